"""stt_codegen: certified prescribed-time reach-avoid-stay controllers in C and Python from one TOML file.

`stt_codegen.pipeline` is the map; `stt-codegen --help` the way in.
"""

__version__ = "0.1.0"
