"""The benchmark of arenas: the same results wherever it runs, sums that are right, arenas as described, tables and options."""

from __future__ import annotations

import dataclasses
import json
import subprocess
import sys
from typing import Any

import numpy as np
import pytest
import typer
from typer.testing import CliRunner

from benchmarks.command_line import suites
from benchmarks.ends import JSON_COMMANDS, problems_of
from benchmarks.suites.arenas import USUAL_PARTS, ArenaJob, ArenaPart, ArenaResult, run_arena, run_jobs, summarize
from benchmarks.suites.command import ArenaOptions, parts_of
from benchmarks.suites.families import FAMILIES, arena_task, cubes, is_feasible
from benchmarks.suites.report import number, record, table
from stt_codegen.cli.main import app
from stt_codegen.errors import BadInput
from tests.support.controllers import ROOT

JOBS = [ArenaJob("paper", seed, "refined") for seed in (0, 25, 3)] + [
    ArenaJob("space3", 1, "refined"),
    ArenaJob("paper", 1, "adaptive"),
]


def without_times(results: list[ArenaResult]) -> list[str]:
    """Return results without their times, as text and in order; as text NaNs compare equal."""
    plain = [dataclasses.replace(r, design_seconds=0.0, certificate_seconds=0.0) for r in results]
    return sorted(repr(r) for r in plain)


@pytest.mark.slow
def test_processes_and_a_cluster_of_two_workers_give_the_same_results() -> None:
    distributed = pytest.importorskip("distributed", reason="pip install stt-codegen[cluster]")
    expected = without_times(list(run_jobs(run_arena, JOBS, 1, None)))
    assert without_times(list(run_jobs(run_arena, JOBS, 2, None))) == expected
    with distributed.LocalCluster(n_workers=2, threads_per_worker=1, processes=True, dashboard_address=None) as cluster:
        assert without_times(list(run_jobs(run_arena, JOBS, 1, cluster.scheduler_address))) == expected


@pytest.mark.slow
def test_a_missing_scheduler_is_reported_with_one_message() -> None:
    with pytest.raises(BadInput, match="no Dask scheduler answers there"):
        list(run_jobs(run_arena, JOBS[:1], 1, "127.0.0.1:9"))


def test_a_result_says_why_an_arena_is_not_certified() -> None:
    blocked, good = run_arena(ArenaJob("paper", 25, "refined")), run_arena(ArenaJob("paper", 0, "refined"))
    assert not blocked.certified
    assert not blocked.is_feasible
    assert "min_width" in blocked.reason
    assert good.certified
    assert not good.reason
    # The slowest tube is no faster than the shipped one; 0.95 is nearly the smallest speed that the geometry allows.
    assert 0.95 <= good.slowest <= good.speed * 1.0001
    literal = run_arena(ArenaJob("paper", 0, "literal"))
    assert not literal.certified
    assert {"P4", "P5"} <= set(literal.failing)


def test_a_summary_counts_arenas_by_their_result() -> None:
    results = [run_arena(ArenaJob("paper", seed, "refined")) for seed in (24, 25, 26)]
    counts = summarize(results)
    assert (counts.arenas, counts.feasible, counts.certified, counts.certified_of_feasible) == (3, 2, 2, 2)
    assert counts.missed == ()
    assert counts.design_ms[0] == np.median([1e3 * r.design_seconds for r in results])


def test_the_full_plan_has_every_family_and_arenas_with_less_clearance() -> None:
    assert {p.family for p in USUAL_PARTS} == set(FAMILIES)
    assert ArenaPart("paper", "refined", 500, 0.02, 0.04) in parts_of(ArenaOptions())
    assert parts_of(ArenaOptions(["dense12"], ["refined"], 7)) == [ArenaPart("dense12", "refined", 7)]
    with pytest.raises(BadInput, match="--family moon"):
        parts_of(ArenaOptions(["moon"]))


def test_a_corridor_has_slabs_one_after_the_other_and_always_a_route() -> None:
    family = dataclasses.replace(FAMILIES["corridor"], count=40, length=24.0)
    for seed in range(5):
        boxes = cubes(family, seed)
        assert (boxes[1:, 0, 0] > boxes[:-1, 0, 1]).all()
        assert (boxes[:, 0, 0] >= 2.0).all()
        assert (boxes[:, 0, 1] <= 22.0).all()
        assert is_feasible(family, seed, 0.06)
        task = arena_task(family, seed)
        assert float(task.state_space.upper[0]) == 24.0
        assert float(task.prescribed_time) == pytest.approx(9.0 * 24 / 5)


def test_the_command_prints_a_table_or_one_document_and_records_its_section(tmp_path) -> None:
    results = tmp_path / "RESULTS.md"
    results.write_text("# Mine\n\n<!-- other -->\nkept\n<!-- end of other -->\n")
    runner = CliRunner()
    arguments = ["arenas", "--family", "paper", "--design", "refined", "--count", "3", "--processes", "1"]
    out = runner.invoke(suites, [*arguments, "--record", str(results)])
    assert out.exit_code == 0, out.output
    assert "3 of 3" in out.output
    runner.invoke(suites, [*arguments, "--record", str(results)])
    text = results.read_text()
    assert text.count("<!-- arenas -->") == text.count("<!-- end of arenas -->") == 1
    assert "kept" in text
    document = json.loads(runner.invoke(suites, [*arguments, "--json"]).stdout)
    assert document["arenas"][0]["certified"] == 3


def test_sections_are_replaced_and_columns_aligned(tmp_path) -> None:
    path = tmp_path / "r.md"
    for text in ("one", "two\nlines", "three"):
        record(path, "a", text)
        record(path, "b", "other")
    assert path.read_text().count("three") == 1
    assert "two" not in path.read_text()
    lines = table(["x", "long heading"], [["1", "2"], ["333", "4"]]).splitlines()
    assert len({len(line) for line in lines}) == 1


def test_numbers_have_their_digits_and_no_exponent() -> None:
    assert [number(v) for v in (0.12345, 99.96, 999.4, 999.5, 999.9, -999.9, 1000.0, 12345.6)] == [
        "0.123", "100", "999", "1000", "1000", "-1000", "1000", "12346",
    ]  # fmt: skip
    assert number(9.96, digits=1) == number(9.6, digits=1) == "10"
    assert number(float("inf")) == number(float("nan")) == "-"


@pytest.mark.parametrize("arguments", [("arenas", "--policies", "x"), ("loop", "--policies", "x"), ("missions", "--limit", "1")])
def test_an_option_of_the_peers_is_refused_without_them(arguments: tuple[str, ...]) -> None:
    result = CliRunner().invoke(suites, [*arguments])
    assert isinstance(result.exception, BadInput)
    assert f"{arguments[1]}: is for --peers" in str(result.exception)


def test_benchmarks_are_listed_and_the_option_help_runs_none() -> None:
    def run(*arguments: str) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-m", "benchmarks", *arguments]
        return subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False, timeout=60)

    listing = run()
    assert listing.returncode == 0
    names = {line for line in listing.stdout.splitlines() if not line.startswith(" ")}
    assert {"arenas", "mcu", "mutations", "tubes", "integration"} <= names
    assert not names & {"command_line", "bodies", "__init__"}
    unknown = run("nothing")
    assert (unknown.returncode, unknown.stderr) == (2, "benchmarks: nothing is none of these\n")
    assert set(unknown.stdout.splitlines()) == set(listing.stdout.splitlines())
    for name in ("ends", "lemma_mutants"):  # without a parser of their own
        help_output = run(name, "--help")
        assert (help_output.returncode, f"python -m benchmarks {name}" in help_output.stdout) == (0, True)


def test_both_ends_of_the_dependencies_use_every_command_that_prints_json() -> None:
    commands = typer.main.get_command(app).commands  # type: ignore[attr-defined]
    with_json = {name for name, command in commands.items() if any("--json" in option.opts for option in command.params)}
    assert set(JSON_COMMANDS) == with_json | {"schema"}  # which is JSON by itself


GOOD = {"stdout": "{}", "stderr": "  designing: 2 s ...\nnote: omni_s2: 3 starts\n", "returncode": 0}


@pytest.mark.parametrize(
    ("change", "problem"),
    [
        ({}, ""),
        ({"stderr": "Running HiGHS 1.9.0\n"}, "Running HiGHS"),
        ({"stderr": "/lib/numpy.py:3: DeprecationWarning: old\n  np.old()\n"}, "DeprecationWarning"),
        ({"stderr": "This program contains Ipopt\n"}, "Ipopt"),
        ({"stdout": "{}\n{}"}, "no JSON document"),
        ({"stdout": "hello"}, "no JSON document"),
        ({"returncode": 5}, "exit code 5"),
        ({"returncode": 4, "stderr": "stt-codegen: no emulator\n"}, ""),
    ],
)
def test_both_ends_of_the_dependencies_notice_what_a_library_prints(change: dict[str, Any], problem: str) -> None:
    problems = problems_of(subprocess.CompletedProcess([], **{**GOOD, **change}))
    assert len(problems) == bool(problem), problems
    assert problem in "".join(problems)
