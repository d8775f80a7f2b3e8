"""The listings are the emitted files: filled with the numbers of a task they have the tokens of its C, its header and its small files.

So nobody reads a listing of something else than what is printed, and no line of it stands without a controller that has it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
import pytest

from stt_codegen.checker.stt_checker import source
from stt_codegen.checker.stt_checker.exact import Refused
from tests.support.listings.changes import replaced_text
from tests.support.listings.combinations import options_of, pairwise_combinations
from tests.support.listings.tasks import (
    TASKS_OF_FILES,
    TASKS_OF_INTEGERS,
    ComparedFile,
    build,
    compared_files,
    task_text,
    text_with_options,
)

ROOTS = ("controller", "header", "guard", "wrap", "unwrap", "integer controller", "integer header")
OPTIONS = {  # that a line may ask for
    *("order 1", "order 2", "ticks", "libm", "inline", "one gain", "gains", "one clamp", "clamps", "one filter", "filters"),
    *("limits", "scaled", "no limits", "differences", "float", "double"),
    *("hold", "stop", "period", "phase", "repeats", "selftest", "closed"),
    *("short", "long", "coarse", "fine", "positive", "negative", "plain filter", "scaled filter"),
}
EACH_CLOSED_AXIS = "each closed axis"
TASKS = {
    **{", ".join(filter(None, alternatives)): text_with_options(alternatives) for alternatives in pairwise_combinations()},
    **TASKS_OF_FILES,
    **{f"integers: {label}": text for label, text in TASKS_OF_INTEGERS.items()},
}
PAIRWISE = [*TASKS][: len(pairwise_combinations())]


def tagged_lines() -> Iterator[tuple[str, str, frozenset[str]]]:
    """Yield heading and text of every line that is there for some options only, with these."""
    for heading, lines in source.pieces().items():
        for line in lines:
            if line.endswith("]") and "  [" in line:
                text, _, condition = line.removesuffix("]").rpartition("  [")
                yield heading, text, frozenset(condition.split(", "))


def holes() -> set[str]:
    """Return the names after $, without the number of an axis."""
    return {name for lines in source.pieces().values() for line in lines for name in re.findall(r"\$([a-z]\w*?)(?=U?\b)", line)}


def reachable_headings() -> set[str]:
    """Return the headings that one of the files has for some options."""
    reached, pending = set[str](), [*ROOTS]
    while pending:
        heading = pending.pop()
        if heading not in reached:
            reached.add(heading)
            pending += [name for line in source.pieces()[heading] for name in re.findall(r"^ *<<(.+)>>", line)]
    return reached


@pytest.fixture(scope="module")
def compared() -> dict[str, list[ComparedFile]]:
    """Return what the checker compares of each task, which is all of its C."""
    result = {}
    for label, text in TASKS.items():
        with TemporaryDirectory() as folder:
            result[label] = compared_files(text, Path(folder))
    return result


# ------------------------------------------------------------------------------------------------ the files are the listings


@pytest.mark.parametrize("label", TASKS)
def test_every_file_has_the_tokens_of_its_filled_listing(label: str, compared: dict[str, list[ComparedFile]]) -> None:
    """Tokens are equal but for literals, which may be spelled otherwise where they round to the same number."""
    for file in compared[label]:
        bits, is_single = (24, True) if "float" in file.options else (53, False)
        assert len(file.tokens) == len(file.wanted)
        assert all(source.is_same(a, b, is_single, bits) for a, b in zip(file.tokens, file.wanted, strict=True))
        literals = [(a, b) for a, b in zip(file.tokens, file.wanted, strict=True) if a != b]
        assert all(re.fullmatch(r"\d+\.\d+(e-?\d+)?F?", a) and re.fullmatch(r"\$?[\d./e-]+", b) for a, b in literals)
    names = {file.name for file in compared[label]}
    emitted = {name for name in build(TASKS[label]).files if name.endswith((".c", ".h"))}
    assert emitted - names <= {"cart_selftest.c", "cart_phase.c"}, "of these only the hash is known"
    assert names <= emitted


@pytest.mark.parametrize("label", PAIRWISE)
def test_a_task_of_a_combination_has_its_options(label: str, compared: dict[str, list[ComparedFile]]) -> None:
    """Else a pair of options might be in no file. A task of order 1 has no filters, whatever a listing's options say of them."""
    (alternatives,) = (a for a in pairwise_combinations() if ", ".join(filter(None, a)) == label)
    of_filters = {"one filter", "filters"} if "order 1" in alternatives else set()
    assert (options_of(alternatives) ^ compared[label][0].options) - of_filters <= {"period"}


def test_the_header_declares_the_functions_of_the_c(compared: dict[str, list[ComparedFile]]) -> None:
    """All functions that are not static, in their order, with the same words."""
    for label, files in compared.items():
        texts = {file.listing.removeprefix("integer "): " ".join(file.tokens) for file in files}
        kinds = r"(?:void|bool|int32_t|cart_status|cart_real)"
        heads = re.findall(rf"(?<=[}};\n] )({kinds} cart_\w+ \( [^{{;]* \)) \{{", texts["controller"])
        assert len(heads) >= 5, label
        assert f"}} cart_status ; {' ; '.join(heads)} ;" in texts["header"], label


def test_macros_begin_with_the_name_of_the_task() -> None:
    """So that none of them changes another word of the C."""
    defined = [line for lines in source.pieces().values() for line in lines if "#define" in line or "#undef" in line]
    assert defined
    assert all(re.match(r"#define M_[A-Z]\w*", line) for line in defined)


# ------------------------------------------------------------------------------------------------ nothing in them is idle or misspelled


def test_every_tag_is_a_known_word() -> None:
    assert {word for *_, words in tagged_lines() for word in words} == OPTIONS | {EACH_CLOSED_AXIS}


def test_every_tag_is_explained() -> None:
    """At the top of a listing, between quotation marks, or it is the name of what the header has."""
    text = "".join((Path(source.__file__).parent / file).read_text().partition("\n== ")[0] for file in source.LISTINGS)
    explained = set(re.findall(r'"([a-z0-9 ]+)"', text))
    named_in_header = {"hold", "stop", "period", "phase", "repeats", "selftest", "closed"}
    assert OPTIONS - named_in_header - {"short", "coarse", "plain filter"} <= explained


def test_every_heading_is_reached() -> None:
    assert reachable_headings() == source.pieces().keys()


def test_every_line_is_in_a_controller_and_every_tag_leaves_it_out_of_another(compared: dict[str, list[ComparedFile]]) -> None:
    options = [file.options for files in compared.values() for file in files]
    idle = [(heading, text) for heading, text, words in tagged_lines() if not any(words <= o for o in options)]
    idle += [(heading, text) for heading, text, words in tagged_lines() if all(words <= o for o in options)]
    assert [entry for entry in idle if entry[1].strip() not in ("<<unwrap an axis>>", "<<turn of a closed axis>>")] == []


def test_every_hole_is_filled_and_every_number_is_used(compared: dict[str, list[ComparedFile]]) -> None:
    numbers = {
        re.sub(r"(axis|number|turn)_\d+$", r"\1", name) for files in compared.values() for file in files for name in file.values
    }
    assert numbers >= holes()
    assert numbers - holes() == {"closed", "filter_bits", "filter_minus", "smallest_share_minus"}, "a number that no listing has"


@pytest.mark.parametrize(
    ("heading", "old", "new"),
    [
        ("law", "<<rates>>  [order 2]", "<<rates>>  [ordr 2]"),
        ("law", "<<scale u>>  [scaled]", "<<scale u>>  [scale]"),
        ("integer segment", "[long]", "[lon]"),
    ],
)
def test_a_misspelled_tag_is_noticed(heading: str, old: str, new: str) -> None:
    pieces = "\n".join(source.pieces()[heading])
    with replaced_text(heading, pieces, pieces.replace(old, new, 1)), pytest.raises(AssertionError):
        test_every_tag_is_a_known_word()


def test_a_heading_that_nothing_reaches_is_noticed() -> None:
    with replaced_text("law", "    <<scale u>>  [scaled]\n", ""), pytest.raises(AssertionError):
        test_every_heading_is_reached()


def test_a_hole_without_a_number_is_noticed(tmp_path: Path) -> None:
    with replaced_text("tube", "i < $n", "i < $m"), pytest.raises(KeyError, match="m"):
        compared_files(task_text(), tmp_path)


@pytest.mark.parametrize(
    ("heading", "old", "new"),
    [
        ("controller", "<<covered>>\n", ""),
        ("law", "<<scale u>>  [scaled]", "<<sum of zeros>>"),
        ("law", "[no limits]", "[limits]"),
        ("header", "#define M_N $n", "#define M_N $pairs"),
    ],
)
def test_a_listing_that_is_not_the_file_is_refused(heading: str, old: str, new: str, tmp_path: Path) -> None:
    with replaced_text(heading, old, new), pytest.raises(Refused, match="where the listing has"):
        compared_files(task_text(), tmp_path)


# ------------------------------------------------------------------------------------------------ the numbers


def scalar_number(value: Fraction, scalar: str) -> Fraction:
    """Return the nearest number of the scalar, by numpy."""
    nearest = float(value)
    if scalar == "double":
        return Fraction(nearest)
    single = np.float32(nearest)  # twice rounded; corrected by the neighbours
    candidates = [
        Fraction(float(v)) for v in (single, np.nextafter(single, np.float32(-np.inf)), np.nextafter(single, np.float32(np.inf)))
    ]
    return min(candidates, key=lambda v: (abs(v - value), int(np.float32(float(v)).view(np.uint32)) & 1))


@pytest.mark.parametrize("label", PAIRWISE)
def test_the_numbers_of_a_listing_are_those_of_the_task(label: str, compared: dict[str, list[ComparedFile]]) -> None:
    """By formulas written here once more: the symbolic machine takes the numbers as they are."""
    file, task = compared[label][0], build(TASKS[label]).task
    design = build(TASKS[label]).design
    numbers, scalar = file.values, "float" if "float" in file.options else "double"
    n, k, t_c = 2, design.segments, Fraction(4)
    assert (numbers["n"], numbers["pairs"], [numbers[f"row_{j}"] for j in (1, 2, 3)]) == (n, 2 * n, [2 * n, 4 * n, 6 * n])
    assert numbers["entries"] == len(numbers["coefficients"]) == 2 * n * (k + 3)
    assert numbers["coefficients"] == [Fraction(v, 2**design.bits) for row in design.table for pair in row for v in pair]
    assert (numbers["t_c"], numbers["per_second"]) == (t_c, scalar_number(k / t_c, scalar))
    last = Fraction(float(np.nextafter((np.float32 if scalar == "float" else np.float64)(k), 0)))
    assert numbers["last"] == last
    assert math.floor(last) == k - 1, "no segment beyond the table"
    gains = task.control.gain if isinstance(task.control.gain, tuple) else (task.control.gain,) * n
    clamps = task.control.e_max if isinstance(task.control.e_max, tuple) else (task.control.e_max,) * n
    assert numbers["gain_table"] == [scalar_number(v, scalar) for v in gains]
    assert numbers["smallest_share_table"] == [scalar_number((1 - v) / 2, scalar) for v in clamps]
    assert numbers["e_max_table"] == [scalar_number(v, scalar) for v in clamps]
    for name in ("gain", "e_max", "smallest_share"):
        assert (numbers[name], numbers[f"{name}_minus"]) == (numbers[f"{name}_table"][0], -numbers[f"{name}_table"][0])
    if "u_max_table" in numbers:
        assert numbers["limit"] == -numbers["limit_minus"] == numbers["u_max_table"][0]
        assert all(
            0 <= Fraction(v) - u < Fraction(v) / 2**23 for u, v in zip(numbers["u_max_table"], task.control.u_max, strict=True)
        )
    if "ticks" in file.options:
        num, den = numbers["tick_num"], numbers["tick_den"]
        assert Fraction(num, den) == Fraction(1, 500) * k / t_c
        assert (numbers["ticks"], numbers["tick_end"], numbers["last_segment"]) == (2000, k * den, k - 1)
        assert max(numbers["ticks"] * num, numbers["tick_end"]) < 2**31
        assert numbers["tick_real"] == scalar_number(Fraction(den), scalar)
