/* base.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (base.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.02 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= [0.5, 0.53, 0.4], 0.85 <= g_ii <= 1.18, |g_ij| <= [0.05, 0.05, 0], x measured to 0.003, u acts at most 0.002
 * s after its sample, v measured to 0.01: |e| of v + lambda x < [0.8745, 0.8849, 0.8661], |u| <= [2.1, 2.5, 1.1].
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "base.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "base.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "base.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "base.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "base.c: double is not IEEE-754's here, for which rounding is bounded"
#endif
/* No fused multiply-adds: Arduino's and other -std=gnu.. compilers would make them. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#pragma clang fp reassociate(off)
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#endif

/* B-spline control points divided by 6, one row for each of 32 + 3 points:
 * lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]
 * Multiples of 2^-20: exact in float and double.
 */
static const base_real base_coefficients[210] = {
    0.10730171203613281, 0.16270160675048828, 0.10464763641357422, 0.1600475311279297,
    -0.033069610595703125, 0.03307628631591797,
    0.10065364837646484, 0.16863346099853516, 0.09769153594970703, 0.164337158203125,
    -0.03345012664794922, 0.033446311950683594,
    0.09014320373535156, 0.16270160675048828, 0.10464763641357422, 0.1825408935546875,
    -0.033069610595703125, 0.03307628631591797,
    0.07963275909423828, 0.14490509033203125, 0.125518798828125, 0.21465778350830078,
    -0.03192710876464844, 0.03314399719238281,
    0.0691213607788086, 0.12452125549316406, 0.16030216217041016, 0.26068878173828125,
    -0.030023574829101562, 0.033972740173339844,
    0.060599327087402344, 0.11599922180175781, 0.2089996337890625, 0.3105459213256836,
    -0.0273590087890625, 0.03556251525878906,
    0.06394100189208984, 0.11934089660644531, 0.27161121368408203, 0.36040306091308594,
    -0.023932456970214844, 0.037914276123046875,
    0.0791473388671875, 0.13454723358154297, 0.3451204299926758, 0.4102611541748047,
    -0.019744873046875, 0.04102802276611328,
    0.1062173843383789, 0.16161727905273438, 0.40471839904785156, 0.46011829376220703,
    -0.014795303344726562, 0.04490184783935547,
    0.14515209197998047, 0.20055198669433594, 0.45040321350097656, 0.505803108215332,
    -0.009084701538085938, 0.049538612365722656,
    0.1959514617919922, 0.25135040283203125, 0.4821739196777344, 0.5375738143920898,
    -0.002613067626953125, 0.054935455322265625,
    0.25861454010009766, 0.3140144348144531, 0.5000314712524414, 0.5554304122924805,
    0.004620552062988281, 0.06109428405761719,
    0.32391929626464844, 0.3793191909790039, 0.5039749145507812, 0.5593748092651367,
    0.012615203857421875, 0.06801414489746094,
    0.37736034393310547, 0.43276023864746094, 0.4940042495727539, 0.5494041442871094,
    0.020296096801757812, 0.07569599151611328,
    0.41893672943115234, 0.4743366241455078, 0.4701213836669922, 0.5255212783813477,
    0.028738975524902344, 0.08413887023925781,
    0.44864940643310547, 0.5040493011474609, 0.4323244094848633, 0.48772335052490234,
    0.03794384002685547, 0.09334373474121094,
    0.46649742126464844, 0.5218973159790039, 0.3806133270263672, 0.43601322174072266,
    0.04790973663330078, 0.10330963134765625,
    0.47248077392578125, 0.5278806686401367, 0.3149890899658203, 0.3703889846801758,
    0.05863666534423828, 0.11403656005859375,
    0.4782838821411133, 0.5336837768554688, 0.25667572021484375, 0.3120756149291992,
    0.07005786895751953, 0.125457763671875,
    0.49595069885253906, 0.5513505935668945, 0.21227645874023438, 0.26767635345458984,
    0.08071708679199219, 0.13611698150634766,
    0.525482177734375, 0.5808820724487305, 0.18179035186767578, 0.23719024658203125,
    0.09061527252197266, 0.14601516723632812,
    0.5668783187866211, 0.6222782135009766, 0.16521739959716797, 0.22061729431152344,
    0.09975242614746094, 0.1551523208618164,
    0.6201381683349609, 0.6755380630493164, 0.16255855560302734, 0.2179584503173828,
    0.10812759399414062, 0.1635274887084961,
    0.6852626800537109, 0.7406625747680664, 0.1738138198852539, 0.22921371459960938,
    0.11574172973632812, 0.1711416244506836,
    0.7486495971679688, 0.8040485382080078, 0.19898223876953125, 0.2543811798095703,
    0.12259483337402344, 0.1779947280883789,
    0.8001708984375, 0.8555707931518555, 0.23806381225585938, 0.29346370697021484,
    0.12868595123291016, 0.18408584594726562,
    0.8398294448852539, 0.895228385925293, 0.2910594940185547, 0.34645843505859375,
    0.1340160369873047, 0.18941497802734375,
    0.8676223754882812, 0.9230222702026367, 0.3579683303833008, 0.41336822509765625,
    0.13858413696289062, 0.1939840316772461,
    0.8835515975952148, 0.9389514923095703, 0.4275360107421875, 0.48293590545654297,
    0.14239120483398438, 0.19779109954833984,
    0.8876171112060547, 0.9430170059204102, 0.48319053649902344, 0.5385904312133789,
    0.14543628692626953, 0.200836181640625,
    0.8798179626464844, 0.9352169036865234, 0.5249309539794922, 0.5803308486938477,
    0.1477212905883789, 0.20312023162841797,
    0.870539665222168, 0.9259395599365234, 0.5527582168579102, 0.6081581115722656,
    0.14924335479736328, 0.20464324951171875,
    0.8612613677978516, 0.916661262512207, 0.5666713714599609, 0.6220712661743164,
    0.15000534057617188, 0.20540523529052734,
    0.8612613677978516, 0.916661262512207, 0.5666713714599609, 0.6220712661743164,
    0.15000534057617188, 0.20540523529052734,
    0.8612613677978516, 0.916661262512207, 0.5666713714599609, 0.6220712661743164,
    0.15000534057617188, 0.20540523529052734
};

/* lambda of v + lambda x, by component. */
static const base_real base_filter[3] = {
    1.4306640625, 1.359375, 1.009765625
};

/* Gain k of the control law, by component. */
static const base_real base_gain[3] = {
    0.0927, 0.144, 0.0285
};

/* Saturation of u, by component. */
static const base_real base_u_max[3] = {
    2.0999999999999996, 2.5, 1.0999999999999999
};

/* Covered starts have x strictly above these bounds, by component. */
static const base_real base_start_lower[3] = {
    0.6430472640991225, 0.643048980712892, -0.15695197296142444
};

/* Covered starts have x strictly below these bounds, by component. */
static const base_real base_start_upper[3] = {
    0.9569493026733384, 0.9569494934082018, 0.15695006561279162
};

/* The same of v + lambda x: strictly above these bounds. */
static const base_real base_filtered_start_lower[3] = {
    0.8640959393605673, 0.8841447081565936, -0.1484847070723717
};

/* The same of v + lambda x: strictly below these bounds. */
static const base_real base_filtered_start_upper[3] = {
    1.359072976969174, 1.3772277293205182, 0.1484827810972874
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 25 s).
 */
static inline void base_segment(base_real t, int32_t *row, base_real *s)
{
    const bool positive = 0.0 < t;
    const base_real started = positive ? t : 0.0;
    const base_real scaled = started * 1.28;
    const bool early = scaled < 31.999999999999996;
    const base_real u = early ? scaled : 31.999999999999996;
    const int32_t segment = (int32_t)u;
    const base_real base = (base_real)segment;
    const base_real place = u - base;
    const int32_t first = segment * 6;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void base_basis(base_real s, base_real *w0, base_real *w1, base_real *w2, base_real *w3)
{
    const base_real v0 = 1.0 - s;
    const base_real v1 = v0 * v0;
    const base_real v2 = v1 * v0;
    const base_real v3 = v0 * s;
    const base_real v4 = 1.0 + v3;
    const base_real v5 = 3.0 * v4;
    const base_real v6 = v0 * v5;
    const base_real v7 = 1.0 + v6;
    const base_real v8 = s * v5;
    const base_real v9 = 1.0 + v8;
    const base_real v10 = s * s;
    const base_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void base_basis_rate(base_real s, base_real *dw0, base_real *dw1, base_real *dw2, base_real *dw3)
{
    const base_real v0 = 1.0 - s;
    const base_real v1 = v0 + v0;
    const base_real v2 = v0 * v1;
    const base_real v3 = v0 * v0;
    const base_real v4 = v2 + v3;
    const base_real v5 = -v4;
    const base_real v6 = v0 - s;
    const base_real v7 = 3.0 * v6;
    const base_real v8 = v0 * v7;
    const base_real v9 = v0 * s;
    const base_real v10 = 1.0 + v9;
    const base_real v11 = 3.0 * v10;
    const base_real v12 = v8 - v11;
    const base_real v13 = s * v7;
    const base_real v14 = v11 + v13;
    const base_real v15 = s + s;
    const base_real v16 = s * v15;
    const base_real v17 = s * s;
    const base_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline base_real base_edge_at(int32_t at, base_real w0, base_real w1, base_real w2, base_real w3)
{
    const base_real q0 = base_coefficients[at];
    const int32_t at_1 = at + 6;
    const base_real q1 = base_coefficients[at_1];
    const int32_t at_2 = at + 12;
    const base_real q2 = base_coefficients[at_2];
    const int32_t at_3 = at + 18;
    const base_real q3 = base_coefficients[at_3];
    const base_real v0 = w0 * q0;
    const base_real v1 = w1 * q1;
    const base_real v2 = v0 + v1;
    const base_real v3 = w2 * q2;
    const base_real v4 = w3 * q3;
    const base_real v5 = v3 + v4;
    const base_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline base_real base_normalized_error(base_real a, base_real b, base_real width)
{
    const base_real v0 = a - b;
    const base_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void base_transformed_error(base_real a, base_real b, base_real *epsilon, base_real *xi)
{
    const base_real v0 = b / a;
    const base_real v1 = log(v0);
    const base_real v2 = -v1;
    const base_real v3 = 1.0 + v0;
    const base_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline base_real base_law(base_real k, base_real xi, base_real epsilon)
{
    const base_real v0 = k * xi;
    const base_real v1 = v0 * epsilon;
    const base_real v2 = -v1;
    return v2;
}

void base_tube(base_real t, base_real lower[BASE_N], base_real upper[BASE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (base_real)NAN;
            upper[j] = (base_real)NAN;
        }
        return;
    }
    int32_t row;
    base_real s;
    base_segment(t, &row, &s);
    base_real w0;
    base_real w1;
    base_real w2;
    base_real w3;
    base_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const base_real lower_edge = base_edge_at(lower_at, w0, w1, w2, w3);
        const base_real upper_edge = base_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void base_tube_rate(base_real t, base_real lower_rate[BASE_N], base_real upper_rate[BASE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower_rate[j] = (base_real)NAN;
            upper_rate[j] = (base_real)NAN;
        }
        return;
    }
    int32_t row;
    base_real s;
    base_segment(t, &row, &s);
    base_real dw0;
    base_real dw1;
    base_real dw2;
    base_real dw3;
    base_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 25.0;
    const base_real per_second = moving ? 1.28 : 0.0;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const base_real lower_slope = base_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const base_real lower_speed = lower_slope * per_second;
        const base_real upper_slope = base_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const base_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

void base_filtered_tube(base_real t, base_real lower[BASE_N], base_real upper[BASE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (base_real)NAN;
            upper[j] = (base_real)NAN;
        }
        return;
    }
    int32_t row;
    base_real s;
    base_segment(t, &row, &s);
    base_real w0;
    base_real w1;
    base_real w2;
    base_real w3;
    base_basis(s, &w0, &w1, &w2, &w3);
    base_real dw0;
    base_real dw1;
    base_real dw2;
    base_real dw3;
    base_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const base_real lower_edge = base_edge_at(lower_at, w0, w1, w2, w3);
        const base_real upper_edge = base_edge_at(upper_at, w0, w1, w2, w3);
        const base_real lower_slope = base_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const base_real lower_rate = lower_slope * 1.28;
        const base_real upper_slope = base_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const base_real upper_rate = upper_slope * 1.28;
        const base_real filter_i = base_filter[i];
        const base_real lower_part = lower_edge * filter_i;
        const base_real z_lower = lower_rate + lower_part;
        lower[i] = z_lower;
        const base_real upper_part = upper_edge * filter_i;
        const base_real z_upper = upper_rate + upper_part;
        upper[i] = z_upper;
    }
}

base_status base_control(base_real t, const base_real x[BASE_N], const base_real v[BASE_N], base_real u[BASE_N])
{
    const base_real t_zero = t * 0.0;
    base_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const base_real x_j = x[j];
        const base_real x_zero = x_j * 0.0;
        const base_real zeros = zero + x_zero;
        zero = zeros;
    }
    base_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const base_real v_k = v[k];
        const base_real v_zero = v_k * 0.0;
        const base_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 3; ++m) {
            u[m] = 0.0;
        }
        return BASE_BAD_INPUT;
    }
    int32_t row;
    base_real s;
    base_segment(t, &row, &s);
    base_real w0;
    base_real w1;
    base_real w2;
    base_real w3;
    base_basis(s, &w0, &w1, &w2, &w3);
    base_real dw0;
    base_real dw1;
    base_real dw2;
    base_real dw3;
    base_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    bool outside = false;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const base_real lower_edge = base_edge_at(lower_at, w0, w1, w2, w3);
        const base_real upper_edge = base_edge_at(upper_at, w0, w1, w2, w3);
        const base_real lower_slope = base_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const base_real lower_rate = lower_slope * 1.28;
        const base_real upper_slope = base_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const base_real upper_rate = upper_slope * 1.28;
        const base_real x_i = x[i];
        const base_real v_i = v[i];
        const base_real width = upper_edge - lower_edge;
        const base_real to_lower = x_i - lower_edge;
        const base_real to_upper = upper_edge - x_i;
        const base_real v_width = upper_rate - lower_rate;
        const base_real v_to_lower = v_i - lower_rate;
        const base_real v_to_upper = upper_rate - v_i;
        const base_real filter_i = base_filter[i];
        const base_real gain_i = base_gain[i];
        const base_real gain_minus = -gain_i;
        const base_real width_part = width * filter_i;
        const base_real z_width = v_width + width_part;
        const base_real lower_part = to_lower * filter_i;
        const base_real z_to_lower = v_to_lower + lower_part;
        const base_real upper_part = to_upper * filter_i;
        const base_real z_to_upper = v_to_upper + upper_part;
        const bool upper_nearer = z_to_upper < z_to_lower;
        const base_real distance = upper_nearer ? z_to_upper : z_to_lower;
        const base_real gain = upper_nearer ? gain_minus : gain_i;
        const base_real smallest = z_width * 0.005;
        const bool clear = smallest < distance;
        const base_real to_nearer = clear ? distance : smallest;
        const base_real to_farther = z_width - to_nearer;
        const bool x_above = 0.0 < to_lower;
        const bool x_below = 0.0 < to_upper;
        const bool x_inside = x_above && x_below;
        const bool z_inside = 0.0 < distance;
        const bool inside = z_inside && x_inside;
        const bool outside_next = inside ? outside : true;
        const base_real u_limit = base_u_max[i];
        base_real epsilon;
        base_real xi;
        base_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const base_real u_i = base_law(gain, xi, epsilon);
        const base_real u_min = -u_limit;
        const bool u_above = u_min < u_i;
        const base_real u_raised = u_above ? u_i : u_min;
        const bool u_beyond = u_limit < u_raised;
        const base_real u_limited = u_beyond ? u_limit : u_raised;
        u[i] = u_limited;
        outside = outside_next;
    }
    return outside ? BASE_OUTSIDE_TUBE : BASE_OK;
}

base_real base_margin(base_real t, const base_real x[BASE_N], const base_real v[BASE_N])
{
    const base_real t_zero = t * 0.0;
    base_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const base_real x_j = x[j];
        const base_real x_zero = x_j * 0.0;
        const base_real zeros = zero + x_zero;
        zero = zeros;
    }
    base_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const base_real v_k = v[k];
        const base_real v_zero = v_k * 0.0;
        const base_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0;
    const bool bad = !finite;
    if (bad) {
        return (base_real)NAN;
    }
    int32_t row;
    base_real s;
    base_segment(t, &row, &s);
    base_real w0;
    base_real w1;
    base_real w2;
    base_real w3;
    base_basis(s, &w0, &w1, &w2, &w3);
    base_real dw0;
    base_real dw1;
    base_real dw2;
    base_real dw3;
    base_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    base_real margin = 0.5;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const base_real lower_edge = base_edge_at(lower_at, w0, w1, w2, w3);
        const base_real upper_edge = base_edge_at(upper_at, w0, w1, w2, w3);
        const base_real lower_slope = base_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const base_real lower_rate = lower_slope * 1.28;
        const base_real upper_slope = base_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const base_real upper_rate = upper_slope * 1.28;
        const base_real x_i = x[i];
        const base_real v_i = v[i];
        const base_real width = upper_edge - lower_edge;
        const base_real to_lower = x_i - lower_edge;
        const base_real to_upper = upper_edge - x_i;
        const base_real v_width = upper_rate - lower_rate;
        const base_real v_to_lower = v_i - lower_rate;
        const base_real v_to_upper = upper_rate - v_i;
        const base_real filter_i = base_filter[i];
        const base_real width_part = width * filter_i;
        const base_real z_width = v_width + width_part;
        const base_real lower_part = to_lower * filter_i;
        const base_real z_to_lower = v_to_lower + lower_part;
        const base_real upper_part = to_upper * filter_i;
        const base_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const base_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const base_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0);
        const base_real margin_z = z_beyond ? (-1.0) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const base_real x_distance = x_nearer ? to_upper : to_lower;
        const base_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const base_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const base_real smaller = x_smaller ? margin_x : margin_z;
        const bool less = smaller < margin;
        const base_real margin_next = less ? smaller : margin;
        margin = margin_next;
    }
    return margin;
}

void base_margins(base_real t, const base_real x[BASE_N], const base_real v[BASE_N], base_real margin[BASE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            margin[j] = (base_real)NAN;
        }
        return;
    }
    int32_t row;
    base_real s;
    base_segment(t, &row, &s);
    base_real w0;
    base_real w1;
    base_real w2;
    base_real w3;
    base_basis(s, &w0, &w1, &w2, &w3);
    base_real dw0;
    base_real dw1;
    base_real dw2;
    base_real dw3;
    base_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const base_real lower_edge = base_edge_at(lower_at, w0, w1, w2, w3);
        const base_real upper_edge = base_edge_at(upper_at, w0, w1, w2, w3);
        const base_real lower_slope = base_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const base_real lower_rate = lower_slope * 1.28;
        const base_real upper_slope = base_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const base_real upper_rate = upper_slope * 1.28;
        const base_real x_i = x[i];
        const base_real v_i = v[i];
        const base_real width = upper_edge - lower_edge;
        const base_real to_lower = x_i - lower_edge;
        const base_real to_upper = upper_edge - x_i;
        const base_real v_width = upper_rate - lower_rate;
        const base_real v_to_lower = v_i - lower_rate;
        const base_real v_to_upper = upper_rate - v_i;
        const base_real filter_i = base_filter[i];
        const base_real width_part = width * filter_i;
        const base_real z_width = v_width + width_part;
        const base_real lower_part = to_lower * filter_i;
        const base_real z_to_lower = v_to_lower + lower_part;
        const base_real upper_part = to_upper * filter_i;
        const base_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const base_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const base_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0);
        const base_real margin_z = z_beyond ? (-1.0) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const base_real x_distance = x_nearer ? to_upper : to_lower;
        const base_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const base_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const base_real smaller = x_smaller ? margin_x : margin_z;
        margin[i] = smaller;
    }
}

bool base_covered(const base_real x[BASE_N], const base_real v[BASE_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 3; ++i) {
        const base_real x_i = x[i];
        const base_real x_lower = base_start_lower[i];
        const base_real x_upper = base_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const base_real filter_i = base_filter[i];
        const base_real x_part = x_i * filter_i;
        const base_real v_i = v[i];
        const base_real z_i = v_i + x_part;
        const base_real z_lower = base_filtered_start_lower[i];
        const base_real z_upper = base_filtered_start_upper[i];
        const bool z_above = z_lower < z_i;
        const bool z_below = z_i < z_upper;
        const bool z_inside = z_above && z_below;
        const bool inside = x_inside && z_inside;
        const bool covered_next = inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void base_transform(const base_real lower[BASE_N], const base_real upper[BASE_N], const base_real x[BASE_N],
                    base_real e[BASE_N], base_real epsilon[BASE_N], base_real xi[BASE_N])
{
    for (int32_t i = 0; i < 3; ++i) {
        const base_real lower_edge = lower[i];
        const base_real upper_edge = upper[i];
        const base_real x_i = x[i];
        const base_real width = upper_edge - lower_edge;
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const base_real safe_width = wide ? width : 9.5367431640625e-7;
        const base_real to_lower = x_i - lower_edge;
        const base_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const base_real distance = upper_nearer ? to_upper : to_lower;
        const base_real sign = upper_nearer ? (-1.0) : 1.0;
        const base_real smallest = safe_width * 0.005;
        const base_real widened = safe_width - width;
        const base_real half = widened * 0.5;
        const base_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const base_real to_nearer = clear ? safe_distance : smallest;
        const base_real to_farther = safe_width - to_nearer;
        const base_real a = upper_nearer ? to_farther : to_nearer;
        const base_real b = upper_nearer ? to_nearer : to_farther;
        const base_real e_i = base_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const base_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const base_real e_limited = e_beyond ? 0.99 : e_raised;
        base_real epsilon_nearer;
        base_real xi_i;
        base_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const base_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const base_real e_or_zero = empty ? 0.0 : e_limited;
        const base_real e_out = finite ? e_or_zero : (base_real)NAN;
        e[i] = e_out;
        const base_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const base_real epsilon_out = finite ? epsilon_or_zero : (base_real)NAN;
        epsilon[i] = epsilon_out;
        const base_real xi_or_zero = empty ? 0.0 : xi_i;
        const base_real xi_out = finite ? xi_or_zero : (base_real)NAN;
        xi[i] = xi_out;
    }
}
