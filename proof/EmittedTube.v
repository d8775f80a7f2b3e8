(* P1 to P5 for the edges that the emitted C computes. All conditions are decided by evaluation: `rounding_check` says that the
   arithmetic moves no edge by more than edge_error (P7), and `emitted_tube_sound` applies `tube_sound` of Tube.v.

   Period.v, Controller.v and Sound.v use the distance to the exact edges; a theorem file has `emitted_tube_sound` as its theorem about
   the tube (docs/theorem.md). *)
From Coq Require Import ZArith QArith Qreals Qabs Qminmax Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed Rounding Emitted.
Import ListNotations.
Open Scope R_scope.

(* The C's constants of time, each as mantissa 2^exponent: K/t_c, and the last spline time below K. *)
Record time_scale := TimeScale { rate_mantissa : Z; rate_exponent : Z; last_mantissa : Z; last_exponent : Z }.
(* m 2^e as a rational. *)
Definition dyadic (m e : Z) : Q := if (0 <=? e)%Z then inject_Z (m * 2 ^ e) else (m # Z.to_pos (2 ^ (- e))).

Lemma dyadic_value m e : Q2R (dyadic m e) = F2R (Float radix2 m e).
Proof.
  unfold dyadic, F2R; cbn [Fnum Fexp]. destruct (Z.leb_spec 0 e).
  - rewrite Q2R_Z, mult_IZR. change 2%Z with (radix_val radix2). now rewrite IZR_Zpower.
  - unfold Q2R; cbn [Qnum Qden]. f_equal.
    assert (0 < 2 ^ (- e))%Z by (apply Z.pow_pos_nonneg; lia).
    rewrite Z2Pos.id by assumption. change 2%Z with (radix_val radix2). rewrite IZR_Zpower by lia.
    rewrite <- bpow_opp. f_equal; lia.
Qed.

(* The largest absolute value in the table. *)
Definition largest_table_value (unit : Q) (rows : table) : Q :=
  Qred (unit * inject_Z (fold_right (fun r m => fold_right (fun p m => Z.max (Z.abs (fst p)) (Z.max (Z.abs (snd p)) m)) m r) 0%Z rows)).

(* P7: the arithmetic moves no edge by more than edge_error. time_error bounds the error of the emitted spline time, in segments. *)
Definition rounding_check (format : format) (unit edge_error : Q) (spec : task) (rows : table) (step_maxima : list Z) (scale : time_scale) (time_error : Q) : bool :=
  let K := inject_Z (Z.of_nat (segment_count rows)) in
  let rate := dyadic (rate_mantissa scale) (rate_exponent scale) in
  let last := dyadic (last_mantissa scale) (last_exponent scale) in
  let largest := largest_table_value unit rows in
  let clock_error := (K / t_c spec * (t_c spec * half_ulp format + half_smallest format))%Q in
  Qle_bool 0 rate && Qle_bool 0 last && is_positive (K - last) && Qle_bool (K - last + clock_error) time_error &&
  (Z.abs (last_mantissa scale) <? 2 ^ precision format)%Z && (minimum_exponent format <=? last_exponent scale)%Z &&
  Qle_bool (t_c spec * Qabs (rate - K / t_c spec) + (t_c spec * rate * half_ulp format + half_smallest format) + clock_error) time_error &&
  forallb (forallb (fun p => Qle_bool (Qabs (unit * inject_Z (fst p))) largest && Qle_bool (Qabs (unit * inject_Z (snd p))) largest)) rows &&
  Qle_bool 0 largest &&
  match spline_evaluation_error format largest with
  | Some evaluation_error => forallb (fun i => Qle_bool (evaluation_error + unit * (3 * inject_Z (nth i step_maxima 0%Z) * time_error)) edge_error) (seq 0 (n spec))
  | None => false
  end.

Lemma Qle_bool_real a b : Qle_bool a b = true -> Q2R a <= Q2R b.
Proof. intro H. now apply Qle_Rle, Qle_bool_iff. Qed.

(* A tube that the checks accept. *)
Section EmittedTube.
  Variables (format : format) (unit edge_error : Q) (plan : search_plan) (spec : task) (rows : table) (step_maxima : list Z) (scale : time_scale) (time_error : Q).
  Hypothesis tube_checked : tube_check unit edge_error plan spec rows = true.
  Hypothesis slopes_checked : slopes_check edge_error spec rows step_maxima = true.
  Hypothesis rounding_checked : rounding_check format unit edge_error spec rows step_maxima scale time_error = true.

  Let time_rate := F2R (Float radix2 (rate_mantissa scale) (rate_exponent scale)).
  Let last_spline_time := F2R (Float radix2 (last_mantissa scale) (last_exponent scale)).
  (* The edge that the C computes at a position, and at a time in seconds that its clock shows. *)
  Definition emitted_edge_at (side : Z * Z -> Z) (i : nat) (position : nat * R) : R := edge_at_position format rows (Q2R unit) side i position.
  Definition emitted_edge (side : Z * Z -> Z) (i : nat) (t : R) : R := emitted_edge_at side i (position_of_time format time_rate last_spline_time t).
  (* A position fits a time, in the terms of Emitted.v. *)
  Definition position_fits_time (t : R) (position : nat * R) : Prop := position_fits rows (Q2R (t_c spec)) (Q2R time_error) t position.

  (* P7: the position of a time that the clock shows fits that time; at a position that fits, the emitted edges are within edge_error of
     the exact ones. *)
  Lemma emitted_edges_near : (forall clock t, clock_shows format clock t -> position_fits_time t (position_of_time format time_rate last_spline_time clock)) /\
    forall i t p, (i < n spec)%nat -> position_fits_time t p ->
      Rabs (emitted_edge_at fst i p - lower unit spec rows i t) <= Q2R edge_error /\ Rabs (emitted_edge_at snd i p - upper unit spec rows i t) <= Q2R edge_error.
  Proof.
    pose proof rounding_checked as H. unfold rounding_check in H. cbv zeta in H. rewrite !andb_true_iff in H.
    destruct H as [[[[[[[[[Cz Lz] LK] LL] Lm] Lexp] Rate] Bd] Bz] Ev].
    pose proof tube_checked as Ch. pose proof slopes_checked as Mo. unfold slopes_check in Mo. rewrite !andb_true_iff in Mo. destruct Mo as [_ Stp].
    assert (Ch2 := Ch). unfold tube_check in Ch2. cbv zeta in Ch2. rewrite !andb_true_iff in Ch2. destruct Ch2 as [[[Up Tp] _] _].
    rewrite forallb_forall in Stp.
    destruct (spline_evaluation_error format (largest_table_value unit rows)) as [e|] eqn:E; [|easy].
    rewrite forallb_forall in Ev. rewrite forallb_forall in Bd.
    assert (Rg : is_regular (n spec) rows = true) by (unfold tube_check in Ch; cbv zeta in Ch; rewrite !andb_true_iff in Ch; apply Ch).
    assert (Tp' := is_positive_sound _ Tp). assert (Up' := is_positive_sound _ Up).
    assert (Z0 : Q2R 0 = 0) by (unfold Q2R; cbn; lra).
    apply Qle_bool_real in Cz, Lz, LL, Rate, Bz. apply is_positive_sound in LK. rewrite Z0 in *.
    assert (KR : Q2R (inject_Z (Z.of_nat (segment_count rows))) = INR (segment_count rows)) by (now rewrite Q2R_Z, <- INR_IZR_INZ).
    assert (Tn : ~ (t_c spec == 0)%Q) by (intro Q; apply Qeq_eqR in Q; rewrite Z0 in Q; lra).
    rewrite Q2R_minus, KR in LK. rewrite !Q2R_plus, !Q2R_mult, Q2R_minus, !Q2R_plus, Q2R_div, KR, Q2R_mult in LL by exact Tn.
    rewrite !Q2R_plus, !Q2R_mult, Q2R_abs, Q2R_minus, !Q2R_plus, !Q2R_div, !Q2R_mult, KR in Rate by exact Tn.
    rewrite dyadic_value in *.
    assert (Bounded : forall side i j, side = fst \/ side = snd ->
      Rabs (Q2R unit * IZR (nth j (edge_column side i rows) 0%Z)) <= Q2R (largest_table_value unit rows)).
    { intros side i' j Sd. assert (S0 : side (0, 0)%Z = 0%Z) by (destruct Sd as [->| ->]; reflexivity).
      rewrite edge_column_nth by exact S0.
      assert (Zero : Rabs (Q2R unit * IZR (side (0,0)%Z)) <= Q2R (largest_table_value unit rows)).
      { rewrite S0, Rmult_0_r, Rabs_R0. exact Bz. }
      destruct (nth_in_or_default j rows []) as [I| ->]; [|destruct i'; exact Zero].
      specialize (Bd _ I). rewrite forallb_forall in Bd.
      destruct (nth_in_or_default i' (nth j rows []) (0, 0)%Z) as [I2|D]; [|rewrite D; exact Zero].
      specialize (Bd _ I2). rewrite andb_true_iff in Bd. destruct Bd as [B1 B2].
      apply Qle_bool_real in B1, B2. rewrite Q2R_abs, Q2R_mult, Q2R_Z in B1, B2.
      destruct Sd as [->| ->]; assumption. }
    assert (Lf : generic_format radix2 (format_exponent format) (F2R (Float radix2 (last_mantissa scale) (last_exponent scale)))).
    { apply generic_format_FLT. exists (Float radix2 (last_mantissa scale) (last_exponent scale)); [reflexivity|now apply Z.ltb_lt|now apply Z.leb_le]. }
    split; [intros clock t Cl; unfold position_fits_time, time_rate, last_spline_time; apply position_of_time_fits; [exact Tp'|exact Cz|lra|exact Lf|lra|lra|exact Cl]|].
    intros i t p Hi Pl.
    assert (Ei : Q2R e + Q2R unit * (3 * IZR (nth i step_maxima 0%Z) * Q2R time_error) <= Q2R edge_error).
    { assert (Q := Ev i ltac:(apply in_seq; lia)). apply Qle_bool_real in Q.
      rewrite Q2R_plus, !Q2R_mult, Q2R_Z in Q. replace (Q2R 3) with 3 in Q by (unfold Q2R; cbn; lra). exact Q. }
    assert (Si := Stp i ltac:(apply in_seq; lia)).
    unfold emitted_edge_at, lower, upper.
    split; (eapply Rle_trans; [|exact Ei]); [apply (edge_at_position_near format rows (n spec) (Q2R unit) (Q2R (t_c spec)) (Q2R time_error)) with (bezier_of_side := fst) (coefficient_max := largest_table_value unit rows)|apply (edge_at_position_near format rows (n spec) (Q2R unit) (Q2R (t_c spec)) (Q2R time_error)) with (bezier_of_side := snd) (coefficient_max := largest_table_value unit rows)]; auto.
  Qed.

  (* A clock that shows every time, right or rounded once. *)
  Variable clock : R -> R.
  Hypothesis clock_reads : forall t, clock_shows format (clock t) t.
  Let L i t := emitted_edge fst i (clock t).
  Let U i t := emitted_edge snd i (clock t).
  Lemma emitted_edge_near i t : (i < n spec)%nat ->
    Rabs (L i t - lower unit spec rows i t) <= Q2R edge_error /\ Rabs (U i t - upper unit spec rows i t) <= Q2R edge_error.
  Proof. intro Hi. destruct emitted_edges_near as [Tm Pl]. exact (Pl i t _ Hi (Tm _ _ (clock_reads t))). Qed.

  (* P1 to P5 of the emitted edges, at every time that the clock shows. *)
  Theorem emitted_tube_sound :
    (* P1 *) (forall i t, (i < n spec)%nat -> L i t + Q2R (min_width spec) <= U i t) /\
    (* P2 *) (forall i, (i < n spec)%nat -> L i 0 < real_at (initial_state spec) i < U i 0 /\ in_box L U (initial_set spec) i 0) /\
    (* P3 *) (forall i t, (i < n spec)%nat -> in_box L U (state_space spec) i t) /\
    (* P4 *) (forall o t, In o (unsafe_sets spec) -> separated (n spec) (Q2R (clearance spec)) o (fun i => L i t) (fun i => U i t)) /\
    (* P5 *) (forall i t, (i < n spec)%nat -> Q2R (t_c spec) <= t -> in_box L U (target_set spec) i t) /\
    (* P3 and P5 where half-spaces cut *)
    (forall t x, (forall i, (i < n spec)%nat -> L i t <= x i <= U i t) -> within_half_spaces (n spec) (state_half_spaces spec) x /\ (Q2R (t_c spec) <= t -> within_half_spaces (n spec) (target_half_spaces spec) x)).
  Proof.
    assert (Up : is_positive unit = true).
    { pose proof tube_checked as C. unfold tube_check in C. cbv zeta in C. rewrite !andb_true_iff in C. apply C. }
    exact (tube_sound unit edge_error Up spec rows plan tube_checked L U emitted_edge_near).
  Qed.
End EmittedTube.

(* Counts of ticks: the first tick that is not before t_c, the parts of a segment that a tick takes, the parts that a segment has, and
   the seconds of a tick. *)
Record tick_scale := TickScale { final_tick : Z; multiplier : Z; divisor : Z; tick_seconds : Q }.
(* The integers count the seconds of a tick exactly, and reach the end at final_tick. *)
Definition ticks_check (format : format) (spec : task) (rows : table) (time_error : Q) (scale : tick_scale) : bool :=
  let K := Z.of_nat (segment_count rows) in
  ((0 <? multiplier scale)%Z && (0 <? divisor scale)%Z && (divisor scale * K <=? final_tick scale * multiplier scale)%Z &&
   Qeq_bool (inject_Z (multiplier scale) * t_c spec) (inject_Z (divisor scale * K) * tick_seconds scale) && Qle_bool (half_ulp format + half_smallest format) time_error)%bool.
(* Then the position of every tick fits its time. *)
Lemma tick_position_fits format unit edge_error plan spec rows time_error c tick : tube_check unit edge_error plan spec rows = true -> ticks_check format spec rows time_error c = true -> (0 <= tick)%Z ->
  position_fits_time spec rows time_error (IZR tick * Q2R (tick_seconds c)) (position_of_tick format rows (final_tick c) (multiplier c) (divisor c) tick).
Proof.
  intros Ch H T0. unfold ticks_check in H. cbv zeta in H. rewrite !andb_true_iff in H. destruct H as [[[[H1 H2] H3] H4] H5].
  apply Z.ltb_lt in H1, H2. apply Z.leb_le in H3. apply Qeq_bool_iff, Qeq_eqR in H4. apply Qle_bool_real in H5. rewrite !Q2R_mult, !Q2R_Z, mult_IZR, <- INR_IZR_INZ in H4. rewrite Q2R_plus in H5.
  unfold tube_check in Ch. cbv zeta in Ch. rewrite !andb_true_iff in Ch. destruct Ch as [[[Up Tp] Rg] _]. apply is_positive_sound in Tp.
  unfold position_fits_time. now apply (position_of_tick_fits format rows (n spec)).
Qed.
