"""`python -m benchmarks missions`: missions designed and proved, beside the mixed-integer programs of stlpy and published
times."""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.peers.milp import between, solved
from benchmarks.suites.report import command, machine, number, record, table, versions
from benchmarks.suites.scenarios import FAMILIES, Scenario, connected_stones, moving_mission, random_mission
from stt_codegen.certify.claims import units_of_error
from stt_codegen.certify.missions.proof import certify_mission
from stt_codegen.controller.edge_errors import edge_error
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import SttError
from stt_codegen.pipeline import build, build_program, certify, design_tube
from stt_codegen.task.load import parse_task
from stt_codegen.task.task import Task

TASKS = Path(__file__).parents[2] / "tasks"
PUBLISHED = (  # names of tasks, and seconds as the authors state them in their code's comments; their machine is another
    ("robot over waypoints, in full", ("waypoints",), 808.0),
    ("the same in three legs", ("mission_leg1", "mission_leg2", "mission_leg3"), 808.0),
    ("one of two waypoints", ("either",), 97.0),
    ("spacecraft", ("spacecraft",), 97.0),
)
RANDOM = ((2, 10, 100), (2, 30, 100), (3, 10, 50))  # dimensions, unsafe sets, missions
MOVING = ((2, 8, 40), (3, 10, 20))
DEMAND = 0.98  # of random missions among sets that stand are carried out, or the command fails
WORTH = (
    (
        "stlpy's programs",
        "any linear predicate, not only boxes; the most robust plan or the one of least cost; limits of u and dynamics in one "
        "program; says when there is no plan at its samples",
        "the formula at the samples, of the model, without wind: nothing between them and no feedback",
    ),
    (
        "tubes by an SMT solver (arXiv 2505.05323)",
        "the same laws for unknown plants; polynomials in time, so no table of segments",
        "the tube at sampled times; between them where a Lipschitz constant of the whole is known and the samples are that dense",
    ),
)
REPEATS = 5  # of each published task


@dataclass(frozen=True)
class Run:
    """One mission: milliseconds of search and programs, of the proof of P10, of the whole certificate;
    least width, peak speed."""

    name: str
    certified: bool
    design: float
    proof: float
    certificate: float
    width: float
    speed: float
    told: str = ""


def measured(name: str, text: str) -> Run:
    """A mission once."""
    return of_task(name, parse_task(text))


def of_task(name: str, task: Task) -> Run:
    begin = time.perf_counter()
    try:
        design = design_tube(task)
    except SttError as error:
        return Run(name, False, 1e3 * (time.perf_counter() - begin), 0.0, 0.0, 0.0, 0.0, str(error))
    assert isinstance(design, RefinedDesign)
    found, program = time.perf_counter(), build_program(task, design)
    made = time.perf_counter()
    certificate = certify(task, design, program)
    proved = time.perf_counter()
    certify_mission(task, design, units_of_error(design, edge_error(design, program)))
    alone = time.perf_counter() - proved
    speed = max(float(v) for v in certificate.speed)
    told = "" if certificate.holds else certificate.refusal()
    took, alone, proof = (1e3 * v for v in (found - begin, alone, proved - made))
    return Run(name, certificate.holds, took, alone, proof, float(certificate.minimum_width), speed, told)


def summary(title: str, runs: list[Run]) -> list[str]:
    """A row about many missions."""
    good = [run for run in runs if run.certified]
    times = sorted(run.design for run in good) or [float("nan")]
    late, proof = times[min(len(times) - 1, int(0.95 * len(times)))], statistics.median([r.proof for r in good] or [float("nan")])
    widths = statistics.median([r.width for r in good] or [float("nan")])
    return [title, f"{len(good)} of {len(runs)}", number(statistics.median(times)), number(late), number(proof), number(widths)]


def run_missions(count: int | None, limit: float, out: Path | None, as_json: bool, say: Callable[[str], None]) -> bool:
    """`python -m benchmarks missions`. True where DEMAND of the random missions among standing sets are carried out, and every
    scenario."""
    measured("warm up", next(FAMILIES["stlpy"]()).text)
    endless = Scenario("patrol of three regions, for ever", (TASKS / "watchman.toml").read_text())
    every = [*(s for family in FAMILIES.values() for s in family()), endless]
    scenarios = [(s, measured(s.name, s.text)) for s in every]
    say(f"{len(scenarios)} scenarios")
    peers = {s.name: list(_peers(s.text, limit)) for s in FAMILIES["stlpy"]()} if limit else {}
    say("programs of stlpy")
    stones = [measured(s.name, s.text) for size in (100, 150) for s in connected_stones(size, 3)]
    many: list[tuple[str, list[Run]]] = [("connected stones, 100 and 150", stones)]
    for n, unsafe, most in RANDOM:
        many.append(
            (f"{n}-D, {unsafe} unsafe sets", [measured(str(k), random_mission(k, n, unsafe)) for k in range(count or most)])
        )
        say(many[-1][0])
    for n, movers, most in MOVING:
        runs = [measured(str(k), moving_mission(k, n, movers)) for k in range(min(count or most, most))]
        many.append((f"{n}-D, {movers} sets that move, three windows of 2 s", runs))
        say(many[-1][0])
    if as_json:
        print(
            json.dumps({"scenarios": [asdict(r) for _, r in scenarios], "random": {t: [asdict(r) for r in rs] for t, rs in many}})
        )
    else:
        text = _told(scenarios, peers, many)
        print(text)
        if out is not None:
            record(out, "missions", text)
    good = all(run.certified != s.closed for s, run in scenarios)
    standing = many[: 1 + len(RANDOM)]
    return good and all(sum(r.certified for r in runs) >= DEMAND * len(runs) for _, runs in standing)


def _peers(text: str, limit: float) -> Iterator[str]:
    """What stlpy's two programs say of a scenario."""
    task = parse_task(text)
    for logarithmic in (False, True):
        answer = solved(task, logarithmic, limit)
        if answer.path is None:
            yield f"{answer.status}, {answer.seconds:.2g} s"
        else:
            wrong = between(task, answer.path)
            yield f"{answer.seconds:.2g} s" + (f", wrong for {100 * wrong:.0f} % of its way" if wrong > 0 else "")


def _told(scenarios: list[tuple[Scenario, Run]], peers: dict[str, list[str]], many: list[tuple[str, list[Run]]]) -> str:
    rows = []
    for s, run in scenarios:
        ours = ["refused", number(run.design), "", "", ""] if not run.certified else [
            "proved", number(run.design), number(run.proof), number(run.speed), number(run.width)
        ]  # fmt: skip
        rows.append([s.name, *ours, *peers.get(s.name, ["", ""])])
    first = table(
        ["mission", "", "design [ms]", "P10 [ms]", "peak speed", "least width", "standard program", "logarithmic program"], rows
    )
    second = table(
        ["random missions", "carried out", "design: median [ms]", "95 % [ms]", "P10: median [ms]", "least width: median"],
        [summary(title, runs) for title, runs in many],
    )
    published = []
    for title, names, theirs in PUBLISHED:
        times = []
        for _ in range(REPEATS):
            begin = time.perf_counter()
            for name in names:
                build(TASKS / f"{name}.toml", "refined", "float")  # raises where it is not certified
            times.append(time.perf_counter() - begin)
        ours_ = statistics.median(times)
        published.append([title, f"{ours_:.3f}", f"{times[0]:.3f}", f"{theirs:g}", f"{theirs / ours_:.0f}"])
    third = table(
        ["published task, to certified C", "seconds", "the first time", "published seconds", "times as long"], published
    )
    note = (
        "The programs are those of stlpy (Kurtz and Lin, 2022) in HiGHS, one thread: a double integrator at samples a second "
        "apart, any solution. Their samples satisfy the formula; between samples the straight way may be in an unsafe set, or "
        "off every stone. Of the stepping stones of seed 1 no continuous solution exists: the stones are not connected. Ours are "
        "tubes for plants that nobody knows, proved for all times. Published seconds are the authors', for synthesis by an SMT "
        'solver at sampled times on another machine; of "one of two waypoints" those of the faster choice.'
    )
    worth = f"{table(['who', 'better than ours', 'guarantees'], WORTH)}\n\n" if peers else ""
    return f"## Missions\n\nMade by `{command()}`; {machine()}{versions()}.\n\n{first}\n\n{note}\n\n{worth}{second}\n\n{third}"
