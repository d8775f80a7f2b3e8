"""attitude: prescribed-time reach-avoid-stay controller, refined tube.

Certified (attitude.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
at rest in it; gamma(0) is in the certificate.
The state stays in it (P9) sampled every 0.06 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
w| <= [0.045, 0.03, 0.04], 0.91 <= g_ii <= 1.09, |g_ij| <= [0.1, 0.03, 0.035], x measured to 0.0005, v measured to
0.0005: |e| of v + lambda x < [0.9021, 0.8401, 0.8667], |u| <= [0.09, 0.06, 0.08].

The same functions as attitude.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 3 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 3
T_C = 60.0  # prescribed time, seconds
SHARE = 0.7999999523162842  # 0.8, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "fa97e27d21c0d12f"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]
# Multiples of 2^-22: exact in float and double.
COEFFICIENTS = (
    -0.01666402816772461, 0.01666402816772461, -0.08289361000061035, -0.04956531524658203,
    -0.1828937530517578, -0.1495654582977295,
    -0.01666402816772461, 0.01666402816772461, -0.08354926109313965, -0.05022120475769043,
    -0.1835494041442871, -0.1502211093902588,
    -0.01666402816772461, 0.01666402816772461, -0.08289361000061035, -0.04956531524658203,
    -0.1828937530517578, -0.1495654582977295,
    -0.01666402816772461, 0.01666402816772461, -0.08092665672302246, -0.04759836196899414,
    -0.18092679977416992, -0.1475985050201416,
    -0.01666402816772461, 0.01666402816772461, -0.07764816284179688, -0.044319868087768555,
    -0.17764830589294434, -0.14432001113891602,
    -0.01666402816772461, 0.01666402816772461, -0.0730583667755127, -0.03973031044006348,
    -0.17305874824523926, -0.13973045349121094,
    -0.01666402816772461, 0.01666402816772461, -0.06715726852416992, -0.0338289737701416,
    -0.16715764999389648, -0.13382935523986816,
    -0.01666402816772461, 0.01666402816772461, -0.059944868087768555, -0.026616573333740234,
    -0.15994501113891602, -0.1266169548034668,
    -0.01666402816772461, 0.01666402816772461, -0.05142092704772949, -0.018092632293701172,
    -0.15142130851745605, -0.11809301376342773,
    -0.01666402816772461, 0.01666402816772461, -0.041585683822631836, -0.008257389068603516,
    -0.1415860652923584, -0.10825777053833008,
    -0.01666402816772461, 0.01666402816772461, -0.030439138412475586, 0.0028891563415527344,
    -0.13043951988220215, -0.09711122512817383,
    -0.01666402816772461, 0.01666402816772461, -0.017981290817260742, 0.015347003936767578,
    -0.1179816722869873, -0.08465337753295898,
    -0.01666402816772461, 0.01666402816772461, -0.0043447017669677734, 0.028983592987060547,
    -0.10421252250671387, -0.07088422775268555,
    -0.01666402816772461, 0.01666402816772461, 0.009126424789428711, 0.04245471954345703,
    -0.08913183212280273, -0.055803537368774414,
    -0.01666402816772461, 0.01666402816772461, 0.0212862491607666, 0.05461454391479492,
    -0.07273983955383301, -0.03941154479980469,
    -0.01666402816772461, 0.01666402816772461, 0.0321347713470459, 0.06546282768249512,
    -0.05503654479980469, -0.021708250045776367,
    -0.01666402816772461, 0.01666402816772461, 0.0416717529296875, 0.07500004768371582,
    -0.03602170944213867, -0.0026934146881103516,
    -0.01666402816772461, 0.01666402816772461, 0.04989743232727051, 0.08322572708129883,
    -0.015695571899414062, 0.017632484436035156,
    -0.01666402816772461, 0.01666402816772461, 0.05681180953979492, 0.09014010429382324,
    0.0039746761322021484, 0.03730297088623047,
    -0.01666402816772461, 0.01666402816772461, 0.06241488456726074, 0.09574294090270996,
    0.022333860397338867, 0.05566215515136719,
    -0.01666402816772461, 0.01666402816772461, 0.06670641899108887, 0.10003471374511719,
    0.03938150405883789, 0.07270979881286621,
    -0.01666402816772461, 0.01666402816772461, 0.0696866512298584, 0.10301494598388672,
    0.05511784553527832, 0.08844614028930664,
    -0.01666402816772461, 0.01666402816772461, 0.07135558128356934, 0.10468387603759766,
    0.06954288482666016, 0.10287117958068848,
    -0.01666402816772461, 0.01666402816772461, 0.07171297073364258, 0.1050412654876709,
    0.0826566219329834, 0.11598491668701172,
    -0.01666402816772461, 0.01666402816772461, 0.07075929641723633, 0.10408759117126465,
    0.09445881843566895, 0.12778711318969727,
    -0.01666402816772461, 0.01666402816772461, 0.06849408149719238, 0.1018223762512207,
    0.1049497127532959, 0.13827800750732422,
    -0.01666402816772461, 0.01666402816772461, 0.06491756439208984, 0.09824562072753906,
    0.11412930488586426, 0.14745759963989258,
    -0.01666402816772461, 0.01666402816772461, 0.06002950668334961, 0.09335780143737793,
    0.12199759483337402, 0.15532565116882324,
    -0.01666402816772461, 0.01666402816772461, 0.05478405952453613, 0.08811235427856445,
    0.1285543441772461, 0.16188263893127441,
    -0.01666402816772461, 0.01666402816772461, 0.049538612365722656, 0.08286690711975098,
    0.13379979133605957, 0.1671280860900879,
    -0.01666402816772461, 0.01666402816772461, 0.04560446739196777, 0.0789327621459961,
    0.13773393630981445, 0.17106199264526367,
    -0.01666402816772461, 0.01666402816772461, 0.042981863021850586, 0.0763101577758789,
    0.14035654067993164, 0.17368483543395996,
    -0.01666402816772461, 0.01666402816772461, 0.04167056083679199, 0.07499861717224121,
    0.14166784286499023, 0.17499613761901855,
    -0.01666402816772461, 0.01666402816772461, 0.04167056083679199, 0.07499861717224121,
    0.14166784286499023, 0.17499613761901855,
    -0.01666402816772461, 0.01666402816772461, 0.04167056083679199, 0.07499861717224121,
    0.14166784286499023, 0.17499613761901855,
)

# Gain k of the control law, by component.
GAIN = (
    0.00011999999696854502, 0.0000779999973019585, 0.00009770000178832561,
)

# Saturation of u, by component.
U_MAX = (
    0.08999999612569809, 0.05999999865889549, 0.07999999821186066,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    -0.0794871374964714, -0.47948718070983887, -1.079487919807434,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    0.0794871374964714, -0.3205125331878662, -0.9205125570297241,
)

# The same of v + lambda x: strictly above these bounds.
FILTERED_START_LOWER = (
    -0.00903838500380516, -0.05703837797045708, -0.12903843820095062,
)

# The same of v + lambda x: strictly below these bounds.
FILTERED_START_UPPER = (
    0.00903838500380516, -0.038961585611104965, -0.11096160113811493,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _segment(t):
    """Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 32 (t_c = 60 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 0.5333333611488342
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
    moving = t < 60.0
    per_second = 0.5333333611488342 if moving else 0.0
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
    """Edges of the filtered tube at time t, in units per second: of v + lambda x, lambda = 0.119999997.
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
        lower_rate = lower_slope * 0.5333333611488342
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 0.5333333611488342
        lower_part = lower_edge * 0.11999999731779099
        z_lower = lower_rate + lower_part
        lower[i] = z_lower
        upper_part = upper_edge * 0.11999999731779099
        z_upper = upper_rate + upper_part
        upper[i] = z_upper
    return tuple(lower), tuple(upper)


def control(t, x, v):
    """Control law (13), u = -k xi epsilon, k = [0.00012, 7.8e-05, 9.77e-05], e clamped to [-0.99, 0.99] by component, u saturated.
    for v + lambda x in its tube, lambda = 0.119999997. t: seconds since the start (held within [0, t_c]);
    x: state; v: its rate; u: input.
    x by component: roll [rad], pitch [rad], yaw [rad].
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
        lower_rate = lower_slope * 0.5333333611488342
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 0.5333333611488342
        x_i = x[i]
        v_i = v[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_width = upper_rate - lower_rate
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        gain_i = GAIN[i]
        gain_minus = -gain_i
        width_part = width * 0.11999999731779099
        z_width = v_width + width_part
        lower_part = to_lower * 0.11999999731779099
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * 0.11999999731779099
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
        lower_rate = lower_slope * 0.5333333611488342
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 0.5333333611488342
        x_i = x[i]
        v_i = v[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_width = upper_rate - lower_rate
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        width_part = width * 0.11999999731779099
        z_width = v_width + width_part
        lower_part = to_lower * 0.11999999731779099
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * 0.11999999731779099
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
        lower_rate = lower_slope * 0.5333333611488342
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 0.5333333611488342
        x_i = x[i]
        v_i = v[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_width = upper_rate - lower_rate
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        width_part = width * 0.11999999731779099
        z_width = v_width + width_part
        lower_part = to_lower * 0.11999999731779099
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * 0.11999999731779099
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
        x_part = x_i * 0.11999999731779099
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
