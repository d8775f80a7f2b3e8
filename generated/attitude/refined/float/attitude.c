/* attitude.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (attitude.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.06 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= [0.045, 0.03, 0.04], 0.91 <= g_ii <= 1.09, |g_ij| <= [0.1, 0.03, 0.035], x measured to 0.0005, v measured to
 * 0.0005: |e| of v + lambda x < [0.9021, 0.8401, 0.8667], |u| <= [0.09, 0.06, 0.08].
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "attitude.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "attitude.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "attitude.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "attitude.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "attitude.c: float is not IEEE-754's here, for which rounding is bounded"
#endif
/* No fused multiply-adds: Arduino's and other -std=gnu.. compilers would make them. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#pragma clang fp reassociate(off)
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#endif

/* B-spline control points divided by 6, one row for each of 32 + 3 points:
 * lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]
 * Multiples of 2^-22: exact in float and double.
 */
static const attitude_real attitude_coefficients[210] = {
    -0.016664028F, 0.016664028F, -0.08289361F, -0.049565315F,
    -0.18289375F, -0.14956546F,
    -0.016664028F, 0.016664028F, -0.08354926F, -0.050221205F,
    -0.1835494F, -0.15022111F,
    -0.016664028F, 0.016664028F, -0.08289361F, -0.049565315F,
    -0.18289375F, -0.14956546F,
    -0.016664028F, 0.016664028F, -0.08092666F, -0.047598362F,
    -0.1809268F, -0.1475985F,
    -0.016664028F, 0.016664028F, -0.07764816F, -0.044319868F,
    -0.1776483F, -0.14432001F,
    -0.016664028F, 0.016664028F, -0.07305837F, -0.03973031F,
    -0.17305875F, -0.13973045F,
    -0.016664028F, 0.016664028F, -0.06715727F, -0.033828974F,
    -0.16715765F, -0.13382936F,
    -0.016664028F, 0.016664028F, -0.059944868F, -0.026616573F,
    -0.15994501F, -0.12661695F,
    -0.016664028F, 0.016664028F, -0.051420927F, -0.018092632F,
    -0.15142131F, -0.118093014F,
    -0.016664028F, 0.016664028F, -0.041585684F, -0.008257389F,
    -0.14158607F, -0.10825777F,
    -0.016664028F, 0.016664028F, -0.030439138F, 0.0028891563F,
    -0.13043952F, -0.097111225F,
    -0.016664028F, 0.016664028F, -0.01798129F, 0.015347004F,
    -0.11798167F, -0.08465338F,
    -0.016664028F, 0.016664028F, -0.0043447018F, 0.028983593F,
    -0.10421252F, -0.07088423F,
    -0.016664028F, 0.016664028F, 0.009126425F, 0.04245472F,
    -0.08913183F, -0.055803537F,
    -0.016664028F, 0.016664028F, 0.02128625F, 0.054614544F,
    -0.07273984F, -0.039411545F,
    -0.016664028F, 0.016664028F, 0.03213477F, 0.06546283F,
    -0.055036545F, -0.02170825F,
    -0.016664028F, 0.016664028F, 0.041671753F, 0.07500005F,
    -0.03602171F, -0.0026934147F,
    -0.016664028F, 0.016664028F, 0.049897432F, 0.08322573F,
    -0.015695572F, 0.017632484F,
    -0.016664028F, 0.016664028F, 0.05681181F, 0.090140104F,
    0.003974676F, 0.03730297F,
    -0.016664028F, 0.016664028F, 0.062414885F, 0.09574294F,
    0.02233386F, 0.055662155F,
    -0.016664028F, 0.016664028F, 0.06670642F, 0.100034714F,
    0.039381504F, 0.0727098F,
    -0.016664028F, 0.016664028F, 0.06968665F, 0.103014946F,
    0.055117846F, 0.08844614F,
    -0.016664028F, 0.016664028F, 0.07135558F, 0.104683876F,
    0.069542885F, 0.10287118F,
    -0.016664028F, 0.016664028F, 0.07171297F, 0.105041265F,
    0.08265662F, 0.11598492F,
    -0.016664028F, 0.016664028F, 0.0707593F, 0.10408759F,
    0.09445882F, 0.12778711F,
    -0.016664028F, 0.016664028F, 0.06849408F, 0.101822376F,
    0.10494971F, 0.13827801F,
    -0.016664028F, 0.016664028F, 0.064917564F, 0.09824562F,
    0.114129305F, 0.1474576F,
    -0.016664028F, 0.016664028F, 0.060029507F, 0.0933578F,
    0.121997595F, 0.15532565F,
    -0.016664028F, 0.016664028F, 0.05478406F, 0.088112354F,
    0.12855434F, 0.16188264F,
    -0.016664028F, 0.016664028F, 0.049538612F, 0.08286691F,
    0.13379979F, 0.16712809F,
    -0.016664028F, 0.016664028F, 0.045604467F, 0.07893276F,
    0.13773394F, 0.171062F,
    -0.016664028F, 0.016664028F, 0.042981863F, 0.07631016F,
    0.14035654F, 0.17368484F,
    -0.016664028F, 0.016664028F, 0.04167056F, 0.07499862F,
    0.14166784F, 0.17499614F,
    -0.016664028F, 0.016664028F, 0.04167056F, 0.07499862F,
    0.14166784F, 0.17499614F,
    -0.016664028F, 0.016664028F, 0.04167056F, 0.07499862F,
    0.14166784F, 0.17499614F
};

/* Gain k of the control law, by component. */
static const attitude_real attitude_gain[3] = {
    0.00012F, 0.000078F, 0.0000977F
};

/* Saturation of u, by component. */
static const attitude_real attitude_u_max[3] = {
    0.089999996F, 0.06F, 0.08F
};

/* Covered starts have x strictly above these bounds, by component. */
static const attitude_real attitude_start_lower[3] = {
    -0.07948714F, -0.47948718F, -1.0794879F
};

/* Covered starts have x strictly below these bounds, by component. */
static const attitude_real attitude_start_upper[3] = {
    0.07948714F, -0.32051253F, -0.92051256F
};

/* The same of v + lambda x: strictly above these bounds. */
static const attitude_real attitude_filtered_start_lower[3] = {
    -0.009038385F, -0.057038378F, -0.12903844F
};

/* The same of v + lambda x: strictly below these bounds. */
static const attitude_real attitude_filtered_start_upper[3] = {
    0.009038385F, -0.038961586F, -0.1109616F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 60 s).
 */
static inline void attitude_segment(attitude_real t, int32_t *row, attitude_real *s)
{
    const bool positive = 0.0F < t;
    const attitude_real started = positive ? t : 0.0F;
    const attitude_real scaled = started * 0.53333336F;
    const bool early = scaled < 31.999998F;
    const attitude_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const attitude_real base = (attitude_real)segment;
    const attitude_real place = u - base;
    const int32_t first = segment * 6;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void attitude_basis(attitude_real s, attitude_real *w0, attitude_real *w1, attitude_real *w2,
                                  attitude_real *w3)
{
    const attitude_real v0 = 1.0F - s;
    const attitude_real v1 = v0 * v0;
    const attitude_real v2 = v1 * v0;
    const attitude_real v3 = v0 * s;
    const attitude_real v4 = 1.0F + v3;
    const attitude_real v5 = 3.0F * v4;
    const attitude_real v6 = v0 * v5;
    const attitude_real v7 = 1.0F + v6;
    const attitude_real v8 = s * v5;
    const attitude_real v9 = 1.0F + v8;
    const attitude_real v10 = s * s;
    const attitude_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void attitude_basis_rate(attitude_real s, attitude_real *dw0, attitude_real *dw1,
                                       attitude_real *dw2, attitude_real *dw3)
{
    const attitude_real v0 = 1.0F - s;
    const attitude_real v1 = v0 + v0;
    const attitude_real v2 = v0 * v1;
    const attitude_real v3 = v0 * v0;
    const attitude_real v4 = v2 + v3;
    const attitude_real v5 = -v4;
    const attitude_real v6 = v0 - s;
    const attitude_real v7 = 3.0F * v6;
    const attitude_real v8 = v0 * v7;
    const attitude_real v9 = v0 * s;
    const attitude_real v10 = 1.0F + v9;
    const attitude_real v11 = 3.0F * v10;
    const attitude_real v12 = v8 - v11;
    const attitude_real v13 = s * v7;
    const attitude_real v14 = v11 + v13;
    const attitude_real v15 = s + s;
    const attitude_real v16 = s * v15;
    const attitude_real v17 = s * s;
    const attitude_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline attitude_real attitude_edge_at(int32_t at, attitude_real w0, attitude_real w1, attitude_real w2,
                                             attitude_real w3)
{
    const attitude_real q0 = attitude_coefficients[at];
    const int32_t at_1 = at + 6;
    const attitude_real q1 = attitude_coefficients[at_1];
    const int32_t at_2 = at + 12;
    const attitude_real q2 = attitude_coefficients[at_2];
    const int32_t at_3 = at + 18;
    const attitude_real q3 = attitude_coefficients[at_3];
    const attitude_real v0 = w0 * q0;
    const attitude_real v1 = w1 * q1;
    const attitude_real v2 = v0 + v1;
    const attitude_real v3 = w2 * q2;
    const attitude_real v4 = w3 * q3;
    const attitude_real v5 = v3 + v4;
    const attitude_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline attitude_real attitude_normalized_error(attitude_real a, attitude_real b, attitude_real width)
{
    const attitude_real v0 = a - b;
    const attitude_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void attitude_transformed_error(attitude_real a, attitude_real b, attitude_real *epsilon,
                                              attitude_real *xi)
{
    const attitude_real v0 = b / a;
    const attitude_real v1 = logf(v0);
    const attitude_real v2 = -v1;
    const attitude_real v3 = 1.0F + v0;
    const attitude_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline attitude_real attitude_law(attitude_real k, attitude_real xi, attitude_real epsilon)
{
    const attitude_real v0 = k * xi;
    const attitude_real v1 = v0 * epsilon;
    const attitude_real v2 = -v1;
    return v2;
}

void attitude_tube(attitude_real t, attitude_real lower[ATTITUDE_N], attitude_real upper[ATTITUDE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (attitude_real)NAN;
            upper[j] = (attitude_real)NAN;
        }
        return;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real w0;
    attitude_real w1;
    attitude_real w2;
    attitude_real w3;
    attitude_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_edge = attitude_edge_at(lower_at, w0, w1, w2, w3);
        const attitude_real upper_edge = attitude_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void attitude_tube_rate(attitude_real t, attitude_real lower_rate[ATTITUDE_N],
                        attitude_real upper_rate[ATTITUDE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower_rate[j] = (attitude_real)NAN;
            upper_rate[j] = (attitude_real)NAN;
        }
        return;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real dw0;
    attitude_real dw1;
    attitude_real dw2;
    attitude_real dw3;
    attitude_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 60.0F;
    const attitude_real per_second = moving ? 0.53333336F : 0.0F;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_slope = attitude_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const attitude_real lower_speed = lower_slope * per_second;
        const attitude_real upper_slope = attitude_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const attitude_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

void attitude_filtered_tube(attitude_real t, attitude_real lower[ATTITUDE_N], attitude_real upper[ATTITUDE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (attitude_real)NAN;
            upper[j] = (attitude_real)NAN;
        }
        return;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real w0;
    attitude_real w1;
    attitude_real w2;
    attitude_real w3;
    attitude_basis(s, &w0, &w1, &w2, &w3);
    attitude_real dw0;
    attitude_real dw1;
    attitude_real dw2;
    attitude_real dw3;
    attitude_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_edge = attitude_edge_at(lower_at, w0, w1, w2, w3);
        const attitude_real upper_edge = attitude_edge_at(upper_at, w0, w1, w2, w3);
        const attitude_real lower_slope = attitude_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const attitude_real lower_rate = lower_slope * 0.53333336F;
        const attitude_real upper_slope = attitude_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const attitude_real upper_rate = upper_slope * 0.53333336F;
        const attitude_real lower_part = lower_edge * 0.12F;
        const attitude_real z_lower = lower_rate + lower_part;
        lower[i] = z_lower;
        const attitude_real upper_part = upper_edge * 0.12F;
        const attitude_real z_upper = upper_rate + upper_part;
        upper[i] = z_upper;
    }
}

attitude_status attitude_control(attitude_real t, const attitude_real x[ATTITUDE_N],
                                 const attitude_real v[ATTITUDE_N], attitude_real u[ATTITUDE_N])
{
    const attitude_real t_zero = t * 0.0F;
    attitude_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const attitude_real x_j = x[j];
        const attitude_real x_zero = x_j * 0.0F;
        const attitude_real zeros = zero + x_zero;
        zero = zeros;
    }
    attitude_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const attitude_real v_k = v[k];
        const attitude_real v_zero = v_k * 0.0F;
        const attitude_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 3; ++m) {
            u[m] = 0.0F;
        }
        return ATTITUDE_BAD_INPUT;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real w0;
    attitude_real w1;
    attitude_real w2;
    attitude_real w3;
    attitude_basis(s, &w0, &w1, &w2, &w3);
    attitude_real dw0;
    attitude_real dw1;
    attitude_real dw2;
    attitude_real dw3;
    attitude_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    bool outside = false;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_edge = attitude_edge_at(lower_at, w0, w1, w2, w3);
        const attitude_real upper_edge = attitude_edge_at(upper_at, w0, w1, w2, w3);
        const attitude_real lower_slope = attitude_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const attitude_real lower_rate = lower_slope * 0.53333336F;
        const attitude_real upper_slope = attitude_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const attitude_real upper_rate = upper_slope * 0.53333336F;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real width = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real v_width = upper_rate - lower_rate;
        const attitude_real v_to_lower = v_i - lower_rate;
        const attitude_real v_to_upper = upper_rate - v_i;
        const attitude_real gain_i = attitude_gain[i];
        const attitude_real gain_minus = -gain_i;
        const attitude_real width_part = width * 0.12F;
        const attitude_real z_width = v_width + width_part;
        const attitude_real lower_part = to_lower * 0.12F;
        const attitude_real z_to_lower = v_to_lower + lower_part;
        const attitude_real upper_part = to_upper * 0.12F;
        const attitude_real z_to_upper = v_to_upper + upper_part;
        const bool upper_nearer = z_to_upper < z_to_lower;
        const attitude_real distance = upper_nearer ? z_to_upper : z_to_lower;
        const attitude_real gain = upper_nearer ? gain_minus : gain_i;
        const attitude_real smallest = z_width * 0.005F;
        const bool clear = smallest < distance;
        const attitude_real to_nearer = clear ? distance : smallest;
        const attitude_real to_farther = z_width - to_nearer;
        const bool x_above = 0.0F < to_lower;
        const bool x_below = 0.0F < to_upper;
        const bool x_inside = x_above && x_below;
        const bool z_inside = 0.0F < distance;
        const bool inside = z_inside && x_inside;
        const bool outside_next = inside ? outside : true;
        const attitude_real u_limit = attitude_u_max[i];
        attitude_real epsilon;
        attitude_real xi;
        attitude_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const attitude_real u_i = attitude_law(gain, xi, epsilon);
        const attitude_real u_min = -u_limit;
        const bool u_above = u_min < u_i;
        const attitude_real u_raised = u_above ? u_i : u_min;
        const bool u_beyond = u_limit < u_raised;
        const attitude_real u_limited = u_beyond ? u_limit : u_raised;
        u[i] = u_limited;
        outside = outside_next;
    }
    return outside ? ATTITUDE_OUTSIDE_TUBE : ATTITUDE_OK;
}

attitude_real attitude_margin(attitude_real t, const attitude_real x[ATTITUDE_N],
                              const attitude_real v[ATTITUDE_N])
{
    const attitude_real t_zero = t * 0.0F;
    attitude_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const attitude_real x_j = x[j];
        const attitude_real x_zero = x_j * 0.0F;
        const attitude_real zeros = zero + x_zero;
        zero = zeros;
    }
    attitude_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const attitude_real v_k = v[k];
        const attitude_real v_zero = v_k * 0.0F;
        const attitude_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (attitude_real)NAN;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real w0;
    attitude_real w1;
    attitude_real w2;
    attitude_real w3;
    attitude_basis(s, &w0, &w1, &w2, &w3);
    attitude_real dw0;
    attitude_real dw1;
    attitude_real dw2;
    attitude_real dw3;
    attitude_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    attitude_real margin = 0.5F;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_edge = attitude_edge_at(lower_at, w0, w1, w2, w3);
        const attitude_real upper_edge = attitude_edge_at(upper_at, w0, w1, w2, w3);
        const attitude_real lower_slope = attitude_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const attitude_real lower_rate = lower_slope * 0.53333336F;
        const attitude_real upper_slope = attitude_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const attitude_real upper_rate = upper_slope * 0.53333336F;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real width = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real v_width = upper_rate - lower_rate;
        const attitude_real v_to_lower = v_i - lower_rate;
        const attitude_real v_to_upper = upper_rate - v_i;
        const attitude_real width_part = width * 0.12F;
        const attitude_real z_width = v_width + width_part;
        const attitude_real lower_part = to_lower * 0.12F;
        const attitude_real z_to_lower = v_to_lower + lower_part;
        const attitude_real upper_part = to_upper * 0.12F;
        const attitude_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const attitude_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const attitude_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0F);
        const attitude_real margin_z = z_beyond ? (-1.0F) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const attitude_real x_distance = x_nearer ? to_upper : to_lower;
        const attitude_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const attitude_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const attitude_real smaller = x_smaller ? margin_x : margin_z;
        const bool less = smaller < margin;
        const attitude_real margin_next = less ? smaller : margin;
        margin = margin_next;
    }
    return margin;
}

void attitude_margins(attitude_real t, const attitude_real x[ATTITUDE_N], const attitude_real v[ATTITUDE_N],
                      attitude_real margin[ATTITUDE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            margin[j] = (attitude_real)NAN;
        }
        return;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real w0;
    attitude_real w1;
    attitude_real w2;
    attitude_real w3;
    attitude_basis(s, &w0, &w1, &w2, &w3);
    attitude_real dw0;
    attitude_real dw1;
    attitude_real dw2;
    attitude_real dw3;
    attitude_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_edge = attitude_edge_at(lower_at, w0, w1, w2, w3);
        const attitude_real upper_edge = attitude_edge_at(upper_at, w0, w1, w2, w3);
        const attitude_real lower_slope = attitude_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const attitude_real lower_rate = lower_slope * 0.53333336F;
        const attitude_real upper_slope = attitude_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const attitude_real upper_rate = upper_slope * 0.53333336F;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real width = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real v_width = upper_rate - lower_rate;
        const attitude_real v_to_lower = v_i - lower_rate;
        const attitude_real v_to_upper = upper_rate - v_i;
        const attitude_real width_part = width * 0.12F;
        const attitude_real z_width = v_width + width_part;
        const attitude_real lower_part = to_lower * 0.12F;
        const attitude_real z_to_lower = v_to_lower + lower_part;
        const attitude_real upper_part = to_upper * 0.12F;
        const attitude_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const attitude_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const attitude_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0F);
        const attitude_real margin_z = z_beyond ? (-1.0F) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const attitude_real x_distance = x_nearer ? to_upper : to_lower;
        const attitude_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const attitude_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const attitude_real smaller = x_smaller ? margin_x : margin_z;
        margin[i] = smaller;
    }
}

bool attitude_covered(const attitude_real x[ATTITUDE_N], const attitude_real v[ATTITUDE_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 3; ++i) {
        const attitude_real x_i = x[i];
        const attitude_real x_lower = attitude_start_lower[i];
        const attitude_real x_upper = attitude_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const attitude_real x_part = x_i * 0.12F;
        const attitude_real v_i = v[i];
        const attitude_real z_i = v_i + x_part;
        const attitude_real z_lower = attitude_filtered_start_lower[i];
        const attitude_real z_upper = attitude_filtered_start_upper[i];
        const bool z_above = z_lower < z_i;
        const bool z_below = z_i < z_upper;
        const bool z_inside = z_above && z_below;
        const bool inside = x_inside && z_inside;
        const bool covered_next = inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void attitude_transform(const attitude_real lower[ATTITUDE_N], const attitude_real upper[ATTITUDE_N],
                        const attitude_real x[ATTITUDE_N], attitude_real e[ATTITUDE_N],
                        attitude_real epsilon[ATTITUDE_N], attitude_real xi[ATTITUDE_N])
{
    for (int32_t i = 0; i < 3; ++i) {
        const attitude_real lower_edge = lower[i];
        const attitude_real upper_edge = upper[i];
        const attitude_real x_i = x[i];
        const attitude_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const attitude_real safe_width = wide ? width : 9.536743e-7F;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const attitude_real distance = upper_nearer ? to_upper : to_lower;
        const attitude_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const attitude_real smallest = safe_width * 0.005F;
        const attitude_real widened = safe_width - width;
        const attitude_real half = widened * 0.5F;
        const attitude_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const attitude_real to_nearer = clear ? safe_distance : smallest;
        const attitude_real to_farther = safe_width - to_nearer;
        const attitude_real a = upper_nearer ? to_farther : to_nearer;
        const attitude_real b = upper_nearer ? to_nearer : to_farther;
        const attitude_real e_i = attitude_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const attitude_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const attitude_real e_limited = e_beyond ? 0.99F : e_raised;
        attitude_real epsilon_nearer;
        attitude_real xi_i;
        attitude_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const attitude_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const attitude_real e_or_zero = empty ? 0.0F : e_limited;
        const attitude_real e_out = finite ? e_or_zero : (attitude_real)NAN;
        e[i] = e_out;
        const attitude_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const attitude_real epsilon_out = finite ? epsilon_or_zero : (attitude_real)NAN;
        epsilon[i] = epsilon_out;
        const attitude_real xi_or_zero = empty ? 0.0F : xi_i;
        const attitude_real xi_out = finite ? xi_or_zero : (attitude_real)NAN;
        xi[i] = xi_out;
    }
}
