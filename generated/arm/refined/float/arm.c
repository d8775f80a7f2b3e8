/* arm.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (arm.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.006 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= [1.3, 3.1], [0.92, 0.7] <= g_ii <= [1.08, 1.32], |g_ij| <= [0.06, 0.56]: |e| of v + lambda x < [0.8023,
 * 0.8669], |u| <= [2.2, 6.8].
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "arm.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "arm.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "arm.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "arm.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "arm.c: float is not IEEE-754's here, for which rounding is bounded"
#endif
/* No fused multiply-adds: Arduino's and other -std=gnu.. compilers would make them. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#pragma clang fp reassociate(off)
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#endif

/* B-spline control points divided by 6, one row for each of 32 + 3 points:
 * lower[0], upper[0], lower[1], upper[1]
 * Multiples of 2^-21: exact in float and double.
 */
static const arm_real arm_coefficients[140] = {
    -0.19122458F, -0.1412344F, 0.10855436F, 0.15854406F,
    -0.19188023F, -0.14189053F, 0.10823059F, 0.15822029F,
    -0.19122458F, -0.1412344F, 0.10855436F, 0.15854406F,
    -0.18925762F, -0.13926744F, 0.109526634F, 0.15951633F,
    -0.18597889F, -0.13598919F, 0.11114693F, 0.16113663F,
    -0.18138933F, -0.13139963F, 0.11341524F, 0.16340542F,
    -0.175488F, -0.1254983F, 0.116332054F, 0.16632175F,
    -0.16827583F, -0.118285656F, 0.11989641F, 0.16988659F,
    -0.15975189F, -0.10976219F, 0.12410927F, 0.17409897F,
    -0.14991665F, -0.09992695F, 0.12897015F, 0.17895985F,
    -0.1387701F, -0.0887804F, 0.13447905F, 0.18446922F,
    -0.12631226F, -0.07632208F, 0.14063644F, 0.19062614F,
    -0.11254263F, -0.06255293F, 0.14744186F, 0.19743156F,
    -0.09746218F, -0.047472477F, 0.15489483F, 0.204885F,
    -0.08106995F, -0.031080246F, 0.16299343F, 0.21298361F,
    -0.06336689F, -0.013376713F, 0.17044401F, 0.22043371F,
    -0.044352055F, 0.0056376457F, 0.17789459F, 0.2278843F,
    -0.024027348F, 0.025962353F, 0.18534517F, 0.23533487F,
    -0.004356861F, 0.04563284F, 0.19214725F, 0.24213743F,
    0.014001846F, 0.06399202F, 0.19894981F, 0.24893951F,
    0.031049728F, 0.08103943F, 0.2054863F, 0.25547647F,
    0.04678583F, 0.09677601F, 0.21202326F, 0.26201296F,
    0.06121111F, 0.11120081F, 0.21791172F, 0.26790142F,
    0.07432461F, 0.12431431F, 0.22380018F, 0.27379036F,
    0.086126804F, 0.1361165F, 0.22904062F, 0.2790308F,
    0.0966177F, 0.1466074F, 0.23363304F, 0.28362274F,
    0.10579729F, 0.15578699F, 0.23757744F, 0.28756714F,
    0.11366558F, 0.16365528F, 0.24087334F, 0.29086304F,
    0.12022209F, 0.17021227F, 0.24352121F, 0.2935114F,
    0.12546778F, 0.17545748F, 0.24611378F, 0.29610348F,
    0.12940168F, 0.17939138F, 0.24805832F, 0.29804802F,
    0.13202429F, 0.18201447F, 0.24935436F, 0.29934406F,
    0.13333607F, 0.18332577F, 0.25000238F, 0.29999256F,
    0.13333607F, 0.18332577F, 0.25000238F, 0.29999256F,
    0.13333607F, 0.18332577F, 0.25000238F, 0.29999256F
};

/* Gain k of the control law, by component. */
static const arm_real arm_gain[2] = {
    0.0268F, 0.0843F
};

/* Saturation of u, by component. */
static const arm_real arm_u_max[2] = {
    2.1999998F, 6.7999997F
};

/* Covered starts have x strictly above these bounds, by component. */
static const arm_real arm_start_lower[2] = {
    -1.1199758F, 0.6800252F
};

/* Covered starts have x strictly below these bounds, by component. */
static const arm_real arm_start_upper[2] = {
    -0.88002515F, 0.91997516F
};

/* The same of v + lambda x: strictly above these bounds. */
static const arm_real arm_filtered_start_lower[2] = {
    -0.6719848F, 0.40801585F
};

/* The same of v + lambda x: strictly below these bounds. */
static const arm_real arm_filtered_start_upper[2] = {
    -0.52801585F, 0.55198437F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 14 s).
 */
static inline void arm_segment(arm_real t, int32_t *row, arm_real *s)
{
    const bool positive = 0.0F < t;
    const arm_real started = positive ? t : 0.0F;
    const arm_real scaled = started * 2.2857144F;
    const bool early = scaled < 31.999998F;
    const arm_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const arm_real base = (arm_real)segment;
    const arm_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void arm_basis(arm_real s, arm_real *w0, arm_real *w1, arm_real *w2, arm_real *w3)
{
    const arm_real v0 = 1.0F - s;
    const arm_real v1 = v0 * v0;
    const arm_real v2 = v1 * v0;
    const arm_real v3 = v0 * s;
    const arm_real v4 = 1.0F + v3;
    const arm_real v5 = 3.0F * v4;
    const arm_real v6 = v0 * v5;
    const arm_real v7 = 1.0F + v6;
    const arm_real v8 = s * v5;
    const arm_real v9 = 1.0F + v8;
    const arm_real v10 = s * s;
    const arm_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void arm_basis_rate(arm_real s, arm_real *dw0, arm_real *dw1, arm_real *dw2, arm_real *dw3)
{
    const arm_real v0 = 1.0F - s;
    const arm_real v1 = v0 + v0;
    const arm_real v2 = v0 * v1;
    const arm_real v3 = v0 * v0;
    const arm_real v4 = v2 + v3;
    const arm_real v5 = -v4;
    const arm_real v6 = v0 - s;
    const arm_real v7 = 3.0F * v6;
    const arm_real v8 = v0 * v7;
    const arm_real v9 = v0 * s;
    const arm_real v10 = 1.0F + v9;
    const arm_real v11 = 3.0F * v10;
    const arm_real v12 = v8 - v11;
    const arm_real v13 = s * v7;
    const arm_real v14 = v11 + v13;
    const arm_real v15 = s + s;
    const arm_real v16 = s * v15;
    const arm_real v17 = s * s;
    const arm_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline arm_real arm_edge_at(int32_t at, arm_real w0, arm_real w1, arm_real w2, arm_real w3)
{
    const arm_real q0 = arm_coefficients[at];
    const int32_t at_1 = at + 4;
    const arm_real q1 = arm_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const arm_real q2 = arm_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const arm_real q3 = arm_coefficients[at_3];
    const arm_real v0 = w0 * q0;
    const arm_real v1 = w1 * q1;
    const arm_real v2 = v0 + v1;
    const arm_real v3 = w2 * q2;
    const arm_real v4 = w3 * q3;
    const arm_real v5 = v3 + v4;
    const arm_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline arm_real arm_normalized_error(arm_real a, arm_real b, arm_real width)
{
    const arm_real v0 = a - b;
    const arm_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void arm_transformed_error(arm_real a, arm_real b, arm_real *epsilon, arm_real *xi)
{
    const arm_real v0 = b / a;
    const arm_real v1 = logf(v0);
    const arm_real v2 = -v1;
    const arm_real v3 = 1.0F + v0;
    const arm_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline arm_real arm_law(arm_real k, arm_real xi, arm_real epsilon)
{
    const arm_real v0 = k * xi;
    const arm_real v1 = v0 * epsilon;
    const arm_real v2 = -v1;
    return v2;
}

void arm_tube(arm_real t, arm_real lower[ARM_N], arm_real upper[ARM_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (arm_real)NAN;
            upper[j] = (arm_real)NAN;
        }
        return;
    }
    int32_t row;
    arm_real s;
    arm_segment(t, &row, &s);
    arm_real w0;
    arm_real w1;
    arm_real w2;
    arm_real w3;
    arm_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const arm_real lower_edge = arm_edge_at(lower_at, w0, w1, w2, w3);
        const arm_real upper_edge = arm_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void arm_tube_rate(arm_real t, arm_real lower_rate[ARM_N], arm_real upper_rate[ARM_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (arm_real)NAN;
            upper_rate[j] = (arm_real)NAN;
        }
        return;
    }
    int32_t row;
    arm_real s;
    arm_segment(t, &row, &s);
    arm_real dw0;
    arm_real dw1;
    arm_real dw2;
    arm_real dw3;
    arm_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 14.0F;
    const arm_real per_second = moving ? 2.2857144F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const arm_real lower_slope = arm_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const arm_real lower_speed = lower_slope * per_second;
        const arm_real upper_slope = arm_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const arm_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

void arm_filtered_tube(arm_real t, arm_real lower[ARM_N], arm_real upper[ARM_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (arm_real)NAN;
            upper[j] = (arm_real)NAN;
        }
        return;
    }
    int32_t row;
    arm_real s;
    arm_segment(t, &row, &s);
    arm_real w0;
    arm_real w1;
    arm_real w2;
    arm_real w3;
    arm_basis(s, &w0, &w1, &w2, &w3);
    arm_real dw0;
    arm_real dw1;
    arm_real dw2;
    arm_real dw3;
    arm_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const arm_real lower_edge = arm_edge_at(lower_at, w0, w1, w2, w3);
        const arm_real upper_edge = arm_edge_at(upper_at, w0, w1, w2, w3);
        const arm_real lower_slope = arm_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const arm_real lower_rate = lower_slope * 2.2857144F;
        const arm_real upper_slope = arm_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const arm_real upper_rate = upper_slope * 2.2857144F;
        const arm_real lower_part = lower_edge * 0.6F;
        const arm_real z_lower = lower_rate + lower_part;
        lower[i] = z_lower;
        const arm_real upper_part = upper_edge * 0.6F;
        const arm_real z_upper = upper_rate + upper_part;
        upper[i] = z_upper;
    }
}

arm_status arm_control(arm_real t, const arm_real x[ARM_N], const arm_real v[ARM_N], arm_real u[ARM_N])
{
    const arm_real t_zero = t * 0.0F;
    arm_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const arm_real x_j = x[j];
        const arm_real x_zero = x_j * 0.0F;
        const arm_real zeros = zero + x_zero;
        zero = zeros;
    }
    arm_real v_zeros = zero;
    for (int32_t k = 0; k < 2; ++k) {
        const arm_real v_k = v[k];
        const arm_real v_zero = v_k * 0.0F;
        const arm_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return ARM_BAD_INPUT;
    }
    int32_t row;
    arm_real s;
    arm_segment(t, &row, &s);
    arm_real w0;
    arm_real w1;
    arm_real w2;
    arm_real w3;
    arm_basis(s, &w0, &w1, &w2, &w3);
    arm_real dw0;
    arm_real dw1;
    arm_real dw2;
    arm_real dw3;
    arm_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const arm_real lower_edge = arm_edge_at(lower_at, w0, w1, w2, w3);
        const arm_real upper_edge = arm_edge_at(upper_at, w0, w1, w2, w3);
        const arm_real lower_slope = arm_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const arm_real lower_rate = lower_slope * 2.2857144F;
        const arm_real upper_slope = arm_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const arm_real upper_rate = upper_slope * 2.2857144F;
        const arm_real x_i = x[i];
        const arm_real v_i = v[i];
        const arm_real width = upper_edge - lower_edge;
        const arm_real to_lower = x_i - lower_edge;
        const arm_real to_upper = upper_edge - x_i;
        const arm_real v_width = upper_rate - lower_rate;
        const arm_real v_to_lower = v_i - lower_rate;
        const arm_real v_to_upper = upper_rate - v_i;
        const arm_real gain_i = arm_gain[i];
        const arm_real gain_minus = -gain_i;
        const arm_real width_part = width * 0.6F;
        const arm_real z_width = v_width + width_part;
        const arm_real lower_part = to_lower * 0.6F;
        const arm_real z_to_lower = v_to_lower + lower_part;
        const arm_real upper_part = to_upper * 0.6F;
        const arm_real z_to_upper = v_to_upper + upper_part;
        const bool upper_nearer = z_to_upper < z_to_lower;
        const arm_real distance = upper_nearer ? z_to_upper : z_to_lower;
        const arm_real gain = upper_nearer ? gain_minus : gain_i;
        const arm_real smallest = z_width * 0.005F;
        const bool clear = smallest < distance;
        const arm_real to_nearer = clear ? distance : smallest;
        const arm_real to_farther = z_width - to_nearer;
        const bool x_above = 0.0F < to_lower;
        const bool x_below = 0.0F < to_upper;
        const bool x_inside = x_above && x_below;
        const bool z_inside = 0.0F < distance;
        const bool inside = z_inside && x_inside;
        const bool outside_next = inside ? outside : true;
        const arm_real u_limit = arm_u_max[i];
        arm_real epsilon;
        arm_real xi;
        arm_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const arm_real u_i = arm_law(gain, xi, epsilon);
        const arm_real u_min = -u_limit;
        const bool u_above = u_min < u_i;
        const arm_real u_raised = u_above ? u_i : u_min;
        const bool u_beyond = u_limit < u_raised;
        const arm_real u_limited = u_beyond ? u_limit : u_raised;
        u[i] = u_limited;
        outside = outside_next;
    }
    return outside ? ARM_OUTSIDE_TUBE : ARM_OK;
}

arm_real arm_margin(arm_real t, const arm_real x[ARM_N], const arm_real v[ARM_N])
{
    const arm_real t_zero = t * 0.0F;
    arm_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const arm_real x_j = x[j];
        const arm_real x_zero = x_j * 0.0F;
        const arm_real zeros = zero + x_zero;
        zero = zeros;
    }
    arm_real v_zeros = zero;
    for (int32_t k = 0; k < 2; ++k) {
        const arm_real v_k = v[k];
        const arm_real v_zero = v_k * 0.0F;
        const arm_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (arm_real)NAN;
    }
    int32_t row;
    arm_real s;
    arm_segment(t, &row, &s);
    arm_real w0;
    arm_real w1;
    arm_real w2;
    arm_real w3;
    arm_basis(s, &w0, &w1, &w2, &w3);
    arm_real dw0;
    arm_real dw1;
    arm_real dw2;
    arm_real dw3;
    arm_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    arm_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const arm_real lower_edge = arm_edge_at(lower_at, w0, w1, w2, w3);
        const arm_real upper_edge = arm_edge_at(upper_at, w0, w1, w2, w3);
        const arm_real lower_slope = arm_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const arm_real lower_rate = lower_slope * 2.2857144F;
        const arm_real upper_slope = arm_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const arm_real upper_rate = upper_slope * 2.2857144F;
        const arm_real x_i = x[i];
        const arm_real v_i = v[i];
        const arm_real width = upper_edge - lower_edge;
        const arm_real to_lower = x_i - lower_edge;
        const arm_real to_upper = upper_edge - x_i;
        const arm_real v_width = upper_rate - lower_rate;
        const arm_real v_to_lower = v_i - lower_rate;
        const arm_real v_to_upper = upper_rate - v_i;
        const arm_real width_part = width * 0.6F;
        const arm_real z_width = v_width + width_part;
        const arm_real lower_part = to_lower * 0.6F;
        const arm_real z_to_lower = v_to_lower + lower_part;
        const arm_real upper_part = to_upper * 0.6F;
        const arm_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const arm_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const arm_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0F);
        const arm_real margin_z = z_beyond ? (-1.0F) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const arm_real x_distance = x_nearer ? to_upper : to_lower;
        const arm_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const arm_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const arm_real smaller = x_smaller ? margin_x : margin_z;
        const bool less = smaller < margin;
        const arm_real margin_next = less ? smaller : margin;
        margin = margin_next;
    }
    return margin;
}

void arm_margins(arm_real t, const arm_real x[ARM_N], const arm_real v[ARM_N], arm_real margin[ARM_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (arm_real)NAN;
        }
        return;
    }
    int32_t row;
    arm_real s;
    arm_segment(t, &row, &s);
    arm_real w0;
    arm_real w1;
    arm_real w2;
    arm_real w3;
    arm_basis(s, &w0, &w1, &w2, &w3);
    arm_real dw0;
    arm_real dw1;
    arm_real dw2;
    arm_real dw3;
    arm_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const arm_real lower_edge = arm_edge_at(lower_at, w0, w1, w2, w3);
        const arm_real upper_edge = arm_edge_at(upper_at, w0, w1, w2, w3);
        const arm_real lower_slope = arm_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const arm_real lower_rate = lower_slope * 2.2857144F;
        const arm_real upper_slope = arm_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const arm_real upper_rate = upper_slope * 2.2857144F;
        const arm_real x_i = x[i];
        const arm_real v_i = v[i];
        const arm_real width = upper_edge - lower_edge;
        const arm_real to_lower = x_i - lower_edge;
        const arm_real to_upper = upper_edge - x_i;
        const arm_real v_width = upper_rate - lower_rate;
        const arm_real v_to_lower = v_i - lower_rate;
        const arm_real v_to_upper = upper_rate - v_i;
        const arm_real width_part = width * 0.6F;
        const arm_real z_width = v_width + width_part;
        const arm_real lower_part = to_lower * 0.6F;
        const arm_real z_to_lower = v_to_lower + lower_part;
        const arm_real upper_part = to_upper * 0.6F;
        const arm_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const arm_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const arm_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0F);
        const arm_real margin_z = z_beyond ? (-1.0F) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const arm_real x_distance = x_nearer ? to_upper : to_lower;
        const arm_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const arm_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const arm_real smaller = x_smaller ? margin_x : margin_z;
        margin[i] = smaller;
    }
}

bool arm_covered(const arm_real x[ARM_N], const arm_real v[ARM_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const arm_real x_i = x[i];
        const arm_real x_lower = arm_start_lower[i];
        const arm_real x_upper = arm_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const arm_real x_part = x_i * 0.6F;
        const arm_real v_i = v[i];
        const arm_real z_i = v_i + x_part;
        const arm_real z_lower = arm_filtered_start_lower[i];
        const arm_real z_upper = arm_filtered_start_upper[i];
        const bool z_above = z_lower < z_i;
        const bool z_below = z_i < z_upper;
        const bool z_inside = z_above && z_below;
        const bool inside = x_inside && z_inside;
        const bool covered_next = inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void arm_transform(const arm_real lower[ARM_N], const arm_real upper[ARM_N], const arm_real x[ARM_N],
                   arm_real e[ARM_N], arm_real epsilon[ARM_N], arm_real xi[ARM_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const arm_real lower_edge = lower[i];
        const arm_real upper_edge = upper[i];
        const arm_real x_i = x[i];
        const arm_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const arm_real safe_width = wide ? width : 9.536743e-7F;
        const arm_real to_lower = x_i - lower_edge;
        const arm_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const arm_real distance = upper_nearer ? to_upper : to_lower;
        const arm_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const arm_real smallest = safe_width * 0.005F;
        const arm_real widened = safe_width - width;
        const arm_real half = widened * 0.5F;
        const arm_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const arm_real to_nearer = clear ? safe_distance : smallest;
        const arm_real to_farther = safe_width - to_nearer;
        const arm_real a = upper_nearer ? to_farther : to_nearer;
        const arm_real b = upper_nearer ? to_nearer : to_farther;
        const arm_real e_i = arm_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const arm_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const arm_real e_limited = e_beyond ? 0.99F : e_raised;
        arm_real epsilon_nearer;
        arm_real xi_i;
        arm_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const arm_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const arm_real e_or_zero = empty ? 0.0F : e_limited;
        const arm_real e_out = finite ? e_or_zero : (arm_real)NAN;
        e[i] = e_out;
        const arm_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const arm_real epsilon_out = finite ? epsilon_or_zero : (arm_real)NAN;
        epsilon[i] = epsilon_out;
        const arm_real xi_or_zero = empty ? 0.0F : xi_i;
        const arm_real xi_out = finite ? xi_or_zero : (arm_real)NAN;
        xi[i] = xi_out;
    }
}
