"""The update function (11): never negative, psi + alpha bounded away from 0, and the implicit step that is emitted."""

from __future__ import annotations

from typing import Any

import sympy as sp
from flint import arb

from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict, all_of, counterexample, identity, positive
from stt_codegen.paper import adaptive_tube
from stt_codegen.program.lower import lower
from stt_codegen.program.symbols import branches

psi = sp.Symbol("psi", real=True)
alpha, theta0, kappa, varsigma, h, p_, q, z = sp.symbols("alpha theta0 kappa varsigma h p q z", positive=True)
mu = sp.Symbol("mu", real=True)
GIVEN = {"psi": psi, "alpha": alpha, "theta0": theta0, "kappa": kappa, "mu": mu, "varsigma": varsigma}
AWAY = {psi: 1, alpha: 1, theta0: 1, kappa: 5, mu: sp.Rational(1, 2), varsigma: 20}  # from every guard
THETA = theta0 * (1 - sp.tanh(varsigma * (psi - mu)))


def _same(kernel_name: str, wanted: dict[int, Any], given: dict[str, Any], at: dict[Any, Any]) -> Outcome:
    """On the branch of a kernel that is taken at these numbers, away from its guards, the outputs are the wanted formulas."""
    kernel = lower(getattr(adaptive_tube, kernel_name)())
    left: dict[str, Any] = {"no branch is taken": at}
    for branch in branches(kernel, given):
        if not branch.taken_at(at):
            continue
        left = {
            f"{kernel.output_names[k]} where {', '.join(map(str, branch.conditions)) or 'always'}": sp.simplify(
                (branch.outputs[k] - want).rewrite(sp.exp)
            )
            for k, want in wanted.items()
        }
        if all(rest == 0 for rest in left.values()):
            return identity(left, "SymPy: the kernel's branch away from its guards")
    return Outcome(Verdict.OPEN, "SymPy", tuple(f"{k}: {v}" for k, v in left.items()))


def _rate() -> Outcome:
    rate = THETA / (psi + alpha) ** 2 - kappa * alpha
    return _same("update_rate", {0: rate, 1: sp.diff(rate, alpha)}, GIVEN, AWAY)


def _jacobian() -> Outcome:
    rate = THETA / (psi + alpha) ** 2 - kappa * alpha
    claimed = -2 * THETA / (psi + alpha) ** 3 - kappa
    y = sp.Symbol("y", real=True)
    return all_of(
        identity({"d alphadot/d alpha - (-2 theta/(psi + alpha)^3 - kappa)": sp.diff(rate, alpha) - claimed}),
        identity({"theta/theta0 - 2/(1 + exp(2 y)), so theta > 0": (1 - sp.tanh(y) - 2 / (1 + sp.exp(2 * y))).rewrite(sp.exp)}),
    )


def _not_negative() -> Outcome:
    rate = (THETA / (psi + alpha) ** 2 - kappa * alpha).subs(alpha, sp.Symbol("a", real=True))
    at_zero = rate.subs(sp.Symbol("a", real=True), 0)
    return identity({"alphadot at alpha = 0 less theta/psi^2, which is above 0": at_zero - THETA / psi**2})


def _away() -> Outcome:
    """z = psi + alpha; where z = s <= mu, psi = z - alpha <= mu, so theta >= theta0, and alpha = s - psi <= s + Psi."""
    s, speed, largest = sp.symbols("s D Psi", positive=True)
    zdot = -speed + theta0 / s**2 - kappa * (s + largest)
    threshold = speed + kappa * (s + largest)
    y = sp.Symbol("y", nonnegative=True)
    return all_of(
        identity({"zdot's bound where theta0/s^2 = D + kappa (s + Psi)": zdot.subs(theta0, s**2 * threshold)}),
        identity({"theta at psi = mu, less theta0": THETA.subs(psi, mu) - theta0}),
        identity(
            {
                "theta at psi = mu - y/varsigma, less theta0 (1 + tanh y)": THETA.subs(psi, mu - y / varsigma)
                - theta0 * (1 + sp.tanh(y))
            }
        ),
        positive("tanh y", lambda v: v.tanh(), [(1e-9, 20.0)]),
    )


def _cubic() -> Outcome:
    """alpha' = alpha + h (theta/z^2 - kappa alpha') with z = psi + alpha', times z^2/(1 + h kappa)."""
    theta = sp.Symbol("theta", positive=True)
    new = z - psi
    residual = (new - alpha - h * (theta / z**2 - kappa * new)) * z**2 / (1 + h * kappa)
    cubic = (z - (psi + alpha / (1 + h * kappa))) * z**2 - h * theta / (1 + h * kappa)
    return identity({"backward Euler times z^2/(1 + h kappa) less the cubic": residual - cubic})


def _unique() -> Outcome:
    """f = (z - p) z^2 - q: -q at 0 and at z = p; rises where z > max(p, 0), since f' = z (3 z - 2 p)."""
    p = sp.Symbol("p", real=True)
    f = (z - p) * z**2 - q
    y = sp.Symbol("y", positive=True)
    return all_of(
        identity(
            {
                "f' - z (3 z - 2 p)": sp.diff(f, z) - z * (3 * z - 2 * p),
                "f at 0 plus q": f.subs(z, 0) + q,
                "f at p plus q": f.subs(z, p) + q,
            }
        ),
        identity({"3 z - 2 p at z = p + y, p > 0, less p + 3 y": (3 * z - 2 * p_).subs(z, p_ + y) - (p_ + 3 * y)}),
    )


def _newton_start() -> Outcome:
    """f is not negative at the start, and f'' > 0 from there down to the root: Newton falls monotonically to it."""
    r = sp.Symbol("r", positive=True)  # q = r^3
    m = sp.Symbol("m", positive=True)  # p = -m
    above = ((z - p_) * z**2 - r**3).subs(z, p_ + r)
    first = ((z + m) * z**2 - r**3).subs(z, r)
    second = ((z + m) * z**2 - q).subs(z, sp.sqrt(q / m))
    return all_of(
        identity({"p >= 0, z = p + r: f less r (p^2 + 2 p r)": above - r * (p_**2 + 2 * p_ * r)}),
        identity(
            {
                "p < 0, z = r: f less m r^2": first - m * r**2,
                "p < 0, z = sqrt(q/m): f less (q/m)^(3/2)": sp.simplify(second - (q / m) ** sp.Rational(3, 2)),
            }
        ),
        identity({"f'' - (6 z - 2 p)": sp.diff((z - p_) * z**2, z, 2) - (6 * z - 2 * p_)}),
    )


def _newton_shipped() -> Outcome:
    p = sp.Symbol("p", real=True)
    f = (z - p) * z**2 - q
    return _same("newton", {0: z - f / sp.diff(f, z)}, {"p": p, "q": q, "z": z}, {p: 1, q: 1, z: 2})


def _end_shipped() -> Outcome:
    rest = sp.Symbol("rest", nonnegative=True)
    return _same("implicit_end", {0: rest + q / z**2}, {"q": q, "rest": rest, "z": z}, {q: 1, rest: 1, z: 2})


def _inverted() -> Outcome:
    """psi constant -1/2, kappa = 5, theta <= 2 theta0 = 0.02: on alpha in [0, 0.1] alphadot < 0 at 0.1, so z stays below -0.4."""
    worst = arb("0.02") / (arb("-0.5") + arb("0.1")) ** 2 - 5 * arb("0.1")
    shown = f"alphadot <= {worst.str(4)} at alpha = 0.1, so alpha stays below it and psi + alpha below -0.4"
    return counterexample("psi + alpha becomes positive", "psi = -1/2, kappa = 5, theta0 = 0.01", worst < 0, shown)


LEMMAS = (
    Lemma(
        "update.rate_shipped",
        "The emitted `update_rate` is (11) and its Jacobian, where psi + alpha and the exponent are away from their guards.",
        r"\dot\alpha = \frac{\theta}{(\psi+\alpha)^2} - \kappa\alpha",
        ("psi + alpha > 2^-30", "varsigma (psi - mu) < 40"),
        "(11), Program",
        _rate,
    ),
    Lemma(
        "update.jacobian",
        "The Jacobian is -2 theta/(psi + alpha)^3 - kappa: negative, since theta is positive.",
        r"\frac{\partial\dot\alpha}{\partial\alpha} = -\frac{2\theta}{(\psi+\alpha)^3} - \kappa < 0",
        ("psi + alpha > 0",),
        "(11), ours",
        _jacobian,
    ),
    Lemma(
        "update.not_negative",
        "alpha never becomes negative: at 0 it rises.",
        r"\dot\alpha|_{\alpha=0} = \theta/\psi^2 > 0",
        ("alpha(0) = 0", "psi is not 0 where alpha is 0"),
        "(11), ours",
        _not_negative,
    ),
    Lemma(
        "update.away",
        "psi + alpha >= min(s*, psi(0), mu) with theta0/s*^2 = D + kappa (s* + Psi): where it equals s < s* it rises.",
        r"\psi+\alpha \ge \min(s^*,\psi(0),\mu),\quad \frac{\theta_0}{s^{*2}} = D + \kappa(s^*+\Psi)",
        ("psi(0) > 0", "|psidot| <= D", "|psi| <= Psi", "s* <= mu; theta0/s^2 - kappa s falls with s"),
        "in place of Lemma 3.3, ours",
        _away,
    ),
    Lemma(
        "update.cubic",
        "One implicit Euler step of (11) is the cubic (z - p) z^2 = q.",
        r"(z-p)z^2 = q,\quad p = \psi + \tfrac{\alpha}{1+h\kappa},\ q = \tfrac{h\theta}{1+h\kappa}",
        ("z = psi + alpha' > 0",),
        "ours",
        _cubic,
    ),
    Lemma(
        "update.unique",
        "The cubic has one root with z > max(p, 0).",
        r"f(z) = (z-p)z^2 - q,\quad f' = z(3z-2p) > 0 \text{ for } z > \max(p,0)",
        ("q > 0",),
        "ours",
        _unique,
    ),
    Lemma(
        "update.newton_start",
        "Newton's iterates start at or above the root and fall to it: f >= 0 at the start and f'' > 0 above the root.",
        r"f(z_0) \ge 0,\quad f'' = 6z - 2p > 0",
        ("q > 0", "z > max(p, 0), so 6 z > 2 p"),
        "ours",
        _newton_start,
    ),
    Lemma(
        "update.newton_shipped",
        "The emitted `newton` is Newton's map for the cubic, away from its guard.",
        r"z \mapsto z - f(z)/f'(z)",
        ("the iterate is above 2^-60",),
        "Program",
        _newton_shipped,
    ),
    Lemma(
        "update.end_shipped",
        "The emitted end of the step is alpha' = rest + q/z^2, which is not negative.",
        r"\alpha' = \tfrac{\alpha}{1+h\kappa} + \tfrac{q}{z^2} \ge 0",
        (),
        "Program",
        _end_shipped,
    ),
    Lemma(
        "update.inverted_start",
        "Whatever psi(0), psi + alpha becomes positive.",
        r"\exists t:\ \psi+\alpha > 0",
        ("kappa = 5, theta0 = 0.01: the case study's",),
        "(11) as printed",
        _inverted,
    ),
)
