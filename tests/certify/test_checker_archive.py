"""The checker as it is shipped: a folder, and one file `checker.pyz` with the same files, the same bytes wherever it is made."""

from __future__ import annotations

import ast
import io
import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from importlib import import_module
from pathlib import Path

import pytest

from stt_codegen.checker import FOLDER, archive
from stt_codegen.checker.stt_checker import source
from stt_codegen.record.package import package
from tests.support.controllers import ROOT, controller_of

MODULES = sorted((FOLDER / "stt_checker").glob("*.py"))
# Lines that may be read; what computes again what the listings mean is read once.
# 2,000 were wanted. Axes that close and covered starts are 240 of the rest, drives that lag, assumed plants and guards 205, bounds on
# files and streams 48, formulas as other tools write them 31, bounds by component and a norm of u 22; messages that name an axis, a
# line or a number, and one statement a line, are most of what remains.
LINE_LIMIT = 2843  # of Python, without MEANING
LINE_LIMIT_OF_A_FILE = 239  # formula.py, which reads formulas as other tools write them
# 1,100 and 400 were wanted, for float or double, order 1, no period, no mission, no set that moves. What a task may state of its
# drive, of a norm of u and by component, the logarithm that the worst path shares, and bounds on files are 137.
LINE_LIMIT_OF_AN_ORDINARY_READER = 1563  # of Python
LINE_LIMIT_OF_AN_ORDINARY_LISTING = 420
MEANING = ("meaning.py", "random_controllers.py", "translation.py")


def run_checker(program: Path, name: str, *flags: str) -> subprocess.CompletedProcess[str]:
    """Check a recorded controller with a copy of the checker, in an empty folder without the variables of this process."""
    folder = program.parent
    shutil.copytree(ROOT / "generated" / name / "refined" / "float", folder, dirs_exist_ok=True)
    shutil.copy(ROOT / "tasks" / f"{name}.toml", folder / "task.toml")
    command = [sys.executable, *flags, str(program), "task.toml", f"{name}.c", f"{name}.certificate.json"]
    environment = {"PATH": os.environ["PATH"], "PYTHONDONTWRITEBYTECODE": "1"}
    return subprocess.run(command, cwd=folder, env=environment, capture_output=True, text=True, check=False)


@pytest.fixture
def shipped(tmp_path: Path) -> dict[str, Path]:
    """Return paths of the checker as a folder and as one file, each in an empty folder."""
    folder, file = tmp_path / "a" / "checker", tmp_path / "b" / archive.ARCHIVE_NAME
    for name, data in archive.members().items():
        (folder / name).parent.mkdir(parents=True, exist_ok=True)
        (folder / name).write_bytes(data)
    file.parent.mkdir()
    file.write_bytes(archive.archive_bytes())
    return {"folder": folder, "file": file}


@pytest.mark.parametrize("kind", ["folder", "file"])
def test_folder_and_file_check_a_controller_with_the_standard_library_alone(kind: str, shipped: dict[str, Path]) -> None:
    """-I: no variables, and no modules of the working folder; -S: no installed packages."""
    result = run_checker(shipped[kind], "omni_s2", "-I", "-S")
    assert result.returncode == 0, result.stdout + result.stderr
    assert result.stdout.startswith("checker: verified: omni_s2")
    source = shipped[kind].parent / "omni_s2.c"
    source.write_text(source.read_text().replace("1.0F - s", "1.0F + s"))
    result = run_checker_again(shipped[kind])
    assert result.returncode == 1
    assert result.stdout.startswith("checker: refused: ")


def run_checker_again(program: Path) -> subprocess.CompletedProcess[str]:
    command = [sys.executable, "-I", "-S", str(program), "task.toml", "omni_s2.c", "omni_s2.certificate.json"]
    return subprocess.run(command, cwd=program.parent, capture_output=True, text=True, check=False)


def test_the_meaning_of_the_listings_is_computed_with_the_standard_library_alone(shipped: dict[str, Path]) -> None:
    command = [sys.executable, "-I", "-S", str(shipped["file"]), "--meaning"]
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    assert "compute the tube and the law" in result.stdout


def test_the_file_has_what_the_folder_has() -> None:
    with zipfile.ZipFile(io.BytesIO(archive.archive_bytes())) as file:
        members = {name: file.read(name) for name in file.namelist()}
    paths = [p for p in FOLDER.rglob("*") if p.is_file() and "__pycache__" not in p.parts]
    package_files = {
        FOLDER / "__init__.py",
        FOLDER / "archive.py",
    }  # of stt_codegen, which imports the checker and makes the archive
    assert members == {p.relative_to(FOLDER).as_posix(): p.read_bytes() for p in paths if p not in package_files}


def test_the_file_has_the_same_bytes_wherever_it_is_made(tmp_path: Path) -> None:
    """In a copy with other times and permissions, in a process with another locale, time zone and umask."""
    shutil.copytree(ROOT / "stt_codegen" / "checker", tmp_path / "stt_codegen" / "checker")
    (tmp_path / "stt_codegen" / "__init__.py").touch()
    for path in tmp_path.rglob("*"):
        os.utime(path, (10**9, 10**9))
        path.chmod(0o700)
    command = 'umask 077; exec "$0" -m stt_codegen.checker.archive checker.pyz'
    environment = {"PATH": os.environ["PATH"], "TZ": "Pacific/Auckland", "LC_ALL": "C", "PYTHONHASHSEED": "7"}
    subprocess.run(["sh", "-c", command, sys.executable], cwd=tmp_path, env=environment, check=True)
    assert (tmp_path / "checker.pyz").read_bytes() == archive.archive_bytes()
    assert b"/home/" not in archive.archive_bytes()


def test_the_archive_s_own_file_makes_it_without_the_package(shipped: dict[str, Path], tmp_path: Path) -> None:
    """docs/checker.md says so to whoever has the folder alone."""
    script = shutil.copy(FOLDER / "archive.py", shipped["folder"])
    subprocess.run([sys.executable, "-I", script, str(tmp_path / "mine.pyz")], cwd=tmp_path, check=True)
    assert (tmp_path / "mine.pyz").read_bytes() == archive.archive_bytes()


def imported_modules(path: Path) -> set[str]:
    """Return the top-level modules that a file imports, its own package apart."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add(str(node.module).partition(".")[0])
    return names


def test_the_checker_imports_the_standard_library_only() -> None:
    imported = set().union(*map(imported_modules, MODULES))
    assert imported <= set(sys.stdlib_module_names)
    assert not imported & {"ctypes", "subprocess", "socket", "urllib", "http"}
    assert imported_modules(FOLDER / "__main__.py") == {"sys", "pathlib", "stt_checker"}


# ------------------------------------------------------------------------------------------------ what is to be read


def lines_of(path: Path) -> int:
    return len(path.read_text().splitlines())


def test_the_checker_is_short() -> None:
    program = [FOLDER / "__main__.py", *MODULES]
    assert sum(lines_of(path) for path in program if path.name not in MEANING) <= LINE_LIMIT
    assert {path.name: lines_of(path) for path in program if lines_of(path) > LINE_LIMIT_OF_A_FILE} == {}


RECORD_CALLS = """
import json, sys
sys.path.insert(0, sys.argv[1])
from stt_checker.main import main
files = set()
sys.setprofile(lambda frame, event, argument: files.add(frame.f_code.co_filename) if event == "call" else None)
code = main(sys.argv[2:])
sys.setprofile(None)
print(json.dumps([code, sorted(files)]))
"""


def test_the_reader_of_an_ordinary_controller_reads_little() -> None:
    """All files of which a function is called for such a task, with the program, and the dataclass of the law's numbers."""
    folder = ROOT / "generated" / "omni_s2" / "refined" / "float"
    paths = [ROOT / "tasks" / "omni_s2.toml", folder / "omni_s2.c", folder / "omni_s2.certificate.json"]
    command = [sys.executable, "-I", "-c", RECORD_CALLS, str(FOLDER), *map(str, paths)]
    output = subprocess.run(command, capture_output=True, text=True, check=True).stdout
    code, called = json.loads(output.splitlines()[-1])
    assert code == 0
    names = {Path(file).name for file in called if Path(file).parent == FOLDER / "stt_checker"}
    assert {"tube.py", "sets.py", "claims.py"} <= names
    assert not names & {"integers.py", "mission.py", "moving.py", "period.py", "inertia.py", *MEANING}
    read = [FOLDER / "__main__.py", *(FOLDER / "stt_checker" / name for name in sorted({*names, "law.py"}))]
    assert sum(map(lines_of, read)) <= LINE_LIMIT_OF_AN_ORDINARY_READER


def lines_of_listing(name: str, options: set[str], headings: set[str]) -> int:
    """Return how many lines of a piece these options have, with the pieces in it that are not in `headings` yet."""
    headings.add(name)
    count = 1
    for line in source.pieces()[name]:
        text, _, condition = line.removesuffix("]").partition("  [") if line.endswith("]") else (line, "", "")
        if not condition or {*condition.split(", ")} <= options:
            inner = re.fullmatch(r" *<<(.+)>>", text)
            count += 1 if not inner or inner[1] in headings else 1 + lines_of_listing(inner[1], options, headings)
    return count


def test_the_listing_of_an_ordinary_controller_is_short() -> None:
    options = {"float", "order 1", "no limits", "libm", "one gain", "one clamp"}
    assert lines_of_listing("controller", options, set()) <= LINE_LIMIT_OF_AN_ORDINARY_LISTING


# ------------------------------------------------------------------------------------------------ who ships it


@pytest.mark.parametrize(
    ("kind", "name", "path"),
    [
        ("cmake", "omni_s2", "omni_s2/extras/checker.pyz"),
        ("arduino", "crane", "crane/extras/checker.pyz"),
        ("rust", "crawler", "crawler/extras/checker.pyz"),
        ("ros2", "trolley", "trolley_ros2/extras/checker.pyz"),
    ],
)
def test_packages_have_the_checker_beside_the_certificate(kind: str, name: str, path: str) -> None:
    files = package(controller_of(name, "fixed" if name == "crane" else "float"), kind)
    assert files[path] == archive.archive_bytes()
    assert path.replace("checker.pyz", f"{name}.certificate.json") in files


def test_units_of_simulators_have_the_checker_too(tool) -> None:
    tool("cc")
    for data in package(controller_of("omni_s2"), "fmu").values():
        with zipfile.ZipFile(io.BytesIO(data)) as unit:
            assert unit.read("resources/checker.pyz") == archive.archive_bytes()


def test_a_package_that_it_cannot_check_has_no_checker() -> None:
    files = package(controller_of("omni_s2", design="adaptive"), "cmake")
    assert not [path for path in files if path.endswith(archive.ARCHIVE_NAME)]


def test_the_page_for_an_assessor_runs_the_file(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """The evidence quotes what the file says: here another program, which refuses."""
    program = io.BytesIO()
    with zipfile.ZipFile(program, "w") as file:
        file.writestr("__main__.py", "print('checker: refused: by a stand-in')\nraise SystemExit(1)\n")
    evidence_page = import_module("stt_codegen.report.page.evidence")
    monkeypatch.setattr(evidence_page.archive, "archive_bytes", program.getvalue)
    check = evidence_page._run_stand_alone_checker(controller_of("omni_s2"), ROOT / "tasks" / "omni_s2.toml")
    assert (check.has_passed, check.message) == (False, "refused: by a stand-in")
