"""omni_heading: prescribed-time reach-avoid-stay controller, refined tube.

Certified (omni_heading.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.

The same functions as omni_heading.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 3 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 3
T_C = 9.0  # prescribed time, seconds
DESIGN_HASH = "e36f846ba61629dd"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    0.0, 0.08331298828125, -0.03641796112060547, 0.04689502716064453,
    -0.016656875610351562, 0.016656875610351562,
    0.00001430511474609375, 0.0833272933959961, 0.00001049041748046875, 0.08332347869873047,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.08331775665283203, 0.03643798828125, 0.1197509765625,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.08331775665283203, 0.07286548614501953, 0.15617847442626953,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.08331775665283203, 0.10929393768310547, 0.19260692596435547,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.08331775665283203, 0.145721435546875, 0.229034423828125,
    -0.016656875610351562, 0.016656875610351562,
    0.03282451629638672, 0.11613750457763672, 0.18214893341064453, 0.26546192169189453,
    -0.016656875610351562, 0.016656875610351562,
    0.045528411865234375, 0.12884140014648438, 0.21857738494873047, 0.30189037322998047,
    -0.016656875610351562, 0.016656875610351562,
    0.07834815979003906, 0.16166114807128906, 0.2550048828125, 0.33831787109375,
    -0.016656875610351562, 0.016656875610351562,
    0.11116790771484375, 0.19448089599609375, 0.29143333435058594, 0.37474632263183594,
    -0.016656875610351562, 0.016656875610351562,
    0.14398765563964844, 0.22730064392089844, 0.32786083221435547, 0.41117382049560547,
    -0.016656875610351562, 0.016656875610351562,
    0.17680740356445312, 0.2601203918457031, 0.3157176971435547, 0.3990306854248047,
    -0.016656875610351562, 0.016656875610351562,
    0.2096271514892578, 0.2929401397705078, 0.27929019927978516, 0.36260318756103516,
    -0.016656875610351562, 0.016656875610351562,
    0.2424468994140625, 0.3257598876953125, 0.24286270141601562, 0.3261756896972656,
    -0.016656875610351562, 0.016656875610351562,
    0.2752666473388672, 0.3585796356201172, 0.27929019927978516, 0.36260318756103516,
    -0.016656875610351562, 0.016656875610351562,
    0.3080863952636719, 0.3913993835449219, 0.29143333435058594, 0.37474632263183594,
    -0.016656875610351562, 0.016656875610351562,
    0.34090614318847656, 0.42421913146972656, 0.2550048828125, 0.33831787109375,
    -0.016656875610351562, 0.016656875610351562,
    0.37372589111328125, 0.45703887939453125, 0.2550048828125, 0.33831787109375,
    -0.016656875610351562, 0.016656875610351562,
    0.40654563903808594, 0.48985862731933594, 0.2550048828125, 0.33831787109375,
    -0.016656875610351562, 0.016656875610351562,
    0.4393653869628906, 0.5226783752441406, 0.29143333435058594, 0.37474632263183594,
    -0.016656875610351562, 0.016656875610351562,
    0.4721851348876953, 0.5554981231689453, 0.29192066192626953, 0.37523365020751953,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.58831787109375, 0.32834815979003906, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.5378246307373047, 0.6211376190185547, 0.364776611328125, 0.448089599609375,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.58831787109375, 0.3978691101074219, 0.4811820983886719,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.58831787109375, 0.4342975616455078, 0.5176105499267578,
    -0.016656875610351562, 0.016656875610351562,
    0.5378246307373047, 0.6211376190185547, 0.47072505950927734, 0.5540380477905273,
    -0.016656875610351562, 0.016656875610351562,
    0.5312070846557617, 0.6145200729370117, 0.5071525573730469, 0.5904655456542969,
    -0.016656875610351562, 0.016656875610351562,
    0.5640268325805664, 0.6473398208618164, 0.5435810089111328, 0.6268939971923828,
    -0.016656875610351562, 0.016656875610351562,
    0.5968465805053711, 0.6801595687866211, 0.5800085067749023, 0.6633214950561523,
    -0.016656875610351562, 0.016656875610351562,
    0.6296663284301758, 0.7129793167114258, 0.6164360046386719, 0.6997489929199219,
    -0.016656875610351562, 0.016656875610351562,
    0.6624860763549805, 0.7457990646362305, 0.6528644561767578, 0.7361774444580078,
    -0.016656875610351562, 0.016656875610351562,
    0.6953058242797852, 0.7786188125610352, 0.6892919540405273, 0.7726049423217773,
    -0.016656875610351562, 0.016656875610351562,
    0.7281255722045898, 0.8114385604858398, 0.7257194519042969, 0.8090324401855469,
    -0.016656875610351562, 0.016656875610351562,
    0.7609453201293945, 0.8442583084106445, 0.7621479034423828, 0.8454608917236328,
    -0.016656875610351562, 0.016656875610351562,
    0.7281255722045898, 0.8114385604858398, 0.7257194519042969, 0.8090324401855469,
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
    scaled = started * 3.555555582046509
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
    per_second = 3.555555582046509 if moving else 0.0
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
