"""Tables about the peers, for `python -m benchmarks arenas --peers` (benchmarks/suites/command.py calls them).

They are: a row for each peer, Table I of the paper beside measured numbers, policies, grids, and costs on a board.
"""

from __future__ import annotations

import tracemalloc
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.peers.in_arenas import PeerOutcome, all_peers
from benchmarks.peers.in_loops import GRIDS, POLICIES, ROBOT
from benchmarks.peers.policy import load_policy
from benchmarks.peers.symbolic import Abstraction, simulate_runs, synthesize
from benchmarks.suites.families import FAMILIES, cubes, is_feasible
from benchmarks.suites.report import number
from stt_codegen.design_kinds import DesignKind
from stt_codegen.errors import MissingTool

PAPER = FAMILIES["paper"]
HEADINGS = ("peer", "asked", "success", "median / 95 %", "guarantees", "does not")
TABLE_I = ("algorithm", "printed: success", "printed: s", "what runs here", "success", "s, median / 95 %")
# Table I of Das and Jagtap (2024): 500 arenas; per cent, and seconds in MATLAB on an i7-11700;
# then how names of the peers begin that are measured beside it.
PRINTED = (
    ("A*", 95.40, 3.32, ("A* (pyastar2d), 101 x 101",)),
    ("RRT*", 97.40, 10.57, ("OMPL RRT*, first solution",)),
    ("RL", 99.20, 99.31, ("reinforcement learning",)),
    ("symbolic control", 100.00, 295.46, ("symbolic control,",)),
    ("spatiotemporal tubes", 100.00, 0.02, ()),
)
RUNS = ("policy", "runs", "in the target at 9 s", "met an unsafe set", "left the room", "good", "a step, median / 95 %")
DESIGN_LABELS: Mapping[DesignKind, str] = {"literal": "as printed", "adaptive": "its functions, mended", "refined": "ours"}
SYMBOLIC = (
    "grid",
    "inputs",
    "period, ms",
    "table, B",
    "memory, MB",
    "states that win",
    "runs",
    "hit at samples",
    "hit between",
    "arrive",
)
BOARD = ("on a Cortex-M4F", "instructions, least / median / most", "code B", "tables B", "stack B")


def peer_rows(outcomes: dict[str, list[PeerOutcome]], policies: Path = POLICIES) -> list[list[str]]:
    """Return a row of HEADINGS for each peer. outcomes: in the arenas, by the peer's name."""
    return [
        [p.name, p.question, _success(outcomes[p.name]), _times(outcomes[p.name], p.timed == "step"), p.guarantees, p.lacks]
        for p in all_peers(policies)
    ]


def _success(outcomes: Sequence[PeerOutcome]) -> str:
    return f"{sum(o.success for o in outcomes)} of {len(outcomes)}"


def _times(outcomes: Sequence[PeerOutcome], step: bool) -> str:
    scale, unit = (1e6, "us a step") if step else (1e3, "ms")
    middle, late = (number(scale * float(np.percentile([o.seconds for o in outcomes], k))) for k in (50, 95))
    return f"{middle} / {late} {unit}"


def policy_rows(outcomes: dict[str, list[PeerOutcome]], policies: Path = POLICIES) -> list[list[str]]:
    """Return a row of RUNS for each policy: how its runs ended."""
    rows = []
    for peer in all_peers(policies):
        runs = [r for o in outcomes[peer.name] for r in o.runs]
        if runs:
            counts = (
                sum(v) for v in zip(*((r.reached, r.hit is not None, r.left_at is not None, r.good) for r in runs), strict=True)
            )
            rows.append([peer.name, f"{len(runs):,}", *(f"{c:,}" for c in counts), _times(outcomes[peer.name], True)])
    return rows


def table_i(outcomes: dict[str, list[PeerOutcome]], tubes: Sequence[Any], policies: Path = POLICIES) -> list[list[str]]:
    """Return the rows of the paper's Table I beside measured ones. tubes: summaries of our designs in the paper's arenas."""
    rows: list[list[str]] = []
    for name, success, seconds, prefixes in PRINTED:
        first, before = [name, f"{success:.1f} %", f"{seconds:g}"], len(rows)
        for peer in (p for p in all_peers(policies) if p.name.startswith(tuple(prefixes)) and prefixes):
            is_trained = peer.timed == "step"
            seconds_text = (
                _times(outcomes[peer.name], False) if not is_trained else f"{_training(peer.name, policies)} once for all arenas"
            )
            rows.append([*first, peer.name, _success(outcomes[peer.name]), seconds_text])
            first = ["", "", ""]
        for s in sorted(tubes, key=lambda s: list(DESIGN_LABELS).index(s.design)) if not prefixes else ():
            result = "certified" if s.certified else "none is a tube"
            median, late = (number(v) for v in (s.both_ms if s.certified else s.design_ms))
            rows.append(
                [
                    *first,
                    f"{s.design} ({DESIGN_LABELS[s.design]}): {result}",
                    f"{s.certified} of {s.arenas}",
                    f"{median} / {late} ms",
                ]
            )
            first = ["", "", ""]
        if len(rows) == before:
            rows.append([*first, "left out: `make policies` trains them", "", ""])
    return rows


def _training(name: str, policies: Path) -> str:
    seed = name.rsplit(" ", 1)[1]
    return f"{load_policy(policies / f'policy_{seed}.npz').training_seconds / 60:.0f} min"


def feasibility_sentence(count: int) -> str:
    """Return a sentence about how many of the first `count` arenas are feasible at several distances."""
    reaches = (1e-6, 0.02, 0.055, 0.1)  # 5.5 cm: half of min_width, and the clearance
    feasible_counts = [sum(is_feasible(PAPER, seed, reach) for seed in range(count)) for reach in reaches]
    return (
        f"Of {count} arenas {feasible_counts[0]} have a way for a point, {feasible_counts[1]} for one that keeps 2 cm, "
        f"{feasible_counts[2]} for one that keeps 5.5 cm and {feasible_counts[3]} for one that keeps 10 cm from everything."
    )


def symbolic_rows(with_robot: bool = True) -> list[list[str]]:
    """Return a row of SYMBOLIC for each grid on the first arena. with_robot: whether the grid of three states is among them."""
    grids: dict[str, Abstraction] = {**GRIDS, **({"100 x 100 x 72, three states": ROBOT} if with_robot else {})}
    rows = []
    for name, a in grids.items():
        tracemalloc.start()  # it slows the synthesis, whose time is in the peers' table
        controller = synthesize(PAPER, cubes(PAPER, 0), a)
        memory = number(tracemalloc.get_traced_memory()[1] / 1e6)
        tracemalloc.stop()
        wins, runs = 100 * float((controller.table < len(a.inputs(2))).mean()), simulate_runs(controller, cubes(PAPER, 0))
        rows.append(
            [
                name,
                str(len(a.inputs(2))),
                number(1e3 * float(a.period)),
                f"{controller.table.size:,}",
                memory,
                f"{wins:.0f} %",
                f"{runs.runs:,}",
                str(runs.at_samples),
                str(runs.between),
                f"{runs.arrived:,}",
            ]
        )
    return rows


def board_rows(policies: Path = POLICIES) -> list[list[str]]:
    """Return a row of BOARD for our controllers, grids and a policy on a Cortex-M4F; one of its own where tools are missing."""
    from benchmarks.suites.mcu import other_costs
    from stt_codegen.board.boards import BOARDS

    squares = cubes(PAPER, 0)
    sources = {
        f"symbolic control, {n}": synthesize(PAPER, squares, GRIDS[n]).source() for n in ("50 x 50", "100 x 100", "200 x 200")
    }
    for path in sorted(policies.glob("policy_*.npz"))[:1]:
        sources["reinforcement learning"] = load_policy(path).source(squares)
    try:
        lines = list(other_costs(BOARDS["m4f"], sources))
    except MissingTool as error:
        return [[f"left out: {error}", "", "", "", ""]]
    return [
        [v.label, f"{v.minimum:,.0f} / {v.median:,.0f} / {v.maximum:,.0f}", f"{v.code:,}", f"{v.tables:,}", f"{v.stack:,}"]
        for v in lines
    ]
