"""The emitted controller and plants as python-control systems: `control.nlsys`, joined by `control.interconnect`.

    controller      inputs x1..xn, outputs u1..un, margin: the emitted Python, continuous in time; an adaptive tube's alpha are
                    its states, moved by the emitted right side of (11)
    plant           inputs u1..un, w1..wn, outputs x1..xn
    closed loop     inputs w1..wn, outputs x1..xn, u1..un, margin

Your plant is any `control.nlsys` with those names, or a `Plant` (plants.py). Importing python-control takes seconds, so import
this late.
"""

from __future__ import annotations

from typing import Any

import control
import numpy as np
import numpy.typing as npt

from stt_codegen.pipeline import EmittedController
from stt_codegen.plants import Model, model
from stt_codegen.program.targets.python.runner import load_module

Array = npt.NDArray[Any]


def signal_names(letter: str, n: int) -> list[str]:
    """Return the names x1, x2, .. of n signals, for the letter x."""
    return [f"{letter}{i + 1}" for i in range(n)]


def controller_system(controller: EmittedController, name: str = "controller") -> Any:
    """Return the emitted Python controller as a system: x1..xn in, u1..un and margin out (0.5 in the middle, 0 at an edge)."""
    module: Any = load_module(controller.task.name, controller.files[f"{controller.task.name}.py"])
    n = controller.task.dimension
    signals = {"name": name, "inputs": signal_names("x", n), "outputs": [*signal_names("u", n), "margin"]}
    if not controller.design.is_stateful:

        def law(t: float, _alpha: Array, x: Array, _params: Any) -> Array:
            return np.array([*module.control(t, x)[1], module.margin(t, x)])

        return control.nlsys(None, law, **signals)

    def rate(t: float, alpha: Array, _x: Array, _params: Any) -> Array:
        return np.array(module.alpha_rate(t, alpha)[0])

    def adaptive_law(t: float, alpha: Array, x: Array, _params: Any) -> Array:
        return np.array([*module.control(t, alpha, x)[1], module.margin(t, alpha, x)])

    return control.nlsys(rate, adaptive_law, states=signal_names("alpha", 2 * n), **signals)


def plant_system(plant: Model, n: int, name: str = "plant") -> Any:
    """Return a plant as a system: u1..un and w1..wn in, x1..xn out (its states); constants in the middle of their ranges."""
    evaluate, middle = model(plant, n), [(low + high) / 2 for low, high in plant.constants]

    def rate(_t: float, x: Array, inputs: Array, _params: Any) -> Array:
        f, g = (np.array(v) for v in evaluate(np.concatenate([x, middle, x if plant.mixing else []])))
        return np.asarray(f.ravel() + g @ inputs[:n] + inputs[n:])

    def output(_t: float, x: Array, _inputs: Array, _params: Any) -> Array:
        return x

    signals = {
        "inputs": [*signal_names("u", n), *signal_names("w", n)],
        "outputs": signal_names("x", n),
        "states": signal_names("x", n),
    }
    return control.nlsys(rate, output, name=name, **signals)


def closed_loop(controller: EmittedController, plant: Any) -> Any:
    """Return controller and plant as one system: w1..wn in; x1..xn, u1..un, margin out.

    plant: a `Model`, or a system with those signals.
    """
    n = controller.task.dimension
    system = plant if isinstance(plant, control.InputOutputSystem) else plant_system(plant, n)
    return control.interconnect(
        [controller_system(controller), system],
        inputs=signal_names("w", n),
        outputs=[*signal_names("x", n), *signal_names("u", n), "margin"],
        name="closed_loop",
    )


def start_of(controller: EmittedController, x0: Any = None) -> Array:
    """Return the initial state of the closed loop: alpha = 0 where there is one, then x(0)."""
    n = controller.task.dimension
    x = np.array([float(v) for v in controller.task.initial_state] if x0 is None else x0)
    alpha = np.zeros(2 * n if controller.design.is_stateful else 0)
    return np.concatenate([alpha, x])
