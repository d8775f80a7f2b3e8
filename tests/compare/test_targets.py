"""Every target language that is registered, against the reference: on a tube with ticks and a logarithm of its own, and on an adaptive
one, whose state goes from step to step."""

from __future__ import annotations

import pytest

from stt_codegen.compare import compare_backend
from stt_codegen.errors import MissingTool
from stt_codegen.program.targets import TARGETS
from stt_codegen.task.load import load_task
from tests.support.absent import absent
from tests.support.controllers import ROOT, built


@pytest.mark.parametrize("target", TARGETS, ids=lambda target: target.key)
@pytest.mark.parametrize(("name", "design"), [("omni_board", "refined"), ("omni_s2", "adaptive")])
def test_every_language_is_within_its_bounds(target, name: str, design: str) -> None:
    try:
        make = target.runner()
    except MissingTool as error:
        absent(str(error))
    task = load_task(ROOT / "tasks" / f"{name}.toml")
    for scalar in target.scalars:
        controller = built(task.with_options(design, scalar, target.key if target.option else None))
        assert set(target.file_names(name)) <= set(controller.files)
        rows = compare_backend(controller, make, 500)
        assert {row.backend for row in rows} <= {target.title, f"{target.title} {scalar}"}
        assert {"tube", "u", "status", "margin"} <= {row.quantity for row in rows}
        assert not [row for row in rows if not row.holds]


def test_what_a_language_has_is_where_its_folder_says() -> None:
    """Each language has a template for each of its files, and for integers where it has these; no two have a key or a suffix."""
    folder = ROOT / "stt_codegen" / "program" / "targets"
    names = [f"{t.key}/{kind}{s}.j2" for t in TARGETS for s in t.suffixes for kind in ("controller", *["fixed"] * t.integers)]
    packaged = [(t, t.package) for t in TARGETS if t.package]
    names += [
        f"{t.key}/{name}" for t, layout in packaged for name in (*layout.templates.values(), (layout.selftest or ("", ""))[1])
    ]
    assert [name for name in names if not (folder / name).exists()] == []
    assert len({t.key for t in TARGETS}) == len(TARGETS)
    assert len({s for t in TARGETS for s in t.suffixes}) == sum(len(t.suffixes) for t in TARGETS)
