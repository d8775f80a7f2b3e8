"""crane: prescribed-time reach-avoid-stay controller, refined tube, in integers.

Certified (crane.certificate.json): for every t the tube keeps 0.05 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
at rest in it; gamma(0) is in the certificate.
The state stays in it (P9) sampled at ticks, every 0.02 s or faster, from every start with |e(0)| <= 0.9 at rest,
for |f + w| <= 0.1, 0.9 <= g_ii <= 1.1, |g_ij| <= 0: |e| of v + lambda x < 0.9001, |u| <= 1.5.

The same functions as crane.c with the same integers, bit for bit; see crane.h for their units.
Arrays come in as sequences of 2 whole numbers of 32 bits and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

N = 2
T_C = 12  # prescribed time, seconds
TICK_PERIOD = 0.005  # seconds of one tick
TICKS = 2400  # the first tick that is not before t_c
X_BITS = 18  # x counts units of 2^-18
U_BITS = 25  # u counts units of 2^-25
SHARE = 0.8999999999999999  # 0.9, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "94579429cb9a0d6c"

OK = 0
OUTSIDE_TUBE = 1

# B-spline control points divided by 6, in 2^-18, a row for each of 32 + 3 points.
COEFFICIENTS = (
    8417, 34610, 9068, 35262,
    8915, 35108, 8589, 34782,
    8417, 34610, 9068, 35262,
    6992, 33185, 10507, 36700,
    6562, 32755, 12905, 39098,
    7127, 33320, 16262, 42455,
    8689, 34882, 20577, 46770,
    11247, 37440, 25852, 52045,
    14801, 40994, 32086, 58279,
    19351, 45544, 39279, 65472,
    24897, 51090, 47432, 73625,
    31440, 57633, 56543, 82736,
    38978, 65171, 66613, 92806,
    47513, 73706, 77642, 103835,
    57044, 83237, 88535, 114728,
    67571, 93764, 98469, 124662,
    79093, 105287, 107444, 133637,
    91613, 117806, 115460, 141653,
    105128, 131321, 122516, 148709,
    119074, 145267, 128614, 154807,
    132023, 158216, 133752, 159945,
    143977, 170170, 137932, 164125,
    154934, 181127, 141152, 167345,
    164895, 191088, 143413, 169606,
    173860, 200053, 144716, 170909,
    181829, 208022, 145059, 171252,
    188802, 214995, 144443, 170636,
    194779, 220972, 142868, 169061,
    199759, 225952, 140333, 166527,
    203744, 229937, 136842, 163036,
    206732, 232925, 133965, 160158,
    208724, 234917, 132047, 158240,
    209721, 235914, 131088, 157281,
    209721, 235914, 131088, 157281,
    209721, 235914, 131088, 157281,
)

# lambda by component, in 2^-16.
FILTERS = (
    43360, 42848,
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
    35861, 34603,
)

# The product e H/d times the gain is shifted down by this, less the shifts of d and of H's row.
SHIFT_OFFSETS = (
    19, 19,
)

# The largest |u|.
LIMITS = (
    50331648, 50331648,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    60352, 60350,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    201794, 201794,
)

# The same of v + lambda x: strictly above these bounds.
FILTERED_START_LOWER = (
    39931, 39459,
)

# The same of v + lambda x: strictly below these bounds.
FILTERED_START_UPPER = (
    133510, 131933,
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
    running = tick < 2400
    held = tick if running else 2400
    count = held
    count_low = count & 65535
    passed = 57266231 * count_low >> 16
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


def _rates(s):
    """At s, in 2^-11 a second: 3 (1 - s)^2, 3 + 6 s (1 - s) and 3 s^2 times the segments in a second."""
    s_fine = s << 12
    square = s_fine * s >> 16
    difference = s_fine - square
    difference_over = 0 < difference
    difference_raised = difference if difference_over else 0
    difference_under = difference_raised < 67108864
    difference_limited = difference_raised if difference_under else 67108864
    complement = 268435456 - s_fine
    first = complement - difference_limited
    first_over = 0 < first
    first_raised = first if first_over else 0
    two_differences = difference_limited * 2
    middle = 268435456 + two_differences
    first_tripled = first_raised * 3
    first_per_second = first_tripled * 43690 >> 16
    first_and_half = first_per_second + 16384
    first_weight = first_and_half >> 15
    middle_tripled = middle * 3
    middle_per_second = middle_tripled * 43690 >> 16
    middle_and_half = middle_per_second + 16384
    middle_weight = middle_and_half >> 15
    last_tripled = square * 3
    last_per_second = last_tripled * 43690 >> 16
    last_and_half = last_per_second + 16384
    last_weight = last_and_half >> 15
    return first_weight, middle_weight, last_weight


def _edge_at(at, w0, w1, w2, r0, r1, r2):
    """An edge of the tube, and its rate in units a second, by the steps about it."""
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
    d1_per_second = d1 * r1
    middle_rate = d1_per_second >> 11
    d0_per_second = d0 * r0
    d2_per_second = d2 * r2
    outer_sum = d0_per_second + d2_per_second
    outer_rate = outer_sum >> 11
    value_rate = middle_rate + outer_rate
    return value, value_rate


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
    r0, r1, r2 = _rates(s)
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge, lower_rate = _edge_at(lower_at, w0, w1, w2, r0, r1, r2)
        upper_edge, upper_rate = _edge_at(upper_at, w0, w1, w2, r0, r1, r2)
        lower[i] = lower_edge
        upper[i] = upper_edge
    return tuple(lower), tuple(upper)


def filtered_tube(tick):
    """Edges of the filtered tube at a tick, in units a second: of v + lambda x,
    lambda = [0.66162109375, 0.65380859375].
    While v + lambda x is between them, x stays in the tube.
    """
    tick = _count("tick", tick)
    lower = [0] * 2
    upper = [0] * 2
    row, s = _segment(tick)
    w0, w1, w2 = _weights(s)
    r0, r1, r2 = _rates(s)
    for i in range(2):
        filter_i = FILTERS[i]
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge, lower_rate = _edge_at(lower_at, w0, w1, w2, r0, r1, r2)
        upper_edge, upper_rate = _edge_at(upper_at, w0, w1, w2, r0, r1, r2)
        lower_part = lower_edge * filter_i >> 16
        z_lower = lower_rate + lower_part
        lower[i] = z_lower
        upper_part = upper_edge * filter_i >> 16
        z_upper = upper_rate + upper_part
        upper[i] = z_upper
    return tuple(lower), tuple(upper)


def control(tick, x, v):
    """Control law (13), u = -k xi epsilon, k = [0.0171, 0.0165], e clamped to [-0.99, 0.99], u saturated,
    for v + lambda x in its tube, lambda = [0.66162109375, 0.65380859375].
    tick: periods of 0.005 s since the start (it must not wrap to 0: stop counting at t_c);
    x: state; v: its rate; u: input.
    x by component: x [m], y [m].
    OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law and
    points inward. Every value of x and v is a state: there is no bad input.
    u may be the array x or v itself.
    """
    tick = _count("tick", tick)
    x = _whole("x", x, 2)
    v = _whole("v", v, 2)
    u = [0] * 2
    row, s = _segment(tick)
    w0, w1, w2 = _weights(s)
    r0, r1, r2 = _rates(s)
    outside = False
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge, lower_rate = _edge_at(lower_at, w0, w1, w2, r0, r1, r2)
        upper_edge, upper_rate = _edge_at(upper_at, w0, w1, w2, r0, r1, r2)
        x_any = x[i]
        x_over = -67108864 < x_any
        x_raised = x_any if x_over else -67108864
        x_under = x_raised < 67108864
        x_i = x_raised if x_under else 67108864
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_any = v[i]
        v_over = -268435456 < v_any
        v_raised = v_any if v_over else -268435456
        v_under = v_raised < 268435456
        v_i = v_raised if v_under else 268435456
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        filter_i = FILTERS[i]
        lower_part = to_lower * filter_i >> 16
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * filter_i >> 16
        z_to_upper = v_to_upper + upper_part
        width = z_to_lower + z_to_upper
        difference = z_to_lower - z_to_upper
        wide = 65536 < width
        safe_width = width if wide else 65536
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
        z_inside = offset < width
        x_above = 0 < to_lower
        x_below = 0 < to_upper
        x_inside = x_above and x_below
        inside = z_inside and x_inside
        outside_next = outside if inside else True
        outside = outside_next
    return OUTSIDE_TUBE if outside else OK, tuple(u)


def margin(tick, x, v):
    """How far x is from leaving the tube, and v + lambda x from leaving its own, in 2^-16: the distance to
    the nearest edge over the width there, the lesser of both, least over the components.
    32768 in the middle, 0 or more inside, negative outside, at least -65536.
    Watch it: act while there is margin, not when the tube is left.
    """
    tick = _count("tick", tick)
    x = _whole("x", x, 2)
    v = _whole("v", v, 2)
    row, s = _segment(tick)
    w0, w1, w2 = _weights(s)
    r0, r1, r2 = _rates(s)
    margin = 32768
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge, lower_rate = _edge_at(lower_at, w0, w1, w2, r0, r1, r2)
        upper_edge, upper_rate = _edge_at(upper_at, w0, w1, w2, r0, r1, r2)
        x_any = x[i]
        x_over = -67108864 < x_any
        x_raised = x_any if x_over else -67108864
        x_under = x_raised < 67108864
        x_i = x_raised if x_under else 67108864
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_any = v[i]
        v_over = -268435456 < v_any
        v_raised = v_any if v_over else -268435456
        v_under = v_raised < 268435456
        v_i = v_raised if v_under else 268435456
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        filter_i = FILTERS[i]
        lower_part = to_lower * filter_i >> 16
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * filter_i >> 16
        z_to_upper = v_to_upper + upper_part
        z_width = z_to_lower + z_to_upper
        z_wide = 65536 < z_width
        z_safe_width = z_width if z_wide else 65536
        z_width_shift = 31 - z_safe_width.bit_length()
        z_width_shifted = z_safe_width << z_width_shift
        z_width_bits = z_width_shifted >> 26
        z_width_row = z_width_bits & 15
        z_width_tail = z_width_shifted >> 10
        z_width_t = z_width_tail & 65535
        z_reciprocal = _curve(z_width_row, z_width_t)
        z_nearer = z_to_upper < z_to_lower
        z_distance = z_to_upper if z_nearer else z_to_lower
        z_inside = 0 < z_distance
        z_distance_minus = -z_distance
        z_size = z_distance if z_inside else z_distance_minus
        z_size_under = z_size < z_safe_width
        z_size_limited = z_size if z_size_under else z_safe_width
        z_size_shifted = z_size_limited << z_width_shift
        z_quotient = z_size_shifted * z_reciprocal >> 16
        z_share_any = z_quotient >> 14
        z_share_under = z_share_any < 65535
        z_share = z_share_any if z_share_under else 65535
        z_share_minus = -1 - z_share
        margin_z = z_share if z_inside else z_share_minus
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
        z_smaller = margin_z < margin_x
        smaller = margin_z if z_smaller else margin_x
        less = smaller < margin
        margin_next = smaller if less else margin
        margin = margin_next
    return margin


def margins(tick, x, v):
    """The margin of each component, in the same units: which axis is near its edge."""
    tick = _count("tick", tick)
    x = _whole("x", x, 2)
    v = _whole("v", v, 2)
    margin = [0] * 2
    row, s = _segment(tick)
    w0, w1, w2 = _weights(s)
    r0, r1, r2 = _rates(s)
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge, lower_rate = _edge_at(lower_at, w0, w1, w2, r0, r1, r2)
        upper_edge, upper_rate = _edge_at(upper_at, w0, w1, w2, r0, r1, r2)
        x_any = x[i]
        x_over = -67108864 < x_any
        x_raised = x_any if x_over else -67108864
        x_under = x_raised < 67108864
        x_i = x_raised if x_under else 67108864
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_any = v[i]
        v_over = -268435456 < v_any
        v_raised = v_any if v_over else -268435456
        v_under = v_raised < 268435456
        v_i = v_raised if v_under else 268435456
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        filter_i = FILTERS[i]
        lower_part = to_lower * filter_i >> 16
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * filter_i >> 16
        z_to_upper = v_to_upper + upper_part
        z_width = z_to_lower + z_to_upper
        z_wide = 65536 < z_width
        z_safe_width = z_width if z_wide else 65536
        z_width_shift = 31 - z_safe_width.bit_length()
        z_width_shifted = z_safe_width << z_width_shift
        z_width_bits = z_width_shifted >> 26
        z_width_row = z_width_bits & 15
        z_width_tail = z_width_shifted >> 10
        z_width_t = z_width_tail & 65535
        z_reciprocal = _curve(z_width_row, z_width_t)
        z_nearer = z_to_upper < z_to_lower
        z_distance = z_to_upper if z_nearer else z_to_lower
        z_inside = 0 < z_distance
        z_distance_minus = -z_distance
        z_size = z_distance if z_inside else z_distance_minus
        z_size_under = z_size < z_safe_width
        z_size_limited = z_size if z_size_under else z_safe_width
        z_size_shifted = z_size_limited << z_width_shift
        z_quotient = z_size_shifted * z_reciprocal >> 16
        z_share_any = z_quotient >> 14
        z_share_under = z_share_any < 65535
        z_share = z_share_any if z_share_under else 65535
        z_share_minus = -1 - z_share
        margin_z = z_share if z_inside else z_share_minus
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
        z_smaller = margin_z < margin_x
        smaller = margin_z if z_smaller else margin_x
        margin[i] = smaller
    return tuple(margin)


def covered(x, v):
    """Whether the proof of the sampling period (P9) covers a start at the measured x and v:
    every component of x is within 0.9 of the tube's half width about its middle at t = 0,
    and v + lambda x is in its own tube, no farther from the middle than from such an x at rest.
    What a measurement may be wrong by (rounding) is taken off.
    Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
    from where it stands.
    """
    x = _whole("x", x, 2)
    v = _whole("v", v, 2)
    covered = True
    for i in range(2):
        x_any = x[i]
        x_over = -67108864 < x_any
        x_raised = x_any if x_over else -67108864
        x_under = x_raised < 67108864
        x_i = x_raised if x_under else 67108864
        v_any = v[i]
        v_over = -268435456 < v_any
        v_raised = v_any if v_over else -268435456
        v_under = v_raised < 268435456
        v_i = v_raised if v_under else 268435456
        filter_i = FILTERS[i]
        x_part = x_i * filter_i >> 16
        z_i = v_i + x_part
        x_lower = START_LOWER[i]
        x_upper = START_UPPER[i]
        x_above = x_lower < x_i
        x_below = x_i < x_upper
        x_inside = x_above and x_below
        z_lower = FILTERED_START_LOWER[i]
        z_upper = FILTERED_START_UPPER[i]
        z_above = z_lower < z_i
        z_below = z_i < z_upper
        z_inside = z_above and z_below
        inside = x_inside and z_inside
        covered_next = covered if inside else False
        covered = covered_next
    return covered
