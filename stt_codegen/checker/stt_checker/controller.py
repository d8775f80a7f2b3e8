"""Which controller in floating point a task and its tube ask for: the options and the numbers of its listings."""

import math
from fractions import Fraction
from typing import Any

from .exact import require, require_in_range, rounded
from .inertia import filtered_tube
from .law import Law
from .limits import emitted_limits
from .tube import Tube

IEEE = {  # bytes of a number, an unsigned word of that size, the bits of 1/sqrt 2, the exponent's place, the fraction's mask
    "float": (4, "uint32_t", "0x3f3504f3U", 23, "0x7fffffU"),
    "double": (8, "uint64_t", "0x3fe6a09e667f3bcdU", 52, "0xfffffffffffffU"),
}
NARROWEST = Fraction(1, 1 << 20)  # of a width that `transform` divides by
BEND, LN_2 = Fraction("0.67660441"), Fraction("0.693147180559945309417232121458")  # of the logarithm; the first always as a float


def options_of(task: Any, law: Law, has_phase: bool) -> set[str]:
    """Return the words that lines of the listings may ask for."""
    limited = "no limits" if task.u_max is None else "scaled" if task.scales else "limits"
    options = {law.scalar, f"order {task.order}", limited, "inline" if task.inline else "libm"}
    if limited == "scaled":
        options.add("no limits")
    for values, equal, different in (
        (law.gain, "one gain", "gains"), (task.e_max, "one clamp", "clamps"), (law.filters, "one filter", "filters"),
    ):  # fmt: skip
        options.add(equal if len({*values}) == 1 else different)
    stated = {"ticks": task.tick, "period": task.period, "differences": task.differs, "repeats": task.repeats, "phase": has_phase}
    stated |= {"selftest": task.selftest, "hold": task.outside == "hold", "stop": task.outside == "stop", "closed": task.turns}
    return options | {name for name, value in stated.items() if value}


def check_products(task: Any, tube: Tube, law: Law) -> None:
    """Require that products stay in range: of the gain and xi, from 4/W to 2/(W share) where the tube that the law is about is W
    wide; of an edge and lambda; of a slope and the segments in a second. Other factors, weights and epsilon, are small."""
    edges, unit = (filtered_tube(task, tube, law.filters)[0], Fraction(1)) if task.order == 2 else (tube.pieces, tube.unit)
    largest = 6 * max(abs(v) for row in tube.table for pair in row for v in pair) * tube.unit
    require_in_range(largest * tube.segments / task.t_c, *(largest * s for s in law.filters))
    for i, (gain, e_max) in enumerate(zip(law.gain, task.e_max, strict=True)):
        is_apart = min((1 - e_max) / 8, e_max / 4096) >= Fraction(1, 1 << law.bits)
        require(is_apart, "e_max is too near 0 or 1 for the scalar")
        widths = [(h - v) * unit for piece in edges for v, h in zip(*piece[i], strict=True)]
        require_in_range(gain * 4 / max(widths), gain * 4 / (min(widths) * (1 - e_max)))


def values_of(task: Any, tube: Tube, law: Law, starts: dict[str, list[Fraction]]) -> dict[str, Any]:
    """Return the numbers and words of the listings by name, as the scalar has them. starts: the tables of `covered`."""
    scalar, bits, n, k, t_c = law.scalar, law.bits, task.n, tube.segments, task.t_c
    check_products(task, tube, law)

    def nearest(values: list[Fraction]) -> list[Fraction]:
        return [rounded(v, bits) for v in values]

    size, word, cut, places, mask = IEEE[scalar]
    entries = [v * tube.unit for row in tube.table for pair in row for v in pair]
    values: dict[str, Any] = {
        "scalar": scalar, "n": n, "pairs": 2 * n, "entries": len(entries), "coefficients": entries,
        **{f"row_{j}": 2 * n * j for j in (1, 2, 3)},
        "t_c": rounded(t_c, bits), "per_second": rounded(k / t_c, bits),
        "last": rounded(k - Fraction(k, 2 ** (bits + 2)), bits, math.floor), "share": rounded(task.start_share, bits, math.floor),
        "narrowest": NARROWEST, "bytes": size, "word": word, "cut": cut, "places": places, "mask": mask,
        "log": "logf" if scalar == "float" else "log", "bend": rounded(BEND, 24), "ln_2": rounded(LN_2, bits), **starts,
    }  # fmt: skip
    tables = {"gain": law.gain, "e_max": task.e_max, "smallest_share": [(1 - v) / 2 for v in task.e_max], "filter": law.filters}
    for name, numbers in tables.items():
        if numbers:
            entries = nearest(numbers)
            values |= {f"{name}_table": entries, name: entries[0], f"{name}_minus": -entries[0]}
    if task.u_max is not None:
        limit = emitted_limits(task, bits)
        values |= {"u_max_table": limit, "limit": limit[0], "limit_minus": -limit[0]}
    if task.turns:
        values["closed"] = list(task.turns.periods)
        for i, turn in task.turns.periods.items():
            values |= {f"axis_{i}": i, f"number_{i}": i + 1, f"turn_{i}": rounded(turn, bits)}
    if task.tick is not None:  # a tick is num/den of a segment
        num, den = (task.tick * k / t_c).as_integer_ratio()
        require(k * den + num < 1 << 31, "the ticks of the C do not fit 31 bits")
        values |= {"ticks": -(-t_c // task.tick), "tick_num": num, "tick_den": den, "tick_end": k * den, "last_segment": k - 1}
        values |= {"tick_real": rounded(Fraction(den), bits), "tick_period": rounded(task.tick, bits)}
    if tube.seam is not None:
        cycle = tube.cycle / (task.tick or tube.cycle)
        require(cycle.denominator == 1, "a cycle is no whole number of ticks")
        values |= {"cycle": rounded(tube.cycle, bits), "cycle_ticks": cycle.numerator}
    if task.period is not None:
        values["period"] = rounded(task.period, bits, math.floor)
    if task.shortest is not None:
        values["shortest"] = rounded(task.shortest, bits, math.ceil)
    return values
