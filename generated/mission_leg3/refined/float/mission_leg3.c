/* mission_leg3.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (mission_leg3.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "mission_leg3.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "mission_leg3.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "mission_leg3.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "mission_leg3.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "mission_leg3.c: float is not IEEE-754's here, for which rounding is bounded"
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
static const mission_leg3_real mission_leg3_coefficients[140] = {
    2.282875F, 2.449463F, 1.2843819F, 1.4509659F,
    2.333374F, 2.499958F, 1.333374F, 1.499958F,
    2.383873F, 2.550457F, 1.3823662F, 1.548954F,
    2.4343681F, 2.600956F, 1.4313622F, 1.5979462F,
    2.484867F, 2.651455F, 1.4803543F, 1.6469421F,
    2.535366F, 2.70195F, 1.5293503F, 1.6959343F,
    2.585865F, 2.752449F, 1.5783424F, 1.7449303F,
    2.6363602F, 2.802948F, 1.6273384F, 1.7939224F,
    2.6868591F, 2.853447F, 1.6763306F, 1.8429184F,
    2.737358F, 2.903942F, 1.7253265F, 1.8919106F,
    2.787857F, 2.954441F, 1.7743187F, 1.9409027F,
    2.8383522F, 3.00494F, 1.8283958F, 1.9949799F,
    2.8888512F, 3.0554352F, 1.8824692F, 2.0490532F,
    2.9393501F, 3.1059341F, 1.9365463F, 2.1031303F,
    2.9429207F, 3.1095047F, 1.9906197F, 2.1572037F,
    2.9464912F, 3.113079F, 2.044693F, 2.2112808F,
    2.9500618F, 3.1166496F, 2.0987701F, 2.2653542F,
    2.9536362F, 3.1202202F, 2.1528435F, 2.3194313F,
    2.9572067F, 3.1237907F, 2.2069206F, 2.3735046F,
    2.9607773F, 3.1273613F, 2.260994F, 2.4275818F,
    2.9643478F, 3.1309319F, 2.315071F, 2.4816551F,
    2.9679184F, 3.1345062F, 2.3691444F, 2.5357323F,
    2.9714928F, 3.1380768F, 2.4232216F, 2.5898056F,
    2.9750633F, 3.1416473F, 2.477295F, 2.643879F,
    2.9786339F, 3.145218F, 2.531372F, 2.697956F,
    2.9822044F, 3.1487885F, 2.5854454F, 2.7520294F,
    2.985775F, 3.1523628F, 2.6395226F, 2.8061066F,
    2.9893456F, 3.1559334F, 2.693596F, 2.86018F,
    2.99292F, 3.159504F, 2.7476692F, 2.914257F,
    2.9964905F, 3.1630745F, 2.8017464F, 2.9683304F,
    3.000061F, 3.166645F, 2.8558197F, 3.0224075F,
    3.000061F, 3.166645F, 2.9098969F, 3.0764809F,
    3.000061F, 3.166645F, 2.9639702F, 3.130558F,
    3.000061F, 3.166645F, 3.0180435F, 3.1846313F,
    3.000061F, 3.166645F, 2.9639702F, 3.130558F
};

/* Covered starts have x strictly above these bounds, by component. */
static const mission_leg3_real mission_leg3_start_lower[2] = {
    14.005244F, 8.005244F
};

/* Covered starts have x strictly below these bounds, by component. */
static const mission_leg3_real mission_leg3_start_upper[2] = {
    14.994752F, 8.994752F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 5 s).
 */
static inline void mission_leg3_segment(mission_leg3_real t, int32_t *row, mission_leg3_real *s)
{
    const bool positive = 0.0F < t;
    const mission_leg3_real started = positive ? t : 0.0F;
    const mission_leg3_real scaled = started * 6.4F;
    const bool early = scaled < 31.999998F;
    const mission_leg3_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const mission_leg3_real base = (mission_leg3_real)segment;
    const mission_leg3_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void mission_leg3_basis(mission_leg3_real s, mission_leg3_real *w0, mission_leg3_real *w1,
                                      mission_leg3_real *w2, mission_leg3_real *w3)
{
    const mission_leg3_real v0 = 1.0F - s;
    const mission_leg3_real v1 = v0 * v0;
    const mission_leg3_real v2 = v1 * v0;
    const mission_leg3_real v3 = v0 * s;
    const mission_leg3_real v4 = 1.0F + v3;
    const mission_leg3_real v5 = 3.0F * v4;
    const mission_leg3_real v6 = v0 * v5;
    const mission_leg3_real v7 = 1.0F + v6;
    const mission_leg3_real v8 = s * v5;
    const mission_leg3_real v9 = 1.0F + v8;
    const mission_leg3_real v10 = s * s;
    const mission_leg3_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void mission_leg3_basis_rate(mission_leg3_real s, mission_leg3_real *dw0, mission_leg3_real *dw1,
                                           mission_leg3_real *dw2, mission_leg3_real *dw3)
{
    const mission_leg3_real v0 = 1.0F - s;
    const mission_leg3_real v1 = v0 + v0;
    const mission_leg3_real v2 = v0 * v1;
    const mission_leg3_real v3 = v0 * v0;
    const mission_leg3_real v4 = v2 + v3;
    const mission_leg3_real v5 = -v4;
    const mission_leg3_real v6 = v0 - s;
    const mission_leg3_real v7 = 3.0F * v6;
    const mission_leg3_real v8 = v0 * v7;
    const mission_leg3_real v9 = v0 * s;
    const mission_leg3_real v10 = 1.0F + v9;
    const mission_leg3_real v11 = 3.0F * v10;
    const mission_leg3_real v12 = v8 - v11;
    const mission_leg3_real v13 = s * v7;
    const mission_leg3_real v14 = v11 + v13;
    const mission_leg3_real v15 = s + s;
    const mission_leg3_real v16 = s * v15;
    const mission_leg3_real v17 = s * s;
    const mission_leg3_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline mission_leg3_real mission_leg3_edge_at(int32_t at, mission_leg3_real w0, mission_leg3_real w1,
                                                     mission_leg3_real w2, mission_leg3_real w3)
{
    const mission_leg3_real q0 = mission_leg3_coefficients[at];
    const int32_t at_1 = at + 4;
    const mission_leg3_real q1 = mission_leg3_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const mission_leg3_real q2 = mission_leg3_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const mission_leg3_real q3 = mission_leg3_coefficients[at_3];
    const mission_leg3_real v0 = w0 * q0;
    const mission_leg3_real v1 = w1 * q1;
    const mission_leg3_real v2 = v0 + v1;
    const mission_leg3_real v3 = w2 * q2;
    const mission_leg3_real v4 = w3 * q3;
    const mission_leg3_real v5 = v3 + v4;
    const mission_leg3_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline mission_leg3_real mission_leg3_normalized_error(mission_leg3_real a, mission_leg3_real b,
                                                              mission_leg3_real width)
{
    const mission_leg3_real v0 = a - b;
    const mission_leg3_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void mission_leg3_transformed_error(mission_leg3_real a, mission_leg3_real b,
                                                  mission_leg3_real *epsilon, mission_leg3_real *xi)
{
    const mission_leg3_real v0 = b / a;
    const mission_leg3_real v1 = logf(v0);
    const mission_leg3_real v2 = -v1;
    const mission_leg3_real v3 = 1.0F + v0;
    const mission_leg3_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline mission_leg3_real mission_leg3_law(mission_leg3_real k, mission_leg3_real xi,
                                                 mission_leg3_real epsilon)
{
    const mission_leg3_real v0 = k * xi;
    const mission_leg3_real v1 = v0 * epsilon;
    const mission_leg3_real v2 = -v1;
    return v2;
}

void mission_leg3_tube(mission_leg3_real t, mission_leg3_real lower[MISSION_LEG3_N],
                       mission_leg3_real upper[MISSION_LEG3_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (mission_leg3_real)NAN;
            upper[j] = (mission_leg3_real)NAN;
        }
        return;
    }
    int32_t row;
    mission_leg3_real s;
    mission_leg3_segment(t, &row, &s);
    mission_leg3_real w0;
    mission_leg3_real w1;
    mission_leg3_real w2;
    mission_leg3_real w3;
    mission_leg3_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg3_real lower_edge = mission_leg3_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg3_real upper_edge = mission_leg3_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void mission_leg3_tube_rate(mission_leg3_real t, mission_leg3_real lower_rate[MISSION_LEG3_N],
                            mission_leg3_real upper_rate[MISSION_LEG3_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (mission_leg3_real)NAN;
            upper_rate[j] = (mission_leg3_real)NAN;
        }
        return;
    }
    int32_t row;
    mission_leg3_real s;
    mission_leg3_segment(t, &row, &s);
    mission_leg3_real dw0;
    mission_leg3_real dw1;
    mission_leg3_real dw2;
    mission_leg3_real dw3;
    mission_leg3_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 5.0F;
    const mission_leg3_real per_second = moving ? 6.4F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg3_real lower_slope = mission_leg3_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const mission_leg3_real lower_speed = lower_slope * per_second;
        const mission_leg3_real upper_slope = mission_leg3_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const mission_leg3_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

mission_leg3_status mission_leg3_control(mission_leg3_real t, const mission_leg3_real x[MISSION_LEG3_N],
                                         mission_leg3_real u[MISSION_LEG3_N])
{
    const mission_leg3_real t_zero = t * 0.0F;
    mission_leg3_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const mission_leg3_real x_j = x[j];
        const mission_leg3_real x_zero = x_j * 0.0F;
        const mission_leg3_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return MISSION_LEG3_BAD_INPUT;
    }
    int32_t row;
    mission_leg3_real s;
    mission_leg3_segment(t, &row, &s);
    mission_leg3_real w0;
    mission_leg3_real w1;
    mission_leg3_real w2;
    mission_leg3_real w3;
    mission_leg3_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg3_real lower_edge = mission_leg3_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg3_real upper_edge = mission_leg3_edge_at(upper_at, w0, w1, w2, w3);
        const mission_leg3_real x_i = x[i];
        const mission_leg3_real width = upper_edge - lower_edge;
        const mission_leg3_real to_lower = x_i - lower_edge;
        const mission_leg3_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const mission_leg3_real distance = upper_nearer ? to_upper : to_lower;
        const mission_leg3_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const mission_leg3_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const mission_leg3_real to_nearer = clear ? distance : smallest;
        const mission_leg3_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        mission_leg3_real epsilon;
        mission_leg3_real xi;
        mission_leg3_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const mission_leg3_real u_i = mission_leg3_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? MISSION_LEG3_OUTSIDE_TUBE : MISSION_LEG3_OK;
}

mission_leg3_real mission_leg3_margin(mission_leg3_real t, const mission_leg3_real x[MISSION_LEG3_N])
{
    const mission_leg3_real t_zero = t * 0.0F;
    mission_leg3_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const mission_leg3_real x_j = x[j];
        const mission_leg3_real x_zero = x_j * 0.0F;
        const mission_leg3_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (mission_leg3_real)NAN;
    }
    int32_t row;
    mission_leg3_real s;
    mission_leg3_segment(t, &row, &s);
    mission_leg3_real w0;
    mission_leg3_real w1;
    mission_leg3_real w2;
    mission_leg3_real w3;
    mission_leg3_basis(s, &w0, &w1, &w2, &w3);
    mission_leg3_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg3_real lower_edge = mission_leg3_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg3_real upper_edge = mission_leg3_edge_at(upper_at, w0, w1, w2, w3);
        const mission_leg3_real x_i = x[i];
        const mission_leg3_real width = upper_edge - lower_edge;
        const mission_leg3_real to_lower = x_i - lower_edge;
        const mission_leg3_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const mission_leg3_real x_distance = x_nearer ? to_upper : to_lower;
        const mission_leg3_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const mission_leg3_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const mission_leg3_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void mission_leg3_margins(mission_leg3_real t, const mission_leg3_real x[MISSION_LEG3_N],
                          mission_leg3_real margin[MISSION_LEG3_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (mission_leg3_real)NAN;
        }
        return;
    }
    int32_t row;
    mission_leg3_real s;
    mission_leg3_segment(t, &row, &s);
    mission_leg3_real w0;
    mission_leg3_real w1;
    mission_leg3_real w2;
    mission_leg3_real w3;
    mission_leg3_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg3_real lower_edge = mission_leg3_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg3_real upper_edge = mission_leg3_edge_at(upper_at, w0, w1, w2, w3);
        const mission_leg3_real x_i = x[i];
        const mission_leg3_real width = upper_edge - lower_edge;
        const mission_leg3_real to_lower = x_i - lower_edge;
        const mission_leg3_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const mission_leg3_real x_distance = x_nearer ? to_upper : to_lower;
        const mission_leg3_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const mission_leg3_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool mission_leg3_covered(const mission_leg3_real x[MISSION_LEG3_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const mission_leg3_real x_i = x[i];
        const mission_leg3_real x_lower = mission_leg3_start_lower[i];
        const mission_leg3_real x_upper = mission_leg3_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void mission_leg3_transform(const mission_leg3_real lower[MISSION_LEG3_N],
                            const mission_leg3_real upper[MISSION_LEG3_N],
                            const mission_leg3_real x[MISSION_LEG3_N], mission_leg3_real e[MISSION_LEG3_N],
                            mission_leg3_real epsilon[MISSION_LEG3_N], mission_leg3_real xi[MISSION_LEG3_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const mission_leg3_real lower_edge = lower[i];
        const mission_leg3_real upper_edge = upper[i];
        const mission_leg3_real x_i = x[i];
        const mission_leg3_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const mission_leg3_real safe_width = wide ? width : 9.536743e-7F;
        const mission_leg3_real to_lower = x_i - lower_edge;
        const mission_leg3_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const mission_leg3_real distance = upper_nearer ? to_upper : to_lower;
        const mission_leg3_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const mission_leg3_real smallest = safe_width * 0.005F;
        const mission_leg3_real widened = safe_width - width;
        const mission_leg3_real half = widened * 0.5F;
        const mission_leg3_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const mission_leg3_real to_nearer = clear ? safe_distance : smallest;
        const mission_leg3_real to_farther = safe_width - to_nearer;
        const mission_leg3_real a = upper_nearer ? to_farther : to_nearer;
        const mission_leg3_real b = upper_nearer ? to_nearer : to_farther;
        const mission_leg3_real e_i = mission_leg3_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const mission_leg3_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const mission_leg3_real e_limited = e_beyond ? 0.99F : e_raised;
        mission_leg3_real epsilon_nearer;
        mission_leg3_real xi_i;
        mission_leg3_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const mission_leg3_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const mission_leg3_real e_or_zero = empty ? 0.0F : e_limited;
        const mission_leg3_real e_out = finite ? e_or_zero : (mission_leg3_real)NAN;
        e[i] = e_out;
        const mission_leg3_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const mission_leg3_real epsilon_out = finite ? epsilon_or_zero : (mission_leg3_real)NAN;
        epsilon[i] = epsilon_out;
        const mission_leg3_real xi_or_zero = empty ? 0.0F : xi_i;
        const mission_leg3_real xi_out = finite ? xi_or_zero : (mission_leg3_real)NAN;
        xi[i] = xi_out;
    }
}
