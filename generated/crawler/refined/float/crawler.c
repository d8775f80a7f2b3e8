/* crawler.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (crawler.certificate.json): for every t the tube keeps 0.05 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The state stays in it (P9) sampled every 0.005 s or faster, from every start with |e(0)| <= 0.9, for |f +
 * w| <= 0.1, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 0.002: |e| < 0.9001, |u| <= 1.3.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "crawler.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "crawler.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "crawler.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "crawler.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "crawler.c: float is not IEEE-754's here, for which rounding is bounded"
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
static const crawler_real crawler_coefficients[140] = {
    -0.009665489F, 0.1619091F, -0.022018433F, 0.14955616F,
    5.2452087e-6F, 0.16666174F, 5.2452087e-6F, 0.16666174F,
    0.009675503F, 0.1714139F, 0.022028923F, 0.18376732F,
    0.019346237F, 0.17616653F, 0.044052124F, 0.2008729F,
    0.029016495F, 0.18091917F, 0.0660758F, 0.21797848F,
    0.03868723F, 0.18567133F, 0.08809948F, 0.23508406F,
    0.048357487F, 0.19042397F, 0.11012316F, 0.25218964F,
    0.05802822F, 0.1951766F, 0.13214684F, 0.26929522F,
    0.06769848F, 0.19992924F, 0.15417051F, 0.2864008F,
    0.07736921F, 0.2046814F, 0.17619419F, 0.30350637F,
    0.08703995F, 0.20943403F, 0.19821787F, 0.32061195F,
    0.096710205F, 0.21418667F, 0.22024155F, 0.33771753F,
    0.10638094F, 0.21893883F, 0.24226522F, 0.3548231F,
    0.1160512F, 0.22860956F, 0.2642889F, 0.3768468F,
    0.12572193F, 0.23827982F, 0.2863121F, 0.39887047F,
    0.14577246F, 0.25833082F, 0.30833578F, 0.42089415F,
    0.16582346F, 0.27838135F, 0.33035946F, 0.44291782F,
    0.18587399F, 0.29843235F, 0.35238314F, 0.4649415F,
    0.20592499F, 0.31848288F, 0.35822582F, 0.4707842F,
    0.22597551F, 0.33853388F, 0.3640685F, 0.47662687F,
    0.24602652F, 0.3585844F, 0.3699112F, 0.48246956F,
    0.26607704F, 0.3786354F, 0.37575388F, 0.48831224F,
    0.28612804F, 0.39868593F, 0.38159657F, 0.49415493F,
    0.30617857F, 0.41873693F, 0.38743925F, 0.49999762F,
    0.32622957F, 0.43878746F, 0.38743925F, 0.49999762F,
    0.3462801F, 0.45883846F, 0.38743925F, 0.49999762F,
    0.3663311F, 0.478889F, 0.38743925F, 0.49999762F,
    0.38638163F, 0.49894F, 0.38743925F, 0.49999762F,
    0.40643263F, 0.5189905F, 0.38743925F, 0.49999762F,
    0.42648315F, 0.5390415F, 0.38743925F, 0.49999762F,
    0.44653416F, 0.55909204F, 0.38743925F, 0.49999762F,
    0.46658468F, 0.57914305F, 0.38743925F, 0.49999762F,
    0.48663568F, 0.5991936F, 0.38743925F, 0.49999762F,
    0.5066862F, 0.6192441F, 0.38743925F, 0.49999762F,
    0.48663568F, 0.5991936F, 0.38743925F, 0.49999762F
};

/* Gain k of the control law, by component. */
static const crawler_real crawler_gain[2] = {
    0.0388F, 0.0623F
};

/* Saturation of u, by component. */
static const crawler_real crawler_u_max[2] = {
    1.3F, 1.3F
};

/* Covered starts have x strictly above these bounds, by component. */
static const crawler_real crawler_start_lower[2] = {
    0.05202842F, 0.0520289F
};

/* Covered starts have x strictly below these bounds, by component. */
static const crawler_real crawler_start_upper[2] = {
    0.9479725F, 0.94797295F
};

/* The type must have 32 bits: avr-gcc's double, for one, has not. */
typedef char crawler_real_size[(sizeof(crawler_real) == 4U) ? 1 : -1];

/* y = m 2^e with m in [1/sqrt 2, sqrt 2), for y not below that: e, and m. */
static inline int32_t crawler_exponent(crawler_real y)
{
    uint32_t bits;
    (void)memcpy(&bits, &y, sizeof bits);
    return (int32_t)((bits - 0x3f3504f3U) >> 23);
}

static inline crawler_real crawler_mantissa(crawler_real y)
{
    uint32_t bits;
    (void)memcpy(&bits, &y, sizeof bits);
    bits = ((bits - 0x3f3504f3U) & 0x7fffffU) + 0x3f3504f3U;
    crawler_real m;
    (void)memcpy(&m, &bits, sizeof m);
    return m;
}

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 6 s).
 */
static inline void crawler_segment(crawler_real t, int32_t *row, crawler_real *s)
{
    const bool positive = 0.0F < t;
    const crawler_real started = positive ? t : 0.0F;
    const crawler_real scaled = started * 5.3333335F;
    const bool early = scaled < 31.999998F;
    const crawler_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const crawler_real base = (crawler_real)segment;
    const crawler_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* As segment, for a count of ticks: one is 2/375 of a segment, in integers; only s is rounded.
 * From tick 6000 on the last segment and s = 1, which is t_c.
 */
static inline void crawler_segment_at_tick(uint32_t tick, int32_t *row, crawler_real *s)
{
    const bool running = tick < 6000U;
    const uint32_t held = running ? tick : 6000U;
    const int32_t count = (int32_t)held;
    const int32_t passed = count * 2;
    const bool early = passed < 12000;
    const int32_t place = early ? passed : 12000;
    const int32_t whole = place / 375;
    const bool before_last = whole < 31;
    const int32_t segment = before_last ? whole : 31;
    const int32_t base = segment * 375;
    const int32_t rest = place - base;
    const crawler_real part = (crawler_real)rest;
    const crawler_real share = part / 375.0F;
    const int32_t first = segment * 4;
    *row = first;
    *s = share;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void crawler_basis(crawler_real s, crawler_real *w0, crawler_real *w1, crawler_real *w2,
                                 crawler_real *w3)
{
    const crawler_real v0 = 1.0F - s;
    const crawler_real v1 = v0 * v0;
    const crawler_real v2 = v1 * v0;
    const crawler_real v3 = v0 * s;
    const crawler_real v4 = 1.0F + v3;
    const crawler_real v5 = 3.0F * v4;
    const crawler_real v6 = v0 * v5;
    const crawler_real v7 = 1.0F + v6;
    const crawler_real v8 = s * v5;
    const crawler_real v9 = 1.0F + v8;
    const crawler_real v10 = s * s;
    const crawler_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void crawler_basis_rate(crawler_real s, crawler_real *dw0, crawler_real *dw1, crawler_real *dw2,
                                      crawler_real *dw3)
{
    const crawler_real v0 = 1.0F - s;
    const crawler_real v1 = v0 + v0;
    const crawler_real v2 = v0 * v1;
    const crawler_real v3 = v0 * v0;
    const crawler_real v4 = v2 + v3;
    const crawler_real v5 = -v4;
    const crawler_real v6 = v0 - s;
    const crawler_real v7 = 3.0F * v6;
    const crawler_real v8 = v0 * v7;
    const crawler_real v9 = v0 * s;
    const crawler_real v10 = 1.0F + v9;
    const crawler_real v11 = 3.0F * v10;
    const crawler_real v12 = v8 - v11;
    const crawler_real v13 = s * v7;
    const crawler_real v14 = v11 + v13;
    const crawler_real v15 = s + s;
    const crawler_real v16 = s * v15;
    const crawler_real v17 = s * s;
    const crawler_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline crawler_real crawler_edge_at(int32_t at, crawler_real w0, crawler_real w1, crawler_real w2,
                                           crawler_real w3)
{
    const crawler_real q0 = crawler_coefficients[at];
    const int32_t at_1 = at + 4;
    const crawler_real q1 = crawler_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const crawler_real q2 = crawler_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const crawler_real q3 = crawler_coefficients[at_3];
    const crawler_real v0 = w0 * q0;
    const crawler_real v1 = w1 * q1;
    const crawler_real v2 = v0 + v1;
    const crawler_real v3 = w2 * q2;
    const crawler_real v4 = w3 * q3;
    const crawler_real v5 = v3 + v4;
    const crawler_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline crawler_real crawler_normalized_error(crawler_real a, crawler_real b, crawler_real width)
{
    const crawler_real v0 = a - b;
    const crawler_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b.
 * ln y by y = m 2^e as e ln 2 + 2 atanh((m - 1)/(m + 1)), with a relative error below 2^-14.
 */
static inline void crawler_transformed_error(crawler_real a, crawler_real b, crawler_real *epsilon,
                                             crawler_real *xi)
{
    const crawler_real v0 = b / a;
    const int32_t exponent = crawler_exponent(v0);
    const crawler_real base = (crawler_real)exponent;
    const crawler_real mantissa = crawler_mantissa(v0);
    const crawler_real below = mantissa - 1.0F;
    const crawler_real above = mantissa + 1.0F;
    const crawler_real s = below / above;
    const crawler_real z = s * s;
    const crawler_real bent = z * 0.6766044F;
    const crawler_real around = bent + 2.0F;
    const crawler_real part = s * around;
    const crawler_real whole = base * 0.6931472F;
    const crawler_real v1 = whole + part;
    const crawler_real v2 = -v1;
    const crawler_real v3 = 1.0F + v0;
    const crawler_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline crawler_real crawler_law(crawler_real k, crawler_real xi, crawler_real epsilon)
{
    const crawler_real v0 = k * xi;
    const crawler_real v1 = v0 * epsilon;
    const crawler_real v2 = -v1;
    return v2;
}

void crawler_tube(crawler_real t, crawler_real lower[CRAWLER_N], crawler_real upper[CRAWLER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (crawler_real)NAN;
            upper[j] = (crawler_real)NAN;
        }
        return;
    }
    int32_t row;
    crawler_real s;
    crawler_segment(t, &row, &s);
    crawler_real w0;
    crawler_real w1;
    crawler_real w2;
    crawler_real w3;
    crawler_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const crawler_real lower_edge = crawler_edge_at(lower_at, w0, w1, w2, w3);
        const crawler_real upper_edge = crawler_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void crawler_tube_rate(crawler_real t, crawler_real lower_rate[CRAWLER_N], crawler_real upper_rate[CRAWLER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (crawler_real)NAN;
            upper_rate[j] = (crawler_real)NAN;
        }
        return;
    }
    int32_t row;
    crawler_real s;
    crawler_segment(t, &row, &s);
    crawler_real dw0;
    crawler_real dw1;
    crawler_real dw2;
    crawler_real dw3;
    crawler_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 6.0F;
    const crawler_real per_second = moving ? 5.3333335F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const crawler_real lower_slope = crawler_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const crawler_real lower_speed = lower_slope * per_second;
        const crawler_real upper_slope = crawler_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const crawler_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

crawler_status crawler_control(crawler_real t, const crawler_real x[CRAWLER_N], crawler_real u[CRAWLER_N])
{
    const crawler_real t_zero = t * 0.0F;
    crawler_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const crawler_real x_j = x[j];
        const crawler_real x_zero = x_j * 0.0F;
        const crawler_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return CRAWLER_BAD_INPUT;
    }
    int32_t row;
    crawler_real s;
    crawler_segment(t, &row, &s);
    crawler_real w0;
    crawler_real w1;
    crawler_real w2;
    crawler_real w3;
    crawler_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const crawler_real lower_edge = crawler_edge_at(lower_at, w0, w1, w2, w3);
        const crawler_real upper_edge = crawler_edge_at(upper_at, w0, w1, w2, w3);
        const crawler_real x_i = x[i];
        const crawler_real gain_i = crawler_gain[i];
        const crawler_real gain_minus = -gain_i;
        const crawler_real width = upper_edge - lower_edge;
        const crawler_real to_lower = x_i - lower_edge;
        const crawler_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const crawler_real distance = upper_nearer ? to_upper : to_lower;
        const crawler_real gain = upper_nearer ? gain_minus : gain_i;
        const crawler_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const crawler_real to_nearer = clear ? distance : smallest;
        const crawler_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        const crawler_real u_limit = crawler_u_max[i];
        crawler_real epsilon;
        crawler_real xi;
        crawler_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const crawler_real u_i = crawler_law(gain, xi, epsilon);
        const crawler_real u_min = -u_limit;
        const bool u_above = u_min < u_i;
        const crawler_real u_raised = u_above ? u_i : u_min;
        const bool u_beyond = u_limit < u_raised;
        const crawler_real u_limited = u_beyond ? u_limit : u_raised;
        u[i] = u_limited;
        outside = outside_next;
    }
    return outside ? CRAWLER_OUTSIDE_TUBE : CRAWLER_OK;
}

crawler_status crawler_control_tick(uint32_t tick, const crawler_real x[CRAWLER_N], crawler_real u[CRAWLER_N])
{
    crawler_real zero = 0.0F;
    for (int32_t j = 0; j < 2; ++j) {
        const crawler_real x_j = x[j];
        const crawler_real x_zero = x_j * 0.0F;
        const crawler_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return CRAWLER_BAD_INPUT;
    }
    int32_t row;
    crawler_real s;
    crawler_segment_at_tick(tick, &row, &s);
    crawler_real w0;
    crawler_real w1;
    crawler_real w2;
    crawler_real w3;
    crawler_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const crawler_real lower_edge = crawler_edge_at(lower_at, w0, w1, w2, w3);
        const crawler_real upper_edge = crawler_edge_at(upper_at, w0, w1, w2, w3);
        const crawler_real x_i = x[i];
        const crawler_real gain_i = crawler_gain[i];
        const crawler_real gain_minus = -gain_i;
        const crawler_real width = upper_edge - lower_edge;
        const crawler_real to_lower = x_i - lower_edge;
        const crawler_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const crawler_real distance = upper_nearer ? to_upper : to_lower;
        const crawler_real gain = upper_nearer ? gain_minus : gain_i;
        const crawler_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const crawler_real to_nearer = clear ? distance : smallest;
        const crawler_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        const crawler_real u_limit = crawler_u_max[i];
        crawler_real epsilon;
        crawler_real xi;
        crawler_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const crawler_real u_i = crawler_law(gain, xi, epsilon);
        const crawler_real u_min = -u_limit;
        const bool u_above = u_min < u_i;
        const crawler_real u_raised = u_above ? u_i : u_min;
        const bool u_beyond = u_limit < u_raised;
        const crawler_real u_limited = u_beyond ? u_limit : u_raised;
        u[i] = u_limited;
        outside = outside_next;
    }
    return outside ? CRAWLER_OUTSIDE_TUBE : CRAWLER_OK;
}

crawler_real crawler_margin(crawler_real t, const crawler_real x[CRAWLER_N])
{
    const crawler_real t_zero = t * 0.0F;
    crawler_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const crawler_real x_j = x[j];
        const crawler_real x_zero = x_j * 0.0F;
        const crawler_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (crawler_real)NAN;
    }
    int32_t row;
    crawler_real s;
    crawler_segment(t, &row, &s);
    crawler_real w0;
    crawler_real w1;
    crawler_real w2;
    crawler_real w3;
    crawler_basis(s, &w0, &w1, &w2, &w3);
    crawler_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const crawler_real lower_edge = crawler_edge_at(lower_at, w0, w1, w2, w3);
        const crawler_real upper_edge = crawler_edge_at(upper_at, w0, w1, w2, w3);
        const crawler_real x_i = x[i];
        const crawler_real width = upper_edge - lower_edge;
        const crawler_real to_lower = x_i - lower_edge;
        const crawler_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const crawler_real x_distance = x_nearer ? to_upper : to_lower;
        const crawler_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const crawler_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const crawler_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void crawler_margins(crawler_real t, const crawler_real x[CRAWLER_N], crawler_real margin[CRAWLER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (crawler_real)NAN;
        }
        return;
    }
    int32_t row;
    crawler_real s;
    crawler_segment(t, &row, &s);
    crawler_real w0;
    crawler_real w1;
    crawler_real w2;
    crawler_real w3;
    crawler_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const crawler_real lower_edge = crawler_edge_at(lower_at, w0, w1, w2, w3);
        const crawler_real upper_edge = crawler_edge_at(upper_at, w0, w1, w2, w3);
        const crawler_real x_i = x[i];
        const crawler_real width = upper_edge - lower_edge;
        const crawler_real to_lower = x_i - lower_edge;
        const crawler_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const crawler_real x_distance = x_nearer ? to_upper : to_lower;
        const crawler_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const crawler_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool crawler_covered(const crawler_real x[CRAWLER_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const crawler_real x_i = x[i];
        const crawler_real x_lower = crawler_start_lower[i];
        const crawler_real x_upper = crawler_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void crawler_transform(const crawler_real lower[CRAWLER_N], const crawler_real upper[CRAWLER_N],
                       const crawler_real x[CRAWLER_N], crawler_real e[CRAWLER_N],
                       crawler_real epsilon[CRAWLER_N], crawler_real xi[CRAWLER_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const crawler_real lower_edge = lower[i];
        const crawler_real upper_edge = upper[i];
        const crawler_real x_i = x[i];
        const crawler_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const crawler_real safe_width = wide ? width : 9.536743e-7F;
        const crawler_real to_lower = x_i - lower_edge;
        const crawler_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const crawler_real distance = upper_nearer ? to_upper : to_lower;
        const crawler_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const crawler_real smallest = safe_width * 0.005F;
        const crawler_real widened = safe_width - width;
        const crawler_real half = widened * 0.5F;
        const crawler_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const crawler_real to_nearer = clear ? safe_distance : smallest;
        const crawler_real to_farther = safe_width - to_nearer;
        const crawler_real a = upper_nearer ? to_farther : to_nearer;
        const crawler_real b = upper_nearer ? to_nearer : to_farther;
        const crawler_real e_i = crawler_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const crawler_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const crawler_real e_limited = e_beyond ? 0.99F : e_raised;
        crawler_real epsilon_nearer;
        crawler_real xi_i;
        crawler_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const crawler_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const crawler_real e_or_zero = empty ? 0.0F : e_limited;
        const crawler_real e_out = finite ? e_or_zero : (crawler_real)NAN;
        e[i] = e_out;
        const crawler_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const crawler_real epsilon_out = finite ? epsilon_or_zero : (crawler_real)NAN;
        epsilon[i] = epsilon_out;
        const crawler_real xi_or_zero = empty ? 0.0F : xi_i;
        const crawler_real xi_out = finite ? xi_or_zero : (crawler_real)NAN;
        xi[i] = xi_out;
    }
}
