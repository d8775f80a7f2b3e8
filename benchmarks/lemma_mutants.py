"""How many mutants the lemma book finds: one node of an emitted kernel or function changed, or of the source of what lemmas run
on symbols (sampled statements, windows, P9, update curves, rows, P7's time error), and the lemmas that read it run again.

    python -m benchmarks lemma_mutants [COUNT]

A mutant counts when it changes an output at some of many inputs by more than rounding; it is found when a lemma about that kernel
or function is no longer proved, be it that the proof takes longer than PATIENCE. Deterministic. The mutants that are missed are
listed.
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
from stt_codegen.lemmas.sampling import first_exit, sampled_evaluated, sampled_exact, sampled_windows
from stt_codegen.lemmas.sets import task_constraints as row_lemmas
from stt_codegen.lemmas.tube import spline_edges
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
from stt_codegen.task.sets import convex_sets as sets

OTHER = {
    "add": "sub", "sub": "add", "mul": "div", "div": "mul", "lt": "le", "le": "lt", "exp": "tanh", "log": "exp", "log1p": "exp",
    "neg": "fabs", "iadd": "isub", "isub": "iadd", "imul": "iadd", "and": "or", "or": "and",
}  # fmt: skip
MEMORY = 4 << 30  # bytes
PATIENCE = 30  # seconds for the lemmas of a mutant; a formula gone wild is not proved either
SMALL_KERNELS = {
    "basis": spline_edges,
    "basis_rate": spline_edges,
    "blend": spline_edges,
    "normalized_error": transform,
    "transformed_error": transform,
    "law": transform,
}

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
    verdicts: Callable[[Any], Iterable[Verdict]]


def _numbers(values: Any) -> list[float]:
    return [float(v) for v in (values if isinstance(values, tuple) else (values,))]


def _unlike(a: list[float], b: list[float]) -> bool:
    return any(
        not (x == y or (math.isnan(x) and math.isnan(y)) or abs(x - y) <= 1e-9 * (1 + abs(x))) for x, y in zip(a, b, strict=True)
    )


def kernel_differs(before: Kernel) -> Callable[[Any, random.Random], bool]:
    """At the claims' own points, moved a little, and at random ones."""

    def call(kernel: Kernel) -> Callable[..., Any]:
        printer, names = PythonPrinter(Program("p", 1, "double", (), (kernel,), functions=())), {}
        exec("import math\n" + "\n".join(printer.kernel(kernel)), names)
        function: Callable[..., Any] = names[f"_{kernel.name}"]
        return function

    def differs(after: Kernel, draw: random.Random) -> bool:
        one, other = call(before), call(after)
        claim = printed_kernels.CLAIMS.get(before.name)
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

    def differs(after: Any, _: random.Random) -> bool:
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


# --------------------------------------------------------------------------------- the source of what lemmas run

SWAPS: dict[type[ast.AST], type[ast.AST]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Lt: ast.Gt, ast.Gt: ast.Lt, ast.Pow: ast.Mult,
    ast.LtE: ast.GtE, ast.GtE: ast.LtE, ast.FloorDiv: ast.Div, ast.And: ast.Or, ast.Or: ast.And, ast.Eq: ast.NotEq,
}  # fmt: skip
OTHER_NAMES = {
    "least": "most", "most": "least", "diagonal_min": "diagonal_max", "diagonal_max": "diagonal_min", "narrow": "wide",
    "wide": "narrow", "shift": "latency", "latency": "shift", "cosh": "tanh",
    "min": "max", "max": "min", "minimum": "maximum", "maximum": "minimum", "argmin": "argmax", "floor": "ceil", "ceil": "floor",
    "LOWER": "UPPER", "UPPER": "LOWER", "lower": "upper", "upper": "lower", "narrow_seen": "narrow", "f_max": "w_max",
    "keep": "bound", "size": "per", "reach": "speed_factor", "share": "decay", "initial_state": "start", "gain": "e_max",
}  # fmt: skip


def mutate_source(text: str, draw: random.Random) -> str:
    """The text of a function with one operator, number, name or attribute changed."""
    tree = ast.parse(text)
    function = next(n for n in ast.walk(tree) if isinstance(n, ast.FunctionDef))
    assigned = {n.id for n in ast.walk(function) if isinstance(n, ast.Name) and isinstance(n.ctx, ast.Store)}
    local = sorted(assigned | {a.arg for a in function.args.args} - {"self", "cls", "loop"})
    spots: list[Callable[[], None]] = []
    for statement in function.body:
        for node in ast.walk(statement):
            if isinstance(node, ast.BinOp | ast.BoolOp) and type(node.op) in SWAPS:
                spots.append(partial(setattr, node, "op", SWAPS[type(node.op)]()))
            elif isinstance(node, ast.Compare) and type(node.ops[0]) in SWAPS:
                spots.append(partial(setattr, node, "ops", [SWAPS[type(node.ops[0])](), *node.ops[1:]]))
            elif isinstance(node, ast.Constant) and isinstance(node.value, int | float) and not isinstance(node.value, bool):
                spots.append(partial(setattr, node, "value", node.value * 2 + 1))
            elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Load):
                if node.id in OTHER_NAMES and node.id not in local:
                    spots.append(partial(setattr, node, "id", OTHER_NAMES[node.id]))
                elif node.id in local and len(local) > 1:
                    spots.append(partial(setattr, node, "id", draw.choice([v for v in local if v != node.id])))
            elif isinstance(node, ast.Attribute) and node.attr in OTHER_NAMES:
                spots.append(partial(setattr, node, "attr", OTHER_NAMES[node.attr]))
            elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.USub):
                spots.append(partial(setattr, node, "op", ast.UAdd()))
            elif isinstance(node, ast.IfExp):
                spots.append(partial(_exchange, node))
    if spots:
        draw.choice(spots)()
    return ast.unparse(tree)


def _exchange(node: ast.IfExp) -> None:
    node.body, node.orelse = node.orelse, node.body


def plain(thing: Any) -> Any:
    """The function behind a property, a class method or a cache."""
    for name in ("fget", "__func__", "func", "__wrapped__"):
        thing = getattr(thing, name, thing)
    return thing


def code_subject(name: str, owner: Any, attribute: str, probe: Callable[[], list[float]], lemmas: Sequence[Lemma]) -> Subject:
    """A function or method whose source is changed in place, wherever it is known; probe: values that it is a part of."""
    function = plain(vars(owner)[attribute])
    text, before = textwrap.dedent(inspect.getsource(function)), probe()

    @contextlib.contextmanager
    def bent(after: str) -> Iterator[None]:
        names: dict[str, Any] = {}
        exec(compile("from __future__ import annotations\n" + after, name, "exec"), function.__globals__, names)
        kept, function.__code__ = function.__code__, plain(names[attribute]).__code__
        try:
            yield
        finally:
            function.__code__ = kept

    def differs(after: Any, _: random.Random) -> bool:
        try:
            with bent(after):
                return _unlike(before, probe())
        except Exception:
            return False  # what cannot be run is not counted

    def verdicts(after: Any) -> Iterator[Verdict]:
        with bent(after):
            for lemma in lemmas:
                yield lemma.run().verdict

    return Subject(name, text, differs, verdicts)  # type: ignore[arg-type]


def _statements() -> list[float]:
    """Every condition of the three statements, and |u|, at a point."""
    found: list[float] = []
    for name, n, reach in (("sharp", 2, ["E1", "E2"]), ("diagonal", 1, ["E"]), ("general", 2, ["E"])):
        loop = sampled_evaluated.setting(n, coupled=name == "sharp")
        at: Any = (
            np.array([sampled_evaluated.symbol(v) for v in reach], dtype=object)
            if name == "sharp"
            else sampled_evaluated.symbol("E")
        )
        for condition in sampling_conditions.SAMPLING_CONDITIONS[name].conditions(loop, at, sampled_evaluated.symbol("tau")):
            found += [float(v) for v in np.asarray(condition.values, dtype=object).ravel()]
    return found


def _numbers_of(thing: Any) -> list[float]:
    """Every number in arrays, tuples and dataclasses, in their order."""
    if thing is None or isinstance(thing, str | numbers.Doubles | numbers.Fractions):
        return []
    if isinstance(thing, np.ndarray):
        return _numbers_of(thing.ravel().tolist())
    if isinstance(thing, list | tuple):
        return [v for part in thing for v in _numbers_of(part)] + [float(len(thing))]
    if is_dataclass(thing):
        return [v for field in fields(thing) for v in _numbers_of(getattr(thing, field.name))]
    return [float(thing)]


TASK = """
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
def _probed() -> tuple[Any, Any, tuple[Fraction, ...]]:
    """A task with all that P9 can ask for, its tube, and bounds such as P7's."""
    task = stt.parse(TASK)
    return task, stt.design(task), (Fraction(1, 1 << 18), Fraction(1, 1 << 17))


def _windows() -> list[float]:
    table: Any = sampled_windows.BezierTube(np.arange(48.0).reshape(3, 2, 2, 4) * 7 % 11, Fraction(7, 3), Fraction(1, 8))
    found = windows.refined_windows(table)
    return _numbers_of([windows.extremes(table), found, found.shortest])


def _setting() -> list[float]:
    task, tube, error = _probed()
    loop = loops.loop_of(task, tube, error)
    falling = np.array([[3.0, 1.0], [2.0, 5.0], [4.0, 4.5]])
    both = [
        sampled_loop.worst_with_previous_window(falling, np.maximum),
        sampled_loop.worst_with_previous_window(falling, np.minimum),
    ]
    return _numbers_of([loop, loop.longest_age, loop.with_law(latency=0.0).longest_age, *both])


def _period() -> list[float]:
    task, tube, error = _probed()
    loop, age = loops.exact_loop(task, tube, error), Fraction("0.0012")
    values: list[Any] = []
    for rho in ((25, 30), (21, 40), (18, 30), (1e4, 30), (60, 25)):
        e = tuple(map(Fraction, rho))
        values += [periods.inputs_where_proved(loop, e, age * k) for k in (1, 20, 1000)]
    for k, rho in itertools.product(range(4), ((3, 5), (25, 30), (2, 10**5))):
        e = np.array([Fraction(v) for v in rho], dtype=object)
        free, blind = loop.with_law(u_max=np.full(2, np.inf)), loop.with_law(shift=np.array([Fraction(2)] * 2))
        values += [sampling_conditions.input_bound(v.window(k), e) for v in (loop, free, blind)]
        for u in (values[-3], values[-3] * 20):
            conditions = sampling_conditions.sharp_under(loop.window(k), e, age, u, loop.closing_speed[k])
            values.append(sampling_conditions.first_failing(conditions) or 0)
    logarithms = [enclosed.logarithm(Fraction(v)) for v in (1.5, 1.001, 77, 1e6)]
    return _numbers_of([values, logarithms, loop.longest_age, loop.law.shift, loop.law.eps_at_clamp, loop.start])


def _update() -> list[float]:
    times = [0.25 * k for k in range(13)]
    steps = alpha_curves.Steps(Fraction(1, 100), Fraction(1, 20), 1e-5, 2.0**-24)
    values: list[Any] = [steps.minimum, steps.reach]
    for psi, theta in (([0.3, 0.1, 0.05, 0.2, 0.5, 0.9] * 2, [0.02, 0.2, 0.4, 0.1, 0.01, 1e-5] * 2), ([0.4] * 12, [0.05] * 12)):
        both = [alpha_curves.upper_curve, alpha_curves.lower_curve]
        values += [curve(times, [*psi, 0.3], [*theta, 0.1], 5.0, steps) for curve in both]
        values += [alpha_curves.extremes_ahead(np.array(times), np.array(psi), 0.3, largest) for largest in (True, False)]
    values.append(alpha_curves.upper_curve(times, [0.1] * 13, [0.1] * 13, 1e-9, steps))
    for side in (1, -1):
        curve_of_side = alpha_curves.Curve(side, 1e-5, 5.0, 1.001, 0.1)
        values += [curve_of_side.root(p, q) for p in (-2.0, 0.0, 0.5) for q in (0.0, 1e-61, 1e-3, 2.0)]
        values += [curve_of_side.beyond(z, 0.5, 2.0) for z in (1e-3, 1.2, 1.45, 9.0)] + [
            curve_of_side.balance(0.5, v) for v in (1e-9, 3.0)
        ]
    return _numbers_of(values)


def _rows() -> list[float]:
    task = stt.parse(TASK)  # anew: sets keep their faces
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
    about = [(row.size, row.bound_from((Fraction(1), Fraction(3))), row.distance_error, row.dimension) for row in all_constraints]
    faces = [
        [s.faces, s.support((2, -3)), s.grown((Fraction(1), Fraction(2))).faces, s.vertices, s.span(0)] for s in task.obstacles
    ]
    faces += [sets.GrownSet(s, (Fraction(1), Fraction(2))).support((2, -3)) for s in task.obstacles]
    lows = [sets.minimum_over_box(n, (Fraction(1), Fraction(2)), (Fraction(5), Fraction(7))) for n in ((1, 2), (-1, 3), (0, -2))]
    return _numbers_of([all_constraints, about, faces, lows, len(rows.avoidances(task))])


def _slack() -> list[float]:
    draw = random.Random(7)
    bezier = np.array([[[[draw.randint(-60, 60) for _ in range(4)] for _ in range(2)] for _ in range(2)] for _ in range(4)])
    bounds = [rows.Constraint(((0, 0, 1),), Fraction(-70)), rows.Constraint(((1, 1, -1),), Fraction(-211, 3))]
    slanted = [
        rows.Constraint(((0, 0, 2), (1, 1, -3)), Fraction(7, 3), Fraction(1), 5),
        rows.Constraint(((1, 0, 1), (1, 1, 1)), Fraction(-99)),
    ]
    chosen = [rows.Avoidance("a", tuple(slanted)), rows.Avoidance("b", (bounds[0], slanted[0]))]
    unit = Fraction(1, 2)
    blocks = [
        slack.ConstraintBlock.of(bounds, unit),
        slack.ConstraintBlock.of([*bounds, *slanted], unit),
        slack.ConstraintBlock.choice(chosen, unit),
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


def _arithmetic() -> list[float]:
    _, tube, _ = _probed()
    return [float(arithmetic.time_error(tube, scalar) * 1e9) for scalar in ("float", "double")]


READ: tuple[tuple[Any, str, Callable[[], list[float]], tuple[Any, ...]], ...] = (
    (sampling_conditions, "input_bound emitted_input sharp_closing_speed sharp_under drift_of_sample "
     "distances_at_sample weakest_effect input_per_gain q q_rate measured_distances "
     "_measured_eps_bound _diagonal_staleness diagonal _general_staleness general", _statements, (sampled_evaluated,)),
    (sampling_conditions.Staleness, "input_bound input_change", _statements, (sampled_evaluated,)),
    (windows, "extremes refined_windows", _windows, (sampled_windows,)),
    (RefinedDesign, "largest_steps", _windows, (sampled_windows,)),
    (windows.Windows, "shortest", _windows, (first_exit,)),
    (sampled_loop, "law_of first_order_loop worst_with_previous_window", _setting, (first_exit, sampled_windows)),
    (sampled_loop.SampledLoop, "longest_age", _setting, (first_exit,)),
    (enclosed, "logarithm _artanh", _period, (sampled_exact, sampled_windows)),
    (periods, "inputs_where_proved is_in_range", _period, (sampled_exact,)),
    (numbers.Fractions, "eps_of_share far_divisor near_divisor share_of_eps log_below log_above lesser evenly", _period,
     (sampled_exact, sampled_windows)),
    (alpha_curves, "curve_values extremes_ahead", _update, (update_cells,)),
    (alpha_curves.Curve, "of outer cell balance root beyond", _update, (update_cells,)),
    (alpha_curves.Steps, "reach minimum", _update, (update_cells,)),
    (rows, "width_constraints initial_state_constraints start_constraints stay_constraints reach_constraints avoidances "
     "speed_constraints box_constraints _interval_constraints separation_constraints _lowest_value_terms", _rows,
     (row_lemmas,)),
    (rows.Constraint, "size bound_from distance_error dimension", _rows, (row_lemmas,)),
    (sets, "minimum_over_box", _rows, (row_lemmas,)),
    (sets.BoxSet, "support faces grown", _rows, (row_lemmas,)),
    (sets.GrownSet, "support", _rows, (row_lemmas,)),
    (slack, "smallest_slack _halve halves units_above", _slack, (spline_edges, row_lemmas)),
    (slack.ConstraintBlock, "choice _build single slack slack_by_constraint slack_of_block _smallest_left_side set_of", _slack,
     (row_lemmas,)),
    (arithmetic, "late time_error", _arithmetic, (spline_edges,)),
)  # fmt: skip


def sources() -> list[Subject]:
    """Every function and method whose very code a lemma runs."""
    found = []
    for owner, names, probe, modules in READ:
        lemmas = [v for module in modules for v in module.LEMMAS]
        word = owner.__name__.rsplit(".", 1)[-1]
        found += [code_subject(f"{word}.{name}", owner, name, probe, lemmas) for name in names.split()]
    return found


def subjects() -> list[Subject]:
    found = sources()
    shipped = printed_kernels.shipped()
    for name, kernel in shipped.items():
        lemma = next(v for v in printed_kernels.LEMMAS if v.name == f"kernels.{name}")

        def alone(after: Kernel, lemma: Any = lemma, name: str = name) -> list[Verdict]:
            printed_kernels.shipped = lambda: {**shipped, name: after}  # type: ignore[attr-defined]
            try:
                return [lemma.run().verdict]
            finally:
                printed_kernels.shipped = lambda: shipped  # type: ignore[attr-defined]

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
    sys.exit(main(int(sys.argv[1]) if len(sys.argv) > 1 else 400))
