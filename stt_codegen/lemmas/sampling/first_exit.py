"""The calculus of a first exit, in small steps that the sampled statements name: eps differentiable from the left everywhere,
for u is piecewise constant, and x and the edges have a slope between two changes of u.
"""

from __future__ import annotations

from itertools import product
from types import SimpleNamespace
from typing import Any

import numpy as np
import sympy as sp

from stt_codegen.lemmas.evaluated_expression import EvaluatedExpression
from stt_codegen.lemmas.lemma import Lemma, Outcome, Verdict, all_of, prove_identities, prove_positive
from stt_codegen.sampling import Setting, Windows, back

E, h, p, y = sp.symbols("E h p y", positive=True)


def _prove_first_exit() -> Outcome:
    """Were the slope -p, then for some h > 0 the quotient (f(t1) - f(t1 - h))/h would be -p/2 - y or less, by what a derivative
    is; so f(t1 - h) = f(t1) + h (p/2 + y), above E before t1."""
    before = E - h * (-p / 2 - y)
    return all_of(
        prove_identities({"f(t1 - h) - E - h (p/2 + y)": sp.expand(before - E - h * (p / 2 + y))}),
        prove_positive({"f(t1 - h) - E": sp.expand(before - E)}),
    )


def _prove_integral() -> Outcome:
    """On each piece between two changes of u the mean value theorem gives one slope; here three pieces, so any number."""
    lengths, slack = sp.symbols("h1:4", positive=True), sp.symbols("s1:4", positive=True)
    most = sp.Symbol("P", real=True)
    moved = sum((most - s) * a for s, a in zip(slack, lengths, strict=True))
    rest = sp.expand(most * sum(lengths) - moved)
    return all_of(
        prove_identities(
            {"P (h1 + h2 + h3) less what was moved less s1 h1 + s2 h2 + s3 h3": rest - sum(map(sp.Mul, slack, lengths))}
        ),
        prove_positive({"s1 h1 + s2 h2 + s3 h3": rest}),
    )


def _prove_age() -> Outcome:
    """t1 = t_k + y in window k, and a sample of age a <= tau <= w, the length of window k - 1, was taken at t1 - a >= t_k - w.
    The input that still acted while this sample was on its way was made from one that is at most 2 tau old; there 2 tau <= w."""
    tau, late, more, room = sp.symbols("tau late y room", positive=True)  # a = tau - late, w = tau + room
    wrong: list[str] = []
    cases = 0
    for lengths, latency in product(((1.0, 3.0, 2.0), (2.0, 0.5, 4.0), (0.25, 0.25, 0.25), (7.0, 5.0, 3.0)), (0.0, 0.125)):
        times = np.cumsum([0.0, *lengths])
        windows: Any = SimpleNamespace(times=times)
        shortest = Windows.shortest.fget(windows)  # type: ignore[attr-defined]
        seen: Any = SimpleNamespace(
            windows=SimpleNamespace(shortest=shortest), law=SimpleNamespace(latency=latency), known_to=np.inf
        )
        age = Setting.longest_age.fget(seen)  # type: ignore[attr-defined]
        cases += 1
        if age * (2 if latency else 1) != min(lengths):
            wrong.append(f"{age} for windows of {lengths} s")
    return all_of(
        prove_identities(
            {"(t1 - a) - (t_k - w), less y + late + room": (more - (tau - late)) + (tau + room) - (more + late + room)}
        ),
        prove_positive({"y + late + room": more + late + room}),
        Outcome(
            Verdict.OPEN if wrong else Verdict.PROVED,
            "by cases: the evaluated code",
            (f"longest_age, twice it where there is latency, is the shortest window's length, in {cases} cases", *wrong),
        ),
    )


def _prove_before() -> Outcome:
    """`back` run on symbols, both ways round: by window the one that is worse, of the window and the one before."""
    found = {}
    for numbers in ((1.0, 2.0, 3.0), (3.0, 2.0, 1.0), (1.0, 3.0, 2.0)):
        names = sp.symbols("v0:3", real=True)
        values = np.array([[EvaluatedExpression(s, v)] for s, v in zip(names, numbers, strict=True)], dtype=object)
        for word, worse, pick in (("most", np.maximum, max), ("least", np.minimum, min)):
            for k, v in enumerate(back(values, worse)[:, 0]):
                wanted = pick((max(k - 1, 0), k), key=lambda j: numbers[j])
                found[f"{word} for {numbers}, window {k}"] = v.expression - names[wanted]
    return prove_identities(found, "SymPy: the evaluated code run on symbols, for every order of three windows' neighbours")


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
