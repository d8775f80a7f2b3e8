/* rover.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (rover.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The state stays in it (P9) sampled every 0.02 s or faster, from every start with |e(0)| <= 0.9, for |f + w| <= 0.1,
 * 0.99 <= g_ii <= 1.01, |g_ij| <= 0.1, x measured to 0.005, u acts at most 0.002 s after its sample: |e| < [0.9118,
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "rover.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "rover.c: double is not IEEE-754's here, for which rounding is bounded"
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
    0.09821891784667969, 0.1688232421875, 0.08110618591308594, 0.15057945251464844,
    0.11667728424072266, 0.18332290649414062, 0.11667728424072266, 0.18332290649414062,
    0.13513469696044922, 0.19782352447509766, 0.15224742889404297, 0.21606731414794922,
    0.15359210968017578, 0.2123241424560547, 0.1878185272216797, 0.2488117218017578,
    0.17204952239990234, 0.22682476043701172, 0.223388671875, 0.2815561294555664,
    0.1905069351196289, 0.24132442474365234, 0.2589597702026367, 0.3142995834350586,
    0.20896434783935547, 0.2558250427246094, 0.29452991485595703, 0.3470439910888672,
    0.2375478744506836, 0.2844085693359375, 0.33010101318359375, 0.3797883987426758,
    0.2731180191040039, 0.3199787139892578, 0.36567211151123047, 0.4125328063964844,
    0.3086891174316406, 0.35554981231689453, 0.3942546844482422, 0.4411153793334961,
    0.34426021575927734, 0.39112091064453125, 0.39008331298828125, 0.43694400787353516,
    0.37983036041259766, 0.42669105529785156, 0.3859109878540039, 0.4327716827392578,
    0.4154014587402344, 0.4622621536254883, 0.38173866271972656, 0.42859935760498047,
    0.4509716033935547, 0.4978322982788086, 0.3775663375854492, 0.4244270324707031,
    0.4865427017211914, 0.5334033966064453, 0.370452880859375, 0.4173135757446289,
    0.5221128463745117, 0.5689735412597656, 0.3633384704589844, 0.4101991653442383,
    0.5576839447021484, 0.6045446395874023, 0.35622406005859375, 0.40308475494384766,
    0.5932550430297852, 0.6401157379150391, 0.3484821319580078, 0.3953428268432617,
    0.6288251876831055, 0.6756858825683594, 0.3386507034301758, 0.3855113983154297,
    0.6643962860107422, 0.7112569808959961, 0.32881832122802734, 0.37567901611328125,
    0.6999664306640625, 0.7468271255493164, 0.3189868927001953, 0.3658475875854492,
    0.7355375289916992, 0.7823982238769531, 0.3091554641723633, 0.3560161590576172,
    0.7711076736450195, 0.8179683685302734, 0.29932308197021484, 0.34618377685546875,
    0.8066787719726562, 0.8535394668579102, 0.2894916534423828, 0.3363523483276367,
    0.8422489166259766, 0.8891096115112305, 0.3250589370727539, 0.3719196319580078,
    0.8778200149536133, 0.9246807098388672, 0.3606300354003906, 0.40749073028564453,
    0.91339111328125, 0.9602518081665039, 0.39620018005371094, 0.44306087493896484,
    0.9489612579345703, 0.9958219528198242, 0.43177127838134766, 0.47863197326660156,
    0.984532356262207, 1.031393051147461, 0.46734142303466797, 0.5142021179199219,
    0.9962882995605469, 1.0431489944458008, 0.5029125213623047, 0.5497732162475586,
    1.0080442428588867, 1.0549049377441406, 0.5384836196899414, 0.5853443145751953,
    1.019801139831543, 1.0666618347167969, 0.5740537643432617, 0.6209144592285156,
    1.019801139831543, 1.0666618347167969, 0.6096248626708984, 0.6564855575561523,
    1.019801139831543, 1.0666618347167969, 0.6451950073242188, 0.6920557022094727,
    1.019801139831543, 1.0666618347167969, 0.6096248626708984, 0.6564855575561523
};

/* Gain k of the control law, by component. */
static const rover_real rover_gain[2] = {
    0.0109, 0.0155
};

/* Saturation of u, by component. */
static const rover_real rover_u_max[2] = {
    0.7999999999999999, 0.7999999999999999
};

/* Covered starts have x strictly above these bounds, by component. */
static const rover_real rover_start_lower[2] = {
    0.7250565338134781, 0.7250565338134781
};

/* Covered starts have x strictly below these bounds, by component. */
static const rover_real rover_start_upper[2] = {
    1.0749446105957015, 1.0749446105957015
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 20 s).
 */
static inline void rover_segment(rover_real t, int32_t *row, rover_real *s)
{
    const bool positive = 0.0 < t;
    const rover_real started = positive ? t : 0.0;
    const rover_real scaled = started * 1.6;
    const bool early = scaled < 31.999999999999996;
    const rover_real u = early ? scaled : 31.999999999999996;
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
    const rover_real v0 = 1.0 - s;
    const rover_real v1 = v0 * v0;
    const rover_real v2 = v1 * v0;
    const rover_real v3 = v0 * s;
    const rover_real v4 = 1.0 + v3;
    const rover_real v5 = 3.0 * v4;
    const rover_real v6 = v0 * v5;
    const rover_real v7 = 1.0 + v6;
    const rover_real v8 = s * v5;
    const rover_real v9 = 1.0 + v8;
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
    const rover_real v0 = 1.0 - s;
    const rover_real v1 = v0 + v0;
    const rover_real v2 = v0 * v1;
    const rover_real v3 = v0 * v0;
    const rover_real v4 = v2 + v3;
    const rover_real v5 = -v4;
    const rover_real v6 = v0 - s;
    const rover_real v7 = 3.0 * v6;
    const rover_real v8 = v0 * v7;
    const rover_real v9 = v0 * s;
    const rover_real v10 = 1.0 + v9;
    const rover_real v11 = 3.0 * v10;
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
    const rover_real v1 = log(v0);
    const rover_real v2 = -v1;
    const rover_real v3 = 1.0 + v0;
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
    const bool moving = t < 20.0;
    const rover_real per_second = moving ? 1.6 : 0.0;
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
    const rover_real t_zero = t * 0.0;
    rover_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const rover_real x_j = x[j];
        const rover_real x_zero = x_j * 0.0;
        const rover_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
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
        const rover_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const rover_real to_nearer = clear ? distance : smallest;
        const rover_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
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
    const rover_real t_zero = t * 0.0;
    rover_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const rover_real x_j = x[j];
        const rover_real x_zero = x_j * 0.0;
        const rover_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
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
    rover_real margin = 0.5;
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
        const bool x_beyond = x_share < (-1.0);
        const rover_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool x_beyond = x_share < (-1.0);
        const rover_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const rover_real safe_width = wide ? width : 9.5367431640625e-7;
        const rover_real to_lower = x_i - lower_edge;
        const rover_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const rover_real distance = upper_nearer ? to_upper : to_lower;
        const rover_real sign = upper_nearer ? (-1.0) : 1.0;
        const rover_real smallest = safe_width * 0.005;
        const rover_real widened = safe_width - width;
        const rover_real half = widened * 0.5;
        const rover_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const rover_real to_nearer = clear ? safe_distance : smallest;
        const rover_real to_farther = safe_width - to_nearer;
        const rover_real a = upper_nearer ? to_farther : to_nearer;
        const rover_real b = upper_nearer ? to_nearer : to_farther;
        const rover_real e_i = rover_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const rover_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const rover_real e_limited = e_beyond ? 0.99 : e_raised;
        rover_real epsilon_nearer;
        rover_real xi_i;
        rover_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const rover_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const rover_real e_or_zero = empty ? 0.0 : e_limited;
        const rover_real e_out = finite ? e_or_zero : (rover_real)NAN;
        e[i] = e_out;
        const rover_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const rover_real epsilon_out = finite ? epsilon_or_zero : (rover_real)NAN;
        epsilon[i] = epsilon_out;
        const rover_real xi_or_zero = empty ? 0.0 : xi_i;
        const rover_real xi_out = finite ? xi_or_zero : (rover_real)NAN;
        xi[i] = xi_out;
    }
}
