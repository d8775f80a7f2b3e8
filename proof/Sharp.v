(* The whole chain under the sharp statement about samples: the controller as the reader finds it in the C text, run on the machine at every sample of the task's period,
   keeps every trajectory of the task's plant where the task wants it, and |e| below what the certificate says. *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra String.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Stt Require Import Tube Loop Speed Rounding Emitted EmittedTube Held HeldLaw Windows Period Syntax Read Run Emission Control Semantics Edge Law Controller Sound.
Import ListNotations.
Open Scope R_scope.

(* the law of the certificate is the one that is read in the text, and loses no less than is proved *)
Definition law_check (f : format) (k : constants) (task : Tube.task) (s : sampling) (gains : list Q) (c : Q) (limits : list (option Q)) : bool :=
  (Qle_bool (loss f k) (lost s) &&
   forallb (fun i => Qeq_bool (Period.gain (part s i)) (nth i gains 0%Q) && Qeq_bool (clamped (part s i)) c &&
     match limit (part s i), nth i limits None with None, None => true | Some m, Some m' => Qeq_bool m m' | _, _ => false end) (seq 0 (n task)))%bool.

Section Sharp.
  Variable f : format.
  Notation prec := (precision f).
  Notation emax := (largest_exponent f).
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).

  Variables (k : constants) (coefficients : list decimal) (lines : list string).
  Variables (unit err : Q) (depth : nat) (task : Tube.task) (rows : Tube.table) (Vs : list Z) (sc : scale) (late : Q) (gains : list Q) (c : Q) (limits : list (option Q)).
  Variables (s : sampling) (hints : list (list (Q * Q))) (cuts : nat).
  Hypothesis tube_checked : check unit err depth task rows = true.
  Hypothesis slopes_checked : slopes err task rows Vs = true.
  Hypothesis rounding_checked : rounding_check f unit err task rows Vs sc late = true.
  Hypothesis constants_checked : constants_check f k coefficients unit task rows sc gains c limits = true.
  Hypothesis period_checked : period_check unit task rows s hints cuts err = true.
  Hypothesis law_checked : law_check f k task s gains c limits = true.
  Let program := Source lines (emitted_tables k coefficients) (Emission.emitted k).

  Variable log_ : number -> number.
  Hypothesis log_accurate : written_out k = false -> accurate prec emax log_.

  Variables (taken switch : nat -> R) (x : nat -> R -> R) (push : nat -> R -> R) (G : nat -> nat -> R -> R).
  Variables (clock : nat -> number) (measured : nat -> nat -> number).
  Let L (i : nat) (t : R) := Tube.lower unit task rows i t.
  Let U (i : nat) (t : R) := Tube.upper unit task rows i t.
  Let input (p i : nat) : R := applied f log_ k program (clock p) (measured p) i.

  Hypothesis times : switch 0%nat = 0 /\ forall p, 0 <= taken p <= switch p /\ switch p < switch (S p) /\
    switch (S p) - taken p <= Q2R (tau_of s) /\ switch p - taken p <= Q2R (latency_of s).
  Hypothesis clock_reads : forall p, is_finite (clock p) = true /\ reads f (value (clock p)) (taken p).
  Hypothesis measures : forall p i, (i < n task)%nat -> is_finite (measured p i) = true /\ Rabs (value (measured p i)) <= 1073741824 /\
    Rabs (value (measured p i) - x i (taken p)) <= Q2R (shift (part s i)) - Q2R err.
  Hypothesis x_cont : forall i t, (i < n task)%nat -> continuity_pt (x i) t.
  Hypothesis x_start : forall i, (i < n task)%nat -> Rabs (2 * x i 0 - L i 0 - U i 0) <= Q2R (share_of s) * (U i 0 - L i 0).
  Hypothesis plant : forall p t, switch p < t < switch (S p) -> (forall i, (i < n task)%nat -> L i t < x i t < U i t) -> forall i, (i < n task)%nat ->
    is_derive (x i) t (push i t + total (n task) (fun j => G i j t * input p j)) /\
    Rabs (push i t) <= Q2R (pushed (part s i)) /\ Q2R (g_min (part s i)) <= G i i t <= Q2R (g_max (part s i)) /\
    forall j, (j < n task)%nat -> j <> i -> Rabs (G i j t) <= Q2R (g_cross (part s i)).

  Theorem controller_sound_sharp : forall p t, 0 <= t <= switch p ->
    (forall i, (i < n task)%nat -> Rabs (2 * x i t - L i t - U i t) <= (Q2R (rho_of (part s i)) - 1) / (Q2R (rho_of (part s i)) + 1) * (U i t - L i t)) /\
    (forall i, (i < n task)%nat -> at_ (lo (space task)) i < x i t < at_ (hi (space task)) i) /\
    (forall o, In o (unsafe task) -> exists i, (i < n task)%nat /\
      (x i t < at_ (lo o) i - Q2R (clearance task) \/ at_ (hi o) i + Q2R (clearance task) < x i t)) /\
    (Q2R (T task) <= t -> forall i, (i < n task)%nat -> at_ (lo (target task)) i < x i t < at_ (hi (target task)) i).
  Proof.
    apply (samples_reach_avoid_stay f unit err depth task rows Vs sc late s hints cuts tube_checked slopes_checked rounding_checked period_checked
      taken switch (fun p => value (clock p)) x (fun p i => value (measured p i)) input push G).
    - intro p. apply clock_reads.
    - exact times.
    - exact x_cont.
    - exact x_start.
    - intros p i Hi. apply (measures p i Hi).
    - intros p i Hi. destruct (clock_reads p) as [Fc Rc].
      destruct (control_acts f k coefficients lines unit err depth task rows Vs sc late gains c limits tube_checked slopes_checked rounding_checked constants_checked log_ log_accurate
        (clock p) (measured p) Fc (fun j Hj => proj1 (measures p j Hj)) (fun j Hj => proj1 (proj2 (measures p j Hj))) (taken p) Rc) as (out & status & E & _ & _ & St).
      destruct (St i Hi) as (v & V1 & _ & V3).
      assert (In : input p i = value v) by (unfold input, applied, program; rewrite E, V1; reflexivity).
      pose proof law_checked as H. unfold law_check in H. rewrite andb_true_iff, forallb_forall in H. destruct H as [H1 H2].
      assert (Hc := H2 i ltac:(apply in_seq; lia)). rewrite !andb_true_iff in Hc. destruct Hc as [[C1 C2] C3].
      apply Qle_true in H1.
      apply Qeq_bool_iff, Qeq_eqR in C1, C2. rewrite C1, C2, In.
      assert (Lm : option_map Q2R (limit (part s i)) = option_map Q2R (nth i limits None)).
      { destruct (limit (part s i)), (nth i limits None); try discriminate; cbn [option_map]; [|reflexivity]. f_equal. now apply Qeq_eqR, Qeq_bool_iff. }
      rewrite Lm.
      eapply acts_more; [exact H1|exact V3].
    - exact plant.
  Qed.
End Sharp.
