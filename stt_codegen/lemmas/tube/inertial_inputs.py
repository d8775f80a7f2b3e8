"""Plants of order 2: no bounds known and any gain, coupled inputs scaled, velocity by differences, feed-forward that is held.

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
SLOWEST, FASTEST = (sp.diff(L, t) - lam * (R - L), sp.diff(R, t) + lam * (R - L))  # v is between them
PULL = 4 / (far + near)  # of xi, at least
STAYS = Z * Phi / (4 * k * g_min)  # |eps| does not pass it
WEIGHT = s - (t - tau)  # of vdot(s) in what two samples of x say of v
C = (L + R) / 2
FORWARD = sp.diff(C, t, 2) - lam * (v - sp.diff(C, t))  # fed forward, for g = ghat


def _prove_vdot() -> Outcome:
    """d ln(a/b)/dt = a'/a - b'/b = xi (a' b - b' a)/(a + b); the mean of the exit inequality is the same rest, written anew."""
    rates = sp.diff(a, t) * b - sp.diff(b, t) * a  # epsdot a b
    rest = sp.cancel(REST * (a + b))
    exit_mean = a * (lam**2 * b0 - sp.diff(R, t, 2)) + b * (-sp.diff(L, t, 2) - lam**2 * a0)
    return prove_identities(
        {
            "(a'/a - b'/b) a b - (a + b)(vdot + rest)": sp.expand(rates - (a + b) * q - rest),
            "(a + b) rest - (a + b) times the mean of the exit inequality": sp.expand(rest - exit_mean),
        }
    )


def _prove_bounded() -> Outcome:
    """What v lacks of both bounds is a distance of z and lambda times one of x. The solution has no other way to infinity."""
    distances = sp.symbols("a b x-L R-x", positive=True)
    return all_of(
        prove_identities(
            {
                "R' + lambda W - v - (b + lambda (x - L))": sp.expand(FASTEST - v - (b + lam * a0)),
                "v - L' + lambda W - (a + lambda (R - x))": sp.expand(v - SLOWEST - (a + lam * b0)),
            }
        ),
        prove_positive(
            {"b + lambda (x - L)": distances[1] + lam * distances[2], "a + lambda (R - x)": distances[0] + lam * distances[3]}
        ),
    )


def asked_at(e: Any, width: Any) -> Any:
    """What the law asks for over k at eps = E: 4 q(E)/Z, q(E) = E cosh(E/2)^2."""
    return 4 * e * sp.cosh(e / 2) ** 2 / width


def _prove_saturated() -> Outcome:
    """At a/b = e^E the law asks for 4 k q(E)/Z, at most Z_+ wide no less than 4 k q(E)/Z_+. With g |u| = P_x + room, f + w = F -
    s_F and the mean of the exit inequality M - s_m, P_x = F + M: eps' a b/(a + b) is below 0, against eps < E before."""
    e, more, room, lack_f, lack_m, force, mean = sp.symbols("E Z_+-Z room s_F s_m F M", positive=True)
    upper, lower = Z / (1 + sp.exp(-e)), Z / (1 + sp.exp(e))
    asked = asked_at(e, Z)
    law = (1 / upper + 1 / lower) * e
    rises = (force - lack_f) - (force + mean + room) + (mean - lack_m)
    less = asked * more / (Z + more)
    return all_of(
        prove_identities(
            {
                "h at a/b = e^E, less 4 q/Z": sp.simplify((law - asked.rewrite(sp.exp)).expand()),
                "4 q/Z - 4 q/Z_+": sp.together(asked - asked_at(e, Z + more) - less),
                "eps' a b/(a + b)": sp.expand(rises + room + lack_f + lack_m),
            }
        ),
        prove_positive(
            {"4 q/Z - 4 q/Z_+": less.subs(sp.cosh(e / 2), sp.Symbol("cosh", positive=True)), "room": room + lack_f + lack_m}
        ),
    )


def _prove_gain() -> Outcome:
    """1/a + 1/b less 4/(a + b) is a square over positive numbers."""
    xi = 1 / far + 1 / near
    return prove_identities(
        {"xi - 4/(a + b) - (a - b)^2/(a b (a + b))": sp.cancel(xi - PULL - (far - near) ** 2 / (far * near * (far + near)))}
    )


def _prove_forever() -> Outcome:
    """Beyond the bound y = |xi eps| = 4 |eps|/Z + more is above Phi/(k g_min), so Vdot <= -k g_min y^2 + y Phi < 0. And while
    |eps| <= E neither a nor b comes near 0, so the solution does not end."""
    beyond, more, narrow, wider, grown, less = sp.symbols("beyond more Z_min wider e^E-1 less", positive=True)
    size = 4 * (STAYS + beyond) / Z + more
    falls = k * g_min * (4 * beyond / Z + more)
    nearer = (narrow + wider) / (1 + (1 + grown) / (1 + less))  # b = Z/(1 + e^eps) for any Z >= Z_min, eps <= E
    room = sp.cancel(nearer - narrow / (2 + grown))
    return all_of(
        prove_identities(
            {"Vdot's bound, plus y times what it falls": sp.expand(-k * g_min * size**2 + size * Phi + size * falls)}
        ),
        prove_positive({"what it falls": falls, "b - Z_min/(1 + e^E)": sp.factor(room)}),
    )


def _prove_scaled() -> Outcome:
    """As for order 1, with the rest of filtered.vdot in the place of the mean of edge rates: P_x bounds it by component."""
    return saturated.prove_scaled_stays()


def _prove_differences() -> Outcome:
    """x(t - tau) = x - tau v + the integral of (s - (t - tau)) vdot(s); the weight's integral is tau^2/2. By parts."""
    place, more, slack = sp.Function("x"), sp.Symbol("more", positive=True), sp.Symbol("A-vdot", positive=True)
    now, before, rate = sp.symbols("x_s x_{s-1} v", real=True)
    by_parts = WEIGHT * sp.diff(place(s), s) - place(s)
    value = sp.Symbol("v(s)", real=True)
    at_end = WEIGHT.subs(s, t) * rate - now
    at_start = WEIGHT.subs(s, t - tau) * value - before
    bent = at_end - at_start  # the integral of the weight times vdot
    return all_of(
        prove_identities(
            {
                "d/ds (weight x'(s) - x(s)) - weight x''(s)": sp.expand(sp.diff(by_parts, s) - WEIGHT * sp.diff(place(s), s, 2)),
                "(x_s - x_{s-1})/tau - v + integral/tau": sp.expand((now - before) / tau - rate + bent / tau),
                "A times the weight's integral, over tau, less A tau/2": sp.expand(
                    A * sp.integrate(WEIGHT, (s, t - tau, t)) / tau - A * tau / 2
                ),
            }
        ),
        prove_positive({"weight times (A - vdot)": WEIGHT.subs(s, t - tau + more) * slack}),
    )


def stamped_bound(speed: Any, noise: Any, late: Any, measured: Any, true: Any) -> Any:
    """What v by differences is wrong by at most: noise in x, time stamps wrong by `late`, and what vdot does meanwhile."""
    return A * true**2 / (2 * measured) + 2 * speed * late / measured + 2 * noise / measured


def _prove_stamped() -> Outcome:
    """v^ tau_s = x_s + n_0 - x_{s-1} - n_1 and x_s - x_{s-1} = tau v - integral. What the error lacks of the bound is positive,
    with (tau - tau_s) v = |v| (2 delta - y), the integral i - A tau^2/2, n_0 = eta - p, n_1 = r - eta. By symmetry the other
    sign."""
    speed, noise, late, measured, true = sp.symbols("|v| eta delta tau_s tau", positive=True)
    p, r, y, i = sp.symbols("p r y i", positive=True)
    error = (speed * (2 * late - y) - (i - A * true**2 / 2) + (noise - p) - (r - noise)) / measured
    lacks = (speed * y + i + p + r) / measured
    return all_of(
        prove_identities(
            {"the bound - (v^ - v) - what it lacks": sp.expand(stamped_bound(speed, noise, late, measured, true) - error - lacks)}
        ),
        prove_positive({"what it lacks": lacks}),
    )


PERIODS = (Fraction(1, 100), Fraction(11, 1000))  # the nominal one, and one that was


def _refute_nominal_period() -> Outcome:
    """Without any acceleration, at v = 1, and a period that is a tenth longer for once."""
    nominal, true = PERIODS
    speed, bound = Fraction(1), Fraction(1)  # |vdot| = 0 is at most 1
    error, claimed = abs(speed * true / nominal - speed), bound * max(PERIODS) / 2
    return refute_by_counterexample(
        "|v^ - v| <= A tau/2", f"v = 1, A = 1, periods {nominal} and {true} s", error > claimed, f"{error}, and {claimed}"
    )


LATE = Fraction(1, 1000)  # of a time stamp


def _refute_stamps_alone() -> Outcome:
    """At v = 0 under vdot = A both stamps shorten a period of 20 ms by LATE each."""
    true, most = Fraction(1, 50), Fraction(2)
    error = most * true**2 / 2 / (true - 2 * LATE)  # x_{s-1} = x_s + A tau^2/2
    claimed = most * true / 2
    return refute_by_counterexample(
        "|v^ - v| <= A tau/2 + 2 |v| delta/tau_s", f"v = 0, vdot = 2, tau = {true}, delta = {LATE}", error > claimed,
        f"{error}, and {claimed}",
    )  # fmt: skip


def _prove_forward() -> Outcome:
    """Fed forward without delay it takes all from the middle's motion and leaves e Z'/2 at an edge, e = (a - b)/Z. Its own rate
    is c''' - lambda (vdot - c''), so within tau it changes by tau (|c'''| + lambda (A + |c''|)) at most."""
    middle = (v + lam * x) - (sp.diff(C, t) + lam * C)
    widens = sp.diff(a + b, t)
    left = sp.cancel(REST * (a + b)) + (a + b) * FORWARD
    jerk, bend, force, less, lesser, least = sp.symbols("|c'''| |c''| A p r y", positive=True)
    claimed = jerk + lam * (force + bend)
    rate = (jerk - less) - lam * (-(force - lesser) - (bend - least))
    return all_of(
        prove_identities(
            {
                "(z - middle)' - (vdot - fed forward)": sp.expand(sp.diff(middle, t) - (q - FORWARD)),
                "(a + b)(rest + fed forward) + (a - b) Z'/2": sp.expand(left + (a - b) * widens / 2),
                "(fed forward)' - (c''' - lambda (vdot - c''))": sp.expand(
                    sp.diff(FORWARD, t) - (sp.diff(C, t, 3) - lam * (q - sp.diff(C, t, 2)))
                ),
            }
        ),
        prove_positive({"|c'''| + lambda (A + |c''|) - its rate": sp.expand(claimed - rate)}),
    )


JERK, WIDTH, SPAN = sp.Integer(20), sp.Rational(1, 2), sp.Rational(1, 10)  # of a cubic edge, W, and the period


def _refute_forward_held() -> Outcome:
    """Both edges move with the cubic c = J t^3/6, so Z = lambda W; lambda = 1. x stays in the middle. A sample at -tau/2 acts
    until tau/2. What pushes z from its middle, besides f + w and the law: -fed forward(t) without; with it fed forward(t_s) less
    that."""
    c = JERK * t**3 / 6
    fed = FORWARD.subs({L: c - WIDTH / 2, R: c + WIDTH / 2, x: c, lam: 1}).doit()
    ends = [fed.subs(t, when) for when in (-SPAN / 2, SPAN / 2)]
    bends = max(abs(sp.diff(c, t, 2).subs(t, when)) for when in (-SPAN / 2, SPAN / 2))  # linear in t, as fed forward is
    without, with_it = max(map(abs, ends)), abs(ends[0] - ends[1])
    saved = bends + (WIDTH + WIDTH) / 2  # |c''| + lambda (Z + lambda W)/2
    stale = SPAN * (abs(JERK) + (bends + bends))  # tau (|c'''| + lambda (A + |c''|)); A is at least |c''|, which is |vdot| here
    return refute_by_counterexample(
        "held feed-forward takes away more than it adds",
        f"c = {JERK} t^3/6, W = {WIDTH}, lambda = 1, v = c', tau = {SPAN}",
        sp.diff(fed, t, 2) == 0 and with_it > without and stale > saved,
        f"the middle is pushed by {without} at most without, by {with_it} with it; of P_m the bounds are {saved} and {stale}",
    )


LEMMAS = (
    Lemma("filtered.vdot", "For order 2 Vdot is the sum of xi_i eps_i (f + g u + w + rest)_i; the rest is lambda v less a mean "
          "of A' and B', and it is the mean of the exit inequality.",
          r"\dot\varepsilon = \xi(\dot v + \rho),\quad \rho = \lambda v - \frac{bA' + aB'}{a+b}", ("a, b > 0",), "ours", _prove_vdot,
          ("filtered.exit", "theorem.norms")),
    Lemma("filtered.bounded", "In the filtered tube v is bounded: between L' - lambda W and R' + lambda W.",
          r"L' - \lambda W < v < R' + \lambda W", ("a, b > 0", "L < x < R"), "ours", _prove_bounded, ("filtered.inside",)),
    Lemma("filtered.gain", "xi |eps| >= 4 |eps|/Z, by component.", r"\xi - \frac4Z = \frac{(a-b)^2}{abZ} \ge 0", ("a, b > 0",),
          "ours", _prove_gain),
    Lemma("filtered.forever", "Theorem 4.1 for order 2: any gain keeps z in the filtered tube and x in its tube, for ever.",
          r"|\varepsilon| \le \max\Bigl(|\varepsilon(0)|, \frac{Z_+\Phi}{4kg_{min}}\Bigr)",
          ("f, g continuous, locally Lipschitz in the state", "g_s >= g_min > 0 and |f + w + rest| <= Phi on the filtered tube",
           "0 < Z_min <= Z <= Z_+", "x(0) and z(0) inside", "no clamp reached", "u is continuous in time"), "ours", _prove_forever,
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
          _refute_forward_held),
)  # fmt: skip
