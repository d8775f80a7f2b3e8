"""A quadrotor's position, for tasks/drone.toml: u are the accelerations that its attitude loop is asked for.

Thrust is known to 4 %, one share for all axes. The air drags. What the tilt is wrong by turns the thrust: at 9.81 m/s^2 and 1.2
degrees that is 0.2 m/s^2, and with gusts it is counted to w.
"""

DRAG = 0.03  # 1/s

p = [(0.96, 1.04)]  # what acts of what is asked for
w_max = 0.25  # m/s^2


def f(x, v, p):
    return -DRAG * v


def g(x, v, p):
    return [[p[0], 0, 0], [0, p[0], 0], [0, 0, p[0]]]
