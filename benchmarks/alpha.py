"""How accurate the implicit step of the update function (11) is: against a stiff integrator (Radau, 1e-10).

    python -m benchmarks alpha

For every example task and step length: the largest error of alpha and of an edge of the tube, and the order observed.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from stt_codegen import reference
from stt_codegen.design.paper_tubes.adaptive_search import design_adaptive
from stt_codegen.designs.adaptive import AdaptiveDesign, parameters_of, step_alpha
from stt_codegen.task.load import load_task

STEPS = (0.001, 0.005, 0.02)


def stiff_alpha(design: AdaptiveDesign, samples: int = 450) -> tuple[np.ndarray, np.ndarray]:
    """Times (S + 1,) and alpha (S + 1, 2 n) by Radau at 1e-10, each bump's edges met exactly by a step."""
    p = parameters_of(design)
    t_c = float(design.prescribed_time)
    times = np.linspace(0, t_c, samples + 1)

    def rate(t: float, alpha: np.ndarray) -> np.ndarray:
        now = reference.lines(p, [t])
        return reference.alpha_rate(p, now.psi[0].ravel(), now.theta[0].ravel(), alpha)[0].astype(float)

    def jacobian(t: float, alpha: np.ndarray) -> np.ndarray:
        now = reference.lines(p, [t])
        return np.diag(reference.alpha_rate(p, now.psi[0].ravel(), now.theta[0].ravel(), alpha)[1].astype(float))

    start = np.zeros(2 * design.dimension)
    solution = solve_ivp(rate, (0, t_c), start, "Radau", times, rtol=1e-10, atol=1e-12, jac=jacobian, max_step=t_c / 100)
    return times, solution.y.T


def stepped_alpha(design: AdaptiveDesign, dt: float, times: np.ndarray) -> np.ndarray:
    """alpha at `times` (multiples of dt) by the implicit step."""
    count = round(float(design.prescribed_time) / dt)
    psi = reference.lines(parameters_of(design), np.arange(count + 1) * dt).psi.astype(float)
    return step_alpha(design, psi, dt).reshape(count + 1, -1)[np.rint(times / dt).astype(int)]


def main() -> None:
    print(f"{'task':14s}{'dt [ms]':>10s}{'error of alpha':>18s}{'order':>8s}{'largest alpha':>16s}")
    for path in sorted(Path("tasks").glob("*.toml")):
        design = design_adaptive(load_task(path))
        times, truth = stiff_alpha(design)
        before = None
        for dt in STEPS:
            error = float(np.abs(stepped_alpha(design, dt, times) - truth).max())
            order = "" if before is None else f"{np.log(error / before[1]) / np.log(dt / before[0]):.2f}"
            print(f"{path.stem:14s}{1000 * dt:10.0f}{error:18.2e}{order:>8s}{np.abs(truth).max():16.3f}")
            before = (dt, error)


if __name__ == "__main__":
    main()
