/* mission_leg3.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "mission_leg3.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "mission_leg3.c: double is not IEEE-754's here, for which rounding is bounded"
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
    2.2828750610351562, 2.449462890625, 1.2843818664550781, 1.4509658813476562,
    2.3333740234375, 2.499958038330078, 1.3333740234375, 1.4999580383300781,
    2.3838729858398438, 2.550457000732422, 1.3823661804199219, 1.5489540100097656,
    2.434368133544922, 2.6009559631347656, 1.4313621520996094, 1.5979461669921875,
    2.4848670959472656, 2.6514549255371094, 1.4803543090820312, 1.646942138671875,
    2.5353660583496094, 2.7019500732421875, 1.5293502807617188, 1.6959342956542969,
    2.585865020751953, 2.7524490356445312, 1.5783424377441406, 1.7449302673339844,
    2.6363601684570312, 2.802947998046875, 1.6273384094238281, 1.7939224243164062,
    2.686859130859375, 2.8534469604492188, 1.67633056640625, 1.8429183959960938,
    2.7373580932617188, 2.903942108154297, 1.7253265380859375, 1.8919105529785156,
    2.7878570556640625, 2.9544410705566406, 1.7743186950683594, 1.9409027099609375,
    2.8383522033691406, 3.0049400329589844, 1.8283958435058594, 1.9949798583984375,
    2.8888511657714844, 3.0554351806640625, 1.8824691772460938, 2.049053192138672,
    2.939350128173828, 3.1059341430664062, 1.9365463256835938, 2.103130340576172,
    2.942920684814453, 3.1095046997070312, 1.9906196594238281, 2.1572036743164062,
    2.946491241455078, 3.113079071044922, 2.0446929931640625, 2.2112808227539062,
    2.950061798095703, 3.116649627685547, 2.0987701416015625, 2.2653541564941406,
    2.9536361694335938, 3.120220184326172, 2.152843475341797, 2.3194313049316406,
    2.9572067260742188, 3.123790740966797, 2.206920623779297, 2.373504638671875,
    2.9607772827148438, 3.127361297607422, 2.2609939575195312, 2.427581787109375,
    2.9643478393554688, 3.130931854248047, 2.3150711059570312, 2.4816551208496094,
    2.9679183959960938, 3.1345062255859375, 2.3691444396972656, 2.5357322692871094,
    2.9714927673339844, 3.1380767822265625, 2.4232215881347656, 2.5898056030273438,
    2.9750633239746094, 3.1416473388671875, 2.477294921875, 2.643878936767578,
    2.9786338806152344, 3.1452178955078125, 2.5313720703125, 2.697956085205078,
    2.9822044372558594, 3.1487884521484375, 2.5854454040527344, 2.7520294189453125,
    2.9857749938964844, 3.152362823486328, 2.6395225524902344, 2.8061065673828125,
    2.9893455505371094, 3.155933380126953, 2.6935958862304688, 2.860179901123047,
    2.992919921875, 3.159503936767578, 2.747669219970703, 2.914257049560547,
    2.996490478515625, 3.163074493408203, 2.801746368408203, 2.9683303833007812,
    3.00006103515625, 3.166645050048828, 2.8558197021484375, 3.0224075317382812,
    3.00006103515625, 3.166645050048828, 2.9098968505859375, 3.0764808654785156,
    3.00006103515625, 3.166645050048828, 2.963970184326172, 3.1305580139160156,
    3.00006103515625, 3.166645050048828, 3.0180435180664062, 3.18463134765625,
    3.00006103515625, 3.166645050048828, 2.963970184326172, 3.1305580139160156
};

/* Covered starts have x strictly above these bounds, by component. */
static const mission_leg3_real mission_leg3_start_lower[2] = {
    14.00524168014527, 8.00524168014527
};

/* Covered starts have x strictly below these bounds, by component. */
static const mission_leg3_real mission_leg3_start_upper[2] = {
    14.994754505157465, 8.994754505157465
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 5 s).
 */
static inline void mission_leg3_segment(mission_leg3_real t, int32_t *row, mission_leg3_real *s)
{
    const bool positive = 0.0 < t;
    const mission_leg3_real started = positive ? t : 0.0;
    const mission_leg3_real scaled = started * 6.4;
    const bool early = scaled < 31.999999999999996;
    const mission_leg3_real u = early ? scaled : 31.999999999999996;
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
    const mission_leg3_real v0 = 1.0 - s;
    const mission_leg3_real v1 = v0 * v0;
    const mission_leg3_real v2 = v1 * v0;
    const mission_leg3_real v3 = v0 * s;
    const mission_leg3_real v4 = 1.0 + v3;
    const mission_leg3_real v5 = 3.0 * v4;
    const mission_leg3_real v6 = v0 * v5;
    const mission_leg3_real v7 = 1.0 + v6;
    const mission_leg3_real v8 = s * v5;
    const mission_leg3_real v9 = 1.0 + v8;
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
    const mission_leg3_real v0 = 1.0 - s;
    const mission_leg3_real v1 = v0 + v0;
    const mission_leg3_real v2 = v0 * v1;
    const mission_leg3_real v3 = v0 * v0;
    const mission_leg3_real v4 = v2 + v3;
    const mission_leg3_real v5 = -v4;
    const mission_leg3_real v6 = v0 - s;
    const mission_leg3_real v7 = 3.0 * v6;
    const mission_leg3_real v8 = v0 * v7;
    const mission_leg3_real v9 = v0 * s;
    const mission_leg3_real v10 = 1.0 + v9;
    const mission_leg3_real v11 = 3.0 * v10;
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
    const mission_leg3_real v1 = log(v0);
    const mission_leg3_real v2 = -v1;
    const mission_leg3_real v3 = 1.0 + v0;
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
    const bool moving = t < 5.0;
    const mission_leg3_real per_second = moving ? 6.4 : 0.0;
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
    const mission_leg3_real t_zero = t * 0.0;
    mission_leg3_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const mission_leg3_real x_j = x[j];
        const mission_leg3_real x_zero = x_j * 0.0;
        const mission_leg3_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
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
        const mission_leg3_real gain = upper_nearer ? (-0.5) : 0.5;
        const mission_leg3_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const mission_leg3_real to_nearer = clear ? distance : smallest;
        const mission_leg3_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
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
    const mission_leg3_real t_zero = t * 0.0;
    mission_leg3_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const mission_leg3_real x_j = x[j];
        const mission_leg3_real x_zero = x_j * 0.0;
        const mission_leg3_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
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
    mission_leg3_real margin = 0.5;
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
        const bool x_beyond = x_share < (-1.0);
        const mission_leg3_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool x_beyond = x_share < (-1.0);
        const mission_leg3_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const mission_leg3_real safe_width = wide ? width : 9.5367431640625e-7;
        const mission_leg3_real to_lower = x_i - lower_edge;
        const mission_leg3_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const mission_leg3_real distance = upper_nearer ? to_upper : to_lower;
        const mission_leg3_real sign = upper_nearer ? (-1.0) : 1.0;
        const mission_leg3_real smallest = safe_width * 0.005;
        const mission_leg3_real widened = safe_width - width;
        const mission_leg3_real half = widened * 0.5;
        const mission_leg3_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const mission_leg3_real to_nearer = clear ? safe_distance : smallest;
        const mission_leg3_real to_farther = safe_width - to_nearer;
        const mission_leg3_real a = upper_nearer ? to_farther : to_nearer;
        const mission_leg3_real b = upper_nearer ? to_nearer : to_farther;
        const mission_leg3_real e_i = mission_leg3_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const mission_leg3_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const mission_leg3_real e_limited = e_beyond ? 0.99 : e_raised;
        mission_leg3_real epsilon_nearer;
        mission_leg3_real xi_i;
        mission_leg3_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const mission_leg3_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const mission_leg3_real e_or_zero = empty ? 0.0 : e_limited;
        const mission_leg3_real e_out = finite ? e_or_zero : (mission_leg3_real)NAN;
        e[i] = e_out;
        const mission_leg3_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const mission_leg3_real epsilon_out = finite ? epsilon_or_zero : (mission_leg3_real)NAN;
        epsilon[i] = epsilon_out;
        const mission_leg3_real xi_or_zero = empty ? 0.0 : xi_i;
        const mission_leg3_real xi_out = finite ? xi_or_zero : (mission_leg3_real)NAN;
        xi[i] = xi_out;
    }
}
