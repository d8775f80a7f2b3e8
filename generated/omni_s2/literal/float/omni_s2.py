"""omni_s2: prescribed-time reach-avoid-stay controller, literal tube.

*** NOT CERTIFIED *** NOT CERTIFIED *** NOT CERTIFIED ***
This controller was written with --uncertified. Do not run it on a machine. What fails:
  P1 width at t = 0.91125 s, dimension 1
  P4 avoid at t in [0.91125, 0.9135] s, unsafe set O3
  P5 reach at t = 9 s, dimension 2

The same functions as omni_s2.c (single precision there) in double arithmetic on the same constants.
Arrays come in as sequences of 2 numbers and go out as tuples.
Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
"""

import math

N = 2
T_C = 9.0  # prescribed time, seconds
DESIGN_HASH = "3bad0adb852f3480"

OK = 0
OUTSIDE_TUBE = 1
BAD_INPUT = 2

# By dimension: X0hat and That of the lower edge, X0hat and That of the upper edge.
REACH = (
    0.0, 4.5, 0.5, 5.0,
    0.0, 4.5, 0.5, 5.0,
)

# By dimension: rest levels of beta_L and beta_U.
WALLS = (
    0.0, 5.0,
    0.0, 5.0,
)

# Circumvent functions B, k, m, r: for each dimension 1 of beta_L, then 1 of beta_U,
# filled up with height 0.
BUMPS = (
    2.200000047683716, 0.009999999776482582, 1.60986328125, 0.7065067291259766,
    0.0, 1.0, 0.0, 1.0,
    0.0, 1.0, 0.0, 1.0,
    2.700000047683716, 0.009999999776482582, 3.4613800048828125, 0.5516948699951172,
)


def _vector(name, values, length):
    """The values as floats; ValueError when there are not `length` of them."""
    numbers = [float(v) for v in values]
    if len(numbers) != length:
        raise ValueError(f"{name} has {len(numbers)} entries, {length} are needed")
    return numbers


def _hold(t, t_c):
    """t held within [0, t_c]."""
    positive = 0.0 < t
    started = t if positive else 0.0
    running = started < t_c
    held = started if running else t_c
    return held


def _profile(t, t_c):
    """Time profile of (4): sigma = tanh(t / (t_c - t)), 1 from t_c on."""
    v0 = t_c - t
    v1 = 0.0009765625 * t_c
    v2 = v1 < v0
    v3 = v0 if v2 else v1
    v4 = t / v3
    v5 = -2.0 * v4
    v6 = math.exp(v5)
    v7 = 1.0 - v6
    v8 = 1.0 + v6
    v9 = v7 / v8
    return v9


def _profile_rate(t, t_c):
    """sigma of (4) and its derivative."""
    v0 = t_c - t
    v1 = 0.0009765625 * t_c
    v2 = v1 < v0
    v3 = v0 if v2 else v1
    v4 = t / v3
    v5 = -2.0 * v4
    v6 = math.exp(v5)
    v7 = 1.0 - v6
    v8 = 1.0 + v6
    v9 = v7 / v8
    v10 = 1.0 / v3
    v11 = v4 / v3
    v12 = v1 <= v0
    v13 = v0 <= v1
    v14 = 1.0 if v12 else 0.0
    v15 = 1.0 if v13 else 0.0
    v16 = v14 + v15
    v17 = v14 / v16
    v18 = v11 * v17
    v19 = v10 + v18
    v20 = -2.0 * v19
    v21 = v6 * v20
    v22 = v21 / v8
    v23 = v9 / v8
    v24 = v23 * v21
    v25 = v22 + v24
    v26 = -v25
    return v9, v26


def _reach_edge(start, end, sigma):
    """An edge of the reachability tube (4)."""
    v0 = end - start
    v1 = v0 * sigma
    v2 = start + v1
    return v2


def _reach_rate(start, end, sigma_rate):
    """The rate of an edge of the reachability tube (4)."""
    v0 = end - start
    v1 = v0 * sigma_rate
    return v1


def _circumvent(t, height, steepness, middle, radius, cut):
    """A circumvent function (7), (8) above its rest level."""
    v0 = t - middle
    v1 = v0 * v0
    v2 = steepness * v1
    v3 = math.fabs(v0)
    v4 = radius - v3
    v5 = radius + v3
    v6 = v4 * v5
    v7 = v2 * cut
    v8 = v7 < v6
    v9 = v6 if v8 else v7
    v10 = v2 / v9
    v11 = -v10
    v12 = math.exp(v11)
    v13 = height * v12
    return v13


def _circumvent_rate(t, height, steepness, middle, radius, cut):
    """A circumvent function (7), (8) and its derivative."""
    v0 = t - middle
    v1 = v0 * v0
    v2 = steepness * v1
    v3 = math.fabs(v0)
    v4 = radius - v3
    v5 = radius + v3
    v6 = v4 * v5
    v7 = v2 * cut
    v8 = v7 < v6
    v9 = v6 if v8 else v7
    v10 = v2 / v9
    v11 = -v10
    v12 = math.exp(v11)
    v13 = height * v12
    v14 = v0 + v0
    v15 = steepness * v14
    v16 = v15 / v9
    v17 = v10 / v9
    v18 = v7 <= v6
    v19 = v6 <= v7
    v20 = 1.0 if v18 else 0.0
    v21 = 1.0 if v19 else 0.0
    v22 = v20 + v21
    v23 = v20 / v22
    v24 = v0 < 0.0
    v25 = -1.0 if v24 else 0.0
    v26 = 0.0 < v0
    v27 = 1.0 if v26 else v25
    v28 = v4 * v27
    v29 = v5 * v27
    v30 = v28 - v29
    v31 = v23 * v30
    v32 = v21 / v22
    v33 = cut * v15
    v34 = v32 * v33
    v35 = v31 + v34
    v36 = v17 * v35
    v37 = v16 - v36
    v38 = v12 * v37
    v39 = height * v38
    v40 = -v39
    return v13, v40


def _update_rate(psi, alpha, theta0, kappa, mu, varsigma):
    """The update function's equation (11) and its exact Jacobian."""
    v0 = theta0 + theta0
    v1 = psi - mu
    v2 = varsigma * v1
    v3 = v2 < 40.0
    v4 = v2 if v3 else 40.0
    v5 = v4 + v4
    v6 = math.exp(v5)
    v7 = 1.0 + v6
    v8 = v0 / v7
    v9 = psi + alpha
    v10 = 9.313225746154785e-10 < v9
    v11 = v9 if v10 else 9.313225746154785e-10
    v12 = v8 / v11
    v13 = v12 / v11
    v14 = kappa * alpha
    v15 = v13 - v14
    v16 = 9.313225746154785e-10 <= v9
    v17 = v9 <= 9.313225746154785e-10
    v18 = 1.0 if v16 else 0.0
    v19 = 1.0 if v17 else 0.0
    v20 = v18 + v19
    v21 = v18 / v20
    v22 = v13 * v21
    v23 = v22 / v11
    v24 = v13 / v11
    v25 = v24 * v21
    v26 = v23 + v25
    v27 = v26 + kappa
    v28 = -v27
    return v15, v28


def _implicit_start(psi, alpha, h, theta0, kappa, mu, varsigma):
    """Implicit step of (11): (z - p) z^2 = q, and where to start."""
    v0 = h * kappa
    v1 = 1.0 + v0
    v2 = alpha / v1
    v3 = psi + v2
    v4 = theta0 + theta0
    v5 = psi - mu
    v6 = varsigma * v5
    v7 = v6 < 40.0
    v8 = v6 if v7 else 40.0
    v9 = v8 + v8
    v10 = math.exp(v9)
    v11 = 1.0 + v10
    v12 = v4 / v11
    v13 = h * v12
    v14 = v13 / v1
    v15 = v3 < 0.0
    v16 = v14 ** 0.3333333432674408
    v17 = -v3
    v18 = 8.673617379884035e-19 < v17
    v19 = v17 if v18 else 8.673617379884035e-19
    v20 = v14 / v19
    v21 = math.sqrt(v20)
    v22 = v16 < v21
    v23 = v16 if v22 else v21
    v24 = v23 if v15 else 0.0
    v25 = not v15
    v26 = v3 + v16
    v27 = v26 if v25 else 0.0
    v28 = v24 + v27
    v29 = 8.673617379884035e-19 < v28
    v30 = v28 if v29 else 8.673617379884035e-19
    return v3, v14, v2, v30


def _newton(p, q, z):
    """One Newton iterate for (z - p) z^2 = q."""
    v0 = z - p
    v1 = v0 * z
    v2 = v1 * z
    v3 = v2 - q
    v4 = z + v0
    v5 = z * v4
    v6 = v5 + v1
    v7 = v3 / v6
    v8 = z - v7
    v9 = 8.673617379884035e-19 < v8
    v10 = v8 if v9 else 8.673617379884035e-19
    return v10


def _implicit_end(q, rest, z):
    """Implicit step of (11): alpha from the root z = psi + alpha."""
    v0 = z * z
    v1 = q / v0
    v2 = rest + v1
    return v2


def _lower_edge(rho, alpha, beta, nu):
    """gamma_L of (10)."""
    v0 = rho - alpha
    v1 = v0 + beta
    v2 = v1 / 2.0
    v3 = v0 - beta
    v4 = math.fabs(v3)
    v5 = v4 / 2.0
    v6 = v2 + v5
    v7 = -2.0 * nu
    v8 = v7 * v5
    v9 = math.exp(v8)
    v10 = math.log1p(v9)
    v11 = v10 / nu
    v12 = v6 + v11
    return v12


def _lower_edge_rate(rho, alpha, beta, nu, rho_rate, alpha_rate, beta_rate):
    """gamma_L of (10) and its total rate."""
    v0 = rho - alpha
    v1 = v0 + beta
    v2 = v1 / 2.0
    v3 = v0 - beta
    v4 = math.fabs(v3)
    v5 = v4 / 2.0
    v6 = v2 + v5
    v7 = -2.0 * nu
    v8 = v7 * v5
    v9 = math.exp(v8)
    v10 = math.log1p(v9)
    v11 = v10 / nu
    v12 = v6 + v11
    v13 = rho_rate - alpha_rate
    v14 = v13 + beta_rate
    v15 = 0.5 * v14
    v16 = v3 < 0.0
    v17 = -1.0 if v16 else 0.0
    v18 = 0.0 < v3
    v19 = 1.0 if v18 else v17
    v20 = v13 - beta_rate
    v21 = v19 * v20
    v22 = 0.5 * v21
    v23 = v15 + v22
    v24 = v7 * v22
    v25 = v9 * v24
    v26 = 1.0 + v9
    v27 = v25 / v26
    v28 = v27 / nu
    v29 = v23 + v28
    return v12, v29


def _upper_edge(rho, alpha, beta, nu):
    """gamma_U of (10)."""
    v0 = rho + alpha
    v1 = v0 + beta
    v2 = v1 / 2.0
    v3 = v0 - beta
    v4 = math.fabs(v3)
    v5 = v4 / 2.0
    v6 = v2 - v5
    v7 = -2.0 * nu
    v8 = v7 * v5
    v9 = math.exp(v8)
    v10 = math.log1p(v9)
    v11 = v10 / nu
    v12 = v6 - v11
    return v12


def _upper_edge_rate(rho, alpha, beta, nu, rho_rate, alpha_rate, beta_rate):
    """gamma_U of (10) and its total rate."""
    v0 = rho + alpha
    v1 = v0 + beta
    v2 = v1 / 2.0
    v3 = v0 - beta
    v4 = math.fabs(v3)
    v5 = v4 / 2.0
    v6 = v2 - v5
    v7 = -2.0 * nu
    v8 = v7 * v5
    v9 = math.exp(v8)
    v10 = math.log1p(v9)
    v11 = v10 / nu
    v12 = v6 - v11
    v13 = rho_rate + alpha_rate
    v14 = v13 + beta_rate
    v15 = 0.5 * v14
    v16 = v3 < 0.0
    v17 = -1.0 if v16 else 0.0
    v18 = 0.0 < v3
    v19 = 1.0 if v18 else v17
    v20 = v13 - beta_rate
    v21 = v19 * v20
    v22 = 0.5 * v21
    v23 = v15 - v22
    v24 = v7 * v22
    v25 = v9 * v24
    v26 = 1.0 + v9
    v27 = v25 / v26
    v28 = v27 / nu
    v29 = v23 - v28
    return v12, v29


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


def alpha_init():
    """Start of the update function: alpha(0) = 0 (11). alpha = [alpha_L by dimension, alpha_U by dimension]."""
    alpha = [0.0] * 4
    for i in range(4):
        alpha[i] = 0.0
    return tuple(alpha)


def alpha_step(t, dt, alpha):
    """One implicit (backward Euler) step of (11) from t to t + dt seconds; fixed cost, stable for every dt > 0. The new
    alpha replaces the given one (C) or is returned (Python); it is the given one when dt <= 0 or a number is not finite.
    Call it once after each control step. A late start begins at t = 0 too: alpha_init, then such steps up to that t.
    """
    t = float(t)
    dt = float(dt)
    alpha = _vector("alpha", alpha, 4)
    t_zero = t * 0.0
    dt_zero = dt * 0.0
    both_zero = t_zero + dt_zero
    zero = both_zero
    for j in range(4):
        alpha_j = alpha[j]
        alpha_zero = alpha_j * 0.0
        zeros = zero + alpha_zero
        zero = zeros
    finite = zero <= 0.0
    bad = not finite
    forward = 0.0 < dt
    backward = not forward
    stay = bad or backward
    if stay:
        return tuple(alpha)
    short_step = dt < 1048576.0
    h = dt if short_step else 1048576.0
    later = t + dt
    held = _hold(later, 9.0)
    sigma = _profile(held, 9.0)
    for i in range(2):
        reach_row = i * 4
        wall_row = i * 2
        low_start = REACH[reach_row]
        low_end_at = reach_row + 1
        low_end = REACH[low_end_at]
        rho_low = _reach_edge(low_start, low_end, sigma)
        high_start_at = reach_row + 2
        high_start = REACH[high_start_at]
        high_end_at = reach_row + 3
        high_end = REACH[high_end_at]
        rho_high = _reach_edge(high_start, high_end, sigma)
        low_wall = WALLS[wall_row]
        low_bumps_at = i * 8
        low_joined = 0.0
        for low_j in range(1):
            low_offset = low_j * 4
            low_at = low_bumps_at + low_offset
            low_height = BUMPS[low_at]
            low_steepness_at = low_at + 1
            low_steepness = BUMPS[low_steepness_at]
            low_middle_at = low_at + 2
            low_middle = BUMPS[low_middle_at]
            low_radius_at = low_at + 3
            low_radius = BUMPS[low_radius_at]
            low_bump = _circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615384973585606)
            low_joined = low_bump
        beta_low = low_wall + low_joined
        high_wall_at = wall_row + 1
        high_wall = WALLS[high_wall_at]
        high_bumps_at = i * 8
        high_joined = 0.0
        for high_j in range(1):
            high_offset = high_j * 4
            high_at = high_bumps_at + high_offset
            high_height_at = high_at + 4
            high_height = BUMPS[high_height_at]
            high_steepness_at = high_at + 5
            high_steepness = BUMPS[high_steepness_at]
            high_middle_at = high_at + 6
            high_middle = BUMPS[high_middle_at]
            high_radius_at = high_at + 7
            high_radius = BUMPS[high_radius_at]
            high_bump = _circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615384973585606)
            high_joined = high_bump
        beta_high = high_wall - high_joined
        alpha_low_in = alpha[i]
        alpha_low_positive = 0.0 < alpha_low_in
        alpha_low_raised = alpha_low_in if alpha_low_positive else 0.0
        alpha_low_small = alpha_low_raised < 41.0
        alpha_low = alpha_low_raised if alpha_low_small else 41.0
        alpha_high_at = i + 2
        alpha_high_in = alpha[alpha_high_at]
        alpha_high_positive = 0.0 < alpha_high_in
        alpha_high_raised = alpha_high_in if alpha_high_positive else 0.0
        alpha_high_small = alpha_high_raised < 41.0
        alpha_high = alpha_high_raised if alpha_high_small else 41.0
        psi_low = beta_high - rho_low
        psi_high = rho_high - beta_low
        low_p, low_q, low_theta_rest, low_z_start = _implicit_start(psi_low, alpha_low, h, 0.009999999776482582, 5.0, 1.0, 100.0)
        low_z = low_z_start
        for low_k in range(7):
            low_z_next = _newton(low_p, low_q, low_z)
            low_z = low_z_next
        alpha_low_out = _implicit_end(low_q, low_theta_rest, low_z)
        alpha[i] = alpha_low_out
        high_p, high_q, high_theta_rest, high_z_start = _implicit_start(psi_high, alpha_high, h, 0.009999999776482582, 5.0, 1.0, 100.0)
        high_z = high_z_start
        for high_k in range(7):
            high_z_next = _newton(high_p, high_q, high_z)
            high_z = high_z_next
        alpha_high_out = _implicit_end(high_q, high_theta_rest, high_z)
        high_out_at = i + 2
        alpha[high_out_at] = alpha_high_out
    return tuple(alpha)


def alpha_rate(t, alpha):
    """Right side of the update equation (11) and its Jacobian d rate / d alpha (diagonal), laid out as alpha.
    For a solver of your own; `alpha_step` needs neither. NaN when a number is not finite.
    """
    t = float(t)
    alpha = _vector("alpha", alpha, 4)
    rate = [0.0] * 4
    jacobian = [0.0] * 4
    t_zero = t * 0.0
    zero = t_zero
    for j in range(4):
        alpha_j = alpha[j]
        alpha_zero = alpha_j * 0.0
        zeros = zero + alpha_zero
        zero = zeros
    finite = zero <= 0.0
    bad = not finite
    if bad:
        for m in range(4):
            rate[m] = math.nan
            jacobian[m] = math.nan
        return tuple(rate), tuple(jacobian)
    held = _hold(t, 9.0)
    sigma = _profile(held, 9.0)
    for i in range(2):
        reach_row = i * 4
        wall_row = i * 2
        low_start = REACH[reach_row]
        low_end_at = reach_row + 1
        low_end = REACH[low_end_at]
        rho_low = _reach_edge(low_start, low_end, sigma)
        high_start_at = reach_row + 2
        high_start = REACH[high_start_at]
        high_end_at = reach_row + 3
        high_end = REACH[high_end_at]
        rho_high = _reach_edge(high_start, high_end, sigma)
        low_wall = WALLS[wall_row]
        low_bumps_at = i * 8
        low_joined = 0.0
        for low_j in range(1):
            low_offset = low_j * 4
            low_at = low_bumps_at + low_offset
            low_height = BUMPS[low_at]
            low_steepness_at = low_at + 1
            low_steepness = BUMPS[low_steepness_at]
            low_middle_at = low_at + 2
            low_middle = BUMPS[low_middle_at]
            low_radius_at = low_at + 3
            low_radius = BUMPS[low_radius_at]
            low_bump = _circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615384973585606)
            low_joined = low_bump
        beta_low = low_wall + low_joined
        high_wall_at = wall_row + 1
        high_wall = WALLS[high_wall_at]
        high_bumps_at = i * 8
        high_joined = 0.0
        for high_j in range(1):
            high_offset = high_j * 4
            high_at = high_bumps_at + high_offset
            high_height_at = high_at + 4
            high_height = BUMPS[high_height_at]
            high_steepness_at = high_at + 5
            high_steepness = BUMPS[high_steepness_at]
            high_middle_at = high_at + 6
            high_middle = BUMPS[high_middle_at]
            high_radius_at = high_at + 7
            high_radius = BUMPS[high_radius_at]
            high_bump = _circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615384973585606)
            high_joined = high_bump
        beta_high = high_wall - high_joined
        alpha_low_in = alpha[i]
        alpha_low_positive = 0.0 < alpha_low_in
        alpha_low_raised = alpha_low_in if alpha_low_positive else 0.0
        alpha_low_small = alpha_low_raised < 41.0
        alpha_low = alpha_low_raised if alpha_low_small else 41.0
        alpha_high_at = i + 2
        alpha_high_in = alpha[alpha_high_at]
        alpha_high_positive = 0.0 < alpha_high_in
        alpha_high_raised = alpha_high_in if alpha_high_positive else 0.0
        alpha_high_small = alpha_high_raised < 41.0
        alpha_high = alpha_high_raised if alpha_high_small else 41.0
        psi_low = beta_high - rho_low
        psi_high = rho_high - beta_low
        rate_low, jacobian_low = _update_rate(psi_low, alpha_low, 0.009999999776482582, 5.0, 1.0, 100.0)
        rate[i] = rate_low
        jacobian[i] = jacobian_low
        rate_high, jacobian_high = _update_rate(psi_high, alpha_high, 0.009999999776482582, 5.0, 1.0, 100.0)
        high_out_at = i + 2
        rate[high_out_at] = rate_high
        jacobian[high_out_at] = jacobian_high
    return tuple(rate), tuple(jacobian)


def tube(t, alpha):
    """Edges of the tube gamma (10) at time t (seconds) for the update function alpha, in the task's units.
    t below 0 counts as 0 and above t_c as t_c; NaN when t or alpha is not finite.
    """
    t = float(t)
    alpha = _vector("alpha", alpha, 4)
    lower = [0.0] * 2
    upper = [0.0] * 2
    t_zero = t * 0.0
    zero = t_zero
    for j in range(4):
        alpha_j = alpha[j]
        alpha_zero = alpha_j * 0.0
        zeros = zero + alpha_zero
        zero = zeros
    finite = zero <= 0.0
    bad = not finite
    if bad:
        for m in range(2):
            lower[m] = math.nan
            upper[m] = math.nan
        return tuple(lower), tuple(upper)
    held = _hold(t, 9.0)
    sigma = _profile(held, 9.0)
    for i in range(2):
        reach_row = i * 4
        wall_row = i * 2
        low_start = REACH[reach_row]
        low_end_at = reach_row + 1
        low_end = REACH[low_end_at]
        rho_low = _reach_edge(low_start, low_end, sigma)
        high_start_at = reach_row + 2
        high_start = REACH[high_start_at]
        high_end_at = reach_row + 3
        high_end = REACH[high_end_at]
        rho_high = _reach_edge(high_start, high_end, sigma)
        low_wall = WALLS[wall_row]
        low_bumps_at = i * 8
        low_joined = 0.0
        for low_j in range(1):
            low_offset = low_j * 4
            low_at = low_bumps_at + low_offset
            low_height = BUMPS[low_at]
            low_steepness_at = low_at + 1
            low_steepness = BUMPS[low_steepness_at]
            low_middle_at = low_at + 2
            low_middle = BUMPS[low_middle_at]
            low_radius_at = low_at + 3
            low_radius = BUMPS[low_radius_at]
            low_bump = _circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615384973585606)
            low_joined = low_bump
        beta_low = low_wall + low_joined
        high_wall_at = wall_row + 1
        high_wall = WALLS[high_wall_at]
        high_bumps_at = i * 8
        high_joined = 0.0
        for high_j in range(1):
            high_offset = high_j * 4
            high_at = high_bumps_at + high_offset
            high_height_at = high_at + 4
            high_height = BUMPS[high_height_at]
            high_steepness_at = high_at + 5
            high_steepness = BUMPS[high_steepness_at]
            high_middle_at = high_at + 6
            high_middle = BUMPS[high_middle_at]
            high_radius_at = high_at + 7
            high_radius = BUMPS[high_radius_at]
            high_bump = _circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615384973585606)
            high_joined = high_bump
        beta_high = high_wall - high_joined
        alpha_low_in = alpha[i]
        alpha_low_positive = 0.0 < alpha_low_in
        alpha_low_raised = alpha_low_in if alpha_low_positive else 0.0
        alpha_low_small = alpha_low_raised < 41.0
        alpha_low = alpha_low_raised if alpha_low_small else 41.0
        alpha_high_at = i + 2
        alpha_high_in = alpha[alpha_high_at]
        alpha_high_positive = 0.0 < alpha_high_in
        alpha_high_raised = alpha_high_in if alpha_high_positive else 0.0
        alpha_high_small = alpha_high_raised < 41.0
        alpha_high = alpha_high_raised if alpha_high_small else 41.0
        gamma_low = _lower_edge(rho_low, alpha_low, beta_low, 100.0)
        gamma_high = _upper_edge(rho_high, alpha_high, beta_high, 100.0)
        lower[i] = gamma_low
        upper[i] = gamma_high
    return tuple(lower), tuple(upper)


def tube_rate(t, alpha):
    """Total rate of the edges, d gamma / d t along (11), at time t (seconds), in units per second.
    Before 0 the rate at 0; from t_c on only alpha moves. NaN when t or alpha is not finite.
    """
    t = float(t)
    alpha = _vector("alpha", alpha, 4)
    lower_rate = [0.0] * 2
    upper_rate = [0.0] * 2
    t_zero = t * 0.0
    zero = t_zero
    for j in range(4):
        alpha_j = alpha[j]
        alpha_zero = alpha_j * 0.0
        zeros = zero + alpha_zero
        zero = zeros
    finite = zero <= 0.0
    bad = not finite
    if bad:
        for m in range(2):
            lower_rate[m] = math.nan
            upper_rate[m] = math.nan
        return tuple(lower_rate), tuple(upper_rate)
    held = _hold(t, 9.0)
    sigma, sigma_rate = _profile_rate(held, 9.0)
    for i in range(2):
        reach_row = i * 4
        wall_row = i * 2
        low_start = REACH[reach_row]
        low_end_at = reach_row + 1
        low_end = REACH[low_end_at]
        rho_low = _reach_edge(low_start, low_end, sigma)
        rho_low_rate = _reach_rate(low_start, low_end, sigma_rate)
        high_start_at = reach_row + 2
        high_start = REACH[high_start_at]
        high_end_at = reach_row + 3
        high_end = REACH[high_end_at]
        rho_high = _reach_edge(high_start, high_end, sigma)
        rho_high_rate = _reach_rate(high_start, high_end, sigma_rate)
        low_wall = WALLS[wall_row]
        low_bumps_at = i * 8
        low_joined = 0.0
        low_joined_rate = 0.0
        for low_j in range(1):
            low_offset = low_j * 4
            low_at = low_bumps_at + low_offset
            low_height = BUMPS[low_at]
            low_steepness_at = low_at + 1
            low_steepness = BUMPS[low_steepness_at]
            low_middle_at = low_at + 2
            low_middle = BUMPS[low_middle_at]
            low_radius_at = low_at + 3
            low_radius = BUMPS[low_radius_at]
            low_bump, low_bump_rate = _circumvent_rate(held, low_height, low_steepness, low_middle, low_radius, 0.009615384973585606)
            low_joined = low_bump
            low_joined_rate = low_bump_rate
        beta_low = low_wall + low_joined
        high_wall_at = wall_row + 1
        high_wall = WALLS[high_wall_at]
        high_bumps_at = i * 8
        high_joined = 0.0
        high_joined_rate = 0.0
        for high_j in range(1):
            high_offset = high_j * 4
            high_at = high_bumps_at + high_offset
            high_height_at = high_at + 4
            high_height = BUMPS[high_height_at]
            high_steepness_at = high_at + 5
            high_steepness = BUMPS[high_steepness_at]
            high_middle_at = high_at + 6
            high_middle = BUMPS[high_middle_at]
            high_radius_at = high_at + 7
            high_radius = BUMPS[high_radius_at]
            high_bump, high_bump_rate = _circumvent_rate(held, high_height, high_steepness, high_middle, high_radius, 0.009615384973585606)
            high_joined = high_bump
            high_joined_rate = high_bump_rate
        beta_high = high_wall - high_joined
        beta_high_rate = -high_joined_rate
        alpha_low_in = alpha[i]
        alpha_low_positive = 0.0 < alpha_low_in
        alpha_low_raised = alpha_low_in if alpha_low_positive else 0.0
        alpha_low_small = alpha_low_raised < 41.0
        alpha_low = alpha_low_raised if alpha_low_small else 41.0
        alpha_high_at = i + 2
        alpha_high_in = alpha[alpha_high_at]
        alpha_high_positive = 0.0 < alpha_high_in
        alpha_high_raised = alpha_high_in if alpha_high_positive else 0.0
        alpha_high_small = alpha_high_raised < 41.0
        alpha_high = alpha_high_raised if alpha_high_small else 41.0
        psi_low = beta_high - rho_low
        psi_high = rho_high - beta_low
        alpha_low_rate, jacobian_low = _update_rate(psi_low, alpha_low, 0.009999999776482582, 5.0, 1.0, 100.0)
        gamma_low, gamma_low_rate = _lower_edge_rate(rho_low, alpha_low, beta_low, 100.0, rho_low_rate, alpha_low_rate, low_joined_rate)
        lower_rate[i] = gamma_low_rate
        alpha_high_rate, jacobian_high = _update_rate(psi_high, alpha_high, 0.009999999776482582, 5.0, 1.0, 100.0)
        gamma_high, gamma_high_rate = _upper_edge_rate(rho_high, alpha_high, beta_high, 100.0, rho_high_rate, alpha_high_rate, beta_high_rate)
        upper_rate[i] = gamma_high_rate
    return tuple(lower_rate), tuple(upper_rate)


def control(t, alpha, x):
    """Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
    t: seconds since the start (held within [0, t_c]); alpha: the update function at t; x: state; u: input.
    OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
    (0 where the tube is empty). BAD_INPUT: t, alpha or x has a NaN or an infinity; u is 0. u may be the array x itself.
    """
    t = float(t)
    alpha = _vector("alpha", alpha, 4)
    x = _vector("x", x, 2)
    u = [0.0] * 2
    t_zero = t * 0.0
    zero = t_zero
    for j in range(4):
        alpha_j = alpha[j]
        alpha_zero = alpha_j * 0.0
        zeros = zero + alpha_zero
        zero = zeros
    x_zeros = zero
    for k in range(2):
        x_k = x[k]
        x_zero = x_k * 0.0
        x_sum = x_zeros + x_zero
        x_zeros = x_sum
    finite = x_zeros <= 0.0
    bad = not finite
    if bad:
        for m in range(2):
            u[m] = 0.0
        return BAD_INPUT, tuple(u)
    held = _hold(t, 9.0)
    sigma = _profile(held, 9.0)
    outside = False
    for i in range(2):
        reach_row = i * 4
        wall_row = i * 2
        low_start = REACH[reach_row]
        low_end_at = reach_row + 1
        low_end = REACH[low_end_at]
        rho_low = _reach_edge(low_start, low_end, sigma)
        high_start_at = reach_row + 2
        high_start = REACH[high_start_at]
        high_end_at = reach_row + 3
        high_end = REACH[high_end_at]
        rho_high = _reach_edge(high_start, high_end, sigma)
        low_wall = WALLS[wall_row]
        low_bumps_at = i * 8
        low_joined = 0.0
        for low_j in range(1):
            low_offset = low_j * 4
            low_at = low_bumps_at + low_offset
            low_height = BUMPS[low_at]
            low_steepness_at = low_at + 1
            low_steepness = BUMPS[low_steepness_at]
            low_middle_at = low_at + 2
            low_middle = BUMPS[low_middle_at]
            low_radius_at = low_at + 3
            low_radius = BUMPS[low_radius_at]
            low_bump = _circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615384973585606)
            low_joined = low_bump
        beta_low = low_wall + low_joined
        high_wall_at = wall_row + 1
        high_wall = WALLS[high_wall_at]
        high_bumps_at = i * 8
        high_joined = 0.0
        for high_j in range(1):
            high_offset = high_j * 4
            high_at = high_bumps_at + high_offset
            high_height_at = high_at + 4
            high_height = BUMPS[high_height_at]
            high_steepness_at = high_at + 5
            high_steepness = BUMPS[high_steepness_at]
            high_middle_at = high_at + 6
            high_middle = BUMPS[high_middle_at]
            high_radius_at = high_at + 7
            high_radius = BUMPS[high_radius_at]
            high_bump = _circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615384973585606)
            high_joined = high_bump
        beta_high = high_wall - high_joined
        alpha_low_in = alpha[i]
        alpha_low_positive = 0.0 < alpha_low_in
        alpha_low_raised = alpha_low_in if alpha_low_positive else 0.0
        alpha_low_small = alpha_low_raised < 41.0
        alpha_low = alpha_low_raised if alpha_low_small else 41.0
        alpha_high_at = i + 2
        alpha_high_in = alpha[alpha_high_at]
        alpha_high_positive = 0.0 < alpha_high_in
        alpha_high_raised = alpha_high_in if alpha_high_positive else 0.0
        alpha_high_small = alpha_high_raised < 41.0
        alpha_high = alpha_high_raised if alpha_high_small else 41.0
        gamma_low = _lower_edge(rho_low, alpha_low, beta_low, 100.0)
        gamma_high = _upper_edge(rho_high, alpha_high, beta_high, 100.0)
        x_i = x[i]
        width = gamma_high - gamma_low
        filled = 0.0 < width
        empty = not filled
        wide = 9.5367431640625e-7 < width
        safe_width = width if wide else 9.5367431640625e-7
        to_lower = x_i - gamma_low
        to_upper = gamma_high - x_i
        upper_nearer = to_upper < to_lower
        distance = to_upper if upper_nearer else to_lower
        gain = -0.5 if upper_nearer else 0.5
        smallest = safe_width * 0.004999999888241291
        widened = safe_width - width
        half = widened * 0.5
        safe_distance = distance + half
        farther = smallest < safe_distance
        clear = filled and farther
        to_nearer = safe_distance if clear else smallest
        to_farther = safe_width - to_nearer
        inside = 0.0 < distance
        outside_next = outside if inside else True
        epsilon, xi = _transformed_error(to_nearer, to_farther)
        u_i = _law(gain, xi, epsilon)
        u_or_zero = 0.0 if empty else u_i
        u[i] = u_or_zero
        outside = outside_next
    return OUTSIDE_TUBE if outside else OK, tuple(u)


def margin(t, alpha, x):
    """How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
    components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
    Watch it: act while there is margin, not when the tube is left.
    """
    t = float(t)
    alpha = _vector("alpha", alpha, 4)
    x = _vector("x", x, 2)
    t_zero = t * 0.0
    zero = t_zero
    for j in range(4):
        alpha_j = alpha[j]
        alpha_zero = alpha_j * 0.0
        zeros = zero + alpha_zero
        zero = zeros
    x_zeros = zero
    for k in range(2):
        x_k = x[k]
        x_zero = x_k * 0.0
        x_sum = x_zeros + x_zero
        x_zeros = x_sum
    finite = x_zeros <= 0.0
    bad = not finite
    if bad:
        return math.nan
    held = _hold(t, 9.0)
    sigma = _profile(held, 9.0)
    margin = 0.5
    for i in range(2):
        reach_row = i * 4
        wall_row = i * 2
        low_start = REACH[reach_row]
        low_end_at = reach_row + 1
        low_end = REACH[low_end_at]
        rho_low = _reach_edge(low_start, low_end, sigma)
        high_start_at = reach_row + 2
        high_start = REACH[high_start_at]
        high_end_at = reach_row + 3
        high_end = REACH[high_end_at]
        rho_high = _reach_edge(high_start, high_end, sigma)
        low_wall = WALLS[wall_row]
        low_bumps_at = i * 8
        low_joined = 0.0
        for low_j in range(1):
            low_offset = low_j * 4
            low_at = low_bumps_at + low_offset
            low_height = BUMPS[low_at]
            low_steepness_at = low_at + 1
            low_steepness = BUMPS[low_steepness_at]
            low_middle_at = low_at + 2
            low_middle = BUMPS[low_middle_at]
            low_radius_at = low_at + 3
            low_radius = BUMPS[low_radius_at]
            low_bump = _circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615384973585606)
            low_joined = low_bump
        beta_low = low_wall + low_joined
        high_wall_at = wall_row + 1
        high_wall = WALLS[high_wall_at]
        high_bumps_at = i * 8
        high_joined = 0.0
        for high_j in range(1):
            high_offset = high_j * 4
            high_at = high_bumps_at + high_offset
            high_height_at = high_at + 4
            high_height = BUMPS[high_height_at]
            high_steepness_at = high_at + 5
            high_steepness = BUMPS[high_steepness_at]
            high_middle_at = high_at + 6
            high_middle = BUMPS[high_middle_at]
            high_radius_at = high_at + 7
            high_radius = BUMPS[high_radius_at]
            high_bump = _circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615384973585606)
            high_joined = high_bump
        beta_high = high_wall - high_joined
        alpha_low_in = alpha[i]
        alpha_low_positive = 0.0 < alpha_low_in
        alpha_low_raised = alpha_low_in if alpha_low_positive else 0.0
        alpha_low_small = alpha_low_raised < 41.0
        alpha_low = alpha_low_raised if alpha_low_small else 41.0
        alpha_high_at = i + 2
        alpha_high_in = alpha[alpha_high_at]
        alpha_high_positive = 0.0 < alpha_high_in
        alpha_high_raised = alpha_high_in if alpha_high_positive else 0.0
        alpha_high_small = alpha_high_raised < 41.0
        alpha_high = alpha_high_raised if alpha_high_small else 41.0
        gamma_low = _lower_edge(rho_low, alpha_low, beta_low, 100.0)
        gamma_high = _upper_edge(rho_high, alpha_high, beta_high, 100.0)
        x_i = x[i]
        width = gamma_high - gamma_low
        wide = 9.5367431640625e-7 < width
        safe_width = width if wide else 9.5367431640625e-7
        to_lower = x_i - gamma_low
        to_upper = gamma_high - x_i
        x_nearer = to_upper < to_lower
        x_distance = to_upper if x_nearer else to_lower
        x_share = x_distance / safe_width
        x_beyond = x_share < -1.0
        margin_x = -1.0 if x_beyond else x_share
        less = margin_x < margin
        margin_next = margin_x if less else margin
        margin = margin_next
    return margin


def margins(t, alpha, x):
    """The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
    components where another argument is not finite.
    """
    t = float(t)
    alpha = _vector("alpha", alpha, 4)
    x = _vector("x", x, 2)
    margin = [0.0] * 2
    t_zero = t * 0.0
    zero = t_zero
    for j in range(4):
        alpha_j = alpha[j]
        alpha_zero = alpha_j * 0.0
        zeros = zero + alpha_zero
        zero = zeros
    finite = zero <= 0.0
    bad = not finite
    if bad:
        for m in range(2):
            margin[m] = math.nan
        return tuple(margin)
    held = _hold(t, 9.0)
    sigma = _profile(held, 9.0)
    for i in range(2):
        reach_row = i * 4
        wall_row = i * 2
        low_start = REACH[reach_row]
        low_end_at = reach_row + 1
        low_end = REACH[low_end_at]
        rho_low = _reach_edge(low_start, low_end, sigma)
        high_start_at = reach_row + 2
        high_start = REACH[high_start_at]
        high_end_at = reach_row + 3
        high_end = REACH[high_end_at]
        rho_high = _reach_edge(high_start, high_end, sigma)
        low_wall = WALLS[wall_row]
        low_bumps_at = i * 8
        low_joined = 0.0
        for low_j in range(1):
            low_offset = low_j * 4
            low_at = low_bumps_at + low_offset
            low_height = BUMPS[low_at]
            low_steepness_at = low_at + 1
            low_steepness = BUMPS[low_steepness_at]
            low_middle_at = low_at + 2
            low_middle = BUMPS[low_middle_at]
            low_radius_at = low_at + 3
            low_radius = BUMPS[low_radius_at]
            low_bump = _circumvent(held, low_height, low_steepness, low_middle, low_radius, 0.009615384973585606)
            low_joined = low_bump
        beta_low = low_wall + low_joined
        high_wall_at = wall_row + 1
        high_wall = WALLS[high_wall_at]
        high_bumps_at = i * 8
        high_joined = 0.0
        for high_j in range(1):
            high_offset = high_j * 4
            high_at = high_bumps_at + high_offset
            high_height_at = high_at + 4
            high_height = BUMPS[high_height_at]
            high_steepness_at = high_at + 5
            high_steepness = BUMPS[high_steepness_at]
            high_middle_at = high_at + 6
            high_middle = BUMPS[high_middle_at]
            high_radius_at = high_at + 7
            high_radius = BUMPS[high_radius_at]
            high_bump = _circumvent(held, high_height, high_steepness, high_middle, high_radius, 0.009615384973585606)
            high_joined = high_bump
        beta_high = high_wall - high_joined
        alpha_low_in = alpha[i]
        alpha_low_positive = 0.0 < alpha_low_in
        alpha_low_raised = alpha_low_in if alpha_low_positive else 0.0
        alpha_low_small = alpha_low_raised < 41.0
        alpha_low = alpha_low_raised if alpha_low_small else 41.0
        alpha_high_at = i + 2
        alpha_high_in = alpha[alpha_high_at]
        alpha_high_positive = 0.0 < alpha_high_in
        alpha_high_raised = alpha_high_in if alpha_high_positive else 0.0
        alpha_high_small = alpha_high_raised < 41.0
        alpha_high = alpha_high_raised if alpha_high_small else 41.0
        gamma_low = _lower_edge(rho_low, alpha_low, beta_low, 100.0)
        gamma_high = _upper_edge(rho_high, alpha_high, beta_high, 100.0)
        x_i = x[i]
        width = gamma_high - gamma_low
        wide = 9.5367431640625e-7 < width
        safe_width = width if wide else 9.5367431640625e-7
        to_lower = x_i - gamma_low
        to_upper = gamma_high - x_i
        x_nearer = to_upper < to_lower
        x_distance = to_upper if x_nearer else to_lower
        x_share = x_distance / safe_width
        x_beyond = x_share < -1.0
        margin_x = -1.0 if x_beyond else x_share
        margin[i] = margin_x
    return tuple(margin)


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
