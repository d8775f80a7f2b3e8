"""Count the wrong kernels and functions that the lemma book notices.

    python -m benchmarks lemma_mutants [COUNT]

A mutant has one changed node: in a kernel or function that is emitted, or in the Python source of a function that lemmas run on
symbols (sampling conditions, windows, periods, update curves, constraints, time error). It counts when it changes an output at
some of many inputs by more than rounding. It is noticed when a lemma about the changed code is no longer proved, or is not proved
within TIME_LIMIT. The draws are the same in every run. The command lists the mutants that no lemma notices, and ends with exit
code 1 where fewer than REQUIRED_SHARE are noticed. docs/lemmas.md describes the lemma book.
"""

from __future__ import annotations

import ast
import contextlib
import inspect
import itertools
import math
import os
import random
import resource
import signal
import sys
import textwrap
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, fields, is_dataclass, replace
from fractions import Fraction
from functools import cache, partial
from typing import Any

import numpy as np

import stt_codegen as stt
from stt_codegen import constraints as rows
from stt_codegen.certify import slack
from stt_codegen.certify.adaptive import alpha_curves
from stt_codegen.controller import edge_errors as arithmetic
from stt_codegen.designs import RefinedDesign
from stt_codegen.lemmas.emitted import examples, functions, printed_kernels
from stt_codegen.lemmas.lemma import Lemma, Verdict
from stt_codegen.lemmas.paper import transform, update_cells
from stt_codegen.lemmas.sampling import first_exit, sampled_evaluated, sampled_exact, sampled_windows, worst_path_evaluated
from stt_codegen.lemmas.sets import task_constraints as constraint_lemmas
from stt_codegen.lemmas.tube import spline_edges
from stt_codegen.paper import refined_tube
from stt_codegen.program.analyse import exact_logarithm as enclosed
from stt_codegen.program.convert.from_casadi import lower
from stt_codegen.program.nodes import (
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
from stt_codegen.program.operations import REAL
from stt_codegen.program.symbolic.paths import follow
from stt_codegen.program.targets.python.printer import PythonPrinter
from stt_codegen.sampling import loops, numbers, periods, sampled_loop, sampling_conditions, windows
from stt_codegen.sampling.path import drive_response, integer_logarithm, path_proof, path_windows, worst_path
from stt_codegen.task.sets import convex_sets as sets

OPERATION_SWAPS = {
    "add": "sub", "sub": "add", "mul": "div", "div": "mul", "lt": "le", "le": "lt", "exp": "tanh", "log": "exp", "log1p": "exp",
    "neg": "fabs", "iadd": "isub", "isub": "iadd", "imul": "iadd", "and": "or", "or": "and",
}  # fmt: skip
MEMORY_LIMIT = 4 << 30  # bytes for the lemmas of a mutant
TIME_LIMIT = 30  # seconds for the lemmas of a mutant; a mutant whose formulas grow without end counts as not proved
SMALL_KERNELS = {  # kernels by name, with the module of lemmas that makes them by calling `lower`
    "basis": spline_edges,
    "basis_rate": spline_edges,
    "blend": spline_edges,
    "normalized_error": transform,
    "transformed_error": transform,
    "law": transform,
}

REQUIRED_SHARE = 0.98  # of the mutants that change a value, this share must leave a lemma open


# ---------------------------------------------------------------------------------------------- mutations


def statement_paths(body: tuple[Statement, ...], prefix: tuple[int, ...] = ()) -> Iterator[tuple[int, ...]]:
    """Yield the path of each statement that can be changed: its indices into nested bodies, after those of `prefix`."""
    for k, statement in enumerate(body):
        if isinstance(statement, Assign | Store | Call | For):
            yield (*prefix, k)
        if isinstance(statement, For | Return):
            yield from statement_paths(statement.body, (*prefix, k))


def change_operand(operand: Operand, variables: list[Var], rng: random.Random) -> Operand:
    """Return another operand of the same type: a different constant, or another of the variables."""
    if isinstance(operand, Const) and isinstance(operand.value, bool):
        return replace(operand, value=not operand.value)
    if isinstance(operand, Const) and operand.value is not None and not hasattr(operand.value, "name"):
        if operand.type is REAL and operand.value and rng.random() < 0.7:
            return replace(operand, value=operand.value * rng.choice((Fraction(101, 100), 2, Fraction(1, 2))))
        return replace(
            operand,
            value=operand.value + (rng.choice((1, -1, Fraction(1, 8))) if operand.type is REAL else rng.choice((1, -1))),
        )
    alternatives = [v for v in variables if v.type is operand.type and v != operand]
    return rng.choice(alternatives) if alternatives else operand


def mutate_expression(value: Expression, variables: list[Var], rng: random.Random) -> Expression:
    """Return the expression with another operation, the order of its operands reversed, or another operand."""
    kind = rng.choice(("operation", "order", "operand"))
    if isinstance(value, Op):
        if kind == "operation" and value.name in OPERATION_SWAPS:
            return Op(OPERATION_SWAPS[value.name], value.args)
        if kind == "order" and value.name in ("sub", "div", "lt", "le", "isub", "ilt", "tlt"):
            return Op(value.name, value.args[::-1])
        k = rng.randrange(len(value.args))
        return Op(value.name, (*value.args[:k], change_operand(value.args[k], variables, rng), *value.args[k + 1 :]))
    if isinstance(value, Select):
        if kind == "order":
            return Select(value.condition, value.otherwise, value.then)
        if kind == "operand":
            return replace(value, then=change_operand(value.then, variables, rng))
        return replace(value, condition=change_operand(value.condition, variables, rng))
    if isinstance(value, Load):
        return replace(value, index=change_operand(value.index, variables, rng))
    if isinstance(value, Trunc):
        return replace(value, arg=change_operand(value.arg, variables, rng))
    return change_operand(value, variables, rng) if isinstance(value, Var | Const) else value


def mutate_statement(
    body: tuple[Statement, ...], path: tuple[int, ...], variables: list[Var], rng: random.Random
) -> tuple[Statement, ...]:
    """Return the body with the statement at `path` changed. variables: those that the first statement of the body may read."""
    k, *rest = path
    for statement in body[:k]:
        variables += (
            [statement.var] if isinstance(statement, Assign) else statement.results if isinstance(statement, Call) else []
        )
    statement = body[k]
    new: Statement
    if rest:
        inner = variables + ([statement.index, *(c.var for c in statement.carries)] if isinstance(statement, For) else [])
        new = replace(statement, body=mutate_statement(statement.body, tuple(rest), inner, rng))  # type: ignore[union-attr, arg-type]
    elif isinstance(statement, Assign):
        new = replace(statement, value=mutate_expression(statement.value, variables, rng))
    elif isinstance(statement, Store):
        name = rng.choice(("index", "value"))
        new = replace(statement, **{name: change_operand(getattr(statement, name), variables, rng)})
    elif isinstance(statement, Call):
        j = rng.randrange(len(statement.args))
        new = replace(
            statement, args=(*statement.args[:j], change_operand(statement.args[j], variables, rng), *statement.args[j + 1 :])
        )
    elif isinstance(statement, For) and statement.carries:
        carry = statement.carries[0]
        new = replace(
            statement, carries=(replace(carry, initial=change_operand(carry.initial, variables, rng)), *statement.carries[1:])
        )
    else:
        new = statement
    return (*body[:k], new, *body[k + 1 :])


def mutate_code(code: Kernel | Function, rng: random.Random) -> Any:
    """Return the kernel or function with one node changed."""
    path = rng.choice(list(statement_paths(code.body)))
    variables = list(code.inputs) if isinstance(code, Kernel) else [Var(p.name, p.type) for p in code.inputs if p.length is None]
    return replace(code, body=mutate_statement(code.body, path, variables, rng))


# ----------------------------------------------------------------------------------------- emitted kernels and functions


@dataclass
class Subject:
    """Code that lemmas are about.

    code: a kernel, a function, or the text of a Python function. changes_a_value: tells whether a mutant gives another output
    somewhere. verdicts: runs the lemmas with a mutant in place of the code.
    """

    name: str
    code: Kernel | Function
    changes_a_value: Callable[[Any, random.Random], bool]
    verdicts: Callable[[Any], Iterable[Verdict]]


def _as_floats(values: Any) -> list[float]:
    return [float(v) for v in (values if isinstance(values, tuple) else (values,))]


def _are_unlike(a: list[float], b: list[float]) -> bool:
    return any(
        not (x == y or (math.isnan(x) and math.isnan(y)) or abs(x - y) <= 1e-9 * (1 + abs(x))) for x, y in zip(a, b, strict=True)
    )


def kernel_comparison(original: Kernel) -> Callable[[Any, random.Random], bool]:
    """Return `changes_a_value` of a kernel: it compares near the points of the kernel's lemma, and at random ones."""

    def runnable(kernel: Kernel) -> Callable[..., Any]:
        printer, names = PythonPrinter(Program("p", 1, "double", (), (kernel,), functions=())), {}
        exec("import math\n" + "\n".join(printer.kernel(kernel)), names)
        function: Callable[..., Any] = names[f"_{kernel.name}"]
        return function

    def changes_a_value(mutant: Kernel, rng: random.Random) -> bool:
        """Return whether the mutant gives other values, or an error, where the original gives values."""
        run_original, run_mutant = runnable(original), runnable(mutant)
        claim = printed_kernels.CLAIMS.get(original.name)
        points = [[rng.uniform(0.05, 3.0) for _ in original.inputs] for _ in range(60)]
        for point in claim.points if claim else ():
            points.append([float(point[v.name]) + rng.choice((0.0, 1e-3)) for v in original.inputs])
        for inputs in points:
            try:
                original_values = _as_floats(run_original(*inputs))
            except (ValueError, ZeroDivisionError, OverflowError):
                continue
            try:
                mutant_values = run_mutant(*inputs)
                if isinstance(mutant_values, complex) or _are_unlike(original_values, _as_floats(mutant_values)):
                    return True
            except (ValueError, ZeroDivisionError, OverflowError, TypeError):
                return True
        return False

    return changes_a_value


def function_subject(name: str, case_name: str, function: str, points: list[Any]) -> Subject:
    """Return the subject of an emitted function; its mutants may also change a kernel that the function calls.

    name: of the lemma, after "functions.". case_name: the example whose program has the function. points: the lemma's inputs,
    at which mutants are compared.
    """
    case = examples.cases()[case_name]
    lemma = next(v for v in functions.LEMMAS if v.name == f"functions.{name}")
    original_results = [follow(case.program, function, point) for point in points]

    def program_with(code: Kernel | Function) -> Program:
        if isinstance(code, Kernel):
            return replace(case.program, kernels=tuple(code if k.name == code.name else k for k in case.program.kernels))
        return replace(case.program, functions=tuple(code if f.name == code.name else f for f in case.program.functions))

    def changes_a_value(mutant: Any, _: random.Random) -> bool:
        """Return whether the function's result or outputs differ at one of the points, or cannot be computed there."""
        mutated_program = program_with(mutant)
        for point, a in zip(points, original_results, strict=True):
            try:
                b = follow(mutated_program, function, point)
            except (ValueError, ZeroDivisionError, OverflowError, IndexError, KeyError, TypeError, AttributeError):
                return True
            if a.result is not b.result and not (isinstance(a.result, float) and not _are_unlike([a.result], [b.result])):
                return True
            for key in a.outputs:
                if any(v is None for v in b.outputs[key]) or _are_unlike(list(a.outputs[key]), list(b.outputs[key])):
                    return True
        return False

    def verdicts(mutant: Any) -> list[Verdict]:
        mutated_cases = {**examples.cases(), case_name: replace(case, program=program_with(mutant))}
        functions.cases = lambda: mutated_cases  # type: ignore[attr-defined]
        try:
            return [lemma.run().verdict]
        finally:
            functions.cases = examples.cases  # type: ignore[attr-defined]

    return Subject(name, case.program.function(function), changes_a_value, verdicts)


# --------------------------------------------------------------------------------- Python functions that lemmas run

SYNTAX_SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.Pow: ast.Mult,
    ast.LtE: ast.GtE, ast.GtE: ast.LtE, ast.FloorDiv: ast.Div, ast.And: ast.Or, ast.Or: ast.And, ast.Eq: ast.NotEq,
}  # fmt: skip
NAME_SWAPS = {
    "least": "most", "most": "least", "diagonal_min": "diagonal_max", "diagonal_max": "diagonal_min", "narrow": "wide",
    "wide": "narrow", "shift": "latency", "latency": "shift", "cosh": "tanh",
    "min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "argmin": "argmax", "floor": "ceil", "ceil": "floor",
    "LOWER": "UPPER", "UPPER": "LOWER", "lower": "upper", "upper": "lower", "narrow_seen": "narrow", "f_max": "w_max",
    "keep": "bound", "size": "per", "reach": "speed_factor", "share": "decay", "initial_state": "start", "gain": "e_max",
}  # fmt: skip


def mutate_source(text: str, rng: random.Random) -> str:
    """Return the text of a function with one operator, number, name or attribute changed."""
    tree = ast.parse(text)
    function = next(n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef))
    assigned = {n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    local = sorted(assigned | {a.arg for a in function.args.args} - {"self", "cls", "loop"})
    changes: list[Callable[[], None]] = []
    for statement in function.body:
        for node in ast.walk(statement):
            if isinstance(node, ast.BinOp | ast.BoolOp) and type(node.op) in SYNTAX_SWAPS:
                changes.append(partial(setattr, node, "op", SYNTAX_SWAPS[type(node.op)]()))
            elif isinstance(node, ast.Compare) and type(node.ops[0]) in SYNTAX_SWAPS:
                changes.append(partial(setattr, node, "ops", [SYNTAX_SWAPS[type(node.ops[0])](), *node.ops[1:]]))
            elif isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
                changes.append(partial(setattr, node, "value", node.value * 2 + 1))
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                if node.id in NAME_SWAPS and node.id not in local:
                    changes.append(partial(setattr, node, "id", NAME_SWAPS[node.id]))
                elif node.id in local and len(local) > 1:
                    changes.append(partial(setattr, node, "id", rng.choice([v for v in local if v != node.id])))
            elif isinstance(node, ast.Attribute) and node.attr in NAME_SWAPS:
                changes.append(partial(setattr, node, "attr", NAME_SWAPS[node.attr]))
            elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
                changes.append(partial(setattr, node, "op", ast.UAdd()))
            elif isinstance(node, ast.IfExp):
                changes.append(partial(_exchange_branches, node))
    if changes:
        rng.choice(changes)()
    return ast.unparse(tree)


def _exchange_branches(node: ast.IfExp) -> None:
    node.body, node.orelse = node.orelse, node.body


def underlying_function(attribute: Any) -> Any:
    """Return the function behind a property, a class method or a cache."""
    for name in ("fget", "__func__", "func", "__wrapped__"):
        attribute = getattr(attribute, name, attribute)
    return attribute


def code_subject(name: str, owner: Any, attribute: str, probe: Callable[[], list[float]], lemmas: Sequence[Lemma]) -> Subject:
    """Return the subject of a Python function or method, whose code is exchanged in place, wherever it was imported.

    owner: the module or class that has it. attribute: its name there. probe: computes values that the function influences.
    """
    function = underlying_function(vars(owner)[attribute])
    text, original_values = textwrap.dedent(inspect.getsource(function)), probe()

    @contextlib.contextmanager
    def substituted(mutant: str) -> Iterator[None]:
        """Run the block with the mutant's code in the function."""
        names: dict[str, Any] = {}
        exec(compile("from __future__ import annotations\n" + mutant, name, "exec"), function.__globals__, names)
        original_code, function.__code__ = function.__code__, underlying_function(names[attribute]).__code__
        try:
            yield
        finally:
            function.__code__ = original_code

    def changes_a_value(mutant: Any, _: random.Random) -> bool:
        try:
            with substituted(mutant):
                return _are_unlike(original_values, probe())
        except Exception:
            return False  # a mutant that cannot be run is not counted

    def verdicts(mutant: Any) -> Iterator[Verdict]:
        with substituted(mutant):
            for lemma in lemmas:
                yield lemma.run().verdict

    return Subject(name, text, changes_a_value, verdicts)  # type: ignore[arg-type]


def _condition_values() -> list[float]:
    """Return the values of all sampling conditions of the three forms at a point."""
    values: list[float] = []
    for name, n, symbols in (("sharp", 2, ["E1", "E2"]), ("diagonal", 1, ["E"]), ("general", 2, ["E"])):
        loop = sampled_evaluated.setting(n, coupled=name == "sharp")
        errors: Any = (
            np.array([sampled_evaluated.symbol(v) for v in symbols], dtype=object)
            if name == "sharp"
            else sampled_evaluated.symbol("E")
        )
        for condition in sampling_conditions.SAMPLING_CONDITIONS[name].conditions(loop, errors, sampled_evaluated.symbol("tau")):
            values += [float(v) for v in np.asarray(condition.values, dtype=object).ravel()]
    return values


def _numbers_of(values: Any) -> list[float]:
    """Return the numbers in nested arrays, tuples and dataclasses, in their order."""
    if values is None or isinstance(values, str | numbers.Doubles | numbers.Fractions):
        return []
    if isinstance(values, np.ndarray):
        return _numbers_of(values.ravel().tolist())
    if isinstance(values, list | tuple):
        return [v for part in values for v in _numbers_of(part)] + [float(len(values))]
    if is_dataclass(values):
        return [v for field in fields(values) for v in _numbers_of(getattr(values, field.name))]
    return [float(values)]


SAMPLE_TASK = """
name = "probe"
prescribed_time = 3.0
initial_state = [0.2, 0.3]
body = [0.1, 0.05]
[state_space]
lower = [-1.0, -1.0]
upper = [5.0, 4.0]
[initial_set]
lower = [-0.3, -0.25]
upper = [0.75, 0.75]
[target_set]
lower = [3.5, 2.5]
upper = [4.5, 3.5]
[[unsafe]]
lower = [1.5, 1.0]
upper = [2.5, 1.75]
[[unsafe]]
lower = [0.5, 2.5]
upper = [1.0, 3.5]
[tube]
clearance = 0.03
max_speed = 9.0
segments = 16
[control]
period = 0.001
latency = 0.0002
u_max = [30.0, 40.0]
gain = [0.25, 0.5]
[plant]
f_max = 0.1
w_max = 0.05
g_min = 0.75
g_max = 1.25
g_cross = 0.01
noise = 0.001
"""


@cache
def _sample_task() -> tuple[Any, Any, tuple[Fraction, ...]]:
    """Return a task that uses every option of the sampling conditions, its tube, and error bands of the edges, (n,)."""
    task = stt.parse(SAMPLE_TASK)
    return task, stt.design(task), (Fraction(1, 1 << 18), Fraction(1, 1 << 17))


def _window_values() -> list[float]:
    table: Any = sampled_windows.BezierTube(np.arange(48.0).reshape(3, 2, 2, 4) * 7 % 11, Fraction(7, 3), Fraction(1, 8))
    refined = windows.refined_windows(table)
    return _numbers_of([windows.extremes(table), refined, refined.shortest])


def _loop_values() -> list[float]:
    task, tube, error = _sample_task()
    loop = loops.loop_of(task, tube, error)
    by_window = np.array([[3.0, 1.0], [2.0, 5.0], [4.0, 4.5]])
    worst = [
        sampled_loop.worst_with_previous_window(by_window, np.maximum),
        sampled_loop.worst_with_previous_window(by_window, np.minimum),
    ]
    return _numbers_of([loop, loop.longest_age, loop.with_law(latency=0.0).longest_age, *worst])


def _period_values() -> list[float]:
    """Return bounds on the input, sharp conditions and logarithms at several rho (numbers that bound the errors) and periods."""
    task, tube, error = _sample_task()
    loop, age = loops.exact_loop(task, tube, error), Fraction("0.0012")
    values: list[Any] = []
    for rho in ((25, 30), (21, 40), (18, 30), (1e4, 30), (60, 25)):
        e = tuple(map(Fraction, rho))
        values += [periods.inputs_where_proved(loop, e, age * k) for k in (1, 20, 1000)]
    for k, rho in itertools.product(range(4), ((3, 5), (25, 30), (2, 10**5))):
        e = np.array([Fraction(v) for v in rho], dtype=object)
        unlimited, shifted = loop.with_law(u_max=np.full(2, np.inf)), loop.with_law(shift=np.array([Fraction(2)] * 2))
        values += [sampling_conditions.input_bound(v.window(k), e) for v in (loop, unlimited, shifted)]
        for u in (values[-3], values[-3] * 20):
            conditions = sampling_conditions.sharp_under(loop.window(k), e, age, u, loop.closing_speed[k])
            values.append(sampling_conditions.first_failing(conditions) or 0)
    logarithms = [enclosed.logarithm(Fraction(v)) for v in (1.5, 1.001, 77, 1e6)]
    return _numbers_of([values, logarithms, loop.longest_age, loop.law.shift, loop.law.eps_at_clamp, loop.start])


def _path_values() -> list[float]:
    """Return worst paths, what drives make of falling commands, bounds over windows, and proofs of loops."""
    cases, starts = worst_path_evaluated.CASES, worst_path_evaluated.STARTS
    values: list[Any] = [integer_logarithm.log_bounds(p, q) for p, q in ((3, 2), (1, 5), (181, 128), (7, 7))]
    values += [worst_path.follow_worst_path(bounds, start) for _, bounds in cases for start in starts[::2]]
    values += [worst_path.follow_worst_path(worst_path_evaluated.AT_REST, starts[3])]
    for drive in worst_path_evaluated.DRIVES:
        cells, command = drive_response.DriveCells(drive, 1 << 41, Fraction(1, 1 << 40), Fraction(1, 500)), 1 << 41
        for _ in range(40):
            values += [cells.acting(command) / 2**40, cells.is_steady(command)]
            cells.step(command)
            command -= 1 << 36
        values += [drive.delay(Fraction(3)), drive.amplification, drive.scaled(Fraction(2))]
    loop, changing = (
        worst_path_evaluated.loop_of_drive(worst_path_evaluated.DRIVES[4], Fraction(1, 50)),
        worst_path_evaluated.changing_loop(),
    )
    values += [loop.bounds_over(0, 1, 4, (Fraction(2), Fraction(3))), loop.start(1), loop.component(1)]
    values += [loop.window_at(Fraction(2))]
    values += [loop.with_period(Fraction(1, 5)), loop.input_bound(0, Fraction(90)), loop.input_bound(0, Fraction(900))]
    values += [path_proof.prove_path(v) for v in (loop, changing)]
    return _numbers_of(values)


def _curve_values() -> list[float]:
    """Return alpha's enclosing curves of an adaptive tube, and what they are computed from."""
    times = [0.25 * k for k in range(13)]
    steps = alpha_curves.Steps(Fraction(1, 100), Fraction(1, 20), 1e-5, 2.0**-24)
    values: list[Any] = [steps.minimum, steps.reach]
    for psi, theta in (([0.3, 0.1, 0.05, 0.2, 0.5, 0.9] * 2, [0.02, 0.2, 0.4, 0.1, 0.01, 1e-5] * 2), ([0.4] * 12, [0.05] * 12)):
        for curve in (alpha_curves.upper_curve, alpha_curves.lower_curve):
            values.append(curve(times, [*psi, 0.3], [*theta, 0.1], 5.0, steps))
        values += [alpha_curves.extremes_ahead(np.array(times), np.array(psi), 0.3, largest) for largest in (True, False)]
    values.append(alpha_curves.upper_curve(times, [0.1] * 13, [0.1] * 13, 1e-9, steps))
    for side in (1, -1):
        one_sided = alpha_curves.Curve(side, 1e-5, 5.0, 1.001, 0.1)
        values += [one_sided.root(p, q) for p in (-2.0, 0.0, 0.5) for q in (0.0, 1e-61, 1e-3, 2.0)]
        values += [one_sided.beyond(z, 0.5, 2.0) for z in (1e-3, 1.2, 1.45, 9.0)]
        values += [one_sided.balance(0.5, v) for v in (1e-9, 3.0)]
    return _numbers_of(values)


def _constraint_values() -> list[float]:
    """Return the numbers in all constraints of the sample task, and in its unsafe sets."""
    task = stt.parse(SAMPLE_TASK)  # not the cached task: its sets cache their faces
    rows._lowest_value_terms.cache_clear()
    simple_constraints = [
        rows.width_constraints(task),
        rows.initial_state_constraints(task),
        rows.start_constraints(task),
        rows.stay_constraints(task),
        rows.reach_constraints(task),
    ]
    all_constraints = [
        row
        for part in (*simple_constraints, rows.speed_constraints(task), *(a.alternatives for a in rows.avoidances(task)))
        for row in part
    ]
    properties = [
        (row.size, row.bound_from((Fraction(1), Fraction(3))), row.distance_error, row.dimension) for row in all_constraints
    ]
    faces = [
        [s.faces, s.support((2, -3)), s.grown((Fraction(1), Fraction(2))).faces, s.vertices, s.span(0)] for s in task.obstacles
    ]
    faces += [sets.GrownSet(s, (Fraction(1), Fraction(2))).support((2, -3)) for s in task.obstacles]
    lows = [sets.minimum_over_box(n, (Fraction(1), Fraction(2)), (Fraction(5), Fraction(7))) for n in ((1, 2), (-1, 3), (0, -2))]
    return _numbers_of([all_constraints, properties, faces, lows, len(rows.avoidances(task))])


def _slack_values() -> list[float]:
    """Return the slacks of several blocks of constraints for a random table of control points."""
    rng = random.Random(7)
    bezier = np.array([[[[rng.randint(-60, 60) for _ in range(4)] for _ in range(2)] for _ in range(2)] for _ in range(4)])
    bounds = [rows.Constraint(((0, 0, 1),), Fraction(-70)), rows.Constraint(((1, 1, -1),), Fraction(-211, 3))]
    slanted = [
        rows.Constraint(((0, 0, 2), (1, 1, -3)), Fraction(7, 3), Fraction(1), 5),
        rows.Constraint(((1, 0, 1), (1, 1, 1)), Fraction(-99)),
    ]
    avoidances = [rows.Avoidance("a", tuple(slanted)), rows.Avoidance("b", (bounds[0], slanted[0]))]
    unit = Fraction(1, 2)
    blocks = [
        slack.ConstraintBlock.of(bounds, unit),
        slack.ConstraintBlock.of([*bounds, *slanted], unit),
        slack.ConstraintBlock.choice(avoidances, unit),
    ]
    values: list[Any] = [slack.halves(bezier.astype(object) * Fraction(1)), slack.units_above(Fraction(7, 3), unit)]
    for block in blocks:
        slacks = block.slack_by_constraint(bezier)
        values += [slacks, block.slack_of_block(slacks), block.slack(bezier)]
        values += [
            [w.slack, w.constraint, w.set_index]
            for w in (slack.smallest_slack(bezier, block, Fraction(v)) for v in (0, 5, 40, -90))
        ]
    return _numbers_of(values)


def _time_error_values() -> list[float]:
    _, tube, _ = _sample_task()
    return [float(arithmetic.spline_time_error(tube, scalar) * 1e9) for scalar in ("float", "double")]


# Functions that lemmas run: the module or class that has them, their names, values that they influence, modules of the lemmas.
LEMMA_CODE: tuple[tuple[Any, str, Callable[[], list[float]], tuple[Any, ...]], ...] = (
    (sampling_conditions, "input_bound emitted_input sharp_closing_speed sharp_under drift_of_sample "
     "distances_at_sample weakest_effect input_per_gain q q_rate measured_distances "
     "_measured_eps_bound _diagonal_staleness diagonal _general_staleness general", _condition_values, (sampled_evaluated,)),
    (sampling_conditions.Staleness, "input_bound input_change", _condition_values, (sampled_evaluated,)),
    (windows, "extremes refined_windows", _window_values, (sampled_windows,)),
    (RefinedDesign, "largest_steps", _window_values, (sampled_windows,)),
    (windows.Windows, "shortest", _window_values, (first_exit,)),
    (sampled_loop, "law_of first_order_loop worst_with_previous_window", _loop_values, (first_exit, sampled_windows)),
    (sampled_loop.SampledLoop, "longest_age", _loop_values, (first_exit,)),
    (enclosed, "logarithm _artanh", _period_values, (sampled_exact, sampled_windows)),
    (periods, "inputs_where_proved is_in_range", _period_values, (sampled_exact,)),
    (numbers.Fractions, "eps_of_share far_divisor near_divisor share_of_eps log_below log_above lesser evenly", _period_values,
     (sampled_exact, sampled_windows)),
    (integer_logarithm, "twice_artanh log_bounds", _path_values, (worst_path_evaluated,)),
    (drive_response, "decay_above", _path_values, (worst_path_evaluated,)),
    (drive_response.Drive, "opposite_weight amplification delay scaled", _path_values, (worst_path_evaluated,)),
    (drive_response.DriveCells, "__init__ acting is_steady step", _path_values, (worst_path_evaluated,)),
    (worst_path, "power_below follow_worst_path", _path_values, (worst_path_evaluated,)),
    (worst_path.PathBounds, "cell covers", _path_values, (worst_path_evaluated,)),
    (worst_path._Law, "__init__ _clamped command", _path_values, (worst_path_evaluated,)),
    (worst_path._Fall, "of at_edge at through_cell", _path_values, (worst_path_evaluated,)),
    (worst_path._Path, "__init__ follow _command _history", _path_values, (worst_path_evaluated,)),
    (path_windows.ComponentLaw, "input_bound", _path_values, (worst_path_evaluated,)),
    (path_windows.PathLoop, "component with_period start bounds_over input_bound window_at", _path_values,
     (worst_path_evaluated,)),
    (path_proof, "prove_path prove_path_for _search _follow _is_enough follow_from_start follow_local_paths _uncovered_paths "
     "_together", _path_values, (worst_path_evaluated,)),
    (alpha_curves, "curve_values extremes_ahead", _curve_values, (update_cells,)),
    (alpha_curves.Curve, "of outer cell balance root beyond", _curve_values, (update_cells,)),
    (alpha_curves.Steps, "reach minimum", _curve_values, (update_cells,)),
    (rows, "width_constraints initial_state_constraints start_constraints stay_constraints reach_constraints avoidances "
     "speed_constraints box_constraints _interval_constraints separation_constraints _lowest_value_terms", _constraint_values,
     (constraint_lemmas,)),
    (rows.Constraint, "size bound_from distance_error dimension", _constraint_values, (constraint_lemmas,)),
    (sets, "minimum_over_box", _constraint_values, (constraint_lemmas,)),
    (sets.BoxSet, "support faces grown", _constraint_values, (constraint_lemmas,)),
    (sets.GrownSet, "support", _constraint_values, (constraint_lemmas,)),
    (slack, "smallest_slack _halve halves units_above", _slack_values, (spline_edges, constraint_lemmas)),
    (slack.ConstraintBlock, "choice _build single slack slack_by_constraint slack_of_block _smallest_left_side set_of",
     _slack_values, (constraint_lemmas,)),
    (arithmetic, "rounded_time_error spline_time_error", _time_error_values, (spline_edges,)),
)  # fmt: skip


def source_subjects() -> list[Subject]:
    """Return a subject for each function and method of LEMMA_CODE."""
    subjects = []
    for owner, names, probe, modules in LEMMA_CODE:
        lemmas = [v for module in modules for v in module.LEMMAS]
        owner_name = owner.__name__.rsplit(".", 1)[-1]
        subjects += [code_subject(f"{owner_name}.{name}", owner, name, probe, lemmas) for name in names.split()]
    return subjects


# ------------------------------------------------------------------------------------------------ all subjects


def shipped_kernel_subjects() -> list[Subject]:
    """Return a subject for each kernel that is shipped; its lemma has the kernel's name."""
    shipped = printed_kernels.shipped()
    subjects = []
    for name, kernel in shipped.items():
        lemma = next(v for v in printed_kernels.LEMMAS if v.name == f"kernels.{name}")

        def verdicts(mutant: Kernel, lemma: Any = lemma, name: str = name) -> list[Verdict]:
            printed_kernels.shipped = lambda: {**shipped, name: mutant}  # type: ignore[attr-defined]
            try:
                return [lemma.run().verdict]
            finally:
                printed_kernels.shipped = lambda: shipped  # type: ignore[attr-defined]

        subjects.append(Subject(name, kernel, kernel_comparison(kernel), verdicts))
    return subjects


def small_kernel_subjects() -> list[Subject]:
    """Return a subject for each of SMALL_KERNELS; all lemmas of its module run with the mutant."""
    kernels = {k.name: k for k in (*examples.cases()["limited"].program.kernels, lower(refined_tube.blend()))}
    subjects = []
    for name, module in SMALL_KERNELS.items():

        def verdicts(mutant: Kernel, module: Any = module, name: str = name) -> list[Verdict]:
            def lower_with_mutant(function: Any, *rest: Any) -> Kernel:
                kernel = lower(function, *rest)
                return mutant if kernel.name == name else kernel

            module.lower = lower_with_mutant
            try:
                return [v.run().verdict for v in module.LEMMAS]
            finally:
                module.lower = lower

        subjects.append(Subject(name, kernels[name], kernel_comparison(kernels[name]), verdicts))
    return subjects


def emitted_function_subjects() -> list[Subject]:
    """Return a subject for each emitted function that has a lemma, and for each kernel that such a function calls."""
    subjects = []
    for name, (case, function, points) in functions.SUBJECTS.items():
        subject = function_subject(name, case, function, list(points(examples.cases()[case])))
        subjects.append(subject)
        for kernel in examples.cases()[case].program.kernels:
            if (
                kernel.name in examples.FOLLOWED
                and kernel.name != "normalized_error"
                and name in FUNCTIONS_WITH_KERNEL[kernel.name]
            ):
                subjects.append(replace(subject, name=f"{kernel.name} in {name}", code=kernel))
    return subjects


FUNCTIONS_WITH_KERNEL: Mapping[str, tuple[str, ...]] = {
    "segment": ("tube", "control"),
    "edge_at": ("tube", "margin"),
    "segment_at_tick": ("control_tick",),
    "hold": ("adaptive_tube",),
}


def is_still_proved(subject: Subject, mutant: Any) -> bool:
    """Return whether all lemmas about the subject hold for the mutant. A new process bounds the time and memory of the proofs."""
    child = os.fork()
    if child == 0:
        resource.setrlimit(resource.RLIMIT_AS, (MEMORY_LIMIT, MEMORY_LIMIT))
        signal.alarm(TIME_LIMIT)
        os._exit(0 if all(v in (Verdict.PROVED, Verdict.REFUTED) for v in subject.verdicts(mutant)) else 1)
    return os.waitpid(child, 0)[1] == 0


def main(count: int) -> int:
    """Draw mutants until `count` of them change a value, and print those that no lemma notices. Return the exit code."""
    warnings.simplefilter("ignore")
    rng = random.Random(1)
    subjects = [*source_subjects(), *shipped_kernel_subjects(), *small_kernel_subjects(), *emitted_function_subjects()]
    tally: Counter[str] = Counter()
    missed: list[str] = []
    while tally["changed"] < count:
        subject = subjects[tally["mutants"] % len(subjects)]
        tally["mutants"] += 1
        try:
            mutant = mutate_source(subject.code, rng) if isinstance(subject.code, str) else mutate_code(subject.code, rng)
        except TypeError:  # the drawn number does not fit the operand's type
            continue
        if mutant == subject.code or not subject.changes_a_value(mutant, rng):
            continue
        tally["changed"] += 1
        if is_still_proved(subject, mutant):
            missed.append(f"{subject.name}: {_new_statements(subject.code, mutant)}"[:300])
        else:
            tally["noticed"] += 1
    print(
        f"{tally['mutants']} mutants of {len(subjects)} subjects, {tally['changed']} change a value, {tally['noticed']} noticed"
    )
    for description in missed:
        print(f"  missed: {description}")
    return 1 if tally["noticed"] < REQUIRED_SHARE * tally["changed"] else 0


def _new_statements(original: Any, mutant: Any) -> list[str]:
    """Return the lines or statements of a mutant that the original does not have."""
    if isinstance(original, str):
        return [line.strip() for line in mutant.splitlines() if line not in ast.unparse(ast.parse(original)).splitlines()]
    original_statements = {repr(s) for s in _innermost_statements(original.body)}
    return [s for s in map(repr, _innermost_statements(mutant.body)) if s not in original_statements]


def _innermost_statements(body: tuple[Statement, ...]) -> Iterator[Statement]:
    for statement in body:
        if isinstance(statement, For | Return):
            yield from _innermost_statements(statement.body)
        else:
            yield statement


if __name__ == "__main__":
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 400))
