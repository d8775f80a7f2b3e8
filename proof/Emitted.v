(* P7: the emitted function `tube` against the exact edge. What rounds: the time that is passed, its product with K/t_c, and the
   statements of `basis` and `blend`. *)
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

  Definition emitted_edge (side : Z * Z -> Z) (i : nat) (t : R) : R :=
    let u := emitted_time t in
    let k := Z.to_nat (Ztrunc u) in
    let s := to_format format (u - INR k) in
    let q j := unit * IZR (nth (k + j) (column side i rows) 0%Z) in
    nth 23 (exec (to_format format) basis_blend [s; q 0%nat; q 1%nat; q 2%nat; q 3%nat]) 0.

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

  Theorem emitted_edge_ok clock t : reads clock t ->
    Rabs (emitted_edge side i clock - edge unit T rows side i t) <= Q2R e + unit * (3 * IZR Vi * late).
  Proof.
    intro Clock.
    pose proof (emitted_time_range clock) as Ur. pose proof (emitted_time_ok clock t Clock) as Uo.
    pose proof (emitted_time_float clock) as Uf.
    set (u := emitted_time clock) in *.
    assert (Fl : Ztrunc u = Zfloor u) by (apply Ztrunc_floor; lra).
    assert (F0 : (0 <= Zfloor u)%Z) by (apply Zfloor_lub; lra).
    pose proof (Zfloor_lb u) as Lb. pose proof (Zfloor_ub u) as Ub.
    assert (Ek : INR (Z.to_nat (Ztrunc u)) = IZR (Zfloor u)) by (now rewrite Fl, INR_IZR_INZ, Z2Nat.id).
    assert (Kk : segment K u = Z.to_nat (Ztrunc u)).
    { unfold segment. rewrite <- Fl. apply Nat.min_l.
      assert (INR (Z.to_nat (Ztrunc u)) < INR K) by lra. apply INR_lt in H. lia. }
    assert (Sp : Rabs (emitted_edge side i clock - unit * spline (column side i rows) u) <= Q2R e).
    { unfold emitted_edge; cbv zeta. fold u. unfold spline.
      replace (length (column side i rows) - 3)%nat with K by (unfold K, segments, column; now rewrite map_length).
      cbv zeta. rewrite Kk, Ek. rewrite (place_exact format u (Zfloor u) Uf ltac:(lra) F0).
      set (k := Z.to_nat (Ztrunc u)). rewrite Nat.add_0_r.
      set (z := fun j => IZR (nth (k + j) (column side i rows) 0%Z)).
      assert (Zb : forall j, Rabs (unit * z j) <= Q2R largest) by (intro; apply bounded).
      assert (Z0 : nth k (column side i rows) 0%Z = nth (k + 0) (column side i rows) 0%Z) by now rewrite Nat.add_0_r.
      rewrite Z0. unfold cubic. fold (z 0%nat) (z 1%nat) (z 2%nat) (z 3%nat).
      eapply Rle_trans; [right|apply (evaluation_ok format largest e (u - IZR (Zfloor u)) (unit * z 0%nat) (unit * z 1%nat) (unit * z 2%nat) (unit * z 3%nat)); auto; lra].
      f_equal. f_equal. ring. }
    assert (Kp : (0 < K)%nat) by (destruct (regular_ok _ _ Rg); unfold K, segments; lia).
    destruct (spline_time_range T rows t T_pos) as [A B]. fold K in B.
    assert (V0 : 0 <= IZR Vi) by (eapply (V_nonneg rows n i Vi side of); eauto).
    assert (Lp : Rabs (spline (column side i rows) u - spline (column side i rows) (spline_time T rows t)) <= 3 * IZR Vi * late).
    { assert (G : forall a b, 0 <= a -> a <= b -> b <= INR K ->
        Rabs (spline (column side i rows) b - spline (column side i rows) a) <= 3 * IZR Vi * (b - a)).
      { intros a b Ha Hab Hb. apply (S_lip rows n i Vi side of Rg Hi sides St K); auto. }
      apply Rabs_le_between in Uo.
      destruct (Rle_dec (spline_time T rows t) u).
      - apply Rle_trans with (3 * IZR Vi * (u - spline_time T rows t)); [apply G; lra|apply Rmult_le_compat_l; lra].
      - rewrite Rabs_minus_sym.
        apply Rle_trans with (3 * IZR Vi * (spline_time T rows t - u)); [apply G; lra|apply Rmult_le_compat_l; lra]. }
    assert (E : edge unit T rows side i t = unit * spline (column side i rows) (spline_time T rows t)) by reflexivity.
    rewrite E. clear E. revert Sp Lp.
    generalize (emitted_edge side i clock) (spline (column side i rows) u) (spline (column side i rows) (spline_time T rows t)).
    intros a b d Sp Lp. replace (a - unit * d) with ((a - unit * b) + unit * (b - d)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat; [exact Sp|].
    rewrite Rabs_mult, (Rabs_pos_eq unit) by lra. apply Rmult_le_compat_l; lra.
  Qed.
End Emitted.
