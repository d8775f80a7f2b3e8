"""The report's figures: seconds to make it, bytes, bytes of WebAssembly, seconds to the first picture, frames a second while the
slider moves, for an example, for 300 sets in the plane and in space.

    python -m benchmarks page [--record FILE.md]
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
SETS, SIZE = 300, 40.0
FRAMES = 200
PICTURE = """() => new Promise((done) => requestAnimationFrame(() => setTimeout(
  () => done([performance.now(), performance.getEntriesByType('navigation')[0].responseEnd]), 0)))"""
SLIDE = """(frames) => new Promise((done) => {
  const slider = document.getElementById('time'), begin = performance.now();
  let k = 0;
  const step = () => {
    slider.value = String((2000 * k) / frames);
    slider.dispatchEvent(new Event('input', { bubbles: true }));
    if (k++ < frames) requestAnimationFrame(step); else done((1000 * frames) / (performance.now() - begin));
  };
  requestAnimationFrame(step);
})"""


def crowded(name: str, dimension: int) -> str:
    """A task with SETS boxes, none near the start or the target."""
    chance, found = random.Random(3), list[str]()
    while len(found) < SETS:
        lower = [round(chance.uniform(0, SIZE - 1.2), 2) for _ in range(dimension)]
        upper = [round(v + chance.uniform(0.4, 1.2), 2) for v in lower]
        if not (max(lower) < 4.5 or min(upper) > SIZE - 5):
            found.append(f'[[unsafe]]\nname = "B{len(found)}"\nlower = {lower}\nupper = {upper}\n')
    ends = {"state_space": (0, SIZE), "initial_set": (1.5, 2.5), "target_set": (SIZE - 3, SIZE - 1)}
    lines = [f'name = "{name}"', "prescribed_time = 40", f"initial_state = {[2.0] * dimension}"]
    lines += [f"{key} = {{ lower = {[a] * dimension}, upper = {[b] * dimension} }}" for key, (a, b) in ends.items()]
    return "\n".join([*lines, *found])


def measured(browser: Any, task: Path, folder: Path) -> list[str]:
    """One row."""
    path = folder / f"{task.stem}.html"
    begin = time.perf_counter()
    subprocess.run([sys.executable, "-m", "stt_codegen.cli", "report", task, "--out", path], check=True, capture_output=True)
    seconds = time.perf_counter() - begin
    text = path.read_text()
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', text, re.S)
    assert found is not None
    drive = json.loads(found[1])["drive"]
    wasm = len(base64.b64decode(drive["wasm"])) if drive else 0
    page = browser.new_page(viewport={"width": 1280, "height": 900})
    first = []
    for _ in range(5):
        page.goto(path.as_uri())
        first.append(page.evaluate(PICTURE)[0] / 1000)
    rate = page.evaluate(SLIDE, FRAMES)
    page.close()
    return [task.stem, f"{seconds:.1f}", f"{len(text.encode()):,}", f"{wasm:,}", f"{statistics.median(first):.2f}", f"{rate:.0f}"]


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--record", type=Path, metavar="FILE.md", help="put the table into this file")
    options = parser.parse_args()
    chromium = shutil.which("chromium")
    if chromium is None:
        print("chromium is not found; `.ci/tools test` installs it", file=sys.stderr)
        return 4
    with tempfile.TemporaryDirectory() as name, sync_playwright() as play:
        folder = Path(name)
        tasks = [ROOT / "tasks" / f"{one}.toml" for one in ("omni_s2", "drone", "courier", "watchman")]
        for task, dimension in (("flat300", 2), ("solid300", 3)):
            (folder / f"{task}.toml").write_text(crowded(task, dimension))
            tasks.append(folder / f"{task}.toml")
        browser = play.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        rows = [measured(browser, task, folder) for task in tasks]
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
        told = "flat300 and solid300 have 300 boxes in the plane and in space; a browser draws 60 frames a second at most."
        record(options.record, "page", f"## The report\n\nMade by `{command()}`; {machine()}.\n\n{text}\n\n{told}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
