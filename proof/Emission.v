(* The program that the generator prints for a refined tube of order 1, with constants as parameters. A theorem file compares it with
   what the reader finds in the C text, for the names of variables too. Its functions and directives are printed from the stand-alone
   checker's listing of the C, by `python -m stt_codegen.theorem.emission`.

   Gains, clamp shares and limits are tables by component where they differ; where there is no table, the statements that read it are
   missing. Control.v runs this program, Design.v finds its constants in a text. docs/c.md explains the emitted functions. *)
From Coq Require Import ZArith List String.
From Stt Require Import Syntax.
Import ListNotations.
Open Scope string_scope.
Open Scope list_scope.

(* The integers of a task with ticks: the first tick that is not before t_c, the parts of a segment that a tick takes, the parts that a
   segment has (as an integer and as a real number), and the number of segments. *)
Record tick_numbers := TickNumbers {
  tick_limit : Z;
  tick_multiplier : Z;
  tick_divisor : Z;
  tick_segments : Z;
  tick_divisor_real : decimal
}.

(* The constants of the program. time_rate is K/t_c, last_spline_time the largest spline time below K. gain_upper and gain_lower are the
   gain where the upper and where the lower edge is nearer. clamp_share is (1 - e_max)/2. A table is empty where its value does not
   differ by component, or where there are no limits. *)
Record constants := Constants {
  dimensions : Z;
  time_rate : decimal;
  last_spline_time : decimal;
  gain_upper : decimal;
  gain_lower : decimal;
  gain_table : list decimal;
  limit_table : list decimal;
  clamp_share : decimal;
  clamp_share_table : list decimal;
  is_single : bool;       (* single precision, else double *)
  has_inline_log : bool;  (* the logarithm is written out (math = "inline"), else the library's *)
  tick_constants : option tick_numbers
}.
Definition has_entries (l : list decimal) : bool := match l with [] => false | _ => true end.
Definition gains_differ (k : constants) : bool := has_entries (gain_table k).
Definition has_limits (k : constants) : bool := has_entries (limit_table k).
Definition clamp_shares_differ (k : constants) : bool := has_entries (clamp_share_table k).
Definition log_name (k : constants) : string := if is_single k then "logf" else "log".

(* 0.0, 1.0, 2.0 and 3.0 *)
Definition literal_zero := Decimal false 0 (-1).
Definition literal_one := Decimal false 10 (-1).
Definition literal_two := Decimal false 20 (-1).
Definition literal_three := Decimal false 30 (-1).

(* The functions, statement by statement. *)
Section Emission.
  Variable consts : constants.

  (* The coefficient of the logarithm that is written out, and ln 2. *)
  Definition log_coefficient := if is_single consts then Decimal false 6766044 (-7) else Decimal false 6766043901443481 (-16).
  Definition ln_two := if is_single consts then Decimal false 6931472 (-7) else Decimal false 6931471805599453 (-16).

  (* The two functions that take a number's exponent and mantissa from its bits. Read.v has their texts. *)
  Definition exponent_function := Function "@exponent" "int32_t" [ByValue TReal "y"] [Return (Some (ExponentOf (Var "y")))].
  Definition mantissa_function := Function "@mantissa" "@real" [ByValue TReal "y"] [Return (Some (MantissaOf (Var "y")))].

(* Printed from the checker's listing: *)
  Definition expected_directives (task : string) : list string := [
    ("#include """ ++ task ++ ".h""")%string;
    "#include <float.h>";
    "#include <math.h>";
    "#include <stdbool.h>";
    "#include <stdint.h>"] ++ (if has_inline_log consts then [
    "#include <string.h>"] else []) ++ [
    "#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))";
    ("#error """ ++ task ++ ".c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity""")%string;
    "#endif";
    "#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)";
    ("#error """ ++ task ++ ".c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding""")%string;
    "#endif"] ++ (if is_single consts then [
    "#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)"] else [
    "#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)"]) ++ [
    ("#error """ ++ task ++ ".c: compile for " ++ (if is_single consts then "float" else "double") ++ " arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that""")%string;
    "#endif"] ++ (if is_single consts then [
    "#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)"] else [
    "#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)"]) ++ [
    ("#error """ ++ task ++ ".c: " ++ (if is_single consts then "float" else "double") ++ " is not IEEE-754's here, for which rounding is bounded""")%string;
    "#endif";
    "#if defined(__clang__)";
    "#pragma STDC FP_CONTRACT OFF";
    "#pragma clang fp reassociate(off)";
    "#elif defined(__GNUC__)";
    "#pragma GCC optimize (""fp-contract=off"")";
    "#endif"].
  (* Spline time u = K t / t_c, held from 0 to the last number below K; the row of the table and s = u - floor(u). *)
  Definition segment_function := Function "@segment" "void" [ByValue TReal "t"; ByPointer TInt "row"; ByPointer TReal "s"] ([
    Let TBool "positive" (Binary Less (RealLiteral literal_zero) (Var "t"));
    Let TReal "started" (Select (Var "positive") (Var "t") (RealLiteral literal_zero));
    Let TReal "scaled" (Binary Times (Var "started") (RealLiteral (time_rate consts)));
    Let TBool "early" (Binary Less (Var "scaled") (RealLiteral (last_spline_time consts)));
    Let TReal "u" (Select (Var "early") (Var "scaled") (RealLiteral (last_spline_time consts)));
    Let TInt "segment" (Cast TInt (Var "u"));
    Let TReal "base" (Cast TReal (Var "segment"));
    Let TReal "place" (Binary Minus (Var "u") (Var "base"));
    Let TInt "first" (Binary Times (Var "segment") (IntLiteral (2 * dimensions consts)));
    AssignResult "row" (Operand (Var "first"));
    AssignResult "s" (Operand (Var "place"))]).
  (* The same for a count of ticks, tick_num/tick_den of a segment each, in integers; only s is rounded. *)
  Definition segment_at_tick_function (c : tick_numbers) := Function "@segment_at_tick" "void" [ByValue TUnsigned "tick"; ByPointer TInt "row"; ByPointer TReal "s"] ([
    Let TBool "running" (Binary Less (Var "tick") (UnsignedLiteral (tick_limit c)));
    Let TUnsigned "held" (Select (Var "running") (Var "tick") (UnsignedLiteral (tick_limit c)));
    Let TInt "count" (Cast TInt (Var "held"));
    Let TInt "passed" (Binary Times (Var "count") (IntLiteral (tick_multiplier c)));
    Let TBool "early" (Binary Less (Var "passed") (IntLiteral (tick_divisor c * tick_segments c)));
    Let TInt "place" (Select (Var "early") (Var "passed") (IntLiteral (tick_divisor c * tick_segments c)));
    Let TInt "whole" (Binary Divide (Var "place") (IntLiteral (tick_divisor c)));
    Let TBool "before_last" (Binary Less (Var "whole") (IntLiteral (tick_segments c - 1)));
    Let TInt "segment" (Select (Var "before_last") (Var "whole") (IntLiteral (tick_segments c - 1)));
    Let TInt "base" (Binary Times (Var "segment") (IntLiteral (tick_divisor c)));
    Let TInt "rest" (Binary Minus (Var "place") (Var "base"));
    Let TReal "part" (Cast TReal (Var "rest"));
    Let TReal "share" (Binary Divide (Var "part") (RealLiteral (tick_divisor_real c)));
    Let TInt "first" (Binary Times (Var "segment") (IntLiteral (2 * dimensions consts)));
    AssignResult "row" (Operand (Var "first"));
    AssignResult "s" (Operand (Var "share"))]).
  (* (1 - s)^3, 1 + 3 (1 - s)(1 + s (1 - s)), 1 + 3 s (1 + s (1 - s)), s^3: 6 times the cubic B-spline's weights. *)
  Definition basis_function := Function "@basis" "void" [ByValue TReal "s"; ByPointer TReal "w0"; ByPointer TReal "w1"; ByPointer TReal "w2"; ByPointer TReal "w3"] ([
    Let TReal "v0" (Binary Minus (RealLiteral literal_one) (Var "s"));
    Let TReal "v1" (Binary Times (Var "v0") (Var "v0"));
    Let TReal "v2" (Binary Times (Var "v1") (Var "v0"));
    Let TReal "v3" (Binary Times (Var "v0") (Var "s"));
    Let TReal "v4" (Binary Plus (RealLiteral literal_one) (Var "v3"));
    Let TReal "v5" (Binary Times (RealLiteral literal_three) (Var "v4"));
    Let TReal "v6" (Binary Times (Var "v0") (Var "v5"));
    Let TReal "v7" (Binary Plus (RealLiteral literal_one) (Var "v6"));
    Let TReal "v8" (Binary Times (Var "s") (Var "v5"));
    Let TReal "v9" (Binary Plus (RealLiteral literal_one) (Var "v8"));
    Let TReal "v10" (Binary Times (Var "s") (Var "s"));
    Let TReal "v11" (Binary Times (Var "v10") (Var "s"));
    AssignResult "w0" (Operand (Var "v2"));
    AssignResult "w1" (Operand (Var "v7"));
    AssignResult "w2" (Operand (Var "v9"));
    AssignResult "w3" (Operand (Var "v11"))]).
  (* One edge, or its slope: w0 q0 + w1 q1 + w2 q2 + w3 q3 of four entries of the table, `at` and one, two and three rows after it. *)
  Definition edge_at_function := Function "@edge_at" "@real" [ByValue TInt "at"; ByValue TReal "w0"; ByValue TReal "w1"; ByValue TReal "w2"; ByValue TReal "w3"] ([
    Let TReal "q0" (Load "@coefficients" (Var "at"));
    Let TInt "at_1" (Binary Plus (Var "at") (IntLiteral (2 * dimensions consts)));
    Let TReal "q1" (Load "@coefficients" (Var "at_1"));
    Let TInt "at_2" (Binary Plus (Var "at") (IntLiteral (4 * dimensions consts)));
    Let TReal "q2" (Load "@coefficients" (Var "at_2"));
    Let TInt "at_3" (Binary Plus (Var "at") (IntLiteral (6 * dimensions consts)));
    Let TReal "q3" (Load "@coefficients" (Var "at_3"));
    Let TReal "v0" (Binary Times (Var "w0") (Var "q0"));
    Let TReal "v1" (Binary Times (Var "w1") (Var "q1"));
    Let TReal "v2" (Binary Plus (Var "v0") (Var "v1"));
    Let TReal "v3" (Binary Times (Var "w2") (Var "q2"));
    Let TReal "v4" (Binary Times (Var "w3") (Var "q3"));
    Let TReal "v5" (Binary Plus (Var "v3") (Var "v4"));
    Let TReal "v6" (Binary Plus (Var "v2") (Var "v5"));
    Return (Some (Operand (Var "v6")))]).
  Definition logarithm_statements := [
    Let TInt "exponent" (CallFunction "@exponent" [Var "v0"]);
    Let TReal "base" (Cast TReal (Var "exponent"));
    Let TReal "mantissa" (CallFunction "@mantissa" [Var "v0"]);
    Let TReal "below" (Binary Minus (Var "mantissa") (RealLiteral literal_one));
    Let TReal "above" (Binary Plus (Var "mantissa") (RealLiteral literal_one));
    Let TReal "s" (Binary Divide (Var "below") (Var "above"));
    Let TReal "z" (Binary Times (Var "s") (Var "s"));
    Let TReal "bent" (Binary Times (Var "z") (RealLiteral log_coefficient));
    Let TReal "around" (Binary Plus (Var "bent") (RealLiteral literal_two));
    Let TReal "part" (Binary Times (Var "s") (Var "around"));
    Let TReal "whole" (Binary Times (Var "base") (RealLiteral ln_two));
    Let TReal "v1" (Binary Plus (Var "whole") (Var "part"))].
  (* e, from the distances a and b to both edges; epsilon = -ln(b/a), xi = 1/a + 1/b; u = -k xi epsilon. *)
  Definition transformed_error_function := Function "@transformed_error" "void" [ByValue TReal "a"; ByValue TReal "b"; ByPointer TReal "epsilon"; ByPointer TReal "xi"] ([
    Let TReal "v0" (Binary Divide (Var "b") (Var "a"))] ++ (if has_inline_log consts then logarithm_statements else [
    Let TReal "v1" (CallFunction (log_name consts) [Var "v0"])]) ++ [
    Let TReal "v2" (Negate (Var "v1"));
    Let TReal "v3" (Binary Plus (RealLiteral literal_one) (Var "v0"));
    Let TReal "v4" (Binary Divide (Var "v3") (Var "b"));
    AssignResult "epsilon" (Operand (Var "v2"));
    AssignResult "xi" (Operand (Var "v4"))]).
  Definition law_function := Function "@law" "@real" [ByValue TReal "k"; ByValue TReal "xi"; ByValue TReal "epsilon"] ([
    Let TReal "v0" (Binary Times (Var "k") (Var "xi"));
    Let TReal "v1" (Binary Times (Var "v0") (Var "epsilon"));
    Let TReal "v2" (Negate (Var "v1"));
    Return (Some (Operand (Var "v2")))]).
  Definition segment_and_s_statements := [
    Declare TInt "row";
    Declare TReal "s";
    CallKernel "@segment" [Var "t"] ["row"; "s"]].
  Definition weights_statements := [
    Declare TReal "w0";
    Declare TReal "w1";
    Declare TReal "w2";
    Declare TReal "w3";
    CallKernel "@basis" [Var "s"] ["w0"; "w1"; "w2"; "w3"]].
  Definition places_in_the_table_statements := [
    Let TInt "pair" (Binary Times (Var "i") (IntLiteral 2));
    Let TInt "lower_at" (Binary Plus (Var "row") (Var "pair"));
    Let TInt "upper_at" (Binary Plus (Var "lower_at") (IntLiteral 1))].
  Definition edges_statements := places_in_the_table_statements ++ [
    Let TReal "lower_edge" (CallFunction "@edge_at" [Var "lower_at"; Var "w0"; Var "w1"; Var "w2"; Var "w3"]);
    Let TReal "upper_edge" (CallFunction "@edge_at" [Var "upper_at"; Var "w0"; Var "w1"; Var "w2"; Var "w3"])].
  Definition tube_function := Function "@tube" "void" [ByValue TReal "t"; ArrayOut "lower"; ArrayOut "upper"] ([
    Let TBool "finite" (IsFinite (Var "t"));
    Let TBool "bad" (Not (Var "finite"));
    IfTrue (Var "bad") ([
      For "j" (dimensions consts) ([
        Store "lower" (Var "j") (Operand NotANumber);
        Store "upper" (Var "j") (Operand NotANumber)]);
      Return None])] ++ segment_and_s_statements ++ weights_statements ++ [
    For "i" (dimensions consts) (edges_statements ++ [
      Store "lower" (Var "i") (Operand (Var "lower_edge"));
      Store "upper" (Var "i") (Operand (Var "upper_edge"))])]).
  Definition sum_of_zeros_statements := [
    For "j" (dimensions consts) ([
      Let TReal "x_j" (Load "x" (Var "j"));
      Let TReal "x_zero" (Binary Times (Var "x_j") (RealLiteral literal_zero));
      Let TReal "zeros" (Binary Plus (Var "zero") (Var "x_zero"));
      Assign "zero" (Operand (Var "zeros"))]);
    Let TBool "finite" (Binary AtMost (Var "zero") (RealLiteral literal_zero));
    Let TBool "bad" (Not (Var "finite"))].
  Definition inputs_that_are_not_finite_statements := sum_of_zeros_statements ++ [
    IfTrue (Var "bad") ([
      For "m" (dimensions consts) ([
        Store "u" (Var "m") (Operand (RealLiteral literal_zero))]);
      Return (Some (Operand (IntLiteral 2)))])].
  Definition state_between_the_edges_statements := edges_statements ++ [
    Let TReal "x_i" (Load "x" (Var "i"))] ++ (if clamp_shares_differ consts then [
    Let TReal "least_share_i" (Load "@least_share" (Var "i"))] else []) ++ (if gains_differ consts then [
    Let TReal "gain_i" (Load "@gain" (Var "i"));
    Let TReal "gain_minus" (Negate (Var "gain_i"))] else []) ++ [
    Let TReal "width" (Binary Minus (Var "upper_edge") (Var "lower_edge"));
    Let TReal "to_lower" (Binary Minus (Var "x_i") (Var "lower_edge"));
    Let TReal "to_upper" (Binary Minus (Var "upper_edge") (Var "x_i"));
    Let TBool "upper_nearer" (Binary Less (Var "to_upper") (Var "to_lower"));
    Let TReal "distance" (Select (Var "upper_nearer") (Var "to_upper") (Var "to_lower"))] ++ (if gains_differ consts then [
    Let TReal "gain" (Select (Var "upper_nearer") (Var "gain_minus") (Var "gain_i"))] else [
    Let TReal "gain" (Select (Var "upper_nearer") (RealLiteral (gain_upper consts)) (RealLiteral (gain_lower consts)))]) ++ (if clamp_shares_differ consts then [
    Let TReal "smallest" (Binary Times (Var "width") (Var "least_share_i"))] else [
    Let TReal "smallest" (Binary Times (Var "width") (RealLiteral (clamp_share consts)))]) ++ [
    Let TBool "clear" (Binary Less (Var "smallest") (Var "distance"));
    Let TReal "to_nearer" (Select (Var "clear") (Var "distance") (Var "smallest"));
    Let TReal "to_farther" (Binary Minus (Var "width") (Var "to_nearer"));
    Let TBool "inside" (Binary Less (RealLiteral literal_zero) (Var "distance"));
    Let TBool "outside_next" (Select (Var "inside") (Var "outside") (BoolLiteral true))].
  Definition law_statements := weights_statements ++ [
    Let TBool "outside" (Operand (BoolLiteral false));
    For "i" (dimensions consts) (state_between_the_edges_statements ++ (if has_limits consts then [
      Let TReal "u_limit" (Load "@u_max" (Var "i"))] else []) ++ [
      Declare TReal "epsilon";
      Declare TReal "xi";
      CallKernel "@transformed_error" [Var "to_nearer"; Var "to_farther"] ["epsilon"; "xi"];
      Let TReal "u_i" (CallFunction "@law" [Var "gain"; Var "xi"; Var "epsilon"])] ++ (if has_limits consts then [
      Let TReal "u_min" (Negate (Var "u_limit"));
      Let TBool "u_above" (Binary Less (Var "u_min") (Var "u_i"));
      Let TReal "u_raised" (Select (Var "u_above") (Var "u_i") (Var "u_min"));
      Let TBool "u_beyond" (Binary Less (Var "u_limit") (Var "u_raised"));
      Let TReal "u_limited" (Select (Var "u_beyond") (Var "u_limit") (Var "u_raised"));
      Store "u" (Var "i") (Operand (Var "u_limited"))] else [
      Store "u" (Var "i") (Operand (Var "u_i"))]) ++ [
      Assign "outside" (Operand (Var "outside_next"))]);
    Return (Some (Select (Var "outside") (IntLiteral 1) (IntLiteral 0)))].
  Definition control_function := Function "@control" "@status" [ByValue TReal "t"; ArrayIn "x"; ArrayOut "u"] ([
    Let TReal "t_zero" (Binary Times (Var "t") (RealLiteral literal_zero));
    Let TReal "zero" (Operand (Var "t_zero"))] ++ inputs_that_are_not_finite_statements ++ segment_and_s_statements ++ law_statements).
  Definition control_tick_function := Function "@control_tick" "@status" [ByValue TUnsigned "tick"; ArrayIn "x"; ArrayOut "u"] ([
    Let TReal "zero" (Operand (RealLiteral literal_zero))] ++ inputs_that_are_not_finite_statements ++ [
    Declare TInt "row";
    Declare TReal "s";
    CallKernel "@segment_at_tick" [Var "tick"] ["row"; "s"]] ++ law_statements).
(* End of what is printed. *)

  (* The tables of the file that the functions read. *)
  Definition emitted_tables (coefficients : list decimal) :=
    [("@coefficients", coefficients)] ++ (if gains_differ consts then [("@gain", gain_table consts)] else []) ++
    (if clamp_shares_differ consts then [("@least_share", clamp_share_table consts)] else []) ++ (if has_limits consts then [("@u_max", limit_table consts)] else []).

  (* The functions that the theorem is about, in the order of the file. The file has other functions; these call none of them and are
     called by none of them. *)
  Definition bit_helpers := if has_inline_log consts then [exponent_function; mantissa_function] else [].
  Definition if_ticks (fs : tick_numbers -> list function) : list function := match tick_constants consts with Some c => fs c | None => [] end.
  Definition emitted_functions := bit_helpers ++ [segment_function] ++ if_ticks (fun c => [segment_at_tick_function c]) ++
    [basis_function; edge_at_function; transformed_error_function; law_function; tube_function; control_function] ++ if_ticks (fun _ => [control_tick_function]).
End Emission.

(* Names of the functions that the theorem is about, and of the tables that they read. *)
Definition relevant_functions : list string := ["@exponent"; "@mantissa"; "@segment"; "@segment_at_tick"; "@basis"; "@edge_at"; "@transformed_error"; "@law"; "@tube"; "@control"; "@control_tick"].
Definition relevant_tables : list string := ["@coefficients"; "@gain"; "@least_share"; "@u_max"].
(* A file without its other functions and tables. *)
Definition relevant_part (s : source) : source :=
  Source (directives s) (filter (fun t => List.existsb (String.eqb (fst t)) relevant_tables) (tables s)) (filter (fun f => List.existsb (String.eqb (function_name f)) relevant_functions) (functions s)).
