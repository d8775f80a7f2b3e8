"""The stand-alone checker: a package that imports the standard library alone, and is read from main.py on."""

from .main import main as check_files

__all__ = ["check_files"]
