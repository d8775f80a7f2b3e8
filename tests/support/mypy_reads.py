"""A plugin of mypy that writes down which class an attribute is read from.

mypy knows the class of `design.table`; a search for the word `table` does not. tests/test_unused.py reads this file's records through
mypy_records.py; `make test` runs mypy in any case, so they cost nothing more. A module's record is a file in mypy's cache folder. It is
written again when mypy checks the module, and stays when mypy takes the module from its cache. `report_config_data` makes mypy check
a module whose record is missing.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from pathlib import Path
from typing import TextIO

from mypy.options import Options
from mypy.plugin import AttributeContext, FunctionContext, MethodSigContext, Plugin, ReportConfigContext
from mypy.plugins.default import DefaultPlugin
from mypy.types import CallableType, Instance, ProperType, TupleType, Type, UnionType, get_proper_type

FOLDER = "attribute-reads"
FIELD_READERS = {  # functions that read fields of their first argument: all of them (*), or the field of a computed name (?)
    "dataclasses.asdict": "*",
    "dataclasses.astuple": "*",
    "dataclasses.fields": "*",
    "builtins.vars": "*",
    "builtins.getattr": "?",
}


def record_of(cache: str | Path, path: str) -> Path:
    """Return the record's file for the module at `path`, which is relative to the folder that mypy runs in."""
    return Path(cache) / FOLDER / (path.replace("/", "+") + ".txt")


def classes_of(value: ProperType) -> list[str]:
    """Return the full names of the classes that a value of this type may have."""
    if isinstance(value, UnionType):
        return [name for item in value.items for name in classes_of(get_proper_type(item))]
    if isinstance(value, TupleType):
        return [value.partial_fallback.type.fullname]
    if isinstance(value, CallableType) and value.is_type_obj():
        return [value.type_object().fullname]
    return [value.type.fullname] if isinstance(value, Instance) else []


class ReadRecorder(Plugin):
    """Adds a line `line column class.name` to the module's record for attributes that are read and methods that are called.

    Where mypy's default plugin has a hook for the same name, mypy calls that hook instead, and the class counts as unknown.
    """

    def __init__(self, options: Options) -> None:
        super().__init__(options)
        self.defaults = DefaultPlugin(options)
        self.files: dict[str, TextIO] = {}
        self.lines: set[tuple[str, str]] = set()

    def record(self, path: str) -> TextIO | None:
        """Return the open record of a module; None for a module of a library, or for a run without a cache."""
        if os.path.isabs(path) or self.options.cache_dir == os.devnull:
            return None
        if path not in self.files:
            target = record_of(self.options.cache_dir, path)
            target.parent.mkdir(parents=True, exist_ok=True)
            self.files[path] = target.open("w", buffering=1)  # mypy ends without closing its files
        return self.files[path]

    def report_config_data(self, ctx: ReportConfigContext) -> bool:
        """Return whether the module's record exists; mypy checks a module again when this differs from its cache."""
        if ctx.is_check:
            return os.path.isabs(ctx.path) or record_of(self.options.cache_dir, ctx.path).exists()
        self.record(ctx.path)  # a module without a read has an empty record
        return True

    def write(self, ctx: AttributeContext | MethodSigContext | FunctionContext, fullname: str) -> None:
        """Add a line for a read of the member `fullname` at the position of `ctx`, once."""
        line = f"{ctx.context.line} {ctx.context.column} {fullname}\n"
        file = self.record(ctx.api.path)
        if file is not None and not fullname.endswith("__") and (ctx.api.path, line) not in self.lines:
            self.lines.add((ctx.api.path, line))
            file.write(line)

    def get_attribute_hook(self, fullname: str) -> Callable[[AttributeContext], Type] | None:
        if self.defaults.get_attribute_hook(fullname) is not None:
            return None
        return self.attribute(fullname)

    def get_class_attribute_hook(self, fullname: str) -> Callable[[AttributeContext], Type] | None:
        if self.defaults.get_class_attribute_hook(fullname) is not None:
            return None
        return self.attribute(fullname)

    def attribute(self, fullname: str) -> Callable[[AttributeContext], Type]:
        """Return a hook that records reads of the attribute and does not change its type."""

        def unchanged(ctx: AttributeContext) -> Type:
            if not ctx.is_lvalue:
                self.write(ctx, fullname)
            return ctx.default_attr_type

        return unchanged

    def get_method_signature_hook(self, fullname: str) -> Callable[[MethodSigContext], CallableType] | None:
        if self.defaults.get_method_signature_hook(fullname) is not None:
            return None

        def unchanged(ctx: MethodSigContext) -> CallableType:
            self.write(ctx, fullname)
            return ctx.default_signature

        return unchanged

    def get_function_hook(self, fullname: str) -> Callable[[FunctionContext], Type] | None:
        """Return a hook that records the fields that a call of a function of `FIELD_READERS` reads."""
        if fullname not in FIELD_READERS:
            return None

        def unchanged(ctx: FunctionContext) -> Type:
            for value in ctx.arg_types[0]:
                for name in classes_of(get_proper_type(value)):
                    self.write(ctx, f"{name}.{FIELD_READERS[fullname]}")
            return ctx.default_return_type

        return unchanged


def plugin(version: str) -> type[Plugin]:
    """Return the plugin's class: the entry point that mypy calls."""
    return ReadRecorder
