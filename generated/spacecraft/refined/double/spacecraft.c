/* spacecraft.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "spacecraft.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "spacecraft.c: double is not IEEE-754's here, for which rounding is bounded"
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
    -0.019896507263183594, 0.0800929069519043, -0.006716251373291016, 0.09327363967895508,
    0.055092811584472656, 0.15508270263671875,
    5.245208740234375e-6, 0.09999513626098633, 5.245208740234375e-6, 0.09999513626098633,
    0.06667184829711914, 0.16666173934936523,
    0.019906997680664062, 0.11989688873291016, 0.006726264953613281, 0.10671615600585938,
    0.07825040817260742, 0.17824029922485352,
    0.03980875015258789, 0.13979864120483398, 0.013447761535644531, 0.11343765258789062,
    0.0898294448852539, 0.1898193359375,
    0.05971050262451172, 0.1597003936767578, 0.020168781280517578, 0.12015867233276367,
    0.10140848159790039, 0.20139837265014648,
    0.07961225509643555, 0.17960214614868164, 0.026890277862548828, 0.12688016891479492,
    0.11298704147338867, 0.21297693252563477,
    0.09951400756835938, 0.19950389862060547, 0.03361177444458008, 0.13360118865966797,
    0.12456607818603516, 0.22455596923828125,
    0.1194157600402832, 0.2194056510925293, 0.040332794189453125, 0.14032268524169922,
    0.13614511489868164, 0.23613500595092773,
    0.13931798934936523, 0.23930740356445312, 0.047054290771484375, 0.14704418182373047,
    0.14772367477416992, 0.24771356582641602,
    0.15921974182128906, 0.25920963287353516, 0.05377531051635742, 0.15376520156860352,
    0.1593027114868164, 0.2592926025390625,
    0.1791214942932129, 0.279111385345459, 0.06049680709838867, 0.16048669815063477,
    0.1708817481994629, 0.270871639251709,
    0.19902324676513672, 0.2990131378173828, 0.06721782684326172, 0.1672077178955078,
    0.18246030807495117, 0.28245019912719727,
    0.21892499923706055, 0.31891489028930664, 0.07393932342529297, 0.17392921447753906,
    0.19403934478759766, 0.29402923583984375,
    0.23882675170898438, 0.33881664276123047, 0.08066082000732422, 0.1806507110595703,
    0.20561838150024414, 0.30560827255249023,
    0.2587285041809082, 0.3587183952331543, 0.08738183975219727, 0.18737173080444336,
    0.21719694137573242, 0.3171868324279785,
    0.27863025665283203, 0.3786201477050781, 0.09410333633422852, 0.1940932273864746,
    0.2287759780883789, 0.328765869140625,
    0.29853248596191406, 0.39852190017700195, 0.10082435607910156, 0.20081424713134766,
    0.2403550148010254, 0.3403449058532715,
    0.3184342384338379, 0.418424129486084, 0.10754585266113281, 0.2075357437133789,
    0.25193357467651367, 0.35192346572875977,
    0.3383359909057617, 0.4383258819580078, 0.1283411979675293, 0.2283306121826172,
    0.26351261138916016, 0.36350250244140625,
    0.35823774337768555, 0.45822763442993164, 0.14913606643676758, 0.24912595748901367,
    0.27509164810180664, 0.37508153915405273,
    0.3770136833190918, 0.4770030975341797, 0.16993141174316406, 0.26992082595825195,
    0.2866702079772949, 0.386660099029541,
    0.39578914642333984, 0.49577903747558594, 0.19072628021240234, 0.29071617126464844,
    0.2982492446899414, 0.3982391357421875,
    0.4145650863647461, 0.5145549774169922, 0.21152162551879883, 0.3115110397338867,
    0.3098282814025879, 0.4098176956176758,
    0.43334102630615234, 0.5333309173583984, 0.2323164939880371, 0.3323063850402832,
    0.32140684127807617, 0.42139673233032227,
    0.43334102630615234, 0.5333309173583984, 0.2531118392944336, 0.3531012535095215,
    0.33298587799072266, 0.43297576904296875,
    0.43334102630615234, 0.5333309173583984, 0.2739067077636719, 0.37389659881591797,
    0.34456491470336914, 0.44455432891845703,
    0.43334102630615234, 0.5333309173583984, 0.29470205307006836, 0.39469146728515625,
    0.3561434745788574, 0.4561333656311035,
    0.43334102630615234, 0.5333309173583984, 0.31549692153930664, 0.41548681259155273,
    0.3677225112915039, 0.46771240234375,
    0.43334102630615234, 0.5333309173583984, 0.3362922668457031, 0.4362821578979492,
    0.3793015480041504, 0.4792909622192383,
    0.43334102630615234, 0.5333309173583984, 0.3570871353149414, 0.4570770263671875,
    0.39088010787963867, 0.49086999893188477,
    0.43334102630615234, 0.5333309173583984, 0.3778824806213379, 0.477872371673584,
    0.40245914459228516, 0.5024490356445312,
    0.43334102630615234, 0.5333309173583984, 0.39867734909057617, 0.49866724014282227,
    0.41403818130493164, 0.5140275955200195,
    0.43334102630615234, 0.5333309173583984, 0.41947269439697266, 0.5194625854492188,
    0.4256167411804199, 0.525606632232666,
    0.43334102630615234, 0.5333309173583984, 0.44026756286621094, 0.540257453918457,
    0.4371953010559082, 0.5371851921081543,
    0.43334102630615234, 0.5333309173583984, 0.41947269439697266, 0.5194625854492188,
    0.4256167411804199, 0.525606632232666
};

/* Covered starts have x strictly above these bounds, by component. */
static const spacecraft_real spacecraft_start_lower[3] = {
    0.0030311655998237087, 0.0030306911468512966, 0.4030303096771248
};

/* Covered starts have x strictly below these bounds, by component. */
static const spacecraft_real spacecraft_start_upper[3] = {
    0.5969706463813774, 0.5969706439971916, 0.996970262527465
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 15 s).
 */
static inline void spacecraft_segment(spacecraft_real t, int32_t *row, spacecraft_real *s)
{
    const bool positive = 0.0 < t;
    const spacecraft_real started = positive ? t : 0.0;
    const spacecraft_real scaled = started * 2.1333333333333333;
    const bool early = scaled < 31.999999999999996;
    const spacecraft_real u = early ? scaled : 31.999999999999996;
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
    const spacecraft_real v0 = 1.0 - s;
    const spacecraft_real v1 = v0 * v0;
    const spacecraft_real v2 = v1 * v0;
    const spacecraft_real v3 = v0 * s;
    const spacecraft_real v4 = 1.0 + v3;
    const spacecraft_real v5 = 3.0 * v4;
    const spacecraft_real v6 = v0 * v5;
    const spacecraft_real v7 = 1.0 + v6;
    const spacecraft_real v8 = s * v5;
    const spacecraft_real v9 = 1.0 + v8;
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
    const spacecraft_real v0 = 1.0 - s;
    const spacecraft_real v1 = v0 + v0;
    const spacecraft_real v2 = v0 * v1;
    const spacecraft_real v3 = v0 * v0;
    const spacecraft_real v4 = v2 + v3;
    const spacecraft_real v5 = -v4;
    const spacecraft_real v6 = v0 - s;
    const spacecraft_real v7 = 3.0 * v6;
    const spacecraft_real v8 = v0 * v7;
    const spacecraft_real v9 = v0 * s;
    const spacecraft_real v10 = 1.0 + v9;
    const spacecraft_real v11 = 3.0 * v10;
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
    const spacecraft_real v1 = log(v0);
    const spacecraft_real v2 = -v1;
    const spacecraft_real v3 = 1.0 + v0;
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
    const bool moving = t < 15.0;
    const spacecraft_real per_second = moving ? 2.1333333333333333 : 0.0;
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
    const spacecraft_real t_zero = t * 0.0;
    spacecraft_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const spacecraft_real x_j = x[j];
        const spacecraft_real x_zero = x_j * 0.0;
        const spacecraft_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 3; ++m) {
            u[m] = 0.0;
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
        const spacecraft_real gain = upper_nearer ? (-0.5) : 0.5;
        const spacecraft_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const spacecraft_real to_nearer = clear ? distance : smallest;
        const spacecraft_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
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
    const spacecraft_real t_zero = t * 0.0;
    spacecraft_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const spacecraft_real x_j = x[j];
        const spacecraft_real x_zero = x_j * 0.0;
        const spacecraft_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
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
    spacecraft_real margin = 0.5;
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
        const bool x_beyond = x_share < (-1.0);
        const spacecraft_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool x_beyond = x_share < (-1.0);
        const spacecraft_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const spacecraft_real safe_width = wide ? width : 9.5367431640625e-7;
        const spacecraft_real to_lower = x_i - lower_edge;
        const spacecraft_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const spacecraft_real distance = upper_nearer ? to_upper : to_lower;
        const spacecraft_real sign = upper_nearer ? (-1.0) : 1.0;
        const spacecraft_real smallest = safe_width * 0.005;
        const spacecraft_real widened = safe_width - width;
        const spacecraft_real half = widened * 0.5;
        const spacecraft_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const spacecraft_real to_nearer = clear ? safe_distance : smallest;
        const spacecraft_real to_farther = safe_width - to_nearer;
        const spacecraft_real a = upper_nearer ? to_farther : to_nearer;
        const spacecraft_real b = upper_nearer ? to_nearer : to_farther;
        const spacecraft_real e_i = spacecraft_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const spacecraft_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const spacecraft_real e_limited = e_beyond ? 0.99 : e_raised;
        spacecraft_real epsilon_nearer;
        spacecraft_real xi_i;
        spacecraft_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const spacecraft_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const spacecraft_real e_or_zero = empty ? 0.0 : e_limited;
        const spacecraft_real e_out = finite ? e_or_zero : (spacecraft_real)NAN;
        e[i] = e_out;
        const spacecraft_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const spacecraft_real epsilon_out = finite ? epsilon_or_zero : (spacecraft_real)NAN;
        epsilon[i] = epsilon_out;
        const spacecraft_real xi_or_zero = empty ? 0.0 : xi_i;
        const spacecraft_real xi_out = finite ? xi_or_zero : (spacecraft_real)NAN;
        xi[i] = xi_out;
    }
}
