(* How fast the edges are, from the differences of neighbouring Bezier coefficients; then the closed loop of Loop.v with the tube
   of Tube.v: reach, avoid and stay in continuous time. *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core.Raux.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop.
Import ListNotations.
Open Scope R_scope.

Definition flat (V : Z) (c : bez) : bool :=
  ((Z.abs (c1 c - c0 c) <=? V) && (Z.abs (c2 c - c1 c) <=? V) && (Z.abs (c3 c - c2 c) <=? V))%Z.
Definition steep (V : Z) (i : nat) (rows : table) : bool :=
  forallb (fun p => let c := nth i p (zero_bez, zero_bez) in flat V (fst c) && flat V (snd c)) (pieces rows).

(* What reach_avoid_stay and its followers ask beyond `check`, also decided by evaluation. *)
Definition slopes (err : Q) (k : task) (rows : table) (Vs : list Z) : bool :=
  (positive (min_width k) && Qle_bool 0 err && forallb (fun i => steep (nth i Vs 0%Z) i rows) (seq 0 (n k)))%bool.

Lemma Zabs_IZR a V : (Z.abs a <= V)%Z -> - IZR V <= IZR a <= IZR V.
Proof. intro H; apply Z.abs_le in H; rewrite <- opp_IZR; split; apply IZR_le; lia. Qed.

Lemma flat_ok V c s r : flat V c = true -> 0 <= s <= 1 -> 0 <= r <= 1 ->
  Rabs (bernstein c r - bernstein c s) <= 3 * IZR V * Rabs (r - s).
Proof.
  unfold flat; rewrite !andb_true_iff, !Z.leb_le; intros [[A B] C] Hs Hr.
  apply Zabs_IZR in A, B, C; rewrite minus_IZR in A, B, C.
  set (a0 := IZR (c1 c) - IZR (c0 c)) in *. set (a1 := IZR (c2 c) - IZR (c1 c)) in *. set (a2 := IZR (c3 c) - IZR (c2 c)) in *.
  set (d := fun x y => a0 * ((1-x)*(1-y)) + a1 * (x*(1-y) + y*(1-x)) + a2 * (x*y)).
  assert (E : bernstein c r - bernstein c s = (r - s) * (d s s + d s r + d r r)).
  { unfold bernstein, d, a0, a1, a2; ring. }
  assert (D : forall x y, 0 <= x <= 1 -> 0 <= y <= 1 -> - IZR V <= d x y <= IZR V).
  { intros x y Hx Hy; unfold d.
    assert (0 <= (1-x)*(1-y)) by (apply Rmult_le_pos; lra).
    assert (0 <= x*(1-y) + y*(1-x)) by (apply Rplus_le_le_0_compat; apply Rmult_le_pos; lra).
    assert (0 <= x*y) by (apply Rmult_le_pos; lra).
    assert (G : forall v, v = v * ((1-x)*(1-y)) + v * (x*(1-y) + y*(1-x)) + v * (x*y)) by (intro; ring).
    split.
    - rewrite (G (- IZR V)); repeat apply Rplus_le_compat; apply Rmult_le_compat_r; lra.
    - rewrite (G (IZR V)); repeat apply Rplus_le_compat; apply Rmult_le_compat_r; lra. }
  rewrite E, Rabs_mult, Rmult_comm. apply Rmult_le_compat_r; [apply Rabs_pos|].
  apply Rabs_le. pose proof (D s s Hs Hs). pose proof (D s r Hs Hr). pose proof (D r r Hr Hr). lra.
Qed.

Section Column.
  Variables (rows : table) (n i : nat) (V : Z) (side : Z * Z -> Z) (of : bez * bez -> bez).
  Hypothesis Rg : regular n rows = true.
  Hypothesis Hi : (i < n)%nat.
  Hypothesis sides : (side = fst /\ of = fst) \/ (side = snd /\ of = snd).
  Hypothesis St : steep V i rows = true.
  Let K := segments rows.
  Let S (u : R) := spline (column side i rows) u.
  Let B (k : nat) := of (nth i (nth k (pieces rows) []) (zero_bez, zero_bez)).

  Lemma side0 : side (0, 0)%Z = 0%Z. Proof. destruct sides as [[-> _]|[-> _]]; reflexivity. Qed.
  Lemma K_pos : (0 < K)%nat. Proof. destruct (regular_ok _ _ Rg); unfold K, segments; lia. Qed.

  Lemma B_value k : (k < K)%nat ->
    B k = to_bez (side (nth i (nth k rows []) (0,0)%Z)) (side (nth i (nth (k+1) rows []) (0,0)%Z))
                 (side (nth i (nth (k+2) rows []) (0,0)%Z)) (side (nth i (nth (k+3) rows []) (0,0)%Z)).
  Proof.
    intro H; destruct (regular_ok _ _ Rg) as [_ Ln]; unfold K, segments in H; unfold B.
    rewrite pieces_nth by (unfold segments; lia). rewrite (make_piece_nth n) by (try apply Ln; lia).
    destruct sides as [[-> ->]|[-> ->]]; reflexivity.
  Qed.

  Lemma S_segment u : 0 <= u <= INR K -> S u = bernstein (B (segment K u)) (u - INR (segment K u)).
  Proof.
    intro Hu. destruct (segment_place K u K_pos Hu) as [Hk _].
    unfold S, spline. replace (length (column side i rows) - 3)%nat with K by (unfold K, segments, column; now rewrite map_length).
    cbv zeta. rewrite !column_nth by exact side0. rewrite B_value by exact Hk. apply cubic_bezier.
  Qed.

  Lemma S_piece k u : (k < K)%nat -> INR k <= u <= INR k + 1 -> S u = bernstein (B k) (u - INR k).
  Proof.
    intros Hk Hu.
    assert (INR k + 1 <= INR K) by (rewrite <- S_INR; apply le_INR; lia). pose proof (pos_INR k).
    rewrite S_segment by lra.
    destruct (segment_place K u K_pos ltac:(lra)) as [Hs Hp]. set (m := segment K u) in *.
    assert (Cases : m = k \/ (m = (k + 1)%nat /\ u = INR k + 1) \/ ((m + 1)%nat = k /\ u = INR k)).
    { destruct (Nat.lt_trichotomy m k) as [C|[C|C]]; [right; right|now left|right; left].
      - assert (m + 1 <= k)%nat by lia. assert (INR (m + 1) <= INR k) by now apply le_INR.
        rewrite plus_INR in *; cbn [INR] in *. assert (E : INR (m + 1) = INR k) by (rewrite plus_INR; cbn [INR]; lra).
        apply INR_eq in E. split; [exact E|lra].
      - assert (INR (k + 1) <= INR m) by (apply le_INR; lia). rewrite plus_INR in *; cbn [INR] in *.
        assert (E : INR m = INR (k + 1)) by (rewrite plus_INR; cbn [INR]; lra). apply INR_eq in E. split; [exact E|lra]. }
    destruct Cases as [->|[[E ->]|[E ->]]]; [reflexivity| |].
    - rewrite E, !B_value by lia. rewrite plus_INR; cbn [INR].
      replace (k + 1 + 1)%nat with (k + 2)%nat by lia. replace (k + 1 + 2)%nat with (k + 3)%nat by lia.
      unfold bernstein, to_bez; cbn [c0 c1 c2 c3]; izr; ring.
    - rewrite <- E, !B_value by lia. rewrite plus_INR; cbn [INR].
      replace (m + 1 + 1)%nat with (m + 2)%nat by lia. replace (m + 1 + 2)%nat with (m + 3)%nat by lia.
      unfold bernstein, to_bez; cbn [c0 c1 c2 c3]; izr; ring.
  Qed.

  Lemma B_flat k : (k < K)%nat -> flat V (B k) = true.
  Proof.
    intro Hk. pose proof St as H. unfold steep in H. rewrite forallb_forall in H.
    assert (A := H (nth k (pieces rows) []) ltac:(apply nth_In; now rewrite pieces_length)).
    cbv zeta in A. apply andb_true_iff in A. unfold B; destruct sides as [[_ ->]|[_ ->]]; apply A.
  Qed.

  Lemma V_nonneg : 0 <= IZR V.
  Proof.
    assert (A := B_flat 0 K_pos). unfold flat in A. rewrite !andb_true_iff, !Z.leb_le in A. destruct A as [[A _] _].
    apply Zabs_IZR in A; lra.
  Qed.

  Lemma S_lip k : (k <= K)%nat -> forall u r, 0 <= u -> u <= r -> r <= INR k -> Rabs (S r - S u) <= 3 * IZR V * (r - u).
  Proof.
    pose proof V_nonneg as V0.
    induction k; intros Hk u r H0 H1 H2.
    - cbn in H2. assert (r = u) as -> by lra. rewrite Rminus_diag_eq, Rabs_R0 by reflexivity. lra.
    - rewrite S_INR in H2.
      assert (P : forall a b, INR k <= a -> a <= b -> b <= INR k + 1 -> Rabs (S b - S a) <= 3 * IZR V * (b - a)).
      { intros a b Ha Hab Hb. rewrite !(S_piece k) by (lia || lra).
        replace (b - a) with (Rabs ((b - INR k) - (a - INR k))) by (rewrite Rabs_pos_eq; lra).
        apply flat_ok; [apply B_flat; lia|lra|lra]. }
      destruct (Rle_dec r (INR k)); [apply IHk; lia || lra|].
      destruct (Rle_dec (INR k) u); [apply P; lra|].
      replace (S r - S u) with ((S r - S (INR k)) + (S (INR k) - S u)) by ring.
      eapply Rle_trans; [apply Rabs_triang|].
      pose proof (P (INR k) r ltac:(lra) ltac:(lra) ltac:(lra)).
      pose proof (IHk ltac:(lia) u (INR k) ltac:(lra) ltac:(lra) ltac:(lra)). lra.
  Qed.
End Column.

Lemma hold_lip T s t : s <= t -> 0 <= hold T t - hold T s <= t - s \/ T < 0.
Proof. unfold hold, Rmax, Rmin; intros; repeat destruct Rle_dec; lra. Qed.

Lemma edge_lip n i V unit T rows side : regular n rows = true -> (i < n)%nat -> 0 < unit -> 0 < T -> steep V i rows = true ->
  side = fst \/ side = snd -> lipschitz (unit * (3 * IZR V) * (INR (segments rows) / T)) (edge unit T rows side i).
Proof.
  intros Rg Hi Hu HT St Sd.
  assert (Main : forall s t, s <= t ->
    Rabs (edge unit T rows side i t - edge unit T rows side i s) <= unit * (3 * IZR V) * (INR (segments rows) / T) * (t - s)).
  { intros s t H. unfold edge. fold (spline_time T rows s) (spline_time T rows t).
    rewrite <- Rmult_minus_distr_l, Rabs_mult, (Rabs_pos_eq unit) by lra. rewrite !Rmult_assoc.
    apply Rmult_le_compat_l; [lra|].
    destruct (spline_time_range T rows s HT), (spline_time_range T rows t HT).
    assert (KT : 0 <= INR (segments rows) / T) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    destruct (hold_lip T s t H) as [Hh|]; [|lra].
    assert (Up : spline_time T rows t - spline_time T rows s = INR (segments rows) / T * (hold T t - hold T s))
      by (unfold spline_time; ring).
    assert (0 <= INR (segments rows) / T * (hold T t - hold T s)) by (apply Rmult_le_pos; lra).
    assert (INR (segments rows) / T * (hold T t - hold T s) <= INR (segments rows) / T * (t - s)) by (apply Rmult_le_compat_l; lra).
    assert (V0 : 0 <= IZR V) by (destruct Sd as [->| ->]; eapply (V_nonneg rows n i V); eauto).
    apply Rle_trans with (3 * IZR V * (spline_time T rows t - spline_time T rows s)).
    - destruct Sd as [->| ->]; [apply (S_lip rows n i V fst fst) with (k := segments rows)|apply (S_lip rows n i V snd snd) with (k := segments rows)];
        auto; lra.
    - rewrite Up. apply Rle_trans with (3 * IZR V * (INR (segments rows) / T * (t - s))); [apply Rmult_le_compat_l; lra|right; ring]. }
  intros s t. destruct (Rle_dec s t).
  - rewrite (Rabs_pos_eq (t - s)) by lra. now apply Main.
  - rewrite (Rabs_minus_sym (edge _ _ _ _ _ t)), (Rabs_minus_sym t). rewrite (Rabs_pos_eq (s - t)) by lra. apply Main; lra.
Qed.

(* ------------------------------------------------------------------ reach-avoid-stay of the closed loop *)

Section ReachAvoidStay.
  Variables (unit err : Q) (how : search) (k : task) (rows : table) (Vs : list Z).
  Hypothesis checked : check unit err how k rows = true.
  Hypothesis more : slopes err k rows Vs = true.

  Let L (i : nat) (t : R) := lower unit k rows i t.
  Let U (i : nat) (t : R) := upper unit k rows i t.
  Let tc := Q2R (T k).

  Variables gain gmin F : nat -> R.
  Variables x f g : nat -> R -> R.
  Hypothesis gain_pos : forall i, (i < n k)%nat -> 0 < gain i.
  Hypothesis gmin_pos : forall i, (i < n k)%nat -> 0 < gmin i.
  Hypothesis x_cont : forall i t, (i < n k)%nat -> continuity_pt (x i) t.
  Hypothesis x_start : forall i, (i < n k)%nat -> L i 0 < x i 0 < U i 0.
  Hypothesis ode : forall t, 0 < t < tc -> (forall i, (i < n k)%nat -> L i t < x i t < U i t) -> forall i, (i < n k)%nat ->
    is_derive (x i) t (f i t + g i t * law (gain i) (x i t - L i t) (U i t - x i t)) /\
    Rabs (f i t) <= F i /\ gmin i <= g i t.

  Theorem reach_avoid_stay :
    (forall t, 0 <= t <= tc -> in_space k (fun i => x i t)) /\
    (forall t o, 0 <= t <= tc -> In o (unsafe k) -> clear (n k) (Q2R (clearance k)) o (fun i => x i t)) /\
    in_target k (fun i => x i tc).
  Proof.
    pose proof checked as C. unfold check in C. cbv zeta in C. rewrite !andb_true_iff in C. destruct C as [[[Up Tp] Rg] _].
    unfold slopes in more. rewrite !andb_true_iff, forallb_forall in more. destruct more as [[Mw Er] St].
    assert (E0 : 0 <= Q2R err) by (apply Qle_bool_iff, Qle_Rle in Er; unfold Q2R in Er at 1; cbn in Er; lra).
    assert (Tp' := positive_ok _ Tp). assert (Up' := positive_ok _ Up). assert (Mw' := positive_ok _ Mw).
    assert (Near : forall i t, (i < n k)%nat -> Rabs (L i t - lower unit k rows i t) <= Q2R err /\ Rabs (U i t - upper unit k rows i t) <= Q2R err).
    { intros i t _. unfold L, U. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. lra. }
    destruct (tube_sound unit err Up k rows how checked L U Near) as (P1 & _).
    assert (Keeps := tube_keeps unit err Up k rows how checked L U Near).
    assert (In_ : forall t, 0 <= t <= tc -> inside (n k) L U x t).
    { set (v := fun i => Q2R unit * (3 * IZR (nth i Vs 0%Z)) * (INR (segments rows) / tc)).
      apply (stays_inside (n k) tc gain gmin F v (fun _ => Q2R (min_width k)) L U x f g); auto.
      - intros i Hi. unfold v. apply (edge_lip (n k)); auto. apply St, in_seq; lia.
      - intros i Hi. unfold v. apply (edge_lip (n k)); auto. apply St, in_seq; lia.
      }
    split; [|split].
    - intros t Ht. apply (Keeps t (fun i => x i t)), (In_ t Ht).
    - intros t o Ht. apply (Keeps t (fun i => x i t)), (In_ t Ht).
    - apply (Keeps tc (fun i => x i tc)); [apply In_|]; unfold tc; lra.
  Qed.
End ReachAvoidStay.

