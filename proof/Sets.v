(* Convex sets that do not move: membership, a bound on how far a set reaches along a normal, and what it means to be clear of a set.

   Tube.v checks with it that a tube is separated from every unsafe set (P4). The words are those of docs/theorem.md; the lemma book has
   the geometry as `shapes.*` (docs/lemmas.md). *)
From Coq Require Import ZArith QArith Qreals Qabs Qminmax Reals List Bool Lia Lra Psatz.
Import ListNotations.
Open Scope R_scope.

(* A box by its lower and its upper corner; a coordinate that a list lacks is 0. *)
Record box := Box { lower_corner : list Q; upper_corner : list Q }.
(* Number i of a list of rationals, as a real number; 0 beyond the end of the list. *)
Definition real_at (l : list Q) (i : nat) : R := Q2R (nth i l 0%Q).
(* The sum of u 0 .. u (m - 1). *)
Fixpoint total (m : nat) (u : nat -> R) : R := match m with O => 0 | S j => u j + total j u end.

(* ------------------------------------------------------------------ membership *)

(* Point x is within all half-spaces (normal, offset): normal . x <= offset. *)
Definition within_half_spaces (n : nat) (half_spaces : list (list Q * Q)) (x : nat -> R) : Prop :=
  forall h, In h half_spaces -> total n (fun i => real_at (fst h) i * x i) <= Q2R (snd h).

(* The core of a set: the convex hull of points, or the part of a box that is within half-spaces. *)
Inductive core := Hull (points : list (list Q)) | Cut (bounds : box) (half_spaces : list (list Q * Q)).

(* A set: all sums of a point of its core, a point of a box, and a point of a ball in the dimensions `ball_axes`. *)
Record shape := Shape { shape_core : core; shape_box : box; ball_axes : list nat; ball_radius : Q }.

(* A box alone, as a set: its core is the origin and its ball has radius 0. *)
Definition shape_of_box (b : box) : shape := Shape (Hull [[]]) b [] 0.

(* Coordinate i of the combination of points with these weights. *)
Definition convex_combination (weights : list R) (points : list (list Q)) (i : nat) : R :=
  fold_right Rplus 0 (map (fun wp => fst wp * real_at (snd wp) i) (combine weights points)).

(* Point q is in the core. *)
Definition in_core (n : nat) (c : core) (q : nat -> R) : Prop :=
  match c with
  | Hull points => exists weights, length weights = length points /\ (forall w, In w weights -> 0 <= w) /\ fold_right Rplus 0 weights = 1 /\
      forall i, (i < n)%nat -> q i = convex_combination weights points i
  | Cut bounds half_spaces => (forall i, (i < n)%nat -> real_at (lower_corner bounds) i <= q i <= real_at (upper_corner bounds) i) /\ within_half_spaces n half_spaces q
  end.

(* Point y is in the set: y = q + b + r with q in the core, b in the box and r in the ball. *)
Definition in_set (n : nat) (set : shape) (y : nat -> R) : Prop := exists q b r : nat -> R,
  in_core n (shape_core set) q /\
  (forall i, (i < n)%nat -> real_at (lower_corner (shape_box set)) i <= b i <= real_at (upper_corner (shape_box set)) i) /\
  (forall i, (i < n)%nat -> ~ In i (ball_axes set) -> r i = 0) /\ total n (fun i => (r i)^2) <= (Q2R (ball_radius set))^2 /\
  forall i, (i < n)%nat -> y i = q i + b i + r i.

(* State x is clear of a set: from every point of the set it is farther away than the clearance in some dimension, which may differ from
   point to point. *)
Definition clear (n : nat) (clearance : R) (set : shape) (x : nat -> R) : Prop :=
  forall y, in_set n set y -> exists i, (i < n)%nat /\ clearance < Rabs (x i - y i).

(* The box [L, U] is separated from a set: along some normal every point of the box is beyond every point of the set, by the clearance
   times the 1-norm of the normal. *)
Definition separated (n : nat) (clearance : R) (set : shape) (L U : nat -> R) : Prop :=
  exists normal : nat -> R, (exists i, (i < n)%nat /\ normal i <> 0) /\
    forall x y, (forall i, (i < n)%nat -> L i <= x i <= U i) -> in_set n set y ->
      total n (fun i => normal i * y i) + clearance * total n (fun i => Rabs (normal i)) <= total n (fun i => normal i * x i).

(* ------------------------------------------------------------------ sums *)

Lemma total_le n u w : (forall i, (i < n)%nat -> u i <= w i) -> total n u <= total n w.
Proof. induction n; intro H; cbn; [lra|]. assert (A := H n ltac:(lia)). assert (total n u <= total n w) by (apply IHn; intros; apply H; lia). lra. Qed.
Lemma total_eq n u w : (forall i, (i < n)%nat -> u i = w i) -> total n u = total n w.
Proof. intro H. apply Rle_antisym; apply total_le; intros i Hi; rewrite (H i Hi); lra. Qed.
Lemma total_lt n u w : (forall i, (i < n)%nat -> u i <= w i) -> (exists i, (i < n)%nat /\ u i < w i) -> total n u < total n w.
Proof.
  induction n; intros H (i & Hi & E); [lia|]. cbn. assert (A := H n ltac:(lia)).
  assert (B : forall j, (j < n)%nat -> u j <= w j) by (intros; apply H; lia). assert (C := total_le n u w B).
  destruct (Nat.eq_dec i n) as [->|Ne]; [lra|]. assert (total n u < total n w); [|lra]. apply IHn; [exact B|]. exists i. split; [lia|exact E].
Qed.
Lemma total_plus n u w : total n (fun i => u i + w i) = total n u + total n w.
Proof. induction n; cbn; [ring|rewrite IHn; ring]. Qed.
Lemma total_scale n a u : total n (fun i => a * u i) = a * total n u.
Proof. induction n; cbn; [ring|rewrite IHn; ring]. Qed.
Lemma total_zero n : total n (fun _ => 0) = 0.
Proof. induction n; cbn; lra. Qed.

(* A decidable property holds for some index below n, or for none. *)
Lemma exists_or_forall_not n (P : nat -> Prop) : (forall i, {P i} + {~ P i}) -> (exists i, (i < n)%nat /\ P i) \/ forall i, (i < n)%nat -> ~ P i.
Proof.
  intro D. induction n as [|n [(i & Hi & E)|N]]; [right; lia|left; exists i; split; [lia|exact E]|].
  destruct (D n) as [E|E]; [left; exists n; split; [lia|exact E]|]. right. intros i Hi. destruct (Nat.eq_dec i n) as [->|Ne]; [exact E|apply N; lia].
Qed.

(* A state strictly inside a box that is separated from a set is clear of the set. *)
Lemma strictly_inside_separated_is_clear n clearance set L U x : separated n clearance set L U -> (forall i, (i < n)%nat -> L i < x i < U i) -> clear n clearance set x.
Proof.
  intros (v & Nz & S) I y Y. destruct (exists_or_forall_not n (fun i => clearance < Rabs (x i - y i))) as [E|N]; [intro; apply Rlt_dec|exact E|]. exfalso.
  set (corner := fun i => if Rlt_dec 0 (v i) then L i else U i).
  assert (A := S corner y ltac:(intros i Hi; specialize (I i Hi); unfold corner; destruct Rlt_dec; lra) Y).
  assert (B : total n (fun i => v i * corner i) < total n (fun i => v i * x i)).
  { apply total_lt.
    - intros i Hi. specialize (I i Hi). unfold corner. destruct Rlt_dec; [apply Rmult_le_compat_l; lra|]. nra.
    - destruct Nz as (i & Hi & Ne). exists i. split; [exact Hi|]. specialize (I i Hi). unfold corner. destruct Rlt_dec; [apply Rmult_lt_compat_l; lra|]. nra. }
  assert (C : total n (fun i => v i * x i) <= total n (fun i => v i * y i + clearance * Rabs (v i))).
  { apply total_le. intros i Hi. specialize (N i Hi). cbv beta in N. apply Rnot_lt_le in N.
    assert (v i * (x i - y i) <= Rabs (v i) * clearance); [|lra].
    apply Rle_trans with (Rabs (v i * (x i - y i))); [apply Rle_abs|]. rewrite Rabs_mult. apply Rmult_le_compat_l; [apply Rabs_pos|exact N]. }
  rewrite total_plus, total_scale in C. lra.
Qed.

(* For a box alone, membership means being between its corners. *)
Lemma in_set_shape_of_box n b y : in_set n (shape_of_box b) y <-> forall i, (i < n)%nat -> real_at (lower_corner b) i <= y i <= real_at (upper_corner b) i.
Proof.
  assert (O : forall i, real_at [] i = 0) by (intro; unfold real_at; destruct i; cbn; unfold Q2R; cbn; lra).
  split.
  - intros (q & e & r & (ws & Len & _ & SumsTo1 & Hq) & He & Hr & _ & Y) i Hi. rewrite (Y i Hi), (Hq i Hi), (Hr i Hi) by easy.
    destruct ws as [|w [|]]; try easy. unfold convex_combination. cbn. rewrite O. specialize (He i Hi). cbn in He. lra.
  - intro H. exists (fun _ => 0), y, (fun _ => 0). split; [|split; [exact H|split; [easy|split; [|intros; ring]]]].
    + exists [1]. split; [reflexivity|split; [intros w [<-|[]]; lra|split; [cbn; lra|]]]. intros. unfold convex_combination. cbn. rewrite O. lra.
    + rewrite (total_eq n _ (fun _ => 0)) by (intros; ring). rewrite total_zero. apply pow2_ge_0.
Qed.

(* For a box alone, being clear means being beyond one of its faces by more than the clearance. No proof uses this: it shows readers that
   `clear` means what it should. *)
Lemma clear_shape_of_box n c b x : 0 <= c -> (forall i, (i < n)%nat -> real_at (lower_corner b) i <= real_at (upper_corner b) i) ->
  clear n c (shape_of_box b) x <-> exists i, (i < n)%nat /\ (x i < real_at (lower_corner b) i - c \/ real_at (upper_corner b) i + c < x i).
Proof.
  intros C0 B. split.
  - intro C. destruct (C (fun i => Rmax (real_at (lower_corner b) i) (Rmin (real_at (upper_corner b) i) (x i)))) as (i & Hi & E).
    + apply in_set_shape_of_box. intros i Hi. specialize (B i Hi). unfold Rmax, Rmin. repeat destruct Rle_dec; lra.
    + exists i. split; [exact Hi|]. specialize (B i Hi). revert E. unfold Rmax, Rmin, Rabs. repeat destruct Rle_dec; destruct Rcase_abs; lra.
  - intros (i & Hi & D) y Y. exists i. split; [exact Hi|]. rewrite in_set_shape_of_box in Y. specialize (Y i Hi). unfold Rabs. destruct Rcase_abs; lra.
Qed.

(* ------------------------------------------------------------------ how far a set reaches, in rationals *)

(* The sum of u 0 .. u (m - 1), in rationals. *)
Fixpoint total_rational (m : nat) (u : nat -> Q) : Q := match m with O => 0%Q | S j => (u j + total_rational j u)%Q end.
(* v q, without work where v is 0: most entries of a normal are 0. *)
Definition product_skipping_zero (v q : Q) : Q := match Qnum v with Z0 => 0%Q | _ => (v * q)%Q end. (* factors of 0 are most, and cost nothing *)

(* How far a box reaches along a normal. *)
Definition box_support (n : nat) (normal : nat -> Q) (b : box) : Q :=
  total_rational n (fun i => product_skipping_zero (normal i) (nth i (if (0 <? Qnum (normal i))%Z then upper_corner b else lower_corner b) 0%Q)).

(* The largest number of a list; 0 if it is empty. *)
Definition maximum (l : list Q) : Q := match l with [] => 0%Q | a :: r => fold_right Qmax a r end.

(* Entry i of the sum of the half-spaces' normals, each times its multiplier. A negative multiplier counts as 0. *)
Fixpoint combined_normal (half_spaces : list (list Q * Q)) (multipliers : list Q) (i : nat) : Q :=
  match half_spaces, multipliers with f :: half_spaces, m :: multipliers => (Qmax 0 m * nth i (fst f) 0 + combined_normal half_spaces multipliers i)%Q | _, _ => 0%Q end.
(* The sum of the half-spaces' offsets, each times its multiplier. *)
Fixpoint combined_offset (half_spaces : list (list Q * Q)) (multipliers : list Q) : Q :=
  match half_spaces, multipliers with f :: half_spaces, m :: multipliers => (Qmax 0 m * snd f + combined_offset half_spaces multipliers)%Q | _, _ => 0%Q end.

(* A bound on how far a core reaches along a normal. For half-spaces any multipliers give a bound; by duality of linear programs some
   give the exact value. *)
Definition core_support_bound (n : nat) (normal : nat -> Q) (multipliers : list Q) (c : core) : Q :=
  match c with
  | Hull points => maximum (map (fun p => total_rational n (fun i => product_skipping_zero (normal i) (nth i p 0%Q))) points)
  | Cut bounds half_spaces => (combined_offset half_spaces multipliers + box_support n (fun i => Qred (normal i - combined_normal half_spaces multipliers i)) bounds)%Q
  end.

(* The sum of v_i^2 over these dimensions. *)
Fixpoint sum_of_squares (n : nat) (normal : nat -> Z) (axes : list nat) : Z :=
  match n with O => 0%Z | S j => ((if existsb (Nat.eqb j) axes then normal j * normal j else 0) + sum_of_squares j normal axes)%Z end.
(* The Euclidean norm of v in these dimensions, rounded up to a multiple of 2^-32. *)
Definition euclidean_norm_above (n : nat) (normal : nat -> Z) (axes : list nat) : Q := (Z.sqrt_up (sum_of_squares n normal axes * 2 ^ 64) # 4294967296)%Q.

(* A bound on how far a set reaches along a normal: of its core, its box and its ball. *)
Definition support_bound (n : nat) (normal : nat -> Z) (multipliers : list Q) (set : shape) : Q :=
  (core_support_bound n (fun i => inject_Z (normal i)) multipliers (shape_core set) + box_support n (fun i => inject_Z (normal i)) (shape_box set) + Qabs (ball_radius set) * euclidean_norm_above n normal (ball_axes set))%Q.

Lemma total_rational_value n u : Q2R (total_rational n u) = total n (fun i => Q2R (u i)).
Proof. induction n; cbn; [unfold Q2R; cbn; lra|]. now rewrite Q2R_plus, IHn. Qed.

Lemma product_skipping_zero_value v q : Q2R (product_skipping_zero v q) = Q2R v * Q2R q.
Proof. unfold product_skipping_zero. destruct v as [[|p|p] d]; cbn [Qnum]; rewrite ?Q2R_mult; try reflexivity. unfold Q2R; cbn. ring. Qed.

Lemma box_support_bounds n v b y : (forall i, (i < n)%nat -> real_at (lower_corner b) i <= y i <= real_at (upper_corner b) i) ->
  total n (fun i => Q2R (v i) * y i) <= Q2R (box_support n v b).
Proof.
  intro H. unfold box_support. rewrite total_rational_value. apply total_le. intros i Hi. specialize (H i Hi). rewrite product_skipping_zero_value. unfold real_at in H.
  assert (D : 0 < / IZR (Zpos (Qden (v i)))) by (apply Rinv_0_lt_compat, (IZR_lt 0); reflexivity).
  assert (V : Q2R (v i) = IZR (Qnum (v i)) * / IZR (Zpos (Qden (v i)))) by reflexivity.
  destruct (Z.ltb_spec 0 (Qnum (v i))) as [P|P].
  - apply IZR_lt in P. assert (0 <= Q2R (v i)) by (rewrite V; apply Rmult_le_pos; lra). apply Rmult_le_compat_l; lra.
  - apply IZR_le in P. assert (Q2R (v i) <= 0) by (rewrite V, <- (Rmult_0_l (/ IZR (Zpos (Qden (v i))))); apply Rmult_le_compat_r; lra). nra.
Qed.

Lemma Qmax_bounds a b : Q2R a <= Q2R (Qmax a b) /\ Q2R b <= Q2R (Qmax a b).
Proof. split; apply Qle_Rle; [apply Q.le_max_l|apply Q.le_max_r]. Qed.

Lemma maximum_bounds q l : In q l -> Q2R q <= Q2R (maximum l).
Proof.
  destruct l as [|a r]; [easy|]. cbn [maximum]. revert a. induction r as [|b r IH]; intros a I; cbn.
  - destruct I as [->|[]]; lra.
  - destruct (Qmax_bounds b (fold_right Qmax a r)) as [A B]. destruct I as [->|[->|I]]; [|exact A|]; (eapply Rle_trans; [|exact B]); apply IH; [now left|now right].
Qed.

Lemma total_of_convex_combination n v : forall ws points,
  total n (fun i => v i * convex_combination ws points i) = fold_right Rplus 0 (map (fun wp => fst wp * total n (fun i => v i * real_at (snd wp) i)) (combine ws points)).
Proof.
  induction ws as [|w ws IH]; intros [|p points]; unfold convex_combination in *; cbn [combine map fold_right fst snd];
    try (rewrite (total_eq n _ (fun _ => 0)) by (intros; ring); apply total_zero).
  rewrite <- IH, <- total_scale, <- total_plus. apply total_eq. intros; ring.
Qed.

Lemma weighted_sum_below (A : Type) (g : A -> R) m : forall ws (l : list A), (forall w, In w ws -> 0 <= w) -> (forall a, In a l -> g a <= m) -> length ws = length l ->
  fold_right Rplus 0 (map (fun wp => fst wp * g (snd wp)) (combine ws l)) <= fold_right Rplus 0 ws * m.
Proof.
  induction ws as [|w ws IH]; intros [|a l] W G Len; cbn in *; try easy; [lra|].
  assert (B := IH l ltac:(auto) ltac:(auto) ltac:(lia)). assert (w * g a <= w * m) by (apply Rmult_le_compat_l; auto). lra.
Qed.

Lemma combined_half_space_holds n q : forall faces ms, within_half_spaces n faces q ->
  total n (fun i => Q2R (combined_normal faces ms i) * q i) <= Q2R (combined_offset faces ms).
Proof.
  assert (Z0 : Q2R 0 = 0) by (unfold Q2R; cbn; lra).
  induction faces as [|f faces IH]; intros [|m ms] H; cbn [combined_normal combined_offset]; rewrite ?Z0;
    try (rewrite (total_eq n _ (fun _ => 0)) by (intros; ring); rewrite total_zero; lra).
  rewrite Q2R_plus, Q2R_mult. specialize (IH ms ltac:(intros g G; apply H; now right)). destruct (Qmax_bounds 0 m) as [M _]. rewrite Z0 in M.
  rewrite (total_eq n _ (fun i => Q2R (Qmax 0 m) * (real_at (fst f) i * q i) + Q2R (combined_normal faces ms i) * q i)).
  - rewrite total_plus, total_scale. apply Rplus_le_compat; [apply Rmult_le_compat_l; [exact M|apply H; now left]|exact IH].
  - intros i _. rewrite Q2R_plus, Q2R_mult. unfold real_at. ring.
Qed.

Lemma core_support_bounds n v ms c q : in_core n c q -> total n (fun i => Q2R (v i) * q i) <= Q2R (core_support_bound n v ms c).
Proof.
  destruct c as [points|bounds faces]; cbn [in_core core_support_bound].
  - intros (ws & Len & Pos & SumsTo1 & Hq).
    rewrite (total_eq n _ (fun i => Q2R (v i) * convex_combination ws points i)) by (intros i Hi; now rewrite Hq).
    rewrite total_of_convex_combination. set (m := maximum _). replace (Q2R m) with (fold_right Rplus 0 ws * Q2R m) by (rewrite SumsTo1; ring).
    apply (weighted_sum_below _ (fun p => total n (fun i => Q2R (v i) * real_at p i))); [exact Pos| |exact Len].
    intros p Hp. eapply Rle_trans; [|apply maximum_bounds, (in_map _ _ _ Hp)]. cbv beta. rewrite total_rational_value. apply total_le. intros i _. rewrite product_skipping_zero_value. unfold real_at. lra.
  - intros [B F]. rewrite Q2R_plus.
    rewrite (total_eq n _ (fun i => Q2R (combined_normal faces ms i) * q i + Q2R (Qred (v i - combined_normal faces ms i)) * q i)).
    + rewrite total_plus. apply Rplus_le_compat; [now apply combined_half_space_holds|now apply box_support_bounds].
    + intros i _. rewrite (Qeq_eqR _ _ (Qred_correct _)), Q2R_minus. ring.
Qed.

Lemma cauchy_schwarz n u w : (total n (fun i => u i * w i))^2 <= total n (fun i => (u i)^2) * total n (fun i => (w i)^2).
Proof.
  induction n; cbn [total]; [lra|].
  set (A := total n (fun i => u i * w i)) in *. set (S := total n (fun i => (u i)^2)) in *. set (T := total n (fun i => (w i)^2)) in *.
  assert (HS : 0 <= S) by (unfold S; rewrite <- (total_zero n); apply total_le; intros; apply pow2_ge_0).
  assert (HT : 0 <= T) by (unfold T; rewrite <- (total_zero n); apply total_le; intros; apply pow2_ge_0).
  clearbody A S T. set (a := u n). set (b := w n). clearbody a b.
  assert (K : 0 <= a^2 * T + b^2 * S - 2 * (A * (a * b))); [|lra].
  destruct (Req_dec T 0) as [->|Ne].
  - assert (A = 0) as -> by nra. assert (0 <= b^2 * S) by (apply Rmult_le_pos; [apply pow2_ge_0|exact HS]). lra.
  - assert (E : 0 <= T * (a^2 * T + b^2 * S - 2 * (A * (a * b)))); [|nra].
    assert (0 <= (a * T - b * A)^2) by apply pow2_ge_0. assert (b^2 * A^2 <= b^2 * (S * T)) by (apply Rmult_le_compat_l; [apply pow2_ge_0|exact IHn]). nra.
Qed.

Lemma sum_of_squares_value n v axes : IZR (sum_of_squares n v axes) = total n (fun i => (if existsb (Nat.eqb i) axes then IZR (v i) else 0)^2).
Proof. induction n; cbn [sum_of_squares total]; [reflexivity|]. rewrite plus_IZR, IHn. destruct existsb; rewrite ?mult_IZR; ring. Qed.

Lemma euclidean_norm_above_bounds n v axes : 0 <= Q2R (euclidean_norm_above n v axes) /\ IZR (sum_of_squares n v axes) <= (Q2R (euclidean_norm_above n v axes))^2.
Proof.
  unfold euclidean_norm_above. set (s := sum_of_squares n v axes). set (w := Z.sqrt_up (s * 2 ^ 64)). assert (W := Z.sqrt_up_nonneg (s * 2 ^ 64)). fold w in W.
  assert (V : Q2R (w # 4294967296) = IZR w * / 4294967296) by reflexivity. rewrite V.
  assert (W' := IZR_le _ _ W). split; [apply Rmult_le_pos; lra|].
  assert (H : (s * 2 ^ 64 <= w * w)%Z).
  { destruct (Z_lt_le_dec 0 (s * 2 ^ 64)) as [P|N]; [apply (Z.sqrt_up_spec _ P)|nia]. }
  apply IZR_le in H. rewrite !mult_IZR in H. change (IZR (2 ^ 64)) with 18446744073709551616 in H. nra.
Qed.

Lemma ball_support_bounds n v axes r rho : (forall i, (i < n)%nat -> ~ In i axes -> r i = 0) -> total n (fun i => (r i)^2) <= rho^2 ->
  total n (fun i => IZR (v i) * r i) <= Rabs rho * Q2R (euclidean_norm_above n v axes).
Proof.
  intros O B. set (masked_normal := fun i => if existsb (Nat.eqb i) axes then IZR (v i) else 0).
  rewrite (total_eq n _ (fun i => masked_normal i * r i)).
  - destruct (euclidean_norm_above_bounds n v axes) as [W S]. rewrite sum_of_squares_value in S. fold masked_normal in S. assert (C := cauchy_schwarz n masked_normal r).
    change (fun i => (if existsb (Nat.eqb i) axes then IZR (v i) else 0)^2) with (fun i => (masked_normal i)^2) in S.
    set (A := total n (fun i => masked_normal i * r i)) in *. set (T := total n (fun i => (masked_normal i)^2)) in *. set (R := total n (fun i => (r i)^2)) in *.
    set (w := Q2R (euclidean_norm_above n v axes)) in *. assert (P := Rabs_pos rho).
    assert (E : A^2 <= (Rabs rho * w)^2).
    { rewrite Rpow_mult_distr, <- Rsqr_pow2 with (x := Rabs rho), <- Rsqr_abs, Rsqr_pow2. apply Rle_trans with (1 := C). rewrite Rmult_comm.
      apply Rmult_le_compat; [|unfold T|exact B|exact S]; [unfold R|]; rewrite <- (total_zero n); apply total_le; intros; apply pow2_ge_0. }
    apply Rnot_lt_le. intro Q. assert (0 <= Rabs rho * w) by (apply Rmult_le_pos; assumption). nra.
  - intros i Hi. unfold masked_normal. destruct (existsb (Nat.eqb i) axes) eqn:E; [reflexivity|].
    rewrite O; [ring|exact Hi|]. intro I. assert (existsb (Nat.eqb i) axes = true) by (apply existsb_exists; exists i; split; [exact I|apply Nat.eqb_refl]). congruence.
Qed.

Lemma Q2R_integer z : Q2R (inject_Z z) = IZR z. Proof. unfold Q2R; cbn; lra. Qed.

(* No point of the set is farther along the normal than `support_bound` says. *)
Theorem support_bounds n normal multipliers set y : in_set n set y -> total n (fun i => IZR (normal i) * y i) <= Q2R (support_bound n normal multipliers set).
Proof.
  intros (q & b & r & Hq & Hb & Ho & Hr & Y). unfold support_bound. rewrite !Q2R_plus, Q2R_mult.
  rewrite (total_eq n _ (fun i => (Q2R (inject_Z (normal i)) * q i + Q2R (inject_Z (normal i)) * b i) + IZR (normal i) * r i)).
  - rewrite !total_plus. apply Rplus_le_compat; [apply Rplus_le_compat|].
    + now apply core_support_bounds.
    + now apply box_support_bounds.
    + assert (E : Q2R (Qabs (ball_radius set)) = Rabs (Q2R (ball_radius set))).
      { destruct (Qlt_le_dec (ball_radius set) 0) as [L|L].
        - rewrite (Qeq_eqR _ _ (Qabs_neg _ (Qlt_le_weak _ _ L))), Q2R_opp. apply Qlt_Rlt in L. replace (Q2R 0) with 0 in L by (unfold Q2R; cbn; lra). rewrite Rabs_left; lra.
        - rewrite (Qeq_eqR _ _ (Qabs_pos _ L)). apply Qle_Rle in L. replace (Q2R 0) with 0 in L by (unfold Q2R; cbn; lra). rewrite Rabs_pos_eq; lra. }
      rewrite E. now apply ball_support_bounds.
  - intros i Hi. rewrite (Y i Hi), Q2R_integer. ring.
Qed.
