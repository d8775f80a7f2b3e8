"""The lemma book: every family's lemmas, proved anew on each run, and the page that they make.

A family is one module with LEMMAS or several. What is refuted stands beside its repair, in the same family.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from stt_codegen.lemmas.cache import Cache
from stt_codegen.lemmas.emitted import functions, printed_kernels
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict, with_steps
from stt_codegen.lemmas.paper import bumps, conflict, reach, smooth_maximum, theorem_4_1, transform, update_cells, update_function
from stt_codegen.lemmas.sampling import (
    definite_plants,
    first_exit,
    sampled,
    sampled_evaluated,
    sampled_exact,
    sampled_windows,
    saturated,
)
from stt_codegen.lemmas.sets import constraint_rows as rows
from stt_codegen.lemmas.sets import moving_bounds as moving
from stt_codegen.lemmas.sets import shape_supports
from stt_codegen.lemmas.tube import filtered_tube, input_limits, spline_edges
from stt_codegen.lemmas.tube import inertial_inputs as inertia

# In this order: a step stands before what names it.
FAMILIES = {
    "reach": ("Reachability tube", reach.LEMMAS),
    "windows": ("Conflict windows, dimension and side", conflict.LEMMAS),
    "bumps": ("Circumvent functions", bumps.LEMMAS),
    "smooth": ("Smooth maximum and minimum", smooth_maximum.LEMMAS),
    "update": ("Update function", (*update_function.LEMMAS, *update_cells.LEMMAS)),
    "transform": ("Error transform and law", transform.LEMMAS),
    "theorem": ("Theorem 4.1", theorem_4_1.LEMMAS),
    "plant": ("Assumption 2 for a plant", definite_plants.LEMMAS),
    "refined": ("Refined tube", spline_edges.LEMMAS),
    "sampled": (
        "Sampled control",
        tuple(v for m in (first_exit, sampled, sampled_evaluated, sampled_windows, sampled_exact) for v in m.LEMMAS),
    ),
    "rows": ("Rows, and what the certificate reads off them", rows.LEMMAS),
    "limits": ("Limits on u", (*input_limits.LEMMAS, *saturated.LEMMAS)),
    "filtered": ("Plants of order 2", (*filtered_tube.LEMMAS, *inertia.LEMMAS)),
    "shapes": ("Shapes: normals, supports, distances", shape_supports.LEMMAS),
    "moving": ("Sets that move: parts of a piece, bounds, places", moving.LEMMAS),
    "kernels": ("What is printed: kernels of the adaptive tube", printed_kernels.LEMMAS),
    "functions": ("What is printed: functions", functions.LEMMAS),
}


@dataclass(frozen=True)
class Entry:
    """A lemma with what its proof came to."""

    lemma: Lemma
    outcome: Outcome

    @property
    def verdict(self) -> Verdict:
        return self.outcome.verdict


def prove_all(progress: Callable[[str], None] = lambda _: None, fresh: bool = True) -> list[Entry]:
    """Every proof, family by family; fresh=False takes outcomes from the cache where nothing that they rest on has changed."""
    cache = Cache(fresh)
    entries: list[Entry] = []
    known: dict[str, Verdict] = {}
    for title, lemmas in FAMILIES.values():
        progress(title)
        for lemma in lemmas:
            outcome = cache.get(lemma.name) or lemma.run()
            cache.put(lemma.name, outcome)
            outcome = with_steps(lemma, outcome, known)
            known[lemma.name] = outcome.verdict
            entries.append(Entry(lemma, outcome))
    cache.keep()
    return entries


def page(entries: list[Entry], suffix: str = ".md") -> str:
    """The book as Markdown (".md") or LaTeX (".tex"), the same on every run."""
    return latex(entries) if suffix == ".tex" else markdown(entries)


def _by_family(entries: list[Entry]) -> Iterator[tuple[str, list[Entry]]]:
    for name, (title, _) in FAMILIES.items():
        yield title, [e for e in entries if e.lemma.family == name]


def _counts(entries: list[Entry]) -> str:
    return ", ".join(f"{sum(e.verdict is verdict for e in entries)} {verdict.value}" for verdict in Verdict)


def markdown(entries: list[Entry]) -> str:
    """Statement, formula, assumptions, steps, source, verdict, method, evidence."""
    lines = [
        "# Lemmas",
        "",
        f"{_counts(entries)}; made by `stt-codegen prove`, which computes verdicts from these very sources.",
        'Source "Program": the statement is about the expression that is printed. Refuted are statements as the paper prints',
        "them, or as one might hope; their repairs stand beside them.",
    ]
    for title, members in _by_family(entries):
        lines += ["", f"## {title}"]
        for e in members:
            lines += ["", f"### {e.lemma.name}: {e.verdict.value}", "", e.lemma.statement, "", f"$${e.lemma.latex}$$", ""]
            if e.lemma.assumptions:
                lines.append(f"- assumed: {'; '.join(e.lemma.assumptions)}")
            if e.lemma.steps:
                lines.append(f"- steps: {_numbered(e.lemma.steps)}")
            lines += [
                f"- source: {e.lemma.source}",
                f"- method: {e.outcome.method}",
                *(f"- {line}" for line in e.outcome.evidence),
            ]
    return "\n".join(lines) + "\n"


LATEX_HEAD = r"""\documentclass[10pt,a4paper]{article}
\usepackage[utf8]{inputenc}
\usepackage{amsmath,amssymb}
\usepackage[margin=25mm]{geometry}
\emergencystretch=3em
\begin{document}
\title{Lemmas}
\author{}
\date{}
\maketitle
"""


def _numbered(steps: tuple[str, ...]) -> str:
    return ", ".join(f"{k}. {name}" for k, name in enumerate(steps, 1))


def latex(entries: list[Entry]) -> str:
    """The same as a LaTeX document that needs amsmath and nothing else."""
    lines = [
        LATEX_HEAD + _plain(f"{_counts(entries)}; made by stt-codegen prove, which computes verdicts from these very sources.")
    ]
    for title, members in _by_family(entries):
        lines.append(rf"\section{{{_plain(title)}}}")
        for e in members:
            lines += [
                rf"\paragraph{{{_plain(e.lemma.name)}: {e.verdict.value}.}} {_plain(e.lemma.statement)}",
                rf"\[ {e.lemma.latex} \]",
                r"\begin{itemize}\small\raggedright",
                *(rf"\item assumed: {_plain(v)}" for v in e.lemma.assumptions),
                *([rf"\item steps: {_plain(_numbered(e.lemma.steps))}"] if e.lemma.steps else []),
                rf"\item source: {_plain(e.lemma.source)}; method: {_plain(e.outcome.method)}",
                *(rf"\item \texttt{{{_plain(v)}}}" for v in e.outcome.evidence),
                r"\end{itemize}",
            ]
    return "\n".join([*lines, r"\end{document}"]) + "\n"


_SPECIAL = {
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
}


def _plain(text: str) -> str:
    """Text with what LaTeX reads as commands written out; a star or bracket may be a place to break the line."""
    quoted = "".join(_SPECIAL.get(c, rf"\{c}" if c in "&%$#_{}" else c) for c in text)
    return quoted.replace("*", r"*\allowbreak{}")
