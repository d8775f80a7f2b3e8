/* omni_heading.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (omni_heading.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "omni_heading.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "omni_heading.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "omni_heading.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "omni_heading.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "omni_heading.c: float is not IEEE-754's here, for which rounding is bounded"
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
static const omni_heading_real omni_heading_coefficients[210] = {
    -0.007575989F, 0.075737F, -0.03641796F, 0.046895027F,
    -0.016656876F, 0.016656876F,
    0.0000104904175F, 0.08332348F, 0.0000104904175F, 0.08332348F,
    -0.016656876F, 0.016656876F,
    0.0075969696F, 0.09090996F, 0.03643799F, 0.11975098F,
    -0.016656876F, 0.016656876F,
    0.015183449F, 0.09849644F, 0.072865486F, 0.15617847F,
    -0.016656876F, 0.016656876F,
    0.022769928F, 0.106082916F, 0.10929394F, 0.19260693F,
    -0.016656876F, 0.016656876F,
    0.030356407F, 0.113669395F, 0.14572144F, 0.22903442F,
    -0.016656876F, 0.016656876F,
    0.037941933F, 0.12125492F, 0.18214989F, 0.26546288F,
    -0.016656876F, 0.016656876F,
    0.045528412F, 0.1288414F, 0.21857738F, 0.30189037F,
    -0.016656876F, 0.016656876F,
    0.07834816F, 0.16166115F, 0.25500488F, 0.33831787F,
    -0.016656876F, 0.016656876F,
    0.11116791F, 0.1944809F, 0.29143238F, 0.37474537F,
    -0.016656876F, 0.016656876F,
    0.14398766F, 0.22730064F, 0.2914772F, 0.3747902F,
    -0.016656876F, 0.016656876F,
    0.1768074F, 0.2601204F, 0.29152107F, 0.37483406F,
    -0.016656876F, 0.016656876F,
    0.20962715F, 0.29294014F, 0.2915659F, 0.37487888F,
    -0.016656876F, 0.016656876F,
    0.2424469F, 0.3257599F, 0.29160976F, 0.37492275F,
    -0.016656876F, 0.016656876F,
    0.27526665F, 0.35857964F, 0.2916546F, 0.37496758F,
    -0.016656876F, 0.016656876F,
    0.3080864F, 0.39139938F, 0.29169846F, 0.37501144F,
    -0.016656876F, 0.016656876F,
    0.34090614F, 0.42421913F, 0.29174328F, 0.37505627F,
    -0.016656876F, 0.016656876F,
    0.3737259F, 0.45703888F, 0.29178715F, 0.37510014F,
    -0.016656876F, 0.016656876F,
    0.40654564F, 0.48985863F, 0.29183197F, 0.37514496F,
    -0.016656876F, 0.016656876F,
    0.4393654F, 0.5226784F, 0.2918768F, 0.37518978F,
    -0.016656876F, 0.016656876F,
    0.47218513F, 0.5554981F, 0.29192066F, 0.37523365F,
    -0.016656876F, 0.016656876F,
    0.5050049F, 0.5883179F, 0.32834816F, 0.41166115F,
    -0.016656876F, 0.016656876F,
    0.5378237F, 0.62113667F, 0.3647766F, 0.4480896F,
    -0.016656876F, 0.016656876F,
    0.5579748F, 0.6412878F, 0.4012041F, 0.4845171F,
    -0.016656876F, 0.016656876F,
    0.57812595F, 0.66143894F, 0.43763256F, 0.52094555F,
    -0.016656876F, 0.016656876F,
    0.5996113F, 0.6829243F, 0.47406006F, 0.55737305F,
    -0.016656876F, 0.016656876F,
    0.62109566F, 0.70440865F, 0.51048756F, 0.59380054F,
    -0.016656876F, 0.016656876F,
    0.642581F, 0.725894F, 0.546916F, 0.630229F,
    -0.016656876F, 0.016656876F,
    0.66406536F, 0.74737835F, 0.5833435F, 0.6666565F,
    -0.016656876F, 0.016656876F,
    0.6855507F, 0.7688637F, 0.619771F, 0.703084F,
    -0.016656876F, 0.016656876F,
    0.70703506F, 0.79034805F, 0.65619946F, 0.73951244F,
    -0.016656876F, 0.016656876F,
    0.7285204F, 0.8118334F, 0.69262695F, 0.77593994F,
    -0.016656876F, 0.016656876F,
    0.75000477F, 0.83331776F, 0.7290554F, 0.8123684F,
    -0.016656876F, 0.016656876F,
    0.75000477F, 0.83331776F, 0.7604799F, 0.8437929F,
    -0.016656876F, 0.016656876F,
    0.75000477F, 0.83331776F, 0.7290554F, 0.8123684F,
    -0.016656876F, 0.016656876F
};

/* Covered starts have x strictly above these bounds, by component. */
static const omni_heading_real omni_heading_start_lower[3] = {
    0.0025629282F, 0.0025619746F, -0.098941244F
};

/* Covered starts have x strictly below these bounds, by component. */
static const omni_heading_real omni_heading_start_upper[3] = {
    0.49744087F, 0.49743992F, 0.098941244F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 9 s).
 */
static inline void omni_heading_segment(omni_heading_real t, int32_t *row, omni_heading_real *s)
{
    const bool positive = 0.0F < t;
    const omni_heading_real started = positive ? t : 0.0F;
    const omni_heading_real scaled = started * 3.5555556F;
    const bool early = scaled < 31.999998F;
    const omni_heading_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const omni_heading_real base = (omni_heading_real)segment;
    const omni_heading_real place = u - base;
    const int32_t first = segment * 6;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void omni_heading_basis(omni_heading_real s, omni_heading_real *w0, omni_heading_real *w1,
                                      omni_heading_real *w2, omni_heading_real *w3)
{
    const omni_heading_real v0 = 1.0F - s;
    const omni_heading_real v1 = v0 * v0;
    const omni_heading_real v2 = v1 * v0;
    const omni_heading_real v3 = v0 * s;
    const omni_heading_real v4 = 1.0F + v3;
    const omni_heading_real v5 = 3.0F * v4;
    const omni_heading_real v6 = v0 * v5;
    const omni_heading_real v7 = 1.0F + v6;
    const omni_heading_real v8 = s * v5;
    const omni_heading_real v9 = 1.0F + v8;
    const omni_heading_real v10 = s * s;
    const omni_heading_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void omni_heading_basis_rate(omni_heading_real s, omni_heading_real *dw0, omni_heading_real *dw1,
                                           omni_heading_real *dw2, omni_heading_real *dw3)
{
    const omni_heading_real v0 = 1.0F - s;
    const omni_heading_real v1 = v0 + v0;
    const omni_heading_real v2 = v0 * v1;
    const omni_heading_real v3 = v0 * v0;
    const omni_heading_real v4 = v2 + v3;
    const omni_heading_real v5 = -v4;
    const omni_heading_real v6 = v0 - s;
    const omni_heading_real v7 = 3.0F * v6;
    const omni_heading_real v8 = v0 * v7;
    const omni_heading_real v9 = v0 * s;
    const omni_heading_real v10 = 1.0F + v9;
    const omni_heading_real v11 = 3.0F * v10;
    const omni_heading_real v12 = v8 - v11;
    const omni_heading_real v13 = s * v7;
    const omni_heading_real v14 = v11 + v13;
    const omni_heading_real v15 = s + s;
    const omni_heading_real v16 = s * v15;
    const omni_heading_real v17 = s * s;
    const omni_heading_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline omni_heading_real omni_heading_edge_at(int32_t at, omni_heading_real w0, omni_heading_real w1,
                                                     omni_heading_real w2, omni_heading_real w3)
{
    const omni_heading_real q0 = omni_heading_coefficients[at];
    const int32_t at_1 = at + 6;
    const omni_heading_real q1 = omni_heading_coefficients[at_1];
    const int32_t at_2 = at + 12;
    const omni_heading_real q2 = omni_heading_coefficients[at_2];
    const int32_t at_3 = at + 18;
    const omni_heading_real q3 = omni_heading_coefficients[at_3];
    const omni_heading_real v0 = w0 * q0;
    const omni_heading_real v1 = w1 * q1;
    const omni_heading_real v2 = v0 + v1;
    const omni_heading_real v3 = w2 * q2;
    const omni_heading_real v4 = w3 * q3;
    const omni_heading_real v5 = v3 + v4;
    const omni_heading_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline omni_heading_real omni_heading_normalized_error(omni_heading_real a, omni_heading_real b,
                                                              omni_heading_real width)
{
    const omni_heading_real v0 = a - b;
    const omni_heading_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void omni_heading_transformed_error(omni_heading_real a, omni_heading_real b,
                                                  omni_heading_real *epsilon, omni_heading_real *xi)
{
    const omni_heading_real v0 = b / a;
    const omni_heading_real v1 = logf(v0);
    const omni_heading_real v2 = -v1;
    const omni_heading_real v3 = 1.0F + v0;
    const omni_heading_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline omni_heading_real omni_heading_law(omni_heading_real k, omni_heading_real xi,
                                                 omni_heading_real epsilon)
{
    const omni_heading_real v0 = k * xi;
    const omni_heading_real v1 = v0 * epsilon;
    const omni_heading_real v2 = -v1;
    return v2;
}

void omni_heading_tube(omni_heading_real t, omni_heading_real lower[OMNI_HEADING_N],
                       omni_heading_real upper[OMNI_HEADING_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (omni_heading_real)NAN;
            upper[j] = (omni_heading_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_heading_real s;
    omni_heading_segment(t, &row, &s);
    omni_heading_real w0;
    omni_heading_real w1;
    omni_heading_real w2;
    omni_heading_real w3;
    omni_heading_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_heading_real lower_edge = omni_heading_edge_at(lower_at, w0, w1, w2, w3);
        const omni_heading_real upper_edge = omni_heading_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void omni_heading_tube_rate(omni_heading_real t, omni_heading_real lower_rate[OMNI_HEADING_N],
                            omni_heading_real upper_rate[OMNI_HEADING_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower_rate[j] = (omni_heading_real)NAN;
            upper_rate[j] = (omni_heading_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_heading_real s;
    omni_heading_segment(t, &row, &s);
    omni_heading_real dw0;
    omni_heading_real dw1;
    omni_heading_real dw2;
    omni_heading_real dw3;
    omni_heading_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 9.0F;
    const omni_heading_real per_second = moving ? 3.5555556F : 0.0F;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_heading_real lower_slope = omni_heading_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const omni_heading_real lower_speed = lower_slope * per_second;
        const omni_heading_real upper_slope = omni_heading_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const omni_heading_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

omni_heading_status omni_heading_control(omni_heading_real t, const omni_heading_real x[OMNI_HEADING_N],
                                         omni_heading_real u[OMNI_HEADING_N])
{
    const omni_heading_real t_zero = t * 0.0F;
    omni_heading_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const omni_heading_real x_j = x[j];
        const omni_heading_real x_zero = x_j * 0.0F;
        const omni_heading_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 3; ++m) {
            u[m] = 0.0F;
        }
        return OMNI_HEADING_BAD_INPUT;
    }
    int32_t row;
    omni_heading_real s;
    omni_heading_segment(t, &row, &s);
    omni_heading_real w0;
    omni_heading_real w1;
    omni_heading_real w2;
    omni_heading_real w3;
    omni_heading_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_heading_real lower_edge = omni_heading_edge_at(lower_at, w0, w1, w2, w3);
        const omni_heading_real upper_edge = omni_heading_edge_at(upper_at, w0, w1, w2, w3);
        const omni_heading_real x_i = x[i];
        const omni_heading_real width = upper_edge - lower_edge;
        const omni_heading_real to_lower = x_i - lower_edge;
        const omni_heading_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_heading_real distance = upper_nearer ? to_upper : to_lower;
        const omni_heading_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const omni_heading_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const omni_heading_real to_nearer = clear ? distance : smallest;
        const omni_heading_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        omni_heading_real epsilon;
        omni_heading_real xi;
        omni_heading_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const omni_heading_real u_i = omni_heading_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? OMNI_HEADING_OUTSIDE_TUBE : OMNI_HEADING_OK;
}

omni_heading_real omni_heading_margin(omni_heading_real t, const omni_heading_real x[OMNI_HEADING_N])
{
    const omni_heading_real t_zero = t * 0.0F;
    omni_heading_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const omni_heading_real x_j = x[j];
        const omni_heading_real x_zero = x_j * 0.0F;
        const omni_heading_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (omni_heading_real)NAN;
    }
    int32_t row;
    omni_heading_real s;
    omni_heading_segment(t, &row, &s);
    omni_heading_real w0;
    omni_heading_real w1;
    omni_heading_real w2;
    omni_heading_real w3;
    omni_heading_basis(s, &w0, &w1, &w2, &w3);
    omni_heading_real margin = 0.5F;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_heading_real lower_edge = omni_heading_edge_at(lower_at, w0, w1, w2, w3);
        const omni_heading_real upper_edge = omni_heading_edge_at(upper_at, w0, w1, w2, w3);
        const omni_heading_real x_i = x[i];
        const omni_heading_real width = upper_edge - lower_edge;
        const omni_heading_real to_lower = x_i - lower_edge;
        const omni_heading_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_heading_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_heading_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const omni_heading_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const omni_heading_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void omni_heading_margins(omni_heading_real t, const omni_heading_real x[OMNI_HEADING_N],
                          omni_heading_real margin[OMNI_HEADING_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            margin[j] = (omni_heading_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_heading_real s;
    omni_heading_segment(t, &row, &s);
    omni_heading_real w0;
    omni_heading_real w1;
    omni_heading_real w2;
    omni_heading_real w3;
    omni_heading_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_heading_real lower_edge = omni_heading_edge_at(lower_at, w0, w1, w2, w3);
        const omni_heading_real upper_edge = omni_heading_edge_at(upper_at, w0, w1, w2, w3);
        const omni_heading_real x_i = x[i];
        const omni_heading_real width = upper_edge - lower_edge;
        const omni_heading_real to_lower = x_i - lower_edge;
        const omni_heading_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_heading_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_heading_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const omni_heading_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool omni_heading_covered(const omni_heading_real x[OMNI_HEADING_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 3; ++i) {
        const omni_heading_real x_i = x[i];
        const omni_heading_real x_lower = omni_heading_start_lower[i];
        const omni_heading_real x_upper = omni_heading_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void omni_heading_transform(const omni_heading_real lower[OMNI_HEADING_N],
                            const omni_heading_real upper[OMNI_HEADING_N],
                            const omni_heading_real x[OMNI_HEADING_N], omni_heading_real e[OMNI_HEADING_N],
                            omni_heading_real epsilon[OMNI_HEADING_N], omni_heading_real xi[OMNI_HEADING_N])
{
    for (int32_t i = 0; i < 3; ++i) {
        const omni_heading_real lower_edge = lower[i];
        const omni_heading_real upper_edge = upper[i];
        const omni_heading_real x_i = x[i];
        const omni_heading_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const omni_heading_real safe_width = wide ? width : 9.536743e-7F;
        const omni_heading_real to_lower = x_i - lower_edge;
        const omni_heading_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_heading_real distance = upper_nearer ? to_upper : to_lower;
        const omni_heading_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const omni_heading_real smallest = safe_width * 0.005F;
        const omni_heading_real widened = safe_width - width;
        const omni_heading_real half = widened * 0.5F;
        const omni_heading_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const omni_heading_real to_nearer = clear ? safe_distance : smallest;
        const omni_heading_real to_farther = safe_width - to_nearer;
        const omni_heading_real a = upper_nearer ? to_farther : to_nearer;
        const omni_heading_real b = upper_nearer ? to_nearer : to_farther;
        const omni_heading_real e_i = omni_heading_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const omni_heading_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const omni_heading_real e_limited = e_beyond ? 0.99F : e_raised;
        omni_heading_real epsilon_nearer;
        omni_heading_real xi_i;
        omni_heading_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const omni_heading_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const omni_heading_real e_or_zero = empty ? 0.0F : e_limited;
        const omni_heading_real e_out = finite ? e_or_zero : (omni_heading_real)NAN;
        e[i] = e_out;
        const omni_heading_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const omni_heading_real epsilon_out = finite ? epsilon_or_zero : (omni_heading_real)NAN;
        epsilon[i] = epsilon_out;
        const omni_heading_real xi_or_zero = empty ? 0.0F : xi_i;
        const omni_heading_real xi_out = finite ? xi_or_zero : (omni_heading_real)NAN;
        xi[i] = xi_out;
    }
}
