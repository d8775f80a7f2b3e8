"""The attitude of a rigid spacecraft, for tasks/attitude.toml: roll, pitch, yaw, torques as inputs.

Its inertia is known to 5 % about each principal axis. The board makes torques of u at the angles of the sample: torque = J T u,
where rates of angles v are body rates T v. So u are accelerations of the angles.
"""

import casadi as ca

INERTIA = (1.2, 1.0, 0.8)  # kg m^2

p = [(0.95, 1.05)] * 3  # what the inertia is of what the board takes it for
w_max = 0.01  # rad/s^2, drag, solar pressure, fuel that moves


def rates(x):
    """T: body rates of rates of angles."""
    sr, cr, sp, cp = ca.sin(x[0]), ca.cos(x[0]), ca.sin(x[1]), ca.cos(x[1])
    return ca.vertcat(ca.horzcat(1, 0, -sp), ca.horzcat(0, cr, sr * cp), ca.horzcat(0, -sr, cr * cp))


def angles(x):
    """T^-1."""
    sr, cr, tp, cp = ca.sin(x[0]), ca.cos(x[0]), ca.tan(x[1]), ca.cos(x[1])
    return ca.vertcat(ca.horzcat(1, sr * tp, cr * tp), ca.horzcat(0, cr, -sr), ca.horzcat(0, sr / cp, cr / cp))


def inertia(p):
    return ca.vertcat(*(value * p[i] for i, value in enumerate(INERTIA)))


def f(x, v, p):
    j, omega = inertia(p), rates(x) @ v
    gyroscopic = ca.cross(omega, j * omega) / j
    turning = ca.jtimes(rates(x) @ v, x, v)  # of T with the angles
    return -angles(x) @ (gyroscopic + turning)


def g(x, v, p):
    return angles(x) @ ca.diag(1 / inertia(p))


def mix(x):
    return ca.diag(ca.vertcat(*INERTIA)) @ rates(x)
