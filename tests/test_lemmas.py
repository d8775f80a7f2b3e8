"""The lemma book: nothing open, refuted what must be, and no wrong statement or wrong kernel proved."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import pytest
import sympy as sp
from conftest import ROOT
from flint import arb
from typer.testing import CliRunner

from stt_codegen.cli import app
from stt_codegen.lemmas import theorem
from stt_codegen.lemmas.book import FAMILIES, page, prove_all
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict, all_of, identity, positive
from stt_codegen.paper import adaptive_tube, circumvent, control_law, reach_tube, refined_tube, smooth

REFUTED = {
    "smooth.plain_max",
    "smooth.printed_float",
    "reach.printed",
    "transform.outer_product",
    "transform.outer_jacobian",
    "update.inverted_start",
    "bumps.printed_window",
    "theorem.rayleigh",
}


def lemma(name: str) -> Lemma:
    return next(v for _, lemmas in FAMILIES.values() for v in lemmas if v.name == name)


def test_nothing_is_open_and_only_what_must_be_is_refuted() -> None:
    entries = prove_all()
    assert {e.lemma.name for e in entries if e.verdict is Verdict.REFUTED} == REFUTED
    assert not [(e.lemma.name, e.outcome.evidence) for e in entries if e.verdict is Verdict.OPEN]
    assert all(e.outcome.evidence for e in entries)


def test_names_belong_to_their_family_and_are_used_once() -> None:
    names = [(family, v.name) for family, (_, lemmas) in FAMILIES.items() for v in lemmas]
    assert all(name.split(".")[0] == family for family, name in names)
    assert len({name for _, name in names}) == len(names)


def test_the_committed_page_is_what_the_book_says() -> None:
    assert (ROOT / "generated" / "lemmas.md").read_text() == page(prove_all())


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


def wrong_equation(*s: ca.SX) -> ca.SX:
    psi, alpha, theta0, kappa, mu, varsigma = s
    return adaptive_tube.trigger(psi, theta0, mu, varsigma) / (psi + alpha) - kappa * alpha


def wrong_newton() -> ca.Function:
    p, q, z = (ca.SX.sym(v) for v in ("p", "q", "z"))
    f = (z - p) * z * z - q
    return ca.Function("newton", [p, q, z], [z - f / (3 * z * z - p * z)], ["p", "q", "z"], ["next"])


def wrong_bump(t: ca.SX, height: ca.SX, steepness: ca.SX, middle: ca.SX, radius: ca.SX, cut: ca.SX) -> ca.SX:
    d = t - middle
    return height * ca.exp(-steepness * d * d / ca.fmax(radius * radius + d * d, cut))


@pytest.mark.parametrize(
    ("module", "name", "wrong", "falls"),
    [
        (control_law, "law", wrong_law, "transform.law_shipped"),
        (control_law, "transformed_error", wrong_transform, "transform.xi_shipped"),
        (control_law, "transformed_error", wrong_transform, "transform.odd"),
        (refined_tube, "weights", wrong_weights, "refined.weights_shipped"),
        (refined_tube, "weights", wrong_weights, "refined.bezier"),
        (reach_tube, "reach_edge", wrong_edge, "reach.hull"),
        (reach_tube, "sigma", wrong_sigma, "reach.shipped"),
        (circumvent, "join", wrong_join, "smooth.join_shipped"),
        (smooth, "smooth_max", wrong_max, "smooth.form"),
        (adaptive_tube, "equation", wrong_equation, "update.rate_shipped"),
        (adaptive_tube, "newton", wrong_newton, "update.newton_shipped"),
        (circumvent, "bump", wrong_bump, "bumps.shipped"),
        (theorem, "E", 2 * theorem.E, "theorem.edot"),  # no kernel of its own: the definition itself made wrong
    ],
)
def test_a_wrong_kernel_leaves_its_lemma_open(
    module: Any, name: str, wrong: Callable[..., Any], falls: str, monkeypatch: Any
) -> None:
    assert lemma(falls).run().verdict is Verdict.PROVED
    monkeypatch.setattr(module, name, wrong)
    outcome = lemma(falls).run()
    assert outcome.verdict is Verdict.OPEN
    assert outcome.evidence


# ---- the methods themselves


x = sp.Symbol("x", real=True)


@pytest.mark.parametrize("wrong", [x, x**2 - x, sp.exp(x) - 1 - x, sp.tanh(x) - x, sp.Rational(1, 10**12)])
def test_a_difference_that_is_not_zero_is_no_identity(wrong: Any) -> None:
    outcome = identity({"right": x - x, "wrong": wrong})
    assert outcome.verdict is Verdict.OPEN
    assert outcome.evidence[0].startswith("wrong: ")


def test_an_inequality_is_proved_refuted_or_left_open_but_never_wrongly_proved() -> None:
    def touching(v: arb) -> arb:
        return (v - arb(1) / 3) ** 2

    assert positive("x^2 + 1/1000", lambda v: v**2 + arb("0.001"), [(-1.0, 1.0)]).verdict is Verdict.PROVED
    assert positive("x^2 - 1/1000", lambda v: v**2 - arb("0.001"), [(-1.0, 1.0)]).verdict is Verdict.REFUTED
    assert positive("(x - 1/3)^2, which is 0 somewhere", touching, [(0.0, 1.0)]).verdict is Verdict.OPEN
    assert positive("1/x over a pole", lambda v: 1 / v, [(-1.0, 1.0)]).verdict is not Verdict.PROVED
    assert (
        positive("x y - 1/2 on the unit square", lambda v, w: v * w - arb("0.5"), [(0.0, 1.0), (0.0, 1.0)]).verdict
        is Verdict.REFUTED
    )


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


def test_the_command_writes_compares_and_fails_on_an_open_lemma(tmp_path: Any, monkeypatch: Any) -> None:
    target = str(tmp_path / "lemmas.md")
    assert CliRunner().invoke(app, ["prove", "--out", target, "--check"]).exit_code == 1
    assert CliRunner().invoke(app, ["prove", "--out", target]).exit_code == 0
    assert CliRunner().invoke(app, ["prove", "--out", target, "--check"]).exit_code == 0
    monkeypatch.setattr(control_law, "law", wrong_law)
    result = CliRunner().invoke(app, ["prove", "--out", target, "--check"])
    assert result.exit_code == 1
    assert "open: transform.law_shipped" in result.stdout
