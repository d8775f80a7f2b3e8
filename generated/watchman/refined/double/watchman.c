/* watchman.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (watchman.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and repeats itself for ever.
 * Every x(t) that stays in the tube satisfies the mission (P10): (always eventually[0, 14] gate and always
 * eventually[0, 14] office and always eventually[0, 14] store and always not lab); times are seconds of t, not turned
 * back. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.343 s.
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
    -0.009248733520507812, 0.09073066711425781, 0.026376724243164062, 0.1263561248779297,
    0.03334331512451172, 0.13332271575927734, 0.03334331512451172, 0.13332271575927734,
    0.07593536376953125, 0.17591571807861328, 0.040309906005859375, 0.1402902603149414,
    0.11852836608886719, 0.2185077667236328, 0.04727745056152344, 0.14725685119628906,
    0.16112041473388672, 0.26109981536865234, 0.054244041442871094, 0.15422344207763672,
    0.20371246337890625, 0.3036918640136719, 0.06121063232421875, 0.16119003295898438,
    0.24630451202392578, 0.3462848663330078, 0.0681772232055664, 0.16815662384033203,
    0.2888975143432617, 0.38887691497802734, 0.07514381408691406, 0.1751241683959961,
    0.33148956298828125, 0.4314689636230469, 0.08211135864257812, 0.18209075927734375,
    0.2950153350830078, 0.39499473571777344, 0.08907794952392578, 0.1890573501586914,
    0.2585411071777344, 0.3585205078125, 0.1316699981689453, 0.23164939880371094,
    0.22206687927246094, 0.32204627990722656, 0.17426204681396484, 0.2742424011230469,
    0.1855926513671875, 0.2855720520019531, 0.21685504913330078, 0.3168344497680664,
    0.14911842346191406, 0.2490978240966797, 0.2594470977783203, 0.35942649841308594,
    0.12496471405029297, 0.2249441146850586, 0.30203914642333984, 0.40201854705810547,
    0.10081100463867188, 0.2007913589477539, 0.3446311950683594, 0.4446115493774414,
    0.07665824890136719, 0.1766376495361328, 0.3872241973876953, 0.48720359802246094,
    0.052504539489746094, 0.15248394012451172, 0.42981624603271484, 0.5297956466674805,
    0.028350830078125, 0.12833118438720703, 0.4724082946777344, 0.5723886489868164,
    0.043313026428222656, 0.14329242706298828, 0.48058032989501953, 0.5805597305297852,
    0.058274269104003906, 0.15825462341308594, 0.47405147552490234, 0.574030876159668,
    0.10001564025878906, 0.1999950408935547, 0.46752166748046875, 0.5675020217895508,
    0.1417560577392578, 0.24173545837402344, 0.46099281311035156, 0.5609731674194336,
    0.18349647521972656, 0.2834768295288086, 0.4544639587402344, 0.5544443130493164,
    0.22523784637451172, 0.32521724700927734, 0.4479351043701172, 0.5479154586791992,
    0.26697826385498047, 0.3669576644897461, 0.44140625, 0.5413856506347656,
    0.3087186813354492, 0.40869808197021484, 0.4348773956298828, 0.5348567962646484,
    0.3504600524902344, 0.450439453125, 0.4283485412597656, 0.5283279418945312,
    0.3922004699707031, 0.49217987060546875, 0.42181968688964844, 0.5217990875244141,
    0.4339408874511719, 0.5339202880859375, 0.42308616638183594, 0.5230655670166016,
    0.47568225860595703, 0.5756616592407227, 0.42435264587402344, 0.5243320465087891,
    0.5174226760864258, 0.6174020767211914, 0.4283485412597656, 0.5283279418945312,
    0.5591630935668945, 0.6591424942016602, 0.4323444366455078, 0.5323238372802734,
    0.6009035110473633, 0.7008838653564453, 0.43634033203125, 0.5363197326660156,
    0.6426448822021484, 0.7426242828369141, 0.4403362274169922, 0.5403156280517578,
    0.6843852996826172, 0.7843647003173828, 0.44433116912841797, 0.5443115234375,
    0.7261257171630859, 0.826106071472168, 0.44832706451416016, 0.5483074188232422,
    0.7678670883178711, 0.8678464889526367, 0.45232295989990234, 0.552302360534668,
    0.8096075057983398, 0.9095869064331055, 0.45631885528564453, 0.5562982559204102,
    0.8119640350341797, 0.9119434356689453, 0.4603147506713867, 0.5602941513061523,
    0.8143205642700195, 0.9142999649047852, 0.4643106460571289, 0.5642900466918945,
    0.8166770935058594, 0.916656494140625, 0.45151805877685547, 0.5514974594116211,
    0.8190336227416992, 0.9190130233764648, 0.4124622344970703, 0.5124416351318359,
    0.8213891983032227, 0.9213695526123047, 0.37340641021728516, 0.4733858108520508,
    0.8237457275390625, 0.9237260818481445, 0.3343505859375, 0.4343299865722656,
    0.8261022567749023, 0.9260826110839844, 0.29529476165771484, 0.39527416229248047,
    0.8284587860107422, 0.9284381866455078, 0.2562389373779297, 0.3562183380126953,
    0.830815315246582, 0.9307947158813477, 0.21718311309814453, 0.31716251373291016,
    0.8331718444824219, 0.9331512451171875, 0.17812728881835938, 0.278106689453125,
    0.8355283737182617, 0.9355077743530273, 0.13907146453857422, 0.23905086517333984,
    0.8378849029541016, 0.9378643035888672, 0.10001564025878906, 0.1999950408935547,
    0.8402414321899414, 0.940220832824707, 0.060959815979003906, 0.16093921661376953,
    0.8425970077514648, 0.9425773620605469, 0.032032012939453125, 0.13201141357421875,
    0.8000049591064453, 0.8999843597412109, 0.03595161437988281, 0.13593101501464844,
    0.7574129104614258, 0.8573923110961914, 0.039870262145996094, 0.13985061645507812,
    0.7148208618164062, 0.8148002624511719, 0.04378986358642578, 0.1437692642211914,
    0.6722278594970703, 0.7722082138061523, 0.04770946502685547, 0.1476888656616211,
    0.6296358108520508, 0.7296152114868164, 0.05162811279296875, 0.15160846710205078,
    0.5870437622070312, 0.6870231628417969, 0.05554771423339844, 0.15552711486816406,
    0.5444507598876953, 0.6444311141967773, 0.059467315673828125, 0.15944671630859375,
    0.5018587112426758, 0.6018381118774414, 0.0633859634399414, 0.16336631774902344,
    0.45926666259765625, 0.5592460632324219, 0.0673055648803711, 0.16728496551513672,
    0.4166746139526367, 0.5166540145874023, 0.07122516632080078, 0.1712045669555664,
    0.3740816116333008, 0.4740619659423828, 0.07514381408691406, 0.1751241683959961,
    0.33148956298828125, 0.4314689636230469, 0.08211135864257812, 0.18209075927734375,
    0.2950153350830078, 0.39499473571777344, 0.08907794952392578, 0.1890573501586914,
    0.2585411071777344, 0.3585205078125, 0.1316699981689453, 0.23164939880371094
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
