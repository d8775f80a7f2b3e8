"""The stand-alone checker: it proves a certificate from task, C and header alone.

`stt_checker/` beside this file is a package that imports nothing of stt_codegen; `python3 -I stt_codegen/checker` runs it, and
`archive` makes one file of both, `checker.pyz`. theorem/, tests and benchmarks import the package from here.
"""

from pathlib import Path

from stt_codegen.checker.stt_checker import check_files as check_files
from stt_codegen.checker.stt_checker import verdict

FOLDER = Path(__file__).parent  # `python3 -I FOLDER TASK C CERTIFICATE` runs it as a program of its own

__all__ = ["FOLDER", "archive", "stt_checker", "verdict"]
