/* either.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "either.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "either.c: double is not IEEE-754's here, for which rounding is bounded"
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
    0.6145744323730469, 0.7872200012207031, 0.6447334289550781, 0.8173789978027344,
    0.6667060852050781, 0.8332939147949219, 0.6667060852050781, 0.8332939147949219,
    0.7188377380371094, 0.8793678283691406, 0.6886787414550781, 0.8492088317871094,
    0.7709732055664062, 0.9254417419433594, 0.7106552124023438, 0.8651237487792969,
    0.8231048583984375, 0.9715156555175781, 0.7326278686523438, 0.8810386657714844,
    0.8752365112304688, 1.0175895690917969, 0.7546005249023438, 0.8969535827636719,
    0.9273681640625, 1.0636634826660156, 0.7765731811523438, 0.9128684997558594,
    0.9794998168945312, 1.1097373962402344, 0.7985458374023438, 0.9287872314453125,
    1.0316314697265625, 1.1558151245117188, 0.8205184936523438, 0.9447021484375,
    1.0837631225585938, 1.2018890380859375, 0.8424911499023438, 0.9606170654296875,
    1.135894775390625, 1.2479629516601562, 0.8644638061523438, 0.976531982421875,
    1.1880264282226562, 1.294036865234375, 0.8864402770996094, 0.9924468994140625,
    1.2401618957519531, 1.3401107788085938, 0.9084129333496094, 1.00836181640625,
    1.2922935485839844, 1.392242431640625, 0.9303855895996094, 1.03033447265625,
    1.3444252014160156, 1.4443740844726562, 0.9523582458496094, 1.05230712890625,
    1.3965568542480469, 1.4965095520019531, 0.9743309020996094, 1.0742835998535156,
    1.4486885070800781, 1.5486412048339844, 0.9963035583496094, 1.0962562561035156,
    1.5008201599121094, 1.6007728576660156, 1.0182762145996094, 1.1182289123535156,
    1.5529518127441406, 1.6529045104980469, 1.0402488708496094, 1.1402015686035156,
    1.6050834655761719, 1.7050361633300781, 1.0622215270996094, 1.1621742248535156,
    1.6572151184082031, 1.7571678161621094, 1.084197998046875, 1.1841468811035156,
    1.7093505859375, 1.8092994689941406, 1.106170654296875, 1.2061195373535156,
    1.7614822387695312, 1.8614311218261719, 1.128143310546875, 1.2280921936035156,
    1.8136138916015625, 1.9135627746582031, 1.150115966796875, 1.2500686645507812,
    1.8657455444335938, 1.9656982421875, 1.172088623046875, 1.2720413208007812,
    1.917877197265625, 2.0178298950195312, 1.194061279296875, 1.2940139770507812,
    1.9700088500976562, 2.0699615478515625, 1.216033935546875, 1.3159866333007812,
    2.0221405029296875, 2.1220932006835938, 1.238006591796875, 1.3379592895507812,
    2.0742721557617188, 2.174224853515625, 1.2599830627441406, 1.3599319458007812,
    2.1264076232910156, 2.2263565063476562, 1.2819557189941406, 1.3819046020507812,
    2.178539276123047, 2.2784881591796875, 1.3039283752441406, 1.4038772583007812,
    2.230670928955078, 2.3306198120117188, 1.3259010314941406, 1.4258499145507812,
    2.2828025817871094, 2.38275146484375, 1.3478736877441406, 1.4478263854980469,
    2.3349342346191406, 2.434886932373047, 1.3984489440917969, 1.4984016418457031,
    2.387054443359375, 2.4870071411132812, 1.4490242004394531, 1.5489768981933594,
    2.38702392578125, 2.4869766235351562, 1.499603271484375, 1.5995521545410156,
    2.386993408203125, 2.4869461059570312, 1.5501785278320312, 1.6501274108886719,
    2.386962890625, 2.4869155883789062, 1.6007537841796875, 1.7007064819335938,
    2.386932373046875, 2.4868850708007812, 1.6513290405273438, 1.75128173828125,
    2.38690185546875, 2.4868545532226562, 1.701904296875, 1.8018569946289062,
    2.386871337890625, 2.4868240356445312, 1.7524833679199219, 1.8524322509765625,
    2.3868408203125, 2.4867935180664062, 1.8030586242675781, 1.9030075073242188,
    2.386810302734375, 2.4867591857910156, 1.8536338806152344, 1.953582763671875,
    2.38677978515625, 2.4867286682128906, 1.9042091369628906, 2.004161834716797,
    2.386749267578125, 2.4866981506347656, 1.9547843933105469, 2.054737091064453,
    2.38671875, 2.4866676330566406, 2.005359649658203, 2.1053123474121094,
    2.386688232421875, 2.4866371154785156, 2.055938720703125, 2.1558876037597656,
    2.38665771484375, 2.4866065979003906, 2.1065139770507812, 2.206462860107422,
    2.386627197265625, 2.4865760803222656, 2.1570892333984375, 2.2570419311523438,
    2.3865928649902344, 2.4865455627441406, 2.2076644897460938, 2.3076171875,
    2.3865623474121094, 2.4865150451660156, 2.25823974609375, 2.3581924438476562,
    2.3865318298339844, 2.4864845275878906, 2.308818817138672, 2.4087677001953125,
    2.3865013122558594, 2.4864540100097656, 2.359394073486328, 2.4593429565429688,
    2.4376296997070312, 2.537578582763672, 2.4099693298339844, 2.5099220275878906,
    2.4887542724609375, 2.5887069702148438, 2.4605445861816406, 2.560497283935547,
    2.5398826599121094, 2.63983154296875, 2.511119842529297, 2.611072540283203,
    2.5910072326660156, 2.690959930419922, 2.561695098876953, 2.6616477966308594,
    2.6421356201171875, 2.742084503173828, 2.612274169921875, 2.7122230529785156,
    2.6932601928710938, 2.793212890625, 2.6628494262695312, 2.762798309326172,
    2.7443885803222656, 2.8443374633789062, 2.7134246826171875, 2.8133773803710938,
    2.795513153076172, 2.895465850830078, 2.7639999389648438, 2.86395263671875,
    2.8466415405273438, 2.9465904235839844, 2.8145751953125, 2.9145278930664062,
    2.89776611328125, 2.9977188110351562, 2.865154266357422, 2.9651031494140625,
    2.948894500732422, 3.0488433837890625, 2.915729522705078, 3.0156784057617188,
    3.000019073486328, 3.0999717712402344, 2.9663047790527344, 3.0662574768066406,
    3.000019073486328, 3.0999717712402344, 3.0168800354003906, 3.1168289184570312,
    3.000019073486328, 3.0999717712402344, 2.9663047790527344, 3.0662574768066406
};

/* Covered starts have x strictly above these bounds, by component. */
static const either_real either_start_lower[2] = {
    4.005234146118169, 4.005234146118169
};

/* Covered starts have x strictly below these bounds, by component. */
static const either_real either_start_upper[2] = {
    4.994765853881831, 4.994765853881831
};

/* Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 64 (t_c = 18 s).
 */
static inline void either_segment(either_real t, int32_t *row, either_real *s)
{
    const bool positive = 0.0 < t;
    const either_real started = positive ? t : 0.0;
    const either_real scaled = started * 3.5555555555555554;
    const bool early = scaled < 63.99999999999999;
    const either_real u = early ? scaled : 63.99999999999999;
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
    const either_real v0 = 1.0 - s;
    const either_real v1 = v0 * v0;
    const either_real v2 = v1 * v0;
    const either_real v3 = v0 * s;
    const either_real v4 = 1.0 + v3;
    const either_real v5 = 3.0 * v4;
    const either_real v6 = v0 * v5;
    const either_real v7 = 1.0 + v6;
    const either_real v8 = s * v5;
    const either_real v9 = 1.0 + v8;
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
    const either_real v0 = 1.0 - s;
    const either_real v1 = v0 + v0;
    const either_real v2 = v0 * v1;
    const either_real v3 = v0 * v0;
    const either_real v4 = v2 + v3;
    const either_real v5 = -v4;
    const either_real v6 = v0 - s;
    const either_real v7 = 3.0 * v6;
    const either_real v8 = v0 * v7;
    const either_real v9 = v0 * s;
    const either_real v10 = 1.0 + v9;
    const either_real v11 = 3.0 * v10;
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
    const either_real v1 = log(v0);
    const either_real v2 = -v1;
    const either_real v3 = 1.0 + v0;
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
    const bool moving = t < 18.0;
    const either_real per_second = moving ? 3.5555555555555554 : 0.0;
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
    const either_real t_zero = t * 0.0;
    either_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const either_real x_j = x[j];
        const either_real x_zero = x_j * 0.0;
        const either_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
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
        const either_real gain = upper_nearer ? (-0.5) : 0.5;
        const either_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const either_real to_nearer = clear ? distance : smallest;
        const either_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
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
    const either_real t_zero = t * 0.0;
    either_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const either_real x_j = x[j];
        const either_real x_zero = x_j * 0.0;
        const either_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
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
    either_real margin = 0.5;
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
        const bool x_beyond = x_share < (-1.0);
        const either_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool x_beyond = x_share < (-1.0);
        const either_real margin_x = x_beyond ? (-1.0) : x_share;
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
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const either_real safe_width = wide ? width : 9.5367431640625e-7;
        const either_real to_lower = x_i - lower_edge;
        const either_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const either_real distance = upper_nearer ? to_upper : to_lower;
        const either_real sign = upper_nearer ? (-1.0) : 1.0;
        const either_real smallest = safe_width * 0.005;
        const either_real widened = safe_width - width;
        const either_real half = widened * 0.5;
        const either_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const either_real to_nearer = clear ? safe_distance : smallest;
        const either_real to_farther = safe_width - to_nearer;
        const either_real a = upper_nearer ? to_farther : to_nearer;
        const either_real b = upper_nearer ? to_nearer : to_farther;
        const either_real e_i = either_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const either_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const either_real e_limited = e_beyond ? 0.99 : e_raised;
        either_real epsilon_nearer;
        either_real xi_i;
        either_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const either_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const either_real e_or_zero = empty ? 0.0 : e_limited;
        const either_real e_out = finite ? e_or_zero : (either_real)NAN;
        e[i] = e_out;
        const either_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const either_real epsilon_out = finite ? epsilon_or_zero : (either_real)NAN;
        epsilon[i] = epsilon_out;
        const either_real xi_or_zero = empty ? 0.0 : xi_i;
        const either_real xi_out = finite ? xi_or_zero : (either_real)NAN;
        xi[i] = xi_out;
    }
}
