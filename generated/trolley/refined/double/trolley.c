/* trolley.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "trolley.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "trolley.c: double is not IEEE-754's here, for which rounding is bounded"
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
    0.011121749877929688, 0.11665534973144531, 0.03612232208251953, 0.14430618286132812,
    0.03334331512451172, 0.13332271575927734, 0.03334331512451172, 0.13332271575927734,
    0.055565834045410156, 0.14999103546142578, 0.030565261840820312, 0.12234020233154297,
    0.07778739929199219, 0.1666584014892578, 0.0277862548828125, 0.11135673522949219,
    0.10000896453857422, 0.18332576751708984, 0.025007247924804688, 0.1003732681274414,
    0.12223148345947266, 0.19999313354492188, 0.02222919464111328, 0.08938980102539062,
    0.1444530487060547, 0.2166604995727539, 0.01945018768310547, 0.07840633392333984,
    0.16667461395263672, 0.23332786560058594, 0.016672134399414062, 0.07431221008300781,
    0.18889713287353516, 0.24999618530273438, 0.016672134399414062, 0.07431221008300781,
    0.2111186981201172, 0.26875972747802734, 0.016672134399414062, 0.07431221008300781,
    0.23334026336669922, 0.2909812927246094, 0.016672134399414062, 0.07431221008300781,
    0.25556278228759766, 0.3132028579711914, 0.016672134399414062, 0.07431221008300781,
    0.2777843475341797, 0.33542537689208984, 0.016672134399414062, 0.07431221008300781,
    0.3000059127807617, 0.3576469421386719, 0.016672134399414062, 0.07431221008300781,
    0.32222843170166016, 0.3798685073852539, 0.016672134399414062, 0.07431221008300781,
    0.3444499969482422, 0.40209102630615234, 0.016672134399414062, 0.07431221008300781,
    0.3666715621948242, 0.4243125915527344, 0.01735401153564453, 0.07499504089355469,
    0.38889312744140625, 0.4465341567993164, 0.018036842346191406, 0.07567691802978516,
    0.4111156463623047, 0.46875667572021484, 0.03743171691894531, 0.09507274627685547,
    0.4333372116088867, 0.4909782409667969, 0.056827545166015625, 0.11446857452392578,
    0.45555877685546875, 0.5131998062133789, 0.07622337341308594, 0.1338644027709961,
    0.4777812957763672, 0.5354213714599609, 0.09561920166015625, 0.1532602310180664,
    0.5000028610229492, 0.5576438903808594, 0.11501502990722656, 0.17265605926513672,
    0.5222244262695312, 0.5798654556274414, 0.1354827880859375, 0.19312381744384766,
    0.5444469451904297, 0.6020870208740234, 0.15595054626464844, 0.2135915756225586,
    0.5666685104370117, 0.6243095397949219, 0.17641830444335938, 0.23405933380126953,
    0.5888900756835938, 0.6465311050415039, 0.1968860626220703, 0.25452709197998047,
    0.6111116409301758, 0.6687526702880859, 0.21735382080078125, 0.2749948501586914,
    0.6333341598510742, 0.690974235534668, 0.2378215789794922, 0.29546260833740234,
    0.6555557250976562, 0.7131967544555664, 0.2582893371582031, 0.3159303665161133,
    0.6592607498168945, 0.7169017791748047, 0.27875804901123047, 0.3363981246948242,
    0.6629667282104492, 0.720606803894043, 0.2992258071899414, 0.35686588287353516,
    0.6666717529296875, 0.7243127822875977, 0.31969356536865234, 0.3773336410522461,
    0.6666717529296875, 0.7243127822875977, 0.3401613235473633, 0.39780139923095703,
    0.6666717529296875, 0.7243127822875977, 0.31969356536865234, 0.3773336410522461
};

/* Gain k of the control law, by component. */
static const trolley_real trolley_gain[2] = {
    0.0384, 0.0252
};

/* Saturation of u, by component. */
static const trolley_real trolley_u_max[2] = {
    2.0, 2.0
};

/* Covered starts have x strictly above these bounds, by component. */
static const trolley_real trolley_start_lower[2] = {
    0.23205466461181753, 0.23205466461181753
};

/* Covered starts have x strictly below these bounds, by component. */
static const trolley_real trolley_start_upper[2] = {
    0.7679434280395496, 0.7679434280395496
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 8 s).
 */
static inline void trolley_segment(trolley_real t, int32_t *row, trolley_real *s)
{
    const bool positive = 0.0 < t;
    const trolley_real started = positive ? t : 0.0;
    const trolley_real scaled = started * 4.0;
    const bool early = scaled < 31.999999999999996;
    const trolley_real u = early ? scaled : 31.999999999999996;
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
    const trolley_real v0 = 1.0 - s;
    const trolley_real v1 = v0 * v0;
    const trolley_real v2 = v1 * v0;
    const trolley_real v3 = v0 * s;
    const trolley_real v4 = 1.0 + v3;
    const trolley_real v5 = 3.0 * v4;
    const trolley_real v6 = v0 * v5;
    const trolley_real v7 = 1.0 + v6;
    const trolley_real v8 = s * v5;
    const trolley_real v9 = 1.0 + v8;
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
    const trolley_real v0 = 1.0 - s;
    const trolley_real v1 = v0 + v0;
    const trolley_real v2 = v0 * v1;
    const trolley_real v3 = v0 * v0;
    const trolley_real v4 = v2 + v3;
    const trolley_real v5 = -v4;
    const trolley_real v6 = v0 - s;
    const trolley_real v7 = 3.0 * v6;
    const trolley_real v8 = v0 * v7;
    const trolley_real v9 = v0 * s;
    const trolley_real v10 = 1.0 + v9;
    const trolley_real v11 = 3.0 * v10;
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
    const trolley_real v1 = log(v0);
    const trolley_real v2 = -v1;
    const trolley_real v3 = 1.0 + v0;
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
    const bool moving = t < 8.0;
    const trolley_real per_second = moving ? 4.0 : 0.0;
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
    const trolley_real t_zero = t * 0.0;
    trolley_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const trolley_real x_j = x[j];
        const trolley_real x_zero = x_j * 0.0;
        const trolley_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
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
        const trolley_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const trolley_real to_nearer = clear ? distance : smallest;
        const trolley_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
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
    const trolley_real t_zero = t * 0.0;
    trolley_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const trolley_real x_j = x[j];
        const trolley_real x_zero = x_j * 0.0;
        const trolley_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
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
    trolley_real margin = 0.5;
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
        const bool x_beyond = x_share < (-1.0);
        const trolley_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool x_beyond = x_share < (-1.0);
        const trolley_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const trolley_real safe_width = wide ? width : 9.5367431640625e-7;
        const trolley_real to_lower = x_i - lower_edge;
        const trolley_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const trolley_real distance = upper_nearer ? to_upper : to_lower;
        const trolley_real sign = upper_nearer ? (-1.0) : 1.0;
        const trolley_real smallest = safe_width * 0.005;
        const trolley_real widened = safe_width - width;
        const trolley_real half = widened * 0.5;
        const trolley_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const trolley_real to_nearer = clear ? safe_distance : smallest;
        const trolley_real to_farther = safe_width - to_nearer;
        const trolley_real a = upper_nearer ? to_farther : to_nearer;
        const trolley_real b = upper_nearer ? to_nearer : to_farther;
        const trolley_real e_i = trolley_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const trolley_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const trolley_real e_limited = e_beyond ? 0.99 : e_raised;
        trolley_real epsilon_nearer;
        trolley_real xi_i;
        trolley_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const trolley_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const trolley_real e_or_zero = empty ? 0.0 : e_limited;
        const trolley_real e_out = finite ? e_or_zero : (trolley_real)NAN;
        e[i] = e_out;
        const trolley_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const trolley_real epsilon_out = finite ? epsilon_or_zero : (trolley_real)NAN;
        epsilon[i] = epsilon_out;
        const trolley_real xi_or_zero = empty ? 0.0 : xi_i;
        const trolley_real xi_out = finite ? xi_or_zero : (trolley_real)NAN;
        xi[i] = xi_out;
    }
}
