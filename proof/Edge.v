(* The edges that the emitted `control` computes with the machine's own operations are those of Emitted.v: positions and edges have the
   values of the rounding model there, and nothing overflows.

   Controller.v uses it. docs/certificate-format.md has the bound on the error (P7: `edge_error`). *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra Psatz SpecFloat.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Stt Require Import Tube Loop Speed Rounding Emitted Syntax Run Emission Control Semantics.
Import ListNotations.
Open Scope R_scope.

(* The formats of Rounding.v, with the exponents of IEEE 754, are formats of Semantics.v. *)
Definition largest_exponent (f : format) : Z := match f with Single => 128 | Double => 1024 end.
Lemma precision_pos (f : format) : Prec_gt_0 (precision f). Proof. destruct f; reflexivity. Qed.
Lemma precision_below (f : format) : Prec_lt_emax (precision f) (largest_exponent f). Proof. destruct f; reflexivity. Qed.
Lemma precision_large f : (24 <= precision f)%Z. Proof. destruct f; cbn; lia. Qed.
Lemma precision_small f : (precision f <= 64)%Z. Proof. destruct f; cbn; lia. Qed.
Lemma exponent_large f : (128 <= largest_exponent f)%Z. Proof. destruct f; cbn; lia. Qed.
Lemma round_nearest_is_round_to_format f x : Semantics.round_nearest (precision f) (largest_exponent f) x = round_to_format f x. Proof. destruct f; reflexivity. Qed.

Section Machine.
  Variables prec emax : Z.
  Context (prec_gt_0_ : Prec_gt_0 prec).
  Context (prec_lt_emax_ : Prec_lt_emax prec emax).
  Hypothesis prec_large : (24 <= prec)%Z.
  Hypothesis emax_large : (128 <= emax)%Z.
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).
  Notation round_nearest := (round_nearest prec emax).
  Variable log_ : number -> number.
  Let u := unit_roundoff prec.
  Let A := machine prec emax _ _ log_.

  (* ---------------------------------------------------------------- sizes: powers of two, so that rounding stays within them *)

  (* v is finite and at most 2^j in size. Rounding keeps such a bound, for powers of two are in the format. *)
  Definition within_power (j : Z) (v : number) : Prop := is_finite v = true /\ Rabs (value v) <= bpow radix2 j.

  Lemma round_nearest_within_power j x : (-126 <= j <= 126)%Z -> Rabs x <= bpow radix2 j -> Rabs (round_nearest x) <= bpow radix2 j.
  Proof.
    intros J H. unfold Semantics.round_nearest. apply abs_round_le_generic; [now apply FLT_exp_valid|apply valid_rnd_N| |exact H].
    apply generic_format_bpow. unfold FLT_exp. assert (P := prec_lt_emax_). unfold Prec_lt_emax in *. lia.
  Qed.
  Lemma within_power_below_maximum j x : (j <= 126)%Z -> Rabs x <= bpow radix2 j -> Rabs x <= safe_maximum emax.
  Proof. intros J H. apply Rle_trans with (1 := H). unfold safe_maximum. apply bpow_le. lia. Qed.
  Lemma bpow_successor j : bpow radix2 (j + 1) = bpow radix2 j + bpow radix2 j.
  Proof. rewrite bpow_plus. cbn [bpow]. change (Z.pow_pos radix2 1) with 2%Z. lra. Qed.

  Lemma add_within_power i j v w : within_power i v -> within_power j w -> (-126 <= Z.max i j <= 125)%Z ->
    value (Bplus mode_NE v w) = round_nearest (value v + value w) /\ within_power (Z.max i j + 1) (Bplus mode_NE v w).
  Proof.
    intros [V1 V2] [W1 W2] J.
    assert (H : Rabs (value v + value w) <= bpow radix2 (Z.max i j + 1)).
    { rewrite bpow_successor. eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat; [apply Rle_trans with (1 := V2)|apply Rle_trans with (1 := W2)]; apply bpow_le; lia. }
    destruct (add_rounds prec emax _ _ prec_large emax_large v w V1 W1) as [Q1 Q2]; [apply within_power_below_maximum with (Z.max i j + 1)%Z; [lia|exact H]|].
    split; [exact Q1|split; [exact Q2|rewrite Q1; apply round_nearest_within_power; [lia|exact H]]].
  Qed.
  Lemma sub_within_power i j v w : within_power i v -> within_power j w -> (-126 <= Z.max i j <= 125)%Z ->
    value (Bminus mode_NE v w) = round_nearest (value v - value w) /\ within_power (Z.max i j + 1) (Bminus mode_NE v w).
  Proof.
    intros [V1 V2] [W1 W2] J.
    assert (H : Rabs (value v - value w) <= bpow radix2 (Z.max i j + 1)).
    { rewrite bpow_successor. unfold Rminus. eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. apply Rplus_le_compat; [apply Rle_trans with (1 := V2)|apply Rle_trans with (1 := W2)]; apply bpow_le; lia. }
    destruct (sub_rounds prec emax _ _ prec_large emax_large v w V1 W1) as [Q1 Q2]; [apply within_power_below_maximum with (Z.max i j + 1)%Z; [lia|exact H]|].
    split; [exact Q1|split; [exact Q2|rewrite Q1; apply round_nearest_within_power; [lia|exact H]]].
  Qed.
  Lemma mul_within_power i j v w : within_power i v -> within_power j w -> (-126 <= i + j <= 126)%Z ->
    value (Bmult mode_NE v w) = round_nearest (value v * value w) /\ within_power (i + j) (Bmult mode_NE v w).
  Proof.
    intros [V1 V2] [W1 W2] J.
    assert (H : Rabs (value v * value w) <= bpow radix2 (i + j)).
    { rewrite bpow_plus, Rabs_mult. apply Rmult_le_compat; try apply Rabs_pos; assumption. }
    destruct (mul_rounds prec emax _ _ prec_large emax_large v w V1 W1) as [Q1 Q2]; [apply within_power_below_maximum with (i + j)%Z; [lia|exact H]|].
    split; [exact Q1|split; [exact Q2|rewrite Q1; apply round_nearest_within_power; [lia|exact H]]].
  Qed.

  Lemma literal_one_value : value (decimal_number prec emax _ _ literal_one) = 1 /\ within_power 0 (decimal_number prec emax _ _ literal_one).
  Proof.
    destruct (integer_literal_exact prec emax _ _ prec_large emax_large literal_one 1 ltac:(lia) ltac:(reflexivity)) as [O1 O2].
    split; [exact O1|split; [exact O2|rewrite O1, Rabs_R1; cbn; lra]].
  Qed.
  Lemma literal_three_value : value (decimal_number prec emax _ _ literal_three) = 3 /\ within_power 2 (decimal_number prec emax _ _ literal_three).
  Proof.
    destruct (integer_literal_exact prec emax _ _ prec_large emax_large literal_three 3 ltac:(lia) ltac:(reflexivity)) as [O1 O2].
    split; [exact O1|split; [exact O2|rewrite O1, Rabs_pos_eq by lra; cbn; lra]].
  Qed.
  Lemma literal_zero_value : value (decimal_number prec emax _ _ literal_zero) = 0 /\ is_finite (decimal_number prec emax _ _ literal_zero) = true.
  Proof. split; reflexivity. Qed.

  (* The edge is the straight-line code that Rounding.v analyses. *)
  Lemma edge_is_analysed_code (s q0 q1 q2 q3 : number) : within_power 0 s -> within_power 30 q0 -> within_power 30 q1 -> within_power 30 q2 -> within_power 30 q3 ->
    value (edge A s q0 q1 q2 q3) = nth 23 (run_assignments round_nearest basis_edge [value s; value q0; value q1; value q2; value q3]) 0 /\ is_finite (edge A s q0 q1 q2 q3) = true.
  Proof.
    intros Hs H0 H1 H2 H3. destruct literal_one_value as [O1 O2]. destruct literal_three_value as [T1 T2].
    unfold edge, blend, weight0, weight1, weight2, weight3, bump_factor, one_minus_position.
    change (literal A literal_one) with (decimal_number prec emax prec_gt_0_ prec_lt_emax_ literal_one). change (literal A literal_three) with (decimal_number prec emax prec_gt_0_ prec_lt_emax_ literal_three).
    change (add A) with (@Bplus prec emax prec_gt_0_ prec_lt_emax_ mode_NE). change (sub A) with (@Bminus prec emax prec_gt_0_ prec_lt_emax_ mode_NE).
    change (mul A) with (@Bmult prec emax prec_gt_0_ prec_lt_emax_ mode_NE).
    set (l1 := decimal_number prec emax prec_gt_0_ prec_lt_emax_ literal_one) in *. set (l3 := decimal_number prec emax prec_gt_0_ prec_lt_emax_ literal_three) in *.
    destruct (sub_within_power 0 0 l1 s O2 Hs ltac:(lia)) as [E5 S5]. set (n5 := Bminus mode_NE l1 s) in *. cbn [Z.max Z.compare Z.add] in S5.
    destruct (mul_within_power _ _ n5 n5 S5 S5 ltac:(lia)) as [E6 S6]. set (n6 := Bmult mode_NE n5 n5) in *.
    destruct (mul_within_power _ _ n6 n5 S6 S5 ltac:(lia)) as [E7 S7]. set (n7 := Bmult mode_NE n6 n5) in *.
    destruct (mul_within_power _ _ n5 s S5 Hs ltac:(lia)) as [E8 S8]. set (n8 := Bmult mode_NE n5 s) in *.
    destruct (add_within_power _ _ l1 n8 O2 S8 ltac:(lia)) as [E9 S9]. set (n9 := Bplus mode_NE l1 n8) in *.
    destruct (mul_within_power _ _ l3 n9 T2 S9 ltac:(lia)) as [E10 S10]. set (n10 := Bmult mode_NE l3 n9) in *.
    destruct (mul_within_power _ _ n5 n10 S5 S10 ltac:(lia)) as [E11 S11]. set (n11 := Bmult mode_NE n5 n10) in *.
    destruct (add_within_power _ _ l1 n11 O2 S11 ltac:(lia)) as [E12 S12]. set (n12 := Bplus mode_NE l1 n11) in *.
    destruct (mul_within_power _ _ s n10 Hs S10 ltac:(lia)) as [E13 S13]. set (n13 := Bmult mode_NE s n10) in *.
    destruct (add_within_power _ _ l1 n13 O2 S13 ltac:(lia)) as [E14 S14]. set (n14 := Bplus mode_NE l1 n13) in *.
    destruct (mul_within_power _ _ s s Hs Hs ltac:(lia)) as [E15 S15]. set (n15 := Bmult mode_NE s s) in *.
    destruct (mul_within_power _ _ n15 s S15 Hs ltac:(lia)) as [E16 S16]. set (n16 := Bmult mode_NE n15 s) in *.
    destruct (mul_within_power _ _ n7 q0 S7 H0 ltac:(lia)) as [E17 S17]. set (n17 := Bmult mode_NE n7 q0) in *.
    destruct (mul_within_power _ _ n12 q1 S12 H1 ltac:(lia)) as [E18 S18]. set (n18 := Bmult mode_NE n12 q1) in *.
    destruct (add_within_power _ _ n17 n18 S17 S18 ltac:(lia)) as [E19 S19]. set (n19 := Bplus mode_NE n17 n18) in *.
    destruct (mul_within_power _ _ n14 q2 S14 H2 ltac:(lia)) as [E20 S20]. set (n20 := Bmult mode_NE n14 q2) in *.
    destruct (mul_within_power _ _ n16 q3 S16 H3 ltac:(lia)) as [E21 S21]. set (n21 := Bmult mode_NE n16 q3) in *.
    destruct (add_within_power _ _ n20 n21 S20 S21 ltac:(lia)) as [E22 S22]. set (n22 := Bplus mode_NE n20 n21) in *.
    destruct (add_within_power _ _ n19 n22 S19 S22 ltac:(lia)) as [E23 S23]. 
    split; [|apply S23]. rewrite E23. cbv [run_assignments basis_edge app nth Rounding.operand_value apply_operation operation_of left_operand right_operand].
    rewrite E22, E21, E20, E19, E18, E17, E16, E15, E14, E13, E12, E11, E10, E9, E8, E7, E6, E5, O1, T1. reflexivity.
  Qed.

End Machine.

(* From a time to its position, in single or in double precision. *)
Section Format.
  Variable f : format.
  Notation prec := (precision f).
  Notation emax := (largest_exponent f).
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).
  Local Instance precision_pos_instance : Prec_gt_0 prec := precision_pos f.
  Local Instance precision_below_instance : Prec_lt_emax prec emax := precision_below f.
  Notation within_power := (within_power prec emax).
  Variable log_ : number -> number.
  Let A := machine prec emax _ _ log_.
  Let prec_large := precision_large f.
  Let emax_large := exponent_large f.
  Notation literal_number d := (decimal_number prec emax precision_pos_instance precision_below_instance d).

  (* ---------------------------------------------------------------- time, segment and place *)

  Variable consts : constants.
  Variables (rows : Tube.table) (unit time_rate_real last_time_real : R).
  Let K := segment_count rows.
  Hypothesis time_rate_value : value (literal_number (time_rate consts)) = time_rate_real /\ is_finite (literal_number (time_rate consts)) = true.
  Hypothesis last_time_value : value (literal_number (last_spline_time consts)) = last_time_real /\ is_finite (literal_number (last_spline_time consts)) = true.
  Hypothesis time_rate_range : 0 <= time_rate_real <= 1073741824.
  Hypothesis last_range : 0 <= last_time_real < INR K.
  Hypothesis K_small : (Z.of_nat K <= 2 ^ 24)%Z.
  Notation emitted_time_of := (emitted_spline_time f time_rate_real last_time_real).

  Variable t : number.
  Hypothesis finite_t : is_finite t = true.

  Let machine_time := Control.spline_time A consts t.
  Lemma machine_time_value : value machine_time = emitted_time_of (value t) /\ is_finite machine_time = true.
  Proof.
    destruct (literal_zero_value prec emax precision_pos_instance precision_below_instance) as [Z1 Z2]. destruct time_rate_value as [C1 C2]. destruct last_time_value as [L1 L2].
    unfold machine_time, Control.spline_time. cbv zeta.
    change (literal A literal_zero) with (decimal_number prec emax precision_pos_instance precision_below_instance literal_zero). change (literal A (time_rate consts)) with (decimal_number prec emax precision_pos_instance precision_below_instance (time_rate consts)).
    change (literal A (last_spline_time consts)) with (decimal_number prec emax precision_pos_instance precision_below_instance (last_spline_time consts)).
    change (less_than A) with (@Bltb prec emax). change (mul A) with (@Bmult prec emax precision_pos_instance precision_below_instance mode_NE).
    set (z := decimal_number prec emax precision_pos_instance precision_below_instance literal_zero) in *. set (r := decimal_number prec emax precision_pos_instance precision_below_instance (time_rate consts)) in *.
    set (l := decimal_number prec emax precision_pos_instance precision_below_instance (last_spline_time consts)) in *.
    assert (St : value (if Bltb z t then t else z) = (if Rlt_dec 0 (value t) then value t else 0) /\ is_finite (if Bltb z t then t else z) = true).
    { assert (H := less_is_real_order prec emax z t Z2 finite_t). rewrite Z1 in H. destruct (Bltb z t); destruct (Rlt_dec 0 (value t)) as [Q|Q]; auto.
      - exfalso; apply Q, H; reflexivity.
      - apply H in Q. discriminate. }
    set (st := if Bltb z t then t else z) in *. destruct St as [S1 S2].
    assert (S0 : 0 <= value st) by (rewrite S1; destruct Rlt_dec; lra).
    change (value (if Bltb (Bmult mode_NE st r) l then Bmult mode_NE st r else l) = emitted_time_of (value t) /\ is_finite (if Bltb (Bmult mode_NE st r) l then Bmult mode_NE st r else l) = true).
    assert (M := Bmult_correct prec emax _ _ mode_NE st r). cbn [round_mode] in M.
    match type of M with context [round radix2 ?e ?m (value st * value r)] => change (round radix2 e m (value st * value r)) with (Semantics.round_nearest prec emax (value st * value r)) in M end.
    destruct (Rlt_bool_spec (Rabs (Semantics.round_nearest prec emax (value st * value r))) (bpow radix2 emax)) as [Fits|Over].
    2: { (* where the product overflows, the time is past t_c, and the last spline time is taken *)
      assert (Rn : 0 <= Semantics.round_nearest prec emax (value st * value r)).
      { rewrite <- (round_nearest_0 prec emax). apply round_nearest_le; [exact precision_pos_instance|]. apply Rmult_le_pos; [exact S0|rewrite C1; lra]. }
      rewrite (Rabs_pos_eq _ Rn) in Over.
      assert (Big : last_time_real < bpow radix2 emax).
      { rewrite <- L1. eapply Rle_lt_trans; [apply Rle_abs|]. apply abs_B2R_lt_emax. }
      assert (Nz : 0 < value st /\ 0 < value r).
      { assert (P : 0 < value st * value r).
        { apply Rnot_le_lt; intro Q. apply (round_nearest_le prec emax precision_pos_instance) in Q. rewrite round_nearest_0 in Q. pose proof (bpow_gt_0 radix2 emax). lra. }
        rewrite C1 in *. assert (value st <> 0) by (intro Q; rewrite Q, Rmult_0_l in P; lra). assert (time_rate_real <> 0) by (intro Q; rewrite Q, Rmult_0_r in P; lra). lra. }
      assert (Sgn : forall v : number, 0 < value v -> Bsign v = false).
      { intros [sv|sv| |sv mv ev Hv] Q; cbn in Q; try lra. destruct sv; [|reflexivity]. exfalso. 
        assert (F2R (Float radix2 (Zneg mv) ev) < 0) by (now apply F2R_lt_0). cbn in *. lra. }
      rewrite (Sgn st (proj1 Nz)), (Sgn r (proj2 Nz)) in M. cbn [xorb] in M.
      assert (Less : Bltb (Bmult mode_NE st r) l = false).
      { unfold Bltb. rewrite M. clear - L2. change (binary_overflow prec emax mode_NE false) with (S754_infinity false). destruct l as [sl|sl| |sl ml el Hl]; try reflexivity; discriminate. }
      rewrite Less, L1. split; [|exact L2]. unfold emitted_spline_time; cbv zeta. rewrite <- round_nearest_is_round_to_format, <- S1, <- C1.
      destruct (Rlt_dec _ last_time_real) as [Q|Q]; [lra|reflexivity]. }
    destruct M as (M1 & M2 & _). rewrite S2, C2 in M2. cbn [andb] in M2. rewrite round_nearest_is_round_to_format in M1.
    assert (H := less_is_real_order prec emax (Bmult mode_NE st r) l M2 L2). rewrite M1, L1, S1, C1 in H.
    unfold emitted_spline_time; cbv zeta. destruct (Bltb (Bmult mode_NE st r) l); destruct (Rlt_dec _ last_time_real) as [Q|Q].
    - rewrite M1, S1, C1. auto.
    - exfalso; apply Q, H; reflexivity.
    - apply H in Q. discriminate.
    - auto.
  Qed.

  (* The segment of time t. *)
  Definition segment_of_time : Z := Zfloor (emitted_time_of (value t)).
  Lemma segment_range : (0 <= segment_of_time < Z.of_nat K)%Z.
  Proof.
    pose proof (emitted_spline_time_range f rows time_rate_real last_time_real ltac:(lra) last_range (value t)) as R0. unfold segment_of_time. split; [apply Zfloor_lub; lra|].
    apply lt_IZR. rewrite <- INR_IZR_INZ. pose proof (Zfloor_lb (emitted_time_of (value t))). lra.
  Qed.
  Lemma machine_segment : to_integer A machine_time = Some segment_of_time.
  Proof.
    destruct machine_time_value as [T1 T2]. cbn [to_integer A machine]. rewrite T2, truncation_value by exact precision_below_instance. rewrite T1.
    unfold segment_of_time. rewrite Ztrunc_floor by (apply (emitted_spline_time_range f rows time_rate_real last_time_real ltac:(lra) last_range)). reflexivity.
  Qed.

  Let machine_position := position_in_segment A machine_time segment_of_time.
  Lemma machine_position_value : value machine_position = round_to_format f (emitted_time_of (value t) - IZR segment_of_time) /\ within_power 0 machine_position.
  Proof.
    destruct machine_time_value as [T1 T2]. pose proof segment_range as Sr. pose proof (emitted_spline_time_range f rows time_rate_real last_time_real ltac:(lra) last_range (value t)) as R0.
    pose proof (Zfloor_lb (emitted_time_of (value t))) as Lb. pose proof (Zfloor_ub (emitted_time_of (value t))) as Ub. fold segment_of_time in Lb, Ub.
    destruct (of_int_exact prec emax _ _ prec_large emax_large segment_of_time ltac:(lia)) as [I1 I2].
    unfold machine_position, position_in_segment. change (sub A) with (@Bminus prec emax precision_pos_instance precision_below_instance mode_NE). change (of_integer A segment_of_time) with (of_int prec emax precision_pos_instance precision_below_instance segment_of_time).
    assert (Small : Rabs (value machine_time - value (of_int prec emax precision_pos_instance precision_below_instance segment_of_time)) <= bpow radix2 0).
    { rewrite T1, I1. cbn [bpow]. apply Rabs_le; lra. }
    destruct (sub_rounds prec emax _ _ prec_large emax_large machine_time (of_int prec emax precision_pos_instance precision_below_instance segment_of_time) T2 I2) as [Q1 Q2].
    { apply (within_power_below_maximum emax emax_large 0); [lia|exact Small]. }
    split; [rewrite Q1, T1, I1; apply round_nearest_is_round_to_format|]. split; [exact Q2|]. rewrite Q1. apply (round_nearest_within_power prec emax _ _ prec_large emax_large); [lia|exact Small].
  Qed.

  (* The machine's segment and position are those of Emitted.v. *)
  Lemma position_of_time_is_machine_position : position_of_time f time_rate_real last_time_real (value t) = (Z.to_nat segment_of_time, value machine_position).
  Proof.
    destruct machine_position_value as [P1 _]. pose proof segment_range as Sr. pose proof (emitted_spline_time_range f rows time_rate_real last_time_real ltac:(lra) last_range (value t)) as R0.
    assert (Sg : Ztrunc (emitted_time_of (value t)) = segment_of_time) by (unfold segment_of_time; apply Ztrunc_floor; lra).
    unfold position_of_time. cbv zeta. rewrite Sg, P1. now rewrite INR_IZR_INZ, Z2Nat.id by lia.
  Qed.
End Format.

(* ------------------------------------------------------------------ an edge *)

(* From a position to an edge. *)
Section EdgeAtPosition.
  Variable f : format.
  Notation prec := (precision f).
  Notation emax := (largest_exponent f).
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).
  Local Existing Instance precision_pos_instance.
  Local Existing Instance precision_below_instance.
  Variable log_ : number -> number.
  Let A := machine prec emax _ _ log_.
  Variables (rows : Tube.table) (unit : R) (segment : nat) (position : number).
  Hypothesis position_range : within_power prec emax 0 position.
  Variables (i : nat) (side : Z * Z -> Z).
  Variables q0 q1 q2 q3 : number.
  Let coefficient (j : nat) : R := unit * IZR (nth (segment + j) (edge_column side i rows) 0%Z).
  Hypothesis q0_value : value q0 = coefficient 0 /\ is_finite q0 = true.
  Hypothesis q1_value : value q1 = coefficient 1 /\ is_finite q1 = true.
  Hypothesis q2_value : value q2 = coefficient 2 /\ is_finite q2 = true.
  Hypothesis q3_value : value q3 = coefficient 3 /\ is_finite q3 = true.
  Hypothesis coefficients_bounded : forall k, Rabs (unit * IZR (nth k (edge_column side i rows) 0%Z)) <= 1073741824.

  (* The machine's edge is that of Emitted.v. *)
  Theorem machine_edge_value : value (edge A position q0 q1 q2 q3) = edge_at_position f rows unit side i (segment, value position) /\ is_finite (edge A position q0 q1 q2 q3) = true.
  Proof.
    assert (Sq : forall q j, value q = coefficient j /\ is_finite q = true -> within_power prec emax 30 q).
    { intros q j [Q1 Q2]. split; [exact Q2|]. rewrite Q1. change (bpow radix2 30) with 1073741824. apply coefficients_bounded. }
    destruct (edge_is_analysed_code prec emax _ _ (precision_large f) (exponent_large f) log_ position q0 q1 q2 q3 position_range (Sq _ _ q0_value) (Sq _ _ q1_value) (Sq _ _ q2_value) (Sq _ _ q3_value)) as [E1 E2].
    split; [|exact E2]. change (value (edge A position q0 q1 q2 q3)) with (value (edge (machine prec emax (precision_pos_instance f) (precision_below_instance f) log_) position q0 q1 q2 q3)). rewrite E1.
    destruct q0_value as [-> _]. destruct q1_value as [-> _]. destruct q2_value as [-> _]. destruct q3_value as [-> _].
    unfold edge_at_position; cbv zeta; cbn [fst snd]. unfold coefficient. generalize [value position;
      unit * IZR (nth (segment + 0) (edge_column side i rows) 0%Z); unit * IZR (nth (segment + 1) (edge_column side i rows) 0%Z);
      unit * IZR (nth (segment + 2) (edge_column side i rows) 0%Z); unit * IZR (nth (segment + 3) (edge_column side i rows) 0%Z)].
    intro env. f_equal. revert env. generalize basis_edge. clear. intro b. induction b as [|st rest IH]; intro env; cbn [run_assignments]; [reflexivity|]. rewrite round_nearest_is_round_to_format. apply IH.
  Qed.
End EdgeAtPosition.
