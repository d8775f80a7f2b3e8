"""omni_heading: prescribed-time reach-avoid-stay controller, refined tube.

Certified (omni_heading.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.

The same functions as omni_heading.c (double precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 3 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 3
T_C = 9.0  # prescribed time, seconds
DESIGN_HASH = "ab02a802003353af"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    -0.038776397705078125, 0.044536590576171875, -0.07992362976074219, 0.043358802795410156,
    -0.016656875610351562, 0.016656875610351562,
    0.00001049041748046875, 0.08332347869873047, 0.019994735717773438, 0.08332347869873047,
    -0.016656875610351562, 0.016656875610351562,
    0.038796424865722656, 0.12211036682128906, 4.76837158203125e-6, 0.12328720092773438,
    -0.016656875610351562, 0.016656875610351562,
    9.5367431640625e-6, 0.16089725494384766, 4.76837158203125e-6, 0.1632518768310547,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.16166114807128906, 0.015218734741210938, 0.203216552734375,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.16166114807128906, 0.05518341064453125, 0.2431812286376953,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.16166114807128906, 0.09514713287353516, 0.2831449508666992,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.16166114807128906, 0.13511180877685547, 0.32310962677001953,
    -0.016656875610351562, 0.016656875610351562,
    0.000774383544921875, 0.16166114807128906, 0.17507648468017578, 0.36307430267333984,
    -0.016656875610351562, 0.016656875610351562,
    0.03956127166748047, 0.12287425994873047, 0.2150402069091797, 0.40303802490234375,
    -0.016656875610351562, 0.016656875610351562,
    0.07834911346435547, 0.16166114807128906, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.11713600158691406, 0.20044898986816406, 0.2949695587158203, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.15592288970947266, 0.23923587799072266, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.19470977783203125, 0.27802276611328125, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.23349666595458984, 0.31680965423583984, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.27228355407714844, 0.35559654235839844, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.31107044219970703, 0.39438343048095703, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.3498573303222656, 0.4331703186035156, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.3886442184448242, 0.4719572067260742, 0.2618141174316406, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.4274311065673828, 0.5107440948486328, 0.30177879333496094, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.4662179946899414, 0.5495309829711914, 0.34174251556396484, 0.37169742584228516,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.58831787109375, 0.38170719146728516, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.5437917709350586, 0.6271047592163086, 0.42167186737060547, 0.4516258239746094,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.6658916473388672, 0.4616365432739258, 0.4915904998779297,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.7046785354614258, 0.42167186737060547, 0.53155517578125,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.7434654235839844, 0.44361114501953125, 0.5715188980102539,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.782252311706543, 0.48357582092285156, 0.6114835739135742,
    -0.016656875610351562, 0.016656875610351562,
    0.53021240234375, 0.8210391998291016, 0.5235404968261719, 0.6514482498168945,
    -0.016656875610351562, 0.016656875610351562,
    0.5689992904663086, 0.8333282470703125, 0.5635042190551758, 0.6914119720458984,
    -0.016656875610351562, 0.016656875610351562,
    0.6077861785888672, 0.8333282470703125, 0.6034688949584961, 0.7313766479492188,
    -0.016656875610351562, 0.016656875610351562,
    0.6465730667114258, 0.8333282470703125, 0.6434335708618164, 0.7713413238525391,
    -0.016656875610351562, 0.016656875610351562,
    0.6853599548339844, 0.8333282470703125, 0.6833972930908203, 0.8113059997558594,
    -0.016656875610351562, 0.016656875610351562,
    0.724146842956543, 0.807490348815918, 0.7233619689941406, 0.8333282470703125,
    -0.016656875610351562, 0.016656875610351562,
    0.7629337310791016, 0.8462467193603516, 0.7633266448974609, 0.8333282470703125,
    -0.016656875610351562, 0.016656875610351562,
    0.724146842956543, 0.807490348815918, 0.7233619689941406, 0.8333282470703125,
    -0.016656875610351562, 0.016656875610351562,
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
    scaled = started * 3.5555555555555554
    early = scaled < 31.999999999999996
    u = scaled if early else 31.999999999999996
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
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 6
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 12
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 18
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        lower[i] = lower_edge
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 7
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 13
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 19
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
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
    moving = t < 9.0
    per_second = 3.5555555555555554 if moving else 0.0
    for i in range(3):
        pair = i * 2
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 6
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 12
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 18
        lower_q3 = COEFFICIENTS[lower_3]
        lower_slope = _blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3)
        lower_speed = lower_slope * per_second
        lower_rate[i] = lower_speed
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 7
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 13
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 19
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
    x = _vector("x", x, 3)
    u = [0.0] * 3
    t_zero = t * 0.0
    zero = t_zero
    for j in range(3):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    finite = zero <= 0.0
    bad = not finite
    if bad:
        for j2 in range(3):
            u[j2] = 0.0
        return BAD_INPUT, tuple(u)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    outside = False
    for i in range(3):
        pair = i * 2
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 6
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 12
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 18
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 7
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 13
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 19
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
        x_i = x[i]
        room = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        nearest = to_upper if upper_nearer else to_lower
        gain = -0.5 if upper_nearer else 0.5
        least = room * 0.005
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
    x = _vector("x", x, 3)
    t_zero = t * 0.0
    zero = t_zero
    for j in range(3):
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
    for i in range(3):
        pair = i * 2
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 6
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 12
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 18
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 7
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 13
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 19
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
        least = width * 0.005
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
        e_held_above = -0.99 < e_raw
        e_held_raised = e_raw if e_held_above else -0.99
        e_held_over = 0.99 < e_held_raised
        e_held = 0.99 if e_held_over else e_held_raised
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
