"""rover: prescribed-time reach-avoid-stay controller, refined tube.

Certified (rover.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
The state stays in it (P9) sampled every 0.02 s or faster, from every start with |e(0)| <= 0.9, for |f + w| <= 0.1,
0.99 <= g_ii <= 1.01, |g_ij| <= 0.1, x measured to 0.005, u acts at most 0.002 s after its sample: |e| < [0.9119,
0.9105], |u| <= 0.8.

The same functions as rover.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 20.0  # prescribed time, seconds
SHARE = 0.8999999761581421  # 0.9, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "fd3d315be19c6b65"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    0.09821891784667969, 0.1688232421875, 0.08110618591308594, 0.15057945251464844,
    0.11667728424072266, 0.18332290649414062, 0.11667728424072266, 0.18332290649414062,
    0.13513469696044922, 0.19782352447509766, 0.15224742889404297, 0.21606731414794922,
    0.15359210968017578, 0.2123241424560547, 0.1878185272216797, 0.2488117218017578,
    0.17204952239990234, 0.22682476043701172, 0.223388671875, 0.2815561294555664,
    0.1905069351196289, 0.24132442474365234, 0.2589597702026367, 0.3142995834350586,
    0.20896434783935547, 0.2558250427246094, 0.29452991485595703, 0.3470439910888672,
    0.2375478744506836, 0.2844085693359375, 0.33010101318359375, 0.3797883987426758,
    0.2731180191040039, 0.3199787139892578, 0.36567211151123047, 0.4125328063964844,
    0.3086891174316406, 0.35554981231689453, 0.3942546844482422, 0.4411153793334961,
    0.34426021575927734, 0.39112091064453125, 0.39008331298828125, 0.43694400787353516,
    0.37983036041259766, 0.42669105529785156, 0.3859109878540039, 0.4327716827392578,
    0.4154014587402344, 0.4622621536254883, 0.38173866271972656, 0.42859935760498047,
    0.4509716033935547, 0.4978322982788086, 0.3775663375854492, 0.4244270324707031,
    0.4865427017211914, 0.5334033966064453, 0.370452880859375, 0.4173135757446289,
    0.5221128463745117, 0.5689735412597656, 0.3633384704589844, 0.4101991653442383,
    0.5576839447021484, 0.6045446395874023, 0.35622406005859375, 0.40308475494384766,
    0.5932550430297852, 0.6401157379150391, 0.3484821319580078, 0.3953428268432617,
    0.6288251876831055, 0.6756858825683594, 0.3386507034301758, 0.3855113983154297,
    0.6643962860107422, 0.7112569808959961, 0.32881832122802734, 0.37567901611328125,
    0.6999664306640625, 0.7468271255493164, 0.3189868927001953, 0.3658475875854492,
    0.7355375289916992, 0.7823982238769531, 0.3091554641723633, 0.3560161590576172,
    0.7711076736450195, 0.8179683685302734, 0.29932308197021484, 0.34618377685546875,
    0.8066787719726562, 0.8535394668579102, 0.2894916534423828, 0.3363523483276367,
    0.8422489166259766, 0.8891096115112305, 0.3250589370727539, 0.3719196319580078,
    0.8778200149536133, 0.9246807098388672, 0.3606300354003906, 0.40749073028564453,
    0.91339111328125, 0.9602518081665039, 0.39620018005371094, 0.44306087493896484,
    0.9489612579345703, 0.9958219528198242, 0.43177127838134766, 0.47863197326660156,
    0.984532356262207, 1.031393051147461, 0.46734142303466797, 0.5142021179199219,
    0.9962882995605469, 1.0431489944458008, 0.5029125213623047, 0.5497732162475586,
    1.0080442428588867, 1.0549049377441406, 0.5384836196899414, 0.5853443145751953,
    1.019801139831543, 1.0666618347167969, 0.5740537643432617, 0.6209144592285156,
    1.019801139831543, 1.0666618347167969, 0.6096248626708984, 0.6564855575561523,
    1.019801139831543, 1.0666618347167969, 0.6451950073242188, 0.6920557022094727,
    1.019801139831543, 1.0666618347167969, 0.6096248626708984, 0.6564855575561523,
)

# Gain k of the control law, by component.
GAIN = (
    0.010900000110268593, 0.01549999974668026,
)

# Saturation of u, by component.
U_MAX = (
    0.7999999523162842, 0.7999999523162842,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    0.7250574231147766, 0.7250574231147766,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    1.0749436616897583, 1.0749436616897583,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _segment(t):
    """Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 32 (t_c = 20 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 1.600000023841858
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
    moving = t < 20.0
    per_second = 1.600000023841858 if moving else 0.0
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
    """Control law (13), u = -k xi epsilon, k = [0.0109, 0.0155], e clamped to [-0.99, 0.99] by component, u saturated.
    t: seconds since the start (held within [0, t_c]); x: state; u: input.
    x by component: x [m], y [m].
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
