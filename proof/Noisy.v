(* What Sampled.law_ok asks for, from a law evaluated on edges and states known to within eta (rounded edges, sensors)
   and with relative error delta (the arithmetic of the law, logf). *)
From Coq Require Import Reals Lra Psatz Lia.
From Coquelicot Require Import Coquelicot.
From Stt Require Import Loop Sampled.
Open Scope R_scope.

Lemma noisy k a b a' b' near far d D gm F v eta delta theta :
  0 < k -> 0 < gm -> eta < near -> near <= a -> near <= b -> Rabs (a' - a) <= eta -> Rabs (b' - b) <= eta ->
  d <= a' + b' <= D -> 2 * (far + eta) <= d -> 0 <= delta < 1 -> Rabs theta <= delta -> 0 <= F + v ->
  F + v <= gm * (1 - delta) * (k * / (far + eta) * ln ((d - (far + eta)) / (far + eta))) ->
  Rabs (law k a' b' * (1 + theta)) <= (k * (2 / (near - eta)) * ln (D / (near - eta))) * (1 + delta) /\
  (a < far -> F + v <= gm * (law k a' b' * (1 + theta))) /\ (b < far -> F + v <= gm * - (law k a' b' * (1 + theta))).
Proof.
  intros Hk Hg He Ha Hb Ea Eb Hd Hf Hdl Ht Fv H.
  apply Rabs_le_between in Ea, Eb. assert (T := Ht). apply Rabs_le_between in T.
  assert (G : 0 < gm * (1 - delta)) by (apply Rmult_lt_0_compat; lra).
  assert (Up : forall l, F + v <= gm * (1 - delta) * l -> F + v <= gm * (l * (1 + theta))).
  { intros l Hl. apply Rle_trans with (1 := Hl).
    assert (0 <= l) by (apply Rnot_lt_le; intro C; assert (0 < gm * (1 - delta) * - l) by (apply Rmult_lt_0_compat; lra); lra).
    rewrite Rmult_assoc. apply Rmult_le_compat_l; [lra|]. rewrite Rmult_comm. apply Rmult_le_compat_l; lra. }
  split; [|split].
  - rewrite Rabs_mult. apply Rmult_le_compat; try apply Rabs_pos.
    + apply law_size; lra.
    + eapply Rle_trans; [apply Rabs_triang|]. rewrite Rabs_R1. lra.
  - intro Cl. apply Up. apply (law_far k a' b' (near - eta) (far + eta) d D); auto; lra.
  - intro Cl. rewrite law_opp by lra. replace (- (- law k b' a' * (1 + theta))) with (law k b' a' * (1 + theta)) by ring.
    apply Up. apply (law_far k b' a' (near - eta) (far + eta) d D); auto; lra.
Qed.
