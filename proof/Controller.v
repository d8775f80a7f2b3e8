(* The emitted controller: from what the reader finds in the C text to the edges of the library and a law that acts as the library asks. *)
From Coq Require Import ZArith QArith Qreals Qabs Reals List Bool Lia Lra String.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import Core IEEE754.BinarySingleNaN.
From Stt Require HeldLaw.
From Stt Require Import Tube Loop Speed Rounding Emitted EmittedTube Syntax Read Run Emission Control Semantics Edge Law Logarithm.
Import ListNotations.
Open Scope R_scope.

(* ------------------------------------------------------------------ the table, one number after the other *)

Definition flat_row (r : list (Z * Z)) : list Z := flat_map (fun p => [fst p; snd p]) r.
Definition flat_table (rows : Tube.table) : list Z := flat_map flat_row rows.

Lemma nth_flat_map {A B} (g : A -> list B) m d a l : (forall y, In y l -> List.length (g y) = m) -> forall r j, (r < List.length l)%nat -> (j < m)%nat ->
  nth (m * r + j) (flat_map g l) d = nth j (g (nth r l a)) d.
Proof.
  induction l as [|y l IH]; intros H r j Hr Hj; [cbn in Hr; lia|]. cbn [flat_map]. assert (Ly : List.length (g y) = m) by (apply H; now left).
  destruct r as [|r].
  - rewrite Nat.mul_0_r, Nat.add_0_l, app_nth1 by lia. reflexivity.
  - rewrite app_nth2 by (rewrite Ly; lia). rewrite Ly. replace (m * S r + j - m)%nat with (m * r + j)%nat by lia. cbn [nth].
    apply IH; [intros; apply H; now right|cbn in Hr; lia|exact Hj].
Qed.
Lemma flat_row_length r : List.length (flat_row r) = (2 * List.length r)%nat.
Proof. unfold flat_row. induction r; cbn [flat_map app List.length]; [reflexivity|rewrite IHr; lia]. Qed.
Lemma flat_table_length n rows : regular n rows = true -> List.length (flat_table rows) = (2 * n * List.length rows)%nat.
Proof.
  unfold regular. rewrite andb_true_iff, forallb_forall. intros [H _]. unfold flat_table. induction rows as [|r rows IH]; cbn [flat_map List.length]; [lia|].
  rewrite app_length, flat_row_length, IH by (intros; apply H; now right). assert (E := H r (or_introl eq_refl)). apply Nat.eqb_eq in E. lia.
Qed.
Lemma flat_table_nth n rows r i : regular n rows = true -> (r < List.length rows)%nat -> (i < n)%nat ->
  nth (2 * n * r + 2 * i) (flat_table rows) 0%Z = fst (nth i (nth r rows []) (0, 0)%Z) /\
  nth (2 * n * r + (2 * i + 1)) (flat_table rows) 0%Z = snd (nth i (nth r rows []) (0, 0)%Z).
Proof.
  intros Rg Hr Hi. destruct (regular_ok _ _ Rg) as [_ Ln]. unfold flat_table.
  assert (Len : forall y, In y rows -> List.length (flat_row y) = (2 * n)%nat).
  { intros y Hy. rewrite flat_row_length. unfold regular in Rg. rewrite andb_true_iff, forallb_forall in Rg. destruct Rg as [Rg _]. assert (E := Rg y Hy). apply Nat.eqb_eq in E. lia. }
  specialize (Ln r Hr).
  split; rewrite (nth_flat_map flat_row (2 * n) 0%Z []) by (auto; lia); unfold flat_row.
  - replace (2 * i)%nat with (2 * i + 0)%nat by lia. rewrite (nth_flat_map _ 2 0%Z (0, 0)%Z) by (auto; lia). reflexivity.
  - rewrite (nth_flat_map _ 2 0%Z (0, 0)%Z) by (auto; lia). reflexivity.
Qed.

(* what the law may lose, in relative terms and in epsilon: so much with the library's logarithm, and so much with one that is written out *)
Definition loss (f : format) (k : constants) : Q := if written_out k then 1 # 16384 else 32 * half_ulp f.
Lemma acts_more k c r r' limit a b u : r <= r' -> HeldLaw.acts k c r limit a b u -> HeldLaw.acts k c r' limit a b u.
Proof. intros H (e1 & e2 & A & B & E). exists e1, e2. split; [lra|split; [lra|exact E]]. Qed.

Section Controller.
  Variable f : format.
  Notation prec := (precision f).
  Notation emax := (largest_exponent f).
  Notation number := (binary_float prec emax).
  Notation value := (@B2R prec emax).
  Notation pos_ := (Edge.pos_ f).
  Notation below_ := (Edge.below_ f).
  Local Existing Instance Edge.pos_.
  Local Existing Instance Edge.below_.
  Notation lit d := (decimal_number prec emax pos_ below_ d).

  (* every literal of the table is exactly so many steps *)
  Fixpoint matches (unit : Q) (ds : list decimal) (zs : list Z) : bool :=
    match ds, zs with
    | [], [] => true
    | d :: ds, z :: zs => if is_number prec emax d (unit * inject_Z z) then matches unit ds zs else false
    | _, _ => false
    end.
  Lemma matches_ok unit : forall ds zs, matches unit ds zs = true -> List.length ds = List.length zs /\ forall j, (j < List.length ds)%nat ->
    value (lit (nth j ds zero)) = Q2R unit * IZR (nth j zs 0%Z) /\ is_finite (lit (nth j ds zero)) = true.
  Proof.
    induction ds as [|d ds IH]; intros [|z zs] H; cbn [matches] in H; try discriminate; [split; [reflexivity|cbn; lia]|].
    destruct (is_number _ _ d _) eqn:E; [|easy]. destruct (IH zs H) as [Ln V]. split; [cbn; lia|].
    intros [|j] Hj; cbn [nth]; [|apply V; cbn in Hj; lia].
    destruct (is_number_ok prec emax _ _ _ _ E) as [E1 E2]. rewrite E1, Q2R_mult, Q2R_Z. auto.
  Qed.

  Definition small (v : Q) : bool := Qle_bool (Qabs v) (inject_Z 1073741824).

  (* of component i: its gain, with both signs, its clamp, and its limit *)
  Definition component_constants (k : constants) (gains clamps : list Q) (limits : list (option Q)) (i : nat) : bool :=
    let gain := nth i gains 0%Q in let c := nth i clamps 0%Q in
    (is_number prec emax (clamp (of_component k (Z.of_nat i))) c && Qle_bool (1 # 1073741824) c && Qle_bool c (1 # 4) &&
     (if several k then is_number prec emax (nth i (gain_table k) zero) gain else is_number prec emax (gain_lower k) gain && is_number prec emax (gain_upper k) (- gain)) &&
     Qle_bool (1 # 1073741824) gain && Qle_bool gain (inject_Z 1073741824) &&
     match nth i limits None with
     | Some m => if limited k then is_number prec emax (nth i (limit_table k) zero) m && Qle_bool 0 m else false
     | None => negb (limited k)
     end)%bool.
  Lemma component_constants_ok k gains clamps limits i : component_constants k gains clamps limits i = true -> forall log_,
    let A := machine prec emax pos_ below_ log_ in
    ((value (lit (clamp (of_component k (Z.of_nat i)))) = Q2R (nth i clamps 0%Q) /\ is_finite (lit (clamp (of_component k (Z.of_nat i)))) = true) /\
     / 1073741824 <= Q2R (nth i clamps 0%Q) <= / 4) /\
    (@B2R prec emax (low_gain A k (Z.of_nat i)) = Q2R (nth i gains 0%Q) /\ is_finite (low_gain A k (Z.of_nat i) : number) = true) /\
    (@B2R prec emax (high_gain A k (Z.of_nat i)) = - Q2R (nth i gains 0%Q) /\ is_finite (high_gain A k (Z.of_nat i) : number) = true) /\
    / 1073741824 <= Q2R (nth i gains 0%Q) <= 1073741824 /\
    match nth i limits None with
    | Some m => limited k = true /\ (@B2R prec emax (own A (limit_table k) (Z.of_nat i)) = Q2R m /\ is_finite (own A (limit_table k) (Z.of_nat i) : number) = true) /\ 0 <= Q2R m
    | None => limited k = false
    end.
  Proof.
    intros H log_ A. unfold component_constants in H. cbv zeta in H. rewrite !andb_true_iff in H. destruct H as [[[[[[C1 C2] C3] H1] H2] H3] H4].
    apply Qle_bool_R in H2, H3, C2, C3. rewrite Q2R_Z in H3. assert (Zi : Q2R (1 # 1073741824) = / 1073741824) by (unfold Q2R; cbn; lra).
    assert (Zq : Q2R (1 # 4) = / 4) by (unfold Q2R; cbn; lra). rewrite Zi in H2, C2. rewrite Zq in C3.
    unfold low_gain, high_gain, own. rewrite Nat2Z.id. change (literal A) with (decimal_number prec emax pos_ below_).
    assert (G : forall d v, is_number prec emax d v = true -> value (lit d) = Q2R v /\ is_finite (lit d) = true) by (intros; now apply is_number_ok).
    split; [split; [apply G, C1|lra]|]. split; [|split; [|split; [lra|]]].
    - destruct (several k); [|rewrite andb_true_iff in H1; destruct H1 as [H1 _]]; apply G, H1.
    - destruct (several k).
      + destruct (opp_ok prec emax (lit (nth i (gain_table k) zero))) as [O1 O2]. change (opp A) with (@Bopp prec emax). rewrite O1, O2. apply G in H1. destruct H1 as [-> ->]. auto.
      + rewrite andb_true_iff in H1. destruct H1 as [_ H1]. apply G in H1. rewrite Q2R_opp in H1. exact H1.
    - destruct (nth i limits None) as [m|].
      + destruct (limited k); [|discriminate]. rewrite andb_true_iff in H4. destruct H4 as [H4 H5]. apply Qle_bool_R in H5.
        assert (Z0 : Q2R 0 = 0) by (unfold Q2R; cbn; lra). rewrite Z0 in H5. split; [reflexivity|split; [apply G, H4|exact H5]].
      + destruct (limited k); [discriminate|reflexivity].
  Qed.

  Definition constants_check (k : constants) (coefficients : list decimal) (unit : Q) (task : Tube.task) (rows : Tube.table) (s : scale) (gains clamps : list Q)
    (limits : list (option Q)) : bool :=
    let n := Z.of_nat (n task) in
    let K := Z.of_nat (segments rows) in
    ((dimensions k =? n)%Z && (0 <? n)%Z && (K <=? 2 ^ 24)%Z && (2 * n * (K + 3) <=? 2147483647)%Z &&
     is_number prec emax (rate k) (dyadic (rate_m s) (rate_e s)) && is_number prec emax (last k) (dyadic (last_m s) (last_e s)) &&
     (if several k then (Z.of_nat (List.length (gain_table k)) =? n)%Z else true) && (if limited k then (Z.of_nat (List.length (limit_table k)) =? n)%Z else true) &&
     (if clamps_differ k then (Z.of_nat (List.length (clamp_table k)) =? n)%Z else true) && forallb (component_constants k gains clamps limits) (seq 0 (Tube.n task)) &&
     small (dyadic (rate_m s) (rate_e s)) && small (largest_of unit rows) && Qle_bool (1 # 1073741824) (min_width task) &&
     forallb (fun i => small (nth i (lo (space task)) 0%Q) && small (nth i (hi (space task)) 0%Q)) (seq 0 (Tube.n task)) &&
     matches unit coefficients (flat_table rows))%bool.

  Variables (k : constants) (coefficients : list decimal) (lines : list string).
  Variables (unit err : Q) (how : search) (task : Tube.task) (rows : Tube.table) (Vs : list Z) (s : scale) (late : Q) (gains clamps : list Q) (limits : list (option Q)).
  Hypothesis tube_checked : check unit err how task rows = true.
  Hypothesis slopes_checked : slopes err task rows Vs = true.
  Hypothesis rounding_checked : rounding_check f unit err task rows Vs s late = true.
  Hypothesis constants_checked : constants_check k coefficients unit task rows s gains clamps limits = true.

  Variable log_ : number -> number.
  Hypothesis log_accurate : written_out k = false -> accurate prec emax log_.
  Let A := machine prec emax pos_ below_ log_.
  Let prec_large := precision_large f.
  Let emax_large := exponent_large f.

  (* what `control` or `control_tick` is called with, besides the time *)
  Variable x : nat -> number.
  Hypothesis finite_x : forall i, (i < n task)%nat -> is_finite (x i) = true.
  Hypothesis size_x : forall i, (i < n task)%nat -> Rabs (value (x i)) <= 1073741824.
  Let xs (i : Z) : number := x (Z.to_nat i).

  Lemma small_ok v : small v = true -> Rabs (Q2R v) <= 1073741824.
  Proof. unfold small. intro H. apply Qle_bool_R in H. rewrite Q2R_abs, Q2R_Z in H. exact H. Qed.

  Lemma literal_zero_ok : value (lit zero) = 0 /\ is_finite (lit zero) = true.
  Proof. split; reflexivity. Qed.
  Lemma times_zero (v : number) : is_finite v = true -> value (Bmult mode_NE v (lit zero)) = 0 /\ is_finite (Bmult mode_NE v (lit zero)) = true.
  Proof.
    intro Fv. destruct literal_zero_ok as [Z1 Z2].
    destruct (mul_ok prec emax _ _ prec_large emax_large v (lit zero) Fv Z2) as [Q1 Q2]; [rewrite Z1, Rmult_0_r, Rabs_R0; unfold most; apply bpow_ge_0|].
    rewrite Q1, Z1, Rmult_0_r. split; [apply rnd_0|exact Q2].
  Qed.
  Lemma zeros_ok (first : number) m : value first = 0 /\ is_finite first = true -> (m <= n task)%nat -> value (zeros A xs first m) = 0 /\ is_finite (zeros A xs first m) = true.
  Proof.
    intros First. induction m; intro Hm; cbn [zeros]; [exact First|].
    destruct (IHm ltac:(lia)) as [I1 I2]. destruct (times_zero (xs (Z.of_nat m))) as [X1 X2]; [unfold xs; rewrite Nat2Z.id; apply finite_x; lia|].
    destruct (add_ok prec emax _ _ prec_large emax_large (zeros A xs first m) (Bmult mode_NE (xs (Z.of_nat m)) (lit zero)) I2 X2) as [Q1 Q2].
    { rewrite I1, X1, Rplus_0_l, Rabs_R0. unfold most. apply bpow_ge_0. }
    change (add A) with (@Bplus prec emax pos_ below_ mode_NE). change (mul A) with (@Bmult prec emax pos_ below_ mode_NE).
    change (literal A zero) with (lit zero). rewrite Q1, I1, X1, Rplus_0_l. split; [apply rnd_0|exact Q2].
  Qed.

  Let K := segments rows.
  Let cs := F2R (Float radix2 (rate_m s) (rate_e s)).
  Let ls := F2R (Float radix2 (last_m s) (last_e s)).

  (* the checks, as statements about real numbers *)
  Record checked : Prop := {
    dimensions_ok : dimensions k = Z.of_nat (n task);
    n_pos : (0 < n task)%nat;
    K_small : (Z.of_nat K <= 2 ^ 24)%Z;
    indices_small : (2 * dimensions k * (Z.of_nat K + 3) <= 2147483647)%Z;
    rate_value : value (lit (rate k)) = cs /\ is_finite (lit (rate k)) = true;
    last_value : value (lit (last k)) = ls /\ is_finite (lit (last k)) = true;
    gains_many : several k = true -> Z.of_nat (List.length (gain_table k)) = dimensions k;
    limits_many : limited k = true -> Z.of_nat (List.length (limit_table k)) = dimensions k;
    clamps_many : clamps_differ k = true -> Z.of_nat (List.length (clamp_table k)) = dimensions k;
    own_constants : forall i, (i < n task)%nat -> component_constants k gains clamps limits i = true;
    rate_size : 0 <= cs <= 1073741824;
    last_size : 0 <= ls < INR K;
    table_size : forall side i j, side = fst \/ side = snd -> Rabs (Q2R unit * IZR (nth j (column side i rows) 0%Z)) <= 1073741824;
    width_size : / 1073741824 <= Q2R (min_width task);
    space_size : forall i, (i < n task)%nat -> -1073741824 <= at_ (lo (space task)) i /\ at_ (hi (space task)) i <= 1073741824;
    table_matches : matches unit coefficients (flat_table rows) = true;
    table_regular : regular (n task) rows = true
  }.

  Lemma all_checked : checked.
  Proof.
    pose proof constants_checked as H. unfold constants_check in H. cbv zeta in H. rewrite !andb_true_iff in H.
    destruct H as [[[[[[[[[[[[[[H1 H2] H3] H4] H5] H6] H7] H8] H9] H10] H14] H15] H16] H17] H18].
    pose proof rounding_checked as G. unfold rounding_check in G. cbv zeta in G. rewrite !andb_true_iff in G.
    destruct G as [[[[[[[[[Cz Lz] LK] LL] Lm] Lexp] Rate] Bd] Bz] Ev].
    pose proof tube_checked as C. unfold check in C. cbv zeta in C. rewrite !andb_true_iff in C. destruct C as [[[Up Tp] Rg] _].
    apply Z.eqb_eq in H1. apply Z.ltb_lt in H2. apply Z.leb_le in H3, H4.
    apply is_number_ok with (prec_gt_0_ := pos_) (prec_lt_emax_ := below_) in H5, H6.
    rewrite forallb_forall in H10.
    apply Qle_bool_R in H16, Cz, Lz, Bz. apply positive_ok in LK.
    assert (Z0 : Q2R 0 = 0) by (unfold Q2R; cbn; lra).
    assert (Zi : Q2R (1 # 1073741824) = / 1073741824) by (unfold Q2R; cbn; lra).
    rewrite Zi, ?Q2R_Z in *. rewrite !dyadic_ok in *. rewrite Z0 in *.
    assert (KR : Q2R (inject_Z (Z.of_nat (segments rows))) = INR (segments rows)) by (now rewrite Q2R_Z, <- INR_IZR_INZ).
    rewrite Q2R_minus, KR, dyadic_ok in LK.
    apply small_ok in H14, H15. rewrite dyadic_ok in H14. apply Rabs_le_between in H14, H15.
    constructor; auto; try (unfold cs, ls, K; lra).
    - lia.
    - rewrite H1. exact H4.
    - intro Sv. rewrite Sv in H7. apply Z.eqb_eq in H7. now rewrite H1.
    - intro Li. rewrite Li in H8. apply Z.eqb_eq in H8. now rewrite H1.
    - intro Cd. rewrite Cd in H9. apply Z.eqb_eq in H9. now rewrite H1.
    - intros i Hi. apply H10, in_seq. lia.
    - intros side i j Sd. assert (S0 : side (0, 0)%Z = 0%Z) by (destruct Sd as [->| ->]; reflexivity).
      rewrite column_nth by exact S0.
      assert (Zero : Rabs (Q2R unit * IZR (side (0,0)%Z)) <= 1073741824) by (rewrite S0, Rmult_0_r, Rabs_R0; lra).
      rewrite forallb_forall in Bd.
      destruct (nth_in_or_default j rows []) as [I| ->]; [|destruct i; exact Zero].
      specialize (Bd _ I). rewrite forallb_forall in Bd.
      destruct (nth_in_or_default i (nth j rows []) (0, 0)%Z) as [I2|D]; [|rewrite D; exact Zero].
      specialize (Bd _ I2). rewrite andb_true_iff in Bd. destruct Bd as [B1 B2].
      apply Qle_bool_R in B1, B2. rewrite Q2R_abs, Q2R_mult, Q2R_Z in B1, B2.
      destruct Sd as [->| ->]; lra.
    - intros i Hi. rewrite forallb_forall in H17. assert (Q := H17 i ltac:(apply in_seq; lia)). rewrite andb_true_iff in Q. destruct Q as [Q1 Q2].
      apply small_ok in Q1, Q2. apply Rabs_le_between in Q1, Q2. unfold at_. lra.
  Qed.

  (* A place that fits a time, as the machine has it: the segment, and s in it. *)
  Section Placed.
  Variables (seg : Z) (part : number) (tau : R).
  Let p : nat * R := (Z.to_nat seg, value part).
  Hypothesis seg_range : (0 <= seg < Z.of_nat K)%Z.
  Hypothesis part_sized : sized prec emax 0 part.
  Hypothesis place_fits : fits_time task rows late tau p.
  Let L (i : nat) : R := at_place f unit rows fst i p.
  Let U (i : nat) : R := at_place f unit rows snd i p.

  (* one coefficient of the C's table *)
  Lemma coefficient_ok i j side : (i < n task)%nat -> (j <= 3)%nat -> (side = 0 \/ side = 1)%Z ->
    value (q A coefficients (seg * (2 * dimensions k) + Z.of_nat i * 2 + (2 * dimensions k * Z.of_nat j + side))) =
      Q2R unit * IZR (nth (Z.to_nat seg + j) (column (if (side =? 0)%Z then fst else snd) i rows) 0%Z) /\
    is_finite (q A coefficients (seg * (2 * dimensions k) + Z.of_nat i * 2 + (2 * dimensions k * Z.of_nat j + side))) = true.
  Proof.
    destruct all_checked as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr]. intros Hi Hj Hs.
    destruct (matches_ok _ _ _ Tm) as [Ml Mv]. rewrite (flat_table_length _ _ Tr) in Ml.
    destruct seg_range as [S1 S2].
    destruct (regular_ok _ _ Tr) as [L4 _]. assert (Kl : (List.length rows = K + 3)%nat) by (unfold K, segments; lia).
    set (r := (Z.to_nat seg + j)%nat). assert (Hr : (r < List.length rows)%nat) by (unfold r; lia).
    destruct (flat_table_nth _ _ _ _ Tr Hr Hi) as [F1 F2].
    unfold q. change (literal A) with (decimal_number prec emax pos_ below_).
    rewrite D. destruct Hs as [-> | ->]; cbn [Z.eqb].
    - assert (E : Z.to_nat (seg * (2 * Z.of_nat (n task)) + Z.of_nat i * 2 + (2 * Z.of_nat (n task) * Z.of_nat j + 0)) = (2 * n task * r + 2 * i)%nat) by (unfold r; nia).
      rewrite E. rewrite column_nth by reflexivity. rewrite <- F1. apply Mv. rewrite Ml. apply Nat.lt_le_trans with (2 * n task * (r + 1))%nat; [lia|apply Nat.mul_le_mono_l; lia].
    - assert (E : Z.to_nat (seg * (2 * Z.of_nat (n task)) + Z.of_nat i * 2 + (2 * Z.of_nat (n task) * Z.of_nat j + 1)) = (2 * n task * r + (2 * i + 1))%nat) by (unfold r; nia).
      rewrite E. rewrite column_nth by reflexivity. rewrite <- F2. apply Mv. rewrite Ml. apply Nat.lt_le_trans with (2 * n task * (r + 1))%nat; [lia|apply Nat.mul_le_mono_l; lia].
  Qed.

  Let Lf (i : nat) : number := Control.lower A k seg part (q A coefficients) (Z.of_nat i).
  Let Uf (i : nat) : number := Control.upper A k seg part (q A coefficients) (Z.of_nat i).

  Lemma edges_ok i : (i < n task)%nat -> (value (Lf i) = L i /\ is_finite (Lf i) = true) /\ (value (Uf i) = U i /\ is_finite (Uf i) = true).
  Proof.
    intro Hi. destruct all_checked as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr].
    assert (G : forall side j z, (j <= 3)%nat -> (side = 0 \/ side = 1)%Z -> z = (seg * (2 * dimensions k) + Z.of_nat i * 2 + (2 * dimensions k * Z.of_nat j + side))%Z ->
      value (q A coefficients z) = Q2R unit * IZR (nth (Z.to_nat seg + j) (column (if (side =? 0)%Z then fst else snd) i rows) 0%Z) /\ is_finite (q A coefficients z) = true).
    { intros side j z Hj Hs ->. now apply coefficient_ok. }
    unfold L, U, at_place. split.
    - unfold Lf, Control.lower. cbv zeta.
      apply (edge_of_machine f log_ rows (Q2R unit) (Z.to_nat seg) _ part_sized i fst).
      + apply (G 0%Z 0%nat); [lia|now left|ring].
      + apply (G 0%Z 1%nat); [lia|now left|ring].
      + apply (G 0%Z 2%nat); [lia|now left|ring].
      + apply (G 0%Z 3%nat); [lia|now left|ring].
      + intro j. apply Ts. now left.
    - unfold Uf, Control.upper. cbv zeta.
      apply (edge_of_machine f log_ rows (Q2R unit) (Z.to_nat seg) _ part_sized i snd).
      + apply (G 1%Z 0%nat); [lia|now right|ring].
      + apply (G 1%Z 1%nat); [lia|now right|ring].
      + apply (G 1%Z 2%nat); [lia|now right|ring].
      + apply (G 1%Z 3%nat); [lia|now right|ring].
      + intro j. apply Ts. now right.
  Qed.

  (* the emitted tube is wide enough, and within the state space *)
  Lemma edges_range i : (i < n task)%nat -> L i + Q2R (min_width task) <= U i /\ at_ (lo (space task)) i <= L i /\ U i <= at_ (hi (space task)) i.
  Proof.
    intro Hi.
    assert (Up : positive unit = true).
    { pose proof tube_checked as C. unfold check in C. cbv zeta in C. rewrite !andb_true_iff in C. apply C. }
    destruct (emission_near f unit err how task rows Vs s late tube_checked slopes_checked rounding_checked) as [_ Near].
    set (Lt := fun i r => if Req_EM_T r tau then L i else Tube.lower unit task rows i r). set (Ut := fun i r => if Req_EM_T r tau then U i else Tube.upper unit task rows i r).
    assert (Close : forall i r, (i < n task)%nat -> Rabs (Lt i r - Tube.lower unit task rows i r) <= Q2R err /\ Rabs (Ut i r - Tube.upper unit task rows i r) <= Q2R err).
    { intros j r Hj. destruct (Near j tau p Hj place_fits) as [N1 N2]. pose proof (Rabs_pos (at_place f unit rows fst j p - Tube.lower unit task rows j tau)).
      unfold Lt, Ut. destruct (Req_EM_T r tau) as [->|_]; [split; [exact N1|exact N2]|]. rewrite !Rminus_diag_eq, Rabs_R0 by reflexivity. split; lra. }
    destruct (tube_sound unit err Up task rows how tube_checked Lt Ut Close) as (P1 & _ & P3 & _).
    specialize (P1 i tau Hi). specialize (P3 i tau Hi). unfold in_box, Lt, Ut in P1, P3. destruct (Req_EM_T tau tau) as [_|Ne]; [|congruence]. split; [exact P1|exact P3].
  Qed.

  (* From a run to what it means: finite inputs that act as the law (13) with e clamped, and a status that says whether the state is inside. *)
  Definition acts_between (name : string) (v : Run.value A) (L U : nat -> R) : Prop := exists out status,
    execute A (log_name k) (Source lines (emitted_tables k coefficients) (Emission.emitted k)) name [v] (places_of A k xs) = Some (out, Some (I_ status)) /\
    (status = 0%Z <-> forall i, (i < n task)%nat -> L i < value (x i) < U i) /\ (status = 0 \/ status = 1)%Z /\
    forall i, (i < n task)%nat -> exists v : number, stored (A := A) "u" (Z.of_nat i) out = Some v /\ is_finite v = true /\
      HeldLaw.acts (Q2R (nth i gains 0%Q)) (Q2R (nth i clamps 0%Q)) (Q2R (loss f k)) (option_map Q2R (nth i limits None)) (value (x i) - L i) (U i - value (x i)) (value v).

  Lemma placed_acts name v : acts_at A k coefficients seg part xs lines name v -> acts_between name v L U.
  Proof.
    intros (out & E & St). unfold acts_between.
    destruct all_checked as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr].
    assert (Nd : number_of_dimensions k = n task) by (unfold number_of_dimensions; rewrite D; apply Nat2Z.id).
    assert (Near := logarithm_is_near f log_ k log_accurate). assert (Lam : 0 <= log_loss k <= / 8192) by (unfold log_loss; destruct (written_out k); lra).
      assert (Lost : 32 * unit_roundoff prec + 1.03 * log_loss k <= Q2R (loss f k)).
      { unfold loss, log_loss. destruct (written_out k).
        - pose proof (u_small prec (precision_large f)). replace (Q2R (1 # 16384)) with (/ 16384) by (unfold Q2R; cbn; lra). lra.
        - rewrite Q2R_mult, half_ulp_value. change (bpow radix2 (- prec)) with (unit_roundoff prec). replace (Q2R 32) with 32 by (unfold Q2R; cbn; lra). lra. }
      assert (Acts : forall i, (i < n task)%nat ->
        (HeldLaw.acts (Q2R (nth i gains 0%Q)) (Q2R (nth i clamps 0%Q)) (Q2R (loss f k)) (option_map Q2R (nth i limits None)) (value (x i) - L i) (U i - value (x i))
           (value (control_input A k (Z.of_nat i) (Lf i) (Uf i) (x i))) /\
         is_finite (control_input A k (Z.of_nat i) (Lf i) (Uf i) (x i) : number) = true) /\
        (is_within A (Lf i) (Uf i) (x i) = true <-> L i < value (x i) < U i)).
      { intros i Hi. destruct (edges_ok i Hi) as [[L1 L2] [U1 U2]]. destruct (edges_range i Hi) as (W & Sl & Su). destruct (Ss i Hi) as [S1 S2].
        assert (Wl : / 1073741824 <= value (x i) - value (Lf i) + (value (Uf i) - value (x i))) by (rewrite L1, U1; lra).
        assert (ZL : Rabs (value (Lf i)) <= 1073741824) by (rewrite L1; apply Rabs_le; lra).
        assert (ZU : Rabs (value (Uf i)) <= 1073741824) by (rewrite U1; apply Rabs_le; lra).
        split.
        - destruct (component_constants_ok k gains clamps limits i (Gs i Hi) log_) as ([Cv Cs] & Lg & Ug & Gr & Lk). fold A in Lg, Ug, Lk. unfold control_input. cbv zeta.
          destruct (nth i limits None) as [m|].
          + destruct Lk as (-> & [M1 M2] & M3).
            assert (G := saturated_acts prec emax pos_ below_ prec_large emax_large log_ (of_component k (Z.of_nat i)) (log_loss k) Lam Near (precision_small f) (Q2R (nth i gains 0%Q)) (Q2R (nth i clamps 0%Q))
              (high_gain A k (Z.of_nat i)) (low_gain A k (Z.of_nat i)) Lg Ug Cv Gr Cs
              (Lf i) (Uf i) (x i) L2 U2 (finite_x i Hi) ZL ZU (size_x i Hi) Wl (own A (limit_table k) (Z.of_nat i)) M2 ltac:(rewrite M1; exact M3)).
            rewrite L1, U1, M1 in G. split; [exact (acts_more _ _ _ _ _ _ _ _ Lost (proj1 G))|apply G].
          + rewrite Lk.
            assert (G := law_acts prec emax pos_ below_ prec_large emax_large log_ (of_component k (Z.of_nat i)) (log_loss k) Lam Near (precision_small f) (Q2R (nth i gains 0%Q)) (Q2R (nth i clamps 0%Q))
              (high_gain A k (Z.of_nat i)) (low_gain A k (Z.of_nat i)) Lg Ug Cv Gr Cs
              (Lf i) (Uf i) (x i) L2 U2 (finite_x i Hi) ZL ZU (size_x i Hi) Wl). rewrite L1, U1 in G.
            split; [exact (acts_more _ _ _ _ _ _ _ _ Lost (proj1 G))|apply G].
        - assert (G := within_ok prec emax pos_ below_ prec_large emax_large log_ (Lf i) (Uf i) (x i) L2 U2 (finite_x i Hi) ZL ZU (size_x i Hi)).
          rewrite L1, U1 in G. split; intro Q; [apply G in Q; lra|apply G; lra]. }
      exists out. eexists. split; [exact E|split; [|split]].
      + rewrite Nd. assert (O : forall m, (m <= n task)%nat -> outside_after A k seg part (q A coefficients) xs m = false <-> forall i, (i < m)%nat -> L i < value (x i) < U i).
        { induction m; intro Hm; cbn [outside_after]; [split; [intros _ i Hi; lia|reflexivity]|].
          specialize (IHm ltac:(lia)). destruct (Acts m ltac:(lia)) as [_ W]. cbv zeta. fold (Lf m) (Uf m). unfold xs at 1. rewrite Nat2Z.id.
          destruct (is_within A (Lf m) (Uf m) (x m)).
          - rewrite IHm. split; intros H i Hi; [destruct (Nat.eq_dec i m) as [->|Ne]; [now apply W|apply H; lia]|apply H; lia].
          - split; [discriminate|]. intro H. assert (Q := H m ltac:(lia)). apply W in Q. discriminate. }
        specialize (O (n task) ltac:(lia)). destruct (outside_after A k seg part (q A coefficients) xs (n task)).
        * split; [discriminate|]. intro H. apply O in H. discriminate.
        * split; [|reflexivity]. intros _. now apply O.
      + destruct (outside_after A k seg part (q A coefficients) xs (number_of_dimensions k)); auto.
      + intros i Hi. exists (control_input A k (Z.of_nat i) (Lf i) (Uf i) (x i)). destruct (Acts i Hi) as [[A1 A2] _]. split; [|split; [exact A2|exact A1]].
        rewrite (St (Z.of_nat i)) by (rewrite D; lia). unfold xs. rewrite Nat2Z.id. reflexivity.
  Qed.
  End Placed.

  Lemma table_fits : (0 < dimensions k /\ 2 * dimensions k * (Z.of_nat K + 3) <= 2147483647)%Z /\ (Z.of_nat (List.length coefficients) = 2 * dimensions k * (Z.of_nat K + 3))%Z.
  Proof.
    destruct all_checked as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr].
    destruct (matches_ok _ _ _ Tm) as [Ml _]. rewrite (flat_table_length _ _ Tr) in Ml.
    destruct (regular_ok _ _ Tr) as [L4 _]. assert (Kl : (List.length rows = K + 3)%nat) by (unfold K, segments; lia).
    split; [rewrite D in *; lia|]. rewrite D, Ml, Kl. nia.
  Qed.
  Lemma inputs_finite (first : number) : value first = 0 /\ is_finite first = true -> at_most A (zeros A xs first (number_of_dimensions k)) (literal A zero) = true.
  Proof.
    intro First. assert (Nd : number_of_dimensions k = n task) by (unfold number_of_dimensions; rewrite (dimensions_ok all_checked); apply Nat2Z.id).
    rewrite Nd. destruct (zeros_ok first (n task) First ltac:(lia)) as [Z1 Z2].
    apply (at_most_ok prec emax (zeros A xs first (n task)) (lit zero) Z2 eq_refl). rewrite Z1. right. reflexivity.
  Qed.

  (* The emitted `control`, for times that are right but for one rounding: it ends without anything undefined. *)
  Theorem control_acts (t : number) : is_finite t = true -> forall tau, reads f (value t) tau ->
    acts_between "@control" (@R_ A t) (fun i => EmittedTube.emitted f unit rows s fst i (value t)) (fun i => EmittedTube.emitted f unit rows s snd i (value t)).
  Proof.
    intros finite_t tau reads_t.
    destruct all_checked as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr]. destruct table_fits as [Fit Len].
    destruct (emission_near f unit err how task rows Vs s late tube_checked slopes_checked rounding_checked) as [Time _].
    assert (Fits := Time _ _ reads_t). assert (Pm := place_of_machine f log_ k rows cs ls Rv Lv Rs Ls Ks t finite_t). destruct (place_machine f log_ k rows cs ls Rv Lv Rs Ls Ks t finite_t) as [_ Ps].
    fold cs ls in Fits. unfold EmittedTube.emitted. fold cs ls. rewrite Pm in *.
    assert (Sr := segment_range f rows cs ls Rs Ls t).
    apply (placed_acts _ _ tau Sr Ps Fits).
    apply (control_executes A k coefficients (segment_of f cs ls t) (Z.of_nat K) _ xs lines Sr Fit Len Gm Cm Lm).
    - apply (segment_machine f log_ k rows cs ls Rv Lv Rs Ls t finite_t).
    - reflexivity.
    - apply inputs_finite, times_zero, finite_t.
  Qed.

  (* and `control_tick`, for every count of ticks. *)
  Definition counted (c : tick_numbers) (period : Q) : EmittedTube.ticks := Ticks (tick_limit c) (tick_multiplier c) (tick_divisor c) period.
  Definition tick_constants_check (period : Q) : bool :=
    match tick_constants k with
    | Some c => (ticks_check f task rows late (counted c period) && (tick_segments c =? Z.of_nat K)%Z && is_number prec emax (tick_share c) (inject_Z (tick_divisor c)) &&
        (tick_divisor c <=? 2 ^ 24)%Z && (tick_multiplier c <=? 2147483647)%Z && (0 <=? tick_limit c)%Z && (tick_limit c <=? 2147483647)%Z &&
        (tick_limit c * tick_multiplier c <=? 2147483647)%Z && (tick_divisor c * Z.of_nat K <=? 2147483647)%Z)%bool
    | None => false
    end.
  Definition tick_place_of (tick : Z) : nat * R :=
    match tick_constants k with Some c => place_of_tick f rows (tick_limit c) (tick_multiplier c) (tick_divisor c) tick | None => (0%nat, 0) end.

  Lemma tick_place_fits period tick : tick_constants_check period = true -> (0 <= tick)%Z -> fits_time task rows late (IZR tick * Q2R period) (tick_place_of tick).
  Proof.
    unfold tick_constants_check, tick_place_of. destruct (tick_constants k) as [c|]; [|discriminate]. rewrite !andb_true_iff. intros H T0. destruct H as [[[[[[[[H _] _] _] _] _] _] _] _].
    exact (ticks_fit f unit err how task rows late (counted c period) tick tube_checked H T0).
  Qed.

  Theorem control_tick_acts period tick : tick_constants_check period = true -> (0 <= tick <= 4294967295)%Z ->
    acts_between "@control_tick" (@U_ A tick) (fun i => at_place f unit rows fst i (tick_place_of tick)) (fun i => at_place f unit rows snd i (tick_place_of tick)).
  Proof.
    intros H T0. assert (Fits := tick_place_fits period tick H (proj1 T0)). revert H Fits. unfold tick_constants_check, tick_place_of.
    destruct (tick_constants k) as [c|] eqn:Tk; [|discriminate]. rewrite !andb_true_iff. intros [[[[[[[[H H1] H2] H3] H4] H5] H6] H7] H8] Fits.
    unfold ticks_check in H. cbv zeta in H. cbn [final multiplier divisor seconds counted] in H. rewrite !andb_true_iff in H. destruct H as [[[[M0 D0] _] _] _].
    apply Z.eqb_eq in H1. apply Z.ltb_lt in M0, D0. apply Z.leb_le in H3, H4, H5, H6, H7, H8.
    destruct all_checked as [D N0 Ks Is Rv Lv Gm Lm Cm Gs Rs Ls Ts Ws Ss Tm Tr]. destruct table_fits as [Fit Len].
    assert (K0 : (0 < Z.of_nat K)%Z) by (destruct (regular_ok _ _ Tr); unfold K, segments; lia).
    assert (Sm : ticks_small c) by (unfold ticks_small; rewrite H1; lia).
    destruct (tick_range c tick Sm (proj1 T0)) as (_ & Sr & Rr). rewrite H1 in Sr.
    apply is_number_ok with (prec_gt_0_ := pos_) (prec_lt_emax_ := below_) in H2. destruct H2 as [S1 S2]. rewrite Q2R_Z in S1.
    assert (Dp := IZR_lt _ _ D0). assert (R1 := IZR_le _ _ (proj1 Rr)). assert (R2 := IZR_le _ _ (proj2 Rr)).
    destruct (of_int_ok prec emax _ _ prec_large emax_large (tick_rest c tick) ltac:(lia)) as [I1 I2].
    assert (X : 0 <= IZR (tick_rest c tick) / IZR (tick_divisor c) <= 1) by (split; [apply Rcomplements.Rle_div_r; lra|apply Rcomplements.Rle_div_l; lra]).
    assert (Part : value (share_of_tick A c tick) = to_format f (IZR (tick_rest c tick) / IZR (tick_divisor c)) /\ sized prec emax 0 (share_of_tick A c tick)).
    { unfold share_of_tick. change (Run.div A) with (@Bdiv prec emax pos_ below_ mode_NE). change (of_integer A (tick_rest c tick)) with (of_int prec emax pos_ below_ (tick_rest c tick)).
      change (literal A (tick_share c)) with (lit (tick_share c)).
      assert (Small : Rabs (value (of_int prec emax pos_ below_ (tick_rest c tick)) / value (lit (tick_share c))) <= bpow radix2 0) by (rewrite I1, S1; cbn [bpow]; apply Rabs_le; lra).
      destruct (div_ok prec emax _ _ prec_large emax_large (of_int prec emax pos_ below_ (tick_rest c tick)) (lit (tick_share c)) I2) as [Q1 Q2];
        [rewrite S1; lra|apply (within_most emax emax_large 0); [lia|exact Small]|].
      split; [rewrite Q1, I1, S1; apply rnd_format_of|]. split; [exact Q2|]. rewrite Q1. apply (rnd_sized prec emax _ _ prec_large emax_large); [lia|exact Small]. }
    destruct Part as [P1 P2].
    assert (Pl : place_of_tick f rows (tick_limit c) (tick_multiplier c) (tick_divisor c) tick = (Z.to_nat (tick_segment c tick), value (share_of_tick A c tick))).
    { rewrite P1. unfold place_of_tick, ticked, tick_rest, tick_segment, tick_place. cbv zeta. rewrite H1. reflexivity. }
    rewrite Pl in *. apply (placed_acts _ _ (IZR tick * Q2R period) Sr P2 Fits).
    apply (control_tick_executes A k coefficients (tick_segment c tick) (Z.of_nat K) _ xs lines Sr Fit Len Gm Cm Lm c tick Tk Sm H1 T0 eq_refl eq_refl).
    apply inputs_finite, literal_zero_ok.
  Qed.
End Controller.
