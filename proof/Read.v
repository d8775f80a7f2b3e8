(* A reader of the C text that runs inside Coq: a theorem is about the program that this reader returns for the shipped file.

   It fails on whatever it does not know, and on texts that C changes before it forms tokens. Functions that no theorem is about are
   read, and left to the stand-alone checker. Each `read_` function takes a list of tokens and returns what it has read with the
   remaining tokens; `expect_` functions return the remaining tokens alone. `fuel` bounds a recursion.

   Design.v and theorem files use `read_source`, Toml.v and Header.v the tokens (docs/theorem.md says what Coq reads). *)
From Coq Require Import ZArith NArith List Bool String Ascii.
From Stt Require Import Syntax.
Import ListNotations.
Open Scope string_scope.

(* ------------------------------------------------------------------ tokens *)

(* Character classes, by ASCII code. *)
Definition code_between (low high c : N) : bool := if (low <=? c)%N then (c <=? high)%N else false.
Definition is_digit (c : ascii) : bool := code_between 48 57 (N_of_ascii c).
Definition is_upper (c : ascii) : bool := code_between 65 90 (N_of_ascii c).
Definition is_lower (c : ascii) : bool := code_between 97 122 (N_of_ascii c).
Definition is_letter (c : ascii) : bool := is_upper c || is_lower c || (N_of_ascii c =? 95)%N.
Definition is_blank (c : ascii) : bool := let n := N_of_ascii c in (n =? 32)%N || (n =? 10)%N.
Definition is_newline (c : ascii) : bool := (N_of_ascii c =? 10)%N.

(* After sign c, blanks and then a sign with which C would join c into one token, or a comment. *)
Fixpoint joins_after_blanks (c : ascii) (s : string) : bool :=
  match s with
  | String d r => if is_blank d then joins_after_blanks c r else if Ascii.eqb d "/" then true else
      if existsb (Ascii.eqb c) ["+"; "-"; "&"; "|"]%char then Ascii.eqb c d else Ascii.eqb d "=" || Ascii.eqb c ">" && Ascii.eqb d ">"
  | EmptyString => false
  end.
(* Where a character stands: in code, in a comment (after a star), or in the line of a directive. *)
Inductive text_part := Code | Comment (star : bool) | Directive.
Definition next_part (part : text_part) (c : ascii) (r : string) : text_part :=
  match part with
  | Code => if Ascii.eqb c "#" then Directive else if Ascii.eqb c "/" then match r with String "*" _ => Comment false | _ => Code end else Code
  | Comment star => if star then if Ascii.eqb c "/" then Code else Comment (Ascii.eqb c "*") else Comment (Ascii.eqb c "*")
  | Directive => if is_newline c then Code else Directive
  end.
(* The text has nothing that C changes before it forms tokens: no spliced line, trigraph, `//` comment, `/*/`, or directive within a
   line. Nor are there, outside of directives, two signs apart that C would join: here every sign is a token. *)
Fixpoint has_plain_tokens (part : text_part) (s : string) : bool :=
  match s with
  | EmptyString => true
  | String c r =>
      if Ascii.eqb c "\" then false else
      match r with
      | String d t =>
          if Ascii.eqb d "#" && negb (is_newline c) then false else
          if Ascii.eqb c "?" && Ascii.eqb d "?" then false else
          if Ascii.eqb c "/" && Ascii.eqb d "/" then false else
          if Ascii.eqb c "/" && Ascii.eqb d "*" && (match t with String e _ => Ascii.eqb e "/" | _ => false end) then false else
          if (match part with Directive => false | _ => true end) && (is_blank d || Ascii.eqb d "/") && existsb (Ascii.eqb c) ["+"; "-"; "&"; "|"; "<"; ">"; "="; "!"]%char && joins_after_blanks c r then false
          else has_plain_tokens (next_part part c r) r
      | EmptyString => true
      end
  end.

(* A word, a number, a sign, or the line of a directive. *)
Inductive token := Word (w : string) | Number (w : string) | Sign (c : ascii) | Line (w : string).

(* The token that is being read, its characters back to front. *)
Inductive reader_state := Between | InWord (w : string) | InNumber (w : string) | InComment (star : bool) | InLine (w : string) | AfterSlash.

(* s back to front, before acc. *)
Fixpoint reverse_onto (s acc : string) : string := match s with EmptyString => acc | String c r => reverse_onto r (String c acc) end.
Definition ends_in_e (w : string) : bool := match w with String c _ => Ascii.eqb c "e" | _ => false end.
(* The tokens with the one that is being read, which ends here; tokens are kept back to front. *)
Definition close_token (st : reader_state) (l : list token) : option (list token) :=
  match st with
  | Between => Some l
  | InWord w => Some (Word (reverse_onto w "") :: l)
  | InNumber w => Some (Number (reverse_onto w "") :: l)
  | InLine w => Some (Line (reverse_onto w "") :: l)
  | InComment _ | AfterSlash => None
  end.

(* What begins with character c. A directive is its whole line. *)
Definition begin_token (c : ascii) : option (reader_state * list token) :=
  if is_blank c then Some (Between, [])
  else if is_letter c then Some (InWord (String c ""), [])
  else if is_digit c then Some (InNumber (String c ""), [])
  else if Ascii.eqb c "/" then Some (AfterSlash, [])
  else if Ascii.eqb c "#" then Some (InLine "#", [])
  else if code_between 33 126 (N_of_ascii c) then Some (Between, [Sign c])
  else None.

(* The tokens of a text; a comment is left out, but not inside a directive. *)
Fixpoint tokenize (s : string) (st : reader_state) (acc : list token) : option (list token) :=
  match s with
  | EmptyString => match close_token st acc with Some l => Some (rev' l) | None => None end
  | String c r =>
      let fresh acc := match begin_token c with Some (st, new) => tokenize r st (app new acc) | None => None end in
      match st with
      | InComment star =>
          if star then (if Ascii.eqb c "/" then tokenize r Between acc else tokenize r (InComment (Ascii.eqb c "*")) acc)
          else tokenize r (InComment (Ascii.eqb c "*")) acc
      | AfterSlash => if Ascii.eqb c "*" then tokenize r (InComment false) acc
                 else match begin_token c with Some (st, new) => tokenize r st (app new (Sign "/" :: acc)) | None => None end
      | InLine w => if is_newline c then tokenize r Between (Line (reverse_onto w "") :: acc) else tokenize r (InLine (String c w)) acc
      | InWord w => if is_letter c || is_digit c then tokenize r (InWord (String c w)) acc else fresh (Word (reverse_onto w "") :: acc)
      | InNumber w => if is_letter c || is_digit c || Ascii.eqb c "." || (ends_in_e w && Ascii.eqb c "-")
                      then tokenize r (InNumber (String c w)) acc else fresh (Number (reverse_onto w "") :: acc)
      | Between => fresh acc
      end
  end.

(* A letter in capitals. *)
Definition to_upper (c : ascii) : ascii := if is_lower c then ascii_of_N (N_of_ascii c - 32) else c.
Fixpoint map_string (f : ascii -> ascii) (s : string) : string := match s with EmptyString => "" | String c r => String (f c) (map_string f r) end.
(* The rest of a string after a prefix. *)
Fixpoint strip_prefix (prefix s : string) : option string :=
  match prefix, s with
  | EmptyString, _ => Some s
  | String p ps, String c r => if Ascii.eqb p c then strip_prefix ps r else None
  | _, EmptyString => None
  end.
Fixpoint all_characters (p : ascii -> bool) (s : string) : bool := match s with EmptyString => true | String c r => if p c then all_characters p r else false end.
Definition begins_without_capital (s : string) : bool := match s with String c _ => negb (is_upper c) | EmptyString => false end.
(* Replaces the task's name at the head of a word by @, so that all tasks have the same names: `<task>_` in small letters, `<TASK>_` in
   capitals where the rest is in capitals too. No word of a C text contains an @. *)
Definition mark_task_name (task : string) : token -> token :=
  let small := task ++ "_" in let big := map_string to_upper small in
  fun t => match t with
  | Word w =>
      match strip_prefix small w with
      | Some r => if begins_without_capital r then Word ("@" ++ r) else t
      | None => match strip_prefix big w with Some r => if all_characters (fun c => negb (is_lower c)) r then Word ("@" ++ r) else t | None => t end
      end
  | _ => t
  end.

(* ------------------------------------------------------------------ parts of a statement *)

Notation "'let*' x ':=' e 'in' f" := (match e with Some x => f | None => None end) (at level 200, x pattern, right associativity).
Notation "e 'or' f" := (match e with Some y => Some y | None => f end) (at level 60, right associativity).

Definition expect_sign (c : ascii) (l : list token) : option (list token) :=
  match l with Sign d :: r => if Ascii.eqb c d then Some r else None | _ => None end.
Definition expect_word (w : string) (l : list token) : option (list token) :=
  match l with Word v :: r => if String.eqb w v then Some r else None | _ => None end.
Fixpoint expect_signs (s : string) (l : list token) : option (list token) :=
  match s with EmptyString => Some l | String c s => let* l := expect_sign c l in expect_signs s l end.

(* Words that are no names of variables or functions. *)
Definition keywords : list string :=
  ["const"; "static"; "inline"; "void"; "bool"; "int32_t"; "uint32_t"; "if"; "else"; "for"; "while"; "do"; "return"; "true"; "false"; "isfinite"; "NAN"; "@real"; "@status";
   "@OK"; "@OUTSIDE_TUBE"; "@BAD_INPUT"; "@N"].
Definition read_name (l : list token) : option (string * list token) :=
  match l with Word w :: r => if existsb (String.eqb w) keywords then None else Some (w, r) | _ => None end.

(* The value of the digits at the head of a string, after those in v; how many there are, and the rest. *)
Fixpoint read_digits (s : string) (v count : Z) : Z * Z * string :=
  match s with
  | String c r => if is_digit c then read_digits r (10 * v + Z.of_N (N_of_ascii c - 48)) (count + 1) else (v, count, s)
  | EmptyString => (v, count, s)
  end.
(* An int32_t literal, in decimal digits: 0 alone may begin with 0, for C reads others as octal. *)
Definition read_integer (w : string) : option Z :=
  match read_digits w 0 0 with
  | (v, n, EmptyString) => match w with String "0" _ => if (n =? 1)%Z then Some 0%Z else None | _ => if (n =? 0)%Z then None else Some v end
  | _ => None
  end.

(* A literal with a U. *)
Definition read_unsigned (w : string) : option Z :=
  match read_digits w 0 0 with
  | (v, n, String "U" EmptyString) => match w with String "0" _ => None | _ => if (n =? 0)%Z then None else Some v end
  | _ => None
  end.

(* The helpers that take a number's exponent and mantissa from its bits, and the check of its size, must have exactly these texts. They
   are the only statements about how a real number lies in memory. *)
Definition same_token (s t : token) : bool :=
  match s, t with Word v, Word w | Number v, Number w => String.eqb v w | Sign c, Sign d => Ascii.eqb c d | _, _ => false end.
Fixpoint expect_tokens (ts l : list token) : option (list token) :=
  match ts, l with
  | [], _ => Some l
  | t :: ts, s :: r => if same_token t s then expect_tokens ts r else None
  | _, [] => None
  end.
Definition tokens_of_helper (s : string) : list token := match tokenize s Between [] with Some l => map (mark_task_name "p") l | None => [] end.
(* Printed from the checker's listing: *)
Definition size_check_text (bytes : string) : string := ("typedef char p_real_size[(sizeof(p_real) == " ++ bytes ++ "U) ? 1 : -1];")%string.
Definition exponent_helper_text (word cut places : string) : string := ("static inline int32_t p_exponent(p_real y) { " ++ word ++ " bits; (void)memcpy(&bits, &y, sizeof bits); return (int32_t)((bits - " ++ cut ++ ") >> " ++ places ++ "); }")%string.
Definition mantissa_helper_text (word cut mask : string) : string := ("static inline p_real p_mantissa(p_real y) { " ++ word ++ " bits; (void)memcpy(&bits, &y, sizeof bits); bits = ((bits - " ++ cut ++ ") & " ++ mask ++ ") + " ++ cut ++ "; p_real m; (void)memcpy(&m, &bits, sizeof m); return m; }")%string.
(* End of what is printed. *)
(* The tokens of these three texts, in single or in double precision. *)
Record memory_layout := MemoryLayout { size_check_tokens : list token; exponent_helper_tokens : list token; mantissa_helper_tokens : list token }.
Definition memory_layout_of (single : bool) : memory_layout :=
  if single
  then MemoryLayout (tokens_of_helper (size_check_text "4")) (tokens_of_helper (exponent_helper_text "uint32_t" "0x3f3504f3U" "23")) (tokens_of_helper (mantissa_helper_text "uint32_t" "0x3f3504f3U" "0x7fffffU"))
  else MemoryLayout (tokens_of_helper (size_check_text "8")) (tokens_of_helper (exponent_helper_text "uint64_t" "0x3fe6a09e667f3bcdU" "52"))
         (tokens_of_helper (mantissa_helper_text "uint64_t" "0x3fe6a09e667f3bcdU" "0xfffffffffffffU")).

(* The parser, for texts whose real literals end with `suffix`: "F" in single precision, "" in double. *)
Section Parse.
  Variable suffix : string.

  (* digits . digits [e [-] digits] suffix, as digits and decimal exponent. *)
  Definition read_real (w : string) : option (Z * Z) :=
    match read_digits w 0 0 with
    | (v, a, String "." r) =>
        let '(v, b, r) := read_digits r v 0 in
        if (a =? 0)%Z then None else if (b =? 0)%Z then None
        else if String.eqb r suffix then Some (v, - b)%Z
        else match r with
             | String "e" (String "-" r) => let '(x, c, r) := read_digits r 0 0 in if (c =? 0)%Z then None else if String.eqb r suffix then Some (v, - b - x)%Z else None
             | String "e" r => let '(x, c, r) := read_digits r 0 0 in if (c =? 0)%Z then None else if String.eqb r suffix then Some (v, - b + x)%Z else None
             | _ => None
             end
    | _ => None
    end.
  Definition read_decimal (l : list token) : option (decimal * list token) :=
    match l with
    | Number w :: r => let* (d, e) := read_real w in Some (Decimal false d e, r)
    | Sign "-" :: Number w :: r => let* (d, e) := read_real w in Some (Decimal true d e, r)
    | _ => None
    end.

  (* Names that stand for literals. *)
  Definition named_constants : list (string * operand) :=
    [("true", BoolLiteral true); ("false", BoolLiteral false); ("@OK", IntLiteral 0); ("@OUTSIDE_TUBE", IntLiteral 1); ("@BAD_INPUT", IntLiteral 2)].
  (* The entry of a name in a list. *)
  Definition lookup {A} (x : string) (l : list (string * A)) : option A :=
    (fix go l := match l with [] => None | (y, a) :: r => if String.eqb x y then Some a else go r end) l.

  Definition read_type (l : list token) : option (c_type * list token) :=
    match l with Word w :: r => let* t := lookup w [("@real", TReal); ("int32_t", TInt); ("bool", TBool); ("uint32_t", TUnsigned)] in Some (t, r) | _ => None end.

  Definition read_operand (l : list token) : option (operand * list token) :=
    match l with
    | Word w :: r => (let* a := lookup w named_constants in Some (a, r)) or (let* (x, r) := read_name l in Some (Var x, r))
    | Number w :: r => (let* (d, e) := read_real w in Some (RealLiteral (Decimal false d e), r)) or (let* z := read_integer w in Some (IntLiteral z, r)) or (let* z := read_unsigned w in Some (UnsignedLiteral z, r))
    | Sign "(" :: Sign "-" :: r => let* (v, r) := read_decimal (Sign "-" :: r) in let* r := expect_sign ")" r in Some (RealLiteral v, r)
    | Sign "(" :: r => let* r := expect_word "@real" r in let* r := expect_sign ")" r in let* r := expect_word "NAN" r in Some (NotANumber, r)
    | _ => None
    end.

  Definition read_operator (l : list token) : option (operator * list token) :=
    match l with
    | Sign c :: r =>
        if Ascii.eqb c "+" then Some (Plus, r) else if Ascii.eqb c "-" then Some (Minus, r)
        else if Ascii.eqb c "*" then Some (Times, r) else if Ascii.eqb c "/" then Some (Divide, r)
        else if Ascii.eqb c "<" then (let* r := expect_sign "=" r in Some (AtMost, r)) or Some (Less, r)
        else if Ascii.eqb c "&" then let* r := expect_sign "&" r in Some (And, r) else None
    | _ => None
    end.

  (* a, b, ..) after the opening bracket: values, then results, which are written &x. *)
  Fixpoint read_arguments (fuel : nat) (l : list token) : option (list operand * list string * list token) :=
    match fuel with
    | O => None
    | S f =>
        let go a out r :=
          (let* r := expect_sign ")" r in Some (a, out, r)) or
          (let* r := expect_sign "," r in let* (more, outs, r) := read_arguments f r in
           match out, more with [], _ => Some (app a more, outs, r) | _, [] => Some ([], app out outs, r) | _, _ => None end) in
        (let* r := expect_sign "&" l in let* (x, r) := read_name r in go [] [x] r) or
        (let* (a, r) := read_operand l in go [a] [] r)
    end.

  (* An expression, and the semicolon that ends it. *)
  Definition read_expression (l : list token) : option (expression * list token) :=
    (let* (a, r) := read_operand l in
       (let* r := expect_sign ";" r in Some (Operand a, r)) or
       (let* (o, r) := read_operator r in let* (b, r) := read_operand r in let* r := expect_sign ";" r in Some (Binary o a b, r)) or
       (let* r := expect_sign "?" r in let* (b, r) := read_operand r in let* r := expect_sign ":" r in let* (c, r) := read_operand r in let* r := expect_sign ";" r in Some (Select a b c, r))) or
    (let* r := expect_sign "-" l in let* (x, r) := read_name r in let* r := expect_sign ";" r in Some (Negate (Var x), r)) or
    (let* r := expect_sign "!" l in let* (x, r) := read_name r in let* r := expect_sign ";" r in Some (Not (Var x), r)) or
    (let* r := expect_sign "(" l in let* (t, r) := read_type r in let* r := expect_sign ")" r in let* (x, r) := read_name r in let* r := expect_sign ";" r in Some (Cast t (Var x), r)) or
    (let* (x, r) := read_name l in
       (let* r := expect_sign "[" r in let* (i, r) := read_name r in let* r := expect_signs "];" r in Some (Load x (Var i), r)) or
       (let* r := expect_sign "(" r in let* (a, o, r) := read_arguments 20 r in match o with [] => let* r := expect_sign ";" r in Some (CallFunction x a, r) | _ => None end)) or
    (let* r := expect_word "isfinite" l in let* r := expect_sign "(" r in let* (x, r) := read_name r in let* r := expect_signs ")!=" r in
       match r with Number "0" :: r => let* r := expect_sign ";" r in Some (IsFinite (Var x), r) | _ => None end).

  (* ------------------------------------------------------------------ statements, functions, the file *)

  Definition read_statement (block : list token -> option (list statement * list token)) (l : list token) : option (statement * list token) :=
    (let* r := expect_word "const" l in let* (t, r) := read_type r in let* (x, r) := read_name r in let* r := expect_sign "=" r in
       let* (e, r) := read_expression r in Some (Let t x e, r)) or
    (let* (t, r) := read_type l in let* (x, r) := read_name r in
       (let* r := expect_sign ";" r in Some (Declare t x, r)) or
       (let* r := expect_sign "=" r in let* (e, r) := read_expression r in Some (Let t x e, r))) or
    (let* r := expect_sign "*" l in let* (x, r) := read_name r in let* r := expect_sign "=" r in let* (e, r) := read_expression r in Some (AssignResult x e, r)) or
    (let* (x, r) := read_name l in
       (let* r := expect_sign "=" r in let* (e, r) := read_expression r in Some (Assign x e, r)) or
       (let* r := expect_sign "[" r in let* (i, r) := read_name r in let* r := expect_signs "]=" r in
          (* a NaN is written with a cast, as in any expression *)
          let* (e, r) := read_expression r in Some (Store x (Var i) e, r)) or
       (let* r := expect_sign "(" r in let* (a, o, r) := read_arguments 20 r in let* r := expect_sign ";" r in Some (CallKernel x a o, r))) or
    (let* r := expect_word "for" l in let* r := expect_sign "(" r in let* r := expect_word "int32_t" r in let* (x, r) := read_name r in let* r := expect_sign "=" r in
       match r with
       | Number "0" :: r =>
           let* r := expect_sign ";" r in let* r := expect_word x r in let* r := expect_sign "<" r in
           match r with
           | Number w :: r =>
               let* n := read_integer w in let* r := expect_signs ";++" r in let* r := expect_word x r in let* r := expect_signs "){" r in
               let* (body, r) := block r in Some (For x n body, r)
           | _ => None
           end
       | _ => None
       end) or
    (let* r := expect_word "if" l in let* r := expect_sign "(" r in let* (x, r) := read_name r in let* r := expect_signs "){" r in
       let* (body, r) := block r in Some (IfTrue (Var x) body, r)) or
    (let* r := expect_word "return" l in
       (let* r := expect_sign ";" r in Some (Return None, r)) or (let* (e, r) := read_expression r in Some (Return (Some e), r))).

  (* Statements up to the closing brace; the fuel is the number of tokens. *)
  Fixpoint read_block (fuel : nat) (l : list token) : option (list statement * list token) :=
    match fuel with
    | O => None
    | S f => (let* r := expect_sign "}" l in Some ([], r)) or
             (let* (s, r) := read_statement (read_block f) l in let* (ss, r) := read_block f r in Some (s :: ss, r))
    end.

  Definition read_parameter (l : list token) : option (parameter * list token) :=
    let array r := let* r := expect_sign "[" r in let* r := expect_word "@N" r in expect_sign "]" r in
    (let* r := expect_word "const" l in let* r := expect_word "@real" r in let* (x, r) := read_name r in let* r := array r in Some (ArrayIn x, r)) or
    (let* (t, r) := read_type l in
       (let* r := expect_sign "*" r in let* (x, r) := read_name r in Some (ByPointer t x, r)) or
       (let* (x, r) := read_name r in
          (let* r := array r in match t with TReal => Some (ArrayOut x, r) | _ => None end) or Some (ByValue t x, r))).
  Fixpoint read_parameters (fuel : nat) (l : list token) : option (list parameter * list token) :=
    match fuel with
    | O => None
    | S f => let* (p, r) := read_parameter l in
             (let* r := expect_sign ")" r in Some ([p], r)) or
             (let* r := expect_sign "," r in let* (ps, r) := read_parameters f r in Some (p :: ps, r))
    end.

  Variable layout : memory_layout.
  Definition read_bit_helper (l : list token) : option (function * list token) :=
    (let* r := expect_tokens (exponent_helper_tokens layout) l in Some (Function "@exponent" "int32_t" [ByValue TReal "y"] [Return (Some (ExponentOf (Var "y")))], r)) or
    (let* r := expect_tokens (mantissa_helper_tokens layout) l in Some (Function "@mantissa" "@real" [ByValue TReal "y"] [Return (Some (MantissaOf (Var "y")))], r)).
  Definition read_function (fuel : nat) (l : list token) : option (function * list token) :=
    (read_bit_helper l) or
    let r := match (let* r := expect_word "static" l in expect_word "inline" r) with Some r => r | None => l end in
    match r with
    | Word t :: r =>
        if existsb (String.eqb t) ["void"; "@real"; "@status"; "bool"] then
          let* (x, r) := read_name r in let* r := expect_sign "(" r in let* (ps, r) := read_parameters 20 r in let* r := expect_sign "{" r in
          let* (body, r) := read_block fuel r in Some (Function x t ps body, r)
        else None
    | _ => None
    end.

  Fixpoint read_decimals (fuel : nat) (l : list token) : option (list decimal * list token) :=
    match fuel with
    | O => None
    | S f => let* (v, r) := read_decimal l in
             (let* r := expect_signs "};" r in Some ([v], r)) or (let* r := expect_sign "," r in let* (vs, r) := read_decimals f r in Some (v :: vs, r))
    end.
  (* static const real x[count] = { .. }; *)
  Definition read_table (fuel : nat) (l : list token) : option (string * list decimal * list token) :=
    let* r := expect_word "static" l in let* r := expect_word "const" r in let* r := expect_word "@real" r in let* (x, r) := read_name r in let* r := expect_sign "[" r in
    match r with
    | Number w :: r =>
        let* n := read_integer w in let* r := expect_signs "]={" r in let* (vs, r) := read_decimals fuel r in
        if (Z.of_nat (List.length vs) =? n)%Z then Some (x, vs, r) else None
    | _ => None
    end.

  (* The name begins with the task's name. *)
  Definition has_task_mark (x : string) : bool := match x with String c _ => Ascii.eqb c "@" | EmptyString => false end.
  (* Accepts a definition only where all directives come before it, and its name begins with the task's: so it is no function of a
     library. *)
  Definition after_directives (x : string) (s : source) (accepted : source) : option source :=
    match directives s with [] => if has_task_mark x then Some accepted else None | _ => None end.
  (* All directives and definitions of a file. *)
  Fixpoint read_file (fuel : nat) (l : list token) : option source :=
    match fuel, l with
    | O, _ => None
    | _, [] => Some (Source [] [] [])
    | S f, Line w :: r => let* s := read_file f r in Some (Source (w :: directives s) (tables s) (functions s))
    | S f, _ =>
        (let* (x, vs, r) := read_table fuel l in let* s := read_file f r in after_directives x s (Source [] ((x, vs) :: tables s) (functions s))) or
        (let* r := expect_tokens (size_check_tokens layout) l in let* s := read_file f r in match directives s with [] => Some s | _ => None end) or
        (let* (g, r) := read_function fuel l in let* s := read_file f r in after_directives (function_name g) s (Source [] (tables s) (g :: functions s)))
    end.

  (* A C text as a program. *)
  Definition parse_text (task text : string) : option source :=
    if negb (has_plain_tokens Code text) then None else
    let* l := tokenize text Between [] in
    let l := map (mark_task_name task) l in
    read_file (S (List.length l)) l.
End Parse.
(* A C text of a task as a program; suffix "F" means single precision. *)
Definition read_source (suffix task text : string) : option source := parse_text suffix (memory_layout_of (String.eqb suffix "F")) task text.
