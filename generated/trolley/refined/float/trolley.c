/* trolley.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (trolley.certificate.json): for every t the tube keeps 0.05 from every
 * unsafe set, stays in the state space, is at least 0.2 wide, and ends in the target set.
 * The state stays in it (P9) sampled every 0.02 s or faster, from every start with |e(0)| <= 0.9, for |f +
 * w| <= 0.15, 0.9 <= g_ii <= 1.1, |g_ij| <= 0.05, x measured to 0.002, u acts at most 0.002 s after its sample:
 * |e| < [0.9117, 0.9138], |u| <= 2.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "trolley.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "trolley.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "trolley.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "trolley.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "trolley.c: float is not IEEE-754's here, for which rounding is bounded"
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
static const trolley_real trolley_coefficients[140] = {
    0.01112175F, 0.11665535F, 0.036122322F, 0.14430618F,
    0.033343315F, 0.13332272F, 0.033343315F, 0.13332272F,
    0.055565834F, 0.14999104F, 0.030565262F, 0.1223402F,
    0.0777874F, 0.1666584F, 0.027786255F, 0.111356735F,
    0.100008965F, 0.18332577F, 0.025007248F, 0.10037327F,
    0.12223148F, 0.19999313F, 0.022229195F, 0.0893898F,
    0.14445305F, 0.2166605F, 0.019450188F, 0.078406334F,
    0.16667461F, 0.23332787F, 0.016672134F, 0.07431221F,
    0.18889713F, 0.24999619F, 0.016672134F, 0.07431221F,
    0.2111187F, 0.26875973F, 0.016672134F, 0.07431221F,
    0.23334026F, 0.2909813F, 0.016672134F, 0.07431221F,
    0.25556278F, 0.31320286F, 0.016672134F, 0.07431221F,
    0.27778435F, 0.33542538F, 0.016672134F, 0.07431221F,
    0.3000059F, 0.35764694F, 0.016672134F, 0.07431221F,
    0.32222843F, 0.3798685F, 0.016672134F, 0.07431221F,
    0.34445F, 0.40209103F, 0.016672134F, 0.07431221F,
    0.36667156F, 0.4243126F, 0.017354012F, 0.07499504F,
    0.38889313F, 0.44653416F, 0.018036842F, 0.07567692F,
    0.41111565F, 0.46875668F, 0.037431717F, 0.09507275F,
    0.4333372F, 0.49097824F, 0.056827545F, 0.114468575F,
    0.45555878F, 0.5131998F, 0.07622337F, 0.1338644F,
    0.4777813F, 0.5354214F, 0.0956192F, 0.15326023F,
    0.50000286F, 0.5576439F, 0.11501503F, 0.17265606F,
    0.5222244F, 0.57986546F, 0.13548279F, 0.19312382F,
    0.54444695F, 0.602087F, 0.15595055F, 0.21359158F,
    0.5666685F, 0.62430954F, 0.1764183F, 0.23405933F,
    0.5888901F, 0.6465311F, 0.19688606F, 0.2545271F,
    0.61111164F, 0.6687527F, 0.21735382F, 0.27499485F,
    0.63333416F, 0.69097424F, 0.23782158F, 0.2954626F,
    0.6555557F, 0.71319675F, 0.25828934F, 0.31593037F,
    0.65926075F, 0.7169018F, 0.27875805F, 0.33639812F,
    0.6629667F, 0.7206068F, 0.2992258F, 0.35686588F,
    0.66667175F, 0.7243128F, 0.31969357F, 0.37733364F,
    0.66667175F, 0.7243128F, 0.34016132F, 0.3978014F,
    0.66667175F, 0.7243128F, 0.31969357F, 0.37733364F
};

/* Gain k of the control law, by component. */
static const trolley_real trolley_gain[2] = {
    0.0384F, 0.0252F
};

/* Saturation of u, by component. */
static const trolley_real trolley_u_max[2] = {
    2.0F, 2.0F
};

/* Covered starts have x strictly above these bounds, by component. */
static const trolley_real trolley_start_lower[2] = {
    0.23205526F, 0.23205526F
};

/* Covered starts have x strictly below these bounds, by component. */
static const trolley_real trolley_start_upper[2] = {
    0.7679428F, 0.7679428F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 8 s).
 */
static inline void trolley_segment(trolley_real t, int32_t *row, trolley_real *s)
{
    const bool positive = 0.0F < t;
    const trolley_real started = positive ? t : 0.0F;
    const trolley_real scaled = started * 4.0F;
    const bool early = scaled < 31.999998F;
    const trolley_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const trolley_real base = (trolley_real)segment;
    const trolley_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void trolley_basis(trolley_real s, trolley_real *w0, trolley_real *w1, trolley_real *w2,
                                 trolley_real *w3)
{
    const trolley_real v0 = 1.0F - s;
    const trolley_real v1 = v0 * v0;
    const trolley_real v2 = v1 * v0;
    const trolley_real v3 = v0 * s;
    const trolley_real v4 = 1.0F + v3;
    const trolley_real v5 = 3.0F * v4;
    const trolley_real v6 = v0 * v5;
    const trolley_real v7 = 1.0F + v6;
    const trolley_real v8 = s * v5;
    const trolley_real v9 = 1.0F + v8;
    const trolley_real v10 = s * s;
    const trolley_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void trolley_basis_rate(trolley_real s, trolley_real *dw0, trolley_real *dw1, trolley_real *dw2,
                                      trolley_real *dw3)
{
    const trolley_real v0 = 1.0F - s;
    const trolley_real v1 = v0 + v0;
    const trolley_real v2 = v0 * v1;
    const trolley_real v3 = v0 * v0;
    const trolley_real v4 = v2 + v3;
    const trolley_real v5 = -v4;
    const trolley_real v6 = v0 - s;
    const trolley_real v7 = 3.0F * v6;
    const trolley_real v8 = v0 * v7;
    const trolley_real v9 = v0 * s;
    const trolley_real v10 = 1.0F + v9;
    const trolley_real v11 = 3.0F * v10;
    const trolley_real v12 = v8 - v11;
    const trolley_real v13 = s * v7;
    const trolley_real v14 = v11 + v13;
    const trolley_real v15 = s + s;
    const trolley_real v16 = s * v15;
    const trolley_real v17 = s * s;
    const trolley_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline trolley_real trolley_edge_at(int32_t at, trolley_real w0, trolley_real w1, trolley_real w2,
                                           trolley_real w3)
{
    const trolley_real q0 = trolley_coefficients[at];
    const int32_t at_1 = at + 4;
    const trolley_real q1 = trolley_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const trolley_real q2 = trolley_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const trolley_real q3 = trolley_coefficients[at_3];
    const trolley_real v0 = w0 * q0;
    const trolley_real v1 = w1 * q1;
    const trolley_real v2 = v0 + v1;
    const trolley_real v3 = w2 * q2;
    const trolley_real v4 = w3 * q3;
    const trolley_real v5 = v3 + v4;
    const trolley_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline trolley_real trolley_normalized_error(trolley_real a, trolley_real b, trolley_real width)
{
    const trolley_real v0 = a - b;
    const trolley_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void trolley_transformed_error(trolley_real a, trolley_real b, trolley_real *epsilon,
                                             trolley_real *xi)
{
    const trolley_real v0 = b / a;
    const trolley_real v1 = logf(v0);
    const trolley_real v2 = -v1;
    const trolley_real v3 = 1.0F + v0;
    const trolley_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline trolley_real trolley_law(trolley_real k, trolley_real xi, trolley_real epsilon)
{
    const trolley_real v0 = k * xi;
    const trolley_real v1 = v0 * epsilon;
    const trolley_real v2 = -v1;
    return v2;
}

void trolley_tube(trolley_real t, trolley_real lower[TROLLEY_N], trolley_real upper[TROLLEY_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (trolley_real)NAN;
            upper[j] = (trolley_real)NAN;
        }
        return;
    }
    int32_t row;
    trolley_real s;
    trolley_segment(t, &row, &s);
    trolley_real w0;
    trolley_real w1;
    trolley_real w2;
    trolley_real w3;
    trolley_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const trolley_real lower_edge = trolley_edge_at(lower_at, w0, w1, w2, w3);
        const trolley_real upper_edge = trolley_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void trolley_tube_rate(trolley_real t, trolley_real lower_rate[TROLLEY_N], trolley_real upper_rate[TROLLEY_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (trolley_real)NAN;
            upper_rate[j] = (trolley_real)NAN;
        }
        return;
    }
    int32_t row;
    trolley_real s;
    trolley_segment(t, &row, &s);
    trolley_real dw0;
    trolley_real dw1;
    trolley_real dw2;
    trolley_real dw3;
    trolley_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 8.0F;
    const trolley_real per_second = moving ? 4.0F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const trolley_real lower_slope = trolley_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const trolley_real lower_speed = lower_slope * per_second;
        const trolley_real upper_slope = trolley_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const trolley_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

trolley_status trolley_control(trolley_real t, const trolley_real x[TROLLEY_N], trolley_real u[TROLLEY_N])
{
    const trolley_real t_zero = t * 0.0F;
    trolley_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const trolley_real x_j = x[j];
        const trolley_real x_zero = x_j * 0.0F;
        const trolley_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return TROLLEY_BAD_INPUT;
    }
    int32_t row;
    trolley_real s;
    trolley_segment(t, &row, &s);
    trolley_real w0;
    trolley_real w1;
    trolley_real w2;
    trolley_real w3;
    trolley_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const trolley_real lower_edge = trolley_edge_at(lower_at, w0, w1, w2, w3);
        const trolley_real upper_edge = trolley_edge_at(upper_at, w0, w1, w2, w3);
        const trolley_real x_i = x[i];
        const trolley_real gain_i = trolley_gain[i];
        const trolley_real gain_minus = -gain_i;
        const trolley_real width = upper_edge - lower_edge;
        const trolley_real to_lower = x_i - lower_edge;
        const trolley_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const trolley_real distance = upper_nearer ? to_upper : to_lower;
        const trolley_real gain = upper_nearer ? gain_minus : gain_i;
        const trolley_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const trolley_real to_nearer = clear ? distance : smallest;
        const trolley_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        const trolley_real u_limit = trolley_u_max[i];
        trolley_real epsilon;
        trolley_real xi;
        trolley_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const trolley_real u_i = trolley_law(gain, xi, epsilon);
        const trolley_real u_min = -u_limit;
        const bool u_above = u_min < u_i;
        const trolley_real u_raised = u_above ? u_i : u_min;
        const bool u_beyond = u_limit < u_raised;
        const trolley_real u_limited = u_beyond ? u_limit : u_raised;
        u[i] = u_limited;
        outside = outside_next;
    }
    return outside ? TROLLEY_OUTSIDE_TUBE : TROLLEY_OK;
}

trolley_real trolley_margin(trolley_real t, const trolley_real x[TROLLEY_N])
{
    const trolley_real t_zero = t * 0.0F;
    trolley_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const trolley_real x_j = x[j];
        const trolley_real x_zero = x_j * 0.0F;
        const trolley_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (trolley_real)NAN;
    }
    int32_t row;
    trolley_real s;
    trolley_segment(t, &row, &s);
    trolley_real w0;
    trolley_real w1;
    trolley_real w2;
    trolley_real w3;
    trolley_basis(s, &w0, &w1, &w2, &w3);
    trolley_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const trolley_real lower_edge = trolley_edge_at(lower_at, w0, w1, w2, w3);
        const trolley_real upper_edge = trolley_edge_at(upper_at, w0, w1, w2, w3);
        const trolley_real x_i = x[i];
        const trolley_real width = upper_edge - lower_edge;
        const trolley_real to_lower = x_i - lower_edge;
        const trolley_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const trolley_real x_distance = x_nearer ? to_upper : to_lower;
        const trolley_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const trolley_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const trolley_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void trolley_margins(trolley_real t, const trolley_real x[TROLLEY_N], trolley_real margin[TROLLEY_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (trolley_real)NAN;
        }
        return;
    }
    int32_t row;
    trolley_real s;
    trolley_segment(t, &row, &s);
    trolley_real w0;
    trolley_real w1;
    trolley_real w2;
    trolley_real w3;
    trolley_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const trolley_real lower_edge = trolley_edge_at(lower_at, w0, w1, w2, w3);
        const trolley_real upper_edge = trolley_edge_at(upper_at, w0, w1, w2, w3);
        const trolley_real x_i = x[i];
        const trolley_real width = upper_edge - lower_edge;
        const trolley_real to_lower = x_i - lower_edge;
        const trolley_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const trolley_real x_distance = x_nearer ? to_upper : to_lower;
        const trolley_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const trolley_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool trolley_covered(const trolley_real x[TROLLEY_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const trolley_real x_i = x[i];
        const trolley_real x_lower = trolley_start_lower[i];
        const trolley_real x_upper = trolley_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void trolley_transform(const trolley_real lower[TROLLEY_N], const trolley_real upper[TROLLEY_N],
                       const trolley_real x[TROLLEY_N], trolley_real e[TROLLEY_N],
                       trolley_real epsilon[TROLLEY_N], trolley_real xi[TROLLEY_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const trolley_real lower_edge = lower[i];
        const trolley_real upper_edge = upper[i];
        const trolley_real x_i = x[i];
        const trolley_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const trolley_real safe_width = wide ? width : 9.536743e-7F;
        const trolley_real to_lower = x_i - lower_edge;
        const trolley_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const trolley_real distance = upper_nearer ? to_upper : to_lower;
        const trolley_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const trolley_real smallest = safe_width * 0.005F;
        const trolley_real widened = safe_width - width;
        const trolley_real half = widened * 0.5F;
        const trolley_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const trolley_real to_nearer = clear ? safe_distance : smallest;
        const trolley_real to_farther = safe_width - to_nearer;
        const trolley_real a = upper_nearer ? to_farther : to_nearer;
        const trolley_real b = upper_nearer ? to_nearer : to_farther;
        const trolley_real e_i = trolley_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const trolley_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const trolley_real e_limited = e_beyond ? 0.99F : e_raised;
        trolley_real epsilon_nearer;
        trolley_real xi_i;
        trolley_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const trolley_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const trolley_real e_or_zero = empty ? 0.0F : e_limited;
        const trolley_real e_out = finite ? e_or_zero : (trolley_real)NAN;
        e[i] = e_out;
        const trolley_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const trolley_real epsilon_out = finite ? epsilon_or_zero : (trolley_real)NAN;
        epsilon[i] = epsilon_out;
        const trolley_real xi_or_zero = empty ? 0.0F : xi_i;
        const trolley_real xi_out = finite ? xi_or_zero : (trolley_real)NAN;
        xi[i] = xi_out;
    }
}
