"""trolley: prescribed-time reach-avoid-stay controller, refined tube.

Certified (trolley.certificate.json): for every t the tube keeps 0.05 from every
unsafe set, stays in the state space, is at least 0.2 wide, and ends in the target set.
The state stays in it (P9) sampled every 0.02 s or faster, from every start with |e(0)| <= 0.9, for |f +
w| <= 0.15, 0.9 <= g_ii <= 1.1, |g_ij| <= 0.05, x measured to 0.002, u acts at most 0.002 s after its sample:
|e| < [0.9117, 0.9138], |u| <= 2.

The same functions as trolley.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 8.0  # prescribed time, seconds
SHARE = 0.8999999761581421  # 0.9, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "5ebd1be7025bd9ea"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    0.011121749877929688, 0.11665534973144531, 0.03612232208251953, 0.14430618286132812,
    0.03334331512451172, 0.13332271575927734, 0.03334331512451172, 0.13332271575927734,
    0.055565834045410156, 0.14999103546142578, 0.030565261840820312, 0.12234020233154297,
    0.07778739929199219, 0.1666584014892578, 0.0277862548828125, 0.11135673522949219,
    0.10000896453857422, 0.18332576751708984, 0.025007247924804688, 0.1003732681274414,
    0.12223148345947266, 0.19999313354492188, 0.02222919464111328, 0.08938980102539062,
    0.1444530487060547, 0.2166604995727539, 0.01945018768310547, 0.07840633392333984,
    0.16667461395263672, 0.23332786560058594, 0.016672134399414062, 0.07431221008300781,
    0.18889713287353516, 0.24999618530273438, 0.016672134399414062, 0.07431221008300781,
    0.2111186981201172, 0.26875972747802734, 0.016672134399414062, 0.07431221008300781,
    0.23334026336669922, 0.2909812927246094, 0.016672134399414062, 0.07431221008300781,
    0.25556278228759766, 0.3132028579711914, 0.016672134399414062, 0.07431221008300781,
    0.2777843475341797, 0.33542537689208984, 0.016672134399414062, 0.07431221008300781,
    0.3000059127807617, 0.3576469421386719, 0.016672134399414062, 0.07431221008300781,
    0.32222843170166016, 0.3798685073852539, 0.016672134399414062, 0.07431221008300781,
    0.3444499969482422, 0.40209102630615234, 0.016672134399414062, 0.07431221008300781,
    0.3666715621948242, 0.4243125915527344, 0.01735401153564453, 0.07499504089355469,
    0.38889312744140625, 0.4465341567993164, 0.018036842346191406, 0.07567691802978516,
    0.4111156463623047, 0.46875667572021484, 0.03743171691894531, 0.09507274627685547,
    0.4333372116088867, 0.4909782409667969, 0.056827545166015625, 0.11446857452392578,
    0.45555877685546875, 0.5131998062133789, 0.07622337341308594, 0.1338644027709961,
    0.4777812957763672, 0.5354213714599609, 0.09561920166015625, 0.1532602310180664,
    0.5000028610229492, 0.5576438903808594, 0.11501502990722656, 0.17265605926513672,
    0.5222244262695312, 0.5798654556274414, 0.1354827880859375, 0.19312381744384766,
    0.5444469451904297, 0.6020870208740234, 0.15595054626464844, 0.2135915756225586,
    0.5666685104370117, 0.6243095397949219, 0.17641830444335938, 0.23405933380126953,
    0.5888900756835938, 0.6465311050415039, 0.1968860626220703, 0.25452709197998047,
    0.6111116409301758, 0.6687526702880859, 0.21735382080078125, 0.2749948501586914,
    0.6333341598510742, 0.690974235534668, 0.2378215789794922, 0.29546260833740234,
    0.6555557250976562, 0.7131967544555664, 0.2582893371582031, 0.3159303665161133,
    0.6592607498168945, 0.7169017791748047, 0.27875804901123047, 0.3363981246948242,
    0.6629667282104492, 0.720606803894043, 0.2992258071899414, 0.35686588287353516,
    0.6666717529296875, 0.7243127822875977, 0.31969356536865234, 0.3773336410522461,
    0.6666717529296875, 0.7243127822875977, 0.3401613235473633, 0.39780139923095703,
    0.6666717529296875, 0.7243127822875977, 0.31969356536865234, 0.3773336410522461,
)

# Gain k of the control law, by component.
GAIN = (
    0.03840000182390213, 0.025200000032782555,
)

# Saturation of u, by component.
U_MAX = (
    2.0, 2.0,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    0.23205526173114777, 0.23205526173114777,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    0.7679427862167358, 0.7679427862167358,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _segment(t):
    """Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 32 (t_c = 8 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 4.0
    early = scaled < 31.999998092651367
    u = scaled if early else 31.999998092651367
    segment = int(u)
    base = float(segment)
    place = u - base
    first = segment * 4
    return first, place


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
    moving = t < 8.0
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
    """Control law (13), u = -k xi epsilon, k = [0.0384, 0.0252], e clamped to [-0.99, 0.99] by component, u saturated.
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
        smallest = width * 0.004999999888241291
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
