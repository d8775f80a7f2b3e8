"""The package for notebooks and scripts, behind `import stt_codegen as stt`; every name is documented here.

task = stt.load("cart.toml")                    # or stt.Task(name="cart", prescribed_time=6, ...)
controller = stt.build(task)                    # a certified controller
lower, upper = controller.tube(t)               # t a number or an array
controller.write("src")                         # cart.h, cart.c, cart.py, cart.certificate.json

Long because it documents every name; pipeline.py and the rooms do the work.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from stt_codegen import pipeline
from stt_codegen.arrays import as_floats
from stt_codegen.certify import Certificate, Finding
from stt_codegen.design_kinds import kinds_offering
from stt_codegen.designs import Design, uncertified_alpha_step
from stt_codegen.effort import DEFAULT_SECONDS, Effort
from stt_codegen.errors import BadInput, MissingTool, NotCertified, SttError
from stt_codegen.program.targets.python.runner import load_module
from stt_codegen.task import Task, load_task, parse_task
from stt_codegen.task.sets import Box, UnsafeBall, UnsafeCapsule, UnsafeHalfSpaces, UnsafePolytope, UnsafeSet

__all__ = [
    "BadInput", "Box", "Certificate", "Controller", "Finding", "MissingTool", "NotCertified", "SttError", "Task",
    "UnsafeBall", "UnsafeCapsule", "UnsafeHalfSpaces", "UnsafePolytope", "UnsafeSet",
    "build", "certify", "certify_tube", "design", "load", "parse",
]  # fmt: skip


Array = npt.NDArray[np.float64]


def load(path: str | Path) -> Task:
    """Read and check a task file.

    Raises
    ------
    BadInput
        With file, field, what is wrong and what would be right.

    Examples
    --------
    >>> load("tasks/omni_s2.toml").dimension
    2
    """
    return load_task(path)


def parse(text: str) -> Task:
    """Read and check the text of a task file, as `load` does a file's.

    Examples
    --------
    >>> parse(open("tasks/omni_s2.toml").read()) == load("tasks/omni_s2.toml")
    True
    """
    return parse_task(text)


# How a caller asks for a longer search, and for the tube as it is; refusals name it.
LONGER, AS_IT_IS = "effort=SECONDS", "uncertified=True makes the controller as it is, with a banner"


def _load_if_path(task: Task | str | Path) -> Task:
    """Return the task itself, or the task in the file of that path."""
    if isinstance(task, Task):
        return task
    if not isinstance(task, str | Path):
        raise BadInput(f"task: is a {type(task).__name__}; a Task or the path of a task file is needed")
    return load(task)


def design(task: Task | str | Path, *, effort: float = DEFAULT_SECONDS) -> Design:
    """Find a tube of the kind `tube.design` for the task: the numbers that fix it.

    It is a tube that `certify` accepts, where the task leaves one open; else its certificate says what fails.

    Parameters
    ----------
    effort
        Seconds, within which another way is looked for where the task has no certified tube as it is stated.

    Raises
    ------
    NotCertified
        There is no tube. The message has the reason, and changes of the task that were tried and work.
    BadInput
        The task uses an option that its kind of tube does not offer.

    Examples
    --------
    >>> design(load("tasks/omni_s2.toml")).kind
    'refined'
    """
    task = _load_if_path(task)
    pipeline.require_supported(task)
    return pipeline.design_tube(task, Effort(effort, longer=LONGER))


def certify(task: Task | str | Path, tube: Design) -> Certificate:
    """Certify a tube for the task: P1 to P7, P8 with limits, P9 with a period, P10 with a mission.

    Each property has its margin in the task's units, P9 in seconds.

    Returns
    -------
    Certificate
        `holds` is true when every property holds; `findings` has each property with its margin.

    Raises
    ------
    BadInput
        The task uses an option that its kind of tube does not offer, or the tube is not of the kind, dimension, order or
        prescribed time that the task states.

    Examples
    --------
    >>> task = load("tasks/omni_s2.toml")
    >>> certify(task, design(task)).holds
    True
    """
    task = _load_if_path(task)
    pipeline.require_supported(task)
    pipeline.require_design_for(task, tube)
    task = pipeline.with_chosen_control(task, tube)
    return pipeline.certify(task, tube, pipeline.build_program(task, tube))


def build(task: Task | str | Path, *, uncertified: bool = False, effort: float = DEFAULT_SECONDS) -> Controller:
    """Design, certify and emit a controller; nothing is written.

    Parameters
    ----------
    task
        A task, or the path of its file.
    uncertified
        Make the controller even where the certificate fails; every file then says so.
    effort
        Seconds, within which another way is looked for where the task is refused as it is.

    Raises
    ------
    NotCertified
        There is no tube or, unless `uncertified`, the certificate fails. The message has the reason, and changes of the task that
        were tried and work.
    BadInput
        The task's file is refused.

    Examples
    --------
    >>> build("tasks/omni_s2.toml").certificate.holds
    True
    """
    source = None if isinstance(task, Task) else Path(task).resolve()
    return _controller(
        pipeline.build_task(_load_if_path(task), uncertified, effort=Effort(effort, longer=LONGER, as_it_is=AS_IT_IS)), source
    )


def _controller(emitted: pipeline.EmittedController, source: Path | None = None) -> Controller:
    return Controller(**vars(emitted), source=source)


def certify_tube(
    task: Task | str | Path,
    *,
    points: npt.ArrayLike | None = None,
    samples: tuple[Any, Any, Any] | None = None,
    uncertified: bool = False,
) -> Controller:
    """Certify and emit a tube of your own, as `build` does with a designed one. Give `points` or `samples`.

    Parameters
    ----------
    points
        Control points of uniform cubic B-splines over [0, t_c], of shape (K + 3, n, 2) for K segments, lower edge first, in the
        task's units. The last equals the last but two, for the tube rests at t_c. They are rounded inwards to
        the tube's grid.
    samples
        (t, lower, upper) of shapes (M,), (M, n), (M, n), t rising from 0 to t_c, of any curves. The nearest spline tube is
        certified, of tube.segments segments or 32; `Controller.distance` gives its distance from your curves.
    uncertified
        As in `build`.

    Raises
    ------
    BadInput
        Wrong shapes, numbers that are not real and finite, or a tube that still moves at t_c.
    NotCertified
        The tube fails a property; the message has the property, the time and the amount.

    Examples
    --------
    A tube whose edges are given by a few points, joined by a cubic spline of SciPy's (t_c is 9 s here):

    >>> import numpy as np
    >>> from scipy.interpolate import CubicSpline
    >>> waypoints = [0.25, 0.25], [0.5, 1.2], [1.1, 2.0], [2.4, 2.0], [3.5, 2.7], [4.2, 3.7], [4.75, 4.75]
    >>> t, middle = np.linspace(0, 9, 600), CubicSpline(np.linspace(0, 9, 7), waypoints, bc_type="clamped")
    >>> samples = t, middle(t) - 0.1, middle(t) + 0.1
    >>> controller = certify_tube(load("tasks/omni_s2.toml"), samples=samples)
    >>> controller.certificate.holds, bool(controller.distance(*samples).max() < 0.001)
    (True, True)
    """
    from stt_codegen.design import fitted_tube, spline_tube  # brings the solvers, which no other import of this file needs

    if (points is None) == (samples is None):
        raise BadInput("certify_tube: give points or samples")
    task = _load_if_path(task)
    if not task.tube.capabilities.accepts_user_tubes:
        kinds = kinds_offering("accepts_user_tubes", quoted=True)
        raise BadInput(f'tube.design: is "{task.tube.design}"; a tube of your own is a spline, {kinds}')
    tube = spline_tube(task, points) if samples is None else fitted_tube(task, *_require_three_arrays(samples))
    return _controller(pipeline.build_task(task, uncertified, tube))


def _require_three_arrays(samples: Any) -> tuple[Any, Any, Any]:
    """Return t, lower and upper of `certify_tube`'s samples. Raises `BadInput` where there are not three."""
    if not isinstance(samples, list | tuple):
        raise BadInput(f"samples: is a {type(samples).__name__}; a tuple of three arrays is needed, (t, lower, upper)")
    if len(samples) != 3:
        raise BadInput(f"samples: has {len(samples)} entries; three arrays are needed, (t, lower, upper)")
    return samples[0], samples[1], samples[2]


@dataclass(frozen=True, repr=False)
class Controller(pipeline.EmittedController):
    """A task's controller: its emitted functions over arrays, and what you can write, draw and simulate with it.

    n is the dimension; t is in seconds, everything else in the task's units. Times t are a number or an array of shape (P,);
    states and results have the shape (n,) or (P, n). Other shapes raise `BadInput`, and so do arrays that are not of real
    numbers: complex or masked ones, texts, booleans. For a NaN or an infinity the status is 2, or the value NaN. Values
    are those of the emitted Python, in double arithmetic. A controller in integers is evaluated at the nearest tick and the
    nearest unit of x.

    Examples
    --------
    >>> controller = build("tasks/omni_s2.toml")
    >>> controller
    <Controller omni_s2: refined tube, 32 segments, certified, least width 0.5, float>
    """

    source: Path | None = None  # the task's file, where `build` read one

    def __repr__(self) -> str:
        verdict = "certified" if self.certificate.holds else "NOT CERTIFIED"
        width = f"least width {float(self.certificate.minimum_width):.3g}"
        kind = f"{self.design.kind} tube, {self.design.size}"
        return f"<Controller {self.task.name}: {kind}, {verdict}, {width}, {self.program.scalar}>"

    def _repr_png_(self) -> bytes:
        from stt_codegen.report.pictures import figure_of

        data = io.BytesIO()
        figure_of(self).savefig(data, format="png", dpi=80)
        return data.getvalue()

    def __getstate__(self) -> dict[str, Any]:
        """Leave out the emitted Python for pickle: it is loaded again from its text."""
        return {name: value for name, value in self.__dict__.items() if name != "module"}

    # ---- the emitted functions

    @cached_property
    def module(self) -> Any:
        """The emitted Python as a module."""
        return load_module(self.task.name, self.files[f"{self.task.name}.py"])

    def alpha(self, t: npt.ArrayLike) -> Array:
        """Evaluate the update function alpha of an adaptive or literal tube, by emitted steps of the certificate's longest size.

        Returns
        -------
        alpha
            alpha_L, then alpha_U: shape (2 n,) or (P, 2 n).

        Raises
        ------
        BadInput
            A refined tube has no alpha.
        """
        if not self.design.is_stateful:
            raise BadInput(f"{self.task.name}: a {self.design.kind} tube has no alpha")
        times, single = self._times(t, finite=True)
        steps = self.certificate.steps
        longest = float(steps[1]) if steps is not None else float(uncertified_alpha_step(self.task.prescribed_time))
        start, alpha, alpha_at = 0.0, self.module.alpha_init(), {}
        for end in np.unique(np.maximum(times, 0.0)):
            count = int(np.ceil((end - start) / longest)) if end > start else 0
            for k in range(count):
                alpha = self.module.alpha_step(start + k * (end - start) / count, (end - start) / count, alpha)
            start, alpha_at[float(end)] = float(end), alpha
        rows = np.array([alpha_at[float(t)] for t in np.maximum(times, 0.0)])
        return rows[0] if single else rows

    def tube(self, t: npt.ArrayLike) -> tuple[Array, Array]:
        """Evaluate the lower and upper edges of the tube at times t, each of shape (n,) or (P, n).

        Examples
        --------
        >>> lower, upper = build("tasks/omni_s2.toml").tube([0.0, 4.5, 9.0])
        >>> lower.shape, bool((upper - lower).min() > 0.49)
        ((3, 2), True)
        """
        lower, upper = self._at("tube", t)
        return lower, upper

    def tube_rate(self, t: npt.ArrayLike) -> tuple[Array, Array]:
        """Evaluate the rates of the edges at times t, each of shape (n,) or (P, n), in units per second."""
        if self.program.tick is not None:
            raise BadInput(f"{self.task.name}: a controller in integers has no rates of its edges")
        lower, upper = self._at("tube_rate", t)
        return lower, upper

    def control(self, t: npt.ArrayLike, x: npt.ArrayLike, v: npt.ArrayLike | None = None) -> tuple[Any, Array]:
        """Evaluate status and input at times t for states x and, for plants of order 2, their velocities v of x's shape.

        Returns
        -------
        status
            0 inside, 1 outside the tube, 2 bad input: a number or (P,).
        u
            The input, of shape (n,) or (P, n).

        Examples
        --------
        >>> status, u = build("tasks/omni_s2.toml").control(0.0, [0.1, 0.4])
        >>> int(status), bool(u[0] > 0 > u[1])
        (0, True)
        """
        status, u = self._at("control", t, x, v)
        return status, u

    def filtered_tube(self, t: npt.ArrayLike) -> tuple[Array, Array]:
        """Evaluate the lower and upper edges of v + lambda x at times t, for plants of order 2.

        Each is of shape (n,) or (P, n), in units per second.
        """
        if self.task.order == 1:
            raise BadInput(f"{self.task.name}: is of order 1; only a plant of order 2 has a filtered tube")
        lower, upper = self._at("filtered_tube", t)
        return lower, upper

    def margin(self, t: npt.ArrayLike, x: npt.ArrayLike, v: npt.ArrayLike | None = None) -> Any:
        """Return the distance of x from the nearest edge as a share of the tube's width: a number, or (P,).

        0.5 is in the middle, 0 at an edge. For plants of order 2 it is the smaller one of that and the share of v + lambda x
        in its filtered tube.

        Examples
        --------
        >>> round(float(build("tasks/omni_s2.toml").margin(0.0, [0.25, 0.25])), 3)
        0.5
        """
        (share,) = self._at("margin", t, x, v)
        return share

    def margins(self, t: npt.ArrayLike, x: npt.ArrayLike, v: npt.ArrayLike | None = None) -> Array:
        """Return `margin` by component, which shows the axis that is near an edge: of shape (n,) or (P, n).

        Examples
        --------
        >>> [round(float(m), 2) for m in build("tasks/omni_s2.toml").margins(0.0, [0.1, 0.25])]
        [0.2, 0.5]
        """
        (shares,) = self._at("margins", t, x, v)
        return np.asarray(shares)

    def covered(self, x: npt.ArrayLike, v: npt.ArrayLike | None = None) -> Any:
        """Return whether the guarantee covers a start at the measured x: a truth value, or (P,) of them.

        v is the velocity, for plants of order 2. With `control.period` the guarantee is the proof for held inputs (P9), else
        Theorem 4.1 where the clamp does not act. The answer is false where the controller is not certified. Raises `BadInput`
        for adaptive and literal tubes, which have no such bounds.

        Examples
        --------
        >>> [bool(c) for c in build("tasks/omni_s2.toml").covered([[0.25, 0.25], [0.25, 0.499]])]
        [True, False]
        """
        if not self.design.capabilities.emits_covered_starts:
            kinds = kinds_offering("emits_covered_starts")
            raise BadInput(f"{self.task.name}: only a {kinds} tube says which starts are covered; this one is {self.design.kind}")
        (inside,) = self._at("covered", 0.0, x, v)
        return inside

    def unwrap(self, x_before: npt.ArrayLike, x: npt.ArrayLike) -> Array:
        """Return a measured x with the turns of its closed axes counted: the state that `control`, `margin` and `covered` take.

        x_before is the last unwrapped state, at first the initial one. All are of shape (n,). Raises `BadInput` where no axis
        closes.
        """
        if not self.task.closed_axes:
            raise BadInput(f"{self.task.name}: no axis closes (periodic); take x as it is measured")
        before = as_floats("x_before", x_before)
        state = as_floats("x", x, finite=False)
        for label, values in (("x_before", before), ("x", state)):
            if values.shape != (self.task.dimension,):
                raise BadInput(
                    f"{label}: has shape {values.shape}; ({self.task.dimension},) is needed, one number for each dimension"
                )
        return np.asarray(self.module.unwrap(before.tolist(), state.tolist()))

    def distance(self, t: npt.ArrayLike, lower: npt.ArrayLike, upper: npt.ArrayLike) -> Array:
        """Return the largest distance of the tube's edges from lower and upper at times t: (n,), in the task's units."""
        times, single = self._times(t, finite=True)
        expected_shape = (self.task.dimension,) if single else (len(times), self.task.dimension)
        edges = [as_floats(name, value) for name, value in (("lower", lower), ("upper", upper))]
        for name, edge in zip(("lower", "upper"), edges, strict=True):
            if edge.shape != expected_shape:
                raise BadInput(f"{name}: has shape {edge.shape}; {expected_shape} is needed, one row for each time")
        distances = np.abs(np.stack(self.tube(times[0] if single else times)) - np.stack(edges))
        return np.asarray(distances.reshape(-1, self.task.dimension).max(axis=0))

    def _times(self, t: npt.ArrayLike, finite: bool = False) -> tuple[Array, bool]:
        """Return t as an array of one axis, and whether it was a number. finite: refuse a NaN or an infinity."""
        times = as_floats("t", t, finite)
        if times.ndim > 1 or not times.size:
            raise BadInput(f"t: has shape {times.shape}; a number or an array of one axis is needed, with one time or more")
        return np.atleast_1d(times), times.ndim == 0

    def _at(self, name: str, t: npt.ArrayLike, *state: npt.ArrayLike | None) -> list[Any]:
        """Evaluate an emitted function at every time.

        Outputs have no first axis where t is a number and x is a single state. state: x and v, as far as the function takes them.
        """
        times, single = self._times(t)
        labelled = [(label, v) for label, v in zip(("x", "v"), state, strict=False) if v is not None or self.task.order == 2]
        if len(labelled) > self.task.order:
            raise BadInput("v: the plant is of order 1, whose law takes x alone")
        arguments = []
        for label, value in labelled:
            states = self._states(label, value, times, single)
            single = single and states.ndim == 1
            count = len(states) if states.ndim == 2 else len(times)
            times = np.broadcast_to(times, count)
            arguments.append(np.broadcast_to(states, (count, self.task.dimension)))
        if self.design.is_stateful:
            arguments = [np.atleast_2d(self.alpha(times)), *arguments]
        function = getattr(self.module, name)
        if self.program.tick is not None:
            columns = self._in_integers(name, times, arguments)
            return [c[0] for c in columns] if single else columns
        takes_time = name != "covered"
        rows = [function(*([float(v)] if takes_time else []), *(a[k] for a in arguments)) for k, v in enumerate(times)]
        has_columns = isinstance(rows[0], tuple) and name != "margins"
        columns = [np.array(c) for c in zip(*rows, strict=True)] if has_columns else [np.array(rows)]
        return [c[0] for c in columns] if single else columns

    def _states(self, label: str, value: npt.ArrayLike | None, times: Array, single: bool) -> Array:
        """Return x or v as an array, (n,) or (P, n). Raises `BadInput` where it is missing or does not fit the times."""
        n = self.task.dimension
        states: Array = as_floats(label, np.nan if value is None else value, finite=False)
        if states.ndim not in (1, 2) or states.shape[-1] != n or (states.ndim == 2 and len(times) not in (1, len(states))):
            expected_shape = f"({n},) or ({'P' if single else len(times)}, {n})"
            problem = "is missing" if value is None else f"has shape {states.shape}"
            raise BadInput(f"{label}: {problem}; {expected_shape} is needed, one number for each dimension")
        return states

    def _in_integers(self, name: str, times: Array, states: list[Any]) -> list[Any]:
        """Evaluate a function in integers at the nearest tick and units; return its values in the task's units."""
        assert self.program.tick is not None
        module, tick = self.module, float(self.program.tick)
        for label, values in (("t", times), *zip(("x", "v"), states, strict=False)):
            if not np.isfinite(values).all():
                raise BadInput(f"{label}: has a number that is not finite; a controller in integers takes finite ones only")
        ticks = np.clip(np.rint(times / tick), 0, 2**32 - 1).astype(np.int64)
        units = [np.clip(np.rint(np.ldexp(a, module.X_BITS)), -(2**31), 2**31 - 1).astype(np.int64) for a in states]
        if name == "covered":
            return [np.array([module.covered(*(a[k].tolist() for a in units)) for k in range(len(ticks))])]
        rows = [getattr(module, name)(int(v), *(a[k].tolist() for a in units)) for k, v in enumerate(ticks)]
        if name in ("margin", "margins"):
            return [np.array(rows) / 65536]
        first, second = (np.array(c) for c in zip(*rows, strict=True))
        if name == "control":
            return [first, np.ldexp(second.astype(float), -module.U_BITS)]
        return [np.ldexp(edge.astype(float), -module.X_BITS) for edge in (first, second)]

    # ---- CasADi, files, pictures, closed loops

    def casadi(self) -> Mapping[str, Any]:
        """Return the emitted functions of seconds as CasADi functions, made of the printed statements, and du_dx and du_dt of u.

        Inputs and outputs are columns; call them with numbers, SX or MX. Keys: tube, tube_rate, control, margin, transform. The
        functions of adaptive tubes take alpha too, and have alpha_rate (the update equation and its Jacobian) and alpha_step.

        Examples
        --------
        The input u for a symbolic state, for your own optimisation problem:

        >>> import casadi as ca
        >>> x = ca.MX.sym("x", 2)
        >>> status, u = build("tasks/omni_s2.toml").casadi()["control"](1.0, x)
        >>> u.shape
        (2, 1)
        """
        if self.program.tick is not None:
            raise BadInput(
                f"{self.task.name}: a controller in integers has no CasADi functions; build it in floating point for them"
            )
        import casadi as ca

        from stt_codegen.program import REAL
        from stt_codegen.program.convert import casadi_function

        names = [f.name for f in self.program.functions if all(p.type is REAL for p in f.params) and f.inputs]
        functions = {name: casadi_function(self.program, name) for name in names}
        law = functions["control"]
        symbols = [ca.SX.sym(law.name_in(k), *law.size_in(k)) for k in range(law.n_in())]
        _, u = law(*symbols)
        for name, by in (("du_dx", "x"), ("du_dt", "t")):
            jacobian = ca.jacobian(u, symbols[law.index_in(by)])
            functions[name] = ca.Function(name, symbols, [jacobian], law.name_in(), [name])
        return functions

    def write(self, folder: str | Path) -> list[Path]:
        """Write the files into a folder, all of them or none.

        Returns
        -------
        list of Path
            The files.

        Raises
        ------
        BadInput
            The folder cannot be written, or a file is not the one that the certificate is about.

        Examples
        --------
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     [path.name for path in build("tasks/omni_s2.toml").write(folder)]
        ['omni_s2.h', 'omni_s2.c', 'omni_s2.py', 'omni_s2.certificate.json']
        """
        from stt_codegen.files import write_files

        write_files(Path(folder), self.files)
        return [Path(folder) / name for name in self.files]

    def plot(self, ax: Any = None) -> Any:
        """Draw the tube: all panels as a matplotlib Figure, or the arena alone into `ax`. The backend of matplotlib stays.

        Examples
        --------
        >>> len(build("tasks/omni_s2.toml").plot().axes)
        3
        """
        from stt_codegen.report.pictures import draw_arena, draw_dimension, figure_of, sample_tube

        if ax is None:
            return figure_of(self)
        tube = sample_tube(self)
        if self.task.dimension > 1:
            draw_arena(ax, self, tube)
        else:
            draw_dimension(ax, self, 0, tube)
        return ax

    def simulate(self, plant: Any = "integrator", **scenario: Any) -> Any:
        """Simulate a plant in closed loop with the compiled C; the input is held between samples.

        Parameters
        ----------
        plant
            A name, the path of a Python file, or a `Plant`.
        scenario
            Fields of `loop.simulate.Scenario`: rate in Hz, disturbance, strength, noise, noise_v, lost, latency, lag, start,
            seed, clock. Rate, noise and latency that you leave out are the task's (1 kHz, 0 and 0 where it has none).

        Returns
        -------
        Run
            With its trace: rows of t, x, u, lower, upper, w, status.

        Raises
        ------
        BadInput
            No such field of a scenario, or no such plant.
        MissingTool
            There is no C compiler.

        Examples
        --------
        >>> build("tasks/omni_s2.toml").simulate(rate=1000).good
        True
        """
        from stt_codegen.loop import Loop, Scenario, scenario_of_task
        from stt_codegen.plants import plant_of

        model = plant_of(plant, self.task.dimension, self.task.order) if isinstance(plant, str) else plant
        if not all(hasattr(model, name) for name in ("name", "f", "g", "w_max", "dimension", "order", "constants", "mixing")):
            raise BadInput(f"plant: is a {type(plant).__name__}; a name, a Python file or a `stt_codegen.plants.Plant` is needed")
        try:
            conditions = Scenario(**{**scenario_of_task(self.task), **scenario})
        except TypeError:
            known = [field.name for field in fields(Scenario)]
            unknown = [name for name in scenario if name not in known] or list(scenario)
            raise BadInput(f"simulate: {unknown[0]}: is not understood; known are {', '.join(known)}") from None
        return Loop(self, model).run(conditions, trace=True)

    def report(self, path: str | Path | None = None, *, plant: str | None = None, show: bool = True) -> Path:
        """Write the page of `stt-codegen report`, and open it in a browser.

        Parameters
        ----------
        path
            The page; by default <name>.report.html in the current folder.
        plant
            The plant that the page simulates and is about, by name or Python file; by default the table [plant].
        show
            Whether to open it.

        Returns
        -------
        Path
            The page.

        Raises
        ------
        BadInput
            Its folder cannot be written, or there is no such plant.

        Examples
        --------
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     page = build("tasks/omni_s2.toml").report(folder + "/page.html", show=False)
        ...     page.name, page.read_text()[:15]
        ('page.html', '<!doctype html>')
        """
        import webbrowser

        from stt_codegen.files import write_files
        from stt_codegen.plants import plant_of
        from stt_codegen.report import design_report
        from stt_codegen.report.page import evidence, page

        model = None if plant is None else plant_of(plant, self.task.dimension, self.task.order)
        target = Path(path) if path is not None else Path(f"{self.task.name}.report.html")
        write_files(target.parent, {target.name: page(self, design_report(self, 0.0), evidence(self, self.source), model)})
        if show:
            webbrowser.open(target.resolve().as_uri())
        return target
