"""either: prescribed-time reach-avoid-stay controller, refined tube.

Certified (either.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
Every x(t) that stays in the tube satisfies the mission (P10): eventually[8, 9.5] (T1 or T2); times are seconds of
t. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.000274 s.

The same functions as either.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 18.0  # prescribed time, seconds
SHARE = 0.9899999499320984  # 0.99, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "37a6b5f9eebbc011"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 64 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-18: exact in float and double.
COEFFICIENTS = (
    0.6145744323730469, 0.7872200012207031, 0.6447334289550781, 0.8173789978027344,
    0.6667060852050781, 0.8332939147949219, 0.6667060852050781, 0.8332939147949219,
    0.7188377380371094, 0.8793678283691406, 0.6886787414550781, 0.8492088317871094,
    0.7709732055664062, 0.9254417419433594, 0.7106552124023438, 0.8651237487792969,
    0.8231048583984375, 0.9715156555175781, 0.7326278686523438, 0.8810386657714844,
    0.8752365112304688, 1.0175895690917969, 0.7546005249023438, 0.8969535827636719,
    0.9273681640625, 1.0636634826660156, 0.7765731811523438, 0.9128684997558594,
    0.9794998168945312, 1.1097373962402344, 0.7985458374023438, 0.9287872314453125,
    1.0316314697265625, 1.1558151245117188, 0.8205184936523438, 0.9447021484375,
    1.0837631225585938, 1.2018890380859375, 0.8424911499023438, 0.9606170654296875,
    1.135894775390625, 1.2479629516601562, 0.8644638061523438, 0.976531982421875,
    1.1880264282226562, 1.294036865234375, 0.8864402770996094, 0.9924468994140625,
    1.2401618957519531, 1.3401107788085938, 0.9084129333496094, 1.00836181640625,
    1.2922935485839844, 1.392242431640625, 0.9303855895996094, 1.03033447265625,
    1.3444252014160156, 1.4443740844726562, 0.9523582458496094, 1.05230712890625,
    1.3965568542480469, 1.4965095520019531, 0.9743309020996094, 1.0742835998535156,
    1.4486885070800781, 1.5486412048339844, 0.9963035583496094, 1.0962562561035156,
    1.5008201599121094, 1.6007728576660156, 1.0182762145996094, 1.1182289123535156,
    1.5529518127441406, 1.6529045104980469, 1.0402488708496094, 1.1402015686035156,
    1.6050834655761719, 1.7050361633300781, 1.0622215270996094, 1.1621742248535156,
    1.6572151184082031, 1.7571678161621094, 1.084197998046875, 1.1841468811035156,
    1.7093505859375, 1.8092994689941406, 1.106170654296875, 1.2061195373535156,
    1.7614822387695312, 1.8614311218261719, 1.128143310546875, 1.2280921936035156,
    1.8136138916015625, 1.9135627746582031, 1.150115966796875, 1.2500686645507812,
    1.8657455444335938, 1.9656982421875, 1.172088623046875, 1.2720413208007812,
    1.917877197265625, 2.0178298950195312, 1.194061279296875, 1.2940139770507812,
    1.9700088500976562, 2.0699615478515625, 1.216033935546875, 1.3159866333007812,
    2.0221405029296875, 2.1220932006835938, 1.238006591796875, 1.3379592895507812,
    2.0742721557617188, 2.174224853515625, 1.2599830627441406, 1.3599319458007812,
    2.1264076232910156, 2.2263565063476562, 1.2819557189941406, 1.3819046020507812,
    2.178539276123047, 2.2784881591796875, 1.3039283752441406, 1.4038772583007812,
    2.230670928955078, 2.3306198120117188, 1.3259010314941406, 1.4258499145507812,
    2.2828025817871094, 2.38275146484375, 1.3478736877441406, 1.4478263854980469,
    2.3349342346191406, 2.434886932373047, 1.3984489440917969, 1.4984016418457031,
    2.387054443359375, 2.4870071411132812, 1.4490242004394531, 1.5489768981933594,
    2.38702392578125, 2.4869766235351562, 1.499603271484375, 1.5995521545410156,
    2.386993408203125, 2.4869461059570312, 1.5501785278320312, 1.6501274108886719,
    2.386962890625, 2.4869155883789062, 1.6007537841796875, 1.7007064819335938,
    2.386932373046875, 2.4868850708007812, 1.6513290405273438, 1.75128173828125,
    2.38690185546875, 2.4868545532226562, 1.701904296875, 1.8018569946289062,
    2.386871337890625, 2.4868240356445312, 1.7524833679199219, 1.8524322509765625,
    2.3868408203125, 2.4867935180664062, 1.8030586242675781, 1.9030075073242188,
    2.386810302734375, 2.4867591857910156, 1.8536338806152344, 1.953582763671875,
    2.38677978515625, 2.4867286682128906, 1.9042091369628906, 2.004161834716797,
    2.386749267578125, 2.4866981506347656, 1.9547843933105469, 2.054737091064453,
    2.38671875, 2.4866676330566406, 2.005359649658203, 2.1053123474121094,
    2.386688232421875, 2.4866371154785156, 2.055938720703125, 2.1558876037597656,
    2.38665771484375, 2.4866065979003906, 2.1065139770507812, 2.206462860107422,
    2.386627197265625, 2.4865760803222656, 2.1570892333984375, 2.2570419311523438,
    2.3865928649902344, 2.4865455627441406, 2.2076644897460938, 2.3076171875,
    2.3865623474121094, 2.4865150451660156, 2.25823974609375, 2.3581924438476562,
    2.3865318298339844, 2.4864845275878906, 2.308818817138672, 2.4087677001953125,
    2.3865013122558594, 2.4864540100097656, 2.359394073486328, 2.4593429565429688,
    2.4376296997070312, 2.537578582763672, 2.4099693298339844, 2.5099220275878906,
    2.4887542724609375, 2.5887069702148438, 2.4605445861816406, 2.560497283935547,
    2.5398826599121094, 2.63983154296875, 2.511119842529297, 2.611072540283203,
    2.5910072326660156, 2.690959930419922, 2.561695098876953, 2.6616477966308594,
    2.6421356201171875, 2.742084503173828, 2.612274169921875, 2.7122230529785156,
    2.6932601928710938, 2.793212890625, 2.6628494262695312, 2.762798309326172,
    2.7443885803222656, 2.8443374633789062, 2.7134246826171875, 2.8133773803710938,
    2.795513153076172, 2.895465850830078, 2.7639999389648438, 2.86395263671875,
    2.8466415405273438, 2.9465904235839844, 2.8145751953125, 2.9145278930664062,
    2.89776611328125, 2.9977188110351562, 2.865154266357422, 2.9651031494140625,
    2.948894500732422, 3.0488433837890625, 2.915729522705078, 3.0156784057617188,
    3.000019073486328, 3.0999717712402344, 2.9663047790527344, 3.0662574768066406,
    3.000019073486328, 3.0999717712402344, 3.0168800354003906, 3.1168289184570312,
    3.000019073486328, 3.0999717712402344, 2.9663047790527344, 3.0662574768066406,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    4.005236625671387, 4.005236625671387,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    4.994763374328613, 4.994763374328613,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _segment(t):
    """Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 64 (t_c = 18 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 3.555555582046509
    early = scaled < 63.999996185302734
    u = scaled if early else 63.999996185302734
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
    moving = t < 18.0
    per_second = 3.555555582046509 if moving else 0.0
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
    """The entry of the mission that is being served at time t, from 1; 0 once all are done. See either.h."""
    if t < 9.000274658203125:
        return 1
    return 0
