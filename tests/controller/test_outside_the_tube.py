"""`control.outside`: what the guard does once the state is outside the tube, in C, in Python and in loops; the checker knows it.

"hold": the tube waits while the state is outside. "stop": u stays 0 until a reset. "return": no guard; the law pushes back."""

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

from stt_codegen.checker import check_files
from stt_codegen.errors import BadInput
from stt_codegen.loop.compiled import FLAGS
from stt_codegen.loop.simulate import Loop, Scenario
from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import PLANTS
from stt_codegen.program.targets.c.runner import find_compiler
from stt_codegen.program.targets.python.runner import load_module
from stt_codegen.program.targets.toolchain import run_compiler
from stt_codegen.task.load import load_task
from tests.support.controllers import build_once

ROOT = Path(__file__).parents[2]
OK, OUTSIDE, BAD = 0, 1, 2


@cache
def guarded_controller(name: str, outside: str) -> EmittedController:
    """Return the controller of an example task in doubles, with this `control.outside` and a limit on u."""
    task = load_task(ROOT / "tasks" / f"{name}.toml")
    limit = {"u_max": 1} if task.control.u_max is None else {}
    quiet = {"noise": "0.002", "noise_v": "0.01"} if task.plant.noise_v else {}  # with which no state is measured outside
    return build_once(task.changed(control={"outside": outside, **limit}, plant=quiet, emit={"scalar": "double"}))


@pytest.fixture(scope="module")
def library(tmp_path_factory: Any) -> Any:
    """Return a function that compiles a controller with its guard and loads the shared library."""

    @cache
    def load(name: str, outside: str) -> Any:
        folder = tmp_path_factory.mktemp(f"{name}_{outside}")
        for file, data in guarded_controller(name, outside).files.items():
            (folder / file).write_bytes(data)
        sources = [str(folder / f"{name}{end}") for end in (".c", "_guard.c")]
        run_compiler([find_compiler(), *FLAGS, "-Wconversion", "-pedantic", *sources, "-o", str(folder / "guarded.so"), "-lm"])
        return ctypes.CDLL(str(folder / "guarded.so"))

    return load


def walk(name: str, seed: int) -> list[tuple[float, np.ndarray, np.ndarray]]:
    """Return times, states and speeds along the tube: mostly inside, now and then outside for some steps, and once NaN."""
    controller = guarded_controller(name, "stop" if load_task(ROOT / "tasks" / f"{name}.toml").order == 2 else "hold")
    module = load_module(name, controller.files[f"{name}.py"])
    draw, n, steps = np.random.default_rng(seed), controller.task.dimension, []
    steps_outside = 0
    for k in range(400):
        t = float(controller.task.prescribed_time) * k / 380
        low, high = (np.array(v) for v in module.tube(t))
        steps_outside = int(draw.integers(1, 12)) if draw.uniform() < 0.03 else max(steps_outside - 1, 0)
        position = draw.uniform(1.5, 4, size=n) if steps_outside else draw.uniform(0.4, 0.6, size=n)
        x = low + position * (high - low)
        rates = (np.array(v) for v in module.tube_rate(t))
        v = np.mean(list(rates), axis=0)
        steps.append((t, x if k != 200 else x * np.nan, v))
    return steps


@pytest.mark.parametrize(("name", "outside"), [("omni_s2", "hold"), ("omni_s2", "stop"), ("drone", "stop")])
def test_the_guard_does_the_same_in_c_and_python(name: str, outside: str, library: Any) -> None:
    controller, compiled = guarded_controller(name, outside), library(name, outside)
    module = load_module(name, controller.files[f"{name}.py"])
    n, has_speed = controller.task.dimension, controller.task.order == 2
    guard = getattr(compiled, f"{name}_guard")
    array = ctypes.c_double * n
    memory = (ctypes.c_double * 2)() if outside == "hold" else ctypes.c_int(0)
    python_memory: Any = (0.0, 0.0) if outside == "hold" else False
    statuses = set()
    for t, x, v in walk(name, 3):
        u = array()
        state = [array(*x), *([array(*v)] if has_speed else [])]
        status = guard(ctypes.c_double(t), *state, memory if outside == "hold" else ctypes.byref(memory), u)
        python_status, python_memory, python_u = module.guard(t, x, *([v] if has_speed else []), python_memory)
        assert status == python_status
        assert np.allclose(list(u), python_u, rtol=1e-12, atol=0)
        assert (list(memory) if outside == "hold" else bool(memory.value)) == (
            list(python_memory) if outside == "hold" else python_memory
        )
        statuses.add(status)
    assert statuses == {OK, OUTSIDE, BAD}


def test_a_holding_tube_stands_while_the_state_is_outside_and_goes_on_from_there() -> None:
    controller = guarded_controller("omni_s2", "hold")
    module = load_module("omni_s2", controller.files["omni_s2.py"])
    memory, waiting_steps = (0.0, 0.0), 0  # the guard's memory: seconds that the tube has waited, and its last time
    for t, x, _ in walk("omni_s2", 4):
        before = memory
        status, memory, u = module.guard(t, x, memory)
        tube_time = t - memory[0]
        if status == BAD:
            assert memory == before
            assert u == (0.0, 0.0)
            continue
        assert tube_time <= t
        assert tube_time >= before[1] - 1e-12  # the tube's time never decreases
        assert memory[1] == pytest.approx(tube_time, abs=1e-12)
        assert (status, u) == module.control(memory[1], x) or (status, u) == module.control(t - before[0], x)
        if module.control(t - before[0], x)[0] == OUTSIDE:
            waiting_steps += 1
            assert memory[1] == before[1]
        else:
            assert memory[0] == before[0]
    assert waiting_steps > 10


@pytest.mark.parametrize("name", ["omni_s2", "drone"])
def test_a_stopped_controller_stays_stopped_until_it_is_reset(name: str) -> None:
    module = load_module(name, guarded_controller(name, "stop").files[f"{name}.py"])
    stopped, has_speed = False, guarded_controller(name, "stop").task.order == 2
    has_left = False
    for t, x, v in walk(name, 5):
        unguarded = module.control(t, x, *([v] if has_speed else []))
        status, stopped, u = module.guard(t, x, *([v] if has_speed else []), stopped)
        has_left = has_left or unguarded[0] == OUTSIDE
        assert stopped == has_left
        if has_left:
            assert not any(u)
            assert status == (BAD if unguarded[0] == BAD else OUTSIDE)
        else:
            assert (status, u) == unguarded
        if has_left and t > 0.7 * module.T_C:
            stopped, has_left = False, False


def test_a_loop_that_starts_outside_arrives_late_with_hold_and_stands_with_stop() -> None:
    """With hold the tube waits until the state is inside, and the target is reached late; with stop the state never moves."""
    start = (0.05, 0.95)
    runs = {
        outside: Loop(guarded_controller("omni_s2", outside), PLANTS["integrator"]).run(Scenario(rate=200.0, start=start))
        for outside in ("hold", "stop")
    }
    assert runs["hold"].waited > 0
    assert runs["hold"].reached
    assert runs["hold"].hit is None
    assert runs["stop"].last == pytest.approx(start)  # u = 0, and nothing else moves it
    assert runs["stop"].u == (0.0, 0.0)


def test_hold_changes_nothing_while_the_state_stays_inside() -> None:
    waiting, plain = (
        Loop(guarded_controller("omni_s2", outside), PLANTS["integrator"]).run(Scenario(rate=200.0))
        for outside in ("hold", "return")
    )
    assert waiting.waited == 0
    assert waiting == plain


@pytest.mark.parametrize(
    ("task", "outside", "message"),
    [("drone", "hold", "with inertia"), ("omni_s2", "wait", "hold"), ("omni_s2", "hold", "does not wait")],
)
def test_hold_is_refused_with_inertia_or_with_moving_sets(task: str, outside: str, message: str) -> None:
    plain = load_task(ROOT / "tasks" / f"{task}.toml")
    changes: dict[str, Any] = {}
    if message == "does not wait":
        first, *rest = plain.unsafe
        changes = {"unsafe": [{**first.model_dump(exclude_unset=True), "during": [1, 2]}, *rest]}
    with pytest.raises(BadInput, match=message):
        plain.changed(control={"outside": outside}, **changes)


@pytest.mark.parametrize("outside", ["hold", "stop"])
@pytest.mark.parametrize("design", ["adaptive", "literal"])
def test_only_the_refined_design_has_a_guard(outside: str, design: str) -> None:
    with pytest.raises(BadInput, match=r"control\.outside"):
        load_task(ROOT / "tasks" / "omni_s1.toml").changed(control={"outside": outside}, tube={"design": design})


def test_return_is_the_default_and_emits_no_guard() -> None:
    task = load_task(ROOT / "tasks" / "omni_s2.toml")
    default_files, return_files = build_once(task).files, build_once(task.changed(control={"outside": "return"})).files
    assert set(default_files) == set(return_files)
    assert not any("guard" in name for name in default_files)
    assert b"guard" not in default_files["omni_s2.h"]


@pytest.mark.parametrize(("name", "outside"), [("trolley", "hold"), ("trolley", "stop"), ("drone", "stop")])
def test_the_checker_refuses_a_changed_guard(name: str, outside: str, tmp_path: Path, capsys: Any) -> None:
    """A change of any line of its code is refused although the hashes fit."""
    text = (ROOT / "tasks" / f"{name}.toml").read_text().replace("[control]\n", f'[control]\noutside = "{outside}"\n')
    text = re.sub(r"(?m)^noise_v = 0.02", "noise_v = 0.01", text.replace("noise = 0.005 ", "noise = 0.002 "))
    (tmp_path / "task.toml").write_text(text)
    files = build_once(load_task(tmp_path / "task.toml")).files
    for file, data in files.items():
        (tmp_path / file).write_bytes(data)
    arguments = [str(tmp_path / f) for f in ("task.toml", f"{name}.c", f"{name}.certificate.json")]
    assert check_files(arguments) == 0
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
        assert check_files(arguments) == 1
        assert "guard" in capsys.readouterr().out
