"""Train the reinforcement learning peer of `python -m benchmarks loop --peers`: PPO of brax, on the processor.

    python -m benchmarks policy --out build/policies        (make policies)

One policy is for all arenas of the paper's kind, and is trained on others than those of the benchmark. Each episode draws a
disturbance of at most W_MAX: none, constant, sinusoidal, random, or toward the nearest square. The reward is the progress along
the shortest path around the unsafe squares (which the policy does not observe), plus 10 in the target at t_c, minus 10 in a
square or outside of the state space, which ends the episode. One episode in three begins anywhere.
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

from benchmarks.peers.policy import DECISIONS_PER_SECOND, FAMILY, OBSERVATION_SIZE, SPEED, Policy, observe
from benchmarks.suites.families import BOX, cubes, is_feasible

FIRST_SEED = 100_000  # seeds of the arenas that are trained on; the benchmark has 0 to 499
GRID_POINTS = 51  # points of the map of path lengths along one axis
CAUTION_DISTANCE = 0.08  # points nearer to a square than this cost CAUTION_COST times as much
CAUTION_COST = 6.0
W_MAX = 0.3
SUBSTEPS = 5  # states between two decisions at which collisions are checked
T_C = FAMILY.prescribed_time
EPISODE_STEPS = round(T_C * DECISIONS_PER_SECOND)
HIDDEN = (128, 128)


def path_lengths(boxes: np.ndarray) -> np.ndarray:
    """Return the length of the shortest path to the target's middle from every grid point, (GRID_POINTS, GRID_POINTS)."""
    axis = np.linspace(0, FAMILY.side, GRID_POINTS)
    points = np.stack(np.meshgrid(axis, axis, indexing="ij"), axis=-1)
    near = np.zeros((GRID_POINTS, GRID_POINTS), dtype=bool)
    for box in boxes:
        near |= np.all((box[:, 0] - CAUTION_DISTANCE < points) & (points < box[:, 1] + CAUTION_DISTANCE), axis=-1)
    cost, index = np.where(near, CAUTION_COST, 1.0), np.arange(GRID_POINTS * GRID_POINTS).reshape(GRID_POINTS, GRID_POINTS)
    rows, columns, lengths = [], [], []
    for di, dj in ((0, 1), (1, 0), (1, 1), (1, -1)):
        cells = (slice(0, GRID_POINTS - di), slice(max(0, -dj), GRID_POINTS - max(0, dj)))
        neighbours = (slice(di, GRID_POINTS), slice(max(0, dj), GRID_POINTS - max(0, -dj)))
        rows.append(index[cells].ravel())
        columns.append(index[neighbours].ravel())
        lengths.append((np.hypot(di, dj) * axis[1] * np.maximum(cost[cells], cost[neighbours])).ravel())
    graph = coo_matrix(
        (np.concatenate(lengths), (np.concatenate(rows), np.concatenate(columns))), shape=(GRID_POINTS * GRID_POINTS,) * 2
    )
    goal = int(index[(round((FAMILY.side - BOX / 2) / axis[1]),) * 2])
    return np.asarray(dijkstra(graph.tocsr(), directed=False, indices=goal)).reshape(GRID_POINTS, GRID_POINTS)


def draw_arenas(count: int, first: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the squares of `count` feasible arenas from the seed `first` on, and their maps of path lengths."""
    seeds, seed = [], first
    while len(seeds) < count:
        if is_feasible(FAMILY, seed, 0.05):
            seeds.append(seed)
        seed += 1
    squares = [cubes(FAMILY, s) for s in seeds]
    return np.array(squares, dtype=np.float32), np.array([path_lengths(b) for b in squares], dtype=np.float32)


class ArenaEnvironment(Env):
    """Brax's environment of xdot = u + w in a random arena. arenas: squares and maps of `draw_arenas`."""

    def __init__(self, arenas: tuple[np.ndarray, np.ndarray]) -> None:
        self.boxes, self.maps = jnp.asarray(arenas[0]), jnp.asarray(arenas[1])

    observation_size = OBSERVATION_SIZE
    action_size = 2
    backend = "none"

    def reset(self, rng: Any) -> State:
        """Begin an episode: draw an arena, a start and a disturbance."""
        arena_key, start_key, anywhere_key, kind_key, wind_shape_key, episode_key = jax.random.split(rng, 6)
        arena = jax.random.randint(arena_key, (), 0, len(self.boxes))
        boxes = self.boxes[arena]
        candidates = jax.random.uniform(anywhere_key, (8, 2)) * FAMILY.side  # the first of these in no square is taken
        free = jnp.all(distances(candidates[:, None], boxes[None]) > 0.02, axis=-1)
        start = jax.random.uniform(start_key, (2,)) * BOX
        begins_anywhere = (jax.random.uniform(start_key) < 1 / 3) & jnp.any(free)
        x = jnp.where(begins_anywhere, candidates[jnp.argmax(free)], start)
        angle, speed, size = jax.random.uniform(wind_shape_key, (3,))
        state = {
            "x": x,
            "t": jnp.zeros(()),
            "arena": arena,
            "kind": jax.random.randint(kind_key, (), 0, 6),
            "angle": 2 * jnp.pi * angle,
            "turn": 0.5 + 19.5 * speed,
            "size": W_MAX * jnp.minimum(1.0, 0.3 + 1.4 * size),
            "rng": episode_key,
        }
        zero = jnp.zeros(())
        return State(state, observe(jnp, x, zero, boxes), zero, zero, {"reached": zero, "hit": zero})

    def step(self, state: State, action: Any) -> State:
        """Advance by one decision of the policy, in SUBSTEPS parts."""
        s = dict(state.pipeline_state)
        boxes, x, u = self.boxes[s["arena"]], s["x"], SPEED * jnp.clip(action, -1, 1)
        s["rng"], wind_key = jax.random.split(s["rng"])
        hit, before = jnp.zeros((), bool), self.remaining_length(s["arena"], x)
        for k in range(SUBSTEPS):
            t = s["t"] + k / (DECISIONS_PER_SECOND * SUBSTEPS)
            x = x + (u + self.disturbance(s, x, t, boxes, wind_key)) / (DECISIONS_PER_SECOND * SUBSTEPS)
            hit |= jnp.any(distances(x, boxes) <= 0) | jnp.any((x < 0) | (x > FAMILY.side))
        s["x"], s["t"] = x, s["t"] + 1 / DECISIONS_PER_SECOND
        is_over = s["t"] >= T_C - 0.5 / DECISIONS_PER_SECOND
        reached = is_over & ~hit & jnp.all(x >= FAMILY.side - BOX)
        reward = before - self.remaining_length(s["arena"], x) + 10.0 * reached - 10.0 * hit
        done = (hit | is_over).astype(jnp.float32)
        metrics = {"reached": reached.astype(jnp.float32), "hit": hit.astype(jnp.float32)}
        return state.replace(
            pipeline_state=s, obs=observe(jnp, x, s["t"], boxes), reward=reward, done=done, metrics={**state.metrics, **metrics}
        )

    def disturbance(self, s: dict[str, Any], x: Any, t: Any, boxes: Any, wind_key: Any) -> Any:
        """Return w, (2,), of the episode's kind: the sixth kind is the fifth again."""
        along = jnp.array([jnp.cos(s["angle"]), jnp.sin(s["angle"])])
        random_angle = 2 * jnp.pi * jax.random.uniform(wind_key)
        nearest = jnp.argmin(distances(x, boxes))
        point = jnp.clip(x, boxes[nearest, :, 0], boxes[nearest, :, 1]) - x
        toward = point / jnp.maximum(jnp.linalg.norm(point), 1e-6)
        random_direction = jnp.stack([jnp.cos(random_angle), jnp.sin(random_angle)])
        kinds = jnp.stack([jnp.zeros(2), along, along * jnp.sin(s["turn"] * t), random_direction, toward, toward])
        return s["size"] * kinds[s["kind"]]

    def remaining_length(self, arena: Any, x: Any) -> Any:
        """Return the length of the shortest path from x, interpolated in the arena's map."""
        at = jnp.clip(x / FAMILY.side, 0, 1) * (GRID_POINTS - 1)
        low = jnp.minimum(at.astype(int), GRID_POINTS - 2)
        (a, b), m = at - low, self.maps[arena]
        i, j = low
        return (1 - a) * ((1 - b) * m[i, j] + b * m[i, j + 1]) + a * ((1 - b) * m[i + 1, j] + b * m[i + 1, j + 1])


def distances(x: Any, boxes: Any) -> Any:
    """Return the distance of x from each square, in the largest component; it is negative inside."""
    return jnp.max(jnp.maximum(boxes[..., 0] - x[..., None, :] if x.ndim == 1 else boxes[..., 0] - x,
                               x - boxes[..., 1]), axis=-1)  # fmt: skip


class NewArenaWrapper(Wrapper):
    """Begin each episode in a new arena: brax's wrapper would repeat the first one."""

    def reset(self, rng: Any) -> State:
        state = self.env.reset(rng)
        state.info["next"] = jax.vmap(partial(jax.random.fold_in, data=1))(rng)
        return state

    def step(self, state: State, action: Any) -> State:
        """Advance all environments, and replace those whose episode is over by new ones."""
        steps = jnp.where(state.done, 0, state.info["steps"])
        state.info.update(steps=steps)
        state = self.env.step(state.replace(done=jnp.zeros_like(state.done)), action)
        keys = jax.vmap(jax.random.split)(state.info["next"])
        fresh = self.env.reset(keys[:, 0])

        def replace_finished(new: Any, old: Any) -> Any:
            return jnp.where(state.done.reshape(state.done.shape + (1,) * (old.ndim - 1)).astype(bool), new, old)

        state.info["next"] = keys[:, 1]
        pipeline_state = jax.tree.map(replace_finished, fresh.pipeline_state, state.pipeline_state)
        return state.replace(pipeline_state=pipeline_state, obs=replace_finished(fresh.obs, state.obs))


def wrap_environment(env: Env, episode_length: int, action_repeat: int, randomization_fn: Any = None) -> Env:  # noqa: ARG001 (brax names it)
    return NewArenaWrapper(EpisodeWrapper(VmapWrapper(env), episode_length, action_repeat))


def train_policy(seed: int, minutes: float, steps: int, arenas: int) -> Policy:
    """Train one policy. minutes: training ends at the first evaluation after them. steps: at most. arenas: how many are drawn."""
    training_arenas = draw_arenas(arenas, FIRST_SEED + 1_000_000 * seed)
    begin, latest = time.perf_counter(), []

    class TimeIsOver(Exception):
        pass

    def progress(step: int, metrics: Any) -> None:
        elapsed = (time.perf_counter() - begin) / 60
        shares = {k: float(metrics[f"eval/episode_{k}"]) for k in ("reward", "reached", "hit") if f"eval/episode_{k}" in metrics}
        print(f"seed {seed}: {elapsed:5.1f} min, {step:>10} steps, {shares}", flush=True)

    def keep(step: int, _make: Any, params: Any) -> None:
        latest[:] = [(step, params)]
        if time.perf_counter() - begin > 60 * minutes:
            raise TimeIsOver

    factory = partial(networks.make_ppo_networks, policy_hidden_layer_sizes=HIDDEN, value_hidden_layer_sizes=HIDDEN)
    with contextlib.suppress(TimeIsOver):
        train.train(
            environment=ArenaEnvironment(training_arenas), num_timesteps=steps, episode_length=EPISODE_STEPS, num_envs=512,
            unroll_length=30, batch_size=256, num_minibatches=16, num_updates_per_batch=3, learning_rate=3e-4, entropy_cost=3e-3,
            discounting=0.995, gae_lambda=0.95, clipping_epsilon=0.2, normalize_observations=True, reward_scaling=0.3,
            max_grad_norm=0.5, wrap_env_fn=wrap_environment, network_factory=factory, seed=seed, num_evals=200,
            num_eval_envs=256, deterministic_eval=True, progress_fn=progress, policy_params_fn=keep,
        )  # fmt: skip
    step, (normal, policy, *_) = latest[-1]
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
    options = parser.parse_args()
    for seed in options.seeds:
        train_policy(seed, options.minutes, options.steps, options.arenas).save(options.out / f"policy_{seed}.npz")


if __name__ == "__main__":
    main()
