"""watchman: prescribed-time reach-avoid-stay controller, refined tube.

Certified (watchman.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and repeats itself for ever.
Every x(t) that stays in the tube satisfies the mission (P10): (always eventually[0, 14] gate and always
eventually[0, 14] office and always eventually[0, 14] store and always not lab); times are seconds of t, not turned
back. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.125 s.

The same functions as watchman.c (double precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 16.0  # prescribed time, seconds
TICK_PERIOD = 0.02  # seconds of one tick of control_tick
TICKS = 800  # the first tick that is not before t_c
CYCLE = 14.0  # seconds after which the tube repeats itself, from T_C - CYCLE on
CYCLE_TICKS = 700
SHARE = 0.99  # 0.99, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "4fcf0b50ae32e31a"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 64 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    0.0014467239379882812, 0.10142707824707031, 0.026207923889160156, 0.12618732452392578,
    0.03334331512451172, 0.13332271575927734, 0.03334331512451172, 0.13332271575927734,
    0.06523990631103516, 0.16521930694580078, 0.04047870635986328, 0.1404590606689453,
    0.0971364974975586, 0.19711589813232422, 0.04761505126953125, 0.14759445190429688,
    0.12903308868408203, 0.22901248931884766, 0.05475044250488281, 0.15472984313964844,
    0.16092967987060547, 0.2609090805053711, 0.061885833740234375, 0.161865234375,
    0.1928262710571289, 0.29280567169189453, 0.06902122497558594, 0.16900062561035156,
    0.22472286224365234, 0.32470226287841797, 0.0761566162109375, 0.17613697052001953,
    0.2566194534301758, 0.3565988540649414, 0.08329200744628906, 0.1832723617553711,
    0.24215221405029297, 0.3421316146850586, 0.09042835235595703, 0.19040775299072266,
    0.22768497467041016, 0.3276653289794922, 0.12508678436279297, 0.225067138671875,
    0.21321868896484375, 0.3131980895996094, 0.16397762298583984, 0.26395702362060547,
    0.19875144958496094, 0.29873085021972656, 0.20286846160888672, 0.30284786224365234,
    0.18428421020507812, 0.28426456451416016, 0.2417593002319336, 0.3417387008666992,
    0.16981792449951172, 0.26979732513427734, 0.28065013885498047, 0.3806295394897461,
    0.1553506851196289, 0.25533008575439453, 0.31954097747802734, 0.41952037811279297,
    0.1408834457397461, 0.24086284637451172, 0.3584308624267578, 0.45841121673583984,
    0.12641620635986328, 0.2263965606689453, 0.3973217010498047, 0.4973020553588867,
    0.11194992065429688, 0.2119293212890625, 0.43621253967285156, 0.5361919403076172,
    0.09748268127441406, 0.1974620819091797, 0.47510337829589844, 0.5750827789306641,
    0.0917062759399414, 0.19168567657470703, 0.4699087142944336, 0.5698881149291992,
    0.12927913665771484, 0.22925853729248047, 0.46471309661865234, 0.5646934509277344,
    0.16685199737548828, 0.2668313980102539, 0.4595184326171875, 0.5594978332519531,
    0.2044239044189453, 0.30440425872802734, 0.45432376861572266, 0.5543031692504883,
    0.24199676513671875, 0.3419761657714844, 0.4491281509399414, 0.5491085052490234,
    0.2795696258544922, 0.3795490264892578, 0.44393348693847656, 0.5439128875732422,
    0.3171424865722656, 0.41712188720703125, 0.4387388229370117, 0.5387182235717773,
    0.35471439361572266, 0.4546947479248047, 0.43354320526123047, 0.5335235595703125,
    0.3922872543334961, 0.4922666549682617, 0.4283485412597656, 0.5283279418945312,
    0.42986011505126953, 0.5298395156860352, 0.4231538772583008, 0.5231332778930664,
    0.46743202209472656, 0.5674123764038086, 0.4209127426147461, 0.5208921432495117,
    0.5050048828125, 0.6049842834472656, 0.4283485412597656, 0.5283279418945312,
    0.5425777435302734, 0.6425571441650391, 0.43578433990478516, 0.5357646942138672,
    0.5801506042480469, 0.6801300048828125, 0.4432210922241211, 0.5432004928588867,
    0.6177225112915039, 0.7177028656005859, 0.4506568908691406, 0.5506362915039062,
    0.6552953720092773, 0.755274772644043, 0.45809268951416016, 0.5580730438232422,
    0.6876935958862305, 0.7876729965209961, 0.4655294418334961, 0.5655088424682617,
    0.7200908660888672, 0.8200702667236328, 0.4729652404785156, 0.5729446411132812,
    0.7524890899658203, 0.8524684906005859, 0.48040103912353516, 0.5803813934326172,
    0.784886360168457, 0.8848657608032227, 0.4878377914428711, 0.5878171920776367,
    0.8172836303710938, 0.9172639846801758, 0.4489479064941406, 0.5489273071289062,
    0.8460378646850586, 0.9460182189941406, 0.41005706787109375, 0.5100364685058594,
    0.8747920989990234, 0.9747724533081055, 0.3711662292480469, 0.4711456298828125,
    0.9035463333129883, 1.0035266876220703, 0.332275390625, 0.4322547912597656,
    0.8929519653320312, 0.9929323196411133, 0.2933845520019531, 0.39336395263671875,
    0.8823575973510742, 0.9823369979858398, 0.25449371337890625, 0.3544740676879883,
    0.8717632293701172, 0.9717426300048828, 0.21560287475585938, 0.3155832290649414,
    0.8611688613891602, 0.9611482620239258, 0.1767129898071289, 0.27669239044189453,
    0.8505744934082031, 0.9505538940429688, 0.13782215118408203, 0.23780155181884766,
    0.8399801254272461, 0.9399595260620117, 0.09893131256103516, 0.19891071319580078,
    0.8010892868041992, 0.9010686874389648, 0.06004047393798828, 0.1600198745727539,
    0.7621984481811523, 0.862177848815918, 0.021149635314941406, 0.12112903594970703,
    0.7233076095581055, 0.8232870101928711, 0.022161483764648438, 0.12214088439941406,
    0.6844167709350586, 0.7843971252441406, 0.02317333221435547, 0.1231527328491211,
    0.6455259323120117, 0.7455062866210938, 0.024184226989746094, 0.12416458129882812,
    0.6066360473632812, 0.7066154479980469, 0.025196075439453125, 0.12517642974853516,
    0.5677452087402344, 0.667724609375, 0.026207923889160156, 0.12618732452392578,
    0.5288543701171875, 0.6288337707519531, 0.03334331512451172, 0.13332271575927734,
    0.4899635314941406, 0.5899429321289062, 0.04047870635986328, 0.1404590606689453,
    0.45107269287109375, 0.5510520935058594, 0.04761505126953125, 0.14759445190429688,
    0.4121818542480469, 0.5121612548828125, 0.05475044250488281, 0.15472984313964844,
    0.373291015625, 0.47327136993408203, 0.061885833740234375, 0.161865234375,
    0.3344001770019531, 0.43438053131103516, 0.06902122497558594, 0.16900062561035156,
    0.29551029205322266, 0.3954896926879883, 0.0761566162109375, 0.17613697052001953,
    0.2566194534301758, 0.3565988540649414, 0.08329200744628906, 0.1832723617553711,
    0.24215221405029297, 0.3421316146850586, 0.09042835235595703, 0.19040775299072266,
    0.22768497467041016, 0.3276653289794922, 0.12508678436279297, 0.225067138671875,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    0.20305927753448622, 0.20305927753448622,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    0.7969378614425645, 0.7969378614425645,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _count(name, value):
    """A count from 0 to 2^32 - 1; ValueError for anything else."""
    if int(value) != value or not 0 <= value < 2**32:
        raise ValueError(f"{name} is {value!r}, it must be a whole number from 0 to 2^32 - 1")
    return int(value)


def _segment(t):
    """Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 64 (t_c = 16 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 4.0
    early = scaled < 63.99999999999999
    u = scaled if early else 63.99999999999999
    segment = int(u)
    base = float(segment)
    place = u - base
    first = segment * 4
    return first, place


def _segment_at_tick(tick):
    """As segment, for a count of ticks: one is 2/25 of a segment, in integers; only s is rounded.
    From tick 800 on the last segment and s = 1, which is t_c.
    """
    running = tick < 800
    held = tick if running else 800
    count = held
    passed = count * 2
    early = passed < 1600
    place = passed if early else 1600
    whole = place // 25
    before_last = whole < 63
    segment = whole if before_last else 63
    base = segment * 25
    rest = place - base
    part = float(rest)
    share = part / 25.0
    first = segment * 4
    return first, share


def _basis(s):
    """6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6."""
    v0 = 1.0 - s
    v1 = v0 * v0
    v2 = v1 * v0
    v3 = v0 * s
    v4 = 1.0 + v3
    v5 = 3.0 * v4
    v6 = v0 * v5
    v7 = 1.0 + v6
    v8 = s * v5
    v9 = 1.0 + v8
    v10 = s * s
    v11 = v10 * s
    return v2, v7, v9, v11


def _basis_rate(s):
    """Derivative of the weights with respect to s."""
    v0 = 1.0 - s
    v1 = v0 + v0
    v2 = v0 * v1
    v3 = v0 * v0
    v4 = v2 + v3
    v5 = -v4
    v6 = v0 - s
    v7 = 3.0 * v6
    v8 = v0 * v7
    v9 = v0 * s
    v10 = 1.0 + v9
    v11 = 3.0 * v10
    v12 = v8 - v11
    v13 = s * v7
    v14 = v11 + v13
    v15 = s + s
    v16 = s * v15
    v17 = s * s
    v18 = v16 + v17
    return v5, v12, v14, v18


def _edge_at(at, w0, w1, w2, w3):
    """An edge of the tube (or its slope in spline time): sum of w_j q_j,
    of the control points that stand at `at` and one, two and three rows after it.
    """
    q0 = COEFFICIENTS[at]
    at_1 = at + 4
    q1 = COEFFICIENTS[at_1]
    at_2 = at + 8
    q2 = COEFFICIENTS[at_2]
    at_3 = at + 12
    q3 = COEFFICIENTS[at_3]
    v0 = w0 * q0
    v1 = w1 * q1
    v2 = v0 + v1
    v3 = w2 * q2
    v4 = w3 * q3
    v5 = v3 + v4
    v6 = v2 + v5
    return v6


def _normalized_error(a, b, width):
    """Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x."""
    v0 = a - b
    v1 = v0 / width
    return v1


def _transformed_error(a, b):
    """Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b."""
    v0 = b / a
    v1 = math.log(v0)
    v2 = -v1
    v3 = 1.0 + v0
    v4 = v3 / b
    return v2, v4


def _law(k, xi, epsilon):
    """Control law (13): u = -k xi epsilon."""
    v0 = k * xi
    v1 = v0 * epsilon
    v2 = -v1
    return v2


def tube(t):
    """Edges of the tube gamma at time t (seconds), in the task's units.
    t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
    """
    t = float(t)
    lower = [0.0] * 2
    upper = [0.0] * 2
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(2):
            lower[j] = math.nan
            upper[j] = math.nan
        return tuple(lower), tuple(upper)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower[i] = lower_edge
        upper[i] = upper_edge
    return tuple(lower), tuple(upper)


def tube_rate(t):
    """Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
    The rate at 0 before that and zero from t_c on; NaN when t is not finite.
    """
    t = float(t)
    lower_rate = [0.0] * 2
    upper_rate = [0.0] * 2
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(2):
            lower_rate[j] = math.nan
            upper_rate[j] = math.nan
        return tuple(lower_rate), tuple(upper_rate)
    row, s = _segment(t)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    moving = t < 16.0
    per_second = 4.0 if moving else 0.0
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_speed = lower_slope * per_second
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_speed = upper_slope * per_second
        lower_rate[i] = lower_speed
        upper_rate[i] = upper_speed
    return tuple(lower_rate), tuple(upper_rate)


def control(t, x):
    """Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
    t: seconds, as watchman_wrap turns them back (held within [0, t_c]); x: state; u: input.
    x by component: x [m], y [m].
    OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
    (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
    """
    t = float(t)
    x = _vector("x", x, 2)
    u = [0.0] * 2
    t_zero = t * 0.0
    zero = t_zero
    for j in range(2):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    finite = zero <= 0.0
    bad = not finite
    if bad:
        for m in range(2):
            u[m] = 0.0
        return BAD_INPUT, tuple(u)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    outside = False
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        x_i = x[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        distance = to_upper if upper_nearer else to_lower
        gain = -0.5 if upper_nearer else 0.5
        smallest = width * 0.005
        clear = smallest < distance
        to_nearer = distance if clear else smallest
        to_farther = width - to_nearer
        inside = 0.0 < distance
        outside_next = outside if inside else True
        epsilon, xi = _transformed_error(to_nearer, to_farther)
        u_i = _law(gain, xi, epsilon)
        u[i] = u_i
        outside = outside_next
    return OUTSIDE_TUBE if outside else OK, tuple(u)


def control_tick(tick, x):
    """Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
    tick: periods of 0.02 s, as watchman_wrap_tick turns them back; x: state; u: input.
    x by component: x [m], y [m].
    OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
    (0 where the tube is empty). BAD_INPUT: x has a NaN or an infinity; u is 0. u may be the array x itself.
    """
    tick = _count("tick", tick)
    x = _vector("x", x, 2)
    u = [0.0] * 2
    zero = 0.0
    for j in range(2):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    finite = zero <= 0.0
    bad = not finite
    if bad:
        for m in range(2):
            u[m] = 0.0
        return BAD_INPUT, tuple(u)
    row, s = _segment_at_tick(tick)
    w0, w1, w2, w3 = _basis(s)
    outside = False
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        x_i = x[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        distance = to_upper if upper_nearer else to_lower
        gain = -0.5 if upper_nearer else 0.5
        smallest = width * 0.005
        clear = smallest < distance
        to_nearer = distance if clear else smallest
        to_farther = width - to_nearer
        inside = 0.0 < distance
        outside_next = outside if inside else True
        epsilon, xi = _transformed_error(to_nearer, to_farther)
        u_i = _law(gain, xi, epsilon)
        u[i] = u_i
        outside = outside_next
    return OUTSIDE_TUBE if outside else OK, tuple(u)


def margin(t, x):
    """How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
    components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
    Watch it: act while there is margin, not when the tube is left.
    """
    t = float(t)
    x = _vector("x", x, 2)
    t_zero = t * 0.0
    zero = t_zero
    for j in range(2):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    finite = zero <= 0.0
    bad = not finite
    if bad:
        return math.nan
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    margin = 0.5
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        x_i = x[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        x_nearer = to_upper < to_lower
        x_distance = to_upper if x_nearer else to_lower
        x_share = x_distance / width
        x_beyond = x_share < -1.0
        margin_x = -1.0 if x_beyond else x_share
        less = margin_x < margin
        margin_next = margin_x if less else margin
        margin = margin_next
    return margin


def margins(t, x):
    """The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
    components where another argument is not finite.
    """
    t = float(t)
    x = _vector("x", x, 2)
    margin = [0.0] * 2
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(2):
            margin[j] = math.nan
        return tuple(margin)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        x_i = x[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        x_nearer = to_upper < to_lower
        x_distance = to_upper if x_nearer else to_lower
        x_share = x_distance / width
        x_beyond = x_share < -1.0
        margin_x = -1.0 if x_beyond else x_share
        margin[i] = margin_x
    return tuple(margin)


def covered(x):
    """Whether the paper's Theorem 4.1, in continuous time, covers a start at the measured x:
    every component of x is within 0.99 of the tube's half width about its middle at t = 0.
    What a measurement may be wrong by (rounding) is taken off.
    Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
    from where it stands. False for a NaN.
    """
    x = _vector("x", x, 2)
    covered = True
    for i in range(2):
        x_i = x[i]
        x_lower = START_LOWER[i]
        x_upper = START_UPPER[i]
        x_above = x_lower < x_i
        x_below = x_i < x_upper
        x_inside = x_above and x_below
        covered_next = covered if x_inside else False
        covered = covered_next
    return covered


def transform(lower, upper, x):
    """Error transform of section IV for the state x in the box (lower, upper), by component:
      e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
      epsilon = ln((1 + e) / (1 - e))
      xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
    0 in a component with upper <= lower; a width below 2^-20 counts as that.
    NaN where an edge, x or upper - lower is not finite.
    """
    lower = _vector("lower", lower, 2)
    upper = _vector("upper", upper, 2)
    x = _vector("x", x, 2)
    e = [0.0] * 2
    epsilon = [0.0] * 2
    xi = [0.0] * 2
    for i in range(2):
        lower_edge = lower[i]
        upper_edge = upper[i]
        x_i = x[i]
        width = upper_edge - lower_edge
        filled = 0.0 < width
        empty = not filled
        wide = 9.5367431640625e-7 < width
        safe_width = width if wide else 9.5367431640625e-7
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        distance = to_upper if upper_nearer else to_lower
        sign = -1.0 if upper_nearer else 1.0
        smallest = safe_width * 0.005
        widened = safe_width - width
        half = widened * 0.5
        safe_distance = distance + half
        farther = smallest < safe_distance
        clear = filled and farther
        to_nearer = safe_distance if clear else smallest
        to_farther = safe_width - to_nearer
        a = to_farther if upper_nearer else to_nearer
        b = to_nearer if upper_nearer else to_farther
        e_i = _normalized_error(a, b, safe_width)
        e_above = -0.99 < e_i
        e_raised = e_i if e_above else -0.99
        e_beyond = 0.99 < e_raised
        e_limited = 0.99 if e_beyond else e_raised
        epsilon_nearer, xi_i = _transformed_error(to_nearer, to_farther)
        epsilon_i = sign * epsilon_nearer
        finite_x = math.isfinite(x_i)
        finite_width = math.isfinite(width)
        finite = finite_x and finite_width
        e_or_zero = 0.0 if empty else e_limited
        e_out = e_or_zero if finite else math.nan
        e[i] = e_out
        epsilon_or_zero = 0.0 if empty else epsilon_i
        epsilon_out = epsilon_or_zero if finite else math.nan
        epsilon[i] = epsilon_out
        xi_or_zero = 0.0 if empty else xi_i
        xi_out = xi_or_zero if finite else math.nan
        xi[i] = xi_out
    return tuple(e), tuple(epsilon), tuple(xi)


def phase(t):
    """The entry of the mission that is being served at time t, from 1; 0 once all are done. See watchman.h."""
    if t < 16.0:
        return 1
    return 0


def wrap(t):
    """t, or from t_c on one cycle earlier: count t = wrap(t + period). See watchman.h."""
    return t if t < T_C else t - CYCLE


def wrap_tick(tick):
    """The same for a count of ticks, exactly."""
    return tick if tick < TICKS else tick - CYCLE_TICKS
