(* The closed loop with held inputs: each input is computed from a sample and acts until the next one does. The state stays in an inner
   tube, whose edges cut off the share 1/(1 + rho) of the width on both sides, the same at all times. That is |e| <= (rho - 1)/(rho + 1).

   An input is constant while it acts. Either it pushes inwards harder than everything pushes outwards; then the state does not pass the
   inner edge. Or its sample was taken far from that edge; then the state cannot get there, because a sample is never older than tau.

   Period.v applies this to the emitted law. The lemma book has it as `sampled.first_exit` to `sampled.sharp`, with the same three
   conditions (docs/lemmas.md); docs/certificate-format.md has them as P9. *)
From Coq Require Import Reals Lra Psatz Lia.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Loop.
Open Scope R_scope.

(* `first_time_at_most` of Loop.v, from time s on. *)
Lemma first_time_at_most_from (f : R -> R) (s t c : R) : s <= t -> (forall r, continuity_pt f r) -> c < f s -> f t <= c ->
  exists m, s < m <= t /\ f m <= c /\ forall r, s <= r < m -> c < f r.
Proof.
  intros St Cf Fs Ft.
  destruct (first_time_at_most (fun r => f (s + r)) (t - s) c) as (m & Hm & Fm & A).
  - lra.
  - intro r; apply (continuity_pt_comp (fun r => s + r) f); [|apply Cf].
    apply continuity_pt_plus; [apply continuity_pt_const; now intros ? ?|apply derivable_continuous_pt, derivable_pt_id].
  - now rewrite Rplus_0_r.
  - now replace (s + (t - s)) with t by ring.
  - exists (s + m); split; [lra|split; [exact Fm|]].
    intros r Hr; assert (B := A (r - s) ltac:(lra)); cbn in B; now replace (s + (r - s)) with r in B by ring.
Qed.

(* A function whose derivative is at most `rate` in size moves at most so fast between two times. *)
Lemma moves_at_most f df t0 t1 rate : t0 <= t1 -> (forall r, continuity_pt f r) -> (forall r, t0 < r < t1 -> is_derive f r (df r) /\ Rabs (df r) <= rate) ->
  Rabs (f t1 - f t0) <= rate * (t1 - t0).
Proof.
  intros Sm Cx D. destruct (Req_dec t0 t1) as [->|Ne].
  { rewrite !Rminus_diag_eq by reflexivity. rewrite Rabs_R0. lra. }
  assert (A : - rate * (t1 - t0) <= f t1 - f t0).
  { apply (rises_at_rate f df); [lra|exact Cx|]. intros r Hr. destruct (D r Hr) as [De B]. apply Rabs_le_between in B. split; [exact De|lra]. }
  assert (B : - rate * (t1 - t0) <= - f t1 - - f t0).
  { apply (rises_at_rate (fun t => - f t) (fun t => - df t)); [lra|intro; now apply continuity_pt_opp|].
    intros r Hr. destruct (D r Hr) as [De B]. apply Rabs_le_between in B. split; [exact (is_derive_opp _ _ _ De)|lra]. }
  apply Rabs_le. lra.
Qed.

(* The sum of u 0 .. u (n - 1) without u i: what the inputs of other components add up to. *)
Fixpoint sum_except (n i : nat) (u : nat -> R) : R :=
  match n with O => 0 | S m => (if Nat.eq_dec m i then 0 else u m) + sum_except m i u end.
Lemma sum_except_le n i u w : (forall j, (j < n)%nat -> u j <= w j) -> sum_except n i u <= sum_except n i w.
Proof.
  induction n; intro H; cbn; [lra|]. assert (A := IHn ltac:(intros; apply H; lia)). assert (B := H n ltac:(lia)).
  destruct (Nat.eq_dec n i); lra.
Qed.
Lemma sum_except_nonneg n i u : (forall j, (j < n)%nat -> 0 <= u j) -> 0 <= sum_except n i u.
Proof.
  induction n; intro H; cbn; [lra|]. assert (A := IHn ltac:(intros; apply H; lia)). assert (B := H n ltac:(lia)).
  destruct (Nat.eq_dec n i); lra.
Qed.

(* One component near its upper edge. Input u acts from switch_time until `now`, and was computed from the sample of sample_time; before
   switch_time earlier inputs acted. unforced_rate is xdot without g u; tau bounds the age of a sample, latency the delay until its input
   acts. *)
Section UpperEdge.
  (* One component at its upper edge, at time m; the input u acts since q, of the sample at s; before q others acted. *)
  Variables (x L U : R -> R) (unforced_rate g : R -> R) (sample_time switch_time now u rho force_max edge_speed g_min g_max input_max tau latency : R).
  Let width (t : R) := U t - L t.
  Hypothesis rho_at_least_1 : 1 <= rho.
  Hypothesis times_ordered : sample_time <= switch_time /\ switch_time < now /\ now - sample_time <= tau /\ switch_time - sample_time <= latency.
  Hypothesis bounds_positive : 0 <= force_max /\ 0 <= edge_speed /\ 0 < g_min <= g_max /\ 0 <= input_max.
  Hypothesis x_continuous : forall t, continuity_pt x t.
  Hypothesis edges_move_slowly : forall r, sample_time <= r <= now -> Rabs (L now - L r) <= edge_speed * (now - r) /\ Rabs (U now - U r) <= edge_speed * (now - r).
  Hypothesis moved_since_sample : Rabs (x switch_time - x sample_time) <= (force_max + g_max * input_max) * (switch_time - sample_time).
  Hypothesis plant_equation : forall r, switch_time < r < now -> is_derive x r (unforced_rate r + g r * u) /\ Rabs (unforced_rate r) <= force_max /\ g_min <= g r <= g_max.
  Hypothesis input_bounded : Rabs u <= input_max.
  (* A sample that was far above the middle of the tube has an input that does not push upwards. *)
  Hypothesis side_condition : forall slack, slack = (x sample_time - L sample_time) - (U sample_time - x sample_time) ->
    width now * ((rho - 1) / (rho + 1)) - 2 * ((force_max + edge_speed + g_max * input_max) * tau) <= slack -> u <= 0.
  (* A sample that was near the upper edge has an input that pulls down faster than the edge and all forces move up. *)
  Hypothesis pull_condition : (width now * (rho / (1 + rho)) - ((force_max + edge_speed) * tau + g_max * input_max * latency) <= x sample_time - L sample_time) ->
    (U sample_time - x sample_time <= width now * / (1 + rho) + ((force_max + edge_speed) * tau + g_max * input_max * latency)) ->
    width sample_time <= width now + 2 * (edge_speed * tau) -> force_max + edge_speed <= g_min * - u.
  Hypothesis inside_at_switch : x switch_time <= U switch_time - width switch_time * / (1 + rho).

  (* Then the state is below the inner upper edge at time `now`. *)
  Lemma upper_edge_kept : x now <= U now - width now * / (1 + rho).
  Proof.
    apply Rnot_lt_le; intro Past. unfold width in *.
    destruct times_ordered as (T1 & T2 & T3 & T4), bounds_positive as (F0 & v0 & (g0 & g1) & M0).
    assert (H1 : 0 < / (1 + rho)) by (apply Rinv_0_lt_compat; lra).
    assert (H2 : / (1 + rho) <= 1 / 2) by (apply Rle_trans with (/ 2); [apply Rinv_le_contravar; lra|lra]).
    assert (E1 : rho / (1 + rho) = 1 - / (1 + rho)) by (field; lra).
    assert (E2 : (rho - 1) / (rho + 1) = 1 - 2 * / (1 + rho)) by (field; lra).
    set (z := / (1 + rho)) in *. rewrite E1 in pull_condition. rewrite E2 in side_condition.
    assert (GM : 0 <= g_max * input_max) by (apply Rmult_le_pos; lra).
    destruct (edges_move_slowly sample_time ltac:(lra)) as [Ls Us]. destruct (edges_move_slowly switch_time ltac:(lra)) as [Lq Uq].
    apply Rabs_le_between in Ls, Us, Lq, Uq, moved_since_sample.
    (* how far the state may have moved since the switch, whatever the sign of the input *)
    assert (Mv : Rabs (x now - x switch_time) <= (force_max + g_max * input_max) * (now - switch_time)).
    { apply (moves_at_most x (fun r => unforced_rate r + g r * u)); [lra|exact x_continuous|]. intros r Hr. destruct (plant_equation r Hr) as (De & Y & G).
      split; [exact De|]. eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat; [exact Y|].
      rewrite Rabs_mult, (Rabs_pos_eq (g r)) by lra. apply Rmult_le_compat; try lra. apply Rabs_pos. }
    apply Rabs_le_between in Mv.
    assert (Vt : edge_speed * (now - sample_time) <= edge_speed * tau) by (apply Rmult_le_compat_l; lra).
    assert (Bt : (force_max + g_max * input_max) * (now - sample_time) <= (force_max + g_max * input_max) * tau) by (apply Rmult_le_compat_l; lra).
    assert (Neg : u <= 0).
    { apply (side_condition _ eq_refl). lra. }
    (* because u <= 0, the forces alone have moved x upwards *)
    assert (Up : - force_max * (now - switch_time) <= - x now - - x switch_time).
    { apply (rises_at_rate (fun t => - x t) (fun r => - (unforced_rate r + g r * u))); [lra|intro; now apply continuity_pt_opp|].
      intros r Hr. destruct (plant_equation r Hr) as (De & Y & G). split; [exact (is_derive_opp _ _ _ De)|].
      apply Rabs_le_between in Y. assert (0 <= g r * - u) by (apply Rmult_le_pos; lra). lra. }
    assert (Ft : force_max * (now - sample_time) <= force_max * tau) by (apply Rmult_le_compat_l; lra).
    assert (Gl : g_max * input_max * (switch_time - sample_time) <= g_max * input_max * latency) by (apply Rmult_le_compat_l; lra).
    assert (P : force_max + edge_speed <= g_min * - u).
    { apply pull_condition; lra. }
    (* so x falls faster than the inner edge does *)
    assert (Fall : edge_speed * (now - switch_time) <= - x now - - x switch_time).
    { apply (rises_at_rate (fun t => - x t) (fun r => - (unforced_rate r + g r * u))); [lra|intro; now apply continuity_pt_opp|].
      intros r Hr. destruct (plant_equation r Hr) as (De & Y & G). split; [exact (is_derive_opp _ _ _ De)|].
      apply Rabs_le_between in Y. assert (g_min * - u <= g r * - u) by (apply Rmult_le_compat_r; lra). lra. }
    assert (Edge : U now * (1 - z) + L now * z >= U switch_time * (1 - z) + L switch_time * z - edge_speed * (now - switch_time)).
    { assert (- (edge_speed * (now - switch_time)) * (1 - z) <= (U now - U switch_time) * (1 - z)) by (apply Rmult_le_compat_r; lra).
      assert (- (edge_speed * (now - switch_time)) * z <= (L now - L switch_time) * z) by (apply Rmult_le_compat_r; lra). lra. }
    lra.
  Qed.
End UpperEdge.

(* All n components and all times. Input p is computed from the sample of time sampled_at p and acts from acts_from p to acts_from (p +
   1). *)
Section HeldInputs.
  Variables (n : nat) (sampled_at acts_from : nat -> R).
  Variables (rho g_min g_max push_max cross_gain_max margin : nat -> R) (tau latency : R).
  Variables L U x : nat -> R -> R.
  Variables unforced_rate g : nat -> nat -> R -> R.  (* of component i while input p acts; unforced_rate is xdot without g u *)
  Variable input : nat -> nat -> R.
  Variables edge_speed input_max : nat -> R -> R.  (* at time m: how fast the edges moved since m - tau; a bound on inputs of samples since m - 2 tau *)

  Let width (i : nat) (t : R) := U i t - L i t.
  (* At time t the state is in the inner tube. *)
  Definition in_inner_tube (t : R) : Prop := forall i, (i < n)%nat ->
    width i t * / (1 + rho i) <= x i t - L i t /\ width i t * / (1 + rho i) <= U i t - x i t.
  (* At time t the state is strictly inside the tube. *)
  Definition in_tube (t : R) : Prop := forall i, (i < n)%nat -> L i t < x i t < U i t.
  (* A bound on |unforced_rate| at time m: push_max, and the coupling with the inputs of other components. *)
  Definition force_max (i : nat) (m : R) : R := push_max i + cross_gain_max i * sum_except n i (fun j => input_max j m).
  (* How far the state and an edge may have moved together since the sample. *)
  Definition drift_max (i : nat) (m : R) : R := (force_max i m + edge_speed i m) * tau + g_max i * input_max i m * latency.

  (* The first input acts from 0 on. No sample is older than tau while its input acts, and an input acts at most latency after its
     sample. *)
  Hypothesis times_ordered : acts_from 0%nat = 0 /\ forall p, 0 <= sampled_at p <= acts_from p /\ acts_from p < acts_from (S p) /\
    acts_from (S p) - sampled_at p <= tau /\ acts_from p - sampled_at p <= latency.
  Hypothesis bounds_positive : forall i, (i < n)%nat -> 1 <= rho i /\ 0 < g_min i <= g_max i /\ 0 <= push_max i /\ 0 <= cross_gain_max i /\ 0 < margin i.
  Hypothesis paths_continuous : forall i t, (i < n)%nat -> continuity_pt (x i) t /\ continuity_pt (L i) t /\ continuity_pt (U i) t.
  Hypothesis margin_below_inner_edge : forall i t, (i < n)%nat -> margin i <= width i t * / (1 + rho i).
  Hypothesis edges_move_slowly : forall i m, (i < n)%nat -> 0 <= m -> 0 <= edge_speed i m /\ 0 <= input_max i m /\ forall r, 0 <= r -> m - tau <= r <= m ->
    Rabs (L i m - L i r) <= edge_speed i m * (m - r) /\ Rabs (U i m - U i r) <= edge_speed i m * (m - r).
  Hypothesis starts_in_inner_tube : in_inner_tube 0.
  Hypothesis plant_equation : forall p t, acts_from p < t < acts_from (S p) -> in_tube t -> forall i, (i < n)%nat ->
    is_derive (x i) t (unforced_rate i p t + g i p t * input p i) /\
    Rabs (unforced_rate i p t) <= push_max i + cross_gain_max i * sum_except n i (fun j => Rabs (input p j)) /\ g_min i <= g i p t <= g_max i.

  (* The three conditions on the law, where its sample was taken in the inner tube. *)
  Hypothesis input_bounded : forall p m i, (i < n)%nat -> in_inner_tube (sampled_at p) -> sampled_at p <= m <= sampled_at p + 2 * tau ->
    (latency = 0 -> m <= sampled_at p + tau) -> Rabs (input p i) <= input_max i m.
  Hypothesis side_condition : forall p m i, (i < n)%nat -> in_inner_tube (sampled_at p) -> sampled_at p <= m <= sampled_at p + tau ->
    (width i m * ((rho i - 1) / (rho i + 1)) - 2 * ((force_max i m + edge_speed i m + g_max i * input_max i m) * tau)
       <= (x i (sampled_at p) - L i (sampled_at p)) - (U i (sampled_at p) - x i (sampled_at p)) -> input p i <= 0) /\
    (width i m * ((rho i - 1) / (rho i + 1)) - 2 * ((force_max i m + edge_speed i m + g_max i * input_max i m) * tau)
       <= (U i (sampled_at p) - x i (sampled_at p)) - (x i (sampled_at p) - L i (sampled_at p)) -> 0 <= input p i).
  Hypothesis pull_condition : forall p m i, (i < n)%nat -> in_inner_tube (sampled_at p) -> sampled_at p <= m <= sampled_at p + tau ->
    width i (sampled_at p) <= width i m + 2 * (edge_speed i m * tau) ->
    (width i m * (rho i / (1 + rho i)) - drift_max i m <= x i (sampled_at p) - L i (sampled_at p) ->
     U i (sampled_at p) - x i (sampled_at p) <= width i m * / (1 + rho i) + drift_max i m -> force_max i m + edge_speed i m <= g_min i * - input p i) /\
    (width i m * (rho i / (1 + rho i)) - drift_max i m <= U i (sampled_at p) - x i (sampled_at p) ->
     x i (sampled_at p) - L i (sampled_at p) <= width i m * / (1 + rho i) + drift_max i m -> force_max i m + edge_speed i m <= g_min i * input p i).

  (* The distance to the nearer inner edge, in units of `margin`, plus 1/2: so it is at least 1/2 in the inner tube, and above 0 in the
     tube. *)
  Let scaled_distance (i : nat) (t : R) := Rmin (x i t - L i t - width i t * / (1 + rho i)) (U i t - x i t - width i t * / (1 + rho i)) * / margin i + 1 / 2.

  Lemma scaled_distance_continuous i t : (i < n)%nat -> continuity_pt (scaled_distance i) t.
  Proof.
    intro Hi. destruct (paths_continuous i t Hi) as (A & B & C). unfold scaled_distance.
    apply (continuity_pt_plus (fun t => Rmin (x i t - L i t - width i t * / (1 + rho i)) (U i t - x i t - width i t * / (1 + rho i)) * / margin i) (fun _ => 1 / 2)).
    2: apply continuity_pt_const; now intros ? ?.
    apply (continuity_pt_mult (fun t => Rmin (x i t - L i t - width i t * / (1 + rho i)) (U i t - x i t - width i t * / (1 + rho i))) (fun _ => / margin i)).
    2: apply continuity_pt_const; now intros ? ?.
    assert (W : continuity_pt (fun t => width i t * / (1 + rho i)) t).
    { apply (continuity_pt_mult (width i) (fun _ => / (1 + rho i))); [now apply continuity_pt_minus|apply continuity_pt_const; now intros ? ?]. }
    apply continuity_pt_Rmin.
    - apply (continuity_pt_minus (fun t => x i t - L i t) (fun t => width i t * / (1 + rho i))); [now apply continuity_pt_minus|exact W].
    - apply (continuity_pt_minus (fun t => U i t - x i t) (fun t => width i t * / (1 + rho i))); [now apply continuity_pt_minus|exact W].
  Qed.

  Lemma scaled_distance_at_least i t c : (i < n)%nat -> (c <= scaled_distance i t <->
    (c - 1 / 2) * margin i <= x i t - L i t - width i t * / (1 + rho i) /\ (c - 1 / 2) * margin i <= U i t - x i t - width i t * / (1 + rho i)).
  Proof.
    intro Hi. destruct (bounds_positive i Hi) as (_ & _ & _ & _ & R0). unfold scaled_distance. set (m := Rmin _ _).
    assert (E : m = m * / margin i * margin i) by (field; lra).
    assert (A : c <= m * / margin i + 1 / 2 <-> (c - 1 / 2) * margin i <= m).
    { split; intro Q.
      - rewrite E. apply Rmult_le_compat_r; lra.
      - assert (c - 1 / 2 <= m * / margin i); [|lra]. apply (Rmult_le_reg_r (margin i)); [lra|]. rewrite <- E; lra. }
    rewrite A. unfold m, Rmin; destruct Rle_dec; lra.
  Qed.

  Lemma inner_tube_in_tube t : in_inner_tube t -> in_tube t.
  Proof.
    intros K i Hi. destruct (K i Hi). assert (W := margin_below_inner_edge i t Hi). destruct (bounds_positive i Hi) as (_ & _ & _ & _ & R0). lra.
  Qed.

  Lemma acts_from_nonneg p : 0 <= acts_from p.
  Proof. destruct times_ordered as [_ C]. destruct (C p) as (A & _). lra. Qed.

  Lemma force_max_bounds p m i : (i < n)%nat -> (forall j, (j < n)%nat -> Rabs (input p j) <= input_max j m) ->
    push_max i + cross_gain_max i * sum_except n i (fun j => Rabs (input p j)) <= force_max i m.
  Proof.
    intros Hi M. destruct (bounds_positive i Hi) as (_ & _ & _ & C0 & _). unfold force_max.
    apply Rplus_le_compat_l, Rmult_le_compat_l; [exact C0|]. now apply sum_except_le.
  Qed.

  Lemma tau_pos : 0 < tau /\ 0 <= latency.
  Proof. destruct times_ordered as [_ C]. destruct (C 0%nat) as (A & B & D & E). lra. Qed.

  (* As long as the state was in the inner tube, it moved between a sample and the switch no faster than bounded inputs and forces can
     move it. *)
  Lemma moved_while_inputs_acted p : (forall t, 0 <= t <= acts_from p -> in_inner_tube t) -> forall i m s q, (i < n)%nat ->
    0 <= s <= q -> q <= acts_from p -> q <= m -> m - tau <= s -> (latency = 0 -> s = q) ->
    Rabs (x i q - x i s) <= (force_max i m + g_max i * input_max i m) * (q - s).
  Proof.
    induction p; intros Past i m s q Hi Hs Hq Hm Ht Hl.
    - destruct times_ordered as [C0 _]. rewrite C0 in Hq. assert (q = s) by lra. subst. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. lra.
    - destruct times_ordered as [_ C]. destruct (C p) as (C1 & C2 & C3 & C4).
      assert (M0 : 0 <= m) by lra. destruct (edges_move_slowly i m Hi M0) as (S0 & U0 & _).
      destruct (Req_dec latency 0) as [Z|NZ].
      { specialize (Hl Z). subst. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. lra. }
      assert (P' : forall t, 0 <= t <= acts_from p -> in_inner_tube t) by (intros; apply Past; lra).
      destruct (Rle_dec q (acts_from p)) as [Q|Q]; [apply IHp; auto; lra|].
      set (b := Rmax s (acts_from p)).
      assert (Bs : s <= b /\ acts_from p <= b /\ b <= q) by (unfold b, Rmax; destruct Rle_dec; lra).
      assert (Now : Rabs (x i q - x i b) <= (force_max i m + g_max i * input_max i m) * (q - b)).
      { apply (moves_at_most (x i) (fun r => unforced_rate i p r + g i p r * input p i)); [lra|intro; now apply paths_continuous|]. intros r Hr.
        assert (Mo : forall j, (j < n)%nat -> Rabs (input p j) <= input_max j m).
        { intros j Hj. apply (input_bounded p m j Hj); [apply Past; lra|lra|intro; lra]. }
        destruct (plant_equation p r ltac:(lra) ltac:(apply inner_tube_in_tube, Past; lra) i Hi) as (De & Y & G).
        split; [exact De|]. eapply Rle_trans; [apply Rabs_triang|].
        assert (F := force_max_bounds p m i Hi Mo). apply Rplus_le_compat; [lra|].
        destruct (bounds_positive i Hi) as (_ & G0 & _). rewrite Rabs_mult, (Rabs_pos_eq (g i p r)) by lra.
        apply Rmult_le_compat; try lra; [apply Rabs_pos|now apply Mo]. }
      destruct (Rle_dec s (acts_from p)) as [Q2|Q2].
      + assert (b = acts_from p) by (unfold b; rewrite Rmax_right; lra). rewrite H in *.
        assert (A := IHp P' i m s (acts_from p) Hi ltac:(lra) ltac:(lra) ltac:(lra) ltac:(lra) ltac:(intro; lra)).
        replace (x i q - x i s) with ((x i q - x i (acts_from p)) + (x i (acts_from p) - x i s)) by ring.
        eapply Rle_trans; [apply Rabs_triang|]. lra.
      + assert (b = s) by (unfold b; rewrite Rmax_left; lra). rewrite H in *. exact Now.
  Qed.

  (* If the state was in the inner tube until input p began to act, it is so until the next input acts. *)
  Lemma stays_until_next_switch p : (forall t, 0 <= t <= acts_from p -> in_inner_tube t) -> forall t, acts_from p <= t <= acts_from (S p) -> in_inner_tube t.
  Proof.
    intro Past. destruct times_ordered as [_ C]. destruct (C p) as (C1 & C2 & C3 & C4). destruct tau_pos as [T0 L0].
    assert (G : forall t, acts_from p <= t <= acts_from (S p) -> 1 / 2 <= minimum_of n scaled_distance t).
    2: { intros t Ht i Hi. assert (B := G t Ht). pose proof (minimum_of_below n scaled_distance t i Hi) as D.
         assert (E : 1 / 2 <= scaled_distance i t) by lra. apply scaled_distance_at_least in E; [lra|exact Hi]. }
    intros t1 Ht1. apply Rnot_lt_le; intro Bad.
    set (l := minimum_of n scaled_distance) in *.
    set (c := Rmax (1 / 4) ((l t1 + 1 / 2) / 2)).
    assert (Cc : 1 / 4 <= c < 1 / 2 /\ l t1 <= c) by (unfold c, Rmax; destruct Rle_dec; lra).
    assert (W0 : 1 / 2 <= l (acts_from p)).
    { apply minimum_of_at_least; [lra|]. intros i Hi. apply scaled_distance_at_least; [exact Hi|]. destruct (Past (acts_from p) ltac:(pose proof (acts_from_nonneg p); lra) i Hi); lra. }
    destruct (first_time_at_most_from l (acts_from p) t1 c) as (m & Hm & Fm & Before); try lra.
    { intro; apply minimum_of_continuous; intros; now apply scaled_distance_continuous. }
    assert (In : forall r, acts_from p <= r < m -> in_tube r).
    { intros r Hr i Hi. assert (B := Before r Hr). pose proof (minimum_of_below n scaled_distance r i Hi) as D. fold l in D.
      assert (E : c <= scaled_distance i r) by lra. apply scaled_distance_at_least in E; [|exact Hi]. assert (W := margin_below_inner_edge i r Hi).
      destruct (bounds_positive i Hi) as (_ & _ & _ & _ & R0).
      assert (- (1 / 4) * margin i <= (c - 1 / 2) * margin i) by (apply Rmult_le_compat_r; lra). lra. }
    destruct (minimum_of_attained n scaled_distance m) as (i & Hi & E); [fold l; lra|]. fold l in E.
    destruct (bounds_positive i Hi) as (rho1 & g0 & p0 & c0 & R0).
    assert (K0 : in_inner_tube (sampled_at p)) by (apply Past; lra).
    assert (M0 : 0 <= m) by (pose proof (acts_from_nonneg p); lra).
    destruct (edges_move_slowly i m Hi M0) as (v0 & U0 & Sp).
    assert (Mo : forall j, (j < n)%nat -> Rabs (input p j) <= input_max j m).
    { intros j Hj. apply (input_bounded p m j Hj K0); [lra|intro; lra]. }
    assert (Fo := force_max_bounds p m i Hi Mo).
    assert (F0 : 0 <= force_max i m).
    { unfold force_max. apply Rplus_le_le_0_compat; [exact p0|]. apply Rmult_le_pos; [exact c0|]. apply sum_except_nonneg. intros j Hj. apply (edges_move_slowly j m Hj M0). }
    assert (Od : forall r, acts_from p < r < m -> is_derive (x i) r (unforced_rate i p r + g i p r * input p i) /\ Rabs (unforced_rate i p r) <= force_max i m /\ g_min i <= g i p r <= g_max i).
    { intros r Hr. destruct (plant_equation p r ltac:(lra) (In r ltac:(lra)) i Hi) as (De & Y & Gr). split; [exact De|split; [lra|exact Gr]]. }
    assert (Mv : Rabs (x i (acts_from p) - x i (sampled_at p)) <= (force_max i m + g_max i * input_max i m) * (acts_from p - sampled_at p)).
    { apply (moved_while_inputs_acted p Past); auto; lra. }
    assert (Ws : width i (sampled_at p) <= width i m + 2 * (edge_speed i m * tau)).
    { destruct (Sp (sampled_at p) ltac:(lra) ltac:(lra)) as [A B]. apply Rabs_le_between in A, B. unfold width.
      assert (edge_speed i m * (m - sampled_at p) <= edge_speed i m * tau) by (apply Rmult_le_compat_l; lra). lra. }
    destruct (side_condition p m i Hi K0 ltac:(lra)) as [Sa Sb]. destruct (pull_condition p m i Hi K0 ltac:(lra) Ws) as [Pa Pb].
    assert (Kq := Past (acts_from p) ltac:(pose proof (acts_from_nonneg p); lra) i Hi).
    assert (Keep : width i m * / (1 + rho i) <= x i m - L i m /\ width i m * / (1 + rho i) <= U i m - x i m).
    { split.
      - assert (Q : - x i m <= - L i m - (- L i m - - U i m) * / (1 + rho i)); [|unfold width; lra].
        apply (upper_edge_kept (fun t => - x i t) (fun t => - U i t) (fun t => - L i t) (fun r => - unforced_rate i p r) (g i p)
                 (sampled_at p) (acts_from p) m (- input p i) (rho i) (force_max i m) (edge_speed i m) (g_min i) (g_max i) (input_max i m) tau latency);
          [exact rho1|repeat split; lra|repeat split; lra| | | | | | | |].
        + intro t. apply continuity_pt_opp. now apply paths_continuous.
        + intros r Hr. destruct (Sp r ltac:(lra) ltac:(lra)) as [A B].
          replace (- U i m - - U i r) with (- (U i m - U i r)) by ring. replace (- L i m - - L i r) with (- (L i m - L i r)) by ring.
          rewrite !Rabs_Ropp. now split.
        + replace (- x i (acts_from p) - - x i (sampled_at p)) with (- (x i (acts_from p) - x i (sampled_at p))) by ring.
          rewrite Rabs_Ropp. exact Mv.
        + intros r Hr. destruct (Od r Hr) as (De & Y & Gr). split; [|rewrite Rabs_Ropp; now split].
          replace (- unforced_rate i p r + g i p r * - input p i) with (- (unforced_rate i p r + g i p r * input p i)) by ring. exact (is_derive_opp _ _ _ De).
        + rewrite Rabs_Ropp. now apply Mo.
        + intros sl -> Hs. assert (0 <= input p i); [|lra]. apply Sb. unfold width. lra.
        + intros H1 H2 _. rewrite Ropp_involutive. apply Pb; unfold drift_max, width; lra.
        + unfold width in Kq. lra.
      - assert (Q : x i m <= U i m - (U i m - L i m) * / (1 + rho i)); [|unfold width; lra].
        apply (upper_edge_kept (x i) (L i) (U i) (unforced_rate i p) (g i p)
                 (sampled_at p) (acts_from p) m (input p i) (rho i) (force_max i m) (edge_speed i m) (g_min i) (g_max i) (input_max i m) tau latency);
          [exact rho1|repeat split; lra|repeat split; lra| | | | | | | |].
        + intro t. now apply paths_continuous.
        + intros r Hr. apply Sp; lra.
        + exact Mv.
        + exact Od.
        + now apply Mo.
        + intros sl -> Hs. apply Sa. unfold width. lra.
        + intros H1 H2 _. apply Pa; unfold drift_max, width; lra.
        + unfold width in Kq. lra. }
    assert (1 / 2 <= scaled_distance i m); [apply scaled_distance_at_least; [exact Hi|]; lra|]. lra.
  Qed.

  (* The state is in the inner tube at all times. *)
  Theorem stays_in_inner_tube : forall p t, 0 <= t <= acts_from p -> in_inner_tube t.
  Proof.
    induction p; intros t Ht.
    - destruct times_ordered as [C0 _]. rewrite C0 in Ht. replace t with 0 by lra. exact starts_in_inner_tube.
    - destruct (Rle_dec t (acts_from p)); [apply IHp; lra|]. apply (stays_until_next_switch p IHp). lra.
  Qed.
End HeldInputs.
