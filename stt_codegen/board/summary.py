"""One line about a run on an emulated board, for the report's evidence."""

from __future__ import annotations

from stt_codegen.board.boards import BOARDS
from stt_codegen.board.emulated import run_on_board
from stt_codegen.errors import BadInput
from stt_codegen.pipeline import EmittedController
from stt_codegen.report.page import Check

POINTS = 500  # random points, beside the edges


def require_board(name: str) -> None:
    """Raise `BadInput` for an unknown board."""
    if name not in BOARDS:
        raise BadInput(f"--board {name}: is none of {', '.join(BOARDS)}")


def on_board(controller: EmittedController, name: str) -> Check:
    """Run the C on a board and compare it with the reference, as `pil` does. Raises `BadInput` for an unknown board."""
    require_board(name)
    board = BOARDS[name]
    rows, costs = run_on_board(controller, board, POINTS)
    lines = [f"{f}: {c.minimum} to {c.maximum} {board.unit}, {c.stack} B of stack" for f, c in costs.items()]
    worst = max(rows, key=lambda r: r.share)
    lines.append(f"{sum(r.points for r in rows):,} values, nearest to its bound: {worst.quantity}, at {worst.share:.0%} of it")
    return Check(f"{board.title}, emulated", all(r.holds for r in rows), "; ".join(lines))
