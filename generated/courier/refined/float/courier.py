"""courier: prescribed-time reach-avoid-stay controller, refined tube.

Certified (courier.certificate.json): for every t the tube keeps 0.03 from every
unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
Every x(t) that stays in the tube satisfies the mission (P10): (eventually[4, 9] (always[0, 2] dock and
eventually[2, 12] (left or right)) and (not lab until[0, 24] dock) and always[0, 12] (not dock or eventually[0, 8]
charger)); times are seconds of t. It still holds where every time at which the tube is in a region, or off one, is
wrong by up to 0.00585 s.

The same functions as courier.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 24.0  # prescribed time, seconds
SHARE = 0.9899999499320984  # 0.99, rounded down, of the tube's half widths at t = 0: the starts of `covered`
DESIGN_HASH = "ce9c1b30d7e334e4"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# B-spline control points divided by 6, one row for each of 64 + 3 points:
# lower[0], upper[0], lower[1], upper[1]
# Multiples of 2^-20: exact in float and double.
COEFFICIENTS = (
    0.008747100830078125, 0.1420602798461914, -0.01875782012939453, 0.11455535888671875,
    0.016676902770996094, 0.14999008178710938, 0.016676902770996094, 0.14999008178710938,
    0.024606704711914062, 0.15791988372802734, 0.05211162567138672, 0.1854248046875,
    0.03253650665283203, 0.1658496856689453, 0.08754634857177734, 0.22085857391357422,
    0.04046630859375, 0.17377948760986328, 0.12298107147216797, 0.25629329681396484,
    0.04839611053466797, 0.18170928955078125, 0.1584148406982422, 0.29172801971435547,
    0.05632591247558594, 0.18963909149169922, 0.1938495635986328, 0.3271627426147461,
    0.0642557144165039, 0.1975688934326172, 0.22928428649902344, 0.3625974655151367,
    0.07218551635742188, 0.20549869537353516, 0.26471900939941406, 0.39803218841552734,
    0.08011627197265625, 0.21342849731445312, 0.3001537322998047, 0.43346691131591797,
    0.08804607391357422, 0.2213582992553711, 0.3355884552001953, 0.4689016342163086,
    0.09597587585449219, 0.22928810119628906, 0.37102317810058594, 0.5043354034423828,
    0.10390567779541016, 0.23721885681152344, 0.40645790100097656, 0.5397701263427734,
    0.11183547973632812, 0.2451486587524414, 0.4418916702270508, 0.5752048492431641,
    0.1197652816772461, 0.2530784606933594, 0.4773263931274414, 0.6106395721435547,
    0.12769508361816406, 0.26100826263427734, 0.512761116027832, 0.6460742950439453,
    0.13562488555908203, 0.2689380645751953, 0.5481958389282227, 0.6815090179443359,
    0.1435546875, 0.2768678665161133, 0.5836305618286133, 0.7169437408447266,
    0.15148448944091797, 0.28479766845703125, 0.6190652847290039, 0.7523784637451172,
    0.15941429138183594, 0.2927274703979492, 0.6545000076293945, 0.7878122329711914,
    0.1673440933227539, 0.3006572723388672, 0.6899347305297852, 0.823246955871582,
    0.17527389526367188, 0.30858707427978516, 0.7222585678100586, 0.8555717468261719,
    0.18320369720458984, 0.3165168762207031, 0.7210617065429688, 0.854374885559082,
    0.18162155151367188, 0.31493473052978516, 0.7198638916015625, 0.8531770706176758,
    0.1800384521484375, 0.3133516311645508, 0.7186670303344727, 0.8519802093505859,
    0.1770153045654297, 0.31032848358154297, 0.7174701690673828, 0.8507833480834961,
    0.17399120330810547, 0.30730438232421875, 0.7162723541259766, 0.8495855331420898,
    0.1770162582397461, 0.3103294372558594, 0.7174720764160156, 0.8507843017578125,
    0.2427539825439453, 0.3760671615600586, 0.7257843017578125, 0.8590974807739258,
    0.30849170684814453, 0.4418048858642578, 0.7340965270996094, 0.8674097061157227,
    0.37422943115234375, 0.507542610168457, 0.7424087524414062, 0.8757219314575195,
    0.4399681091308594, 0.5732803344726562, 0.7507209777832031, 0.8840341567993164,
    0.5057058334350586, 0.6390190124511719, 0.7590341567993164, 0.8923463821411133,
    0.5714435577392578, 0.7047567367553711, 0.7673463821411133, 0.9006595611572266,
    0.637181282043457, 0.7704944610595703, 0.7756586074829102, 0.9089717864990234,
    0.7029190063476562, 0.8362321853637695, 0.783970832824707, 0.9172840118408203,
    0.7686576843261719, 0.9019699096679688, 0.7387418746948242, 0.8720550537109375,
    0.8343954086303711, 0.9677085876464844, 0.673004150390625, 0.8063173294067383,
    0.8280706405639648, 0.9613838195800781, 0.6072664260864258, 0.7405796051025391,
    0.821746826171875, 0.9550600051879883, 0.5415287017822266, 0.6748409271240234,
    0.8154220581054688, 0.948735237121582, 0.47579097747802734, 0.6091032028198242,
    0.8090982437133789, 0.9424114227294922, 0.4100522994995117, 0.543365478515625,
    0.8027744293212891, 0.9360866546630859, 0.3443145751953125, 0.4776277542114258,
    0.7964496612548828, 0.9297628402709961, 0.2785768508911133, 0.41189002990722656,
    0.790125846862793, 0.9234380722045898, 0.21283912658691406, 0.34615230560302734,
    0.7838010787963867, 0.9171142578125, 0.14710140228271484, 0.2804136276245117,
    0.7774772644042969, 0.9107894897460938, 0.08136272430419922, 0.2146759033203125,
    0.794468879699707, 0.9277820587158203, 0.015625, 0.14893817901611328,
    0.8114614486694336, 0.9447746276855469, 0.058823585510253906, 0.1921367645263672,
    0.8284540176391602, 0.9617671966552734, 0.10202312469482422, 0.2353353500366211,
    0.8454465866088867, 0.9787588119506836, 0.14522171020507812, 0.2785348892211914,
    0.8624382019042969, 0.9957513809204102, 0.18842029571533203, 0.3217334747314453,
    0.8794307708740234, 1.0127439498901367, 0.23161888122558594, 0.3649320602416992,
    0.89642333984375, 1.0297365188598633, 0.27481842041015625, 0.4081306457519531,
    0.9134149551391602, 1.0467281341552734, 0.31801700592041016, 0.45133018493652344,
    0.9304075241088867, 1.063720703125, 0.36121559143066406, 0.49452877044677734,
    0.9474000930786133, 1.0807132720947266, 0.40441417694091797, 0.5377273559570312,
    0.9643926620483398, 1.0977048873901367, 0.4476137161254883, 0.5809259414672852,
    0.98138427734375, 1.1146974563598633, 0.4908123016357422, 0.6241254806518555,
    0.9983768463134766, 1.1316900253295898, 0.5340108871459961, 0.6673240661621094,
    1.0153694152832031, 1.1486825942993164, 0.57720947265625, 0.7105226516723633,
    1.0323610305786133, 1.1656742095947266, 0.6204090118408203, 0.7537212371826172,
    1.0493535995483398, 1.1826667785644531, 0.6636075973510742, 0.7969207763671875,
    1.0663461685180664, 1.1996593475341797, 0.7068061828613281, 0.8401193618774414,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953,
)

# Covered starts have x strictly above these bounds, by component.
START_LOWER = (
    0.10406176745891571, 0.10406176745891571,
)

# Covered starts have x strictly below these bounds, by component.
START_UPPER = (
    0.8959401249885559, 0.8959401249885559,
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
    scaled = started * 2.6666667461395264
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
    moving = t < 24.0
    per_second = 2.6666667461395264 if moving else 0.0
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
        smallest = width * 0.004999999888241291
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


def phase(t):
    """The entry of the mission that is being served at time t, from 1; 0 once all are done. See courier.h."""
    if t < 9.7734375:
        return 1
    if t < 13.130859375:
        return 3
    if t < 16.9453125:
        return 1
    return 0
