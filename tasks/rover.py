"""A rover with two driven wheels, for tasks/rover.toml: what is steered is a point AHEAD of the axle, which goes any way at once.

With the heading h the point moves at R(h) diag(1, AHEAD) (speed, turning rate). The board turns the velocity u that it wants of
the point into both, by the heading of the sample: (speed, turning rate) = diag(1, 1/AHEAD) R(-h) u. Until the next sample the
rover has turned by an angle that nobody tells the controller: p. It is at most the turning rate times the greatest age of a
sample, and the turning rate at most sqrt(2) U_MAX / AHEAD, where |u_i| <= U_MAX. The heading itself is free.
"""

import casadi as ca

AHEAD = 0.25  # m
U_MAX, AGE = 0.8, 0.022  # m/s, s: control.u_max; control.period and control.latency
TURNED = 2**0.5 * U_MAX / AHEAD * AGE  # rad

p = [(-TURNED, TURNED)]
w_max = 0.1  # m/s, slip


def f(x, p):
    return [0, 0]


def g(x, p):
    c, s = ca.cos(p[0]), ca.sin(p[0])
    return [[c, -s], [s, c]]
