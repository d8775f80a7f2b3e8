/* watchman.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (watchman.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and repeats itself for ever.
 * Every x(t) that stays in the tube satisfies the mission (P10): (always eventually[0, 14] gate and always
 * eventually[0, 14] office and always eventually[0, 14] store and always not lab); times are seconds of t, not turned
 * back. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.125 s.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "watchman.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "watchman.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "watchman.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "watchman.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "watchman.c: double is not IEEE-754's here, for which rounding is bounded"
#endif
/* No fused multiply-adds: Arduino's and other -std=gnu.. compilers would make them. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#pragma clang fp reassociate(off)
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#endif

/* B-spline control points divided by 6, one row for each of 64 + 3 points:
 * lower[0], upper[0], lower[1], upper[1]
 * Multiples of 2^-20: exact in float and double.
 */
static const watchman_real watchman_coefficients[268] = {
    0.0014467239379882812, 0.10142707824707031, 0.026207923889160156, 0.12618732452392578,
    0.03334331512451172, 0.13332271575927734, 0.03334331512451172, 0.13332271575927734,
    0.06523990631103516, 0.16521930694580078, 0.04047870635986328, 0.1404590606689453,
    0.0971364974975586, 0.19711589813232422, 0.04761505126953125, 0.14759445190429688,
    0.12903308868408203, 0.22901248931884766, 0.05475044250488281, 0.15472984313964844,
    0.16092967987060547, 0.2609090805053711, 0.061885833740234375, 0.161865234375,
    0.1928262710571289, 0.29280567169189453, 0.06902122497558594, 0.16900062561035156,
    0.22472286224365234, 0.32470226287841797, 0.0761566162109375, 0.17613697052001953,
    0.2566194534301758, 0.3565988540649414, 0.08329200744628906, 0.1832723617553711,
    0.24215221405029297, 0.3421316146850586, 0.09042835235595703, 0.19040775299072266,
    0.22768497467041016, 0.3276653289794922, 0.12508678436279297, 0.225067138671875,
    0.21321868896484375, 0.3131980895996094, 0.16397762298583984, 0.26395702362060547,
    0.19875144958496094, 0.29873085021972656, 0.20286846160888672, 0.30284786224365234,
    0.18428421020507812, 0.28426456451416016, 0.2417593002319336, 0.3417387008666992,
    0.16981792449951172, 0.26979732513427734, 0.28065013885498047, 0.3806295394897461,
    0.1553506851196289, 0.25533008575439453, 0.31954097747802734, 0.41952037811279297,
    0.1408834457397461, 0.24086284637451172, 0.3584308624267578, 0.45841121673583984,
    0.12641620635986328, 0.2263965606689453, 0.3973217010498047, 0.4973020553588867,
    0.11194992065429688, 0.2119293212890625, 0.43621253967285156, 0.5361919403076172,
    0.09748268127441406, 0.1974620819091797, 0.47510337829589844, 0.5750827789306641,
    0.0917062759399414, 0.19168567657470703, 0.4699087142944336, 0.5698881149291992,
    0.12927913665771484, 0.22925853729248047, 0.46471309661865234, 0.5646934509277344,
    0.16685199737548828, 0.2668313980102539, 0.4595184326171875, 0.5594978332519531,
    0.2044239044189453, 0.30440425872802734, 0.45432376861572266, 0.5543031692504883,
    0.24199676513671875, 0.3419761657714844, 0.4491281509399414, 0.5491085052490234,
    0.2795696258544922, 0.3795490264892578, 0.44393348693847656, 0.5439128875732422,
    0.3171424865722656, 0.41712188720703125, 0.4387388229370117, 0.5387182235717773,
    0.35471439361572266, 0.4546947479248047, 0.43354320526123047, 0.5335235595703125,
    0.3922872543334961, 0.4922666549682617, 0.4283485412597656, 0.5283279418945312,
    0.42986011505126953, 0.5298395156860352, 0.4231538772583008, 0.5231332778930664,
    0.46743202209472656, 0.5674123764038086, 0.4209127426147461, 0.5208921432495117,
    0.5050048828125, 0.6049842834472656, 0.4283485412597656, 0.5283279418945312,
    0.5425777435302734, 0.6425571441650391, 0.43578433990478516, 0.5357646942138672,
    0.5801506042480469, 0.6801300048828125, 0.4432210922241211, 0.5432004928588867,
    0.6177225112915039, 0.7177028656005859, 0.4506568908691406, 0.5506362915039062,
    0.6552953720092773, 0.755274772644043, 0.45809268951416016, 0.5580730438232422,
    0.6876935958862305, 0.7876729965209961, 0.4655294418334961, 0.5655088424682617,
    0.7200908660888672, 0.8200702667236328, 0.4729652404785156, 0.5729446411132812,
    0.7524890899658203, 0.8524684906005859, 0.48040103912353516, 0.5803813934326172,
    0.784886360168457, 0.8848657608032227, 0.4878377914428711, 0.5878171920776367,
    0.8172836303710938, 0.9172639846801758, 0.4489479064941406, 0.5489273071289062,
    0.8460378646850586, 0.9460182189941406, 0.41005706787109375, 0.5100364685058594,
    0.8747920989990234, 0.9747724533081055, 0.3711662292480469, 0.4711456298828125,
    0.9035463333129883, 1.0035266876220703, 0.332275390625, 0.4322547912597656,
    0.8929519653320312, 0.9929323196411133, 0.2933845520019531, 0.39336395263671875,
    0.8823575973510742, 0.9823369979858398, 0.25449371337890625, 0.3544740676879883,
    0.8717632293701172, 0.9717426300048828, 0.21560287475585938, 0.3155832290649414,
    0.8611688613891602, 0.9611482620239258, 0.1767129898071289, 0.27669239044189453,
    0.8505744934082031, 0.9505538940429688, 0.13782215118408203, 0.23780155181884766,
    0.8399801254272461, 0.9399595260620117, 0.09893131256103516, 0.19891071319580078,
    0.8010892868041992, 0.9010686874389648, 0.06004047393798828, 0.1600198745727539,
    0.7621984481811523, 0.862177848815918, 0.021149635314941406, 0.12112903594970703,
    0.7233076095581055, 0.8232870101928711, 0.022161483764648438, 0.12214088439941406,
    0.6844167709350586, 0.7843971252441406, 0.02317333221435547, 0.1231527328491211,
    0.6455259323120117, 0.7455062866210938, 0.024184226989746094, 0.12416458129882812,
    0.6066360473632812, 0.7066154479980469, 0.025196075439453125, 0.12517642974853516,
    0.5677452087402344, 0.667724609375, 0.026207923889160156, 0.12618732452392578,
    0.5288543701171875, 0.6288337707519531, 0.03334331512451172, 0.13332271575927734,
    0.4899635314941406, 0.5899429321289062, 0.04047870635986328, 0.1404590606689453,
    0.45107269287109375, 0.5510520935058594, 0.04761505126953125, 0.14759445190429688,
    0.4121818542480469, 0.5121612548828125, 0.05475044250488281, 0.15472984313964844,
    0.373291015625, 0.47327136993408203, 0.061885833740234375, 0.161865234375,
    0.3344001770019531, 0.43438053131103516, 0.06902122497558594, 0.16900062561035156,
    0.29551029205322266, 0.3954896926879883, 0.0761566162109375, 0.17613697052001953,
    0.2566194534301758, 0.3565988540649414, 0.08329200744628906, 0.1832723617553711,
    0.24215221405029297, 0.3421316146850586, 0.09042835235595703, 0.19040775299072266,
    0.22768497467041016, 0.3276653289794922, 0.12508678436279297, 0.225067138671875
};

/* Covered starts have x strictly above these bounds, by component. */
static const watchman_real watchman_start_lower[2] = {
    0.20305927753448622, 0.20305927753448622
};

/* Covered starts have x strictly below these bounds, by component. */
static const watchman_real watchman_start_upper[2] = {
    0.7969378614425645, 0.7969378614425645
};

/* Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 64 (t_c = 16 s).
 */
static inline void watchman_segment(watchman_real t, int32_t *row, watchman_real *s)
{
    const bool positive = 0.0 < t;
    const watchman_real started = positive ? t : 0.0;
    const watchman_real scaled = started * 4.0;
    const bool early = scaled < 63.99999999999999;
    const watchman_real u = early ? scaled : 63.99999999999999;
    const int32_t segment = (int32_t)u;
    const watchman_real base = (watchman_real)segment;
    const watchman_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* As segment, for a count of ticks: one is 2/25 of a segment, in integers; only s is rounded.
 * From tick 800 on the last segment and s = 1, which is t_c.
 */
static inline void watchman_segment_at_tick(uint32_t tick, int32_t *row, watchman_real *s)
{
    const bool running = tick < 800U;
    const uint32_t held = running ? tick : 800U;
    const int32_t count = (int32_t)held;
    const int32_t passed = count * 2;
    const bool early = passed < 1600;
    const int32_t place = early ? passed : 1600;
    const int32_t whole = place / 25;
    const bool before_last = whole < 63;
    const int32_t segment = before_last ? whole : 63;
    const int32_t base = segment * 25;
    const int32_t rest = place - base;
    const watchman_real part = (watchman_real)rest;
    const watchman_real share = part / 25.0;
    const int32_t first = segment * 4;
    *row = first;
    *s = share;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void watchman_basis(watchman_real s, watchman_real *w0, watchman_real *w1, watchman_real *w2,
                                  watchman_real *w3)
{
    const watchman_real v0 = 1.0 - s;
    const watchman_real v1 = v0 * v0;
    const watchman_real v2 = v1 * v0;
    const watchman_real v3 = v0 * s;
    const watchman_real v4 = 1.0 + v3;
    const watchman_real v5 = 3.0 * v4;
    const watchman_real v6 = v0 * v5;
    const watchman_real v7 = 1.0 + v6;
    const watchman_real v8 = s * v5;
    const watchman_real v9 = 1.0 + v8;
    const watchman_real v10 = s * s;
    const watchman_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void watchman_basis_rate(watchman_real s, watchman_real *dw0, watchman_real *dw1,
                                       watchman_real *dw2, watchman_real *dw3)
{
    const watchman_real v0 = 1.0 - s;
    const watchman_real v1 = v0 + v0;
    const watchman_real v2 = v0 * v1;
    const watchman_real v3 = v0 * v0;
    const watchman_real v4 = v2 + v3;
    const watchman_real v5 = -v4;
    const watchman_real v6 = v0 - s;
    const watchman_real v7 = 3.0 * v6;
    const watchman_real v8 = v0 * v7;
    const watchman_real v9 = v0 * s;
    const watchman_real v10 = 1.0 + v9;
    const watchman_real v11 = 3.0 * v10;
    const watchman_real v12 = v8 - v11;
    const watchman_real v13 = s * v7;
    const watchman_real v14 = v11 + v13;
    const watchman_real v15 = s + s;
    const watchman_real v16 = s * v15;
    const watchman_real v17 = s * s;
    const watchman_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline watchman_real watchman_edge_at(int32_t at, watchman_real w0, watchman_real w1, watchman_real w2,
                                             watchman_real w3)
{
    const watchman_real q0 = watchman_coefficients[at];
    const int32_t at_1 = at + 4;
    const watchman_real q1 = watchman_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const watchman_real q2 = watchman_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const watchman_real q3 = watchman_coefficients[at_3];
    const watchman_real v0 = w0 * q0;
    const watchman_real v1 = w1 * q1;
    const watchman_real v2 = v0 + v1;
    const watchman_real v3 = w2 * q2;
    const watchman_real v4 = w3 * q3;
    const watchman_real v5 = v3 + v4;
    const watchman_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline watchman_real watchman_normalized_error(watchman_real a, watchman_real b, watchman_real width)
{
    const watchman_real v0 = a - b;
    const watchman_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void watchman_transformed_error(watchman_real a, watchman_real b, watchman_real *epsilon,
                                              watchman_real *xi)
{
    const watchman_real v0 = b / a;
    const watchman_real v1 = log(v0);
    const watchman_real v2 = -v1;
    const watchman_real v3 = 1.0 + v0;
    const watchman_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline watchman_real watchman_law(watchman_real k, watchman_real xi, watchman_real epsilon)
{
    const watchman_real v0 = k * xi;
    const watchman_real v1 = v0 * epsilon;
    const watchman_real v2 = -v1;
    return v2;
}

void watchman_tube(watchman_real t, watchman_real lower[WATCHMAN_N], watchman_real upper[WATCHMAN_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (watchman_real)NAN;
            upper[j] = (watchman_real)NAN;
        }
        return;
    }
    int32_t row;
    watchman_real s;
    watchman_segment(t, &row, &s);
    watchman_real w0;
    watchman_real w1;
    watchman_real w2;
    watchman_real w3;
    watchman_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const watchman_real lower_edge = watchman_edge_at(lower_at, w0, w1, w2, w3);
        const watchman_real upper_edge = watchman_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void watchman_tube_rate(watchman_real t, watchman_real lower_rate[WATCHMAN_N],
                        watchman_real upper_rate[WATCHMAN_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (watchman_real)NAN;
            upper_rate[j] = (watchman_real)NAN;
        }
        return;
    }
    int32_t row;
    watchman_real s;
    watchman_segment(t, &row, &s);
    watchman_real dw0;
    watchman_real dw1;
    watchman_real dw2;
    watchman_real dw3;
    watchman_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 16.0;
    const watchman_real per_second = moving ? 4.0 : 0.0;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const watchman_real lower_slope = watchman_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const watchman_real lower_speed = lower_slope * per_second;
        const watchman_real upper_slope = watchman_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const watchman_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

watchman_status watchman_control(watchman_real t, const watchman_real x[WATCHMAN_N],
                                 watchman_real u[WATCHMAN_N])
{
    const watchman_real t_zero = t * 0.0;
    watchman_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const watchman_real x_j = x[j];
        const watchman_real x_zero = x_j * 0.0;
        const watchman_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
        }
        return WATCHMAN_BAD_INPUT;
    }
    int32_t row;
    watchman_real s;
    watchman_segment(t, &row, &s);
    watchman_real w0;
    watchman_real w1;
    watchman_real w2;
    watchman_real w3;
    watchman_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const watchman_real lower_edge = watchman_edge_at(lower_at, w0, w1, w2, w3);
        const watchman_real upper_edge = watchman_edge_at(upper_at, w0, w1, w2, w3);
        const watchman_real x_i = x[i];
        const watchman_real width = upper_edge - lower_edge;
        const watchman_real to_lower = x_i - lower_edge;
        const watchman_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const watchman_real distance = upper_nearer ? to_upper : to_lower;
        const watchman_real gain = upper_nearer ? (-0.5) : 0.5;
        const watchman_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const watchman_real to_nearer = clear ? distance : smallest;
        const watchman_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
        const bool outside_next = inside ? outside : true;
        watchman_real epsilon;
        watchman_real xi;
        watchman_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const watchman_real u_i = watchman_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? WATCHMAN_OUTSIDE_TUBE : WATCHMAN_OK;
}

watchman_status watchman_control_tick(uint32_t tick, const watchman_real x[WATCHMAN_N],
                                      watchman_real u[WATCHMAN_N])
{
    watchman_real zero = 0.0;
    for (int32_t j = 0; j < 2; ++j) {
        const watchman_real x_j = x[j];
        const watchman_real x_zero = x_j * 0.0;
        const watchman_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
        }
        return WATCHMAN_BAD_INPUT;
    }
    int32_t row;
    watchman_real s;
    watchman_segment_at_tick(tick, &row, &s);
    watchman_real w0;
    watchman_real w1;
    watchman_real w2;
    watchman_real w3;
    watchman_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const watchman_real lower_edge = watchman_edge_at(lower_at, w0, w1, w2, w3);
        const watchman_real upper_edge = watchman_edge_at(upper_at, w0, w1, w2, w3);
        const watchman_real x_i = x[i];
        const watchman_real width = upper_edge - lower_edge;
        const watchman_real to_lower = x_i - lower_edge;
        const watchman_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const watchman_real distance = upper_nearer ? to_upper : to_lower;
        const watchman_real gain = upper_nearer ? (-0.5) : 0.5;
        const watchman_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const watchman_real to_nearer = clear ? distance : smallest;
        const watchman_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
        const bool outside_next = inside ? outside : true;
        watchman_real epsilon;
        watchman_real xi;
        watchman_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const watchman_real u_i = watchman_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? WATCHMAN_OUTSIDE_TUBE : WATCHMAN_OK;
}

watchman_real watchman_margin(watchman_real t, const watchman_real x[WATCHMAN_N])
{
    const watchman_real t_zero = t * 0.0;
    watchman_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const watchman_real x_j = x[j];
        const watchman_real x_zero = x_j * 0.0;
        const watchman_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        return (watchman_real)NAN;
    }
    int32_t row;
    watchman_real s;
    watchman_segment(t, &row, &s);
    watchman_real w0;
    watchman_real w1;
    watchman_real w2;
    watchman_real w3;
    watchman_basis(s, &w0, &w1, &w2, &w3);
    watchman_real margin = 0.5;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const watchman_real lower_edge = watchman_edge_at(lower_at, w0, w1, w2, w3);
        const watchman_real upper_edge = watchman_edge_at(upper_at, w0, w1, w2, w3);
        const watchman_real x_i = x[i];
        const watchman_real width = upper_edge - lower_edge;
        const watchman_real to_lower = x_i - lower_edge;
        const watchman_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const watchman_real x_distance = x_nearer ? to_upper : to_lower;
        const watchman_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const watchman_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool less = margin_x < margin;
        const watchman_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void watchman_margins(watchman_real t, const watchman_real x[WATCHMAN_N], watchman_real margin[WATCHMAN_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (watchman_real)NAN;
        }
        return;
    }
    int32_t row;
    watchman_real s;
    watchman_segment(t, &row, &s);
    watchman_real w0;
    watchman_real w1;
    watchman_real w2;
    watchman_real w3;
    watchman_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const watchman_real lower_edge = watchman_edge_at(lower_at, w0, w1, w2, w3);
        const watchman_real upper_edge = watchman_edge_at(upper_at, w0, w1, w2, w3);
        const watchman_real x_i = x[i];
        const watchman_real width = upper_edge - lower_edge;
        const watchman_real to_lower = x_i - lower_edge;
        const watchman_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const watchman_real x_distance = x_nearer ? to_upper : to_lower;
        const watchman_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const watchman_real margin_x = x_beyond ? (-1.0) : x_share;
        margin[i] = margin_x;
    }
}

bool watchman_covered(const watchman_real x[WATCHMAN_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const watchman_real x_i = x[i];
        const watchman_real x_lower = watchman_start_lower[i];
        const watchman_real x_upper = watchman_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void watchman_transform(const watchman_real lower[WATCHMAN_N], const watchman_real upper[WATCHMAN_N],
                        const watchman_real x[WATCHMAN_N], watchman_real e[WATCHMAN_N],
                        watchman_real epsilon[WATCHMAN_N], watchman_real xi[WATCHMAN_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const watchman_real lower_edge = lower[i];
        const watchman_real upper_edge = upper[i];
        const watchman_real x_i = x[i];
        const watchman_real width = upper_edge - lower_edge;
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const watchman_real safe_width = wide ? width : 9.5367431640625e-7;
        const watchman_real to_lower = x_i - lower_edge;
        const watchman_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const watchman_real distance = upper_nearer ? to_upper : to_lower;
        const watchman_real sign = upper_nearer ? (-1.0) : 1.0;
        const watchman_real smallest = safe_width * 0.005;
        const watchman_real widened = safe_width - width;
        const watchman_real half = widened * 0.5;
        const watchman_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const watchman_real to_nearer = clear ? safe_distance : smallest;
        const watchman_real to_farther = safe_width - to_nearer;
        const watchman_real a = upper_nearer ? to_farther : to_nearer;
        const watchman_real b = upper_nearer ? to_nearer : to_farther;
        const watchman_real e_i = watchman_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const watchman_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const watchman_real e_limited = e_beyond ? 0.99 : e_raised;
        watchman_real epsilon_nearer;
        watchman_real xi_i;
        watchman_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const watchman_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const watchman_real e_or_zero = empty ? 0.0 : e_limited;
        const watchman_real e_out = finite ? e_or_zero : (watchman_real)NAN;
        e[i] = e_out;
        const watchman_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const watchman_real epsilon_out = finite ? epsilon_or_zero : (watchman_real)NAN;
        epsilon[i] = epsilon_out;
        const watchman_real xi_or_zero = empty ? 0.0 : xi_i;
        const watchman_real xi_out = finite ? xi_or_zero : (watchman_real)NAN;
        xi[i] = xi_out;
    }
}
