"""The peers' tables of `python -m benchmarks arenas --peers`: everyone's row, Table I of the paper beside what is measured here,
and the grids."""

from __future__ import annotations

import tracemalloc
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks.peers.in_arenas import Outcome, all_peers
from benchmarks.peers.in_loops import GRIDS, POLICIES, ROBOT
from benchmarks.peers.policy import load_policy
from benchmarks.peers.symbolic import Abstraction, synthesize, tried
from benchmarks.suites.families import FAMILIES, cubes, is_feasible
from benchmarks.suites.report import number
from stt_codegen.design_kinds import DesignKind
from stt_codegen.errors import MissingTool

PAPER = FAMILIES["paper"]
HEADINGS = ("peer", "asked", "success", "median / 95 %", "guarantees", "does not")
TABLE_I = ("algorithm", "printed: success", "printed: s", "what runs here", "success", "s, median / 95 %")
# Table I of Das and Jagtap (2024): 500 arenas; per cent, and seconds in MATLAB on an i7-11700.
PRINTED = (
    ("A*", 95.40, 3.32, ("A* (pyastar2d), 101 x 101",)),
    ("RRT*", 97.40, 10.57, ("OMPL RRT*, first solution",)),
    ("RL", 99.20, 99.31, ("reinforcement learning",)),
    ("symbolic control", 100.00, 295.46, ("symbolic control,",)),
    ("spatiotemporal tubes", 100.00, 0.02, ()),
)
RUNS = ("policy", "runs", "in the target at 9 s", "met an unsafe set", "left the room", "good", "a step, median / 95 %")
WORDS: Mapping[DesignKind, str] = {"literal": "as printed", "adaptive": "its functions, mended", "refined": "ours"}
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


def peer_rows(found: dict[str, list[Outcome]], policies: Path = POLICIES) -> list[list[str]]:
    """One row a peer."""
    return [
        [p.name, p.asks, _success(found[p.name]), _times(found[p.name], p.per == "step"), p.guarantees, p.lacks]
        for p in all_peers(policies)
    ]


def _success(outcomes: Sequence[Outcome]) -> str:
    return f"{sum(o.success for o in outcomes)} of {len(outcomes)}"


def _times(outcomes: Sequence[Outcome], step: bool) -> str:
    scale, unit = (1e6, "us a step") if step else (1e3, "ms")
    middle, late = (number(scale * float(np.percentile([o.seconds for o in outcomes], k))) for k in (50, 95))
    return f"{middle} / {late} {unit}"


def policy_rows(found: dict[str, list[Outcome]], policies: Path = POLICIES) -> list[list[str]]:
    """How every run of every policy ended."""
    rows = []
    for peer in all_peers(policies):
        runs = [r for o in found[peer.name] for r in o.runs]
        if runs:
            counts = (
                sum(v) for v in zip(*((r.reached, r.hit is not None, r.left_at is not None, r.good) for r in runs), strict=True)
            )
            rows.append([peer.name, f"{len(runs):,}", *(f"{c:,}" for c in counts), _times(found[peer.name], True)])
    return rows


def table_i(found: dict[str, list[Outcome]], tubes: Sequence[Any], policies: Path = POLICIES) -> list[list[str]]:
    """The paper's Table I beside what is measured. tubes: summaries of `arenas` of the paper's family."""
    rows: list[list[str]] = []
    for name, success, seconds, starts in PRINTED:
        first, before = [name, f"{success:.1f} %", f"{seconds:g}"], len(rows)
        for peer in (p for p in all_peers(policies) if p.name.startswith(tuple(starts)) and starts):
            trained = peer.per == "step"
            took = _times(found[peer.name], False) if not trained else f"{_training(peer.name, policies)} once for all arenas"
            rows.append([*first, peer.name, _success(found[peer.name]), took])
            first = ["", "", ""]
        for s in sorted(tubes, key=lambda s: list(WORDS).index(s.design)) if not starts else ():
            whole = s.both_ms if s.certified else s.design_ms
            told = "certified" if s.certified else "none is a tube"
            median, late = (number(v) for v in whole)
            rows.append(
                [*first, f"{s.design} ({WORDS[s.design]}): {told}", f"{s.certified} of {s.arenas}", f"{median} / {late} ms"]
            )
            first = ["", "", ""]
        if len(rows) == before:
            rows.append([*first, "left out: `make policies` trains them", "", ""])
    return rows


def _training(name: str, policies: Path) -> str:
    seed = name.rsplit(" ", 1)[1]
    return f"{load_policy(policies / f'policy_{seed}.npz').trained / 60:.0f} min"


def ways(count: int) -> str:
    """How many of the arenas have a way at all."""
    reaches = (1e-6, 0.02, 0.055, 0.1)  # 5.5 cm: half of min_width, and the clearance
    having = [sum(is_feasible(PAPER, seed, reach) for seed in range(count)) for reach in reaches]
    return (
        f"Of {count} arenas {having[0]} have a way for a point, {having[1]} for one that keeps 2 cm, "
        f"{having[2]} for one that keeps 5.5 cm and {having[3]} for one that keeps 10 cm from everything."
    )


def symbolic_rows(robot: bool = True) -> list[list[str]]:
    """Every grid on the first arena."""
    grids: dict[str, Abstraction] = {**GRIDS, **({"100 x 100 x 72, three states": ROBOT} if robot else {})}
    rows = []
    for name, a in grids.items():
        tracemalloc.start()  # it slows what it counts: times stand in the peers' table
        made = synthesize(PAPER, cubes(PAPER, 0), a)
        memory = number(tracemalloc.get_traced_memory()[1] / 1e6)
        tracemalloc.stop()
        wins, runs = 100 * float((made.table < len(a.inputs(2))).mean()), tried(made, cubes(PAPER, 0))
        rows.append(
            [
                name,
                str(len(a.inputs(2))),
                number(1e3 * float(a.period)),
                f"{made.table.size:,}",
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
    """Instructions and bytes of ours, of grids and of a policy on a Cortex-M4F; none where its tools are missing."""
    from benchmarks.suites.mcu import others
    from stt_codegen.board.boards import BOARDS

    squares = cubes(PAPER, 0)
    sources = {
        f"symbolic control, {n}": synthesize(PAPER, squares, GRIDS[n]).source() for n in ("50 x 50", "100 x 100", "200 x 200")
    }
    for path in sorted(policies.glob("policy_*.npz"))[:1]:
        sources["reinforcement learning"] = load_policy(path).source(squares)
    try:
        lines = list(others(BOARDS["m4f"], sources))
    except MissingTool as error:
        return [[f"left out: {error}", "", "", "", ""]]
    return [
        [v.label, f"{v.least:,.0f} / {v.median:,.0f} / {v.most:,.0f}", f"{v.code:,}", f"{v.tables:,}", f"{v.stack:,}"]
        for v in lines
    ]
