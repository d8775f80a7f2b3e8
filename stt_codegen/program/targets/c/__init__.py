"""C: header and source, which take C++ compilers too, and small files beside them that a task may ask for."""

from collections.abc import Callable
from typing import Any

from stt_codegen.program.targets.c.headers import HEADERS
from stt_codegen.program.targets.c.helpers import fixed_lines, split_lines
from stt_codegen.program.targets.c.macros import COMMON_MACROS
from stt_codegen.program.targets.c.printer import CPrinter
from stt_codegen.program.targets.target import Emitted, TargetLanguage

__all__ = ["TARGET", "CPrinter", "fixed_lines", "runner", "split_lines"]

C_WORDS = frozenset(
    """auto break case char const continue default do double else enum extern float for goto if inline int long
    register restrict return short signed sizeof static struct switch typedef union unsigned void volatile while
    bool true false alignas alignof constexpr nullptr static_assert thread_local typeof typeof_unqual
    asm fortran main errno""".split()
)

CPP_WORDS = frozenset(
    """alignas alignof and and_eq asm atomic_cancel atomic_commit atomic_noexcept auto bitand bitor bool break case
    catch char char8_t char16_t char32_t class compl concept const consteval constexpr constinit const_cast continue
    co_await co_return co_yield decltype default delete do double dynamic_cast else enum explicit export extern false
    float for friend goto if inline int long mutable namespace new noexcept not not_eq nullptr operator or or_eq
    private protected public reflexpr register reinterpret_cast requires return short signed sizeof static
    static_assert static_cast struct switch synchronized template this thread_local throw true try typedef typeid
    typename union unsigned using virtual void volatile wchar_t while xor xor_eq final override import module""".split()
)

MATH_WORDS = frozenset("j0 j1 jn y0 y1 yn gamma lgamma signgam isfinite NAN INFINITY".split())


def _runner() -> Callable[[Emitted], Any]:
    from stt_codegen.program.targets.c.runner import CompiledC, find_compiler

    find_compiler()
    return CompiledC


TARGET = TargetLanguage(
    key="c",
    title="C",
    suffixes=(".h", ".c"),
    printer=CPrinter,
    words=C_WORDS | CPP_WORDS,
    words_are="a reserved word of C or C++",
    library=HEADERS,
    globals=MATH_WORDS | COMMON_MACROS,
    integers=True,
    runner=_runner,
)
