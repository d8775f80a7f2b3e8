"""What the package knows of a target language. A language is a folder here, whose `__init__.py` has one `TargetLanguage`, and an
entry of `TARGETS` in registry.py."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from stt_codegen.program.nodes import Program
from stt_codegen.program.targets.printer import Printer


class Emitted(Protocol):
    """A controller as runners see it."""

    @property
    def program(self) -> Program: ...
    @property
    def files(self) -> Mapping[str, bytes]: ...


@dataclass(frozen=True)
class Layout:
    """The files of the package that `--package <key>` writes, in the language's usual layout.

    sources: the path of each emitted file, by its suffix. templates: the template of each further file, by path. selftest: the
    path and the template of calls whose results are known; left out where rounding makes u too uncertain.
    """

    sources: Mapping[str, str]
    templates: Mapping[str, str]
    selftest: tuple[str, str] | None = None


@dataclass(frozen=True, kw_only=True)
class TargetLanguage:
    """One target language.

    key: the name of its folder, of its printer in its templates, of its key in [emit], and of its kind of package. title: what
    people call it. suffixes: of the files that it emits, in order; `controller<suffix>.j2` in its folder is the template of each.
    printer: made of a Program, it prints the parts that the templates place. words: names that no task, kernel, function
    or variable of a Program can have; words_are: what they are, as the end of a sentence. library: lower-case names of the
    language's library that a file of a task's name would shadow. globals: names that its files take from the library, and
    macros of common headers, so that no part of a Program can have them.

    option: the description of its key in [emit], where a task has to ask for it; empty for a language that is always emitted.
    integers: whether it emits controllers in integers too, from `fixed<suffix>.j2`. runner: returns the class of the backend
    that makes the emitted code callable for `compare`, which it imports; it raises `MissingTool` where the language's tools are
    missing. scalars: those that `compare` runs it in. package: the language's own package, if it has one. lacks: names of
    `ADDED_NAMES` (task/added_names.py) that its template does not add, each with the reason.
    """

    key: str
    title: str
    suffixes: tuple[str, ...]
    printer: Callable[[Program], Printer]
    words: frozenset[str]
    words_are: str
    runner: Callable[[], Callable[[Emitted], Any]]
    library: frozenset[str] = frozenset()
    globals: frozenset[str] = frozenset()
    option: str = ""
    integers: bool = False
    scalars: tuple[str, ...] = ("float", "double")
    package: Layout | None = field(default=None)
    lacks: Mapping[str, str] = field(default_factory=dict)

    def file_names(self, prefix: str) -> list[str]:
        """Return the names of the files that it emits for a task of this name."""
        return [prefix + suffix for suffix in self.suffixes]
