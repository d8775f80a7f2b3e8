"""Lemmas about the code of the worst path: it is run on numbers, beside the rules of docs/sampling-path.md in doubles or balls.

Both must agree to COMPARISON_TOLERANCE, and the code's result must be on the safe side but for the doubles' rounding. book.py
takes LEMMAS as a part of the family `path`.

Long because the rules are written out a second time, from the document and not from the code.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from flint import arb, ctx

from stt_codegen.lemmas.lemma import Lemma, Outcome, all_of, outcome_of_cases
from stt_codegen.sampling.path import (
    LOG_BITS,
    ComponentLaw,
    Drive,
    DriveCells,
    PathBounds,
    PathLoop,
    Start,
    WindowBounds,
    WorstPath,
    follow_worst_path,
    log_bounds,
    prove_path,
    prove_path_for,
)

F = Fraction
COMPARISON_TOLERANCE = 1e-9  # of the width, or of the input
BITS = 200  # of the balls


def _prove_logarithm() -> Outcome:
    """Enclose ln(p/q) in balls for quotients near 1, far from 1, and at the ends of the reduction."""
    pairs = [(p, q) for p in (1, 2, 3, 5, 127, 181, 182, 2**20 + 1, 2**47 - 1) for q in (1, 3, 4, 128, 2**20, 2**47 - 3)]
    pairs += [(1000 + k, 1000) for k in range(0, 1000, 37)]
    failures: list[str] = []
    precision = ctx.prec
    ctx.prec = BITS
    try:
        for p, q in pairs:
            low, high = log_bounds(p, q)
            exact = (arb(p) / arb(q)).log() * arb(2) ** LOG_BITS
            is_close = high - low <= 30 * (1 + abs(p.bit_length() - q.bit_length()))
            slack = arb(2) ** -60
            if not (arb(low) <= exact + slack and exact <= arb(high) + slack and is_close):
                failures.append(f"ln({p}/{q})")
    finally:
        ctx.prec = precision
    return outcome_of_cases(len(pairs), failures, "low <= 2^64 ln(p/q) <= high, at most 30 units and 30 more an octave apart")


# ------------------------------------------------------------------------------------------------ drives

DRIVES = (
    Drive(),
    Drive((F(1, 20),)),
    Drive((F(1, 20), F(1, 60))),
    Drive(slew=F(30)),
    Drive((F(1, 30),), F(25), F(1, 20)),
    Drive(overshoot=F(1, 8)),
)


class DriveReference:
    """What acts of commands that do not rise, in doubles: rules of section 3 and 6."""

    def __init__(self, drive: Drive, bound: float, cell: float) -> None:
        self.bound, self.slew_step = bound, None if drive.slew is None else float(drive.slew) * cell
        self.weight = float(drive.overshoot) / (1 - float(drive.overshoot))
        self.decays = [1 / sum((cell / float(lag)) ** j / math.factorial(j) for j in range(8)) for lag in drive.lags]
        self.ramp, self.stages = bound, [bound] * len(drive.lags)

    def source(self, command: float) -> float:
        """Return what comes out of the limit of the rate at the cell's begin."""
        return command if self.slew_step is None else max(command, self.ramp)

    def acting(self, command: float) -> float:
        """Return what acts at the cell's begin."""
        y = self.stages[-1] if self.stages else self.source(command)
        return y + self.weight * max(y + self.bound, 0)

    def step(self, command: float) -> None:
        """Pass one cell."""
        sources = [self.source(command), *self.stages]
        if self.slew_step is not None:
            self.ramp = max(command, self.ramp - self.slew_step)
        for k, decay in enumerate(self.decays):
            self.stages[k] = sources[k] + (self.stages[k] - sources[k]) * decay


def _prove_drive_evaluated() -> Outcome:
    """Run every drive on commands that fall in steps, fast and slowly, through 0 and to the opposite bound."""
    cell, unit, failures, case_count = F(1, 500), F(1, 1 << 40), list[str](), 0
    largest = 1 << 41  # 2 units of u
    for number, drive in enumerate(DRIVES):
        for fall in (1 << 34, 1 << 36, 1 << 39):
            cells, reference = DriveCells(drive, largest, unit, cell), DriveReference(drive, 2.0, float(cell))
            command = largest
            for _ in range(120):
                case_count += 1
                value, expected = cells.acting(command) * float(unit), reference.acting(command * float(unit))
                if not -1e-13 <= value - expected <= COMPARISON_TOLERANCE:
                    failures.append(f"drive {number}, fall {fall}: {value} for {expected}")
                    break
                cells.step(command)
                reference.step(command * float(unit))
                command = max(command - fall, -largest)
    slower = DRIVES[4].scaled(F(2))
    if (slower.lags, slower.slew, slower.overshoot) != ((F(1, 15),), F(25, 2), F(1, 20)):
        failures.append("a slower drive")
    if DRIVES[4].delay(F(3)) != F(1, 30) + F(6, 25) or DRIVES[5].amplification != 1 + 2 * F(1, 7):
        failures.append("delay or amplification")
    return outcome_of_cases(case_count, failures, "what acts is at most the code's, and equal to 1e-9")


# ------------------------------------------------------------------------------------------------ one path


@dataclass(frozen=True)
class PathReference:
    """One path by the rules of section 6, in doubles. levels: at the begin of every cell. history: A, in seconds."""

    levels: list[float]
    history: float | None


class ReferenceLaw:
    """Psi in doubles."""

    def __init__(self, bounds: PathBounds) -> None:
        self.bounds, self.r = bounds, float(bounds.rounding)
        width, clamp = float(bounds.wide + 2 * bounds.shift), float(1 - bounds.e_max) / 2
        limit = float(bounds.input_bound if bounds.u_max is None else bounds.u_max)
        self.smallest = max(self.pull(width * (1 - clamp), width * clamp), -limit)

    def pull(self, far: float, near: float) -> float:
        """Return a bound on u from above at these distances."""
        log = math.log(far / near) - self.r
        return -float(self.bounds.gain) * (1 / far + 1 / near) * log * (1 - self.r if log > 0 else 1 + self.r)

    def psi(self, level: float) -> float:
        near = level + float(self.bounds.shift)
        far = float(self.bounds.narrow) - near
        bound = float(self.bounds.input_bound)
        return bound if far <= 0 else min(max(self.pull(far, near), self.smallest), bound)


def cell_of(bounds: PathBounds) -> float:
    """Return h: 4 to 7 times a power of two."""
    drive = bounds.drive
    delay = float(bounds.age + sum(drive.lags)) + (2 * float(bounds.input_bound / drive.slew) if drive.slew else 0.0)
    crossing = float(bounds.narrow / (bounds.closing_speed + bounds.g_max * bounds.input_bound))
    longest = max(delay / 96, crossing / 512)
    return max(k * 2.0**e for k in (4, 5, 6, 7) for e in range(-40, 10) if k * 2.0**e <= longest)


def reference_path(bounds: PathBounds, start: Start | None) -> PathReference:
    """Follow a path."""
    h, law = cell_of(bounds), ReferenceLaw(bounds)
    speed, rate, bound = float(bounds.closing_speed), float(bounds.filter_rate), float(bounds.input_bound)
    begin = 0.0 if start is None else float(start.nearest)

    def at_edge(y: float) -> float:
        return speed + float(bounds.g_max if y > 0 else bounds.g_min) * y

    level = float(bounds.wide)
    while level * 7 / 8 > begin and law.psi(level * 7 / 8) == bound:
        level = level * 7 / 8
    levels, drive, age_cells = [level], DriveReference(bounds.drive, bound, h), math.ceil(float(bounds.age) / h)
    newer, start_cell = age_cells - float(bounds.age) / h, None if start is not None else 0
    while True:
        command, cell = bound, len(levels) - 1
        if cell >= age_cells:
            older, after = levels[cell - age_cells], levels[cell - age_cells + 1]
            command = law.psi(older + (after - older) * newer)
        if start_cell is None and level <= begin:
            start_cell = cell
        if start is not None and (start_cell is None or (cell - start_cell) * h < float(start.first_input)):
            command = max(command, 0.0)
        y = drive.acting(command)
        falls = at_edge(y) - rate * level
        if start_cell is not None and (falls if start is not None else at_edge(y)) < 0:
            break
        smallest = speed / 64 if start_cell is not None else at_edge(bound) / 16
        level -= h * max(falls / (1 - rate * h), smallest)
        if level <= 0:
            return PathReference([*levels, 0.0], None)
        levels.append(level)
        drive.step(command)
    waiting, forgetting = DriveReference(bounds.drive, bound, h), 0
    while start is None and at_edge(waiting.acting(law.psi(level))) >= 0 and forgetting < 5000:
        waiting.step(law.psi(level))
        forgetting += 1
    return PathReference(levels, None if start is not None else (len(levels) + age_cells + forgetting + 1) * h)


BASE = PathBounds(
    closing_speed=F(7, 10), filter_rate=F(0), g_min=F(19, 20), g_max=F(21, 20), input_bound=F(2), u_max=F(2), gain=F(1, 25),
    narrow=F(9, 10), wide=F(1), shift=F(1, 200), rounding=F(1, 1 << 19), e_max=F(99, 100), age=F(1, 50), drive=Drive(),
)  # fmt: skip
CASES: tuple[tuple[str, PathBounds], ...] = (
    ("no drive", BASE),
    ("a lag", replace(BASE, drive=DRIVES[1])),
    ("two lags, a wide tube", replace(BASE, drive=Drive((F(1, 60), F(1, 80))), wide=F(11, 10))),
    ("a slew", replace(BASE, drive=Drive(slew=F(60)))),
    ("all of it", replace(BASE, drive=Drive((F(1, 50),), F(90), F(1, 50)), closing_speed=F(6, 10))),
    ("order 2", replace(BASE, filter_rate=F(1, 2), g_min=F(1), drive=DRIVES[1])),
    ("at the clamp", replace(BASE, e_max=F(4, 5), gain=F(1, 12))),
    ("no limit", replace(BASE, u_max=None, input_bound=F(3), gain=F(1, 20))),
    ("a long age", replace(BASE, age=F(7, 100), closing_speed=F(1, 2))),
    ("coarse rounding", replace(BASE, rounding=F(1, 16), gain=F(1, 15))),
    ("a drive that is too late", replace(BASE, drive=Drive((F(1, 4),)))),
)
AT_REST = replace(BASE, filter_rate=F(2), closing_speed=F(1, 2))  # of order 2: where lambda b > P nothing moves the path on
STARTS: tuple[Start | None, ...] = (None, Start(F(1, 20), F(0)), Start(F(1, 20), F(1, 900)), Start(F(3, 10), F(1, 40)))


def _path_failures(name: str, bounds: PathBounds, start: Start | None) -> Iterator[str]:
    """Yield what differs between the code's path and the reference."""
    path, reference = follow_worst_path(bounds, start), reference_path(bounds, start)
    expected, nearest = reference.levels[-1], float(path.nearest)
    if abs(nearest - expected) > COMPARISON_TOLERANCE or nearest > expected + 1e-12:
        yield f"{name}, {start}: Q_pk = {nearest} for {expected}"
    if nearest and path.cells != len(reference.levels):
        yield f"{name}, {start}: {path.cells} cells for {len(reference.levels)}"
    history = None if path.history is None else float(path.history)
    if (history is None) != (reference.history is None) or abs((history or 0) - (reference.history or 0)) > 1e-9:
        yield f"{name}, {start}: A = {history} for {reference.history}"
    if start is not None and path.nearest > start.nearest:
        yield f"{name}, {start}: it ended before the start"
    if path.nearest and path.rho(bounds.wide) != bounds.wide / path.nearest - 1:
        yield f"{name}, {start}: rho"


def _prove_path_evaluated() -> Outcome:
    """Run the code on every case, from several starts and with recent bounds alone."""
    failures = [text for name, bounds in CASES for start in STARTS for text in _path_failures(name, bounds, start)]
    failures += [text for start in STARTS[1:] for text in _path_failures("at rest above the start", AT_REST, start)]
    ended = sum(follow_worst_path(bounds, STARTS[1]).nearest > 0 for _, bounds in CASES)
    failures += [] if 5 <= ended < len(CASES) else [f"{ended} paths from the start turn round"]
    refused = (replace(BASE, shift=F(9, 20)), replace(BASE, filter_rate=F(10**6)))
    failures += [f"no path: {b}" for b in refused if follow_worst_path(b, STARTS[1]) != WorstPath(F(0), None, 0)]
    case_count = len(CASES) * len(STARTS) + len(STARTS[1:]) + len(refused)
    return outcome_of_cases(case_count, failures, "Q_pk, its cell and A are those of the rules")


# ------------------------------------------------------------------------------------------------ whole loops

WINDOWS = tuple(
    WindowBounds(closing_speed=s, cross=(F(0), c), g_min=F(9, 10) + s / 100, g_max=F(11, 10) + c, narrow=w, wide=w * F(21, 20))
    for s, c, w in (
        (F(4, 10), F(1, 50), F(9, 10)),
        (F(5, 10), F(1, 40), F(1)),
        (F(6, 10), F(1, 30), F(12, 10)),
        (F(3, 10), F(0), F(1)),
        (F(2, 10), F(1, 90), F(8, 10)),
        (F(2, 10), F(0), F(9, 10)),
    )
)
LAW = ComponentLaw(
    gain=F(1, 30), e_max=F(99, 100), shift=F(1, 300), u_max=F(9, 4), rounding=F(1, 1 << 19), filter_rate=F(0), rho_at_start=F(9)
)


def loop_of_drive(drive: Drive, latency: Fraction) -> PathLoop:
    """Return a loop of two coupled components in six windows of two thirds of a second."""
    second = tuple(
        replace(window, cross=(window.cross[1], F(0)), closing_speed=window.closing_speed * F(9, 10)) for window in WINDOWS
    )
    return PathLoop(
        begins=tuple(F(2 * k, 3) for k in range(len(WINDOWS))),
        windows=(WINDOWS, second),
        laws=(LAW, replace(LAW, gain=F(1, 25), rho_at_start=F(7))),
        drives=(drive, Drive(overshoot=F(1, 10))),
        age=F(1, 40) + latency,
        latency=latency,
        largest_known_age=math.inf,
    )


def _prove_joined() -> Outcome:
    """Compare the bounds over windows, U, and starts with their formulas."""
    loop, failures, case_count = loop_of_drive(DRIVES[1], F(1, 100)), list[str](), 0
    inputs = (F(2), F(9, 4))
    acting = F(9, 4) * (1 + 2 * F(1, 9))  # of the other component
    for first in range(len(WINDOWS)):
        for last in range(first, len(WINDOWS)):
            bounds, windows = loop.bounds_over(0, first, last, inputs), WINDOWS[first : last + 1]
            expected = (
                max(r.closing_speed + r.cross[1] * acting for r in windows), min(r.g_min for r in windows),
                max(r.g_max for r in windows), min(r.narrow for r in windows), max(r.wide for r in windows), F(2), F(7, 200),
                DRIVES[1],
            )  # fmt: skip
            values = (
                bounds.closing_speed, bounds.g_min, bounds.g_max, bounds.narrow, bounds.wide, bounds.input_bound, bounds.age,
                bounds.drive,
            )  # fmt: skip
            case_count += 1
            failures += [] if values == expected else [f"bounds over windows {first} to {last}"]
    start, component = loop.start(1), loop.component(1)
    failures += [] if (start.nearest, start.first_input) == (F(9, 10) / 8, F(1, 100)) else ["the start"]
    failures += (
        [] if component.windows[0][2].closing_speed == F(54, 100) and component.drives == loop.drives[1:] else ["a component"]
    )
    failures += [] if [loop.window_at(F(t, 3)) for t in (0, 1, 2, 9, 30)] == [0, 0, 1, 4, 5] else ["the window of a time"]
    failures += [] if loop.with_period(F(1, 5)).age == F(21, 100) else ["the age of another period"]
    return all_of(
        outcome_of_cases(case_count + 4, failures, "bounds, starts and windows are those of the windows"), _check_input_bound()
    )


def _check_input_bound() -> Outcome:
    """Compare U with the law at the farthest position that it may see, or at its clamp."""
    failures: list[str] = []
    for narrow, rho, e_max, u_max in ((0.8, 20, 0.99, None), (0.8, 400, 0.99, None), (1.1, 90, 0.9, None), (1.0, 19, 0.99, 0.5)):
        law = replace(LAW, e_max=F(e_max), u_max=None if u_max is None else F(u_max))
        near, far, clamp = narrow / (1 + rho) - 1 / 300, narrow * rho / (1 + rho) + 1 / 300, (1 - e_max) / 2
        if near <= (near + far) * clamp:
            near, far = clamp * (narrow - 1 / 150), (1 - clamp) * (narrow - 1 / 150)
        expected = (1 / near + 1 / far) * (math.log(far / near) + 2.0**-19) * (1 + 2.0**-19) / 30
        value = law.input_bound(F(narrow), F(rho))
        wanted = expected if u_max is None else min(expected, u_max)
        if value is None or abs(float(value) - wanted) > 1e-9 * wanted:
            failures.append(f"U for {narrow}, {rho}, {e_max}: {value}")
    unlimited = replace(LAW, u_max=None, shift=F(1))
    failures += [] if unlimited.input_bound(F(1), F(9)) is None else ["a law that may see any position"]
    return outcome_of_cases(5, failures, "U is the law's largest input within e^E = rho")


def changing_loop() -> PathLoop:
    """Return a loop whose tube is narrow and slow at first and wide and quick later, which only recent bounds prove."""
    speeds_and_widths = [(F(35, 100), F(8, 10))] * 6 + [(F(6, 10), F(12, 10))] * 4 + [(F(3, 2), F(8, 5))] * 6
    windows = tuple(
        WindowBounds(closing_speed=speed, cross=(F(0),), g_min=F(1), g_max=F(1), narrow=width, wide=width)
        for speed, width in speeds_and_widths
    )
    begins = tuple(F(k, 2) for k in range(len(windows)))
    law = replace(LAW, gain=F(1, 25), shift=F(1, 200), u_max=F(2), rho_at_start=F(19))
    drive = Drive((F(6, 100),))
    return replace(loop_of_drive(drive, F(0)), begins=begins, windows=(windows,), laws=(law,), drives=(drive,), age=F(1, 50))


def _prove_proof() -> Outcome:
    """Check that a proof's paths are all that it needs, by following every window's path without leaving any out."""
    failures: list[str] = []
    loops = [
        loop_of_drive(Drive((F(9, 100),)), F(0)),
        loop_of_drive(Drive((F(1, 8),)), F(0)),
        loop_of_drive(DRIVES[4], F(1, 50)),
        changing_loop(),
    ]
    for number, loop in enumerate(loops):
        proof = prove_path(loop)
        if proof is None:
            failures.append(f"loop {number} is not proved")
            continue
        for i, path in enumerate(proof.paths):
            nearest, wide, cell_count = _nearest_of_all(loop, i, proof.u, path.history)
            rho_needed = wide / nearest - 1
            failures += [] if path.cells == cell_count else [f"loop {number}, component {i}: paths that are not needed"]
            if abs(float(path.rho / rho_needed) - 1) > 1e-3 or not path.rho < proof.rho[i] < path.rho * F(1001, 1000):
                failures.append(f"loop {number}, component {i}: rho {float(proof.rho[i])} for {rho_needed}")
        if prove_path_for(loop, [v * F(9, 10) for v in proof.rho]) is not None or prove_path_for(loop, proof.rho) is None:
            failures.append(f"loop {number}: another rho")
    if prove_path(replace(loops[0], largest_known_age=F(1, 100))) is not None:
        failures.append("an age of which nothing is known")
    proof_by_windows = prove_path(loops[-1])
    if proof_by_windows is None or proof_by_windows.paths[0].history is None:
        failures.append("no loop needs recent bounds")
    return outcome_of_cases(len(loops) + 2, failures, "the paths of all windows, each by the rules, prove rho")


def _nearest_of_all(loop: PathLoop, i: int, inputs: Sequence[Fraction], history: Fraction | None) -> tuple[float, float, int]:
    """Return Q_pk and W+ of the path with the largest W+/Q_pk, over all windows of a component, and the cells of those needed.

    A window has its own path, or that of another window whose bounds hold for it too, if that needs less history.
    """
    last = len(loop.begins) - 1
    first_local = last + 1 if history is None else next(k for k, t in enumerate(loop.begins) if t >= history)
    early = loop.bounds_over(i, 0, first_local - 1, inputs)
    from_start = reference_path(early, loop.start(i)).levels
    results, cell_count = [(from_start[-1], float(early.wide))], len(from_start)
    stretches: list[PathBounds] = []
    for k in range(first_local, last + 1):
        begin = loop.begins[k] - (history or F(0))
        bounds = loop.bounds_over(i, max(j for j, t in enumerate(loop.begins) if t <= begin), k, inputs)
        stretches += [] if bounds in stretches else [bounds]
    paths = [reference_path(bounds, None) for bounds in stretches]
    for bounds, path_of_window in zip(stretches, paths, strict=True):
        usable = [
            (path.levels[-1], float(wider_bounds.wide))
            for wider_bounds, path in zip(stretches, paths, strict=True)
            if _hold_for(wider_bounds, bounds) and (path.history or math.inf) <= float(history or 0)
        ]
        results.append(max(usable, key=lambda result: result[0] / result[1], default=(1e-9, float(bounds.wide))))
        is_needed = not any(_hold_for(wider_bounds, bounds) for wider_bounds in stretches if wider_bounds != bounds)
        cell_count += len(path_of_window.levels) if is_needed else 0
    return (*min(results, key=lambda result: result[0] / result[1]), cell_count)


def _hold_for(wider: PathBounds, bounds: PathBounds) -> bool:
    """Return whether bounds hold wherever the second ones do."""
    upper = ("closing_speed", "wide", "g_max", "input_bound")
    is_above = all(getattr(wider, name) >= getattr(bounds, name) for name in upper)
    return is_above and wider.narrow <= bounds.narrow and wider.g_min <= bounds.g_min


LEMMAS = (
    Lemma(
        "path.logarithm",
        "The logarithm of a quotient of whole numbers is between the code's bounds.",
        r"low \le 2^{64}\ln(p/q) \le high",
        (),
        "the evaluated code",
        _prove_logarithm,
    ),
    Lemma(
        "path.drive_evaluated",
        "The code's bound on what acts is that of the rules, rounded up.",
        r"Y \mapsto c + (Y - c)\,q",
        (),
        "the evaluated code",
        _prove_drive_evaluated,
        ("path.drive", "path.cells"),
    ),
    Lemma(
        "path.evaluated",
        "The code's path is that of the rules, on the safe side: Q_pk, the cell in which it ends, and the history that it needs.",
        r"Q_{pk},\ A",
        (),
        "the evaluated code",
        _prove_path_evaluated,
        ("path.cells", "path.early", "path.ends", "path.logarithm", "path.drive_evaluated"),
    ),
    Lemma(
        "path.joined",
        "The code's bounds over several windows are the worst of each, with the other inputs and what makes them larger.",
        r"P = \max_k \bigl(P_k + \textstyle\sum_j |g_{ij}| (1 + 2\nu_j) U_j\bigr)",
        (),
        "the evaluated code",
        _prove_joined,
        ("sampled.coupled", "sampled.shift"),
    ),
    Lemma(
        "path.proof",
        "The code's proof needs what the paths of all windows need: windows that it leaves out are covered.",
        r"\rho_i > W^+/Q_{pk} - 1",
        (),
        "the evaluated code",
        _prove_proof,
        ("path.local", "path.evaluated", "path.joined"),
    ),
)
