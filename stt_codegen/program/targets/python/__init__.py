"""Python: one module in double arithmetic on the emitted constants, with `math` and nothing else."""

import keyword
import sys
from collections.abc import Callable
from typing import Any

from stt_codegen.program.targets.python.printer import PythonPrinter
from stt_codegen.program.targets.target import Emitted, TargetLanguage

__all__ = ["TARGET", "PythonPrinter", "runner"]

# Modules that <name>.py must not shadow: the interpreter looks in the folder of a script before its library.
# Modules that some of Python 3.11 to 3.14 have count too, so that every interpreter refuses the same names.
SOME_VERSIONS = """aifc annotationlib asynchat asyncore audioop cgi cgitb chunk compression crypt distutils imghdr imp lib2to3
    mailcap msilib nis nntplib ossaudiodev pipes smtpd sndhdr spwd sunau telnetlib uu xdrlib""".split()
MODULES = frozenset({name.lower() for name in sys.stdlib_module_names} | {"numpy", *SOME_VERSIONS})


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
