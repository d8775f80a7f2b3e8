/* omni_s3.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (omni_s3.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "omni_s3.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "omni_s3.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "omni_s3.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "omni_s3.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "omni_s3.c: float is not IEEE-754's here, for which rounding is bounded"
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
 * Multiples of 2^-20: exact in float and double.
 */
static const omni_s3_real omni_s3_coefficients[140] = {
    0.67929554F, 0.7626085F, -0.022960663F, 0.060352325F,
    0.6666765F, 0.7499895F, 0.0000104904175F, 0.08332348F,
    0.65405846F, 0.73737144F, 0.02298069F, 0.10629368F,
    0.6414404F, 0.7247534F, 0.04595089F, 0.12926388F,
    0.6288223F, 0.7121353F, 0.06892109F, 0.15223408F,
    0.6162033F, 0.6995163F, 0.09189224F, 0.17520523F,
    0.60358524F, 0.68689823F, 0.11486244F, 0.19817543F,
    0.5909672F, 0.67428017F, 0.13783264F, 0.22114563F,
    0.57834816F, 0.66166115F, 0.16168118F, 0.24499416F,
    0.5657301F, 0.6490431F, 0.18553257F, 0.26884556F,
    0.55311203F, 0.636425F, 0.20938396F, 0.29269695F,
    0.54049397F, 0.62380695F, 0.2332344F, 0.3165474F,
    0.52787495F, 0.61118793F, 0.2570858F, 0.3403988F,
    0.5152569F, 0.59856987F, 0.28093624F, 0.36424923F,
    0.5215664F, 0.6048794F, 0.30478764F, 0.38810062F,
    0.52787495F, 0.61118793F, 0.32863808F, 0.41195107F,
    0.54049397F, 0.62380695F, 0.35248947F, 0.43580246F,
    0.55311203F, 0.636425F, 0.3763399F, 0.4596529F,
    0.5657301F, 0.6490431F, 0.4001913F, 0.4835043F,
    0.57834816F, 0.66166115F, 0.42404175F, 0.50735474F,
    0.5909672F, 0.67428017F, 0.44789314F, 0.53120613F,
    0.60358524F, 0.68689823F, 0.47174358F, 0.5550566F,
    0.6162033F, 0.6995163F, 0.49559498F, 0.57890797F,
    0.6288223F, 0.7121353F, 0.5194454F, 0.6027584F,
    0.6414404F, 0.7247534F, 0.5432968F, 0.6266098F,
    0.65405846F, 0.73737144F, 0.5671482F, 0.6504612F,
    0.6666765F, 0.7499895F, 0.59099865F, 0.67431164F,
    0.67929554F, 0.7626085F, 0.61485004F, 0.69816303F,
    0.6919136F, 0.7752266F, 0.6387005F, 0.7220135F,
    0.70453167F, 0.78784466F, 0.6625519F, 0.74586487F,
    0.7171507F, 0.8004637F, 0.6864023F, 0.7697153F,
    0.72976875F, 0.81308174F, 0.7102537F, 0.7935667F,
    0.7423868F, 0.8256998F, 0.73410416F, 0.81741714F,
    0.75381374F, 0.83712673F, 0.75795555F, 0.84126854F,
    0.7423868F, 0.8256998F, 0.73410416F, 0.81741714F
};

/* Covered starts have x strictly above these bounds, by component. */
static const omni_s3_real omni_s3_start_lower[2] = {
    4.00256F, 0.0025619746F
};

/* Covered starts have x strictly below these bounds, by component. */
static const omni_s3_real omni_s3_start_upper[2] = {
    4.497438F, 0.49743992F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 9 s).
 */
static inline void omni_s3_segment(omni_s3_real t, int32_t *row, omni_s3_real *s)
{
    const bool positive = 0.0F < t;
    const omni_s3_real started = positive ? t : 0.0F;
    const omni_s3_real scaled = started * 3.5555556F;
    const bool early = scaled < 31.999998F;
    const omni_s3_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const omni_s3_real base = (omni_s3_real)segment;
    const omni_s3_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void omni_s3_basis(omni_s3_real s, omni_s3_real *w0, omni_s3_real *w1, omni_s3_real *w2,
                                 omni_s3_real *w3)
{
    const omni_s3_real v0 = 1.0F - s;
    const omni_s3_real v1 = v0 * v0;
    const omni_s3_real v2 = v1 * v0;
    const omni_s3_real v3 = v0 * s;
    const omni_s3_real v4 = 1.0F + v3;
    const omni_s3_real v5 = 3.0F * v4;
    const omni_s3_real v6 = v0 * v5;
    const omni_s3_real v7 = 1.0F + v6;
    const omni_s3_real v8 = s * v5;
    const omni_s3_real v9 = 1.0F + v8;
    const omni_s3_real v10 = s * s;
    const omni_s3_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void omni_s3_basis_rate(omni_s3_real s, omni_s3_real *dw0, omni_s3_real *dw1, omni_s3_real *dw2,
                                      omni_s3_real *dw3)
{
    const omni_s3_real v0 = 1.0F - s;
    const omni_s3_real v1 = v0 + v0;
    const omni_s3_real v2 = v0 * v1;
    const omni_s3_real v3 = v0 * v0;
    const omni_s3_real v4 = v2 + v3;
    const omni_s3_real v5 = -v4;
    const omni_s3_real v6 = v0 - s;
    const omni_s3_real v7 = 3.0F * v6;
    const omni_s3_real v8 = v0 * v7;
    const omni_s3_real v9 = v0 * s;
    const omni_s3_real v10 = 1.0F + v9;
    const omni_s3_real v11 = 3.0F * v10;
    const omni_s3_real v12 = v8 - v11;
    const omni_s3_real v13 = s * v7;
    const omni_s3_real v14 = v11 + v13;
    const omni_s3_real v15 = s + s;
    const omni_s3_real v16 = s * v15;
    const omni_s3_real v17 = s * s;
    const omni_s3_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline omni_s3_real omni_s3_edge_at(int32_t at, omni_s3_real w0, omni_s3_real w1, omni_s3_real w2,
                                           omni_s3_real w3)
{
    const omni_s3_real q0 = omni_s3_coefficients[at];
    const int32_t at_1 = at + 4;
    const omni_s3_real q1 = omni_s3_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const omni_s3_real q2 = omni_s3_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const omni_s3_real q3 = omni_s3_coefficients[at_3];
    const omni_s3_real v0 = w0 * q0;
    const omni_s3_real v1 = w1 * q1;
    const omni_s3_real v2 = v0 + v1;
    const omni_s3_real v3 = w2 * q2;
    const omni_s3_real v4 = w3 * q3;
    const omni_s3_real v5 = v3 + v4;
    const omni_s3_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline omni_s3_real omni_s3_normalized_error(omni_s3_real a, omni_s3_real b, omni_s3_real width)
{
    const omni_s3_real v0 = a - b;
    const omni_s3_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void omni_s3_transformed_error(omni_s3_real a, omni_s3_real b, omni_s3_real *epsilon,
                                             omni_s3_real *xi)
{
    const omni_s3_real v0 = b / a;
    const omni_s3_real v1 = logf(v0);
    const omni_s3_real v2 = -v1;
    const omni_s3_real v3 = 1.0F + v0;
    const omni_s3_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline omni_s3_real omni_s3_law(omni_s3_real k, omni_s3_real xi, omni_s3_real epsilon)
{
    const omni_s3_real v0 = k * xi;
    const omni_s3_real v1 = v0 * epsilon;
    const omni_s3_real v2 = -v1;
    return v2;
}

void omni_s3_tube(omni_s3_real t, omni_s3_real lower[OMNI_S3_N], omni_s3_real upper[OMNI_S3_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (omni_s3_real)NAN;
            upper[j] = (omni_s3_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s3_real s;
    omni_s3_segment(t, &row, &s);
    omni_s3_real w0;
    omni_s3_real w1;
    omni_s3_real w2;
    omni_s3_real w3;
    omni_s3_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s3_real lower_edge = omni_s3_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s3_real upper_edge = omni_s3_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void omni_s3_tube_rate(omni_s3_real t, omni_s3_real lower_rate[OMNI_S3_N], omni_s3_real upper_rate[OMNI_S3_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (omni_s3_real)NAN;
            upper_rate[j] = (omni_s3_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s3_real s;
    omni_s3_segment(t, &row, &s);
    omni_s3_real dw0;
    omni_s3_real dw1;
    omni_s3_real dw2;
    omni_s3_real dw3;
    omni_s3_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 9.0F;
    const omni_s3_real per_second = moving ? 3.5555556F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s3_real lower_slope = omni_s3_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const omni_s3_real lower_speed = lower_slope * per_second;
        const omni_s3_real upper_slope = omni_s3_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const omni_s3_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

omni_s3_status omni_s3_control(omni_s3_real t, const omni_s3_real x[OMNI_S3_N], omni_s3_real u[OMNI_S3_N])
{
    const omni_s3_real t_zero = t * 0.0F;
    omni_s3_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s3_real x_j = x[j];
        const omni_s3_real x_zero = x_j * 0.0F;
        const omni_s3_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return OMNI_S3_BAD_INPUT;
    }
    int32_t row;
    omni_s3_real s;
    omni_s3_segment(t, &row, &s);
    omni_s3_real w0;
    omni_s3_real w1;
    omni_s3_real w2;
    omni_s3_real w3;
    omni_s3_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s3_real lower_edge = omni_s3_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s3_real upper_edge = omni_s3_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s3_real x_i = x[i];
        const omni_s3_real width = upper_edge - lower_edge;
        const omni_s3_real to_lower = x_i - lower_edge;
        const omni_s3_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s3_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s3_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const omni_s3_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const omni_s3_real to_nearer = clear ? distance : smallest;
        const omni_s3_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        omni_s3_real epsilon;
        omni_s3_real xi;
        omni_s3_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const omni_s3_real u_i = omni_s3_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? OMNI_S3_OUTSIDE_TUBE : OMNI_S3_OK;
}

omni_s3_real omni_s3_margin(omni_s3_real t, const omni_s3_real x[OMNI_S3_N])
{
    const omni_s3_real t_zero = t * 0.0F;
    omni_s3_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s3_real x_j = x[j];
        const omni_s3_real x_zero = x_j * 0.0F;
        const omni_s3_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (omni_s3_real)NAN;
    }
    int32_t row;
    omni_s3_real s;
    omni_s3_segment(t, &row, &s);
    omni_s3_real w0;
    omni_s3_real w1;
    omni_s3_real w2;
    omni_s3_real w3;
    omni_s3_basis(s, &w0, &w1, &w2, &w3);
    omni_s3_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s3_real lower_edge = omni_s3_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s3_real upper_edge = omni_s3_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s3_real x_i = x[i];
        const omni_s3_real width = upper_edge - lower_edge;
        const omni_s3_real to_lower = x_i - lower_edge;
        const omni_s3_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s3_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s3_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const omni_s3_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const omni_s3_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void omni_s3_margins(omni_s3_real t, const omni_s3_real x[OMNI_S3_N], omni_s3_real margin[OMNI_S3_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (omni_s3_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s3_real s;
    omni_s3_segment(t, &row, &s);
    omni_s3_real w0;
    omni_s3_real w1;
    omni_s3_real w2;
    omni_s3_real w3;
    omni_s3_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s3_real lower_edge = omni_s3_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s3_real upper_edge = omni_s3_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s3_real x_i = x[i];
        const omni_s3_real width = upper_edge - lower_edge;
        const omni_s3_real to_lower = x_i - lower_edge;
        const omni_s3_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s3_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s3_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const omni_s3_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool omni_s3_covered(const omni_s3_real x[OMNI_S3_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s3_real x_i = x[i];
        const omni_s3_real x_lower = omni_s3_start_lower[i];
        const omni_s3_real x_upper = omni_s3_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void omni_s3_transform(const omni_s3_real lower[OMNI_S3_N], const omni_s3_real upper[OMNI_S3_N],
                       const omni_s3_real x[OMNI_S3_N], omni_s3_real e[OMNI_S3_N],
                       omni_s3_real epsilon[OMNI_S3_N], omni_s3_real xi[OMNI_S3_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s3_real lower_edge = lower[i];
        const omni_s3_real upper_edge = upper[i];
        const omni_s3_real x_i = x[i];
        const omni_s3_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const omni_s3_real safe_width = wide ? width : 9.536743e-7F;
        const omni_s3_real to_lower = x_i - lower_edge;
        const omni_s3_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s3_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s3_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const omni_s3_real smallest = safe_width * 0.005F;
        const omni_s3_real widened = safe_width - width;
        const omni_s3_real half = widened * 0.5F;
        const omni_s3_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const omni_s3_real to_nearer = clear ? safe_distance : smallest;
        const omni_s3_real to_farther = safe_width - to_nearer;
        const omni_s3_real a = upper_nearer ? to_farther : to_nearer;
        const omni_s3_real b = upper_nearer ? to_nearer : to_farther;
        const omni_s3_real e_i = omni_s3_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const omni_s3_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const omni_s3_real e_limited = e_beyond ? 0.99F : e_raised;
        omni_s3_real epsilon_nearer;
        omni_s3_real xi_i;
        omni_s3_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const omni_s3_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const omni_s3_real e_or_zero = empty ? 0.0F : e_limited;
        const omni_s3_real e_out = finite ? e_or_zero : (omni_s3_real)NAN;
        e[i] = e_out;
        const omni_s3_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const omni_s3_real epsilon_out = finite ? epsilon_or_zero : (omni_s3_real)NAN;
        epsilon[i] = epsilon_out;
        const omni_s3_real xi_or_zero = empty ? 0.0F : xi_i;
        const omni_s3_real xi_out = finite ? xi_or_zero : (omni_s3_real)NAN;
        xi[i] = xi_out;
    }
}
