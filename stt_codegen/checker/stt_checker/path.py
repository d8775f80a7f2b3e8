"""P9 where inputs act late: by latency, lags, a limited rate or an overshoot. docs/sampling-path.md has the theorem and the rules
by which a path is followed. It falls at least as fast as any run may, so where it turns round no run comes nearer to the edge."""

import math
from fractions import Fraction
from typing import Any

from .exact import logarithm, require


def power(value: Fraction) -> Fraction:
    """Return the largest power of two that is at most the value."""
    exponent = value.numerator.bit_length() - value.denominator.bit_length()
    return Fraction(2) ** (exponent - (Fraction(2) ** exponent > value))


def follow(b: Any, start: Fraction | None, first: Fraction) -> tuple[Fraction, Fraction]:
    """Return the last distance to the edge, 0 where the path meets it, and how much history the bounds must hold for. start: the
    least distance of a start, from where on the first input acts `first` later; None for bounds of recent windows alone."""
    longest = (b.age + sum(b.lags) + (2 * b.u / b.slew if b.slew else 0)) / 96
    longest = max(longest, b.narrow / (b.speed + b.g_max * b.u) / 512)
    h = longest // (power(longest) / 4) * power(longest) / 4
    length, unit = power(b.wide) / (1 << 47), power(b.u) / (1 << 47)
    narrow, shift, largest = math.floor(b.narrow / length), math.ceil(b.shift / length), math.ceil(b.u / unit)
    decays = [math.ceil((1 << 48) / sum((h / lag) ** j / math.factorial(j) for j in range(8))) for lag in b.lags]
    slew_step, age_cells = math.floor((b.slew or 0) * h / unit), math.ceil(b.age / h)
    newer, begin = math.floor((age_cells - b.age / h) * (1 << 48)), math.floor((start or 0) / length)

    def law(far: Any, near: Any) -> int:
        log = (logarithm(Fraction(far) / near)[0] if far >= near else -logarithm(Fraction(near) / far)[1]) - b.rounding
        gain = b.gain * (1 - b.rounding if log > 0 else 1 + b.rounding)
        return math.ceil(-gain * (Fraction(1, far) + Fraction(1, near)) * log / length / unit)

    clamp = (b.wide + 2 * b.shift) / 2 / length
    weakest = max(law(clamp * (1 + b.e_max), clamp * (1 - b.e_max)), -math.floor(b.limit / unit))

    def psi(level: int) -> int:
        near = level + shift
        return largest if near >= narrow else min(max(law(narrow - near, near), weakest), largest)

    def acts(state: list[int], c: int) -> int:
        return (y := state[-1] if decays else max(c, state[0]) if b.slew else c) + math.ceil(b.nu * max(y + largest, 0))

    def a_cell_later(state: list[int], c: int) -> list[int]:
        inputs = [max(c, state[0]) if b.slew else c, *state[1:]][: len(decays)]
        stages = [x - (x - v) * q // (1 << 48) for x, v, q in zip(inputs, state[1:], decays, strict=True)]
        return [max(c, state[0] - slew_step), *stages]

    def at_edge(y: int) -> Fraction:
        return h * (b.speed + (b.g_max if y > 0 else b.g_min) * y * unit) / length

    level, state, clipped, started = math.ceil(b.wide / length), [largest] * (1 + len(decays)), 0, start is None
    while level * 7 // 8 > begin and psi(level * 7 // 8) == largest:
        level = level * 7 // 8
    levels, smallest_before = [level], h * (b.speed + b.g_max * b.u) / 16 / length
    while level > 0 and len(levels) < 1 << 14 and h * b.filter_rate < 1:
        older, after = levels[max(len(levels) - 1 - age_cells, 0)], levels[-age_cells if len(levels) > age_cells else 0]
        c = psi(older - (older - after) * newer // (1 << 48)) if len(levels) > age_cells else largest
        if not started and level <= begin:
            started, clipped = True, math.ceil(first / h)
        if not started or clipped > 0:
            c, clipped = max(c, 0), clipped - 1
        falls = at_edge(acts(state, c)) - h * b.filter_rate * level
        if started and (falls if start is not None else at_edge(acts(state, c))) < 0:
            cells, forgetting = len(levels) + age_cells + 1, [largest] * (1 + len(decays))
            while start is None and at_edge(acts(forgetting, psi(level))) >= 0 and cells < 1 << 15:
                cells, forgetting = cells + 1, a_cell_later(forgetting, psi(level))
            return level * length, cells * h
        level -= math.ceil(max(falls / (1 - h * b.filter_rate), h * b.speed / 64 / length, 0 if started else smallest_before))
        levels, state = [*levels, level], a_cell_later(state, c)
    return Fraction(0), Fraction(0)


def prove(b: Any, rows: list[Any], begins: list[Fraction], start: tuple[Fraction, Fraction], claim: Any) -> None:
    """Prove (3) of one component: that no path comes nearer than W+/(1 + rho), nor than is claimed. b: all that windows share,
    with `rho`. rows: P, the least and the largest width of every window, and when it begins. claim: the certificate's path."""
    nearest, history = claim

    def over(first: int, last: int) -> tuple[Fraction, ...]:
        speeds, narrow, wide = zip(*rows[first : last + 1], strict=True)
        return max(speeds), min(narrow), max(wide)

    recent = [] if history is None else [k for k, begin in enumerate(begins) if begin >= history]
    bounds = {over(max(j for j, begin in enumerate(begins) if begin <= begins[k] - (history or 0)), k) for k in recent}
    covered = {v for v in bounds for w in bounds if v != w and w[0] >= v[0] and w[1] <= v[1] and w[2] >= v[2]}
    paths = [(over(0, recent[0] - 1 if recent else len(rows) - 1), start[0]), *((v, None) for v in bounds - covered)]
    for (b.speed, b.narrow, b.wide), level in paths:
        distance, needed = follow(b, level, start[1])
        is_proved = distance * (1 + b.rho) > b.wide and distance >= nearest and (level is not None or needed <= (history or 0))
        require(is_proved, f"P9 does not hold: a path comes too near to an edge, or needs more history ({b.name})")
