"""The stand-alone checker: a package that imports the standard library alone, and is read from main.py on."""

from .main import main as check_files
from .main import verdict

# Beside it, the modules that theorems read the files with.
__all__ = ["check_files", "claims", "exact", "rounding", "sets", "source", "task", "tube", "verdict"]
