(* The whole chain: a controller as the reader finds it in the C text, run on the machine at every sample, keeps every trajectory of every plant within the conditions
   that are stated where the task wants it, and |e| below what the certificate says. *)
From Coq Require Import ZArith QArith Qreals Qminmax Qabs Reals List Bool Lia Lra String.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Stt Require Import Tube Loop Speed Rounding Emitted EmittedTube Held HeldLaw Windows Period Syntax Read Run Emission Control Semantics Edge Law Controller.
Import ListNotations.
Open Scope R_scope.

(* What is said of samples and of the plant xdot_i = f_i + sum over j of g_ij u_j; lists are by component. *)
Record conditions := Conditions {
  period : Q;            (* seconds between samples, at most *)
  latency : Q;           (* seconds from a sample to its input, at most *)
  share : Q;             (* |e(0)|, at most *)
  noise : Q;             (* of each measured x, besides its rounding *)
  forces : list Q;       (* |f_i|, drift and disturbance, at most *)
  least_gains : list Q;  (* g_ii, at least *)
  most_gains : list Q;   (* g_ii, at most *)
  cross_gains : list Q   (* |g_ij| for other j, at most *)
}.
Definition at_most_each (v : Q) (l : list Q) : bool := forallb (fun w => Qle_bool v w) l.

(* The largest coordinate of the state space: a float near it is rounded by half_ulp times that. *)
Definition farthest (b : box) : Q := fold_right (fun v m => Qmax (Qabs v) m) 0%Q (lo b ++ hi b).
(* What a measured state is wrong by at most. *)
Definition sensed (f : format) (task : Tube.task) (d : conditions) : Q := (noise d + half_ulp f * farthest (space task))%Q.

(* What a function of the text stores for component i, called with a time or a count of ticks and with the state x; 0 where it would not run. *)
Definition stored_by (f : format) (log_ : binary_float (precision f) (largest_exponent f) -> binary_float (precision f) (largest_exponent f))
  (k : constants) (program : source) (name : string) (v : Run.value (machine (precision f) (largest_exponent f) (Edge.pos_ f) (Edge.below_ f) log_))
  (x : nat -> binary_float (precision f) (largest_exponent f)) (i : nat) : R :=
  let A := machine (precision f) (largest_exponent f) (Edge.pos_ f) (Edge.below_ f) log_ in
  match execute A (log_name k) program name [v] (places_of A k (fun z => x (Z.to_nat z))) with
  | Some (out, _) => match stored (A := A) "u" (Z.of_nat i) out with Some v => @B2R (precision f) (largest_exponent f) v | None => 0 end
  | None => 0
  end.
Definition applied f log_ k program (t : binary_float (precision f) (largest_exponent f)) x i : R :=
  stored_by f log_ k program "@control" (@R_ (machine (precision f) (largest_exponent f) (Edge.pos_ f) (Edge.below_ f) log_) t) x i.
Definition applied_at_tick f log_ k program (tick : Z) x i : R :=
  stored_by f log_ k program "@control_tick" (@U_ (machine (precision f) (largest_exponent f) (Edge.pos_ f) (Edge.below_ f) log_) tick) x i.

(* What `period_check` decides on: the law as the text has it, the conditions, and two lists, of the certificate or chosen: rho, and what a distance that the law
   sees is wrong by. *)
Definition sampled_by (n : nat) (d : conditions) (lost : Q) (gains clamps : list Q) (limits : list (option Q)) (rhos shifts : list Q) : sampling :=
  Sampling (period d + latency d) (latency d) (share d) lost (map (fun i =>
    Component (nth i gains 0) (nth i clamps 0) (nth i limits None) (nth i rhos 0) (nth i (forces d) 0) (nth i (least_gains d) 0) (nth i (most_gains d) 0)
      (nth i (cross_gains d) 0) (nth i shifts 0)) (seq 0 n))%Q.
Lemma sampled_part n d lost gains clamps limits rhos shifts i : (i < n)%nat -> part (sampled_by n d lost gains clamps limits rhos shifts) i =
  (Component (nth i gains 0) (nth i clamps 0) (nth i limits None) (nth i rhos 0) (nth i (forces d) 0) (nth i (least_gains d) 0) (nth i (most_gains d) 0)
    (nth i (cross_gains d) 0) (nth i shifts 0))%Q.
Proof.
  intro H. unfold part, sampled_by. cbn [components].
  match goal with |- nth i (map ?g (seq 0 n)) nobody = _ => rewrite (nth_indep _ nobody (g 0%nat)) by (rewrite map_length, seq_length; exact H); rewrite (map_nth g) end.
  now rewrite seq_nth by exact H.
Qed.

Section Sound.
  Variable f : format.
  Notation prec := (precision f).
  Notation emax := (largest_exponent f).
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).

  (* the text, as read, and the checks *)
  Variables (k : constants) (coefficients : list decimal) (lines : list string).
  Variables (unit err : Q) (how : search) (task : Tube.task) (rows : Tube.table) (Vs : list Z) (sc : scale) (late : Q) (gains clamps : list Q) (limits : list (option Q)).
  Variables (d : conditions) (rhos shifts : list Q) (hints : list (list (Q * Q))) (cuts : nat).
  Let s := sampled_by (n task) d (loss f k) gains clamps limits rhos shifts.
  Hypothesis tube_checked : check unit err how task rows = true.
  Hypothesis slopes_checked : slopes err task rows Vs = true.
  Hypothesis rounding_checked : rounding_check f unit err task rows Vs sc late = true.
  Hypothesis constants_checked : constants_check f k coefficients unit task rows sc gains clamps limits = true.
  Hypothesis period_checked : period_check unit task rows s hints cuts err = true.
  Hypothesis sensors_checked : at_most_each (sensed f task d + err) (map shift (components s)) = true.
  Let program := Source lines (emitted_tables k coefficients) (Emission.emitted k).

  (* the library's logarithm, where the text calls it *)
  Variable log_ : number -> number.
  Hypothesis log_accurate : written_out k = false -> accurate prec emax log_.

  (* inputs are computed from samples, and act from one switch to the next *)
  Variables (taken switch : nat -> R) (x push : nat -> R -> R) (G : nat -> nat -> R -> R).
  Variable measured : nat -> nat -> number.
  Let L (i : nat) (t : R) := Tube.lower unit task rows i t.
  Let U (i : nat) (t : R) := Tube.upper unit task rows i t.

  Hypothesis times : switch 0%nat = 0 /\ forall p, 0 <= taken p <= switch p /\ switch p < switch (S p) /\
    switch (S p) - taken p <= Q2R (period d) + Q2R (latency d) /\ switch p - taken p <= Q2R (latency d).
  Hypothesis measures : forall p i, (i < n task)%nat -> is_finite (measured p i) = true /\ Rabs (value (measured p i)) <= 1073741824 /\
    Rabs (value (measured p i) - x i (taken p)) <= Q2R (sensed f task d).
  Hypothesis x_cont : forall i t, (i < n task)%nat -> continuity_pt (x i) t.
  Hypothesis x_start : forall i, (i < n task)%nat -> Rabs (2 * x i 0 - L i 0 - U i 0) <= Q2R (share d) * (U i 0 - L i 0).
  Definition plant_within (input : nat -> nat -> R) : Prop :=
    forall p t, switch p < t < switch (S p) -> (forall i, (i < n task)%nat -> L i t < x i t < U i t) -> forall i, (i < n task)%nat ->
    is_derive (x i) t (push i t + total (n task) (fun j => G i j t * input p j)) /\
    Rabs (push i t) <= at_ (forces d) i /\ at_ (least_gains d) i <= G i i t <= at_ (most_gains d) i /\
    forall j, (j < n task)%nat -> j <> i -> Rabs (G i j t) <= at_ (cross_gains d) i.
  Definition reached : Prop := forall p t, 0 <= t <= switch p ->
    (forall i, (i < n task)%nat -> Rabs (2 * x i t - L i t - U i t) <= (at_ rhos i - 1) / (at_ rhos i + 1) * (U i t - L i t)) /\
    in_space task (fun i => x i t) /\
    (forall o, In o (unsafe task) -> clear (n task) (Q2R (clearance task)) o (fun i => x i t)) /\
    (Q2R (T task) <= t -> in_target task (fun i => x i t)).

  (* For what a function of the text stores, whose edges at sample p are near the exact ones of its time. *)
  Lemma stored_sound name (v : nat -> Run.value (machine prec emax (Edge.pos_ f) (Edge.below_ f) log_)) (low high : nat -> nat -> R) :
    (forall p i, (i < n task)%nat -> Rabs (low p i - L i (taken p)) <= Q2R err /\ Rabs (high p i - U i (taken p)) <= Q2R err) ->
    (forall p, acts_between f k coefficients lines task gains clamps limits log_ (measured p) name (v p) (low p) (high p)) ->
    plant_within (fun p i => stored_by f log_ k program name (v p) (measured p) i) -> reached.
  Proof.
    intros Near Acts plant. set (input := fun p i => stored_by f log_ k program name (v p) (measured p) i) in plant.
    assert (Part : forall i, (i < n task)%nat -> part s i = (Component (nth i gains 0) (nth i clamps 0) (nth i limits None) (nth i rhos 0) (nth i (forces d) 0)
      (nth i (least_gains d) 0) (nth i (most_gains d) 0) (nth i (cross_gains d) 0) (nth i shifts 0))%Q) by (intros; now apply sampled_part).
    assert (Tau : Q2R (tau_of s) = Q2R (period d) + Q2R (latency d)) by apply Q2R_plus.
    intros p t Ht.
    destruct (samples_reach_avoid_stay unit err how task rows Vs s hints cuts tube_checked slopes_checked period_checked
      taken switch low high x (fun p i => value (measured p i)) input push G) with (p := p) (t := t) as (K1 & K2); auto.
    - rewrite Tau. exact times.
    - intros q i Hi. destruct (measures q i Hi) as (_ & _ & M). eapply Rle_trans; [exact M|].
      pose proof sensors_checked as H. unfold at_most_each in H. rewrite forallb_forall in H.
      assert (I : In (shift (part s i)) (map shift (components s))).
      { apply in_map. unfold part. apply nth_In. unfold s, sampled_by. cbn [components]. now rewrite map_length, seq_length. }
      apply H, Qle_true in I. rewrite Q2R_plus in I. lra.
    - intros q i Hi. destruct (Acts q) as (out & status & E & _ & _ & St).
      destruct (St i Hi) as (w & V1 & _ & V3).
      assert (In : input q i = value w) by (unfold input, stored_by, program; rewrite E, V1; reflexivity).
      rewrite (Part i Hi), In. cbn [Period.gain clamped limit]. exact V3.
    - intros q r Hr Hin i Hi. rewrite (Part i Hi). exact (plant q r Hr Hin i Hi).
    - split; [|exact K2]. intros i Hi. specialize (K1 i Hi). rewrite (Part i Hi) in K1. exact K1.
  Qed.

  (* `control`, for a clock that shows the time, right or rounded once; *)
  Theorem controller_sound (clock : nat -> number) : (forall p, is_finite (clock p) = true /\ reads f (value (clock p)) (taken p)) ->
    plant_within (fun p i => applied f log_ k program (clock p) (measured p) i) -> reached.
  Proof.
    intros clock_reads. destruct (emission_near f unit err how task rows Vs sc late tube_checked slopes_checked rounding_checked) as [Time Near].
    apply (stored_sound "@control" (fun p => @R_ (machine prec emax (Edge.pos_ f) (Edge.below_ f) log_) (clock p)) (fun p i => EmittedTube.emitted f unit rows sc fst i (value (clock p))) (fun p i => EmittedTube.emitted f unit rows sc snd i (value (clock p)))).
    - intros p i Hi. exact (Near i _ _ Hi (Time _ _ (proj2 (clock_reads p)))).
    - intro p. exact (control_acts f k coefficients lines unit err how task rows Vs sc late gains clamps limits tube_checked slopes_checked rounding_checked constants_checked log_ log_accurate
        (measured p) (fun j Hj => proj1 (measures p j Hj)) (fun j Hj => proj1 (proj2 (measures p j Hj))) (clock p) (proj1 (clock_reads p)) (taken p) (proj2 (clock_reads p))).
  Qed.

  (* and `control_tick`, for samples that are taken at counts of ticks. *)
  Theorem controller_tick_sound (tick_period : Q) (tick : nat -> Z) : tick_constants_check f k task rows late tick_period = true ->
    (forall p, (0 <= tick p <= 4294967295)%Z /\ taken p = IZR (tick p) * Q2R tick_period) ->
    plant_within (fun p i => applied_at_tick f log_ k program (tick p) (measured p) i) -> reached.
  Proof.
    intros Checked Ticks. destruct (emission_near f unit err how task rows Vs sc late tube_checked slopes_checked rounding_checked) as [_ Near].
    apply (stored_sound "@control_tick" (fun p => @U_ (machine prec emax (Edge.pos_ f) (Edge.below_ f) log_) (tick p)) (fun p i => at_place f unit rows fst i (tick_place_of f k rows (tick p))) (fun p i => at_place f unit rows snd i (tick_place_of f k rows (tick p)))).
    - intros p i Hi. destruct (Ticks p) as [[T0 _] ->]. exact (Near i _ _ Hi (tick_place_fits f k unit err how task rows late tube_checked tick_period (tick p) Checked T0)).
    - intro p. exact (control_tick_acts f k coefficients lines unit err how task rows Vs sc late gains clamps limits tube_checked slopes_checked rounding_checked constants_checked log_ log_accurate
        (measured p) (fun j Hj => proj1 (measures p j Hj)) (fun j Hj => proj1 (proj2 (measures p j Hj))) tick_period (tick p) Checked (proj1 (Ticks p))).
  Qed.
End Sound.
