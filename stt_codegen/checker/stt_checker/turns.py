"""Axes that close after a period, as an angle does: the target's nearest image, the images of unsafe sets, and the error of an
unwrapped measurement. For tasks with `periodic`. docs/certificate-format.md, "Axes that close", has the rules."""

import itertools
import math
from fractions import Fraction
from typing import Any

from .exact import Unusable, number, require
from .sets import Inside, Obstacle, axes_of, dot, spread_over

IMAGE_LIMIT = 64  # images of one unsafe set
TURN_LIMIT = 100  # full turns that a measurement or a set may be away
DRIFT_UNIT, NOISE_UNIT = Fraction(1, 10**18), Fraction(1, 10**12)


def two_pi() -> tuple[Fraction, Fraction]:
    """Return 2 pi from below and above by Machin's formula: partial sums of an alternating series bound it."""

    def arctangent(n: int, terms: int) -> Fraction:
        return sum((Fraction((-1) ** k, (2 * k + 1) * n ** (2 * k + 1)) for k in range(terms)), Fraction(0))

    (a, b), (c, d) = (sorted(arctangent(n, terms) for terms in (40, 41)) for n in (5, 239))
    return 8 * (4 * a - d), 8 * (4 * b - c)


def drift(period: Fraction) -> Fraction:
    """Return how far a period may be from 2 pi/m, where it is within a thousandth of that for some m up to 12; else 0."""
    low, high = two_pi()
    for m in range(1, 13):
        off = max(abs(period - low / m), abs(period - high / m))
        if off <= high / (1000 * m):
            return math.ceil(off / DRIFT_UNIT) * DRIFT_UNIT
    return Fraction(0)


def corners(normals: list[Any], edges: list[tuple[Fraction, Fraction]]) -> list[list[Fraction]]:
    """Return the corners of a box that is cut by half-spaces: the points where d faces meet and all others hold."""
    d = len(edges)
    axes = [
        ([Fraction(sign * (k == i)) for k in range(d)], sign * edge)
        for i in range(d)
        for sign, edge in zip((-1, 1), edges[i], strict=True)
    ]
    faces, result = [*normals, *axes], list[list[Fraction]]()
    for some in itertools.combinations(faces, d):
        rows = [[*normal, offset] for normal, offset in some]
        for i in range(d):  # Gauss and Jordan
            lead = next((r for r in rows[i:] if r[i]), None)
            if lead is None:
                break
            rows.remove(lead)
            rows.insert(i, [v / lead[i] for v in lead])
            rows = [r if k == i else [v - r[i] * w for v, w in zip(r, rows[i], strict=True)] for k, r in enumerate(rows)]
        else:
            point = [r[d] for r in rows]
            if all(dot(normal, point) <= offset for normal, offset in faces):
                result.append(point)
    return result


class Turns:
    """The closed axes of a task. It widens the state space and moves the target of the task."""

    def __init__(self, task: Any) -> None:
        stated, names, document = task.document["periodic"], task.names, task.document
        regions = (table.get("axes", names) for table in document.get("region", []) if "any_of" not in table)
        is_known = isinstance(stated, dict) and stated and {*stated} <= {*names}
        if not is_known or document.get("emit", {}).get("scalar") == "fixed" or any({*stated} & {*axes} for axes in regions):
            raise Unusable("the task has closed axes that are not its own, or of a region, or of a controller in integers")
        self.task, self.periods = task, {i: number(stated[name]) for i, name in enumerate(names) if name in stated}
        if min(self.periods.values()) <= 0:
            raise Unusable("the task has a period of an axis that is not above 0")
        self.drifts, self.farthest_image = {i: drift(v) for i, v in self.periods.items()}, 0
        self.steps = dict[int, Fraction]()  # an angle must move by less than this between two samples
        self.unwrap_noise = [Fraction(0)] * task.n
        by, error = [Fraction(0)] * task.n, [Fraction(0)] * task.n
        for i, period in self.periods.items():
            k = self._nearest_turn(i, period)
            by[i], error[i] = k * period, abs(k) * self.drifts[i]
        if task.target is not None:
            spans = [self._span(i) for i in self.periods]
            if any(span is not None and span[1] - span[0] <= 2 * error[i] for i, span in zip(self.periods, spans, strict=True)):
                raise Unusable("the task has a target that is narrower than what its turns are wrong by")
            task.target.move(by, error)
        self.turns = {i: int(max(abs(task.box[0][i]), abs(task.box[1][i])) / v) + 2 for i, v in self.periods.items()}

    def _span(self, i: int) -> tuple[Fraction, Fraction] | None:
        """Return the edges of the target in an axis, at t_c; None where it does not bound the axis."""
        target, table = self.task.target, self.task.document.get("target_set", {})
        if "lower" in table:
            return -target.faces[2 * i + 1][1], target.faces[2 * i][1]
        if target is None or i not in target.axes:
            return None
        centre = target.ball[0][target.axes.index(i)]
        return centre - target.ball[1], centre + target.ball[1]

    def _nearest_turn(self, i: int, period: Fraction) -> int:
        """Choose the target's image that is nearest to the initial state. Where the state space has a whole turn, let it go half
        a turn beyond start and target. Return the image's turn."""
        task, (lower, upper) = self.task, self.task.box
        is_limited, turn = upper[i] - lower[i] < period, 0
        if not is_limited and any({"vertices", "normals"} & {*task.document["state_space"]}):
            faces = Inside(task.document["state_space"], task.names, task.body).faces[2 * task.n :]
            if any(normal[i] for normal, _ in faces):
                raise Unusable("the task has half-spaces that cut the state space in an axis that closes")
        ends, span = [(task.start[0][i], task.start[1][i])], self._span(i)
        if span is not None:
            a, b = span
            off = (task.state[i] - (a + b) / 2) / period
            images = range(math.floor(off) - TURN_LIMIT, math.ceil(off) + TURN_LIMIT + 1)
            low, high = lower[i] + task.body[i], upper[i] - task.body[i]
            inside = [k for k in images if not is_limited or (low <= a + k * period and b + k * period <= high)]
            if not inside:
                raise Unusable("the task has a target of which no image lies in the state space")
            turn = min(inside, key=lambda k: (abs(k - off), abs(k), -k))
            ends.append((a + turn * period, b + turn * period))
        if not is_limited:
            lower[i], upper[i] = min(a for a, _ in ends) - period / 2, max(b for _, b in ends) + period / 2
        return turn

    def obstacles(self, tables: list[tuple[str, Any]]) -> list[Obstacle]:
        """Return the unsafe sets, and after them their images as far as these can come near the state space."""
        task, sets, images, margin = self.task, list[Obstacle](), list[Obstacle](), Fraction(0)
        box = task.box
        for name, table in tables:
            closed = [i for i in axes_of(table, task.names) if i in self.periods]
            ends = [{i: task.state[i] + sign * 64 * self.periods[i] for i in closed} for sign in (-1, 1)]
            lower, upper = ([end.get(i, v) for i, v in enumerate(edges)] for end, edges in zip(ends, box, strict=True))
            task.box = (lower, upper)
            obstacle = Obstacle(table, name, task)
            task.box = box
            sets.append(obstacle)
            ranges = [self._images(i, obstacle, table) for i in closed]
            if math.prod(map(len, ranges)) > IMAGE_LIMIT:
                raise Unusable("the task has a set with more images than can be checked in good time")
            for turns in itertools.product(*ranges):
                if any(turns):
                    by = [Fraction(0)] * task.n
                    for i, k in zip(closed, turns, strict=True):
                        by[i] = k * self.periods[i]
                    images.append(obstacle.image(name + "".join(f"{k:+d}" for k in turns), by))
                    margin = max([margin, *(abs(k) * self.drifts[i] for i, k in zip(closed, turns, strict=True))])
                    self.farthest_image = max(self.farthest_image, *map(abs, turns))
        task.clearance = [v + margin for v in task.clearance]
        return sets + images

    def _images(self, i: int, obstacle: Obstacle, table: Any) -> list[int]:
        """Return the turns of a set in a closed axis that can come near the state space, 0 first."""
        task, period = self.task, self.periods[i]
        column, (lower, upper) = obstacle.axes.index(i), task.box
        ends, extent = obstacle.points, obstacle.half[i]
        if obstacle.faces:
            edges = [(obstacle.points[0][j] - obstacle.half[j], obstacle.points[0][j] + obstacle.half[j]) for j in obstacle.axes]
            normals = [([normal[j] for j in obstacle.axes], offset) for normal, offset in obstacle.faces]
            if len(normals) > 32 or len(edges) > 3:
                raise Unusable("the task has more half-spaces than can be checked in good time")
            ends = [spread_over(obstacle.axes, p, task.n) for p in corners(normals, edges)]
            extent = Fraction(0)
            if not ends or not all(edges[column][0] < p[i] < edges[column][1] for p in ends):
                raise Unusable("the task has half-spaces that leave a set empty, or open in an axis that closes")
        by = [number(v["by"][column]) for v in table.get("motion", [])] or [Fraction(0)]
        grown = number(table.get("spread", 0)) * (task.t_c + obstacle.timing + task.start_delay)
        reach = task.clearance[i] + extent + task.body[i] + obstacle.radius + grown + period / 8
        first = math.ceil((lower[i] - reach - max(p[i] for p in ends) - max(by)) / period)
        last = math.floor((upper[i] + reach - min(p[i] for p in ends) - min(by)) / period)
        if last - first > IMAGE_LIMIT:
            raise Unusable("the task has a set with more images than can be checked in good time")
        return sorted({0, *range(first, last + 1)}, key=lambda k: (abs(k), -k))

    def add_noise(self, bits: int) -> None:
        """Add to the noise of a measured x what unwrapping is wrong by, for a scalar of so many bits."""
        task, largest = self.task, Fraction(0)
        for i, period in self.periods.items():
            turns = self.turns[i]
            error = turns * self.drifts[i] + period * (3 * turns + 3) / (1 << bits)
            error = math.ceil(error / NOISE_UNIT) * NOISE_UNIT
            self.steps[i], largest = period / 2 - 2 * (task.noise(i)[0] + error) - 4 * error, max(largest, error)
            first = max(task.state[i] - task.start[0][i], task.start[1][i] - task.state[i])
            if max(turns, self.farthest_image) > TURN_LIMIT or first >= self.steps[i]:
                raise Unusable("the task has starts, turns or noise with which a measured angle is on no known turn")
        self.unwrap_noise = [task.noise(i)[0] + largest for i in range(task.n)]
        if task.period is not None:
            is_list, stated = isinstance(task.stated["noise"], list), [str(v) for v in self.unwrap_noise]
            task.plant["noise"], task.stated["noise"] = self.unwrap_noise, stated if is_list else stated[0]

    def prove_steps(self, tube: Any, u: list[Fraction], filters: list[Fraction]) -> None:
        """P9: between two samples an angle moves by less than unwrapping allows. It moves by no more than the tube's width and
        its edges, or of order 1 what the plant does with |u_i| <= u_i, or of order 2 as fast as both tubes let it."""
        task = self.task
        for i, allowed in self.steps.items():
            width, speed = max(h - v for piece in tube.pieces for v, h in zip(*piece[i], strict=True)) * tube.unit, tube.speed(i)
            force, _, g_max, cross = task.bounds(i)
            drive = force + g_max * u[i] + cross * (sum(u) - u[i]) if task.order == 1 else speed + filters[i] * width
            moves = min(width + speed * task.period, drive * task.period)
            require(moves < allowed, f"P9: between two samples {task.names[i]} may move by {float(moves):.6g}: its turn is lost")
