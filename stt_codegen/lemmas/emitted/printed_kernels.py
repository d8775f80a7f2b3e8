"""Lemmas about the emitted kernels of the adaptive tube: on every branch they are the claimed formulas, guards included.

A kernel with a rate has the derivative of its value. A kernel is followed at points of every regime. On one branch each output
is one formula; that is compared with the claimed one, in which maxima, minima and absolute values are resolved at the point.
book.py takes LEMMAS as the family `kernels`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from itertools import product
from typing import Any

import sympy as sp

from stt_codegen.controller.kernels import adaptive_kernels
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict
from stt_codegen.paper.adaptive_tube import EXPONENT_LIMIT, MINIMUM_GAP, MINIMUM_ROOT
from stt_codegen.paper.reach_tube import MINIMUM_REST
from stt_codegen.program import Kernel
from stt_codegen.program.symbolic import follow_kernel, kernel_formulas

Point = Mapping[str, Fraction]
SYMBOLS: dict[str, Any] = {
    name: sp.Symbol(name, real=True)
    for name in (
        "t t_c start end sigma sigma_rate height steepness middle radius cut a b da db psi alpha theta0 kappa mu varsigma h "
        "p q z rest rho beta rho_rate alpha_rate beta_rate"
    ).split()
} | {name: sp.Symbol(name, positive=True) for name in ("nu", "h", "theta0", "kappa")}


def _exact(value: float) -> Any:
    return sp.Rational(Fraction(value).numerator, Fraction(value).denominator)


@dataclass(frozen=True)
class KernelClaim:
    """The formulas that a kernel's outputs are claimed to be, and points of every regime.

    rates: of inputs by name (1 for time itself), where the last output is the derivative of the first. rewriting: for a point
    the substitutes of inputs whose signs SymPy then knows.
    """

    kernel: str
    values: tuple[Any, ...]
    points: tuple[Point, ...]
    rates: Mapping[str, Any] | None = None
    rewriting: Callable[[Point], Mapping[Any, Any]] = lambda _: {}


def resolved(expression: Any, point: Mapping[Any, Any]) -> Any:
    """Replace maxima, minima and absolute values by the argument that they are at the point; by the mean of two equal ones."""

    def extreme(*args: Any, largest: bool) -> Any:
        sizes = [sp.sympify(a).subs(point) for a in args]
        extreme_size = max(sizes) if largest else min(sizes)
        chosen = [a for a, size in zip(args, sizes, strict=True) if size == extreme_size]
        return sum(chosen) / len(chosen)

    def absolute(a: Any) -> Any:
        return a * sp.sign(sp.sympify(a).subs(point))

    def piece(*pairs: Any) -> Any:
        return next(value for value, holds in pairs if sp.sympify(holds).subs(point) == sp.true)

    replaced = expression.replace(sp.Piecewise, piece) if expression.has(sp.Piecewise) else expression
    replaced = replaced.replace(sp.Abs, absolute)
    replaced = replaced.replace(sp.Max, lambda *a: extreme(*a, largest=True))
    return replaced.replace(sp.Min, lambda *a: extreme(*a, largest=False))


def _rate(value: Any, rates: Mapping[str, Any]) -> Any:
    return sum(sp.diff(value, SYMBOLS[name]) * rate for name, rate in rates.items())


def check(claim: KernelClaim, kernel: Kernel) -> Outcome:
    """Prove that the outputs are the claimed formulas on every branch that the points take."""
    branches: dict[Any, Point] = {}
    for point in claim.points:
        inputs = [point[v.name] for v in kernel.inputs]
        exact = {SYMBOLS[name]: sp.Rational(v.numerator, v.denominator) for name, v in point.items()}
        values = tuple(resolved(v, exact) for v in claim.values)
        branches.setdefault((follow_kernel(kernel, [float(v) for v in inputs]), values), point)
    failures = []
    for (decisions, values), point in branches.items():
        symbols = [SYMBOLS[v.name] for v in kernel.inputs]
        exact = {SYMBOLS[name]: sp.Rational(v.numerator, v.denominator) for name, v in point.items()}
        expected = list(values) + ([_rate(values[0], claim.rates)] if claim.rates is not None else [])
        if len(expected) != len(kernel.outputs):
            return Outcome(
                Verdict.OPEN, "SymPy", (f"{claim.kernel} has {len(kernel.outputs)} outputs, {len(expected)} are claimed",)
            )
        computed = kernel_formulas(kernel, symbols, decisions)
        for name, output, formula in zip(kernel.output_names, computed, expected, strict=True):
            remainder = _difference(
                *(v.subs(claim.rewriting(point)) for v in (resolved(sp.sympify(output), exact), sp.sympify(formula)))
            )
            if remainder != 0:
                failures.append(f"{name} at {_in_words(point)}: {remainder}")
    method = "SymPy: the kernel followed at points of every regime, its formula on each branch compared"
    if failures:
        return Outcome(Verdict.OPEN, method, tuple(failures))
    return Outcome(Verdict.PROVED, method, (f"{claim.kernel}: {len(branches)} branches and regimes, {len(claim.points)} points",))


def _difference(output: Any, expected: Any) -> Any:
    """Return the simplified difference, 0 where both are the same formula."""
    difference = sp.sympify(output) - expected
    for step in (sp.expand, lambda v: sp.cancel(sp.together(sp.powsimp(sp.expand(v)))), sp.simplify):
        remainder = step(difference)
        if remainder == 0:
            return remainder
    return remainder


def _in_words(point: Point) -> str:
    return ", ".join(f"{name} = {float(v):g}" for name, v in point.items())


def points(**choices: Sequence[float]) -> tuple[Point, ...]:
    """Return every combination of the values of each name."""
    return tuple({name: Fraction(v) for name, v in zip(choices, values, strict=True)} for values in product(*choices.values()))


def _theta(psi: Any) -> Any:
    return 2 * SYMBOLS["theta0"] / (1 + sp.exp(2 * sp.Min(SYMBOLS["varsigma"] * (psi - SYMBOLS["mu"]), _exact(EXPONENT_LIMIT))))


def _smooth_max(a: Any, b: Any, sign: int) -> Any:
    """Return the smooth maximum (sign 1) or minimum (-1)."""
    return (a + b) / 2 + sign * sp.Abs(a - b) / 2 + sign * sp.log(1 + sp.exp(-SYMBOLS["nu"] * sp.Abs(a - b))) / SYMBOLS["nu"]


def _reach_claims() -> Iterator[KernelClaim]:
    """Yield the claims about clamped time, the profile (4) and the edges of the reachability tube."""
    t, t_c, start, end, sigma, sigma_rate = (SYMBOLS[n] for n in ("t", "t_c", "start", "end", "sigma", "sigma_rate"))
    s = t / sp.Max(t_c - t, _exact(MINIMUM_REST) * t_c)
    profile = (1 - sp.exp(-2 * s)) / (1 + sp.exp(-2 * s))
    times = points(t=(0.0, 1.0, 8.9, 8.999, 9.0), t_c=(9.0,))
    smooth_times = tuple(v for v in times if v["t"] != 9 * (1 - Fraction(MINIMUM_REST)))
    yield KernelClaim("hold", (sp.Min(sp.Max(t, 0), t_c),), points(t=(-1.0, 1.0, 9.5), t_c=(9.0,)))
    yield KernelClaim("profile", (profile,), times)
    yield KernelClaim("profile_rate", (profile,), smooth_times, {"t": 1})
    yield KernelClaim("reach_edge", (start + (end - start) * sigma,), points(start=(0.0,), end=(1.0,), sigma=(0.5,)))
    yield KernelClaim("reach_rate", ((end - start) * sigma_rate,), points(start=(0.0,), end=(1.0,), sigma_rate=(0.5,)))


def _bump_claims() -> Iterator[KernelClaim]:
    """Yield the claims about circumvent functions (7), (8) and how two of them are joined in place of (9)."""
    t, a, b, nu = (SYMBOLS[n] for n in ("t", "a", "b", "nu"))
    height, steepness, radius, cut = (SYMBOLS[n] for n in ("height", "steepness", "radius", "cut"))
    d = t - SYMBOLS["middle"]
    weighted_square = steepness * d**2
    bump = height * sp.exp(-weighted_square / sp.Max((radius - sp.Abs(d)) * (radius + sp.Abs(d)), weighted_square * cut))
    times = points(
        t=(1.0, 1.5, 2.0, 2.5, 2.999, 3.5, 0.5), height=(3.0,), steepness=(0.5,), middle=(2.0,), radius=(1.0,), cut=(2.0**-7,)
    )
    larger = sp.Max(a, b)
    joined = larger + sp.log(1 + sp.exp(-nu * sp.Abs(a - b)) - sp.exp(-nu * larger)) / nu
    pairs, pair_rates = {"a": (0.0, 0.5, 2.0), "b": (0.25, 1.0)}, {"da": (0.5,), "db": (-0.25,)}
    rates = {"a": SYMBOLS["da"], "b": SYMBOLS["db"]}
    yield KernelClaim("circumvent", (bump,), times)
    yield KernelClaim("circumvent_rate", (bump,), tuple(v for v in times if v["t"] != 2), {"t": 1})
    yield KernelClaim("join", (joined,), points(**pairs, nu=(20.0,)))
    yield KernelClaim("join_rate", (joined,), points(**pairs, **pair_rates, nu=(20.0,)), rates)


def _update_claims() -> Iterator[KernelClaim]:
    """Yield the claims about (11) and the implicit step that is emitted for it."""
    psi, alpha, p, q, z = (SYMBOLS[n] for n in ("psi", "alpha", "p", "q", "z"))
    psi_plus_alpha = sp.Max(psi + alpha, _exact(MINIMUM_GAP))
    alpha_rate = _theta(psi) / psi_plus_alpha**2 - SYMBOLS["kappa"] * alpha
    constants = {"theta0": (0.5,), "kappa": (5.0,), "mu": (0.25,), "varsigma": (20.0,)}
    states = points(psi=(-1.0, 0.5, 1.0, 4.0), alpha=(0.0, 0.125, 0.75), **constants)
    starts = points(h=(0.001, 1.0), psi=(-2.0, -0.5, 0.5, 4.0), alpha=(0.0, 0.75), **constants)
    iterates = points(p=(-2.0, 0.0, 1.0), q=(0.0, 1e-30, 0.5), z=(2.0**-60, 0.5, 2.0))
    next_iterate = sp.Max(z - ((z - p) * z**2 - q) / (z * (3 * z - 2 * p)), _exact(MINIMUM_ROOT))
    yield KernelClaim("theta", (_theta(psi),), points(psi=(0.0, 4.0), theta0=(0.5,), mu=(0.25,), varsigma=(20.0,)))
    yield KernelClaim("update_rate", (alpha_rate,), states, {"alpha": 1})
    yield KernelClaim("implicit_start", _implicit_start(), starts, rewriting=_psi_by_minus_p)
    yield KernelClaim("newton", (next_iterate,), tuple(v for v in iterates if 3 * v["z"] != 2 * v["p"]))
    yield KernelClaim("implicit_end", (SYMBOLS["rest"] + q / z**2,), points(q=(0.5,), rest=(0.25,), z=(2.0,)))


def _edge_claims() -> Iterator[KernelClaim]:
    """Yield the claims about the edges (10) and their rates."""
    rho, alpha, beta = (SYMBOLS[n] for n in ("rho", "alpha", "beta"))
    lower, upper = _smooth_max(rho - alpha, beta, 1), _smooth_max(rho + alpha, beta, -1)
    states = {"rho": (0.5, 2.0), "alpha": (0.0, 0.25), "beta": (0.0, 1.0, 3.0), "nu": (20.0,)}
    state_rates = {"rho_rate": (0.5,), "alpha_rate": (-0.25,), "beta_rate": (1.0,)}
    rates = {name: SYMBOLS[f"{name}_rate"] for name in ("rho", "alpha", "beta")}
    yield KernelClaim("lower_edge", (lower,), points(**states))
    yield KernelClaim("upper_edge", (upper,), points(**states))
    yield KernelClaim("lower_edge_rate", (lower,), points(**states, **state_rates), rates)
    yield KernelClaim("upper_edge_rate", (upper,), points(**states, **state_rates), rates)


def _implicit_start() -> tuple[Any, ...]:
    """Return p, q, rest and the first iterate of the implicit step."""
    h, kappa, psi, alpha = (SYMBOLS[n] for n in ("h", "kappa", "psi", "alpha"))
    rest = alpha / (1 + h * kappa)
    p, q = psi + rest, h * _theta(psi) / (1 + h * kappa)
    minimum_root = _exact(MINIMUM_ROOT)
    third = _exact(1 / 3)
    root_for_negative_p = sp.Max(sp.Min(q**third, sp.sqrt(q / sp.Max(-p, minimum_root))), minimum_root)
    start = sp.Piecewise((root_for_negative_p, p < 0), (sp.Max(p + q**third, minimum_root), True))
    return p, q, rest, start


def _psi_by_minus_p(point: Point) -> Mapping[Any, Any]:
    """Return a substitute for psi by -p where p < 0; -p is then a positive symbol."""
    rest = point["alpha"] / (1 + point["h"] * point["kappa"])
    m = sp.Symbol("m", positive=True)
    return {SYMBOLS["psi"]: -m - SYMBOLS["alpha"] / (1 + SYMBOLS["h"] * SYMBOLS["kappa"])} if point["psi"] + rest < 0 else {}


def shipped() -> Mapping[str, Kernel]:
    """Return the kernels that are printed, by name."""
    return dict(vars(adaptive_kernels.build_adaptive_kernels()))


CLAIMS = {claim.kernel: claim for claim in (*_reach_claims(), *_bump_claims(), *_update_claims(), *_edge_claims())}
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


def _proof_of(name: str) -> Callable[[], Outcome]:
    return lambda: check(CLAIMS[name], shipped()[name])


LEMMAS = tuple(
    Lemma(
        f"kernels.{name}",
        f"The emitted `{name}`: {statement}",
        latex,
        ("on every branch",),
        f"{source}, Program",
        _proof_of(name),
    )
    for name, (statement, latex, source) in TITLES.items()
)
