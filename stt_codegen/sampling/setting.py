"""A loop as the sampled statements see it: a tube in time windows, bounds on a plant in each, and the law with its errors."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.program import FORMATS, round_down
from stt_codegen.sampling.numbers import DOUBLES, Numbers
from stt_codegen.sampling.plant import Bounds
from stt_codegen.sampling.windows import Windows
from stt_codegen.task import Task

Array = npt.NDArray[Any]
# Of the emitted law against (13) on what it sees: relative, and in eps = ln(a/b). Float: less than 32 roundings of 2^-24, the
# library's logarithm within 4 units; inline adds its 2^-14.9 of eps. Fixed: `integers.errors.law_error`, and its clamp, which
# acts up to 2^-13 later; there is no logarithm of either kind.
ROUNDING = {
    ("fixed", "libm"): 2.0**-10,
    ("fixed", "inline"): 2.0**-10,
    ("float", "libm"): 2.0**-19,
    ("float", "inline"): 2.0**-14,
    ("double", "libm"): 2.0**-46,
    ("double", "inline"): 2.0**-14,
}


@dataclass(frozen=True, kw_only=True)
class Law:
    """By component: gain = |k|, e_max, shift, u_max as it is emitted (infinite where u is not limited). rounding: relative and in
    eps. gain_high: a statement then is about every |k| from `gain` to this, by component; infinite: from `gain` on. numbers: what
    the law and all of its setting are computed in."""

    gain: Array
    e_max: Array
    shift: Array
    u_max: Array
    rounding: Any
    latency: Any = 0.0  # seconds from a sample to the input that it makes
    gain_high: Array | None = None
    numbers: Numbers = DOUBLES

    @property
    def strongest(self) -> Array:
        """The largest |k|, by component: |u| is at most what this one asks for."""
        return self.gain if self.gain_high is None else self.gain_high

    @property
    def farthest(self) -> Array:
        """The reach at the clamp, by component: of doubles ln((1 + e_max)/(1 - e_max))."""
        return np.asarray(self.numbers.reach_of_share(self.e_max))


@dataclass(frozen=True, kw_only=True)
class Setting:
    """A tube, a plant over it and a law. Arrays are (W + 1, n), by window and component, where nothing else is said; a value is
    the worst over its window and the one before, because a sample may stem from there.

    least, most, cross (W + 1, n, n), definite, norm (both (W + 1)): of g, as `plant.Bounds`. push: what moves x or an edge apart
    from u, P = |f + w| + the edges' speed; push_norm (W + 1): the same as a norm. narrow: the tube's width. start (n): what
    |eps(0)| is at most, for the starts that are spoken of. drift, middle: for order 2 what pushes in the other places of the
    sharp statement. known_to: seconds, how old a sample may be for which g of a plant that mixes, and the error of a velocity by
    differences, are known.
    """

    windows: Windows
    law: Law
    least: Array
    most: Array
    cross: Array
    push: Array
    narrow: Array
    definite: Array
    norm: Array
    push_norm: Array
    start: Array
    drift: Array | None = None
    middle: Array | None = None
    known_to: Any = math.inf

    @property
    def numbers(self) -> Numbers:
        """What all of this is computed in."""
        return self.law.numbers

    @property
    def longest_age(self) -> Any:
        """Of a sample, so that it and what acted before it stem from this window or the one before."""
        return min(self.known_to, self.windows.shortest / (2 if self.law.latency else 1))

    def with_law(self, **changes: Any) -> Setting:
        return replace(self, law=replace(self.law, **changes))

    def component(self, i: int) -> Setting:
        """Component i alone, for a plant whose inputs are not coupled."""
        here = slice(i, i + 1)
        w, law = self.windows, self.law
        windows = replace(
            w,
            start=w.start[here],
            **{name: getattr(w, name)[:, here] for name in ("narrow", "wide", "speed", "widening", "low", "high")},
        )
        by_component = ("gain", "e_max", "shift", "u_max", *(("gain_high",) if law.gain_high is not None else ()))
        one = replace(law, **{name: getattr(law, name)[here] for name in by_component})
        names = ("least", "most", "push", "narrow", *(("drift", "middle") if self.drift is not None else ()))
        own = {name: getattr(self, name)[:, here] for name in names}
        return replace(self, windows=windows, law=one, cross=self.cross[:, here, here], start=self.start[here], **own)

    def window(self, k: int) -> Setting:
        """One window alone, as the sharp statement sees it, with what the one before adds."""
        here = slice(k, k + 1)
        windows = replace(self.windows, narrow=self.windows.narrow[here], wide=self.windows.wide[here])
        names = ("least", "most", "cross", "push", "narrow", *(("drift", "middle") if self.drift is not None else ()))
        return replace(self, windows=windows, **{name: getattr(self, name)[here] for name in names})

    def begun_at(self, start: Array) -> Setting:
        """The same loop with other starts: what |eps(0)| is at most, (n,)."""
        return replace(self, start=start)


def law_of(task: Task, edge_error: Sequence[Fraction], noise: Any = 0.0, latency: Any = 0.0, numbers: Numbers = DOUBLES) -> Law:
    """The law of a task; `noise` bounds the error of a measured x, by component, in the task's units; latency in seconds."""
    n, scalar = task.dimension, task.emit.scalar
    size = max(abs(v) for edge in (task.state_space.lower, task.state_space.upper) for v in edge)
    rounded = numbers.outward(numbers.of(FORMATS[scalar].roundoff * size), 1e-12)
    return Law(
        gain=np.array([numbers.of(abs(v)) for v in task.gain]),
        e_max=np.array([numbers.of(v) for v in task.e_max]),
        shift=np.array([numbers.outward(numbers.of(2 * e), 1e-12) + rounded + noise for e in edge_error]),
        u_max=np.full(n, np.inf) if task.u_max is None else np.array([numbers.of(round_down(v, scalar)) for v in task.u_max]),
        rounding=numbers.of(ROUNDING[scalar, task.emit.math]),
        latency=latency,
        numbers=numbers,
    )


def reach_of_starts(share: Fraction, n: int, numbers: Numbers = DOUBLES) -> Array:
    """The least reach that all starts with |e(0)| <= share have, by component; rounded up."""
    return np.full(n, numbers.outward(numbers.reach_of_share(share), 1e-9))


def eps_of_state(windows: Windows, x0: Sequence[float]) -> Array:
    """|eps(0)| of a state by component, rounded up; infinite where it is not strictly inside gamma(0)."""
    x = np.array(x0)
    a, b = x - windows.start[:, 0], windows.start[:, 1] - x
    a, b = a - 1e-15 * np.abs(x), b - 1e-15 * np.abs(x)  # more than the differences are rounded by
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where((a > 0) & (b > 0), np.abs(np.log(a / b)) * (1 + 1e-9), np.inf)


def setting_of(windows: Windows, plant: Sequence[Bounds], law: Law, start: Array) -> Setting:
    """`plant`: bounds for every window, over it and the one before it. start (n): what |eps(0)| is at most."""
    numbers, speed = law.numbers, back(windows.speed, np.maximum)
    total = numbers.root_above((speed**2).sum(axis=1))
    return Setting(
        windows=windows,
        law=law,
        least=np.array([p.least for p in plant]),
        most=np.array([p.most for p in plant]),
        cross=np.array([p.cross for p in plant]),
        push=numbers.outward(np.array([p.push for p in plant]) + speed, 1e-12),
        narrow=back(windows.narrow, np.minimum),
        definite=np.array([p.definite for p in plant]),
        norm=np.array([p.norm for p in plant]),
        push_norm=numbers.outward(np.array([p.push_norm for p in plant]) + total, 1e-12),
        start=start,
    )


def back(values: Array, worse: Callable[[Array, Array], Array]) -> Array:
    """By window the worse of its value and that of the window before."""
    return worse(values, np.concatenate([values[:1], values[:-1]]))


def in_balls(s: Setting) -> Setting:
    """The same with balls in place of doubles where a formula calculates."""
    convert = np.vectorize(arb, otypes=[object])
    windows = replace(s.windows, **{name: convert(getattr(s.windows, name)) for name in ("narrow", "wide", "speed", "widening")})
    names = ("least", "most", "cross", "push", "narrow", "definite", "norm", "push_norm")
    names = (*names, *(("drift", "middle") if s.drift is not None else ()))
    high = s.law.gain_high
    law = replace(s.law, gain=convert(s.law.gain), gain_high=None if high is None else convert(high))
    return replace(s, windows=windows, law=law, **{name: convert(getattr(s, name)) for name in names})
