(* The edges that the emitted control computes, against the exact spline: P7 for any precision, from the machine's own operations. *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra Psatz SpecFloat.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Stt Require Import Tube Loop Speed Rounding Emitted Syntax Run Emission Control Semantics.
Import ListNotations.
Open Scope R_scope.

(* Formats of the library are Flocq's, with the exponents of IEEE 754. *)
Definition largest_exponent (f : format) : Z := match f with Single => 128 | Double => 1024 end.
Lemma precision_pos (f : format) : Prec_gt_0 (precision f). Proof. destruct f; reflexivity. Qed.
Lemma precision_below (f : format) : Prec_lt_emax (precision f) (largest_exponent f). Proof. destruct f; reflexivity. Qed.
Lemma precision_large f : (24 <= precision f)%Z. Proof. destruct f; cbn; lia. Qed.
Lemma precision_small f : (precision f <= 64)%Z. Proof. destruct f; cbn; lia. Qed.
Lemma exponent_large f : (128 <= largest_exponent f)%Z. Proof. destruct f; cbn; lia. Qed.
Lemma rnd_format_of f x : Semantics.rnd (precision f) (largest_exponent f) x = to_format f x. Proof. destruct f; reflexivity. Qed.

Section Machine.
  Variables prec emax : Z.
  Context (prec_gt_0_ : Prec_gt_0 prec).
  Context (prec_lt_emax_ : Prec_lt_emax prec emax).
  Hypothesis prec_large : (24 <= prec)%Z.
  Hypothesis emax_large : (128 <= emax)%Z.
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).
  Notation rnd := (rnd prec emax).
  Variable log_ : number -> number.
  Let u := unit_roundoff prec.
  Let A := machine prec emax _ _ log_.

  (* ---------------------------------------------------------------- sizes: powers of two, so that rounding stays within them *)

  Definition sized (j : Z) (v : number) : Prop := is_finite v = true /\ Rabs (value v) <= bpow radix2 j.

  Lemma rnd_sized j x : (-126 <= j <= 126)%Z -> Rabs x <= bpow radix2 j -> Rabs (rnd x) <= bpow radix2 j.
  Proof.
    intros J H. unfold Semantics.rnd. apply abs_round_le_generic; [now apply FLT_exp_valid|apply valid_rnd_N| |exact H].
    apply generic_format_bpow. unfold FLT_exp. assert (P := prec_lt_emax_). unfold Prec_lt_emax in *. lia.
  Qed.
  Lemma within_most j x : (j <= 126)%Z -> Rabs x <= bpow radix2 j -> Rabs x <= most emax.
  Proof. intros J H. apply Rle_trans with (1 := H). unfold most. apply bpow_le. lia. Qed.
  Lemma bpow_double j : bpow radix2 (j + 1) = bpow radix2 j + bpow radix2 j.
  Proof. rewrite bpow_plus. cbn [bpow]. change (Z.pow_pos radix2 1) with 2%Z. lra. Qed.

  Lemma add_sized i j v w : sized i v -> sized j w -> (-126 <= Z.max i j <= 125)%Z ->
    value (Bplus mode_NE v w) = rnd (value v + value w) /\ sized (Z.max i j + 1) (Bplus mode_NE v w).
  Proof.
    intros [V1 V2] [W1 W2] J.
    assert (H : Rabs (value v + value w) <= bpow radix2 (Z.max i j + 1)).
    { rewrite bpow_double. eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat; [apply Rle_trans with (1 := V2)|apply Rle_trans with (1 := W2)]; apply bpow_le; lia. }
    destruct (add_ok prec emax _ _ prec_large emax_large v w V1 W1) as [Q1 Q2]; [apply within_most with (Z.max i j + 1)%Z; [lia|exact H]|].
    split; [exact Q1|split; [exact Q2|rewrite Q1; apply rnd_sized; [lia|exact H]]].
  Qed.
  Lemma sub_sized i j v w : sized i v -> sized j w -> (-126 <= Z.max i j <= 125)%Z ->
    value (Bminus mode_NE v w) = rnd (value v - value w) /\ sized (Z.max i j + 1) (Bminus mode_NE v w).
  Proof.
    intros [V1 V2] [W1 W2] J.
    assert (H : Rabs (value v - value w) <= bpow radix2 (Z.max i j + 1)).
    { rewrite bpow_double. unfold Rminus. eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp. apply Rplus_le_compat; [apply Rle_trans with (1 := V2)|apply Rle_trans with (1 := W2)]; apply bpow_le; lia. }
    destruct (sub_ok prec emax _ _ prec_large emax_large v w V1 W1) as [Q1 Q2]; [apply within_most with (Z.max i j + 1)%Z; [lia|exact H]|].
    split; [exact Q1|split; [exact Q2|rewrite Q1; apply rnd_sized; [lia|exact H]]].
  Qed.
  Lemma mul_sized i j v w : sized i v -> sized j w -> (-126 <= i + j <= 126)%Z ->
    value (Bmult mode_NE v w) = rnd (value v * value w) /\ sized (i + j) (Bmult mode_NE v w).
  Proof.
    intros [V1 V2] [W1 W2] J.
    assert (H : Rabs (value v * value w) <= bpow radix2 (i + j)).
    { rewrite bpow_plus, Rabs_mult. apply Rmult_le_compat; try apply Rabs_pos; assumption. }
    destruct (mul_ok prec emax _ _ prec_large emax_large v w V1 W1) as [Q1 Q2]; [apply within_most with (i + j)%Z; [lia|exact H]|].
    split; [exact Q1|split; [exact Q2|rewrite Q1; apply rnd_sized; [lia|exact H]]].
  Qed.

  Lemma literal_one : value (decimal_number prec emax _ _ one) = 1 /\ sized 0 (decimal_number prec emax _ _ one).
  Proof.
    destruct (whole_literal prec emax _ _ prec_large emax_large one 1 ltac:(lia) ltac:(reflexivity)) as [O1 O2].
    split; [exact O1|split; [exact O2|rewrite O1, Rabs_R1; cbn; lra]].
  Qed.
  Lemma literal_three : value (decimal_number prec emax _ _ three) = 3 /\ sized 2 (decimal_number prec emax _ _ three).
  Proof.
    destruct (whole_literal prec emax _ _ prec_large emax_large three 3 ltac:(lia) ltac:(reflexivity)) as [O1 O2].
    split; [exact O1|split; [exact O2|rewrite O1, Rabs_pos_eq by lra; cbn; lra]].
  Qed.
  Lemma literal_zero : value (decimal_number prec emax _ _ zero) = 0 /\ is_finite (decimal_number prec emax _ _ zero) = true.
  Proof. split; reflexivity. Qed.

  (* one edge is the straight-line code that was analysed *)
  Lemma edge_machine (s q0 q1 q2 q3 : number) : sized 0 s -> sized 30 q0 -> sized 30 q1 -> sized 30 q2 -> sized 30 q3 ->
    value (edge A s q0 q1 q2 q3) = nth 23 (exec rnd basis_blend [value s; value q0; value q1; value q2; value q3]) 0 /\ is_finite (edge A s q0 q1 q2 q3) = true.
  Proof.
    intros Hs H0 H1 H2 H3. destruct literal_one as [O1 O2]. destruct literal_three as [T1 T2].
    unfold edge, blend, weight0, weight1, weight2, weight3, v5, v0.
    change (literal A one) with (decimal_number prec emax prec_gt_0_ prec_lt_emax_ one). change (literal A three) with (decimal_number prec emax prec_gt_0_ prec_lt_emax_ three).
    change (add A) with (@Bplus prec emax prec_gt_0_ prec_lt_emax_ mode_NE). change (sub A) with (@Bminus prec emax prec_gt_0_ prec_lt_emax_ mode_NE).
    change (mul A) with (@Bmult prec emax prec_gt_0_ prec_lt_emax_ mode_NE).
    set (l1 := decimal_number prec emax prec_gt_0_ prec_lt_emax_ one) in *. set (l3 := decimal_number prec emax prec_gt_0_ prec_lt_emax_ three) in *.
    destruct (sub_sized 0 0 l1 s O2 Hs ltac:(lia)) as [E5 S5]. set (n5 := Bminus mode_NE l1 s) in *. cbn [Z.max Z.compare Z.add] in S5.
    destruct (mul_sized _ _ n5 n5 S5 S5 ltac:(lia)) as [E6 S6]. set (n6 := Bmult mode_NE n5 n5) in *.
    destruct (mul_sized _ _ n6 n5 S6 S5 ltac:(lia)) as [E7 S7]. set (n7 := Bmult mode_NE n6 n5) in *.
    destruct (mul_sized _ _ n5 s S5 Hs ltac:(lia)) as [E8 S8]. set (n8 := Bmult mode_NE n5 s) in *.
    destruct (add_sized _ _ l1 n8 O2 S8 ltac:(lia)) as [E9 S9]. set (n9 := Bplus mode_NE l1 n8) in *.
    destruct (mul_sized _ _ l3 n9 T2 S9 ltac:(lia)) as [E10 S10]. set (n10 := Bmult mode_NE l3 n9) in *.
    destruct (mul_sized _ _ n5 n10 S5 S10 ltac:(lia)) as [E11 S11]. set (n11 := Bmult mode_NE n5 n10) in *.
    destruct (add_sized _ _ l1 n11 O2 S11 ltac:(lia)) as [E12 S12]. set (n12 := Bplus mode_NE l1 n11) in *.
    destruct (mul_sized _ _ s n10 Hs S10 ltac:(lia)) as [E13 S13]. set (n13 := Bmult mode_NE s n10) in *.
    destruct (add_sized _ _ l1 n13 O2 S13 ltac:(lia)) as [E14 S14]. set (n14 := Bplus mode_NE l1 n13) in *.
    destruct (mul_sized _ _ s s Hs Hs ltac:(lia)) as [E15 S15]. set (n15 := Bmult mode_NE s s) in *.
    destruct (mul_sized _ _ n15 s S15 Hs ltac:(lia)) as [E16 S16]. set (n16 := Bmult mode_NE n15 s) in *.
    destruct (mul_sized _ _ n7 q0 S7 H0 ltac:(lia)) as [E17 S17]. set (n17 := Bmult mode_NE n7 q0) in *.
    destruct (mul_sized _ _ n12 q1 S12 H1 ltac:(lia)) as [E18 S18]. set (n18 := Bmult mode_NE n12 q1) in *.
    destruct (add_sized _ _ n17 n18 S17 S18 ltac:(lia)) as [E19 S19]. set (n19 := Bplus mode_NE n17 n18) in *.
    destruct (mul_sized _ _ n14 q2 S14 H2 ltac:(lia)) as [E20 S20]. set (n20 := Bmult mode_NE n14 q2) in *.
    destruct (mul_sized _ _ n16 q3 S16 H3 ltac:(lia)) as [E21 S21]. set (n21 := Bmult mode_NE n16 q3) in *.
    destruct (add_sized _ _ n20 n21 S20 S21 ltac:(lia)) as [E22 S22]. set (n22 := Bplus mode_NE n20 n21) in *.
    destruct (add_sized _ _ n19 n22 S19 S22 ltac:(lia)) as [E23 S23]. 
    split; [|apply S23]. rewrite E23. cbv [exec basis_blend app nth Rounding.get apply_op what left right].
    rewrite E22, E21, E20, E19, E18, E17, E16, E15, E14, E13, E12, E11, E10, E9, E8, E7, E6, E5, O1, T1. reflexivity.
  Qed.

End Machine.

Section Format.
  Variable f : format.
  Notation prec := (precision f).
  Notation emax := (largest_exponent f).
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).
  Local Instance pos_ : Prec_gt_0 prec := precision_pos f.
  Local Instance below_ : Prec_lt_emax prec emax := precision_below f.
  Notation sized := (sized prec emax).
  Variable log_ : number -> number.
  Let A := machine prec emax _ _ log_.
  Let prec_large := precision_large f.
  Let emax_large := exponent_large f.
  Notation lit d := (decimal_number prec emax pos_ below_ d).

  (* ---------------------------------------------------------------- time, segment and place *)

  Variable k : constants.
  Variables (rows : Tube.table) (unit c last_ : R).
  Let K := segments rows.
  Hypothesis rate_ok : value (lit (rate k)) = c /\ is_finite (lit (rate k)) = true.
  Hypothesis last_ok : value (lit (last k)) = last_ /\ is_finite (lit (last k)) = true.
  Hypothesis c_range : 0 <= c <= 1073741824.
  Hypothesis last_range : 0 <= last_ < INR K.
  Hypothesis K_small : (Z.of_nat K <= 2 ^ 24)%Z.
  Notation time_of := (emitted_time f c last_).

  Variable t : number.
  Hypothesis finite_t : is_finite t = true.

  Let time := Control.spline_time A k t.
  Lemma time_machine : value time = time_of (value t) /\ is_finite time = true.
  Proof.
    destruct (literal_zero prec emax pos_ below_) as [Z1 Z2]. destruct rate_ok as [C1 C2]. destruct last_ok as [L1 L2].
    unfold time, Control.spline_time. cbv zeta.
    change (literal A zero) with (decimal_number prec emax pos_ below_ zero). change (literal A (rate k)) with (decimal_number prec emax pos_ below_ (rate k)).
    change (literal A (last k)) with (decimal_number prec emax pos_ below_ (last k)).
    change (less A) with (@Bltb prec emax). change (mul A) with (@Bmult prec emax pos_ below_ mode_NE).
    set (z := decimal_number prec emax pos_ below_ zero) in *. set (r := decimal_number prec emax pos_ below_ (rate k)) in *.
    set (l := decimal_number prec emax pos_ below_ (last k)) in *.
    assert (St : value (if Bltb z t then t else z) = (if Rlt_dec 0 (value t) then value t else 0) /\ is_finite (if Bltb z t then t else z) = true).
    { assert (H := less_ok prec emax z t Z2 finite_t). rewrite Z1 in H. destruct (Bltb z t); destruct (Rlt_dec 0 (value t)) as [Q|Q]; auto.
      - exfalso; apply Q, H; reflexivity.
      - apply H in Q. discriminate. }
    set (st := if Bltb z t then t else z) in *. destruct St as [S1 S2].
    assert (S0 : 0 <= value st) by (rewrite S1; destruct Rlt_dec; lra).
    change (value (if Bltb (Bmult mode_NE st r) l then Bmult mode_NE st r else l) = time_of (value t) /\ is_finite (if Bltb (Bmult mode_NE st r) l then Bmult mode_NE st r else l) = true).
    assert (M := Bmult_correct prec emax _ _ mode_NE st r). cbn [round_mode] in M.
    match type of M with context [round radix2 ?e ?m (value st * value r)] => change (round radix2 e m (value st * value r)) with (Semantics.rnd prec emax (value st * value r)) in M end.
    destruct (Rlt_bool_spec (Rabs (Semantics.rnd prec emax (value st * value r))) (bpow radix2 emax)) as [Fits|Over].
    2: { (* where the product overflows, time is past the end anyway *)
      assert (Rn : 0 <= Semantics.rnd prec emax (value st * value r)).
      { rewrite <- (rnd_0 prec emax). apply rnd_le; [exact pos_|]. apply Rmult_le_pos; [exact S0|rewrite C1; lra]. }
      rewrite (Rabs_pos_eq _ Rn) in Over.
      assert (Big : last_ < bpow radix2 emax).
      { rewrite <- L1. eapply Rle_lt_trans; [apply Rle_abs|]. apply abs_B2R_lt_emax. }
      assert (Nz : 0 < value st /\ 0 < value r).
      { assert (P : 0 < value st * value r).
        { apply Rnot_le_lt; intro Q. apply (rnd_le prec emax pos_) in Q. rewrite rnd_0 in Q. pose proof (bpow_gt_0 radix2 emax). lra. }
        rewrite C1 in *. assert (value st <> 0) by (intro Q; rewrite Q, Rmult_0_l in P; lra). assert (c <> 0) by (intro Q; rewrite Q, Rmult_0_r in P; lra). lra. }
      assert (Sgn : forall v : number, 0 < value v -> Bsign v = false).
      { intros [sv|sv| |sv mv ev Hv] Q; cbn in Q; try lra. destruct sv; [|reflexivity]. exfalso. 
        assert (F2R (Float radix2 (Zneg mv) ev) < 0) by (now apply F2R_lt_0). cbn in *. lra. }
      rewrite (Sgn st (proj1 Nz)), (Sgn r (proj2 Nz)) in M. cbn [xorb] in M.
      assert (Less : Bltb (Bmult mode_NE st r) l = false).
      { unfold Bltb. rewrite M. clear - L2. change (binary_overflow prec emax mode_NE false) with (S754_infinity false). destruct l as [sl|sl| |sl ml el Hl]; try reflexivity; discriminate. }
      rewrite Less, L1. split; [|exact L2]. unfold emitted_time; cbv zeta. rewrite <- rnd_format_of, <- S1, <- C1.
      destruct (Rlt_dec _ last_) as [Q|Q]; [lra|reflexivity]. }
    destruct M as (M1 & M2 & _). rewrite S2, C2 in M2. cbn [andb] in M2. rewrite rnd_format_of in M1.
    assert (H := less_ok prec emax (Bmult mode_NE st r) l M2 L2). rewrite M1, L1, S1, C1 in H.
    unfold emitted_time; cbv zeta. destruct (Bltb (Bmult mode_NE st r) l); destruct (Rlt_dec _ last_) as [Q|Q].
    - rewrite M1, S1, C1. auto.
    - exfalso; apply Q, H; reflexivity.
    - apply H in Q. discriminate.
    - auto.
  Qed.

  Definition segment_of : Z := Zfloor (time_of (value t)).
  Lemma segment_range : (0 <= segment_of < Z.of_nat K)%Z.
  Proof.
    pose proof (emitted_time_range f rows c last_ ltac:(lra) last_range (value t)) as R0. unfold segment_of. split; [apply Zfloor_lub; lra|].
    apply lt_IZR. rewrite <- INR_IZR_INZ. pose proof (Zfloor_lb (time_of (value t))). lra.
  Qed.
  Lemma segment_machine : to_integer A time = Some segment_of.
  Proof.
    destruct time_machine as [T1 T2]. cbn [to_integer A machine]. rewrite T2, to_int_ok by exact below_. rewrite T1.
    unfold segment_of. rewrite Ztrunc_floor by (apply (emitted_time_range f rows c last_ ltac:(lra) last_range)). reflexivity.
  Qed.

  Let s := place A time segment_of.
  Lemma place_machine : value s = to_format f (time_of (value t) - IZR segment_of) /\ sized 0 s.
  Proof.
    destruct time_machine as [T1 T2]. pose proof segment_range as Sr. pose proof (emitted_time_range f rows c last_ ltac:(lra) last_range (value t)) as R0.
    pose proof (Zfloor_lb (time_of (value t))) as Lb. pose proof (Zfloor_ub (time_of (value t))) as Ub. fold segment_of in Lb, Ub.
    destruct (of_int_ok prec emax _ _ prec_large emax_large segment_of ltac:(lia)) as [I1 I2].
    unfold s, place. change (sub A) with (@Bminus prec emax pos_ below_ mode_NE). change (of_integer A segment_of) with (of_int prec emax pos_ below_ segment_of).
    assert (Small : Rabs (value time - value (of_int prec emax pos_ below_ segment_of)) <= bpow radix2 0).
    { rewrite T1, I1. cbn [bpow]. apply Rabs_le; lra. }
    destruct (sub_ok prec emax _ _ prec_large emax_large time (of_int prec emax pos_ below_ segment_of) T2 I2) as [Q1 Q2].
    { apply (within_most emax emax_large 0); [lia|exact Small]. }
    split; [rewrite Q1, T1, I1; apply rnd_format_of|]. split; [exact Q2|]. rewrite Q1. apply (rnd_sized prec emax _ _ prec_large emax_large); [lia|exact Small].
  Qed.

  (* `segment` gives the place that the time has *)
  Lemma place_of_machine : place_of_time f c last_ (value t) = (Z.to_nat segment_of, value s).
  Proof.
    destruct place_machine as [P1 _]. pose proof segment_range as Sr. pose proof (emitted_time_range f rows c last_ ltac:(lra) last_range (value t)) as R0.
    assert (Sg : Ztrunc (time_of (value t)) = segment_of) by (unfold segment_of; apply Ztrunc_floor; lra).
    unfold place_of_time. cbv zeta. rewrite Sg, P1. now rewrite INR_IZR_INZ, Z2Nat.id by lia.
  Qed.
End Format.

(* ------------------------------------------------------------------ an edge *)

Section Place.
  Variable f : format.
  Notation prec := (precision f).
  Notation emax := (largest_exponent f).
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).
  Local Existing Instance pos_.
  Local Existing Instance below_.
  Variable log_ : number -> number.
  Let A := machine prec emax _ _ log_.
  Variables (rows : Tube.table) (unit : R) (segment : nat) (s : number).
  Hypothesis s_range : sized prec emax 0 s.
  Variables (i : nat) (side : Z * Z -> Z).
  Variables q0 q1 q2 q3 : number.
  Let coefficient (j : nat) : R := unit * IZR (nth (segment + j) (column side i rows) 0%Z).
  Hypothesis q0_ok : value q0 = coefficient 0 /\ is_finite q0 = true.
  Hypothesis q1_ok : value q1 = coefficient 1 /\ is_finite q1 = true.
  Hypothesis q2_ok : value q2 = coefficient 2 /\ is_finite q2 = true.
  Hypothesis q3_ok : value q3 = coefficient 3 /\ is_finite q3 = true.
  Hypothesis bounded : forall k, Rabs (unit * IZR (nth k (column side i rows) 0%Z)) <= 1073741824.

  Theorem edge_of_machine : value (edge A s q0 q1 q2 q3) = placed f rows unit side i (segment, value s) /\ is_finite (edge A s q0 q1 q2 q3) = true.
  Proof.
    assert (Sq : forall q j, value q = coefficient j /\ is_finite q = true -> sized prec emax 30 q).
    { intros q j [Q1 Q2]. split; [exact Q2|]. rewrite Q1. change (bpow radix2 30) with 1073741824. apply bounded. }
    destruct (edge_machine prec emax _ _ (precision_large f) (exponent_large f) log_ s q0 q1 q2 q3 s_range (Sq _ _ q0_ok) (Sq _ _ q1_ok) (Sq _ _ q2_ok) (Sq _ _ q3_ok)) as [E1 E2].
    split; [|exact E2]. change (value (edge A s q0 q1 q2 q3)) with (value (edge (machine prec emax (pos_ f) (below_ f) log_) s q0 q1 q2 q3)). rewrite E1.
    destruct q0_ok as [-> _]. destruct q1_ok as [-> _]. destruct q2_ok as [-> _]. destruct q3_ok as [-> _].
    unfold placed; cbv zeta; cbn [fst snd]. unfold coefficient. generalize [value s;
      unit * IZR (nth (segment + 0) (column side i rows) 0%Z); unit * IZR (nth (segment + 1) (column side i rows) 0%Z);
      unit * IZR (nth (segment + 2) (column side i rows) 0%Z); unit * IZR (nth (segment + 3) (column side i rows) 0%Z)].
    intro env. f_equal. revert env. generalize basis_blend. clear. intro b. induction b as [|st rest IH]; intro env; cbn [exec]; [reflexivity|]. rewrite rnd_format_of. apply IH.
  Qed.
End Place.
