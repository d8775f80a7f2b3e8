"""An omnidirectional base with mass, for tasks/base.toml: x, y and the heading, forces and a torque in its own frame.

It weighs 20 to 26 kg, with its load, and its inertia is 1.0 to 1.3 kg m^2. The board turns u into the frame of the heading that
it saw, and multiplies by what a base in the middle weighs: forces = M R(-heading) u. So u are accelerations.
"""

import casadi as ca

MASS, INERTIA = 23.0, 1.15  # kg, kg m^2, of the board
FRICTION = (4.0, 0.3)  # N s/m, N m s

p = [(20.0, 26.0), (1.0, 1.3)]  # mass and inertia
w_max = 0.15  # m/s^2: slip, slopes, cables


def turned(heading):
    c, s = ca.cos(heading), ca.sin(heading)
    return ca.vertcat(ca.horzcat(c, -s, 0), ca.horzcat(s, c, 0), ca.horzcat(0, 0, 1))


def f(x, v, p):
    return [-FRICTION[0] / p[0] * v[0], -FRICTION[0] / p[0] * v[1], -FRICTION[1] / p[1] * v[2]]


def g(x, v, p):
    return turned(x[2]) @ ca.diag(ca.vertcat(1 / p[0], 1 / p[0], 1 / p[1]))


def mix(x):
    return ca.diag(ca.vertcat(MASS, MASS, INERTIA)) @ turned(x[2]).T
