(* The C that the generator prints, as data: one operation a statement, over real numbers, integers and truth values. *)
From Coq Require Import ZArith List String.
Import ListNotations.

(* (-1)^minus digits 10^exponent, as it is written in the text *)
Record decimal := Decimal { is_negative : bool; digits : Z; decimal_exponent : Z }.

Inductive c_type := TReal | TInt | TBool | TUnsigned.

Inductive operand :=
| Var (x : string)
| RealLiteral (v : decimal)
| IntLiteral (z : Z)
| UnsignedLiteral (z : Z)
| BoolLiteral (b : bool)
| NotANumber.

Inductive operator := Plus | Minus | Times | Divide | Less | AtMost | And.

Inductive expression :=
| Operand (a : operand)
| Binary (o : operator) (a b : operand)
| Negate (a : operand)
| Not (a : operand)
| Select (c a b : operand)
| Cast (t : c_type) (a : operand)
| Load (array : string) (i : operand)
| IsFinite (a : operand)                               (* isfinite(a) != 0 *)
| CallFunction (f : string) (arguments : list operand)
| ExponentOf (a : operand)                           (* of y = m 2^e, by its bits: e, *)
| MantissaOf (a : operand).                          (* and m *)

Inductive statement :=
| Let (t : c_type) (x : string) (e : expression)
| Declare (t : c_type) (x : string)
| Assign (x : string) (e : expression)
| AssignResult (x : string) (e : expression)               (* *x = e: a result of a kernel *)
| Store (array : string) (i : operand) (e : expression)
| CallKernel (f : string) (arguments : list operand) (results : list string)
| For (x : string) (count : Z) (body : list statement)
| IfTrue (c : operand) (body : list statement)
| Return (e : option expression).

Inductive parameter := ByValue (t : c_type) (x : string) | ByPointer (t : c_type) (x : string) | ArrayIn (x : string) | ArrayOut (x : string).

Record function := Function { function_name : string; result_type : string; parameters : list parameter; body : list statement }.

Record source := Source { directives : list string; tables : list (string * list decimal); functions : list function }.
