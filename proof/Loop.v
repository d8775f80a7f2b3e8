(* The closed loop in continuous time: under the control law (13) the state never leaves the tube, whatever the bounds of the plant are.

   The proof is by first exit. Near an edge the law outweighs drift, disturbance and the motion of the edge together, for 1/a grows
   without bound. So the state keeps a positive distance from every edge, which depends on the bounds.

   Speed.v applies this to spline tubes; HeldInputs.v and HeldInputLaw.v use the lemmas on real functions. The paper has it as Theorem
   4.1 (docs/paper.md); the lemma book as `theorem.*` (docs/lemmas.md). *)
From Coq Require Import Reals Lra Psatz Lia.
From Coquelicot Require Import Coquelicot.
Open Scope R_scope.

(* A continuous function that is at least c at s and below c at t has a last time m at which it is at least c. *)
Lemma last_time_at_least (f : R -> R) (s t c : R) : s <= t -> (forall r, continuity_pt f r) -> c <= f s -> f t < c ->
  exists m, s <= m < t /\ c <= f m /\ forall r, m < r <= t -> f r < c.
Proof.
  intros St Cf Fs Ft.
  set (E := fun r => s <= r <= t /\ c <= f r).
  assert (Es : E s) by (unfold E; lra).
  destruct (completeness E) as [m [Ub Lub]].
  { exists t; intros r [? _]; lra. }
  { now exists s. }
  assert (s <= m) by now apply Ub.
  assert (m <= t) by (apply Lub; intros r [? _]; lra).
  assert (Fm : c <= f m).
  { apply Rnot_lt_le; intro C.
    destruct (Cf m (c - f m) ltac:(lra)) as (dl & Hd & Hc).
    assert (m <= m - dl); [|lra].
    apply Lub; intros r [Hr Hf]; apply Rnot_lt_le; intro Q.
    assert (r <= m) by (apply Ub; split; auto).
    destruct (Req_dec r m) as [->|Ne]; [lra|].
    assert (A : Rabs (f r - f m) < c - f m).
    { apply Hc; split; [split; [exact I|congruence]|]. unfold dist; cbn; unfold R_dist; apply Rabs_def1; lra. }
    apply Rabs_def2 in A; lra. }
  exists m; split; [|split; [exact Fm|]].
  - destruct (Req_dec m t) as [->|]; lra.
  - intros r Hr; apply Rnot_le_lt; intro C. assert (r <= m) by (apply Ub; unfold E; lra). lra.
Qed.

(* A continuous function that is above c at 0 and at most c at t has a first time m at which it is at most c. *)
Lemma first_time_at_most (f : R -> R) (t c : R) : 0 <= t -> (forall r, continuity_pt f r) -> c < f 0 -> f t <= c ->
  exists m, 0 < m <= t /\ f m <= c /\ forall r, 0 <= r < m -> c < f r.
Proof.
  intros Ht Cf F0 Ft.
  destruct (last_time_at_least (fun r => - f (t - r)) 0 t (- c)) as (m & Hm & Fm & A).
  - exact Ht.
  - intro r; apply continuity_pt_opp. apply (continuity_pt_comp (fun r => t - r) f); [|apply Cf].
    apply continuity_pt_minus; [apply continuity_pt_const; now intros ? ?|apply derivable_continuous_pt, derivable_pt_id].
  - cbn; rewrite Rminus_0_r; lra.
  - cbn; replace (t - t) with 0 by ring; lra.
  - exists (t - m); split; [lra|split; [lra|]].
    intros r Hr; assert (B := A (t - r) ltac:(lra)); cbn in B; replace (t - (t - r)) with r in B by ring; lra.
Qed.

(* A function whose derivative is at least `rate` strictly between two times rises at least at that rate; at the ends no derivative is
   needed. *)
Lemma rises_at_rate f df t0 t1 rate : t0 < t1 -> (forall r, continuity_pt f r) ->
  (forall r, t0 < r < t1 -> is_derive f r (df r) /\ rate <= df r) -> rate * (t1 - t0) <= f t1 - f t0.
Proof.
  intros Sm Cx D.
  (* At the ends there may be no derivative: the mean value theorem is used on the open interval. *)
  destruct (MVT_gen f t0 t1 (fun r => df r)) as (c & Hc & E).
  - rewrite Rmin_left, Rmax_right by lra; intros r Hr; apply D; lra.
  - intros r _; apply Cx.
  - rewrite Rmin_left, Rmax_right in Hc by lra.
    (* MVT_gen gives c in the closed interval; argue with the classical theorem instead when c is an end *)
    assert (H : exists c, t0 < c < t1 /\ f t1 - f t0 = df c * (t1 - t0)).
    { clear c Hc E.
      assert (pr : forall c, t0 < c < t1 -> derivable_pt f c).
      { intros c Hc; exists (df c); apply is_derive_Reals, D; lra. }
      assert (pr2 : forall c, t0 < c < t1 -> derivable_pt id c) by (intros; apply derivable_pt_id).
      destruct (MVT f id t0 t1 pr pr2 Sm) as (c & Hc & E).
      - intros; apply Cx.
      - intros; apply derivable_continuous_pt, derivable_pt_id.
      - exists c; split; [exact Hc|].
        unfold id at 1 2 in E.
        replace (derive_pt id c (pr2 c Hc)) with 1 in E by (symmetry; rewrite (pr_nu id c _ (derivable_pt_id c)); apply derive_pt_id).
        replace (derive_pt f c (pr c Hc)) with (df c) in E; [lra|].
        symmetry; apply derive_pt_eq_0, is_derive_Reals, D; lra. }
    destruct H as (c' & Hc' & ->). apply Rmult_le_compat_r; [lra|]. apply D; lra.
Qed.

(* The control law (13) of a component, a = x - lower edge, b = upper edge - x: xi = 1/a + 1/b, epsilon = ln(a/b), u = -gain xi epsilon. *)
Definition law (gain a b : R) : R := - gain * (1 / a + 1 / b) * ln (a / b).

(* Mirroring the state between the edges changes the sign of the input. *)
Lemma law_odd gain a b : 0 < a -> 0 < b -> law gain a b = - law gain b a.
Proof.
  intros; unfold law. replace (a / b) with (/ (b / a)) by (field; lra).
  rewrite ln_Rinv by (apply Rdiv_lt_0_compat; lra). ring.
Qed.

(* Closer than rho to the lower edge the law pushes x up faster than drift and disturbance (force_max) and the edge (edge_speed)
   together. *)
Lemma law_outweighs_bounds_near_edge gain a b rho width g_min force_max edge_speed : 0 < gain -> 0 < a <= rho -> width <= a + b -> rho <= width / 4 -> 0 < g_min -> rho * (force_max + edge_speed) <= g_min * gain ->
  force_max + edge_speed <= g_min * law gain a b.
Proof.
  intros Hk Ha Hd Hr Hg Hs.
  assert (B : 3 * a <= b) by lra.
  assert (Ln : 1 <= ln (b / a)).
  { rewrite <- (ln_exp 1). apply Rcomplements.ln_le; [apply exp_pos|].
    apply Rle_trans with 3; [apply exp_le_3|]. apply Rcomplements.Rle_div_r; lra. }
  rewrite law_odd by lra. unfold law.
  replace (g_min * - (- gain * (1 / b + 1 / a) * ln (b / a))) with (g_min * gain * ((1 / a + 1 / b) * ln (b / a))) by ring.
  assert (0 < / b) by (apply Rinv_0_lt_compat; lra).
  assert (/ rho <= / a) by (apply Rinv_le_contravar; lra).
  assert (0 < / rho) by (apply Rinv_0_lt_compat; lra).
  assert (/ rho <= (1 / a + 1 / b) * ln (b / a)).
  { rewrite <- (Rmult_1_r (/ rho)). apply Rmult_le_compat; unfold Rdiv; lra. }
  apply Rle_trans with (g_min * gain * / rho).
  - apply (Rmult_le_reg_l rho); [lra|]. replace (rho * (g_min * gain * / rho)) with (g_min * gain) by (field; lra). lra.
  - apply Rmult_le_compat_l; [|lra]. left; apply Rmult_lt_0_compat; lra.
Qed.

Lemma Rmin_formula a b : Rmin a b = (a + b - Rabs (a - b)) / 2.
Proof. unfold Rmin, Rabs; destruct Rle_dec, Rcase_abs; lra. Qed.

Lemma continuity_pt_Rmin f g t : continuity_pt f t -> continuity_pt g t -> continuity_pt (fun t => Rmin (f t) (g t)) t.
Proof.
  intros A B. apply continuity_pt_ext with (fun t => (f t + g t - Rabs (f t - g t)) * / 2).
  { intro; now rewrite Rmin_formula. }
  apply (continuity_pt_mult (fun t => f t + g t - Rabs (f t - g t)) (fun _ => / 2)).
  - apply (continuity_pt_minus (fun t => f t + g t) (fun t => Rabs (f t - g t))).
    + now apply continuity_pt_plus.
    + apply (continuity_pt_comp (fun t => f t - g t) Rabs); [now apply continuity_pt_minus|apply Rcontinuity_abs].
  - apply continuity_pt_const; now intros ? ?.
Qed.

(* The minimum of 1 and of values 0 .. n - 1 at time t. The 1 makes it defined for n = 0. *)
Fixpoint minimum_of (n : nat) (values : nat -> R -> R) (t : R) : R :=
  match n with O => 1 | S m => Rmin (values m t) (minimum_of m values t) end.

Lemma minimum_of_continuous n values : (forall i t, (i < n)%nat -> continuity_pt (values i) t) -> forall t, continuity_pt (minimum_of n values) t.
Proof.
  induction n; intros H t; cbn.
  - apply continuity_pt_const; now intros ? ?.
  - apply continuity_pt_Rmin; [apply H; lia|apply IHn; intros; apply H; lia].
Qed.
Lemma minimum_of_below n values t i : (i < n)%nat -> minimum_of n values t <= values i t.
Proof.
  induction n; [lia|]; intro H; cbn. destruct (Nat.eq_dec i n) as [->|]; [apply Rmin_l|].
  apply Rle_trans with (minimum_of n values t); [apply Rmin_r|apply IHn; lia].
Qed.
Lemma minimum_of_at_least n values t c : c <= 1 -> (forall i, (i < n)%nat -> c <= values i t) -> c <= minimum_of n values t.
Proof. intro C; induction n; intro H; cbn; [exact C|]. apply Rmin_glb; [apply H; lia|apply IHn; intros; apply H; lia]. Qed.
(* Where it is below 1, the minimum is attained by a component. *)
Lemma minimum_of_attained n values t : minimum_of n values t < 1 -> exists i, (i < n)%nat /\ values i t = minimum_of n values t.
Proof.
  induction n; cbn; [lra|]. unfold Rmin; destruct Rle_dec; intro H; [exists n; split; [lia|reflexivity]|].
  destruct (IHn H) as (i & Hi & E); exists i; split; [lia|exact E].
Qed.

(* If every one of n components has a positive number with a property that smaller numbers keep, one positive number has it for all
   components. *)
Lemma common_positive_bound n (P : nat -> R -> Prop) : (forall i r r', P i r -> 0 < r' <= r -> P i r') ->
  (forall i, (i < n)%nat -> exists r, 0 < r /\ P i r) -> exists r, 0 < r <= 1 /\ forall i, (i < n)%nat -> P i r.
Proof.
  intros Mono; induction n; intro H; [exists 1; split; [lra|lia]|].
  destruct IHn as (r & Hr & A); [intros; apply H; lia|]. destruct (H n ltac:(lia)) as (q & Hq & B).
  assert (0 < Rmin r q) by (apply Rmin_glb_lt; lra).
  exists (Rmin r q); split; [split; [easy|apply Rle_trans with r; [apply Rmin_l|lra]]|].
  intros i Hi; destruct (Nat.eq_dec i n) as [->|].
  - apply Mono with q; [exact B|]; split; [easy|apply Rmin_r].
  - apply Mono with r; [apply A; lia|]; split; [easy|apply Rmin_l].
Qed.

(* f changes at most by `speed` a second. *)
Definition lipschitz (speed : R) (f : R -> R) : Prop := forall s t, Rabs (f t - f s) <= speed * Rabs (t - s).

Lemma lipschitz_continuous speed f : lipschitz speed f -> forall t, continuity_pt f t.
Proof.
  intros H t e He.
  assert (V : 0 <= speed).
  { assert (A := H 0 1). replace (1 - 0) with 1 in A by ring. rewrite Rabs_R1, Rmult_1_r in A. pose proof (Rabs_pos (f 1 - f 0)); lra. }
  exists (e / (speed + 1)); split; [apply Rdiv_lt_0_compat; lra|].
  intros r [_ Hr]; cbn in *; unfold R_dist in *.
  apply Rle_lt_trans with (speed * Rabs (r - t)); [apply H|].
  assert (speed * Rabs (r - t) <= speed * (e / (speed + 1))) by (apply Rmult_le_compat_l; lra).
  assert (speed * (e / (speed + 1)) < e); [|lra].
  apply (Rmult_lt_reg_r (speed + 1)); [lra|]. replace (speed * (e / (speed + 1)) * (speed + 1)) with (speed * e) by (field; lra). nra.
Qed.

(* n components, each with a gain, edges L and U, and a plant xdot = f + g u, up to the time t_c. *)
Section Loop.
  Variables (n : nat) (t_c : R).
  Variables gain g_min force_max edge_speed width_min : nat -> R.  (* by component; g_min bounds g from below, force_max bounds |f| *)
  Variables L U x f g : nat -> R -> R.  (* by component and time; f is drift and disturbance along the trajectory *)
  Hypothesis gain_pos : forall i, (i < n)%nat -> 0 < gain i.
  Hypothesis g_min_pos : forall i, (i < n)%nat -> 0 < g_min i.
  Hypothesis width_min_pos : forall i, (i < n)%nat -> 0 < width_min i.
  Hypothesis L_lipschitz : forall i, (i < n)%nat -> lipschitz (edge_speed i) (L i).
  Hypothesis U_lipschitz : forall i, (i < n)%nat -> lipschitz (edge_speed i) (U i).
  Hypothesis wide_enough : forall i t, (i < n)%nat -> 0 <= t <= t_c -> L i t + width_min i <= U i t.
  Hypothesis x_continuous : forall i t, (i < n)%nat -> continuity_pt (x i) t.

  (* At time t the state is strictly between the edges. *)
  Definition inside (t : R) : Prop := forall i, (i < n)%nat -> L i t < x i t < U i t.
  (* The input that the law gives. *)
  Definition law_input (i : nat) (t : R) : R := law (gain i) (x i t - L i t) (U i t - x i t).

  Hypothesis starts_inside : inside 0.
  Hypothesis plant_equation : forall t, 0 < t < t_c -> inside t -> forall i, (i < n)%nat ->
    is_derive (x i) t (f i t + g i t * law_input i t) /\ Rabs (f i t) <= force_max i /\ g_min i <= g i t.

  (* The distance of the state to the nearer edge. *)
  Let distance_to_edge (i : nat) (t : R) := Rmin (x i t - L i t) (U i t - x i t).

  Lemma distance_to_edge_continuous i t : (i < n)%nat -> continuity_pt (distance_to_edge i) t.
  Proof.
    intro Hi; apply continuity_pt_Rmin; apply continuity_pt_minus; auto; eapply lipschitz_continuous; eauto.
  Qed.

  (* There is a rho that is at most the distance to the edges at 0, and so small that the law outweighs all bounds within rho of an edge. *)
  Lemma safe_distance_exists : exists rho, 0 < rho <= 1 /\ forall i, (i < n)%nat ->
    rho <= distance_to_edge i 0 /\ rho <= width_min i / 4 /\ rho * (force_max i + edge_speed i) <= g_min i * gain i.
  Proof.
    destruct (common_positive_bound n (fun i r => r <= distance_to_edge i 0 /\ r <= width_min i / 4 /\ r * Rabs (force_max i + edge_speed i) <= g_min i * gain i)) as (rho & Hr & A).
    3: { exists rho; split; [exact Hr|]; intros i Hi; destruct (A i Hi) as (B & C & D); repeat split; try lra.
         apply Rle_trans with (rho * Rabs (force_max i + edge_speed i)); [apply Rmult_le_compat_l; [lra|apply Rle_abs]|exact D]. }
    - intros i r r' (A & B & C) D; split; [|split]; try lra.
      apply Rle_trans with (r * Rabs (force_max i + edge_speed i)); [apply Rmult_le_compat_r; [apply Rabs_pos|lra]|exact C].
    - intros i Hi.
      assert (R0 : 0 < distance_to_edge i 0) by (unfold distance_to_edge; destruct (starts_inside i Hi); apply Rmin_glb_lt; lra).
      pose proof (width_min_pos i Hi). pose proof (Rmult_lt_0_compat _ _ (g_min_pos i Hi) (gain_pos i Hi)) as GK.
      set (q := g_min i * gain i / (Rabs (force_max i + edge_speed i) + 1)).
      pose proof (Rabs_pos (force_max i + edge_speed i)). pose proof (Rle_abs (force_max i + edge_speed i)).
      assert (Q : 0 < q) by (apply Rdiv_lt_0_compat; lra).
      assert (Pos : 0 < Rmin (distance_to_edge i 0) (Rmin (width_min i / 4) q)) by (apply Rmin_glb_lt; [exact R0|apply Rmin_glb_lt; lra]).
      exists (Rmin (distance_to_edge i 0) (Rmin (width_min i / 4) q)); split; [exact Pos|].
      split; [apply Rmin_l|split].
      + eapply Rle_trans; [apply Rmin_r|apply Rmin_l].
      + set (r := Rmin (distance_to_edge i 0) _) in *. assert (r <= q) by (eapply Rle_trans; [apply Rmin_r|apply Rmin_r]).
        apply Rle_trans with (q * (Rabs (force_max i + edge_speed i) + 1)); [|right; unfold q; field; lra].
        apply Rle_trans with (r * (Rabs (force_max i + edge_speed i) + 1)); [apply Rmult_le_compat_l; lra|apply Rmult_le_compat_r; lra].
  Qed.

  (* The state stays at least rho away from every edge until t_c. *)
  Theorem keeps_safe_distance : exists rho, 0 < rho /\ forall t, 0 <= t <= t_c -> forall i, (i < n)%nat ->
    rho <= x i t - L i t /\ rho <= U i t - x i t.
  Proof.
    destruct safe_distance_exists as (rho & Hr & A). exists rho; split; [lra|].
    assert (G : forall t, 0 <= t <= t_c -> rho <= minimum_of n distance_to_edge t).
    2: { intros t Ht i Hi; assert (B := G t Ht). pose proof (minimum_of_below n distance_to_edge t i Hi) as C. unfold distance_to_edge in C at 2.
         pose proof (Rmin_l (x i t - L i t) (U i t - x i t)). pose proof (Rmin_r (x i t - L i t) (U i t - x i t)). lra. }
    intros t1 Ht1; apply Rnot_lt_le; intro Bad.
    set (h := minimum_of n distance_to_edge) in *.
    set (c := Rmax (rho / 2) ((h t1 + rho) / 2)).
    assert (C : 0 < c < rho /\ h t1 <= c) by (unfold c, Rmax; destruct Rle_dec; lra).
    assert (H0 : rho <= h 0) by (apply minimum_of_at_least; [lra|intros; now apply A]).
    destruct (first_time_at_most h t1 c) as (m & Hm & Fm & Before); try lra.
    { intro; apply minimum_of_continuous; intros; now apply distance_to_edge_continuous. }
    assert (In : forall r, 0 <= r < m -> inside r).
    { intros r Hr' i Hi. assert (B := Before r Hr'). pose proof (minimum_of_below n distance_to_edge r i Hi) as D. fold h in D.
      unfold distance_to_edge in D. pose proof (Rmin_l (x i r - L i r) (U i r - x i r)). pose proof (Rmin_r (x i r - L i r) (U i r - x i r)). lra. }
    destruct (minimum_of_attained n distance_to_edge m) as (i & Hi & E); [fold h; lra|]. fold h in E.
    destruct (A i Hi) as (A0 & Ad & Ag). unfold distance_to_edge in E, A0.
    pose proof (Rmin_l (x i 0 - L i 0) (U i 0 - x i 0)) as M1. pose proof (Rmin_r (x i 0 - L i 0) (U i 0 - x i 0)) as M2.
    assert (Near : x i m - L i m < rho \/ U i m - x i m < rho) by (unfold Rmin in E; destruct Rle_dec; [left|right]; lra).
    destruct Near as [Near|Near].
    - destruct (last_time_at_least (fun t => x i t - L i t) 0 m rho) as (s & Hs & Fs & After); try lra.
      { intro; apply continuity_pt_minus; [auto|eapply lipschitz_continuous; eauto]. }
      assert (edge_speed i * (m - s) <= x i m - x i s).
      { apply (rises_at_rate (x i) (fun r => f i r + g i r * law_input i r)); [lra|intro; auto|]. intros r Hr'.
        assert (I := In r ltac:(lra)). destruct (plant_equation r ltac:(lra) I i Hi) as (De & Fb & Gb).
        split; [exact De|]. specialize (I i Hi). assert (Aft := After r ltac:(lra)); cbn in Aft.
        assert (W := wide_enough i r Hi ltac:(lra)).
        assert (P : force_max i + edge_speed i <= g i r * law_input i r).
        { apply law_outweighs_bounds_near_edge with rho (width_min i); auto; try lra.
          - pose proof (g_min_pos i Hi); lra.
          - apply Rle_trans with (g_min i * gain i); [exact Ag|]. apply Rmult_le_compat_r; [left; auto|exact Gb]. }
        apply Rabs_le_between in Fb. lra. }
      assert (Lp := L_lipschitz i Hi s m). rewrite (Rabs_pos_eq (m - s)) in Lp by lra. apply Rabs_le_between in Lp. lra.
    - destruct (last_time_at_least (fun t => U i t - x i t) 0 m rho) as (s & Hs & Fs & After); try lra.
      { intro; apply continuity_pt_minus; [eapply lipschitz_continuous; eauto|auto]. }
      assert (edge_speed i * (m - s) <= - x i m - - x i s).
      { apply (rises_at_rate (fun t => - x i t) (fun r => - (f i r + g i r * law_input i r))); [lra|intro; apply continuity_pt_opp; auto|].
        intros r Hr'.
        assert (I := In r ltac:(lra)). destruct (plant_equation r ltac:(lra) I i Hi) as (De & Fb & Gb).
        split; [exact (is_derive_opp _ _ _ De)|]. specialize (I i Hi). assert (Aft := After r ltac:(lra)); cbn in Aft.
        assert (W := wide_enough i r Hi ltac:(lra)).
        assert (P : force_max i + edge_speed i <= g i r * law (gain i) (U i r - x i r) (x i r - L i r)).
        { apply law_outweighs_bounds_near_edge with rho (width_min i); auto; try lra.
          - pose proof (g_min_pos i Hi); lra.
          - apply Rle_trans with (g_min i * gain i); [exact Ag|]. apply Rmult_le_compat_r; [left; auto|exact Gb]. }
        rewrite law_odd in P by lra. fold (law_input i r) in P.
        apply Rabs_le_between in Fb. lra. }
      assert (Lp := U_lipschitz i Hi s m). rewrite (Rabs_pos_eq (m - s)) in Lp by lra. apply Rabs_le_between in Lp. lra.
  Qed.

  (* The state stays strictly inside the tube until t_c. *)
  Corollary stays_inside : forall t, 0 <= t <= t_c -> inside t.
  Proof. destruct keeps_safe_distance as (rho & Hr & H); intros t Ht i Hi; destruct (H t Ht i Hi); lra. Qed.
End Loop.

