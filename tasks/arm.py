"""A two-link arm in a horizontal plane, for tasks/arm.toml: M(q) qdd + C(q, qd) qd + D qd = torque + disturbance.

Each link has 2 kg and 0.5 m; the hand holds 0 to 0.3 kg, nobody knows how much. The board multiplies u by the inertia of an arm
with 0.12 kg, at the joints of the sample: torque = Mhat(q) u. So u are accelerations of the joints.
"""

import casadi as ca

MASS, LENGTH, FRICTION = 2.0, 0.5, 0.1  # kg, m, N m s
PAYLOAD = 0.12  # kg, in Mhat

p = [(0.0, 0.3)]  # kg in the hand
w_max = 0.2  # rad/s^2, what torques that nobody modelled accelerate


def parts(payload):
    """a, b, d of M = [[a + 2 b c, d + b c], [d + b c, d]], c = cos(q2); kg m^2."""
    first = MASS * LENGTH**2 * (1 / 3 + 1) + payload * LENGTH**2  # a - d
    b = (MASS / 2 + payload) * LENGTH**2
    d = (MASS / 3 + payload) * LENGTH**2
    return first + d, b, d


def inverse(q, payload):
    """M(q)^-1. Its determinant is (a - d) d - b^2 c^2, in which what cancels is left out: so it is enclosed well."""
    a, b, d = parts(payload)
    c = b * ca.cos(q[1])
    return ca.vertcat(ca.horzcat(d, -(d + c)), ca.horzcat(-(d + c), a + 2 * c)) / ((a - d) * d - c**2)


def f(x, v, p):
    s = parts(p[0])[1] * ca.sin(x[1])
    coriolis = ca.vertcat(-s * v[1] * (2 * v[0] + v[1]), s * v[0] ** 2)
    return inverse(x, p[0]) @ -(coriolis + FRICTION * v)


def g(x, v, p):
    return inverse(x, p[0])


def mix(x):
    a, b, d = parts(PAYLOAD)
    c = b * ca.cos(x[1])
    return ca.vertcat(ca.horzcat(a + 2 * c, d + c), ca.horzcat(d + c, d))
