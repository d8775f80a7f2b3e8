(* The program that the generator prints for a refined tube, order 1, up to its constants: the reader's result is compared with it.
   Gains that differ and limits of u are tables, by component; where there are none, so are the statements that use them. *)
From Coq Require Import ZArith List String.
From Stt Require Import Syntax.
Import ListNotations.
Open Scope string_scope.
Open Scope list_scope.

(* Of a task with ticks: the first that is not before t_c, of how many the divisor's a tick is in a segment, and how many segments there are. *)
Record tick_numbers := TickNumbers {
  tick_limit : Z;
  tick_multiplier : Z;
  tick_divisor : Z;
  tick_segments : Z;
  tick_share : decimal (* the divisor once more, as a real number *)
}.

Record constants := Constants {
  dimensions : Z;
  rate : decimal;       (* spline time a second *)
  last : decimal;       (* the last spline time *)
  gain_upper : decimal; (* gain where the upper edge is nearer, and where the lower one is *)
  gain_lower : decimal;
  gain_table : list decimal;  (* the gain by component where it differs; else empty *)
  limit_table : list decimal; (* u_max by component where there is one; else empty *)
  clamp : decimal;      (* (1 - e_max) / 2 *)
  clamp_table : list decimal; (* the same by component where it differs; else empty *)
  single : bool;        (* binary32, else binary64 *)
  written_out : bool;   (* the logarithm: by exponent and mantissa, else the library's *)
  tick_constants : option tick_numbers
}.
Definition any (l : list decimal) : bool := match l with [] => false | _ => true end.
Definition several (k : constants) : bool := any (gain_table k).
Definition limited (k : constants) : bool := any (limit_table k).
Definition clamps_differ (k : constants) : bool := any (clamp_table k).
Definition log_name (k : constants) : string := if single k then "logf" else "log".

Definition zero := Decimal false 0 (-1).
Definition one := Decimal false 10 (-1).
Definition two := Decimal false 20 (-1).
Definition three := Decimal false 30 (-1).

Section Emission.
  Variable k : constants.

  Definition segment_function := Function "@segment" "void" [ByValue TReal "t"; ByPointer TInt "row"; ByPointer TReal "s"] [
    Let TBool "positive" (Binary Less (Real zero) (Name "t"));
    Let TReal "started" (Select (Name "positive") (Name "t") (Real zero));
    Let TReal "scaled" (Binary Times (Name "started") (Real (rate k)));
    Let TBool "early" (Binary Less (Name "scaled") (Real (last k)));
    Let TReal "u" (Select (Name "early") (Name "scaled") (Real (last k)));
    Let TInt "segment" (Cast TInt (Name "u"));
    Let TReal "base" (Cast TReal (Name "segment"));
    Let TReal "place" (Binary Minus (Name "u") (Name "base"));
    Let TInt "first" (Binary Times (Name "segment") (Int (2 * dimensions k)));
    Put "row" (Atom (Name "first")); Put "s" (Atom (Name "place"))].

  Definition segment_at_tick_function (c : tick_numbers) := Function "@segment_at_tick" "void" [ByValue TUnsigned "tick"; ByPointer TInt "row"; ByPointer TReal "s"] [
    Let TBool "running" (Binary Less (Name "tick") (Unsigned (tick_limit c)));
    Let TUnsigned "held" (Select (Name "running") (Name "tick") (Unsigned (tick_limit c)));
    Let TInt "count" (Cast TInt (Name "held"));
    Let TInt "passed" (Binary Times (Name "count") (Int (tick_multiplier c)));
    Let TBool "early" (Binary Less (Name "passed") (Int (tick_divisor c * tick_segments c)));
    Let TInt "place" (Select (Name "early") (Name "passed") (Int (tick_divisor c * tick_segments c)));
    Let TInt "whole" (Binary Over (Name "place") (Int (tick_divisor c)));
    Let TBool "before_last" (Binary Less (Name "whole") (Int (tick_segments c - 1)));
    Let TInt "segment" (Select (Name "before_last") (Name "whole") (Int (tick_segments c - 1)));
    Let TInt "base" (Binary Times (Name "segment") (Int (tick_divisor c)));
    Let TInt "rest" (Binary Minus (Name "place") (Name "base"));
    Let TReal "part" (Cast TReal (Name "rest"));
    Let TReal "share" (Binary Over (Name "part") (Real (tick_share c)));
    Let TInt "first" (Binary Times (Name "segment") (Int (2 * dimensions k)));
    Put "row" (Atom (Name "first")); Put "s" (Atom (Name "share"))].

  Definition basis_function := Function "@basis" "void" [ByValue TReal "s"; ByPointer TReal "w0"; ByPointer TReal "w1"; ByPointer TReal "w2"; ByPointer TReal "w3"] [
    Let TReal "v0" (Binary Minus (Real one) (Name "s"));
    Let TReal "v1" (Binary Times (Name "v0") (Name "v0"));
    Let TReal "v2" (Binary Times (Name "v1") (Name "v0"));
    Let TReal "v3" (Binary Times (Name "v0") (Name "s"));
    Let TReal "v4" (Binary Plus (Real one) (Name "v3"));
    Let TReal "v5" (Binary Times (Real three) (Name "v4"));
    Let TReal "v6" (Binary Times (Name "v0") (Name "v5"));
    Let TReal "v7" (Binary Plus (Real one) (Name "v6"));
    Let TReal "v8" (Binary Times (Name "s") (Name "v5"));
    Let TReal "v9" (Binary Plus (Real one) (Name "v8"));
    Let TReal "v10" (Binary Times (Name "s") (Name "s"));
    Let TReal "v11" (Binary Times (Name "v10") (Name "s"));
    Put "w0" (Atom (Name "v2")); Put "w1" (Atom (Name "v7")); Put "w2" (Atom (Name "v9")); Put "w3" (Atom (Name "v11"))].

  Definition blend_function := Function "@blend" "@real"
    [ByValue TReal "w0"; ByValue TReal "w1"; ByValue TReal "w2"; ByValue TReal "w3"; ByValue TReal "q0"; ByValue TReal "q1"; ByValue TReal "q2"; ByValue TReal "q3"] [
    Let TReal "v0" (Binary Times (Name "w0") (Name "q0"));
    Let TReal "v1" (Binary Times (Name "w1") (Name "q1"));
    Let TReal "v2" (Binary Plus (Name "v0") (Name "v1"));
    Let TReal "v3" (Binary Times (Name "w2") (Name "q2"));
    Let TReal "v4" (Binary Times (Name "w3") (Name "q3"));
    Let TReal "v5" (Binary Plus (Name "v3") (Name "v4"));
    Let TReal "v6" (Binary Plus (Name "v2") (Name "v5"));
    Return (Some (Atom (Name "v6")))].

  Definition exponent_function := Function "@exponent" "int32_t" [ByValue TReal "y"] [Return (Some (ExponentOf (Name "y")))].
  Definition mantissa_function := Function "@mantissa" "@real" [ByValue TReal "y"] [Return (Some (MantissaOf (Name "y")))].

  (* v1 = ln v0 *)
  Definition bend := if single k then Decimal false 6766044 (-7) else Decimal false 6766043901443481 (-16).
  Definition ln_two := if single k then Decimal false 6931472 (-7) else Decimal false 6931471805599453 (-16).
  Definition logarithm_statements := if written_out k then [
    Let TInt "exponent" (Apply "@exponent" [Name "v0"]);
    Let TReal "base" (Cast TReal (Name "exponent"));
    Let TReal "mantissa" (Apply "@mantissa" [Name "v0"]);
    Let TReal "below" (Binary Minus (Name "mantissa") (Real one));
    Let TReal "above" (Binary Plus (Name "mantissa") (Real one));
    Let TReal "s" (Binary Over (Name "below") (Name "above"));
    Let TReal "z" (Binary Times (Name "s") (Name "s"));
    Let TReal "bent" (Binary Times (Name "z") (Real bend));
    Let TReal "around" (Binary Plus (Name "bent") (Real two));
    Let TReal "part" (Binary Times (Name "s") (Name "around"));
    Let TReal "whole" (Binary Times (Name "base") (Real ln_two));
    Let TReal "v1" (Binary Plus (Name "whole") (Name "part"))]
  else [Let TReal "v1" (Apply (log_name k) [Name "v0"])].

  Definition transformed_error_function := Function "@transformed_error" "void"
    [ByValue TReal "a"; ByValue TReal "b"; ByPointer TReal "epsilon"; ByPointer TReal "xi"] ([
    Let TReal "v0" (Binary Over (Name "b") (Name "a"))] ++ logarithm_statements ++ [
    Let TReal "v2" (Negate (Name "v1"));
    Let TReal "v3" (Binary Plus (Real one) (Name "v0"));
    Let TReal "v4" (Binary Over (Name "v3") (Name "b"));
    Put "epsilon" (Atom (Name "v2")); Put "xi" (Atom (Name "v4"))]).

  Definition law_function := Function "@law" "@real" [ByValue TReal "k"; ByValue TReal "xi"; ByValue TReal "epsilon"] [
    Let TReal "v0" (Binary Times (Name "k") (Name "xi"));
    Let TReal "v1" (Binary Times (Name "v0") (Name "epsilon"));
    Let TReal "v2" (Negate (Name "v1"));
    Return (Some (Atom (Name "v2")))].

  (* the segment by a kernel of a time or a count of ticks, and the weights in it *)
  Definition place_statements (segment clock : string) := [
    Declare TInt "row"; Declare TReal "s"; Call segment [Name clock] ["row"; "s"];
    Declare TReal "w0"; Declare TReal "w1"; Declare TReal "w2"; Declare TReal "w3";
    Call "@basis" [Name "s"] ["w0"; "w1"; "w2"; "w3"]].

  Definition blended (q0 q1 q2 q3 : string) := Apply "@blend" [Name "w0"; Name "w1"; Name "w2"; Name "w3"; Name q0; Name q1; Name q2; Name q3].

  (* the edges of dimension i; `stored` comes between them in `tube` *)
  Definition lower_statements := [
    Let TInt "pair" (Binary Times (Name "i") (Int 2));
    Let TInt "at" (Binary Plus (Name "row") (Name "pair"));
    Let TReal "lower_q0" (Load "@coefficients" (Name "at"));
    Let TInt "lower_1" (Binary Plus (Name "at") (Int (2 * dimensions k)));
    Let TReal "lower_q1" (Load "@coefficients" (Name "lower_1"));
    Let TInt "lower_2" (Binary Plus (Name "at") (Int (4 * dimensions k)));
    Let TReal "lower_q2" (Load "@coefficients" (Name "lower_2"));
    Let TInt "lower_3" (Binary Plus (Name "at") (Int (6 * dimensions k)));
    Let TReal "lower_q3" (Load "@coefficients" (Name "lower_3"));
    Let TReal "lower_edge" (blended "lower_q0" "lower_q1" "lower_q2" "lower_q3")].
  Definition upper_statements := [
    Let TInt "upper_0" (Binary Plus (Name "at") (Int 1));
    Let TReal "upper_q0" (Load "@coefficients" (Name "upper_0"));
    Let TInt "upper_1" (Binary Plus (Name "at") (Int (2 * dimensions k + 1)));
    Let TReal "upper_q1" (Load "@coefficients" (Name "upper_1"));
    Let TInt "upper_2" (Binary Plus (Name "at") (Int (4 * dimensions k + 1)));
    Let TReal "upper_q2" (Load "@coefficients" (Name "upper_2"));
    Let TInt "upper_3" (Binary Plus (Name "at") (Int (6 * dimensions k + 1)));
    Let TReal "upper_q3" (Load "@coefficients" (Name "upper_3"));
    Let TReal "upper_edge" (blended "upper_q0" "upper_q1" "upper_q2" "upper_q3")].

  Definition tube_body :=
    lower_statements ++ [Store "lower" (Name "i") (Atom (Name "lower_edge"))] ++ upper_statements ++ [Store "upper" (Name "i") (Atom (Name "upper_edge"))].

  Definition tube_function := Function "@tube" "void" [ByValue TReal "t"; ArrayOut "lower"; ArrayOut "upper"] ([
    Let TBool "finite" (Finite (Name "t"));
    Let TBool "bad" (Not (Name "finite"));
    When (Name "bad") [
      For "j" (dimensions k) [Store "lower" (Name "j") (Atom NotANumber); Store "upper" (Name "j") (Atom NotANumber)];
      Return None]] ++
    place_statements "@segment" "t" ++ [For "i" (dimensions k) tube_body]).

  Definition inputs_body := [
    Let TReal "x_j" (Load "x" (Name "j"));
    Let TReal "x_zero" (Binary Times (Name "x_j") (Real zero));
    Let TReal "zeros" (Binary Plus (Name "zero") (Name "x_zero"));
    Set_ "zero" (Atom (Name "zeros"))].

  (* what is there only with a table of clamps, only with one of gains, and only with one of limits *)
  Definition clamp_statements := if clamps_differ k then [
    Let TReal "least_share_i" (Load "@least_share" (Name "i"))] else [].
  Definition gain_statements := if several k then [
    Let TReal "gain_i" (Load "@gain" (Name "i"));
    Let TReal "gain_minus" (Negate (Name "gain_i"))] else [].
  Definition limit_statements := if limited k then [
    Let TReal "u_limit" (Load "@u_max" (Name "i"))] else [].
  Definition held_statements := if limited k then [
    Let TReal "u_min" (Negate (Name "u_limit"));
    Let TBool "u_held_above" (Binary Less (Name "u_min") (Name "push"));
    Let TReal "u_held_raised" (Select (Name "u_held_above") (Name "push") (Name "u_min"));
    Let TBool "u_held_over" (Binary Less (Name "u_limit") (Name "u_held_raised"));
    Let TReal "u_held" (Select (Name "u_held_over") (Name "u_limit") (Name "u_held_raised"))] else [].

  Definition law_statements := [
    Let TReal "x_i" (Load "x" (Name "i"))] ++ clamp_statements ++ gain_statements ++ [
    Let TReal "room" (Binary Minus (Name "upper_edge") (Name "lower_edge"));
    Let TReal "to_lower" (Binary Minus (Name "x_i") (Name "lower_edge"));
    Let TReal "to_upper" (Binary Minus (Name "upper_edge") (Name "x_i"));
    Let TBool "upper_nearer" (Binary Less (Name "to_upper") (Name "to_lower"));
    Let TReal "nearest" (Select (Name "upper_nearer") (Name "to_upper") (Name "to_lower"));
    Let TReal "gain" (if several k then Select (Name "upper_nearer") (Name "gain_minus") (Name "gain_i")
                      else Select (Name "upper_nearer") (Real (gain_upper k)) (Real (gain_lower k)));
    Let TReal "least" (Binary Times (Name "room") (if clamps_differ k then Name "least_share_i" else Real (clamp k)));
    Let TBool "clear" (Binary Less (Name "least") (Name "nearest"));
    Let TReal "near" (Select (Name "clear") (Name "nearest") (Name "least"));
    Let TReal "far" (Binary Minus (Name "room") (Name "near"));
    Let TBool "within" (Binary Less (Real zero) (Name "nearest"));
    Let TBool "outside_any" (Select (Name "within") (Name "outside") (Truth true))] ++ limit_statements ++ [
    Declare TReal "epsilon"; Declare TReal "xi";
    Call "@transformed_error" [Name "near"; Name "far"] ["epsilon"; "xi"];
    Let TReal "push" (Apply "@law" [Name "gain"; Name "xi"; Name "epsilon"])] ++ held_statements ++ [
    Store "u" (Name "i") (Atom (Name (if limited k then "u_held" else "push")));
    Set_ "outside" (Atom (Name "outside_any"))].

  Definition control_body := lower_statements ++ upper_statements ++ law_statements.

  (* `zero` is 0, or not if an input is not finite *)
  Definition inputs_statements := [
    For "j" (dimensions k) inputs_body;
    Let TBool "finite" (Binary AtMost (Name "zero") (Real zero));
    Let TBool "bad" (Not (Name "finite"));
    When (Name "bad") [
      For "j2" (dimensions k) [Store "u" (Name "j2") (Atom (Real zero))];
      Return (Some (Atom (Int 2)))]].
  Definition inside_statements := [
    Let TBool "outside" (Atom (Truth false));
    For "i" (dimensions k) control_body;
    Return (Some (Select (Name "outside") (Int 1) (Int 0)))].
  (* what `control` and `control_tick` have in common *)
  Definition common_statements (segment clock : string) := inputs_statements ++ place_statements segment clock ++ inside_statements.

  Definition control_function := Function "@control" "@status" [ByValue TReal "t"; ArrayIn "x"; ArrayOut "u"] ([
    Let TReal "t_zero" (Binary Times (Name "t") (Real zero));
    Let TReal "zero" (Atom (Name "t_zero"))] ++
    common_statements "@segment" "t").
  Definition control_tick_function := Function "@control_tick" "@status" [ByValue TUnsigned "tick"; ArrayIn "x"; ArrayOut "u"] ([
    Let TReal "zero" (Atom (Real zero))] ++
    common_statements "@segment_at_tick" "tick").

  Definition emitted_tables (coefficients : list decimal) :=
    [("@coefficients", coefficients)] ++ (if several k then [("@gain", gain_table k)] else []) ++
    (if clamps_differ k then [("@least_share", clamp_table k)] else []) ++ (if limited k then [("@u_max", limit_table k)] else []).

  (* the kernels and functions that the theorem is about; the file has others, which call nothing here and are called by nothing here *)
  Definition helpers := if written_out k then [exponent_function; mantissa_function] else [].
  Definition with_ticks (fs : tick_numbers -> list function) : list function := match tick_constants k with Some c => fs c | None => [] end.
  Definition emitted := helpers ++ [segment_function] ++ with_ticks (fun c => [segment_at_tick_function c]) ++
    [basis_function; blend_function; transformed_error_function; law_function; tube_function; control_function] ++ with_ticks (fun _ => [control_tick_function]).
End Emission.

Definition kept : list string := ["@exponent"; "@mantissa"; "@segment"; "@segment_at_tick"; "@basis"; "@blend"; "@transformed_error"; "@law"; "@tube"; "@control"; "@control_tick"].
(* and what they read; of e_max by component there is a table that only `transform` reads *)
Definition kept_tables : list string := ["@coefficients"; "@gain"; "@least_share"; "@u_max"].
Definition keep (s : source) : source :=
  Source (directives s) (filter (fun t => List.existsb (String.eqb (fst t)) kept_tables) (tables s)) (filter (fun f => List.existsb (String.eqb (title f)) kept) (functions s)).
