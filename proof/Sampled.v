(* The closed loop with a zero-order hold: an input is computed every h seconds and held. *)
From Coq Require Import Reals Lra Psatz Lia.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Loop.
Open Scope R_scope.

Lemma first_time_from (f : R -> R) (s t c : R) : s <= t -> (forall r, continuity_pt f r) -> c < f s -> f t <= c ->
  exists m, s < m <= t /\ f m <= c /\ forall r, s <= r < m -> c < f r.
Proof.
  intros St Cf Fs Ft.
  destruct (first_time (fun r => f (s + r)) (t - s) c) as (m & Hm & Fm & A).
  - lra.
  - intro r; apply (continuity_pt_comp (fun r => s + r) f); [|apply Cf].
    apply continuity_pt_plus; [apply continuity_pt_const; now intros ? ?|apply derivable_continuous_pt, derivable_pt_id].
  - now rewrite Rplus_0_r.
  - now replace (s + (t - s)) with t by ring.
  - exists (s + m); split; [lra|split; [exact Fm|]].
    intros r Hr; assert (B := A (r - s) ltac:(lra)); cbn in B; now replace (s + (r - s)) with r in B by ring.
Qed.

Section Sampled.
  Variables (n : nat) (h : R) (N : nat).               (* N periods of h seconds *)
  Variables gmin gmax F v near far push_ : nat -> R.    (* push_: the largest input while `near` is kept *)
  Variables L U x f g : nat -> R -> R.
  Variable input : nat -> nat -> R.                     (* input held in period p, for dimension i *)
  Hypothesis h_pos : 0 < h.
  Hypothesis g_pos : forall i, (i < n)%nat -> 0 < gmin i.
  Hypothesis Fv_pos : forall i, (i < n)%nat -> 0 <= F i /\ 0 <= v i.
  Hypothesis near_pos : forall i, (i < n)%nat -> 0 < near i.
  Hypothesis L_lip : forall i, (i < n)%nat -> lipschitz (v i) (L i).
  Hypothesis U_lip : forall i, (i < n)%nat -> lipschitz (v i) (U i).
  Hypothesis x_cont : forall i t, (i < n)%nat -> continuity_pt (x i) t.

  Definition keeps (t : R) : Prop := forall i, (i < n)%nat -> near i <= x i t - L i t /\ near i <= U i t - x i t.
  Definition strictly_inside (t : R) : Prop := forall i, (i < n)%nat -> L i t < x i t < U i t.

  Hypothesis start : keeps 0.
  (* what is asked of the law at a sampling instant; the emitted arithmetic may be any that has it *)
  Hypothesis law_ok : forall p, (p < N)%nat -> keeps (INR p * h) -> forall i, (i < n)%nat ->
    Rabs (input p i) <= push_ i /\
    (x i (INR p * h) - L i (INR p * h) < far i -> F i + v i <= gmin i * input p i) /\
    (U i (INR p * h) - x i (INR p * h) < far i -> F i + v i <= gmin i * - input p i).
  Hypothesis ode : forall p t, (p < N)%nat -> INR p * h < t < INR p * h + h -> strictly_inside t -> forall i, (i < n)%nat ->
    is_derive (x i) t (f i t + g i t * input p i) /\ Rabs (f i t) <= F i /\ gmin i <= g i t <= gmax i.
  Hypothesis quick : forall i, (i < n)%nat -> (F i + v i + gmax i * push_ i) * h <= far i - near i.

  Let share (i : nat) (t : R) := Rmin (x i t - L i t) (U i t - x i t) * / (2 * near i).

  Lemma share_cont i t : (i < n)%nat -> continuity_pt (share i) t.
  Proof.
    intro Hi. apply (continuity_pt_mult (fun t => Rmin (x i t - L i t) (U i t - x i t)) (fun _ => / (2 * near i))).
    - apply continuity_pt_Rmin; apply continuity_pt_minus; auto; eapply lipschitz_cont; eauto.
    - apply continuity_pt_const; now intros ? ?.
  Qed.

  Lemma share_up i t c : (i < n)%nat -> (c <= share i t <-> 2 * near i * c <= x i t - L i t /\ 2 * near i * c <= U i t - x i t).
  Proof.
    intro Hi. pose proof (near_pos i Hi). unfold share. set (m := Rmin _ _).
    assert (E : m = m * / (2 * near i) * (2 * near i)) by (field; lra).
    assert (A : c <= m * / (2 * near i) <-> 2 * near i * c <= m).
    { split; intro Q.
      - rewrite E, Rmult_comm. apply Rmult_le_compat_r; lra.
      - apply (Rmult_le_reg_r (2 * near i)); [lra|]. rewrite <- E; lra. }
    rewrite A. unfold m, Rmin; destruct Rle_dec; lra.
  Qed.

  (* over one period *)
  Lemma period p : (p < N)%nat -> keeps (INR p * h) -> forall t, INR p * h <= t <= INR p * h + h -> keeps t.
  Proof.
    intros Hp Now. set (s := INR p * h) in *.
    assert (G : forall t, s <= t <= s + h -> 1 / 2 <= least_of n share t).
    2: { intros t Ht i Hi. assert (B := G t Ht). pose proof (least_of_le n share t i Hi) as D.
         assert (E : 1 / 2 <= share i t) by lra. apply share_up in E; [lra|exact Hi]. }
    intros t1 Ht1. apply Rnot_lt_le; intro Bad.
    set (w := least_of n share) in *.
    set (c := Rmax (1 / 4) ((w t1 + 1 / 2) / 2)).
    assert (C : 0 < c < 1 / 2 /\ w t1 <= c) by (unfold c, Rmax; destruct Rle_dec; lra).
    assert (W0 : 1 / 2 <= w s).
    { apply least_of_from; [lra|]. intros i Hi. apply share_up; [exact Hi|]. destruct (Now i Hi); lra. }
    destruct (first_time_from w s t1 c) as (m & Hm & Fm & Before); try lra.
    { intro; apply least_of_cont; intros; now apply share_cont. }
    assert (In : forall r, s <= r < m -> strictly_inside r).
    { intros r Hr i Hi. assert (B := Before r Hr). pose proof (least_of_le n share r i Hi) as D. fold w in D.
      assert (E : c <= share i r) by lra. apply share_up in E; [|exact Hi]. pose proof (near_pos i Hi).
      assert (0 < 2 * near i * c) by (apply Rmult_lt_0_compat; lra). lra. }
    destruct (least_of_at n share m) as (i & Hi & E); [fold w; lra|]. fold w in E.
    assert (Near : x i m - L i m < near i \/ U i m - x i m < near i).
    { destruct (Rlt_dec (x i m - L i m) (near i)); [now left|]. destruct (Rlt_dec (U i m - x i m) (near i)); [now right|].
      assert (1 / 2 <= share i m) by (apply share_up; [exact Hi|]; lra). lra. }
    destruct (law_ok p Hp Now i Hi) as (Ub & Ua & Uc). fold s in Ua, Uc.
    destruct (Fv_pos i Hi) as (F0 & v0). pose proof (g_pos i Hi) as gp.
    pose proof (quick i Hi) as Q. destruct (Now i Hi) as (N1 & N2).
    assert (Um : 0 <= push_ i) by (pose proof (Rabs_pos (input p i)); lra).
    (* with the input held, x moves no faster than this *)
    assert (Gu : forall r, s < r < m -> Rabs (g i r * input p i) <= gmax i * push_ i).
    { intros r Hr. destruct (ode p r Hp ltac:(fold s; lra) (In r ltac:(lra)) i Hi) as (_ & _ & G1 & G2).
      rewrite Rabs_mult. rewrite (Rabs_pos_eq (g i r)) by lra. apply Rmult_le_compat; try lra. apply Rabs_pos. }
    assert (Dur : (F i + v i + gmax i * push_ i) * (m - s) <= far i - near i).
    { assert (0 <= gmax i * push_ i).
      { destruct (ode p ((s + m) / 2) Hp ltac:(fold s; lra) (In ((s + m) / 2) ltac:(lra)) i Hi) as (_ & _ & G1 & G2).
        apply Rmult_le_pos; lra. }
      apply Rle_trans with ((F i + v i + gmax i * push_ i) * h); [apply Rmult_le_compat_l; lra|exact Q]. }
    destruct Near as [Near|Near].
    - assert (Lp := L_lip i Hi s m). rewrite (Rabs_pos_eq (m - s)) in Lp by lra. apply Rabs_le_between in Lp.
      destruct (Rlt_dec (x i s - L i s) (far i)) as [Close|Away].
      + assert (v i * (m - s) <= x i m - x i s); [|lra].
        apply (rises (x i) (fun r => f i r + g i r * input p i)); [lra|intro; auto|]. intros r Hr.
        destruct (ode p r Hp ltac:(fold s; lra) (In r ltac:(lra)) i Hi) as (De & Fb & G1 & G2).
        split; [exact De|]. specialize (Ua Close). apply Rabs_le_between in Fb.
        assert (0 <= input p i) by nra.
        assert (gmin i * input p i <= g i r * input p i) by (apply Rmult_le_compat_r; lra). lra.
      + assert (- (F i + gmax i * push_ i) * (m - s) <= x i m - x i s); [|lra].
        apply (rises (x i) (fun r => f i r + g i r * input p i)); [lra|intro; auto|]. intros r Hr.
        destruct (ode p r Hp ltac:(fold s; lra) (In r ltac:(lra)) i Hi) as (De & Fb & G1 & G2).
        split; [exact De|]. assert (A := Gu r Hr). apply Rabs_le_between in Fb, A. lra.
    - assert (Lp := U_lip i Hi s m). rewrite (Rabs_pos_eq (m - s)) in Lp by lra. apply Rabs_le_between in Lp.
      destruct (Rlt_dec (U i s - x i s) (far i)) as [Close|Away].
      + assert (v i * (m - s) <= - x i m - - x i s); [|lra].
        apply (rises (fun t => - x i t) (fun r => - (f i r + g i r * input p i))); [lra|intro; apply continuity_pt_opp; auto|]. intros r Hr.
        destruct (ode p r Hp ltac:(fold s; lra) (In r ltac:(lra)) i Hi) as (De & Fb & G1 & G2).
        split; [exact (is_derive_opp _ _ _ De)|]. specialize (Uc Close). apply Rabs_le_between in Fb.
        assert (0 <= - input p i) by nra.
        assert (gmin i * - input p i <= g i r * - input p i) by (apply Rmult_le_compat_r; lra). lra.
      + assert (- (F i + gmax i * push_ i) * (m - s) <= - x i m - - x i s); [|lra].
        apply (rises (fun t => - x i t) (fun r => - (f i r + g i r * input p i))); [lra|intro; apply continuity_pt_opp; auto|]. intros r Hr.
        destruct (ode p r Hp ltac:(fold s; lra) (In r ltac:(lra)) i Hi) as (De & Fb & G1 & G2).
        split; [exact (is_derive_opp _ _ _ De)|]. assert (A := Gu r Hr). apply Rabs_le_between in Fb, A. lra.
  Qed.

  Lemma at_samples p : (p <= N)%nat -> keeps (INR p * h).
  Proof.
    induction p; intro Hp; [replace (INR 0 * h) with 0 by (cbn; ring); exact start|].
    rewrite S_INR, Rmult_plus_distr_r, Rmult_1_l. apply (period p); [lia|apply IHp; lia|]. lra.
  Qed.

  Theorem sampled_stays : forall p t, (p < N)%nat -> INR p * h <= t <= INR p * h + h -> keeps t.
  Proof. intros p t Hp Ht. apply (period p Hp); [apply at_samples; lia|exact Ht]. Qed.
End Sampled.

(* numbers under which the funnel law has what `law_ok` asks for: widths within [d, D] *)
Lemma law_far k a b near far d D gm F v : 0 < k -> 0 < gm -> 0 < near -> near <= a < far -> near <= b -> d <= a + b <= D -> 2 * far <= d ->
  F + v <= gm * (k * / far * ln ((d - far) / far)) -> F + v <= gm * law k a b.
Proof.
  intros Hk Hg Hn Ha Hb Hd Hf H. apply Rle_trans with (1 := H). apply Rmult_le_compat_l; [lra|].
  rewrite law_opp by lra. unfold law.
  replace (- (- k * (1 / b + 1 / a) * ln (b / a))) with (k * (1 / b + 1 / a) * ln (b / a)) by ring.
  assert (F0 : 0 < far) by lra.
  assert (1 <= (d - far) / far) by (apply Rcomplements.Rle_div_r; lra).
  assert (0 <= ln ((d - far) / far)) by (rewrite <- ln_1; apply Rcomplements.ln_le; lra).
  assert (Q : (d - far) / far <= b / a).
  { apply Rcomplements.Rle_div_l; [lra|]. apply (Rmult_le_reg_r a); [lra|].
    replace (b / a * far * a) with (b * far) by (field; lra). nra. }
  assert (ln ((d - far) / far) <= ln (b / a)) by (apply Rcomplements.ln_le; lra).
  assert (/ far <= / a) by (apply Rinv_le_contravar; lra).
  assert (0 < / b) by (apply Rinv_0_lt_compat; lra). assert (0 < / far) by (apply Rinv_0_lt_compat; lra).
  apply Rmult_le_compat; try lra; [apply Rmult_le_pos; lra|]. apply Rmult_le_compat_l; unfold Rdiv; lra.
Qed.

Lemma law_size k a b near D : 0 < k -> 0 < near -> near <= a -> near <= b -> a + b <= D ->
  Rabs (law k a b) <= k * (2 / near) * ln (D / near).
Proof.
  intros Hk Hn Ha Hb HD.
  assert (One : forall a b, near <= a -> near <= b -> a + b <= D -> ln (a / b) <= ln (D / near)).
  { intros p q Hp Hq Hpq. apply Rcomplements.ln_le; [apply Rdiv_lt_0_compat; lra|].
    apply Rmult_le_compat; try lra; [left; apply Rinv_0_lt_compat; lra|apply Rinv_le_contravar; lra]. }
  assert (Ab : Rabs (ln (a / b)) <= ln (D / near)).
  { apply Rabs_le; split; [|now apply One].
    replace (a / b) with (/ (b / a)) by (field; lra). rewrite ln_Rinv by (apply Rdiv_lt_0_compat; lra).
    apply Ropp_le_contravar, One; lra. }
  unfold law. rewrite !Rabs_mult, Rabs_Ropp, (Rabs_pos_eq k) by lra.
  assert (/ a <= / near) by (apply Rinv_le_contravar; lra). assert (/ b <= / near) by (apply Rinv_le_contravar; lra).
  assert (0 < / a) by (apply Rinv_0_lt_compat; lra). assert (0 < / b) by (apply Rinv_0_lt_compat; lra).
  apply Rmult_le_compat; [apply Rmult_le_pos; [lra|apply Rabs_pos]|apply Rabs_pos| |exact Ab].
  apply Rmult_le_compat_l; [lra|]. unfold Rdiv. rewrite Rabs_pos_eq; lra.
Qed.

