"""Plants xdot = f(x) + g(x) u + w, or of order 2, unknown to the controller: for bounds on u, for sampling and simulation.

You write a plant as a Python file with `f(x)` and `g(x)`, CasADi expressions of a column x (or lists of entries and of rows), and
`w_max`, a bound on the norm of w, if there is one:

    import casadi as ca

    def f(x):
        return [0, -9.81 * ca.sin(x[0])]

    def g(x):
        return [[1, 0], [0, 2 + ca.cos(x[0])]]

    w_max = 0.1

For a plant of order 2, xdot = v, vdot = f(x, v) + g(x, v) u + w, both take x and v. A file may also state

    p = [(0, 0.3)]      # unknown constants, each from .. to: f(x, p), g(x, p), or f(x, v, p), g(x, v, p)

    def mix(x):         # the board multiplies u by it at the sample: the plant's input is mix(x of the sample) u, held
        return [[1, 0], [0, 1 + 0.5 * ca.cos(x[1])]]

A bound over a box then holds for all constants within their ranges, and for samples of every possible age.

CasADi is imported only where a plant is evaluated. Long because every error of a plant's file is refused here.
"""

from __future__ import annotations

import contextlib
import inspect
import math
import runpy
import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, Protocol

from stt_codegen.arrays import is_array, real_array, require_real
from stt_codegen.errors import BadInput


class Model(Protocol):
    """The interface of a plant.

    f, g: CasADi expressions of the column x, for order 2 of x and v, shapes (n,) and (n, n). w_max: a bound on |w|, in units per
    second, for order 2 per second squared. dimension, order: None where every one is possible. constants: ranges of the last
    argument of f and g, if they have one. mixing: an (n, n) matrix of the sample's x, by which u is multiplied.
    """

    @property
    def name(self) -> str: ...
    @property
    def dimension(self) -> int | None: ...
    @property
    def order(self) -> int | None: ...
    @property
    def w_max(self) -> Fraction: ...
    @property
    def constants(self) -> tuple[tuple[float, float], ...]: ...
    @property
    def mixing(self) -> Callable[..., Any] | None: ...
    def f(self, *state: Any) -> Any: ...
    def g(self, *state: Any) -> Any: ...


@dataclass(frozen=True, kw_only=True)
class Plant:
    """A plant made of two functions."""

    name: str
    dimension: int | None
    drift: Callable[..., Any]
    input_matrix: Callable[..., Any]
    w_max: Fraction = Fraction(0)
    order: int | None = 1
    constants: tuple[tuple[float, float], ...] = ()
    mixing: Callable[..., Any] | None = None

    def f(self, *state: Any) -> Any:
        return self.drift(*state)

    def g(self, *state: Any) -> Any:
        return self.input_matrix(*state)


# ------------------------------------------------------------------------------------------------ built in


def _no_drift(x: Any, *_: Any) -> Any:
    return [0] * x.shape[0]


def _identity(x: Any, *_: Any) -> Any:
    n = x.shape[0]
    return [[int(i == j) for j in range(n)] for i in range(n)]


def _robot(x: Any) -> Any:
    """g of (14): velocities in the robot's frame, turned by its heading x3."""
    import casadi as ca

    c, s = ca.cos(x[2]), ca.sin(x[2])
    return [[c, -s, 0], [s, c, 0], [0, 0, 1]]


INERTIA = (1.2, 1.0, 0.8)  # kg m^2 about the principal axes, of the example spacecraft


def _gyroscopic(x: Any) -> Any:
    """Euler's equations: J omegadot = -omega x (J omega) + torque."""
    a, b, c = INERTIA
    return [(b - c) / a * x[1] * x[2], (c - a) / b * x[2] * x[0], (a - b) / c * x[0] * x[1]]


def _torques(_x: Any) -> Any:
    return [[1 / INERTIA[0], 0, 0], [0, 1 / INERTIA[1], 0], [0, 0, 1 / INERTIA[2]]]


def _droop(x: Any) -> Any:
    """f of a velocity servo of a planar arm of two equal links: the effect of gravity, rad/s."""
    import casadi as ca

    return [-0.10 * ca.cos(x[0]) - 0.05 * ca.cos(x[0] + x[1]), -0.05 * ca.cos(x[0] + x[1])]


def _servo(x: Any) -> Any:
    """g of the arm, unknown to the controller: gains change with the elbow, and each joint drags the other a little."""
    import casadi as ca

    drag = 0.15 * ca.cos(x[1])
    return [[0.9 - 0.2 * ca.cos(x[1]), drag], [drag, 1.1]]


PLANTS = {
    plant.name: plant
    for plant in (
        # xdot = u + w, or vdot = u + w, in any dimension
        Plant(name="integrator", dimension=None, drift=_no_drift, input_matrix=_identity, order=None),
        # the omnidirectional robot (14) with its heading x3
        Plant(name="robot", dimension=3, drift=_no_drift, input_matrix=_robot),
        # attitude rates of a rigid body, torques as inputs
        Plant(name="spacecraft", dimension=3, drift=_gyroscopic, input_matrix=_torques),
        # two-link arm at velocity level, unknown gains
        Plant(name="arm", dimension=2, drift=_droop, input_matrix=_servo),
    )
}


# ------------------------------------------------------------------------------------------------ by name


def plant_of(name: str, dimension: int, order: int = 1) -> Model:
    """Return a built-in plant, or the one in a Python file. Raises `BadInput` where it does not exist or fit the task."""
    plant = _plant_in_file(Path(name)) if name.endswith(".py") else PLANTS.get(name)
    functions = "f(x, v) and g(x, v)" if order == 2 else "f(x) and g(x)"
    if plant is None:
        raise BadInput(f"--plant {name}: is none of {', '.join(PLANTS)}, nor a Python file with {functions}")
    if plant.order not in (None, order):
        orders = f"is of order {plant.order}, the task of order {order}"
        raise BadInput(f"--plant {name}: {orders}; give {functions}, or use integrator")
    if plant.dimension not in (None, dimension):
        fitting = [p.name for p in PLANTS.values() if p.dimension in (None, dimension) and p.order in (None, order)]
        raise BadInput(f"--plant {name}: has {plant.dimension} dimensions, the task has {dimension}; use {', '.join(fitting)}")
    model(plant, dimension, order)  # it refuses wrong shapes and functions
    return plant


def _plant_in_file(path: Path) -> Plant:
    """Run a plant's file and return its plant. Raises `BadInput` for what is missing or of the wrong type."""
    try:
        with contextlib.redirect_stdout(sys.stderr):  # its output must not mix with results
            names = runpy.run_path(str(path))
    except (Exception, SystemExit) as error:  # the user's own code may raise anything
        raise BadInput(f"--plant {path}: cannot be run ({type(error).__name__}: {error})") from None
    for function in ("f", "g"):
        if not callable(names.get(function)):
            raise BadInput(f"--plant {path}: has no function {function}(x); see `stt_codegen/plants.py` for an example")
    try:
        w_max = Fraction(str(names.get("w_max", 0)))
        float(w_max)
    except (ValueError, ArithmeticError):
        w_max = Fraction(-1)
    if w_max < 0:
        raise BadInput(f"--plant {path}: w_max is {names['w_max']!r}; a number that is 0 or greater is needed")
    constants = _constants(path, names.get("p", ()))
    mixing = names.get("mix")
    if mixing is not None and not callable(mixing):
        raise BadInput(f"--plant {path}: mix is {mixing!r}; a function of x is needed")
    order = _order(names["f"], bool(constants))
    if not constants and "p" in _parameters(names["f"]):
        raise BadInput(f"--plant {path}: f takes p, and the file gives no ranges for it; add them, for example p = [(0, 0.3)]")
    return Plant(
        name=path.stem,
        dimension=None,
        drift=names["f"],
        input_matrix=names["g"],
        w_max=w_max,
        order=order,
        constants=constants,
        mixing=mixing,
    )


def _constants(path: Path, p: Any) -> tuple[tuple[float, float], ...]:
    """Return the ranges of `p`. Raises `BadInput` where they are no ranges."""
    try:
        ranges = tuple((float(low), float(high)) for low, high in p)
    except (TypeError, ValueError, ArithmeticError):
        ranges = ((1.0, 0.0),)
    for k, (low, high) in enumerate(ranges):
        if not (math.isfinite(low) and math.isfinite(high) and low <= high and math.isfinite(low + high)):
            value = f"p[{k}] is {p[k]!r}" if isinstance(p, Sequence) and k < len(p) else f"p is {p!r}"
            raise BadInput(
                f"--plant {path}: {value}; finite ranges (from, to), from <= to, are needed, for example p = [(0, 0.3)]"
            )
    return ranges


def _parameters(function: Callable[..., Any]) -> Mapping[str, inspect.Parameter]:
    """Return the parameters by name; none where the function is not Python's."""
    try:
        return inspect.signature(function).parameters
    except (TypeError, ValueError):
        return {}


def _order(function: Callable[..., Any], constants: bool) -> int:
    """Return 2 where a function needs x and v, else 1; the constants, where there are any, are one more argument."""
    parameters = _parameters(function).values()
    needed = sum(p.default is p.empty and p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) for p in parameters)
    return 2 if needed - constants == 2 else 1


def model(plant: Model, dimension: int, order: int = 1) -> Any:
    """Return the plant as a CasADi function with outputs f (n) and g (n by n, dense).

    Its argument is a column: x (n), or x and v (2n); then the constants, if there are any; then the sample's x (n), if the plant
    mixes, and the mixing matrix is then in g. Raises `BadInput` for wrong shapes and for expressions that cannot be printed.
    """
    import casadi as ca

    parts = [ca.SX.sym(name, dimension) for name in ("x", "v")[:order]]
    parts += [ca.SX.sym("p", len(plant.constants))] if plant.constants else []
    sample = ca.SX.sym("sample", dimension if plant.mixing else 0)
    _require_mixing(plant, sample)
    mixing = ca.SX.eye(dimension)
    try:
        with contextlib.redirect_stdout(sys.stderr):
            f = ca.densify(_matrix(plant.f(*parts)))
            g = ca.densify(_matrix(plant.g(*parts)))
            mixing = mixing if plant.mixing is None else ca.densify(_matrix(plant.mixing(sample)))
    except (Exception, SystemExit) as error:  # the user's own code may raise anything
        if "out of bounds" in str(error).lower():
            raise BadInput(
                f"--plant {plant.name}: f, g or mix reads an entry that x does not have; the task has {dimension} dimensions, "
                f"x[0] to x[{dimension - 1}]" + (f", and p has {len(plant.constants)} ranges" if plant.constants else "")
            ) from None
        raise BadInput(f"--plant {plant.name}: f(x) or g(x) fails ({_first_line(error)})") from None
    square = (dimension, dimension)
    for name, value, shape in (("f", f, (dimension, 1)), ("g", g, square), ("mix", mixing, square)):
        if value.shape != shape:
            raise BadInput(f"--plant {plant.name}: {name}(x) has shape {value.shape}; {shape} is needed")
    g = g if plant.mixing is None else ca.densify(ca.mtimes(g, mixing))
    function = ca.Function("plant", [ca.vertcat(*parts, sample)], [f, g], ["x"], ["f", "g"])
    _require_printable(plant, function)
    return function


def _require_mixing(plant: Model, sample: Any) -> None:
    """Raise `BadInput` where a plant's mix(x) fails for the sample's x, or is no matrix."""
    if plant.mixing is None:
        return
    try:
        with contextlib.redirect_stdout(sys.stderr):
            _matrix(plant.mixing(sample))
    except (Exception, SystemExit) as error:  # the user's own code may raise anything
        raise BadInput(
            f"--plant {plant.name}: mix(x) fails or is no matrix ({_first_line(error)}); it takes x of the sample alone"
        ) from None


def _require_printable(plant: Model, function: Any) -> None:
    """Raise `BadInput` where f or g has an operation that cannot be enclosed and printed, or a NaN."""
    from stt_codegen.program.convert import UnknownOpcode, lower

    try:
        lower(function)
    except (UnknownOpcode, ValueError, OverflowError) as error:
        if "NaN" in str(error):
            raise BadInput(
                f"--plant {plant.name}: a NaN came of f(x) or g(x); functions of Python's math take no expressions, use "
                "CasADi's, as in casadi.sin(x[0])"
            ) from None
        raise BadInput(
            f"--plant {plant.name}: f(x) or g(x) has something that cannot be enclosed and printed ({error})"
        ) from None


def _first_line(error: BaseException) -> str:
    """Return the type of an error and the first line of its message."""
    return f"{type(error).__name__}: {str(error).partition(chr(10))[0]}"


def _matrix(value: Any) -> Any:
    """Return a CasADi matrix from an expression, a list of entries, or a list of rows."""
    import casadi as ca

    if isinstance(value, Sequence):
        rows = [ca.horzcat(*map(_entry, row)) if _is_row(row) else _entry(row) for row in value]
        return ca.vertcat(*(ca.SX(row) for row in rows))
    return ca.SX(_entry(value))


def _is_row(value: Any) -> bool:
    """Return whether a value is a row of a matrix: a list, or an array of one axis."""
    import casadi as ca

    array = is_array(value) and not isinstance(value, ca.SX | ca.MX | ca.DM) and getattr(value, "ndim", 0) == 1
    return (isinstance(value, Sequence) and not isinstance(value, str)) or array


def _entry(value: Any) -> Any:
    """Return an expression, a number or an array unchanged. Raises ValueError for numbers that are not real or not finite."""
    import casadi as ca

    if isinstance(value, ca.SX | ca.MX | ca.DM):
        return value
    require_real(value, symbols=True)
    if not is_array(value):
        if abs(value) == math.inf:  # a NaN has a message of its own, by the operation that produces it
            raise ValueError(f"has {value} in it; finite numbers are needed")
        return value if isinstance(value, int | float) else float(value)
    array = real_array(value, symbols=True)
    if array.dtype.kind == "O":
        return ca.vertcat(*(ca.horzcat(*map(_entry, row)) if array.ndim == 2 else _entry(row) for row in array))
    if math.inf in map(abs, array.ravel().tolist()):
        raise ValueError("has an infinity in it; finite numbers are needed")
    return array.astype(float)  # CasADi would end the process for numbers of 128 bits
