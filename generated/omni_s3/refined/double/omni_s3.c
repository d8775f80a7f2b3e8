/* omni_s3.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
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

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "omni_s3.c: compile without -ffast-math; it tests its inputs for NaN and infinity"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1)
#error "omni_s3.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif

/* B-spline control points divided by 6, one row for each of 32 + 3 points:
 * lower[0], upper[0], lower[1], upper[1]
 * Multiples of 2^-20: exact in float and double.
 */
static const omni_s3_real omni_s3_coefficients[140] = {
    0.6887588500976562, 0.7720718383789062, -0.02367401123046875, 0.05963897705078125,
    0.6666765213012695, 0.7499895095825195, 0.00001049041748046875, 0.08332347869873047,
    0.6445951461791992, 0.7279081344604492, 0.02369403839111328, 0.10700702667236328,
    0.6225128173828125, 0.7058258056640625, 0.0473785400390625, 0.1306915283203125,
    0.6004304885864258, 0.6837434768676758, 0.07106208801269531, 0.1543750762939453,
    0.5783481597900391, 0.6616611480712891, 0.09474658966064453, 0.17805957794189453,
    0.5562667846679688, 0.6395797729492188, 0.11843013763427734, 0.20174312591552734,
    0.534184455871582, 0.6616611480712891, 0.14211463928222656, 0.22542762756347656,
    0.5121021270751953, 0.6616611480712891, 0.16579818725585938, 0.24911117553710938,
    0.5050048828125, 0.6616611480712891, 0.1894826889038086, 0.2727956771850586,
    0.5050048828125, 0.6616611480712891, 0.2131662368774414, 0.2964792251586914,
    0.5050048828125, 0.6616611480712891, 0.23685073852539062, 0.3201637268066406,
    0.5050048828125, 0.6616611480712891, 0.26053428649902344, 0.34384727478027344,
    0.5050048828125, 0.6616611480712891, 0.28421878814697266, 0.36753177642822266,
    0.5050048828125, 0.6616611480712891, 0.3079032897949219, 0.3912162780761719,
    0.5050048828125, 0.6616611480712891, 0.3315868377685547, 0.4148998260498047,
    0.5050048828125, 0.6616611480712891, 0.3552713394165039, 0.4385843276977539,
    0.5050048828125, 0.6616611480712891, 0.3789548873901367, 0.4622678756713867,
    0.5050048828125, 0.6395797729492188, 0.40263938903808594, 0.48595237731933594,
    0.5050048828125, 0.6616611480712891, 0.42632293701171875, 0.5096359252929688,
    0.5050048828125, 0.6837434768676758, 0.45000743865966797, 0.533320426940918,
    0.5050048828125, 0.7058258056640625, 0.4736909866333008, 0.5570039749145508,
    0.5144634246826172, 0.7279081344604492, 0.49737548828125, 0.5806884765625,
    0.5365447998046875, 0.7499895095825195, 0.5210590362548828, 0.6043720245361328,
    0.5586271286010742, 0.7720718383789062, 0.544743537902832, 0.628056526184082,
    0.5807094573974609, 0.794154167175293, 0.5684270858764648, 0.6517400741577148,
    0.6027917861938477, 0.8162355422973633, 0.5921115875244141, 0.6754245758056641,
    0.624873161315918, 0.8333282470703125, 0.6157951354980469, 0.6991081237792969,
    0.6469554901123047, 0.8333282470703125, 0.6394796371459961, 0.7227926254272461,
    0.6690378189086914, 0.8333282470703125, 0.6631631851196289, 0.7464761734008789,
    0.6911191940307617, 0.8333282470703125, 0.6868476867675781, 0.7701606750488281,
    0.7132015228271484, 0.8333282470703125, 0.7105312347412109, 0.7938442230224609,
    0.7352838516235352, 0.8186273574829102, 0.7342157363891602, 0.8175287246704102,
    0.7573661804199219, 0.8406782150268555, 0.7579002380371094, 0.8412132263183594,
    0.7352838516235352, 0.8186273574829102, 0.7342157363891602, 0.8175287246704102
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 9 s).
 */
static inline void omni_s3_segment(omni_s3_real t, int32_t *row, omni_s3_real *s)
{
    const bool positive = 0.0 < t;
    const omni_s3_real started = positive ? t : 0.0;
    const omni_s3_real scaled = started * 3.5555555555555554;
    const bool early = scaled < 31.999999999999996;
    const omni_s3_real u = early ? scaled : 31.999999999999996;
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
    const omni_s3_real v0 = 1.0 - s;
    const omni_s3_real v1 = v0 * v0;
    const omni_s3_real v2 = v1 * v0;
    const omni_s3_real v3 = v0 * s;
    const omni_s3_real v4 = 1.0 + v3;
    const omni_s3_real v5 = 3.0 * v4;
    const omni_s3_real v6 = v0 * v5;
    const omni_s3_real v7 = 1.0 + v6;
    const omni_s3_real v8 = s * v5;
    const omni_s3_real v9 = 1.0 + v8;
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
    const omni_s3_real v0 = 1.0 - s;
    const omni_s3_real v1 = v0 + v0;
    const omni_s3_real v2 = v0 * v1;
    const omni_s3_real v3 = v0 * v0;
    const omni_s3_real v4 = v2 + v3;
    const omni_s3_real v5 = -v4;
    const omni_s3_real v6 = v0 - s;
    const omni_s3_real v7 = 3.0 * v6;
    const omni_s3_real v8 = v0 * v7;
    const omni_s3_real v9 = v0 * s;
    const omni_s3_real v10 = 1.0 + v9;
    const omni_s3_real v11 = 3.0 * v10;
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

/* An edge of the tube (or its slope in spline time): sum of w_j q_j. */
static inline omni_s3_real omni_s3_blend(omni_s3_real w0, omni_s3_real w1, omni_s3_real w2, omni_s3_real w3,
                                         omni_s3_real q0, omni_s3_real q1, omni_s3_real q2, omni_s3_real q3)
{
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
    const omni_s3_real v1 = log(v0);
    const omni_s3_real v2 = -v1;
    const omni_s3_real v3 = 1.0 + v0;
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
        const int32_t at = row + pair;
        const omni_s3_real lower_q0 = omni_s3_coefficients[at];
        const int32_t lower_1 = at + 4;
        const omni_s3_real lower_q1 = omni_s3_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const omni_s3_real lower_q2 = omni_s3_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const omni_s3_real lower_q3 = omni_s3_coefficients[lower_3];
        const omni_s3_real lower_edge = omni_s3_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        lower[i] = lower_edge;
        const int32_t upper_0 = at + 1;
        const omni_s3_real upper_q0 = omni_s3_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const omni_s3_real upper_q1 = omni_s3_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const omni_s3_real upper_q2 = omni_s3_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const omni_s3_real upper_q3 = omni_s3_coefficients[upper_3];
        const omni_s3_real upper_edge = omni_s3_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
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
    const bool moving = t < 9.0;
    const omni_s3_real per_second = moving ? 3.5555555555555554 : 0.0;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const omni_s3_real lower_q0 = omni_s3_coefficients[at];
        const int32_t lower_1 = at + 4;
        const omni_s3_real lower_q1 = omni_s3_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const omni_s3_real lower_q2 = omni_s3_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const omni_s3_real lower_q3 = omni_s3_coefficients[lower_3];
        const omni_s3_real lower_slope = omni_s3_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const omni_s3_real lower_speed = lower_slope * per_second;
        lower_rate[i] = lower_speed;
        const int32_t upper_0 = at + 1;
        const omni_s3_real upper_q0 = omni_s3_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const omni_s3_real upper_q1 = omni_s3_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const omni_s3_real upper_q2 = omni_s3_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const omni_s3_real upper_q3 = omni_s3_coefficients[upper_3];
        const omni_s3_real upper_slope = omni_s3_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const omni_s3_real upper_speed = upper_slope * per_second;
        upper_rate[i] = upper_speed;
    }
}

omni_s3_status omni_s3_control(omni_s3_real t, const omni_s3_real x[OMNI_S3_N], omni_s3_real u[OMNI_S3_N])
{
    const omni_s3_real t_zero = t * 0.0;
    omni_s3_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s3_real x_j = x[j];
        const omni_s3_real x_zero = x_j * 0.0;
        const omni_s3_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j2 = 0; j2 < 2; ++j2) {
            u[j2] = 0.0;
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
        const int32_t at = row + pair;
        const omni_s3_real lower_q0 = omni_s3_coefficients[at];
        const int32_t lower_1 = at + 4;
        const omni_s3_real lower_q1 = omni_s3_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const omni_s3_real lower_q2 = omni_s3_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const omni_s3_real lower_q3 = omni_s3_coefficients[lower_3];
        const omni_s3_real lower_edge = omni_s3_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const int32_t upper_0 = at + 1;
        const omni_s3_real upper_q0 = omni_s3_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const omni_s3_real upper_q1 = omni_s3_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const omni_s3_real upper_q2 = omni_s3_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const omni_s3_real upper_q3 = omni_s3_coefficients[upper_3];
        const omni_s3_real upper_edge = omni_s3_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const omni_s3_real x_i = x[i];
        const omni_s3_real room = upper_edge - lower_edge;
        const omni_s3_real to_lower = x_i - lower_edge;
        const omni_s3_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s3_real nearest = upper_nearer ? to_upper : to_lower;
        const omni_s3_real gain = upper_nearer ? (-0.5) : 0.5;
        const omni_s3_real least = room * 0.005;
        const bool clear = least < nearest;
        const omni_s3_real near = clear ? nearest : least;
        const omni_s3_real far = room - near;
        const bool within = 0.0 < nearest;
        const bool outside_any = within ? outside : true;
        omni_s3_real epsilon;
        omni_s3_real xi;
        omni_s3_transformed_error(near, far, &epsilon, &xi);
        const omni_s3_real push = omni_s3_law(gain, xi, epsilon);
        u[i] = push;
        outside = outside_any;
    }
    return outside ? OMNI_S3_OUTSIDE_TUBE : OMNI_S3_OK;
}

omni_s3_real omni_s3_margin(omni_s3_real t, const omni_s3_real x[OMNI_S3_N])
{
    const omni_s3_real t_zero = t * 0.0;
    omni_s3_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s3_real x_j = x[j];
        const omni_s3_real x_zero = x_j * 0.0;
        const omni_s3_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
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
    omni_s3_real margin = 0.5;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const omni_s3_real lower_q0 = omni_s3_coefficients[at];
        const int32_t lower_1 = at + 4;
        const omni_s3_real lower_q1 = omni_s3_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const omni_s3_real lower_q2 = omni_s3_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const omni_s3_real lower_q3 = omni_s3_coefficients[lower_3];
        const omni_s3_real lower_edge = omni_s3_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const int32_t upper_0 = at + 1;
        const omni_s3_real upper_q0 = omni_s3_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const omni_s3_real upper_q1 = omni_s3_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const omni_s3_real upper_q2 = omni_s3_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const omni_s3_real upper_q3 = omni_s3_coefficients[upper_3];
        const omni_s3_real upper_edge = omni_s3_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const omni_s3_real x_i = x[i];
        const omni_s3_real room = upper_edge - lower_edge;
        const omni_s3_real to_lower = x_i - lower_edge;
        const omni_s3_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s3_real nearest = upper_nearer ? to_upper : to_lower;
        const omni_s3_real share = nearest / room;
        const bool beyond = share < (-1.0);
        const omni_s3_real held_share = beyond ? (-1.0) : share;
        const bool less = held_share < margin;
        const omni_s3_real margin_next = less ? held_share : margin;
        margin = margin_next;
    }
    return margin;
}

void omni_s3_transform(const omni_s3_real lower[OMNI_S3_N], const omni_s3_real upper[OMNI_S3_N],
                       const omni_s3_real x[OMNI_S3_N], omni_s3_real e[OMNI_S3_N],
                       omni_s3_real epsilon[OMNI_S3_N], omni_s3_real xi[OMNI_S3_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s3_real lower_edge = lower[i];
        const omni_s3_real upper_edge = upper[i];
        const omni_s3_real x_i = x[i];
        const omni_s3_real room = upper_edge - lower_edge;
        const bool filled = 0.0 < room;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < room;
        const omni_s3_real width = wide ? room : 9.5367431640625e-7;
        const omni_s3_real to_lower = x_i - lower_edge;
        const omni_s3_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s3_real nearest = upper_nearer ? to_upper : to_lower;
        const omni_s3_real gain = upper_nearer ? (-1.0) : 1.0;
        const omni_s3_real least = width * 0.005;
        const omni_s3_real widened = width - room;
        const omni_s3_real spare = widened * 0.5;
        const omni_s3_real distance = nearest + spare;
        const bool farther = least < distance;
        const bool clear = filled && farther;
        const omni_s3_real near = clear ? distance : least;
        const omni_s3_real far = width - near;
        const omni_s3_real a = upper_nearer ? far : near;
        const omni_s3_real b = upper_nearer ? near : far;
        const omni_s3_real e_raw = omni_s3_normalized_error(a, b, width);
        const bool e_held_above = (-0.99) < e_raw;
        const omni_s3_real e_held_raised = e_held_above ? e_raw : (-0.99);
        const bool e_held_over = 0.99 < e_held_raised;
        const omni_s3_real e_held = e_held_over ? 0.99 : e_held_raised;
        omni_s3_real epsilon_near;
        omni_s3_real xi_i;
        omni_s3_transformed_error(near, far, &epsilon_near, &xi_i);
        const omni_s3_real epsilon_i = gain * epsilon_near;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_room = isfinite(room) != 0;
        const bool finite = finite_x && finite_room;
        const omni_s3_real e_settled = empty ? 0.0 : e_held;
        const omni_s3_real e_out = finite ? e_settled : (omni_s3_real)NAN;
        e[i] = e_out;
        const omni_s3_real epsilon_settled = empty ? 0.0 : epsilon_i;
        const omni_s3_real epsilon_out = finite ? epsilon_settled : (omni_s3_real)NAN;
        epsilon[i] = epsilon_out;
        const omni_s3_real xi_settled = empty ? 0.0 : xi_i;
        const omni_s3_real xi_out = finite ? xi_settled : (omni_s3_real)NAN;
        xi[i] = xi_out;
    }
}
