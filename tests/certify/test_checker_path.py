"""The checker's worst path beside the tool's: equal but for rounding, and no bent claim or drive is verified."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from fractions import Fraction
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from stt_codegen.checker.stt_checker import path as checker_path
from stt_codegen.sampling.path.worst_path import PathBounds, follow_worst_path
from stt_codegen.task.load import parse_task
from tests.certify.test_late_inputs import CART, DRIVES, files_of, sampled_of, task_of, with_claim
from tests.sampling.test_worst_path import drawn
from tests.support.checked_files import UNUSABLE, VERIFIED, verdict, verdict_of_proof, with_hashes
from tests.support.controllers import build_once

# Of W+, by which the checker's path ends farther from the edge: it rounds levels, commands and inputs, but no factor of theirs.
ROUNDING_SHARE = Fraction(1, 1 << 36)
Follow = Callable[[Any, Fraction | None, Fraction], tuple[Fraction, Fraction]]


def as_the_checker_has_them(bounds: PathBounds) -> Any:
    """Return the bounds of a path as the checker's `follow` takes them."""
    same = "age narrow wide g_max g_min shift rounding gain e_max filter_rate"
    drive = bounds.drive
    return SimpleNamespace(
        **{name: getattr(bounds, name) for name in same.split()}, u=bounds.input_bound, speed=bounds.closing_speed,
        limit=bounds.u_max, lags=drive.lags, slew=drive.slew, nu=drive.opposite_weight,
    )  # fmt: skip


def differences(follow: Follow, count: int, seed: int) -> Iterator[str]:
    """Yield where the checker's path is nearer to the edge than the tool's, farther by more than rounding, or needs other history."""
    for bounds, start in drawn(count, seed):
        for begin in (start, None):
            wanted = follow_worst_path(bounds, begin)
            nearest, history = follow(as_the_checker_has_them(bounds), begin and begin.nearest, start.first_input)
            if not 0 <= nearest - wanted.nearest <= bounds.wide * ROUNDING_SHARE:
                yield f"{bounds}, {begin}: Q_pk = {float(nearest)} for {float(wanted.nearest)}"
            if wanted.history is not None and history != wanted.history:
                yield f"{bounds}, {begin}: A = {float(history)} for {float(wanted.history)}"


def test_the_checkers_path_is_the_tools_and_farther_from_the_edge_only_by_rounding() -> None:
    assert list(differences(checker_path.follow, 10, seed=9)) == []


MUTANTS = (
    ("/ 96", "/ 60"),
    ("/ 512", "/ 64"),
    ("* 7 // 8", "* 3 // 4"),
    ("math.factorial(j) for j in range(8)", "math.factorial(j) for j in range(3)"),
    ("c, clipped = max(c, 0), clipped - 1", "clipped = clipped - 1"),
    ("started, clipped = True, math.ceil(first / h)", "started, clipped = True, 0"),
    ("math.ceil(b.nu * max(y + largest, 0))", "0"),
    ("max(falls / (1 - h * b.filter_rate)", "max(falls"),
    ("level + shift", "level"),
    ("law(narrow - near, near)", "law(2 * narrow - near, near)"),
    ("max(law(narrow - near, near), weakest)", "law(narrow - near, near)"),
    ("age_cells - b.age / h", "0"),
    ("(b.g_max if y > 0 else b.g_min)", "b.g_max"),
    ("max(c, state[0] - slew_step)", "c"),
    ("len(levels) + age_cells + 1", "len(levels)"),
)


@pytest.mark.parametrize(("old", "new"), MUTANTS)
def test_a_changed_rule_of_the_checkers_path_is_noticed(old: str, new: str) -> None:
    text = Path(checker_path.__file__).read_text()
    assert old in text
    names = vars(checker_path).copy()
    exec(compile(text.replace(old, new), "path.py", "exec"), names)
    assert any(True for seed in (9, 10, 11, 12) for _ in differences(names["follow"], 4, seed))


def bent(key: str, value: object, i: int = 0) -> Callable[[dict[str, Any]], None]:
    """Return a change of one entry of the path's claim."""
    return lambda sampled: sampled["path"][i].update({key: value})


@pytest.mark.parametrize("name", ["cart", "repeated, by recent bounds", "two lags, slew and overshoot"])
@pytest.mark.parametrize(
    ("key", "value"),
    [
        ("history", "0"), ("history", "-1"), ("history", "1/1000000"), ("history", "1000"), ("history", True), ("history", [1]),
        ("nearest", "1"), ("nearest", "1e9"), ("nearest", None), ("nearest", 0.05), ("nearest", "1/0"), ("cell", "1/100"),
    ],
)  # fmt: skip
def test_no_bent_path_is_verified(name: str, key: str, value: object, tmp_path: Path) -> None:
    """A cell's length follows from the bounds, so a certificate that states one is unknown."""
    files = files_of(build_once(task_of(name)), DRIVES[name])
    if (key, value) == ("history", "1000") and sampled_of(files)["path"][0]["history"] is None:
        pytest.skip("with more history than the task lasts the path from the start is all that is followed")
    result = verdict_of_proof(with_claim(files, bent(key, value)), tmp_path)
    assert result.code != VERIFIED
    assert "Traceback" not in result.message


def test_the_last_digits_of_a_path_count(tmp_path: Path) -> None:
    """Q_pk is stated in six digits, rounded down. One unit of the last digit farther from the edge it is not verified."""
    files = files_of(build_once(task_of("cart")), CART)
    nearest = Fraction(sampled_of(files)["path"][0]["nearest"])
    assert verdict_of_proof(with_claim(files, bent("nearest", str(nearest))), tmp_path).code == VERIFIED
    farther = nearest * (1 + Fraction(1, 10**5))
    assert verdict_of_proof(with_claim(files, bent("nearest", str(farther))), tmp_path).code != VERIFIED


@pytest.mark.parametrize(
    "drive", ["slew = 0.0", "slew = -3.0", "lag2 = -0.05", "overshoot = -0.05", "overshoot = 1.0", "lag3 = 0.01"]
)
def test_a_drive_that_the_tool_refuses_is_not_verified_either(drive: str, tmp_path: Path) -> None:
    """The claim is changed with the task, so that only the drive can be refused."""
    text = CART.replace("lag = 0.08", f"lag = 0.08\n{drive}")
    with pytest.raises(Exception, match=drive.split(" ", maxsplit=1)[0]):
        parse_task(text)
    key, value = drive.split(" = ")
    files = {**files_of(build_once(task_of("cart")), CART), "task.toml": text.encode()}
    files = with_claim(files, lambda sampled: sampled["plant"].update({key: value.removesuffix(".0")}))
    try:
        files = with_hashes(files)
    except Exception:  # the checker cannot read the task
        assert verdict(files, tmp_path).code == UNUSABLE
        return
    assert verdict_of_proof(files, tmp_path).code != VERIFIED
