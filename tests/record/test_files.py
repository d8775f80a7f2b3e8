"""Files on disk are reproducible to the byte, recorded in a manifest, compared both ways, and written all together or not at all."""

from __future__ import annotations

import copy
import hashlib
import json
import os
import pickle
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from stt_codegen.cli.options import PACKAGES
from stt_codegen.errors import BadInput
from stt_codegen.files import write_files
from stt_codegen.record.check import check
from stt_codegen.record.manifest import hash_of_inputs, record
from stt_codegen.record.number_changes import describe_numbers
from stt_codegen.record.overwriting import refuse_to_overwrite_certified
from stt_codegen.record.package import KINDS, package
from stt_codegen.task.load import load_task
from tests.support.command_line import run_command, run_in_new_process
from tests.support.controllers import ROOT, build_once, controller_of

# Hash seed, time zone, locale and the vector instructions of NumPy and libm must not change a byte.
ENVIRONMENTS = [
    {"PYTHONHASHSEED": "1", "TZ": "UTC", "LC_ALL": "C"},
    {
        "PYTHONHASHSEED": "4711",
        "TZ": "Pacific/Kiritimati",
        "LC_ALL": "C.UTF-8",
        "NPY_DISABLE_CPU_FEATURES": "AVX2 FMA3 AVX512F AVX512_SKX",
        "OPENBLAS_CORETYPE": "Nehalem",
        "GLIBC_TUNABLES": "glibc.cpu.hwcaps=-AVX2,-FMA,-AVX2_Usable,-FMA_Usable",
    },
]


@pytest.mark.parametrize("design", ["refined", "adaptive", "literal"])
@pytest.mark.parametrize("name", ["omni_s2", "spacecraft"])
def test_generated_bytes_do_not_depend_on_process_folder_or_environment(name: str, design: str, tmp_path) -> None:
    files_by_run = []
    for k, environment in enumerate(ENVIRONMENTS):
        folder = tmp_path / f"folder {k}" / ("deep" * k)
        folder.mkdir(parents=True)
        shutil.copy(ROOT / "tasks" / f"{name}.toml", folder / "copy.toml")
        options = ("--out", "out", "--design", design, "--uncertified")
        result = run_in_new_process("generate", "copy.toml", *options, cwd=folder, env=environment)
        assert result.returncode == 0, result.stderr
        files_by_run.append({p.name: p.read_bytes() for p in (folder / "out").iterdir()})
    assert files_by_run[0] == files_by_run[1]
    if design == "refined":
        assert files_by_run[0] == controller_of(name).files


def test_the_committed_files_are_what_the_tool_writes() -> None:
    assert check(ROOT / "generated").differences == ()


@pytest.fixture
def recorded(tmp_path) -> Path:
    """Return the folder of a user's small repository with one recorded task."""
    (tmp_path / "tasks").mkdir()
    shutil.copy(ROOT / "tasks" / "empty.toml", tmp_path / "tasks")
    result = run_command("generate", "tasks/empty.toml", "--record", "generated", cwd=tmp_path)
    assert result.returncode == 0, result.stderr
    return tmp_path


def test_check_accepts_recorded_files_from_any_folder(recorded) -> None:
    assert run_command("check", cwd=recorded).returncode == 0
    assert run_command("check", str(recorded / "generated"), cwd=Path("/")).returncode == 0
    manifest = json.loads((recorded / "generated" / "MANIFEST.json").read_text())
    assert manifest["folders"]["empty/refined/float"]["task"] == "../tasks/empty.toml"


@pytest.mark.parametrize("name", ["empty.h", "empty.c", "empty.py", "empty.certificate.json"])
@pytest.mark.parametrize("position", [0.0, 0.5, 1.0])
def test_every_changed_byte_is_noticed(recorded, name: str, position: float) -> None:
    file = recorded / "generated" / "empty" / "refined" / "float" / name
    data = bytearray(file.read_bytes())
    k = int(position * (len(data) - 1))
    data[k] ^= 1
    file.write_bytes(bytes(data))
    result = run_command("check", cwd=recorded)
    assert result.returncode == 1
    assert f"empty/refined/float/{name}: differs" in result.stdout
    assert result.stdout.rstrip().endswith("stt-codegen check generated --accept")
    assert run_command("check", "generated", "--accept", cwd=recorded).returncode == 0
    assert run_command("check", cwd=recorded).returncode == 0


def test_missing_extra_and_line_end_changes_are_noticed(recorded) -> None:
    folder = recorded / "generated" / "empty" / "refined" / "float"
    (folder / "empty.h").unlink()
    (folder / "extra.c").write_text("int x;\n")
    (folder / "empty.c").write_bytes((folder / "empty.c").read_bytes().replace(b"\n", b"\r\n"))
    differences = {(d.path.rsplit("/", 1)[1], d.problem) for d in check(recorded / "generated").differences}
    assert ("empty.h", "is missing") in differences
    assert ("extra.c", "is not recorded in the manifest; delete it (--accept leaves it alone)") in differences
    assert ("empty.c", "differs") in differences


def test_a_changed_task_is_noticed_with_the_size_of_the_change(recorded) -> None:
    task = recorded / "tasks" / "empty.toml"
    task.write_text(task.read_text().replace("upper = [1.0, 1.0]", "upper = [1.0, 0.99]"))
    result = run_command("check", "--json", cwd=recorded)
    assert result.returncode == 1
    document = json.loads(result.stdout)
    entry = next(d for d in document["differences"] if d["path"].endswith("empty.c"))
    assert "numbers changed" in entry["numbers"]
    relative_change = float(entry["numbers"].rsplit(" ", 1)[1])
    assert 0.005 < relative_change < 1.0


def test_a_manifest_that_is_damaged_or_absent_is_bad_input(recorded) -> None:
    manifest = recorded / "generated" / "MANIFEST.json"
    manifest.write_text("{}")
    assert run_command("check", cwd=recorded).returncode == 2
    manifest.unlink()
    result = run_command("check", cwd=recorded)
    assert result.returncode == 2
    assert "--record" in result.stderr


def test_describe_numbers_distinguishes_text_from_numbers() -> None:
    old = "static const float x[2] = {1.5F, -2.0F};\n/* 3 points */\n"
    assert describe_numbers(old, old.replace("/* 3 points */", "/* 3 knots */")) == "the text changed, no number did"
    assert describe_numbers(old, old.replace("-2.0F", "-2.5F")).startswith(
        "1 of 4 numbers changed, the largest relative change is 0.2"
    )
    assert "structure changed" in describe_numbers(old, old.replace(", -2.0F", ""))


@pytest.mark.parametrize(
    ("before", "after"), [("0x7fffffU", "0x6fffffU"), ("4U", "5U"), ("1e-3F", "2e-3F"), ("1.F", "2.F"), ("7L", "8L")]
)
def test_a_number_of_c_that_changes_is_a_number(before: str, after: str) -> None:
    assert describe_numbers(f"x = {before};", f"x = {after};").startswith("1 of 1 numbers changed")


def test_an_edge_moves_by_at_most_6_times_the_change_of_a_coefficient() -> None:
    import numpy as np

    from stt_codegen import reference

    design = controller_of("omni_s2").design
    t = np.linspace(0, 9, 2000)
    before = np.stack(reference.tube(design.integers(), design.unit, design.prescribed_time, t))
    changed_design = design.integers()
    changed_design[7, 0, 1] += 1000
    changed_design[12, 1, 0] -= 700
    after = np.stack(reference.tube(changed_design, design.unit, design.prescribed_time, t))
    assert np.abs(after - before).max() <= 6 * 1000 * float(design.unit)


def test_a_failed_write_leaves_the_old_files_unchanged(tmp_path, monkeypatch) -> None:
    write_files(tmp_path, {"a.c": b"old a", "b.c": b"old b"})

    def fail(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, "fsync", fail)
    with pytest.raises(BadInput, match="No space left"):
        write_files(tmp_path, {"a.c": b"new a", "b.c": b"new b"})
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == {"a.c": b"old a", "b.c": b"old b"}


def altered(controller, name: str):
    """Return the controller with one more space at the end of a file."""
    return replace(controller, files={**controller.files, name: controller.files[name] + b" "})


def test_files_of_a_controller_cannot_be_changed_and_can_be_copied_and_pickled() -> None:
    controller = controller_of("omni_s2")
    contents = {name: bytes(data) for name, data in controller.files.items()}
    changes = {
        "assigned": lambda files: files.__setitem__("omni_s2.c", b""),
        "deleted": lambda files: files.__delitem__("omni_s2.c"),
        "updated": lambda files: files.update({"omni_s2.c": b""}),
        "popped": lambda files: files.pop("omni_s2.c"),
        "cleared": lambda files: files.clear(),
    }
    for change in changes.values():
        with pytest.raises((TypeError, AttributeError)):
            change(controller.files)
    contents_before = dict(contents)
    copied = replace(controller, files=contents_before)
    contents_before["omni_s2.c"] = b""
    for files in (
        controller.files,
        copied.files,
        copy.copy(copied.files),
        copy.deepcopy(copied.files),
        pickle.loads(pickle.dumps(copied)).files,
    ):
        assert files == contents
        assert type(files) is type(controller.files)


@pytest.mark.parametrize("name", ["omni_s2.c", "omni_s2.h", "omni_s2.py"])
def test_an_altered_file_is_not_written_beside_its_certificate(name: str, tmp_path) -> None:
    """By no way: neither as files, nor recorded, nor in a package of any kind."""
    controller = altered(controller_of("omni_s2"), name)
    message = f"{name}: is not what omni_s2.certificate.json is about"
    with pytest.raises(BadInput, match=message):
        write_files(tmp_path / "plain", controller.files)
    with pytest.raises(BadInput, match=message):
        record(tmp_path / "recorded", ROOT / "tasks" / "omni_s2.toml", controller, False)
    for kind in KINDS:
        with pytest.raises(BadInput, match=message):
            package(controller, kind)
    assert not list(tmp_path.rglob("*.*"))
    files = package(controller_of("omni_s2"), "cmake")
    with pytest.raises(BadInput, match="is not what omni_s2/extras/omni_s2.certificate.json is about"):
        write_files(tmp_path, files | {"omni_s2/src/omni_s2.c": b"int quick;"})
    without = {path: data for path, data in controller.files.items() if not path.endswith(".json")}
    write_files(tmp_path, without)  # nothing vouches for it


@pytest.mark.parametrize("kind", KINDS)
def test_a_file_is_not_written_beside_a_certificate_that_is_about_another_one(kind: str, tmp_path) -> None:
    files = package(build_once(load_task(ROOT / "tasks" / "omni_s3.toml").changed(emit={"rust": True})), kind)
    write_files(tmp_path, files)
    for path in files:
        write_files(tmp_path, {path: files[path]})  # the same bytes
    certificates = [path for path in files if path.endswith(".certificate.json")]
    named = json.loads(files[certificates[0]])["sha256"] if certificates else {}
    altered_paths = [path for path in files if Path(path).name in named]
    assert bool(altered_paths) == (kind != "fmu")  # a unit of FMI has its certificate inside
    for path in altered_paths:
        with pytest.raises(BadInput, match="is about another one; write it with its certificate"):
            write_files(tmp_path, {path: b"int quick;"})
    assert {path: (tmp_path / path).read_bytes() for path in files} == files
    (tmp_path / "damaged.certificate.json").write_bytes(b"{")
    write_files(tmp_path, {"damaged.c": b""})


def test_nothing_is_written_when_one_of_several_tasks_is_refused(tmp_path) -> None:
    (tmp_path / "bad.toml").write_text("name = 1\n")
    result = run_command("generate", str(ROOT / "tasks" / "empty.toml"), "bad.toml", "--out", "out", cwd=tmp_path)
    assert result.returncode == 2
    assert not (tmp_path / "out").exists()


def test_a_renamed_task_is_noticed_and_accept_moves_its_folder(recorded) -> None:
    task = recorded / "tasks" / "empty.toml"
    task.write_text(task.read_text().replace('name = "empty"', 'name = "wagon"'))
    result = run_command("check", cwd=recorded)
    assert result.returncode == 1
    assert "now called 'wagon'" in result.stdout
    assert run_command("check", "--accept", cwd=recorded).returncode == 0
    assert run_command("check", cwd=recorded).returncode == 0
    assert not (recorded / "generated" / "empty").exists()


def test_a_task_that_is_gone_is_noticed_and_accept_drops_its_folder(recorded) -> None:
    (recorded / "tasks" / "empty.toml").unlink()
    result = run_command("check", cwd=recorded)
    assert result.returncode == 1
    assert "task file ../tasks/empty.toml is gone" in result.stdout
    accepted = run_command("check", "--accept", cwd=recorded)
    assert accepted.returncode == 0
    assert "1 dropped" in accepted.stdout
    assert run_command("check", cwd=recorded).returncode == 0


@pytest.mark.parametrize(
    ("change", "code", "message"),
    [
        (("[initial_set]", "[initial_set]\nu_nrom = 3"), 2, "u_nrom: unknown key"),
        (("max_speed = 9", "max_speed = 0.1"), 3, "tube.max_speed = 0.1"),
    ],
    ids=["typo", "uncertifiable"],
)
def test_what_can_be_accepted_is_beside_a_task_that_is_refused(
    recorded, change: tuple[str, str], code: int, message: str
) -> None:
    text = (recorded / "tasks" / "empty.toml").read_text().replace('name = "empty"', 'name = "second"')
    second = recorded / "tasks" / "second.toml"
    second.write_text(text + "\n[tube]\nmax_speed = 9\n")
    assert run_command("generate", "tasks/second.toml", "--record", "generated", cwd=recorded).returncode == 0
    header = recorded / "generated" / "empty" / "refined" / "float" / "empty.h"
    content = header.read_bytes()
    header.unlink()
    assert change[0] in second.read_text()
    second.write_text(second.read_text().replace(*change))
    assert run_command("check", cwd=recorded).returncode == 1
    accepted = run_command("check", "--accept", cwd=recorded)
    assert accepted.returncode == code
    assert message in accepted.stderr
    assert "1 folder written" in accepted.stdout
    assert "1 not written (refused)" in accepted.stdout
    assert header.read_bytes() == content
    document = json.loads(run_command("check", "--accept", "--json", cwd=recorded).stdout)
    assert (document["written"], [refusal["exit_code"] for refusal in document["refused"]]) == (1, [code])


def test_another_task_file_cannot_take_over_a_recorded_name(recorded) -> None:
    text = (recorded / "tasks" / "empty.toml").read_text()
    (recorded / "tasks" / "other.toml").write_text(text.replace('name = "empty"', 'name = "Empty"'))
    result = run_command("generate", "tasks/other.toml", "--record", "generated", cwd=recorded)
    assert result.returncode == 2
    assert "is recorded for ../tasks/empty.toml already" in result.stderr


def test_a_refusal_of_one_of_several_tasks_names_its_file(tmp_path) -> None:
    wall = '\n[[unsafe]]\nname = "wall"\nlower = [2.0, 0.0]\nupper = [2.5, 3.0]\n'
    (tmp_path / "walled.toml").write_text((ROOT / "tasks" / "empty.toml").read_text() + wall)
    result = run_command("generate", str(ROOT / "tasks" / "omni_s3.toml"), "walled.toml", "--out", "out", cwd=tmp_path)
    assert result.returncode == 3
    assert "walled.toml: avoid (P4)" in result.stderr


def test_a_replacement_that_fails_half_way_puts_the_old_files_back(tmp_path, monkeypatch) -> None:
    write_files(tmp_path, {"a.c": b"old a", "b.c": b"old b"})
    replace = os.replace
    calls = []

    def fail_second_time(source, target) -> None:
        calls.append(target)
        if len(calls) == 2:
            raise OSError(5, "Input/output error")
        replace(source, target)

    monkeypatch.setattr(os, "replace", fail_second_time)
    with pytest.raises(BadInput, match="Input/output"):
        write_files(tmp_path, {"a.c": b"new a", "b.c": b"new b"})
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == {"a.c": b"old a", "b.c": b"old b"}


def test_a_change_of_the_prescribed_time_is_not_described_as_a_movement_of_edges(recorded) -> None:
    task = recorded / "tasks" / "empty.toml"
    task.write_text(task.read_text().replace("prescribed_time = 4.0", "prescribed_time = 5.0"))
    result = run_command("check", "--json", cwd=recorded)
    entry = next(d for d in json.loads(result.stdout)["differences"] if d["path"].endswith("empty.c"))
    assert "numbers changed" in entry["numbers"]
    assert "edges move" not in entry["numbers"]


def test_an_uncertified_controller_does_not_replace_a_certified_one(tmp_path) -> None:
    task = str(ROOT / "tasks" / "omni_s3.toml")
    assert run_command("generate", task, "--out", "out", cwd=tmp_path).returncode == 0
    before = {p.name: p.read_bytes() for p in (tmp_path / "out").iterdir()}
    result = run_command("generate", task, "--out", "out", "--design", "literal", "--uncertified", cwd=tmp_path)
    assert result.returncode == 2
    assert "holds a certified 'omni_s3'" in result.stderr
    assert {p.name: p.read_bytes() for p in (tmp_path / "out").iterdir()} == before


def test_an_uncertified_package_does_not_replace_a_certified_one(tmp_path) -> None:
    """The certificate of a package is in another folder than its C."""
    task = str(ROOT / "tasks" / "omni_s3.toml")
    options = ["--package", "cmake", "--out", "out"]
    assert run_command("generate", task, *options, cwd=tmp_path).returncode == 0
    before = {p: p.read_bytes() for p in (tmp_path / "out").rglob("*") if p.is_file()}
    result = run_command("generate", task, *options, "--design", "literal", "--uncertified", cwd=tmp_path)
    assert result.returncode == 2, result.stderr
    assert "holds a certified 'omni_s3' (omni_s3/extras/omni_s3.certificate.json)" in result.stderr
    assert {p: p.read_bytes() for p in (tmp_path / "out").rglob("*") if p.is_file()} == before


def test_certified_files_of_every_kind_of_package_are_protected(tmp_path) -> None:
    assert tuple(KINDS) == PACKAGES
    controller = build_once(load_task(ROOT / "tasks" / "omni_s3.toml").changed(emit={"rust": True}))
    for kind in KINDS:
        files = package(controller, kind)
        refuse_to_overwrite_certified(tmp_path / kind, files)  # the folder is empty
        write_files(tmp_path / kind, files)
        refuse_to_overwrite_certified(tmp_path / kind, files)  # the same files may be written again
        (certificate,) = [data for path, data in files.items() if path.endswith(".certificate.json")] or [b'{"sha256": {}}']
        protected = [
            p for p in files if Path(p).name in json.loads(certificate)["sha256"] or p.endswith((".certificate.json", ".fmu"))
        ]
        assert protected
        for path in protected:  # a single file, without its certificate
            with pytest.raises(BadInput, match="holds a certified 'omni_s3'"):
                refuse_to_overwrite_certified(tmp_path / kind, {path: b"other"})


def test_another_task_or_kind_of_package_does_not_replace_certified_files(tmp_path) -> None:
    """Part of them is not replaced either, so that files of an older design never stay beside a new certificate."""
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()

    def task(name: str, old: str = "", new: str = "") -> str:
        (tmp_path / "now.toml").write_text(text.replace('name = "omni_s2"', f'name = "{name}"', 1).replace(old, new, 1))
        return str(tmp_path / "now.toml")

    def expect_refusal(*arguments: str, message: str) -> None:
        before = {p: p.read_bytes() for p in (tmp_path / "out").rglob("*") if p.is_file()}
        result = run_command("generate", *arguments, cwd=tmp_path)
        assert result.returncode == 2, result.stdout
        assert message in result.stderr
        assert {p: p.read_bytes() for p in (tmp_path / "out").rglob("*") if p.is_file()} == before

    def expect_written(*arguments: str) -> None:
        result = run_command("generate", *arguments, cwd=tmp_path)
        assert result.returncode == 0, result.stderr

    expect_written(task("omni_s2"), "--package", "cmake", "--out", "out")
    expect_refusal(
        task("omni_s2"), "--out", "out/omni_s2/src", message="holds a certified 'omni_s2' (../extras/omni_s2.certificate.json)"
    )
    expect_written(task("omni_s2"), "--package", "rust", "--out", "out")  # the same design may be written
    expect_refusal(
        task("omni_s2", "clearance = 0.03", "clearance = 0.04"), "--package", "rust", "--out", "out", message="of another design"
    )
    expect_written(task("omni_s2_plant"), "--package", "fmu", "--out", "out")
    expect_refusal(
        task("omni_s2"), "--package", "fmu", "--plant", "integrator", "--out", "out", message="holds a certified 'omni_s2_plant'"
    )
    expect_written(task("omni_s2_selftest"), "--out", "out")
    expect_refusal(
        task("omni_s2", "[control]", "[emit]\nselftest = true\n[control]"),
        "--out",
        "out",
        message="holds a certified 'omni_s2_selftest'",
    )
    expect_written(task("omni_s2"), "--record", "out/recorded")
    late = task("omni_s2", "[control]", "[control]\nperiod = 5.0")  # a period that is not proved
    expect_refusal(late, "--record", "out/recorded", "--uncertified", message="holds a certified 'omni_s2'")


def test_two_tasks_that_would_write_the_same_file_are_refused(tmp_path) -> None:
    """The plant's unit of the first task has the name of the second task's unit."""
    text = (ROOT / "tasks" / "omni_s2.toml").read_text()
    (tmp_path / "a.toml").write_text(text)
    (tmp_path / "b.toml").write_text(text.replace('name = "omni_s2"', 'name = "omni_s2_plant"', 1))
    result = run_command(
        "generate", "a.toml", "b.toml", "--package", "fmu", "--plant", "integrator", "--out", "out", cwd=tmp_path
    )
    assert result.returncode == 2
    assert "'omni_s2' and 'omni_s2_plant' would both write omni_s2_plant.fmu" in result.stderr
    assert not (tmp_path / "out").exists()


WRITE_AND_EXIT = """
import os, sys
from pathlib import Path
from stt_codegen.pipeline import build
from stt_codegen.files import write_files

files, replace, remaining = build(Path(sys.argv[1])).files, os.replace, [int(sys.argv[3])]

def replace_or_exit(source, target):
    if not remaining[0]:
        os._exit(9)
    remaining[0] -= 1
    replace(source, target)

os.replace = replace_or_exit
write_files(Path(sys.argv[2]), files)
"""


@pytest.mark.parametrize("renamed", [0, 1, 2, 3, 4])
def test_a_run_killed_between_renames_leaves_a_complete_set_or_no_certificate(renamed: int, tmp_path) -> None:
    from stt_codegen.checker import check_files

    old, new = tmp_path / "old.toml", tmp_path / "second.toml"
    text = (ROOT / "tasks" / "empty.toml").read_text()
    old.write_text(text)
    new.write_text(text.replace("prescribed_time = 4.0", "prescribed_time = 5.0"))
    out = tmp_path / "out"
    write_files(out, build_once(load_task(old)).files)
    run = subprocess.run([sys.executable, "-c", WRITE_AND_EXIT, str(new), str(out), str(renamed)], check=False)
    assert run.returncode == (9 if renamed < 4 else 0)
    is_verified = [
        check_files([str(task), str(out / "empty.c"), str(out / "empty.certificate.json")]) == 0 for task in (old, new)
    ]
    assert is_verified == [False, renamed == 4]
    assert (out / "empty.certificate.json").exists() == (renamed == 4)
    assert bool(list(out.glob(".*"))) == (renamed < 4)
    write_files(out, build_once(load_task(new)).files)
    assert not list(out.glob(".*"))  # the next write removes temporary files
    assert check_files([str(new), str(out / "empty.c"), str(out / "empty.certificate.json")]) == 0


def test_a_recorded_file_that_the_tool_does_not_write_is_reported(recorded) -> None:
    manifest = recorded / "generated" / "MANIFEST.json"
    document = json.loads(manifest.read_text())
    folder = next(name for name in document["folders"] if name.startswith("empty/"))
    document["folders"][folder]["sha256"]["empty_fast.c"] = "00"
    manifest.write_text(json.dumps(document))
    (recorded / "generated" / folder / "empty_fast.c").write_text("int quick;\n")
    result = run_command("check", cwd=recorded)
    assert result.returncode == 1
    assert f"records {folder}/empty_fast.c, which is not made" in result.stdout


@pytest.mark.parametrize("kind", ["demo", "test", "integration"])
def test_the_script_of_tools_names_every_missing_package(kind: str, tmp_path: Path) -> None:
    """Without any tool and without root, .ci/tools lists every Debian package that this kind of job needs."""
    text = (ROOT / ".ci" / "tools").read_text().replace("/usr", str(tmp_path / "usr"))
    section = re.search(rf"^{kind}\).*?^    ;;", text, re.S | re.M)
    assert section is not None
    needed = {package for line in re.findall(r"^\s*need \S+ (.+)$", section[0], re.M) for package in line.split()}
    for name, output in {"id": "1000", **({"rustc": str(tmp_path)} if kind == "integration" else {})}.items():
        (tmp_path / name).write_text(f"#!/bin/sh\necho {output}\n")
        (tmp_path / name).chmod(0o755)
    (tmp_path / "tools").write_text(text)
    result = subprocess.run(
        ["/bin/sh", str(tmp_path / "tools"), kind], env={"PATH": str(tmp_path)}, capture_output=True, text=True, check=False
    )
    named = set(result.stderr.partition("(Debian names):")[2].split())
    assert needed
    assert needed <= named, needed - named


HOSTILE_MANIFESTS = {
    "a folder that leaves": lambda d: d["folders"].update({"../../x": next(iter(d["folders"].values()))}),
    "an absolute folder": lambda d: d["folders"].update({"/tmp/x": next(iter(d["folders"].values()))}),
    "a file that leaves": lambda d: next(iter(d["folders"].values()))["sha256"].update({"../../../../tasks/empty.toml": "00"}),
    "a task that is no path": lambda d: next(iter(d["folders"].values())).update(task="a\0b.toml"),
    "an unknown design": lambda d: next(iter(d["folders"].values()))["options"].update(design="\0"),
    "an unknown scalar": lambda d: next(iter(d["folders"].values()))["options"].update(scalar=-(2**64)),
    "hashes that are a number": lambda d: next(iter(d["folders"].values())).update(sha256=5),
    "folders that are a list": lambda d: d.update(folders=[]),
}


@pytest.mark.parametrize("change", HOSTILE_MANIFESTS)
def test_a_hostile_manifest_is_bad_input_and_removes_nothing(change: str, recorded) -> None:
    path = recorded / "generated" / "MANIFEST.json"
    document = json.loads(path.read_text())
    HOSTILE_MANIFESTS[change](document)
    path.write_text(json.dumps(document))
    before = {p: p.read_bytes() for p in recorded.rglob("*") if p.is_file()}
    for arguments in (("check",), ("check", "--accept")):
        result = run_command(*arguments, cwd=recorded)
        assert result.returncode == 2, result.stdout
        assert "MANIFEST.json: " in result.stderr
    assert {p: p.read_bytes() for p in recorded.rglob("*") if p.is_file()} == before


@pytest.mark.parametrize("data", [b"[" * 100_000, b'{"sha256": 5, "certified": true}', b"\xff", b'{"sha256": ["empty.c"]}', b""])
def test_a_damaged_certificate_in_the_way_belongs_to_nobody(data: bytes, tmp_path) -> None:
    (tmp_path / "out").mkdir()
    for name in ("other.certificate.json", "empty.c", "empty.fmu"):
        (tmp_path / "out" / name).write_bytes(data)
    refuse_to_overwrite_certified(tmp_path / "out", {"empty.c": b"", "empty.fmu": b"", "empty.certificate.json": data})


def test_a_unit_that_is_packed_to_a_thousandth_is_not_unpacked_whole(tmp_path, monkeypatch) -> None:
    import zipfile

    from stt_codegen.record import overwriting

    monkeypatch.setattr(overwriting, "SIZE_LIMIT", 100_000)
    with zipfile.ZipFile(tmp_path / "empty.fmu", "w", zipfile.ZIP_DEFLATED) as unit:
        unit.writestr("resources/empty.certificate.json", b'{"certified": true, "task": "' + b"x" * 10_000_000 + b'"}')
    refuse_to_overwrite_certified(tmp_path, {"empty.fmu": b""})  # what is larger than any certificate is none


FOLDER = "empty/refined/float"


def edit_task(root: Path) -> None:
    task = root / "tasks" / "empty.toml"
    task.write_text(task.read_text().replace("upper = [1.0, 1.0]", "upper = [1.0, 0.99]"))


def edit_c(root: Path) -> None:
    path = root / "generated" / FOLDER / "empty.c"
    path.write_bytes(path.read_bytes() + b"\n")


def damage_task(root: Path) -> None:
    (root / "tasks" / "empty.toml").write_text("x = [")


def lose_image(root: Path) -> None:
    """Leave a task with a map whose image is gone."""
    header = "image: hall.pgm\nresolution: 1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    (root / "tasks" / "hall.yaml").write_text(header)
    with (root / "tasks" / "empty.toml").open("a") as task:
        task.write('[map]\nfile = "hall.yaml"\n')


def remove_header(root: Path) -> None:
    (root / "generated" / FOLDER / "empty.h").unlink()


def record_older_tool(root: Path) -> None:
    """Leave the folder as a tool that printed one more line would have recorded it."""
    edit_c(root)
    path = root / "generated" / "MANIFEST.json"
    document = json.loads(path.read_text())
    data = (root / "generated" / FOLDER / "empty.c").read_bytes()
    document["folders"][FOLDER]["sha256"]["empty.c"] = hashlib.sha256(data).hexdigest()
    path.write_text(json.dumps(document))


def drop_hash(root: Path) -> None:
    """Leave the manifest as a tool without hashes of tasks wrote it."""
    path = root / "generated" / "MANIFEST.json"
    document = json.loads(path.read_text())
    del document["folders"][FOLDER]["inputs_sha256"]
    path.write_text(json.dumps(document))


TASK_CHANGED, TOOL_CHANGED = "its task tasks/empty.toml changed", "the tool changed, with the versions that are recorded"
UNKNOWN = "its task tasks/empty.toml or the tool changed; the manifest has no hash of the task, --accept adds it"


@pytest.mark.parametrize(
    ("edits", "expected"),
    [
        ([edit_task], TASK_CHANGED),
        ([edit_c], "empty.c edited"),
        ([remove_header], "empty.h missing"),
        ([record_older_tool], TOOL_CHANGED),
        ([edit_task, edit_c], f"empty.c edited; {TASK_CHANGED}"),
        ([record_older_tool, remove_header], f"empty.h missing; {TOOL_CHANGED}"),
        ([drop_hash, edit_task], UNKNOWN),
        ([drop_hash, edit_c], "empty.c edited"),
    ],
    ids=lambda value: "+".join(f.__name__ for f in value) if isinstance(value, list) else "",
)
def test_check_says_which_side_of_a_folder_changed(recorded, edits, expected: str) -> None:
    for edit in edits:
        edit(recorded)
    lines = run_command("check", cwd=recorded).stdout.splitlines()
    assert [line for line in lines if "since it was recorded" in line] == [f"{FOLDER}: since it was recorded: {expected}"]
    (folder,) = json.loads(run_command("check", "--json", cwd=recorded).stdout)["folders"]
    assert folder["task_changed"] is (None if drop_hash in edits else edit_task in edits)
    assert bool(folder["edited"]) is (edit_c in edits)
    assert folder["tool_changed"] is (None if edit_task in edits else record_older_tool in edits)
    run_command("check", "--accept", cwd=recorded)
    assert json.loads(run_command("check", "--json", cwd=recorded).stdout)["folders"] == []


def test_a_comment_in_a_task_is_no_change_and_an_image_of_its_map_is_one(recorded, tmp_path) -> None:
    task = recorded / "tasks" / "empty.toml"
    before = hash_of_inputs(task)
    task.write_text("# a comment\n" + task.read_text())
    assert hash_of_inputs(task) == before
    (tmp_path / "hall.pgm").write_bytes(b"P5 2 2 255\n" + bytes([254] * 4))
    header = "image: hall.pgm\nresolution: 1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.196\n"
    (tmp_path / "hall.yaml").write_text(header)
    task.write_text(task.read_text() + '[map]\nfile = "../hall.yaml"\n')
    with_map = hash_of_inputs(task)
    assert with_map != before
    (tmp_path / "hall.pgm").write_bytes(b"P5 2 2 255\n" + bytes([254, 254, 254, 0]))
    assert hash_of_inputs(task) != with_map


def test_tasks_that_were_never_recorded_are_named(recorded) -> None:
    text = (recorded / "tasks" / "empty.toml").read_text()
    (recorded / "tasks" / "second.toml").write_text(text.replace('"empty"', '"second"'))
    (recorded / "tasks" / "damaged.toml").write_text('name = "damaged\n')
    (recorded / "tasks" / "pyproject.toml").write_text("[tool.ruff]\n")
    (recorded / "tasks" / "hall.task.toml").write_text(text)
    result = run_command("check", cwd=recorded)
    assert result.returncode == 0
    assert re.findall(r"note: (\S+) was never recorded", result.stdout) == ["tasks/damaged.toml", "tasks/second.toml"]
    assert json.loads(run_command("check", "--json", cwd=recorded).stdout)["unrecorded_tasks"] == [
        "tasks/damaged.toml",
        "tasks/second.toml",
    ]
    assert run_command("generate", "tasks/second.toml", "--record", "generated", cwd=recorded).returncode == 0
    (recorded / "tasks" / "damaged.toml").unlink()
    assert "never recorded" not in run_command("check", cwd=recorded).stdout


def refuse_task(root: Path) -> None:
    task = root / "tasks" / "empty.toml"
    task.write_text(task.read_text().replace("upper = [1.0, 1.0]", "upper = [0.0, 1.0]"))


@pytest.mark.parametrize("edit", [refuse_task, damage_task, lose_image])
def test_a_task_that_is_refused_now_is_a_difference_and_hides_no_other(recorded, edit) -> None:
    (recorded / "tasks" / "second.toml").write_text(
        (recorded / "tasks" / "empty.toml").read_text().replace('"empty"', '"second"')
    )
    assert run_command("generate", "tasks/second.toml", "--record", "generated", cwd=recorded).returncode == 0
    edit(recorded)
    path = recorded / "generated" / "second" / "refined" / "float" / "second.c"
    path.write_bytes(path.read_bytes() + b"\n")
    result = run_command("check", cwd=recorded)
    assert result.returncode == 1
    assert f"{FOLDER}: is not made any more (--accept leaves it as it is): " in result.stdout
    assert f"{FOLDER}: since it was recorded: {TASK_CHANGED}" in result.stdout
    assert "second/refined/float: since it was recorded: second.c edited" in result.stdout


def test_files_beside_what_is_recorded_are_not_read_beyond_their_bounds(recorded) -> None:
    """A sparse file of a terabyte, and a task that would cost the parser minutes."""
    with (recorded / "generated" / FOLDER / "empty.c").open("r+b") as file:
        file.truncate(10**12)
    (recorded / "tasks" / "bomb.toml").write_text("a." * 30_000 + "b = 1")
    result = run_command("check", cwd=recorded)
    assert f"{FOLDER}: since it was recorded: empty.c edited" in result.stdout
    assert "note: tasks/bomb.toml was never recorded" in result.stdout
