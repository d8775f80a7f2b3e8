"""Tubes that repeat for ever: the algebra of periodic signals, the seam where a cycle begins again, the clock, the checker, runs."""

from __future__ import annotations

import ctypes
import dataclasses
import hashlib
import json
import subprocess
from collections.abc import Mapping
from fractions import Fraction
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from stt_codegen.certify.missions.proof import cycle_of
from stt_codegen.certify.monitor import Cycle, holds
from stt_codegen.checker.stt_checker import formula as checked_formula
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.loop.command import with_gain
from stt_codegen.loop.simulate import EXTRA_CYCLES, Loop, Scenario
from stt_codegen.pipeline import EmittedController, build_program, certify, render_files
from stt_codegen.plants import plant_of
from stt_codegen.record.package import package
from stt_codegen.sampling.numbers import FRACTIONS
from stt_codegen.sampling.order_two import filtered_extremes
from stt_codegen.sampling.windows import extremes
from stt_codegen.task.load import parse_task
from stt_codegen.task.mission.formulas import Always, And, Eventually, Formula, InRegion, Interval, Or, Until
from stt_codegen.task.mission.regions import StateFormula, state_formulas_of, with_state_formulas
from tests.design.test_missions import NAMES, exit_code_of_checker, formulas
from tests.support.controllers import ROOT, build_once

BEGIN, END = 3, 8  # seconds: begin and end of the cycle that repeats
PLACES = 2 * END  # half seconds from 0 to END; END is not among them, because a signal there is as at BEGIN
WATCHMAN = (ROOT / "tasks" / "watchman.toml").read_text()
ORDER_TWO = WATCHMAN.replace("0.02", "0.005").replace(
    "[emit]", "[plant]\norder = 2\nf_max = 0.3\n[control]\nu_max = 20\nperiod = 0.005\n[emit]"
)


@cache
def watchman_controller(text: str = WATCHMAN) -> EmittedController:
    """Return the controller of the watchman, or of another task."""
    return build_once(parse_task(text))


# --------------------------------------------------------------------------------------------------- the algebra


def place_in_cycle(position: int) -> int:
    """Return the place before END at which the periodic signal has the same value."""
    return position if position < PLACES else 2 * BEGIN + (position - 2 * BEGIN) % (PLACES - 2 * BEGIN)


def truth(formula: Formula, signal: Mapping[str, Any]) -> Any:
    """Return whether a formula holds at each place, by its definition; a window without end is cut after two more cycles."""

    def places_in_window(t: int, over: Interval) -> range:
        last = t + 2 * PLACES + 2 * int(over.begin) if over.end is None else t + 2 * int(over.end)
        return range(t + 2 * int(over.begin), last + 1)

    match formula:
        case StateFormula(inner):
            return truth(inner, signal)
        case InRegion(region, is_negated):
            return signal[region] != is_negated
        case And(parts):
            return np.all([truth(p, signal) for p in parts], axis=0)
        case Or(parts):
            return np.any([truth(p, signal) for p in parts], axis=0)
        case Always(over, part):
            inner = truth(part, signal)
            return np.array([all(inner[place_in_cycle(s)] for s in places_in_window(t, over)) for t in range(PLACES)])
        case Eventually(over, part):
            inner = truth(part, signal)
            return np.array([any(inner[place_in_cycle(s)] for s in places_in_window(t, over)) for t in range(PLACES)])
        case Until(over, first, last):
            first_holds, last_holds = truth(first, signal), truth(last, signal)
            holds_at = []
            for t in range(PLACES):
                candidates = [s for s in places_in_window(t, over) if last_holds[place_in_cycle(s)]]
                holds_at.append(any(all(first_holds[place_in_cycle(r)] for r in range(t, s + 1)) for s in candidates))
            return np.array(holds_at)
    raise AssertionError(formula)


def signals() -> Any:
    """Signals that are true on closed intervals: what is true between two whole seconds is true at both."""

    def closed(bits: list[bool]) -> Any:
        signal = np.array(bits, dtype=bool)
        for k in range(1, PLACES, 2):
            if signal[k]:
                signal[k - 1] = signal[place_in_cycle(k + 1)] = True
        return signal

    return st.lists(st.booleans(), min_size=PLACES, max_size=PLACES).map(closed)


def proved_of(formula: Formula, signal: Mapping[str, Any]) -> dict[StateFormula, list[tuple[Any, Any]]]:
    """Return, by state formula, the closed intervals until END on which it holds."""
    intervals: dict[StateFormula, list[tuple[Any, Any]]] = {}
    for state in state_formulas_of(formula):
        bits = truth(state.inner, signal)
        spans: list[tuple[Any, Any]] = [
            (Fraction(k, 2), Fraction(k, 2)) for k in range(0, PLACES + 1, 2) if bits[place_in_cycle(k)]
        ]
        full_seconds = [k for k in range(1, PLACES, 2) if bits[k] and bits[k - 1] and bits[place_in_cycle(k + 1)]]
        spans += [(Fraction(k - 1, 2), Fraction(k + 1, 2)) for k in full_seconds]
        merged: list[tuple[Any, Any]] = []
        for a, b in sorted(spans):
            if merged and a <= merged[-1][1]:
                merged[-1] = (merged[-1][0], max(b, merged[-1][1]))
            else:
                merged.append((a, b))
        intervals[state] = [(-float("inf") if a == 0 else a, b) for a, b in merged]
    return intervals


def with_endless_windows(formula: Formula, drawn: list[bool]) -> Formula:
    """Return the formula with some windows that have no end, and perhaps all three times as long, which is longer than a cycle."""
    ends, times = iter(drawn), 3 if drawn[-1] else 1

    def window(over: Interval) -> Interval:
        assert over.end is not None
        return Interval(times * over.begin, None if next(ends) else times * over.end)

    def with_new_windows(subformula: Formula) -> Formula:
        """Return the formula with the new windows, in the order of its parts."""
        match subformula:
            case And(parts):
                return And(tuple(map(with_new_windows, parts)))
            case Or(parts):
                return Or(tuple(map(with_new_windows, parts)))
            case Always(over, part):
                return Always(window(over), with_new_windows(part))
            case Eventually(over, part):
                return Eventually(window(over), with_new_windows(part))
            case Until(over, first, last):
                return Until(window(over), with_new_windows(first), with_new_windows(last))
        return subformula

    return with_new_windows(formula)


def to_checker_formula(formula: Formula) -> Any:
    """Return a formula in the form of the stand-alone checker, nested tuples."""
    match formula:
        case StateFormula(inner):
            return to_checker_formula(inner)
        case InRegion(region, is_negated):
            return ("out" if is_negated else "in", region)
        case And(parts) | Or(parts):
            return ("and" if isinstance(formula, And) else "or", *map(to_checker_formula, parts))
        case Always(over, _) | Eventually(over, _) | Until(over, _, _):
            window = (over.begin, float("inf") if over.end is None else over.end)
            parts_ = (formula.first, formula.last) if isinstance(formula, Until) else (formula.part,)
            return (type(formula).__name__.lower(), window, *map(to_checker_formula, parts_))
    raise AssertionError(formula)


CASE = st.tuples(
    formulas(4), st.lists(st.booleans(), min_size=12, max_size=12), st.fixed_dictionaries({name: signals() for name in NAMES})
)


@given(CASE)
@settings(max_examples=300, deadline=None)
def test_what_the_algebra_proves_of_a_cycle_is_true_for_ever(case: Any) -> None:
    """This is so for every formula. Without "not" every set is closed, and all that is true is proved. The checker's algebra agrees."""
    formula, drawn, signal = case
    formula = with_endless_windows(formula, drawn)
    stated = with_state_formulas(formula, frozenset())
    proved, cycle = proved_of(stated, signal), Cycle(Fraction(BEGIN), Fraction(END))
    is_proved, is_true = holds(stated, proved, cycle=cycle), bool(truth(formula, signal)[0])
    assert not is_proved or is_true, str(formula)
    assert is_proved or not is_true or "not" in str(formula), str(formula)
    checker_intervals = {to_checker_formula(state): spans for state, spans in proved.items()}
    checker_proved = checked_formula.satisfied(
        to_checker_formula(stated), checker_intervals, checked_formula.Cycle(Fraction(BEGIN), Fraction(END), Fraction(0))
    )
    assert any(a <= 0 <= b for a, b in checker_proved) == is_proved, str(formula)


@given(CASE, st.integers(-2, 2), st.sampled_from([1, 2]))
@settings(max_examples=200, deadline=None)
def test_the_margin_in_time_covers_a_clock_that_is_off_in_every_cycle(case: Any, error: int, margin: int) -> None:
    """Every state may begin and end later or earlier by the margin, in half seconds, before the cycle and in each cycle. The checker
    subtracts the same margin."""
    formula, drawn, signal = case
    stated = with_state_formulas(with_endless_windows(formula, drawn), frozenset())
    proved, cycle = proved_of(stated, signal), Cycle(Fraction(BEGIN), Fraction(END))
    is_proved = holds(stated, proved, Fraction(margin, 2), cycle)
    checker_intervals = {to_checker_formula(state): spans for state, spans in proved.items()}
    checker_proved = checked_formula.satisfied(
        to_checker_formula(stated), checker_intervals, checked_formula.Cycle(Fraction(BEGIN), Fraction(END), Fraction(margin, 2))
    )
    assert any(a <= 0 <= b for a, b in checker_proved) == is_proved, str(stated)
    if is_proved and abs(error) <= margin:  # shift the signal, with one cycle written out
        shift = Fraction(error, 2)
        later = {s: [(a + shift, b + shift) for a, b in cycle.repeat_once(spans)] for s, spans in proved.items()}
        next_cycle = Cycle(Fraction(END) + shift, Fraction(END) + cycle.length + shift)
        assert holds(stated, {s: [(a if a > 0 else -float("inf"), b) for a, b in v] for s, v in later.items()}, cycle=next_cycle)


def test_what_happens_only_before_the_cycle_does_not_happen_for_ever() -> None:
    state, cycle = StateFormula(InRegion("a")), Cycle(Fraction(BEGIN), Fraction(END))
    formula = Always(Interval(), Eventually(Interval(Fraction(0), Fraction(5)), state))
    before_the_cycle: list[tuple[Any, Any]] = [(Fraction(1), Fraction(2))]
    assert not holds(formula, {state: before_the_cycle}, cycle=cycle)
    assert holds(formula, {state: [*before_the_cycle, (Fraction(6), Fraction(6))]}, cycle=cycle)
    assert not holds(formula, {state: [*before_the_cycle, (Fraction(6), Fraction(6))]}, Fraction(1, 4), cycle)


# --------------------------------------------------------------------------------------------------- tube and clock


def compile_clock(controller: EmittedController, folder: Path) -> Any:
    """Compile a controller, and return its functions that turn the clock back: in seconds and in ticks."""
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    p = controller.task.name
    path = folder / "clock.so"
    sources = [str(folder / f"{p}.c"), str(folder / f"{p}_wrap.c")]
    flags = [
        "-std=c99",
        "-O2",
        "-shared",
        "-fPIC",
        "-Wall",
        "-Wextra",
        "-Wpedantic",
        "-Wconversion",
        "-Werror",
        "-ffp-contract=off",
    ]
    subprocess.run(["gcc", *flags, *sources, "-o", str(path), "-lm"], check=True)
    library = ctypes.CDLL(str(path))
    wrap, tick = library[f"{p}_wrap"], library[f"{p}_wrap_tick"]
    wrap.restype, wrap.argtypes = ctypes.c_float, [ctypes.c_float]
    tick.restype, tick.argtypes = ctypes.c_uint32, [ctypes.c_uint32]
    return wrap, tick


@pytest.mark.parametrize("text", [WATCHMAN, ORDER_TWO], ids=["first order", "second order"])
def test_the_tube_is_twice_differentiable_where_it_begins_again(text: str) -> None:
    """Value, first and second difference are the same at t_c and on both sides of the begin of the cycle, in integers."""
    design = watchman_controller(text).design
    assert isinstance(design, RefinedDesign)
    assert design.seam is not None
    bezier = design.bezier().astype(object)
    last, first, before = bezier[-1], bezier[design.seam], bezier[design.seam - 1]
    for order in range(3):
        derivatives = [np.diff(piece, n=order, axis=-1) for piece in (last, first, before)]
        assert (derivatives[0][..., -1] == derivatives[1][..., 0]).all()
        assert (derivatives[2][..., -1] == derivatives[1][..., 0]).all()
    windows = extremes(design)  # proofs for samples take the cycle's first segment after the last one
    for name in ("narrow", "wide", "step", "width_step", "low", "high"):
        values = getattr(windows, name)
        assert (values[-1] == values[design.seam]).all()
    if design.filter:
        filtered = filtered_extremes(design)
        for values in (
            filtered.narrow,
            filtered.wide,
            filtered.width,
            filtered.middle,
            filtered.rate,
            *filtered.bends,
            *filtered.press,
        ):
            assert (values[-1] == values[design.seam]).all()
        exact = filtered_extremes(design, FRACTIONS)
        assert len(exact.narrow) == design.segments + 1
        assert exact.narrow[-1, 0] == exact.narrow[design.seam, 0]


def test_ticks_are_turned_back_exactly_for_ever(tmp_path: Path) -> None:
    """The wrapped count is the unwrapped one less whole cycles, exactly, after any number of turns."""
    controller = watchman_controller()
    cycle, tick = cycle_of(controller.design), controller.task.emit.tick_period  # type: ignore[arg-type]
    assert cycle is not None
    assert tick is not None
    _, wrap_tick = compile_clock(controller, tmp_path)
    last, length = int(cycle.end / tick), int(cycle.length / tick)
    wrapped = 0
    for count in range(6 * last):
        expected = count if count < last else last - length + (count - last) % length
        assert wrapped == expected
        wrapped = wrap_tick(wrapped + 1)


def test_turning_back_in_seconds_moves_the_clock_by_no_more_than_the_header_says(tmp_path: Path) -> None:
    controller = watchman_controller(
        WATCHMAN.replace("prescribed_time = 16", "prescribed_time = 15.7").replace("0.02", "0.00245312500")
    )
    wrap, _ = compile_clock(controller, tmp_path)
    cycle, p = cycle_of(controller.design), controller.task.name  # type: ignore[arg-type]
    assert cycle is not None
    stated = float(controller.files[f"{p}.h"].decode().split("moves the clock by up to ")[1].split()[0])
    t_c = np.float32(float(cycle.end))
    for t in np.random.default_rng(1).uniform(float(t_c), float(t_c + cycle.length), 2000).astype(np.float32):
        assert abs(Fraction(float(wrap(t))) - (Fraction(float(t)) - cycle.length)) <= Fraction(stated)
    assert wrap(np.nextafter(t_c, np.float32(0))) == np.nextafter(t_c, np.float32(0))
    assert np.isnan(wrap(float("nan")))


# --------------------------------------------------------------------------------------------------- from task to runs


@pytest.mark.parametrize("text", [WATCHMAN, ORDER_TWO], ids=["first order", "second order"])
def test_a_watchman_is_certified_accepted_and_runs_for_several_cycles(text: str, tmp_path: Path) -> None:
    controller = watchman_controller(text)
    assert controller.certificate.holds
    assert exit_code_of_checker(controller, text, tmp_path) == 0
    order = controller.task.order
    run = Loop(controller, plant_of("integrator", 2, order)).run(
        Scenario(rate=500.0, disturbance="nearest", strength=0.2), trace=True
    )
    assert run.good
    assert run.kept
    cycle = cycle_of(controller.design)  # type: ignore[arg-type]
    assert cycle is not None
    assert run.trace is not None
    assert run.trace[-1, 0] == pytest.approx(float(cycle.end + EXTRA_CYCLES * cycle.length))  # both are sums of a few doubles
    weak = Loop(with_gain(controller, [1e-5] * 2), plant_of("integrator", 2, order)).run(Scenario(rate=500.0))
    assert 1 in weak.missed  # outside its tube it misses the patrol, and the loop reports that


def claim_of(document: dict[str, Any], state: str) -> dict[str, Any]:
    """Return the certificate's claim of P10 about this state formula."""
    return next(c for c in document["claims"] if c["property"] == "P10" and c["set"] == state)


@pytest.mark.parametrize(
    ("file", "old", "new"),
    [
        ("watchman_wrap.c", "t - WATCHMAN_CYCLE", "t + WATCHMAN_CYCLE"),
        ("watchman_wrap.c", "t < WATCHMAN_T_C", "t <= WATCHMAN_T_C"),
        ("watchman_wrap.c", "tick - WATCHMAN_CYCLE_TICKS", "0U"),
        ("watchman.h", "CYCLE 14.0F", "CYCLE 14.25F"),
        ("watchman.h", "CYCLE_TICKS 700U", "CYCLE_TICKS 699U"),
        ("watchman.certificate.json", '"seam": 8', '"seam": 9'),
        ("watchman.certificate.json", '"seam": 8', '"seam": 0'),
        ("watchman.certificate.json", ', "seam": 8', ""),
    ],
)
def test_the_checker_refuses_a_clock_that_is_turned_back_wrongly(
    file: str, old: str, new: str, tmp_path: Path, capsys: Any
) -> None:
    """The certificate has the hash of the changed file."""
    controller = watchman_controller()
    text = controller.files[file].decode()
    assert old in text
    files = {**controller.files, file: text.replace(old, new).encode()}
    document = json.loads(files["watchman.certificate.json"])
    if file in document["sha256"]:
        document["sha256"][file] = hashlib.sha256(files[file]).hexdigest()
        files["watchman.certificate.json"] = json.dumps(document).encode()
    assert exit_code_of_checker(dataclasses.replace(controller, files=files), WATCHMAN, tmp_path) == 1
    assert "refused" in capsys.readouterr().out


@pytest.mark.parametrize("row", [0, 1, 2])
def test_a_kink_where_it_begins_again_is_refused_by_certificate_and_checker(row: int, tmp_path: Path, capsys: Any) -> None:
    """One of the last three control points is moved by one unit."""
    controller = watchman_controller()
    design = controller.design
    assert isinstance(design, RefinedDesign)
    table = design.integers().copy()
    table[-3 + row, 0, 0] += 1
    bent = dataclasses.replace(design, table=tuple(tuple((int(a), int(b)) for a, b in pairs) for pairs in table.tolist()))
    certified = certify(controller.task, bent, controller.program)
    assert [f.code for f in certified.findings if not f.holds] == ["P6"]
    forged = dataclasses.replace(certified, findings=controller.certificate.findings)
    files = render_files(controller.task, bent, build_program(controller.task, bent), forged)
    assert exit_code_of_checker(dataclasses.replace(controller, files=files), WATCHMAN, tmp_path) == 1
    assert "P6" in capsys.readouterr().out


@pytest.mark.parametrize("change", [("every = 14", "every = 13"), ('"store"]', '"store", "lab"]'), ("patrol =", "formula =")])
def test_tool_and_checker_refuse_the_tube_for_another_mission(change: tuple[str, str], tmp_path: Path, capsys: Any) -> None:
    """The cycle is 14 s: what it visits once, for less than a second, is not visited every 13 s, although it is in the first 16 s."""
    controller = watchman_controller()
    text = WATCHMAN.replace(*change)
    if change[0] == "patrol =":
        text = WATCHMAN.replace('patrol = ["gate", "office", "store"]\nevery = 14', 'formula = "always eventually[0, 13] gate"')
    task = parse_task(text)
    certified = certify(task, controller.design, controller.program)
    assert not certified.holds
    files = render_files(
        task, controller.design, controller.program, dataclasses.replace(certified, findings=controller.certificate.findings)
    )
    document = json.loads(files["watchman.certificate.json"])
    first = json.loads(controller.files["watchman.certificate.json"])
    document["claims"], document["grid"] = first["claims"], first["grid"]
    document["mission"] = {"formula": str(task.formula), "time_margin": first["mission"]["time_margin"]}
    files["watchman.certificate.json"] = json.dumps(document).encode()
    assert exit_code_of_checker(dataclasses.replace(controller, files=files), text, tmp_path) == 1
    output = capsys.readouterr().out
    assert "P10" in output or "hashes" in output


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (("[[mission]]\npatrol", "[target_set]\nlower = [5, 3]\nupper = [6, 4]\n[[mission]]\npatrol"), "target_set: is where a tube ends"),
        (("upper = [3.6, 2.4]", "upper = [3.6, 2.4]\nduring = [1, 2]"), "unsafe[0].during: with repeat = true"),
        (("repeat = true", "repeat = 1"), "repeat"),
        (("every = 14", "every = 17"), "mission[0].every: is 17"),
        (("0.02", "0.0037"), "emit.tick_period: is 0.0037 s, and with repeat = true no cycle would last whole ticks"),
    ],
)  # fmt: skip
def test_an_option_that_does_not_fit_repeat_is_refused_with_one_message(change: tuple[str, str], message: str) -> None:
    assert change[0] in WATCHMAN
    with pytest.raises((BadInput, NotCertified)) as error:
        build_once(parse_task(WATCHMAN.replace(*change)))
    assert message in str(error.value)
    assert "\n" not in str(error.value)


def test_repeat_without_a_mission_is_refused() -> None:
    text = WATCHMAN[: WATCHMAN.index("[[region]]")] + "[target_set]\nlower = [5, 3]\nupper = [6, 4]\n"
    with pytest.raises(BadInput, match="repeat: is for missions"):
        parse_task(text)


@pytest.mark.parametrize(
    "entry",
    [
        'formula = "always eventually gate"',
        'formula = "always (gate -> eventually[0, 8] office) and always eventually[0, 14] gate"',
        'formula = "always[0, 20] not lab and eventually[0, 20] store"',
        'formula = "eventually always gate"',
        'patrol = ["gate"]\nevery = 5\n[[mission]]\nvisit = "store"\nbetween = [2, 12]',
    ],
)
def test_missions_with_windows_without_end_or_longer_than_a_cycle_get_a_tube(entry: str, tmp_path: Path) -> None:
    text = WATCHMAN.replace('patrol = ["gate", "office", "store"]\nevery = 14', entry)
    controller = build_once(parse_task(text))
    assert exit_code_of_checker(controller, text, tmp_path) == 0
    if "eventually always" in entry:
        proof = controller.certificate.mission
        assert proof is not None
        assert any(w.end == float("inf") for w in proof.witnesses[0])


def test_a_round_that_has_too_little_time_is_refused_with_a_larger_max_speed() -> None:
    """This is so although the search tries rounds by the hundred."""
    with pytest.raises(NotCertified, match=r"tube.max_speed = 0.5.*certified with .*tube.max_speed = 0\.\d+"):
        build_once(parse_task(WATCHMAN.replace("[emit]", "[tube]\nmax_speed = 0.5\n[emit]")))


def test_a_period_that_rounds_to_nothing_on_a_clock_in_seconds_is_refused() -> None:
    slow = WATCHMAN.replace("prescribed_time = 16", "prescribed_time = 4000").replace("every = 14", "every = 3500")
    fast = "[control]\nperiod = 0.0001\n[plant]\nf_max = 0.01\n[emit]\n"
    with pytest.raises(BadInput, match=r"control.period: 0.0001 s is lost where a float adds it .* give emit.tick_period"):
        parse_task(slow.replace("[emit]\ntick_period = 0.02", fast))
    parse_task(slow.replace("[emit]\ntick_period = 0.02", fast + 'scalar = "double"\n'))


@pytest.mark.parametrize("tick", [True, False])
@pytest.mark.parametrize("outside", ["return", "stop"])
def test_packages_turn_the_clock_back_and_have_every_source(tick: bool, outside: str, tool: Any, tmp_path: Path) -> None:
    text = WATCHMAN if tick else WATCHMAN.replace("[emit]\ntick_period = 0.02", "")
    text += f'\n[control]\noutside = "{outside}"\n'
    controller = watchman_controller(text)
    sketch = package(controller, "arduino")["watchman/examples/watchman_loop/watchman_loop.ino"].decode()
    by_ticks = tick and outside == "return"  # a guard takes seconds
    assert ("ticks = watchman_wrap_tick(ticks)" if by_ticks else "watchman_wrap(elapsed * ") in sketch
    assert ("static uint32_t ticks" in sketch) == by_ticks
    files = package(controller, "cmake")
    library = files["watchman/CMakeLists.txt"].decode()
    for name in (n for n in files if n.endswith(".c")):
        assert name.removeprefix("watchman/") in library
