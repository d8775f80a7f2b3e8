"""The question: state space, unsafe sets, initial set, target set, prescribed time (design words: X, U_j, X0, T, t_c).

`load_task` reads a TOML file into a frozen `Task`. Decimals stay exact: every number is a `Fraction`.
All refusals are `BadInput` with one message: file, field, what is wrong, what would be right.
"""

from __future__ import annotations

import difflib
import hashlib
import json
import tomllib
from decimal import Decimal
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    PlainSerializer,
    PrivateAttr,
    StrictBool,
    ValidationError,
    WithJsonSchema,
)

from stt_codegen.errors import BadInput
from stt_codegen.task_checks import first_problem
from stt_codegen.wording import decimal, kind_of

MAX_DIMENSION = 64
MAX_NAME = 20
MAX_LABEL = 40
LARGEST, SMALLEST = Fraction(10) ** 9, Fraction(1, 10**9)  # keeps every derived float32 constant normal
MAX_DIGITS = 40

DesignKind = Literal["refined", "adaptive", "literal"]
Scalar = Literal["float", "double"]


def _number(value: object) -> Fraction:
    """A TOML number as an exact fraction; raises ValueError with the reason when it cannot be one."""
    if isinstance(value, Fraction):
        return value
    if isinstance(value, bool):
        raise ValueError(f"is the boolean {str(value).lower()}; a number is needed, for example 1.0")
    if not isinstance(value, int | Decimal):
        raise ValueError(f"is {kind_of(value)}; a number is needed, for example 1.0")
    if isinstance(value, Decimal):
        if not value.is_finite():
            raise ValueError(f"is {value}; a finite number is needed")
        if value and (value.adjusted() > 9 or value.adjusted() < -10 or len(value.as_tuple().digits) > MAX_DIGITS):
            raise ValueError(
                f"is {value!s:.40}; use 0 or a magnitude from 1e-9 to 1e9 of at most {MAX_DIGITS} digits (rescale the units)"
            )
    exact = Fraction(value)
    if exact and not SMALLEST <= abs(exact) <= LARGEST:
        raise ValueError("is out of range; use 0 or a magnitude from 1e-9 to 1e9 (rescale the units)")
    return exact


def _positive(value: Fraction) -> Fraction:
    if value <= 0:
        raise ValueError(f"is {decimal(value)}; it must be greater than 0")
    return value


def _not_negative(value: Fraction) -> Fraction:
    if value < 0:
        raise ValueError(f"is {decimal(value)}; it must be 0 or greater")
    return value


Number = Annotated[
    Fraction,
    BeforeValidator(_number),
    PlainSerializer(float, return_type=float),
    WithJsonSchema({"type": "number"}),
]
Positive = Annotated[Number, AfterValidator(_positive), WithJsonSchema({"type": "number", "exclusiveMinimum": 0})]
NotNegative = Annotated[Number, AfterValidator(_not_negative), WithJsonSchema({"type": "number", "minimum": 0})]


def _vector(value: object) -> object:
    if not isinstance(value, list | tuple):
        raise ValueError(f"is {kind_of(value)}; a list of numbers is needed, one for each dimension")
    if not value:
        raise ValueError("is an empty list; give one number for each dimension")
    if len(value) > MAX_DIMENSION:
        raise ValueError(f"has {len(value)} entries; at most {MAX_DIMENSION} dimensions are supported")
    return value


Vector = Annotated[tuple[Number, ...], BeforeValidator(_vector)]


def _integer(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"is {kind_of(value)}; a whole number is needed")
    if value.bit_length() > 63:
        raise ValueError("is out of range; use a whole number below 2^63")
    return value


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Box(_Table):
    """An axis-aligned box: `lower` and `upper` edges by dimension, in the task's units."""

    lower: Vector
    upper: Vector


class UnsafeSet(Box):
    """One unsafe set U_j; unnamed sets are called U1, U2, ... in the order of the file."""

    name: str = Field(default="", pattern=r"^[A-Za-z0-9_ .()#+-]*$", max_length=MAX_LABEL)


class AdaptiveOptions(_Table):
    """Parameters of the paper's functions (7)-(11). Absent: adaptive lets the search choose, literal takes the case study's."""

    bump_steepness: Positive | None = Field(default=None, description="k^j of (7); literal only: 0.01")
    overshoot: Positive | None = Field(default=None, description="delta B of (7), units; literal 0.2")
    theta0: Positive | None = Field(default=None, description="theta_0 of (11), units cubed per second; literal 0.01")
    kappa: Positive | None = Field(default=None, description="decay of alpha in (11), 1/s; literal 5")
    mu: Positive | None = Field(default=None, description="tolerance of the trigger in (11), units; literal 1")
    varsigma: Positive | None = Field(default=None, description="steepness of the trigger's tanh, 1/units; literal 100")
    nu: Positive | None = Field(default=None, description="sharpness of smooth max and min, 1/units; literal 100")
    target_margin: NotNegative | None = Field(default=None, description="inset of That, units; adaptive only")


class TubeOptions(_Table):
    """How the tube is designed."""

    design: DesignKind = "refined"
    clearance: NotNegative = Field(default=Fraction(3, 100), description="kept between tube and unsafe sets")
    min_width: NotNegative = Field(default=Fraction(5, 100), description="least width of the tube in each dimension")
    max_speed: NotNegative | None = Field(default=None, description="bound on the speed of every edge of the tube")
    segments: Annotated[int, BeforeValidator(_integer)] | None = Field(
        default=None, ge=4, le=8192, description="spline segments; chosen when absent"
    )
    seed: Annotated[int, BeforeValidator(_integer)] = Field(default=0, ge=0, description="literal design: the random sides")
    adaptive: AdaptiveOptions = AdaptiveOptions()


class ControlOptions(_Table):
    """The control law (13)."""

    gain: Number = Field(default=Fraction(1, 2), description="k; negative where g_s is negative definite (Remark 4.2)")
    e_max: Number = Field(default=Fraction(99, 100), description="clamp of the normalized error, in (0, 1)")
    u_max: Vector | None = Field(default=None, description="saturation of the emitted u, one bound for each dimension")


class EmitOptions(_Table):
    """What the C looks like."""

    scalar: Scalar = "float"
    math: Literal["libm", "inline"] = "libm"
    tick_period: Positive | None = Field(default=None, description="seconds; adds an entry point with an integer tick")
    selftest: StrictBool = Field(default=False, description="adds <name>_selftest.c for the board's boot")


class PlantBounds(_Table):
    """Bounds on the plant for the effort and sampling statements; the controller itself needs none of them."""

    f_max: NotNegative | None = None
    g_min: Positive | None = None
    g_max: Positive | None = None
    w_max: NotNegative | None = None


class Task(_Table):
    """A reach-avoid-stay task with prescribed time (Definition 2.1), and the options of its controller."""

    name: str = Field(description="prefix of every emitted identifier", pattern="^[A-Za-z][A-Za-z0-9_]*$", max_length=MAX_NAME)
    prescribed_time: Positive = Field(description="t_c, seconds")
    initial_state: Vector = Field(description="x(0), strictly inside the initial set")
    state_space: Box
    initial_set: Box
    target_set: Box
    body: Vector | None = Field(default=None, description="half extents of the robot")
    unsafe: tuple[UnsafeSet, ...] = ()
    tube: TubeOptions = TubeOptions()
    control: ControlOptions = ControlOptions()
    emit: EmitOptions = EmitOptions()
    plant: PlantBounds = PlantBounds()

    _digest: str = PrivateAttr(default="")

    @property
    def dimension(self) -> int:
        """n, the number of state components."""
        return len(self.state_space.lower)

    @property
    def digest(self) -> str:
        """SHA-256 of the file's data (comments, spacing and the order of keys do not count)."""
        return self._digest

    @property
    def free_space(self) -> Box:
        """The state space shrunk by `body`: where the robot's reference point may be."""
        body = self.body or (Fraction(0),) * self.dimension
        return Box.model_construct(
            lower=tuple(a + h for a, h in zip(self.state_space.lower, body, strict=True)),
            upper=tuple(b - h for b, h in zip(self.state_space.upper, body, strict=True)),
        )

    @property
    def grown_unsafe(self) -> tuple[UnsafeSet, ...]:
        """The unsafe sets grown by `body`."""
        body = self.body or (Fraction(0),) * self.dimension
        return tuple(
            UnsafeSet.model_construct(
                name=s.name,
                lower=tuple(a - h for a, h in zip(s.lower, body, strict=True)),
                upper=tuple(b + h for b, h in zip(s.upper, body, strict=True)),
            )
            for s in self.unsafe
        )

    def with_options(self, design: str | None = None, scalar: str | None = None) -> Task:
        """The same task with the options that the command line may override."""
        tube = self.tube.model_copy(update={"design": design}) if design else self.tube
        emit = self.emit.model_copy(update={"scalar": scalar}) if scalar else self.emit
        return self.model_copy(update={"tube": tube, "emit": emit})


# --------------------------------------------------------------------------------------------- loading


def load_task(path: str | Path) -> Task:
    """Read and check a task file. Raises `BadInput`; never returns a task that section 7 of the contract refuses."""
    path = Path(path)
    try:
        text = path.read_bytes().decode("utf-8-sig")
    except OSError as error:
        raise BadInput(f"{path}: cannot be read ({error.strerror}); give the path of a task file") from None
    except UnicodeDecodeError as error:
        raise BadInput(f"{path}: byte {error.start} is not UTF-8; save the file as UTF-8") from None
    return parse_task(text, str(path))


def parse_task(text: str, source: str = "task") -> Task:
    """As `load_task`, from the text of a task file; `source` names it in messages."""
    # TOML allows CRLF; a lone carriage return or a byte-order mark it does not, and tomllib says so.
    try:
        document = tomllib.loads(text, parse_float=Decimal)
    except tomllib.TOMLDecodeError as error:
        last = text.count("\n") + 1
        where = str(error).replace("at end of document", f"at line {last}, the end of the file")
        raise BadInput(f"{source}: not valid TOML: {where}") from None
    except (ValueError, ArithmeticError, RecursionError):
        raise BadInput(f"{source}: not valid TOML: a number is too long or the nesting is too deep") from None
    try:
        task = Task.model_validate(document)
    except ValidationError as error:
        raise BadInput(f"{source}: {_explain(error)}") from None
    problem = first_problem(task)
    if problem:
        raise BadInput(f"{source}: {problem}")
    named = tuple(s if s.name else s.model_copy(update={"name": f"U{j}"}) for j, s in enumerate(task.unsafe, 1))
    task = task.model_copy(update={"unsafe": named})
    task._digest = document_digest(document)
    return task


def document_digest(document: dict[str, Any]) -> str:
    """SHA-256 of a parsed task file: JSON with sorted keys, every number as a reduced fraction "p/q"."""

    def plain(value: object) -> object:
        if isinstance(value, dict):
            return {k: plain(v) for k, v in value.items()}
        if isinstance(value, list):
            return [plain(v) for v in value]
        if isinstance(value, bool | str):
            return value
        assert isinstance(value, int | Decimal)
        number = Fraction(value)
        return f"{number.numerator}/{number.denominator}"

    text = json.dumps(plain(document), sort_keys=True, separators=(",", ":"), ensure_ascii=True)
    return hashlib.sha256(text.encode()).hexdigest()


def json_schema() -> str:
    """The JSON Schema of a task file, for editors that complete and check TOML."""
    schema = Task.model_json_schema()
    schema["title"] = "stt_codegen task"
    return json.dumps(schema, indent=2, sort_keys=True) + "\n"


def _explain(error: ValidationError) -> str:
    """The first of pydantic's findings in this project's words."""
    first = error.errors(include_url=False)[0]
    where = _field(first["loc"])
    kind = first["type"]
    value = first.get("input")
    if kind == "missing":
        return f"{where}: is missing; add it (see the task files in tasks/)"
    if kind == "extra_forbidden":
        known = _known_keys(first["loc"])
        close = difflib.get_close_matches(str(first["loc"][-1]), known, 1)
        hint = f"did you mean {close[0]!r}?" if close else f"known keys here are {', '.join(known)}"
        return f"{where}: unknown key; {hint}"
    if kind == "value_error":
        return f"{where}: {first['ctx']['error']}"
    if kind in ("string_pattern_mismatch", "string_too_long"):
        if first["loc"][0] == "unsafe":
            return (
                f"{where}: {value!r:.40} is no name; use letters, digits, spaces or . _ ( ) # + -, at most {MAX_LABEL} characters"
            )
        return f"{where}: {value!r:.40} is no name; use a letter, then letters, digits or _, at most {MAX_NAME} characters"
    if kind == "literal_error":
        return f"{where}: is {kind_of(value)}; use one of {first['ctx']['expected']}"
    if kind in ("greater_than_equal", "less_than_equal"):
        bound = first["ctx"].get("ge", first["ctx"].get("le"))
        return f"{where}: is {value}; it must be {'at least' if kind == 'greater_than_equal' else 'at most'} {bound}"
    if kind in ("model_type", "model_attributes_type"):
        return f"{where}: is {kind_of(value)}; a table is needed"
    if kind == "tuple_type":
        return f"{where}: is {kind_of(value)}; a list of tables [[{where}]] is needed"
    if kind == "bool_type":
        return f"{where}: is {kind_of(value)}; use true or false, without quotes"
    if kind == "string_type":
        return f"{where}: is {kind_of(value)}; text in quotes is needed"
    return f"{where}: is {kind_of(value)}; {first['msg']}"


def _field(location: tuple[int | str, ...]) -> str:
    text = ""
    for part in location:
        shown = part if isinstance(part, int) or part.isidentifier() else f"{part!r:.40}"
        text += f"[{part}]" if isinstance(part, int) else f".{shown}" if text else str(shown)
    return text or "the file"


def _known_keys(location: tuple[int | str, ...]) -> list[str]:
    model: type[BaseModel] = Task
    tables: dict[str, type[BaseModel]] = {
        "state_space": Box,
        "initial_set": Box,
        "target_set": Box,
        "unsafe": UnsafeSet,
        "tube": TubeOptions,
        "adaptive": AdaptiveOptions,
        "control": ControlOptions,
        "emit": EmitOptions,
        "plant": PlantBounds,
    }
    for part in location[:-1]:
        model = tables.get(str(part), model)
    return list(model.model_fields)
