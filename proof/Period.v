(* P9: the numbers under which held inputs keep the state, decided by evaluation, window by window; and the theorem of the sampled
   closed loop, from the emitted edges, the clock and the sensors to the sets of the task. *)
From Coq Require Import ZArith QArith Qreals Qabs Qminmax Reals List Bool Lia Lra Psatz.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed Rounding Emitted EmittedTube Held HeldLaw Windows.
Import ListNotations.
Open Scope R_scope.

(* Of one component. limit: u_max, where there is one. shift: what the law sees of a distance is wrong by at most that. *)
Record component := Component {
  gain : Q; clamped : Q; limit : option Q; rho_of : Q; pushed : Q; g_min : Q; g_max : Q; g_cross : Q; shift : Q }.
(* lost: by the arithmetic of the law, in relative terms and of the logarithm. *)
Record sampling := Sampling { tau_of : Q; latency_of : Q; share_of : Q; lost : Q; components : list component }.
Definition nobody : component := Component 0 0 None 0 0 0 0 0 0.
Definition part (s : sampling) (i : nat) : component := nth i (components s) nobody.

(* a .. a + m h in m cells. *)
Fixpoint cells (m : nat) (a h : Q) : list (Q * Q) := match m with O => [] | S j => (a, Qred (a + h)) :: cells j (Qred (a + h)) h end.

Lemma cells_cover m : forall a h d, Q2R a <= d -> d <= Q2R a + INR m * Q2R h -> (0 < m)%nat -> exists c, In c (cells m a h) /\ Q2R (fst c) <= d <= Q2R (snd c).
Proof.
  induction m; intros a h d A B M; [lia|]. cbn [cells].
  assert (E : Q2R (Qred (a + h)) = Q2R a + Q2R h) by (rewrite Q2R_red; apply Q2R_plus).
  destruct (Rle_dec d (Q2R (Qred (a + h)))) as [L|L].
  - exists (a, Qred (a + h)). split; [now left|split; [exact A|exact L]].
  - destruct m as [|m].
    { rewrite S_INR in B; cbn [INR] in B. lra. }
    destruct (IHm (Qred (a + h)) h d) as (c & I & Hc); [lra| |lia|exists c; split; [now right|exact Hc]].
    rewrite E. rewrite S_INR in B. lra.
Qed.

Section Check.
  Variables (unit : Q) (k : task) (rows : table) (s : sampling).
  Variables (hints : list (list (Q * Q))).    (* by window and component: a bound on |u|, and one on the logarithm in it *)
  Variable parts : nat.                        (* into so many the range of a window's width is cut *)
  Let K := inject_Z (Z.of_nat (segments rows)).

  Definition z_of (i : nat) : Q := / (1 + rho_of (part s i)).
  Definition narrow (w i : nat) : Q := unit * inject_Z (least (between_edges rows i w)).
  Definition broad (w i : nat) : Q := unit * inject_Z (most_of (between_edges rows i w)).
  Definition seen (w i : nat) : Q := Qmin (narrow w i) (narrow (w - 1) i).
  Definition broadest (w i : nat) : Q := Qmax (broad w i) (broad (w - 1) i).
  Definition quick (w i : nat) : Q := unit * (3 * inject_Z (steepest_at rows i w)) * (K / T k).
  Definition most_q (w i : nat) : Q := fst (nth i (nth w hints []) (0, 0)%Q).
  Fixpoint others_q (m i : nat) (w : nat) : Q :=
    match m with O => 0 | S j => (if Nat.eq_dec j i then 0 else most_q w j) + others_q j i w end.
  Definition force_q (w i : nat) : Q := Qred (pushed (part s i) + g_cross (part s i) * others_q (n k) i w).

  Definition less (a b : Q) : bool := positive (b - a).

  (* |u| is at most U: it is limited to that, or the law makes no more of what it may see. *)
  Definition most_check (w i : nat) : bool :=
    let c := part s i in let U := most_q w i in
    if Qle_bool 0 U then
      if match limit c with Some m => Qle_bool m U | None => false end then true
      else
        let z := z_of i in let d := seen w i in let l := snd (nth i (nth w hints []) (0, 0)%Q) in
        let N := Qred (d * z - shift c) in let Y := Qred ((d * (1 - z) + shift c) / N) in
        if positive N then if exp_at_least l Y then Qle_bool (gain c * / N * (1 + / Y) * (1 + lost s) * (l + lost s)) U else false else false
    else false.

  Definition pull_check (i : nat) (P drift : Q) (cell : Q * Q) : bool :=
    let c := part s i in let z := z_of i in
    let A := Qred (fst cell * (1 - z) - (drift + shift c)) in let B0 := Qred (fst cell * z + (drift + shift c)) in
    let B := Qred (snd cell * z + (drift + shift c)) in
    if (positive (fst cell) && positive B0 && positive B && less B0 A)%bool then
      let Y := Qred (A / B0) in
      let most_pull := Qred (g_min c * gain c * / B * (1 + / Y) * (1 - lost s)) in
      if positive most_pull then let l := Qred (P / most_pull + lost s) in exp_at_most l Y else false
    else false.

  Definition window_check (w i : nat) : bool :=
    let c := part s i in let z := z_of i in let v := quick w i in let f := force_q w i in let U := most_q w i in
    let P := Qred (f + v) in
    if most_check w i then
      if (positive (narrow w i) && Qle_bool (narrow w i) (broad w i))%bool then
        if less (2 * shift c + lost s * (broadest w i + 2 * shift c))
                (narrow w i * ((rho_of c - 1) / (rho_of c + 1)) - 2 * ((P + g_max c * U) * tau_of s))
        then if match limit c with Some m => Qle_bool P (g_min c * m) | None => true end
          then forallb (pull_check i P (Qred (P * tau_of s + g_max c * U * latency_of s)))
                 (cells parts (narrow w i) ((broad w i - narrow w i) * (1 # Pos.of_nat parts)))
          else false
        else false
      else false
    else false.

  Definition component_check (err : Q) (i : nat) : bool :=
    let c := part s i in
    positive (gain c) && positive (clamped c) && Qle_bool (clamped c * (1 + rho_of c)) 1 && Qle_bool 1 (rho_of c) &&
    Qle_bool (clamped c) (1 # 4) && positive (g_min c) && Qle_bool (g_min c) (g_max c) && Qle_bool 0 (g_cross c) && Qle_bool 0 (pushed c) &&
    Qle_bool err (shift c) && match limit c with Some m => Qle_bool 0 m | None => true end &&
    Qle_bool (share_of s) ((rho_of c - 1) / (rho_of c + 1)).

  Definition period_check (err : Q) : bool :=
    (0 <? parts)%nat && Qle_bool 0 (lost s) && Qle_bool (lost s) (1 # 2) && positive (tau_of s) && Qle_bool 0 (latency_of s) &&
    Qle_bool (K / T k * (if Qle_bool (latency_of s) 0 then tau_of s else 2 * tau_of s)) 1 &&
    forallb (component_check err) (seq 0 (n k)) &&
    forallb (fun w => forallb (window_check w) (seq 0 (n k))) (seq 0 (S (segments rows))).
End Check.

Lemma less_ok a b : less a b = true -> Q2R a < Q2R b.
Proof. unfold less. intro H. apply positive_ok in H. rewrite Q2R_minus in H. lra. Qed.
Lemma Q2R_inv_pos q : 0 < Q2R q -> Q2R (/ q) = / Q2R q.
Proof. intro H. apply Q2R_inv. intro E. apply Qeq_eqR in E. rewrite Q2R_0 in E. lra. Qed.
Lemma Q2R_div_pos a q : 0 < Q2R q -> Q2R (a / q) = Q2R a / Q2R q.
Proof. intro H. apply Q2R_div. intro E. apply Qeq_eqR in E. rewrite Q2R_0 in E. lra. Qed.

Lemma total_others m i u : (i < m)%nat -> total m u = u i + others m i u.
Proof.
  induction m; intro H; [lia|]. cbn. destruct (Nat.eq_dec m i) as [->|Ne]; [|rewrite IHm by lia; ring].
  assert (E : forall j, (j <= i)%nat -> total j u = others j i u).
  { induction j; intro Hj; cbn; [reflexivity|]. destruct (Nat.eq_dec j i); [lia|]. rewrite IHj by lia. reflexivity. }
  rewrite (E i) by lia. ring.
Qed.
Lemma others_small m i u v b : 0 <= b -> (forall j, (j < m)%nat -> j <> i -> Rabs (u j) <= b * v j) -> Rabs (others m i u) <= b * others m i v.
Proof.
  intros B H. induction m; cbn; [rewrite Rabs_R0; lra|]. assert (A := IHm ltac:(intros; apply H; lia)).
  destruct (Nat.eq_dec m i) as [->|Ne]; [rewrite !Rplus_0_l; exact A|].
  assert (C := H m ltac:(lia) Ne). eapply Rle_trans; [apply Rabs_triang|]. lra.
Qed.

Section Sampled.
  Variables (unit err : Q) (how : search) (k : task) (rows : table) (Vs : list Z).
  Variables (s : sampling) (hints : list (list (Q * Q))) (cuts : nat).
  Hypothesis checked : check unit err how k rows = true.
  Hypothesis more : slopes err k rows Vs = true.
  Hypothesis period_checked : period_check unit k rows s hints cuts err = true.

  Let L (i : nat) (t : R) := lower unit k rows i t.
  Let U (i : nat) (t : R) := upper unit k rows i t.
  Let c_ (i : nat) := part s i.
  Let tau := Q2R (tau_of s).
  Let latency := Q2R (latency_of s).
  Let rho (i : nat) := Q2R (rho_of (c_ i)).
  Let eta (i : nat) := Q2R (shift (c_ i)).
  Let lim (i : nat) := option_map Q2R (limit (c_ i)).

  Variables (taken switch : nat -> R) (low high : nat -> nat -> R) (x : nat -> R -> R) (measured : nat -> nat -> R).
  Variables (input : nat -> nat -> R) (f : nat -> R -> R) (G : nat -> nat -> R -> R).
  (* the edges that the law sees are near the exact ones of the time when sample p is taken *)
  Hypothesis edges_near : forall p i, (i < n k)%nat -> Rabs (low p i - L i (taken p)) <= Q2R err /\ Rabs (high p i - U i (taken p)) <= Q2R err.
  Hypothesis times : switch 0%nat = 0 /\ forall p, 0 <= taken p <= switch p /\ switch p < switch (S p) /\
    switch (S p) - taken p <= tau /\ switch p - taken p <= latency.
  Hypothesis x_cont : forall i t, (i < n k)%nat -> continuity_pt (x i) t.
  Hypothesis x_start : forall i, (i < n k)%nat -> Rabs (2 * x i 0 - L i 0 - U i 0) <= Q2R (share_of s) * (U i 0 - L i 0).
  Hypothesis sensors : forall p i, (i < n k)%nat -> Rabs (measured p i - x i (taken p)) <= eta i - Q2R err.
  Hypothesis law_acts : forall p i, (i < n k)%nat ->
    acts (Q2R (gain (c_ i))) (Q2R (clamped (c_ i))) (Q2R (lost s)) (lim i) (measured p i - low p i) (high p i - measured p i) (input p i).
  Hypothesis plant : forall p t, switch p < t < switch (S p) -> (forall i, (i < n k)%nat -> L i t < x i t < U i t) -> forall i, (i < n k)%nat ->
    is_derive (x i) t (f i t + total (n k) (fun j => G i j t * input p j)) /\
    Rabs (f i t) <= Q2R (pushed (c_ i)) /\ Q2R (g_min (c_ i)) <= G i i t <= Q2R (g_max (c_ i)) /\
    forall j, (j < n k)%nat -> j <> i -> Rabs (G i j t) <= Q2R (g_cross (c_ i)).

  Let win (m : R) : nat := window rows (Q2R (T k)) m.
  Let z (i : nat) : R := / (1 + rho i).
  Let most (i : nat) (m : R) : R := Q2R (most_q hints (win m) i).
  Let speed (i : nat) (m : R) : R := speed_at rows (Q2R (T k)) (Q2R unit) i (win m).

  Lemma all_checked : 0 < Q2R unit /\ 0 < Q2R (T k) /\ regular (n k) rows = true /\ 0 < Q2R (min_width k) /\ 0 <= Q2R err.
  Proof.
    pose proof checked as C. unfold check in C. cbv zeta in C. rewrite !andb_true_iff in C. destruct C as [[[Up Tp] Rg] _].
    pose proof more as M. unfold slopes in M. rewrite !andb_true_iff in M. destruct M as [[Mw Er] _].
    apply positive_ok in Up, Tp, Mw. apply Qle_true in Er. rewrite Q2R_0 in Er. repeat split; auto.
  Qed.

  Lemma period_parts : (0 < cuts)%nat /\ 0 <= Q2R (lost s) <= 1 / 2 /\ 0 < tau /\ 0 <= latency /\
    (INR (segments rows) / Q2R (T k) * tau <= 1) /\ (latency <> 0 -> INR (segments rows) / Q2R (T k) * (2 * tau) <= 1) /\
    (forall i, (i < n k)%nat -> component_check s err i = true) /\
    (forall w i, (w <= segments rows)%nat -> (i < n k)%nat -> window_check unit k rows s hints cuts w i = true).
  Proof.
    destruct all_checked as (Up & Tp & _).
    pose proof period_checked as P. unfold period_check in P. cbv zeta in P. rewrite !andb_true_iff in P.
    destruct P as [[[[[[[A B] C] D] E] F] H] W].
    rewrite forallb_forall in H, W. apply Qle_true in B, C, E, F. apply positive_ok in D. rewrite Q2R_0 in B, E.
    replace (Q2R (1 # 2)) with (1 / 2) in C by (unfold Q2R; cbn; lra). rewrite Q2R_1 in F.
    assert (KR : Q2R (inject_Z (Z.of_nat (segments rows))) = INR (segments rows)) by (now rewrite Q2R_Z, <- INR_IZR_INZ).
    assert (R0 : 0 <= INR (segments rows) / Q2R (T k)) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    split; [now apply Nat.ltb_lt|]. split; [lra|]. split; [exact D|]. split; [exact E|].
    rewrite Q2R_mult, Q2R_div_pos, KR in F by exact Tp.
    assert (S1 : INR (segments rows) / Q2R (T k) * tau <= INR (segments rows) / Q2R (T k) * (2 * tau)) by (apply Rmult_le_compat_l; [exact R0|unfold tau; lra]).
    destruct (Qle_bool (latency_of s) 0) eqn:Z0.
    - apply Qle_true in Z0. rewrite Q2R_0 in Z0. split; [exact F|]. split; [intro Ne; exfalso; apply Ne; unfold latency; lra|].
      split; [intros i Hi; apply H, in_seq; lia|]. intros w i Hw Hi. specialize (W w ltac:(apply in_seq; lia)). rewrite forallb_forall in W. apply W, in_seq; lia.
    - rewrite Q2R_mult, Q2R_2 in F. fold tau in F. split; [lra|]. split; [intros _; exact F|].
      split; [intros i Hi; apply H, in_seq; lia|]. intros w i Hw Hi. specialize (W w ltac:(apply in_seq; lia)). rewrite forallb_forall in W. apply W, in_seq; lia.
  Qed.

  Lemma component_parts i : (i < n k)%nat -> let c := c_ i in
    0 < Q2R (gain c) /\ 0 < Q2R (clamped c) <= z i /\ z i <= 1 / 2 /\ 1 <= rho i /\ Q2R (clamped c) <= 1 / 4 /\
    0 < Q2R (g_min c) <= Q2R (g_max c) /\ 0 <= Q2R (g_cross c) /\ 0 <= Q2R (pushed c) /\ Q2R err <= eta i /\
    (forall m, lim i = Some m -> 0 <= m) /\ Q2R (share_of s) <= (rho i - 1) / (rho i + 1).
  Proof.
    intros Hi c. destruct period_parts as (_ & _ & _ & _ & _ & _ & Cc & _). specialize (Cc i Hi).
    unfold component_check in Cc. cbv zeta in Cc. fold (c_ i) in Cc. fold c in Cc. rewrite !andb_true_iff in Cc.
    destruct Cc as [[[[[[[[[[[A B] C] D] E] F] H] I] J] M] N] O].
    apply positive_ok in A, B, F. apply Qle_true in C, D, E, H, I, J, M, O. rewrite Q2R_0 in I, J. rewrite Q2R_1 in C, D.
    rewrite Q2R_mult, Q2R_plus, Q2R_1 in C. replace (Q2R (1 # 4)) with (1 / 4) in E by (unfold Q2R; cbn; lra).
    fold c in A, B, C, D, E, F, H, I, J, M, N, O. fold (rho i) in C, D.
    assert (P1 : 0 < Q2R (rho_of c + 1)) by (rewrite Q2R_plus, Q2R_1; unfold rho, c in *; lra).
    rewrite Q2R_div_pos, Q2R_plus, Q2R_minus, Q2R_1 in O by exact P1.
    unfold z. change (Q2R (rho_of c)) with (rho i) in *.
    assert (Z1 : / (1 + rho i) <= 1 / 2) by (apply Rle_trans with (/ 2); [apply Rinv_le_contravar; lra|lra]).
    assert (Cz : Q2R (clamped c) <= / (1 + rho i)).
    { apply (Rmult_le_reg_r (1 + rho i)); [lra|]. rewrite Rinv_l by lra. exact C. }
    repeat split; auto; try lra.
    intros m Hm. unfold lim in Hm. fold c in Hm. destruct (limit c) as [q|]; cbn in Hm; [|easy]. injection Hm as <-.
    apply Qle_true in N. rewrite Q2R_0 in N. exact N.
  Qed.
  Lemma z_value i : (i < n k)%nat -> Q2R (z_of s i) = z i.
  Proof.
    intro Hi. destruct (component_parts i Hi) as (_ & _ & _ & r1 & _). unfold z_of, z. fold (c_ i).
    rewrite Q2R_inv_pos, Q2R_plus, Q2R_1; [reflexivity|]. rewrite Q2R_plus, Q2R_1. unfold rho in r1. lra.
  Qed.

  Lemma others_value m i w : Q2R (others_q hints m i w) = others m i (fun j => Q2R (most_q hints w j)).
  Proof.
    induction m; cbn [others_q others]; [exact Q2R_0|]. rewrite Q2R_plus, IHm. destruct (Nat.eq_dec m i); [now rewrite Q2R_0|reflexivity].
  Qed.
  Lemma force_value w i : Q2R (force_q k s hints w i) =
    Q2R (pushed (c_ i)) + Q2R (g_cross (c_ i)) * others (n k) i (fun j => Q2R (most_q hints w j)).
  Proof. unfold force_q. rewrite Q2R_red, Q2R_plus, Q2R_mult, others_value. reflexivity. Qed.

  Let nar (w i : nat) : R := Q2R unit * IZR (least (between_edges rows i w)).
  Let bro (w i : nat) : R := Q2R unit * IZR (most_of (between_edges rows i w)).
  Lemma narrow_value w i : Q2R (narrow unit rows w i) = nar w i. Proof. unfold narrow, nar. now rewrite Q2R_mult, Q2R_Z. Qed.
  Lemma broad_value w i : Q2R (broad unit rows w i) = bro w i. Proof. unfold broad, bro. now rewrite Q2R_mult, Q2R_Z. Qed.
  Lemma quick_value w i : Q2R (quick unit k rows w i) = speed_at rows (Q2R (T k)) (Q2R unit) i w.
  Proof.
    destruct all_checked as (_ & Tp & _). unfold quick, speed_at. rewrite !Q2R_mult, Q2R_div_pos, !Q2R_Z by exact Tp.
    rewrite <- INR_IZR_INZ. replace (Q2R 3) with 3 by (unfold Q2R; cbn; lra). reflexivity.
  Qed.

  Let P_ (w i : nat) : R := Q2R (force_q k s hints w i) + speed_at rows (Q2R (T k)) (Q2R unit) i w.
  Let Um (w i : nat) : R := Q2R (most_q hints w i).
  Let drift_ (w i : nat) : R := P_ w i * tau + Q2R (g_max (c_ i)) * Um w i * latency.

  Lemma window_parts w i : (w <= segments rows)%nat -> (i < n k)%nat ->
    most_check unit rows s hints w i = true /\ 0 < nar w i <= bro w i /\
    2 * eta i + Q2R (lost s) * (Rmax (bro w i) (bro (w - 1) i) + 2 * eta i) <
      nar w i * ((rho i - 1) / (rho i + 1)) - 2 * ((P_ w i + Q2R (g_max (c_ i)) * Um w i) * tau) /\
    (forall m, lim i = Some m -> P_ w i <= Q2R (g_min (c_ i)) * m) /\
    (forall d, nar w i <= d <= bro w i -> exists cell, Q2R (fst cell) <= d <= Q2R (snd cell) /\
      exists P drift, Q2R P = P_ w i /\ Q2R drift = drift_ w i /\ pull_check s i P drift cell = true).
  Proof.
    intros Hw Hi. destruct period_parts as (Cu & _ & _ & _ & _ & _ & _ & W). specialize (W w i Hw Hi).
    destruct (component_parts i Hi) as (_ & _ & _ & r1 & _).
    unfold window_check in W. cbv zeta in W. fold (c_ i) in W.
    destruct (most_check unit rows s hints w i) eqn:M; [|easy].
    destruct (positive (narrow unit rows w i) && Qle_bool (narrow unit rows w i) (broad unit rows w i))%bool eqn:N; [|easy].
    destruct (less _ _) eqn:Sd; [|easy].
    set (P := Qred (force_q k s hints w i + quick unit k rows w i)) in *.
    assert (PV : Q2R P = P_ w i) by (unfold P, P_; now rewrite Q2R_red, Q2R_plus, quick_value).
    destruct (match limit (c_ i) with Some m => Qle_bool P (g_min (c_ i) * m) | None => true end) eqn:Li; [|easy].
    apply andb_true_iff in N. destruct N as [N1 N2]. apply positive_ok in N1. apply Qle_true in N2. rewrite narrow_value, broad_value in *.
    split; [reflexivity|]. split; [lra|]. split; [|split].
    - apply less_ok in Sd. assert (P1 : 0 < Q2R (rho_of (c_ i) + 1)) by (rewrite Q2R_plus, Q2R_1; unfold rho in r1; lra).
      rewrite Q2R_minus, Q2R_plus, !Q2R_mult, Q2R_div_pos, !Q2R_plus, Q2R_minus, !Q2R_mult, PV, Q2R_1, Q2R_2 in Sd by exact P1.
      unfold broadest in Sd. rewrite Q2R_max, !broad_value, narrow_value in Sd. exact Sd.
    - intros m Hm. unfold lim in Hm. destruct (limit (c_ i)) as [q|]; cbn in Hm; [|easy]. injection Hm as <-.
      apply Qle_true in Li. rewrite Q2R_mult, PV in Li. exact Li.
    - intros d Hd. rewrite forallb_forall in W.
      destruct (cells_cover cuts (narrow unit rows w i) ((broad unit rows w i - narrow unit rows w i) * (1 # Pos.of_nat cuts)) d) as (cell & I & Hc).
      + rewrite narrow_value. lra.
      + rewrite Q2R_mult, Q2R_minus, narrow_value, broad_value.
        assert (E : INR cuts * Q2R (1 # Pos.of_nat cuts) = 1).
        { rewrite Q2R_unit, INR_IZR_INZ. rewrite <- (Nat2Pos.id cuts) at 1 by lia. rewrite positive_nat_Z. apply Rinv_r.
          assert (0 < IZR (Z.pos (Pos.of_nat cuts))) by now apply IZR_lt. lra. }
        replace (INR cuts * ((bro w i - nar w i) * Q2R (1 # Pos.of_nat cuts))) with ((bro w i - nar w i) * (INR cuts * Q2R (1 # Pos.of_nat cuts))) by ring.
        rewrite E. lra.
      + exact Cu.
      + exists cell. split; [exact Hc|]. eexists _, _. split; [exact PV|split; [|exact (W cell I)]].
        rewrite Q2R_red, Q2R_plus, !Q2R_mult, PV. reflexivity.
  Qed.

  Lemma width_at i t : (i < n k)%nat -> nar (win t) i <= U i t - L i t <= bro (win t) i.
  Proof. intro Hi. destruct all_checked as (Up & Tp & Rg & _). unfold U, L, upper, lower. now apply (width_in_window rows _ _ (n k)). Qed.

  Lemma win_le t : (win t <= segments rows)%nat.
  Proof. apply Nat.le_min_r. Qed.

  Lemma seen_error p i : (i < n k)%nat ->
    let a := measured p i - low p i in
    let b := high p i - measured p i in
    Rabs (a - (x i (taken p) - L i (taken p))) <= eta i /\ Rabs (b - (U i (taken p) - x i (taken p))) <= eta i /\ 0 < a + b.
  Proof.
    intros Hi a b. assert (Sn := sensors p i Hi).
    assert (Up : positive unit = true).
    { pose proof checked as C. unfold check in C. cbv zeta in C. rewrite !andb_true_iff in C. apply C. }
    set (Lt := fun j r => if Req_EM_T r (taken p) then low p j else lower unit k rows j r). set (Ut := fun j r => if Req_EM_T r (taken p) then high p j else upper unit k rows j r).
    destruct (edges_near p i Hi) as [A B].
    assert (Close : forall j r, (j < n k)%nat -> Rabs (Lt j r - lower unit k rows j r) <= Q2R err /\ Rabs (Ut j r - upper unit k rows j r) <= Q2R err).
    { intros j r Hj. destruct (edges_near p j Hj) as [A' B']. pose proof (Rabs_pos (low p j - L j (taken p))).
      unfold Lt, Ut. destruct (Req_EM_T r (taken p)) as [->|_]; [split; [exact A'|exact B']|]. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. split; lra. }
    destruct (tube_sound unit err Up k rows how checked Lt Ut Close) as (P1 & _).
    assert (W := P1 i (taken p) Hi). unfold Lt, Ut in W. destruct (Req_EM_T (taken p) (taken p)) as [_|Ne]; [|congruence]. destruct all_checked as (_ & _ & _ & Mw & _).
    apply Rabs_le_between in Sn, A, B.
    repeat split; [apply Rabs_le; unfold a; lra|apply Rabs_le; unfold b; lra|unfold a, b; lra].
  Qed.

  Lemma clamp_limit m v : 0 <= m -> Rabs (clamp (Some m) v) <= m.
  Proof. intro H. cbn. apply Rabs_le. unfold Rmax, Rmin; repeat destruct Rle_dec; lra. Qed.

  Let keep (t : R) : Prop := keeps (n k) rho L U x t.

  Lemma law_most' p m i : (i < n k)%nat -> keep (taken p) -> taken p <= m <= taken p + 2 * tau ->
    (latency = 0 -> m <= taken p + tau) -> Rabs (input p i) <= most i m.
  Proof.
    intros Hi Kp Hm Hl. destruct all_checked as (Up & Tp & Rg & _ & er0).
    destruct period_parts as (_ & R & T0 & L0 & Ta & Tb & _).
    destruct (component_parts i Hi) as (k0 & (cl0 & clz) & zh & r1 & c4 & g0 & gc & pu & er & li & _).
    destruct (window_parts (win m) i (win_le m) Hi) as (M & _).
    assert (R0 : 0 <= INR (segments rows) / Q2R (T k)) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    assert (D : INR (segments rows) / Q2R (T k) * (m - taken p) <= 1).
    { destruct (Req_dec latency 0) as [Z0|Z0].
      - specialize (Hl Z0). apply Rle_trans with (2 := Ta). apply Rmult_le_compat_l; lra.
      - apply Rle_trans with (2 := Tb Z0). apply Rmult_le_compat_l; lra. }
    destruct (seen_error p i Hi) as (Ea & Eb & Hs). cbv zeta in Ea, Eb, Hs.
    assert (Act := law_acts p i Hi).
    unfold most. unfold most_check in M. cbv zeta in M. fold (c_ i) in M.
    destruct (Qle_bool 0 (most_q hints (win m) i)) eqn:U0; [|easy]. apply Qle_true in U0. rewrite Q2R_0 in U0.
    destruct (match limit (c_ i) with Some m0 => Qle_bool m0 (most_q hints (win m) i) | None => false end) eqn:Li.
    { unfold lim in Act, li. destruct (limit (c_ i)) as [q|]; [|easy]. apply Qle_true in Li. cbn [option_map] in *.
      destruct Act as (e1 & e2 & _ & _ & ->). eapply Rle_trans; [apply clamp_limit, (li _ eq_refl)|exact Li]. }
    set (N := Qred (seen unit rows (win m) i * z_of s i - shift (c_ i))) in *.
    destruct (positive N) eqn:PN; [|easy]. apply positive_ok in PN.
    set (Y := Qred ((seen unit rows (win m) i * (1 - z_of s i) + shift (c_ i)) / N)) in *.
    set (l := snd (nth i (nth (win m) hints []) (0, 0)%Q)) in *.
    destruct (exp_at_least l Y) eqn:E; [|easy]. apply Qle_true in M.
    assert (NV : Q2R N = Q2R (seen unit rows (win m) i) * z i - eta i).
    { unfold N. now rewrite Q2R_red, Q2R_minus, Q2R_mult, z_value. }
    assert (YV : Q2R Y = (Q2R (seen unit rows (win m) i) * (1 - z i) + eta i) / (Q2R (seen unit rows (win m) i) * z i - eta i)).
    { unfold Y. rewrite Q2R_red, Q2R_div_pos, Q2R_plus, Q2R_mult, Q2R_minus, Q2R_1, z_value, NV by assumption. reflexivity. }
    assert (z0 : 0 < z i) by lra.
    assert (dpos : 0 < Q2R (seen unit rows (win m) i)).
    { apply (Rmult_lt_reg_r (z i)); [exact z0|]. rewrite NV in PN. lra. }
    assert (Ypos : 0 < Q2R Y).
    { rewrite YV. apply Rdiv_lt_0_compat; [|rewrite <- NV; exact PN].
      assert (0 < Q2R (seen unit rows (win m) i) * (1 - z i)) by (apply Rmult_lt_0_compat; lra). lra. }
    assert (El := ln_at_most _ _ E Ypos).
    destruct (Kp i Hi) as [K1 K2]. fold (z i) in K1, K2.
    assert (Wd : Q2R (seen unit rows (win m) i) <= U i (taken p) - L i (taken p)).
    { assert (Wi := width_at i (taken p) Hi). unfold seen. rewrite Q2R_min, !narrow_value.
      destruct (window_before rows (Q2R (T k)) (n k) i Hi Tp (taken p) m ltac:(lra) D) as [Q|Q]; fold (win (taken p)) (win m) in Q; rewrite Q in Wi;
        unfold Rmin; destruct Rle_dec; lra. }
    assert (Fin := acts_most (Q2R (gain (c_ i))) (Q2R (clamped (c_ i))) (Q2R (lost s)) (eta i) (z i) (lim i)
      (conj k0 (conj (conj cl0 clz) (conj zh (conj R (conj c4 (Rle_trans _ _ _ (proj2 (proj2 (proj2 (proj2 all_checked)))) er)))))) li (x i (taken p) - L i (taken p)) (U i (taken p) - x i (taken p)) _ _ (input p i)
      (Q2R (seen unit rows (win m) i)) (Q2R Y) (Q2R l) Act Ea Eb ltac:(lra)).
    replace (x i (taken p) - L i (taken p) + (U i (taken p) - x i (taken p))) with (U i (taken p) - L i (taken p)) in Fin by ring.
    specialize (Fin K1 K2 ltac:(rewrite <- NV; exact PN) YV El).
    eapply Rle_trans; [exact Fin|]. eapply Rle_trans; [right|exact M].
    rewrite !Q2R_mult, !Q2R_plus, !Q2R_inv_pos, NV, Q2R_1 by assumption. reflexivity.
  Qed.

  Lemma force_is i m : force (n k) (fun i => Q2R (pushed (c_ i))) (fun i => Q2R (g_cross (c_ i))) most i m = Q2R (force_q k s hints (win m) i).
  Proof. now rewrite force_value. Qed.
  Lemma drift_is i m : drift (n k) (fun i => Q2R (g_max (c_ i))) (fun i => Q2R (pushed (c_ i))) (fun i => Q2R (g_cross (c_ i))) tau latency speed most i m
    = drift_ (win m) i.
  Proof. unfold drift. rewrite force_is. reflexivity. Qed.

  (* In a window and the one before, the width is at most the larger of the two. *)
  Lemma width_before i r m : (i < n k)%nat -> r <= m <= r + tau -> U i r - L i r <= Rmax (bro (win m) i) (bro (win m - 1) i).
  Proof.
    intros Hi Hm. destruct all_checked as (Up & Tp & _). destruct period_parts as (_ & _ & T0 & _ & Ta & _).
    assert (R0 : 0 <= INR (segments rows) / Q2R (T k)) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    assert (D : INR (segments rows) / Q2R (T k) * (m - r) <= 1) by (apply Rle_trans with (2 := Ta); apply Rmult_le_compat_l; lra).
    assert (Wi := width_at i r Hi).
    destruct (window_before rows (Q2R (T k)) (n k) i Hi Tp r m ltac:(lra) D) as [Q|Q]; fold (win r) (win m) in Q; rewrite Q in Wi;
      unfold Rmax; destruct Rle_dec; lra.
  Qed.

  Lemma lost_small i : (i < n k)%nat -> 0 < Q2R (gain (c_ i)) /\ 0 < Q2R (clamped (c_ i)) <= z i /\ z i <= 1 / 2 /\
    0 <= Q2R (lost s) <= 1 / 2 /\ Q2R (clamped (c_ i)) <= 1 / 4 /\ 0 <= eta i.
  Proof.
    intro Hi. destruct (component_parts i Hi) as (A & B & C & _ & D & _ & _ & _ & E & _). destruct period_parts as (_ & R & _).
    destruct all_checked as (_ & _ & _ & _ & F). split; [exact A|split; [exact B|split; [exact C|split; [exact R|split; [exact D|lra]]]]].
  Qed.

  Lemma side_up i m a b a' b' u p : (i < n k)%nat -> a + b = U i (taken p) - L i (taken p) -> taken p <= m <= taken p + tau ->
    acts (Q2R (gain (c_ i))) (Q2R (clamped (c_ i))) (Q2R (lost s)) (lim i) a' b' u ->
    Rabs (a' - a) <= eta i -> Rabs (b' - b) <= eta i -> 0 < a' + b' ->
    (U i m - L i m) * ((rho i - 1) / (rho i + 1)) - 2 * ((P_ (win m) i + Q2R (g_max (c_ i)) * Um (win m) i) * tau) <= a - b -> u <= 0.
  Proof.
    intros Hi Sum Hm Act Ea Eb Hs H.
    destruct (window_parts (win m) i (win_le m) Hi) as (_ & N & Sd & _ & _).
    destruct (component_parts i Hi) as (_ & _ & _ & r1 & _ & _ & _ & _ & _ & li & _).
    apply (acts_side (Q2R (gain (c_ i))) (Q2R (clamped (c_ i))) (Q2R (lost s)) (eta i) (z i) (lim i) (lost_small i Hi) li
      a b a' b' u (Rmax (bro (win m) i) (bro (win m - 1) i)) Act Ea Eb Hs).
    - rewrite Sum. now apply width_before.
    - assert (W := width_at i m Hi).
      assert (F0 : 0 <= (rho i - 1) / (rho i + 1)) by (apply Rmult_le_pos; [lra|left; apply Rinv_0_lt_compat; lra]).
      assert (nar (win m) i * ((rho i - 1) / (rho i + 1)) <= (U i m - L i m) * ((rho i - 1) / (rho i + 1))) by (apply Rmult_le_compat_r; lra).
      lra.
  Qed.

  Lemma pull_up i m a b a' b' u p : (i < n k)%nat -> a + b = U i (taken p) - L i (taken p) -> taken p <= m <= taken p + tau -> 0 <= m ->
    acts (Q2R (gain (c_ i))) (Q2R (clamped (c_ i))) (Q2R (lost s)) (lim i) a' b' u ->
    Rabs (a' - a) <= eta i -> Rabs (b' - b) <= eta i -> 0 < a' + b' -> a + b <= (U i m - L i m) + 2 * (speed i m * tau) ->
    (U i m - L i m) * (1 - z i) - drift_ (win m) i <= a -> b <= (U i m - L i m) * z i + drift_ (win m) i ->
    P_ (win m) i <= Q2R (g_min (c_ i)) * - u.
  Proof.
    intros Hi Sum Hm M0 Act Ea Eb Hs Hw Ha Hb.
    destruct (window_parts (win m) i (win_le m) Hi) as (Mo & N & _ & Li & Pu).
    destruct (component_parts i Hi) as (_ & _ & _ & r1 & _ & g0 & gc0 & pu0 & er & li & _).
    destruct all_checked as (Up & Tp & Rg & _). destruct period_parts as (_ & R & T0 & L0 & _).
    assert (W := width_at i m Hi).
    destruct (Pu (U i m - L i m) W) as (cell & Hc & P & dr & PV & DV & Ck).
    destruct (lost_small i Hi) as (k0 & (cl0 & clz) & zh & _ & c4 & e0).
    unfold pull_check in Ck. cbv zeta in Ck. fold (c_ i) in Ck.
    set (A := Qred (fst cell * (1 - z_of s i) - (dr + shift (c_ i)))) in *.
    set (B0 := Qred (fst cell * z_of s i + (dr + shift (c_ i)))) in *.
    set (B := Qred (snd cell * z_of s i + (dr + shift (c_ i)))) in *.
    destruct (positive (fst cell) && positive B0 && positive B && less B0 A)%bool eqn:Ps; [|easy].
    rewrite !andb_true_iff in Ps. destruct Ps as [[[Pc PB0] PB] AB]. apply positive_ok in Pc, PB0, PB. apply less_ok in AB.
    set (Y := Qred (A / B0)) in *. set (mp := Qred (g_min (c_ i) * gain (c_ i) * / B * (1 + / Y) * (1 - lost s))) in *.
    destruct (positive mp) eqn:Pm; [|easy]. apply positive_ok in Pm. set (l := Qred (P / mp + lost s)) in *.
    apply ln_at_least in Ck.
    assert (AV : Q2R A = Q2R (fst cell) * (1 - z i) - (drift_ (win m) i + eta i)).
    { unfold A. rewrite Q2R_red, Q2R_minus, Q2R_mult, Q2R_minus, Q2R_plus, Q2R_1, z_value, DV by exact Hi. reflexivity. }
    assert (B0V : Q2R B0 = Q2R (fst cell) * z i + (drift_ (win m) i + eta i)).
    { unfold B0. rewrite Q2R_red, !Q2R_plus, Q2R_mult, z_value, DV by exact Hi. reflexivity. }
    assert (BV : Q2R B = Q2R (snd cell) * z i + (drift_ (win m) i + eta i)).
    { unfold B. rewrite Q2R_red, !Q2R_plus, Q2R_mult, z_value, DV by exact Hi. reflexivity. }
    assert (YV : Q2R Y = Q2R A / Q2R B0) by (unfold Y; rewrite Q2R_red; now apply Q2R_div_pos).
    assert (Y1 : 1 < Q2R Y) by (rewrite YV; apply Rcomplements.Rlt_div_r; lra).
    assert (LV : Q2R l = Q2R P / Q2R mp + Q2R (lost s)) by (unfold l; now rewrite Q2R_red, Q2R_plus, Q2R_div_pos).
    assert (mV : Q2R mp = Q2R (g_min (c_ i)) * Q2R (gain (c_ i)) * / Q2R B * (1 + / Q2R Y) * (1 - Q2R (lost s))).
    { unfold mp. rewrite Q2R_red, !Q2R_mult, Q2R_plus, Q2R_minus, !Q2R_inv_pos, Q2R_1 by lra. reflexivity. }
    assert (v0 : 0 <= speed i m) by (apply speed_at_nonneg; assumption).
    assert (U0 : 0 <= Um (win m) i).
    { unfold most_check in Mo. cbv zeta in Mo. destruct (Qle_bool 0 (most_q hints (win m) i)) eqn:Q; [|easy]. apply Qle_true in Q. now rewrite Q2R_0 in Q. }
    assert (f0 : 0 <= Q2R (force_q k s hints (win m) i)).
    { rewrite force_value. apply Rplus_le_le_0_compat; [exact pu0|]. apply Rmult_le_pos; [exact gc0|]. apply others_nonneg. intros j Hj.
      destruct (window_parts (win m) j (win_le m) Hj) as (Mj & _). unfold most_check in Mj. cbv zeta in Mj.
      destruct (Qle_bool 0 (most_q hints (win m) j)) eqn:Q; [|easy]. apply Qle_true in Q. now rewrite Q2R_0 in Q. }
    assert (P0 : 0 <= P_ (win m) i) by (unfold P_; fold (speed i m); lra).
    assert (vd : 0 <= speed i m * tau <= drift_ (win m) i).
    { split; [apply Rmult_le_pos; lra|]. unfold drift_, P_. fold (speed i m).
      assert (0 <= Q2R (force_q k s hints (win m) i) * tau) by (apply Rmult_le_pos; lra).
      assert (0 <= Q2R (g_max (c_ i)) * Um (win m) i * latency) by (apply Rmult_le_pos; [apply Rmult_le_pos|]; lra). lra. }
    assert (Pr : 0 <= Q2R P / Q2R mp) by (rewrite PV; apply Rmult_le_pos; [exact P0|left; now apply Rinv_0_lt_compat]).
    apply (acts_pull (Q2R (gain (c_ i))) (Q2R (clamped (c_ i))) (Q2R (lost s)) (eta i) (z i) (lim i) (lost_small i Hi) li
      a b a' b' u (U i m - L i m) (Q2R (fst cell)) (Q2R (snd cell)) (drift_ (win m) i) (speed i m * tau) (Q2R A) (Q2R B0) (Q2R Y) (Q2R l)
      (Q2R (g_min (c_ i))) (P_ (win m) i) Act Ea Eb Hs Hc Pc vd Hw Ha Hb AV B0V YV Y1 Ck); try lra.
    - rewrite <- BV. replace (Q2R (g_min (c_ i)) * (Q2R (gain (c_ i)) * / Q2R B * (1 + / Q2R Y) * (1 - Q2R (lost s)) * (Q2R l - Q2R (lost s))))
        with (Q2R mp * (Q2R l - Q2R (lost s))) by (rewrite mV; ring).
      rewrite LV. replace (Q2R mp * (Q2R P / Q2R mp + Q2R (lost s) - Q2R (lost s))) with (Q2R P) by (field; lra). lra.
    - exact Li.
  Qed.

  Lemma exact_tube :
    (forall i t, (i < n k)%nat -> L i t + Q2R (min_width k) <= U i t) /\
    (forall t x, (forall i, (i < n k)%nat -> L i t < x i < U i t) ->
      in_space k x /\ (forall o, In o (unsafe k) -> clear (n k) (Q2R (clearance k)) o x) /\ (Q2R (T k) <= t -> in_target k x)).
  Proof.
    assert (Up : positive unit = true).
    { pose proof checked as C. unfold check in C. cbv zeta in C. rewrite !andb_true_iff in C. apply C. }
    destruct all_checked as (_ & _ & _ & _ & er0).
    assert (Near : forall i t, (i < n k)%nat -> Rabs (L i t - lower unit k rows i t) <= Q2R err /\ Rabs (U i t - upper unit k rows i t) <= Q2R err).
    { intros i t _. unfold L, U. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. lra. }
    split; [apply (tube_sound unit err Up k rows how checked L U Near)|exact (tube_keeps unit err Up k rows how checked L U Near)].
  Qed.

  Theorem held_inside : forall p t, 0 <= t <= switch p -> keep t.
  Proof.
    destruct all_checked as (Up & Tp & Rg & Mw & er0). destruct period_parts as (_ & R & T0 & L0 & Ta & Tb & _).
    destruct exact_tube as (P1 & _).
    assert (R0 : 0 <= INR (segments rows) / Q2R (T k)) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    assert (Zpos : forall i, (i < n k)%nat -> 0 < z i).
    { intros i Hi. destruct (lost_small i Hi) as (_ & A & _). lra. }
    assert (Lip : forall i, (i < n k)%nat -> exists v, lipschitz v (L i) /\ lipschitz v (U i)).
    { intros i Hi. pose proof more as M. unfold slopes in M. rewrite !andb_true_iff, forallb_forall in M. destruct M as [_ St].
      eexists. split; apply (edge_lip (n k)); auto; apply St, in_seq; lia. }
    assert (Cont : forall i t, (i < n k)%nat -> continuity_pt (x i) t /\ continuity_pt (L i) t /\ continuity_pt (U i) t).
    { intros i t Hi. destruct (Lip i Hi) as (v & A & B). split; [now apply x_cont|]. split; eapply lipschitz_cont; eauto. }
    apply (held_stays (n k) taken switch rho (fun i => Q2R (g_min (c_ i))) (fun i => Q2R (g_max (c_ i))) (fun i => Q2R (pushed (c_ i)))
      (fun i => Q2R (g_cross (c_ i))) (fun i => Q2R (min_width k) * z i) tau latency L U x
      (fun i p t => f i t + others (n k) i (fun j => G i j t * input p j)) (fun i p t => G i i t) input speed most).
    - exact times.
    - intros i Hi. destruct (component_parts i Hi) as (_ & _ & _ & r1 & _ & g0 & gc0 & pu0 & _).
      split; [exact r1|split; [exact g0|split; [exact pu0|split; [exact gc0|]]]]. apply Rmult_lt_0_compat; [exact Mw|now apply Zpos].
    - exact Cont.
    - intros i t Hi. fold (z i). apply Rmult_le_compat_r; [left; now apply Zpos|]. specialize (P1 i t Hi). lra.
    - intros i m Hi M0. split; [now apply speed_at_nonneg|split].
      + destruct (window_parts (win m) i (win_le m) Hi) as (Mo & _). unfold most. unfold most_check in Mo. cbv zeta in Mo.
        destruct (Qle_bool 0 (most_q hints (win m) i)) eqn:Q; [|easy]. apply Qle_true in Q. now rewrite Q2R_0 in Q.
      + intros r Hr Hm.
        assert (D : INR (segments rows) / Q2R (T k) * (m - r) <= 1) by (apply Rle_trans with (2 := Ta); apply Rmult_le_compat_l; lra).
        split; [apply (edge_moves rows (Q2R (T k)) (Q2R unit) (n k) i Rg Hi Tp Up fst fst (or_introl (conj eq_refl eq_refl)))
               |apply (edge_moves rows (Q2R (T k)) (Q2R unit) (n k) i Rg Hi Tp Up snd snd (or_intror (conj eq_refl eq_refl)))]; auto; lra.
    - intros i Hi. destruct (component_parts i Hi) as (_ & _ & _ & r1 & _ & _ & _ & _ & _ & _ & Sh). specialize (P1 i 0 Hi).
      assert (X := x_start i Hi). fold (z i).
      assert (E : (rho i - 1) / (rho i + 1) = 1 - 2 * z i) by (unfold z; field; lra). rewrite E in Sh.
      assert (Q2R (share_of s) * (U i 0 - L i 0) <= (1 - 2 * z i) * (U i 0 - L i 0)) by (apply Rmult_le_compat_r; lra).
      apply Rabs_le_between in X. lra.
    - intros p t Ht Hin i Hi. destruct (plant p t Ht Hin i Hi) as (De & Fb & Gb & Gc).
      destruct (component_parts i Hi) as (_ & _ & _ & _ & _ & _ & gc0 & _). split; [|split; [|exact Gb]].
      + rewrite (total_others (n k) i _ Hi) in De.
        replace (f i t + others (n k) i (fun j => G i j t * input p j) + G i i t * input p i) with
          (f i t + (G i i t * input p i + others (n k) i (fun j => G i j t * input p j))) by ring. exact De.
      + eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat; [exact Fb|]. apply others_small; [exact gc0|].
        intros j Hj Ne. rewrite Rabs_mult. apply Rmult_le_compat_r; [apply Rabs_pos|now apply Gc].
    - intros p m i Hi Kp Hm Hl. now apply (law_most' p).
    - intros p m i Hi Kp Hm. destruct (seen_error p i Hi) as (Ea & Eb & Hs). cbv zeta in Ea, Eb, Hs. assert (Act := law_acts p i Hi).
      destruct (lost_small i Hi) as (_ & Cl & zh & _ & c4 & _).
      destruct (component_parts i Hi) as (_ & _ & _ & _ & _ & _ & _ & _ & _ & li & _).
      rewrite force_is. split; intro H.
      + eapply (side_up i m _ _ _ _ (input p i) p Hi); [|exact Hm|exact Act|exact Ea|exact Eb|exact Hs|exact H]. ring.
      + assert (- input p i <= 0); [|lra].
        eapply (side_up i m (U i (taken p) - x i (taken p)) (x i (taken p) - L i (taken p)) _ _ (- input p i) p Hi);
          [ring|exact Hm|apply (acts_opp _ _ _ _ _ _ _ li); [lra|exact Hs|exact Act]|exact Eb|exact Ea|lra|exact H].
    - intros p m i Hi Kp Hm Hw. destruct (seen_error p i Hi) as (Ea & Eb & Hs). cbv zeta in Ea, Eb, Hs. assert (Act := law_acts p i Hi).
      destruct (lost_small i Hi) as (_ & Cl & zh & _ & c4 & _).
      destruct (component_parts i Hi) as (_ & _ & _ & r1 & _ & _ & _ & _ & _ & li & _).
      assert (M0 : 0 <= m) by (destruct times as [_ C]; destruct (C p) as (A & _); lra).
      assert (E1 : rho i / (1 + rho i) = 1 - z i) by (unfold z; field; lra). rewrite E1, drift_is, force_is. fold (z i).
      split; intros Ha Hb.
      + eapply (pull_up i m _ _ _ _ (input p i) p Hi); [|exact Hm|exact M0|exact Act|exact Ea|exact Eb|exact Hs| |exact Ha|exact Hb]; [ring|lra].
      + rewrite <- (Ropp_involutive (input p i)).
        eapply (pull_up i m (U i (taken p) - x i (taken p)) (x i (taken p) - L i (taken p)) _ _ (- input p i) p Hi);
          [ring|exact Hm|exact M0|apply (acts_opp _ _ _ _ _ _ _ li); [lra|exact Hs|exact Act]|exact Eb|exact Ea|lra|lra|exact Ha|exact Hb].
  Qed.

  (* In the words of the task. *)
  Theorem samples_reach_avoid_stay : forall p t, 0 <= t <= switch p ->
    (forall i, (i < n k)%nat -> Rabs (2 * x i t - L i t - U i t) <= (rho i - 1) / (rho i + 1) * (U i t - L i t)) /\
    in_space k (fun i => x i t) /\
    (forall o, In o (unsafe k) -> clear (n k) (Q2R (clearance k)) o (fun i => x i t)) /\
    (Q2R (T k) <= t -> in_target k (fun i => x i t)).
  Proof.
    intros p t Ht. assert (Kp := held_inside p t Ht). destruct exact_tube as [P1 Keeps].
    destruct all_checked as (_ & _ & _ & Mw & _).
    assert (In_ : forall i, (i < n k)%nat -> L i t < x i t < U i t).
    { intros i Hi. destruct (Kp i Hi) as [A B]. fold (z i) in A, B. specialize (P1 i t Hi). destruct (lost_small i Hi) as (_ & C & _).
      assert (0 < (U i t - L i t) * z i) by (apply Rmult_lt_0_compat; lra). lra. }
    split; [|exact (Keeps t _ In_)].
    intros i Hi. destruct (Kp i Hi) as [A B]. fold (z i) in A, B. destruct (component_parts i Hi) as (_ & _ & _ & r1 & _).
    assert (E : (rho i - 1) / (rho i + 1) = 1 - 2 * z i) by (unfold z; field; lra). rewrite E. apply Rabs_le. lra.
  Qed.
End Sampled.

(* The same on the emitted edges, for a clock that shows a number at every time. *)
Definition sampled_reach_avoid_stay format unit err how k rows Vs sc late s hints cuts checked more (rounding : rounding_check format unit err k rows Vs sc late = true) period_checked
  taken switch (clock : R -> R) x measured input f G (clock_reads : forall t, reads format (clock t) t) :=
  samples_reach_avoid_stay unit err how k rows Vs s hints cuts checked more period_checked taken switch
    (fun p i => emitted format unit rows sc fst i (clock (taken p))) (fun p i => emitted format unit rows sc snd i (clock (taken p))) x measured input f G
    (fun p i Hi => emitted_near format unit err how k rows Vs sc late checked more rounding clock clock_reads i (taken p) Hi).
