(* What the C does: an evaluator of the syntax over any arithmetic. It has no result (None) where C leaves the behaviour undefined: an
   index outside an array, an integer outside 32 bits, a division by an integer that is not positive, a conversion of a real number that
   has no integer, a variable without a value. So a theorem that a run has a result excludes all of these.

   Unsigned integers are compared, chosen and converted. They have no arithmetic, so that none wraps around. Signed and unsigned integers
   together have no meaning here, for C would convert one of them.

   Control.v runs the emitted program with it, Semantics.v has the machine's arithmetic. *)
From Coq Require Import ZArith List String Bool Lia.
From Stt Require Import Syntax.
Import ListNotations.
Open Scope string_scope.

(* An arithmetic of real numbers: a type, its operations, literals and conversions. to_integer is None where C leaves the conversion
   undefined. exponent_of and mantissa_of are e and m of y = m 2^e, by the bits of y; e fits 32 bits (`exponent_range` of Semantics.v). *)
Record arithmetic := Arithmetic {
  float : Type;
  add : float -> float -> float;
  sub : float -> float -> float;
  mul : float -> float -> float;
  div : float -> float -> float;
  negate : float -> float;
  less_than : float -> float -> bool;
  at_most : float -> float -> bool;
  finite : float -> bool;
  nan : float;
  literal : decimal -> float;
  of_integer : Z -> float;
  to_integer : float -> option Z;
  logarithm : float -> float;
  exponent_of : float -> Z;
  mantissa_of : float -> float
}.

(* The evaluator, over an arithmetic A. *)
Section Run.
  Variable A : arithmetic.
  Notation number := (float A).

  (* A value of a C type; Unset is a variable without a value. *)
  Inductive c_value := RealValue (x : number) | IntValue (z : Z) | UnsignedValue (z : Z) | BoolValue (b : bool) | Unset.
  (* Variables with their values, the newest first. *)
  Definition environment := list (string * c_value).
  (* What was stored in arrays: array, index and number, the newest first. *)
  Definition array_stores := list (string * Z * number).
  (* What a function does, as a function of its arguments: the results by pointer, and the returned value if there is one. *)
  Definition kernel_meaning := list c_value -> option (list c_value * option c_value).

  (* The newest entry of a name. *)
  Definition lookup_name {V} (x : string) (l : list (string * V)) : option V :=
    (fix go l := match l with [] => None | (y, v) :: r => if String.eqb x y then Some v else go r end) l.
  (* A variable with a new value; None if it is not declared. *)
  Definition assign_name (x : string) (v : c_value) (l : environment) : option environment :=
    (fix go l := match l with
                 | [] => None
                 | (y, w) :: r => if String.eqb x y then Some ((y, v) :: r) else match go r with Some r => Some ((y, w) :: r) | None => None end
                 end) l.

  (* An int32_t or a uint32_t, None outside its range. *)
  Definition int32 (z : Z) : option c_value := if (-2147483648 <=? z)%Z then if (z <=? 2147483647)%Z then Some (IntValue z) else None else None.
  Definition uint32 (z : Z) : option c_value := if (0 <=? z)%Z then if (z <=? 4294967295)%Z then Some (UnsignedValue z) else None else None.

  (* The functions that may be called, and the arrays that may be read. *)
  Variable kernels : list (string * kernel_meaning).
  Variable arrays : string -> Z -> option number.

  (* The value of an operand. *)
  Definition value_of (env : environment) (a : operand) : option c_value :=
    match a with
    | Var x => match lookup_name x env with Some Unset => None | v => v end
    | RealLiteral v => Some (RealValue (literal A v))
    | IntLiteral z => int32 z
    | UnsignedLiteral z => uint32 z
    | BoolLiteral b => Some (BoolValue b)
    | NotANumber => Some (RealValue (nan A))
    end.
  Fixpoint values_of (env : environment) (l : list operand) : option (list c_value) :=
    match l with
    | [] => Some []
    | a :: r => match value_of env a with Some v => match values_of env r with Some vs => Some (v :: vs) | None => None end | None => None end
    end.

  (* The result of an operator, for values of one type. *)
  Definition apply_operator (o : operator) (a b : c_value) : option c_value :=
    match a, b with
    | RealValue x, RealValue y =>
        match o with
        | Plus => Some (RealValue (add A x y)) | Minus => Some (RealValue (sub A x y)) | Times => Some (RealValue (mul A x y)) | Divide => Some (RealValue (div A x y))
        | Less => Some (BoolValue (less_than A x y)) | AtMost => Some (BoolValue (at_most A x y)) | And => None
        end
    | IntValue x, IntValue y =>
        match o with
        | Plus => int32 (x + y) | Minus => int32 (x - y) | Times => int32 (x * y)
        | Divide => if (0 <? y)%Z then int32 (Z.quot x y) else None (* C rounds towards 0 *)
        | Less => Some (BoolValue (x <? y)%Z) | _ => None
        end
    | UnsignedValue x, UnsignedValue y => match o with Less => Some (BoolValue (x <? y)%Z) | _ => None end
    | BoolValue x, BoolValue y => match o with And => Some (BoolValue (andb x y)) | _ => None end
    | _, _ => None
    end.

  (* c ? a : b, for values of one type. The choice is made inside the constructor, so that the type is known without it. *)
  Definition choose (c : bool) (a b : c_value) : option c_value :=
    match a, b with
    | RealValue x, RealValue y => Some (RealValue (if c then x else y))
    | IntValue x, IntValue y => Some (IntValue (if c then x else y))
    | UnsignedValue x, UnsignedValue y => Some (UnsignedValue (if c then x else y))
    | BoolValue x, BoolValue y => Some (BoolValue (if c then x else y))
    | _, _ => None
    end.

  Definition expression_value (env : environment) (e : expression) : option c_value :=
    match e with
    | Operand a => value_of env a
    | Binary o a b => match value_of env a, value_of env b with Some x, Some y => apply_operator o x y | _, _ => None end
    | Negate a => match value_of env a with Some (RealValue x) => Some (RealValue (negate A x)) | _ => None end
    | Not a => match value_of env a with Some (BoolValue x) => Some (BoolValue (negb x)) | _ => None end
    | Select c a b => match value_of env c, value_of env a, value_of env b with Some (BoolValue c), Some x, Some y => choose c x y | _, _, _ => None end
    | Cast TInt a => match value_of env a with Some (RealValue x) => match to_integer A x with Some z => int32 z | None => None end | Some (UnsignedValue x) => int32 x | _ => None end
    | Cast TReal a => match value_of env a with Some (IntValue x) => Some (RealValue (of_integer A x)) | _ => None end
    | Cast TBool _ | Cast TUnsigned _ => None
    | Load x i => match value_of env i with Some (IntValue i) => match arrays x i with Some v => Some (RealValue v) | None => None end | _ => None end
    | IsFinite a => match value_of env a with Some (RealValue x) => Some (BoolValue (finite A x)) | _ => None end
    | ExponentOf a => match value_of env a with Some (RealValue x) => Some (IntValue (exponent_of A x)) | _ => None end
    | MantissaOf a => match value_of env a with Some (RealValue x) => Some (RealValue (mantissa_of A x)) | _ => None end
    | CallFunction f l => match lookup_name f kernels, values_of env l with
                   | Some k, Some vs => match k vs with Some ([], Some v) => Some v | _ => None end
                   | _, _ => None
                   end
    end.

  Definition has_type (t : c_type) (v : c_value) : bool := match t, v with TReal, RealValue _ => true | TInt, IntValue _ => true | TUnsigned, UnsignedValue _ => true | TBool, BoolValue _ => true | _, _ => false end.

  Fixpoint assign_names (xs : list string) (vs : list c_value) (env : environment) : option environment :=
    match xs, vs with
    | [], [] => Some env
    | x :: xs, v :: vs => match assign_name x v env with Some env => assign_names xs vs env | None => None end
    | _, _ => None
    end.

  (* The environment after a block: without the block's own variables. *)
  Definition leave_block (outer env : environment) : environment := skipn (List.length env - List.length outer) env.

  (* The outcome of a run: environment and stores, and a return with its value if the function has returned. *)
  Definition run_outcome := option (environment * array_stores * option (option c_value)).

  Section Block.
    Variable run_one : statement -> environment -> array_stores -> run_outcome.
    (* A list of statements. *)
    Fixpoint run_block (l : list statement) (env : environment) (out : array_stores) : run_outcome :=
      match l with
      | [] => Some (env, out, None)
      | s :: r => match run_one s env out with Some (env, out, None) => run_block r env out | o => o end
      end.
    Variables (x : string) (body : list statement).
    (* A loop over i, i + 1, .., count times. *)
    Fixpoint run_loop (count : nat) (i : Z) (env : environment) (out : array_stores) : run_outcome :=
      match count with
      | O => Some (env, out, None)
      | S c => match run_block body ((x, IntValue i) :: env) out with
               | Some (inner, out, None) => run_loop c (i + 1) (leave_block env inner) out
               | o => o
               end
      end.
  End Block.

  (* One statement. *)
  Fixpoint run_statement (s : statement) (env : environment) (out : array_stores) : run_outcome :=
    match s with
    | Let t x e => match expression_value env e with Some v => if has_type t v then Some ((x, v) :: env, out, None) else None | None => None end
    | Declare _ x => Some ((x, Unset) :: env, out, None)
    | Assign x e | AssignResult x e => match expression_value env e with
                            | Some v => match assign_name x v env with Some env => Some (env, out, None) | None => None end
                            | None => None end
    | Store x i e => match value_of env i, expression_value env e with
                     | Some (IntValue i), Some (RealValue v) => match arrays x i with Some _ => Some (env, (x, i, v) :: out, None) | None => None end
                     | _, _ => None end
    | CallKernel f a xs => match lookup_name f kernels, values_of env a with
                     | Some k, Some vs => match k vs with
                                          | Some (rs, None) => match assign_names xs rs env with Some env => Some (env, out, None) | None => None end
                                          | _ => None end
                     | _, _ => None end
    | For x n body => run_loop run_statement x body (Z.to_nat n) 0 env out
    | IfTrue c body => match value_of env c with
                     | Some (BoolValue true) => match run_block run_statement body env out with Some (inner, out, o) => Some (leave_block env inner, out, o) | None => None end
                     | Some (BoolValue false) => Some (env, out, None)
                     | _ => None end
    | Return None => Some (env, out, Some None)
    | Return (Some e) => match expression_value env e with Some v => Some (env, out, Some (Some v)) | None => None end
    end.

  (* The environment in which a function begins: arguments by value, results without a value. Arrays are named in the text and need no
     entry. *)
  Fixpoint bind_parameters (ps : list parameter) (vs : list c_value) : option environment :=
    match ps, vs with
    | [], [] => Some []
    | ByValue t x :: ps, v :: vs => if has_type t v then match bind_parameters ps vs with Some env => Some ((x, v) :: env) | None => None end else None
    | ByPointer t x :: ps, vs => match bind_parameters ps vs with Some env => Some ((x, Unset) :: env) | None => None end
    | ArrayIn _ :: ps, vs | ArrayOut _ :: ps, vs => bind_parameters ps vs
    | _, _ => None
    end.
  (* The results by pointer, at the end of a function. *)
  Fixpoint pointer_results (ps : list parameter) (env : environment) : option (list c_value) :=
    match ps with
    | [] => Some []
    | ByPointer t x :: ps => match lookup_name x env, pointer_results ps env with Some v, Some vs => if has_type t v then Some (v :: vs) else None | _, _ => None end
    | _ :: ps => pointer_results ps env
    end.

  (* A function with its arguments. *)
  Definition run_function (f : function) (vs : list c_value) : run_outcome := match bind_parameters (parameters f) vs with Some env => run_block run_statement (body f) env [] | None => None end.

  (* A function as a kernel: it reads arrays, and must store nothing in them. *)
  Definition kernel_of_function (f : function) : kernel_meaning := fun vs =>
    match run_function f vs with
    | Some (env, [], o) => match pointer_results (parameters f) env with Some rs => Some (rs, match o with Some v => v | None => None end) | None => None end
    | _ => None
    end.
End Run.

Arguments RealValue {A}. Arguments IntValue {A}. Arguments UnsignedValue {A}. Arguments BoolValue {A}. Arguments Unset {A}.

(* The meanings of all functions of a file; each may call those above it, and read the file's tables. *)
Fixpoint kernels_in_order (A : arithmetic) (entries : string -> Z -> option (float A)) (fs : list function) (known : list (string * kernel_meaning A)) : list (string * kernel_meaning A) :=
  match fs with
  | [] => known
  | f :: r => kernels_in_order A entries r ((function_name f, kernel_of_function A known entries f) :: known)
  end.
(* The library function for the logarithm. *)
Definition math_library (A : arithmetic) (log_name : string) : list (string * kernel_meaning A) :=
  [(log_name, fun vs => match vs with [RealValue x] => Some ([], Some (RealValue (logarithm A x))) | _ => None end)].

(* An entry of a file's table, as a number. There is none outside the table, or where the file has no table of that name. *)
Definition table_entry (A : arithmetic) (s : source) (x : string) (i : Z) : option (float A) :=
  match lookup_name x (tables s) with
  | Some t => if (i <? 0)%Z then None else match nth_error t (Z.to_nat i) with Some v => Some (literal A v) | None => None end
  | None => None
  end.
(* Runs function f of a file, with arguments and the caller's arrays: what it stores and what it returns. The functions that it calls
   have no arrays but the file's tables, for no array is an argument of a call. *)
Definition execute (A : arithmetic) (log_name : string) (s : source) (f : string) (vs : list (c_value A)) (arrays : string -> Z -> option (float A)) :
  option (array_stores A * option (c_value A)) :=
  let tables_and_arrays x i := match lookup_name x (tables s) with Some _ => table_entry A s x i | None => arrays x i end in
  let ks := kernels_in_order A (table_entry A s) (filter (fun g => negb (String.eqb (function_name g) f)) (functions s)) (math_library A log_name) in
  match List.find (fun g => String.eqb (function_name g) f) (functions s) with
  | Some g => match run_function A ks tables_and_arrays g vs with Some (_, out, o) => Some (out, match o with Some v => v | None => None end) | None => None end
  | None => None
  end.

Lemma int32_in_range A z : (-2147483648 <= z <= 2147483647)%Z -> int32 A z = Some (IntValue z).
Proof. intros [H1 H2]; unfold int32. apply Z.leb_le in H1, H2. now rewrite H1, H2. Qed.

Lemma uint32_in_range A z : (0 <= z <= 4294967295)%Z -> uint32 A z = Some (UnsignedValue z).
Proof. intros [H1 H2]; unfold uint32. apply Z.leb_le in H1, H2. now rewrite H1, H2. Qed.

(* A loop keeps an invariant that its body keeps. *)
Lemma run_loop_invariant A ks arrays x body (P : Z -> environment A -> array_stores A -> Prop) count : forall i env out,
  (forall j env out, (i <= j < i + Z.of_nat count)%Z -> P j env out ->
     exists inner out', run_block A (run_statement A ks arrays) body ((x, IntValue j) :: env) out = Some (inner, out', None) /\ P (j + 1)%Z (leave_block A env inner) out') ->
  P i env out ->
  exists env' out', run_loop A (run_statement A ks arrays) x body count i env out = Some (env', out', None) /\ P (i + Z.of_nat count)%Z env' out'.
Proof.
  induction count; intros i env out B H.
  - exists env, out. split; [reflexivity|]. now rewrite Z.add_0_r.
  - destruct (B i env out ltac:(lia) H) as (inner & out1 & E & H1).
    destruct (IHcount (i + 1)%Z (leave_block A env inner) out1) as (env2 & out2 & E2 & H2); [|exact H1|].
    + intros j e o Hj. apply B; lia.
    + exists env2, out2. split; [|now replace (i + Z.of_nat (S count))%Z with (i + 1 + Z.of_nat count)%Z by lia].
      cbn [run_loop]. now rewrite E.
Qed.
