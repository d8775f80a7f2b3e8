"""`make integration` (benchmarks/integration.py): a job runs unless it is green and its inputs are unchanged; its list has every job."""

from __future__ import annotations

import ast
import itertools
import json
import os
import re
import signal
import subprocess
import sys
import time
from collections import Counter, defaultdict
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from benchmarks import integration
from benchmarks.__main__ import SUITES
from benchmarks.integration import JOBS, UNLISTED, Job, Ledger, State, main, outcome_of
from tests.support.controllers import ROOT

APPEND_MARK = "from pathlib import Path; p = Path('count.txt'); p.write_text((p.read_text() if p.exists() else '') + '{mark}')"


@pytest.fixture
def root(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the root of a small repository with two inputs."""
    monkeypatch.delenv("CI", raising=False)
    for name in ("inputs/a.txt", "inputs/deep/b.txt", "beside.txt"):
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text("as it was")
    (tmp_path / ".gitignore").write_text("build/\n*.log\n__pycache__/\n")
    return tmp_path


def marking_job(name: str = "a", code: str = "", minutes: float = 0.01, inputs: tuple[str, ...] = ("inputs",)) -> Job:
    """Return a job that appends its name to count.txt, then runs this code."""
    return Job(name, f"The law of {name}.", minutes, None, ("-c", f"{APPEND_MARK.format(mark=name)}; {code}"), inputs)


def marks_of_runs(root: Path) -> str:
    """Return the names of the jobs that ran, in order."""
    path = root / "count.txt"
    return path.read_text() if path.exists() else ""


def states(root: Path, *jobs: Job) -> list[State]:
    """Return the state of each job."""
    return [status.state for status in Ledger(root).statuses(jobs)]


# ------------------------------------------------------------------------------------------ when a result is valid


def test_a_green_job_does_not_run_again_until_a_byte_of_its_inputs_changes(root: Path) -> None:
    job, path = marking_job(), root / "inputs" / "deep" / "b.txt"
    assert states(root, job) == [State.NOT_RUN]
    for _ in range(2):
        assert main([], [job], root) == 0
        assert marks_of_runs(root) == "a"
    stamp = path.stat()
    path.write_text("as it wAs")
    os.utime(path, ns=(stamp.st_atime_ns, stamp.st_mtime_ns))  # size and time are unchanged
    assert states(root, job) == [State.STALE]
    assert main([], [job], root) == 0
    assert marks_of_runs(root) == "aa"
    os.utime(path)
    assert states(root, job) == [State.GREEN]


@pytest.mark.parametrize(
    "change",
    [
        lambda inputs: (inputs / "c.txt").write_text(""),
        lambda inputs: (inputs / "a.txt").unlink(),
        lambda inputs: (inputs / "a.txt").rename(inputs / "z.txt"),
        lambda inputs: inputs.rename(inputs.with_name("elsewhere")),
    ],
    ids=["a new file", "a removed file", "a new name", "a removed folder"],
)
def test_a_changed_name_of_an_input_makes_a_job_stale(change, root: Path) -> None:
    job = marking_job()
    main([], [job], root)
    change(root / "inputs")
    assert states(root, job) == [State.STALE]


def test_a_file_that_is_ignored_or_no_input_leaves_a_job_green(root: Path) -> None:
    job = marking_job()
    main([], [job], root)
    (root / "beside.txt").write_text("changed")
    (root / "inputs" / "run.log").write_text("new")
    (root / "inputs" / "__pycache__").mkdir()
    (root / "inputs" / "__pycache__" / "a.txt").write_text("new")
    assert states(root, job) == [State.GREEN]


def test_another_command_seed_or_version_makes_a_job_stale(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    job = replace(marking_job(), command=("-c", "print({seed})"), seed=1, tools=("sh",))
    main([], [job], root)
    assert states(root, job) == [State.GREEN]
    assert states(root, replace(job, seed=2)) == [State.STALE]
    monkeypatch.setattr(integration, "tool_version", lambda name, root: "sh of next year")
    status = Ledger(root).statuses([job])[0]
    assert (status.state, status.reason) == (State.STALE, "green before sh changed")


def test_a_result_is_stale_whose_inputs_changed_during_the_run(root: Path) -> None:
    job = marking_job(code="Path('inputs/a.txt').write_text('meanwhile')")
    assert main([], [job], root) == 1
    (root / "inputs" / "a.txt").write_text("as it was")  # with the earlier contents it is stale too
    assert states(root, job) == [State.STALE]


def test_an_unreadable_record_counts_as_not_run(root: Path) -> None:
    job = marking_job()
    main([], [job], root)
    path = root / "benchmarks" / "integration_records" / "a.json"
    for text in ("", "{}", path.read_text()[:-20], path.read_text().replace("green", "greenish")):
        path.write_text(text)
        assert states(root, job) == [State.NOT_RUN]


# ------------------------------------------------------------------------------------------ which jobs run


def test_after_a_failure_the_other_jobs_run_and_the_failed_one_runs_first_next_time(root: Path, capsys) -> None:
    jobs = [marking_job("a", minutes=0.1), marking_job("b", "raise SystemExit('a violated law')"), marking_job("c", minutes=0.2)]
    assert main([], jobs, root) == 1
    assert marks_of_runs(root) == "bac"
    output = capsys.readouterr().out
    assert "| a violated law" in output
    assert "failed (exit code 1): b" in output
    assert states(root, *jobs) == [State.GREEN, State.FAILED, State.GREEN]
    assert main([], jobs, root) == 1
    assert marks_of_runs(root) == "bacb"
    capsys.readouterr()
    (root / "inputs" / "a.txt").write_text("changed")
    assert main(["--list"], jobs, root) == 1
    assert "stale (failed before inputs changed): b" in capsys.readouterr().out
    mended = replace(jobs[1], command=marking_job("b").command)
    assert main([], [jobs[0], mended, jobs[2]], root) == 0
    assert marks_of_runs(root)[:5] == "bacbb"


def test_a_green_job_runs_again_with_the_option_again(root: Path) -> None:
    main([], [marking_job()], root)
    assert main(["--again"], [marking_job()], root) == 0
    assert marks_of_runs(root) == "aa"


def test_the_option_list_runs_no_job(root: Path, capsys) -> None:
    assert main(["--list"], [marking_job()], root) == 1
    assert marks_of_runs(root) == ""
    output = capsys.readouterr().out
    assert output.split("\n")[0].split() == ["job", "law", "state", "seconds", "commit"]
    assert "not run: a" in output


def test_no_job_starts_after_the_stated_minutes(root: Path, capsys) -> None:
    jobs = [marking_job("a"), marking_job("b", minutes=0.1)]
    clock = itertools.count(step=30.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(integration.time, "monotonic", lambda: next(clock))
        assert main(["--minutes", "1"], jobs, root) == 1
    assert marks_of_runs(root) == "a"
    assert "not run: b" in capsys.readouterr().out
    assert main(["--minutes", "1"], jobs, root) == 0


def test_jobs_are_chosen_by_name_and_by_their_inputs(root: Path) -> None:
    jobs = [marking_job("one-1"), marking_job("one-2", inputs=("beside.txt",)), marking_job("two")]
    assert main(["--only", "one-*", "--jobs-matching", str(root / "inputs" / "deep" / "b.txt")], jobs, root) == 0
    assert marks_of_runs(root) == "one-1"
    assert main(["--jobs-matching", str(root / "beside.txt")], jobs, root) == 0
    assert marks_of_runs(root) == "one-1one-2"
    with pytest.raises(SystemExit) as exit_:
        main(["--only", "three"], jobs, root)
    assert exit_.value.code == 2


@pytest.mark.parametrize(
    ("path", "reads"),
    [
        ("a/b", True),
        ("a/b/c.py", True),
        ("a", True),
        (".", True),
        ("a/bc", False),
        ("b", False),
        ("f.py", True),
        ("f.pyi", False),
    ],
)
def test_a_job_reads_a_path_in_above_or_below_its_inputs(path: str, reads: bool) -> None:
    assert marking_job(inputs=("a/b", "f.py")).reads(integration.PurePosixPath(path)) == reads


@pytest.mark.parametrize(("kind", "is_caught"), [(signal.SIGKILL, False), (signal.SIGINT, True), (signal.SIGTERM, True)])
def test_a_stopped_run_continues_with_the_job_that_was_stopped(kind: int, is_caught: bool, root: Path) -> None:
    """A new process runs three jobs: the first is green, the second is stopped, the third has not started."""
    hanging = "import time; open('pid.txt', 'w').write(str(__import__('os').getpid())); time.sleep(600)"
    jobs = [marking_job("a"), marking_job("b", hanging, 0.1), marking_job("c", minutes=0.2)]
    program = f"import sys; sys.path.insert(0, {str(ROOT)!r})\nfrom benchmarks.integration import *\n"
    program += f"sys.exit(main([], {jobs!r}, Path({str(root)!r})))"
    run = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
    deadline = time.monotonic() + 300
    while not (root / "pid.txt").exists() or not (root / "pid.txt").read_text():
        assert time.monotonic() < deadline
        time.sleep(0.02)
    job_process = int((root / "pid.txt").read_text())
    run.send_signal(kind)
    output = run.communicate(timeout=300)[0]
    assert run.returncode == (1 if is_caught else -signal.SIGKILL)
    assert ("1 of 3 jobs are green" in output) == is_caught
    if is_caught:
        with pytest.raises(ProcessLookupError):
            os.kill(job_process, 0)
    else:
        os.kill(job_process, signal.SIGKILL)
    assert states(root, *jobs) == [State.GREEN, State.NOT_RUN, State.NOT_RUN]
    assert main([], [jobs[0], replace(jobs[1], command=marking_job("b").command), jobs[2]], root) == 0
    assert marks_of_runs(root) == "abbc"


def test_a_job_that_takes_too_long_is_ended_and_failed(root: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(integration, "SHORTEST_LIMIT", 0.01)
    job = marking_job(code="__import__('time').sleep(60)", minutes=0.001)
    assert main([], [job], root) == 1
    status = Ledger(root).statuses([job])[0]
    assert (status.state, status.reason) == (State.FAILED, "it took too long")


# ------------------------------------------------------------------------------------------ missing tools


@pytest.mark.parametrize(
    "requirement", [{"tools": ("no-such-tool",)}, {"packages": ("no-such-package",)}, {"tools": ("build/x/python",)}]
)
@pytest.mark.parametrize("ci", [False, True])
def test_a_missing_tool_is_reported_and_fails_in_ci(
    requirement, ci: bool, root: Path, monkeypatch: pytest.MonkeyPatch, capsys
) -> None:
    jobs = [replace(marking_job("a"), **requirement), marking_job("b")]
    if ci:
        monkeypatch.setenv("CI", "true")
    assert main([], jobs, root) == int(ci)
    assert marks_of_runs(root) == "b"
    name = next(iter(requirement.values()))[0]
    assert f"{'failed' if ci else 'missing tool'} ({name}: not installed): a" in capsys.readouterr().out


@pytest.mark.parametrize(
    ("code", "output", "state"),
    [
        (0, "12 passed in 2.31s", State.GREEN),
        (0, "12 passed, 3 skipped, 1 deselected in 2.31s", State.MISSING_TOOL),
        (0, "3 skipped in 2.31s\nand more", State.GREEN),
        (0, "", State.GREEN),
        (1, "1 failed, 3 skipped in 2.31s", State.FAILED),
        (5, "no tests ran in 2.31s", State.FAILED),
        (None, "", State.FAILED),
    ],
)
def test_skipped_tests_are_not_green(code: int | None, output: str, state: State) -> None:
    assert outcome_of(code, output) is state


def test_a_job_with_skipped_tests_runs_again(root: Path) -> None:
    job = marking_job(code="print('1 passed, 1 skipped in 0.1s')")
    for count in (1, 2):
        assert main([], [job], root) == 0
        assert marks_of_runs(root) == "a" * count
    assert states(root, job) == [State.MISSING_TOOL]


# ------------------------------------------------------------------------------------------ the list of jobs


def modules_of(name: str) -> Iterator[Path]:
    """Yield the files that the import of a module executes, with the packages around it."""
    parts = name.split(".")
    for k in range(1, len(parts) + 1):
        path = ROOT.joinpath(*parts[:k])
        yield from (p for p in (path / "__init__.py", path.with_suffix(".py")) if p.is_file())


@cache
def imported_files(path: Path) -> tuple[Path, ...]:
    """Return the files that a file imports, anywhere in it.

    The package's interface imports its names from api.py when they are first used."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names.update(a.name for a in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            names.update(f"{node.module}.{a.name}" for a in node.names)
    if any(name.count(".") < 2 and len(list(modules_of(name))) < 2 for name in names if name.split(".")[0] == "stt_codegen"):
        names.add("stt_codegen.api")
    return tuple(p for name in names for p in modules_of(name))


def reachable_files(*starts: Path) -> set[Path]:
    """Return the files that these files import, directly or not."""
    known: set[Path] = set()
    waiting = list(starts)
    while waiting:
        path = waiting.pop()
        if path not in known:
            known.add(path)
            waiting += [] if path == ROOT / "stt_codegen" / "__init__.py" else imported_files(path)
    return known


def first_files(job: Job) -> list[Path]:
    """Return the files that a job's command names."""
    if "pytest" in job.command:
        return [*(ROOT / word for word in job.command if word.endswith(".py")), ROOT / "tests" / "conftest.py"]
    path = ROOT / "benchmarks" / f"{job.command[2]}.py"
    return [path if path.is_file() else ROOT / "benchmarks" / "command_line.py"]


def test_reachable_files_include_imports_inside_functions_and_through_scripts() -> None:
    names = {str(p.relative_to(ROOT)) for p in reachable_files(ROOT / "benchmarks" / "mutations.py")}
    assert {"benchmarks/oracles/shapes.py", "stt_codegen/checker/stt_checker/claims.py", "stt_codegen/design/refine.py"} <= names
    assert "stt_codegen/lemmas/book.py" not in names


@pytest.mark.parametrize("job", JOBS, ids=[job.name for job in JOBS])
def test_every_import_of_a_job_is_one_of_its_inputs(job: Job) -> None:
    outside = {
        p.relative_to(ROOT)
        for p in reachable_files(*first_files(job))
        if not job.reads(integration.PurePosixPath(p.relative_to(ROOT)))
    }
    assert outside == set()


def test_jobs_have_unique_names_a_law_in_one_sentence_at_most_10_minutes_and_existing_inputs() -> None:
    assert max(Counter(job.name for job in JOBS).values()) == 1
    assert max(Counter(job.arguments for job in JOBS).values()) == 1
    for job in JOBS:
        assert re.fullmatch(r"[a-z0-9_-]+", job.name), job.name
        assert re.fullmatch(r"[^.]*(\.(?! )[^.]*)*\.", job.law), job.law  # exactly one sentence
        assert 0 < job.minutes <= 10, job.name
        assert (job.seed is None) == all("{seed}" not in word for word in job.command), job.name
        assert "locks/requirements.lock" in job.inputs, job.name
        missing = [path for path in job.inputs if not (ROOT / path).exists()]
        assert missing == [], job.name


def test_no_tracked_file_is_ignored_by_the_digest() -> None:
    """The digest compares names with the patterns of .gitignore, so it can have only simple ones."""
    patterns = (ROOT / ".gitignore").read_text().split()
    assert all("/" not in p.rstrip("/") and not p.startswith(("!", "#")) for p in patterns)
    tracked = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False).stdout.splitlines()
    assert not [name for name in tracked if Ledger(ROOT)._is_ignored(ROOT / name)]


def scripts_with_exit_code() -> set[str]:
    """Return the names of the scripts of benchmarks/ that have an exit code."""
    exits = re.compile(r"sys\.exit|SystemExit")
    return {p.name for p in (ROOT / "benchmarks").glob("*.py") if exits.search(p.read_text())} - {
        "integration.py",
        "__main__.py",
        "command_line.py",
    }


def test_a_script_with_an_exit_code_is_a_job_or_has_a_reason_not_to_be() -> None:
    listed = {f"{job.command[2]}.py" for job in JOBS if job.command[1] == "benchmarks"} - {f"{name}.py" for name in SUITES}
    assert scripts_with_exit_code() == listed | set(UNLISTED)
    assert not listed & set(UNLISTED)
    assert all(reason.endswith(".") for reason in UNLISTED.values())


def test_every_slow_test_is_in_a_job() -> None:
    slow = {
        p.relative_to(ROOT).as_posix() for p in (ROOT / "tests").rglob("test_*.py") if re.search(r"mark\.slow\b", p.read_text())
    }
    slow.discard("tests/benchmarks/test_integration.py")
    assert slow == {word for job in JOBS for word in job.command if word.startswith("tests/")}


def test_jobs_of_one_test_file_run_every_test_exactly_once() -> None:
    """For every combination of words in a test's name, exactly one of the jobs' expressions holds."""
    by_file = defaultdict(list)
    for job in JOBS:
        if "pytest" in job.command:
            expression = job.command[job.command.index("-k") + 1] if "-k" in job.command else "True"
            by_file[next(word for word in job.command if word.startswith("tests/"))].append(expression)
    assert max(map(len, by_file.values())) > 1
    for file, expressions in by_file.items():
        atoms = sorted({word for text in expressions for word in re.findall(r"\w+", text)} - {"and", "or", "not", "True"})
        for values in itertools.product((False, True), repeat=len(atoms)):
            chosen = [eval(text, {}, dict(zip(atoms, values, strict=True))) for text in expressions]
            assert sum(chosen) == 1, (file, atoms, values)


def test_the_makefile_runs_the_list_of_jobs() -> None:
    text = (ROOT / "Makefile").read_text()
    recipe = re.search(r"^integration:.*\n((?:\t.*\n)+)", text, re.M)
    assert recipe is not None
    lines = [line.strip().lstrip("@") for line in recipe[1].splitlines()]
    assert [line for line in lines if not line.startswith(".ci/tools")] == ["$(BIN)/python -m benchmarks integration $(OPTIONS)"]
    assert ".ci/tools integration" in lines


def test_the_recorded_commit_has_a_plus_where_inputs_differ_from_it(root: Path) -> None:
    def git(*arguments: str) -> None:
        names = ("-c", "user.name=n", "-c", "user.email=e@example.org")
        subprocess.run(["git", *names, *arguments], cwd=root, check=True, capture_output=True)

    def commit(job: Job) -> str:
        main(["--again"], [job], root)
        return str(json.loads((root / "benchmarks" / "integration_records" / f"{job.name}.json").read_text())["commit"])

    job = marking_job()
    assert commit(job) == "-"
    git("init", "-q")
    git("add", "inputs", "beside.txt")
    git("commit", "-q", "-m", "first")
    (root / "beside.txt").write_text("changed")
    assert re.fullmatch("[0-9a-f]+", commit(job))
    (root / "inputs" / "a.txt").write_text("changed")
    assert re.fullmatch(r"[0-9a-f]+\+", commit(job))
