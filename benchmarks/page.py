"""Measure the HTML report: seconds to write it, bytes, bytes of WebAssembly, seconds to the first picture, frames a second.

    python -m benchmarks page [--record FILE.md]

The tasks are four examples, and 300 sets in the plane and in space. The frames are those while the slider of time moves. It needs
chromium, and ends with exit code 4 without it.
"""

from __future__ import annotations

import argparse
import base64
import json
import random
import re
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from playwright.sync_api import sync_playwright

from benchmarks.suites.report import command, machine, record, table

ROOT = Path(__file__).parent.parent
SET_COUNT, SIDE = 300, 40.0  # of the tasks with many sets: unsafe boxes, and width of the state space
FRAMES = 200  # while the slider moves
FIRST_PICTURE = """() => new Promise((done) => requestAnimationFrame(() => setTimeout(
  () => done([performance.now(), performance.getEntriesByType('navigation')[0].responseEnd]), 0)))"""
MOVE_SLIDER = """(frames) => new Promise((done) => {
  const slider = document.getElementById('time'), begin = performance.now();
  let k = 0;
  const step = () => {
    slider.value = String((2000 * k) / frames);
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    if (k++ < frames) requestAnimationFrame(step); else done((1000 * frames) / (performance.now() - begin));
  };
  requestAnimationFrame(step);
})"""


def task_with_many_sets(name: str, dimension: int) -> str:
    """Return the text of a task with SET_COUNT boxes, none near the start or the target."""
    rng, boxes = random.Random(3), list[str]()
    while len(boxes) < SET_COUNT:
        lower = [round(rng.uniform(0, SIDE - 1.2), 2) for _ in range(dimension)]
        upper = [round(v + rng.uniform(0.4, 1.2), 2) for v in lower]
        if not (max(lower) < 4.5 or min(upper) > SIDE - 5):
            boxes.append(f'[[unsafe]]\nname = "B{len(boxes)}"\nlower = {lower}\nupper = {upper}\n')
    ends = {"state_space": (0, SIDE), "initial_set": (1.5, 2.5), "target_set": (SIDE - 3, SIDE - 1)}
    lines = [f'name = "{name}"', "prescribed_time = 40", f"initial_state = {[2.0] * dimension}"]
    lines += [f"{key} = {{ lower = {[a] * dimension}, upper = {[b] * dimension} }}" for key, (a, b) in ends.items()]
    return "\n".join([*lines, *boxes])


def report_row(browser: Any, task_path: Path, folder: Path) -> list[str]:
    """Write the report of a task and show it in the browser. Return the task's row of the table."""
    path = folder / f"{task_path.stem}.html"
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-m", "stt_codegen.cli", "report", task_path, "--out", path], check=True, capture_output=True)
    seconds = time.perf_counter() - begin
    text = path.read_text()
    data = re.search(r'<script id="data" type="application/json">(.*?)</script>', text, re.S)
    assert data is not None
    drive = json.loads(data[1])["drive"]
    wasm = len(base64.b64decode(drive["wasm"])) if drive else 0
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    picture_seconds = []
    for _ in range(5):
        page.goto(path.as_uri())
        picture_seconds.append(page.evaluate(FIRST_PICTURE)[0] / 1000)
    rate = page.evaluate(MOVE_SLIDER, FRAMES)
    page.close()
    return [
        task_path.stem,
        f"{seconds:.1f}",
        f"{len(text.encode()):,}",
        f"{wasm:,}",
        f"{statistics.median(picture_seconds):.2f}",
        f"{rate:.0f}",
    ]


def main() -> int:
    """Measure all tasks, and print the table. Return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the table into this file")
    options = parser.parse_args()
    chromium = shutil.which("chromium")
    if chromium is None:
        print("chromium is not found; `.ci/tools test` installs it", file=sys.stderr)
        return 4
    with tempfile.TemporaryDirectory() as name, sync_playwright() as play:
        folder = Path(name)
        tasks = [ROOT / "tasks" / f"{example}.toml" for example in ("omni_s2", "drone", "courier", "watchman")]
        for task, dimension in (("flat300", 2), ("solid300", 3)):
            (folder / f"{task}.toml").write_text(task_with_many_sets(task, dimension))
            tasks.append(folder / f"{task}.toml")
        browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        rows = [report_row(browser, task, folder) for task in tasks]
        browser.close()
    heads = [
        "task",
        "seconds to make",
        "bytes",
        "of WebAssembly",
        "seconds to the first picture",
        "frames a second",
    ]
    text = table(heads, rows)
    print(text)
    if options.record:
        note = "flat300 and solid300 have 300 boxes in the plane and in space; a browser draws 60 frames a second at most."
        record(options.record, "page", f"## The report\n\nMade by `{command()}`; {machine()}.\n\n{text}\n\n{note}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
