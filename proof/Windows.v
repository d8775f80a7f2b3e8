(* The edges window by window: a window is a segment, or the time from t_c on. Their least and largest distance in it, and their
   speed in it and in the one before. *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core.Raux.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed.
Import ListNotations.
Open Scope R_scope.

Definition least (c : bez) : Z := Z.min (Z.min (c0 c) (c1 c)) (Z.min (c2 c) (c3 c)).
Definition most_of (c : bez) : Z := Z.max (Z.max (c0 c) (c1 c)) (Z.max (c2 c) (c3 c)).
Definition steepest (c : bez) : Z := Z.max (Z.abs (c1 c - c0 c)) (Z.max (Z.abs (c2 c - c1 c)) (Z.abs (c3 c - c2 c))).

Lemma least_ok c s : 0 <= s <= 1 -> IZR (least c) <= bernstein c s.
Proof. intro H. apply hull; [|exact H]. unfold all_from, least. rewrite !andb_true_iff, !Z.leb_le. lia. Qed.
Lemma most_ok c s : 0 <= s <= 1 -> bernstein c s <= IZR (most_of c).
Proof.
  intro H. assert (A : IZR (- most_of c) <= bernstein (mix (-1) c 0 zero_bez) s).
  { apply hull; [|exact H]. unfold all_from, mix, zero_bez, most_of; cbn [c0 c1 c2 c3]. rewrite !andb_true_iff, !Z.leb_le. lia. }
  rewrite mix_ok, opp_IZR in A. lra.
Qed.
Lemma steepest_flat c : flat (steepest c) c = true.
Proof. unfold flat, steepest. rewrite !andb_true_iff, !Z.leb_le. lia. Qed.
Lemma steepest_pos c : (0 <= steepest c)%Z.
Proof. unfold steepest. eapply Z.le_trans; [apply Z.abs_nonneg|apply Z.le_max_l]. Qed.
Lemma flat_more V V' c : (V <= V')%Z -> flat V c = true -> flat V' c = true.
Proof. unfold flat. rewrite !andb_true_iff, !Z.leb_le. lia. Qed.

Section Windows.
  Variables (rows : table) (T unit : R) (n i : nat).
  Hypothesis Rg : regular n rows = true.
  Hypothesis Hi : (i < n)%nat.
  Hypothesis T_pos : 0 < T.
  Hypothesis unit_pos : 0 < unit.
  Let K := segments rows.

  Definition window (t : R) : nat := Nat.min (Z.to_nat (Zfloor (INR K / T * Rmax 0 t))) K.

  (* From t_c on the tube stands still: a last piece that is the end of the one before. *)
  Definition piece_at (k : nat) : piece := nth k (pieces rows ++ [both at_end (nth (K - 1) (pieces rows) [])]) [].
  Definition between_edges (k : nat) : bez := let c := nth i (piece_at k) (zero_bez, zero_bez) in mix (-1) (fst c) 1 (snd c).
  Definition steepest_at (k : nat) : Z :=
    let V j := let c := nth i (nth j (pieces rows) []) (zero_bez, zero_bez) in Z.max (steepest (fst c)) (steepest (snd c)) in
    Z.max (V (k - 1)%nat) (V k).

  Lemma K_pos' : (0 < K)%nat. Proof. destruct (regular_ok _ _ Rg); unfold K, segments; lia. Qed.
  Lemma rate_pos : 0 <= INR K / T. Proof. apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]. Qed.

  Lemma spline_time_min t : spline_time T rows t = Rmin (INR K / T * Rmax 0 t) (INR K).
  Proof.
    unfold spline_time, hold. fold K. assert (KT : INR K / T * T = INR K) by (field; lra). pose proof rate_pos as R0.
    unfold Rmin at 1. destruct (Rle_dec t T) as [tT|tT].
    - assert (INR K / T * Rmax 0 t <= INR K / T * T) by (apply Rmult_le_compat_l; [exact R0|unfold Rmax; destruct Rle_dec; lra]).
      rewrite Rmin_left by lra. reflexivity.
    - rewrite (Rmax_right 0 T), (Rmax_right 0 t) by lra.
      assert (INR K / T * T <= INR K / T * t) by (apply Rmult_le_compat_l; lra). rewrite Rmin_right by lra. lra.
  Qed.

  Lemma window_place t : (window t <= K)%nat /\ INR (window t) <= spline_time T rows t <= INR (window t) + 1 /\
    (window t = K -> spline_time T rows t = INR K).
  Proof.
    rewrite spline_time_min. unfold window. set (v := INR K / T * Rmax 0 t).
    assert (v0 : 0 <= v) by (apply Rmult_le_pos; [apply rate_pos|apply Rmax_l]).
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
  Lemma window_before s t : s <= t -> INR K / T * (t - s) <= 1 -> window s = window t \/ window s = (window t - 1)%nat.
  Proof.
    intros Hs Hd. pose proof rate_pos as R0. unfold window. set (a := INR K / T * Rmax 0 s). set (b := INR K / T * Rmax 0 t).
    assert (a0 : 0 <= a) by (apply Rmult_le_pos; [exact R0|apply Rmax_l]).
    assert (AB : a <= b).
    { apply Rmult_le_compat_l; [exact R0|]. unfold Rmax; repeat destruct Rle_dec; lra. }
    assert (BA : b <= a + 1).
    { assert (INR K / T * (Rmax 0 t - Rmax 0 s) <= INR K / T * (t - s)); [|unfold a, b; lra].
      apply Rmult_le_compat_l; [exact R0|]. unfold Rmax; repeat destruct Rle_dec; lra. }
    assert (F1 : (Zfloor a <= Zfloor b)%Z) by now apply Zfloor_le.
    assert (F2 : (Zfloor b < Zfloor a + 2)%Z).
    { apply lt_IZR. rewrite plus_IZR. pose proof (Zfloor_ub a). pose proof (Zfloor_lb b). lra. }
    assert (F0 : (0 <= Zfloor a)%Z) by (now apply Zfloor_lub). lia.
  Qed.

  Lemma piece_inside k : (k < K)%nat -> piece_at k = nth k (pieces rows) [].
  Proof. intro H. unfold piece_at. apply app_nth1. rewrite pieces_length. exact H. Qed.
  Lemma piece_last : piece_at K = both at_end (nth (K - 1) (pieces rows) []).
  Proof. unfold piece_at. rewrite app_nth2; rewrite pieces_length; [|unfold K; lia]. fold K. now rewrite Nat.sub_diag. Qed.

  Variables (side : Z * Z -> Z) (of : bez * bez -> bez).
  Hypothesis sides : (side = fst /\ of = fst) \/ (side = snd /\ of = snd).
  Let S (u : R) := spline (column side i rows) u.

  (* The edge in a window is a polynomial, also the last one. *)
  Lemma edge_window t : exists s, 0 <= s <= 1 /\
    (s = match Nat.eq_dec (window t) K with left _ => 1 | right _ => spline_time T rows t - INR (window t) end) /\
    S (spline_time T rows t) = bernstein (of (nth i (piece_at (window t)) (zero_bez, zero_bez))) s.
  Proof.
    destruct (window_place t) as (A & B & C).
    exists (match Nat.eq_dec (window t) K with left _ => 1 | right _ => spline_time T rows t - INR (window t) end).
    destruct (Nat.eq_dec (window t) K) as [E|E].
    - split; [lra|split; [reflexivity|]]. rewrite (C E), E, piece_last.
      assert (Ko : K = Datatypes.S (K - 1)) by (pose proof K_pos'; lia).
      assert (IK : INR K = INR (K - 1) + 1) by (rewrite Ko at 1; now rewrite S_INR).
      unfold S. rewrite (S_piece rows n i side of Rg Hi sides (K - 1)) by (fold K; pose proof K_pos'; lia || lra).
      replace (INR K - INR (K - 1)) with 1 by lra.
      assert (Nm : nth i (both at_end (nth (K - 1) (pieces rows) [])) (zero_bez, zero_bez) =
        (fun c => (at_end (fst c), at_end (snd c))) (nth i (nth (K - 1) (pieces rows) []) (zero_bez, zero_bez))).
      { unfold both. rewrite <- (map_nth (fun c : bez * bez => (at_end (fst c), at_end (snd c)))). reflexivity. }
      rewrite Nm. destruct sides as [[_ ->]|[_ ->]]; cbn [fst snd]; rewrite at_end_ok; ring.
    - split; [lra|split; [reflexivity|]]. rewrite piece_inside by lia.
      unfold S. apply (S_piece rows n i side of Rg Hi sides (window t)); [fold K; lia|exact B].
  Qed.

  Lemma flat_at k V : (k < K)%nat -> (steepest (of (nth i (nth k (pieces rows) []) (zero_bez, zero_bez))) <= V)%Z ->
    flat V (of (nth i (nth k (pieces rows) []) (zero_bez, zero_bez))) = true.
  Proof. intros _ H. now apply (flat_more (steepest (of (nth i (nth k (pieces rows) []) (zero_bez, zero_bez))))), steepest_flat. Qed.

  Lemma piece_moves k V u v : (k < K)%nat -> (steepest (of (nth i (nth k (pieces rows) []) (zero_bez, zero_bez))) <= V)%Z ->
    INR k <= u <= v -> v <= INR k + 1 -> Rabs (S v - S u) <= 3 * IZR V * (v - u).
  Proof.
    intros Hk HV Hu Hv. unfold S. rewrite !(S_piece rows n i side of Rg Hi sides k) by (fold K; lia || lra).
    replace (v - u) with (Rabs ((v - INR k) - (u - INR k))) by (rewrite Rabs_pos_eq; lra).
    apply flat_ok; [now apply flat_at|lra|lra].
  Qed.

  Lemma steepest_side k : (steepest (of (nth i (nth k (pieces rows) []) (zero_bez, zero_bez))) <=
    Z.max (steepest (fst (nth i (nth k (pieces rows) []) (zero_bez, zero_bez)))) (steepest (snd (nth i (nth k (pieces rows) []) (zero_bez, zero_bez)))))%Z.
  Proof. destruct sides as [[_ ->]|[_ ->]]; lia. Qed.

  Lemma steepest_nonneg k : 0 <= IZR (steepest_at k).
  Proof. apply IZR_le. unfold steepest_at. eapply Z.le_trans; [|apply Z.le_max_r]. eapply Z.le_trans; [|apply Z.le_max_l]. apply steepest_pos. Qed.

  Definition speed_at (k : nat) : R := unit * (3 * IZR (steepest_at k)) * (INR K / T).
  Lemma speed_at_nonneg k : 0 <= speed_at k.
  Proof. unfold speed_at. apply Rmult_le_pos; [|apply rate_pos]. apply Rmult_le_pos; [lra|]. pose proof (steepest_nonneg k). lra. Qed.

  Lemma edge_moves s t : s <= t -> INR K / T * (t - s) <= 1 ->
    Rabs (edge unit T rows side i t - edge unit T rows side i s) <= speed_at (window t) * (t - s).
  Proof.
    intros Hs Hd. unfold edge. fold (spline_time T rows s) (spline_time T rows t). fold (S (spline_time T rows s)) (S (spline_time T rows t)).
    destruct (window_place t) as (A & B & C). destruct (window_place s) as (A' & B' & C').
    pose proof rate_pos as R0.
    assert (St : 0 <= spline_time T rows t - spline_time T rows s <= INR K / T * (t - s)).
    { destruct (hold_lip T s t Hs) as [Hh|]; [|lra]. unfold spline_time. fold K.
      assert (0 <= INR K / T * (hold T t - hold T s)) by (apply Rmult_le_pos; lra).
      assert (INR K / T * (hold T t - hold T s) <= INR K / T * (t - s)) by (apply Rmult_le_compat_l; lra). lra. }
    set (k := window t) in *. set (V := steepest_at k).
    assert (V0 := steepest_nonneg k). fold V in V0.
    assert (Vk : forall j, j = k \/ j = (k - 1)%nat -> (steepest (of (nth i (nth j (pieces rows) []) (zero_bez, zero_bez))) <= V)%Z).
    { intros j Hj. eapply Z.le_trans; [apply steepest_side|]. unfold V, steepest_at. destruct Hj as [->| ->]; [apply Z.le_max_r|apply Z.le_max_l]. }
    assert (Mv : Rabs (S (spline_time T rows t) - S (spline_time T rows s)) <= 3 * IZR V * (spline_time T rows t - spline_time T rows s)).
    { destruct (window_before s t Hs Hd) as [E|E]; fold k in E.
      - rewrite E in *. destruct (Nat.eq_dec k K) as [Q|Q].
        + rewrite (C Q), (C' Q), !Rminus_diag_eq, Rabs_R0 by reflexivity. lra.
        + apply (piece_moves k); [lia|apply Vk; now left|lra|lra].
      - destruct (Nat.eq_dec k 0) as [Z0|Z0].
        { rewrite E, Z0 in *. cbn in B, B'. pose proof K_pos'. apply (piece_moves 0%nat); [lia|apply Vk; left; lia|cbn; lra|cbn; lra]. }
        assert (IK : INR k = INR (k - 1) + 1) by (rewrite <- S_INR; f_equal; lia). rewrite E in B'.
        replace (S (spline_time T rows t) - S (spline_time T rows s)) with
          ((S (spline_time T rows t) - S (INR k)) + (S (INR k) - S (spline_time T rows s))) by ring.
        eapply Rle_trans; [apply Rabs_triang|].
        assert (A1 : Rabs (S (spline_time T rows t) - S (INR k)) <= 3 * IZR V * (spline_time T rows t - INR k)).
        { destruct (Nat.eq_dec k K) as [Q|Q].
          - rewrite (C Q), <- Q, !Rminus_diag_eq, Rabs_R0 by reflexivity. lra.
          - apply (piece_moves k); [lia|apply Vk; now left|lra|lra]. }
        assert (A2 : Rabs (S (INR k) - S (spline_time T rows s)) <= 3 * IZR V * (INR k - spline_time T rows s)).
        { apply (piece_moves (k - 1)); [lia|apply Vk; now right|lra|lra]. }
        lra. }
    rewrite <- Rmult_minus_distr_l, Rabs_mult, (Rabs_pos_eq unit) by lra. unfold speed_at. fold V. fold k. fold V.
    replace (unit * (3 * IZR V) * (INR K / T) * (t - s)) with (unit * (3 * IZR V * (INR K / T * (t - s)))) by ring.
    apply Rmult_le_compat_l; [lra|]. eapply Rle_trans; [exact Mv|]. apply Rmult_le_compat_l; lra.
  Qed.
End Windows.

(* The width in a window. *)
Lemma width_in_window rows T unit n i t : regular n rows = true -> (i < n)%nat -> 0 < T -> 0 < unit ->
  unit * IZR (least (between_edges rows i (window rows T t))) <= edge unit T rows snd i t - edge unit T rows fst i t <=
  unit * IZR (most_of (between_edges rows i (window rows T t))).
Proof.
  intros Rg Hi HT Hu. unfold edge. fold (spline_time T rows t).
  destruct (edge_window rows T n i Rg Hi HT fst fst (or_introl (conj eq_refl eq_refl)) t) as (s & Hs & Es & L).
  destruct (edge_window rows T n i Rg Hi HT snd snd (or_intror (conj eq_refl eq_refl)) t) as (s' & _ & Es' & U).
  rewrite <- Es in Es'. subst s'. rewrite L, U.
  assert (A := least_ok (between_edges rows i (window rows T t)) s Hs). assert (B := most_ok (between_edges rows i (window rows T t)) s Hs).
  unfold between_edges in A, B at 1. rewrite mix_ok in A. cbv zeta in A.
  unfold between_edges in B. rewrite mix_ok in B. cbv zeta in B. unfold between_edges.
  split.
  - replace (unit * bernstein (snd (nth i (piece_at rows (window rows T t)) (zero_bez, zero_bez))) s -
             unit * bernstein (fst (nth i (piece_at rows (window rows T t)) (zero_bez, zero_bez))) s) with
      (unit * (IZR (-1) * bernstein (fst (nth i (piece_at rows (window rows T t)) (zero_bez, zero_bez))) s +
       IZR 1 * bernstein (snd (nth i (piece_at rows (window rows T t)) (zero_bez, zero_bez))) s)) by ring.
    apply Rmult_le_compat_l; lra.
  - replace (unit * bernstein (snd (nth i (piece_at rows (window rows T t)) (zero_bez, zero_bez))) s -
             unit * bernstein (fst (nth i (piece_at rows (window rows T t)) (zero_bez, zero_bez))) s) with
      (unit * (IZR (-1) * bernstein (fst (nth i (piece_at rows (window rows T t)) (zero_bez, zero_bez))) s +
       IZR 1 * bernstein (snd (nth i (piece_at rows (window rows T t)) (zero_bez, zero_bez))) s)) by ring.
    apply Rmult_le_compat_l; lra.
Qed.
