"""How many mutated Programs the lemma book finds: one node of an emitted kernel or function, or of the source of the sampled
statements, changed, and the lemmas that read it run again.

    python benchmarks/lemma_mutants.py [COUNT]

A mutant counts when it changes an output at some of many inputs by more than rounding; it is found when a lemma about that kernel
or function is no longer proved, be it that the proof takes longer than PATIENCE. Deterministic. The mutants that are missed are
listed.
"""

from __future__ import annotations

import ast
import contextlib
import inspect
import math
import os
import random
import resource
import signal
import sys
import warnings
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import partial
from typing import Any

import numpy as np

from stt_codegen.lemmas import examples, functions, kernels, refined, sampled_evaluated, transform
from stt_codegen.lemmas.lemma import Verdict
from stt_codegen.program import (
    REAL,
    Assign,
    Call,
    Const,
    Expression,
    For,
    Function,
    Kernel,
    Load,
    Op,
    Operand,
    Program,
    Return,
    Select,
    Statement,
    Store,
    Trunc,
    Var,
)
from stt_codegen.program.lower import lower
from stt_codegen.program.paths import follow
from stt_codegen.program.print.python import PythonPrinter
from stt_codegen.sampling import statements

OTHER = {
    "add": "sub", "sub": "add", "mul": "div", "div": "mul", "lt": "le", "le": "lt", "exp": "tanh", "log": "exp", "log1p": "exp",
    "neg": "fabs", "iadd": "isub", "isub": "iadd", "imul": "iadd", "and": "or", "or": "and",
}  # fmt: skip
MEMORY = 4 << 30  # bytes
PATIENCE = 30  # seconds for the lemmas of a mutant; a formula gone wild is not proved either
SMALL_KERNELS = {
    "basis": refined, "basis_rate": refined, "blend": refined, "normalized_error": transform, "transformed_error": transform,
    "law": transform,
}  # fmt: skip

LEAST_FOUND = 0.98  # of the mutants that change a value, the share that must leave a lemma open


# ---------------------------------------------------------------------------------------------- mutations


def places(body: tuple[Statement, ...], at: tuple[int, ...] = ()) -> Iterator[tuple[int, ...]]:
    """Where a statement with something to change is, as indices into nested bodies."""
    for k, statement in enumerate(body):
        if isinstance(statement, Assign | Store | Call | For):
            yield (*at, k)
        if isinstance(statement, For | Return):
            yield from places(statement.body, (*at, k))


def changed(operand: Operand, known: list[Var], draw: random.Random) -> Operand:
    """Another operand of the same type: a constant that differs, or another variable."""
    if isinstance(operand, Const) and isinstance(operand.value, bool):
        return replace(operand, value=not operand.value)
    if isinstance(operand, Const) and operand.value is not None and not hasattr(operand.value, "name"):
        if operand.type is REAL and operand.value and draw.random() < 0.7:
            return replace(operand, value=operand.value * draw.choice((Fraction(101, 100), 2, Fraction(1, 2))))
        return replace(
            operand,
            value=operand.value + (draw.choice((1, -1, Fraction(1, 8))) if operand.type is REAL else draw.choice((1, -1))),
        )
    others = [v for v in known if v.type is operand.type and v != operand]
    return draw.choice(others) if others else operand


def mutated(value: Expression, known: list[Var], draw: random.Random) -> Expression:
    kind = draw.choice(("operation", "order", "operand"))
    if isinstance(value, Op):
        if kind == "operation" and value.name in OTHER:
            return Op(OTHER[value.name], value.args)
        if kind == "order" and value.name in ("sub", "div", "lt", "le", "isub", "ilt", "tlt"):
            return Op(value.name, value.args[::-1])
        k = draw.randrange(len(value.args))
        return Op(value.name, (*value.args[:k], changed(value.args[k], known, draw), *value.args[k + 1 :]))
    if isinstance(value, Select):
        if kind == "order":
            return Select(value.condition, value.other, value.then)
        if kind == "operand":
            return replace(value, then=changed(value.then, known, draw))
        return replace(value, condition=changed(value.condition, known, draw))
    if isinstance(value, Load):
        return replace(value, index=changed(value.index, known, draw))
    if isinstance(value, Trunc):
        return replace(value, arg=changed(value.arg, known, draw))
    return changed(value, known, draw) if isinstance(value, Var | Const) else value


def rewritten(body: tuple[Statement, ...], at: tuple[int, ...], known: list[Var], draw: random.Random) -> tuple[Statement, ...]:
    """The body with the statement at a place mutated; `known`: what may be read there."""
    k, *rest = at
    for statement in body[:k]:
        known += [statement.var] if isinstance(statement, Assign) else statement.results if isinstance(statement, Call) else []
    statement = body[k]
    new: Statement
    if rest:
        inner = known + ([statement.index, *(c.var for c in statement.carries)] if isinstance(statement, For) else [])
        new = replace(statement, body=rewritten(statement.body, tuple(rest), inner, draw))  # type: ignore[union-attr, arg-type]
    elif isinstance(statement, Assign):
        new = replace(statement, value=mutated(statement.value, known, draw))
    elif isinstance(statement, Store):
        name = draw.choice(("index", "value"))
        new = replace(statement, **{name: changed(getattr(statement, name), known, draw)})
    elif isinstance(statement, Call):
        j = draw.randrange(len(statement.args))
        new = replace(statement, args=(*statement.args[:j], changed(statement.args[j], known, draw), *statement.args[j + 1 :]))
    elif isinstance(statement, For) and statement.carries:
        carry = statement.carries[0]
        new = replace(statement, carries=(replace(carry, initial=changed(carry.initial, known, draw)), *statement.carries[1:]))
    else:
        new = statement
    return (*body[:k], new, *body[k + 1 :])


def mutate(thing: Kernel | Function, draw: random.Random) -> Any:
    at = draw.choice(list(places(thing.body)))
    known = list(thing.inputs) if isinstance(thing, Kernel) else [Var(p.name, p.type) for p in thing.inputs if p.length is None]
    return replace(thing, body=rewritten(thing.body, at, known, draw))


# -------------------------------------------------------------------------------------- what is looked at


@dataclass
class Subject:
    """A kernel or function: what it is, inputs to compare at, and how to run the lemmas with another in its place."""

    name: str
    thing: Kernel | Function
    differs: Callable[[Any, random.Random], bool]
    verdicts: Callable[[Any], list[Verdict]]


def _numbers(values: Any) -> list[float]:
    return [float(v) for v in (values if isinstance(values, tuple) else (values,))]


def _unlike(a: list[float], b: list[float]) -> bool:
    return any(
        not (x == y or (math.isnan(x) and math.isnan(y)) or abs(x - y) <= 1e-9 * (1 + abs(x))) for x, y in zip(a, b, strict=True)
    )


def kernel_differs(before: Kernel) -> Callable[[Any, random.Random], bool]:
    """At the claims' own points, moved a little, and at random ones."""

    def call(kernel: Kernel) -> Callable[..., Any]:
        printer, names = PythonPrinter(Program("p", 1, "double", (), (kernel,), ())), {}
        exec("import math\n" + "\n".join(printer.kernel(kernel)), names)
        function: Callable[..., Any] = names[f"_{kernel.name}"]
        return function

    def differs(after: Kernel, draw: random.Random) -> bool:
        one, other = call(before), call(after)
        claim = kernels.CLAIMS.get(before.name)
        given = [[draw.uniform(0.05, 3.0) for _ in before.inputs] for _ in range(60)]
        for point in claim.points if claim else ():
            given.append([float(point[v.name]) + draw.choice((0.0, 1e-3)) for v in before.inputs])
        for inputs in given:
            try:
                a = _numbers(one(*inputs))
            except (ValueError, ZeroDivisionError, OverflowError):
                continue
            try:
                b = other(*inputs)
                if isinstance(b, complex) or _unlike(a, _numbers(b)):
                    return True
            except (ValueError, ZeroDivisionError, OverflowError, TypeError):
                return True
        return False

    return differs


def function_subject(name: str, case_name: str, function: str, points: list[Any]) -> Subject:
    """A function (or a kernel that belongs to its frame) of an example, through the lemma's own points for what it changes."""
    case = examples.cases()[case_name]
    lemma = next(v for v in functions.LEMMAS if v.name == f"functions.{name}")
    before = [follow(case.program, function, point) for point in points]

    def program_with(thing: Kernel | Function) -> Program:
        if isinstance(thing, Kernel):
            return replace(case.program, kernels=tuple(thing if k.name == thing.name else k for k in case.program.kernels))
        return replace(case.program, functions=tuple(thing if f.name == thing.name else f for f in case.program.functions))

    def differs(after: Any, draw: random.Random) -> bool:
        other = program_with(after)
        for point, a in zip(points, before, strict=True):
            try:
                b = follow(other, function, point)
            except (ValueError, ZeroDivisionError, OverflowError, IndexError, KeyError, TypeError, AttributeError):
                return True
            if a.result is not b.result and not (isinstance(a.result, float) and not _unlike([a.result], [b.result])):
                return True
            for key in a.outputs:
                if any(v is None for v in b.outputs[key]) or _unlike(list(a.outputs[key]), list(b.outputs[key])):
                    return True
        return False

    def verdicts(after: Any) -> list[Verdict]:
        bent = {**examples.cases(), case_name: replace(case, program=program_with(after))}
        functions.cases = lambda: bent  # type: ignore[attr-defined]
        try:
            return [lemma.run().verdict]
        finally:
            functions.cases = examples.cases  # type: ignore[attr-defined]

    return Subject(name, case.program.function(function), differs, verdicts)


# ------------------------------------------------------------------------- the source of the sampled statements

EVALUATED = (
    "input_bound", "sharp_push", "sharp_under", "pull", "q", "q_rate", "_seen", "_seen_reach", "_stale", "_input",
    "_diagonal_staleness", "diagonal", "_general_staleness", "general",
)  # fmt: skip
SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.Pow: ast.Mult,
}  # fmt: skip


def mutate_source(text: str, draw: random.Random) -> str:
    """The text of a function with one operator, number, name or attribute changed."""
    tree = ast.parse(text)
    names = sorted(
        {n.id for n in ast.walk(tree) if isinstance(n, ast.Name)}
        & {"u", "tau", "push", "drift", "narrow", "far", "near", "e", "a", "b", "reach"}
    )
    attributes = [
        ("least", "most"),
        ("narrow", "wide"),
        ("most", "least"),
        ("wide", "narrow"),
        ("shift", "latency"),
        ("latency", "shift"),
        ("cosh", "tanh"),
    ]
    spots: list[Callable[[], None]] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.BinOp) and type(node.op) in SWAPS:
            spots.append(partial(setattr, node, "op", SWAPS[type(node.op)]()))
        elif isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
            spots.append(partial(setattr, node, "value", node.value * 2 + 1))
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load) and node.id in names and len(names) > 1:
            spots.append(partial(setattr, node, "id", draw.choice([v for v in names if v != node.id])))
        elif isinstance(node, ast.Attribute):
            spots += [partial(setattr, node, "attr", after) for before, after in attributes if before == node.attr]
        elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
            spots.append(partial(setattr, node, "op", ast.UAdd()))
    draw.choice(spots)()
    return ast.unparse(tree)


def _evaluated() -> list[float]:
    """Every condition of the three statements, and |u|, at a point."""
    found: list[float] = []
    for name, n, reach in (("sharp", 2, ["E1", "E2"]), ("diagonal", 1, ["E"]), ("general", 2, ["E"])):
        loop = sampled_evaluated.setting(n, coupled=name == "sharp")
        at: Any = (
            np.array([sampled_evaluated._f(v) for v in reach], dtype=object) if name == "sharp" else sampled_evaluated._f("E")
        )
        for condition in statements.STATEMENTS[name].conditions(loop, at, sampled_evaluated._f("tau")):
            found += [float(v) for v in np.asarray(condition.values, dtype=object).ravel()]
    return found


def source_subject(name: str) -> Subject:
    """A function of sampling/statements.py, for the lemmas that run it on symbols."""
    original = getattr(statements, name)
    text, before = inspect.getsource(original), _evaluated()

    @contextlib.contextmanager
    def bent(after: str) -> Iterator[None]:
        exec(compile(after, name, "exec"), statements.__dict__)
        try:
            yield
        finally:
            setattr(statements, name, original)

    def differs(after: Any, _: random.Random) -> bool:
        with bent(after):
            try:
                return _unlike(before, _evaluated())
            except Exception:
                return True

    def verdicts(after: Any) -> list[Verdict]:
        with bent(after):
            return [lemma.run().verdict for lemma in sampled_evaluated.LEMMAS]

    return Subject(f"statements.{name}", text, differs, verdicts)  # type: ignore[arg-type]


def subjects() -> list[Subject]:
    found = [source_subject(name) for name in EVALUATED]
    shipped = kernels.shipped()
    for name, kernel in shipped.items():
        lemma = next(v for v in kernels.LEMMAS if v.name == f"kernels.{name}")

        def alone(after: Kernel, lemma: Any = lemma, name: str = name) -> list[Verdict]:
            kernels.shipped = lambda: {**shipped, name: after}  # type: ignore[attr-defined]
            try:
                return [lemma.run().verdict]
            finally:
                kernels.shipped = lambda: shipped  # type: ignore[attr-defined]

        found.append(Subject(name, kernel, kernel_differs(kernel), alone))
    wide = examples.cases()["wide"].program
    for name, module in SMALL_KERNELS.items():

        def verdicts(after: Kernel, module: Any = module, name: str = name) -> list[Verdict]:
            def bent(function: Any, *rest: Any) -> Kernel:
                kernel = lower(function, *rest)
                return after if kernel.name == name else kernel

            module.lower = bent
            try:
                return [v.run().verdict for v in module.LEMMAS]
            finally:
                module.lower = lower

        found.append(Subject(name, wide.kernel(name), kernel_differs(wide.kernel(name)), verdicts))
    for name, (case, function, points) in functions.SUBJECTS.items():
        subject = function_subject(name, case, function, list(points(examples.cases()[case])))
        found.append(subject)
        for kernel in examples.cases()[case].program.kernels:
            if kernel.name in examples.FOLLOWED and kernel.name != "normalized_error" and name in FRAME_KERNELS[kernel.name]:
                found.append(replace(subject, name=f"{kernel.name} in {name}", thing=kernel))
    return found


FRAME_KERNELS: Mapping[str, tuple[str, ...]] = {
    "segment": ("wide_tube", "narrow_control"),
    "segment_at_tick": ("control_tick",),
    "hold": ("adaptive_tube",),
}


def still_proved(subject: Subject, after: Any) -> bool:
    """Whether every lemma about it is still proved, in a process of its own: a wild formula may take all time or memory."""
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY, MEMORY))
        signal.alarm(PATIENCE)
        os._exit(0 if all(v in (Verdict.PROVED, Verdict.REFUTED) for v in subject.verdicts(after)) else 1)
    return os.waitpid(child, 0)[1] == 0


def main(count: int) -> int:
    warnings.simplefilter("ignore")
    draw = random.Random(1)
    everything = subjects()
    tally: Counter[str] = Counter()
    missed: list[str] = []
    while tally["changed"] < count:
        subject = everything[tally["mutants"] % len(everything)]
        tally["mutants"] += 1
        try:
            after = mutate_source(subject.thing, draw) if isinstance(subject.thing, str) else mutate(subject.thing, draw)
        except TypeError:  # no value of that type to put there
            continue
        if after == subject.thing or not subject.differs(after, draw):
            continue
        tally["changed"] += 1
        if still_proved(subject, after):
            missed.append(f"{subject.name}: {_changes(subject.thing, after)}"[:300])
        else:
            tally["found"] += 1
    print(f"{tally['mutants']} mutants of {len(everything)} subjects, {tally['changed']} change a value, {tally['found']} found")
    for what in missed:
        print(f"  missed: {what}")
    return 1 if tally["found"] < LEAST_FOUND * tally["changed"] else 0


def _changes(before: Any, after: Any) -> list[str]:
    """What stands in a mutant that did not stand in the original."""
    if isinstance(before, str):
        return [line.strip() for line in after.splitlines() if line not in ast.unparse(ast.parse(before)).splitlines()]
    known = {repr(s) for s in _flat(before.body)}
    return [s for s in map(repr, _flat(after.body)) if s not in known]


def _flat(body: tuple[Statement, ...]) -> Iterator[Statement]:
    for statement in body:
        if isinstance(statement, For | Return):
            yield from _flat(statement.body)
        else:
            yield statement


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 200))
