/* base.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (base.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.02 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= [0.5, 0.53, 0.4], 0.85 <= g_ii <= 1.18, |g_ij| <= [0.05, 0.05, 0], x measured to 0.003, u acts at most 0.002
 * s after its sample, v measured to 0.01: |e| of v + lambda x < [0.8745, 0.8842, 0.8667], |u| <= [2.1, 2.5, 1.1].
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "base.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "base.c: float is not IEEE-754's here, for which rounding is bounded"
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
    0.10730171F, 0.1627016F, 0.10464764F, 0.16004753F,
    -0.03306961F, 0.033076286F,
    0.10065365F, 0.16863346F, 0.097691536F, 0.16433716F,
    -0.033450127F, 0.033446312F,
    0.090143204F, 0.1627016F, 0.10464764F, 0.1825409F,
    -0.03306961F, 0.033076286F,
    0.07963276F, 0.14490509F, 0.1255188F, 0.21465778F,
    -0.03192711F, 0.033143997F,
    0.06912136F, 0.124521255F, 0.16030216F, 0.26068878F,
    -0.030023575F, 0.03397274F,
    0.060599327F, 0.11599922F, 0.20899963F, 0.31054592F,
    -0.027359009F, 0.035562515F,
    0.063941F, 0.1193409F, 0.2716112F, 0.36040306F,
    -0.023932457F, 0.037914276F,
    0.07914734F, 0.13454723F, 0.34512043F, 0.41026115F,
    -0.019744873F, 0.041028023F,
    0.106217384F, 0.16161728F, 0.4047184F, 0.4601183F,
    -0.014795303F, 0.044901848F,
    0.14515209F, 0.20055199F, 0.4504032F, 0.5058031F,
    -0.009084702F, 0.049538612F,
    0.19595146F, 0.2513504F, 0.48217392F, 0.5375738F,
    -0.0026130676F, 0.054935455F,
    0.25861454F, 0.31401443F, 0.5000315F, 0.5554304F,
    0.004620552F, 0.061094284F,
    0.3239193F, 0.3793192F, 0.5039749F, 0.5593748F,
    0.012615204F, 0.068014145F,
    0.37736034F, 0.43276024F, 0.49400425F, 0.54940414F,
    0.020296097F, 0.07569599F,
    0.41893673F, 0.47433662F, 0.47012138F, 0.5255213F,
    0.028738976F, 0.08413887F,
    0.4486494F, 0.5040493F, 0.4323244F, 0.48772335F,
    0.03794384F, 0.093343735F,
    0.46649742F, 0.5218973F, 0.38061333F, 0.43601322F,
    0.047909737F, 0.10330963F,
    0.47248077F, 0.52788067F, 0.3149891F, 0.37038898F,
    0.058636665F, 0.11403656F,
    0.47828388F, 0.5336838F, 0.25667572F, 0.31207561F,
    0.07005787F, 0.12545776F,
    0.4959507F, 0.5513506F, 0.21227646F, 0.26767635F,
    0.08071709F, 0.13611698F,
    0.5254822F, 0.5808821F, 0.18179035F, 0.23719025F,
    0.09061527F, 0.14601517F,
    0.5668783F, 0.6222782F, 0.1652174F, 0.2206173F,
    0.099752426F, 0.15515232F,
    0.62013817F, 0.67553806F, 0.16255856F, 0.21795845F,
    0.108127594F, 0.16352749F,
    0.6852627F, 0.7406626F, 0.17381382F, 0.22921371F,
    0.11574173F, 0.17114162F,
    0.7486496F, 0.80404854F, 0.19898224F, 0.25438118F,
    0.12259483F, 0.17799473F,
    0.8001709F, 0.8555708F, 0.23806381F, 0.2934637F,
    0.12868595F, 0.18408585F,
    0.83982944F, 0.8952284F, 0.2910595F, 0.34645844F,
    0.13401604F, 0.18941498F,
    0.8676224F, 0.9230223F, 0.35796833F, 0.41336823F,
    0.13858414F, 0.19398403F,
    0.8835516F, 0.9389515F, 0.427536F, 0.4829359F,
    0.1423912F, 0.1977911F,
    0.8876171F, 0.943017F, 0.48319054F, 0.53859043F,
    0.14543629F, 0.20083618F,
    0.87981796F, 0.9352169F, 0.52493095F, 0.58033085F,
    0.14772129F, 0.20312023F,
    0.87053967F, 0.92593956F, 0.5527582F, 0.6081581F,
    0.14924335F, 0.20464325F,
    0.86126137F, 0.91666126F, 0.5666714F, 0.62207127F,
    0.15000534F, 0.20540524F,
    0.86126137F, 0.91666126F, 0.5666714F, 0.62207127F,
    0.15000534F, 0.20540524F,
    0.86126137F, 0.91666126F, 0.5666714F, 0.62207127F,
    0.15000534F, 0.20540524F
};

/* lambda of v + lambda x, by component. */
static const base_real base_filter[3] = {
    1.4306641F, 1.359375F, 1.0097656F
};

/* Gain k of the control law, by component. */
static const base_real base_gain[3] = {
    0.0927F, 0.144F, 0.0285F
};

/* Saturation of u, by component. */
static const base_real base_u_max[3] = {
    2.1F, 2.5F, 1.0999999F
};

/* Covered starts have x strictly above these bounds, by component. */
static const base_real base_start_lower[3] = {
    0.643048F, 0.6430497F, -0.15695125F
};

/* Covered starts have x strictly below these bounds, by component. */
static const base_real base_start_upper[3] = {
    0.9569486F, 0.95694876F, 0.15694934F
};

/* The same of v + lambda x: strictly above these bounds. */
static const base_real base_filtered_start_lower[3] = {
    0.8641004F, 0.88414896F, -0.14848176F
};

/* The same of v + lambda x: strictly below these bounds. */
static const base_real base_filtered_start_upper[3] = {
    1.3590685F, 1.3772235F, 0.14847983F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 25 s).
 */
static inline void base_segment(base_real t, int32_t *row, base_real *s)
{
    const bool positive = 0.0F < t;
    const base_real started = positive ? t : 0.0F;
    const base_real scaled = started * 1.28F;
    const bool early = scaled < 31.999998F;
    const base_real u = early ? scaled : 31.999998F;
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
    const base_real v0 = 1.0F - s;
    const base_real v1 = v0 * v0;
    const base_real v2 = v1 * v0;
    const base_real v3 = v0 * s;
    const base_real v4 = 1.0F + v3;
    const base_real v5 = 3.0F * v4;
    const base_real v6 = v0 * v5;
    const base_real v7 = 1.0F + v6;
    const base_real v8 = s * v5;
    const base_real v9 = 1.0F + v8;
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
    const base_real v0 = 1.0F - s;
    const base_real v1 = v0 + v0;
    const base_real v2 = v0 * v1;
    const base_real v3 = v0 * v0;
    const base_real v4 = v2 + v3;
    const base_real v5 = -v4;
    const base_real v6 = v0 - s;
    const base_real v7 = 3.0F * v6;
    const base_real v8 = v0 * v7;
    const base_real v9 = v0 * s;
    const base_real v10 = 1.0F + v9;
    const base_real v11 = 3.0F * v10;
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
    const base_real v1 = logf(v0);
    const base_real v2 = -v1;
    const base_real v3 = 1.0F + v0;
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
    const bool moving = t < 25.0F;
    const base_real per_second = moving ? 1.28F : 0.0F;
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
        const base_real lower_rate = lower_slope * 1.28F;
        const base_real upper_slope = base_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const base_real upper_rate = upper_slope * 1.28F;
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
    const base_real t_zero = t * 0.0F;
    base_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const base_real x_j = x[j];
        const base_real x_zero = x_j * 0.0F;
        const base_real zeros = zero + x_zero;
        zero = zeros;
    }
    base_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const base_real v_k = v[k];
        const base_real v_zero = v_k * 0.0F;
        const base_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 3; ++m) {
            u[m] = 0.0F;
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
        const base_real lower_rate = lower_slope * 1.28F;
        const base_real upper_slope = base_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const base_real upper_rate = upper_slope * 1.28F;
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
        const base_real smallest = z_width * 0.005F;
        const bool clear = smallest < distance;
        const base_real to_nearer = clear ? distance : smallest;
        const base_real to_farther = z_width - to_nearer;
        const bool x_above = 0.0F < to_lower;
        const bool x_below = 0.0F < to_upper;
        const bool x_inside = x_above && x_below;
        const bool z_inside = 0.0F < distance;
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
    const base_real t_zero = t * 0.0F;
    base_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const base_real x_j = x[j];
        const base_real x_zero = x_j * 0.0F;
        const base_real zeros = zero + x_zero;
        zero = zeros;
    }
    base_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const base_real v_k = v[k];
        const base_real v_zero = v_k * 0.0F;
        const base_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0F;
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
    base_real margin = 0.5F;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const base_real lower_edge = base_edge_at(lower_at, w0, w1, w2, w3);
        const base_real upper_edge = base_edge_at(upper_at, w0, w1, w2, w3);
        const base_real lower_slope = base_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const base_real lower_rate = lower_slope * 1.28F;
        const base_real upper_slope = base_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const base_real upper_rate = upper_slope * 1.28F;
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
        const bool z_beyond = z_share < (-1.0F);
        const base_real margin_z = z_beyond ? (-1.0F) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const base_real x_distance = x_nearer ? to_upper : to_lower;
        const base_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const base_real margin_x = x_beyond ? (-1.0F) : x_share;
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
        const base_real lower_rate = lower_slope * 1.28F;
        const base_real upper_slope = base_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const base_real upper_rate = upper_slope * 1.28F;
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
        const bool z_beyond = z_share < (-1.0F);
        const base_real margin_z = z_beyond ? (-1.0F) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const base_real x_distance = x_nearer ? to_upper : to_lower;
        const base_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const base_real margin_x = x_beyond ? (-1.0F) : x_share;
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
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const base_real safe_width = wide ? width : 9.536743e-7F;
        const base_real to_lower = x_i - lower_edge;
        const base_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const base_real distance = upper_nearer ? to_upper : to_lower;
        const base_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const base_real smallest = safe_width * 0.005F;
        const base_real widened = safe_width - width;
        const base_real half = widened * 0.5F;
        const base_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const base_real to_nearer = clear ? safe_distance : smallest;
        const base_real to_farther = safe_width - to_nearer;
        const base_real a = upper_nearer ? to_farther : to_nearer;
        const base_real b = upper_nearer ? to_nearer : to_farther;
        const base_real e_i = base_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const base_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const base_real e_limited = e_beyond ? 0.99F : e_raised;
        base_real epsilon_nearer;
        base_real xi_i;
        base_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const base_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const base_real e_or_zero = empty ? 0.0F : e_limited;
        const base_real e_out = finite ? e_or_zero : (base_real)NAN;
        e[i] = e_out;
        const base_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const base_real epsilon_out = finite ? epsilon_or_zero : (base_real)NAN;
        epsilon[i] = epsilon_out;
        const base_real xi_or_zero = empty ? 0.0F : xi_i;
        const base_real xi_out = finite ? xi_or_zero : (base_real)NAN;
        xi[i] = xi_out;
    }
}
