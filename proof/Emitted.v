(* P7: the emitted edges against the exact ones. What rounds: the time that is passed, its product with K/t_c (a count of ticks is exact,
   and its part of a segment rounded once), and the statements of `basis` and `blend`. *)
From Coq Require Import ZArith QArith Qreals Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed Rounding.
Import ListNotations.
Open Scope R_scope.

Section Emitted.
  Variables (format : format) (rows : table) (n : nat) (unit T c last : R).
  Let K := segments rows.

  Definition emitted_time (t : R) : R :=
    let started := if Rlt_dec 0 t then t else 0 in
    let scaled := to_format format (started * c) in
    if Rlt_dec scaled last then scaled else last.

  (* An edge in segment k at s: a place is the two together. *)
  Definition placed (side : Z * Z -> Z) (i : nat) (p : nat * R) : R :=
    let q j := unit * IZR (nth (fst p + j) (column side i rows) 0%Z) in
    nth 23 (exec (to_format format) basis_blend [snd p; q 0%nat; q 1%nat; q 2%nat; q 3%nat]) 0.
  Definition place_of_time (t : R) : nat * R :=
    let u := emitted_time t in let k := Z.to_nat (Ztrunc u) in (k, to_format format (u - INR k)).

  (* Of a count of ticks, of which one is multiplier / divisor of a segment, and `final` the first that is not before t_c. *)
  Definition ticked (final multiplier divisor tick : Z) : Z :=
    let passed := (Z.min tick final * multiplier)%Z in Z.min passed (divisor * Z.of_nat K).
  Definition place_of_tick (final multiplier divisor tick : Z) : nat * R :=
    let place := ticked final multiplier divisor tick in
    let k := Z.min (place / divisor) (Z.of_nat K - 1) in
    (Z.to_nat k, to_format format (IZR (place - k * divisor) / IZR divisor)).

  (* A time passed to the emitted function may be rounded to the format. *)
  Definition reads (clock t : R) : Prop := Rabs (clock - t) <= Rabs t * Q2R (half_ulp format) + Q2R (half_least format).

  Variables (late : R).   (* how far the emitted spline time may be from the true one *)
  Let early := INR K / T * (T * Q2R (half_ulp format) + Q2R (half_least format)).   (* the part of it that the rounded time takes *)
  Hypothesis T_pos : 0 < T.
  Hypothesis unit_pos : 0 < unit.
  Hypothesis c_pos : 0 <= c.
  Hypothesis last_range : 0 <= last < INR K.
  Hypothesis last_float : generic_format radix2 (fexp format) last.
  Hypothesis late_last : INR K - last + early <= late.
  Hypothesis late_rate : T * Rabs (c - INR K / T) + (T * c * Q2R (half_ulp format) + Q2R (half_least format)) + early <= late.

  Lemma emitted_time_range t : 0 <= emitted_time t <= last.
  Proof.
    unfold emitted_time; cbv zeta. set (st := if Rlt_dec 0 t then t else 0).
    assert (S0 : 0 <= st) by (unfold st; destruct Rlt_dec; lra).
    assert (0 <= to_format format (st * c)).
    { unfold to_format. apply round_ge_generic; [apply fexp_valid|apply valid_rnd_N|apply generic_format_0|]. now apply Rmult_le_pos. }
    destruct (Rlt_dec (to_format format (st * c)) last); lra.
  Qed.

  Lemma emitted_time_float t : generic_format radix2 (fexp format) (emitted_time t).
  Proof.
    unfold emitted_time; cbv zeta. destruct (Rlt_dec (to_format format _) last); [|exact last_float].
    unfold to_format. apply generic_format_round; [apply fexp_valid|apply valid_rnd_N].
  Qed.

  Lemma emitted_time_exact t : Rabs (emitted_time t - spline_time T rows t) <= late - early.
  Proof.
    assert (KT : INR K / T * T = INR K) by (field; lra).
    assert (R0 : 0 <= INR K / T) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    set (dc := Rabs (c - INR K / T)) in *.
    assert (Dc : - dc <= c - INR K / T <= dc) by (apply Rabs_le_between; unfold dc; lra).
    assert (U : 0 <= Q2R (half_ulp format) <= 1) by apply half_ulp_range.
    set (ul := Q2R (half_ulp format)) in *. set (ti := Q2R (half_least format)) in *.
    unfold emitted_time, spline_time, hold; cbv zeta. fold K.
    destruct (Rlt_dec 0 t) as [t0|t0].
    2: { rewrite Rmult_0_l. replace (to_format format 0) with 0 by (unfold to_format; now rewrite round_0 by apply valid_rnd_N).
         assert (Rmin t T <= 0) by (apply Rle_trans with t; [apply Rmin_l|lra]).
         rewrite Rmax_left, Rmult_0_r by lra.
         destruct (Rlt_dec 0 last); [rewrite Rminus_0_r, Rabs_R0|].
         - lra.
         - replace last with 0 by lra. rewrite Rminus_0_r, Rabs_R0. lra. }
    rewrite (Rmax_right 0) by (apply Rmin_glb; lra).
    assert (E := to_format_ok format (t * c)). fold ul ti in E. rewrite (Rabs_pos_eq (t * c)) in E by (apply Rmult_le_pos; lra).
    apply Rabs_le_between in E.
    destruct (Rle_dec t T) as [tT|tT].
    - rewrite Rmin_left by exact tT.
      assert (A : t * c * ul <= T * c * ul) by (apply Rmult_le_compat_r; [lra|apply Rmult_le_compat_r; lra]).
      assert (B : t * dc <= T * dc) by (apply Rmult_le_compat_r; [apply Rabs_pos|lra]).
      assert (Dt : - (t * dc) <= t * c - INR K / T * t <= t * dc) by nra.
      assert (Up : INR K / T * t <= INR K) by (rewrite <- KT at 2; apply Rmult_le_compat_l; lra).
      destruct (Rlt_dec (to_format format (t * c)) last); apply Rabs_le; lra.
    - rewrite Rmin_right by lra. rewrite KT.
      assert (A : T * c * (1 - ul) <= t * c * (1 - ul)) by (apply Rmult_le_compat_r; [lra|apply Rmult_le_compat_r; lra]).
      assert (Dt : - (T * dc) <= T * c - INR K) by (rewrite <- KT; nra).
      destruct (Rlt_dec (to_format format (t * c)) last); apply Rabs_le; lra.
  Qed.

  Lemma clock_ok clock t : reads clock t -> Rabs (spline_time T rows clock - spline_time T rows t) <= early.
  Proof.
    unfold reads, spline_time, early. fold K. intro H.
    assert (U := half_ulp_range format). assert (L := half_least_pos format).
    set (ul := Q2R (half_ulp format)) in *. set (ti := Q2R (half_least format)) in *.
    assert (R0 : 0 <= INR K / T) by (apply Rmult_le_pos; [apply pos_INR|left; now apply Rinv_0_lt_compat]).
    rewrite <- Rmult_minus_distr_l, Rabs_mult, (Rabs_pos_eq (INR K / T)) by exact R0. apply Rmult_le_compat_l; [exact R0|].
    assert (0 <= T * ul) by (apply Rmult_le_pos; lra).
    apply Rabs_le_between in H. unfold hold.
    destruct (Rle_dec 0 t) as [t0|t0].
    - rewrite (Rabs_pos_eq t t0) in H. destruct (Rle_dec t T) as [tT|tT].
      + assert (t * ul <= T * ul) by (apply Rmult_le_compat_r; lra).
        apply Rabs_le. unfold Rmax, Rmin; repeat destruct Rle_dec; lra.
      + assert (T * (1 - ul) <= t * (1 - ul)) by (apply Rmult_le_compat_r; lra).
        apply Rabs_le. unfold Rmax, Rmin; repeat destruct Rle_dec; lra.
    - rewrite (Rabs_left t) in H by lra. assert (0 <= - t * (1 - ul)) by (apply Rmult_le_pos; lra).
      apply Rabs_le. unfold Rmax, Rmin; repeat destruct Rle_dec; lra.
  Qed.

  Lemma emitted_time_ok clock t : reads clock t -> Rabs (emitted_time clock - spline_time T rows t) <= late.
  Proof.
    intro H. assert (A := emitted_time_exact clock). assert (B := clock_ok clock t H).
    replace (emitted_time clock - spline_time T rows t)
      with ((emitted_time clock - spline_time T rows clock) + (spline_time T rows clock - spline_time T rows t)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. lra.
  Qed.

  Variables (i : nat) (side : Z * Z -> Z) (of : bez * bez -> bez) (Vi : Z) (largest e : Q).
  Hypothesis Rg : regular n rows = true.
  Hypothesis Hi : (i < n)%nat.
  Hypothesis sides : (side = fst /\ of = fst) \/ (side = snd /\ of = snd).
  Hypothesis St : steep Vi i rows = true.
  Hypothesis bounded : forall k, Rabs (unit * IZR (nth k (column side i rows) 0%Z)) <= Q2R largest.
  Hypothesis ev : evaluation_error format largest = Some e.

  (* A place fits a time when its spline time is wrong by no more than `late`. *)
  Definition fits (t : R) (p : nat * R) : Prop :=
    (fst p < K)%nat /\ 0 <= snd p <= 1 /\ Rabs (INR (fst p) + snd p - spline_time T rows t) <= late.

  Theorem placed_ok p t : fits t p -> Rabs (placed side i p - edge unit T rows side i t) <= Q2R e + unit * (3 * IZR Vi * late).
  Proof.
    destruct p as [k s]. unfold fits; cbn [fst snd]. intros (Hk & Hs & Near).
    assert (Sp : Rabs (placed side i (k, s) - unit * spline (column side i rows) (INR k + s)) <= Q2R e).
    { unfold placed; cbn [fst snd]. rewrite (S_piece rows n i side of Rg Hi sides k (INR k + s)) by (fold K; lia || lra).
      replace (INR k + s - INR k) with s by ring.
      assert (Kk : (k + 3 < length rows)%nat) by (unfold K, segments in Hk; lia).
      assert (B : of (nth i (nth k (pieces rows) []) (zero_bez, zero_bez)) =
        to_bez (nth (k + 0) (column side i rows) 0%Z) (nth (k + 1) (column side i rows) 0%Z) (nth (k + 2) (column side i rows) 0%Z) (nth (k + 3) (column side i rows) 0%Z)).
      { destruct (regular_ok _ _ Rg) as [_ Ln]. rewrite pieces_nth by exact Hk. rewrite (make_piece_nth n) by (try apply Ln; lia). rewrite Nat.add_0_r.
        rewrite !column_nth by (destruct sides as [[-> _]|[-> _]]; reflexivity). destruct sides as [[-> ->]|[-> ->]]; reflexivity. }
      rewrite B, <- cubic_bezier. unfold cubic. set (z := fun j => IZR (nth (k + j) (column side i rows) 0%Z)).
      fold (z 0%nat) (z 1%nat) (z 2%nat) (z 3%nat).
      eapply Rle_trans; [right|apply (evaluation_ok format largest e s (unit * z 0%nat) (unit * z 1%nat) (unit * z 2%nat) (unit * z 3%nat)); auto; apply bounded].
      f_equal. f_equal. ring. }
    destruct (spline_time_range T rows t T_pos) as [A B]. fold K in B.
    assert (V0 : 0 <= IZR Vi) by (eapply (V_nonneg rows n i Vi side of); eauto).
    set (u := INR k + s) in *.
    assert (Ur : 0 <= u <= INR K) by (unfold u; pose proof (pos_INR k); assert (INR k + 1 <= INR K) by (rewrite <- S_INR; apply le_INR; lia); lra).
    assert (Lp : Rabs (spline (column side i rows) u - spline (column side i rows) (spline_time T rows t)) <= 3 * IZR Vi * late).
    { assert (G : forall a b, 0 <= a -> a <= b -> b <= INR K ->
        Rabs (spline (column side i rows) b - spline (column side i rows) a) <= 3 * IZR Vi * (b - a)).
      { intros a b Ha Hab Hb. apply (S_lip rows n i Vi side of Rg Hi sides St K); auto. }
      apply Rabs_le_between in Near.
      destruct (Rle_dec (spline_time T rows t) u).
      - apply Rle_trans with (3 * IZR Vi * (u - spline_time T rows t)); [apply G; lra|apply Rmult_le_compat_l; lra].
      - rewrite Rabs_minus_sym.
        apply Rle_trans with (3 * IZR Vi * (spline_time T rows t - u)); [apply G; lra|apply Rmult_le_compat_l; lra]. }
    assert (E : edge unit T rows side i t = unit * spline (column side i rows) (spline_time T rows t)) by reflexivity.
    rewrite E. clear E. revert Sp Lp.
    generalize (placed side i (k, s)) (spline (column side i rows) u) (spline (column side i rows) (spline_time T rows t)).
    intros a b d Sp Lp. replace (a - unit * d) with ((a - unit * b) + unit * (b - d)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat; [exact Sp|].
    rewrite Rabs_mult, (Rabs_pos_eq unit) by lra. apply Rmult_le_compat_l; lra.
  Qed.

  (* Seconds, right or rounded once. *)
  Lemma time_fits clock t : reads clock t -> fits t (place_of_time clock).
  Proof.
    intro Clock. pose proof (emitted_time_range clock) as Ur. pose proof (emitted_time_ok clock t Clock) as Uo.
    pose proof (emitted_time_float clock) as Uf. unfold fits, place_of_time. cbv zeta. set (u := emitted_time clock) in *. cbn [fst snd].
    assert (Fl : Ztrunc u = Zfloor u) by (apply Ztrunc_floor; lra).
    assert (F0 : (0 <= Zfloor u)%Z) by (apply Zfloor_lub; lra).
    pose proof (Zfloor_lb u) as Lb. pose proof (Zfloor_ub u) as Ub.
    assert (Ek : INR (Z.to_nat (Ztrunc u)) = IZR (Zfloor u)) by (now rewrite Fl, INR_IZR_INZ, Z2Nat.id).
    rewrite Ek. assert (Pl := place_exact format u (Zfloor u) Uf ltac:(lra) F0). rewrite Pl.
    split; [apply INR_lt; lra|split; [lra|]]. replace (IZR (Zfloor u) + (u - IZR (Zfloor u))) with u by ring. exact Uo.
  Qed.
End Emitted.

Section Ticks.
  Variables (format : format) (rows : table) (n : nat) (T late : R).
  Let K := segments rows.
  Hypothesis T_pos : 0 < T.
  Hypothesis Rg : regular n rows = true.

  (* A count of ticks, of which one takes `period` seconds. *)
  Variables (final multiplier divisor : Z) (period : R).
  Hypothesis ticks_pos : (0 < multiplier)%Z /\ (0 < divisor)%Z.
  Hypothesis ticks_last : (divisor * Z.of_nat K <= final * multiplier)%Z.
  Hypothesis ticks_rate : IZR multiplier * T = IZR divisor * INR K * period.
  Hypothesis ticks_late : Q2R (half_ulp format) + Q2R (half_least format) <= late.

  Lemma ticked_min tick : (0 <= tick)%Z -> ticked rows final multiplier divisor tick = Z.min (tick * multiplier) (divisor * Z.of_nat K).
  Proof. intro H. unfold ticked. cbv zeta. destruct ticks_pos. destruct (Z.min_spec tick final) as [[C ->]|[C ->]]; [reflexivity|]. nia. Qed.
  Lemma ticked_time tick : (0 <= tick)%Z -> IZR (ticked rows final multiplier divisor tick) = IZR divisor * spline_time T rows (IZR tick * period).
  Proof.
    intro H. destruct ticks_pos as [M0 D0]. apply IZR_lt in M0, D0. pose proof (IZR_le _ _ H) as H0.
    assert (Kp : 0 < INR K) by (apply lt_0_INR; destruct (regular_ok _ _ Rg); unfold K, segments; lia).
    assert (P0 : 0 < period).
    { assert (0 < IZR divisor * INR K) by (apply Rmult_lt_0_compat; lra). apply (Rmult_lt_reg_l (IZR divisor * INR K)); [lra|]. rewrite <- ticks_rate, Rmult_0_r. apply Rmult_lt_0_compat; lra. }
    assert (I : IZR tick * IZR multiplier = IZR divisor * (INR K / T * (IZR tick * period))).
    { apply (Rmult_eq_reg_r T); [|lra]. replace (IZR divisor * (INR K / T * (IZR tick * period)) * T) with (IZR tick * (IZR divisor * INR K * period)) by (field; lra). rewrite <- ticks_rate. ring. }
    rewrite ticked_min by exact H. unfold spline_time, hold. fold K. rewrite (Rmax_right 0) by (apply Rmin_glb; [apply Rmult_le_pos; lra|lra]).
    assert (R0 : 0 < INR K / T) by (apply Rdiv_lt_0_compat; lra).
    destruct (Z.min_spec (tick * multiplier) (divisor * Z.of_nat K)) as [[C ->]|[C ->]]; apply IZR_lt in C || apply IZR_le in C; rewrite !mult_IZR, <- INR_IZR_INZ in C.
    - rewrite mult_IZR, I. rewrite I in C. apply Rmult_lt_reg_l in C; [|lra]. rewrite Rmin_left; [reflexivity|].
      apply (Rmult_le_reg_l (INR K / T)); [lra|]. replace (INR K / T * T) with (INR K) by (field; lra). lra.
    - rewrite mult_IZR, <- INR_IZR_INZ. rewrite I in C. apply Rmult_le_reg_l in C; [|lra]. rewrite Rmin_right; [field; lra|].
      apply (Rmult_le_reg_l (INR K / T)); [lra|]. replace (INR K / T * T) with (INR K) by (field; lra). lra.
  Qed.
  Lemma tick_fits tick : (0 <= tick)%Z -> fits rows T late (IZR tick * period) (place_of_tick format rows final multiplier divisor tick).
  Proof.
    intro H. assert (E := ticked_time tick H). assert (M := ticked_min tick H). unfold fits, place_of_tick. cbv zeta. fold K. set (place := ticked _ _ _ _ _) in *. cbn [fst snd].
    destruct ticks_pos as [M0 D0]. assert (Kp : (0 < Z.of_nat K)%Z) by (destruct (regular_ok _ _ Rg); unfold K, segments; lia).
    assert (P : (0 <= place <= divisor * Z.of_nat K)%Z) by nia.
    set (k := Z.min (place / divisor) (Z.of_nat K - 1)).
    assert (Dv := Z.div_mod place divisor ltac:(lia)). assert (Md := Z.mod_pos_bound place divisor D0).
    assert (Q0 : (0 <= place / divisor)%Z) by (apply Z.div_pos; lia).
    assert (K0 : (0 <= k <= Z.of_nat K - 1)%Z) by (unfold k; lia).
    assert (R0 : (0 <= place - k * divisor <= divisor)%Z) by (unfold k; destruct (Z.min_spec (place / divisor) (Z.of_nat K - 1)) as [[C ->]|[C ->]]; nia).
    assert (Dp := IZR_lt _ _ D0). destruct R0 as [R1 R2]. apply IZR_le in R1, R2.
    set (x := IZR (place - k * divisor) / IZR divisor).
    assert (X : 0 <= x <= 1).
    { unfold x. split; [apply Rcomplements.Rle_div_r; lra|apply Rcomplements.Rle_div_l; lra]. }
    assert (One : generic_format radix2 (fexp format) 1).
    { apply generic_format_FLT. exists (Float radix2 1 0); [unfold F2R; cbn; ring| |]; destruct format; cbn; lia. }
    assert (S0 : 0 <= to_format format x <= 1).
    { unfold to_format. split; [apply round_ge_generic|apply round_le_generic]; try apply fexp_valid; try apply valid_rnd_N; try apply generic_format_0; try exact One; lra. }
    split; [lia|split; [exact S0|]].
    assert (Ex : INR (Z.to_nat k) + x = spline_time T rows (IZR tick * period)).
    { rewrite INR_IZR_INZ, Z2Nat.id by lia. apply (Rmult_eq_reg_l (IZR divisor)); [|lra]. rewrite <- E. unfold x. rewrite minus_IZR, mult_IZR. field; lra. }
    rewrite <- Ex. replace (INR (Z.to_nat k) + to_format format x - (INR (Z.to_nat k) + x)) with (to_format format x - x) by ring.
    eapply Rle_trans; [apply to_format_ok|]. rewrite (Rabs_pos_eq x) by lra. pose proof (half_ulp_range format).
    assert (x * Q2R (half_ulp format) <= 1 * Q2R (half_ulp format)) by (apply Rmult_le_compat_r; lra). lra.
  Qed.
End Ticks.
