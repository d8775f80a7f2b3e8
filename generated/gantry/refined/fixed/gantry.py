"""gantry: prescribed-time reach-avoid-stay controller, refined tube, in integers.

Certified (gantry.certificate.json): for every t the tube keeps 0.01 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
The state stays in it (P9) sampled at ticks, every 0.01 s or faster, from every start with |e(0)| <= 0.9, for |f +
w| <= 0.02, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 3e-05: |e| < 0.9001, |u| <= 0.6.

The same functions as gantry.c with the same integers, bit for bit; see gantry.h for their units.
Arrays come in as sequences of 2 whole numbers of 32 bits and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

N = 2
T_C = 4  # prescribed time, seconds
TICK_PERIOD = 0.001  # seconds of one tick
TICKS = 4000  # the first tick that is not before t_c
X_BITS = 20  # x counts units of 2^-20
U_BITS = 26  # u counts units of 2^-26
SHARE = 0.8999999999999999  # 0.9, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "a0f9dc15bb115d69"

OK = 0
OUTSIDE_TUBE = 1

# B-spline control points divided by 6, in 2^-20, a row for each of 32 + 3 points.
COEFFICIENTS = (
    51, 31487, -2902, 28534,
    3506, 34942, 3506, 34942,
    6961, 38397, 9913, 41349,
    10415, 41851, 16321, 47757,
    13870, 45306, 22728, 54164,
    17325, 48761, 29136, 60572,
    20779, 52215, 35544, 66979,
    24234, 55670, 41951, 73387,
    27689, 59125, 48359, 79795,
    31143, 62579, 54766, 86202,
    34598, 66034, 61174, 92610,
    38053, 69489, 67581, 99017,
    41507, 72943, 73989, 105425,
    44962, 76398, 80396, 111832,
    51370, 82806, 86803, 118239,
    57777, 89213, 86092, 117527,
    64185, 95621, 85380, 116816,
    70592, 102028, 84668, 116104,
    77000, 108436, 83956, 115392,
    83407, 114843, 83244, 114680,
    89815, 121251, 82532, 113968,
    96222, 127658, 81820, 113256,
    102630, 134066, 81108, 112544,
    109037, 140473, 80396, 111832,
    115445, 146881, 79684, 111120,
    121852, 153288, 78972, 110408,
    128260, 159696, 78260, 109696,
    134667, 166103, 77548, 108984,
    141075, 172511, 76837, 108272,
    147483, 178918, 76125, 107561,
    153890, 185326, 81173, 112609,
    160298, 191734, 87581, 119017,
    166705, 198141, 93989, 125424,
    166705, 198141, 97193, 128629,
    166705, 198141, 93989, 125424,
)

# Quadratics level - (slope - bend t) t, by row: 16 for 1/d, d in [2^30, 2^31), then
# 8 for each octave of y, for H = 4 ln((2 - y)/y)/((1 - y) y (2 - y)).
LEVELS = (
    65535,
    61680,
    58253,
    55187,
    52428,
    49931,
    47662,
    45590,
    43690,
    41942,
    40329,
    38836,
    37449,
    36157,
    34952,
    33824,
    47996,
    43453,
    40084,
    37570,
    35709,
    34368,
    33463,
    32939,
    48578,
    42676,
    38104,
    34475,
    63078,
    58254,
    54239,
    50862,
    54083,
    47061,
    41588,
    37216,
    33653,
    61399,
    56435,
    52211,
    61945,
    53773,
    47386,
    42270,
    38090,
    34617,
    63381,
    58389,
    35589,
    61813,
    54476,
    48588,
    43766,
    39753,
    36366,
    33472,
    40628,
    35334,
    62356,
    55671,
    50189,
    45618,
    41754,
    38448,
    45928,
    40013,
    35361,
    63229,
    57073,
    51933,
    47583,
    43856,
)

SLOPES = (
    8175,
    7244,
    6462,
    5801,
    5236,
    4750,
    4328,
    3960,
    3638,
    3353,
    3100,
    2875,
    2673,
    2492,
    2329,
    2181,
    10462,
    7720,
    5762,
    4297,
    3151,
    2213,
    1410,
    687,
    13374,
    10243,
    8053,
    6465,
    10558,
    8741,
    7319,
    6186,
    15875,
    12226,
    9672,
    7819,
    6435,
    10755,
    9103,
    7790,
    18451,
    14251,
    11303,
    9162,
    7560,
    6333,
    10747,
    9221,
    10561,
    16353,
    13000,
    10558,
    8728,
    7324,
    6225,
    5350,
    11929,
    9256,
    14744,
    11996,
    9934,
    8349,
    7107,
    6116,
    13316,
    10351,
    8259,
    13461,
    11163,
    9396,
    8008,
    6900,
)

BENDS = (
    467,
    392,
    331,
    283,
    244,
    211,
    184,
    162,
    143,
    127,
    113,
    101,
    91,
    82,
    74,
    67,
    1384,
    987,
    737,
    576,
    471,
    403,
    363,
    344,
    1581,
    1104,
    799,
    596,
    913,
    714,
    569,
    461,
    1842,
    1287,
    933,
    696,
    532,
    830,
    659,
    531,
    2120,
    1485,
    1078,
    805,
    616,
    482,
    766,
    618,
    1203,
    1690,
    1229,
    920,
    705,
    552,
    439,
    355,
    1349,
    949,
    1383,
    1037,
    796,
    624,
    497,
    402,
    1496,
    1054,
    769,
    1155,
    888,
    697,
    556,
    451,
)

# By row: H is its quadratic times 2 to this power, and a common one.
H_SHIFTS = (
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    1,
    1,
    1,
    1,
    1,
    1,
    1,
    1,
    2,
    2,
    2,
    2,
    1,
    1,
    1,
    1,
    3,
    3,
    3,
    3,
    3,
    2,
    2,
    2,
    4,
    4,
    4,
    4,
    4,
    4,
    3,
    3,
    6,
    5,
    5,
    5,
    5,
    5,
    5,
    5,
    7,
    7,
    6,
    6,
    6,
    6,
    6,
    6,
    8,
    8,
    8,
    7,
    7,
    7,
    7,
    7,
)

# By component: the gain, 16 bits of it.
GAINS = (
    36658, 36658,
)

# The product e H/d times the gain is shifted down by this, less the shifts of d and of H's row.
SHIFT_OFFSETS = (
    18, 18,
)

# The largest |u|.
LIMITS = (
    40265280, 40265280,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    30498, 30497,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    200190, 200189,
)


def _whole(name, values, length):
    """The values as integers; ValueError where they are not, or not `length` of them."""
    numbers = [_within(f"{name}[{i}]", v, -(2**31), 2**31) for i, v in enumerate(values)]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _count(name, value):
    """A count from 0 to 2^32 - 1; ValueError for anything else."""
    return _within(name, value, 0, 2**32)


def _within(name, value, low, high):
    if int(value) != value or not low <= value < high:
        raise ValueError(f"{name} is {value!r}, it must be a whole number from {low} to {high - 1}")
    return int(value)


def _segment(tick):
    """Table index of the segment at a tick, and s in 2^-16 of it."""
    running = tick < 4000
    held = tick if running else 4000
    count = held
    count_low = count & 65535
    passed = 34359738 * count_low >> 16
    early = passed < 2097151
    place = passed if early else 2097151
    segment = place >> 16
    share = place & 65535
    first = segment * 4
    return first, share


def _weights(s):
    """At s: (1 - s)^3 and s^3 in 2^-15, 3 s + 3 s^2 - 2 s^3 in 2^-14."""
    s_fine = s << 12
    square = s_fine * s >> 16
    cube = square * s >> 16
    sum = s_fine + square
    three_sums = sum * 3
    two_cubes = cube * 2
    middle = three_sums - two_cubes
    difference = s_fine - square
    difference_over = 0 < difference
    difference_raised = difference if difference_over else 0
    three_differences = difference_raised * 3
    first_and_cube = 268435456 - three_differences
    first = first_and_cube - cube
    middle_over = 0 < middle
    middle_raised = middle if middle_over else 0
    middle_and_half = middle_raised + 8192
    middle_rounded = middle_and_half >> 14
    first_over = 0 < first
    first_raised = first if first_over else 0
    first_and_half = first_raised + 4096
    first_weight = first_and_half >> 13
    middle_under = middle_rounded < 65535
    middle_weight = middle_rounded if middle_under else 65535
    last_and_half = cube + 4096
    last_weight = last_and_half >> 13
    return first_weight, middle_weight, last_weight


def _edge_at(at, w0, w1, w2):
    """An edge of the tube: a control point, and the steps about it by their weights."""
    q0 = COEFFICIENTS[at]
    at_1 = at + 4
    q1 = COEFFICIENTS[at_1]
    at_2 = at + 8
    q2 = COEFFICIENTS[at_2]
    at_3 = at + 12
    q3 = COEFFICIENTS[at_3]
    difference_0 = q1 - q0
    difference_1 = q2 - q1
    difference_2 = q3 - q2
    d0 = difference_0
    d1 = difference_1
    d2 = difference_2
    six_q1 = q1 * 6
    base = six_q1 + d1
    d1_weighted = d1 * w1
    middle_part = d1_weighted >> 14
    d2_weighted = d2 * w2
    d0_weighted = d0 * w0
    outer = d2_weighted - d0_weighted
    outer_part = outer >> 15
    base_and_middle = base + middle_part
    value = base_and_middle + outer_part
    return value


def _curve(row, t):
    """The quadratic of a row, level - (slope - bend t) t, at t in 2^-16."""
    level = LEVELS[row]
    slope = SLOPES[row]
    bend = BENDS[row]
    bend_t = bend * t
    bend_part = bend_t >> 16
    mean_slope = slope - bend_part
    slope_t = mean_slope * t
    fall = slope_t >> 17
    difference = level - fall
    value = difference & 65535
    return value


def _input_size(e, h, reciprocal, gain, shift, limit):
    """|u|: gain e H/d, at most `limit`."""
    e_times_h = e * h >> 16
    over_width = e_times_h * reciprocal >> 16
    unshifted = over_width * gain >> 16
    unlimited = unshifted >> shift
    limit_under = unlimited < limit
    size = unlimited if limit_under else limit
    return size


def tube(tick):
    """Edges of the tube gamma at a tick, in the units of x.
    From the tick of t_c on those at t_c.
    """
    tick = _count("tick", tick)
    lower = [0] * 2
    upper = [0] * 2
    row, s = _segment(tick)
    w0, w1, w2 = _weights(s)
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2)
        upper_edge = _edge_at(upper_at, w0, w1, w2)
        lower[i] = lower_edge
        upper[i] = upper_edge
    return tuple(lower), tuple(upper)


def control(tick, x):
    """Control law (13), u = -k xi epsilon, k = 0.00437, e clamped to [-0.99, 0.99], u saturated.
    tick: periods of 0.001 s since the start (it must not wrap to 0: stop counting at t_c); x: state; u: input.
    x by component: x [m], y [m].
    OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law and points inward.
    Every value of x is a state: there is no bad input. u may be the array x itself.
    """
    tick = _count("tick", tick)
    x = _whole("x", x, 2)
    u = [0] * 2
    row, s = _segment(tick)
    w0, w1, w2 = _weights(s)
    outside = False
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2)
        upper_edge = _edge_at(upper_at, w0, w1, w2)
        x_any = x[i]
        x_over = -268435456 < x_any
        x_raised = x_any if x_over else -268435456
        x_under = x_raised < 268435456
        x_i = x_raised if x_under else 268435456
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        width = to_lower + to_upper
        difference = to_lower - to_upper
        wide = 131072 < width
        safe_width = width if wide else 131072
        width_shift = 31 - safe_width.bit_length()
        width_shifted = safe_width << width_shift
        width_bits = width_shifted >> 26
        width_row = width_bits & 15
        width_tail = width_shifted >> 10
        width_t = width_tail & 65535
        reciprocal = _curve(width_row, width_t)
        upper_nearer = 0 < difference
        difference_minus = -difference
        offset = difference if upper_nearer else difference_minus
        offset_under = offset < safe_width
        offset_limited = offset if offset_under else safe_width
        offset_shifted = offset_limited << width_shift
        e_any = offset_shifted * reciprocal >> 16
        e_under = e_any < 1063134168
        e_limited = e_any if e_under else 1063134168
        remainder = width_shifted - offset_shifted
        y_any = remainder * reciprocal >> 16
        y_over = 10736107 < y_any
        y_raised = y_any if y_over else 10736107
        y_under = y_raised < 1073741823
        y_limited = y_raised if y_under else 1073741823
        y_shift = 31 - y_limited.bit_length()
        octave_rows = y_shift * 8
        first_row = octave_rows + 8
        y_shifted = y_limited << y_shift
        y_bits = y_shifted >> 27
        y_piece = y_bits & 7
        y_row = y_piece + first_row
        y_tail = y_shifted >> 11
        y_t = y_tail & 65535
        h = _curve(y_row, y_t)
        h_shift = H_SHIFTS[y_row]
        gain = GAINS[i]
        shift_offset = SHIFT_OFFSETS[i]
        limit = LIMITS[i]
        less_width_shift = shift_offset - width_shift
        shift_any = less_width_shift - h_shift
        shift_over = 0 < shift_any
        shift = shift_any if shift_over else 0
        size = _input_size(e_limited, h, reciprocal, gain, shift, limit)
        size_minus = -size
        u_i = size_minus if upper_nearer else size
        u[i] = u_i
        inside = offset < width
        outside_next = outside if inside else True
        outside = outside_next
    return OUTSIDE_TUBE if outside else OK, tuple(u)


def margin(tick, x):
    """How far x is from leaving the tube, in 2^-16: the distance to the nearest edge over the width there,
    least over the components. 32768 in the middle, 0 or more inside, else -65536 to -1.
    Watch it: act while there is margin, not when the tube is left.
    """
    tick = _count("tick", tick)
    x = _whole("x", x, 2)
    row, s = _segment(tick)
    w0, w1, w2 = _weights(s)
    margin = 32768
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2)
        upper_edge = _edge_at(upper_at, w0, w1, w2)
        x_any = x[i]
        x_over = -268435456 < x_any
        x_raised = x_any if x_over else -268435456
        x_under = x_raised < 268435456
        x_i = x_raised if x_under else 268435456
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        x_width = to_lower + to_upper
        x_wide = 131072 < x_width
        x_safe_width = x_width if x_wide else 131072
        x_width_shift = 31 - x_safe_width.bit_length()
        x_width_shifted = x_safe_width << x_width_shift
        x_width_bits = x_width_shifted >> 26
        x_width_row = x_width_bits & 15
        x_width_tail = x_width_shifted >> 10
        x_width_t = x_width_tail & 65535
        x_reciprocal = _curve(x_width_row, x_width_t)
        x_nearer = to_upper < to_lower
        x_distance = to_upper if x_nearer else to_lower
        x_inside = 0 < x_distance
        x_distance_minus = -x_distance
        x_size = x_distance if x_inside else x_distance_minus
        x_size_under = x_size < x_safe_width
        x_size_limited = x_size if x_size_under else x_safe_width
        x_size_shifted = x_size_limited << x_width_shift
        x_quotient = x_size_shifted * x_reciprocal >> 16
        x_share_any = x_quotient >> 14
        x_share_under = x_share_any < 65535
        x_share = x_share_any if x_share_under else 65535
        x_share_minus = -1 - x_share
        margin_x = x_share if x_inside else x_share_minus
        less = margin_x < margin
        margin_next = margin_x if less else margin
        margin = margin_next
    return margin


def margins(tick, x):
    """The margin of each component, in the same units: which axis is near its edge."""
    tick = _count("tick", tick)
    x = _whole("x", x, 2)
    margin = [0] * 2
    row, s = _segment(tick)
    w0, w1, w2 = _weights(s)
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2)
        upper_edge = _edge_at(upper_at, w0, w1, w2)
        x_any = x[i]
        x_over = -268435456 < x_any
        x_raised = x_any if x_over else -268435456
        x_under = x_raised < 268435456
        x_i = x_raised if x_under else 268435456
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        x_width = to_lower + to_upper
        x_wide = 131072 < x_width
        x_safe_width = x_width if x_wide else 131072
        x_width_shift = 31 - x_safe_width.bit_length()
        x_width_shifted = x_safe_width << x_width_shift
        x_width_bits = x_width_shifted >> 26
        x_width_row = x_width_bits & 15
        x_width_tail = x_width_shifted >> 10
        x_width_t = x_width_tail & 65535
        x_reciprocal = _curve(x_width_row, x_width_t)
        x_nearer = to_upper < to_lower
        x_distance = to_upper if x_nearer else to_lower
        x_inside = 0 < x_distance
        x_distance_minus = -x_distance
        x_size = x_distance if x_inside else x_distance_minus
        x_size_under = x_size < x_safe_width
        x_size_limited = x_size if x_size_under else x_safe_width
        x_size_shifted = x_size_limited << x_width_shift
        x_quotient = x_size_shifted * x_reciprocal >> 16
        x_share_any = x_quotient >> 14
        x_share_under = x_share_any < 65535
        x_share = x_share_any if x_share_under else 65535
        x_share_minus = -1 - x_share
        margin_x = x_share if x_inside else x_share_minus
        margin[i] = margin_x
    return tuple(margin)


def covered(x):
    """Whether the proof of the sampling period (P9) covers a start at the measured x:
    every component of x is within 0.9 of the tube's half width about its middle at t = 0.
    What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
    Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
    from where it stands.
    """
    x = _whole("x", x, 2)
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
