"""either: prescribed-time reach-avoid-stay controller, refined tube.

Certified (either.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
Every x(t) that stays in the tube satisfies the mission (P10): eventually[8, 9.5] (T1 or T2); times are seconds of
t. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.158 s.

The same functions as either.c (double precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 18.0  # prescribed time, seconds
SHARE = 0.99  # 0.99, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "67de839bb39cfa7b"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 64 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-18: exact in float and double.
COEFFICIENTS = (
    0.6111526489257812, 0.7837944030761719, 0.6405181884765625, 0.8131599426269531,
    0.6667060852050781, 0.8332939147949219, 0.6667060852050781, 0.8332939147949219,
    0.7222633361816406, 0.8827896118164062, 0.6928977966308594, 0.853424072265625,
    0.7778167724609375, 0.9322853088378906, 0.7190895080566406, 0.8735580444335938,
    0.8333740234375, 0.9817848205566406, 0.7452774047851562, 0.8936920166015625,
    0.8889274597167969, 1.031280517578125, 0.7714691162109375, 0.9138259887695312,
    0.9444808959960938, 1.080780029296875, 0.7976608276367188, 0.9339561462402344,
    1.0000381469726562, 1.1302757263183594, 0.8238525390625, 0.9540901184082031,
    1.0555915832519531, 1.1797752380371094, 0.8500404357910156, 0.9742240905761719,
    1.11114501953125, 1.2292709350585938, 0.8762321472167969, 0.994354248046875,
    1.1667022705078125, 1.2787666320800781, 0.9024238586425781, 1.0144882202148438,
    1.2222557067871094, 1.3282661437988281, 0.9286117553710938, 1.0346221923828125,
    1.2778129577636719, 1.3777618408203125, 0.954803466796875, 1.0547561645507812,
    1.3333663940429688, 1.433319091796875, 0.9749374389648438, 1.0748863220214844,
    1.3889198303222656, 1.4888725280761719, 0.9950714111328125, 1.0950202941894531,
    1.4444770812988281, 1.5444259643554688, 1.0152015686035156, 1.1151542663574219,
    1.500030517578125, 1.5999832153320312, 1.0353355407714844, 1.1352882385253906,
    1.5555877685546875, 1.6555366516113281, 1.0554695129394531, 1.1554183959960938,
    1.6111412048339844, 1.7110939025878906, 1.0755996704101562, 1.1755523681640625,
    1.6666946411132812, 1.7666473388671875, 1.095733642578125, 1.1956863403320312,
    1.7222518920898438, 1.8222007751464844, 1.1158676147460938, 1.2158164978027344,
    1.7778053283691406, 1.8777580261230469, 1.1360015869140625, 1.2359504699707031,
    1.8333625793457031, 1.9333114624023438, 1.1561317443847656, 1.2560844421386719,
    1.888916015625, 1.9888687133789062, 1.1762657165527344, 1.2762184143066406,
    1.9444694519042969, 2.044422149658203, 1.1963996887207031, 1.2963485717773438,
    2.0000267028808594, 2.0999755859375, 1.2165336608886719, 1.3164825439453125,
    2.0555801391601562, 2.1555328369140625, 1.236663818359375, 1.3366165161132812,
    2.1111373901367188, 2.2110862731933594, 1.2567977905273438, 1.35675048828125,
    2.1666908264160156, 2.266643524169922, 1.2769317626953125, 1.3768806457519531,
    2.2222442626953125, 2.3221969604492188, 1.2970619201660156, 1.3970146179199219,
    2.277801513671875, 2.3777503967285156, 1.3171958923339844, 1.4171485900878906,
    2.333354949951172, 2.433307647705078, 1.3333549499511719, 1.4333038330078125,
    2.3889007568359375, 2.4888534545898438, 1.3495101928710938, 1.449462890625,
    2.3887786865234375, 2.4887313842773438, 1.4000282287597656, 1.4999771118164062,
    2.388660430908203, 2.4886093139648438, 1.4505538940429688, 1.5505027770996094,
    2.388538360595703, 2.4884910583496094, 1.5010795593261719, 1.6010284423828125,
    2.388416290283203, 2.4883689880371094, 1.551605224609375, 1.6515579223632812,
    2.3882980346679688, 2.4882469177246094, 1.6021308898925781, 1.7020835876464844,
    2.3881759643554688, 2.488128662109375, 1.6526565551757812, 1.7526092529296875,
    2.3880577087402344, 2.488006591796875, 1.7031822204589844, 1.8031349182128906,
    2.3879356384277344, 2.487884521484375, 1.7537078857421875, 1.8536605834960938,
    2.3878135681152344, 2.4877662658691406, 1.8042373657226562, 1.9041862487792969,
    2.3876953125, 2.4876441955566406, 1.8547630310058594, 1.9547119140625,
    2.3875732421875, 2.4875259399414062, 1.9052886962890625, 2.005237579345703,
    2.387451171875, 2.4874038696289062, 1.9558143615722656, 2.055767059326172,
    2.3873329162597656, 2.4872817993164062, 2.0063400268554688, 2.106292724609375,
    2.3872108459472656, 2.487163543701172, 2.056865692138672, 2.156818389892578,
    2.3870887756347656, 2.487041473388672, 2.107391357421875, 2.2073440551757812,
    2.3869705200195312, 2.486919403076172, 2.157917022705078, 2.2578697204589844,
    2.3868484497070312, 2.4868011474609375, 2.2084426879882812, 2.3083953857421875,
    2.386730194091797, 2.4866790771484375, 2.25897216796875, 2.3589210510253906,
    2.386608123779297, 2.486560821533203, 2.309497833251953, 2.4094467163085938,
    2.386486053466797, 2.486438751220703, 2.3600234985351562, 2.459972381591797,
    2.4376144409179688, 2.537567138671875, 2.4105491638183594, 2.5105018615722656,
    2.4887428283691406, 2.588695526123047, 2.4610748291015625, 2.5610275268554688,
    2.5398712158203125, 2.639820098876953, 2.5116004943847656, 2.611553192138672,
    2.5909996032714844, 2.690948486328125, 2.5621261596679688, 2.662078857421875,
    2.6421241760253906, 2.742076873779297, 2.612651824951172, 2.712604522705078,
    2.6932525634765625, 2.7932052612304688, 2.6631813049316406, 2.7631301879882812,
    2.7443809509277344, 2.8443336486816406, 2.7137069702148438, 2.8136558532714844,
    2.7955093383789062, 2.8954620361328125, 2.764232635498047, 2.8641815185546875,
    2.846637725830078, 2.9465866088867188, 2.81475830078125, 2.9147109985351562,
    2.89776611328125, 2.9977149963378906, 2.865283966064453, 2.9652366638183594,
    2.9488906860351562, 3.0488433837890625, 2.9158096313476562, 3.0157623291015625,
    3.000019073486328, 3.0999717712402344, 2.9663352966308594, 3.0662879943847656,
    3.000019073486328, 3.0999717712402344, 3.0168609619140625, 3.1168136596679688,
    3.000019073486328, 3.0999717712402344, 2.9663352966308594, 3.0662879943847656,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    4.005237922668462, 4.005237922668462,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    4.994762077331538, 4.994762077331538,
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
    scaled = started * 3.5555555555555554
    early = scaled < 63.99999999999999
    u = scaled if early else 63.99999999999999
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


def phase(t):
    """The entry of the mission that is being served at time t, from 1; 0 once all are done. See either.h."""
    if t < 8.9296875:
        return 1
    return 0
