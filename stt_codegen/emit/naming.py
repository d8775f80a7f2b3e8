"""Names in emitted files: everything external begins with the task's prefix, nothing collides.

The task loader has refused prefixes that are reserved words or shadow a library; here the finished Program is checked,
so that a new kernel or function cannot collide with another name of the same file.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from stt_codegen.program import Assign, Call, For, Program, Return, Statement
from stt_codegen.task.reserved import C_WORDS, CPP_WORDS, RUST_WORDS

SUFFIXES = (".h", ".c", ".py", ".certificate.json")
MATH_WORDS = frozenset("j0 j1 jn y0 y1 yn gamma lgamma signgam isfinite NAN INFINITY".split())


def file_names(prefix: str) -> tuple[str, ...]:
    """The files that `generate` writes for one task."""
    return tuple(prefix + suffix for suffix in SUFFIXES)


def selftest_name(prefix: str) -> str:
    """The file that `emit.selftest` adds."""
    return f"{prefix}_selftest.c"


def guard_name(prefix: str) -> str:
    """The file that `control.outside` adds where it is not "return"."""
    return f"{prefix}_guard.c"


def phase_name(prefix: str) -> str:
    """The file that a mission adds."""
    return f"{prefix}_phase.c"


def wrap_name(prefix: str) -> str:
    """The file that `repeat` adds."""
    return f"{prefix}_wrap.c"


def rust_name(prefix: str) -> str:
    """The file that `emit.rust` adds."""
    return f"{prefix}.rs"


def check_names(program: Program) -> None:
    """Raise ValueError when two externals collide, a local is assigned twice, or a name is a word of C, C++, <math.h> or Rust."""
    external = [t.name for t in program.tables] + [k.name for k in program.kernels] + [f.name for f in program.functions]
    external += ["real", "status", "selftest", "guard", "phase", "wrap", "wrap_tick", "exponent", "mantissa"]
    _unique(external, "the file")
    for kernel in program.kernels:
        _unique([v.name for v in kernel.inputs] + [a.var.name for a in kernel.body], kernel.name)
    for function in program.functions:
        _unique([p.name for p in function.params] + list(_assigned(function.body)), function.name)


def _assigned(body: Iterable[Statement]) -> Iterator[str]:
    for statement in body:
        match statement:
            case Assign(var=var):
                yield var.name
            case Call(results=results):
                yield from (r.name for r in results)
            case For(index=index, body=inner, carries=carries):
                yield index.name
                yield from (c.var.name for c in carries)
                yield from _assigned(inner)
            case Return(body=inner):
                yield from _assigned(inner)


def _unique(names: list[str], where: str) -> None:
    seen: set[str] = set()
    for name in names:
        if name in seen:
            raise ValueError(f"{where}: the name {name!r} is used twice")
        if name in C_WORDS | CPP_WORDS | MATH_WORDS | RUST_WORDS:
            raise ValueError(f"{where}: {name!r} is a word of C, C++, <math.h> or Rust")
        seen.add(name)
