(* The whole chain: a controller as the reader finds it in the C text, run on the machine at every sample, keeps every trajectory of the plant where the task wants it. *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra String.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Stt Require Import Tube Loop Speed Rounding Emitted EmittedTube Held HeldLaw Syntax Read Run Emission Control Semantics Edge Law Controller Uniform.
Import ListNotations.
Open Scope R_scope.

(* what `control` stores for component i, called at time t with the state x; 0 where it would not run *)
Definition applied (f : format) (log_ : binary_float (precision f) (largest_exponent f) -> binary_float (precision f) (largest_exponent f))
  (k : constants) (program : source) (t : binary_float (precision f) (largest_exponent f)) (x : nat -> binary_float (precision f) (largest_exponent f)) (i : nat) : R :=
  let A := machine (precision f) (largest_exponent f) (Edge.pos_ f) (Edge.below_ f) log_ in
  match execute A (log_name k) program "@control" [@R_ A t] (places_of A k (fun z => x (Z.to_nat z))) with
  | Some (out, _) => match stored (A := A) "u" (Z.of_nat i) out with Some v => @B2R (precision f) (largest_exponent f) v | None => 0 end
  | None => 0
  end.

Section Sound.
  Variable f : format.
  Notation prec := (precision f).
  Notation emax := (largest_exponent f).
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).

  (* the text, as read, and the checks *)
  Variables (k : constants) (coefficients : list decimal) (lines : list string).
  Variables (unit err : Q) (depth : nat) (task : Tube.task) (rows : Tube.table) (Vs : list Z) (s : scale) (late : Q) (gains : list Q) (c : Q) (limits : list (option Q)) (P : plant).
  Hypothesis tube_checked : check unit err depth task rows = true.
  Hypothesis slopes_checked : slopes err task rows Vs = true.
  Hypothesis rounding_checked : rounding_check f unit err task rows Vs s late = true.
  Hypothesis constants_checked : constants_check f k coefficients unit task rows s gains c limits = true.
  Hypothesis plant_checked : plant_check unit err depth task rows Vs gains c (loss f k) limits P = true.
  Let program := Source lines (emitted_tables k coefficients) (Emission.emitted k).

  (* the library's logarithm, where the text calls it *)
  Variable log_ : number -> number.
  Hypothesis log_accurate : written_out k = false -> accurate prec emax log_.

  (* the plant: component i has the derivative y + g u, where y is all but its own input; inputs are computed from samples, and act from one switch to the next *)
  Variables (taken switch : nat -> R) (x : nat -> R -> R) (y g : nat -> nat -> R -> R).
  Variables (clock : nat -> number) (measured : nat -> nat -> number).
  Let L (i : nat) (t : R) := Tube.lower unit task rows i t.
  Let U (i : nat) (t : R) := Tube.upper unit task rows i t.
  Let input (p i : nat) : R := applied f log_ k program (clock p) (measured p) i.

  Hypothesis times : switch 0%nat = 0 /\ forall p, 0 <= taken p <= switch p /\ switch p < switch (S p) /\
    switch (S p) - taken p <= Q2R (tau_ P) /\ switch p - taken p <= Q2R (latency_ P).
  Hypothesis x_cont : forall i t, (i < n task)%nat -> continuity_pt (x i) t.
  (* the start: |e| <= (rho - 1)/(rho + 1) *)
  Hypothesis start : forall i, (i < n task)%nat ->
    (U i 0 - L i 0) * / (1 + Q2R (nth i (rho_ P) 0%Q)) <= x i 0 - L i 0 /\ (U i 0 - L i 0) * / (1 + Q2R (nth i (rho_ P) 0%Q)) <= U i 0 - x i 0.
  Hypothesis ode : forall p t, switch p < t < switch (S p) -> (forall i, (i < n task)%nat -> L i t < x i t < U i t) -> forall i, (i < n task)%nat ->
    is_derive (x i) t (y i p t + g i p t * input p i) /\
    Rabs (y i p t) <= Q2R (nth i (push_ P) 0%Q) + Q2R (nth i (cross_ P) 0%Q) * others (n task) i (fun j => Rabs (input p j)) /\
    Q2R (nth i (gmin_ P) 0%Q) <= g i p t <= Q2R (nth i (gmax_ P) 0%Q).
  (* the clock is right but for one rounding, and a measured state for the noise *)
  Hypothesis clock_reads : forall p, is_finite (clock p) = true /\ reads f (value (clock p)) (taken p).
  Hypothesis measures : forall p i, (i < n task)%nat -> is_finite (measured p i) = true /\ Rabs (value (measured p i)) <= 1073741824 /\
    Rabs (value (measured p i) - x i (taken p)) <= Q2R (noise_ P).

  Lemma law_of_control p i : (i < n task)%nat -> exists a b,
    Rabs (a - (x i (taken p) - L i (taken p))) <= Q2R (eta err P) /\ Rabs (b - (U i (taken p) - x i (taken p))) <= Q2R (eta err P) /\ 0 < a + b /\
    acts (Q2R (nth i gains 0%Q)) (Q2R c) (Q2R (loss f k)) (option_map Q2R (nth i limits None)) a b (input p i).
  Proof.
    intro Hi. destruct (clock_reads p) as [Fc Rc].
    destruct (control_acts f k coefficients lines unit err depth task rows Vs s late gains c limits tube_checked slopes_checked rounding_checked constants_checked log_ log_accurate
      (clock p) (measured p) Fc (fun j Hj => proj1 (measures p j Hj)) (fun j Hj => proj1 (proj2 (measures p j Hj))) (taken p) Rc) as (out & status & E & _ & _ & St).
    destruct (St i Hi) as (v & V1 & _ & V3).
    assert (In : input p i = value v) by (unfold input, applied, program; rewrite E, V1; reflexivity).
    destruct (measures p i Hi) as (_ & _ & Ms).
    set (ck := fun r => if Req_EM_T r (taken p) then value (clock p) else r).
    assert (Cl : forall r, reads f (ck r) r).
    { intro r. unfold ck. destruct (Req_EM_T r (taken p)) as [->|_]; [exact Rc|]. unfold reads. rewrite Rminus_diag_eq, Rabs_R0 by reflexivity.
      apply Rplus_le_le_0_compat; [apply Rmult_le_pos; [apply Rabs_pos|apply half_ulp_range]|apply half_least_pos]. }
    assert (Et : ck (taken p) = value (clock p)) by (unfold ck; destruct (Req_EM_T (taken p) (taken p)); [reflexivity|congruence]).
    destruct (emitted_near f unit err depth task rows Vs s late tube_checked slopes_checked rounding_checked ck Cl i (taken p) Hi) as [Nl Nu].
    destruct (emitted_tube_sound f unit err depth task rows Vs s late tube_checked slopes_checked rounding_checked ck Cl) as (P1 & _).
    specialize (P1 i (taken p) Hi). cbv beta in Nl, Nu, P1. rewrite Et in Nl, Nu, P1.
    assert (W := width_size _ _ _ _ _ _ _ _ _ _ (all_checked f k coefficients unit err depth task rows Vs s late gains c limits tube_checked rounding_checked constants_checked (clock p))).

    exists (value (measured p i) - EmittedTube.emitted f unit rows s fst i (value (clock p))), (EmittedTube.emitted f unit rows s snd i (value (clock p)) - value (measured p i)).
    apply Rabs_le_between in Ms, Nl, Nu. unfold eta. rewrite Q2R_plus. fold (L i (taken p)) in Nl. fold (U i (taken p)) in Nu.
    split; [apply Rabs_le; lra|split; [apply Rabs_le; lra|split; [lra|]]].
    rewrite In. exact V3.
  Qed.

  (* at all times: in the state space, the clearance away from every unsafe set, and from t_c on in the target set *)
  Theorem controller_sound : forall p t, 0 <= t <= switch p ->
    (forall i, (i < n task)%nat -> at_ (lo (space task)) i < x i t < at_ (hi (space task)) i) /\
    (forall o, In o (unsafe task) -> exists i, (i < n task)%nat /\
      (x i t < at_ (lo o) i - Q2R (clearance task) \/ at_ (hi o) i + Q2R (clearance task) < x i t)) /\
    (Q2R (T task) <= t -> forall i, (i < n task)%nat -> at_ (lo (target task)) i < x i t < at_ (hi (target task)) i).
  Proof.
    intros p t Ht.
    assert (K := held unit err depth task rows Vs gains c (loss f k) limits P tube_checked slopes_checked plant_checked taken switch x y g input times x_cont start ode law_of_control p t Ht).
    pose proof tube_checked as Ck. unfold check in Ck. cbv zeta in Ck. rewrite !andb_true_iff in Ck. destruct Ck as [[[Up Tp] Rg] _].
    pose proof slopes_checked as Sl. unfold slopes in Sl. rewrite !andb_true_iff in Sl. destruct Sl as [[_ Er] _]. apply Qle_true in Er. rewrite Q2R_0 in Er.
    destruct (tube_sound unit err Up task rows depth tube_checked L U) as (P1 & P2 & P3 & P4 & P5).
    { intros i r _. unfold L, U. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. lra. }
    assert (I : forall i, (i < n task)%nat -> L i t < x i t < U i t).
    { intros i Hi. destruct (K i Hi) as [K1 K2]. destruct (widths_ok unit err depth task rows Vs gains c (loss f k) limits P tube_checked plant_checked i t Hi) as [W _].
      pose proof plant_checked as H. unfold plant_check in H. rewrite !andb_true_iff in H. destruct H as [_ Cc]. rewrite forallb_forall in Cc.
      assert (Ci := Cc i ltac:(apply in_seq; lia)). unfold component_check in Ci. rewrite !andb_true_iff in Ci.
      assert (R1 : 1 <= Q2R (nth i (rho_ P) 0%Q)) by (rewrite <- Q2R_1; apply Qle_true; tauto).
      assert (D0 : 0 < Q2R (nth i (narrowest P) 0%Q)) by (rewrite <- Q2R_0; apply Qless_ok; tauto).
      assert (0 < / (1 + Q2R (nth i (rho_ P) 0%Q))) by (apply Rinv_0_lt_compat; lra). fold (L i t) (U i t) in K1, K2, W.
      assert (0 < (U i t - L i t) * / (1 + Q2R (nth i (rho_ P) 0%Q))) by (apply Rmult_lt_0_compat; unfold L, U in *; lra). unfold L, U in *. lra. }
    split; [|split].
    - intros i Hi. destruct (I i Hi), (P3 i t Hi). lra.
    - intros o Ho. destruct (P4 o t Ho) as (i & Hi & D). exists i; split; [exact Hi|]. destruct (I i Hi). destruct D; [left|right]; lra.
    - intros Htc i Hi. destruct (I i Hi), (P5 i t Hi Htc). lra.
  Qed.
End Sound.
