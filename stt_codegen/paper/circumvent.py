"""Section III-B: circumvent functions (7)-(9).

B is the height, k the steepness, m the middle and r the radius of the bump:

    bump(t) = B exp(-k (t - m)^2 / (r^2 - (t - m)^2)) for |t - m| < r, and 0 elsewhere;  all derivatives vanish at +-r.

In the paper the window of a bump is exactly the conflict. The bump is 0 at both ends of it, so the window must be wider.
r^2 - (t - m)^2 is computed as (r - |t - m|)(r + |t - m|) with the floor k (t - m)^2 cut, where cut = 1/104 (float) or 1/746
(double). So the exponent never falls below -104 (-746), where the exponential is 0: inside near the edges, and everywhere
outside. No branch avoids a division by zero, since r^2 alone remains where t = m. The lemmas `bumps.*` prove this.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction

import casadi as ca

from stt_codegen.paper.smooth import smooth_join

CUT = {
    "float": Fraction(1, 104),
    "double": Fraction(1, 746),
}  # exp(-104) is 0 in binary32, exp(-746) in binary64; exp(-745) is not


def bump(t: ca.SX, parameters: Sequence[ca.SX]) -> ca.SX:
    """Return the height of one circumvent function above its rest level X_i, by (7) and (8); parameters: B, k, m, r and cut."""
    height, steepness, middle, radius, cut = parameters
    d = t - middle
    rest = (radius - ca.fabs(d)) * (radius + ca.fabs(d))
    rise = steepness * (d * d)
    return height * ca.exp(-rise / ca.fmax(rest, rise * cut))


def circumvent(rate: bool = False) -> ca.Function:
    """t, B, k, m, r, cut -> bump; with `rate` also its derivative in t, by differentiation."""
    names = ["t", "height", "steepness", "middle", "radius", "cut"]
    t, *shape = symbols = [ca.SX.sym(name) for name in names]
    value = bump(t, shape)
    if not rate:
        return ca.Function("circumvent", symbols, [value], names, ["bump"])
    return ca.Function("circumvent_rate", symbols, [value, ca.jacobian(value, t)], names, ["bump", "bump_rate"])


def join(rate: bool = False) -> ca.Function:
    """Two bumps (or joined bumps), nu -> their smooth joining in place of (9)'s max; with `rate`, rates to rate too."""
    a, b, da, db, nu = (ca.SX.sym(name) for name in ("a", "b", "da", "db", "nu"))
    value = smooth_join(a, b, nu)
    if not rate:
        return ca.Function("join", [a, b, nu], [value], ["a", "b", "nu"], ["joined"])
    slope = ca.jtimes(value, ca.vertcat(a, b), ca.vertcat(da, db))
    return ca.Function("join_rate", [a, b, da, db, nu], [value, slope], ["a", "b", "da", "db", "nu"], ["joined", "joined_rate"])
