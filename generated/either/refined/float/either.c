/* either.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (either.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * Every x(t) that stays in the tube satisfies the mission (P10): eventually[8, 9.5] (T1 or T2); times are seconds of
 * t. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.158 s.
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
    0.61115265F, 0.7837944F, 0.6405182F, 0.81315994F,
    0.6667061F, 0.8332939F, 0.6667061F, 0.8332939F,
    0.72226334F, 0.8827896F, 0.6928978F, 0.8534241F,
    0.7778168F, 0.9322853F, 0.7190895F, 0.87355804F,
    0.833374F, 0.9817848F, 0.7452774F, 0.893692F,
    0.88892746F, 1.0312805F, 0.7714691F, 0.913826F,
    0.9444809F, 1.08078F, 0.7976608F, 0.93395615F,
    1.0000381F, 1.1302757F, 0.82385254F, 0.9540901F,
    1.0555916F, 1.1797752F, 0.85004044F, 0.9742241F,
    1.111145F, 1.2292709F, 0.87623215F, 0.99435425F,
    1.1667023F, 1.2787666F, 0.90242386F, 1.0144882F,
    1.2222557F, 1.3282661F, 0.92861176F, 1.0346222F,
    1.277813F, 1.3777618F, 0.95480347F, 1.0547562F,
    1.3333664F, 1.4333191F, 0.97493744F, 1.0748863F,
    1.3889198F, 1.4888725F, 0.9950714F, 1.0950203F,
    1.4444771F, 1.544426F, 1.0152016F, 1.1151543F,
    1.5000305F, 1.5999832F, 1.0353355F, 1.1352882F,
    1.5555878F, 1.6555367F, 1.0554695F, 1.1554184F,
    1.6111412F, 1.7110939F, 1.0755997F, 1.1755524F,
    1.6666946F, 1.7666473F, 1.0957336F, 1.1956863F,
    1.7222519F, 1.8222008F, 1.1158676F, 1.2158165F,
    1.7778053F, 1.877758F, 1.1360016F, 1.2359505F,
    1.8333626F, 1.9333115F, 1.1561317F, 1.2560844F,
    1.888916F, 1.9888687F, 1.1762657F, 1.2762184F,
    1.9444695F, 2.0444221F, 1.1963997F, 1.2963486F,
    2.0000267F, 2.0999756F, 1.2165337F, 1.3164825F,
    2.0555801F, 2.1555328F, 1.2366638F, 1.3366165F,
    2.1111374F, 2.2110863F, 1.2567978F, 1.3567505F,
    2.1666908F, 2.2666435F, 1.2769318F, 1.3768806F,
    2.2222443F, 2.322197F, 1.2970619F, 1.3970146F,
    2.2778015F, 2.3777504F, 1.3171959F, 1.4171486F,
    2.333355F, 2.4333076F, 1.333355F, 1.4333038F,
    2.3889008F, 2.4888535F, 1.3495102F, 1.4494629F,
    2.3887787F, 2.4887314F, 1.4000282F, 1.4999771F,
    2.3886604F, 2.4886093F, 1.4505539F, 1.5505028F,
    2.3885384F, 2.488491F, 1.5010796F, 1.6010284F,
    2.3884163F, 2.488369F, 1.5516052F, 1.6515579F,
    2.388298F, 2.488247F, 1.6021309F, 1.7020836F,
    2.388176F, 2.4881287F, 1.6526566F, 1.7526093F,
    2.3880577F, 2.4880066F, 1.7031822F, 1.8031349F,
    2.3879356F, 2.4878845F, 1.7537079F, 1.8536606F,
    2.3878136F, 2.4877663F, 1.8042374F, 1.9041862F,
    2.3876953F, 2.4876442F, 1.854763F, 1.9547119F,
    2.3875732F, 2.487526F, 1.9052887F, 2.0052376F,
    2.3874512F, 2.4874039F, 1.9558144F, 2.055767F,
    2.387333F, 2.4872818F, 2.00634F, 2.1062927F,
    2.3872108F, 2.4871635F, 2.0568657F, 2.1568184F,
    2.3870888F, 2.4870415F, 2.1073914F, 2.207344F,
    2.3869705F, 2.4869194F, 2.157917F, 2.2578697F,
    2.3868484F, 2.4868011F, 2.2084427F, 2.3083954F,
    2.3867302F, 2.486679F, 2.2589722F, 2.358921F,
    2.3866081F, 2.4865608F, 2.3094978F, 2.4094467F,
    2.386486F, 2.4864388F, 2.3600235F, 2.4599724F,
    2.4376144F, 2.5375671F, 2.4105492F, 2.5105019F,
    2.4887428F, 2.5886955F, 2.4610748F, 2.5610275F,
    2.5398712F, 2.63982F, 2.5116005F, 2.6115532F,
    2.5909996F, 2.6909485F, 2.5621262F, 2.6620789F,
    2.6421242F, 2.7420769F, 2.6126518F, 2.7126045F,
    2.6932526F, 2.7932053F, 2.6631813F, 2.7631302F,
    2.744381F, 2.8443336F, 2.713707F, 2.8136559F,
    2.7955093F, 2.895462F, 2.7642326F, 2.8641815F,
    2.8466377F, 2.9465866F, 2.8147583F, 2.914711F,
    2.897766F, 2.997715F, 2.865284F, 2.9652367F,
    2.9488907F, 3.0488434F, 2.9158096F, 3.0157623F,
    3.000019F, 3.0999718F, 2.9663353F, 3.066288F,
    3.000019F, 3.0999718F, 3.016861F, 3.1168137F,
    3.000019F, 3.0999718F, 2.9663353F, 3.066288F
};

/* Covered starts have x strictly above these bounds, by component. */
static const either_real either_start_lower[2] = {
    4.0052404F, 4.0052404F
};

/* Covered starts have x strictly below these bounds, by component. */
static const either_real either_start_upper[2] = {
    4.9947596F, 4.9947596F
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
