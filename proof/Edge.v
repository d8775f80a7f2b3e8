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
End Machine.
