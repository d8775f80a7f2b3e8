(* reach-avoid-stay under a zero-order hold, for a checked table and numbers that satisfy three inequalities *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra Psatz.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed Sampled.
Import ListNotations.
Open Scope R_scope.

Section SampledTube.
  Variables (unit err : Q) (depth : nat) (k : task) (rows : table) (Vs : list Z).
  Hypothesis checked : check unit err depth k rows = true.
  Hypothesis more : slopes err k rows Vs = true.
  Let L (i : nat) (t : R) := lower unit k rows i t.
  Let U (i : nat) (t : R) := upper unit k rows i t.
  Let tc := Q2R (T k).
  Definition speed (i : nat) : R := Q2R unit * (3 * IZR (nth i Vs 0%Z)) * (INR (segments rows) / tc).

  Variables (h : R) (N : nat) (gain gmin gmax F near far : nat -> R).
  Variables x f g : nat -> R -> R.
  Let D (i : nat) : R := at_ (hi (space k)) i - at_ (lo (space k)) i.
  Let d : R := Q2R (min_width k).
  Let largest (i : nat) : R := gain i * (2 / near i) * ln (D i / near i).
  Hypothesis h_pos : 0 < h.
  Hypothesis numbers : forall i, (i < n k)%nat -> 0 < gain i /\ 0 < gmin i /\ 0 <= F i /\ 0 < near i /\ 2 * far i <= d /\
    F i + speed i <= gmin i * (gain i * / far i * ln ((d - far i) / far i)) /\
    (F i + speed i + gmax i * largest i) * h <= far i - near i.
  Hypothesis x_cont : forall i t, (i < n k)%nat -> continuity_pt (x i) t.
  Hypothesis x_start : forall i, (i < n k)%nat -> x i 0 = at_ (x0 k) i /\ near i <= x i 0 - L i 0 /\ near i <= U i 0 - x i 0.
  Let input (p i : nat) : R := law (gain i) (x i (INR p * h) - L i (INR p * h)) (U i (INR p * h) - x i (INR p * h)).
  Hypothesis ode : forall p t, (p < N)%nat -> INR p * h < t < INR p * h + h ->
    (forall i, (i < n k)%nat -> L i t < x i t < U i t) -> forall i, (i < n k)%nat ->
    is_derive (x i) t (f i t + g i t * input p i) /\ Rabs (f i t) <= F i /\ gmin i <= g i t <= gmax i.

  Theorem sampled_reach_avoid_stay : forall p t, (p < N)%nat -> INR p * h <= t <= INR p * h + h ->
    (forall i, (i < n k)%nat -> at_ (lo (space k)) i < x i t < at_ (hi (space k)) i) /\
    (forall o, In o (unsafe k) -> exists i, (i < n k)%nat /\
      (x i t < at_ (lo o) i - Q2R (clearance k) \/ at_ (hi o) i + Q2R (clearance k) < x i t)) /\
    (tc <= t -> forall i, (i < n k)%nat -> at_ (lo (target k)) i < x i t < at_ (hi (target k)) i).
  Proof.
    pose proof checked as C. unfold check in C. cbv zeta in C. rewrite !andb_true_iff in C. destruct C as [[[Up Tp] Rg] _].
    unfold slopes in more. rewrite !andb_true_iff, forallb_forall in more. destruct more as [[Mw Er] St].
    assert (E0 : 0 <= Q2R err) by (apply Qle_bool_iff, Qle_Rle in Er; unfold Q2R in Er at 1; cbn in Er; lra).
    assert (Tp' := positive_ok _ Tp). assert (Up' := positive_ok _ Up). assert (Mw' := positive_ok _ Mw).
    destruct (tube_sound unit err Up k rows depth checked L U) as (P1 & P2 & P3 & P4 & P5).
    { intros i t _. unfold L, U. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. lra. }
    assert (V0 : forall i, (i < n k)%nat -> 0 <= speed i).
    { intros i Hi. unfold speed.
      assert (0 <= IZR (nth i Vs 0%Z)).
      { apply (V_nonneg rows (n k) i _ fst fst); auto. apply St, in_seq; lia. }
      assert (0 <= INR (segments rows) / tc) by (apply Rmult_le_pos; [apply pos_INR|left; apply Rinv_0_lt_compat; exact Tp']).
      apply Rmult_le_pos; [apply Rmult_le_pos; lra|easy]. }
    assert (Lip : forall i, (i < n k)%nat -> lipschitz (speed i) (L i) /\ lipschitz (speed i) (U i)).
    { intros i Hi; split; apply (edge_lip (n k)); auto; apply St, in_seq; lia. }
    assert (Keep : forall p t, (p < N)%nat -> INR p * h <= t <= INR p * h + h -> keeps (n k) near L U x t).
    { apply (sampled_stays (n k) h N gmin gmax F speed near far largest L U x f g input); auto.
      - intros i Hi; apply numbers, Hi.
      - intros i Hi; split; [apply numbers, Hi|apply V0, Hi].
      - intros i Hi; apply numbers, Hi.
      - intros i Hi; apply Lip, Hi.
      - intros i Hi; apply Lip, Hi.
      - intros i Hi; apply x_start, Hi.
      - intros p Hp Kp i Hi. set (s := INR p * h) in *. destruct (Kp i Hi) as [K1 K2].
        destruct (numbers i Hi) as (k0 & g0 & F0 & n0 & fd & Q1 & Q2).
        destruct (P3 i s Hi) as [S1 S2]. assert (W := P1 i s Hi). unfold input; fold s.
        assert (Sum : d <= (x i s - L i s) + (U i s - x i s) <= D i) by (unfold d, D; lra).
        split; [apply (law_size _ _ _ (near i) (D i)); lra|split]; intro Cl.
        + apply (law_far _ _ _ (near i) (far i) d (D i)); auto; lra.
        + rewrite law_opp by lra. rewrite Ropp_involutive. apply (law_far _ _ _ (near i) (far i) d (D i)); auto; lra.
      - intros i Hi; apply numbers, Hi. }
    intros p t Hp Ht. assert (Kp := Keep p t Hp Ht).
    assert (I : forall i, (i < n k)%nat -> L i t < x i t < U i t).
    { intros i Hi. destruct (Kp i Hi). destruct (numbers i Hi) as (_ & _ & _ & ? & _). lra. }
    split; [|split].
    - intros i Hi. destruct (I i Hi), (P3 i t Hi). lra.
    - intros o Ho. destruct (P4 o t Ho) as (i & Hi & Dj). exists i; split; [exact Hi|]. destruct (I i Hi). destruct Dj; [left|right]; lra.
    - intros Htc i Hi. destruct (I i Hi), (P5 i t Hi Htc). lra.
  Qed.
End SampledTube.
