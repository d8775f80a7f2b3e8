/* empty.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (empty.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "empty.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "empty.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "empty.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "empty.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "empty.c: float is not IEEE-754's here, for which rounding is bounded"
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
static const empty_real empty_coefficients[140] = {
    -0.015784264F, 0.15087223F, -0.010520935F, 0.15613556F,
    5.2452087e-6F, 0.16666174F, 5.2452087e-6F, 0.16666174F,
    0.015794277F, 0.18245077F, 0.0105314255F, 0.17718792F,
    0.031583786F, 0.19824028F, 0.021057606F, 0.1877141F,
    0.047373295F, 0.21402979F, 0.031583786F, 0.19824028F,
    0.0631628F, 0.2298193F, 0.042109966F, 0.20876646F,
    0.07895231F, 0.2456088F, 0.052636147F, 0.21929264F,
    0.094741344F, 0.26139784F, 0.06316233F, 0.22981882F,
    0.11053085F, 0.27718735F, 0.073688984F, 0.24034548F,
    0.12632036F, 0.29297686F, 0.084215164F, 0.25087166F,
    0.14210987F, 0.30876637F, 0.094741344F, 0.26139784F,
    0.1578989F, 0.3245554F, 0.105267525F, 0.27192402F,
    0.17368841F, 0.3403449F, 0.115793705F, 0.2824502F,
    0.18947792F, 0.3561344F, 0.12631989F, 0.29297638F,
    0.20526743F, 0.37192392F, 0.13684607F, 0.30350256F,
    0.22105646F, 0.38771296F, 0.14737225F, 0.31402874F,
    0.23684597F, 0.40350246F, 0.1578989F, 0.3245554F,
    0.25263548F, 0.41929197F, 0.16842508F, 0.33508158F,
    0.268425F, 0.43508148F, 0.17895126F, 0.34560776F,
    0.2842145F, 0.450871F, 0.18947744F, 0.35613394F,
    0.30000353F, 0.46666002F, 0.20000362F, 0.36666012F,
    0.31579304F, 0.48244953F, 0.2105298F, 0.3771863F,
    0.33158255F, 0.49823904F, 0.22105598F, 0.38771248F,
    0.34737206F, 0.51402855F, 0.23158264F, 0.39823914F,
    0.3631611F, 0.5298176F, 0.24210882F, 0.40876532F,
    0.3789506F, 0.5456071F, 0.252635F, 0.4192915F,
    0.3947401F, 0.5613966F, 0.26316118F, 0.42981768F,
    0.4105296F, 0.5771861F, 0.27368736F, 0.44034386F,
    0.42631912F, 0.5929756F, 0.28421354F, 0.45087004F,
    0.44210815F, 0.60876465F, 0.29473972F, 0.46139622F,
    0.45789766F, 0.62455416F, 0.3052659F, 0.4719224F,
    0.47368717F, 0.64034367F, 0.31579256F, 0.48244905F,
    0.48947668F, 0.6561332F, 0.32631874F, 0.49297523F,
    0.5052657F, 0.6719222F, 0.33684444F, 0.50350094F,
    0.48947668F, 0.6561332F, 0.32631874F, 0.49297523F
};

/* Covered starts have x strictly above these bounds, by component. */
static const empty_real empty_start_lower[2] = {
    0.005031166F, 0.005031643F
};

/* Covered starts have x strictly below these bounds, by component. */
static const empty_real empty_start_upper[2] = {
    0.9949698F, 0.99497026F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 4 s).
 */
static inline void empty_segment(empty_real t, int32_t *row, empty_real *s)
{
    const bool positive = 0.0F < t;
    const empty_real started = positive ? t : 0.0F;
    const empty_real scaled = started * 8.0F;
    const bool early = scaled < 31.999998F;
    const empty_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const empty_real base = (empty_real)segment;
    const empty_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void empty_basis(empty_real s, empty_real *w0, empty_real *w1, empty_real *w2, empty_real *w3)
{
    const empty_real v0 = 1.0F - s;
    const empty_real v1 = v0 * v0;
    const empty_real v2 = v1 * v0;
    const empty_real v3 = v0 * s;
    const empty_real v4 = 1.0F + v3;
    const empty_real v5 = 3.0F * v4;
    const empty_real v6 = v0 * v5;
    const empty_real v7 = 1.0F + v6;
    const empty_real v8 = s * v5;
    const empty_real v9 = 1.0F + v8;
    const empty_real v10 = s * s;
    const empty_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void empty_basis_rate(empty_real s, empty_real *dw0, empty_real *dw1, empty_real *dw2,
                                    empty_real *dw3)
{
    const empty_real v0 = 1.0F - s;
    const empty_real v1 = v0 + v0;
    const empty_real v2 = v0 * v1;
    const empty_real v3 = v0 * v0;
    const empty_real v4 = v2 + v3;
    const empty_real v5 = -v4;
    const empty_real v6 = v0 - s;
    const empty_real v7 = 3.0F * v6;
    const empty_real v8 = v0 * v7;
    const empty_real v9 = v0 * s;
    const empty_real v10 = 1.0F + v9;
    const empty_real v11 = 3.0F * v10;
    const empty_real v12 = v8 - v11;
    const empty_real v13 = s * v7;
    const empty_real v14 = v11 + v13;
    const empty_real v15 = s + s;
    const empty_real v16 = s * v15;
    const empty_real v17 = s * s;
    const empty_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline empty_real empty_edge_at(int32_t at, empty_real w0, empty_real w1, empty_real w2, empty_real w3)
{
    const empty_real q0 = empty_coefficients[at];
    const int32_t at_1 = at + 4;
    const empty_real q1 = empty_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const empty_real q2 = empty_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const empty_real q3 = empty_coefficients[at_3];
    const empty_real v0 = w0 * q0;
    const empty_real v1 = w1 * q1;
    const empty_real v2 = v0 + v1;
    const empty_real v3 = w2 * q2;
    const empty_real v4 = w3 * q3;
    const empty_real v5 = v3 + v4;
    const empty_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline empty_real empty_normalized_error(empty_real a, empty_real b, empty_real width)
{
    const empty_real v0 = a - b;
    const empty_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void empty_transformed_error(empty_real a, empty_real b, empty_real *epsilon, empty_real *xi)
{
    const empty_real v0 = b / a;
    const empty_real v1 = logf(v0);
    const empty_real v2 = -v1;
    const empty_real v3 = 1.0F + v0;
    const empty_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline empty_real empty_law(empty_real k, empty_real xi, empty_real epsilon)
{
    const empty_real v0 = k * xi;
    const empty_real v1 = v0 * epsilon;
    const empty_real v2 = -v1;
    return v2;
}

void empty_tube(empty_real t, empty_real lower[EMPTY_N], empty_real upper[EMPTY_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (empty_real)NAN;
            upper[j] = (empty_real)NAN;
        }
        return;
    }
    int32_t row;
    empty_real s;
    empty_segment(t, &row, &s);
    empty_real w0;
    empty_real w1;
    empty_real w2;
    empty_real w3;
    empty_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const empty_real lower_edge = empty_edge_at(lower_at, w0, w1, w2, w3);
        const empty_real upper_edge = empty_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void empty_tube_rate(empty_real t, empty_real lower_rate[EMPTY_N], empty_real upper_rate[EMPTY_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (empty_real)NAN;
            upper_rate[j] = (empty_real)NAN;
        }
        return;
    }
    int32_t row;
    empty_real s;
    empty_segment(t, &row, &s);
    empty_real dw0;
    empty_real dw1;
    empty_real dw2;
    empty_real dw3;
    empty_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 4.0F;
    const empty_real per_second = moving ? 8.0F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const empty_real lower_slope = empty_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const empty_real lower_speed = lower_slope * per_second;
        const empty_real upper_slope = empty_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const empty_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

empty_status empty_control(empty_real t, const empty_real x[EMPTY_N], empty_real u[EMPTY_N])
{
    const empty_real t_zero = t * 0.0F;
    empty_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const empty_real x_j = x[j];
        const empty_real x_zero = x_j * 0.0F;
        const empty_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return EMPTY_BAD_INPUT;
    }
    int32_t row;
    empty_real s;
    empty_segment(t, &row, &s);
    empty_real w0;
    empty_real w1;
    empty_real w2;
    empty_real w3;
    empty_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const empty_real lower_edge = empty_edge_at(lower_at, w0, w1, w2, w3);
        const empty_real upper_edge = empty_edge_at(upper_at, w0, w1, w2, w3);
        const empty_real x_i = x[i];
        const empty_real width = upper_edge - lower_edge;
        const empty_real to_lower = x_i - lower_edge;
        const empty_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const empty_real distance = upper_nearer ? to_upper : to_lower;
        const empty_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const empty_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const empty_real to_nearer = clear ? distance : smallest;
        const empty_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        empty_real epsilon;
        empty_real xi;
        empty_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const empty_real u_i = empty_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? EMPTY_OUTSIDE_TUBE : EMPTY_OK;
}

empty_real empty_margin(empty_real t, const empty_real x[EMPTY_N])
{
    const empty_real t_zero = t * 0.0F;
    empty_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const empty_real x_j = x[j];
        const empty_real x_zero = x_j * 0.0F;
        const empty_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (empty_real)NAN;
    }
    int32_t row;
    empty_real s;
    empty_segment(t, &row, &s);
    empty_real w0;
    empty_real w1;
    empty_real w2;
    empty_real w3;
    empty_basis(s, &w0, &w1, &w2, &w3);
    empty_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const empty_real lower_edge = empty_edge_at(lower_at, w0, w1, w2, w3);
        const empty_real upper_edge = empty_edge_at(upper_at, w0, w1, w2, w3);
        const empty_real x_i = x[i];
        const empty_real width = upper_edge - lower_edge;
        const empty_real to_lower = x_i - lower_edge;
        const empty_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const empty_real x_distance = x_nearer ? to_upper : to_lower;
        const empty_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const empty_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const empty_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void empty_margins(empty_real t, const empty_real x[EMPTY_N], empty_real margin[EMPTY_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (empty_real)NAN;
        }
        return;
    }
    int32_t row;
    empty_real s;
    empty_segment(t, &row, &s);
    empty_real w0;
    empty_real w1;
    empty_real w2;
    empty_real w3;
    empty_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const empty_real lower_edge = empty_edge_at(lower_at, w0, w1, w2, w3);
        const empty_real upper_edge = empty_edge_at(upper_at, w0, w1, w2, w3);
        const empty_real x_i = x[i];
        const empty_real width = upper_edge - lower_edge;
        const empty_real to_lower = x_i - lower_edge;
        const empty_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const empty_real x_distance = x_nearer ? to_upper : to_lower;
        const empty_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const empty_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool empty_covered(const empty_real x[EMPTY_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const empty_real x_i = x[i];
        const empty_real x_lower = empty_start_lower[i];
        const empty_real x_upper = empty_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void empty_transform(const empty_real lower[EMPTY_N], const empty_real upper[EMPTY_N],
                     const empty_real x[EMPTY_N], empty_real e[EMPTY_N], empty_real epsilon[EMPTY_N],
                     empty_real xi[EMPTY_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const empty_real lower_edge = lower[i];
        const empty_real upper_edge = upper[i];
        const empty_real x_i = x[i];
        const empty_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const empty_real safe_width = wide ? width : 9.536743e-7F;
        const empty_real to_lower = x_i - lower_edge;
        const empty_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const empty_real distance = upper_nearer ? to_upper : to_lower;
        const empty_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const empty_real smallest = safe_width * 0.005F;
        const empty_real widened = safe_width - width;
        const empty_real half = widened * 0.5F;
        const empty_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const empty_real to_nearer = clear ? safe_distance : smallest;
        const empty_real to_farther = safe_width - to_nearer;
        const empty_real a = upper_nearer ? to_farther : to_nearer;
        const empty_real b = upper_nearer ? to_nearer : to_farther;
        const empty_real e_i = empty_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const empty_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const empty_real e_limited = e_beyond ? 0.99F : e_raised;
        empty_real epsilon_nearer;
        empty_real xi_i;
        empty_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const empty_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const empty_real e_or_zero = empty ? 0.0F : e_limited;
        const empty_real e_out = finite ? e_or_zero : (empty_real)NAN;
        e[i] = e_out;
        const empty_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const empty_real epsilon_out = finite ? epsilon_or_zero : (empty_real)NAN;
        epsilon[i] = epsilon_out;
        const empty_real xi_or_zero = empty ? 0.0F : xi_i;
        const empty_real xi_out = finite ? xi_or_zero : (empty_real)NAN;
        xi[i] = xi_out;
    }
}
