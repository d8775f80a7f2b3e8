(* The law as it is emitted, on distances seen with errors: clamped, rounded, limited. Bounds on its input from the distances that
   are true. And bounds on exp that are decided in rationals, for the logarithm in it. *)
From Coq Require Import ZArith QArith Qreals Qround Reals Lra Psatz Lia.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Loop Tube.
Open Scope R_scope.

(* ------------------------------------------------------------------ exp, between rationals *)

Lemma exp_above_fraction z : 0 <= z < 2 -> exp z <= (2 + z) / (2 - z).
Proof.
  intros [Z0 Z2]. apply Rcomplements.Rle_div_r; [lra|].
  destruct (Req_dec z 0) as [->|Ne]; [rewrite exp_0; lra|].
  assert (A : 0 * (z - 0) <= (2 + z - (2 - z) * exp z) - (2 + 0 - (2 - 0) * exp 0)).
  { apply (rises (fun t => 2 + t - (2 - t) * exp t) (fun t => 1 - (1 - t) * exp t)); [lra| |].
    - intro r. apply derivable_continuous_pt. exists (1 - (1 - r) * exp r). apply is_derive_Reals. auto_derive; [easy|ring].
    - intros r Hr. split; [auto_derive; [easy|ring]|].
      assert (E := exp_ineq1_le (- r)). rewrite exp_Ropp in E. pose proof (exp_pos r) as P.
      assert ((1 + - r) * exp r <= / exp r * exp r) by (apply Rmult_le_compat_r; lra).
      rewrite Rinv_l in H by lra. lra. }
  rewrite exp_0 in A. lra.
Qed.

Lemma exp_below_square z : 0 <= z -> 1 + z + z * z / 2 <= exp z.
Proof.
  intro Z0. destruct (Req_dec z 0) as [->|Ne]; [rewrite exp_0; lra|].
  assert (A : 0 * (z - 0) <= (exp z - (1 + z + z * z / 2)) - (exp 0 - (1 + 0 + 0 * 0 / 2))).
  { apply (rises (fun t => exp t - (1 + t + t * t / 2)) (fun t => exp t - (1 + t))); [lra| |].
    - intro r. apply derivable_continuous_pt. exists (exp r - (1 + r)). apply is_derive_Reals. auto_derive; [easy|field].
    - intros r Hr. split; [auto_derive; [easy|field]|]. pose proof (exp_ineq1_le r). lra. }
  rewrite exp_0 in A. lra.
Qed.

(* Fixed point: a stands for a / 2^40, which one addition and one shift a squaring keep. *)
Definition grid : Z := 2 ^ 40.
Definition fixed (a : Z) : R := IZR a / IZR grid.
Definition up (q : Q) : Z := Qceiling (q * inject_Z grid).
Definition down (q : Q) : Z := Qfloor (q * inject_Z grid).
Lemma grid_pos : 0 < IZR grid. Proof. now apply IZR_lt. Qed.
Lemma up_ok q : Q2R q <= fixed (up q).
Proof.
  assert (G := grid_pos). apply (Rmult_le_reg_r (IZR grid)); [exact G|]. unfold fixed, up, Rdiv.
  rewrite (Rmult_assoc (IZR _)), Rinv_l, Rmult_1_r by lra. rewrite <- !Q2R_Z, <- Q2R_mult. apply Qle_Rle, Qle_ceiling.
Qed.
Lemma down_ok q : fixed (down q) <= Q2R q.
Proof.
  assert (G := grid_pos). apply (Rmult_le_reg_r (IZR grid)); [exact G|]. unfold fixed, down, Rdiv.
  rewrite (Rmult_assoc (IZR _)), Rinv_l, Rmult_1_r by lra. rewrite <- !Q2R_Z, <- Q2R_mult. apply Qle_Rle, Qfloor_le.
Qed.

Fixpoint squares_up (m : nat) (a : Z) : Z := match m with O => a | S k => squares_up k (Z.shiftr (a * a) 40 + 1) end.
Fixpoint squares_down (m : nat) (a : Z) : Z := match m with O => a | S k => squares_down k (Z.shiftr (a * a) 40) end.

Lemma shifted a : fixed (Z.shiftr (a * a) 40) <= fixed a * fixed a <= fixed (Z.shiftr (a * a) 40 + 1).
Proof.
  rewrite Z.shiftr_div_pow2 by lia. change (2 ^ 40)%Z with grid. assert (G := grid_pos).
  assert (I : 0 < / IZR grid) by now apply Rinv_0_lt_compat. set (b := (a * a / grid)%Z).
  assert (F : forall c, fixed c = IZR (c * grid) * (/ IZR grid * / IZR grid)) by (intro; unfold fixed; rewrite mult_IZR; field; lra).
  assert (E : fixed a * fixed a = IZR (a * a) * (/ IZR grid * / IZR grid)) by (unfold fixed; rewrite mult_IZR; field; lra).
  rewrite E, (F b), (F (b + 1)%Z). assert (0 <= / IZR grid * / IZR grid) by (apply Rmult_le_pos; lra).
  split; apply Rmult_le_compat_r; try assumption; apply IZR_le; unfold b.
  - rewrite (Z.mul_comm (a * a / grid) grid). now apply Z.mul_div_le.
  - rewrite Z.add_1_r, (Z.mul_comm _ grid). apply Z.lt_le_incl. now apply Z.mul_succ_div_gt.
Qed.

Lemma squares_up_ok m : forall a z, exp z <= fixed a -> exp (z * 2 ^ m) <= fixed (squares_up m a).
Proof.
  induction m; intros a z H; cbn [squares_up pow]; [now rewrite Rmult_1_r|].
  replace (z * (2 * 2 ^ m)) with ((z + z) * 2 ^ m) by ring. apply IHm. rewrite exp_plus.
  eapply Rle_trans; [|apply shifted]. pose proof (exp_pos z). apply Rmult_le_compat; lra.
Qed.
Lemma squares_down_ok m : forall a z, fixed a <= exp z -> (0 <= a)%Z -> fixed (squares_down m a) <= exp (z * 2 ^ m).
Proof.
  induction m; intros a z H P; cbn [squares_down pow]; [now rewrite Rmult_1_r|].
  replace (z * (2 * 2 ^ m)) with ((z + z) * 2 ^ m) by ring.
  assert (F : 0 <= fixed a) by (unfold fixed; apply Rmult_le_pos; [now apply IZR_le|left; apply Rinv_0_lt_compat, grid_pos]).
  apply IHm.
  - rewrite exp_plus. eapply Rle_trans; [apply shifted|]. apply Rmult_le_compat; lra.
  - apply Z.shiftr_nonneg. now apply Z.mul_nonneg_nonneg.
Qed.

Definition halvings : nat := 10.
Definition small : Q := 1 # 1024.
Lemma small_ok : Q2R small * 2 ^ halvings = 1. Proof. unfold small, halvings, Q2R; cbn; lra. Qed.

(* exp l <= y, and y <= exp l, for rationals; `false` where it cannot be told. *)
Definition rational (a : Z) : Q := a # Z.to_pos grid.
Lemma rational_ok a : Q2R (rational a) = fixed a.
Proof. unfold rational, fixed, Q2R; cbn [Qnum Qden]. rewrite Z2Pos.id by reflexivity. reflexivity. Qed.

Definition exp_at_most (l y : Q) : bool :=
  let z := rational (up (l * small)) in
  if (Qle_bool 0 z && Qle_bool z 1)%bool then Qle_bool (rational (squares_up halvings (up ((2 + z) / (2 - z))))) y else false.
Definition exp_at_least (l y : Q) : bool :=
  let z := rational (down (l * small)) in
  if Qle_bool 0 z then
    let v := down (1 + z + z * z * (1 # 2)) in if (0 <=? v)%Z then Qle_bool y (rational (squares_down halvings v)) else false
  else false.

Lemma Q2R_0 : Q2R 0 = 0. Proof. unfold Q2R; cbn; lra. Qed.
Lemma Q2R_1 : Q2R 1 = 1. Proof. unfold Q2R; cbn; lra. Qed.
Lemma Q2R_2 : Q2R 2 = 2. Proof. unfold Q2R; cbn; lra. Qed.
Lemma Qle_true a b : Qle_bool a b = true -> Q2R a <= Q2R b. Proof. intro H. now apply Qle_Rle, Qle_bool_iff. Qed.

Lemma ln_at_least l y : exp_at_most l y = true -> Q2R l <= ln (Q2R y).
Proof.
  unfold exp_at_most. set (z := rational (up (l * small))). destruct (Qle_bool 0 z && Qle_bool z 1)%bool eqn:B; [|easy]. intro H.
  apply andb_true_iff in B. destruct B as [B1 B2]. apply Qle_true in B1, B2, H. rewrite Q2R_0 in B1. rewrite Q2R_1 in B2.
  assert (E : exp (Q2R l) <= Q2R y).
  { apply Rle_trans with (2 := H). rewrite rational_ok. apply Rle_trans with (exp (Q2R z * 2 ^ halvings)).
    - assert (A : Q2R l <= Q2R z * 2 ^ halvings).
      { assert (U := up_ok (l * small)). rewrite <- rational_ok in U. fold z in U. rewrite Q2R_mult in U.
        apply (Rmult_le_compat_r (2 ^ halvings)) in U; [|left; apply pow_lt; lra]. rewrite Rmult_assoc, small_ok in U. lra. }
      destruct (Req_dec (Q2R l) (Q2R z * 2 ^ halvings)) as [->|Ne]; [lra|]. left. apply exp_increasing. lra.
    - apply squares_up_ok. eapply Rle_trans; [|apply up_ok].
      assert (N : ~ (2 - z == 0)%Q) by (intro Q; apply Qeq_eqR in Q; rewrite Q2R_minus, Q2R_2, Q2R_0 in Q; lra).
      rewrite Q2R_div, Q2R_plus, Q2R_minus, Q2R_2 by exact N. apply exp_above_fraction. lra. }
  rewrite <- (ln_exp (Q2R l)). apply Rcomplements.ln_le; [apply exp_pos|exact E].
Qed.

Lemma ln_at_most l y : exp_at_least l y = true -> 0 < Q2R y -> ln (Q2R y) <= Q2R l.
Proof.
  unfold exp_at_least. set (z := rational (down (l * small))). destruct (Qle_bool 0 z) eqn:B; [|easy].
  set (v := down _). destruct (0 <=? v)%Z eqn:B2; [|easy]. intros H Y.
  apply Qle_true in B, H. apply Z.leb_le in B2. rewrite Q2R_0 in B. rewrite rational_ok in H.
  assert (E : Q2R y <= exp (Q2R l)).
  { apply Rle_trans with (1 := H). apply Rle_trans with (exp (Q2R z * 2 ^ halvings)).
    - apply squares_down_ok; [|exact B2]. eapply Rle_trans; [apply down_ok|].
      rewrite !Q2R_plus, !Q2R_mult, Q2R_1. replace (Q2R (1 # 2)) with (/ 2) by (unfold Q2R; cbn; lra).
      apply Rle_trans with (2 := exp_below_square _ B). lra.
    - assert (A : Q2R z * 2 ^ halvings <= Q2R l).
      { assert (U := down_ok (l * small)). rewrite <- rational_ok in U. fold z in U. rewrite Q2R_mult in U.
        apply (Rmult_le_compat_r (2 ^ halvings)) in U; [|left; apply pow_lt; lra]. rewrite Rmult_assoc, small_ok in U. lra. }
      destruct (Req_dec (Q2R z * 2 ^ halvings) (Q2R l)) as [->|Ne]; [lra|]. left. apply exp_increasing. lra. }
  rewrite <- (ln_exp (Q2R l)). apply Rcomplements.ln_le; [exact Y|exact E].
Qed.

(* ------------------------------------------------------------------ the law *)

Lemma ln_from y : 0 < y -> 1 - / y <= ln y.
Proof.
  intro H. assert (P : 0 < / y) by now apply Rinv_0_lt_compat.
  assert (E := exp_ineq1_le (- ln y)). rewrite exp_Ropp, exp_ln in E by exact H. lra.
Qed.
Lemma ln_up y : 0 < y -> ln y <= y - 1.
Proof. intro H. assert (E := exp_ineq1_le (ln y)). rewrite exp_ln in E by exact H. lra. Qed.

(* (1 + 1/y) (ln y + r) rises with y: the law pulls the harder, the more the distances differ. *)
Lemma harder y1 y2 r : 1 <= y1 <= y2 -> r <= 1 -> (1 + / y1) * (ln y1 + r) <= (1 + / y2) * (ln y2 + r).
Proof.
  intros [A B] Hr. assert (P1 : 0 < / y1) by (apply Rinv_0_lt_compat; lra). assert (P2 : 0 < / y2) by (apply Rinv_0_lt_compat; lra).
  assert (D : 1 - y1 * / y2 <= ln y2 - ln y1).
  { rewrite <- ln_div by lra. assert (L := ln_from (y2 / y1) ltac:(apply Rdiv_lt_0_compat; lra)).
    replace (/ (y2 / y1)) with (y1 * / y2) in L by (field; lra). exact L. }
  assert (L1 := ln_up y1 ltac:(lra)).
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

Definition side (a b : R) : R := if Rlt_dec b a then 1 else -1.
Definition nearer (c a b : R) : R := Rmax (Rmin a b) (c * (a + b)).
Definition magnitude (k near far e1 e2 : R) : R := k * (1 / far + 1 / near) * (1 + e1) * (ln (far / near) + e2).
Definition clamp (limit : option R) (u : R) : R := match limit with None => u | Some m => Rmax (- m) (Rmin u m) end.
(* What `control` gives for distances a and b as it sees them; e1 and e2 are what its arithmetic and its logarithm lose. *)
Definition acts (k c r : R) (limit : option R) (a b u : R) : Prop := exists e1 e2, Rabs e1 <= r /\ Rabs e2 <= r /\
  u = clamp limit (- side a b * magnitude k (nearer c a b) (a + b - nearer c a b) e1 e2).

Lemma nearer_range c a b : 0 < c <= 1 / 2 -> 0 < a + b -> 0 < nearer c a b <= (a + b) / 2.
Proof.
  intros Hc Hs. assert (0 < c * (a + b)) by (apply Rmult_lt_0_compat; lra).
  assert (c * (a + b) <= 1 / 2 * (a + b)) by (apply Rmult_le_compat_r; lra).
  unfold nearer, Rmax, Rmin; repeat destruct Rle_dec; lra.
Qed.

Lemma magnitude_form k near far e1 e2 : 0 < near -> 0 < far ->
  magnitude k near far e1 e2 = k * (/ near * ((1 + / (far / near)) * (ln (far / near) + e2))) * (1 + e1).
Proof. intros; unfold magnitude. field. lra. Qed.

Lemma magnitude_from k near far e1 e2 r B Y l : 0 < k -> 0 < near <= B -> 1 <= Y <= far / near -> l <= ln Y -> 0 <= r <= l -> r <= 1 ->
  Rabs e1 <= r -> Rabs e2 <= r -> k * / B * (1 + / Y) * (1 - r) * (l - r) <= magnitude k near far e1 e2.
Proof.
  intros Hk Hn Hy Hl Hr r1 E1 E2. apply Rabs_le_between in E1, E2.
  assert (F : 0 < far).
  { apply (Rmult_lt_reg_r (/ near)); [apply Rinv_0_lt_compat; lra|]. rewrite Rmult_0_l. fold (far / near). lra. }
  rewrite magnitude_form by lra. set (y := far / near) in *.
  assert (P : 0 < / y) by (apply Rinv_0_lt_compat; lra). assert (PY : 0 < / Y) by (apply Rinv_0_lt_compat; lra).
  assert (Q := harder Y y (- r) ltac:(lra) ltac:(lra)).
  assert (A : (1 + / Y) * (l - r) <= (1 + / y) * (ln y + e2)).
  { apply Rle_trans with ((1 + / Y) * (ln Y + - r)); [apply Rmult_le_compat_l; lra|]. apply Rle_trans with (1 := Q).
    apply Rmult_le_compat_l; lra. }
  assert (A0 : 0 <= (1 + / Y) * (l - r)) by (apply Rmult_le_pos; lra).
  assert (IB : 0 < / B <= / near).
  { split; [apply Rinv_0_lt_compat; lra|apply Rinv_le_contravar; lra]. }
  assert (C : / B * ((1 + / Y) * (l - r)) <= / near * ((1 + / y) * (ln y + e2))) by (apply Rmult_le_compat; lra).
  assert (C0 : 0 <= / B * ((1 + / Y) * (l - r))) by (apply Rmult_le_pos; lra).
  replace (k * / B * (1 + / Y) * (1 - r) * (l - r)) with (k * (/ B * ((1 + / Y) * (l - r))) * (1 - r)) by ring.
  apply Rmult_le_compat; try lra; [apply Rmult_le_pos; lra|]. apply Rmult_le_compat_l; lra.
Qed.

Lemma magnitude_to k near far e1 e2 r N Y l : 0 < k -> 0 < N <= near -> 1 <= far / near <= Y -> ln Y <= l -> 0 <= r <= 1 ->
  Rabs e1 <= r -> Rabs e2 <= r -> Rabs (magnitude k near far e1 e2) <= k * / N * (1 + / Y) * (1 + r) * (l + r).
Proof.
  intros Hk Hn Hy Hl Hr E1 E2.
  assert (F : 0 < far).
  { apply (Rmult_lt_reg_r (/ near)); [apply Rinv_0_lt_compat; lra|]. rewrite Rmult_0_l. fold (far / near). lra. }
  rewrite magnitude_form by lra. set (y := far / near) in *.
  assert (P : 0 < / y) by (apply Rinv_0_lt_compat; lra). assert (PY : 0 < / Y) by (apply Rinv_0_lt_compat; lra).
  assert (Ly : 0 <= ln y) by (rewrite <- ln_1; apply Rcomplements.ln_le; lra).
  assert (Q := harder y Y r ltac:(lra) ltac:(lra)).
  rewrite !Rabs_mult, (Rabs_pos_eq k), (Rabs_pos_eq (/ near)), (Rabs_pos_eq (1 + / y)) by (try lra; left; apply Rinv_0_lt_compat; lra).
  assert (A1 : Rabs (ln y + e2) <= ln y + r).
  { eapply Rle_trans; [apply Rabs_triang|]. rewrite (Rabs_pos_eq (ln y)) by lra. lra. }
  assert (A2 : Rabs (1 + e1) <= 1 + r).
  { eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_R1. lra. }
  assert (IN : 0 < / near <= / N).
  { split; [apply Rinv_0_lt_compat; lra|apply Rinv_le_contravar; lra]. }
  assert (A : (1 + / y) * Rabs (ln y + e2) <= (1 + / Y) * (l + r)).
  { apply Rle_trans with ((1 + / y) * (ln y + r)); [apply Rmult_le_compat_l; lra|]. apply Rle_trans with (1 := Q).
    apply Rmult_le_compat_l; lra. }
  assert (A0 : 0 <= (1 + / y) * Rabs (ln y + e2)) by (apply Rmult_le_pos; [lra|apply Rabs_pos]).
  replace (k * / N * (1 + / Y) * (1 + r) * (l + r)) with (k * (/ N * ((1 + / Y) * (l + r))) * (1 + r)) by ring.
  assert (0 <= / near * ((1 + / y) * Rabs (ln y + e2))) by (apply Rmult_le_pos; lra).
  apply Rmult_le_compat; [apply Rmult_le_pos; lra|apply Rabs_pos| |exact A2].
  apply Rmult_le_compat_l; [lra|]. apply Rmult_le_compat; lra.
Qed.

Lemma clamp_opp limit u : (forall m, limit = Some m -> 0 <= m) -> clamp limit (- u) = - clamp limit u.
Proof.
  intro H. destruct limit as [m|]; cbn; [|reflexivity]. specialize (H m eq_refl). unfold Rmax, Rmin; repeat destruct Rle_dec; lra.
Qed.

(* The law is odd: what it does at one edge it does at the other. *)
Lemma acts_opp k c r limit a b u : (forall m, limit = Some m -> 0 <= m) -> 0 < c <= 1 / 2 -> 0 < a + b -> acts k c r limit a b u -> acts k c r limit b a (- u).
Proof.
  intros Hm Hc Hs (e1 & e2 & A & B & ->).
  assert (N : nearer c b a = nearer c a b) by (unfold nearer; rewrite Rmin_comm; f_equal; ring).
  assert (S : b + a = a + b) by ring.
  destruct (Req_dec a b) as [E|E].
  - (* in the middle the logarithm is 0, and what is lost there may be of either sign *)
    exists e1, (- e2). rewrite Rabs_Ropp. split; [exact A|split; [exact B|]]. rewrite <- clamp_opp by exact Hm. f_equal.
    rewrite N, S. subst b. unfold side. destruct Rlt_dec; [lra|]. unfold magnitude.
    assert (Nr := nearer_range c a a Hc Hs).
    assert (M : nearer c a a = a).
    { unfold nearer. rewrite Rmin_left by lra. assert (c * (a + a) <= 1 / 2 * (a + a)) by (apply Rmult_le_compat_r; lra). apply Rmax_left; lra. }
    rewrite M. replace ((a + a - a) / a) with 1 by (field; lra). rewrite ln_1. ring.
  - exists e1, e2. split; [exact A|split; [exact B|]]. rewrite <- clamp_opp by exact Hm. f_equal. rewrite N, S.
    unfold side. repeat destruct Rlt_dec; try lra; ring.
Qed.

Section Bounds.
  Variables (k c r eta z : R) (limit : option R).
  Hypothesis numbers : 0 < k /\ 0 < c <= z /\ z <= 1 / 2 /\ 0 <= r <= 1 / 2 /\ c <= 1 / 4 /\ 0 <= eta.
  Hypothesis limit_pos : forall m, limit = Some m -> 0 <= m.

  Lemma clamp_most u : Rabs (clamp limit u) <= Rabs u.
  Proof.
    destruct limit as [m|]; cbn; [|lra]. specialize (limit_pos m eq_refl).
    unfold Rmax, Rmin, Rabs; repeat destruct Rle_dec; repeat destruct Rcase_abs; lra.
  Qed.

  (* The largest input: the sample was inside the inner tube, whose width there was at least d. *)
  Lemma acts_most a b a' b' u d Y l : acts k c r limit a' b' u -> Rabs (a' - a) <= eta -> Rabs (b' - b) <= eta ->
    d <= a + b -> (a + b) * z <= a -> (a + b) * z <= b -> 0 < d * z - eta -> Y = (d * (1 - z) + eta) / (d * z - eta) -> ln Y <= l ->
    Rabs u <= k * / (d * z - eta) * (1 + / Y) * (1 + r) * (l + r).
  Proof.
    destruct numbers as (k0 & Hc & Hz & Hr & c4 & e0).
    intros (e1 & e2 & E1 & E2 & ->) Ea Eb Hd Wa Wb HN HY Hl. apply Rabs_le_between in Ea, Eb.
    eapply Rle_trans; [apply clamp_most|].
    assert (Sd : Rabs (- side a' b' * magnitude k (nearer c a' b') (a' + b' - nearer c a' b') e1 e2) =
                 Rabs (magnitude k (nearer c a' b') (a' + b' - nearer c a' b') e1 e2)).
    { rewrite Rabs_mult. unfold side. destruct Rlt_dec; [rewrite Rabs_left by lra|rewrite Rabs_pos_eq by lra]; ring. }
    rewrite Sd.
    assert (Wd : d * z <= (a + b) * z) by (apply Rmult_le_compat_r; lra).
    assert (Mn : d * z - eta <= Rmin a' b') by (unfold Rmin; destruct Rle_dec; lra).
    assert (Mx : Rmax a' b' <= (a + b) * (1 - z) + eta) by (unfold Rmax; destruct Rle_dec; lra).
    assert (Mn2 : (a + b) * z - eta <= Rmin a' b') by (unfold Rmin; destruct Rle_dec; lra).
    assert (SumE : a' + b' = Rmin a' b' + Rmax a' b') by (unfold Rmin, Rmax; repeat destruct Rle_dec; lra).
    destruct (nearer_range c a' b' ltac:(lra) ltac:(unfold Rmin in Mn; destruct Rle_dec; lra)) as [N0 N2].
    assert (N1 : Rmin a' b' <= nearer c a' b') by (unfold nearer; apply Rmax_l).
    set (near := nearer c a' b') in *.
    assert (d0 : 0 < d) by (apply (Rmult_lt_reg_r z); lra).
    assert (YN : Y * (d * z - eta) = d * (1 - z) + eta) by (rewrite HY; field; lra).
    assert (Y1 : 1 <= Y).
    { rewrite HY. apply Rcomplements.Rle_div_r; [lra|]. assert (0 <= d * (1 - 2 * z)) by (apply Rmult_le_pos; lra). lra. }
    assert (Far : a' + b' - near <= Y * near).
    { assert (A : (a + b) * (1 - z) + eta <= Y * ((a + b) * z - eta)).
      { assert (0 <= Y * eta) by (apply Rmult_le_pos; lra).
        assert (Yz : 1 - z <= Y * z) by (apply (Rmult_le_reg_l d); lra).
        assert (0 <= (a + b - d) * (Y * z - (1 - z))) by (apply Rmult_le_pos; lra). lra. }
      assert (Y * ((a + b) * z - eta) <= Y * near) by (apply Rmult_le_compat_l; lra). lra. }
    apply magnitude_to; try lra.
    split.
    - apply Rcomplements.Rle_div_r; lra.
    - apply Rcomplements.Rle_div_l; [lra|exact Far].
  Qed.

  (* A sample that is seen above the middle by more than is lost: its input is not upwards. *)
  Lemma acts_side a b a' b' u most : acts k c r limit a' b' u -> Rabs (a' - a) <= eta -> Rabs (b' - b) <= eta -> 0 < a' + b' ->
    a + b <= most -> 2 * eta + r * (most + 2 * eta) < a - b -> u <= 0.
  Proof.
    destruct numbers as (k0 & Hc & Hz & Hr & c4 & e0).
    intros (e1 & e2 & E1 & E2 & ->) Ea Eb Hs Hm Hd. apply Rabs_le_between in Ea, Eb, E1, E2.
    assert (Sn : r * (a' + b') <= r * (most + 2 * eta)) by (apply Rmult_le_compat_l; lra).
    assert (R0 : 0 <= r * (a' + b')) by (apply Rmult_le_pos; lra).
    destruct (nearer_range c a' b' ltac:(lra) Hs) as [N0 N2].
    assert (Ln : r <= ln ((a' + b' - nearer c a' b') / nearer c a' b')).
    { set (near := nearer c a' b') in *. set (far := a' + b' - near) in *.
      assert (P : 0 < far / near) by (apply Rdiv_lt_0_compat; unfold far; lra).
      eapply Rle_trans; [|apply (ln_from _ P)].
      replace (/ (far / near)) with (near / far) by (unfold far in *; field; lra).
      assert (Q : near / far <= 1 - r); [|lra].
      apply Rcomplements.Rle_div_l; [unfold far; lra|]. unfold far.
      assert (Cs : near = b' \/ near = c * (a' + b')).
      { unfold near, nearer, Rmax, Rmin. repeat destruct Rle_dec; lra. }
      destruct Cs as [Q|Q]; rewrite Q in *.
      { assert (0 <= r * b') by (apply Rmult_le_pos; lra). lra. }
      assert (c * (a' + b') <= 1 / 4 * (a' + b')) by (apply Rmult_le_compat_r; lra).
      assert (r * (a' + b') <= 1 / 2 * (a' + b')) by (apply Rmult_le_compat_r; lra).
      assert (0 <= r * (c * (a' + b'))) by (apply Rmult_le_pos; [lra|apply Rmult_le_pos; lra]). lra. }
    unfold side. destruct Rlt_dec as [_|Q]; [|lra].
    assert (M : 0 <= magnitude k (nearer c a' b') (a' + b' - nearer c a' b') e1 e2).
    { unfold magnitude. repeat apply Rmult_le_pos; try lra. unfold Rdiv. rewrite !Rmult_1_l.
      apply Rplus_le_le_0_compat; left; apply Rinv_0_lt_compat; lra. }
    set (mg := magnitude _ _ _ _ _) in *.
    destruct limit as [m|]; cbn; [|lra]. specialize (limit_pos m eq_refl). unfold Rmax, Rmin; repeat destruct Rle_dec; lra.
  Qed.

  (* The least pull of a sample that was near the upper edge, where the width is between d0 and d1 when it acts. *)
  Lemma acts_pull a b a' b' u d d0 d1 drift vt A B0 Y l gmin P :
    acts k c r limit a' b' u -> Rabs (a' - a) <= eta -> Rabs (b' - b) <= eta -> 0 < a' + b' ->
    d0 <= d <= d1 -> 0 < d0 -> 0 <= vt <= drift -> a + b <= d + 2 * vt -> d * (1 - z) - drift <= a -> b <= d * z + drift ->
    A = d0 * (1 - z) - (drift + eta) -> B0 = d0 * z + (drift + eta) -> Y = A / B0 -> 1 < Y -> l <= ln Y -> r <= l -> 0 < gmin ->
    P <= gmin * (k * / (d1 * z + (drift + eta)) * (1 + / Y) * (1 - r) * (l - r)) ->
    (forall m, limit = Some m -> P <= gmin * m) -> P <= gmin * - u.
  Proof.
    destruct numbers as (k0 & Hc & Hz & Hr & c4 & e0).
    intros (e1 & e2 & E1 & E2 & ->) Ea Eb Hs Hd d00 Hv Hw Ha Hb HA HB HY Y1 Hl rl Hg HP Hlim. apply Rabs_le_between in Ea, Eb.
    destruct (nearer_range c a' b' ltac:(lra) Hs) as [N0 N2].
    assert (B00 : 0 < B0) by (rewrite HB; assert (0 < d0 * z) by (apply Rmult_lt_0_compat; lra); lra).
    assert (YB : Y * B0 = A) by (rewrite HY; field; lra).
    assert (Dz : d0 * z <= d * z <= d1 * z) by (split; apply Rmult_le_compat_r; lra).
    assert (Yz : Y * z <= 1 - z).
    { apply (Rmult_le_reg_l d0); [exact d00|]. assert (0 <= Y * (drift + eta)) by (apply Rmult_le_pos; lra).
      rewrite HB, HA in YB. lra. }
    assert (Yb : Y * (d * z + (drift + eta)) <= d * (1 - z) - (drift + eta)).
    { assert ((d - d0) * (Y * z) <= (d - d0) * (1 - z)) by (apply Rmult_le_compat_l; lra).
      rewrite HB, HA in YB. lra. }
    assert (Bb : b' <= d * z + (drift + eta)) by lra.
    assert (Yb' : Y * b' <= a').
    { assert (Y * b' <= Y * (d * z + (drift + eta))) by (apply Rmult_le_compat_l; lra). lra. }
    assert (Lt : b' < a').
    { assert (0 < d * z + (drift + eta)) by (assert (0 < d * z) by (apply Rmult_lt_0_compat; lra); lra).
      assert (1 * (d * z + (drift + eta)) < Y * (d * z + (drift + eta))) by (apply Rmult_lt_compat_r; lra). lra. }
    set (near := nearer c a' b') in *.
    assert (Cs : near = b' \/ near = c * (a' + b')) by (unfold near, nearer, Rmax, Rmin; repeat destruct Rle_dec; lra).
    assert (Cz : c * (a' + b') <= z * (a' + b')) by (apply Rmult_le_compat_r; lra).
    assert (NB : near <= d1 * z + (drift + eta)).
    { destruct Cs as [Q|Q]; rewrite Q; [lra|]. apply Rle_trans with (1 := Cz).
      assert (z * (a' + b') <= z * (d + 2 * vt + 2 * eta)) by (apply Rmult_le_compat_l; lra).
      assert (z * (2 * (vt + eta)) <= 1 / 2 * (2 * (vt + eta))) by (apply Rmult_le_compat_r; lra). lra. }
    assert (FY : Y <= (a' + b' - near) / near).
    { apply Rcomplements.Rle_div_r; [lra|]. destruct Cs as [Q|Q]; rewrite Q; [lra|].
      assert (Y * (c * (a' + b')) <= Y * (z * (a' + b'))) by (apply Rmult_le_compat_l; lra).
      assert (Y * z * (a' + b') <= (1 - z) * (a' + b')) by (apply Rmult_le_compat_r; lra). lra. }
    assert (M := magnitude_from k near (a' + b' - near) e1 e2 r (d1 * z + (drift + eta)) Y l k0 ltac:(lra) ltac:(lra) Hl ltac:(lra) ltac:(lra) E1 E2).
    unfold side. destruct Rlt_dec as [_|Q]; [|lra]. fold near.
    set (mg := magnitude _ _ _ _ _) in *. set (bd := k * / _ * _ * _ * _) in *.
    assert (gmin * bd <= gmin * mg) by (apply Rmult_le_compat_l; lra).
    destruct limit as [m|]; cbn; [|lra]. specialize (limit_pos m eq_refl). specialize (Hlim m eq_refl).
    set (held := Rmax _ _).
    assert (Cl : mg <= - held \/ m <= - held) by (unfold held, Rmax, Rmin; repeat destruct Rle_dec; lra).
    destruct Cl; [assert (gmin * mg <= gmin * - held)|assert (gmin * m <= gmin * - held)]; try (apply Rmult_le_compat_l; lra); lra.
  Qed.
End Bounds.
