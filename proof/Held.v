(* The closed loop with held inputs: each is computed from a sample and acts until the next one. The state keeps to an inner tube
   whose edges divide the tube's width by rho, the same at all times; so it keeps |e| <= (rho - 1)/(rho + 1).

   The argument, as in docs/lemmas.md (sampled.sharp): an input is constant while it acts. Either it pushes inwards harder than
   anything pushes outwards, and then the inner edge is not passed while it acts. Or its sample was taken far from the edge, and
   then the state cannot have come to the edge, because the sample is no older than tau. *)
From Coq Require Import Reals Lra Psatz Lia.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Loop.
Open Scope R_scope.

Lemma first_time_from (f : R -> R) (s t c : R) : s <= t -> (forall r, continuity_pt f r) -> c < f s -> f t <= c ->
  exists m, s < m <= t /\ f m <= c /\ forall r, s <= r < m -> c < f r.
Proof.
  intros St Cf Fs Ft.
  destruct (first_time (fun r => f (s + r)) (t - s) c) as (m & Hm & Fm & A).
  - lra.
  - intro r; apply (continuity_pt_comp (fun r => s + r) f); [|apply Cf].
    apply continuity_pt_plus; [apply continuity_pt_const; now intros ? ?|apply derivable_continuous_pt, derivable_pt_id].
  - now rewrite Rplus_0_r.
  - now replace (s + (t - s)) with t by ring.
  - exists (s + m); split; [lra|split; [exact Fm|]].
    intros r Hr; assert (B := A (r - s) ltac:(lra)); cbn in B; now replace (s + (r - s)) with r in B by ring.
Qed.

(* A state that moves at most so fast between two times. *)
Lemma moves x dx s m v : s <= m -> (forall r, continuity_pt x r) -> (forall r, s < r < m -> is_derive x r (dx r) /\ Rabs (dx r) <= v) ->
  Rabs (x m - x s) <= v * (m - s).
Proof.
  intros Sm Cx D. destruct (Req_dec s m) as [->|Ne].
  { rewrite !Rminus_diag_eq by reflexivity. rewrite Rabs_R0. lra. }
  assert (A : - v * (m - s) <= x m - x s).
  { apply (rises x dx); [lra|exact Cx|]. intros r Hr. destruct (D r Hr) as [De B]. apply Rabs_le_between in B. split; [exact De|lra]. }
  assert (B : - v * (m - s) <= - x m - - x s).
  { apply (rises (fun t => - x t) (fun t => - dx t)); [lra|intro; now apply continuity_pt_opp|].
    intros r Hr. destruct (D r Hr) as [De B]. apply Rabs_le_between in B. split; [exact (is_derive_opp _ _ _ De)|lra]. }
  apply Rabs_le. lra.
Qed.

(* The sum of a row without its own entry. *)
Fixpoint others (n i : nat) (u : nat -> R) : R :=
  match n with O => 0 | S m => (if Nat.eq_dec m i then 0 else u m) + others m i u end.
Lemma others_le n i u w : (forall j, (j < n)%nat -> u j <= w j) -> others n i u <= others n i w.
Proof.
  induction n; intro H; cbn; [lra|]. assert (A := IHn ltac:(intros; apply H; lia)). assert (B := H n ltac:(lia)).
  destruct (Nat.eq_dec n i); lra.
Qed.
Lemma others_nonneg n i u : (forall j, (j < n)%nat -> 0 <= u j) -> 0 <= others n i u.
Proof.
  induction n; intro H; cbn; [lra|]. assert (A := IHn ltac:(intros; apply H; lia)). assert (B := H n ltac:(lia)).
  destruct (Nat.eq_dec n i); lra.
Qed.

Section OneSide.
  (* One component at its upper edge, at time m; the input u acts since q, of the sample at s; before q others acted. *)
  Variables (x L U : R -> R) (y g : R -> R) (s q m u rho force v gmin gmax most tau latency : R).
  Let w (t : R) := U t - L t.
  Hypothesis rho_one : 1 <= rho.
  Hypothesis times : s <= q /\ q < m /\ m - s <= tau /\ q - s <= latency.
  Hypothesis positive : 0 <= force /\ 0 <= v /\ 0 < gmin <= gmax /\ 0 <= most.
  Hypothesis x_cont : forall t, continuity_pt x t.
  Hypothesis edges : forall r, s <= r <= m -> Rabs (L m - L r) <= v * (m - r) /\ Rabs (U m - U r) <= v * (m - r).
  Hypothesis before : Rabs (x q - x s) <= (force + gmax * most) * (q - s).
  Hypothesis ode : forall r, q < r < m -> is_derive x r (y r + g r * u) /\ Rabs (y r) <= force /\ gmin <= g r <= gmax.
  Hypothesis largest : Rabs u <= most.
  Hypothesis side_rule : forall slack, slack = (x s - L s) - (U s - x s) ->
    w m * ((rho - 1) / (rho + 1)) - 2 * ((force + v + gmax * most) * tau) <= slack -> u <= 0.
  Hypothesis pull_rule : (w m * (rho / (1 + rho)) - ((force + v) * tau + gmax * most * latency) <= x s - L s) ->
    (U s - x s <= w m * / (1 + rho) + ((force + v) * tau + gmax * most * latency)) ->
    w s <= w m + 2 * (v * tau) -> force + v <= gmin * - u.
  Hypothesis inside_before : x q <= U q - w q * / (1 + rho).

  Lemma upper_edge_kept : x m <= U m - w m * / (1 + rho).
  Proof.
    apply Rnot_lt_le; intro Past. unfold w in *.
    destruct times as (T1 & T2 & T3 & T4), positive as (F0 & v0 & (g0 & g1) & M0).
    assert (H1 : 0 < / (1 + rho)) by (apply Rinv_0_lt_compat; lra).
    assert (H2 : / (1 + rho) <= 1 / 2) by (apply Rle_trans with (/ 2); [apply Rinv_le_contravar; lra|lra]).
    assert (E1 : rho / (1 + rho) = 1 - / (1 + rho)) by (field; lra).
    assert (E2 : (rho - 1) / (rho + 1) = 1 - 2 * / (1 + rho)) by (field; lra).
    set (z := / (1 + rho)) in *. rewrite E1 in pull_rule. rewrite E2 in side_rule.
    assert (GM : 0 <= gmax * most) by (apply Rmult_le_pos; lra).
    destruct (edges s ltac:(lra)) as [Ls Us]. destruct (edges q ltac:(lra)) as [Lq Uq].
    apply Rabs_le_between in Ls, Us, Lq, Uq, before.
    (* what the state has moved since the sample, whatever acted *)
    assert (Mv : Rabs (x m - x q) <= (force + gmax * most) * (m - q)).
    { apply (moves x (fun r => y r + g r * u)); [lra|exact x_cont|]. intros r Hr. destruct (ode r Hr) as (De & Y & G).
      split; [exact De|]. eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat; [exact Y|].
      rewrite Rabs_mult, (Rabs_pos_eq (g r)) by lra. apply Rmult_le_compat; try lra. apply Rabs_pos. }
    apply Rabs_le_between in Mv.
    assert (Vt : v * (m - s) <= v * tau) by (apply Rmult_le_compat_l; lra).
    assert (Bt : (force + gmax * most) * (m - s) <= (force + gmax * most) * tau) by (apply Rmult_le_compat_l; lra).
    assert (Neg : u <= 0).
    { apply (side_rule _ eq_refl). lra. }
    (* since u <= 0, x has risen by what pushes it alone *)
    assert (Up : - force * (m - q) <= - x m - - x q).
    { apply (rises (fun t => - x t) (fun r => - (y r + g r * u))); [lra|intro; now apply continuity_pt_opp|].
      intros r Hr. destruct (ode r Hr) as (De & Y & G). split; [exact (is_derive_opp _ _ _ De)|].
      apply Rabs_le_between in Y. assert (0 <= g r * - u) by (apply Rmult_le_pos; lra). lra. }
    assert (Ft : force * (m - s) <= force * tau) by (apply Rmult_le_compat_l; lra).
    assert (Gl : gmax * most * (q - s) <= gmax * most * latency) by (apply Rmult_le_compat_l; lra).
    assert (P : force + v <= gmin * - u).
    { apply pull_rule; lra. }
    (* so x falls faster than the inner edge can *)
    assert (Fall : v * (m - q) <= - x m - - x q).
    { apply (rises (fun t => - x t) (fun r => - (y r + g r * u))); [lra|intro; now apply continuity_pt_opp|].
      intros r Hr. destruct (ode r Hr) as (De & Y & G). split; [exact (is_derive_opp _ _ _ De)|].
      apply Rabs_le_between in Y. assert (gmin * - u <= g r * - u) by (apply Rmult_le_compat_r; lra). lra. }
    assert (Edge : U m * (1 - z) + L m * z >= U q * (1 - z) + L q * z - v * (m - q)).
    { assert (- (v * (m - q)) * (1 - z) <= (U m - U q) * (1 - z)) by (apply Rmult_le_compat_r; lra).
      assert (- (v * (m - q)) * z <= (L m - L q) * z) by (apply Rmult_le_compat_r; lra). lra. }
    lra.
  Qed.
End OneSide.

Section Held.
  Variables (n : nat) (taken switch : nat -> R).       (* input p: of the sample taken then, acting from switch p to switch (p + 1) *)
  Variables (rho gmin gmax push cross room : nat -> R) (tau latency : R).
  Variables L U x : nat -> R -> R.
  Variables y g : nat -> nat -> R -> R.                 (* of component i, while input p acts: all that moves x but g u *)
  Variable input : nat -> nat -> R.
  Variables speed most : nat -> R -> R.                 (* at time m: of the edges since m - tau; of inputs from samples since m - 2 tau *)

  Let w (i : nat) (t : R) := U i t - L i t.
  Definition keeps (t : R) : Prop := forall i, (i < n)%nat ->
    w i t * / (1 + rho i) <= x i t - L i t /\ w i t * / (1 + rho i) <= U i t - x i t.
  Definition within (t : R) : Prop := forall i, (i < n)%nat -> L i t < x i t < U i t.
  Definition force (i : nat) (m : R) : R := push i + cross i * others n i (fun j => most j m).
  Definition drift (i : nat) (m : R) : R := (force i m + speed i m) * tau + gmax i * most i m * latency.

  Hypothesis clock : switch 0%nat = 0 /\ forall p, 0 <= taken p <= switch p /\ switch p < switch (S p) /\
    switch (S p) - taken p <= tau /\ switch p - taken p <= latency.
  Hypothesis bounds : forall i, (i < n)%nat -> 1 <= rho i /\ 0 < gmin i <= gmax i /\ 0 <= push i /\ 0 <= cross i /\ 0 < room i.
  Hypothesis cont : forall i t, (i < n)%nat -> continuity_pt (x i) t /\ continuity_pt (L i) t /\ continuity_pt (U i) t.
  Hypothesis wide : forall i t, (i < n)%nat -> room i <= w i t * / (1 + rho i).
  Hypothesis speeds : forall i m, (i < n)%nat -> 0 <= m -> 0 <= speed i m /\ 0 <= most i m /\ forall r, 0 <= r -> m - tau <= r <= m ->
    Rabs (L i m - L i r) <= speed i m * (m - r) /\ Rabs (U i m - U i r) <= speed i m * (m - r).
  Hypothesis start : keeps 0.
  Hypothesis ode : forall p t, switch p < t < switch (S p) -> within t -> forall i, (i < n)%nat ->
    is_derive (x i) t (y i p t + g i p t * input p i) /\
    Rabs (y i p t) <= push i + cross i * others n i (fun j => Rabs (input p j)) /\ gmin i <= g i p t <= gmax i.

  (* What is asked of the law, where its sample was taken inside the inner tube. *)
  Hypothesis law_most : forall p m i, (i < n)%nat -> keeps (taken p) -> taken p <= m <= taken p + 2 * tau ->
    (latency = 0 -> m <= taken p + tau) -> Rabs (input p i) <= most i m.
  Hypothesis law_side : forall p m i, (i < n)%nat -> keeps (taken p) -> taken p <= m <= taken p + tau ->
    (w i m * ((rho i - 1) / (rho i + 1)) - 2 * ((force i m + speed i m + gmax i * most i m) * tau)
       <= (x i (taken p) - L i (taken p)) - (U i (taken p) - x i (taken p)) -> input p i <= 0) /\
    (w i m * ((rho i - 1) / (rho i + 1)) - 2 * ((force i m + speed i m + gmax i * most i m) * tau)
       <= (U i (taken p) - x i (taken p)) - (x i (taken p) - L i (taken p)) -> 0 <= input p i).
  Hypothesis law_pull : forall p m i, (i < n)%nat -> keeps (taken p) -> taken p <= m <= taken p + tau ->
    w i (taken p) <= w i m + 2 * (speed i m * tau) ->
    (w i m * (rho i / (1 + rho i)) - drift i m <= x i (taken p) - L i (taken p) ->
     U i (taken p) - x i (taken p) <= w i m * / (1 + rho i) + drift i m -> force i m + speed i m <= gmin i * - input p i) /\
    (w i m * (rho i / (1 + rho i)) - drift i m <= U i (taken p) - x i (taken p) ->
     x i (taken p) - L i (taken p) <= w i m * / (1 + rho i) + drift i m -> force i m + speed i m <= gmin i * input p i).

  Let share (i : nat) (t : R) := Rmin (x i t - L i t - w i t * / (1 + rho i)) (U i t - x i t - w i t * / (1 + rho i)) * / room i + 1 / 2.

  Lemma share_cont i t : (i < n)%nat -> continuity_pt (share i) t.
  Proof.
    intro Hi. destruct (cont i t Hi) as (A & B & C). unfold share.
    apply (continuity_pt_plus (fun t => Rmin (x i t - L i t - w i t * / (1 + rho i)) (U i t - x i t - w i t * / (1 + rho i)) * / room i) (fun _ => 1 / 2)).
    2: apply continuity_pt_const; now intros ? ?.
    apply (continuity_pt_mult (fun t => Rmin (x i t - L i t - w i t * / (1 + rho i)) (U i t - x i t - w i t * / (1 + rho i))) (fun _ => / room i)).
    2: apply continuity_pt_const; now intros ? ?.
    assert (W : continuity_pt (fun t => w i t * / (1 + rho i)) t).
    { apply (continuity_pt_mult (w i) (fun _ => / (1 + rho i))); [now apply continuity_pt_minus|apply continuity_pt_const; now intros ? ?]. }
    apply continuity_pt_Rmin.
    - apply (continuity_pt_minus (fun t => x i t - L i t) (fun t => w i t * / (1 + rho i))); [now apply continuity_pt_minus|exact W].
    - apply (continuity_pt_minus (fun t => U i t - x i t) (fun t => w i t * / (1 + rho i))); [now apply continuity_pt_minus|exact W].
  Qed.

  Lemma share_up i t c : (i < n)%nat -> (c <= share i t <->
    (c - 1 / 2) * room i <= x i t - L i t - w i t * / (1 + rho i) /\ (c - 1 / 2) * room i <= U i t - x i t - w i t * / (1 + rho i)).
  Proof.
    intro Hi. destruct (bounds i Hi) as (_ & _ & _ & _ & R0). unfold share. set (m := Rmin _ _).
    assert (E : m = m * / room i * room i) by (field; lra).
    assert (A : c <= m * / room i + 1 / 2 <-> (c - 1 / 2) * room i <= m).
    { split; intro Q.
      - rewrite E. apply Rmult_le_compat_r; lra.
      - assert (c - 1 / 2 <= m * / room i); [|lra]. apply (Rmult_le_reg_r (room i)); [lra|]. rewrite <- E; lra. }
    rewrite A. unfold m, Rmin; destruct Rle_dec; lra.
  Qed.

  Lemma keeps_within t : keeps t -> within t.
  Proof.
    intros K i Hi. destruct (K i Hi). assert (W := wide i t Hi). destruct (bounds i Hi) as (_ & _ & _ & _ & R0). lra.
  Qed.

  Lemma switches p : 0 <= switch p.
  Proof. destruct clock as [_ C]. destruct (C p) as (A & _). lra. Qed.

  Lemma force_of p m i : (i < n)%nat -> (forall j, (j < n)%nat -> Rabs (input p j) <= most j m) ->
    push i + cross i * others n i (fun j => Rabs (input p j)) <= force i m.
  Proof.
    intros Hi M. destruct (bounds i Hi) as (_ & _ & _ & C0 & _). unfold force.
    apply Rplus_le_compat_l, Rmult_le_compat_l; [exact C0|]. now apply others_le.
  Qed.

  Lemma tau_pos : 0 < tau /\ 0 <= latency.
  Proof. destruct clock as [_ C]. destruct (C 0%nat) as (A & B & D & E). lra. Qed.

  (* While inputs up to p have acted, x has moved no faster than they and the rest can move it. *)
  Lemma moved p : (forall t, 0 <= t <= switch p -> keeps t) -> forall i m s q, (i < n)%nat ->
    0 <= s <= q -> q <= switch p -> q <= m -> m - tau <= s -> (latency = 0 -> s = q) ->
    Rabs (x i q - x i s) <= (force i m + gmax i * most i m) * (q - s).
  Proof.
    induction p; intros Past i m s q Hi Hs Hq Hm Ht Hl.
    - destruct clock as [C0 _]. rewrite C0 in Hq. assert (q = s) by lra. subst. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. lra.
    - destruct clock as [_ C]. destruct (C p) as (C1 & C2 & C3 & C4).
      assert (M0 : 0 <= m) by lra. destruct (speeds i m Hi M0) as (S0 & U0 & _).
      destruct (Req_dec latency 0) as [Z|NZ].
      { specialize (Hl Z). subst. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. lra. }
      assert (P' : forall t, 0 <= t <= switch p -> keeps t) by (intros; apply Past; lra).
      destruct (Rle_dec q (switch p)) as [Q|Q]; [apply IHp; auto; lra|].
      set (b := Rmax s (switch p)).
      assert (Bs : s <= b /\ switch p <= b /\ b <= q) by (unfold b, Rmax; destruct Rle_dec; lra).
      assert (Now : Rabs (x i q - x i b) <= (force i m + gmax i * most i m) * (q - b)).
      { apply (moves (x i) (fun r => y i p r + g i p r * input p i)); [lra|intro; now apply cont|]. intros r Hr.
        assert (Mo : forall j, (j < n)%nat -> Rabs (input p j) <= most j m).
        { intros j Hj. apply (law_most p m j Hj); [apply Past; lra|lra|intro; lra]. }
        destruct (ode p r ltac:(lra) ltac:(apply keeps_within, Past; lra) i Hi) as (De & Y & G).
        split; [exact De|]. eapply Rle_trans; [apply Rabs_triang|].
        assert (F := force_of p m i Hi Mo). apply Rplus_le_compat; [lra|].
        destruct (bounds i Hi) as (_ & G0 & _). rewrite Rabs_mult, (Rabs_pos_eq (g i p r)) by lra.
        apply Rmult_le_compat; try lra; [apply Rabs_pos|now apply Mo]. }
      destruct (Rle_dec s (switch p)) as [Q2|Q2].
      + assert (b = switch p) by (unfold b; rewrite Rmax_right; lra). rewrite H in *.
        assert (A := IHp P' i m s (switch p) Hi ltac:(lra) ltac:(lra) ltac:(lra) ltac:(lra) ltac:(intro; lra)).
        replace (x i q - x i s) with ((x i q - x i (switch p)) + (x i (switch p) - x i s)) by ring.
        eapply Rle_trans; [apply Rabs_triang|]. lra.
      + assert (b = s) by (unfold b; rewrite Rmax_left; lra). rewrite H in *. exact Now.
  Qed.

  Lemma period p : (forall t, 0 <= t <= switch p -> keeps t) -> forall t, switch p <= t <= switch (S p) -> keeps t.
  Proof.
    intro Past. destruct clock as [_ C]. destruct (C p) as (C1 & C2 & C3 & C4). destruct tau_pos as [T0 L0].
    assert (G : forall t, switch p <= t <= switch (S p) -> 1 / 2 <= least_of n share t).
    2: { intros t Ht i Hi. assert (B := G t Ht). pose proof (least_of_le n share t i Hi) as D.
         assert (E : 1 / 2 <= share i t) by lra. apply share_up in E; [lra|exact Hi]. }
    intros t1 Ht1. apply Rnot_lt_le; intro Bad.
    set (l := least_of n share) in *.
    set (c := Rmax (1 / 4) ((l t1 + 1 / 2) / 2)).
    assert (Cc : 1 / 4 <= c < 1 / 2 /\ l t1 <= c) by (unfold c, Rmax; destruct Rle_dec; lra).
    assert (W0 : 1 / 2 <= l (switch p)).
    { apply least_of_from; [lra|]. intros i Hi. apply share_up; [exact Hi|]. destruct (Past (switch p) ltac:(pose proof (switches p); lra) i Hi); lra. }
    destruct (first_time_from l (switch p) t1 c) as (m & Hm & Fm & Before); try lra.
    { intro; apply least_of_cont; intros; now apply share_cont. }
    assert (In : forall r, switch p <= r < m -> within r).
    { intros r Hr i Hi. assert (B := Before r Hr). pose proof (least_of_le n share r i Hi) as D. fold l in D.
      assert (E : c <= share i r) by lra. apply share_up in E; [|exact Hi]. assert (W := wide i r Hi).
      destruct (bounds i Hi) as (_ & _ & _ & _ & R0).
      assert (- (1 / 4) * room i <= (c - 1 / 2) * room i) by (apply Rmult_le_compat_r; lra). lra. }
    destruct (least_of_at n share m) as (i & Hi & E); [fold l; lra|]. fold l in E.
    destruct (bounds i Hi) as (rho1 & g0 & p0 & c0 & R0).
    assert (K0 : keeps (taken p)) by (apply Past; lra).
    assert (M0 : 0 <= m) by (pose proof (switches p); lra).
    destruct (speeds i m Hi M0) as (v0 & U0 & Sp).
    assert (Mo : forall j, (j < n)%nat -> Rabs (input p j) <= most j m).
    { intros j Hj. apply (law_most p m j Hj K0); [lra|intro; lra]. }
    assert (Fo := force_of p m i Hi Mo).
    assert (F0 : 0 <= force i m).
    { unfold force. apply Rplus_le_le_0_compat; [exact p0|]. apply Rmult_le_pos; [exact c0|]. apply others_nonneg. intros j Hj. apply (speeds j m Hj M0). }
    assert (Od : forall r, switch p < r < m -> is_derive (x i) r (y i p r + g i p r * input p i) /\ Rabs (y i p r) <= force i m /\ gmin i <= g i p r <= gmax i).
    { intros r Hr. destruct (ode p r ltac:(lra) (In r ltac:(lra)) i Hi) as (De & Y & Gr). split; [exact De|split; [lra|exact Gr]]. }
    assert (Mv : Rabs (x i (switch p) - x i (taken p)) <= (force i m + gmax i * most i m) * (switch p - taken p)).
    { apply (moved p Past); auto; lra. }
    assert (Ws : w i (taken p) <= w i m + 2 * (speed i m * tau)).
    { destruct (Sp (taken p) ltac:(lra) ltac:(lra)) as [A B]. apply Rabs_le_between in A, B. unfold w.
      assert (speed i m * (m - taken p) <= speed i m * tau) by (apply Rmult_le_compat_l; lra). lra. }
    destruct (law_side p m i Hi K0 ltac:(lra)) as [Sa Sb]. destruct (law_pull p m i Hi K0 ltac:(lra) Ws) as [Pa Pb].
    assert (Kq := Past (switch p) ltac:(pose proof (switches p); lra) i Hi).
    assert (Keep : w i m * / (1 + rho i) <= x i m - L i m /\ w i m * / (1 + rho i) <= U i m - x i m).
    { split.
      - assert (Q : - x i m <= - L i m - (- L i m - - U i m) * / (1 + rho i)); [|unfold w; lra].
        apply (upper_edge_kept (fun t => - x i t) (fun t => - U i t) (fun t => - L i t) (fun r => - y i p r) (g i p)
                 (taken p) (switch p) m (- input p i) (rho i) (force i m) (speed i m) (gmin i) (gmax i) (most i m) tau latency);
          [exact rho1|repeat split; lra|repeat split; lra| | | | | | | |].
        + intro t. apply continuity_pt_opp. now apply cont.
        + intros r Hr. destruct (Sp r ltac:(lra) ltac:(lra)) as [A B].
          replace (- U i m - - U i r) with (- (U i m - U i r)) by ring. replace (- L i m - - L i r) with (- (L i m - L i r)) by ring.
          rewrite !Rabs_Ropp. now split.
        + replace (- x i (switch p) - - x i (taken p)) with (- (x i (switch p) - x i (taken p))) by ring.
          rewrite Rabs_Ropp. exact Mv.
        + intros r Hr. destruct (Od r Hr) as (De & Y & Gr). split; [|rewrite Rabs_Ropp; now split].
          replace (- y i p r + g i p r * - input p i) with (- (y i p r + g i p r * input p i)) by ring. exact (is_derive_opp _ _ _ De).
        + rewrite Rabs_Ropp. now apply Mo.
        + intros sl -> Hs. assert (0 <= input p i); [|lra]. apply Sb. unfold w. lra.
        + intros H1 H2 _. rewrite Ropp_involutive. apply Pb; unfold drift, w; lra.
        + unfold w in Kq. lra.
      - assert (Q : x i m <= U i m - (U i m - L i m) * / (1 + rho i)); [|unfold w; lra].
        apply (upper_edge_kept (x i) (L i) (U i) (y i p) (g i p)
                 (taken p) (switch p) m (input p i) (rho i) (force i m) (speed i m) (gmin i) (gmax i) (most i m) tau latency);
          [exact rho1|repeat split; lra|repeat split; lra| | | | | | | |].
        + intro t. now apply cont.
        + intros r Hr. apply Sp; lra.
        + exact Mv.
        + exact Od.
        + now apply Mo.
        + intros sl -> Hs. apply Sa. unfold w. lra.
        + intros H1 H2 _. apply Pa; unfold drift, w; lra.
        + unfold w in Kq. lra. }
    assert (1 / 2 <= share i m); [apply share_up; [exact Hi|]; lra|]. lra.
  Qed.

  Theorem held_stays : forall p t, 0 <= t <= switch p -> keeps t.
  Proof.
    induction p; intros t Ht.
    - destruct clock as [C0 _]. rewrite C0 in Ht. replace t with 0 by lra. exact start.
    - destruct (Rle_dec t (switch p)); [apply IHp; lra|]. apply (period p IHp). lra.
  Qed.
End Held.
