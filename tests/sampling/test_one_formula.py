"""The sampling conditions are one set of formulas: doubles and fractions agree within what doubles lose, and a wrong term shows
in the lemma book, in the certificate, in the search and in what Coq is given at once. So do bounds beside them (coupled_cases.py).
"""

from __future__ import annotations

import functools
import inspect
import math
import random
import textwrap
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

import numpy as np
import pytest

from stt_codegen import constraints
from stt_codegen.designs import RefinedDesign
from stt_codegen.lemmas.lemma import Verdict
from stt_codegen.lemmas.sampling import sampled_evaluated, sampled_exact
from stt_codegen.program.analyse.exact_logarithm import logarithm
from stt_codegen.sampling import sampled_loop, sampling_conditions, windows
from stt_codegen.sampling.numbers import FRACTIONS
from stt_codegen.sampling.periods import inputs_where_proved, longest_proved_period
from stt_codegen.sampling.sampled_loop import SampledLaw, SampledLoop
from stt_codegen.sampling.windows import Windows
from stt_codegen.task.schema import TaskTables
from stt_codegen.theorem import hints
from tests.sampling.coupled_cases import (
    control_authority_agrees,
    difference_errors_agree,
    lost_turns_agree,
    the_hints_agree,
)

ROUNDOFF = 2.0**-53
ULPS = 4  # of an exponential, a logarithm or a hyperbolic tangent, whichever library has it


# ------------------------------------------------------------------------------------------------ random loops


def drawn(draw: random.Random, low: float, high: float) -> Fraction:
    """A number of 20 bits, which a double holds."""
    return Fraction(math.floor(draw.uniform(low, high) * 2**20), 2**20)


def exact_loop(draw: random.Random, n: int, order: int, is_limited: bool, is_late: bool, is_coupled: bool) -> SampledLoop:
    """A loop of three windows in fractions that doubles hold."""

    def array(low: float, high: float, *shape: int) -> Any:
        return np.array([drawn(draw, low, high) for _ in range(math.prod(shape))], dtype=object).reshape(shape)

    narrow, still = array(0.4, 0.6, 3, n), np.zeros((3, n), dtype=int)
    times = np.array([Fraction(k) for k in range(4)])
    windows = Windows(
        times=times,
        narrow=narrow,
        wide=narrow + array(0, 0.5, 3, n),
        speed=still,
        widening=still,
        low=still,
        high=still,
        start=still,
    )
    gain = np.array([drawn(draw, k, 2 * k) for k in (draw.choice((0.01, 0.02, 0.05, 0.2)) for _ in range(n))], dtype=object)
    push, least = array(0.1, 0.5, 3, n), array(0.7, 0.9, 3, n)
    needed = np.array([drawn(draw, v, v + 0.01) * Fraction(draw.choice((99, 102, 300)), 100) for v in (push / least).max(axis=0)])
    u_max = needed if is_limited else np.full(n, np.inf)  # a little less and a little more than what is enough
    law = SampledLaw(
        gain=gain, e_max=array(0.6, 0.9, n), shift=array(0.0005, 0.004, n), u_max=u_max,
        rounding=Fraction(1, 256), latency=drawn(draw, 1e-3, 2e-3) if is_late else Fraction(0), numbers=FRACTIONS,
    )  # fmt: skip
    cross = array(0, 0.1, 3, n, n) * (1 - np.eye(n, dtype=int)) * is_coupled
    drift, middle = (array(0.1, 0.9, 3, n), array(0.1, 0.9, 3, n)) if order == 2 else (None, None)
    one = array(1, 1, 3)
    return SampledLoop(
        windows=windows, law=law, diagonal_min=least, diagonal_max=array(1, 1.3, 3, n), cross=cross, closing_speed=push, narrow=narrow - array(0, 0.1, 3, n),
        eigenvalue_min=one, norm=one, closing_speed_norm=one, start=np.full(n, Fraction(2)), closing_speed_aging=drift, closing_speed_middle=middle,
    )  # fmt: skip


def in_doubles(loop: SampledLoop) -> SampledLoop:
    """The same loop in doubles: reaches are E, starts too."""

    def floats(values: Any) -> Any:
        return None if values is None else np.asarray(values, dtype=float)

    names = ("times", "narrow", "wide", "speed", "widening", "low", "high", "start")
    windows = Windows(**{name: floats(getattr(loop.windows, name)) for name in names})
    law = loop.law
    parts = {name: floats(getattr(law, name)) for name in ("gain", "e_max", "shift", "u_max")}
    numbers = SampledLaw(**parts, rounding=float(law.rounding), latency=float(law.latency))
    values = {
        name: floats(getattr(loop, name))
        for name in (
            "diagonal_min",
            "diagonal_max",
            "cross",
            "closing_speed",
            "narrow",
            "closing_speed_aging",
            "closing_speed_middle",
        )
    }
    ends = {name: floats(getattr(loop, name)) for name in ("eigenvalue_min", "norm", "closing_speed_norm")}
    return replace(loop, windows=windows, law=numbers, start=np.log(floats(loop.start)), **values, **ends)


# ------------------------------------------------------------------------------------------------ doubles against fractions


@dataclass(frozen=True)
class Rounded:
    """What a double is, and by how much at most it differs from the number that no rounding touched."""

    value: float
    error: float = 0.0

    def __float__(self) -> float:
        return float(self.value)

    def _of(self, value: float, error: float, ulps: float = 0.5) -> Rounded:
        return Rounded(value, error * (1 + 1e-9) + 2 * ulps * ROUNDOFF * abs(value))

    def __neg__(self) -> Rounded:
        return Rounded(-self.value, self.error)

    def __add__(self, other: Any) -> Rounded:
        b = rounded(other)
        return self._of(self.value + b.value, self.error + b.error)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Rounded:
        return self + -rounded(other)

    def __rsub__(self, other: Any) -> Rounded:
        return rounded(other) - self

    def __mul__(self, other: Any) -> Rounded:
        b = rounded(other)
        error = abs(self.value) * b.error + abs(b.value) * self.error + self.error * b.error
        return self._of(self.value * b.value, error)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Rounded:
        b = rounded(other)
        size = abs(b.value) - b.error
        assert size > 0
        return self._of(self.value / b.value, (self.error + abs(self.value / b.value) * b.error) / size)

    def __rtruediv__(self, other: Any) -> Rounded:
        return rounded(other) / self

    def exp(self) -> Rounded:
        return self._of(math.exp(self.value), math.exp(self.value + self.error) * self.error, ULPS)

    def log(self) -> Rounded:
        assert self.value > self.error
        return self._of(math.log(self.value), self.error / (self.value - self.error), ULPS)

    def tanh(self) -> Rounded:
        return self._of(math.tanh(self.value), self.error, ULPS)

    def __lt__(self, other: Any) -> bool:
        return self.value < float(other)

    def __gt__(self, other: Any) -> bool:
        return self.value > float(other)

    def __le__(self, other: Any) -> bool:
        return self.value <= float(other)

    def __ge__(self, other: Any) -> bool:
        return self.value >= float(other)


def rounded(value: Any) -> Rounded:
    return value if isinstance(value, Rounded) else Rounded(float(value))


KINDS = [
    (n, order, is_limited, is_late, is_coupled)
    for n, is_coupled in ((1, False), (2, True))
    for order in (1, 2)
    for is_limited in (False, True)
    for is_late in (False, True)
]


@pytest.mark.parametrize("kind", KINDS, ids=str)
def test_doubles_are_the_fractions_within_what_they_round(kind: tuple[int, int, bool, bool, bool]) -> None:
    """The very formulas run on doubles that carry a bound on their error, derived operation by operation."""
    draw, compared = random.Random(str(kind)), 0
    for _ in range(12):
        loop, age = exact_loop(draw, *kind), drawn(draw, 2e-3, 6e-3)
        rho = np.array([drawn(draw, 2, 12) for _ in range(kind[0])], dtype=object)
        reach = np.array([math.log(v) for v in rho])
        carried = np.array([Rounded(v, 2 * ULPS * ROUNDOFF * abs(v)) for v in reach], dtype=object)
        doubles = in_doubles(loop)
        tracked = doubles.with_law(shift=np.array([rounded(v) for v in doubles.law.shift], dtype=object))
        if not is_computable(loop, rho, age):
            continue
        wanted, carries, has = (
            [sampling_conditions.input_bound(s, e), *(c.values for c in sampling_conditions.sharp(s, e, tau))]
            for s, e, tau in ((loop, rho, age), (tracked, carried, float(age)), (doubles, reach, float(age)))
        )
        for a, b, c in zip(wanted, carries, has, strict=True):
            for exact, bound, double in zip(np.ravel(a), np.ravel(b), np.ravel(c), strict=True):
                if isinstance(exact, float) or not isinstance(bound, Rounded):
                    continue  # u_max itself, or no limit
                compared += 1
                assert abs(Fraction(float(double)) - exact) <= Fraction(2 * bound.error), (exact, double, bound)
                assert bound.error <= 1e-11 * max(1.0, abs(bound.value))  # so that the bound says something
    assert compared > 40


def is_computable(loop: SampledLoop, rho: Any, age: Fraction) -> bool:
    """Whether no condition takes a logarithm of what is below 1."""
    u = sampling_conditions.input_bound(loop, rho)
    for c in sampling_conditions.sharp_under(loop, rho, age, u, sampling_conditions.sharp_closing_speed(loop, u)):
        if c.lemma == "sampled.ends" and not (c.values > 0).all():
            return False
    return True


# ------------------------------------------------------------------------------------------------ one wrong term, three laws


def input_by_hand(loop: SampledLoop, k: int, i: int, rho: Fraction) -> Any:
    """U of one component in one window, from the docstring of sampling/sampling_conditions.py; infinite where nothing bounds it."""
    law, d = loop.law, loop.narrow[k, i]
    eta, share, r = law.shift[i], (1 - law.e_max[i]) / 2, law.rounding
    far, near = d * rho / (1 + rho) + eta, d / (1 + rho) - eta
    if near <= (far + near) * share:
        far, near = (1 - share) * (d - 2 * eta), share * (d - 2 * eta)
    if near <= 0:
        return law.u_max[i]
    return min(law.gain[i] * (1 / far + 1 / near) * (logarithm(far / near)[1] + r) * (1 + r), law.u_max[i])


def kept_by_hand(loop: SampledLoop, k: int, i: int, rho: Fraction, age: Fraction, u: list[Any]) -> bool:
    """The conditions on one component in one window, likewise."""
    law, r = loop.law, loop.law.rounding
    others = sum((loop.cross[k, i, j] * v for j, v in enumerate(u) if j != i), Fraction(0))
    push = loop.closing_speed[k, i] + others
    aged, turned = (push if v is None else v[k, i] + others for v in (loop.closing_speed_aging, loop.closing_speed_middle))
    narrow, wide, most, least = (
        loop.windows.narrow[k, i],
        loop.windows.wide[k, i],
        loop.diagonal_max[k, i],
        loop.diagonal_min[k, i],
    )
    if (turned + most * u[i]) * age + law.shift[i] >= narrow / 2 * ((rho - 1) / (rho + 1) - r) or least * law.u_max[i] <= push:
        return False
    c = aged * age + most * u[i] * law.latency + law.shift[i]
    for d in (narrow, wide):
        a, b = d * rho / (1 + rho) - c, d / (1 + rho) + c
        if a <= b or law.gain[i] * (1 - r) * least * (1 / a + 1 / b) * (logarithm(a / b)[0] - r) <= push:
            return False
    return True


def by_hand(loop: SampledLoop, rho: tuple[Fraction, ...], age: Fraction) -> tuple[Any, ...] | None:
    """What `inputs_where_proved` should say, where rho and age are in range."""
    largest = [Fraction(0)] * len(rho)
    for k in range(len(loop.narrow)):
        u = [input_by_hand(loop, k, i, v) for i, v in enumerate(rho)]
        if not all(kept_by_hand(loop, k, i, v, age, u) for i, v in enumerate(rho)):
            return None
        largest = [max(a, b) for a, b in zip(largest, u, strict=True)]
    return tuple(largest)


def last_age(loop: SampledLoop, rho: tuple[Fraction, ...]) -> Fraction | None:
    """Near the longest age that the conditions allow, by hand; None where they allow none."""
    low, high = max(loop.law.latency, Fraction(1, 10**6)), loop.longest_age
    if by_hand(loop, rho, low) is None:
        return None
    for _ in range(16):
        middle = (low + high) / 2
        low, high = (low, middle) if by_hand(loop, rho, middle) is None else (middle, high)
    return low


@functools.cache
def cases() -> list[tuple[SampledLoop, tuple[Fraction, ...], Fraction, tuple[Any, ...] | None]]:
    """Random loops with reaches up to the clamp, ages on both sides of the longest, and what is true by hand."""
    draw, made = random.Random(5), []
    for kind in KINDS * 4:
        loop = exact_loop(draw, *kind)
        rho = tuple(draw.choice((drawn(draw, 2.1, float(v)), v)) for v in loop.law.eps_at_clamp)
        longest_age = last_age(loop, rho)
        ages = [Fraction(1, 500)] if longest_age is None else [longest_age * (1 + Fraction(k, 10**4)) for k in (-1000, -1, 1)]
        ages = [age for age in ages if loop.law.latency <= age <= loop.longest_age]
        made += [(loop, rho, age, by_hand(loop, rho, age)) for age in ages]
    return made


def test_the_cases_are_on_both_sides() -> None:
    proved = [u is not None for *_, u in cases()]
    assert 20 < sum(proved) < len(proved) - 20


def the_certificate_agrees() -> bool:
    """Exactly, on both sides of the longest age of random loops."""
    return all(inputs_where_proved(loop, rho, age) == u for loop, rho, age, u in cases())


@functools.cache
def loops_to_search() -> list[tuple[SampledLoop, SampledLoop]]:
    draw = random.Random(6)
    loops = [exact_loop(draw, *kind) for kind in KINDS * 4]
    return [(loop, in_doubles(loop)) for loop in loops]


def the_search_agrees() -> bool:
    """What it finds is true by hand, and clearly more is true of no reach of a grid, where there is one component."""
    for loop, doubles in loops_to_search():
        found = longest_proved_period("sharp", doubles)
        if found is not None:
            age = max(Fraction(found.seconds) * (1 - Fraction(1, 10**6)), loop.law.latency)
            u = by_hand(loop, tuple(Fraction(math.exp(v)) for v in found.eps_bound), age)
            if u is None or any(abs(float(a) - b) > 1e-6 * b for a, b in zip(u, found.u, strict=True)):
                return False
        if len(loop.start) == 1:
            more = Fraction(0 if found is None else found.seconds) * Fraction(21, 20) + Fraction(1, 10**5)
            more = max(more, loop.law.latency)
            reaches = np.geomspace(math.log(2) * 1.001, math.log(loop.law.eps_at_clamp[0]) * 0.999, 24)
            if more <= loop.longest_age and any(by_hand(loop, (Fraction(math.exp(v)),), more) is not None for v in reaches):
                return False
    return True


def the_book_agrees() -> bool:
    return all(
        proof().verdict is Verdict.PROVED for proof in (sampled_evaluated._prove_sharp_evaluated, sampled_exact._prove_inputs)
    )


LAWS: dict[str, Callable[[], bool]] = {
    "lemma book": the_book_agrees,
    "certificate": the_certificate_agrees,
    "search": the_search_agrees,
    "hints": the_hints_agree,
    "lost turns": lost_turns_agree,
    "velocity by differences": difference_errors_agree,
    "control authority": control_authority_agrees,
}


@pytest.mark.parametrize("law", LAWS)
def test_the_formulas_are_those_of_the_statement(law: str) -> None:
    with np.errstate(all="ignore"):
        assert LAWS[law]()


@contextmanager
def changed(owner: Any, name: str, old: str, new: str) -> Iterator[None]:
    """A function or method with another source text, wherever it is known."""
    function = vars(owner)[name]
    function = getattr(function, "__func__", function)
    text, kept, names = textwrap.dedent(inspect.getsource(function)), function.__code__, dict[str, Any]()
    assert text.count(old) == 1
    exec(compile("from __future__ import annotations\n" + text.replace(old, new), name, "exec"), function.__globals__ | {}, names)
    function.__code__ = names[name].__code__
    try:
        yield
    finally:
        function.__code__ = kept


OF_CONDITIONS, OF_ALL = ("lemma book", "certificate", "search"), ("lemma book", "certificate", "search", "hints")
BOUNDS = ("lost turns", "velocity by differences", "control authority")
MUTANTS = [  # owner, function, what is replaced by what, the laws that it must break
    (sampling_conditions, "input_per_gain", "1 / far + 1 / near", "1 / far - 1 / near", OF_ALL),
    (sampling_conditions, "input_per_gain", "+ rounding * steepness", "", OF_ALL),
    (sampling_conditions, "emitted_input", "* (1 + rounding)", "", OF_ALL),
    (sampling_conditions, "measured_distances", "+ loop.law.shift", "- loop.law.shift", OF_ALL),
    (sampling_conditions, "input_bound", "(1 - loop.law.e_max) / 2", "(1 - loop.law.e_max) / 3", OF_CONDITIONS),
    (sampling_conditions, "input_bound", "loop.narrow - 2 * loop.law.shift", "loop.narrow - loop.law.shift", OF_CONDITIONS),
    (sampling_conditions, "sharp_closing_speed", "(loop.cross * u[..., None, :]).sum(axis=-1)", "0 * loop.closing_speed", OF_ALL),
    (
        sampling_conditions,
        "sharp_under",
        "(loop.numbers.share_of_eps(eps_bound) - r)",
        "loop.numbers.share_of_eps(eps_bound)",
        OF_CONDITIONS,
    ),
    (
        sampling_conditions,
        "sharp_under",
        "(from_middle + loop.diagonal_max * u) * tau",
        "(from_middle + loop.diagonal_min * u) * tau",
        OF_CONDITIONS,
    ),
    (
        sampling_conditions,
        "sharp_under",
        "* loop.diagonal_min - closing_speed)\n    drift",
        "* loop.diagonal_max - closing_speed)\n    drift",
        OF_CONDITIONS,
    ),
    (sampling_conditions, "drift_of_sample", "aging * tau", "aging * tau / 2", OF_ALL),
    (sampling_conditions, "drift_of_sample", "+ loop.diagonal_max * u * loop.law.latency", "", OF_ALL),
    (sampling_conditions, "drift_of_sample", "* loop.law.latency + loop.law.shift", "* loop.law.latency", OF_ALL),
    (sampling_conditions, "distances_at_sample", "far_divisor(eps_bound) - drift", "far_divisor(eps_bound)", OF_ALL),
    (
        sampling_conditions,
        "sharp_under",
        "(loop.windows.narrow, loop.windows.wide)",
        "(loop.windows.narrow, loop.windows.narrow)",
        OF_CONDITIONS,
    ),
    (sampling_conditions, "weakest_effect", "loop.law.gain * (1 - r)", "loop.law.gain", OF_ALL),
    (sampling_conditions, "weakest_effect", "loop.diagonal_min * input", "loop.diagonal_max * input", OF_ALL),
    (sampled_loop, "first_order_loop", "np.array([p.disturbance for p in plant]) + speed, 1", "speed, 1", ("hints",)),
    (sampled_loop, "first_order_loop", "for p in plant]) + speed, 1", "for p in plant]), 1", ("hints",)),
    (windows, "refined_windows", "Fraction(3 * design.segments)", "Fraction(2 * design.segments)", ("hints",)),
    (hints.CoqConditions, "turns_in_time", "+ loop.diagonal_max * self.inputs", "", ("hints",)),
    (hints.CoqConditions, "turns_in_time", "(broadest + 2", "(0 * broadest + 2", ("hints",)),
    (hints.CoqConditions, "turns_in_time", "stays & outdoes", "stays", ("hints",)),
    (hints.CoqConditions, "pushes_back", "* near / near_at_end", "", ("hints",)),
    (TaskTables, "coupling_of", "b.cross * (total - v)", "0 * v", BOUNDS),
    (TaskTables, "coupling_of", "(total - v)", "total", BOUNDS),
    (TaskTables, "largest_derivative", "+ coupling", "", BOUNDS[:2]),
    (TaskTables, "largest_derivative", "b.g_max * u", "u", BOUNDS[:2]),
    (TaskTables, "largest_derivative", "b.force + ", "", BOUNDS[:2]),
    (constraints, "control_authority", "- b.force - coupling", "- b.force", BOUNDS[2:]),
    (RefinedDesign, "largest_steps", ".max(axis=(2, 3))", "[:, :, 0].max(axis=2)", ("hints", "lost turns")),
]


def broken_laws() -> Iterator[Any]:
    """Yield every mutant with every law that it must break; the lemma book takes long."""
    for *mutant, laws in MUTANTS:
        for law in laws:
            name = f"{mutant[1]}: {mutant[2].strip()[:40]}, {law}"
            yield pytest.param(mutant, law, id=name, marks=[pytest.mark.slow] if law == "lemma book" else [])


@pytest.mark.parametrize(("mutant", "law"), list(broken_laws()))
def test_a_wrong_term_breaks_every_law_that_rests_on_it(mutant: Sequence[Any], law: str) -> None:
    with changed(*mutant), np.errstate(all="ignore"):
        try:
            agrees = LAWS[law]()
        except (ArithmeticError, ValueError, TypeError):  # a logarithm of what is below 0
            agrees = False
    assert not agrees
