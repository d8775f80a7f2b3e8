/* rover.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (rover.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The state stays in it (P9) sampled every 0.02 s or faster, from every start with |e(0)| <= 0.9, for |f + w| <= 0.1,
 * 0.99 <= g_ii <= 1.01, |g_ij| <= 0.1, x measured to 0.005, u acts at most 0.002 s after its sample: |e| < [0.9119,
 * 0.9105], |u| <= 0.8.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "rover.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "rover.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "rover.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "rover.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "rover.c: float is not IEEE-754's here, for which rounding is bounded"
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
static const rover_real rover_coefficients[140] = {
    0.09821892F, 0.16882324F, 0.081106186F, 0.15057945F,
    0.116677284F, 0.1833229F, 0.116677284F, 0.1833229F,
    0.1351347F, 0.19782352F, 0.15224743F, 0.21606731F,
    0.15359211F, 0.21232414F, 0.18781853F, 0.24881172F,
    0.17204952F, 0.22682476F, 0.22338867F, 0.28155613F,
    0.19050694F, 0.24132442F, 0.25895977F, 0.31429958F,
    0.20896435F, 0.25582504F, 0.2945299F, 0.347044F,
    0.23754787F, 0.28440857F, 0.330101F, 0.3797884F,
    0.27311802F, 0.3199787F, 0.3656721F, 0.4125328F,
    0.30868912F, 0.3555498F, 0.39425468F, 0.44111538F,
    0.34426022F, 0.3911209F, 0.3900833F, 0.436944F,
    0.37983036F, 0.42669106F, 0.385911F, 0.43277168F,
    0.41540146F, 0.46226215F, 0.38173866F, 0.42859936F,
    0.4509716F, 0.4978323F, 0.37756634F, 0.42442703F,
    0.4865427F, 0.5334034F, 0.37045288F, 0.41731358F,
    0.52211285F, 0.56897354F, 0.36333847F, 0.41019917F,
    0.55768394F, 0.60454464F, 0.35622406F, 0.40308475F,
    0.59325504F, 0.64011574F, 0.34848213F, 0.39534283F,
    0.6288252F, 0.6756859F, 0.3386507F, 0.3855114F,
    0.6643963F, 0.711257F, 0.32881832F, 0.37567902F,
    0.69996643F, 0.7468271F, 0.3189869F, 0.3658476F,
    0.7355375F, 0.7823982F, 0.30915546F, 0.35601616F,
    0.7711077F, 0.81796837F, 0.29932308F, 0.34618378F,
    0.8066788F, 0.85353947F, 0.28949165F, 0.33635235F,
    0.8422489F, 0.8891096F, 0.32505894F, 0.37191963F,
    0.87782F, 0.9246807F, 0.36063004F, 0.40749073F,
    0.9133911F, 0.9602518F, 0.39620018F, 0.44306087F,
    0.94896126F, 0.99582195F, 0.43177128F, 0.47863197F,
    0.98453236F, 1.031393F, 0.46734142F, 0.5142021F,
    0.9962883F, 1.043149F, 0.5029125F, 0.5497732F,
    1.0080442F, 1.0549049F, 0.5384836F, 0.5853443F,
    1.0198011F, 1.0666618F, 0.57405376F, 0.62091446F,
    1.0198011F, 1.0666618F, 0.60962486F, 0.65648556F,
    1.0198011F, 1.0666618F, 0.645195F, 0.6920557F,
    1.0198011F, 1.0666618F, 0.60962486F, 0.65648556F
};

/* Gain k of the control law, by component. */
static const rover_real rover_gain[2] = {
    0.0109F, 0.0155F
};

/* Saturation of u, by component. */
static const rover_real rover_u_max[2] = {
    0.79999995F, 0.79999995F
};

/* Covered starts have x strictly above these bounds, by component. */
static const rover_real rover_start_lower[2] = {
    0.7250574F, 0.7250574F
};

/* Covered starts have x strictly below these bounds, by component. */
static const rover_real rover_start_upper[2] = {
    1.0749437F, 1.0749437F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 20 s).
 */
static inline void rover_segment(rover_real t, int32_t *row, rover_real *s)
{
    const bool positive = 0.0F < t;
    const rover_real started = positive ? t : 0.0F;
    const rover_real scaled = started * 1.6F;
    const bool early = scaled < 31.999998F;
    const rover_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const rover_real base = (rover_real)segment;
    const rover_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void rover_basis(rover_real s, rover_real *w0, rover_real *w1, rover_real *w2, rover_real *w3)
{
    const rover_real v0 = 1.0F - s;
    const rover_real v1 = v0 * v0;
    const rover_real v2 = v1 * v0;
    const rover_real v3 = v0 * s;
    const rover_real v4 = 1.0F + v3;
    const rover_real v5 = 3.0F * v4;
    const rover_real v6 = v0 * v5;
    const rover_real v7 = 1.0F + v6;
    const rover_real v8 = s * v5;
    const rover_real v9 = 1.0F + v8;
    const rover_real v10 = s * s;
    const rover_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void rover_basis_rate(rover_real s, rover_real *dw0, rover_real *dw1, rover_real *dw2,
                                    rover_real *dw3)
{
    const rover_real v0 = 1.0F - s;
    const rover_real v1 = v0 + v0;
    const rover_real v2 = v0 * v1;
    const rover_real v3 = v0 * v0;
    const rover_real v4 = v2 + v3;
    const rover_real v5 = -v4;
    const rover_real v6 = v0 - s;
    const rover_real v7 = 3.0F * v6;
    const rover_real v8 = v0 * v7;
    const rover_real v9 = v0 * s;
    const rover_real v10 = 1.0F + v9;
    const rover_real v11 = 3.0F * v10;
    const rover_real v12 = v8 - v11;
    const rover_real v13 = s * v7;
    const rover_real v14 = v11 + v13;
    const rover_real v15 = s + s;
    const rover_real v16 = s * v15;
    const rover_real v17 = s * s;
    const rover_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline rover_real rover_edge_at(int32_t at, rover_real w0, rover_real w1, rover_real w2, rover_real w3)
{
    const rover_real q0 = rover_coefficients[at];
    const int32_t at_1 = at + 4;
    const rover_real q1 = rover_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const rover_real q2 = rover_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const rover_real q3 = rover_coefficients[at_3];
    const rover_real v0 = w0 * q0;
    const rover_real v1 = w1 * q1;
    const rover_real v2 = v0 + v1;
    const rover_real v3 = w2 * q2;
    const rover_real v4 = w3 * q3;
    const rover_real v5 = v3 + v4;
    const rover_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline rover_real rover_normalized_error(rover_real a, rover_real b, rover_real width)
{
    const rover_real v0 = a - b;
    const rover_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void rover_transformed_error(rover_real a, rover_real b, rover_real *epsilon, rover_real *xi)
{
    const rover_real v0 = b / a;
    const rover_real v1 = logf(v0);
    const rover_real v2 = -v1;
    const rover_real v3 = 1.0F + v0;
    const rover_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline rover_real rover_law(rover_real k, rover_real xi, rover_real epsilon)
{
    const rover_real v0 = k * xi;
    const rover_real v1 = v0 * epsilon;
    const rover_real v2 = -v1;
    return v2;
}

void rover_tube(rover_real t, rover_real lower[ROVER_N], rover_real upper[ROVER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (rover_real)NAN;
            upper[j] = (rover_real)NAN;
        }
        return;
    }
    int32_t row;
    rover_real s;
    rover_segment(t, &row, &s);
    rover_real w0;
    rover_real w1;
    rover_real w2;
    rover_real w3;
    rover_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const rover_real lower_edge = rover_edge_at(lower_at, w0, w1, w2, w3);
        const rover_real upper_edge = rover_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void rover_tube_rate(rover_real t, rover_real lower_rate[ROVER_N], rover_real upper_rate[ROVER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (rover_real)NAN;
            upper_rate[j] = (rover_real)NAN;
        }
        return;
    }
    int32_t row;
    rover_real s;
    rover_segment(t, &row, &s);
    rover_real dw0;
    rover_real dw1;
    rover_real dw2;
    rover_real dw3;
    rover_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 20.0F;
    const rover_real per_second = moving ? 1.6F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const rover_real lower_slope = rover_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const rover_real lower_speed = lower_slope * per_second;
        const rover_real upper_slope = rover_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const rover_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

rover_status rover_control(rover_real t, const rover_real x[ROVER_N], rover_real u[ROVER_N])
{
    const rover_real t_zero = t * 0.0F;
    rover_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const rover_real x_j = x[j];
        const rover_real x_zero = x_j * 0.0F;
        const rover_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return ROVER_BAD_INPUT;
    }
    int32_t row;
    rover_real s;
    rover_segment(t, &row, &s);
    rover_real w0;
    rover_real w1;
    rover_real w2;
    rover_real w3;
    rover_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const rover_real lower_edge = rover_edge_at(lower_at, w0, w1, w2, w3);
        const rover_real upper_edge = rover_edge_at(upper_at, w0, w1, w2, w3);
        const rover_real x_i = x[i];
        const rover_real gain_i = rover_gain[i];
        const rover_real gain_minus = -gain_i;
        const rover_real width = upper_edge - lower_edge;
        const rover_real to_lower = x_i - lower_edge;
        const rover_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const rover_real distance = upper_nearer ? to_upper : to_lower;
        const rover_real gain = upper_nearer ? gain_minus : gain_i;
        const rover_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const rover_real to_nearer = clear ? distance : smallest;
        const rover_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        const rover_real u_limit = rover_u_max[i];
        rover_real epsilon;
        rover_real xi;
        rover_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const rover_real u_i = rover_law(gain, xi, epsilon);
        const rover_real u_min = -u_limit;
        const bool u_above = u_min < u_i;
        const rover_real u_raised = u_above ? u_i : u_min;
        const bool u_beyond = u_limit < u_raised;
        const rover_real u_limited = u_beyond ? u_limit : u_raised;
        u[i] = u_limited;
        outside = outside_next;
    }
    return outside ? ROVER_OUTSIDE_TUBE : ROVER_OK;
}

rover_real rover_margin(rover_real t, const rover_real x[ROVER_N])
{
    const rover_real t_zero = t * 0.0F;
    rover_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const rover_real x_j = x[j];
        const rover_real x_zero = x_j * 0.0F;
        const rover_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (rover_real)NAN;
    }
    int32_t row;
    rover_real s;
    rover_segment(t, &row, &s);
    rover_real w0;
    rover_real w1;
    rover_real w2;
    rover_real w3;
    rover_basis(s, &w0, &w1, &w2, &w3);
    rover_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const rover_real lower_edge = rover_edge_at(lower_at, w0, w1, w2, w3);
        const rover_real upper_edge = rover_edge_at(upper_at, w0, w1, w2, w3);
        const rover_real x_i = x[i];
        const rover_real width = upper_edge - lower_edge;
        const rover_real to_lower = x_i - lower_edge;
        const rover_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const rover_real x_distance = x_nearer ? to_upper : to_lower;
        const rover_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const rover_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const rover_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void rover_margins(rover_real t, const rover_real x[ROVER_N], rover_real margin[ROVER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (rover_real)NAN;
        }
        return;
    }
    int32_t row;
    rover_real s;
    rover_segment(t, &row, &s);
    rover_real w0;
    rover_real w1;
    rover_real w2;
    rover_real w3;
    rover_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const rover_real lower_edge = rover_edge_at(lower_at, w0, w1, w2, w3);
        const rover_real upper_edge = rover_edge_at(upper_at, w0, w1, w2, w3);
        const rover_real x_i = x[i];
        const rover_real width = upper_edge - lower_edge;
        const rover_real to_lower = x_i - lower_edge;
        const rover_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const rover_real x_distance = x_nearer ? to_upper : to_lower;
        const rover_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const rover_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool rover_covered(const rover_real x[ROVER_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const rover_real x_i = x[i];
        const rover_real x_lower = rover_start_lower[i];
        const rover_real x_upper = rover_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void rover_transform(const rover_real lower[ROVER_N], const rover_real upper[ROVER_N],
                     const rover_real x[ROVER_N], rover_real e[ROVER_N], rover_real epsilon[ROVER_N],
                     rover_real xi[ROVER_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const rover_real lower_edge = lower[i];
        const rover_real upper_edge = upper[i];
        const rover_real x_i = x[i];
        const rover_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const rover_real safe_width = wide ? width : 9.536743e-7F;
        const rover_real to_lower = x_i - lower_edge;
        const rover_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const rover_real distance = upper_nearer ? to_upper : to_lower;
        const rover_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const rover_real smallest = safe_width * 0.005F;
        const rover_real widened = safe_width - width;
        const rover_real half = widened * 0.5F;
        const rover_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const rover_real to_nearer = clear ? safe_distance : smallest;
        const rover_real to_farther = safe_width - to_nearer;
        const rover_real a = upper_nearer ? to_farther : to_nearer;
        const rover_real b = upper_nearer ? to_nearer : to_farther;
        const rover_real e_i = rover_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const rover_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const rover_real e_limited = e_beyond ? 0.99F : e_raised;
        rover_real epsilon_nearer;
        rover_real xi_i;
        rover_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const rover_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const rover_real e_or_zero = empty ? 0.0F : e_limited;
        const rover_real e_out = finite ? e_or_zero : (rover_real)NAN;
        e[i] = e_out;
        const rover_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const rover_real epsilon_out = finite ? epsilon_or_zero : (rover_real)NAN;
        epsilon[i] = epsilon_out;
        const rover_real xi_or_zero = empty ? 0.0F : xi_i;
        const rover_real xi_out = finite ? xi_or_zero : (rover_real)NAN;
        xi[i] = xi_out;
    }
}
