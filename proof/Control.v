(* The emitted functions run: `control` and `control_tick` always end, without anything that C leaves undefined, and what they store is this formula. *)
From Coq Require Import ZArith List String Bool Ascii Lia.
From Stt Require Import Syntax Run Emission.
Import ListNotations.
Open Scope string_scope.
Open Scope list_scope.

(* The constants that component i goes by: where clamps differ, its own. *)
Definition of_component (k : constants) (i : Z) : constants :=
  Constants (dimensions k) (rate k) (last k) (gain_upper k) (gain_lower k) (gain_table k) (limit_table k)
    (if clamps_differ k then nth (Z.to_nat i) (clamp_table k) zero else clamp k) (clamp_table k) (single k) (written_out k) (tick_constants k).

Section Formulas.
  Variable A : arithmetic.
  Variable k : constants.
  Notation F := (float A).
  Let lit := literal A.

  Definition spline_time (t : F) : F :=
    let started := if less A (lit zero) t then t else lit zero in
    let scaled := mul A started (lit (rate k)) in
    if less A scaled (lit (last k)) then scaled else lit (last k).
  Definition place (u : F) (segment : Z) : F := sub A u (of_integer A segment).

  (* of a count of ticks: how many of the divisor's are passed, the segment, and the part of it *)
  Definition tick_place (c : tick_numbers) (tick : Z) : Z := Z.min (Z.min tick (tick_limit c) * tick_multiplier c) (tick_divisor c * tick_segments c).
  Definition tick_segment (c : tick_numbers) (tick : Z) : Z := Z.min (tick_place c tick / tick_divisor c) (tick_segments c - 1).
  Definition tick_rest (c : tick_numbers) (tick : Z) : Z := (tick_place c tick - tick_segment c tick * tick_divisor c)%Z.
  Definition share_of_tick (c : tick_numbers) (tick : Z) : F := div A (of_integer A (tick_rest c tick)) (lit (tick_share c)).

  Definition v0 s := sub A (lit one) s.
  Definition v5 s := mul A (lit three) (add A (lit one) (mul A (v0 s) s)).
  Definition weight0 s := mul A (mul A (v0 s) (v0 s)) (v0 s).
  Definition weight1 s := add A (lit one) (mul A (v0 s) (v5 s)).
  Definition weight2 s := add A (lit one) (mul A s (v5 s)).
  Definition weight3 s := mul A (mul A s s) s.
  Definition blend (w0 w1 w2 w3 q0 q1 q2 q3 : F) : F := add A (add A (mul A w0 q0) (mul A w1 q1)) (add A (mul A w2 q2) (mul A w3 q3)).

  Definition edge (s q0 q1 q2 q3 : F) : F := blend (weight0 s) (weight1 s) (weight2 s) (weight3 s) q0 q1 q2 q3.

  Definition upper_nearer (L U x : F) : bool := less A (sub A U x) (sub A x L).
  Definition nearest (L U x : F) : F := if upper_nearer L U x then sub A U x else sub A x L.
  Definition near (L U x : F) : F :=
    let least := mul A (sub A U L) (lit (clamp k)) in if less A least (nearest L U x) then nearest L U x else least.
  Definition far (L U x : F) : F := sub A (sub A U L) (near L U x).
  Definition ratio (L U x : F) : F := div A (far L U x) (near L U x).
  (* ln y where it is written out: y = m 2^e *)
  Definition written_log (y : F) : F :=
    let m := mantissa_of A y in
    let s := div A (sub A m (lit one)) (add A m (lit one)) in
    let around := add A (mul A (mul A s s) (lit (bend k))) (lit two) in
    add A (mul A (of_integer A (exponent_of A y)) (lit (ln_two k))) (mul A s around).
  Definition log_of (y : F) : F := if written_out k then written_log y else logarithm A y.
  Definition epsilon (L U x : F) : F := opp A (log_of (ratio L U x)).
  Definition xi (L U x : F) : F := div A (add A (lit one) (ratio L U x)) (far L U x).
  (* the gain of a component where the upper edge is nearer, and where the lower one is *)
  Definition own (table : list decimal) (i : Z) : F := lit (nth (Z.to_nat i) table zero).
  Definition high_gain (i : Z) : F := if several k then opp A (own (gain_table k) i) else lit (gain_upper k).
  Definition low_gain (i : Z) : F := if several k then own (gain_table k) i else lit (gain_lower k).
  Definition gain (high low L U x : F) : F := if upper_nearer L U x then high else low.
  Definition push (high low L U x : F) : F := opp A (mul A (mul A (gain high low L U x) (xi L U x)) (epsilon L U x)).
  (* v held within a limit *)
  Definition saturated (m v : F) : F := let raised := if less A (opp A m) v then v else opp A m in if less A m raised then m else raised.
  Definition is_within (L U x : F) : bool := less A (lit zero) (nearest L U x).
End Formulas.
Definition control_input (A : arithmetic) (k : constants) (i : Z) (L U x : float A) : float A :=
  let v := push A (of_component k i) (high_gain A k i) (low_gain A k i) L U x in if limited k then saturated A (own A (limit_table k) i) v else v.

(* what an array holds at the end: the newest store *)
Fixpoint stored {A} (x : string) (i : Z) (out : stores A) : option (float A) :=
  match out with [] => None | (y, j, v) :: r => if String.eqb x y then if (i =? j)%Z then Some v else stored x i r else stored x i r end.

Ltac reduce := cbv beta iota zeta delta
  [exponent_function mantissa_function segment_function segment_at_tick_function basis_function blend_function transformed_error_function law_function tube_function control_function control_tick_function
   kernel_of enter bind of_type parameters code run run_block expression_value value_of values_of get put put_all binary select results_of leave
   String.eqb Ascii.eqb Bool.eqb app rev List.length skipn Nat.sub negb
   common_statements inputs_statements inside_statements place_statements lower_statements upper_statements law_statements clamp_statements gain_statements limit_statements held_statements control_body tube_body inputs_body blended
   library log_name].

(* The integers of a text with ticks stay within 31 bits. *)
Definition ticks_small (c : tick_numbers) : Prop := (0 < tick_multiplier c <= 2147483647 /\ 0 < tick_divisor c /\ 0 < tick_segments c /\ 0 <= tick_limit c <= 2147483647 /\
  tick_limit c * tick_multiplier c <= 2147483647 /\ tick_divisor c * tick_segments c <= 2147483647)%Z.
Lemma tick_range c tick : ticks_small c -> (0 <= tick)%Z ->
  (0 <= tick_place c tick <= tick_divisor c * tick_segments c /\ 0 <= tick_segment c tick < tick_segments c /\ 0 <= tick_rest c tick <= tick_divisor c)%Z.
Proof.
  intros ([M _] & D & K & L & LM & DK) T. unfold tick_rest.
  assert (P : (0 <= tick_place c tick <= tick_divisor c * tick_segments c)%Z) by (unfold tick_place; nia).
  assert (Dv := Z.div_mod (tick_place c tick) (tick_divisor c) ltac:(lia)). assert (Md := Z.mod_pos_bound (tick_place c tick) (tick_divisor c) D).
  assert (Q0 : (0 <= tick_place c tick / tick_divisor c)%Z) by (apply Z.div_pos; lia).
  split; [exact P|]. unfold tick_segment.
  destruct (Z.min_spec (tick_place c tick / tick_divisor c) (tick_segments c - 1)) as [[C ->]|[C ->]]; split; nia.
Qed.
Lemma if_less (a b : Z) : (if (a <? b)%Z then a else b) = Z.min a b.
Proof. destruct (Z.ltb_spec a b); lia. Qed.

(* ------------------------------------------------------------------ the kernels *)
Section Kernels.
  Variable A : arithmetic.
  Variable k : constants.
  Notation F := (float A).
  Variable ks : list (string * kernel A).

  Lemma segment_runs t segment : to_integer A (spline_time A k t) = Some segment ->
    (-2147483648 <= segment <= 2147483647)%Z -> (-2147483648 <= 2 * dimensions k <= 2147483647)%Z ->
    (-2147483648 <= segment * (2 * dimensions k) <= 2147483647)%Z ->
    kernel_of A ks (fun _ _ => None) (segment_function k) [R_ t] =
    Some ([I_ (segment * (2 * dimensions k))%Z; R_ (place A (spline_time A k t) segment)], None).
  Proof.
    intros E H1 H2 H3. unfold spline_time in E. cbv zeta in E.
    reduce. rewrite E. repeat (rewrite !int32_ok by assumption; cbv beta iota). reflexivity.
  Qed.
  Lemma segment_at_tick_runs c tick : ticks_small c -> (0 <= tick <= 4294967295)%Z -> (0 < dimensions k /\ 2 * dimensions k * tick_segments c <= 2147483647)%Z ->
    kernel_of A ks (fun _ _ => None) (segment_at_tick_function k c) [U_ tick] =
    Some ([I_ (tick_segment c tick * (2 * dimensions k))%Z; R_ (share_of_tick A c tick)], None).
  Proof.
    intros S T N. assert (R := tick_range c tick S (proj1 T)). destruct R as ([P1 P2] & [S1 S2] & [R1 R2]). destruct S as ([M M1] & D & K & [L0 L1] & LM & DK).
    assert (Q : Z.quot (tick_place c tick) (tick_divisor c) = (tick_place c tick / tick_divisor c)%Z) by (apply Z.quot_div_nonneg; lia).
    assert (W : (-2147483648 <= tick_place c tick / tick_divisor c <= 2147483647)%Z).
    { split; [apply Z.le_trans with 0%Z; [lia|apply Z.div_pos; lia]|]. apply Z.le_trans with (tick_place c tick); [apply Z.div_le_upper_bound; nia|lia]. }
    assert (Z1 : (-2147483648 <= Z.min tick (tick_limit c) <= 2147483647)%Z) by lia.
    assert (Z2 : (-2147483648 <= Z.min tick (tick_limit c) * tick_multiplier c <= 2147483647)%Z) by nia.
    assert (Z3 : (-2147483648 <= tick_segment c tick * tick_divisor c <= 2147483647)%Z) by nia.
    assert (Z4 : (-2147483648 <= tick_segment c tick * (2 * dimensions k) <= 2147483647)%Z) by nia.
    assert (Z5 : (-2147483648 <= tick_rest c tick <= 2147483647)%Z) by nia.
    assert (Z6 : (0 < dimensions k /\ 2 * dimensions k <= 2147483647)%Z) by nia.
    assert (Z8 : (tick_divisor c <= 2147483647 /\ tick_segments c <= 2147483647)%Z) by nia.
    assert (Z9 : (0 <= tick_divisor c * tick_segments c)%Z) by nia.
    reduce. rewrite uint32_ok by lia. cbv beta iota. rewrite if_less, !int32_ok by lia. cbv beta iota.
    rewrite if_less. fold (tick_place c tick). rewrite (proj2 (Z.ltb_lt _ _) D), Q, int32_ok by exact W. cbv beta iota. rewrite !int32_ok by lia. cbv beta iota. rewrite if_less. fold (tick_segment c tick).
    rewrite int32_ok by exact Z3. cbv beta iota. fold (tick_rest c tick). rewrite int32_ok by exact Z5. cbv beta iota. rewrite int32_ok by lia. cbv beta iota. rewrite int32_ok by exact Z4. reflexivity.
  Qed.
  Lemma basis_runs s : kernel_of A ks (fun _ _ => None) basis_function [R_ s] =
    Some ([R_ (weight0 A s); R_ (weight1 A s); R_ (weight2 A s); R_ (weight3 A s)], None).
  Proof. reflexivity. Qed.
  Lemma blend_runs w0 w1 w2 w3 q0 q1 q2 q3 :
    kernel_of A ks (fun _ _ => None) blend_function [R_ w0; R_ w1; R_ w2; R_ w3; R_ q0; R_ q1; R_ q2; R_ q3] =
    Some ([], Some (R_ (blend A w0 w1 w2 w3 q0 q1 q2 q3))).
  Proof. reflexivity. Qed.
  Lemma law_runs g x e : kernel_of A ks (fun _ _ => None) law_function [R_ g; R_ x; R_ e] = Some ([], Some (R_ (opp A (mul A (mul A g x) e)))).
  Proof. reflexivity. Qed.
  Definition log_kernels := if written_out k
    then [("@mantissa", kernel_of A (("@exponent", kernel_of A (library A (log_name k)) (fun _ _ => None) exponent_function) :: library A (log_name k)) (fun _ _ => None) mantissa_function);
          ("@exponent", kernel_of A (library A (log_name k)) (fun _ _ => None) exponent_function)] ++ library A (log_name k)
    else library A (log_name k).
  Lemma transformed_error_runs f0 f1 segments_ a b : (exists f2, segments_ = [("@segment", f2)]) \/ (exists f2 f3, segments_ = [("@segment_at_tick", f3); ("@segment", f2)]) ->
    kernel_of A (("@blend", f0) :: ("@basis", f1) :: segments_ ++ log_kernels) (fun _ _ => None) (transformed_error_function k) [R_ a; R_ b] =
    Some ([R_ (opp A (log_of A k (div A b a))); R_ (div A (add A (literal A one) (div A b a)) b)], None).
  Proof.
    unfold transformed_error_function, log_kernels, logarithm_statements, log_of, log_name.
    intros [[f2 ->]|(f2 & f3 & ->)]; (destruct (written_out k); [|destruct (single k)]; reflexivity).
  Qed.
End Kernels.

(* ------------------------------------------------------------------ their callers *)
Section Callers.
  Variable A : arithmetic.
  Variable k : constants.
  Notation F := (float A).
  Let lit := literal A.
  Variables basis_ blend_ transformed_error_ law_ : kernel A.
  Variable kernels : list (string * kernel A).
  Hypothesis basis_there : get "@basis" kernels = Some basis_.
  Hypothesis blend_there : get "@blend" kernels = Some blend_.
  Hypothesis transformed_error_there : get "@transformed_error" kernels = Some transformed_error_.
  Hypothesis law_there : get "@law" kernels = Some law_.

  (* the place, wherever it comes from: a segment, and s in it *)
  Variables (segment K : Z) (s : F) (q x : Z -> F) (arrays : string -> Z -> option F).
  Let n := dimensions k.
  Let row := (segment * (2 * n))%Z.

  Hypothesis segment_range : (0 <= segment < K)%Z.
  Hypothesis small : (0 < n /\ 2 * n * (K + 3) <= 2147483647)%Z.
  Hypothesis basis_does : basis_ [R_ s] = Some ([R_ (weight0 A s); R_ (weight1 A s); R_ (weight2 A s); R_ (weight3 A s)], None).
  Hypothesis blend_does : forall w0 w1 w2 w3 q0 q1 q2 q3,
    blend_ [R_ w0; R_ w1; R_ w2; R_ w3; R_ q0; R_ q1; R_ q2; R_ q3] = Some ([], Some (R_ (blend A w0 w1 w2 w3 q0 q1 q2 q3))).
  Hypothesis transformed_error_does : forall a b, transformed_error_ [R_ a; R_ b] =
    Some ([R_ (opp A (log_of A k (div A b a))); R_ (div A (add A (literal A one) (div A b a)) b)], None).
  Hypothesis law_does : forall g x e, law_ [R_ g; R_ x; R_ e] = Some ([], Some (R_ (opp A (mul A (mul A g x) e)))).
  Hypothesis table : forall z, (0 <= z < 2 * n * (K + 3))%Z -> arrays "@coefficients" z = Some (q z).

  Definition lower (i : Z) : F := let at_ := (row + i * 2)%Z in edge A s (q at_) (q (at_ + 2 * n)) (q (at_ + 4 * n)) (q (at_ + 6 * n)).
  Definition upper (i : Z) : F := let at_ := (row + i * 2)%Z in edge A s (q (at_ + 1)) (q (at_ + (2 * n + 1))) (q (at_ + (4 * n + 1))) (q (at_ + (6 * n + 1))).

  Definition places (rest : environment A) : environment A :=
    ("w3", R_ (weight3 A s)) :: ("w2", R_ (weight2 A s)) :: ("w1", R_ (weight1 A s)) :: ("w0", R_ (weight0 A s)) :: ("s", R_ s) :: ("row", I_ row) :: rest.

  (* one statement after the other; v is found by evaluating *)
  Lemma let_step ty y e r env out v o : expression_value A kernels arrays env e = Some v -> of_type A ty v = true ->
    run_block A (run A kernels arrays) r ((y, v) :: env) out = o -> run_block A (run A kernels arrays) (Let ty y e :: r) env out = o.
  Proof. intros E T H. cbn [run_block run]. now rewrite E, T. Qed.
  Lemma set_step y e r env env' out v o : expression_value A kernels arrays env e = Some v -> put A y v env = Some env' ->
    run_block A (run A kernels arrays) r env' out = o -> run_block A (run A kernels arrays) (Set_ y e :: r) env out = o.
  Proof. intros E T H. cbn [run_block run]. now rewrite E, T. Qed.
  Lemma declare_step ty y r env out o :
    run_block A (run A kernels arrays) r ((y, Nothing) :: env) out = o -> run_block A (run A kernels arrays) (Declare ty y :: r) env out = o.
  Proof. intros H. exact H. Qed.
  Lemma call_step f a ys r env env' out kf vs rs o : get f kernels = Some kf -> values_of A env a = Some vs -> kf vs = Some (rs, None) ->
    put_all A ys rs env = Some env' -> run_block A (run A kernels arrays) r env' out = o -> run_block A (run A kernels arrays) (Call f a ys :: r) env out = o.
  Proof. intros G V C P H. cbn [run_block run]. now rewrite G, V, C, P. Qed.
  Lemma store_step y i e r env out j v w o : value_of A env i = Some (I_ j) -> expression_value A kernels arrays env e = Some (R_ v) -> arrays y j = Some w ->
    run_block A (run A kernels arrays) r env ((y, j, v) :: out) = o -> run_block A (run A kernels arrays) (Store y i e :: r) env out = o.
  Proof. intros I E T H. cbn [run_block run]. now rewrite I, E, T. Qed.
  Lemma loop_step y m body r env out env' out' o : run_loop A (run A kernels arrays) y body (Z.to_nat m) 0 env out = Some (env', out', None) ->
    run_block A (run A kernels arrays) r env' out' = o -> run_block A (run A kernels arrays) (For y m body :: r) env out = o.
  Proof. intros E H. cbn [run_block run]. now rewrite E. Qed.
  Lemma pass_step c body r env out o : value_of A env c = Some (B_ false) ->
    run_block A (run A kernels arrays) r env out = o -> run_block A (run A kernels arrays) (When c body :: r) env out = o.
  Proof. intros E H. cbn [run_block run]. now rewrite E. Qed.
  Lemma return_step e r env out v : expression_value A kernels arrays env e = Some v ->
    run_block A (run A kernels arrays) (Return (Some e) :: r) env out = Some (env, out, Some (Some v)).
  Proof. intros E. cbn [run_block run]. now rewrite E. Qed.

  Hypothesis inputs : forall i, (0 <= i < n)%Z -> arrays "x" i = Some (x i).
  Hypothesis outputs : forall i, (0 <= i < n)%Z -> exists w, arrays "u" i = Some w.
  Hypothesis gains_there : several k = true -> forall i, (0 <= i < n)%Z -> arrays "@gain" i = Some (own A (gain_table k) i).
  Hypothesis clamps_there : clamps_differ k = true -> forall i, (0 <= i < n)%Z -> arrays "@least_share" i = Some (own A (clamp_table k) i).
  Hypothesis limits_there : limited k = true -> forall i, (0 <= i < n)%Z -> arrays "@u_max" i = Some (own A (limit_table k) i).

  (* the variables before the loop; those below belong to `control` or to `control_tick` alone *)
  Variable below : environment A.
  Definition checked (z : F) (f : bool) : environment A := ("bad", B_ (negb f)) :: ("finite", B_ f) :: ("zero", R_ z) :: below.

  (* a block is left by dropping what is newer, however much there is below *)
  Inductive ends (inner : environment A) : environment A -> Prop := here : ends inner inner | later v l : ends inner l -> ends inner (v :: l).
  Lemma leave_ends outer inner l : ends inner l -> List.length inner = List.length outer -> leave A outer l = inner.
  Proof.
    intros E Ln. assert (G : exists front, l = front ++ inner) by (induction E as [|v l E [front ->]]; [now exists []|now exists (v :: front)]).
    destruct G as [front ->]. unfold leave. rewrite app_length, Ln, Nat.add_sub. clear. induction front; [reflexivity|exact IHfront].
  Qed.
  Ltac left_is := apply leave_ends; [repeat first [apply here | apply later] | reflexivity].

  (* the variables of its loop once the edges are known, before anything that differs from text to text *)
  Definition known (i : Z) (outside : bool) (z : F) (f : bool) : environment A :=
    let at_ := (row + i * 2)%Z in
    [("upper_edge", R_ (upper i)); ("upper_q3", R_ (q (at_ + (6 * n + 1)))); ("upper_3", I_ (at_ + (6 * n + 1))%Z);
     ("upper_q2", R_ (q (at_ + (4 * n + 1)))); ("upper_2", I_ (at_ + (4 * n + 1))%Z); ("upper_q1", R_ (q (at_ + (2 * n + 1)))); ("upper_1", I_ (at_ + (2 * n + 1))%Z);
     ("upper_q0", R_ (q (at_ + 1))); ("upper_0", I_ (at_ + 1)%Z);
     ("lower_edge", R_ (lower i)); ("lower_q3", R_ (q (at_ + 6 * n))); ("lower_3", I_ (at_ + 6 * n)%Z);
     ("lower_q2", R_ (q (at_ + 4 * n))); ("lower_2", I_ (at_ + 4 * n)%Z); ("lower_q1", R_ (q (at_ + 2 * n))); ("lower_1", I_ (at_ + 2 * n)%Z);
     ("lower_q0", R_ (q at_)); ("at", I_ at_); ("pair", I_ (i * 2)%Z); ("i", I_ i); ("outside", B_ outside)] ++
    places (checked z f).
  (* in one pass, for every pass leaves a term in the proof *)
  Ltac evaluate := cbv beta iota zeta delta [expression_value]; rewrite ?blend_there, ?law_there; cbv beta iota zeta delta
    [places known checked expression_value value_of values_of get binary select String.eqb Ascii.eqb Bool.eqb negb app];
    repeat first [ rewrite int32_ok by (unfold row, n in *; nia) | rewrite table by (unfold row, n in *; nia) | rewrite inputs by assumption
                 | rewrite gains_there by first [assumption | reflexivity] | rewrite clamps_there by first [assumption | reflexivity] | rewrite limits_there by first [assumption | reflexivity]
                 | rewrite blend_does | rewrite law_does ]; reflexivity.
  Ltac step := first
    [ eapply let_step; [evaluate|reflexivity|]
    | eapply set_step; [evaluate|reflexivity|]
    | apply declare_step ].
  (* the same with a name for the value, so that terms stay small *)
  Ltac named v := eapply (let_step _ _ _ _ _ _ v); [first [reflexivity | evaluate]|reflexivity|].

  Lemma edges_run i outside z f rest out : (0 <= i < n)%Z ->
    run_block A (run A kernels arrays) (lower_statements k ++ upper_statements k ++ rest) (("i", I_ i) :: ("outside", B_ outside) :: places (checked z f)) out =
    run_block A (run A kernels arrays) rest (known i outside z f) out.
  Proof.
    intro Hi. cbv [lower_statements upper_statements app blended]. do 9 step. named (R_ (lower i)). do 8 step. named (R_ (upper i)). reflexivity.
  Qed.

  Lemma body_runs i outside z f out : (0 <= i < n)%Z ->
    exists inner, run_block A (run A kernels arrays) (control_body k) (("i", I_ i) :: ("outside", B_ outside) :: places (checked z f)) out =
      Some (inner, ("u", i, control_input A k i (lower i) (upper i) (x i)) :: out, None) /\
      leave A (("outside", B_ outside) :: places (checked z f)) inner =
      ("outside", B_ (if is_within A (lower i) (upper i) (x i) then outside else true)) :: places (checked z f).
  Proof.
    intro Hi. destruct (outputs i Hi) as [w Hw]. unfold control_body. rewrite edges_run by exact Hi.
    set (L := lower i). set (U := upper i).
    unfold law_statements, clamp_statements, gain_statements, limit_statements, held_statements, control_input, high_gain, low_gain. cbv zeta.
    unfold of_component. destruct (several k) eqn:Sv; destruct (limited k) eqn:Li; destruct (clamps_differ k) eqn:Cd;
      match goal with |- context [push A ?o ?h ?l] => set (own_k := o); set (high := h); set (low := l) end; (eexists; split;
      [ cbn [app]; step;
        (* a table of clamps *)
        try named (R_ (own A (clamp_table k) i));
        (* one of gains *)
        try (named (R_ low); named (R_ high));
        do 3 step; named (@B_ A (upper_nearer A L U (x i))); named (R_ (nearest A L U (x i))); named (R_ (gain A high low L U (x i)));
        do 2 step; named (R_ (near A own_k L U (x i))); named (R_ (far A own_k L U (x i))); named (@B_ A (is_within A L U (x i))); step;
        try named (R_ (own A (limit_table k) i)); do 2 step;
        (eapply call_step with (rs := [R_ (epsilon A own_k L U (x i)); R_ (xi A own_k L U (x i))]);
          [exact transformed_error_there|reflexivity|apply transformed_error_does|reflexivity|]);
        named (R_ (push A own_k high low L U (x i)));
        (* one of limits *)
        try (do 4 step; named (R_ (saturated A (own A (limit_table k) i) (push A own_k high low L U (x i)))));
        (eapply store_step; [reflexivity|evaluate|exact Hw|]);
        (eapply set_step; [evaluate|reflexivity|]); reflexivity
      | left_is ]).
  Qed.

  (* the test of the inputs: what there is to begin with and every x, times 0 and added up *)
  Variable first : F.
  Fixpoint zeros (m : nat) : F := match m with O => first | S m => add A (zeros m) (mul A (x (Z.of_nat m)) (lit zero)) end.
  Definition number_of_dimensions := Z.to_nat n.
  Hypothesis finite_inputs : at_most A (zeros number_of_dimensions) (lit zero) = true.

  Fixpoint outside_after (m : nat) : bool :=
    match m with O => false | S m => let i := Z.of_nat m in if is_within A (lower i) (upper i) (x i) then outside_after m else true end.

  Lemma inputs_run : exists out env,
    run_loop A (run A kernels arrays) "j" inputs_body (Z.to_nat n) 0 (("zero", R_ first) :: below) [] = Some (env, out, None) /\
    env = ("zero", R_ (zeros number_of_dimensions)) :: below /\ out = [].
  Proof.
    destruct (run_loop_keeps A kernels arrays "j" inputs_body
      (fun j env out => env = ("zero", R_ (zeros (Z.to_nat j))) :: below /\ out = []) (Z.to_nat n) 0 (("zero", R_ first) :: below) []) as (env & out & E & H1 & H2).
    - intros j env out Hj [-> ->]. assert (Hi : (0 <= j < n)%Z) by (unfold n in *; lia).
      do 2 eexists. split; [|split; [|reflexivity]].
      + unfold inputs_body. do 4 step. reflexivity.
      + replace (Z.to_nat (j + 1)) with (S (Z.to_nat j)) by lia. cbn [zeros]. rewrite Z2Nat.id by lia. left_is.
    - split; reflexivity.
    - exists out, env. split; [exact E|]. split; [|exact H2]. rewrite H1. now rewrite Z.add_0_l, Nat2Z.id.
  Qed.

  Lemma stored_other y i j v (out : stores A) : (i =? j)%Z = false -> stored (A := A) y i ((y, j, v) :: out) = stored (A := A) y i out.
  Proof. intro E. cbn [stored]. now rewrite String.eqb_refl, E. Qed.
  Lemma stored_same y i v (out : stores A) : stored (A := A) y i ((y, i, v) :: out) = Some v.
  Proof. cbn [stored]. now rewrite String.eqb_refl, Z.eqb_refl. Qed.

  Lemma bodies_run z f : exists out env,
    run_loop A (run A kernels arrays) "i" (control_body k) (Z.to_nat n) 0 (("outside", B_ false) :: places (checked z f)) [] = Some (env, out, None) /\
    env = ("outside", B_ (outside_after number_of_dimensions)) :: places (checked z f) /\
    forall i, (0 <= i < n)%Z -> stored (A := A) "u" i out = Some (control_input A k i (lower i) (upper i) (x i)).
  Proof.
    destruct (run_loop_keeps A kernels arrays "i" (control_body k)
      (fun j env out => env = ("outside", B_ (outside_after (Z.to_nat j))) :: places (checked z f) /\
         forall i, (0 <= i < j)%Z -> stored (A := A) "u" i out = Some (control_input A k i (lower i) (upper i) (x i))) (Z.to_nat n) 0
      (("outside", B_ false) :: places (checked z f)) []) as (env & out & E & H1 & H2).
    - intros j env out Hj [-> St]. assert (Hi : (0 <= j < n)%Z) by (unfold n in *; lia).
      destruct (body_runs j (outside_after (Z.to_nat j)) z f out Hi) as (inner & E & Lv).
      do 2 eexists. split; [exact E|split].
      + rewrite Lv. replace (Z.to_nat (j + 1)) with (S (Z.to_nat j)) by lia. cbn [outside_after]. now rewrite Z2Nat.id by lia.
      + intros i Hij. destruct (Z.eqb_spec i j) as [->|Ne]; [apply stored_same|].
        rewrite stored_other by now apply Z.eqb_neq. apply St; lia.
    - split; [reflexivity|]. intros; lia.
    - exists out, env. split; [exact E|]. rewrite Z.add_0_l in H1, H2. rewrite Nat2Z.id in H1. split; [exact H1|].
      intros i Hi. apply H2. unfold n in *; lia.
  Qed.

  (* The place comes from a kernel of the time or the count of ticks. *)
  Variables (name clock : string) (segment_ : kernel A) (value : value A).
  Hypothesis segment_there : get name kernels = Some segment_.
  Hypothesis clock_there : forall z f, values_of A (("s", Nothing) :: ("row", Nothing) :: checked z f) [Name clock] = Some [value].
  Hypothesis segment_does : segment_ [value] = Some ([I_ row; R_ s], None).

  Theorem common_runs : exists out env,
    run_block A (run A kernels arrays) (common_statements k name clock) (("zero", R_ first) :: below) [] =
      Some (env, out, Some (Some (I_ (if outside_after number_of_dimensions then 1 else 0)%Z))) /\
    forall i, (0 <= i < n)%Z -> stored (A := A) "u" i out = Some (control_input A k i (lower i) (upper i) (x i)).
  Proof.
    destruct (bodies_run (zeros number_of_dimensions) true) as (out & env & E & -> & St).
    destruct inputs_run as (out0 & env0 & E0 & -> & ->).
    exists out. eexists. split; [|exact St].
    cbv [common_statements inputs_statements inside_statements place_statements app].
    eapply loop_step; [exact E0|].
    eapply let_step; [reduce; fold lit; rewrite finite_inputs; reflexivity|reflexivity|].
    eapply let_step; [evaluate|reflexivity|].
    eapply pass_step; [evaluate|].
    do 2 step.
    eapply call_step; [exact segment_there|exact (clock_there (zeros number_of_dimensions) true)|exact segment_does|reduce; reflexivity|].
    do 4 step.
    eapply call_step; [exact basis_there|reduce; reflexivity|exact basis_does|reduce; reflexivity|].
    step.
    eapply loop_step; [exact E|].
    apply return_step. unfold places. reduce. rewrite !int32_ok by lia. reflexivity.
  Qed.
End Callers.

(* ------------------------------------------------------------------ the whole text *)

Section Execute.
  Variable A : arithmetic.
  Variables (k : constants) (coefficients : list decimal).
  Notation F := (float A).
  Let n := dimensions k.
  Variables (segment K : Z) (s : F) (x : Z -> F).
  Variable lines : list string. (* directives, which the evaluator does not read *)
  Let program := Source lines (emitted_tables k coefficients) (emitted k).
  Hypothesis segment_range : (0 <= segment < K)%Z.
  Hypothesis small : (0 < n /\ 2 * n * (K + 3) <= 2147483647)%Z.
  Hypothesis table_length : (Z.of_nat (List.length coefficients) = 2 * n * (K + 3))%Z.
  Hypothesis gains_length : several k = true -> Z.of_nat (List.length (gain_table k)) = n.
  Hypothesis clamps_length : clamps_differ k = true -> Z.of_nat (List.length (clamp_table k)) = n.
  Hypothesis limits_length : limited k = true -> Z.of_nat (List.length (limit_table k)) = n.

  Definition q (z : Z) : F := literal A (nth (Z.to_nat z) coefficients zero).
  (* `x` and `u` have n places *)
  Definition places_of (name : string) (i : Z) : option F := if (0 <=? i)%Z then if (i <? n)%Z then Some (x i) else None else None.
  Let L i := lower A k segment s q i.
  Let U i := upper A k segment s q i.

  Lemma get_coefficients : get "@coefficients" (tables program) = Some coefficients.
  Proof. reflexivity. Qed.
  Lemma get_gains : several k = true -> get "@gain" (tables program) = Some (gain_table k).
  Proof. intro H. unfold program, emitted_tables. cbn [tables]. rewrite H. reflexivity. Qed.
  Lemma get_clamps : clamps_differ k = true -> get "@least_share" (tables program) = Some (clamp_table k).
  Proof. intro H. unfold program, emitted_tables. cbn [tables]. rewrite H. destruct (several k); reflexivity. Qed.
  Lemma get_limits : limited k = true -> get "@u_max" (tables program) = Some (limit_table k).
  Proof. intro H. unfold program, emitted_tables. cbn [tables]. rewrite H. destruct (several k), (clamps_differ k); reflexivity. Qed.
  Lemma get_other y : existsb (String.eqb y) kept_tables = false -> get y (tables program) = None.
  Proof.
    cbn [existsb kept_tables]. rewrite !orb_false_iff. intros (H1 & H2 & H3 & H4 & _). unfold program, emitted_tables, get. cbn [tables].
    destruct (several k), (clamps_differ k), (limited k); cbn [app]; now rewrite ?H1, ?H2, ?H3, ?H4.
  Qed.
  Lemma table_entry (l : list decimal) z : (0 <= z < Z.of_nat (List.length l))%Z ->
    (if (z <? 0)%Z then None else match nth_error l (Z.to_nat z) with Some v => Some (literal A v) | None => None end) = Some (literal A (nth (Z.to_nat z) l zero)).
  Proof. intro H. replace (z <? 0)%Z with false by (symmetry; apply Z.ltb_ge; lia). rewrite (nth_error_nth' _ zero) by lia. reflexivity. Qed.
  Lemma places_there y i : (0 <= i < n)%Z -> places_of y i = Some (x i).
  Proof. intros [H1 H2]. unfold places_of. apply Z.leb_le in H1. apply Z.ltb_lt in H2. now rewrite H1, H2. Qed.

  Lemma kernels_after f rest : f <> "@exponent" -> f <> "@mantissa" -> all_kernels A (filter (fun g => negb (String.eqb (title g) f)) (helpers k ++ rest)) (library A (log_name k)) =
    all_kernels A (filter (fun g => negb (String.eqb (title g) f)) rest) (log_kernels A k).
  Proof.
    intros H1 H2. apply not_eq_sym in H1, H2. apply String.eqb_neq in H1, H2. unfold helpers, log_kernels. destruct (written_out k); [|reflexivity].
    cbn [app filter title exponent_function mantissa_function]. rewrite H1, H2. reflexivity.
  Qed.
  Lemma found_after f rest : f <> "@exponent" -> f <> "@mantissa" ->
    List.find (fun g => String.eqb (title g) f) (helpers k ++ rest) = List.find (fun g => String.eqb (title g) f) rest.
  Proof.
    intros H1 H2. apply not_eq_sym in H1, H2. apply String.eqb_neq in H1, H2. unfold helpers. destruct (written_out k); [|reflexivity].
    cbn [app List.find title exponent_function mantissa_function]. now rewrite H1, H2.
  Qed.

  Definition arrays_of (y : string) (i : Z) : option F :=
    match get y (tables program) with
    | Some t => if (i <? 0)%Z then None else match nth_error t (Z.to_nat i) with Some v => Some (literal A v) | None => None end
    | None => places_of y i
    end.

  (* What is stored once the place is known. *)
  Section Common.
    Variables (kernels : list (string * kernel A)) (basis_ blend_ transformed_error_ law_ segment_ : kernel A).
    Hypothesis there : get "@basis" kernels = Some basis_ /\ get "@blend" kernels = Some blend_ /\ get "@transformed_error" kernels = Some transformed_error_ /\ get "@law" kernels = Some law_.
    Hypothesis basis_does : basis_ [R_ s] = Some ([R_ (weight0 A s); R_ (weight1 A s); R_ (weight2 A s); R_ (weight3 A s)], None).
    Hypothesis blend_does : forall w0 w1 w2 w3 q0 q1 q2 q3,
      blend_ [R_ w0; R_ w1; R_ w2; R_ w3; R_ q0; R_ q1; R_ q2; R_ q3] = Some ([], Some (R_ (blend A w0 w1 w2 w3 q0 q1 q2 q3))).
    Hypothesis transformed_error_does : forall a b, transformed_error_ [R_ a; R_ b] =
      Some ([R_ (opp A (log_of A k (div A b a))); R_ (div A (add A (literal A one) (div A b a)) b)], None).
    Hypothesis law_does : forall g x e, law_ [R_ g; R_ x; R_ e] = Some ([], Some (R_ (opp A (mul A (mul A g x) e)))).
    Variables (below : environment A) (first : F) (name clock : string) (v : value A).
    Hypothesis finite_inputs : at_most A (zeros A x first (number_of_dimensions k)) (literal A zero) = true.
    Hypothesis segment_there : get name kernels = Some segment_.
    Hypothesis clock_there : forall z f, values_of A (("s", Nothing) :: ("row", Nothing) :: checked A below z f) [Name clock] = Some [v].
    Hypothesis segment_does : segment_ [v] = Some ([I_ (segment * (2 * n))%Z; R_ s], None).

    Lemma common_executes : exists out env,
      run_block A (run A kernels arrays_of) (common_statements k name clock) (("zero", R_ first) :: below) [] =
        Some (env, out, Some (Some (I_ (if outside_after A k segment s q x (number_of_dimensions k) then 1 else 0)%Z))) /\
      forall i, (0 <= i < n)%Z -> stored (A := A) "u" i out = Some (control_input A k i (L i) (U i) (x i)).
    Proof.
      destruct there as (T1 & T2 & T3 & T4).
      apply (common_runs A k basis_ blend_ transformed_error_ law_ kernels T1 T2 T3 T4 segment K s q x arrays_of segment_range small basis_does blend_does transformed_error_does law_does) with (segment_ := segment_) (value := v); try assumption.
      - intros z Hz. unfold arrays_of. rewrite get_coefficients. apply table_entry; lia.
      - intros i Hi. unfold arrays_of. rewrite get_other by reflexivity. now apply places_there.
      - intros i Hi. exists (x i). unfold arrays_of. rewrite get_other by reflexivity. now apply places_there.
      - intros Sv i Hi. unfold arrays_of. rewrite (get_gains Sv). apply table_entry; rewrite ?(gains_length Sv); lia.
      - intros Cd i Hi. unfold arrays_of. rewrite (get_clamps Cd). apply table_entry; rewrite ?(clamps_length Cd); lia.
      - intros Li i Hi. unfold arrays_of. rewrite (get_limits Li). apply table_entry; rewrite ?(limits_length Li); lia.
    Qed.
  End Common.

  Definition acts_at (f : string) (v : value A) : Prop := exists out,
    execute A (log_name k) program f [v] places_of =
      Some (out, Some (I_ (if outside_after A k segment s q x (number_of_dimensions k) then 1 else 0)%Z)) /\
    forall i, (0 <= i < n)%Z -> stored (A := A) "u" i out = Some (control_input A k i (L i) (U i) (x i)).

  (* Kernels by the function that each is: written out, each would hold all of those before it twice. *)
  Definition grow (ks : list (string * kernel A)) (g : function) : list (string * kernel A) := (title g, kernel_of A ks (fun _ _ => None) g) :: ks.
  Lemma all_kernels_grow : forall fs ks, all_kernels A fs ks = fold_left grow fs ks.
  Proof. induction fs as [|g fs IH]; intro ks; [reflexivity|]. exact (IH (grow ks g)). Qed.

  (* what the two functions see *)
  Definition places_known (segments : list function) := fold_left grow segments (log_kernels A k).
  Definition edges_known segments := grow (grow (places_known segments) basis_function) blend_function.
  Definition law_known segments := grow (grow (edges_known segments) (transformed_error_function k)) law_function.

  Lemma law_known_executes segments others below first name clock v segment_ :
    segments = [segment_function k] \/ (exists c, segments = [segment_function k; segment_at_tick_function k c]) ->
    (forall f, In f others -> title f = "@tube" \/ title f = "@control" \/ title f = "@control_tick") ->
    at_most A (zeros A x first (number_of_dimensions k)) (literal A zero) = true ->
    get name (places_known segments) = Some segment_ -> (name = "@segment" \/ name = "@segment_at_tick") ->
    (forall z f, values_of A (("s", Nothing) :: ("row", Nothing) :: checked A below z f) [Name clock] = Some [v]) ->
    segment_ [v] = Some ([I_ (segment * (2 * n))%Z; R_ s], None) ->
    exists out env,
      run_block A (run A (fold_left grow others (law_known segments)) arrays_of) (common_statements k name clock) (("zero", R_ first) :: below) [] =
        Some (env, out, Some (Some (I_ (if outside_after A k segment s q x (number_of_dimensions k) then 1 else 0)%Z))) /\
      forall i, (0 <= i < n)%Z -> stored (A := A) "u" i out = Some (control_input A k i (L i) (U i) (x i)).
  Proof.
    intros Sg Ot Fi Sn Nm Cl Sd.
    assert (Past : forall y ks, y <> "@tube" -> y <> "@control" -> y <> "@control_tick" -> get y (fold_left grow others ks) = get y ks).
    { intros y ks N1 N2 N3. revert ks Ot. induction others as [|g r IH]; intros ks Ot; [reflexivity|]. cbn [fold_left]. rewrite IH by (intros; apply Ot; now right).
      unfold grow at 1, get. assert (Ne : String.eqb y (title g) = false).
      { apply String.eqb_neq. intro Q. destruct (Ot g (or_introl eq_refl)) as [E|[E|E]]; rewrite E in Q; contradiction. }
      rewrite Ne. reflexivity. }
    apply (common_executes (fold_left grow others (law_known segments))
      (kernel_of A (places_known segments) (fun _ _ => None) basis_function) (kernel_of A (grow (places_known segments) basis_function) (fun _ _ => None) blend_function)
      (kernel_of A (edges_known segments) (fun _ _ => None) (transformed_error_function k))
      (kernel_of A (grow (edges_known segments) (transformed_error_function k)) (fun _ _ => None) law_function) segment_) with (v := v); try assumption.
    - rewrite !Past by discriminate. repeat split; reflexivity.
    - apply basis_runs.
    - intros; apply blend_runs.
    - intros a b. destruct Sg as [->|[c ->]].
      + apply (transformed_error_runs A k _ _ [("@segment", _)]). left; eexists; reflexivity.
      + apply (transformed_error_runs A k _ _ [("@segment_at_tick", _); ("@segment", _)]). right; do 2 eexists; reflexivity.
    - intros; apply law_runs.
    - rewrite Past by (destruct Nm as [-> | ->]; discriminate). destruct Nm as [-> | ->]; exact Sn.
  Qed.

  Ltac chosen g := match goal with |- context [List.find ?p ?l] => change (List.find p l) with (Some g) end.
  Ltac known_as ks := match goal with |- context [fold_left grow ?l (log_kernels A k)] => change (fold_left grow l (log_kernels A k)) with ks end; cbv iota beta.
  Ltac started E := unfold enter; cbn [bind of_type parameters code control_function control_tick_function app];
    repeat (eapply (let_step A _ arrays_of); [reflexivity|reflexivity|]); exact E.

  Theorem control_executes t : to_integer A (spline_time A k t) = Some segment -> s = place A (spline_time A k t) segment ->
    at_most A (zeros A x (mul A t (literal A zero)) (number_of_dimensions k)) (literal A zero) = true -> acts_at "@control" (R_ t).
  Proof.
    intros Sk Es Fi. unfold acts_at, execute. cbn [functions program]. change (fun y i => match get y (tables program) with Some _ => _ | None => _ end) with arrays_of.
    unfold emitted. rewrite kernels_after, found_after by discriminate. rewrite all_kernels_grow.
    assert (Run : kernel_of A (log_kernels A k) (fun _ _ => None) (segment_function k) [R_ t] = Some ([I_ (segment * (2 * n))%Z; R_ s], None)).
    { rewrite Es. apply (segment_runs A k (log_kernels A k) t segment); auto; unfold n in *; nia. }
    assert (Ex : forall segments others, segments = [segment_function k] \/ (exists c, segments = [segment_function k; segment_at_tick_function k c]) ->
      (forall f, In f others -> title f = "@tube" \/ title f = "@control" \/ title f = "@control_tick") ->
      exists out env, enter A (fold_left grow others (law_known segments)) arrays_of (control_function k) [R_ t] =
        Some (env, out, Some (Some (I_ (if outside_after A k segment s q x (number_of_dimensions k) then 1 else 0)%Z))) /\
        forall i, (0 <= i < n)%Z -> stored (A := A) "u" i out = Some (control_input A k i (L i) (U i) (x i))).
    { intros segments others Sg Ot. destruct (law_known_executes segments others [("t_zero", R_ (mul A t (literal A zero))); ("t", R_ t)] (mul A t (literal A zero)) "@segment" "t" (R_ t)
        (kernel_of A (log_kernels A k) (fun _ _ => None) (segment_function k)) Sg Ot Fi) as (out & env & E & St).
      - destruct Sg as [->|[c ->]]; reflexivity.
      - now left.
      - reflexivity.
      - exact Run.
      - exists out, env. split; [started E|exact St]. }
    unfold with_ticks. destruct (tick_constants k) as [c|]; chosen (control_function k).
    - known_as (fold_left grow [tube_function k; control_tick_function k] (law_known [segment_function k; segment_at_tick_function k c])).
      destruct (Ex [segment_function k; segment_at_tick_function k c] [tube_function k; control_tick_function k]) as (out & env & E & St); [right; now exists c| |].
      + intros g [<-|[<-|[]]]; [now left|now right; right].
      + exists out. split; [now rewrite E|exact St].
    - known_as (fold_left grow [tube_function k] (law_known [segment_function k])).
      destruct (Ex [segment_function k] [tube_function k]) as (out & env & E & St); [now left| |].
      + intros g [<-|[]]. now left.
      + exists out. split; [now rewrite E|exact St].
  Qed.

  Theorem control_tick_executes c tick : tick_constants k = Some c -> ticks_small c -> tick_segments c = K -> (0 <= tick <= 4294967295)%Z ->
    segment = tick_segment c tick -> s = share_of_tick A c tick ->
    at_most A (zeros A x (literal A zero) (number_of_dimensions k)) (literal A zero) = true -> acts_at "@control_tick" (U_ tick).
  Proof.
    intros Tk Sm Ks Tr Sk Es Fi. unfold acts_at, execute. cbn [functions program]. change (fun y i => match get y (tables program) with Some _ => _ | None => _ end) with arrays_of.
    unfold emitted. rewrite kernels_after, found_after by discriminate. rewrite all_kernels_grow.
    assert (Run : forall ks, kernel_of A ks (fun _ _ => None) (segment_at_tick_function k c) [U_ tick] = Some ([I_ (segment * (2 * n))%Z; R_ s], None)).
    { intro ks. rewrite Es, Sk. apply (segment_at_tick_runs A k ks c tick); auto; rewrite Ks; unfold n in *; nia. }
    unfold with_ticks. rewrite Tk. chosen (control_tick_function k).
    known_as (fold_left grow [tube_function k; control_function k] (law_known [segment_function k; segment_at_tick_function k c])).
    destruct (law_known_executes [segment_function k; segment_at_tick_function k c] [tube_function k; control_function k] [("tick", @U_ A tick)] (literal A zero) "@segment_at_tick" "tick" (@U_ A tick)
      (kernel_of A (grow (log_kernels A k) (segment_function k)) (fun _ _ => None) (segment_at_tick_function k c))) as (out & env & E & St).
    - right. now exists c.
    - intros g [<-|[<-|[]]]; [now left|now right; left].
    - exact Fi.
    - reflexivity.
    - now right.
    - reflexivity.
    - apply Run.
    - exists out. split; [|exact St].
      assert (En : enter A (fold_left grow [tube_function k; control_function k] (law_known [segment_function k; segment_at_tick_function k c])) arrays_of (control_tick_function k) [U_ tick] =
        Some (env, out, Some (Some (I_ (if outside_after A k segment s q x (number_of_dimensions k) then 1 else 0)%Z)))) by (started E).
      now rewrite En.
  Qed.
End Execute.
