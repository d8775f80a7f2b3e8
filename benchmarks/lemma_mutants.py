"""How many mutated kernels the lemma book finds: one node of a kernel changed, its lemma run again.

    python benchmarks/lemma_mutants.py [COUNT]

A mutant counts when it changes an output at some random inputs by more than rounding; it is found when a lemma about that kernel
is no longer proved. Deterministic.
"""

from __future__ import annotations

import random
import sys
from collections import Counter
from collections.abc import Callable
from dataclasses import replace
from typing import Any

from stt_codegen.lemmas import bumps, reach, refined, smooth, transform, update
from stt_codegen.lemmas.lemma import Lemma, Verdict
from stt_codegen.program.lower import lower
from stt_codegen.program.program import Assign, Const, Kernel, Op, Program, real
from stt_codegen.program.python import PythonPrinter

MODULES = (bumps, reach, refined, smooth, transform, update)
OTHER = {
    "add": "sub",
    "sub": "add",
    "mul": "div",
    "div": "mul",
    "lt": "le",
    "exp": "tanh",
    "log": "exp",
    "log1p": "exp",
    "neg": "fabs",
}


def mutate(kernel: Kernel, draw: random.Random) -> tuple[Kernel, str]:
    """One node changed: the operation, the order of its operands, an operand, or a constant."""
    places = [k for k, a in enumerate(kernel.body) if isinstance(a.value, Op)]
    at = draw.choice(places)
    assign = kernel.body[at]
    op = assign.value
    assert isinstance(op, Op)
    kind = draw.choice(("operation", "order", "operand"))
    if kind == "operation" and op.name in OTHER:
        new = Op(OTHER[op.name], op.args)
    elif kind == "order" and op.name in ("sub", "div", "lt"):
        new = Op(op.name, op.args[::-1])
    else:
        k = draw.randrange(len(op.args))
        old = op.args[k]
        known = [v for v in (*kernel.inputs, *(a.var for a in kernel.body[:at])) if v.type is old.type and v != old]
        if isinstance(old, Const) and old.value is not None and not isinstance(old.value, bool):
            changed: Any = real(old.value + draw.choice((1, -1)) * 2)  # type: ignore[operator]
        elif known:
            changed = draw.choice(known)
        else:
            return kernel, "none"
        new = Op(op.name, (*op.args[:k], changed, *op.args[k + 1 :]))
    body = (*kernel.body[:at], Assign(assign.var, new), *kernel.body[at + 1 :])
    return replace(kernel, body=body), f"{kernel.name}: {assign.var.name} = {new.name}"


def function_of(kernel: Kernel) -> Callable[..., Any]:
    printer = PythonPrinter(Program("p", 1, "double", (), (kernel,), ()))
    names: dict[str, Any] = {}
    exec("import math\n" + "\n".join(printer.kernel(kernel)), names)
    function: Callable[..., Any] = names[f"_{kernel.name}"]
    return function


def changes(before: Kernel, after: Kernel, draw: random.Random) -> bool:
    """Whether an output differs at one of 60 random inputs."""
    one, other = function_of(before), function_of(after)
    for _ in range(60):
        given = [draw.uniform(0.05, 3.0) for _ in before.inputs]
        try:
            a = one(*given)
        except (ValueError, ZeroDivisionError, OverflowError):
            continue
        try:
            b = other(*given)
        except (ValueError, ZeroDivisionError, OverflowError, TypeError):
            return True
        pairs = zip(a, b, strict=True) if isinstance(a, tuple) else ((a, b),)
        if any(isinstance(y, complex) or abs(x - y) > 1e-9 * (1 + abs(x)) for x, y in pairs):
            return True
    return False


def kernels_of(lemma: Lemma, module: Any) -> list[str]:
    """The kernels that a lemma reads, by running it once."""
    seen: list[str] = []

    def watching(function: Any, *rest: Any) -> Kernel:
        kernel = lower(function, *rest)
        seen.append(kernel.name)
        return kernel

    module.lower = watching
    lemma.run()
    module.lower = lower
    return list(dict.fromkeys(seen))


def main(count: int) -> None:
    draw = random.Random(1)
    about = [(m, v, k) for m in MODULES for v in m.LEMMAS for k in kernels_of(v, m)]
    kernels = sorted({(m.__name__.rsplit(".", 1)[1], k) for m, _, k in about})
    tally: Counter[str] = Counter()
    missed: list[str] = []
    while tally["changed"] < count:
        family, name = draw.choice(kernels)
        module = next(m for m in MODULES if m.__name__.endswith(f".{family}"))
        made: dict[str, tuple[Kernel, Kernel, str]] = {}
        seed = draw.randrange(1 << 30)

        def bent(function: Any, *rest: Any, name: str = name, seed: int = seed, made: dict[str, Any] = made) -> Kernel:
            kernel = lower(function, *rest)
            if kernel.name != name:
                return kernel
            after, what = mutate(kernel, random.Random(seed))
            made["kernel"] = (kernel, after, what)
            return after

        module.lower = bent
        verdicts = [v.run().verdict for m, v, k in about if m is module and k == name]
        module.lower = lower
        before, after, what = made["kernel"]
        tally["mutants"] += 1
        if before == after or not changes(before, after, draw):
            continue
        tally["changed"] += 1
        if all(v is Verdict.PROVED for v in verdicts):
            missed.append(what)
        else:
            tally["found"] += 1
    print(f"{tally['mutants']} mutants of {len(kernels)} kernels, {tally['changed']} change a value, {tally['found']} found")
    for what, times in Counter(missed).most_common():
        print(f"  missed {times} times: {what}")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 200)
