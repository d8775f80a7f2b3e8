"""Run the checker from its folder: python3 stt_codegen/checker TASK.toml CONTROLLER.c CERTIFICATE.json."""

import sys
from pathlib import Path

sys.dont_write_bytecode, sys.pycache_prefix = True, "/dev/null"  # run what can be read here, and no compiled file beside it
sys.path.insert(0, str(Path(__file__).parent))  # for `python3 -I`, which does not add it

from stt_checker import check_files  # type: ignore[import-not-found]  # noqa: E402

sys.exit(check_files(sys.argv[1:]))
