"""Limits on u where g couples: all of u scaled keeps the tube, each component clipped does not; and M^-1 Mhat in the place of g.

v = xi eps, u = -k v min(1, u_max/(k m)), m the largest |v_i|: the direction of v is kept. |.| is Euclid's norm. g may be any
matrix whose symmetric part is at least g_min > 0. V = |eps|^2/2.
"""

from __future__ import annotations

from typing import Any

import sympy as sp
from flint import arb

from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, prove_identities, prove_positive, refute_by_counterexample
from stt_codegen.lemmas.sampling.sampled import Q

k, m, u_max, g_min, P, W = sp.symbols("k m u_max g_min P W", positive=True)
FACTOR = u_max / (k * m)  # where k m is above u_max; else 1
PULLED = 4 * Q / W  # |v_i| at |eps_i| = E

# A coupling that is symmetric and positive definite, in the resting tube (-1, 1)^2 with f = w = 0, u_max = 1 and any k >= 1.
COUPLED = ((sp.Integer(1), sp.Rational(3, 2)), (sp.Rational(3, 2), sp.Integer(4)))
RISES_AT = (sp.Rational(9, 10), sp.Rational(-3, 10))
LEAVES_FROM = (sp.Rational(9, 10), sp.Rational(-97, 100))

# Two equal uniform rods, stretched: the inertia over m l^2. The nominal one leaves the coupling out.
INERTIA = ((sp.Rational(8, 3), sp.Rational(5, 6)), (sp.Rational(5, 6), sp.Rational(1, 3)))
NOMINAL = ((sp.Rational(8, 3), sp.Integer(0)), (sp.Integer(0), sp.Rational(1, 3)))


def scaled(v: Any, factor: Any) -> Any:
    """u for a factor of at most 1: the same for every component."""
    return -k * factor * v


def vdot(size: Any, effort: Any) -> Any:
    """What Vdot is at most, for |v| and |u|."""
    return size * (P - g_min * effort)


def _prove_scaled() -> Outcome:
    """g is an antisymmetric part, g_min I, and what is left of its symmetric part, which is N'N for some N. For n = 1, 2, 3."""
    factor = sp.Symbol("factor", positive=True)
    found = {}
    for n in (1, 2, 3):
        v = sp.Matrix(sp.symbols(f"v1:{n + 1}", real=True))
        turn = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"t{min(i, j)}{max(i, j)}") * sp.sign(j - i))
        root = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"N{i}{j}", real=True))
        u, rest = scaled(v, factor), root * v
        work = (v.T * (turn + g_min * sp.eye(n) + root.T * root) * u)[0]
        found[f"n = {n}: v' g u + g_min k factor |v|^2 + k factor |N v|^2"] = sp.expand(
            work + k * factor * (g_min * v.dot(v) + rest.dot(rest))
        )
        found[f"n = {n}: |u|^2 - (k factor)^2 |v|^2"] = sp.expand(u.dot(u) - (k * factor) ** 2 * v.dot(v))
    return prove_identities(found)


def _prove_scaled_size() -> Outcome:
    """Where u is scaled its largest component is u_max: no other is above it, and |u| is no less. Where it is not |u| = k |v|."""
    others = sp.symbols("v2 v3", real=True)
    u = scaled(sp.Matrix([m, *others]), FACTOR)
    lesser, less = sp.symbols("lesser less", positive=True)  # |v_i|, and what it lacks of m
    held = scaled(lesser, FACTOR).subs(m, lesser + less)
    free = scaled(sp.Matrix([m, *others]), 1)
    return all_of(
        prove_identities(
            {
                "largest |u_i| - u_max, scaled": sp.simplify(-u[0] - u_max),
                "|u|^2 - u_max^2 - (u_2^2 + u_3^2), scaled": sp.simplify(u.dot(u) - u_max**2 - (u[1] ** 2 + u[2] ** 2)),
                "|u|^2 - k^2 |v|^2, not scaled": sp.expand(free.dot(free) - k**2 * (m**2 + sum(v**2 for v in others))),
            }
        ),
        prove_positive({"u_max - |u_i|": sp.cancel(u_max + held)}),
    )


def prove_scaled_stays() -> Outcome:
    """Vdot <= |v| (P - g_min |u|). With g_min u_max = P + s it is -s |v| or less where u is scaled; with k g_min 4 q_n/W = P + s
    and |v| = 4 q_n/W + more it is -|v| (s + k g_min more) where u is not. |v_i| = 4 q_i/W_i >= 4 q_i/W, W = W_i + s."""
    s, more, size, least = sp.symbols("s more v 4q_n/W", positive=True)
    own, width = sp.symbols("q_i W_i", positive=True)
    free = size * (s + k * g_min * more)
    pulled = PULLED.subs(Q, own)
    return all_of(
        prove_identities(
            {
                "scaled: Vdot's bound, plus s |v|": sp.expand(vdot(size, u_max).subs(u_max, (P + s) / g_min) + s * size),
                "not scaled: Vdot's bound, plus |v| (s + k g_min more)": sp.expand(
                    (vdot(size, k * (least + more)) + free).subs(least, (P + s) / (k * g_min))
                ),
            }
        ),
        prove_positive({"s |v|": s * size, "|v| (s + k g_min more)": free}),
        prove_positive({"4 q_i/W_i - 4 q_i/W": sp.cancel(pulled.subs(W, width) - pulled.subs(W, width + s))}),
    )


def _law_at(place: tuple[Any, ...]) -> list[Any]:
    """v = xi eps of the tube (-1, 1)^2, enclosed."""
    found = []
    for value in place:
        x = arb(value.p) / arb(value.q)
        found.append((1 / (1 + x) + 1 / (1 - x)) * ((1 + x) / (1 - x)).log())
    return found


def _definite(matrix: Any) -> bool:
    """Whether a symmetric 2 by 2 matrix is positive definite."""
    return bool(matrix[0, 0] > 0 and matrix.det() > 0)


def _refute_clipped() -> Outcome:
    """f = w = 0, so P = 0: clipped u is (-1, 1) for every k >= 1, and Vdot = v' g u."""
    g, v = sp.Matrix(COUPLED), _law_at(RISES_AT)
    rate = g * sp.Matrix([-1 if value > 0 else 1 for value in v])
    rises = sum(value * arb(r.p) / arb(r.q) for value, r in zip(v, rate, strict=True))
    work = sum(v[i] * v[j] * arb(g[i, j].p) / arb(g[i, j].q) for i in range(2) for j in range(2))
    falls = -work / max(map(abs, v))  # of the scaled law: k v is above u_max in both components
    clips = all(abs(value) > 1 for value in v)
    return refute_by_counterexample(
        "V falls under clipped u",
        f"g = {g.tolist()}, f = w = 0, u_max = 1, k >= 1, x = {RISES_AT}",
        _definite(g) and clips and rises > 0 and falls < 0,
        f"Vdot is {rises.str(4)}, and {falls.str(4)} under scaled u",
    )


def _refute_clipped_leaves() -> Outcome:
    """While both components of k v are beyond u_max x moves on a line. |v_i| rises with |x_i|, so on the way |v_1| is least at
    the start and |v_2| at the end, provided that x_2 keeps its sign."""
    g = sp.Matrix(COUPLED)
    rate = g * sp.Matrix([-1, 1])
    time = (1 - LEAVES_FROM[0]) / rate[0] if rate[0] > 0 else sp.oo
    end = LEAVES_FROM[1] + rate[1] * time
    least = _law_at((LEAVES_FROM[0], end)) if -1 < end < 0 else [arb(0), arb(0)]
    return refute_by_counterexample(
        "clipped u keeps the tube",
        f"g = {g.tolist()}, f = w = 0, u_max = 1, k >= 1, x(0) = {LEAVES_FROM}",
        _definite(g) and least[0] > 1 and least[1] < -1,
        f"u is (-1, 1) and xdot {tuple(rate)} until x = (1, {end}) at t = {time}, where x_1 leaves; "
        f"on the way v_1 is {least[0].str(4)} or more and v_2 {least[1].str(4)} or less",
    )


def _refute_nominal() -> Outcome:
    inertia, nominal = sp.Matrix(INERTIA), sp.Matrix(NOMINAL)
    product = inertia.inv() * nominal
    half = (product + product.T) / 2
    v = sp.Matrix([1, 1])
    work = (v.T * half * v)[0]
    return refute_by_counterexample(
        "M^-1 Mhat has a positive definite symmetric part",
        f"M = {inertia.tolist()}, Mhat = {nominal.tolist()}, v = (1, 1)",
        _definite(inertia) and _definite(nominal) and work < 0,
        f"v' M^-1 Mhat v = {work}, the symmetric part's determinant is {half.det()}",
    )


def nominal_error(inverse: Any, inertia: Any, nominal: Any) -> Any:
    """What the nominal inertia leaves of g = M^-1 Mhat beside the identity."""
    return inverse * (inertia - nominal)


def _prove_near_nominal() -> Outcome:
    """v' M^-1 Mhat v = |v|^2 - v' D v, and v' D v <= |D| |v|^2 by what a norm is. For n = 1, 2, by entry."""
    found: dict[str, Any] = {}
    for n in (1, 2):
        inertia = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"M{min(i, j)}{max(i, j)}"))
        nominal = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"Mhat{min(i, j)}{max(i, j)}"))
        inverse = inertia.inv()
        rest = inverse * nominal - sp.eye(n) + nominal_error(inverse, inertia, nominal)
        found |= {f"n = {n}: M^-1 Mhat - I + D, entry {i}{j}": sp.cancel(rest[i, j]) for i in range(n) for j in range(n)}
    return prove_identities(found)


LEMMAS = (
    Lemma("limits.scaled", "Scaled u does work against eps in full: no coupling turns it.",
          r"v^\top g u \le -g_{min}\,|v|\,|u|", ("g_s >= g_min", "u = -k v times a factor"), "ours", _prove_scaled, ("theorem.skew",)),
    Lemma("limits.scaled_size", "Scaled u is within u_max, and is no less than the lesser of k |v| and u_max.",
          r"u = -kv\min\bigl(1, \tfrac{u_{max}}{k\max|v_i|}\bigr) \Rightarrow |u_i| \le u_{max},\ |u| \ge \min(k|v|, u_{max})",
          ("| | is Euclid's norm", "u_max is the same for all components"), "ours", _prove_scaled_size),
    Lemma("limits.scaled_stays", "For any g with g_s >= g_min scaled u keeps |eps| < E if u_max and the gain are enough for P.",
          r"g_{min}u_{max} > P,\ k\,g_{min}\tfrac{4}{W_+}q_n(E) > P \Rightarrow \dot V < 0\ \mathrm{at}\ |\varepsilon| = E",
          ("|eps(0)| < E <= eps(e_max)", "P >= |f + w - mean of edge rates| in the whole tube", "u is continuous in time"),
          "ours", prove_scaled_stays, ("sampled.first_exit", "theorem.vdot", "theorem.norms", "sampled.law", "sampled.norm", "limits.scaled",
                           "limits.scaled_size")),
    Lemma("limits.clipped", "With each component of u clipped instead, V falls as it does with scaled u.",
          r"u_i = -\mathrm{sat}(k v_i) \Rightarrow \dot V < 0", ("g symmetric and positive definite", "f = w = 0"),
          "a common law", _refute_clipped),
    Lemma("limits.clipped_leaves", "With each component of u clipped the tube is kept if g_min u_max > P and the gain is enough.",
          r"g_{min}u_{max} > P = 0 \Rightarrow x \in \Gamma", ("g symmetric and positive definite", "f = w = 0, edges at rest"),
          "a common law", _refute_clipped_leaves, ("sampled.rises",)),
    Lemma("limits.nominal", "For an arm of inertia M that is driven by Mhat times u, g = M^-1 Mhat has g_s > 0.",
          r"M, \hat M > 0 \Rightarrow (M^{-1}\hat M)_s > 0", ("M, Mhat symmetric and positive definite",), "as one might hope",
          _refute_nominal),
    Lemma("limits.near_nominal", "It has where the nominal inertia is near enough: g_s is at least 1 - |M^-1 (M - Mhat)|.",
          r"M^{-1}\hat M = I - D,\ D = M^{-1}(M-\hat M) \Rightarrow (M^{-1}\hat M)_s \ge 1 - |D|", ("|D| the spectral norm",),
          "ours", _prove_near_nominal),
)  # fmt: skip
