"""Missions for benchmarks, as texts of task files: stlpy's (Kurtz and Lin, IEEE L-CSS 6, 2022), the project's, and random ones.

One step of stlpy is a second here. A start is a box of 0.25 to each side, and the clearance is 0.03, unless a scenario says
otherwise. No speed is limited: the slowest tube is designed.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from stt_codegen.design.half_spaces import Array

Box = Sequence[float]  # x0 x1 y0 y1 ..
START_HALF_WIDTH = 0.25


@dataclass(frozen=True)
class Scenario:
    """A mission. name: in tables. text: of the task file. is_infeasible: whether it must be refused, because no plan exists."""

    name: str
    text: str
    is_infeasible: bool = False


def _vector(values: Sequence[float]) -> str:
    return "[" + ", ".join(f"{v:.6g}" for v in values) + "]"


def _set(kind: str, name: str, box: Box) -> str:
    return f'[[{kind}]]\nname = "{name}"\nlower = {_vector(box[::2])}\nupper = {_vector(box[1::2])}\n'


def task_of(
    name: str,
    time: float,
    start: Sequence[float],
    space: Box,
    *,
    unsafe: Sequence[Box],
    regions: Mapping[str, Box],
    entries: str,
    start_half_width: float = START_HALF_WIDTH,
    tube: str = "",
) -> str:
    """Return the text of a task file.

    time: prescribed, seconds. start: its middle. space: the state space. regions: by name. entries: further tables as TOML, such
    as those of the mission. tube: the lines of [tube].
    """
    lower, upper = ([v + sign * start_half_width for v in start] for sign in (-1, 1))
    parts = [
        f'name = "{name}"\nprescribed_time = {time:g}\ninitial_state = {_vector(start)}\n',
        f"[state_space]\nlower = {_vector(space[::2])}\nupper = {_vector(space[1::2])}\n",
        f"[initial_set]\nlower = {_vector(lower)}\nupper = {_vector(upper)}\n",
        *(_set("unsafe", f"O{j}", box) for j, box in enumerate(unsafe, 1)),
        *(_set("region", key, box) for key, box in regions.items()),
        entries,
        f"[tube]\n{tube}\n" if tube else "",
    ]  # fmt: skip
    return "\n".join(parts)


def formulas(*texts: str) -> str:
    """Return the entries of a mission that has these formulas."""
    return "\n".join(f'[[mission]]\nformula = "{text}"\n' for text in texts)


SPACE = (0, 10, 0, 10)  # x0 x1 y0 y1 of the state space, of stlpy and ours
WALLS = ((8, 15, 0, 4), (8, 15, 6, 10), (3.5, 5, 0, 2.5), (0, 2.5, 4, 6), (3.5, 5, 7.5, 10))
DOORS = ((12.8, 14, 3.99, 6.01), (11.5, 12.7, 3.99, 6.01), (10.2, 11.4, 3.99, 6.01), (8.9, 10.1, 3.99, 6.01))
KEYS = ((1, 2, 1, 2), (1, 2, 8, 9), (6, 7, 8, 9), (6, 7, 1, 2))
PAIRS = (
    ((5.4249, 6.4249, 4.9039, 5.9039), (3.8129, 4.8129, 5.813, 6.813)),
    ((3.9383, 4.9383, 8.026, 9.026), (8.673, 9.673, 3.451, 4.451)),
    ((7.1255, 8.1255, 4.7601, 5.7601), (5.1124, 6.1124, 8.3304, 9.3304)),
    ((0.6393, 1.6393, 0.7842, 1.7842), (0.182, 1.182, 7.4936, 8.4936)),
    ((7.0034, 8.0034, 7.8301, 8.8301), (8.8076, 9.8076, 7.1924, 8.1924)),
)
STONES = (
    (3.7532, 6.4829), (0.001, 2.721), (1.3208, 0.831), (1.6763, 3.11), (3.5709, 4.8494), (3.7728, 6.167), (1.8401, 7.9031),
    (0.2465, 6.0342), (3.7557, 5.0282), (1.2635, 1.7829), (7.2067, 8.7144), (2.8208, 6.2309), (7.8875, 8.0515), (0.7654, 0.3515),
    (1.5285, 7.9033),
)  # fmt: skip


def stlpy_scenarios() -> Iterator[Scenario]:
    """Yield the scenarios of stlpy's example files, with the numbers of these files."""
    goal, block = {"goal": (7, 8, 8, 9)}, [(3, 5, 4, 6)]
    for time in (10, 20):
        text = task_of(
            "reach",
            time,
            (1, 2),
            SPACE,
            unsafe=block,
            regions=goal,
            entries=formulas(f"eventually[0, {time}] goal"),
            tube="clearance = 0",
        )
        yield Scenario(f"reach-avoid, {time} s", text)
    either = {**goal, "t1": (1, 2, 6, 7), "t2": (7, 8, 4.5, 5.5)}
    mission = formulas("eventually[0, 15] (always[0, 5] t1 or always[0, 5] t2)", "eventually[0, 20] goal")
    yield Scenario(
        "either-or, 20 s",
        task_of("either", 20, (2, 2), SPACE, unsafe=block, regions=either, entries=mission, tube="clearance = 0"),
    )
    narrow = [(2, 5, 4, 6), (5.5, 9, 3.8, 5.7), (4.6, 8, 0.5, 3.5), (2.2, 4.4, 6.4, 10)]
    goals = {"g1": (7, 8, 8, 9), "g2": (9.5, 10.5, 1.5, 2.5)}
    mission = formulas("eventually[0, 25] (g1 or g2)")
    yield Scenario(
        "narrow passage, 25 s",
        task_of("narrow", 25, (3, 3.6), SPACE, unsafe=narrow, regions=goals, entries=mission, tube="clearance = 0"),
    )
    for doors, time in ((2, 25), (4, 50)):
        regions = {"goal": (14.1, 14.9, 4.1, 5.9)}
        for k in range(doors):
            regions |= {f"door{k}": DOORS[k], f"key{k}": KEYS[k]}
        mission = formulas(*(f"not door{k} until[0, {time}] key{k}" for k in range(doors)), f"eventually[0, {time}] goal")
        text = task_of(
            "doors", time, (6, 1), (0, 15, 0, 10), unsafe=WALLS, regions=regions, entries=mission, tube="clearance = 0"
        )
        yield Scenario(f"door puzzle {doors}, {time} s", text)
    regions = {f"t{k}{'ab'[j]}": box for k, pair in enumerate(PAIRS) for j, box in enumerate(pair)}
    mission = formulas(*(f"eventually[0, 25] (t{k}a or t{k}b)" for k in range(len(PAIRS))))
    many = [(4.9393, 6.9393, 6.4367, 8.4367)]
    yield Scenario(
        "many-target, 25 s",
        task_of("targets", 25, (5, 2), SPACE, unsafe=many, regions=regions, entries=mission, tube="clearance = 0"),
    )
    yield Scenario(
        "stepping stones, seed 1, 15 s", stepping_stones([(*s,) for s in STONES], 15, (2, 1.3), 0.05, 0.02), is_infeasible=True
    )


def stepping_stones(
    corners: Sequence[Sequence[float]], time: float, start: Sequence[float], start_half_width: float, width: float
) -> str:
    """Return a task in which the tube must always be in one of the unit squares, and at some time in the last."""
    regions = {f"s{k}": (x, x + 1, y, y + 1) for k, (x, y) in enumerate(corners)}
    any_stone = " or ".join(regions)
    mission = formulas(f"always[0, {time:g}] ({any_stone})", f"eventually[0, {time:g}] s{len(corners) - 1}")
    return task_of(
        "stones",
        time,
        start,
        SPACE,
        unsafe=[],
        regions=regions,
        entries=mission,
        start_half_width=start_half_width,
        tube=f"clearance = 0\nmin_width = {width:g}",
    )


def connected_stones(count: int, limit: int) -> Iterator[Scenario]:
    """Yield at most `limit` scenarios of `count` random stones.

    Stones that overlap by more than 0.12 connect the first with the last, which is more than 5 away.
    """
    scenario_count = 0
    for seed in range(400):
        rng = np.random.default_rng(seed)
        corners = rng.uniform(0, 9, (count, 2))
        overlap = 1 - np.abs(corners[:, None] - corners[None]).max(axis=2)
        reached, queue = {0}, [0]
        while queue:
            stone = queue.pop()
            neighbours = [j for j in np.nonzero(overlap[stone] > 0.12)[0].tolist() if j not in reached]
            reached.update(neighbours)
            queue += neighbours
        if count - 1 in reached and np.abs(corners[0] - corners[-1]).max() > 5:
            middle = corners[0] + 0.5
            yield Scenario(
                f"{count} stones, seed {seed}, 40 s", stepping_stones(corners.tolist(), 40, middle.tolist(), 0.1, 0.05)
            )
            scenario_count += 1
            if scenario_count == limit:
                return


UNSAFE_SETS = ((3, 4, 1, 4), (6, 7, 5, 9), (2, 3, 6, 7), (7, 8.5, 2, 3.5))
REGIONS = {
    "a": (1, 2, 8, 9), "b": (8.5, 9.5, 8, 9), "c": (8.5, 9.5, 0.5, 1.5), "d": (4.5, 5.5, 0.5, 1.5), "e": (4.5, 5.5, 4.5, 5.5),
    "f": (0.5, 1.5, 4, 5), "g": (4.2, 5.2, 8, 9), "h": (8.6, 9.6, 4.6, 5.6),
}  # fmt: skip


def project_scenarios() -> Iterator[Scenario]:
    """Yield missions as users have them: a patrol, a response, a stay with a deadline after it, and three of eight visits."""

    def scenario_of(name: str, title: str, time: float, regions: str, entries: str) -> Scenario:
        boxes = {key: REGIONS[key] for key in regions}
        return Scenario(title, task_of(name, time, (0.6, 0.6), SPACE, unsafe=UNSAFE_SETS, regions=boxes, entries=entries))

    yield scenario_of("patrol", "patrol of two regions", 40, "ae", '[[mission]]\npatrol = ["a", "e"]\nevery = 14\n')
    yield scenario_of(
        "respond", "response", 30, "ae", formulas("eventually[0, 12] a", "always[0, 18] (not a or eventually[0, 8] e)")
    )
    stay = '[[mission]]\nvisit = "a"\nbetween = [4, 12]\nstay = 3\nthen = "b"\nwithin = 8\n'
    stay += '\n[[mission]]\nnever = "e"\nbefore = "b"\n'
    yield scenario_of("stay", "stay, then, never before", 30, "abe", stay)
    order = "eventually[0, 60] (f and eventually[0, 60] (a and eventually[0, 60] (g and eventually[0, 60] (e and "
    order += "eventually[0, 60] (d and eventually[0, 60] (c and eventually[0, 60] (h and eventually[0, 60] b)))))))"
    yield scenario_of("inorder", "eight visits in order", 60, "abcdefgh", formulas(order))
    free = "\n".join(f'[[mission]]\nvisit = "{k}"\n' for k in "abcdefgh")
    yield scenario_of("anyorder", "eight visits in any order", 60, "abcdefgh", free)
    windows = {"a": (5, 20), "c": (20, 35), "e": (35, 50), "h": (10, 30)}
    timed = "\n".join(
        f'[[mission]]\nvisit = "{k}"\n' + (f"between = [{windows[k][0]}, {windows[k][1]}]\n" if k in windows else "")
        for k in "abcdefgh"
    )
    yield scenario_of("windowed", "eight visits, four windows", 60, "abcdefgh", timed)


def random_mission(seed: int, n: int, unsafe: int) -> str:
    """Return the text of a random mission among unsafe boxes.

    It has a visit in a window with a stay, one in another window, one of two regions, and a door that needs a key.
    """
    rng, visits = np.random.default_rng(seed), 5
    start = np.array([[0.3] * n, [0.8] * n])
    sets: list[Array] = []
    while len(sets) < unsafe:
        low = rng.uniform(0, 8.5, n)
        box = np.array([low, low + rng.uniform(0.6, 2, n)])
        if _is_apart(box, [start], 0.6):
            sets.append(box)
    regions: list[Array] = []
    while len(regions) < visits + 2:
        low = rng.uniform(0, 9, n)
        box = np.array([low, low + 1.0])
        if _is_apart(box, [*sets, start, *regions], 0.15):
            regions.append(box)
    first, last = rng.uniform(2, 15), rng.uniform(8, 24)
    entries = [
        f'[[mission]]\nvisit = "r0"\nbetween = [{first:.4f}, {first + 5:.4f}]\nstay = 2\n',
        f'[[mission]]\nvisit = "r1"\nbetween = [{last:.4f}, {last + 5:.4f}]\n',
        f'[[mission]]\nvisit = "either"\n\n[[mission]]\nnever = "r{visits + 1}"\nbefore = "r{visits - 1}"\n',
        *(f'[[mission]]\nvisit = "r{k}"\n' for k in range(3, visits)),
    ]
    choice = f'[[region]]\nname = "either"\nany_of = ["r2", "r{visits}"]\n'
    boxes = {f"r{k}": box.T.ravel().tolist() for k, box in enumerate(regions)}
    middle = [0.55] * n
    return task_of(
        f"r{seed}",
        30,
        middle,
        (0, 10) * n,
        unsafe=[b.T.ravel().tolist() for b in sets],
        regions=boxes,
        entries="\n".join([choice, *entries]),
    )


def _is_apart(box: Array, boxes: Sequence[Array], gap: float) -> bool:
    return all(bool((box[0] - gap > b[1]).any() or (box[1] + gap < b[0]).any()) for b in boxes)


def moving_mission(seed: int, n: int, set_count: int) -> str:
    """Return the text of a mission of three visits, each in a window of two seconds, among unit boxes that move."""
    rng, size, time, side = np.random.default_rng(seed), 1.0, 9.0, 5.0
    while True:
        low, speed = rng.uniform(0, side - size, (set_count, n)), rng.uniform(-0.4, 0.4, (set_count, n))
        low_at_end = low + speed * time
        meets_start = (low < 0.6).all(axis=1).any()
        meets_target = ((low_at_end + size > side - 0.6) & (low_at_end < side + 0.1)).all(axis=1).any()
        if not meets_start and not meets_target:
            break
    rng = np.random.default_rng(seed + 999)
    boxes, entries = {}, []
    for k in range(3):
        corner, begin = rng.uniform(0.3, side - 1.3, n), rng.uniform(0.5, 6)
        boxes[f"r{k}"] = np.stack([corner, corner + 0.8], axis=1).ravel().tolist()
        entries.append(f'[[mission]]\nvisit = "r{k}"\nbetween = [{begin:.4f}, {begin + 2:.4f}]\n')
    sets = [
        _set("unsafe", f"M{j}", np.stack([a, a + size], axis=1).ravel().tolist())
        + f"motion = [{{ at = 0, by = {_vector([0.0] * n)} }}, {{ at = {time:g}, by = {_vector((v * time).tolist())} }}]\n"
        for j, (a, v) in enumerate(zip(low, speed, strict=True))
    ]
    target = _set("target_set", "", [v for _ in range(n) for v in (side - 0.5, side)]).replace("[[target_set]]", "[target_set]")
    tables = "\n".join([target.replace('name = ""\n', ""), *sets, *entries])
    return task_of(f"m{seed}", time, [0.25] * n, (0, side) * n, unsafe=[], regions=boxes, entries=tables, start_half_width=0.24)


SCENARIO_FAMILIES: dict[str, Callable[[], Iterator[Scenario]]] = {"stlpy": stlpy_scenarios, "own": project_scenarios}
