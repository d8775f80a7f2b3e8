(* The machine's arithmetic: IEEE 754 floats of Flocq, rounded to the nearest, ties to even, for any precision and exponent range of at
   least those of single precision. Infinity and NaN are values of the type; that none occurs is proved from ranges.

   Edge.v, Law.v and Logarithm.v compute with it, Controller.v uses it for single and double precision. docs/theorem.md says what is
   assumed of compiler and hardware. *)
From Coq Require Import ZArith QArith Qreals Reals Lia Lra List Bool SpecFloat.
From Flocq Require Import Core Relative IEEE754.BinarySingleNaN.
From Flocq Require Plus_error.
From Stt Require Import Syntax Run.
Open Scope R_scope.

(* A format with prec bits of significand and exponents below emax. *)
Section Semantics.
  Variables prec emax : Z.
  Context (prec_gt_0_ : Prec_gt_0 prec).
  Context (prec_lt_emax_ : Prec_lt_emax prec emax).
  Hypothesis prec_large : (24 <= prec)%Z.
  Hypothesis emax_large : (128 <= emax)%Z.
  Notation number := (binary_float prec emax).
  Notation format_exponent := (FLT_exp (3 - emax - prec) prec).

  (* A real number rounded to the format, and the relative error of a rounding. *)
  Definition round_nearest : R -> R := round radix2 format_exponent ZnearestE.
  Definition unit_roundoff : R := bpow radix2 (- prec).

  Global Instance format_exponent_valid : Valid_exp format_exponent. Proof. now apply FLT_exp_valid. Qed.

  (* ---------------------------------------------------------------- literals *)

  (* A literal as a fraction, numerator over denominator. *)
  Definition numerator (d : decimal) : positive := (Z.to_pos (digits d) * Z.to_pos (10 ^ Z.max 0 (decimal_exponent d)))%positive.
  Definition denominator (d : decimal) : positive := Z.to_pos (10 ^ Z.max 0 (- decimal_exponent d)).
  Definition decimal_value (d : decimal) : Q := if (digits d =? 0)%Z then 0%Q else (cond_Zopp (is_negative d) (Zpos (numerator d)) # denominator d)%Q.

  (* A literal rounded to the format. *)
  Definition decimal_float (d : decimal) : spec_float :=
    if (digits d =? 0)%Z then S754_zero (is_negative d)
    else let '(m, e, l) := SFdiv_core_binary prec emax (Zpos (numerator d)) 0 (Zpos (denominator d)) 0 in
         binary_round_aux prec emax mode_NE (xorb (is_negative d) false) m e l.

  Lemma decimal_float_valid d : valid_binary prec emax (decimal_float d) = true.
  Proof.
    unfold decimal_float. destruct (digits d =? 0)%Z; [reflexivity|].
    exact (proj1 (Bdiv_correct_aux prec emax _ _ mode_NE (is_negative d) (numerator d) 0 false (denominator d) 0)).
  Qed.
  Definition decimal_number (d : decimal) : number := SF2B (decimal_float d) (decimal_float_valid d).

  (* A literal is its decimal value, rounded. *)
  Lemma decimal_number_rounds d : Rabs (round_nearest (Q2R (decimal_value d))) < bpow radix2 emax ->
    B2R (decimal_number d) = round_nearest (Q2R (decimal_value d)) /\ is_finite (decimal_number d) = true.
  Proof.
    unfold decimal_number. rewrite B2R_SF2B, is_finite_SF2B. unfold decimal_float, decimal_value.
    destruct (digits d =? 0)%Z.
    - intros _. cbn. split; [|reflexivity]. unfold Q2R; cbn. rewrite Rmult_0_l. unfold round_nearest. now rewrite round_0 by apply valid_rnd_N.
    - assert (H := Bdiv_correct_aux prec emax _ _ mode_NE (is_negative d) (numerator d) 0 false (denominator d) 0). cbv zeta in H.
      destruct H as [_ H]. intro B.
      assert (E : F2R (Float radix2 (cond_Zopp (is_negative d) (Zpos (numerator d))) 0) / F2R (Float radix2 (cond_Zopp false (Zpos (denominator d))) 0) =
        Q2R (cond_Zopp (is_negative d) (Zpos (numerator d)) # denominator d)).
      { unfold F2R, Q2R; cbn [Fnum Fexp cond_Zopp Qnum Qden bpow]. unfold Rdiv. rewrite !Rmult_1_r. reflexivity. }
      rewrite E in H. rewrite Rlt_bool_true in H by exact B. destruct H as (H1 & H2 & _). split; [exact H1|exact H2].
  Qed.

  (* The value of a float as a rational, which Coq computes. *)
  Definition spec_float_value (x : spec_float) : Q :=
    match x with
    | S754_finite s m e => if (0 <=? e)%Z then inject_Z (cond_Zopp s (Zpos m) * 2 ^ e) else (cond_Zopp s (Zpos m) # Z.to_pos (2 ^ (- e)))%Q
    | _ => 0%Q
    end.
  Lemma spec_float_value_real x : Q2R (spec_float_value x) = SF2R radix2 x.
  Proof.
    destruct x as [s|s| |s m e]; cbn [spec_float_value SF2R]; try (unfold Q2R; cbn; lra).
    unfold F2R; cbn [Fnum Fexp]. destruct (Z.leb_spec 0 e).
    - unfold Q2R, inject_Z; cbn [Qnum Qden]. rewrite mult_IZR. change 2%Z with (radix_val radix2). rewrite IZR_Zpower by assumption. lra.
    - unfold Q2R; cbn [Qnum Qden]. f_equal. assert (0 < 2 ^ (- e))%Z by (apply Z.pow_pos_nonneg; lia).
      rewrite Z2Pos.id by assumption. change 2%Z with (radix_val radix2). rewrite IZR_Zpower by lia. rewrite <- bpow_opp. f_equal; lia.
  Qed.
  (* A literal is exactly the number v. *)
  Definition literal_equals (d : decimal) (v : Q) : bool :=
    match decimal_float d with S754_finite _ _ _ | S754_zero _ => Qeq_bool (spec_float_value (decimal_float d)) v | _ => false end.
  Lemma literal_equals_value d v : literal_equals d v = true -> B2R (decimal_number d) = Q2R v /\ is_finite (decimal_number d) = true.
  Proof.
    unfold literal_equals, decimal_number. rewrite B2R_SF2B, is_finite_SF2B.
    intro H. assert (Q : Qeq_bool (spec_float_value (decimal_float d)) v = true /\ is_finite_SF (decimal_float d) = true) by (destruct (decimal_float d); try easy; now split).
    destruct Q as [Q Fi]. split; [|exact Fi]. rewrite <- spec_float_value_real. now apply Qeq_eqR, Qeq_bool_iff.
  Qed.

  (* ---------------------------------------------------------------- bits *)

  (* A number in memory, as an unsigned integer in IEEE 754's interchange format. From the lowest bit: the fraction, the biased exponent,
     the sign. There is one NaN, the quiet one. exponent_step is 1 in the exponent's field, bit_pattern_count the number of patterns. *)
  Definition minimum_exponent : Z := 3 - emax - prec.
  Definition exponent_step : Z := 2 ^ (prec - 1).
  Definition bit_pattern_count : Z := 4 * emax * exponent_step.
  Definition bits (y : number) : Z :=
    let signed (s : bool) (z : Z) := (if s then z + bit_pattern_count / 2 else z)%Z in
    match y with
    | B754_zero s => signed s 0%Z
    | B754_infinity s => signed s ((2 * emax - 1) * exponent_step)%Z
    | B754_nan => ((2 * emax - 1) * exponent_step + exponent_step / 2)%Z
    | B754_finite s m e _ => signed s (if (Zpos m <? exponent_step)%Z then Zpos m else (e - minimum_exponent + 1) * exponent_step + (Zpos m - exponent_step))%Z
    end.
  Definition of_bits (z : Z) : number :=
    let s := (bit_pattern_count / 2 <=? z)%Z in
    let field := (z mod (bit_pattern_count / 2) / exponent_step)%Z in
    let fraction := (z mod exponent_step)%Z in
    if (field =? 2 * emax - 1)%Z then (if (fraction =? 0)%Z then B754_infinity s else B754_nan)
    else if (field =? 0)%Z then binary_normalize prec emax _ _ mode_NE (cond_Zopp s fraction) minimum_exponent s
    else binary_normalize prec emax _ _ mode_NE (cond_Zopp s (fraction + exponent_step)) (field - 1 + minimum_exponent) s.

  (* y = m 2^e with m from about 1/sqrt 2 to about sqrt 2, as the C computes it in unsigned arithmetic. mantissa_cut is the bit pattern
     of the smallest m. *)
  Definition mantissa_cut : Z := if (prec =? 24)%Z then 0x3f3504f3 else 0x3fe6a09e667f3bcd.
  Definition exponent_by_bits (y : number) : Z := Z.shiftr ((bits y - mantissa_cut) mod bit_pattern_count) (prec - 1).
  Definition mantissa_by_bits (y : number) : number := of_bits ((Z.land ((bits y - mantissa_cut) mod bit_pattern_count) (Z.ones (prec - 1)) + mantissa_cut) mod bit_pattern_count).

  (* The exponent by bits is below 512 in single precision and below 4096 in double, so it fits an int32_t. No proof uses this: it is for
     readers. *)
  Lemma exponent_range y : (0 <= exponent_by_bits y < 4 * emax)%Z.
  Proof.
    assert (S0 : (0 < exponent_step)%Z) by (apply Z.pow_pos_nonneg; lia). assert (W : (0 < bit_pattern_count)%Z) by (unfold bit_pattern_count; nia).
    assert (M := Z.mod_pos_bound (bits y - mantissa_cut) bit_pattern_count W). unfold exponent_by_bits. rewrite Z.shiftr_div_pow2 by lia. fold exponent_step.
    split; [apply Z.div_pos; lia|apply Z.div_lt_upper_bound; [exact S0|]]. unfold bit_pattern_count in *. lia.
  Qed.

  (* ---------------------------------------------------------------- the machine *)

  (* An integer as a float. *)
  Definition of_int (z : Z) : number := binary_normalize prec emax _ _ mode_NE z 0 false.
  (* The machine's arithmetic; log_ is its library's logarithm. *)
  Definition machine (log_ : number -> number) : arithmetic :=
    Arithmetic number (Bplus mode_NE) (Bminus mode_NE) (Bmult mode_NE) (Bdiv mode_NE) Bopp Bltb Bleb is_finite B754_nan decimal_number of_int
      (fun x => if is_finite x then Some (Btrunc x) else None) log_ exponent_by_bits mantissa_by_bits.

  (* Half of the range: results up to it do not overflow. *)
  Definition safe_maximum : R := bpow radix2 (emax - 1).

  Lemma round_nearest_le x y : x <= y -> round_nearest x <= round_nearest y.
  Proof. intro H. unfold round_nearest. apply round_le; [apply format_exponent_valid|apply valid_rnd_N|exact H]. Qed.
  Lemma round_nearest_0 : round_nearest 0 = 0. Proof. unfold round_nearest. now rewrite round_0 by apply valid_rnd_N. Qed.
  Lemma round_nearest_opp x : round_nearest (- x) = - round_nearest x. Proof. unfold round_nearest. apply round_NE_opp. Qed.
  Lemma round_nearest_of_format x : generic_format radix2 format_exponent x -> round_nearest x = x.
  Proof. intro H. unfold round_nearest. apply round_generic; [apply valid_rnd_N|exact H]. Qed.
  Lemma number_format (x : number) : generic_format radix2 format_exponent (B2R x).
  Proof. apply generic_format_B2R. Qed.

  Lemma no_overflow x : Rabs x <= safe_maximum -> Rlt_bool (Rabs (round_nearest x)) (bpow radix2 emax) = true.
  Proof.
    intro H. apply Rlt_bool_true. apply Rle_lt_trans with safe_maximum; [|unfold safe_maximum; apply bpow_lt; lia].
    unfold round_nearest. apply abs_round_le_generic; [apply format_exponent_valid|apply valid_rnd_N| |exact H].
    unfold safe_maximum. apply generic_format_bpow. unfold FLT_exp. assert (P := prec_gt_0_). assert (P2 := prec_lt_emax_). unfold Prec_gt_0, Prec_lt_emax in *. lia.
  Qed.

  Lemma add_rounds (x y : number) : is_finite x = true -> is_finite y = true -> Rabs (B2R x + B2R y) <= safe_maximum ->
    B2R (Bplus mode_NE x y) = round_nearest (B2R x + B2R y) /\ is_finite (Bplus mode_NE x y) = true.
  Proof. intros X Y H. assert (C := Bplus_correct prec emax _ _ mode_NE x y X Y). cbn [round_mode] in C. fold round_nearest in C. fold (round_nearest (B2R x + B2R y)) in C. rewrite no_overflow in C by exact H. tauto. Qed.
  Lemma sub_rounds (x y : number) : is_finite x = true -> is_finite y = true -> Rabs (B2R x - B2R y) <= safe_maximum ->
    B2R (Bminus mode_NE x y) = round_nearest (B2R x - B2R y) /\ is_finite (Bminus mode_NE x y) = true.
  Proof. intros X Y H. assert (C := Bminus_correct prec emax _ _ mode_NE x y X Y). cbn [round_mode] in C. fold (round_nearest (B2R x - B2R y)) in C. rewrite no_overflow in C by exact H. tauto. Qed.
  Lemma mul_rounds (x y : number) : is_finite x = true -> is_finite y = true -> Rabs (B2R x * B2R y) <= safe_maximum ->
    B2R (Bmult mode_NE x y) = round_nearest (B2R x * B2R y) /\ is_finite (Bmult mode_NE x y) = true.
  Proof.
    intros X Y H. assert (C := Bmult_correct prec emax _ _ mode_NE x y). cbn [round_mode] in C. fold (round_nearest (B2R x * B2R y)) in C. rewrite no_overflow in C by exact H.
    destruct C as (C1 & C2 & _). split; [exact C1|]. rewrite C2, X, Y. reflexivity.
  Qed.
  Lemma div_rounds (x y : number) : is_finite x = true -> B2R y <> 0 -> Rabs (B2R x / B2R y) <= safe_maximum ->
    B2R (Bdiv mode_NE x y) = round_nearest (B2R x / B2R y) /\ is_finite (Bdiv mode_NE x y) = true.
  Proof.
    intros X Y H. assert (C := Bdiv_correct prec emax _ _ mode_NE x y Y). cbn [round_mode] in C. fold (round_nearest (B2R x / B2R y)) in C. rewrite no_overflow in C by exact H.
    destruct C as (C1 & C2 & _). split; [exact C1|]. now rewrite C2.
  Qed.
  Lemma less_is_real_order (x y : number) : is_finite x = true -> is_finite y = true -> Bltb x y = true <-> B2R x < B2R y.
  Proof. intros X Y. rewrite (Bltb_correct prec emax x y X Y). case Rlt_bool_spec; intuition (try easy; lra). Qed.
  Lemma at_most_is_real_order (x y : number) : is_finite x = true -> is_finite y = true -> Bleb x y = true <-> B2R x <= B2R y.
  Proof. intros X Y. rewrite (Bleb_correct prec emax x y X Y). case Rle_bool_spec; intuition (try easy; lra). Qed.
  Lemma opp_is_exact (x : number) : B2R (Bopp x) = - B2R x /\ is_finite (Bopp x) = is_finite x.
  Proof. split; [apply B2R_Bopp|apply is_finite_Bopp]. Qed.

  (* Integers up to 2^24 are floats. *)
  Lemma small_integer_in_format z : (Z.abs z <= 2 ^ 24)%Z -> generic_format radix2 format_exponent (IZR z).
  Proof.
    intro H. assert (E : F2R (Float radix2 z 0) = IZR z) by (unfold F2R; cbn; ring).
    destruct (Z.eq_dec (Z.abs z) (2 ^ 24)) as [Q|Q].
    - assert (B : generic_format radix2 format_exponent (bpow radix2 24)).
      { apply generic_format_bpow. unfold FLT_exp. assert (P := prec_lt_emax_). unfold Prec_lt_emax in *. lia. }
      destruct (Z.abs_spec z) as [[_ Z1]|[_ Z1]]; rewrite Z1 in Q.
      + rewrite Q. exact B.
      + replace z with (- (2 ^ 24))%Z by lia. rewrite opp_IZR. now apply generic_format_opp.
    - apply generic_format_FLT. exists (Float radix2 z 0); cbn [Fnum Fexp]; [now rewrite E| |assert (P := prec_lt_emax_); unfold Prec_lt_emax in *; lia].
      apply Z.lt_le_trans with (2 ^ 24)%Z; [lia|]. change (radix_val radix2) with 2%Z. apply Z.pow_le_mono_r; lia.
  Qed.
  Lemma small_integer_no_overflow z : (Z.abs z <= 2 ^ 24)%Z -> Rabs (IZR z) < bpow radix2 emax.
  Proof.
    intro H. rewrite <- abs_IZR. apply Rle_lt_trans with (bpow radix2 24); [|apply bpow_lt; lia].
    change (bpow radix2 24) with (IZR (2 ^ 24)). now apply IZR_le.
  Qed.
  Lemma of_int_exact z : (Z.abs z <= 2 ^ 24)%Z -> B2R (of_int z) = IZR z /\ is_finite (of_int z) = true.
  Proof.
    intro H. assert (C := binary_normalize_correct prec emax _ _ mode_NE z 0 false). cbv zeta in C. cbn [round_mode] in C.
    assert (E : F2R (Float radix2 z 0) = IZR z) by (unfold F2R; cbn; ring). rewrite E in C.
    unfold of_int. match type of C with context [round radix2 ?f ?r (IZR z)] => change (round radix2 f r (IZR z)) with (round_nearest (IZR z)) in C end.
    rewrite (round_nearest_of_format _ (small_integer_in_format z H)) in C. rewrite Rlt_bool_true in C; [tauto|now apply small_integer_no_overflow].
  Qed.
  Lemma integer_literal_exact d z : (Z.abs z <= 2 ^ 24)%Z -> (decimal_value d == inject_Z z)%Q -> B2R (decimal_number d) = IZR z /\ is_finite (decimal_number d) = true.
  Proof.
    intros H E. assert (V : Q2R (decimal_value d) = IZR z) by (rewrite (Qeq_eqR _ _ E); unfold Q2R, inject_Z; cbn; lra).
    assert (C := decimal_number_rounds d). rewrite V, (round_nearest_of_format _ (small_integer_in_format z H)) in C. apply C. now apply small_integer_no_overflow.
  Qed.
  Lemma truncation_value (x : number) : Btrunc x = Ztrunc (B2R x).
  Proof.
    apply eq_IZR. rewrite Btrunc_correct by exact prec_lt_emax_. unfold round, F2R; cbn [Fnum Fexp]. unfold scaled_mantissa, cexp, FIX_exp; cbn [bpow Z.opp]. now rewrite !Rmult_1_r.
  Qed.

  (* ---------------------------------------------------------------- errors *)

  Lemma unit_roundoff_range : 0 < unit_roundoff <= / IZR (2 ^ 24).
  Proof.
    unfold unit_roundoff. split; [apply bpow_gt_0|]. change (/ IZR (2 ^ 24)) with (bpow radix2 (-24)). apply bpow_le; lia.
  Qed.
  Lemma unit_roundoff_as_half : / 2 * bpow radix2 (- prec + 1) = unit_roundoff.
  Proof. rewrite bpow_plus. unfold unit_roundoff. cbn [bpow]. change (Z.pow_pos radix2 1) with 2%Z. lra. Qed.

  (* The absolute error of a rounding, from subnormal numbers. *)
  Definition underflow_error : R := bpow radix2 (-150).
  Lemma round_nearest_error x : Rabs (round_nearest x - x) <= Rabs x * unit_roundoff + underflow_error.
  Proof.
    destruct (error_N_FLT radix2 (3 - emax - prec) prec ltac:(exact prec_gt_0_) (fun x => negb (Z.even x)) x) as (e & t & He & Ht & _ & E).
    unfold round_nearest, ZnearestE in *. rewrite E. replace (x * (1 + e) + t - x) with (x * e + t) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_mult. apply Rplus_le_compat.
    - apply Rmult_le_compat_l; [apply Rabs_pos|]. apply Rle_trans with (1 := He). rewrite unit_roundoff_as_half. apply Rle_refl.
    - apply Rle_trans with (1 := Ht). unfold underflow_error. replace (/ 2) with (bpow radix2 (-1)) by reflexivity. rewrite <- bpow_plus. apply bpow_le. lia.
  Qed.
  Lemma round_nearest_relative_error x : bpow radix2 (-126) <= Rabs x -> Rabs (round_nearest x - x) <= unit_roundoff * Rabs x.
  Proof.
    intro H. rewrite <- unit_roundoff_as_half. apply (relative_error_N_FLT radix2 (3 - emax - prec) prec ltac:(exact prec_gt_0_) (fun x => negb (Z.even x))).
    apply Rle_trans with (2 := H). apply bpow_le. lia.
  Qed.
  (* A sum of floats has a relative error alone. *)
  Lemma sum_relative_error x y : generic_format radix2 format_exponent x -> generic_format radix2 format_exponent y -> Rabs (round_nearest (x + y) - (x + y)) <= unit_roundoff * Rabs (x + y).
  Proof.
    intros X Y. destruct (Plus_error.FLT_plus_error_N_ex radix2 (3 - emax - prec) prec (fun x => negb (Z.even x)) x y X Y) as (e & He & E).
    change (round_nearest (x + y)) with (round radix2 format_exponent (Znearest (fun x => negb (Z.even x))) (x + y)). rewrite E. replace ((x + y) * (1 + e) - (x + y)) with (e * (x + y)) by ring. rewrite Rabs_mult.
    apply Rmult_le_compat_r; [apply Rabs_pos|]. apply Rle_trans with (1 := He).
    assert (U : u_ro radix2 prec = unit_roundoff) by (unfold u_ro; apply unit_roundoff_as_half). rewrite U. pose proof unit_roundoff_range.
    apply Rmult_le_reg_r with (1 + unit_roundoff); [lra|]. unfold Rdiv. rewrite Rmult_assoc, Rinv_l by lra. nra.
  Qed.
  Lemma difference_relative_error x y : generic_format radix2 format_exponent x -> generic_format radix2 format_exponent y -> Rabs (round_nearest (x - y) - (x - y)) <= unit_roundoff * Rabs (x - y).
  Proof. intros X Y. change (x - y) with (x + - y). apply sum_relative_error; [exact X|now apply generic_format_opp]. Qed.
End Semantics.
