(* The emitted edges are near the exact ones (P7). Three things round: the time that is passed, its product with K/t_c, and the
   assignments of `basis` and `edge_at`. For a count of ticks the position in its segment is rounded, and nothing before that.

   EmittedTube.v decides the hypotheses by evaluation. docs/certificate-format.md derives the same bound (P7: `edge_error`); the lemma
   book has it as `refined.late` (docs/lemmas.md). *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed Rounding.
Import ListNotations.
Open Scope R_scope.

(* Time in seconds. `time_rate` and `last_spline_time` are the C's constants for K/t_c and for the largest spline time below K; `unit` is
   the value of one step of the table. *)
Section Emitted.
  Variables (format : format) (rows : table) (n : nat) (unit t_c time_rate last_spline_time : R).
  Let K := segment_count rows.

  (* The spline time that the C computes for t: the product, rounded, and limited to [0, last_spline_time]. *)
  Definition emitted_spline_time (t : R) : R :=
    let started := if Rlt_dec 0 t then t else 0 in
    let scaled := round_to_format format (started * time_rate) in
    if Rlt_dec scaled last_spline_time then scaled else last_spline_time.

  (* The edge that the C computes at a position: segment k = fst position, and s = snd position in it. *)
  Definition edge_at_position (side : Z * Z -> Z) (i : nat) (position : nat * R) : R :=
    let q j := unit * IZR (nth (fst position + j) (edge_column side i rows) 0%Z) in
    nth 23 (run_assignments (round_to_format format) basis_edge [snd position; q 0%nat; q 1%nat; q 2%nat; q 3%nat]) 0.
  (* The position that the C computes for a time in seconds. *)
  Definition position_of_time (t : R) : nat * R :=
    let u := emitted_spline_time t in let k := Z.to_nat (Ztrunc u) in (k, round_to_format format (u - INR k)).

  (* Ticks. A segment has `divisor` parts; a tick takes `multiplier` of them, and `final_tick` is the first tick that is not before t_c.
     This is how many parts have passed at a tick, at most those of all segments. *)
  Definition parts_passed (final multiplier divisor tick : Z) : Z :=
    let passed := (Z.min tick final * multiplier)%Z in Z.min passed (divisor * Z.of_nat K).
  (* The position that the C computes for a count of ticks. *)
  Definition position_of_tick (final multiplier divisor tick : Z) : nat * R :=
    let parts := parts_passed final multiplier divisor tick in
    let k := Z.min (parts / divisor) (Z.of_nat K - 1) in
    (Z.to_nat k, round_to_format format (IZR (parts - k * divisor) / IZR divisor)).

  (* A clock shows time t if its value is t, rounded at most once to the format. *)
  Definition clock_shows (clock t : R) : Prop := Rabs (clock - t) <= Rabs t * Q2R (half_ulp format) + Q2R (half_smallest format).

  Variables (time_error : R).  (* a bound on the error of the emitted spline time, in segments *)
  Let clock_error := INR K / t_c * (t_c * Q2R (half_ulp format) + Q2R (half_smallest format)).  (* the part of it that is due to the clock *)
  Hypothesis t_c_pos : 0 < t_c.
  Hypothesis unit_pos : 0 < unit.
  Hypothesis time_rate_nonneg : 0 <= time_rate.
  Hypothesis last_spline_time_range : 0 <= last_spline_time < INR K.
  Hypothesis last_spline_time_in_format : generic_format radix2 (format_exponent format) last_spline_time.
  Hypothesis time_error_covers_end : INR K - last_spline_time + clock_error <= time_error.
  Hypothesis time_error_covers_rate : t_c * Rabs (time_rate - INR K / t_c) + (t_c * time_rate * Q2R (half_ulp format) + Q2R (half_smallest format)) + clock_error <= time_error.

  Lemma emitted_spline_time_range t : 0 <= emitted_spline_time t <= last_spline_time.
  Proof.
    unfold emitted_spline_time; cbv zeta. set (st := if Rlt_dec 0 t then t else 0).
    assert (S0 : 0 <= st) by (unfold st; destruct Rlt_dec; lra).
    assert (0 <= round_to_format format (st * time_rate)).
    { unfold round_to_format. apply round_ge_generic; [apply format_exponent_valid|apply valid_rnd_N|apply generic_format_0|]. now apply Rmult_le_pos. }
    destruct (Rlt_dec (round_to_format format (st * time_rate)) last_spline_time); lra.
  Qed.

  Lemma emitted_spline_time_in_format t : generic_format radix2 (format_exponent format) (emitted_spline_time t).
  Proof.
    unfold emitted_spline_time; cbv zeta. destruct (Rlt_dec (round_to_format format _) last_spline_time); [|exact last_spline_time_in_format].
    unfold round_to_format. apply generic_format_round; [apply format_exponent_valid|apply valid_rnd_N].
  Qed.

  Lemma emitted_spline_time_near t : Rabs (emitted_spline_time t - spline_time t_c rows t) <= time_error - clock_error.
  Proof.
    assert (KT : INR K / t_c * t_c = INR K) by (field; lra).
    assert (R0 : 0 <= INR K / t_c) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    set (dc := Rabs (time_rate - INR K / t_c)) in *.
    assert (Dc : - dc <= time_rate - INR K / t_c <= dc) by (apply Rabs_le_between; unfold dc; lra).
    assert (U : 0 <= Q2R (half_ulp format) <= 1) by apply half_ulp_range.
    set (ul := Q2R (half_ulp format)) in *. set (ti := Q2R (half_smallest format)) in *.
    unfold emitted_spline_time, spline_time, clamped_time; cbv zeta. fold K.
    destruct (Rlt_dec 0 t) as [t0|t0].
    2: { rewrite Rmult_0_l. replace (round_to_format format 0) with 0 by (unfold round_to_format; now rewrite round_0 by apply valid_rnd_N).
         assert (Rmin t t_c <= 0) by (apply Rle_trans with t; [apply Rmin_l|lra]).
         rewrite Rmax_left, Rmult_0_r by lra.
         destruct (Rlt_dec 0 last_spline_time); [rewrite Rminus_0_r, Rabs_R0|].
         - lra.
         - replace last_spline_time with 0 by lra. rewrite Rminus_0_r, Rabs_R0. lra. }
    rewrite (Rmax_right 0) by (apply Rmin_glb; lra).
    assert (E := round_to_format_error format (t * time_rate)). fold ul ti in E. rewrite (Rabs_pos_eq (t * time_rate)) in E by (apply Rmult_le_pos; lra).
    apply Rabs_le_between in E.
    destruct (Rle_dec t t_c) as [tT|tT].
    - rewrite Rmin_left by exact tT.
      assert (A : t * time_rate * ul <= t_c * time_rate * ul) by (apply Rmult_le_compat_r; [lra|apply Rmult_le_compat_r; lra]).
      assert (B : t * dc <= t_c * dc) by (apply Rmult_le_compat_r; [apply Rabs_pos|lra]).
      assert (Dt : - (t * dc) <= t * time_rate - INR K / t_c * t <= t * dc) by nra.
      assert (Up : INR K / t_c * t <= INR K) by (rewrite <- KT at 2; apply Rmult_le_compat_l; lra).
      destruct (Rlt_dec (round_to_format format (t * time_rate)) last_spline_time); apply Rabs_le; lra.
    - rewrite Rmin_right by lra. rewrite KT.
      assert (A : t_c * time_rate * (1 - ul) <= t * time_rate * (1 - ul)) by (apply Rmult_le_compat_r; [lra|apply Rmult_le_compat_r; lra]).
      assert (Dt : - (t_c * dc) <= t_c * time_rate - INR K) by (rewrite <- KT; nra).
      destruct (Rlt_dec (round_to_format format (t * time_rate)) last_spline_time); apply Rabs_le; lra.
  Qed.

  Lemma clock_error_bounds clock t : clock_shows clock t -> Rabs (spline_time t_c rows clock - spline_time t_c rows t) <= clock_error.
  Proof.
    unfold clock_shows, spline_time, clock_error. fold K. intro H.
    assert (U := half_ulp_range format). assert (L := half_smallest_nonneg format).
    set (ul := Q2R (half_ulp format)) in *. set (ti := Q2R (half_smallest format)) in *.
    assert (R0 : 0 <= INR K / t_c) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    rewrite <- Rmult_minus_distr_l, Rabs_mult, (Rabs_pos_eq (INR K / t_c)) by exact R0. apply Rmult_le_compat_l; [exact R0|].
    assert (0 <= t_c * ul) by (apply Rmult_le_pos; lra).
    apply Rabs_le_between in H. unfold clamped_time.
    destruct (Rle_dec 0 t) as [t0|t0].
    - rewrite (Rabs_pos_eq t t0) in H. destruct (Rle_dec t t_c) as [tT|tT].
      + assert (t * ul <= t_c * ul) by (apply Rmult_le_compat_r; lra).
        apply Rabs_le. unfold Rmax, Rmin; repeat destruct Rle_dec; lra.
      + assert (t_c * (1 - ul) <= t * (1 - ul)) by (apply Rmult_le_compat_r; lra).
        apply Rabs_le. unfold Rmax, Rmin; repeat destruct Rle_dec; lra.
    - rewrite (Rabs_left t) in H by lra. assert (0 <= - t * (1 - ul)) by (apply Rmult_le_pos; lra).
      apply Rabs_le. unfold Rmax, Rmin; repeat destruct Rle_dec; lra.
  Qed.

  Lemma emitted_spline_time_near_true clock t : clock_shows clock t -> Rabs (emitted_spline_time clock - spline_time t_c rows t) <= time_error.
  Proof.
    intro H. assert (A := emitted_spline_time_near clock). assert (B := clock_error_bounds clock t H).
    replace (emitted_spline_time clock - spline_time t_c rows t)
      with ((emitted_spline_time clock - spline_time t_c rows clock) + (spline_time t_c rows clock - spline_time t_c rows t)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. lra.
  Qed.

  Variables (i : nat) (side : Z * Z -> Z) (bezier_of_side : bezier * bezier -> bezier) (step_max : Z) (coefficient_max evaluation_error : Q).
  Hypothesis rows_regular : is_regular n rows = true.
  Hypothesis axis_below_n : (i < n)%nat.
  Hypothesis side_matches : (side = fst /\ bezier_of_side = fst) \/ (side = snd /\ bezier_of_side = snd).
  Hypothesis steps_checked : edge_steps_within step_max i rows = true.
  Hypothesis coefficients_bounded : forall k, Rabs (unit * IZR (nth k (edge_column side i rows) 0%Z)) <= Q2R coefficient_max.
  Hypothesis evaluation_error_known : spline_evaluation_error format coefficient_max = Some evaluation_error.

  (* A position fits time t if its spline time, segment and s together, is within time_error of the true one. *)
  Definition position_fits (t : R) (position : nat * R) : Prop :=
    (fst position < K)%nat /\ 0 <= snd position <= 1 /\ Rabs (INR (fst position) + snd position - spline_time t_c rows t) <= time_error.

  (* At a position that fits a time, the computed edge is near the exact edge of that time. *)
  Theorem edge_at_position_near p t : position_fits t p -> Rabs (edge_at_position side i p - edge unit t_c rows side i t) <= Q2R evaluation_error + unit * (3 * IZR step_max * time_error).
  Proof.
    destruct p as [k s]. unfold position_fits; cbn [fst snd]. intros (Hk & Hs & Near).
    assert (Sp : Rabs (edge_at_position side i (k, s) - unit * spline (edge_column side i rows) (INR k + s)) <= Q2R evaluation_error).
    { unfold edge_at_position; cbn [fst snd]. rewrite (edge_spline_in_segment rows n i side bezier_of_side rows_regular axis_below_n side_matches k (INR k + s)) by (fold K; lia || lra).
      replace (INR k + s - INR k) with s by ring.
      assert (Kk : (k + 3 < length rows)%nat) by (unfold K, segment_count in Hk; lia).
      assert (B : bezier_of_side (nth i (nth k (pieces rows) []) (zero_bezier, zero_bezier)) =
        bezier_of_spline (nth (k + 0) (edge_column side i rows) 0%Z) (nth (k + 1) (edge_column side i rows) 0%Z) (nth (k + 2) (edge_column side i rows) 0%Z) (nth (k + 3) (edge_column side i rows) 0%Z)).
      { destruct (is_regular_lengths _ _ rows_regular) as [_ Ln]. rewrite pieces_nth by exact Hk. rewrite (piece_of_rows_nth n) by (try apply Ln; lia). rewrite Nat.add_0_r.
        rewrite !edge_column_nth by (destruct side_matches as [[-> _]|[-> _]]; reflexivity). destruct side_matches as [[-> ->]|[-> ->]]; reflexivity. }
      rewrite B, <- cubic_blend_is_bezier. unfold cubic_blend. set (z := fun j => IZR (nth (k + j) (edge_column side i rows) 0%Z)).
      fold (z 0%nat) (z 1%nat) (z 2%nat) (z 3%nat).
      eapply Rle_trans; [right|apply (spline_evaluation_near format coefficient_max evaluation_error s (unit * z 0%nat) (unit * z 1%nat) (unit * z 2%nat) (unit * z 3%nat)); auto; apply coefficients_bounded].
      f_equal. f_equal. ring. }
    destruct (spline_time_range t_c rows t t_c_pos) as [A B]. fold K in B.
    assert (V0 : 0 <= IZR step_max) by (eapply (step_max_nonneg rows n i step_max side bezier_of_side); eauto).
    set (u := INR k + s) in *.
    assert (Ur : 0 <= u <= INR K) by (unfold u; pose proof (pos_INR k); assert (INR k + 1 <= INR K) by (rewrite <- S_INR; apply le_INR; lia); lra).
    assert (Lp : Rabs (spline (edge_column side i rows) u - spline (edge_column side i rows) (spline_time t_c rows t)) <= 3 * IZR step_max * time_error).
    { assert (G : forall a b, 0 <= a -> a <= b -> b <= INR K ->
        Rabs (spline (edge_column side i rows) b - spline (edge_column side i rows) a) <= 3 * IZR step_max * (b - a)).
      { intros a b Ha Hab Hb. apply (edge_spline_lipschitz rows n i step_max side bezier_of_side rows_regular axis_below_n side_matches steps_checked K); auto. }
      apply Rabs_le_between in Near.
      destruct (Rle_dec (spline_time t_c rows t) u).
      - apply Rle_trans with (3 * IZR step_max * (u - spline_time t_c rows t)); [apply G; lra|apply Rmult_le_compat_l; lra].
      - rewrite Rabs_minus_sym.
        apply Rle_trans with (3 * IZR step_max * (spline_time t_c rows t - u)); [apply G; lra|apply Rmult_le_compat_l; lra]. }
    assert (E : edge unit t_c rows side i t = unit * spline (edge_column side i rows) (spline_time t_c rows t)) by reflexivity.
    rewrite E. clear E. revert Sp Lp.
    generalize (edge_at_position side i (k, s)) (spline (edge_column side i rows) u) (spline (edge_column side i rows) (spline_time t_c rows t)).
    intros a b d Sp Lp. replace (a - unit * d) with ((a - unit * b) + unit * (b - d)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat; [exact Sp|].
    rewrite Rabs_mult, (Rabs_pos_eq unit) by lra. apply Rmult_le_compat_l; lra.
  Qed.

  (* The position of a time in seconds fits it, also where the clock rounded it once. *)
  Lemma position_of_time_fits clock t : clock_shows clock t -> position_fits t (position_of_time clock).
  Proof.
    intro Clock. pose proof (emitted_spline_time_range clock) as Ur. pose proof (emitted_spline_time_near_true clock t Clock) as Uo.
    pose proof (emitted_spline_time_in_format clock) as Uf. unfold position_fits, position_of_time. cbv zeta. set (u := emitted_spline_time clock) in *. cbn [fst snd].
    assert (Fl : Ztrunc u = Zfloor u) by (apply Ztrunc_floor; lra).
    assert (F0 : (0 <= Zfloor u)%Z) by (apply Zfloor_lub; lra).
    pose proof (Zfloor_lb u) as Lb. pose proof (Zfloor_ub u) as Ub.
    assert (Ek : INR (Z.to_nat (Ztrunc u)) = IZR (Zfloor u)) by (now rewrite Fl, INR_IZR_INZ, Z2Nat.id).
    rewrite Ek. assert (Pl := fractional_part_exact format u (Zfloor u) Uf ltac:(lra) F0). rewrite Pl.
    split; [apply INR_lt; lra|split; [lra|]]. replace (IZR (Zfloor u) + (u - IZR (Zfloor u))) with u by ring. exact Uo.
  Qed.
End Emitted.

(* Time in ticks, of tick_period seconds. *)
Section Ticks.
  Variables (format : format) (rows : table) (n : nat) (t_c time_error : R).
  Let K := segment_count rows.
  Hypothesis t_c_pos : 0 < t_c.
  Hypothesis rows_regular : is_regular n rows = true.

  (* A count of ticks, of which one takes `period` seconds. *)
  Variables (final_tick multiplier divisor : Z) (tick_period : R).
  Hypothesis ticks_pos : (0 < multiplier)%Z /\ (0 < divisor)%Z.
  Hypothesis ticks_reach_end : (divisor * Z.of_nat K <= final_tick * multiplier)%Z.
  Hypothesis ticks_keep_rate : IZR multiplier * t_c = IZR divisor * INR K * tick_period.
  Hypothesis time_error_covers_rounding : Q2R (half_ulp format) + Q2R (half_smallest format) <= time_error.

  Lemma parts_passed_is_minimum tick : (0 <= tick)%Z -> parts_passed rows final_tick multiplier divisor tick = Z.min (tick * multiplier) (divisor * Z.of_nat K).
  Proof. intro H. unfold parts_passed. cbv zeta. destruct ticks_pos. destruct (Z.min_spec tick final_tick) as [[C ->]|[C ->]]; [reflexivity|]. nia. Qed.
  (* The parts that have passed are the spline time exactly, in parts. *)
  Lemma parts_passed_is_spline_time tick : (0 <= tick)%Z -> IZR (parts_passed rows final_tick multiplier divisor tick) = IZR divisor * spline_time t_c rows (IZR tick * tick_period).
  Proof.
    intro H. destruct ticks_pos as [M0 D0]. apply IZR_lt in M0, D0. pose proof (IZR_le _ _ H) as H0.
    assert (Kp : 0 < INR K) by (apply lt_0_INR; destruct (is_regular_lengths _ _ rows_regular); unfold K, segment_count; lia).
    assert (P0 : 0 < tick_period).
    { assert (0 < IZR divisor * INR K) by (apply Rmult_lt_0_compat; lra). apply (Rmult_lt_reg_l (IZR divisor * INR K)); [lra|]. rewrite <- ticks_keep_rate, Rmult_0_r. apply Rmult_lt_0_compat; lra. }
    assert (I : IZR tick * IZR multiplier = IZR divisor * (INR K / t_c * (IZR tick * tick_period))).
    { apply (Rmult_eq_reg_r t_c); [|lra]. replace (IZR divisor * (INR K / t_c * (IZR tick * tick_period)) * t_c) with (IZR tick * (IZR divisor * INR K * tick_period)) by (field; lra). rewrite <- ticks_keep_rate. ring. }
    rewrite parts_passed_is_minimum by exact H. unfold spline_time, clamped_time. fold K. rewrite (Rmax_right 0) by (apply Rmin_glb; [apply Rmult_le_pos; lra|lra]).
    assert (R0 : 0 < INR K / t_c) by (apply Rdiv_lt_0_compat; lra).
    destruct (Z.min_spec (tick * multiplier) (divisor * Z.of_nat K)) as [[C ->]|[C ->]]; apply IZR_lt in C || apply IZR_le in C; rewrite !mult_IZR, <- INR_IZR_INZ in C.
    - rewrite mult_IZR, I. rewrite I in C. apply Rmult_lt_reg_l in C; [|lra]. rewrite Rmin_left; [reflexivity|].
      apply (Rmult_le_reg_l (INR K / t_c)); [lra|]. replace (INR K / t_c * t_c) with (INR K) by (field; lra). lra.
    - rewrite mult_IZR, <- INR_IZR_INZ. rewrite I in C. apply Rmult_le_reg_l in C; [|lra]. rewrite Rmin_right; [field; lra|].
      apply (Rmult_le_reg_l (INR K / t_c)); [lra|]. replace (INR K / t_c * t_c) with (INR K) by (field; lra). lra.
  Qed.
  (* The position of a tick fits its time. *)
  Lemma position_of_tick_fits tick : (0 <= tick)%Z -> position_fits rows t_c time_error (IZR tick * tick_period) (position_of_tick format rows final_tick multiplier divisor tick).
  Proof.
    intro H. assert (E := parts_passed_is_spline_time tick H). assert (M := parts_passed_is_minimum tick H). unfold position_fits, position_of_tick. cbv zeta. fold K. set (parts := parts_passed _ _ _ _ _) in *. cbn [fst snd].
    destruct ticks_pos as [M0 D0]. assert (Kp : (0 < Z.of_nat K)%Z) by (destruct (is_regular_lengths _ _ rows_regular); unfold K, segment_count; lia).
    assert (P : (0 <= parts <= divisor * Z.of_nat K)%Z) by nia.
    set (k := Z.min (parts / divisor) (Z.of_nat K - 1)).
    assert (Dv := Z.div_mod parts divisor ltac:(lia)). assert (Md := Z.mod_pos_bound parts divisor D0).
    assert (Q0 : (0 <= parts / divisor)%Z) by (apply Z.div_pos; lia).
    assert (K0 : (0 <= k <= Z.of_nat K - 1)%Z) by (unfold k; lia).
    assert (R0 : (0 <= parts - k * divisor <= divisor)%Z) by (unfold k; destruct (Z.min_spec (parts / divisor) (Z.of_nat K - 1)) as [[C ->]|[C ->]]; nia).
    assert (Dp := IZR_lt _ _ D0). destruct R0 as [R1 R2]. apply IZR_le in R1, R2.
    set (x := IZR (parts - k * divisor) / IZR divisor).
    assert (X : 0 <= x <= 1).
    { unfold x. split; [apply Rcomplements.Rle_div_r; lra|apply Rcomplements.Rle_div_l; lra]. }
    assert (One_in_format : generic_format radix2 (format_exponent format) 1).
    { apply generic_format_FLT. exists (Float radix2 1 0); [unfold F2R; cbn; ring| |]; destruct format; cbn; lia. }
    assert (S0 : 0 <= round_to_format format x <= 1).
    { unfold round_to_format. split; [apply round_ge_generic|apply round_le_generic]; try apply format_exponent_valid; try apply valid_rnd_N; try apply generic_format_0; try exact One_in_format; lra. }
    split; [lia|split; [exact S0|]].
    assert (Ex : INR (Z.to_nat k) + x = spline_time t_c rows (IZR tick * tick_period)).
    { rewrite INR_IZR_INZ, Z2Nat.id by lia. apply (Rmult_eq_reg_l (IZR divisor)); [|lra]. rewrite <- E. unfold x. rewrite minus_IZR, mult_IZR. field; lra. }
    rewrite <- Ex. replace (INR (Z.to_nat k) + round_to_format format x - (INR (Z.to_nat k) + x)) with (round_to_format format x - x) by ring.
    eapply Rle_trans; [apply round_to_format_error|]. rewrite (Rabs_pos_eq x) by lra. pose proof (half_ulp_range format).
    assert (x * Q2R (half_ulp format) <= 1 * Q2R (half_ulp format)) by (apply Rmult_le_compat_r; lra). lra.
  Qed.
End Ticks.
