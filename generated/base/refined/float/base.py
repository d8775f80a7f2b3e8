"""base: prescribed-time reach-avoid-stay controller, refined tube.

Certified (base.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
at rest in it; gamma(0) is in the certificate.
The state stays in it (P9) sampled every 0.02 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
w| <= [0.5, 0.53, 0.4], 0.85 <= g_ii <= 1.18, |g_ij| <= [0.05, 0.05, 0], x measured to 0.003, u acts at most 0.002
s after its sample, v measured to 0.01: |e| of v + lambda x < [0.8745, 0.8842, 0.8667], |u| <= [2.1, 2.5, 1.1].

The same functions as base.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 3 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 3
T_C = 25.0  # prescribed time, seconds
SHARE = 0.7999999523162842  # 0.8, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "cb6310726d773a53"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 32 + 3 points:
# lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    0.10730171203613281, 0.16270160675048828, 0.10464763641357422, 0.1600475311279297,
    -0.033069610595703125, 0.03307628631591797,
    0.10065364837646484, 0.16863346099853516, 0.09769153594970703, 0.164337158203125,
    -0.03345012664794922, 0.033446311950683594,
    0.09014320373535156, 0.16270160675048828, 0.10464763641357422, 0.1825408935546875,
    -0.033069610595703125, 0.03307628631591797,
    0.07963275909423828, 0.14490509033203125, 0.125518798828125, 0.21465778350830078,
    -0.03192710876464844, 0.03314399719238281,
    0.0691213607788086, 0.12452125549316406, 0.16030216217041016, 0.26068878173828125,
    -0.030023574829101562, 0.033972740173339844,
    0.060599327087402344, 0.11599922180175781, 0.2089996337890625, 0.3105459213256836,
    -0.0273590087890625, 0.03556251525878906,
    0.06394100189208984, 0.11934089660644531, 0.27161121368408203, 0.36040306091308594,
    -0.023932456970214844, 0.037914276123046875,
    0.0791473388671875, 0.13454723358154297, 0.3451204299926758, 0.4102611541748047,
    -0.019744873046875, 0.04102802276611328,
    0.1062173843383789, 0.16161727905273438, 0.40471839904785156, 0.46011829376220703,
    -0.014795303344726562, 0.04490184783935547,
    0.14515209197998047, 0.20055198669433594, 0.45040321350097656, 0.505803108215332,
    -0.009084701538085938, 0.049538612365722656,
    0.1959514617919922, 0.25135040283203125, 0.4821739196777344, 0.5375738143920898,
    -0.002613067626953125, 0.054935455322265625,
    0.25861454010009766, 0.3140144348144531, 0.5000314712524414, 0.5554304122924805,
    0.004620552062988281, 0.06109428405761719,
    0.32391929626464844, 0.3793191909790039, 0.5039749145507812, 0.5593748092651367,
    0.012615203857421875, 0.06801414489746094,
    0.37736034393310547, 0.43276023864746094, 0.4940042495727539, 0.5494041442871094,
    0.020296096801757812, 0.07569599151611328,
    0.41893672943115234, 0.4743366241455078, 0.4701213836669922, 0.5255212783813477,
    0.028738975524902344, 0.08413887023925781,
    0.44864940643310547, 0.5040493011474609, 0.4323244094848633, 0.48772335052490234,
    0.03794384002685547, 0.09334373474121094,
    0.46649742126464844, 0.5218973159790039, 0.3806133270263672, 0.43601322174072266,
    0.04790973663330078, 0.10330963134765625,
    0.47248077392578125, 0.5278806686401367, 0.3149890899658203, 0.3703889846801758,
    0.05863666534423828, 0.11403656005859375,
    0.4782838821411133, 0.5336837768554688, 0.25667572021484375, 0.3120756149291992,
    0.07005786895751953, 0.125457763671875,
    0.49595069885253906, 0.5513505935668945, 0.21227645874023438, 0.26767635345458984,
    0.08071708679199219, 0.13611698150634766,
    0.525482177734375, 0.5808820724487305, 0.18179035186767578, 0.23719024658203125,
    0.09061527252197266, 0.14601516723632812,
    0.5668783187866211, 0.6222782135009766, 0.16521739959716797, 0.22061729431152344,
    0.09975242614746094, 0.1551523208618164,
    0.6201381683349609, 0.6755380630493164, 0.16255855560302734, 0.2179584503173828,
    0.10812759399414062, 0.1635274887084961,
    0.6852626800537109, 0.7406625747680664, 0.1738138198852539, 0.22921371459960938,
    0.11574172973632812, 0.1711416244506836,
    0.7486495971679688, 0.8040485382080078, 0.19898223876953125, 0.2543811798095703,
    0.12259483337402344, 0.1779947280883789,
    0.8001708984375, 0.8555707931518555, 0.23806381225585938, 0.29346370697021484,
    0.12868595123291016, 0.18408584594726562,
    0.8398294448852539, 0.895228385925293, 0.2910594940185547, 0.34645843505859375,
    0.1340160369873047, 0.18941497802734375,
    0.8676223754882812, 0.9230222702026367, 0.3579683303833008, 0.41336822509765625,
    0.13858413696289062, 0.1939840316772461,
    0.8835515975952148, 0.9389514923095703, 0.4275360107421875, 0.48293590545654297,
    0.14239120483398438, 0.19779109954833984,
    0.8876171112060547, 0.9430170059204102, 0.48319053649902344, 0.5385904312133789,
    0.14543628692626953, 0.200836181640625,
    0.8798179626464844, 0.9352169036865234, 0.5249309539794922, 0.5803308486938477,
    0.1477212905883789, 0.20312023162841797,
    0.870539665222168, 0.9259395599365234, 0.5527582168579102, 0.6081581115722656,
    0.14924335479736328, 0.20464324951171875,
    0.8612613677978516, 0.916661262512207, 0.5666713714599609, 0.6220712661743164,
    0.15000534057617188, 0.20540523529052734,
    0.8612613677978516, 0.916661262512207, 0.5666713714599609, 0.6220712661743164,
    0.15000534057617188, 0.20540523529052734,
    0.8612613677978516, 0.916661262512207, 0.5666713714599609, 0.6220712661743164,
    0.15000534057617188, 0.20540523529052734,
)

# lambda of v + lambda x, by component.
FILTER = (
    1.4306640625, 1.359375, 1.009765625,
)

# Gain k of the control law, by component.
GAIN = (
    0.09269999712705612, 0.14399999380111694, 0.02850000001490116,
)

# Saturation of u, by component.
U_MAX = (
    2.0999999046325684, 2.5, 1.0999999046325684,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    0.6430479884147644, 0.6430497169494629, -0.15695124864578247,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    0.9569485783576965, 0.9569487571716309, 0.15694934129714966,
)

# The same of v + lambda x: strictly above these bounds.
FILTERED_START_LOWER = (
    0.8641003966331482, 0.8841489553451538, -0.14848175644874573,
)

# The same of v + lambda x: strictly below these bounds.
FILTERED_START_UPPER = (
    1.359068512916565, 1.3772234916687012, 0.14847983419895172,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _segment(t):
    """Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
    Before 0 the start; from t_c on the last number below 32 (t_c = 25 s).
    """
    positive = 0.0 < t
    started = t if positive else 0.0
    scaled = started * 1.2799999713897705
    early = scaled < 31.999998092651367
    u = scaled if early else 31.999998092651367
    segment = int(u)
    base = float(segment)
    place = u - base
    first = segment * 6
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
    at_1 = at + 6
    q1 = COEFFICIENTS[at_1]
    at_2 = at + 12
    q2 = COEFFICIENTS[at_2]
    at_3 = at + 18
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
    lower = [0.0] * 3
    upper = [0.0] * 3
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(3):
            lower[j] = math.nan
            upper[j] = math.nan
        return tuple(lower), tuple(upper)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    for i in range(3):
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
    lower_rate = [0.0] * 3
    upper_rate = [0.0] * 3
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(3):
            lower_rate[j] = math.nan
            upper_rate[j] = math.nan
        return tuple(lower_rate), tuple(upper_rate)
    row, s = _segment(t)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    moving = t < 25.0
    per_second = 1.2799999713897705 if moving else 0.0
    for i in range(3):
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
    """Edges of the filtered tube at time t, in units per second: of v + lambda x, lambda = [1.4306640625, 1.359375, 1.009765625].
    While v + lambda x is between them, x stays in the tube. NaN when t is not finite.
    """
    t = float(t)
    lower = [0.0] * 3
    upper = [0.0] * 3
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(3):
            lower[j] = math.nan
            upper[j] = math.nan
        return tuple(lower), tuple(upper)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    for i in range(3):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 1.2799999713897705
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 1.2799999713897705
        filter_i = FILTER[i]
        lower_part = lower_edge * filter_i
        z_lower = lower_rate + lower_part
        lower[i] = z_lower
        upper_part = upper_edge * filter_i
        z_upper = upper_rate + upper_part
        upper[i] = z_upper
    return tuple(lower), tuple(upper)


def control(t, x, v):
    """Control law (13), u = -k xi epsilon, k = [0.0927, 0.144, 0.0285], e clamped to [-0.99, 0.99] by component, u saturated.
    for v + lambda x in its tube, lambda = [1.4306640625, 1.359375, 1.009765625]. t: seconds since the start (held within [0, t_c]);
    x: state; v: its rate; u: input.
    x by component: x [m], y [m], heading [rad].
    OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law,
    finite, and points inward (0 where the tube is empty). BAD_INPUT: t, x or v has a NaN or an
    infinity; u is 0. u may be the array x or v itself.
    """
    t = float(t)
    x = _vector("x", x, 3)
    v = _vector("v", v, 3)
    u = [0.0] * 3
    t_zero = t * 0.0
    zero = t_zero
    for j in range(3):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    v_zeros = zero
    for k in range(3):
        v_k = v[k]
        v_zero = v_k * 0.0
        v_sum = v_zeros + v_zero
        v_zeros = v_sum
    finite = v_zeros <= 0.0
    bad = not finite
    if bad:
        for m in range(3):
            u[m] = 0.0
        return BAD_INPUT, tuple(u)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    outside = False
    for i in range(3):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 1.2799999713897705
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 1.2799999713897705
        x_i = x[i]
        v_i = v[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_width = upper_rate - lower_rate
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        filter_i = FILTER[i]
        gain_i = GAIN[i]
        gain_minus = -gain_i
        width_part = width * filter_i
        z_width = v_width + width_part
        lower_part = to_lower * filter_i
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * filter_i
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
    x = _vector("x", x, 3)
    v = _vector("v", v, 3)
    t_zero = t * 0.0
    zero = t_zero
    for j in range(3):
        x_j = x[j]
        x_zero = x_j * 0.0
        zeros = zero + x_zero
        zero = zeros
    v_zeros = zero
    for k in range(3):
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
    for i in range(3):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 1.2799999713897705
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 1.2799999713897705
        x_i = x[i]
        v_i = v[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_width = upper_rate - lower_rate
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        filter_i = FILTER[i]
        width_part = width * filter_i
        z_width = v_width + width_part
        lower_part = to_lower * filter_i
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * filter_i
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
    x = _vector("x", x, 3)
    v = _vector("v", v, 3)
    margin = [0.0] * 3
    finite = math.isfinite(t)
    bad = not finite
    if bad:
        for j in range(3):
            margin[j] = math.nan
        return tuple(margin)
    row, s = _segment(t)
    w0, w1, w2, w3 = _basis(s)
    dw0, dw1, dw2, dw3 = _basis_rate(s)
    for i in range(3):
        pair = i * 2
        lower_at = row + pair
        upper_at = lower_at + 1
        lower_edge = _edge_at(lower_at, w0, w1, w2, w3)
        upper_edge = _edge_at(upper_at, w0, w1, w2, w3)
        lower_slope = _edge_at(lower_at, dw0, dw1, dw2, dw3)
        lower_rate = lower_slope * 1.2799999713897705
        upper_slope = _edge_at(upper_at, dw0, dw1, dw2, dw3)
        upper_rate = upper_slope * 1.2799999713897705
        x_i = x[i]
        v_i = v[i]
        width = upper_edge - lower_edge
        to_lower = x_i - lower_edge
        to_upper = upper_edge - x_i
        v_width = upper_rate - lower_rate
        v_to_lower = v_i - lower_rate
        v_to_upper = upper_rate - v_i
        filter_i = FILTER[i]
        width_part = width * filter_i
        z_width = v_width + width_part
        lower_part = to_lower * filter_i
        z_to_lower = v_to_lower + lower_part
        upper_part = to_upper * filter_i
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
    What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
    Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
    from where it stands. False for a NaN.
    """
    x = _vector("x", x, 3)
    v = _vector("v", v, 3)
    covered = True
    for i in range(3):
        x_i = x[i]
        x_lower = START_LOWER[i]
        x_upper = START_UPPER[i]
        x_above = x_lower < x_i
        x_below = x_i < x_upper
        x_inside = x_above and x_below
        filter_i = FILTER[i]
        x_part = x_i * filter_i
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
    lower = _vector("lower", lower, 3)
    upper = _vector("upper", upper, 3)
    x = _vector("x", x, 3)
    e = [0.0] * 3
    epsilon = [0.0] * 3
    xi = [0.0] * 3
    for i in range(3):
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
