(* Widths and speeds of the edges by window. A window is a segment of the spline, or the time from t_c on. For each window this file has
   the smallest and the largest width, and how fast an edge moves in it and in the one before.

   Period.v checks P9 window by window, so that it proves long periods. The lemma book has it as `sampled.windows` and
   `sampled.exact_windows` (docs/lemmas.md). *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core.Raux.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed.
Import ListNotations.
Open Scope R_scope.

(* The smallest and the largest Bezier coefficient, and the largest step between neighbours. *)
Definition smallest_coefficient (c : bezier) : Z := Z.min (Z.min (c0 c) (c1 c)) (Z.min (c2 c) (c3 c)).
Definition largest_coefficient (c : bezier) : Z := Z.max (Z.max (c0 c) (c1 c)) (Z.max (c2 c) (c3 c)).
Definition largest_step (c : bezier) : Z := Z.max (Z.abs (c1 c - c0 c)) (Z.max (Z.abs (c2 c - c1 c)) (Z.abs (c3 c - c2 c))).

Lemma smallest_coefficient_bounds c s : 0 <= s <= 1 -> IZR (smallest_coefficient c) <= bezier_value c s.
Proof. intro H. apply bezier_value_at_least; [|exact H]. unfold coefficients_at_least, smallest_coefficient. rewrite !andb_true_iff, !Z.leb_le. lia. Qed.
Lemma largest_coefficient_bounds c s : 0 <= s <= 1 -> bezier_value c s <= IZR (largest_coefficient c).
Proof.
  intro H. assert (A : IZR (- largest_coefficient c) <= bezier_value (bezier_combination (-1) c 0 zero_bezier) s).
  { apply bezier_value_at_least; [|exact H]. unfold coefficients_at_least, bezier_combination, zero_bezier, largest_coefficient; cbn [c0 c1 c2 c3]. rewrite !andb_true_iff, !Z.leb_le. lia. }
  rewrite bezier_combination_value, opp_IZR in A. lra.
Qed.
Lemma steps_within_largest_step c : steps_within (largest_step c) c = true.
Proof. unfold steps_within, largest_step. rewrite !andb_true_iff, !Z.leb_le. lia. Qed.
Lemma largest_step_nonneg c : (0 <= largest_step c)%Z.
Proof. unfold largest_step. eapply Z.le_trans; [apply Z.abs_nonneg|apply Z.le_max_l]. Qed.
Lemma steps_within_weaken step_max wider_max c : (step_max <= wider_max)%Z -> steps_within step_max c = true -> steps_within wider_max c = true.
Proof. unfold steps_within. rewrite !andb_true_iff, !Z.leb_le. lia. Qed.

(* The edges of dimension i of a table of K segments. *)
Section Windows.
  Variables (rows : table) (t_c unit : R) (n i : nat).
  Hypothesis rows_regular : is_regular n rows = true.
  Hypothesis axis_below_n : (i < n)%nat.
  Hypothesis t_c_pos : 0 < t_c.
  Hypothesis unit_pos : 0 < unit.
  Let K := segment_count rows.

  (* The window of time t: its segment, or K from t_c on. *)
  Definition window_index (t : R) : nat := Nat.min (Z.to_nat (Zfloor (INR K / t_c * Rmax 0 t))) K.

  (* The piece of a window. From t_c on the tube stands still: there it is the constant end of the last piece. *)
  Definition window_piece (k : nat) : piece := nth k (pieces rows ++ [map_edges constant_at_end (nth (K - 1) (pieces rows) [])]) [].
  (* The width in a window, as a polynomial. *)
  Definition width_bezier (k : nat) : bezier := let c := nth i (window_piece k) (zero_bezier, zero_bezier) in bezier_combination (-1) (fst c) 1 (snd c).
  (* The largest step of both edges in a window and in the one before. *)
  Definition window_step_max (k : nat) : Z :=
    let V j := let c := nth i (nth j (pieces rows) []) (zero_bezier, zero_bezier) in Z.max (largest_step (fst c)) (largest_step (snd c)) in
    Z.max (V (k - 1)%nat) (V k).

  Lemma segment_count_positive : (0 < K)%nat. Proof. destruct (is_regular_lengths _ _ rows_regular); unfold K, segment_count; lia. Qed.
  Lemma segment_rate_nonneg : 0 <= INR K / t_c. Proof. apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]. Qed.

  Lemma spline_time_is_minimum t : spline_time t_c rows t = Rmin (INR K / t_c * Rmax 0 t) (INR K).
  Proof.
    unfold spline_time, clamped_time. fold K. assert (KT : INR K / t_c * t_c = INR K) by (field; lra). pose proof segment_rate_nonneg as R0.
    unfold Rmin at 1. destruct (Rle_dec t t_c) as [tT|tT].
    - assert (INR K / t_c * Rmax 0 t <= INR K / t_c * t_c) by (apply Rmult_le_compat_l; [exact R0|unfold Rmax; destruct Rle_dec; lra]).
      rewrite Rmin_left by lra. reflexivity.
    - rewrite (Rmax_right 0 t_c), (Rmax_right 0 t) by lra.
      assert (INR K / t_c * t_c <= INR K / t_c * t) by (apply Rmult_le_compat_l; lra). rewrite Rmin_right by lra. lra.
  Qed.

  Lemma window_index_range t : (window_index t <= K)%nat /\ INR (window_index t) <= spline_time t_c rows t <= INR (window_index t) + 1 /\
    (window_index t = K -> spline_time t_c rows t = INR K).
  Proof.
    rewrite spline_time_is_minimum. unfold window_index. set (v := INR K / t_c * Rmax 0 t).
    assert (v0 : 0 <= v) by (apply Rmult_le_pos; [apply segment_rate_nonneg|apply Rmax_l]).
    assert (F0 : (0 <= Zfloor v)%Z) by (now apply Zfloor_lub).
    pose proof (Zfloor_lb v) as Lb. pose proof (Zfloor_ub v) as Ub.
    assert (E : INR (Z.to_nat (Zfloor v)) = IZR (Zfloor v)) by (now rewrite INR_IZR_INZ, Z2Nat.id).
    split; [apply Nat.le_min_r|].
    destruct (Nat.min_spec (Z.to_nat (Zfloor v)) K) as [[C ->]|[C ->]].
    - assert (S1 : INR (Z.to_nat (Zfloor v)) + 1 <= INR K) by (rewrite <- S_INR; apply le_INR; lia).
      rewrite Rmin_left by lra. split; [lra|intro; lia].
    - apply le_INR in C. rewrite Rmin_right by lra. split; [lra|reflexivity].
  Qed.

  (* Two times at most a segment apart lie in the same window or in neighbouring ones. *)
  Lemma window_same_or_next s t : s <= t -> INR K / t_c * (t - s) <= 1 -> window_index s = window_index t \/ window_index s = (window_index t - 1)%nat.
  Proof.
    intros Hs Hd. pose proof segment_rate_nonneg as R0. unfold window_index. set (a := INR K / t_c * Rmax 0 s). set (b := INR K / t_c * Rmax 0 t).
    assert (a0 : 0 <= a) by (apply Rmult_le_pos; [exact R0|apply Rmax_l]).
    assert (AB : a <= b).
    { apply Rmult_le_compat_l; [exact R0|]. unfold Rmax; repeat destruct Rle_dec; lra. }
    assert (BA : b <= a + 1).
    { assert (INR K / t_c * (Rmax 0 t - Rmax 0 s) <= INR K / t_c * (t - s)); [|unfold a, b; lra].
      apply Rmult_le_compat_l; [exact R0|]. unfold Rmax; repeat destruct Rle_dec; lra. }
    assert (F1 : (Zfloor a <= Zfloor b)%Z) by now apply Zfloor_le.
    assert (F2 : (Zfloor b < Zfloor a + 2)%Z).
    { apply lt_IZR. rewrite plus_IZR. pose proof (Zfloor_ub a). pose proof (Zfloor_lb b). lra. }
    assert (F0 : (0 <= Zfloor a)%Z) by (now apply Zfloor_lub). lia.
  Qed.

  Lemma window_piece_of_segment k : (k < K)%nat -> window_piece k = nth k (pieces rows) [].
  Proof. intro H. unfold window_piece. apply app_nth1. rewrite pieces_length. exact H. Qed.
  Lemma window_piece_after_end : window_piece K = map_edges constant_at_end (nth (K - 1) (pieces rows) []).
  Proof. unfold window_piece. rewrite app_nth2; rewrite pieces_length; [|unfold K; lia]. fold K. now rewrite Nat.sub_diag. Qed.

  Variables (side : Z * Z -> Z) (bezier_of_side : bezier * bezier -> bezier).
  Hypothesis side_matches : (side = fst /\ bezier_of_side = fst) \/ (side = snd /\ bezier_of_side = snd).
  Let edge_spline (u : R) := spline (edge_column side i rows) u.

  (* In every window the edge is a polynomial, also from t_c on. *)
  Lemma edge_spline_in_window t : exists s, 0 <= s <= 1 /\
    (s = match Nat.eq_dec (window_index t) K with left _ => 1 | right _ => spline_time t_c rows t - INR (window_index t) end) /\
    edge_spline (spline_time t_c rows t) = bezier_value (bezier_of_side (nth i (window_piece (window_index t)) (zero_bezier, zero_bezier))) s.
  Proof.
    destruct (window_index_range t) as (A & B & C).
    exists (match Nat.eq_dec (window_index t) K with left _ => 1 | right _ => spline_time t_c rows t - INR (window_index t) end).
    destruct (Nat.eq_dec (window_index t) K) as [E|E].
    - split; [lra|split; [reflexivity|]]. rewrite (C E), E, window_piece_after_end.
      assert (Ko : K = Datatypes.S (K - 1)) by (pose proof segment_count_positive; lia).
      assert (IK : INR K = INR (K - 1) + 1) by (rewrite Ko at 1; now rewrite S_INR).
      unfold edge_spline. rewrite (edge_spline_in_segment rows n i side bezier_of_side rows_regular axis_below_n side_matches (K - 1)) by (fold K; pose proof segment_count_positive; lia || lra).
      replace (INR K - INR (K - 1)) with 1 by lra.
      assert (Nm : nth i (map_edges constant_at_end (nth (K - 1) (pieces rows) [])) (zero_bezier, zero_bezier) =
        (fun c => (constant_at_end (fst c), constant_at_end (snd c))) (nth i (nth (K - 1) (pieces rows) []) (zero_bezier, zero_bezier))).
      { unfold map_edges. rewrite <- (map_nth (fun c : bezier * bezier => (constant_at_end (fst c), constant_at_end (snd c)))). reflexivity. }
      rewrite Nm. destruct side_matches as [[_ ->]|[_ ->]]; cbn [fst snd]; rewrite constant_at_end_value; ring.
    - split; [lra|split; [reflexivity|]]. rewrite window_piece_of_segment by lia.
      unfold edge_spline. apply (edge_spline_in_segment rows n i side bezier_of_side rows_regular axis_below_n side_matches (window_index t)); [fold K; lia|exact B].
  Qed.

  Lemma window_steps_within k V : (k < K)%nat -> (largest_step (bezier_of_side (nth i (nth k (pieces rows) []) (zero_bezier, zero_bezier))) <= V)%Z ->
    steps_within V (bezier_of_side (nth i (nth k (pieces rows) []) (zero_bezier, zero_bezier))) = true.
  Proof. intros _ H. now apply (steps_within_weaken (largest_step (bezier_of_side (nth i (nth k (pieces rows) []) (zero_bezier, zero_bezier))))), steps_within_largest_step. Qed.

  Lemma edge_spline_moves_at_most k V u v : (k < K)%nat -> (largest_step (bezier_of_side (nth i (nth k (pieces rows) []) (zero_bezier, zero_bezier))) <= V)%Z ->
    INR k <= u <= v -> v <= INR k + 1 -> Rabs (edge_spline v - edge_spline u) <= 3 * IZR V * (v - u).
  Proof.
    intros Hk HV Hu Hv. unfold edge_spline. rewrite !(edge_spline_in_segment rows n i side bezier_of_side rows_regular axis_below_n side_matches k) by (fold K; lia || lra).
    replace (v - u) with (Rabs ((v - INR k) - (u - INR k))) by (rewrite Rabs_pos_eq; lra).
    apply steps_within_lipschitz; [now apply window_steps_within|lra|lra].
  Qed.

  Lemma side_step_below_largest k : (largest_step (bezier_of_side (nth i (nth k (pieces rows) []) (zero_bezier, zero_bezier))) <=
    Z.max (largest_step (fst (nth i (nth k (pieces rows) []) (zero_bezier, zero_bezier)))) (largest_step (snd (nth i (nth k (pieces rows) []) (zero_bezier, zero_bezier)))))%Z.
  Proof. destruct side_matches as [[_ ->]|[_ ->]]; lia. Qed.

  Lemma window_step_max_nonneg k : 0 <= IZR (window_step_max k).
  Proof. apply IZR_le. unfold window_step_max. eapply Z.le_trans; [|apply Z.le_max_r]. eapply Z.le_trans; [|apply Z.le_max_l]. apply largest_step_nonneg. Qed.

  (* How fast an edge moves in a window and in the one before. *)
  Definition window_edge_speed (k : nat) : R := unit * (3 * IZR (window_step_max k)) * (INR K / t_c).
  Lemma window_edge_speed_nonneg k : 0 <= window_edge_speed k.
  Proof. unfold window_edge_speed. apply Rmult_le_pos; [|apply segment_rate_nonneg]. apply Rmult_le_pos; [lra|]. pose proof (window_step_max_nonneg k). lra. Qed.

  (* Until time t an edge moved at most so fast, from at most a segment earlier on. *)
  Lemma edge_moves_at_most s t : s <= t -> INR K / t_c * (t - s) <= 1 ->
    Rabs (edge unit t_c rows side i t - edge unit t_c rows side i s) <= window_edge_speed (window_index t) * (t - s).
  Proof.
    intros Hs Hd. unfold edge. fold (spline_time t_c rows s) (spline_time t_c rows t). fold (edge_spline (spline_time t_c rows s)) (edge_spline (spline_time t_c rows t)).
    destruct (window_index_range t) as (A & B & C). destruct (window_index_range s) as (A' & B' & C').
    pose proof segment_rate_nonneg as R0.
    assert (St : 0 <= spline_time t_c rows t - spline_time t_c rows s <= INR K / t_c * (t - s)).
    { destruct (clamped_time_lipschitz t_c s t Hs) as [Hh|]; [|lra]. unfold spline_time. fold K.
      assert (0 <= INR K / t_c * (clamped_time t_c t - clamped_time t_c s)) by (apply Rmult_le_pos; lra).
      assert (INR K / t_c * (clamped_time t_c t - clamped_time t_c s) <= INR K / t_c * (t - s)) by (apply Rmult_le_compat_l; lra). lra. }
    set (k := window_index t) in *. set (V := window_step_max k).
    assert (V0 := window_step_max_nonneg k). fold V in V0.
    assert (Vk : forall j, j = k \/ j = (k - 1)%nat -> (largest_step (bezier_of_side (nth i (nth j (pieces rows) []) (zero_bezier, zero_bezier))) <= V)%Z).
    { intros j Hj. eapply Z.le_trans; [apply side_step_below_largest|]. unfold V, window_step_max. destruct Hj as [->| ->]; [apply Z.le_max_r|apply Z.le_max_l]. }
    assert (Mv : Rabs (edge_spline (spline_time t_c rows t) - edge_spline (spline_time t_c rows s)) <= 3 * IZR V * (spline_time t_c rows t - spline_time t_c rows s)).
    { destruct (window_same_or_next s t Hs Hd) as [E|E]; fold k in E.
      - rewrite E in *. destruct (Nat.eq_dec k K) as [Q|Q].
        + rewrite (C Q), (C' Q), !Rminus_diag_eq, Rabs_R0 by reflexivity. lra.
        + apply (edge_spline_moves_at_most k); [lia|apply Vk; now left|lra|lra].
      - destruct (Nat.eq_dec k 0) as [Z0|Z0].
        { rewrite E, Z0 in *. cbn in B, B'. pose proof segment_count_positive. apply (edge_spline_moves_at_most 0%nat); [lia|apply Vk; left; lia|cbn; lra|cbn; lra]. }
        assert (IK : INR k = INR (k - 1) + 1) by (rewrite <- S_INR; f_equal; lia). rewrite E in B'.
        replace (edge_spline (spline_time t_c rows t) - edge_spline (spline_time t_c rows s)) with
          ((edge_spline (spline_time t_c rows t) - edge_spline (INR k)) + (edge_spline (INR k) - edge_spline (spline_time t_c rows s))) by ring.
        eapply Rle_trans; [apply Rabs_triang|].
        assert (A1 : Rabs (edge_spline (spline_time t_c rows t) - edge_spline (INR k)) <= 3 * IZR V * (spline_time t_c rows t - INR k)).
        { destruct (Nat.eq_dec k K) as [Q|Q].
          - rewrite (C Q), <- Q, !Rminus_diag_eq, Rabs_R0 by reflexivity. lra.
          - apply (edge_spline_moves_at_most k); [lia|apply Vk; now left|lra|lra]. }
        assert (A2 : Rabs (edge_spline (INR k) - edge_spline (spline_time t_c rows s)) <= 3 * IZR V * (INR k - spline_time t_c rows s)).
        { apply (edge_spline_moves_at_most (k - 1)); [lia|apply Vk; now right|lra|lra]. }
        lra. }
    rewrite <- Rmult_minus_distr_l, Rabs_mult, (Rabs_pos_eq unit) by lra. unfold window_edge_speed. fold V. fold k. fold V.
    replace (unit * (3 * IZR V) * (INR K / t_c) * (t - s)) with (unit * (3 * IZR V * (INR K / t_c * (t - s)))) by ring.
    apply Rmult_le_compat_l; [lra|]. eapply Rle_trans; [exact Mv|]. apply Rmult_le_compat_l; lra.
  Qed.
End Windows.

(* The width in a window is between the smallest and the largest coefficient of its polynomial. *)
Lemma width_in_window rows T unit n i t : is_regular n rows = true -> (i < n)%nat -> 0 < T -> 0 < unit ->
  unit * IZR (smallest_coefficient (width_bezier rows i (window_index rows T t))) <= edge unit T rows snd i t - edge unit T rows fst i t <=
  unit * IZR (largest_coefficient (width_bezier rows i (window_index rows T t))).
Proof.
  intros Rg Hi HT Hu. unfold edge. fold (spline_time T rows t).
  destruct (edge_spline_in_window rows T n i Rg Hi HT fst fst (or_introl (conj eq_refl eq_refl)) t) as (s & Hs & Es & L).
  destruct (edge_spline_in_window rows T n i Rg Hi HT snd snd (or_intror (conj eq_refl eq_refl)) t) as (s' & _ & Es' & U).
  rewrite <- Es in Es'. subst s'. rewrite L, U.
  assert (A := smallest_coefficient_bounds (width_bezier rows i (window_index rows T t)) s Hs). assert (B := largest_coefficient_bounds (width_bezier rows i (window_index rows T t)) s Hs).
  unfold width_bezier in A, B at 1. rewrite bezier_combination_value in A. cbv zeta in A.
  unfold width_bezier in B. rewrite bezier_combination_value in B. cbv zeta in B. unfold width_bezier.
  split.
  - replace (unit * bezier_value (snd (nth i (window_piece rows (window_index rows T t)) (zero_bezier, zero_bezier))) s -
             unit * bezier_value (fst (nth i (window_piece rows (window_index rows T t)) (zero_bezier, zero_bezier))) s) with
      (unit * (IZR (-1) * bezier_value (fst (nth i (window_piece rows (window_index rows T t)) (zero_bezier, zero_bezier))) s +
       IZR 1 * bezier_value (snd (nth i (window_piece rows (window_index rows T t)) (zero_bezier, zero_bezier))) s)) by ring.
    apply Rmult_le_compat_l; lra.
  - replace (unit * bezier_value (snd (nth i (window_piece rows (window_index rows T t)) (zero_bezier, zero_bezier))) s -
             unit * bezier_value (fst (nth i (window_piece rows (window_index rows T t)) (zero_bezier, zero_bezier))) s) with
      (unit * (IZR (-1) * bezier_value (fst (nth i (window_piece rows (window_index rows T t)) (zero_bezier, zero_bezier))) s +
       IZR 1 * bezier_value (snd (nth i (window_piece rows (window_index rows T t)) (zero_bezier, zero_bezier))) s)) by ring.
    apply Rmult_le_compat_l; lra.
Qed.
