"""Read input files within bounds (docs/inputs.md), and write output files as one set, one writer at a time."""

from stt_codegen.files.bounded_reading import decode, read_input
from stt_codegen.files.bounded_toml import parse_toml
from stt_codegen.files.certified_contents import (
    CERTIFICATE_SUFFIX,
    hashes_in,
    parse_certificate,
    possible_paths,
    read_certificate,
    require_certified_contents,
)
from stt_codegen.files.json_file import parse_json_object
from stt_codegen.files.locks import locked
from stt_codegen.files.task_text import read_task_text
from stt_codegen.files.writing import write_files

__all__ = [
    "CERTIFICATE_SUFFIX",
    "decode",
    "hashes_in",
    "locked",
    "parse_certificate",
    "parse_json_object",
    "parse_toml",
    "possible_paths",
    "read_certificate",
    "read_input",
    "read_task_text",
    "require_certified_contents",
    "write_files",
]
