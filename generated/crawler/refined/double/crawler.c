/* crawler.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "crawler.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "crawler.c: double is not IEEE-754's here, for which rounding is bounded"
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
    -0.009665489196777344, 0.1619091033935547, -0.0220184326171875, 0.14955615997314453,
    5.245208740234375e-6, 0.16666173934936523, 5.245208740234375e-6, 0.16666173934936523,
    0.00967550277709961, 0.17141389846801758, 0.02202892303466797, 0.18376731872558594,
    0.019346237182617188, 0.17616653442382812, 0.0440521240234375, 0.20087289810180664,
    0.029016494750976562, 0.18091917037963867, 0.06607580184936523, 0.21797847747802734,
    0.03868722915649414, 0.18567132949829102, 0.08809947967529297, 0.23508405685424805,
    0.048357486724853516, 0.19042396545410156, 0.1101231575012207, 0.25218963623046875,
    0.058028221130371094, 0.1951766014099121, 0.13214683532714844, 0.26929521560668945,
    0.06769847869873047, 0.19992923736572266, 0.15417051315307617, 0.28640079498291016,
    0.07736921310424805, 0.204681396484375, 0.1761941909790039, 0.30350637435913086,
    0.08703994750976562, 0.20943403244018555, 0.19821786880493164, 0.32061195373535156,
    0.096710205078125, 0.2141866683959961, 0.22024154663085938, 0.33771753311157227,
    0.10638093948364258, 0.21893882751464844, 0.2422652244567871, 0.35482311248779297,
    0.11605119705200195, 0.22860956192016602, 0.26428890228271484, 0.3768467903137207,
    0.12572193145751953, 0.2382798194885254, 0.2863121032714844, 0.39887046813964844,
    0.14577245712280273, 0.2583308219909668, 0.3083357810974121, 0.42089414596557617,
    0.16582345962524414, 0.27838134765625, 0.33035945892333984, 0.4429178237915039,
    0.18587398529052734, 0.2984323501586914, 0.3523831367492676, 0.46494150161743164,
    0.20592498779296875, 0.3184828758239746, 0.35822582244873047, 0.47078418731689453,
    0.22597551345825195, 0.338533878326416, 0.36406850814819336, 0.4766268730163574,
    0.24602651596069336, 0.3585844039916992, 0.36991119384765625, 0.4824695587158203,
    0.26607704162597656, 0.3786354064941406, 0.37575387954711914, 0.4883122444152832,
    0.28612804412841797, 0.39868593215942383, 0.38159656524658203, 0.4941549301147461,
    0.30617856979370117, 0.41873693466186523, 0.3874392509460449, 0.499997615814209,
    0.3262295722961426, 0.43878746032714844, 0.3874392509460449, 0.499997615814209,
    0.3462800979614258, 0.45883846282958984, 0.3874392509460449, 0.499997615814209,
    0.3663311004638672, 0.47888898849487305, 0.3874392509460449, 0.499997615814209,
    0.3863816261291504, 0.49893999099731445, 0.3874392509460449, 0.499997615814209,
    0.4064326286315918, 0.5189905166625977, 0.3874392509460449, 0.499997615814209,
    0.426483154296875, 0.5390415191650391, 0.3874392509460449, 0.499997615814209,
    0.4465341567993164, 0.5590920448303223, 0.3874392509460449, 0.499997615814209,
    0.4665846824645996, 0.5791430473327637, 0.3874392509460449, 0.499997615814209,
    0.486635684967041, 0.5991935729980469, 0.3874392509460449, 0.499997615814209,
    0.5066862106323242, 0.6192440986633301, 0.3874392509460449, 0.499997615814209,
    0.486635684967041, 0.5991935729980469, 0.3874392509460449, 0.499997615814209
};

/* Gain k of the control law, by component. */
static const crawler_real crawler_gain[2] = {
    0.0388, 0.0623
};

/* Saturation of u, by component. */
static const crawler_real crawler_u_max[2] = {
    1.2999999999999998, 1.2999999999999998
};

/* Covered starts have x strictly above these bounds, by component. */
static const crawler_real crawler_start_lower[2] = {
    0.05202794265747159, 0.052028419494629795
};

/* Covered starts have x strictly below these bounds, by component. */
static const crawler_real crawler_start_upper[2] = {
    0.9479730110168447, 0.9479734878540029
};

/* The type must have 64 bits: avr-gcc's double, for one, has not. */
typedef char crawler_real_size[(sizeof(crawler_real) == 8U) ? 1 : -1];

/* y = m 2^e with m in [1/sqrt 2, sqrt 2), for y not below that: e, and m. */
static inline int32_t crawler_exponent(crawler_real y)
{
    uint64_t bits;
    (void)memcpy(&bits, &y, sizeof bits);
    return (int32_t)((bits - 0x3fe6a09e667f3bcdU) >> 52);
}

static inline crawler_real crawler_mantissa(crawler_real y)
{
    uint64_t bits;
    (void)memcpy(&bits, &y, sizeof bits);
    bits = ((bits - 0x3fe6a09e667f3bcdU) & 0xfffffffffffffU) + 0x3fe6a09e667f3bcdU;
    crawler_real m;
    (void)memcpy(&m, &bits, sizeof m);
    return m;
}

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 6 s).
 */
static inline void crawler_segment(crawler_real t, int32_t *row, crawler_real *s)
{
    const bool positive = 0.0 < t;
    const crawler_real started = positive ? t : 0.0;
    const crawler_real scaled = started * 5.333333333333333;
    const bool early = scaled < 31.999999999999996;
    const crawler_real u = early ? scaled : 31.999999999999996;
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
    const crawler_real share = part / 375.0;
    const int32_t first = segment * 4;
    *row = first;
    *s = share;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void crawler_basis(crawler_real s, crawler_real *w0, crawler_real *w1, crawler_real *w2,
                                 crawler_real *w3)
{
    const crawler_real v0 = 1.0 - s;
    const crawler_real v1 = v0 * v0;
    const crawler_real v2 = v1 * v0;
    const crawler_real v3 = v0 * s;
    const crawler_real v4 = 1.0 + v3;
    const crawler_real v5 = 3.0 * v4;
    const crawler_real v6 = v0 * v5;
    const crawler_real v7 = 1.0 + v6;
    const crawler_real v8 = s * v5;
    const crawler_real v9 = 1.0 + v8;
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
    const crawler_real v0 = 1.0 - s;
    const crawler_real v1 = v0 + v0;
    const crawler_real v2 = v0 * v1;
    const crawler_real v3 = v0 * v0;
    const crawler_real v4 = v2 + v3;
    const crawler_real v5 = -v4;
    const crawler_real v6 = v0 - s;
    const crawler_real v7 = 3.0 * v6;
    const crawler_real v8 = v0 * v7;
    const crawler_real v9 = v0 * s;
    const crawler_real v10 = 1.0 + v9;
    const crawler_real v11 = 3.0 * v10;
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
    const crawler_real below = mantissa - 1.0;
    const crawler_real above = mantissa + 1.0;
    const crawler_real s = below / above;
    const crawler_real z = s * s;
    const crawler_real bent = z * 0.6766043901443481;
    const crawler_real around = bent + 2.0;
    const crawler_real part = s * around;
    const crawler_real whole = base * 0.6931471805599453;
    const crawler_real v1 = whole + part;
    const crawler_real v2 = -v1;
    const crawler_real v3 = 1.0 + v0;
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
    const bool moving = t < 6.0;
    const crawler_real per_second = moving ? 5.333333333333333 : 0.0;
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
    const crawler_real t_zero = t * 0.0;
    crawler_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const crawler_real x_j = x[j];
        const crawler_real x_zero = x_j * 0.0;
        const crawler_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
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
        const crawler_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const crawler_real to_nearer = clear ? distance : smallest;
        const crawler_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
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
    crawler_real zero = 0.0;
    for (int32_t j = 0; j < 2; ++j) {
        const crawler_real x_j = x[j];
        const crawler_real x_zero = x_j * 0.0;
        const crawler_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
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
        const crawler_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const crawler_real to_nearer = clear ? distance : smallest;
        const crawler_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
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
    const crawler_real t_zero = t * 0.0;
    crawler_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const crawler_real x_j = x[j];
        const crawler_real x_zero = x_j * 0.0;
        const crawler_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
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
    crawler_real margin = 0.5;
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
        const bool x_beyond = x_share < (-1.0);
        const crawler_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool x_beyond = x_share < (-1.0);
        const crawler_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const crawler_real safe_width = wide ? width : 9.5367431640625e-7;
        const crawler_real to_lower = x_i - lower_edge;
        const crawler_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const crawler_real distance = upper_nearer ? to_upper : to_lower;
        const crawler_real sign = upper_nearer ? (-1.0) : 1.0;
        const crawler_real smallest = safe_width * 0.005;
        const crawler_real widened = safe_width - width;
        const crawler_real half = widened * 0.5;
        const crawler_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const crawler_real to_nearer = clear ? safe_distance : smallest;
        const crawler_real to_farther = safe_width - to_nearer;
        const crawler_real a = upper_nearer ? to_farther : to_nearer;
        const crawler_real b = upper_nearer ? to_nearer : to_farther;
        const crawler_real e_i = crawler_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const crawler_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const crawler_real e_limited = e_beyond ? 0.99 : e_raised;
        crawler_real epsilon_nearer;
        crawler_real xi_i;
        crawler_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const crawler_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const crawler_real e_or_zero = empty ? 0.0 : e_limited;
        const crawler_real e_out = finite ? e_or_zero : (crawler_real)NAN;
        e[i] = e_out;
        const crawler_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const crawler_real epsilon_out = finite ? epsilon_or_zero : (crawler_real)NAN;
        epsilon[i] = epsilon_out;
        const crawler_real xi_or_zero = empty ? 0.0 : xi_i;
        const crawler_real xi_out = finite ? xi_or_zero : (crawler_real)NAN;
        xi[i] = xi_out;
    }
}
