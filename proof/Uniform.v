(* Held inputs under bounds that are the same at all times: the least and greatest width of the tube, its greatest speed. All conditions are decided in rationals.
   (Bounds window by window allow longer periods; the argument is the same.) *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra Psatz.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed Held HeldLaw.
Import ListNotations.
Open Scope R_scope.

Lemma Q2R_inv_total q : Q2R (/ q) = / Q2R q.
Proof.
  destruct (Qeq_dec q 0) as [E|E]; [|now apply Q2R_inv].
  rewrite (Qeq_eqR _ _ E). rewrite (Qeq_eqR (/ q) (/ 0)) by (now rewrite E). change (/ 0)%Q with 0%Q. rewrite Q2R_0. now rewrite Rinv_0.
Qed.
Lemma Q2R_div_total a b : Q2R (a / b) = Q2R a * / Q2R b.
Proof. unfold Qdiv. now rewrite Q2R_mult, Q2R_inv_total. Qed.
Ltac reals := repeat first [rewrite Q2R_plus | rewrite Q2R_minus | rewrite Q2R_mult | rewrite Q2R_div_total | rewrite Q2R_inv_total | rewrite Q2R_opp].
Ltac reals_in H := repeat first [rewrite Q2R_plus in H | rewrite Q2R_minus in H | rewrite Q2R_mult in H | rewrite Q2R_div_total in H | rewrite Q2R_inv_total in H | rewrite Q2R_opp in H].

Definition Qless (a b : Q) : bool := negb (Qle_bool b a).
Lemma Qless_ok a b : Qless a b = true -> Q2R a < Q2R b.
Proof. unfold Qless. intro H. apply Qlt_Rlt. apply negb_true_iff in H. apply Qnot_le_lt. intro C. apply Qle_bool_iff in C. congruence. Qed.

(* by component: the inner tube is |e| <= (rho - 1)/(rho + 1); bounds of the plant; least and greatest width; bounds of two logarithms (found outside, decided here) *)
Record plant := Plant {
  rho_ : list Q; gmin_ : list Q; gmax_ : list Q; push_ : list Q; cross_ : list Q;
  tau_ : Q; latency_ : Q; noise_ : Q;
  narrowest : list Q; widest : list Q;
  log_up : list Q; log_down : list Q
}.
Notation of l i := (nth i l 0%Q).

Fixpoint others_Q (n i : nat) (u : nat -> Q) : Q :=
  match n with O => 0%Q | S m => ((if Nat.eq_dec m i then 0 else u m) + others_Q m i u)%Q end.
Lemma others_Q_ok n i u : Q2R (others_Q n i u) = others n i (fun j => Q2R (u j)).
Proof. induction n; cbn; [apply Q2R_0|]. rewrite Q2R_plus, IHn. destruct (Nat.eq_dec n i); [now rewrite Q2R_0|reflexivity]. Qed.

Section Uniform.
  Variables (unit err : Q) (depth : search) (k : task) (rows : table) (Vs : list Z).
  Variables (gains : list Q) (c r : Q) (limits : list (option Q)) (P : plant).

  Definition eta : Q := err + noise_ P.
  Definition z_ i : Q := 1 / (1 + of (rho_ P) i).
  Definition v_ i : Q := unit * (3 * inject_Z (nth i Vs 0%Z)) * (inject_Z (Z.of_nat (segments rows)) / T k).
  Definition N_ i : Q := Qred (of (narrowest P) i * z_ i - eta).
  Definition Y1 i : Q := Qred ((of (narrowest P) i * (1 - z_ i) + eta) / N_ i).
  Definition most_ i : Q := Qred (of gains i * / N_ i * (1 + / Y1 i) * (1 + r) * (of (log_up P) i + r)).
  Definition force_ i : Q := Qred (of (push_ P) i + of (cross_ P) i * others_Q (n k) i most_).
  Definition drift_ i : Q := Qred ((force_ i + v_ i) * tau_ P + of (gmax_ P) i * most_ i * latency_ P).
  Definition A_ i : Q := of (narrowest P) i * (1 - z_ i) - (drift_ i + eta).
  Definition B_ i : Q := of (narrowest P) i * z_ i + (drift_ i + eta).
  Definition Y2 i : Q := Qred (A_ i / B_ i).
  Definition pull_ i : Q := of (gmin_ P) i * (of gains i * / (of (widest P) i * z_ i + (drift_ i + eta)) * (1 + / Y2 i) * (1 - r) * (of (log_down P) i - r)).

  Definition narrow (i : nat) (v : Q) : atom := single i 1 (-1) (- below unit v).
  Definition widths : list requirement := flat_map (fun i => [[wide unit i (of (narrowest P) i)]; [narrow i (of (widest P) i)]]) (seq 0 (n k)).

  Definition component_check (i : nat) : bool :=
    (Qle_bool 1 (of (rho_ P) i) && Qless 0 (of (gmin_ P) i) && Qle_bool (of (gmin_ P) i) (of (gmax_ P) i) && Qle_bool 0 (of (push_ P) i) && Qle_bool 0 (of (cross_ P) i) &&
     Qless 0 (of (narrowest P) i) && Qle_bool c (z_ i) && Qless 0 (N_ i) && Qle_bool 0 (most_ i) && Qle_bool 0 (v_ i) &&
     exp_at_least (of (log_up P) i) (Y1 i) && exp_at_most (of (log_down P) i) (Y2 i) && Qless 1 (Y2 i) && Qle_bool r (of (log_down P) i) && Qless 0 (B_ i) &&
     Qless (2 * eta + r * (of (widest P) i + 2 * eta))
           (of (narrowest P) i * ((of (rho_ P) i - 1) / (of (rho_ P) i + 1)) - 2 * ((force_ i + v_ i + of (gmax_ P) i * most_ i) * tau_ P)) &&
     Qle_bool (force_ i + v_ i) (pull_ i) && Qless 0 (of gains i) &&
     match nth i limits None with Some m => Qle_bool 0 m && Qle_bool (force_ i + v_ i) (of (gmin_ P) i * m) | None => true end)%bool.
  Definition plant_check : bool :=
    (Qless 0 c && Qle_bool c (1 # 4) && Qle_bool 0 r && Qle_bool r (1 # 2) && Qle_bool 0 (noise_ P) && Qle_bool 0 (tau_ P) && Qle_bool 0 (latency_ P) &&
     forallb (fun p => check_piece (halves depth) 1 p widths) (pieces rows) && forallb component_check (seq 0 (n k)))%bool.

  Hypothesis tube_checked : check unit err depth k rows = true.
  Hypothesis slopes_checked : slopes err k rows Vs = true.
  Hypothesis plant_checked : plant_check = true.

  Let L (i : nat) (t : R) := lower unit k rows i t.
  Let U (i : nat) (t : R) := upper unit k rows i t.

  (* the trajectory, the samples, and the inputs that act *)
  Variables (taken switch : nat -> R) (x : nat -> R -> R) (y g : nat -> nat -> R -> R) (input : nat -> nat -> R).
  Hypothesis clock : switch 0%nat = 0 /\ forall p, 0 <= taken p <= switch p /\ switch p < switch (S p) /\
    switch (S p) - taken p <= Q2R (tau_ P) /\ switch p - taken p <= Q2R (latency_ P).
  Hypothesis x_cont : forall i t, (i < n k)%nat -> continuity_pt (x i) t.
  Hypothesis start : keeps (n k) (fun i => Q2R (of (rho_ P) i)) L U x 0.
  Hypothesis ode : forall p t, switch p < t < switch (S p) -> (forall i, (i < n k)%nat -> L i t < x i t < U i t) -> forall i, (i < n k)%nat ->
    is_derive (x i) t (y i p t + g i p t * input p i) /\
    Rabs (y i p t) <= Q2R (of (push_ P) i) + Q2R (of (cross_ P) i) * others (n k) i (fun j => Rabs (input p j)) /\
    Q2R (of (gmin_ P) i) <= g i p t <= Q2R (of (gmax_ P) i).
  (* every input is the law's, on distances seen with errors *)
  Hypothesis law : forall p i, (i < n k)%nat -> exists a b,
    Rabs (a - (x i (taken p) - L i (taken p))) <= Q2R eta /\ Rabs (b - (U i (taken p) - x i (taken p))) <= Q2R eta /\ 0 < a + b /\
    acts (Q2R (of gains i)) (Q2R c) (Q2R r) (option_map Q2R (nth i limits None)) a b (input p i).

  Lemma widths_ok i t : (i < n k)%nat -> Q2R (of (narrowest P) i) <= U i t - L i t <= Q2R (of (widest P) i).
  Proof.
    intro Hi. pose proof plant_checked as H. unfold plant_check in H. rewrite !andb_true_iff in H. destruct H as [[_ W] _].
    pose proof tube_checked as C. unfold check in C. cbv zeta in C. rewrite !andb_true_iff in C. destruct C as [[[Up Tp] Rg] _].
    assert (Tp' := positive_ok _ Tp). assert (Up' := positive_ok _ Up).
    assert (D : forall r a e, In r widths -> In a r -> In e (terms a) -> (dim e < n k)%nat).
    { intros rq a e. unfold widths. rewrite in_flat_map. intros (j & Hj & [<-|[<-|[]]]); apply in_seq in Hj; intros [<-|[]] [<-|[]]; cbn; lia. }
    assert (S := check_table_sound (n k) (halves depth) (Q2R unit) (Q2R (T k)) rows widths Rg Up' Tp' D W t).
    assert (I : In i (seq 0 (n k))) by (apply in_seq; lia).
    destruct (S [wide unit i (of (narrowest P) i)]) as (a & [<-|[]] & M1).
    { unfold widths. apply in_flat_map. exists i. split; [exact I|now left]. }
    destruct (S [narrow i (of (widest P) i)]) as (a & [<-|[]] & M2).
    { unfold widths. apply in_flat_map. exists i. split; [exact I|right; now left]. }
    unfold weighted, wide, narrow, single in *. cbn [terms fold_right dim wl wu least] in *. unfold L, U, lower, upper.
    pose proof (above_ok unit Up (of (narrowest P) i)) as Ab. pose proof (below_ok unit Up (of (widest P) i)) as Be. rewrite opp_IZR in M2. lra.
  Qed.

  Theorem held : forall p t, 0 <= t <= switch p -> keeps (n k) (fun i => Q2R (of (rho_ P) i)) L U x t.
  Proof.
    pose proof plant_checked as H. unfold plant_check in H. rewrite !andb_true_iff in H. destruct H as [[[[[[[[G2 G3] G4] G5] G6] G7] G8] W] Cc].
    apply Qless_ok in G2. apply Qle_true in G3, G4, G5, G6, G7, G8. rewrite forallb_forall in Cc.
    pose proof tube_checked as C. unfold check in C. cbv zeta in C. rewrite !andb_true_iff in C. destruct C as [[[Up Tp] Rg] _].
    assert (Tp' := positive_ok _ Tp). assert (Up' := positive_ok _ Up).
    pose proof slopes_checked as Sl. unfold slopes in Sl. rewrite !andb_true_iff, forallb_forall in Sl. destruct Sl as [[Mw Er] St].
    apply Qle_true in Er.
    assert (Q1 : Q2R (1 # 4) = 1 / 4) by (unfold Q2R; cbn; lra). assert (Qh : Q2R (1 # 2) = 1 / 2) by (unfold Q2R; cbn; lra).
    assert (Eta : 0 <= Q2R eta) by (unfold eta; rewrite Q2R_plus, Q2R_0 in *; lra).
    assert (Each : forall i, (i < n k)%nat -> component_check i = true) by (intros i Hi; apply Cc, in_seq; lia).
    assert (Own : forall i, (i < n k)%nat -> 0 < Q2R (of gains i) /\ (forall m, option_map Q2R (nth i limits None) = Some m -> 0 <= m) /\
      forall m, option_map Q2R (nth i limits None) = Some m -> Q2R (force_ i) + Q2R (v_ i) <= Q2R (of (gmin_ P) i) * m).
    { intros i Hi. assert (E := Each i Hi). unfold component_check in E. rewrite !andb_true_iff in E. destruct E as [[_ E1] E2]. apply Qless_ok in E1. rewrite Q2R_0 in E1.
      split; [exact E1|]. destruct (nth i limits None) as [q|]; cbn [option_map]; [|split; intros; discriminate].
      rewrite andb_true_iff in E2. destruct E2 as [E2 E3]. apply Qle_true in E2, E3. rewrite Q2R_0 in E2. rewrite Q2R_plus, Q2R_mult in E3. split; intros m [= <-]; assumption. }
    (* the conditions of one component, in real numbers *)
    assert (Num : forall i, (i < n k)%nat ->
      let rho := Q2R (of (rho_ P) i) in let z := / (1 + rho) in let d0 := Q2R (of (narrowest P) i) in let d1 := Q2R (of (widest P) i) in
      let most := Q2R (most_ i) in let v := Q2R (v_ i) in let F := Q2R (force_ i) in let dr := Q2R (drift_ i) in
      1 <= rho /\ 0 < Q2R (of (gmin_ P) i) <= Q2R (of (gmax_ P) i) /\ 0 <= Q2R (of (push_ P) i) /\ 0 <= Q2R (of (cross_ P) i) /\ 0 < d0 /\ Q2R c <= z /\ 0 < d0 * z - Q2R eta /\
      0 <= most /\ 0 <= v /\ v = Q2R unit * (3 * IZR (nth i Vs 0%Z)) * (INR (segments rows) / Q2R (T k)) /\
      Q2R (Y1 i) = (d0 * (1 - z) + Q2R eta) / (d0 * z - Q2R eta) /\ ln (Q2R (Y1 i)) <= Q2R (of (log_up P) i) /\
      most = Q2R (of gains i) * / (d0 * z - Q2R eta) * (1 + / Q2R (Y1 i)) * (1 + Q2R r) * (Q2R (of (log_up P) i) + Q2R r) /\
      F = Q2R (of (push_ P) i) + Q2R (of (cross_ P) i) * others (n k) i (fun j => Q2R (most_ j)) /\
      dr = (F + v) * Q2R (tau_ P) + Q2R (of (gmax_ P) i) * most * Q2R (latency_ P) /\
      2 * Q2R eta + Q2R r * (d1 + 2 * Q2R eta) < d0 * ((rho - 1) / (rho + 1)) - 2 * ((F + v + Q2R (of (gmax_ P) i) * most) * Q2R (tau_ P)) /\
      Q2R (Y2 i) = (d0 * (1 - z) - (dr + Q2R eta)) / (d0 * z + (dr + Q2R eta)) /\ 1 < Q2R (Y2 i) /\ Q2R (of (log_down P) i) <= ln (Q2R (Y2 i)) /\ Q2R r <= Q2R (of (log_down P) i) /\
      F + v <= Q2R (of (gmin_ P) i) * (Q2R (of gains i) * / (d1 * z + (dr + Q2R eta)) * (1 + / Q2R (Y2 i)) * (1 - Q2R r) * (Q2R (of (log_down P) i) - Q2R r))).
    { intros i Hi. cbv zeta. assert (E := Each i Hi). unfold component_check in E. rewrite !andb_true_iff in E.
      destruct E as [[[[[[[[[[[[[[[[[[E1 E2] E3] E4] E5] E6] E7] E8] E9] E10] E11] E12] E13] E14] E15] E16] E17] _] _].
      apply Qless_ok in E2, E6, E8, E13, E15, E16. apply Qle_true in E1, E3, E4, E5, E7, E9, E10, E14, E17.
      rewrite ?Q2R_0, ?Q2R_1 in *.
      assert (Z : Q2R (z_ i) = / (1 + Q2R (of (rho_ P) i))) by (unfold z_; reals; rewrite Q2R_1; ring).
      assert (Nn : Q2R (N_ i) = Q2R (of (narrowest P) i) * / (1 + Q2R (of (rho_ P) i)) - Q2R eta).
      { unfold N_. rewrite (Qeq_eqR _ _ (Qred_correct _)). reals. now rewrite Z. }
      assert (Yy1 : Q2R (Y1 i) = (Q2R (of (narrowest P) i) * (1 - / (1 + Q2R (of (rho_ P) i))) + Q2R eta) / (Q2R (of (narrowest P) i) * / (1 + Q2R (of (rho_ P) i)) - Q2R eta)).
      { unfold Y1. rewrite (Qeq_eqR _ _ (Qred_correct _)). reals. rewrite Z, Nn, Q2R_1. reflexivity. }
      assert (Mm : Q2R (most_ i) = Q2R (of gains i) * / (Q2R (of (narrowest P) i) * / (1 + Q2R (of (rho_ P) i)) - Q2R eta) * (1 + / Q2R (Y1 i)) * (1 + Q2R r) * (Q2R (of (log_up P) i) + Q2R r)).
      { unfold most_. rewrite (Qeq_eqR _ _ (Qred_correct _)). reals. rewrite Nn, Q2R_1. reflexivity. }
      assert (Ff : Q2R (force_ i) = Q2R (of (push_ P) i) + Q2R (of (cross_ P) i) * others (n k) i (fun j => Q2R (most_ j))).
      { unfold force_. rewrite (Qeq_eqR _ _ (Qred_correct _)). reals. now rewrite others_Q_ok. }
      assert (Dd : Q2R (drift_ i) = (Q2R (force_ i) + Q2R (v_ i)) * Q2R (tau_ P) + Q2R (of (gmax_ P) i) * Q2R (most_ i) * Q2R (latency_ P)).
      { unfold drift_. rewrite (Qeq_eqR _ _ (Qred_correct _)). reals. reflexivity. }
      assert (Yy2 : Q2R (Y2 i) = (Q2R (of (narrowest P) i) * (1 - / (1 + Q2R (of (rho_ P) i))) - (Q2R (drift_ i) + Q2R eta)) /
                                 (Q2R (of (narrowest P) i) * / (1 + Q2R (of (rho_ P) i)) + (Q2R (drift_ i) + Q2R eta))).
      { unfold Y2. rewrite (Qeq_eqR _ _ (Qred_correct _)). unfold A_, B_. reals. rewrite Z, Q2R_1. reflexivity. }
      rewrite Z in E7. rewrite Nn in E8.
      assert (rho1 : 1 <= Q2R (of (rho_ P) i)) by lra.
      assert (z0 : 0 < / (1 + Q2R (of (rho_ P) i)) <= 1 / 2).
      { split; [apply Rinv_0_lt_compat; lra|]. replace (1 / 2) with (/ 2) by lra. apply Rinv_le_contravar; lra. }
      assert (Y1p : 0 < Q2R (Y1 i)).
      { rewrite Yy1. apply Rdiv_lt_0_compat; [|exact E8]. assert (0 < Q2R (of (narrowest P) i) * (1 - / (1 + Q2R (of (rho_ P) i)))) by (apply Rmult_lt_0_compat; lra). lra. }
      apply ln_at_most in E11; [|exact Y1p]. apply ln_at_least in E12.
      assert (Q2 : Q2R 2 = 2) by (unfold Q2R; cbn; lra).
      unfold pull_ in E17. reals_in E16. reals_in E17. rewrite Z, Q2R_1 in *. rewrite Q2 in E16.
      assert (Vv : Q2R (v_ i) = Q2R unit * (3 * IZR (nth i Vs 0%Z)) * (INR (segments rows) / Q2R (T k))).
      { unfold v_. reals. rewrite !Q2R_Z, <- INR_IZR_INZ. replace (Q2R 3) with 3 by (unfold Q2R; cbn; lra). reflexivity. }
      unfold Rdiv. repeat split; try assumption; try lra. }
    assert (Lip : forall i, (i < n k)%nat -> lipschitz (Q2R (v_ i)) (L i) /\ lipschitz (Q2R (v_ i)) (U i)).
    { intros i Hi. destruct (Num i Hi) as (_ & _ & _ & _ & _ & _ & _ & _ & _ & Vv & _). rewrite Vv.
      split; apply (edge_lip (n k)); auto; apply St, in_seq; lia. }
    assert (Bd : forall i, (i < n k)%nat -> 1 <= Q2R (of (rho_ P) i) /\ 0 < Q2R (of (gmin_ P) i) <= Q2R (of (gmax_ P) i) /\ 0 <= Q2R (of (push_ P) i) /\ 0 <= Q2R (of (cross_ P) i) /\
      0 < Q2R (of (narrowest P) i) * / (1 + Q2R (of (rho_ P) i))).
    { intros i Hi. destruct (Num i Hi) as (r1 & g1 & p1 & c1 & d1 & _). repeat split; try lra. apply Rmult_lt_0_compat; [exact d1|apply Rinv_0_lt_compat; lra]. }
    apply (held_stays (n k) taken switch (fun i => Q2R (of (rho_ P) i)) (fun i => Q2R (of (gmin_ P) i)) (fun i => Q2R (of (gmax_ P) i)) (fun i => Q2R (of (push_ P) i))
      (fun i => Q2R (of (cross_ P) i)) (fun i => Q2R (of (narrowest P) i) * / (1 + Q2R (of (rho_ P) i))) (Q2R (tau_ P)) (Q2R (latency_ P)) L U x y g input
      (fun i _ => Q2R (v_ i)) (fun i _ => Q2R (most_ i))).
    - exact clock.
    - exact Bd.
    - intros i t Hi. destruct (Lip i Hi) as [A B]. split; [now apply x_cont|split; eapply lipschitz_cont; eauto].
    - intros i t Hi. destruct (widths_ok i t Hi) as [A _]. destruct (Bd i Hi) as (r1 & _). apply Rmult_le_compat_r; [left; apply Rinv_0_lt_compat; lra|exact A].
    - intros i m Hi M0. destruct (Num i Hi) as (_ & _ & _ & _ & _ & _ & _ & m0 & v0 & _). split; [exact v0|split; [exact m0|]].
      intros q _ Hq. destruct (Lip i Hi) as [A B]. specialize (A q m). specialize (B q m). rewrite (Rabs_pos_eq (m - q)) in A, B by lra. auto.
    - exact start.
    - exact ode.
    - intros p m i Hi Kp _ _. destruct (Num i Hi) as (r1 & g1 & p1 & c1 & d0 & cz & N0 & m0 & v0 & _ & Hy & Hl & Hm & _).
      destruct (Own i Hi) as (gp & Lp & Lm). destruct (law p i Hi) as (a & b & Ha & Hb & Hs & Act). destruct (Kp i Hi) as [K1 K2]. destruct (widths_ok i (taken p) Hi) as [W1 W2].
      assert (z0 : 0 < / (1 + Q2R (of (rho_ P) i)) <= 1 / 2).
      { split; [apply Rinv_0_lt_compat; lra|]. replace (1 / 2) with (/ 2) by lra. apply Rinv_le_contravar; lra. }
      assert (Nb : 0 < Q2R (of gains i) /\ 0 < Q2R c <= / (1 + Q2R (of (rho_ P) i)) /\ / (1 + Q2R (of (rho_ P) i)) <= 1 / 2 /\ 0 <= Q2R r <= 1 / 2 /\ Q2R c <= 1 / 4 /\ 0 <= Q2R eta)
        by (rewrite Q2R_0 in *; repeat split; lra).
      rewrite Hm. apply (acts_most (Q2R (of gains i)) (Q2R c) (Q2R r) (Q2R eta) (/ (1 + Q2R (of (rho_ P) i))) (option_map Q2R (nth i limits None)) Nb Lp
        (x i (taken p) - L i (taken p)) (U i (taken p) - x i (taken p)) a b (input p i) (Q2R (of (narrowest P) i)) (Q2R (Y1 i)) (Q2R (of (log_up P) i)) Act Ha Hb); auto; try lra.
    - intros p m i Hi Kp Hm. destruct (Num i Hi) as (r1 & g1 & p1 & c1 & d0 & cz & N0 & m0 & v0 & _ & Hy & Hl & Hmo & Hf & Hd & Hside & _).
      destruct (Own i Hi) as (gp & Lp & Lm). destruct (law p i Hi) as (a & b & Ha & Hb & Hs & Act). destruct (widths_ok i (taken p) Hi) as [W1 W2]. destruct (widths_ok i m Hi) as [W3 W4].
      assert (z0 : 0 < / (1 + Q2R (of (rho_ P) i)) <= 1 / 2).
      { split; [apply Rinv_0_lt_compat; lra|]. replace (1 / 2) with (/ 2) by lra. apply Rinv_le_contravar; lra. }
      assert (Nb : 0 < Q2R (of gains i) /\ 0 < Q2R c <= / (1 + Q2R (of (rho_ P) i)) /\ / (1 + Q2R (of (rho_ P) i)) <= 1 / 2 /\ 0 <= Q2R r <= 1 / 2 /\ Q2R c <= 1 / 4 /\ 0 <= Q2R eta)
        by (rewrite Q2R_0 in *; repeat split; lra).
      assert (Wm : Q2R (of (narrowest P) i) * ((Q2R (of (rho_ P) i) - 1) / (Q2R (of (rho_ P) i) + 1)) <= (U i m - L i m) * ((Q2R (of (rho_ P) i) - 1) / (Q2R (of (rho_ P) i) + 1))).
      { apply Rmult_le_compat_r; [|exact W3]. apply Rmult_le_pos; [lra|left; apply Rinv_0_lt_compat; lra]. }
      assert (Fo : Held.force (n k) (fun i => Q2R (of (push_ P) i)) (fun i => Q2R (of (cross_ P) i)) (fun i _ => Q2R (most_ i)) i m = Q2R (force_ i)) by (unfold force; symmetry; exact Hf).
      rewrite Fo. cbv beta. split; intro Q.
      + apply (acts_side (Q2R (of gains i)) (Q2R c) (Q2R r) (Q2R eta) (/ (1 + Q2R (of (rho_ P) i))) (option_map Q2R (nth i limits None)) Nb Lp
          (x i (taken p) - L i (taken p)) (U i (taken p) - x i (taken p)) a b (input p i) (Q2R (of (widest P) i)) Act Ha Hb Hs); lra.
      + apply acts_opp in Act; [|exact Lp|lra|exact Hs].
        assert (- input p i <= 0); [|lra].
        apply (acts_side (Q2R (of gains i)) (Q2R c) (Q2R r) (Q2R eta) (/ (1 + Q2R (of (rho_ P) i))) (option_map Q2R (nth i limits None)) Nb Lp
          (U i (taken p) - x i (taken p)) (x i (taken p) - L i (taken p)) b a (- input p i) (Q2R (of (widest P) i)) Act Hb Ha); lra.
    - intros p m i Hi Kp Hm Hw. destruct (Num i Hi) as (r1 & g1 & p1 & c1 & d0 & cz & N0 & m0 & v0 & _ & Hy & Hl & Hmo & Hf & Hd & Hside & Hy2 & Hy3 & Hl2 & Hr2 & Hp).
      destruct (Own i Hi) as (gp & Lp & Lm). destruct (law p i Hi) as (a & b & Ha & Hb & Hs & Act). destruct (widths_ok i (taken p) Hi) as [W1 W2]. destruct (widths_ok i m Hi) as [W3 W4].
      assert (z0 : 0 < / (1 + Q2R (of (rho_ P) i)) <= 1 / 2).
      { split; [apply Rinv_0_lt_compat; lra|]. replace (1 / 2) with (/ 2) by lra. apply Rinv_le_contravar; lra. }
      assert (Nb : 0 < Q2R (of gains i) /\ 0 < Q2R c <= / (1 + Q2R (of (rho_ P) i)) /\ / (1 + Q2R (of (rho_ P) i)) <= 1 / 2 /\ 0 <= Q2R r <= 1 / 2 /\ Q2R c <= 1 / 4 /\ 0 <= Q2R eta)
        by (rewrite Q2R_0 in *; repeat split; lra).
      assert (Fo : forall m, Held.force (n k) (fun i => Q2R (of (push_ P) i)) (fun i => Q2R (of (cross_ P) i)) (fun i _ => Q2R (most_ i)) i m = Q2R (force_ i)) by (intro; unfold force; symmetry; exact Hf).
      assert (Dr : Held.drift (n k) (fun i => Q2R (of (gmax_ P) i)) (fun i => Q2R (of (push_ P) i)) (fun i => Q2R (of (cross_ P) i)) (Q2R (tau_ P)) (Q2R (latency_ P))
        (fun i _ => Q2R (v_ i)) (fun i _ => Q2R (most_ i)) i m = Q2R (drift_ i)) by (unfold drift; rewrite Fo; symmetry; exact Hd).
      rewrite Fo, Dr. cbv beta in *.
      assert (Rz : Q2R (of (rho_ P) i) / (1 + Q2R (of (rho_ P) i)) = 1 - / (1 + Q2R (of (rho_ P) i))) by (field; lra). rewrite Rz.
      assert (F0 : 0 <= Q2R (force_ i)).
      { rewrite Hf. apply Rplus_le_le_0_compat; [exact p1|]. apply Rmult_le_pos; [exact c1|]. apply others_nonneg. intros j Hj. destruct (Num j Hj) as (_ & _ & _ & _ & _ & _ & _ & mj & _). exact mj. }
      rewrite Q2R_0 in *.
      assert (Vt : 0 <= Q2R (v_ i) * Q2R (tau_ P) <= Q2R (drift_ i)).
      { rewrite Hd. assert (0 <= Q2R (v_ i) * Q2R (tau_ P)) by (apply Rmult_le_pos; lra). assert (0 <= Q2R (force_ i) * Q2R (tau_ P)) by (apply Rmult_le_pos; lra).
        assert (0 <= Q2R (of (gmax_ P) i) * Q2R (most_ i) * Q2R (latency_ P)) by (apply Rmult_le_pos; [apply Rmult_le_pos|]; lra). lra. }
      split; intros Q3 Q4.
      + apply (acts_pull (Q2R (of gains i)) (Q2R c) (Q2R r) (Q2R eta) (/ (1 + Q2R (of (rho_ P) i))) (option_map Q2R (nth i limits None)) Nb Lp
          (x i (taken p) - L i (taken p)) (U i (taken p) - x i (taken p)) a b (input p i) (U i m - L i m) (Q2R (of (narrowest P) i)) (Q2R (of (widest P) i)) (Q2R (drift_ i))
          (Q2R (v_ i) * Q2R (tau_ P)) _ _ (Q2R (Y2 i)) (Q2R (of (log_down P) i)) (Q2R (of (gmin_ P) i)) (Q2R (force_ i) + Q2R (v_ i)) Act Ha Hb Hs ltac:(lra) d0 Vt ltac:(lra) Q3 Q4 eq_refl eq_refl Hy2 Hy3 Hl2 Hr2);
          [lra|exact Hp|exact Lm].
      + replace (input p i) with (- - input p i) by ring. apply acts_opp in Act; [|exact Lp|lra|exact Hs].
        apply (acts_pull (Q2R (of gains i)) (Q2R c) (Q2R r) (Q2R eta) (/ (1 + Q2R (of (rho_ P) i))) (option_map Q2R (nth i limits None)) Nb Lp
          (U i (taken p) - x i (taken p)) (x i (taken p) - L i (taken p)) b a (- input p i) (U i m - L i m) (Q2R (of (narrowest P) i)) (Q2R (of (widest P) i)) (Q2R (drift_ i))
          (Q2R (v_ i) * Q2R (tau_ P)) _ _ (Q2R (Y2 i)) (Q2R (of (log_down P) i)) (Q2R (of (gmin_ P) i)) (Q2R (force_ i) + Q2R (v_ i)) Act Hb Ha ltac:(lra) ltac:(lra) d0 Vt ltac:(lra) Q3 Q4 eq_refl eq_refl Hy2 Hy3 Hl2 Hr2);
          [lra|exact Hp|exact Lm].
  Qed.
End Uniform.
