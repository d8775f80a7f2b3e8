/* drone.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (drone.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.025 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= 0.35, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 0.005, u acts at most 0.004 s after its sample, v
 * measured to 0.02: |e| of v + lambda x < [0.9346, 0.9346, 0.9377], |u| <= 2.5.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "drone.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "drone.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "drone.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "drone.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "drone.c: float is not IEEE-754's here, for which rounding is bounded"
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
static const drone_real drone_coefficients[210] = {
    0.050009727F, 0.14999008F, 0.051778793F, 0.15175915F,
    0.11683369F, 0.21681309F,
    0.050009727F, 0.14999008F, 0.04912567F, 0.14910507F,
    0.11659813F, 0.21657848F,
    0.050009727F, 0.14999008F, 0.051778793F, 0.15175915F,
    0.11683369F, 0.21681309F,
    0.05123329F, 0.15121365F, 0.059739113F, 0.15971851F,
    0.117539406F, 0.21751976F,
    0.057764053F, 0.15774345F, 0.07300472F, 0.17298508F,
    0.11871624F, 0.2186966F,
    0.069600105F, 0.16958046F, 0.09157848F, 0.19155788F,
    0.12036419F, 0.22034359F,
    0.086743355F, 0.18672371F, 0.115457535F, 0.21543694F,
    0.1224823F, 0.22246265F,
    0.1045351F, 0.2045145F, 0.14464378F, 0.24462318F,
    0.12507153F, 0.22505093F,
    0.12763214F, 0.2276125F, 0.17913628F, 0.27911568F,
    0.12813187F, 0.22811127F,
    0.15603638F, 0.25601673F, 0.21893501F, 0.3189144F,
    0.13166237F, 0.23164177F,
    0.18974781F, 0.2897272F, 0.26404F, 0.36402035F,
    0.13566303F, 0.23564339F,
    0.22876453F, 0.32874393F, 0.31445217F, 0.41443253F,
    0.14013577F, 0.24011517F,
    0.2677822F, 0.3677616F, 0.37017155F, 0.47015095F,
    0.1450777F, 0.24505806F,
    0.30679893F, 0.4067793F, 0.42747974F, 0.52745914F,
    0.15049171F, 0.25047112F,
    0.35112286F, 0.45110226F, 0.4794817F, 0.5794611F,
    0.15637589F, 0.2563553F,
    0.40075302F, 0.5007334F, 0.52617645F, 0.62615585F,
    0.16273117F, 0.26271057F,
    0.45569038F, 0.5556698F, 0.56756496F, 0.6675453F,
    0.16955662F, 0.26953602F,
    0.515934F, 0.6159134F, 0.60364723F, 0.70362663F,
    0.17684937F, 0.27682972F,
    0.58148384F, 0.68146324F, 0.63442326F, 0.73440266F,
    0.18391037F, 0.28389072F,
    0.6504564F, 0.7504358F, 0.6598921F, 0.7598715F,
    0.19050121F, 0.2904806F,
    0.719429F, 0.8194084F, 0.68005466F, 0.78003407F,
    0.19662094F, 0.29660034F,
    0.7831068F, 0.88308716F, 0.694911F, 0.7948904F,
    0.20226955F, 0.30224895F,
    0.8414793F, 0.9414587F, 0.70446014F, 0.80443954F,
    0.207448F, 0.3074274F,
    0.8945446F, 0.994524F, 0.70870304F, 0.80868244F,
    0.21215534F, 0.31213474F,
    0.9423027F, 1.042283F, 0.7076397F, 0.8076191F,
    0.21639156F, 0.31637192F,
    0.9847555F, 1.0847349F, 0.7025194F, 0.8024998F,
    0.22015762F, 0.32013702F,
    1.0219011F, 1.1218805F, 0.6974001F, 0.7973795F,
    0.22345257F, 0.32343292F,
    1.0537405F, 1.1537199F, 0.69228077F, 0.79226017F,
    0.22627735F, 0.32625675F,
    1.0802727F, 1.180253F, 0.6871605F, 0.78714085F,
    0.22863102F, 0.32861042F,
    1.1014996F, 1.201479F, 0.68204117F, 0.78202057F,
    0.23051357F, 0.33049393F,
    1.1174192F, 1.2173986F, 0.6769209F, 0.77690125F,
    0.23192596F, 0.33190632F,
    1.1280317F, 1.2280111F, 0.67180157F, 0.77178097F,
    0.23286724F, 0.3328476F,
    1.133338F, 1.2333183F, 0.66668224F, 0.76666164F,
    0.23333836F, 0.33331776F,
    1.133338F, 1.2333183F, 0.66668224F, 0.76666164F,
    0.23333836F, 0.33331776F,
    1.133338F, 1.2333183F, 0.66668224F, 0.76666164F,
    0.23333836F, 0.33331776F
};

/* lambda of v + lambda x, by component. */
static const drone_real drone_filter[3] = {
    0.98046875F, 0.98046875F, 0.78564453F
};

/* Gain k of the control law, by component. */
static const drone_real drone_gain[3] = {
    0.0525F, 0.0525F, 0.027F
};

/* Saturation of u, by component. */
static const drone_real drone_u_max[3] = {
    2.5F, 2.5F, 2.5F
};

/* Covered starts have x strictly above these bounds, by component. */
static const drone_real drone_start_lower[3] = {
    0.36504754F, 0.36504906F, 0.7650489F
};

/* Covered starts have x strictly below these bounds, by component. */
static const drone_real drone_start_upper[3] = {
    0.8349513F, 0.8349498F, 1.234951F
};

/* The same of v + lambda x: strictly above these bounds. */
static const drone_real drone_filtered_start_lower[3] = {
    0.37792072F, 0.37792224F, 0.621059F
};

/* The same of v + lambda x: strictly below these bounds. */
static const drone_real drone_filtered_start_upper[3] = {
    0.7986406F, 0.7986391F, 0.95023006F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 12 s).
 */
static inline void drone_segment(drone_real t, int32_t *row, drone_real *s)
{
    const bool positive = 0.0F < t;
    const drone_real started = positive ? t : 0.0F;
    const drone_real scaled = started * 2.6666667F;
    const bool early = scaled < 31.999998F;
    const drone_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const drone_real base = (drone_real)segment;
    const drone_real place = u - base;
    const int32_t first = segment * 6;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void drone_basis(drone_real s, drone_real *w0, drone_real *w1, drone_real *w2, drone_real *w3)
{
    const drone_real v0 = 1.0F - s;
    const drone_real v1 = v0 * v0;
    const drone_real v2 = v1 * v0;
    const drone_real v3 = v0 * s;
    const drone_real v4 = 1.0F + v3;
    const drone_real v5 = 3.0F * v4;
    const drone_real v6 = v0 * v5;
    const drone_real v7 = 1.0F + v6;
    const drone_real v8 = s * v5;
    const drone_real v9 = 1.0F + v8;
    const drone_real v10 = s * s;
    const drone_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void drone_basis_rate(drone_real s, drone_real *dw0, drone_real *dw1, drone_real *dw2,
                                    drone_real *dw3)
{
    const drone_real v0 = 1.0F - s;
    const drone_real v1 = v0 + v0;
    const drone_real v2 = v0 * v1;
    const drone_real v3 = v0 * v0;
    const drone_real v4 = v2 + v3;
    const drone_real v5 = -v4;
    const drone_real v6 = v0 - s;
    const drone_real v7 = 3.0F * v6;
    const drone_real v8 = v0 * v7;
    const drone_real v9 = v0 * s;
    const drone_real v10 = 1.0F + v9;
    const drone_real v11 = 3.0F * v10;
    const drone_real v12 = v8 - v11;
    const drone_real v13 = s * v7;
    const drone_real v14 = v11 + v13;
    const drone_real v15 = s + s;
    const drone_real v16 = s * v15;
    const drone_real v17 = s * s;
    const drone_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline drone_real drone_edge_at(int32_t at, drone_real w0, drone_real w1, drone_real w2, drone_real w3)
{
    const drone_real q0 = drone_coefficients[at];
    const int32_t at_1 = at + 6;
    const drone_real q1 = drone_coefficients[at_1];
    const int32_t at_2 = at + 12;
    const drone_real q2 = drone_coefficients[at_2];
    const int32_t at_3 = at + 18;
    const drone_real q3 = drone_coefficients[at_3];
    const drone_real v0 = w0 * q0;
    const drone_real v1 = w1 * q1;
    const drone_real v2 = v0 + v1;
    const drone_real v3 = w2 * q2;
    const drone_real v4 = w3 * q3;
    const drone_real v5 = v3 + v4;
    const drone_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline drone_real drone_normalized_error(drone_real a, drone_real b, drone_real width)
{
    const drone_real v0 = a - b;
    const drone_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void drone_transformed_error(drone_real a, drone_real b, drone_real *epsilon, drone_real *xi)
{
    const drone_real v0 = b / a;
    const drone_real v1 = logf(v0);
    const drone_real v2 = -v1;
    const drone_real v3 = 1.0F + v0;
    const drone_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline drone_real drone_law(drone_real k, drone_real xi, drone_real epsilon)
{
    const drone_real v0 = k * xi;
    const drone_real v1 = v0 * epsilon;
    const drone_real v2 = -v1;
    return v2;
}

void drone_tube(drone_real t, drone_real lower[DRONE_N], drone_real upper[DRONE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (drone_real)NAN;
            upper[j] = (drone_real)NAN;
        }
        return;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real w0;
    drone_real w1;
    drone_real w2;
    drone_real w3;
    drone_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_edge = drone_edge_at(lower_at, w0, w1, w2, w3);
        const drone_real upper_edge = drone_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void drone_tube_rate(drone_real t, drone_real lower_rate[DRONE_N], drone_real upper_rate[DRONE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower_rate[j] = (drone_real)NAN;
            upper_rate[j] = (drone_real)NAN;
        }
        return;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real dw0;
    drone_real dw1;
    drone_real dw2;
    drone_real dw3;
    drone_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 12.0F;
    const drone_real per_second = moving ? 2.6666667F : 0.0F;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_slope = drone_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const drone_real lower_speed = lower_slope * per_second;
        const drone_real upper_slope = drone_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const drone_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

void drone_filtered_tube(drone_real t, drone_real lower[DRONE_N], drone_real upper[DRONE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (drone_real)NAN;
            upper[j] = (drone_real)NAN;
        }
        return;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real w0;
    drone_real w1;
    drone_real w2;
    drone_real w3;
    drone_basis(s, &w0, &w1, &w2, &w3);
    drone_real dw0;
    drone_real dw1;
    drone_real dw2;
    drone_real dw3;
    drone_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_edge = drone_edge_at(lower_at, w0, w1, w2, w3);
        const drone_real upper_edge = drone_edge_at(upper_at, w0, w1, w2, w3);
        const drone_real lower_slope = drone_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const drone_real lower_rate = lower_slope * 2.6666667F;
        const drone_real upper_slope = drone_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const drone_real upper_rate = upper_slope * 2.6666667F;
        const drone_real filter_i = drone_filter[i];
        const drone_real lower_part = lower_edge * filter_i;
        const drone_real z_lower = lower_rate + lower_part;
        lower[i] = z_lower;
        const drone_real upper_part = upper_edge * filter_i;
        const drone_real z_upper = upper_rate + upper_part;
        upper[i] = z_upper;
    }
}

drone_status drone_control(drone_real t, const drone_real x[DRONE_N], const drone_real v[DRONE_N],
                           drone_real u[DRONE_N])
{
    const drone_real t_zero = t * 0.0F;
    drone_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const drone_real x_j = x[j];
        const drone_real x_zero = x_j * 0.0F;
        const drone_real zeros = zero + x_zero;
        zero = zeros;
    }
    drone_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const drone_real v_k = v[k];
        const drone_real v_zero = v_k * 0.0F;
        const drone_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 3; ++m) {
            u[m] = 0.0F;
        }
        return DRONE_BAD_INPUT;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real w0;
    drone_real w1;
    drone_real w2;
    drone_real w3;
    drone_basis(s, &w0, &w1, &w2, &w3);
    drone_real dw0;
    drone_real dw1;
    drone_real dw2;
    drone_real dw3;
    drone_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    bool outside = false;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_edge = drone_edge_at(lower_at, w0, w1, w2, w3);
        const drone_real upper_edge = drone_edge_at(upper_at, w0, w1, w2, w3);
        const drone_real lower_slope = drone_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const drone_real lower_rate = lower_slope * 2.6666667F;
        const drone_real upper_slope = drone_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const drone_real upper_rate = upper_slope * 2.6666667F;
        const drone_real x_i = x[i];
        const drone_real v_i = v[i];
        const drone_real width = upper_edge - lower_edge;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const drone_real v_width = upper_rate - lower_rate;
        const drone_real v_to_lower = v_i - lower_rate;
        const drone_real v_to_upper = upper_rate - v_i;
        const drone_real filter_i = drone_filter[i];
        const drone_real gain_i = drone_gain[i];
        const drone_real gain_minus = -gain_i;
        const drone_real width_part = width * filter_i;
        const drone_real z_width = v_width + width_part;
        const drone_real lower_part = to_lower * filter_i;
        const drone_real z_to_lower = v_to_lower + lower_part;
        const drone_real upper_part = to_upper * filter_i;
        const drone_real z_to_upper = v_to_upper + upper_part;
        const bool upper_nearer = z_to_upper < z_to_lower;
        const drone_real distance = upper_nearer ? z_to_upper : z_to_lower;
        const drone_real gain = upper_nearer ? gain_minus : gain_i;
        const drone_real smallest = z_width * 0.005F;
        const bool clear = smallest < distance;
        const drone_real to_nearer = clear ? distance : smallest;
        const drone_real to_farther = z_width - to_nearer;
        const bool x_above = 0.0F < to_lower;
        const bool x_below = 0.0F < to_upper;
        const bool x_inside = x_above && x_below;
        const bool z_inside = 0.0F < distance;
        const bool inside = z_inside && x_inside;
        const bool outside_next = inside ? outside : true;
        const drone_real u_limit = drone_u_max[i];
        drone_real epsilon;
        drone_real xi;
        drone_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const drone_real u_i = drone_law(gain, xi, epsilon);
        const drone_real u_min = -u_limit;
        const bool u_above = u_min < u_i;
        const drone_real u_raised = u_above ? u_i : u_min;
        const bool u_beyond = u_limit < u_raised;
        const drone_real u_limited = u_beyond ? u_limit : u_raised;
        u[i] = u_limited;
        outside = outside_next;
    }
    return outside ? DRONE_OUTSIDE_TUBE : DRONE_OK;
}

drone_real drone_margin(drone_real t, const drone_real x[DRONE_N], const drone_real v[DRONE_N])
{
    const drone_real t_zero = t * 0.0F;
    drone_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const drone_real x_j = x[j];
        const drone_real x_zero = x_j * 0.0F;
        const drone_real zeros = zero + x_zero;
        zero = zeros;
    }
    drone_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const drone_real v_k = v[k];
        const drone_real v_zero = v_k * 0.0F;
        const drone_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (drone_real)NAN;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real w0;
    drone_real w1;
    drone_real w2;
    drone_real w3;
    drone_basis(s, &w0, &w1, &w2, &w3);
    drone_real dw0;
    drone_real dw1;
    drone_real dw2;
    drone_real dw3;
    drone_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    drone_real margin = 0.5F;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_edge = drone_edge_at(lower_at, w0, w1, w2, w3);
        const drone_real upper_edge = drone_edge_at(upper_at, w0, w1, w2, w3);
        const drone_real lower_slope = drone_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const drone_real lower_rate = lower_slope * 2.6666667F;
        const drone_real upper_slope = drone_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const drone_real upper_rate = upper_slope * 2.6666667F;
        const drone_real x_i = x[i];
        const drone_real v_i = v[i];
        const drone_real width = upper_edge - lower_edge;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const drone_real v_width = upper_rate - lower_rate;
        const drone_real v_to_lower = v_i - lower_rate;
        const drone_real v_to_upper = upper_rate - v_i;
        const drone_real filter_i = drone_filter[i];
        const drone_real width_part = width * filter_i;
        const drone_real z_width = v_width + width_part;
        const drone_real lower_part = to_lower * filter_i;
        const drone_real z_to_lower = v_to_lower + lower_part;
        const drone_real upper_part = to_upper * filter_i;
        const drone_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const drone_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const drone_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0F);
        const drone_real margin_z = z_beyond ? (-1.0F) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const drone_real x_distance = x_nearer ? to_upper : to_lower;
        const drone_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const drone_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const drone_real smaller = x_smaller ? margin_x : margin_z;
        const bool less = smaller < margin;
        const drone_real margin_next = less ? smaller : margin;
        margin = margin_next;
    }
    return margin;
}

void drone_margins(drone_real t, const drone_real x[DRONE_N], const drone_real v[DRONE_N],
                   drone_real margin[DRONE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            margin[j] = (drone_real)NAN;
        }
        return;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real w0;
    drone_real w1;
    drone_real w2;
    drone_real w3;
    drone_basis(s, &w0, &w1, &w2, &w3);
    drone_real dw0;
    drone_real dw1;
    drone_real dw2;
    drone_real dw3;
    drone_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_edge = drone_edge_at(lower_at, w0, w1, w2, w3);
        const drone_real upper_edge = drone_edge_at(upper_at, w0, w1, w2, w3);
        const drone_real lower_slope = drone_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const drone_real lower_rate = lower_slope * 2.6666667F;
        const drone_real upper_slope = drone_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const drone_real upper_rate = upper_slope * 2.6666667F;
        const drone_real x_i = x[i];
        const drone_real v_i = v[i];
        const drone_real width = upper_edge - lower_edge;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const drone_real v_width = upper_rate - lower_rate;
        const drone_real v_to_lower = v_i - lower_rate;
        const drone_real v_to_upper = upper_rate - v_i;
        const drone_real filter_i = drone_filter[i];
        const drone_real width_part = width * filter_i;
        const drone_real z_width = v_width + width_part;
        const drone_real lower_part = to_lower * filter_i;
        const drone_real z_to_lower = v_to_lower + lower_part;
        const drone_real upper_part = to_upper * filter_i;
        const drone_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const drone_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const drone_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0F);
        const drone_real margin_z = z_beyond ? (-1.0F) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const drone_real x_distance = x_nearer ? to_upper : to_lower;
        const drone_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const drone_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const drone_real smaller = x_smaller ? margin_x : margin_z;
        margin[i] = smaller;
    }
}

bool drone_covered(const drone_real x[DRONE_N], const drone_real v[DRONE_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 3; ++i) {
        const drone_real x_i = x[i];
        const drone_real x_lower = drone_start_lower[i];
        const drone_real x_upper = drone_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const drone_real filter_i = drone_filter[i];
        const drone_real x_part = x_i * filter_i;
        const drone_real v_i = v[i];
        const drone_real z_i = v_i + x_part;
        const drone_real z_lower = drone_filtered_start_lower[i];
        const drone_real z_upper = drone_filtered_start_upper[i];
        const bool z_above = z_lower < z_i;
        const bool z_below = z_i < z_upper;
        const bool z_inside = z_above && z_below;
        const bool inside = x_inside && z_inside;
        const bool covered_next = inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void drone_transform(const drone_real lower[DRONE_N], const drone_real upper[DRONE_N],
                     const drone_real x[DRONE_N], drone_real e[DRONE_N], drone_real epsilon[DRONE_N],
                     drone_real xi[DRONE_N])
{
    for (int32_t i = 0; i < 3; ++i) {
        const drone_real lower_edge = lower[i];
        const drone_real upper_edge = upper[i];
        const drone_real x_i = x[i];
        const drone_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const drone_real safe_width = wide ? width : 9.536743e-7F;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const drone_real distance = upper_nearer ? to_upper : to_lower;
        const drone_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const drone_real smallest = safe_width * 0.005F;
        const drone_real widened = safe_width - width;
        const drone_real half = widened * 0.5F;
        const drone_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const drone_real to_nearer = clear ? safe_distance : smallest;
        const drone_real to_farther = safe_width - to_nearer;
        const drone_real a = upper_nearer ? to_farther : to_nearer;
        const drone_real b = upper_nearer ? to_nearer : to_farther;
        const drone_real e_i = drone_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const drone_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const drone_real e_limited = e_beyond ? 0.99F : e_raised;
        drone_real epsilon_nearer;
        drone_real xi_i;
        drone_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const drone_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const drone_real e_or_zero = empty ? 0.0F : e_limited;
        const drone_real e_out = finite ? e_or_zero : (drone_real)NAN;
        e[i] = e_out;
        const drone_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const drone_real epsilon_out = finite ? epsilon_or_zero : (drone_real)NAN;
        epsilon[i] = epsilon_out;
        const drone_real xi_or_zero = empty ? 0.0F : xi_i;
        const drone_real xi_out = finite ? xi_or_zero : (drone_real)NAN;
        xi[i] = xi_out;
    }
}
