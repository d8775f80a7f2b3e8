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
U_BITS = 24  # u counts units of 2^-24
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
# 8 for each octave of y, for H = 4 ln((2 - y)/y)/((1 - y) y (2 - y)), which also moves up, by:
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

PLACES = (
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
    34341, 33161,
)

# By how many places less u moves up.
OFFSETS = (
    16, 16,
)

# The largest |u|.
LIMITS = (
    25165824, 25165824,
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
    place_under = passed < 2097151
    place = passed if place_under else 2097151
    segment = place >> 16
    share = place & 65535
    first = segment * 4
    return first, share


def _weights(s):
    """At s: (1 - s)^3 and s^3 in 2^-15, 3 s + 3 s^2 - 2 s^3 in 2^-14."""
    s_up = s << 12
    square = s_up * s >> 16
    cube = square * s >> 16
    sum = s_up + square
    sum_3 = sum * 3
    cube_2 = cube * 2
    bend = sum_3 - cube_2
    less = s_up - square
    less_held_over = 0 < less
    less_held = less if less_held_over else 0
    less_3 = less_held * 3
    left_square = 268435456 - less_3
    left = left_square - cube
    bend_held_over = 0 < bend
    bend_held = bend if bend_held_over else 0
    bend_near_half = bend_held + 8192
    bend_near = bend_near_half >> 14
    left_held_over = 0 < left
    left_held = left if left_held_over else 0
    before_half = left_held + 4096
    before = before_half >> 13
    middle_under = bend_near < 65535
    middle = bend_near if middle_under else 65535
    after_half = cube + 4096
    after = after_half >> 13
    return before, middle, after


def _rates(s):
    """At s, in 2^-11 a second: 3 (1 - s)^2, 3 + 6 s (1 - s) and 3 s^2 times the segments in a second."""
    s_up = s << 12
    square = s_up * s >> 16
    less = s_up - square
    less_held_over = 0 < less
    less_held = less if less_held_over else 0
    less_most_under = less_held < 67108864
    less_most = less_held if less_most_under else 67108864
    one_less = 268435456 - s_up
    left = one_less - less_most
    left_held_over = 0 < left
    left_held = left if left_held_over else 0
    less_2 = less_most * 2
    middle = 268435456 + less_2
    before_3 = left_held * 3
    before_second = before_3 * 43690 >> 16
    before_half = before_second + 16384
    before = before_half >> 15
    between_3 = middle * 3
    between_second = between_3 * 43690 >> 16
    between_half = between_second + 16384
    between = between_half >> 15
    after_3 = square * 3
    after_second = after_3 * 43690 >> 16
    after_half = after_second + 16384
    after = after_half >> 15
    return before, between, after


def _edge(at, w0, w1, w2, r0, r1, r2):
    """An edge of the tube, and its rate in units a second, by the steps about it."""
    at_q0 = COEFFICIENTS[at]
    at_1 = at + 4
    at_q1 = COEFFICIENTS[at_1]
    at_2 = at + 8
    at_q2 = COEFFICIENTS[at_2]
    at_3 = at + 12
    at_q3 = COEFFICIENTS[at_3]
    apart_0 = at_q1 - at_q0
    apart_1 = at_q2 - at_q1
    apart_2 = at_q3 - at_q2
    d0 = apart_0
    d1 = apart_1
    d2 = apart_2
    q1_6 = at_q1 * 6
    base = q1_6 + d1
    d1_w1 = d1 * w1
    middle = d1_w1 >> 14
    d2_w2 = d2 * w2
    d0_w0 = d0 * w0
    outer = d2_w2 - d0_w0
    ends = outer >> 15
    bent = base + middle
    value = bent + ends
    d1_r1 = d1 * r1
    between = d1_r1 >> 11
    d0_r0 = d0 * r0
    d2_r2 = d2 * r2
    about = d0_r0 + d2_r2
    around = about >> 11
    slope = between + around
    return value, slope


def _curve(row, t):
    """The quadratic of a row, level - (slope - bend t) t, at t in 2^-16."""
    level = LEVELS[row]
    slope = SLOPES[row]
    bend = BENDS[row]
    bend_t = bend * t
    bent = bend_t >> 16
    down = slope - bent
    down_t = down * t
    fall = down_t >> 17
    left = level - fall
    found = left & 65535
    return found


def _push(e, rise, over, gain, places, limit):
    """|u|: gain e H/d, at most `limit`."""
    steep = e * rise >> 16
    over_width = steep * over >> 16
    size = over_width * gain >> 16
    moved = size >> places
    push_held_under = moved < limit
    push_held = moved if push_held_under else limit
    return push_held


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
        lower_edge, lower_rate = _edge(lower_at, w0, w1, w2, r0, r1, r2)
        upper_edge, upper_rate = _edge(upper_at, w0, w1, w2, r0, r1, r2)
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
        lower_edge, lower_rate = _edge(lower_at, w0, w1, w2, r0, r1, r2)
        upper_edge, upper_rate = _edge(upper_at, w0, w1, w2, r0, r1, r2)
        lower_filtered = lower_edge * filter_i >> 16
        lower_z = lower_rate + lower_filtered
        lower[i] = lower_z
        upper_filtered = upper_edge * filter_i >> 16
        upper_z = upper_rate + upper_filtered
        upper[i] = upper_z
    return tuple(lower), tuple(upper)


def control(tick, x, v):
    """Control law (13), u = -k xi epsilon, k = [0.262, 0.253], e clamped to [-0.99, 0.99], u saturated,
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
        lower_edge, lower_rate = _edge(lower_at, w0, w1, w2, r0, r1, r2)
        upper_edge, upper_rate = _edge(upper_at, w0, w1, w2, r0, r1, r2)
        x_all = x[i]
        x_near_over = -67108864 < x_all
        x_near = x_all if x_near_over else -67108864
        x_i_under = x_near < 67108864
        x_i = x_near if x_i_under else 67108864
        x_lower = x_i - lower_edge
        x_upper = upper_edge - x_i
        v_all = v[i]
        v_near_over = -268435456 < v_all
        v_near = v_all if v_near_over else -268435456
        v_i_under = v_near < 268435456
        v_i = v_near if v_i_under else 268435456
        v_lower = v_i - lower_rate
        v_upper = upper_rate - v_i
        filter_i = FILTERS[i]
        lower_filtered = x_lower * filter_i >> 16
        to_lower = v_lower + lower_filtered
        upper_filtered = x_upper * filter_i >> 16
        to_upper = v_upper + upper_filtered
        room = to_lower + to_upper
        apart = to_lower - to_upper
        e_width_over = 65536 < room
        e_width = room if e_width_over else 65536
        e_n = 31 - e_width.bit_length()
        e_width_up = e_width << e_n
        e_over_bits = e_width_up >> 26
        e_over_head = e_over_bits & 15
        e_over_tail = e_width_up >> 10
        e_over_t = e_over_tail & 65535
        e_over = _curve(e_over_head, e_over_t)
        upper_nearer = 0 < apart
        minus = -apart
        off = apart if upper_nearer else minus
        off_held_under = off < e_width
        off_held = off if off_held_under else e_width
        off_up = off_held << e_n
        e_all = off_up * e_over >> 16
        e_under = e_all < 1063134168
        e = e_all if e_under else 1063134168
        rest = e_width_up - off_up
        y_all = rest * e_over >> 16
        y_near_over = 10736107 < y_all
        y_near = y_all if y_near_over else 10736107
        y_under = y_near < 1073741823
        y = y_near if y_under else 1073741823
        m = 31 - y.bit_length()
        octaves = m * 8
        octave = octaves + 8
        y_up = y << m
        rise_bits = y_up >> 27
        rise_head = rise_bits & 7
        rise_row = rise_head + octave
        rise_tail = y_up >> 11
        rise_t = rise_tail & 65535
        rise = _curve(rise_row, rise_t)
        rise_places = PLACES[rise_row]
        gain = GAINS[i]
        offset = OFFSETS[i]
        limit = LIMITS[i]
        down_n = offset - e_n
        down_all = down_n - rise_places
        down_over = 0 < down_all
        down = down_all if down_over else 0
        push = _push(e, rise, e_over, gain, down, limit)
        back = -push
        u_i = back if upper_nearer else push
        u[i] = u_i
        within = off < room
        over = 0 < x_lower
        under = 0 < x_upper
        between = over and under
        inside = within and between
        outside_any = outside if inside else True
        outside = outside_any
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
        lower_edge, lower_rate = _edge(lower_at, w0, w1, w2, r0, r1, r2)
        upper_edge, upper_rate = _edge(upper_at, w0, w1, w2, r0, r1, r2)
        x_all = x[i]
        x_near_over = -67108864 < x_all
        x_near = x_all if x_near_over else -67108864
        x_i_under = x_near < 67108864
        x_i = x_near if x_i_under else 67108864
        x_lower = x_i - lower_edge
        x_upper = upper_edge - x_i
        v_all = v[i]
        v_near_over = -268435456 < v_all
        v_near = v_all if v_near_over else -268435456
        v_i_under = v_near < 268435456
        v_i = v_near if v_i_under else 268435456
        v_lower = v_i - lower_rate
        v_upper = upper_rate - v_i
        filter_i = FILTERS[i]
        lower_filtered = x_lower * filter_i >> 16
        to_lower = v_lower + lower_filtered
        upper_filtered = x_upper * filter_i >> 16
        to_upper = v_upper + upper_filtered
        share_room = to_lower + to_upper
        share_width_over = 65536 < share_room
        share_width = share_room if share_width_over else 65536
        share_n = 31 - share_width.bit_length()
        share_width_up = share_width << share_n
        share_over_bits = share_width_up >> 26
        share_over_head = share_over_bits & 15
        share_over_tail = share_width_up >> 10
        share_over_t = share_over_tail & 65535
        share_over = _curve(share_over_head, share_over_t)
        share_high = to_upper < to_lower
        share_nearest = to_upper if share_high else to_lower
        share_inside = 0 < share_nearest
        share_beyond = -share_nearest
        share_size = share_nearest if share_inside else share_beyond
        share_held_under = share_size < share_width
        share_held = share_size if share_held_under else share_width
        share_up = share_held << share_n
        share_quotient = share_up * share_over >> 16
        share_part = share_quotient >> 14
        share_most_under = share_part < 65535
        share_most = share_part if share_most_under else 65535
        share_minus = -1 - share_most
        share = share_most if share_inside else share_minus
        place_room = x_lower + x_upper
        place_width_over = 131072 < place_room
        place_width = place_room if place_width_over else 131072
        place_n = 31 - place_width.bit_length()
        place_width_up = place_width << place_n
        place_over_bits = place_width_up >> 26
        place_over_head = place_over_bits & 15
        place_over_tail = place_width_up >> 10
        place_over_t = place_over_tail & 65535
        place_over = _curve(place_over_head, place_over_t)
        place_high = x_upper < x_lower
        place_nearest = x_upper if place_high else x_lower
        place_inside = 0 < place_nearest
        place_beyond = -place_nearest
        place_size = place_nearest if place_inside else place_beyond
        place_held_under = place_size < place_width
        place_held = place_size if place_held_under else place_width
        place_up = place_held << place_n
        place_quotient = place_up * place_over >> 16
        place_part = place_quotient >> 14
        place_most_under = place_part < 65535
        place_most = place_part if place_most_under else 65535
        place_minus = -1 - place_most
        place = place_most if place_inside else place_minus
        filtered_less = share < place
        lesser = share if filtered_less else place
        less = lesser < margin
        margin_next = lesser if less else margin
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
        lower_edge, lower_rate = _edge(lower_at, w0, w1, w2, r0, r1, r2)
        upper_edge, upper_rate = _edge(upper_at, w0, w1, w2, r0, r1, r2)
        x_all = x[i]
        x_near_over = -67108864 < x_all
        x_near = x_all if x_near_over else -67108864
        x_i_under = x_near < 67108864
        x_i = x_near if x_i_under else 67108864
        x_lower = x_i - lower_edge
        x_upper = upper_edge - x_i
        v_all = v[i]
        v_near_over = -268435456 < v_all
        v_near = v_all if v_near_over else -268435456
        v_i_under = v_near < 268435456
        v_i = v_near if v_i_under else 268435456
        v_lower = v_i - lower_rate
        v_upper = upper_rate - v_i
        filter_i = FILTERS[i]
        lower_filtered = x_lower * filter_i >> 16
        to_lower = v_lower + lower_filtered
        upper_filtered = x_upper * filter_i >> 16
        to_upper = v_upper + upper_filtered
        share_room = to_lower + to_upper
        share_width_over = 65536 < share_room
        share_width = share_room if share_width_over else 65536
        share_n = 31 - share_width.bit_length()
        share_width_up = share_width << share_n
        share_over_bits = share_width_up >> 26
        share_over_head = share_over_bits & 15
        share_over_tail = share_width_up >> 10
        share_over_t = share_over_tail & 65535
        share_over = _curve(share_over_head, share_over_t)
        share_high = to_upper < to_lower
        share_nearest = to_upper if share_high else to_lower
        share_inside = 0 < share_nearest
        share_beyond = -share_nearest
        share_size = share_nearest if share_inside else share_beyond
        share_held_under = share_size < share_width
        share_held = share_size if share_held_under else share_width
        share_up = share_held << share_n
        share_quotient = share_up * share_over >> 16
        share_part = share_quotient >> 14
        share_most_under = share_part < 65535
        share_most = share_part if share_most_under else 65535
        share_minus = -1 - share_most
        share = share_most if share_inside else share_minus
        place_room = x_lower + x_upper
        place_width_over = 131072 < place_room
        place_width = place_room if place_width_over else 131072
        place_n = 31 - place_width.bit_length()
        place_width_up = place_width << place_n
        place_over_bits = place_width_up >> 26
        place_over_head = place_over_bits & 15
        place_over_tail = place_width_up >> 10
        place_over_t = place_over_tail & 65535
        place_over = _curve(place_over_head, place_over_t)
        place_high = x_upper < x_lower
        place_nearest = x_upper if place_high else x_lower
        place_inside = 0 < place_nearest
        place_beyond = -place_nearest
        place_size = place_nearest if place_inside else place_beyond
        place_held_under = place_size < place_width
        place_held = place_size if place_held_under else place_width
        place_up = place_held << place_n
        place_quotient = place_up * place_over >> 16
        place_part = place_quotient >> 14
        place_most_under = place_part < 65535
        place_most = place_part if place_most_under else 65535
        place_minus = -1 - place_most
        place = place_most if place_inside else place_minus
        filtered_less = share < place
        lesser = share if filtered_less else place
        margin[i] = lesser
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
        x_all = x[i]
        x_near_over = -67108864 < x_all
        x_near = x_all if x_near_over else -67108864
        x_i_under = x_near < 67108864
        x_i = x_near if x_i_under else 67108864
        v_all = v[i]
        v_near_over = -268435456 < v_all
        v_near = v_all if v_near_over else -268435456
        v_i_under = v_near < 268435456
        v_i = v_near if v_i_under else 268435456
        filter_i = FILTERS[i]
        filtered = x_i * filter_i >> 16
        z = v_i + filtered
        x_lower = START_LOWER[i]
        x_upper = START_UPPER[i]
        x_above = x_lower < x_i
        x_below = x_i < x_upper
        x_inside = x_above and x_below
        z_lower = FILTERED_START_LOWER[i]
        z_upper = FILTERED_START_UPPER[i]
        z_above = z_lower < z
        z_below = z < z_upper
        z_inside = z_above and z_below
        inside = x_inside and z_inside
        covered_next = covered if inside else False
        covered = covered_next
    return covered
