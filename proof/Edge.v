(* The edges that the emitted control computes, against the exact spline: P7 for any precision, from the machine's own operations. *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra Psatz.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Stt Require Import Tube Loop Speed Rounding Syntax Run Emission Control Semantics.
Import ListNotations.
Open Scope R_scope.

(* ------------------------------------------------------------------ rounding error of one edge, for any unit roundoff *)

Definition tiny_Q : Q := 1 # Z.to_pos (2 ^ 150).
Definition evaluation (ulp largest : Q) : option Q :=
  match analyse ulp tiny_Q basis_blend
          [Known 0 1 0; Known (- largest) largest 0; Known (- largest) largest 0; Known (- largest) largest 0; Known (- largest) largest 0] with
  | Some out => option_map error (nth_error out 23)
  | None => None
  end.

Lemma evaluation_sound rnd ulp largest e s a b c d :
  (forall x, Rabs (rnd x - x) <= Rabs x * Q2R ulp + Q2R tiny_Q) -> 0 <= Q2R ulp ->
  evaluation ulp largest = Some e -> 0 <= s <= 1 ->
  Rabs a <= Q2R largest -> Rabs b <= Q2R largest -> Rabs c <= Q2R largest -> Rabs d <= Q2R largest ->
  Rabs (nth 23 (exec rnd basis_blend [s; a; b; c; d]) 0 -
    (a * (1 - s)^3 + b * (3*s^3 - 6*s^2 + 4) + c * (- 3*s^3 + 3*s^2 + 3*s + 1) + d * s^3)) <= Q2R e.
Proof.
  intros Rn Ul E Hs Ha Hb Hc Hd. unfold evaluation in E.
  destruct (analyse _ _ _ _) as [out|] eqn:An; [|easy].
  assert (Z0 : Q2R 0 = 0) by (unfold Q2R; cbn; lra). assert (Z1 : Q2R 1 = 1) by (unfold Q2R; cbn; lra).
  assert (M : forall x, Rabs x <= Q2R largest -> means (Known (- largest) largest 0) x x).
  { intros x Hx; unfold means; cbn [low high error]. rewrite Q2R_opp, Z0, Rminus_diag_eq, Rabs_R0 by reflexivity.
    apply Rabs_le_between in Hx; lra. }
  assert (S := analyse_sound ulp tiny_Q rnd Rn Ul _ _ [s; a; b; c; d] [s; a; b; c; d] _ An).
  destruct (nth_error out 23) as [k|] eqn:N; [|easy]. cbn in E. injection E as <-.
  assert (H3 : All3 [Known 0 1 0; Known (- largest) largest 0; Known (- largest) largest 0; Known (- largest) largest 0;
                     Known (- largest) largest 0] [s; a; b; c; d] [s; a; b; c; d]).
  { apply cons3; [|apply cons3; [now apply M|apply cons3; [now apply M|apply cons3; [now apply M|apply cons3; [now apply M|apply nil3]]]]].
    unfold means; cbn [low high error]. rewrite Z0, Z1, Rminus_diag_eq, Rabs_R0 by reflexivity. lra. }
  destruct (All3_nth _ _ _ 23 k (S H3) N) as [_ Q].
  replace (a * (1 - s)^3 + b * (3*s^3 - 6*s^2 + 4) + c * (- 3*s^3 + 3*s^2 + 3*s + 1) + d * s^3)
    with (nth 23 (exec (fun x => x) basis_blend [s; a; b; c; d]) 0); [exact Q|].
  cbv [exec basis_blend app nth Rounding.get apply_op what left right]; ring.
Qed.

Section Machine.
  Variables prec emax : Z.
  Context (prec_gt_0_ : Prec_gt_0 prec).
  Context (prec_lt_emax_ : Prec_lt_emax prec emax).
  Hypothesis prec_large : (24 <= prec)%Z.
  Hypothesis emax_large : (128 <= emax)%Z.
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).
  Notation rnd := (rnd prec emax).
  Notation fexp := (FLT_exp (3 - emax - prec) prec).
  Variable log_ : number -> number.
  Let u := unit_roundoff prec.
  Let A := machine prec emax _ _ log_.

  Definition ulp_Q : Q := 1 # Z.to_pos (2 ^ prec).
  Lemma ulp_ok : Q2R ulp_Q = u.
  Proof.
    unfold Q2R, ulp_Q, u, unit_roundoff; cbn [Qnum Qden]. assert (0 < 2 ^ prec)%Z by (apply Z.pow_pos_nonneg; lia).
    rewrite Z2Pos.id by assumption. change 2%Z with (radix_val radix2). rewrite IZR_Zpower by lia. rewrite <- bpow_opp. ring.
  Qed.
  Lemma rnd_ok x : Rabs (rnd x - x) <= Rabs x * Q2R ulp_Q + Q2R tiny_Q.
  Proof.
    rewrite ulp_ok. eapply Rle_trans; [apply rnd_error; assumption|]. apply Rplus_le_compat_l. right. unfold tiny, Q2R, tiny_Q; cbn [Qnum Qden].
    replace (bpow radix2 (-150)) with (/ bpow radix2 150) by (rewrite <- bpow_opp; reflexivity).
    change (bpow radix2 150) with (IZR (Zpos (Z.to_pos (2 ^ 150)))). lra.
  Qed.

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

  (* ---------------------------------------------------------------- u - floor u is exact *)

  Lemma place_is_exact v k : generic_format radix2 fexp v -> IZR k <= v < IZR k + 1 -> (0 <= k)%Z -> rnd (v - IZR k) = v - IZR k.
  Proof.
    intros G H K0. apply rnd_format.
    apply FLT_format_generic in G; [|easy]. destruct G as [[m e] E M X]; cbn [Fnum Fexp] in *.
    unfold F2R in E; cbn [Fnum Fexp] in E.
    destruct (Z_le_gt_dec e 0) as [e0|e0].
    - apply generic_format_FLT. exists (Float radix2 (m - k * 2 ^ (- e)) e); cbn [Fnum Fexp]; [|  |exact X].
      + unfold F2R; cbn [Fnum Fexp]. rewrite minus_IZR, mult_IZR, E.
        change 2%Z with (radix_val radix2). rewrite IZR_Zpower by lia. rewrite Rmult_minus_distr_r, Rmult_assoc, <- bpow_plus.
        replace (- e + e)%Z with 0%Z by lia. cbn [bpow]. ring.
      + assert (P : (0 <= m - k * 2 ^ (- e))%Z).
        { apply le_IZR. rewrite minus_IZR, mult_IZR. change 2%Z with (radix_val radix2). rewrite IZR_Zpower by lia.
          apply (Rmult_le_reg_r (bpow radix2 e)); [apply bpow_gt_0|]. rewrite Rmult_0_l, Rmult_minus_distr_r, Rmult_assoc, <- bpow_plus.
          replace (- e + e)%Z with 0%Z by lia. cbn [bpow]. lra. }
        assert (0 <= 2 ^ (- e))%Z by (apply Z.pow_nonneg; lia). nia.
    - replace (v - IZR k) with 0; [apply generic_format_0|].
      assert (U : v = IZR (m * 2 ^ e)) by (rewrite mult_IZR; change 2%Z with (radix_val radix2); rewrite IZR_Zpower by lia; exact E).
      rewrite U in *. destruct H as [B1 B2]. apply le_IZR in B1. rewrite <- plus_IZR in B2. apply lt_IZR in B2.
      rewrite <- minus_IZR. replace (m * 2 ^ e - k)%Z with 0%Z by lia. reflexivity.
  Qed.

  (* ---------------------------------------------------------------- time, segment and place *)

  Variable k : constants.
  Variables (rows : Tube.table) (n : nat) (unit T c last_ late : R).
  Let K := segments rows.
  Hypothesis rate_ok : value (decimal_number prec emax _ _ (rate k)) = c /\ is_finite (decimal_number prec emax _ _ (rate k)) = true.
  Hypothesis last_ok : value (decimal_number prec emax _ _ (last k)) = last_ /\ is_finite (decimal_number prec emax _ _ (last k)) = true.
  Hypothesis T_pos : 0 < T.
  Hypothesis unit_pos : 0 < unit.
  Hypothesis c_range : 0 <= c <= 1073741824.
  Hypothesis last_range : 0 <= last_ < INR K.
  Hypothesis K_small : (Z.of_nat K <= 2 ^ 24)%Z.
  Hypothesis late_last : INR K - last_ <= late.
  Hypothesis late_rate : T * Rabs (c - INR K / T) + (T * c * Q2R ulp_Q + Q2R tiny_Q) <= late.

  Definition time_of (t : R) : R :=
    let started := if Rlt_dec 0 t then t else 0 in
    let scaled := rnd (started * c) in
    if Rlt_dec scaled last_ then scaled else last_.

  Lemma time_range t : 0 <= time_of t <= last_.
  Proof.
    unfold time_of; cbv zeta. set (st := if Rlt_dec 0 t then t else 0).
    assert (S0 : 0 <= st) by (unfold st; destruct Rlt_dec; lra).
    assert (0 <= rnd (st * c)).
    { rewrite <- (rnd_0 prec emax). apply rnd_le; [exact prec_gt_0_|]. apply Rmult_le_pos; lra. }
    destruct (Rlt_dec (rnd (st * c)) last_); lra.
  Qed.

  Lemma time_close t : Rabs (time_of t - Tube.spline_time T rows t) <= late.
  Proof.
    assert (KT : INR K / T * T = INR K) by (field; lra).
    assert (R0 : 0 <= INR K / T) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    set (dc := Rabs (c - INR K / T)) in *.
    assert (Dc : - dc <= c - INR K / T <= dc) by (apply Rabs_le_between; unfold dc; lra).
    assert (U : 0 <= Q2R ulp_Q <= 1).
    { rewrite ulp_ok. pose proof (unit_roundoff_small prec prec_large) as H. change (IZR (2 ^ 24)) with 16777216 in H. fold u in H. lra. }
    set (ul := Q2R ulp_Q) in *. set (ti := Q2R tiny_Q) in *.
    unfold time_of, Tube.spline_time, hold; cbv zeta. fold K.
    destruct (Rlt_dec 0 t) as [t0|t0].
    2: { rewrite Rmult_0_l, rnd_0.
         assert (Rmin t T <= 0) by (apply Rle_trans with t; [apply Rmin_l|lra]).
         rewrite Rmax_left, Rmult_0_r by lra.
         destruct (Rlt_dec 0 last_); [rewrite Rminus_0_r, Rabs_R0|].
         - lra.
         - replace last_ with 0 by lra. rewrite Rminus_0_r, Rabs_R0. lra. }
    rewrite (Rmax_right 0) by (apply Rmin_glb; lra).
    assert (E := rnd_ok (t * c)). fold ul ti in E. rewrite (Rabs_pos_eq (t * c)) in E by (apply Rmult_le_pos; lra).
    apply Rabs_le_between in E.
    destruct (Rle_dec t T) as [tT|tT].
    - rewrite Rmin_left by exact tT.
      assert (B1 : t * c * ul <= T * c * ul) by (apply Rmult_le_compat_r; [lra|apply Rmult_le_compat_r; lra]).
      assert (B2 : t * dc <= T * dc) by (apply Rmult_le_compat_r; [apply Rabs_pos|lra]).
      assert (Dt : - (t * dc) <= t * c - INR K / T * t <= t * dc) by nra.
      assert (Up : INR K / T * t <= INR K) by (rewrite <- KT at 2; apply Rmult_le_compat_l; lra).
      destruct (Rlt_dec (rnd (t * c)) last_); apply Rabs_le; lra.
    - rewrite Rmin_right by lra. rewrite KT.
      assert (B1 : T * c * (1 - ul) <= t * c * (1 - ul)) by (apply Rmult_le_compat_r; [lra|apply Rmult_le_compat_r; lra]).
      assert (Dt : - (T * dc) <= T * c - INR K) by (rewrite <- KT; nra).
      destruct (Rlt_dec (rnd (t * c)) last_); apply Rabs_le; lra.
  Qed.

  Variable t : number.
  Hypothesis finite_t : is_finite t = true.
  Hypothesis size_t : Rabs (value t) <= 1073741824.

  Let time := Control.spline_time A k t.
  Lemma time_machine : value time = time_of (value t) /\ is_finite time = true.
  Proof.
    destruct literal_zero as [Z1 Z2]. destruct rate_ok as [C1 C2]. destruct last_ok as [L1 L2].
    unfold time, Control.spline_time. cbv zeta.
    change (literal A zero) with (decimal_number prec emax prec_gt_0_ prec_lt_emax_ zero). change (literal A (rate k)) with (decimal_number prec emax prec_gt_0_ prec_lt_emax_ (rate k)).
    change (literal A (last k)) with (decimal_number prec emax prec_gt_0_ prec_lt_emax_ (last k)).
    change (less A) with (@Bltb prec emax). change (mul A) with (@Bmult prec emax prec_gt_0_ prec_lt_emax_ mode_NE).
    set (z := decimal_number prec emax prec_gt_0_ prec_lt_emax_ zero) in *. set (r := decimal_number prec emax prec_gt_0_ prec_lt_emax_ (rate k)) in *.
    set (l := decimal_number prec emax prec_gt_0_ prec_lt_emax_ (last k)) in *.
    assert (St : value (if Bltb z t then t else z) = (if Rlt_dec 0 (value t) then value t else 0) /\ is_finite (if Bltb z t then t else z) = true).
    { assert (H := less_ok prec emax z t Z2 finite_t). rewrite Z1 in H. destruct (Bltb z t); destruct (Rlt_dec 0 (value t)) as [Q|Q]; auto.
      - exfalso; apply Q, H; reflexivity.
      - apply H in Q. discriminate. }
    set (st := if Bltb z t then t else z) in *. destruct St as [S1 S2].
    assert (Ss : sized 30 st).
    { split; [exact S2|]. rewrite S1. change (bpow radix2 30) with 1073741824. destruct Rlt_dec; [exact size_t|rewrite Rabs_R0; lra]. }
    assert (Sr : sized 30 r) by (split; [exact C2|rewrite C1; change (bpow radix2 30) with 1073741824; apply Rabs_le; lra]).
    destruct (mul_sized _ _ st r Ss Sr ltac:(lia)) as [M1 [M2 _]].
    assert (H := less_ok prec emax (Bmult mode_NE st r) l M2 L2). rewrite M1, L1, S1, C1 in H.
    change (value (if Bltb (Bmult mode_NE st r) l then Bmult mode_NE st r else l) = time_of (value t) /\ is_finite (if Bltb (Bmult mode_NE st r) l then Bmult mode_NE st r else l) = true).
    unfold time_of; cbv zeta. destruct (Bltb (Bmult mode_NE st r) l); destruct (Rlt_dec _ last_) as [Q|Q].
    - rewrite M1, S1, C1. auto.
    - exfalso; apply Q, H; reflexivity.
    - apply H in Q. discriminate.
    - auto.
  Qed.

  Definition segment_of : Z := Zfloor (time_of (value t)).
  Lemma segment_range : (0 <= segment_of < Z.of_nat K)%Z.
  Proof.
    pose proof (time_range (value t)) as R0. unfold segment_of. split; [apply Zfloor_lub; lra|].
    apply lt_IZR. rewrite <- INR_IZR_INZ. pose proof (Zfloor_lb (time_of (value t))). lra.
  Qed.
  Lemma segment_machine : to_integer A time = Some segment_of.
  Proof.
    destruct time_machine as [T1 T2]. cbn [to_integer A machine]. rewrite T2, to_int_ok by exact prec_lt_emax_. rewrite T1.
    unfold segment_of. rewrite Ztrunc_floor by apply time_range. reflexivity.
  Qed.

  Let s := place A time segment_of.
  Lemma place_machine : value s = time_of (value t) - IZR segment_of /\ sized 0 s /\ 0 <= value s <= 1.
  Proof.
    destruct time_machine as [T1 T2]. pose proof segment_range as Sr. pose proof (time_range (value t)) as R0.
    pose proof (Zfloor_lb (time_of (value t))) as Lb. pose proof (Zfloor_ub (time_of (value t))) as Ub. fold segment_of in Lb, Ub.
    destruct (of_int_ok prec emax _ _ prec_large emax_large segment_of ltac:(lia)) as [I1 I2].
    assert (P : value s = time_of (value t) - IZR segment_of /\ is_finite s = true).
    { unfold s, place. change (sub A) with (@Bminus prec emax prec_gt_0_ prec_lt_emax_ mode_NE). change (of_integer A segment_of) with (of_int prec emax prec_gt_0_ prec_lt_emax_ segment_of).
      destruct (sub_ok prec emax _ _ prec_large emax_large time (of_int prec emax prec_gt_0_ prec_lt_emax_ segment_of) T2 I2) as [Q1 Q2].
      - rewrite T1, I1. apply within_most with 0%Z; [lia|]. cbn [bpow]. apply Rabs_le; lra.
      - split; [|exact Q2]. rewrite Q1, T1, I1. apply place_is_exact; [rewrite <- T1; apply number_format|lra|lia]. }
    destruct P as [P1 P2]. split; [exact P1|split; [split; [exact P2|rewrite P1; cbn [bpow]; apply Rabs_le; lra]|rewrite P1; lra]].
  Qed.

  (* ---------------------------------------------------------------- an edge *)

  Variables (i : nat) (side : Z * Z -> Z) (of : bez * bez -> bez) (Vi : Z) (largest e : Q).
  Variables q0 q1 q2 q3 : number.
  Let at_segment := Z.to_nat segment_of.
  Let coefficient (j : nat) : R := unit * IZR (nth (at_segment + j) (column side i rows) 0%Z).
  Hypothesis q0_ok : value q0 = coefficient 0 /\ is_finite q0 = true.
  Hypothesis q1_ok : value q1 = coefficient 1 /\ is_finite q1 = true.
  Hypothesis q2_ok : value q2 = coefficient 2 /\ is_finite q2 = true.
  Hypothesis q3_ok : value q3 = coefficient 3 /\ is_finite q3 = true.
  Hypothesis Rg : regular n rows = true.
  Hypothesis Hi : (i < n)%nat.
  Hypothesis sides : (side = fst /\ of = fst) \/ (side = snd /\ of = snd).
  Hypothesis St : steep Vi i rows = true.
  Hypothesis bounded : forall k, Rabs (unit * IZR (nth k (column side i rows) 0%Z)) <= Q2R largest.
  Hypothesis largest_small : Q2R largest <= 1073741824.
  Hypothesis ev : evaluation ulp_Q largest = Some e.

  Theorem edge_ok :
    Rabs (value (edge A s q0 q1 q2 q3) - Tube.edge unit T rows side i (value t)) <= Q2R e + unit * (3 * IZR Vi * late) /\
    is_finite (edge A s q0 q1 q2 q3) = true.
  Proof.
    destruct place_machine as (P1 & P2 & P3).
    assert (Sq : forall q j, value q = coefficient j /\ is_finite q = true -> sized 30 q).
    { intros q j [Q1 Q2]. split; [exact Q2|]. rewrite Q1. change (bpow radix2 30) with 1073741824. unfold coefficient. eapply Rle_trans; [apply bounded|exact largest_small]. }
    destruct (edge_machine s q0 q1 q2 q3 P2 (Sq _ _ q0_ok) (Sq _ _ q1_ok) (Sq _ _ q2_ok) (Sq _ _ q3_ok)) as [E1 E2].
    split; [|exact E2]. rewrite E1.
    destruct q0_ok as [-> _]. destruct q1_ok as [-> _]. destruct q2_ok as [-> _]. destruct q3_ok as [-> _].
    pose proof (time_range (value t)) as Ur. pose proof (time_close (value t)) as Uo. pose proof segment_range as Sr.
    set (v := time_of (value t)) in *.
    pose proof (Zfloor_lb v) as Lb. pose proof (Zfloor_ub v) as Ub. fold segment_of in Lb, Ub.
    assert (Ek : INR at_segment = IZR segment_of) by (unfold at_segment; rewrite INR_IZR_INZ, Z2Nat.id; [reflexivity|lia]).
    assert (Kk : segment K v = at_segment).
    { unfold segment. fold segment_of. fold at_segment. apply Nat.min_l. unfold at_segment. lia. }
    assert (Sp : Rabs (nth 23 (exec rnd basis_blend [value s; coefficient 0; coefficient 1; coefficient 2; coefficient 3]) 0 - unit * spline (column side i rows) v) <= Q2R e).
    { unfold spline.
      replace (length (column side i rows) - 3)%nat with K by (unfold K, segments, column; now rewrite map_length).
      cbv zeta. rewrite Kk, Ek.
      set (z := fun j => IZR (nth (at_segment + j) (column side i rows) 0%Z)).
      assert (Zb : forall j, Rabs (unit * z j) <= Q2R largest) by (intro; apply bounded).
      assert (Z0 : nth at_segment (column side i rows) 0%Z = nth (at_segment + 0) (column side i rows) 0%Z) by now rewrite Nat.add_0_r.
      rewrite Z0. unfold cubic. unfold coefficient. fold (z 0%nat) (z 1%nat) (z 2%nat) (z 3%nat). rewrite P1. fold v.
      eapply Rle_trans; [right|apply (evaluation_sound rnd ulp_Q largest e (v - IZR segment_of) (unit * z 0%nat) (unit * z 1%nat) (unit * z 2%nat) (unit * z 3%nat)); auto].
      - f_equal. f_equal. ring.
      - intro; apply rnd_ok.
      - rewrite ulp_ok. unfold u, unit_roundoff. apply bpow_ge_0.
      - lra. }
    assert (Kp : (0 < K)%nat) by (destruct (regular_ok _ _ Rg); unfold K, segments; lia).
    destruct (spline_time_range T rows (value t) T_pos) as [B1 B2]. fold K in B2.
    assert (V0 : 0 <= IZR Vi) by (eapply (V_nonneg rows n i Vi side of); eauto).
    assert (Lp : Rabs (spline (column side i rows) v - spline (column side i rows) (Tube.spline_time T rows (value t))) <= 3 * IZR Vi * late).
    { assert (G : forall a b, 0 <= a -> a <= b -> b <= INR K ->
        Rabs (spline (column side i rows) b - spline (column side i rows) a) <= 3 * IZR Vi * (b - a)).
      { intros a b Ha Hab Hb. apply (S_lip rows n i Vi side of Rg Hi sides St K); auto. }
      apply Rabs_le_between in Uo.
      destruct (Rle_dec (Tube.spline_time T rows (value t)) v).
      - apply Rle_trans with (3 * IZR Vi * (v - Tube.spline_time T rows (value t))); [apply G; lra|apply Rmult_le_compat_l; lra].
      - rewrite Rabs_minus_sym.
        apply Rle_trans with (3 * IZR Vi * (Tube.spline_time T rows (value t) - v)); [apply G; lra|apply Rmult_le_compat_l; lra]. }
    assert (Ed : Tube.edge unit T rows side i (value t) = unit * spline (column side i rows) (Tube.spline_time T rows (value t))) by reflexivity.
    rewrite Ed. clear Ed. revert Sp Lp.
    generalize (nth 23 (exec rnd basis_blend [value s; coefficient 0; coefficient 1; coefficient 2; coefficient 3]) 0)
      (spline (column side i rows) v) (spline (column side i rows) (Tube.spline_time T rows (value t))).
    intros a b d Sp Lp. replace (a - unit * d) with ((a - unit * b) + unit * (b - d)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat; [exact Sp|].
    rewrite Rabs_mult, (Rabs_pos_eq unit) by lra. apply Rmult_le_compat_l; lra.
  Qed.
End Machine.
