"""What Theorem 4.1 and the sampled statements give for one controller and one plant: hypotheses, and bounds with numbers.

`design` shows the short form, `prove TASK` writes all of it to <p>.bounds.json. Every number is rounded to the safe side.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt
from flint import arb

from stt_codegen.certify.certificate import above, below
from stt_codegen.certify.enclosure import Enclosed
from stt_codegen.certify.plant import Bounds, PlantEnclosure, bounds_of_task
from stt_codegen.certify.sampling import COARSE, STATEMENTS, Period, Setting, law_of, longest, proposal, q, setting_of
from stt_codegen.certify.windows import Windows, enclosed_windows, refined_windows
from stt_codegen.design.adapted import AdaptiveDesign
from stt_codegen.design.tube import RefinedDesign
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import Controller
from stt_codegen.plants import Model

Array = npt.NDArray[Any]
GAINS = np.geomspace(1e-2, 1e2, 25)  # times the widest tube's natural gain, tried for the longest period
USUAL_PERIOD = 0.001  # seconds; for which the safe gains are told when the task names no tick_period


@dataclass(frozen=True)
class Hypothesis:
    """Something that a theorem assumes: whether it holds for this tube and plant, with the numbers."""

    name: str
    statement: str
    holds: bool


class Analysis:
    """A controller with a plant (None: the bounds in the task's [plant]); `noise` bounds the error of a measured
    state, `latency` the seconds from a sample to the input that it makes (in the age of a sample it counts too)."""

    def __init__(self, controller: Controller, plant: Model | None = None, noise: float = 0.0, latency: float = 0.0) -> None:
        for name, value in (("--noise", noise), ("--latency", latency)):
            if not (math.isfinite(value) and value >= 0):
                raise BadInput(f"{name} {value:g}: a finite number of 0 or more is needed")
        self.controller, self.noise, self.latency = controller, noise, latency
        self.plant = plant
        task = controller.task
        self.windows = self._windows()
        law = law_of(task, controller.certificate.edge_error, noise, latency)
        self.bounds = list(self._bounds())
        self.setting = setting_of(self.windows, self.bounds, law, [float(v) for v in task.initial_state])

    def _windows(self) -> Windows:
        design = self.controller.design
        return refined_windows(design) if isinstance(design, RefinedDesign) else enclosed_windows(self._enclosed)

    @cached_property
    def _enclosed(self) -> Enclosed:
        from stt_codegen.certify.enclosure import enclosed_tube

        design = self.controller.design
        assert isinstance(design, AdaptiveDesign)
        return enclosed_tube(self.controller.task, design)

    def _bounds(self) -> Iterator[Bounds]:
        """The plant over every window's box, joined with that of the window before."""
        task, w = self.controller.task, self.windows
        if self.plant is None:
            yield from [bounds_of_task(task)] * len(w.narrow)
            return
        enclosure = PlantEnclosure(self.plant, task.dimension, 1 if task.control.gain > 0 else -1)
        for k in range(len(w.narrow)):
            before = max(k - 1, 0)
            low, high = np.minimum(w.low[k], w.low[before]), np.maximum(w.high[k], w.high[before])
            yield enclosure.over(list(zip(low.tolist(), high.tolist(), strict=True)))

    def start_at(self, x0: Sequence[float]) -> Array:
        """|eps(0)| of another start."""
        law = self.setting.law
        return setting_of(self.windows, self.bounds, law, x0).start

    @property
    def name(self) -> str:
        if self.plant is not None:
            return self.plant.name
        told = self.controller.task.plant.model_dump(exclude_none=True)
        return "[plant] of the task" if told else "xdot = u" if self.controller.task.control.gain > 0 else "xdot = -u"

    # ------------------------------------------------------------------------------------ sampled control

    @cached_property
    def periods(self) -> dict[str, Period | None]:
        """By statement, the longest period proved for the task's gain."""
        return {statement: self._longest(statement, self.setting) for statement in STATEMENTS}

    def _longest(self, statement: str, setting: Setting) -> Period | None:
        """`longest`; none below what the certificate of an adaptive tube allows `alpha_step`."""
        period = longest(statement, setting)
        return None if period is None or period.seconds < self.shortest else period

    @property
    def shortest(self) -> float:
        """The shortest period: 0 but for adaptive tubes, whose alpha may not be stepped more finely than is certified."""
        steps = self.controller.certificate.steps
        return 0.0 if steps is None else float(steps[0])

    def assumptions(self) -> list[str]:
        """What the periods rest on and nothing here can show."""
        task, found = self.controller.task, []
        if self.plant is None and task.plant.model_dump(exclude_none=True):
            found.append("inputs are decoupled (g diagonal); `prove TASK --plant` takes any g")
            if task.plant.g_min is None:
                found.append(f"plant.g_min, which is not stated, is {below_float(float(self.bounds[0].definite)):g}")
        if self.shortest:
            found.append("alpha follows (11); what the emitted steps differ from it by is not in the period")
        return found

    @cached_property
    def period(self) -> Period | None:
        """The longest of them."""
        found = [p for p in self.periods.values() if p is not None]
        return max(found, key=lambda p: p.seconds, default=None)

    def period_at(self, gain: float) -> Period | None:
        """The longest period of the sharp statement at another |k|; of the general one where that has none."""
        setting = self.setting.with_gain(gain)
        return self._longest("sharp", setting) or self._longest("general", setting)

    @cached_property
    def _gains(self) -> list[tuple[float, float]]:
        """(|k|, period in seconds) over a range of gains in short decimals, as the search has it: a proposal, not yet proved."""
        s = self.setting
        natural = float(np.max(s.push * s.windows.wide / np.maximum(s.least, 1e-9)))  # keeps eps near 1
        natural = natural if 0 < natural < 1e6 else float(s.law.gain)
        gains = dict.fromkeys(float(f"{k * natural:.2g}") for k in GAINS)
        found = [(k, proposal("sharp", s.with_gain(k), COARSE) or proposal("general", s.with_gain(k), COARSE)) for k in gains]
        return [(k, p[0]) for k, p in found if p is not None]

    @cached_property
    def best_gain(self) -> tuple[float, Period] | None:
        """The |k| of the longest period, in two digits, and what is proved for it."""
        for k, _ in sorted(self._gains, key=lambda pair: -pair[1]):
            period = self.period_at(k)
            if period is not None:
                return k, period
        return None

    def safe_gains(self, seconds: float) -> tuple[float, float] | None:
        """The least and the largest |k| tried for which a period of so many seconds is proved."""
        enough = sorted(k for k, p in self._gains if p >= 0.9 * seconds)  # the search for it was coarse

        def proved(k: float) -> bool:
            period = self.period_at(k)
            return period is not None and period.seconds >= seconds

        least, largest = next(filter(proved, enough), None), next(filter(proved, reversed(enough)), None)
        own = self.period
        good = [k for k in (least, largest) if k is not None]
        good += [self.setting.law.gain] if own is not None and own.seconds >= seconds else []
        return (min(good), max(good)) if good else None

    # --------------------------------------------------------------------------------- continuous control

    @cached_property
    def reach(self) -> Array:
        """eps* by component (Theorem 4.1 for g that couples nothing): the least E with 4 k g_min q(E)/d+ >= P, and |eps(0)|;
        infinite where there is none below eps(e_max)."""
        s = self.setting
        need = np.where(s.least > 0, s.push * s.windows.wide / (4 * s.law.gain * np.maximum(s.least, 1e-300)), np.inf).max(axis=0)
        need = np.where(s.cross.sum(axis=(0, 2)) > 0, np.inf, need) * (1 + 1e-9)
        return np.maximum(_inverse_q(need, s.law.farthest), s.start)

    @cached_property
    def reach_norm(self) -> float:
        """eps* in norm, for any g: max(|eps(0)|, max gamma_d Phi/(4 k g_min))."""
        s = self.setting
        if not (s.definite > 0).all():
            return math.inf
        phi = s.push_norm / s.definite * s.windows.wide.max(axis=1) / (4 * s.law.gain)
        return max(float(phi.max()) * (1 + 1e-9), float(np.sqrt((s.start**2).sum())))

    @cached_property
    def effort(self) -> Array:
        """|u_i| <= max(|u_i(0)|, P_i/g_min,i) under continuous control, for g that couples nothing; else infinite."""
        s = self.setting
        with np.errstate(divide="ignore", invalid="ignore"):
            held = np.where(s.least > 0, s.push / s.least, np.inf).max(axis=0)
        first = 4 * s.law.gain * q(s.start) / s.windows.narrow[0] * (1 + 1e-9)
        return np.where(s.cross.sum(axis=(0, 2)) > 0, np.inf, np.maximum(held * (1 + 1e-9), first))

    # ---------------------------------------------------------------------------------------- hypotheses

    def hypotheses(self) -> Iterator[Hypothesis]:
        s, task, c = self.setting, self.controller.task, self.controller.certificate
        yield Hypothesis("tube", "the certificate holds: P1 to P7", c.holds)
        yield Hypothesis("start", "x(0) strictly inside gamma(0)", bool(np.isfinite(s.start).all()))
        least = float(s.definite.min())
        sign = "" if task.control.gain > 0 else "-"
        known = f"{sign}g_s > 0 over the tube" + (f", at least {below_float(least):g}" if math.isfinite(least) else "")
        yield Hypothesis("Assumption 2", known, least > 0)
        clamp = s.law.farthest
        inside = bool((self.reach < clamp).all()) or self.reach_norm < clamp or self.period is not None
        told = f"eps* <= eps(e_max) = {clamp:.4g} under continuous control, or a sampled statement holds: the clamp never acts"
        yield Hypothesis("Theorem 4.1", told, inside)
        if task.control.u_max is not None:
            free = self.period is not None or bool((self.effort <= s.law.u_max).all())
            yield Hypothesis("saturation", "u_max leaves the law what the tube asks for", free)
        if task.emit.tick_period is not None:
            period = self.period
            enough = period is not None and float(task.emit.tick_period) + self.latency <= period.seconds
            yield Hypothesis("sampling", f"emit.tick_period = {float(task.emit.tick_period):g} s is proved short enough", enough)
        if isinstance(self.controller.design, AdaptiveDesign):
            yield from self._adaptive

    @cached_property
    def _adaptive(self) -> list[Hypothesis]:
        """Lemma 3.3 repaired, and the four gaps, for this tube."""
        numbers = self.update_function
        least, needed = numbers["least_gap"], numbers["ln4_over_nu"]
        star = numbers["s_star"]
        if None in (least, needed, star):
            return [Hypothesis("update function", "psi + alpha is bounded away from 0", False)]
        return [
            Hypothesis("update function", f"psi + alpha >= s* = {star:g} > 0", star > 0),
            Hypothesis("four gaps", f"the least gap, {least:g}, is above ln 4/nu = {needed:g}", least > needed),
        ]

    @cached_property
    def update_function(self) -> dict[str, float]:
        """Bounds on psi + alpha, alpha and the gaps of an adaptive tube; s* = min over cells of psi + alpha, enclosed."""
        tube, design = self._enclosed, self.controller.design
        assert isinstance(design, AdaptiveDesign)
        psi, alpha, rho, beta = tube.lines.psi, tube.alpha, tube.lines.rho, tube.lines.beta
        low, high = 0, 1
        upper = (rho[:, :, 1, low] + alpha[:, :, 1, low], beta[:, :, 1, low])
        lower = (rho[:, :, 0, high] - alpha[:, :, 0, low], beta[:, :, 0, high])
        gap = min(float((a - b).min()) for a in upper for b in lower)
        return {
            "s_star": below_float(float((psi[..., low] + alpha[..., low]).min())),
            "psi_0": below_float(float(psi[0, ..., low].min())),
            "alpha_max": above_float(float(alpha[..., high].max())),
            "least_gap": below_float(gap),
            "ln4_over_nu": above_float(math.log(4) / float(design.nu)),
        }

    # ------------------------------------------------------------------------------------------ document

    def sampling(self) -> dict[str, Any]:
        """What a user chooses from: the proved period at his gain, the gain with the longest, the gains for a period."""
        task, best = self.controller.task, self.best_gain
        wanted = float(task.emit.tick_period or USUAL_PERIOD)
        gains = self.safe_gains(wanted + self.latency)
        sign = 1 if task.control.gain > 0 else -1
        return {
            "plant": self.name,
            "latency": self.latency,
            "assumes": self.assumptions(),
            "shortest": above_float(self.shortest),
            "gain": float(task.control.gain),
            "at_this_gain": _period(self.period),
            "longest": None if best is None else {"gain": sign * best[0], **_period(best[1])},
            "gains_at": {"period": wanted, "gains": None if gains is None else [sign * k for k in gains]},
        }

    def document(self) -> dict[str, Any]:
        """All of it as JSON data; SI units of the task."""
        controller, s, w = self.controller, self.setting, self.windows
        task = controller.task
        hypotheses = list(self.hypotheses())
        document: dict[str, Any] = {
            "task": task.name,
            "design": controller.design.kind,
            "scalar": controller.program.scalar,
            "plant": self.name,
            "noise": self.noise,
            "latency": self.latency,
            "hypotheses": [{"name": h.name, "statement": h.statement, "holds": h.holds} for h in hypotheses],
            "tube": {
                "lower": _rounded(w.low.min(axis=0), below_float),
                "upper": _rounded(w.high.max(axis=0), above_float),
                "least_width": _rounded(w.narrow.min(axis=0), below_float),
                "largest_width": _rounded(w.wide.max(axis=0), above_float),
                "speed": _rounded(w.speed.max(axis=0), above_float),
            },
            "plant_over_the_tube": {
                "push": _rounded(np.array([b.push for b in self.bounds]).max(axis=0), above_float),
                "g_diagonal_least": _rounded(s.least.min(axis=0), below_float),
                "g_cross_largest": _rounded(s.cross.max(axis=(0, 2)), above_float),
                "g_s_least_eigenvalue": below_float(float(s.definite.min())),
                "g_norm": above_float(float(s.norm.max())),
            },
            "continuous": {
                "epsilon_star": _rounded(self.reach, above_float),
                "epsilon_star_norm": above_float(self.reach_norm),
                "u": _rounded(self.effort, above_float),
            },
            "sampled": {name: _period(p) for name, p in self.periods.items()},
            "sampling": self.sampling(),
        }
        if isinstance(controller.design, AdaptiveDesign):
            document["update_function"] = self.update_function
        return document


def _period(period: Period | None) -> Any:
    """A period as JSON data; seconds rounded down."""
    if period is None:
        return None
    return {
        "statement": period.statement,
        "period": below_float(period.seconds),
        "e": above_float(period.e),
        "u": [above_float(v) for v in period.u],
        "tight": {"time": list(period.tight[:2]), "dimension": period.tight[2] or "all"},
    }


def _inverse_q(need: Array, most: float) -> Array:
    """The least E (rounded up) with q(E) >= need, shown in balls; infinite above `most`."""
    low, high = np.zeros(need.shape), np.full(need.shape, most)
    for _ in range(60):
        middle = (low + high) / 2
        enough = q(middle) >= need
        low, high = np.where(enough, low, middle), np.where(enough, middle, high)
    high = high * (1 + 1e-9)
    shown = [
        bool(q(np.array([arb(e)], dtype=object))[0] >= arb(v)) if math.isfinite(v) else False
        for e, v in zip(high, need, strict=True)
    ]
    return np.where(shown, high, np.inf)


def _rounded(values: Array, rounding: Any) -> list[float | None]:
    return [rounding(float(v)) for v in values]


def below_float(value: float) -> Any:
    """Four digits, not above the value; None where it is not finite."""
    return below(Fraction(value), 4) if math.isfinite(value) else None


def above_float(value: float) -> Any:
    """Four digits, not below the value; None where it is not finite."""
    return above(Fraction(value), 4) if math.isfinite(value) else None
