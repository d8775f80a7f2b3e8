"""Tubes that repeat themselves for ever: the algebra of what is periodic, the seam, the clock, the checker, runs."""

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

from stt_codegen.certify import checker
from stt_codegen.certify.missions.proof import cycle_of
from stt_codegen.certify.monitor import Cycle, holds
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import BadInput, NotCertified
from stt_codegen.loop.command import with_gain
from stt_codegen.loop.simulate import CYCLES, Loop, Scenario
from stt_codegen.pipeline import EmittedController, build_program, certify, render_files
from stt_codegen.plants import plant_of
from stt_codegen.record.package import package
from stt_codegen.sampling.numbers import FRACTIONS
from stt_codegen.sampling.order_two import filtered_extremes
from stt_codegen.sampling.windows import extremes
from stt_codegen.task.load import parse_task
from stt_codegen.task.mission.formulas import Always, And, Eventually, Formula, InRegion, Interval, Or, Until
from stt_codegen.task.mission.regions import StateFormula, state_formulas_of, with_state_formulas
from tests.design.test_missions import NAMES, checked, formulas
from tests.support.controllers import ROOT, built

BEGIN, END = 3, 8  # seconds: what happens from the one to the other happens again and again
PLACES = 2 * END  # half seconds from 0 on, END excluded: there it is as at BEGIN
WATCHMAN = (ROOT / "tasks" / "watchman.toml").read_text()
SECOND = WATCHMAN.replace("0.02", "0.005").replace(
    "[emit]", "[plant]\norder = 2\nf_max = 0.3\n[control]\nu_max = 20\nperiod = 0.005\n[emit]"
)


@cache
def the_watchman(text: str = WATCHMAN) -> EmittedController:
    return built(parse_task(text))


# --------------------------------------------------------------------------------------------------- the algebra


def folded(place: int) -> int:
    """The place before END at which all is as there."""
    return place if place < PLACES else 2 * BEGIN + (place - 2 * BEGIN) % (PLACES - 2 * BEGIN)


def truth(formula: Formula, signal: Mapping[str, Any]) -> Any:
    """Whether a formula holds at each place: by its definition. What is for ever is looked at for two cycles more than there are."""

    def reach(t: int, over: Interval) -> range:
        last = t + 2 * PLACES + 2 * int(over.begin) if over.end is None else t + 2 * int(over.end)
        return range(t + 2 * int(over.begin), last + 1)

    match formula:
        case StateFormula(inner):
            return truth(inner, signal)
        case InRegion(region, kept):
            return signal[region] != kept
        case And(parts):
            return np.all([truth(p, signal) for p in parts], axis=0)
        case Or(parts):
            return np.any([truth(p, signal) for p in parts], axis=0)
        case Always(over, part):
            inner = truth(part, signal)
            return np.array([all(inner[folded(s)] for s in reach(t, over)) for t in range(PLACES)])
        case Eventually(over, part):
            inner = truth(part, signal)
            return np.array([any(inner[folded(s)] for s in reach(t, over)) for t in range(PLACES)])
        case Until(over, first, last):
            held, reached = truth(first, signal), truth(last, signal)
            found = []
            for t in range(PLACES):
                good = [s for s in reach(t, over) if reached[folded(s)]]
                found.append(any(all(held[folded(r)] for r in range(t, s + 1)) for s in good))
            return np.array(found)
    raise AssertionError(formula)


def signals() -> Any:
    """What is true between two whole seconds is true at both."""

    def closed(bits: list[bool]) -> Any:
        found = np.array(bits, dtype=bool)
        for k in range(1, PLACES, 2):
            if found[k]:
                found[k - 1] = found[folded(k + 1)] = True
        return found

    return st.lists(st.booleans(), min_size=PLACES, max_size=PLACES).map(closed)


def proved_of(formula: Formula, signal: Mapping[str, Any]) -> dict[StateFormula, list[tuple[Any, Any]]]:
    """The closed intervals on which each state holds, until END."""
    found: dict[StateFormula, list[tuple[Any, Any]]] = {}
    for state in state_formulas_of(formula):
        bits = truth(state.inner, signal)
        spans: list[tuple[Any, Any]] = [(Fraction(k, 2), Fraction(k, 2)) for k in range(0, PLACES + 1, 2) if bits[folded(k)]]
        whole = [k for k in range(1, PLACES, 2) if bits[k] and bits[k - 1] and bits[folded(k + 1)]]
        spans += [(Fraction(k - 1, 2), Fraction(k + 1, 2)) for k in whole]
        merged: list[tuple[Any, Any]] = []
        for a, b in sorted(spans):
            if merged and a <= merged[-1][1]:
                merged[-1] = (merged[-1][0], max(b, merged[-1][1]))
            else:
                merged.append((a, b))
        found[state] = [(-float("inf") if a == 0 else a, b) for a, b in merged]
    return found


def endless(formula: Formula, drawn: list[bool]) -> Formula:
    """The same formula with some windows that have no end, and all of them three times as long, or not: longer than a cycle."""
    ends, times = iter(drawn), 3 if drawn[-1] else 1

    def window(over: Interval) -> Interval:
        assert over.end is not None
        return Interval(times * over.begin, None if next(ends) else times * over.end)

    def told(one: Formula) -> Formula:
        match one:
            case And(parts):
                return And(tuple(map(told, parts)))
            case Or(parts):
                return Or(tuple(map(told, parts)))
            case Always(over, part):
                return Always(window(over), told(part))
            case Eventually(over, part):
                return Eventually(window(over), told(part))
            case Until(over, first, last):
                return Until(window(over), told(first), told(last))
        return one

    return told(formula)


def in_tuples(formula: Formula) -> Any:
    """As the stand-alone checker has formulas."""
    match formula:
        case StateFormula(inner):
            return in_tuples(inner)
        case InRegion(region, kept):
            return ("out" if kept else "in", region)
        case And(parts) | Or(parts):
            return ("and" if isinstance(formula, And) else "or", *map(in_tuples, parts))
        case Always(over, _) | Eventually(over, _) | Until(over, _, _):
            window = (over.begin, float("inf") if over.end is None else over.end)
            parts_ = (formula.first, formula.last) if isinstance(formula, Until) else (formula.part,)
            return (type(formula).__name__.lower(), window, *map(in_tuples, parts_))
    raise AssertionError(formula)


CASE = st.tuples(
    formulas(4), st.lists(st.booleans(), min_size=12, max_size=12), st.fixed_dictionaries({name: signals() for name in NAMES})
)


@given(CASE)
@settings(max_examples=300, deadline=None)
def test_what_the_algebra_says_of_a_cycle_holds_for_ever(case: Any) -> None:
    """Sound for every formula. Nothing is lost where there is no "not", for then every set is closed. The checker's own algebra
    says the same."""
    formula, drawn, signal = case
    formula = endless(formula, drawn)
    stated = with_state_formulas(formula, frozenset())
    proved, cycle = proved_of(stated, signal), Cycle(Fraction(BEGIN), Fraction(END))
    found, true = holds(stated, proved, cycle=cycle), bool(truth(formula, signal)[0])
    assert not found or true, str(formula)
    assert found or not true or "not" in str(formula), str(formula)
    known = {in_tuples(state): spans for state, spans in proved.items()}
    theirs = checker.satisfied(in_tuples(stated), known, checker.Cycle(Fraction(BEGIN), Fraction(END), Fraction(0)))
    assert any(a <= 0 <= b for a, b in theirs) == found, str(formula)


@given(CASE, st.integers(-2, 2), st.sampled_from([1, 2]))
@settings(max_examples=200, deadline=None)
def test_the_margin_in_time_covers_a_clock_that_is_off_in_every_cycle(case: Any, off: int, margin: int) -> None:
    """By the margin, in halves of a second, every state may begin and end later or earlier, in the lead-in and in each cycle. The
    checker takes the same off."""
    formula, drawn, signal = case
    stated = with_state_formulas(endless(formula, drawn), frozenset())
    proved, cycle = proved_of(stated, signal), Cycle(Fraction(BEGIN), Fraction(END))
    found = holds(stated, proved, Fraction(margin, 2), cycle)
    known = {in_tuples(state): spans for state, spans in proved.items()}
    theirs = checker.satisfied(in_tuples(stated), known, checker.Cycle(Fraction(BEGIN), Fraction(END), Fraction(margin, 2)))
    assert any(a <= 0 <= b for a, b in theirs) == found, str(stated)
    if found and abs(off) <= margin:  # in the unrolled signal everything so much later
        shift = Fraction(off, 2)
        later = {s: [(a + shift, b + shift) for a, b in cycle.repeat_once(spans)] for s, spans in proved.items()}
        one_on = Cycle(Fraction(END) + shift, Fraction(END) + cycle.length + shift)
        assert holds(stated, {s: [(a if a > 0 else -float("inf"), b) for a, b in v] for s, v in later.items()}, cycle=one_on)


def test_a_cycle_in_which_something_does_not_happen_is_no_cycle_in_which_it_does() -> None:
    state, cycle = StateFormula(InRegion("a")), Cycle(Fraction(BEGIN), Fraction(END))
    again = Always(Interval(), Eventually(Interval(Fraction(0), Fraction(5)), state))
    lead: list[tuple[Any, Any]] = [(Fraction(1), Fraction(2))]
    assert not holds(again, {state: lead}, cycle=cycle)
    assert holds(again, {state: [*lead, (Fraction(6), Fraction(6))]}, cycle=cycle)
    assert not holds(again, {state: [*lead, (Fraction(6), Fraction(6))]}, Fraction(1, 4), cycle)


# --------------------------------------------------------------------------------------------------- tube and clock


def compiled(controller: EmittedController, folder: Path) -> Any:
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    p = controller.task.name
    made = folder / "own.so"
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
    subprocess.run(["gcc", *flags, *sources, "-o", str(made), "-lm"], check=True)
    library = ctypes.CDLL(str(made))
    wrap, tick = library[f"{p}_wrap"], library[f"{p}_wrap_tick"]
    wrap.restype, wrap.argtypes = ctypes.c_float, [ctypes.c_float]
    tick.restype, tick.argtypes = ctypes.c_uint32, [ctypes.c_uint32]
    return wrap, tick


@pytest.mark.parametrize("text", [WATCHMAN, SECOND], ids=["first order", "second order"])
def test_the_tube_is_c2_where_it_begins_again(text: str) -> None:
    """Value, slope and bend at the seam, from the left at t_c and from both sides where the cycle begins, in whole numbers."""
    design = the_watchman(text).design
    assert isinstance(design, RefinedDesign)
    assert design.seam is not None
    bezier = design.bezier().astype(object)
    last, first, before = bezier[-1], bezier[design.seam], bezier[design.seam - 1]
    for order in range(3):
        ends = [np.diff(piece, n=order, axis=-1) for piece in (last, first, before)]
        assert (ends[0][..., -1] == ends[1][..., 0]).all()
        assert (ends[2][..., -1] == ends[1][..., 0]).all()
    found = extremes(design)  # what is proved of samples is about the cycle's first segment after the last one
    for name in ("narrow", "wide", "step", "width_step", "low", "high"):
        values = getattr(found, name)
        assert (values[-1] == values[design.seam]).all()
    if design.filter:
        every = filtered_extremes(design)
        for values in (every.narrow, every.wide, every.width, every.middle, every.rate, *every.bends, *every.press):
            assert (values[-1] == values[design.seam]).all()
        exact = filtered_extremes(design, FRACTIONS)
        assert len(exact.narrow) == design.segments + 1
        assert exact.narrow[-1, 0] == exact.narrow[design.seam, 0]


def test_ticks_are_turned_back_exactly_for_ever(tmp_path: Path) -> None:
    """Whole cycles of ticks: the tube's time in ticks is that of the count without end, to the tick, after any number of turns."""
    controller = the_watchman()
    cycle, tick = cycle_of(controller.design), controller.task.emit.tick_period  # type: ignore[arg-type]
    assert cycle is not None
    assert tick is not None
    _, wrap_tick = compiled(controller, tmp_path)
    last, length = int(cycle.end / tick), int(cycle.length / tick)
    at = 0
    for count in range(6 * last):
        true = count if count < last else last - length + (count - last) % length
        assert at == true
        at = wrap_tick(at + 1)


def test_a_turn_in_seconds_moves_the_clock_by_no_more_than_the_header_says(tmp_path: Path) -> None:
    controller = the_watchman(WATCHMAN.replace("prescribed_time = 16", "prescribed_time = 15.7").replace("0.02", "0.00245312500"))
    wrap, _ = compiled(controller, tmp_path)
    cycle, p = cycle_of(controller.design), controller.task.name  # type: ignore[arg-type]
    assert cycle is not None
    told = float(controller.files[f"{p}.h"].decode().split("moves the clock by up to ")[1].split()[0])
    t_c = np.float32(float(cycle.end))
    for t in np.random.default_rng(1).uniform(float(t_c), float(t_c + cycle.length), 2000).astype(np.float32):
        assert abs(Fraction(float(wrap(t))) - (Fraction(float(t)) - cycle.length)) <= Fraction(told)
    assert wrap(np.nextafter(t_c, np.float32(0))) == np.nextafter(t_c, np.float32(0))
    assert np.isnan(wrap(float("nan")))


# --------------------------------------------------------------------------------------------------- the whole way


@pytest.mark.parametrize("text", [WATCHMAN, SECOND], ids=["first order", "second order"])
def test_a_watchman_is_certified_checked_and_goes_on_for_ever(text: str, tmp_path: Path) -> None:
    controller = the_watchman(text)
    assert controller.certificate.holds
    assert checked(controller, text, tmp_path) == 0
    order = controller.task.order
    run = Loop(controller, plant_of("integrator", 2, order)).run(
        Scenario(rate=500.0, disturbance="nearest", strength=0.2), trace=True
    )
    assert run.good
    assert run.kept
    cycle = cycle_of(controller.design)  # type: ignore[arg-type]
    assert cycle is not None
    assert run.trace is not None
    assert run.trace[-1, 0] == pytest.approx(float(cycle.end + CYCLES * cycle.length))  # both are sums of a few doubles
    weak = Loop(with_gain(controller, [1e-5] * 2), plant_of("integrator", 2, order)).run(Scenario(rate=500.0))
    assert 1 in weak.missed  # outside its tube it does not carry the patrol out, and that is seen


def claim_of(document: dict[str, Any], state: str) -> dict[str, Any]:
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
def test_the_checker_finds_a_clock_that_is_turned_back_otherwise(
    file: str, old: str, new: str, tmp_path: Path, capsys: Any
) -> None:
    """Also where the certificate has the hash of what was changed."""
    controller = the_watchman()
    text = controller.files[file].decode()
    assert old in text
    files = controller.files | {file: text.replace(old, new).encode()}
    document = json.loads(files["watchman.certificate.json"])
    if file in document["sha256"]:
        document["sha256"][file] = hashlib.sha256(files[file]).hexdigest()
        files["watchman.certificate.json"] = json.dumps(document).encode()
    assert checked(dataclasses.replace(controller, files=files), WATCHMAN, tmp_path) == 1
    assert "NO" in capsys.readouterr().out


@pytest.mark.parametrize("place", [0, 1, 2])
def test_a_kink_where_it_begins_again_is_refused_by_certificate_and_checker(place: int, tmp_path: Path, capsys: Any) -> None:
    """One of the last three control points moved by one unit."""
    controller = the_watchman()
    design = controller.design
    assert isinstance(design, RefinedDesign)
    table = design.integers().copy()
    table[-3 + place, 0, 0] += 1
    bent = dataclasses.replace(design, table=tuple(tuple((int(a), int(b)) for a, b in row) for row in table.tolist()))
    certified = certify(controller.task, bent, controller.program)
    assert [f.code for f in certified.findings if not f.holds] == ["P6"]
    forged = dataclasses.replace(certified, findings=controller.certificate.findings)
    files = render_files(controller.task, bent, build_program(controller.task, bent), forged)
    assert checked(dataclasses.replace(controller, files=files), WATCHMAN, tmp_path) == 1
    assert "P6" in capsys.readouterr().out


@pytest.mark.parametrize("change", [("every = 14", "every = 13.5"), ('"store"]', '"store", "lab"]'), ("patrol =", "formula =")])
def test_another_mission_for_the_same_cycle_is_judged_alike(change: tuple[str, str], tmp_path: Path, capsys: Any) -> None:
    """The cycle is 14 s: nothing that is visited once in it is visited every 13.5 s, though it is in the first 16 s."""
    controller = the_watchman()
    other = WATCHMAN.replace(*change)
    if change[0] == "patrol =":
        other = WATCHMAN.replace('patrol = ["gate", "office", "store"]\nevery = 14', 'formula = "always eventually[0, 13] gate"')
    task = parse_task(other)
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
    assert checked(dataclasses.replace(controller, files=files), other, tmp_path) == 1
    told = capsys.readouterr().out
    assert "P10" in told or "hashes" in told


@pytest.mark.parametrize(
    ("change", "told"),
    [
        (("[[mission]]\npatrol", "[target_set]\nlower = [5, 3]\nupper = [6, 4]\n[[mission]]\npatrol"), "target_set: is where a tube ends"),
        (("upper = [3.6, 2.4]", "upper = [3.6, 2.4]\nduring = [1, 2]"), "unsafe[0].during: with repeat = true"),
        (("repeat = true", "repeat = 1"), "repeat"),
        (("every = 14", "every = 17"), "mission[0].every: is 17"),
        (("0.02", "0.0037"), "emit.tick_period: is 0.0037 s, and with repeat = true no cycle would last whole ticks"),
    ],
)  # fmt: skip
def test_what_does_not_go_with_a_tube_without_end_is_one_message(change: tuple[str, str], told: str) -> None:
    assert change[0] in WATCHMAN
    with pytest.raises((BadInput, NotCertified)) as error:
        built(parse_task(WATCHMAN.replace(*change)))
    assert told in str(error.value)
    assert "\n" not in str(error.value)


def test_repeat_without_a_mission_is_told() -> None:
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
def test_windows_without_end_and_past_the_first_cycle_have_a_tube(entry: str, tmp_path: Path) -> None:
    text = WATCHMAN.replace('patrol = ["gate", "office", "store"]\nevery = 14', entry)
    controller = built(parse_task(text))
    assert checked(controller, text, tmp_path) == 0
    if "eventually always" in entry:
        shown = controller.certificate.mission
        assert shown is not None
        assert any(w.end == float("inf") for w in shown.witnesses[0])


def test_a_round_that_has_no_time_is_refused_and_how_fast_would_do() -> None:
    """Also where what is tried makes rounds by the hundred."""
    with pytest.raises(NotCertified, match=r"tube.max_speed 0.5.*raise tube.max_speed to 0\.\d+"):
        built(parse_task(WATCHMAN.replace("[emit]", "[tube]\nmax_speed = 0.5\n[emit]")))


def test_a_period_that_a_clock_in_seconds_would_lose_is_refused() -> None:
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
    controller = the_watchman(text)
    sketch = package(controller, "arduino")["watchman/examples/watchman_loop/watchman_loop.ino"].decode()
    by_ticks = tick and outside == "return"  # a guard takes seconds
    assert ("ticks = watchman_wrap_tick(ticks)" if by_ticks else "watchman_wrap(elapsed * ") in sketch
    assert ("static uint32_t ticks" in sketch) == by_ticks
    files = package(controller, "cmake")
    library = files["watchman/CMakeLists.txt"].decode()
    for name in (n for n in files if n.endswith(".c")):
        assert name.removeprefix("watchman/") in library
