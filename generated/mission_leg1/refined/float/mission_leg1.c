/* mission_leg1.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (mission_leg1.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "mission_leg1.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "mission_leg1.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "mission_leg1.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "mission_leg1.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "mission_leg1.c: float is not IEEE-754's here, for which rounding is bounded"
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
 * Multiples of 2^-18: exact in float and double.
 */
static const mission_leg1_real mission_leg1_coefficients[140] = {
    0.61621094F, 0.7830925F, 0.6173401F, 0.7842903F,
    0.6667061F, 0.8332939F, 0.6667061F, 0.8332939F,
    0.71720505F, 0.8834915F, 0.7160759F, 0.8822937F,
    0.767704F, 0.9336891F, 0.7654419F, 0.9312973F,
    0.818203F, 0.9838867F, 0.8148117F, 0.9803009F,
    0.8686981F, 1.0340881F, 0.8641815F, 1.0293007F,
    0.9191971F, 1.0842857F, 0.9135475F, 1.0783043F,
    0.96969604F, 1.1344833F, 0.9629173F, 1.1273079F,
    1.020195F, 1.1846848F, 1.0122833F, 1.1763077F,
    1.0706902F, 1.2348824F, 1.0616531F, 1.2253113F,
    1.1211891F, 1.28508F, 1.1110191F, 1.2743111F,
    1.1716881F, 1.3352776F, 1.16502F, 1.3283119F,
    1.2221832F, 1.385479F, 1.2190208F, 1.3823128F,
    1.2723846F, 1.4356766F, 1.2730217F, 1.4363136F,
    1.2760696F, 1.4393616F, 1.3270187F, 1.4903145F,
    1.2797508F, 1.4430466F, 1.3810196F, 1.5443115F,
    1.2834358F, 1.4467316F, 1.4350204F, 1.5983124F,
    1.2871208F, 1.4504128F, 1.4890213F, 1.6523132F,
    1.2908058F, 1.4540977F, 1.5430222F, 1.7063141F,
    1.2944908F, 1.4577827F, 1.5970192F, 1.760315F,
    1.2981758F, 1.4614677F, 1.65102F, 1.814312F,
    1.3018608F, 1.4651527F, 1.7050209F, 1.8683128F,
    1.3055458F, 1.4688377F, 1.7590218F, 1.9223137F,
    1.309227F, 1.4725227F, 1.8130226F, 1.9763145F,
    1.312912F, 1.4762077F, 1.8670197F, 2.0303154F,
    1.316597F, 1.4798889F, 1.9210205F, 2.0843124F,
    1.320282F, 1.4835739F, 1.9750214F, 2.1383133F,
    1.323967F, 1.4872589F, 2.0290222F, 2.1923141F,
    1.327652F, 1.4909439F, 2.083023F, 2.246315F,
    1.331337F, 1.4946289F, 2.13702F, 2.300312F,
    1.335022F, 1.4983139F, 2.191021F, 2.354313F,
    1.335022F, 1.4983139F, 2.2450218F, 2.4083138F,
    1.335022F, 1.4983139F, 2.2990227F, 2.4623146F,
    1.335022F, 1.4983139F, 2.3530197F, 2.5163116F,
    1.335022F, 1.4983139F, 2.2990227F, 2.4623146F
};

/* Covered starts have x strictly above these bounds, by component. */
static const mission_leg1_real mission_leg1_start_lower[2] = {
    4.0052404F, 4.0052404F
};

/* Covered starts have x strictly below these bounds, by component. */
static const mission_leg1_real mission_leg1_start_upper[2] = {
    4.9947596F, 4.9947596F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 9.5 s).
 */
static inline void mission_leg1_segment(mission_leg1_real t, int32_t *row, mission_leg1_real *s)
{
    const bool positive = 0.0F < t;
    const mission_leg1_real started = positive ? t : 0.0F;
    const mission_leg1_real scaled = started * 3.368421F;
    const bool early = scaled < 31.999998F;
    const mission_leg1_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const mission_leg1_real base = (mission_leg1_real)segment;
    const mission_leg1_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void mission_leg1_basis(mission_leg1_real s, mission_leg1_real *w0, mission_leg1_real *w1,
                                      mission_leg1_real *w2, mission_leg1_real *w3)
{
    const mission_leg1_real v0 = 1.0F - s;
    const mission_leg1_real v1 = v0 * v0;
    const mission_leg1_real v2 = v1 * v0;
    const mission_leg1_real v3 = v0 * s;
    const mission_leg1_real v4 = 1.0F + v3;
    const mission_leg1_real v5 = 3.0F * v4;
    const mission_leg1_real v6 = v0 * v5;
    const mission_leg1_real v7 = 1.0F + v6;
    const mission_leg1_real v8 = s * v5;
    const mission_leg1_real v9 = 1.0F + v8;
    const mission_leg1_real v10 = s * s;
    const mission_leg1_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void mission_leg1_basis_rate(mission_leg1_real s, mission_leg1_real *dw0, mission_leg1_real *dw1,
                                           mission_leg1_real *dw2, mission_leg1_real *dw3)
{
    const mission_leg1_real v0 = 1.0F - s;
    const mission_leg1_real v1 = v0 + v0;
    const mission_leg1_real v2 = v0 * v1;
    const mission_leg1_real v3 = v0 * v0;
    const mission_leg1_real v4 = v2 + v3;
    const mission_leg1_real v5 = -v4;
    const mission_leg1_real v6 = v0 - s;
    const mission_leg1_real v7 = 3.0F * v6;
    const mission_leg1_real v8 = v0 * v7;
    const mission_leg1_real v9 = v0 * s;
    const mission_leg1_real v10 = 1.0F + v9;
    const mission_leg1_real v11 = 3.0F * v10;
    const mission_leg1_real v12 = v8 - v11;
    const mission_leg1_real v13 = s * v7;
    const mission_leg1_real v14 = v11 + v13;
    const mission_leg1_real v15 = s + s;
    const mission_leg1_real v16 = s * v15;
    const mission_leg1_real v17 = s * s;
    const mission_leg1_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline mission_leg1_real mission_leg1_edge_at(int32_t at, mission_leg1_real w0, mission_leg1_real w1,
                                                     mission_leg1_real w2, mission_leg1_real w3)
{
    const mission_leg1_real q0 = mission_leg1_coefficients[at];
    const int32_t at_1 = at + 4;
    const mission_leg1_real q1 = mission_leg1_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const mission_leg1_real q2 = mission_leg1_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const mission_leg1_real q3 = mission_leg1_coefficients[at_3];
    const mission_leg1_real v0 = w0 * q0;
    const mission_leg1_real v1 = w1 * q1;
    const mission_leg1_real v2 = v0 + v1;
    const mission_leg1_real v3 = w2 * q2;
    const mission_leg1_real v4 = w3 * q3;
    const mission_leg1_real v5 = v3 + v4;
    const mission_leg1_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline mission_leg1_real mission_leg1_normalized_error(mission_leg1_real a, mission_leg1_real b,
                                                              mission_leg1_real width)
{
    const mission_leg1_real v0 = a - b;
    const mission_leg1_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void mission_leg1_transformed_error(mission_leg1_real a, mission_leg1_real b,
                                                  mission_leg1_real *epsilon, mission_leg1_real *xi)
{
    const mission_leg1_real v0 = b / a;
    const mission_leg1_real v1 = logf(v0);
    const mission_leg1_real v2 = -v1;
    const mission_leg1_real v3 = 1.0F + v0;
    const mission_leg1_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline mission_leg1_real mission_leg1_law(mission_leg1_real k, mission_leg1_real xi,
                                                 mission_leg1_real epsilon)
{
    const mission_leg1_real v0 = k * xi;
    const mission_leg1_real v1 = v0 * epsilon;
    const mission_leg1_real v2 = -v1;
    return v2;
}

void mission_leg1_tube(mission_leg1_real t, mission_leg1_real lower[MISSION_LEG1_N],
                       mission_leg1_real upper[MISSION_LEG1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (mission_leg1_real)NAN;
            upper[j] = (mission_leg1_real)NAN;
        }
        return;
    }
    int32_t row;
    mission_leg1_real s;
    mission_leg1_segment(t, &row, &s);
    mission_leg1_real w0;
    mission_leg1_real w1;
    mission_leg1_real w2;
    mission_leg1_real w3;
    mission_leg1_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg1_real lower_edge = mission_leg1_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg1_real upper_edge = mission_leg1_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void mission_leg1_tube_rate(mission_leg1_real t, mission_leg1_real lower_rate[MISSION_LEG1_N],
                            mission_leg1_real upper_rate[MISSION_LEG1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (mission_leg1_real)NAN;
            upper_rate[j] = (mission_leg1_real)NAN;
        }
        return;
    }
    int32_t row;
    mission_leg1_real s;
    mission_leg1_segment(t, &row, &s);
    mission_leg1_real dw0;
    mission_leg1_real dw1;
    mission_leg1_real dw2;
    mission_leg1_real dw3;
    mission_leg1_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 9.5F;
    const mission_leg1_real per_second = moving ? 3.368421F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg1_real lower_slope = mission_leg1_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const mission_leg1_real lower_speed = lower_slope * per_second;
        const mission_leg1_real upper_slope = mission_leg1_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const mission_leg1_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

mission_leg1_status mission_leg1_control(mission_leg1_real t, const mission_leg1_real x[MISSION_LEG1_N],
                                         mission_leg1_real u[MISSION_LEG1_N])
{
    const mission_leg1_real t_zero = t * 0.0F;
    mission_leg1_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const mission_leg1_real x_j = x[j];
        const mission_leg1_real x_zero = x_j * 0.0F;
        const mission_leg1_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return MISSION_LEG1_BAD_INPUT;
    }
    int32_t row;
    mission_leg1_real s;
    mission_leg1_segment(t, &row, &s);
    mission_leg1_real w0;
    mission_leg1_real w1;
    mission_leg1_real w2;
    mission_leg1_real w3;
    mission_leg1_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg1_real lower_edge = mission_leg1_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg1_real upper_edge = mission_leg1_edge_at(upper_at, w0, w1, w2, w3);
        const mission_leg1_real x_i = x[i];
        const mission_leg1_real width = upper_edge - lower_edge;
        const mission_leg1_real to_lower = x_i - lower_edge;
        const mission_leg1_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const mission_leg1_real distance = upper_nearer ? to_upper : to_lower;
        const mission_leg1_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const mission_leg1_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const mission_leg1_real to_nearer = clear ? distance : smallest;
        const mission_leg1_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        mission_leg1_real epsilon;
        mission_leg1_real xi;
        mission_leg1_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const mission_leg1_real u_i = mission_leg1_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? MISSION_LEG1_OUTSIDE_TUBE : MISSION_LEG1_OK;
}

mission_leg1_real mission_leg1_margin(mission_leg1_real t, const mission_leg1_real x[MISSION_LEG1_N])
{
    const mission_leg1_real t_zero = t * 0.0F;
    mission_leg1_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const mission_leg1_real x_j = x[j];
        const mission_leg1_real x_zero = x_j * 0.0F;
        const mission_leg1_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (mission_leg1_real)NAN;
    }
    int32_t row;
    mission_leg1_real s;
    mission_leg1_segment(t, &row, &s);
    mission_leg1_real w0;
    mission_leg1_real w1;
    mission_leg1_real w2;
    mission_leg1_real w3;
    mission_leg1_basis(s, &w0, &w1, &w2, &w3);
    mission_leg1_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg1_real lower_edge = mission_leg1_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg1_real upper_edge = mission_leg1_edge_at(upper_at, w0, w1, w2, w3);
        const mission_leg1_real x_i = x[i];
        const mission_leg1_real width = upper_edge - lower_edge;
        const mission_leg1_real to_lower = x_i - lower_edge;
        const mission_leg1_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const mission_leg1_real x_distance = x_nearer ? to_upper : to_lower;
        const mission_leg1_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const mission_leg1_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const mission_leg1_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void mission_leg1_margins(mission_leg1_real t, const mission_leg1_real x[MISSION_LEG1_N],
                          mission_leg1_real margin[MISSION_LEG1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (mission_leg1_real)NAN;
        }
        return;
    }
    int32_t row;
    mission_leg1_real s;
    mission_leg1_segment(t, &row, &s);
    mission_leg1_real w0;
    mission_leg1_real w1;
    mission_leg1_real w2;
    mission_leg1_real w3;
    mission_leg1_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg1_real lower_edge = mission_leg1_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg1_real upper_edge = mission_leg1_edge_at(upper_at, w0, w1, w2, w3);
        const mission_leg1_real x_i = x[i];
        const mission_leg1_real width = upper_edge - lower_edge;
        const mission_leg1_real to_lower = x_i - lower_edge;
        const mission_leg1_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const mission_leg1_real x_distance = x_nearer ? to_upper : to_lower;
        const mission_leg1_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const mission_leg1_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool mission_leg1_covered(const mission_leg1_real x[MISSION_LEG1_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const mission_leg1_real x_i = x[i];
        const mission_leg1_real x_lower = mission_leg1_start_lower[i];
        const mission_leg1_real x_upper = mission_leg1_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void mission_leg1_transform(const mission_leg1_real lower[MISSION_LEG1_N],
                            const mission_leg1_real upper[MISSION_LEG1_N],
                            const mission_leg1_real x[MISSION_LEG1_N], mission_leg1_real e[MISSION_LEG1_N],
                            mission_leg1_real epsilon[MISSION_LEG1_N], mission_leg1_real xi[MISSION_LEG1_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const mission_leg1_real lower_edge = lower[i];
        const mission_leg1_real upper_edge = upper[i];
        const mission_leg1_real x_i = x[i];
        const mission_leg1_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const mission_leg1_real safe_width = wide ? width : 9.536743e-7F;
        const mission_leg1_real to_lower = x_i - lower_edge;
        const mission_leg1_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const mission_leg1_real distance = upper_nearer ? to_upper : to_lower;
        const mission_leg1_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const mission_leg1_real smallest = safe_width * 0.005F;
        const mission_leg1_real widened = safe_width - width;
        const mission_leg1_real half = widened * 0.5F;
        const mission_leg1_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const mission_leg1_real to_nearer = clear ? safe_distance : smallest;
        const mission_leg1_real to_farther = safe_width - to_nearer;
        const mission_leg1_real a = upper_nearer ? to_farther : to_nearer;
        const mission_leg1_real b = upper_nearer ? to_nearer : to_farther;
        const mission_leg1_real e_i = mission_leg1_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const mission_leg1_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const mission_leg1_real e_limited = e_beyond ? 0.99F : e_raised;
        mission_leg1_real epsilon_nearer;
        mission_leg1_real xi_i;
        mission_leg1_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const mission_leg1_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const mission_leg1_real e_or_zero = empty ? 0.0F : e_limited;
        const mission_leg1_real e_out = finite ? e_or_zero : (mission_leg1_real)NAN;
        e[i] = e_out;
        const mission_leg1_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const mission_leg1_real epsilon_out = finite ? epsilon_or_zero : (mission_leg1_real)NAN;
        epsilon[i] = epsilon_out;
        const mission_leg1_real xi_or_zero = empty ? 0.0F : xi_i;
        const mission_leg1_real xi_out = finite ? xi_or_zero : (mission_leg1_real)NAN;
        xi[i] = xi_out;
    }
}
