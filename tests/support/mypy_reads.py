"""A plugin of mypy that writes down which class an attribute is read from.

mypy knows the class of `lattice.room`; a search for the word `room` does not. tests/test_unused.py takes its facts from this file's
records, so the run of mypy that `make test` has anyway pays for them. A module's record lies in mypy's cache folder. It is written
anew when mypy checks the module, and stays when mypy takes the module from its cache: their lives are coupled by
`report_config_data`, which makes mypy check a module whose record is missing.
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
DYNAMIC = {  # functions that read fields of their first argument: all of them, or the field of a computed name
    "dataclasses.asdict": "*",
    "dataclasses.astuple": "*",
    "dataclasses.fields": "*",
    "builtins.vars": "*",
    "builtins.getattr": "?",
}


def record_of(cache: str | Path, path: str) -> Path:
    """The file with the reads of the module at `path`, relative to the folder that mypy runs in."""
    return Path(cache) / FOLDER / (path.replace("/", "+") + ".txt")


def classes_of(value: ProperType) -> list[str]:
    """Full names of the classes that a value of this type may have."""
    if isinstance(value, UnionType):
        return [name for item in value.items for name in classes_of(get_proper_type(item))]
    if isinstance(value, TupleType):
        return [value.partial_fallback.type.fullname]
    if isinstance(value, CallableType) and value.is_type_obj():
        return [value.type_object().fullname]
    return [value.type.fullname] if isinstance(value, Instance) else []


class Reads(Plugin):
    """Adds a line `line column class.name` to the module's record for attributes that are read and methods that are called.

    Where mypy's plugin has a hook for the same name, that hook goes first and the class counts as unknown.
    """

    def __init__(self, options: Options) -> None:
        super().__init__(options)
        self.defaults = DefaultPlugin(options)
        self.files: dict[str, TextIO] = {}
        self.lines: set[tuple[str, str]] = set()

    def record(self, path: str) -> TextIO | None:
        if os.path.isabs(path) or self.options.cache_dir == os.devnull:
            return None  # of a library, or of a run that leaves no trace
        if path not in self.files:
            target = record_of(self.options.cache_dir, path)
            target.parent.mkdir(parents=True, exist_ok=True)
            self.files[path] = target.open("w", buffering=1)  # mypy ends without closing its files
        return self.files[path]

    def report_config_data(self, ctx: ReportConfigContext) -> bool:
        if ctx.is_check:
            return os.path.isabs(ctx.path) or record_of(self.options.cache_dir, ctx.path).exists()
        self.record(ctx.path)  # a module without a read has an empty record
        return True

    def write(self, ctx: AttributeContext | MethodSigContext | FunctionContext, fullname: str) -> None:
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
        if fullname not in DYNAMIC:
            return None

        def unchanged(ctx: FunctionContext) -> Type:
            for value in ctx.arg_types[0]:
                for name in classes_of(get_proper_type(value)):
                    self.write(ctx, f"{name}.{DYNAMIC[fullname]}")
            return ctx.default_return_type

        return unchanged


def plugin(version: str) -> type[Plugin]:
    return Reads
