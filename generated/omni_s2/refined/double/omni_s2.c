/* omni_s2.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (omni_s2.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "omni_s2.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "omni_s2.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "omni_s2.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "omni_s2.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "omni_s2.c: double is not IEEE-754's here, for which rounding is bounded"
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
static const omni_s2_real omni_s2_coefficients[140] = {
    -0.00757598876953125, 0.07573699951171875, -0.03641796112060547, 0.04689502716064453,
    0.00001049041748046875, 0.08332347869873047, 0.00001049041748046875, 0.08332347869873047,
    0.0075969696044921875, 0.09090995788574219, 0.03643798828125, 0.1197509765625,
    0.015183448791503906, 0.0984964370727539, 0.07286548614501953, 0.15617847442626953,
    0.022769927978515625, 0.10608291625976562, 0.10929393768310547, 0.19260692596435547,
    0.030356407165527344, 0.11366939544677734, 0.145721435546875, 0.229034423828125,
    0.037941932678222656, 0.12125492095947266, 0.18214988708496094, 0.26546287536621094,
    0.045528411865234375, 0.12884140014648438, 0.21857738494873047, 0.30189037322998047,
    0.07834815979003906, 0.16166114807128906, 0.2550048828125, 0.33831787109375,
    0.11116790771484375, 0.19448089599609375, 0.29143238067626953, 0.37474536895751953,
    0.14398765563964844, 0.22730064392089844, 0.2914772033691406, 0.3747901916503906,
    0.17680740356445312, 0.2601203918457031, 0.2915210723876953, 0.3748340606689453,
    0.2096271514892578, 0.2929401397705078, 0.2915658950805664, 0.3748788833618164,
    0.2424468994140625, 0.3257598876953125, 0.2916097640991211, 0.3749227523803711,
    0.2752666473388672, 0.3585796356201172, 0.2916545867919922, 0.3749675750732422,
    0.3080863952636719, 0.3913993835449219, 0.2916984558105469, 0.3750114440917969,
    0.34090614318847656, 0.42421913146972656, 0.29174327850341797, 0.37505626678466797,
    0.37372589111328125, 0.45703887939453125, 0.29178714752197266, 0.37510013580322266,
    0.40654563903808594, 0.48985862731933594, 0.29183197021484375, 0.37514495849609375,
    0.4393653869628906, 0.5226783752441406, 0.29187679290771484, 0.37518978118896484,
    0.4721851348876953, 0.5554981231689453, 0.29192066192626953, 0.37523365020751953,
    0.5050048828125, 0.58831787109375, 0.32834815979003906, 0.41166114807128906,
    0.5378236770629883, 0.6211366653442383, 0.364776611328125, 0.448089599609375,
    0.5579748153686523, 0.6412878036499023, 0.40120410919189453, 0.48451709747314453,
    0.5781259536743164, 0.6614389419555664, 0.43763256072998047, 0.5209455490112305,
    0.5996112823486328, 0.6829242706298828, 0.47406005859375, 0.557373046875,
    0.6210956573486328, 0.7044086456298828, 0.5104875564575195, 0.5938005447387695,
    0.6425809860229492, 0.7258939743041992, 0.5469160079956055, 0.6302289962768555,
    0.6640653610229492, 0.7473783493041992, 0.583343505859375, 0.666656494140625,
    0.6855506896972656, 0.7688636779785156, 0.6197710037231445, 0.7030839920043945,
    0.7070350646972656, 0.7903480529785156, 0.6561994552612305, 0.7395124435424805,
    0.728520393371582, 0.811833381652832, 0.692626953125, 0.77593994140625,
    0.750004768371582, 0.833317756652832, 0.7290554046630859, 0.8123683929443359,
    0.750004768371582, 0.833317756652832, 0.7604799270629883, 0.8437929153442383,
    0.750004768371582, 0.833317756652832, 0.7290554046630859, 0.8123683929443359
};

/* Covered starts have x strictly above these bounds, by component. */
static const omni_s2_real omni_s2_start_lower[2] = {
    0.002562332153321423, 0.0025613784790050166
};

/* Covered starts have x strictly below these bounds, by component. */
static const omni_s2_real omni_s2_start_upper[2] = {
    0.49744148254394416, 0.49744052886962775
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 9 s).
 */
static inline void omni_s2_segment(omni_s2_real t, int32_t *row, omni_s2_real *s)
{
    const bool positive = 0.0 < t;
    const omni_s2_real started = positive ? t : 0.0;
    const omni_s2_real scaled = started * 3.5555555555555554;
    const bool early = scaled < 31.999999999999996;
    const omni_s2_real u = early ? scaled : 31.999999999999996;
    const int32_t segment = (int32_t)u;
    const omni_s2_real base = (omni_s2_real)segment;
    const omni_s2_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void omni_s2_basis(omni_s2_real s, omni_s2_real *w0, omni_s2_real *w1, omni_s2_real *w2,
                                 omni_s2_real *w3)
{
    const omni_s2_real v0 = 1.0 - s;
    const omni_s2_real v1 = v0 * v0;
    const omni_s2_real v2 = v1 * v0;
    const omni_s2_real v3 = v0 * s;
    const omni_s2_real v4 = 1.0 + v3;
    const omni_s2_real v5 = 3.0 * v4;
    const omni_s2_real v6 = v0 * v5;
    const omni_s2_real v7 = 1.0 + v6;
    const omni_s2_real v8 = s * v5;
    const omni_s2_real v9 = 1.0 + v8;
    const omni_s2_real v10 = s * s;
    const omni_s2_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void omni_s2_basis_rate(omni_s2_real s, omni_s2_real *dw0, omni_s2_real *dw1, omni_s2_real *dw2,
                                      omni_s2_real *dw3)
{
    const omni_s2_real v0 = 1.0 - s;
    const omni_s2_real v1 = v0 + v0;
    const omni_s2_real v2 = v0 * v1;
    const omni_s2_real v3 = v0 * v0;
    const omni_s2_real v4 = v2 + v3;
    const omni_s2_real v5 = -v4;
    const omni_s2_real v6 = v0 - s;
    const omni_s2_real v7 = 3.0 * v6;
    const omni_s2_real v8 = v0 * v7;
    const omni_s2_real v9 = v0 * s;
    const omni_s2_real v10 = 1.0 + v9;
    const omni_s2_real v11 = 3.0 * v10;
    const omni_s2_real v12 = v8 - v11;
    const omni_s2_real v13 = s * v7;
    const omni_s2_real v14 = v11 + v13;
    const omni_s2_real v15 = s + s;
    const omni_s2_real v16 = s * v15;
    const omni_s2_real v17 = s * s;
    const omni_s2_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline omni_s2_real omni_s2_edge_at(int32_t at, omni_s2_real w0, omni_s2_real w1, omni_s2_real w2,
                                           omni_s2_real w3)
{
    const omni_s2_real q0 = omni_s2_coefficients[at];
    const int32_t at_1 = at + 4;
    const omni_s2_real q1 = omni_s2_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const omni_s2_real q2 = omni_s2_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const omni_s2_real q3 = omni_s2_coefficients[at_3];
    const omni_s2_real v0 = w0 * q0;
    const omni_s2_real v1 = w1 * q1;
    const omni_s2_real v2 = v0 + v1;
    const omni_s2_real v3 = w2 * q2;
    const omni_s2_real v4 = w3 * q3;
    const omni_s2_real v5 = v3 + v4;
    const omni_s2_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline omni_s2_real omni_s2_normalized_error(omni_s2_real a, omni_s2_real b, omni_s2_real width)
{
    const omni_s2_real v0 = a - b;
    const omni_s2_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void omni_s2_transformed_error(omni_s2_real a, omni_s2_real b, omni_s2_real *epsilon,
                                             omni_s2_real *xi)
{
    const omni_s2_real v0 = b / a;
    const omni_s2_real v1 = log(v0);
    const omni_s2_real v2 = -v1;
    const omni_s2_real v3 = 1.0 + v0;
    const omni_s2_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline omni_s2_real omni_s2_law(omni_s2_real k, omni_s2_real xi, omni_s2_real epsilon)
{
    const omni_s2_real v0 = k * xi;
    const omni_s2_real v1 = v0 * epsilon;
    const omni_s2_real v2 = -v1;
    return v2;
}

void omni_s2_tube(omni_s2_real t, omni_s2_real lower[OMNI_S2_N], omni_s2_real upper[OMNI_S2_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (omni_s2_real)NAN;
            upper[j] = (omni_s2_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s2_real s;
    omni_s2_segment(t, &row, &s);
    omni_s2_real w0;
    omni_s2_real w1;
    omni_s2_real w2;
    omni_s2_real w3;
    omni_s2_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s2_real lower_edge = omni_s2_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s2_real upper_edge = omni_s2_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void omni_s2_tube_rate(omni_s2_real t, omni_s2_real lower_rate[OMNI_S2_N], omni_s2_real upper_rate[OMNI_S2_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (omni_s2_real)NAN;
            upper_rate[j] = (omni_s2_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s2_real s;
    omni_s2_segment(t, &row, &s);
    omni_s2_real dw0;
    omni_s2_real dw1;
    omni_s2_real dw2;
    omni_s2_real dw3;
    omni_s2_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 9.0;
    const omni_s2_real per_second = moving ? 3.5555555555555554 : 0.0;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s2_real lower_slope = omni_s2_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const omni_s2_real lower_speed = lower_slope * per_second;
        const omni_s2_real upper_slope = omni_s2_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const omni_s2_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

omni_s2_status omni_s2_control(omni_s2_real t, const omni_s2_real x[OMNI_S2_N], omni_s2_real u[OMNI_S2_N])
{
    const omni_s2_real t_zero = t * 0.0;
    omni_s2_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s2_real x_j = x[j];
        const omni_s2_real x_zero = x_j * 0.0;
        const omni_s2_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
        }
        return OMNI_S2_BAD_INPUT;
    }
    int32_t row;
    omni_s2_real s;
    omni_s2_segment(t, &row, &s);
    omni_s2_real w0;
    omni_s2_real w1;
    omni_s2_real w2;
    omni_s2_real w3;
    omni_s2_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s2_real lower_edge = omni_s2_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s2_real upper_edge = omni_s2_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s2_real x_i = x[i];
        const omni_s2_real width = upper_edge - lower_edge;
        const omni_s2_real to_lower = x_i - lower_edge;
        const omni_s2_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s2_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s2_real gain = upper_nearer ? (-0.5) : 0.5;
        const omni_s2_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const omni_s2_real to_nearer = clear ? distance : smallest;
        const omni_s2_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
        const bool outside_next = inside ? outside : true;
        omni_s2_real epsilon;
        omni_s2_real xi;
        omni_s2_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const omni_s2_real u_i = omni_s2_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? OMNI_S2_OUTSIDE_TUBE : OMNI_S2_OK;
}

omni_s2_real omni_s2_margin(omni_s2_real t, const omni_s2_real x[OMNI_S2_N])
{
    const omni_s2_real t_zero = t * 0.0;
    omni_s2_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s2_real x_j = x[j];
        const omni_s2_real x_zero = x_j * 0.0;
        const omni_s2_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        return (omni_s2_real)NAN;
    }
    int32_t row;
    omni_s2_real s;
    omni_s2_segment(t, &row, &s);
    omni_s2_real w0;
    omni_s2_real w1;
    omni_s2_real w2;
    omni_s2_real w3;
    omni_s2_basis(s, &w0, &w1, &w2, &w3);
    omni_s2_real margin = 0.5;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s2_real lower_edge = omni_s2_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s2_real upper_edge = omni_s2_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s2_real x_i = x[i];
        const omni_s2_real width = upper_edge - lower_edge;
        const omni_s2_real to_lower = x_i - lower_edge;
        const omni_s2_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s2_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s2_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const omni_s2_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool less = margin_x < margin;
        const omni_s2_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void omni_s2_margins(omni_s2_real t, const omni_s2_real x[OMNI_S2_N], omni_s2_real margin[OMNI_S2_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (omni_s2_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s2_real s;
    omni_s2_segment(t, &row, &s);
    omni_s2_real w0;
    omni_s2_real w1;
    omni_s2_real w2;
    omni_s2_real w3;
    omni_s2_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s2_real lower_edge = omni_s2_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s2_real upper_edge = omni_s2_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s2_real x_i = x[i];
        const omni_s2_real width = upper_edge - lower_edge;
        const omni_s2_real to_lower = x_i - lower_edge;
        const omni_s2_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s2_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s2_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const omni_s2_real margin_x = x_beyond ? (-1.0) : x_share;
        margin[i] = margin_x;
    }
}

bool omni_s2_covered(const omni_s2_real x[OMNI_S2_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s2_real x_i = x[i];
        const omni_s2_real x_lower = omni_s2_start_lower[i];
        const omni_s2_real x_upper = omni_s2_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void omni_s2_transform(const omni_s2_real lower[OMNI_S2_N], const omni_s2_real upper[OMNI_S2_N],
                       const omni_s2_real x[OMNI_S2_N], omni_s2_real e[OMNI_S2_N],
                       omni_s2_real epsilon[OMNI_S2_N], omni_s2_real xi[OMNI_S2_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s2_real lower_edge = lower[i];
        const omni_s2_real upper_edge = upper[i];
        const omni_s2_real x_i = x[i];
        const omni_s2_real width = upper_edge - lower_edge;
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const omni_s2_real safe_width = wide ? width : 9.5367431640625e-7;
        const omni_s2_real to_lower = x_i - lower_edge;
        const omni_s2_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s2_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s2_real sign = upper_nearer ? (-1.0) : 1.0;
        const omni_s2_real smallest = safe_width * 0.005;
        const omni_s2_real widened = safe_width - width;
        const omni_s2_real half = widened * 0.5;
        const omni_s2_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const omni_s2_real to_nearer = clear ? safe_distance : smallest;
        const omni_s2_real to_farther = safe_width - to_nearer;
        const omni_s2_real a = upper_nearer ? to_farther : to_nearer;
        const omni_s2_real b = upper_nearer ? to_nearer : to_farther;
        const omni_s2_real e_i = omni_s2_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const omni_s2_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const omni_s2_real e_limited = e_beyond ? 0.99 : e_raised;
        omni_s2_real epsilon_nearer;
        omni_s2_real xi_i;
        omni_s2_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const omni_s2_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const omni_s2_real e_or_zero = empty ? 0.0 : e_limited;
        const omni_s2_real e_out = finite ? e_or_zero : (omni_s2_real)NAN;
        e[i] = e_out;
        const omni_s2_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const omni_s2_real epsilon_out = finite ? epsilon_or_zero : (omni_s2_real)NAN;
        epsilon[i] = epsilon_out;
        const omni_s2_real xi_or_zero = empty ? 0.0 : xi_i;
        const omni_s2_real xi_out = finite ? xi_or_zero : (omni_s2_real)NAN;
        xi[i] = xi_out;
    }
}
