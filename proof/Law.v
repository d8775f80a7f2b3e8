(* The law in the machine's arithmetic: what the emitted statements compute is the law (13) with e clamped, up to 32 units of rounding in
   the factor and in the logarithm, and more where the logarithm is written out.

   Relative errors are counted in factors p = 1 - u, u the relative error of a rounding: x and y are close by n when each is at least p^n
   times the other. Products and quotients add the counts, and a rounding adds one.

   Controller.v uses `unlimited_input_acts_as_law`, `saturated_input_acts_as_law` and `is_inside_correct`. docs/certificate-format.md
   counts the same errors (the law). *)
From Coq Require Import ZArith QArith Qreals Reals Lia Lra Psatz.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Stt Require HeldInputLaw.
From Stt Require Import Loop Syntax Run Emission Control Semantics.
Open Scope R_scope.

(* Counting relative errors of positive numbers. *)
Section RoundingCounts.
  Variable u : R.
  Hypothesis u_small : 0 < u <= / 16777216.
  Let p := 1 - u.

  (* x and y are close by n. *)
  Definition close (n : nat) (x y : R) : Prop := 0 < x /\ 0 < y /\ y * p ^ n <= x /\ x * p ^ n <= y.

  Lemma p_range : 0 < p < 1. Proof. unfold p. lra. Qed.
  Lemma pow_range n : 0 < p ^ n <= 1.
  Proof. pose proof p_range. split; [apply pow_lt; lra|]. rewrite <- (pow1 n). apply pow_incr; lra. Qed.

  Lemma close_refl n x : 0 < x -> close n x x.
  Proof. intro H. pose proof (pow_range n). unfold close. repeat split; nra. Qed.
  Lemma close_sym n x y : close n x y -> close n y x.
  Proof. unfold close. tauto. Qed.
  Lemma close_weaken n m x y : (n <= m)%nat -> close n x y -> close m x y.
  Proof.
    intros L (X & Y & A & B). pose proof (pow_range n) as Pn. replace m with (n + (m - n))%nat by lia. unfold close. rewrite !pow_add.
    pose proof (pow_range (m - n)) as Pm. repeat split; auto; nra.
  Qed.
  Lemma close_trans n m x y z : close n x y -> close m y z -> close (n + m) x z.
  Proof.
    intros (X & Y & A & B) (_ & Z & C & D). pose proof (pow_range n). pose proof (pow_range m). unfold close. rewrite pow_add. repeat split; auto.
    - apply Rle_trans with (2 := A). replace (z * (p ^ n * p ^ m)) with (z * p ^ m * p ^ n) by ring. apply Rmult_le_compat_r; lra.
    - apply Rle_trans with (2 := D). rewrite <- Rmult_assoc. apply Rmult_le_compat_r; lra.
  Qed.
  Lemma close_mul n m x y x' y' : close n x y -> close m x' y' -> close (n + m) (x * x') (y * y').
  Proof.
    intros (X & Y & A & B) (X' & Y' & C & D). pose proof (pow_range n). pose proof (pow_range m). unfold close. rewrite pow_add.
    assert (0 < y * p ^ n) by nra. assert (0 < y' * p ^ m) by nra. assert (0 < x * p ^ n) by nra. assert (0 < x' * p ^ m) by nra.
    repeat split; [nra|nra| |].
    - replace (y * y' * (p ^ n * p ^ m)) with ((y * p ^ n) * (y' * p ^ m)) by ring. apply Rmult_le_compat; lra.
    - replace (x * x' * (p ^ n * p ^ m)) with ((x * p ^ n) * (x' * p ^ m)) by ring. apply Rmult_le_compat; lra.
  Qed.
  Lemma close_inv n x y : close n x y -> close n (/ x) (/ y).
  Proof.
    intros (X & Y & A & B). pose proof (pow_range n). assert (0 < / x) by now apply Rinv_0_lt_compat. assert (0 < / y) by now apply Rinv_0_lt_compat.
    unfold close. repeat split; auto.
    - apply (Rmult_le_reg_r (x * y)); [nra|]. replace (/ y * p ^ n * (x * y)) with (x * p ^ n) by (field; lra). replace (/ x * (x * y)) with y by (field; lra). exact B.
    - apply (Rmult_le_reg_r (x * y)); [nra|]. replace (/ x * p ^ n * (x * y)) with (y * p ^ n) by (field; lra). replace (/ y * (x * y)) with x by (field; lra). exact A.
  Qed.
  Lemma close_div n m x y x' y' : close n x y -> close m x' y' -> close (n + m) (x / x') (y / y').
  Proof. intros A B. apply close_mul; [exact A|now apply close_inv]. Qed.
  Lemma close_add n x y x' y' : close n x y -> close n x' y' -> close n (x + x') (y + y').
  Proof. intros (X & Y & A & B) (X' & Y' & C & D). unfold close. repeat split; nra. Qed.
  Lemma rounding_is_close r x : 0 < x -> Rabs (r - x) <= u * Rabs x -> close 1 r x.
  Proof.
    intros X H. rewrite (Rabs_pos_eq x) in H by lra. apply Rabs_le_between in H. unfold close. rewrite pow_1. unfold p. repeat split; nra.
  Qed.
  Lemma close_after_rounding n r x y : close n x y -> Rabs (r - x) <= u * Rabs x -> close (S n) r y.
  Proof. intros C H. change (S n) with (1 + n)%nat. apply close_trans with x; [|exact C]. apply rounding_is_close; [apply C|exact H]. Qed.

  (* (1 - u)^n is at least 1 - n u. *)
  Lemma bernoulli n : 1 - INR n * u <= p ^ n.
  Proof.
    induction n; [cbn; lra|]. rewrite S_INR. cbn [pow]. pose proof (pos_INR n). pose proof p_range.
    destruct (Rle_dec (1 - INR n * u) 0) as [N|P].
    - assert (0 <= p * p ^ n) by (apply Rmult_le_pos; [lra|left; apply pow_range]). nra.
    - apply Rle_trans with (p * (1 - INR n * u)); [unfold p; nra|apply Rmult_le_compat_l; lra].
  Qed.
  (* Logarithms of close numbers have an absolute error. *)
  Lemma close_logarithms n x y : (n <= 1000)%nat -> close n x y -> Rabs (ln x - ln y) <= INR n * u * (1 + / 1000).
  Proof.
    intros N (X & Y & A & B). apply le_INR in N. replace (INR 1000) with 1000 in N by (rewrite INR_IZR_INZ; reflexivity). pose proof (pos_INR n).
    pose proof (bernoulli n) as Be. pose proof (pow_range n) as P.
    assert (Nu : 0 <= INR n * u <= / 10000) by nra.
    assert (Lp : - ln (p ^ n) <= INR n * u * (1 + / 1000)).
    { rewrite <- ln_Rinv by lra.
      assert (E := exp_ineq1_le (INR n * u * (1 + / 1000))).
      rewrite <- (ln_exp (INR n * u * (1 + / 1000))). apply Rcomplements.ln_le; [apply Rinv_0_lt_compat; lra|].
      apply Rle_trans with (2 := E). apply (Rmult_le_reg_r (p ^ n)); [lra|]. rewrite Rinv_l by lra.
      apply Rle_trans with ((1 + INR n * u * (1 + / 1000)) * (1 - INR n * u)); [|apply Rmult_le_compat_l; nra]. nra. }
    assert (G : forall a b, 0 < a -> 0 < b -> b * p ^ n <= a -> ln b - ln a <= INR n * u * (1 + / 1000)).
    { intros a b Ha Hb H1. apply Rcomplements.ln_le in H1; [|nra]. rewrite ln_mult in H1 by lra. lra. }
    apply Rabs_le. pose proof (G x y X Y A). pose proof (G y x Y X B). lra.
  Qed.
End RoundingCounts.

(* ------------------------------------------------------------------ real numbers: nearest, least and far *)

(* The distances in the law: clamping and subtracting them. *)
Section Distances.
  Variable u : R.
  Hypothesis u_small : 0 < u <= / 16777216.
  Let p := 1 - u.
  Notation close := (close u).

  (* The larger of two numbers, of which one may be negative. *)
  Lemma max_is_close n m y N Y : close n y Y -> (0 < m -> close n N m) -> (m <= 0 -> N <= 0) ->
    close n (if Rlt_dec y N then N else y) (Rmax m Y).
  Proof.
    intros Cy Cn Neg. pose proof (pow_range u u_small n) as P. destruct Cy as (y0 & Y0 & A & B).
    destruct (Rlt_dec y N) as [Q|Q].
    - assert (m0 : 0 < m) by (apply Rnot_le_lt; intro C; apply Neg in C; lra). destruct (Cn m0) as (N0 & _ & C & D).
      unfold close, Law.close in *. unfold Rmax. destruct (Rle_dec m Y); repeat split; auto; nra.
    - unfold close, Law.close in *. destruct (Rle_dec m 0) as [m0|m0].
      + rewrite Rmax_right by lra. repeat split; auto.
      + destruct (Cn ltac:(lra)) as (N0 & _ & C & D). unfold Rmax. destruct (Rle_dec m Y); repeat split; auto; try lra; nra.
  Qed.

  (* A difference that is at least half of the minuend. *)
  Lemma difference_is_close S N s n : close 1 s S -> close 2 n N -> N <= S - N -> close 5 (s - n) (S - N).
  Proof.
    intros (s0 & S0 & A & B) (n0 & N0 & C & D) H. pose proof (p_range u u_small) as Pr. fold p in Pr, A, B, C, D. rewrite pow_1 in A, B.
    set (F := S - N) in *. replace S with (F + N) in * by (unfold F; ring). clearbody F. clear S0.
    assert (P2 : 0 < p ^ 2 <= 1) by (apply (pow_range u u_small)). assert (P5 : 0 < p ^ 5 <= 1) by (apply (pow_range u u_small)).
    assert (I1 : p ^ 7 <= 2 * p ^ 3 - 1).
    { replace p with (1 - u) by reflexivity. assert (0 <= u * u <= u / 1000) by nra. assert (0 <= u * u * u <= u / 1000) by nra.
      assert (0 <= u * u * u * u <= u / 1000) by nra. assert (0 <= u * u * u * u * u <= u / 1000) by nra.
      assert (0 <= u * u * u * u * u * u <= u / 1000) by nra. assert (0 <= u * u * u * u * u * u * u <= u / 1000) by nra. nra. }
    assert (I2 : 2 * p ^ 4 - p ^ 7 <= 1).
    { replace p with (1 - u) by reflexivity. assert (0 <= u * u <= u / 1000) by nra. assert (0 <= u * u * u <= u / 1000) by nra.
      assert (0 <= u * u * u * u <= u / 1000) by nra. assert (0 <= u * u * u * u * u <= u / 1000) by nra.
      assert (0 <= u * u * u * u * u * u <= u / 1000) by nra. assert (0 <= u * u * u * u * u * u * u <= u / 1000) by nra. nra. }
    (* n <= N / p^2 and s <= S / p, without the quotients *)
    assert (Low : F * p ^ 5 <= s - n).
    { apply (Rmult_le_reg_r (p ^ 2)); [lra|]. replace (F * p ^ 5 * p ^ 2) with (F * p ^ 7) by ring.
      assert (n * p ^ 2 <= N) by exact D. assert ((F + N) * p * p ^ 2 <= s * p ^ 2) by (apply Rmult_le_compat_r; lra).
      assert (Q : p ^ 3 <= 1) by (apply (pow_range u u_small)).
      assert (F * p ^ 7 <= F * (2 * p ^ 3 - 1)) by (apply Rmult_le_compat_l; lra).
      assert (0 <= (F - N) * (1 - p ^ 3)) by (apply Rmult_le_pos; lra).
      replace ((F + N) * p * p ^ 2) with ((F + N) * p ^ 3) in * by ring. nra. }
    assert (High : (s - n) * p ^ 5 <= F).
    { assert (s * p * p ^ 4 <= (F + N) * p ^ 4) by (apply Rmult_le_compat_r; [left; apply (pow_range u u_small)|lra]).
      assert (N * p ^ 2 * p ^ 5 <= n * p ^ 5) by (apply Rmult_le_compat_r; lra).
      assert (Q : p ^ 7 <= p ^ 4).
      { replace (p ^ 7) with (p ^ 4 * p ^ 3) by ring. assert (0 < p ^ 4 <= 1) by (apply (pow_range u u_small)). assert (0 < p ^ 3 <= 1) by (apply (pow_range u u_small)). nra. }
      assert (F * (2 * p ^ 4 - p ^ 7) <= F) by nra.
      assert (0 <= (F - N) * (p ^ 4 - p ^ 7)) by (apply Rmult_le_pos; lra).
      replace ((s - n) * p ^ 5) with (s * p * p ^ 4 - n * p ^ 5) by ring. replace (N * p ^ 2 * p ^ 5) with (N * p ^ 7) in * by ring. nra. }
    unfold close, Law.close. fold p. repeat split; try assumption; try lra. assert (0 < F * p ^ 5) by nra. lra.
  Qed.

  Lemma close_within_factor_2 n x y : (n <= 1000)%nat -> close n x y -> y / 2 <= x <= 2 * y.
  Proof.
    intros N (X & Y & A & B). fold p in A, B. pose proof (bernoulli u u_small n) as Be. fold p in Be. apply le_INR in N. replace (INR 1000) with 1000 in N by (rewrite INR_IZR_INZ; reflexivity).
    assert (1 / 2 <= p ^ n) by nra. nra.
  Qed.
End Distances.

(* ------------------------------------------------------------------ the law on the machine *)

(* The law (13) with e clamped: the distance to the nearer edge is at least clamp_share times the width. *)
Definition clamped_law (clamp_share gain a b : R) : R :=
  let near := Rmax (Rmin a b) (clamp_share * (a + b)) in
  let far := a + b - near in
  (if Rlt_dec b a then - gain else gain) * (1 / near + 1 / far) * ln (far / near).

(* The emitted statements, on floats. The edges L and U and the state x are finite and of ordinary size; a and b are the distances of x
   to the lower and the upper edge. *)
Section Machine.
  Variables prec emax : Z.
  Context (prec_gt_0_ : Prec_gt_0 prec).
  Context (prec_lt_emax_ : Prec_lt_emax prec emax).
  Hypothesis prec_large : (24 <= prec)%Z.
  Hypothesis emax_large : (128 <= emax)%Z.
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).
  Notation round_nearest := (round_nearest prec emax).
  Variable log_ : number -> number.
  Let u := unit_roundoff prec.
  Let A := machine prec emax _ _ log_.
  Notation close := (close u).

  (* The library's logarithm is within 4 units in the last place. *)
  Definition accurate : Prop := forall y : number, is_finite y = true -> 0 < value y ->
    is_finite (log_ y) = true /\ Rabs (value (log_ y) - ln (value y)) <= 8 * u * Rabs (ln (value y)).
  Variable consts : constants.

  (* The relative error of the logarithm, besides the library's. *)
  Variable log_error : R.
  Hypothesis log_error_range : 0 <= log_error <= / 8192.
  (* The logarithm of the text, the library's or one that is written out, is near ln for numbers from a little below 1 on. *)
  Definition logarithm_near : Prop := forall y : number, is_finite y = true -> 0.9 <= value y <= bpow radix2 62 ->
    is_finite (emitted_log A consts y : number) = true /\ Rabs (value (emitted_log A consts y) - ln (value y)) <= (8 * u + log_error) * Rabs (ln (value y)).
  Hypothesis log_is_near : logarithm_near.
  Hypothesis prec_small : (prec <= 64)%Z.
  Variables gain_real clamp_share_real : R.
  Variables gain_high gain_low : number. (* the gain with its sign: where the upper edge is nearer, and where the lower one is *)
  Hypothesis gain_low_value : value gain_low = gain_real /\ is_finite gain_low = true.
  Hypothesis gain_high_value : value gain_high = - gain_real /\ is_finite gain_high = true.
  Hypothesis clamp_share_value : value (decimal_number prec emax _ _ (clamp_share consts)) = clamp_share_real /\ is_finite (decimal_number prec emax _ _ (clamp_share consts)) = true.
  Hypothesis gain_range : / 1073741824 <= gain_real <= 1073741824.
  Hypothesis clamp_share_range : / 1073741824 <= clamp_share_real <= / 4.

  Variables L U x : number.
  Hypothesis finite_L : is_finite L = true.
  Hypothesis finite_U : is_finite U = true.
  Hypothesis finite_x : is_finite x = true.
  Hypothesis size_L : Rabs (value L) <= 1073741824.
  Hypothesis size_U : Rabs (value U) <= 1073741824.
  Hypothesis size_x : Rabs (value x) <= 1073741824.
  Let a := value x - value L.
  Let b := value U - value x.
  Let width := a + b.
  Hypothesis width_minimum : / 1073741824 <= width.
  Let nearest_real := Rmin a b.
  Let near_real := Rmax nearest_real (clamp_share_real * width).
  Let far_real := width - near_real.

  Lemma u_small : 0 < u <= / 16777216.
  Proof. pose proof (unit_roundoff_range prec prec_large) as H. change (IZR (2 ^ 24)) with 16777216 in H. exact H. Qed.

  Lemma below_safe_maximum v : Rabs v <= IZR (2 ^ 126) -> Rabs v <= safe_maximum emax.
  Proof. intro H. apply Rle_trans with (1 := H). unfold safe_maximum. change (IZR (2 ^ 126)) with (bpow radix2 126). apply bpow_le; lia. Qed.
  Lemma normal_relative_error v : / IZR (2 ^ 126) <= Rabs v -> Rabs (round_nearest v - v) <= u * Rabs v.
  Proof.
    intro H. apply round_nearest_relative_error; [exact prec_gt_0_|exact emax_large|]. apply Rle_trans with (2 := H).
    change (/ IZR (2 ^ 126)) with (bpow radix2 (-126)). apply Rle_refl.
  Qed.

  (* Products and quotients of close numbers of ordinary size. *)
  Lemma product_is_close n m' (v w : number) V W : is_finite v = true -> is_finite w = true -> close n (value v) V -> close m' (value w) W -> (n + m' <= 1000)%nat ->
    / IZR (2 ^ 120) <= V * W <= IZR (2 ^ 120) -> close (1 + (n + m')) (value (Bmult mode_NE v w)) (V * W) /\ is_finite (Bmult mode_NE v w) = true.
  Proof.
    intros Fv Fw Cv Cw Small [Lo Hi]. assert (C := close_mul u u_small _ _ _ _ _ _ Cv Cw). destruct (close_within_factor_2 u u_small _ _ _ Small C) as [B1 B2].
    assert (P : 0 < / IZR (2 ^ 120)) by (apply Rinv_0_lt_compat; lra).
    assert (E : Rabs (value v * value w) = value v * value w) by (apply Rabs_pos_eq; lra).
    destruct (mul_rounds prec emax _ _ prec_large emax_large v w Fv Fw) as [Q1 Q2]; [apply below_safe_maximum; rewrite E; lra|].
    split; [|exact Q2]. rewrite Q1. apply close_after_rounding with (x := value v * value w); [exact u_small|exact C|]. apply normal_relative_error. rewrite E. lra.
  Qed.
  Lemma quotient_is_close n m' (v w : number) V W : is_finite v = true -> close n (value v) V -> close m' (value w) W -> (n + m' <= 1000)%nat ->
    / IZR (2 ^ 120) <= V / W <= IZR (2 ^ 120) -> close (1 + (n + m')) (value (Bdiv mode_NE v w)) (V / W) /\ is_finite (Bdiv mode_NE v w) = true.
  Proof.
    intros Fv Cv Cw Small [Lo Hi]. assert (C := close_div u u_small _ _ _ _ _ _ Cv Cw). destruct (close_within_factor_2 u u_small _ _ _ Small C) as [B1 B2].
    assert (P : 0 < / IZR (2 ^ 120)) by (apply Rinv_0_lt_compat; lra).
    assert (E : Rabs (value v / value w) = value v / value w) by (apply Rabs_pos_eq; lra).
    assert (W0 : value w <> 0) by (destruct Cw as (W0 & _); lra).
    destruct (div_rounds prec emax _ _ prec_large emax_large v w Fv W0) as [Q1 Q2]; [apply below_safe_maximum; rewrite E; lra|].
    split; [|exact Q2]. rewrite Q1. apply close_after_rounding with (x := value v / value w); [exact u_small|exact C|]. apply normal_relative_error. rewrite E. lra.
  Qed.

  Lemma width_from_edges : width = value U - value L. Proof. unfold width, a, b. ring. Qed.
  Lemma width_maximum : width <= 2147483648.
  Proof. rewrite width_from_edges. pose proof size_U as HU. pose proof size_L as HL. apply Rabs_le_between in HU, HL. lra. Qed.
  Lemma near_real_range : clamp_share_real * width <= near_real <= width / 2 /\ near_real <= far_real.
  Proof.
    assert (nearest_real <= width / 2) by (unfold nearest_real, Rmin, width; destruct Rle_dec; lra).
    pose proof clamp_share_range as [C1 C2]. pose proof width_minimum as W. assert (clamp_share_real * width <= width / 4) by nra.
    assert (clamp_share_real * width <= near_real <= width / 2) by (unfold near_real, Rmax; destruct Rle_dec; lra). unfold far_real. lra.
  Qed.

  (* The machine's values, each with the real number that it is close to. *)
  Let machine_width := sub A U L.
  Lemma machine_width_close : close 1 (value machine_width) width /\ is_finite machine_width = true.
  Proof.
    pose proof width_minimum as W. pose proof width_maximum as Wz. rewrite width_from_edges in W, Wz. assert (Rabs (value U - value L) = value U - value L) as E by (apply Rabs_pos_eq; lra).
    destruct (sub_rounds prec emax _ _ prec_large emax_large U L finite_U finite_L) as [Q1 Q2].
    { apply below_safe_maximum. rewrite E. assert (IZR (2 ^ 126) = 85070591730234615865843651857942052864) as -> by reflexivity. lra. }
    split; [|exact Q2]. change (value machine_width) with (value (Bminus mode_NE U L)). rewrite Q1, width_from_edges. apply rounding_is_close; [exact u_small|lra|].
    apply difference_relative_error; try apply number_format; assumption.
  Qed.

  Lemma differences_round : value (sub A x L) = round_nearest a /\ is_finite (sub A x L) = true /\ value (sub A U x) = round_nearest b /\ is_finite (sub A U x) = true.
  Proof.
    pose proof size_U as HU. pose proof size_L as HL. pose proof size_x as Hx. apply Rabs_le_between in HU, HL, Hx.
    assert (IZR (2 ^ 126) = 85070591730234615865843651857942052864) as Z126 by reflexivity.
    destruct (sub_rounds prec emax _ _ prec_large emax_large x L finite_x finite_L) as [Q1 Q2].
    { apply below_safe_maximum. rewrite Z126. apply Rabs_le; lra. }
    destruct (sub_rounds prec emax _ _ prec_large emax_large U x finite_U finite_x) as [Q3 Q4].
    { apply below_safe_maximum. rewrite Z126. apply Rabs_le; lra. }
    auto.
  Qed.

  Lemma upper_nearer_correct : (upper_nearer A L U x = true -> b < a) /\ (upper_nearer A L U x = false -> round_nearest a <= round_nearest b).
  Proof.
    destruct differences_round as (D1 & D2 & D3 & D4).
    assert (H := less_is_real_order prec emax (sub A U x) (sub A x L) D4 D2). rewrite D1, D3 in H.
    unfold upper_nearer. change (less_than A (sub A U x) (sub A x L)) with (Bltb (sub A U x) (sub A x L)). split; intro E.
    - apply H in E. apply Rnot_le_lt; intro C. apply (round_nearest_le prec emax prec_gt_0_) in C. lra.
    - apply Rnot_lt_le; intro C. apply H in C. congruence.
  Qed.

  Lemma nearest_distance_rounds : value (nearest_distance A L U x) = round_nearest nearest_real /\ is_finite (nearest_distance A L U x) = true.
  Proof.
    destruct differences_round as (D1 & D2 & D3 & D4). destruct upper_nearer_correct as [N1 N2]. unfold nearest_distance. destruct (upper_nearer A L U x).
    - specialize (N1 eq_refl). rewrite D3. unfold nearest_real. rewrite Rmin_right by lra. auto.
    - specialize (N2 eq_refl). rewrite D1. split; [|exact D2]. unfold nearest_real, Rmin. destruct (Rle_dec a b) as [Q|Q]; [reflexivity|].
      apply Rle_antisym; [exact N2|]. apply round_nearest_le; [exact prec_gt_0_|lra].
  Qed.

  Let machine_clamped := mul A machine_width (decimal_number prec emax _ _ (clamp_share consts)).
  Lemma machine_clamped_close : close 2 (value machine_clamped) (clamp_share_real * width) /\ is_finite machine_clamped = true.
  Proof.
    destruct machine_width_close as [R1 R2]. destruct clamp_share_value as [C1 C2]. pose proof width_minimum as W. pose proof width_maximum as Wz. pose proof clamp_share_range as Cr.
    assert (Z120 : IZR (2 ^ 120) = 1329227995784915872903807060280344576) by reflexivity.
    rewrite (Rmult_comm clamp_share_real width). change machine_clamped with (Bmult mode_NE machine_width (decimal_number prec emax _ _ (clamp_share consts))).
    change 2%nat with (1 + (1 + 0))%nat. apply product_is_close; [exact R2|exact C2|exact R1|rewrite C1; apply close_refl; [exact u_small|lra]|lia|].
    rewrite Z120. assert (/ 1073741824 * / 1073741824 <= width * clamp_share_real) by (apply Rmult_le_compat; lra). assert (width * clamp_share_real <= 2147483648 * 1) by (apply Rmult_le_compat; lra). lra.
  Qed.

  Let machine_near := near_distance A consts L U x.
  Lemma machine_near_close : close 2 (value machine_near) near_real /\ is_finite machine_near = true.
  Proof.
    destruct machine_clamped_close as [L1 L2]. destruct nearest_distance_rounds as [M1 M2].
    assert (H := less_is_real_order prec emax machine_clamped (nearest_distance A L U x) L2 M2).
    assert (V : value machine_near = (if Rlt_dec (value machine_clamped) (round_nearest nearest_real) then round_nearest nearest_real else value machine_clamped) /\ is_finite machine_near = true).
    { unfold machine_near, near_distance. cbv zeta. change (mul A (sub A U L) (literal A (clamp_share consts))) with machine_clamped.
      change (less_than A machine_clamped (nearest_distance A L U x)) with (Bltb machine_clamped (nearest_distance A L U x)). rewrite M1 in H. destruct (Bltb machine_clamped (nearest_distance A L U x)).
      - split; [|exact M2]. rewrite M1. destruct (Rlt_dec (value machine_clamped) (round_nearest nearest_real)) as [Q|Q]; [reflexivity|]. exfalso; apply Q, H; reflexivity.
      - split; [|exact L2]. destruct (Rlt_dec (value machine_clamped) (round_nearest nearest_real)) as [Q|Q]; [|reflexivity]. apply H in Q. discriminate. }
    destruct V as [V1 V2]. split; [|exact V2]. rewrite V1. unfold near_real. apply max_is_close; [exact u_small|exact L1| |].
    - intro m0. apply close_weaken with 1%nat; [exact u_small|lia|]. apply rounding_is_close; [exact u_small|exact m0|].
      unfold nearest_real, Rmin. destruct (Rle_dec a b); apply difference_relative_error; try apply number_format; assumption.
    - intro m0. rewrite <- (round_nearest_0 prec emax). apply round_nearest_le; [exact prec_gt_0_|exact m0].
  Qed.

  Let machine_far := far_distance A consts L U x.
  Lemma machine_far_close : close 6 (value machine_far) far_real /\ is_finite machine_far = true.
  Proof.
    destruct machine_width_close as [R1 R2]. destruct machine_near_close as [N1 N2]. destruct near_real_range as [Nr Nf].
    assert (D : close 5 (value machine_width - value machine_near) far_real) by (apply difference_is_close; [exact u_small|exact R1|exact N1|exact Nf]).
    destruct (close_within_factor_2 u u_small 5 _ _ ltac:(lia) D) as [D1 D2]. pose proof width_maximum as Wz. pose proof clamp_share_range. pose proof width_minimum.
    assert (P : 0 < value machine_width - value machine_near) by apply D.
    destruct (sub_rounds prec emax _ _ prec_large emax_large machine_width machine_near R2 N2) as [Q1 Q2].
    { apply below_safe_maximum. rewrite Rabs_pos_eq by lra. assert (IZR (2 ^ 126) = 85070591730234615865843651857942052864) as -> by reflexivity. assert (0 < clamp_share_real * width) by nra. unfold far_real in *. lra. }
    split; [|exact Q2]. change (value machine_far) with (value (Bminus mode_NE machine_width machine_near)). rewrite Q1. apply close_after_rounding with (x := value machine_width - value machine_near); [exact u_small|exact D|].
    apply difference_relative_error; try apply number_format; assumption.
  Qed.

  Lemma distance_ranges : / 1073741824 * / 1073741824 <= near_real /\ near_real <= far_real /\ far_real <= 2147483648 /\ 1 <= far_real / near_real <= 1073741824.
  Proof.
    destruct near_real_range as [[N1 N2] N3]. pose proof width_maximum as Wz. pose proof clamp_share_range as Cr. pose proof width_minimum as W.
    assert (/ 1073741824 * / 1073741824 <= clamp_share_real * width) by (apply Rmult_le_compat; lra).
    assert (N0 : 0 < near_real) by lra. repeat split; try (unfold far_real in *; lra).
    - apply Rcomplements.Rle_div_r; lra.
    - apply Rcomplements.Rle_div_l; [lra|]. assert (width <= 1073741824 * (clamp_share_real * width)) by nra. unfold far_real in *. nra.
  Qed.

  Let machine_ratio := distance_ratio A consts L U x.
  Lemma machine_ratio_close : close 9 (value machine_ratio) (far_real / near_real) /\ is_finite machine_ratio = true.
  Proof.
    destruct machine_near_close as [N1 N2]. destruct machine_far_close as [F1 F2]. destruct distance_ranges as (S1 & S2 & S3 & S4).
    assert (Z120 : IZR (2 ^ 120) = 1329227995784915872903807060280344576) by reflexivity.
    change 9%nat with (1 + (6 + 2))%nat. change machine_ratio with (Bdiv mode_NE machine_far machine_near). apply quotient_is_close; [exact F2|exact F1|exact N1|lia|rewrite Z120; lra].
  Qed.

  Let xi_real := 1 / near_real + 1 / far_real.
  Lemma xi_real_range : / 2147483648 <= xi_real <= 2305843009213693952.
  Proof.
    destruct distance_ranges as (S1 & S2 & S3 & S4). unfold xi_real, Rdiv. rewrite !Rmult_1_l. assert (0 < near_real) by lra.
    assert (/ 2147483648 <= / far_real) by (apply Rinv_le_contravar; lra). assert (0 < / near_real) by (apply Rinv_0_lt_compat; lra).
    assert (/ far_real <= / near_real) by (apply Rinv_le_contravar; lra).
    assert (/ near_real <= 1152921504606846976).
    { replace 1152921504606846976 with (/ (/ 1073741824 * / 1073741824)) by lra. apply Rinv_le_contravar; lra. }
    lra.
  Qed.

  Let machine_xi := xi A consts L U x.
  Lemma machine_xi_close : close 17 (value machine_xi) xi_real /\ is_finite machine_xi = true.
  Proof.
    destruct machine_ratio_close as [R1 R2]. destruct machine_far_close as [F1 F2]. destruct distance_ranges as (S1 & S2 & S3 & S4). pose proof xi_real_range as Xr.
    assert (Z120 : IZR (2 ^ 120) = 1329227995784915872903807060280344576) by reflexivity.
    assert (Z126 : IZR (2 ^ 126) = 85070591730234615865843651857942052864) by reflexivity.
    destruct (integer_literal_exact prec emax _ _ prec_large emax_large literal_one 1 ltac:(lia) ltac:(reflexivity)) as [O1 O2].
    assert (C : close 9 (1 + value machine_ratio) (1 + far_real / near_real)) by (apply close_add; [apply close_refl; [exact u_small|lra]|exact R1]).
    destruct (close_within_factor_2 u u_small 9 _ _ ltac:(lia) C) as [B1 B2].
    assert (E : Rabs (1 + value machine_ratio) = 1 + value machine_ratio) by (apply Rabs_pos_eq; lra).
    destruct (add_rounds prec emax _ _ prec_large emax_large _ machine_ratio O2 R2) as [Q1 Q2]; [rewrite O1; apply below_safe_maximum; rewrite E; lra|]. rewrite O1 in Q1.
    set (sum := Bplus mode_NE (decimal_number prec emax prec_gt_0_ prec_lt_emax_ literal_one) machine_ratio) in *.
    assert (Cs : close 10 (value sum) (1 + far_real / near_real)).
    { rewrite Q1. apply close_after_rounding with (x := 1 + value machine_ratio); [exact u_small|exact C|]. apply normal_relative_error. rewrite E, Z126. lra. }
    assert (EX : xi_real = (1 + far_real / near_real) / far_real) by (unfold xi_real; field; lra). rewrite EX in *.
    change 17%nat with (1 + (10 + 6))%nat. change machine_xi with (Bdiv mode_NE sum machine_far). apply quotient_is_close; [exact Q2|exact Cs|exact F1|lia|rewrite Z120; lra].
  Qed.

  Let log_real := ln (far_real / near_real).
  Lemma log_real_range : 0 <= log_real <= 1073741824.
  Proof.
    destruct distance_ranges as (S1 & S2 & S3 & S4). unfold log_real. split; [rewrite <- ln_1; apply Rcomplements.ln_le; lra|].
    assert (H := exp_ineq1_le (far_real / near_real)). assert (Q : ln (far_real / near_real) <= far_real / near_real).
    { rewrite <- (ln_exp (far_real / near_real)) at 2. apply Rcomplements.ln_le; lra. }
    lra.
  Qed.

  Let machine_log : number := emitted_log A consts machine_ratio.
  Lemma machine_log_near : Rabs (value machine_log - log_real) <= u * (10 + 9 * log_real) + log_error * log_real /\ is_finite machine_log = true.
  Proof.
    destruct machine_ratio_close as [R1 R2]. destruct (close_within_factor_2 u u_small 9 _ _ ltac:(lia) R1) as [_ R3]. destruct distance_ranges as (_ & _ & _ & S4). pose proof log_error_range as Lr.
    assert (R4 : 0.9 <= value machine_ratio <= bpow radix2 62).
    { split; [|change (bpow radix2 62) with 4611686018427387904; lra]. destruct R1 as (_ & _ & R1 & _). pose proof (bernoulli u u_small 9) as Be. replace (INR 9) with 9 in Be by (cbn; lra).
      pose proof u_small as Us. apply Rle_trans with (2 := R1). apply Rle_trans with (1 * (1 - 9 * u)); [lra|apply Rmult_le_compat; lra]. }
    destruct (log_is_near machine_ratio R2 R4) as [G1 G2]. split; [|exact G1].
    assert (D := close_logarithms u u_small 9 _ _ ltac:(lia) R1). fold log_real in D. replace (INR 9) with 9 in D by (cbn; lra).
    fold machine_log in G2. pose proof log_real_range as Er. pose proof u_small as Us.
    replace (value machine_log - log_real) with ((value machine_log - ln (value machine_ratio)) + (ln (value machine_ratio) - log_real)) by ring.
    eapply Rle_trans; [apply Rabs_triang|].
    assert (Rabs (ln (value machine_ratio)) <= log_real + 1).
    { replace (ln (value machine_ratio)) with ((ln (value machine_ratio) - log_real) + log_real) by ring. eapply Rle_trans; [apply Rabs_triang|]. rewrite (Rabs_pos_eq log_real) by lra. lra. }
    assert (H2 : Rabs (ln (value machine_ratio)) <= log_real + 9 * u * (1 + / 1000)).
    { replace (ln (value machine_ratio)) with ((ln (value machine_ratio) - log_real) + log_real) by ring. eapply Rle_trans; [apply Rabs_triang|]. rewrite (Rabs_pos_eq log_real) by lra. lra. }
    assert (8 * u * Rabs (ln (value machine_ratio)) <= 8 * u * (log_real + 9 * u * (1 + / 1000))) by (apply Rmult_le_compat_l; lra).
    assert (log_error * Rabs (ln (value machine_ratio)) <= log_error * (log_real + 9 * u * (1 + / 1000))) by (apply Rmult_le_compat_l; lra).
    assert (log_error * (9 * u * (1 + / 1000)) <= / 8192 * (9 * u * (1 + / 1000))) by (apply Rmult_le_compat_r; lra).
    assert (8 * u * (9 * u * (1 + / 1000)) <= / 1000000 * (9 * u * (1 + / 1000))) by (apply Rmult_le_compat_r; lra).
    assert (0 <= u * log_real) by (apply Rmult_le_pos; lra). lra.
  Qed.

  (* The sign of the input: the machine takes the upper edge for the nearer one, or not. *)
  Let machine_side := if upper_nearer A L U x then -1 else 1.

  Lemma factor_times_log_near v K e : close 18 v K -> Rabs (e - log_real) <= u * (10 + 9 * log_real) + log_error * log_real -> / 1152921504606846976 / 2 <= K ->
    Rabs (v * e - K * log_real) <= u * K * (11 + 28 * log_real) + 1.001 * log_error * (K * log_real).
  Proof.
    intros (v0 & K0 & C1 & C2) He HK. pose proof (bernoulli u u_small 18) as Be. replace (INR 18) with 18 in Be by (cbn; lra).
    pose proof u_small as Us. pose proof log_real_range as Er. pose proof log_error_range as Lr.
    assert (D1 : Rabs (v - K) <= u * K * 18.1).
    { assert (K * (1 - 18 * u) <= v) by (apply Rle_trans with (2 := C1); apply Rmult_le_compat_l; lra). assert (v * (1 - 18 * u) <= K) by (apply Rle_trans with (2 := C2); apply Rmult_le_compat_l; lra).
      assert (v <= K * (1 + 18.1 * u)).
      { apply (Rmult_le_reg_r (1 - 18 * u)); [lra|]. assert (K * (1 - (1 + 18.1 * u) * (1 - 18 * u)) <= 0); [|lra]. 
        assert (0 <= u * (0.1 - 325.8 * u)) by (apply Rmult_le_pos; lra).
        assert (0 <= K * (u * (0.1 - 325.8 * u))) by (apply Rmult_le_pos; lra). lra. }
      apply Rabs_le. lra. }
    replace (v * e - K * log_real) with (K * (e - log_real) + (v - K) * log_real + (v - K) * (e - log_real)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_mult with (x := v - K).
    assert (Q1 : Rabs (K * (e - log_real) + (v - K) * log_real) <= K * (u * (10 + 9 * log_real) + log_error * log_real) + u * K * 18.1 * log_real).
    { eapply Rle_trans; [apply Rabs_triang|]. rewrite !Rabs_mult. rewrite (Rabs_pos_eq K), (Rabs_pos_eq log_real) by lra.
      apply Rplus_le_compat; [apply Rmult_le_compat_l; lra|apply Rmult_le_compat_r; lra]. }
    assert (Q2 : Rabs (v - K) * Rabs (e - log_real) <= (u * K * 18.1) * (u * (10 + 9 * log_real) + log_error * log_real)) by (apply Rmult_le_compat; try apply Rabs_pos; assumption).
    assert (Kp : 0 < u * K) by (apply Rmult_lt_0_compat; lra). assert (0 <= u * K * log_real) by (apply Rmult_le_pos; lra).
    assert (Q3 : (u * K * 18.1) * (u * (10 + 9 * log_real) + log_error * log_real) <= u * K * (0.01 + 0.01 * log_real) + 0.001 * log_error * (K * log_real)).
    { replace ((u * K * 18.1) * (u * (10 + 9 * log_real) + log_error * log_real)) with (u * K * (18.1 * (u * (10 + 9 * log_real))) + 18.1 * u * (log_error * (K * log_real))) by ring.
      replace (0.001 * log_error * (K * log_real)) with (0.001 * (log_error * (K * log_real))) by ring.
      apply Rplus_le_compat; [apply Rmult_le_compat_l; [lra|]|apply Rmult_le_compat_r; [apply Rmult_le_pos; [lra|apply Rmult_le_pos; lra]|lra]].
      assert (u * (10 + 9 * log_real) <= / 16777216 * (10 + 9 * log_real)) by (apply Rmult_le_compat_r; lra). lra. }
    lra.
  Qed.

  (* The machine's input is near the law, with the machine's sign. *)
  Lemma unlimited_input_near : Rabs (value (unlimited_input A consts gain_high gain_low L U x) - machine_side * (gain_real * xi_real * log_real)) <= u * (gain_real * xi_real) * (12 + 30 * log_real) + 1.01 * log_error * (gain_real * xi_real * log_real) /\ is_finite (unlimited_input A consts gain_high gain_low L U x) = true.
  Proof.
    destruct machine_xi_close as [X1 X2]. destruct machine_log_near as [G1 G2]. pose proof xi_real_range as Xr. pose proof log_real_range as Er. pose proof gain_range as Gr. pose proof u_small as Us. pose proof log_error_range as Lr.
    destruct gain_low_value as [L1 L2]. destruct gain_high_value as [U1 U2].
    assert (Z126 : IZR (2 ^ 126) = 85070591730234615865843651857942052864) by reflexivity.
    set (K := gain_real * xi_real).
    assert (Kr : / 1152921504606846976 / 2 <= K <= 2475880078570760549798248448).
    { unfold K. split; [|assert (gain_real * xi_real <= 1073741824 * 2305843009213693952) by (apply Rmult_le_compat; lra); lra].
      assert (/ 1073741824 * / 2147483648 <= gain_real * xi_real) by (apply Rmult_le_compat; lra). lra. }
    set (g := chosen_gain A gain_high gain_low L U x).
    assert (Gv : value g = machine_side * gain_real /\ is_finite g = true).
    { unfold g, chosen_gain, machine_side. destruct (upper_nearer A L U x); [rewrite U1|rewrite L1]; split; auto; ring. }
    assert (Side : machine_side = 1 \/ machine_side = -1) by (unfold machine_side; destruct upper_nearer; auto).
    assert (Sa : Rabs machine_side = 1) by (destruct Side as [-> | ->]; [apply Rabs_R1|rewrite Rabs_left; lra]).
    assert (Odd : forall z, round_nearest (machine_side * z) = machine_side * round_nearest z).
    { intro z. destruct Side as [-> | ->]; [now rewrite !Rmult_1_l|]. replace (-1 * z) with (- z) by ring. rewrite round_nearest_opp. ring. }
    destruct Gv as [Gv Gf].
    (* gain times xi *)
    assert (C : close 17 (gain_real * value machine_xi) K).
    { unfold K. change 17%nat with (0 + 17)%nat. apply close_mul; [exact u_small|apply close_refl; [exact u_small|lra]|exact X1]. }
    destruct (close_within_factor_2 u u_small 17 _ _ ltac:(lia) C) as [B1 B2].
    assert (Ez : Rabs (value g * value machine_xi) = gain_real * value machine_xi).
    { rewrite Gv. replace (machine_side * gain_real * value machine_xi) with (machine_side * (gain_real * value machine_xi)) by ring. rewrite Rabs_mult, Sa, Rmult_1_l. apply Rabs_pos_eq. lra. }
    destruct (mul_rounds prec emax _ _ prec_large emax_large g machine_xi Gf X2) as [M1 M2]; [apply below_safe_maximum; rewrite Ez, Z126; lra|].
    set (gx := Bmult mode_NE g machine_xi) in *.
    assert (Cg : close 18 (round_nearest (gain_real * value machine_xi)) K).
    { apply close_after_rounding with (x := gain_real * value machine_xi); [exact u_small|exact C|]. apply normal_relative_error. rewrite Rabs_pos_eq, Z126 by lra. lra. }
    rewrite Gv, Rmult_assoc, Odd in M1. set (v := round_nearest (gain_real * value machine_xi)) in *.
    (* times epsilon *)
    assert (P := factor_times_log_near v K (value machine_log) Cg G1 ltac:(lra)).
    set (e := value machine_log) in *.
    assert (Kp : 0 < u * K) by (apply Rmult_lt_0_compat; lra). assert (KE : 0 <= K * log_real) by (apply Rmult_le_pos; lra). assert (KEb : u * (K * log_real) <= 1 * (K * log_real)) by (apply Rmult_le_compat_r; lra).
    replace (1.001 * log_error * (K * log_real)) with (1.001 * (log_error * (K * log_real))) in P by ring. replace (1.01 * log_error * (K * log_real)) with (1.01 * (log_error * (K * log_real))) by ring. set (W := log_error * (K * log_real)) in *.
    assert (Wr : 0 <= W <= K * log_real) by (unfold W; split; [apply Rmult_le_pos; lra|apply Rle_trans with (1 * (K * log_real)); [apply Rmult_le_compat_r; lra|lra]]). clearbody W.
    assert (Pz : Rabs (v * e) <= K * log_real + u * K * (11 + 28 * log_real) + 1.001 * W).
    { replace (v * e) with (K * log_real + (v * e - K * log_real)) by ring. eapply Rle_trans; [apply Rabs_triang|]. rewrite (Rabs_pos_eq (K * log_real)) by lra. lra. }
    destruct (opp_is_exact prec emax machine_log) as [O1 O2].
    set (eps := Bopp machine_log) in *.
    assert (Ev : value gx * value eps = - machine_side * (v * e)).
    { rewrite M1, O1. fold e. ring. }
    assert (Ea : Rabs (value gx * value eps) <= IZR (2 ^ 126)).
    { rewrite Ev, Rabs_mult, Rabs_Ropp, Sa, Rmult_1_l, Z126. 
      assert (K * log_real <= 2475880078570760549798248448 * 1073741824) by (apply Rmult_le_compat; lra).
      assert (u * K <= 1 * K) by (apply Rmult_le_compat_r; lra). assert (u * K * (11 + 28 * log_real) <= K * (11 + 28 * log_real)) by (apply Rmult_le_compat_r; lra). lra. }
    destruct (mul_rounds prec emax _ _ prec_large emax_large gx eps M2 ltac:(rewrite O2; exact G2)) as [T1 T2]; [now apply below_safe_maximum|].
    set (product := Bmult mode_NE gx eps) in *.
    destruct (opp_is_exact prec emax product) as [W1 W2].
    change (unlimited_input A consts gain_high gain_low L U x) with (Bopp product). rewrite W1, W2. split; [|exact T2].
    rewrite T1, Ev. replace (- machine_side * (v * e)) with (- (machine_side * (v * e))) by ring. rewrite round_nearest_opp, Odd, Ropp_involutive.
    rewrite <- Rmult_minus_distr_l, Rabs_mult, Sa, Rmult_1_l.
    replace (round_nearest (v * e) - K * log_real) with ((round_nearest (v * e) - v * e) + (v * e - K * log_real)) by ring.
    eapply Rle_trans; [apply Rabs_triang|].
    assert (Re := round_nearest_error prec emax prec_gt_0_ prec_large emax_large (v * e)). fold u in Re.
    assert (Ti : underflow_error <= u * K * / 100).
    { assert (Ub : bpow radix2 (-64) <= u) by (apply bpow_le; lia). unfold underflow_error.
      replace (bpow radix2 (-150)) with (bpow radix2 (-64) * bpow radix2 (-86)) by (rewrite <- bpow_plus; reflexivity).
      assert (B86 : bpow radix2 (-86) = / 77371252455336267181195264) by reflexivity. rewrite B86.
      pose proof (bpow_gt_0 radix2 (-64)). rewrite Rmult_assoc. apply Rmult_le_compat; lra. }
    assert (Rabs (v * e) * u <= (K * log_real + u * K * (11 + 28 * log_real) + 1.001 * W) * u) by (apply Rmult_le_compat_r; lra).
    assert (1.001 * W * u <= 1.001 * W * 0.001) by (apply Rmult_le_compat_l; lra).
    assert (u * K * (11 + 28 * log_real) * u <= u * K * (0.1 + 0.1 * log_real)).
    { replace (u * K * (11 + 28 * log_real) * u) with (u * K * (u * (11 + 28 * log_real))) by ring. apply Rmult_le_compat_l; [lra|].
      apply Rle_trans with (/ 16777216 * (11 + 28 * log_real)); [apply Rmult_le_compat_r; lra|lra]. }
    assert (0 <= u * (K * log_real)) by (apply Rmult_le_pos; lra). lra.
  Qed.

  (* The machine's input is the law (13) with e clamped, up to 30 u + 1.01 log_error in relative terms and in epsilon. *)
  Theorem unlimited_input_near_clamped_law : Rabs (value (unlimited_input A consts gain_high gain_low L U x) - clamped_law clamp_share_real gain_real a b) <= (30 * u + 1.01 * log_error) * (gain_real * xi_real) * (1 + log_real) /\ is_finite (unlimited_input A consts gain_high gain_low L U x) = true.
  Proof.
    destruct unlimited_input_near as [P Fi]. split; [|exact Fi]. pose proof xi_real_range as Xr. pose proof log_real_range as Er. pose proof gain_range as Gr. pose proof u_small as Us.
    destruct upper_nearer_correct as [N1 N2]. destruct distance_ranges as (S1 & S2 & S3 & S4). pose proof log_error_range as Lr.
    assert (Kp : 0 < gain_real * xi_real) by (apply Rmult_lt_0_compat; lra). assert (Lk : 0 <= log_error * (gain_real * xi_real)) by (apply Rmult_le_pos; lra). assert (0 <= log_error * (gain_real * xi_real) * log_real) by (apply Rmult_le_pos; lra). assert (Up : 0 < u * (gain_real * xi_real)) by (apply Rmult_lt_0_compat; lra). assert (0 <= u * (gain_real * xi_real) * log_real) by (apply Rmult_le_pos; lra).
    assert (Law : clamped_law clamp_share_real gain_real a b = (if Rlt_dec b a then -1 else 1) * (gain_real * xi_real * log_real)).
    { unfold clamped_law. cbv zeta. fold width. fold nearest_real. fold near_real. fold far_real. fold xi_real. fold log_real. destruct (Rlt_dec b a); ring. }
    rewrite Law. unfold machine_side in P. destruct (upper_nearer A L U x).
    - destruct (Rlt_dec b a) as [Q|Q]; [|specialize (N1 eq_refl); lra]. eapply Rle_trans; [exact P|lra].
    - specialize (N2 eq_refl). destruct (Rlt_dec b a) as [Q|Q]; [|eapply Rle_trans; [exact P|lra]].
      (* the distances are equal after rounding: the logarithm is near 0, and a wrong sign does not matter *)
      assert (Eq : round_nearest a = round_nearest b) by (apply Rle_antisym; [exact N2|apply round_nearest_le; [exact prec_gt_0_|lra]]).
      assert (b0 : 0 < b).
      { apply Rnot_le_lt; intro C. assert (R0 : round_nearest b <= 0) by (rewrite <- (round_nearest_0 prec emax); now apply round_nearest_le). 
        assert (D := difference_relative_error prec emax prec_gt_0_ prec_large (value x) (value L) (number_format _ _ _) (number_format _ _ _)). fold a in D. fold u in D.
        pose proof width_minimum as Wd. unfold width in Wd. rewrite Rabs_pos_eq with (x := a) in D by lra. apply Rabs_le_between in D.
        assert (u * a <= / 16777216 * a) by (apply Rmult_le_compat_r; lra). lra. }
      assert (Ca : close 1 (round_nearest a) a) by (apply rounding_is_close; [exact u_small|lra|apply difference_relative_error; try apply number_format; assumption]).
      assert (Cb : close 1 (round_nearest b) b) by (apply rounding_is_close; [exact u_small|lra|apply difference_relative_error; try apply number_format; assumption]).
      rewrite Eq in Ca. assert (Cab : close 2 a b) by (change 2%nat with (1 + 1)%nat; apply close_trans with (y := round_nearest b); [exact u_small|apply close_sym; first [exact u_small|exact Ca]|exact Cb]).
      assert (Nm : near_real = b /\ far_real = a).
      { assert (nearest_real = b) as Mb by (unfold nearest_real; apply Rmin_right; lra). destruct (close_within_factor_2 u u_small 2 _ _ ltac:(lia) Cab) as [B1 B2].
        assert (clamp_share_real * width <= b) by (pose proof clamp_share_range; unfold width; nra). assert (near_real = b) by (unfold near_real; rewrite Mb; apply Rmax_left; lra). split; [assumption|]. unfold far_real, width. lra. }
      assert (Es : log_real <= 3 * u).
      { unfold log_real. destruct Nm as [-> ->]. assert (D := close_logarithms u u_small 2 _ _ ltac:(lia) Cab). replace (INR 2) with 2 in D by (cbn; lra).
        assert (Q2 : ln (a / b) = ln a - ln b) by (unfold Rdiv; rewrite ln_mult, ln_Rinv by (try apply Rinv_0_lt_compat; lra); ring). rewrite Q2.
        apply Rabs_le_between in D. lra. }
      replace (value (unlimited_input A consts gain_high gain_low L U x) - -1 * (gain_real * xi_real * log_real)) with ((value (unlimited_input A consts gain_high gain_low L U x) - 1 * (gain_real * xi_real * log_real)) + 2 * (gain_real * xi_real * log_real)) by ring.
      eapply Rle_trans; [apply Rabs_triang|]. rewrite (Rabs_pos_eq (2 * (gain_real * xi_real * log_real))) by (apply Rmult_le_pos; [lra|apply Rmult_le_pos; lra]).
      assert (gain_real * xi_real * log_real <= gain_real * xi_real * (3 * u)) by (apply Rmult_le_compat_l; lra). lra.
  Qed.

  (* The same in the terms of HeldInputLaw.v: an error of the factor and an error of the logarithm. *)
  Theorem unlimited_input_acts_as_law : HeldInputLaw.acts_as_law gain_real clamp_share_real (32 * u + 1.03 * log_error) None a b (value (unlimited_input A consts gain_high gain_low L U x)) /\ is_finite (unlimited_input A consts gain_high gain_low L U x) = true.
  Proof.
    destruct unlimited_input_near_clamped_law as [P Fi]. split; [|exact Fi]. pose proof xi_real_range as Xr. pose proof log_real_range as Er. pose proof gain_range as Gr. pose proof u_small as Us.
    set (w := value (unlimited_input A consts gain_high gain_low L U x)) in *. assert (Kp : 0 < gain_real * xi_real) by (apply Rmult_lt_0_compat; lra).
    set (sign := if Rlt_dec b a then -1 else 1). assert (Sg : sign * sign = 1 /\ Rabs sign = 1).
    { unfold sign. destruct (Rlt_dec b a); split; try ring; [rewrite Rabs_left; lra|apply Rabs_R1]. }
    assert (Law : clamped_law clamp_share_real gain_real a b = sign * (gain_real * xi_real * log_real)).
    { unfold clamped_law, sign. cbv zeta. fold width. fold nearest_real. fold near_real. fold far_real. fold xi_real. fold log_real. destruct (Rlt_dec b a); ring. }
    rewrite Law in P. set (d := (sign * w / (gain_real * xi_real) - log_real) / (1 + log_real)).
    pose proof log_error_range as Lr. assert (D : Rabs d <= 30 * u + 1.01 * log_error).
    { unfold d. assert (Q : sign * w / (gain_real * xi_real) - log_real = sign * (w - sign * (gain_real * xi_real * log_real)) * / (gain_real * xi_real)).
      { replace (sign * (w - sign * (gain_real * xi_real * log_real))) with (sign * w - sign * sign * (gain_real * xi_real * log_real)) by ring. destruct Sg as [-> _]. field. lra. }
      rewrite Q. unfold Rdiv. rewrite !Rabs_mult. destruct Sg as [_ ->].
      rewrite (Rabs_pos_eq (/ (gain_real * xi_real))) by (left; apply Rinv_0_lt_compat; lra). rewrite (Rabs_pos_eq (/ (1 + log_real))) by (left; apply Rinv_0_lt_compat; lra).
      apply (Rmult_le_reg_r ((gain_real * xi_real) * (1 + log_real))); [apply Rmult_lt_0_compat; lra|].
      replace (1 * Rabs (w - sign * (gain_real * xi_real * log_real)) * / (gain_real * xi_real) * / (1 + log_real) * (gain_real * xi_real * (1 + log_real))) with (Rabs (w - sign * (gain_real * xi_real * log_real))) by (field; lra).
      eapply Rle_trans; [exact P|]. right; ring. }
    assert (Db := D). apply Rabs_le_between in Db.
    assert (W : w = sign * (gain_real * xi_real * (1 + d) * (log_real + d / (1 + d)))).
    { replace (gain_real * xi_real * (1 + d) * (log_real + d / (1 + d))) with (gain_real * xi_real * (log_real + d * (1 + log_real))) by (field; lra). unfold d.
      replace ((sign * w / (gain_real * xi_real) - log_real) / (1 + log_real) * (1 + log_real)) with (sign * w / (gain_real * xi_real) - log_real) by (field; lra).
      replace (sign * (gain_real * xi_real * (log_real + (sign * w / (gain_real * xi_real) - log_real)))) with (sign * sign * w) by (field; lra). destruct Sg as [-> _]. ring. }
    exists d, (d / (1 + d)). split; [lra|split].
    - unfold Rdiv. rewrite Rabs_mult, (Rabs_pos_eq (/ (1 + d))) by (left; apply Rinv_0_lt_compat; lra).
      apply (Rmult_le_reg_r (1 + d)); [lra|]. rewrite Rmult_assoc, Rinv_l, Rmult_1_r by lra. apply Rle_trans with ((32 * u + 1.03 * log_error) * 0.999); [lra|apply Rmult_le_compat_l; lra].
    - unfold HeldInputLaw.limit_input. rewrite W. unfold HeldInputLaw.law_magnitude, HeldInputLaw.clamped_near_distance. fold width. fold nearest_real. fold near_real. fold far_real. fold log_real. unfold HeldInputLaw.side_sign, sign, xi_real. destruct (Rlt_dec b a); ring.
  Qed.

  (* Limiting an input is exact: comparisons and a change of sign lose nothing. *)
  Lemma saturate_value (limit v : number) : is_finite limit = true -> is_finite v = true -> 0 <= value limit ->
    value (saturate A limit v) = HeldInputLaw.limit_input (Some (value limit)) (value v) /\ is_finite (saturate A limit v) = true.
  Proof.
    intros Fm Fv m0. destruct (opp_is_exact prec emax limit) as [O1 O2]. rewrite Fm in O2.
    assert (H1 := less_is_real_order prec emax (Bopp limit) v O2 Fv). rewrite O1 in H1.
    set (raised := if Bltb (Bopp limit) v then v else Bopp limit : number).
    change (saturate A limit v) with (if Bltb limit raised then limit else raised : number).
    assert (Ra : value raised = Rmax (- value limit) (value v) /\ is_finite raised = true).
    { unfold raised. destruct (Bltb (Bopp limit) v).
      - rewrite Rmax_right by (left; now apply H1). auto.
      - rewrite O1, Rmax_left; [auto|]. apply Rnot_lt_le. intro C. apply H1 in C. discriminate. }
    destruct Ra as [R1 R2]. assert (H2 := less_is_real_order prec emax limit raised Fm R2). rewrite R1 in H2. cbn [HeldInputLaw.limit_input].
    destruct (Bltb limit raised).
    - split; [|exact Fm]. assert (Q : value limit < Rmax (- value limit) (value v)) by now apply H2.
      unfold Rmax, Rmin in *; repeat destruct Rle_dec; lra.
    - split; [|exact R2]. rewrite R1. assert (Q : Rmax (- value limit) (value v) <= value limit) by (apply Rnot_lt_le; intro C; apply H2 in C; discriminate).
      unfold Rmax, Rmin in *; repeat destruct Rle_dec; lra.
  Qed.
  Theorem saturated_input_acts_as_law (limit : number) : is_finite limit = true -> 0 <= value limit ->
    HeldInputLaw.acts_as_law gain_real clamp_share_real (32 * u + 1.03 * log_error) (Some (value limit)) a b (value (saturate A limit (unlimited_input A consts gain_high gain_low L U x))) /\ is_finite (saturate A limit (unlimited_input A consts gain_high gain_low L U x)) = true.
  Proof.
    intros Fm m0. destruct unlimited_input_acts_as_law as [(e1 & e2 & E1 & E2 & Eq) Fi]. destruct (saturate_value limit _ Fm Fi m0) as [S1 S2].
    split; [|exact S2]. exists e1, e2. split; [exact E1|split; [exact E2|]]. rewrite S1, Eq. reflexivity.
  Qed.

  (* The machine says that the state is inside just where it is. *)
  Theorem is_inside_correct : is_inside A L U x = true <-> 0 < a /\ 0 < b.
  Proof.
    destruct nearest_distance_rounds as [M1 M2]. assert (Z0 : value (decimal_number prec emax _ _ literal_zero) = 0) by reflexivity.
    assert (H := less_is_real_order prec emax (decimal_number prec emax _ _ literal_zero) (nearest_distance A L U x) eq_refl M2). rewrite Z0, M1 in H.
    unfold is_inside. change (less_than A (literal A literal_zero) (nearest_distance A L U x)) with (Bltb (decimal_number prec emax _ _ literal_zero) (nearest_distance A L U x)). rewrite H.
    assert (R : 0 < round_nearest nearest_real <-> 0 < nearest_real).
    { split; intro Q.
      - apply Rnot_le_lt; intro C. apply (round_nearest_le prec emax prec_gt_0_) in C. rewrite round_nearest_0 in C. lra.
      - assert (D : Rabs (round_nearest nearest_real - nearest_real) <= u * Rabs nearest_real) by (unfold nearest_real, Rmin; destruct (Rle_dec a b); apply difference_relative_error; try apply number_format; assumption).
        rewrite (Rabs_pos_eq nearest_real) in D by lra. apply Rabs_le_between in D. pose proof u_small as Us. nra. }
    rewrite R. unfold nearest_real, Rmin. destruct (Rle_dec a b); lra.
  Qed.
End Machine.
