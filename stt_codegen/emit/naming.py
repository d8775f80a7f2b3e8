"""Names of emitted files, and a check that no two names in them collide: every external name begins with the task's prefix.

The task loader refuses prefixes that are reserved words or shadow a library. `check_names` is about the finished Program, so that
a new kernel or function cannot collide with a name of the same file.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from stt_codegen.program import Assign, Call, For, Program, Return, Statement
from stt_codegen.program.targets import TARGETS


class CommonFiles(NamedTuple):
    """The names of the files that every task has: C and its header, the Python module, and the certificate."""

    header: str
    source: str
    module: str
    certificate: str


def file_names(prefix: str) -> CommonFiles:
    """Return the names of the files that every task has; those of code are of the languages that are always emitted."""
    header, source, module = (name for target in TARGETS if not target.option for name in target.file_names(prefix))
    return CommonFiles(header, source, module, f"{prefix}.certificate.json")


def selftest_name(prefix: str) -> str:
    """Return the file that `emit.selftest` adds."""
    return f"{prefix}_selftest.c"


def guard_name(prefix: str) -> str:
    """Return the file that `control.outside` adds where it is not "return"."""
    return f"{prefix}_guard.c"


def phase_name(prefix: str) -> str:
    """Return the file that a mission adds."""
    return f"{prefix}_phase.c"


def wrap_name(prefix: str) -> str:
    """Return the file that `repeat` adds."""
    return f"{prefix}_wrap.c"


def unwrap_name(prefix: str) -> str:
    """Return the file that `periodic` adds."""
    return f"{prefix}_unwrap.c"


def spelled_name(prefix: str) -> str:
    """Return the file of the task with the sets of its map or outline written out, which the checker reads."""
    return f"{prefix}.task.toml"


def check_names(program: Program) -> None:
    """Refuse names that collide, whatever the task is called.

    Raises `ValueError` when two externals collide, a local is assigned twice, or a name is taken in a target language. The same
    for a local that could be an external name of the file for some name of the task, which begins external names: it would hide
    that name. Capitals are for macros: no local has them.
    """
    external = [t.name for t in program.tables] + [k.name for k in program.kernels] + [f.name for f in program.functions]
    external += ["real", "status", "selftest", "guard", "phase", "wrap", "wrap_tick", "unwrap", "exponent", "mantissa"]
    _require_unique(external, "the file")
    for kernel in program.kernels:
        _require_unique([v.name for v in kernel.inputs] + [a.var.name for a in kernel.body], kernel.name)
    for function in program.functions:
        _require_unique([p.name for p in function.params] + list(_assigned_names(function.body)), function.name)
    endings = tuple(f"_{name}" for name in {*external, *_helper_names(program)})
    for name in _locals(program):
        if name.endswith(endings):
            raise ValueError(f"the local {name!r} would hide a function or table of a task called {name.partition('_')[0]!r}")
        if not re.fullmatch(r"[a-z][a-z0-9_]*", name):
            raise ValueError(f"the local {name!r} is no name in small letters")


def _helper_names(program: Program) -> set[str]:
    """Return the names of the helper functions that printers add, without the task's name."""
    printable = (target for target in TARGETS if target.integers or program.scalar != "fixed")
    text = "\n".join(str(target.printer(program).helpers()) for target in printable)
    return set(re.findall(rf"\b{re.escape(program.prefix)}_(\w+)", text))


def _locals(program: Program) -> Iterator[str]:
    """Yield the names of all parameters and local variables of a program."""
    for kernel in program.kernels:
        yield from (v.name for v in kernel.inputs)
        yield from (a.var.name for a in kernel.body)
    for function in program.functions:
        yield from (p.name for p in function.params)
        yield from _assigned_names(function.body)


def _assigned_names(body: Iterable[Statement]) -> Iterator[str]:
    """Yield the names that a body assigns: variables, results of calls, loop counters and carried values."""
    for statement in body:
        match statement:
            case Assign(var=var):
                yield var.name
            case Call(results=results):
                yield from (r.name for r in results)
            case For(index=index, body=inner, carries=carries):
                yield index.name
                yield from (c.var.name for c in carries)
                yield from _assigned_names(inner)
            case Return(body=inner):
                yield from _assigned_names(inner)


def _require_unique(names: list[str], where: str) -> None:
    """Raise ValueError where a name occurs twice, or is taken in a target language; where: the part that has the names."""
    earlier_names: set[str] = set()
    for name in names:
        if name in earlier_names:
            raise ValueError(f"{where}: the name {name!r} is used twice")
        for target in TARGETS:
            if name in target.words:
                raise ValueError(f"{where}: {name!r} is {target.words_are}")
            if name in target.globals:
                raise ValueError(f"{where}: {name!r} is a name of the library of {target.title}")
        earlier_names.add(name)
