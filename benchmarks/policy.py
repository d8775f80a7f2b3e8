"""Train the reinforcement learning peer of `python -m benchmarks loop --peers`: PPO of brax, on the processor.

    python -m benchmarks policy --out build/policies        (make policies)

One policy for all arenas of the paper's kind, trained on others than those of the benchmark, with winds drawn anew in every
episode: none, constant, sinusoidal, random, or toward what is nearest, each of at most W_MAX. The reward is the way won,
along the shortest way around the unsafe squares (which the policy does not see), 10 for being in the target at t_c, -10 for
entering a square or leaving the room, which end the episode. One episode in three begins anywhere.
"""

from __future__ import annotations

import argparse
import contextlib
import os
import time
from functools import partial
from pathlib import Path
from typing import Any

os.environ.setdefault("JAX_PLATFORMS", "cpu")

import jax
import jax.numpy as jnp
import numpy as np
from brax.envs.base import Env, State, Wrapper
from brax.envs.wrappers.training import EpisodeWrapper, VmapWrapper
from brax.training.agents.ppo import networks, train
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import dijkstra

from benchmarks.peers.policy import FAMILY, HERTZ, OBSERVATION_SIZE, SPEED, Policy, observe
from benchmarks.suites.families import BOX, cubes, is_feasible

FIRST = 100_000  # seeds of the arenas that are trained on; the benchmark has 0 to 499
GRID = 51  # points of the map of ways along one axis
NEAR = 0.08  # cells nearer to a square than this count DEAR times
DEAR = 6.0
W_MAX = 0.3
SUBSTEPS = 5  # states between two decisions that are judged
T_C = FAMILY.prescribed_time
LENGTH = round(T_C * HERTZ)
HIDDEN = (128, 128)


def ways(boxes: np.ndarray) -> np.ndarray:
    """The length of the shortest way to the target's middle from every grid point, (GRID, GRID)."""
    axis = np.linspace(0, FAMILY.side, GRID)
    points = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1)
    near = np.zeros((GRID, GRID), dtype=bool)
    for box in boxes:
        near |= np.all((box[:, 0] - NEAR < points) & (points < box[:, 1] + NEAR), axis=-1)
    cost, index = np.where(near, DEAR, 1.0), np.arange(GRID * GRID).reshape(GRID, GRID)
    rows, columns, lengths = [], [], []
    for di, dj in ((0, 1), (1, 0), (1, 1), (1, -1)):
        here = (slice(0, GRID - di), slice(max(0, -dj), GRID - max(0, dj)))
        there = (slice(di, GRID), slice(max(0, dj), GRID - max(0, -dj)))
        rows.append(index[here].ravel())
        columns.append(index[there].ravel())
        lengths.append((np.hypot(di, dj) * axis[1] * np.maximum(cost[here], cost[there])).ravel())
    graph = coo_matrix((np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))), shape=(GRID * GRID,) * 2)
    goal = int(index[(round((FAMILY.side - BOX / 2) / axis[1]),) * 2])
    return np.asarray(dijkstra(graph.tocsr(), directed=False, indices=goal)).reshape(GRID, GRID)


def bank(count: int, first: int) -> tuple[np.ndarray, np.ndarray]:
    """Arenas with a way, and their maps."""
    seeds, seed = [], first
    while len(seeds) < count:
        if is_feasible(FAMILY, seed, 0.05):
            seeds.append(seed)
        seed += 1
    found = [cubes(FAMILY, s) for s in seeds]
    return np.array(found, dtype=np.float32), np.array([ways(b) for b in found], dtype=np.float32)


class Arena(Env):
    """xdot = u + w in a random arena."""

    def __init__(self, arenas: tuple[np.ndarray, np.ndarray]) -> None:
        self.boxes, self.maps = jnp.asarray(arenas[0]), jnp.asarray(arenas[1])

    observation_size = OBSERVATION_SIZE
    action_size = 2
    backend = "none"

    def reset(self, rng: Any) -> State:
        which, where, anywhere, kind, how, phase = jax.random.split(rng, 6)
        arena = jax.random.randint(which, (), 0, len(self.boxes))
        boxes = self.boxes[arena]
        several = jax.random.uniform(anywhere, (8, 2)) * FAMILY.side  # the first that is in no square
        free = jnp.all(away(several[:, None], boxes[None]) > 0.02, axis=-1)
        start = jax.random.uniform(where, (2,)) * BOX
        far = (jax.random.uniform(where) < 1 / 3) & jnp.any(free)
        x = jnp.where(far, several[jnp.argmax(free)], start)
        angle, speed, size = jax.random.uniform(how, (3,))
        state = {
            "x": x,
            "t": jnp.zeros(()),
            "arena": arena,
            "kind": jax.random.randint(kind, (), 0, 6),
            "angle": 2 * jnp.pi * angle,
            "turn": 0.5 + 19.5 * speed,
            "size": W_MAX * jnp.minimum(1.0, 0.3 + 1.4 * size),
            "rng": phase,
        }
        zero = jnp.zeros(())
        return State(state, observe(jnp, x, zero, boxes), zero, zero, {"reached": zero, "hit": zero})

    def step(self, state: State, action: Any) -> State:
        s = dict(state.pipeline_state)
        boxes, x, u = self.boxes[s["arena"]], s["x"], SPEED * jnp.clip(action, -1, 1)
        s["rng"], drawn = jax.random.split(s["rng"])
        hit, before = jnp.zeros((), bool), self.length(s["arena"], x)
        for k in range(SUBSTEPS):
            t = s["t"] + k / (HERTZ * SUBSTEPS)
            x = x + (u + self.wind(s, x, t, boxes, drawn)) / (HERTZ * SUBSTEPS)
            hit |= jnp.any(away(x, boxes) <= 0) | jnp.any((x < 0) | (x > FAMILY.side))
        s["x"], s["t"] = x, s["t"] + 1 / HERTZ
        over = s["t"] >= T_C - 0.5 / HERTZ
        reached = over & ~hit & jnp.all(x >= FAMILY.side - BOX)
        reward = before - self.length(s["arena"], x) + 10.0 * reached - 10.0 * hit
        done = (hit | over).astype(jnp.float32)
        told = {"reached": reached.astype(jnp.float32), "hit": hit.astype(jnp.float32)}
        return state.replace(
            pipeline_state=s, obs=observe(jnp, x, s["t"], boxes), reward=reward, done=done, metrics={**state.metrics, **told}
        )

    def wind(self, s: dict[str, Any], x: Any, t: Any, boxes: Any, drawn: Any) -> Any:
        along = jnp.array([jnp.cos(s["angle"]), jnp.sin(s["angle"])])
        other = 2 * jnp.pi * jax.random.uniform(drawn)
        nearest = jnp.argmin(away(x, boxes))
        point = jnp.clip(x, boxes[nearest, :, 0], boxes[nearest, :, 1]) - x
        toward = point / jnp.maximum(jnp.linalg.norm(point), 1e-6)
        kinds = jnp.stack(
            [
                jnp.zeros(2), along, along * jnp.sin(s["turn"] * t), jnp.stack([jnp.cos(other), jnp.sin(other)]), toward, toward
            ]
        )  # fmt: skip
        return s["size"] * kinds[s["kind"]]

    def length(self, arena: Any, x: Any) -> Any:
        """The map between its points."""
        at = jnp.clip(x / FAMILY.side, 0, 1) * (GRID - 1)
        low = jnp.minimum(at.astype(int), GRID - 2)
        (a, b), m = at - low, self.maps[arena]
        i, j = low
        return (1 - a) * ((1 - b) * m[i, j] + b * m[i, j + 1]) + a * ((1 - b) * m[i + 1, j] + b * m[i + 1, j + 1])


def away(x: Any, boxes: Any) -> Any:
    """How far from every square, in the largest component; negative inside."""
    return jnp.max(jnp.maximum(boxes[..., 0] - x[..., None, :] if x.ndim == 1 else boxes[..., 0] - x,
                               x - boxes[..., 1]), axis=-1)  # fmt: skip


class Fresh(Wrapper):
    """A new arena after every episode: brax's own wrapper would go back to the first."""

    def reset(self, rng: Any) -> State:
        state = self.env.reset(rng)
        state.info["next"] = jax.vmap(partial(jax.random.fold_in, data=1))(rng)
        return state

    def step(self, state: State, action: Any) -> State:
        steps = jnp.where(state.done, 0, state.info["steps"])
        state.info.update(steps=steps)
        state = self.env.step(state.replace(done=jnp.zeros_like(state.done)), action)
        both = jax.vmap(jax.random.split)(state.info["next"])
        fresh = self.env.reset(both[:, 0])

        def pick(new: Any, old: Any) -> Any:
            return jnp.where(state.done.reshape(state.done.shape + (1,) * (old.ndim - 1)).astype(bool), new, old)

        state.info["next"] = both[:, 1]
        place = jax.tree.map(pick, fresh.pipeline_state, state.pipeline_state)
        return state.replace(pipeline_state=place, obs=pick(fresh.obs, state.obs))


def wrapped(env: Env, episode_length: int, action_repeat: int, randomization_fn: Any = None) -> Env:  # noqa: ARG001 (brax names it)
    return Fresh(EpisodeWrapper(VmapWrapper(env), episode_length, action_repeat))


def trained(seed: int, minutes: float, steps: int, arenas: int) -> Policy:
    """One policy. minutes: after which its training ends, at the next look."""
    made = bank(arenas, FIRST + 1_000_000 * seed)
    begin, kept = time.perf_counter(), []

    class Enough(Exception):
        pass

    def progress(step: int, told: Any) -> None:
        took = (time.perf_counter() - begin) / 60
        share = {k: float(told[f"eval/episode_{k}"]) for k in ("reward", "reached", "hit") if f"eval/episode_{k}" in told}
        print(f"seed {seed}: {took:5.1f} min, {step:>10} steps, {share}", flush=True)

    def keep(step: int, _make: Any, params: Any) -> None:
        kept[:] = [(step, params)]
        if time.perf_counter() - begin > 60 * minutes:
            raise Enough

    factory = partial(networks.make_ppo_networks, policy_hidden_layer_sizes=HIDDEN, value_hidden_layer_sizes=HIDDEN)
    with contextlib.suppress(Enough):
        train.train(
            environment=Arena(made), num_timesteps=steps, episode_length=LENGTH, num_envs=512, unroll_length=30, batch_size=256,
            num_minibatches=16, num_updates_per_batch=3, learning_rate=3e-4, entropy_cost=3e-3, discounting=0.995,
            gae_lambda=0.95, clipping_epsilon=0.2, normalize_observations=True, reward_scaling=0.3, max_grad_norm=0.5,
            wrap_env_fn=wrapped, network_factory=factory, seed=seed, num_evals=200, num_eval_envs=256, deterministic_eval=True,
            progress_fn=progress, policy_params_fn=keep,
        )  # fmt: skip
    step, (normal, policy, *_) = kept[-1]
    inner = policy["params"]
    layers = [inner[f"hidden_{k}"] for k in range(len(HIDDEN) + 1)]
    return Policy(
        np.asarray(normal.mean, dtype=float), np.asarray(normal.std, dtype=float),
        tuple((np.asarray(v["kernel"], dtype=float), np.asarray(v["bias"], dtype=float)) for v in layers),
        seed, time.perf_counter() - begin, int(step),
    )  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path("build/policies"))
    parser.add_argument("--seeds", type=int, nargs="*", default=[1, 2, 3])
    parser.add_argument("--minutes", type=float, default=22.0, help="for each seed")
    parser.add_argument("--steps", type=int, default=100_000_000)
    parser.add_argument("--arenas", type=int, default=8192)
    given = parser.parse_args()
    for seed in given.seeds:
        trained(seed, given.minutes, given.steps, given.arenas).save(given.out / f"policy_{seed}.npz")


if __name__ == "__main__":
    main()
