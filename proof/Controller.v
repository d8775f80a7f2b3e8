(* The emitted controller: where the text is the program of Emission.v with constants that the checks accept, `control` and
   `control_tick` end, and what they store acts as the law asks on edges that are near the exact ones.

   Sound.v and theorem files use `control_runs_as_law` and `control_tick_runs_as_law` (docs/theorem.md, theorem 1 about the controller). *)
From Coq Require Import ZArith QArith Qreals Qabs Reals List Bool Lia Lra String.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Stt Require HeldInputLaw.
From Stt Require Import Tube Loop Speed Rounding Emitted EmittedTube Syntax Read Run Emission Control Semantics Edge Law Logarithm.
Import ListNotations.
Open Scope R_scope.

(* ------------------------------------------------------------------ the table, one number after the other *)

(* The numbers of a row, and of a table, in the order of the C's table. *)
Definition row_numbers (r : list (Z * Z)) : list Z := flat_map (fun p => [fst p; snd p]) r.
Definition table_numbers (rows : Tube.table) : list Z := flat_map row_numbers rows.

Lemma nth_flat_map {A B} (g : A -> list B) m d a l : (forall y, In y l -> List.length (g y) = m) -> forall r j, (r < List.length l)%nat -> (j < m)%nat ->
  nth (m * r + j) (flat_map g l) d = nth j (g (nth r l a)) d.
Proof.
  induction l as [|y l IH]; intros H r j Hr Hj; [cbn in Hr; lia|]. cbn [flat_map]. assert (Ly : List.length (g y) = m) by (apply H; now left).
  destruct r as [|r].
  - rewrite Nat.mul_0_r, Nat.add_0_l, app_nth1 by lia. reflexivity.
  - rewrite app_nth2 by (rewrite Ly; lia). rewrite Ly. replace (m * S r + j - m)%nat with (m * r + j)%nat by lia. cbn [nth].
    apply IH; [intros; apply H; now right|cbn in Hr; lia|exact Hj].
Qed.
Lemma row_numbers_length r : List.length (row_numbers r) = (2 * List.length r)%nat.
Proof. unfold row_numbers. induction r; cbn [flat_map app List.length]; [reflexivity|rewrite IHr; lia]. Qed.
Lemma table_numbers_length n rows : is_regular n rows = true -> List.length (table_numbers rows) = (2 * n * List.length rows)%nat.
Proof.
  unfold is_regular. rewrite andb_true_iff, forallb_forall. intros [H _]. unfold table_numbers. induction rows as [|r rows IH]; cbn [flat_map List.length]; [lia|].
  rewrite app_length, row_numbers_length, IH by (intros; apply H; now right). assert (E := H r (or_introl eq_refl)). apply Nat.eqb_eq in E. lia.
Qed.
Lemma table_numbers_nth n rows r i : is_regular n rows = true -> (r < List.length rows)%nat -> (i < n)%nat ->
  nth (2 * n * r + 2 * i) (table_numbers rows) 0%Z = fst (nth i (nth r rows []) (0, 0)%Z) /\
  nth (2 * n * r + (2 * i + 1)) (table_numbers rows) 0%Z = snd (nth i (nth r rows []) (0, 0)%Z).
Proof.
  intros Rg Hr Hi. destruct (is_regular_lengths _ _ Rg) as [_ Ln]. unfold table_numbers.
  assert (Len : forall y, In y rows -> List.length (row_numbers y) = (2 * n)%nat).
  { intros y Hy. rewrite row_numbers_length. unfold is_regular in Rg. rewrite andb_true_iff, forallb_forall in Rg. destruct Rg as [Rg _]. assert (E := Rg y Hy). apply Nat.eqb_eq in E. lia. }
  specialize (Ln r Hr).
  split; rewrite (nth_flat_map row_numbers (2 * n) 0%Z []) by (auto; lia); unfold row_numbers.
  - replace (2 * i)%nat with (2 * i + 0)%nat by lia. rewrite (nth_flat_map _ 2 0%Z (0, 0)%Z) by (auto; lia). reflexivity.
  - rewrite (nth_flat_map _ 2 0%Z (0, 0)%Z) by (auto; lia). reflexivity.
Qed.

(* The error of the law's arithmetic, in the factor and in epsilon: 2^-14 where the logarithm is written out, else 32 units of rounding. *)
Definition law_loss (f : format) (consts : constants) : Q := if has_inline_log consts then 1 # 16384 else 32 * half_ulp f.
Lemma acts_as_law_weaken k c r r' limit a b u : r <= r' -> HeldInputLaw.acts_as_law k c r limit a b u -> HeldInputLaw.acts_as_law k c r' limit a b u.
Proof. intros H (e1 & e2 & A & B & E). exists e1, e2. split; [lra|split; [lra|exact E]]. Qed.

(* The text's constants and table, and the checks. *)
Section Controller.
  Variable f : format.
  Notation prec := (precision f).
  Notation emax := (largest_exponent f).
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).
  Notation precision_pos_instance := (Edge.precision_pos_instance f).
  Notation precision_below_instance := (Edge.precision_below_instance f).
  Local Existing Instance Edge.precision_pos_instance.
  Local Existing Instance Edge.precision_below_instance.
  Notation literal_number d := (decimal_number prec emax precision_pos_instance precision_below_instance d).

  (* Every literal of the table is exactly so many units. *)
  Fixpoint literals_match (unit : Q) (ds : list decimal) (zs : list Z) : bool :=
    match ds, zs with
    | [], [] => true
    | d :: ds, z :: zs => if literal_equals prec emax d (unit * inject_Z z) then literals_match unit ds zs else false
    | _, _ => false
    end.
  Lemma literals_match_values unit : forall ds zs, literals_match unit ds zs = true -> List.length ds = List.length zs /\ forall j, (j < List.length ds)%nat ->
    value (literal_number (nth j ds literal_zero)) = Q2R unit * IZR (nth j zs 0%Z) /\ is_finite (literal_number (nth j ds literal_zero)) = true.
  Proof.
    induction ds as [|d ds IH]; intros [|z zs] H; cbn [literals_match] in H; try discriminate; [split; [reflexivity|cbn; lia]|].
    destruct (literal_equals _ _ d _) eqn:E; [|easy]. destruct (IH zs H) as [Ln V]. split; [cbn; lia|].
    intros [|j] Hj; cbn [nth]; [|apply V; cbn in Hj; lia].
    destruct (literal_equals_value prec emax _ _ _ _ E) as [E1 E2]. rewrite E1, Q2R_mult, Q2R_Z. auto.
  Qed.

  (* A number is at most 2^30 in size. *)
  Definition is_ordinary (v : Q) : bool := Qle_bool (Qabs v) (inject_Z 1073741824).

  (* The literals of component i are its gain, with both signs, its clamp share and its limit, all of ordinary size. *)
  Definition component_constants_check (consts : constants) (gains clamp_shares : list Q) (limits : list (option Q)) (i : nat) : bool :=
    let gain := nth i gains 0%Q in let c := nth i clamp_shares 0%Q in
    (literal_equals prec emax (clamp_share (constants_of_component consts (Z.of_nat i))) c && Qle_bool (1 # 1073741824) c && Qle_bool c (1 # 4) &&
     (if gains_differ consts then literal_equals prec emax (nth i (gain_table consts) literal_zero) gain else literal_equals prec emax (gain_lower consts) gain && literal_equals prec emax (gain_upper consts) (- gain)) &&
     Qle_bool (1 # 1073741824) gain && Qle_bool gain (inject_Z 1073741824) &&
     match nth i limits None with
     | Some m => if has_limits consts then literal_equals prec emax (nth i (limit_table consts) literal_zero) m && Qle_bool 0 m else false
     | None => negb (has_limits consts)
     end)%bool.
  Lemma component_constants_values consts gains clamp_shares limits i : component_constants_check consts gains clamp_shares limits i = true -> forall log_,
    let A := machine prec emax precision_pos_instance precision_below_instance log_ in
    ((value (literal_number (clamp_share (constants_of_component consts (Z.of_nat i)))) = Q2R (nth i clamp_shares 0%Q) /\ is_finite (literal_number (clamp_share (constants_of_component consts (Z.of_nat i)))) = true) /\
     / 1073741824 <= Q2R (nth i clamp_shares 0%Q) <= / 4) /\
    (@B2R prec emax (gain_if_lower_nearer A consts (Z.of_nat i)) = Q2R (nth i gains 0%Q) /\ is_finite (gain_if_lower_nearer A consts (Z.of_nat i) : number) = true) /\
    (@B2R prec emax (gain_if_upper_nearer A consts (Z.of_nat i)) = - Q2R (nth i gains 0%Q) /\ is_finite (gain_if_upper_nearer A consts (Z.of_nat i) : number) = true) /\
    / 1073741824 <= Q2R (nth i gains 0%Q) <= 1073741824 /\
    match nth i limits None with
    | Some m => has_limits consts = true /\ (@B2R prec emax (table_constant A (limit_table consts) (Z.of_nat i)) = Q2R m /\ is_finite (table_constant A (limit_table consts) (Z.of_nat i) : number) = true) /\ 0 <= Q2R m
    | None => has_limits consts = false
    end.
  Proof.
    intros H log_ A. unfold component_constants_check in H. cbv zeta in H. rewrite !andb_true_iff in H. destruct H as [[[[[[C1 C2] C3] H1] H2] H3] H4].
    apply Qle_bool_real in H2, H3, C2, C3. rewrite Q2R_Z in H3. assert (Zi : Q2R (1 # 1073741824) = / 1073741824) by (unfold Q2R; cbn; lra).
    assert (Zq : Q2R (1 # 4) = / 4) by (unfold Q2R; cbn; lra). rewrite Zi in H2, C2. rewrite Zq in C3.
    unfold gain_if_lower_nearer, gain_if_upper_nearer, table_constant. rewrite Nat2Z.id. change (literal A) with (decimal_number prec emax precision_pos_instance precision_below_instance).
    assert (G : forall d v, literal_equals prec emax d v = true -> value (literal_number d) = Q2R v /\ is_finite (literal_number d) = true) by (intros; now apply literal_equals_value).
    split; [split; [apply G, C1|lra]|]. split; [|split; [|split; [lra|]]].
    - destruct (gains_differ consts); [|rewrite andb_true_iff in H1; destruct H1 as [H1 _]]; apply G, H1.
    - destruct (gains_differ consts).
      + destruct (opp_is_exact prec emax (literal_number (nth i (gain_table consts) literal_zero))) as [O1 O2]. change (negate A) with (@Bopp prec emax). rewrite O1, O2. apply G in H1. destruct H1 as [-> ->]. auto.
      + rewrite andb_true_iff in H1. destruct H1 as [_ H1]. apply G in H1. rewrite Q2R_opp in H1. exact H1.
    - destruct (nth i limits None) as [m|].
      + destruct (has_limits consts); [|discriminate]. rewrite andb_true_iff in H4. destruct H4 as [H4 H5]. apply Qle_bool_real in H5.
        assert (Z0 : Q2R 0 = 0) by (unfold Q2R; cbn; lra). rewrite Z0 in H5. split; [reflexivity|split; [apply G, H4|exact H5]].
      + destruct (has_limits consts); [discriminate|reflexivity].
  Qed.

  (* The literals of the text are the numbers of the design, and of ordinary size. *)
  Definition constants_check (consts : constants) (coefficients : list decimal) (unit : Q) (spec : Tube.task) (rows : Tube.table) (scale : time_scale) (gains clamp_shares : list Q)
    (limits : list (option Q)) : bool :=
    let n := Z.of_nat (n spec) in
    let K := Z.of_nat (segment_count rows) in
    ((dimensions consts =? n)%Z && (0 <? n)%Z && (K <=? 2 ^ 24)%Z && (2 * n * (K + 3) <=? 2147483647)%Z &&
     literal_equals prec emax (time_rate consts) (dyadic (rate_mantissa scale) (rate_exponent scale)) && literal_equals prec emax (last_spline_time consts) (dyadic (last_mantissa scale) (last_exponent scale)) &&
     (if gains_differ consts then (Z.of_nat (List.length (gain_table consts)) =? n)%Z else true) && (if has_limits consts then (Z.of_nat (List.length (limit_table consts)) =? n)%Z else true) &&
     (if clamp_shares_differ consts then (Z.of_nat (List.length (clamp_share_table consts)) =? n)%Z else true) && forallb (component_constants_check consts gains clamp_shares limits) (seq 0 (Tube.n spec)) &&
     is_ordinary (dyadic (rate_mantissa scale) (rate_exponent scale)) && is_ordinary (largest_table_value unit rows) && Qle_bool (1 # 1073741824) (min_width spec) &&
     forallb (fun i => is_ordinary (nth i (lower_corner (state_space spec)) 0%Q) && is_ordinary (nth i (upper_corner (state_space spec)) 0%Q)) (seq 0 (Tube.n spec)) &&
     literals_match unit coefficients (table_numbers rows))%bool.

  Variables (consts : constants) (coefficients : list decimal) (directive_lines : list string).
  Variables (unit edge_error : Q) (plan : search_plan) (spec : Tube.task) (rows : Tube.table) (step_maxima : list Z) (scale : time_scale) (time_error : Q) (gains clamp_shares : list Q) (limits : list (option Q)).
  Hypothesis tube_checked : tube_check unit edge_error plan spec rows = true.
  Hypothesis slopes_checked : slopes_check edge_error spec rows step_maxima = true.
  Hypothesis rounding_checked : rounding_check f unit edge_error spec rows step_maxima scale time_error = true.
  Hypothesis constants_checked : constants_check consts coefficients unit spec rows scale gains clamp_shares limits = true.

  Variable log_ : number -> number.
  Hypothesis log_accurate : has_inline_log consts = false -> accurate prec emax log_.
  Let A := machine prec emax precision_pos_instance precision_below_instance log_.
  Let prec_large := precision_large f.
  Let emax_large := exponent_large f.

  (* The state that `control` or `control_tick` is called with. *)
  Variable x : nat -> number.
  Hypothesis finite_x : forall i, (i < n spec)%nat -> is_finite (x i) = true.
  Hypothesis size_x : forall i, (i < n spec)%nat -> Rabs (value (x i)) <= 1073741824.
  Let xs (i : Z) : number := x (Z.to_nat i).

  Lemma is_ordinary_bounds v : is_ordinary v = true -> Rabs (Q2R v) <= 1073741824.
  Proof. unfold is_ordinary. intro H. apply Qle_bool_real in H. rewrite Q2R_abs, Q2R_Z in H. exact H. Qed.

  Lemma literal_zero_is_0 : value (literal_number literal_zero) = 0 /\ is_finite (literal_number literal_zero) = true.
  Proof. split; reflexivity. Qed.
  Lemma times_zero_is_0 (v : number) : is_finite v = true -> value (Bmult mode_NE v (literal_number literal_zero)) = 0 /\ is_finite (Bmult mode_NE v (literal_number literal_zero)) = true.
  Proof.
    intro Fv. destruct literal_zero_is_0 as [Z1 Z2].
    destruct (mul_rounds prec emax _ _ prec_large emax_large v (literal_number literal_zero) Fv Z2) as [Q1 Q2]; [rewrite Z1, Rmult_0_r, Rabs_R0; unfold safe_maximum; apply bpow_ge_0|].
    rewrite Q1, Z1, Rmult_0_r. split; [apply round_nearest_0|exact Q2].
  Qed.
  Lemma sum_times_zero_is_0 (first : number) m : value first = 0 /\ is_finite first = true -> (m <= n spec)%nat -> value (sum_times_zero A xs first m) = 0 /\ is_finite (sum_times_zero A xs first m) = true.
  Proof.
    intros First. induction m; intro Hm; cbn [sum_times_zero]; [exact First|].
    destruct (IHm ltac:(lia)) as [I1 I2]. destruct (times_zero_is_0 (xs (Z.of_nat m))) as [X1 X2]; [unfold xs; rewrite Nat2Z.id; apply finite_x; lia|].
    destruct (add_rounds prec emax _ _ prec_large emax_large (sum_times_zero A xs first m) (Bmult mode_NE (xs (Z.of_nat m)) (literal_number literal_zero)) I2 X2) as [Q1 Q2].
    { rewrite I1, X1, Rplus_0_l, Rabs_R0. unfold safe_maximum. apply bpow_ge_0. }
    change (add A) with (@Bplus prec emax precision_pos_instance precision_below_instance mode_NE). change (mul A) with (@Bmult prec emax precision_pos_instance precision_below_instance mode_NE).
    change (literal A literal_zero) with (literal_number literal_zero). rewrite Q1, I1, X1, Rplus_0_l. split; [apply round_nearest_0|exact Q2].
  Qed.

  Let K := segment_count rows.
  Let time_rate_real := F2R (Float radix2 (rate_mantissa scale) (rate_exponent scale)).
  Let last_time_real := F2R (Float radix2 (last_mantissa scale) (last_exponent scale)).

  (* The checks, as statements about real numbers. *)
  Record checked_facts : Prop := {
    dimensions_match : dimensions consts = Z.of_nat (n spec);
    n_pos : (0 < n spec)%nat;
    segments_fit : (Z.of_nat K <= 2 ^ 24)%Z;
    indices_fit_31_bits : (2 * dimensions consts * (Z.of_nat K + 3) <= 2147483647)%Z;
    rate_value : value (literal_number (time_rate consts)) = time_rate_real /\ is_finite (literal_number (time_rate consts)) = true;
    last_value : value (literal_number (last_spline_time consts)) = last_time_real /\ is_finite (literal_number (last_spline_time consts)) = true;
    gain_table_length : gains_differ consts = true -> Z.of_nat (List.length (gain_table consts)) = dimensions consts;
    limit_table_length : has_limits consts = true -> Z.of_nat (List.length (limit_table consts)) = dimensions consts;
    clamp_share_table_length : clamp_shares_differ consts = true -> Z.of_nat (List.length (clamp_share_table consts)) = dimensions consts;
    component_constants_checked : forall i, (i < n spec)%nat -> component_constants_check consts gains clamp_shares limits i = true;
    time_rate_size : 0 <= time_rate_real <= 1073741824;
    last_time_size : 0 <= last_time_real < INR K;
    table_size : forall side i j, side = fst \/ side = snd -> Rabs (Q2R unit * IZR (nth j (edge_column side i rows) 0%Z)) <= 1073741824;
    width_size : / 1073741824 <= Q2R (min_width spec);
    space_size : forall i, (i < n spec)%nat -> -1073741824 <= real_at (lower_corner (state_space spec)) i /\ real_at (upper_corner (state_space spec)) i <= 1073741824;
    table_matches : literals_match unit coefficients (table_numbers rows) = true;
    table_regular : is_regular (n spec) rows = true
  }.

  Lemma facts_from_checks : checked_facts.
  Proof.
    pose proof constants_checked as H. unfold constants_check in H. cbv zeta in H. rewrite !andb_true_iff in H.
    destruct H as [[[[[[[[[[[[[[H1 H2] H3] H4] H5] H6] H7] H8] H9] H10] H14] H15] H16] H17] H18].
    pose proof rounding_checked as G. unfold rounding_check in G. cbv zeta in G. rewrite !andb_true_iff in G.
    destruct G as [[[[[[[[[Cz Lz] LK] LL] Lm] Lexp] Rate] Bd] Bz] Ev].
    pose proof tube_checked as C. unfold tube_check in C. cbv zeta in C. rewrite !andb_true_iff in C. destruct C as [[[Up Tp] Rg] _].
    apply Z.eqb_eq in H1. apply Z.ltb_lt in H2. apply Z.leb_le in H3, H4.
    apply literal_equals_value with (prec_gt_0_ := precision_pos_instance) (prec_lt_emax_ := precision_below_instance) in H5, H6.
    rewrite forallb_forall in H10.
    apply Qle_bool_real in H16, Cz, Lz, Bz. apply is_positive_sound in LK.
    assert (Z0 : Q2R 0 = 0) by (unfold Q2R; cbn; lra).
    assert (Zi : Q2R (1 # 1073741824) = / 1073741824) by (unfold Q2R; cbn; lra).
    rewrite Zi, ?Q2R_Z in *. rewrite !dyadic_value in *. rewrite Z0 in *.
    assert (KR : Q2R (inject_Z (Z.of_nat (segment_count rows))) = INR (segment_count rows)) by (now rewrite Q2R_Z, <- INR_IZR_INZ).
    rewrite Q2R_minus, KR, dyadic_value in LK.
    apply is_ordinary_bounds in H14, H15. rewrite dyadic_value in H14. apply Rabs_le_between in H14, H15.
    constructor; auto; try (unfold time_rate_real, last_time_real, K; lra).
    - lia.
    - rewrite H1. exact H4.
    - intro Sv. rewrite Sv in H7. apply Z.eqb_eq in H7. now rewrite H1.
    - intro Li. rewrite Li in H8. apply Z.eqb_eq in H8. now rewrite H1.
    - intro Cd. rewrite Cd in H9. apply Z.eqb_eq in H9. now rewrite H1.
    - intros i Hi. apply H10, in_seq. lia.
    - intros side i j Sd. assert (S0 : side (0, 0)%Z = 0%Z) by (destruct Sd as [->| ->]; reflexivity).
      rewrite edge_column_nth by exact S0.
      assert (Zero : Rabs (Q2R unit * IZR (side (0,0)%Z)) <= 1073741824) by (rewrite S0, Rmult_0_r, Rabs_R0; lra).
      rewrite forallb_forall in Bd.
      destruct (nth_in_or_default j rows []) as [I| ->]; [|destruct i; exact Zero].
      specialize (Bd _ I). rewrite forallb_forall in Bd.
      destruct (nth_in_or_default i (nth j rows []) (0, 0)%Z) as [I2|D]; [|rewrite D; exact Zero].
      specialize (Bd _ I2). rewrite andb_true_iff in Bd. destruct Bd as [B1 B2].
      apply Qle_bool_real in B1, B2. rewrite Q2R_abs, Q2R_mult, Q2R_Z in B1, B2.
      destruct Sd as [->| ->]; lra.
    - intros i Hi. rewrite forallb_forall in H17. assert (Q := H17 i ltac:(apply in_seq; lia)). rewrite andb_true_iff in Q. destruct Q as [Q1 Q2].
      apply is_ordinary_bounds in Q1, Q2. apply Rabs_le_between in Q1, Q2. unfold real_at. lra.
  Qed.

  (* A position that fits a time, as the machine computes it: a segment, and the position in it. *)
  Section KnownPosition.
  Variables (segment : Z) (machine_position : number) (tau : R).
  Let position : nat * R := (Z.to_nat segment, value machine_position).
  Hypothesis segment_range : (0 <= segment < Z.of_nat K)%Z.
  Hypothesis machine_position_range : within_power prec emax 0 machine_position.
  Hypothesis position_fits : position_fits_time spec rows time_error tau position.
  Let L (i : nat) : R := emitted_edge_at f unit rows fst i position.
  Let U (i : nat) : R := emitted_edge_at f unit rows snd i position.

  (* A number of the C's table is a control point. *)
  Lemma coefficient_value i j side : (i < n spec)%nat -> (j <= 3)%nat -> (side = 0 \/ side = 1)%Z ->
    value (coefficient_at A coefficients (segment * (2 * dimensions consts) + Z.of_nat i * 2 + (2 * dimensions consts * Z.of_nat j + side))) =
      Q2R unit * IZR (nth (Z.to_nat segment + j) (edge_column (if (side =? 0)%Z then fst else snd) i rows) 0%Z) /\
    is_finite (coefficient_at A coefficients (segment * (2 * dimensions consts) + Z.of_nat i * 2 + (2 * dimensions consts * Z.of_nat j + side))) = true.
  Proof.
    destruct facts_from_checks as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr]. intros Hi Hj Hs.
    destruct (literals_match_values _ _ _ Tm) as [Ml Mv]. rewrite (table_numbers_length _ _ Tr) in Ml.
    destruct segment_range as [S1 S2].
    destruct (is_regular_lengths _ _ Tr) as [L4 _]. assert (Kl : (List.length rows = K + 3)%nat) by (unfold K, segment_count; lia).
    set (r := (Z.to_nat segment + j)%nat). assert (Hr : (r < List.length rows)%nat) by (unfold r; lia).
    destruct (table_numbers_nth _ _ _ _ Tr Hr Hi) as [F1 F2].
    unfold coefficient_at. change (literal A) with (decimal_number prec emax precision_pos_instance precision_below_instance).
    rewrite D. destruct Hs as [-> | ->]; cbn [Z.eqb].
    - assert (E : Z.to_nat (segment * (2 * Z.of_nat (n spec)) + Z.of_nat i * 2 + (2 * Z.of_nat (n spec) * Z.of_nat j + 0)) = (2 * n spec * r + 2 * i)%nat) by (unfold r; nia).
      rewrite E. rewrite edge_column_nth by reflexivity. rewrite <- F1. apply Mv. rewrite Ml. apply Nat.lt_le_trans with (2 * n spec * (r + 1))%nat; [lia|apply Nat.mul_le_mono_l; lia].
    - assert (E : Z.to_nat (segment * (2 * Z.of_nat (n spec)) + Z.of_nat i * 2 + (2 * Z.of_nat (n spec) * Z.of_nat j + 1)) = (2 * n spec * r + (2 * i + 1))%nat) by (unfold r; nia).
      rewrite E. rewrite edge_column_nth by reflexivity. rewrite <- F2. apply Mv. rewrite Ml. apply Nat.lt_le_trans with (2 * n spec * (r + 1))%nat; [lia|apply Nat.mul_le_mono_l; lia].
  Qed.

  Let machine_lower (i : nat) : number := Control.lower A consts segment machine_position (coefficient_at A coefficients) (Z.of_nat i).
  Let machine_upper (i : nat) : number := Control.upper A consts segment machine_position (coefficient_at A coefficients) (Z.of_nat i).

  Lemma machine_edges_value i : (i < n spec)%nat -> (value (machine_lower i) = L i /\ is_finite (machine_lower i) = true) /\ (value (machine_upper i) = U i /\ is_finite (machine_upper i) = true).
  Proof.
    intro Hi. destruct facts_from_checks as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr].
    assert (G : forall side j z, (j <= 3)%nat -> (side = 0 \/ side = 1)%Z -> z = (segment * (2 * dimensions consts) + Z.of_nat i * 2 + (2 * dimensions consts * Z.of_nat j + side))%Z ->
      value (coefficient_at A coefficients z) = Q2R unit * IZR (nth (Z.to_nat segment + j) (edge_column (if (side =? 0)%Z then fst else snd) i rows) 0%Z) /\ is_finite (coefficient_at A coefficients z) = true).
    { intros side j z Hj Hs ->. now apply coefficient_value. }
    unfold L, U, emitted_edge_at. split.
    - unfold machine_lower, Control.lower. cbv zeta.
      apply (machine_edge_value f log_ rows (Q2R unit) (Z.to_nat segment) _ machine_position_range i fst).
      + apply (G 0%Z 0%nat); [lia|now left|ring].
      + apply (G 0%Z 1%nat); [lia|now left|ring].
      + apply (G 0%Z 2%nat); [lia|now left|ring].
      + apply (G 0%Z 3%nat); [lia|now left|ring].
      + intro j. apply Ts. now left.
    - unfold machine_upper, Control.upper. cbv zeta.
      apply (machine_edge_value f log_ rows (Q2R unit) (Z.to_nat segment) _ machine_position_range i snd).
      + apply (G 1%Z 0%nat); [lia|now right|ring].
      + apply (G 1%Z 1%nat); [lia|now right|ring].
      + apply (G 1%Z 2%nat); [lia|now right|ring].
      + apply (G 1%Z 3%nat); [lia|now right|ring].
      + intro j. apply Ts. now right.
  Qed.

  (* The emitted edges are as far apart as demanded, and within the state space. *)
  Lemma edges_range i : (i < n spec)%nat -> L i + Q2R (min_width spec) <= U i /\ real_at (lower_corner (state_space spec)) i <= L i /\ U i <= real_at (upper_corner (state_space spec)) i.
  Proof.
    intro Hi.
    assert (Up : is_positive unit = true).
    { pose proof tube_checked as C. unfold tube_check in C. cbv zeta in C. rewrite !andb_true_iff in C. apply C. }
    destruct (emitted_edges_near f unit edge_error plan spec rows step_maxima scale time_error tube_checked slopes_checked rounding_checked) as [_ Near].
    set (Lt := fun i r => if Req_EM_T r tau then L i else Tube.lower unit spec rows i r). set (Ut := fun i r => if Req_EM_T r tau then U i else Tube.upper unit spec rows i r).
    assert (Close : forall i r, (i < n spec)%nat -> Rabs (Lt i r - Tube.lower unit spec rows i r) <= Q2R edge_error /\ Rabs (Ut i r - Tube.upper unit spec rows i r) <= Q2R edge_error).
    { intros j r Hj. destruct (Near j tau position Hj position_fits) as [N1 N2]. pose proof (Rabs_pos (emitted_edge_at f unit rows fst j position - Tube.lower unit spec rows j tau)).
      unfold Lt, Ut. destruct (Req_EM_T r tau) as [->|_]; [split; [exact N1|exact N2]|]. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. split; lra. }
    destruct (tube_sound unit edge_error Up spec rows plan tube_checked Lt Ut Close) as (P1 & _ & P3 & _).
    specialize (P1 i tau Hi). specialize (P3 i tau Hi). unfold in_box, Lt, Ut in P1, P3. destruct (Req_EM_T tau tau) as [_|Ne]; [|congruence]. split; [exact P1|exact P3].
  Qed.

  (* Called with v, the function ends. Its status says whether the state is between the edges L and U in every dimension. It stores
     finite inputs that act as the law (13) with e clamped. *)
  Definition runs_as_law (name : string) (v : Run.c_value A) (L U : nat -> R) : Prop := exists out status,
    execute A (log_name consts) (Source directive_lines (emitted_tables consts coefficients) (Emission.emitted_functions consts)) name [v] (caller_arrays A consts xs) = Some (out, Some (IntValue status)) /\
    (status = 0%Z <-> forall i, (i < n spec)%nat -> L i < value (x i) < U i) /\ (status = 0 \/ status = 1)%Z /\
    forall i, (i < n spec)%nat -> exists v : number, last_stored (A := A) "u" (Z.of_nat i) out = Some v /\ is_finite v = true /\
      HeldInputLaw.acts_as_law (Q2R (nth i gains 0%Q)) (Q2R (nth i clamp_shares 0%Q)) (Q2R (law_loss f consts)) (option_map Q2R (nth i limits None)) (value (x i) - L i) (U i - value (x i)) (value v).

  Lemma stored_inputs_act_as_law name v : stores_control_inputs A consts coefficients segment machine_position xs directive_lines name v -> runs_as_law name v L U.
  Proof.
    intros (out & E & St). unfold runs_as_law.
    destruct facts_from_checks as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr].
    assert (Nd : number_of_dimensions consts = n spec) by (unfold number_of_dimensions; rewrite D; apply Nat2Z.id).
    assert (Near := emitted_log_near f log_ consts log_accurate). assert (Lam : 0 <= log_error_of consts <= / 8192) by (unfold log_error_of; destruct (has_inline_log consts); lra).
      assert (Lost : 32 * unit_roundoff prec + 1.03 * log_error_of consts <= Q2R (law_loss f consts)).
      { unfold law_loss, log_error_of. destruct (has_inline_log consts).
        - pose proof (u_small prec (precision_large f)). replace (Q2R (1 # 16384)) with (/ 16384) by (unfold Q2R; cbn; lra). lra.
        - rewrite Q2R_mult, half_ulp_value. change (bpow radix2 (- prec)) with (unit_roundoff prec). replace (Q2R 32) with 32 by (unfold Q2R; cbn; lra). lra. }
      assert (Acts : forall i, (i < n spec)%nat ->
        (HeldInputLaw.acts_as_law (Q2R (nth i gains 0%Q)) (Q2R (nth i clamp_shares 0%Q)) (Q2R (law_loss f consts)) (option_map Q2R (nth i limits None)) (value (x i) - L i) (U i - value (x i))
           (value (control_input A consts (Z.of_nat i) (machine_lower i) (machine_upper i) (x i))) /\
         is_finite (control_input A consts (Z.of_nat i) (machine_lower i) (machine_upper i) (x i) : number) = true) /\
        (is_inside A (machine_lower i) (machine_upper i) (x i) = true <-> L i < value (x i) < U i)).
      { intros i Hi. destruct (machine_edges_value i Hi) as [[L1 L2] [U1 U2]]. destruct (edges_range i Hi) as (W & Sl & Su). destruct (Ss i Hi) as [S1 S2].
        assert (Wl : / 1073741824 <= value (x i) - value (machine_lower i) + (value (machine_upper i) - value (x i))) by (rewrite L1, U1; lra).
        assert (ZL : Rabs (value (machine_lower i)) <= 1073741824) by (rewrite L1; apply Rabs_le; lra).
        assert (ZU : Rabs (value (machine_upper i)) <= 1073741824) by (rewrite U1; apply Rabs_le; lra).
        split.
        - destruct (component_constants_values consts gains clamp_shares limits i (Gs i Hi) log_) as ([Cv Cs] & Lg & Ug & Gr & Lk). fold A in Lg, Ug, Lk. unfold control_input. cbv zeta.
          destruct (nth i limits None) as [m|].
          + destruct Lk as (-> & [M1 M2] & M3).
            assert (G := saturated_input_acts_as_law prec emax precision_pos_instance precision_below_instance prec_large emax_large log_ (constants_of_component consts (Z.of_nat i)) (log_error_of consts) Lam Near (precision_small f) (Q2R (nth i gains 0%Q)) (Q2R (nth i clamp_shares 0%Q))
              (gain_if_upper_nearer A consts (Z.of_nat i)) (gain_if_lower_nearer A consts (Z.of_nat i)) Lg Ug Cv Gr Cs
              (machine_lower i) (machine_upper i) (x i) L2 U2 (finite_x i Hi) ZL ZU (size_x i Hi) Wl (table_constant A (limit_table consts) (Z.of_nat i)) M2 ltac:(rewrite M1; exact M3)).
            rewrite L1, U1, M1 in G. split; [exact (acts_as_law_weaken _ _ _ _ _ _ _ _ Lost (proj1 G))|apply G].
          + rewrite Lk.
            assert (G := unlimited_input_acts_as_law prec emax precision_pos_instance precision_below_instance prec_large emax_large log_ (constants_of_component consts (Z.of_nat i)) (log_error_of consts) Lam Near (precision_small f) (Q2R (nth i gains 0%Q)) (Q2R (nth i clamp_shares 0%Q))
              (gain_if_upper_nearer A consts (Z.of_nat i)) (gain_if_lower_nearer A consts (Z.of_nat i)) Lg Ug Cv Gr Cs
              (machine_lower i) (machine_upper i) (x i) L2 U2 (finite_x i Hi) ZL ZU (size_x i Hi) Wl). rewrite L1, U1 in G.
            split; [exact (acts_as_law_weaken _ _ _ _ _ _ _ _ Lost (proj1 G))|apply G].
        - assert (G := is_inside_correct prec emax precision_pos_instance precision_below_instance prec_large emax_large log_ (machine_lower i) (machine_upper i) (x i) L2 U2 (finite_x i Hi) ZL ZU (size_x i Hi)).
          rewrite L1, U1 in G. split; intro Q; [apply G in Q; lra|apply G; lra]. }
      exists out. eexists. split; [exact E|split; [|split]].
      + rewrite Nd. assert (O : forall m, (m <= n spec)%nat -> is_outside_within_first A consts segment machine_position (coefficient_at A coefficients) xs m = false <-> forall i, (i < m)%nat -> L i < value (x i) < U i).
        { induction m; intro Hm; cbn [is_outside_within_first]; [split; [intros _ i Hi; lia|reflexivity]|].
          specialize (IHm ltac:(lia)). destruct (Acts m ltac:(lia)) as [_ W]. cbv zeta. fold (machine_lower m) (machine_upper m). unfold xs at 1. rewrite Nat2Z.id.
          destruct (is_inside A (machine_lower m) (machine_upper m) (x m)).
          - rewrite IHm. split; intros H i Hi; [destruct (Nat.eq_dec i m) as [->|Ne]; [now apply W|apply H; lia]|apply H; lia].
          - split; [discriminate|]. intro H. assert (Q := H m ltac:(lia)). apply W in Q. discriminate. }
        specialize (O (n spec) ltac:(lia)). destruct (is_outside_within_first A consts segment machine_position (coefficient_at A coefficients) xs (n spec)).
        * split; [discriminate|]. intro H. apply O in H. discriminate.
        * split; [|reflexivity]. intros _. now apply O.
      + destruct (is_outside_within_first A consts segment machine_position (coefficient_at A coefficients) xs (number_of_dimensions consts)); auto.
      + intros i Hi. exists (control_input A consts (Z.of_nat i) (machine_lower i) (machine_upper i) (x i)). destruct (Acts i Hi) as [[A1 A2] _]. split; [|split; [exact A2|exact A1]].
        rewrite (St (Z.of_nat i)) by (rewrite D; lia). unfold xs. rewrite Nat2Z.id. reflexivity.
  Qed.
  End KnownPosition.

  Lemma indices_of_table_fit : (0 < dimensions consts /\ 2 * dimensions consts * (Z.of_nat K + 3) <= 2147483647)%Z /\ (Z.of_nat (List.length coefficients) = 2 * dimensions consts * (Z.of_nat K + 3))%Z.
  Proof.
    destruct facts_from_checks as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr].
    destruct (literals_match_values _ _ _ Tm) as [Ml _]. rewrite (table_numbers_length _ _ Tr) in Ml.
    destruct (is_regular_lengths _ _ Tr) as [L4 _]. assert (Kl : (List.length rows = K + 3)%nat) by (unfold K, segment_count; lia).
    split; [rewrite D in *; lia|]. rewrite D, Ml, Kl. nia.
  Qed.
  Lemma finite_test_passes (first : number) : value first = 0 /\ is_finite first = true -> at_most A (sum_times_zero A xs first (number_of_dimensions consts)) (literal A literal_zero) = true.
  Proof.
    intro First. assert (Nd : number_of_dimensions consts = n spec) by (unfold number_of_dimensions; rewrite (dimensions_match facts_from_checks); apply Nat2Z.id).
    rewrite Nd. destruct (sum_times_zero_is_0 first (n spec) First ltac:(lia)) as [Z1 Z2].
    apply (at_most_is_real_order prec emax (sum_times_zero A xs first (n spec)) (literal_number literal_zero) Z2 eq_refl). rewrite Z1. right. reflexivity.
  Qed.

  (* `control`, for a time that is right or rounded once. *)
  Theorem control_runs_as_law (t : number) : is_finite t = true -> forall tau, clock_shows f (value t) tau ->
    runs_as_law "@control" (@RealValue A t) (fun i => EmittedTube.emitted_edge f unit rows scale fst i (value t)) (fun i => EmittedTube.emitted_edge f unit rows scale snd i (value t)).
  Proof.
    intros finite_t tau reads_t.
    destruct facts_from_checks as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr]. destruct indices_of_table_fit as [Fit Len].
    destruct (emitted_edges_near f unit edge_error plan spec rows step_maxima scale time_error tube_checked slopes_checked rounding_checked) as [Time _].
    assert (Fits := Time _ _ reads_t). assert (Pm := position_of_time_is_machine_position f log_ consts rows time_rate_real last_time_real Rv Lv Rs Ls Ks t finite_t). destruct (machine_position_value f log_ consts rows time_rate_real last_time_real Rv Lv Rs Ls Ks t finite_t) as [_ Ps].
    fold time_rate_real last_time_real in Fits. unfold EmittedTube.emitted_edge. fold time_rate_real last_time_real. rewrite Pm in *.
    assert (Sr := segment_range f rows time_rate_real last_time_real Rs Ls t).
    apply (stored_inputs_act_as_law _ _ tau Sr Ps Fits).
    apply (control_executes A consts coefficients (segment_of_time f time_rate_real last_time_real t) (Z.of_nat K) _ xs directive_lines Sr Fit Len Gm Cm Lm).
    - apply (machine_segment f log_ consts rows time_rate_real last_time_real Rv Lv Rs Ls t finite_t).
    - reflexivity.
    - apply finite_test_passes, times_zero_is_0, finite_t.
  Qed.

  (* The ticks of a text, and the check of its integers. *)
  Definition tick_scale_of (c : tick_numbers) (period : Q) : EmittedTube.tick_scale := TickScale (tick_limit c) (tick_multiplier c) (tick_divisor c) period.
  Definition tick_constants_check (period : Q) : bool :=
    match tick_constants consts with
    | Some c => (ticks_check f spec rows time_error (tick_scale_of c period) && (tick_segments c =? Z.of_nat K)%Z && literal_equals prec emax (tick_divisor_real c) (inject_Z (tick_divisor c)) &&
        (tick_divisor c <=? 2 ^ 24)%Z && (tick_multiplier c <=? 2147483647)%Z && (0 <=? tick_limit c)%Z && (tick_limit c <=? 2147483647)%Z &&
        (tick_limit c * tick_multiplier c <=? 2147483647)%Z && (tick_divisor c * Z.of_nat K <=? 2147483647)%Z)%bool
    | None => false
    end.
  (* The position of a tick. *)
  Definition tick_position (tick : Z) : nat * R :=
    match tick_constants consts with Some c => position_of_tick f rows (tick_limit c) (tick_multiplier c) (tick_divisor c) tick | None => (0%nat, 0) end.

  Lemma tick_position_fits_time period tick : tick_constants_check period = true -> (0 <= tick)%Z -> position_fits_time spec rows time_error (IZR tick * Q2R period) (tick_position tick).
  Proof.
    unfold tick_constants_check, tick_position. destruct (tick_constants consts) as [c|]; [|discriminate]. rewrite !andb_true_iff. intros H T0. destruct H as [[[[[[[[H _] _] _] _] _] _] _] _].
    exact (tick_position_fits f unit edge_error plan spec rows time_error (tick_scale_of c period) tick tube_checked H T0).
  Qed.

  (* `control_tick`, for every count of ticks below 2^32. *)
  Theorem control_tick_runs_as_law period tick : tick_constants_check period = true -> (0 <= tick <= 4294967295)%Z ->
    runs_as_law "@control_tick" (@UnsignedValue A tick) (fun i => emitted_edge_at f unit rows fst i (tick_position tick)) (fun i => emitted_edge_at f unit rows snd i (tick_position tick)).
  Proof.
    intros H T0. assert (Fits := tick_position_fits_time period tick H (proj1 T0)). revert H Fits. unfold tick_constants_check, tick_position.
    destruct (tick_constants consts) as [c|] eqn:Tk; [|discriminate]. rewrite !andb_true_iff. intros [[[[[[[[H H1] H2] H3] H4] H5] H6] H7] H8] Fits.
    unfold ticks_check in H. cbv zeta in H. cbn [final_tick multiplier divisor tick_seconds tick_scale_of] in H. rewrite !andb_true_iff in H. destruct H as [[[[M0 D0] _] _] _].
    apply Z.eqb_eq in H1. apply Z.ltb_lt in M0, D0. apply Z.leb_le in H3, H4, H5, H6, H7, H8.
    destruct facts_from_checks as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr]. destruct indices_of_table_fit as [Fit Len].
    assert (K0 : (0 < Z.of_nat K)%Z) by (destruct (is_regular_lengths _ _ Tr); unfold K, segment_count; lia).
    assert (Sm : ticks_fit_31_bits c) by (unfold ticks_fit_31_bits; rewrite H1; lia).
    destruct (tick_parts_range c tick Sm (proj1 T0)) as (_ & Sr & Rr). rewrite H1 in Sr.
    apply literal_equals_value with (prec_gt_0_ := precision_pos_instance) (prec_lt_emax_ := precision_below_instance) in H2. destruct H2 as [S1 S2]. rewrite Q2R_Z in S1.
    assert (Dp := IZR_lt _ _ D0). assert (R1 := IZR_le _ _ (proj1 Rr)). assert (R2 := IZR_le _ _ (proj2 Rr)).
    destruct (of_int_exact prec emax _ _ prec_large emax_large (tick_parts_in_segment c tick) ltac:(lia)) as [I1 I2].
    assert (X : 0 <= IZR (tick_parts_in_segment c tick) / IZR (tick_divisor c) <= 1) by (split; [apply Rcomplements.Rle_div_r; lra|apply Rcomplements.Rle_div_l; lra]).
    assert (Part : value (tick_position_in_segment A c tick) = round_to_format f (IZR (tick_parts_in_segment c tick) / IZR (tick_divisor c)) /\ within_power prec emax 0 (tick_position_in_segment A c tick)).
    { unfold tick_position_in_segment. change (Run.div A) with (@Bdiv prec emax precision_pos_instance precision_below_instance mode_NE). change (of_integer A (tick_parts_in_segment c tick)) with (of_int prec emax precision_pos_instance precision_below_instance (tick_parts_in_segment c tick)).
      change (literal A (tick_divisor_real c)) with (literal_number (tick_divisor_real c)).
      assert (Small : Rabs (value (of_int prec emax precision_pos_instance precision_below_instance (tick_parts_in_segment c tick)) / value (literal_number (tick_divisor_real c))) <= bpow radix2 0) by (rewrite I1, S1; cbn [bpow]; apply Rabs_le; lra).
      destruct (div_rounds prec emax _ _ prec_large emax_large (of_int prec emax precision_pos_instance precision_below_instance (tick_parts_in_segment c tick)) (literal_number (tick_divisor_real c)) I2) as [Q1 Q2];
        [rewrite S1; lra|apply (within_power_below_maximum emax emax_large 0); [lia|exact Small]|].
      split; [rewrite Q1, I1, S1; apply round_nearest_is_round_to_format|]. split; [exact Q2|]. rewrite Q1. apply (round_nearest_within_power prec emax _ _ prec_large emax_large); [lia|exact Small]. }
    destruct Part as [P1 P2].
    assert (Pl : position_of_tick f rows (tick_limit c) (tick_multiplier c) (tick_divisor c) tick = (Z.to_nat (tick_segment c tick), value (tick_position_in_segment A c tick))).
    { rewrite P1. unfold position_of_tick, parts_passed, tick_parts_in_segment, tick_segment, tick_parts. cbv zeta. rewrite H1. reflexivity. }
    rewrite Pl in *. apply (stored_inputs_act_as_law _ _ (IZR tick * Q2R period) Sr P2 Fits).
    apply (control_tick_executes A consts coefficients (tick_segment c tick) (Z.of_nat K) _ xs directive_lines Sr Fit Len Gm Cm Lm c tick Tk Sm H1 T0 eq_refl eq_refl).
    apply finite_test_passes, literal_zero_is_0.
  Qed.
End Controller.
