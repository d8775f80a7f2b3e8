"""What a certificate among files is about: the hashes of the set's other files."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from stt_codegen.errors import BadInput
from stt_codegen.files.bounded_json import json_object

CERTIFICATE_SUFFIX = ".certificate.json"  # such a file has the hashes of the set's other files


def parse_certificate(data: bytes) -> dict[str, Any]:
    """Return a certificate as JSON data; empty where the data is none."""
    with suppress(ValueError):
        return json_object(data)
    return {}


def hashes_in(certificate: Mapping[str, Any]) -> dict[str, Any]:
    """Return the hashes of a certificate by file; empty where it has none."""
    hashes = certificate.get("sha256")
    return hashes if isinstance(hashes, dict) else {}


def possible_paths(certificate: str, name: str) -> Iterator[str]:
    """Yield where the file `name` of a certificate may lie, relative to the same folder as the certificate's path."""
    parent = Path(certificate).parent
    yield (parent / name).as_posix()
    if parent.name == "extras":
        yield (parent.parent / "src" / name).as_posix()


def require_certified_contents(files: Mapping[str, bytes]) -> None:
    """Raise `BadInput` where a certificate among the files has another hash of one of them."""
    for certificate in (path for path in files if path.endswith(CERTIFICATE_SUFFIX)):
        for name, digest in hashes_in(parse_certificate(files[certificate])).items():
            for path in possible_paths(certificate, name):
                if path in files and hashlib.sha256(files[path]).hexdigest() != digest:
                    raise BadInput(
                        f"{path}: is not what {certificate} is about; write the files as they were emitted, or without the "
                        "certificate"
                    )
