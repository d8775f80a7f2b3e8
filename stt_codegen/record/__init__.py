"""Files on disk: recorded sets, packages for build systems and simulators, and whether they are still what the tool writes."""

from stt_codegen.record.files import write_files
from stt_codegen.record.manifest import folder_of, record
from stt_codegen.record.package import package
from stt_codegen.record.ros2 import interface_of
from stt_codegen.record.sketch import sketch_notes
from stt_codegen.record.standing import keep_apart, keep_certified, keep_inputs

__all__ = [
    "check",
    "folder_of",
    "interface_of",
    "keep_apart",
    "keep_certified",
    "keep_inputs",
    "package",
    "record",
    "sketch_notes",
    "write_files",
]
