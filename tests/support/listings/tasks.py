"""Small tasks whose controllers have all options of the listings, and what the checker compares of their files."""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple
from unittest.mock import patch

from stt_codegen.checker.stt_checker import claims, source
from stt_codegen.checker.stt_checker.task import Task
from stt_codegen.pipeline import EmittedController
from stt_codegen.task.load import parse_task
from tests.support.controllers import build_once
from tests.support.listings.combinations import options_of

TEXT = """
name = "cart"
axes = ["x", "y"]
prescribed_time = 4.0
initial_state = [0.0, 0.0]
{top}
[state_space]
lower = [-1.0, -1.0]
upper = [2.0, 2.0]

[initial_set]
lower = [-0.1, -0.1]
upper = [0.1, 0.1]

{sets}
[tube]
{tube}
[control]
{control}
[emit]
{emit}
[plant]
order = {order}
{plant}
"""
TARGET = "[target_set]\nlower = [0.9, 0.9]\nupper = [1.1, 1.1]\n"
VISIT = f"""{TARGET}
[[region]]
name = "dock"
lower = [0.5, 0.0]
upper = [1.0, 0.5]

[[mission]]
visit = "dock"
between = [1.0, 2.0]
"""
PATROL = """
[[region]]
name = "A"
lower = [0.5, 0.5]
upper = [1.5, 1.5]

[[region]]
name = "B"
lower = [-0.5, -0.5]
upper = [0.3, 0.3]

[[mission]]
patrol = ["A", "B"]
every = 4.0
"""


def task_text(order: int = 1, sets: str = TARGET, **tables: Iterable[str]) -> str:
    """Return a task file. tables: lines by table; `top` has those before the first table."""
    lines = {name: "\n".join(tables.get(name, ())) for name in ("top", "tube", "control", "emit", "plant")}
    return TEXT.format(order=order, sets=sets, **lines)


def text_with_options(alternatives: tuple[str, ...]) -> str:
    """Return a task whose controller in floating point has these options of combinations.py."""
    options = options_of(alternatives)
    order = 2 if "order 2" in options else 1
    emit = [
        f'scalar = "{"float" if "float" in options else "double"}"',
        f'math = "{"inline" if "inline" in options else "libm"}"',
    ]
    emit += ["tick_period = 0.002"] if "ticks" in options else []
    control = ["gain = [0.4, 0.5]" if "gains" in options else "gain = 0.4"]
    control += ["e_max = [0.99, 0.98]" if "clamps" in options else "e_max = 0.99"]
    control += ["u_max = [50.0, 60.0]"] if "limits" in options else []
    control += ["u_max = [5.0, 5.0]", 'saturate = "scale"'] if "scaled" in options else []
    control += ['velocity = "differences"', "period = 0.002"] if "differences" in options else []
    filters = ["filter = [2.0, 2.5]" if "filters" in options else "filter = 2.0"] if order == 2 else []
    return task_text(order, emit=emit, control=control, tube=filters)


SELFTEST = "selftest = true"
TASKS_OF_FILES = {  # the header and small files, of controllers in floating point
    "stop": task_text(control=['outside = "stop"'], emit=[SELFTEST]),
    "stop, order 2": task_text(2, control=['outside = "stop"']),
    "hold": task_text(control=['outside = "hold"']),
    "closed axes": task_text(top=["periodic = { x = 7.0, y = 6.283185307179586 }"]),
    "phase, period": task_text(sets=VISIT, control=["u_max = [3.0, 4.0]", "period = 0.01"], emit=[SELFTEST]),
    "repeats": task_text(sets=PATROL, top=["repeat = true"]),
    "repeats, ticks": task_text(sets=PATROL, top=["repeat = true"], emit=["tick_period = 0.01"]),
}
FIXED = 'scalar = "fixed"'
TICKS, MANY_TICKS = "tick_period = 0.001", "tick_period = 0.00005"
U_MAX, NEGATIVE = "u_max = [3.0, 4.0]", "gain = [-0.5, -0.7]"
U_MAX_2 = "u_max = [30.0, 30.0]"
TASKS_OF_INTEGERS = {
    "selftest": task_text(control=[U_MAX], emit=[FIXED, TICKS, SELFTEST]),
    "negative": task_text(control=[U_MAX, NEGATIVE], emit=[FIXED, TICKS]),
    "long, negative": task_text(control=[U_MAX, NEGATIVE], emit=[FIXED, MANY_TICKS]),
    "long": task_text(control=[U_MAX], emit=[FIXED, MANY_TICKS]),
    "phase, period": task_text(sets=VISIT, control=[U_MAX, "period = 0.01"], emit=[FIXED, "tick_period = 0.01"]),
    "order 2": task_text(2, control=[U_MAX_2], emit=[FIXED, TICKS], tube=["filter = 0.5"]),
    "order 2, long, negative": task_text(2, control=[U_MAX_2, NEGATIVE], emit=[FIXED, MANY_TICKS], tube=["filter = 0.5"]),
    "order 2, scaled filter": task_text(2, control=[U_MAX_2, NEGATIVE], emit=[FIXED, TICKS], tube=["filter = 2.5"]),
    "order 2, long, scaled filter": task_text(2, control=[U_MAX_2], emit=[FIXED, MANY_TICKS], tube=["filter = 2.5"]),
}


class ComparedFile(NamedTuple):
    """A file that the checker compared with a listing: its tokens, those of the filled listing, the options and the numbers."""

    name: str
    listing: str
    tokens: list[str]
    wanted: list[str]
    options: set[str]
    values: dict[str, Any]


def build(text: str) -> EmittedController:
    return build_once(parse_task(text))


def compared_files(text: str, folder: Path, controller: EmittedController | None = None) -> list[ComparedFile]:
    """Check the controller of a task in this folder, and return what was compared. Raises where the checker refuses.

    The controller is built from the text where none is passed."""
    controller = controller or build(text)
    prefix = controller.task.name
    for name, data in controller.files.items():
        (folder / name).write_bytes(data)
    filled: list[tuple[str, set[str], dict[str, Any]]] = []
    compared: list[ComparedFile] = []
    fill, compare = source.fill, source.compare

    def record_fill(listing: str, options: set[str], task_name: str, values: dict[str, Any]) -> list[str]:
        filled.append((listing, set(options), dict(values)))
        return fill(listing, options, task_name, values)

    def record_comparison(file: str, data: bytes, wanted: list[str], *scalar: Any) -> None:
        listing, options, values = filled[-1]
        compared.append(ComparedFile(file, listing, source.tokens(data.decode()), wanted, options, values))
        compare(file, data, wanted, *scalar)

    certificate = json.loads(controller.files[f"{prefix}.certificate.json"])
    with patch.object(source, "fill", record_fill), patch.object(source, "compare", record_comparison):
        claims.check(Task(text.encode()), certificate, controller.files[f"{prefix}.c"], folder)
    return compared
