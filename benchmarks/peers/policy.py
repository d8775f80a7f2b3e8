"""Reinforcement learning as a peer: what a policy sees, its weights, and its C for the closed loops.

One policy for all arenas of the paper's kind: it sees the state, the time, every unsafe square, and rays like a laser scanner's.
`benchmarks/policy.py` trains it (PPO of brax, on the processor); weights are not in the repository.
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
RAYS = 16
HERTZ = 20  # decisions a second, in training and in the loops; an input is held between two
SPEED = 1.0  # |u_i| at most, that of the other peers
ANGLES = (np.arange(RAYS) + 0.5) * (2 * np.pi / RAYS)  # no ray is along an axis
DIRECTIONS = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
SEEN = 5 + 2 * FAMILY.count + RAYS  # numbers of an observation


def observe(xp: Any, x: Any, t: Any, boxes: Any) -> Any:
    """What the policy sees at one state, (SEEN,). xp: numpy or jax.numpy; x (2,), boxes (count, 2, 2) of lower and upper edges.

    In units of the room's side and of t_c: x, the way to the target's middle, t, the middles of the squares seen from x, nearest
    first, and how far every ray goes.
    """
    side = FAMILY.side
    away = xp.max(xp.maximum(boxes[..., 0] - x, x - boxes[..., 1]), axis=-1)
    middles = (xp.mean(boxes, axis=-1) - x)[xp.argsort(away)]
    way = side - BOX / 2 - x
    seen = [
        x / side,
        way / side,
        xp.reshape(t / FAMILY.prescribed_time, (1,)),
        xp.ravel(middles) / side,
        rays(xp, x, boxes) / side,
    ]
    return xp.concatenate(seen)


def rays(xp: Any, x: Any, boxes: Any) -> Any:
    """How far every ray goes to the first square or wall, (RAYS,)."""
    directions = xp.asarray(DIRECTIONS)[:, None, :]
    ends = [(boxes[None, ..., k] - x) / directions for k in (0, 1)]
    near, far = xp.max(xp.minimum(*ends), axis=-1), xp.min(xp.maximum(*ends), axis=-1)
    hits = xp.where((near < far) & (far > 0), xp.maximum(near, 0), xp.inf)
    walls = xp.min(xp.maximum((0 - x) / directions[:, 0], (FAMILY.side - x) / directions[:, 0]), axis=-1)
    return xp.minimum(xp.min(hits, axis=-1), walls)


@dataclass(frozen=True)
class Policy:
    """A trained policy: observations are shifted and scaled, layers are matrices (in, out) with biases, SiLU between them,
    and u is SPEED times the hyperbolic tangent of the first half of what comes out. trained: seconds of training; steps: of
    the plant."""

    shift: Array
    scale: Array
    layers: tuple[tuple[Array, Array], ...]
    seed: int
    trained: float
    steps: int

    def __call__(self, x: Array, t: float, boxes: Array) -> Array:
        """u, (2,)."""
        value = (observe(np, x, np.asarray(t), boxes) - self.shift) / self.scale
        for k, (weights, bias) in enumerate(self.layers):
            value = value @ weights + bias
            if k < len(self.layers) - 1:
                value = value / (1 + np.exp(-value))
        return np.asarray(SPEED * np.tanh(value[:2]))

    def source(self, boxes: Array) -> str:
        """The policy in an arena as C: `decide`, in single precision."""

        def numbers(values: Array) -> list[Any]:
            return [numbers(v) if np.ndim(v) else _literal(float(v)) for v in values]

        return template("bench/policy.c.j2").render(
            side=FAMILY.side, t_c=FAMILY.prescribed_time, half_goal=BOX / 2, speed=SPEED, seen=SEEN, rays=numbers(DIRECTIONS),
            layers=[(numbers(w), numbers(b)) for w, b in self.layers], shift=numbers(self.shift), scale=numbers(self.scale),
            boxes=numbers(boxes), widest=max(SEEN, *(len(b) for _, b in self.layers)),
        )  # fmt: skip

    def save(self, path: Path) -> None:
        path.parent.mkdir(parents=True, exist_ok=True)
        layers = {
            f"{name}{k}": v for k, layer in enumerate(self.layers) for name, v in zip(("weights", "bias"), layer, strict=True)
        }
        about = {"seed": self.seed, "trained": self.trained, "steps": self.steps}
        np.savez(path, allow_pickle=False, shift=self.shift, scale=self.scale, **layers, **about)


def _literal(value: float) -> str:
    """A float of C that reads back as the same float."""
    text = f"{value:.9g}"
    return f"{text}F" if any(c in text for c in ".e") else f"{text}.0F"


def load_policy(path: Path) -> Policy:
    """A policy that `benchmarks/policy.py` saved."""
    with np.load(path) as found:
        count = sum(name.startswith("weights") for name in found)
        layers = tuple((found[f"weights{k}"], found[f"bias{k}"]) for k in range(count))
        return Policy(found["shift"], found["scale"], layers, int(found["seed"]), float(found["trained"]), int(found["steps"]))
