"""Every registered target language is compared with the reference, on a tube with ticks and an inline logarithm and on an adaptive one."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from stt_codegen.compare import compare_backend
from stt_codegen.errors import BadInput, MissingTool
from stt_codegen.program.targets import TARGETS
from stt_codegen.task.added_names import ADDED_NAMES
from stt_codegen.task.load import load_task
from stt_codegen.task.task import Task
from tests.support.controllers import ROOT, build_once
from tests.support.missing_tools import skip_without


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.key)
@pytest.mark.parametrize(("name", "design"), [("omni_board", "refined"), ("omni_s2", "adaptive")])
def test_every_language_is_within_its_bounds(target, name: str, design: str) -> None:
    try:
        make = target.runner()
    except MissingTool as error:
        skip_without(str(error))
    task = load_task(ROOT / "tasks" / f"{name}.toml")
    for scalar in target.scalars:
        controller = build_once(task.with_options(design, scalar, target.key if target.option else None))
        assert set(target.file_names(name)) <= set(controller.files)
        rows = compare_backend(controller, make, 500)
        assert {row.backend for row in rows} <= {target.title, f"{target.title} {scalar}"}
        assert {"tube", "u", "status", "margin"} <= {row.quantity for row in rows}
        assert not [row for row in rows if not row.holds]


CART = {
    "name": "cart",
    "axes": ["x"],
    "prescribed_time": 6,
    "initial_state": [0.5],
    "state_space": {"lower": [0], "upper": [4]},
    "initial_set": {"lower": [0], "upper": [1]},
    "target_set": {"lower": [3], "upper": [4]},
}
DOCKS = [{"name": name, "lower": [lower], "upper": [lower + 1]} for name, lower in (("near", 0.5), ("far", 2.5))]
# For each name that templates add to the Program: changes of `CART` that make the name part of its files.
OWED: dict[str, dict[str, Any]] = {
    "phase": {"region": DOCKS, "mission": [{"visit": "far"}]},
    "wrap": {
        "region": DOCKS,
        "mission": [{"patrol": ["near", "far"], "every": 20}],
        "repeat": True,
        "prescribed_time": 40,
        "target_set": None,
    },
    "unwrap": {"periodic": {"x": 40}},
    "guard": {"control": {"outside": "stop"}},
    "PERIOD_PROVED": {"control": {"period": 0.02, "u_max": 100}, "plant": {"w_max": 0.1}},
}
OWED["wrap_tick"] = {**OWED["wrap"], "emit": {"tick_period": 0.01}}


def owing(name: str) -> Task:
    """Return a task whose files in C and Python must have the name."""
    return Task(**{key: value for key, value in {**CART, **OWED[name]}.items() if value is not None})


def adds(text: str, name: str) -> bool:
    """Return whether the text of a file has the constant, or a function or a structure of the name."""
    end = r"\b" if ADDED_NAMES[name].is_constant else r"(?:\(| \{)"
    return re.search(rf"\b\w+ (?:\w+_)?{name}{end}", text, re.I) is not None


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.key)
@pytest.mark.parametrize("name", ADDED_NAMES)
def test_every_language_adds_the_names_of_a_task_or_refuses_with_a_reason(target, name: str) -> None:
    assert ADDED_NAMES[name].applies_to(owing(name))
    assert target.lacks.keys() <= ADDED_NAMES.keys()
    if name in target.lacks and not ADDED_NAMES[name].is_constant:
        lacking = "|".join(target.lacks)  # files of a task may need several
        with pytest.raises(BadInput, match=f"^emit.{target.key}: .* has no `(?:{lacking})`"):
            owing(name).with_options(language=target.key)
        return
    controller = build_once(owing(name).with_options(language=target.key if target.option else None))
    files = (text.decode() for file, text in controller.files.items() if Path(file).suffix in target.suffixes)
    assert any(adds(text, name) for text in files) == (name not in target.lacks)


def test_a_language_that_lacks_a_function_refuses_the_tasks_that_need_it(monkeypatch: pytest.MonkeyPatch) -> None:
    targets_without_guard = tuple(
        replace(target, lacks={"guard": "a trial"}) if target.key == "rust" else target for target in TARGETS
    )
    monkeypatch.setattr("stt_codegen.program.targets.registry.TARGETS", targets_without_guard)
    task = owing("phase").with_options(language="rust")
    with pytest.raises(BadInput, match=r"^emit\.rust: Rust has no `guard`, which control\.outside needs"):
        task.changed(control={"outside": "stop"})


def test_every_language_has_its_templates_in_its_folder() -> None:
    """Each language has a template for each of its files, and for integers if it has them; keys and suffixes are unique."""
    folder = ROOT / "stt_codegen" / "program" / "targets"
    names = [f"{t.key}/{kind}{s}.j2" for t in TARGETS for s in t.suffixes for kind in ("controller", *["fixed"] * t.integers)]
    packaged = [(t, t.package) for t in TARGETS if t.package]
    names += [
        f"{t.key}/{name}" for t, layout in packaged for name in (*layout.templates.values(), (layout.selftest or ("", ""))[1])
    ]
    assert [name for name in names if not (folder / name).exists()] == []
    assert len({t.key for t in TARGETS}) == len(TARGETS)
    assert len({s for t in TARGETS for s in t.suffixes}) == sum(len(t.suffixes) for t in TARGETS)
