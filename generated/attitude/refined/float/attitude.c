/* attitude.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (attitude.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.06 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= [0.045, 0.03, 0.04], 0.91 <= g_ii <= 1.09, |g_ij| <= [0.1, 0.03, 0.035], x measured to 0.0005, v measured to
 * 0.0005: |e| of v + lambda x < [0.8474, 0.8001, 0.8001], |u| <= [0.09, 0.06, 0.08].
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "attitude.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "attitude.c: compile without -ffast-math; it tests its inputs for NaN and infinity"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)
#error "attitude.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
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
    0.000301F, 0.000202F, 0.000255F
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

/* An edge of the tube (or its slope in spline time): sum of w_j q_j. */
static inline attitude_real attitude_blend(attitude_real w0, attitude_real w1, attitude_real w2,
                                           attitude_real w3, attitude_real q0, attitude_real q1,
                                           attitude_real q2, attitude_real q3)
{
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
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_edge = attitude_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        lower[i] = lower_edge;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_edge = attitude_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
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
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_slope = attitude_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_speed = lower_slope * per_second;
        lower_rate[i] = lower_speed;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_slope = attitude_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_speed = upper_slope * per_second;
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
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_edge = attitude_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_slope = attitude_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_rate = lower_slope * 0.53333336F;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_edge = attitude_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_slope = attitude_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_rate = upper_slope * 0.53333336F;
        const attitude_real filtered = lower_edge * 0.12F;
        const attitude_real edge = lower_rate + filtered;
        lower[i] = edge;
        const attitude_real filtered2 = upper_edge * 0.12F;
        const attitude_real edge2 = upper_rate + filtered2;
        upper[i] = edge2;
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
    attitude_real zero2 = zero;
    for (int32_t j2 = 0; j2 < 3; ++j2) {
        const attitude_real v_j = v[j2];
        const attitude_real v_zero = v_j * 0.0F;
        const attitude_real zeros2 = zero2 + v_zero;
        zero2 = zeros2;
    }
    const bool finite = zero2 <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j3 = 0; j3 < 3; ++j3) {
            u[j3] = 0.0F;
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
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_edge = attitude_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_slope = attitude_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_rate = lower_slope * 0.53333336F;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_edge = attitude_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_slope = attitude_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_rate = upper_slope * 0.53333336F;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real room = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real room2 = upper_rate - lower_rate;
        const attitude_real to_lower2 = v_i - lower_rate;
        const attitude_real to_upper2 = upper_rate - v_i;
        const attitude_real gain_i = attitude_gain[i];
        const attitude_real gain_minus = -gain_i;
        const attitude_real filtered = room * 0.12F;
        const attitude_real room3 = room2 + filtered;
        const attitude_real filtered2 = to_lower * 0.12F;
        const attitude_real to_lower3 = to_lower2 + filtered2;
        const attitude_real filtered3 = to_upper * 0.12F;
        const attitude_real to_upper3 = to_upper2 + filtered3;
        const bool upper_nearer = to_upper3 < to_lower3;
        const attitude_real nearest = upper_nearer ? to_upper3 : to_lower3;
        const attitude_real gain = upper_nearer ? gain_minus : gain_i;
        const attitude_real least = room3 * 0.005F;
        const bool clear = least < nearest;
        const attitude_real near = clear ? nearest : least;
        const attitude_real far = room3 - near;
        const bool over = 0.0F < to_lower;
        const bool under = 0.0F < to_upper;
        const bool between = over && under;
        const bool within = 0.0F < nearest;
        const bool inside = within && between;
        const bool outside_any = inside ? outside : true;
        const attitude_real u_limit = attitude_u_max[i];
        attitude_real epsilon;
        attitude_real xi;
        attitude_transformed_error(near, far, &epsilon, &xi);
        const attitude_real push = attitude_law(gain, xi, epsilon);
        const attitude_real u_min = -u_limit;
        const bool u_held_above = u_min < push;
        const attitude_real u_held_raised = u_held_above ? push : u_min;
        const bool u_held_over = u_limit < u_held_raised;
        const attitude_real u_held = u_held_over ? u_limit : u_held_raised;
        u[i] = u_held;
        outside = outside_any;
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
    attitude_real zero2 = zero;
    for (int32_t j2 = 0; j2 < 3; ++j2) {
        const attitude_real v_j = v[j2];
        const attitude_real v_zero = v_j * 0.0F;
        const attitude_real zeros2 = zero2 + v_zero;
        zero2 = zeros2;
    }
    const bool finite = zero2 <= 0.0F;
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
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_edge = attitude_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_slope = attitude_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_rate = lower_slope * 0.53333336F;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_edge = attitude_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_slope = attitude_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_rate = upper_slope * 0.53333336F;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real room = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real room2 = upper_rate - lower_rate;
        const attitude_real to_lower2 = v_i - lower_rate;
        const attitude_real to_upper2 = upper_rate - v_i;
        const attitude_real filtered = room * 0.12F;
        const attitude_real room3 = room2 + filtered;
        const attitude_real filtered2 = to_lower * 0.12F;
        const attitude_real to_lower3 = to_lower2 + filtered2;
        const attitude_real filtered3 = to_upper * 0.12F;
        const attitude_real to_upper3 = to_upper2 + filtered3;
        const bool upper_nearer = to_upper3 < to_lower3;
        const attitude_real nearest = upper_nearer ? to_upper3 : to_lower3;
        const attitude_real share = nearest / room3;
        const bool beyond = share < (-1.0F);
        const attitude_real held_share = beyond ? (-1.0F) : share;
        const bool upper_nearer2 = to_upper < to_lower;
        const attitude_real nearest2 = upper_nearer2 ? to_upper : to_lower;
        const attitude_real share2 = nearest2 / room;
        const bool beyond2 = share2 < (-1.0F);
        const attitude_real held_share2 = beyond2 ? (-1.0F) : share2;
        const bool filtered_less = held_share < held_share2;
        const attitude_real lesser = filtered_less ? held_share : held_share2;
        const bool less = lesser < margin;
        const attitude_real margin_next = less ? lesser : margin;
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
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_edge = attitude_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_slope = attitude_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_rate = lower_slope * 0.53333336F;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_edge = attitude_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_slope = attitude_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_rate = upper_slope * 0.53333336F;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real room = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real room2 = upper_rate - lower_rate;
        const attitude_real to_lower2 = v_i - lower_rate;
        const attitude_real to_upper2 = upper_rate - v_i;
        const attitude_real filtered = room * 0.12F;
        const attitude_real room3 = room2 + filtered;
        const attitude_real filtered2 = to_lower * 0.12F;
        const attitude_real to_lower3 = to_lower2 + filtered2;
        const attitude_real filtered3 = to_upper * 0.12F;
        const attitude_real to_upper3 = to_upper2 + filtered3;
        const bool upper_nearer = to_upper3 < to_lower3;
        const attitude_real nearest = upper_nearer ? to_upper3 : to_lower3;
        const attitude_real share = nearest / room3;
        const bool beyond = share < (-1.0F);
        const attitude_real held_share = beyond ? (-1.0F) : share;
        const bool upper_nearer2 = to_upper < to_lower;
        const attitude_real nearest2 = upper_nearer2 ? to_upper : to_lower;
        const attitude_real share2 = nearest2 / room;
        const bool beyond2 = share2 < (-1.0F);
        const attitude_real held_share2 = beyond2 ? (-1.0F) : share2;
        const bool filtered_less = held_share < held_share2;
        const attitude_real lesser = filtered_less ? held_share : held_share2;
        margin[i] = lesser;
    }
}

bool attitude_covered(const attitude_real x[ATTITUDE_N], const attitude_real v[ATTITUDE_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 3; ++i) {
        const attitude_real x_i = x[i];
        const attitude_real start_lower_i = attitude_start_lower[i];
        const attitude_real start_upper_i = attitude_start_upper[i];
        const bool x_i_after = start_lower_i < x_i;
        const bool x_i_before = x_i < start_upper_i;
        const bool x_i_between = x_i_after && x_i_before;
        const attitude_real filtered = x_i * 0.12F;
        const attitude_real v_i = v[i];
        const attitude_real z = v_i + filtered;
        const attitude_real filtered_start_lower_i = attitude_filtered_start_lower[i];
        const attitude_real filtered_start_upper_i = attitude_filtered_start_upper[i];
        const bool z_after = filtered_start_lower_i < z;
        const bool z_before = z < filtered_start_upper_i;
        const bool z_between = z_after && z_before;
        const bool inside = x_i_between && z_between;
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
        const attitude_real room = upper_edge - lower_edge;
        const bool filled = 0.0F < room;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < room;
        const attitude_real width = wide ? room : 9.536743e-7F;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const attitude_real nearest = upper_nearer ? to_upper : to_lower;
        const attitude_real gain = upper_nearer ? (-1.0F) : 1.0F;
        const attitude_real least = width * 0.005F;
        const attitude_real widened = width - room;
        const attitude_real spare = widened * 0.5F;
        const attitude_real distance = nearest + spare;
        const bool farther = least < distance;
        const bool clear = filled && farther;
        const attitude_real near = clear ? distance : least;
        const attitude_real far = width - near;
        const attitude_real a = upper_nearer ? far : near;
        const attitude_real b = upper_nearer ? near : far;
        const attitude_real e_raw = attitude_normalized_error(a, b, width);
        const bool e_held_above = (-0.99F) < e_raw;
        const attitude_real e_held_raised = e_held_above ? e_raw : (-0.99F);
        const bool e_held_over = 0.99F < e_held_raised;
        const attitude_real e_held = e_held_over ? 0.99F : e_held_raised;
        attitude_real epsilon_near;
        attitude_real xi_i;
        attitude_transformed_error(near, far, &epsilon_near, &xi_i);
        const attitude_real epsilon_i = gain * epsilon_near;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_room = isfinite(room) != 0;
        const bool finite = finite_x && finite_room;
        const attitude_real e_settled = empty ? 0.0F : e_held;
        const attitude_real e_out = finite ? e_settled : (attitude_real)NAN;
        e[i] = e_out;
        const attitude_real epsilon_settled = empty ? 0.0F : epsilon_i;
        const attitude_real epsilon_out = finite ? epsilon_settled : (attitude_real)NAN;
        epsilon[i] = epsilon_out;
        const attitude_real xi_settled = empty ? 0.0F : xi_i;
        const attitude_real xi_out = finite ? xi_settled : (attitude_real)NAN;
        xi[i] = xi_out;
    }
}
