(* The task's numbers from the text of its TOML file: sets, times and margins; and what it states of samples and plant. It fails on keys that it does not know. *)
From Coq Require Import ZArith NArith QArith Qabs Qminmax List Bool String Ascii DecimalString.
From Stt Require Import Tube Read Sound.
Import ListNotations.
Open Scope string_scope.
Open Scope list_scope.

Inductive token := Bare (w : string) | Text (w : string) | Mark (c : ascii) | End.
Inductive state := Between | InBare (w : string) | InText (w : string) | InComment.

Definition bare (c : ascii) : bool := is_letter c || is_digit c || Ascii.eqb c "-" || Ascii.eqb c "+" || Ascii.eqb c ".".
Definition space_ (c : ascii) : bool := let n := N_of_ascii c in (n =? 32)%N || (n =? 9)%N || (n =? 13)%N.

Fixpoint tokens (s : string) (st : state) (acc : list token) : option (list token) :=
  match s with
  | EmptyString => match st with
                   | Between | InComment => Some (rev' (End :: acc))
                   | InBare w => Some (rev' (End :: Bare (reverse w "") :: acc))
                   | InText _ => None
                   end
  | String c r =>
      let fresh acc :=
        if is_newline c then tokens r Between (End :: acc)
        else if space_ c then tokens r Between acc
        else if Ascii.eqb c "#" then tokens r InComment acc
        else if Ascii.eqb c """" then tokens r (InText "") acc
        else if bare c then tokens r (InBare (String c "")) acc
        else tokens r Between (Mark c :: acc) in
      match st with
      | Between => fresh acc
      | InBare w => if bare c then tokens r (InBare (String c w)) acc else fresh (Bare (reverse w "") :: acc)
      | InText w => if Ascii.eqb c """" then tokens r Between (Text (reverse w "") :: acc)
                    else if Ascii.eqb c "\" then None else if is_newline c then None else tokens r (InText (String c w)) acc
      | InComment => if is_newline c then tokens r Between (End :: acc) else tokens r InComment acc
      end
  end.

Inductive value := VNumber (q : Q) | VText (s : string) | VTruth (b : bool) | VList (l : list value).

(* [-] digits [. digits] [e or E [- or +] digits] *)
Definition power (e : Z) : Q := if (0 <=? e)%Z then inject_Z (10 ^ e) else (1 # Z.to_pos (10 ^ (- e)))%Q.
Definition magnitude (w : string) : option Q :=
  let '(v, a, r) := number w 0 0 in
  if (a =? 0)%Z then None else
  let '(v, b, r) := match r with String "." r => let '(v, b, r) := number r v 0 in (v, if (b =? 0)%Z then (-1)%Z else b, r) | _ => (v, 0%Z, r) end in
  if (b <? 0)%Z then None else
  match r with
  | EmptyString => Some (inject_Z v * power (- b))%Q
  | String c r =>
      if (Ascii.eqb c "e" || Ascii.eqb c "E")%bool then
        let '(sign, r) := match r with String "-" r => ((-1)%Z, r) | String "+" r => (1%Z, r) | _ => (1%Z, r) end in
        match number r 0 0 with (x, c, EmptyString) => if (c =? 0)%Z then None else Some (inject_Z v * power (sign * x - b))%Q | _ => None end
      else None
  end.
Definition number_ (w : string) : option Q :=
  match w with
  | String "-" r => match magnitude r with Some q => Some (Qred (- q)) | None => None end
  | _ => match magnitude w with Some q => Some (Qred q) | None => None end
  end.

Fixpoint skip (l : list token) : list token := match l with End :: r => skip r | _ => l end.
Fixpoint value_ (fuel : nat) (l : list token) : option (value * list token) :=
  match fuel, l with
  | O, _ => None
  | S f, Bare w :: r => if String.eqb w "true" then Some (VTruth true, r) else if String.eqb w "false" then Some (VTruth false, r)
                        else match number_ w with Some q => Some (VNumber q, r) | None => None end
  | S f, Text w :: r => Some (VText w, r)
  | S f, Mark "[" :: r =>
      (fix items m l acc := match m with
         | O => None
         | S m => match skip l with
                  | Mark "]" :: r => Some (VList (rev acc), r)
                  | l => match value_ f l with
                         | Some (v, r) => match skip r with
                                          | Mark "," :: r => items m r (v :: acc)
                                          | Mark "]" :: r => Some (VList (rev (v :: acc)), r)
                                          | _ => None end
                         | None => None end
                  end
         end) (List.length r) r []
  | _, _ => None
  end.

Definition entries := list (string * value).
Record section := Section_ { many : bool; head : string; body : entries }.

(* sections back to front, and their entries too *)
Fixpoint document (fuel : nat) (l : list token) (now : section) (done : list section) : option (list section) :=
  match fuel, l with
  | O, _ => None
  | _, [] => Some (rev (now :: done))
  | S f, End :: r => document f r now done
  | S f, Mark "[" :: Mark "[" :: Bare h :: Mark "]" :: Mark "]" :: End :: r => document f r (Section_ true h []) (now :: done)
  | S f, Mark "[" :: Bare h :: Mark "]" :: End :: r => document f r (Section_ false h []) (now :: done)
  | S f, Bare k :: Mark "=" :: r => match value_ (List.length r) r with
                                    | Some (v, End :: r) => document f r (Section_ (many now) (head now) ((k, v) :: body now)) done
                                    | _ => None end
  | _, _ => None
  end.

Definition every {A B} (f : A -> option B) (l : list A) : option (list B) :=
  fold_right (fun a acc => match f a, acc with Some b, Some r => Some (b :: r) | _, _ => None end) (Some []) l.
Definition of_length {A} (d : nat) (l : list A) : option (list A) := if Nat.eqb (List.length l) d then Some l else None.
Definition numbers (v : value) : option (list Q) :=
  match v with VList l => every (fun v => match v with VNumber q => Some q | _ => None end) l | _ => None end.
Definition the_numbers (k : string) (e : entries) : option (list Q) := match find k e with Some v => numbers v | None => None end.
Definition the_number (k : string) (e : entries) : option Q := match find k e with Some (VNumber q) => Some q | _ => None end.
Definition number_or (d : Q) (k : string) (e : entries) : option Q := match find k e with None => Some d | Some (VNumber q) => Some q | _ => None end.
Definition only (ks : list string) (e : entries) : bool := forallb (fun p => existsb (String.eqb (fst p)) ks) e.
Definition once (e : entries) : bool :=
  (fix go e := match e with [] => true | (k, _) :: r => if existsb (fun p => String.eqb k (fst p)) r then false else go r end) e.

Definition box_of (n : nat) (shrink : list Q) (e : entries) : option box :=
  match the_numbers "lower" e, the_numbers "upper" e with
  | Some a, Some b => if Nat.eqb (List.length a) n then if Nat.eqb (List.length b) n then
      Some (Box (map (fun p => Qred (fst p + snd p)) (combine a shrink)) (map (fun p => Qred (fst p - snd p)) (combine b shrink))) else None else None
  | _, _ => None
  end.

(* ------------------------------------------------------------------ unsafe sets *)

Definition texts (v : value) : option (list string) :=
  match v with VList l => every (fun v => match v with VText w => Some w | _ => None end) l | _ => None end.
Definition the_vector (d : nat) (k : string) (e : entries) : option (list Q) := let* l := the_numbers k e in of_length d l.
Definition the_vectors (d : nat) (k : string) (e : entries) : option (list (list Q)) :=
  match find k e with Some (VList (v :: r)) => every (fun v => let* l := numbers v in of_length d l) (v :: r) | _ => None end.
Definition differ (ws : list string) : bool := once (map (fun w => (w, VTruth true)) ws).
Fixpoint place {A} (same : A -> A -> bool) (a : A) (l : list A) : option nat :=
  match l with [] => None | b :: r => if same a b then Some O else match place same a r with Some i => Some (S i) | None => None end end.

(* names of the dimensions: those of the task, or x1, x2, .. *)
Definition names_of (n : nat) (top : entries) : option (list string) :=
  match find "axes" top with
  | None => Some (map (fun i => String.append "x" (NilZero.string_of_uint (Nat.to_uint i))) (seq 1 n))
  | Some v => let* ws := texts v in if differ ws then of_length n ws else None
  end.
(* the dimensions that a set is in *)
Definition own_of (names : list string) (e : entries) : option (list nat) :=
  match find "axes" e with
  | None => Some (seq 0 (List.length names))
  | Some v => let* ws := texts v in if differ ws then match ws with [] => None | _ => every (fun w => place String.eqb w names) ws end else None
  end.

(* Numbers that are given for these dimensions, and for the others those of the rest. *)
Definition laid (n : nat) (own : list nat) (given rest : list Q) : list Q :=
  map (fun i => match place Nat.eqb i own with Some k => nth k given 0%Q | None => nth i rest 0%Q end) (seq 0 n).

(* The half-spaces that cut the box of the state space, less the body, or of the target; none where none are said. *)
Definition faces_of (names : list string) (h : list Q) (e : entries) : option (list (list Q * Q)) :=
  let n := List.length names in
  if only ["axes"; "lower"; "upper"] e then Some [] else
  let* own := own_of names e in
  let* vs := the_vectors (List.length own) "normals" e in
  let* os := the_vector (List.length vs) "offsets" e in
  let face v := laid n own v [] in
  let less v := fold_right (fun p s => Qabs (fst p) * snd p + s)%Q 0%Q (combine (face v) h) in
  Some (map (fun f => (face (fst f), Qred (snd f - less (fst f)))) (combine vs os)).

(* A set is said in the dimensions that it is in; of the others it has the whole state space. The body h is added to all. *)
Definition shape_of (names : list string) (space : box) (h : list Q) (e : entries) : option shape :=
  let n := List.length names in
  let* own := own_of names e in
  let d := List.length own in
  let grown (sign : Q -> Q) (l : list Q) := map (fun p => Qred (fst p + sign (snd p))) (combine l h) in
  let about a b := Box (grown Qopp (laid n own a (lo space))) (grown (fun q => q) (laid n own b (hi space))) in
  let points ps := Hull (map (fun p => laid n own p []) ps) in
  let zero := repeat 0%Q d in
  let said ks := only (["name"; "axes"] ++ ks) e in
  if said ["lower"; "upper"] then
    let* a := the_vector d "lower" e in
    let* b := the_vector d "upper" e in
    if forallb (fun p => negb (Qle_bool (snd p) (fst p))) (combine a b) then Some (solid (about a b)) else None
  else if said ["vertices"] then
    let* ps := the_vectors d "vertices" e in
    Some (Shape (points ps) (about zero zero) [] 0)
  else if said ["normals"; "offsets"] then (* the part of the state space that is within them *)
    let* vs := the_vectors d "normals" e in
    let* os := the_vector (List.length vs) "offsets" e in
    let part l := laid n own (map (fun i => nth i l 0%Q) own) [] in
    Some (Shape (Cut (Box (part (lo space)) (part (hi space))) (combine (map (fun v => laid n own v []) vs) os)) (about zero zero) [] 0)
  else
    let* ps := if said ["centre"; "radius"] then let* c := the_vector d "centre" e in Some [c]
               else if said ["segment"; "radius"] then the_vectors d "segment" e else None in
    let* r := the_number "radius" e in
    if (0 <? Qnum r)%Z then Some (Shape (points ps) (about zero zero) own r) else None.

(* Keys that are read, or that leave what is read alone: the tube and the law are checked by themselves. *)
Definition sections_known : list (string * list string) := [
  ("", ["name"; "axes"; "units"; "prescribed_time"; "initial_state"; "body"]);
  ("state_space", ["lower"; "upper"; "axes"; "normals"; "offsets"]); ("initial_set", ["lower"; "upper"; "share"]); ("target_set", ["lower"; "upper"; "axes"; "normals"; "offsets"]);
  ("unsafe", ["name"; "axes"; "lower"; "upper"; "vertices"; "normals"; "offsets"; "centre"; "radius"; "segment"]);
  ("tube", ["clearance"; "min_width"; "design"; "prefer"; "max_speed"; "max_acceleration"; "segments"; "seed"]);
  ("control", ["gain"; "e_max"; "u_max"; "period"; "latency"; "outside"; "saturate"]);
  ("emit", ["scalar"; "math"; "tick_period"; "selftest"; "rust"]);
  ("plant", ["f_max"; "w_max"; "g_min"; "g_max"; "g_cross"; "noise"])].

(* The sections of a text whose keys are all known, each once. *)
Definition sections_in (text : string) : option (list section) :=
  let* l := tokens text Between [] in
  let* ss := document (S (List.length l)) l (Section_ false "" []) [] in
  let known := forallb (fun s => match find (head s) sections_known with
    | Some ks => if only ks (body s) then if once (body s) then Bool.eqb (many s) (String.eqb (head s) "unsafe") else false else false
    | None => false end) ss in
  let singles := map (fun s => (head s, VTruth true)) (filter (fun s => negb (many s)) ss) in
  if negb known then None else if negb (once singles) then None else Some ss.
Definition part_of (h : string) (ss : list section) : entries := match List.find (fun s => String.eqb (head s) h) ss with Some s => body s | None => [] end.

(* A number for each of n components, or one for all. *)
Definition each (n : nat) (v : value) : option (list Q) :=
  match v with VNumber q => Some (repeat q n) | _ => let* l := numbers v in of_length n l end.
Definition each_or (n : nat) (d : Q) (k : string) (e : entries) : option (list Q) := match find k e with None => Some (repeat d n) | Some v => each n v end.

Definition task_in (text : string) : option (string * task) :=
  let* ss := sections_in text in
  let part h := part_of h ss in
  let top := part "" in
  let* T := the_number "prescribed_time" top in
  let* x := the_numbers "initial_state" top in
  let n := List.length x in
  let* h := each_or n 0%Q "body" top in
  let none := repeat 0%Q n in
  let* space := box_of n h (part "state_space") in
  let* start := box_of n none (part "initial_set") in
  let* target := box_of n none (part "target_set") in
  let* names := names_of n top in
  let* whole := box_of n none (part "state_space") in
  let* unsafe := every (fun s => shape_of names whole h (body s)) (filter many ss) in
  let* clearance := number_or (3 # 100) "clearance" (part "tube") in
  let* width := number_or (1 # 20) "min_width" (part "tube") in
  let* name := match find "name" top with Some (VText w) => Some w | _ => None end in
  let* walls := faces_of names h (part "state_space") in
  let* goals := faces_of names none (part "target_set") in
  Some (name, Task n T x space start target unsafe clearance (Qmax width (1 # 1048576)) walls goals).

(* Limits on u: the task's u_max, where it has one; and whether those of a text are there just then, and no larger. *)
Definition limits_in (text : string) : option (option (list Q)) :=
  let* ss := sections_in text in
  let* x := the_numbers "initial_state" (part_of "" ss) in
  match find "u_max" (part_of "control" ss) with
  | None => Some None
  | Some v => let* l := each (List.length x) v in Some (Some l)
  end.
Definition limits_within (limits : list (option Q)) (most : option (list Q)) : bool :=
  match most with
  | None => forallb (fun l => match l with None => true | Some _ => false end) limits
  | Some us => Nat.eqb (List.length limits) (List.length us) && forallb (fun p => match fst p with Some m => Qle_bool m (snd p) | None => false end) (combine limits us)
  end.

(* The conditions that a task with a period states. Where one bound of g is missing it is 1, or the other one where 1 contradicts that. *)
Definition conditions_in (text : string) : option conditions :=
  let* ss := sections_in text in
  let control := part_of "control" ss in let plant := part_of "plant" ss in
  let* x := the_numbers "initial_state" (part_of "" ss) in
  let n := List.length x in
  let* period := the_number "period" control in
  let* latency := number_or 0 "latency" control in
  let* share := number_or (9 # 10) "share" (part_of "initial_set" ss) in
  let* noise := number_or 0 "noise" plant in
  let* drift := each_or n 0%Q "f_max" plant in
  let* wind := each_or n 0%Q "w_max" plant in
  let* cross := each_or n 0%Q "g_cross" plant in
  let* high := each_or n 1%Q "g_max" plant in
  let* low := match find "g_min" plant with Some v => each n v | None => Some (map (Qmin 1) high) end in
  let high := match find "g_max" plant with Some _ => high | None => map (Qmax 1) low end in
  Some (Conditions period latency share noise (map (fun p => Qred (fst p + snd p)) (combine drift wind)) low high cross).

(* What one tick takes, in seconds. *)
Definition tick_period_in (text : string) : option Q := let* ss := sections_in text in the_number "tick_period" (part_of "emit" ss).
