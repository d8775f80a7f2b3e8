(* A refined tube: edges that are uniform cubic B-splines with a table of integer control points, a check `tube_check` that computes with
   integers, and the theorem `tube_sound`: where the check says true, properties P1 to P5 hold at every time.

   A requirement is a disjunction of lower bounds on weighted sums of edges. On a segment of the spline such a sum is at least its
   smallest Bezier coefficient. Where that proves too little, the segment is halved, and each half may satisfy another part of the
   disjunction: an obstacle may be passed below in one half and above in the next. Separating normals come from outside and are only
   tried, never believed.

   Speed.v, Emitted.v, Windows.v and all later files build on it. The lemma book has the mathematics as `refined.*` and `rows.*`
   (docs/lemmas.md), docs/certificate.md the properties. *)
From Coq Require Import ZArith QArith Qreals Qround Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core.Raux.
From Coquelicot Require Import Coquelicot.
From Stt Require Export Sets.
Import ListNotations.
Open Scope R_scope.

(* ------------------------------------------------------------------ the edge, as the emitted code computes it *)

(* A cubic B-spline on one segment, at s in [0, 1]. The control points q are already divided by 6. *)
Definition cubic_blend (q0 q1 q2 q3 : Z) (s : R) : R :=
  IZR q0 * (1 - s)^3 + IZR q1 * (3*s^3 - 6*s^2 + 4) + IZR q2 * (- 3*s^3 + 3*s^2 + 3*s + 1) + IZR q3 * s^3.

(* The segment of a spline time when there are `count` segments: its floor, limited to 0 .. count - 1. *)
Definition segment_index (count : nat) (spline_time : R) : nat := Nat.min (Z.to_nat (Zfloor spline_time)) (count - 1).

(* The spline with control points q, at spline time u: segment k begins at u = k. *)
Definition spline (q : list Z) (u : R) : R :=
  let k := segment_index (length q - 3) u in
  cubic_blend (nth k q 0%Z) (nth (k+1) q 0%Z) (nth (k+2) q 0%Z) (nth (k+3) q 0%Z) (u - INR k).

(* A table of control points: one row for each, with a pair (lower, upper) for each dimension, in units. *)
Definition table := list (list (Z * Z)).
(* The control points of an edge: `side` is fst for the lower edge, snd for the upper one; i is the dimension. *)
Definition edge_column (side : Z * Z -> Z) (i : nat) (rows : table) : list Z := map (fun r => side (nth i r (0, 0)%Z)) rows.
Definition segment_count (rows : table) : nat := length rows - 3.
(* Time t, limited to [0, t_c]. *)
Definition clamped_time (t_c t : R) : R := Rmax 0 (Rmin t t_c).

(* An edge as a function of time. Before 0 it has its value at 0, from t_c on its value at t_c. *)
Definition edge (unit t_c : R) (rows : table) (side : Z * Z -> Z) (i : nat) (t : R) : R :=
  unit * spline (edge_column side i rows) (INR (segment_count rows) / t_c * clamped_time t_c t).

(* ------------------------------------------------------------------ Bezier coefficients *)

(* A cubic polynomial on [0, 1] by its four Bezier coefficients. *)
Record bezier := Bezier { c0 : Z; c1 : Z; c2 : Z; c3 : Z }.

(* The value of such a polynomial at s. *)
Definition bezier_value (c : bezier) (s : R) : R :=
  IZR (c0 c) * (1-s)^3 + 3 * IZR (c1 c) * (1-s)^2 * s + 3 * IZR (c2 c) * (1-s) * s^2 + IZR (c3 c) * s^3.

(* The Bezier coefficients of one segment, from its four control points. *)
Definition bezier_of_spline (q0 q1 q2 q3 : Z) : bezier :=
  Bezier (q0 + 4*q1 + q2) (4*q1 + 2*q2) (2*q1 + 4*q2) (q1 + 4*q2 + q3).

Ltac izr := repeat (rewrite plus_IZR || rewrite minus_IZR || rewrite mult_IZR || rewrite opp_IZR).

Lemma cubic_blend_is_bezier q0 q1 q2 q3 s : cubic_blend q0 q1 q2 q3 s = bezier_value (bezier_of_spline q0 q1 q2 q3) s.
Proof. unfold cubic_blend, bezier_value, bezier_of_spline; cbn [c0 c1 c2 c3]; izr; ring. Qed.

(* The polynomial on the first half of its interval, times 8 so that coefficients stay integers (de Casteljau). Each halving multiplies a
   bound by 8. *)
Definition first_half (c : bezier) : bezier :=
  Bezier (8 * c0 c) (4 * (c0 c + c1 c)) (2 * (c0 c + 2 * c1 c + c2 c)) (c0 c + 3 * c1 c + 3 * c2 c + c3 c).
Definition second_half (c : bezier) : bezier :=
  Bezier (c0 c + 3 * c1 c + 3 * c2 c + c3 c) (2 * (c1 c + 2 * c2 c + c3 c)) (4 * (c2 c + c3 c)) (8 * c3 c).

Lemma first_half_value c s : bezier_value (first_half c) s = 8 * bezier_value c (s / 2).
Proof. unfold bezier_value, first_half; cbn [c0 c1 c2 c3]; izr; field. Qed.
Lemma second_half_value c s : bezier_value (second_half c) s = 8 * bezier_value c ((1 + s) / 2).
Proof. unfold bezier_value, second_half; cbn [c0 c1 c2 c3]; izr; field. Qed.

(* The polynomial a c + b d. *)
Definition bezier_combination (a : Z) (c : bezier) (b : Z) (d : bezier) : bezier :=
  Bezier (a * c0 c + b * c0 d) (a * c1 c + b * c1 d) (a * c2 c + b * c2 d) (a * c3 c + b * c3 d).
Lemma bezier_combination_value a c b d s : bezier_value (bezier_combination a c b d) s = IZR a * bezier_value c s + IZR b * bezier_value d s.
Proof. unfold bezier_value, bezier_combination; cbn [c0 c1 c2 c3]; izr; ring. Qed.

(* All coefficients are at least z. *)
Definition coefficients_at_least (z : Z) (c : bezier) : bool := ((z <=? c0 c) && (z <=? c1 c) && (z <=? c2 c) && (z <=? c3 c))%Z.

(* Then so is every value on [0, 1]: the polynomial lies in the convex hull of its coefficients. *)
Lemma bezier_value_at_least z c s : coefficients_at_least z c = true -> 0 <= s <= 1 -> IZR z <= bezier_value c s.
Proof.
  unfold coefficients_at_least, bezier_value; rewrite !andb_true_iff, !Z.leb_le; intros [[[A B] C] D] [E F].
  apply IZR_le in A, B, C, D.
  assert (G : 0 <= 1 - s) by lra.
  assert (0 <= (1-s)^3) by (apply pow_le; lra). assert (0 <= s^3) by (apply pow_le; lra).
  assert (0 <= (1-s)^2 * s) by (apply Rmult_le_pos; [apply pow_le|]; lra).
  assert (0 <= (1-s) * s^2) by (apply Rmult_le_pos; [|apply pow_le]; lra).
  replace (IZR z) with (IZR z * (1-s)^3 + 3 * (IZR z * ((1-s)^2 * s)) + 3 * (IZR z * ((1-s) * s^2)) + IZR z * s^3) by ring.
  assert (IZR z * (1-s)^3 <= IZR (c0 c) * (1-s)^3) by (apply Rmult_le_compat_r; auto).
  assert (IZR z * ((1-s)^2*s) <= IZR (c1 c) * ((1-s)^2*s)) by (apply Rmult_le_compat_r; auto).
  assert (IZR z * ((1-s)*s^2) <= IZR (c2 c) * ((1-s)*s^2)) by (apply Rmult_le_compat_r; auto).
  assert (IZR z * s^3 <= IZR (c3 c) * s^3) by (apply Rmult_le_compat_r; auto).
  lra.
Qed.

(* ------------------------------------------------------------------ requirements and the checker *)

(* The edges on one segment: by dimension the polynomials of the lower and of the upper edge. *)
Definition piece := list (bezier * bezier).
Definition zero_bezier := Bezier 0 0 0 0.

(* lower_weight times the lower edge plus upper_weight times the upper edge, of one dimension. *)
Record term := Term { axis : nat; lower_weight : Z; upper_weight : Z }.
(* The sum of the terms is at least `bound`, in units of the table. *)
Record edge_inequality := EdgeInequality { terms : list term; bound : Z }.
(* An inequality with one term. *)
Definition single_axis_inequality (i : nat) (l u v : Z) : edge_inequality := EdgeInequality [Term i l u] v.
(* A disjunction: at every time one of the inequalities must hold. Which one may differ from half to half of a segment. *)
Definition requirement := list edge_inequality.

(* The polynomial of a term on a piece. *)
Definition term_bezier (e : term) (p : piece) : bezier :=
  let c := nth (axis e) p (zero_bezier, zero_bezier) in bezier_combination (lower_weight e) (fst c) (upper_weight e) (snd c).
Fixpoint terms_bezier (es : list term) (p : piece) : bezier :=
  match es with [] => zero_bezier | [e] => term_bezier e p | e :: es => bezier_combination 1 (term_bezier e p) 1 (terms_bezier es p) end.
Definition inequality_bezier (a : edge_inequality) (p : piece) : bezier := terms_bezier (terms a) p.
(* One of the inequalities follows from the coefficients of its polynomial. `scale` is 8 for each halving so far. *)
Definition follows_from_coefficients (scale : Z) (p : piece) (requirement : requirement) : bool :=
  existsb (fun a => coefficients_at_least (scale * bound a) (inequality_bezier a p)) requirement.

(* A piece with both its edges changed by f. *)
Definition map_edges (f : bezier -> bezier) (p : piece) : piece := map (fun c => (f (fst c), f (snd c))) p.

(* All requirements hold on a piece: by coefficients, or on both halves; it is halved at most `depth` times. *)
Fixpoint check_piece (depth : nat) (scale : Z) (p : piece) (requirements : list requirement) : bool :=
  match filter (fun r => negb (follows_from_coefficients scale p r)) requirements with
  | [] => true
  | unproved => match depth with
           | O => false
           | S d => if check_piece d (8 * scale) (map_edges first_half p) unproved then check_piece d (8 * scale) (map_edges second_half p) unproved else false (* no &&: the second half costs nothing where the first fails *)
           end
  end.

Definition term_value (e : term) (p : piece) (s : R) : R :=
  let c := nth (axis e) p (zero_bezier, zero_bezier) in IZR (lower_weight e) * bezier_value (fst c) s + IZR (upper_weight e) * bezier_value (snd c) s.
(* The sum of the terms of an inequality, at s on a piece. *)
Definition terms_value (a : edge_inequality) (p : piece) (s : R) : R := fold_right (fun e v => term_value e p s + v) 0 (terms a).

Lemma inequality_bezier_value a p s : bezier_value (inequality_bezier a p) s = terms_value a p s.
Proof.
  assert (T : forall e, bezier_value (term_bezier e p) s = term_value e p s) by (intro; unfold term_bezier, term_value; now rewrite bezier_combination_value).
  unfold inequality_bezier, terms_value. induction (terms a) as [|e [|d es] IH]; cbn [terms_bezier fold_right] in *.
  - unfold bezier_value, zero_bezier; cbn [c0 c1 c2 c3]; ring.
  - rewrite T; ring.
  - rewrite bezier_combination_value, T, IH; ring.
Qed.

Lemma terms_value_map_edges f k h a p s : f zero_bezier = zero_bezier -> (forall c, bezier_value (f c) s = k * bezier_value c h) ->
  terms_value a (map_edges f p) s = k * terms_value a p h.
Proof.
  intros Z0 H; unfold terms_value. induction (terms a) as [|e es IH]; cbn [fold_right]; [ring|rewrite IH].
  unfold term_value, map_edges.
  set (g := fun c : bezier * bezier => (f (fst c), f (snd c))).
  replace (zero_bezier, zero_bezier) with (g (zero_bezier, zero_bezier)) at 1 2 by (unfold g; cbn; now rewrite Z0).
  rewrite !map_nth; unfold g; cbn [fst snd]; rewrite !H; ring.
Qed.

Lemma follows_from_coefficients_sound scale p r s : follows_from_coefficients scale p r = true -> 0 <= s <= 1 ->
  exists a, In a r /\ IZR scale * IZR (bound a) <= terms_value a p s.
Proof.
  unfold follows_from_coefficients; rewrite existsb_exists; intros (a & I & H) S; exists a; split; [exact I|].
  apply bezier_value_at_least with (s := s) in H; [|exact S].
  rewrite inequality_bezier_value, mult_IZR in H; exact H.
Qed.

(* Where `check_piece` says true, one inequality of every requirement holds at every s. *)
Lemma check_piece_sound depth : forall scale p rs, check_piece depth scale p rs = true ->
  forall s, 0 <= s <= 1 -> forall r, In r rs -> exists a, In a r /\ IZR scale * IZR (bound a) <= terms_value a p s.
Proof.
  induction depth; intros scale p rs H s S r I; cbn [check_piece] in H;
  destruct (follows_from_coefficients scale p r) eqn:Sh; try (now apply follows_from_coefficients_sound); 
  assert (B : In r (filter (fun r => negb (follows_from_coefficients scale p r)) rs)) by (apply filter_In; now rewrite Sh);
  destruct (filter _ rs) as [|b bs]; try easy.
  destruct (check_piece depth (8 * scale) (map_edges first_half p) (b :: bs)) eqn:E; [|easy]. rename H into L.
  destruct (Rle_dec s (1/2)) as [Q|Q].
  - destruct (IHdepth _ _ _ E (2 * s) ltac:(lra) r B) as (a & Ia & V); exists a; split; [exact Ia|].
    rewrite (terms_value_map_edges first_half 8 s) in V; [rewrite mult_IZR in V; lra|easy|].
    intro c; rewrite first_half_value; do 2 f_equal; field.
  - destruct (IHdepth _ _ _ L (2 * s - 1) ltac:(lra) r B) as (a & Ia & V); exists a; split; [exact Ia|].
    rewrite (terms_value_map_edges second_half 8 s) in V; [rewrite mult_IZR in V; lra|easy|].
    intro c; rewrite second_half_value; do 2 f_equal; field.
Qed.

(* The piece of four consecutive rows of the table. *)
Fixpoint piece_of_rows (r0 r1 r2 r3 : list (Z * Z)) : piece :=
  match r0, r1, r2, r3 with
  | (a0, b0) :: r0, (a1, b1) :: r1, (a2, b2) :: r2, (a3, b3) :: r3 =>
      (bezier_of_spline a0 a1 a2 a3, bezier_of_spline b0 b1 b2 b3) :: piece_of_rows r0 r1 r2 r3
  | _, _, _, _ => []
  end.

(* The pieces of all segments. *)
Fixpoint pieces (rows : table) : list piece :=
  match rows with
  | r0 :: ((r1 :: r2 :: r3 :: _) as rest) => piece_of_rows r0 r1 r2 r3 :: pieces rest
  | _ => []
  end.

Lemma piece_of_rows_nth n : forall r0 r1 r2 r3 i, length r0 = n -> length r1 = n -> length r2 = n -> length r3 = n -> (i < n)%nat ->
  nth i (piece_of_rows r0 r1 r2 r3) (zero_bezier, zero_bezier) =
  (bezier_of_spline (fst (nth i r0 (0,0)%Z)) (fst (nth i r1 (0,0)%Z)) (fst (nth i r2 (0,0)%Z)) (fst (nth i r3 (0,0)%Z)),
   bezier_of_spline (snd (nth i r0 (0,0)%Z)) (snd (nth i r1 (0,0)%Z)) (snd (nth i r2 (0,0)%Z)) (snd (nth i r3 (0,0)%Z))).
Proof.
  induction n; intros [|[]r0] [|[]r1] [|[]r2] [|[]r3] i; cbn [length]; intros; try lia.
  destruct i; cbn; [reflexivity|apply IHn; lia].
Qed.

Lemma pieces_length rows : length (pieces rows) = segment_count rows.
Proof.
  unfold segment_count; induction rows as [|r0 [|r1 [|r2 [|r3 rest]]] IH]; try reflexivity.
  cbn [pieces length] in *; rewrite IH; lia.
Qed.

Lemma pieces_nth : forall k rows, (k < segment_count rows)%nat ->
  nth k (pieces rows) [] = piece_of_rows (nth k rows []) (nth (k+1) rows []) (nth (k+2) rows []) (nth (k+3) rows []).
Proof.
  unfold segment_count; induction k; intros [|r0 [|r1 [|r2 [|r3 rest]]]] H; cbn [length] in H; try lia; [reflexivity|].
  change (nth (S k) (pieces (r0 :: r1 :: r2 :: r3 :: rest)) []) with (nth k (pieces (r1 :: r2 :: r3 :: rest)) []).
  rewrite IHk by (cbn [length]; lia); reflexivity.
Qed.

(* ------------------------------------------------------------------ from a piece to the edges *)

(* Every row has n pairs, and there are at least four rows. *)
Definition is_regular (n : nat) (rows : table) : bool := forallb (fun r => Nat.eqb (length r) n) rows && (4 <=? length rows)%nat.

Lemma is_regular_lengths n rows : is_regular n rows = true ->
  (4 <= length rows)%nat /\ forall k, (k < length rows)%nat -> length (nth k rows []) = n.
Proof.
  unfold is_regular; rewrite andb_true_iff, forallb_forall, Nat.leb_le; intros [A B]; split; [exact B|].
  intros k H; apply Nat.eqb_eq, A, nth_In, H.
Qed.

Lemma edge_column_nth side i rows k : side (0,0)%Z = 0%Z -> nth k (edge_column side i rows) 0%Z = side (nth i (nth k rows []) (0,0)%Z).
Proof.
  intro S; unfold edge_column. set (f := fun r => side (nth i r (0,0)%Z)).
  change (side (nth i (nth k rows []) (0,0)%Z)) with (f (nth k rows [])).
  rewrite <- (map_nth f rows [] k). replace (f []) with 0%Z; [reflexivity|].
  unfold f; destruct i; symmetry; exact S.
Qed.

(* The spline time is within its segment. *)
Lemma segment_index_range K u : (0 < K)%nat -> 0 <= u <= INR K -> (segment_index K u < K)%nat /\ 0 <= u - INR (segment_index K u) <= 1.
Proof.
  intros HK [U0 U1]; unfold segment_index; split; [lia|].
  assert (F0 : (0 <= Zfloor u)%Z) by (now apply Zfloor_lub).
  pose proof (Zfloor_lb u) as Lb. pose proof (Zfloor_ub u) as Ub.
  assert (E : INR (Z.to_nat (Zfloor u)) = IZR (Zfloor u)) by (now rewrite INR_IZR_INZ, Z2Nat.id).
  destruct (Nat.min_spec (Z.to_nat (Zfloor u)) (K - 1)) as [[C ->]|[C ->]].
  - rewrite E; lra.
  - apply le_INR in C; rewrite E in C.
    assert (INR (K - 1) = INR K - 1) by (rewrite minus_INR by lia; cbn; lra). lra.
Qed.

(* The time in segments: 0 at t = 0 and before, the number of segments from t_c on. *)
Definition spline_time (t_c : R) (rows : table) (t : R) : R := INR (segment_count rows) / t_c * clamped_time t_c t.

Lemma clamped_time_range t_c t : 0 < t_c -> 0 <= clamped_time t_c t <= t_c.
Proof. unfold clamped_time, Rmax, Rmin; intros; repeat destruct Rle_dec; lra. Qed.
Lemma clamped_time_within t_c t : 0 <= t <= t_c -> clamped_time t_c t = t.
Proof. unfold clamped_time, Rmax, Rmin; intros; repeat destruct Rle_dec; lra. Qed.

Lemma spline_time_range t_c rows t : 0 < t_c -> 0 <= spline_time t_c rows t <= INR (segment_count rows).
Proof.
  intros HT; unfold spline_time; destruct (clamped_time_range t_c t HT) as [A B]; pose proof (pos_INR (segment_count rows)) as P.
  assert (0 <= INR (segment_count rows) / t_c) by (apply Rmult_le_pos; [|left; apply Rinv_0_lt_compat]; lra).
  split; [apply Rmult_le_pos; lra|].
  apply Rle_trans with (INR (segment_count rows) / t_c * t_c); [now apply Rmult_le_compat_l|].
  right; field; lra.
Qed.

(* The sum of the terms of an inequality, for any functions `low` and `up` of the dimension. *)
Definition weighted_edges (low up : nat -> R) (a : edge_inequality) : R :=
  fold_right (fun e v => IZR (lower_weight e) * low (axis e) + IZR (upper_weight e) * up (axis e) + v) 0 (terms a).

(* At time t that sum, of the edges, is the value of the inequality's polynomial on the piece of t. *)
Lemma weighted_edges_on_piece n unit t_c rows a t : is_regular n rows = true -> 0 < t_c -> (forall e, In e (terms a) -> (axis e < n)%nat) ->
  let k := segment_index (segment_count rows) (spline_time t_c rows t) in
  weighted_edges (fun i => edge unit t_c rows fst i t) (fun i => edge unit t_c rows snd i t) a =
  unit * terms_value a (nth k (pieces rows) []) (spline_time t_c rows t - INR k).
Proof.
  intros Rg HT Hd k. unfold weighted_edges, terms_value.
  induction (terms a) as [|e es IH]; cbn [fold_right]; [ring|]. rewrite IH by (intros; apply Hd; now right). rewrite Rmult_plus_distr_l. f_equal.
  specialize (Hd e (or_introl eq_refl)). clear IH.
  destruct (is_regular_lengths _ _ Rg) as [L4 Ln].
  destruct (segment_index_range (segment_count rows) (spline_time t_c rows t)) as [Hk _];
    [unfold segment_count; lia|now apply spline_time_range|]. fold k in Hk.
  assert (K3 : (k + 3 < length rows)%nat) by (unfold segment_count in Hk; lia).
  unfold edge, spline, term_value; fold (spline_time t_c rows t).
  assert (LC : forall side, (length (edge_column side (axis e) rows) - 3)%nat = segment_count rows)
    by (intro; unfold edge_column, segment_count; now rewrite map_length).
  rewrite !LC; fold k.
  rewrite !edge_column_nth by reflexivity. rewrite !cubic_blend_is_bezier.
  rewrite pieces_nth by exact Hk.
  rewrite (piece_of_rows_nth n) by (try apply Ln; lia). cbn [fst snd]. ring.
Qed.

(* Requirements that `check_piece` accepts on every piece hold for the edges at every time. *)
Lemma check_table_sound n depth unit t_c rows rs : is_regular n rows = true -> 0 < unit -> 0 < t_c ->
  (forall r a e, In r rs -> In a r -> In e (terms a) -> (axis e < n)%nat) ->
  forallb (fun p => check_piece depth 1 p rs) (pieces rows) = true ->
  forall t r, In r rs -> exists a, In a r /\
    unit * IZR (bound a) <= weighted_edges (fun i => edge unit t_c rows fst i t) (fun i => edge unit t_c rows snd i t) a.
Proof.
  intros Rg Hu HT Hd C t r I.
  destruct (is_regular_lengths _ _ Rg) as [L4 _].
  destruct (segment_index_range (segment_count rows) (spline_time t_c rows t)) as [Hk Hs];
    [unfold segment_count; lia|now apply spline_time_range|].
  set (k := segment_index (segment_count rows) (spline_time t_c rows t)) in *.
  rewrite forallb_forall in C.
  assert (Ck := C (nth k (pieces rows) []) ltac:(apply nth_In; now rewrite pieces_length)).
  destruct (check_piece_sound _ _ _ _ Ck _ Hs r I) as (a & Ia & V).
  exists a; split; [exact Ia|].
  rewrite (weighted_edges_on_piece n) by eauto. fold k.
  apply Rmult_le_compat_l; [lra|]. lra.
Qed.

(* The constant polynomial with the value at s = 0; `constant_at_end` has that at s = 1. So requirements are checked at 0 and from t_c on
   alone (P2, P5). *)
Definition constant_at_start (c : bezier) := Bezier (c0 c) (c0 c) (c0 c) (c0 c).
Definition constant_at_end (c : bezier) := Bezier (c3 c) (c3 c) (c3 c) (c3 c).
Lemma constant_at_start_value c s : bezier_value (constant_at_start c) s = 1 * bezier_value c 0.
Proof. unfold bezier_value, constant_at_start; cbn [c0 c1 c2 c3]; ring. Qed.
Lemma constant_at_end_value c s : bezier_value (constant_at_end c) s = 1 * bezier_value c 1.
Proof. unfold bezier_value, constant_at_end; cbn [c0 c1 c2 c3]; ring. Qed.

Lemma check_start_sound n unit t_c rows rs : is_regular n rows = true -> 0 < unit -> 0 < t_c ->
  (forall r a e, In r rs -> In a r -> In e (terms a) -> (axis e < n)%nat) ->
  check_piece 0 1 (map_edges constant_at_start (nth 0 (pieces rows) [])) rs = true ->
  forall r, In r rs -> exists a, In a r /\
    unit * IZR (bound a) <= weighted_edges (fun i => edge unit t_c rows fst i 0) (fun i => edge unit t_c rows snd i 0) a.
Proof.
  intros Rg Hu HT Hd C r I. destruct (is_regular_lengths _ _ Rg) as [L4 _].
  destruct (check_piece_sound _ _ _ _ C 0 ltac:(lra) r I) as (a & Ia & V). exists a; split; [exact Ia|].
  rewrite (terms_value_map_edges constant_at_start 1 0) in V by (try easy; intro; apply constant_at_start_value).
  rewrite (weighted_edges_on_piece n) by eauto.
  assert (U : spline_time t_c rows 0 = 0) by (unfold spline_time; rewrite clamped_time_within by lra; ring).
  assert (S : segment_index (segment_count rows) 0 = 0%nat).
  { unfold segment_index; replace (Zfloor 0) with 0%Z by (symmetry; apply Zfloor_imp; simpl; lra); reflexivity. }
  rewrite U, S; cbn [INR]; rewrite Rminus_0_r. apply Rmult_le_compat_l; lra.
Qed.

Lemma check_end_sound n unit t_c rows rs : is_regular n rows = true -> 0 < unit -> 0 < t_c ->
  (forall r a e, In r rs -> In a r -> In e (terms a) -> (axis e < n)%nat) ->
  check_piece 0 1 (map_edges constant_at_end (nth (segment_count rows - 1) (pieces rows) [])) rs = true ->
  forall t, t_c <= t -> forall r, In r rs -> exists a, In a r /\
    unit * IZR (bound a) <= weighted_edges (fun i => edge unit t_c rows fst i t) (fun i => edge unit t_c rows snd i t) a.
Proof.
  intros Rg Hu HT Hd C t Ht r I. destruct (is_regular_lengths _ _ Rg) as [L4 _].
  destruct (check_piece_sound _ _ _ _ C 0 ltac:(lra) r I) as (a & Ia & V). exists a; split; [exact Ia|].
  rewrite (terms_value_map_edges constant_at_end 1 1) in V by (try easy; intro; apply constant_at_end_value).
  rewrite (weighted_edges_on_piece n) by eauto.
  assert (U : spline_time t_c rows t = INR (segment_count rows)).
  { unfold spline_time, clamped_time. rewrite Rmin_right, Rmax_right by lra. field; lra. }
  assert (S : segment_index (segment_count rows) (INR (segment_count rows)) = (segment_count rows - 1)%nat).
  { unfold segment_index; rewrite INR_IZR_INZ, Zfloor_IZR, Nat2Z.id; lia. }
  rewrite U, S.
  replace (INR (segment_count rows) - INR (segment_count rows - 1)) with 1; [apply Rmult_le_compat_l; lra|].
  rewrite minus_INR by (unfold segment_count; lia); cbn; lra.
Qed.

(* ------------------------------------------------------------------ the task, and what P1 to P5 ask of the table *)

(* A task: n dimensions, the prescribed time t_c, the initial state, sets, the clearance from every unsafe set and the smallest width of
   a tube. Half-spaces cut the state space and the target set. Sets are already grown, and the state space shrunk, by the robot's body. *)
Record task := Task {
  n : nat; t_c : Q; initial_state : list Q; state_space : box; initial_set : box; target_set : box; unsafe_sets : list shape; clearance : Q; min_width : Q;
  state_half_spaces : list (list Q * Q); target_half_spaces : list (list Q * Q) }.

(* State x is strictly inside the state space. *)
Definition in_space (spec : task) (x : nat -> R) : Prop :=
  (forall i, (i < n spec)%nat -> real_at (lower_corner (state_space spec)) i < x i < real_at (upper_corner (state_space spec)) i) /\ within_half_spaces (n spec) (state_half_spaces spec) x.
(* State x is strictly inside the target set. *)
Definition in_target (spec : task) (x : nat -> R) : Prop :=
  (forall i, (i < n spec)%nat -> real_at (lower_corner (target_set spec)) i < x i < real_at (upper_corner (target_set spec)) i) /\ within_half_spaces (n spec) (target_half_spaces spec) x.

(* A normal that may separate the tube from an unsafe set, and a multiplier for each half-space of the set. *)
Definition normal_with_multipliers : Type := list Z * list Q.
(* How `tube_check` searches; nothing in it is believed. It has the number of times that a segment may be halved, and for every unsafe
   set normals that are tried besides those of the axes. *)
Record search_plan := SearchPlan { halvings_max : nat; normals : list (list normal_with_multipliers) }.

(* The terms of the corner of the box [L, U] that comes first along a normal: L_j where the entry is positive, U_j where it is negative. *)
Fixpoint facing_corner (n : nat) (normal : nat -> Z) : list term :=
  match n with
  | O => []
  | S j => match normal j with Z0 => facing_corner j normal | Zpos _ => Term j (normal j) 0 :: facing_corner j normal | Zneg _ => Term j 0 (normal j) :: facing_corner j normal end
  end.
(* The sum of |v_i|. *)
Fixpoint norm_1 (n : nat) (v : nat -> Z) : Z := match n with O => 0%Z | S j => (Z.abs (v j) + norm_1 j v)%Z end.
(* The normals of the axes, in both directions. *)
Definition axis_normals (n : nat) : list normal_with_multipliers := flat_map (fun i => [(repeat 0 i ++ [-1], []); (repeat 0 i ++ [1], [])]%Z) (seq 0 n).

(* What P1 to P5 require of the table, the check, and its soundness. *)
Section Requirements.
  Variables unit edge_error : Q. (* the value of one step of the table; how far the functions L and U below may be from the edges *)

  (* A value in units of the table, rounded up; `steps_below` rounds down. *)
  Definition steps_above (v : Q) : Z := Qceiling (v / unit).
  Definition steps_below (v : Q) : Z := Qfloor (v / unit).

  (* Inequalities on an edge of dimension i: lower edge >= v, upper edge <= v, lower edge < v, upper edge > v, upper - lower edge >= v. A
     bound is rounded to whole units on the side that demands more. *)
  Definition lower_at_least i v := single_axis_inequality i 1 0 (steps_above v).
  Definition upper_at_most i v := single_axis_inequality i 0 (-1) (- steps_below v).
  Definition lower_less_than i v := single_axis_inequality i (-1) 0 (1 - steps_above v).
  Definition upper_greater_than i v := single_axis_inequality i 0 1 (steps_below v + 1).
  Definition width_at_least i v := single_axis_inequality i (-1) 1 (steps_above v).

  (* Both edges of dimension i are inside the box, with room for the error. *)
  Definition edges_inside_box (b : box) (i : nat) : list requirement :=
    [[lower_at_least i (nth i (lower_corner b) 0 + edge_error)]; [upper_at_most i (nth i (upper_corner b) 0 - edge_error)]]%Q.
  (* Coordinate i of point x is strictly between the edges, with room for the error. *)
  Definition edges_around_point (x : list Q) (i : nat) : list requirement :=
    [[lower_less_than i (nth i x 0 - edge_error)]; [upper_greater_than i (nth i x 0 + edge_error)]]%Q.
  (* Along a normal the tube is beyond the set, by the clearance and the error; an impossible requirement for the normal 0, which
     separates nothing. *)
  Definition beyond_set_along_normal (n : nat) (clearance : Q) (set : shape) (v : normal_with_multipliers) : requirement :=
    let w i := nth i (fst v) 0%Z in
    match facing_corner n w with
    | [] => []
    | es => [EdgeInequality es (steps_above (support_bound n w (snd v) set + (clearance + edge_error) * inject_Z (norm_1 n w)))]
    end.
  (* For every unsafe set: one of its normals, or of the axes', separates the tube from it. *)
  Fixpoint separation_requirements (n : nat) (clearance : Q) (sets : list shape) (normals_by_set : list (list normal_with_multipliers)) : list requirement :=
    match sets with [] => [] | o :: sets => flat_map (beyond_set_along_normal n clearance o) (axis_normals n ++ hd [] normals_by_set) :: separation_requirements n clearance sets (tl normals_by_set) end.

  (* The whole box between the edges is within a half-space, whose normal is scaled to integers. *)
  Definition edges_within_half_space (n : nat) (half_space : list Q * Q) : requirement :=
    let d := fold_right (fun q d => Z.lcm (Zpos (Qden q)) d) 1%Z (fst half_space) in
    let w i := Qnum (Qred (nth i (fst half_space) 0%Q * inject_Z d)) in
    if ((0 <? d)%Z && forallb (fun i => Qeq_bool (inject_Z (w i)) (nth i (fst half_space) 0%Q * inject_Z d)) (seq 0 n))%bool
    then [EdgeInequality (facing_corner n (fun i => - w i)%Z) (steps_above (edge_error * inject_Z (norm_1 n (fun i => - w i)%Z) - snd half_space * inject_Z d))] else [].

  (* The requirements at all times (P1, P3, P4); then those at 0 (P2) and those from t_c on (P5). *)
  Definition requirements_always (plan : search_plan) (spec : task) : list requirement :=
    map (fun i => [width_at_least i (min_width spec + 2 * edge_error)%Q]) (seq 0 (n spec)) ++
    flat_map (edges_inside_box (state_space spec)) (seq 0 (n spec)) ++ map (edges_within_half_space (n spec)) (state_half_spaces spec) ++
    separation_requirements (n spec) (clearance spec) (unsafe_sets spec) (normals plan).
  Definition requirements_at_start (spec : task) : list requirement := flat_map (fun i => edges_around_point (initial_state spec) i ++ edges_inside_box (initial_set spec) i) (seq 0 (n spec)).
  Definition requirements_at_end (spec : task) : list requirement := flat_map (edges_inside_box (target_set spec)) (seq 0 (n spec)) ++ map (edges_within_half_space (n spec)) (target_half_spaces spec).

  (* q > 0. *)
  Definition is_positive (q : Q) : bool := negb (Qle_bool q 0).

  (* P1 to P5, with room for the error: the requirements at all times on every piece, those at 0 on the first piece's start, those from
     t_c on on the last piece's end. *)
  Definition tube_check (plan : search_plan) (spec : task) (rows : table) : bool :=
    is_positive unit && is_positive (t_c spec) && is_regular (n spec) rows &&
    let ps := pieces rows in
    forallb (let rs := requirements_always plan spec in fun p => check_piece (halvings_max plan) 1 p rs) ps &&
    check_piece 0 1 (map_edges constant_at_start (nth 0 ps [])) (requirements_at_start spec) &&
    check_piece 0 1 (map_edges constant_at_end (nth (segment_count rows - 1) ps [])) (requirements_at_end spec).

  Hypothesis unit_pos : is_positive unit = true.

  Lemma is_positive_sound q : is_positive q = true -> 0 < Q2R q.
  Proof.
    unfold is_positive; intro H; replace 0 with (Q2R 0) by (unfold Q2R; cbn; lra); apply Qlt_Rlt.
    apply negb_true_iff in H. apply Qnot_le_lt; intro C; apply Qle_bool_iff in C; congruence.
  Qed.

  Lemma unit_real_pos : 0 < Q2R unit. Proof. now apply is_positive_sound. Qed.
  Lemma unit_nonzero : ~ (unit == 0)%Q.
  Proof. intro E; apply Qeq_eqR in E; pose proof unit_real_pos as P; rewrite E in P; revert P; unfold Q2R; cbn; lra. Qed.

  Lemma Q2R_Z z : Q2R (inject_Z z) = IZR z. Proof. unfold Q2R; cbn; lra. Qed.

  Lemma unit_times_quotient v : Q2R v = Q2R unit * Q2R (v / unit).
  Proof. rewrite Q2R_div by exact unit_nonzero; field; pose proof unit_real_pos; lra. Qed.

  Lemma steps_above_bounds v : Q2R v <= Q2R unit * IZR (steps_above v).
  Proof.
    rewrite (unit_times_quotient v) at 1; apply Rmult_le_compat_l; [left; exact unit_real_pos|].
    rewrite <- Q2R_Z; apply Qle_Rle, Qle_ceiling.
  Qed.
  Lemma steps_below_bounds v : Q2R unit * IZR (steps_below v) <= Q2R v.
  Proof.
    rewrite (unit_times_quotient v) at 1; apply Rmult_le_compat_l; [left; exact unit_real_pos|].
    rewrite <- Q2R_Z; apply Qle_Rle, Qfloor_le.
  Qed.
  Lemma steps_above_tight v : Q2R unit * IZR (steps_above v - 1) < Q2R v.
  Proof.
    rewrite (unit_times_quotient v) at 1; apply Rmult_lt_compat_l; [exact unit_real_pos|].
    rewrite <- Q2R_Z; apply Qlt_Rlt, Qceiling_lt.
  Qed.
  Lemma steps_below_tight v : Q2R v < Q2R unit * IZR (steps_below v + 1).
  Proof.
    rewrite (unit_times_quotient v) at 1; apply Rmult_lt_compat_l; [exact unit_real_pos|].
    rewrite <- Q2R_Z; apply Qlt_Rlt, Qlt_floor.
  Qed.

  Variables (spec : task) (rows : table) (plan : search_plan).
  Hypothesis tube_checked : tube_check plan spec rows = true.

  (* The exact edges. *)
  Definition lower (i : nat) (t : R) : R := edge (Q2R unit) (Q2R (t_c spec)) rows fst i t.
  Definition upper (i : nat) (t : R) : R := edge (Q2R unit) (Q2R (t_c spec)) rows snd i t.

  (* Functions that are near the exact edges: what a program computes. *)
  Variables L U : nat -> R -> R.
  Hypothesis near_exact_edges : forall i t, (i < n spec)%nat ->
    Rabs (L i t - lower i t) <= Q2R edge_error /\ Rabs (U i t - upper i t) <= Q2R edge_error.

  (* The inequality holds for the exact edges at time t. *)
  Definition inequality_holds_at (t : R) (a : edge_inequality) : Prop :=
    Q2R unit * IZR (bound a) <= weighted_edges (fun i => lower i t) (fun i => upper i t) a.

  Lemma exact_edges_range i t : (i < n spec)%nat ->
    L i t - Q2R edge_error <= lower i t <= L i t + Q2R edge_error /\ U i t - Q2R edge_error <= upper i t <= U i t + Q2R edge_error.
  Proof. intro H; destruct (near_exact_edges i t H) as [A B]; apply Rabs_le_between in A, B; lra. Qed.

  Ltac atoms i t H Hi := unfold inequality_holds_at, weighted_edges, lower_at_least, upper_at_most, lower_less_than, upper_greater_than, width_at_least, single_axis_inequality in H;
    cbn [terms fold_right axis lower_weight upper_weight bound] in H; destruct (exact_edges_range i t Hi).

  Lemma lower_at_least_sound i v t : (i < n spec)%nat -> inequality_holds_at t (lower_at_least i (v + edge_error)) -> Q2R v <= L i t.
  Proof. intros Hi H; atoms i t H Hi; pose proof (steps_above_bounds (v + edge_error)) as A; rewrite Q2R_plus in A; lra. Qed.
  Lemma upper_at_most_sound i v t : (i < n spec)%nat -> inequality_holds_at t (upper_at_most i (v - edge_error)) -> U i t <= Q2R v.
  Proof.
    intros Hi H; atoms i t H Hi; pose proof (steps_below_bounds (v - edge_error)) as A; rewrite Q2R_minus in A.
    rewrite opp_IZR in H; lra.
  Qed.
  Lemma lower_less_than_sound i v t : (i < n spec)%nat -> inequality_holds_at t (lower_less_than i (v - edge_error)) -> L i t < Q2R v.
  Proof.
    intros Hi H; atoms i t H Hi; pose proof (steps_above_tight (v - edge_error)) as A; rewrite Q2R_minus in A.
    rewrite minus_IZR in *; lra.
  Qed.
  Lemma upper_greater_than_sound i v t : (i < n spec)%nat -> inequality_holds_at t (upper_greater_than i (v + edge_error)) -> Q2R v < U i t.
  Proof. intros Hi H; atoms i t H Hi; pose proof (steps_below_tight (v + edge_error)) as A; rewrite Q2R_plus in A; lra. Qed.
  Lemma width_at_least_sound i v t : (i < n spec)%nat -> inequality_holds_at t (width_at_least i (v + 2 * edge_error)) -> L i t + Q2R v <= U i t.
  Proof.
    intros Hi H; atoms i t H Hi; pose proof (steps_above_bounds (v + 2 * edge_error)) as A; rewrite Q2R_plus, Q2R_mult in A.
    replace (Q2R 2) with 2 in A by (unfold Q2R; cbn; lra). lra.
  Qed.

  (* Both functions of dimension i are inside the box at time t. *)
  Definition in_box (b : box) (i : nat) (t : R) : Prop := real_at (lower_corner b) i <= L i t /\ U i t <= real_at (upper_corner b) i.

  Lemma edges_inside_box_sound b i t : (i < n spec)%nat -> (forall r, In r (edges_inside_box b i) -> exists a, In a r /\ inequality_holds_at t a) -> in_box b i t.
  Proof.
    intros Hi H; split.
    - destruct (H _ (or_introl eq_refl)) as (a & [<-|[]] & M); now apply lower_at_least_sound in M.
    - destruct (H _ (or_intror (or_introl eq_refl))) as (a & [<-|[]] & M); now apply upper_at_most_sound in M.
  Qed.

  Lemma separation_requirements_form c r : forall os vs, In r (separation_requirements (n spec) c os vs) -> exists o ns, r = flat_map (beyond_set_along_normal (n spec) c o) ns.
  Proof. induction os as [|o os IH]; intros vs I; cbn in I; [easy|]. destruct I as [<-|I]; [eauto|now apply (IH (tl vs))]. Qed.
  Lemma separation_requirement_exists c o : forall os vs, In o os -> exists ns, In (flat_map (beyond_set_along_normal (n spec) c o) ns) (separation_requirements (n spec) c os vs).
  Proof.
    induction os as [|p os IH]; intros vs I; cbn [In separation_requirements] in *; [easy|]. destruct I as [->|I]; [eexists; left; reflexivity|].
    destruct (IH (tl vs) I) as (ns & J). exists ns. now right.
  Qed.
  Lemma facing_corner_axes v e : forall m, In e (facing_corner m v) -> (axis e < m)%nat.
  Proof.
    induction m as [|m IH]; intro I; cbn [facing_corner] in I; [easy|].
    destruct (v m); [apply IH in I; lia| |]; (destruct I as [<-|I]; [cbn; lia|apply IH in I; lia]).
  Qed.

  Lemma half_space_axes f a e : In a (edges_within_half_space (n spec) f) -> In e (terms a) -> (axis e < n spec)%nat.
  Proof. unfold edges_within_half_space; cbv zeta. destruct (_ && _)%bool; [|easy]. intros [<-|[]]. apply facing_corner_axes. Qed.

  Lemma requirements_always_axes r a e : In r (requirements_always plan spec) -> In a r -> In e (terms a) -> (axis e < n spec)%nat.
  Proof.
    unfold requirements_always; rewrite !in_app_iff, !in_map_iff, in_flat_map.
    intros [(i & <- & I)|[(i & I & [<-|[<-|[]]])|[(f & <- & _)|H]]].
    4: apply half_space_axes.
    1,2,3: intros [<-|[]] [<-|[]]; cbn; apply in_seq in I; lia.
    apply separation_requirements_form in H; destruct H as (o & ns & ->). rewrite in_flat_map; intros (v & _ & J) K. unfold beyond_set_along_normal in J.
    destruct (facing_corner (n spec) _) eqn:F; [easy|]. destruct J as [<-|[]]; cbn [terms] in K. rewrite <- F in K. now apply facing_corner_axes in K.
  Qed.
  Lemma requirements_at_start_axes r a e : In r (requirements_at_start spec) -> In a r -> In e (terms a) -> (axis e < n spec)%nat.
  Proof.
    unfold requirements_at_start; rewrite in_flat_map; intros (i & I & H); apply in_seq in I.
    destruct H as [<-|[<-|[<-|[<-|[]]]]]; intros [<-|[]] [<-|[]]; cbn; lia.
  Qed.
  Lemma requirements_at_end_axes r a e : In r (requirements_at_end spec) -> In a r -> In e (terms a) -> (axis e < n spec)%nat.
  Proof.
    unfold requirements_at_end; rewrite in_app_iff, in_flat_map, in_map_iff.
    intros [(i & I & H)|(f & <- & _)]; [|apply half_space_axes]. apply in_seq in I. destruct H as [<-|[<-|[]]]; intros [<-|[]] [<-|[]]; cbn; lia.
  Qed.

  Lemma facing_corner_weighted low up v z m : weighted_edges low up (EdgeInequality (facing_corner m v) z) = total m (fun i => IZR (v i) * (if (0 <? v i)%Z then low i else up i)).
  Proof.
    unfold weighted_edges; cbn [terms]. induction m as [|m IH]; cbn [facing_corner total]; [reflexivity|].
    destruct (v m); cbn [fold_right axis lower_weight upper_weight Z.ltb Z.compare]; rewrite IH; ring.
  Qed.
  Lemma facing_corner_nonzero v : forall m, facing_corner m v <> [] -> exists i, (i < m)%nat /\ v i <> 0%Z.
  Proof.
    induction m as [|m IH]; cbn [facing_corner]; [easy|]. intro H. destruct (v m) eqn:E.
    1: destruct (IH H) as (i & Hi & Ne); exists i; split; [lia|exact Ne].
    all: exists m; split; [lia|rewrite E; easy].
  Qed.
  Lemma norm_1_value m v : IZR (norm_1 m v) = total m (fun i => Rabs (IZR (v i))).
  Proof. induction m as [|m IH]; cbn [norm_1 total]; [reflexivity|]. now rewrite plus_IZR, IH, abs_IZR. Qed.

  Let between_edges (x : nat -> R) (t : R) : Prop := forall i, (i < n spec)%nat -> L i t <= x i <= U i t.

  Lemma facing_corner_bounds v z x t : between_edges x t -> inequality_holds_at t (EdgeInequality (facing_corner (n spec) v) z) ->
    Q2R unit * IZR z <= total (n spec) (fun i => IZR (v i) * x i) + Q2R edge_error * total (n spec) (fun i => Rabs (IZR (v i))).
  Proof.
    intros B M. unfold inequality_holds_at in M. cbn [bound] in M. rewrite facing_corner_weighted in M. apply (Rle_trans _ _ _ M).
    rewrite <- total_scale, <- total_plus. apply total_le. intros i Hi. specialize (B i Hi). destruct (exact_edges_range i t Hi) as [[L1 L2] [U1 U2]].
    destruct (Z.ltb_spec 0 (v i)) as [P|P].
    - apply IZR_lt in P. rewrite Rabs_pos_eq by lra.
      assert (IZR (v i) * lower i t <= IZR (v i) * (x i + Q2R edge_error)) by (apply Rmult_le_compat_l; lra). lra.
    - apply IZR_le in P. rewrite Rabs_left1 by lra.
      assert (- IZR (v i) * (x i - Q2R edge_error) <= - IZR (v i) * upper i t) by (apply Rmult_le_compat_l; lra). lra.
  Qed.

  Lemma edges_within_half_space_sound f x t : between_edges x t -> (exists a, In a (edges_within_half_space (n spec) f) /\ inequality_holds_at t a) -> total (n spec) (fun i => real_at (fst f) i * x i) <= Q2R (snd f).
  Proof.
    intros B (a & I & M). unfold edges_within_half_space in I. cbv zeta in I. set (d := fold_right _ _ _) in I. destruct (_ && _)%bool eqn:C; [|easy].
    rewrite andb_true_iff, forallb_forall in C. destruct C as [D W]. apply Z.ltb_lt, IZR_lt in D. destruct I as [<-|[]].
    apply (facing_corner_bounds _ _ x t B) in M. rewrite <- norm_1_value in M.
    set (q := (edge_error * _ - _)%Q) in M. pose proof (steps_above_bounds q) as A. unfold q in A at 1. rewrite Q2R_minus, !Q2R_mult, !Q2R_Z in A.
    rewrite (total_eq (n spec) _ (fun i => - IZR d * (real_at (fst f) i * x i))) in M.
    - rewrite total_scale in M. apply (Rmult_le_reg_l (IZR d)); lra.
    - intros i Hi. assert (E := W i ltac:(apply in_seq; lia)). apply Qeq_bool_iff, Qeq_eqR in E. rewrite Q2R_mult, !Q2R_Z in E.
      rewrite opp_IZR, E. unfold real_at. ring.
  Qed.

  (* The requirement implies `separated`. *)
  Lemma beyond_set_along_normal_separates o ns t : (exists a, In a (flat_map (beyond_set_along_normal (n spec) (clearance spec) o) ns) /\ inequality_holds_at t a) ->
    separated (n spec) (Q2R (clearance spec)) o (fun i => L i t) (fun i => U i t).
  Proof.
    intros (a & I & M). apply in_flat_map in I. destruct I as (v & _ & I). unfold beyond_set_along_normal in I.
    set (w := fun i => nth i (fst v) 0%Z) in *. destruct (facing_corner (n spec) w) eqn:F; [easy|]. rewrite <- F in I.
    assert (Nz := facing_corner_nonzero w (n spec) ltac:(rewrite F; easy)). destruct I as [<-|[]].
    set (q := (support_bound _ _ _ _ + _)%Q) in *. pose proof (steps_above_bounds q) as A. unfold q in A.
    rewrite Q2R_plus, Q2R_mult, Q2R_plus, Q2R_Z, norm_1_value in A. fold q in A.
    exists (fun i => IZR (w i)). split.
    - destruct Nz as (i & Hi & Ne). exists i. split; [exact Hi|]. intro E. apply Ne. now apply eq_IZR.
    - intros x y Hx Hy. assert (B := support_bounds (n spec) w (snd v) o y Hy).
      assert (C := facing_corner_bounds w _ x t Hx M). lra.
  Qed.

  (* Where `tube_check` says true, P1 to P5 hold at every time, for any functions within the error of the edges. *)
  Theorem tube_sound :
    (* P1 *) (forall i t, (i < n spec)%nat -> L i t + Q2R (min_width spec) <= U i t) /\
    (* P2 *) (forall i, (i < n spec)%nat -> L i 0 < real_at (initial_state spec) i < U i 0 /\ in_box (initial_set spec) i 0) /\
    (* P3 *) (forall i t, (i < n spec)%nat -> in_box (state_space spec) i t) /\
    (* P4 *) (forall o t, In o (unsafe_sets spec) -> separated (n spec) (Q2R (clearance spec)) o (fun i => L i t) (fun i => U i t)) /\
    (* P5 *) (forall i t, (i < n spec)%nat -> Q2R (t_c spec) <= t -> in_box (target_set spec) i t) /\
    (* P3 and P5 where half-spaces cut *)
    (forall t x, (forall i, (i < n spec)%nat -> L i t <= x i <= U i t) -> within_half_spaces (n spec) (state_half_spaces spec) x /\ (Q2R (t_c spec) <= t -> within_half_spaces (n spec) (target_half_spaces spec) x)).
  Proof.
    pose proof tube_checked as C; unfold tube_check in C; cbv zeta in C.
    rewrite !andb_true_iff in C; destruct C as [[[_ HT] Rg] [[Ca Cs] Ce]].
    apply is_positive_sound in HT.
    assert (A := check_table_sound _ _ _ _ _ _ Rg unit_real_pos HT requirements_always_axes Ca).
    assert (S := check_start_sound _ _ _ _ _ Rg unit_real_pos HT requirements_at_start_axes Cs).
    assert (E := check_end_sound _ _ _ _ _ Rg unit_real_pos HT requirements_at_end_axes Ce).
    split; [|split; [|split; [|split; [|split]]]].
    - intros i t Hi.
      destruct (A t [width_at_least i (min_width spec + 2 * edge_error)%Q]) as (a & [<-|[]] & M).
      { unfold requirements_always; apply in_app_iff; left. apply (in_map (fun i => [width_at_least i (min_width spec + 2 * edge_error)%Q])), in_seq; lia. }
      now apply width_at_least_sound in M.
    - intros i Hi.
      assert (G : forall r, In r (edges_around_point (initial_state spec) i ++ edges_inside_box (initial_set spec) i) -> exists a, In a r /\ inequality_holds_at 0 a).
      { intros r I; apply S; unfold requirements_at_start; apply in_flat_map; exists i; split; [apply in_seq; lia|exact I]. }
      split; [split|].
      + destruct (G _ (or_introl eq_refl)) as (a & [<-|[]] & M); now apply lower_less_than_sound in M.
      + destruct (G _ (or_intror (or_introl eq_refl))) as (a & [<-|[]] & M); now apply upper_greater_than_sound in M.
      + apply edges_inside_box_sound; [exact Hi|]; intros r I; apply G, in_app_iff; now right.
    - intros i t Hi; apply edges_inside_box_sound; [exact Hi|]; intros r I; apply A; unfold requirements_always.
      rewrite !in_app_iff; right; left; apply in_flat_map; exists i; split; [apply in_seq; lia|exact I].
    - intros o t Ho. destruct (separation_requirement_exists (clearance spec) o (unsafe_sets spec) (normals plan) Ho) as (ns & I).
      apply (beyond_set_along_normal_separates o ns), A. unfold requirements_always; rewrite !in_app_iff; now do 3 right.
    - intros i t Hi Ht; apply edges_inside_box_sound; [exact Hi|]; intros r I; apply (E t Ht).
      unfold requirements_at_end; apply in_app_iff; left; apply in_flat_map; exists i; split; [apply in_seq; lia|exact I].
    - intros t x B. split; [|intro Ht]; intros f F; apply (edges_within_half_space_sound f x t B).
      + apply A. unfold requirements_always; rewrite !in_app_iff; do 2 right; left. now apply in_map.
      + apply (E t Ht). unfold requirements_at_end; rewrite in_app_iff; right. now apply in_map.
  Qed.

  (* So a state strictly inside the tube is in the state space and clear of every unsafe set, and from t_c on in the target set. *)
  Lemma inside_tube_meets_task t x : (forall i, (i < n spec)%nat -> L i t < x i < U i t) ->
    in_space spec x /\ (forall o, In o (unsafe_sets spec) -> clear (n spec) (Q2R (clearance spec)) o x) /\ (Q2R (t_c spec) <= t -> in_target spec x).
  Proof.
    intro I. destruct tube_sound as (_ & _ & P3 & P4 & P5 & P). destruct (P t x) as [W G]; [intros i Hi; specialize (I i Hi); lra|].
    split; [split; [|exact W]|split].
    - intros i Hi. destruct (I i Hi), (P3 i t Hi). lra.
    - intros o Ho. exact (strictly_inside_separated_is_clear _ _ _ _ _ _ (P4 o t Ho) I).
    - intro Ht. split; [|exact (G Ht)]. intros i Hi. destruct (I i Hi), (P5 i t Hi Ht). lra.
  Qed.
End Requirements.

