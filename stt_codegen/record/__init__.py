"""Write files: packages for build systems and simulators, recorded folders and their comparison with what is built now."""

from stt_codegen.record.manifest import folder_of, record
from stt_codegen.record.overwriting import refuse_to_overwrite_certified, refuse_to_overwrite_inputs, require_distinct_paths
from stt_codegen.record.package import package
from stt_codegen.record.ros2 import interface_of
from stt_codegen.record.sketch import sketch_notes

__all__ = [
    "check",
    "folder_of",
    "interface_of",
    "package",
    "record",
    "refuse_to_overwrite_certified",
    "refuse_to_overwrite_inputs",
    "require_distinct_paths",
    "sketch_notes",
]
