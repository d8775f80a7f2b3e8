"""u is finite for every bit pattern: the steps of the argument in docs/c.md, and ten million random patterns."""

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
    """Return an upper bound on |u| of the emitted kernels, by ball arithmetic.

    width: lowest and highest width of the tube. near: the smallest distance to the nearer edge, as a share of the width; the nearer edge is
    within [near, 1/2] and the farther within [1/2, 1 - near] of the width."""
    balls = Enclosure(controller.program, rounding=True)
    rounding = Fraction(1, 1 << 20)  # of both distances
    pieces = 24
    ratio = (Fraction(1, 2) / near) ** Fraction(1, pieces)
    worst = 0.0
    low = width[0]
    while low < width[1]:  # octaves of the width, and in each 24 steps of the nearer distance
        high = 2 * low
        for k in range(pieces):
            a, b = (Fraction(float(near) * float(ratio) ** j).limit_denominator(10**9) for j in (k, k + 1))
            nearer = interval(a * low * (1 - rounding), b * high * (1 + rounding))
            farther = interval((1 - b) * low * (1 - rounding), (1 - a) * high * (1 + rounding))
            epsilon, xi = balls.kernel("transformed_error", nearer, farther)
            (u,) = balls.kernel("law", ball(controller.task.gain[0]), xi, epsilon)
            assert u.is_finite()
            worst = max(worst, float(abs(u).upper()))
        low = high
    return worst


def interval(low: Fraction, high: Fraction) -> arb:
    """Return the ball that contains both ends."""
    return ball(low).union(ball(high))


@pytest.mark.parametrize("name", ["omni_s2", "omni_board", "spacecraft"])
@pytest.mark.parametrize("scalar", ["float", "double"])
def test_the_law_is_far_from_overflow_for_every_clamped_error(name: str, scalar: str) -> None:
    """Widths from MINIMUM_WIDTH to twice the state space; the bound is at most the one by which `build_control_law` refuses tasks."""
    controller = controller_of(name, scalar)
    near = (1 - controller.task.e_max[0]) / 2
    space = controller.task.state_space
    widest = max(b - a for a, b in zip(space.lower, space.upper, strict=True))
    bound = law_bound(controller, (MINIMUM_WIDTH, 2 * widest), near)
    refusal_bound = abs(controller.task.gain[0]) * 2 / (near * MINIMUM_WIDTH) * 64
    assert bound <= float(refusal_bound)
    assert refusal_bound <= FORMATS[scalar].largest / 4


@pytest.mark.parametrize(
    "folder", ["omni_s2/refined/float", "omni_board/refined/float", "spacecraft/refined/double", "omni_s2/adaptive/float"]
)
def test_u_is_finite_for_ten_million_random_patterns(folder: str, tool, tmp_path) -> None:
    """Arguments are arbitrary bits or ordinary numbers. u is always finite, and each of the three statuses occurs."""
    name = folder.split("/", maxsplit=1)[0]
    source = ROOT / "generated" / folder / f"{name}.c"
    has_alpha = "alpha" in source.with_suffix(".h").read_text()
    count = 10_000_000 if not has_alpha else 2_000_000
    arrays = [("alpha", f"2 * {name.upper()}_N")] * has_alpha + [("x", f"{name.upper()}_N")]
    fill = "".join(
        f"for (int i = 0; i < {size}; i++) {array}[i] = k % 2 ? any() : ({name}_real)(draw() % 6000U) / 1000;"
        for array, size in arrays
    )
    text = (
        f'#include "{name}.h"\n#include <math.h>\n{any_value_text(f"{name}_real")}\nint main(void)\n{{\n    long seen[3] = {{0}};\n'
        + "".join(f"    {name}_real {array}[{size}];\n" for array, size in arrays)
        + f"    for (long k = 0; k < {count}L; k++) {{\n        {fill}\n        {name}_real u[{name.upper()}_N];\n"
        f"        const {name}_real t = k % 3 ? any() : ({name}_real)(draw() % 10000U) / 1000;\n"
        f"        seen[{name}_control(t, {'alpha, ' if has_alpha else ''}x, u)]++;\n"
        f"        for (int i = 0; i < {name.upper()}_N; i++) if (!isfinite(u[i])) return 2;\n    }}\n"
        "    return seen[0] && seen[1] && seen[2] ? 0 : 3;\n}\n"
    )
    (tmp_path / "main.c").write_text(text)
    command = [tool("gcc"), "-std=c99", "-O2", f"-I{source.parent}", "main.c", str(source), "-o", "main", "-lm"]
    subprocess.run(command, cwd=tmp_path, check=True)
    assert subprocess.run([tmp_path / "main"], check=False).returncode == 0
