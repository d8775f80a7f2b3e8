"""Read input files within bounds (docs/inputs.md), and write output files as one set, one writer at a time."""

from stt_codegen.files.bounded_json import json_object
from stt_codegen.files.bounded_reading import decode, printable, read_input
from stt_codegen.files.bounded_toml import parse_toml
from stt_codegen.files.locks import locked
from stt_codegen.files.writing import CERTIFICATE_SUFFIX, write_files

__all__ = ["CERTIFICATE_SUFFIX", "decode", "json_object", "locked", "parse_toml", "printable", "read_input", "write_files"]
