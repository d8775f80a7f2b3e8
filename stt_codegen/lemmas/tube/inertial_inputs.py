"""Lemmas about plants of order 2: any gain without bounds, scaled coupled inputs, velocity by differences, held feed-forward.

book.py takes LEMMAS as a part of the family `filtered`. Long because its lemmas refer to one another.

Letters as in filtered_tube.py: a and b are the distances of z = v + lambda x to the edges A = L' + lambda L and
B = R' + lambda R of the filtered tube, Z = a + b; eps = ln(a/b), xi = 1/a + 1/b, V = |eps|^2/2.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import sympy as sp

from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, prove_identities, prove_positive, refute_by_counterexample
from stt_codegen.lemmas.sampling import saturated
from stt_codegen.lemmas.tube.filtered_tube import L, R, a, a0, b, b0, lam, q, t, v, x

far, near, Z, Phi, k, g_min = sp.symbols("a b Z Phi k g_min", positive=True)
tau, A = sp.symbols("tau A", positive=True)  # the time between two samples; |vdot| is at most A
s = sp.Symbol("s", real=True)  # a time between them

A_RATE, B_RATE = (sp.diff(sp.diff(edge, t) + lam * edge, t) for edge in (L, R))
REST = lam * v - (b * A_RATE + a * B_RATE) / (a + b)
V_MIN, V_MAX = (sp.diff(L, t) - lam * (R - L), sp.diff(R, t) + lam * (R - L))  # bounds on v
XI_MIN = 4 / (far + near)  # xi is at least that
EPSILON_BOUND = Z * Phi / (4 * k * g_min)  # |eps| stays below it
WEIGHT = s - (t - tau)  # of vdot(s), in the error of v by differences
C = (L + R) / 2
FEED_FORWARD = sp.diff(C, t, 2) - lam * (v - sp.diff(C, t))  # for g = ghat


def _prove_vdot() -> Outcome:
    """Prove d ln(a/b)/dt = a'/a - b'/b = xi (a' b - b' a)/(a + b), and that REST is the mean of the exit inequality."""
    numerator = sp.diff(a, t) * b - sp.diff(b, t) * a  # epsdot a b
    rest = sp.cancel(REST * (a + b))
    exit_mean = a * (lam**2 * b0 - sp.diff(R, t, 2)) + b * (-sp.diff(L, t, 2) - lam**2 * a0)
    return prove_identities(
        {
            "(a'/a - b'/b) a b - (a + b)(vdot + rest)": sp.expand(numerator - (a + b) * q - rest),
            "(a + b) rest - (a + b) times the mean of the exit inequality": sp.expand(rest - exit_mean),
        }
    )


def _prove_bounded() -> Outcome:
    """Prove that v differs from each bound by a distance of z and lambda times one of x, both positive, so that v is bounded."""
    distances = sp.symbols("a b x-L R-x", positive=True)
    return all_of(
        prove_identities(
            {
                "R' + lambda W - v - (b + lambda (x - L))": sp.expand(V_MAX - v - (b + lam * a0)),
                "v - L' + lambda W - (a + lambda (R - x))": sp.expand(v - V_MIN - (a + lam * b0)),
            }
        ),
        prove_positive(
            {"b + lambda (x - L)": distances[1] + lam * distances[2], "a + lambda (R - x)": distances[0] + lam * distances[3]}
        ),
    )


def input_over_gain_at(e: Any, width: Any) -> Any:
    """Return |u|/k of the law at eps = E: 4 q(E)/Z with q(E) = E cosh(E/2)^2."""
    return 4 * e * sp.cosh(e / 2) ** 2 / width


def _prove_saturated() -> Outcome:
    """Prove that eps' a b/(a + b) is below 0 at eps = E, which contradicts eps < E before.

    At a/b = e^E the law's |u| is 4 k q(E)/Z, and at least 4 k q(E)/Z_+ since Z <= Z_+. Let g |u| = P_x + room, f + w = F - s_F,
    the mean of the exit inequality M - s_m, and P_x = F + M.
    """
    e, width_difference, margin, drift_deficit, mean_deficit, drift_bound, mean_bound = sp.symbols(
        "E Z_+-Z room s_F s_m F M", positive=True
    )
    upper, lower = Z / (1 + sp.exp(-e)), Z / (1 + sp.exp(e))
    input_over_gain = input_over_gain_at(e, Z)
    law = (1 / upper + 1 / lower) * e
    rate = (drift_bound - drift_deficit) - (drift_bound + mean_bound + margin) + (mean_bound - mean_deficit)
    difference = input_over_gain * width_difference / (Z + width_difference)
    return all_of(
        prove_identities(
            {
                "h at a/b = e^E, less 4 q/Z": sp.simplify((law - input_over_gain.rewrite(sp.exp)).expand()),
                "4 q/Z - 4 q/Z_+": sp.together(input_over_gain - input_over_gain_at(e, Z + width_difference) - difference),
                "eps' a b/(a + b)": sp.expand(rate + margin + drift_deficit + mean_deficit),
            }
        ),
        prove_positive(
            {
                "4 q/Z - 4 q/Z_+": difference.subs(sp.cosh(e / 2), sp.Symbol("cosh", positive=True)),
                "room": margin + drift_deficit + mean_deficit,
            }
        ),
    )


def _prove_gain() -> Outcome:
    """Prove that 1/a + 1/b less 4/(a + b) is a square over positive numbers."""
    xi = 1 / far + 1 / near
    return prove_identities(
        {"xi - 4/(a + b) - (a - b)^2/(a b (a + b))": sp.cancel(xi - XI_MIN - (far - near) ** 2 / (far * near * (far + near)))}
    )


def _prove_forever() -> Outcome:
    """Prove that V falls beyond the bound, and that neither a nor b comes near 0 within it.

    Beyond it y = |xi eps| = 4 |eps|/Z + more is above Phi/(k g_min), so Vdot <= -k g_min y^2 + y Phi < 0. Since a and b are
    bounded below, the solution exists for all time.
    """
    excess, xi_excess, z_min, z_excess, growth, decay = sp.symbols("beyond more Z_min wider e^E-1 less", positive=True)
    v_norm = 4 * (EPSILON_BOUND + excess) / Z + xi_excess
    decrease = k * g_min * (4 * excess / Z + xi_excess)
    near_distance = (z_min + z_excess) / (1 + (1 + growth) / (1 + decay))  # b = Z/(1 + e^eps) for any Z >= Z_min, eps <= E
    distance_margin = sp.cancel(near_distance - z_min / (2 + growth))
    return all_of(
        prove_identities(
            {"Vdot's bound, plus y times what it falls": sp.expand(-k * g_min * v_norm**2 + v_norm * Phi + v_norm * decrease)}
        ),
        prove_positive({"what it falls": decrease, "b - Z_min/(1 + e^E)": sp.factor(distance_margin)}),
    )


def _prove_scaled() -> Outcome:
    """Repeat the proof for order 1: P_x bounds REST by component, as P bounds the mean of edge rates there."""
    return saturated.prove_scaled_stays()


def _prove_differences() -> Outcome:
    """Prove the error of v by differences: integrate (s - (t - tau)) vdot(s) by parts; the weight's integral is tau^2/2."""
    position, (elapsed, acceleration_deficit) = sp.Function("x"), sp.symbols("more A-vdot", positive=True)
    x_now, x_before, velocity = sp.symbols("x_s x_{s-1} v", real=True)
    by_parts = WEIGHT * sp.diff(position(s), s) - position(s)
    velocity_before = sp.Symbol("v(s)", real=True)
    at_end = WEIGHT.subs(s, t) * velocity - x_now
    at_start = WEIGHT.subs(s, t - tau) * velocity_before - x_before
    weighted_integral = at_end - at_start  # the integral of the weight times vdot
    return all_of(
        prove_identities(
            {
                "d/ds (weight x'(s) - x(s)) - weight x''(s)": sp.expand(
                    sp.diff(by_parts, s) - WEIGHT * sp.diff(position(s), s, 2)
                ),
                "(x_s - x_{s-1})/tau - v + integral/tau": sp.expand(
                    (x_now - x_before) / tau - velocity + weighted_integral / tau
                ),
                "A times the weight's integral, over tau, less A tau/2": sp.expand(
                    A * sp.integrate(WEIGHT, (s, t - tau, t)) / tau - A * tau / 2
                ),
            }
        ),
        prove_positive({"weight times (A - vdot)": WEIGHT.subs(s, t - tau + elapsed) * acceleration_deficit}),
    )


def stamped_bound(speed: Any, noise: Any, stamp_error: Any, measured_period: Any, true_period: Any) -> Any:
    """Return the bound on the error of v by differences, from noise in x, errors of time stamps, and vdot between samples."""
    return A * true_period**2 / (2 * measured_period) + 2 * speed * stamp_error / measured_period + 2 * noise / measured_period


def _prove_stamped() -> Outcome:
    """Prove that the bound less the error is positive; the other sign of the error follows by symmetry.

    v^ tau_s = x_s + n_0 - x_{s-1} - n_1 and x_s - x_{s-1} = tau v - integral. Let (tau - tau_s) v = |v| (2 delta - y), the
    integral be i - A tau^2/2, n_0 = eta - p and n_1 = r - eta.
    """
    speed, noise, stamp_error, measured_period, true_period = sp.symbols("|v| eta delta tau_s tau", positive=True)
    p, r, y, i = sp.symbols("p r y i", positive=True)
    error = (speed * (2 * stamp_error - y) - (i - A * true_period**2 / 2) + (noise - p) - (r - noise)) / measured_period
    margin = (speed * y + i + p + r) / measured_period
    return all_of(
        prove_identities(
            {
                "the bound - (v^ - v) - what it lacks": sp.expand(
                    stamped_bound(speed, noise, stamp_error, measured_period, true_period) - error - margin
                )
            }
        ),
        prove_positive({"what it lacks": margin}),
    )


PERIODS = (Fraction(1, 100), Fraction(11, 1000))  # s: the nominal one, and the true one


def _refute_nominal_period() -> Outcome:
    """Compute the error at v = 1 without acceleration where the true period is a tenth longer than the nominal one."""
    nominal_period, true_period = PERIODS
    speed, acceleration_bound = Fraction(1), Fraction(1)  # |vdot| = 0 is at most 1
    error, claimed = abs(speed * true_period / nominal_period - speed), acceleration_bound * max(PERIODS) / 2
    return refute_by_counterexample(
        "|v^ - v| <= A tau/2",
        f"v = 1, A = 1, periods {nominal_period} and {true_period} s",
        error > claimed,
        f"{error}, and {claimed}",
    )


STAMP_ERROR = Fraction(1, 1000)  # s, of a time stamp


def _refute_stamps_alone() -> Outcome:
    """Compute the error at v = 0 under vdot = A where both stamps shorten a period of 20 ms by STAMP_ERROR each."""
    true_period, acceleration = Fraction(1, 50), Fraction(2)
    error = acceleration * true_period**2 / 2 / (true_period - 2 * STAMP_ERROR)  # x_{s-1} = x_s + A tau^2/2
    claimed = acceleration * true_period / 2
    return refute_by_counterexample(
        "|v^ - v| <= A tau/2 + 2 |v| delta/tau_s",
        f"v = 0, vdot = 2, tau = {true_period}, delta = {STAMP_ERROR}", error > claimed,
        f"{error}, and {claimed}",
    )  # fmt: skip


def _prove_forward() -> Outcome:
    """Prove what feed-forward without delay leaves of the tube's motion, and how fast it changes.

    It cancels the middle's motion and leaves e Z'/2 at an edge, e = (a - b)/Z. Its rate is c''' - lambda (vdot - c''), so within
    tau it changes by at most tau (|c'''| + lambda (A + |c''|)).
    """
    middle = (v + lam * x) - (sp.diff(C, t) + lam * C)
    width_rate = sp.diff(a + b, t)
    remainder = sp.cancel(REST * (a + b)) + (a + b) * FEED_FORWARD
    jerk, curvature, acceleration, jerk_deficit, acceleration_deficit, curvature_deficit = sp.symbols(
        "|c'''| |c''| A p r y", positive=True
    )
    rate_bound = jerk + lam * (acceleration + curvature)
    rate = (jerk - jerk_deficit) - lam * (-(acceleration - acceleration_deficit) - (curvature - curvature_deficit))
    return all_of(
        prove_identities(
            {
                "(z - middle)' - (vdot - fed forward)": sp.expand(sp.diff(middle, t) - (q - FEED_FORWARD)),
                "(a + b)(rest + fed forward) + (a - b) Z'/2": sp.expand(remainder + (a - b) * width_rate / 2),
                "(fed forward)' - (c''' - lambda (vdot - c''))": sp.expand(
                    sp.diff(FEED_FORWARD, t) - (sp.diff(C, t, 3) - lam * (q - sp.diff(C, t, 2)))
                ),
            }
        ),
        prove_positive({"|c'''| + lambda (A + |c''|) - its rate": sp.expand(rate_bound - rate)}),
    )


JERK, WIDTH, PERIOD = sp.Integer(20), sp.Rational(1, 2), sp.Rational(1, 10)  # c''' of the cubic, W, and tau


def _refute_delayed_forward() -> Outcome:
    """Compute for one tube how strongly z is accelerated from its middle, with held feed-forward and without.

    Both edges move with the cubic c = J t^3/6, so Z = lambda W, and lambda = 1. x stays in the middle, and a sample of time
    -tau/2 acts until tau/2. Besides f + w and the law, the acceleration is -phi(t) without feed-forward phi, and
    phi(t_s) - phi(t) with it.
    """
    c = JERK * t**3 / 6
    feed_forward = FEED_FORWARD.subs({L: c - WIDTH / 2, R: c + WIDTH / 2, x: c, lam: 1}).doit()
    values = [feed_forward.subs(t, time) for time in (-PERIOD / 2, PERIOD / 2)]
    # c'' is linear in t, as the feed-forward is, so both are largest at an end.
    curvature = max(abs(sp.diff(c, t, 2).subs(t, time)) for time in (-PERIOD / 2, PERIOD / 2))
    without_feed_forward, with_feed_forward = max(map(abs, values)), abs(values[0] - values[1])
    bound_saved = curvature + (WIDTH + WIDTH) / 2  # |c''| + lambda (Z + lambda W)/2
    bound_added = PERIOD * (abs(JERK) + (curvature + curvature))  # tau (|c'''| + lambda (A + |c''|)) with A = |c''|
    return refute_by_counterexample(
        "held feed-forward takes away more than it adds",
        f"c = {JERK} t^3/6, W = {WIDTH}, lambda = 1, v = c', tau = {PERIOD}",
        sp.diff(feed_forward, t, 2) == 0 and with_feed_forward > without_feed_forward and bound_added > bound_saved,
        f"the middle is pushed by {without_feed_forward} at most without, by {with_feed_forward} with it; "
        f"of P_m the bounds are {bound_saved} and {bound_added}",
    )


LEMMAS = (
    Lemma("filtered.vdot", "For order 2 Vdot is the sum of xi_i eps_i (f + g u + w + rest)_i; the rest is lambda v less a mean "
          "of A' and B', and it is the mean of the exit inequality.",
          r"\dot\varepsilon = \xi(\dot v + \rho),\quad \rho = \lambda v - \frac{bA' + aB'}{a+b}", ("a, b > 0",), "ours",
          _prove_vdot, ("filtered.exit", "theorem.norms")),
    Lemma("filtered.bounded", "In the filtered tube v is bounded: between L' - lambda W and R' + lambda W.",
          r"L' - \lambda W < v < R' + \lambda W", ("a, b > 0", "L < x < R"), "ours", _prove_bounded, ("filtered.inside",)),
    Lemma("filtered.gain", "xi |eps| >= 4 |eps|/Z, by component.", r"\xi - \frac4Z = \frac{(a-b)^2}{abZ} \ge 0", ("a, b > 0",),
          "ours", _prove_gain),
    Lemma("filtered.forever", "Theorem 4.1 for order 2: any gain keeps z in the filtered tube and x in its tube, for ever.",
          r"|\varepsilon| \le \max\Bigl(|\varepsilon(0)|, \frac{Z_+\Phi}{4kg_{min}}\Bigr)",
          ("f, g continuous, locally Lipschitz in the state", "g_s >= g_min > 0 and |f + w + rest| <= Phi on the filtered tube",
           "0 < Z_min <= Z <= Z_+", "x(0) and z(0) inside", "no clamp reached", "u is continuous in time"), "ours",
          _prove_forever,
          ("sampled.first_exit", "filtered.inside", "filtered.bounded", "filtered.vdot", "filtered.pushed", "theorem.skew",
           "filtered.gain", "theorem.decrease")),
    Lemma(
        "filtered.saturated",
        "Where g min(u_max, what the law asks for at |eps| = E) is above P_x, |eps| < E stays: x in its tube, whatever u_max is.",
        r"g\,\min(u_{max}, 4 k q(E)/Z_+) > P_x \Rightarrow \dot\epsilon < 0\ \mathrm{at}\ \epsilon = E",
        ("u is continuous in time", "a, b > 0 and x in its tube at the start", "the lower edge by symmetry"),
        "ours",
        _prove_saturated,
        ("filtered.inside", "filtered.exit", "filtered.pushed"),
    ),
    Lemma("filtered.scaled", "Scaled u keeps |eps| < E for order 2 too, for any g with g_s >= g_min.",
          r"g_{min}u_{max} > |P_x|,\ k\,g_{min}\tfrac{4}{Z_+}q_n(E) > |P_x|"
          r" \Rightarrow \dot V < 0\ \mathrm{at}\ |\varepsilon| = E",
          ("as limits.scaled_stays", "x(0) inside"), "ours", _prove_scaled,
          ("limits.scaled_stays", "filtered.inside", "filtered.vdot", "filtered.pushed")),
    Lemma("filtered.differences", "Two samples of x say v up to A tau/2.",
          r"\frac{x_s - x_{s-1}}{\tau} = v - \frac1\tau\int_{t-\tau}^t (s-t+\tau)\,\dot v(s)\,ds,"
          r"\quad |\hat v - v| \le \frac{A\tau}2",
          ("|vdot| <= A between the samples", "tau is the time that went by"), "ours", _prove_differences),
    Lemma("filtered.stamped", "With noise eta in x and time stamps wrong by delta there are two more terms, and the true time.",
          r"|\hat v - v| \le \frac{A\tau^2}{2\tau_s} + \frac{2|v|\delta}{\tau_s} + \frac{2\eta}{\tau_s},"
          r"\quad \tau \le \tau_s + 2\delta",
          ("v^ is divided by tau_s, the measured time",), "ours", _prove_stamped, ("filtered.differences",)),
    Lemma("filtered.nominal_period", "Divided by the nominal period they say v as well.", r"|\hat v - v| \le \frac{A\tau}2",
          ("periods that vary", "tau the longest"), "as one might hope", _refute_nominal_period),
    Lemma("filtered.stamps_alone", "Time stamps wrong by delta add 2 |v| delta/tau_s and nothing else.",
          r"|\hat v - v| \le \frac{A\tau}2 + \frac{2|v|\delta}{\tau_s}", ("tau the true time", "no noise"), "as one might hope",
          _refute_stamps_alone),
    Lemma("filtered.forward", "c'' - lambda (v - c'), fed forward, takes the tube's motion away but for Z'; it changes no faster "
          "than |c'''| + lambda (A + |c''|), so what is left of one that is held is tau times that.",
          r"\varphi = c'' - \lambda(v - c'),\quad \dot\varphi = c''' - \lambda(\dot v - c''),"
          r"\quad |\varphi(t) - \varphi(t_s)| \le \tau(|c'''| + \lambda(A + |c''|))",
          ("g known", "|vdot| <= A"), "ours", _prove_forward, ("filtered.vdot", "filtered.middle", "sampled.integral")),
    Lemma("filtered.forward_held", "Held, such feed-forward never adds more to P_m within a period than it takes away.",
          r"\max|\varphi(t) - \varphi(t_s)| \le \max|\varphi(t)|", ("g known", "edges cubic in t"), "as one might hope",
          _refute_delayed_forward),
)  # fmt: skip
