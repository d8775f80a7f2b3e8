"""Lemmas about a first exit from the tube, in small steps of calculus that the sampled statements name.

eps is differentiable from the left everywhere: u is piecewise constant, and x and the edges have a slope between two changes of
u. book.py takes LEMMAS as a part of the family `sampled`.
"""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy as sp

from stt_codegen.lemmas.evaluated_expression import EvaluatedExpression
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict, all_of, prove_identities, prove_positive
from stt_codegen.sampling import SampledLoop, Windows, worst_with_previous_window

E, h, p, y = sp.symbols("E h p y", positive=True)


def _prove_first_exit() -> Outcome:
    """Prove by contradiction that the slope is not -p < 0.

    For some h > 0 the quotient (f(t1) - f(t1 - h))/h would then be -p/2 - y or less, by the definition of a derivative; so
    f(t1 - h) = f(t1) + h (p/2 + y) would be above E before t1.
    """
    before = E - h * (-p / 2 - y)
    return all_of(
        prove_identities({"f(t1 - h) - E - h (p/2 + y)": sp.expand(before - E - h * (p / 2 + y))}),
        prove_positive({"f(t1 - h) - E": sp.expand(before - E)}),
    )


def _prove_integral() -> Outcome:
    """Prove the bound for three pieces, each with one mean slope by the mean value theorem; the argument is the same for any
    number."""
    lengths, slacks = sp.symbols("h1:4", positive=True), sp.symbols("s1:4", positive=True)
    rate_bound = sp.Symbol("P", real=True)
    moved = sum((rate_bound - s) * a for s, a in zip(slacks, lengths, strict=True))
    remainder = sp.expand(rate_bound * sum(lengths) - moved)
    return all_of(
        prove_identities(
            {"P (h1 + h2 + h3) less what was moved less s1 h1 + s2 h2 + s3 h3": remainder - sum(map(sp.Mul, slacks, lengths))}
        ),
        prove_positive({"s1 h1 + s2 h2 + s3 h3": remainder}),
    )


def _prove_age() -> Outcome:
    """Prove that no sample is older than the window before, and check that the code limits the age accordingly.

    Let t1 = t_k + y be in window k, and w the length of window k - 1. A sample of age a <= tau <= w was taken at
    t1 - a >= t_k - w. With latency, the input before it is of a sample that is at most 2 tau old; there 2 tau <= w.
    """
    # a = tau - younger and w = tau + margin
    tau, younger, y, margin = sp.symbols("tau late y room", positive=True)
    failures: list[str] = []
    case_count = 0
    for lengths, latency in product(((1.0, 3.0, 2.0), (2.0, 0.5, 4.0), (0.25, 0.25, 0.25), (7.0, 5.0, 3.0)), (0.0, 0.125)):
        times = np.cumsum([0.0, *lengths])
        windows: Any = SimpleNamespace(times=times)
        shortest = Windows.shortest.fget(windows)  # type: ignore[attr-defined]
        setting: Any = SimpleNamespace(
            windows=SimpleNamespace(shortest=shortest), law=SimpleNamespace(latency=latency), largest_known_age=np.inf
        )
        age = SampledLoop.longest_age.fget(setting)  # type: ignore[attr-defined]
        case_count += 1
        if age * (2 if latency else 1) != min(lengths):
            failures.append(f"{age} for windows of {lengths} s")
    return all_of(
        prove_identities(
            {"(t1 - a) - (t_k - w), less y + late + room": (y - (tau - younger)) + (tau + margin) - (y + younger + margin)}
        ),
        prove_positive({"y + late + room": y + younger + margin}),
        Outcome(
            Verdict.OPEN if failures else Verdict.PROVED,
            "by cases: the evaluated code",
            (f"longest_age, twice it where there is latency, is the shortest window's length, in {case_count} cases", *failures),
        ),
    )


def _prove_before() -> Outcome:
    """Run `worst_with_previous_window` on symbols: it must give the worse value of each window and the one before."""
    differences = {}
    for numbers in ((1.0, 2.0, 3.0), (3.0, 2.0, 1.0), (1.0, 3.0, 2.0)):
        symbols = sp.symbols("v0:3", real=True)
        values = np.array([[EvaluatedExpression(s, v)] for s, v in zip(symbols, numbers, strict=True)], dtype=object)
        for word, worse, choose in (("most", np.maximum, max), ("least", np.minimum, min)):
            for k, v in enumerate(worst_with_previous_window(values, worse)[:, 0]):
                expected = choose((max(k - 1, 0), k), key=lambda j: numbers[j])
                differences[f"{word} for {numbers}, window {k}"] = v.expression - symbols[expected]
    return prove_identities(differences, "SymPy: the evaluated code run on symbols, for every order of three windows' neighbours")


LEMMAS = (
    Lemma(
        "sampled.first_exit",
        "Where f reaches E for the first time, from below, its slope from the left is not negative.",
        r"f < E \text{ before } t_1,\ f(t_1) = E \Rightarrow \dot f(t_1^-) \ge 0",
        ("f has a slope from the left at t1",),
        "calculus",
        _prove_first_exit,
    ),
    Lemma(
        "sampled.integral",
        "What moves no faster than P on every piece between two changes of u moves by P times the time at most.",
        r"\dot f \le P \text{ on } [t_s, t_1] \Rightarrow f(t_1) - f(t_s) \le P\,(t_1 - t_s)",
        ("f continuous, with a slope inside every piece: the mean value theorem",),
        "calculus",
        _prove_integral,
    ),
    Lemma(
        "sampled.age",
        "A sample that acts in a window was taken in it or in the one before; so was what acted before the sample came to act.",
        r"t_s \ge t_1 - \tau \ge t_{k-1}",
        ("samples no older than tau", "tau <= the shortest window, half of it where there is latency"),
        "the evaluated code",
        _prove_age,
    ),
    Lemma(
        "sampled.before",
        "The code takes of every bound the worse one of a window and of the window before.",
        r"v_k \mapsto \max(v_{k-1}, v_k)",
        (),
        "the evaluated code",
        _prove_before,
    ),
)
