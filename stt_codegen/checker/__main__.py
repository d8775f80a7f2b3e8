"""Run the checker from its folder: python3 stt_codegen/checker TASK.toml CONTROLLER.c CERTIFICATE.json."""

import sys
from pathlib import Path

if sys.version_info < (3, 11):  # noqa: UP036 - whoever checks may have an older one
    print("checker: cannot check: it needs Python 3.11 or a newer one", file=sys.stderr)
    sys.exit(2)
sys.dont_write_bytecode, sys.pycache_prefix = True, "/dev/null"  # imports read the source that is here, and no compiled file
sys.path.insert(0, str(Path(__file__).parent))  # for `python3 -I`, which does not add it

from stt_checker import check_files  # type: ignore[import-not-found]  # noqa: E402

sys.exit(check_files(sys.argv[1:]))
