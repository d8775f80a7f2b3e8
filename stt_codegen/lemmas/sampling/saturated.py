"""Lemmas about limits on u where g couples: scaling all of u keeps x in the tube, clipping each component may not.

The last two are about an arm, where M^-1 Mhat is in the place of g. book.py takes LEMMAS as a part of the family `limits`.
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
V_AT_E = 4 * Q / W  # |v_i| at |eps_i| = E

# A coupling that is symmetric and positive definite, in the resting tube (-1, 1)^2 with f = w = 0, u_max = 1 and any k >= 1.
COUPLED = ((sp.Integer(1), sp.Rational(3, 2)), (sp.Rational(3, 2), sp.Integer(4)))
RISES_AT = (sp.Rational(9, 10), sp.Rational(-3, 10))
LEAVES_FROM = (sp.Rational(9, 10), sp.Rational(-97, 100))

# Two equal uniform rods, stretched: the inertia over m l^2. The nominal one has no coupling.
INERTIA = ((sp.Rational(8, 3), sp.Rational(5, 6)), (sp.Rational(5, 6), sp.Rational(1, 3)))
NOMINAL = ((sp.Rational(8, 3), sp.Integer(0)), (sp.Integer(0), sp.Rational(1, 3)))


def scaled(v: Any, factor: Any) -> Any:
    """Return u with one factor, at most 1, for all components."""
    return -k * factor * v


def vdot(size: Any, effort: Any) -> Any:
    """Return the bound on Vdot for |v| and |u|."""
    return size * (P - g_min * effort)


def _prove_scaled() -> Outcome:
    """Prove v' g u <= -g_min |v| |u| for n = 1, 2, 3: g is an antisymmetric part, g_min I, and N'N for some matrix N."""
    factor = sp.Symbol("factor", positive=True)
    differences = {}
    for n in (1, 2, 3):
        v = sp.Matrix(sp.symbols(f"v1:{n + 1}", real=True))
        antisymmetric = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"t{min(i, j)}{max(i, j)}") * sp.sign(j - i))
        root = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"N{i}{j}", real=True))
        u, root_v = scaled(v, factor), root * v
        work = (v.T * (antisymmetric + g_min * sp.eye(n) + root.T * root) * u)[0]
        differences[f"n = {n}: v' g u + g_min k factor |v|^2 + k factor |N v|^2"] = sp.expand(
            work + k * factor * (g_min * v.dot(v) + root_v.dot(root_v))
        )
        differences[f"n = {n}: |u|^2 - (k factor)^2 |v|^2"] = sp.expand(u.dot(u) - (k * factor) ** 2 * v.dot(v))
    return prove_identities(differences)


def _prove_scaled_size() -> Outcome:
    """Prove that scaled u has u_max as its largest component, so |u| >= u_max, and that u which is not scaled has |u| = k |v|."""
    smaller_components = sp.symbols("v2 v3", real=True)
    u = scaled(sp.Matrix([m, *smaller_components]), FACTOR)
    size, distance_to_m = sp.symbols("lesser less", positive=True)  # |v_i|, and m less that
    smaller_input = scaled(size, FACTOR).subs(m, size + distance_to_m)
    unscaled = scaled(sp.Matrix([m, *smaller_components]), 1)
    return all_of(
        prove_identities(
            {
                "largest |u_i| - u_max, scaled": sp.simplify(-u[0] - u_max),
                "|u|^2 - u_max^2 - (u_2^2 + u_3^2), scaled": sp.simplify(u.dot(u) - u_max**2 - (u[1] ** 2 + u[2] ** 2)),
                "|u|^2 - k^2 |v|^2, not scaled": sp.expand(
                    unscaled.dot(unscaled) - k**2 * (m**2 + sum(v**2 for v in smaller_components))
                ),
            }
        ),
        prove_positive({"u_max - |u_i|": sp.cancel(u_max + smaller_input)}),
    )


def prove_scaled_stays() -> Outcome:
    """Prove that Vdot <= |v| (P - g_min |u|) is below 0 at |eps| = E, where u is scaled and where it is not.

    Scaled, with g_min u_max = P + s, it is -s |v| or less. Not scaled, with k g_min 4 q_n/W = P + s and |v| = 4 q_n/W + more,
    it is -|v| (s + k g_min more). |v_i| = 4 q_i/W_i >= 4 q_i/W, since W = W_i + s.
    """
    s, excess, size, v_bound = sp.symbols("s more v 4q_n/W", positive=True)
    q_component, width = sp.symbols("q_i W_i", positive=True)
    decrease = size * (s + k * g_min * excess)
    v_component = V_AT_E.subs(Q, q_component)
    return all_of(
        prove_identities(
            {
                "scaled: Vdot's bound, plus s |v|": sp.expand(vdot(size, u_max).subs(u_max, (P + s) / g_min) + s * size),
                "not scaled: Vdot's bound, plus |v| (s + k g_min more)": sp.expand(
                    (vdot(size, k * (v_bound + excess)) + decrease).subs(v_bound, (P + s) / (k * g_min))
                ),
            }
        ),
        prove_positive({"s |v|": s * size, "|v| (s + k g_min more)": decrease}),
        prove_positive({"4 q_i/W_i - 4 q_i/W": sp.cancel(v_component.subs(W, width) - v_component.subs(W, width + s))}),
    )


def _law_at(state: tuple[Any, ...]) -> list[Any]:
    """Enclose v = xi eps at a point of the tube (-1, 1)^2."""
    v = []
    for value in state:
        x = arb(value.p) / arb(value.q)
        v.append((1 / (1 + x) + 1 / (1 - x)) * ((1 + x) / (1 - x)).log())
    return v


def _is_definite(matrix: Any) -> bool:
    """Return whether a symmetric 2 by 2 matrix is positive definite."""
    return bool(matrix[0, 0] > 0 and matrix.det() > 0)


def _refute_clipped() -> Outcome:
    """Enclose Vdot = v' g u for f = w = 0, so P = 0, where clipped u is (-1, 1) for every k >= 1."""
    g, v = sp.Matrix(COUPLED), _law_at(RISES_AT)
    velocity = g * sp.Matrix([-1 if value > 0 else 1 for value in v])
    rate_clipped = sum(value * arb(r.p) / arb(r.q) for value, r in zip(v, velocity, strict=True))
    work = sum(v[i] * v[j] * arb(g[i, j].p) / arb(g[i, j].q) for i in range(2) for j in range(2))
    rate_scaled = -work / max(map(abs, v))  # of the scaled law: k v is above u_max in both components
    both_clipped = all(abs(value) > 1 for value in v)
    return refute_by_counterexample(
        "V falls under clipped u",
        f"g = {g.tolist()}, f = w = 0, u_max = 1, k >= 1, x = {RISES_AT}",
        _is_definite(g) and both_clipped and rate_clipped > 0 and rate_scaled < 0,
        f"Vdot is {rate_clipped.str(4)}, and {rate_scaled.str(4)} under scaled u",
    )


def _refute_clipped_leaves() -> Outcome:
    """Follow x under clipped u until it leaves the tube.

    While both components of k v are beyond u_max, x moves on a line. |v_i| rises with |x_i|; so on the way |v_1| is smallest at
    the start and |v_2| at the end, provided that x_2 does not change its sign.
    """
    g = sp.Matrix(COUPLED)
    velocity = g * sp.Matrix([-1, 1])
    time = (1 - LEAVES_FROM[0]) / velocity[0] if velocity[0] > 0 else sp.oo
    end = LEAVES_FROM[1] + velocity[1] * time
    smallest_v = _law_at((LEAVES_FROM[0], end)) if -1 < end < 0 else [arb(0), arb(0)]
    return refute_by_counterexample(
        "clipped u keeps the tube",
        f"g = {g.tolist()}, f = w = 0, u_max = 1, k >= 1, x(0) = {LEAVES_FROM}",
        _is_definite(g) and smallest_v[0] > 1 and smallest_v[1] < -1,
        f"u is (-1, 1) and xdot {tuple(velocity)} until x = (1, {end}) at t = {time}, where x_1 leaves; "
        f"on the way v_1 is {smallest_v[0].str(4)} or more and v_2 {smallest_v[1].str(4)} or less",
    )


def _refute_nominal() -> Outcome:
    """Compute v' M^-1 Mhat v for two stretched rods and a nominal inertia without their coupling: it is negative."""
    inertia, nominal = sp.Matrix(INERTIA), sp.Matrix(NOMINAL)
    product = inertia.inv() * nominal
    symmetric_part = (product + product.T) / 2
    v = sp.Matrix([1, 1])
    work = (v.T * symmetric_part * v)[0]
    return refute_by_counterexample(
        "M^-1 Mhat has a positive definite symmetric part",
        f"M = {inertia.tolist()}, Mhat = {nominal.tolist()}, v = (1, 1)",
        _is_definite(inertia) and _is_definite(nominal) and work < 0,
        f"v' M^-1 Mhat v = {work}, the symmetric part's determinant is {symmetric_part.det()}",
    )


def nominal_error(inverse: Any, inertia: Any, nominal: Any) -> Any:
    """Return D of g = M^-1 Mhat = I - D, which the nominal inertia leaves."""
    return inverse * (inertia - nominal)


def _prove_near_nominal() -> Outcome:
    """Prove M^-1 Mhat = I - D for n = 1, 2 by entry; v' D v <= |D| |v|^2 by the definition of a norm."""
    differences: dict[str, Any] = {}
    for n in (1, 2):
        inertia = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"M{min(i, j)}{max(i, j)}"))
        nominal = sp.Matrix(n, n, lambda i, j: sp.Symbol(f"Mhat{min(i, j)}{max(i, j)}"))
        inverse = inertia.inv()
        remainder = inverse * nominal - sp.eye(n) + nominal_error(inverse, inertia, nominal)
        differences |= {
            f"n = {n}: M^-1 Mhat - I + D, entry {i}{j}": sp.cancel(remainder[i, j]) for i in range(n) for j in range(n)
        }
    return prove_identities(differences)


LEMMAS = (
    Lemma("limits.scaled", "Scaled u does work against eps in full: no coupling turns it.",
          r"v^\top g u \le -g_{min}\,|v|\,|u|", ("g_s >= g_min", "u = -k v times a factor"), "ours", _prove_scaled,
          ("theorem.skew",)),
    Lemma("limits.scaled_size", "Scaled u is within u_max, and is no less than the lesser of k |v| and u_max.",
          r"u = -kv\min\bigl(1, \tfrac{u_{max}}{k\max|v_i|}\bigr) \Rightarrow |u_i| \le u_{max},\ |u| \ge \min(k|v|, u_{max})",
          ("| | is Euclid's norm", "u_max is the same for all components"), "ours", _prove_scaled_size),
    Lemma("limits.scaled_stays", "For any g with g_s >= g_min scaled u keeps |eps| < E if u_max and the gain are enough for P.",
          r"g_{min}u_{max} > P,\ k\,g_{min}\tfrac{4}{W_+}q_n(E) > P \Rightarrow \dot V < 0\ \mathrm{at}\ |\varepsilon| = E",
          ("|eps(0)| < E <= eps(e_max)", "P >= |f + w - mean of edge rates| in the whole tube", "u is continuous in time"),
          "ours", prove_scaled_stays, ("sampled.first_exit", "theorem.vdot", "theorem.norms", "sampled.law", "sampled.norm",
                                       "limits.scaled", "limits.scaled_size")),
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
