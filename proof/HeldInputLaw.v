(* The law as it is emitted: computed from distances that have errors, with e clamped, rounded, and limited to u_max. This file bounds
   its input by the true distances: from above, by its sign past the middle, and from below near an edge. It also bounds exp by
   rationals, which decides what the logarithm in the law is.

   Period.v uses the three bounds as the conditions of HeldInputs.v, Law.v proves that the emitted statements are this law. The lemma
   book has them as `sampled.inputs`, `sampled.same_side`, `sampled.pull`, `sampled.shift` and `sampled.saturated` (docs/lemmas.md). *)
From Coq Require Import ZArith QArith Qreals Qround Reals Lra Psatz Lia.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Loop Tube.
Open Scope R_scope.

(* ------------------------------------------------------------------ exp, between rationals *)

Lemma exp_le_fraction z : 0 <= z < 2 -> exp z <= (2 + z) / (2 - z).
Proof.
  intros [Z0 Z2]. apply Rcomplements.Rle_div_r; [lra|].
  destruct (Req_dec z 0) as [->|Ne]; [rewrite exp_0; lra|].
  assert (A : 0 * (z - 0) <= (2 + z - (2 - z) * exp z) - (2 + 0 - (2 - 0) * exp 0)).
  { apply (rises_at_rate (fun t => 2 + t - (2 - t) * exp t) (fun t => 1 - (1 - t) * exp t)); [lra| |].
    - intro r. apply derivable_continuous_pt. exists (1 - (1 - r) * exp r). apply is_derive_Reals. auto_derive; [easy|ring].
    - intros r Hr. split; [auto_derive; [easy|ring]|].
      assert (E := exp_ineq1_le (- r)). rewrite exp_Ropp in E. pose proof (exp_pos r) as P.
      assert ((1 + - r) * exp r <= / exp r * exp r) by (apply Rmult_le_compat_r; lra).
      rewrite Rinv_l in H by lra. lra. }
  rewrite exp_0 in A. lra.
Qed.

Lemma exp_ge_quadratic z : 0 <= z -> 1 + z + z * z / 2 <= exp z.
Proof.
  intro Z0. destruct (Req_dec z 0) as [->|Ne]; [rewrite exp_0; lra|].
  assert (A : 0 * (z - 0) <= (exp z - (1 + z + z * z / 2)) - (exp 0 - (1 + 0 + 0 * 0 / 2))).
  { apply (rises_at_rate (fun t => exp t - (1 + t + t * t / 2)) (fun t => exp t - (1 + t))); [lra| |].
    - intro r. apply derivable_continuous_pt. exists (exp r - (1 + r)). apply is_derive_Reals. auto_derive; [easy|field].
    - intros r Hr. split; [auto_derive; [easy|field]|]. pose proof (exp_ineq1_le r). lra. }
  rewrite exp_0 in A. lra.
Qed.

(* Fixed-point numbers: the integer a stands for a/2^40, so that squaring takes a product and a shift. *)
Definition fixed_unit : Z := 2 ^ 40.
Definition fixed_value (a : Z) : R := IZR a / IZR fixed_unit.
(* A rational as a fixed-point number, rounded up; `fixed_below` rounds down. *)
Definition fixed_above (q : Q) : Z := Qceiling (q * inject_Z fixed_unit).
Definition fixed_below (q : Q) : Z := Qfloor (q * inject_Z fixed_unit).
Lemma fixed_unit_pos : 0 < IZR fixed_unit. Proof. now apply IZR_lt. Qed.
Lemma fixed_above_bounds q : Q2R q <= fixed_value (fixed_above q).
Proof.
  assert (G := fixed_unit_pos). apply (Rmult_le_reg_r (IZR fixed_unit)); [exact G|]. unfold fixed_value, fixed_above, Rdiv.
  rewrite (Rmult_assoc (IZR _)), Rinv_l, Rmult_1_r by lra. rewrite <- !Q2R_Z, <- Q2R_mult. apply Qle_Rle, Qle_ceiling.
Qed.
Lemma fixed_below_bounds q : fixed_value (fixed_below q) <= Q2R q.
Proof.
  assert (G := fixed_unit_pos). apply (Rmult_le_reg_r (IZR fixed_unit)); [exact G|]. unfold fixed_value, fixed_below, Rdiv.
  rewrite (Rmult_assoc (IZR _)), Rinv_l, Rmult_1_r by lra. rewrite <- !Q2R_Z, <- Q2R_mult. apply Qle_Rle, Qfloor_le.
Qed.

(* a squared m times, rounded up each time; `repeated_square_below` rounds down. *)
Fixpoint repeated_square_above (m : nat) (a : Z) : Z := match m with O => a | S k => repeated_square_above k (Z.shiftr (a * a) 40 + 1) end.
Fixpoint repeated_square_below (m : nat) (a : Z) : Z := match m with O => a | S k => repeated_square_below k (Z.shiftr (a * a) 40) end.

Lemma fixed_square_bounds a : fixed_value (Z.shiftr (a * a) 40) <= fixed_value a * fixed_value a <= fixed_value (Z.shiftr (a * a) 40 + 1).
Proof.
  rewrite Z.shiftr_div_pow2 by lia. change (2 ^ 40)%Z with fixed_unit. assert (G := fixed_unit_pos).
  assert (I : 0 < / IZR fixed_unit) by now apply Rinv_0_lt_compat. set (b := (a * a / fixed_unit)%Z).
  assert (F : forall c, fixed_value c = IZR (c * fixed_unit) * (/ IZR fixed_unit * / IZR fixed_unit)) by (intro; unfold fixed_value; rewrite mult_IZR; field; lra).
  assert (E : fixed_value a * fixed_value a = IZR (a * a) * (/ IZR fixed_unit * / IZR fixed_unit)) by (unfold fixed_value; rewrite mult_IZR; field; lra).
  rewrite E, (F b), (F (b + 1)%Z). assert (0 <= / IZR fixed_unit * / IZR fixed_unit) by (apply Rmult_le_pos; lra).
  split; apply Rmult_le_compat_r; try assumption; apply IZR_le; unfold b.
  - rewrite (Z.mul_comm (a * a / fixed_unit) fixed_unit). now apply Z.mul_div_le.
  - rewrite Z.add_1_r, (Z.mul_comm _ fixed_unit). apply Z.lt_le_incl. now apply Z.mul_succ_div_gt.
Qed.

Lemma repeated_square_above_bounds m : forall a z, exp z <= fixed_value a -> exp (z * 2 ^ m) <= fixed_value (repeated_square_above m a).
Proof.
  induction m; intros a z H; cbn [repeated_square_above pow]; [now rewrite Rmult_1_r|].
  replace (z * (2 * 2 ^ m)) with ((z + z) * 2 ^ m) by ring. apply IHm. rewrite exp_plus.
  eapply Rle_trans; [|apply fixed_square_bounds]. pose proof (exp_pos z). apply Rmult_le_compat; lra.
Qed.
Lemma repeated_square_below_bounds m : forall a z, fixed_value a <= exp z -> (0 <= a)%Z -> fixed_value (repeated_square_below m a) <= exp (z * 2 ^ m).
Proof.
  induction m; intros a z H P; cbn [repeated_square_below pow]; [now rewrite Rmult_1_r|].
  replace (z * (2 * 2 ^ m)) with ((z + z) * 2 ^ m) by ring.
  assert (F : 0 <= fixed_value a) by (unfold fixed_value; apply Rmult_le_pos; [now apply IZR_le|left; apply Rinv_0_lt_compat, fixed_unit_pos]).
  apply IHm.
  - rewrite exp_plus. eapply Rle_trans; [apply fixed_square_bounds|]. apply Rmult_le_compat; lra.
  - apply Z.shiftr_nonneg. now apply Z.mul_nonneg_nonneg.
Qed.

(* exp l is computed as exp (l/1024)^1024, by ten squarings. *)
Definition halving_count : nat := 10.
Definition halving_factor : Q := 1 # 1024.
Lemma halving_factor_value : Q2R halving_factor * 2 ^ halving_count = 1. Proof. unfold halving_factor, halving_count, Q2R; cbn; lra. Qed.

(* A fixed-point number as a rational. *)
Definition fixed_rational (a : Z) : Q := a # Z.to_pos fixed_unit.
Lemma fixed_rational_value a : Q2R (fixed_rational a) = fixed_value a.
Proof. unfold fixed_rational, fixed_value, Q2R; cbn [Qnum Qden]. rewrite Z2Pos.id by reflexivity. reflexivity. Qed.

(* exp l <= y, decided in rationals; false where the bounds do not decide it. `proves_exp_ge` is y <= exp l. *)
Definition proves_exp_le (l y : Q) : bool :=
  let z := fixed_rational (fixed_above (l * halving_factor)) in
  if (Qle_bool 0 z && Qle_bool z 1)%bool then Qle_bool (fixed_rational (repeated_square_above halving_count (fixed_above ((2 + z) / (2 - z))))) y else false.
Definition proves_exp_ge (l y : Q) : bool :=
  let z := fixed_rational (fixed_below (l * halving_factor)) in
  if Qle_bool 0 z then
    let v := fixed_below (1 + z + z * z * (1 # 2)) in if (0 <=? v)%Z then Qle_bool y (fixed_rational (repeated_square_below halving_count v)) else false
  else false.

Lemma Q2R_0 : Q2R 0 = 0. Proof. unfold Q2R; cbn; lra. Qed.
Lemma Q2R_1 : Q2R 1 = 1. Proof. unfold Q2R; cbn; lra. Qed.
Lemma Q2R_2 : Q2R 2 = 2. Proof. unfold Q2R; cbn; lra. Qed.
Lemma Qle_bool_to_R a b : Qle_bool a b = true -> Q2R a <= Q2R b. Proof. intro H. now apply Qle_Rle, Qle_bool_iff. Qed.

Lemma ln_ge_if_exp_le l y : proves_exp_le l y = true -> Q2R l <= ln (Q2R y).
Proof.
  unfold proves_exp_le. set (z := fixed_rational (fixed_above (l * halving_factor))). destruct (Qle_bool 0 z && Qle_bool z 1)%bool eqn:B; [|easy]. intro H.
  apply andb_true_iff in B. destruct B as [B1 B2]. apply Qle_bool_to_R in B1, B2, H. rewrite Q2R_0 in B1. rewrite Q2R_1 in B2.
  assert (E : exp (Q2R l) <= Q2R y).
  { apply Rle_trans with (2 := H). rewrite fixed_rational_value. apply Rle_trans with (exp (Q2R z * 2 ^ halving_count)).
    - assert (A : Q2R l <= Q2R z * 2 ^ halving_count).
      { assert (U := fixed_above_bounds (l * halving_factor)). rewrite <- fixed_rational_value in U. fold z in U. rewrite Q2R_mult in U.
        apply (Rmult_le_compat_r (2 ^ halving_count)) in U; [|left; apply pow_lt; lra]. rewrite Rmult_assoc, halving_factor_value in U. lra. }
      destruct (Req_dec (Q2R l) (Q2R z * 2 ^ halving_count)) as [->|Ne]; [lra|]. left. apply exp_increasing. lra.
    - apply repeated_square_above_bounds. eapply Rle_trans; [|apply fixed_above_bounds].
      assert (N : ~ (2 - z == 0)%Q) by (intro Q; apply Qeq_eqR in Q; rewrite Q2R_minus, Q2R_2, Q2R_0 in Q; lra).
      rewrite Q2R_div, Q2R_plus, Q2R_minus, Q2R_2 by exact N. apply exp_le_fraction. lra. }
  rewrite <- (ln_exp (Q2R l)). apply Rcomplements.ln_le; [apply exp_pos|exact E].
Qed.

Lemma ln_le_if_exp_ge l y : proves_exp_ge l y = true -> 0 < Q2R y -> ln (Q2R y) <= Q2R l.
Proof.
  unfold proves_exp_ge. set (z := fixed_rational (fixed_below (l * halving_factor))). destruct (Qle_bool 0 z) eqn:B; [|easy].
  set (v := fixed_below _). destruct (0 <=? v)%Z eqn:B2; [|easy]. intros H Y.
  apply Qle_bool_to_R in B, H. apply Z.leb_le in B2. rewrite Q2R_0 in B. rewrite fixed_rational_value in H.
  assert (E : Q2R y <= exp (Q2R l)).
  { apply Rle_trans with (1 := H). apply Rle_trans with (exp (Q2R z * 2 ^ halving_count)).
    - apply repeated_square_below_bounds; [|exact B2]. eapply Rle_trans; [apply fixed_below_bounds|].
      rewrite !Q2R_plus, !Q2R_mult, Q2R_1. replace (Q2R (1 # 2)) with (/ 2) by (unfold Q2R; cbn; lra).
      apply Rle_trans with (2 := exp_ge_quadratic _ B). lra.
    - assert (A : Q2R z * 2 ^ halving_count <= Q2R l).
      { assert (U := fixed_below_bounds (l * halving_factor)). rewrite <- fixed_rational_value in U. fold z in U. rewrite Q2R_mult in U.
        apply (Rmult_le_compat_r (2 ^ halving_count)) in U; [|left; apply pow_lt; lra]. rewrite Rmult_assoc, halving_factor_value in U. lra. }
      destruct (Req_dec (Q2R z * 2 ^ halving_count) (Q2R l)) as [->|Ne]; [lra|]. left. apply exp_increasing. lra. }
  rewrite <- (ln_exp (Q2R l)). apply Rcomplements.ln_le; [exact Y|exact E].
Qed.

(* ------------------------------------------------------------------ the law *)

Lemma ln_ge_one_minus_inverse y : 0 < y -> 1 - / y <= ln y.
Proof.
  intro H. assert (P : 0 < / y) by now apply Rinv_0_lt_compat.
  assert (E := exp_ineq1_le (- ln y)). rewrite exp_Ropp, exp_ln in E by exact H. lra.
Qed.
Lemma ln_le_minus_one y : 0 < y -> ln y <= y - 1.
Proof. intro H. assert (E := exp_ineq1_le (ln y)). rewrite exp_ln in E by exact H. lra. Qed.

(* (1 + 1/y) (ln y + r) grows with y: the law pulls harder the more the distances to both edges differ. *)
Lemma pull_grows_with_ratio y1 y2 r : 1 <= y1 <= y2 -> r <= 1 -> (1 + / y1) * (ln y1 + r) <= (1 + / y2) * (ln y2 + r).
Proof.
  intros [A B] Hr. assert (P1 : 0 < / y1) by (apply Rinv_0_lt_compat; lra). assert (P2 : 0 < / y2) by (apply Rinv_0_lt_compat; lra).
  assert (D : 1 - y1 * / y2 <= ln y2 - ln y1).
  { rewrite <- ln_div by lra. assert (L := ln_ge_one_minus_inverse (y2 / y1) ltac:(apply Rdiv_lt_0_compat; lra)).
    replace (/ (y2 / y1)) with (y1 * / y2) in L by (field; lra). exact L. }
  assert (L1 := ln_le_minus_one y1 ltac:(lra)).
  assert (S0 : 0 <= 1 - y1 * / y2).
  { assert (y1 * / y2 <= y2 * / y2) by (apply Rmult_le_compat_r; lra). rewrite Rinv_r in H by lra. lra. }
  assert (E : / y1 - / y2 = (1 - y1 * / y2) * / y1) by (field; lra).
  assert (Q : (ln y1 + r) * / y1 <= 1).
  { apply Rle_trans with (y1 * / y1); [apply Rmult_le_compat_r; lra|rewrite Rinv_r; lra]. }
  assert ((1 - y1 * / y2) * ((ln y1 + r) * / y1) <= (1 - y1 * / y2) * 1) by (apply Rmult_le_compat_l; lra).
  assert ((1 - y1 * / y2) * (1 + / y2) <= (ln y2 - ln y1) * (1 + / y2)) by (apply Rmult_le_compat_r; lra).
  assert (0 <= (1 - y1 * / y2) * / y2) by (apply Rmult_le_pos; lra).
  assert ((ln y1 + r) * (/ y1 - / y2) <= (ln y2 - ln y1) * (1 + / y2)) by (rewrite E; lra). lra.
Qed.

(* 1 where the upper edge is nearer, else -1; a and b are the distances to the lower and the upper edge. *)
Definition side_sign (a b : R) : R := if Rlt_dec b a then 1 else -1.
(* The distance to the nearer edge, but at least the share clamp_share of the width: so e is clamped. *)
Definition clamped_near_distance (clamp_share a b : R) : R := Rmax (Rmin a b) (clamp_share * (a + b)).
(* |u| by the law (13) for the nearer and the farther distance, with errors e1 of the factor and e2 of the logarithm. *)
Definition law_magnitude (gain near far e1 e2 : R) : R := gain * (1 / far + 1 / near) * (1 + e1) * (ln (far / near) + e2).
(* An input limited to u_max, where there is a limit. *)
Definition limit_input (u_limit : option R) (u : R) : R := match u_limit with None => u | Some m => Rmax (- m) (Rmin u m) end.
(* u is an input that `control` may store for distances a and b: the law (13) with e clamped, limited, with errors of at most law_error
   in the factor and in the logarithm. *)
Definition acts_as_law (gain clamp_share law_error : R) (u_limit : option R) (a b u : R) : Prop := exists e1 e2, Rabs e1 <= law_error /\ Rabs e2 <= law_error /\
  u = limit_input u_limit (- side_sign a b * law_magnitude gain (clamped_near_distance clamp_share a b) (a + b - clamped_near_distance clamp_share a b) e1 e2).

Lemma clamped_near_distance_range clamp_share a b : 0 < clamp_share <= 1 / 2 -> 0 < a + b -> 0 < clamped_near_distance clamp_share a b <= (a + b) / 2.
Proof.
  intros Hc Hs. assert (0 < clamp_share * (a + b)) by (apply Rmult_lt_0_compat; lra).
  assert (clamp_share * (a + b) <= 1 / 2 * (a + b)) by (apply Rmult_le_compat_r; lra).
  unfold clamped_near_distance, Rmax, Rmin; repeat destruct Rle_dec; lra.
Qed.

Lemma law_magnitude_form gain near far e1 e2 : 0 < near -> 0 < far ->
  law_magnitude gain near far e1 e2 = gain * (/ near * ((1 + / (far / near)) * (ln (far / near) + e2))) * (1 + e1).
Proof. intros; unfold law_magnitude. field. lra. Qed.

Lemma law_magnitude_ge gain near far e1 e2 law_error B Y l : 0 < gain -> 0 < near <= B -> 1 <= Y <= far / near -> l <= ln Y -> 0 <= law_error <= l -> law_error <= 1 ->
  Rabs e1 <= law_error -> Rabs e2 <= law_error -> gain * / B * (1 + / Y) * (1 - law_error) * (l - law_error) <= law_magnitude gain near far e1 e2.
Proof.
  intros Hk Hn Hy Hl Hr r1 E1 E2. apply Rabs_le_between in E1, E2.
  assert (F : 0 < far).
  { apply (Rmult_lt_reg_r (/ near)); [apply Rinv_0_lt_compat; lra|]. rewrite Rmult_0_l. fold (far / near). lra. }
  rewrite law_magnitude_form by lra. set (y := far / near) in *.
  assert (P : 0 < / y) by (apply Rinv_0_lt_compat; lra). assert (PY : 0 < / Y) by (apply Rinv_0_lt_compat; lra).
  assert (Q := pull_grows_with_ratio Y y (- law_error) ltac:(lra) ltac:(lra)).
  assert (A : (1 + / Y) * (l - law_error) <= (1 + / y) * (ln y + e2)).
  { apply Rle_trans with ((1 + / Y) * (ln Y + - law_error)); [apply Rmult_le_compat_l; lra|]. apply Rle_trans with (1 := Q).
    apply Rmult_le_compat_l; lra. }
  assert (A0 : 0 <= (1 + / Y) * (l - law_error)) by (apply Rmult_le_pos; lra).
  assert (IB : 0 < / B <= / near).
  { split; [apply Rinv_0_lt_compat; lra|apply Rinv_le_contravar; lra]. }
  assert (C : / B * ((1 + / Y) * (l - law_error)) <= / near * ((1 + / y) * (ln y + e2))) by (apply Rmult_le_compat; lra).
  assert (C0 : 0 <= / B * ((1 + / Y) * (l - law_error))) by (apply Rmult_le_pos; lra).
  replace (gain * / B * (1 + / Y) * (1 - law_error) * (l - law_error)) with (gain * (/ B * ((1 + / Y) * (l - law_error))) * (1 - law_error)) by ring.
  apply Rmult_le_compat; try lra; [apply Rmult_le_pos; lra|]. apply Rmult_le_compat_l; lra.
Qed.

Lemma law_magnitude_le gain near far e1 e2 law_error N Y l : 0 < gain -> 0 < N <= near -> 1 <= far / near <= Y -> ln Y <= l -> 0 <= law_error <= 1 ->
  Rabs e1 <= law_error -> Rabs e2 <= law_error -> Rabs (law_magnitude gain near far e1 e2) <= gain * / N * (1 + / Y) * (1 + law_error) * (l + law_error).
Proof.
  intros Hk Hn Hy Hl Hr E1 E2.
  assert (F : 0 < far).
  { apply (Rmult_lt_reg_r (/ near)); [apply Rinv_0_lt_compat; lra|]. rewrite Rmult_0_l. fold (far / near). lra. }
  rewrite law_magnitude_form by lra. set (y := far / near) in *.
  assert (P : 0 < / y) by (apply Rinv_0_lt_compat; lra). assert (PY : 0 < / Y) by (apply Rinv_0_lt_compat; lra).
  assert (Ly : 0 <= ln y) by (rewrite <- ln_1; apply Rcomplements.ln_le; lra).
  assert (Q := pull_grows_with_ratio y Y law_error ltac:(lra) ltac:(lra)).
  rewrite !Rabs_mult, (Rabs_pos_eq gain), (Rabs_pos_eq (/ near)), (Rabs_pos_eq (1 + / y)) by (try lra; left; apply Rinv_0_lt_compat; lra).
  assert (A1 : Rabs (ln y + e2) <= ln y + law_error).
  { eapply Rle_trans; [apply Rabs_triang|]. rewrite (Rabs_pos_eq (ln y)) by lra. lra. }
  assert (A2 : Rabs (1 + e1) <= 1 + law_error).
  { eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_R1. lra. }
  assert (IN : 0 < / near <= / N).
  { split; [apply Rinv_0_lt_compat; lra|apply Rinv_le_contravar; lra]. }
  assert (A : (1 + / y) * Rabs (ln y + e2) <= (1 + / Y) * (l + law_error)).
  { apply Rle_trans with ((1 + / y) * (ln y + law_error)); [apply Rmult_le_compat_l; lra|]. apply Rle_trans with (1 := Q).
    apply Rmult_le_compat_l; lra. }
  assert (A0 : 0 <= (1 + / y) * Rabs (ln y + e2)) by (apply Rmult_le_pos; [lra|apply Rabs_pos]).
  replace (gain * / N * (1 + / Y) * (1 + law_error) * (l + law_error)) with (gain * (/ N * ((1 + / Y) * (l + law_error))) * (1 + law_error)) by ring.
  assert (0 <= / near * ((1 + / y) * Rabs (ln y + e2))) by (apply Rmult_le_pos; lra).
  apply Rmult_le_compat; [apply Rmult_le_pos; lra|apply Rabs_pos| |exact A2].
  apply Rmult_le_compat_l; [lra|]. apply Rmult_le_compat; lra.
Qed.

Lemma limit_input_odd u_limit u : (forall m, u_limit = Some m -> 0 <= m) -> limit_input u_limit (- u) = - limit_input u_limit u.
Proof.
  intro H. destruct u_limit as [m|]; cbn; [|reflexivity]. specialize (H m eq_refl). unfold Rmax, Rmin; repeat destruct Rle_dec; lra.
Qed.

(* Mirroring the state between the edges changes the sign of the input. *)
Lemma acts_as_law_odd gain clamp_share law_error u_limit a b u : (forall m, u_limit = Some m -> 0 <= m) -> 0 < clamp_share <= 1 / 2 -> 0 < a + b -> acts_as_law gain clamp_share law_error u_limit a b u -> acts_as_law gain clamp_share law_error u_limit b a (- u).
Proof.
  intros Hm Hc Hs (e1 & e2 & A & B & ->).
  assert (N : clamped_near_distance clamp_share b a = clamped_near_distance clamp_share a b) by (unfold clamped_near_distance; rewrite Rmin_comm; f_equal; ring).
  assert (S : b + a = a + b) by ring.
  destruct (Req_dec a b) as [E|E].
  - (* in the middle the logarithm is 0, and its error may have either sign *)
    exists e1, (- e2). rewrite Rabs_Ropp. split; [exact A|split; [exact B|]]. rewrite <- limit_input_odd by exact Hm. f_equal.
    rewrite N, S. subst b. unfold side_sign. destruct Rlt_dec; [lra|]. unfold law_magnitude.
    assert (Nr := clamped_near_distance_range clamp_share a a Hc Hs).
    assert (M : clamped_near_distance clamp_share a a = a).
    { unfold clamped_near_distance. rewrite Rmin_left by lra. assert (clamp_share * (a + a) <= 1 / 2 * (a + a)) by (apply Rmult_le_compat_r; lra). apply Rmax_left; lra. }
    rewrite M. replace ((a + a - a) / a) with 1 by (field; lra). rewrite ln_1. ring.
  - exists e1, e2. split; [exact A|split; [exact B|]]. rewrite <- limit_input_odd by exact Hm. f_equal. rewrite N, S.
    unfold side_sign. repeat destruct Rlt_dec; try lra; ring.
Qed.

(* An emitted law that measures distances a' and b' within distance_error of the true ones, a and b. inner_share is 1/(1 + rho). *)
Section InputBounds.
  Variables (gain clamp_share law_error distance_error inner_share : R) (u_limit : option R).
  Hypothesis constants_in_range : 0 < gain /\ 0 < clamp_share <= inner_share /\ inner_share <= 1 / 2 /\ 0 <= law_error <= 1 / 2 /\ clamp_share <= 1 / 4 /\ 0 <= distance_error.
  Hypothesis u_limit_nonneg : forall m, u_limit = Some m -> 0 <= m.

  Lemma limit_input_shrinks u : Rabs (limit_input u_limit u) <= Rabs u.
  Proof.
    destruct u_limit as [m|]; cbn; [|lra]. specialize (u_limit_nonneg m eq_refl).
    unfold Rmax, Rmin, Rabs; repeat destruct Rle_dec; repeat destruct Rcase_abs; lra.
  Qed.

  (* The largest input, where the sample was taken in the inner tube and the width was at least width_low. *)
  Lemma input_bounded_in_inner_tube a b a' b' u width_low Y l : acts_as_law gain clamp_share law_error u_limit a' b' u -> Rabs (a' - a) <= distance_error -> Rabs (b' - b) <= distance_error ->
    width_low <= a + b -> (a + b) * inner_share <= a -> (a + b) * inner_share <= b -> 0 < width_low * inner_share - distance_error -> Y = (width_low * (1 - inner_share) + distance_error) / (width_low * inner_share - distance_error) -> ln Y <= l ->
    Rabs u <= gain * / (width_low * inner_share - distance_error) * (1 + / Y) * (1 + law_error) * (l + law_error).
  Proof.
    destruct constants_in_range as (k0 & Hc & Hz & Hr & c4 & e0).
    intros (e1 & e2 & E1 & E2 & ->) Ea Eb Hd Wa Wb HN HY Hl. apply Rabs_le_between in Ea, Eb.
    eapply Rle_trans; [apply limit_input_shrinks|].
    assert (Sd : Rabs (- side_sign a' b' * law_magnitude gain (clamped_near_distance clamp_share a' b') (a' + b' - clamped_near_distance clamp_share a' b') e1 e2) =
                 Rabs (law_magnitude gain (clamped_near_distance clamp_share a' b') (a' + b' - clamped_near_distance clamp_share a' b') e1 e2)).
    { rewrite Rabs_mult. unfold side_sign. destruct Rlt_dec; [rewrite Rabs_left by lra|rewrite Rabs_pos_eq by lra]; ring. }
    rewrite Sd.
    assert (Wd : width_low * inner_share <= (a + b) * inner_share) by (apply Rmult_le_compat_r; lra).
    assert (Mn : width_low * inner_share - distance_error <= Rmin a' b') by (unfold Rmin; destruct Rle_dec; lra).
    assert (Mx : Rmax a' b' <= (a + b) * (1 - inner_share) + distance_error) by (unfold Rmax; destruct Rle_dec; lra).
    assert (Mn2 : (a + b) * inner_share - distance_error <= Rmin a' b') by (unfold Rmin; destruct Rle_dec; lra).
    assert (SumE : a' + b' = Rmin a' b' + Rmax a' b') by (unfold Rmin, Rmax; repeat destruct Rle_dec; lra).
    destruct (clamped_near_distance_range clamp_share a' b' ltac:(lra) ltac:(unfold Rmin in Mn; destruct Rle_dec; lra)) as [N0 N2].
    assert (N1 : Rmin a' b' <= clamped_near_distance clamp_share a' b') by (unfold clamped_near_distance; apply Rmax_l).
    set (near := clamped_near_distance clamp_share a' b') in *.
    assert (d0 : 0 < width_low) by (apply (Rmult_lt_reg_r inner_share); lra).
    assert (YN : Y * (width_low * inner_share - distance_error) = width_low * (1 - inner_share) + distance_error) by (rewrite HY; field; lra).
    assert (Y1 : 1 <= Y).
    { rewrite HY. apply Rcomplements.Rle_div_r; [lra|]. assert (0 <= width_low * (1 - 2 * inner_share)) by (apply Rmult_le_pos; lra). lra. }
    assert (Far : a' + b' - near <= Y * near).
    { assert (A : (a + b) * (1 - inner_share) + distance_error <= Y * ((a + b) * inner_share - distance_error)).
      { assert (0 <= Y * distance_error) by (apply Rmult_le_pos; lra).
        assert (Yz : 1 - inner_share <= Y * inner_share) by (apply (Rmult_le_reg_l width_low); lra).
        assert (0 <= (a + b - width_low) * (Y * inner_share - (1 - inner_share))) by (apply Rmult_le_pos; lra). lra. }
      assert (Y * ((a + b) * inner_share - distance_error) <= Y * near) by (apply Rmult_le_compat_l; lra). lra. }
    apply law_magnitude_le; try lra.
    split.
    - apply Rcomplements.Rle_div_r; lra.
    - apply Rcomplements.Rle_div_l; [lra|exact Far].
  Qed.

  (* Where the sample was farther above the middle than all errors, the input is not upwards. *)
  Lemma input_not_outwards_past_middle a b a' b' u width_max : acts_as_law gain clamp_share law_error u_limit a' b' u -> Rabs (a' - a) <= distance_error -> Rabs (b' - b) <= distance_error -> 0 < a' + b' ->
    a + b <= width_max -> 2 * distance_error + law_error * (width_max + 2 * distance_error) < a - b -> u <= 0.
  Proof.
    destruct constants_in_range as (k0 & Hc & Hz & Hr & c4 & e0).
    intros (e1 & e2 & E1 & E2 & ->) Ea Eb Hs Hm Hd. apply Rabs_le_between in Ea, Eb, E1, E2.
    assert (Sn : law_error * (a' + b') <= law_error * (width_max + 2 * distance_error)) by (apply Rmult_le_compat_l; lra).
    assert (R0 : 0 <= law_error * (a' + b')) by (apply Rmult_le_pos; lra).
    destruct (clamped_near_distance_range clamp_share a' b' ltac:(lra) Hs) as [N0 N2].
    assert (Ln : law_error <= ln ((a' + b' - clamped_near_distance clamp_share a' b') / clamped_near_distance clamp_share a' b')).
    { set (near := clamped_near_distance clamp_share a' b') in *. set (far := a' + b' - near) in *.
      assert (P : 0 < far / near) by (apply Rdiv_lt_0_compat; unfold far; lra).
      eapply Rle_trans; [|apply (ln_ge_one_minus_inverse _ P)].
      replace (/ (far / near)) with (near / far) by (unfold far in *; field; lra).
      assert (Q : near / far <= 1 - law_error); [|lra].
      apply Rcomplements.Rle_div_l; [unfold far; lra|]. unfold far.
      assert (Cs : near = b' \/ near = clamp_share * (a' + b')).
      { unfold near, clamped_near_distance, Rmax, Rmin. repeat destruct Rle_dec; lra. }
      destruct Cs as [Q|Q]; rewrite Q in *.
      { assert (0 <= law_error * b') by (apply Rmult_le_pos; lra). lra. }
      assert (clamp_share * (a' + b') <= 1 / 4 * (a' + b')) by (apply Rmult_le_compat_r; lra).
      assert (law_error * (a' + b') <= 1 / 2 * (a' + b')) by (apply Rmult_le_compat_r; lra).
      assert (0 <= law_error * (clamp_share * (a' + b'))) by (apply Rmult_le_pos; [lra|apply Rmult_le_pos; lra]). lra. }
    unfold side_sign. destruct Rlt_dec as [_|Q]; [|lra].
    assert (M : 0 <= law_magnitude gain (clamped_near_distance clamp_share a' b') (a' + b' - clamped_near_distance clamp_share a' b') e1 e2).
    { unfold law_magnitude. repeat apply Rmult_le_pos; try lra. unfold Rdiv. rewrite !Rmult_1_l.
      apply Rplus_le_le_0_compat; left; apply Rinv_0_lt_compat; lra. }
    set (mg := law_magnitude _ _ _ _ _) in *.
    destruct u_limit as [m|]; cbn; [|lra]. specialize (u_limit_nonneg m eq_refl). unfold Rmax, Rmin; repeat destruct Rle_dec; lra.
  Qed.

  (* Where the sample was near the upper edge, and the width is between width_low and width_high when the input acts, the input pulls
     down faster than closing_speed. *)
  Lemma input_pulls_back_near_edge a b a' b' u width width_low width_high drift edge_drift A B0 Y l g_min closing_speed :
    acts_as_law gain clamp_share law_error u_limit a' b' u -> Rabs (a' - a) <= distance_error -> Rabs (b' - b) <= distance_error -> 0 < a' + b' ->
    width_low <= width <= width_high -> 0 < width_low -> 0 <= edge_drift <= drift -> a + b <= width + 2 * edge_drift -> width * (1 - inner_share) - drift <= a -> b <= width * inner_share + drift ->
    A = width_low * (1 - inner_share) - (drift + distance_error) -> B0 = width_low * inner_share + (drift + distance_error) -> Y = A / B0 -> 1 < Y -> l <= ln Y -> law_error <= l -> 0 < g_min ->
    closing_speed <= g_min * (gain * / (width_high * inner_share + (drift + distance_error)) * (1 + / Y) * (1 - law_error) * (l - law_error)) ->
    (forall m, u_limit = Some m -> closing_speed <= g_min * m) -> closing_speed <= g_min * - u.
  Proof.
    destruct constants_in_range as (k0 & Hc & Hz & Hr & c4 & e0).
    intros (e1 & e2 & E1 & E2 & ->) Ea Eb Hs Hd d00 Hv Hw Ha Hb HA HB HY Y1 Hl rl Hg HP Hlim. apply Rabs_le_between in Ea, Eb.
    destruct (clamped_near_distance_range clamp_share a' b' ltac:(lra) Hs) as [N0 N2].
    assert (B00 : 0 < B0) by (rewrite HB; assert (0 < width_low * inner_share) by (apply Rmult_lt_0_compat; lra); lra).
    assert (YB : Y * B0 = A) by (rewrite HY; field; lra).
    assert (Dz : width_low * inner_share <= width * inner_share <= width_high * inner_share) by (split; apply Rmult_le_compat_r; lra).
    assert (Yz : Y * inner_share <= 1 - inner_share).
    { apply (Rmult_le_reg_l width_low); [exact d00|]. assert (0 <= Y * (drift + distance_error)) by (apply Rmult_le_pos; lra).
      rewrite HB, HA in YB. lra. }
    assert (Yb : Y * (width * inner_share + (drift + distance_error)) <= width * (1 - inner_share) - (drift + distance_error)).
    { assert ((width - width_low) * (Y * inner_share) <= (width - width_low) * (1 - inner_share)) by (apply Rmult_le_compat_l; lra).
      rewrite HB, HA in YB. lra. }
    assert (Bb : b' <= width * inner_share + (drift + distance_error)) by lra.
    assert (Yb' : Y * b' <= a').
    { assert (Y * b' <= Y * (width * inner_share + (drift + distance_error))) by (apply Rmult_le_compat_l; lra). lra. }
    assert (Lt : b' < a').
    { assert (0 < width * inner_share + (drift + distance_error)) by (assert (0 < width * inner_share) by (apply Rmult_lt_0_compat; lra); lra).
      assert (1 * (width * inner_share + (drift + distance_error)) < Y * (width * inner_share + (drift + distance_error))) by (apply Rmult_lt_compat_r; lra). lra. }
    set (near := clamped_near_distance clamp_share a' b') in *.
    assert (Cs : near = b' \/ near = clamp_share * (a' + b')) by (unfold near, clamped_near_distance, Rmax, Rmin; repeat destruct Rle_dec; lra).
    assert (Cz : clamp_share * (a' + b') <= inner_share * (a' + b')) by (apply Rmult_le_compat_r; lra).
    assert (NB : near <= width_high * inner_share + (drift + distance_error)).
    { destruct Cs as [Q|Q]; rewrite Q; [lra|]. apply Rle_trans with (1 := Cz).
      assert (inner_share * (a' + b') <= inner_share * (width + 2 * edge_drift + 2 * distance_error)) by (apply Rmult_le_compat_l; lra).
      assert (inner_share * (2 * (edge_drift + distance_error)) <= 1 / 2 * (2 * (edge_drift + distance_error))) by (apply Rmult_le_compat_r; lra). lra. }
    assert (FY : Y <= (a' + b' - near) / near).
    { apply Rcomplements.Rle_div_r; [lra|]. destruct Cs as [Q|Q]; rewrite Q; [lra|].
      assert (Y * (clamp_share * (a' + b')) <= Y * (inner_share * (a' + b'))) by (apply Rmult_le_compat_l; lra).
      assert (Y * inner_share * (a' + b') <= (1 - inner_share) * (a' + b')) by (apply Rmult_le_compat_r; lra). lra. }
    assert (M := law_magnitude_ge gain near (a' + b' - near) e1 e2 law_error (width_high * inner_share + (drift + distance_error)) Y l k0 ltac:(lra) ltac:(lra) Hl ltac:(lra) ltac:(lra) E1 E2).
    unfold side_sign. destruct Rlt_dec as [_|Q]; [|lra]. fold near.
    set (mg := law_magnitude _ _ _ _ _) in *. set (bd := gain * / _ * _ * _ * _) in *.
    assert (g_min * bd <= g_min * mg) by (apply Rmult_le_compat_l; lra).
    destruct u_limit as [m|]; cbn; [|lra]. specialize (u_limit_nonneg m eq_refl). specialize (Hlim m eq_refl).
    set (limited := Rmax _ _).
    assert (Cl : mg <= - limited \/ m <= - limited) by (unfold limited, Rmax, Rmin; repeat destruct Rle_dec; lra).
    destruct Cl; [assert (g_min * mg <= g_min * - limited)|assert (g_min * m <= g_min * - limited)]; try (apply Rmult_le_compat_l; lra); lra.
  Qed.
End InputBounds.
