(* P1 to P5 for what the emitted code computes, all of it decided by evaluation. *)
From Coq Require Import ZArith QArith Qreals Qabs Qminmax Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed Rounding Emitted.
Import ListNotations.
Open Scope R_scope.

(* K/t_c and the last spline time below K, as the C has them: mantissa and exponent. *)
Record scale := Scale { rate_m : Z; rate_e : Z; last_m : Z; last_e : Z }.
Definition dyadic (m e : Z) : Q := if (0 <=? e)%Z then inject_Z (m * 2 ^ e) else (m # Z.to_pos (2 ^ (- e))).

Lemma dyadic_ok m e : Q2R (dyadic m e) = F2R (Float radix2 m e).
Proof.
  unfold dyadic, F2R; cbn [Fnum Fexp]. destruct (Z.leb_spec 0 e).
  - rewrite Q2R_Z, mult_IZR. change 2%Z with (radix_val radix2). now rewrite IZR_Zpower.
  - unfold Q2R; cbn [Qnum Qden]. f_equal.
    assert (0 < 2 ^ (- e))%Z by (apply Z.pow_pos_nonneg; lia).
    rewrite Z2Pos.id by assumption. change 2%Z with (radix_val radix2). rewrite IZR_Zpower by lia.
    rewrite <- bpow_opp. f_equal; lia.
Qed.

Definition largest_of (unit : Q) (rows : table) : Q :=
  Qred (unit * inject_Z (fold_right (fun r m => fold_right (fun p m => Z.max (Z.abs (fst p)) (Z.max (Z.abs (snd p)) m)) m r) 0%Z rows)).

(* P7: that the arithmetic moves no edge by more than err. late: what the emitted spline time may be wrong by. *)
Definition rounding_check (format : format) (unit err : Q) (k : task) (rows : table) (Vs : list Z) (s : scale) (late : Q) : bool :=
  let K := inject_Z (Z.of_nat (segments rows)) in
  let c := dyadic (rate_m s) (rate_e s) in
  let last := dyadic (last_m s) (last_e s) in
  let big := largest_of unit rows in
  let early := (K / T k * (T k * half_ulp format + half_least format))%Q in
  Qle_bool 0 c && Qle_bool 0 last && positive (K - last) && Qle_bool (K - last + early) late &&
  (Z.abs (last_m s) <? 2 ^ precision format)%Z && (least_exponent format <=? last_e s)%Z &&
  Qle_bool (T k * Qabs (c - K / T k) + (T k * c * half_ulp format + half_least format) + early) late &&
  forallb (forallb (fun p => Qle_bool (Qabs (unit * inject_Z (fst p))) big && Qle_bool (Qabs (unit * inject_Z (snd p))) big)) rows &&
  Qle_bool 0 big &&
  match evaluation_error format big with
  | Some e => forallb (fun i => Qle_bool (e + unit * (3 * inject_Z (nth i Vs 0%Z) * late)) err) (seq 0 (n k))
  | None => false
  end.

Lemma Qle_bool_R a b : Qle_bool a b = true -> Q2R a <= Q2R b.
Proof. intro H. now apply Qle_Rle, Qle_bool_iff. Qed.

Section EmittedTube.
  Variables (format : format) (unit err : Q) (how : search) (k : task) (rows : table) (Vs : list Z) (s : scale) (late : Q).
  Hypothesis checked : check unit err how k rows = true.
  Hypothesis more : slopes err k rows Vs = true.
  Hypothesis rounding : rounding_check format unit err k rows Vs s late = true.

  (* what the C function `tube` stores, as real numbers *)
  Let rate := F2R (Float radix2 (rate_m s) (rate_e s)).
  Let end_ := F2R (Float radix2 (last_m s) (last_e s)).
  Definition at_place (side : Z * Z -> Z) (i : nat) (p : nat * R) : R := placed format rows (Q2R unit) side i p.
  Definition emitted (side : Z * Z -> Z) (i : nat) (t : R) : R := at_place side i (place_of_time format rate end_ t).
  Definition fits_time (t : R) (p : nat * R) : Prop := fits rows (Q2R (T k)) (Q2R late) t p.

  (* P7: at a place that fits a time the emitted edges are within err of the exact ones; a time in seconds has such a place. *)
  Lemma emission_near : (forall clock t, reads format clock t -> fits_time t (place_of_time format rate end_ clock)) /\
    forall i t p, (i < n k)%nat -> fits_time t p ->
      Rabs (at_place fst i p - lower unit k rows i t) <= Q2R err /\ Rabs (at_place snd i p - upper unit k rows i t) <= Q2R err.
  Proof.
    pose proof rounding as H. unfold rounding_check in H. cbv zeta in H. rewrite !andb_true_iff in H.
    destruct H as [[[[[[[[[Cz Lz] LK] LL] Lm] Lexp] Rate] Bd] Bz] Ev].
    pose proof checked as Ch. pose proof more as Mo. unfold slopes in Mo. rewrite !andb_true_iff in Mo. destruct Mo as [_ Stp].
    assert (Ch2 := Ch). unfold check in Ch2. cbv zeta in Ch2. rewrite !andb_true_iff in Ch2. destruct Ch2 as [[[Up Tp] _] _].
    rewrite forallb_forall in Stp.
    destruct (evaluation_error format (largest_of unit rows)) as [e|] eqn:E; [|easy].
    rewrite forallb_forall in Ev. rewrite forallb_forall in Bd.
    assert (Rg : regular (n k) rows = true) by (unfold check in Ch; cbv zeta in Ch; rewrite !andb_true_iff in Ch; apply Ch).
    assert (Tp' := positive_ok _ Tp). assert (Up' := positive_ok _ Up).
    assert (Z0 : Q2R 0 = 0) by (unfold Q2R; cbn; lra).
    apply Qle_bool_R in Cz, Lz, LL, Rate, Bz. apply positive_ok in LK. rewrite Z0 in *.
    assert (KR : Q2R (inject_Z (Z.of_nat (segments rows))) = INR (segments rows)) by (now rewrite Q2R_Z, <- INR_IZR_INZ).
    assert (Tn : ~ (T k == 0)%Q) by (intro Q; apply Qeq_eqR in Q; rewrite Z0 in Q; lra).
    rewrite Q2R_minus, KR in LK. rewrite !Q2R_plus, !Q2R_mult, Q2R_minus, !Q2R_plus, Q2R_div, KR, Q2R_mult in LL by exact Tn.
    rewrite !Q2R_plus, !Q2R_mult, Q2R_abs, Q2R_minus, !Q2R_plus, !Q2R_div, !Q2R_mult, KR in Rate by exact Tn.
    rewrite dyadic_ok in *.
    assert (Bounded : forall side i j, side = fst \/ side = snd ->
      Rabs (Q2R unit * IZR (nth j (column side i rows) 0%Z)) <= Q2R (largest_of unit rows)).
    { intros side i' j Sd. assert (S0 : side (0, 0)%Z = 0%Z) by (destruct Sd as [->| ->]; reflexivity).
      rewrite column_nth by exact S0.
      assert (Zero : Rabs (Q2R unit * IZR (side (0,0)%Z)) <= Q2R (largest_of unit rows)).
      { rewrite S0, Rmult_0_r, Rabs_R0. exact Bz. }
      destruct (nth_in_or_default j rows []) as [I| ->]; [|destruct i'; exact Zero].
      specialize (Bd _ I). rewrite forallb_forall in Bd.
      destruct (nth_in_or_default i' (nth j rows []) (0, 0)%Z) as [I2|D]; [|rewrite D; exact Zero].
      specialize (Bd _ I2). rewrite andb_true_iff in Bd. destruct Bd as [B1 B2].
      apply Qle_bool_R in B1, B2. rewrite Q2R_abs, Q2R_mult, Q2R_Z in B1, B2.
      destruct Sd as [->| ->]; assumption. }
    assert (Lf : generic_format radix2 (fexp format) (F2R (Float radix2 (last_m s) (last_e s)))).
    { apply generic_format_FLT. exists (Float radix2 (last_m s) (last_e s)); [reflexivity|now apply Z.ltb_lt|now apply Z.leb_le]. }
    split; [intros clock t Cl; unfold fits_time, rate, end_; apply time_fits; [exact Tp'|exact Cz|lra|exact Lf|lra|lra|exact Cl]|].
    intros i t p Hi Pl.
    assert (Ei : Q2R e + Q2R unit * (3 * IZR (nth i Vs 0%Z) * Q2R late) <= Q2R err).
    { assert (Q := Ev i ltac:(apply in_seq; lia)). apply Qle_bool_R in Q.
      rewrite Q2R_plus, !Q2R_mult, Q2R_Z in Q. replace (Q2R 3) with 3 in Q by (unfold Q2R; cbn; lra). exact Q. }
    assert (Si := Stp i ltac:(apply in_seq; lia)).
    unfold at_place, lower, upper.
    split; (eapply Rle_trans; [|exact Ei]); [apply (placed_ok format rows (n k) (Q2R unit) (Q2R (T k)) (Q2R late)) with (of := fst) (largest := largest_of unit rows)|apply (placed_ok format rows (n k) (Q2R unit) (Q2R (T k)) (Q2R late)) with (of := snd) (largest := largest_of unit rows)]; auto.
  Qed.

  (* A clock that is right, or right but for one rounding to the format. *)
  Variable clock : R -> R.
  Hypothesis clock_reads : forall t, reads format (clock t) t.
  Let L i t := emitted fst i (clock t).
  Let U i t := emitted snd i (clock t).
  Lemma emitted_near i t : (i < n k)%nat ->
    Rabs (L i t - lower unit k rows i t) <= Q2R err /\ Rabs (U i t - upper unit k rows i t) <= Q2R err.
  Proof. intro Hi. destruct emission_near as [Tm Pl]. exact (Pl i t _ Hi (Tm _ _ (clock_reads t))). Qed.

  Theorem emitted_tube_sound :
    (* P1 *) (forall i t, (i < n k)%nat -> L i t + Q2R (min_width k) <= U i t) /\
    (* P2 *) (forall i, (i < n k)%nat -> L i 0 < at_ (x0 k) i < U i 0 /\ in_box L U (start k) i 0) /\
    (* P3 *) (forall i t, (i < n k)%nat -> in_box L U (space k) i t) /\
    (* P4 *) (forall o t, In o (unsafe k) -> separated (n k) (Q2R (clearance k)) o (fun i => L i t) (fun i => U i t)) /\
    (* P5 *) (forall i t, (i < n k)%nat -> Q2R (T k) <= t -> in_box L U (target k) i t) /\
    (* and where half-spaces cut *)
    (forall t x, (forall i, (i < n k)%nat -> L i t <= x i <= U i t) -> within_faces (n k) (walls k) x /\ (Q2R (T k) <= t -> within_faces (n k) (goals k) x)).
  Proof.
    assert (Up : positive unit = true).
    { pose proof checked as C. unfold check in C. cbv zeta in C. rewrite !andb_true_iff in C. apply C. }
    exact (tube_sound unit err Up k rows how checked L U emitted_near).
  Qed.
End EmittedTube.

(* Counts of ticks: the first that is not before t_c, of how many the divisor's a tick is in a segment, and its seconds. *)
Record ticks := Ticks { final : Z; multiplier : Z; divisor : Z; seconds : Q }.
Definition ticks_check (format : format) (k : task) (rows : table) (late : Q) (c : ticks) : bool :=
  let K := Z.of_nat (segments rows) in
  ((0 <? multiplier c)%Z && (0 <? divisor c)%Z && (divisor c * K <=? final c * multiplier c)%Z &&
   Qeq_bool (inject_Z (multiplier c) * T k) (inject_Z (divisor c * K) * seconds c) && Qle_bool (half_ulp format + half_least format) late)%bool.
Lemma ticks_fit format unit err how k rows late c tick : check unit err how k rows = true -> ticks_check format k rows late c = true -> (0 <= tick)%Z ->
  fits_time k rows late (IZR tick * Q2R (seconds c)) (place_of_tick format rows (final c) (multiplier c) (divisor c) tick).
Proof.
  intros Ch H T0. unfold ticks_check in H. cbv zeta in H. rewrite !andb_true_iff in H. destruct H as [[[[H1 H2] H3] H4] H5].
  apply Z.ltb_lt in H1, H2. apply Z.leb_le in H3. apply Qeq_bool_iff, Qeq_eqR in H4. apply Qle_bool_R in H5. rewrite !Q2R_mult, !Q2R_Z, mult_IZR, <- INR_IZR_INZ in H4. rewrite Q2R_plus in H5.
  unfold check in Ch. cbv zeta in Ch. rewrite !andb_true_iff in Ch. destruct Ch as [[[Up Tp] Rg] _]. apply positive_ok in Tp.
  unfold fits_time. now apply (tick_fits format rows (n k)).
Qed.
