/* either.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (either.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * Every x(t) that stays in the tube satisfies the mission (P10): eventually[8, 9.5] (T1 or T2); times are seconds of
 * t. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.000274 s.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "either.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "either.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "either.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "either.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "either.c: float is not IEEE-754's here, for which rounding is bounded"
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
 * Multiples of 2^-18: exact in float and double.
 */
static const either_real either_coefficients[268] = {
    0.61457443F, 0.78722F, 0.6447334F, 0.817379F,
    0.6667061F, 0.8332939F, 0.6667061F, 0.8332939F,
    0.71883774F, 0.8793678F, 0.68867874F, 0.84920883F,
    0.7709732F, 0.92544174F, 0.7106552F, 0.86512375F,
    0.82310486F, 0.97151566F, 0.73262787F, 0.88103867F,
    0.8752365F, 1.0175896F, 0.7546005F, 0.8969536F,
    0.92736816F, 1.0636635F, 0.7765732F, 0.9128685F,
    0.9794998F, 1.1097374F, 0.79854584F, 0.92878723F,
    1.0316315F, 1.1558151F, 0.8205185F, 0.94470215F,
    1.0837631F, 1.201889F, 0.84249115F, 0.96061707F,
    1.1358948F, 1.247963F, 0.8644638F, 0.976532F,
    1.1880264F, 1.2940369F, 0.8864403F, 0.9924469F,
    1.2401619F, 1.3401108F, 0.90841293F, 1.0083618F,
    1.2922935F, 1.3922424F, 0.9303856F, 1.0303345F,
    1.3444252F, 1.4443741F, 0.95235825F, 1.0523071F,
    1.3965569F, 1.4965096F, 0.9743309F, 1.0742836F,
    1.4486885F, 1.5486412F, 0.99630356F, 1.0962563F,
    1.5008202F, 1.6007729F, 1.0182762F, 1.1182289F,
    1.5529518F, 1.6529045F, 1.0402489F, 1.1402016F,
    1.6050835F, 1.7050362F, 1.0622215F, 1.1621742F,
    1.6572151F, 1.7571678F, 1.084198F, 1.1841469F,
    1.7093506F, 1.8092995F, 1.1061707F, 1.2061195F,
    1.7614822F, 1.8614311F, 1.1281433F, 1.2280922F,
    1.8136139F, 1.9135628F, 1.150116F, 1.2500687F,
    1.8657455F, 1.9656982F, 1.1720886F, 1.2720413F,
    1.9178772F, 2.01783F, 1.1940613F, 1.294014F,
    1.9700089F, 2.0699615F, 1.2160339F, 1.3159866F,
    2.0221405F, 2.1220932F, 1.2380066F, 1.3379593F,
    2.0742722F, 2.1742249F, 1.2599831F, 1.359932F,
    2.1264076F, 2.2263565F, 1.2819557F, 1.3819046F,
    2.1785393F, 2.2784882F, 1.3039284F, 1.4038773F,
    2.230671F, 2.3306198F, 1.325901F, 1.4258499F,
    2.2828026F, 2.3827515F, 1.3478737F, 1.4478264F,
    2.3349342F, 2.434887F, 1.398449F, 1.4984016F,
    2.3870544F, 2.4870071F, 1.4490242F, 1.5489769F,
    2.387024F, 2.4869766F, 1.4996033F, 1.5995522F,
    2.3869934F, 2.486946F, 1.5501785F, 1.6501274F,
    2.386963F, 2.4869156F, 1.6007538F, 1.7007065F,
    2.3869324F, 2.486885F, 1.651329F, 1.7512817F,
    2.3869019F, 2.4868546F, 1.7019043F, 1.801857F,
    2.3868713F, 2.486824F, 1.7524834F, 1.8524323F,
    2.3868408F, 2.4867935F, 1.8030586F, 1.9030075F,
    2.3868103F, 2.4867592F, 1.8536339F, 1.9535828F,
    2.3867798F, 2.4867287F, 1.9042091F, 2.0041618F,
    2.3867493F, 2.4866982F, 1.9547844F, 2.054737F,
    2.3867188F, 2.4866676F, 2.0053596F, 2.1053123F,
    2.3866882F, 2.486637F, 2.0559387F, 2.1558876F,
    2.3866577F, 2.4866066F, 2.106514F, 2.2064629F,
    2.3866272F, 2.486576F, 2.1570892F, 2.257042F,
    2.3865929F, 2.4865456F, 2.2076645F, 2.3076172F,
    2.3865623F, 2.486515F, 2.2582397F, 2.3581924F,
    2.3865318F, 2.4864845F, 2.3088188F, 2.4087677F,
    2.3865013F, 2.486454F, 2.359394F, 2.459343F,
    2.4376297F, 2.5375786F, 2.4099693F, 2.509922F,
    2.4887543F, 2.588707F, 2.4605446F, 2.5604973F,
    2.5398827F, 2.6398315F, 2.5111198F, 2.6110725F,
    2.5910072F, 2.69096F, 2.561695F, 2.6616478F,
    2.6421356F, 2.7420845F, 2.6122742F, 2.712223F,
    2.6932602F, 2.793213F, 2.6628494F, 2.7627983F,
    2.7443886F, 2.8443375F, 2.7134247F, 2.8133774F,
    2.7955132F, 2.8954659F, 2.764F, 2.8639526F,
    2.8466415F, 2.9465904F, 2.8145752F, 2.914528F,
    2.897766F, 2.9977188F, 2.8651543F, 2.9651031F,
    2.9488945F, 3.0488434F, 2.9157295F, 3.0156784F,
    3.000019F, 3.0999718F, 2.9663048F, 3.0662575F,
    3.000019F, 3.0999718F, 3.01688F, 3.116829F,
    3.000019F, 3.0999718F, 2.9663048F, 3.0662575F
};

/* Covered starts have x strictly above these bounds, by component. */
static const either_real either_start_lower[2] = {
    4.0052366F, 4.0052366F
};

/* Covered starts have x strictly below these bounds, by component. */
static const either_real either_start_upper[2] = {
    4.9947634F, 4.9947634F
};

/* Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 64 (t_c = 18 s).
 */
static inline void either_segment(either_real t, int32_t *row, either_real *s)
{
    const bool positive = 0.0F < t;
    const either_real started = positive ? t : 0.0F;
    const either_real scaled = started * 3.5555556F;
    const bool early = scaled < 63.999996F;
    const either_real u = early ? scaled : 63.999996F;
    const int32_t segment = (int32_t)u;
    const either_real base = (either_real)segment;
    const either_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void either_basis(either_real s, either_real *w0, either_real *w1, either_real *w2,
                                either_real *w3)
{
    const either_real v0 = 1.0F - s;
    const either_real v1 = v0 * v0;
    const either_real v2 = v1 * v0;
    const either_real v3 = v0 * s;
    const either_real v4 = 1.0F + v3;
    const either_real v5 = 3.0F * v4;
    const either_real v6 = v0 * v5;
    const either_real v7 = 1.0F + v6;
    const either_real v8 = s * v5;
    const either_real v9 = 1.0F + v8;
    const either_real v10 = s * s;
    const either_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void either_basis_rate(either_real s, either_real *dw0, either_real *dw1, either_real *dw2,
                                     either_real *dw3)
{
    const either_real v0 = 1.0F - s;
    const either_real v1 = v0 + v0;
    const either_real v2 = v0 * v1;
    const either_real v3 = v0 * v0;
    const either_real v4 = v2 + v3;
    const either_real v5 = -v4;
    const either_real v6 = v0 - s;
    const either_real v7 = 3.0F * v6;
    const either_real v8 = v0 * v7;
    const either_real v9 = v0 * s;
    const either_real v10 = 1.0F + v9;
    const either_real v11 = 3.0F * v10;
    const either_real v12 = v8 - v11;
    const either_real v13 = s * v7;
    const either_real v14 = v11 + v13;
    const either_real v15 = s + s;
    const either_real v16 = s * v15;
    const either_real v17 = s * s;
    const either_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline either_real either_edge_at(int32_t at, either_real w0, either_real w1, either_real w2,
                                         either_real w3)
{
    const either_real q0 = either_coefficients[at];
    const int32_t at_1 = at + 4;
    const either_real q1 = either_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const either_real q2 = either_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const either_real q3 = either_coefficients[at_3];
    const either_real v0 = w0 * q0;
    const either_real v1 = w1 * q1;
    const either_real v2 = v0 + v1;
    const either_real v3 = w2 * q2;
    const either_real v4 = w3 * q3;
    const either_real v5 = v3 + v4;
    const either_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline either_real either_normalized_error(either_real a, either_real b, either_real width)
{
    const either_real v0 = a - b;
    const either_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void either_transformed_error(either_real a, either_real b, either_real *epsilon, either_real *xi)
{
    const either_real v0 = b / a;
    const either_real v1 = logf(v0);
    const either_real v2 = -v1;
    const either_real v3 = 1.0F + v0;
    const either_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline either_real either_law(either_real k, either_real xi, either_real epsilon)
{
    const either_real v0 = k * xi;
    const either_real v1 = v0 * epsilon;
    const either_real v2 = -v1;
    return v2;
}

void either_tube(either_real t, either_real lower[EITHER_N], either_real upper[EITHER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (either_real)NAN;
            upper[j] = (either_real)NAN;
        }
        return;
    }
    int32_t row;
    either_real s;
    either_segment(t, &row, &s);
    either_real w0;
    either_real w1;
    either_real w2;
    either_real w3;
    either_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const either_real lower_edge = either_edge_at(lower_at, w0, w1, w2, w3);
        const either_real upper_edge = either_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void either_tube_rate(either_real t, either_real lower_rate[EITHER_N], either_real upper_rate[EITHER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (either_real)NAN;
            upper_rate[j] = (either_real)NAN;
        }
        return;
    }
    int32_t row;
    either_real s;
    either_segment(t, &row, &s);
    either_real dw0;
    either_real dw1;
    either_real dw2;
    either_real dw3;
    either_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 18.0F;
    const either_real per_second = moving ? 3.5555556F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const either_real lower_slope = either_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const either_real lower_speed = lower_slope * per_second;
        const either_real upper_slope = either_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const either_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

either_status either_control(either_real t, const either_real x[EITHER_N], either_real u[EITHER_N])
{
    const either_real t_zero = t * 0.0F;
    either_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const either_real x_j = x[j];
        const either_real x_zero = x_j * 0.0F;
        const either_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return EITHER_BAD_INPUT;
    }
    int32_t row;
    either_real s;
    either_segment(t, &row, &s);
    either_real w0;
    either_real w1;
    either_real w2;
    either_real w3;
    either_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const either_real lower_edge = either_edge_at(lower_at, w0, w1, w2, w3);
        const either_real upper_edge = either_edge_at(upper_at, w0, w1, w2, w3);
        const either_real x_i = x[i];
        const either_real width = upper_edge - lower_edge;
        const either_real to_lower = x_i - lower_edge;
        const either_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const either_real distance = upper_nearer ? to_upper : to_lower;
        const either_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const either_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const either_real to_nearer = clear ? distance : smallest;
        const either_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        either_real epsilon;
        either_real xi;
        either_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const either_real u_i = either_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? EITHER_OUTSIDE_TUBE : EITHER_OK;
}

either_real either_margin(either_real t, const either_real x[EITHER_N])
{
    const either_real t_zero = t * 0.0F;
    either_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const either_real x_j = x[j];
        const either_real x_zero = x_j * 0.0F;
        const either_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (either_real)NAN;
    }
    int32_t row;
    either_real s;
    either_segment(t, &row, &s);
    either_real w0;
    either_real w1;
    either_real w2;
    either_real w3;
    either_basis(s, &w0, &w1, &w2, &w3);
    either_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const either_real lower_edge = either_edge_at(lower_at, w0, w1, w2, w3);
        const either_real upper_edge = either_edge_at(upper_at, w0, w1, w2, w3);
        const either_real x_i = x[i];
        const either_real width = upper_edge - lower_edge;
        const either_real to_lower = x_i - lower_edge;
        const either_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const either_real x_distance = x_nearer ? to_upper : to_lower;
        const either_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const either_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const either_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void either_margins(either_real t, const either_real x[EITHER_N], either_real margin[EITHER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (either_real)NAN;
        }
        return;
    }
    int32_t row;
    either_real s;
    either_segment(t, &row, &s);
    either_real w0;
    either_real w1;
    either_real w2;
    either_real w3;
    either_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const either_real lower_edge = either_edge_at(lower_at, w0, w1, w2, w3);
        const either_real upper_edge = either_edge_at(upper_at, w0, w1, w2, w3);
        const either_real x_i = x[i];
        const either_real width = upper_edge - lower_edge;
        const either_real to_lower = x_i - lower_edge;
        const either_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const either_real x_distance = x_nearer ? to_upper : to_lower;
        const either_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const either_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool either_covered(const either_real x[EITHER_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const either_real x_i = x[i];
        const either_real x_lower = either_start_lower[i];
        const either_real x_upper = either_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void either_transform(const either_real lower[EITHER_N], const either_real upper[EITHER_N],
                      const either_real x[EITHER_N], either_real e[EITHER_N], either_real epsilon[EITHER_N],
                      either_real xi[EITHER_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const either_real lower_edge = lower[i];
        const either_real upper_edge = upper[i];
        const either_real x_i = x[i];
        const either_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const either_real safe_width = wide ? width : 9.536743e-7F;
        const either_real to_lower = x_i - lower_edge;
        const either_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const either_real distance = upper_nearer ? to_upper : to_lower;
        const either_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const either_real smallest = safe_width * 0.005F;
        const either_real widened = safe_width - width;
        const either_real half = widened * 0.5F;
        const either_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const either_real to_nearer = clear ? safe_distance : smallest;
        const either_real to_farther = safe_width - to_nearer;
        const either_real a = upper_nearer ? to_farther : to_nearer;
        const either_real b = upper_nearer ? to_nearer : to_farther;
        const either_real e_i = either_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const either_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const either_real e_limited = e_beyond ? 0.99F : e_raised;
        either_real epsilon_nearer;
        either_real xi_i;
        either_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const either_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const either_real e_or_zero = empty ? 0.0F : e_limited;
        const either_real e_out = finite ? e_or_zero : (either_real)NAN;
        e[i] = e_out;
        const either_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const either_real epsilon_out = finite ? epsilon_or_zero : (either_real)NAN;
        epsilon[i] = epsilon_out;
        const either_real xi_or_zero = empty ? 0.0F : xi_i;
        const either_real xi_out = finite ? xi_or_zero : (either_real)NAN;
        xi[i] = xi_out;
    }
}
