"""`python -m benchmarks missions`: design and prove missions, beside the mixed-integer programs of stlpy and published times.

benchmarks/command_line.py has the options. docs/missions.md describes missions.
"""

from __future__ import annotations

import json
import statistics
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.peers.milp import share_violated_between_samples, solve_mission
from benchmarks.suites.report import command, machine, number, record, table, versions
from benchmarks.suites.scenarios import SCENARIO_FAMILIES, Scenario, connected_stones, moving_mission, random_mission
from stt_codegen.certify.claims import units_of_error
from stt_codegen.certify.missions.proof import SLICES, certify_mission
from stt_codegen.controller.edge_errors import edge_error
from stt_codegen.designs.refined import RefinedDesign
from stt_codegen.errors import SttError
from stt_codegen.pipeline import build, build_program, certify, preferred_tube
from stt_codegen.task.load import parse_task
from stt_codegen.task.task import Task

TASKS = Path(__file__).parents[2] / "tasks"
PUBLISHED = (  # names of tasks, and the seconds that their authors state in their code's comments, for another machine
    ("robot over waypoints, in full", ("waypoints",), 808.0),
    ("the same in three legs", ("mission_leg1", "mission_leg2", "mission_leg3"), 808.0),
    ("one of two waypoints", ("either",), 97.0),
    ("spacecraft", ("spacecraft",), 97.0),
)
RANDOM_MISSIONS = ((2, 10, 100), (2, 30, 100), (3, 10, 50))  # dimensions, unsafe sets, number of missions
MOVING_MISSIONS = ((2, 8, 40), (3, 10, 20))  # likewise, and the sets move
REQUIRED_SHARE = 0.98  # of random missions among sets at rest that must be certified
STRENGTHS = (  # of peers: who, better than ours, guarantees
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
REPEATS = 5  # runs of each published task


@dataclass(frozen=True)
class MissionRun:
    """The result of one mission.

    design: milliseconds of search and linear programs. proof: of the mission's property (P10). certificate: of all properties.
    width: smallest of the tube. speed: largest. time_margin: by how much every time may be wrong, in thousandths of t_c. refusal:
    why it is not certified.
    """

    name: str
    certified: bool
    design: float
    proof: float
    certificate: float
    width: float
    speed: float
    time_margin: float = 0.0
    refusal: str = ""


def run_mission(name: str, task: Task) -> MissionRun:
    """Design and certify a mission once, and measure the time."""
    begin = time.perf_counter()
    try:
        design = preferred_tube(task)
    except SttError as error:
        return MissionRun(name, False, 1e3 * (time.perf_counter() - begin), 0.0, 0.0, 0.0, 0.0, refusal=str(error))
    assert isinstance(design, RefinedDesign)
    design_seconds, program = time.perf_counter() - begin, build_program(task, design)
    begin = time.perf_counter()
    certificate = certify(task, design, program)
    certificate_seconds = time.perf_counter() - begin
    begin = time.perf_counter()
    _, proof = certify_mission(task, design, units_of_error(design, edge_error(design, program)))
    proof_seconds = time.perf_counter() - begin
    return MissionRun(
        name=name,
        certified=certificate.holds,
        design=1e3 * design_seconds,
        proof=1e3 * proof_seconds,
        certificate=1e3 * certificate_seconds,
        width=float(certificate.minimum_width),
        speed=max(float(v) for v in certificate.speed),
        time_margin=0.0 if proof is None else 1e3 * proof.time_margin / (design.segments * SLICES),
        refusal="" if certificate.holds else certificate.refusal(),
    )


def run_text(name: str, text: str) -> MissionRun:
    """Design and certify the mission of a task file once."""
    return run_mission(name, parse_task(text))


def summary_row(title: str, runs: list[MissionRun]) -> list[str]:
    """Return the table's row about many missions; times and widths are of those that are certified."""
    certified = [run for run in runs if run.certified]
    times = sorted(run.design for run in certified) or [float("nan")]
    late = times[min(len(times) - 1, int(0.95 * len(times)))]
    medians = [
        statistics.median([getattr(r, name) for r in certified] or [float("nan")])
        for name in ("proof", "width", "speed", "time_margin")
    ]
    return [
        title, f"{len(certified)} of {len(runs)}", number(statistics.median(times)), number(late), *map(number, medians)
    ]  # fmt: skip


def run_missions(count: int | None, limit: float, out: Path | None, as_json: bool, say: Callable[[str], None]) -> bool:
    """Run all missions, and print the report or JSON. say: called with the name of each part that is done.

    count: of random missions of each kind; None for the usual number. limit: seconds for each of stlpy's programs, 0 to leave
    them out. Return whether every scenario ended as it must, and REQUIRED_SHARE of the random missions among sets at rest were
    certified.
    """
    run_text("warm up", next(SCENARIO_FAMILIES["stlpy"]()).text)
    endless = Scenario("patrol of three regions, for ever", (TASKS / "watchman.toml").read_text())
    all_scenarios = [*(s for family in SCENARIO_FAMILIES.values() for s in family()), endless]
    scenarios = [(s, run_text(s.name, s.text)) for s in all_scenarios]
    say(f"{len(scenarios)} scenarios")
    peers = {s.name: list(_peer_results(s.text, limit)) for s in SCENARIO_FAMILIES["stlpy"]()} if limit else {}
    say("programs of stlpy")
    stones = [run_text(s.name, s.text) for size in (100, 150) for s in connected_stones(size, 3)]
    groups: list[tuple[str, list[MissionRun]]] = [("connected stones, 100 and 150", stones)]
    for n, unsafe, usual_count in RANDOM_MISSIONS:
        runs = [run_text(str(k), random_mission(k, n, unsafe)) for k in range(count or usual_count)]
        groups.append((f"{n}-D, {unsafe} unsafe sets", runs))
        say(groups[-1][0])
    for n, unsafe, usual_count in MOVING_MISSIONS:
        runs = [run_text(str(k), moving_mission(k, n, unsafe)) for k in range(min(count or usual_count, usual_count))]
        groups.append((f"{n}-D, {unsafe} sets that move, three windows of 2 s", runs))
        say(groups[-1][0])
    if as_json:
        random_runs = {title: [asdict(r) for r in runs] for title, runs in groups}
        print(json.dumps({"scenarios": [asdict(r) for _, r in scenarios], "random": random_runs}))
    else:
        text = _report(scenarios, peers, groups)
        print(text)
        if out is not None:
            record(out, "missions", text)
    scenarios_end_well = all(run.certified != s.is_infeasible for s, run in scenarios)
    at_rest = groups[: 1 + len(RANDOM_MISSIONS)]
    return scenarios_end_well and all(sum(r.certified for r in runs) >= REQUIRED_SHARE * len(runs) for _, runs in at_rest)


def _peer_results(text: str, limit: float) -> Iterator[str]:
    """Yield the results of stlpy's standard and logarithmic programs for a scenario."""
    task = parse_task(text)
    for logarithmic in (False, True):
        answer = solve_mission(task, logarithmic, limit)
        if answer.path is None:
            yield f"{answer.status}, {answer.seconds:.2g} s"
        else:
            wrong = share_violated_between_samples(task, answer.path)
            yield f"{answer.seconds:.2g} s" + (f", wrong for {100 * wrong:.0f} % of its way" if wrong > 0 else "")


def _scenario_table(scenarios: list[tuple[Scenario, MissionRun]], peers: dict[str, list[str]]) -> str:
    """Return a row for each scenario, beside what stlpy's two programs make of it. The margin is in thousandths of t_c."""
    rows = []
    for s, run in scenarios:
        cells = ["refused", number(run.design), "", "", "", ""] if not run.certified else [
            "proved", number(run.design), number(run.proof), number(run.speed), number(run.width), number(run.time_margin)
        ]  # fmt: skip
        rows.append([s.name, *cells, *peers.get(s.name, ["", ""])])
    head = [
        "mission",
        "",
        "design [ms]",
        "P10 [ms]",
        "peak speed",
        "least width",
        "margin in time",
        "standard program",
        "logarithmic program",
    ]
    return table(head, rows)


def _published_table() -> str:
    """Build the published tasks, and return the seconds beside those of their authors."""
    rows = []
    for title, names, published_seconds in PUBLISHED:
        times = []
        for _ in range(REPEATS):
            begin = time.perf_counter()
            for name in names:
                build(TASKS / f"{name}.toml", "refined", "float")  # raises where it is not certified
            times.append(time.perf_counter() - begin)
        median = statistics.median(times)
        rows.append([title, f"{median:.3f}", f"{times[0]:.3f}", f"{published_seconds:g}", f"{published_seconds / median:.0f}"])
    return table(["published task, to certified C", "seconds", "the first time", "published seconds", "times as long"], rows)


NOTE = (
    "The programs are those of stlpy (Kurtz and Lin, 2022) in HiGHS, one thread: a double integrator at samples a second "
    "apart, any solution. Their samples satisfy the formula; between samples the straight way may be in an unsafe set, or "
    "off every stone. Of the stepping stones of seed 1 no continuous solution exists: the stones are not connected. Ours are "
    "tubes for plants that nobody knows, proved for all times. Published seconds are the authors', for synthesis by an SMT "
    'solver at sampled times on another machine; of "one of two waypoints" those of the faster choice.'
)


def _report(
    scenarios: list[tuple[Scenario, MissionRun]], peers: dict[str, list[str]], groups: list[tuple[str, list[MissionRun]]]
) -> str:
    """Return all tables as Markdown. peers: results of stlpy's two programs, by scenario. groups: runs of random missions."""
    head = ["random missions", "carried out", "design: median [ms]", "95 % [ms]", "P10: median [ms]", "least width: median"]
    head += ["peak speed: median", "margin in time: median [t_c/1000]"]
    random_table = table(head, [summary_row(title, runs) for title, runs in groups])
    strengths = f"{table(['who', 'better than ours', 'guarantees'], STRENGTHS)}\n\n" if peers else ""
    origin = f"Made by `{command()}`; {machine()}{versions()}."
    tables = f"{_scenario_table(scenarios, peers)}\n\n{NOTE}\n\n{strengths}{random_table}\n\n{_published_table()}"
    return f"## Missions\n\n{origin}\n\n{tables}"
