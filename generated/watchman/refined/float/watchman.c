/* watchman.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
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
    0.0014467239F, 0.10142708F, 0.026207924F, 0.12618732F,
    0.033343315F, 0.13332272F, 0.033343315F, 0.13332272F,
    0.06523991F, 0.1652193F, 0.040478706F, 0.14045906F,
    0.0971365F, 0.1971159F, 0.04761505F, 0.14759445F,
    0.12903309F, 0.22901249F, 0.054750443F, 0.15472984F,
    0.16092968F, 0.26090908F, 0.061885834F, 0.16186523F,
    0.19282627F, 0.29280567F, 0.069021225F, 0.16900063F,
    0.22472286F, 0.32470226F, 0.076156616F, 0.17613697F,
    0.25661945F, 0.35659885F, 0.08329201F, 0.18327236F,
    0.24215221F, 0.3421316F, 0.09042835F, 0.19040775F,
    0.22768497F, 0.32766533F, 0.12508678F, 0.22506714F,
    0.21321869F, 0.3131981F, 0.16397762F, 0.26395702F,
    0.19875145F, 0.29873085F, 0.20286846F, 0.30284786F,
    0.18428421F, 0.28426456F, 0.2417593F, 0.3417387F,
    0.16981792F, 0.26979733F, 0.28065014F, 0.38062954F,
    0.15535069F, 0.2553301F, 0.31954098F, 0.41952038F,
    0.14088345F, 0.24086285F, 0.35843086F, 0.45841122F,
    0.1264162F, 0.22639656F, 0.3973217F, 0.49730206F,
    0.11194992F, 0.21192932F, 0.43621254F, 0.53619194F,
    0.09748268F, 0.19746208F, 0.47510338F, 0.5750828F,
    0.091706276F, 0.19168568F, 0.4699087F, 0.5698881F,
    0.12927914F, 0.22925854F, 0.4647131F, 0.56469345F,
    0.166852F, 0.2668314F, 0.45951843F, 0.55949783F,
    0.2044239F, 0.30440426F, 0.45432377F, 0.55430317F,
    0.24199677F, 0.34197617F, 0.44912815F, 0.5491085F,
    0.27956963F, 0.37954903F, 0.4439335F, 0.5439129F,
    0.3171425F, 0.4171219F, 0.43873882F, 0.5387182F,
    0.3547144F, 0.45469475F, 0.4335432F, 0.53352356F,
    0.39228725F, 0.49226665F, 0.42834854F, 0.52832794F,
    0.42986012F, 0.5298395F, 0.42315388F, 0.5231333F,
    0.46743202F, 0.5674124F, 0.42091274F, 0.52089214F,
    0.5050049F, 0.6049843F, 0.42834854F, 0.52832794F,
    0.54257774F, 0.64255714F, 0.43578434F, 0.5357647F,
    0.5801506F, 0.68013F, 0.4432211F, 0.5432005F,
    0.6177225F, 0.71770287F, 0.4506569F, 0.5506363F,
    0.6552954F, 0.7552748F, 0.4580927F, 0.55807304F,
    0.6876936F, 0.787673F, 0.46552944F, 0.56550884F,
    0.72009087F, 0.82007027F, 0.47296524F, 0.57294464F,
    0.7524891F, 0.8524685F, 0.48040104F, 0.5803814F,
    0.78488636F, 0.88486576F, 0.4878378F, 0.5878172F,
    0.81728363F, 0.917264F, 0.4489479F, 0.5489273F,
    0.84603786F, 0.9460182F, 0.41005707F, 0.51003647F,
    0.8747921F, 0.97477245F, 0.37116623F, 0.47114563F,
    0.90354633F, 1.0035267F, 0.3322754F, 0.4322548F,
    0.89295197F, 0.9929323F, 0.29338455F, 0.39336395F,
    0.8823576F, 0.982337F, 0.2544937F, 0.35447407F,
    0.8717632F, 0.97174263F, 0.21560287F, 0.31558323F,
    0.86116886F, 0.96114826F, 0.17671299F, 0.2766924F,
    0.8505745F, 0.9505539F, 0.13782215F, 0.23780155F,
    0.8399801F, 0.9399595F, 0.09893131F, 0.19891071F,
    0.8010893F, 0.9010687F, 0.060040474F, 0.16001987F,
    0.76219845F, 0.86217785F, 0.021149635F, 0.121129036F,
    0.7233076F, 0.823287F, 0.022161484F, 0.122140884F,
    0.6844168F, 0.7843971F, 0.023173332F, 0.12315273F,
    0.64552593F, 0.7455063F, 0.024184227F, 0.12416458F,
    0.60663605F, 0.70661545F, 0.025196075F, 0.12517643F,
    0.5677452F, 0.6677246F, 0.026207924F, 0.12618732F,
    0.52885437F, 0.6288338F, 0.033343315F, 0.13332272F,
    0.48996353F, 0.58994293F, 0.040478706F, 0.14045906F,
    0.4510727F, 0.5510521F, 0.04761505F, 0.14759445F,
    0.41218185F, 0.51216125F, 0.054750443F, 0.15472984F,
    0.37329102F, 0.47327137F, 0.061885834F, 0.16186523F,
    0.33440018F, 0.43438053F, 0.069021225F, 0.16900063F,
    0.2955103F, 0.3954897F, 0.076156616F, 0.17613697F,
    0.25661945F, 0.35659885F, 0.08329201F, 0.18327236F,
    0.24215221F, 0.3421316F, 0.09042835F, 0.19040775F,
    0.22768497F, 0.32766533F, 0.12508678F, 0.22506714F
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
