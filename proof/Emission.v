(* The program that the generator prints for a refined tube of order 1, with constants as parameters. A theorem file compares it with
   what the reader finds in the C text, for the names of variables too.

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

  (* From a time to the first row of its segment and the position s in it. *)
  Definition segment_function := Function "@segment" "void" [ByValue TReal "t"; ByPointer TInt "row"; ByPointer TReal "s"] [
    Let TBool "positive" (Binary Less (RealLiteral literal_zero) (Var "t"));
    Let TReal "started" (Select (Var "positive") (Var "t") (RealLiteral literal_zero));
    Let TReal "scaled" (Binary Times (Var "started") (RealLiteral (time_rate consts)));
    Let TBool "early" (Binary Less (Var "scaled") (RealLiteral (last_spline_time consts)));
    Let TReal "u" (Select (Var "early") (Var "scaled") (RealLiteral (last_spline_time consts)));
    Let TInt "segment" (Cast TInt (Var "u"));
    Let TReal "base" (Cast TReal (Var "segment"));
    Let TReal "place" (Binary Minus (Var "u") (Var "base"));
    Let TInt "first" (Binary Times (Var "segment") (IntLiteral (2 * dimensions consts)));
    AssignResult "row" (Operand (Var "first")); AssignResult "s" (Operand (Var "place"))].

  (* The same from a count of ticks, in integers but for the last division. *)
  Definition segment_at_tick_function (c : tick_numbers) := Function "@segment_at_tick" "void" [ByValue TUnsigned "tick"; ByPointer TInt "row"; ByPointer TReal "s"] [
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
    AssignResult "row" (Operand (Var "first")); AssignResult "s" (Operand (Var "share"))].

  (* The weights of the four control points at s. *)
  Definition basis_function := Function "@basis" "void" [ByValue TReal "s"; ByPointer TReal "w0"; ByPointer TReal "w1"; ByPointer TReal "w2"; ByPointer TReal "w3"] [
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
    AssignResult "w0" (Operand (Var "v2")); AssignResult "w1" (Operand (Var "v7")); AssignResult "w2" (Operand (Var "v9")); AssignResult "w3" (Operand (Var "v11"))].

  (* An edge: the sum of weights times control points. *)
  Definition blend_function := Function "@blend" "@real"
    [ByValue TReal "w0"; ByValue TReal "w1"; ByValue TReal "w2"; ByValue TReal "w3"; ByValue TReal "q0"; ByValue TReal "q1"; ByValue TReal "q2"; ByValue TReal "q3"] [
    Let TReal "v0" (Binary Times (Var "w0") (Var "q0"));
    Let TReal "v1" (Binary Times (Var "w1") (Var "q1"));
    Let TReal "v2" (Binary Plus (Var "v0") (Var "v1"));
    Let TReal "v3" (Binary Times (Var "w2") (Var "q2"));
    Let TReal "v4" (Binary Times (Var "w3") (Var "q3"));
    Let TReal "v5" (Binary Plus (Var "v3") (Var "v4"));
    Let TReal "v6" (Binary Plus (Var "v2") (Var "v5"));
    Return (Some (Operand (Var "v6")))].

  Definition exponent_function := Function "@exponent" "int32_t" [ByValue TReal "y"] [Return (Some (ExponentOf (Var "y")))].
  Definition mantissa_function := Function "@mantissa" "@real" [ByValue TReal "y"] [Return (Some (MantissaOf (Var "y")))].

  (* The logarithm: v1 = ln v0, by the library or written out. *)
  Definition log_coefficient := if is_single consts then Decimal false 6766044 (-7) else Decimal false 6766043901443481 (-16).
  Definition ln_two := if is_single consts then Decimal false 6931472 (-7) else Decimal false 6931471805599453 (-16).
  Definition logarithm_statements := if has_inline_log consts then [
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
    Let TReal "v1" (Binary Plus (Var "whole") (Var "part"))]
  else [Let TReal "v1" (CallFunction (log_name consts) [Var "v0"])].

  (* From the nearer and the farther distance to epsilon and xi, up to sign. *)
  Definition transformed_error_function := Function "@transformed_error" "void"
    [ByValue TReal "a"; ByValue TReal "b"; ByPointer TReal "epsilon"; ByPointer TReal "xi"] ([
    Let TReal "v0" (Binary Divide (Var "b") (Var "a"))] ++ logarithm_statements ++ [
    Let TReal "v2" (Negate (Var "v1"));
    Let TReal "v3" (Binary Plus (RealLiteral literal_one) (Var "v0"));
    Let TReal "v4" (Binary Divide (Var "v3") (Var "b"));
    AssignResult "epsilon" (Operand (Var "v2")); AssignResult "xi" (Operand (Var "v4"))]).

  (* The law (13): -k xi epsilon. *)
  Definition law_function := Function "@law" "@real" [ByValue TReal "k"; ByValue TReal "xi"; ByValue TReal "epsilon"] [
    Let TReal "v0" (Binary Times (Var "k") (Var "xi"));
    Let TReal "v1" (Binary Times (Var "v0") (Var "epsilon"));
    Let TReal "v2" (Negate (Var "v1"));
    Return (Some (Operand (Var "v2")))].

  (* Calls that compute the segment, by a function of the time or the count of ticks, and the weights. *)
  Definition position_statements (segment clock : string) := [
    Declare TInt "row"; Declare TReal "s"; CallKernel segment [Var clock] ["row"; "s"];
    Declare TReal "w0"; Declare TReal "w1"; Declare TReal "w2"; Declare TReal "w3";
    CallKernel "@basis" [Var "s"] ["w0"; "w1"; "w2"; "w3"]].

  Definition blend_call (q0 q1 q2 q3 : string) := CallFunction "@blend" [Var "w0"; Var "w1"; Var "w2"; Var "w3"; Var q0; Var q1; Var q2; Var q3].

  (* The lower and the upper edge of dimension i. *)
  Definition lower_statements := [
    Let TInt "pair" (Binary Times (Var "i") (IntLiteral 2));
    Let TInt "at" (Binary Plus (Var "row") (Var "pair"));
    Let TReal "lower_q0" (Load "@coefficients" (Var "at"));
    Let TInt "lower_1" (Binary Plus (Var "at") (IntLiteral (2 * dimensions consts)));
    Let TReal "lower_q1" (Load "@coefficients" (Var "lower_1"));
    Let TInt "lower_2" (Binary Plus (Var "at") (IntLiteral (4 * dimensions consts)));
    Let TReal "lower_q2" (Load "@coefficients" (Var "lower_2"));
    Let TInt "lower_3" (Binary Plus (Var "at") (IntLiteral (6 * dimensions consts)));
    Let TReal "lower_q3" (Load "@coefficients" (Var "lower_3"));
    Let TReal "lower_edge" (blend_call "lower_q0" "lower_q1" "lower_q2" "lower_q3")].
  Definition upper_statements := [
    Let TInt "upper_0" (Binary Plus (Var "at") (IntLiteral 1));
    Let TReal "upper_q0" (Load "@coefficients" (Var "upper_0"));
    Let TInt "upper_1" (Binary Plus (Var "at") (IntLiteral (2 * dimensions consts + 1)));
    Let TReal "upper_q1" (Load "@coefficients" (Var "upper_1"));
    Let TInt "upper_2" (Binary Plus (Var "at") (IntLiteral (4 * dimensions consts + 1)));
    Let TReal "upper_q2" (Load "@coefficients" (Var "upper_2"));
    Let TInt "upper_3" (Binary Plus (Var "at") (IntLiteral (6 * dimensions consts + 1)));
    Let TReal "upper_q3" (Load "@coefficients" (Var "upper_3"));
    Let TReal "upper_edge" (blend_call "upper_q0" "upper_q1" "upper_q2" "upper_q3")].

  Definition tube_body :=
    lower_statements ++ [Store "lower" (Var "i") (Operand (Var "lower_edge"))] ++ upper_statements ++ [Store "upper" (Var "i") (Operand (Var "upper_edge"))].

  (* `tube`: both edges of all dimensions, NaN for a time that is not finite. *)
  Definition tube_function := Function "@tube" "void" [ByValue TReal "t"; ArrayOut "lower"; ArrayOut "upper"] ([
    Let TBool "finite" (IsFinite (Var "t"));
    Let TBool "bad" (Not (Var "finite"));
    IfTrue (Var "bad") [
      For "j" (dimensions consts) [Store "lower" (Var "j") (Operand NotANumber); Store "upper" (Var "j") (Operand NotANumber)];
      Return None]] ++
    position_statements "@segment" "t" ++ [For "i" (dimensions consts) tube_body]).

  Definition finite_test_body := [
    Let TReal "x_j" (Load "x" (Var "j"));
    Let TReal "x_zero" (Binary Times (Var "x_j") (RealLiteral literal_zero));
    Let TReal "zeros" (Binary Plus (Var "zero") (Var "x_zero"));
    Assign "zero" (Operand (Var "zeros"))].

  (* Statements that exist only with a table of clamp shares, of gains, or of limits. *)
  Definition clamp_share_statements := if clamp_shares_differ consts then [
    Let TReal "least_share_i" (Load "@least_share" (Var "i"))] else [].
  Definition gain_statements := if gains_differ consts then [
    Let TReal "gain_i" (Load "@gain" (Var "i"));
    Let TReal "gain_minus" (Negate (Var "gain_i"))] else [].
  Definition limit_statements := if has_limits consts then [
    Let TReal "u_limit" (Load "@u_max" (Var "i"))] else [].
  Definition saturation_statements := if has_limits consts then [
    Let TReal "u_min" (Negate (Var "u_limit"));
    Let TBool "u_held_above" (Binary Less (Var "u_min") (Var "push"));
    Let TReal "u_held_raised" (Select (Var "u_held_above") (Var "push") (Var "u_min"));
    Let TBool "u_held_over" (Binary Less (Var "u_limit") (Var "u_held_raised"));
    Let TReal "u_held" (Select (Var "u_held_over") (Var "u_limit") (Var "u_held_raised"))] else [].

  (* The input of component i, from its edges. *)
  Definition law_statements := [
    Let TReal "x_i" (Load "x" (Var "i"))] ++ clamp_share_statements ++ gain_statements ++ [
    Let TReal "room" (Binary Minus (Var "upper_edge") (Var "lower_edge"));
    Let TReal "to_lower" (Binary Minus (Var "x_i") (Var "lower_edge"));
    Let TReal "to_upper" (Binary Minus (Var "upper_edge") (Var "x_i"));
    Let TBool "upper_nearer" (Binary Less (Var "to_upper") (Var "to_lower"));
    Let TReal "nearest" (Select (Var "upper_nearer") (Var "to_upper") (Var "to_lower"));
    Let TReal "gain" (if gains_differ consts then Select (Var "upper_nearer") (Var "gain_minus") (Var "gain_i")
                      else Select (Var "upper_nearer") (RealLiteral (gain_upper consts)) (RealLiteral (gain_lower consts)));
    Let TReal "least" (Binary Times (Var "room") (if clamp_shares_differ consts then Var "least_share_i" else RealLiteral (clamp_share consts)));
    Let TBool "clear" (Binary Less (Var "least") (Var "nearest"));
    Let TReal "near" (Select (Var "clear") (Var "nearest") (Var "least"));
    Let TReal "far" (Binary Minus (Var "room") (Var "near"));
    Let TBool "within" (Binary Less (RealLiteral literal_zero) (Var "nearest"));
    Let TBool "outside_any" (Select (Var "within") (Var "outside") (BoolLiteral true))] ++ limit_statements ++ [
    Declare TReal "epsilon"; Declare TReal "xi";
    CallKernel "@transformed_error" [Var "near"; Var "far"] ["epsilon"; "xi"];
    Let TReal "push" (CallFunction "@law" [Var "gain"; Var "xi"; Var "epsilon"])] ++ saturation_statements ++ [
    Store "u" (Var "i") (Operand (Var (if has_limits consts then "u_held" else "push")));
    Assign "outside" (Operand (Var "outside_any"))].

  Definition control_body := lower_statements ++ upper_statements ++ law_statements.

  (* The test whether all inputs are finite: `zero` is 0 then, and NaN otherwise. *)
  Definition finite_test_statements := [
    For "j" (dimensions consts) finite_test_body;
    Let TBool "finite" (Binary AtMost (Var "zero") (RealLiteral literal_zero));
    Let TBool "bad" (Not (Var "finite"));
    IfTrue (Var "bad") [
      For "j2" (dimensions consts) [Store "u" (Var "j2") (Operand (RealLiteral literal_zero))];
      Return (Some (Operand (IntLiteral 2)))]].
  Definition dimension_loop_statements := [
    Let TBool "outside" (Operand (BoolLiteral false));
    For "i" (dimensions consts) control_body;
    Return (Some (Select (Var "outside") (IntLiteral 1) (IntLiteral 0)))].
  (* What `control` and `control_tick` have in common. *)
  Definition statements_after_clock (segment clock : string) := finite_test_statements ++ position_statements segment clock ++ dimension_loop_statements.

  Definition control_function := Function "@control" "@status" [ByValue TReal "t"; ArrayIn "x"; ArrayOut "u"] ([
    Let TReal "t_zero" (Binary Times (Var "t") (RealLiteral literal_zero));
    Let TReal "zero" (Operand (Var "t_zero"))] ++
    statements_after_clock "@segment" "t").
  Definition control_tick_function := Function "@control_tick" "@status" [ByValue TUnsigned "tick"; ArrayIn "x"; ArrayOut "u"] ([
    Let TReal "zero" (Operand (RealLiteral literal_zero))] ++
    statements_after_clock "@segment_at_tick" "tick").

  (* The tables of the file that the functions read. *)
  Definition emitted_tables (coefficients : list decimal) :=
    [("@coefficients", coefficients)] ++ (if gains_differ consts then [("@gain", gain_table consts)] else []) ++
    (if clamp_shares_differ consts then [("@least_share", clamp_share_table consts)] else []) ++ (if has_limits consts then [("@u_max", limit_table consts)] else []).

  (* The functions that the theorem is about, in the order of the file. The file has other functions; these call none of them and are
     called by none of them. *)
  Definition bit_helpers := if has_inline_log consts then [exponent_function; mantissa_function] else [].
  Definition if_ticks (fs : tick_numbers -> list function) : list function := match tick_constants consts with Some c => fs c | None => [] end.
  Definition emitted_functions := bit_helpers ++ [segment_function] ++ if_ticks (fun c => [segment_at_tick_function c]) ++
    [basis_function; blend_function; transformed_error_function; law_function; tube_function; control_function] ++ if_ticks (fun _ => [control_tick_function]).
End Emission.

(* Names of the functions that the theorem is about, and of the tables that they read. *)
Definition relevant_functions : list string := ["@exponent"; "@mantissa"; "@segment"; "@segment_at_tick"; "@basis"; "@blend"; "@transformed_error"; "@law"; "@tube"; "@control"; "@control_tick"].
Definition relevant_tables : list string := ["@coefficients"; "@gain"; "@least_share"; "@u_max"].
(* A file without its other functions and tables. *)
Definition relevant_part (s : source) : source :=
  Source (directives s) (filter (fun t => List.existsb (String.eqb (fst t)) relevant_tables) (tables s)) (filter (fun f => List.existsb (String.eqb (function_name f)) relevant_functions) (functions s)).
