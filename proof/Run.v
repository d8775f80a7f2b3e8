(* What the C does: an evaluator of the syntax over any arithmetic. It gives no result (None) for what C leaves undefined: an index outside an array, an
   integer outside 32 bits, a division by an integer that is not positive, a conversion of a real number that has no integer, a variable without a value. So a
   theorem that a run has a result excludes these. Unsigned integers are compared, chosen and converted, and have no arithmetic, so that none wraps around;
   signed and unsigned together have no meaning here, for C would convert one of them. *)
From Coq Require Import ZArith List String Bool Lia.
From Stt Require Import Syntax.
Import ListNotations.
Open Scope string_scope.

Record arithmetic := Arithmetic {
  float : Type;
  add : float -> float -> float;
  sub : float -> float -> float;
  mul : float -> float -> float;
  div : float -> float -> float;
  opp : float -> float;
  less : float -> float -> bool;
  at_most : float -> float -> bool;
  finite : float -> bool;
  nan : float;
  literal : decimal -> float;
  of_integer : Z -> float;
  to_integer : float -> option Z; (* None where C leaves the conversion undefined *)
  logarithm : float -> float;
  exponent_of : float -> Z; (* of y = m 2^e, by the bits of y: e, within 32 bits (`exponent_range`), *)
  mantissa_of : float -> float (* and m *)
}.

Section Run.
  Variable A : arithmetic.
  Notation F := (float A).

  Inductive value := R_ (x : F) | I_ (z : Z) | U_ (z : Z) | B_ (b : bool) | Nothing.
  Definition environment := list (string * value).        (* the newest first *)
  Definition stores := list (string * Z * F).             (* what is stored in arrays, the newest first *)
  Definition kernel := list value -> option (list value * option value).

  Definition get {V} (x : string) (l : list (string * V)) : option V :=
    (fix go l := match l with [] => None | (y, v) :: r => if String.eqb x y then Some v else go r end) l.
  Definition put (x : string) (v : value) (l : environment) : option environment :=
    (fix go l := match l with
                 | [] => None
                 | (y, w) :: r => if String.eqb x y then Some ((y, v) :: r) else match go r with Some r => Some ((y, w) :: r) | None => None end
                 end) l.

  Definition int32 (z : Z) : option value := if (-2147483648 <=? z)%Z then if (z <=? 2147483647)%Z then Some (I_ z) else None else None.
  Definition uint32 (z : Z) : option value := if (0 <=? z)%Z then if (z <=? 4294967295)%Z then Some (U_ z) else None else None.

  Variable kernels : list (string * kernel).
  Variable arrays : string -> Z -> option F.

  Definition value_of (env : environment) (a : atom) : option value :=
    match a with
    | Name x => match get x env with Some Nothing => None | v => v end
    | Real v => Some (R_ (literal A v))
    | Int z => int32 z
    | Unsigned z => uint32 z
    | Truth b => Some (B_ b)
    | NotANumber => Some (R_ (nan A))
    end.
  Fixpoint values_of (env : environment) (l : list atom) : option (list value) :=
    match l with
    | [] => Some []
    | a :: r => match value_of env a with Some v => match values_of env r with Some vs => Some (v :: vs) | None => None end | None => None end
    end.

  Definition binary (o : operator) (a b : value) : option value :=
    match a, b with
    | R_ x, R_ y =>
        match o with
        | Plus => Some (R_ (add A x y)) | Minus => Some (R_ (sub A x y)) | Times => Some (R_ (mul A x y)) | Over => Some (R_ (div A x y))
        | Less => Some (B_ (less A x y)) | AtMost => Some (B_ (at_most A x y)) | And => None
        end
    | I_ x, I_ y =>
        match o with
        | Plus => int32 (x + y) | Minus => int32 (x - y) | Times => int32 (x * y)
        | Over => if (0 <? y)%Z then int32 (Z.quot x y) else None (* C cuts towards 0 *)
        | Less => Some (B_ (x <? y)%Z) | _ => None
        end
    | U_ x, U_ y => match o with Less => Some (B_ (x <? y)%Z) | _ => None end
    | B_ x, B_ y => match o with And => Some (B_ (andb x y)) | _ => None end
    | _, _ => None
    end.

  (* the choice is made inside the constructor, so that it may stand for either *)
  Definition select (c : bool) (a b : value) : option value :=
    match a, b with
    | R_ x, R_ y => Some (R_ (if c then x else y))
    | I_ x, I_ y => Some (I_ (if c then x else y))
    | U_ x, U_ y => Some (U_ (if c then x else y))
    | B_ x, B_ y => Some (B_ (if c then x else y))
    | _, _ => None
    end.

  Definition expression_value (env : environment) (e : expression) : option value :=
    match e with
    | Atom a => value_of env a
    | Binary o a b => match value_of env a, value_of env b with Some x, Some y => binary o x y | _, _ => None end
    | Negate a => match value_of env a with Some (R_ x) => Some (R_ (opp A x)) | _ => None end
    | Not a => match value_of env a with Some (B_ x) => Some (B_ (negb x)) | _ => None end
    | Select c a b => match value_of env c, value_of env a, value_of env b with Some (B_ c), Some x, Some y => select c x y | _, _, _ => None end
    | Cast TInt a => match value_of env a with Some (R_ x) => match to_integer A x with Some z => int32 z | None => None end | Some (U_ x) => int32 x | _ => None end
    | Cast TReal a => match value_of env a with Some (I_ x) => Some (R_ (of_integer A x)) | _ => None end
    | Cast TBool _ | Cast TUnsigned _ => None
    | Load x i => match value_of env i with Some (I_ i) => match arrays x i with Some v => Some (R_ v) | None => None end | _ => None end
    | Finite a => match value_of env a with Some (R_ x) => Some (B_ (finite A x)) | _ => None end
    | ExponentOf a => match value_of env a with Some (R_ x) => Some (I_ (exponent_of A x)) | _ => None end
    | MantissaOf a => match value_of env a with Some (R_ x) => Some (R_ (mantissa_of A x)) | _ => None end
    | Apply f l => match get f kernels, values_of env l with
                   | Some k, Some vs => match k vs with Some ([], Some v) => Some v | _ => None end
                   | _, _ => None
                   end
    end.

  Definition of_type (t : type) (v : value) : bool := match t, v with TReal, R_ _ => true | TInt, I_ _ => true | TUnsigned, U_ _ => true | TBool, B_ _ => true | _, _ => false end.

  Fixpoint put_all (xs : list string) (vs : list value) (env : environment) : option environment :=
    match xs, vs with
    | [], [] => Some env
    | x :: xs, v :: vs => match put x v env with Some env => put_all xs vs env | None => None end
    | _, _ => None
    end.

  (* variables of a block end with it *)
  Definition leave (outer env : environment) : environment := skipn (List.length env - List.length outer) env.

  (* a run goes on (None) or returns, with a value or without *)
  Definition outcome := option (environment * stores * option (option value)).

  Section Block.
    Variable run : statement -> environment -> stores -> outcome.
    Fixpoint run_block (l : list statement) (env : environment) (out : stores) : outcome :=
      match l with
      | [] => Some (env, out, None)
      | s :: r => match run s env out with Some (env, out, None) => run_block r env out | o => o end
      end.
    Variables (x : string) (body : list statement).
    Fixpoint run_loop (count : nat) (i : Z) (env : environment) (out : stores) : outcome :=
      match count with
      | O => Some (env, out, None)
      | S c => match run_block body ((x, I_ i) :: env) out with
               | Some (inner, out, None) => run_loop c (i + 1) (leave env inner) out
               | o => o
               end
      end.
  End Block.

  Fixpoint run (s : statement) (env : environment) (out : stores) : outcome :=
    match s with
    | Let t x e => match expression_value env e with Some v => if of_type t v then Some ((x, v) :: env, out, None) else None | None => None end
    | Declare _ x => Some ((x, Nothing) :: env, out, None)
    | Set_ x e | Put x e => match expression_value env e with
                            | Some v => match put x v env with Some env => Some (env, out, None) | None => None end
                            | None => None end
    | Store x i e => match value_of env i, expression_value env e with
                     | Some (I_ i), Some (R_ v) => match arrays x i with Some _ => Some (env, (x, i, v) :: out, None) | None => None end
                     | _, _ => None end
    | Call f a xs => match get f kernels, values_of env a with
                     | Some k, Some vs => match k vs with
                                          | Some (rs, None) => match put_all xs rs env with Some env => Some (env, out, None) | None => None end
                                          | _ => None end
                     | _, _ => None end
    | For x n body => run_loop run x body (Z.to_nat n) 0 env out
    | When c body => match value_of env c with
                     | Some (B_ true) => match run_block run body env out with Some (inner, out, o) => Some (leave env inner, out, o) | None => None end
                     | Some (B_ false) => Some (env, out, None)
                     | _ => None end
    | Return None => Some (env, out, Some None)
    | Return (Some e) => match expression_value env e with Some v => Some (env, out, Some (Some v)) | None => None end
    end.

  (* arguments by value; results without a value yet; arrays are named in the text and need no place here *)
  Fixpoint bind (ps : list parameter) (vs : list value) : option environment :=
    match ps, vs with
    | [], [] => Some []
    | ByValue t x :: ps, v :: vs => if of_type t v then match bind ps vs with Some env => Some ((x, v) :: env) | None => None end else None
    | ByPointer t x :: ps, vs => match bind ps vs with Some env => Some ((x, Nothing) :: env) | None => None end
    | ArrayIn _ :: ps, vs | ArrayOut _ :: ps, vs => bind ps vs
    | _, _ => None
    end.
  Fixpoint results_of (ps : list parameter) (env : environment) : option (list value) :=
    match ps with
    | [] => Some []
    | ByPointer t x :: ps => match get x env, results_of ps env with Some v, Some vs => if of_type t v then Some (v :: vs) else None | _, _ => None end
    | _ :: ps => results_of ps env
    end.

  Definition enter (f : function) (vs : list value) : outcome := match bind (parameters f) vs with Some env => run_block run (code f) env [] | None => None end.

  Definition kernel_of (f : function) : kernel := fun vs =>
    match enter f vs with
    | Some (env, [], o) => match results_of (parameters f) env with Some rs => Some (rs, match o with Some v => v | None => None end) | None => None end
    | _ => None
    end.
End Run.

Arguments R_ {A}. Arguments I_ {A}. Arguments U_ {A}. Arguments B_ {A}. Arguments Nothing {A}.

(* a kernel sees what stands above it in the text *)
Fixpoint all_kernels (A : arithmetic) (fs : list function) (known : list (string * kernel A)) : list (string * kernel A) :=
  match fs with
  | [] => known
  | f :: r => all_kernels A r ((title f, kernel_of A known (fun _ _ => None) f) :: known)
  end.
Definition library (A : arithmetic) (log_name : string) : list (string * kernel A) :=
  [(log_name, fun vs => match vs with [R_ x] => Some ([], Some (R_ (logarithm A x))) | _ => None end)].

(* a function of the header: its tables, arguments and arrays; what it stores and what it returns *)
Definition execute (A : arithmetic) (log_name : string) (s : source) (f : string) (vs : list (value A)) (arrays : string -> Z -> option (float A)) :
  option (stores A * option (value A)) :=
  let tables x i := match get x (tables s) with
                    | Some t => if (i <? 0)%Z then None else match nth_error t (Z.to_nat i) with Some v => Some (literal A v) | None => None end
                    | None => arrays x i
                    end in
  let ks := all_kernels A (filter (fun g => negb (String.eqb (title g) f)) (functions s)) (library A log_name) in
  match List.find (fun g => String.eqb (title g) f) (functions s) with
  | Some g => match enter A ks tables g vs with Some (_, out, o) => Some (out, match o with Some v => v | None => None end) | None => None end
  | None => None
  end.

Lemma int32_ok A z : (-2147483648 <= z <= 2147483647)%Z -> int32 A z = Some (I_ z).
Proof. intros [H1 H2]; unfold int32. apply Z.leb_le in H1, H2. now rewrite H1, H2. Qed.

Lemma uint32_ok A z : (0 <= z <= 4294967295)%Z -> uint32 A z = Some (U_ z).
Proof. intros [H1 H2]; unfold uint32. apply Z.leb_le in H1, H2. now rewrite H1, H2. Qed.

(* a loop keeps what its body keeps *)
Lemma run_loop_keeps A ks arrays x body (P : Z -> environment A -> stores A -> Prop) count : forall i env out,
  (forall j env out, (i <= j < i + Z.of_nat count)%Z -> P j env out ->
     exists inner out', run_block A (run A ks arrays) body ((x, I_ j) :: env) out = Some (inner, out', None) /\ P (j + 1)%Z (leave A env inner) out') ->
  P i env out ->
  exists env' out', run_loop A (run A ks arrays) x body count i env out = Some (env', out', None) /\ P (i + Z.of_nat count)%Z env' out'.
Proof.
  induction count; intros i env out B H.
  - exists env, out. split; [reflexivity|]. now rewrite Z.add_0_r.
  - destruct (B i env out ltac:(lia) H) as (inner & out1 & E & H1).
    destruct (IHcount (i + 1)%Z (leave A env inner) out1) as (env2 & out2 & E2 & H2); [|exact H1|].
    + intros j e o Hj. apply B; lia.
    + exists env2, out2. split; [|now replace (i + Z.of_nat (S count))%Z with (i + 1 + Z.of_nat count)%Z by lia].
      cbn [run_loop]. now rewrite E.
Qed.
