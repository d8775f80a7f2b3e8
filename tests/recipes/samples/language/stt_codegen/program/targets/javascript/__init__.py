"""JavaScript: one module in double arithmetic on the emitted constants, with `Math` and nothing else."""

from collections.abc import Callable
from typing import Any

from stt_codegen.program.targets.javascript.printer import JavaScriptPrinter

from stt_codegen.program.targets.target import Emitted, TargetLanguage

__all__ = ["TARGET"]

WORDS = frozenset(
    """arguments await break case catch class const continue debugger default delete do else enum eval export extends false finally
    for function if implements import in instanceof interface let new null package private protected public return static super
    switch this throw true try typeof undefined var void while with yield module require Math Number""".split()
)


def _runner() -> Callable[[Emitted], Any]:
    from stt_codegen.program.targets.javascript.runner import RunJavaScript, find_node

    find_node()
    return RunJavaScript


TARGET = TargetLanguage(
    key="javascript",
    title="JavaScript",
    suffixes=(".js",),
    printer=JavaScriptPrinter,
    words=WORDS,
    words_are="a reserved word of JavaScript",
    option="adds <name>.js, a module for node",
    scalars=("double",),
    runner=_runner,
    lacks=dict.fromkeys(("phase", "wrap", "wrap_tick", "unwrap", "guard", "PERIOD_PROVED"), "the template is small"),
)
