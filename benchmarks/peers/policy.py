"""Reinforcement learning as a peer: a policy's observation, its weights, and its C for the closed loops.

One policy drives in all arenas of the paper's kind. It observes the state, the time, every unsafe square, and rays like those of
a laser scanner. `benchmarks/policy.py` trains it (PPO of brax, on the processor); weights are not in the repository. `in_loops`
runs it.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.suites.families import BOX, FAMILIES
from stt_codegen.program.targets.template_files import template

Array = npt.NDArray[Any]
FAMILY = FAMILIES["paper"]
RAY_COUNT = 16
DECISIONS_PER_SECOND = 20  # in training and in the loops; an input is held between two decisions
SPEED = 1.0  # bound of |u_i|, as for the other peers
RAY_ANGLES = (np.arange(RAY_COUNT) + 0.5) * (2 * np.pi / RAY_COUNT)  # no ray is along an axis
RAY_DIRECTIONS = np.stack([np.cos(RAY_ANGLES), np.sin(RAY_ANGLES)], axis=1)
OBSERVATION_SIZE = 5 + 2 * FAMILY.count + RAY_COUNT


def observe(xp: Any, x: Any, t: Any, boxes: Any) -> Any:
    """Return the observation of the policy at one state, (OBSERVATION_SIZE,).

    xp: numpy or jax.numpy; x: (2,); boxes: the unsafe squares, (count, 2, 2), by square, axis, and lower or upper edge.

    The observation has five parts: x, the vector from x to the centre of the target, t, the vectors from x to the centres of the
    squares (the nearest square first), and the lengths of the rays. Its unit of length is the side of the state space, and its
    unit of time is t_c.
    """
    side = FAMILY.side
    distance = xp.max(xp.maximum(boxes[..., 0] - x, x - boxes[..., 1]), axis=-1)
    vectors_to_squares = (xp.mean(boxes, axis=-1) - x)[xp.argsort(distance)]
    vector_to_target = side - BOX / 2 - x
    parts = [
        x / side,
        vector_to_target / side,
        xp.reshape(t / FAMILY.prescribed_time, (1,)),
        xp.ravel(vectors_to_squares) / side,
        ray_lengths(xp, x, boxes) / side,
    ]
    return xp.concatenate(parts)


def ray_lengths(xp: Any, x: Any, boxes: Any) -> Any:
    """Return the distance along every ray from x to the first square or wall, (RAY_COUNT,)."""
    directions = xp.asarray(RAY_DIRECTIONS)[:, None, :]
    ends = [(boxes[None, ..., k] - x) / directions for k in (0, 1)]
    near, far = xp.max(xp.minimum(*ends), axis=-1), xp.min(xp.maximum(*ends), axis=-1)
    hits = xp.where((near < far) & (far > 0), xp.maximum(near, 0), xp.inf)
    walls = xp.min(xp.maximum((0 - x) / directions[:, 0], (FAMILY.side - x) / directions[:, 0]), axis=-1)
    return xp.minimum(xp.min(hits, axis=-1), walls)


@dataclass(frozen=True)
class Policy:
    """A trained policy: a network with SiLU between its layers, from the observation minus `shift`, divided by `scale`, to u.

    The network has four outputs: PPO trains a normal distribution of each input, by its mean and its spread. u is SPEED times the
    hyperbolic tangent of the two means. layers: matrices (in, out) with biases; training_steps: decisions of the policy in
    training."""

    shift: Array
    scale: Array
    layers: tuple[tuple[Array, Array], ...]
    seed: int
    training_seconds: float
    training_steps: int

    def __call__(self, x: Array, t: float, boxes: Array) -> Array:
        """Return u, (2,)."""
        value = (observe(np, x, np.asarray(t), boxes) - self.shift) / self.scale
        for k, (weights, bias) in enumerate(self.layers):
            value = value @ weights + bias
            if k < len(self.layers) - 1:
                value = value / (1 + np.exp(-value))
        return np.asarray(SPEED * np.tanh(value[:2]))

    def source(self, boxes: Array) -> str:
        """Print the policy for an arena as C: `decide`, in single precision."""

        def numbers(values: Array) -> list[Any]:
            return [numbers(v) if np.ndim(v) else _literal(float(v)) for v in values]

        return template("bench/policy.c.j2").render(
            side=FAMILY.side, t_c=FAMILY.prescribed_time, half_target=BOX / 2, speed=SPEED, observation_size=OBSERVATION_SIZE,
            rays=numbers(RAY_DIRECTIONS),
            layers=[(numbers(w), numbers(b)) for w, b in self.layers], shift=numbers(self.shift), scale=numbers(self.scale),
            boxes=numbers(boxes), largest_layer=max(OBSERVATION_SIZE, *(len(b) for _, b in self.layers)),
        )  # fmt: skip

    def save(self, path: Path) -> None:
        """Write the policy to an .npz file, which `load_policy` reads."""
        path.parent.mkdir(parents=True, exist_ok=True)
        layers = {
            f"{name}{k}": v for k, layer in enumerate(self.layers) for name, v in zip(("weights", "bias"), layer, strict=True)
        }
        # the keys of stored files: those of earlier trainings stay readable
        training = {"seed": self.seed, "trained": self.training_seconds, "steps": self.training_steps}
        np.savez(path, allow_pickle=False, shift=self.shift, scale=self.scale, **layers, **training)


def _literal(value: float) -> str:
    """Print a float of C that reads back as the same float."""
    text = f"{value:.9g}"
    return f"{text}F" if any(c in text for c in ".e") else f"{text}.0F"


def load_policy(path: Path) -> Policy:
    """Read a policy that `Policy.save` wrote."""
    with np.load(path) as arrays:
        count = sum(name.startswith("weights") for name in arrays)
        layers = tuple((arrays[f"weights{k}"], arrays[f"bias{k}"]) for k in range(count))
        return Policy(
            arrays["shift"], arrays["scale"], layers, int(arrays["seed"]), float(arrays["trained"]), int(arrays["steps"])
        )
