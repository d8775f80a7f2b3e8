"""waypoints: prescribed-time reach-avoid-stay controller, refined tube.

Certified (waypoints.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and carries out the mission.
Every x(t) that stays in the tube satisfies the mission (P10): (always[0, 1] home and always[3, 4] left and
always[6, 7] right and always[9, 10] left and always[12, 13] right and always[17, 18] goal); times are seconds of
t. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.031 s.

The same functions as waypoints.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 18.0  # prescribed time, seconds
DESIGN_HASH = "577371335753292f"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 64 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-18: exact in float and double.
COEFFICIENTS = (
    0.6596870422363281, 0.8484840393066406, 0.6610107421875, 0.8442535400390625,
    0.6667060852050781, 0.8332939147949219, 0.6667060852050781, 0.8332939147949219,
    0.6737289428710938, 0.8181037902832031, 0.6724052429199219, 0.8223304748535156,
    0.6807479858398438, 0.8029098510742188, 0.6781005859375, 0.8113670349121094,
    0.6877708435058594, 0.7877197265625, 0.6837959289550781, 0.8004074096679688,
    0.6947898864746094, 0.7947425842285156, 0.6894912719726562, 0.7894439697265625,
    0.9332389831542969, 1.0331916809082031, 0.9417457580566406, 1.0416984558105469,
    1.1716880798339844, 1.271636962890625, 1.228363037109375, 1.3283119201660156,
    1.4101333618164062, 1.5100860595703125, 1.5149765014648438, 1.61492919921875,
    1.4053688049316406, 1.5053176879882812, 1.8015899658203125, 1.9015426635742188,
    1.4006004333496094, 1.50054931640625, 2.088207244873047, 2.1881561279296875,
    1.3958320617675781, 1.4957809448242188, 2.3748207092285156, 2.474773406982422,
    1.3910636901855469, 1.4910163879394531, 2.4126319885253906, 2.5125808715820312,
    1.3862953186035156, 1.4862480163574219, 2.3748245239257812, 2.474773406982422,
    1.3815269470214844, 1.4814796447753906, 2.3697853088378906, 2.4697341918945312,
    1.3767585754394531, 1.4767112731933594, 2.36474609375, 2.4646987915039062,
    1.3719902038574219, 1.4719429016113281, 2.3597068786621094, 2.4596595764160156,
    1.5354461669921875, 1.6353950500488281, 2.196544647216797, 2.296497344970703,
    1.6988983154296875, 1.7988471984863281, 2.0333824157714844, 2.1333351135253906,
    1.8623504638671875, 1.9623031616210938, 1.8702201843261719, 1.9701690673828125,
    2.0258026123046875, 2.1257553100585938, 1.7070579528808594, 1.8070068359375,
    2.1892547607421875, 2.2892074584960938, 1.5438919067382812, 1.6438446044921875,
    2.352710723876953, 2.4526596069335938, 1.3807296752929688, 1.480682373046875,
    2.4000282287597656, 2.499980926513672, 1.3333549499511719, 1.4333038330078125,
    2.4000282287597656, 2.499980926513672, 1.3333549499511719, 1.4333038330078125,
    2.4000282287597656, 2.499980926513672, 1.3333549499511719, 1.4333038330078125,
    2.3526687622070312, 2.452617645263672, 1.3809814453125, 1.4809341430664062,
    2.1894187927246094, 2.2893714904785156, 1.5428848266601562, 1.6428375244140625,
    2.026172637939453, 2.1261253356933594, 1.7047882080078125, 1.8047409057617188,
    1.8629226684570312, 1.9628753662109375, 1.8666915893554688, 1.9666404724121094,
    1.699676513671875, 1.7996292114257812, 2.028594970703125, 2.1285438537597656,
    1.5364303588867188, 1.6363792419433594, 2.1904983520507812, 2.290447235107422,
    1.3731803894042969, 1.4731330871582031, 2.352397918701172, 2.452350616455078,
    1.3710212707519531, 1.4709701538085938, 2.4000282287597656, 2.499980926513672,
    1.3688583374023438, 1.46881103515625, 2.4000282287597656, 2.499980926513672,
    1.3666954040527344, 1.4666481018066406, 2.4000282287597656, 2.499980926513672,
    1.316680908203125, 1.4166336059570312, 2.4000282287597656, 2.499980926513672,
    1.36669921875, 1.4666481018066406, 2.3703880310058594, 2.4703407287597656,
    1.6166954040527344, 1.716644287109375, 2.1185379028320312, 2.2184906005859375,
    1.8666915893554688, 1.9666404724121094, 1.8666915893554688, 1.9666404724121094,
    2.116687774658203, 2.2166366577148438, 1.6148414611816406, 1.7147941589355469,
    2.3666839599609375, 2.466632843017578, 1.3629951477050781, 1.4629440307617188,
    2.4167022705078125, 2.516651153564453, 1.3333549499511719, 1.4333038330078125,
    2.3666839599609375, 2.466632843017578, 1.3333549499511719, 1.4333038330078125,
    2.3619232177734375, 2.461872100830078, 1.3333549499511719, 1.4333038330078125,
    2.3571624755859375, 2.457111358642578, 1.3333549499511719, 1.4333038330078125,
    2.352397918701172, 2.452350616455078, 1.3333549499511719, 1.4333038330078125,
    2.347637176513672, 2.447589874267578, 1.3333549499511719, 1.4333038330078125,
    2.342876434326172, 2.442829132080078, 1.3333549499511719, 1.4333038330078125,
    2.338115692138672, 2.4380645751953125, 1.3333549499511719, 1.4333038330078125,
    2.333354949951172, 2.4333038330078125, 1.3748207092285156, 1.4747734069824219,
    2.3285903930664062, 2.4285430908203125, 1.5675277709960938, 1.66748046875,
    2.3238296508789062, 2.4237823486328125, 1.7602348327636719, 1.8601875305175781,
    2.3190689086914062, 2.4190216064453125, 1.95294189453125, 2.0528907775878906,
    2.3143081665039062, 2.4142608642578125, 2.145648956298828, 2.2455978393554688,
    2.379199981689453, 2.4791526794433594, 2.3383522033691406, 2.438304901123047,
    2.5390625, 2.6390151977539062, 2.5310592651367188, 2.631011962890625,
    2.6989288330078125, 2.7988815307617188, 2.723766326904297, 2.823719024658203,
    2.858795166015625, 2.9587440490722656, 2.916473388671875, 3.0164222717285156,
    3.018657684326172, 3.118610382080078, 3.0042381286621094, 3.1041908264160156,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
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


def _blend(w0, w1, w2, w3, q0, q1, q2, q3):
    """An edge of the tube (or its slope in spline time): sum of w_j q_j."""
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
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        lower[i] = lower_edge
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
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
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_slope = _blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3)
        lower_speed = lower_slope * per_second
        lower_rate[i] = lower_speed
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_slope = _blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3)
        upper_speed = upper_slope * per_second
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
        for j2 in range(2):
            u[j2] = 0.0
        return BAD_INPUT, tuple(u)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    outside = False
    for i in range(2):
        pair = i * 2
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
        x_i = x[i]
        room = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        nearest = to_upper if upper_nearer else to_lower
        gain = -0.5 if upper_nearer else 0.5
        least = room * 0.004999999888241291
        clear = least < nearest
        near = nearest if clear else least
        far = room - near
        within = 0.0 < nearest
        outside_any = outside if within else True
        epsilon, xi = _transformed_error(near, far)
        push = _law(gain, xi, epsilon)
        u[i] = push
        outside = outside_any
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
        at = row + pair
        lower_q0 = COEFFICIENTS[at]
        lower_1 = at + 4
        lower_q1 = COEFFICIENTS[lower_1]
        lower_2 = at + 8
        lower_q2 = COEFFICIENTS[lower_2]
        lower_3 = at + 12
        lower_q3 = COEFFICIENTS[lower_3]
        lower_edge = _blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3)
        upper_0 = at + 1
        upper_q0 = COEFFICIENTS[upper_0]
        upper_1 = at + 5
        upper_q1 = COEFFICIENTS[upper_1]
        upper_2 = at + 9
        upper_q2 = COEFFICIENTS[upper_2]
        upper_3 = at + 13
        upper_q3 = COEFFICIENTS[upper_3]
        upper_edge = _blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3)
        x_i = x[i]
        room = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        nearest = to_upper if upper_nearer else to_lower
        share = nearest / room
        beyond = share < -1.0
        held_share = -1.0 if beyond else share
        less = held_share < margin
        margin_next = held_share if less else margin
        margin = margin_next
    return margin


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
        room = upper_edge - lower_edge
        filled = 0.0 < room
        empty = not filled
        wide = 9.5367431640625e-7 < room
        width = room if wide else 9.5367431640625e-7
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        upper_nearer = to_upper < to_lower
        nearest = to_upper if upper_nearer else to_lower
        gain = -1.0 if upper_nearer else 1.0
        least = width * 0.004999999888241291
        widened = width - room
        spare = widened * 0.5
        distance = nearest + spare
        farther = least < distance
        clear = filled and farther
        near = distance if clear else least
        far = width - near
        a = far if upper_nearer else near
        b = near if upper_nearer else far
        e_raw = _normalized_error(a, b, width)
        e_held_above = -0.9900000095367432 < e_raw
        e_held_raised = e_raw if e_held_above else -0.9900000095367432
        e_held_over = 0.9900000095367432 < e_held_raised
        e_held = 0.9900000095367432 if e_held_over else e_held_raised
        epsilon_near, xi_i = _transformed_error(near, far)
        epsilon_i = gain * epsilon_near
        finite_x = math.isfinite(x_i)
        finite_room = math.isfinite(room)
        finite = finite_x and finite_room
        e_settled = 0.0 if empty else e_held
        e_out = e_settled if finite else math.nan
        e[i] = e_out
        epsilon_settled = 0.0 if empty else epsilon_i
        epsilon_out = epsilon_settled if finite else math.nan
        epsilon[i] = epsilon_out
        xi_settled = 0.0 if empty else xi_i
        xi_out = xi_settled if finite else math.nan
        xi[i] = xi_out
    return tuple(e), tuple(epsilon), tuple(xi)


def phase(t):
    """The entry of the mission that is being served at time t, from 1; 0 once all are done. See waypoints.h."""
    if t < 7.03125:
        return 1
    if t < 18.0:
        return 2
    return 0
