"""Every kernel on every branch: the emitted kernels of the adaptive tube are the built formulas, guards included, and their rates
are the derivatives of their values.

A kernel is followed at points of every regime. Where it is on one branch all its outputs are one formula there; that formula is
compared with the claimed one, whose maxima, minima and absolute values are those of the point.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

import sympy as sp

from stt_codegen.controller.kernels import adaptive_parts
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict
from stt_codegen.paper.adaptive_tube import HELD, LEAST_GAP, LEAST_ROOT
from stt_codegen.paper.reach_tube import LEAST_REST
from stt_codegen.program import Kernel
from stt_codegen.program.symbolic import follow_kernel, kernel_formulas

Point = Mapping[str, Fraction]
S: dict[str, Any] = {
    name: sp.Symbol(name, real=True)
    for name in (
        "t t_c start end sigma sigma_rate height steepness middle radius cut a b da db psi alpha theta0 kappa mu varsigma h "
        "p q z rest rho beta rho_rate alpha_rate beta_rate"
    ).split()
} | {name: sp.Symbol(name, positive=True) for name in ("nu", "h", "theta0", "kappa")}


def _exact(value: float) -> Any:
    return sp.Rational(Fraction(value).numerator, Fraction(value).denominator)


@dataclass(frozen=True)
class Claim:
    """What a kernel's outputs are. `rates`: input -> its rate, for the derivative that follows the value (1 for time itself)."""

    kernel: str
    values: tuple[Any, ...]
    points: tuple[Point, ...]
    rates: Mapping[str, Any] | None = None
    written: Callable[[Point], Mapping[Any, Any]] = lambda _: {}  # inputs in others whose signs SymPy knows


def resolved(expression: Any, point: Mapping[Any, Any]) -> Any:
    """Maxima, minima and absolute values replaced by what they are at the point; of two equal ones, their mean."""

    def pick(*args: Any, largest: bool) -> Any:
        sizes = [sp.sympify(a).subs(point) for a in args]
        best = max(sizes) if largest else min(sizes)
        chosen = [a for a, size in zip(args, sizes, strict=True) if size == best]
        return sum(chosen) / len(chosen)

    def absolute(a: Any) -> Any:
        return a * sp.sign(sp.sympify(a).subs(point))

    def piece(*pairs: Any) -> Any:
        return next(value for value, holds in pairs if sp.sympify(holds).subs(point) == sp.true)

    replaced = expression.replace(sp.Piecewise, piece) if expression.has(sp.Piecewise) else expression
    replaced = replaced.replace(sp.Abs, absolute)
    replaced = replaced.replace(sp.Max, lambda *a: pick(*a, largest=True))
    return replaced.replace(sp.Min, lambda *a: pick(*a, largest=False))


def _rate(value: Any, rates: Mapping[str, Any]) -> Any:
    return sum(sp.diff(value, S[name]) * rate for name, rate in rates.items())


def check(claim: Claim, kernel: Kernel) -> Outcome:
    """Proved when on every branch that the points take the outputs are the claimed formulas."""
    seen: dict[Any, Point] = {}
    for point in claim.points:
        given = [point[v.name] for v in kernel.inputs]
        exact = {S[name]: sp.Rational(v.numerator, v.denominator) for name, v in point.items()}
        values = tuple(resolved(v, exact) for v in claim.values)
        seen.setdefault((follow_kernel(kernel, [float(v) for v in given]), values), point)
    left = []
    for (decisions, values), point in seen.items():
        symbols = [S[v.name] for v in kernel.inputs]
        exact = {S[name]: sp.Rational(v.numerator, v.denominator) for name, v in point.items()}
        wanted = list(values) + ([_rate(values[0], claim.rates)] if claim.rates is not None else [])
        if len(wanted) != len(kernel.outputs):
            return Outcome(
                Verdict.OPEN, "SymPy", (f"{claim.kernel} has {len(kernel.outputs)} outputs, {len(wanted)} are claimed",)
            )
        found = kernel_formulas(kernel, symbols, decisions)
        for name, output, want in zip(kernel.output_names, found, wanted, strict=True):
            rest = _difference(*(v.subs(claim.written(point)) for v in (resolved(sp.sympify(output), exact), sp.sympify(want))))
            if rest != 0:
                left.append(f"{name} at {_shown(point)}: {rest}")
    method = "SymPy: the kernel followed at points of every regime, its formula on each branch compared"
    if left:
        return Outcome(Verdict.OPEN, method, tuple(left))
    return Outcome(Verdict.PROVED, method, (f"{claim.kernel}: {len(seen)} branches and regimes, {len(claim.points)} points",))


def _difference(output: Any, want: Any) -> Any:
    """0 when both are the same formula."""
    difference = sp.sympify(output) - want
    for step in (sp.expand, lambda v: sp.cancel(sp.together(sp.powsimp(sp.expand(v)))), sp.simplify):
        rest = step(difference)
        if rest == 0:
            return rest
    return rest


def _shown(point: Point) -> str:
    return ", ".join(f"{name} = {float(v):g}" for name, v in point.items())


def points(**choices: Sequence[float]) -> tuple[Point, ...]:
    """Every combination of the values given for each name."""
    return tuple({name: Fraction(v) for name, v in zip(choices, values, strict=True)} for values in product(*choices.values()))


def _theta(psi: Any) -> Any:
    return 2 * S["theta0"] / (1 + sp.exp(2 * sp.Min(S["varsigma"] * (psi - S["mu"]), _exact(HELD))))


def _smooth_max(a: Any, b: Any, sign: int) -> Any:
    """The smooth maximum (sign 1) or minimum (-1)."""
    return (a + b) / 2 + sign * sp.Abs(a - b) / 2 + sign * sp.log(1 + sp.exp(-S["nu"] * sp.Abs(a - b))) / S["nu"]


def _claims() -> tuple[Claim, ...]:
    t, t_c, a, b, nu = (S[n] for n in ("t", "t_c", "a", "b", "nu"))
    s = t / sp.Max(t_c - t, _exact(LEAST_REST) * t_c)
    sigma = (1 - sp.exp(-2 * s)) / (1 + sp.exp(-2 * s))
    times = points(t=(0.0, 1.0, 8.9, 8.999, 9.0), t_c=(9.0,))
    d = t - S["middle"]
    rise = S["steepness"] * d**2
    bump = S["height"] * sp.exp(-rise / sp.Max((S["radius"] - sp.Abs(d)) * (S["radius"] + sp.Abs(d)), rise * S["cut"]))
    around = points(
        t=(1.0, 1.5, 2.0, 2.5, 2.999, 3.5, 0.5), height=(3.0,), steepness=(0.5,), middle=(2.0,), radius=(1.0,), cut=(2.0**-7,)
    )
    high = sp.Max(a, b)
    join = high + sp.log(1 + sp.exp(-nu * sp.Abs(a - b)) - sp.exp(-nu * high)) / nu
    pairs, moving = {"a": (0.0, 0.5, 2.0), "b": (0.25, 1.0)}, {"da": (0.5,), "db": (-0.25,)}
    z = sp.Max(S["psi"] + S["alpha"], _exact(LEAST_GAP))
    update = _theta(S["psi"]) / z**2 - S["kappa"] * S["alpha"]
    constants = {"theta0": (0.5,), "kappa": (5.0,), "mu": (0.25,), "varsigma": (20.0,)}
    states = points(psi=(-1.0, 0.5, 1.0, 4.0), alpha=(0.0, 0.125, 0.75), **constants)
    edges = {"rho": (0.5, 2.0), "alpha": (0.0, 0.25), "beta": (0.0, 1.0, 3.0), "nu": (20.0,)}
    rates = {"rho_rate": (0.5,), "alpha_rate": (-0.25,), "beta_rate": (1.0,)}
    lower = _smooth_max(S["rho"] - S["alpha"], S["beta"], 1)
    upper = _smooth_max(S["rho"] + S["alpha"], S["beta"], -1)
    along = {name: S[f"{name}_rate"] for name in ("rho", "alpha", "beta")}
    newton = {"p": (-2.0, 0.0, 1.0), "q": (0.0, 1e-30, 0.5), "z": (2.0**-60, 0.5, 2.0)}
    p, q, root = S["p"], S["q"], S["z"]
    return (
        Claim("hold", (sp.Min(sp.Max(t, 0), t_c),), points(t=(-1.0, 1.0, 9.5), t_c=(9.0,))),
        Claim("profile", (sigma,), times),
        Claim("profile_rate", (sigma,), tuple(v for v in times if v["t"] != 9 * (1 - Fraction(LEAST_REST))), {"t": 1}),
        Claim("reach_edge", (S["start"] + (S["end"] - S["start"]) * S["sigma"],), points(start=(0.0,), end=(1.0,), sigma=(0.5,))),
        Claim("reach_rate", ((S["end"] - S["start"]) * S["sigma_rate"],), points(start=(0.0,), end=(1.0,), sigma_rate=(0.5,))),
        Claim("circumvent", (bump,), around),
        Claim("circumvent_rate", (bump,), tuple(v for v in around if v["t"] != 2), {"t": 1}),
        Claim("join", (join,), points(**pairs, nu=(20.0,))),
        Claim("join_rate", (join,), points(**pairs, **moving, nu=(20.0,)), {"a": S["da"], "b": S["db"]}),
        Claim("update_rate", (update,), states, {"alpha": 1}),
        Claim(
            "implicit_start",
            _implicit_start(),
            points(h=(0.001, 1.0), psi=(-2.0, -0.5, 0.5, 4.0), alpha=(0.0, 0.75), **constants),
            written=_written,
        ),
        Claim(
            "newton",
            (sp.Max(root - ((root - p) * root**2 - q) / (root * (3 * root - 2 * p)), _exact(LEAST_ROOT)),),
            tuple(v for v in points(**newton) if 3 * v["z"] != 2 * v["p"]),
        ),
        Claim("implicit_end", (S["rest"] + q / root**2,), points(q=(0.5,), rest=(0.25,), z=(2.0,))),
        Claim("lower_edge", (lower,), points(**edges)),
        Claim("upper_edge", (upper,), points(**edges)),
        Claim("lower_edge_rate", (lower,), points(**edges, **rates), along),
        Claim("upper_edge_rate", (upper,), points(**edges, **rates), along),
        Claim("theta", (_theta(S["psi"]),), points(psi=(0.0, 4.0), theta0=(0.5,), mu=(0.25,), varsigma=(20.0,))),
    )


def _implicit_start() -> tuple[Any, ...]:
    h, kappa, psi, alpha = (S[n] for n in ("h", "kappa", "psi", "alpha"))
    rest = alpha / (1 + h * kappa)
    p, q = psi + rest, h * _theta(psi) / (1 + h * kappa)
    least = _exact(LEAST_ROOT)
    third = _exact(1 / 3)
    below = sp.Max(sp.Min(q**third, sp.sqrt(q / sp.Max(-p, least))), least)
    start = sp.Piecewise((below, p < 0), (sp.Max(p + q**third, least), True))
    return p, q, rest, start


def _written(point: Point) -> Mapping[Any, Any]:
    """Where p < 0, psi by -p, which is then a positive symbol."""
    rest = point["alpha"] / (1 + point["h"] * point["kappa"])
    m = sp.Symbol("m", positive=True)
    return {S["psi"]: -m - S["alpha"] / (1 + S["h"] * S["kappa"])} if point["psi"] + rest < 0 else {}


def shipped() -> Mapping[str, Kernel]:
    """The kernels that are printed, by name."""
    return dict(vars(adaptive_parts.kernels_of_the_paper()))


CLAIMS = {claim.kernel: claim for claim in _claims()}
TITLES = {
    "hold": ("t is held within [0, t_c].", r"\min(\max(t,0),t_c)", "ours"),
    "profile": ("The profile is tanh(s), s = t/max(t_c - t, t_c/1024).", r"\sigma = \tanh s", "(4)"),
    "profile_rate": ("The profile's rate is its derivative.", r"\dot\sigma = d\sigma/dt", "(4)"),
    "reach_edge": ("An edge of the reachability tube.", r"\rho = \hat X_0 + (\hat T - \hat X_0)\sigma", "(4)"),
    "reach_rate": ("Its rate.", r"\dot\rho = (\hat T - \hat X_0)\dot\sigma", "(4)"),
    "circumvent": (
        "A circumvent function, its exponent held above -1/cut.",
        r"B\exp\frac{-k d^2}{\max(r^2-d^2,\ k d^2\,\mathrm{cut})}",
        "(7), (8)",
    ),
    "circumvent_rate": ("Its rate is its derivative.", r"\dot b = db/dt", "(7), (8)"),
    "join": ("Two circumvent functions joined.", r"\tfrac1\nu\ln(e^{\nu a}+e^{\nu b}-1)", "in place of (9)"),
    "join_rate": (
        "The rate of the joined functions is the derivative along both rates.",
        r"\partial_a\dot a+\partial_b\dot b",
        "in place of (9)",
    ),
    "update_rate": (
        "(11), psi + alpha held above 2^-30, and its derivative with respect to alpha.",
        r"\dot\alpha,\ \partial\dot\alpha/\partial\alpha",
        "(11)",
    ),
    "implicit_start": (
        "p, q, rest and the first iterate of the implicit step.",
        r"p,\ q,\ \tfrac{\alpha}{1+h\kappa},\ z_0",
        "(11), ours",
    ),
    "newton": ("Newton's map for (z - p) z^2 = q, held above 2^-60.", r"z - f/f'", "ours"),
    "implicit_end": ("alpha at the end of the step.", r"\alpha' = \mathrm{rest} + q/z^2", "ours"),
    "lower_edge": ("gamma_L: the smooth maximum of rho_L - alpha_L and beta_L.", r"\gamma_L", "(10)"),
    "upper_edge": ("gamma_U: the smooth minimum of rho_U + alpha_U and beta_U.", r"\gamma_U", "(10)"),
    "lower_edge_rate": ("The rate of gamma_L is the derivative along all three.", r"\dot\gamma_L", "(10)"),
    "upper_edge_rate": ("The rate of gamma_U is the derivative along all three.", r"\dot\gamma_U", "(10)"),
    "theta": ("theta, its exponent held below 80.", r"\theta", "(11)"),
}


def _proof(name: str) -> Callable[[], Outcome]:
    return lambda: check(CLAIMS[name], shipped()[name])


LEMMAS = tuple(
    Lemma(
        f"kernels.{name}", f"The emitted `{name}`: {statement}", latex, ("on every branch",), f"{source}, Program", _proof(name)
    )
    for name, (statement, latex, source) in TITLES.items()
)
