"""Measure the error of the implicit step of the update function, equation (11), against a stiff integrator (Radau, 1e-10).

    python -m benchmarks alpha

For every example task and step length it prints the largest error of alpha, and the observed order of the step.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from stt_codegen import reference
from stt_codegen.design.paper_tubes.adaptive_search import design_adaptive
from stt_codegen.designs.adaptive import AdaptiveDesign, parameters_of, step_alpha
from stt_codegen.task.load import load_task

STEP_LENGTHS = (0.001, 0.005, 0.02)  # seconds


def stiff_alpha(design: AdaptiveDesign, samples: int = 450) -> tuple[np.ndarray, np.ndarray]:
    """Integrate alpha by Radau at 1e-10. Return times, (samples + 1,), and alpha, (samples + 1, 2 n)."""
    parameters = parameters_of(design)
    t_c = float(design.prescribed_time)
    times = np.linspace(0, t_c, samples + 1)

    def rate(t: float, alpha: np.ndarray) -> np.ndarray:
        lines = reference.lines(parameters, [t])
        return reference.alpha_rate(parameters, lines.psi[0].ravel(), lines.theta[0].ravel(), alpha)[0].astype(float)

    def jacobian(t: float, alpha: np.ndarray) -> np.ndarray:
        lines = reference.lines(parameters, [t])
        return np.diag(reference.alpha_rate(parameters, lines.psi[0].ravel(), lines.theta[0].ravel(), alpha)[1].astype(float))

    start = np.zeros(2 * design.dimension)
    solution = solve_ivp(rate, (0, t_c), start, "Radau", times, rtol=1e-10, atol=1e-12, jac=jacobian, max_step=t_c / 100)
    return times, solution.y.T


def stepped_alpha(design: AdaptiveDesign, dt: float, times: np.ndarray) -> np.ndarray:
    """Return alpha at `times`, which are multiples of dt, by the implicit step."""
    count = round(float(design.prescribed_time) / dt)
    psi = reference.lines(parameters_of(design), np.arange(count + 1) * dt).psi.astype(float)
    return step_alpha(design, psi, dt).reshape(count + 1, -1)[np.rint(times / dt).astype(int)]


def main() -> None:
    """Print the table of errors for all example tasks."""
    print(f"{'task':14s}{'dt [ms]':>10s}{'error of alpha':>18s}{'order':>8s}{'largest alpha':>16s}")
    for path in sorted(Path("tasks").glob("*.toml")):
        design = design_adaptive(load_task(path))
        times, exact = stiff_alpha(design)
        previous = None
        for dt in STEP_LENGTHS:
            error = float(np.abs(stepped_alpha(design, dt, times) - exact).max())
            order = "" if previous is None else f"{np.log(error / previous[1]) / np.log(dt / previous[0]):.2f}"
            print(f"{path.stem:14s}{1000 * dt:10.0f}{error:18.2e}{order:>8s}{np.abs(exact).max():16.3f}")
            previous = (dt, error)


if __name__ == "__main__":
    main()
