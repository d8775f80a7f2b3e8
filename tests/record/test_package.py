"""The wheel carries all it needs; the project names no registry host."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile

import pytest

from stt_codegen.program.targets import TARGETS
from tests.support.controllers import ROOT, controller_of


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    folder = tmp_path_factory.mktemp("wheel")
    command = [sys.executable, "-m", "build", "--wheel", "--no-isolation", "--outdir", str(folder), str(ROOT)]
    subprocess.run(command, check=True, capture_output=True)
    return next(folder.glob("*.whl"))


def test_an_installed_wheel_generates_the_same_bytes_far_from_the_checkout(wheel, tmp_path) -> None:
    site = tmp_path / "site"
    with zipfile.ZipFile(wheel) as archive:
        archive.extractall(site)
    (tmp_path / "task.toml").write_bytes((ROOT / "tasks" / "omni_s3.toml").read_bytes())
    code = (
        "import sys, stt_codegen; assert stt_codegen.__file__.startswith(sys.path[0]), stt_codegen.__file__\n"
        "from stt_codegen.cli.main import main; sys.argv = ['stt-codegen', 'generate', 'task.toml']; main()"
    )
    env = {**os.environ, "PYTHONPATH": str(site)}
    code = code.replace("sys.path[0]", repr(str(site)))
    result = subprocess.run([sys.executable, "-c", code], cwd=tmp_path, env=env, capture_output=True, text=True, check=False)
    assert result.returncode == 0, result.stderr
    for name, data in controller_of("omni_s3").files.items():
        assert (tmp_path / name).read_bytes() == data


def test_the_wheel_holds_the_templates_and_the_console_script(wheel) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        entry = next(n for n in names if n.endswith("entry_points.txt"))
        assert "stt-codegen = stt_codegen.cli.main:main" in archive.read(entry).decode()
    assert {f"stt_codegen/program/targets/{t.key}/controller{suffix}.j2" for t in TARGETS for suffix in t.suffixes} <= set(names)
    assert {"stt_codegen/proof/_CoqProject", "stt_codegen/proof/Tube.v", "stt_codegen/templates/theorem.v.j2"} <= set(names)
    assert {"stt_codegen/py.typed", "stt_codegen/__init__.pyi"} <= set(names)  # type checkers see the interface
    assert not [n for n in names if n.startswith(("tests/", "generated/", "benchmarks/"))]


def test_a_wheel_built_from_the_source_distribution_holds_the_same_files(wheel, tmp_path) -> None:
    build = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(tmp_path)]
    subprocess.run([*build, "--sdist", str(ROOT)], check=True, capture_output=True)
    with tarfile.open(next(tmp_path.glob("*.tar.gz"))) as archive:
        archive.extractall(tmp_path, filter="data")
    (source,) = [p for p in tmp_path.iterdir() if p.is_dir()]
    subprocess.run([*build, "--wheel", str(source)], check=True, capture_output=True)
    again = next(tmp_path.glob("*.whl"))
    with zipfile.ZipFile(wheel) as one, zipfile.ZipFile(again) as other:
        assert {n: one.read(n) for n in one.namelist()} == {n: other.read(n) for n in other.namelist()}


LOCKS = {
    "requirements": ("test",),
    "peers": ("test", "peers"),
    "peers-rl": ("peers-rl",),
    "physics": ("test", "physics"),
    "ros": ("ros",),
}


def test_every_lock_is_checked() -> None:
    assert {path.stem for path in (ROOT / "locks").iterdir()} == set(LOCKS)


@pytest.mark.parametrize("lock", LOCKS)
def test_the_lock_pins_every_package_with_a_hash_and_names_no_host(lock: str) -> None:
    text = (ROOT / "locks" / f"{lock}.lock").read_text()
    assert not re.search(r"https?://|index-url|find-links", text)
    entries = re.split(r"\n(?=\S)", text.strip())
    assert all("==" in e and "--hash=sha256:" in e for e in entries)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    wanted = [*project["dependencies"], *(w for extra in LOCKS[lock] for w in project["optional-dependencies"][extra])]
    assert len(wanted) >= 4
    for name, relation, version in (split(w) for w in wanted):
        locked = re.findall(rf"^{name}==([\w.]+)", text, re.M)  # one, or one for each range of Python
        assert locked
        assert all(v == version if relation == "==" else parts(v) >= parts(version) for v in locked)


def split(wanted: str) -> tuple[str, str, str]:
    name, relation, version = re.match(r"([\w-]+)(?:\[\w+\])?(==|>=)([\w.]+)", wanted).groups()  # type: ignore[union-attr]
    return name, relation, version


def parts(version: str) -> list[int]:
    return [int(n) for n in re.findall(r"\d+", version)]
