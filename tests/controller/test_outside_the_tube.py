"""control.outside: what the guard does once the tube is left, in C and Python, in loops, and before the checker."""

from __future__ import annotations

import ctypes
import hashlib
import json
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from stt_codegen.certify import checker
from stt_codegen.errors import BadInput
from stt_codegen.loop.compiled import FLAGS
from stt_codegen.loop.simulate import Loop, Scenario
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import PLANTS
from stt_codegen.program.targets.c.runner import find_compiler
from stt_codegen.program.targets.python.runner import load_module
from stt_codegen.program.targets.toolchain import run_compiler
from stt_codegen.task.load import load_task
from tests.support.controllers import built

ROOT = Path(__file__).parents[2]
OK, OUTSIDE, BAD = 0, 1, 2


@cache
def made(name: str, outside: str) -> EmittedController:
    task = load_task(ROOT / "tasks" / f"{name}.toml")
    limited = {"u_max": 1} if task.control.u_max is None else {}
    return built(task.changed(control={"outside": outside, **limited}, emit={"scalar": "double"}))


@pytest.fixture(scope="module")
def library(tmp_path_factory: Any) -> Any:
    @cache
    def built(name: str, outside: str) -> Any:
        folder = tmp_path_factory.mktemp(f"{name}_{outside}")
        for file, data in made(name, outside).files.items():
            (folder / file).write_bytes(data)
        sources = [str(folder / f"{name}{end}") for end in (".c", "_guard.c")]
        run_compiler([find_compiler(), *FLAGS, "-Wconversion", "-pedantic", *sources, "-o", str(folder / "own.so"), "-lm"])
        return ctypes.CDLL(str(folder / "own.so"))

    return built


def walk(name: str, seed: int) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Times, states and speeds along the tube: mostly inside, now and then away for a while, once no number."""
    controller = made(name, "stop" if load_task(ROOT / "tasks" / f"{name}.toml").order == 2 else "hold")
    module = load_module(name, controller.files[f"{name}.py"])
    draw, n, found = np.random.default_rng(seed), controller.task.dimension, []
    away = 0
    for k in range(400):
        t = float(controller.task.prescribed_time) * k / 380
        low, high = (np.array(v) for v in module.tube(t))
        away = int(draw.integers(1, 12)) if draw.uniform() < 0.03 else max(away - 1, 0)
        share = draw.uniform(1.5, 4, size=n) if away else draw.uniform(0.4, 0.6, size=n)
        x = low + share * (high - low)
        rates = (np.array(v) for v in module.tube_rate(t))
        v = np.mean(list(rates), axis=0)
        found.append((t, x if k != 200 else x * np.nan, v))
    return found


@pytest.mark.parametrize(("name", "outside"), [("omni_s2", "hold"), ("omni_s2", "stop"), ("drone", "stop")])
def test_c_and_python_guard_alike(name: str, outside: str, library: Any) -> None:
    controller, own = made(name, outside), library(name, outside)
    module = load_module(name, controller.files[f"{name}.py"])
    n, second = controller.task.dimension, controller.task.order == 2
    guard = getattr(own, f"{name}_guard")
    array = ctypes.c_double * n
    memory = (ctypes.c_double * 2)() if outside == "hold" else ctypes.c_int(0)
    kept: Any = (0.0, 0.0) if outside == "hold" else False
    seen = set()
    for t, x, v in walk(name, 3):
        u = array()
        state = [array(*x), *([array(*v)] if second else [])]
        status = guard(ctypes.c_double(t), *state, memory if outside == "hold" else ctypes.byref(memory), u)
        wanted, kept, python = module.guard(t, x, *([v] if second else []), kept)
        assert status == wanted
        assert np.allclose(list(u), python, rtol=1e-12, atol=0)
        assert (list(memory) if outside == "hold" else bool(memory.value)) == (list(kept) if outside == "hold" else kept)
        seen.add(status)
    assert seen == {OK, OUTSIDE, BAD}


def test_a_tube_that_waits_stands_while_the_state_is_outside_and_goes_on_from_there() -> None:
    controller = made("omni_s2", "hold")
    module = load_module("omni_s2", controller.files["omni_s2.py"])
    held, waited = (0.0, 0.0), 0
    for t, x, _ in walk("omni_s2", 4):
        before = held
        status, held, u = module.guard(t, x, held)
        now = t - held[0]
        if status == BAD:
            assert held == before
            assert u == (0.0, 0.0)
            continue
        assert now <= t
        assert now >= before[1] - 1e-12  # its time never goes back
        assert held[1] == pytest.approx(now, abs=1e-12)
        assert (status, u) == module.control(held[1], x) or (status, u) == module.control(t - before[0], x)
        if module.control(t - before[0], x)[0] == OUTSIDE:
            waited += 1
            assert held[1] == before[1]
        else:
            assert held[0] == before[0]
    assert waited > 10


@pytest.mark.parametrize("name", ["omni_s2", "drone"])
def test_what_stopped_stays_stopped_until_it_is_reset(name: str) -> None:
    module = load_module(name, made(name, "stop").files[f"{name}.py"])
    stopped, second = False, made(name, "stop").task.order == 2
    left = False
    for t, x, v in walk(name, 5):
        own = module.control(t, x, *([v] if second else []))
        status, stopped, u = module.guard(t, x, *([v] if second else []), stopped)
        left = left or own[0] == OUTSIDE
        assert stopped == left
        if left:
            assert not any(u)
            assert status == (BAD if own[0] == BAD else OUTSIDE)
        else:
            assert (status, u) == own
        if left and t > 0.7 * module.T_C:
            stopped, left = False, False


def test_loops_that_start_outside_come_back_late_wait_or_stop() -> None:
    """From outside gamma(0): pushed back, the tube is missed at first; a tube that waits is not, and the target is reached late."""
    start = (0.05, 0.95)
    runs = {o: Loop(made("omni_s2", o), PLANTS["integrator"]).run(Scenario(rate=200.0, start=start)) for o in ("hold", "stop")}
    assert runs["hold"].waited > 0
    assert runs["hold"].reached
    assert runs["hold"].hit is None
    assert runs["stop"].last == pytest.approx(start)  # u = 0, and nothing else moves it
    assert runs["stop"].u == (0.0, 0.0)


def test_a_tube_that_waits_is_in_time_where_nothing_goes_wrong() -> None:
    waiting, plain = (Loop(made("omni_s2", o), PLANTS["integrator"]).run(Scenario(rate=200.0)) for o in ("hold", "return"))
    assert waiting.waited == 0
    assert waiting == plain


@pytest.mark.parametrize(
    ("task", "outside", "told"),
    [("drone", "hold", "with inertia"), ("omni_s2", "wait", "hold"), ("omni_s2", "hold", "does not wait")],
)
def test_what_cannot_wait_is_refused(task: str, outside: str, told: str) -> None:
    known = load_task(ROOT / "tasks" / f"{task}.toml")
    moving: dict[str, Any] = {}
    if told == "does not wait":
        first, *others = known.unsafe
        moving = {"unsafe": [{**first.model_dump(exclude_unset=True), "during": [1, 2]}, *others]}
    with pytest.raises(BadInput, match=told):
        known.changed(control={"outside": outside}, **moving)


@pytest.mark.parametrize("outside", ["hold", "stop"])
@pytest.mark.parametrize("design", ["adaptive", "literal"])
def test_only_the_refined_design_has_a_guard(outside: str, design: str) -> None:
    with pytest.raises(BadInput, match=r"control\.outside"):
        load_task(ROOT / "tasks" / "omni_s1.toml").changed(control={"outside": outside}, tube={"design": design})


def test_return_is_the_default_and_adds_nothing() -> None:
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    own, said = built(task).files, built(task.changed(control={"outside": "return"})).files
    assert set(own) == set(said)
    assert not any("guard" in name for name in own)
    assert b"guard" not in own["omni_s2.h"]


@pytest.mark.parametrize(("name", "outside"), [("trolley", "hold"), ("trolley", "stop"), ("drone", "stop")])
def test_the_checker_knows_the_guard(name: str, outside: str, tmp_path: Path, capsys: Any) -> None:
    """Every line of the guard that is changed is found, with the hashes made to fit."""
    text = (ROOT / "tasks" / f"{name}.toml").read_text().replace("[control]\n", f'[control]\noutside = "{outside}"\n')
    (tmp_path / "task.toml").write_text(text)
    files = built(load_task(tmp_path / "task.toml")).files
    for file, data in files.items():
        (tmp_path / file).write_bytes(data)
    arguments = [str(tmp_path / f) for f in ("task.toml", f"{name}.c", f"{name}.certificate.json")]
    assert checker.main(arguments) == 0
    capsys.readouterr()
    plain = (tmp_path / f"{name}_guard.c").read_text()
    code = [k for k, line in enumerate(plain.splitlines()) if re.search(r"[=!]|return", line) and "/*" not in line]
    assert len(code) >= 5
    for k in code:
        lines = plain.splitlines()
        lines[k] = lines[k].replace("return", "return (int)").replace("==", "!=") + " {}"
        (tmp_path / f"{name}_guard.c").write_text("\n".join(lines) + "\n")
        proof = json.loads(files[f"{name}.certificate.json"])
        proof["sha256"][f"{name}_guard.c"] = hashlib.sha256((tmp_path / f"{name}_guard.c").read_bytes()).hexdigest()
        (tmp_path / f"{name}.certificate.json").write_text(json.dumps(proof))
        assert checker.main(arguments) == 1
        assert "guard" in capsys.readouterr().out
