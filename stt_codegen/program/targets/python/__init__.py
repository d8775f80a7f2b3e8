"""Python: one module in double arithmetic on the emitted constants, with `math` and nothing else."""

import keyword
import sys
from collections.abc import Callable
from typing import Any

from stt_codegen.program.targets.python.printer import PythonPrinter
from stt_codegen.program.targets.target import Emitted, TargetLanguage

__all__ = ["TARGET", "PythonPrinter", "runner"]

# Modules that <name>.py must not shadow: the interpreter looks in the folder of a script before its library.
MODULES = frozenset({name.lower() for name in sys.stdlib_module_names} | {"numpy"})


def _runner() -> Callable[[Emitted], Any]:
    from stt_codegen.program.targets.python.runner import GeneratedPython

    return GeneratedPython


TARGET = TargetLanguage(
    key="python",
    title="Python",
    suffixes=(".py",),
    printer=PythonPrinter,
    words=frozenset(keyword.kwlist) | frozenset(keyword.softkwlist),
    words_are="a reserved word of Python",
    library=MODULES,
    integers=True,
    scalars=("double",),
    runner=_runner,
    lacks={"PERIOD_PROVED": "the bytes of every Python file with a period would change"},
)
