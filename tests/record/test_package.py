"""The wheel contains all files that it needs, and the lock files pin every package without naming a registry host."""

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


def test_the_wheel_contains_templates_proofs_types_and_the_console_script(wheel) -> None:
    with zipfile.ZipFile(wheel) as archive:
        names = archive.namelist()
        entry = next(n for n in names if n.endswith("entry_points.txt"))
        assert "stt-codegen = stt_codegen.cli.main:main" in archive.read(entry).decode()
    assert {f"stt_codegen/program/targets/{t.key}/controller{suffix}.j2" for t in TARGETS for suffix in t.suffixes} <= set(names)
    assert {"stt_codegen/proof/_CoqProject", "stt_codegen/proof/Tube.v", "stt_codegen/templates/theorem.v.j2"} <= set(names)
    assert {"stt_codegen/py.typed", "stt_codegen/__init__.pyi"} <= set(names)  # type checkers see the interface
    assert not [n for n in names if n.startswith(("tests/", "generated/", "benchmarks/"))]


def test_a_wheel_from_the_source_distribution_contains_the_same_files(wheel, tmp_path) -> None:
    build = [sys.executable, "-m", "build", "--no-isolation", "--outdir", str(tmp_path)]
    subprocess.run([*build, "--sdist", str(ROOT)], check=True, capture_output=True)
    with tarfile.open(next(tmp_path.glob("*.tar.gz"))) as archive:
        archive.extractall(tmp_path, **({"filter": "data"} if hasattr(tarfile, "data_filter") else {}))  # Python 3.11.4 has it
    (source,) = [p for p in tmp_path.iterdir() if p.is_dir()]
    subprocess.run([*build, "--wheel", str(source)], check=True, capture_output=True)
    rebuilt_wheel = next(tmp_path.glob("*.whl"))
    with zipfile.ZipFile(wheel) as archive, zipfile.ZipFile(rebuilt_wheel) as rebuilt:
        assert {n: archive.read(n) for n in archive.namelist()} == {n: rebuilt.read(n) for n in rebuilt.namelist()}


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
    requirements = [*project["dependencies"], *(r for extra in LOCKS[lock] for r in project["optional-dependencies"][extra])]
    assert len(requirements) >= 4
    for name, relation, version in (split_requirement(r) for r in requirements):
        locked = re.findall(rf"^{name}==([\w.]+)", text, re.M)  # a single version, or one for each range of Python
        assert locked
        assert all(v == version if relation == "==" else version_numbers(v) >= version_numbers(version) for v in locked)


def split_requirement(requirement: str) -> tuple[str, str, str]:
    """Return name, relation and version of a requirement such as `numpy>=2.0`."""
    name, relation, version = re.match(r"([\w-]+)(?:\[\w+\])?(==|>=)([\w.]+)", requirement).groups()  # type: ignore[union-attr]
    return name, relation, version


def version_numbers(version: str) -> list[int]:
    return [int(n) for n in re.findall(r"\d+", version)]
