"""Prints the table of docs/drive.md: its robot with drives of several lags. Run python docs/drive_example.py."""

from pathlib import Path

from stt_codegen.loop import Request, simulate
from stt_codegen.pipeline import EmittedController, build_task
from stt_codegen.task import parse_task

PAGE = Path(__file__).parent / "drive.md"
LAGS = (0.0, 0.08, 0.16, 0.32)  # seconds: none, the proved one, twice and four times that
START = "1.23,0.97"  # near a corner of the start share


def controller_of_page() -> EmittedController:
    """Build the controller of the first task file on the page."""
    return build_task(parse_task(PAGE.read_text().partition("```toml\n")[2].partition("```")[0]))


def table(controller: EmittedController) -> str:
    """Return the table: for each lag the worst run within [plant], and what is proved of it before."""
    lines = ["| lag, s | largest \\|e\\| | the tube | the task | proved before the run |", "|---|---|---|---|---|"]
    for lag in LAGS:
        report = simulate(controller, Request(plant="bounds", lag=lag, start=START), None)
        run, verdict = report.run, report.proof_lines[-1].partition(":")[0].partition(",")[0]
        tube = "kept" if run.kept else "**left**"
        outcome = "met" if run.good else f"**missed**: {'no arrival' if run.hit is None else f'into {run.hit}'}"
        lines.append(f"| {lag:g} | {', '.join(f'{e:.2f}' for e in run.e)} | {tube} | {outcome} | {verdict} |")
    return "\n".join(lines)


if __name__ == "__main__":
    print(table(controller_of_page()))
