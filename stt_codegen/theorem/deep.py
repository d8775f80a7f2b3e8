"""`<p>.v` from the texts of the task, the header and the C: the file holds these texts, and Coq reads them. What is taken from elsewhere
is not believed: P7's bound, the unit of the table, and numbers that bound logarithms and widths."""

from __future__ import annotations

import math
import sys
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any

from stt_codegen.errors import BadInput
from stt_codegen.theorem.reading import Facts, facts
from stt_codegen.theorem.hints import hints, steps
from stt_codegen.theorem.writing import CELLS, DEPTH, FORMATS, box, listed, rational

GRID = 1 << 24  # logarithms, widths and shares are multiples of 1/GRID
SLACK = 4096  # how far the bound of a logarithm is from it, in these: Coq's enclosure of exp is not exact


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


@dataclass(frozen=True)
class Bounds:
    """What is known of the plant, by component: force pushes it (drift and disturbance), g is between g_min and g_max, cross is what other inputs pull."""

    force: list[Fraction]
    g_min: list[Fraction]
    g_max: list[Fraction]
    cross: list[Fraction]
    tau: Fraction  # no acting sample is older
    latency: Fraction
    noise: Fraction


@dataclass(frozen=True)
class Plant:
    """The record `plant` of proof/Uniform.v."""

    bounds: Bounds
    rho: list[Fraction]
    narrowest: list[Fraction]
    widest: list[Fraction]
    log_up: list[Fraction]
    log_down: list[Fraction]

    def __str__(self) -> str:
        b = self.bounds
        rows = [self.rho, b.g_min, b.g_max, b.force, b.cross]
        scalars = " ".join(map(rational, (b.tau, b.latency, b.noise)))
        rest = [self.narrowest, self.widest, self.log_up, self.log_down]
        return f"(Plant {' '.join(map(listed, rows))}\n  {scalars}\n  {' '.join(map(listed, rest))})%Q"


def _widths(found: Facts) -> tuple[list[Fraction], list[Fraction]]:
    """The least and greatest Bezier coefficient of the width, by component."""
    narrowest, widest = [], []
    for i in range(found.n):
        hull = []
        for k in range(found.segments):
            a, b, c, d = (found.table[k + j][i][1] - found.table[k + j][i][0] for j in range(4))
            hull += [a + 4 * b + c, 4 * b + 2 * c, 2 * b + 4 * c, b + 4 * c + d]
        narrowest.append(min(hull) * found.unit)
        widest.append(max(hull) * found.unit)
    return narrowest, widest


def plant(found: Facts, bounds: Bounds, rho: Fraction) -> Plant | None:
    """Numbers with which `plant_check` holds for this rho, or None: the same formulas as in proof/Uniform.v."""
    r = 32 * Fraction(1, 1 << FORMATS[found.scalar][1])
    eta = found.error * found.unit + bounds.noise
    narrowest, widest = _widths(found)
    z = 1 / (1 + rho)
    most, log_up, log_down = [], [], []
    for i in range(found.n):
        least = narrowest[i] * z - eta
        if least <= 0:
            return None
        y = (narrowest[i] * (1 - z) + eta) / least
        log_up.append(Fraction(math.ceil(math.log(y) * GRID) + SLACK, GRID))
        most.append(found.gain[i] / least * (1 + 1 / y) * (1 + r) * (log_up[i] + r))
    for i in range(found.n):
        v = found.unit * 3 * steps(found)[i] * Fraction(found.segments) / found.t_c
        force = bounds.force[i] + bounds.cross[i] * sum(most[j] for j in range(found.n) if j != i)
        drift = (force + v) * bounds.tau + bounds.g_max[i] * most[i] * bounds.latency
        y = (narrowest[i] * (1 - z) - drift - eta) / (narrowest[i] * z + drift + eta)
        if y <= 1:
            return None
        log_down.append(Fraction(math.floor(math.log(y) * GRID) - SLACK, GRID))
        side = narrowest[i] * (rho - 1) / (rho + 1) - 2 * (force + v + bounds.g_max[i] * most[i]) * bounds.tau
        pull = bounds.g_min[i] * found.gain[i] / (widest[i] * z + drift + eta) * (1 + 1 / y) * (1 - r) * (log_down[i] - r)
        if 2 * eta + r * (widest[i] + 2 * eta) >= side or force + v > pull or log_down[i] < r:
            return None
    return Plant(bounds, [rho] * found.n, narrowest, widest, log_up, log_down)


def found_plant(found: Facts, bounds: Bounds) -> Plant | None:
    """The greatest rho of a grid with which the check holds: from every start with |e| <= (rho - 1)/(rho + 1), |e| stays below it."""
    for k in range(98, 0, -1):
        rho = (1 + Fraction(k, 100)) / (1 - Fraction(k, 100))
        numbers = plant(found, bounds, rho)
        if numbers is not None:
            return numbers
    return None


def example(n: int) -> Bounds:
    """A plant for tasks that have none: xdot = u + w, |w| <= 1/20, sampled every millisecond."""
    return Bounds(
        [Fraction(1, 20)] * n,
        [Fraction(1)] * n,
        [Fraction(1)] * n,
        [Fraction(0)] * n,
        Fraction(1, 1000),
        Fraction(0),
        Fraction(1, 1 << 20),
    )


TEMPLATE = """\
(* {name}.v: theorems about the controller in {name}.c. The texts of the task, of {name}.h and of {name}.c are below, and Coq reads them.

   For every time and state in finite numbers of ordinary size, `{name}_control` ends, with nothing that C leaves undefined; what it
   stores are finite inputs that act as the law (13) with e clamped, on the distances of the state from edges L and U, up to
   32 units of rounding in the factor and in epsilon; its status says whether the state is between L and U in every dimension.
   For every time, L and U are those of the tube theorem: as wide as demanded, within the state space, clear of every unsafe set,
   in the initial set at 0 and in the target set from t_c on.

   Assumed: IEEE 754 arithmetic without contraction, and a library whose logarithm is within 4 units in the last place. *)
From Coq Require Import ZArith QArith Qreals Reals List String.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import IEEE754.BinarySingleNaN.
From Stt Require Held HeldLaw.
From Stt Require Import Tube Speed Rounding Emitted EmittedTube Syntax Read Run Emission Control Semantics Edge Law Controller Windows Period Design Uniform Sound Sharp Toml Header.
Import ListNotations.
Open Scope R_scope.

(* The three files, as they are. *)
Definition the_toml : string := {toml}%string.
Definition the_header : string := {header}%string.
Definition the_text : string := {text}%string.

(* The task that is read in the first. Sets have the body added; all numbers are exact. *)
Definition the_task : Tube.task := {task}.
Lemma task_read : task_in the_toml = Some ({quoted_name}, the_task).
Proof. vm_cast_no_check (eq_refl (Some ({quoted_name}, the_task))). Qed.

(* The header has this type of numbers, these values of the status, prototypes, and no more that the C could see. *)
Lemma header_read : header_ok {format} {quoted_name} {n} the_header = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

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


{loop}Definition theorems := (task_read, header_read, text_read, controller, tube, closed_loop).
Print Assumptions theorems.
"""


UNIFORM = """\
(* The plant: bounds by component, and numbers that help Coq. *)
Definition the_plant : plant := {plant}.
Lemma plant_checked : plant_check the_unit the_error {depth} the_task the_table the_steps the_gain the_clamp (32 * half_ulp {format}) the_plant = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

(* The closed loop. Input p is what `control` stores, run on the text's program at clock p with the state measured at the time `taken p`; it acts from `switch p`
   to `switch (p + 1)`. The derivative of x i is y + g u, with y all but its own input. *)
Theorem closed_loop : forall (log_ : number -> number), accurate (precision {format}) (largest_exponent {format}) log_ ->
  forall (taken switch : nat -> R) (x : nat -> R -> R) (y g : nat -> nat -> R -> R) (clock : nat -> number) (measured : nat -> nat -> number) (program : source),
  option_map keep (read (suffix {format}) {quoted_name} the_text) = Some program ->
  let L i t := Tube.lower the_unit the_task the_table i t in
  let U i t := Tube.upper the_unit the_task the_table i t in
  let input p i := applied {format} log_ the_constants program (clock p) (measured p) i in
  (* times: the first input acts from 0 on; no acting sample is older than tau, none begins to act later than the latency *)
  (switch 0%nat = 0 /\\ forall p, 0 <= taken p <= switch p /\\ switch p < switch (S p) /\\
    switch (S p) - taken p <= Q2R (tau_ the_plant) /\\ switch p - taken p <= Q2R (latency_ the_plant)) ->
  (forall p, is_finite (clock p) = true /\\ reads {format} (B2R (clock p)) (taken p)) ->
  (* sensors *)
  (forall p i, (i < {n})%nat -> is_finite (measured p i) = true /\\ Rabs (B2R (measured p i)) <= 1073741824 /\\
    Rabs (B2R (measured p i) - x i (taken p)) <= Q2R (noise_ the_plant)) ->
  (* the start: |e| <= (rho - 1)/(rho + 1) *)
  (forall i, (i < {n})%nat -> (U i 0 - L i 0) * / (1 + Q2R (nth i (rho_ the_plant) 0%Q)) <= x i 0 - L i 0 /\\
    (U i 0 - L i 0) * / (1 + Q2R (nth i (rho_ the_plant) 0%Q)) <= U i 0 - x i 0) ->
  (* the plant *)
  (forall i t, (i < {n})%nat -> continuity_pt (x i) t) ->
  (forall p t, switch p < t < switch (S p) -> (forall i, (i < {n})%nat -> L i t < x i t < U i t) -> forall i, (i < {n})%nat ->
    is_derive (x i) t (y i p t + g i p t * input p i) /\\
    Rabs (y i p t) <= Q2R (nth i (push_ the_plant) 0%Q) + Q2R (nth i (cross_ the_plant) 0%Q) * Held.others {n} i (fun j => Rabs (input p j)) /\\
    Q2R (nth i (gmin_ the_plant) 0%Q) <= g i p t <= Q2R (nth i (gmax_ the_plant) 0%Q)) ->
  forall p t, 0 <= t <= switch p ->
    (forall i, (i < {n})%nat -> at_ (lo (space the_task)) i < x i t < at_ (hi (space the_task)) i) /\\
    (forall o, In o (unsafe the_task) -> exists i, (i < {n})%nat /\\
      (x i t < at_ (lo o) i - Q2R (clearance the_task) \\/ at_ (hi o) i + Q2R (clearance the_task) < x i t)) /\\
    (Q2R (Tube.T the_task) <= t -> forall i, (i < {n})%nat -> at_ (lo (target the_task)) i < x i t < at_ (hi (target the_task)) i).
Proof.
  intros log_ accurate taken switch x y g clock measured program Text L U input Times Clock Sensors Start Continuous Ode.
  rewrite text_read in Text. injection Text as <-.
  exact (controller_sound {format} the_constants the_coefficients (preamble {format} {quoted_name}) the_unit the_error {depth} the_task the_table the_steps the_scale the_late
    the_gain the_clamp the_plant tube_checked slopes_checked rounding_checked constants_checked plant_checked log_ accurate taken switch x y g clock measured
    Times Continuous Start Ode Clock Sensors).
Qed.

"""

SHARP = """\
(* P9's numbers. By component: gain, (1 - e_max)/2, u_max, rho, bounds on |f + w|, g_ii and |g_ij|, shift. Before that: period + latency, latency, share, what the
   arithmetic of the law loses. *)
Definition the_sampling : sampling := (Sampling {tau} {latency} {share} {lost} [
  {components}])%Q.
(* By window and component a bound on |u| and one on the logarithm in it: they help Coq and are not believed. *)
Definition the_hints : list (list (Q * Q)) := [
  {hints}]%Q.
Lemma period_checked : period_check the_unit the_task the_table the_sampling the_hints {cells} the_error = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
Lemma law_checked : law_check {format} the_task the_sampling the_gain the_clamp = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

(* The closed loop. Input p is what `control` stores, run on the text's program at clock p with the state measured at the time `taken p`; it acts from `switch p`
   to `switch (p + 1)`. *)
Theorem closed_loop : forall (log_ : number -> number), accurate (precision {format}) (largest_exponent {format}) log_ ->
  forall (taken switch : nat -> R) (x push : nat -> R -> R) (G : nat -> nat -> R -> R) (clock : nat -> number) (measured : nat -> nat -> number) (program : source),
  option_map keep (read (suffix {format}) {quoted_name} the_text) = Some program ->
  let L i t := Tube.lower the_unit the_task the_table i t in
  let U i t := Tube.upper the_unit the_task the_table i t in
  let of i := part the_sampling i in
  let input p i := applied {format} log_ the_constants program (clock p) (measured p) i in
  (* times: the first input acts from 0 on; no acting sample is older than period + latency, none begins to act later than the latency *)
  (switch 0%nat = 0 /\\ forall p, 0 <= taken p <= switch p /\\ switch p < switch (S p) /\\
    switch (S p) - taken p <= Q2R (tau_of the_sampling) /\\ switch p - taken p <= Q2R (latency_of the_sampling)) ->
  (forall p, is_finite (clock p) = true /\\ reads {format} (B2R (clock p)) (taken p)) ->
  (* sensors *)
  (forall p i, (i < {n})%nat -> is_finite (measured p i) = true /\\ Rabs (B2R (measured p i)) <= 1073741824 /\\
    Rabs (B2R (measured p i) - x i (taken p)) <= Q2R (shift (of i)) - Q2R the_error) ->
  (forall i t, (i < {n})%nat -> continuity_pt (x i) t) ->
  (* the start: |e| <= share *)
  (forall i, (i < {n})%nat -> Rabs (2 * x i 0 - L i 0 - U i 0) <= Q2R (share_of the_sampling) * (U i 0 - L i 0)) ->
  (* the plant *)
  (forall p t, switch p < t < switch (S p) -> (forall i, (i < {n})%nat -> L i t < x i t < U i t) -> forall i, (i < {n})%nat ->
    is_derive (x i) t (push i t + total {n} (fun j => G i j t * input p j)) /\\
    Rabs (push i t) <= Q2R (pushed (of i)) /\\ Q2R (g_min (of i)) <= G i i t <= Q2R (g_max (of i)) /\\
    forall j, (j < {n})%nat -> j <> i -> Rabs (G i j t) <= Q2R (g_cross (of i))) ->
  forall p t, 0 <= t <= switch p ->
    (forall i, (i < {n})%nat -> Rabs (2 * x i t - L i t - U i t) <= (Q2R (rho_of (of i)) - 1) / (Q2R (rho_of (of i)) + 1) * (U i t - L i t)) /\\
    (forall i, (i < {n})%nat -> at_ (lo (space the_task)) i < x i t < at_ (hi (space the_task)) i) /\\
    (forall o, In o (unsafe the_task) -> exists i, (i < {n})%nat /\\
      (x i t < at_ (lo o) i - Q2R (clearance the_task) \\/ at_ (hi o) i + Q2R (clearance the_task) < x i t)) /\\
    (Q2R (Tube.T the_task) <= t -> forall i, (i < {n})%nat -> at_ (lo (target the_task)) i < x i t < at_ (hi (target the_task)) i).
Proof.
  intros log_ accurate taken switch x push G clock measured program Text L U of input Times Clock Sensors Continuous Start Plant.
  rewrite text_read in Text. injection Text as <-.
  exact (controller_sound_sharp {format} the_constants the_coefficients (preamble {format} {quoted_name}) the_unit the_error {depth} the_task the_table the_steps the_scale the_late
    the_gain the_clamp the_sampling the_hints {cells} tube_checked slopes_checked rounding_checked constants_checked period_checked law_checked log_ accurate taken switch x push G
    clock measured Times Clock Sensors Continuous Start Plant).
Qed.

"""


def deep(task: bytes, header: bytes, source: bytes, certificate: bytes) -> str:
    """The text of `<p>.v` for Coq. Raises as `reading.facts` does."""
    found = facts(task, source, certificate)
    format_, _, _ = FORMATS[found.scalar]
    shared = {"quoted_name": f"{quoted(found.name)}%string", "format": format_, "depth": DEPTH, "n": found.n}
    return TEMPLATE.format(
        name=found.name,
        toml=quoted(task.decode("ascii")),
        header=quoted(header.decode("ascii")),
        text=quoted(source.decode("ascii")),
        task=the_task(found),
        unit=rational(found.unit),
        error=rational(found.error * found.unit),
        loop=_loop(found, shared),
        **shared,
    )


def _loop(found: Facts, shared: dict[str, Any]) -> str:
    """The theorem of the closed loop: of the task's samples, or of an example where the task has none."""
    if found.sampling is None:
        numbers = found_plant(found, example(found.n))
        if numbers is None:
            raise BadInput("theorem: no rho for the example of a sampled loop")
        return UNIFORM.format(plant=numbers, **shared)
    s = found.sampling
    rest = (s.rho, s.force, s.g_min, s.g_max, s.g_cross, s.shift)
    components = [f"Component the_gain the_clamp None {' '.join(rational(values[i]) for values in rest)}" for i in range(found.n)]
    return SHARP.format(
        tau=rational(s.period + s.latency),
        latency=rational(s.latency),
        share=rational(s.share),
        lost=rational(s.lost),
        components=";\n  ".join(components),
        hints=";\n  ".join(f"[{'; '.join(f'({rational(u)}, {rational(log)})' for u, log in row)}]" for row in hints(found, s)),
        cells=CELLS,
        **shared,
    )


if __name__ == "__main__":
    task, c, certificate, out = map(Path, sys.argv[1:5])
    out.write_text(deep(task.read_bytes(), c.with_suffix(".h").read_bytes(), c.read_bytes(), certificate.read_bytes()))
