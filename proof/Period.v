(* P9 as a check: `period_check` decides window by window whether inputs that are held keep the state in an inner tube.
   `sampled_loop_reach_avoid_stay` is the theorem about the sampled loop, from edges, clock and sensors to the sets of the task.

   A theorem file about the tube uses `emitted_loop_reach_avoid_stay` as its third theorem; Sound.v applies the theorem to the whole C.
   docs/certificate-format.md has the conditions as P9, the lemma book as `sampled.sharp` (docs/lemmas.md). theorem/hints.py finds the
   hints. *)
From Coq Require Import ZArith QArith Qreals Qabs Qminmax Reals List Bool Lia Lra Psatz.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed Rounding Emitted EmittedTube HeldInputs HeldInputLaw Windows.
Import ListNotations.
Open Scope R_scope.

(* One component: gain, clamp share (1 - e_max)/2, u_max where there is one, rho, the bound on drift and disturbance, bounds on g_ii and
   |g_ij|, and the error of a distance that the law measures. *)
Record component := Component {
  component_gain : Q; component_clamp_share : Q; component_u_limit : option Q; component_rho : Q; component_force_max : Q; component_g_min : Q; component_g_max : Q; component_cross_gain_max : Q; component_distance_error : Q }.
(* The sampled loop: the largest age of a sample, the largest delay until its input acts, the start share, the error of the law's
   arithmetic (relative, and of the logarithm), and the components. *)
Record sampling := Sampling { sampling_age_max : Q; sampling_delay : Q; sampling_start_share : Q; sampling_law_error : Q; components : list component }.
(* What `component_at` returns beyond the list. *)
Definition zero_component : component := Component 0 0 None 0 0 0 0 0 0.
Definition component_at (loop : sampling) (i : nat) : component := nth i (components loop) zero_component.

(* The interval from begin to begin + count step, cut into cells. *)
Fixpoint width_cells (count : nat) (begin step : Q) : list (Q * Q) := match count with O => [] | S j => (begin, Qred (begin + step)) :: width_cells j (Qred (begin + step)) step end.

Lemma width_cells_cover m : forall a h d, Q2R a <= d -> d <= Q2R a + INR m * Q2R h -> (0 < m)%nat -> exists c, In c (width_cells m a h) /\ Q2R (fst c) <= d <= Q2R (snd c).
Proof.
  induction m; intros a h d A B M; [lia|]. cbn [width_cells].
  assert (E : Q2R (Qred (a + h)) = Q2R a + Q2R h) by (rewrite Q2R_red; apply Q2R_plus).
  destruct (Rle_dec d (Q2R (Qred (a + h)))) as [L|L].
  - exists (a, Qred (a + h)). split; [now left|split; [exact A|exact L]].
  - destruct m as [|m].
    { rewrite S_INR in B; cbn [INR] in B. lra. }
    destruct (IHm (Qred (a + h)) h d) as (c & I & Hc); [lra| |lia|exists c; split; [now right|exact Hc]].
    rewrite E. rewrite S_INR in B. lra.
Qed.

(* The checks. cell_count is the number of cells into which the range of a window's width is cut; hints has by window and component a
   bound on |u| and one on the logarithm in it, which are checked. *)
Section Check.
  Variables (unit : Q) (spec : task) (rows : table) (loop : sampling).
  Variables (hints : list (list (Q * Q))).
  Variable cell_count : nat.
  Let K := inject_Z (Z.of_nat (segment_count rows)).

  (* 1/(1 + rho): the share of the width between an edge and the inner edge. *)
  Definition inner_share (i : nat) : Q := / (1 + component_rho (component_at loop i)).
  (* By window w and component i: the smallest and the largest width, in this window and in it or the one before (`recent`), and the
     speed of the edges. *)
  Definition narrowest_width (w i : nat) : Q := unit * inject_Z (smallest_coefficient (width_bezier rows i w)).
  Definition widest_width (w i : nat) : Q := unit * inject_Z (largest_coefficient (width_bezier rows i w)).
  Definition narrowest_recent_width (w i : nat) : Q := Qmin (narrowest_width w i) (narrowest_width (w - 1) i).
  Definition widest_recent_width (w i : nat) : Q := Qmax (widest_width w i) (widest_width (w - 1) i).
  Definition window_speed_max (w i : nat) : Q := unit * (3 * inject_Z (window_step_max rows i w)) * (K / t_c spec).
  (* The hint's bound on |u|, the sum of those of other components, and the bound on all that moves x but its own input. *)
  Definition window_input_max (w i : nat) : Q := fst (nth i (nth w hints []) (0, 0)%Q).
  Fixpoint window_other_inputs_max (m i : nat) (w : nat) : Q :=
    match m with O => 0 | S j => (if Nat.eq_dec j i then 0 else window_input_max w j) + window_other_inputs_max j i w end.
  Definition window_force_max (w i : nat) : Q := Qred (component_force_max (component_at loop i) + component_cross_gain_max (component_at loop i) * window_other_inputs_max (n spec) i w).

  (* a < b. *)
  Definition is_less (a b : Q) : bool := is_positive (b - a).

  (* The hint is a bound on |u|: by u_max, or because the law is no larger for any sample in the inner tube. *)
  Definition input_max_check (w i : nat) : bool :=
    let c := component_at loop i in let input_max := window_input_max w i in
    if Qle_bool 0 input_max then
      if match component_u_limit c with Some m => Qle_bool m input_max | None => false end then true
      else
        let share := inner_share i in let width := narrowest_recent_width w i in let log_max := snd (nth i (nth w hints []) (0, 0)%Q) in
        let near_min := Qred (width * share - component_distance_error c) in let ratio_max := Qred ((width * (1 - share) + component_distance_error c) / near_min) in
        if is_positive near_min then if proves_exp_ge log_max ratio_max then Qle_bool (component_gain c * / near_min * (1 + / ratio_max) * (1 + sampling_law_error loop) * (log_max + sampling_law_error loop)) input_max else false else false
    else false.

  (* For every width in a cell, a sample near an edge has an input that pulls back faster than closing_speed. *)
  Definition pull_check (i : nat) (closing_speed drift : Q) (cell : Q * Q) : bool :=
    let c := component_at loop i in let share := inner_share i in
    let far_min := Qred (fst cell * (1 - share) - (drift + component_distance_error c)) in let near_begin := Qred (fst cell * share + (drift + component_distance_error c)) in
    let near_end := Qred (snd cell * share + (drift + component_distance_error c)) in
    if (is_positive (fst cell) && is_positive near_begin && is_positive near_end && is_less near_begin far_min)%bool then
      let ratio_min := Qred (far_min / near_begin) in
      let pull_max := Qred (component_g_min c * component_gain c * / near_end * (1 + / ratio_min) * (1 - sampling_law_error loop)) in
      if is_positive pull_max then let log_min := Qred (closing_speed / pull_max + sampling_law_error loop) in proves_exp_le log_min ratio_min else false
    else false.

  (* All conditions of P9 in window w, for component i. *)
  Definition window_check (w i : nat) : bool :=
    let c := component_at loop i in let edge_speed := window_speed_max w i in let force := window_force_max w i in let input_max := window_input_max w i in
    let closing_speed := Qred (force + edge_speed) in
    if input_max_check w i then
      if (is_positive (narrowest_width w i) && Qle_bool (narrowest_width w i) (widest_width w i))%bool then
        if is_less (2 * component_distance_error c + sampling_law_error loop * (widest_recent_width w i + 2 * component_distance_error c))
                (narrowest_width w i * ((component_rho c - 1) / (component_rho c + 1)) - 2 * ((closing_speed + component_g_max c * input_max) * sampling_age_max loop))
        then if match component_u_limit c with Some m => Qle_bool closing_speed (component_g_min c * m) | None => true end
          then forallb (pull_check i closing_speed (Qred (closing_speed * sampling_age_max loop + component_g_max c * input_max * sampling_delay loop)))
                 (width_cells cell_count (narrowest_width w i) ((widest_width w i - narrowest_width w i) * (1 # Pos.of_nat cell_count)))
          else false
        else false
      else false
    else false.

  (* The numbers of a component are in range, and the start share is within the inner tube. *)
  Definition component_check (edge_error : Q) (i : nat) : bool :=
    let c := component_at loop i in
    is_positive (component_gain c) && is_positive (component_clamp_share c) && Qle_bool (component_clamp_share c * (1 + component_rho c)) 1 && Qle_bool 1 (component_rho c) &&
    Qle_bool (component_clamp_share c) (1 # 4) && is_positive (component_g_min c) && Qle_bool (component_g_min c) (component_g_max c) && Qle_bool 0 (component_cross_gain_max c) && Qle_bool 0 (component_force_max c) &&
    Qle_bool edge_error (component_distance_error c) && match component_u_limit c with Some m => Qle_bool 0 m | None => true end &&
    Qle_bool (sampling_start_share loop) ((component_rho c - 1) / (component_rho c + 1)).

  (* P9: the numbers are in range, a sample is at most a window old (half of one with a delay), and the conditions hold in every window. *)
  Definition period_check (edge_error : Q) : bool :=
    (0 <? cell_count)%nat && Qle_bool 0 (sampling_law_error loop) && Qle_bool (sampling_law_error loop) (1 # 2) && is_positive (sampling_age_max loop) && Qle_bool 0 (sampling_delay loop) &&
    Qle_bool (K / t_c spec * (if Qle_bool (sampling_delay loop) 0 then sampling_age_max loop else 2 * sampling_age_max loop)) 1 &&
    forallb (component_check edge_error) (seq 0 (n spec)) &&
    forallb (fun window => forallb (window_check window) (seq 0 (n spec))) (seq 0 (S (segment_count rows))).
End Check.

Lemma is_less_sound a b : is_less a b = true -> Q2R a < Q2R b.
Proof. unfold is_less. intro H. apply is_positive_sound in H. rewrite Q2R_minus in H. lra. Qed.
Lemma Q2R_inv_pos q : 0 < Q2R q -> Q2R (/ q) = / Q2R q.
Proof. intro H. apply Q2R_inv. intro E. apply Qeq_eqR in E. rewrite Q2R_0 in E. lra. Qed.
Lemma Q2R_div_pos a q : 0 < Q2R q -> Q2R (a / q) = Q2R a / Q2R q.
Proof. intro H. apply Q2R_div. intro E. apply Qeq_eqR in E. rewrite Q2R_0 in E. lra. Qed.

Lemma total_splits_off_term m i u : (i < m)%nat -> total m u = u i + sum_except m i u.
Proof.
  induction m; intro H; [lia|]. cbn. destruct (Nat.eq_dec m i) as [->|Ne]; [|rewrite IHm by lia; ring].
  assert (E : forall j, (j <= i)%nat -> total j u = sum_except j i u).
  { induction j; intro Hj; cbn; [reflexivity|]. destruct (Nat.eq_dec j i); [lia|]. rewrite IHj by lia. reflexivity. }
  rewrite (E i) by lia. ring.
Qed.
Lemma sum_except_bounded m i u v b : 0 <= b -> (forall j, (j < m)%nat -> j <> i -> Rabs (u j) <= b * v j) -> Rabs (sum_except m i u) <= b * sum_except m i v.
Proof.
  intros B H. induction m; cbn; [rewrite Rabs_R0; lra|]. assert (A := IHm ltac:(intros; apply H; lia)).
  destruct (Nat.eq_dec m i) as [->|Ne]; [rewrite !Rplus_0_l; exact A|].
  assert (C := H m ltac:(lia) Ne). eapply Rle_trans; [apply Rabs_triang|]. lra.
Qed.

(* A tube and a sampled loop that the checks accept. Input p is computed from the sample of time sampled_at p, with edges seen_lower and
   seen_upper, and acts from acts_from p on. *)
Section Sampled.
  Variables (unit edge_error : Q) (plan : search_plan) (spec : task) (rows : table) (step_maxima : list Z).
  Variables (loop : sampling) (hints : list (list (Q * Q))) (cell_count : nat).
  Hypothesis tube_checked : tube_check unit edge_error plan spec rows = true.
  Hypothesis slopes_checked : slopes_check edge_error spec rows step_maxima = true.
  Hypothesis period_checked : period_check unit spec rows loop hints cell_count edge_error = true.

  Let L (i : nat) (t : R) := lower unit spec rows i t.
  Let U (i : nat) (t : R) := upper unit spec rows i t.
  Let axis_component (i : nat) := component_at loop i.
  Let age_max := Q2R (sampling_age_max loop).
  Let delay := Q2R (sampling_delay loop).
  Let rho (i : nat) := Q2R (component_rho (axis_component i)).
  Let distance_error (i : nat) := Q2R (component_distance_error (axis_component i)).
  Let u_limit (i : nat) := option_map Q2R (component_u_limit (axis_component i)).

  Variables (sampled_at acts_from : nat -> R) (law_lower law_upper : nat -> nat -> R) (x : nat -> R -> R) (measured : nat -> nat -> R).
  Variables (input : nat -> nat -> R) (push : nat -> R -> R) (G : nat -> nat -> R -> R).
  Hypothesis sampled_edges_near : forall p i, (i < n spec)%nat -> Rabs (law_lower p i - L i (sampled_at p)) <= Q2R edge_error /\ Rabs (law_upper p i - U i (sampled_at p)) <= Q2R edge_error.
  Hypothesis times_ordered : acts_from 0%nat = 0 /\ forall p, 0 <= sampled_at p <= acts_from p /\ acts_from p < acts_from (S p) /\
    acts_from (S p) - sampled_at p <= age_max /\ acts_from p - sampled_at p <= delay.
  Hypothesis x_continuous : forall i t, (i < n spec)%nat -> continuity_pt (x i) t.
  Hypothesis x_starts_in_share : forall i, (i < n spec)%nat -> Rabs (2 * x i 0 - L i 0 - U i 0) <= Q2R (sampling_start_share loop) * (U i 0 - L i 0).
  Hypothesis measurements_near : forall p i, (i < n spec)%nat -> Rabs (measured p i - x i (sampled_at p)) <= distance_error i - Q2R edge_error.
  Hypothesis inputs_act_as_law : forall p i, (i < n spec)%nat ->
    acts_as_law (Q2R (component_gain (axis_component i))) (Q2R (component_clamp_share (axis_component i))) (Q2R (sampling_law_error loop)) (u_limit i) (measured p i - law_lower p i) (law_upper p i - measured p i) (input p i).
  Hypothesis plant_within_bounds : forall p t, acts_from p < t < acts_from (S p) -> (forall i, (i < n spec)%nat -> L i t < x i t < U i t) -> forall i, (i < n spec)%nat ->
    is_derive (x i) t (push i t + total (n spec) (fun j => G i j t * input p j)) /\
    Rabs (push i t) <= Q2R (component_force_max (axis_component i)) /\ Q2R (component_g_min (axis_component i)) <= G i i t <= Q2R (component_g_max (axis_component i)) /\
    forall j, (j < n spec)%nat -> j <> i -> Rabs (G i j t) <= Q2R (component_cross_gain_max (axis_component i)).

  (* Real values of the check's rationals, by component and time. *)
  Let window_at (m : R) : nat := window_index rows (Q2R (t_c spec)) m.
  Let inner_share_real (i : nat) : R := / (1 + rho i).
  Let input_max_at (i : nat) (m : R) : R := Q2R (window_input_max hints (window_at m) i).
  Let edge_speed_at (i : nat) (m : R) : R := window_edge_speed rows (Q2R (t_c spec)) (Q2R unit) i (window_at m).

  (* The checks, as statements about real numbers. *)
  Lemma tube_facts : 0 < Q2R unit /\ 0 < Q2R (t_c spec) /\ is_regular (n spec) rows = true /\ 0 < Q2R (min_width spec) /\ 0 <= Q2R edge_error.
  Proof.
    pose proof tube_checked as C. unfold tube_check in C. cbv zeta in C. rewrite !andb_true_iff in C. destruct C as [[[Up Tp] Rg] _].
    pose proof slopes_checked as M. unfold slopes_check in M. rewrite !andb_true_iff in M. destruct M as [[Mw Er] _].
    apply is_positive_sound in Up, Tp, Mw. apply Qle_bool_to_R in Er. rewrite Q2R_0 in Er. repeat split; auto.
  Qed.

  Lemma period_facts : (0 < cell_count)%nat /\ 0 <= Q2R (sampling_law_error loop) <= 1 / 2 /\ 0 < age_max /\ 0 <= delay /\
    (INR (segment_count rows) / Q2R (t_c spec) * age_max <= 1) /\ (delay <> 0 -> INR (segment_count rows) / Q2R (t_c spec) * (2 * age_max) <= 1) /\
    (forall i, (i < n spec)%nat -> component_check loop edge_error i = true) /\
    (forall w i, (w <= segment_count rows)%nat -> (i < n spec)%nat -> window_check unit spec rows loop hints cell_count w i = true).
  Proof.
    destruct tube_facts as (Up & Tp & _).
    pose proof period_checked as P. unfold period_check in P. cbv zeta in P. rewrite !andb_true_iff in P.
    destruct P as [[[[[[[A B] C] D] E] F] H] W].
    rewrite forallb_forall in H, W. apply Qle_bool_to_R in B, C, E, F. apply is_positive_sound in D. rewrite Q2R_0 in B, E.
    replace (Q2R (1 # 2)) with (1 / 2) in C by (unfold Q2R; cbn; lra). rewrite Q2R_1 in F.
    assert (KR : Q2R (inject_Z (Z.of_nat (segment_count rows))) = INR (segment_count rows)) by (now rewrite Q2R_Z, <- INR_IZR_INZ).
    assert (R0 : 0 <= INR (segment_count rows) / Q2R (t_c spec)) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    split; [now apply Nat.ltb_lt|]. split; [lra|]. split; [exact D|]. split; [exact E|].
    rewrite Q2R_mult, Q2R_div_pos, KR in F by exact Tp.
    assert (S1 : INR (segment_count rows) / Q2R (t_c spec) * age_max <= INR (segment_count rows) / Q2R (t_c spec) * (2 * age_max)) by (apply Rmult_le_compat_l; [exact R0|unfold age_max; lra]).
    destruct (Qle_bool (sampling_delay loop) 0) eqn:Z0.
    - apply Qle_bool_to_R in Z0. rewrite Q2R_0 in Z0. split; [exact F|]. split; [intro Ne; exfalso; apply Ne; unfold delay; lra|].
      split; [intros i Hi; apply H, in_seq; lia|]. intros w i Hw Hi. specialize (W w ltac:(apply in_seq; lia)). rewrite forallb_forall in W. apply W, in_seq; lia.
    - rewrite Q2R_mult, Q2R_2 in F. fold age_max in F. split; [lra|]. split; [intros _; exact F|].
      split; [intros i Hi; apply H, in_seq; lia|]. intros w i Hw Hi. specialize (W w ltac:(apply in_seq; lia)). rewrite forallb_forall in W. apply W, in_seq; lia.
  Qed.

  Lemma component_facts i : (i < n spec)%nat -> let c := axis_component i in
    0 < Q2R (component_gain c) /\ 0 < Q2R (component_clamp_share c) <= inner_share_real i /\ inner_share_real i <= 1 / 2 /\ 1 <= rho i /\ Q2R (component_clamp_share c) <= 1 / 4 /\
    0 < Q2R (component_g_min c) <= Q2R (component_g_max c) /\ 0 <= Q2R (component_cross_gain_max c) /\ 0 <= Q2R (component_force_max c) /\ Q2R edge_error <= distance_error i /\
    (forall m, u_limit i = Some m -> 0 <= m) /\ Q2R (sampling_start_share loop) <= (rho i - 1) / (rho i + 1).
  Proof.
    intros Hi c. destruct period_facts as (_ & _ & _ & _ & _ & _ & Cc & _). specialize (Cc i Hi).
    unfold component_check in Cc. cbv zeta in Cc. fold (axis_component i) in Cc. fold c in Cc. rewrite !andb_true_iff in Cc.
    destruct Cc as [[[[[[[[[[[A B] C] D] E] F] H] I] J] M] N] O].
    apply is_positive_sound in A, B, F. apply Qle_bool_to_R in C, D, E, H, I, J, M, O. rewrite Q2R_0 in I, J. rewrite Q2R_1 in C, D.
    rewrite Q2R_mult, Q2R_plus, Q2R_1 in C. replace (Q2R (1 # 4)) with (1 / 4) in E by (unfold Q2R; cbn; lra).
    fold c in A, B, C, D, E, F, H, I, J, M, N, O. fold (rho i) in C, D.
    assert (P1 : 0 < Q2R (component_rho c + 1)) by (rewrite Q2R_plus, Q2R_1; unfold rho, c in *; lra).
    rewrite Q2R_div_pos, Q2R_plus, Q2R_minus, Q2R_1 in O by exact P1.
    unfold inner_share_real. change (Q2R (component_rho c)) with (rho i) in *.
    assert (Z1 : / (1 + rho i) <= 1 / 2) by (apply Rle_trans with (/ 2); [apply Rinv_le_contravar; lra|lra]).
    assert (Cz : Q2R (component_clamp_share c) <= / (1 + rho i)).
    { apply (Rmult_le_reg_r (1 + rho i)); [lra|]. rewrite Rinv_l by lra. exact C. }
    repeat split; auto; try lra.
    intros m Hm. unfold u_limit in Hm. fold c in Hm. destruct (component_u_limit c) as [q|]; cbn in Hm; [|easy]. injection Hm as <-.
    apply Qle_bool_to_R in N. rewrite Q2R_0 in N. exact N.
  Qed.
  Lemma inner_share_value i : (i < n spec)%nat -> Q2R (inner_share loop i) = inner_share_real i.
  Proof.
    intro Hi. destruct (component_facts i Hi) as (_ & _ & _ & r1 & _). unfold inner_share, inner_share_real. fold (axis_component i).
    rewrite Q2R_inv_pos, Q2R_plus, Q2R_1; [reflexivity|]. rewrite Q2R_plus, Q2R_1. unfold rho in r1. lra.
  Qed.

  Lemma window_other_inputs_max_value m i w : Q2R (window_other_inputs_max hints m i w) = sum_except m i (fun j => Q2R (window_input_max hints w j)).
  Proof.
    induction m; cbn [window_other_inputs_max sum_except]; [exact Q2R_0|]. rewrite Q2R_plus, IHm. destruct (Nat.eq_dec m i); [now rewrite Q2R_0|reflexivity].
  Qed.
  Lemma window_force_max_value w i : Q2R (window_force_max spec loop hints w i) =
    Q2R (component_force_max (axis_component i)) + Q2R (component_cross_gain_max (axis_component i)) * sum_except (n spec) i (fun j => Q2R (window_input_max hints w j)).
  Proof. unfold window_force_max. rewrite Q2R_red, Q2R_plus, Q2R_mult, window_other_inputs_max_value. reflexivity. Qed.

  Let narrowest_real (w i : nat) : R := Q2R unit * IZR (smallest_coefficient (width_bezier rows i w)).
  Let widest_real (w i : nat) : R := Q2R unit * IZR (largest_coefficient (width_bezier rows i w)).
  Lemma narrowest_width_value w i : Q2R (narrowest_width unit rows w i) = narrowest_real w i. Proof. unfold narrowest_width, narrowest_real. now rewrite Q2R_mult, Q2R_Z. Qed.
  Lemma widest_width_value w i : Q2R (widest_width unit rows w i) = widest_real w i. Proof. unfold widest_width, widest_real. now rewrite Q2R_mult, Q2R_Z. Qed.
  Lemma window_speed_max_value w i : Q2R (window_speed_max unit spec rows w i) = window_edge_speed rows (Q2R (t_c spec)) (Q2R unit) i w.
  Proof.
    destruct tube_facts as (_ & Tp & _). unfold window_speed_max, window_edge_speed. rewrite !Q2R_mult, Q2R_div_pos, !Q2R_Z by exact Tp.
    rewrite <- INR_IZR_INZ. replace (Q2R 3) with 3 by (unfold Q2R; cbn; lra). reflexivity.
  Qed.

  (* How fast an edge and the state may approach each other, a bound on |u|, and how far both move between sample and switch. *)
  Let closing_speed (w i : nat) : R := Q2R (window_force_max spec loop hints w i) + window_edge_speed rows (Q2R (t_c spec)) (Q2R unit) i w.
  Let window_input_max_real (w i : nat) : R := Q2R (window_input_max hints w i).
  Let window_drift (w i : nat) : R := closing_speed w i * age_max + Q2R (component_g_max (axis_component i)) * window_input_max_real w i * delay.

  (* What `window_check` says, about real numbers. *)
  Lemma window_facts w i : (w <= segment_count rows)%nat -> (i < n spec)%nat ->
    input_max_check unit rows loop hints w i = true /\ 0 < narrowest_real w i <= widest_real w i /\
    2 * distance_error i + Q2R (sampling_law_error loop) * (Rmax (widest_real w i) (widest_real (w - 1) i) + 2 * distance_error i) <
      narrowest_real w i * ((rho i - 1) / (rho i + 1)) - 2 * ((closing_speed w i + Q2R (component_g_max (axis_component i)) * window_input_max_real w i) * age_max) /\
    (forall m, u_limit i = Some m -> closing_speed w i <= Q2R (component_g_min (axis_component i)) * m) /\
    (forall d, narrowest_real w i <= d <= widest_real w i -> exists cell, Q2R (fst cell) <= d <= Q2R (snd cell) /\
      exists P drift, Q2R P = closing_speed w i /\ Q2R drift = window_drift w i /\ pull_check loop i P drift cell = true).
  Proof.
    intros Hw Hi. destruct period_facts as (Cu & _ & _ & _ & _ & _ & _ & W). specialize (W w i Hw Hi).
    destruct (component_facts i Hi) as (_ & _ & _ & r1 & _).
    unfold window_check in W. cbv zeta in W. fold (axis_component i) in W.
    destruct (input_max_check unit rows loop hints w i) eqn:M; [|easy].
    destruct (is_positive (narrowest_width unit rows w i) && Qle_bool (narrowest_width unit rows w i) (widest_width unit rows w i))%bool eqn:N; [|easy].
    destruct (is_less _ _) eqn:Sd; [|easy].
    set (P := Qred (window_force_max spec loop hints w i + window_speed_max unit spec rows w i)) in *.
    assert (PV : Q2R P = closing_speed w i) by (unfold P, closing_speed; now rewrite Q2R_red, Q2R_plus, window_speed_max_value).
    destruct (match component_u_limit (axis_component i) with Some m => Qle_bool P (component_g_min (axis_component i) * m) | None => true end) eqn:Li; [|easy].
    apply andb_true_iff in N. destruct N as [N1 N2]. apply is_positive_sound in N1. apply Qle_bool_to_R in N2. rewrite narrowest_width_value, widest_width_value in *.
    split; [reflexivity|]. split; [lra|]. split; [|split].
    - apply is_less_sound in Sd. assert (P1 : 0 < Q2R (component_rho (axis_component i) + 1)) by (rewrite Q2R_plus, Q2R_1; unfold rho in r1; lra).
      rewrite Q2R_minus, Q2R_plus, !Q2R_mult, Q2R_div_pos, !Q2R_plus, Q2R_minus, !Q2R_mult, PV, Q2R_1, Q2R_2 in Sd by exact P1.
      unfold widest_recent_width in Sd. rewrite Q2R_max, !widest_width_value, narrowest_width_value in Sd. exact Sd.
    - intros m Hm. unfold u_limit in Hm. destruct (component_u_limit (axis_component i)) as [q|]; cbn in Hm; [|easy]. injection Hm as <-.
      apply Qle_bool_to_R in Li. rewrite Q2R_mult, PV in Li. exact Li.
    - intros d Hd. rewrite forallb_forall in W.
      destruct (width_cells_cover cell_count (narrowest_width unit rows w i) ((widest_width unit rows w i - narrowest_width unit rows w i) * (1 # Pos.of_nat cell_count)) d) as (cell & I & Hc).
      + rewrite narrowest_width_value. lra.
      + rewrite Q2R_mult, Q2R_minus, narrowest_width_value, widest_width_value.
        assert (E : INR cell_count * Q2R (1 # Pos.of_nat cell_count) = 1).
        { rewrite Q2R_unit_fraction, INR_IZR_INZ. rewrite <- (Nat2Pos.id cell_count) at 1 by lia. rewrite positive_nat_Z. apply Rinv_r.
          assert (0 < IZR (Z.pos (Pos.of_nat cell_count))) by now apply IZR_lt. lra. }
        replace (INR cell_count * ((widest_real w i - narrowest_real w i) * Q2R (1 # Pos.of_nat cell_count))) with ((widest_real w i - narrowest_real w i) * (INR cell_count * Q2R (1 # Pos.of_nat cell_count))) by ring.
        rewrite E. lra.
      + exact Cu.
      + exists cell. split; [exact Hc|]. eexists _, _. split; [exact PV|split; [|exact (W cell I)]].
        rewrite Q2R_red, Q2R_plus, !Q2R_mult, PV. reflexivity.
  Qed.

  Lemma width_in_its_window i t : (i < n spec)%nat -> narrowest_real (window_at t) i <= U i t - L i t <= widest_real (window_at t) i.
  Proof. intro Hi. destruct tube_facts as (Up & Tp & Rg & _). unfold U, L, upper, lower. now apply (width_in_window rows _ _ (n spec)). Qed.

  Lemma window_at_below_count t : (window_at t <= segment_count rows)%nat.
  Proof. apply Nat.le_min_r. Qed.

  (* The distances that the law measures are near the true ones. *)
  Lemma measured_distances_near p i : (i < n spec)%nat ->
    let a := measured p i - law_lower p i in
    let b := law_upper p i - measured p i in
    Rabs (a - (x i (sampled_at p) - L i (sampled_at p))) <= distance_error i /\ Rabs (b - (U i (sampled_at p) - x i (sampled_at p))) <= distance_error i /\ 0 < a + b.
  Proof.
    intros Hi a b. assert (Sn := measurements_near p i Hi).
    assert (Up : is_positive unit = true).
    { pose proof tube_checked as C. unfold tube_check in C. cbv zeta in C. rewrite !andb_true_iff in C. apply C. }
    set (Lt := fun j r => if Req_EM_T r (sampled_at p) then law_lower p j else lower unit spec rows j r). set (Ut := fun j r => if Req_EM_T r (sampled_at p) then law_upper p j else upper unit spec rows j r).
    destruct (sampled_edges_near p i Hi) as [A B].
    assert (Close : forall j r, (j < n spec)%nat -> Rabs (Lt j r - lower unit spec rows j r) <= Q2R edge_error /\ Rabs (Ut j r - upper unit spec rows j r) <= Q2R edge_error).
    { intros j r Hj. destruct (sampled_edges_near p j Hj) as [A' B']. pose proof (Rabs_pos (law_lower p j - L j (sampled_at p))).
      unfold Lt, Ut. destruct (Req_EM_T r (sampled_at p)) as [->|_]; [split; [exact A'|exact B']|]. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. split; lra. }
    destruct (tube_sound unit edge_error Up spec rows plan tube_checked Lt Ut Close) as (P1 & _).
    assert (W := P1 i (sampled_at p) Hi). unfold Lt, Ut in W. destruct (Req_EM_T (sampled_at p) (sampled_at p)) as [_|Ne]; [|congruence]. destruct tube_facts as (_ & _ & _ & Mw & _).
    apply Rabs_le_between in Sn, A, B.
    repeat split; [apply Rabs_le; unfold a; lra|apply Rabs_le; unfold b; lra|unfold a, b; lra].
  Qed.

  Lemma limit_input_within_limit m v : 0 <= m -> Rabs (limit_input (Some m) v) <= m.
  Proof. intro H. cbn. apply Rabs_le. unfold Rmax, Rmin; repeat destruct Rle_dec; lra. Qed.

  Let in_inner_tube_at (t : R) : Prop := in_inner_tube (n spec) rho L U x t.

  Lemma input_bounded_at p m i : (i < n spec)%nat -> in_inner_tube_at (sampled_at p) -> sampled_at p <= m <= sampled_at p + 2 * age_max ->
    (delay = 0 -> m <= sampled_at p + age_max) -> Rabs (input p i) <= input_max_at i m.
  Proof.
    intros Hi Kp Hm Hl. destruct tube_facts as (Up & Tp & Rg & _ & er0).
    destruct period_facts as (_ & R & T0 & L0 & Ta & Tb & _).
    destruct (component_facts i Hi) as (k0 & (cl0 & clz) & zh & r1 & c4 & g0 & gc & pu & er & li & _).
    destruct (window_facts (window_at m) i (window_at_below_count m) Hi) as (M & _).
    assert (R0 : 0 <= INR (segment_count rows) / Q2R (t_c spec)) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    assert (D : INR (segment_count rows) / Q2R (t_c spec) * (m - sampled_at p) <= 1).
    { destruct (Req_dec delay 0) as [Z0|Z0].
      - specialize (Hl Z0). apply Rle_trans with (2 := Ta). apply Rmult_le_compat_l; lra.
      - apply Rle_trans with (2 := Tb Z0). apply Rmult_le_compat_l; lra. }
    destruct (measured_distances_near p i Hi) as (Ea & Eb & Hs). cbv zeta in Ea, Eb, Hs.
    assert (Act := inputs_act_as_law p i Hi).
    unfold input_max_at. unfold input_max_check in M. cbv zeta in M. fold (axis_component i) in M.
    destruct (Qle_bool 0 (window_input_max hints (window_at m) i)) eqn:U0; [|easy]. apply Qle_bool_to_R in U0. rewrite Q2R_0 in U0.
    destruct (match component_u_limit (axis_component i) with Some m0 => Qle_bool m0 (window_input_max hints (window_at m) i) | None => false end) eqn:Li.
    { unfold u_limit in Act, li. destruct (component_u_limit (axis_component i)) as [q|]; [|easy]. apply Qle_bool_to_R in Li. cbn [option_map] in *.
      destruct Act as (e1 & e2 & _ & _ & ->). eapply Rle_trans; [apply limit_input_within_limit, (li _ eq_refl)|exact Li]. }
    set (N := Qred (narrowest_recent_width unit rows (window_at m) i * inner_share loop i - component_distance_error (axis_component i))) in *.
    destruct (is_positive N) eqn:PN; [|easy]. apply is_positive_sound in PN.
    set (Y := Qred ((narrowest_recent_width unit rows (window_at m) i * (1 - inner_share loop i) + component_distance_error (axis_component i)) / N)) in *.
    set (l := snd (nth i (nth (window_at m) hints []) (0, 0)%Q)) in *.
    destruct (proves_exp_ge l Y) eqn:E; [|easy]. apply Qle_bool_to_R in M.
    assert (NV : Q2R N = Q2R (narrowest_recent_width unit rows (window_at m) i) * inner_share_real i - distance_error i).
    { unfold N. now rewrite Q2R_red, Q2R_minus, Q2R_mult, inner_share_value. }
    assert (YV : Q2R Y = (Q2R (narrowest_recent_width unit rows (window_at m) i) * (1 - inner_share_real i) + distance_error i) / (Q2R (narrowest_recent_width unit rows (window_at m) i) * inner_share_real i - distance_error i)).
    { unfold Y. rewrite Q2R_red, Q2R_div_pos, Q2R_plus, Q2R_mult, Q2R_minus, Q2R_1, inner_share_value, NV by assumption. reflexivity. }
    assert (z0 : 0 < inner_share_real i) by lra.
    assert (dpos : 0 < Q2R (narrowest_recent_width unit rows (window_at m) i)).
    { apply (Rmult_lt_reg_r (inner_share_real i)); [exact z0|]. rewrite NV in PN. lra. }
    assert (Ypos : 0 < Q2R Y).
    { rewrite YV. apply Rdiv_lt_0_compat; [|rewrite <- NV; exact PN].
      assert (0 < Q2R (narrowest_recent_width unit rows (window_at m) i) * (1 - inner_share_real i)) by (apply Rmult_lt_0_compat; lra). lra. }
    assert (El := ln_le_if_exp_ge _ _ E Ypos).
    destruct (Kp i Hi) as [K1 K2]. fold (inner_share_real i) in K1, K2.
    assert (Wd : Q2R (narrowest_recent_width unit rows (window_at m) i) <= U i (sampled_at p) - L i (sampled_at p)).
    { assert (Wi := width_in_its_window i (sampled_at p) Hi). unfold narrowest_recent_width. rewrite Q2R_min, !narrowest_width_value.
      destruct (window_same_or_next rows (Q2R (t_c spec)) (n spec) i Hi Tp (sampled_at p) m ltac:(lra) D) as [Q|Q]; fold (window_at (sampled_at p)) (window_at m) in Q; rewrite Q in Wi;
        unfold Rmin; destruct Rle_dec; lra. }
    assert (Fin := input_bounded_in_inner_tube (Q2R (component_gain (axis_component i))) (Q2R (component_clamp_share (axis_component i))) (Q2R (sampling_law_error loop)) (distance_error i) (inner_share_real i) (u_limit i)
      (conj k0 (conj (conj cl0 clz) (conj zh (conj R (conj c4 (Rle_trans _ _ _ (proj2 (proj2 (proj2 (proj2 tube_facts)))) er)))))) li (x i (sampled_at p) - L i (sampled_at p)) (U i (sampled_at p) - x i (sampled_at p)) _ _ (input p i)
      (Q2R (narrowest_recent_width unit rows (window_at m) i)) (Q2R Y) (Q2R l) Act Ea Eb ltac:(lra)).
    replace (x i (sampled_at p) - L i (sampled_at p) + (U i (sampled_at p) - x i (sampled_at p))) with (U i (sampled_at p) - L i (sampled_at p)) in Fin by ring.
    specialize (Fin K1 K2 ltac:(rewrite <- NV; exact PN) YV El).
    eapply Rle_trans; [exact Fin|]. eapply Rle_trans; [right|exact M].
    rewrite !Q2R_mult, !Q2R_plus, !Q2R_inv_pos, NV, Q2R_1 by assumption. reflexivity.
  Qed.

  Lemma force_max_in_window i m : force_max (n spec) (fun i => Q2R (component_force_max (axis_component i))) (fun i => Q2R (component_cross_gain_max (axis_component i))) input_max_at i m = Q2R (window_force_max spec loop hints (window_at m) i).
  Proof. now rewrite window_force_max_value. Qed.
  Lemma drift_max_in_window i m : drift_max (n spec) (fun i => Q2R (component_g_max (axis_component i))) (fun i => Q2R (component_force_max (axis_component i))) (fun i => Q2R (component_cross_gain_max (axis_component i))) age_max delay edge_speed_at input_max_at i m
    = window_drift (window_at m) i.
  Proof. unfold drift_max. rewrite force_max_in_window. reflexivity. Qed.

  (* The width at a time of at most one sample's age earlier is at most the largest of two windows. *)
  Lemma recent_width_below i r m : (i < n spec)%nat -> r <= m <= r + age_max -> U i r - L i r <= Rmax (widest_real (window_at m) i) (widest_real (window_at m - 1) i).
  Proof.
    intros Hi Hm. destruct tube_facts as (Up & Tp & _). destruct period_facts as (_ & _ & T0 & _ & Ta & _).
    assert (R0 : 0 <= INR (segment_count rows) / Q2R (t_c spec)) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    assert (D : INR (segment_count rows) / Q2R (t_c spec) * (m - r) <= 1) by (apply Rle_trans with (2 := Ta); apply Rmult_le_compat_l; lra).
    assert (Wi := width_in_its_window i r Hi).
    destruct (window_same_or_next rows (Q2R (t_c spec)) (n spec) i Hi Tp r m ltac:(lra) D) as [Q|Q]; fold (window_at r) (window_at m) in Q; rewrite Q in Wi;
      unfold Rmax; destruct Rle_dec; lra.
  Qed.

  Lemma law_constants_range i : (i < n spec)%nat -> 0 < Q2R (component_gain (axis_component i)) /\ 0 < Q2R (component_clamp_share (axis_component i)) <= inner_share_real i /\ inner_share_real i <= 1 / 2 /\
    0 <= Q2R (sampling_law_error loop) <= 1 / 2 /\ Q2R (component_clamp_share (axis_component i)) <= 1 / 4 /\ 0 <= distance_error i.
  Proof.
    intro Hi. destruct (component_facts i Hi) as (A & B & C & _ & D & _ & _ & _ & E & _). destruct period_facts as (_ & R & _).
    destruct tube_facts as (_ & _ & _ & _ & F). split; [exact A|split; [exact B|split; [exact C|split; [exact R|split; [exact D|lra]]]]].
  Qed.

  (* The conditions of HeldInputs.v hold at the upper edge; by symmetry they hold at the lower one. *)
  Lemma side_condition_holds i m a b a' b' u p : (i < n spec)%nat -> a + b = U i (sampled_at p) - L i (sampled_at p) -> sampled_at p <= m <= sampled_at p + age_max ->
    acts_as_law (Q2R (component_gain (axis_component i))) (Q2R (component_clamp_share (axis_component i))) (Q2R (sampling_law_error loop)) (u_limit i) a' b' u ->
    Rabs (a' - a) <= distance_error i -> Rabs (b' - b) <= distance_error i -> 0 < a' + b' ->
    (U i m - L i m) * ((rho i - 1) / (rho i + 1)) - 2 * ((closing_speed (window_at m) i + Q2R (component_g_max (axis_component i)) * window_input_max_real (window_at m) i) * age_max) <= a - b -> u <= 0.
  Proof.
    intros Hi Sum Hm Act Ea Eb Hs H.
    destruct (window_facts (window_at m) i (window_at_below_count m) Hi) as (_ & N & Sd & _ & _).
    destruct (component_facts i Hi) as (_ & _ & _ & r1 & _ & _ & _ & _ & _ & li & _).
    apply (input_not_outwards_past_middle (Q2R (component_gain (axis_component i))) (Q2R (component_clamp_share (axis_component i))) (Q2R (sampling_law_error loop)) (distance_error i) (inner_share_real i) (u_limit i) (law_constants_range i Hi) li
      a b a' b' u (Rmax (widest_real (window_at m) i) (widest_real (window_at m - 1) i)) Act Ea Eb Hs).
    - rewrite Sum. now apply recent_width_below.
    - assert (W := width_in_its_window i m Hi).
      assert (F0 : 0 <= (rho i - 1) / (rho i + 1)) by (apply Rmult_le_pos; [lra|left; apply Rinv_0_lt_compat; lra]).
      assert (narrowest_real (window_at m) i * ((rho i - 1) / (rho i + 1)) <= (U i m - L i m) * ((rho i - 1) / (rho i + 1))) by (apply Rmult_le_compat_r; lra).
      lra.
  Qed.

  Lemma pull_condition_holds i m a b a' b' u p : (i < n spec)%nat -> a + b = U i (sampled_at p) - L i (sampled_at p) -> sampled_at p <= m <= sampled_at p + age_max -> 0 <= m ->
    acts_as_law (Q2R (component_gain (axis_component i))) (Q2R (component_clamp_share (axis_component i))) (Q2R (sampling_law_error loop)) (u_limit i) a' b' u ->
    Rabs (a' - a) <= distance_error i -> Rabs (b' - b) <= distance_error i -> 0 < a' + b' -> a + b <= (U i m - L i m) + 2 * (edge_speed_at i m * age_max) ->
    (U i m - L i m) * (1 - inner_share_real i) - window_drift (window_at m) i <= a -> b <= (U i m - L i m) * inner_share_real i + window_drift (window_at m) i ->
    closing_speed (window_at m) i <= Q2R (component_g_min (axis_component i)) * - u.
  Proof.
    intros Hi Sum Hm M0 Act Ea Eb Hs Hw Ha Hb.
    destruct (window_facts (window_at m) i (window_at_below_count m) Hi) as (Mo & N & _ & Li & Pu).
    destruct (component_facts i Hi) as (_ & _ & _ & r1 & _ & g0 & gc0 & pu0 & er & li & _).
    destruct tube_facts as (Up & Tp & Rg & _). destruct period_facts as (_ & R & T0 & L0 & _).
    assert (W := width_in_its_window i m Hi).
    destruct (Pu (U i m - L i m) W) as (cell & Hc & P & dr & PV & DV & Ck).
    destruct (law_constants_range i Hi) as (k0 & (cl0 & clz) & zh & _ & c4 & e0).
    unfold pull_check in Ck. cbv zeta in Ck. fold (axis_component i) in Ck.
    set (A := Qred (fst cell * (1 - inner_share loop i) - (dr + component_distance_error (axis_component i)))) in *.
    set (B0 := Qred (fst cell * inner_share loop i + (dr + component_distance_error (axis_component i)))) in *.
    set (B := Qred (snd cell * inner_share loop i + (dr + component_distance_error (axis_component i)))) in *.
    destruct (is_positive (fst cell) && is_positive B0 && is_positive B && is_less B0 A)%bool eqn:Ps; [|easy].
    rewrite !andb_true_iff in Ps. destruct Ps as [[[Pc PB0] PB] AB]. apply is_positive_sound in Pc, PB0, PB. apply is_less_sound in AB.
    set (Y := Qred (A / B0)) in *. set (mp := Qred (component_g_min (axis_component i) * component_gain (axis_component i) * / B * (1 + / Y) * (1 - sampling_law_error loop))) in *.
    destruct (is_positive mp) eqn:Pm; [|easy]. apply is_positive_sound in Pm. set (l := Qred (P / mp + sampling_law_error loop)) in *.
    apply ln_ge_if_exp_le in Ck.
    assert (AV : Q2R A = Q2R (fst cell) * (1 - inner_share_real i) - (window_drift (window_at m) i + distance_error i)).
    { unfold A. rewrite Q2R_red, Q2R_minus, Q2R_mult, Q2R_minus, Q2R_plus, Q2R_1, inner_share_value, DV by exact Hi. reflexivity. }
    assert (B0V : Q2R B0 = Q2R (fst cell) * inner_share_real i + (window_drift (window_at m) i + distance_error i)).
    { unfold B0. rewrite Q2R_red, !Q2R_plus, Q2R_mult, inner_share_value, DV by exact Hi. reflexivity. }
    assert (BV : Q2R B = Q2R (snd cell) * inner_share_real i + (window_drift (window_at m) i + distance_error i)).
    { unfold B. rewrite Q2R_red, !Q2R_plus, Q2R_mult, inner_share_value, DV by exact Hi. reflexivity. }
    assert (YV : Q2R Y = Q2R A / Q2R B0) by (unfold Y; rewrite Q2R_red; now apply Q2R_div_pos).
    assert (Y1 : 1 < Q2R Y) by (rewrite YV; apply Rcomplements.Rlt_div_r; lra).
    assert (LV : Q2R l = Q2R P / Q2R mp + Q2R (sampling_law_error loop)) by (unfold l; now rewrite Q2R_red, Q2R_plus, Q2R_div_pos).
    assert (mV : Q2R mp = Q2R (component_g_min (axis_component i)) * Q2R (component_gain (axis_component i)) * / Q2R B * (1 + / Q2R Y) * (1 - Q2R (sampling_law_error loop))).
    { unfold mp. rewrite Q2R_red, !Q2R_mult, Q2R_plus, Q2R_minus, !Q2R_inv_pos, Q2R_1 by lra. reflexivity. }
    assert (v0 : 0 <= edge_speed_at i m) by (apply window_edge_speed_nonneg; assumption).
    assert (U0 : 0 <= window_input_max_real (window_at m) i).
    { unfold input_max_check in Mo. cbv zeta in Mo. destruct (Qle_bool 0 (window_input_max hints (window_at m) i)) eqn:Q; [|easy]. apply Qle_bool_to_R in Q. now rewrite Q2R_0 in Q. }
    assert (f0 : 0 <= Q2R (window_force_max spec loop hints (window_at m) i)).
    { rewrite window_force_max_value. apply Rplus_le_le_0_compat; [exact pu0|]. apply Rmult_le_pos; [exact gc0|]. apply sum_except_nonneg. intros j Hj.
      destruct (window_facts (window_at m) j (window_at_below_count m) Hj) as (Mj & _). unfold input_max_check in Mj. cbv zeta in Mj.
      destruct (Qle_bool 0 (window_input_max hints (window_at m) j)) eqn:Q; [|easy]. apply Qle_bool_to_R in Q. now rewrite Q2R_0 in Q. }
    assert (P0 : 0 <= closing_speed (window_at m) i) by (unfold closing_speed; fold (edge_speed_at i m); lra).
    assert (vd : 0 <= edge_speed_at i m * age_max <= window_drift (window_at m) i).
    { split; [apply Rmult_le_pos; lra|]. unfold window_drift, closing_speed. fold (edge_speed_at i m).
      assert (0 <= Q2R (window_force_max spec loop hints (window_at m) i) * age_max) by (apply Rmult_le_pos; lra).
      assert (0 <= Q2R (component_g_max (axis_component i)) * window_input_max_real (window_at m) i * delay) by (apply Rmult_le_pos; [apply Rmult_le_pos|]; lra). lra. }
    assert (Pr : 0 <= Q2R P / Q2R mp) by (rewrite PV; apply Rmult_le_pos; [exact P0|left; now apply Rinv_0_lt_compat]).
    apply (input_pulls_back_near_edge (Q2R (component_gain (axis_component i))) (Q2R (component_clamp_share (axis_component i))) (Q2R (sampling_law_error loop)) (distance_error i) (inner_share_real i) (u_limit i) (law_constants_range i Hi) li
      a b a' b' u (U i m - L i m) (Q2R (fst cell)) (Q2R (snd cell)) (window_drift (window_at m) i) (edge_speed_at i m * age_max) (Q2R A) (Q2R B0) (Q2R Y) (Q2R l)
      (Q2R (component_g_min (axis_component i))) (closing_speed (window_at m) i) Act Ea Eb Hs Hc Pc vd Hw Ha Hb AV B0V YV Y1 Ck); try lra.
    - rewrite <- BV. replace (Q2R (component_g_min (axis_component i)) * (Q2R (component_gain (axis_component i)) * / Q2R B * (1 + / Q2R Y) * (1 - Q2R (sampling_law_error loop)) * (Q2R l - Q2R (sampling_law_error loop))))
        with (Q2R mp * (Q2R l - Q2R (sampling_law_error loop))) by (rewrite mV; ring).
      rewrite LV. replace (Q2R mp * (Q2R P / Q2R mp + Q2R (sampling_law_error loop) - Q2R (sampling_law_error loop))) with (Q2R P) by (field; lra). lra.
    - exact Li.
  Qed.

  (* Between the exact edges the state is in the state space and clear of every unsafe set, and from t_c on in the target set. *)
  Lemma exact_tube_meets_task :
    (forall i t, (i < n spec)%nat -> L i t + Q2R (min_width spec) <= U i t) /\
    (forall t x, (forall i, (i < n spec)%nat -> L i t < x i < U i t) ->
      in_space spec x /\ (forall o, In o (unsafe_sets spec) -> clear (n spec) (Q2R (clearance spec)) o x) /\ (Q2R (t_c spec) <= t -> in_target spec x)).
  Proof.
    assert (Up : is_positive unit = true).
    { pose proof tube_checked as C. unfold tube_check in C. cbv zeta in C. rewrite !andb_true_iff in C. apply C. }
    destruct tube_facts as (_ & _ & _ & _ & er0).
    assert (Near : forall i t, (i < n spec)%nat -> Rabs (L i t - lower unit spec rows i t) <= Q2R edge_error /\ Rabs (U i t - upper unit spec rows i t) <= Q2R edge_error).
    { intros i t _. unfold L, U. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. lra. }
    split; [apply (tube_sound unit edge_error Up spec rows plan tube_checked L U Near)|exact (inside_tube_meets_task unit edge_error Up spec rows plan tube_checked L U Near)].
  Qed.

  (* The state is in the inner tube at all times until the last switch. *)
  Theorem sampled_loop_stays_in_inner_tube : forall p t, 0 <= t <= acts_from p -> in_inner_tube_at t.
  Proof.
    destruct tube_facts as (Up & Tp & Rg & Mw & er0). destruct period_facts as (_ & R & T0 & L0 & Ta & Tb & _).
    destruct exact_tube_meets_task as (P1 & _).
    assert (R0 : 0 <= INR (segment_count rows) / Q2R (t_c spec)) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    assert (Zpos : forall i, (i < n spec)%nat -> 0 < inner_share_real i).
    { intros i Hi. destruct (law_constants_range i Hi) as (_ & A & _). lra. }
    assert (Lip : forall i, (i < n spec)%nat -> exists v, lipschitz v (L i) /\ lipschitz v (U i)).
    { intros i Hi. pose proof slopes_checked as M. unfold slopes_check in M. rewrite !andb_true_iff, forallb_forall in M. destruct M as [_ St].
      eexists. split; apply (edge_lipschitz (n spec)); auto; apply St, in_seq; lia. }
    assert (Cont : forall i t, (i < n spec)%nat -> continuity_pt (x i) t /\ continuity_pt (L i) t /\ continuity_pt (U i) t).
    { intros i t Hi. destruct (Lip i Hi) as (v & A & B). split; [now apply x_continuous|]. split; eapply lipschitz_continuous; eauto. }
    apply (stays_in_inner_tube (n spec) sampled_at acts_from rho (fun i => Q2R (component_g_min (axis_component i))) (fun i => Q2R (component_g_max (axis_component i))) (fun i => Q2R (component_force_max (axis_component i)))
      (fun i => Q2R (component_cross_gain_max (axis_component i))) (fun i => Q2R (min_width spec) * inner_share_real i) age_max delay L U x
      (fun i p t => push i t + sum_except (n spec) i (fun j => G i j t * input p j)) (fun i p t => G i i t) input edge_speed_at input_max_at).
    - exact times_ordered.
    - intros i Hi. destruct (component_facts i Hi) as (_ & _ & _ & r1 & _ & g0 & gc0 & pu0 & _).
      split; [exact r1|split; [exact g0|split; [exact pu0|split; [exact gc0|]]]]. apply Rmult_lt_0_compat; [exact Mw|now apply Zpos].
    - exact Cont.
    - intros i t Hi. fold (inner_share_real i). apply Rmult_le_compat_r; [left; now apply Zpos|]. specialize (P1 i t Hi). lra.
    - intros i m Hi M0. split; [now apply window_edge_speed_nonneg|split].
      + destruct (window_facts (window_at m) i (window_at_below_count m) Hi) as (Mo & _). unfold input_max_at. unfold input_max_check in Mo. cbv zeta in Mo.
        destruct (Qle_bool 0 (window_input_max hints (window_at m) i)) eqn:Q; [|easy]. apply Qle_bool_to_R in Q. now rewrite Q2R_0 in Q.
      + intros r Hr Hm.
        assert (D : INR (segment_count rows) / Q2R (t_c spec) * (m - r) <= 1) by (apply Rle_trans with (2 := Ta); apply Rmult_le_compat_l; lra).
        split; [apply (edge_moves_at_most rows (Q2R (t_c spec)) (Q2R unit) (n spec) i Rg Hi Tp Up fst fst (or_introl (conj eq_refl eq_refl)))
               |apply (edge_moves_at_most rows (Q2R (t_c spec)) (Q2R unit) (n spec) i Rg Hi Tp Up snd snd (or_intror (conj eq_refl eq_refl)))]; auto; lra.
    - intros i Hi. destruct (component_facts i Hi) as (_ & _ & _ & r1 & _ & _ & _ & _ & _ & _ & Sh). specialize (P1 i 0 Hi).
      assert (X := x_starts_in_share i Hi). fold (inner_share_real i).
      assert (E : (rho i - 1) / (rho i + 1) = 1 - 2 * inner_share_real i) by (unfold inner_share_real; field; lra). rewrite E in Sh.
      assert (Q2R (sampling_start_share loop) * (U i 0 - L i 0) <= (1 - 2 * inner_share_real i) * (U i 0 - L i 0)) by (apply Rmult_le_compat_r; lra).
      apply Rabs_le_between in X. lra.
    - intros p t Ht Hin i Hi. destruct (plant_within_bounds p t Ht Hin i Hi) as (De & Fb & Gb & Gc).
      destruct (component_facts i Hi) as (_ & _ & _ & _ & _ & _ & gc0 & _). split; [|split; [|exact Gb]].
      + rewrite (total_splits_off_term (n spec) i _ Hi) in De.
        replace (push i t + sum_except (n spec) i (fun j => G i j t * input p j) + G i i t * input p i) with
          (push i t + (G i i t * input p i + sum_except (n spec) i (fun j => G i j t * input p j))) by ring. exact De.
      + eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat; [exact Fb|]. apply sum_except_bounded; [exact gc0|].
        intros j Hj Ne. rewrite Rabs_mult. apply Rmult_le_compat_r; [apply Rabs_pos|now apply Gc].
    - intros p m i Hi Kp Hm Hl. now apply (input_bounded_at p).
    - intros p m i Hi Kp Hm. destruct (measured_distances_near p i Hi) as (Ea & Eb & Hs). cbv zeta in Ea, Eb, Hs. assert (Act := inputs_act_as_law p i Hi).
      destruct (law_constants_range i Hi) as (_ & Cl & zh & _ & c4 & _).
      destruct (component_facts i Hi) as (_ & _ & _ & _ & _ & _ & _ & _ & _ & li & _).
      rewrite force_max_in_window. split; intro H.
      + eapply (side_condition_holds i m _ _ _ _ (input p i) p Hi); [|exact Hm|exact Act|exact Ea|exact Eb|exact Hs|exact H]. ring.
      + assert (- input p i <= 0); [|lra].
        eapply (side_condition_holds i m (U i (sampled_at p) - x i (sampled_at p)) (x i (sampled_at p) - L i (sampled_at p)) _ _ (- input p i) p Hi);
          [ring|exact Hm|apply (acts_as_law_odd _ _ _ _ _ _ _ li); [lra|exact Hs|exact Act]|exact Eb|exact Ea|lra|exact H].
    - intros p m i Hi Kp Hm Hw. destruct (measured_distances_near p i Hi) as (Ea & Eb & Hs). cbv zeta in Ea, Eb, Hs. assert (Act := inputs_act_as_law p i Hi).
      destruct (law_constants_range i Hi) as (_ & Cl & zh & _ & c4 & _).
      destruct (component_facts i Hi) as (_ & _ & _ & r1 & _ & _ & _ & _ & _ & li & _).
      assert (M0 : 0 <= m) by (destruct times_ordered as [_ C]; destruct (C p) as (A & _); lra).
      assert (E1 : rho i / (1 + rho i) = 1 - inner_share_real i) by (unfold inner_share_real; field; lra). rewrite E1, drift_max_in_window, force_max_in_window. fold (inner_share_real i).
      split; intros Ha Hb.
      + eapply (pull_condition_holds i m _ _ _ _ (input p i) p Hi); [|exact Hm|exact M0|exact Act|exact Ea|exact Eb|exact Hs| |exact Ha|exact Hb]; [ring|lra].
      + rewrite <- (Ropp_involutive (input p i)).
        eapply (pull_condition_holds i m (U i (sampled_at p) - x i (sampled_at p)) (x i (sampled_at p) - L i (sampled_at p)) _ _ (- input p i) p Hi);
          [ring|exact Hm|exact M0|apply (acts_as_law_odd _ _ _ _ _ _ _ li); [lra|exact Hs|exact Act]|exact Eb|exact Ea|lra|lra|exact Ha|exact Hb].
  Qed.

  (* The theorem about the sampled loop: |e| stays bounded, the state in the state space and clear of every unsafe set, and from t_c on
     in the target set. *)
  Theorem sampled_loop_reach_avoid_stay : forall p t, 0 <= t <= acts_from p ->
    (forall i, (i < n spec)%nat -> Rabs (2 * x i t - L i t - U i t) <= (rho i - 1) / (rho i + 1) * (U i t - L i t)) /\
    in_space spec (fun i => x i t) /\
    (forall o, In o (unsafe_sets spec) -> clear (n spec) (Q2R (clearance spec)) o (fun i => x i t)) /\
    (Q2R (t_c spec) <= t -> in_target spec (fun i => x i t)).
  Proof.
    intros p t Ht. assert (Kp := sampled_loop_stays_in_inner_tube p t Ht). destruct exact_tube_meets_task as [P1 Keeps].
    destruct tube_facts as (_ & _ & _ & Mw & _).
    assert (In_ : forall i, (i < n spec)%nat -> L i t < x i t < U i t).
    { intros i Hi. destruct (Kp i Hi) as [A B]. fold (inner_share_real i) in A, B. specialize (P1 i t Hi). destruct (law_constants_range i Hi) as (_ & C & _).
      assert (0 < (U i t - L i t) * inner_share_real i) by (apply Rmult_lt_0_compat; lra). lra. }
    split; [|exact (Keeps t _ In_)].
    intros i Hi. destruct (Kp i Hi) as [A B]. fold (inner_share_real i) in A, B. destruct (component_facts i Hi) as (_ & _ & _ & r1 & _).
    assert (E : (rho i - 1) / (rho i + 1) = 1 - 2 * inner_share_real i) by (unfold inner_share_real; field; lra). rewrite E. apply Rabs_le. lra.
  Qed.
End Sampled.

(* The same where the law sees the emitted edges, for a clock that shows every time. *)
Definition emitted_loop_reach_avoid_stay format unit edge_error plan spec rows step_maxima scale time_error loop hints cell_count tube_checked slopes_checked (rounding_checked : rounding_check format unit edge_error spec rows step_maxima scale time_error = true) period_checked
  sampled_at acts_from (clock : R -> R) x measured input push G (clock_reads : forall t, clock_shows format (clock t) t) :=
  sampled_loop_reach_avoid_stay unit edge_error plan spec rows step_maxima loop hints cell_count tube_checked slopes_checked period_checked sampled_at acts_from
    (fun p i => emitted_edge format unit rows scale fst i (clock (sampled_at p))) (fun p i => emitted_edge format unit rows scale snd i (clock (sampled_at p))) x measured input push G
    (fun p i Hi => emitted_edge_near format unit edge_error plan spec rows step_maxima scale time_error tube_checked slopes_checked rounding_checked clock clock_reads i (sampled_at p) Hi).
