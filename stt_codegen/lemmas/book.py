"""The lemma book: every family's lemmas, proved anew on each run, and the page that they make.

A family is a module with LEMMAS. What is refuted stands beside its repair, in the same family.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

from stt_codegen.lemmas import bumps, reach, refined, smooth, theorem, transform, update
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict

FAMILIES = {
    "reach": ("Reachability tube", reach.LEMMAS),
    "bumps": ("Circumvent functions", bumps.LEMMAS),
    "smooth": ("Smooth maximum and minimum", smooth.LEMMAS),
    "update": ("Update function", update.LEMMAS),
    "transform": ("Error transform and law", transform.LEMMAS),
    "theorem": ("Theorem 4.1", theorem.LEMMAS),
    "refined": ("Refined tube", refined.LEMMAS),
}


@dataclass(frozen=True)
class Entry:
    """A lemma with what its proof came to, and how long that took."""

    lemma: Lemma
    outcome: Outcome
    seconds: float

    @property
    def verdict(self) -> Verdict:
        return self.outcome.verdict


def prove_all(progress: Callable[[str], None] = lambda _: None) -> list[Entry]:
    """Run every proof, family by family."""
    entries = []
    for title, lemmas in FAMILIES.values():
        progress(title)
        for lemma in lemmas:
            begin = time.perf_counter()
            outcome = lemma.run()
            entries.append(Entry(lemma, outcome, time.perf_counter() - begin))
    return entries


def page(entries: list[Entry]) -> str:
    """The book as Markdown: statement, formula, assumptions, source, verdict, method, evidence; the same on every run."""
    counts = ", ".join(f"{sum(e.verdict is verdict for e in entries)} {verdict.value}" for verdict in Verdict)
    lines = [
        "# Lemmas",
        "",
        f"{counts}; made by `stt-codegen prove`,",
        'which computes every verdict anew. Source "Program": the statement is about the expression that is printed. Refuted are',
        "statements as the paper prints them or as one might hope; their repairs stand beside them.",
    ]
    for name, (title, _) in FAMILIES.items():
        lines += ["", f"## {title}"]
        for e in entries:
            if e.lemma.family != name:
                continue
            lines += ["", f"### {e.lemma.name}: {e.verdict.value}", "", e.lemma.statement, "", f"$${e.lemma.latex}$$", ""]
            if e.lemma.assumptions:
                lines.append(f"- assumed: {'; '.join(e.lemma.assumptions)}")
            lines += [
                f"- source: {e.lemma.source}",
                f"- method: {e.outcome.method}",
                *(f"- {line}" for line in e.outcome.evidence),
            ]
    return "\n".join(lines) + "\n"
