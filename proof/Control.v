(* The emitted functions run: `control` and `control_tick` end for all finite inputs, without anything that C leaves undefined. What they
   store is a formula, over any arithmetic.

   Controller.v applies it to the machine's arithmetic. The formulas are those of docs/certificate-format.md (the law); Emission.v has
   the statements. *)
From Coq Require Import ZArith List String Bool Ascii Lia.
From Stt Require Import Syntax Run Emission.
Import ListNotations.
Open Scope string_scope.
Open Scope list_scope.

(* The constants of component i: its own clamp share, where they differ. *)
Definition constants_of_component (consts : constants) (i : Z) : constants :=
  Constants (dimensions consts) (time_rate consts) (last_spline_time consts) (gain_upper consts) (gain_lower consts) (gain_table consts) (limit_table consts)
    (if clamp_shares_differ consts then nth (Z.to_nat i) (clamp_share_table consts) literal_zero else clamp_share consts) (clamp_share_table consts) (is_single consts) (has_inline_log consts) (tick_constants consts).

(* The values of the statements, as formulas over an arithmetic. *)
Section Formulas.
  Variable A : arithmetic.
  Variable consts : constants.
  Notation number := (float A).
  Let literal_value := literal A.

  (* The spline time of t: the product with time_rate, limited to [0, last_spline_time]. *)
  Definition spline_time (t : number) : number :=
    let started := if less_than A (literal_value literal_zero) t then t else literal_value literal_zero in
    let scaled := mul A started (literal_value (time_rate consts)) in
    if less_than A scaled (literal_value (last_spline_time consts)) then scaled else literal_value (last_spline_time consts).
  (* The position in a segment. *)
  Definition position_in_segment (u : number) (segment : Z) : number := sub A u (of_integer A segment).

  (* Of a count of ticks: the parts that have passed, the segment, the parts that have passed in it, and the position in it. *)
  Definition tick_parts (c : tick_numbers) (tick : Z) : Z := Z.min (Z.min tick (tick_limit c) * tick_multiplier c) (tick_divisor c * tick_segments c).
  Definition tick_segment (c : tick_numbers) (tick : Z) : Z := Z.min (tick_parts c tick / tick_divisor c) (tick_segments c - 1).
  Definition tick_parts_in_segment (c : tick_numbers) (tick : Z) : Z := (tick_parts c tick - tick_segment c tick * tick_divisor c)%Z.
  Definition tick_position_in_segment (c : tick_numbers) (tick : Z) : number := div A (of_integer A (tick_parts_in_segment c tick)) (literal_value (tick_divisor_real c)).

  (* The weights of the four control points; `bump_factor` is 3 (1 + (1 - s) s). *)
  Definition one_minus_position s := sub A (literal_value literal_one) s.
  Definition bump_factor s := mul A (literal_value literal_three) (add A (literal_value literal_one) (mul A (one_minus_position s) s)).
  Definition weight0 s := mul A (mul A (one_minus_position s) (one_minus_position s)) (one_minus_position s).
  Definition weight1 s := add A (literal_value literal_one) (mul A (one_minus_position s) (bump_factor s)).
  Definition weight2 s := add A (literal_value literal_one) (mul A s (bump_factor s)).
  Definition weight3 s := mul A (mul A s s) s.
  Definition blend (w0 w1 w2 w3 q0 q1 q2 q3 : number) : number := add A (add A (mul A w0 q0) (mul A w1 q1)) (add A (mul A w2 q2) (mul A w3 q3)).

  (* An edge at s, from its four control points. *)
  Definition edge (s q0 q1 q2 q3 : number) : number := blend (weight0 s) (weight1 s) (weight2 s) (weight3 s) q0 q1 q2 q3.

  (* For edges L and U and state x: whether the upper edge is nearer; the distance to the nearer edge, before and after the clamp; the
     farther one; their ratio. *)
  Definition upper_nearer (L U x : number) : bool := less_than A (sub A U x) (sub A x L).
  Definition nearest_distance (L U x : number) : number := if upper_nearer L U x then sub A U x else sub A x L.
  Definition near_distance (L U x : number) : number :=
    let clamped_nearest := mul A (sub A U L) (literal_value (clamp_share consts)) in if less_than A clamped_nearest (nearest_distance L U x) then nearest_distance L U x else clamped_nearest.
  Definition far_distance (L U x : number) : number := sub A (sub A U L) (near_distance L U x).
  Definition distance_ratio (L U x : number) : number := div A (far_distance L U x) (near_distance L U x).
  (* ln y where it is written out, with y = m 2^e. *)
  Definition inline_log (y : number) : number :=
    let m := mantissa_of A y in
    let s := div A (sub A m (literal_value literal_one)) (add A m (literal_value literal_one)) in
    let around := add A (mul A (mul A s s) (literal_value (log_coefficient consts))) (literal_value literal_two) in
    add A (mul A (of_integer A (exponent_of A y)) (literal_value (ln_two consts))) (mul A s around).
  Definition emitted_log (y : number) : number := if has_inline_log consts then inline_log y else logarithm A y.
  Definition epsilon (L U x : number) : number := negate A (emitted_log (distance_ratio L U x)).
  Definition xi (L U x : number) : number := div A (add A (literal_value literal_one) (distance_ratio L U x)) (far_distance L U x).
  (* Entry i of a table of constants. *)
  Definition table_constant (table : list decimal) (i : Z) : number := literal_value (nth (Z.to_nat i) table literal_zero).
  (* The gain of component i where the upper edge is nearer, and where the lower one is. *)
  Definition gain_if_upper_nearer (i : Z) : number := if gains_differ consts then negate A (table_constant (gain_table consts) i) else literal_value (gain_upper consts).
  Definition gain_if_lower_nearer (i : Z) : number := if gains_differ consts then table_constant (gain_table consts) i else literal_value (gain_lower consts).
  Definition chosen_gain (high low L U x : number) : number := if upper_nearer L U x then high else low.
  (* The input by the law (13), before it is limited. *)
  Definition unlimited_input (high low L U x : number) : number := negate A (mul A (mul A (chosen_gain high low L U x) (xi L U x)) (epsilon L U x)).
  (* v limited to [-m, m]. *)
  Definition saturate (m v : number) : number := let raised := if less_than A (negate A m) v then v else negate A m in if less_than A m raised then m else raised.
  Definition is_inside (L U x : number) : bool := less_than A (literal_value literal_zero) (nearest_distance L U x).
End Formulas.
(* The input that `control` stores for component i. *)
Definition control_input (A : arithmetic) (consts : constants) (i : Z) (L U x : float A) : float A :=
  let v := unlimited_input A (constants_of_component consts i) (gain_if_upper_nearer A consts i) (gain_if_lower_nearer A consts i) L U x in if has_limits consts then saturate A (table_constant A (limit_table consts) i) v else v.

(* The number that an array has at an index after these stores: the newest one. *)
Fixpoint last_stored {A} (x : string) (i : Z) (out : array_stores A) : option (float A) :=
  match out with [] => None | (y, j, v) :: r => if String.eqb x y then if (i =? j)%Z then Some v else last_stored x i r else last_stored x i r end.

(* The common statements of `control` and `control_tick`. The position comes from a function of the time or of the count of ticks. *)
Definition statements_after_clock (consts : constants) (segment clock : string) : list statement :=
  inputs_that_are_not_finite_statements consts ++ [Declare TInt "row"; Declare TReal "s"; CallKernel segment [Var clock] ["row"; "s"]] ++ law_statements consts.
(* The bodies of their loops over dimensions: the test of the inputs, and the law. *)
Definition body_of_loop (s : statement) : list statement := match s with For _ _ body => body | _ => [] end.
Definition finite_test_body (consts : constants) : list statement := body_of_loop (nth 0 (sum_of_zeros_statements consts) (Return None)).
Definition control_body (consts : constants) : list statement := body_of_loop (nth 6 (law_statements consts) (Return None)).

Ltac reduce := cbv beta iota zeta delta
  [exponent_function mantissa_function segment_function segment_at_tick_function basis_function edge_at_function transformed_error_function law_function tube_function control_function control_tick_function
   kernel_of_function run_function bind_parameters has_type parameters body run_statement run_block expression_value value_of values_of lookup_name assign_name assign_names apply_operator choose pointer_results leave_block
   String.eqb Ascii.eqb Bool.eqb app rev List.length skipn Nat.sub negb
   math_library log_name].

(* The integers of a text with ticks fit 31 bits. *)
Definition ticks_fit_31_bits (c : tick_numbers) : Prop := (0 < tick_multiplier c <= 2147483647 /\ 0 < tick_divisor c /\ 0 < tick_segments c /\ 0 <= tick_limit c <= 2147483647 /\
  tick_limit c * tick_multiplier c <= 2147483647 /\ tick_divisor c * tick_segments c <= 2147483647)%Z.
Lemma tick_parts_range c tick : ticks_fit_31_bits c -> (0 <= tick)%Z ->
  (0 <= tick_parts c tick <= tick_divisor c * tick_segments c /\ 0 <= tick_segment c tick < tick_segments c /\ 0 <= tick_parts_in_segment c tick <= tick_divisor c)%Z.
Proof.
  intros ([M _] & D & K & L & LM & DK) T. unfold tick_parts_in_segment.
  assert (P : (0 <= tick_parts c tick <= tick_divisor c * tick_segments c)%Z) by (unfold tick_parts; nia).
  assert (Dv := Z.div_mod (tick_parts c tick) (tick_divisor c) ltac:(lia)). assert (Md := Z.mod_pos_bound (tick_parts c tick) (tick_divisor c) D).
  assert (Q0 : (0 <= tick_parts c tick / tick_divisor c)%Z) by (apply Z.div_pos; lia).
  split; [exact P|]. unfold tick_segment.
  destruct (Z.min_spec (tick_parts c tick / tick_divisor c) (tick_segments c - 1)) as [[C ->]|[C ->]]; split; nia.
Qed.
Lemma if_less_is_minimum (a b : Z) : (if (a <? b)%Z then a else b) = Z.min a b.
Proof. destruct (Z.ltb_spec a b); lia. Qed.

(* ------------------------------------------------------------------ the kernels *)
(* What each function computes. *)
Section Kernels.
  Variable A : arithmetic.
  Variable consts : constants.
  Notation number := (float A).
  Variable known_kernels : list (string * kernel_meaning A).
  Variable entries : string -> Z -> option number.

  Lemma segment_runs t segment : to_integer A (spline_time A consts t) = Some segment ->
    (-2147483648 <= segment <= 2147483647)%Z -> (-2147483648 <= 2 * dimensions consts <= 2147483647)%Z ->
    (-2147483648 <= segment * (2 * dimensions consts) <= 2147483647)%Z ->
    kernel_of_function A known_kernels entries (segment_function consts) [RealValue t] =
    Some ([IntValue (segment * (2 * dimensions consts))%Z; RealValue (position_in_segment A (spline_time A consts t) segment)], None).
  Proof.
    intros E H1 H2 H3. unfold spline_time in E. cbv zeta in E.
    reduce. rewrite E. repeat (rewrite !int32_in_range by assumption; cbv beta iota). reflexivity.
  Qed.
  Lemma segment_at_tick_runs c tick : ticks_fit_31_bits c -> (0 <= tick <= 4294967295)%Z -> (0 < dimensions consts /\ 2 * dimensions consts * tick_segments c <= 2147483647)%Z ->
    kernel_of_function A known_kernels entries (segment_at_tick_function consts c) [UnsignedValue tick] =
    Some ([IntValue (tick_segment c tick * (2 * dimensions consts))%Z; RealValue (tick_position_in_segment A c tick)], None).
  Proof.
    intros S T N. assert (R := tick_parts_range c tick S (proj1 T)). destruct R as ([P1 P2] & [S1 S2] & [R1 R2]). destruct S as ([M M1] & D & K & [L0 L1] & LM & DK).
    assert (Q : Z.quot (tick_parts c tick) (tick_divisor c) = (tick_parts c tick / tick_divisor c)%Z) by (apply Z.quot_div_nonneg; lia).
    assert (W : (-2147483648 <= tick_parts c tick / tick_divisor c <= 2147483647)%Z).
    { split; [apply Z.le_trans with 0%Z; [lia|apply Z.div_pos; lia]|]. apply Z.le_trans with (tick_parts c tick); [apply Z.div_le_upper_bound; nia|lia]. }
    assert (Z1 : (-2147483648 <= Z.min tick (tick_limit c) <= 2147483647)%Z) by lia.
    assert (Z2 : (-2147483648 <= Z.min tick (tick_limit c) * tick_multiplier c <= 2147483647)%Z) by nia.
    assert (Z3 : (-2147483648 <= tick_segment c tick * tick_divisor c <= 2147483647)%Z) by nia.
    assert (Z4 : (-2147483648 <= tick_segment c tick * (2 * dimensions consts) <= 2147483647)%Z) by nia.
    assert (Z5 : (-2147483648 <= tick_parts_in_segment c tick <= 2147483647)%Z) by nia.
    assert (Z6 : (0 < dimensions consts /\ 2 * dimensions consts <= 2147483647)%Z) by nia.
    assert (Z8 : (tick_divisor c <= 2147483647 /\ tick_segments c <= 2147483647)%Z) by nia.
    assert (Z9 : (0 <= tick_divisor c * tick_segments c)%Z) by nia.
    reduce. rewrite uint32_in_range by lia. cbv beta iota. rewrite if_less_is_minimum, !int32_in_range by lia. cbv beta iota.
    rewrite if_less_is_minimum. fold (tick_parts c tick). rewrite (proj2 (Z.ltb_lt _ _) D), Q, int32_in_range by exact W. cbv beta iota. rewrite !int32_in_range by lia. cbv beta iota. rewrite if_less_is_minimum. fold (tick_segment c tick).
    rewrite int32_in_range by exact Z3. cbv beta iota. fold (tick_parts_in_segment c tick). rewrite int32_in_range by exact Z5. cbv beta iota. rewrite int32_in_range by lia. cbv beta iota. rewrite int32_in_range by exact Z4. reflexivity.
  Qed.
  Lemma basis_runs s : kernel_of_function A known_kernels entries basis_function [RealValue s] =
    Some ([RealValue (weight0 A s); RealValue (weight1 A s); RealValue (weight2 A s); RealValue (weight3 A s)], None).
  Proof. reflexivity. Qed.
  (* The edge's four entries stand at `at_` and one, two and three rows after it, all within the table. *)
  Lemma edge_at_runs coefficient length at_ w0 w1 w2 w3 : (0 < dimensions consts)%Z -> (0 <= at_)%Z -> (at_ + 6 * dimensions consts < length)%Z -> (length <= 2147483647)%Z ->
    (forall z, (0 <= z < length)%Z -> entries "@coefficients" z = Some (coefficient z)) ->
    kernel_of_function A known_kernels entries (edge_at_function consts) [IntValue at_; RealValue w0; RealValue w1; RealValue w2; RealValue w3] =
    Some ([], Some (RealValue (blend A w0 w1 w2 w3 (coefficient at_) (coefficient (at_ + 2 * dimensions consts)%Z) (coefficient (at_ + 4 * dimensions consts)%Z) (coefficient (at_ + 6 * dimensions consts)%Z)))).
  Proof.
    intros N A0 A6 L E. reduce. repeat (first [rewrite E by lia | rewrite int32_in_range by lia]; cbv beta iota). reflexivity.
  Qed.
  Lemma law_runs g x e : kernel_of_function A known_kernels entries law_function [RealValue g; RealValue x; RealValue e] = Some ([], Some (RealValue (negate A (mul A (mul A g x) e)))).
  Proof. reflexivity. Qed.
  (* The meanings of the logarithm's helpers, or of the library's logarithm. *)
  Definition log_kernels := if has_inline_log consts
    then [("@mantissa", kernel_of_function A (("@exponent", kernel_of_function A (math_library A (log_name consts)) entries exponent_function) :: math_library A (log_name consts)) entries mantissa_function);
          ("@exponent", kernel_of_function A (math_library A (log_name consts)) entries exponent_function)] ++ math_library A (log_name consts)
    else math_library A (log_name consts).
  Lemma transformed_error_runs f0 f1 segments_ a b : (exists f2, segments_ = [("@segment", f2)]) \/ (exists f2 f3, segments_ = [("@segment_at_tick", f3); ("@segment", f2)]) ->
    kernel_of_function A (("@edge_at", f0) :: ("@basis", f1) :: segments_ ++ log_kernels) entries (transformed_error_function consts) [RealValue a; RealValue b] =
    Some ([RealValue (negate A (emitted_log A consts (div A b a))); RealValue (div A (add A (literal A literal_one) (div A b a)) b)], None).
  Proof.
    unfold transformed_error_function, log_kernels, logarithm_statements, emitted_log, log_name.
    intros [[f2 ->]|(f2 & f3 & ->)]; (destruct (has_inline_log consts); [|destruct (is_single consts)]; reflexivity).
  Qed.
End Kernels.

(* ------------------------------------------------------------------ their callers *)
(* The statements of `control` and `control_tick` after the clock, for a segment and a position in it that come from either. *)
Section Callers.
  Variable A : arithmetic.
  Variable consts : constants.
  Notation number := (float A).
  Let literal_value := literal A.
  Variables basis_kernel edge_at_kernel transformed_error_kernel law_kernel : kernel_meaning A.
  Variable kernels : list (string * kernel_meaning A).
  Hypothesis basis_known : lookup_name "@basis" kernels = Some basis_kernel.
  Hypothesis edge_at_known : lookup_name "@edge_at" kernels = Some edge_at_kernel.
  Hypothesis transformed_error_known : lookup_name "@transformed_error" kernels = Some transformed_error_kernel.
  Hypothesis law_known_ : lookup_name "@law" kernels = Some law_kernel.

  Variables (segment K : Z) (position : number) (coefficient x : Z -> number) (arrays : string -> Z -> option number).
  Let n := dimensions consts.
  Let row := (segment * (2 * n))%Z.

  Hypothesis segment_range : (0 <= segment < K)%Z.
  Hypothesis indices_fit_31_bits : (0 < n /\ 2 * n * (K + 3) <= 2147483647)%Z.
  Hypothesis basis_kernel_value : basis_kernel [RealValue position] = Some ([RealValue (weight0 A position); RealValue (weight1 A position); RealValue (weight2 A position); RealValue (weight3 A position)], None).
  Hypothesis edge_at_kernel_value : forall at_ w0 w1 w2 w3, (0 <= at_)%Z -> (at_ + 6 * n < 2 * n * (K + 3))%Z ->
    edge_at_kernel [IntValue at_; RealValue w0; RealValue w1; RealValue w2; RealValue w3] =
    Some ([], Some (RealValue (blend A w0 w1 w2 w3 (coefficient at_) (coefficient (at_ + 2 * n)%Z) (coefficient (at_ + 4 * n)%Z) (coefficient (at_ + 6 * n)%Z)))).
  Hypothesis transformed_error_kernel_value : forall a b, transformed_error_kernel [RealValue a; RealValue b] =
    Some ([RealValue (negate A (emitted_log A consts (div A b a))); RealValue (div A (add A (literal A literal_one) (div A b a)) b)], None).
  Hypothesis law_kernel_value : forall g x e, law_kernel [RealValue g; RealValue x; RealValue e] = Some ([], Some (RealValue (negate A (mul A (mul A g x) e)))).

  (* The edges of dimension i that the statements compute. *)
  Definition lower (i : Z) : number := let at_ := (row + i * 2)%Z in edge A position (coefficient at_) (coefficient (at_ + 2 * n)) (coefficient (at_ + 4 * n)) (coefficient (at_ + 6 * n)).
  Definition upper (i : Z) : number := let at_ := (row + i * 2)%Z in edge A position (coefficient (at_ + 1)) (coefficient (at_ + (2 * n + 1))) (coefficient (at_ + (4 * n + 1))) (coefficient (at_ + (6 * n + 1))).

  (* The variables of segment, position and weights, above `rest`. *)
  Definition position_variables (rest : environment A) : environment A :=
    ("w3", RealValue (weight3 A position)) :: ("w2", RealValue (weight2 A position)) :: ("w1", RealValue (weight1 A position)) :: ("w0", RealValue (weight0 A position)) :: ("s", RealValue position) :: ("row", IntValue row) :: rest.

  (* One lemma for each kind of statement: its value v is found by evaluating, and the rest of the block runs on. *)
  Lemma let_step ty y e r env out v o : expression_value A kernels arrays env e = Some v -> has_type A ty v = true ->
    run_block A (run_statement A kernels arrays) r ((y, v) :: env) out = o -> run_block A (run_statement A kernels arrays) (Let ty y e :: r) env out = o.
  Proof. intros E T H. cbn [run_block run_statement]. now rewrite E, T. Qed.
  Lemma set_step y e r env env' out v o : expression_value A kernels arrays env e = Some v -> assign_name A y v env = Some env' ->
    run_block A (run_statement A kernels arrays) r env' out = o -> run_block A (run_statement A kernels arrays) (Assign y e :: r) env out = o.
  Proof. intros E T H. cbn [run_block run_statement]. now rewrite E, T. Qed.
  Lemma declare_step ty y r env out o :
    run_block A (run_statement A kernels arrays) r ((y, Unset) :: env) out = o -> run_block A (run_statement A kernels arrays) (Declare ty y :: r) env out = o.
  Proof. intros H. exact H. Qed.
  Lemma call_step f a ys r env env' out kf vs rs o : lookup_name f kernels = Some kf -> values_of A env a = Some vs -> kf vs = Some (rs, None) ->
    assign_names A ys rs env = Some env' -> run_block A (run_statement A kernels arrays) r env' out = o -> run_block A (run_statement A kernels arrays) (CallKernel f a ys :: r) env out = o.
  Proof. intros G V C P H. cbn [run_block run_statement]. now rewrite G, V, C, P. Qed.
  Lemma store_step y i e r env out j v w o : value_of A env i = Some (IntValue j) -> expression_value A kernels arrays env e = Some (RealValue v) -> arrays y j = Some w ->
    run_block A (run_statement A kernels arrays) r env ((y, j, v) :: out) = o -> run_block A (run_statement A kernels arrays) (Store y i e :: r) env out = o.
  Proof. intros I E T H. cbn [run_block run_statement]. now rewrite I, E, T. Qed.
  Lemma loop_step y m body r env out env' out' o : run_loop A (run_statement A kernels arrays) y body (Z.to_nat m) 0 env out = Some (env', out', None) ->
    run_block A (run_statement A kernels arrays) r env' out' = o -> run_block A (run_statement A kernels arrays) (For y m body :: r) env out = o.
  Proof. intros E H. cbn [run_block run_statement]. now rewrite E. Qed.
  Lemma pass_step c body r env out o : value_of A env c = Some (BoolValue false) ->
    run_block A (run_statement A kernels arrays) r env out = o -> run_block A (run_statement A kernels arrays) (IfTrue c body :: r) env out = o.
  Proof. intros E H. cbn [run_block run_statement]. now rewrite E. Qed.
  Lemma return_step e r env out v : expression_value A kernels arrays env e = Some v ->
    run_block A (run_statement A kernels arrays) (Return (Some e) :: r) env out = Some (env, out, Some (Some v)).
  Proof. intros E. cbn [run_block run_statement]. now rewrite E. Qed.

  Hypothesis inputs_readable : forall i, (0 <= i < n)%Z -> arrays "x" i = Some (x i).
  Hypothesis outputs_writable : forall i, (0 <= i < n)%Z -> exists w, arrays "u" i = Some w.
  Hypothesis gains_readable : gains_differ consts = true -> forall i, (0 <= i < n)%Z -> arrays "@gain" i = Some (table_constant A (gain_table consts) i).
  Hypothesis clamp_shares_readable : clamp_shares_differ consts = true -> forall i, (0 <= i < n)%Z -> arrays "@least_share" i = Some (table_constant A (clamp_share_table consts) i).
  Hypothesis limits_readable : has_limits consts = true -> forall i, (0 <= i < n)%Z -> arrays "@u_max" i = Some (table_constant A (limit_table consts) i).

  (* Variables before the common statements: they belong to `control` or to `control_tick`. *)
  Variable outer_variables : environment A.
  Definition variables_after_test (z : number) (f : bool) : environment A := ("bad", BoolValue (negb f)) :: ("finite", BoolValue f) :: ("zero", RealValue z) :: outer_variables.

  (* The environment ends with `inner`. Leaving a block drops newer variables, however many are below. *)
  Inductive is_suffix (inner : environment A) : environment A -> Prop := suffix_itself : is_suffix inner inner | suffix_of_longer v l : is_suffix inner l -> is_suffix inner (v :: l).
  Lemma leave_block_suffix outer inner l : is_suffix inner l -> List.length inner = List.length outer -> leave_block A outer l = inner.
  Proof.
    intros E Ln. assert (G : exists front, l = front ++ inner) by (induction E as [|v l E [front ->]]; [now exists []|now exists (v :: front)]).
    destruct G as [front ->]. unfold leave_block. rewrite app_length, Ln, Nat.add_sub. clear. induction front; [reflexivity|exact IHfront].
  Qed.
  Ltac left_is := apply leave_block_suffix; [repeat first [apply suffix_itself | apply suffix_of_longer] | reflexivity].

  (* The variables of the loop once the edges are computed, before statements that depend on tables. *)
  Definition variables_with_edges (i : Z) (outside : bool) (z : number) (f : bool) : environment A :=
    let at_ := (row + i * 2)%Z in
    [("upper_edge", RealValue (upper i)); ("lower_edge", RealValue (lower i)); ("upper_at", IntValue (at_ + 1)%Z); ("lower_at", IntValue at_); ("pair", IntValue (i * 2)%Z);
     ("i", IntValue i); ("outside", BoolValue outside)] ++
    position_variables (variables_after_test z f).
  (* Evaluates in one pass: every pass leaves a term in the proof. *)
  Ltac evaluate := cbv beta iota zeta delta [expression_value]; rewrite ?edge_at_known, ?law_known_; cbv beta iota zeta delta
    [position_variables variables_with_edges variables_after_test expression_value value_of values_of lookup_name apply_operator choose String.eqb Ascii.eqb Bool.eqb negb app];
    repeat first [ rewrite int32_in_range by (unfold row, n in *; nia) | rewrite inputs_readable by assumption
                 | rewrite gains_readable by first [assumption | reflexivity] | rewrite clamp_shares_readable by first [assumption | reflexivity] | rewrite limits_readable by first [assumption | reflexivity]
                 | rewrite edge_at_kernel_value by (unfold row, n in *; nia) | rewrite law_kernel_value ]; reflexivity.
  Ltac step := first
    [ eapply let_step; [evaluate|reflexivity|]
    | eapply set_step; [evaluate|reflexivity|]
    | apply declare_step ].
  (* The same with a stated value, so that terms stay small. *)
  Ltac named v := eapply (let_step _ _ _ _ _ _ v); [first [reflexivity | evaluate]|reflexivity|].

  Lemma edge_statements_run i outside z f rest out : (0 <= i < n)%Z ->
    run_block A (run_statement A kernels arrays) (edges_statements ++ rest) (("i", IntValue i) :: ("outside", BoolValue outside) :: position_variables (variables_after_test z f)) out =
    run_block A (run_statement A kernels arrays) rest (variables_with_edges i outside z f) out.
  Proof.
    intro Hi. cbv [edges_statements places_in_the_table_statements app]. do 3 step. named (RealValue (lower i)).
    assert (E : upper i = edge A position (coefficient (row + i * 2 + 1)%Z) (coefficient (row + i * 2 + 1 + 2 * n)%Z) (coefficient (row + i * 2 + 1 + 4 * n)%Z) (coefficient (row + i * 2 + 1 + 6 * n)%Z)).
    { unfold upper. cbv zeta. f_equal; f_equal; ring. }
    eapply (let_step _ _ _ _ _ _ (RealValue (upper i))); [rewrite E; evaluate|reflexivity|]. reflexivity.
  Qed.

  (* The body of the loop over dimensions stores the input of component i, and sets `outside` if the state is not between the edges. *)
  Lemma control_body_runs i outside z f out : (0 <= i < n)%Z ->
    exists inner, run_block A (run_statement A kernels arrays) (control_body consts) (("i", IntValue i) :: ("outside", BoolValue outside) :: position_variables (variables_after_test z f)) out =
      Some (inner, ("u", i, control_input A consts i (lower i) (upper i) (x i)) :: out, None) /\
      leave_block A (("outside", BoolValue outside) :: position_variables (variables_after_test z f)) inner =
      ("outside", BoolValue (if is_inside A (lower i) (upper i) (x i) then outside else true)) :: position_variables (variables_after_test z f).
  Proof.
    intro Hi. destruct (outputs_writable i Hi) as [w Hw]. change (control_body consts) with (edges_statements ++ skipn (List.length edges_statements) (control_body consts)). rewrite edge_statements_run by exact Hi.
    unfold control_body, law_statements, state_between_the_edges_statements, weights_statements, edges_statements, places_in_the_table_statements.
    set (L := lower i). set (U := upper i).
    unfold control_input, gain_if_upper_nearer, gain_if_lower_nearer. cbv zeta.
    unfold constants_of_component. destruct (gains_differ consts) eqn:Sv; destruct (has_limits consts) eqn:Li; destruct (clamp_shares_differ consts) eqn:Cd;
      match goal with |- context [unlimited_input A ?o ?h ?l] => set (component_consts := o); set (high := h); set (low := l) end; (eexists; split;
      [ cbn [body_of_loop nth app skipn List.length]; step;
        (* only with a table of clamp shares *)
        try named (RealValue (table_constant A (clamp_share_table consts) i));
        (* with a table of gains *)
        try (named (RealValue low); named (RealValue high));
        do 3 step; named (@BoolValue A (upper_nearer A L U (x i))); named (RealValue (nearest_distance A L U (x i))); named (RealValue (chosen_gain A high low L U (x i)));
        do 2 step; named (RealValue (near_distance A component_consts L U (x i))); named (RealValue (far_distance A component_consts L U (x i))); named (@BoolValue A (is_inside A L U (x i))); step;
        try named (RealValue (table_constant A (limit_table consts) i)); do 2 step;
        (eapply call_step with (rs := [RealValue (epsilon A component_consts L U (x i)); RealValue (xi A component_consts L U (x i))]);
          [exact transformed_error_known|reflexivity|apply transformed_error_kernel_value|reflexivity|]);
        named (RealValue (unlimited_input A component_consts high low L U (x i)));
        (* with a table of limits *)
        try (do 4 step; named (RealValue (saturate A (table_constant A (limit_table consts) i) (unlimited_input A component_consts high low L U (x i)))));
        (eapply store_step; [reflexivity|evaluate|exact Hw|]);
        (eapply set_step; [evaluate|reflexivity|]); reflexivity
      | left_is ]).
  Qed.

  (* The value with which the test of the inputs begins: the clock's value times 0, or 0. *)
  Variable clock_times_zero : number.
  (* The test of the inputs: the clock's value and every x, times 0 and added up. *)
  Fixpoint sum_times_zero (m : nat) : number := match m with O => clock_times_zero | S m => add A (sum_times_zero m) (mul A (x (Z.of_nat m)) (literal_value literal_zero)) end.
  Definition number_of_dimensions := Z.to_nat n.
  Hypothesis inputs_finite : at_most A (sum_times_zero number_of_dimensions) (literal_value literal_zero) = true.

  (* One of the first m components is not between its edges. *)
  Fixpoint is_outside_within_first (m : nat) : bool :=
    match m with O => false | S m => let i := Z.of_nat m in if is_inside A (lower i) (upper i) (x i) then is_outside_within_first m else true end.

  Lemma finite_test_runs : exists out env,
    run_loop A (run_statement A kernels arrays) "j" (finite_test_body consts) (Z.to_nat n) 0 (("zero", RealValue clock_times_zero) :: outer_variables) [] = Some (env, out, None) /\
    env = ("zero", RealValue (sum_times_zero number_of_dimensions)) :: outer_variables /\ out = [].
  Proof.
    destruct (run_loop_invariant A kernels arrays "j" (finite_test_body consts)
      (fun j env out => env = ("zero", RealValue (sum_times_zero (Z.to_nat j))) :: outer_variables /\ out = []) (Z.to_nat n) 0 (("zero", RealValue clock_times_zero) :: outer_variables) []) as (env & out & E & H1 & H2).
    - intros j env out Hj [-> ->]. assert (Hi : (0 <= j < n)%Z) by (unfold n in *; lia).
      do 2 eexists. split; [|split; [|reflexivity]].
      + cbv [finite_test_body body_of_loop nth sum_of_zeros_statements]. do 4 step. reflexivity.
      + replace (Z.to_nat (j + 1)) with (S (Z.to_nat j)) by lia. cbn [sum_times_zero]. rewrite Z2Nat.id by lia. left_is.
    - split; reflexivity.
    - exists out, env. split; [exact E|]. split; [|exact H2]. rewrite H1. now rewrite Z.add_0_l, Nat2Z.id.
  Qed.

  Lemma last_stored_elsewhere y i j v (out : array_stores A) : (i =? j)%Z = false -> last_stored (A := A) y i ((y, j, v) :: out) = last_stored (A := A) y i out.
  Proof. intro E. cbn [last_stored]. now rewrite String.eqb_refl, E. Qed.
  Lemma last_stored_same y i v (out : array_stores A) : last_stored (A := A) y i ((y, i, v) :: out) = Some v.
  Proof. cbn [last_stored]. now rewrite String.eqb_refl, Z.eqb_refl. Qed.

  Lemma dimension_loop_runs z f : exists out env,
    run_loop A (run_statement A kernels arrays) "i" (control_body consts) (Z.to_nat n) 0 (("outside", BoolValue false) :: position_variables (variables_after_test z f)) [] = Some (env, out, None) /\
    env = ("outside", BoolValue (is_outside_within_first number_of_dimensions)) :: position_variables (variables_after_test z f) /\
    forall i, (0 <= i < n)%Z -> last_stored (A := A) "u" i out = Some (control_input A consts i (lower i) (upper i) (x i)).
  Proof.
    destruct (run_loop_invariant A kernels arrays "i" (control_body consts)
      (fun j env out => env = ("outside", BoolValue (is_outside_within_first (Z.to_nat j))) :: position_variables (variables_after_test z f) /\
         forall i, (0 <= i < j)%Z -> last_stored (A := A) "u" i out = Some (control_input A consts i (lower i) (upper i) (x i))) (Z.to_nat n) 0
      (("outside", BoolValue false) :: position_variables (variables_after_test z f)) []) as (env & out & E & H1 & H2).
    - intros j env out Hj [-> St]. assert (Hi : (0 <= j < n)%Z) by (unfold n in *; lia).
      destruct (control_body_runs j (is_outside_within_first (Z.to_nat j)) z f out Hi) as (inner & E & Lv).
      do 2 eexists. split; [exact E|split].
      + rewrite Lv. replace (Z.to_nat (j + 1)) with (S (Z.to_nat j)) by lia. cbn [is_outside_within_first]. now rewrite Z2Nat.id by lia.
      + intros i Hij. destruct (Z.eqb_spec i j) as [->|Ne]; [apply last_stored_same|].
        rewrite last_stored_elsewhere by now apply Z.eqb_neq. apply St; lia.
    - split; [reflexivity|]. intros; lia.
    - exists out, env. split; [exact E|]. rewrite Z.add_0_l in H1, H2. rewrite Nat2Z.id in H1. split; [exact H1|].
      intros i Hi. apply H2. unfold n in *; lia.
  Qed.

  (* The position comes from a function of the time or of the count of ticks. *)
  Variables (segment_name clock_name : string) (segment_kernel : kernel_meaning A) (clock_value : c_value A).
  Hypothesis segment_known : lookup_name segment_name kernels = Some segment_kernel.
  Hypothesis clock_readable : forall z f, values_of A (("s", Unset) :: ("row", Unset) :: variables_after_test z f) [Var clock_name] = Some [clock_value].
  Hypothesis segment_kernel_value : segment_kernel [clock_value] = Some ([IntValue row; RealValue position], None).

  (* The common statements end, return whether the state is outside, and store the inputs. *)
  Theorem statements_after_clock_run : exists out env,
    run_block A (run_statement A kernels arrays) (statements_after_clock consts segment_name clock_name) (("zero", RealValue clock_times_zero) :: outer_variables) [] =
      Some (env, out, Some (Some (IntValue (if is_outside_within_first number_of_dimensions then 1 else 0)%Z))) /\
    forall i, (0 <= i < n)%Z -> last_stored (A := A) "u" i out = Some (control_input A consts i (lower i) (upper i) (x i)).
  Proof.
    destruct (dimension_loop_runs (sum_times_zero number_of_dimensions) true) as (out & env & E & -> & St).
    destruct finite_test_runs as (out0 & env0 & E0 & -> & ->).
    exists out. eexists. split; [|exact St].
    cbv [statements_after_clock inputs_that_are_not_finite_statements sum_of_zeros_statements law_statements weights_statements app].
    eapply loop_step; [exact E0|].
    eapply let_step; [reduce; fold literal_value; rewrite inputs_finite; reflexivity|reflexivity|].
    eapply let_step; [evaluate|reflexivity|].
    eapply pass_step; [evaluate|].
    do 2 step.
    eapply call_step; [exact segment_known|exact (clock_readable (sum_times_zero number_of_dimensions) true)|exact segment_kernel_value|reduce; reflexivity|].
    do 4 step.
    eapply call_step; [exact basis_known|reduce; reflexivity|exact basis_kernel_value|reduce; reflexivity|].
    step.
    eapply loop_step; [exact E|].
    apply return_step. unfold position_variables. reduce. rewrite !int32_in_range by lia. reflexivity.
  Qed.
End Callers.

(* ------------------------------------------------------------------ the whole text *)

(* The whole file. *)
Section Execute.
  Variable A : arithmetic.
  Variables (consts : constants) (coefficients : list decimal).
  Notation number := (float A).
  Let n := dimensions consts.
  Variables (segment K : Z) (position : number) (x : Z -> number).
  Variable directive_lines : list string.
  Let program := Source directive_lines (emitted_tables consts coefficients) (emitted_functions consts).
  Hypothesis segment_range : (0 <= segment < K)%Z.
  Hypothesis indices_fit_31_bits : (0 < n /\ 2 * n * (K + 3) <= 2147483647)%Z.
  Hypothesis table_length : (Z.of_nat (List.length coefficients) = 2 * n * (K + 3))%Z.
  Hypothesis gain_table_length : gains_differ consts = true -> Z.of_nat (List.length (gain_table consts)) = n.
  Hypothesis clamp_share_table_length : clamp_shares_differ consts = true -> Z.of_nat (List.length (clamp_share_table consts)) = n.
  Hypothesis limit_table_length : has_limits consts = true -> Z.of_nat (List.length (limit_table consts)) = n.

  Let file_entries := table_entry A program.

  Definition coefficient_at (z : Z) : number := literal A (nth (Z.to_nat z) coefficients literal_zero).
  (* The caller's arrays `x` and `u`, of n places each. *)
  Definition caller_arrays (name : string) (i : Z) : option number := if (0 <=? i)%Z then if (i <? n)%Z then Some (x i) else None else None.
  Let L i := lower A consts segment position coefficient_at i.
  Let U i := upper A consts segment position coefficient_at i.

  Lemma lookup_coefficients : lookup_name "@coefficients" (tables program) = Some coefficients.
  Proof. reflexivity. Qed.
  Lemma lookup_gains : gains_differ consts = true -> lookup_name "@gain" (tables program) = Some (gain_table consts).
  Proof. intro H. unfold program, emitted_tables. cbn [tables]. rewrite H. reflexivity. Qed.
  Lemma lookup_clamp_shares : clamp_shares_differ consts = true -> lookup_name "@least_share" (tables program) = Some (clamp_share_table consts).
  Proof. intro H. unfold program, emitted_tables. cbn [tables]. rewrite H. destruct (gains_differ consts); reflexivity. Qed.
  Lemma lookup_limits : has_limits consts = true -> lookup_name "@u_max" (tables program) = Some (limit_table consts).
  Proof. intro H. unfold program, emitted_tables. cbn [tables]. rewrite H. destruct (gains_differ consts), (clamp_shares_differ consts); reflexivity. Qed.
  Lemma lookup_no_table y : existsb (String.eqb y) relevant_tables = false -> lookup_name y (tables program) = None.
  Proof.
    cbn [existsb relevant_tables]. rewrite !orb_false_iff. intros (H1 & H2 & H3 & H4 & _). unfold program, emitted_tables, lookup_name. cbn [tables].
    destruct (gains_differ consts), (clamp_shares_differ consts), (has_limits consts); cbn [app]; now rewrite ?H1, ?H2, ?H3, ?H4.
  Qed.
  Lemma table_entry_readable (l : list decimal) z : (0 <= z < Z.of_nat (List.length l))%Z ->
    (if (z <? 0)%Z then None else match nth_error l (Z.to_nat z) with Some v => Some (literal A v) | None => None end) = Some (literal A (nth (Z.to_nat z) l literal_zero)).
  Proof. intro H. replace (z <? 0)%Z with false by (symmetry; apply Z.ltb_ge; lia). rewrite (nth_error_nth' _ literal_zero) by lia. reflexivity. Qed.
  Lemma caller_arrays_readable y i : (0 <= i < n)%Z -> caller_arrays y i = Some (x i).
  Proof. intros [H1 H2]. unfold caller_arrays. apply Z.leb_le in H1. apply Z.ltb_lt in H2. now rewrite H1, H2. Qed.

  Lemma kernels_skip_bit_helpers f rest : f <> "@exponent" -> f <> "@mantissa" -> kernels_in_order A file_entries (filter (fun g => negb (String.eqb (function_name g) f)) (bit_helpers consts ++ rest)) (math_library A (log_name consts)) =
    kernels_in_order A file_entries (filter (fun g => negb (String.eqb (function_name g) f)) rest) (log_kernels A consts file_entries).
  Proof.
    intros H1 H2. apply not_eq_sym in H1, H2. apply String.eqb_neq in H1, H2. unfold bit_helpers, log_kernels. destruct (has_inline_log consts); [|reflexivity].
    cbn [app filter function_name exponent_function mantissa_function]. rewrite H1, H2. reflexivity.
  Qed.
  Lemma find_skips_bit_helpers f rest : f <> "@exponent" -> f <> "@mantissa" ->
    List.find (fun g => String.eqb (function_name g) f) (bit_helpers consts ++ rest) = List.find (fun g => String.eqb (function_name g) f) rest.
  Proof.
    intros H1 H2. apply not_eq_sym in H1, H2. apply String.eqb_neq in H1, H2. unfold bit_helpers. destruct (has_inline_log consts); [|reflexivity].
    cbn [app List.find function_name exponent_function mantissa_function]. now rewrite H1, H2.
  Qed.

  (* The arrays that the functions may read: the file's tables, else the caller's. *)
  Definition program_arrays (y : string) (i : Z) : option number := match lookup_name y (tables program) with Some _ => table_entry A program y i | None => caller_arrays y i end.
  Lemma program_table_readable y (l : list decimal) z : lookup_name y (tables program) = Some l -> (0 <= z < Z.of_nat (List.length l))%Z -> program_arrays y z = Some (literal A (nth (Z.to_nat z) l literal_zero)).
  Proof. intros E H. unfold program_arrays, table_entry. rewrite E. now apply table_entry_readable. Qed.
  Lemma coefficients_of_file_readable z : (0 <= z < 2 * n * (K + 3))%Z -> file_entries "@coefficients" z = Some (coefficient_at z).
  Proof. intro H. unfold file_entries, table_entry. rewrite lookup_coefficients. apply table_entry_readable; lia. Qed.

  (* The common statements, in the file, once the position is known. *)
  Section Common.
    Variables (kernels : list (string * kernel_meaning A)) (basis_kernel edge_at_kernel transformed_error_kernel law_kernel segment_kernel : kernel_meaning A).
    Hypothesis kernels_known : lookup_name "@basis" kernels = Some basis_kernel /\ lookup_name "@edge_at" kernels = Some edge_at_kernel /\ lookup_name "@transformed_error" kernels = Some transformed_error_kernel /\ lookup_name "@law" kernels = Some law_kernel.
    Hypothesis basis_kernel_value : basis_kernel [RealValue position] = Some ([RealValue (weight0 A position); RealValue (weight1 A position); RealValue (weight2 A position); RealValue (weight3 A position)], None).
    Hypothesis edge_at_kernel_value : forall at_ w0 w1 w2 w3, (0 <= at_)%Z -> (at_ + 6 * n < 2 * n * (K + 3))%Z ->
      edge_at_kernel [IntValue at_; RealValue w0; RealValue w1; RealValue w2; RealValue w3] =
      Some ([], Some (RealValue (blend A w0 w1 w2 w3 (coefficient_at at_) (coefficient_at (at_ + 2 * n)%Z) (coefficient_at (at_ + 4 * n)%Z) (coefficient_at (at_ + 6 * n)%Z)))).
    Hypothesis transformed_error_kernel_value : forall a b, transformed_error_kernel [RealValue a; RealValue b] =
      Some ([RealValue (negate A (emitted_log A consts (div A b a))); RealValue (div A (add A (literal A literal_one) (div A b a)) b)], None).
    Hypothesis law_kernel_value : forall g x e, law_kernel [RealValue g; RealValue x; RealValue e] = Some ([], Some (RealValue (negate A (mul A (mul A g x) e)))).
    Variables (outer_variables : environment A) (clock_times_zero : number) (segment_name clock_name : string) (clock_value : c_value A).
    Hypothesis inputs_finite : at_most A (sum_times_zero A x clock_times_zero (number_of_dimensions consts)) (literal A literal_zero) = true.
    Hypothesis segment_known : lookup_name segment_name kernels = Some segment_kernel.
    Hypothesis clock_readable : forall z f, values_of A (("s", Unset) :: ("row", Unset) :: variables_after_test A outer_variables z f) [Var clock_name] = Some [clock_value].
    Hypothesis segment_kernel_value : segment_kernel [clock_value] = Some ([IntValue (segment * (2 * n))%Z; RealValue position], None).

    Lemma statements_after_clock_execute : exists out env,
      run_block A (run_statement A kernels program_arrays) (statements_after_clock consts segment_name clock_name) (("zero", RealValue clock_times_zero) :: outer_variables) [] =
        Some (env, out, Some (Some (IntValue (if is_outside_within_first A consts segment position coefficient_at x (number_of_dimensions consts) then 1 else 0)%Z))) /\
      forall i, (0 <= i < n)%Z -> last_stored (A := A) "u" i out = Some (control_input A consts i (L i) (U i) (x i)).
    Proof.
      destruct kernels_known as (T1 & T2 & T3 & T4).
      apply (statements_after_clock_run A consts basis_kernel edge_at_kernel transformed_error_kernel law_kernel kernels T1 T2 T3 T4 segment K position coefficient_at x program_arrays segment_range indices_fit_31_bits basis_kernel_value edge_at_kernel_value transformed_error_kernel_value law_kernel_value) with (segment_kernel := segment_kernel) (clock_value := clock_value); try assumption.
      - intros i Hi. unfold program_arrays. rewrite lookup_no_table by reflexivity. now apply caller_arrays_readable.
      - intros i Hi. exists (x i). unfold program_arrays. rewrite lookup_no_table by reflexivity. now apply caller_arrays_readable.
      - intros Sv i Hi. apply (program_table_readable _ _ i (lookup_gains Sv)); rewrite ?(gain_table_length Sv); lia.
      - intros Cd i Hi. apply (program_table_readable _ _ i (lookup_clamp_shares Cd)); rewrite ?(clamp_share_table_length Cd); lia.
      - intros Li i Hi. apply (program_table_readable _ _ i (lookup_limits Li)); rewrite ?(limit_table_length Li); lia.
    Qed.
  End Common.

  (* Function f, called with v, ends, returns whether the state is outside, and stores `control_input` for every component. *)
  Definition stores_control_inputs (f : string) (v : c_value A) : Prop := exists out,
    execute A (log_name consts) program f [v] caller_arrays =
      Some (out, Some (IntValue (if is_outside_within_first A consts segment position coefficient_at x (number_of_dimensions consts) then 1 else 0)%Z)) /\
    forall i, (0 <= i < n)%Z -> last_stored (A := A) "u" i out = Some (control_input A consts i (L i) (U i) (x i)).

  (* Adds the meaning of a function. Kernels are named by the function that each is: written out, each would contain all of those before
     it twice. *)
  Definition add_kernel (ks : list (string * kernel_meaning A)) (g : function) : list (string * kernel_meaning A) := (function_name g, kernel_of_function A ks file_entries g) :: ks.
  Lemma kernels_in_order_fold : forall fs ks, kernels_in_order A file_entries fs ks = fold_left add_kernel fs ks.
  Proof. induction fs as [|g fs IH]; intro ks; [reflexivity|]. exact (IH (add_kernel ks g)). Qed.

  (* The functions that `control` and `control_tick` may call, by what stands above them in the file. *)
  Definition kernels_up_to_segment (segments : list function) := fold_left add_kernel segments (log_kernels A consts file_entries).
  Definition kernels_up_to_edge_at segments := add_kernel (add_kernel (kernels_up_to_segment segments) basis_function) (edge_at_function consts).
  Definition kernels_up_to_law segments := add_kernel (add_kernel (kernels_up_to_edge_at segments) (transformed_error_function consts)) law_function.

  Lemma kernels_up_to_law_execute segments later_functions outer_variables clock_times_zero segment_name clock_name clock_value segment_kernel :
    segments = [segment_function consts] \/ (exists c, segments = [segment_function consts; segment_at_tick_function consts c]) ->
    (forall f, In f later_functions -> function_name f = "@tube" \/ function_name f = "@control" \/ function_name f = "@control_tick") ->
    at_most A (sum_times_zero A x clock_times_zero (number_of_dimensions consts)) (literal A literal_zero) = true ->
    lookup_name segment_name (kernels_up_to_segment segments) = Some segment_kernel -> (segment_name = "@segment" \/ segment_name = "@segment_at_tick") ->
    (forall z f, values_of A (("s", Unset) :: ("row", Unset) :: variables_after_test A outer_variables z f) [Var clock_name] = Some [clock_value]) ->
    segment_kernel [clock_value] = Some ([IntValue (segment * (2 * n))%Z; RealValue position], None) ->
    exists out env,
      run_block A (run_statement A (fold_left add_kernel later_functions (kernels_up_to_law segments)) program_arrays) (statements_after_clock consts segment_name clock_name) (("zero", RealValue clock_times_zero) :: outer_variables) [] =
        Some (env, out, Some (Some (IntValue (if is_outside_within_first A consts segment position coefficient_at x (number_of_dimensions consts) then 1 else 0)%Z))) /\
      forall i, (0 <= i < n)%Z -> last_stored (A := A) "u" i out = Some (control_input A consts i (L i) (U i) (x i)).
  Proof.
    intros Sg Ot Fi Sn Nm Cl Sd.
    assert (Past : forall y ks, y <> "@tube" -> y <> "@control" -> y <> "@control_tick" -> lookup_name y (fold_left add_kernel later_functions ks) = lookup_name y ks).
    { intros y ks N1 N2 N3. revert ks Ot. induction later_functions as [|g r IH]; intros ks Ot; [reflexivity|]. cbn [fold_left]. rewrite IH by (intros; apply Ot; now right).
      unfold add_kernel at 1, lookup_name. assert (Ne : String.eqb y (function_name g) = false).
      { apply String.eqb_neq. intro Q. destruct (Ot g (or_introl eq_refl)) as [E|[E|E]]; rewrite E in Q; contradiction. }
      rewrite Ne. reflexivity. }
    apply (statements_after_clock_execute (fold_left add_kernel later_functions (kernels_up_to_law segments))
      (kernel_of_function A (kernels_up_to_segment segments) file_entries basis_function) (kernel_of_function A (add_kernel (kernels_up_to_segment segments) basis_function) file_entries (edge_at_function consts))
      (kernel_of_function A (kernels_up_to_edge_at segments) file_entries (transformed_error_function consts))
      (kernel_of_function A (add_kernel (kernels_up_to_edge_at segments) (transformed_error_function consts)) file_entries law_function) segment_kernel) with (clock_value := clock_value); try assumption.
    - rewrite !Past by discriminate. repeat split; reflexivity.
    - apply basis_runs.
    - intros at_ w0 w1 w2 w3 A0 A6. apply (edge_at_runs A consts) with (length := (2 * n * (K + 3))%Z); try (unfold n in *; lia). exact coefficients_of_file_readable.
    - intros a b. destruct Sg as [->|[c ->]].
      + apply (transformed_error_runs A consts file_entries _ _ [("@segment", _)]). left; eexists; reflexivity.
      + apply (transformed_error_runs A consts file_entries _ _ [("@segment_at_tick", _); ("@segment", _)]). right; do 2 eexists; reflexivity.
    - intros; apply law_runs.
    - rewrite Past by (destruct Nm as [-> | ->]; discriminate). destruct Nm as [-> | ->]; exact Sn.
  Qed.

  Ltac chosen g := match goal with |- context [List.find ?p ?l] => change (List.find p l) with (Some g) end.
  Ltac known_as ks := match goal with |- context [fold_left add_kernel ?l (log_kernels A consts file_entries)] => change (fold_left add_kernel l (log_kernels A consts file_entries)) with ks end; cbv iota beta.
  Ltac started E := unfold run_function; cbn [bind_parameters has_type parameters body control_function control_tick_function app];
    repeat (eapply (let_step A _ program_arrays); [reflexivity|reflexivity|]); exact E.

  (* `control` runs as the formulas say. *)
  Theorem control_executes t : to_integer A (spline_time A consts t) = Some segment -> position = position_in_segment A (spline_time A consts t) segment ->
    at_most A (sum_times_zero A x (mul A t (literal A literal_zero)) (number_of_dimensions consts)) (literal A literal_zero) = true -> stores_control_inputs "@control" (RealValue t).
  Proof.
    intros Sk Es Fi. unfold stores_control_inputs, execute. cbn [functions program]. change (fun y i => match lookup_name y (tables program) with Some _ => _ | None => _ end) with program_arrays. fold file_entries.
    unfold emitted_functions. rewrite kernels_skip_bit_helpers, find_skips_bit_helpers by discriminate. rewrite kernels_in_order_fold.
    assert (Run : kernel_of_function A (log_kernels A consts file_entries) file_entries (segment_function consts) [RealValue t] = Some ([IntValue (segment * (2 * n))%Z; RealValue position], None)).
    { rewrite Es. apply (segment_runs A consts (log_kernels A consts file_entries) file_entries t segment); auto; unfold n in *; nia. }
    assert (Ex : forall segments later_functions, segments = [segment_function consts] \/ (exists c, segments = [segment_function consts; segment_at_tick_function consts c]) ->
      (forall f, In f later_functions -> function_name f = "@tube" \/ function_name f = "@control" \/ function_name f = "@control_tick") ->
      exists out env, run_function A (fold_left add_kernel later_functions (kernels_up_to_law segments)) program_arrays (control_function consts) [RealValue t] =
        Some (env, out, Some (Some (IntValue (if is_outside_within_first A consts segment position coefficient_at x (number_of_dimensions consts) then 1 else 0)%Z))) /\
        forall i, (0 <= i < n)%Z -> last_stored (A := A) "u" i out = Some (control_input A consts i (L i) (U i) (x i))).
    { intros segments later_functions Sg Ot. destruct (kernels_up_to_law_execute segments later_functions [("t_zero", RealValue (mul A t (literal A literal_zero))); ("t", RealValue t)] (mul A t (literal A literal_zero)) "@segment" "t" (RealValue t)
        (kernel_of_function A (log_kernels A consts file_entries) file_entries (segment_function consts)) Sg Ot Fi) as (out & env & E & St).
      - destruct Sg as [->|[c ->]]; reflexivity.
      - now left.
      - reflexivity.
      - exact Run.
      - exists out, env. split; [started E|exact St]. }
    unfold if_ticks. destruct (tick_constants consts) as [c|]; chosen (control_function consts).
    - known_as (fold_left add_kernel [tube_function consts; control_tick_function consts] (kernels_up_to_law [segment_function consts; segment_at_tick_function consts c])).
      destruct (Ex [segment_function consts; segment_at_tick_function consts c] [tube_function consts; control_tick_function consts]) as (out & env & E & St); [right; now exists c| |].
      + intros g [<-|[<-|[]]]; [now left|now right; right].
      + exists out. split; [now rewrite E|exact St].
    - known_as (fold_left add_kernel [tube_function consts] (kernels_up_to_law [segment_function consts])).
      destruct (Ex [segment_function consts] [tube_function consts]) as (out & env & E & St); [now left| |].
      + intros g [<-|[]]. now left.
      + exists out. split; [now rewrite E|exact St].
  Qed.

  (* `control_tick` runs as the formulas say. *)
  Theorem control_tick_executes c tick : tick_constants consts = Some c -> ticks_fit_31_bits c -> tick_segments c = K -> (0 <= tick <= 4294967295)%Z ->
    segment = tick_segment c tick -> position = tick_position_in_segment A c tick ->
    at_most A (sum_times_zero A x (literal A literal_zero) (number_of_dimensions consts)) (literal A literal_zero) = true -> stores_control_inputs "@control_tick" (UnsignedValue tick).
  Proof.
    intros Tk Sm Ks Tr Sk Es Fi. unfold stores_control_inputs, execute. cbn [functions program]. change (fun y i => match lookup_name y (tables program) with Some _ => _ | None => _ end) with program_arrays. fold file_entries.
    unfold emitted_functions. rewrite kernels_skip_bit_helpers, find_skips_bit_helpers by discriminate. rewrite kernels_in_order_fold.
    assert (Run : forall ks, kernel_of_function A ks file_entries (segment_at_tick_function consts c) [UnsignedValue tick] = Some ([IntValue (segment * (2 * n))%Z; RealValue position], None)).
    { intro ks. rewrite Es, Sk. apply (segment_at_tick_runs A consts ks file_entries c tick); auto; rewrite Ks; unfold n in *; nia. }
    unfold if_ticks. rewrite Tk. chosen (control_tick_function consts).
    known_as (fold_left add_kernel [tube_function consts; control_function consts] (kernels_up_to_law [segment_function consts; segment_at_tick_function consts c])).
    destruct (kernels_up_to_law_execute [segment_function consts; segment_at_tick_function consts c] [tube_function consts; control_function consts] [("tick", @UnsignedValue A tick)] (literal A literal_zero) "@segment_at_tick" "tick" (@UnsignedValue A tick)
      (kernel_of_function A (add_kernel (log_kernels A consts file_entries) (segment_function consts)) file_entries (segment_at_tick_function consts c))) as (out & env & E & St).
    - right. now exists c.
    - intros g [<-|[<-|[]]]; [now left|now right; left].
    - exact Fi.
    - reflexivity.
    - now right.
    - reflexivity.
    - apply Run.
    - exists out. split; [|exact St].
      assert (En : run_function A (fold_left add_kernel [tube_function consts; control_function consts] (kernels_up_to_law [segment_function consts; segment_at_tick_function consts c])) program_arrays (control_tick_function consts) [UnsignedValue tick] =
        Some (env, out, Some (Some (IntValue (if is_outside_within_first A consts segment position coefficient_at x (number_of_dimensions consts) then 1 else 0)%Z)))) by (started E).
      now rewrite En.
  Qed.
End Execute.
