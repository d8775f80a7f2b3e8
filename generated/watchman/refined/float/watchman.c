/* watchman.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "watchman.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "watchman.c: float is not IEEE-754's here, for which rounding is bounded"
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
    -0.0092487335F, 0.09073067F, 0.026376724F, 0.12635612F,
    0.033343315F, 0.13332272F, 0.033343315F, 0.13332272F,
    0.075935364F, 0.17591572F, 0.040309906F, 0.14029026F,
    0.118528366F, 0.21850777F, 0.04727745F, 0.14725685F,
    0.16112041F, 0.26109982F, 0.05424404F, 0.15422344F,
    0.20371246F, 0.30369186F, 0.061210632F, 0.16119003F,
    0.24630451F, 0.34628487F, 0.06817722F, 0.16815662F,
    0.2888975F, 0.38887691F, 0.075143814F, 0.17512417F,
    0.33148956F, 0.43146896F, 0.08211136F, 0.18209076F,
    0.29501534F, 0.39499474F, 0.08907795F, 0.18905735F,
    0.2585411F, 0.3585205F, 0.13167F, 0.2316494F,
    0.22206688F, 0.32204628F, 0.17426205F, 0.2742424F,
    0.18559265F, 0.28557205F, 0.21685505F, 0.31683445F,
    0.14911842F, 0.24909782F, 0.2594471F, 0.3594265F,
    0.124964714F, 0.22494411F, 0.30203915F, 0.40201855F,
    0.100811005F, 0.20079136F, 0.3446312F, 0.44461155F,
    0.07665825F, 0.17663765F, 0.3872242F, 0.4872036F,
    0.05250454F, 0.15248394F, 0.42981625F, 0.52979565F,
    0.02835083F, 0.12833118F, 0.4724083F, 0.57238865F,
    0.043313026F, 0.14329243F, 0.48058033F, 0.58055973F,
    0.05827427F, 0.15825462F, 0.47405148F, 0.5740309F,
    0.10001564F, 0.19999504F, 0.46752167F, 0.567502F,
    0.14175606F, 0.24173546F, 0.4609928F, 0.56097317F,
    0.18349648F, 0.28347683F, 0.45446396F, 0.5544443F,
    0.22523785F, 0.32521725F, 0.4479351F, 0.54791546F,
    0.26697826F, 0.36695766F, 0.44140625F, 0.54138565F,
    0.30871868F, 0.40869808F, 0.4348774F, 0.5348568F,
    0.35046005F, 0.45043945F, 0.42834854F, 0.52832794F,
    0.39220047F, 0.49217987F, 0.4218197F, 0.5217991F,
    0.4339409F, 0.5339203F, 0.42308617F, 0.52306557F,
    0.47568226F, 0.57566166F, 0.42435265F, 0.52433205F,
    0.5174227F, 0.6174021F, 0.42834854F, 0.52832794F,
    0.5591631F, 0.6591425F, 0.43234444F, 0.53232384F,
    0.6009035F, 0.70088387F, 0.43634033F, 0.53631973F,
    0.6426449F, 0.7426243F, 0.44033623F, 0.5403156F,
    0.6843853F, 0.7843647F, 0.44433117F, 0.5443115F,
    0.7261257F, 0.8261061F, 0.44832706F, 0.5483074F,
    0.7678671F, 0.8678465F, 0.45232296F, 0.55230236F,
    0.8096075F, 0.9095869F, 0.45631886F, 0.55629826F,
    0.81196404F, 0.91194344F, 0.46031475F, 0.56029415F,
    0.81432056F, 0.91429996F, 0.46431065F, 0.56429005F,
    0.8166771F, 0.9166565F, 0.45151806F, 0.55149746F,
    0.8190336F, 0.919013F, 0.41246223F, 0.51244164F,
    0.8213892F, 0.92136955F, 0.3734064F, 0.4733858F,
    0.8237457F, 0.9237261F, 0.3343506F, 0.43433F,
    0.82610226F, 0.9260826F, 0.29529476F, 0.39527416F,
    0.8284588F, 0.9284382F, 0.25623894F, 0.35621834F,
    0.8308153F, 0.9307947F, 0.21718311F, 0.3171625F,
    0.83317184F, 0.93315125F, 0.17812729F, 0.2781067F,
    0.8355284F, 0.9355078F, 0.13907146F, 0.23905087F,
    0.8378849F, 0.9378643F, 0.10001564F, 0.19999504F,
    0.84024143F, 0.94022083F, 0.060959816F, 0.16093922F,
    0.842597F, 0.94257736F, 0.032032013F, 0.13201141F,
    0.80000496F, 0.89998436F, 0.035951614F, 0.13593102F,
    0.7574129F, 0.8573923F, 0.039870262F, 0.13985062F,
    0.71482086F, 0.81480026F, 0.043789864F, 0.14376926F,
    0.67222786F, 0.7722082F, 0.047709465F, 0.14768887F,
    0.6296358F, 0.7296152F, 0.051628113F, 0.15160847F,
    0.58704376F, 0.68702316F, 0.055547714F, 0.15552711F,
    0.54445076F, 0.6444311F, 0.059467316F, 0.15944672F,
    0.5018587F, 0.6018381F, 0.06338596F, 0.16336632F,
    0.45926666F, 0.55924606F, 0.067305565F, 0.16728497F,
    0.4166746F, 0.516654F, 0.07122517F, 0.17120457F,
    0.3740816F, 0.47406197F, 0.075143814F, 0.17512417F,
    0.33148956F, 0.43146896F, 0.08211136F, 0.18209076F,
    0.29501534F, 0.39499474F, 0.08907795F, 0.18905735F,
    0.2585411F, 0.3585205F, 0.13167F, 0.2316494F
};

/* Covered starts have x strictly above these bounds, by component. */
static const watchman_real watchman_start_lower[2] = {
    0.20306F, 0.20306F
};

/* Covered starts have x strictly below these bounds, by component. */
static const watchman_real watchman_start_upper[2] = {
    0.7969371F, 0.7969371F
};

/* Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 64 (t_c = 16 s).
 */
static inline void watchman_segment(watchman_real t, int32_t *row, watchman_real *s)
{
    const bool positive = 0.0F < t;
    const watchman_real started = positive ? t : 0.0F;
    const watchman_real scaled = started * 4.0F;
    const bool early = scaled < 63.999996F;
    const watchman_real u = early ? scaled : 63.999996F;
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
    const watchman_real share = part / 25.0F;
    const int32_t first = segment * 4;
    *row = first;
    *s = share;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void watchman_basis(watchman_real s, watchman_real *w0, watchman_real *w1, watchman_real *w2,
                                  watchman_real *w3)
{
    const watchman_real v0 = 1.0F - s;
    const watchman_real v1 = v0 * v0;
    const watchman_real v2 = v1 * v0;
    const watchman_real v3 = v0 * s;
    const watchman_real v4 = 1.0F + v3;
    const watchman_real v5 = 3.0F * v4;
    const watchman_real v6 = v0 * v5;
    const watchman_real v7 = 1.0F + v6;
    const watchman_real v8 = s * v5;
    const watchman_real v9 = 1.0F + v8;
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
    const watchman_real v0 = 1.0F - s;
    const watchman_real v1 = v0 + v0;
    const watchman_real v2 = v0 * v1;
    const watchman_real v3 = v0 * v0;
    const watchman_real v4 = v2 + v3;
    const watchman_real v5 = -v4;
    const watchman_real v6 = v0 - s;
    const watchman_real v7 = 3.0F * v6;
    const watchman_real v8 = v0 * v7;
    const watchman_real v9 = v0 * s;
    const watchman_real v10 = 1.0F + v9;
    const watchman_real v11 = 3.0F * v10;
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
    const watchman_real v1 = logf(v0);
    const watchman_real v2 = -v1;
    const watchman_real v3 = 1.0F + v0;
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
    const bool moving = t < 16.0F;
    const watchman_real per_second = moving ? 4.0F : 0.0F;
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
    const watchman_real t_zero = t * 0.0F;
    watchman_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const watchman_real x_j = x[j];
        const watchman_real x_zero = x_j * 0.0F;
        const watchman_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
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
        const watchman_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const watchman_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const watchman_real to_nearer = clear ? distance : smallest;
        const watchman_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
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
    watchman_real zero = 0.0F;
    for (int32_t j = 0; j < 2; ++j) {
        const watchman_real x_j = x[j];
        const watchman_real x_zero = x_j * 0.0F;
        const watchman_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
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
        const watchman_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const watchman_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const watchman_real to_nearer = clear ? distance : smallest;
        const watchman_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
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
    const watchman_real t_zero = t * 0.0F;
    watchman_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const watchman_real x_j = x[j];
        const watchman_real x_zero = x_j * 0.0F;
        const watchman_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
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
    watchman_real margin = 0.5F;
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
        const bool x_beyond = x_share < (-1.0F);
        const watchman_real margin_x = x_beyond ? (-1.0F) : x_share;
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
        const bool x_beyond = x_share < (-1.0F);
        const watchman_real margin_x = x_beyond ? (-1.0F) : x_share;
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
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const watchman_real safe_width = wide ? width : 9.536743e-7F;
        const watchman_real to_lower = x_i - lower_edge;
        const watchman_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const watchman_real distance = upper_nearer ? to_upper : to_lower;
        const watchman_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const watchman_real smallest = safe_width * 0.005F;
        const watchman_real widened = safe_width - width;
        const watchman_real half = widened * 0.5F;
        const watchman_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const watchman_real to_nearer = clear ? safe_distance : smallest;
        const watchman_real to_farther = safe_width - to_nearer;
        const watchman_real a = upper_nearer ? to_farther : to_nearer;
        const watchman_real b = upper_nearer ? to_nearer : to_farther;
        const watchman_real e_i = watchman_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const watchman_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const watchman_real e_limited = e_beyond ? 0.99F : e_raised;
        watchman_real epsilon_nearer;
        watchman_real xi_i;
        watchman_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const watchman_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const watchman_real e_or_zero = empty ? 0.0F : e_limited;
        const watchman_real e_out = finite ? e_or_zero : (watchman_real)NAN;
        e[i] = e_out;
        const watchman_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const watchman_real epsilon_out = finite ? epsilon_or_zero : (watchman_real)NAN;
        epsilon[i] = epsilon_out;
        const watchman_real xi_or_zero = empty ? 0.0F : xi_i;
        const watchman_real xi_out = finite ? xi_or_zero : (watchman_real)NAN;
        xi[i] = xi_out;
    }
}
