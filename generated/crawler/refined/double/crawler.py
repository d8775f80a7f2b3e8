"""crawler: prescribed-time reach-avoid-stay controller, refined tube.

Certified (crawler.certificate.json): for every t the tube keeps 0.05 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
The state stays in it (P9) sampled every 0.005 s or faster, from every start with |e(0)| <= 0.9, for |f +
w| <= 0.1, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 0.002: |e| < 0.9001, |u| <= 1.3.

The same functions as crawler.c (double precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 6.0  # prescribed time, seconds
TICK_PERIOD = 0.001  # seconds of one tick of control_tick
TICKS = 6000  # the first tick that is not before t_c
SHARE = 0.8999999999999999  # 0.9, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "dbb8a86162c3b17a"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-21: exact in float and double.
COEFFICIENTS = (
    -0.009665489196777344, 0.1619091033935547, -0.0220184326171875, 0.14955615997314453,
    5.245208740234375e-6, 0.16666173934936523, 5.245208740234375e-6, 0.16666173934936523,
    0.00967550277709961, 0.17141389846801758, 0.02202892303466797, 0.18376731872558594,
    0.019346237182617188, 0.17616653442382812, 0.0440521240234375, 0.20087289810180664,
    0.029016494750976562, 0.18091917037963867, 0.06607580184936523, 0.21797847747802734,
    0.03868722915649414, 0.18567132949829102, 0.08809947967529297, 0.23508405685424805,
    0.048357486724853516, 0.19042396545410156, 0.1101231575012207, 0.25218963623046875,
    0.058028221130371094, 0.1951766014099121, 0.13214683532714844, 0.26929521560668945,
    0.06769847869873047, 0.19992923736572266, 0.15417051315307617, 0.28640079498291016,
    0.07736921310424805, 0.204681396484375, 0.1761941909790039, 0.30350637435913086,
    0.08703994750976562, 0.20943403244018555, 0.19821786880493164, 0.32061195373535156,
    0.096710205078125, 0.2141866683959961, 0.22024154663085938, 0.33771753311157227,
    0.10638093948364258, 0.21893882751464844, 0.2422652244567871, 0.35482311248779297,
    0.11605119705200195, 0.22860956192016602, 0.26428890228271484, 0.3768467903137207,
    0.12572193145751953, 0.2382798194885254, 0.2863121032714844, 0.39887046813964844,
    0.14577245712280273, 0.2583308219909668, 0.3083357810974121, 0.42089414596557617,
    0.16582345962524414, 0.27838134765625, 0.33035945892333984, 0.4429178237915039,
    0.18587398529052734, 0.2984323501586914, 0.3523831367492676, 0.46494150161743164,
    0.20592498779296875, 0.3184828758239746, 0.35822582244873047, 0.47078418731689453,
    0.22597551345825195, 0.338533878326416, 0.36406850814819336, 0.4766268730163574,
    0.24602651596069336, 0.3585844039916992, 0.36991119384765625, 0.4824695587158203,
    0.26607704162597656, 0.3786354064941406, 0.37575387954711914, 0.4883122444152832,
    0.28612804412841797, 0.39868593215942383, 0.38159656524658203, 0.4941549301147461,
    0.30617856979370117, 0.41873693466186523, 0.3874392509460449, 0.499997615814209,
    0.3262295722961426, 0.43878746032714844, 0.3874392509460449, 0.499997615814209,
    0.3462800979614258, 0.45883846282958984, 0.3874392509460449, 0.499997615814209,
    0.3663311004638672, 0.47888898849487305, 0.3874392509460449, 0.499997615814209,
    0.3863816261291504, 0.49893999099731445, 0.3874392509460449, 0.499997615814209,
    0.4064326286315918, 0.5189905166625977, 0.3874392509460449, 0.499997615814209,
    0.426483154296875, 0.5390415191650391, 0.3874392509460449, 0.499997615814209,
    0.4465341567993164, 0.5590920448303223, 0.3874392509460449, 0.499997615814209,
    0.4665846824645996, 0.5791430473327637, 0.3874392509460449, 0.499997615814209,
    0.486635684967041, 0.5991935729980469, 0.3874392509460449, 0.499997615814209,
    0.5066862106323242, 0.6192440986633301, 0.3874392509460449, 0.499997615814209,
    0.486635684967041, 0.5991935729980469, 0.3874392509460449, 0.499997615814209,
)

# Gain k of the control law, by component.
GAIN = (
    0.0388, 0.0623,
)

# Saturation of u, by component.
U_MAX = (
    1.2999999999999998, 1.2999999999999998,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    0.05202794265747159, 0.052028419494629795,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    0.9479730110168447, 0.9479734878540029,
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


def _split(y):
    """m and e with y = m 2^e, m in [1/sqrt 2, sqrt 2)."""
    m, e = math.frexp(y)
    return (m, e) if m >= 0.7071067811865476 else (2.0 * m, e - 1)


def _segment(t):
    """Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 32 (t_c = 6 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 5.333333333333333
    early = scaled < 31.999999999999996
    u = scaled if early else 31.999999999999996
    segment = int(u)
    base = float(segment)
    place = u - base
    first = segment * 4
    return first, place


def _segment_at_tick(tick):
    """As segment, for a count of ticks: one is 2/375 of a segment, in integers; only s is rounded.
    From tick 6000 on the last segment and s = 1, which is t_c.
    """
    running = tick < 6000
    held = tick if running else 6000
    count = held
    passed = count * 2
    early = passed < 12000
    place = passed if early else 12000
    whole = place // 375
    before_last = whole < 31
    segment = whole if before_last else 31
    base = segment * 375
    rest = place - base
    part = float(rest)
    share = part / 375.0
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
    """Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b.
    ln y by y = m 2^e as e ln 2 + 2 atanh((m - 1)/(m + 1)), with a relative error below 2^-14.
    """
    v0 = b / a
    exponent = _split(v0)[1]
    base = float(exponent)
    mantissa = _split(v0)[0]
    below = mantissa - 1.0
    above = mantissa + 1.0
    s = below / above
    z = s * s
    bent = z * 0.6766043901443481
    around = bent + 2.0
    part = s * around
    whole = base * 0.6931471805599453
    v1 = whole + part
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
    moving = t < 6.0
    per_second = 5.333333333333333 if moving else 0.0
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
    """Control law (13), u = -k xi epsilon, k = [0.0388, 0.0623], e clamped to [-0.99, 0.99] by component, u saturated.
    t: seconds since the start (held within [0, t_c]); x: state; u: input.
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
        gain_i = GAIN[i]
        gain_minus = -gain_i
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        distance = to_upper if upper_nearer else to_lower
        gain = gain_minus if upper_nearer else gain_i
        smallest = width * 0.005
        clear = smallest < distance
        to_nearer = distance if clear else smallest
        to_farther = width - to_nearer
        inside = 0.0 < distance
        outside_next = outside if inside else True
        u_limit = U_MAX[i]
        epsilon, xi = _transformed_error(to_nearer, to_farther)
        u_i = _law(gain, xi, epsilon)
        u_min = -u_limit
        u_above = u_min < u_i
        u_raised = u_i if u_above else u_min
        u_beyond = u_limit < u_raised
        u_limited = u_limit if u_beyond else u_raised
        u[i] = u_limited
        outside = outside_next
    return OUTSIDE_TUBE if outside else OK, tuple(u)


def control_tick(tick, x):
    """Control law (13), u = -k xi epsilon, k = [0.0388, 0.0623], e clamped to [-0.99, 0.99] by component, u saturated.
    tick: periods of 0.001 s since the start (it must not wrap to 0: stop counting at t_c); x: state; u: input.
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
        gain_i = GAIN[i]
        gain_minus = -gain_i
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        distance = to_upper if upper_nearer else to_lower
        gain = gain_minus if upper_nearer else gain_i
        smallest = width * 0.005
        clear = smallest < distance
        to_nearer = distance if clear else smallest
        to_farther = width - to_nearer
        inside = 0.0 < distance
        outside_next = outside if inside else True
        u_limit = U_MAX[i]
        epsilon, xi = _transformed_error(to_nearer, to_farther)
        u_i = _law(gain, xi, epsilon)
        u_min = -u_limit
        u_above = u_min < u_i
        u_raised = u_i if u_above else u_min
        u_beyond = u_limit < u_raised
        u_limited = u_limit if u_beyond else u_raised
        u[i] = u_limited
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
    """Whether the proof of the sampling period (P9) covers a start at the measured x:
    every component of x is within 0.9 of the tube's half width about its middle at t = 0.
    What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
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
