"""watchman: prescribed-time reach-avoid-stay controller, refined tube.

Certified (watchman.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and repeats itself for ever.
Every x(t) that stays in the tube satisfies the mission (P10): (always eventually[0, 14] gate and always
eventually[0, 14] office and always eventually[0, 14] store and always not lab); times are seconds of t, not turned
back. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.343 s.

The same functions as watchman.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 16.0  # prescribed time, seconds
TICK_PERIOD = 0.019999999552965164  # seconds of one tick of control_tick
TICKS = 800  # the first tick that is not before t_c
CYCLE = 14.0  # seconds after which the tube repeats itself, from T_C - CYCLE on
CYCLE_TICKS = 700
SHARE = 0.9899999499320984  # 0.99, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "13e53a4c311d7074"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 64 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    -0.009248733520507812, 0.09073066711425781, 0.026376724243164062, 0.1263561248779297,
    0.03334331512451172, 0.13332271575927734, 0.03334331512451172, 0.13332271575927734,
    0.07593536376953125, 0.17591571807861328, 0.040309906005859375, 0.1402902603149414,
    0.11852836608886719, 0.2185077667236328, 0.04727745056152344, 0.14725685119628906,
    0.16112041473388672, 0.26109981536865234, 0.054244041442871094, 0.15422344207763672,
    0.20371246337890625, 0.3036918640136719, 0.06121063232421875, 0.16119003295898438,
    0.24630451202392578, 0.3462848663330078, 0.0681772232055664, 0.16815662384033203,
    0.2888975143432617, 0.38887691497802734, 0.07514381408691406, 0.1751241683959961,
    0.33148956298828125, 0.4314689636230469, 0.08211135864257812, 0.18209075927734375,
    0.2950153350830078, 0.39499473571777344, 0.08907794952392578, 0.1890573501586914,
    0.2585411071777344, 0.3585205078125, 0.1316699981689453, 0.23164939880371094,
    0.22206687927246094, 0.32204627990722656, 0.17426204681396484, 0.2742424011230469,
    0.1855926513671875, 0.2855720520019531, 0.21685504913330078, 0.3168344497680664,
    0.14911842346191406, 0.2490978240966797, 0.2594470977783203, 0.35942649841308594,
    0.12496471405029297, 0.2249441146850586, 0.30203914642333984, 0.40201854705810547,
    0.10081100463867188, 0.2007913589477539, 0.3446311950683594, 0.4446115493774414,
    0.07665824890136719, 0.1766376495361328, 0.3872241973876953, 0.48720359802246094,
    0.052504539489746094, 0.15248394012451172, 0.42981624603271484, 0.5297956466674805,
    0.028350830078125, 0.12833118438720703, 0.4724082946777344, 0.5723886489868164,
    0.043313026428222656, 0.14329242706298828, 0.48058032989501953, 0.5805597305297852,
    0.058274269104003906, 0.15825462341308594, 0.47405147552490234, 0.574030876159668,
    0.10001564025878906, 0.1999950408935547, 0.46752166748046875, 0.5675020217895508,
    0.1417560577392578, 0.24173545837402344, 0.46099281311035156, 0.5609731674194336,
    0.18349647521972656, 0.2834768295288086, 0.4544639587402344, 0.5544443130493164,
    0.22523784637451172, 0.32521724700927734, 0.4479351043701172, 0.5479154586791992,
    0.26697826385498047, 0.3669576644897461, 0.44140625, 0.5413856506347656,
    0.3087186813354492, 0.40869808197021484, 0.4348773956298828, 0.5348567962646484,
    0.3504600524902344, 0.450439453125, 0.4283485412597656, 0.5283279418945312,
    0.3922004699707031, 0.49217987060546875, 0.42181968688964844, 0.5217990875244141,
    0.4339408874511719, 0.5339202880859375, 0.42308616638183594, 0.5230655670166016,
    0.47568225860595703, 0.5756616592407227, 0.42435264587402344, 0.5243320465087891,
    0.5174226760864258, 0.6174020767211914, 0.4283485412597656, 0.5283279418945312,
    0.5591630935668945, 0.6591424942016602, 0.4323444366455078, 0.5323238372802734,
    0.6009035110473633, 0.7008838653564453, 0.43634033203125, 0.5363197326660156,
    0.6426448822021484, 0.7426242828369141, 0.4403362274169922, 0.5403156280517578,
    0.6843852996826172, 0.7843647003173828, 0.44433116912841797, 0.5443115234375,
    0.7261257171630859, 0.826106071472168, 0.44832706451416016, 0.5483074188232422,
    0.7678670883178711, 0.8678464889526367, 0.45232295989990234, 0.552302360534668,
    0.8096075057983398, 0.9095869064331055, 0.45631885528564453, 0.5562982559204102,
    0.8119640350341797, 0.9119434356689453, 0.4603147506713867, 0.5602941513061523,
    0.8143205642700195, 0.9142999649047852, 0.4643106460571289, 0.5642900466918945,
    0.8166770935058594, 0.916656494140625, 0.45151805877685547, 0.5514974594116211,
    0.8190336227416992, 0.9190130233764648, 0.4124622344970703, 0.5124416351318359,
    0.8213891983032227, 0.9213695526123047, 0.37340641021728516, 0.4733858108520508,
    0.8237457275390625, 0.9237260818481445, 0.3343505859375, 0.4343299865722656,
    0.8261022567749023, 0.9260826110839844, 0.29529476165771484, 0.39527416229248047,
    0.8284587860107422, 0.9284381866455078, 0.2562389373779297, 0.3562183380126953,
    0.830815315246582, 0.9307947158813477, 0.21718311309814453, 0.31716251373291016,
    0.8331718444824219, 0.9331512451171875, 0.17812728881835938, 0.278106689453125,
    0.8355283737182617, 0.9355077743530273, 0.13907146453857422, 0.23905086517333984,
    0.8378849029541016, 0.9378643035888672, 0.10001564025878906, 0.1999950408935547,
    0.8402414321899414, 0.940220832824707, 0.060959815979003906, 0.16093921661376953,
    0.8425970077514648, 0.9425773620605469, 0.032032012939453125, 0.13201141357421875,
    0.8000049591064453, 0.8999843597412109, 0.03595161437988281, 0.13593101501464844,
    0.7574129104614258, 0.8573923110961914, 0.039870262145996094, 0.13985061645507812,
    0.7148208618164062, 0.8148002624511719, 0.04378986358642578, 0.1437692642211914,
    0.6722278594970703, 0.7722082138061523, 0.04770946502685547, 0.1476888656616211,
    0.6296358108520508, 0.7296152114868164, 0.05162811279296875, 0.15160846710205078,
    0.5870437622070312, 0.6870231628417969, 0.05554771423339844, 0.15552711486816406,
    0.5444507598876953, 0.6444311141967773, 0.059467315673828125, 0.15944671630859375,
    0.5018587112426758, 0.6018381118774414, 0.0633859634399414, 0.16336631774902344,
    0.45926666259765625, 0.5592460632324219, 0.0673055648803711, 0.16728496551513672,
    0.4166746139526367, 0.5166540145874023, 0.07122516632080078, 0.1712045669555664,
    0.3740816116333008, 0.4740619659423828, 0.07514381408691406, 0.1751241683959961,
    0.33148956298828125, 0.4314689636230469, 0.08211135864257812, 0.18209075927734375,
    0.2950153350830078, 0.39499473571777344, 0.08907794952392578, 0.1890573501586914,
    0.2585411071777344, 0.3585205078125, 0.1316699981689453, 0.23164939880371094,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    0.20306000113487244, 0.20306000113487244,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    0.796937108039856, 0.796937108039856,
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
    early = scaled < 63.999996185302734
    u = scaled if early else 63.999996185302734
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
        smallest = width * 0.004999999888241291
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
        smallest = width * 0.004999999888241291
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
        smallest = safe_width * 0.004999999888241291
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
        e_above = -0.9900000095367432 < e_i
        e_raised = e_i if e_above else -0.9900000095367432
        e_beyond = 0.9900000095367432 < e_raised
        e_limited = 0.9900000095367432 if e_beyond else e_raised
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
