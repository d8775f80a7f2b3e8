"""Whether the worst path proves a loop for a sampling period, an input delay and a drive, and which |e| and |u| follow.

`prove_path` looks for the smallest E by component for which the theorem of docs/sampling-path.md holds: first with the bounds
of the whole time, then window by window. A bound U on |u| rises with E, and the E that a path needs rises with U; so E starts
at that of the starts and is raised until it is enough for every path, in all components at once. Every number of the final
proof is stated in the certificate, or follows from the task and its tube, so a checker follows the same paths.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

from stt_codegen.decimals import above
from stt_codegen.effort import require_effort
from stt_codegen.sampling.path.path_windows import PathLoop
from stt_codegen.sampling.path.worst_path import PathBounds, WorstPath, follow_worst_path

ROUND_LIMIT = 16  # of raising E
FIRST_RAISE = Fraction(1, 1 << 20)  # relative, of rho above what the paths need; it doubles from round to round
RHO_DIGITS = 9
HISTORY_ROUND_LIMIT = 8  # of raising A
HISTORY_RAISE = Fraction(1, 16)  # relative
HISTORY_UNIT = Fraction(1, 1024)  # seconds


@dataclass(frozen=True)
class ComponentPath:
    """The paths of one component: the rho that all of them prove at least, Q_pk of the one that comes nearest, and A.

    history: A in seconds; None where one path from the start has the bounds of the whole time. cells: of all paths.
    """

    rho: Fraction
    nearest: Fraction
    history: Fraction | None
    cells: int


@dataclass(frozen=True)
class PathProof:
    """What the worst path proves, by component: |e| < (rho - 1)/(rho + 1) and |u| <= u; `paths` has the paths themselves."""

    rho: tuple[Fraction, ...]
    u: tuple[Fraction, ...]
    paths: tuple[ComponentPath, ...]


def prove_path(loop: PathLoop) -> PathProof | None:
    """Prove that the loop stays in its tube, with the smallest rho that the search finds; None where no path does."""
    require_effort()
    if not loop.has_known_start:
        return None
    proof = _search(loop, is_local=False)
    return _search(loop, is_local=True) if proof is None and loop.has_windows else proof


def prove_path_for(loop: PathLoop, rho: Sequence[Fraction]) -> PathProof | None:
    """Prove that the loop stays in its tube with these rho by component; None where no path does."""
    if not loop.has_known_start:
        return None
    for is_local in (False, True):
        proof = _follow(loop, rho, is_local)
        if proof is not None and _is_enough(proof):
            return proof
    return None


def _search(loop: PathLoop, is_local: bool) -> PathProof | None:
    """Raise rho until the paths of all components prove it."""
    rho, proof = [_decimal_above(law.rho_at_start * (1 + FIRST_RAISE)) for law in loop.laws], None
    for k in range(ROUND_LIMIT):
        proof = _follow(loop, rho, is_local, proof)
        if proof is None or _is_enough(proof):
            return proof
        raised = 1 + FIRST_RAISE * 2**k
        rho = [max(v, _decimal_above(path.rho * raised)) for path, v in zip(proof.paths, rho, strict=True)]
    return None


def _follow(loop: PathLoop, rho: Sequence[Fraction], is_local: bool, earlier: PathProof | None = None) -> PathProof | None:
    """Follow the paths of all components, with U for these rho; None where a path meets the edge, or nothing bounds an input.

    earlier: paths of the same loop for another rho, which are the same where U is.
    """
    bounds = [loop.input_bound(i, ratio) for i, ratio in enumerate(rho)]
    inputs = [Fraction(str(above(bound))) for bound in bounds if bound is not None]
    if len(inputs) < loop.n:
        return None
    if earlier is not None and earlier.u == tuple(inputs):
        return replace(earlier, rho=tuple(rho))
    paths = []
    for i in range(loop.n):
        path = (follow_local_paths(loop, i, inputs) if is_local else None) or follow_from_start(loop, i, inputs)
        if path is None:
            return None
        paths.append(path)
    return PathProof(tuple(rho), tuple(inputs), tuple(paths))


def _is_enough(proof: PathProof) -> bool:
    return all(path.rho < v for path, v in zip(proof.paths, proof.rho, strict=True))


def _decimal_above(value: Fraction) -> Fraction:
    return Fraction(str(above(value, RHO_DIGITS)))


def follow_from_start(loop: PathLoop, i: int, inputs: Sequence[Fraction], last: int | None = None) -> ComponentPath | None:
    """Follow the path of component i from its start, with the bounds of all windows up to `last`; None where it meets the edge.

    inputs: a bound on each |u_j|.
    """
    bounds = loop.bounds_over(i, 0, len(loop.begins) - 1 if last is None else last, inputs)
    path = follow_worst_path(bounds, loop.start(i))
    rho = path.rho(bounds.wide)
    return None if rho is None else ComponentPath(rho, path.nearest, None, path.cells)


def follow_local_paths(loop: PathLoop, i: int, inputs: Sequence[Fraction]) -> ComponentPath | None:
    """Follow the paths of component i, for every window with the bounds of the last A seconds, and one for the windows before A.

    A starts at the delay of the sample and the drive and is raised until no path needs more. None where a path meets the edge,
    or no A fits.
    """
    history = loop.age + loop.drives[i].delay(inputs[i])
    for _ in range(HISTORY_ROUND_LIMIT):
        history = -(-history // HISTORY_UNIT) * HISTORY_UNIT
        if history > loop.begins[-1]:
            return None
        first_local = next(k for k, begin in enumerate(loop.begins) if begin >= history)
        needed, paths = Fraction(0), []
        for bounds, path in _uncovered_paths(loop, i, inputs, first_local, history):
            rho = path.rho(bounds.wide)
            if rho is None or path.history is None:
                return None
            needed = max(needed, path.history)
            paths.append(ComponentPath(rho, path.nearest, history, path.cells))
        if needed <= history:
            from_start = follow_from_start(loop, i, inputs, first_local - 1)
            return None if from_start is None else _together([from_start, *paths], history)
        history = needed * (1 + HISTORY_RAISE)
    return None


def _uncovered_paths(
    loop: PathLoop, i: int, inputs: Sequence[Fraction], first_local: int, history: Fraction
) -> Iterator[tuple[PathBounds, WorstPath]]:
    """Yield the paths of the windows from `first_local` on, but for windows whose bounds those of another window cover.

    A window whose speed is large for its width comes first, since it is the most likely to fail.
    """
    candidates = [
        loop.bounds_over(i, loop.window_at(loop.begins[k] - history), k, inputs) for k in range(first_local, len(loop.begins))
    ]
    candidates.sort(key=lambda b: (b.closing_speed + b.g_max * b.input_bound) / b.narrow, reverse=True)
    followed: list[PathBounds] = []
    for bounds in candidates:
        if not any(other_bounds.covers(bounds) for other_bounds in followed):
            followed.append(bounds)
            yield bounds, follow_worst_path(bounds)


def _together(paths: Sequence[ComponentPath], history: Fraction) -> ComponentPath:
    """Return the worst of the paths of a component."""
    return ComponentPath(max(p.rho for p in paths), min(p.nearest for p in paths), history, sum(p.cells for p in paths))
