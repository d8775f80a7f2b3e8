"""drone: prescribed-time reach-avoid-stay controller, refined tube.

Certified (drone.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
at rest in it; gamma(0) is in the certificate.
The state stays in it (P9) sampled every 0.025 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
w| <= 0.35, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 0.005, u acts at most 0.004 s after its sample, v
measured to 0.02: |e| of v + lambda x < [0.9346, 0.9346, 0.9377], |u| <= 2.5.

The same functions as drone.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 3 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 3
T_C = 12.0  # prescribed time, seconds
SHARE = 0.7999999523162842  # 0.8, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "ad7b6e169cade754"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    0.050009727478027344, 0.14999008178710938, 0.05177879333496094, 0.15175914764404297,
    0.11683368682861328, 0.2168130874633789,
    0.050009727478027344, 0.14999008178710938, 0.04912567138671875, 0.14910507202148438,
    0.11659812927246094, 0.21657848358154297,
    0.050009727478027344, 0.14999008178710938, 0.05177879333496094, 0.15175914764404297,
    0.11683368682861328, 0.2168130874633789,
    0.05123329162597656, 0.1512136459350586, 0.059739112854003906, 0.15971851348876953,
    0.1175394058227539, 0.21751976013183594,
    0.05776405334472656, 0.1577434539794922, 0.07300472259521484, 0.17298507690429688,
    0.11871623992919922, 0.21869659423828125,
    0.06960010528564453, 0.16958045959472656, 0.09157848358154297, 0.1915578842163086,
    0.12036418914794922, 0.22034358978271484,
    0.08674335479736328, 0.1867237091064453, 0.11545753479003906, 0.2154369354248047,
    0.1224822998046875, 0.22246265411376953,
    0.10453510284423828, 0.2045145034790039, 0.14464378356933594, 0.24462318420410156,
    0.12507152557373047, 0.2250509262084961,
    0.12763214111328125, 0.22761249542236328, 0.1791362762451172, 0.2791156768798828,
    0.12813186645507812, 0.22811126708984375,
    0.156036376953125, 0.25601673126220703, 0.2189350128173828, 0.31891441345214844,
    0.13166236877441406, 0.2316417694091797,
    0.18974781036376953, 0.28972721099853516, 0.2640399932861328, 0.36402034759521484,
    0.13566303253173828, 0.2356433868408203,
    0.22876453399658203, 0.32874393463134766, 0.3144521713256836, 0.4144325256347656,
    0.1401357650756836, 0.24011516571044922,
    0.26778221130371094, 0.36776161193847656, 0.37017154693603516, 0.4701509475708008,
    0.14507770538330078, 0.2450580596923828,
    0.30679893493652344, 0.40677928924560547, 0.42747974395751953, 0.5274591445922852,
    0.15049171447753906, 0.2504711151123047,
    0.3511228561401367, 0.45110225677490234, 0.47948169708251953, 0.5794610977172852,
    0.15637588500976562, 0.25635528564453125,
    0.4007530212402344, 0.5007333755493164, 0.5261764526367188, 0.6261558532714844,
    0.16273117065429688, 0.2627105712890625,
    0.4556903839111328, 0.5556697845458984, 0.5675649642944336, 0.6675453186035156,
    0.1695566177368164, 0.26953601837158203,
    0.5159339904785156, 0.6159133911132812, 0.6036472320556641, 0.7036266326904297,
    0.176849365234375, 0.27682971954345703,
    0.5814838409423828, 0.6814632415771484, 0.6344232559204102, 0.7344026565551758,
    0.18391036987304688, 0.2838907241821289,
    0.650456428527832, 0.7504358291625977, 0.6598920822143555, 0.7598714828491211,
    0.19050121307373047, 0.2904806137084961,
    0.7194290161132812, 0.8194084167480469, 0.6800546646118164, 0.780034065246582,
    0.19662094116210938, 0.296600341796875,
    0.783106803894043, 0.883087158203125, 0.694911003112793, 0.7948904037475586,
    0.2022695541381836, 0.3022489547729492,
    0.8414793014526367, 0.9414587020874023, 0.7044601440429688, 0.8044395446777344,
    0.20744800567626953, 0.30742740631103516,
    0.8945446014404297, 0.9945240020751953, 0.7087030410766602, 0.8086824417114258,
    0.21215534210205078, 0.3121347427368164,
    0.9423027038574219, 1.042283058166504, 0.7076396942138672, 0.8076190948486328,
    0.21639156341552734, 0.3163719177246094,
    0.9847555160522461, 1.0847349166870117, 0.702519416809082, 0.8024997711181641,
    0.22015762329101562, 0.32013702392578125,
    1.0219011306762695, 1.1218805313110352, 0.6974000930786133, 0.7973794937133789,
    0.22345256805419922, 0.32343292236328125,
    1.0537405014038086, 1.1537199020385742, 0.6922807693481445, 0.7922601699829102,
    0.22627735137939453, 0.32625675201416016,
    1.0802726745605469, 1.180253028869629, 0.6871604919433594, 0.7871408462524414,
    0.22863101959228516, 0.3286104202270508,
    1.1014995574951172, 1.2014789581298828, 0.6820411682128906, 0.7820205688476562,
    0.2305135726928711, 0.3304939270019531,
    1.1174192428588867, 1.2173986434936523, 0.6769208908081055, 0.7769012451171875,
    0.23192596435546875, 0.3319063186645508,
    1.1280317306518555, 1.228011131286621, 0.6718015670776367, 0.7717809677124023,
    0.23286724090576172, 0.33284759521484375,
    1.1333379745483398, 1.2333183288574219, 0.666682243347168, 0.7666616439819336,
    0.2333383560180664, 0.33331775665283203,
    1.1333379745483398, 1.2333183288574219, 0.666682243347168, 0.7666616439819336,
    0.2333383560180664, 0.33331775665283203,
    1.1333379745483398, 1.2333183288574219, 0.666682243347168, 0.7666616439819336,
    0.2333383560180664, 0.33331775665283203,
)

# lambda of v + lambda x, by component.
FILTER = (
    0.98046875, 0.98046875, 0.78564453125,
)

# Gain k of the control law, by component.
GAIN = (
    0.05249999836087227, 0.05249999836087227, 0.027000000700354576,
)

# Saturation of u, by component.
U_MAX = (
    2.5, 2.5, 2.5,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    0.36504754424095154, 0.3650490641593933, 0.7650489211082458,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    0.8349512815475464, 0.834949791431427, 1.2349510192871094,
)

# The same of v + lambda x: strictly above these bounds.
FILTERED_START_LOWER = (
    0.3779207170009613, 0.3779222369194031, 0.621059000492096,
)

# The same of v + lambda x: strictly below these bounds.
FILTERED_START_UPPER = (
    0.7986406087875366, 0.7986391186714172, 0.950230062007904,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _segment(t):
    """Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 32 (t_c = 12 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 2.6666667461395264
    early = scaled < 31.999998092651367
    u = scaled if early else 31.999998092651367
    segment = int(u)
    base = float(segment)
    place = u - base
    first = segment * 6
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
    at_1 = at + 6
    q1 = COEFFICIENTS[at_1]
    at_2 = at + 12
    q2 = COEFFICIENTS[at_2]
    at_3 = at + 18
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
    lower = [0.0] * 3
    upper = [0.0] * 3
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(3):
            lower[j] = math.nan
            upper[j] = math.nan
        return tuple(lower), tuple(upper)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    for i in range(3):
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
    lower_rate = [0.0] * 3
    upper_rate = [0.0] * 3
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(3):
            lower_rate[j] = math.nan
            upper_rate[j] = math.nan
        return tuple(lower_rate), tuple(upper_rate)
    row, s = _segment(t)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    moving = t < 12.0
    per_second = 2.6666667461395264 if moving else 0.0
    for i in range(3):
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


def filtered_tube(t):
    """Edges of the filtered tube at time t, in units per second: of v + lambda x, lambda = [0.98046875, 0.98046875, 0.78564453125].
    While v + lambda x is between them, x stays in the tube. NaN when t is not finite.
    """
    t = float(t)
    lower = [0.0] * 3
    upper = [0.0] * 3
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(3):
            lower[j] = math.nan
            upper[j] = math.nan
        return tuple(lower), tuple(upper)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    for i in range(3):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 2.6666667461395264
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 2.6666667461395264
        filter_i = FILTER[i]
        lower_part = lower_edge * filter_i
        z_lower = lower_rate + lower_part
        lower[i] = z_lower
        upper_part = upper_edge * filter_i
        z_upper = upper_rate + upper_part
        upper[i] = z_upper
    return tuple(lower), tuple(upper)


def control(t, x, v):
    """Control law (13), u = -k xi epsilon, k = [0.0525, 0.0525, 0.027], e clamped to [-0.99, 0.99] by component, u saturated.
    for v + lambda x in its tube, lambda = [0.98046875, 0.98046875, 0.78564453125]. t: seconds since the start (held within [0, t_c]);
    x: state; v: its rate; u: input.
    x by component: x [m], y [m], z [m].
    OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law,
    finite, and points inward (0 where the tube is empty). BAD_INPUT: t, x or v has a NaN or an
    infinity; u is 0. u may be the array x or v itself.
    """
    t = float(t)
    x = _vector("x", x, 3)
    v = _vector("v", v, 3)
    u = [0.0] * 3
    t_zero = t * 0.0
    zero = t_zero
    for j in range(3):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    v_zeros = zero
    for k in range(3):
        v_k = v[k]
        v_zero = v_k * 0.0
        v_sum = v_zeros + v_zero
        v_zeros = v_sum
    finite = v_zeros <= 0.0
    bad = not finite
    if bad:
        for m in range(3):
            u[m] = 0.0
        return BAD_INPUT, tuple(u)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    outside = False
    for i in range(3):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 2.6666667461395264
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 2.6666667461395264
        x_i = x[i]
        v_i = v[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_width = upper_rate - lower_rate
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        filter_i = FILTER[i]
        gain_i = GAIN[i]
        gain_minus = -gain_i
        width_part = width * filter_i
        z_width = v_width + width_part
        lower_part = to_lower * filter_i
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * filter_i
        z_to_upper = v_to_upper + upper_part
        upper_nearer = z_to_upper < z_to_lower
        distance = z_to_upper if upper_nearer else z_to_lower
        gain = gain_minus if upper_nearer else gain_i
        smallest = z_width * 0.004999999888241291
        clear = smallest < distance
        to_nearer = distance if clear else smallest
        to_farther = z_width - to_nearer
        x_above = 0.0 < to_lower
        x_below = 0.0 < to_upper
        x_inside = x_above and x_below
        z_inside = 0.0 < distance
        inside = z_inside and x_inside
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


def margin(t, x, v):
    """How far x is from leaving the tube, and v + lambda x from leaving its own: the distance to the nearest edge
    over the width there, the lesser of both, least over the components. 0.5 in the middle, positive inside,
    negative outside, at least -1; NaN when an argument is not finite.
    Watch it: act while there is margin, not when the tube is left.
    """
    t = float(t)
    x = _vector("x", x, 3)
    v = _vector("v", v, 3)
    t_zero = t * 0.0
    zero = t_zero
    for j in range(3):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    v_zeros = zero
    for k in range(3):
        v_k = v[k]
        v_zero = v_k * 0.0
        v_sum = v_zeros + v_zero
        v_zeros = v_sum
    finite = v_zeros <= 0.0
    bad = not finite
    if bad:
        return math.nan
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    margin = 0.5
    for i in range(3):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 2.6666667461395264
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 2.6666667461395264
        x_i = x[i]
        v_i = v[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_width = upper_rate - lower_rate
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        filter_i = FILTER[i]
        width_part = width * filter_i
        z_width = v_width + width_part
        lower_part = to_lower * filter_i
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * filter_i
        z_to_upper = v_to_upper + upper_part
        z_nearer = z_to_upper < z_to_lower
        z_distance = z_to_upper if z_nearer else z_to_lower
        z_share = z_distance / z_width
        z_beyond = z_share < -1.0
        margin_z = -1.0 if z_beyond else z_share
        x_nearer = to_upper < to_lower
        x_distance = to_upper if x_nearer else to_lower
        x_share = x_distance / width
        x_beyond = x_share < -1.0
        margin_x = -1.0 if x_beyond else x_share
        x_smaller = margin_x < margin_z
        smaller = margin_x if x_smaller else margin_z
        less = smaller < margin
        margin_next = smaller if less else margin
        margin = margin_next
    return margin


def margins(t, x, v):
    """The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
    components where another argument is not finite.
    """
    t = float(t)
    x = _vector("x", x, 3)
    v = _vector("v", v, 3)
    margin = [0.0] * 3
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(3):
            margin[j] = math.nan
        return tuple(margin)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    for i in range(3):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 2.6666667461395264
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 2.6666667461395264
        x_i = x[i]
        v_i = v[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_width = upper_rate - lower_rate
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        filter_i = FILTER[i]
        width_part = width * filter_i
        z_width = v_width + width_part
        lower_part = to_lower * filter_i
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * filter_i
        z_to_upper = v_to_upper + upper_part
        z_nearer = z_to_upper < z_to_lower
        z_distance = z_to_upper if z_nearer else z_to_lower
        z_share = z_distance / z_width
        z_beyond = z_share < -1.0
        margin_z = -1.0 if z_beyond else z_share
        x_nearer = to_upper < to_lower
        x_distance = to_upper if x_nearer else to_lower
        x_share = x_distance / width
        x_beyond = x_share < -1.0
        margin_x = -1.0 if x_beyond else x_share
        x_smaller = margin_x < margin_z
        smaller = margin_x if x_smaller else margin_z
        margin[i] = smaller
    return tuple(margin)


def covered(x, v):
    """Whether the proof of the sampling period (P9) covers a start at the measured x and v:
    every component of x is within 0.8 of the tube's half width about its middle at t = 0,
    and v + lambda x is in its own tube, no farther from the middle than from such an x at rest.
    What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
    Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
    from where it stands. False for a NaN.
    """
    x = _vector("x", x, 3)
    v = _vector("v", v, 3)
    covered = True
    for i in range(3):
        x_i = x[i]
        x_lower = START_LOWER[i]
        x_upper = START_UPPER[i]
        x_above = x_lower < x_i
        x_below = x_i < x_upper
        x_inside = x_above and x_below
        filter_i = FILTER[i]
        x_part = x_i * filter_i
        v_i = v[i]
        z_i = v_i + x_part
        z_lower = FILTERED_START_LOWER[i]
        z_upper = FILTERED_START_UPPER[i]
        z_above = z_lower < z_i
        z_below = z_i < z_upper
        z_inside = z_above and z_below
        inside = x_inside and z_inside
        covered_next = covered if inside else False
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
    lower = _vector("lower", lower, 3)
    upper = _vector("upper", upper, 3)
    x = _vector("x", x, 3)
    e = [0.0] * 3
    epsilon = [0.0] * 3
    xi = [0.0] * 3
    for i in range(3):
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
