(* The design that a C text holds: constants, table and all that helps the checks, found by Coq in the parsed text. Nothing here is believed; the checks decide. *)
From Coq Require Import ZArith QArith Qabs Qminmax List Bool String Strings.Byte SpecFloat.
From Flocq Require Import IEEE754.BinarySingleNaN.
From Stt Require Import Tube Rounding EmittedTube Syntax Read Emission Semantics Edge.
Import ListNotations.
Open Scope string_scope.
Open Scope list_scope.

(* A file as it is. Its text is read into one constructor a character, where a string would have ten: Coq takes a third of the time. *)
Inductive text := Text (l : list byte).
Definition text_of (l : list byte) : text := Text l.
Definition bytes_of (t : text) : list byte := let 'Text l := t in l.
Definition string_of (t : text) : string := string_of_list_byte (bytes_of t).
Declare Scope text_scope.
Delimit Scope text_scope with text.
String Notation text text_of bytes_of : text_scope.

Definition suffix (f : format) : string := match f with Single => "F" | Double => "" end.

(* the directives of the file, each as it stands in its line *)
Definition preamble (f : format) (k : constants) (task : string) : list string := [
  String.append "#include """ (String.append task ".h""");
  "#include <float.h>"; "#include <math.h>"; "#include <stdbool.h>"; "#include <stdint.h>"] ++
  (if written_out k then ["#include <string.h>"] else []) ++ [
  "#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))";
  String.append "#error """ (String.append task ".c: compile without -ffast-math; it tests its inputs for NaN and infinity""");
  "#endif"] ++
  match f with
  | Single => [
      "#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)";
      String.append "#error """ (String.append task ".c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that""")]
  | Double => [
      "#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1)";
      String.append "#error """ (String.append task ".c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that""")]
  end ++ ["#endif"].

Definition none := Decimal false 0 0.
Definition function_named (x : string) (fs : list function) : list statement :=
  match List.find (fun f => String.eqb (title f) x) fs with Some f => code f | None => [] end.
Fixpoint real_right (l : list statement) (x : string) : decimal := (* of const x = .. op literal *)
  match l with
  | Let _ y (Binary _ _ (Real v)) :: r => if String.eqb x y then v else real_right r x
  | For _ _ body :: r => (fix inner b := match b with
      | Let _ y (Binary _ _ (Real v)) :: b => if String.eqb x y then v else inner b
      | _ :: b => inner b
      | [] => real_right r x end) body
  | _ :: r => real_right r x
  | [] => none
  end.
Fixpoint reals_chosen (l : list statement) (x : string) : decimal * decimal :=
  match l with
  | Let _ y (Select _ (Real v) (Real w)) :: r => if String.eqb x y then (v, w) else reals_chosen r x
  | For _ _ body :: r => (fix inner b := match b with
      | Let _ y (Select _ (Real v) (Real w)) :: b => if String.eqb x y then (v, w) else inner b
      | _ :: b => inner b
      | [] => reals_chosen r x end) body
  | _ :: r => reals_chosen r x
  | [] => (none, none)
  end.
Fixpoint loop_count (l : list statement) : Z := match l with For _ n _ :: _ => n | _ :: r => loop_count r | [] => 0%Z end.

(* of const x = .. op literal, and of const x = .. ? .. : literal *)
Fixpoint integer_right (l : list statement) (x : string) : Z :=
  match l with
  | Let _ y (Binary _ _ (Int z)) :: r | Let _ y (Binary _ _ (Unsigned z)) :: r | Let _ y (Select _ _ (Int z)) :: r => if String.eqb x y then z else integer_right r x
  | _ :: r => integer_right r x
  | [] => 0%Z
  end.
Definition tick_constants_of (fs : list function) : option tick_numbers :=
  match function_named "@segment_at_tick" fs with
  | [] => None
  | l => Some (TickNumbers (integer_right l "running") (integer_right l "passed") (integer_right l "whole") (integer_right l "segment" + 1) (real_right l "share"))
  end.

Definition table_named (x : string) (s : option source) : list decimal :=
  match s with Some s => match List.find (fun t => String.eqb (fst t) x) (tables s) with Some (_, t) => t | None => [] end | None => [] end.
Definition constants_of (f : format) (s : option source) : constants :=
  let fs := match s with Some s => functions s | None => [] end in
  let segment := function_named "@segment" fs in
  let control := function_named "@control" fs in
  let gains := reals_chosen control "gain" in
  Constants (loop_count control) (real_right segment "scaled") (real_right segment "early") (fst gains) (snd gains)
    (table_named "@gain" s) (table_named "@u_max" s) (real_right control "least") (table_named "@least_share" s)
    (match f with Single => true | Double => false end) (existsb (fun g => String.eqb (title g) "@mantissa") fs) (tick_constants_of fs).
Definition coefficients_of : option source -> list decimal := table_named "@coefficients".

Section Numbers.
  Variable f : format.
  Definition value_of (d : decimal) : Q := Qred (rational (decimal_float (precision f) (largest_exponent f) d)).
  (* gains, clamps and limits by component *)
  Definition gains_of (k : constants) : list Q :=
    if several k then map value_of (gain_table k) else repeat (value_of (gain_lower k)) (Z.to_nat (dimensions k)).
  Definition clamps_of (k : constants) : list Q :=
    if clamps_differ k then map value_of (clamp_table k) else repeat (value_of (clamp k)) (Z.to_nat (dimensions k)).
  Definition limits_of (k : constants) : list (option Q) := map (fun d => Some (value_of d)) (limit_table k).
  Definition dyadic_of (d : decimal) : Z * Z :=
    match decimal_float (precision f) (largest_exponent f) d with S754_finite s m e => (cond_Zopp s (Zpos m), e) | _ => (0, 0)%Z end.
  Definition scale_of (k : constants) : scale := let '(m, e) := dyadic_of (rate k) in let '(m', e') := dyadic_of (last k) in Scale m e m' e'.

  Fixpoint pairs (l : list Z) : list (Z * Z) := match l with a :: b :: r => (a, b) :: pairs r | _ => [] end.
  Fixpoint chunks (fuel n : nat) (l : list (Z * Z)) : Tube.table :=
    match fuel, l with S m, _ :: _ => firstn n l :: chunks m n (skipn n l) | _, _ => [] end.
  Definition rows_of (unit : Q) (k : constants) (ds : list decimal) : Tube.table :=
    let zs := pairs (map (fun d => Qnum (Qred (value_of d / unit))) ds) in chunks (List.length zs) (Z.to_nat (dimensions k)) zs.

  (* the largest difference of neighbouring Bezier coefficients, by dimension *)
  Definition steps_of (n : nat) (rows : Tube.table) : list Z :=
    let step c := Z.max (Z.abs (c1 c - c0 c)) (Z.max (Z.abs (c2 c - c1 c)) (Z.abs (c3 c - c2 c))) in
    map (fun i => fold_right (fun p m => let c := nth i p (zero_bez, zero_bez) in Z.max m (Z.max (step (fst c)) (step (snd c)))) 0%Z (pieces rows)) (seq 0 n).

  (* what the emitted spline time may be wrong by *)
  Definition late_of (T : Q) (rows : Tube.table) (s : scale) : Q :=
    let K := inject_Z (Z.of_nat (segments rows)) in
    let c := dyadic (rate_m s) (rate_e s) in
    let early := (K / T * (T * half_ulp f + half_least f))%Q in
    Qred (Qmax (K - dyadic (last_m s) (last_e s) + early) (T * Qabs (c - K / T) + (T * c * half_ulp f + half_least f) + early)).
End Numbers.
