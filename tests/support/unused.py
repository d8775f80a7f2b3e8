"""Finds names that nothing uses, for tests/test_unused.py: members of classes, and names of modules.

A use is a read. A value that is only stored, passed to its class's constructor or copied by `replace` is unused. The records of
mypy_reads.py say of which class a member is read. Where mypy does not know the class of a value, `value.name` counts as a use of all
members of that name; in a source that mypy does not check it counts as none.

A face is a module that only passes on names which it imports; such an import is no use.

Long because Python has many ways to use a name: attributes, patterns, `getattr` with a computed name, `asdict`, faces, decorators.
"""

from __future__ import annotations

import ast
import symtable
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from itertools import chain, pairwise

Reads = dict[tuple[int, int], set[str]]  # line and column -> class.name that mypy sees read at that position
Scope = ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef
PLAIN_BASES = {*"ABC BaseModel Enum Exception Generic NamedTuple Protocol object str".split()}  # they call no method by name
PLAIN_DECORATORS = {*"abc builtins classmethod contextlib dataclasses functools property staticmethod typing".split()}
COPIES = {"replace", "model_copy", "_replace"}
ALL = "*"  # stands for all fields of a class


def is_dunder(name: str) -> bool:
    """Return whether a name is special to Python, like __init__."""
    return name.startswith("__") and name.endswith("__")


def first_argument(node: ast.AST) -> str | None:
    """Return the name of a function's first parameter, which is `self` in a method; None without one."""
    return node.args.args[0].arg if isinstance(node, ast.FunctionDef) and node.args.args else None


def statements(node: ast.AST) -> Iterator[ast.stmt]:
    """Yield all statements inside of a node, at any depth."""
    for inner in ast.iter_child_nodes(node):
        if isinstance(inner, ast.stmt):
            yield inner
        if isinstance(inner, ast.stmt | ast.ExceptHandler | ast.match_case):
            yield from statements(inner)


def names_bound(statement: ast.stmt) -> Iterator[str]:
    """Yield the names that a statement of a module or class defines, except imports."""
    if isinstance(statement, Scope):
        yield statement.name
    elif isinstance(statement, ast.Assign | ast.AnnAssign):
        targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
        yield from (n.id for t in targets for n in ast.walk(t) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store))
    else:
        yield from (n for inner in ast.iter_child_nodes(statement) if isinstance(inner, ast.stmt) for n in names_bound(inner))


def names_read(source: str) -> set[str]:
    """Return the module's names that a statement reads, in any scope inside of the statement."""
    pending, read = [symtable.symtable(source, "statement", "exec")], set()
    while pending:
        table = pending.pop()
        pending += table.get_children()
        is_module_scope = table.get_type() == "module"
        read |= {s.get_name() for s in table.get_symbols() if s.is_referenced() and (is_module_scope or s.is_global())}
    return read


@dataclass
class Class:
    """A class of the sources, with the lines of its members; its full name is written as mypy writes it."""

    fullname: str
    module: Module
    bases: list[str] = field(default_factory=list)
    members: dict[str, int] = field(default_factory=dict)
    fields: list[str] = field(default_factory=list)  # in the order of the constructor
    methods: set[str] = field(default_factory=set)
    annotations: set[str] = field(default_factory=set)  # full names of its fields' types

    @property
    def name(self) -> str:
        return self.fullname.rsplit(".", 1)[-1].split("@")[0]


@dataclass
class Module:
    """A source, what its names stand for, and the members that mypy sees it read (None: mypy does not check it)."""

    name: str
    text: str
    reads: Reads | None = None
    imports: dict[str, str] = field(default_factory=dict)
    definitions: dict[str, int] = field(default_factory=dict)
    is_package: bool = False  # whether it is the __init__.py of a folder

    def imported_from(self, node: ast.ImportFrom) -> str:
        """Return the full name of the module that a statement imports from."""
        steps = self.name.split(".")
        folder = steps[: len(steps) - node.level + self.is_package] if node.level else []
        return ".".join([*folder, *([node.module] if node.module else [])])

    def __post_init__(self) -> None:
        for node in statements(self.tree):
            if isinstance(node, ast.Import):
                for a in node.names:
                    top = a.name.split(".")[0]
                    self.imports[a.asname or top] = a.name if a.asname else top
            elif isinstance(node, ast.ImportFrom):
                self.imports |= {a.asname or a.name: f"{self.imported_from(node)}.{a.name}" for a in node.names}
        for statement in self.tree.body:
            self.definitions |= dict.fromkeys(names_bound(statement), statement.lineno)

    @cached_property
    def tree(self) -> ast.Module:
        return ast.parse(self.text)


class UseCensus:
    """All sources, and the uses that are counted in them. A full name is `package.module.Class.member`."""

    def __init__(self, modules: list[Module]) -> None:
        self.modules = {m.name: m for m in modules}
        self.packages = {name.split(".")[0] for name in self.modules}
        self.classes: dict[str, Class] = {}
        self.class_at: dict[tuple[str, int], str] = {}  # by module and line
        self.read_members: set[tuple[str, str]] = set()  # (class, member) that is read of a value of the class
        self.members_of_unknown_class: set[str] = set()  # members that are read of values whose class mypy does not know
        self.members_of_libraries: set[str] = set()  # members that are read of a library's values
        self.names_of_modules: set[str] = set()  # names that are read of modules which are values
        self.used: set[str] = set()  # full names of functions, classes and constants of modules
        for module in modules:
            self.collect_classes(module, module.tree, module.name)
        for module in modules:
            MemberReads(self, module).visit(module.tree)
            self.collect_names(module)

    def is_face(self, module: Module) -> bool:
        """Return whether a module passes names on, so that its imports are no use."""
        return "__all__" in module.definitions or any(name.startswith(f"{module.name}.") for name in self.modules)

    def resolve(self, fullname: str) -> str:
        """Return the full name under which a name is defined, where the given one goes through faces."""
        for _ in range(10):
            face, _, last = fullname.rpartition(".")
            if face in self.modules and last in self.modules[face].imports:  # before a module of that name
                fullname = self.modules[face].imports[last]
                continue
            module = fullname
            while module not in self.modules and "." in module:
                module = module.rpartition(".")[0]
            name, _, rest = fullname[len(module) + 1 :].partition(".")
            if module not in self.modules or name not in self.modules[module].imports or name in self.modules[module].definitions:
                break
            fullname = ".".join(filter(None, [self.modules[module].imports[name], rest]))
        return fullname

    def name_in(self, module: Module, node: ast.expr) -> str | None:
        """Return the full name that an expression `a.b.c` stands for, where `a` is imported or defined in the module; else None."""
        match node:
            case ast.Name():
                if node.id in module.definitions:
                    return f"{module.name}.{node.id}"
                return self.resolve(module.imports[node.id]) if node.id in module.imports else None
            case ast.Attribute():
                base = self.name_in(module, node.value)
                return None if base is None else self.resolve(f"{base}.{node.attr}")
            case ast.Subscript() | ast.Call():
                return self.name_in(module, node.value if isinstance(node, ast.Subscript) else node.func)
        return None

    def collect_classes(self, module: Module, tree: ast.AST, prefix: str, is_local: bool = False) -> None:
        """Add the classes that a module defines, inside of functions and classes too."""
        for node in ast.iter_child_nodes(tree):
            if isinstance(node, ast.ClassDef):
                fullname = f"{module.name}.{node.name}@{node.lineno}" if is_local else f"{prefix}.{node.name}"
                self.classes[fullname] = self.class_of(module, node, fullname)
                self.class_at[module.name, node.lineno] = fullname
                self.collect_classes(module, node, fullname)
            elif isinstance(node, ast.stmt):
                self.collect_classes(module, node, prefix, is_local or isinstance(node, Scope))

    def class_of(self, module: Module, node: ast.ClassDef, fullname: str) -> Class:
        """Return the class with the members that its body defines and those that its methods store in their first argument."""
        result = Class(fullname, module)
        for base in node.bases:
            result.bases.append(self.name_in(module, base) or ast.unparse(base))
        for statement in node.body:
            names = [] if isinstance(statement, ast.ClassDef) else [*names_bound(statement)]
            result.members |= dict.fromkeys(names, statement.lineno)
            if isinstance(statement, ast.AnnAssign):
                result.fields += names
                parts = (self.name_in(module, n) for n in ast.walk(statement.annotation) if isinstance(n, ast.Name))
                result.annotations |= {n for n in parts if n}
            if isinstance(statement, ast.FunctionDef):
                if self.is_registered(module, statement):
                    self.read_members.add((fullname, statement.name))
                result.methods.add(statement.name)
                subject = first_argument(statement)
                for inner in ast.walk(statement):
                    match inner:
                        case ast.Attribute(value=ast.Name(id=name), attr=member, ctx=ast.Store()) if name == subject:
                            result.members.setdefault(member, inner.lineno)
        return result

    def is_registered(self, module: Module, node: Scope) -> bool:
        """Return whether a decorator passes the function to a library that will call it."""
        names = [self.name_in(module, d) or ast.unparse(d) for d in node.decorator_list]
        return any(n.split(".")[0] not in PLAIN_DECORATORS and not n.endswith((".setter", ".deleter")) for n in names)

    def values_of(self, module: Module, node: ast.Name) -> Iterator[ast.AST]:
        """Yield the syntax nodes of the value of a constant that a name stands for."""
        owner, _, name = (self.name_in(module, node) or "").rpartition(".")
        for statement in self.modules[owner].tree.body if owner in self.modules else ():
            if isinstance(statement, ast.Assign | ast.AnnAssign) and statement.value and name in names_bound(statement):
                yield from ast.walk(statement.value)

    def collect_names(self, module: Module) -> None:
        """Add uses of names of modules: a name is read in another statement of its module, or imported from it."""
        lines = module.text.splitlines()
        for statement in module.tree.body:
            if isinstance(statement, ast.Import | ast.ImportFrom):
                continue
            bound = set(names_bound(statement))
            if isinstance(statement, Scope) and self.is_registered(module, statement) and not isinstance(statement, ast.ClassDef):
                self.used.add(f"{module.name}.{statement.name}")
            first = min([statement.lineno, *(d.lineno for d in getattr(statement, "decorator_list", []))])
            read = names_read("\n".join(lines[first - 1 : statement.end_lineno])) - bound
            self.used |= {f"{module.name}.{name}" for name in read & module.definitions.keys()}
            if self.is_face(module):
                self.used |= {self.resolve(module.imports[name]) for name in read & module.imports.keys()}
        passed_on = set(module.tree.body) if self.is_face(module) else set()
        for node in statements(module.tree):
            if isinstance(node, ast.ImportFrom) and node not in passed_on:
                for a in node.names:
                    self.use(f"{module.imported_from(node)}.{a.name}")

    def use(self, fullname: str) -> None:
        """Count a use of a name, under the face that it is imported from and under its definition."""
        self.used |= {fullname, self.resolve(fullname)}

    def ancestors(self, fullname: str) -> list[str]:
        """Return the class and all its base classes, the nearest first; those of libraries as the source writes them."""
        bases = self.classes[fullname].bases if fullname in self.classes else []
        return [fullname, *(a for base in bases for a in self.ancestors(base))]

    def has_plain_bases(self, fullname: str) -> bool:
        return all(a in self.classes or a.rsplit(".", 1)[-1] in PLAIN_BASES for a in self.ancestors(fullname))

    @cached_property
    def below(self) -> dict[str, set[str]]:
        """Return, by class, the class itself and all that inherit from it."""
        result: dict[str, set[str]] = defaultdict(set)
        for fullname in self.classes:
            for above in self.ancestors(fullname):
                result[above].add(fullname)
        return result

    def members_of(self, fullname: str) -> set[str]:
        return {n for a in self.ancestors(fullname) if a in self.classes for n in self.classes[a].members}

    def constructor_fields(self, fullname: str) -> list[str]:
        """Return the fields of a class and of its base classes, in the order of the constructor."""
        above = [a for a in self.ancestors(fullname) if a in self.classes]
        return [*dict.fromkeys(chain.from_iterable(self.classes[a].fields for a in reversed(above)))]

    def members_read_together(self) -> set[tuple[str, str]]:
        """Return the members of classes all of whose fields are read at once (`asdict`), and of the classes of those fields."""
        pending, result = {c for c, name in self.read_members if name == ALL}, set()
        visited: set[str] = set()
        while pending := (pending - visited) & self.classes.keys():
            visited |= pending
            classes = [self.classes[c] for c in pending]
            result |= {(c.fullname, n) for c in classes for n in c.members.keys() - c.methods}
            pending = {n for c in classes for n in (*c.annotations, *self.ancestors(c.fullname), *self.below[c.fullname])}
        return result

    def unused_members(self) -> list[tuple[Class, str]]:
        """Return members that are read nowhere, except fields of a NamedTuple, which is unpacked by position."""
        used = self.members_read_together()
        for fullname, name in self.read_members:
            definer = next(
                (a for a in self.ancestors(fullname) if a in self.classes and name in self.classes[a].members), fullname
            )
            used |= {(c, name) for c in (definer, *self.below[fullname])}
            if fullname in self.classes and "typing.Protocol" in self.classes[fullname].bases:
                required = self.classes[fullname].members.keys()
                used |= {(c, name) for c in self.classes if required <= self.members_of(c)}
        return [
            (c, name)
            for c in self.classes.values()
            for name in c.members
            if (c.fullname, name) not in used
            and name not in self.members_of_unknown_class
            and not is_dunder(name)
            and not ("typing.NamedTuple" in c.bases and name in c.fields)
            and (name not in self.members_of_libraries or self.has_plain_bases(c.fullname))
        ]

    def unused_names(self) -> list[tuple[Module, str]]:
        """Return the functions, classes and constants of modules that nothing reads or imports, with their modules."""
        names = ((m, name) for m in self.modules.values() for name in m.definitions if name not in self.names_of_modules)
        return [(m, name) for m, name in names if f"{m.name}.{name}" not in self.used and not is_dunder(name)]


class MemberReads(ast.NodeVisitor):
    """Adds the members that a module reads to the census."""

    def __init__(self, census: UseCensus, module: Module) -> None:
        self.census, self.module = census, module
        self.scopes: list[Scope] = []
        self.keywords: list[tuple[str, str]] = []  # (function, keyword) of the calls around
        self.members_of_unknown_class = set() if module.reads is None else census.members_of_unknown_class

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        self.visit_scope(node)

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        self.visit_scope(node)

    def visit_scope(self, node: Scope) -> None:
        """Visit the decorators outside of the scope, and the rest inside of it."""
        for decorator in node.decorator_list:
            self.visit(decorator)
        self.scopes.append(node)
        for inner in ast.iter_child_nodes(node):
            if inner not in node.decorator_list:
                self.visit(inner)
        self.scopes.pop()

    def recorded_classes(self, node: ast.expr, name: str) -> set[str]:
        """Return the classes of which mypy sees `name` read at the position of the expression."""
        reads = (self.module.reads or {}).get((node.lineno, node.col_offset), ())
        return {n.removesuffix(f".{name}") for n in reads if n.endswith(f".{name}")}

    def visit_Call(self, node: ast.Call) -> None:
        """Remember the keywords around each argument, and record calls that read all fields or a field of a computed name."""
        function = node.func.attr if isinstance(node.func, ast.Attribute) else getattr(node.func, "id", "")
        for inner in (node.func, *node.args):
            self.visit(inner)
        for keyword in node.keywords:
            self.keywords.append((function, keyword.arg or ""))
            self.visit(keyword.value)
            self.keywords.pop()
        self.census.read_members |= {(c, ALL) for c in self.recorded_classes(node, ALL)}
        if function == "getattr":
            self.read_computed_name(node)

    def read_computed_name(self, node: ast.Call) -> None:
        """Record `getattr(x, name)`: the name may be any string in the function, or in the constants that the function uses."""
        classes, name = self.recorded_classes(node, "?") & self.census.classes.keys(), node.args[1]
        function = next((f for f in reversed(self.scopes) if isinstance(f, ast.FunctionDef)), self.module.tree)
        nodes: list[ast.AST] = [name] if isinstance(name, ast.Constant) else [*ast.walk(function)]
        nodes += [v for n in nodes if isinstance(n, ast.Name) for v in self.census.values_of(self.module, n)]
        texts = {n.value for n in nodes if isinstance(n, ast.Constant) and isinstance(n.value, str)}
        is_parameter = isinstance(name, ast.Name) and any(isinstance(n, ast.arg) and n.arg == name.id for n in nodes)
        lists_fields = any(isinstance(n, ast.Attribute) and n.attr in {"model_fields", "model_fields_set"} for n in nodes)
        if isinstance(name, ast.JoinedStr):
            start = name.values[0].value if isinstance(name.values[0], ast.Constant) else ""
            below = chain.from_iterable(self.census.below[c] for c in classes)
            texts |= {m for d in below for m in self.census.members_of(d) if m.startswith(start)}
        if not classes:
            self.members_of_unknown_class |= texts
        self.census.read_members |= {(c, t) for c in classes for t in ([ALL] if is_parameter or lists_fields else texts)}

    def visit_MatchClass(self, node: ast.MatchClass) -> None:
        """Record the members that a class pattern compares or binds; a wildcard reads nothing."""
        fullname = self.census.name_in(self.module, node.cls) or ""
        fields = self.census.constructor_fields(fullname) if fullname in self.census.classes else []
        patterns = [*zip(fields, node.patterns, strict=False), *zip(node.kwd_attrs, node.kwd_patterns, strict=True)]
        is_wildcard = [isinstance(p, ast.MatchAs) and p.name is None and p.pattern is None for _, p in patterns]
        self.census.read_members |= {(fullname, n) for (n, _), wild in zip(patterns, is_wildcard, strict=True) if not wild}
        self.generic_visit(node)

    def visit_Attribute(self, node: ast.Attribute) -> None:
        """Record the read of an attribute, by its class where that is known."""
        self.generic_visit(node)
        if not isinstance(node.ctx, ast.Load):
            return
        classes, base = self.recorded_classes(node, node.attr), self.base_of(node.value)
        if base in self.census.modules:
            self.census.use(f"{base}.{node.attr}")
        elif base in self.census.classes:
            classes = classes or {base}
        elif base is None and not classes:
            self.members_of_unknown_class.add(node.attr)
        for fullname in classes:
            if fullname == "types.ModuleType":
                self.census.names_of_modules.add(node.attr)
            elif fullname not in self.census.classes:
                self.census.members_of_libraries.add(node.attr)
            elif not self.is_read_for_itself(fullname, node.attr):
                self.census.read_members.add((fullname, node.attr))

    def base_of(self, node: ast.expr) -> str | None:
        """Return the module or class that an expression is, or whose `self` it is; None where that is not known."""
        methods = [(c, f) for c, f in pairwise(self.scopes) if isinstance(c, ast.ClassDef) and isinstance(f, ast.FunctionDef)]
        if isinstance(node, ast.Name) and methods and node.id == first_argument(methods[-1][1]):
            return self.census.class_at[self.module.name, methods[-1][0].lineno]
        name = None if isinstance(node, ast.Call | ast.Subscript) else self.census.name_in(self.module, node)
        if name is None or name in self.census.classes or name in self.census.modules:
            return name
        return None if name.split(".")[0] in self.census.packages else name

    def is_read_for_itself(self, fullname: str, name: str) -> bool:
        """Return whether the read is in the definition of what is read, or only fills the same field of a copy."""
        owner, scopes = self.census.classes[fullname].name, [s.name for s in self.scopes]
        return (owner, name) in pairwise(scopes) or any(f in {owner, *COPIES} and k == name for f, k in self.keywords)
