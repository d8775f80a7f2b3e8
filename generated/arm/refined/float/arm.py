"""arm: prescribed-time reach-avoid-stay controller, refined tube.

Certified (arm.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
at rest in it; gamma(0) is in the certificate.
The state stays in it (P9) sampled every 0.006 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
w| <= [1.3, 3.1], [0.92, 0.7] <= g_ii <= [1.08, 1.32], |g_ij| <= [0.06, 0.56]: |e| of v + lambda x < [0.8023,
0.8669], |u| <= [2.2, 6.8].

The same functions as arm.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 14.0  # prescribed time, seconds
SHARE = 0.7999999523162842  # 0.8, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "773ceca581c572bc"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-21: exact in float and double.
COEFFICIENTS = (
    -0.1912245750427246, -0.1412343978881836, 0.10855436325073242, 0.15854406356811523,
    -0.1918802261352539, -0.1418905258178711, 0.1082305908203125, 0.1582202911376953,
    -0.1912245750427246, -0.1412343978881836, 0.10855436325073242, 0.15854406356811523,
    -0.18925762176513672, -0.1392674446105957, 0.1095266342163086, 0.1595163345336914,
    -0.18597888946533203, -0.13598918914794922, 0.11114692687988281, 0.16113662719726562,
    -0.18138933181762695, -0.13139963150024414, 0.11341524124145508, 0.1634054183959961,
    -0.17548799514770508, -0.12549829483032227, 0.1163320541381836, 0.1663217544555664,
    -0.1682758331298828, -0.1182856559753418, 0.11989641189575195, 0.16988658905029297,
    -0.15975189208984375, -0.10976219177246094, 0.12410926818847656, 0.17409896850585938,
    -0.1499166488647461, -0.09992694854736328, 0.12897014617919922, 0.17895984649658203,
    -0.13877010345458984, -0.08878040313720703, 0.13447904586791992, 0.18446922302246094,
    -0.126312255859375, -0.07632207870483398, 0.14063644409179688, 0.1906261444091797,
    -0.11254262924194336, -0.06255292892456055, 0.14744186401367188, 0.1974315643310547,
    -0.09746217727661133, -0.047472476959228516, 0.15489482879638672, 0.20488500595092773,
    -0.0810699462890625, -0.031080245971679688, 0.1629934310913086, 0.2129836082458496,
    -0.06336688995361328, -0.013376712799072266, 0.17044401168823242, 0.22043371200561523,
    -0.044352054595947266, 0.005637645721435547, 0.17789459228515625, 0.22788429260253906,
    -0.024027347564697266, 0.025962352752685547, 0.18534517288208008, 0.2353348731994629,
    -0.004356861114501953, 0.04563283920288086, 0.19214725494384766, 0.24213743209838867,
    0.014001846313476562, 0.06399202346801758, 0.19894981384277344, 0.24893951416015625,
    0.031049728393554688, 0.0810394287109375, 0.20548629760742188, 0.2554764747619629,
    0.046785831451416016, 0.09677600860595703, 0.21202325820922852, 0.26201295852661133,
    0.06121110916137695, 0.11120080947875977, 0.2179117202758789, 0.2679014205932617,
    0.0743246078491211, 0.1243143081665039, 0.2238001823425293, 0.2737903594970703,
    0.08612680435180664, 0.13611650466918945, 0.22904062271118164, 0.27903079986572266,
    0.0966176986694336, 0.1466073989868164, 0.23363304138183594, 0.28362274169921875,
    0.10579729080200195, 0.15578699111938477, 0.2375774383544922, 0.287567138671875,
    0.11366558074951172, 0.16365528106689453, 0.2408733367919922, 0.290863037109375,
    0.12022209167480469, 0.1702122688293457, 0.24352121353149414, 0.29351139068603516,
    0.12546777725219727, 0.17545747756958008, 0.24611377716064453, 0.29610347747802734,
    0.12940168380737305, 0.17939138412475586, 0.24805831909179688, 0.2980480194091797,
    0.13202428817749023, 0.18201446533203125, 0.24935436248779297, 0.2993440628051758,
    0.13333606719970703, 0.18332576751708984, 0.250002384185791, 0.29999256134033203,
    0.13333606719970703, 0.18332576751708984, 0.250002384185791, 0.29999256134033203,
    0.13333606719970703, 0.18332576751708984, 0.250002384185791, 0.29999256134033203,
)

# Gain k of the control law, by component.
GAIN = (
    0.026799999177455902, 0.08429999649524689,
)

# Saturation of u, by component.
U_MAX = (
    2.1999998092651367, 6.799999713897705,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    -1.1199758052825928, 0.6800252199172974,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    -0.8800251483917236, 0.9199751615524292,
)

# The same of v + lambda x: strictly above these bounds.
FILTERED_START_LOWER = (
    -0.6719847917556763, 0.4080158472061157,
)

# The same of v + lambda x: strictly below these bounds.
FILTERED_START_UPPER = (
    -0.5280158519744873, 0.5519843697547913,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _segment(t):
    """Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 32 (t_c = 14 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 2.2857143878936768
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
    moving = t < 14.0
    per_second = 2.2857143878936768 if moving else 0.0
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


def filtered_tube(t):
    """Edges of the filtered tube at time t, in units per second: of v + lambda x, lambda = 0.600000024.
    While v + lambda x is between them, x stays in the tube. NaN when t is not finite.
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
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 2.2857143878936768
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 2.2857143878936768
        lower_part = lower_edge * 0.6000000238418579
        z_lower = lower_rate + lower_part
        lower[i] = z_lower
        upper_part = upper_edge * 0.6000000238418579
        z_upper = upper_rate + upper_part
        upper[i] = z_upper
    return tuple(lower), tuple(upper)


def control(t, x, v):
    """Control law (13), u = -k xi epsilon, k = [0.0268, 0.0843], e clamped to [-0.99, 0.99] by component, u saturated.
    for v + lambda x in its tube, lambda = 0.600000024. t: seconds since the start (held within [0, t_c]);
    x: state; v: its rate; u: input.
    x by component: shoulder [rad], elbow [rad].
    OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law,
    finite, and points inward (0 where the tube is empty). BAD_INPUT: t, x or v has a NaN or an
    infinity; u is 0. u may be the array x or v itself.
    """
    t = float(t)
    x = _vector("x", x, 2)
    v = _vector("v", v, 2)
    u = [0.0] * 2
    t_zero = t * 0.0
    zero = t_zero
    for j in range(2):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    v_zeros = zero
    for k in range(2):
        v_k = v[k]
        v_zero = v_k * 0.0
        v_sum = v_zeros + v_zero
        v_zeros = v_sum
    finite = v_zeros <= 0.0
    bad = not finite
    if bad:
        for m in range(2):
            u[m] = 0.0
        return BAD_INPUT, tuple(u)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    outside = False
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 2.2857143878936768
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 2.2857143878936768
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
        width_part = width * 0.6000000238418579
        z_width = v_width + width_part
        lower_part = to_lower * 0.6000000238418579
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * 0.6000000238418579
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
    x = _vector("x", x, 2)
    v = _vector("v", v, 2)
    t_zero = t * 0.0
    zero = t_zero
    for j in range(2):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    v_zeros = zero
    for k in range(2):
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
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 2.2857143878936768
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 2.2857143878936768
        x_i = x[i]
        v_i = v[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_width = upper_rate - lower_rate
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        width_part = width * 0.6000000238418579
        z_width = v_width + width_part
        lower_part = to_lower * 0.6000000238418579
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * 0.6000000238418579
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
    x = _vector("x", x, 2)
    v = _vector("v", v, 2)
    margin = [0.0] * 2
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(2):
            margin[j] = math.nan
        return tuple(margin)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 2.2857143878936768
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 2.2857143878936768
        x_i = x[i]
        v_i = v[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_width = upper_rate - lower_rate
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        width_part = width * 0.6000000238418579
        z_width = v_width + width_part
        lower_part = to_lower * 0.6000000238418579
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * 0.6000000238418579
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
    What a measurement may be wrong by (rounding) is taken off.
    Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
    from where it stands. False for a NaN.
    """
    x = _vector("x", x, 2)
    v = _vector("v", v, 2)
    covered = True
    for i in range(2):
        x_i = x[i]
        x_lower = START_LOWER[i]
        x_upper = START_UPPER[i]
        x_above = x_lower < x_i
        x_below = x_i < x_upper
        x_inside = x_above and x_below
        x_part = x_i * 0.6000000238418579
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
