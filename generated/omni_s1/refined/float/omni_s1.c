/* omni_s1.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (omni_s1.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "omni_s1.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "omni_s1.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "omni_s1.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "omni_s1.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "omni_s1.c: float is not IEEE-754's here, for which rounding is bounded"
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
 * Multiples of 2^-20: exact in float and double.
 */
static const omni_s1_real omni_s1_coefficients[140] = {
    -0.012588501F, 0.07280731F, 0.777133F, 0.8619337F,
    0.0000104904175F, 0.08332348F, 0.7500105F, 0.8333235F,
    0.012608528F, 0.09383869F, 0.722888F, 0.80471325F,
    0.025206566F, 0.104353905F, 0.6957655F, 0.776103F,
    0.037805557F, 0.11487007F, 0.668643F, 0.7474928F,
    0.050403595F, 0.12538528F, 0.6415205F, 0.7188816F,
    0.06300163F, 0.1359005F, 0.614398F, 0.6902714F,
    0.08876228F, 0.16166115F, 0.5872755F, 0.66166115F,
    0.11452484F, 0.1874237F, 0.560153F, 0.6330519F,
    0.1402874F, 0.21318626F, 0.5666475F, 0.6395464F,
    0.16605091F, 0.23894978F, 0.57314205F, 0.6460409F,
    0.19181347F, 0.26471233F, 0.5796375F, 0.6525364F,
    0.21757603F, 0.2904749F, 0.58613205F, 0.6590309F,
    0.24333858F, 0.31623745F, 0.5888052F, 0.66170406F,
    0.26910114F, 0.342F, 0.5886774F, 0.6615763F,
    0.2948637F, 0.36776257F, 0.58855057F, 0.66144943F,
    0.32062626F, 0.39352512F, 0.5884237F, 0.6613226F,
    0.34638977F, 0.41928864F, 0.58829594F, 0.6611948F,
    0.37215233F, 0.4450512F, 0.5909691F, 0.66386795F,
    0.3979149F, 0.47081375F, 0.6023283F, 0.67522717F,
    0.42367744F, 0.4965763F, 0.61368847F, 0.68658733F,
    0.44944F, 0.52233887F, 0.62504864F, 0.6979475F,
    0.47520256F, 0.5481014F, 0.63640785F, 0.7093067F,
    0.5009661F, 0.57386494F, 0.647768F, 0.7206669F,
    0.52672863F, 0.5996275F, 0.65912724F, 0.7320261F,
    0.5524912F, 0.62539005F, 0.6704874F, 0.74338627F,
    0.57825375F, 0.6511526F, 0.6818466F, 0.7547455F,
    0.6040163F, 0.67691517F, 0.6932068F, 0.76610565F,
    0.62977886F, 0.7026777F, 0.704566F, 0.77746487F,
    0.6555414F, 0.7284403F, 0.7159262F, 0.78882504F,
    0.68130493F, 0.7542038F, 0.7272854F, 0.80018425F,
    0.7070675F, 0.77996635F, 0.73864555F, 0.8115444F,
    0.73283005F, 0.8057289F, 0.75000477F, 0.82290363F,
    0.7585926F, 0.8314915F, 0.75000477F, 0.82290363F,
    0.73283005F, 0.8057289F, 0.75000477F, 0.82290363F
};

/* Covered starts have x strictly above these bounds, by component. */
static const omni_s1_real omni_s1_start_lower[2] = {
    0.0025619746F, 4.502563F
};

/* Covered starts have x strictly below these bounds, by component. */
static const omni_s1_real omni_s1_start_upper[2] = {
    0.49743992F, 4.997441F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 9 s).
 */
static inline void omni_s1_segment(omni_s1_real t, int32_t *row, omni_s1_real *s)
{
    const bool positive = 0.0F < t;
    const omni_s1_real started = positive ? t : 0.0F;
    const omni_s1_real scaled = started * 3.5555556F;
    const bool early = scaled < 31.999998F;
    const omni_s1_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const omni_s1_real base = (omni_s1_real)segment;
    const omni_s1_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void omni_s1_basis(omni_s1_real s, omni_s1_real *w0, omni_s1_real *w1, omni_s1_real *w2,
                                 omni_s1_real *w3)
{
    const omni_s1_real v0 = 1.0F - s;
    const omni_s1_real v1 = v0 * v0;
    const omni_s1_real v2 = v1 * v0;
    const omni_s1_real v3 = v0 * s;
    const omni_s1_real v4 = 1.0F + v3;
    const omni_s1_real v5 = 3.0F * v4;
    const omni_s1_real v6 = v0 * v5;
    const omni_s1_real v7 = 1.0F + v6;
    const omni_s1_real v8 = s * v5;
    const omni_s1_real v9 = 1.0F + v8;
    const omni_s1_real v10 = s * s;
    const omni_s1_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void omni_s1_basis_rate(omni_s1_real s, omni_s1_real *dw0, omni_s1_real *dw1, omni_s1_real *dw2,
                                      omni_s1_real *dw3)
{
    const omni_s1_real v0 = 1.0F - s;
    const omni_s1_real v1 = v0 + v0;
    const omni_s1_real v2 = v0 * v1;
    const omni_s1_real v3 = v0 * v0;
    const omni_s1_real v4 = v2 + v3;
    const omni_s1_real v5 = -v4;
    const omni_s1_real v6 = v0 - s;
    const omni_s1_real v7 = 3.0F * v6;
    const omni_s1_real v8 = v0 * v7;
    const omni_s1_real v9 = v0 * s;
    const omni_s1_real v10 = 1.0F + v9;
    const omni_s1_real v11 = 3.0F * v10;
    const omni_s1_real v12 = v8 - v11;
    const omni_s1_real v13 = s * v7;
    const omni_s1_real v14 = v11 + v13;
    const omni_s1_real v15 = s + s;
    const omni_s1_real v16 = s * v15;
    const omni_s1_real v17 = s * s;
    const omni_s1_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline omni_s1_real omni_s1_edge_at(int32_t at, omni_s1_real w0, omni_s1_real w1, omni_s1_real w2,
                                           omni_s1_real w3)
{
    const omni_s1_real q0 = omni_s1_coefficients[at];
    const int32_t at_1 = at + 4;
    const omni_s1_real q1 = omni_s1_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const omni_s1_real q2 = omni_s1_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const omni_s1_real q3 = omni_s1_coefficients[at_3];
    const omni_s1_real v0 = w0 * q0;
    const omni_s1_real v1 = w1 * q1;
    const omni_s1_real v2 = v0 + v1;
    const omni_s1_real v3 = w2 * q2;
    const omni_s1_real v4 = w3 * q3;
    const omni_s1_real v5 = v3 + v4;
    const omni_s1_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline omni_s1_real omni_s1_normalized_error(omni_s1_real a, omni_s1_real b, omni_s1_real width)
{
    const omni_s1_real v0 = a - b;
    const omni_s1_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void omni_s1_transformed_error(omni_s1_real a, omni_s1_real b, omni_s1_real *epsilon,
                                             omni_s1_real *xi)
{
    const omni_s1_real v0 = b / a;
    const omni_s1_real v1 = logf(v0);
    const omni_s1_real v2 = -v1;
    const omni_s1_real v3 = 1.0F + v0;
    const omni_s1_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline omni_s1_real omni_s1_law(omni_s1_real k, omni_s1_real xi, omni_s1_real epsilon)
{
    const omni_s1_real v0 = k * xi;
    const omni_s1_real v1 = v0 * epsilon;
    const omni_s1_real v2 = -v1;
    return v2;
}

void omni_s1_tube(omni_s1_real t, omni_s1_real lower[OMNI_S1_N], omni_s1_real upper[OMNI_S1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (omni_s1_real)NAN;
            upper[j] = (omni_s1_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void omni_s1_tube_rate(omni_s1_real t, omni_s1_real lower_rate[OMNI_S1_N], omni_s1_real upper_rate[OMNI_S1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (omni_s1_real)NAN;
            upper_rate[j] = (omni_s1_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real dw0;
    omni_s1_real dw1;
    omni_s1_real dw2;
    omni_s1_real dw3;
    omni_s1_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 9.0F;
    const omni_s1_real per_second = moving ? 3.5555556F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_slope = omni_s1_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const omni_s1_real lower_speed = lower_slope * per_second;
        const omni_s1_real upper_slope = omni_s1_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const omni_s1_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

omni_s1_status omni_s1_control(omni_s1_real t, const omni_s1_real x[OMNI_S1_N], omni_s1_real u[OMNI_S1_N])
{
    const omni_s1_real t_zero = t * 0.0F;
    omni_s1_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s1_real x_j = x[j];
        const omni_s1_real x_zero = x_j * 0.0F;
        const omni_s1_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return OMNI_S1_BAD_INPUT;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s1_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s1_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const omni_s1_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const omni_s1_real to_nearer = clear ? distance : smallest;
        const omni_s1_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        omni_s1_real epsilon;
        omni_s1_real xi;
        omni_s1_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const omni_s1_real u_i = omni_s1_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? OMNI_S1_OUTSIDE_TUBE : OMNI_S1_OK;
}

omni_s1_real omni_s1_margin(omni_s1_real t, const omni_s1_real x[OMNI_S1_N])
{
    const omni_s1_real t_zero = t * 0.0F;
    omni_s1_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s1_real x_j = x[j];
        const omni_s1_real x_zero = x_j * 0.0F;
        const omni_s1_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (omni_s1_real)NAN;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    omni_s1_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s1_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s1_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const omni_s1_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const omni_s1_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void omni_s1_margins(omni_s1_real t, const omni_s1_real x[OMNI_S1_N], omni_s1_real margin[OMNI_S1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (omni_s1_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s1_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s1_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const omni_s1_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool omni_s1_covered(const omni_s1_real x[OMNI_S1_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s1_real x_i = x[i];
        const omni_s1_real x_lower = omni_s1_start_lower[i];
        const omni_s1_real x_upper = omni_s1_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void omni_s1_transform(const omni_s1_real lower[OMNI_S1_N], const omni_s1_real upper[OMNI_S1_N],
                       const omni_s1_real x[OMNI_S1_N], omni_s1_real e[OMNI_S1_N],
                       omni_s1_real epsilon[OMNI_S1_N], omni_s1_real xi[OMNI_S1_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s1_real lower_edge = lower[i];
        const omni_s1_real upper_edge = upper[i];
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const omni_s1_real safe_width = wide ? width : 9.536743e-7F;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s1_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s1_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const omni_s1_real smallest = safe_width * 0.005F;
        const omni_s1_real widened = safe_width - width;
        const omni_s1_real half = widened * 0.5F;
        const omni_s1_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const omni_s1_real to_nearer = clear ? safe_distance : smallest;
        const omni_s1_real to_farther = safe_width - to_nearer;
        const omni_s1_real a = upper_nearer ? to_farther : to_nearer;
        const omni_s1_real b = upper_nearer ? to_nearer : to_farther;
        const omni_s1_real e_i = omni_s1_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const omni_s1_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const omni_s1_real e_limited = e_beyond ? 0.99F : e_raised;
        omni_s1_real epsilon_nearer;
        omni_s1_real xi_i;
        omni_s1_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const omni_s1_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const omni_s1_real e_or_zero = empty ? 0.0F : e_limited;
        const omni_s1_real e_out = finite ? e_or_zero : (omni_s1_real)NAN;
        e[i] = e_out;
        const omni_s1_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const omni_s1_real epsilon_out = finite ? epsilon_or_zero : (omni_s1_real)NAN;
        epsilon[i] = epsilon_out;
        const omni_s1_real xi_or_zero = empty ? 0.0F : xi_i;
        const omni_s1_real xi_out = finite ? xi_or_zero : (omni_s1_real)NAN;
        xi[i] = xi_out;
    }
}
