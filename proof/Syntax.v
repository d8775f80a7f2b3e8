(* The C that the generator prints, as data: one operation a statement, over real numbers, integers and truth values. *)
From Coq Require Import ZArith List String.
Import ListNotations.

(* (-1)^minus digits 10^exponent, as it is written in the text *)
Record decimal := Decimal { minus : bool; digits : Z; exponent : Z }.

Inductive type := TReal | TInt | TBool | TUnsigned.

Inductive atom :=
| Name (x : string)
| Real (v : decimal)
| Int (z : Z)
| Unsigned (z : Z)
| Truth (b : bool)
| NotANumber.

Inductive operator := Plus | Minus | Times | Over | Less | AtMost | And.

Inductive expression :=
| Atom (a : atom)
| Binary (o : operator) (a b : atom)
| Negate (a : atom)
| Not (a : atom)
| Select (c a b : atom)
| Cast (t : type) (a : atom)
| Load (array : string) (i : atom)
| Finite (a : atom)                               (* isfinite(a) != 0 *)
| Apply (f : string) (arguments : list atom)
| ExponentOf (a : atom)                           (* of y = m 2^e, by its bits: e, *)
| MantissaOf (a : atom).                          (* and m *)

Inductive statement :=
| Let (t : type) (x : string) (e : expression)
| Declare (t : type) (x : string)
| Set_ (x : string) (e : expression)
| Put (x : string) (e : expression)               (* *x = e: a result of a kernel *)
| Store (array : string) (i : atom) (e : expression)
| Call (f : string) (arguments : list atom) (results : list string)
| For (x : string) (count : Z) (body : list statement)
| When (c : atom) (body : list statement)
| Return (e : option expression).

Inductive parameter := ByValue (t : type) (x : string) | ByPointer (t : type) (x : string) | ArrayIn (x : string) | ArrayOut (x : string).

Record function := Function { title : string; result : string; parameters : list parameter; code : list statement }.

Record source := Source { directives : list string; tables : list (string * list decimal); functions : list function }.
