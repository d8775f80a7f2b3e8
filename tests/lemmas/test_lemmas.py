"""The lemma book: no lemma is open, the expected ones are refuted, and no wrong statement or kernel is proved."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import casadi as ca
import numpy as np
import pytest
import sympy as sp
from flint import arb
from typer.testing import CliRunner

from stt_codegen import constraints
from stt_codegen.certify import moving_slack as moving
from stt_codegen.certify import slack
from stt_codegen.certify.adaptive import alpha_curves as update_module
from stt_codegen.cli.main import app
from stt_codegen.controller.kernels import logarithm
from stt_codegen.lemmas import book as book_module
from stt_codegen.lemmas import cache as cache_module
from stt_codegen.lemmas.book import FAMILIES, BookEntry, page, prove_all
from stt_codegen.lemmas.emitted import examples, functions, printed_kernels
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict, all_of, prove_above, prove_identities, prove_positive, with_steps
from stt_codegen.lemmas.paper import bumps, reach, theorem_4_1, update_function
from stt_codegen.lemmas.sampling import definite_plants, first_exit, sampled, sampled_windows, worst_path_theorem
from stt_codegen.paper import adaptive_tube, circumvent, control_law, reach_tube, refined_tube, smooth
from stt_codegen.plants import Plant
from stt_codegen.program.analyse import exact_logarithm as enclosed
from stt_codegen.program.convert.from_casadi import lower
from stt_codegen.program.nodes import Assign, Call, For, Load, Op, Return, Select, Status, Var, integer, real
from stt_codegen.program.operations import BOOL, INT, REAL
from stt_codegen.program.symbolic.paths import follow
from stt_codegen.program.targets.python.printer import PythonPrinter
from stt_codegen.sampling import periods, sampled_loop, sampling_conditions, windows
from stt_codegen.sampling.numbers import Fractions
from stt_codegen.sampling.path import drive_response, integer_logarithm, path_proof, path_windows, worst_path
from stt_codegen.sampling.sampled_loop import SampledLoop, first_order_loop
from stt_codegen.sampling.windows import extremes
from stt_codegen.task.sets.convex_sets import BoxSet
from stt_codegen.task.sets.motion import Leg
from tests.support.controllers import ROOT

REFUTED = {  # statements that do not hold: of the paper as printed, and of rules that look right
    "smooth.plain_max",
    "smooth.printed_float",
    "reach.printed",
    "transform.outer_product",
    "transform.outer_jacobian",
    "update.inverted_start",
    "bumps.printed_window",
    "theorem.rayleigh",
    "transform.outer_loop",
    "transform.outer_three",
    "update.printed_lemma",
    "plant.robot_anywhere",
    "sampled.centre_rule",
    "windows.printed_defined",
    "windows.printed_order",
    "windows.one_dimension",
    "windows.from_rho",
    "windows.shortest",
    "windows.printed_wall",
    "windows.random_side",
    "limits.clipped",
    "limits.clipped_leaves",
    "limits.nominal",
    "filtered.nominal_period",
    "filtered.stamps_alone",
    "filtered.forward_held",
}


def lemma(name: str) -> Lemma:
    """Return the lemma of this name."""
    return next(v for _, lemmas in FAMILIES.values() for v in lemmas if v.name == name)


def test_no_lemma_is_open_the_expected_ones_are_refuted_and_the_pages_are_current() -> None:
    """This is one test because proving the whole book takes a minute and a half."""
    entries = prove_all()
    assert {e.lemma.name for e in entries if e.verdict is Verdict.REFUTED} == REFUTED
    assert not [(e.lemma.name, e.outcome.evidence) for e in entries if e.verdict is Verdict.OPEN]
    assert all(e.outcome.evidence for e in entries)
    assert (ROOT / "generated" / "lemmas.md").read_text() == page(entries)
    assert_latex_is_well_formed_and_complete(entries)


def test_names_belong_to_their_family_and_are_used_once() -> None:
    names = [(family, v.name) for family, (_, lemmas) in FAMILIES.items() for v in lemmas]
    assert all(name.split(".")[0] == family for family, name in names)
    assert len({name for _, name in names}) == len(names)


# ---- a wrong kernel in place of the printed one, one family after the other


def wrong_law() -> ca.Function:
    k, xi, epsilon = (ca.SX.sym(v) for v in ("k", "xi", "epsilon"))
    return ca.Function("law", [k, xi, epsilon], [k * xi * epsilon], ["k", "xi", "epsilon"], ["u"])


def wrong_transform() -> ca.Function:
    a, b = ca.SX.sym("a"), ca.SX.sym("b")
    return ca.Function("t", [a, b], [-ca.log(b / a), (1 + b / a) / a], ["a", "b"], ["epsilon", "xi"])


def wrong_weights(s: ca.SX) -> ca.SX:
    r = 1 - s
    return ca.vertcat(r * r * r, 1 + 3 * r * (1 + r * s), 1 + 3 * s * (1 + s * s), s * s * s)


def wrong_edge() -> ca.Function:
    start, end, value = (ca.SX.sym(v) for v in ("start", "end", "sigma"))
    return ca.Function("reach_edge", [start, end, value], [start + end * value], ["start", "end", "sigma"], ["rho"])


def wrong_join(rate: bool = False) -> ca.Function:
    a, b, nu = (ca.SX.sym(v) for v in ("a", "b", "nu"))
    return ca.Function("join", [a, b, nu], [smooth.smooth_max(a, b, nu)], ["a", "b", "nu"], ["joined"])


def wrong_max(a: ca.SX, b: ca.SX, nu: ca.SX) -> ca.SX:
    half = ca.fabs(a - b) / 2
    return (a + b) / 2 + half + ca.log1p(ca.exp(-nu * half)) / nu


def wrong_sigma(t: ca.SX, t_c: ca.SX) -> ca.SX:
    return (1 - ca.exp(-t / ca.fmax(t_c - t, 2.0**-10 * t_c))) / (1 + ca.exp(-2 * t / ca.fmax(t_c - t, 2.0**-10 * t_c)))


def wrong_equation(psi: ca.SX, alpha: ca.SX, parameters: Any) -> ca.SX:
    theta0, kappa, mu, varsigma = parameters
    return adaptive_tube.trigger(psi, theta0, mu, varsigma) / (psi + alpha) - kappa * alpha


def wrong_newton() -> ca.Function:
    p, q, z = (ca.SX.sym(v) for v in ("p", "q", "z"))
    f = (z - p) * z * z - q
    return ca.Function("newton", [p, q, z], [z - f / (3 * z * z - p * z)], ["p", "q", "z"], ["next"])


def wrong_bump(t: ca.SX, shape: Any) -> ca.SX:
    height, steepness, middle, radius, cut = shape
    d = t - middle
    return height * ca.exp(-steepness * d * d / ca.fmax(radius * radius + d * d, cut))


SHIPPED = SimpleNamespace(  # functions as they are shipped, which the wrong ones below call
    constraints=constraints.separation_constraints,
    of=update_module.Curve.of,
    beyond=update_module.Curve.beyond,
    cell=update_module.Curve.cell,
    bounds_over=path_windows.PathLoop.bounds_over,
    input_bound=path_windows.ComponentLaw.input_bound,
    command=worst_path._Law.command,
    history=worst_path._Path._history,
)


def wrong_closing_rate(distance: Any, effect: Any) -> Any:
    return worst_path_theorem.P + worst_path_theorem.rate * distance + effect


upside_down = Plant(name="wrong", dimension=None, drift=lambda x: [0] * x.shape[0], input_matrix=lambda x: -ca.diag(1 + x**2))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "name", "wrong", "lemma_name"),
    [
        (control_law, "law", wrong_law, "transform.law_shipped"),
        (control_law, "transformed_error", wrong_transform, "transform.xi_shipped"),
        (control_law, "transformed_error", wrong_transform, "transform.odd"),
        (refined_tube, "weights", wrong_weights, "refined.weights_shipped"),
        (refined_tube, "weights", wrong_weights, "refined.bezier"),
        (reach_tube, "reach_edge", wrong_edge, "reach.hull"),
        (circumvent, "join", wrong_join, "smooth.join_shipped"),
        (smooth, "smooth_max", wrong_max, "smooth.form"),
        (reach, "FASTEST", 0.45, "reach.steepest"),
        (bumps, "BUMP", bumps.BUMP * bumps.height, "bumps.between"),
        (update_function, "THETA", update_function.THETA / 2, "update.away"),
        (definite_plants, "ROBOT", upside_down, "plant.robot"),
        (definite_plants, "ARM", upside_down, "plant.arm"),
        (sampled, "INPUT_OVER_GAIN", (1 / sampled.a - 1 / sampled.b) * sp.log(sampled.a / sampled.b), "sampled.pull"),
        (sampled, "Q", sampled.E * sp.cosh(sampled.E / 2), "sampled.law"),
        (
            sampling_conditions,
            "input_per_gain",
            lambda a, b, log, r: (1 / a - 1 / b) * log(a / b) + r * (1 / a + 1 / b),
            "sampled.sharp_evaluated",
        ),
        (sampling_conditions, "sharp_closing_speed", lambda s, u: s.closing_speed, "sampled.sharp_evaluated"),
        (sampling_conditions, "input_bound", lambda s, reach: 0 * s.closing_speed, "sampled.sharp_evaluated"),
        (sampling_conditions, "q", lambda e: e * np.cosh(e / 2), "sampled.diagonal_evaluated"),
        (sampling_conditions, "q_rate", lambda e: np.cosh(e / 2) ** 2, "sampled.diagonal_evaluated"),
        (sampling_conditions, "q_rate", lambda e: np.cosh(e / 2) ** 2, "sampled.general_evaluated"),
        (
            sampling_conditions.Staleness,
            "input_bound",
            lambda old: 0 * old.measured_eps_bound / old.width,
            "sampled.general_evaluated",
        ),
        (slack, "halves", lambda piece: (piece, piece), "refined.halves"),
        (slack, "units_above", lambda value, unit: math.floor(value / unit), "refined.integers"),
        (
            slack.ConstraintBlock,
            "slack_by_constraint",
            lambda self, pieces, *when: 2 * self._smallest_left_side(pieces),
            "rows.told",
        ),
        (moving, "cut", lambda piece, a, b: piece, "moving.parts"),
        (moving.MovingBounds, "at", lambda bounds, t: (bounds.constant // bounds.denominator).tolist(), "moving.bounds"),
        (Leg, "displacements_at", lambda leg, t: tuple(a for a, _ in leg.displacements), "moving.places"),
        (slack, "halves", lambda piece: (piece[..., :1] + 0 * piece, piece[..., :1] + 0 * piece), "rows.subdivided"),
        (constraints, "initial_state_constraints", lambda task: constraints.start_constraints(task), "rows.plain"),
        (
            constraints,
            "separation_constraints",
            lambda convex, clearances: SHIPPED.constraints(convex, [min(clearances, key=str)] * 3),
            "rows.apart",
        ),
        (constraints.Constraint, "bound_from", lambda row, origin: row.bound, "rows.moved"),
        (BoxSet, "support", lambda box, normal: Fraction(0), "rows.support"),
        (
            sampled_windows,
            "extremes",
            lambda design: extremes(replace(design, unit=1, coefficients=design.coefficients[::-1])),
            "sampled.windows",
        ),
        (windows, "OUTWARD_MARGIN", -(2.0**-40), "sampled.windows"),
        (sampled_loop, "worst_with_previous_window", lambda values, worse: values, "sampled.exact_windows"),
        (Fractions, "log_above", Fractions.log_below, "sampled.inputs"),
        (Fractions, "near_divisor", Fractions.far_divisor, "sampled.inputs"),
        (Fractions, "log_below", Fractions.log_above, "sampled.fractions"),
        (Fractions, "share_of_eps", lambda numbers, rho: rho / (rho + 1), "sampled.fractions"),
        (Fractions, "eps_of_share", lambda numbers, share: 1 / (1 - share), "sampled.setting"),
        (periods, "is_in_range", lambda *_: True, "sampled.all"),
        (periods, "first_failing", lambda conditions: None, "sampled.all"),
        (enclosed, "TERMS", 3, "sampled.logarithm"),
        (Fractions, "evenly", lambda numbers, end, parts: np.arange(parts + 1), "sampled.exact_windows"),
        (
            sampled_windows,
            "first_order_loop",
            lambda w, p, law, start: replace(first_order_loop(w, p, law, start), closing_speed=w.speed),
            "sampled.setting",
        ),
        (SampledLoop, "longest_age", property(lambda s: s.windows.shortest), "sampled.age"),
        (first_exit, "worst_with_previous_window", lambda values, worse: values, "sampled.before"),
        (
            update_module.Curve,
            "of",
            classmethod(lambda cls, *rest: replace(SHIPPED.of(*rest), speed_factor=rest[1])),
            "update.rounded",
        ),
        (update_module.Curve, "beyond", lambda self, z, p, q: SHIPPED.beyond(self, z, p, q + q), "update.root"),
        (update_module.Curve, "cell", lambda self, *rest: SHIPPED.cell(self, *rest)[:1] * 3, "update.falls"),
        (update_module.Curve, "balance", lambda self, psi, theta: self.root(psi, theta), "update.rises"),
        (update_module.Curve, "outer", lambda self, a, b: a, "update.promise"),
        (logarithm, "C", Fraction(2, 3), "transform.logarithm"),
        (
            worst_path_theorem,
            "INPUT_OVER_GAIN",
            (1 / sampled.a - 1 / sampled.b) * sp.log(sampled.a / sampled.b),
            "path.psi_rises",
        ),
        (worst_path_theorem, "closing_rate", wrong_closing_rate, "path.distance"),
        (worst_path_theorem, "closing_rate", wrong_closing_rate, "path.slides"),
        (worst_path_theorem, "closing_rate", wrong_closing_rate, "path.ends"),
        (worst_path_theorem, "closing_rate", wrong_closing_rate, "path.local"),
        (worst_path_theorem, "drive_answer", lambda start, c, lag, t: c + (start - c) * sp.exp(-t * lag), "path.drive"),
        (worst_path_theorem, "path_time", lambda time, theta: time + theta, "path.early"),
        (worst_path_theorem, "cell_speed", lambda at_begin, rest: at_begin * rest, "path.cells"),
        (integer_logarithm, "ARTANH_ERROR", -6, "path.logarithm"),
        (integer_logarithm, "LOG_TWO", integer_logarithm.LOG_TWO + 1000, "path.logarithm"),
        (drive_response, "decay_above", lambda x: drive_response.SHARE_ONE * 9 // 10, "path.drive_evaluated"),
        (drive_response.DriveCells, "acting", lambda cells, command: command, "path.drive_evaluated"),
        (worst_path._Law, "command", lambda law, near: SHIPPED.command(law, near * 2), "path.evaluated"),
        (worst_path._Fall, "through_cell", lambda fall, amount: amount, "path.evaluated"),
        (worst_path._Path, "_history", lambda path, level, cells: SHIPPED.history(path, level, 0), "path.evaluated"),
        (worst_path, "SLOWEST_START_BITS", 5, "path.evaluated"),
        (
            path_windows.PathLoop,
            "bounds_over",
            lambda loop, i, first, last, inputs: SHIPPED.bounds_over(loop, i, last, last, inputs),
            "path.joined",
        ),
        (
            path_windows.ComponentLaw,
            "input_bound",
            lambda law, narrow, rho: SHIPPED.input_bound(law, narrow, rho - 1),
            "path.joined",
        ),
        (worst_path.PathBounds, "covers", lambda bounds, tighter: True, "path.proof"),
        (path_proof, "_is_enough", lambda proof: True, "path.proof"),
        (theorem_4_1, "E", 2 * theorem_4_1.E, "theorem.edot"),  # it has no kernel; its definition is wrong instead
    ],
)
def test_a_wrong_kernel_leaves_its_lemma_open(
    module: Any, name: str, wrong: Callable[..., Any], lemma_name: str, monkeypatch: Any
) -> None:
    assert lemma(lemma_name).run().verdict is Verdict.PROVED
    monkeypatch.setattr(module, name, wrong)
    outcome = lemma(lemma_name).run()
    assert outcome.verdict is not Verdict.PROVED  # open, or refuted by a point
    assert outcome.evidence
    assert outcome.method != "none"  # a method ran and failed to prove it


def test_a_lemma_with_an_open_step_is_open() -> None:
    sharp = lemma("sampled.sharp")
    proved, verdicts = sharp.run(), dict.fromkeys(sharp.steps, Verdict.PROVED)
    assert with_steps(sharp, proved, verdicts) == proved
    for name in sharp.steps:
        for wrong in ({**verdicts, name: Verdict.OPEN}, {k: v for k, v in verdicts.items() if k != name}):
            outcome = with_steps(sharp, proved, wrong)
            assert outcome.verdict is Verdict.OPEN
            assert name in outcome.evidence[0]
    refuted = Outcome(Verdict.REFUTED, "counterexample", ("at 0",))
    assert with_steps(sharp, refuted, {}) == refuted


def test_the_book_makes_a_lemma_with_an_open_step_open(monkeypatch: Any, tmp_path: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))

    def make_lemma(name: str, verdict: Verdict, *steps: str) -> Lemma:
        return Lemma(name, "", "", (), "ours", lambda: Outcome(verdict, "by hand", ("said",)), steps)

    lemmas = (
        make_lemma("a.one", Verdict.OPEN),
        make_lemma("a.two", Verdict.PROVED, "a.one"),
        make_lemma("a.three", Verdict.PROVED),
    )
    monkeypatch.setattr(book_module, "FAMILIES", {"a": ("A", lemmas)})
    assert [e.verdict for e in prove_all()] == [Verdict.OPEN, Verdict.OPEN, Verdict.PROVED]


def test_the_steps_of_a_lemma_come_before_it_in_the_book() -> None:
    before: set[str] = set()
    for name in (v.name for _, lemmas in FAMILIES.values() for v in lemmas):
        assert set(lemma(name).steps) <= before
        before.add(name)


def test_the_sampled_statements_have_the_first_exit_as_a_step() -> None:
    for name in ("sharp", "diagonal", "general"):
        assert lemma(f"sampled.{name}").steps[0] == "sampled.first_exit"
        assert f"sampled.{name}" in lemma(f"sampled.{name}_evaluated").steps


@pytest.mark.parametrize(
    ("module", "name", "wrong", "kernel", "make_kernel"),
    [
        (reach_tube, "sigma", wrong_sigma, "profile", reach_tube.profile),
        (adaptive_tube, "equation", wrong_equation, "update_rate", adaptive_tube.update_rate),
        (circumvent, "bump", wrong_bump, "circumvent", circumvent.circumvent),
        (adaptive_tube, "smooth_max", wrong_max, "lower_edge", adaptive_tube.lower_edge),
        (adaptive_tube, "smooth_max", wrong_max, "lower_edge_rate", lambda: adaptive_tube.lower_edge(True)),
        (adaptive_tube, "newton", wrong_newton, "newton", lambda: wrong_newton()),
        (adaptive_tube, "MINIMUM_GAP", 2.0**-20, "update_rate", adaptive_tube.update_rate),
    ],
)
def test_a_wrong_kernel_of_the_adaptive_tube_leaves_its_lemma_open(
    module: Any, name: str, wrong: Any, kernel: str, make_kernel: Callable[[], ca.Function], monkeypatch: Any
) -> None:
    shipped = dict(printed_kernels.shipped())  # copied before the change, so that only one kernel is wrong
    assert lemma(f"kernels.{kernel}").run().verdict is Verdict.PROVED
    monkeypatch.setattr(module, name, wrong)
    shipped[kernel] = lower(make_kernel())
    monkeypatch.setattr(printed_kernels, "shipped", lambda: shipped)
    assert lemma(f"kernels.{kernel}").run().verdict is Verdict.OPEN


def with_function(case: str, function: str, change: Callable[[Any], Any]) -> dict[str, Any]:
    """Return the examples, with `change` applied to every statement of one function of one case."""

    def changed_body(statements: Any) -> Any:
        return tuple(
            replace(changed, body=changed_body(changed.body)) if isinstance(changed, For | Return) else changed
            for changed in map(change, statements)
        )

    example = examples.cases()[case]
    changed_functions = tuple(
        replace(f, body=changed_body(f.body)) if f.name == function else f for f in example.program.functions
    )
    return {**examples.cases(), case: replace(example, program=replace(example.program, functions=changed_functions))}


def never_outside(statement: Any) -> Any:
    """Make the status OK outside the tube."""
    is_target = isinstance(statement, Assign) and statement.var.name == "outside_next" and isinstance(statement.value, Select)
    return replace(statement, value=replace(statement.value, otherwise=statement.value.then)) if is_target else statement


def with_the_first_limit(statement: Any) -> Any:
    """Saturate every component at the first one's limit."""
    is_target = isinstance(statement, Assign) and statement.value == Load("u_max", Var("i", INT))
    return replace(statement, value=Load("u_max", integer(0))) if is_target else statement


def with_a_lower_coefficient(statement: Any) -> Any:
    """Compute the upper edge from the coefficients of the lower edge."""
    is_target = isinstance(statement, Call) and statement.results[0].name == "upper_edge"
    return replace(statement, args=(Var("lower_at", INT), *statement.args[1:])) if is_target else statement


def without_step_clamp(statement: Any) -> Any:
    """Let the implicit step ignore the upper bound on dt."""
    is_target = isinstance(statement, Assign) and statement.var.name == "h"
    return replace(statement, value=statement.value.then) if is_target else statement


def with_alpha_of_the_lower_edge(statement: Any) -> Any:
    """Use alpha of the lower edge in the place of that of the upper edge."""
    is_target = isinstance(statement, Assign) and statement.var.name == "alpha_high_in"
    return replace(statement, value=Load("alpha", Var("i", INT))) if is_target else statement


def with_threshold(name: str, k: int, value: Fraction) -> Callable[[Any], Any]:
    """Return a change that replaces argument k of the comparison of that name by another constant."""

    def change(statement: Any) -> Any:
        if not (isinstance(statement, Assign) and statement.var.name == name):
            return statement
        assert isinstance(statement.value, Op)
        return replace(
            statement,
            value=Op(statement.value.name, tuple(real(value) if i == k else a for i, a in enumerate(statement.value.args))),
        )

    return change


def test_a_branch_that_no_point_takes_leaves_its_lemma_open(monkeypatch: Any) -> None:
    """For 7.00 < t < 7.05 the gain has the other sign; none of the times at which the lemma follows the program lies there."""
    t = Var("t", REAL)

    def change(s: Any) -> Any:
        return replace(s, value=Select(Var("there", BOOL), s.value.otherwise, s.value.then)) if _is_gain(s) else s

    def _is_gain(s: Any) -> bool:
        return isinstance(s, Assign) and s.var.name == "gain" and isinstance(s.value, Select)

    wrong = with_function("limited", "control", change)["limited"]
    condition = (
        Assign(Var("after", BOOL), Op("lt", (real(Fraction(7)), t))),
        Assign(Var("before", BOOL), Op("lt", (t, real(Fraction("7.05"))))),
        Assign(Var("there", BOOL), Op("and", (Var("after", BOOL), Var("before", BOOL)))),
    )
    (control,) = (f for f in wrong.program.functions if f.name == "control")
    wrong_control = replace(control, body=(*condition, *control.body))
    program = replace(
        wrong.program, functions=tuple(wrong_control if f.name == "control" else f for f in wrong.program.functions)
    )
    assert not any(7 < time < 7.05 for time in functions.TIMES)
    monkeypatch.setattr(functions, "cases", lambda: {**examples.cases(), "limited": replace(wrong, program=program)})
    outcome = lemma("functions.control_limited").run()
    assert outcome.verdict is Verdict.OPEN
    assert "lt 7 t is no comparison of the frame" in outcome.evidence


@pytest.mark.parametrize(
    ("name", "function", "change"),
    [
        ("tube_rate", "tube_rate", with_threshold("moving", 1, Fraction("8.95"))),
        ("control_limited", "control", with_threshold("inside", 0, Fraction("0.0001"))),
        ("transform", "transform", with_threshold("wide", 0, Fraction(1, 1 << 10))),
        ("transform", "transform", with_threshold("filled", 0, Fraction(1, 1 << 23))),
        ("control_limited", "control", never_outside),
        ("control_limited", "control", with_the_first_limit),
        ("tube", "tube", with_a_lower_coefficient),
        ("margin", "margin", with_a_lower_coefficient),
        ("alpha_step", "alpha_step", without_step_clamp),
        ("adaptive_tube", "tube", with_alpha_of_the_lower_edge),
        ("adaptive_control", "control", never_outside),
    ],
)
def test_a_wrong_frame_leaves_its_lemma_open(name: str, function: str, change: Callable[[Any], Any], monkeypatch: Any) -> None:
    case = functions.SUBJECTS[name][0]
    wrong = with_function(case, function, change)
    assert wrong[case].program != examples.cases()[case].program
    monkeypatch.setattr(functions, "cases", lambda: wrong)
    assert lemma(f"functions.{name}").run().verdict is Verdict.OPEN


@pytest.mark.parametrize("name", ["limited", "unlimited", "adaptive"])
def test_a_followed_function_gives_what_the_emitted_python_gives(name: str) -> None:
    """Following a function at a point computes the same numbers as the printed Python, to the last bit."""
    case = examples.cases()[name]
    # The emitted function `_vector` also checks lengths.
    module: dict[str, Any] = {"_vector": lambda _, values, length: [float(v) for v in values]}
    printer = PythonPrinter(case.program)
    module |= {status.name: status.value for status in Status}
    parts = [*map(printer.table, case.program.tables), *map(printer.kernel, case.program.kernels)]
    parts += map(printer.function, case.program.functions)
    exec("\n".join(["import math", *(line for part in parts for line in part)]), module)
    for lemma_name, (kind, function, points) in functions.SUBJECTS.items():
        if kind != name or function in ("alpha_init", "control_tick"):
            continue
        for point in list(points(case))[::7]:
            path = follow(case.program, function, point)
            emitted = module[function](**point)
            followed = (
                [path.result, *path.outputs.values()] if path.result is not None and path.outputs else list(path.outputs.values())
            )
            followed = followed or [path.result]
            flat_results = _flat(emitted), _flat(followed)
            assert repr(flat_results[0]) == repr(flat_results[1]), (lemma_name, point)


def _flat(value: Any) -> list[Any]:
    """Return nested lists of results as one list."""
    if isinstance(value, list | tuple):
        return [w for v in value for w in _flat(v)]
    return [value.value if isinstance(value, Status) else value]


# ---- the methods of proof


x = sp.Symbol("x", real=True)


@pytest.mark.parametrize("wrong", [x, x**2 - x, sp.exp(x) - 1 - x, sp.tanh(x) - x, sp.Rational(1, 10**12)])
def test_a_difference_that_is_not_zero_is_no_identity(wrong: Any) -> None:
    outcome = prove_identities({"right": x - x, "wrong": wrong})
    assert outcome.verdict is Verdict.OPEN
    assert outcome.evidence[0].startswith("wrong: ")


def test_an_inequality_is_proved_refuted_or_left_open_but_never_wrongly_proved() -> None:
    def touching(v: arb) -> arb:
        return (v - arb(1) / 3) ** 2

    assert prove_above("x^2 + 1/1000", lambda v: v**2 + arb("0.001"), [(-1.0, 1.0)]).verdict is Verdict.PROVED
    assert prove_above("x^2 - 1/1000", lambda v: v**2 - arb("0.001"), [(-1.0, 1.0)]).verdict is Verdict.REFUTED
    assert prove_above("(x - 1/3)^2, which is 0 somewhere", touching, [(0.0, 1.0)]).verdict is Verdict.OPEN
    assert prove_above("1/x over a pole", lambda v: 1 / v, [(-1.0, 1.0)]).verdict is not Verdict.PROVED
    assert (
        prove_above("x y - 1/2 on the unit square", lambda v, w: v * w - arb("0.5"), [(0.0, 1.0), (0.0, 1.0)]).verdict
        is Verdict.REFUTED
    )


def test_no_evidence_is_no_proof() -> None:
    for nothing in (lambda: prove_identities({}), lambda: all_of(), lambda: prove_positive({})):
        assert Lemma("a.b", "", "", (), "", nothing).run().verdict is Verdict.OPEN


def test_an_equation_for_positive_numbers_only_is_no_identity() -> None:
    """An expansion of logarithms without that assumption would turn log x^2 into 2 log x."""
    assert prove_identities({"log x^2 - 2 log x": sp.log(x**2) - 2 * sp.log(x)}).verdict is Verdict.OPEN
    y = sp.Symbol("y", positive=True)
    assert prove_identities({"log y^2 - 2 log y": sp.log(y**2) - 2 * sp.log(y)}).verdict is Verdict.PROVED


def test_a_sign_is_proved_only_if_it_holds_for_all_values() -> None:
    y = sp.Symbol("y", positive=True)
    assert prove_positive({"y + sinh y": y + sp.sinh(y)}).verdict is Verdict.PROVED
    for unknown in (x, x**2, y - 1, sp.cosh(y) - 2):
        assert prove_positive({"good": y, "bad": unknown}).verdict is Verdict.OPEN


def test_all_of_has_the_verdict_of_its_worst_part() -> None:
    good, bad = (Outcome(v, "m", ("e",)) for v in (Verdict.PROVED, Verdict.OPEN))
    assert all_of(good, good).verdict is Verdict.PROVED
    assert all_of(good, bad) is bad


def test_a_proof_that_fails_is_open_with_its_message() -> None:
    def broken() -> Outcome:
        raise ZeroDivisionError("no such number")

    outcome = Lemma("a.b", "", "", (), "", broken).run()
    assert outcome.verdict is Verdict.OPEN
    assert "no such number" in outcome.evidence[0]


def test_the_cache_is_used_until_a_source_changes(tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    few_families = {name: FAMILIES[name] for name in ("reach", "bumps", "refined")}  # any families would do
    monkeypatch.setattr(book_module, "FAMILIES", few_families)
    count = sum(len(lemmas) for _, lemmas in few_families.values())
    assert CliRunner().invoke(app, ["prove", "--out", str(tmp_path / "a.md")]).exit_code == 0
    cache_file = tmp_path / "stt_codegen" / "lemmas.json"
    document = json.loads(cache_file.read_bytes())
    assert len(document["outcomes"]) == count

    ran: list[str] = []
    run = Lemma.run
    monkeypatch.setattr(Lemma, "run", lambda self: ran.append(self.name) or run(self))
    assert CliRunner().invoke(app, ["prove", "--out", str(tmp_path / "b.md"), "--check"]).exit_code == 1  # b.md does not exist
    assert not ran  # nothing has changed
    assert page(prove_all(fresh=False)) == (tmp_path / "a.md").read_text()

    monkeypatch.setattr(cache_module, "key", lambda: "other sources")
    prove_all(fresh=False)
    assert len(ran) == count
    cache_file.write_text("no JSON")
    ran.clear()
    prove_all(fresh=False)
    assert len(ran) == count


def test_an_open_lemma_is_not_cached(tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    cache = cache_module.Cache(fresh=True)
    cache.put("a.b", Outcome(Verdict.OPEN, "none", ("left",)))
    cache.put("a.c", Outcome(Verdict.PROVED, "none", ("done",)))
    cache.save()
    reloaded = cache_module.Cache(fresh=False)
    assert reloaded.get("a.b") is None
    assert reloaded.get("a.c") == Outcome(Verdict.PROVED, "none", ("done",))


def test_the_key_of_the_cache_depends_on_every_source_file(monkeypatch: Any) -> None:
    before = cache_module.key()
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda self: read(self) + (b" " if self.name == "reach_tube.py" else b""))
    assert cache_module.key() != before


def assert_latex_is_well_formed_and_complete(entries: list[BookEntry]) -> None:
    """Assert that braces and environments of the LaTeX page match, and that it has every lemma."""
    text = page(entries, ".tex")
    assert text.count("{") - text.count(r"\{") == text.count("}") - text.count(r"\}")
    for environment in ("itemize", "document"):
        assert text.count(rf"\begin{{{environment}}}") == text.count(rf"\end{{{environment}}}")
    for e in entries:
        assert e.lemma.name.replace("_", r"\_") in text
        assert e.lemma.latex in text


def test_the_command_writes_compares_and_fails_on_an_open_lemma(tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    few_families = {name: FAMILIES[name] for name in ("reach", "transform")}  # another test proves the whole book
    monkeypatch.setattr(book_module, "FAMILIES", few_families)
    target = str(tmp_path / "lemmas.md")
    assert CliRunner().invoke(app, ["prove", "--out", target, "--check"]).exit_code == 1
    assert CliRunner().invoke(app, ["prove", "--out", target]).exit_code == 0
    assert CliRunner().invoke(app, ["prove", "--out", target, "--check"]).exit_code == 0
    monkeypatch.setattr(control_law, "law", wrong_law)
    result = CliRunner().invoke(app, ["prove", "--out", target, "--check", "--fresh"])
    assert result.exit_code == 1
    assert "open: transform.law_shipped" in result.stdout
