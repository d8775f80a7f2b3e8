"""spacecraft: prescribed-time reach-avoid-stay controller, refined tube.

Certified (spacecraft.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.

The same functions as spacecraft.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 3 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 3
T_C = 15.0  # prescribed time, seconds
DESIGN_HASH = "d5974d0d5371718e"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]
# Multiples of 2^-21: exact in float and double.
COEFFICIENTS = (
    -0.01691150665283203, 0.08307838439941406, -0.04571390151977539, 0.07713651657104492,
    0.055092811584472656, 0.15508270263671875,
    5.245208740234375e-6, 0.09999513626098633, 0.011435508728027344, 0.09999513626098633,
    0.06667184829711914, 0.16666173934936523,
    0.016921520233154297, 0.11691141128540039, 2.384185791015625e-6, 0.12285327911376953,
    0.07825040817260742, 0.17824029922485352,
    0.03383827209472656, 0.13382816314697266, 2.384185791015625e-6, 0.14571142196655273,
    0.0898294448852539, 0.1898193359375,
    0.050754547119140625, 0.15074443817138672, 2.384185791015625e-6, 0.16856956481933594,
    0.10140848159790039, 0.20139837265014648,
    0.06767129898071289, 0.16766119003295898, 2.384185791015625e-6, 0.19142770767211914,
    0.11298704147338867, 0.21297693252563477,
    0.08458757400512695, 0.18457746505737305, 2.384185791015625e-6, 0.21428585052490234,
    0.12456607818603516, 0.22455596923828125,
    0.10150432586669922, 0.2014942169189453, 2.384185791015625e-6, 0.2283306121826172,
    0.13614511489868164, 0.23613500595092773,
    0.11842107772827148, 0.21841049194335938, 2.384185791015625e-6, 0.2283306121826172,
    0.14772367477416992, 0.24771356582641602,
    0.13533735275268555, 0.23532724380493164, 2.384185791015625e-6, 0.2283306121826172,
    0.1593027114868164, 0.2592926025390625,
    0.1522541046142578, 0.2522439956665039, 2.384185791015625e-6, 0.2283306121826172,
    0.1708817481994629, 0.2708711624145508,
    0.16917037963867188, 0.26916027069091797, 2.384185791015625e-6, 0.2283306121826172,
    0.18246030807495117, 0.28245019912719727,
    0.18608713150024414, 0.28607702255249023, 2.384185791015625e-6, 0.2283306121826172,
    0.19403934478759766, 0.29402923583984375,
    0.2030034065246582, 0.3029932975769043, 2.384185791015625e-6, 0.2283306121826172,
    0.20561838150024414, 0.30560779571533203,
    0.21992015838623047, 0.31991004943847656, 0.006649017333984375, 0.2283306121826172,
    0.21719694137573242, 0.3171868324279785,
    0.23683643341064453, 0.3368263244628906, 0.029507160186767578, 0.2283306121826172,
    0.2287759780883789, 0.328765869140625,
    0.2537531852722168, 0.3537430763244629, 0.05236530303955078, 0.2283306121826172,
    0.2403545379638672, 0.3403444290161133,
    0.27066993713378906, 0.37065935134887695, 0.07522344589233398, 0.2283306121826172,
    0.25193357467651367, 0.35192346572875977,
    0.2875862121582031, 0.3875761032104492, 0.09808206558227539, 0.2283306121826172,
    0.26351261138916016, 0.36350250244140625,
    0.3045029640197754, 0.4044928550720215, 0.1209402084350586, 0.2283306121826172,
    0.27509117126464844, 0.37508106231689453,
    0.32141923904418945, 0.42140913009643555, 0.1437983512878418, 0.20547246932983398,
    0.2866702079772949, 0.386660099029541,
    0.3383359909057617, 0.4383258819580078, 0.166656494140625, 0.2283306121826172,
    0.2982492446899414, 0.3982391357421875,
    0.3552522659301758, 0.4552421569824219, 0.1895146369934082, 0.2511892318725586,
    0.3098278045654297, 0.4098176956176758,
    0.3383359909057617, 0.47215890884399414, 0.2123727798461914, 0.2740473747253418,
    0.32140684127807617, 0.42139673233032227,
    0.3383359909057617, 0.4890751838684082, 0.2352313995361328, 0.296905517578125,
    0.33298587799072266, 0.43297529220581055,
    0.3383359909057617, 0.5059919357299805, 0.258089542388916, 0.3197636604309082,
    0.34456443786621094, 0.44455432891845703,
    0.3383359909057617, 0.5229082107543945, 0.2809476852416992, 0.3426218032836914,
    0.3561434745788574, 0.4561333656311035,
    0.3383359909057617, 0.5333309173583984, 0.3038058280944824, 0.3654799461364746,
    0.3677225112915039, 0.4677119255065918,
    0.35439205169677734, 0.5333309173583984, 0.3266639709472656, 0.388338565826416,
    0.3793010711669922, 0.4792909622192383,
    0.3713083267211914, 0.5333309173583984, 0.34952259063720703, 0.4111967086791992,
    0.39088010787963867, 0.49086999893188477,
    0.38822507858276367, 0.5333309173583984, 0.37238073348999023, 0.4340548515319824,
    0.40245866775512695, 0.502448558807373,
    0.40514183044433594, 0.5333309173583984, 0.39523887634277344, 0.4569129943847656,
    0.41403770446777344, 0.5140275955200195,
    0.42205810546875, 0.5220632553100586, 0.41809701919555664, 0.47977113723754883,
    0.4256167411804199, 0.525606632232666,
    0.43897485733032227, 0.5389642715454102, 0.44095516204833984, 0.5026297569274902,
    0.4371953010559082, 0.5371851921081543,
    0.42205810546875, 0.5220632553100586, 0.41809701919555664, 0.47977113723754883,
    0.4256167411804199, 0.525606632232666,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _segment(t):
    """Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 32 (t_c = 15 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 2.133333444595337
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
    moving = t < 15.0
    per_second = 2.133333444595337 if moving else 0.0
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
