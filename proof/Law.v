(* The law in machine arithmetic. Relative errors are counted in factors (1 - u): x and y are within n of each other when each is at least
   (1 - u)^n of the other; products and quotients add the counts, and a rounding adds one. *)
From Coq Require Import ZArith QArith Qreals Reals Lia Lra Psatz.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Loop Syntax Run Emission Control Semantics.
Open Scope R_scope.

Section Counts.
  Variable u : R.
  Hypothesis u_small : 0 < u <= / 16777216.
  Let p := 1 - u.

  Definition close (n : nat) (x y : R) : Prop := 0 < x /\ 0 < y /\ y * p ^ n <= x /\ x * p ^ n <= y.

  Lemma p_range : 0 < p < 1. Proof. unfold p. lra. Qed.
  Lemma pow_range n : 0 < p ^ n <= 1.
  Proof. pose proof p_range. split; [apply pow_lt; lra|]. rewrite <- (pow1 n). apply pow_incr; lra. Qed.

  Lemma close_refl n x : 0 < x -> close n x x.
  Proof. intro H. pose proof (pow_range n). unfold close. repeat split; nra. Qed.
  Lemma close_sym n x y : close n x y -> close n y x.
  Proof. unfold close. tauto. Qed.
  Lemma close_more n m x y : (n <= m)%nat -> close n x y -> close m x y.
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
  Lemma close_rounded r x : 0 < x -> Rabs (r - x) <= u * Rabs x -> close 1 r x.
  Proof.
    intros X H. rewrite (Rabs_pos_eq x) in H by lra. apply Rabs_le_between in H. unfold close. rewrite pow_1. unfold p. repeat split; nra.
  Qed.
  Lemma close_then n r x y : close n x y -> Rabs (r - x) <= u * Rabs x -> close (S n) r y.
  Proof. intros C H. change (S n) with (1 + n)%nat. apply close_trans with x; [|exact C]. apply close_rounded; [apply C|exact H]. Qed.

  (* (1 - u)^n is at least 1 - n u *)
  Lemma bernoulli n : 1 - INR n * u <= p ^ n.
  Proof.
    induction n; [cbn; lra|]. rewrite S_INR. cbn [pow]. pose proof (pos_INR n). pose proof p_range.
    destruct (Rle_dec (1 - INR n * u) 0) as [N|P].
    - assert (0 <= p * p ^ n) by (apply Rmult_le_pos; [lra|left; apply pow_range]). nra.
    - apply Rle_trans with (p * (1 - INR n * u)); [unfold p; nra|apply Rmult_le_compat_l; lra].
  Qed.
  Lemma close_ln n x y : (n <= 1000)%nat -> close n x y -> Rabs (ln x - ln y) <= INR n * u * (1 + / 1000).
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
End Counts.

(* ------------------------------------------------------------------ real numbers: nearest, least and far *)

Section Distances.
  Variable u : R.
  Hypothesis u_small : 0 < u <= / 16777216.
  Let p := 1 - u.
  Notation close := (close u).

  (* the greater of two, of which one may be negative *)
  Lemma greater_close n m y N Y : close n y Y -> (0 < m -> close n N m) -> (m <= 0 -> N <= 0) ->
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

  (* a difference that is at least half of the minuend *)
  Lemma difference_close S N s n : close 1 s S -> close 2 n N -> N <= S - N -> close 5 (s - n) (S - N).
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

  Lemma close_bounds n x y : (n <= 1000)%nat -> close n x y -> y / 2 <= x <= 2 * y.
  Proof.
    intros N (X & Y & A & B). fold p in A, B. pose proof (bernoulli u u_small n) as Be. fold p in Be. apply le_INR in N. replace (INR 1000) with 1000 in N by (rewrite INR_IZR_INZ; reflexivity).
    assert (1 / 2 <= p ^ n) by nra. nra.
  Qed.
End Distances.
