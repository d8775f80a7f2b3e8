/* omni_s1.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (omni_s1.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "omni_s1.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "omni_s1.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "omni_s1.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "omni_s1.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "omni_s1.c: double is not IEEE-754's here, for which rounding is bounded"
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
static const omni_s1_real omni_s1_coefficients[140] = {
    -0.0125885009765625, 0.07280731201171875, 0.7771329879760742, 0.861933708190918,
    0.00001049041748046875, 0.08332347869873047, 0.7500104904174805, 0.8333234786987305,
    0.012608528137207031, 0.09383869171142578, 0.7228879928588867, 0.804713249206543,
    0.025206565856933594, 0.1043539047241211, 0.695765495300293, 0.7761030197143555,
    0.03780555725097656, 0.11487007141113281, 0.6686429977416992, 0.747492790222168,
    0.050403594970703125, 0.12538528442382812, 0.6415205001831055, 0.7188816070556641,
    0.06300163269042969, 0.13590049743652344, 0.6143980026245117, 0.6902713775634766,
    0.08876228332519531, 0.16166114807128906, 0.587275505065918, 0.6616611480712891,
    0.11452484130859375, 0.1874237060546875, 0.5601530075073242, 0.633051872253418,
    0.1402873992919922, 0.21318626403808594, 0.5666475296020508, 0.6395463943481445,
    0.16605091094970703, 0.23894977569580078, 0.5731420516967773, 0.6460409164428711,
    0.19181346893310547, 0.2647123336791992, 0.5796375274658203, 0.6525363922119141,
    0.2175760269165039, 0.29047489166259766, 0.5861320495605469, 0.6590309143066406,
    0.24333858489990234, 0.3162374496459961, 0.5888051986694336, 0.6617040634155273,
    0.2691011428833008, 0.34200000762939453, 0.5886774063110352, 0.6615762710571289,
    0.2948637008666992, 0.36776256561279297, 0.5885505676269531, 0.6614494323730469,
    0.32062625885009766, 0.3935251235961914, 0.5884237289428711, 0.6613225936889648,
    0.3463897705078125, 0.41928863525390625, 0.5882959365844727, 0.6611948013305664,
    0.37215232849121094, 0.4450511932373047, 0.5909690856933594, 0.6638679504394531,
    0.3979148864746094, 0.4708137512207031, 0.6023283004760742, 0.675227165222168,
    0.4236774444580078, 0.49657630920410156, 0.6136884689331055, 0.6865873336791992,
    0.44944000244140625, 0.5223388671875, 0.6250486373901367, 0.6979475021362305,
    0.4752025604248047, 0.5481014251708984, 0.6364078521728516, 0.7093067169189453,
    0.5009660720825195, 0.5738649368286133, 0.6477680206298828, 0.7206668853759766,
    0.526728630065918, 0.5996274948120117, 0.6591272354125977, 0.7320261001586914,
    0.5524911880493164, 0.6253900527954102, 0.6704874038696289, 0.7433862686157227,
    0.5782537460327148, 0.6511526107788086, 0.6818466186523438, 0.7547454833984375,
    0.6040163040161133, 0.676915168762207, 0.693206787109375, 0.7661056518554688,
    0.6297788619995117, 0.7026777267456055, 0.7045660018920898, 0.7774648666381836,
    0.6555414199829102, 0.7284402847290039, 0.7159261703491211, 0.7888250350952148,
    0.681304931640625, 0.7542037963867188, 0.7272853851318359, 0.8001842498779297,
    0.7070674896240234, 0.7799663543701172, 0.7386455535888672, 0.8115444183349609,
    0.7328300476074219, 0.8057289123535156, 0.750004768371582, 0.8229036331176758,
    0.7585926055908203, 0.8314914703369141, 0.750004768371582, 0.8229036331176758,
    0.7328300476074219, 0.8057289123535156, 0.750004768371582, 0.8229036331176758
};

/* Covered starts have x strictly above these bounds, by component. */
static const omni_s1_real omni_s1_start_lower[2] = {
    0.0025613784790050166, 4.502562332153322
};

/* Covered starts have x strictly below these bounds, by component. */
static const omni_s1_real omni_s1_start_upper[2] = {
    0.49744052886962775, 4.997441482543944
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 9 s).
 */
static inline void omni_s1_segment(omni_s1_real t, int32_t *row, omni_s1_real *s)
{
    const bool positive = 0.0 < t;
    const omni_s1_real started = positive ? t : 0.0;
    const omni_s1_real scaled = started * 3.5555555555555554;
    const bool early = scaled < 31.999999999999996;
    const omni_s1_real u = early ? scaled : 31.999999999999996;
    const int32_t segment = (int32_t)u;
    const omni_s1_real base = (omni_s1_real)segment;
    const omni_s1_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void omni_s1_basis(omni_s1_real s, omni_s1_real *w0, omni_s1_real *w1, omni_s1_real *w2,
                                 omni_s1_real *w3)
{
    const omni_s1_real v0 = 1.0 - s;
    const omni_s1_real v1 = v0 * v0;
    const omni_s1_real v2 = v1 * v0;
    const omni_s1_real v3 = v0 * s;
    const omni_s1_real v4 = 1.0 + v3;
    const omni_s1_real v5 = 3.0 * v4;
    const omni_s1_real v6 = v0 * v5;
    const omni_s1_real v7 = 1.0 + v6;
    const omni_s1_real v8 = s * v5;
    const omni_s1_real v9 = 1.0 + v8;
    const omni_s1_real v10 = s * s;
    const omni_s1_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void omni_s1_basis_rate(omni_s1_real s, omni_s1_real *dw0, omni_s1_real *dw1, omni_s1_real *dw2,
                                      omni_s1_real *dw3)
{
    const omni_s1_real v0 = 1.0 - s;
    const omni_s1_real v1 = v0 + v0;
    const omni_s1_real v2 = v0 * v1;
    const omni_s1_real v3 = v0 * v0;
    const omni_s1_real v4 = v2 + v3;
    const omni_s1_real v5 = -v4;
    const omni_s1_real v6 = v0 - s;
    const omni_s1_real v7 = 3.0 * v6;
    const omni_s1_real v8 = v0 * v7;
    const omni_s1_real v9 = v0 * s;
    const omni_s1_real v10 = 1.0 + v9;
    const omni_s1_real v11 = 3.0 * v10;
    const omni_s1_real v12 = v8 - v11;
    const omni_s1_real v13 = s * v7;
    const omni_s1_real v14 = v11 + v13;
    const omni_s1_real v15 = s + s;
    const omni_s1_real v16 = s * v15;
    const omni_s1_real v17 = s * s;
    const omni_s1_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline omni_s1_real omni_s1_edge_at(int32_t at, omni_s1_real w0, omni_s1_real w1, omni_s1_real w2,
                                           omni_s1_real w3)
{
    const omni_s1_real q0 = omni_s1_coefficients[at];
    const int32_t at_1 = at + 4;
    const omni_s1_real q1 = omni_s1_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const omni_s1_real q2 = omni_s1_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const omni_s1_real q3 = omni_s1_coefficients[at_3];
    const omni_s1_real v0 = w0 * q0;
    const omni_s1_real v1 = w1 * q1;
    const omni_s1_real v2 = v0 + v1;
    const omni_s1_real v3 = w2 * q2;
    const omni_s1_real v4 = w3 * q3;
    const omni_s1_real v5 = v3 + v4;
    const omni_s1_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline omni_s1_real omni_s1_normalized_error(omni_s1_real a, omni_s1_real b, omni_s1_real width)
{
    const omni_s1_real v0 = a - b;
    const omni_s1_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void omni_s1_transformed_error(omni_s1_real a, omni_s1_real b, omni_s1_real *epsilon,
                                             omni_s1_real *xi)
{
    const omni_s1_real v0 = b / a;
    const omni_s1_real v1 = log(v0);
    const omni_s1_real v2 = -v1;
    const omni_s1_real v3 = 1.0 + v0;
    const omni_s1_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline omni_s1_real omni_s1_law(omni_s1_real k, omni_s1_real xi, omni_s1_real epsilon)
{
    const omni_s1_real v0 = k * xi;
    const omni_s1_real v1 = v0 * epsilon;
    const omni_s1_real v2 = -v1;
    return v2;
}

void omni_s1_tube(omni_s1_real t, omni_s1_real lower[OMNI_S1_N], omni_s1_real upper[OMNI_S1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (omni_s1_real)NAN;
            upper[j] = (omni_s1_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void omni_s1_tube_rate(omni_s1_real t, omni_s1_real lower_rate[OMNI_S1_N], omni_s1_real upper_rate[OMNI_S1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (omni_s1_real)NAN;
            upper_rate[j] = (omni_s1_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real dw0;
    omni_s1_real dw1;
    omni_s1_real dw2;
    omni_s1_real dw3;
    omni_s1_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 9.0;
    const omni_s1_real per_second = moving ? 3.5555555555555554 : 0.0;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_slope = omni_s1_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const omni_s1_real lower_speed = lower_slope * per_second;
        const omni_s1_real upper_slope = omni_s1_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const omni_s1_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

omni_s1_status omni_s1_control(omni_s1_real t, const omni_s1_real x[OMNI_S1_N], omni_s1_real u[OMNI_S1_N])
{
    const omni_s1_real t_zero = t * 0.0;
    omni_s1_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s1_real x_j = x[j];
        const omni_s1_real x_zero = x_j * 0.0;
        const omni_s1_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
        }
        return OMNI_S1_BAD_INPUT;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s1_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s1_real gain = upper_nearer ? (-0.5) : 0.5;
        const omni_s1_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const omni_s1_real to_nearer = clear ? distance : smallest;
        const omni_s1_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
        const bool outside_next = inside ? outside : true;
        omni_s1_real epsilon;
        omni_s1_real xi;
        omni_s1_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const omni_s1_real u_i = omni_s1_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? OMNI_S1_OUTSIDE_TUBE : OMNI_S1_OK;
}

omni_s1_real omni_s1_margin(omni_s1_real t, const omni_s1_real x[OMNI_S1_N])
{
    const omni_s1_real t_zero = t * 0.0;
    omni_s1_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s1_real x_j = x[j];
        const omni_s1_real x_zero = x_j * 0.0;
        const omni_s1_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        return (omni_s1_real)NAN;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    omni_s1_real margin = 0.5;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s1_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s1_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const omni_s1_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool less = margin_x < margin;
        const omni_s1_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void omni_s1_margins(omni_s1_real t, const omni_s1_real x[OMNI_S1_N], omni_s1_real margin[OMNI_S1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (omni_s1_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s1_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s1_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const omni_s1_real margin_x = x_beyond ? (-1.0) : x_share;
        margin[i] = margin_x;
    }
}

bool omni_s1_covered(const omni_s1_real x[OMNI_S1_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s1_real x_i = x[i];
        const omni_s1_real x_lower = omni_s1_start_lower[i];
        const omni_s1_real x_upper = omni_s1_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void omni_s1_transform(const omni_s1_real lower[OMNI_S1_N], const omni_s1_real upper[OMNI_S1_N],
                       const omni_s1_real x[OMNI_S1_N], omni_s1_real e[OMNI_S1_N],
                       omni_s1_real epsilon[OMNI_S1_N], omni_s1_real xi[OMNI_S1_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s1_real lower_edge = lower[i];
        const omni_s1_real upper_edge = upper[i];
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const omni_s1_real safe_width = wide ? width : 9.5367431640625e-7;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s1_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s1_real sign = upper_nearer ? (-1.0) : 1.0;
        const omni_s1_real smallest = safe_width * 0.005;
        const omni_s1_real widened = safe_width - width;
        const omni_s1_real half = widened * 0.5;
        const omni_s1_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const omni_s1_real to_nearer = clear ? safe_distance : smallest;
        const omni_s1_real to_farther = safe_width - to_nearer;
        const omni_s1_real a = upper_nearer ? to_farther : to_nearer;
        const omni_s1_real b = upper_nearer ? to_nearer : to_farther;
        const omni_s1_real e_i = omni_s1_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const omni_s1_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const omni_s1_real e_limited = e_beyond ? 0.99 : e_raised;
        omni_s1_real epsilon_nearer;
        omni_s1_real xi_i;
        omni_s1_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const omni_s1_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const omni_s1_real e_or_zero = empty ? 0.0 : e_limited;
        const omni_s1_real e_out = finite ? e_or_zero : (omni_s1_real)NAN;
        e[i] = e_out;
        const omni_s1_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const omni_s1_real epsilon_out = finite ? epsilon_or_zero : (omni_s1_real)NAN;
        epsilon[i] = epsilon_out;
        const omni_s1_real xi_or_zero = empty ? 0.0 : xi_i;
        const omni_s1_real xi_out = finite ? xi_or_zero : (omni_s1_real)NAN;
        xi[i] = xi_out;
    }
}
