(* The syntax of the C that the generator prints, as data: one operation a statement, over real numbers, integers and truth values.

   Read.v reads it from the text, Run.v runs it, and Emission.v has the program that the text must be (docs/theorem.md). *)
From Coq Require Import ZArith List String.
Import ListNotations.

(* A literal as it is written: (-1)^is_negative digits 10^decimal_exponent. *)
Record decimal := Decimal { is_negative : bool; digits : Z; decimal_exponent : Z }.

(* The C types: the program's real type, int32_t, bool and uint32_t. *)
Inductive c_type := TReal | TInt | TBool | TUnsigned.

(* An operand of an expression: a variable or a literal. *)
Inductive operand :=
| Var (x : string)
| RealLiteral (v : decimal)
| IntLiteral (z : Z)
| UnsignedLiteral (z : Z)
| BoolLiteral (b : bool)
| NotANumber.

(* + - * / < <= && *)
Inductive operator := Plus | Minus | Times | Divide | Less | AtMost | And.

(* The right side of an assignment. CallFunction is a call whose value is used; ExponentOf and MantissaOf are e and m of y = m 2^e, by
   the bits of y. *)
Inductive expression :=
| Operand (a : operand)
| Binary (o : operator) (a b : operand)
| Negate (a : operand)
| Not (a : operand)
| Select (c a b : operand)
| Cast (t : c_type) (a : operand)
| Load (array : string) (i : operand)
| IsFinite (a : operand)  (* isfinite(a) != 0 *)
| CallFunction (f : string) (arguments : list operand)
| ExponentOf (a : operand)
| MantissaOf (a : operand).

(* A statement. Let declares a variable with a value, Declare one without. Store assigns an element of an array. CallKernel calls a
   function whose results are pointers. For counts from 0. *)
Inductive statement :=
| Let (t : c_type) (x : string) (e : expression)
| Declare (t : c_type) (x : string)
| Assign (x : string) (e : expression)
| AssignResult (x : string) (e : expression)  (* *x = e, a result of a function *)
| Store (array : string) (i : operand) (e : expression)
| CallKernel (f : string) (arguments : list operand) (results : list string)
| For (x : string) (count : Z) (body : list statement)
| IfTrue (c : operand) (body : list statement)
| Return (e : option expression).

(* A parameter: a value, a pointer to a result, an array that is read, an array that is written. *)
Inductive parameter := ByValue (t : c_type) (x : string) | ByPointer (t : c_type) (x : string) | ArrayIn (x : string) | ArrayOut (x : string).

(* A function: name, type of its result, parameters and body. *)
Record function := Function { function_name : string; result_type : string; parameters : list parameter; body : list statement }.

(* A C file: directives, tables of constants, functions. *)
Record source := Source { directives : list string; tables : list (string * list decimal); functions : list function }.
