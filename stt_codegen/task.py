"""The question: state space, unsafe sets, initial set, target set, prescribed time (design words: X, U_j, X0, T, t_c).

`load_task` reads a TOML file into a frozen `Task`. Decimals stay exact: every number is a `Fraction`.
All refusals are `BadInput` with one message: file, field, what is wrong, what would be right.
"""

from __future__ import annotations

import difflib
import hashlib
import json
import keyword
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
    ValidationError,
    WithJsonSchema,
)

from stt_codegen.errors import BadInput
from stt_codegen.words import C_WORDS, CPP_WORDS, LIBRARY_NAMES

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
        raise ValueError(f"is {_kind(value)}; a number is needed, for example 1.0")
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


def decimal(value: Fraction) -> str:
    """A fraction as a decimal: exact where that takes at most 15 digits, else nearest with 9."""
    short = f"{float(value):.15g}"
    return short if Fraction(short) == value else f"{float(value):.9g}"


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
        raise ValueError(f"is {_kind(value)}; a list of numbers is needed, one for each dimension")
    if not value:
        raise ValueError("is an empty list; give one number for each dimension")
    if len(value) > MAX_DIMENSION:
        raise ValueError(f"has {len(value)} entries; at most {MAX_DIMENSION} dimensions are supported")
    return value


Vector = Annotated[tuple[Number, ...], BeforeValidator(_vector)]


def _integer(value: object) -> object:
    if isinstance(value, bool) or not isinstance(value, int):
        raise ValueError(f"is {_kind(value)}; a whole number is needed")
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
    """Parameters of the paper's functions (7)-(11); chosen by the search when absent."""

    bump_steepness: Positive | None = Field(default=None, description="k^j of (7)")
    overshoot: Positive | None = Field(default=None, description="delta B of (7)")
    theta0: Positive | None = None
    kappa: Positive | None = None
    mu: Positive | None = None
    varsigma: Positive | None = None
    nu: Positive | None = None
    target_margin: NotNegative | None = None


class TubeOptions(_Table):
    """How the tube is designed."""

    design: DesignKind = "refined"
    clearance: NotNegative = Field(default=Fraction(3, 100), description="kept between tube and unsafe sets")
    min_width: NotNegative = Field(default=Fraction(5, 100), description="least width of the tube in each dimension")
    max_speed: NotNegative | None = Field(default=None, description="bound on the speed of every edge of the tube")
    segments: Annotated[int, BeforeValidator(_integer)] | None = Field(
        default=None, ge=4, le=1024, description="spline segments; chosen when absent"
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
    problem = _first_problem(task)
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


def _kind(value: object) -> str:
    if isinstance(value, bool):
        return f"the boolean {str(value).lower()}"
    if isinstance(value, str):
        return f"the text {value!r:.40}"
    if isinstance(value, list | tuple):
        return "a list"
    if isinstance(value, dict):
        return "a table"
    if isinstance(value, int) and value.bit_length() > 63:
        return "a very large number"
    if isinstance(value, int | float | Decimal | Fraction):
        return f"the number {value!s:.40}"
    return f"a {type(value).__name__}"


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
        return f"{where}: is {_kind(value)}; use one of {first['ctx']['expected']}"
    if kind in ("greater_than_equal", "less_than_equal"):
        bound = first["ctx"].get("ge", first["ctx"].get("le"))
        return f"{where}: is {value}; it must be {'at least' if kind == 'greater_than_equal' else 'at most'} {bound}"
    if kind in ("model_type", "model_attributes_type"):
        return f"{where}: is {_kind(value)}; a table is needed"
    if kind == "tuple_type":
        return f"{where}: is {_kind(value)}; a list of tables [[{where}]] is needed"
    if kind == "string_type":
        return f"{where}: is {_kind(value)}; text in quotes is needed"
    return f"{where}: is {_kind(value)}; {first['msg']}"


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


# --------------------------------------------------------------------------------- checks between fields


def _first_problem(task: Task) -> str | None:
    """The first thing that no schema can see, in the words of the message; None when there is none."""
    n = task.dimension
    return (
        _name_problem(task.name)
        or _shape_problem(task, n)
        or _options_problem(task)
        or _containment_problem(task, n)
        or _unsafe_problem(task, n)
    )


def _name_problem(name: str) -> str | None:
    reserved = C_WORDS | CPP_WORDS | set(keyword.kwlist) | set(keyword.softkwlist)
    if name in reserved:
        return f"name: {name!r} is a reserved word of C, C++ or Python; choose another"
    if name.lower() in LIBRARY_NAMES:
        return f"name: {name!r} would shadow a header or module of the standard library; choose another"
    return None


def _shape_problem(task: Task, n: int) -> str | None:
    vectors = [
        ("state_space.upper", task.state_space.upper),
        ("initial_state", task.initial_state),
        ("initial_set.lower", task.initial_set.lower),
        ("initial_set.upper", task.initial_set.upper),
        ("target_set.lower", task.target_set.lower),
        ("target_set.upper", task.target_set.upper),
    ]
    for j, unsafe in enumerate(task.unsafe):
        vectors += [(f"unsafe[{j}].lower", unsafe.lower), (f"unsafe[{j}].upper", unsafe.upper)]
    if task.body is not None:
        vectors.append(("body", task.body))
    if task.control.u_max is not None:
        vectors.append(("control.u_max", task.control.u_max))
    for field, vector in vectors:
        if len(vector) != n:
            return f"{field}: has {len(vector)} entries; state_space.lower has {n}, and all must agree"
    boxes: list[tuple[str, Box]] = [
        ("state_space", task.state_space),
        ("initial_set", task.initial_set),
        ("target_set", task.target_set),
    ]
    boxes += [(f"unsafe[{j}]", unsafe) for j, unsafe in enumerate(task.unsafe)]
    for field, box in boxes:
        for i, (a, b) in enumerate(zip(box.lower, box.upper, strict=True)):
            if a >= b:
                return f"{field}: lower[{i}] = {decimal(a)} is not below upper[{i}] = {decimal(b)}"
    return None


def _options_problem(task: Task) -> str | None:
    for i, half in enumerate(task.body or ()):
        if half < 0:
            return f"body[{i}]: is {decimal(half)}; half extents must be 0 or greater"
    if task.control.gain == 0:
        return "control.gain: is 0; use a positive gain, or a negative one where g_s is negative definite"
    if not 0 < task.control.e_max < 1:
        return f"control.e_max: is {decimal(task.control.e_max)}; it must lie strictly between 0 and 1, for example 0.99"
    for i, bound in enumerate(task.control.u_max or ()):
        if bound <= 0:
            return f"control.u_max[{i}]: is {decimal(bound)}; it must be greater than 0"
    if task.tube.max_speed == 0:
        return "tube.max_speed: is 0; it must be greater than 0, or left out for no bound"
    low, high = task.plant.g_min, task.plant.g_max
    if low is not None and high is not None and low > high:
        return f"plant.g_min: is {decimal(low)}, above plant.g_max = {decimal(high)}"
    return None


def _containment_problem(task: Task, n: int) -> str | None:
    space, body = task.free_space, " less the body" if task.body and any(task.body) else ""
    for i in range(n):
        if space.lower[i] >= space.upper[i]:
            return f"body[{i}]: the body does not fit into the state space; make it smaller"
    for field, box in (("initial_set", task.initial_set), ("target_set", task.target_set)):
        for i in range(n):
            if box.lower[i] < space.lower[i]:
                return (
                    f"{field}: lower[{i}] = {decimal(box.lower[i])} lies outside the state space{body}; "
                    f"use at least {decimal(space.lower[i])}"
                )
            if box.upper[i] > space.upper[i]:
                return (
                    f"{field}: upper[{i}] = {decimal(box.upper[i])} lies outside the state space{body}; "
                    f"use at most {decimal(space.upper[i])}"
                )
    for i, x in enumerate(task.initial_state):
        a, b = task.initial_set.lower[i], task.initial_set.upper[i]
        if not a < x < b:
            return (
                f"initial_state[{i}]: {decimal(x)} is not strictly inside the initial set; "
                f"use a value between {decimal(a)} and {decimal(b)}"
            )
    return None


def _unsafe_problem(task: Task, n: int) -> str | None:
    seen: dict[str, int] = {}
    for j, unsafe in enumerate(task.unsafe):
        name = unsafe.name or f"U{j + 1}"
        if name in seen:
            return f"unsafe[{j}].name: {name!r} is already the name of unsafe[{seen[name]}]; names must differ"
        seen[name] = j
    start, target = task.initial_set, task.target_set
    for j, unsafe in enumerate(task.grown_unsafe):
        label = (
            f"unsafe[{j}]"
            + (f" ({unsafe.name})" if unsafe.name else "")
            + (" grown by the body" if task.body and any(task.body) else "")
        )
        if all(unsafe.lower[i] <= start.upper[i] and start.lower[i] <= unsafe.upper[i] for i in range(n)):
            return f"initial_set: meets {label}; move or shrink one of them"
        if all(unsafe.lower[i] <= target.lower[i] and target.upper[i] <= unsafe.upper[i] for i in range(n)):
            return f"target_set: lies inside {label}; move or shrink one of them"
    return None
