(* The header that the C includes: the type of its numbers, the values of its status, and nothing that could change the text below it. *)
From Coq Require Import ZArith NArith List Bool String Ascii.
From Stt Require Import Rounding Syntax Read.
Import ListNotations.
Open Scope string_scope.
Open Scope list_scope.

Fixpoint holds (p : ascii -> bool) (s : string) : bool := match s with EmptyString => false | String c r => if p c then true else holds p r end.
Fixpoint opens_comment (s : string) : bool := match s with String "/" (String "*" _) => true | String _ r => opens_comment r | EmptyString => false end.
Fixpoint closed_at_end (s : string) : bool := match s with String "*" (String "/" EmptyString) => true | String _ r => closed_at_end r | EmptyString => false end.
(* a directive that ends with its line: no continuation, and a comment on it ends there *)
Definition one_line (s : string) : bool :=
  if holds (fun c => Ascii.eqb c "\") s then false else if opens_comment s then closed_at_end s else true.

Definition eat_line (w : string) (l : list token) : option (list token) :=
  match l with Line v :: r => if String.eqb w v then Some r else None | _ => None end.
Definition eat_prefix (w : string) (l : list token) : option (list token) :=
  match l with Line v :: r => match without w v with Some _ => if one_line v then Some r else None | None => None end | _ => None end.
(* a directive that defines this number and nothing more: C evaluates what sizes a parameter *)
Definition eat_count (w : string) (n : Z) (l : list token) : option (list token) :=
  match l with
  | Line v :: rest => let* s := without w v in
                   match number s 0 0 with
                   | (z, _, EmptyString) => if (z =? n)%Z then Some rest else None
                   | _ => None
                   end
  | _ => None
  end.
Fixpoint eat_words (ws : list string) (l : list token) : option (list token) := (* words, or one character each *)
  match ws with
  | [] => Some l
  | w :: ws => let* r := (eat_word w l) or (match w with String c EmptyString => eat_sign c l | _ => None end) in eat_words ws r
  end.
Definition eat_integer (z : Z) (l : list token) : option (list token) :=
  match l with Number w :: r => let* v := integer w in if (v =? z)%Z then Some r else None | _ => None end.

Fixpoint prototypes (fuel : nat) (l : list token) : option (list token) :=
  match fuel, l with
  | S f, Word t :: r =>
      if existsb (String.eqb t) ["void"; "@real"; "@status"; "bool"] then
        let* (x, r) := name r in let* r := eat_sign "(" r in let* (ps, r) := parameters_ 20 r in let* r := eat_sign ";" r in prototypes f r
      else None
  | _, _ => Some l
  end.

(* lines that define a number of the task or its hash: no name of the C but N, which sizes parameters, and these change nothing *)
Fixpoint definitions (fuel : nat) (big : string) (n : Z) (l : list token) : option (list token) :=
  match fuel with
  | S f => (let* r := (eat_prefix (String.append "#define " (String.append big "T_C ")) l) or (eat_prefix (String.append "#define " (String.append big "DESIGN_HASH ")) l) or
                      (eat_count (String.append "#define " (String.append big "N ")) n l) or
                      (eat_prefix (String.append "#define " (String.append big "PERIOD_PROVED ")) l) or (eat_prefix (String.append "#define " (String.append big "SHARE ")) l) or
                      (eat_prefix (String.append "#define " (String.append big "TICK_PERIOD ")) l) or (eat_prefix (String.append "#define " (String.append big "TICKS ")) l) in definitions f big n r) or (Some l)
  | O => None
  end.

(* a macro that stands for nothing and whose name ends with the design's hash, and a function in a file of its own *)
Definition is_hex (c : ascii) : bool := is_digit c || within 97 102 (N_of_ascii c).
Definition selftest (big : string) (l : list token) : option (list token) :=
  match l with
  | Line v :: r => let* s := without (String.append "#define " (String.append big "SELFTEST_")) v in
                   if each is_hex s then eat_words ["int"; "@selftest"; "("; "void"; ")"; ";"] r else None
  | _ => None
  end.

Definition header_ok (f : format) (task : string) (n : Z) (text : string) : bool :=
  let big := String.append (map_string upper task) "_" in
  if negb (plain text) then false else
  match (
    let* l := tokens text Between [] in
    let l := map (local task) l in
    let* r := eat_line (String.append "#ifndef " (String.append big "H")) l in
    let* r := eat_line (String.append "#define " (String.append big "H")) r in
    let* r := eat_line "#include <stdbool.h>" r in
    let* r := (eat_line "#include <stdint.h>" r) or (Some r) in
    let* r := eat_line "#ifdef __cplusplus" r in
    let* r := eat_words ["extern"; """"; "C"; """"; "{"] r in
    let* r := eat_line "#endif" r in
    let* r := eat_words ["typedef"; match f with Single => "float" | Double => "double" end; "@real"; ";"] r in
    let* r := definitions 10 big n r in
    let* r := eat_words ["typedef"; "enum"; "{"; "@OK"; "="] r in let* r := eat_integer 0 r in
    let* r := eat_words [","; "@OUTSIDE_TUBE"; "="] r in let* r := eat_integer 1 r in
    let* r := eat_words [","; "@BAD_INPUT"; "="] r in let* r := eat_integer 2 r in
    let* r := eat_words ["}"; "@status"; ";"] r in
    let* r := prototypes 20 r in
    let* r := (selftest big r) or (Some r) in
    let* r := eat_line "#ifdef __cplusplus" r in let* r := eat_sign "}" r in let* r := eat_line "#endif" r in let* r := eat_line "#endif" r in
    Some r)
  with Some [] => true | _ => false end.
