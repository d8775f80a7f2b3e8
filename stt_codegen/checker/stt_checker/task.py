"""The task file, in exact numbers. A key that is unknown here is refused: it might change what the task asks for."""

import hashlib
import json
import re
import tomllib
from decimal import Decimal
from fractions import Fraction
from typing import Any, NamedTuple

from .bounds import require_bounded
from .drive import Drive, assumed_plant
from .exact import Unusable, decimal, number, numbers, vector
from .keys import KNOWN_KEYS, canonical, refuse_unknown_keys
from .moving import Course
from .sets import Inside, Obstacle, axes_of, box, points

NARROWEST_WIDTH = Fraction(1, 1 << 18)  # of a tube: the emitted law divides by the width, and takes it as it is


class Bounds(NamedTuple):
    """Of one component: |f + w|, and the entries of g on its diagonal and beside it."""

    force: Fraction
    g_min: Fraction
    g_max: Fraction
    g_cross: Fraction


class Task:
    """The numbers of a task file by component; sets as what the tube must be in, and what it must avoid."""

    def __init__(self, data: bytes) -> None:
        text = data.decode("utf-8-sig")
        require_bounded(text)
        document = tomllib.loads(text, parse_float=decimal)
        refuse_unknown_keys(document)
        self.digest = hashlib.sha256(json.dumps(canonical(document), sort_keys=True, separators=(",", ":")).encode()).hexdigest()
        self.document, self.name, self.t_c = document, document["name"], number(document["prescribed_time"])
        self.state = [number(v) for v in document["initial_state"]]
        n = self.n = len(self.state)
        self.names = document.get("axes") or [f"x{i + 1}" for i in range(n)]
        names = [self.name, *self.names, *(table.get("name", "") for table in document.get("unsafe", []))]
        are_names = all(isinstance(name, str) for name in names) and re.fullmatch(r"[A-Za-z]\w*", self.name, re.ASCII)
        if not are_names or len(self.names) != n or len({*self.names}) < n:
            raise Unusable("the task has a name that is no word, or axes that are not one name for each dimension")
        self.body, self.start_delay = vector(document.get("body", [0] * n), n), number(document.get("start_delay", 0))
        self.start = box(document["initial_set"], n)
        self._read_tube(document.get("tube", {}))
        self._read_sets(document)
        self._read_plant(document.get("plant", {}), document["initial_set"], document.get("tube", {}))
        self._read_law(document.get("control", {}))
        self._read_emission(document.get("emit", {}))
        self._refuse_contradictions(document.get("plant", {}), document.get("control", {}))

    def _read_tube(self, tube: dict[str, Any]) -> None:
        n = self.n
        self.clearance = numbers(tube.get("clearance", Decimal("0.03")), n)
        self.min_width = [max(v, NARROWEST_WIDTH) for v in numbers(tube.get("min_width", Decimal("0.05")), n)]
        self.segments = number(tube["segments"]) if "segments" in tube else None
        self.max_speed = numbers(tube["max_speed"], n) if "max_speed" in tube else None
        self.max_acceleration = numbers(tube["max_acceleration"], n) if "max_acceleration" in tube else None
        self.filter = None if tube.get("filter", "auto") == "auto" else numbers(tube["filter"], n)

    def _read_sets(self, document: dict[str, Any]) -> None:
        """Read the state space less the body, the target at t_c, and the unsafe sets with their images on axes that close."""
        n, self.box = self.n, box(document["state_space"], self.n)
        self.reaches, self.repeats = "target_set" in document or "mission" not in document, document.get("repeat", False)
        self.target = self._read_target(document["target_set"]) if self.reaches else None
        self.turns: Any = None
        if "periodic" in document:
            from .turns import Turns

            self.turns = Turns(self)
        self.space = Inside(document["state_space"], self.names, self.body)
        for i, (low, high) in enumerate(zip(*self.box, strict=True)):  # as the file says, unless the axis closes
            (axis, _), (opposite, _) = self.space.faces[2 * i : 2 * i + 2]
            self.space.faces[2 * i : 2 * i + 2] = [(axis, high - self.body[i]), (opposite, -low - self.body[i])]
        if self.target is not None and "lower" not in document["target_set"]:  # a ball: other axes are those of the state space
            free = [i for i in range(n) if i not in self.target.axes]
            self.target.faces += [face for i in free for face in self.space.faces[2 * i : 2 * i + 2]]
        tables = [(table.get("name") or f"U{j}", table) for j, table in enumerate(document.get("unsafe", []), 1)]
        if self.turns is None:
            self.unsafe = [Obstacle(table, name, self) for name, table in tables]
        else:
            self.unsafe = self.turns.obstacles(tables)
        self.farthest = max(map(abs, self.box[0] + self.box[1]))
        self.moves = any({"motion", "during"} & {*v} or v.get("spread") for _, v in tables)
        self.moves |= self.reaches and "motion" in document["target_set"]
        timing = {obstacle.name: str(obstacle.timing) for obstacle in self.unsafe if obstacle.states_timing}
        self.clock = {"start_delay": str(self.start_delay), "timing": timing} if self.moves else None

    def _read_target(self, table: Any) -> Inside:
        """Return the target where it is at t_c, as far as it is bounded itself."""
        if ("centre" in table) != ("radius" in table) or not ("lower" in table or "centre" in table):
            raise Unusable("the task has a target without both of its edges, or a ball without a centre or a radius")
        target = Inside(table, self.names, [Fraction(0)] * self.n)
        if "motion" in table:
            axes = axes_of(table, self.names)
            moves = [(v["at"], dict(zip(axes, points([v["by"]], len(axes))[0], strict=True))) for v in table["motion"]]
            target.move(Course(table, moves, self).displacement(self.t_c))
        return target

    def _read_plant(self, plant: dict[str, Any], starts: dict[str, Any], tube: dict[str, Any]) -> None:
        """Read the plant's order and bounds, its drives, and how it starts."""
        self.order, n = plant.get("order", 1), self.n
        self.share, self.speed = number(starts.get("share", Decimal("0.9"))), numbers(starts.get("speed", 0), n)
        if type(self.order) is not int or self.order not in (1, 2):
            raise Unusable("the task has an order that is not 1 or 2")
        if self.order == 1 and ("filter" in tube or "speed" in starts or "noise_v" in plant):
            raise Unusable("the task has a key that is for order 2 alone")
        keys = KNOWN_KEYS["plant"].split()[1 : 6 + self.order]
        self.plant = {k: numbers(plant[k], n) if k in plant else None for k in keys}
        self.stated = {k: as_text(plant[k]) if k in plant else None for k in keys}  # as the certificate repeats it
        self.drive = Drive(plant, n)
        self.stated |= {k: as_text(plant[k]) for k in self.drive.stated}
        is_open = not any([*self.plant.values(), self.drive.stated, plant.get("exact", False)]) and self.order == 1
        self.assumes_plant = is_open and "period" in self.document.get("control", {})

    def _read_law(self, control: dict[str, Any]) -> None:
        """Read what the task states about gain, limits and samples."""
        n = self.n
        self.period = number(control["period"]) if "period" in control else None
        self.latency = number(control.get("latency", 0))
        gain = control.get("gain", Decimal("0.5") if self.period is None else "auto")
        self.gain = None if gain in ("auto", "tight") else numbers(gain, n)
        self.e_max = numbers(control.get("e_max", Decimal("0.99")), n)
        self.u_norm = number(control["u_norm"]) if "u_norm" in control else None
        limit = control.get("u_max", None if self.period is None else "auto")
        self.stated_u_max = None if limit in (None, "auto") else numbers(limit, n)  # a norm of u may leave less
        self.leaves_limit = limit == "auto" or self.u_norm is not None
        self.u_max = None if self.leaves_limit else self.stated_u_max
        self.scales, self.outside = control.get("saturate", "clip") == "scale", control.get("outside", "return")
        self.differs = control.get("velocity", "measured") == "differences"
        self.shortest = None  # the least time between two samples, where v is by differences
        if self.differs and self.period is not None:
            self.shortest = number(control["period_min"]) if "period_min" in control else self.period / 2

    def _read_emission(self, emit: dict[str, Any]) -> None:
        self.inline, self.selftest = emit.get("math") == "inline", bool(emit.get("selftest", False))
        self.tick = number(emit["tick_period"]) if "tick_period" in emit else None

    def _refuse_contradictions(self, plant: dict[str, Any], control: dict[str, Any]) -> None:
        """Refuse values out of range, and combinations of which nothing is proved."""
        bounds = [v for values in self.plant.values() for v in values or []]
        rates = [*(self.max_speed or []), *(self.max_acceleration or []), *(self.stated_u_max or []), *(self.filter or [])]
        gains = [*(self.plant["g_min"] or []), *(self.plant["g_max"] or [])]
        positive_numbers = [v for v in (self.t_c, self.period, self.shortest, self.tick, self.u_norm) if v is not None]
        has_mission, is_equal = "mission" in self.document, self.u_max is not None and len({*self.u_max}) == 1
        is_equal &= self.gain is None or len({*self.gain}) == 1
        lists = any(isinstance(v, list) for v in plant.values())
        for is_wrong, what in (
            (min([*positive_numbers, self.share, *self.e_max, *rates, *gains]) <= 0, "a number that is not positive"),
            (max(self.share, *self.e_max) >= 1, "a share or an e_max that is not below 1"),
            (bool(self.drive.stated) and self.period is None, "a drive where nothing is proved about it"),
            (self.leaves_limit and self.period is self.u_norm is None, "a u_max to be chosen without a period"),
            (type(plant.get("exact", False)) is not bool, "an `exact` that is neither true nor false"),
            (plant.get("exact") is True and any(self.plant[k] for k in ("f_max", "w_max", "g_min", "g_max", "g_cross")),
             "an exact plant with bounds"),
            (min([*self.clearance, self.latency, self.start_delay, *self.body, *self.speed, *bounds]) < 0, "a negative number"),
            (len({o.name for o in self.unsafe}) < len(self.unsafe), "two unsafe sets of one name"),
            (type(self.repeats) is not bool, "a `repeat` that is neither true nor false"),
            (self.repeats and (self.reaches or self.moves or not has_mission), "a `repeat` for a task that has an end"),
            (control.get("saturate", "clip") not in ("clip", "scale"), "a `saturate` that is unknown here"),
            (self.scales and (lists or not is_equal or self.order == 2 or self.period is not None),
             "u scaled as a whole where nothing is proved about it"),
            (self.outside not in ("return", "hold", "stop"), "an `outside` that is unknown here"),
            (self.outside == "hold" and (self.order == 2 or self.moves or has_mission),
             "a tube that waits beside something that does not"),
            (control.get("velocity", "measured") not in ("measured", "differences"), "a `velocity` that is unknown here"),
            (self.differs and (self.order == 1 or self.period is None or "noise_v" in plant or any(self.speed)),
             "a velocity by differences where nothing is proved about it"),
            ("period_min" in control and not self.differs, "a `period_min` for a velocity that is measured"),
            (self.differs and (self.shortest or 0) > (self.period or 0), "a `period_min` above its period"),
        ):  # fmt: skip
            if is_wrong:
                raise Unusable(f"the task has {what}")

    def assume_plant(self, speeds: list[Fraction]) -> None:
        """Take the plant that is assumed where none is stated. speeds: of the tube's fastest edges by component."""
        bounds = assumed_plant(speeds)
        self.plant |= bounds
        self.stated |= {"w_max": [str(v) for v in bounds["w_max"]], "g_min": "4/5", "g_max": "6/5"}

    @property
    def proves_limits(self) -> bool:
        """Whether P8 is asked for."""
        has_bounds = any(v is not None for k, v in self.plant.items() if not k.startswith("noise"))
        return self.u_max is not None and has_bounds and self.period is None

    @property
    def start_share(self) -> Fraction:
        """The share of gamma(0) that covered starts are within: that of P9, or where the law is not clamped."""
        return min(self.e_max) if self.period is None else self.share

    @property
    def is_late(self) -> bool:
        """Whether an input may act later than its sample, or otherwise than it is commanded."""
        return self.latency > 0 or not self.drive.acts_at_once

    def noise(self, i: int) -> tuple[Fraction, Fraction]:
        """Return by how much a measured x_i and a measured v_i may be wrong."""
        of_x, of_v = ((self.plant.get(k) or [Fraction(0)] * self.n)[i] for k in ("noise", "noise_v"))
        return of_x, of_v

    def bounds(self, i: int) -> Bounds:
        """Return the plant bounds of component i. A missing g_min or g_max is 1, or the other one where 1 contradicts it."""
        values = {k: None if v is None else v[i] for k, v in self.plant.items()}
        low, high = values["g_min"], values["g_max"]
        low = min(Fraction(1), Fraction(1) if high is None else high) if low is None else low
        force = (values["f_max"] or Fraction(0)) + (values["w_max"] or Fraction(0))
        return Bounds(force, low, max(Fraction(1), low) if high is None else high, values["g_cross"] or Fraction(0))


def as_text(value: Any) -> Any:
    return [str(number(v)) for v in value] if isinstance(value, list) else str(number(value))
