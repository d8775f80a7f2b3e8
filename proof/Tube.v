(* A refined tube: uniform cubic B-spline edges from a table of integers, a check over Z, and what follows from its `true`.

   A requirement is a disjunction of lower bounds on sums of edges. On a segment a sum lies above its least Bezier coefficient;
   where that shows too little the segment is halved, and each half may choose another of the disjuncts. So an obstacle may be
   passed below in one half and above in the next. Normals that separate may come from outside: none of them is believed. *)
From Coq Require Import ZArith QArith Qreals Qround Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core.Raux.
From Coquelicot Require Import Coquelicot.
From Stt Require Export Sets.
Import ListNotations.
Open Scope R_scope.

(* ------------------------------------------------------------------ the edge, as the emitted code computes it *)

(* control points are already divided by 6 *)
Definition cubic (q0 q1 q2 q3 : Z) (s : R) : R :=
  IZR q0 * (1 - s)^3 + IZR q1 * (3*s^3 - 6*s^2 + 4) + IZR q2 * (- 3*s^3 + 3*s^2 + 3*s + 1) + IZR q3 * s^3.

(* segment of spline time u when there are K: floor u, held within 0 .. K-1 *)
Definition segment (K : nat) (u : R) : nat := Nat.min (Z.to_nat (Zfloor u)) (K - 1).

Definition spline (q : list Z) (u : R) : R :=
  let k := segment (length q - 3) u in
  cubic (nth k q 0%Z) (nth (k+1) q 0%Z) (nth (k+2) q 0%Z) (nth (k+3) q 0%Z) (u - INR k).

(* a table has one row per control point, and in it a pair (lower, upper) per dimension *)
Definition table := list (list (Z * Z)).
Definition column (side : Z * Z -> Z) (i : nat) (rows : table) : list Z := map (fun r => side (nth i r (0, 0)%Z)) rows.
Definition segments (rows : table) : nat := length rows - 3.
Definition hold (T t : R) : R := Rmax 0 (Rmin t T).

(* an edge: held at its start before 0 and at its end from T on *)
Definition edge (unit T : R) (rows : table) (side : Z * Z -> Z) (i : nat) (t : R) : R :=
  unit * spline (column side i rows) (INR (segments rows) / T * hold T t).

(* ------------------------------------------------------------------ Bezier coefficients *)

Record bez := Bez { c0 : Z; c1 : Z; c2 : Z; c3 : Z }.

Definition bernstein (c : bez) (s : R) : R :=
  IZR (c0 c) * (1-s)^3 + 3 * IZR (c1 c) * (1-s)^2 * s + 3 * IZR (c2 c) * (1-s) * s^2 + IZR (c3 c) * s^3.

Definition to_bez (q0 q1 q2 q3 : Z) : bez :=
  Bez (q0 + 4*q1 + q2) (4*q1 + 2*q2) (2*q1 + 4*q2) (q1 + 4*q2 + q3).

Ltac izr := repeat (rewrite plus_IZR || rewrite minus_IZR || rewrite mult_IZR || rewrite opp_IZR).

Lemma cubic_bezier q0 q1 q2 q3 s : cubic q0 q1 q2 q3 s = bernstein (to_bez q0 q1 q2 q3) s.
Proof. unfold cubic, bernstein, to_bez; cbn [c0 c1 c2 c3]; izr; ring. Qed.

(* de Casteljau's halves, times 8: coefficients stay integers, and the bound is multiplied by 8 with each halving. *)
Definition early (c : bez) : bez :=
  Bez (8 * c0 c) (4 * (c0 c + c1 c)) (2 * (c0 c + 2 * c1 c + c2 c)) (c0 c + 3 * c1 c + 3 * c2 c + c3 c).
Definition late (c : bez) : bez :=
  Bez (c0 c + 3 * c1 c + 3 * c2 c + c3 c) (2 * (c1 c + 2 * c2 c + c3 c)) (4 * (c2 c + c3 c)) (8 * c3 c).

Lemma early_ok c s : bernstein (early c) s = 8 * bernstein c (s / 2).
Proof. unfold bernstein, early; cbn [c0 c1 c2 c3]; izr; field. Qed.
Lemma late_ok c s : bernstein (late c) s = 8 * bernstein c ((1 + s) / 2).
Proof. unfold bernstein, late; cbn [c0 c1 c2 c3]; izr; field. Qed.

Definition mix (a : Z) (c : bez) (b : Z) (d : bez) : bez :=
  Bez (a * c0 c + b * c0 d) (a * c1 c + b * c1 d) (a * c2 c + b * c2 d) (a * c3 c + b * c3 d).
Lemma mix_ok a c b d s : bernstein (mix a c b d) s = IZR a * bernstein c s + IZR b * bernstein d s.
Proof. unfold bernstein, mix; cbn [c0 c1 c2 c3]; izr; ring. Qed.

Definition all_from (z : Z) (c : bez) : bool := ((z <=? c0 c) && (z <=? c1 c) && (z <=? c2 c) && (z <=? c3 c))%Z.

Lemma hull z c s : all_from z c = true -> 0 <= s <= 1 -> IZR z <= bernstein c s.
Proof.
  unfold all_from, bernstein; rewrite !andb_true_iff, !Z.leb_le; intros [[[A B] C] D] [E F].
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

Definition piece := list (bez * bez).
Definition zero_bez := Bez 0 0 0 0.

(* Over the terms, the sum of wl * lower + wu * upper of the edges of one dimension is >= least, in units of the table. *)
Record term := Term { dim : nat; wl : Z; wu : Z }.
Record atom := Atom { terms : list term; least : Z }.
Definition single (i : nat) (l u v : Z) : atom := Atom [Term i l u] v.
Definition requirement := list atom. (* one of them must hold; which one may differ from half to half *)

Definition of_term (e : term) (p : piece) : bez :=
  let c := nth (dim e) p (zero_bez, zero_bez) in mix (wl e) (fst c) (wu e) (snd c).
Fixpoint of_terms (es : list term) (p : piece) : bez :=
  match es with [] => zero_bez | [e] => of_term e p | e :: es => mix 1 (of_term e p) 1 (of_terms es p) end.
Definition of_atom (a : atom) (p : piece) : bez := of_terms (terms a) p.
Definition shown (scale : Z) (p : piece) (r : requirement) : bool :=
  existsb (fun a => all_from (scale * least a) (of_atom a p)) r.

Definition both (f : bez -> bez) (p : piece) : piece := map (fun c => (f (fst c), f (snd c))) p.

Fixpoint check_piece (depth : nat) (scale : Z) (p : piece) (rs : list requirement) : bool :=
  match filter (fun r => negb (shown scale p r)) rs with
  | [] => true
  | bad => match depth with
           | O => false
           | S d => if check_piece d (8 * scale) (both early p) bad then check_piece d (8 * scale) (both late p) bad else false (* lazily *)
           end
  end.

Definition term_value (e : term) (p : piece) (s : R) : R :=
  let c := nth (dim e) p (zero_bez, zero_bez) in IZR (wl e) * bernstein (fst c) s + IZR (wu e) * bernstein (snd c) s.
Definition value (a : atom) (p : piece) (s : R) : R := fold_right (fun e v => term_value e p s + v) 0 (terms a).

Lemma value_ok a p s : bernstein (of_atom a p) s = value a p s.
Proof.
  assert (T : forall e, bernstein (of_term e p) s = term_value e p s) by (intro; unfold of_term, term_value; now rewrite mix_ok).
  unfold of_atom, value. induction (terms a) as [|e [|d es] IH]; cbn [of_terms fold_right] in *.
  - unfold bernstein, zero_bez; cbn [c0 c1 c2 c3]; ring.
  - rewrite T; ring.
  - rewrite mix_ok, T, IH; ring.
Qed.

Lemma value_both f k h a p s : f zero_bez = zero_bez -> (forall c, bernstein (f c) s = k * bernstein c h) ->
  value a (both f p) s = k * value a p h.
Proof.
  intros Z0 H; unfold value. induction (terms a) as [|e es IH]; cbn [fold_right]; [ring|rewrite IH].
  unfold term_value, both.
  set (g := fun c : bez * bez => (f (fst c), f (snd c))).
  replace (zero_bez, zero_bez) with (g (zero_bez, zero_bez)) at 1 2 by (unfold g; cbn; now rewrite Z0).
  rewrite !map_nth; unfold g; cbn [fst snd]; rewrite !H; ring.
Qed.

Lemma shown_ok scale p r s : shown scale p r = true -> 0 <= s <= 1 ->
  exists a, In a r /\ IZR scale * IZR (least a) <= value a p s.
Proof.
  unfold shown; rewrite existsb_exists; intros (a & I & H) S; exists a; split; [exact I|].
  apply hull with (s := s) in H; [|exact S].
  rewrite value_ok, mult_IZR in H; exact H.
Qed.

Lemma check_piece_sound depth : forall scale p rs, check_piece depth scale p rs = true ->
  forall s, 0 <= s <= 1 -> forall r, In r rs -> exists a, In a r /\ IZR scale * IZR (least a) <= value a p s.
Proof.
  induction depth; intros scale p rs H s S r I; cbn [check_piece] in H;
  destruct (shown scale p r) eqn:Sh; try (now apply shown_ok); 
  assert (B : In r (filter (fun r => negb (shown scale p r)) rs)) by (apply filter_In; now rewrite Sh);
  destruct (filter _ rs) as [|b bs]; try easy.
  destruct (check_piece depth (8 * scale) (both early p) (b :: bs)) eqn:E; [|easy]. rename H into L.
  destruct (Rle_dec s (1/2)) as [Q|Q].
  - destruct (IHdepth _ _ _ E (2 * s) ltac:(lra) r B) as (a & Ia & V); exists a; split; [exact Ia|].
    rewrite (value_both early 8 s) in V; [rewrite mult_IZR in V; lra|easy|].
    intro c; rewrite early_ok; do 2 f_equal; field.
  - destruct (IHdepth _ _ _ L (2 * s - 1) ltac:(lra) r B) as (a & Ia & V); exists a; split; [exact Ia|].
    rewrite (value_both late 8 s) in V; [rewrite mult_IZR in V; lra|easy|].
    intro c; rewrite late_ok; do 2 f_equal; field.
Qed.

Fixpoint make_piece (r0 r1 r2 r3 : list (Z * Z)) : piece :=
  match r0, r1, r2, r3 with
  | (a0, b0) :: r0, (a1, b1) :: r1, (a2, b2) :: r2, (a3, b3) :: r3 =>
      (to_bez a0 a1 a2 a3, to_bez b0 b1 b2 b3) :: make_piece r0 r1 r2 r3
  | _, _, _, _ => []
  end.

Fixpoint pieces (rows : table) : list piece :=
  match rows with
  | r0 :: ((r1 :: r2 :: r3 :: _) as rest) => make_piece r0 r1 r2 r3 :: pieces rest
  | _ => []
  end.

Lemma make_piece_nth n : forall r0 r1 r2 r3 i, length r0 = n -> length r1 = n -> length r2 = n -> length r3 = n -> (i < n)%nat ->
  nth i (make_piece r0 r1 r2 r3) (zero_bez, zero_bez) =
  (to_bez (fst (nth i r0 (0,0)%Z)) (fst (nth i r1 (0,0)%Z)) (fst (nth i r2 (0,0)%Z)) (fst (nth i r3 (0,0)%Z)),
   to_bez (snd (nth i r0 (0,0)%Z)) (snd (nth i r1 (0,0)%Z)) (snd (nth i r2 (0,0)%Z)) (snd (nth i r3 (0,0)%Z))).
Proof.
  induction n; intros [|[]r0] [|[]r1] [|[]r2] [|[]r3] i; cbn [length]; intros; try lia.
  destruct i; cbn; [reflexivity|apply IHn; lia].
Qed.

Lemma pieces_length rows : length (pieces rows) = segments rows.
Proof.
  unfold segments; induction rows as [|r0 [|r1 [|r2 [|r3 rest]]] IH]; try reflexivity.
  cbn [pieces length] in *; rewrite IH; lia.
Qed.

Lemma pieces_nth : forall k rows, (k < segments rows)%nat ->
  nth k (pieces rows) [] = make_piece (nth k rows []) (nth (k+1) rows []) (nth (k+2) rows []) (nth (k+3) rows []).
Proof.
  unfold segments; induction k; intros [|r0 [|r1 [|r2 [|r3 rest]]]] H; cbn [length] in H; try lia; [reflexivity|].
  change (nth (S k) (pieces (r0 :: r1 :: r2 :: r3 :: rest)) []) with (nth k (pieces (r1 :: r2 :: r3 :: rest)) []).
  rewrite IHk by (cbn [length]; lia); reflexivity.
Qed.

(* ------------------------------------------------------------------ from a piece to the edges *)

Definition regular (n : nat) (rows : table) : bool := forallb (fun r => Nat.eqb (length r) n) rows && (4 <=? length rows)%nat.

Lemma regular_ok n rows : regular n rows = true ->
  (4 <= length rows)%nat /\ forall k, (k < length rows)%nat -> length (nth k rows []) = n.
Proof.
  unfold regular; rewrite andb_true_iff, forallb_forall, Nat.leb_le; intros [A B]; split; [exact B|].
  intros k H; apply Nat.eqb_eq, A, nth_In, H.
Qed.

Lemma column_nth side i rows k : side (0,0)%Z = 0%Z -> nth k (column side i rows) 0%Z = side (nth i (nth k rows []) (0,0)%Z).
Proof.
  intro S; unfold column. set (f := fun r => side (nth i r (0,0)%Z)).
  change (side (nth i (nth k rows []) (0,0)%Z)) with (f (nth k rows [])).
  rewrite <- (map_nth f rows [] k). replace (f []) with 0%Z; [reflexivity|].
  unfold f; destruct i; symmetry; exact S.
Qed.

Lemma segment_place K u : (0 < K)%nat -> 0 <= u <= INR K -> (segment K u < K)%nat /\ 0 <= u - INR (segment K u) <= 1.
Proof.
  intros HK [U0 U1]; unfold segment; split; [lia|].
  assert (F0 : (0 <= Zfloor u)%Z) by (now apply Zfloor_lub).
  pose proof (Zfloor_lb u) as Lb. pose proof (Zfloor_ub u) as Ub.
  assert (E : INR (Z.to_nat (Zfloor u)) = IZR (Zfloor u)) by (now rewrite INR_IZR_INZ, Z2Nat.id).
  destruct (Nat.min_spec (Z.to_nat (Zfloor u)) (K - 1)) as [[C ->]|[C ->]].
  - rewrite E; lra.
  - apply le_INR in C; rewrite E in C.
    assert (INR (K - 1) = INR K - 1) by (rewrite minus_INR by lia; cbn; lra). lra.
Qed.

Definition spline_time (T : R) (rows : table) (t : R) : R := INR (segments rows) / T * hold T t.

Lemma hold_range T t : 0 < T -> 0 <= hold T t <= T.
Proof. unfold hold, Rmax, Rmin; intros; repeat destruct Rle_dec; lra. Qed.
Lemma hold_id T t : 0 <= t <= T -> hold T t = t.
Proof. unfold hold, Rmax, Rmin; intros; repeat destruct Rle_dec; lra. Qed.

Lemma spline_time_range T rows t : 0 < T -> 0 <= spline_time T rows t <= INR (segments rows).
Proof.
  intros HT; unfold spline_time; destruct (hold_range T t HT) as [A B]; pose proof (pos_INR (segments rows)) as P.
  assert (0 <= INR (segments rows) / T) by (apply Rmult_le_pos; [|left; apply Rinv_0_lt_compat]; lra).
  split; [apply Rmult_le_pos; lra|].
  apply Rle_trans with (INR (segments rows) / T * T); [now apply Rmult_le_compat_l|].
  right; field; lra.
Qed.

Definition weighted (low up : nat -> R) (a : atom) : R :=
  fold_right (fun e v => IZR (wl e) * low (dim e) + IZR (wu e) * up (dim e) + v) 0 (terms a).

Lemma edge_value n unit T rows a t : regular n rows = true -> 0 < T -> (forall e, In e (terms a) -> (dim e < n)%nat) ->
  let k := segment (segments rows) (spline_time T rows t) in
  weighted (fun i => edge unit T rows fst i t) (fun i => edge unit T rows snd i t) a =
  unit * value a (nth k (pieces rows) []) (spline_time T rows t - INR k).
Proof.
  intros Rg HT Hd k. unfold weighted, value.
  induction (terms a) as [|e es IH]; cbn [fold_right]; [ring|]. rewrite IH by (intros; apply Hd; now right). rewrite Rmult_plus_distr_l. f_equal.
  specialize (Hd e (or_introl eq_refl)). clear IH.
  destruct (regular_ok _ _ Rg) as [L4 Ln].
  destruct (segment_place (segments rows) (spline_time T rows t)) as [Hk _];
    [unfold segments; lia|now apply spline_time_range|]. fold k in Hk.
  assert (K3 : (k + 3 < length rows)%nat) by (unfold segments in Hk; lia).
  unfold edge, spline, term_value; fold (spline_time T rows t).
  assert (LC : forall side, (length (column side (dim e) rows) - 3)%nat = segments rows)
    by (intro; unfold column, segments; now rewrite map_length).
  rewrite !LC; fold k.
  rewrite !column_nth by reflexivity. rewrite !cubic_bezier.
  rewrite pieces_nth by exact Hk.
  rewrite (make_piece_nth n) by (try apply Ln; lia). cbn [fst snd]. ring.
Qed.

(* the requirements hold for the edges at every t *)
Lemma check_table_sound n depth unit T rows rs : regular n rows = true -> 0 < unit -> 0 < T ->
  (forall r a e, In r rs -> In a r -> In e (terms a) -> (dim e < n)%nat) ->
  forallb (fun p => check_piece depth 1 p rs) (pieces rows) = true ->
  forall t r, In r rs -> exists a, In a r /\
    unit * IZR (least a) <= weighted (fun i => edge unit T rows fst i t) (fun i => edge unit T rows snd i t) a.
Proof.
  intros Rg Hu HT Hd C t r I.
  destruct (regular_ok _ _ Rg) as [L4 _].
  destruct (segment_place (segments rows) (spline_time T rows t)) as [Hk Hs];
    [unfold segments; lia|now apply spline_time_range|].
  set (k := segment (segments rows) (spline_time T rows t)) in *.
  rewrite forallb_forall in C.
  assert (Ck := C (nth k (pieces rows) []) ltac:(apply nth_In; now rewrite pieces_length)).
  destruct (check_piece_sound _ _ _ _ Ck _ Hs r I) as (a & Ia & V).
  exists a; split; [exact Ia|].
  rewrite (edge_value n) by eauto. fold k.
  apply Rmult_le_compat_l; [lra|]. lra.
Qed.

(* Requirements at one end only, for P2 and P5: the first piece's start (s = 0), the last one's end (s = 1) *)
Definition at_start (c : bez) := Bez (c0 c) (c0 c) (c0 c) (c0 c).
Definition at_end (c : bez) := Bez (c3 c) (c3 c) (c3 c) (c3 c).
Lemma at_start_ok c s : bernstein (at_start c) s = 1 * bernstein c 0.
Proof. unfold bernstein, at_start; cbn [c0 c1 c2 c3]; ring. Qed.
Lemma at_end_ok c s : bernstein (at_end c) s = 1 * bernstein c 1.
Proof. unfold bernstein, at_end; cbn [c0 c1 c2 c3]; ring. Qed.

Lemma check_start_sound n unit T rows rs : regular n rows = true -> 0 < unit -> 0 < T ->
  (forall r a e, In r rs -> In a r -> In e (terms a) -> (dim e < n)%nat) ->
  check_piece 0 1 (both at_start (nth 0 (pieces rows) [])) rs = true ->
  forall r, In r rs -> exists a, In a r /\
    unit * IZR (least a) <= weighted (fun i => edge unit T rows fst i 0) (fun i => edge unit T rows snd i 0) a.
Proof.
  intros Rg Hu HT Hd C r I. destruct (regular_ok _ _ Rg) as [L4 _].
  destruct (check_piece_sound _ _ _ _ C 0 ltac:(lra) r I) as (a & Ia & V). exists a; split; [exact Ia|].
  rewrite (value_both at_start 1 0) in V by (try easy; intro; apply at_start_ok).
  rewrite (edge_value n) by eauto.
  assert (U : spline_time T rows 0 = 0) by (unfold spline_time; rewrite hold_id by lra; ring).
  assert (S : segment (segments rows) 0 = 0%nat).
  { unfold segment; replace (Zfloor 0) with 0%Z by (symmetry; apply Zfloor_imp; simpl; lra); reflexivity. }
  rewrite U, S; cbn [INR]; rewrite Rminus_0_r. apply Rmult_le_compat_l; lra.
Qed.

Lemma check_end_sound n unit T rows rs : regular n rows = true -> 0 < unit -> 0 < T ->
  (forall r a e, In r rs -> In a r -> In e (terms a) -> (dim e < n)%nat) ->
  check_piece 0 1 (both at_end (nth (segments rows - 1) (pieces rows) [])) rs = true ->
  forall t, T <= t -> forall r, In r rs -> exists a, In a r /\
    unit * IZR (least a) <= weighted (fun i => edge unit T rows fst i t) (fun i => edge unit T rows snd i t) a.
Proof.
  intros Rg Hu HT Hd C t Ht r I. destruct (regular_ok _ _ Rg) as [L4 _].
  destruct (check_piece_sound _ _ _ _ C 0 ltac:(lra) r I) as (a & Ia & V). exists a; split; [exact Ia|].
  rewrite (value_both at_end 1 1) in V by (try easy; intro; apply at_end_ok).
  rewrite (edge_value n) by eauto.
  assert (U : spline_time T rows t = INR (segments rows)).
  { unfold spline_time, hold. rewrite Rmin_right, Rmax_right by lra. field; lra. }
  assert (S : segment (segments rows) (INR (segments rows)) = (segments rows - 1)%nat).
  { unfold segment; rewrite INR_IZR_INZ, Zfloor_IZR, Nat2Z.id; lia. }
  rewrite U, S.
  replace (INR (segments rows) - INR (segments rows - 1)) with 1; [apply Rmult_le_compat_l; lra|].
  rewrite minus_INR by (unfold segments; lia); cbn; lra.
Qed.

(* ------------------------------------------------------------------ the task, and what P1 to P5 ask of the table *)

Record task := Task {
  n : nat; T : Q; x0 : list Q; space : box; start : box; target : box; unsafe : list shape; clearance : Q; min_width : Q;
  walls : list (list Q * Q); goals : list (list Q * Q) }. (* half-spaces that cut the state space, and the target *)

Definition in_space (k : task) (x : nat -> R) : Prop :=
  (forall i, (i < n k)%nat -> at_ (lo (space k)) i < x i < at_ (hi (space k)) i) /\ within_faces (n k) (walls k) x.
Definition in_target (k : task) (x : nat -> R) : Prop :=
  (forall i, (i < n k)%nat -> at_ (lo (target k)) i < x i < at_ (hi (target k)) i) /\ within_faces (n k) (goals k) x.

(* How `check` goes about it; nothing in it is believed. How often a segment may be halved, and for every unsafe set normals that may
   separate the tube from it, beside those of the axes; with each go multipliers of the set's half-spaces. *)
Definition normal : Type := list Z * list Q.
Record search := Search { halves : nat; normals : list (list normal) }.

Fixpoint facing (m : nat) (v : nat -> Z) : list term := (* the corner of a box that is first along v *)
  match m with
  | O => []
  | S j => match v j with Z0 => facing j v | Zpos _ => Term j (v j) 0 :: facing j v | Zneg _ => Term j 0 (v j) :: facing j v end
  end.
Fixpoint norm_1 (m : nat) (v : nat -> Z) : Z := match m with O => 0%Z | S j => (Z.abs (v j) + norm_1 j v)%Z end.
Definition axes (m : nat) : list normal := flat_map (fun i => [(repeat 0 i ++ [-1], []); (repeat 0 i ++ [1], [])]%Z) (seq 0 m).

Section Compile.
  Variables unit err : Q. (* the value of one table step; how far rounding may move an edge *)

  Definition above (v : Q) : Z := Qceiling (v / unit).
  Definition below (v : Q) : Z := Qfloor (v / unit).

  Definition lower_from i v := single i 1 0 (above v).
  Definition upper_to i v := single i 0 (-1) (- below v).
  Definition lower_below i v := single i (-1) 0 (1 - above v). (* strictly *)
  Definition upper_beyond i v := single i 0 1 (below v + 1).   (* strictly *)
  Definition wide i v := single i (-1) 1 (above v).

  Definition within (b : box) (i : nat) : list requirement :=
    [[lower_from i (nth i (lo b) 0 + err)]; [upper_to i (nth i (hi b) 0 - err)]]%Q.
  Definition around (x : list Q) (i : nat) : list requirement :=
    [[lower_below i (nth i x 0 - err)]; [upper_beyond i (nth i x 0 + err)]]%Q.
  Definition beyond (m : nat) (c : Q) (o : shape) (v : normal) : requirement :=
    let w i := nth i (fst v) 0%Z in
    match facing m w with
    | [] => [] (* a normal of 0 separates nothing *)
    | es => [Atom es (above (support m w (snd v) o + (c + err) * inject_Z (norm_1 m w)))]
    end.
  Fixpoint clear_of (m : nat) (c : Q) (os : list shape) (vs : list (list normal)) : list requirement :=
    match os with [] => [] | o :: os => flat_map (beyond m c o) (axes m ++ hd [] vs) :: clear_of m c os (tl vs) end.

  (* A half-space, with the whole numbers along its normal *)
  Definition inner (m : nat) (f : list Q * Q) : requirement :=
    let d := fold_right (fun q d => Z.lcm (Zpos (Qden q)) d) 1%Z (fst f) in
    let w i := Qnum (Qred (nth i (fst f) 0%Q * inject_Z d)) in
    if ((0 <? d)%Z && forallb (fun i => Qeq_bool (inject_Z (w i)) (nth i (fst f) 0%Q * inject_Z d)) (seq 0 m))%bool
    then [Atom (facing m (fun i => - w i)%Z) (above (err * inject_Z (norm_1 m (fun i => - w i)%Z) - snd f * inject_Z d))] else [].

  Definition along (how : search) (k : task) : list requirement :=
    map (fun i => [wide i (min_width k + 2 * err)%Q]) (seq 0 (n k)) ++
    flat_map (within (space k)) (seq 0 (n k)) ++ map (inner (n k)) (walls k) ++
    clear_of (n k) (clearance k) (unsafe k) (normals how).
  Definition first_ones (k : task) : list requirement := flat_map (fun i => around (x0 k) i ++ within (start k) i) (seq 0 (n k)).
  Definition last_ones (k : task) : list requirement := flat_map (within (target k)) (seq 0 (n k)) ++ map (inner (n k)) (goals k).

  (* Bounds are rounded to whole units on the harder side, and widened by err: by so much a function may differ from its edge. *)
  Definition positive (q : Q) : bool := negb (Qle_bool q 0).

  Definition check (how : search) (k : task) (rows : table) : bool :=
    positive unit && positive (T k) && regular (n k) rows &&
    let ps := pieces rows in
    forallb (let rs := along how k in fun p => check_piece (halves how) 1 p rs) ps &&
    check_piece 0 1 (both at_start (nth 0 ps [])) (first_ones k) &&
    check_piece 0 1 (both at_end (nth (segments rows - 1) ps [])) (last_ones k).

  Hypothesis unit_pos : positive unit = true.

  Lemma positive_ok q : positive q = true -> 0 < Q2R q.
  Proof.
    unfold positive; intro H; replace 0 with (Q2R 0) by (unfold Q2R; cbn; lra); apply Qlt_Rlt.
    apply negb_true_iff in H. apply Qnot_le_lt; intro C; apply Qle_bool_iff in C; congruence.
  Qed.

  Lemma unit_R : 0 < Q2R unit. Proof. now apply positive_ok. Qed.
  Lemma unit_nz : ~ (unit == 0)%Q.
  Proof. intro E; apply Qeq_eqR in E; pose proof unit_R as P; rewrite E in P; revert P; unfold Q2R; cbn; lra. Qed.

  Lemma Q2R_Z z : Q2R (inject_Z z) = IZR z. Proof. unfold Q2R; cbn; lra. Qed.

  Lemma scaled v : Q2R v = Q2R unit * Q2R (v / unit).
  Proof. rewrite Q2R_div by exact unit_nz; field; pose proof unit_R; lra. Qed.

  Lemma above_ok v : Q2R v <= Q2R unit * IZR (above v).
  Proof.
    rewrite (scaled v) at 1; apply Rmult_le_compat_l; [left; exact unit_R|].
    rewrite <- Q2R_Z; apply Qle_Rle, Qle_ceiling.
  Qed.
  Lemma below_ok v : Q2R unit * IZR (below v) <= Q2R v.
  Proof.
    rewrite (scaled v) at 1; apply Rmult_le_compat_l; [left; exact unit_R|].
    rewrite <- Q2R_Z; apply Qle_Rle, Qfloor_le.
  Qed.
  Lemma above_strict v : Q2R unit * IZR (above v - 1) < Q2R v.
  Proof.
    rewrite (scaled v) at 1; apply Rmult_lt_compat_l; [exact unit_R|].
    rewrite <- Q2R_Z; apply Qlt_Rlt, Qceiling_lt.
  Qed.
  Lemma below_strict v : Q2R v < Q2R unit * IZR (below v + 1).
  Proof.
    rewrite (scaled v) at 1; apply Rmult_lt_compat_l; [exact unit_R|].
    rewrite <- Q2R_Z; apply Qlt_Rlt, Qlt_floor.
  Qed.

  Variables (k : task) (rows : table) (how : search).
  Hypothesis checked : check how k rows = true.

  Definition lower (i : nat) (t : R) : R := edge (Q2R unit) (Q2R (T k)) rows fst i t.
  Definition upper (i : nat) (t : R) : R := edge (Q2R unit) (Q2R (T k)) rows snd i t.

  Variables L U : nat -> R -> R. (* what the program computes *)
  Hypothesis near : forall i t, (i < n k)%nat ->
    Rabs (L i t - lower i t) <= Q2R err /\ Rabs (U i t - upper i t) <= Q2R err.

  Definition meaning (t : R) (a : atom) : Prop :=
    Q2R unit * IZR (least a) <= weighted (fun i => lower i t) (fun i => upper i t) a.

  Lemma near' i t : (i < n k)%nat ->
    L i t - Q2R err <= lower i t <= L i t + Q2R err /\ U i t - Q2R err <= upper i t <= U i t + Q2R err.
  Proof. intro H; destruct (near i t H) as [A B]; apply Rabs_le_between in A, B; lra. Qed.

  Ltac atoms i t H Hi := unfold meaning, weighted, lower_from, upper_to, lower_below, upper_beyond, wide, single in H;
    cbn [terms fold_right dim wl wu least] in H; destruct (near' i t Hi).

  Lemma lower_from_ok i v t : (i < n k)%nat -> meaning t (lower_from i (v + err)) -> Q2R v <= L i t.
  Proof. intros Hi H; atoms i t H Hi; pose proof (above_ok (v + err)) as A; rewrite Q2R_plus in A; lra. Qed.
  Lemma upper_to_ok i v t : (i < n k)%nat -> meaning t (upper_to i (v - err)) -> U i t <= Q2R v.
  Proof.
    intros Hi H; atoms i t H Hi; pose proof (below_ok (v - err)) as A; rewrite Q2R_minus in A.
    rewrite opp_IZR in H; lra.
  Qed.
  Lemma lower_below_ok i v t : (i < n k)%nat -> meaning t (lower_below i (v - err)) -> L i t < Q2R v.
  Proof.
    intros Hi H; atoms i t H Hi; pose proof (above_strict (v - err)) as A; rewrite Q2R_minus in A.
    rewrite minus_IZR in *; lra.
  Qed.
  Lemma upper_beyond_ok i v t : (i < n k)%nat -> meaning t (upper_beyond i (v + err)) -> Q2R v < U i t.
  Proof. intros Hi H; atoms i t H Hi; pose proof (below_strict (v + err)) as A; rewrite Q2R_plus in A; lra. Qed.
  Lemma wide_ok i v t : (i < n k)%nat -> meaning t (wide i (v + 2 * err)) -> L i t + Q2R v <= U i t.
  Proof.
    intros Hi H; atoms i t H Hi; pose proof (above_ok (v + 2 * err)) as A; rewrite Q2R_plus, Q2R_mult in A.
    replace (Q2R 2) with 2 in A by (unfold Q2R; cbn; lra). lra.
  Qed.

  Definition in_box (b : box) (i : nat) (t : R) : Prop := at_ (lo b) i <= L i t /\ U i t <= at_ (hi b) i.

  Lemma within_ok b i t : (i < n k)%nat -> (forall r, In r (within b i) -> exists a, In a r /\ meaning t a) -> in_box b i t.
  Proof.
    intros Hi H; split.
    - destruct (H _ (or_introl eq_refl)) as (a & [<-|[]] & M); now apply lower_from_ok in M.
    - destruct (H _ (or_intror (or_introl eq_refl))) as (a & [<-|[]] & M); now apply upper_to_ok in M.
  Qed.

  Lemma clear_of_in c r : forall os vs, In r (clear_of (n k) c os vs) -> exists o ns, r = flat_map (beyond (n k) c o) ns.
  Proof. induction os as [|o os IH]; intros vs I; cbn in I; [easy|]. destruct I as [<-|I]; [eauto|now apply (IH (tl vs))]. Qed.
  Lemma clear_of_each c o : forall os vs, In o os -> exists ns, In (flat_map (beyond (n k) c o) ns) (clear_of (n k) c os vs).
  Proof.
    induction os as [|p os IH]; intros vs I; cbn [In clear_of] in *; [easy|]. destruct I as [->|I]; [eexists; left; reflexivity|].
    destruct (IH (tl vs) I) as (ns & J). exists ns. now right.
  Qed.
  Lemma facing_dims v e : forall m, In e (facing m v) -> (dim e < m)%nat.
  Proof.
    induction m as [|m IH]; intro I; cbn [facing] in I; [easy|].
    destruct (v m); [apply IH in I; lia| |]; (destruct I as [<-|I]; [cbn; lia|apply IH in I; lia]).
  Qed.

  Lemma inner_dims f a e : In a (inner (n k) f) -> In e (terms a) -> (dim e < n k)%nat.
  Proof. unfold inner; cbv zeta. destruct (_ && _)%bool; [|easy]. intros [<-|[]]. apply facing_dims. Qed.

  Lemma dims_along r a e : In r (along how k) -> In a r -> In e (terms a) -> (dim e < n k)%nat.
  Proof.
    unfold along; rewrite !in_app_iff, !in_map_iff, in_flat_map.
    intros [(i & <- & I)|[(i & I & [<-|[<-|[]]])|[(f & <- & _)|H]]].
    4: apply inner_dims.
    1,2,3: intros [<-|[]] [<-|[]]; cbn; apply in_seq in I; lia.
    apply clear_of_in in H; destruct H as (o & ns & ->). rewrite in_flat_map; intros (v & _ & J) K. unfold beyond in J.
    destruct (facing (n k) _) eqn:F; [easy|]. destruct J as [<-|[]]; cbn [terms] in K. rewrite <- F in K. now apply facing_dims in K.
  Qed.
  Lemma dims_first r a e : In r (first_ones k) -> In a r -> In e (terms a) -> (dim e < n k)%nat.
  Proof.
    unfold first_ones; rewrite in_flat_map; intros (i & I & H); apply in_seq in I.
    destruct H as [<-|[<-|[<-|[<-|[]]]]]; intros [<-|[]] [<-|[]]; cbn; lia.
  Qed.
  Lemma dims_last r a e : In r (last_ones k) -> In a r -> In e (terms a) -> (dim e < n k)%nat.
  Proof.
    unfold last_ones; rewrite in_app_iff, in_flat_map, in_map_iff.
    intros [(i & I & H)|(f & <- & _)]; [|apply inner_dims]. apply in_seq in I. destruct H as [<-|[<-|[]]]; intros [<-|[]] [<-|[]]; cbn; lia.
  Qed.

  Lemma facing_weighted low up v z m : weighted low up (Atom (facing m v) z) = total m (fun i => IZR (v i) * (if (0 <? v i)%Z then low i else up i)).
  Proof.
    unfold weighted; cbn [terms]. induction m as [|m IH]; cbn [facing total]; [reflexivity|].
    destruct (v m); cbn [fold_right dim wl wu Z.ltb Z.compare]; rewrite IH; ring.
  Qed.
  Lemma facing_nonzero v : forall m, facing m v <> [] -> exists i, (i < m)%nat /\ v i <> 0%Z.
  Proof.
    induction m as [|m IH]; cbn [facing]; [easy|]. intro H. destruct (v m) eqn:E.
    1: destruct (IH H) as (i & Hi & Ne); exists i; split; [lia|exact Ne].
    all: exists m; split; [lia|rewrite E; easy].
  Qed.
  Lemma norm_1_ok m v : IZR (norm_1 m v) = total m (fun i => Rabs (IZR (v i))).
  Proof. induction m as [|m IH]; cbn [norm_1 total]; [reflexivity|]. now rewrite plus_IZR, IH, abs_IZR. Qed.

  Let between (x : nat -> R) (t : R) : Prop := forall i, (i < n k)%nat -> L i t <= x i <= U i t.

  Lemma facing_ok v z x t : between x t -> meaning t (Atom (facing (n k) v) z) ->
    Q2R unit * IZR z <= total (n k) (fun i => IZR (v i) * x i) + Q2R err * total (n k) (fun i => Rabs (IZR (v i))).
  Proof.
    intros B M. unfold meaning in M. cbn [least] in M. rewrite facing_weighted in M. apply (Rle_trans _ _ _ M).
    rewrite <- total_scal, <- total_plus. apply total_le. intros i Hi. specialize (B i Hi). destruct (near' i t Hi) as [[L1 L2] [U1 U2]].
    destruct (Z.ltb_spec 0 (v i)) as [P|P].
    - apply IZR_lt in P. rewrite Rabs_pos_eq by lra.
      assert (IZR (v i) * lower i t <= IZR (v i) * (x i + Q2R err)) by (apply Rmult_le_compat_l; lra). lra.
    - apply IZR_le in P. rewrite Rabs_left1 by lra.
      assert (- IZR (v i) * (x i - Q2R err) <= - IZR (v i) * upper i t) by (apply Rmult_le_compat_l; lra). lra.
  Qed.

  Lemma inner_ok f x t : between x t -> (exists a, In a (inner (n k) f) /\ meaning t a) -> total (n k) (fun i => at_ (fst f) i * x i) <= Q2R (snd f).
  Proof.
    intros B (a & I & M). unfold inner in I. cbv zeta in I. set (d := fold_right _ _ _) in I. destruct (_ && _)%bool eqn:C; [|easy].
    rewrite andb_true_iff, forallb_forall in C. destruct C as [D W]. apply Z.ltb_lt, IZR_lt in D. destruct I as [<-|[]].
    apply (facing_ok _ _ x t B) in M. rewrite <- norm_1_ok in M.
    set (q := (err * _ - _)%Q) in M. pose proof (above_ok q) as A. unfold q in A at 1. rewrite Q2R_minus, !Q2R_mult, !Q2R_Z in A.
    rewrite (total_eq (n k) _ (fun i => - IZR d * (at_ (fst f) i * x i))) in M.
    - rewrite total_scal in M. apply (Rmult_le_reg_l (IZR d)); lra.
    - intros i Hi. assert (E := W i ltac:(apply in_seq; lia)). apply Qeq_bool_iff, Qeq_eqR in E. rewrite Q2R_mult, !Q2R_Z in E.
      rewrite opp_IZR, E. unfold at_. ring.
  Qed.

  Lemma beyond_ok o ns t : (exists a, In a (flat_map (beyond (n k) (clearance k) o) ns) /\ meaning t a) ->
    separated (n k) (Q2R (clearance k)) o (fun i => L i t) (fun i => U i t).
  Proof.
    intros (a & I & M). apply in_flat_map in I. destruct I as (v & _ & I). unfold beyond in I.
    set (w := fun i => nth i (fst v) 0%Z) in *. destruct (facing (n k) w) eqn:F; [easy|]. rewrite <- F in I.
    assert (Nz := facing_nonzero w (n k) ltac:(rewrite F; easy)). destruct I as [<-|[]].
    set (q := (support _ _ _ _ + _)%Q) in *. pose proof (above_ok q) as A. unfold q in A.
    rewrite Q2R_plus, Q2R_mult, Q2R_plus, Q2R_Z, norm_1_ok in A. fold q in A.
    exists (fun i => IZR (w i)). split.
    - destruct Nz as (i & Hi & Ne). exists i. split; [exact Hi|]. intro E. apply Ne. now apply eq_IZR.
    - intros x y Hx Hy. assert (B := support_ok (n k) w (snd v) o y Hy).
      assert (C := facing_ok w _ x t Hx M). lra.
  Qed.

  Theorem tube_sound :
    (* P1 *) (forall i t, (i < n k)%nat -> L i t + Q2R (min_width k) <= U i t) /\
    (* P2 *) (forall i, (i < n k)%nat -> L i 0 < at_ (x0 k) i < U i 0 /\ in_box (start k) i 0) /\
    (* P3 *) (forall i t, (i < n k)%nat -> in_box (space k) i t) /\
    (* P4 *) (forall o t, In o (unsafe k) -> separated (n k) (Q2R (clearance k)) o (fun i => L i t) (fun i => U i t)) /\
    (* P5 *) (forall i t, (i < n k)%nat -> Q2R (T k) <= t -> in_box (target k) i t) /\
    (* and where half-spaces cut *)
    (forall t x, (forall i, (i < n k)%nat -> L i t <= x i <= U i t) -> within_faces (n k) (walls k) x /\ (Q2R (T k) <= t -> within_faces (n k) (goals k) x)).
  Proof.
    pose proof checked as C; unfold check in C; cbv zeta in C.
    rewrite !andb_true_iff in C; destruct C as [[[_ HT] Rg] [[Ca Cs] Ce]].
    apply positive_ok in HT.
    assert (A := check_table_sound _ _ _ _ _ _ Rg unit_R HT dims_along Ca).
    assert (S := check_start_sound _ _ _ _ _ Rg unit_R HT dims_first Cs).
    assert (E := check_end_sound _ _ _ _ _ Rg unit_R HT dims_last Ce).
    split; [|split; [|split; [|split; [|split]]]].
    - intros i t Hi.
      destruct (A t [wide i (min_width k + 2 * err)%Q]) as (a & [<-|[]] & M).
      { unfold along; apply in_app_iff; left. apply (in_map (fun i => [wide i (min_width k + 2 * err)%Q])), in_seq; lia. }
      now apply wide_ok in M.
    - intros i Hi.
      assert (G : forall r, In r (around (x0 k) i ++ within (start k) i) -> exists a, In a r /\ meaning 0 a).
      { intros r I; apply S; unfold first_ones; apply in_flat_map; exists i; split; [apply in_seq; lia|exact I]. }
      split; [split|].
      + destruct (G _ (or_introl eq_refl)) as (a & [<-|[]] & M); now apply lower_below_ok in M.
      + destruct (G _ (or_intror (or_introl eq_refl))) as (a & [<-|[]] & M); now apply upper_beyond_ok in M.
      + apply within_ok; [exact Hi|]; intros r I; apply G, in_app_iff; now right.
    - intros i t Hi; apply within_ok; [exact Hi|]; intros r I; apply A; unfold along.
      rewrite !in_app_iff; right; left; apply in_flat_map; exists i; split; [apply in_seq; lia|exact I].
    - intros o t Ho. destruct (clear_of_each (clearance k) o (unsafe k) (normals how) Ho) as (ns & I).
      apply (beyond_ok o ns), A. unfold along; rewrite !in_app_iff; now do 3 right.
    - intros i t Hi Ht; apply within_ok; [exact Hi|]; intros r I; apply (E t Ht).
      unfold last_ones; apply in_app_iff; left; apply in_flat_map; exists i; split; [apply in_seq; lia|exact I].
    - intros t x B. split; [|intro Ht]; intros f F; apply (inner_ok f x t B).
      + apply A. unfold along; rewrite !in_app_iff; do 2 right; left. now apply in_map.
      + apply (E t Ht). unfold last_ones; rewrite in_app_iff; right. now apply in_map.
  Qed.

  (* and so of every state strictly inside *)
  Lemma tube_keeps t x : (forall i, (i < n k)%nat -> L i t < x i < U i t) ->
    in_space k x /\ (forall o, In o (unsafe k) -> clear (n k) (Q2R (clearance k)) o x) /\ (Q2R (T k) <= t -> in_target k x).
  Proof.
    intro I. destruct tube_sound as (_ & _ & P3 & P4 & P5 & P). destruct (P t x) as [W G]; [intros i Hi; specialize (I i Hi); lra|].
    split; [split; [|exact W]|split].
    - intros i Hi. destruct (I i Hi), (P3 i t Hi). lra.
    - intros o Ho. exact (separated_clear _ _ _ _ _ _ (P4 o t Ho) I).
    - intro Ht. split; [|exact (G Ht)]. intros i Hi. destruct (I i Hi), (P5 i t Hi Ht). lra.
  Qed.
End Compile.

