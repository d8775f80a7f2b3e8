"""Packages keep their bytes: units of FMI, nodes of ROS and libraries are what package_digests.json recorded.

A user's tools compare these files, and a unit's token names it, so a change of their text is announced. After one that is meant:

    python -m tests.record.test_package_bytes        # writes package_digests.json; its diff is part of the review
"""

from __future__ import annotations

import hashlib
import io
import json
import zipfile
from collections.abc import Iterator
from pathlib import Path

import pytest

from stt_codegen.record.package import package
from tests.support.controllers import controller_of

RECORD = Path(__file__).parent / "package_digests.json"
KINDS = {
    "omni_s2": ("cmake", "arduino", "platformio", "fmu", "ros2"),
    "trolley": ("fmu", "ros2"),  # with a period
    "drone": ("fmu", "ros2"),  # of order 2
    "watchman": ("fmu", "ros2"),  # without an end
    "crane": ("arduino",),  # in integers
}


def package_files(name: str, kind: str) -> Iterator[tuple[str, bytes]]:
    """Yield name and contents of each file of a package; of a unit those of its members that no compiler made.

    The checker is left out: its bytes are those of the program (tests/certify/test_checker_archive.py)."""
    controller = controller_of(name, "fixed" if name == "crane" else "float")
    for file, data in package(controller, kind).items():
        if file.endswith(".fmu"):
            with zipfile.ZipFile(io.BytesIO(data)) as unit:
                members = [member for member in unit.namelist() if not member.startswith(("binaries/", "resources/checker"))]
                yield from ((f"{file}/{member}", unit.read(member)) for member in members)
        elif not file.endswith("/extras/checker.pyz"):
            yield file, data


def digests(name: str) -> dict[str, str]:
    """Return the first 16 hexadecimal digits of the SHA-256 of each file, by the package's kind and the file's name."""
    return {
        f"{kind}: {file}": hashlib.sha256(data).hexdigest()[:16]
        for kind in KINDS[name]
        for file, data in package_files(name, kind)
    }


@pytest.mark.parametrize("name", KINDS)
def test_a_package_keeps_its_bytes(name: str, tool) -> None:
    if "fmu" in KINDS[name]:
        tool("cc")
    assert digests(name) == json.loads(RECORD.read_text())[name]


if __name__ == "__main__":
    RECORD.write_text(json.dumps({name: digests(name) for name in KINDS}, indent=1, sort_keys=True) + "\n")
