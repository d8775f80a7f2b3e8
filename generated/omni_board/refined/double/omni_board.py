"""omni_board: prescribed-time reach-avoid-stay controller, refined tube.

Certified (omni_board.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.

The same functions as omni_board.c (double precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 9.0  # prescribed time, seconds
TICK_PERIOD = 0.001  # seconds of one tick of control_tick
TICKS = 9000  # the first tick that is not before t_c
SHARE = 0.99  # 0.99, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "32ce15c0d15e3d91"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    -0.00757598876953125, 0.07573699951171875, -0.03641796112060547, 0.04689502716064453,
    0.00001049041748046875, 0.08332347869873047, 0.00001049041748046875, 0.08332347869873047,
    0.0075969696044921875, 0.09090995788574219, 0.03643798828125, 0.1197509765625,
    0.015183448791503906, 0.0984964370727539, 0.07286548614501953, 0.15617847442626953,
    0.022769927978515625, 0.10608291625976562, 0.10929393768310547, 0.19260692596435547,
    0.030356407165527344, 0.11366939544677734, 0.145721435546875, 0.229034423828125,
    0.037941932678222656, 0.12125492095947266, 0.18214988708496094, 0.26546287536621094,
    0.045528411865234375, 0.12884140014648438, 0.21857738494873047, 0.30189037322998047,
    0.07834815979003906, 0.16166114807128906, 0.2550048828125, 0.33831787109375,
    0.11116790771484375, 0.19448089599609375, 0.29143238067626953, 0.37474536895751953,
    0.14398765563964844, 0.22730064392089844, 0.2914772033691406, 0.3747901916503906,
    0.17680740356445312, 0.2601203918457031, 0.2915210723876953, 0.3748340606689453,
    0.2096271514892578, 0.2929401397705078, 0.2915658950805664, 0.3748788833618164,
    0.2424468994140625, 0.3257598876953125, 0.2916097640991211, 0.3749227523803711,
    0.2752666473388672, 0.3585796356201172, 0.2916545867919922, 0.3749675750732422,
    0.3080863952636719, 0.3913993835449219, 0.2916984558105469, 0.3750114440917969,
    0.34090614318847656, 0.42421913146972656, 0.29174327850341797, 0.37505626678466797,
    0.37372589111328125, 0.45703887939453125, 0.29178714752197266, 0.37510013580322266,
    0.40654563903808594, 0.48985862731933594, 0.29183197021484375, 0.37514495849609375,
    0.4393653869628906, 0.5226783752441406, 0.29187679290771484, 0.37518978118896484,
    0.4721851348876953, 0.5554981231689453, 0.29192066192626953, 0.37523365020751953,
    0.5050048828125, 0.58831787109375, 0.32834815979003906, 0.41166114807128906,
    0.5378236770629883, 0.6211366653442383, 0.364776611328125, 0.448089599609375,
    0.5579748153686523, 0.6412878036499023, 0.40120410919189453, 0.48451709747314453,
    0.5781259536743164, 0.6614389419555664, 0.43763256072998047, 0.5209455490112305,
    0.5996112823486328, 0.6829242706298828, 0.47406005859375, 0.557373046875,
    0.6210956573486328, 0.7044086456298828, 0.5104875564575195, 0.5938005447387695,
    0.6425809860229492, 0.7258939743041992, 0.5469160079956055, 0.6302289962768555,
    0.6640653610229492, 0.7473783493041992, 0.583343505859375, 0.666656494140625,
    0.6855506896972656, 0.7688636779785156, 0.6197710037231445, 0.7030839920043945,
    0.7070350646972656, 0.7903480529785156, 0.6561994552612305, 0.7395124435424805,
    0.728520393371582, 0.811833381652832, 0.692626953125, 0.77593994140625,
    0.750004768371582, 0.833317756652832, 0.7290554046630859, 0.8123683929443359,
    0.750004768371582, 0.833317756652832, 0.7604799270629883, 0.8437929153442383,
    0.750004768371582, 0.833317756652832, 0.7290554046630859, 0.8123683929443359,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    0.002562332153321423, 0.0025613784790050166,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    0.49744148254394416, 0.49744052886962775,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _count(name, value):
    """A count from 0 to 2^32 - 1; ValueError for anything else."""
    if int(value) != value or not 0 <= value < 2**32:
        raise ValueError(f"{name} is {value!r}, it must be a whole number from 0 to 2^32 - 1")
    return int(value)


def _split(y):
    """m and e with y = m 2^e, m in [1/sqrt 2, sqrt 2)."""
    m, e = math.frexp(y)
    return (m, e) if m >= 0.7071067811865476 else (2.0 * m, e - 1)


def _segment(t):
    """Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 32 (t_c = 9 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 3.5555555555555554
    early = scaled < 31.999999999999996
    u = scaled if early else 31.999999999999996
    segment = int(u)
    base = float(segment)
    place = u - base
    first = segment * 4
    return first, place


def _segment_at_tick(tick):
    """As segment, for a count of ticks: one is 4/1125 of a segment, in integers; only s is rounded.
    From tick 9000 on the last segment and s = 1, which is t_c.
    """
    running = tick < 9000
    held = tick if running else 9000
    count = held
    passed = count * 4
    early = passed < 36000
    place = passed if early else 36000
    whole = place // 1125
    before_last = whole < 31
    segment = whole if before_last else 31
    base = segment * 1125
    rest = place - base
    part = float(rest)
    share = part / 1125.0
    first = segment * 4
    return first, share


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
    """Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b.
    ln y by y = m 2^e as e ln 2 + 2 atanh((m - 1)/(m + 1)), with a relative error below 2^-14.
    """
    v0 = b / a
    exponent = _split(v0)[1]
    base = float(exponent)
    mantissa = _split(v0)[0]
    below = mantissa - 1.0
    above = mantissa + 1.0
    s = below / above
    z = s * s
    bent = z * 0.6766043901443481
    around = bent + 2.0
    part = s * around
    whole = base * 0.6931471805599453
    v1 = whole + part
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
    moving = t < 9.0
    per_second = 3.5555555555555554 if moving else 0.0
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
        smallest = width * 0.005
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


def control_tick(tick, x):
    """Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
    tick: periods of 0.001 s since the start (it must not wrap to 0: stop counting at t_c); x: state; u: input.
    OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
    (0 where the tube is empty). BAD_INPUT: x has a NaN or an infinity; u is 0. u may be the array x itself.
    """
    tick = _count("tick", tick)
    x = _vector("x", x, 2)
    u = [0.0] * 2
    zero = 0.0
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
    row, s = _segment_at_tick(tick)
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
        smallest = width * 0.005
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
        smallest = safe_width * 0.005
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
        e_above = -0.99 < e_i
        e_raised = e_i if e_above else -0.99
        e_beyond = 0.99 < e_raised
        e_limited = 0.99 if e_beyond else e_raised
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
