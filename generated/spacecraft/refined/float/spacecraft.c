/* spacecraft.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (spacecraft.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "spacecraft.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "spacecraft.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "spacecraft.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "spacecraft.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "spacecraft.c: float is not IEEE-754's here, for which rounding is bounded"
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
 * Multiples of 2^-21: exact in float and double.
 */
static const spacecraft_real spacecraft_coefficients[210] = {
    -0.019896507F, 0.08009291F, -0.0067162514F, 0.09327364F,
    0.05509281F, 0.1550827F,
    5.2452087e-6F, 0.099995136F, 5.2452087e-6F, 0.099995136F,
    0.06667185F, 0.16666174F,
    0.019906998F, 0.11989689F, 0.006726265F, 0.106716156F,
    0.07825041F, 0.1782403F,
    0.03980875F, 0.13979864F, 0.013447762F, 0.11343765F,
    0.089829445F, 0.18981934F,
    0.059710503F, 0.1597004F, 0.020168781F, 0.12015867F,
    0.10140848F, 0.20139837F,
    0.079612255F, 0.17960215F, 0.026890278F, 0.12688017F,
    0.11298704F, 0.21297693F,
    0.09951401F, 0.1995039F, 0.033611774F, 0.13360119F,
    0.12456608F, 0.22455597F,
    0.11941576F, 0.21940565F, 0.040332794F, 0.14032269F,
    0.13614511F, 0.236135F,
    0.13931799F, 0.2393074F, 0.04705429F, 0.14704418F,
    0.14772367F, 0.24771357F,
    0.15921974F, 0.25920963F, 0.05377531F, 0.1537652F,
    0.15930271F, 0.2592926F,
    0.1791215F, 0.2791114F, 0.060496807F, 0.1604867F,
    0.17088175F, 0.27087164F,
    0.19902325F, 0.29901314F, 0.06721783F, 0.16720772F,
    0.18246031F, 0.2824502F,
    0.218925F, 0.3189149F, 0.07393932F, 0.17392921F,
    0.19403934F, 0.29402924F,
    0.23882675F, 0.33881664F, 0.08066082F, 0.18065071F,
    0.20561838F, 0.30560827F,
    0.2587285F, 0.3587184F, 0.08738184F, 0.18737173F,
    0.21719694F, 0.31718683F,
    0.27863026F, 0.37862015F, 0.09410334F, 0.19409323F,
    0.22877598F, 0.32876587F,
    0.2985325F, 0.3985219F, 0.100824356F, 0.20081425F,
    0.24035501F, 0.3403449F,
    0.31843424F, 0.41842413F, 0.10754585F, 0.20753574F,
    0.25193357F, 0.35192347F,
    0.338336F, 0.43832588F, 0.1283412F, 0.22833061F,
    0.2635126F, 0.3635025F,
    0.35823774F, 0.45822763F, 0.14913607F, 0.24912596F,
    0.27509165F, 0.37508154F,
    0.37701368F, 0.4770031F, 0.16993141F, 0.26992083F,
    0.2866702F, 0.3866601F,
    0.39578915F, 0.49577904F, 0.19072628F, 0.29071617F,
    0.29824924F, 0.39823914F,
    0.4145651F, 0.514555F, 0.21152163F, 0.31151104F,
    0.30982828F, 0.4098177F,
    0.43334103F, 0.5333309F, 0.2323165F, 0.33230639F,
    0.32140684F, 0.42139673F,
    0.43334103F, 0.5333309F, 0.25311184F, 0.35310125F,
    0.33298588F, 0.43297577F,
    0.43334103F, 0.5333309F, 0.2739067F, 0.3738966F,
    0.3445649F, 0.44455433F,
    0.43334103F, 0.5333309F, 0.29470205F, 0.39469147F,
    0.35614347F, 0.45613337F,
    0.43334103F, 0.5333309F, 0.31549692F, 0.4154868F,
    0.3677225F, 0.4677124F,
    0.43334103F, 0.5333309F, 0.33629227F, 0.43628216F,
    0.37930155F, 0.47929096F,
    0.43334103F, 0.5333309F, 0.35708714F, 0.45707703F,
    0.3908801F, 0.49087F,
    0.43334103F, 0.5333309F, 0.37788248F, 0.47787237F,
    0.40245914F, 0.50244904F,
    0.43334103F, 0.5333309F, 0.39867735F, 0.49866724F,
    0.41403818F, 0.5140276F,
    0.43334103F, 0.5333309F, 0.4194727F, 0.5194626F,
    0.42561674F, 0.52560663F,
    0.43334103F, 0.5333309F, 0.44026756F, 0.54025745F,
    0.4371953F, 0.5371852F,
    0.43334103F, 0.5333309F, 0.4194727F, 0.5194626F,
    0.42561674F, 0.52560663F
};

/* Covered starts have x strictly above these bounds, by component. */
static const spacecraft_real spacecraft_start_lower[3] = {
    0.0030315472F, 0.0030310727F, 0.4030307F
};

/* Covered starts have x strictly below these bounds, by component. */
static const spacecraft_real spacecraft_start_upper[3] = {
    0.59697026F, 0.59697026F, 0.9969699F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 15 s).
 */
static inline void spacecraft_segment(spacecraft_real t, int32_t *row, spacecraft_real *s)
{
    const bool positive = 0.0F < t;
    const spacecraft_real started = positive ? t : 0.0F;
    const spacecraft_real scaled = started * 2.1333334F;
    const bool early = scaled < 31.999998F;
    const spacecraft_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const spacecraft_real base = (spacecraft_real)segment;
    const spacecraft_real place = u - base;
    const int32_t first = segment * 6;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void spacecraft_basis(spacecraft_real s, spacecraft_real *w0, spacecraft_real *w1,
                                    spacecraft_real *w2, spacecraft_real *w3)
{
    const spacecraft_real v0 = 1.0F - s;
    const spacecraft_real v1 = v0 * v0;
    const spacecraft_real v2 = v1 * v0;
    const spacecraft_real v3 = v0 * s;
    const spacecraft_real v4 = 1.0F + v3;
    const spacecraft_real v5 = 3.0F * v4;
    const spacecraft_real v6 = v0 * v5;
    const spacecraft_real v7 = 1.0F + v6;
    const spacecraft_real v8 = s * v5;
    const spacecraft_real v9 = 1.0F + v8;
    const spacecraft_real v10 = s * s;
    const spacecraft_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void spacecraft_basis_rate(spacecraft_real s, spacecraft_real *dw0, spacecraft_real *dw1,
                                         spacecraft_real *dw2, spacecraft_real *dw3)
{
    const spacecraft_real v0 = 1.0F - s;
    const spacecraft_real v1 = v0 + v0;
    const spacecraft_real v2 = v0 * v1;
    const spacecraft_real v3 = v0 * v0;
    const spacecraft_real v4 = v2 + v3;
    const spacecraft_real v5 = -v4;
    const spacecraft_real v6 = v0 - s;
    const spacecraft_real v7 = 3.0F * v6;
    const spacecraft_real v8 = v0 * v7;
    const spacecraft_real v9 = v0 * s;
    const spacecraft_real v10 = 1.0F + v9;
    const spacecraft_real v11 = 3.0F * v10;
    const spacecraft_real v12 = v8 - v11;
    const spacecraft_real v13 = s * v7;
    const spacecraft_real v14 = v11 + v13;
    const spacecraft_real v15 = s + s;
    const spacecraft_real v16 = s * v15;
    const spacecraft_real v17 = s * s;
    const spacecraft_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline spacecraft_real spacecraft_edge_at(int32_t at, spacecraft_real w0, spacecraft_real w1,
                                                 spacecraft_real w2, spacecraft_real w3)
{
    const spacecraft_real q0 = spacecraft_coefficients[at];
    const int32_t at_1 = at + 6;
    const spacecraft_real q1 = spacecraft_coefficients[at_1];
    const int32_t at_2 = at + 12;
    const spacecraft_real q2 = spacecraft_coefficients[at_2];
    const int32_t at_3 = at + 18;
    const spacecraft_real q3 = spacecraft_coefficients[at_3];
    const spacecraft_real v0 = w0 * q0;
    const spacecraft_real v1 = w1 * q1;
    const spacecraft_real v2 = v0 + v1;
    const spacecraft_real v3 = w2 * q2;
    const spacecraft_real v4 = w3 * q3;
    const spacecraft_real v5 = v3 + v4;
    const spacecraft_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline spacecraft_real spacecraft_normalized_error(spacecraft_real a, spacecraft_real b,
                                                          spacecraft_real width)
{
    const spacecraft_real v0 = a - b;
    const spacecraft_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void spacecraft_transformed_error(spacecraft_real a, spacecraft_real b, spacecraft_real *epsilon,
                                                spacecraft_real *xi)
{
    const spacecraft_real v0 = b / a;
    const spacecraft_real v1 = logf(v0);
    const spacecraft_real v2 = -v1;
    const spacecraft_real v3 = 1.0F + v0;
    const spacecraft_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline spacecraft_real spacecraft_law(spacecraft_real k, spacecraft_real xi, spacecraft_real epsilon)
{
    const spacecraft_real v0 = k * xi;
    const spacecraft_real v1 = v0 * epsilon;
    const spacecraft_real v2 = -v1;
    return v2;
}

void spacecraft_tube(spacecraft_real t, spacecraft_real lower[SPACECRAFT_N],
                     spacecraft_real upper[SPACECRAFT_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (spacecraft_real)NAN;
            upper[j] = (spacecraft_real)NAN;
        }
        return;
    }
    int32_t row;
    spacecraft_real s;
    spacecraft_segment(t, &row, &s);
    spacecraft_real w0;
    spacecraft_real w1;
    spacecraft_real w2;
    spacecraft_real w3;
    spacecraft_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const spacecraft_real lower_edge = spacecraft_edge_at(lower_at, w0, w1, w2, w3);
        const spacecraft_real upper_edge = spacecraft_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void spacecraft_tube_rate(spacecraft_real t, spacecraft_real lower_rate[SPACECRAFT_N],
                          spacecraft_real upper_rate[SPACECRAFT_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower_rate[j] = (spacecraft_real)NAN;
            upper_rate[j] = (spacecraft_real)NAN;
        }
        return;
    }
    int32_t row;
    spacecraft_real s;
    spacecraft_segment(t, &row, &s);
    spacecraft_real dw0;
    spacecraft_real dw1;
    spacecraft_real dw2;
    spacecraft_real dw3;
    spacecraft_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 15.0F;
    const spacecraft_real per_second = moving ? 2.1333334F : 0.0F;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const spacecraft_real lower_slope = spacecraft_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const spacecraft_real lower_speed = lower_slope * per_second;
        const spacecraft_real upper_slope = spacecraft_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const spacecraft_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

spacecraft_status spacecraft_control(spacecraft_real t, const spacecraft_real x[SPACECRAFT_N],
                                     spacecraft_real u[SPACECRAFT_N])
{
    const spacecraft_real t_zero = t * 0.0F;
    spacecraft_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const spacecraft_real x_j = x[j];
        const spacecraft_real x_zero = x_j * 0.0F;
        const spacecraft_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 3; ++m) {
            u[m] = 0.0F;
        }
        return SPACECRAFT_BAD_INPUT;
    }
    int32_t row;
    spacecraft_real s;
    spacecraft_segment(t, &row, &s);
    spacecraft_real w0;
    spacecraft_real w1;
    spacecraft_real w2;
    spacecraft_real w3;
    spacecraft_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const spacecraft_real lower_edge = spacecraft_edge_at(lower_at, w0, w1, w2, w3);
        const spacecraft_real upper_edge = spacecraft_edge_at(upper_at, w0, w1, w2, w3);
        const spacecraft_real x_i = x[i];
        const spacecraft_real width = upper_edge - lower_edge;
        const spacecraft_real to_lower = x_i - lower_edge;
        const spacecraft_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const spacecraft_real distance = upper_nearer ? to_upper : to_lower;
        const spacecraft_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const spacecraft_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const spacecraft_real to_nearer = clear ? distance : smallest;
        const spacecraft_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        spacecraft_real epsilon;
        spacecraft_real xi;
        spacecraft_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const spacecraft_real u_i = spacecraft_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? SPACECRAFT_OUTSIDE_TUBE : SPACECRAFT_OK;
}

spacecraft_real spacecraft_margin(spacecraft_real t, const spacecraft_real x[SPACECRAFT_N])
{
    const spacecraft_real t_zero = t * 0.0F;
    spacecraft_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const spacecraft_real x_j = x[j];
        const spacecraft_real x_zero = x_j * 0.0F;
        const spacecraft_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (spacecraft_real)NAN;
    }
    int32_t row;
    spacecraft_real s;
    spacecraft_segment(t, &row, &s);
    spacecraft_real w0;
    spacecraft_real w1;
    spacecraft_real w2;
    spacecraft_real w3;
    spacecraft_basis(s, &w0, &w1, &w2, &w3);
    spacecraft_real margin = 0.5F;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const spacecraft_real lower_edge = spacecraft_edge_at(lower_at, w0, w1, w2, w3);
        const spacecraft_real upper_edge = spacecraft_edge_at(upper_at, w0, w1, w2, w3);
        const spacecraft_real x_i = x[i];
        const spacecraft_real width = upper_edge - lower_edge;
        const spacecraft_real to_lower = x_i - lower_edge;
        const spacecraft_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const spacecraft_real x_distance = x_nearer ? to_upper : to_lower;
        const spacecraft_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const spacecraft_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const spacecraft_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void spacecraft_margins(spacecraft_real t, const spacecraft_real x[SPACECRAFT_N],
                        spacecraft_real margin[SPACECRAFT_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            margin[j] = (spacecraft_real)NAN;
        }
        return;
    }
    int32_t row;
    spacecraft_real s;
    spacecraft_segment(t, &row, &s);
    spacecraft_real w0;
    spacecraft_real w1;
    spacecraft_real w2;
    spacecraft_real w3;
    spacecraft_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const spacecraft_real lower_edge = spacecraft_edge_at(lower_at, w0, w1, w2, w3);
        const spacecraft_real upper_edge = spacecraft_edge_at(upper_at, w0, w1, w2, w3);
        const spacecraft_real x_i = x[i];
        const spacecraft_real width = upper_edge - lower_edge;
        const spacecraft_real to_lower = x_i - lower_edge;
        const spacecraft_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const spacecraft_real x_distance = x_nearer ? to_upper : to_lower;
        const spacecraft_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const spacecraft_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool spacecraft_covered(const spacecraft_real x[SPACECRAFT_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 3; ++i) {
        const spacecraft_real x_i = x[i];
        const spacecraft_real x_lower = spacecraft_start_lower[i];
        const spacecraft_real x_upper = spacecraft_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void spacecraft_transform(const spacecraft_real lower[SPACECRAFT_N], const spacecraft_real upper[SPACECRAFT_N],
                          const spacecraft_real x[SPACECRAFT_N], spacecraft_real e[SPACECRAFT_N],
                          spacecraft_real epsilon[SPACECRAFT_N], spacecraft_real xi[SPACECRAFT_N])
{
    for (int32_t i = 0; i < 3; ++i) {
        const spacecraft_real lower_edge = lower[i];
        const spacecraft_real upper_edge = upper[i];
        const spacecraft_real x_i = x[i];
        const spacecraft_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const spacecraft_real safe_width = wide ? width : 9.536743e-7F;
        const spacecraft_real to_lower = x_i - lower_edge;
        const spacecraft_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const spacecraft_real distance = upper_nearer ? to_upper : to_lower;
        const spacecraft_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const spacecraft_real smallest = safe_width * 0.005F;
        const spacecraft_real widened = safe_width - width;
        const spacecraft_real half = widened * 0.5F;
        const spacecraft_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const spacecraft_real to_nearer = clear ? safe_distance : smallest;
        const spacecraft_real to_farther = safe_width - to_nearer;
        const spacecraft_real a = upper_nearer ? to_farther : to_nearer;
        const spacecraft_real b = upper_nearer ? to_nearer : to_farther;
        const spacecraft_real e_i = spacecraft_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const spacecraft_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const spacecraft_real e_limited = e_beyond ? 0.99F : e_raised;
        spacecraft_real epsilon_nearer;
        spacecraft_real xi_i;
        spacecraft_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const spacecraft_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const spacecraft_real e_or_zero = empty ? 0.0F : e_limited;
        const spacecraft_real e_out = finite ? e_or_zero : (spacecraft_real)NAN;
        e[i] = e_out;
        const spacecraft_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const spacecraft_real epsilon_out = finite ? epsilon_or_zero : (spacecraft_real)NAN;
        epsilon[i] = epsilon_out;
        const spacecraft_real xi_or_zero = empty ? 0.0F : xi_i;
        const spacecraft_real xi_out = finite ? xi_or_zero : (spacecraft_real)NAN;
        xi[i] = xi_out;
    }
}
