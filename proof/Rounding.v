(* Rounding errors of straight-line code (P7): every assignment rounds once, and a forward analysis in rationals bounds the error of each
   result. It is proved for any rounding with a relative and an absolute error, and used for IEEE single and double precision as Flocq
   defines them.

   Emitted.v applies it to the emitted kernels `basis` and `edge_at`, and Edge.v to the machine's own operations. docs/certificate-
   format.md derives the same bound (P7: `edge_error`). *)
From Coq Require Import ZArith QArith Qreals Qminmax Qabs Qround Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core Relative.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed.
Import ListNotations.
Open Scope R_scope.

(* ------------------------------------------------------------------ code: one operation a statement, each value assigned once *)

(* An operand: `V i` is value number i, `C c` the integer c. In a theorem file the kernels of the C are written so. *)
Inductive operand := V (i : nat) | C (c : Z).
Inductive operation := Add | Sub | Mul.
(* One assignment; its result gets the next number. *)
Record assignment := Assignment { operation_of : operation; left_operand : operand; right_operand : operand }.

(* The value of an operand, where `values` has all values so far. *)
Definition operand_value (values : list R) (o : operand) : R := match o with V i => nth i values 0 | C c => IZR c end.
Definition apply_operation (o : operation) (a b : R) : R := match o with Add => a + b | Sub => a - b | Mul => a * b end.
(* All values after the code, where every result is rounded. *)
Fixpoint run_assignments (rnd : R -> R) (code : list assignment) (values : list R) : list R :=
  match code with [] => values | s :: rest => run_assignments rnd rest (values ++ [rnd (apply_operation (operation_of s) (operand_value values (left_operand s)) (operand_value values (right_operand s)))]) end.

(* ------------------------------------------------------------------ forward analysis in rationals *)

(* What the analysis knows of a value: without rounding it is between low and high, and rounding moves it by at most `error`. *)
Record enclosure := Enclosure { low : Q; high : Q; error : Q }.
(* The largest absolute value between low and high. *)
Definition largest_magnitude (a : enclosure) : Q := Qmax (Qabs (low a)) (Qabs (high a)).

(* q rounded up to a multiple of 2^-120: so fractions stay short where errors of errors add up. *)
Definition rounded_up_to_grid (q : Q) : Q := Qceiling (q * inject_Z (2 ^ 120)) # (2 ^ 120).
Lemma rounded_up_to_grid_bounds q : Q2R q <= Q2R (rounded_up_to_grid q).
Proof.
  assert (C := Qle_ceiling (q * inject_Z (2 ^ 120))). apply Qle_Rle in C. rewrite Q2R_mult in C.
  assert (P : 0 < IZR (2 ^ 120)) by now apply IZR_lt. assert (Z2 : Q2R (inject_Z (2 ^ 120)) = IZR (2 ^ 120)) by (unfold Q2R, inject_Z; cbn [Qnum Qden]; field). rewrite Z2 in C.
  unfold rounded_up_to_grid. unfold Q2R at 2. cbn [Qnum Qden]. change (IZR (Zpos (2 ^ 120))) with (IZR (2 ^ 120)).
  apply (Rmult_le_reg_r (IZR (2 ^ 120))); [exact P|]. rewrite Rmult_assoc, Rinv_l, Rmult_1_r by lra. eapply Rle_trans; [exact C|].
  right. unfold Q2R, inject_Z; cbn [Qnum Qden]. field.
Qed.

(* The analysis, for a rounding that loses at most |x| relative_error + absolute_error. *)
Section Analysis.
  Variables relative_error absolute_error : Q.
  (* What is known of a result that is between low_end and high_end without rounding, and has an error of at most error_before before it
     is rounded. *)
  Definition enclosure_after_rounding (low_end high_end error_before : Q) : enclosure :=
    let low_end := Qred low_end in let high_end := Qred high_end in
    Enclosure low_end high_end (rounded_up_to_grid (error_before + (Qmax (Qabs low_end) (Qabs high_end) + error_before) * relative_error + absolute_error)).
  (* What is known of an operand. *)
  Definition operand_enclosure (enclosures : list enclosure) (o : operand) : option enclosure :=
    match o with V i => nth_error enclosures i | C c => Some (Enclosure (inject_Z c) (inject_Z c) 0) end.
  (* What is known of the result of an operation. *)
  Definition operation_enclosure (o : operation) (a b : enclosure) : enclosure :=
    match o with
    | Add => enclosure_after_rounding (low a + low b) (high a + high b) (error a + error b)
    | Sub => enclosure_after_rounding (low a - high b) (high a - low b) (error a + error b)
    | Mul => enclosure_after_rounding (Qmin (Qmin (low a * low b) (low a * high b)) (Qmin (high a * low b) (high a * high b)))
                     (Qmax (Qmax (low a * low b) (low a * high b)) (Qmax (high a * low b) (high a * high b)))
                     (largest_magnitude a * error b + largest_magnitude b * error a + error a * error b)
    end%Q.
  (* What is known of all values after the code; None if an operand has no value yet. *)
  Fixpoint analyse_assignments (code : list assignment) (enclosures : list enclosure) : option (list enclosure) :=
    match code with
    | [] => Some enclosures
    | s :: rest => match operand_enclosure enclosures (left_operand s), operand_enclosure enclosures (right_operand s) with
                   | Some a, Some b => analyse_assignments rest (enclosures ++ [operation_enclosure (operation_of s) a b])
                   | _, _ => None
                   end
    end.

  (* The enclosure is right about a value, exact and with rounding. *)
  Definition encloses (k : enclosure) (exact float : R) : Prop :=
    Q2R (low k) <= exact <= Q2R (high k) /\ Rabs (float - exact) <= Q2R (error k).

  Lemma Q2R_max a b : Q2R (Qmax a b) = Rmax (Q2R a) (Q2R b).
  Proof.
    destruct (Q.max_spec a b) as [[H E]|[H E]]; rewrite (Qeq_eqR _ _ E); symmetry.
    - apply Rmax_right. left; now apply Qlt_Rlt.
    - apply Rmax_left. now apply Qle_Rle.
  Qed.
  Lemma Q2R_min a b : Q2R (Qmin a b) = Rmin (Q2R a) (Q2R b).
  Proof.
    destruct (Q.min_spec a b) as [[H E]|[H E]]; rewrite (Qeq_eqR _ _ E); symmetry.
    - apply Rmin_left. left; now apply Qlt_Rlt.
    - apply Rmin_right. now apply Qle_Rle.
  Qed.
  Lemma Q2R_abs a : Q2R (Qabs a) = Rabs (Q2R a).
  Proof.
    assert (Z0 : Q2R 0 = 0) by (unfold Q2R; cbn; lra).
    apply Qabs_case; intro H; apply Qle_Rle in H; rewrite Z0 in H.
    - now rewrite Rabs_pos_eq.
    - rewrite Q2R_opp. rewrite Rabs_left1; lra.
  Qed.
  Lemma Q2R_red a : Q2R (Qred a) = Q2R a. Proof. apply Qeq_eqR, Qred_correct. Qed.

  Variable rounding : R -> R.
  Hypothesis rounding_error_bound : forall x, Rabs (rounding x - x) <= Rabs x * Q2R relative_error + Q2R absolute_error.
  Hypothesis relative_error_nonneg : 0 <= Q2R relative_error.

  Lemma Rabs_between_ends l h x : l <= x <= h -> Rabs x <= Rmax (Rabs l) (Rabs h).
  Proof. intro H. apply RmaxAbs; lra. Qed.

  Lemma enclosure_after_rounding_sound l h e exact value : Q2R l <= exact <= Q2R h -> Rabs (value - exact) <= Q2R e ->
    encloses (enclosure_after_rounding l h e) exact (rounding value).
  Proof.
    intros H E. unfold encloses, enclosure_after_rounding; cbn [low high error]. rewrite !Q2R_red. split; [exact H|].
    eapply Rle_trans; [|apply rounded_up_to_grid_bounds]. rewrite !Q2R_plus, Q2R_mult, Q2R_plus, Q2R_max, !Q2R_abs, !Q2R_red.
    replace (rounding value - exact) with ((rounding value - value) + (value - exact)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. pose proof (rounding_error_bound value).
    assert (Rabs value <= Rmax (Rabs (Q2R l)) (Rabs (Q2R h)) + Q2R e).
    { replace value with (exact + (value - exact)) by ring. eapply Rle_trans; [apply Rabs_triang|].
      apply Rplus_le_compat; [now apply Rabs_between_ends|exact E]. }
    assert (Rabs value * Q2R relative_error <= (Rmax (Rabs (Q2R l)) (Rabs (Q2R h)) + Q2R e) * Q2R relative_error) by (apply Rmult_le_compat_r; lra).
    lra.
  Qed.

  Lemma product_range a b c d x y : a <= x <= b -> c <= y <= d ->
    Rmin (Rmin (a * c) (a * d)) (Rmin (b * c) (b * d)) <= x * y <= Rmax (Rmax (a * c) (a * d)) (Rmax (b * c) (b * d)).
  Proof.
    intros Hx Hy.
    assert (H1 : Rmin (a * y) (b * y) <= x * y <= Rmax (a * y) (b * y)).
    { unfold Rmin, Rmax. destruct (Rle_dec 0 y); repeat destruct Rle_dec; nra. }
    assert (H2 : forall z, Rmin (z * c) (z * d) <= z * y <= Rmax (z * c) (z * d)).
    { intro z. unfold Rmin, Rmax. destruct (Rle_dec 0 z); repeat destruct Rle_dec; nra. }
    pose proof (H2 a) as A. pose proof (H2 b) as B. revert H1 A B.
    generalize (a * y) (b * y) (x * y) (a * c) (a * d) (b * c) (b * d). intros.
    unfold Rmin, Rmax in *. repeat destruct Rle_dec; lra.
  Qed.

  Lemma operation_enclosure_sound o a b x y fx fy : encloses a x fx -> encloses b y fy -> encloses (operation_enclosure o a b) (apply_operation o x y) (rounding (apply_operation o fx fy)).
  Proof.
    intros [Ra Ea] [Rb Eb]. destruct o; cbn [operation_enclosure apply_operation]; apply enclosure_after_rounding_sound; rewrite ?Q2R_plus, ?Q2R_minus; try lra.
    - replace (fx + fy - (x + y)) with ((fx - x) + (fy - y)) by ring. eapply Rle_trans; [apply Rabs_triang|]; lra.
    - replace (fx - fy - (x - y)) with ((fx - x) + - (fy - y)) by ring. eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp; lra.
    - rewrite !Q2R_min, !Q2R_max, !Q2R_mult. now apply product_range.
    - rewrite !Q2R_mult. unfold largest_magnitude. rewrite !Q2R_max, !Q2R_abs.
      replace (fx * fy - x * y) with (x * (fy - y) + y * (fx - x) + (fx - x) * (fy - y)) by ring.
      eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat.
      + eapply Rle_trans; [apply Rabs_triang|]. rewrite !Rabs_mult.
        apply Rplus_le_compat; apply Rmult_le_compat; try apply Rabs_pos; auto; now apply Rabs_between_ends.
      + rewrite Rabs_mult. apply Rmult_le_compat; auto; apply Rabs_pos.
  Qed.

  (* Every enclosure is right about its value. *)
  Inductive all_enclosed : list enclosure -> list R -> list R -> Prop :=
  | all_enclosed_nil : all_enclosed [] [] []
  | all_enclosed_cons k x f ks xs fs : encloses k x f -> all_enclosed ks xs fs -> all_enclosed (k :: ks) (x :: xs) (f :: fs).

  Lemma all_enclosed_app ks xs fs k x f : all_enclosed ks xs fs -> encloses k x f -> all_enclosed (ks ++ [k]) (xs ++ [x]) (fs ++ [f]).
  Proof. induction 1; intro M; cbn; [constructor; [exact M|constructor]|constructor; auto]. Qed.
  Lemma all_enclosed_nth ks xs fs i k : all_enclosed ks xs fs -> nth_error ks i = Some k -> encloses k (nth i xs 0) (nth i fs 0).
  Proof. intro H; revert i; induction H; intros [|i] E; cbn in *; try easy; [now injection E as <-|auto]. Qed.
  Lemma operand_enclosure_sound ks xs fs o k : all_enclosed ks xs fs -> operand_enclosure ks o = Some k -> encloses k (operand_value xs o) (operand_value fs o).
  Proof.
    destruct o; cbn; intros H E; [eapply all_enclosed_nth; eauto|]. injection E as <-. unfold encloses; cbn [low high error].
    rewrite Q2R_Z, Rminus_diag_eq, Rabs_R0 by reflexivity. replace (Q2R 0) with 0 by (unfold Q2R; cbn; lra). lra.
  Qed.

  (* What the analysis says is right. *)
  Theorem analyse_assignments_sound code : forall ks xs fs out, analyse_assignments code ks = Some out -> all_enclosed ks xs fs ->
    all_enclosed out (run_assignments (fun x => x) code xs) (run_assignments rounding code fs).
  Proof.
    induction code as [|[o l r] rest IH]; cbn [analyse_assignments run_assignments]; intros ks xs fs out E H; [now injection E as <-|].
    destruct (operand_enclosure ks _) as [a|] eqn:A; [|easy]. destruct (operand_enclosure ks (right_operand _)) as [b|] eqn:B; [|easy].
    apply (IH _ _ _ _ E). apply all_enclosed_app; [exact H|]. cbn [operation_of left_operand right_operand] in *.
    apply operation_enclosure_sound; eapply operand_enclosure_sound; eauto.
  Qed.
End Analysis.

(* ------------------------------------------------------------------ IEEE single and double precision, rounding to nearest even *)

(* Single or double precision. There is no overflow in these formats; Semantics.v and Edge.v prove that none occurs. *)
Inductive format := Single | Double.
Definition precision (f : format) : Z := match f with Single => 24 | Double => 53 end.
Definition minimum_exponent (f : format) : Z := match f with Single => -149 | Double => -1074 end.
Definition format_exponent (f : format) : Z -> Z := FLT_exp (minimum_exponent f) (precision f).
(* A real number rounded to the nearest number of the format, ties to even. *)
Definition round_to_format (f : format) : R -> R := round radix2 (format_exponent f) ZnearestE.

(* The relative error of a rounding, and its absolute error: half of the smallest subnormal number. *)
Definition half_ulp (f : format) : Q := match f with Single => 1 # 2 ^ 24 | Double => 1 # 2 ^ 53 end.
Definition half_smallest (f : format) : Q := match f with Single => 1 # 2 ^ 150 | Double => 1 # 2 ^ 1075 end.

Global Instance format_exponent_valid f : Valid_exp (format_exponent f).
Proof. destruct f; now apply FLT_exp_valid. Qed.

Lemma Q2R_unit_fraction p : Q2R (1 # p) = / IZR (Z.pos p). Proof. unfold Q2R; cbn [Qnum Qden]; lra. Qed.
Lemma inverse_power_of_two p : / IZR (Z.pos (2 ^ p)) = bpow radix2 (- Z.pos p).
Proof. rewrite bpow_opp. f_equal. rewrite Pos2Z.inj_pow. now apply (IZR_Zpower radix2 (Z.pos p)). Qed.
Lemma half_ulp_value f : Q2R (half_ulp f) = bpow radix2 (- precision f).
Proof. destruct f; unfold half_ulp; rewrite Q2R_unit_fraction; apply inverse_power_of_two. Qed.
Lemma half_smallest_value f : Q2R (half_smallest f) = bpow radix2 (minimum_exponent f - 1).
Proof. destruct f; unfold half_smallest; rewrite Q2R_unit_fraction; apply inverse_power_of_two. Qed.
Lemma half_ulp_range f : 0 <= Q2R (half_ulp f) <= 1.
Proof.
  rewrite half_ulp_value. split; [apply bpow_ge_0|]. apply (bpow_le radix2 _ 0). destruct f; cbn; lia.
Qed.
Lemma half_smallest_nonneg f : 0 <= Q2R (half_smallest f).
Proof. rewrite half_smallest_value. apply bpow_ge_0. Qed.

Lemma round_to_format_error f x : Rabs (round_to_format f x - x) <= Rabs x * Q2R (half_ulp f) + Q2R (half_smallest f).
Proof.
  assert (P : (0 < precision f)%Z) by (destruct f; reflexivity).
  destruct (error_N_FLT radix2 (minimum_exponent f) (precision f) P (fun x => negb (Z.even x)) x) as (e & t & He & Ht & _ & E).
  unfold round_to_format, format_exponent. rewrite E. replace (x * (1 + e) + t - x) with (x * e + t) by ring.
  eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_mult. apply Rplus_le_compat.
  - apply Rmult_le_compat_l; [apply Rabs_pos|]. apply Rle_trans with (1 := He). right. rewrite half_ulp_value.
    change (/ 2) with (bpow radix2 (- (1))). rewrite <- bpow_plus. f_equal; ring.
  - apply Rle_trans with (1 := Ht). right. rewrite half_smallest_value.
    change (/ 2) with (bpow radix2 (- (1))). rewrite <- bpow_plus. f_equal; ring.
Qed.

(* Subtracting its floor from a number of the format is exact. *)
Lemma fractional_part_exact f u k : generic_format radix2 (format_exponent f) u -> IZR k <= u < IZR k + 1 -> (0 <= k)%Z -> round_to_format f (u - IZR k) = u - IZR k.
Proof.
  intros G H K0. unfold round_to_format. apply round_generic; [apply valid_rnd_N|].
  apply FLT_format_generic in G; [|destruct f; reflexivity]. destruct G as [[m e] E M X]; cbn [Fnum Fexp] in *.
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
  - replace (u - IZR k) with 0; [apply generic_format_0|].
    assert (U : u = IZR (m * 2 ^ e)) by (rewrite mult_IZR; change 2%Z with (radix_val radix2); rewrite IZR_Zpower by lia; exact E).
    rewrite U in *. destruct H as [A B]. apply le_IZR in A. rewrite <- plus_IZR in B. apply lt_IZR in B.
    rewrite <- minus_IZR. replace (m * 2 ^ e - k)%Z with 0%Z by lia. reflexivity.
Qed.

(* ------------------------------------------------------------------ the emitted kernels `basis` and `edge_at` *)
(* The emitted kernels `basis` and `edge_at`, one assignment a line. Value 0 is s, values 1 to 4 are the coefficients q0 to q3. Values 5 to
   16 are v0 to v11 of `basis`, 17 to 23 are v0 to v6 of `edge_at`; the last one is the edge. *)
Definition basis_edge : list assignment := [
  Assignment Sub (C 1) (V 0);   (* 5  v0 *)
  Assignment Mul (V 5) (V 5);   (* 6  v1 *)
  Assignment Mul (V 6) (V 5);   (* 7  v2 = w0 *)
  Assignment Mul (V 5) (V 0);   (* 8  v3 *)
  Assignment Add (C 1) (V 8);   (* 9  v4 *)
  Assignment Mul (C 3) (V 9);   (* 10 v5 *)
  Assignment Mul (V 5) (V 10);  (* 11 v6 *)
  Assignment Add (C 1) (V 11);  (* 12 v7 = w1 *)
  Assignment Mul (V 0) (V 10);  (* 13 v8 *)
  Assignment Add (C 1) (V 13);  (* 14 v9 = w2 *)
  Assignment Mul (V 0) (V 0);   (* 15 v10 *)
  Assignment Mul (V 15) (V 0);  (* 16 v11 = w3 *)
  Assignment Mul (V 7) (V 1);   (* 17 *)
  Assignment Mul (V 12) (V 2);  (* 18 *)
  Assignment Add (V 17) (V 18); (* 19 *)
  Assignment Mul (V 14) (V 3);  (* 20 *)
  Assignment Mul (V 16) (V 4);  (* 21 *)
  Assignment Add (V 20) (V 21); (* 22 *)
  Assignment Add (V 19) (V 22)  (* 23 *)
].

(* A bound on the error of an edge at s in [0, 1], where no coefficient is larger than `largest`. *)
Definition spline_evaluation_error (f : format) (largest : Q) : option Q :=
  match analyse_assignments (half_ulp f) (half_smallest f) basis_edge
          [Enclosure 0 1 0; Enclosure (- largest) largest 0; Enclosure (- largest) largest 0; Enclosure (- largest) largest 0; Enclosure (- largest) largest 0] with
  | Some out => option_map error (nth_error out 23)
  | None => None
  end.

(* The emitted kernels evaluate the cubic blend within that bound. *)
Theorem spline_evaluation_near f largest e s a b c d : spline_evaluation_error f largest = Some e -> 0 <= s <= 1 ->
  Rabs a <= Q2R largest -> Rabs b <= Q2R largest -> Rabs c <= Q2R largest -> Rabs d <= Q2R largest ->
  Rabs (nth 23 (run_assignments (round_to_format f) basis_edge [s; a; b; c; d]) 0 -
    (a * (1 - s)^3 + b * (3*s^3 - 6*s^2 + 4) + c * (- 3*s^3 + 3*s^2 + 3*s + 1) + d * s^3)) <= Q2R e.
Proof.
  intros E Hs Ha Hb Hc Hd. unfold spline_evaluation_error in E.
  destruct (analyse_assignments _ _ _ _) as [out|] eqn:A; [|easy].
  assert (Z0 : Q2R 0 = 0) by (unfold Q2R; cbn; lra). assert (Z1 : Q2R 1 = 1) by (unfold Q2R; cbn; lra).
  assert (M : forall x, Rabs x <= Q2R largest -> encloses (Enclosure (- largest) largest 0) x x).
  { intros x Hx; unfold encloses; cbn [low high error]. rewrite Q2R_opp, Z0, Rminus_diag_eq, Rabs_R0 by reflexivity.
    apply Rabs_le_between in Hx; lra. }
  assert (S := analyse_assignments_sound (half_ulp f) (half_smallest f) (round_to_format f) (round_to_format_error f) ltac:(apply half_ulp_range) _ _ [s; a; b; c; d] [s; a; b; c; d] _ A).
  destruct (nth_error out 23) as [k|] eqn:N; [|easy]. cbn in E. injection E as <-.
  assert (H3 : all_enclosed [Enclosure 0 1 0; Enclosure (- largest) largest 0; Enclosure (- largest) largest 0; Enclosure (- largest) largest 0;
                     Enclosure (- largest) largest 0] [s; a; b; c; d] [s; a; b; c; d]).
  { apply all_enclosed_cons; [|apply all_enclosed_cons; [now apply M|apply all_enclosed_cons; [now apply M|apply all_enclosed_cons; [now apply M|apply all_enclosed_cons; [now apply M|apply all_enclosed_nil]]]]].
    unfold encloses; cbn [low high error]. rewrite Z0, Z1, Rminus_diag_eq, Rabs_R0 by reflexivity. lra. }
  destruct (all_enclosed_nth _ _ _ 23 k (S H3) N) as [_ Q].
  replace (a * (1 - s)^3 + b * (3*s^3 - 6*s^2 + 4) + c * (- 3*s^3 + 3*s^2 + 3*s + 1) + d * s^3)
    with (nth 23 (run_assignments (fun x => x) basis_edge [s; a; b; c; d]) 0); [exact Q|].
  cbv [run_assignments basis_edge app nth operand_value apply_operation operation_of left_operand right_operand]; ring.
Qed.

