"""The question: state space, unsafe sets, initial set, target set, prescribed time (design words: X, U_j, X0, T, t_c).

A frozen `Task` of frozen tables. Decimals stay exact: every number is a `Fraction`. `values.py` has the kinds of numbers,
`load.py` makes a task of a file, `checks/field_checks.py` looks at how the fields fit together.

Long because every field of a task file stands here once, and what is made of it.
"""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field, StrictBool, create_model

from stt_codegen.design_kinds import CAPABILITIES, Capabilities, DesignKind
from stt_codegen.program.targets import optional_targets
from stt_codegen.properties import Property
from stt_codegen.task.mission import AnyRegion, Formula, MissionEntry, RegionUnion, conjunction, expand_unions, with_states
from stt_codegen.task.sets import (
    AnyUnsafe,
    Box,
    BoxSet,
    ConvexSet,
    Course,
    HalfSpace,
    Region,
    StateSpace,
    Table,
    Target,
    Unsafe,
    UnsafeSet,
    course_of,
)
from stt_codegen.task.values import (
    MAX_NAME,
    Each,
    EachOrAuto,
    GainOrAuto,
    Labels,
    NotNegative,
    PeriodOfAxis,
    Positive,
    Vector,
    below_one,
    whole,
)

Scalar = Literal["float", "double", "fixed"]
Preference = Literal["balanced", "slow", "wide", "period"]
Outside = Literal["return", "hold", "stop"]
PLANT_BOUNDS = ("f_max", "w_max", "g_min", "g_max", "g_cross")  # keys of [plant] that are one number, or one for each component
EmitOptionsType = TypeVar("EmitOptionsType", bound=Table)


class InitialSet(Box):
    """The initial set X0, and the starts that statements about sampling are for."""

    share: Annotated[Positive, AfterValidator(below_one)] = Field(
        default=Fraction(9, 10), description="starts that sampling is proved for: this share of gamma(0)'s half widths"
    )
    speed: Each | None = Field(default=None, description="bound on the speed of these starts, for order 2; absent: at rest")


def _from_box(value: object) -> object:
    """A `Box` or a `Region` will do, from Python."""
    if isinstance(value, Box) and type(value) in (Box, Region):
        return {name: getattr(value, name) for name in value.model_fields_set}
    return value


class AdaptiveOptions(Table):
    """Parameters of the paper's functions (7)-(11). Absent: adaptive lets the search choose, literal takes the case study's."""

    bump_steepness: Positive | None = Field(default=None, description="k^j of (7); literal only: 0.01")
    overshoot: Positive | None = Field(default=None, description="delta B of (7), units; literal 0.2")
    theta0: Positive | None = Field(default=None, description="theta_0 of (11), units cubed per second; literal 0.01")
    kappa: Positive | None = Field(default=None, description="decay of alpha in (11), 1/s; literal 5")
    mu: Positive | None = Field(default=None, description="tolerance of the trigger in (11), units; literal 1")
    varsigma: Positive | None = Field(default=None, description="steepness of the trigger's tanh, 1/units; literal 100")
    nu: Positive | None = Field(default=None, description="sharpness of smooth max and min, 1/units; literal 100")
    target_margin: NotNegative | None = Field(default=None, description="inset of That, units; adaptive only")


class TubeOptions(Table):
    """How the tube is designed."""

    design: DesignKind = "refined"
    clearance: NotNegative = Field(default=Fraction(3, 100), description="kept between tube and unsafe sets")
    min_width: NotNegative = Field(default=Fraction(5, 100), description="least width of the tube in each dimension")
    prefer: Preference = Field(default="balanced", description="what a refined tube gives up the rest for")
    max_speed: Each | None = Field(default=None, description="bound on the speed of every edge, or one for each component")
    max_acceleration: Each | None = Field(
        default=None, description="bound on the acceleration of every edge, or one for each component; refined only"
    )
    filter: EachOrAuto | None = Field(
        default=None, description='lambda of order 2, in 1/s: what is held is v + lambda x; "auto" or absent: chosen'
    )
    segments: Annotated[int, BeforeValidator(whole)] | None = Field(
        default=None, ge=4, le=8192, description="spline segments; chosen when absent"
    )
    seed: Annotated[int, BeforeValidator(whole)] = Field(default=0, ge=0, description="literal design: the random sides")
    adaptive: AdaptiveOptions = AdaptiveOptions()

    @property
    def capabilities(self) -> Capabilities:
        """What the kind of tube that is asked for offers."""
        return CAPABILITIES[self.design]


class ControlOptions(Table):
    """The control law (13)."""

    gain: GainOrAuto | None = Field(
        default=None,
        description='k, or one for each component; negative where g_s is negative definite (Remark 4.2); "auto": most room at '
        'control.period; absent: 0.5, or "auto" with a period',
    )
    e_max: Each = Field(
        default=Fraction(99, 100), description="clamp of the normalized error, in (0, 1), or one for each component"
    )
    u_max: Each | None = Field(default=None, description="saturation of the emitted u, or one bound for each component")
    saturate: Literal["clip", "scale"] = Field(
        default="clip", description="how u_max limits u: each component, or all of u by one factor, for g that couples"
    )
    period: Positive | None = Field(
        default=None, description=f"seconds between samples; proved ({Property.PERIOD.code}), or the task is refused"
    )
    latency: NotNegative = Field(default=Fraction(0), description="seconds from a sample to the input that it makes, at most")
    velocity: Literal["measured", "differences"] = Field(
        default="measured", description="for order 2, where v is from: a sensor, or differences of measured x"
    )
    period_min: Positive | None = Field(
        default=None, description="seconds between samples at least, where v is of differences; absent: half of the period"
    )
    outside: Outside = Field(
        default="return", description="once the tube is left: u pushes back, the tube waits, or u is 0 until it is reset"
    )


def _with_language_keys(options: type[EmitOptionsType]) -> type[EmitOptionsType]:
    """Return the table with a key more for each target language that a task has to ask for."""
    keys: dict[str, Any] = {t.key: (StrictBool, Field(default=False, description=t.option)) for t in optional_targets()}
    return create_model(options.__name__, __base__=options, __module__=options.__module__, __doc__=options.__doc__, **keys)


@_with_language_keys
class EmitOptions(Table):
    """What the C looks like."""

    scalar: Scalar = "float"
    math: Literal["libm", "inline"] = "libm"
    tick_period: Positive | None = Field(default=None, description="seconds; adds an entry point with an integer tick")
    selftest: StrictBool = Field(default=False, description="adds <name>_selftest.c for the board's boot")


class PlantBounds(Table):
    """Bounds on the plant for the effort and sampling statements; the controller itself needs none of them."""

    order: Annotated[int, BeforeValidator(whole)] = Field(
        default=1, ge=1, le=2, description="1: u makes speeds; 2: accelerations, and the bounds here are of these"
    )
    f_max: Each | None = Field(default=None, description="bound on |f|, or one on each |f_i|; absent: 0")
    w_max: Each | None = Field(default=None, description="bound on |w|, or one on each |w_i|; absent: 0")
    g_min: Each | None = Field(
        default=None, description="bound on g_s from below, or one on each g_ii; absent: 1, or g_max where that is less"
    )
    g_max: Each | None = Field(
        default=None, description="bound on |g|, or one on each g_ii; absent: 1, or g_min where that is more"
    )
    g_cross: Each | None = Field(
        default=None, description="bound on every |g_ij|, i not j, or one for each row i; absent: 0, no coupling"
    )
    noise: NotNegative | None = Field(default=None, description="bound on the error of every measured x_i; absent: 0")
    noise_v: NotNegative | None = Field(
        default=None, description="bound on the error of every measured v_i, for order 2; absent: 0"
    )

    @property
    def bounds(self) -> dict[str, Fraction | tuple[Fraction, ...] | None]:
        """What the task says of each bound, those of order 2 only there."""
        names = (*PLANT_BOUNDS, "noise", *(("noise_v",) if self.order == 2 else ()))
        return {name: getattr(self, name) for name in names}

    @property
    def is_stated(self) -> bool:
        """Whether the task says anything about the plant but its order."""
        return any(v is not None for v in self.bounds.values())


@dataclass(frozen=True)
class ComponentBounds:
    """What [plant] says of component i: |f_i + w_i| <= force, g_min <= g_ii <= g_max, |g_ij| <= cross; -g for k < 0."""

    force: Fraction
    g_min: Fraction
    g_max: Fraction
    cross: Fraction


def _named(sets: tuple[AnyUnsafe, ...]) -> tuple[AnyUnsafe, ...]:
    """With U1, U2, ... for those without a name; the name that was not given does not count as data."""
    named = []
    for j, one in enumerate(sets, 1):
        copy = one.model_copy()
        given = "name" in one.model_fields_set and one.name  # of a set from another task the name may be its number there
        copy.__dict__["name"] = given or f"U{j}"
        named.append(copy)
    return tuple(named)


class TaskTables(Table):
    """All tables of a task, and the sets that they describe. Users have `Task`, which is checked."""

    name: str = Field(description="prefix of every emitted identifier", pattern="^[A-Za-z][A-Za-z0-9_]*$", max_length=MAX_NAME)
    axes: Labels | None = Field(default=None, description="names of the dimensions in messages, pictures and comments: x1, ..")
    units: Labels | None = Field(default=None, description="unit of each dimension there; an empty text for none")
    periodic: PeriodOfAxis | None = Field(
        default=None, description="axes that close, by name, each with its period in the axis's unit: an angle's 2 pi"
    )
    prescribed_time: Positive = Field(description="t_c, seconds")
    repeat: StrictBool = Field(
        default=False, description="for ever: after a lead-in the tube is periodic, and t_c is the end of its first cycle"
    )
    initial_state: Vector = Field(description="x(0), strictly inside the initial set")
    state_space: Annotated[StateSpace, BeforeValidator(_from_box)]
    initial_set: Annotated[InitialSet, BeforeValidator(_from_box)]
    target_set: Annotated[Target, BeforeValidator(_from_box)] | None = Field(
        default=None, description="where the tube is at t_c; may be left out where there is a mission"
    )
    body: Vector | None = Field(default=None, description="half extents of the robot")
    start_delay: NotNegative = Field(
        default=Fraction(0), description="seconds by which the controller may start late against the sets' clock"
    )
    unsafe: Annotated[tuple[AnyUnsafe, ...], AfterValidator(_named)] = ()
    region: tuple[AnyRegion, ...] = Field(default=(), description="named sets that missions speak of")
    mission: tuple[MissionEntry, ...] = Field(default=(), description="what must hold beside reach, avoid and stay, every entry")
    tube: TubeOptions = TubeOptions()
    control: ControlOptions = ControlOptions()
    emit: EmitOptions = EmitOptions()
    plant: PlantBounds = PlantBounds()

    @property
    def dimension(self) -> int:
        """n, the number of state components."""
        return len(self.state_space.lower)

    @property
    def axis_names(self) -> tuple[str, ...]:
        """What the dimensions are called: `axes`, or x1, x2, ..."""
        return self.axes or tuple(f"x{i + 1}" for i in range(self.dimension))

    @property
    def axis_labels(self) -> tuple[str, ...]:
        """The same with their units, as in heading [rad]."""
        units = self.units or ("",) * self.dimension
        return tuple(f"{name} [{unit}]" if unit else name for name, unit in zip(self.axis_names, units, strict=True))

    @property
    def axis_words(self) -> tuple[str, ...]:
        """How a sentence names them: "axis heading", or "dimension 3" where they have no names."""
        return tuple(f"axis {a}" for a in self.axes) if self.axes else tuple(f"dimension {i + 1}" for i in range(self.dimension))

    def _each(self, value: Fraction | tuple[Fraction, ...]) -> tuple[Fraction, ...]:
        return value if isinstance(value, tuple) else (value,) * self.dimension

    @property
    def has_automatic_gain(self) -> bool:
        """Whether the pipeline has to choose the gain: "auto"."""
        given = self.control.gain
        return given == "auto" or (given is None and self.control.period is not None)

    @property
    def gain(self) -> tuple[Fraction, ...]:
        """k by component; where it has to be chosen and is not yet, 1/2."""
        given = self.control.gain
        return self._each(Fraction(1, 2) if given is None or isinstance(given, str) else given)

    @property
    def e_max(self) -> tuple[Fraction, ...]:
        """The clamp of the normalized error by component."""
        return self._each(self.control.e_max)

    @property
    def u_max(self) -> tuple[Fraction, ...] | None:
        """The saturation of u by component; None for none."""
        return None if self.control.u_max is None else self._each(self.control.u_max)

    @property
    def plant_bounds(self) -> tuple[ComponentBounds, ...]:
        """[plant] by component. Where g_min or g_max is missing it is 1, or the other one where 1 contradicts it."""
        found, plant = [], self.plant
        given = [(None,) * self.dimension if v is None else self._each(v) for v in (plant.g_min, plant.g_max)]
        force, wind, cross = (self._each(v or Fraction(0)) for v in (plant.f_max, plant.w_max, plant.g_cross))
        for i, (low, high) in enumerate(zip(*given, strict=True)):
            least = low if low is not None else min(Fraction(1), high or Fraction(1))
            most = high if high is not None else max(Fraction(1), least)
            found.append(ComponentBounds(force[i] + wind[i], least, most, cross[i]))
        return tuple(found)

    @property
    def disturbance_bound(self) -> Fraction:
        """The largest norm of w that is within plant.w_max whatever its direction."""
        return min(self._each(self.plant.w_max or Fraction(0)))

    @property
    def is_coupled(self) -> bool:
        """Whether [plant] lets inputs push other components than their own."""
        return any(b.cross for b in self.plant_bounds)

    @property
    def scales_input(self) -> bool:
        """Whether u is limited as a whole."""
        return self.control.saturate == "scale"

    @property
    def requires_input_limits(self) -> bool:
        """Whether P8 is asked for: u is limited, the plant has bounds, and no period is to be proved, which asks for more."""
        bounded = any(getattr(self.plant, name) is not None for name in PLANT_BOUNDS)
        return self.control.u_max is not None and bounded and self.control.period is None and self.tube.capabilities.proves_limits

    @property
    def max_speed(self) -> tuple[Fraction, ...] | None:
        """The bound on the speed of the tube's edges by dimension; None for none."""
        return None if self.tube.max_speed is None else self._each(self.tube.max_speed)

    @property
    def order(self) -> int:
        """Of the plant: 1 where u makes speeds, 2 where it makes accelerations."""
        return self.plant.order

    @property
    def filter(self) -> tuple[Fraction, ...] | None:
        """lambda by component; None where it is to be chosen."""
        given = self.tube.filter
        return None if given is None or isinstance(given, str) else self._each(given)

    @property
    def start_speed(self) -> tuple[Fraction, ...]:
        """The bound on the speed at the start, by component."""
        return self._each(self.initial_set.speed or Fraction(0))

    @property
    def max_acceleration(self) -> tuple[Fraction, ...] | None:
        """The bound on the acceleration of the tube's edges by dimension; None for none."""
        return None if self.tube.max_acceleration is None else self._each(self.tube.max_acceleration)

    @property
    def sampling_period(self) -> Fraction:
        """Seconds between samples: control.period, else emit.tick_period, else a millisecond."""
        return self.control.period or self.emit.tick_period or Fraction(1, 1000)

    @property
    def uses_differences(self) -> bool:
        """Whether v is of differences of measured x."""
        return self.control.velocity == "differences"

    @property
    def shortest_period(self) -> Fraction:
        """Seconds between samples at least, where v is of differences."""
        return self.control.period_min or self.sampling_period / 2

    @property
    def half_extents(self) -> tuple[Fraction, ...]:
        """The robot's half extents by dimension; 0 for a point."""
        return self.body or (Fraction(0),) * self.dimension

    @property
    def free_space(self) -> BoxSet:
        """The state space shrunk by `body`: where the robot's reference point may be."""
        return self.state_space.convex().grown([-h for h in self.half_extents])

    @property
    def start(self) -> BoxSet:
        """The initial set X0."""
        return self.initial_set.convex()

    @property
    def target_at_rest(self) -> BoxSet:
        """The target set, or the box that is cut to it, before it is displaced."""
        target = self.target_set
        return self.free_space if target is None else target.box(self.free_space, self.axis_indices(target))

    @property
    def target(self) -> BoxSet:
        """The target set T at t_c, or the box that is cut to it."""
        box = self.target_at_rest
        by = self.target_course.displacement(self.prescribed_time)
        lower, upper = (tuple(v + d for v, d in zip(edges, by, strict=True)) for edges in (box.lower, box.upper))
        return BoxSet(lower, upper)

    @property
    def space_cuts(self) -> tuple[HalfSpace, ...]:
        """The half-spaces that cut the state space, moved in by `body`."""
        half = self.half_extents
        given = self.state_space.cuts(self.axis_indices(self.state_space), self.dimension)
        return tuple((n, h - sum((abs(c) * v for c, v in zip(n, half, strict=True)), Fraction(0))) for n, h in given)

    @property
    def target_cuts(self) -> tuple[HalfSpace, ...]:
        """The half-spaces that cut the target set at t_c."""
        if self.target_set is None:
            return self.space_cuts
        by = self.target_course.displacement(self.prescribed_time)
        given = self.target_set.cuts(self.axis_indices(self.target_set), self.dimension)
        return tuple((n, h + sum((c * v for c, v in zip(n, by, strict=True)), Fraction(0))) for n, h in given)

    @property
    def target_course(self) -> Course:
        """How the target moves."""
        return self._course(self.target_set or self.state_space, None, Fraction(0), Fraction(0))

    @property
    def courses(self) -> tuple[Course | None, ...]:
        """How each of the unsafe sets moves, and when it is unsafe; None for one that is the same at all times."""
        return tuple(
            self._course(s, s.during, s.timing or Fraction(0), s.spread or Fraction(0)) if s.is_timed else None
            for s in self.unsafe
        )

    @property
    def has_timed_sets(self) -> bool:
        """Whether the clock of the sets matters: some unsafe set is not always the same, or the target moves."""
        return any(s.is_timed for s in self.unsafe) or self.has_moving_target

    @property
    def has_moving_target(self) -> bool:
        """Whether the target is displaced."""
        return self.target_set is not None and self.target_set.motion is not None

    @property
    def regions(self) -> dict[str, Unsafe | RegionUnion]:
        """The named regions."""
        return {one.name: one for one in self.region}

    @property
    def formulas(self) -> tuple[Formula, ...]:
        """Every entry of the mission as a formula about states."""
        regions = self.regions
        boxes = frozenset(name for name, one in regions.items() if isinstance(one, UnsafeSet))
        meanings = (e.meaning(self.prescribed_time, self.repeat) for e in self.mission)
        return tuple(with_states(expand_unions(one, regions), boxes) for one in meanings)

    @property
    def formula(self) -> Formula | None:
        """The mission, all of its entries; None where there is none."""
        return conjunction(*self.formulas) if self.mission else None

    def _course(self, table: Unsafe | Region, during: Vector | None, timing: Fraction, spread: Fraction) -> Course:
        """Return the course of a set from what its table says of its time."""
        axes, motion = self.axis_indices(table), getattr(table, "motion", None)
        knots = [(p.at, dict(zip(axes, p.by, strict=True))) for p in motion or ()] or [(Fraction(0), {})]
        return course_of(
            knots=tuple((at, tuple(by.get(i, Fraction(0)) for i in range(self.dimension))) for at, by in knots),
            active_interval=None if during is None else (during[0], during[1]),
            clock_lag=timing,
            clock_lead=timing + self.start_delay,
            spread=spread,
            t_c=self.prescribed_time,
        )

    @property
    def unsafe_sets(self) -> tuple[ConvexSet, ...]:
        """The unsafe sets as they are, in the order of the file."""
        return tuple(s.to_set_in(self.state_space, self.axis_indices(s)) for s in self.unsafe)

    def unsafe_field(self, j: int) -> str:
        """Where the file has unsafe set j."""
        return f"unsafe[{j}]"

    def axis_indices(self, table: Unsafe | Region) -> tuple[int, ...]:
        """The dimensions that a set is in; its axes are known to be of the task's."""
        return tuple(self.axis_names.index(name) for name in table.axes or self.axis_names)

    @property
    def obstacles(self) -> tuple[ConvexSet, ...]:
        """The unsafe sets grown by `body`, in the order of the file."""
        return tuple(s.grown(self.half_extents) for s in self.unsafe_sets)
