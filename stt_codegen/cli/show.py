"""Tables of designs, bounds, closed loops and comparisons that the command line prints; --json has the same as data.

Long because every table of the command line is in one place, with one console.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Sequence
from typing import Any

from rich.console import Console
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from stt_codegen.arrays import entries_of
from stt_codegen.certify.missions import describe_entry
from stt_codegen.compare import ComparisonRow
from stt_codegen.decimals import by_component
from stt_codegen.loop import RunReport, written_drive
from stt_codegen.report import (
    BoundsReport,
    DesignReport,
    SamplingReport,
    TradeReport,
    format_numbers,
    format_time,
    sampling_lines,
)
from stt_codegen.steps import StepEnvelope


class _Console(Console):
    def on_broken_pipe(self) -> None:
        """Leave a closed pipe to `main.run`; Rich would end with exit code 1."""
        raise BrokenPipeError


def _console() -> Any:
    """Return a console as wide as the terminal, or of 120 columns in a file."""
    return _Console(highlight=False, width=None if sys.stdout.isatty() else 120)


def show_design(report: DesignReport) -> None:
    """Print a design: tube, notes, properties, inputs, sampling and cost."""
    console = _console()
    _show_tube(console, report)
    _show_design_notes(console, report)
    _show_properties(console, report)
    limits = report.input
    if limits.largest_u is not None:
        saturated = f", saturated at {', '.join(f'{u:g}' for u in limits.u_max)}" if limits.u_max else ""
        console.print(f"  |u| up to {limits.largest_u:.4g} at the clamp{saturated}")
    for line in limits.chosen:
        _indented(console, escape(line))
    if limits.sampling is not None:
        _show_sampling(console, limits.sampling, limits.tick_period)
    cost = report.cost
    kinds = ", ".join(f"{count} {kind}" for kind, count in cost.operations.items())
    code = f", {cost.host_code_bytes} B of code on this host (-Os)" if cost.host_code_bytes else ""
    console.print(f"  one {' + '.join(cost.functions)} step: {cost.operations_total} operations ({kinds})")
    console.print(f"  {cost.table_bytes} B of tables{code}")
    if report.picture is not None:
        console.print(f"  picture: {report.picture}")


def _show_tube(console: Any, report: DesignReport) -> None:
    """Print the verdict, and the tube's width, speed and cycle."""
    verdict = "[green]certified[/green]" if report.certified else "[red]NOT CERTIFIED[/red]"
    console.print(f"[bold]{report.task}[/bold]: {report.design} tube, {verdict}, {report.seconds} s")
    has_axis_names = any(name != f"x{i + 1}" for i, name in enumerate(report.axes))
    names = [f"{escape(name)} " if has_axis_names else "" for name in report.axes]
    units = [f" {unit}/s" if unit else "" for unit in report.units]
    speed = ", ".join(f"{a}{v:.4g}{unit}" for a, v, unit in zip(names, report.speed_bound, units, strict=True))
    console.print(
        f"  {report.parameters} over {report.prescribed_time:g} s; least width {report.smallest_width:.4g}; "
        f"speed of an edge at most {speed}" + ("" if has_axis_names else " by dimension")
    )
    if report.cycle is not None:
        begin, end = report.cycle
        console.print(f"  for ever: after {begin:g} s it repeats itself every {end - begin:g} s, C2 also where it begins again")


def _show_design_notes(console: Any, report: DesignReport) -> None:
    """Print the notes about how the tube was certified, which starts it covers, and those of the task."""
    if report.method == "sampled":
        console.print(
            "  [yellow]note[/yellow]: checked at samples only, which proves nothing between them; the smooth maximum narrows "
            "gamma(0), so starts near the edge of the initial set are outside"
        )
    elif report.method == "enclosure":
        console.print(
            "  [yellow]note[/yellow]: the smooth maximum narrows gamma(0), so starts near the edge of the initial set are outside"
        )
    elif not report.covers_initial_set:
        left_out = zip(report.axes, report.start_left_out, strict=True)
        sides = ", ".join(f"{v:.3g} in {escape(name)}" for name, v in left_out if v)
        _indented(
            console,
            f"[yellow]note[/yellow]: gamma(0) leaves out a rim of the initial set, up to {sides}: {escape(report.start_cause)}; "
            "starts there are not covered",
        )
    for note in report.notes:
        _indented(console, f"[yellow]note[/yellow]: {escape(note)}")


def _show_properties(console: Any, report: DesignReport) -> None:
    """Print the certified properties with their margins, and the entries of the mission."""
    table = Table(box=None, pad_edge=True, header_style="bold")
    for heading in ("", "property", "holds", "margin", "smallest at"):
        table.add_column(heading, justify="right" if heading == "margin" else "left")
    for p in report.properties:
        holds = "[green]yes[/green]" if p.holds else "[red]NO[/red]"
        table.add_row(f"{p.title} ({p.property})", escape(p.statement), holds, f"{p.margin:.3g}" if p.margin else "", p.where)
    console.print(table)
    for proof in report.mission:
        _indented(console, f"mission {proof.entry}, {escape(describe_entry(proof))}")


def show_trade(report: TradeReport) -> None:
    """Print several tubes of a task, the widest first."""
    console = _console()
    console.print(f"[bold]{report.task}[/bold]: what a tube's width costs; none of these is beaten in all three")
    table = Table(box=None, pad_edge=True, header_style="bold")
    for heading in ("least width", "peak speed", "proved period", "with gain"):
        table.add_column(heading, justify="right")
    table.add_column("tube.prefer")
    for t in report.tubes:
        period, gain = ("none", "") if t.period is None or t.gain is None else (format_time(t.period), by_component(t.gain))
        table.add_row(f"{t.smallest_width:.4g}", f"{t.speed:.4g}", period, gain, ", ".join(t.preferred))
    console.print(table)
    if report.has_drive:
        _indented(console, "periods: with the task's drive, at its gain or the one that is chosen for its period")
    else:
        console.print("  periods: at control.gain, or the longest of the gains tried, for the plant and the starts of the task")
    if report.picture is not None:
        console.print(f"  picture: {report.picture}")


def _indented(console: Any, line: str) -> None:
    """Print a line with an indent of two columns; where it is too long, its rest has an indent of four."""
    text = line.lstrip(" ")
    depth = 2 + len(line) - len(text)
    first, *rest = Text.from_markup(text).wrap(console, console.width - depth - 2)
    for k, part in enumerate((first, *rest)):
        part.rstrip()
        console.print(Text(" " * (depth + 2 * (k > 0))) + part)


def _show_sampling(console: Any, sampling: SamplingReport, tick_period: float | None) -> None:
    for line in sampling_lines(sampling, tick_period):
        _indented(console, "  " * line.is_detail + ("[yellow]note[/yellow]: " if line.is_note else "") + escape(line.text))


def show_bounds(report: BoundsReport) -> None:
    """Print the answer of `prove TASK`: hypotheses, bounds by dimension, and the proved periods."""
    console = _console()
    _show_hypotheses(console, report)
    _show_bound_table(console, report)
    _show_proved_periods(console, report)
    _show_sampling(console, report.sampling, None)
    _show_plant_table(console, report)


def _show_hypotheses(console: Any, report: BoundsReport) -> None:
    """Print the hypotheses, and whether each holds."""
    errors = entries_of("noise", report.noise, len(report.axes))
    noise = f", x measured to {by_component(errors)}" if any(errors) else ""
    noise += f", u {format_time(report.latency)} after its sample" if report.latency else ""
    console.print(f"[bold]{report.task}[/bold], {report.design}, with {escape(report.plant)}{noise}")
    table = Table(box=None, header_style="bold")
    for heading in ("hypothesis", "statement", "holds"):
        table.add_column(heading)
    for h in report.hypotheses:
        table.add_row(escape(h.name), escape(h.statement), "[green]yes[/green]" if h.holds else "[red]NO[/red]")
    console.print(table)
    console.print(f"  for all starts with {report.sampling.starts}:")


def _show_bound_table(console: Any, report: BoundsReport) -> None:
    """Print the bounds of tube, plant and continuous control, a column for each axis."""
    tube, plant, continuous = report.tube, report.plant_over_the_tube, report.continuous
    rows = {
        "tube, lowest": tube.lower,
        "tube, highest": tube.upper,
        "least width": tube.smallest_width,
        "largest width": tube.largest_width,
        "speed of an edge": tube.speed,
        "|f + w|": plant.disturbance,
        "g_ii, least": plant.smallest_g_diagonal,
        "|g_ij|, largest": plant.largest_g_cross,
        "eps* (continuous)": continuous.epsilon_star,
        "|u| (continuous)": continuous.u,
    }
    numbers = Table(box=None, header_style="bold")
    numbers.add_column("bound")
    for name in report.axes:
        numbers.add_column(name, justify="right")
    for name, values in rows.items():
        numbers.add_row(name, *map(_or_none, values))
    console.print(numbers)
    console.print(f"  |eps|, all of it (continuous): {_or_none(continuous.epsilon_star_norm)}")
    if None in (*continuous.epsilon_star, continuous.epsilon_star_norm):
        console.print(
            "  none: nothing below eps(e_max) is shown for continuous control, by component not where inputs are coupled"
        )


def _show_proved_periods(console: Any, report: BoundsReport) -> None:
    """Print the period that each form of the sampling conditions proves."""
    for name, p in report.sampled.items():
        if p is None:
            console.print(f"  sampled, {name}: proves no period")
            continue
        tightest = f"tightest at {p.critical_window[0]:.4g} to {p.critical_window[1]:.4g} s"
        tightest += f", x{p.critical_dimension}" if p.critical_dimension else ""
        note = "; conservative: adversaries need 4 times as long or more" if name == "general" else ""
        console.print(f"  sampled, {name}: {format_time(p.period)}, |e| below {format_numbers(p.e)}; {tightest}{note}")


def _show_plant_table(console: Any, report: BoundsReport) -> None:
    """Print the table [plant] that states the bounds of a plant with equations, or why there is none."""
    proposed = report.proposed
    if proposed is None:
        return
    if proposed.reason:
        _indented(console, f"no \\[plant] can state this plant: {escape(proposed.reason)}")
        return
    console.print("  as bounds in the task:")
    for line in proposed.lines:
        console.print(f"    {line}", markup=False, soft_wrap=True)
    if report.filter:
        rate = by_component(report.filter)
        console.print(f'  (for lambda = {rate}: state tube.filter too, for "auto" goes by these bounds)', markup=False)


def _or_none(value: float | None) -> str:
    return "none" if value is None else f"{value:.4g}"


def show_run(report: RunReport) -> None:
    """Print the result of a closed loop, and what was proved for it beforehand."""
    console = _console()
    task, run = report.controller.task, report.run
    verdict = "[green]fulfilled[/green]" if report.fulfilled else "[red]MISSED[/red]"
    conditions = ", ".join(_conditions(report))
    kind = f"({report.controller.design.kind})"
    console.print(f"[bold]{task.name}[/bold] {kind} drives {escape(report.plant)}: {verdict}; {conditions}")
    hit = "none" if run.hit is None else f"[red]{run.hit} at {run.hit_at:.4g} s[/red]"
    left = "never" if run.left_at is None else f"[red]at {run.left_at:.4g} s[/red]"
    reached = "in the target" if run.reached else f"[red]not in the target, at {_numbers(run.last)}[/red]"
    end = f"{format_time(run.waited)} after t_c, for the tube waited," if run.waited else "at t_c"
    arrival = "" if task.target_set is None else f"; {end} {reached}"
    console.print(f"  unsafe sets entered: {hit}; state space left: {left}{arrival}")
    if task.mission:
        not_done = ", ".join(f"{k} ({escape(task.mission[k - 1].title())})" for k in run.missed)
        console.print(f"  mission: {f'[red]entry {not_done} missed[/red]' if run.missed else 'carried out, at every sample'}")
    tube = f"least margin {run.margin:.3g} of the width" if run.kept else "[red]was left[/red]"
    if report.fulfilled and not run.kept:
        tube += "; the task was met without a guarantee"
    console.print(f"  tube: {tube}; |e| up to {_numbers(run.e)}; |u| up to {_numbers(run.u)}")
    for line in report.proof_lines:
        console.print(f"  beforehand: {escape(line)}")
    for path in report.files:
        console.print(f"  {path}")


def _conditions(report: RunReport) -> list[str]:
    """Return the conditions of a run in words: disturbance, rate, gain, noise, lag, latency, lost samples."""
    task, s = report.controller.task, report.scenario
    bounds = [s.strength * v for v in s.shares] or [s.strength]
    conditions = [f"|w| <= {by_component(bounds)} ({s.disturbance})" if s.strength else "no disturbance"]
    conditions += [f"{s.rate:g} Hz", f"gain {by_component(task.gain)}"]
    for letter, noise in (("x", s.noise), ("v", s.noise_v)):
        errors = entries_of(letter, noise, task.dimension)
        conditions += [f"{letter} measured to {by_component(errors)}"] if any(errors) else []
    if s.has_drives:
        conditions.append(f"u through {written_drive(s.drives)}{', as bad as it may be' if s.is_adverse else ''}")
    if s.latency:
        conditions.append(f"u {format_time(s.latency)} late")
    if s.lost:
        conditions.append(f"up to {s.lost} lost in a row")
    if any(c is not None for c in task.courses):
        conditions.append(f"clock of the sets {s.clock}")
    return conditions


def _numbers(values: Sequence[float]) -> str:
    return ", ".join(f"{v:.4g}" if math.isfinite(v) else "beyond numbers" for v in values)


LONGEST_USUAL_SAMPLE_TIME = 0.1  # seconds; in a record with longer ones the times may be milliseconds


def show_envelope(name: str, envelope: StepEnvelope) -> None:
    """Print what a task may state of a drive by its recorded step, as lines of a task file, and what the record hides."""
    before, after = envelope.command
    step = f"{envelope.columns[1]} steps from {before:g} to {after:g} at {envelope.step_time:g} s"
    gain = f"{envelope.columns[2]} settles at {envelope.gain:.4g} times that"
    print(f"{name}: {envelope.samples} samples; {step}, {gain}")
    print("  [control]")
    print(f"  latency = {envelope.latency:g}  # of the drive; add the time from a sample to its command")
    print("  [plant]")
    print(f"  lag = {envelope.lag:g}")
    if envelope.overshoot:
        print(f"  overshoot = {envelope.overshoot:g}")
    taken = f"every sample counts as {100 * envelope.noise:.2g} % of the step lower, for noise"
    late = f"up to {format_time(2 * envelope.sample_time)} later, for the time between samples"
    print(f"  against the drive: {taken}, and {late}")
    unseen = f"the last {100 * envelope.hidden:.2g} % of the step, and falls below {100 * envelope.smallest_fall:.2g} %"
    print(f"  not seen: {unseen}; where your drive creeps or rings by more, state it in w_max or overshoot")
    if envelope.sample_time > LONGEST_USUAL_SAMPLE_TIME:
        print(f"  note: samples are {format_time(envelope.sample_time)} apart; are the times in seconds?")
    print("  holds for this step: record one as large as the controller may command, from -u_max to u_max, under load")


def show_agreement(title: str, rows: Sequence[ComparisonRow]) -> None:
    """Print a comparison in which every row holds as a line: the backends, and the quantity nearest to its bound."""
    nearest = max(rows, key=lambda r: r.share)
    print(
        f"{title}: {', '.join(dict.fromkeys(r.backend for r in rows))} agree with the reference within derived bounds, "
        f"{sum(r.points for r in rows):,} values compared; "
        f"nearest to its bound: {nearest.quantity} by {nearest.backend}, {nearest.share:.0%} (--verbose for all)"
    )


def show_rows(title: str, rows: Sequence[ComparisonRow]) -> None:
    """Print a comparison with the reference as a table."""
    heading = f"{title}: largest distance from the reference"
    table = Table(box=None, header_style="bold", title=heading, title_justify="left")
    for name in ("backend", "quantity", "values", "error", "ulp", "of its bound", ""):
        table.add_column(name, justify="left" if name in ("backend", "quantity") else "right")
    for r in rows:
        verdict = "[green]ok[/green]" if r.holds else "[red]BEYOND[/red]"
        table.add_row(r.backend, r.quantity, str(r.points), f"{r.error:.2e}", f"{r.ulps:.1f}", f"{r.share:.0%}", verdict)
    _console().print(table)
    print("ulp: units in the last place of the sizes a quantity is made of; docs/accuracy.md derives the bounds")
