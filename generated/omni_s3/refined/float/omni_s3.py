"""omni_s3: prescribed-time reach-avoid-stay controller, refined tube.

Certified (omni_s3.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.

The same functions as omni_s3.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 9.0  # prescribed time, seconds
DESIGN_HASH = "d04355d300317e25"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    0.6887588500976562, 0.7720718383789062, -0.02367401123046875, 0.05963897705078125,
    0.6666765213012695, 0.7499895095825195, 0.00001049041748046875, 0.08332347869873047,
    0.6445951461791992, 0.7279081344604492, 0.02369403839111328, 0.10700702667236328,
    0.6225128173828125, 0.7058258056640625, 0.0473785400390625, 0.1306915283203125,
    0.6004304885864258, 0.6837434768676758, 0.07106208801269531, 0.1543750762939453,
    0.5783481597900391, 0.6616611480712891, 0.09474658966064453, 0.17805957794189453,
    0.5562667846679688, 0.6395797729492188, 0.11843013763427734, 0.20174312591552734,
    0.534184455871582, 0.6616611480712891, 0.14211463928222656, 0.22542762756347656,
    0.5121021270751953, 0.6616611480712891, 0.16579818725585938, 0.24911117553710938,
    0.5050048828125, 0.6616611480712891, 0.1894826889038086, 0.2727956771850586,
    0.5050048828125, 0.6616611480712891, 0.2131662368774414, 0.2964792251586914,
    0.5050048828125, 0.6616611480712891, 0.23685073852539062, 0.3201637268066406,
    0.5050048828125, 0.6616611480712891, 0.26053428649902344, 0.34384727478027344,
    0.5050048828125, 0.6616611480712891, 0.28421878814697266, 0.36753177642822266,
    0.5050048828125, 0.6616611480712891, 0.3079032897949219, 0.3912162780761719,
    0.5050048828125, 0.6616611480712891, 0.3315868377685547, 0.4148998260498047,
    0.5050048828125, 0.6616611480712891, 0.3552713394165039, 0.4385843276977539,
    0.5050048828125, 0.6616611480712891, 0.3789548873901367, 0.4622678756713867,
    0.5050048828125, 0.6395797729492188, 0.40263938903808594, 0.48595237731933594,
    0.5050048828125, 0.6616611480712891, 0.42632293701171875, 0.5096359252929688,
    0.5050048828125, 0.6837434768676758, 0.45000743865966797, 0.533320426940918,
    0.5050048828125, 0.7058258056640625, 0.4736909866333008, 0.5570039749145508,
    0.5144634246826172, 0.7279081344604492, 0.49737548828125, 0.5806884765625,
    0.5365447998046875, 0.7499895095825195, 0.5210590362548828, 0.6043720245361328,
    0.5586271286010742, 0.7720718383789062, 0.544743537902832, 0.628056526184082,
    0.5807094573974609, 0.794154167175293, 0.5684270858764648, 0.6517400741577148,
    0.6027917861938477, 0.8162355422973633, 0.5921115875244141, 0.6754245758056641,
    0.624873161315918, 0.8333282470703125, 0.6157951354980469, 0.6991081237792969,
    0.6469554901123047, 0.8333282470703125, 0.6394796371459961, 0.7227926254272461,
    0.6690378189086914, 0.8333282470703125, 0.6631631851196289, 0.7464761734008789,
    0.6911191940307617, 0.8333282470703125, 0.6868476867675781, 0.7701606750488281,
    0.7132015228271484, 0.8333282470703125, 0.7105312347412109, 0.7938442230224609,
    0.7352838516235352, 0.8186273574829102, 0.7342157363891602, 0.8175287246704102,
    0.7573661804199219, 0.8406782150268555, 0.7579002380371094, 0.8412132263183594,
    0.7352838516235352, 0.8186273574829102, 0.7342157363891602, 0.8175287246704102,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _segment(t):
    """Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 32 (t_c = 9 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 3.555555582046509
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


def _blend(w0, w1, w2, w3, q0, q1, q2, q3):
    """An edge of the tube (or its slope in spline time): sum of w_j q_j."""
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
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        lower[i] = lower_edge
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
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
    moving = t < 9.0
    per_second = 3.555555582046509 if moving else 0.0
    for i in range(2):
        pair = i * 2
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_slope = _blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3)
        lower_speed = lower_slope * per_second
        lower_rate[i] = lower_speed
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_slope = _blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3)
        upper_speed = upper_slope * per_second
        upper_rate[i] = upper_speed
    return tuple(lower_rate), tuple(upper_rate)


def control(t, x):
    """Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
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
        for j2 in range(2):
            u[j2] = 0.0
        return BAD_INPUT, tuple(u)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    outside = False
    for i in range(2):
        pair = i * 2
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
        x_i = x[i]
        room = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        nearest = to_upper if upper_nearer else to_lower
        gain = -0.5 if upper_nearer else 0.5
        least = room * 0.004999999888241291
        clear = least < nearest
        near = nearest if clear else least
        far = room - near
        within = 0.0 < nearest
        outside_any = outside if within else True
        epsilon, xi = _transformed_error(near, far)
        push = _law(gain, xi, epsilon)
        u[i] = push
        outside = outside_any
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
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
        x_i = x[i]
        room = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        nearest = to_upper if upper_nearer else to_lower
        share = nearest / room
        beyond = share < -1.0
        held_share = -1.0 if beyond else share
        less = held_share < margin
        margin_next = held_share if less else margin
        margin = margin_next
    return margin


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
        room = upper_edge - lower_edge
        filled = 0.0 < room
        empty = not filled
        wide = 9.5367431640625e-7 < room
        width = room if wide else 9.5367431640625e-7
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        nearest = to_upper if upper_nearer else to_lower
        gain = -1.0 if upper_nearer else 1.0
        least = width * 0.004999999888241291
        widened = width - room
        spare = widened * 0.5
        distance = nearest + spare
        farther = least < distance
        clear = filled and farther
        near = distance if clear else least
        far = width - near
        a = far if upper_nearer else near
        b = near if upper_nearer else far
        e_raw = _normalized_error(a, b, width)
        e_held_above = -0.9900000095367432 < e_raw
        e_held_raised = e_raw if e_held_above else -0.9900000095367432
        e_held_over = 0.9900000095367432 < e_held_raised
        e_held = 0.9900000095367432 if e_held_over else e_held_raised
        epsilon_near, xi_i = _transformed_error(near, far)
        epsilon_i = gain * epsilon_near
        finite_x = math.isfinite(x_i)
        finite_room = math.isfinite(room)
        finite = finite_x and finite_room
        e_settled = 0.0 if empty else e_held
        e_out = e_settled if finite else math.nan
        e[i] = e_out
        epsilon_settled = 0.0 if empty else epsilon_i
        epsilon_out = epsilon_settled if finite else math.nan
        epsilon[i] = epsilon_out
        xi_settled = 0.0 if empty else xi_i
        xi_out = xi_settled if finite else math.nan
        xi[i] = xi_out
    return tuple(e), tuple(epsilon), tuple(xi)
