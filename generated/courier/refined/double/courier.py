"""courier: prescribed-time reach-avoid-stay controller, refined tube.

Certified (courier.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
Every x(t) that stays in the tube satisfies the mission (P10): (eventually[4, 9] (always[0, 2] dock and
eventually[2, 12] (left or right)) and (not lab until[0, 24] dock) and always[0, 12] (not dock or eventually[0, 8]
charger)); times are seconds of t. It still holds where every time at which the tube is in a region, or off one, is
wrong by up to 0.000366 s.

The same functions as courier.c (double precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 24.0  # prescribed time, seconds
DESIGN_HASH = "c919fe8a5e85a942"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 64 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    0.008760452270507812, 0.1420736312866211, -0.020165443420410156, 0.11314773559570312,
    0.016676902770996094, 0.14999008178710938, 0.016676902770996094, 0.14999008178710938,
    0.024593353271484375, 0.15790557861328125, 0.05351829528808594, 0.18683147430419922,
    0.03250885009765625, 0.16582202911376953, 0.09036064147949219, 0.22367382049560547,
    0.04042530059814453, 0.1737384796142578, 0.12720203399658203, 0.2605152130126953,
    0.04834175109863281, 0.1816539764404297, 0.16404438018798828, 0.29735755920410156,
    0.05625724792480469, 0.18957042694091797, 0.20088577270507812, 0.3341989517211914,
    0.06417369842529297, 0.19748687744140625, 0.23772811889648438, 0.37104129791259766,
    0.07209014892578125, 0.20540237426757812, 0.2745695114135742, 0.4078826904296875,
    0.08000564575195312, 0.2133188247680664, 0.31141185760498047, 0.44472408294677734,
    0.0879220962524414, 0.2212352752685547, 0.3482532501220703, 0.4815664291381836,
    0.09583854675292969, 0.22915077209472656, 0.38509559631347656, 0.5184078216552734,
    0.10375404357910156, 0.23706722259521484, 0.4219369888305664, 0.5552501678466797,
    0.11167049407958984, 0.24498367309570312, 0.45877933502197266, 0.5920915603637695,
    0.11958694458007812, 0.252899169921875, 0.4956207275390625, 0.6289339065551758,
    0.12750244140625, 0.2608156204223633, 0.5324621200561523, 0.6657752990722656,
    0.13541889190673828, 0.26873207092285156, 0.5693044662475586, 0.7026176452636719,
    0.14333438873291016, 0.27664756774902344, 0.6061458587646484, 0.7394590377807617,
    0.15125083923339844, 0.2845640182495117, 0.6429882049560547, 0.776301383972168,
    0.15916728973388672, 0.29248046875, 0.6798295974731445, 0.8131427764892578,
    0.1670827865600586, 0.3003959655761719, 0.7166719436645508, 0.8499851226806641,
    0.17499923706054688, 0.30831241607666016, 0.7166719436645508, 0.8499851226806641,
    0.18291568756103516, 0.31622886657714844, 0.7166719436645508, 0.8499851226806641,
    0.18656539916992188, 0.31987857818603516, 0.7166719436645508, 0.8499851226806641,
    0.190216064453125, 0.3235282897949219, 0.7166719436645508, 0.8499851226806641,
    0.1673908233642578, 0.3007040023803711, 0.7166719436645508, 0.8499851226806641,
    0.20383548736572266, 0.33714866638183594, 0.7166719436645508, 0.8499851226806641,
    0.1673879623413086, 0.3007011413574219, 0.7166719436645508, 0.8499851226806641,
    0.17660903930664062, 0.3099222183227539, 0.7166719436645508, 0.8499851226806641,
    0.25061893463134766, 0.38393211364746094, 0.7287578582763672, 0.8620710372924805,
    0.3246288299560547, 0.45794105529785156, 0.7408437728881836, 0.8741559982299805,
    0.3986377716064453, 0.5319509506225586, 0.7529296875, 0.8862419128417969,
    0.47264766693115234, 0.6059608459472656, 0.7650156021118164, 0.8983278274536133,
    0.5466575622558594, 0.6799697875976562, 0.7690973281860352, 0.902409553527832,
    0.62066650390625, 0.7539796829223633, 0.7731781005859375, 0.9064912796020508,
    0.694676399230957, 0.8279895782470703, 0.7772598266601562, 0.9105730056762695,
    0.7686862945556641, 0.9019994735717773, 0.7353525161743164, 0.8686656951904297,
    0.8426952362060547, 0.976008415222168, 0.6934452056884766, 0.8267583847045898,
    0.8382711410522461, 0.9715843200683594, 0.6515378952026367, 0.78485107421875,
    0.8338470458984375, 0.9671602249145508, 0.6096305847167969, 0.7429437637329102,
    0.8294229507446289, 0.9627361297607422, 0.567723274230957, 0.7010354995727539,
    0.8249988555908203, 0.9583120346069336, 0.5258150100708008, 0.6591281890869141,
    0.8205747604370117, 0.953887939453125, 0.48390769958496094, 0.6172208786010742,
    0.8161506652832031, 0.9494638442993164, 0.4420003890991211, 0.5753135681152344,
    0.8117265701293945, 0.9450397491455078, 0.40009307861328125, 0.5334062576293945,
    0.8073024749755859, 0.9406156539916992, 0.3581857681274414, 0.4914989471435547,
    0.8028783798217773, 0.9361906051635742, 0.31627845764160156, 0.44959068298339844,
    0.7984542846679688, 0.9317665100097656, 0.2743711471557617, 0.4076833724975586,
    0.7940292358398438, 0.927342414855957, 0.23246288299560547, 0.36577606201171875,
    0.7896051406860352, 0.9229183197021484, 0.19055557250976562, 0.3238687515258789,
    0.7851810455322266, 0.9184942245483398, 0.14864826202392578, 0.28196144104003906,
    0.780756950378418, 0.9140701293945312, 0.10674095153808594, 0.24005413055419922,
    0.7763328552246094, 0.9096460342407227, 0.0648336410522461, 0.19814682006835938,
    0.8019170761108398, 0.9352293014526367, 0.12193107604980469, 0.25524425506591797,
    0.8275003433227539, 0.9608135223388672, 0.17902851104736328, 0.31234169006347656,
    0.8530845642089844, 0.9863977432250977, 0.23612594604492188, 0.36943912506103516,
    0.8786678314208984, 1.0119810104370117, 0.2932243347167969, 0.42653656005859375,
    0.9042520523071289, 1.0375652313232422, 0.35032176971435547, 0.48363494873046875,
    0.929835319519043, 1.0631484985351562, 0.40741920471191406, 0.5407323837280273,
    0.9554195404052734, 1.0887327194213867, 0.46451663970947266, 0.5978298187255859,
    0.9810028076171875, 1.1143159866333008, 0.5216140747070312, 0.6549272537231445,
    1.006587028503418, 1.1399002075195312, 0.5787124633789062, 0.7120246887207031,
    1.0321712493896484, 1.1654834747314453, 0.6358098983764648, 0.7691230773925781,
    1.0577545166015625, 1.1910676956176758, 0.6929073333740234, 0.8262205123901367,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _segment(t):
    """Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 64 (t_c = 24 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 2.6666666666666665
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
    moving = t < 24.0
    per_second = 2.6666666666666665 if moving else 0.0
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
        least = room * 0.005
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
        least = width * 0.005
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
        e_held_above = -0.99 < e_raw
        e_held_raised = e_raw if e_held_above else -0.99
        e_held_over = 0.99 < e_held_raised
        e_held = 0.99 if e_held_over else e_held_raised
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
    """The entry of the mission that is being served at time t, from 1; 0 once all are done. See courier.h."""
    if t < 9.703125:
        return 1
    if t < 13.1253662109375:
        return 3
    if t < 19.1722412109375:
        return 1
    return 0
