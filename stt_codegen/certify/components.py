"""What the sharp statement in fractions knows of a tube, window by window; for order 2 all of it."""

from __future__ import annotations

import itertools
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np

from stt_codegen.designs import LOWER, UPPER, RefinedDesign
from stt_codegen.designs.filtered import filtered, pressed, slopes_at_start
from stt_codegen.program.number import FORMATS
from stt_codegen.sampling.inertia import ROUNDINGS, difference_error
from stt_codegen.task import Task


@dataclass(frozen=True)
class Component:
    """What the statement knows of component i in one time window: exact numbers."""

    narrow: Fraction  # least width of the window
    narrow_seen: Fraction  # and of the one before
    wide: Fraction
    speed: Fraction  # of an edge, of both windows; for order 2 what the tube's motion pushes at an edge,
    drift: Fraction | None = None  # while a sample ages,
    middle: Fraction | None = None  # and from the middle


def inertial_components(design: RefinedDesign) -> Iterator[tuple[Component, ...]]:
    """The windows of order 2 (sampling/inertia.py has the formulas), exactly."""
    edges, press, bezier = filtered(design), pressed(design), design.bezier().astype(object)
    z = edges.coefficients[:, :, UPPER] - edges.coefficients[:, :, LOWER]
    w = bezier[:, :, UPPER] - bezier[:, :, LOWER]
    turn = 6 * np.diff(bezier, n=2, axis=3)
    low, high = turn[:, :, LOWER], turn[:, :, UPPER]
    bend = design.unit * (Fraction(design.segments) / design.prescribed_time) ** 2
    found: list[tuple[Component, ...]] = []
    for k in [*range(design.segments), design.segments if design.seam is None else design.seam]:
        last = k == design.segments
        at = slice(3, 4) if last else slice(0, 4)
        here = []
        for i, s in enumerate(design.filter):
            p = min(k, design.segments - 1)
            wide, narrow = max(z[p, i, at]) * edges.unit, min(z[p, i, at]) * edges.unit
            width = max(w[p, i, at]) * design.unit
            turns = [0, 0, 0, 0, 0]
            if not last:
                turns = [max(low[p, i]), -min(low[p, i]), max(high[p, i]), -min(high[p, i]), max(abs(low[p, i] + high[p, i]))]
            up_l, down_l, up_r, down_r, both = (int(v) * bend for v in turns)
            asked = [max(c) * press.unit for c in (press.coefficients[p, i, LOWER, at], -press.coefficients[p, i, UPPER, at])]
            square, held = s * s * width, s * wide
            here.append(Component(
                narrow, narrow, wide, max(*asked, up_r, down_l),
                max(held + down_l, square + down_r, held + up_r, square + up_l, Fraction(0)), both / 2 + (held + square) / 2,
            ))  # fmt: skip
        found.append(tuple(here))
    for k, here_ in enumerate(found):
        yield tuple(_joined(a, b) for a, b in zip(here_, found[max(k - 1, 0)], strict=True))


def _joined(own: Component, before: Component) -> Component:
    """With the worse of its window and of the one before, from which a sample may stem."""
    assert own.drift is not None
    assert own.middle is not None
    assert before.drift is not None
    assert before.middle is not None
    return replace(
        own,
        narrow_seen=min(own.narrow, before.narrow),
        speed=max(own.speed, before.speed),
        drift=max(own.drift, before.drift),
        middle=max(own.middle, before.middle),
    )


def start_ratios(task: Task, design: RefinedDesign) -> list[Fraction] | None:
    """By component the largest a/b and b/a at the start, of every x in the share and every speed within initial_set.speed; None
    where v + lambda x may be outside."""
    found = []
    for i, (low_rate, high_rate) in enumerate(slopes_at_start(design)):
        low, high = (int(v) * design.unit for v in design.bezier()[0, i, :, 0])
        half, middle = task.initial_set.share * (high - low) / 2, (low + high) / 2
        most = (1 + task.initial_set.share) / (1 - task.initial_set.share)  # so that the bound on e holds of x at 0 too
        for x, v in itertools.product((middle - half, middle + half), (task.start_speed[i], -task.start_speed[i])):
            a, b = v - low_rate + design.filter[i] * (x - low), high_rate - v + design.filter[i] * (high - x)
            if a <= 0 or b <= 0:
                return None
            most = max(most, a / b, b / a)
        found.append(most)
    return found


def inertial_shift(
    task: Task, design: RefinedDesign, edge_error: Sequence[Fraction], rate: Sequence[Fraction]
) -> tuple[Fraction, ...]:
    """What the law of order 2 sees of a and b is wrong by: arithmetic, noise of x and v, x and v rounded, a and b rounded."""
    roundoff, plant = Fraction(FORMATS[task.emit.scalar].roundoff), task.plant
    size = max(abs(v) for edge in (task.state_space.lower, task.state_space.upper) for v in edge)
    bezier, edges = design.bezier().astype(object), filtered(design)
    per_second = Fraction(design.segments) / design.prescribed_time
    found, widths, rates = [], [], []
    for i, s in enumerate(design.filter):
        width = max((bezier[:, i, UPPER] - bezier[:, i, LOWER]).ravel()) * design.unit
        wide = max((edges.coefficients[:, i, UPPER] - edges.coefficients[:, i, LOWER]).ravel()) * edges.unit
        fastest = 3 * int(np.abs(np.diff(design.bezier()[:, i], axis=-1)).max()) * design.unit * per_second
        rounded = roundoff * (s * size + fastest + s * width + ROUNDINGS * (wide + 2 * s * width))
        found.append(2 * (rate[i] + s * edge_error[i]) + (plant.noise_v or 0) + s * (plant.noise or 0) + rounded)
        widths.append(width)
        rates.append(fastest)
    if not task.differs:
        return tuple(found)
    of_v = difference_error(task, plant.noise or Fraction(0), rates, widths, design.filter)
    return tuple(a + b for a, b in zip(found, of_v, strict=True))
