"""Files for people that a package has beside the C: the certificate, the checker that reads it, the task, the Python."""

from __future__ import annotations

from collections.abc import Mapping

from stt_codegen.checker import archive
from stt_codegen.designs import Design
from stt_codegen.emit.naming import file_names, spelled_name
from stt_codegen.emit.render import Files


def extra_files(prefix: str, design: Design, files: Mapping[str, bytes], *, has_module: bool = True) -> Files:
    """Return the extra files by name, out of all emitted `files`. has_module: whether the Python is one of them.

    The task is there where the text of its sets was written out, the checker where it can check the certificate.
    """
    common = file_names(prefix)
    names = [*([common.module] if has_module else []), common.certificate, spelled_name(prefix)]
    checker = {archive.ARCHIVE_NAME: archive.archive_bytes()} if design.capabilities.has_exact_claims else {}
    return {name: files[name] for name in names if name in files} | checker
