(* How fast the edges are, by the differences of neighbouring Bezier coefficients; and `reach_avoid_stay`, the closed loop of Loop.v in
   the tube of Tube.v: a plant under the law in continuous time stays in the state space, avoids every unsafe set and reaches the target
   set.

   Emitted.v and Windows.v use the speed; a theorem file about the tube alone uses `reach_avoid_stay` as its second theorem
   (docs/theorem.md). The lemma book has it as `refined.rates_shipped` and `theorem.component` (docs/lemmas.md). *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core.Raux.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop.
Import ListNotations.
Open Scope R_scope.

(* Neighbouring coefficients differ by at most step_max. *)
Definition steps_within (step_max : Z) (c : bezier) : bool :=
  ((Z.abs (c1 c - c0 c) <=? step_max) && (Z.abs (c2 c - c1 c) <=? step_max) && (Z.abs (c3 c - c2 c) <=? step_max))%Z.
(* On every segment this holds for both edges of dimension i. *)
Definition edge_steps_within (step_max : Z) (i : nat) (rows : table) : bool :=
  forallb (fun p => let c := nth i p (zero_bezier, zero_bezier) in steps_within step_max (fst c) && steps_within step_max (snd c)) (pieces rows).

(* What the theorems about motion need besides `tube_check`: a positive smallest width, an error that is not negative, and bounds on the
   steps of the edges. *)
Definition slopes_check (edge_error : Q) (spec : task) (rows : table) (step_maxima : list Z) : bool :=
  (is_positive (min_width spec) && Qle_bool 0 edge_error && forallb (fun i => edge_steps_within (nth i step_maxima 0%Z) i rows) (seq 0 (n spec)))%bool.

Lemma Zabs_bounds a V : (Z.abs a <= V)%Z -> - IZR V <= IZR a <= IZR V.
Proof. intro H; apply Z.abs_le in H; rewrite <- opp_IZR; split; apply IZR_le; lia. Qed.

(* Such a polynomial changes by at most 3 step_max a unit of s. *)
Lemma steps_within_lipschitz step_max c s r : steps_within step_max c = true -> 0 <= s <= 1 -> 0 <= r <= 1 ->
  Rabs (bezier_value c r - bezier_value c s) <= 3 * IZR step_max * Rabs (r - s).
Proof.
  unfold steps_within; rewrite !andb_true_iff, !Z.leb_le; intros [[A B] C] Hs Hr.
  apply Zabs_bounds in A, B, C; rewrite minus_IZR in A, B, C.
  set (a0 := IZR (c1 c) - IZR (c0 c)) in *. set (a1 := IZR (c2 c) - IZR (c1 c)) in *. set (a2 := IZR (c3 c) - IZR (c2 c)) in *.
  set (d := fun x y => a0 * ((1-x)*(1-y)) + a1 * (x*(1-y) + y*(1-x)) + a2 * (x*y)).
  assert (E : bezier_value c r - bezier_value c s = (r - s) * (d s s + d s r + d r r)).
  { unfold bezier_value, d, a0, a1, a2; ring. }
  assert (D : forall x y, 0 <= x <= 1 -> 0 <= y <= 1 -> - IZR step_max <= d x y <= IZR step_max).
  { intros x y Hx Hy; unfold d.
    assert (0 <= (1-x)*(1-y)) by (apply Rmult_le_pos; lra).
    assert (0 <= x*(1-y) + y*(1-x)) by (apply Rplus_le_le_0_compat; apply Rmult_le_pos; lra).
    assert (0 <= x*y) by (apply Rmult_le_pos; lra).
    assert (G : forall v, v = v * ((1-x)*(1-y)) + v * (x*(1-y) + y*(1-x)) + v * (x*y)) by (intro; ring).
    split.
    - rewrite (G (- IZR step_max)); repeat apply Rplus_le_compat; apply Rmult_le_compat_r; lra.
    - rewrite (G (IZR step_max)); repeat apply Rplus_le_compat; apply Rmult_le_compat_r; lra. }
  rewrite E, Rabs_mult, Rmult_comm. apply Rmult_le_compat_r; [apply Rabs_pos|].
  apply Rabs_le. pose proof (D s s Hs Hs). pose proof (D s r Hs Hr). pose proof (D r r Hr Hr). lra.
Qed.

(* One edge, of dimension i: `side` picks it in a pair of the table, `bezier_of_side` in a pair of polynomials. *)
Section EdgeColumn.
  Variables (rows : table) (n i : nat) (step_max : Z) (side : Z * Z -> Z) (bezier_of_side : bezier * bezier -> bezier).
  Hypothesis rows_regular : is_regular n rows = true.
  Hypothesis axis_below_n : (i < n)%nat.
  Hypothesis side_matches : (side = fst /\ bezier_of_side = fst) \/ (side = snd /\ bezier_of_side = snd).
  Hypothesis steps_checked : edge_steps_within step_max i rows = true.
  Let K := segment_count rows.
  (* The edge in units, by spline time; `segment_bezier` is its polynomial on segment k. *)
  Let edge_spline (u : R) := spline (edge_column side i rows) u.
  Let segment_bezier (k : nat) := bezier_of_side (nth i (nth k (pieces rows) []) (zero_bezier, zero_bezier)).

  Lemma side_of_zero : side (0, 0)%Z = 0%Z. Proof. destruct side_matches as [[-> _]|[-> _]]; reflexivity. Qed.
  Lemma segment_count_pos : (0 < K)%nat. Proof. destruct (is_regular_lengths _ _ rows_regular); unfold K, segment_count; lia. Qed.

  Lemma segment_bezier_value k : (k < K)%nat ->
    segment_bezier k = bezier_of_spline (side (nth i (nth k rows []) (0,0)%Z)) (side (nth i (nth (k+1) rows []) (0,0)%Z))
                 (side (nth i (nth (k+2) rows []) (0,0)%Z)) (side (nth i (nth (k+3) rows []) (0,0)%Z)).
  Proof.
    intro H; destruct (is_regular_lengths _ _ rows_regular) as [_ Ln]; unfold K, segment_count in H; unfold segment_bezier.
    rewrite pieces_nth by (unfold segment_count; lia). rewrite (piece_of_rows_nth n) by (try apply Ln; lia).
    destruct side_matches as [[-> ->]|[-> ->]]; reflexivity.
  Qed.

  Lemma edge_spline_in_its_segment u : 0 <= u <= INR K -> edge_spline u = bezier_value (segment_bezier (segment_index K u)) (u - INR (segment_index K u)).
  Proof.
    intro Hu. destruct (segment_index_range K u segment_count_pos Hu) as [Hk _].
    unfold edge_spline, spline. replace (length (edge_column side i rows) - 3)%nat with K by (unfold K, segment_count, edge_column; now rewrite map_length).
    cbv zeta. rewrite !edge_column_nth by exact side_of_zero. rewrite segment_bezier_value by exact Hk. apply cubic_blend_is_bezier.
  Qed.

  (* On segment k, ends included, the edge is that polynomial. *)
  Lemma edge_spline_in_segment k u : (k < K)%nat -> INR k <= u <= INR k + 1 -> edge_spline u = bezier_value (segment_bezier k) (u - INR k).
  Proof.
    intros Hk Hu.
    assert (INR k + 1 <= INR K) by (rewrite <- S_INR; apply le_INR; lia). pose proof (pos_INR k).
    rewrite edge_spline_in_its_segment by lra.
    destruct (segment_index_range K u segment_count_pos ltac:(lra)) as [Hs Hp]. set (m := segment_index K u) in *.
    assert (Cases : m = k \/ (m = (k + 1)%nat /\ u = INR k + 1) \/ ((m + 1)%nat = k /\ u = INR k)).
    { destruct (Nat.lt_trichotomy m k) as [C|[C|C]]; [right; right|now left|right; left].
      - assert (m + 1 <= k)%nat by lia. assert (INR (m + 1) <= INR k) by now apply le_INR.
        rewrite plus_INR in *; cbn [INR] in *. assert (E : INR (m + 1) = INR k) by (rewrite plus_INR; cbn [INR]; lra).
        apply INR_eq in E. split; [exact E|lra].
      - assert (INR (k + 1) <= INR m) by (apply le_INR; lia). rewrite plus_INR in *; cbn [INR] in *.
        assert (E : INR m = INR (k + 1)) by (rewrite plus_INR; cbn [INR]; lra). apply INR_eq in E. split; [exact E|lra]. }
    destruct Cases as [->|[[E ->]|[E ->]]]; [reflexivity| |].
    - rewrite E, !segment_bezier_value by lia. rewrite plus_INR; cbn [INR].
      replace (k + 1 + 1)%nat with (k + 2)%nat by lia. replace (k + 1 + 2)%nat with (k + 3)%nat by lia.
      unfold bezier_value, bezier_of_spline; cbn [c0 c1 c2 c3]; izr; ring.
    - rewrite <- E, !segment_bezier_value by lia. rewrite plus_INR; cbn [INR].
      replace (m + 1 + 1)%nat with (m + 2)%nat by lia. replace (m + 1 + 2)%nat with (m + 3)%nat by lia.
      unfold bezier_value, bezier_of_spline; cbn [c0 c1 c2 c3]; izr; ring.
  Qed.

  Lemma segment_bezier_steps k : (k < K)%nat -> steps_within step_max (segment_bezier k) = true.
  Proof.
    intro Hk. pose proof steps_checked as H. unfold edge_steps_within in H. rewrite forallb_forall in H.
    assert (A := H (nth k (pieces rows) []) ltac:(apply nth_In; now rewrite pieces_length)).
    cbv zeta in A. apply andb_true_iff in A. unfold segment_bezier; destruct side_matches as [[_ ->]|[_ ->]]; apply A.
  Qed.

  Lemma step_max_nonneg : 0 <= IZR step_max.
  Proof.
    assert (A := segment_bezier_steps 0 segment_count_pos). unfold steps_within in A. rewrite !andb_true_iff, !Z.leb_le in A. destruct A as [[A _] _].
    apply Zabs_bounds in A; lra.
  Qed.

  (* The edge changes by at most 3 step_max units a segment. *)
  Lemma edge_spline_lipschitz k : (k <= K)%nat -> forall u r, 0 <= u -> u <= r -> r <= INR k -> Rabs (edge_spline r - edge_spline u) <= 3 * IZR step_max * (r - u).
  Proof.
    pose proof step_max_nonneg as V0.
    induction k; intros Hk u r H0 H1 H2.
    - cbn in H2. assert (r = u) as -> by lra. rewrite Rminus_diag_eq, Rabs_R0 by reflexivity. lra.
    - rewrite S_INR in H2.
      assert (P : forall a b, INR k <= a -> a <= b -> b <= INR k + 1 -> Rabs (edge_spline b - edge_spline a) <= 3 * IZR step_max * (b - a)).
      { intros a b Ha Hab Hb. rewrite !(edge_spline_in_segment k) by (lia || lra).
        replace (b - a) with (Rabs ((b - INR k) - (a - INR k))) by (rewrite Rabs_pos_eq; lra).
        apply steps_within_lipschitz; [apply segment_bezier_steps; lia|lra|lra]. }
      destruct (Rle_dec r (INR k)); [apply IHk; lia || lra|].
      destruct (Rle_dec (INR k) u); [apply P; lra|].
      replace (edge_spline r - edge_spline u) with ((edge_spline r - edge_spline (INR k)) + (edge_spline (INR k) - edge_spline u)) by ring.
      eapply Rle_trans; [apply Rabs_triang|].
      pose proof (P (INR k) r ltac:(lra) ltac:(lra) ltac:(lra)).
      pose proof (IHk ltac:(lia) u (INR k) ltac:(lra) ltac:(lra) ltac:(lra)). lra.
  Qed.
End EdgeColumn.

(* Limited time runs no faster than time, and not backwards. *)
Lemma clamped_time_lipschitz t_c s t : s <= t -> 0 <= clamped_time t_c t - clamped_time t_c s <= t - s \/ t_c < 0.
Proof. unfold clamped_time, Rmax, Rmin; intros; repeat destruct Rle_dec; lra. Qed.

(* An edge is Lipschitz in time. *)
Lemma edge_lipschitz n i step_max unit t_c rows side : is_regular n rows = true -> (i < n)%nat -> 0 < unit -> 0 < t_c -> edge_steps_within step_max i rows = true ->
  side = fst \/ side = snd -> lipschitz (unit * (3 * IZR step_max) * (INR (segment_count rows) / t_c)) (edge unit t_c rows side i).
Proof.
  intros Rg Hi Hu HT St Sd.
  assert (Main : forall s t, s <= t ->
    Rabs (edge unit t_c rows side i t - edge unit t_c rows side i s) <= unit * (3 * IZR step_max) * (INR (segment_count rows) / t_c) * (t - s)).
  { intros s t H. unfold edge. fold (spline_time t_c rows s) (spline_time t_c rows t).
    rewrite <- Rmult_minus_distr_l, Rabs_mult, (Rabs_pos_eq unit) by lra. rewrite !Rmult_assoc.
    apply Rmult_le_compat_l; [lra|].
    destruct (spline_time_range t_c rows s HT), (spline_time_range t_c rows t HT).
    assert (KT : 0 <= INR (segment_count rows) / t_c) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    destruct (clamped_time_lipschitz t_c s t H) as [Hh|]; [|lra].
    assert (Up : spline_time t_c rows t - spline_time t_c rows s = INR (segment_count rows) / t_c * (clamped_time t_c t - clamped_time t_c s))
      by (unfold spline_time; ring).
    assert (0 <= INR (segment_count rows) / t_c * (clamped_time t_c t - clamped_time t_c s)) by (apply Rmult_le_pos; lra).
    assert (INR (segment_count rows) / t_c * (clamped_time t_c t - clamped_time t_c s) <= INR (segment_count rows) / t_c * (t - s)) by (apply Rmult_le_compat_l; lra).
    assert (V0 : 0 <= IZR step_max) by (destruct Sd as [->| ->]; eapply (step_max_nonneg rows n i step_max); eauto).
    apply Rle_trans with (3 * IZR step_max * (spline_time t_c rows t - spline_time t_c rows s)).
    - destruct Sd as [->| ->]; [apply (edge_spline_lipschitz rows n i step_max fst fst) with (k := segment_count rows)|apply (edge_spline_lipschitz rows n i step_max snd snd) with (k := segment_count rows)];
        auto; lra.
    - rewrite Up. apply Rle_trans with (3 * IZR step_max * (INR (segment_count rows) / t_c * (t - s))); [apply Rmult_le_compat_l; lra|right; ring]. }
  intros s t. destruct (Rle_dec s t).
  - rewrite (Rabs_pos_eq (t - s)) by lra. now apply Main.
  - rewrite (Rabs_minus_sym (edge _ _ _ _ _ t)), (Rabs_minus_sym t). rewrite (Rabs_pos_eq (s - t)) by lra. apply Main; lra.
Qed.

(* ------------------------------------------------------------------ reach-avoid-stay of the closed loop *)

(* A tube that the checks accept, and a plant xdot = f + g u, |f| <= force_max, g >= g_min > 0, of which nothing else is known. *)
Section ReachAvoidStay.
  Variables (unit edge_error : Q) (plan : search_plan) (spec : task) (rows : table) (step_maxima : list Z).
  Hypothesis tube_checked : tube_check unit edge_error plan spec rows = true.
  Hypothesis slopes_checked : slopes_check edge_error spec rows step_maxima = true.

  Let L (i : nat) (t : R) := lower unit spec rows i t.
  Let U (i : nat) (t : R) := upper unit spec rows i t.
  Let end_time := Q2R (t_c spec).

  Variables gain g_min force_max : nat -> R.
  Variables x f g : nat -> R -> R.
  Hypothesis gain_pos : forall i, (i < n spec)%nat -> 0 < gain i.
  Hypothesis g_min_pos : forall i, (i < n spec)%nat -> 0 < g_min i.
  Hypothesis x_continuous : forall i t, (i < n spec)%nat -> continuity_pt (x i) t.
  Hypothesis x_starts_inside : forall i, (i < n spec)%nat -> L i 0 < x i 0 < U i 0.
  Hypothesis plant_equation : forall t, 0 < t < end_time -> (forall i, (i < n spec)%nat -> L i t < x i t < U i t) -> forall i, (i < n spec)%nat ->
    is_derive (x i) t (f i t + g i t * law (gain i) (x i t - L i t) (U i t - x i t)) /\
    Rabs (f i t) <= force_max i /\ g_min i <= g i t.

  (* The theorem about continuous time: stay in the state space, avoid every unsafe set, reach the target set at t_c. *)
  Theorem reach_avoid_stay :
    (forall t, 0 <= t <= end_time -> in_space spec (fun i => x i t)) /\
    (forall t o, 0 <= t <= end_time -> In o (unsafe_sets spec) -> clear (n spec) (Q2R (clearance spec)) o (fun i => x i t)) /\
    in_target spec (fun i => x i end_time).
  Proof.
    pose proof tube_checked as C. unfold tube_check in C. cbv zeta in C. rewrite !andb_true_iff in C. destruct C as [[[Up Tp] Rg] _].
    unfold slopes_check in slopes_checked. rewrite !andb_true_iff, forallb_forall in slopes_checked. destruct slopes_checked as [[Mw Er] St].
    assert (E0 : 0 <= Q2R edge_error) by (apply Qle_bool_iff, Qle_Rle in Er; unfold Q2R in Er at 1; cbn in Er; lra).
    assert (Tp' := is_positive_sound _ Tp). assert (Up' := is_positive_sound _ Up). assert (Mw' := is_positive_sound _ Mw).
    assert (Near : forall i t, (i < n spec)%nat -> Rabs (L i t - lower unit spec rows i t) <= Q2R edge_error /\ Rabs (U i t - upper unit spec rows i t) <= Q2R edge_error).
    { intros i t _. unfold L, U. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. lra. }
    destruct (tube_sound unit edge_error Up spec rows plan tube_checked L U Near) as (P1 & _).
    assert (Keeps := inside_tube_meets_task unit edge_error Up spec rows plan tube_checked L U Near).
    assert (In_ : forall t, 0 <= t <= end_time -> inside (n spec) L U x t).
    { set (v := fun i => Q2R unit * (3 * IZR (nth i step_maxima 0%Z)) * (INR (segment_count rows) / end_time)).
      apply (stays_inside (n spec) end_time gain g_min force_max v (fun _ => Q2R (min_width spec)) L U x f g); auto.
      - intros i Hi. unfold v. apply (edge_lipschitz (n spec)); auto. apply St, in_seq; lia.
      - intros i Hi. unfold v. apply (edge_lipschitz (n spec)); auto. apply St, in_seq; lia.
      }
    split; [|split].
    - intros t Ht. apply (Keeps t (fun i => x i t)), (In_ t Ht).
    - intros t o Ht. apply (Keeps t (fun i => x i t)), (In_ t Ht).
    - apply (Keeps end_time (fun i => x i end_time)); [apply In_|]; unfold end_time; lra.
  Qed.
End ReachAvoidStay.

