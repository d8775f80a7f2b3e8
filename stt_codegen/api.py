"""The package for notebooks and scripts, behind `import stt_codegen as stt`; every name is documented here.

task = stt.load("cart.toml")                    # or stt.Task(name="cart", prescribed_time=6, ...)
controller = stt.build(task)                    # a certified controller
lower, upper = controller.tube(t)               # t a number or an array
controller.write("src")                         # cart.h, cart.c, cart.py, cart.certificate.json

Long because the documentation of every name is here; the work is done elsewhere.
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
from stt_codegen.design import fitted_tube, spline_tube
from stt_codegen.designs import Design
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


def _task(given: Task | str | Path) -> Task:
    """A task, or the one in a file."""
    if isinstance(given, Task):
        return given
    if not isinstance(given, str | Path):
        raise BadInput(f"task: is a {type(given).__name__}; a Task or the path of a task file is needed")
    return load(given)


def design(task: Task | str | Path) -> Design:
    """Find a tube for the task, as `tube.design` says: the numbers that fix it, not yet certified.

    Raises
    ------
    NotCertified
        No tube is found: with the reason and, where there is one, the option that would do.
    BadInput
        The task asks for something that its kind of tube does not offer.

    Examples
    --------
    >>> design(load("tasks/omni_s2.toml")).kind
    'refined'
    """
    task = _task(task)
    pipeline.require_supported(task)
    return pipeline.design_tube(task)


def certify(task: Task | str | Path, tube: Design) -> Certificate:
    """Certify a tube for the task: P1 to P7, each with its margin in the task's units; P9, in seconds, where it has a period.

    Returns
    -------
    Certificate
        `holds` says whether all of them do, `findings` which and by how much.

    Raises
    ------
    BadInput
        The task asks for something that its kind of tube does not offer, as for `design` and `build`.

    Examples
    --------
    >>> task = load("tasks/omni_s2.toml")
    >>> certify(task, design(task)).holds
    True
    """
    task = _task(task)
    pipeline.require_supported(task)
    task = pipeline.settled(task, tube)
    return pipeline.certify(task, tube, pipeline.build_program(task, tube))


def build(task: Task | str | Path, *, uncertified: bool = False) -> Controller:
    """Design, certify and emit a controller; nothing is written.

    Parameters
    ----------
    task
        A task, or the path of its file.
    uncertified
        Make the controller also where the certificate fails; every file then says so.

    Raises
    ------
    NotCertified
        No tube is found or, unless `uncertified`, the certificate fails.
    BadInput
        The task's file is refused.

    Examples
    --------
    >>> build("tasks/omni_s2.toml").certificate.holds
    True
    """
    made = pipeline.build_task(_task(task), uncertified)
    source = None if isinstance(task, Task) else Path(task).resolve()
    return Controller(made.task, made.design, made.program, made.certificate, made.files, source)


def certify_tube(
    task: Task | str | Path,
    *,
    points: npt.ArrayLike | None = None,
    samples: tuple[Any, Any, Any] | None = None,
    uncertified: bool = False,
) -> Controller:
    """Certify and emit a tube of your own, like one that was designed. Give `points` or `samples`.

    Parameters
    ----------
    points
        Control points of uniform cubic B-splines over [0, t_c], of shape (K + 3, n, 2) for K segments, lower edge first, in the
        task's units. The last equals the last but two, for the tube rests at t_c. They are rounded inwards, to
        the tube's grid.
    samples
        (t, lower, upper) of shapes (M,), (M, n), (M, n), t rising from 0 to t_c: of any curves, a cubic spline on knots of its
        own as well. The nearest spline tube is taken, of tube.segments segments or 32; `Controller.distance` says how far it is.
    uncertified
        As in `build`.

    Raises
    ------
    BadInput
        Other shapes, no real and finite numbers, or a tube that still moves at t_c.
    NotCertified
        The tube does not do: with property, time and amount.

    Examples
    --------
    A tube whose edges are given by a few points, joined by a cubic spline of SciPy's (t_c is 9 s here):

    >>> import numpy as np
    >>> from scipy.interpolate import CubicSpline
    >>> way = [0.25, 0.25], [0.5, 1.2], [1.1, 2.0], [2.4, 2.0], [3.5, 2.7], [4.2, 3.7], [4.75, 4.75]
    >>> t, middle = np.linspace(0, 9, 600), CubicSpline(np.linspace(0, 9, 7), way, bc_type="clamped")
    >>> samples = t, middle(t) - 0.1, middle(t) + 0.1
    >>> own = certify_tube(load("tasks/omni_s2.toml"), samples=samples)
    >>> own.certificate.holds, bool(own.distance(*samples).max() < 0.001)
    (True, True)
    """
    if (points is None) == (samples is None):
        raise BadInput("certify_tube: give points or samples")
    task = _task(task)
    if not task.tube.capabilities.accepts_user_tubes:
        raise BadInput(f'tube.design: is "{task.tube.design}"; a tube of your own is a spline, "refined"')
    own = spline_tube(task, points) if samples is None else fitted_tube(task, *_samples(samples))
    made = pipeline.build_task(task, uncertified, own)
    return Controller(made.task, made.design, made.program, made.certificate, made.files)


def _samples(samples: Any) -> tuple[Any, Any, Any]:
    """The three arrays of `certify_tube`'s samples. Raises `BadInput` where they are not three."""
    if not isinstance(samples, list | tuple):
        raise BadInput(f"samples: is a {type(samples).__name__}; a tuple of three arrays is needed, (t, lower, upper)")
    if len(samples) != 3:
        raise BadInput(f"samples: has {len(samples)} entries; three arrays are needed, (t, lower, upper)")
    return samples[0], samples[1], samples[2]


@dataclass(frozen=True, repr=False)
class Controller(pipeline.EmittedController):
    """A task's controller: the emitted functions, vectorised, and what one does with them.

    n is the dimension; t is in seconds, everything else in the task's units. Times t are a number or an array of shape (P,); then
    states are of shape (n,) or (P, n), and so are results. Other shapes raise `BadInput`, and so do arrays that are not of real
    numbers: complex or masked ones, texts, booleans. Emitted functions answer a NaN or an infinity with status 2 or NaN. Values
    are those of the emitted Python, in double arithmetic; of a controller in integers at the nearest tick, for the nearest unit
    of x.

    Examples
    --------
    >>> controller = build("tasks/omni_s2.toml")
    >>> controller
    <Controller omni_s2: refined tube, 32 segments, certified, least width 0.5, float>
    """

    source: Path | None = None  # the task's file, of what `build` made of one

    def __repr__(self) -> str:
        verdict = "certified" if self.certificate.holds else "NOT CERTIFIED"
        width = f"least width {float(self.certificate.least_width):.3g}"
        kind = f"{self.design.kind} tube, {self.design.size}"
        return f"<Controller {self.task.name}: {kind}, {verdict}, {width}, {self.program.scalar}>"

    def _repr_png_(self) -> bytes:
        from stt_codegen.report.pictures import figure_of

        data = io.BytesIO()
        figure_of(self).savefig(data, format="png", dpi=80)
        return data.getvalue()

    def __getstate__(self) -> dict[str, Any]:
        """For pickle: the emitted Python is loaded anew from its text."""
        return {name: value for name, value in self.__dict__.items() if name != "module"}

    # ---- the emitted functions

    @cached_property
    def module(self) -> Any:
        """The emitted Python, as a module."""
        return load_module(self.task.name, self.files[f"{self.task.name}.py"])

    def alpha(self, t: npt.ArrayLike) -> Array:
        """The update function alpha of an adaptive or literal tube by emitted steps from 0, as long as the certificate allows.

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
        longest = float(steps[1]) if steps is not None else float(self.task.prescribed_time) / 2000
        now, alpha, found = 0.0, self.module.alpha_init(), {}
        for later in np.unique(np.maximum(times, 0.0)):
            count = int(np.ceil((later - now) / longest)) if later > now else 0
            for k in range(count):
                alpha = self.module.alpha_step(now + k * (later - now) / count, (later - now) / count, alpha)
            now, found[float(later)] = float(later), alpha
        rows = np.array([found[float(v)] for v in np.maximum(times, 0.0)])
        return rows[0] if single else rows

    def tube(self, t: npt.ArrayLike) -> tuple[Array, Array]:
        """Lower and upper edges of the tube at times t, each of shape (n,) or (P, n).

        Examples
        --------
        >>> lower, upper = build("tasks/omni_s2.toml").tube([0.0, 4.5, 9.0])
        >>> lower.shape, bool((upper - lower).min() > 0.49)
        ((3, 2), True)
        """
        lower, upper = self._at("tube", t)
        return lower, upper

    def tube_rate(self, t: npt.ArrayLike) -> tuple[Array, Array]:
        """Rates of the edges at times t, each of shape (n,) or (P, n), in units per second."""
        if self.program.tick is not None:
            raise BadInput(f"{self.task.name}: a controller in integers has no rates of its edges")
        lower, upper = self._at("tube_rate", t)
        return lower, upper

    def control(self, t: npt.ArrayLike, x: npt.ArrayLike, v: npt.ArrayLike | None = None) -> tuple[Any, Array]:
        """Status and input at times t for states x, of order 2 with their speeds v, of x's shape.

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
        """Of order 2, lower and upper edges for v + lambda x at times t, each of shape (n,) or (P, n), in units per second."""
        if self.task.order == 1:
            raise BadInput(f"{self.task.name}: is of order 1; only a plant of order 2 has a filtered tube")
        lower, upper = self._at("filtered_tube", t)
        return lower, upper

    def margin(self, t: npt.ArrayLike, x: npt.ArrayLike, v: npt.ArrayLike | None = None) -> Any:
        """How far x is from leaving the tube, as a share of its width: 0.5 in the middle, 0 at an edge; a number, or (P,). Of
        order 2 the lesser of that and the same of v + lambda x in its own tube.

        Examples
        --------
        >>> round(float(build("tasks/omni_s2.toml").margin(0.0, [0.25, 0.25])), 3)
        0.5
        """
        (share,) = self._at("margin", t, x, v)
        return share

    def margins(self, t: npt.ArrayLike, x: npt.ArrayLike, v: npt.ArrayLike | None = None) -> Array:
        """`margin` by component, which tells the axis that is near its edge: of shape (n,) or (P, n).

        Examples
        --------
        >>> [round(float(m), 2) for m in build("tasks/omni_s2.toml").margins(0.0, [0.1, 0.25])]
        [0.2, 0.5]
        """
        (shares,) = self._at("margins", t, x, v)
        return np.asarray(shares)

    def covered(self, x: npt.ArrayLike, v: npt.ArrayLike | None = None) -> Any:
        """Whether the guarantee covers a start at the measured x, of order 2 with its speed v: a truth value, or (P,) of them.
        With `control.period` that is the proof of sampling (P9), else Theorem 4.1 where the clamp does not act. Always false
        where the controller is not certified. Raises `BadInput` for adaptive and literal tubes, which have no such bounds.

        Examples
        --------
        >>> [bool(c) for c in build("tasks/omni_s2.toml").covered([[0.25, 0.25], [0.25, 0.499]])]
        [True, False]
        """
        if not self.design.capabilities.tells_covered_starts:
            raise BadInput(f"{self.task.name}: only a refined tube says which starts are covered; this one is {self.design.kind}")
        (inside,) = self._at("covered", 0.0, x, v)
        return inside

    def unwrap(self, x_before: npt.ArrayLike, x: npt.ArrayLike) -> Array:
        """A measured x with the turns of its closed axes counted on from x_before, the last unwrapped state and at first the
        initial one: what `control`, `margin` and `covered` take. Both of shape (n,). Raises `BadInput` where no axis closes."""
        if not self.task.closed:
            raise BadInput(f"{self.task.name}: no axis closes (periodic); take x as it is measured")
        before, state = as_floats("x_before", x_before), as_floats("x", x, finite=False)
        for label, values in (("x_before", before), ("x", state)):
            if values.shape != (self.task.dimension,):
                raise BadInput(
                    f"{label}: has shape {values.shape}; ({self.task.dimension},) is needed, one number for each dimension"
                )
        return np.asarray(self.module.unwrap(before.tolist(), state.tolist()))

    def distance(self, t: npt.ArrayLike, lower: npt.ArrayLike, upper: npt.ArrayLike) -> Array:
        """How far the tube's edges are, at most, from others at times t: by dimension, (n,), in the task's units."""
        times, single = self._times(t, finite=True)
        wanted = (self.task.dimension,) if single else (len(times), self.task.dimension)
        edges = [as_floats(name, value) for name, value in (("lower", lower), ("upper", upper))]
        for name, edge in zip(("lower", "upper"), edges, strict=True):
            if edge.shape != wanted:
                raise BadInput(f"{name}: has shape {edge.shape}; {wanted} is needed, one row for each time")
        far = np.abs(np.stack(self.tube(times[0] if single else times)) - np.stack(edges)).reshape(-1, self.task.dimension)
        found: Array = far.max(axis=0)
        return found

    def _times(self, t: npt.ArrayLike, finite: bool = False) -> tuple[Array, bool]:
        """As an array of one axis, and whether it was a number. Emitted functions take times that are not finite, too."""
        times = as_floats("t", t, finite)
        if times.ndim > 1 or not times.size:
            raise BadInput(f"t: has shape {times.shape}; a number or an array of one axis is needed, with one time or more")
        return np.atleast_1d(times), times.ndim == 0

    def _at(self, name: str, t: npt.ArrayLike, *state: npt.ArrayLike | None) -> list[Any]:
        """An emitted function at every time; outputs without the first axis where t is a number and x is one state."""
        times, single = self._times(t)
        n, arguments = self.task.dimension, list[Any]()
        given = [(label, v) for label, v in zip(("x", "v"), state, strict=False) if v is not None or self.task.order == 2]
        if len(given) > self.task.order:
            raise BadInput("v: the plant is of order 1, whose law takes x alone")
        for label, value in given:
            states = as_floats(label, np.nan if value is None else value, finite=False)
            if states.ndim not in (1, 2) or states.shape[-1] != n or (states.ndim == 2 and len(times) not in (1, len(states))):
                wanted = f"({n},) or ({'P' if single else len(times)}, {n})"
                told = "is missing" if value is None else f"has shape {states.shape}"
                raise BadInput(f"{label}: {told}; {wanted} is needed, one number for each dimension")
            single = single and states.ndim == 1
            count = len(states) if states.ndim == 2 else len(times)
            times, states = np.broadcast_to(times, count), np.broadcast_to(states, (count, n))
            arguments.append(states)
        if self.design.is_stateful:
            arguments = [np.atleast_2d(self.alpha(times)), *arguments]
        function = getattr(self.module, name)
        if self.program.tick is not None:
            columns = self._in_integers(name, times, arguments)
            return [c[0] for c in columns] if single else columns
        timed = name != "covered"
        rows = [function(*([float(v)] if timed else []), *(a[k] for a in arguments)) for k, v in enumerate(times)]
        several = isinstance(rows[0], tuple) and name != "margins"
        columns = [np.array(c) for c in zip(*rows, strict=True)] if several else [np.array(rows)]
        return [c[0] for c in columns] if single else columns

    def _in_integers(self, name: str, times: Array, states: list[Any]) -> list[Any]:
        """The emitted function of ticks and units at the nearest ones, and what it gives in the task's units."""
        assert self.program.tick is not None
        module, tick = self.module, float(self.program.tick)
        for label, values in (("t", times), *zip(("x", "v"), states, strict=False)):
            if not np.isfinite(values).all():
                raise BadInput(f"{label}: has a number that is not finite, which a controller in integers cannot be given")
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

    # ---- what one does with it

    def casadi(self) -> Mapping[str, Any]:
        """Every emitted function of seconds as a CasADi function, from the very statements that are printed, and the derivatives
        `du_dx` and `du_dt` of u. Columns in, columns out; call them with numbers, SX or MX.

        Keys: tube, tube_rate, control, margin, transform; for adaptive tubes, whose functions take alpha too, alpha_rate (the
        update equation and its Jacobian) and alpha_step.

        Examples
        --------
        u along a symbolic state, for an optimisation problem of one's own:

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
        found = {name: casadi_function(self.program, name) for name in names}
        law = found["control"]
        symbols = [ca.SX.sym(law.name_in(k), *law.size_in(k)) for k in range(law.n_in())]
        _, u = law(*symbols)
        for name, by in (("du_dx", "x"), ("du_dt", "t")):
            jacobian = ca.jacobian(u, symbols[law.index_in(by)])
            found[name] = ca.Function(name, symbols, [jacobian], law.name_in(), [name])
        return found

    def write(self, folder: str | Path) -> list[Path]:
        """Write the files into a folder, all or none.

        Returns
        -------
        list of Path
            What was written.

        Raises
        ------
        BadInput
            The folder cannot be written.

        Examples
        --------
        >>> import tempfile
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     [path.name for path in build("tasks/omni_s2.toml").write(folder)]
        ['omni_s2.h', 'omni_s2.c', 'omni_s2.py', 'omni_s2.certificate.json']
        """
        from stt_codegen.record import write_files

        write_files(Path(folder), self.files)
        return [Path(folder) / name for name in self.files]

    def plot(self, ax: Any = None) -> Any:
        """Draw the tube: the whole picture as a matplotlib Figure, or the arena alone into `ax`. No backend is changed.

        Examples
        --------
        >>> len(build("tasks/omni_s2.toml").plot().axes)
        3
        """
        from stt_codegen.report.pictures import draw_arena, draw_dimension, figure_of

        if ax is None:
            return figure_of(self)
        t = np.linspace(0.0, float(self.task.prescribed_time), 1801)
        low, high = self.design.edges_at(t)
        if self.task.dimension > 1:
            draw_arena(ax, self, low, high)
        else:
            draw_dimension(ax, self, 0, t, low, high)
        return ax

    def simulate(self, plant: Any = "integrator", **scenario: Any) -> Any:
        """Drive a plant with the compiled C, held between samples.

        Parameters
        ----------
        plant
            A name, the path of a Python file, or a `Plant`.
        scenario
            Fields of `loop.simulate.Scenario`: rate in Hz, disturbance, strength, noise, noise_v, lost, latency, lag, start,
            seed, clock. Rate, noise and latency that are not given are the task's (1 kHz, 0 and 0 where it says nothing).

        Returns
        -------
        Run
            With its trace: rows of t, x, u, lower, upper, w, status.

        Raises
        ------
        BadInput
            A scenario or a plant that is none.
        MissingTool
            There is no C compiler.

        Examples
        --------
        >>> build("tasks/omni_s2.toml").simulate(rate=1000).good
        True
        """
        from stt_codegen.loop import Loop, Scenario, of_task
        from stt_codegen.plants import plant_of

        model = plant_of(plant, self.task.dimension, self.task.order) if isinstance(plant, str) else plant
        if not all(hasattr(model, name) for name in ("name", "f", "g", "w_max", "dimension", "order", "constants", "mixing")):
            raise BadInput(f"plant: is a {type(plant).__name__}; a name, a Python file or a `stt_codegen.plants.Plant` is needed")
        try:
            asked = Scenario(**{**of_task(self.task), **scenario})
        except TypeError:
            known = [one.name for one in fields(Scenario)]
            wrong = [name for name in scenario if name not in known] or list(scenario)
            raise BadInput(f"simulate: {wrong[0]}: is not understood; known are {', '.join(known)}") from None
        return Loop(self, model).run(asked, trace=True)

    def report(self, path: str | Path | None = None, *, plant: str | None = None, show: bool = True) -> Path:
        """Write the page that `stt-codegen report` writes, and open it in a browser.

        Parameters
        ----------
        path
            The page; by default <name>.report.html in the current folder.
        plant
            What is driven in the page and what its statements are about, by name or Python file; by default [plant].
        show
            Whether to open it.

        Returns
        -------
        Path
            The page that was written.

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

        from stt_codegen.plants import plant_of
        from stt_codegen.record import write_files
        from stt_codegen.report import design_report
        from stt_codegen.report.page import evidence, page

        model = None if plant is None else plant_of(plant, self.task.dimension, self.task.order)
        made = Path(path) if path is not None else Path(f"{self.task.name}.report.html")
        write_files(made.parent, {made.name: page(self, design_report(self, 0.0), evidence(self, self.source), model)})
        if show:
            webbrowser.open(made.resolve().as_uri())
        return made
