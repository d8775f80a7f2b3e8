"""Lemmas about the worst path: the steps of the theorem of docs/sampling-path.md.

b is the distance to the edge that x approaches, Q the path, d = Q - b, y what acts of u, Y a bound on it, and gamma(y) = G y for
y > 0, g_min y else. book.py takes LEMMAS as a part of the family `path`; worst_path_evaluated.py is about the code.
"""

from __future__ import annotations

import sympy as sp

from stt_codegen.lemmas.law_slopes import prove_slope_bound
from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, prove_identities, prove_positive
from stt_codegen.lemmas.sampling.sampled import INPUT_OVER_GAIN, a, b

f, w, y, g, x, v, low, high, low_rate, high_rate, low_bend, high_bend = sp.symbols("f w y g x v L R L' R' L'' R''", real=True)
rate, F, S, P, d, cell = sp.symbols("lambda F S P d s", positive=True)
gamma, gamma_Y, Q, width, eta, near = sp.symbols("gamma gamma_Y Q W eta near", real=True)


def closing_rate(distance: sp.Expr, effect: sp.Expr) -> sp.Expr:
    """Return the largest speed at which an edge at this distance comes nearer; effect: gamma of what acts."""
    return P - rate * distance + effect


def drive_answer(start: sp.Expr, command: sp.Expr, lag: sp.Expr, time: sp.Expr) -> sp.Expr:
    """Return what a first-order lag makes of a constant command after a time, from `start` on."""
    return command + (start - command) * sp.exp(-time / lag)


def path_time(time: sp.Expr, theta: sp.Expr) -> sp.Expr:
    """Return the own time of the path that is at the start's distance at the time theta."""
    return time - theta


def cell_speed(at_begin: sp.Expr, rest: sp.Expr) -> sp.Expr:
    """Return the path's speed in a cell, from the speed that (2) asks for at its begin; rest: 1 - lambda h."""
    return at_begin / rest


def _prove_distance() -> Outcome:
    """Prove (1): what is left of P - lambda b + gamma(y) + b' is a sum of terms that the bounds make positive."""
    to_upper = high_rate - v + rate * (high - x)  # b of order 2
    velocity = f + w + g * y
    b_rate = high_bend - velocity + rate * (high_rate - v)
    a_rate = velocity - low_bend + rate * (v - low_rate)
    to_lower = v - low_rate + rate * (x - low)
    exit_rate = a_rate / to_lower - b_rate / to_upper
    expected = (velocity - low_bend - rate**2 * (x - low)) / to_lower + (velocity - high_bend + rate**2 * (high - x)) / to_upper
    at_order_2 = F + rate**2 * (high - low) - high_bend  # the part of P that (1) needs at the upper edge
    return prove_identities(
        {
            "order 1: P - lambda b + gamma + b' - [F - f - w] - [S + R'] - [gamma - g y], at lambda = 0": closing_rate(
                sp.Symbol("b"), gamma
            ).subs({P: F + S, rate: 0})
            + (high_rate - f - w - g * y)
            - ((F - f - w) + (S + high_rate) + (gamma - g * y)),
            "order 2: P - lambda b + gamma + b' - [F - f - w] - lambda^2 [x - L] - [gamma - g y]": sp.expand(
                closing_rate(to_upper, gamma).subs(P, at_order_2) + b_rate - ((F - f - w) + rate**2 * (x - low) + (gamma - g * y))
            ),
            "order 2: a'/a - b'/b has no lambda beside lambda^2": sp.simplify(exit_rate - expected),
        }
    )


def _prove_psi_rises() -> Outcome:
    """Prove that h(W - near, near) falls as near grows, by dh/da > 0 > dh/db, and that errors of a and b leave their sum.

    1 + y - ln y > 0 is a step of `sampled.pull`. A smaller W makes h smaller too, by dh/da.
    """
    slope = sp.diff(INPUT_OVER_GAIN.subs({a: width - near, b: near}), near)
    ratio = a / b
    return all_of(
        prove_identities(
            {
                "dh(W - near, near)/dnear + dh/da - dh/db": sp.simplify(
                    slope.subs({width: a + b, near: b}) + sp.diff(INPUT_OVER_GAIN, a) - sp.diff(INPUT_OVER_GAIN, b)
                ),
                "a^2 dh/da - (1 + a/b - ln(a/b))": sp.simplify(a**2 * sp.diff(INPUT_OVER_GAIN, a) - (1 + ratio - sp.log(ratio))),
                "b^2 dh/db + (1 + b/a + ln(a/b))": sp.simplify(
                    b**2 * sp.diff(INPUT_OVER_GAIN, b) + (1 + 1 / ratio + sp.log(ratio))
                ),
                "(a - eta) + (b + eta) - (a + b)": (a - eta) + (b + eta) - (a + b),
            }
        ),
        prove_slope_bound(),
    )


def _prove_drive() -> Outcome:
    """Prove that Y solves its equation in a cell, that weight on an older command makes the mean larger, and nu."""
    start, command, lag, time = sp.symbols("Y c T t", positive=True)
    answer = drive_answer(start, command, lag, time)
    older, younger, weight, moved = sp.symbols("c_older c_younger p m", positive=True)
    mean = younger * weight + older * (1 - weight)
    with_less_age = younger * (weight + moved) + older * (1 - weight - moved)
    positive, opposite, bound, overshoot = sp.symbols("Y+ nu U M", positive=True)
    slowest, quicker = sp.symbols("s_max q", positive=True)  # a drive that follows by s_max + q a second
    return prove_identities(
        {
            "Y' - (c - Y)/T": sp.simplify(sp.diff(answer, time) - (command - answer) / lag),
            "Y(0) - Y": answer.subs(time, 0) - start,
            "slew: (Y - y)(t) - (Y - y)(0) - q t, while both fall": sp.expand(
                (start - slowest * time) - (start - (slowest + quicker) * time) - quicker * time
            ),
            "mean less that with m moved to a younger command, less m (c_older - c_younger)": sp.expand(
                mean - with_less_age - moved * (older - younger)
            ),
            "(1 + nu) Y+ + nu U - (Y+ + nu (Y+ + U))": sp.expand(
                (1 + opposite) * positive + opposite * bound - (positive + opposite * (positive + bound))
            ),
            "nu = M + M nu at nu = M/(1 - M)": sp.simplify(
                overshoot + overshoot * overshoot / (1 - overshoot) - overshoot / (1 - overshoot)
            ),
        }
    )


def _prove_slides() -> Outcome:
    """Prove d' <= lambda d before the path's end, and that d e^(-lambda s) cannot leave 0 upwards."""
    b_now = sp.Symbol("b", real=True)
    path_rate, distance_rate = -closing_rate(Q, gamma_Y), -closing_rate(b_now, gamma)
    grown = sp.Function("d")(cell)
    return prove_identities(
        {
            "Q' - b' - lambda (Q - b) + (gamma(Y) - gamma(y))": sp.expand(
                path_rate - distance_rate - rate * (Q - b_now) + (gamma_Y - gamma)
            ),
            "(d e^(-lambda s))' - (d' - lambda d) e^(-lambda s)": sp.simplify(
                sp.diff(grown * sp.exp(-rate * cell), cell) - (sp.diff(grown, cell) - rate * grown) * sp.exp(-rate * cell)
            ),
        }
    )


def _prove_ends() -> Outcome:
    """Prove that after the end -b' <= lambda d: of P - lambda Q + gamma(Y) <= 0, and Y falls."""
    remainder, b_now = sp.Symbol("m", positive=True), sp.Symbol("b", real=True)
    bound = closing_rate(b_now, gamma)
    at_end = {P: rate * Q - gamma_Y - remainder}
    return all_of(
        prove_identities(
            {
                "P - lambda b + gamma(y) - lambda (Q - b) + (gamma(Y) - gamma(y)) + m": sp.expand(
                    bound.subs(at_end) - rate * (Q - b_now) + (gamma_Y - gamma) + remainder
                ),
                "1 - 2 Q/W at Q = W/(1 + e^E), less tanh(E/2)": sp.simplify(
                    1 - 2 / (1 + sp.exp(d)) - (sp.exp(d) - 1) / (sp.exp(d) + 1)
                ),
            }
        ),
        prove_positive({"m": remainder}),
    )


def _prove_early() -> Outcome:
    """Prove that a path whose own time 0 is at theta >= 0 is clipped wherever no sample need have arrived.

    The bound on a command at a time is Psi of the path at the own time less tau, and the sample is not older than that.
    """
    time, theta, latency, rest, age, later = sp.symbols("t theta l rest tau later", positive=True)
    return all_of(
        prove_identities(
            {
                "l - own time at t = l - rest, less rest + theta": latency - path_time(latency - rest, theta) - (rest + theta),
                "own time at t = -rest, before the start, plus rest + theta": path_time(-rest, theta) + (rest + theta),
                "own time of a sample less (own time of its command - tau) - later": path_time(time - age + later, theta)
                - (path_time(time, theta) - age)
                - later,
            }
        ),
        prove_positive({"l - own time": rest + theta, "a sample is younger than tau by": later}),
    )


def _prove_local() -> Outcome:
    """Prove that bounds over the last A seconds are enough: the untouched path ends, the sample and the drive pass within A."""
    t1, life, age, forget, margin, p = sp.symbols("t1 life tau forget margin p", positive=True)
    history = life + age + forget + margin
    slope = -p * (1 / a + 1 / b)
    return all_of(
        prove_identities(
            {
                "t1 - (t1 - A + life + tau + forget) - margin": sp.expand(t1 - (t1 - history + life + age + forget) - margin),
                "b' - lambda (b - Q) at P - lambda Q + gamma = 0": sp.expand(
                    -closing_rate(near, gamma).subs(P, rate * Q - gamma) - rate * (near - Q)
                ),
            }
        ),
        prove_positive({"margin": margin, "-eps' where P + gamma(y) <= -p": -slope}),
    )


def _prove_cells() -> Outcome:
    """Prove that a fall of h v, v = n/(1 - lambda h), is fast enough until a cell's end, where lambda Q is less by lambda h v."""
    at_begin, rest, gap, decay, added = sp.symbols("n r gap q m", positive=True)  # r = 1 - lambda h, gap = Y - c
    speed = cell_speed(at_begin, rest)
    x = sp.Symbol("x", positive=True)
    return all_of(
        prove_identities(
            {
                "v - (n + lambda h v)": sp.simplify(speed - (at_begin + (1 - rest) * speed)),
                "c + (Y - c)(q + m) - (c + (Y - c) q) - (Y - c) m": sp.expand(gap * (decay + added) - gap * decay - gap * added),
                "derivatives of e^x at 0, less 1": sum(
                    (sp.diff(sp.exp(x), x, j).subs(x, 0) - 1 for j in range(8)), sp.Integer(0)
                ),
            }
        ),
        prove_positive({"what a larger q adds to Y": gap * added, "what 8 terms of e^x leave out": x**8}),
    )


LEMMAS = (
    Lemma(
        "path.distance",
        "The distance b to the edge ahead falls at most at P - lambda b + gamma(y); eps falls where P + gamma(y) < 0.",
        r"-\dot b \le P - \lambda b + \gamma(y),\quad \dot\varepsilon \le (P+\gamma(y))(1/a+1/b)",
        ("|f + w| <= F, edges no faster than S; for order 2 R - x <= R - L", "g_min <= g <= G"),
        "ours",
        _prove_distance,
    ),
    Lemma(
        "path.psi_rises",
        "u at a state no farther from the edge than Q is at most Psi(Q), and Psi does not fall as Q rises.",
        r"b \le Q \Rightarrow u \le \Psi(Q) = "
        r"\max\bigl(-k\,h(W^- - Q - \eta, Q + \eta),\ -k\,h_{e_{max}}(W^+ + 2\eta),\ -u_{max}\bigr)",
        ("each measured distance is off by at most eta",),
        "ours",
        _prove_psi_rises,
        ("sampled.law", "sampled.pull", "sampled.shift"),
    ),
    Lemma(
        "path.drive",
        "What acts of commands that are at most c, which falls, is at most Y: Y' = (c - Y)/T, or Y' = -s_max while Y > c.",
        r"u \le c \Rightarrow y \le Y[c],\quad \dot Y = (c-Y)/T",
        ("weights of past commands have mass 1, and e^(-q/T) of them at most are older than q", "c does not rise in time"),
        "ours",
        _prove_drive,
    ),
    Lemma(
        "path.slides",
        "Where the path touches the distance of a run from above, it stays at or below it until the path's end.",
        r"d = Q - b \ge 0,\ \dot d \le \lambda d,\ d(s^*) = 0 \Rightarrow d = 0",
        ("y <= Y, so gamma(y) <= gamma(Y)", "Gronwall's inequality"),
        "ours",
        _prove_slides,
        ("path.distance", "path.psi_rises", "path.drive"),
    ),
    Lemma(
        "path.ends",
        "After the path's end the distance of a run that it touched does not fall below Q_pk; so |e| <= 1 - 2 Q_pk/W+.",
        r"P - \lambda Q_{pk} + \gamma(Y) \le 0 \Rightarrow \dot d \le \lambda d;\quad |e| \le 1 - 2Q_{pk}/W^+",
        ("Y falls",),
        "ours",
        _prove_ends,
        ("path.slides",),
    ),
    Lemma(
        "path.early",
        "A path that is at the start's distance at theta >= 0 bounds the commands before the first sample and those of samples.",
        r"s < l \Rightarrow s - \theta < l;\quad u(s) \le \Psi(Q_\theta(\sigma)) \le \Psi(Q_\theta(s-\tau))",
        ("commands before the first sample are 0", "the path goes on until it is at the start's distance"),
        "ours",
        _prove_early,
        ("path.psi_rises",),
    ),
    Lemma(
        "path.local",
        "Bounds over the last A seconds are enough: a path that touches no run has ended, and the drive forgot older commands.",
        r"A > life + \tau + forget \Rightarrow P + \gamma(y) < 0 \text{ before } t_1",
        ("the path of recent bounds ends only where P + gamma(Y) < 0; lambda Q_pk does not help",),
        "ours",
        _prove_local,
        ("path.slides", "path.ends", "path.distance"),
    ),
    Lemma(
        "path.cells",
        "In cells the path falls fast enough: by h v, v = (P - lambda Q + gamma(Y))/(1 - lambda h), with Y and c of the begin.",
        r"v = n + \lambda h v,\quad q \ge e^{-h/T}",
        ("lambda h < 1", "Y, c and Q fall in a cell"),
        "ours",
        _prove_cells,
        ("path.drive",),
    ),
)
