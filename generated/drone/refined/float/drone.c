/* drone.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (drone.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.025 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= 0.35, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 0.005, u 0.004 s after its sample at most, the first
 * at once, v measured to 0.02: |e| of v + lambda x < 0.8001, |u| <= 2.5.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "drone.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "drone.c: compile without -ffast-math; it tests its inputs for NaN and infinity"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)
#error "drone.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
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
    0.383F, 0.383F, 0.154F
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

/* An edge of the tube (or its slope in spline time): sum of w_j q_j. */
static inline drone_real drone_blend(drone_real w0, drone_real w1, drone_real w2, drone_real w3, drone_real q0,
                                     drone_real q1, drone_real q2, drone_real q3)
{
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
        const int32_t at = row + pair;
        const drone_real lower_q0 = drone_coefficients[at];
        const int32_t lower_1 = at + 6;
        const drone_real lower_q1 = drone_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const drone_real lower_q2 = drone_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const drone_real lower_q3 = drone_coefficients[lower_3];
        const drone_real lower_edge = drone_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        lower[i] = lower_edge;
        const int32_t upper_0 = at + 1;
        const drone_real upper_q0 = drone_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const drone_real upper_q1 = drone_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const drone_real upper_q2 = drone_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const drone_real upper_q3 = drone_coefficients[upper_3];
        const drone_real upper_edge = drone_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
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
        const int32_t at = row + pair;
        const drone_real lower_q0 = drone_coefficients[at];
        const int32_t lower_1 = at + 6;
        const drone_real lower_q1 = drone_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const drone_real lower_q2 = drone_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const drone_real lower_q3 = drone_coefficients[lower_3];
        const drone_real lower_slope = drone_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const drone_real lower_speed = lower_slope * per_second;
        lower_rate[i] = lower_speed;
        const int32_t upper_0 = at + 1;
        const drone_real upper_q0 = drone_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const drone_real upper_q1 = drone_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const drone_real upper_q2 = drone_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const drone_real upper_q3 = drone_coefficients[upper_3];
        const drone_real upper_slope = drone_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const drone_real upper_speed = upper_slope * per_second;
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
        const int32_t at = row + pair;
        const drone_real lower_q0 = drone_coefficients[at];
        const int32_t lower_1 = at + 6;
        const drone_real lower_q1 = drone_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const drone_real lower_q2 = drone_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const drone_real lower_q3 = drone_coefficients[lower_3];
        const drone_real lower_edge = drone_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const drone_real lower_slope = drone_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const drone_real lower_rate = lower_slope * 2.6666667F;
        const int32_t upper_0 = at + 1;
        const drone_real upper_q0 = drone_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const drone_real upper_q1 = drone_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const drone_real upper_q2 = drone_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const drone_real upper_q3 = drone_coefficients[upper_3];
        const drone_real upper_edge = drone_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const drone_real upper_slope = drone_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const drone_real upper_rate = upper_slope * 2.6666667F;
        const drone_real filter_i = drone_filter[i];
        const drone_real filtered = lower_edge * filter_i;
        const drone_real edge = lower_rate + filtered;
        lower[i] = edge;
        const drone_real filtered2 = upper_edge * filter_i;
        const drone_real edge2 = upper_rate + filtered2;
        upper[i] = edge2;
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
    drone_real zero2 = zero;
    for (int32_t j2 = 0; j2 < 3; ++j2) {
        const drone_real v_j = v[j2];
        const drone_real v_zero = v_j * 0.0F;
        const drone_real zeros2 = zero2 + v_zero;
        zero2 = zeros2;
    }
    const bool finite = zero2 <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j3 = 0; j3 < 3; ++j3) {
            u[j3] = 0.0F;
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
        const int32_t at = row + pair;
        const drone_real lower_q0 = drone_coefficients[at];
        const int32_t lower_1 = at + 6;
        const drone_real lower_q1 = drone_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const drone_real lower_q2 = drone_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const drone_real lower_q3 = drone_coefficients[lower_3];
        const drone_real lower_edge = drone_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const drone_real lower_slope = drone_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const drone_real lower_rate = lower_slope * 2.6666667F;
        const int32_t upper_0 = at + 1;
        const drone_real upper_q0 = drone_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const drone_real upper_q1 = drone_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const drone_real upper_q2 = drone_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const drone_real upper_q3 = drone_coefficients[upper_3];
        const drone_real upper_edge = drone_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const drone_real upper_slope = drone_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const drone_real upper_rate = upper_slope * 2.6666667F;
        const drone_real x_i = x[i];
        const drone_real v_i = v[i];
        const drone_real room = upper_edge - lower_edge;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const drone_real room2 = upper_rate - lower_rate;
        const drone_real to_lower2 = v_i - lower_rate;
        const drone_real to_upper2 = upper_rate - v_i;
        const drone_real filter_i = drone_filter[i];
        const drone_real gain_i = drone_gain[i];
        const drone_real gain_minus = -gain_i;
        const drone_real filtered = room * filter_i;
        const drone_real room3 = room2 + filtered;
        const drone_real filtered2 = to_lower * filter_i;
        const drone_real to_lower3 = to_lower2 + filtered2;
        const drone_real filtered3 = to_upper * filter_i;
        const drone_real to_upper3 = to_upper2 + filtered3;
        const bool upper_nearer = to_upper3 < to_lower3;
        const drone_real nearest = upper_nearer ? to_upper3 : to_lower3;
        const drone_real gain = upper_nearer ? gain_minus : gain_i;
        const drone_real least = room3 * 0.005F;
        const bool clear = least < nearest;
        const drone_real near = clear ? nearest : least;
        const drone_real far = room3 - near;
        const bool over = 0.0F < to_lower;
        const bool under = 0.0F < to_upper;
        const bool between = over && under;
        const bool within = 0.0F < nearest;
        const bool inside = within && between;
        const bool outside_any = inside ? outside : true;
        const drone_real u_limit = drone_u_max[i];
        drone_real epsilon;
        drone_real xi;
        drone_transformed_error(near, far, &epsilon, &xi);
        const drone_real push = drone_law(gain, xi, epsilon);
        const drone_real u_min = -u_limit;
        const bool u_held_above = u_min < push;
        const drone_real u_held_raised = u_held_above ? push : u_min;
        const bool u_held_over = u_limit < u_held_raised;
        const drone_real u_held = u_held_over ? u_limit : u_held_raised;
        u[i] = u_held;
        outside = outside_any;
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
    drone_real zero2 = zero;
    for (int32_t j2 = 0; j2 < 3; ++j2) {
        const drone_real v_j = v[j2];
        const drone_real v_zero = v_j * 0.0F;
        const drone_real zeros2 = zero2 + v_zero;
        zero2 = zeros2;
    }
    const bool finite = zero2 <= 0.0F;
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
        const int32_t at = row + pair;
        const drone_real lower_q0 = drone_coefficients[at];
        const int32_t lower_1 = at + 6;
        const drone_real lower_q1 = drone_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const drone_real lower_q2 = drone_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const drone_real lower_q3 = drone_coefficients[lower_3];
        const drone_real lower_edge = drone_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const drone_real lower_slope = drone_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const drone_real lower_rate = lower_slope * 2.6666667F;
        const int32_t upper_0 = at + 1;
        const drone_real upper_q0 = drone_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const drone_real upper_q1 = drone_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const drone_real upper_q2 = drone_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const drone_real upper_q3 = drone_coefficients[upper_3];
        const drone_real upper_edge = drone_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const drone_real upper_slope = drone_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const drone_real upper_rate = upper_slope * 2.6666667F;
        const drone_real x_i = x[i];
        const drone_real v_i = v[i];
        const drone_real room = upper_edge - lower_edge;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const drone_real room2 = upper_rate - lower_rate;
        const drone_real to_lower2 = v_i - lower_rate;
        const drone_real to_upper2 = upper_rate - v_i;
        const drone_real filter_i = drone_filter[i];
        const drone_real filtered = room * filter_i;
        const drone_real room3 = room2 + filtered;
        const drone_real filtered2 = to_lower * filter_i;
        const drone_real to_lower3 = to_lower2 + filtered2;
        const drone_real filtered3 = to_upper * filter_i;
        const drone_real to_upper3 = to_upper2 + filtered3;
        const bool upper_nearer = to_upper3 < to_lower3;
        const drone_real nearest = upper_nearer ? to_upper3 : to_lower3;
        const drone_real share = nearest / room3;
        const bool beyond = share < (-1.0F);
        const drone_real held_share = beyond ? (-1.0F) : share;
        const bool upper_nearer2 = to_upper < to_lower;
        const drone_real nearest2 = upper_nearer2 ? to_upper : to_lower;
        const drone_real share2 = nearest2 / room;
        const bool beyond2 = share2 < (-1.0F);
        const drone_real held_share2 = beyond2 ? (-1.0F) : share2;
        const bool filtered_less = held_share < held_share2;
        const drone_real lesser = filtered_less ? held_share : held_share2;
        const bool less = lesser < margin;
        const drone_real margin_next = less ? lesser : margin;
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
        const int32_t at = row + pair;
        const drone_real lower_q0 = drone_coefficients[at];
        const int32_t lower_1 = at + 6;
        const drone_real lower_q1 = drone_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const drone_real lower_q2 = drone_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const drone_real lower_q3 = drone_coefficients[lower_3];
        const drone_real lower_edge = drone_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const drone_real lower_slope = drone_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const drone_real lower_rate = lower_slope * 2.6666667F;
        const int32_t upper_0 = at + 1;
        const drone_real upper_q0 = drone_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const drone_real upper_q1 = drone_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const drone_real upper_q2 = drone_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const drone_real upper_q3 = drone_coefficients[upper_3];
        const drone_real upper_edge = drone_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const drone_real upper_slope = drone_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const drone_real upper_rate = upper_slope * 2.6666667F;
        const drone_real x_i = x[i];
        const drone_real v_i = v[i];
        const drone_real room = upper_edge - lower_edge;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const drone_real room2 = upper_rate - lower_rate;
        const drone_real to_lower2 = v_i - lower_rate;
        const drone_real to_upper2 = upper_rate - v_i;
        const drone_real filter_i = drone_filter[i];
        const drone_real filtered = room * filter_i;
        const drone_real room3 = room2 + filtered;
        const drone_real filtered2 = to_lower * filter_i;
        const drone_real to_lower3 = to_lower2 + filtered2;
        const drone_real filtered3 = to_upper * filter_i;
        const drone_real to_upper3 = to_upper2 + filtered3;
        const bool upper_nearer = to_upper3 < to_lower3;
        const drone_real nearest = upper_nearer ? to_upper3 : to_lower3;
        const drone_real share = nearest / room3;
        const bool beyond = share < (-1.0F);
        const drone_real held_share = beyond ? (-1.0F) : share;
        const bool upper_nearer2 = to_upper < to_lower;
        const drone_real nearest2 = upper_nearer2 ? to_upper : to_lower;
        const drone_real share2 = nearest2 / room;
        const bool beyond2 = share2 < (-1.0F);
        const drone_real held_share2 = beyond2 ? (-1.0F) : share2;
        const bool filtered_less = held_share < held_share2;
        const drone_real lesser = filtered_less ? held_share : held_share2;
        margin[i] = lesser;
    }
}

bool drone_covered(const drone_real x[DRONE_N], const drone_real v[DRONE_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 3; ++i) {
        const drone_real x_i = x[i];
        const drone_real start_lower_i = drone_start_lower[i];
        const drone_real start_upper_i = drone_start_upper[i];
        const bool x_i_after = start_lower_i < x_i;
        const bool x_i_before = x_i < start_upper_i;
        const bool x_i_between = x_i_after && x_i_before;
        const drone_real filter_i = drone_filter[i];
        const drone_real filtered = x_i * filter_i;
        const drone_real v_i = v[i];
        const drone_real z = v_i + filtered;
        const drone_real filtered_start_lower_i = drone_filtered_start_lower[i];
        const drone_real filtered_start_upper_i = drone_filtered_start_upper[i];
        const bool z_after = filtered_start_lower_i < z;
        const bool z_before = z < filtered_start_upper_i;
        const bool z_between = z_after && z_before;
        const bool inside = x_i_between && z_between;
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
        const drone_real room = upper_edge - lower_edge;
        const bool filled = 0.0F < room;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < room;
        const drone_real width = wide ? room : 9.536743e-7F;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const drone_real nearest = upper_nearer ? to_upper : to_lower;
        const drone_real gain = upper_nearer ? (-1.0F) : 1.0F;
        const drone_real least = width * 0.005F;
        const drone_real widened = width - room;
        const drone_real spare = widened * 0.5F;
        const drone_real distance = nearest + spare;
        const bool farther = least < distance;
        const bool clear = filled && farther;
        const drone_real near = clear ? distance : least;
        const drone_real far = width - near;
        const drone_real a = upper_nearer ? far : near;
        const drone_real b = upper_nearer ? near : far;
        const drone_real e_raw = drone_normalized_error(a, b, width);
        const bool e_held_above = (-0.99F) < e_raw;
        const drone_real e_held_raised = e_held_above ? e_raw : (-0.99F);
        const bool e_held_over = 0.99F < e_held_raised;
        const drone_real e_held = e_held_over ? 0.99F : e_held_raised;
        drone_real epsilon_near;
        drone_real xi_i;
        drone_transformed_error(near, far, &epsilon_near, &xi_i);
        const drone_real epsilon_i = gain * epsilon_near;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_room = isfinite(room) != 0;
        const bool finite = finite_x && finite_room;
        const drone_real e_settled = empty ? 0.0F : e_held;
        const drone_real e_out = finite ? e_settled : (drone_real)NAN;
        e[i] = e_out;
        const drone_real epsilon_settled = empty ? 0.0F : epsilon_i;
        const drone_real epsilon_out = finite ? epsilon_settled : (drone_real)NAN;
        epsilon[i] = epsilon_out;
        const drone_real xi_settled = empty ? 0.0F : xi_i;
        const drone_real xi_out = finite ? xi_settled : (drone_real)NAN;
        xi[i] = xi_out;
    }
}
