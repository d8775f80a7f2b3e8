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
    58196, 58196,
)

# By how many places less u moves up.
OFFSETS = (
    14, 14,
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


def _edge(at, w0, w1, w2):
    """An edge of the tube: a control point, and the steps about it by their weights."""
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
    return value


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
    for i in range(2):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge(lower_at, w0, w1, w2)
        upper_edge = _edge(upper_at, w0, w1, w2)
        lower[i] = lower_edge
        upper[i] = upper_edge
    return tuple(lower), tuple(upper)


def control(tick, x):
    """Control law (13), u = -k xi epsilon, k = 0.111, e clamped to [-0.99, 0.99], u saturated.
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
        lower_edge = _edge(lower_at, w0, w1, w2)
        upper_edge = _edge(upper_at, w0, w1, w2)
        x_all = x[i]
        x_near_over = -268435456 < x_all
        x_near = x_all if x_near_over else -268435456
        x_i_under = x_near < 268435456
        x_i = x_near if x_i_under else 268435456
        x_lower = x_i - lower_edge
        x_upper = upper_edge - x_i
        room = x_lower + x_upper
        apart = x_lower - x_upper
        e_width_over = 131072 < room
        e_width = room if e_width_over else 131072
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
        outside_any = outside if within else True
        outside = outside_any
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
        lower_edge = _edge(lower_at, w0, w1, w2)
        upper_edge = _edge(upper_at, w0, w1, w2)
        x_all = x[i]
        x_near_over = -268435456 < x_all
        x_near = x_all if x_near_over else -268435456
        x_i_under = x_near < 268435456
        x_i = x_near if x_i_under else 268435456
        x_lower = x_i - lower_edge
        x_upper = upper_edge - x_i
        share_room = x_lower + x_upper
        share_width_over = 131072 < share_room
        share_width = share_room if share_width_over else 131072
        share_n = 31 - share_width.bit_length()
        share_width_up = share_width << share_n
        share_over_bits = share_width_up >> 26
        share_over_head = share_over_bits & 15
        share_over_tail = share_width_up >> 10
        share_over_t = share_over_tail & 65535
        share_over = _curve(share_over_head, share_over_t)
        share_high = x_upper < x_lower
        share_nearest = x_upper if share_high else x_lower
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
        less = share < margin
        margin_next = share if less else margin
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
        lower_edge = _edge(lower_at, w0, w1, w2)
        upper_edge = _edge(upper_at, w0, w1, w2)
        x_all = x[i]
        x_near_over = -268435456 < x_all
        x_near = x_all if x_near_over else -268435456
        x_i_under = x_near < 268435456
        x_i = x_near if x_i_under else 268435456
        x_lower = x_i - lower_edge
        x_upper = upper_edge - x_i
        share_room = x_lower + x_upper
        share_width_over = 131072 < share_room
        share_width = share_room if share_width_over else 131072
        share_n = 31 - share_width.bit_length()
        share_width_up = share_width << share_n
        share_over_bits = share_width_up >> 26
        share_over_head = share_over_bits & 15
        share_over_tail = share_width_up >> 10
        share_over_t = share_over_tail & 65535
        share_over = _curve(share_over_head, share_over_t)
        share_high = x_upper < x_lower
        share_nearest = x_upper if share_high else x_lower
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
        margin[i] = share
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
