"""`<p>.v` from the text of the C itself: the file holds that text, and Coq reads it. What is taken from elsewhere are the task's
numbers, P7's bound and the unit of the table; constants, table and steps are found by Coq in the text."""

from __future__ import annotations

import sys
from pathlib import Path

from stt_codegen.theorem.reading import Facts, facts
from stt_codegen.theorem.writing import DEPTH, FORMATS, box, listed, rational


def quoted(text: str) -> str:
    """A Coq string. Coq knows no escape but the doubled quote, and these texts are ASCII."""
    return '"' + text.replace('"', '""') + '"'


def the_task(found: Facts) -> str:
    unsafe = ";\n   ".join(box(edges) for _, edges in found.unsafe)
    return (
        f"(Task {found.n} {rational(found.t_c)} {listed(found.state)}\n  {box(found.space)} (* state space *)\n"
        f"  {box(found.start)} (* initial set *)\n  {box(found.target)} (* target set *)\n  [{unsafe}] (* unsafe sets *)\n"
        f"  {rational(found.clearance)} {rational(found.min_width)} (* clearance, least width *))%Q"
    )


TEMPLATE = """\
(* {name}.v: a theorem about the controller in {name}.c, whose text is below. Coq reads it.

   For every time and state in finite numbers of ordinary size, `{name}_control` ends, with nothing that C leaves undefined; what it
   stores are finite inputs that act as the law (13) with e clamped, on the distances of the state from edges L and U, up to
   32 units of rounding in the factor and in epsilon; its status says whether the state is between L and U in every dimension.
   For every time, L and U are those of the tube theorem: as wide as demanded, within the state space, clear of every unsafe set,
   in the initial set at 0 and in the target set from t_c on.

   Assumed: IEEE 754 arithmetic without contraction, and a library whose logarithm is within 4 units in the last place. *)
From Coq Require Import ZArith QArith Qreals Reals List String.
From Flocq Require Import IEEE754.BinarySingleNaN.
From Stt Require HeldLaw.
From Stt Require Import Tube Speed Rounding Emitted EmittedTube Syntax Read Run Emission Control Semantics Edge Law Controller Design.
Import ListNotations.

Definition the_text : string := {text}%string.

(* The task. Sets have the body added; all numbers are exact. *)
Definition the_task : Tube.task := {task}.
Definition the_unit : Q := {unit}.
Definition the_error : Q := {error}.

Definition the_source := read (suffix {format}) {quoted_name} the_text.
Definition the_constants : constants := Eval vm_compute in constants_of {format} the_source.
Definition the_coefficients : list decimal := Eval vm_compute in coefficients_of the_source.
Definition the_table : Tube.table := Eval vm_compute in rows_of {format} the_unit the_constants the_coefficients.
Definition the_scale : scale := Eval vm_compute in scale_of {format} the_constants.
Definition the_gain : Q := Eval vm_compute in value_of {format} (gain_lower the_constants).
Definition the_clamp : Q := Eval vm_compute in value_of {format} (Emission.clamp the_constants).
Definition the_steps : list Z := Eval vm_compute in steps_of (Tube.n the_task) the_table.
Definition the_late : Q := Eval vm_compute in late_of {format} (Tube.T the_task) the_table the_scale.
Definition the_program : source := Source (preamble {format} {quoted_name}) [("@coefficients"%string, the_coefficients)] (Emission.emitted the_constants).

(* The text is this program: the table, and the functions that `tube` and `control` are made of. *)
Lemma text_read : option_map keep (read (suffix {format}) {quoted_name} the_text) = Some the_program.
Proof. vm_cast_no_check (eq_refl (Some the_program)). Qed.

(* P1 to P5 of the exact tube, with room for the error. *)
Lemma tube_checked : check the_unit the_error {depth} the_task the_table = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
Lemma slopes_checked : slopes the_error the_task the_table the_steps = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
(* P7: the arithmetic moves no edge by more than the error. *)
Lemma rounding_checked : rounding_check {format} the_unit the_error the_task the_table the_steps the_scale the_late = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
(* The constants and the table of the text are these numbers, and of ordinary size. *)
Lemma constants_checked : constants_check {format} the_constants the_coefficients the_unit the_task the_table the_scale the_gain the_clamp = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

Notation number := (binary_float (precision {format}) (largest_exponent {format})).

(* What `control` does: *)
Theorem controller : forall (log_ : number -> number), accurate (precision {format}) (largest_exponent {format}) log_ ->
  let A := machine (precision {format}) (largest_exponent {format}) (Edge.pos_ {format}) (Edge.below_ {format}) log_ in
  forall (t : number) (x : nat -> number),
  is_finite t = true -> (forall i, (i < {n})%nat -> is_finite (x i) = true) ->
  (forall i, (i < {n})%nat -> (Rabs (B2R (x i)) <= 1073741824)%R) ->
  forall tau, reads {format} (B2R t) tau ->
  let L i := EmittedTube.emitted {format} the_unit the_table the_scale fst i (B2R t) in
  let U i := EmittedTube.emitted {format} the_unit the_table the_scale snd i (B2R t) in
  exists program out status,
    option_map keep (read (suffix {format}) {quoted_name} the_text) = Some program /\\
    execute A (log_name the_constants) program "@control" [@R_ A t] (places_of A the_constants (fun i => x (Z.to_nat i))) = Some (out, Some (I_ status)) /\\
    (status = 0%Z <-> forall i, (i < {n})%nat -> (L i < B2R (x i) < U i)%R) /\\ (status = 0 \\/ status = 1)%Z /\\
    forall i, (i < {n})%nat -> exists v : number, stored (A := A) "u" (Z.of_nat i) out = Some v /\\ is_finite v = true /\\
      HeldLaw.acts (Q2R the_gain) (Q2R the_clamp) (32 * Q2R (half_ulp {format})) None (B2R (x i) - L i) (U i - B2R (x i)) (B2R v).
Proof.
  intros log_ accurate A t x Ft Fx Sx tau Rt L U.
  destruct (control_acts {format} the_constants the_coefficients (preamble {format} {quoted_name}) the_unit the_error {depth} the_task the_table the_steps the_scale the_late
    the_gain the_clamp tube_checked slopes_checked rounding_checked constants_checked log_ accurate t x Ft Fx Sx tau Rt) as (out & status & H).
  exists the_program, out, status. split; [exact text_read|exact H].
Qed.

(* and what its edges are: *)
Definition tube := emitted_tube_sound {format} the_unit the_error {depth} the_task the_table the_steps the_scale the_late tube_checked slopes_checked rounding_checked.

Print Assumptions controller.
"""


def deep(task: bytes, source: bytes, certificate: bytes) -> str:
    """The text of `<p>.v` for Coq. Raises as `reading.facts` does."""
    found = facts(task, source, certificate)
    format_, _, _ = FORMATS[found.scalar]
    return TEMPLATE.format(
        name=found.name,
        quoted_name=f"{quoted(found.name)}%string",
        text=quoted(source.decode("ascii")),
        task=the_task(found),
        unit=rational(found.unit),
        error=rational(found.error * found.unit),
        format=format_,
        depth=DEPTH,
        n=found.n,
    )


if __name__ == "__main__":
    task, c, certificate, out = map(Path, sys.argv[1:5])
    out.write_text(deep(task.read_bytes(), c.read_bytes(), certificate.read_bytes()))
