"""The closed loop in python-control: the emitted controller of tasks/omni_s2.toml and a plant of your own, under a gust.

python docs/loop_example.py        (from the project's folder; takes some seconds, most of them to import python-control)
"""

from pathlib import Path

import control
import numpy as np

from stt_codegen.loop.systems import closed_loop, start_of
from stt_codegen.pipeline import build

TASK = Path(__file__).parent.parent / "tasks" / "omni_s2.toml"


def pushed_cart(t, x, inputs, params):  # your plant, in five lines: xdot = f(x) + g(x) u + w
    u, w = inputs[:2], inputs[2:]
    drift = [-0.1 * x[1], 0.1 * np.sin(x[0])]
    gains = [0.9 + 0.1 * np.cos(x[1]), 1.2]
    return drift + gains * u + w


def main() -> None:
    controller = build(TASK)
    plant = control.nlsys(
        pushed_cart, None, inputs=["u1", "u2", "w1", "w2"], outputs=["x1", "x2"], states=["x1", "x2"], name="plant"
    )
    loop = closed_loop(controller, plant)
    t = np.linspace(0, 9, 901)
    gust = 0.3 * np.array([np.sin(2 * t), (t > 4) & (t < 5)])
    response = control.input_output_response(
        loop, t, gust, start_of(controller), solve_ivp_kwargs={"rtol": 1e-8, "max_step": 0.02}
    )
    x, margin = response.outputs[:2], response.outputs[4]
    print(f"x(9) = {x[0, -1]:.3f}, {x[1, -1]:.3f}; least margin {margin.min():.3f} of the tube's width")


if __name__ == "__main__":
    main()
