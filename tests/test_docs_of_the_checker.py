"""The pages about the checker say what is so: the listing that they show, commands and their output, lines to read, options, keys."""

from __future__ import annotations

import hashlib
import json
import re
import subprocess
import sys
from pathlib import Path

import pytest

from stt_codegen.checker.stt_checker import check_files, claims, source
from stt_codegen.checker.stt_checker.integers import CONSTANTS, CONSTANTS_OF_ORDER_2
from stt_codegen.checker.stt_checker.keys import KNOWN_KEYS
from stt_codegen.checker.stt_checker.starts import TABLES as TABLES_OF_STARTS
from tests.support.controllers import ROOT

FORMAT_PAGE, CHECKER_PAGE, LISTING_PAGE = (
    (ROOT / "docs" / f"{name}.md").read_text() for name in ("certificate-format", "checker", "listing")
)
FOLDER = ROOT / "stt_codegen" / "checker" / "stt_checker"
ORDINARY = {"float", "order 1", "libm", "one gain", "one clamp", "no limits"}  # options of omni_s2
OMNI_S2 = ROOT / "generated" / "omni_s2" / "refined" / "float"


def with_present_pieces(page: str) -> str:
    """Return the page with each block of C as the listing has it now: the pieces that the block names, in its order."""
    pieces = re.split(r"^(?=== )", (FOLDER / "listing_controller.c").read_text(), flags=re.M)
    by_name = {re.match(r"(== .*)?", piece)[0]: piece for piece in pieces}  # type: ignore[index]

    def block(match: re.Match[str]) -> str:
        names = re.findall(r"^== .*", match[1], re.M) or [""]
        return f"```c\n{''.join(by_name[name] for name in names).strip()}\n```"

    return re.sub(r"^```c\n(.*?)^```", block, page, flags=re.M | re.S)


def test_the_blocks_of_the_page_are_the_listing() -> None:
    """`python -m tests.test_docs_of_the_checker` writes them again."""
    blocks = re.findall(r"^```c\n(.*?)^```", LISTING_PAGE, re.M | re.S)
    assert "\n".join(blocks) == (FOLDER / "listing_controller.c").read_text()
    assert with_present_pieces(LISTING_PAGE) == LISTING_PAGE


def test_the_command_of_the_page_prints_what_it_shows() -> None:
    ((command, shown),) = re.findall(r"^```console\n\$ python3 (.*?)\n(.*?)^```", CHECKER_PAGE, re.M | re.S)
    run = subprocess.run([sys.executable, *command.split()], cwd=ROOT, capture_output=True, text=True, check=True)
    assert run.stdout == shown


def test_the_program_of_the_page_prints_the_lines_of_a_task_and_the_page_quotes_two_of_them() -> None:
    (program,) = re.findall(r"^```python\n(.*?)^```", CHECKER_PAGE, re.M | re.S)
    printed = subprocess.run([sys.executable, "-c", program], cwd=ROOT, capture_output=True, text=True, check=True).stdout
    lines = [line.strip() for line in printed.splitlines()]
    assert lines == [line.strip() for line in source.chosen_lines("controller", ORDINARY)]
    quoted = re.findall(r"^    (const .*?;)  +(const .*?;)$", CHECKER_PAGE, re.M)
    assert len(quoted) == 2
    emitted = [line.strip() for line in (OMNI_S2 / "omni_s2.c").read_text().splitlines()]
    assert all(in_listing in lines and in_file in emitted for in_listing, in_file in quoted)


def test_a_renamed_local_is_refused_with_the_message_of_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The certificate has the hash of the changed file."""
    certificate = json.loads((OMNI_S2 / "omni_s2.certificate.json").read_text())
    for name in ("omni_s2.c", "omni_s2.h"):
        (tmp_path / name).write_text((OMNI_S2 / name).read_text().replace("lower_edge", "bottom"))
        certificate["sha256"][name] = hashlib.sha256((tmp_path / name).read_bytes()).hexdigest()
    (tmp_path / "proof.json").write_text(json.dumps(certificate))
    paths = (ROOT / "tasks" / "omni_s2.toml", tmp_path / "omni_s2.c", tmp_path / "proof.json")
    assert check_files([str(path) for path in paths]) == 1
    assert f"    {capsys.readouterr().out.strip()}\n" in CHECKER_PAGE


def lines_of(name: str) -> int:
    """Return the lines of a file that a reader of an ordinary task reads: of a listing only those of such a task."""
    pieces = {"listing_controller.c": "controller", "listing_files.c": "header"}
    if name in pieces:
        return len(source.chosen_lines(pieces[name], ORDINARY))
    return len((FOLDER / name).read_text().splitlines())


ROW = re.compile(r"^(\|.*checker/stt_checker/.*\| )([\d,]+)(?= \|)", re.M)
TOGETHER = re.compile(r"^(\| together \| )([\d,]+)(?= \|)", re.M)
PYTHON_ROWS = 11  # of an ordinary task; rows of listings follow


def lines_of_row(row: str) -> int:
    return sum(map(lines_of, re.findall(r"checker/stt_checker/([\w.]+)\)", row)))


def with_present_lines(page: str) -> str:
    """Return the page with the lines of each row as they are now, rounded up to tens."""

    def rounded_up(lines: int) -> str:
        return f"{-(-lines // 10) * 10:,}"

    together = sum(lines_of_row(match[1]) for match in [*ROW.finditer(page)][:PYTHON_ROWS])
    page = ROW.sub(lambda match: match[1] + rounded_up(lines_of_row(match[1])), page)
    return TOGETHER.sub(lambda match: match[1] + rounded_up(together), page)


def test_the_page_says_how_many_lines_there_are_to_read() -> None:
    """`python -m tests.test_docs_of_the_checker` writes them again. A few lines more or less in a file do not matter."""
    shown, present = (
        [int(match[2].replace(",", "")) for pattern in (ROW, TOGETHER) for match in pattern.finditer(page)]
        for page in (CHECKER_PAGE, with_present_lines(CHECKER_PAGE))
    )
    assert [(a, b) for a, b in zip(shown, present, strict=True) if abs(a - b) > 10 + b // 20] == []
    files = {path.name for path in FOLDER.iterdir() if path.is_file() and path.name != "__init__.py"}
    assert files == set(re.findall(r"checker/stt_checker/([\w.]+)\)", CHECKER_PAGE))


def test_the_format_has_every_key_of_a_certificate() -> None:
    keys = {*claims.KEYS.split(), "filter", "rate_error", "integers", "clock", "mission", "sampled"}
    table = FORMAT_PAGE.partition("## The keys")[2].partition("## The tube")[0]
    assert {key for row in re.findall(r"^\| (`.*?`) \|", table, re.M) for key in re.findall(r"`(\w+)`", row)} == keys


def test_the_format_has_every_constant_of_integers() -> None:
    table = FORMAT_PAGE.partition("## Integers")[2].partition("These formulas differ")[0]
    assert set(f"{CONSTANTS} {CONSTANTS_OF_ORDER_2}".split()) <= set(re.findall(r"`(\w+)`", table))


def test_the_format_has_every_option_and_number_of_the_listings() -> None:
    text = "\n".join(path.read_text() for path in FOLDER.glob("listing_*.c"))
    options = {word for tail in re.findall(r"  \[([^\]]+)\]$", text, re.M) for word in tail.split(", ")} - {
        "words",
        "each closed axis",
    }
    table = FORMAT_PAGE.partition("## The C is the listing")[2]
    assert {option for option in options if f"`{option}`" not in table} == set()
    numbers = {re.sub(r"_(table|minus)$", "", name) for name in re.findall(r"\$([a-z]\w*?)(?=U?\b)", text)} - {"name", "u_max"}
    starts = {f"{name}_{kind}" for name in TABLES_OF_STARTS for kind in ("type", "bits")}
    keys = f"{CONSTANTS} {CONSTANTS_OF_ORDER_2}".split()
    # in the table as "`row_1` .. `row_3`", "the same of `filters` and of the bounds of starts", "the keys of `integers`"
    named_together = {"row_2", "filters_type", "filters_bits", *starts, *keys}
    assert {name for name in numbers if f"`{name}`" not in table} - named_together == set()


def test_the_format_has_the_defaults_of_all_keys_that_it_lists() -> None:
    """Each key of its first table is a key of a task."""
    table = FORMAT_PAGE.partition("These are the defaults")[2].partition("`axes` gives")[0]
    named = {key for row in re.findall(r"^\| (`.*?`) \|", table, re.M) for key in re.findall(r"`([\w.]+)`", row)}
    keys = {key if not name else f"{name}.{key}" for name, words in KNOWN_KEYS.items() for key in words.split()}
    assert named <= keys | {"timing", "spread", "latency"}


if __name__ == "__main__":
    (ROOT / "docs" / "listing.md").write_text(with_present_pieces(LISTING_PAGE))
    (ROOT / "docs" / "checker.md").write_text(with_present_lines(CHECKER_PAGE))
