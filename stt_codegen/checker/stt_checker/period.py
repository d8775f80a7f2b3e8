"""P9: with an input that is held between samples the state stays in the tube. docs/certificate-format.md has the statement, the
lemma book its proof (sampled.*). rho_i is e^E_i: the claim is |e_i| < (rho_i - 1)/(rho_i + 1) at all times. For tasks with a
period."""

import itertools
from fractions import Fraction
from types import SimpleNamespace
from typing import Any, NamedTuple

from . import path
from .exact import logarithm, require
from .inertia import filtered_tube, widths
from .law import Law
from .limits import emitted_limits
from .tube import Tube

ZERO = Fraction(0)


class Window(NamedTuple):
    """One component during a segment, or from t_c on: the least and largest width of the tube that holds it, and how fast the
    tube's motion pushes it: at an edge, while a sample ages, and from the middle. Of order 1 all three are the faster edge's
    speed."""

    narrow: Fraction
    wide: Fraction
    at_edge: Fraction
    ageing: Fraction
    from_middle: Fraction


def windows(task: Any, tube: Tube, filters: list[Fraction]) -> list[list[Window]]:
    """Return every segment by component, and the time from t_c on, where a tube that repeats is again at its seam."""
    per = tube.segments / task.t_c
    if task.order == 1:
        segments = []
        for piece in tube.pieces:
            spans = [[(h - v) * tube.unit for v, h in zip(*edges, strict=True)] for edges in piece]
            speeds = [3 * max(abs(b - a) for e in edges for a, b in itertools.pairwise(e)) * per * tube.unit for edges in piece]
            segments.append([Window(min(s), max(s), v, v, v) for s, v in zip(spans, speeds, strict=True)])
        still = [Window((b - a) * tube.unit, (b - a) * tube.unit, ZERO, ZERO, ZERO) for a, b in tube.end]
        return [*segments, still if tube.seam is None else segments[tube.seam]]
    columns = list(zip(tube.pieces, *filtered_tube(task, tube, filters), strict=True))

    def window(k: int, per: Fraction) -> list[Window]:
        parts = zip(*columns[k], filters, strict=True)
        return [filtered_window(edges, z, demands, s, unit=tube.unit, per=per) for edges, z, demands, s in parts]

    segments = [window(k, per) for k in range(tube.segments)]
    return [*segments, window(tube.segments - 1, ZERO) if tube.seam is None else segments[tube.seam]]


def filtered_window(edges: Any, filtered: Any, demands: Any, s: Fraction, *, unit: Fraction, per: Fraction) -> Window:
    """Return a window of order 2, of one component with lambda s: from its edges in units, those of the filtered tube, and what
    its motion asks of u. per: segments a second; 0 from t_c on, where the tube stands still."""
    part = slice(0, 4) if per else slice(3, 4)
    z = [h - v for v, h in zip(*filtered, strict=True)][part]
    width = max([h - v for v, h in zip(*edges, strict=True)][part]) * unit
    low, high = (
        [6 * (c - 2 * b + a) * per**2 * unit for a, b, c in zip(e, e[1:], e[2:], strict=False)] for e in edges
    )  # L'', R''
    first, second = s * max(z), s * s * width
    return Window(
        min(z), max(z), max(*(max(c[part]) for c in demands), *high, *(-v for v in low)),
        max(first - min(low), second - min(high), first + max(high), second + max(low), ZERO),
        max(abs(a + b) for a, b in zip(low, high, strict=True)) / 2 + (first + second) / 2,
    )  # fmt: skip


def start_ratios(task: Any, tube: Tube, filters: list[Fraction]) -> list[Fraction]:
    """Return by component how large a/b and b/a are at most at the start: a and b are the distances to the edges."""
    smallest = (1 + task.share) / (1 - task.share)
    ratios, per_segment = [smallest] * task.n, tube.unit * tube.segments / task.t_c
    for i, s in enumerate(filters):  # order 2
        low, high = tube.pieces[0][i]
        width, rates = (high[0] - low[0]) * tube.unit, [3 * (e[1] - e[0]) * per_segment for e in (low, high)]
        for share, v in itertools.product(((1 - task.share) / 2, (1 + task.share) / 2), (task.speed[i], -task.speed[i])):
            a, b = v - rates[0] + s * share * width, rates[1] - v + s * (1 - share) * width
            require(min(a, b) > 0, "P9 does not hold: a start may be outside the filtered tube")
            ratios[i] = max(ratios[i], a / b, b / a)
    return ratios


def shifts(task: Any, tube: Tube, law: Law) -> list[Fraction]:
    """Return by component how far the position that the law sees in the tube may be off: by the edges' errors, x (and v) rounded
    to the scalar, noise, and for order 2 the roundings of a and b, 8 of numbers that are at most Z + 2 lambda W."""
    eps = Fraction(1, 1 << law.bits)
    if task.order == 1:
        return [2 * v + eps * task.farthest + task.noise(i)[0] for i, v in enumerate(law.edge_error)]
    edges, result, limit = filtered_tube(task, tube, law.filters)[0], [], emitted_limits(task, law.bits)
    for i, s in enumerate(law.filters):
        w = max(h - v for piece in tube.pieces for v, h in zip(*piece[i], strict=True)) * tube.unit
        (noise, noise_v), fastest, z = task.noise(i), tube.speed(i), max(widths(edges, i))
        if task.differs:
            force, _, g_max, cross = task.bounds(i)
            largest = [v * (1 + 2 * nu) for v, nu in zip(limit, task.drive.opposite, strict=True)]
            acceleration = force + g_max * largest[i] + cross * (sum(largest) - largest[i])
            noise_v = acceleration * task.period / 2 + 2 * (noise + eps * (task.farthest + noise)) / task.shortest
            noise_v += 4 * eps * (fastest + s * w + noise_v)
        rounding = eps * (s * task.farthest + fastest + s * w + 8 * (z + 2 * s * w))
        result.append(2 * (law.rate_error[i] + s * law.edge_error[i]) + rounding + noise_v + s * noise)
    return result


def prove_paths(task: Any, tube: Tube, law: Law, claims: Any, numbers: tuple[list[Fraction], ...]) -> list[Fraction]:
    """Prove P9 by worst paths, one claim by component. numbers: the claimed rho, u and shift. Return a bound on each |u_i|."""
    rho, u, shift = numbers
    drive, limit = task.drive, emitted_limits(task, law.bits)
    acting = [v * (1 + 2 * nu) for v, nu in zip(u, drive.opposite, strict=True)]
    segments, bounds, seam = windows(task, tube, law.filters), [], tube.seam
    order = [*range(len(segments))] if seam is None else [*range(tube.segments), *range(seam, tube.segments)]
    begins, ratios = [k * task.t_c / tube.segments for k in range(len(order))], start_ratios(task, tube, law.filters)
    for i in range(task.n):
        force, g_min, g_max, cross = task.bounds(i)
        force += cross * (sum(acting) - acting[i])
        narrowest = min(window[i].narrow for window in segments)
        bounds.append(largest_input(task, law, i, farthest_position(task, i, narrowest, rho[i], shift[i])))
        require(ratios[i] < rho[i] and g_min <= g_max, "P9 does not hold: rho is not above the start share, or g_min above g_max")
        smallest = (force + max(window[i].at_edge for window in segments)) / 50 or g_max * u[i] / 256  # so that every path ends
        rows = [(max(smallest, force + max(segments[max(k - 1, 0)][i].at_edge, w.at_edge)), w.narrow, w.wide)
                for k in order for w in [segments[k][i]]]  # fmt: skip
        shared = SimpleNamespace(
            g_min=g_min, g_max=g_max, u=u[i], filter_rate=law.filters[i] if law.filters else ZERO, gain=abs(law.gain[i]),
            limit=limit[i] if limit else u[i], shift=shift[i], rounding=law.rounding, e_max=task.e_max[i], rho=rho[i],
            age=task.period + task.latency, lags=drive.lags[i], slew=drive.slew[i], nu=drive.opposite[i], name=task.names[i],
        )  # fmt: skip
        path.prove(shared, rows, begins, (rows[0][1] / (1 + ratios[i]), task.latency), claims[i])
    return bounds


def prove(task: Any, tube: Tube, law: Law, rho: list[Fraction], shift: list[Fraction]) -> list[Fraction]:
    """Prove P9 window by window; a sample may stem from the window before. Return a bound on each |u_i|."""
    age, limit, r = task.period + task.latency, emitted_limits(task, law.bits), law.rounding
    require(age <= task.t_c / tube.segments, "P9 does not hold: a sample may be older than a segment")
    for smallest, e, e_max in zip(start_ratios(task, tube, law.filters), rho, task.e_max, strict=True):
        require(smallest < e <= (1 + e_max) / (1 - e_max), "P9 does not hold: rho is not between the start share and e_max")
    segments, largest = windows(task, tube, law.filters), [ZERO] * task.n
    for k, window in enumerate(segments):
        previous = segments[max(k - 1, 0)]
        narrowest = [min(a.narrow, b.narrow) for a, b in zip(window, previous, strict=True)]
        u = [largest_input(task, law, i, farthest_position(task, i, narrowest[i], rho[i], shift[i])) for i in range(task.n)]
        for i in range(task.n):
            narrow, wide = window[i][:2]
            force, g_min, g_max, cross = task.bounds(i)
            force += cross * (sum(u) - u[i])
            at_edge, ageing, from_middle = (force + max(a, b) for a, b in zip(window[i][2:], previous[i][2:], strict=True))
            where = f"({task.names[i]}, window {k})"
            require(g_min <= g_max, "P9 does not hold: g_min is above g_max")
            to_middle = narrow / 2 * ((rho[i] - 1) / (rho[i] + 1) - r)
            crosses = to_middle <= (from_middle + g_max * u[i]) * age + shift[i]
            require(not crosses, f"P9 does not hold: x may pass the middle of the tube between two samples {where}")
            require(not limit or g_min * limit[i] > at_edge, f"P9 does not hold: u_max is too small {where}")
            moved = ageing * age + shift[i]
            for d in (narrow, wide):
                a, b = d * rho[i] / (1 + rho[i]) - moved, d / (1 + rho[i]) + moved
                is_kept = a > b and abs(law.gain[i]) * (1 - r) * g_min * (1 / a + 1 / b) * (logarithm(a / b)[0] - r) > at_edge
                require(is_kept, f"P9 does not hold: the law does not push back enough {where}")
        largest = [max(a, b) for a, b in zip(largest, u, strict=True)]
    return largest


def prove_guard(task: Any, tube: Tube, law: Law, rho: list[Fraction], shift: list[Fraction]) -> None:
    """Require that a state in the tube is never measured outside, where `outside` acts on that. Of order 2, y = x - L has y' = b
    - s y for the distance b of v + s x: it is never below the smaller one of its start and b/s."""
    segments = windows(task, tube, law.filters)
    for i, name in enumerate(task.names):
        nearest, (low, high) = min(window[i].narrow for window in segments) / (1 + rho[i]), tube.start[i]
        nearest = min([nearest, *(s * (1 - task.share) / 2 * (high - low) * tube.unit for s in law.filters[i : i + 1])])
        is_quiet = task.outside == "return" or nearest > shift[i]
        require(is_quiet, f"P9 does not hold: the guard may act inside the tube, by noise of {name}")


def farthest_position(task: Any, i: int, width: Fraction, rho: Fraction, shift: Fraction) -> tuple[Fraction, Fraction]:
    """Return the distances to the farther and to the nearer edge at the farthest position that the law may see, or where it is
    clamped. The nearer one may be negative: then the law may see a position outside."""
    far, near, share = width * rho / (1 + rho) + shift, width / (1 + rho) - shift, (1 - task.e_max[i]) / 2
    if near <= (far + near) * share:  # the clamp acts
        far, near = (1 - share) * (width - 2 * shift), share * (width - 2 * shift)
    return far, near


def largest_input(task: Any, law: Law, i: int, position: tuple[Fraction, Fraction]) -> Fraction:
    """Return a bound on |u_i| of the law at a position, and of its limit."""
    (far, near), r, limit = position, law.rounding, emitted_limits(task, law.bits)[i : i + 1]
    require(near > 0 or bool(limit), "P9 does not hold: the law may see a position beyond the tube")
    pull = abs(law.gain[i]) * (1 / far + 1 / near) * (logarithm(far / near)[1] + r) * (1 + r) if near > 0 else limit[0]
    return min([pull, *limit])
