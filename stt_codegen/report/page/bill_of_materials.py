"""The software bill of materials of one controller, in CycloneDX 1.6: its files, what they call, and what made them.

Without a serial number or a date: the same task and versions give the same bill."""

from __future__ import annotations

import hashlib
import importlib.metadata
import re
from collections.abc import Mapping
from typing import Any

from stt_codegen import __version__
from stt_codegen.pipeline import EmittedController

PACKAGES = ("casadi", "highspy", "jinja2", "numpy", "pydantic", "python-flint", "scipy")  # that an emitted byte may depend on
CALLS = re.compile(r"\b(logf?|expf?|log1pf?|powf?|sqrtf?|memcpy)\(")


def bill(controller: EmittedController) -> dict[str, Any]:
    """CycloneDX as JSON data."""
    name, version = controller.task.name, controller.files
    calls = library_calls(version)
    files = [
        {
            "type": "file",
            "bom-ref": f"file:{file}",
            "name": file,
            "hashes": [{"alg": "SHA-256", "content": hashlib.sha256(data).hexdigest()}],
        }
        for file, data in controller.files.items()
    ]
    library = [
        {
            "type": "library",
            "bom-ref": "libc",
            "name": "the C library of the board",
            "description": f"not delivered here; called for {', '.join(calls)}",
        }
    ]
    tool = {"type": "application", "bom-ref": "stt_codegen", "name": "stt_codegen", "version": __version__}
    made_by = [
        {
            "type": "library",
            "name": package,
            "version": importlib.metadata.version(package),
            "purl": f"pkg:pypi/{package}@{importlib.metadata.version(package)}",
        }
        for package in PACKAGES
    ]
    used = ["libc"] if calls else []
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {
            "component": {"type": "firmware", "bom-ref": name, "name": name, "version": _design_hash(controller)},
            "tools": {"components": [tool, *made_by]},
        },
        "components": [*files, *(library if calls else [])],
        "dependencies": [
            {"ref": name, "dependsOn": [one["bom-ref"] for one in files] + used},
            *({"ref": f"file:{file}", "dependsOn": used} for file in version if library_calls({file: version[file]})),
        ],
    }


def library_calls(files: Mapping[str, bytes]) -> list[str]:
    """The functions of the C library that the C of these files calls."""
    return sorted({call for name, data in files.items() if name.endswith(".c") for call in CALLS.findall(data.decode())})


def _design_hash(controller: EmittedController) -> str:
    """The hash that the firmware logs, from the header."""
    header = controller.files[f"{controller.task.name}.h"].decode()
    found = re.search(r'_DESIGN_HASH "([0-9a-f]{16})"', header)
    assert found is not None
    return found[1]
