"""A controller in integers alone, for boards without a floating-point unit.

curves    1/d and H(y), the two curves of the law, as tables of quadratics with their error
kernels   straight lines of shifts, sums and products of 16 bits
law       the constants of (13) for a task and a tube, and their tables
frame     tube, control, margin at a tick; inertia: the same for order 2
errors    what edges and law are wrong by, in exact numbers
program   all of it as a Program
"""
