"""A recorded step gives a lag, a latency and an overshoot under whose envelope the drive lies, whatever its kind and the noise."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest
from typer.testing import CliRunner

from stt_codegen.cli.main import app
from stt_codegen.errors import BadInput
from stt_codegen.steps.envelope import LATENCY_WEIGHT, StepEnvelope, envelope_of
from stt_codegen.steps.recording import StepRecord, parse_record
from tests.support.command_line import run_command

Array = npt.NDArray[np.float64]
Step = Callable[[Array], Array]
END = 1.0  # seconds of a record, after the step
PRECISE = np.linspace(0, END, 200_001)


def lag(time_constant: float, dead_time: float = 0.0) -> Step:
    return lambda t: np.where(t > dead_time, 1 - np.exp(-np.maximum(t - dead_time, 0) / time_constant), 0.0)


def two_lags(first: float, second: float) -> Step:
    return lambda t: 1 - (first * np.exp(-t / first) - second * np.exp(-t / second)) / (first - second)


def slew(rate: float) -> Step:
    return lambda t: np.minimum(rate * t, 1.0)


def oscillator(damping: float, frequency: float) -> Step:
    damped = np.sqrt(1 - damping**2)
    return lambda t: (
        1
        - np.exp(-damping * frequency * t) * (np.cos(damped * frequency * t) + damping / damped * np.sin(damped * frequency * t))
    )


def varying_lag(slow: float, fast: float) -> Step:
    """A lag whose time constant is `fast` at first and `slow` from 0.03 s on."""
    return lambda t: 1 - np.exp(-np.minimum(t, 0.03) / fast - np.maximum(t - 0.03, 0) / slow)


DRIVES: dict[str, Step] = {
    "lag": lag(0.08),
    "lag behind a dead time": lag(0.05, 0.0125),
    "two lags": two_lags(0.06, 0.02),
    "slew": slew(12.0),
    "critically damped": oscillator(0.999, 60.0),
    "varying lag": varying_lag(0.1, 0.03),
    "rings": oscillator(0.7, 50.0),
    "rings long": oscillator(0.5, 60.0),
}


def recorded(drive: Step, sample_time: float, noise: float, seed: int) -> StepRecord:
    """Sample a drive's step; the command comes at a random time between two samples and steps from 2 to -1."""
    draw = np.random.default_rng(seed)
    time = np.arange(-int(0.2 / sample_time), int(END / sample_time)) * sample_time + draw.uniform(0, 1) * sample_time
    error = noise * draw.uniform(-1, 1, len(time))
    response = 5.0 - 30.0 * (np.where(time >= 0, drive(np.maximum(time, 0)), 0.0) + error)
    return StepRecord(
        time=tuple((time + 3.0).tolist()),
        command=tuple(np.where(time >= 0, -1.0, 2.0).tolist()),
        response=tuple(response.tolist()),
        lines=tuple(range(2, len(time) + 2)),
        columns=("t", "u", "y"),
    )


def rises_and_falls(response: Array) -> tuple[Array, float]:
    """Return the sum of all rises until each time, and that of all falls."""
    change = np.diff(response, prepend=0.0)
    return np.cumsum(np.maximum(change, 0)), float(-np.minimum(change, 0).sum())


def excess(drive: Step, envelope: StepEnvelope) -> float:
    """Return by how much the envelope is above the drive's rises, as a share, up to what the record hides."""
    rises, falls = rises_and_falls(drive(PRECISE))
    nu = max(envelope.overshoot / (1 - envelope.overshoot), falls if envelope.overshoot else 0.0)
    late = np.maximum(PRECISE - envelope.latency, 0)
    lower = np.where(late > 0, 1 - np.exp(-late / max(envelope.lag, 1e-12)), 0.0)
    return float((np.minimum(lower, 1 - envelope.hidden) - rises / (1 + nu)).max())


@pytest.mark.parametrize("name", DRIVES)
@pytest.mark.parametrize("sample_time", [0.0005, 0.002, 0.01])
@pytest.mark.parametrize("noise", [0.0, 0.001, 0.01])
def test_a_drive_lies_above_the_envelope_of_its_recorded_step(name: str, sample_time: float, noise: float) -> None:
    drive, envelopes = DRIVES[name], 0
    _, falls = rises_and_falls(drive(PRECISE))
    for seed in range(6):
        for latency in (None, 0.03):
            try:
                envelope = envelope_of(recorded(drive, sample_time, noise, seed), latency)
            except BadInput as refusal:
                assert ("hides" in str(refusal) and falls > 0 and noise > 0.005) or "--latency" in str(refusal)
                continue
            envelopes += 1
            assert excess(drive, envelope) <= 1e-9
            nu = envelope.overshoot / (1 - envelope.overshoot)
            assert nu >= falls * (1 - 1e-3) or falls < 2 * envelope.noise + 0.002
    assert envelopes or (falls > 0 and noise > 0.005)


def test_the_law_of_envelopes_finds_one_that_is_too_quick() -> None:
    envelope = envelope_of(recorded(DRIVES["lag"], 0.0005, 0.001, 1))
    for change in ({"lag": 0.9 * 0.08}, {"lag": 0.07, "latency": 0.0}):
        values = {**envelope.document(), **change}
        assert excess(DRIVES["lag"], StepEnvelope(**values)) > 0.001


@pytest.mark.parametrize(("name", "delay"), [("lag", 0.08), ("lag behind a dead time", 0.0625), ("two lags", 0.085)])
def test_a_clean_record_adds_little(name: str, delay: float) -> None:
    envelope = envelope_of(recorded(DRIVES[name], 0.0005, 0.0, 2))
    assert envelope.overshoot == 0
    assert delay * 0.98 < envelope.lag + envelope.latency < delay * 1.06
    assert envelope.gain == pytest.approx(10.0, rel=1e-3)
    assert envelope.command == (2.0, -1.0)


@pytest.mark.parametrize("noise", [0.0, 0.01])
def test_more_noise_and_fewer_samples_never_shorten_the_delay_of_a_lag(noise: float) -> None:
    precise = envelope_of(recorded(DRIVES["lag"], 0.0005, noise / 4, 3))
    coarse = envelope_of(recorded(DRIVES["lag"], 0.01, noise, 3))
    assert coarse.lag + coarse.latency >= precise.lag + precise.latency
    assert coarse.hidden >= precise.hidden


def csv_of(record: StepRecord, heading: str = "time,command,response\n") -> str:
    rows = zip(record.time, record.command, record.response, strict=True)
    return heading + "".join(f"{t:.6f},{u:g},{y:.6f}\n" for t, u, y in rows)


GOOD = csv_of(recorded(DRIVES["lag"], 0.002, 0.001, 4))


@pytest.mark.parametrize(
    "text",
    [
        GOOD.partition("\n")[2],
        "# motor, left\n% 12 V\n\n" + GOOD,
        "drive,,\n" + GOOD.replace("time,command", '"t [s]","u"'),
        GOOD.replace(",", ";"),
        GOOD.replace(",", ";").replace(".", ","),
        GOOD.replace(",", "\t"),
        GOOD.replace(",", "  "),
        GOOD.replace("\n", "\r\n"),
        GOOD.replace("\n", ",rest\n"),
    ],
)
def test_records_of_many_forms_are_read_alike(text: str) -> None:
    record, expected = parse_record(text), parse_record(GOOD)
    assert (record.time, record.command, record.response) == (expected.time, expected.command, expected.response)


def test_columns_are_chosen_by_name_and_by_number() -> None:
    rows = [line.split(",") for line in GOOD.splitlines()]
    text = "\n".join(f"{y},{k},{t},{u}" for k, (t, u, y) in enumerate(rows))
    expected = envelope_of(parse_record(GOOD))
    for columns in (("time", "command", "response"), ("3", "4", "1")):
        assert envelope_of(parse_record(text, columns=columns)) == expected
    with pytest.raises(BadInput, match="--columns speed: record has no such column; use one of response, 0, time, command"):
        parse_record(text, columns=("time", "command", "speed"))


def without_rows(text: str, is_left_out: Callable[[float], bool]) -> str:
    heading, *rows = text.splitlines(keepends=True)
    return heading + "".join(row for row in rows if not is_left_out(float(row.partition(",")[0])))


def with_line(text: str, number: int, line: str) -> str:
    lines = text.splitlines()
    lines[number - 1] = line
    return "\n".join(lines)


def with_creep(record: StepRecord) -> StepRecord:
    """Return the record with a command that moves on after its step, by less than a step from sample to sample."""
    command = [u if u > 0 else u + 0.005 * max(k - 110, 0) for k, u in enumerate(record.command)]
    return replace(record, command=tuple(command))


def reversed_sensor(record: StepRecord) -> StepRecord:
    return replace(record, response=tuple(-y for y in record.response))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "step.csv: has no row of numbers; a row for every sample is needed"),
        ("time,command\n0,1\n", "step.csv: has 2 columns; three are needed"),
        (with_line(GOOD, 40, "3.1,x,2"), "step.csv, line 40: the command is 'x'; a finite number is needed"),
        (with_line(GOOD, 40, "3.1,2,nan"), "step.csv, line 40: the response is 'nan'; a finite number is needed"),
        (with_line(GOOD, 40, "3.1,2"), "step.csv, line 40: has 2 cells; the response is in column 3"),
        (with_line(GOOD, 40, "0.5,2,2"), "step.csv, line 40: time 0.5 is not after"),
        (GOOD.replace(",-1,", ",2,"), "step.csv: the command is 2 all along"),
        (with_line(GOOD, 300, "3.398000,2,1"), "step.csv, line 300: the command changes again"),
        (without_rows(GOOD, lambda t: t > 3.02), "rows after the step; at least 20"),
        (without_rows(GOOD, lambda t: t > 3.25), "step.csv: the response has not settled: in the last fifth it still moves by"),
        (csv_of(recorded(lambda t: 0 * t, 0.002, 0.001, 4)), "step.csv: the response does not follow the command"),
        (csv_of(recorded(DRIVES["lag"], 0.002, 0.1, 4)), "record a larger step, or the mean of several"),
        (
            csv_of(with_creep(recorded(DRIVES["lag"], 0.002, 0.0, 4))),
            "and -1 beside the step; keep the rows in which the command",
        ),
        (csv_of(reversed_sensor(recorded(DRIVES["lag"], 0.002, 0.0, 4))), "against the command; change the sign of one of the"),
    ],
)
def test_what_is_no_step_is_refused_in_one_message(text: str, message: str, tmp_path: Path) -> None:
    (tmp_path / "step.csv").write_text(text)
    result = CliRunner().invoke(app, ["lag", str(tmp_path / "step.csv")])
    assert isinstance(result.exception, BadInput)
    assert message in str(result.exception)


@pytest.mark.parametrize("name", ["lag", "two lags", "slew"])
@pytest.mark.parametrize("parts", [20, 50, 200])
def test_a_drive_lies_above_the_envelope_that_a_coarse_sensor_shows(name: str, parts: int) -> None:
    """The sensor rounds down to a part of the step, so it shows no noise at rest."""
    for seed in range(4):
        record = recorded(DRIVES[name], 0.0005, 0.0, seed)
        part = 30.0 / parts
        envelope = envelope_of(replace(record, response=tuple((np.floor(np.array(record.response) / part) * part).tolist())))
        assert envelope.noise >= 1 / parts * (1 - 1e-9)
        assert excess(DRIVES[name], envelope) <= 1e-9


def test_the_lag_of_a_noisy_record_is_no_matter_of_luck() -> None:
    """Normal noise of one size gives delays of one size, since no outlier of the settled end decides: without that 1.46 times."""
    delays = []
    for seed in range(40):
        record = recorded(DRIVES["lag"], 0.002, 0.0, seed)
        noise = 30 * np.random.default_rng(seed).normal(0, 0.0025, len(record.response))
        envelope = envelope_of(replace(record, response=tuple((np.array(record.response) + noise).tolist())))
        delays.append(envelope.lag + LATENCY_WEIGHT * envelope.latency)
    assert max(delays) < 1.3 * min(delays)


def test_a_column_of_many_digits_is_refused() -> None:
    with pytest.raises(BadInput, match="has no such column"):
        parse_record(GOOD, columns=("9" * 5000, "2", "3"))


def test_the_latency_that_a_refusal_names_is_accepted() -> None:
    record = recorded(DRIVES["lag behind a dead time"], 0.002, 0.01, 5)
    with pytest.raises(BadInput, match=r"--latency 0\.001: the response is not above the noise") as refusal:
        envelope_of(record, 0.001)
    latency = float(str(refusal.value).partition("use ")[2].split()[0])
    assert envelope_of(record, latency).latency == latency


def test_the_command_prints_lines_of_a_task_and_json_has_the_same(tmp_path: Path) -> None:
    (tmp_path / "step.csv").write_text(GOOD)
    shown = run_command("lag", "step.csv", cwd=tmp_path)
    document: dict[str, Any] = json.loads(run_command("lag", "step.csv", "--json", cwd=tmp_path).stdout)
    assert shown.returncode == 0
    for key in ("lag", "latency"):
        assert f"{key} = {document[key]:g}" in shown.stdout
    missing = run_command("lag", "none.csv", cwd=tmp_path)
    assert missing.returncode == 2
    assert missing.stderr.strip().startswith(
        "stt-codegen: none.csv: cannot be read (No such file or directory); give a record as CSV"
    )
