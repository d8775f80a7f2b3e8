"""Draws the pictures in docs/: python docs/figures.py [NAME ...] (from the project's folder; all of them without a name).

`PICTURES` says what each picture shows and what the page that has it says. figures.json records the designs that were drawn and
how their runs ended. tests/test_pictures.py holds all of it together.
"""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

from stt_codegen.emit import design_hash
from stt_codegen.loop.command import with_disturbance_bound, with_gain
from stt_codegen.loop.picture import draw_figure1, draw_figure3, draw_run
from stt_codegen.loop.simulate import Loop, Run, Scenario, random_start, scenario_of_task
from stt_codegen.pipeline import EmittedController, build
from stt_codegen.plants import PLANTS, plant_of
from stt_codegen.report.analysis import Analysis
from stt_codegen.report.pictures.tube_pictures import draw, draw_beside, plane_named
from stt_codegen.sampling.gains import choose_proved_gain

HERE = Path(__file__).parent
TASKS = HERE.parent / "tasks"
RECORD = HERE / "figures.json"

INTEGRATOR = PLANTS["integrator"]
WIND = 0.3  # bound on |w|
RATE = 1000.0  # samples a second
TOO_SLOW = 16.0  # samples a second
SHARE = 0.9  # of gamma(0): where runs begin

Scene = tuple[EmittedController, list[Run]]  # what a picture shows: a controller, and its runs where it drives


@dataclass(frozen=True)
class Picture:
    """A picture of a page.

    caption: the page's words in its place. ending: of every run, as `ending_of` says it; empty where nothing drives.
    """

    name: str
    page: str
    caption: str
    ending: str
    scenes: Callable[[], list[Scene]]
    draw: Callable[[list[Scene], Path], None]


def ending_of(run: Run) -> str:
    """Return how a run ended: "fulfilled", or the name of the set that it hit, or what else it missed."""
    if run.good:
        return "fulfilled"
    return run.hit or ("state space left" if run.left_at is not None else "target missed")


def driven(name: str) -> Scene:
    """A certified tube with the gain that `--gain best` takes, and runs from all over the initial set under every disturbance."""
    controller = build(TASKS / f"{name}.toml")
    best = choose_proved_gain(Analysis(controller, with_disturbance_bound(INTEGRATOR, WIND)).sampled_loop, 1 / RATE)
    assert best is not None
    controller = with_gain(controller, best[0].tolist())
    loop = Loop(controller, INTEGRATOR)
    kinds = ("constant", "sinusoidal", "random", "nearest", "outward")
    runs = []
    for seed, kind in enumerate(2 * kinds):
        start = random_start(controller.certificate.start, SHARE, seed)
        runs.append(loop.run(Scenario(rate=RATE, disturbance=kind, strength=WIND, seed=seed, start=start), trace=True))
    return controller, runs


def robot(name: str) -> list[Scene]:
    """A robot of tasks/ with its plant from a corner of the share, pushed about as its file says."""
    controller = build(TASKS / f"{name}.toml")
    task, file = controller.task, TASKS / f"{name}.py"
    plant = plant_of(str(file) if file.exists() else "integrator", task.dimension, task.order)
    start = random_start(controller.certificate.start, 0.99 * float(task.initial_set.share), 2, corner=True)
    strength = float(plant.w_max or task.disturbance_bound)
    run = Loop(controller, plant).run(
        Scenario(disturbance="outward", strength=strength, seed=2, start=start, **scenario_of_task(task)), trace=True
    )
    return [(controller, [run])]


def omni_s2(rate: float, disturbance: str, design: str = "refined") -> list[Scene]:
    """The paper's arena with a tube of this kind, driven at this rate."""
    controller = build(TASKS / "omni_s2.toml", design)
    scenario = Scenario(rate=rate, disturbance=disturbance, strength=WIND, seed=0 if design == "refined" else 1)
    return [(controller, [Loop(controller, INTEGRATOR).run(scenario, trace=True)])]


def paper_missions() -> list[Scene]:
    """S1, S2 and S3 of the paper's figure 3."""
    return [driven(name) for name in ("omni_s1", "omni_s2", "omni_s3")]


def tube(name: str) -> list[Scene]:
    """A certified tube that nothing drives through."""
    return [(build(TASKS / f"{name}.toml"), [])]


def paper_and_shipped() -> list[Scene]:
    """The tube of the printed formulas, which collides, and the certified one."""
    return [(build(TASKS / "omni_s1.toml", design, uncertified=True), []) for design in ("literal", "refined")]


def _draw_robot(scenes: list[Scene], path: Path, axes: Sequence[str] = ()) -> None:
    """Draw one run in these planes."""
    ((controller, (run,)),) = scenes
    draw_run(controller, run, path, [plane_named(controller.task, text) for text in axes])


def _draw_tube(scenes: list[Scene], path: Path) -> None:
    ((controller, _),) = scenes
    draw(controller, path)


def _draw_figure1(scenes: list[Scene], path: Path) -> None:
    ((controller, (run,)),) = scenes
    draw_figure1(controller, run, path)


def _draw_pair(scenes: list[Scene], path: Path) -> None:
    titles = ["as printed: (5)-(11)", "as shipped: refined, certified"]
    draw_beside([controller for controller, _ in scenes], titles, path)


def _robot_picture(name: str, *axes: str) -> Picture:
    return Picture(name, "docs/task.md", "picture", "fulfilled", partial(robot, name), partial(_draw_robot, axes=axes))


PICTURES = {
    picture.name: picture
    for picture in (
        _robot_picture("arm"),
        _robot_picture("attitude", "pitch,yaw"),
        _robot_picture("base"),
        _robot_picture("drone", "x,y", "x,z"),
        _robot_picture("rover"),
        Picture(
            "figure3", "README.md", "Three starts, ten runs each, within their certified tubes", "fulfilled",
            paper_missions, draw_figure3,
        ),
        Picture(
            "figure1", "docs/loop.md", "State space, reachability tube, circumvent function, adapted tube, all over time",
            "fulfilled", partial(omni_s2, 4000.0, "sinusoidal", "adaptive"), _draw_figure1,
        ),
        Picture(
            "sampled_too_slowly", "docs/loop.md", "Sampled too slowly: the state bangs between the walls and hits O1", "O1",
            partial(omni_s2, TOO_SLOW, "outward"), _draw_robot,
        ),
        Picture("omni_s2", "README.md", "A certified tube through the paper's arena", "", partial(tube, "omni_s2"), _draw_tube),
        Picture(
            "courier", "docs/missions.md", "A courier's tube: to the dock, past the charger, to an exit, to the target", "",
            partial(tube, "courier"), _draw_tube,
        ),
        Picture(
            "watchman", "docs/missions.md", "A watchman's tube: a lead-in, then a round that closes", "",
            partial(tube, "watchman"), _draw_tube,
        ),
        Picture(
            "literal_beside_refined", "README.md", "The literal tube runs through O1; the refined one goes around", "",
            paper_and_shipped, _draw_pair,
        ),
    )
}  # fmt: skip


def record_of(scenes: Sequence[Scene], image: bytes) -> dict[str, Any]:
    """Return what figures.json keeps of a picture: the designs that it shows, how runs ended, and the image's SHA-256."""
    designs = {f"{c.task.name}, {c.design.kind}": design_hash(c.task, c.design) for c, _ in scenes}
    endings = sorted({ending_of(run) for _, runs in scenes for run in runs})
    return {"designs": designs, "endings": endings, "image": hashlib.sha256(image).hexdigest()}


def main(names: Sequence[str]) -> None:
    """Draw these pictures, or all, and record what they show."""
    records = json.loads(RECORD.read_text()) if RECORD.exists() else {}
    for name in names or PICTURES:
        picture, path = PICTURES[name], HERE / f"{name}.png"
        scenes = picture.scenes()
        picture.draw(scenes, path)
        records[name] = record_of(scenes, path.read_bytes())
        print(f"{path.name}: {', '.join(records[name]['endings']) or 'no run'}", flush=True)
    RECORD.write_text(json.dumps({name: records[name] for name in sorted(records)}, indent=2) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
