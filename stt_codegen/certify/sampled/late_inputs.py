"""P9 by the worst path (sampling/path/): for inputs that act late, and where the sharp conditions fail.

The path is followed in whole numbers, so search and proof are one computation. docs/sampling-path.md has the theorem.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

from stt_codegen.certify.certificate import PathClaim, PeriodProof
from stt_codegen.decimals import by_component, decimal
from stt_codegen.sampling.path import PathLoop, PathProof, prove_path, prove_path_for
from stt_codegen.task import Task


def prove_late_period(task: Task, loop: PathLoop, rho_of_conditions: Sequence[Fraction] | None) -> PeriodProof | None:
    """Prove the task's period by the path; None where it does not.

    rho_of_conditions: e^E by component as the sharp conditions prove it for such an age. The path takes it where that is larger,
    so that theorems about these conditions are about the same numbers.
    """
    proof = prove_path(loop)
    if proof is not None and rho_of_conditions is not None:
        proof = prove_path_for(loop, [max(pair) for pair in zip(proof.rho, rho_of_conditions, strict=True)]) or proof
    return None if proof is None else _period_proof(task, loop, proof)


def _period_proof(task: Task, loop: PathLoop, proof: PathProof) -> PeriodProof:
    return PeriodProof(
        period=task.sampling_period,
        latency=task.control.latency,
        share=task.initial_set.share,
        rho=proof.rho,
        u=proof.u,
        shift=tuple(law.shift for law in loop.laws),
        paths=tuple(PathClaim(path.nearest, path.history) for path in proof.paths),
    )


def disturbances(task: Task) -> list[Fraction]:
    """Return the bounds on |f + w| by component."""
    return [bounds.force for bounds in task.plant_bounds]


def drive_words(task: Task) -> list[str]:
    """Return what the proof assumes of when inputs act, in words; empty where they act at once."""
    drives, words = task.drive_bounds, []
    if task.control.latency:
        words.append(f"u acts at most {decimal(task.control.latency)} s after its sample")
    lags = [by_component(values) for values in ([d.lag for d in drives], [d.lag2 for d in drives]) if any(values)]
    kinds = []
    if len(lags) > 1:
        kinds.append(f"is no slower than two first-order lags in series, of {' s and '.join(lags)} s")
    elif lags:
        exponent = "lag" if lags[0].startswith("[") else lags[0]
        answer = f" (its step response never falls and is never below 1 - e^(-t/{exponent}))"
        kinds.append(f"is no slower than a first-order lag of {lags[0]} s{'' if any(d.overshoot for d in drives) else answer}")
    if any(d.slew for d in drives):
        kinds.append(f"follows u by at least {by_component([d.slew or Fraction(0) for d in drives])} a second")
    if any(d.overshoot for d in drives):
        kinds.append(f"overshoots a step by at most {by_component([d.overshoot for d in drives])} of it")
    if kinds:
        words.append(f"a drive that {', '.join(kinds[:-1])}{' and ' * (len(kinds) > 1)}{kinds[-1]}, at rest at 0")
    return words
