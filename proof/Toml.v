(* The task's numbers from the text of its TOML file: sets, times and margins, and what it states of samples and plant. A text with keys
   or spellings that are not listed here is refused.

   Theorem files compare `task_in`, `limits_in`, `conditions_in` and `tick_period_in` with the numbers of the theorem (docs/theorem.md);
   docs/task.md explains the keys, tests/task/test_keys.py compares the list. *)
From Coq Require Import ZArith NArith QArith Qabs Qminmax List Bool String Ascii DecimalString.
From Stt Require Import Tube Read Sound.
Import ListNotations.
Open Scope string_scope.
Open Scope list_scope.

(* A bare word (a key or a number), a text in quotes, a sign, the end of a line. *)
Inductive toml_token := Bare (w : string) | Text (w : string) | Mark (c : ascii) | End.
(* The token that is being read, its characters back to front. *)
Inductive toml_state := Between | InBare (w : string) | InText (w : string) | InComment.

Definition is_bare (c : ascii) : bool := is_letter c || is_digit c || Ascii.eqb c "-" || Ascii.eqb c "+" || Ascii.eqb c ".".
Definition is_space (c : ascii) : bool := let n := N_of_ascii c in (n =? 32)%N || (n =? 9)%N || (n =? 13)%N.

(* The tokens of a text, without comments. *)
Fixpoint toml_tokens (s : string) (st : toml_state) (acc : list toml_token) : option (list toml_token) :=
  match s with
  | EmptyString => match st with
                   | Between | InComment => Some (rev' (End :: acc))
                   | InBare w => Some (rev' (End :: Bare (reverse_onto w "") :: acc))
                   | InText _ => None
                   end
  | String c r =>
      let fresh acc :=
        if is_newline c then toml_tokens r Between (End :: acc)
        else if is_space c then toml_tokens r Between acc
        else if Ascii.eqb c "#" then toml_tokens r InComment acc
        else if Ascii.eqb c """" then toml_tokens r (InText "") acc
        else if is_bare c then toml_tokens r (InBare (String c "")) acc
        else toml_tokens r Between (Mark c :: acc) in
      match st with
      | Between => fresh acc
      | InBare w => if is_bare c then toml_tokens r (InBare (String c w)) acc else fresh (Bare (reverse_onto w "") :: acc)
      | InText w => if Ascii.eqb c """" then toml_tokens r Between (Text (reverse_onto w "") :: acc)
                    else if Ascii.eqb c "\" then None else if is_newline c then None else toml_tokens r (InText (String c w)) acc
      | InComment => if is_newline c then toml_tokens r Between (End :: acc) else toml_tokens r InComment acc
      end
  end.

(* A value: number, text, truth value or array. *)
Inductive toml_value := VNumber (q : Q) | VText (s : string) | VTruth (b : bool) | VList (l : list toml_value).

(* [-] digits [. digits] [e or E [- or +] digits] *)
Definition power_of_10 (e : Z) : Q := if (0 <=? e)%Z then inject_Z (10 ^ e) else (1 # Z.to_pos (10 ^ (- e)))%Q.
(* digits [. digits] [e or E [- or +] digits] *)
Definition unsigned_number (w : string) : option Q :=
  let '(v, a, r) := read_digits w 0 0 in
  if (a =? 0)%Z then None else
  let '(v, b, r) := match r with String "." r => let '(v, b, r) := read_digits r v 0 in (v, if (b =? 0)%Z then (-1)%Z else b, r) | _ => (v, 0%Z, r) end in
  if (b <? 0)%Z then None else
  match r with
  | EmptyString => Some (inject_Z v * power_of_10 (- b))%Q
  | String c r =>
      if (Ascii.eqb c "e" || Ascii.eqb c "E")%bool then
        let '(sign, r) := match r with String "-" r => ((-1)%Z, r) | String "+" r => (1%Z, r) | _ => (1%Z, r) end in
        match read_digits r 0 0 with (x, c, EmptyString) => if (c =? 0)%Z then None else Some (inject_Z v * power_of_10 (sign * x - b))%Q | _ => None end
      else None
  end.
Definition signed_number (w : string) : option Q :=
  match w with
  | String "-" r => match unsigned_number r with Some q => Some (Qred (- q)) | None => None end
  | _ => match unsigned_number w with Some q => Some (Qred q) | None => None end
  end.

(* Arrays may go over several lines. *)
Fixpoint skip_ends (l : list toml_token) : list toml_token := match l with End :: r => skip_ends r | _ => l end.
(* A value, with the remaining tokens. *)
Fixpoint read_value (fuel : nat) (l : list toml_token) : option (toml_value * list toml_token) :=
  match fuel, l with
  | O, _ => None
  | S f, Bare w :: r => if String.eqb w "true" then Some (VTruth true, r) else if String.eqb w "false" then Some (VTruth false, r)
                        else match signed_number w with Some q => Some (VNumber q, r) | None => None end
  | S f, Text w :: r => Some (VText w, r)
  | S f, Mark "[" :: r =>
      (fix items m l acc := match m with
         | O => None
         | S m => match skip_ends l with
                  | Mark "]" :: r => Some (VList (rev acc), r)
                  | l => match read_value f l with
                         | Some (v, r) => match skip_ends r with
                                          | Mark "," :: r => items m r (v :: acc)
                                          | Mark "]" :: r => Some (VList (rev (v :: acc)), r)
                                          | _ => None end
                         | None => None end
                  end
         end) (List.length r) r []
  | _, _ => None
  end.

Definition entries := list (string * toml_value).
(* A table of the file: [name], or [[name]] where it is repeated, with its entries. *)
Record toml_section := TomlSection { is_repeated : bool; section_name : string; section_entries : entries }.

(* The tables of the file, with the entries of each back to front. *)
Fixpoint read_sections (fuel : nat) (l : list toml_token) (current : toml_section) (finished : list toml_section) : option (list toml_section) :=
  match fuel, l with
  | O, _ => None
  | _, [] => Some (rev (current :: finished))
  | S f, End :: r => read_sections f r current finished
  | S f, Mark "[" :: Mark "[" :: Bare h :: Mark "]" :: Mark "]" :: End :: r => read_sections f r (TomlSection true h []) (current :: finished)
  | S f, Mark "[" :: Bare h :: Mark "]" :: End :: r => read_sections f r (TomlSection false h []) (current :: finished)
  | S f, Bare k :: Mark "=" :: r => match read_value (List.length r) r with
                                    | Some (v, End :: r) => read_sections f r (TomlSection (is_repeated current) (section_name current) ((k, v) :: section_entries current)) finished
                                    | _ => None end
  | _, _ => None
  end.

(* f of every element; None if it is None for one of them. *)
Definition map_all {A B} (f : A -> option B) (l : list A) : option (list B) :=
  fold_right (fun a acc => match f a, acc with Some b, Some r => Some (b :: r) | _, _ => None end) (Some []) l.
Definition with_length {A} (d : nat) (l : list A) : option (list A) := if Nat.eqb (List.length l) d then Some l else None.
(* The numbers of an array. *)
Definition rationals_in (v : toml_value) : option (list Q) :=
  match v with VList l => map_all (fun v => match v with VNumber q => Some q | _ => None end) l | _ => None end.
(* The numbers, or the number, of a key; `rational_at_or` has a default. *)
Definition rationals_at (k : string) (e : entries) : option (list Q) := match lookup k e with Some v => rationals_in v | None => None end.
Definition rational_at (k : string) (e : entries) : option Q := match lookup k e with Some (VNumber q) => Some q | _ => None end.
Definition rational_at_or (d : Q) (k : string) (e : entries) : option Q := match lookup k e with None => Some d | Some (VNumber q) => Some q | _ => None end.
(* All keys are in a list, and no key is there twice. *)
Definition has_keys_in (ks : list string) (e : entries) : bool := forallb (fun p => existsb (String.eqb (fst p)) ks) e.
Definition has_distinct_keys (e : entries) : bool :=
  (fix go e := match e with [] => true | (k, _) :: r => if existsb (fun p => String.eqb k (fst p)) r then false else go r end) e.

(* The box of a table, smaller by `shrink` on all sides. *)
Definition box_of (n : nat) (shrink : list Q) (e : entries) : option box :=
  match rationals_at "lower" e, rationals_at "upper" e with
  | Some a, Some b => if Nat.eqb (List.length a) n then if Nat.eqb (List.length b) n then
      Some (Box (map (fun p => Qred (fst p + snd p)) (combine a shrink)) (map (fun p => Qred (fst p - snd p)) (combine b shrink))) else None else None
  | _, _ => None
  end.

(* ------------------------------------------------------------------ unsafe sets *)

(* The texts of an array; points and lists of points of a key. *)
Definition texts_in (v : toml_value) : option (list string) :=
  match v with VList l => map_all (fun v => match v with VText w => Some w | _ => None end) l | _ => None end.
Definition vector_at (d : nat) (k : string) (e : entries) : option (list Q) := let* l := rationals_at k e in with_length d l.
Definition vectors_at (d : nat) (k : string) (e : entries) : option (list (list Q)) :=
  match lookup k e with Some (VList (v :: r)) => map_all (fun v => let* l := rationals_in v in with_length d l) (v :: r) | _ => None end.
Definition are_distinct (ws : list string) : bool := has_distinct_keys (map (fun w => (w, VTruth true)) ws).
Fixpoint index_of {A} (same : A -> A -> bool) (a : A) (l : list A) : option nat :=
  match l with [] => None | b :: r => if same a b then Some O else match index_of same a r with Some i => Some (S i) | None => None end end.

(* The names of the dimensions: those of the task, or x1, x2, .. *)
Definition axis_names (n : nat) (top : entries) : option (list string) :=
  match lookup "axes" top with
  | None => Some (map (fun i => String.append "x" (NilZero.string_of_uint (Nat.to_uint i))) (seq 1 n))
  | Some v => let* ws := texts_in v in if are_distinct ws then with_length n ws else None
  end.
(* The dimensions that a set is in. *)
Definition axes_of_set (names : list string) (e : entries) : option (list nat) :=
  match lookup "axes" e with
  | None => Some (seq 0 (List.length names))
  | Some v => let* ws := texts_in v in if are_distinct ws then match ws with [] => None | _ => map_all (fun w => index_of String.eqb w names) ws end else None
  end.

(* A vector of n numbers: `values` in the dimensions of a set, `default` in all other ones. *)
Definition spread_over_axes (n : nat) (set_axes : list nat) (values default : list Q) : list Q :=
  map (fun i => match index_of Nat.eqb i set_axes with Some k => nth k values 0%Q | None => nth i default 0%Q end) (seq 0 n).

(* The half-spaces that cut the state space, moved inwards by the body, or the target set; empty where the task states none. *)
Definition half_spaces_of (names : list string) (body : list Q) (e : entries) : option (list (list Q * Q)) :=
  let n := List.length names in
  if has_keys_in ["axes"; "lower"; "upper"] e then Some [] else
  let* set_axes := axes_of_set names e in
  let* vs := vectors_at (List.length set_axes) "normals" e in
  let* offsets := vector_at (List.length vs) "offsets" e in
  let face v := spread_over_axes n set_axes v [] in
  let body_reach v := fold_right (fun p s => Qabs (fst p) * snd p + s)%Q 0%Q (combine (face v) body) in
  Some (map (fun f => (face (fst f), Qred (snd f - body_reach (fst f)))) (combine vs offsets)).

(* An unsafe set, grown by the body. It is described in its own dimensions; in all other ones it is as wide as the state space. *)
Definition shape_of (names : list string) (space : box) (body : list Q) (e : entries) : option shape :=
  let n := List.length names in
  let* set_axes := axes_of_set names e in
  let axis_count := List.length set_axes in
  let grown (sign : Q -> Q) (l : list Q) := map (fun p => Qred (fst p + sign (snd p))) (combine l body) in
  let grown_box a b := Box (grown Qopp (spread_over_axes n set_axes a (lower_corner space))) (grown (fun q => q) (spread_over_axes n set_axes b (upper_corner space))) in
  let points ps := Hull (map (fun p => spread_over_axes n set_axes p []) ps) in
  let zero := repeat 0%Q axis_count in
  let has_form ks := has_keys_in (["name"; "axes"] ++ ks) e in
  if has_form ["lower"; "upper"] then
    let* a := vector_at axis_count "lower" e in
    let* b := vector_at axis_count "upper" e in
    if forallb (fun p => negb (Qle_bool (snd p) (fst p))) (combine a b) then Some (shape_of_box (grown_box a b)) else None
  else if has_form ["vertices"] then
    let* ps := vectors_at axis_count "vertices" e in
    Some (Shape (points ps) (grown_box zero zero) [] 0)
  else if has_form ["normals"; "offsets"] then (* the part of the state space that is within the half-spaces *)
    let* vs := vectors_at axis_count "normals" e in
    let* offsets := vector_at (List.length vs) "offsets" e in
    let part l := spread_over_axes n set_axes (map (fun i => nth i l 0%Q) set_axes) [] in
    Some (Shape (Cut (Box (part (lower_corner space)) (part (upper_corner space))) (combine (map (fun v => spread_over_axes n set_axes v []) vs) offsets)) (grown_box zero zero) [] 0)
  else
    let* ps := if has_form ["centre"; "radius"] then let* c := vector_at axis_count "centre" e in Some [c]
               else if has_form ["segment"; "radius"] then vectors_at axis_count "segment" e else None in
    let* r := rational_at "radius" e in
    if (0 <? Qnum r)%Z then Some (Shape (points ps) (grown_box zero zero) set_axes r) else None.

(* The keys that are read, or that change nothing that is read: tube and law are checked by themselves. *)
Definition known_sections : list (string * list string) := [
  ("", ["name"; "axes"; "units"; "prescribed_time"; "initial_state"; "body"]);
  ("state_space", ["lower"; "upper"; "axes"; "normals"; "offsets"]); ("initial_set", ["lower"; "upper"; "share"]); ("target_set", ["lower"; "upper"; "axes"; "normals"; "offsets"]);
  ("unsafe", ["name"; "axes"; "lower"; "upper"; "vertices"; "normals"; "offsets"; "centre"; "radius"; "segment"]);
  ("tube", ["clearance"; "min_width"; "design"; "prefer"; "max_speed"; "max_acceleration"; "segments"; "seed"]);
  ("control", ["gain"; "e_max"; "u_max"; "period"; "latency"; "outside"; "saturate"]);
  ("emit", ["scalar"; "math"; "tick_period"; "selftest"; "rust"]);
  ("plant", ["f_max"; "w_max"; "g_min"; "g_max"; "g_cross"; "noise"])].

(* The tables of a text whose keys are all known, and none is there twice. *)
Definition sections_in (text : string) : option (list toml_section) :=
  let* l := toml_tokens text Between [] in
  let* ss := read_sections (S (List.length l)) l (TomlSection false "" []) [] in
  let known := forallb (fun s => match lookup (section_name s) known_sections with
    | Some ks => if has_keys_in ks (section_entries s) then if has_distinct_keys (section_entries s) then Bool.eqb (is_repeated s) (String.eqb (section_name s) "unsafe") else false else false
    | None => false end) ss in
  let singles := map (fun s => (section_name s, VTruth true)) (filter (fun s => negb (is_repeated s)) ss) in
  if negb known then None else if negb (has_distinct_keys singles) then None else Some ss.
(* The entries of a table; none where it is missing. *)
Definition entries_of (h : string) (ss : list toml_section) : entries := match List.find (fun s => String.eqb (section_name s) h) ss with Some s => section_entries s | None => [] end.

(* A number for each of n components, or one number for all of them. *)
Definition per_component (n : nat) (v : toml_value) : option (list Q) :=
  match v with VNumber q => Some (repeat q n) | _ => let* l := rationals_in v in with_length n l end.
Definition per_component_or (n : nat) (d : Q) (k : string) (e : entries) : option (list Q) := match lookup k e with None => Some (repeat d n) | Some v => per_component n v end.

(* The name of the task, and the task. *)
Definition task_in (text : string) : option (string * task) :=
  let* ss := sections_in text in
  let part name := entries_of name ss in
  let top := part "" in
  let* t_c := rational_at "prescribed_time" top in
  let* x := rationals_at "initial_state" top in
  let n := List.length x in
  let* body := per_component_or n 0%Q "body" top in
  let no_margin := repeat 0%Q n in
  let* state_space := box_of n body (part "state_space") in
  let* initial_set := box_of n no_margin (part "initial_set") in
  let* target_set := box_of n no_margin (part "target_set") in
  let* names := axis_names n top in
  let* full_space := box_of n no_margin (part "state_space") in
  let* unsafe_sets := map_all (fun s => shape_of names full_space body (section_entries s)) (filter is_repeated ss) in
  let* clearance := rational_at_or (3 # 100) "clearance" (part "tube") in
  let* width := rational_at_or (1 # 20) "min_width" (part "tube") in
  let* name := match lookup "name" top with Some (VText w) => Some w | _ => None end in
  let* state_half_spaces := half_spaces_of names body (part "state_space") in
  let* target_half_spaces := half_spaces_of names no_margin (part "target_set") in
  Some (name, Task n t_c x state_space initial_set target_set unsafe_sets clearance (Qmax width (1 # 1048576)) state_half_spaces target_half_spaces).

(* The task's u_max, if it has one. `limits_within`: the limits of a C text are there just where the task has u_max, and are no larger. *)
Definition limits_in (text : string) : option (option (list Q)) :=
  let* ss := sections_in text in
  let* x := rationals_at "initial_state" (entries_of "" ss) in
  match lookup "u_max" (entries_of "control" ss) with
  | None => Some None
  | Some v => let* l := per_component (List.length x) v in Some (Some l)
  end.
Definition limits_within (limits : list (option Q)) (u_max : option (list Q)) : bool :=
  match u_max with
  | None => forallb (fun l => match l with None => true | Some _ => false end) limits
  | Some us => Nat.eqb (List.length limits) (List.length us) && forallb (fun p => match fst p with Some m => Qle_bool m (snd p) | None => false end) (combine limits us)
  end.

(* The conditions that a task with a period states. A missing bound of g is 1, or equals the other bound where 1 contradicts that. *)
Definition conditions_in (text : string) : option conditions :=
  let* ss := sections_in text in
  let control := entries_of "control" ss in let plant := entries_of "plant" ss in
  let* x := rationals_at "initial_state" (entries_of "" ss) in
  let n := List.length x in
  let* sampling_period := rational_at "period" control in
  let* input_delay := rational_at_or 0 "latency" control in
  let* start_share := rational_at_or (9 # 10) "share" (entries_of "initial_set" ss) in
  let* sensor_noise := rational_at_or 0 "noise" plant in
  let* f_max := per_component_or n 0%Q "f_max" plant in
  let* w_max := per_component_or n 0%Q "w_max" plant in
  let* g_cross := per_component_or n 0%Q "g_cross" plant in
  let* g_max := per_component_or n 1%Q "g_max" plant in
  let* g_min := match lookup "g_min" plant with Some v => per_component n v | None => Some (map (Qmin 1) g_max) end in
  let g_max := match lookup "g_max" plant with Some _ => g_max | None => map (Qmax 1) g_min end in
  Some (Conditions sampling_period input_delay start_share sensor_noise (map (fun p => Qred (fst p + snd p)) (combine f_max w_max)) g_min g_max g_cross).

(* The seconds of a tick. *)
Definition tick_period_in (text : string) : option Q := let* ss := sections_in text in rational_at "tick_period" (entries_of "emit" ss).
