"""Run the checker from its folder: python3 stt_codegen/checker TASK.toml CONTROLLER.c CERTIFICATE.json."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))  # for `python3 -I`, which does not add it

from stt_checker.main import main  # type: ignore[import-not-found]

sys.exit(main(sys.argv[1:]))
