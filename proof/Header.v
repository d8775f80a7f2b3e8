(* The header that the C includes: the type of its numbers, the values of its status, prototypes, and nothing that could change the text
   below the include.

   Theorem files ask `header_ok` of the shipped header (docs/theorem.md says what Coq takes from it). *)
From Coq Require Import ZArith NArith List Bool String Ascii.
From Stt Require Import Rounding Syntax Read.
Import ListNotations.
Open Scope string_scope.
Open Scope list_scope.

Fixpoint contains_character (p : ascii -> bool) (s : string) : bool := match s with EmptyString => false | String c r => if p c then true else contains_character p r end.
(* A comment begins in the string; `ends_with_comment`: it ends with the end of a comment. *)
Fixpoint has_comment (s : string) : bool := match s with String "/" (String "*" _) => true | String _ r => has_comment r | EmptyString => false end.
Fixpoint ends_with_comment (s : string) : bool := match s with String "*" (String "/" EmptyString) => true | String _ r => ends_with_comment r | EmptyString => false end.
(* A directive that ends with its line: it has no continuation, and a comment in it ends there. *)
Definition is_within_line (s : string) : bool :=
  if contains_character (fun c => Ascii.eqb c "\") s then false else if has_comment s then ends_with_comment s else true.

(* This directive; `expect_line_prefix`: a directive that begins so. *)
Definition expect_line (w : string) (l : list token) : option (list token) :=
  match l with Line v :: r => if String.eqb w v then Some r else None | _ => None end.
Definition expect_line_prefix (w : string) (l : list token) : option (list token) :=
  match l with Line v :: r => match strip_prefix w v with Some _ => if is_within_line v then Some r else None | None => None end | _ => None end.
(* A directive that defines this number and nothing more, for C evaluates the size of an array parameter. *)
Definition expect_count (w : string) (n : Z) (l : list token) : option (list token) :=
  match l with
  | Line v :: rest => let* s := strip_prefix w v in
                   match read_digits s 0 0 with
                   | (z, _, EmptyString) => if (z =? n)%Z then Some rest else None
                   | _ => None
                   end
  | _ => None
  end.
(* Words, or one sign each. *)
Fixpoint expect_words (ws : list string) (l : list token) : option (list token) :=
  match ws with
  | [] => Some l
  | w :: ws => let* r := (expect_word w l) or (match w with String c EmptyString => expect_sign c l | _ => None end) in expect_words ws r
  end.
Definition expect_integer (z : Z) (l : list token) : option (list token) :=
  match l with Number w :: r => let* v := read_integer w in if (v =? z)%Z then Some r else None | _ => None end.

(* Skips the prototypes. *)
Fixpoint skip_prototypes (fuel : nat) (l : list token) : option (list token) :=
  match fuel, l with
  | S f, Word t :: r =>
      if existsb (String.eqb t) ["void"; "@real"; "@status"; "bool"] then
        let* (x, r) := read_name r in let* r := expect_sign "(" r in let* (ps, r) := read_parameters 20 r in let* r := expect_sign ";" r in skip_prototypes f r
      else None
  | _, _ => Some l
  end.

(* Skips lines that define a number of the task or its hash. The C uses none of these names but N, which sizes parameters. *)
Fixpoint skip_definitions (fuel : nat) (big : string) (n : Z) (l : list token) : option (list token) :=
  match fuel with
  | S f => (let* r := (expect_line_prefix (String.append "#define " (String.append big "T_C ")) l) or (expect_line_prefix (String.append "#define " (String.append big "DESIGN_HASH ")) l) or
                      (expect_count (String.append "#define " (String.append big "N ")) n l) or
                      (expect_line_prefix (String.append "#define " (String.append big "PERIOD_PROVED ")) l) or (expect_line_prefix (String.append "#define " (String.append big "SHARE ")) l) or
                      (expect_line_prefix (String.append "#define " (String.append big "TICK_PERIOD ")) l) or (expect_line_prefix (String.append "#define " (String.append big "TICKS ")) l) in skip_definitions f big n r) or (Some l)
  | O => None
  end.

(* A hexadecimal digit. *)
Definition is_hex (c : ascii) : bool := is_digit c || code_between 97 102 (N_of_ascii c).
(* A macro whose name ends with the design's hash and that stands for nothing, and the prototype of the self-test, which is in a file of
   its own. *)
Definition expect_selftest (big : string) (l : list token) : option (list token) :=
  match l with
  | Line v :: r => let* s := strip_prefix (String.append "#define " (String.append big "SELFTEST_")) v in
                   if all_characters is_hex s then expect_words ["int"; "@selftest"; "("; "void"; ")"; ";"] r else None
  | _ => None
  end.

(* The whole header. *)
Definition header_ok (f : format) (task : string) (n : Z) (text : string) : bool :=
  let big := String.append (map_string to_upper task) "_" in
  if negb (has_plain_tokens Code text) then false else
  match (
    let* l := tokenize text Between [] in
    let l := map (mark_task_name task) l in
    let* r := expect_line (String.append "#ifndef " (String.append big "H")) l in
    let* r := expect_line (String.append "#define " (String.append big "H")) r in
    let* r := expect_line "#include <stdbool.h>" r in
    let* r := (expect_line "#include <stdint.h>" r) or (Some r) in
    let* r := expect_line "#ifdef __cplusplus" r in
    let* r := expect_words ["extern"; """"; "C"; """"; "{"] r in
    let* r := expect_line "#endif" r in
    let* r := expect_words ["typedef"; match f with Single => "float" | Double => "double" end; "@real"; ";"] r in
    let* r := skip_definitions 10 big n r in
    let* r := expect_words ["typedef"; "enum"; "{"; "@OK"; "="] r in let* r := expect_integer 0 r in
    let* r := expect_words [","; "@OUTSIDE_TUBE"; "="] r in let* r := expect_integer 1 r in
    let* r := expect_words [","; "@BAD_INPUT"; "="] r in let* r := expect_integer 2 r in
    let* r := expect_words ["}"; "@status"; ";"] r in
    let* r := skip_prototypes 20 r in
    let* r := (expect_selftest big r) or (Some r) in
    let* r := expect_line "#ifdef __cplusplus" r in let* r := expect_sign "}" r in let* r := expect_line "#endif" r in let* r := expect_line "#endif" r in
    Some r)
  with Some [] => true | _ => false end.
