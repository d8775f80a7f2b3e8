(* P7 for straight-line code: every statement rounds once, and a forward analysis in rationals bounds what that adds up to. It is
   proved for any rounding with a relative and an absolute error, and used for IEEE single and double precision as Flocq has them. *)
From Coq Require Import ZArith QArith Qreals Qminmax Qabs Qround Reals List Bool Lia Lra Psatz.
From Flocq Require Import Core Relative.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Tube Loop Speed.
Import ListNotations.
Open Scope R_scope.

(* ------------------------------------------------------------------ code: one operation a statement, each value assigned once *)

Inductive operand := V (i : nat) | C (c : Z).
Inductive op := Add | Sub | Mul.
Record stmt := Stmt { what : op; left : operand; right : operand }.

Definition get (env : list R) (o : operand) : R := match o with V i => nth i env 0 | C c => IZR c end.
Definition apply_op (o : op) (a b : R) : R := match o with Add => a + b | Sub => a - b | Mul => a * b end.
Fixpoint exec (rnd : R -> R) (code : list stmt) (env : list R) : list R :=
  match code with [] => env | s :: rest => exec rnd rest (env ++ [rnd (apply_op (what s) (get env (left s)) (get env (right s)))]) end.

(* ------------------------------------------------------------------ forward analysis in rationals *)

Record known := Known { low : Q; high : Q; error : Q }.
Definition size (a : known) : Q := Qmax (Qabs (low a)) (Qabs (high a)).

(* A little more, so that errors of errors do not make fractions long. *)
Definition coarser (q : Q) : Q := Qceiling (q * inject_Z (2 ^ 120)) # (2 ^ 120).
Lemma coarser_ok q : Q2R q <= Q2R (coarser q).
Proof.
  assert (C := Qle_ceiling (q * inject_Z (2 ^ 120))). apply Qle_Rle in C. rewrite Q2R_mult in C.
  assert (P : 0 < IZR (2 ^ 120)) by now apply IZR_lt. assert (Z2 : Q2R (inject_Z (2 ^ 120)) = IZR (2 ^ 120)) by (unfold Q2R, inject_Z; cbn [Qnum Qden]; field). rewrite Z2 in C.
  unfold coarser. unfold Q2R at 2. cbn [Qnum Qden]. change (IZR (Zpos (2 ^ 120))) with (IZR (2 ^ 120)).
  apply (Rmult_le_reg_r (IZR (2 ^ 120))); [exact P|]. rewrite Rmult_assoc, Rinv_l, Rmult_1_r by lra. eapply Rle_trans; [exact C|].
  right. unfold Q2R, inject_Z; cbn [Qnum Qden]. field.
Qed.

Section Analysis.
  Variables ulp tiny : Q.
  Definition rounded (l h e : Q) : known :=
    let l := Qred l in let h := Qred h in
    Known l h (coarser (e + (Qmax (Qabs l) (Qabs h) + e) * ulp + tiny)).
  Definition get_known (env : list known) (o : operand) : option known :=
    match o with V i => nth_error env i | C c => Some (Known (inject_Z c) (inject_Z c) 0) end.
  Definition step (o : op) (a b : known) : known :=
    match o with
    | Add => rounded (low a + low b) (high a + high b) (error a + error b)
    | Sub => rounded (low a - high b) (high a - low b) (error a + error b)
    | Mul => rounded (Qmin (Qmin (low a * low b) (low a * high b)) (Qmin (high a * low b) (high a * high b)))
                     (Qmax (Qmax (low a * low b) (low a * high b)) (Qmax (high a * low b) (high a * high b)))
                     (size a * error b + size b * error a + error a * error b)
    end%Q.
  Fixpoint analyse (code : list stmt) (env : list known) : option (list known) :=
    match code with
    | [] => Some env
    | s :: rest => match get_known env (left s), get_known env (right s) with
                   | Some a, Some b => analyse rest (env ++ [step (what s) a b])
                   | _, _ => None
                   end
    end.

  Definition means (k : known) (exact float : R) : Prop :=
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

  Variable rnd : R -> R.
  Hypothesis rnd_ok : forall x, Rabs (rnd x - x) <= Rabs x * Q2R ulp + Q2R tiny.
  Hypothesis ulp_pos : 0 <= Q2R ulp.

  Lemma within_size l h x : l <= x <= h -> Rabs x <= Rmax (Rabs l) (Rabs h).
  Proof. intro H. apply RmaxAbs; lra. Qed.

  Lemma rounded_ok l h e exact value : Q2R l <= exact <= Q2R h -> Rabs (value - exact) <= Q2R e ->
    means (rounded l h e) exact (rnd value).
  Proof.
    intros H E. unfold means, rounded; cbn [low high error]. rewrite !Q2R_red. split; [exact H|].
    eapply Rle_trans; [|apply coarser_ok]. rewrite !Q2R_plus, Q2R_mult, Q2R_plus, Q2R_max, !Q2R_abs, !Q2R_red.
    replace (rnd value - exact) with ((rnd value - value) + (value - exact)) by ring.
    eapply Rle_trans; [apply Rabs_triang|]. pose proof (rnd_ok value).
    assert (Rabs value <= Rmax (Rabs (Q2R l)) (Rabs (Q2R h)) + Q2R e).
    { replace value with (exact + (value - exact)) by ring. eapply Rle_trans; [apply Rabs_triang|].
      apply Rplus_le_compat; [now apply within_size|exact E]. }
    assert (Rabs value * Q2R ulp <= (Rmax (Rabs (Q2R l)) (Rabs (Q2R h)) + Q2R e) * Q2R ulp) by (apply Rmult_le_compat_r; lra).
    lra.
  Qed.

  Lemma mul_range a b c d x y : a <= x <= b -> c <= y <= d ->
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

  Lemma step_ok o a b x y fx fy : means a x fx -> means b y fy -> means (step o a b) (apply_op o x y) (rnd (apply_op o fx fy)).
  Proof.
    intros [Ra Ea] [Rb Eb]. destruct o; cbn [step apply_op]; apply rounded_ok; rewrite ?Q2R_plus, ?Q2R_minus; try lra.
    - replace (fx + fy - (x + y)) with ((fx - x) + (fy - y)) by ring. eapply Rle_trans; [apply Rabs_triang|]; lra.
    - replace (fx - fy - (x - y)) with ((fx - x) + - (fy - y)) by ring. eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_Ropp; lra.
    - rewrite !Q2R_min, !Q2R_max, !Q2R_mult. now apply mul_range.
    - rewrite !Q2R_mult. unfold size. rewrite !Q2R_max, !Q2R_abs.
      replace (fx * fy - x * y) with (x * (fy - y) + y * (fx - x) + (fx - x) * (fy - y)) by ring.
      eapply Rle_trans; [apply Rabs_triang|]. apply Rplus_le_compat.
      + eapply Rle_trans; [apply Rabs_triang|]. rewrite !Rabs_mult.
        apply Rplus_le_compat; apply Rmult_le_compat; try apply Rabs_pos; auto; now apply within_size.
      + rewrite Rabs_mult. apply Rmult_le_compat; auto; apply Rabs_pos.
  Qed.

  Inductive All3 : list known -> list R -> list R -> Prop :=
  | nil3 : All3 [] [] []
  | cons3 k x f ks xs fs : means k x f -> All3 ks xs fs -> All3 (k :: ks) (x :: xs) (f :: fs).

  Lemma All3_app ks xs fs k x f : All3 ks xs fs -> means k x f -> All3 (ks ++ [k]) (xs ++ [x]) (fs ++ [f]).
  Proof. induction 1; intro M; cbn; [constructor; [exact M|constructor]|constructor; auto]. Qed.
  Lemma All3_nth ks xs fs i k : All3 ks xs fs -> nth_error ks i = Some k -> means k (nth i xs 0) (nth i fs 0).
  Proof. intro H; revert i; induction H; intros [|i] E; cbn in *; try easy; [now injection E as <-|auto]. Qed.
  Lemma get_ok ks xs fs o k : All3 ks xs fs -> get_known ks o = Some k -> means k (get xs o) (get fs o).
  Proof.
    destruct o; cbn; intros H E; [eapply All3_nth; eauto|]. injection E as <-. unfold means; cbn [low high error].
    rewrite Q2R_Z, Rminus_diag_eq, Rabs_R0 by reflexivity. replace (Q2R 0) with 0 by (unfold Q2R; cbn; lra). lra.
  Qed.

  Theorem analyse_sound code : forall ks xs fs out, analyse code ks = Some out -> All3 ks xs fs ->
    All3 out (exec (fun x => x) code xs) (exec rnd code fs).
  Proof.
    induction code as [|[o l r] rest IH]; cbn [analyse exec]; intros ks xs fs out E H; [now injection E as <-|].
    destruct (get_known ks _) as [a|] eqn:A; [|easy]. destruct (get_known ks (right _)) as [b|] eqn:B; [|easy].
    apply (IH _ _ _ _ E). apply All3_app; [exact H|]. cbn [what left right] in *.
    apply step_ok; eapply get_ok; eauto.
  Qed.
End Analysis.

(* ------------------------------------------------------------------ IEEE single and double precision, rounding to nearest even *)

(* Overflow is no part of these formats: a result is finite where it stays below the largest number of the format. *)
Inductive format := Single | Double.
Definition precision (f : format) : Z := match f with Single => 24 | Double => 53 end.
Definition least_exponent (f : format) : Z := match f with Single => -149 | Double => -1074 end.
Definition fexp (f : format) : Z -> Z := FLT_exp (least_exponent f) (precision f).
Definition to_format (f : format) : R -> R := round radix2 (fexp f) ZnearestE.

(* A rounding loses at most this share of the value, and half of the least subnormal number. *)
Definition half_ulp (f : format) : Q := match f with Single => 1 # 2 ^ 24 | Double => 1 # 2 ^ 53 end.
Definition half_least (f : format) : Q := match f with Single => 1 # 2 ^ 150 | Double => 1 # 2 ^ 1075 end.

Global Instance fexp_valid f : Valid_exp (fexp f).
Proof. destruct f; now apply FLT_exp_valid. Qed.

Lemma Q2R_unit p : Q2R (1 # p) = / IZR (Z.pos p). Proof. unfold Q2R; cbn [Qnum Qden]; lra. Qed.
Lemma half_power p : / IZR (Z.pos (2 ^ p)) = bpow radix2 (- Z.pos p).
Proof. rewrite bpow_opp. f_equal. rewrite Pos2Z.inj_pow. now apply (IZR_Zpower radix2 (Z.pos p)). Qed.
Lemma half_ulp_value f : Q2R (half_ulp f) = bpow radix2 (- precision f).
Proof. destruct f; unfold half_ulp; rewrite Q2R_unit; apply half_power. Qed.
Lemma half_least_value f : Q2R (half_least f) = bpow radix2 (least_exponent f - 1).
Proof. destruct f; unfold half_least; rewrite Q2R_unit; apply half_power. Qed.
Lemma half_ulp_range f : 0 <= Q2R (half_ulp f) <= 1.
Proof.
  rewrite half_ulp_value. split; [apply bpow_ge_0|]. apply (bpow_le radix2 _ 0). destruct f; cbn; lia.
Qed.
Lemma half_least_pos f : 0 <= Q2R (half_least f).
Proof. rewrite half_least_value. apply bpow_ge_0. Qed.

Lemma to_format_ok f x : Rabs (to_format f x - x) <= Rabs x * Q2R (half_ulp f) + Q2R (half_least f).
Proof.
  assert (P : (0 < precision f)%Z) by (destruct f; reflexivity).
  destruct (error_N_FLT radix2 (least_exponent f) (precision f) P (fun x => negb (Z.even x)) x) as (e & t & He & Ht & _ & E).
  unfold to_format, fexp. rewrite E. replace (x * (1 + e) + t - x) with (x * e + t) by ring.
  eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_mult. apply Rplus_le_compat.
  - apply Rmult_le_compat_l; [apply Rabs_pos|]. apply Rle_trans with (1 := He). right. rewrite half_ulp_value.
    change (/ 2) with (bpow radix2 (- (1))). rewrite <- bpow_plus. f_equal; ring.
  - apply Rle_trans with (1 := Ht). right. rewrite half_least_value.
    change (/ 2) with (bpow radix2 (- (1))). rewrite <- bpow_plus. f_equal; ring.
Qed.

(* u - floor u is exact *)
Lemma place_exact f u k : generic_format radix2 (fexp f) u -> IZR k <= u < IZR k + 1 -> (0 <= k)%Z -> to_format f (u - IZR k) = u - IZR k.
Proof.
  intros G H K0. unfold to_format. apply round_generic; [apply valid_rnd_N|].
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

(* ------------------------------------------------------------------ the emitted kernels `basis` and `blend` *)
(* 0: s; 1..4: q0..q3; then v0 .. v11 of basis (5 .. 16) and v0 .. v6 of blend (17 .. 23) *)
Definition basis_blend : list stmt := [
  Stmt Sub (C 1) (V 0);   (* 5  v0 *)
  Stmt Mul (V 5) (V 5);   (* 6  v1 *)
  Stmt Mul (V 6) (V 5);   (* 7  v2 = w0 *)
  Stmt Mul (V 5) (V 0);   (* 8  v3 *)
  Stmt Add (C 1) (V 8);   (* 9  v4 *)
  Stmt Mul (C 3) (V 9);   (* 10 v5 *)
  Stmt Mul (V 5) (V 10);  (* 11 v6 *)
  Stmt Add (C 1) (V 11);  (* 12 v7 = w1 *)
  Stmt Mul (V 0) (V 10);  (* 13 v8 *)
  Stmt Add (C 1) (V 13);  (* 14 v9 = w2 *)
  Stmt Mul (V 0) (V 0);   (* 15 v10 *)
  Stmt Mul (V 15) (V 0);  (* 16 v11 = w3 *)
  Stmt Mul (V 7) (V 1);   (* 17 *)
  Stmt Mul (V 12) (V 2);  (* 18 *)
  Stmt Add (V 17) (V 18); (* 19 *)
  Stmt Mul (V 14) (V 3);  (* 20 *)
  Stmt Mul (V 16) (V 4);  (* 21 *)
  Stmt Add (V 20) (V 21); (* 22 *)
  Stmt Add (V 19) (V 22)  (* 23 *)
].

Definition evaluation_error (f : format) (largest : Q) : option Q :=
  match analyse (half_ulp f) (half_least f) basis_blend
          [Known 0 1 0; Known (- largest) largest 0; Known (- largest) largest 0; Known (- largest) largest 0; Known (- largest) largest 0] with
  | Some out => option_map error (nth_error out 23)
  | None => None
  end.

Theorem evaluation_ok f largest e s a b c d : evaluation_error f largest = Some e -> 0 <= s <= 1 ->
  Rabs a <= Q2R largest -> Rabs b <= Q2R largest -> Rabs c <= Q2R largest -> Rabs d <= Q2R largest ->
  Rabs (nth 23 (exec (to_format f) basis_blend [s; a; b; c; d]) 0 -
    (a * (1 - s)^3 + b * (3*s^3 - 6*s^2 + 4) + c * (- 3*s^3 + 3*s^2 + 3*s + 1) + d * s^3)) <= Q2R e.
Proof.
  intros E Hs Ha Hb Hc Hd. unfold evaluation_error in E.
  destruct (analyse _ _ _ _) as [out|] eqn:A; [|easy].
  assert (Z0 : Q2R 0 = 0) by (unfold Q2R; cbn; lra). assert (Z1 : Q2R 1 = 1) by (unfold Q2R; cbn; lra).
  assert (M : forall x, Rabs x <= Q2R largest -> means (Known (- largest) largest 0) x x).
  { intros x Hx; unfold means; cbn [low high error]. rewrite Q2R_opp, Z0, Rminus_diag_eq, Rabs_R0 by reflexivity.
    apply Rabs_le_between in Hx; lra. }
  assert (S := analyse_sound (half_ulp f) (half_least f) (to_format f) (to_format_ok f) ltac:(apply half_ulp_range) _ _ [s; a; b; c; d] [s; a; b; c; d] _ A).
  destruct (nth_error out 23) as [k|] eqn:N; [|easy]. cbn in E. injection E as <-.
  assert (H3 : All3 [Known 0 1 0; Known (- largest) largest 0; Known (- largest) largest 0; Known (- largest) largest 0;
                     Known (- largest) largest 0] [s; a; b; c; d] [s; a; b; c; d]).
  { apply cons3; [|apply cons3; [now apply M|apply cons3; [now apply M|apply cons3; [now apply M|apply cons3; [now apply M|apply nil3]]]]].
    unfold means; cbn [low high error]. rewrite Z0, Z1, Rminus_diag_eq, Rabs_R0 by reflexivity. lra. }
  destruct (All3_nth _ _ _ 23 k (S H3) N) as [_ Q].
  replace (a * (1 - s)^3 + b * (3*s^3 - 6*s^2 + 4) + c * (- 3*s^3 + 3*s^2 + 3*s + 1) + d * s^3)
    with (nth 23 (exec (fun x => x) basis_blend [s; a; b; c; d]) 0); [exact Q|].
  cbv [exec basis_blend app nth get apply_op what left right]; ring.
Qed.

