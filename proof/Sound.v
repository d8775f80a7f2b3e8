(* The whole chain for a shipped controller: read from its C text and run on the machine at every sample, it keeps every trajectory of
   every plant within the stated conditions in the state space and clear of every unsafe set, and brings it into the target set by t_c;
   |e| stays bounded.

   It joins Controller.v (what the C computes) with Period.v (P9). Theorem files apply `controller_sound` and `controller_tick_sound` to
   a shipped controller (docs/theorem.md, theorems 3 and 4 about the controller). *)
From Coq Require Import ZArith QArith Qreals Qminmax Qabs Reals List Bool Lia Lra String.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Stt Require Import Tube Loop Speed Rounding Emitted EmittedTube HeldInputs HeldInputLaw Windows Period Syntax Read Run Emission Control Semantics Edge Law Controller.
Import ListNotations.
Open Scope R_scope.

(* The conditions on samples and on the plant xdot_i = f_i + sum over j of g_ij u_j; lists are by component. *)
Record conditions := Conditions {
  sampling_period : Q;          (* largest time between samples, in seconds *)
  input_delay : Q;              (* largest age of a sample when its input acts, in seconds *)
  start_share : Q;              (* largest |e| at 0 *)
  sensor_noise : Q;             (* largest error of a measured coordinate, before it is rounded *)
  forces_max : list Q;          (* bound on |f_i|, drift and disturbance *)
  diagonal_gains_min : list Q;  (* lower bound on g_ii *)
  diagonal_gains_max : list Q;  (* upper bound on g_ii *)
  cross_gains_max : list Q      (* bound on |g_ij| for other j *)
}.
(* v is at most every number of the list. *)
Definition at_most_all (v : Q) (l : list Q) : bool := forallb (fun w => Qle_bool v w) l.

(* The largest coordinate of a box, in size: a float near it is rounded by half_ulp times that. *)
Definition largest_coordinate (b : box) : Q := fold_right (fun v m => Qmax (Qabs v) m) 0%Q (lower_corner b ++ upper_corner b).
(* The largest error of a measured coordinate, rounding included. *)
Definition sensor_error (f : format) (spec : Tube.task) (conds : conditions) : Q := (sensor_noise conds + half_ulp f * largest_coordinate (state_space spec))%Q.

(* What a function of the text stores for component i, called with a time or a count of ticks and with the state x; 0 where it does not
   end. *)
Definition stored_input (f : format) (log_ : binary_float (precision f) (largest_exponent f) -> binary_float (precision f) (largest_exponent f))
  (consts : constants) (program : source) (name : string) (v : Run.c_value (machine (precision f) (largest_exponent f) (Edge.precision_pos_instance f) (Edge.precision_below_instance f) log_))
  (x : nat -> binary_float (precision f) (largest_exponent f)) (i : nat) : R :=
  let A := machine (precision f) (largest_exponent f) (Edge.precision_pos_instance f) (Edge.precision_below_instance f) log_ in
  match execute A (log_name consts) program name [v] (caller_arrays A consts (fun z => x (Z.to_nat z))) with
  | Some (out, _) => match last_stored (A := A) "u" (Z.of_nat i) out with Some v => @B2R (precision f) (largest_exponent f) v | None => 0 end
  | None => 0
  end.
(* What `control` stores at time t, and what `control_tick` stores at a tick. *)
Definition applied_input f log_ consts program (t : binary_float (precision f) (largest_exponent f)) x i : R :=
  stored_input f log_ consts program "@control" (@RealValue (machine (precision f) (largest_exponent f) (Edge.precision_pos_instance f) (Edge.precision_below_instance f) log_) t) x i.
Definition applied_input_at_tick f log_ consts program (tick : Z) x i : R :=
  stored_input f log_ consts program "@control_tick" (@UnsignedValue (machine (precision f) (largest_exponent f) (Edge.precision_pos_instance f) (Edge.precision_below_instance f) log_) tick) x i.

(* The sampled loop that `period_check` decides about: the law of the text, the conditions, and two lists from the certificate, rho and
   the error of a distance that the law measures. *)
Definition sampling_of (n : nat) (conds : conditions) (law_error : Q) (gains clamp_shares : list Q) (limits : list (option Q)) (rhos shifts : list Q) : sampling :=
  Sampling (sampling_period conds + input_delay conds) (input_delay conds) (start_share conds) law_error (map (fun i =>
    Component (nth i gains 0) (nth i clamp_shares 0) (nth i limits None) (nth i rhos 0) (nth i (forces_max conds) 0) (nth i (diagonal_gains_min conds) 0) (nth i (diagonal_gains_max conds) 0)
      (nth i (cross_gains_max conds) 0) (nth i shifts 0)) (seq 0 n))%Q.
Lemma sampling_of_component n conds law_error gains clamp_shares limits rhos shifts i : (i < n)%nat -> component_at (sampling_of n conds law_error gains clamp_shares limits rhos shifts) i =
  (Component (nth i gains 0) (nth i clamp_shares 0) (nth i limits None) (nth i rhos 0) (nth i (forces_max conds) 0) (nth i (diagonal_gains_min conds) 0) (nth i (diagonal_gains_max conds) 0)
    (nth i (cross_gains_max conds) 0) (nth i shifts 0))%Q.
Proof.
  intro H. unfold component_at, sampling_of. cbn [components].
  match goal with |- nth i (map ?g (seq 0 n)) zero_component = _ => rewrite (nth_indep _ zero_component (g 0%nat)) by (rewrite map_length, seq_length; exact H); rewrite (map_nth g) end.
  now rewrite seq_nth by exact H.
Qed.

(* A text as it was read, the checks, and a sampled loop. Input p is computed from the sample of time sampled_at p and acts from
   acts_from p on; x is the trajectory, `measured p` what the sensors say at that time. *)
Section Sound.
  Variable f : format.
  Notation prec := (precision f).
  Notation emax := (largest_exponent f).
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).

  Variables (consts : constants) (coefficients : list decimal) (directive_lines : list string).
  Variables (unit edge_error : Q) (plan : search_plan) (spec : Tube.task) (rows : Tube.table) (step_maxima : list Z) (scale : time_scale) (time_error : Q) (gains clamp_shares : list Q) (limits : list (option Q)).
  Variables (conds : conditions) (rhos shifts : list Q) (hints : list (list (Q * Q))) (cell_count : nat).
  Let sampling := sampling_of (n spec) conds (law_loss f consts) gains clamp_shares limits rhos shifts.
  Hypothesis tube_checked : tube_check unit edge_error plan spec rows = true.
  Hypothesis slopes_checked : slopes_check edge_error spec rows step_maxima = true.
  Hypothesis rounding_checked : rounding_check f unit edge_error spec rows step_maxima scale time_error = true.
  Hypothesis constants_checked : constants_check f consts coefficients unit spec rows scale gains clamp_shares limits = true.
  Hypothesis period_checked : period_check unit spec rows sampling hints cell_count edge_error = true.
  Hypothesis sensors_checked : at_most_all (sensor_error f spec conds + edge_error) (map component_distance_error (components sampling)) = true.
  Let program := Source directive_lines (emitted_tables consts coefficients) (Emission.emitted_functions consts).

  (* The library's logarithm; it is assumed to be accurate only where the text calls it. *)
  Variable log_ : number -> number.
  Hypothesis log_accurate : has_inline_log consts = false -> accurate prec emax log_.

  Variables (sampled_at acts_from : nat -> R) (x push : nat -> R -> R) (G : nat -> nat -> R -> R).
  Variable measured : nat -> nat -> number.
  Let L (i : nat) (t : R) := Tube.lower unit spec rows i t.
  Let U (i : nat) (t : R) := Tube.upper unit spec rows i t.

  Hypothesis times_ordered : acts_from 0%nat = 0 /\ forall p, 0 <= sampled_at p <= acts_from p /\ acts_from p < acts_from (S p) /\
    acts_from (S p) - sampled_at p <= Q2R (sampling_period conds) + Q2R (input_delay conds) /\ acts_from p - sampled_at p <= Q2R (input_delay conds).
  Hypothesis measurements_near : forall p i, (i < n spec)%nat -> is_finite (measured p i) = true /\ Rabs (value (measured p i)) <= 1073741824 /\
    Rabs (value (measured p i) - x i (sampled_at p)) <= Q2R (sensor_error f spec conds).
  Hypothesis x_continuous : forall i t, (i < n spec)%nat -> continuity_pt (x i) t.
  Hypothesis x_starts_in_share : forall i, (i < n spec)%nat -> Rabs (2 * x i 0 - L i 0 - U i 0) <= Q2R (start_share conds) * (U i 0 - L i 0).
  (* The plant, driven by these inputs, is within the conditions. *)
  Definition plant_within (input : nat -> nat -> R) : Prop :=
    forall p t, acts_from p < t < acts_from (S p) -> (forall i, (i < n spec)%nat -> L i t < x i t < U i t) -> forall i, (i < n spec)%nat ->
    is_derive (x i) t (push i t + total (n spec) (fun j => G i j t * input p j)) /\
    Rabs (push i t) <= real_at (forces_max conds) i /\ real_at (diagonal_gains_min conds) i <= G i i t <= real_at (diagonal_gains_max conds) i /\
    forall j, (j < n spec)%nat -> j <> i -> Rabs (G i j t) <= real_at (cross_gains_max conds) i.
  (* The trajectory stays in the state space, is clear of every unsafe set, and is in the target set from t_c on; |e| is bounded by rho. *)
  Definition reach_avoid_stay_holds : Prop := forall p t, 0 <= t <= acts_from p ->
    (forall i, (i < n spec)%nat -> Rabs (2 * x i t - L i t - U i t) <= (real_at rhos i - 1) / (real_at rhos i + 1) * (U i t - L i t)) /\
    in_space spec (fun i => x i t) /\
    (forall o, In o (unsafe_sets spec) -> clear (n spec) (Q2R (clearance spec)) o (fun i => x i t)) /\
    (Q2R (t_c spec) <= t -> in_target spec (fun i => x i t)).

  (* That holds for a function of the text whose edges at every sample are near the exact ones of its time. *)
  Lemma stored_inputs_reach_avoid_stay name (v : nat -> Run.c_value (machine prec emax (Edge.precision_pos_instance f) (Edge.precision_below_instance f) log_)) (low high : nat -> nat -> R) :
    (forall p i, (i < n spec)%nat -> Rabs (low p i - L i (sampled_at p)) <= Q2R edge_error /\ Rabs (high p i - U i (sampled_at p)) <= Q2R edge_error) ->
    (forall p, runs_as_law f consts coefficients directive_lines spec gains clamp_shares limits log_ (measured p) name (v p) (low p) (high p)) ->
    plant_within (fun p i => stored_input f log_ consts program name (v p) (measured p) i) -> reach_avoid_stay_holds.
  Proof.
    intros Near Acts plant. set (input := fun p i => stored_input f log_ consts program name (v p) (measured p) i) in plant.
    assert (Part : forall i, (i < n spec)%nat -> component_at sampling i = (Component (nth i gains 0) (nth i clamp_shares 0) (nth i limits None) (nth i rhos 0) (nth i (forces_max conds) 0)
      (nth i (diagonal_gains_min conds) 0) (nth i (diagonal_gains_max conds) 0) (nth i (cross_gains_max conds) 0) (nth i shifts 0))%Q) by (intros; now apply sampling_of_component).
    assert (Tau : Q2R (sampling_age_max sampling) = Q2R (sampling_period conds) + Q2R (input_delay conds)) by apply Q2R_plus.
    intros p t Ht.
    destruct (sampled_loop_reach_avoid_stay unit edge_error plan spec rows step_maxima sampling hints cell_count tube_checked slopes_checked period_checked
      sampled_at acts_from low high x (fun p i => value (measured p i)) input push G) with (p := p) (t := t) as (K1 & K2); auto.
    - rewrite Tau. exact times_ordered.
    - intros q i Hi. destruct (measurements_near q i Hi) as (_ & _ & M). eapply Rle_trans; [exact M|].
      pose proof sensors_checked as H. unfold at_most_all in H. rewrite forallb_forall in H.
      assert (I : In (component_distance_error (component_at sampling i)) (map component_distance_error (components sampling))).
      { apply in_map. unfold component_at. apply nth_In. unfold sampling, sampling_of. cbn [components]. now rewrite map_length, seq_length. }
      apply H, Qle_bool_to_R in I. rewrite Q2R_plus in I. lra.
    - intros q i Hi. destruct (Acts q) as (out & status & E & _ & _ & St).
      destruct (St i Hi) as (w & V1 & _ & V3).
      assert (In : input q i = value w) by (unfold input, stored_input, program; rewrite E, V1; reflexivity).
      rewrite (Part i Hi), In. cbn [Period.component_gain component_clamp_share component_u_limit]. exact V3.
    - intros q r Hr Hin i Hi. rewrite (Part i Hi). exact (plant q r Hr Hin i Hi).
    - split; [|exact K2]. intros i Hi. specialize (K1 i Hi). rewrite (Part i Hi) in K1. exact K1.
  Qed.

  (* It holds for `control`, with a clock that shows the time, right or rounded once. *)
  Theorem controller_sound (clock : nat -> number) : (forall p, is_finite (clock p) = true /\ clock_shows f (value (clock p)) (sampled_at p)) ->
    plant_within (fun p i => applied_input f log_ consts program (clock p) (measured p) i) -> reach_avoid_stay_holds.
  Proof.
    intros clock_reads. destruct (emitted_edges_near f unit edge_error plan spec rows step_maxima scale time_error tube_checked slopes_checked rounding_checked) as [Time Near].
    apply (stored_inputs_reach_avoid_stay "@control" (fun p => @RealValue (machine prec emax (Edge.precision_pos_instance f) (Edge.precision_below_instance f) log_) (clock p)) (fun p i => EmittedTube.emitted_edge f unit rows scale fst i (value (clock p))) (fun p i => EmittedTube.emitted_edge f unit rows scale snd i (value (clock p)))).
    - intros p i Hi. exact (Near i _ _ Hi (Time _ _ (proj2 (clock_reads p)))).
    - intro p. exact (control_runs_as_law f consts coefficients directive_lines unit edge_error plan spec rows step_maxima scale time_error gains clamp_shares limits tube_checked slopes_checked rounding_checked constants_checked log_ log_accurate
        (measured p) (fun j Hj => proj1 (measurements_near p j Hj)) (fun j Hj => proj1 (proj2 (measurements_near p j Hj))) (clock p) (proj1 (clock_reads p)) (sampled_at p) (proj2 (clock_reads p))).
  Qed.

  (* It holds for `control_tick`, with samples at counts of ticks. *)
  Theorem controller_tick_sound (tick_period : Q) (tick : nat -> Z) : tick_constants_check f consts spec rows time_error tick_period = true ->
    (forall p, (0 <= tick p <= 4294967295)%Z /\ sampled_at p = IZR (tick p) * Q2R tick_period) ->
    plant_within (fun p i => applied_input_at_tick f log_ consts program (tick p) (measured p) i) -> reach_avoid_stay_holds.
  Proof.
    intros Checked Ticks. destruct (emitted_edges_near f unit edge_error plan spec rows step_maxima scale time_error tube_checked slopes_checked rounding_checked) as [_ Near].
    apply (stored_inputs_reach_avoid_stay "@control_tick" (fun p => @UnsignedValue (machine prec emax (Edge.precision_pos_instance f) (Edge.precision_below_instance f) log_) (tick p)) (fun p i => emitted_edge_at f unit rows fst i (tick_position f consts rows (tick p))) (fun p i => emitted_edge_at f unit rows snd i (tick_position f consts rows (tick p)))).
    - intros p i Hi. destruct (Ticks p) as [[T0 _] ->]. exact (Near i _ _ Hi (tick_position_fits_time f consts unit edge_error plan spec rows time_error tube_checked tick_period (tick p) Checked T0)).
    - intro p. exact (control_tick_runs_as_law f consts coefficients directive_lines unit edge_error plan spec rows step_maxima scale time_error gains clamp_shares limits tube_checked slopes_checked rounding_checked constants_checked log_ log_accurate
        (measured p) (fun j Hj => proj1 (measurements_near p j Hj)) (fun j Hj => proj1 (proj2 (measurements_near p j Hj))) tick_period (tick p) Checked (proj1 (Ticks p))).
  Qed.
End Sound.
