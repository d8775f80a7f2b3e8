/* mission_leg2.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (mission_leg2.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "mission_leg2.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "mission_leg2.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "mission_leg2.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "mission_leg2.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "mission_leg2.c: double is not IEEE-754's here, for which rounding is bounded"
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
static const mission_leg2_real mission_leg2_coefficients[140] = {
    1.3017425537109375, 1.4686279296875, 2.364704132080078, 2.5315895080566406,
    1.3333740234375, 1.4999580383300781, 2.3333740234375, 2.499958038330078,
    1.3650054931640625, 1.5312919616699219, 2.302043914794922, 2.4683265686035156,
    1.396636962890625, 1.5626220703125, 2.270709991455078, 2.4366989135742188,
    1.4282684326171875, 1.5939559936523438, 2.2393798828125, 2.4050674438476562,
    1.4598960876464844, 1.6252861022949219, 2.2080459594726562, 2.3734359741210938,
    1.4915275573730469, 1.6566162109375, 2.176715850830078, 2.3418045043945312,
    1.5231590270996094, 1.6879501342773438, 2.1453857421875, 2.3101730346679688,
    1.5547904968261719, 1.7192802429199219, 2.1140518188476562, 2.2785415649414062,
    1.5864219665527344, 1.7506141662597656, 2.082721710205078, 2.2469100952148438,
    1.6180534362792969, 1.7819442749023438, 2.0513877868652344, 2.2152786254882812,
    1.6496849060058594, 1.8132743835449219, 2.0200576782226562, 2.1836509704589844,
    1.6813163757324219, 1.8446083068847656, 1.9887275695800781, 2.152019500732422,
    1.7129440307617188, 1.8762397766113281, 1.9570960998535156, 2.1203880310058594,
    1.7445755004882812, 1.9078712463378906, 1.9254646301269531, 2.088756561279297,
    1.7762069702148438, 1.9394989013671875, 1.8938331604003906, 2.0571250915527344,
    1.8078384399414062, 1.97113037109375, 1.8622016906738281, 2.025493621826172,
    1.8394699096679688, 2.0027618408203125, 1.8305702209472656, 1.9938621520996094,
    1.8711013793945312, 2.034393310546875, 1.7989387512207031, 1.9622306823730469,
    1.9027328491210938, 2.0660247802734375, 1.7673072814941406, 1.93060302734375,
    1.9343643188476562, 2.09765625, 1.7356796264648438, 1.8989715576171875,
    1.9659919738769531, 2.1292877197265625, 1.7040481567382812, 1.867340087890625,
    1.9976234436035156, 2.160919189453125, 1.6724166870117188, 1.8357086181640625,
    2.029254913330078, 2.192546844482422, 1.6407852172851562, 1.8040771484375,
    2.0608863830566406, 2.2241783142089844, 1.6091537475585938, 1.7724456787109375,
    2.092517852783203, 2.255809783935547, 1.5775222778320312, 1.740814208984375,
    2.1241493225097656, 2.2874412536621094, 1.5458908081054688, 1.7091827392578125,
    2.155780792236328, 2.319072723388672, 1.5142593383789062, 1.6775550842285156,
    2.1874122619628906, 2.3507041931152344, 1.4826316833496094, 1.6459236145019531,
    2.2190399169921875, 2.382335662841797, 1.4510002136230469, 1.6142921447753906,
    2.25067138671875, 2.4139671325683594, 1.4193687438964844, 1.5826606750488281,
    2.2823028564453125, 2.4455947875976562, 1.3877372741699219, 1.5510292053222656,
    2.313934326171875, 2.4772262573242188, 1.3561058044433594, 1.5193977355957031,
    2.345561981201172, 2.5088539123535156, 1.3244781494140625, 1.4877700805664062,
    2.313934326171875, 2.4772262573242188, 1.3561058044433594, 1.5193977355957031
};

/* Covered starts have x strictly above these bounds, by component. */
static const mission_leg2_real mission_leg2_start_lower[2] = {
    8.00524168014527, 14.005241661071782
};

/* Covered starts have x strictly below these bounds, by component. */
static const mission_leg2_real mission_leg2_start_upper[2] = {
    8.994754505157465, 14.994750709533687
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 3 s).
 */
static inline void mission_leg2_segment(mission_leg2_real t, int32_t *row, mission_leg2_real *s)
{
    const bool positive = 0.0 < t;
    const mission_leg2_real started = positive ? t : 0.0;
    const mission_leg2_real scaled = started * 10.666666666666666;
    const bool early = scaled < 31.999999999999996;
    const mission_leg2_real u = early ? scaled : 31.999999999999996;
    const int32_t segment = (int32_t)u;
    const mission_leg2_real base = (mission_leg2_real)segment;
    const mission_leg2_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void mission_leg2_basis(mission_leg2_real s, mission_leg2_real *w0, mission_leg2_real *w1,
                                      mission_leg2_real *w2, mission_leg2_real *w3)
{
    const mission_leg2_real v0 = 1.0 - s;
    const mission_leg2_real v1 = v0 * v0;
    const mission_leg2_real v2 = v1 * v0;
    const mission_leg2_real v3 = v0 * s;
    const mission_leg2_real v4 = 1.0 + v3;
    const mission_leg2_real v5 = 3.0 * v4;
    const mission_leg2_real v6 = v0 * v5;
    const mission_leg2_real v7 = 1.0 + v6;
    const mission_leg2_real v8 = s * v5;
    const mission_leg2_real v9 = 1.0 + v8;
    const mission_leg2_real v10 = s * s;
    const mission_leg2_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void mission_leg2_basis_rate(mission_leg2_real s, mission_leg2_real *dw0, mission_leg2_real *dw1,
                                           mission_leg2_real *dw2, mission_leg2_real *dw3)
{
    const mission_leg2_real v0 = 1.0 - s;
    const mission_leg2_real v1 = v0 + v0;
    const mission_leg2_real v2 = v0 * v1;
    const mission_leg2_real v3 = v0 * v0;
    const mission_leg2_real v4 = v2 + v3;
    const mission_leg2_real v5 = -v4;
    const mission_leg2_real v6 = v0 - s;
    const mission_leg2_real v7 = 3.0 * v6;
    const mission_leg2_real v8 = v0 * v7;
    const mission_leg2_real v9 = v0 * s;
    const mission_leg2_real v10 = 1.0 + v9;
    const mission_leg2_real v11 = 3.0 * v10;
    const mission_leg2_real v12 = v8 - v11;
    const mission_leg2_real v13 = s * v7;
    const mission_leg2_real v14 = v11 + v13;
    const mission_leg2_real v15 = s + s;
    const mission_leg2_real v16 = s * v15;
    const mission_leg2_real v17 = s * s;
    const mission_leg2_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline mission_leg2_real mission_leg2_edge_at(int32_t at, mission_leg2_real w0, mission_leg2_real w1,
                                                     mission_leg2_real w2, mission_leg2_real w3)
{
    const mission_leg2_real q0 = mission_leg2_coefficients[at];
    const int32_t at_1 = at + 4;
    const mission_leg2_real q1 = mission_leg2_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const mission_leg2_real q2 = mission_leg2_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const mission_leg2_real q3 = mission_leg2_coefficients[at_3];
    const mission_leg2_real v0 = w0 * q0;
    const mission_leg2_real v1 = w1 * q1;
    const mission_leg2_real v2 = v0 + v1;
    const mission_leg2_real v3 = w2 * q2;
    const mission_leg2_real v4 = w3 * q3;
    const mission_leg2_real v5 = v3 + v4;
    const mission_leg2_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline mission_leg2_real mission_leg2_normalized_error(mission_leg2_real a, mission_leg2_real b,
                                                              mission_leg2_real width)
{
    const mission_leg2_real v0 = a - b;
    const mission_leg2_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void mission_leg2_transformed_error(mission_leg2_real a, mission_leg2_real b,
                                                  mission_leg2_real *epsilon, mission_leg2_real *xi)
{
    const mission_leg2_real v0 = b / a;
    const mission_leg2_real v1 = log(v0);
    const mission_leg2_real v2 = -v1;
    const mission_leg2_real v3 = 1.0 + v0;
    const mission_leg2_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline mission_leg2_real mission_leg2_law(mission_leg2_real k, mission_leg2_real xi,
                                                 mission_leg2_real epsilon)
{
    const mission_leg2_real v0 = k * xi;
    const mission_leg2_real v1 = v0 * epsilon;
    const mission_leg2_real v2 = -v1;
    return v2;
}

void mission_leg2_tube(mission_leg2_real t, mission_leg2_real lower[MISSION_LEG2_N],
                       mission_leg2_real upper[MISSION_LEG2_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (mission_leg2_real)NAN;
            upper[j] = (mission_leg2_real)NAN;
        }
        return;
    }
    int32_t row;
    mission_leg2_real s;
    mission_leg2_segment(t, &row, &s);
    mission_leg2_real w0;
    mission_leg2_real w1;
    mission_leg2_real w2;
    mission_leg2_real w3;
    mission_leg2_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg2_real lower_edge = mission_leg2_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg2_real upper_edge = mission_leg2_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void mission_leg2_tube_rate(mission_leg2_real t, mission_leg2_real lower_rate[MISSION_LEG2_N],
                            mission_leg2_real upper_rate[MISSION_LEG2_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (mission_leg2_real)NAN;
            upper_rate[j] = (mission_leg2_real)NAN;
        }
        return;
    }
    int32_t row;
    mission_leg2_real s;
    mission_leg2_segment(t, &row, &s);
    mission_leg2_real dw0;
    mission_leg2_real dw1;
    mission_leg2_real dw2;
    mission_leg2_real dw3;
    mission_leg2_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 3.0;
    const mission_leg2_real per_second = moving ? 10.666666666666666 : 0.0;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg2_real lower_slope = mission_leg2_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const mission_leg2_real lower_speed = lower_slope * per_second;
        const mission_leg2_real upper_slope = mission_leg2_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const mission_leg2_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

mission_leg2_status mission_leg2_control(mission_leg2_real t, const mission_leg2_real x[MISSION_LEG2_N],
                                         mission_leg2_real u[MISSION_LEG2_N])
{
    const mission_leg2_real t_zero = t * 0.0;
    mission_leg2_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const mission_leg2_real x_j = x[j];
        const mission_leg2_real x_zero = x_j * 0.0;
        const mission_leg2_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
        }
        return MISSION_LEG2_BAD_INPUT;
    }
    int32_t row;
    mission_leg2_real s;
    mission_leg2_segment(t, &row, &s);
    mission_leg2_real w0;
    mission_leg2_real w1;
    mission_leg2_real w2;
    mission_leg2_real w3;
    mission_leg2_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg2_real lower_edge = mission_leg2_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg2_real upper_edge = mission_leg2_edge_at(upper_at, w0, w1, w2, w3);
        const mission_leg2_real x_i = x[i];
        const mission_leg2_real width = upper_edge - lower_edge;
        const mission_leg2_real to_lower = x_i - lower_edge;
        const mission_leg2_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const mission_leg2_real distance = upper_nearer ? to_upper : to_lower;
        const mission_leg2_real gain = upper_nearer ? (-0.5) : 0.5;
        const mission_leg2_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const mission_leg2_real to_nearer = clear ? distance : smallest;
        const mission_leg2_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
        const bool outside_next = inside ? outside : true;
        mission_leg2_real epsilon;
        mission_leg2_real xi;
        mission_leg2_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const mission_leg2_real u_i = mission_leg2_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? MISSION_LEG2_OUTSIDE_TUBE : MISSION_LEG2_OK;
}

mission_leg2_real mission_leg2_margin(mission_leg2_real t, const mission_leg2_real x[MISSION_LEG2_N])
{
    const mission_leg2_real t_zero = t * 0.0;
    mission_leg2_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const mission_leg2_real x_j = x[j];
        const mission_leg2_real x_zero = x_j * 0.0;
        const mission_leg2_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        return (mission_leg2_real)NAN;
    }
    int32_t row;
    mission_leg2_real s;
    mission_leg2_segment(t, &row, &s);
    mission_leg2_real w0;
    mission_leg2_real w1;
    mission_leg2_real w2;
    mission_leg2_real w3;
    mission_leg2_basis(s, &w0, &w1, &w2, &w3);
    mission_leg2_real margin = 0.5;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg2_real lower_edge = mission_leg2_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg2_real upper_edge = mission_leg2_edge_at(upper_at, w0, w1, w2, w3);
        const mission_leg2_real x_i = x[i];
        const mission_leg2_real width = upper_edge - lower_edge;
        const mission_leg2_real to_lower = x_i - lower_edge;
        const mission_leg2_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const mission_leg2_real x_distance = x_nearer ? to_upper : to_lower;
        const mission_leg2_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const mission_leg2_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool less = margin_x < margin;
        const mission_leg2_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void mission_leg2_margins(mission_leg2_real t, const mission_leg2_real x[MISSION_LEG2_N],
                          mission_leg2_real margin[MISSION_LEG2_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (mission_leg2_real)NAN;
        }
        return;
    }
    int32_t row;
    mission_leg2_real s;
    mission_leg2_segment(t, &row, &s);
    mission_leg2_real w0;
    mission_leg2_real w1;
    mission_leg2_real w2;
    mission_leg2_real w3;
    mission_leg2_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const mission_leg2_real lower_edge = mission_leg2_edge_at(lower_at, w0, w1, w2, w3);
        const mission_leg2_real upper_edge = mission_leg2_edge_at(upper_at, w0, w1, w2, w3);
        const mission_leg2_real x_i = x[i];
        const mission_leg2_real width = upper_edge - lower_edge;
        const mission_leg2_real to_lower = x_i - lower_edge;
        const mission_leg2_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const mission_leg2_real x_distance = x_nearer ? to_upper : to_lower;
        const mission_leg2_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const mission_leg2_real margin_x = x_beyond ? (-1.0) : x_share;
        margin[i] = margin_x;
    }
}

bool mission_leg2_covered(const mission_leg2_real x[MISSION_LEG2_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const mission_leg2_real x_i = x[i];
        const mission_leg2_real x_lower = mission_leg2_start_lower[i];
        const mission_leg2_real x_upper = mission_leg2_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void mission_leg2_transform(const mission_leg2_real lower[MISSION_LEG2_N],
                            const mission_leg2_real upper[MISSION_LEG2_N],
                            const mission_leg2_real x[MISSION_LEG2_N], mission_leg2_real e[MISSION_LEG2_N],
                            mission_leg2_real epsilon[MISSION_LEG2_N], mission_leg2_real xi[MISSION_LEG2_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const mission_leg2_real lower_edge = lower[i];
        const mission_leg2_real upper_edge = upper[i];
        const mission_leg2_real x_i = x[i];
        const mission_leg2_real width = upper_edge - lower_edge;
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const mission_leg2_real safe_width = wide ? width : 9.5367431640625e-7;
        const mission_leg2_real to_lower = x_i - lower_edge;
        const mission_leg2_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const mission_leg2_real distance = upper_nearer ? to_upper : to_lower;
        const mission_leg2_real sign = upper_nearer ? (-1.0) : 1.0;
        const mission_leg2_real smallest = safe_width * 0.005;
        const mission_leg2_real widened = safe_width - width;
        const mission_leg2_real half = widened * 0.5;
        const mission_leg2_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const mission_leg2_real to_nearer = clear ? safe_distance : smallest;
        const mission_leg2_real to_farther = safe_width - to_nearer;
        const mission_leg2_real a = upper_nearer ? to_farther : to_nearer;
        const mission_leg2_real b = upper_nearer ? to_nearer : to_farther;
        const mission_leg2_real e_i = mission_leg2_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const mission_leg2_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const mission_leg2_real e_limited = e_beyond ? 0.99 : e_raised;
        mission_leg2_real epsilon_nearer;
        mission_leg2_real xi_i;
        mission_leg2_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const mission_leg2_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const mission_leg2_real e_or_zero = empty ? 0.0 : e_limited;
        const mission_leg2_real e_out = finite ? e_or_zero : (mission_leg2_real)NAN;
        e[i] = e_out;
        const mission_leg2_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const mission_leg2_real epsilon_out = finite ? epsilon_or_zero : (mission_leg2_real)NAN;
        epsilon[i] = epsilon_out;
        const mission_leg2_real xi_or_zero = empty ? 0.0 : xi_i;
        const mission_leg2_real xi_out = finite ? xi_or_zero : (mission_leg2_real)NAN;
        xi[i] = xi_out;
    }
}
