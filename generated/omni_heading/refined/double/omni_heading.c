/* omni_heading.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
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

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "omni_heading.c: compile without -ffast-math; it tests its inputs for NaN and infinity"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1)
#error "omni_heading.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif

/* B-spline control points divided by 6, one row for each of 32 + 3 points:
 * lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]
 * Multiples of 2^-20: exact in float and double.
 */
static const omni_heading_real omni_heading_coefficients[210] = {
    -0.038776397705078125, 0.044536590576171875, -0.07992362976074219, 0.043358802795410156,
    -0.016656875610351562, 0.016656875610351562,
    0.00001049041748046875, 0.08332347869873047, 0.019994735717773438, 0.08332347869873047,
    -0.016656875610351562, 0.016656875610351562,
    0.038796424865722656, 0.12211036682128906, 4.76837158203125e-6, 0.12328720092773438,
    -0.016656875610351562, 0.016656875610351562,
    9.5367431640625e-6, 0.16089725494384766, 4.76837158203125e-6, 0.1632518768310547,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.16166114807128906, 0.015218734741210938, 0.203216552734375,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.16166114807128906, 0.05518341064453125, 0.2431812286376953,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.16166114807128906, 0.09514713287353516, 0.2831449508666992,
    -0.016656875610351562, 0.016656875610351562,
    4.76837158203125e-6, 0.16166114807128906, 0.13511180877685547, 0.32310962677001953,
    -0.016656875610351562, 0.016656875610351562,
    0.000774383544921875, 0.16166114807128906, 0.17507648468017578, 0.36307430267333984,
    -0.016656875610351562, 0.016656875610351562,
    0.03956127166748047, 0.12287425994873047, 0.2150402069091797, 0.40303802490234375,
    -0.016656875610351562, 0.016656875610351562,
    0.07834911346435547, 0.16166114807128906, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.11713600158691406, 0.20044898986816406, 0.2949695587158203, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.15592288970947266, 0.23923587799072266, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.19470977783203125, 0.27802276611328125, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.23349666595458984, 0.31680965423583984, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.27228355407714844, 0.35559654235839844, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.31107044219970703, 0.39438343048095703, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.3498573303222656, 0.4331703186035156, 0.2550048828125, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.3886442184448242, 0.4719572067260742, 0.2618141174316406, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.4274311065673828, 0.5107440948486328, 0.30177879333496094, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.4662179946899414, 0.5495309829711914, 0.34174251556396484, 0.37169742584228516,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.58831787109375, 0.38170719146728516, 0.41166114807128906,
    -0.016656875610351562, 0.016656875610351562,
    0.5437917709350586, 0.6271047592163086, 0.42167186737060547, 0.4516258239746094,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.6658916473388672, 0.4616365432739258, 0.4915904998779297,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.7046785354614258, 0.42167186737060547, 0.53155517578125,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.7434654235839844, 0.44361114501953125, 0.5715188980102539,
    -0.016656875610351562, 0.016656875610351562,
    0.5050048828125, 0.782252311706543, 0.48357582092285156, 0.6114835739135742,
    -0.016656875610351562, 0.016656875610351562,
    0.53021240234375, 0.8210391998291016, 0.5235404968261719, 0.6514482498168945,
    -0.016656875610351562, 0.016656875610351562,
    0.5689992904663086, 0.8333282470703125, 0.5635042190551758, 0.6914119720458984,
    -0.016656875610351562, 0.016656875610351562,
    0.6077861785888672, 0.8333282470703125, 0.6034688949584961, 0.7313766479492188,
    -0.016656875610351562, 0.016656875610351562,
    0.6465730667114258, 0.8333282470703125, 0.6434335708618164, 0.7713413238525391,
    -0.016656875610351562, 0.016656875610351562,
    0.6853599548339844, 0.8333282470703125, 0.6833972930908203, 0.8113059997558594,
    -0.016656875610351562, 0.016656875610351562,
    0.724146842956543, 0.807490348815918, 0.7233619689941406, 0.8333282470703125,
    -0.016656875610351562, 0.016656875610351562,
    0.7629337310791016, 0.8462467193603516, 0.7633266448974609, 0.8333282470703125,
    -0.016656875610351562, 0.016656875610351562,
    0.724146842956543, 0.807490348815918, 0.7233619689941406, 0.8333282470703125,
    -0.016656875610351562, 0.016656875610351562
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 9 s).
 */
static inline void omni_heading_segment(omni_heading_real t, int32_t *row, omni_heading_real *s)
{
    const bool positive = 0.0 < t;
    const omni_heading_real started = positive ? t : 0.0;
    const omni_heading_real scaled = started * 3.5555555555555554;
    const bool early = scaled < 31.999999999999996;
    const omni_heading_real u = early ? scaled : 31.999999999999996;
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
    const omni_heading_real v0 = 1.0 - s;
    const omni_heading_real v1 = v0 * v0;
    const omni_heading_real v2 = v1 * v0;
    const omni_heading_real v3 = v0 * s;
    const omni_heading_real v4 = 1.0 + v3;
    const omni_heading_real v5 = 3.0 * v4;
    const omni_heading_real v6 = v0 * v5;
    const omni_heading_real v7 = 1.0 + v6;
    const omni_heading_real v8 = s * v5;
    const omni_heading_real v9 = 1.0 + v8;
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
    const omni_heading_real v0 = 1.0 - s;
    const omni_heading_real v1 = v0 + v0;
    const omni_heading_real v2 = v0 * v1;
    const omni_heading_real v3 = v0 * v0;
    const omni_heading_real v4 = v2 + v3;
    const omni_heading_real v5 = -v4;
    const omni_heading_real v6 = v0 - s;
    const omni_heading_real v7 = 3.0 * v6;
    const omni_heading_real v8 = v0 * v7;
    const omni_heading_real v9 = v0 * s;
    const omni_heading_real v10 = 1.0 + v9;
    const omni_heading_real v11 = 3.0 * v10;
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

/* An edge of the tube (or its slope in spline time): sum of w_j q_j. */
static inline omni_heading_real omni_heading_blend(omni_heading_real w0, omni_heading_real w1,
                                                   omni_heading_real w2, omni_heading_real w3,
                                                   omni_heading_real q0, omni_heading_real q1,
                                                   omni_heading_real q2, omni_heading_real q3)
{
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
    const omni_heading_real v1 = log(v0);
    const omni_heading_real v2 = -v1;
    const omni_heading_real v3 = 1.0 + v0;
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
        const int32_t at = row + pair;
        const omni_heading_real lower_q0 = omni_heading_coefficients[at];
        const int32_t lower_1 = at + 6;
        const omni_heading_real lower_q1 = omni_heading_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const omni_heading_real lower_q2 = omni_heading_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const omni_heading_real lower_q3 = omni_heading_coefficients[lower_3];
        const omni_heading_real lower_edge = omni_heading_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        lower[i] = lower_edge;
        const int32_t upper_0 = at + 1;
        const omni_heading_real upper_q0 = omni_heading_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const omni_heading_real upper_q1 = omni_heading_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const omni_heading_real upper_q2 = omni_heading_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const omni_heading_real upper_q3 = omni_heading_coefficients[upper_3];
        const omni_heading_real upper_edge = omni_heading_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
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
    const bool moving = t < 9.0;
    const omni_heading_real per_second = moving ? 3.5555555555555554 : 0.0;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const omni_heading_real lower_q0 = omni_heading_coefficients[at];
        const int32_t lower_1 = at + 6;
        const omni_heading_real lower_q1 = omni_heading_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const omni_heading_real lower_q2 = omni_heading_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const omni_heading_real lower_q3 = omni_heading_coefficients[lower_3];
        const omni_heading_real lower_slope = omni_heading_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const omni_heading_real lower_speed = lower_slope * per_second;
        lower_rate[i] = lower_speed;
        const int32_t upper_0 = at + 1;
        const omni_heading_real upper_q0 = omni_heading_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const omni_heading_real upper_q1 = omni_heading_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const omni_heading_real upper_q2 = omni_heading_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const omni_heading_real upper_q3 = omni_heading_coefficients[upper_3];
        const omni_heading_real upper_slope = omni_heading_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const omni_heading_real upper_speed = upper_slope * per_second;
        upper_rate[i] = upper_speed;
    }
}

omni_heading_status omni_heading_control(omni_heading_real t, const omni_heading_real x[OMNI_HEADING_N],
                                         omni_heading_real u[OMNI_HEADING_N])
{
    const omni_heading_real t_zero = t * 0.0;
    omni_heading_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const omni_heading_real x_j = x[j];
        const omni_heading_real x_zero = x_j * 0.0;
        const omni_heading_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j2 = 0; j2 < 3; ++j2) {
            u[j2] = 0.0;
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
        const int32_t at = row + pair;
        const omni_heading_real lower_q0 = omni_heading_coefficients[at];
        const int32_t lower_1 = at + 6;
        const omni_heading_real lower_q1 = omni_heading_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const omni_heading_real lower_q2 = omni_heading_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const omni_heading_real lower_q3 = omni_heading_coefficients[lower_3];
        const omni_heading_real lower_edge = omni_heading_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const int32_t upper_0 = at + 1;
        const omni_heading_real upper_q0 = omni_heading_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const omni_heading_real upper_q1 = omni_heading_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const omni_heading_real upper_q2 = omni_heading_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const omni_heading_real upper_q3 = omni_heading_coefficients[upper_3];
        const omni_heading_real upper_edge = omni_heading_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const omni_heading_real x_i = x[i];
        const omni_heading_real room = upper_edge - lower_edge;
        const omni_heading_real to_lower = x_i - lower_edge;
        const omni_heading_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_heading_real nearest = upper_nearer ? to_upper : to_lower;
        const omni_heading_real gain = upper_nearer ? (-0.5) : 0.5;
        const omni_heading_real least = room * 0.005;
        const bool clear = least < nearest;
        const omni_heading_real near = clear ? nearest : least;
        const omni_heading_real far = room - near;
        const bool within = 0.0 < nearest;
        const bool outside_any = within ? outside : true;
        omni_heading_real epsilon;
        omni_heading_real xi;
        omni_heading_transformed_error(near, far, &epsilon, &xi);
        const omni_heading_real push = omni_heading_law(gain, xi, epsilon);
        u[i] = push;
        outside = outside_any;
    }
    return outside ? OMNI_HEADING_OUTSIDE_TUBE : OMNI_HEADING_OK;
}

omni_heading_real omni_heading_margin(omni_heading_real t, const omni_heading_real x[OMNI_HEADING_N])
{
    const omni_heading_real t_zero = t * 0.0;
    omni_heading_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const omni_heading_real x_j = x[j];
        const omni_heading_real x_zero = x_j * 0.0;
        const omni_heading_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
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
    omni_heading_real margin = 0.5;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const omni_heading_real lower_q0 = omni_heading_coefficients[at];
        const int32_t lower_1 = at + 6;
        const omni_heading_real lower_q1 = omni_heading_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const omni_heading_real lower_q2 = omni_heading_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const omni_heading_real lower_q3 = omni_heading_coefficients[lower_3];
        const omni_heading_real lower_edge = omni_heading_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const int32_t upper_0 = at + 1;
        const omni_heading_real upper_q0 = omni_heading_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const omni_heading_real upper_q1 = omni_heading_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const omni_heading_real upper_q2 = omni_heading_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const omni_heading_real upper_q3 = omni_heading_coefficients[upper_3];
        const omni_heading_real upper_edge = omni_heading_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const omni_heading_real x_i = x[i];
        const omni_heading_real room = upper_edge - lower_edge;
        const omni_heading_real to_lower = x_i - lower_edge;
        const omni_heading_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_heading_real nearest = upper_nearer ? to_upper : to_lower;
        const omni_heading_real share = nearest / room;
        const bool beyond = share < (-1.0);
        const omni_heading_real held_share = beyond ? (-1.0) : share;
        const bool less = held_share < margin;
        const omni_heading_real margin_next = less ? held_share : margin;
        margin = margin_next;
    }
    return margin;
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
        const omni_heading_real room = upper_edge - lower_edge;
        const bool filled = 0.0 < room;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < room;
        const omni_heading_real width = wide ? room : 9.5367431640625e-7;
        const omni_heading_real to_lower = x_i - lower_edge;
        const omni_heading_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_heading_real nearest = upper_nearer ? to_upper : to_lower;
        const omni_heading_real gain = upper_nearer ? (-1.0) : 1.0;
        const omni_heading_real least = width * 0.005;
        const omni_heading_real widened = width - room;
        const omni_heading_real spare = widened * 0.5;
        const omni_heading_real distance = nearest + spare;
        const bool farther = least < distance;
        const bool clear = filled && farther;
        const omni_heading_real near = clear ? distance : least;
        const omni_heading_real far = width - near;
        const omni_heading_real a = upper_nearer ? far : near;
        const omni_heading_real b = upper_nearer ? near : far;
        const omni_heading_real e_raw = omni_heading_normalized_error(a, b, width);
        const bool e_held_above = (-0.99) < e_raw;
        const omni_heading_real e_held_raised = e_held_above ? e_raw : (-0.99);
        const bool e_held_over = 0.99 < e_held_raised;
        const omni_heading_real e_held = e_held_over ? 0.99 : e_held_raised;
        omni_heading_real epsilon_near;
        omni_heading_real xi_i;
        omni_heading_transformed_error(near, far, &epsilon_near, &xi_i);
        const omni_heading_real epsilon_i = gain * epsilon_near;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_room = isfinite(room) != 0;
        const bool finite = finite_x && finite_room;
        const omni_heading_real e_settled = empty ? 0.0 : e_held;
        const omni_heading_real e_out = finite ? e_settled : (omni_heading_real)NAN;
        e[i] = e_out;
        const omni_heading_real epsilon_settled = empty ? 0.0 : epsilon_i;
        const omni_heading_real epsilon_out = finite ? epsilon_settled : (omni_heading_real)NAN;
        epsilon[i] = epsilon_out;
        const omni_heading_real xi_settled = empty ? 0.0 : xi_i;
        const omni_heading_real xi_out = finite ? xi_settled : (omni_heading_real)NAN;
        xi[i] = xi_out;
    }
}
