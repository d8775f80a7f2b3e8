"""The sampling conditions (P9) are one set of formulas, which lemma book, certificate, search and the hints for Coq share.

Doubles and fractions agree within a derived rounding error. Each of those users is compared with a second computation "by hand", and a
wrong term in a formula breaks every comparison that depends on it. coupled_cases.py does the same for further bounds.
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
from typing import Any, NamedTuple

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
    hints_agree,
    lost_turns_agree,
)

ROUNDOFF = 2.0**-53
ULPS = 4  # of an exponential, a logarithm or a hyperbolic tangent, whichever library has it


# ------------------------------------------------------------------------------------------------ random loops


def draw_fraction(draw: random.Random, low: float, high: float) -> Fraction:
    """Return a random multiple of 2^-20 in this range, which a double represents exactly."""
    return Fraction(math.floor(draw.uniform(low, high) * 2**20), 2**20)


class LoopKind(NamedTuple):
    """A kind of random loop: is_limited with a u_max, is_late with a latency, is_coupled with inputs that act on other components."""

    dimension: int
    order: int
    is_limited: bool
    is_late: bool
    is_coupled: bool


def exact_loop(draw: random.Random, kind: LoopKind) -> SampledLoop:
    """Return a random loop of three windows, in fractions that doubles represent exactly."""
    n = kind.dimension

    def array(low: float, high: float, *shape: int) -> Any:
        return np.array([draw_fraction(draw, low, high) for _ in range(math.prod(shape))], dtype=object).reshape(shape)

    narrow, zeros = array(0.4, 0.6, 3, n), np.zeros((3, n), dtype=int)
    times = np.array([Fraction(k) for k in range(4)])
    windows = Windows(
        times=times,
        narrow=narrow,
        wide=narrow + array(0, 0.5, 3, n),
        speed=zeros,
        widening=zeros,
        low=zeros,
        high=zeros,
        start=zeros,
    )
    gain = np.array(
        [draw_fraction(draw, k, 2 * k) for k in (draw.choice((0.01, 0.02, 0.05, 0.2)) for _ in range(n))], dtype=object
    )
    closing_speed, diagonal_min = array(0.1, 0.5, 3, n), array(0.7, 0.9, 3, n)
    # A u_max is a little below, a little above, or three times what the conditions need.
    nearly_needed = np.array(
        [
            draw_fraction(draw, v, v + 0.01) * Fraction(draw.choice((99, 102, 300)), 100)
            for v in (closing_speed / diagonal_min).max(axis=0)
        ]
    )
    u_max = nearly_needed if kind.is_limited else np.full(n, np.inf)
    law = SampledLaw(
        gain=gain, e_max=array(0.6, 0.9, n), shift=array(0.0005, 0.004, n), u_max=u_max,
        rounding=Fraction(1, 256), latency=draw_fraction(draw, 1e-3, 2e-3) if kind.is_late else Fraction(0), numbers=FRACTIONS,
    )  # fmt: skip
    cross = array(0, 0.1, 3, n, n) * (1 - np.eye(n, dtype=int)) * kind.is_coupled
    drift, middle = (array(0.1, 0.9, 3, n), array(0.1, 0.9, 3, n)) if kind.order == 2 else (None, None)
    ones = array(1, 1, 3)
    return SampledLoop(
        windows=windows, law=law, diagonal_min=diagonal_min, diagonal_max=array(1, 1.3, 3, n), cross=cross, closing_speed=closing_speed, narrow=narrow - array(0, 0.1, 3, n),
        eigenvalue_min=ones, norm=ones, closing_speed_norm=ones, start=np.full(n, Fraction(2)), closing_speed_aging=drift, closing_speed_middle=middle,
    )  # fmt: skip


def in_doubles(loop: SampledLoop) -> SampledLoop:
    """Return the same loop in doubles; its reaches and starts are logarithms E of the ratios rho."""

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
    norms = {name: floats(getattr(loop, name)) for name in ("eigenvalue_min", "norm", "closing_speed_norm")}
    return replace(loop, windows=windows, law=numbers, start=np.log(floats(loop.start)), **values, **norms)


# ------------------------------------------------------------------------------------------------ doubles against fractions


@dataclass(frozen=True)
class Rounded:
    """A double with a bound on its error: how far it may be from the number that exact arithmetic gives."""

    value: float
    error: float = 0.0

    def __float__(self) -> float:
        return float(self.value)

    def _of(self, value: float, error: float, ulps: float = 0.5) -> Rounded:
        return Rounded(value, error * (1 + 1e-9) + 2 * ulps * ROUNDOFF * abs(value))

    def __neg__(self) -> Rounded:
        return Rounded(-self.value, self.error)

    def __add__(self, operand: Any) -> Rounded:
        term = rounded(operand)
        return self._of(self.value + term.value, self.error + term.error)

    __radd__ = __add__

    def __sub__(self, operand: Any) -> Rounded:
        return self + -rounded(operand)

    def __rsub__(self, operand: Any) -> Rounded:
        return rounded(operand) - self

    def __mul__(self, operand: Any) -> Rounded:
        term = rounded(operand)
        error = abs(self.value) * term.error + abs(term.value) * self.error + self.error * term.error
        return self._of(self.value * term.value, error)

    __rmul__ = __mul__

    def __truediv__(self, operand: Any) -> Rounded:
        term = rounded(operand)
        size = abs(term.value) - term.error
        assert size > 0
        return self._of(self.value / term.value, (self.error + abs(self.value / term.value) * term.error) / size)

    def __rtruediv__(self, operand: Any) -> Rounded:
        return rounded(operand) / self

    def exp(self) -> Rounded:
        return self._of(math.exp(self.value), math.exp(self.value + self.error) * self.error, ULPS)

    def log(self) -> Rounded:
        assert self.value > self.error
        return self._of(math.log(self.value), self.error / (self.value - self.error), ULPS)

    def tanh(self) -> Rounded:
        return self._of(math.tanh(self.value), self.error, ULPS)

    def __lt__(self, operand: Any) -> bool:
        return self.value < float(operand)

    def __gt__(self, operand: Any) -> bool:
        return self.value > float(operand)

    def __le__(self, operand: Any) -> bool:
        return self.value <= float(operand)

    def __ge__(self, operand: Any) -> bool:
        return self.value >= float(operand)


def rounded(value: Any) -> Rounded:
    """Return the value as `Rounded`, without an error if it is a plain number."""
    return value if isinstance(value, Rounded) else Rounded(float(value))


KINDS = [
    LoopKind(n, order, is_limited, is_late, is_coupled)
    for n, is_coupled in ((1, False), (2, True))
    for order in (1, 2)
    for is_limited in (False, True)
    for is_late in (False, True)
]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: str(tuple(kind)))
def test_doubles_agree_with_fractions_within_a_derived_error(kind: LoopKind) -> None:
    """The formulas themselves run on `Rounded` numbers, which derive a bound on the error operation by operation."""
    draw, compared = random.Random(str(tuple(kind))), 0
    for _ in range(12):
        loop, age = exact_loop(draw, kind), draw_fraction(draw, 2e-3, 6e-3)
        rho = np.array([draw_fraction(draw, 2, 12) for _ in range(kind.dimension)], dtype=object)
        reach = np.array([math.log(v) for v in rho])
        rounded_reach = np.array([Rounded(v, 2 * ULPS * ROUNDOFF * abs(v)) for v in reach], dtype=object)
        doubles = in_doubles(loop)
        rounded_loop = doubles.with_law(shift=np.array([rounded(v) for v in doubles.law.shift], dtype=object))
        if not is_computable(loop, rho, age):
            continue
        exact_results, rounded_results, double_results = (
            [sampling_conditions.input_bound(s, e), *(c.values for c in sampling_conditions.sharp(s, e, tau))]
            for s, e, tau in ((loop, rho, age), (rounded_loop, rounded_reach, float(age)), (doubles, reach, float(age)))
        )
        for a, b, c in zip(exact_results, rounded_results, double_results, strict=True):
            for exact, bound, double in zip(np.ravel(a), np.ravel(b), np.ravel(c), strict=True):
                if isinstance(exact, float) or not isinstance(bound, Rounded):
                    continue  # the result is u_max, which is not rounded
                compared += 1
                assert abs(Fraction(float(double)) - exact) <= Fraction(2 * bound.error), (exact, double, bound)
                assert bound.error <= 1e-11 * max(1.0, abs(bound.value))  # the bound is useful only if it is small
    assert compared > 40


def is_computable(loop: SampledLoop, rho: Any, age: Fraction) -> bool:
    """Return whether no condition takes the logarithm of a number below 1."""
    u = sampling_conditions.input_bound(loop, rho)
    for c in sampling_conditions.sharp_under(loop, rho, age, u, sampling_conditions.sharp_closing_speed(loop, u)):
        if c.lemma == "sampled.ends" and not (c.values > 0).all():
            return False
    return True


# ------------------------------------------------------------------------------------------------ one wrong term, several laws


def input_by_hand(loop: SampledLoop, k: int, i: int, rho: Fraction) -> Any:
    """Return the bound U on |u| of component i in window k, by the docstring of sampling/sampling_conditions.py; infinite without a bound."""
    law, width = loop.law, loop.narrow[k, i]
    eta, share, rounding = law.shift[i], (1 - law.e_max[i]) / 2, law.rounding
    far, near = width * rho / (1 + rho) + eta, width / (1 + rho) - eta
    if near <= (far + near) * share:
        far, near = (1 - share) * (width - 2 * eta), share * (width - 2 * eta)
    if near <= 0:
        return law.u_max[i]
    return min(law.gain[i] * (1 / far + 1 / near) * (logarithm(far / near)[1] + rounding) * (1 + rounding), law.u_max[i])


def conditions_hold_by_hand(loop: SampledLoop, k: int, i: int, rho: Fraction, *, age: Fraction, u: list[Any]) -> bool:
    """Return whether the sampling conditions hold for component i in window k, by the same docstring."""
    law, rounding = loop.law, loop.law.rounding
    coupling = sum((loop.cross[k, i, j] * v for j, v in enumerate(u) if j != i), Fraction(0))
    closing_speed = loop.closing_speed[k, i] + coupling
    closing_speed_aging, closing_speed_middle = (
        closing_speed if v is None else v[k, i] + coupling for v in (loop.closing_speed_aging, loop.closing_speed_middle)
    )
    narrow, wide = loop.windows.narrow[k, i], loop.windows.wide[k, i]
    diagonal_max, diagonal_min = loop.diagonal_max[k, i], loop.diagonal_min[k, i]
    motion = (closing_speed_middle + diagonal_max * u[i]) * age + law.shift[i]
    if motion >= narrow / 2 * ((rho - 1) / (rho + 1) - rounding) or diagonal_min * law.u_max[i] <= closing_speed:
        return False
    drift = closing_speed_aging * age + diagonal_max * u[i] * law.latency + law.shift[i]
    for width in (narrow, wide):
        a, b = width * rho / (1 + rho) - drift, width / (1 + rho) + drift
        if a <= b:
            return False
        weakest_effect = law.gain[i] * (1 - rounding) * diagonal_min * (1 / a + 1 / b) * (logarithm(a / b)[0] - rounding)
        if weakest_effect <= closing_speed:
            return False
    return True


def proved_inputs_by_hand(loop: SampledLoop, rho: tuple[Fraction, ...], age: Fraction) -> tuple[Any, ...] | None:
    """Return the largest bounds on |u| where the conditions hold everywhere, else None, like `inputs_where_proved`.

    rho and age must be in range."""
    largest = [Fraction(0)] * len(rho)
    for k in range(len(loop.narrow)):
        u = [input_by_hand(loop, k, i, v) for i, v in enumerate(rho)]
        if not all(conditions_hold_by_hand(loop, k, i, v, age=age, u=u) for i, v in enumerate(rho)):
            return None
        largest = [max(a, b) for a, b in zip(largest, u, strict=True)]
    return tuple(largest)


def longest_age_by_hand(loop: SampledLoop, rho: tuple[Fraction, ...]) -> Fraction | None:
    """Return nearly the longest age of a sample that the conditions allow, by hand; None where they allow none."""
    low, high = max(loop.law.latency, Fraction(1, 10**6)), loop.longest_age
    if proved_inputs_by_hand(loop, rho, low) is None:
        return None
    for _ in range(16):
        middle = (low + high) / 2
        low, high = (low, middle) if proved_inputs_by_hand(loop, rho, middle) is None else (middle, high)
    return low


@functools.cache
def sampled_cases() -> list[tuple[SampledLoop, tuple[Fraction, ...], Fraction, tuple[Any, ...] | None]]:
    """Return (loop, rho, age, inputs proved by hand): random loops, rho up to the clamp, ages on both sides of the longest."""
    draw, result = random.Random(5), []
    for kind in KINDS * 4:
        loop = exact_loop(draw, kind)
        rho = tuple(draw.choice((draw_fraction(draw, 2.1, float(v)), v)) for v in loop.law.eps_at_clamp)
        longest_age = longest_age_by_hand(loop, rho)
        ages = [Fraction(1, 500)] if longest_age is None else [longest_age * (1 + Fraction(k, 10**4)) for k in (-1000, -1, 1)]
        ages = [age for age in ages if loop.law.latency <= age <= loop.longest_age]
        result += [(loop, rho, age, proved_inputs_by_hand(loop, rho, age)) for age in ages]
    return result


def test_at_least_20_cases_are_proved_and_20_are_not() -> None:
    proved = [u is not None for *_, u in sampled_cases()]
    assert 20 < sum(proved) < len(proved) - 20


def certificate_agrees() -> bool:
    """Return whether the certificate's inputs equal those by hand, exactly, for all cases."""
    return all(inputs_where_proved(loop, rho, age) == u for loop, rho, age, u in sampled_cases())


@functools.cache
def loops_to_search() -> list[tuple[SampledLoop, SampledLoop]]:
    """Return random loops of every kind, each in fractions and in doubles."""
    draw = random.Random(6)
    loops = [exact_loop(draw, kind) for kind in KINDS * 4]
    return [(loop, in_doubles(loop)) for loop in loops]


def search_agrees() -> bool:
    """Return whether the search's period is proved by hand, and, for one component, no reach of a grid has one 5 % longer."""
    for loop, doubles in loops_to_search():
        period = longest_proved_period("sharp", doubles)
        if period is not None:
            age = max(Fraction(period.seconds) * (1 - Fraction(1, 10**6)), loop.law.latency)
            u = proved_inputs_by_hand(loop, tuple(Fraction(math.exp(v)) for v in period.eps_bound), age)
            if u is None or any(abs(float(a) - b) > 1e-6 * b for a, b in zip(u, period.u, strict=True)):
                return False
        if len(loop.start) == 1:
            longer_age = Fraction(0 if period is None else period.seconds) * Fraction(21, 20) + Fraction(1, 10**5)
            longer_age = max(longer_age, loop.law.latency)
            reaches = np.geomspace(math.log(2) * 1.001, math.log(loop.law.eps_at_clamp[0]) * 0.999, 24)
            if longer_age <= loop.longest_age and any(
                proved_inputs_by_hand(loop, (Fraction(math.exp(v)),), longer_age) is not None for v in reaches
            ):
                return False
    return True


def lemma_book_agrees() -> bool:
    """Return whether the lemma book proves that its statements are these formulas."""
    return all(
        proof().verdict is Verdict.PROVED for proof in (sampled_evaluated._prove_sharp_evaluated, sampled_exact._prove_inputs)
    )


LAWS: dict[str, Callable[[], bool]] = {
    "lemma book": lemma_book_agrees,
    "certificate": certificate_agrees,
    "search": search_agrees,
    "hints": hints_agree,
    "lost turns": lost_turns_agree,
    "velocity by differences": difference_errors_agree,
    "control authority": control_authority_agrees,
}


@pytest.mark.parametrize("law", LAWS)
def test_every_user_of_the_formulas_agrees_with_the_computation_by_hand(law: str) -> None:
    with np.errstate(all="ignore"):
        assert LAWS[law]()


@contextmanager
def with_changed_source(owner: Any, name: str, old: str, new: str) -> Iterator[None]:
    """Give a function or method another source text, also where it was imported by name, and restore it."""
    function = vars(owner)[name]
    function = getattr(function, "__func__", function)
    text, original_code, names = textwrap.dedent(inspect.getsource(function)), function.__code__, dict[str, Any]()
    assert text.count(old) == 1
    exec(compile("from __future__ import annotations\n" + text.replace(old, new), name, "exec"), function.__globals__ | {}, names)
    function.__code__ = names[name].__code__
    try:
        yield
    finally:
        function.__code__ = original_code


OF_CONDITIONS = ("lemma book", "certificate", "search")  # the laws of formulas that the hints for Coq do not use
OF_ALL = (*OF_CONDITIONS, "hints")
BOUNDS = ("lost turns", "velocity by differences", "control authority")
MUTANTS = [  # module or class, function, text in its source, its replacement, the laws that this must break
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
def test_a_wrong_term_breaks_every_law_that_depends_on_it(mutant: Sequence[Any], law: str) -> None:
    with with_changed_source(*mutant), np.errstate(all="ignore"):
        try:
            agrees = LAWS[law]()
        except (ArithmeticError, ValueError, TypeError):  # a logarithm of a negative number
            agrees = False
    assert not agrees
