"""The lemma book: it proves every family's lemmas, and prints them as a page of Markdown or LaTeX.

`stt-codegen prove` calls it. A family is one module with LEMMAS, or several. A refuted statement stands beside its repair, in
the same family. docs/lemmas.md says what the lemmas mean for a robot.
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
    worst_path_evaluated,
    worst_path_theorem,
)
from stt_codegen.lemmas.sets import moving_bounds, shape_supports, task_constraints
from stt_codegen.lemmas.tube import filtered_tube, inertial_inputs, input_limits, spline_edges

# The order of the book: a lemma stands before those that name it as a step.
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
        (
            *first_exit.LEMMAS,
            *sampled.LEMMAS,
            *sampled_evaluated.LEMMAS,
            *sampled_windows.LEMMAS,
            *sampled_exact.LEMMAS,
        ),
    ),
    "path": ("Late inputs: the worst path", (*worst_path_theorem.LEMMAS, *worst_path_evaluated.LEMMAS)),
    "rows": ("Rows, and what the certificate reads off them", task_constraints.LEMMAS),
    "limits": ("Limits on u", (*input_limits.LEMMAS, *saturated.LEMMAS)),
    "filtered": ("Plants of order 2", (*filtered_tube.LEMMAS, *inertial_inputs.LEMMAS)),
    "shapes": ("Shapes: normals, supports, distances", shape_supports.LEMMAS),
    "moving": ("Sets that move: parts of a piece, bounds, places", moving_bounds.LEMMAS),
    "kernels": ("What is printed: kernels of the adaptive tube", printed_kernels.LEMMAS),
    "functions": ("What is printed: functions", functions.LEMMAS),
}


@dataclass(frozen=True)
class BookEntry:
    """A lemma with the outcome of its proof."""

    lemma: Lemma
    outcome: Outcome

    @property
    def verdict(self) -> Verdict:
        return self.outcome.verdict


def prove_all(progress: Callable[[str], None] = lambda _: None, fresh: bool = True) -> list[BookEntry]:
    """Run every proof, family by family, and return the book's entries in its order.

    progress: is called with the title of each family. fresh=False takes outcomes from the cache where no source has changed.
    """
    cache = Cache(fresh)
    entries: list[BookEntry] = []
    verdicts: dict[str, Verdict] = {}
    for title, lemmas in FAMILIES.values():
        progress(title)
        for lemma in lemmas:
            outcome = cache.get(lemma.name) or lemma.run()
            cache.put(lemma.name, outcome)
            outcome = with_steps(lemma, outcome, verdicts)
            verdicts[lemma.name] = outcome.verdict
            entries.append(BookEntry(lemma, outcome))
    cache.save()
    return entries


def page(entries: list[BookEntry], suffix: str = ".md") -> str:
    """Return the book as Markdown (".md") or LaTeX (".tex"), with the same bytes on every run."""
    return latex(entries) if suffix == ".tex" else markdown(entries)


def _by_family(entries: list[BookEntry]) -> Iterator[tuple[str, list[BookEntry]]]:
    for name, (title, _) in FAMILIES.items():
        yield title, [e for e in entries if e.lemma.family == name]


def _verdict_counts(entries: list[BookEntry]) -> str:
    return ", ".join(f"{sum(e.verdict is verdict for e in entries)} {verdict.value}" for verdict in Verdict)


def markdown(entries: list[BookEntry]) -> str:
    """Return the book as Markdown: of each lemma statement, formula, assumptions, steps, source, method and evidence."""
    lines = [
        "# Lemmas",
        "",
        f"{_verdict_counts(entries)}; made by `stt-codegen prove`, which computes verdicts from these very sources.",
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
                lines.append(f"- steps: {_numbered_steps(e.lemma.steps)}")
            lines += [
                f"- source: {e.lemma.source}",
                f"- method: {e.outcome.method}",
                *(f"- {line}" for line in e.outcome.evidence),
            ]
    return "\n".join(lines) + "\n"


LATEX_PREAMBLE = r"""\documentclass[10pt,a4paper]{article}
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


def _numbered_steps(steps: tuple[str, ...]) -> str:
    return ", ".join(f"{k}. {name}" for k, name in enumerate(steps, 1))


def latex(entries: list[BookEntry]) -> str:
    """Return the book as a LaTeX document; it needs amsmath, amssymb and geometry."""
    lines = [
        LATEX_PREAMBLE
        + _escape_latex(
            f"{_verdict_counts(entries)}; made by stt-codegen prove, which computes verdicts from these very sources."
        )
    ]
    for title, members in _by_family(entries):
        lines.append(rf"\section{{{_escape_latex(title)}}}")
        for e in members:
            lines += [
                rf"\paragraph{{{_escape_latex(e.lemma.name)}: {e.verdict.value}.}} {_escape_latex(e.lemma.statement)}",
                rf"\[ {e.lemma.latex} \]",
                r"\begin{itemize}\small\raggedright",
                *(rf"\item assumed: {_escape_latex(v)}" for v in e.lemma.assumptions),
                *([rf"\item steps: {_escape_latex(_numbered_steps(e.lemma.steps))}"] if e.lemma.steps else []),
                rf"\item source: {_escape_latex(e.lemma.source)}; method: {_escape_latex(e.outcome.method)}",
                *(rf"\item \texttt{{{_escape_latex(v)}}}" for v in e.outcome.evidence),
                r"\end{itemize}",
            ]
    return "\n".join([*lines, r"\end{document}"]) + "\n"


LATEX_ESCAPES = {
    "\\": r"\textbackslash{}",
    "^": r"\textasciicircum{}",
    "~": r"\textasciitilde{}",
    "<": r"\textless{}",
    ">": r"\textgreater{}",
}


def _escape_latex(text: str) -> str:
    """Return the text for LaTeX: its special characters are escaped, and a line may break after a star."""
    escaped = "".join(
        LATEX_ESCAPES.get(character, rf"\{character}" if character in "&%$#_{}" else character) for character in text
    )
    return escaped.replace("*", r"*\allowbreak{}")
