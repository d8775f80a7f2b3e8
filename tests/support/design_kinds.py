"""Finds sources that ask of which kind a design is, for tests/test_designs_protocol.py.

This is a list of what is allowed, because the question "which kind?" can be spelled in too many ways to list them all. Outside of
designs/ a source may look a kind's name up in a table by kind, write it into a text or a document, or compare it with another design's
kind. It may use a class of designs as an annotation, construct it, or pass it to `for_any_design`. A string that equals the name of a
kind or of a class may only be a key of a table.
"""

from __future__ import annotations

import ast
from collections.abc import Callable, Collection, Iterator
from typing import get_args, get_type_hints

from stt_codegen import designs
from stt_codegen.design_kinds import DesignKind
from stt_codegen.task.schema import TubeOptions
from tests.support.controllers import ROOT

PACKAGE = ROOT / "stt_codegen"
KINDS = frozenset(get_args(DesignKind))
CLASSES = {name for name in designs.__all__ if name.endswith("Design")} - {"Design"}
REQUIRE = {  # by name of the function `require_..`: the class that it returns
    name: get_type_hints(getattr(designs, name))["return"]
    for name in designs.__all__
    if name.startswith("require_") and name != "require_design"  # that one accepts all kinds
}
NARROWING = {*REQUIRE, "for_any_design"}
MEMBERS = {
    name
    for design_class in (getattr(designs, name) for name in CLASSES)
    for name in (*vars(design_class), *design_class.__annotations__)
    if not name.startswith("_")
}
# The entries of mypy's record (mypy_reads.py) for a read of a kind's name.
READS_OF_A_KIND = {f"{c.__module__}.{c.__name__}.kind" for c in (getattr(designs, name) for name in ("Design", *CLASSES))} | {
    f"{TubeOptions.__module__}.{TubeOptions.__name__}.design"
}
IsRead = Callable[[ast.Attribute], bool]


def is_called_a_kind(node: ast.Attribute) -> bool:
    """Return whether an attribute's name says that it is a kind: the guess for a source that mypy did not record."""
    return node.attr == "kind" or (node.attr == "design" and ast.unparse(node.value).endswith("tube"))


class Source:
    """A parsed source that knows the parent of every node, and which local names stand for classes of designs.

    defined_tables: names of the tables by kind that the source defines. tables: names of all tables that it may look a kind up in.
    is_read: whether an attribute is a read of a kind's name.
    """

    def __init__(
        self, text: str, defined_tables: Collection[str], tables: Collection[str], is_read: IsRead = is_called_a_kind
    ) -> None:
        self.tree, self.defined_tables, self.tables, self.is_read = ast.parse(text), defined_tables, tables, is_read
        self.nodes = list(ast.walk(self.tree))
        self.parents = {child: node for node in self.nodes for child in ast.iter_child_nodes(node)}
        imports = [alias for node in self.nodes if isinstance(node, ast.ImportFrom) for alias in node.names]
        self.classes = CLASSES | {alias.asname for alias in imports if alias.name in CLASSES and alias.asname}
        annotations = [
            part
            for node in self.nodes
            for part in (getattr(node, "annotation", None), getattr(node, "returns", None))
            if isinstance(part, ast.AST)
        ]
        self.annotations = {node for part in annotations for node in ast.walk(part)}

    def ancestors(self, node: ast.AST) -> Iterator[ast.AST]:
        """Yield the nodes around a node, the nearest first."""
        while node in self.parents:
            node = self.parents[node]
            yield node

    def is_key_of_a_table(self, node: ast.AST) -> bool:
        parent = self.parents.get(node)
        return isinstance(parent, ast.Dict) and node in parent.keys and self.name_of_dict(parent) in self.defined_tables

    def name_of_dict(self, node: ast.Dict) -> str:
        """Return the name that a statement of the module gives to the dictionary; "" where it has none."""
        match self.parents[node]:
            case ast.Assign(targets=[ast.Name(id=name)]) | ast.AnnAssign(target=ast.Name(id=name)):
                return name
        return ""

    def is_docstring(self, node: ast.AST) -> bool:
        return isinstance(self.parents.get(node), ast.Expr)

    def may_stand(self, node: ast.AST) -> bool:
        """Return whether the name of a kind may be read here: looked up, written down, or compared with another kind's name."""
        match self.parents.get(node):
            case ast.Subscript(value=ast.Name(id=table) | ast.Attribute(attr=table), slice=key):
                return key is node and table in self.tables
            case ast.FormattedValue() | ast.keyword():
                return True
            case ast.Dict(values=values):
                return node in values
            case ast.Compare(left=left, comparators=[right], ops=[ast.Eq() | ast.NotEq()]):
                return all(isinstance(side, ast.Attribute) and self.is_read(side) for side in (left, right))
        return False

    def may_name(self, node: ast.AST) -> bool:
        """Return whether a class of designs may be named here."""
        match self.parents.get(node):
            case ast.Call(func=called, args=arguments):
                return called is node or (ast.unparse(called) == "for_any_design" and arguments[0] is node)
            case ast.Subscript(slice=argument):
                return argument is node  # of a generic class
            case ast.Attribute():
                return True  # a method of the class
        return node in self.annotations

    def catches(self, node: ast.AST) -> bool:
        """Return whether an exception that is raised here is caught around it."""
        return any(
            isinstance(a, ast.Try) or (isinstance(a, ast.With) and "suppress" in "".join(ast.unparse(i) for i in a.items))
            for a in self.ancestors(node)
        )

    def questions(self) -> Iterator[tuple[int, str]]:
        """Yield lines at which the source asks of which kind a design is, and how."""
        for node in self.nodes:
            match node:
                case ast.Constant(value=str(name)) if name in KINDS | CLASSES:
                    if not self.is_key_of_a_table(node) and not self.is_docstring(node):
                        yield node.lineno, f'writes "{name}", and not as a key of a table'
                case ast.keyword(arg=str(name), value=value) if name in KINDS:
                    yield value.lineno, f'writes "{name}", and not as a key of a table'
                case ast.Attribute() if self.is_read(node) and not self.may_stand(node):
                    yield node.lineno, "reads the name of a kind, and not for a table or a text"
                case ast.Name(id=name) | ast.Attribute(attr=name) if name in self.classes and not self.may_name(node):
                    yield node.lineno, "asks of its class"
                case ast.Call(func=ast.Name(id="hasattr" | "getattr"), args=[_, ast.Constant(value=name), *_]) if name in MEMBERS:
                    yield node.lineno, "asks what attributes it has"
                case ast.Name(id=name) if name in NARROWING and self.catches(node):
                    yield node.lineno, "asks by an exception"
                case ast.Name(id="singledispatch") | ast.Attribute(attr="singledispatch"):
                    yield node.lineno, "asks of its class"
                case ast.Name(id="singledispatchmethod") | ast.Attribute(attr="singledispatchmethod"):
                    yield node.lineno, "asks of its class"

    def tables_by_kind(self) -> Iterator[tuple[str, set[str]]]:
        """Yield name and kinds of every dictionary with a kind's name among its keys; "" is the name of one without."""
        for node in self.nodes:
            if isinstance(node, ast.Dict):
                keys = {k.value for k in node.keys if isinstance(k, ast.Constant) and isinstance(k.value, str)}
                if keys & KINDS:
                    yield self.name_of_dict(node), keys


def lines_that_list_all_kinds(text: str) -> list[int]:
    """Return the lines at which a source lists all kinds: a tuple, a list, a set or a Literal."""
    listed = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Tuple | ast.List | ast.Set)]
    return [n.lineno for n in listed if {v.value for v in n.elts if isinstance(v, ast.Constant)} >= KINDS]


def lines_that_compare_kinds(text: str) -> list[int]:
    """Return the lines at which a source compares something with the name of a kind."""
    compared = [n for n in ast.walk(ast.parse(text)) if isinstance(n, ast.Compare | ast.MatchValue)]
    return [n.lineno for n in compared if any(isinstance(v, ast.Constant) and v.value in KINDS for v in ast.walk(n))]
