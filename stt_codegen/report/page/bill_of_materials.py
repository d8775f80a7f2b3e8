"""Write the software bill of materials of one controller in CycloneDX 1.6: its files, what they call, and the tools' versions.

It has no serial number and no date, so the same task and versions give the same bill.
"""

from __future__ import annotations

import hashlib
import importlib.metadata
import re
from collections.abc import Mapping
from typing import Any

from stt_codegen import __version__
from stt_codegen.pipeline import EmittedController

PYTHON_PACKAGES = (
    "casadi",
    "highspy",
    "jinja2",
    "numpy",
    "pydantic",
    "python-flint",
    "scipy",
)  # on which emitted bytes may depend
LIBRARY_CALL = re.compile(r"\b(logf?|expf?|log1pf?|powf?|sqrtf?|memcpy)\(")


def bill_of_materials(controller: EmittedController) -> dict[str, Any]:
    """Return the bill as JSON data."""
    name, files = controller.task.name, controller.files
    calls = library_calls(files)
    file_entries = [
        {
            "type": "file",
            "bom-ref": f"file:{file}",
            "name": file,
            "hashes": [{"alg": "SHA-256", "content": hashlib.sha256(data).hexdigest()}],
        }
        for file, data in files.items()
    ]
    library_entries = [
        {
            "type": "library",
            "bom-ref": "libc",
            "name": "the C library of the board",
            "description": f"not delivered here; called for {', '.join(calls)}",
        }
    ]
    tool = {"type": "application", "bom-ref": "stt_codegen", "name": "stt_codegen", "version": __version__}
    packages = [
        {
            "type": "library",
            "name": package,
            "version": importlib.metadata.version(package),
            "purl": f"pkg:pypi/{package}@{importlib.metadata.version(package)}",
        }
        for package in PYTHON_PACKAGES
    ]
    used_libraries = ["libc"] if calls else []
    return {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {
            "component": {"type": "firmware", "bom-ref": name, "name": name, "version": _design_hash(controller)},
            "tools": {"components": [tool, *packages]},
        },
        "components": [*file_entries, *(library_entries if calls else [])],
        "dependencies": [
            {"ref": name, "dependsOn": [entry["bom-ref"] for entry in file_entries] + used_libraries},
            *({"ref": f"file:{file}", "dependsOn": used_libraries} for file in files if library_calls({file: files[file]})),
        ],
    }


def library_calls(files: Mapping[str, bytes]) -> list[str]:
    """Return the functions of the C library that the C of these files calls."""
    return sorted({call for name, data in files.items() if name.endswith(".c") for call in LIBRARY_CALL.findall(data.decode())})


def _design_hash(controller: EmittedController) -> str:
    """Return the design hash from the header, which the firmware can log."""
    header = controller.files[f"{controller.task.name}.h"].decode()
    match = re.search(r'_DESIGN_HASH "([0-9a-f]{16})"', header)
    assert match is not None
    return match[1]
