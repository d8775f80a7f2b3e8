"""u is finite for every bit pattern: the argument of docs/c.md step by step, and ten million random patterns."""

from __future__ import annotations

import subprocess
from fractions import Fraction

import pytest
from flint import arb

from stt_codegen.designs.tube import MINIMUM_WIDTH
from stt_codegen.pipeline import EmittedController
from stt_codegen.program.analyse.ball_arithmetic import ball
from stt_codegen.program.analyse.balls import Enclosure
from stt_codegen.program.number import FORMATS
from tests.emit.test_runtime_errors import any_value_text
from tests.support.controllers import ROOT, controller_of


def law_bound(controller: EmittedController, width: tuple[Fraction, Fraction], near: Fraction) -> float:
    """An upper bound on |u| by balls over the emitted kernels: near in [c, 1/2], far in [1/2, 1 - c] of a width in that range."""
    balls = Enclosure(controller.program, rounding=True)
    slack = Fraction(1, 1 << 20)  # the roundings of near and far
    pieces = 24
    ratio = (Fraction(1, 2) / near) ** Fraction(1, pieces)
    worst = 0.0
    low = width[0]
    while low < width[1]:  # octaves of the width, and steps of the share between c and 1/2
        high = 2 * low
        for k in range(pieces):
            a, b = (Fraction(float(near) * float(ratio) ** j).limit_denominator(10**9) for j in (k, k + 1))
            first = _hull(a * low * (1 - slack), b * high * (1 + slack))
            second = _hull((1 - b) * low * (1 - slack), (1 - a) * high * (1 + slack))
            epsilon, xi = balls.kernel("transformed_error", first, second)
            (u,) = balls.kernel("law", ball(controller.task.gain[0]), xi, epsilon)
            assert u.is_finite()
            worst = max(worst, float(abs(u).upper()))
        low = high
    return worst


def _hull(low: Fraction, high: Fraction) -> arb:
    return ball(low).union(ball(high))


@pytest.mark.parametrize("name", ["omni_s2", "omni_board", "spacecraft"])
@pytest.mark.parametrize("scalar", ["float", "double"])
def test_the_law_is_far_from_overflow_over_all_that_the_clamp_lets_through(name: str, scalar: str) -> None:
    """Widths from MINIMUM_WIDTH to any that the state space has; the bound is what `control_law_of` refuses tasks by, or less."""
    controller = controller_of(name, scalar)
    near = (1 - controller.task.e_max[0]) / 2
    space = controller.task.state_space
    widest = max(b - a for a, b in zip(space.lower, space.upper, strict=True))
    bound = law_bound(controller, (MINIMUM_WIDTH, 2 * widest), near)
    claimed = abs(controller.task.gain[0]) * 2 / (near * MINIMUM_WIDTH) * 64
    assert bound <= float(claimed)
    assert claimed <= FORMATS[scalar].largest / 4


@pytest.mark.parametrize(
    "folder", ["omni_s2/refined/float", "omni_board/refined/float", "spacecraft/refined/double", "omni_s2/adaptive/float"]
)
def test_ten_million_random_patterns(folder: str, tool, tmp_path) -> None:
    """Every argument any bits; u finite each time; statuses all three, so the numbers reach every part."""
    name = folder.split("/", maxsplit=1)[0]
    source = ROOT / "generated" / folder / f"{name}.c"
    alpha = "alpha" in source.with_suffix(".h").read_text()
    count = 10_000_000 if not alpha else 2_000_000
    arrays = [("alpha", f"2 * {name.upper()}_N")] * alpha + [("x", f"{name.upper()}_N")]
    fill = "".join(
        f"for (int i = 0; i < {size}; i++) {a}[i] = k % 2 ? any() : ({name}_real)(draw() % 6000U) / 1000;" for a, size in arrays
    )
    text = (
        f'#include "{name}.h"\n#include <math.h>\n{any_value_text(f"{name}_real")}\nint main(void)\n{{\n    long seen[3] = {{0}};\n'
        + "".join(f"    {name}_real {a}[{size}];\n" for a, size in arrays)
        + f"    for (long k = 0; k < {count}L; k++) {{\n        {fill}\n        {name}_real u[{name.upper()}_N];\n"
        f"        const {name}_real t = k % 3 ? any() : ({name}_real)(draw() % 10000U) / 1000;\n"
        f"        seen[{name}_control(t, {'alpha, ' if alpha else ''}x, u)]++;\n"
        f"        for (int i = 0; i < {name.upper()}_N; i++) if (!isfinite(u[i])) return 2;\n    }}\n"
        "    return seen[0] && seen[1] && seen[2] ? 0 : 3;\n}\n"
    )
    (tmp_path / "main.c").write_text(text)
    command = [tool("gcc"), "-std=c99", "-O2", f"-I{source.parent}", "main.c", str(source), "-o", "main", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"], check=False).returncode == 0
