/* mission_leg1.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "mission_leg1.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "mission_leg1.c: double is not IEEE-754's here, for which rounding is bounded"
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
    0.6162109375, 0.7830924987792969, 0.617340087890625, 0.7842903137207031,
    0.6667060852050781, 0.8332939147949219, 0.6667060852050781, 0.8332939147949219,
    0.7172050476074219, 0.8834915161132812, 0.7160758972167969, 0.882293701171875,
    0.7677040100097656, 0.9336891174316406, 0.76544189453125, 0.9312973022460938,
    0.8182029724121094, 0.98388671875, 0.8148117065429688, 0.9803009033203125,
    0.8686981201171875, 1.034088134765625, 0.8641815185546875, 1.0293006896972656,
    0.9191970825195312, 1.0842857360839844, 0.9135475158691406, 1.0783042907714844,
    0.969696044921875, 1.1344833374023438, 0.9629173278808594, 1.1273078918457031,
    1.0201950073242188, 1.1846847534179688, 1.0122833251953125, 1.1763076782226562,
    1.0706901550292969, 1.2348823547363281, 1.0616531372070312, 1.225311279296875,
    1.1211891174316406, 1.2850799560546875, 1.1110191345214844, 1.2743110656738281,
    1.1716880798339844, 1.3352775573730469, 1.1650199890136719, 1.3283119201660156,
    1.2221832275390625, 1.3854789733886719, 1.2190208435058594, 1.3823127746582031,
    1.2723846435546875, 1.4356765747070312, 1.2730216979980469, 1.4363136291503906,
    1.2760696411132812, 1.439361572265625, 1.3270187377929688, 1.4903144836425781,
    1.2797508239746094, 1.4430465698242188, 1.3810195922851562, 1.5443115234375,
    1.2834358215332031, 1.4467315673828125, 1.4350204467773438, 1.5983123779296875,
    1.2871208190917969, 1.4504127502441406, 1.4890213012695312, 1.652313232421875,
    1.2908058166503906, 1.4540977478027344, 1.5430221557617188, 1.7063140869140625,
    1.2944908142089844, 1.4577827453613281, 1.5970191955566406, 1.76031494140625,
    1.2981758117675781, 1.4614677429199219, 1.6510200500488281, 1.8143119812011719,
    1.3018608093261719, 1.4651527404785156, 1.7050209045410156, 1.8683128356933594,
    1.3055458068847656, 1.4688377380371094, 1.7590217590332031, 1.9223136901855469,
    1.3092269897460938, 1.4725227355957031, 1.8130226135253906, 1.9763145446777344,
    1.3129119873046875, 1.4762077331542969, 1.8670196533203125, 2.030315399169922,
    1.3165969848632812, 1.479888916015625, 1.9210205078125, 2.0843124389648438,
    1.320281982421875, 1.4835739135742188, 1.9750213623046875, 2.1383132934570312,
    1.3239669799804688, 1.4872589111328125, 2.029022216796875, 2.1923141479492188,
    1.3276519775390625, 1.4909439086914062, 2.0830230712890625, 2.2463150024414062,
    1.3313369750976562, 1.49462890625, 2.1370201110839844, 2.300312042236328,
    1.33502197265625, 1.4983139038085938, 2.191020965576172, 2.3543128967285156,
    1.33502197265625, 1.4983139038085938, 2.2450218200683594, 2.408313751220703,
    1.33502197265625, 1.4983139038085938, 2.299022674560547, 2.4623146057128906,
    1.33502197265625, 1.4983139038085938, 2.3530197143554688, 2.5163116455078125,
    1.33502197265625, 1.4983139038085938, 2.299022674560547, 2.4623146057128906
};

/* Covered starts have x strictly above these bounds, by component. */
static const mission_leg1_real mission_leg1_start_lower[2] = {
    4.005237922668462, 4.005237922668462
};

/* Covered starts have x strictly below these bounds, by component. */
static const mission_leg1_real mission_leg1_start_upper[2] = {
    4.994762077331538, 4.994762077331538
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 9.5 s).
 */
static inline void mission_leg1_segment(mission_leg1_real t, int32_t *row, mission_leg1_real *s)
{
    const bool positive = 0.0 < t;
    const mission_leg1_real started = positive ? t : 0.0;
    const mission_leg1_real scaled = started * 3.3684210526315788;
    const bool early = scaled < 31.999999999999996;
    const mission_leg1_real u = early ? scaled : 31.999999999999996;
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
    const mission_leg1_real v0 = 1.0 - s;
    const mission_leg1_real v1 = v0 * v0;
    const mission_leg1_real v2 = v1 * v0;
    const mission_leg1_real v3 = v0 * s;
    const mission_leg1_real v4 = 1.0 + v3;
    const mission_leg1_real v5 = 3.0 * v4;
    const mission_leg1_real v6 = v0 * v5;
    const mission_leg1_real v7 = 1.0 + v6;
    const mission_leg1_real v8 = s * v5;
    const mission_leg1_real v9 = 1.0 + v8;
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
    const mission_leg1_real v0 = 1.0 - s;
    const mission_leg1_real v1 = v0 + v0;
    const mission_leg1_real v2 = v0 * v1;
    const mission_leg1_real v3 = v0 * v0;
    const mission_leg1_real v4 = v2 + v3;
    const mission_leg1_real v5 = -v4;
    const mission_leg1_real v6 = v0 - s;
    const mission_leg1_real v7 = 3.0 * v6;
    const mission_leg1_real v8 = v0 * v7;
    const mission_leg1_real v9 = v0 * s;
    const mission_leg1_real v10 = 1.0 + v9;
    const mission_leg1_real v11 = 3.0 * v10;
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
    const mission_leg1_real v1 = log(v0);
    const mission_leg1_real v2 = -v1;
    const mission_leg1_real v3 = 1.0 + v0;
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
    const bool moving = t < 9.5;
    const mission_leg1_real per_second = moving ? 3.3684210526315788 : 0.0;
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
    const mission_leg1_real t_zero = t * 0.0;
    mission_leg1_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const mission_leg1_real x_j = x[j];
        const mission_leg1_real x_zero = x_j * 0.0;
        const mission_leg1_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
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
        const mission_leg1_real gain = upper_nearer ? (-0.5) : 0.5;
        const mission_leg1_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const mission_leg1_real to_nearer = clear ? distance : smallest;
        const mission_leg1_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
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
    const mission_leg1_real t_zero = t * 0.0;
    mission_leg1_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const mission_leg1_real x_j = x[j];
        const mission_leg1_real x_zero = x_j * 0.0;
        const mission_leg1_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
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
    mission_leg1_real margin = 0.5;
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
        const bool x_beyond = x_share < (-1.0);
        const mission_leg1_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool x_beyond = x_share < (-1.0);
        const mission_leg1_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const mission_leg1_real safe_width = wide ? width : 9.5367431640625e-7;
        const mission_leg1_real to_lower = x_i - lower_edge;
        const mission_leg1_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const mission_leg1_real distance = upper_nearer ? to_upper : to_lower;
        const mission_leg1_real sign = upper_nearer ? (-1.0) : 1.0;
        const mission_leg1_real smallest = safe_width * 0.005;
        const mission_leg1_real widened = safe_width - width;
        const mission_leg1_real half = widened * 0.5;
        const mission_leg1_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const mission_leg1_real to_nearer = clear ? safe_distance : smallest;
        const mission_leg1_real to_farther = safe_width - to_nearer;
        const mission_leg1_real a = upper_nearer ? to_farther : to_nearer;
        const mission_leg1_real b = upper_nearer ? to_nearer : to_farther;
        const mission_leg1_real e_i = mission_leg1_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const mission_leg1_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const mission_leg1_real e_limited = e_beyond ? 0.99 : e_raised;
        mission_leg1_real epsilon_nearer;
        mission_leg1_real xi_i;
        mission_leg1_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const mission_leg1_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const mission_leg1_real e_or_zero = empty ? 0.0 : e_limited;
        const mission_leg1_real e_out = finite ? e_or_zero : (mission_leg1_real)NAN;
        e[i] = e_out;
        const mission_leg1_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const mission_leg1_real epsilon_out = finite ? epsilon_or_zero : (mission_leg1_real)NAN;
        epsilon[i] = epsilon_out;
        const mission_leg1_real xi_or_zero = empty ? 0.0 : xi_i;
        const mission_leg1_real xi_out = finite ? xi_or_zero : (mission_leg1_real)NAN;
        xi[i] = xi_out;
    }
}
