(* The logarithm that is written out: y = m 2^e by the bits of y, and ln y = e ln 2 + ln m. With s = (m - 1)/(m + 1), ln m is 2 atanh s,
   which s (2 + C s^2) approximates. The result is within 1/20480 of ln y, for y from 0.9 to 2^62.

   Controller.v uses `emitted_log_near`. The lemma book has the approximation as `transform.logarithm` (docs/lemmas.md). *)
From Coq Require Import ZArith QArith Qreals Reals Lia Lra Psatz List Bool SpecFloat.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Stt Require Import Rounding Syntax Run Emission Control Semantics Edge Law.
Import ListNotations.
Open Scope R_scope.

(* ------------------------------------------------------------------ real numbers *)

(* A function whose derivative is not negative on [0, b] is at least f 0 at b. *)
Lemma rises_on_interval f df b : 0 <= b -> (forall r, 0 <= r <= b -> is_derive f r (df r) /\ 0 <= df r) -> f 0 <= f b.
Proof.
  intros B D. destruct (MVT_gen f 0 b df) as (c & Hc & E); rewrite Rmin_left, Rmax_right in * by exact B.
  - intros r Hr. apply D; lra.
  - intros r Hr. apply derivable_continuous_pt. exists (df r). apply is_derive_Reals, D, Hr.
  - assert (0 <= df c * (b - 0)) by (apply Rmult_le_pos; [apply D, Hc|lra]). lra.
Qed.

(* 2 atanh s. *)
Definition twice_atanh (s : R) : R := ln (1 + s) - ln (1 - s).

Lemma twice_atanh_ge s : 0 <= s <= 0.172 -> 2 * s + 2 / 3 * s ^ 3 + 2 / 5 * s ^ 5 <= twice_atanh s.
Proof.
  intro S. set (f := fun s => twice_atanh s - (2 * s + 2 / 3 * s ^ 3 + 2 / 5 * s ^ 5)).
  assert (H := rises_on_interval f (fun s => 2 * (s * s * s) * (s * s * s) / (1 - s * s)) s ltac:(lra)).
  unfold f, twice_atanh in H. rewrite Rplus_0_r, Rminus_0_r, ln_1 in H. unfold twice_atanh.
  enough (Q : ln 1 - ln 1 - (2 * 0 + 2 / 3 * 0 ^ 3 + 2 / 5 * 0 ^ 5) <= ln (1 + s) - ln (1 - s) - (2 * s + 2 / 3 * s ^ 3 + 2 / 5 * s ^ 5)) by (rewrite ln_1 in Q; lra).
  rewrite ln_1. apply H. intros r Hr. assert (0 < 1 - r * r) by nra. split.
  - auto_derive; [lra|]. field. split; [lra|]. split; [lra|nra].
  - unfold Rdiv. apply Rmult_le_pos; [|left; now apply Rinv_0_lt_compat]. assert (0 <= r * r * r) by (repeat apply Rmult_le_pos; lra). assert (0 <= (r * r * r) * (r * r * r)) by now apply Rmult_le_pos. lra.
Qed.

Lemma twice_atanh_le s : 0 <= s <= 0.172 -> twice_atanh s <= 2 * s + 2 / 3 * s ^ 3 + 2 / 5 * s ^ 5 + 2 * (1031 / 1000) / 7 * s ^ 7.
Proof.
  intro S. set (f := fun s => 2 * s + 2 / 3 * s ^ 3 + 2 / 5 * s ^ 5 + 2 * (1031 / 1000) / 7 * s ^ 7 - twice_atanh s).
  assert (H := rises_on_interval f (fun s => 2 * (s * s * s) * (s * s * s) * (31 / 1000 - (1031 / 1000) * (s * s)) / (1 - s * s)) s ltac:(lra)).
  unfold f, twice_atanh in H. rewrite Rplus_0_r, Rminus_0_r, ln_1 in H. unfold twice_atanh.
  enough (Q : 2 * 0 + 2 / 3 * 0 ^ 3 + 2 / 5 * 0 ^ 5 + 2 * (1031 / 1000) / 7 * 0 ^ 7 - (0 - 0) <=
    2 * s + 2 / 3 * s ^ 3 + 2 / 5 * s ^ 5 + 2 * (1031 / 1000) / 7 * s ^ 7 - (ln (1 + s) - ln (1 - s))) by lra.
  apply H. intros r Hr. assert (0 <= r * r <= 0.03) by nra. split.
  - auto_derive; [lra|]. field. split; [lra|]. split; [lra|nra].
  - unfold Rdiv. apply Rmult_le_pos; [|left; apply Rinv_0_lt_compat; lra].
    assert (0 <= r * r * r) by (repeat apply Rmult_le_pos; lra). apply Rmult_le_pos; [|lra]. assert (0 <= (r * r * r) * (r * r * r)) by now apply Rmult_le_pos. lra.
Qed.

Lemma twice_atanh_odd s : twice_atanh (- s) = - twice_atanh s.
Proof. unfold twice_atanh. replace (1 + - s) with (1 - s) by ring. replace (1 - - s) with (1 + s) by ring. ring. Qed.

(* s (2 + C s^2) is near 2 atanh s, and both are about 2 s. *)
Lemma cubic_near_twice_atanh C s : 0.676604 <= C <= 0.676605 -> Rabs s <= 0.17158 ->
  Rabs (s * (2 + C * (s * s)) - twice_atanh s) <= 0.000063 * Rabs s /\ 2 * Rabs s <= Rabs (twice_atanh s) <= 2.03 * Rabs s.
Proof.
  intros HC. assert (Pos : forall s, 0 <= s <= 0.17158 -> Rabs (s * (2 + C * (s * s)) - twice_atanh s) <= 0.000063 * s /\ 2 * s <= twice_atanh s <= 2.03 * s).
  { clear s. intros s Hs. assert (Lo := twice_atanh_ge s ltac:(lra)). assert (Hi := twice_atanh_le s ltac:(lra)).
    set (z := s * s) in *. assert (Z : 0 <= z <= 0.02944) by (unfold z; split; nra).
    replace (s ^ 3) with (s * z) in * by (unfold z; ring). replace (s ^ 5) with (s * (z * z)) in * by (unfold z; ring). replace (s ^ 7) with (s * (z * z * z)) in * by (unfold z; ring).
    clearbody z. assert (Z2 : 0 <= z * z <= 0.02944 * z) by (split; [apply Rmult_le_pos|apply Rmult_le_compat_r]; lra).
    assert (Z3 : 0 <= z * z * z <= 0.02944 * z * z) by (split; [apply Rmult_le_pos|apply Rmult_le_compat_r]; lra).
    assert (P1 : (C - 2 / 3) * z - 2 / 5 * (z * z) <= 0.000063).
    { assert (Sq := Rle_0_sqr (z - 0.01242)). unfold Rsqr in Sq. assert (C * z <= 0.676605 * z) by (apply Rmult_le_compat_r; lra). lra. }
    assert (P2 : 2 / 5 * (z * z) + 2 * 1.031 / 7 * (z * z * z) - (C - 2 / 3) * z <= 0.000063).
    { assert (0.676604 * z <= C * z) by (apply Rmult_le_compat_r; lra). lra. }
    assert (Q1 : s * ((C - 2 / 3) * z - 2 / 5 * (z * z)) <= s * 0.000063) by (apply Rmult_le_compat_l; lra).
    assert (Q2 : s * (2 / 5 * (z * z) + 2 * 1.031 / 7 * (z * z * z) - (C - 2 / 3) * z) <= s * 0.000063) by (apply Rmult_le_compat_l; lra).
    assert (Q3 : 0 <= s * z <= s * 0.02944) by (split; [apply Rmult_le_pos; lra|apply Rmult_le_compat_l; lra]).
    assert (Q4 : 0 <= s * (z * z) <= s * 0.00087) by (split; [apply Rmult_le_pos; lra|apply Rmult_le_compat_l; lra]).
    assert (Q5 : 0 <= s * (z * z * z) <= s * 0.00003) by (split; [apply Rmult_le_pos; lra|apply Rmult_le_compat_l; lra]).
    split; [apply Rabs_le|]; lra. }
  intro Hs. destruct (Rle_dec 0 s) as [Q|Q].
  - rewrite (Rabs_pos_eq s) in * by exact Q. destruct (Pos s ltac:(lra)) as [P1 P2]. split; [exact P1|]. rewrite Rabs_pos_eq by lra. exact P2.
  - rewrite (Rabs_left s) in * by lra. destruct (Pos (- s) ltac:(lra)) as [P1 P2]. rewrite twice_atanh_odd in P1, P2. split.
    + replace (- s * (2 + C * (- s * - s)) - - twice_atanh s) with (- (s * (2 + C * (s * s)) - twice_atanh s)) in P1 by ring. rewrite Rabs_Ropp in P1. exact P1.
    + rewrite Rabs_left1 by lra. lra.
Qed.

Lemma twice_atanh_is_ln m : 0 < m -> twice_atanh ((m - 1) / (m + 1)) = ln m.
Proof.
  intro M. unfold twice_atanh. replace (1 + (m - 1) / (m + 1)) with (m * (2 / (m + 1))) by (field; lra). replace (1 - (m - 1) / (m + 1)) with (2 / (m + 1)) by (field; lra).
  rewrite ln_mult; [ring|exact M|]. apply Rdiv_lt_0_compat; lra.
Qed.

Lemma ln_two_near : 0.693146 <= ln 2 <= 0.693148.
Proof.
  (* 2 = (5/4)^3 128/125 *)
  assert (E : ln 2 = 3 * twice_atanh (1 / 9) + twice_atanh (3 / 253)).
  { replace (1 / 9) with ((5 / 4 - 1) / (5 / 4 + 1)) by lra. replace (3 / 253) with ((128 / 125 - 1) / (128 / 125 + 1)) by lra. rewrite !twice_atanh_is_ln by lra.
    replace 2 with (5 / 4 * (5 / 4 * (5 / 4 * (128 / 125)))) at 1 by lra. rewrite !ln_mult by lra. ring. }
  rewrite E. pose proof (twice_atanh_ge (1 / 9) ltac:(lra)). pose proof (twice_atanh_le (1 / 9) ltac:(lra)). pose proof (twice_atanh_ge (3 / 253) ltac:(lra)). pose proof (twice_atanh_le (3 / 253) ltac:(lra)). lra.
Qed.

(* A relative error as a factor 1 + d. *)
Lemma relative_error_as_factor e r x : 0 <= e -> Rabs (r - x) <= e * Rabs x -> exists d, Rabs d <= e /\ r = x * (1 + d).
Proof.
  intros E H. destruct (Req_dec x 0) as [->|X].
  - rewrite Rabs_R0, Rmult_0_r in H. exists 0. rewrite Rabs_R0. split; [exact E|]. assert (r - 0 = 0); [|lra].
    apply Rabs_le_between in H. lra.
  - exists ((r - x) / x). split; [|field; exact X]. unfold Rdiv. rewrite Rabs_mult, Rabs_inv by exact X.
    apply (Rmult_le_reg_r (Rabs x)); [now apply Rabs_pos_lt|]. rewrite Rmult_assoc, Rinv_l, Rmult_1_r by (now apply Rabs_no_R0). exact H.
Qed.

(* ------------------------------------------------------------------ bits *)

(* The bits of a float, and the statements of the logarithm. *)
Section Machine.
  Variables prec emax : Z.
  Context (prec_gt_0_ : Prec_gt_0 prec).
  Context (prec_lt_emax_ : Prec_lt_emax prec emax).
  Hypothesis prec_large : (24 <= prec)%Z.
  Hypothesis prec_small : (prec <= 64)%Z.
  Hypothesis emax_large : (128 <= emax)%Z.
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).
  Notation round_nearest := (round_nearest prec emax).
  Notation P := (exponent_step prec). (* 1 in the field of the exponent *)
  Let u := unit_roundoff prec.

  (* The bit pattern of the smallest m: its exponent's field, and its fraction cut_fraction. *)
  Variable cut_fraction : Z.
  Hypothesis cut_parts : mantissa_cut prec = ((emax - 2) * P + cut_fraction)%Z.
  Hypothesis cut_fraction_range : (7071067 * (2 * P) <= 10000000 * (cut_fraction + P) <= 7071068 * (2 * P))%Z.

  Lemma exponent_step_large : (8 <= P)%Z. Proof. unfold exponent_step. change 8%Z with (2 ^ 3)%Z. apply Z.pow_le_mono_r; lia. Qed.
  Lemma exponent_step_power : IZR (2 * P) = bpow radix2 prec.
  Proof. unfold exponent_step. rewrite <- IZR_Zpower by lia. f_equal. change (radix_val radix2) with 2%Z. replace prec with (1 + (prec - 1))%Z at 2 by ring. rewrite Z.pow_add_r by lia. reflexivity. Qed.

  Lemma of_bits_value j f : (1 <= j < 2 * emax - 1)%Z -> (0 <= f < P)%Z ->
    value (of_bits prec emax _ _ (j * P + f)) = IZR (f + P) * bpow radix2 (j + 2 - emax - prec) /\ is_finite (of_bits prec emax _ _ (j * P + f)) = true.
  Proof.
    intros J F. pose proof exponent_step_large as P0. unfold of_bits. cbv zeta.
    assert (W : (bit_pattern_count prec emax / 2 = 2 * emax * P)%Z) by (unfold bit_pattern_count; replace (4 * emax * P)%Z with (2 * emax * P * 2)%Z by ring; apply Z.div_mul; lia). rewrite W.
    replace (2 * emax * P <=? j * P + f)%Z with false by (symmetry; apply Z.leb_gt; nia).
    rewrite (Z.mod_small (j * P + f) (2 * emax * P)) by nia.
    rewrite Z.div_add_l, (Z.div_small f) by lia. rewrite Z.add_0_r.
    replace ((j * P + f) mod P)%Z with f by (rewrite Z.add_comm, Z.mod_add, Z.mod_small by lia; reflexivity).
    replace (j =? 2 * emax - 1)%Z with false by (symmetry; apply Z.eqb_neq; lia). replace (j =? 0)%Z with false by (symmetry; apply Z.eqb_neq; lia).
    cbn [cond_Zopp]. assert (C := binary_normalize_correct prec emax _ _ mode_NE (f + P) (j - 1 + minimum_exponent prec emax) false). cbv zeta in C. cbn [round_mode] in C.
    set (e := (j - 1 + minimum_exponent prec emax)%Z) in *. assert (Ee : e = (j + 2 - emax - prec)%Z) by (unfold e, minimum_exponent; ring).
    assert (Lp := prec_lt_emax_). unfold Prec_lt_emax in Lp.
    assert (Si : IZR (f + P) < bpow radix2 prec) by (rewrite <- exponent_step_power; apply IZR_lt; lia).
    assert (G : generic_format radix2 (FLT_exp (3 - emax - prec) prec) (F2R (Float radix2 (f + P) e))).
    { apply generic_format_FLT. exists (Float radix2 (f + P) e); cbn [Fnum Fexp]; [reflexivity| |lia].
      apply lt_IZR. change (radix_val radix2) with 2%Z. rewrite abs_IZR, (IZR_Zpower radix2) by lia. rewrite Rabs_pos_eq by (apply IZR_le; lia). exact Si. }
    change (F2R (Float radix2 (f + P) e)) with (IZR (f + P) * bpow radix2 e) in *. rewrite Ee in *.
    match type of C with context [round radix2 ?g ?r ?x] => change (round radix2 g r x) with (round_nearest x) in C end.
    rewrite (round_nearest_of_format prec emax _ G) in C. rewrite Rlt_bool_true in C; [tauto|].
    rewrite Rabs_pos_eq by (apply Rmult_le_pos; [apply IZR_le; lia|apply bpow_ge_0]).
    apply Rlt_le_trans with (bpow radix2 prec * bpow radix2 (j + 2 - emax - prec)); [apply Rmult_lt_compat_r; [apply bpow_gt_0|exact Si]|].
    rewrite <- bpow_plus. apply bpow_le. lia.
  Qed.

  (* The bits split y into m and e: y = m 2^e, with m from about 1/sqrt 2 to about sqrt 2. *)
  Lemma bits_split_number (y : number) : is_finite y = true -> 0.9 <= value y <= bpow radix2 62 ->
    let e := exponent_by_bits prec emax y in let m := mantissa_by_bits prec emax _ _ y in
    is_finite m = true /\ value y = value m * bpow radix2 e /\ (0 <= e <= 63)%Z /\ 0.7071067 <= value m <= 1.4142136 /\ exists q, value m = IZR q * bpow radix2 (- prec).
  Proof.
    intros Fy Ry. pose proof exponent_step_large as P0. pose proof exponent_step_power as Pb. assert (Lp := prec_lt_emax_). unfold Prec_lt_emax in Lp.
    destruct y as [s|s| |s M E H]; try discriminate; [cbn in Ry; lra|].
    destruct s; [exfalso; cbn [B2R] in Ry; assert (Q := F2R_lt_0 radix2 (Float radix2 (Zneg M) E) ltac:(reflexivity)); cbn [cond_Zopp] in Ry; change (Z.opp (Zpos M)) with (Zneg M) in Ry; lra|].
    assert (V : value (B754_finite false M E H) = IZR (Zpos M) * bpow radix2 E) by reflexivity. rewrite V in Ry.
    (* the significand has all its digits *)
    assert (B := H). unfold SpecFloat.bounded in B. rewrite andb_true_iff in B. destruct B as [B1 B2]. unfold SpecFloat.canonical_mantissa in B1.
    apply Zeq_bool_eq in B1. apply Zle_bool_imp_le in B2. rewrite Digits.Zpos_digits2_pos in B1. unfold SpecFloat.fexp, SpecFloat.emin in B1.
    assert (D := Zdigits_correct radix2 (Zpos M)). set (d := Zdigits radix2 (Zpos M)) in *. rewrite Z.abs_eq in D by lia. change (radix_val radix2) with 2%Z in D.
    assert (Hd : (d <= prec)%Z) by lia.
    assert (M1 : (Zpos M < 2 * P)%Z).
    { apply Z.lt_le_trans with (1 := proj2 D). unfold exponent_step. rewrite <- (Z.pow_succ_r 2) by lia. apply Z.pow_le_mono_r; lia. }
    assert (E1 : (- prec <= E)%Z).
    { apply Znot_gt_le. intro C. assert (IZR (Zpos M) * bpow radix2 E <= bpow radix2 prec * bpow radix2 (- prec - 1)).
      { apply Rmult_le_compat; [apply IZR_le; lia|apply bpow_ge_0|rewrite <- Pb; apply IZR_le; lia|apply bpow_le; lia]. }
      rewrite <- bpow_plus in H0. replace (prec + (- prec - 1))%Z with (-1)%Z in H0 by ring. change (bpow radix2 (-1)) with (/ 2) in H0. lra. }
    assert (M0 : (P <= Zpos M)%Z).
    { apply Z.le_trans with (2 := proj1 D). unfold exponent_step. apply Z.pow_le_mono_r; lia. }
    assert (E2 : (E + prec <= 63)%Z).
    { apply Znot_gt_le. intro C. assert (bpow radix2 (prec - 1) * bpow radix2 (64 - prec) <= IZR (Zpos M) * bpow radix2 E).
      { apply Rmult_le_compat; try apply bpow_ge_0; [|apply bpow_le; lia]. rewrite <- (IZR_Zpower radix2) by lia. apply IZR_le, M0. }
      rewrite <- bpow_plus in H0. replace (prec - 1 + (64 - prec))%Z with 63%Z in H0 by ring. assert (bpow radix2 62 < bpow radix2 63) by (apply bpow_lt; lia). lra. }
    (* the bits of y, less those of the smallest m *)
    assert (Bits : (bits prec emax (B754_finite false M E H) - mantissa_cut prec = (E + prec) * P + (Zpos M - P - cut_fraction))%Z).
    { unfold bits. replace (Zpos M <? P)%Z with false by (symmetry; apply Z.ltb_ge; exact M0). rewrite cut_parts. unfold minimum_exponent. ring. }
    assert (Low : (0 <= cut_fraction < P)%Z) by lia.
    assert (First : (E + prec = 0 -> 0 <= Zpos M - P - cut_fraction)%Z).
    { intro Q. assert (Eq : E = (- prec)%Z) by lia. rewrite Eq in Ry. assert (0.9 * bpow radix2 prec <= IZR (Zpos M)).
      { apply (Rmult_le_reg_r (bpow radix2 (- prec))); [apply bpow_gt_0|]. rewrite Rmult_assoc, <- bpow_plus, Z.add_opp_diag_r. change (bpow radix2 0) with 1. lra. }
      rewrite <- Pb in H0. assert (9 * (2 * P) <= 10 * Zpos M)%Z; [|lia]. apply le_IZR. rewrite !mult_IZR in *. lra. }
    set (D0 := ((E + prec) * P + (Zpos M - P - cut_fraction))%Z) in *.
    assert (W : (bit_pattern_count prec emax = 4 * (emax * P))%Z) by (unfold bit_pattern_count; fold P; ring).
    assert (W2 : (128 * P <= emax * P)%Z) by (apply Z.mul_le_mono_nonneg_r; lia).
    assert (Small : (0 <= D0 < bit_pattern_count prec emax)%Z).
    { assert (Up : ((E + prec) * P <= 63 * P)%Z) by (apply Z.mul_le_mono_nonneg_r; lia).
      assert (Below : (0 <= D0)%Z).
      { unfold D0. destruct (Z.eq_dec (E + prec) 0) as [Q|Q]; [rewrite Q, Z.mul_0_l; apply First, Q|].
        assert ((1 * P <= (E + prec) * P)%Z) by (apply Z.mul_le_mono_nonneg_r; lia). lia. }
      split; [exact Below|]. rewrite W. unfold D0. lia. }
    unfold exponent_by_bits, mantissa_by_bits. cbv zeta. rewrite Bits, (Z.mod_small D0) by exact Small.
    rewrite Z.shiftr_div_pow2, Z.land_ones by lia. fold P.
    assert (Two : bpow radix2 1 = 2) by reflexivity. assert (Pp : 0 < bpow radix2 (- prec)) by apply bpow_gt_0.
    assert (Unit : bpow radix2 prec * bpow radix2 (- prec) = 1) by (rewrite <- bpow_plus, Z.add_opp_diag_r; reflexivity).
    assert (Rl : 0.7071067 * bpow radix2 prec <= IZR (cut_fraction + P) <= 0.7071068 * bpow radix2 prec).
    { destruct cut_fraction_range as [R1 R2]. apply IZR_le in R1, R2. rewrite <- Pb. rewrite !(mult_IZR _ (2 * P)), !(mult_IZR _ (cut_fraction + P)) in *. lra. }
    destruct (Z_le_gt_dec 0 (Zpos M - P - cut_fraction)) as [Q|Q].
    - assert (Dv : (D0 / P = E + prec)%Z) by (unfold D0; rewrite Z.div_add_l, Z.div_small by lia; ring).
      assert (Md : (D0 mod P = Zpos M - P - cut_fraction)%Z) by (unfold D0; rewrite Z.add_comm, Z.mod_add, Z.mod_small by lia; reflexivity).
      rewrite Dv, Md, cut_parts. replace (Zpos M - P - cut_fraction + ((emax - 2) * P + cut_fraction))%Z with ((emax - 2) * P + (Zpos M - P))%Z by ring.
      rewrite (Z.mod_small ((emax - 2) * P + (Zpos M - P))) by (rewrite W, Z.mul_sub_distr_r; lia).
      destruct (of_bits_value (emax - 2) (Zpos M - P) ltac:(lia) ltac:(lia)) as [O1 O2]. rewrite V, O1.
      replace (Zpos M - P + P)%Z with (Zpos M) by ring. replace (emax - 2 + 2 - emax - prec)%Z with (- prec)%Z by ring.
      split; [exact O2|]. split; [rewrite Rmult_assoc, <- bpow_plus; f_equal; f_equal; ring|]. split; [lia|]. split; [|exists (Zpos M); reflexivity].
      assert (L1 : IZR (cut_fraction + P) <= IZR (Zpos M)) by (apply IZR_le; lia). assert (L2 : IZR (Zpos M) <= bpow radix2 prec) by (rewrite <- Pb; apply IZR_le; lia).
      split; apply (Rmult_le_reg_r (bpow radix2 prec)); try apply bpow_gt_0; rewrite Rmult_assoc, (Rmult_comm (bpow radix2 (- prec))), Unit; lra.
    - assert (Dv : (D0 / P = E + prec - 1)%Z).
      { unfold D0. replace ((E + prec) * P + (Zpos M - P - cut_fraction))%Z with ((E + prec - 1) * P + (Zpos M - cut_fraction))%Z by ring. rewrite Z.div_add_l, Z.div_small by lia. ring. }
      assert (Md : (D0 mod P = Zpos M - cut_fraction)%Z).
      { unfold D0. replace ((E + prec) * P + (Zpos M - P - cut_fraction))%Z with ((Zpos M - cut_fraction) + (E + prec - 1) * P)%Z by ring. rewrite Z.mod_add, Z.mod_small by lia. reflexivity. }
      rewrite Dv, Md, cut_parts. replace (Zpos M - cut_fraction + ((emax - 2) * P + cut_fraction))%Z with ((emax - 1) * P + (Zpos M - P))%Z by ring.
      rewrite (Z.mod_small ((emax - 1) * P + (Zpos M - P))) by (rewrite W, Z.mul_sub_distr_r; lia).
      destruct (of_bits_value (emax - 1) (Zpos M - P) ltac:(lia) ltac:(lia)) as [O1 O2]. rewrite V, O1.
      replace (Zpos M - P + P)%Z with (Zpos M) by ring. replace (emax - 1 + 2 - emax - prec)%Z with (1 + - prec)%Z by ring.
      split; [exact O2|]. split; [rewrite Rmult_assoc, <- bpow_plus; f_equal; f_equal; ring|]. split; [lia|]. rewrite bpow_plus, Two. split; [|exists (2 * Zpos M)%Z; rewrite mult_IZR; ring].
      assert (L1 : IZR (Zpos M) <= IZR (cut_fraction + P)) by (apply IZR_le; lia). assert (L2 : bpow radix2 prec <= 2 * IZR (Zpos M)) by (rewrite <- Pb, <- (mult_IZR 2); apply IZR_le; lia).
      split; apply (Rmult_le_reg_r (bpow radix2 prec)); try apply bpow_gt_0; replace (IZR (Zpos M) * (2 * bpow radix2 (- prec)) * bpow radix2 prec) with (2 * IZR (Zpos M) * (bpow radix2 prec * bpow radix2 (- prec))) by ring; rewrite Unit; lra.
  Qed.

  (* ---------------------------------------------------------------- the statements *)

  Variable log_ : number -> number.
  Let A := machine prec emax _ _ log_.
  Notation literal_number d := (decimal_number prec emax prec_gt_0_ prec_lt_emax_ d).
  Variable consts : constants.
  Hypothesis log_coefficient_range : 0.676604 <= value (literal_number (log_coefficient consts)) <= 0.676605 /\ is_finite (literal_number (log_coefficient consts)) = true.
  Hypothesis ln_two_range : 0.693146 <= value (literal_number (ln_two consts)) <= 0.693148 /\ is_finite (literal_number (ln_two consts)) = true.

  Lemma unit_roundoff_small : 0 < u <= 0.00000006.
  Proof. pose proof (unit_roundoff_range prec prec_large) as H. change (IZR (2 ^ 24)) with 16777216 in H. fold u in H. lra. Qed.
  Lemma underflow_error_small : 0 <= underflow_error <= 0.000000001.
  Proof.
    unfold underflow_error. split; [apply bpow_ge_0|]. apply Rle_trans with (bpow radix2 (-30)); [apply bpow_le; lia|]. change (bpow radix2 (-30)) with (/ 1073741824). lra.
  Qed.
  Lemma ordinary_below_maximum v : Rabs v <= 1000 -> Rabs v <= safe_maximum emax.
  Proof. intro H. apply Rle_trans with (1 := H). unfold safe_maximum. apply Rle_trans with (bpow radix2 10); [change (bpow radix2 10) with 1024; lra|apply bpow_le; lia]. Qed.
  (* A rounding is a factor where the exact value is 0 or not very small. *)
  Lemma rounding_as_factor x : x = 0 \/ bpow radix2 (-126) <= Rabs x -> exists d, Rabs d <= u /\ round_nearest x = x * (1 + d).
  Proof.
    pose proof unit_roundoff_small. intro H0. apply relative_error_as_factor; [lra|]. destruct H0 as [->|Q].
    - rewrite round_nearest_0, Rminus_0_r, Rabs_R0. lra.
    - apply round_nearest_relative_error; [exact prec_gt_0_|exact emax_large|exact Q].
  Qed.

  (* ln m by the statements, for m from the bits. *)
  Lemma mantissa_log_near (m : number) : is_finite m = true -> 0.7071067 <= value m <= 1.4142136 -> (exists q, value m = IZR q * bpow radix2 (- prec)) ->
    let s := Bdiv mode_NE (Bminus mode_NE m (literal_number literal_one)) (Bplus mode_NE m (literal_number literal_one)) in
    let part := Bmult mode_NE s (Bplus mode_NE (Bmult mode_NE (Bmult mode_NE s s) (literal_number (log_coefficient consts))) (literal_number literal_two)) in
    is_finite part = true /\ Rabs (value part - ln (value m)) <= 0.000033 * Rabs (ln (value m)) /\ Rabs (ln (value m)) <= 0.3484.
  Proof.
    intros Fm Rm [q Hq]. cbv zeta. set (y := value m) in *. pose proof unit_roundoff_small as Ur. pose proof underflow_error_small as Ti.
    destruct (integer_literal_exact prec emax _ _ prec_large emax_large literal_one 1 ltac:(lia) ltac:(reflexivity)) as [O1 O2].
    destruct (integer_literal_exact prec emax _ _ prec_large emax_large literal_two 2 ltac:(lia) ltac:(reflexivity)) as [T1 T2].
    destruct log_coefficient_range as [C1 C2]. set (C := value (literal_number (log_coefficient consts))) in *.
    assert (G1 : generic_format radix2 (FLT_exp (3 - emax - prec) prec) 1) by (rewrite <- O1; apply number_format).
    (* the values of `below` and `above` *)
    destruct (sub_rounds prec emax _ _ prec_large emax_large m (literal_number literal_one) Fm O2) as [B1 B2]; [apply ordinary_below_maximum; rewrite O1; fold y; apply Rabs_le; lra|].
    destruct (add_rounds prec emax _ _ prec_large emax_large m (literal_number literal_one) Fm O2) as [A1 A2]; [apply ordinary_below_maximum; rewrite O1; fold y; apply Rabs_le; lra|].
    rewrite O1 in B1, A1. fold y in B1, A1.
    destruct (relative_error_as_factor u (round_nearest (y - 1)) (y - 1) ltac:(lra)) as (d1 & D1 & E1); [apply difference_relative_error; try assumption; apply number_format|].
    destruct (relative_error_as_factor u (round_nearest (y + 1)) (y + 1) ltac:(lra)) as (d2 & D2 & E2); [apply sum_relative_error; try assumption; apply number_format|].
    set (below := Bminus mode_NE m (literal_number literal_one)) in *. set (above := Bplus mode_NE m (literal_number literal_one)) in *. rewrite E1 in B1. rewrite E2 in A1.
    apply Rabs_le_between in D1, D2.
    assert (A0 : 1.7071065 <= value above) by (rewrite A1; apply Rle_trans with (1.7071067 * (1 - 0.00000006)); [lra|apply Rmult_le_compat; lra]).
    (* the value of `s` *)
    set (s := (y - 1) / (y + 1)).
    assert (Sr : Rabs s <= 0.17158).
    { unfold s. apply Rabs_le. split; [apply Rcomplements.Rle_div_r|apply Rcomplements.Rle_div_l]; lra. }
    assert (Q0 : value below / value above = s * ((1 + d1) / (1 + d2))) by (rewrite B1, A1; unfold s; field; lra).
    assert (F12 : exists d, Rabs d <= 0.0000001201 /\ (1 + d1) / (1 + d2) = 1 + d).
    { exists ((1 + d1) / (1 + d2) - 1). split; [|ring]. replace ((1 + d1) / (1 + d2) - 1) with ((d1 - d2) / (1 + d2)) by (field; lra).
      apply Rabs_le. split; [apply Rcomplements.Rle_div_r|apply Rcomplements.Rle_div_l]; lra. }
    destruct F12 as (d12 & D12 & E12). rewrite E12 in Q0. apply Rabs_le_between in D12.
    assert (Small : s = 0 \/ bpow radix2 (-100) <= Rabs s).
    { destruct (Req_dec y 1) as [Y1|Y1]; [left; unfold s; rewrite Y1; lra|right].
      assert (Z : bpow radix2 (- prec) <= Rabs (y - 1)).
      { assert (One_is_power : 1 = IZR (2 ^ prec) * bpow radix2 (- prec)).
        { change 2%Z with (radix_val radix2). rewrite (IZR_Zpower radix2) by lia. rewrite <- bpow_plus, Z.add_opp_diag_r. reflexivity. }
        assert (Ey : y - 1 = IZR (q - 2 ^ prec) * bpow radix2 (- prec)) by (rewrite minus_IZR, Hq; rewrite One_is_power at 1; ring).
        rewrite Ey, Rabs_mult, (Rabs_pos_eq (bpow _ _)) by apply bpow_ge_0. rewrite <- (Rmult_1_l (bpow radix2 (- prec))) at 1. apply Rmult_le_compat_r; [apply bpow_ge_0|].
        rewrite <- abs_IZR. apply IZR_le. assert (q - 2 ^ prec <> 0)%Z; [|lia]. intro C0. apply Y1. rewrite C0 in Ey. lra. }
      unfold s, Rdiv. rewrite Rabs_mult, (Rabs_pos_eq (/ (y + 1))) by (left; apply Rinv_0_lt_compat; lra).
      apply Rle_trans with (bpow radix2 (- prec) * bpow radix2 (-2)); [rewrite <- bpow_plus; apply bpow_le; lia|].
      apply Rmult_le_compat; try apply bpow_ge_0; [exact Z|]. change (bpow radix2 (-2)) with (/ 4). apply Rinv_le_contravar; lra. }
    assert (Half : forall x, s = 0 \/ bpow radix2 (-100) <= Rabs s -> 0.5 <= Rabs x -> s * x = 0 \/ bpow radix2 (-126) <= Rabs (s * x)).
    { intros x [S0|S0] X; [left; rewrite S0; ring|right]. rewrite Rabs_mult. apply Rle_trans with (bpow radix2 (-100) * 0.5).
      - replace 0.5 with (bpow radix2 (-1)) by (change (bpow radix2 (-1)) with (/ 2); lra). rewrite <- bpow_plus. apply bpow_le. lia.
      - apply Rmult_le_compat; try lra. apply bpow_ge_0. }
    destruct (rounding_as_factor (s * (1 + d12))) as (d3 & D3 & E3); [apply Half; [exact Small|rewrite Rabs_pos_eq; lra]|]. apply Rabs_le_between in D3.
    assert (Ss : exists d, Rabs d <= 0.00000019 /\ round_nearest (s * (1 + d12)) = s * (1 + d)).
    { exists (d12 + d3 + d12 * d3). split; [|rewrite E3; ring]. assert (Rabs (d12 * d3) <= 0.0000001201 * 0.00000006) by (rewrite Rabs_mult; apply Rmult_le_compat; try apply Rabs_pos; apply Rabs_le; lra).
      apply Rabs_le_between in H. apply Rabs_le. lra. }
    destruct Ss as (d & D & Es). apply Rabs_le_between in D.
    assert (Sw : Rabs (s * (1 + d)) <= 0.17159).
    { rewrite Rabs_mult, (Rabs_pos_eq (1 + d)) by lra. apply Rle_trans with (0.17158 * (1 + 0.00000019)); [apply Rmult_le_compat; try apply Rabs_pos; lra|lra]. }
    destruct (div_rounds prec emax _ _ prec_large emax_large below above B2) as [S1 S2]; [lra| |].
    { rewrite Q0. apply ordinary_below_maximum. rewrite Rabs_mult, (Rabs_pos_eq (1 + d12)) by lra. apply Rle_trans with (0.17158 * 2); [apply Rmult_le_compat; try apply Rabs_pos; lra|lra]. }
    rewrite Q0, Es in S1. set (s_ := Bdiv mode_NE below above) in *.
    (* z = s s *)
    set (z := s * s). assert (Zr : 0 <= z <= 0.02944).
    { unfold z. apply Rabs_le_between in Sr. split; [apply Rle_0_sqr|]. replace (s * s) with (Rabs s * Rabs s) by (rewrite <- Rabs_mult; apply Rabs_pos_eq, Rle_0_sqr).
      apply Rle_trans with (0.17158 * 0.17158); [apply Rmult_le_compat; try apply Rabs_pos; apply Rabs_le; lra|lra]. }
    assert (Zw : Rabs (s * (1 + d) * (s * (1 + d)) - z) <= 0.00000002).
    { replace (s * (1 + d) * (s * (1 + d)) - z) with (z * (2 * d + d * d)) by (unfold z; ring). rewrite Rabs_mult, (Rabs_pos_eq z) by lra.
      assert (Rabs (d * d) <= 0.00000019 * 1) by (rewrite Rabs_mult; apply Rmult_le_compat; try apply Rabs_pos; apply Rabs_le; lra). apply Rabs_le_between in H.
      apply Rle_trans with (0.02944 * 0.00000057); [apply Rmult_le_compat; try apply Rabs_pos; [lra|lra|apply Rabs_le; lra]|lra]. }
    destruct (mul_rounds prec emax _ _ prec_large emax_large s_ s_ S2 S2) as [Z1 Z2]; [apply ordinary_below_maximum; rewrite S1; apply Rabs_le_between in Zw; apply Rabs_le; lra|].
    rewrite S1 in Z1. assert (Ze := round_nearest_error prec emax prec_gt_0_ prec_large emax_large (s * (1 + d) * (s * (1 + d)))). fold u in Ze. rewrite <- Z1 in Ze.
    set (z_ := Bmult mode_NE s_ s_) in *. set (w := s * (1 + d) * (s * (1 + d))) in *. clearbody w.
    assert (Zn : Rabs (value z_ - z) <= 0.00000003).
    { apply Rabs_le_between in Zw. assert (Rabs w <= 0.03) by (apply Rabs_le; lra). assert (Rabs w * u <= 0.03 * 0.00000006) by (apply Rmult_le_compat; try apply Rabs_pos; lra).
      apply Rabs_le_between in Ze. apply Rabs_le. lra. }
    apply Rabs_le_between in Zn.
    (* C z *)
    assert (Br : -0.01 <= value z_ * C <= 0.03).
    { split; [|apply Rle_trans with (0.03 * C); [apply Rmult_le_compat_r; lra|lra]]. apply Rle_trans with (-0.00000003 * C); [lra|apply Rmult_le_compat_r; lra]. }
    destruct (mul_rounds prec emax _ _ prec_large emax_large z_ (literal_number (log_coefficient consts)) Z2 C2) as [N1 N2]; [apply ordinary_below_maximum; fold C; apply Rabs_le; lra|]. fold C in N1.
    assert (Ne := round_nearest_error prec emax prec_gt_0_ prec_large emax_large (value z_ * C)). fold u in Ne. rewrite <- N1 in Ne.
    set (bent := Bmult mode_NE z_ (literal_number (log_coefficient consts))) in *.
    assert (Nn : Rabs (value bent - C * z) <= 0.00000003).
    { assert (Rabs (value z_ * C) <= 0.03) by (apply Rabs_le; lra). assert (Rabs (value z_ * C) * u <= 0.03 * 0.00000006) by (apply Rmult_le_compat; try apply Rabs_pos; lra).
      replace (value bent - C * z) with ((value bent - value z_ * C) + C * (value z_ - z)) by ring. eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_mult, (Rabs_pos_eq C) by lra.
      assert (C * Rabs (value z_ - z) <= 0.676605 * 0.00000003) by (apply Rmult_le_compat; try apply Rabs_pos; [lra|lra|apply Rabs_le; lra]). lra. }
    apply Rabs_le_between in Nn. assert (Cz : 0 <= C * z <= 0.02) by (split; [apply Rmult_le_pos; lra|apply Rle_trans with (0.676605 * 0.02944); [apply Rmult_le_compat; lra|lra]]).
    (* 2 + C z *)
    destruct (add_rounds prec emax _ _ prec_large emax_large bent (literal_number literal_two) N2 T2) as [R1 R2]; [apply ordinary_below_maximum; rewrite T1; apply Rabs_le; lra|]. rewrite T1 in R1.
    assert (Re : Rabs (value (Bplus mode_NE bent (literal_number literal_two)) - (value bent + 2)) <= 0.00000013).
    { rewrite R1. eapply Rle_trans; [apply sum_relative_error; try assumption; [apply number_format|rewrite <- T1; apply number_format]|]. fold u.
      rewrite Rabs_pos_eq by lra. apply Rle_trans with (0.00000006 * 2.03); [apply Rmult_le_compat; lra|lra]. }
    set (around := Bplus mode_NE bent (literal_number literal_two)) in *. apply Rabs_le_between in Re.
    assert (An : Rabs (value around - (2 + C * z)) <= 0.0000002) by (apply Rabs_le; lra). assert (Av : 1.9 <= value around <= 2.03) by lra.
    (* the value of `part` *)
    assert (Ep : value s_ * value around = s * ((1 + d) * value around)) by (rewrite S1; ring).
    destruct (rounding_as_factor (value s_ * value around)) as (d5 & D5 & E5).
    { rewrite Ep. apply Half; [exact Small|]. rewrite Rabs_mult, (Rabs_pos_eq (1 + d)), (Rabs_pos_eq (value around)) by lra. apply Rle_trans with (0.5 * 1); [lra|apply Rmult_le_compat; lra]. }
    apply Rabs_le_between in D5.
    destruct (mul_rounds prec emax _ _ prec_large emax_large s_ around S2 R2) as [P1 P2].
    { apply ordinary_below_maximum. rewrite S1, Rabs_mult, (Rabs_pos_eq (value around)) by lra. apply Rle_trans with (0.17159 * 2.03); [apply Rmult_le_compat; try apply Rabs_pos; lra|lra]. }
    rewrite E5, Ep in P1. set (part := Bmult mode_NE s_ around) in *. split; [exact P2|].
    assert (L := twice_atanh_is_ln y ltac:(lra)). fold s in L. destruct (cubic_near_twice_atanh C s C1 Sr) as [L1 L2]. rewrite L in L1, L2. fold z in L1.
    assert (Pn : Rabs (value part - s * (2 + C * z)) <= 0.000001 * Rabs s).
    { rewrite P1. replace (s * ((1 + d) * value around) * (1 + d5) - s * (2 + C * z)) with (((value around - (2 + C * z)) + value around * (d + d5 + d * d5)) * s) by ring.
      rewrite Rabs_mult. apply Rmult_le_compat_r; [apply Rabs_pos|]. eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_mult, (Rabs_pos_eq (value around)) by lra.
      assert (Rabs (d * d5) <= 0.00000019 * 0.01) by (rewrite Rabs_mult; apply Rmult_le_compat; try apply Rabs_pos; apply Rabs_le; lra). apply Rabs_le_between in H.
      assert (value around * Rabs (d + d5 + d * d5) <= 2.03 * 0.00000026) by (apply Rmult_le_compat; try apply Rabs_pos; [lra|lra|apply Rabs_le; lra]). lra. }
    split; [|lra].
    replace (value part - ln y) with ((value part - s * (2 + C * z)) + (s * (2 + C * z) - ln y)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra.
  Qed.

  (* The statements give ln y, up to 1/20480 of it. *)
  Theorem inline_log_near (y : number) : is_finite y = true -> 0.9 <= value y <= bpow radix2 62 ->
    is_finite (inline_log A consts y : number) = true /\ Rabs (value (inline_log A consts y) - ln (value y)) <= / 20480 * Rabs (ln (value y)).
  Proof.
    intros Fy Ry. destruct (bits_split_number y Fy Ry) as (Fm & Ey & Er & Rm & Qm). destruct (mantissa_log_near _ Fm Rm Qm) as (Fp & Ep & Lm).
    set (e := exponent_by_bits prec emax y) in *. set (m := mantissa_by_bits prec emax prec_gt_0_ prec_lt_emax_ y) in *.
    unfold inline_log. cbv zeta. change (mantissa_of A y) with m. change (exponent_of A y) with e.
    change (literal A) with (decimal_number prec emax prec_gt_0_ prec_lt_emax_). change (mul A) with (@Bmult prec emax _ _ mode_NE). change (add A) with (@Bplus prec emax _ _ mode_NE).
    change (sub A) with (@Bminus prec emax _ _ mode_NE). change (div A) with (@Bdiv prec emax _ _ mode_NE). change (of_integer A e) with (of_int prec emax _ _ e).
    match goal with |- context [Bplus mode_NE (Bmult mode_NE (of_int prec emax _ _ e) _) ?p] => set (part := p) in * end.
    pose proof unit_roundoff_small as Ur. destruct ln_two_range as [T1 T2]. set (c := value (literal_number (ln_two consts))) in *. pose proof ln_two_near as L2.
    destruct (of_int_exact prec emax _ _ prec_large emax_large e ltac:(lia)) as [I1 I2].
    assert (Ee : 0 <= IZR e <= 63) by (split; apply IZR_le; lia).
    assert (Cr : 0 <= IZR e * c <= 50) by (split; [apply Rmult_le_pos; lra|apply Rle_trans with (63 * 0.693148); [apply Rmult_le_compat; lra|lra]]).
    destruct (mul_rounds prec emax _ _ prec_large emax_large (of_int prec emax _ _ e) (literal_number (ln_two consts)) I2 T2) as [W1 W2]; [apply ordinary_below_maximum; rewrite I1; fold c; rewrite Rabs_pos_eq; lra|].
    rewrite I1 in W1. fold c in W1. set (exponent_part := Bmult mode_NE (of_int prec emax _ _ e) (literal_number (ln_two consts))) in *.
    assert (Zero : e = 0%Z \/ 1 <= IZR e) by (destruct (Z.eq_dec e 0); [now left|right; apply IZR_le; lia]).
    destruct (rounding_as_factor (IZR e * c)) as (d6 & D6 & E6).
    { destruct Zero as [->|G]; [left; ring|right]. rewrite Rabs_pos_eq by lra. apply Rle_trans with 0.5.
      - replace 0.5 with (bpow radix2 (-1)) by (change (bpow radix2 (-1)) with (/ 2); lra). apply bpow_le. lia.
      - apply Rle_trans with (1 * c); [lra|apply Rmult_le_compat_r; lra]. }
    rewrite E6 in W1. apply Rabs_le_between in D6.
    assert (Pm : Rabs (value part) <= 0.35).
    { replace (value part) with ((value part - ln (value m)) + ln (value m)) by ring. eapply Rle_trans; [apply Rabs_triang|]. lra. }
    assert (Pw : Rabs (IZR e * c * d6) <= IZR e * 0.00000005).
    { rewrite !Rabs_mult, (Rabs_pos_eq (IZR e)), (Rabs_pos_eq c) by lra. rewrite Rmult_assoc. apply Rmult_le_compat_l; [lra|]. apply Rle_trans with (0.693148 * 0.00000006); [|lra].
      apply Rmult_le_compat; try apply Rabs_pos; [lra|lra|apply Rabs_le; lra]. }
    assert (Wv : value exponent_part = IZR e * c + IZR e * c * d6) by (rewrite W1; ring).
    destruct (add_rounds prec emax _ _ prec_large emax_large exponent_part part W2 Fp) as [V1 V2].
    { apply ordinary_below_maximum. rewrite Wv. apply Rabs_le_between in Pm, Pw. apply Rabs_le. lra. }
    split; [exact V2|]. rewrite V1, Ey. clear V1.
    assert (m0 : 0 < value m) by lra. rewrite ln_mult by (try exact m0; apply bpow_gt_0).
    assert (Lb : ln (bpow radix2 e) = IZR e * ln 2) by (rewrite bpow_exp, ln_exp; reflexivity). rewrite Lb.
    destruct Zero as [Z0|G].
    - assert (E0 : IZR e = 0) by (rewrite Z0; reflexivity). rewrite Wv, E0, !Rmult_0_l, !Rplus_0_l, Rplus_0_r. rewrite round_nearest_of_format by apply number_format.
      pose proof (Rabs_pos (ln (value m))). lra.
    - assert (Rd := sum_relative_error prec emax prec_gt_0_ prec_large (value exponent_part) (value part) (number_format _ _ _) (number_format _ _ _)). fold u in Rd.
      set (r := round_nearest (value exponent_part + value part)) in *. set (l := ln (value m)) in *. clearbody r l.
      apply Rabs_le_between in Pm, Pw, Lm. assert (Ep2 : Rabs (value part - l) <= 0.000012) by (eapply Rle_trans; [exact Ep|]; assert (Rabs l <= 0.3484) by (apply Rabs_le; lra); lra).
      apply Rabs_le_between in Ep2.
      assert (C1 : -0.000002 * IZR e <= IZR e * c - IZR e * ln 2 <= 0.000002 * IZR e).
      { replace (IZR e * c - IZR e * ln 2) with ((c - ln 2) * IZR e) by ring. split; apply Rmult_le_compat_r; lra. }
      assert (C2 : 0.693146 * IZR e <= IZR e * ln 2) by (rewrite (Rmult_comm (IZR e)); apply Rmult_le_compat_r; lra).
      assert (C3 : IZR e * c <= IZR e * 0.693148) by (apply Rmult_le_compat_l; lra).
      assert (S0 : 0 <= value exponent_part + value part <= IZR e * 1.1) by lra.
      rewrite (Rabs_pos_eq _ (proj1 S0)) in Rd. assert (Ru : u * (value exponent_part + value part) <= 0.00000006 * (IZR e * 1.1)) by (apply Rmult_le_compat; lra).
      apply Rabs_le_between in Rd. rewrite (Rabs_pos_eq (l + IZR e * ln 2)) by lra. apply Rabs_le. lra.
  Qed.
End Machine.

(* ------------------------------------------------------------------ of both formats *)

(* A literal is between two rationals. *)
Definition literal_between (f : format) (d : decimal) (a b : Q) : bool :=
  let v := decimal_float (precision f) (largest_exponent f) d in (is_finite_SF v && Qle_bool a (spec_float_value v) && Qle_bool (spec_float_value v) b)%bool.
Lemma literal_between_value f d a b : literal_between f d a b = true -> let v := decimal_number (precision f) (largest_exponent f) (Edge.precision_pos_instance f) (Edge.precision_below_instance f) d in
  Q2R a <= B2R v <= Q2R b /\ is_finite v = true.
Proof.
  unfold literal_between, decimal_number. cbv zeta. rewrite B2R_SF2B, is_finite_SF2B, !andb_true_iff, <- spec_float_value_real. intros [[F L] H].
  apply Qle_bool_iff, Qle_Rle in L, H. auto.
Qed.

(* The relative error of the logarithm of a text, besides that of the library: 0 where the text calls the library. *)
Definition log_error_of (k : constants) : R := if has_inline_log k then / 20480 else 0.
(* The logarithm of the text is near ln: the library's by assumption, one that is written out by proof. *)
Lemma emitted_log_near (f : format) (log_ : binary_float (precision f) (largest_exponent f) -> binary_float (precision f) (largest_exponent f)) (k : constants) :
  (has_inline_log k = false -> accurate (precision f) (largest_exponent f) log_) ->
  logarithm_near (precision f) (largest_exponent f) (Edge.precision_pos_instance f) (Edge.precision_below_instance f) log_ k (log_error_of k).
Proof.
  intros H y Fy Ry. unfold emitted_log, log_error_of. destruct (has_inline_log k) eqn:W.
  - assert (Bk : literal_between f (log_coefficient k) (676604 # 1000000) (676605 # 1000000) = true) by (unfold log_coefficient; destruct f, (is_single k); vm_compute; reflexivity).
    assert (Lk : literal_between f (ln_two k) (693146 # 1000000) (693148 # 1000000) = true) by (unfold ln_two; destruct f, (is_single k); vm_compute; reflexivity).
    assert (V : forall a, Q2R (a # 1000000) = IZR a / 1000000) by reflexivity.
    apply literal_between_value in Bk, Lk. rewrite !V in Bk, Lk.
    destruct (inline_log_near (precision f) (largest_exponent f) (Edge.precision_pos_instance f) (Edge.precision_below_instance f) (precision_large f) (precision_small f) (exponent_large f)
      (mantissa_cut (precision f) - (largest_exponent f - 2) * exponent_step (precision f))%Z ltac:(ring) ltac:(destruct f; vm_compute; split; discriminate) log_ k
      ltac:(split; [lra|apply Bk]) ltac:(split; [lra|apply Lk]) y Fy Ry) as [G1 G2].
    split; [exact G1|]. eapply Rle_trans; [exact G2|]. apply Rmult_le_compat_r; [apply Rabs_pos|]. pose proof (bpow_gt_0 radix2 (- precision f)). unfold unit_roundoff. lra.
  - destruct (H eq_refl y Fy ltac:(lra)) as [G1 G2]. split; [exact G1|]. rewrite Rplus_0_r. exact G2.
Qed.

(* The bits and the value of a number in memory. The two lemmas are for readers: 1, -0.75, the smallest positive number and infinity have
   the bits that the standard gives them. *)
Definition bits_and_value (f : format) (z : Z) : Z * spec_float :=
  let v := of_bits (precision f) (largest_exponent f) (Edge.precision_pos_instance f) (Edge.precision_below_instance f) z in (bits (precision f) (largest_exponent f) v, B2SF v).
Lemma bits_of_single : map (bits_and_value Single) [0x3f800000; 0xbf400000; 0x00000001; 0x7f800000]%Z = [
  (0x3f800000%Z, S754_finite false 8388608 (-23)); (0xbf400000%Z, S754_finite true 12582912 (-24)); (1%Z, S754_finite false 1 (-149)); (0x7f800000%Z, S754_infinity false)].
Proof. vm_compute. reflexivity. Qed.
Lemma bits_of_double : map (bits_and_value Double) [0x3ff0000000000000; 0xbfe8000000000000; 0x0000000000000001; 0x7ff0000000000000]%Z = [
  (0x3ff0000000000000%Z, S754_finite false 4503599627370496 (-52)); (0xbfe8000000000000%Z, S754_finite true 6755399441055744 (-53)); (1%Z, S754_finite false 1 (-1074));
  (0x7ff0000000000000%Z, S754_infinity false)].
Proof. vm_compute. reflexivity. Qed.
