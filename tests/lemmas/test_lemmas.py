"""The lemma book: nothing open, refuted what must be, and no wrong statement or wrong kernel proved."""

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

from stt_codegen import constraints as rows
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
from stt_codegen.lemmas.sampling import definite_plants, first_exit, sampled, sampled_windows
from stt_codegen.paper import adaptive_tube, circumvent, control_law, reach_tube, refined_tube, smooth
from stt_codegen.plants import Plant
from stt_codegen.program.analyse import exact_logarithm as enclosed
from stt_codegen.program.convert.from_casadi import lower
from stt_codegen.program.nodes import Assign, For, Load, Op, Return, Select, Status, Var, integer, real
from stt_codegen.program.operations import BOOL, INT, REAL
from stt_codegen.program.symbolic.paths import follow
from stt_codegen.program.targets.python.printer import PythonPrinter
from stt_codegen.sampling import periods, sampled_loop, sampling_conditions, windows
from stt_codegen.sampling.numbers import Fractions
from stt_codegen.sampling.sampled_loop import SampledLoop, first_order_loop
from stt_codegen.sampling.windows import extremes
from stt_codegen.task.sets.convex_sets import BoxSet
from stt_codegen.task.sets.motion import Leg
from tests.support.controllers import ROOT

REFUTED = {
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
    return next(v for _, lemmas in FAMILIES.values() for v in lemmas if v.name == name)


def test_nothing_is_open_only_what_must_be_is_refuted_and_the_pages_say_so() -> None:
    """One test, for the whole book is proved once only within one: a minute and a half."""
    entries = prove_all()
    assert {e.lemma.name for e in entries if e.verdict is Verdict.REFUTED} == REFUTED
    assert not [(e.lemma.name, e.outcome.evidence) for e in entries if e.verdict is Verdict.OPEN]
    assert all(e.outcome.evidence for e in entries)
    assert (ROOT / "generated" / "lemmas.md").read_text() == page(entries)
    the_book_in_latex_is_well_formed_and_complete(entries)


def test_names_belong_to_their_family_and_are_used_once() -> None:
    names = [(family, v.name) for family, (_, lemmas) in FAMILIES.items() for v in lemmas]
    assert all(name.split(".")[0] == family for family, name in names)
    assert len({name for _, name in names}) == len(names)


# ---- sabotage: the kernel that is printed made wrong, one family after the other


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


WRONG = SimpleNamespace(  # what is bent below is bent from these
    rows=rows.separation_constraints,
    of=update_module.Curve.of,
    beyond=update_module.Curve.beyond,
    cell=update_module.Curve.cell,
)
upside_down = Plant(name="wrong", dimension=None, drift=lambda x: [0] * x.shape[0], input_matrix=lambda x: -ca.diag(1 + x**2))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("module", "name", "wrong", "falls"),
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
        (rows, "initial_state_constraints", lambda task: rows.start_constraints(task), "rows.plain"),
        (rows, "separation_constraints", lambda convex, clearance: WRONG.rows(convex, Fraction(0)), "rows.apart"),
        (rows.Constraint, "bound_from", lambda row, origin: row.bound, "rows.moved"),
        (BoxSet, "support", lambda box, normal: Fraction(0), "rows.support"),
        (
            sampled_windows,
            "extremes",
            lambda design: extremes(replace(design, unit=1, coefficients=design.coefficients[::-1])),
            "sampled.windows",
        ),
        (windows, "OUT", -(2.0**-40), "sampled.windows"),
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
            classmethod(lambda cls, *rest: replace(WRONG.of(*rest), speed_factor=rest[1])),
            "update.rounded",
        ),
        (update_module.Curve, "beyond", lambda self, z, p, q: WRONG.beyond(self, z, p, q + q), "update.root"),
        (update_module.Curve, "cell", lambda self, *rest: WRONG.cell(self, *rest)[:1] * 3, "update.falls"),
        (update_module.Curve, "balance", lambda self, psi, theta: self.root(psi, theta), "update.rises"),
        (update_module.Curve, "outer", lambda self, a, b: a, "update.promise"),
        (logarithm, "C", Fraction(2, 3), "transform.logarithm"),
        (theorem_4_1, "E", 2 * theorem_4_1.E, "theorem.edot"),  # no kernel of its own: the definition itself made wrong
    ],
)
def test_a_wrong_kernel_leaves_its_lemma_open(
    module: Any, name: str, wrong: Callable[..., Any], falls: str, monkeypatch: Any
) -> None:
    assert lemma(falls).run().verdict is Verdict.PROVED
    monkeypatch.setattr(module, name, wrong)
    outcome = lemma(falls).run()
    assert outcome.verdict is not Verdict.PROVED  # open, or refuted where a point says so
    assert outcome.evidence
    assert outcome.method != "none"  # by what was found, not because something cannot be run


def test_a_lemma_is_open_where_a_step_of_its_argument_is() -> None:
    good = lemma("sampled.sharp")
    proved, verdicts = good.run(), dict.fromkeys(good.steps, Verdict.PROVED)
    assert with_steps(good, proved, verdicts) == proved
    for name in good.steps:
        for wrong in ({**verdicts, name: Verdict.OPEN}, {k: v for k, v in verdicts.items() if k != name}):
            outcome = with_steps(good, proved, wrong)
            assert outcome.verdict is Verdict.OPEN
            assert name in outcome.evidence[0]
    refuted = Outcome(Verdict.REFUTED, "counterexample", ("at 0",))
    assert with_steps(good, refuted, {}) == refuted


def test_the_book_asks_for_the_steps(monkeypatch: Any, tmp_path: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))

    def made(name: str, verdict: Verdict, *steps: str) -> Lemma:
        return Lemma(name, "", "", (), "ours", lambda: Outcome(verdict, "by hand", ("said",)), steps)

    two = (made("a.one", Verdict.OPEN), made("a.two", Verdict.PROVED, "a.one"), made("a.three", Verdict.PROVED))
    monkeypatch.setattr(book_module, "FAMILIES", {"a": ("A", two)})
    assert [e.verdict for e in prove_all()] == [Verdict.OPEN, Verdict.OPEN, Verdict.PROVED]


def test_steps_are_lemmas_that_stand_before_what_names_them() -> None:
    before: set[str] = set()
    for name in (v.name for _, lemmas in FAMILIES.values() for v in lemmas):
        assert set(lemma(name).steps) <= before
        before.add(name)


def test_the_sampled_statements_go_through_a_first_exit() -> None:
    for name in ("sharp", "diagonal", "general"):
        assert lemma(f"sampled.{name}").steps[0] == "sampled.first_exit"
        assert f"sampled.{name}" in lemma(f"sampled.{name}_evaluated").steps


@pytest.mark.parametrize(
    ("module", "name", "wrong", "kernel", "made"),
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
    module: Any, name: str, wrong: Any, kernel: str, made: Callable[[], ca.Function], monkeypatch: Any
) -> None:
    shipped = dict(printed_kernels.shipped())  # kept from now on: it must not be made of the wrong ones
    assert lemma(f"kernels.{kernel}").run().verdict is Verdict.PROVED
    monkeypatch.setattr(module, name, wrong)
    shipped[kernel] = lower(made())
    monkeypatch.setattr(printed_kernels, "shipped", lambda: shipped)
    assert lemma(f"kernels.{kernel}").run().verdict is Verdict.OPEN


def with_function(case: str, function: str, change: Callable[[Any], Any]) -> dict[str, Any]:
    """The examples with every statement of one function replaced where `change` does so."""

    def body(statements: Any) -> Any:
        return tuple(
            replace(changed, body=body(changed.body)) if isinstance(changed, For | Return) else changed
            for changed in map(change, statements)
        )

    example = examples.cases()[case]
    functions_ = tuple(replace(f, body=body(f.body)) if f.name == function else f for f in example.program.functions)
    return {**examples.cases(), case: replace(example, program=replace(example.program, functions=functions_))}


def not_outside(s: Any) -> Any:
    """The status says OK outside the tube."""
    wrong = isinstance(s, Assign) and s.var.name == "outside_any" and isinstance(s.value, Select)
    return replace(s, value=replace(s.value, otherwise=s.value.then)) if wrong else s


def first_limit(s: Any) -> Any:
    """Every component is saturated at the first one's limit."""
    wrong = isinstance(s, Assign) and s.value == Load("u_max", Var("i", INT))
    return replace(s, value=Load("u_max", integer(0))) if wrong else s


def other_entry(s: Any) -> Any:
    """The upper edge is made of a lower edge's last entry."""
    wrong = isinstance(s, Assign) and s.var.name == "upper_q3"
    return replace(s, value=Load("coefficients", Var("lower_3", INT))) if wrong else s


def no_step(s: Any) -> Any:
    """The implicit step ignores dt's upper bound."""
    wrong = isinstance(s, Assign) and s.var.name == "h"
    return replace(s, value=s.value.then) if wrong else s


def swapped_alpha(s: Any) -> Any:
    """alpha_L in the place of alpha_U."""
    wrong = isinstance(s, Assign) and s.var.name == "alpha_high_in"
    return replace(s, value=Load("alpha", Var("i", INT))) if wrong else s


def threshold(name: str, k: int, value: Fraction) -> Callable[[Any], Any]:
    """Argument k of the comparison of that name becomes another constant."""

    def change(s: Any) -> Any:
        if not (isinstance(s, Assign) and s.var.name == name):
            return s
        assert isinstance(s.value, Op)
        return replace(s, value=Op(s.value.name, tuple(real(value) if i == k else a for i, a in enumerate(s.value.args))))

    return change


def test_a_branch_that_no_point_takes_leaves_its_lemma_open(monkeypatch: Any) -> None:
    """For 7.00 < t < 7.05 the gain has the other sign; no time that is looked at lies there."""
    t = Var("t", REAL)

    def change(s: Any) -> Any:
        return replace(s, value=Select(Var("there", BOOL), s.value.otherwise, s.value.then)) if _is_gain(s) else s

    def _is_gain(s: Any) -> bool:
        return isinstance(s, Assign) and s.var.name == "gain" and isinstance(s.value, Select)

    wrong = with_function("wide", "control", change)["wide"]
    asked = (
        Assign(Var("after", BOOL), Op("lt", (real(Fraction(7)), t))),
        Assign(Var("before", BOOL), Op("lt", (t, real(Fraction("7.05"))))),
        Assign(Var("there", BOOL), Op("and", (Var("after", BOOL), Var("before", BOOL)))),
    )
    (control,) = (f for f in wrong.program.functions if f.name == "control")
    bent = replace(control, body=(*asked, *control.body))
    program = replace(wrong.program, functions=tuple(bent if f.name == "control" else f for f in wrong.program.functions))
    assert not any(7 < time < 7.05 for time in functions.TIMES)
    monkeypatch.setattr(functions, "cases", lambda: {**examples.cases(), "wide": replace(wrong, program=program)})
    outcome = lemma("functions.wide_control").run()
    assert outcome.verdict is Verdict.OPEN
    assert "lt 7 t is no comparison of the frame" in outcome.evidence


@pytest.mark.parametrize(
    ("name", "function", "change"),
    [
        ("wide_tube_rate", "tube_rate", threshold("moving", 1, Fraction("8.95"))),
        ("wide_control", "control", threshold("within", 0, Fraction("0.0001"))),
        ("transform", "transform", threshold("wide", 0, Fraction(1, 1 << 10))),
        ("transform", "transform", threshold("filled", 0, Fraction(1, 1 << 23))),
        ("wide_control", "control", not_outside),
        ("wide_control", "control", first_limit),
        ("narrow_tube", "tube", other_entry),
        ("narrow_margin", "margin", other_entry),
        ("alpha_step", "alpha_step", no_step),
        ("adaptive_tube", "tube", swapped_alpha),
        ("adaptive_control", "control", not_outside),
    ],
)
def test_a_wrong_frame_leaves_its_lemma_open(name: str, function: str, change: Callable[[Any], Any], monkeypatch: Any) -> None:
    case = functions.SUBJECTS[name][0]
    wrong = with_function(case, function, change)
    assert wrong[case].program != examples.cases()[case].program
    monkeypatch.setattr(functions, "cases", lambda: wrong)
    assert lemma(f"functions.{name}").run().verdict is Verdict.OPEN


@pytest.mark.parametrize("name", ["wide", "narrow", "adaptive"])
def test_a_followed_function_gives_what_the_emitted_python_gives(name: str) -> None:
    """The numbers that decide the paths are the program's own: the walk and the printed Python agree to the last bit."""
    case = examples.cases()[name]
    names: dict[str, Any] = {"_vector": lambda _, values, length: [float(v) for v in values]}  # the module's own checks lengths
    printer = PythonPrinter(case.program)
    names |= {status.name: status.value for status in Status}
    parts = [*map(printer.table, case.program.tables), *map(printer.kernel, case.program.kernels)]
    parts += map(printer.function, case.program.functions)
    exec("\n".join(["import math", *(line for part in parts for line in part)]), names)
    for lemma_name, (kind, function, points) in functions.SUBJECTS.items():
        if kind != name or function in ("alpha_init", "control_tick"):
            continue
        for point in list(points(case))[::7]:
            path = follow(case.program, function, point)
            found = names[function](**point)
            wanted = (
                [path.result, *path.outputs.values()] if path.result is not None and path.outputs else list(path.outputs.values())
            )
            wanted = wanted or [path.result]
            flat = _flat(found), _flat(wanted)
            assert repr(flat[0]) == repr(flat[1]), (lemma_name, point)


def _flat(value: Any) -> list[Any]:
    if isinstance(value, list | tuple):
        return [w for v in value for w in _flat(v)]
    return [value.value if isinstance(value, Status) else value]


# ---- the methods themselves


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


def test_what_holds_for_positive_numbers_alone_is_no_identity() -> None:
    """Forced logarithms would take log x^2 for 2 log x."""
    assert prove_identities({"log x^2 - 2 log x": sp.log(x**2) - 2 * sp.log(x)}).verdict is Verdict.OPEN
    y = sp.Symbol("y", positive=True)
    assert prove_identities({"log y^2 - 2 log y": sp.log(y**2) - 2 * sp.log(y)}).verdict is Verdict.PROVED


def test_a_sign_is_for_all_values() -> None:
    y = sp.Symbol("y", positive=True)
    assert prove_positive({"y + sinh y": y + sp.sinh(y)}).verdict is Verdict.PROVED
    for unknown in (x, x**2, y - 1, sp.cosh(y) - 2):
        assert prove_positive({"good": y, "bad": unknown}).verdict is Verdict.OPEN


def test_all_of_is_as_good_as_its_worst() -> None:
    good, bad = (Outcome(v, "m", ("e",)) for v in (Verdict.PROVED, Verdict.OPEN))
    assert all_of(good, good).verdict is Verdict.PROVED
    assert all_of(good, bad) is bad


def test_a_proof_that_fails_is_open_with_its_message() -> None:
    def broken() -> Outcome:
        raise ZeroDivisionError("no such number")

    outcome = Lemma("a.b", "", "", (), "", broken).run()
    assert outcome.verdict is Verdict.OPEN
    assert "no such number" in outcome.evidence[0]


def test_the_cache_is_quick_and_is_never_believed_after_a_change(tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    few = {name: FAMILIES[name] for name in ("reach", "bumps", "refined")}  # of a cache it matters not which
    monkeypatch.setattr(book_module, "FAMILIES", few)
    count = sum(len(lemmas) for _, lemmas in few.values())
    assert CliRunner().invoke(app, ["prove", "--out", str(tmp_path / "a.md")]).exit_code == 0
    kept = tmp_path / "stt_codegen" / "lemmas.json"
    document = json.loads(kept.read_bytes())
    assert len(document["outcomes"]) == count

    ran: list[str] = []
    run = Lemma.run
    monkeypatch.setattr(Lemma, "run", lambda self: ran.append(self.name) or run(self))
    assert CliRunner().invoke(app, ["prove", "--out", str(tmp_path / "b.md"), "--check"]).exit_code == 1  # b.md is not there
    assert not ran  # nothing has changed
    assert page(prove_all(fresh=False)) == (tmp_path / "a.md").read_text()

    monkeypatch.setattr(cache_module, "key", lambda: "other sources")
    prove_all(fresh=False)
    assert len(ran) == count
    kept.write_text("no JSON")
    ran.clear()
    prove_all(fresh=False)
    assert len(ran) == count


def test_an_open_lemma_is_not_kept(tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    cache_ = cache_module.Cache(fresh=True)
    cache_.put("a.b", Outcome(Verdict.OPEN, "none", ("left",)))
    cache_.put("a.c", Outcome(Verdict.PROVED, "none", ("done",)))
    cache_.save()
    again = cache_module.Cache(fresh=False)
    assert again.get("a.b") is None
    assert again.get("a.c") == Outcome(Verdict.PROVED, "none", ("done",))


def test_the_key_follows_every_source_file(monkeypatch: Any) -> None:
    before = cache_module.key()
    read = Path.read_bytes
    monkeypatch.setattr(Path, "read_bytes", lambda self: read(self) + (b" " if self.name == "reach_tube.py" else b""))
    assert cache_module.key() != before


def the_book_in_latex_is_well_formed_and_complete(entries: list[BookEntry]) -> None:
    text = page(entries, ".tex")
    assert text.count("{") - text.count(r"\{") == text.count("}") - text.count(r"\}")
    for environment in ("itemize", "document"):
        assert text.count(rf"\begin{{{environment}}}") == text.count(rf"\end{{{environment}}}")
    for e in entries:
        assert e.lemma.name.replace("_", r"\_") in text
        assert e.lemma.latex in text


def test_the_command_writes_compares_and_fails_on_an_open_lemma(tmp_path: Any, monkeypatch: Any) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    few = {name: FAMILIES[name] for name in ("reach", "transform")}  # the whole book is proved above
    monkeypatch.setattr(book_module, "FAMILIES", few)
    target = str(tmp_path / "lemmas.md")
    assert CliRunner().invoke(app, ["prove", "--out", target, "--check"]).exit_code == 1
    assert CliRunner().invoke(app, ["prove", "--out", target]).exit_code == 0
    assert CliRunner().invoke(app, ["prove", "--out", target, "--check"]).exit_code == 0
    monkeypatch.setattr(control_law, "law", wrong_law)
    result = CliRunner().invoke(app, ["prove", "--out", target, "--check", "--fresh"])
    assert result.exit_code == 1
    assert "open: transform.law_shipped" in result.stdout
