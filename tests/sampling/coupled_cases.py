"""Laws of formulas outside the sampling conditions: hints for Coq, lost turns, velocities by differences, and P8.

Each function `.._agree` computes a formula a second time from its definition, for plants whose inputs are coupled, and returns whether
the package agrees. test_one_formula.py calls them, with the package's formulas and with a wrong term in each."""

from __future__ import annotations

import functools
import itertools
import math
import random
from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

from stt_codegen import constraints
from stt_codegen.certify.sampled.lost_turns import lost_turn
from stt_codegen.designs import RefinedDesign
from stt_codegen.sampling.order_two import difference_error
from stt_codegen.task import DriveBounds, Task
from stt_codegen.task.schema import ComponentBounds
from stt_codegen.theorem import hints
from stt_codegen.theorem.facts import SampledFacts

SEGMENTS = 4
BITS = 12  # of the tables


def draw_fraction(draw: random.Random, low: float, high: float) -> Fraction:
    """Return a random multiple of 2^-20 in this range, which a double represents exactly."""
    return Fraction(math.floor(draw.uniform(low, high) * 2**20), 2**20)


def moving_design(draw: random.Random, n: int, seconds: Fraction = Fraction(40)) -> RefinedDesign:
    """Return a tube that moves, and whose width changes from segment to segment; it rests at its end."""
    table = []
    for _ in range(SEGMENTS + 3):
        lows = [round(2**BITS * draw.uniform(0, 0.02)) for _ in range(n)]
        table.append(tuple((low, low + round(2**BITS * draw.uniform(0.09, 0.11))) for low in lows))
    return RefinedDesign(seconds, SEGMENTS, BITS, (*table[:-1], table[-3]))


@dataclass(frozen=True)
class WindowByHand:
    """Numbers of one component in one window of time.

    narrow, wide: its smallest and largest width there. narrowest, broadest: the same with the window before. speed: of the faster edge."""

    narrow: Fraction
    wide: Fraction
    narrowest: Fraction
    broadest: Fraction
    speed: Fraction


def windows_by_hand(design: RefinedDesign, i: int) -> list[WindowByHand]:
    """Return the windows of a component, computed from the control points; the last one is the time from t_c on."""
    edges, per_second = [], Fraction(3 * design.segments) / design.prescribed_time
    for k in range(design.segments):
        points = [design.table[k + j][i] for j in range(4)]
        edge_pair = []
        for a, b, c, d in zip(*points, strict=True):
            edge_pair.append([a + 4 * b + c, 4 * b + 2 * c, 2 * b + 4 * c, b + 4 * c + d])
        edges.append(edge_pair)
    edges.append([[edge[3]] * 4 for edge in edges[-1]])
    widths = [[(b - a) * design.unit for a, b in zip(low, high, strict=True)] for low, high in edges]
    steps = [max(abs(b - a) for edge in pair for a, b in itertools.pairwise(edge)) * design.unit for pair in edges]
    result = []
    for k, width in enumerate(widths):
        before = max(k - 1, 0)
        narrowest, broadest = min(*width, *widths[before]), max(*width, *widths[before])
        speed = max(steps[k], steps[before]) * per_second
        result.append(WindowByHand(min(width), max(width), narrowest, broadest, speed))
    return result


# ------------------------------------------------------------------------------------------------ hints for Coq


def inputs_by_hand(facts: Any, sampling: SampledFacts) -> list[list[float]]:
    """Return the bound U on |u| by window and component, by the definition of `input_max_check` in proof/Period.v."""
    columns = []
    for i, rho in enumerate(map(float, sampling.rho)):
        column = []
        for window in windows_by_hand(facts.design, i):
            width, shift, law_error = float(window.narrowest), float(sampling.shift[i]), float(sampling.law_error)
            near, far = width / (1 + rho) - shift, width * rho / (1 + rho) + shift
            u = float(facts.gain[i]) * (1 / near + 1 / far) * (math.log(far / near) + law_error) * (1 + law_error)
            column.append(u if facts.u_max is None else min(u, float(facts.u_max[i])))
        columns.append(column)
    return [list(row) for row in zip(*columns, strict=True)]


def coq_accepts(facts: Any, sampling: SampledFacts, cell_count: int) -> bool:
    """Return whether `window_check` of proof/Period.v accepts every window, computed in floating point."""
    tau, law_error, inputs = float(sampling.period + sampling.latency), float(sampling.law_error), inputs_by_hand(facts, sampling)
    for i, rho in enumerate(map(float, sampling.rho)):
        g_min, g_max, shift, gain = (float(v[i]) for v in (sampling.g_min, sampling.g_max, sampling.shift, facts.gain))
        for window, u in zip(windows_by_hand(facts.design, i), inputs, strict=True):
            coupling = float(sampling.g_cross[i]) * sum(v for j, v in enumerate(u) if j != i)
            closing_speed = float(sampling.disturbance[i] + window.speed) + coupling
            half_width = float(window.narrow) * (rho - 1) / (rho + 1) - 2 * (closing_speed + g_max * u[i]) * tau
            if 2 * shift + law_error * (float(window.broadest) + 2 * shift) >= half_width:
                return False
            if facts.u_max is not None and closing_speed > g_min * float(facts.u_max[i]):
                return False
            drift = closing_speed * tau + g_max * u[i] * float(sampling.latency) + shift
            low, high = float(window.narrow), float(window.wide)
            for k in range(cell_count):
                begin, end = (low + (high - low) * j / cell_count for j in (k, k + 1))
                a, b, b_at_end = begin * rho / (1 + rho) - drift, begin / (1 + rho) + drift, end / (1 + rho) + drift
                if (
                    a <= b
                    or g_min * gain / b_at_end * (1 + b / a) * (1 - law_error) * (math.log(a / b) - law_error) <= closing_speed
                ):
                    return False
    return True


def with_period(sampling: SampledFacts, period: Fraction) -> SampledFacts:
    """Return the sampling data with another period."""
    return SampledFacts(**{**vars(sampling), "period": period})


@functools.cache
def coq_cases() -> list[tuple[Any, SampledFacts]]:
    """Return random loops, each with nearly the longest period that Coq accepts with the finest cells; loops without one are skipped."""
    draw, cases = random.Random(7), []
    for is_limited, is_late in list(itertools.product((False, True), repeat=2)) * 12:
        share = draw.choice((0.4, 0.6, 0.8))
        rho = tuple(draw_fraction(draw, 0.98, 1) * (1 + Fraction(share)) / (1 - Fraction(share)) for _ in range(2))
        typical = Fraction(round(0.07 * 0.6 / ((1 + rho[0]) * (1 + 1 / rho[0]) * Fraction(math.log(rho[0]))) * 2**20), 2**20)
        facts = SimpleNamespace(
            n=2,
            design=moving_design(draw, 2),
            gain=tuple(draw_fraction(draw, 1.1, 4) * typical for _ in range(2)),  # a little or much more than the conditions need
            e_max=(Fraction(9, 10),) * 2,
            u_max=tuple(draw_fraction(draw, 0.3, 0.8) for _ in range(2)) if is_limited else None,
        )
        sampling = SampledFacts(
            period=Fraction(1, 1000),
            latency=draw_fraction(draw, 0.005, 0.02) if is_late else Fraction(0),
            share=Fraction(share) - Fraction(1, 10),
            disturbance=tuple(draw_fraction(draw, 0.02, 0.05) for _ in range(2)),
            g_min=tuple(draw_fraction(draw, 0.7, 0.9) for _ in range(2)),
            g_max=tuple(draw_fraction(draw, 1, 1.3) for _ in range(2)),
            g_cross=tuple(draw_fraction(draw, 0.02, 0.06) for _ in range(2)),
            rho=rho,
            shift=tuple(draw_fraction(draw, 0.001, 0.003) for _ in range(2)),
            law_error=Fraction(1, 256),
            noise=Fraction(0),
        )
        if coq_accepts(facts, sampling, hints.CELL_COUNTS[-1]):
            cases.append((facts, with_period(sampling, longest_by_hand(facts, sampling))))
    return cases


def longest_by_hand(facts: Any, sampling: SampledFacts) -> Fraction:
    """Return the longest period, up to 4 s and by bisection, that Coq accepts with the finest cells."""
    low, high = sampling.period, Fraction(4)
    for _ in range(20):
        middle = (low + high) / 2
        low, high = (middle, high) if coq_accepts(facts, with_period(sampling, middle), hints.CELL_COUNTS[-1]) else (low, middle)
    return low


def with_limits(facts: Any, factor: Fraction) -> Any:
    """Return the loop with its limits on u multiplied by a factor."""
    return SimpleNamespace(**{**vars(facts), "u_max": tuple(factor * v for v in facts.u_max)})


def limits_agree(facts: Any, sampling: SampledFacts) -> bool:
    """Return whether the hints hold just above the smallest u_max that Coq accepts, and fail just below it."""
    low, high = Fraction(0), Fraction(1)
    for _ in range(20):
        middle = (low + high) / 2
        low, high = (low, middle) if coq_accepts(with_limits(facts, middle), sampling, hints.CELL_COUNTS[-1]) else (middle, high)
    smaller, larger = (with_limits(facts, high * (1000 + k) / 1000) for k in (-2, 2))
    return hints.is_period_proved(larger, sampling) and not hints.is_period_proved(smaller, sampling)


def cells_by_hand(facts: Any, sampling: SampledFacts) -> int | None:
    """Return the smallest number of cells that Coq needs; None where a period shorter or longer by a thousandth needs another."""
    counts = {
        next(
            (m for m in hints.CELL_COUNTS if coq_accepts(facts, with_period(sampling, sampling.period * (1000 + k) / 1000), m)), 0
        )
        for k in (-1, 0, 1)
    }
    return counts.pop() if len(counts) == 1 else None


def hints_agree() -> bool:
    """Return whether bounds on |u| are just above the second computation, and periods are accepted up to the longest one by hand."""
    compared = 0
    for facts, longest in coq_cases():
        rows = hints.input_hints(facts, longest)
        pairs = [(float(u), v) for row, values in zip(rows, inputs_by_hand(facts, longest), strict=True)
                 for (u, _), v in zip(row, values, strict=True)]  # fmt: skip
        if any(not v * (1 - 1e-9) <= u <= v * (1 + 1e-3) for u, v in pairs):
            return False
        shorter, longer = (with_period(longest, longest.period * (1000 + k) / 1000) for k in (-2, 2))
        if not hints.is_period_proved(facts, shorter) or hints.is_period_proved(facts, longer):
            return False
        if facts.u_max is not None and not limits_agree(facts, with_period(longest, longest.period / 2)):
            return False
        for share in (Fraction(1, 2), Fraction(3, 4), Fraction(9, 10)):
            sampling = with_period(longest, longest.period * share)
            if count := cells_by_hand(facts, sampling):
                compared += 1
                if hints.smallest_cell_count(facts, sampling, hints.input_hints(facts, sampling)) != count:
                    return False
    return compared > 10


# ------------------------------------------------------------------------------------------------ bounds for stated plants


class TaskNumbers(SimpleNamespace):
    """The numbers of a task that the formulas read; it derives further numbers with the methods of `Task`."""

    coupling_of = Task.coupling_of
    largest_derivative = Task.largest_derivative

    @property
    def drive_bounds(self) -> tuple[DriveBounds, ...]:
        """Drives that act at once."""
        return (DriveBounds(Fraction(0), Fraction(0), None, Fraction(0)),) * self.dimension


def coupled_task(draw: random.Random, n: int, **numbers: Any) -> Any:
    """Return random plant bounds and limits for n components, with further numbers of a task."""
    bounds = [
        ComponentBounds(*(draw_fraction(draw, *ends) for ends in ((0.1, 0.5), (0.7, 0.9), (1, 1.3), (0.05, 0.2))))
        for _ in range(n)
    ]
    inputs = tuple(draw_fraction(draw, 1, 2) for _ in range(n))
    common = {"dimension": n, "plant_bounds": tuple(bounds), "emitted_u_max": inputs, "scales_input": False}
    return TaskNumbers(**common, **numbers)


def derivatives_by_hand(task: Any, inputs: Sequence[Fraction]) -> list[Fraction]:
    """Return the largest speed of each component, with these bounds on |u|."""
    result = []
    for i, bounds in enumerate(task.plant_bounds):
        coupling = sum((bounds.cross * u for j, u in enumerate(inputs) if j != i), Fraction(0))
        result.append(bounds.force + bounds.g_max * inputs[i] + coupling)
    return result


def lost_turns_agree() -> bool:
    """Return whether the largest motion of an axis in a period agrees: the smaller of two bounds, by the tube and by the plant."""
    draw, plant_bound_count = random.Random(8), 0
    for k in range(30):
        n, order = 1 + k % 3, 1 + k % 2
        design = moving_design(draw, n, Fraction(8))
        design = RefinedDesign(
            **{
                **fields_without_filter(design),
                "filter": tuple(draw_fraction(draw, 0.5, 4) for _ in range(n)) if order == 2 else (),
            }
        )
        task = coupled_task(draw, n, order=order, prescribed_time=design.prescribed_time)
        period = draw_fraction(draw, 0.01, 0.6)
        u = [Fraction(draw.randint(8, 16), 8) for _ in range(n)]  # the certificate states these numbers without rounding
        for i in range(n):
            windows = windows_by_hand(design, i)
            width, speed = max(w.wide for w in windows), max(w.speed for w in windows)
            rate = derivatives_by_hand(task, u)[i] if order == 1 else speed + design.filter[i] * width
            motion = min(width + speed * period, rate * period)
            plant_bound_count += order == 1 and motion == rate * period
            task.closed_axes = [SimpleNamespace(index=i, largest_step=motion)]
            lost = lost_turn(task, design, SimpleNamespace(u=u, period=period))  # type: ignore[arg-type]
            if lost is None or (lost.axis, lost.motion, lost.allowed) != (i, motion, motion):
                return False
    return plant_bound_count > 5


def fields_without_filter(design: RefinedDesign) -> dict[str, Any]:
    """Return the fields of a design without its filter."""
    return {name: getattr(design, name) for name in ("prescribed_time", "segments", "bits", "table")}


def difference_errors_agree() -> bool:
    """Return whether the error of a velocity by differences agrees: by the motion between samples, noise and rounding."""
    draw = random.Random(9)
    for k in range(20):
        n = 1 + k % 3
        task = coupled_task(
            draw, n, emit=SimpleNamespace(scalar="float"), sampling_period=draw_fraction(draw, 0.01, 0.02),
            shortest_period=draw_fraction(draw, 0.005, 0.01), largest_coordinate=Fraction(7),
        )  # fmt: skip
        factor, roundoff = draw_fraction(draw, 1, 1.1), Fraction(1, 1 << 24)
        noise = [draw_fraction(draw, 0.001, 0.002) for _ in range(n)]
        speeds, widths, rates = ([draw_fraction(draw, 1, 2) for _ in range(n)] for _ in range(3))
        errors = []
        for i, rate in enumerate(derivatives_by_hand(task, task.emitted_u_max)):
            error = rate * factor * task.sampling_period / 2 + 2 * (noise[i] + roundoff * (7 + noise[i])) / task.shortest_period
            errors.append(error + 4 * roundoff * (speeds[i] + rates[i] * widths[i] + error))
        if difference_error(task, noise, (speeds, widths), rates, factor) != tuple(errors):
            return False
    return True


def control_authority_agrees() -> bool:
    """Return whether the speed that u can give against the plant bounds agrees (P8)."""
    draw = random.Random(10)
    for k in range(20):
        task, expected = coupled_task(draw, 1 + k % 3), []
        for i, bounds in enumerate(task.plant_bounds):
            coupling = sum((bounds.cross * u for j, u in enumerate(task.emitted_u_max) if j != i), Fraction(0))
            expected.append(bounds.g_min * task.emitted_u_max[i] - bounds.force - coupling)
        if constraints.control_authority(task) != tuple(expected):
            return False
    return True
