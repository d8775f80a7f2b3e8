(* The design that a C text contains: Coq finds constants, table and all hints for the checks in the parsed text. Nothing here is
   believed, the checks decide; so nothing is proved here.

   Theorem files evaluate these functions on the shipped text (docs/theorem.md). *)
From Coq Require Import ZArith QArith Qabs Qminmax List Bool String Strings.Byte SpecFloat.
From Flocq Require Import IEEE754.BinarySingleNaN.
From Stt Require Import Tube Rounding EmittedTube Syntax Read Emission Semantics Edge.
Import ListNotations.
Open Scope string_scope.
Open Scope list_scope.

(* The text of a file, as a list of bytes. Coq reads that three times as fast as a string, which has ten constructors a character. *)
Inductive file_text := FileText (l : list byte).
Definition text_of (l : list byte) : file_text := FileText l.
Definition bytes_of (t : file_text) : list byte := let 'FileText l := t in l.
Definition string_of (t : file_text) : string := string_of_list_byte (bytes_of t).
Declare Scope text_scope.
Delimit Scope text_scope with text.
String Notation file_text text_of bytes_of : text_scope.

(* The suffix of real literals. *)
Definition literal_suffix (f : format) : string := match f with Single => "F" | Double => "" end.

(* What the functions below return where the text has no such literal. *)
Definition missing_literal := Decimal false 0 0.
(* The body of the function with this name. *)
Definition body_of (x : string) (fs : list function) : list statement :=
  match List.find (fun f => String.eqb (function_name f) x) fs with Some f => body f | None => [] end.
(* The literal in `const x = .. operator literal`, also in a loop. *)
Fixpoint literal_operand_of (l : list statement) (x : string) : decimal :=
  match l with
  | Let _ y (Binary _ _ (RealLiteral v)) :: r => if String.eqb x y then v else literal_operand_of r x
  | For _ _ body :: r => (fix inner b := match b with
      | Let _ y (Binary _ _ (RealLiteral v)) :: b => if String.eqb x y then v else inner b
      | _ :: b => inner b
      | [] => literal_operand_of r x end) body
  | _ :: r => literal_operand_of r x
  | [] => missing_literal
  end.
(* The literals in `const x = c ? literal : literal`, also in a loop. *)
Fixpoint literals_selected_for (l : list statement) (x : string) : decimal * decimal :=
  match l with
  | Let _ y (Select _ (RealLiteral v) (RealLiteral w)) :: r => if String.eqb x y then (v, w) else literals_selected_for r x
  | For _ _ body :: r => (fix inner b := match b with
      | Let _ y (Select _ (RealLiteral v) (RealLiteral w)) :: b => if String.eqb x y then (v, w) else inner b
      | _ :: b => inner b
      | [] => literals_selected_for r x end) body
  | _ :: r => literals_selected_for r x
  | [] => (missing_literal, missing_literal)
  end.
(* How often the first loop runs. *)
Fixpoint loop_count (l : list statement) : Z := match l with For _ n _ :: _ => n | _ :: r => loop_count r | [] => 0%Z end.

(* The integer in `const x = .. operator integer` or `const x = c ? .. : integer`. *)
Fixpoint integer_operand_of (l : list statement) (x : string) : Z :=
  match l with
  | Let _ y (Binary _ _ (IntLiteral z)) :: r | Let _ y (Binary _ _ (UnsignedLiteral z)) :: r | Let _ y (Select _ _ (IntLiteral z)) :: r => if String.eqb x y then z else integer_operand_of r x
  | _ :: r => integer_operand_of r x
  | [] => 0%Z
  end.
(* The integers of a text with ticks. *)
Definition tick_numbers_of (fs : list function) : option tick_numbers :=
  match body_of "@segment_at_tick" fs with
  | [] => None
  | l => Some (TickNumbers (integer_operand_of l "running") (integer_operand_of l "passed") (integer_operand_of l "whole") (integer_operand_of l "segment" + 1) (literal_operand_of l "share"))
  end.

(* The table with this name. *)
Definition table_of (x : string) (s : option source) : list decimal :=
  match s with Some s => match List.find (fun t => String.eqb (fst t) x) (tables s) with Some (_, t) => t | None => [] end | None => [] end.
(* The constants of a text. *)
Definition constants_of (f : format) (s : option source) : constants :=
  let fs := match s with Some s => functions s | None => [] end in
  let segment := body_of "@segment" fs in
  let control := body_of "@control" fs in
  let gains := literals_selected_for control "gain" in
  Constants (loop_count control) (literal_operand_of segment "scaled") (literal_operand_of segment "early") (fst gains) (snd gains)
    (table_of "@gain" s) (table_of "@u_max" s) (literal_operand_of control "smallest") (table_of "@least_share" s)
    (match f with Single => true | Double => false end) (existsb (fun g => String.eqb (function_name g) "@mantissa") fs) (tick_numbers_of fs).
Definition coefficients_of : option source -> list decimal := table_of "@coefficients".

(* The numbers of the design, for single or double precision. *)
Section Numbers.
  Variable f : format.
  (* The number that a literal is rounded to. *)
  Definition literal_rational (d : decimal) : Q := Qred (spec_float_value (decimal_float (precision f) (largest_exponent f) d)).
  (* Gains, clamp shares and limits by component. *)
  Definition gains_of (consts : constants) : list Q :=
    if gains_differ consts then map literal_rational (gain_table consts) else repeat (literal_rational (gain_lower consts)) (Z.to_nat (dimensions consts)).
  Definition clamp_shares_of (consts : constants) : list Q :=
    if clamp_shares_differ consts then map literal_rational (clamp_share_table consts) else repeat (literal_rational (clamp_share consts)) (Z.to_nat (dimensions consts)).
  Definition limits_of (consts : constants) : list (option Q) := map (fun d => Some (literal_rational d)) (limit_table consts).
  (* A literal's number as mantissa 2^exponent. *)
  Definition mantissa_and_exponent_of (d : decimal) : Z * Z :=
    match decimal_float (precision f) (largest_exponent f) d with S754_finite s m e => (cond_Zopp s (Zpos m), e) | _ => (0, 0)%Z end.
  Definition scale_of (consts : constants) : time_scale := let '(m, e) := mantissa_and_exponent_of (time_rate consts) in let '(m', e') := mantissa_and_exponent_of (last_spline_time consts) in TimeScale m e m' e'.

  (* The table as rows of pairs (lower, upper), in units. *)
  Fixpoint pair_up (l : list Z) : list (Z * Z) := match l with a :: b :: r => (a, b) :: pair_up r | _ => [] end.
  Fixpoint rows_of_length (fuel n : nat) (l : list (Z * Z)) : Tube.table :=
    match fuel, l with S m, _ :: _ => firstn n l :: rows_of_length m n (skipn n l) | _, _ => [] end.
  Definition rows_of (unit : Q) (consts : constants) (ds : list decimal) : Tube.table :=
    let zs := pair_up (map (fun d => Qnum (Qred (literal_rational d / unit))) ds) in rows_of_length (List.length zs) (Z.to_nat (dimensions consts)) zs.

  (* The largest difference of neighbouring Bezier coefficients, by dimension. *)
  Definition step_maxima_of (n : nat) (rows : Tube.table) : list Z :=
    let step c := Z.max (Z.abs (c1 c - c0 c)) (Z.max (Z.abs (c2 c - c1 c)) (Z.abs (c3 c - c2 c))) in
    map (fun i => fold_right (fun p m => let c := nth i p (zero_bezier, zero_bezier) in Z.max m (Z.max (step (fst c)) (step (snd c)))) 0%Z (pieces rows)) (seq 0 n).

  (* A bound on the error of the emitted spline time, in segments. *)
  Definition time_error_of (t_c : Q) (rows : Tube.table) (scale : time_scale) : Q :=
    let K := inject_Z (Z.of_nat (segment_count rows)) in
    let c := dyadic (rate_mantissa scale) (rate_exponent scale) in
    let early := (K / t_c * (t_c * half_ulp f + half_smallest f))%Q in
    Qred (Qmax (K - dyadic (last_mantissa scale) (last_exponent scale) + early) (t_c * Qabs (c - K / t_c) + (t_c * c * half_ulp f + half_smallest f) + early)).
End Numbers.
