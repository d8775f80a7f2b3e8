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
SHARE = 0.9899999499320984  # 0.99, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "dc61a40ca017e859"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]
# Multiples of 2^-21: exact in float and double.
COEFFICIENTS = (
    -0.019896507263183594, 0.0800929069519043, -0.006716251373291016, 0.09327363967895508,
    0.055092811584472656, 0.15508270263671875,
    5.245208740234375e-6, 0.09999513626098633, 5.245208740234375e-6, 0.09999513626098633,
    0.06667184829711914, 0.16666173934936523,
    0.019906997680664062, 0.11989688873291016, 0.006726264953613281, 0.10671615600585938,
    0.07825040817260742, 0.17824029922485352,
    0.03980875015258789, 0.13979864120483398, 0.013447761535644531, 0.11343765258789062,
    0.0898294448852539, 0.1898193359375,
    0.05971050262451172, 0.1597003936767578, 0.020168781280517578, 0.12015867233276367,
    0.10140848159790039, 0.20139837265014648,
    0.07961225509643555, 0.17960214614868164, 0.026890277862548828, 0.12688016891479492,
    0.11298704147338867, 0.21297693252563477,
    0.09951400756835938, 0.19950389862060547, 0.03361177444458008, 0.13360118865966797,
    0.12456607818603516, 0.22455596923828125,
    0.1194157600402832, 0.2194056510925293, 0.040332794189453125, 0.14032268524169922,
    0.13614511489868164, 0.23613500595092773,
    0.13931798934936523, 0.23930740356445312, 0.047054290771484375, 0.14704418182373047,
    0.14772367477416992, 0.24771356582641602,
    0.15921974182128906, 0.25920963287353516, 0.05377531051635742, 0.15376520156860352,
    0.1593027114868164, 0.2592926025390625,
    0.1791214942932129, 0.279111385345459, 0.06049680709838867, 0.16048669815063477,
    0.1708817481994629, 0.270871639251709,
    0.19902324676513672, 0.2990131378173828, 0.06721782684326172, 0.1672077178955078,
    0.18246030807495117, 0.28245019912719727,
    0.21892499923706055, 0.31891489028930664, 0.07393932342529297, 0.17392921447753906,
    0.19403934478759766, 0.29402923583984375,
    0.23882675170898438, 0.33881664276123047, 0.08066082000732422, 0.1806507110595703,
    0.20561838150024414, 0.30560827255249023,
    0.2587285041809082, 0.3587183952331543, 0.08738183975219727, 0.18737173080444336,
    0.21719694137573242, 0.3171868324279785,
    0.27863025665283203, 0.3786201477050781, 0.09410333633422852, 0.1940932273864746,
    0.2287759780883789, 0.328765869140625,
    0.29853248596191406, 0.39852190017700195, 0.10082435607910156, 0.20081424713134766,
    0.2403550148010254, 0.3403449058532715,
    0.3184342384338379, 0.418424129486084, 0.10754585266113281, 0.2075357437133789,
    0.25193357467651367, 0.35192346572875977,
    0.3383359909057617, 0.4383258819580078, 0.1283411979675293, 0.2283306121826172,
    0.26351261138916016, 0.36350250244140625,
    0.35823774337768555, 0.45822763442993164, 0.14913606643676758, 0.24912595748901367,
    0.27509164810180664, 0.37508153915405273,
    0.3770136833190918, 0.4770030975341797, 0.16993141174316406, 0.26992082595825195,
    0.2866702079772949, 0.386660099029541,
    0.39578914642333984, 0.49577903747558594, 0.19072628021240234, 0.29071617126464844,
    0.2982492446899414, 0.3982391357421875,
    0.4145650863647461, 0.5145549774169922, 0.21152162551879883, 0.3115110397338867,
    0.3098282814025879, 0.4098176956176758,
    0.43334102630615234, 0.5333309173583984, 0.2323164939880371, 0.3323063850402832,
    0.32140684127807617, 0.42139673233032227,
    0.43334102630615234, 0.5333309173583984, 0.2531118392944336, 0.3531012535095215,
    0.33298587799072266, 0.43297576904296875,
    0.43334102630615234, 0.5333309173583984, 0.2739067077636719, 0.37389659881591797,
    0.34456491470336914, 0.44455432891845703,
    0.43334102630615234, 0.5333309173583984, 0.29470205307006836, 0.39469146728515625,
    0.3561434745788574, 0.4561333656311035,
    0.43334102630615234, 0.5333309173583984, 0.31549692153930664, 0.41548681259155273,
    0.3677225112915039, 0.46771240234375,
    0.43334102630615234, 0.5333309173583984, 0.3362922668457031, 0.4362821578979492,
    0.3793015480041504, 0.4792909622192383,
    0.43334102630615234, 0.5333309173583984, 0.3570871353149414, 0.4570770263671875,
    0.39088010787963867, 0.49086999893188477,
    0.43334102630615234, 0.5333309173583984, 0.3778824806213379, 0.477872371673584,
    0.40245914459228516, 0.5024490356445312,
    0.43334102630615234, 0.5333309173583984, 0.39867734909057617, 0.49866724014282227,
    0.41403818130493164, 0.5140275955200195,
    0.43334102630615234, 0.5333309173583984, 0.41947269439697266, 0.5194625854492188,
    0.4256167411804199, 0.525606632232666,
    0.43334102630615234, 0.5333309173583984, 0.44026756286621094, 0.540257453918457,
    0.4371953010559082, 0.5371851921081543,
    0.43334102630615234, 0.5333309173583984, 0.41947269439697266, 0.5194625854492188,
    0.4256167411804199, 0.525606632232666,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    0.0030315471813082695, 0.003031072672456503, 0.4030306935310364,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    0.59697026014328, 0.59697026014328, 0.9969698786735535,
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
    moving = t < 15.0
    per_second = 2.133333444595337 if moving else 0.0
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
        for m in range(3):
            u[m] = 0.0
        return BAD_INPUT, tuple(u)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    outside = False
    for i in range(3):
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
    x = _vector("x", x, 3)
    margin = [0.0] * 3
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(3):
            margin[j] = math.nan
        return tuple(margin)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    for i in range(3):
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
    x = _vector("x", x, 3)
    covered = True
    for i in range(3):
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
