"""The schema of a task: state space X, unsafe sets U_j, initial set X0, target set T, prescribed time t_c, and all options.

The tables are frozen, and decimals stay exact: every number is a `Fraction`. `values.py` has the types of the fields, `load.py`
reads a file, `checks/field_checks.py` checks how the fields fit together. `TaskTables` also computes the sets of the task, which
all later stages read.

Long because every key of a task file stands here once, with the quantities that follow from it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Annotated, Any, Literal, TypeVar

from pydantic import AfterValidator, BeforeValidator, Field, StrictBool, create_model

from stt_codegen.design_kinds import CAPABILITIES, Capabilities, DesignKind, kinds_offering
from stt_codegen.program import round_down
from stt_codegen.program.targets import optional_targets
from stt_codegen.properties import Property
from stt_codegen.task.input_norm import is_within_norm
from stt_codegen.task.mission import (
    AnyRegion,
    Formula,
    MissionEntry,
    RegionUnion,
    conjunction,
    expand_unions,
    with_state_formulas,
)
from stt_codegen.task.sets import (
    AnyUnsafe,
    Box,
    BoxSet,
    ConvexSet,
    Course,
    HalfSpace,
    Region,
    StateSpace,
    Target,
    TomlTable,
    Unsafe,
    UnsafeSet,
    course_of,
)
from stt_codegen.task.values import (
    MAX_NAME,
    GainOrAuto,
    Labels,
    NotNegative,
    NotNegativePerComponent,
    Number,
    PerComponent,
    PerComponentOrAuto,
    PeriodOfAxis,
    Positive,
    Vector,
    at_least_one,
    below_one,
    read_integer,
)

Scalar = Literal["float", "double", "fixed"]
Preference = Literal["balanced", "slow", "wide", "period"]
Outside = Literal["return", "hold", "stop"]
PLANT_BOUNDS = ("f_max", "w_max", "g_min", "g_max", "g_cross")  # keys of [plant] that are one number, or one for each component
DRIVE_BOUNDS = ("lag", "lag2", "slew", "overshoot")  # keys of [plant] about what acts of u, one number or one for each component
EmitOptionsType = TypeVar("EmitOptionsType", bound=TomlTable)


class InitialSet(Box):
    """The initial set X0, and the start share: the starts for which sampling is proved."""

    share: Annotated[Positive, AfterValidator(below_one)] = Field(
        default=Fraction(9, 10), description="start share: sampling is proved from this share of gamma(0)'s half widths"
    )
    speed: PerComponent | None = Field(
        default=None, description="bound on the speed of these starts, for order 2; absent: at rest"
    )


def _from_box(value: object) -> object:
    """Return the fields of a plain `Box` or `Region` from Python, so that it may stand for a table with more keys."""
    if isinstance(value, Box) and type(value) in (Box, Region):
        return {name: getattr(value, name) for name in value.model_fields_set}
    return value


class AdaptiveOptions(TomlTable):
    """Parameters of the paper's functions (7)-(11). If absent, the adaptive design chooses them by search, and the literal design
    takes those of the paper's case study."""

    bump_steepness: Positive | None = Field(default=None, description="k^j of (7); literal only: 0.01")
    overshoot: Positive | None = Field(default=None, description="delta B of (7), units; literal 0.2")
    theta0: Positive | None = Field(default=None, description="theta_0 of (11), units cubed per second; literal 0.01")
    kappa: Positive | None = Field(default=None, description="decay of alpha in (11), 1/s; literal 5")
    mu: Positive | None = Field(default=None, description="tolerance of the trigger in (11), units; literal 1")
    varsigma: Positive | None = Field(default=None, description="steepness of the trigger's tanh, 1/units; literal 100")
    nu: Positive | None = Field(default=None, description="sharpness of smooth max and min, 1/units; literal 100")
    target_margin: NotNegative | None = Field(default=None, description="inset of That, units; adaptive only")


class TubeOptions(TomlTable):
    """How the tube is designed."""

    design: DesignKind = "refined"
    clearance: NotNegativePerComponent = Field(
        default=Fraction(3, 100), description="distance between tube and unsafe sets, or one for each component"
    )
    min_width: NotNegativePerComponent = Field(
        default=Fraction(5, 100), description="minimum width of the tube in each dimension, or one for each component"
    )
    prefer: Preference = Field(
        default="balanced", description=f"the quality for which a {kinds_offering('offers_widths')} tube gives up the others"
    )
    max_speed: PerComponent | None = Field(
        default=None, description="bound on the speed of every edge, or one for each component"
    )
    max_acceleration: PerComponent | None = Field(
        default=None,
        description="bound on the acceleration of every edge, or one for each component; "
        f"{kinds_offering('bounds_acceleration')} only",
    )
    filter: PerComponentOrAuto | None = Field(
        default=None, description='filter rate lambda for order 2, in 1/s: v + lambda x has a tube too; "auto" or absent: chosen'
    )
    segments: Annotated[int, BeforeValidator(read_integer)] | None = Field(
        default=None, ge=4, le=8192, description="spline segments; chosen when absent"
    )
    seed: Annotated[int, BeforeValidator(read_integer)] = Field(default=0, ge=0, description="literal design: the random sides")
    adaptive: AdaptiveOptions = AdaptiveOptions()

    @property
    def capabilities(self) -> Capabilities:
        """What the chosen kind of tube offers."""
        return CAPABILITIES[self.design]


class ControlOptions(TomlTable):
    """The control law (13)."""

    gain: GainOrAuto | None = Field(
        default=None,
        description='k, or one for each component; negative where g_s is negative definite (Remark 4.2); "auto": the gentlest '
        'that is proved for control.period with a reserve; "tight": the one that keeps |e| smallest; absent: 0.5, or "auto" with '
        "a period",
    )
    rest: Annotated[Positive, AfterValidator(below_one)] | None = Field(
        default=None, description='gain "auto": the |e| within which a steady disturbance rests; absent: 0.7'
    )
    reserve: Annotated[Number, AfterValidator(at_least_one)] | None = Field(
        default=None, description='gain and u_max "auto": times plant.f_max and w_max for which they are proved; absent: 1.5'
    )
    e_max: PerComponent = Field(
        default=Fraction(99, 100), description="clamp of the normalized error, in (0, 1), or one for each component"
    )
    u_max: PerComponentOrAuto | None = Field(
        default=None,
        description='saturation of the emitted u, or one bound for each component; "auto": 1.5 times what is needed, more '
        'with a lag, less where only that is proved; absent: none, or "auto" with a period',
    )
    u_norm: Positive | None = Field(
        default=None,
        description="bound on the Euclidean norm of u, all components; each component is limited to the share that it needs",
    )
    saturate: Literal["clip", "scale"] = Field(
        default="clip", description="how u_max limits u: each component, or all of u by one factor, for g that couples"
    )
    period: Positive | None = Field(
        default=None,
        description=f"sampling period: seconds between samples; proved ({Property.PERIOD.code}), or the task is refused",
    )
    latency: NotNegative = Field(default=Fraction(0), description="input delay: seconds from a sample to its input, at most")
    velocity: Literal["measured", "differences"] = Field(
        default="measured", description="source of v for order 2: a sensor, or differences of measured x"
    )
    period_min: Positive | None = Field(
        default=None, description="seconds between samples at least, where v is of differences; absent: half of the period"
    )
    outside: Outside = Field(
        default="return", description="once x is outside the tube: u pushes back, the tube waits, or u is 0 until a reset"
    )


def _with_language_keys(options: type[EmitOptionsType]) -> type[EmitOptionsType]:
    """Return the table with one more key for each target language that is not printed by default."""
    keys: dict[str, Any] = {t.key: (StrictBool, Field(default=False, description=t.option)) for t in optional_targets()}
    return create_model(options.__name__, __base__=options, __module__=options.__module__, __doc__=options.__doc__, **keys)


@_with_language_keys
class EmitOptions(TomlTable):
    """What the C looks like."""

    scalar: Scalar = "float"
    math: Literal["libm", "inline"] = "libm"
    tick_period: Positive | None = Field(default=None, description="seconds; adds an entry point with an integer tick")
    selftest: StrictBool = Field(default=False, description="adds <name>_selftest.c for the board's boot")


class PlantBounds(TomlTable):
    """Bounds on the plant for the effort and sampling statements; the controller itself needs none of them.

    With control.period, order 1 and no bound stated, a plant is assumed: `Task.assumes_plant`.
    """

    order: Annotated[int, BeforeValidator(read_integer)] = Field(
        default=1, ge=1, le=2, description="1: u makes speeds; 2: accelerations, and the bounds here are of these"
    )
    f_max: PerComponent | None = Field(default=None, description="bound on |f|, or one on each |f_i|; absent: 0")
    w_max: PerComponent | None = Field(default=None, description="bound on |w|, or one on each |w_i|; absent: 0")
    g_min: PerComponent | None = Field(
        default=None, description="bound on g_s from below, or one on each g_ii; absent: 1, or g_max where that is less"
    )
    g_max: PerComponent | None = Field(
        default=None, description="bound on |g|, or one on each g_ii; absent: 1, or g_min where that is more"
    )
    g_cross: PerComponent | None = Field(
        default=None, description="bound on every |g_ij|, i not j, or one for each row i; absent: 0, no coupling"
    )
    lag: PerComponent | None = Field(
        default=None, description="seconds: what acts of u is never behind a first-order lag of so long; absent: u acts at once"
    )
    lag2: PerComponent | None = Field(default=None, description="seconds: a second lag in series, of a filter or a bus")
    slew: PerComponent | None = Field(
        default=None, description="units of u a second: the rate at which what acts follows u at least; absent: at once"
    )
    overshoot: PerComponent | None = Field(
        default=None, description="share of a step of u by which what acts overshoots at most, in [0, 1); absent: 0"
    )
    noise: NotNegativePerComponent | None = Field(
        default=None, description="bound on the error of every measured x_i, or one for each component; absent: 0"
    )
    noise_v: NotNegativePerComponent | None = Field(
        default=None, description="bound on the error of every measured v_i, or one for each component, for order 2; absent: 0"
    )
    exact: StrictBool = Field(
        default=False, description="the plant is x' = u and no other: f = w = 0, g = 1; else control.period assumes a plant"
    )

    @property
    def bounds(self) -> dict[str, Fraction | tuple[Fraction, ...] | None]:
        """The bounds by their keys, None where the task has none; `noise_v` only for order 2, a drive's only where stated."""
        stated = tuple(name for name in DRIVE_BOUNDS if getattr(self, name) is not None)
        names = (*PLANT_BOUNDS, "noise", *(("noise_v",) if self.order == 2 else ()), *stated)
        return {name: getattr(self, name) for name in names}

    @property
    def is_stated(self) -> bool:
        """Whether the task has any plant bound."""
        return any(v is not None for v in self.bounds.values())


@dataclass(frozen=True)
class ComponentBounds:
    """The plant bounds of component i: |f_i + w_i| <= force, g_min <= g_ii <= g_max, |g_ij| <= cross; of -g where k < 0."""

    force: Fraction
    g_min: Fraction
    g_max: Fraction
    cross: Fraction


@dataclass(frozen=True)
class DriveBounds:
    """What [plant] states about the drive of component i; 0 stands for no lag and no overshoot, None for no limit of the rate."""

    lag: Fraction
    lag2: Fraction
    slew: Fraction | None
    overshoot: Fraction

    @property
    def acts_at_once(self) -> bool:
        """Whether what acts is what is commanded."""
        return not (self.lag or self.lag2 or self.overshoot) and self.slew is None

    @property
    def amplification(self) -> Fraction:
        """The largest |y|/|u|, y being what acts: 1 + 2 (M + M^2 + ..) for an overshoot by the share M."""
        return 1 + 2 * self.overshoot / (1 - self.overshoot)


def _named(sets: tuple[AnyUnsafe, ...]) -> tuple[AnyUnsafe, ...]:
    """Return the sets, those without a name called U1, U2, ..; such a default is no data of the task, so no digest has it."""
    named = []
    for j, unsafe in enumerate(sets, 1):
        copy = unsafe.model_copy()
        # a set that was copied from another task may carry the default of its index there
        stated_name = unsafe.name if "name" in unsafe.model_fields_set else ""
        copy.__dict__["name"] = stated_name or f"U{j}"
        named.append(copy)
    return tuple(named)


class TaskTables(TomlTable):
    """All tables of a task, and the sets and bounds that they describe. Users have its checked subclass `Task`."""

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
    region: tuple[AnyRegion, ...] = Field(default=(), description="named sets for missions")
    mission: tuple[MissionEntry, ...] = Field(default=(), description="entries that must all hold, beside reach, avoid and stay")
    tube: TubeOptions = TubeOptions()
    control: ControlOptions = ControlOptions()
    emit: EmitOptions = EmitOptions()
    plant: PlantBounds = PlantBounds()

    @property
    def dimension(self) -> int:
        """The number n of state components."""
        return len(self.state_space.lower)

    @property
    def axis_names(self) -> tuple[str, ...]:
        """The names of the dimensions: `axes`, or x1, x2, .. without it."""
        return self.axes or tuple(f"x{i + 1}" for i in range(self.dimension))

    @property
    def axis_labels(self) -> tuple[str, ...]:
        """The names of the dimensions with their units, as in heading [rad]."""
        units = self.units or ("",) * self.dimension
        return tuple(f"{name} [{unit}]" if unit else name for name, unit in zip(self.axis_names, units, strict=True))

    @property
    def axis_words(self) -> tuple[str, ...]:
        """The dimensions as a sentence names them: "axis heading", or "dimension 3" where they have no names."""
        return tuple(f"axis {a}" for a in self.axes) if self.axes else tuple(f"dimension {i + 1}" for i in range(self.dimension))

    def _per_component(self, value: Fraction | tuple[Fraction, ...]) -> tuple[Fraction, ...]:
        """Return one number for each component."""
        return value if isinstance(value, tuple) else (value,) * self.dimension

    @property
    def has_automatic_gain(self) -> bool:
        """Whether the pipeline has to choose the gain: it is "auto" or "tight", or absent beside a period."""
        gain = self.control.gain
        return isinstance(gain, str) or (gain is None and self.control.period is not None)

    @property
    def has_automatic_limit(self) -> bool:
        """Whether the pipeline has to choose u_max: it is "auto", absent beside a period or u_norm, or beyond u_norm."""
        limits, norm = self._limits_in(self.control), self.control.u_norm
        if limits is None:
            return self.control.u_max is not None or self.control.period is not None or norm is not None
        return norm is not None and not is_within_norm(limits, norm)

    @property
    def resting_error(self) -> Fraction:
        """The |e| within which a steady disturbance rests at a gain that is chosen."""
        return self.control.rest or Fraction(7, 10)

    @property
    def reserve(self) -> Fraction:
        """The factor of f_max and w_max for which a gain and a limit of u are chosen."""
        return self.control.reserve or Fraction(3, 2)

    @property
    def gain(self) -> tuple[Fraction, ...]:
        """The gain k by component; 1/2 while it is not chosen."""
        gain = self.control.gain
        return self._per_component(Fraction(1, 2) if gain is None or isinstance(gain, str) else gain)

    @property
    def e_max(self) -> tuple[Fraction, ...]:
        """The clamp of the normalized error by component."""
        return self._per_component(self.control.e_max)

    @property
    def u_max(self) -> tuple[Fraction, ...] | None:
        """The saturation of u by component; None for none, and while it is not chosen."""
        return None if self.has_automatic_limit else self._limits_in(self.control)

    @property
    def stated_u_max(self) -> tuple[Fraction, ...] | None:
        """The numbers of control.u_max by component, of which u_norm may allow a part only; None where it has none."""
        return self._limits_in(self.control)

    def _limits_in(self, control: ControlOptions) -> tuple[Fraction, ...] | None:
        """Return the numbers of u_max in a table [control] by component; None where it has none."""
        return None if control.u_max is None or isinstance(control.u_max, str) else self._per_component(control.u_max)

    @property
    def emitted_u_max(self) -> tuple[Fraction, ...] | None:
        """The saturation of u as it is emitted, in numbers of the scalar that are not above `u_max`; None for none."""
        return None if self.u_max is None else tuple(round_down(v, self.emit.scalar) for v in self.u_max)

    @property
    def largest_coordinate(self) -> Fraction:
        """The largest |x_i| in the state space."""
        return max(abs(v) for edge in (self.state_space.lower, self.state_space.upper) for v in edge)

    @property
    def plant_bounds(self) -> tuple[ComponentBounds, ...]:
        """The plant bounds by component. A missing g_min or g_max is 1, or equal to the other where 1 would contradict that."""
        bounds, plant = [], self.plant
        stated = [(None,) * self.dimension if v is None else self._per_component(v) for v in (plant.g_min, plant.g_max)]
        force, disturbance, cross = (self._per_component(v or Fraction(0)) for v in (plant.f_max, plant.w_max, plant.g_cross))
        for i, (low, high) in enumerate(zip(*stated, strict=True)):
            g_min = low if low is not None else min(Fraction(1), high or Fraction(1))
            g_max = high if high is not None else max(Fraction(1), g_min)
            bounds.append(ComponentBounds(force[i] + disturbance[i], g_min, g_max, cross[i]))
        return tuple(bounds)

    @property
    def clearances(self) -> tuple[Fraction, ...]:
        """The distance kept from unsafe sets, by dimension."""
        return self._per_component(self.tube.clearance)

    @property
    def clearance_excess(self) -> tuple[Fraction, ...]:
        """By how much the clearance of each dimension is above the smallest one; a set grown by it has one clearance for all."""
        return tuple(v - min(self.clearances) for v in self.clearances)

    @property
    def min_widths(self) -> tuple[Fraction, ...]:
        """The least width of the tube that the task asks for, by dimension."""
        return self._per_component(self.tube.min_width)

    @property
    def noise(self) -> tuple[Fraction, ...]:
        """The bound on the error of each measured x_i."""
        return self._per_component(self.plant.noise or Fraction(0))

    @property
    def noise_v(self) -> tuple[Fraction, ...]:
        """The bound on the error of each measured v_i, for order 2."""
        return self._per_component(self.plant.noise_v or Fraction(0))

    @property
    def has_noise(self) -> bool:
        """Whether the task states that some measured x_i or v_i may be wrong."""
        return any(self.noise) or any(self.noise_v)

    @property
    def drive_bounds(self) -> tuple[DriveBounds, ...]:
        """What is stated about the drive of each component."""
        plant, zero = self.plant, Fraction(0)
        lag, lag2, overshoot = (self._per_component(v or zero) for v in (plant.lag, plant.lag2, plant.overshoot))
        slew = (None,) * self.dimension if plant.slew is None else self._per_component(plant.slew)
        return tuple(DriveBounds(*values) for values in zip(lag, lag2, slew, overshoot, strict=True))

    @property
    def has_drive(self) -> bool:
        """Whether what acts of u may differ from what is commanded."""
        return not all(bounds.acts_at_once for bounds in self.drive_bounds)

    @property
    def has_late_input(self) -> bool:
        """Whether an input may act later than its sample, or otherwise than it is commanded: by latency or by the drive."""
        return self.control.latency > 0 or self.has_drive

    def coupling_of(self, inputs: Sequence[Fraction]) -> tuple[Fraction, ...]:
        """Return by component the sum over j != i of |g_ij| |u_j|, for |u_j| <= inputs_j: what the other inputs move it by."""
        total = sum(inputs, Fraction(0))
        return tuple(b.cross * (total - v) for b, v in zip(self.plant_bounds, inputs, strict=True))

    def largest_derivative(self, inputs: Sequence[Fraction]) -> tuple[Fraction, ...]:
        """Return by component a bound on |f_i + w_i + sum_j g_ij y_j|, the derivative that u acts on, for |u_j| <= inputs_j.

        y is what acts of u, which a drive that overshoots makes larger.
        """
        inputs = [v * drive.amplification for v, drive in zip(inputs, self.drive_bounds, strict=True)]
        parts = zip(self.plant_bounds, inputs, self.coupling_of(inputs), strict=True)
        return tuple(b.force + b.g_max * u + coupling for b, u, coupling in parts)

    @property
    def disturbance_bound(self) -> Fraction:
        """The largest norm for which every w is within plant.w_max, whatever its direction."""
        return min(self._per_component(self.plant.w_max or Fraction(0)))

    @property
    def is_coupled(self) -> bool:
        """Whether the plant bounds let an input act on other components."""
        return any(b.cross for b in self.plant_bounds)

    @property
    def scales_input(self) -> bool:
        """Whether one factor limits all components of u together."""
        return self.control.saturate == "scale"

    @property
    def requires_input_limits(self) -> bool:
        """Whether P8 must be proved: u is limited, the plant has bounds, and there is no period, whose proof demands more."""
        is_bounded = any(getattr(self.plant, name) is not None for name in PLANT_BOUNDS)
        return self.u_max is not None and is_bounded and self.control.period is None and self.tube.capabilities.proves_limits

    @property
    def max_speed(self) -> tuple[Fraction, ...] | None:
        """The bound on the speed of the tube's edges by dimension; None for none."""
        return None if self.tube.max_speed is None else self._per_component(self.tube.max_speed)

    @property
    def order(self) -> int:
        """The order of the plant: 1 where u sets speeds, 2 where it sets accelerations."""
        return self.plant.order

    @property
    def filter(self) -> tuple[Fraction, ...] | None:
        """The filter rate lambda by component, 1/s; None where the design chooses it."""
        rate = self.tube.filter
        return None if rate is None or isinstance(rate, str) else self._per_component(rate)

    @property
    def start_speed(self) -> tuple[Fraction, ...]:
        """The bound on the speed at the start, by component."""
        return self._per_component(self.initial_set.speed or Fraction(0))

    @property
    def max_acceleration(self) -> tuple[Fraction, ...] | None:
        """The bound on the acceleration of the tube's edges by dimension; None for none."""
        return None if self.tube.max_acceleration is None else self._per_component(self.tube.max_acceleration)

    @property
    def sampling_period(self) -> Fraction:
        """Seconds between samples: control.period, else emit.tick_period, else a millisecond."""
        return self.control.period or self.emit.tick_period or Fraction(1, 1000)

    @property
    def uses_differences(self) -> bool:
        """Whether the velocity v is computed from differences of the measured x."""
        return self.control.velocity == "differences"

    @property
    def shortest_period(self) -> Fraction:
        """The minimum time between samples in seconds, where v is computed from differences."""
        return self.control.period_min or self.sampling_period / 2

    @property
    def half_extents(self) -> tuple[Fraction, ...]:
        """The robot's half extents by dimension; 0 for a point."""
        return self.body or (Fraction(0),) * self.dimension

    @property
    def free_space(self) -> BoxSet:
        """The state space shrunk by the body: where the robot's reference point may be."""
        return self.state_space.convex().grown([-h for h in self.half_extents])

    @property
    def start(self) -> BoxSet:
        """The initial set X0."""
        return self.initial_set.convex()

    @property
    def target_at_rest(self) -> BoxSet:
        """The box of the target set before it is displaced, without its cuts."""
        target = self.target_set
        return self.free_space if target is None else target.box(self.free_space, self.axis_indices(target))

    @property
    def target(self) -> BoxSet:
        """The box of the target set T at t_c, without its cuts."""
        box = self.target_at_rest
        by = self.target_course.displacement(self.prescribed_time)
        lower, upper = (tuple(v + d for v, d in zip(edges, by, strict=True)) for edges in (box.lower, box.upper))
        return BoxSet(lower, upper)

    @property
    def space_cuts(self) -> tuple[HalfSpace, ...]:
        """The half-spaces that cut the state space, moved inward by the body."""
        half = self.half_extents
        cuts = self.state_space.cuts(self.axis_indices(self.state_space), self.dimension)
        return tuple((n, h - sum((abs(c) * v for c, v in zip(n, half, strict=True)), Fraction(0))) for n, h in cuts)

    @property
    def target_cuts(self) -> tuple[HalfSpace, ...]:
        """The half-spaces that cut the target set at t_c."""
        if self.target_set is None:
            return self.space_cuts
        by = self.target_course.displacement(self.prescribed_time)
        cuts = self.target_set.cuts(self.axis_indices(self.target_set), self.dimension)
        return tuple((n, h + sum((c * v for c, v in zip(n, by, strict=True)), Fraction(0))) for n, h in cuts)

    @property
    def target_course(self) -> Course:
        """The motion of the target."""
        return self._course(self.target_set or self.state_space, None, Fraction(0), Fraction(0))

    @property
    def courses(self) -> tuple[Course | None, ...]:
        """The motion and active interval of each unsafe set; None for a set that is the same at all times."""
        return tuple(
            self._course(s, s.during, s.timing or Fraction(0), s.spread or Fraction(0)) if s.is_timed else None
            for s in self.unsafe
        )

    @property
    def has_timed_sets(self) -> bool:
        """Whether the clock of the sets matters: some unsafe set changes in time, or the target moves."""
        return any(s.is_timed for s in self.unsafe) or self.has_moving_target

    @property
    def has_moving_target(self) -> bool:
        """Whether the target is displaced."""
        return self.target_set is not None and self.target_set.motion is not None

    @property
    def regions(self) -> dict[str, Unsafe | RegionUnion]:
        """The regions by name."""
        return {region.name: region for region in self.region}

    @property
    def formulas(self) -> tuple[Formula, ...]:
        """Every entry of the mission as a formula about states."""
        regions = self.regions
        boxes = frozenset(name for name, region in regions.items() if isinstance(region, UnsafeSet))
        meanings = (entry.meaning(self.prescribed_time, self.repeat) for entry in self.mission)
        return tuple(with_state_formulas(expand_unions(meaning, regions), boxes) for meaning in meanings)

    @property
    def formula(self) -> Formula | None:
        """The mission as one formula, the conjunction of its entries; None without a mission."""
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
        """The unsafe sets without the body, in the order of the file."""
        return tuple(s.to_set_in(self.state_space, self.axis_indices(s)) for s in self.unsafe)

    def unsafe_field(self, j: int) -> str:
        """Return the field of the file that has unsafe set j."""
        return f"unsafe[{j}]"

    def axis_indices(self, table: Unsafe | Region) -> tuple[int, ...]:
        """Return the dimensions of a set, by index. Its axes must be axes of the task."""
        return tuple(self.axis_names.index(name) for name in table.axes or self.axis_names)

    @property
    def obstacles(self) -> tuple[ConvexSet, ...]:
        """The unsafe sets grown by `body`, in the order of the file."""
        return tuple(s.grown(self.half_extents) for s in self.unsafe_sets)
