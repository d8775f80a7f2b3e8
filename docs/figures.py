"""Draws the pictures in docs/: python docs/figures.py (from the project's folder)."""

from pathlib import Path

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


INTEGRATOR = PLANTS["integrator"]
WIND = 0.3  # bound on |w|
RATE = 1000.0  # samples a second
SHARE = 0.9  # of gamma(0): where runs begin


def driven(name: str) -> tuple[EmittedController, list[Run]]:
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


def robot(name: str, *axes: str) -> None:
    """A robot of tasks/ with its plant from a corner of the share, pushed about as its file says, drawn in these planes."""
    controller = build(TASKS / f"{name}.toml")
    task, file = controller.task, TASKS / f"{name}.py"
    plant = plant_of(str(file) if file.exists() else "integrator", task.dimension, task.order)
    start = random_start(controller.certificate.start, 0.99 * float(task.initial_set.share), 2, corner=True)
    strength = float(plant.w_max or task.disturbance_bound)
    run = Loop(controller, plant).run(
        Scenario(disturbance="outward", strength=strength, seed=2, start=start, **scenario_of_task(task)), trace=True
    )
    draw_run(controller, run, HERE / f"{name}.png", [plane_named(task, text) for text in axes])


def main() -> None:
    robot("arm")
    robot("attitude", "pitch,yaw")
    robot("base")
    robot("drone", "x,y", "x,z")
    robot("rover")
    draw_figure3([driven(name) for name in ("omni_s1", "omni_s2", "omni_s3")], HERE / "figure3.png")
    adaptive = build(TASKS / "omni_s2.toml", "adaptive")
    run = Loop(adaptive, INTEGRATOR).run(Scenario(rate=4000.0, disturbance="sinusoidal", strength=WIND, seed=1), trace=True)
    draw_figure1(adaptive, run, HERE / "figure1.png")
    slow = build(TASKS / "omni_s2.toml")
    draw_run(
        slow,
        Loop(slow, INTEGRATOR).run(Scenario(rate=20.0, disturbance="outward", strength=WIND), trace=True),
        HERE / "sampled_too_slowly.png",
    )
    draw(build(TASKS / "omni_s2.toml"), HERE / "omni_s2.png")
    pair = [build(TASKS / "omni_s1.toml", design, uncertified=True) for design in ("literal", "refined")]
    draw_beside(pair, ["as printed: (5)-(11)", "as shipped: refined, certified"], HERE / "literal_beside_refined.png")


if __name__ == "__main__":
    main()
