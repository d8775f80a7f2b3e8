"""Figures of the documents are those that were recorded: each is read from benchmarks/RESULTS.md and looked for where it is stated."""

from __future__ import annotations

import re
import subprocess
from dataclasses import dataclass
from functools import cache

import pytest

from stt_codegen.board.boards import BOARDS
from stt_codegen.board.emulated import run_on_board
from tests.support.controllers import ROOT, controller_of

GCC = "12.2"  # counts of instructions are of this compiler
RESULTS = (ROOT / "benchmarks" / "RESULTS.md").read_text()


@cache
def document(name: str) -> str:
    """Return a document as one line, so that a sentence may be broken anywhere."""
    return " ".join((ROOT / name).read_text().split())


@cache
def section(name: str) -> str:
    """Return a section of RESULTS.md without the spaces that align its tables."""
    begin = RESULTS.index(f"<!-- {name} -->")
    return re.sub(r" +", " ", RESULTS[begin : RESULTS.index(f"<!-- end of {name} -->", begin)])


@dataclass(frozen=True)
class Claim:
    """A statement of a document, {} where a figure stands, and where each figure is recorded.

    sources: patterns in the section of RESULTS.md, each with a group for every figure that it gives.
    """

    document: str
    words: str
    section: str
    sources: tuple[str, ...]

    def values(self) -> list[str]:
        """Return the recorded figures, in the order of the sources."""
        values: list[str] = []
        for pattern in self.sources:
            matches = re.findall(pattern, section(self.section))
            assert len(matches) == 1, (self.section, pattern, matches)
            values += [matches[0]] if isinstance(matches[0], str) else matches[0]
        return values

    def text(self) -> str:
        """Return the statement with the recorded figures, rounded as the words ask."""
        rounders = {"float": float, "int": lambda text: int(text.replace(",", ""))}
        values = [rounders["int" if "," in v or v.isdigit() else "float"](v) for v in self.values()]
        return self.words.format(*values)


def readme(words: str, section_name: str, *sources: str) -> Claim:
    return Claim("README.md", words, section_name, sources)


COST = r"[\d,]+ / [\d,]+ / ([\d,]+)"  # the largest
CLAIMS = [
    # on boards
    readme("at most {:,} instructions in the runs that count them", "mcu", rf"\| 1000 \| {COST} \|"),
    readme("or {:,} with the logarithm written out", "mcu", rf"\| m4f: refined, inline \| {COST} \|"),
    readme("with a limit of u {:,} and {:,}", "fixed", rf"omni_s2, m4f: float, libm \| {COST} ", rf"omni_s2, m4f: float, inline \| {COST} "),
    readme(
        "{:,} instructions on a Cortex-M0 (floats: {:,})", "fixed",
        rf"omni_s2, m0: integers \| {COST} ", rf"omni_s2, m0: float, libm \| {COST} ",
    ),
    readme("{:,} cycles and no static RAM on an Arduino Uno", "fixed", rf"omni_s2, avr: integers \| {COST} "),
    readme(
        "without a limit of u (in three dimensions {1:,}) | {0:,} | `python -m benchmarks mcu` |", "mcu",
        rf"\| 1000 \| {COST} \|", rf"\| 3 \| {COST} \|",
    ),
    readme("| the same without a library | {:,} | same |", "mcu", rf"\| m4f: refined, inline \| {COST} \|"),
    readme("| C written by hand, with the same tests | {:,} | same |", "mcu", rf"written by hand, refined \| {COST} "),
    readme("| CasADi's own C of the same law | {:,} | same |", "mcu", rf"CasADi's C, as generated, refined \| {COST} "),
    readme(
        "the same `control` with a limit of u, with and without a library | {:,}, {:,} | `python -m benchmarks fixed` |", "fixed",
        rf"omni_s2, m4f: float, libm \| {COST} ", rf"omni_s2, m4f: float, inline \| {COST} ",
    ),
    readme(
        "(in floats {3:,}; {4:,}; {5:,}) | {0:,}, {1:,}; {2:,} | same |", "fixed",
        *(rf"omni_s2, {board}: {kind} \| {COST} " for kind in ("integers", "float, libm") for board in ("m0", "rv32", "avr")),
    ),
    readme(
        "instructions of `control` of order 2 (omni_s2), Cortex-M4F, with and without a library, at most | {:,}, {:,} |", "inertia",
        r"m4f, libm \| \d+ to (\d+)", r"m4f, inline \| \d+ to (\d+)",
    ),
    *(
        Claim("docs/board.md", words, "fixed", tuple(
            rf"{task}, {board}: {kind} \| {COST} " for task in ("omni_s2", "crane") for kind in ("integers", "float, libm")
        ))
        for board, words in (
            ("m0", "| Cortex-M0 (RP2040: M0+) | {:,} | {:,} | {:,} | {:,} |"),
            ("rv32", "| RV32IMAC (ESP32-C3: RV32IMC) | {:,} | {:,} | {:,} | {:,} |"),
            ("avr", "| ATmega328P (Uno) | {:,} | {:,} | {:,} | {:,} |"),
            ("m3", "| Cortex-M3 | {:,} | {:,} | {:,} | {:,} |"),
            ("m4f", "with `math = \"inline\"` | {:,} | {:,} | {:,} | {:,} |"),
        )
    ),
    Claim(
        "docs/board.md", "keep floats, {:,} and {:,} with `math = \"inline\"`", "fixed",
        (rf"omni_s2, m4f: float, inline \| {COST} ", rf"crane, m4f: float, inline \| {COST} "),
    ),
    # arenas and missions
    readme("(498 have gaps of 11 cm all the way, which `min_width` and twice the `clearance` need) | {:,} |", "arenas",
           r"\| paper \(2-D, 4 of 1\) \| refined \| \d+ of \d+ \| (\d+) of 500"),
    readme("| design and certificate on one core, median of the 500 | {:.0f} ms |", "arenas",
           r"\| paper \(2-D, 4 of 1\) \| refined (?:\|[^|]*){4}\| ([\d.]+) / "),
    readme("| peak speed over the least possible, median | {:.2f} |", "arenas",
           r"\| paper \(2-D, 4 of 1\) \| refined (?:\|[^|]*){6}\| ([\d.]+) / "),
    readme("those where it comes within the clearance of an unsafe set | {:,} |", "arenas", r"literal: fails P1 in \d+, P4 in (\d+)"),
    readme("A\\* takes {:.1f} ms where our tube takes {:.0f} ms", "arenas",
           r"\| A\* \| [^|]*\| [^|]*\| A\* [^|]*\| [^|]*\| ([\d.]+) / ", r"refined \(ours\): certified \| [^|]*\| ([\d.]+) / "),
    readme("{:,} instructions a step in the plane: symbolic control", "arenas", rf"symbolic control, 100 x 100 \| {COST} \|"),
    readme("(13 min 28 s there) | {:.1f} s |", "missions", r"robot over waypoints, in full \| ([\d.]+) "),
    readme("certified, of 200 arenas of four moving squares (all leave a way), of 28 of twenty moving boxes and balls in space | {:,}, {:,} |",
           "moving", r"\| four \| (\d+) of 200 ", r"\| twenty \| (\d+) of 28 "),
    readme("started 0.1 s late, in time, and worst: collisions in {:,} | {:,} |", "moving", r"(\d+) closed loops in 20 tubes.*: (\d+) collisions"),
    readme("plants of order 2, \\|w\\| up to 0.3 m/s^2: of 100 arenas of four squares those certified; design and certificate, median | {:,}; {:,} ms |",
           "inertia", r"\| paper \| (\d+) of 100 \| (\d+) / "),
    readme("period proved for omni_s2 and spacecraft with inertia, u limited to 1.1 times the plant bounds | {:.0f}, {:.0f} ms |",
           "inertia", r"\| omni_s2 \| 1.1 \| ([\d.]+)", r"\| spacecraft \| 1.1 \| ([\d.]+)"),
    readme("their closed loops at that period and at 1 kHz, {:,} runs: collisions, tubes left | {:,} |", "inertia",
           r"(\d+) closed loops in 16 tubes: (\d+) collisions, 0 tubes left"),
    readme("the same starts; \\|e(0)\\| <= 0.05 | {:.0f}, {:.0f}; {:.0f}, {:.0f} ms |", "cascade",
           *(rf"\| {tube} \| cascade, c' fed forward \| {start} \| ([\d.]+)" for start in ("0.9", "0.05") for tube in ("omni_s2", "spacecraft"))),
    # mutants, loops, adversaries
    readme("| false certificates, of {:,} mutated tubes and tasks | {:,} |", "mutations", r"\nall (\d+) \d+ \d+ \d+ (\d+) "),
    readme("the same, of {:,} mutated tubes of order 2, {:,} unsafe | {:,} |", "mutations inertia", r"\nall (\d+) (\d+) \d+ \d+ (\d+) "),
    readme("the same, of {:,} missions, regions and tubes bent by chance, some of them for ever,", "mission mutants", r"(\d+) mutants of 24 missions, 0 false"),
    readme("{:,} runs from all of the share, corners too: collisions, tubes left, bounds on \\|e\\| and \\|u\\| passed | {:,} |", "loop",
           r"\| own (?:\|[^|]*){2}\| (\d+) \| (\d+) \| 0 \| 0 "),
    readme("not told w_max and told; of trained policies (ours: 0) | {:,}, {:,}; {:,} to {:,} |", "loop",
           *(rf"\| {who} (?:\|[^|]*){{3}}\| (\d+) \|(?=[^\n]*\d us|[^\n]*\d\.\d)" for who in ("barrier filter", "barrier filter told w_max")),
           *(rf"\(PPO\), seed {seed} (?:\|[^|]*){{3}}\| (\d+) \|" for seed in (1, 3))),
    readme("times the proved one: least, median | {:.1f}, {:.1f} |", "sampled", r"\| sharp \| .*\| ([\d.]+) / ([\d.]+) \|"),
    Claim("docs/physics.md", "of x and of v + lambda x | {:.3f} | {:.3f} |", "physics",
          tuple(rf"\| {body} \| 1000 (?:\|[^|]*){{3}}\| ([\d.]+) " for body in ("base", "arm"))),
    Claim("docs/physics.md", "of {:,} and {:,} configurations off the sets none touches a geom", "physics",
          tuple(rf"\| {body} \| configurations off the sets that touch a geom \| 0 of ([\d,]+) " for body in ("base", "arm"))),
    Claim("docs/peers.md", "| {:,} of 500 | {:.2f} ms |", "arenas", (r"OMPL RRT\*, first solution \| (\d+) of 500 \| ([\d.]+) / [\d.]+ ms \|\n",)),
    Claim("docs/peers.md", "| {:,} of 500, certified | {:.0f} ms with the certificate |", "arenas",
          (r"refined \(ours\): certified \| (\d+) of 500 \| ([\d.]+) / ",)),
    Claim("docs/peers.md", "{2:,} to {1:,} of 500 in all ten runs;", "arenas",
          tuple(rf"\| reinforcement learning \(PPO\), seed {seed} \| (\d+) of 500 \|" for seed in (1, 2, 3))),
    Claim("docs/peers.md", "| ours | 100 % of {:,} | {:,} | {:.1f} | {:.3f} us |", "loop",
          (r"\| own (?:\|[^|]*){2}\| (\d+) \| (\d+) \|", r"\| own (?:\|[^|]*){9}\| ([\d.]+) \| ([\d.]+) \|")),
    Claim("docs/peers.md", "| barrier filter told w_max; not told | {1:.0f} %; {0:.0f} % of", "loop",
          tuple(rf"\| {who} (?:\|[^|]*){{7}}\| ([\d.]+) % \| -" for who in ("barrier filter", "barrier filter told w_max"))),
    Claim("docs/lemmas.md", "is at {:.1f} times its length at least and at {:.1f} in the median; that of the general one at {:.1f} and {:.0f}",
          "sampled", (r"\| sharp \| .*\| ([\d.]+) / ([\d.]+) \|", r"\| general \| .*\| ([\d.]+) / ([\d.]+) \|")),
    Claim("docs/peers.md", "meet an unsafe set there; the swept variant looks at the way too, and finds a controller in {1:,} arenas for {0:,}",
          "arenas", tuple(rf"\| symbolic control, 100 x 100{kind} \| (\d+) of 500 \| [\d.]+ / [\d.]+ ms \|\n" for kind in ("", ", swept"))),
    readme("in MuJoCo it drives a base and an arm", "physics", r"\| base \| (1000) \| 0 \| 0 \| ", r"\| arm \| (1000) \| 0 \| 0 \| "),
]  # fmt: skip
# Rows of the README's table that RESULTS.md does not record, by words of the row; and why.
NOT_RECORDED = {
    "12 or 24 obstacles, 3-D, 6-D": "a sum of four rows, below",
    "beside 1,000 obstacles": "in seconds, below",
    "of the widest box that gets through": "the job `tubes` of benchmarks/integration.py demands it, of fewer arenas",
    "walls and round targets": "the job `mutations-shapes` demands it, of fewer mutants",
    "of 8,400 tubes and sets that move": "recorded by hand, below",
    "that adversaries broke, of 480": "a sum of five rows, below",
    "lemmas proved, refuted, open": "generated/lemmas.md, below",
    "mutated functions, printed or evaluated": "the job `lemma-mutants` demands it, of fewer functions",
    "carried out: of 100 among 10": "two rows and one in space, below",
    "for which a board gives other integers": "the jobs `integer-bits-..` demand it, of 100,000 inputs",
    "tasks/crawler.toml in Rust": "the job `tests-rust` measures it; the C below",
    "code and tables, bytes": "tests below",
    "`generate`, one task": "seconds of one machine",
    "units in the last place": "`compare` demands its bound in make test",
}


@pytest.mark.parametrize("claim", CLAIMS, ids=lambda claim: claim.words[:50])
def test_a_documents_figure_is_the_recorded_one(claim: Claim) -> None:
    assert claim.text() in document(claim.document)


def test_every_row_of_the_readmes_table_is_held_to_a_record() -> None:
    table = (ROOT / "README.md").read_text().partition("## How good")[2].partition("\n\n[benchmarks/RESULTS")[0]
    rows = [" ".join(row.split()) for row in re.findall(r"^\| .* \|$", table, re.M)[1:]]
    assert len(rows) > 35
    texts = [claim.text() for claim in CLAIMS if claim.document == "README.md"]
    recorded_rows = {row for row in rows if any(text in row for text in texts)}
    other_rows = {row for row in rows if any(words in row for words in NOT_RECORDED)}
    assert recorded_rows | other_rows == set(rows)
    assert not recorded_rows & other_rows
    assert all(sum(words in row for row in rows) == 1 for words in NOT_RECORDED)


def test_sums_and_counts_of_the_readme() -> None:
    """What is not one figure of a record: sums of rows, and counts that another file has."""
    text = document("README.md")
    arenas = [
        re.findall(rf"\| {family} \([^|]*\| refined \| (\d+) of (\d+) ", section("arenas"))[0]
        for family in ("dense12", "dense24", "space3", "space6")
    ]
    certified, feasible = (sum(int(pair[k]) for pair in arenas) for k in (0, 1))
    assert f"certified, of {feasible} that leave a way: 12 or 24 obstacles, 3-D, 6-D | {certified} |" in text
    (milliseconds,) = re.findall(r"\| corridor [^|]*\| refined (?:\|[^|]*){4}\| (\d+) / ", section("arenas"))
    assert f"the same beside 1,000 obstacles | {int(milliseconds) / 1000:.1f} s |" in text
    rows = re.findall(r"\| (\d+) \| (\d+) \| (\d+) \| [\d.]+ / [\d.]+ \|", section("sampled"))
    loops, proved, broken = (sum(int(row[k]) for row in rows) for k in range(3))
    assert f"that adversaries broke, of {proved} proved in {loops:,} loops | {broken} |" in text
    broken_missions = sum(
        int(count) for count in re.findall(r"\n\| \w+ \| (\d+) \| \d+ \| \d+ \| 0 \|", section("mission mutants"))
    )
    assert f"some of them for ever, {broken_missions:,} broken by some trajectory | 0 |" in text
    assert re.search(r"\| 8,400 +\| 3,436 +\| 0 +\| 0 ", RESULTS)
    assert "of 8,400 tubes and sets that move, grow or exist for a while, 3,436 unsafe | 0 |" in text
    for words in ("2-D, 10 unsafe sets | 100 of 100", "2-D, 30 unsafe sets | 100 of 100", "3-D, 10 unsafe sets | 50 of 50"):
        assert words in section("missions")
    assert "of 100 among 10 sets in the plane, 100 among 30, 50 in space | all |" in text
    counts = re.search(r"^(\d+) proved, (\d+) refuted, (\d+) open", (ROOT / "generated" / "lemmas.md").read_text(), re.M)
    assert counts is not None
    assert f"lemmas proved, refuted, open (50 s on two cores) | {counts[1]}, {counts[2]}, {counts[3]} |" in text
    families = len(re.findall("^## ", (ROOT / "generated" / "lemmas.md").read_text(), re.M))
    assert f"is the book: {families} families" in document("docs/lemmas.md")
    code, tables = re.findall(rf"\| m4f: refined \| {COST} \| (\d+) \| (\d+) \|", section("mcu"))[0][1:]
    assert f"code and tables, bytes on a Cortex-M4F | {code} + {tables} |" in text
    assert f"{(int(code) + int(tables)) / 1000:.1f} kB with its tables" in text


@pytest.mark.parametrize(
    ("name", "function"), [("omni_s2", "with the C library's logarithm"), ("crawler", "with a limit of u, logarithm written out")]
)
def test_instructions_in_c_beside_rust_are_what_pil_counts(name: str, function: str, tool) -> None:
    """The tasks of docs/rust.md and the README. Their Rust is measured by a slow test."""
    for command in ("arm-none-eabi-gcc", "qemu-system-arm"):
        tool(command)
    version = subprocess.run(["arm-none-eabi-gcc", "-dumpversion"], capture_output=True, text=True, check=True).stdout
    if not version.startswith(GCC):
        pytest.skip(f"the counts are those of arm-none-eabi-gcc {GCC}, this is {version.strip()}")
    _, costs = run_on_board(controller_of(name), BOARDS["m4f"], 2000)
    instructions = costs["control"].maximum
    assert re.search(rf"\| tasks/{name}.toml, {function} \| {instructions} \| \d+ \|", document("docs/rust.md"))
    ours = re.search(r"in Rust \(in C: (\d+), (\d+)\)", document("README.md"))
    assert ours is not None
    assert int(ours[1 if name == "omni_s2" else 2]) == instructions
