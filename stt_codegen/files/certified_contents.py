"""What a certificate among files is about: the hashes of the set's other files."""

from __future__ import annotations

import hashlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from stt_codegen.errors import BadInput
from stt_codegen.files.bounded_reading import read_input
from stt_codegen.files.json_file import parse_json_object

CERTIFICATE_SUFFIX = ".certificate.json"  # such a file has the hashes of the set's other files
SIZE_LIMIT = 64_000_000  # bytes of a certificate


def parse_certificate(data: bytes) -> dict[str, Any]:
    """Return a certificate as JSON data; empty where the data is none."""
    with suppress(ValueError):
        return parse_json_object(data)
    return {}


def read_certificate(path: Path) -> dict[str, Any]:
    """Return a certificate as JSON data; empty where the file is none, or larger than any that this package writes."""
    with suppress(BadInput):
        return parse_certificate(read_input(path, SIZE_LIMIT, "")) if path.is_file() else {}
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
        for path in _altered_files(certificate, parse_certificate(files[certificate]), files):
            raise BadInput(
                f"{path}: is not what {certificate} is about; write the files as they were emitted, or without the certificate"
            )


def require_certificates_that_stay_to_fit(folder: Path, files: Mapping[str, bytes]) -> None:
    """Raise `BadInput` where a certificate in the folder, which the files do not replace, has another hash of one of them."""
    parents = {Path(name).parent for name in files}
    parents |= {parent.parent / "extras" for parent in parents if parent.name == "src"}  # see `possible_paths`
    paths = (path for parent in parents for path in (folder / parent).glob(f"*{CERTIFICATE_SUFFIX}"))
    for certificate in sorted({path.relative_to(folder).as_posix() for path in paths} - files.keys()):
        for path in _altered_files(certificate, read_certificate(folder / certificate), files):
            raise BadInput(
                f"{folder / path}: {certificate} there is about another one; write it with its certificate, or to another folder"
            )


def _altered_files(certificate: str, document: Mapping[str, Any], files: Mapping[str, bytes]) -> Iterator[str]:
    """Yield the files of which a certificate has another hash. certificate: its path, relative to the same folder as theirs."""
    for name, digest in hashes_in(document).items():
        for path in possible_paths(certificate, name):
            if path in files and hashlib.sha256(files[path]).hexdigest() != digest:
                yield path
