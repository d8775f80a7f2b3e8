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

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "omni_s3.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "omni_s3.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "omni_s3.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "omni_s3.c: double is not IEEE-754's here, for which rounding is bounded"
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
static const omni_s3_real omni_s3_coefficients[140] = {
    0.679295539855957, 0.762608528137207, -0.022960662841796875, 0.060352325439453125,
    0.6666765213012695, 0.7499895095825195, 0.00001049041748046875, 0.08332347869873047,
    0.6540584564208984, 0.7373714447021484, 0.022980690002441406, 0.1062936782836914,
    0.6414403915405273, 0.7247533798217773, 0.045950889587402344, 0.12926387786865234,
    0.6288223266601562, 0.7121353149414062, 0.06892108917236328, 0.15223407745361328,
    0.6162033081054688, 0.6995162963867188, 0.09189224243164062, 0.17520523071289062,
    0.6035852432250977, 0.6868982315063477, 0.11486244201660156, 0.19817543029785156,
    0.5909671783447266, 0.6742801666259766, 0.1378326416015625, 0.2211456298828125,
    0.5783481597900391, 0.6616611480712891, 0.1616811752319336, 0.2449941635131836,
    0.565730094909668, 0.649043083190918, 0.1855325698852539, 0.2688455581665039,
    0.5531120300292969, 0.6364250183105469, 0.20938396453857422, 0.2926969528198242,
    0.5404939651489258, 0.6238069534301758, 0.23323440551757812, 0.3165473937988281,
    0.5278749465942383, 0.6111879348754883, 0.25708580017089844, 0.34039878845214844,
    0.5152568817138672, 0.5985698699951172, 0.28093624114990234, 0.36424922943115234,
    0.5215663909912109, 0.6048793792724609, 0.30478763580322266, 0.38810062408447266,
    0.5278749465942383, 0.6111879348754883, 0.32863807678222656, 0.41195106506347656,
    0.5404939651489258, 0.6238069534301758, 0.3524894714355469, 0.4358024597167969,
    0.5531120300292969, 0.6364250183105469, 0.3763399124145508, 0.4596529006958008,
    0.565730094909668, 0.649043083190918, 0.4001913070678711, 0.4835042953491211,
    0.5783481597900391, 0.6616611480712891, 0.424041748046875, 0.507354736328125,
    0.5909671783447266, 0.6742801666259766, 0.4478931427001953, 0.5312061309814453,
    0.6035852432250977, 0.6868982315063477, 0.4717435836791992, 0.5550565719604492,
    0.6162033081054688, 0.6995162963867188, 0.49559497833251953, 0.5789079666137695,
    0.6288223266601562, 0.7121353149414062, 0.5194454193115234, 0.6027584075927734,
    0.6414403915405273, 0.7247533798217773, 0.5432968139648438, 0.6266098022460938,
    0.6540584564208984, 0.7373714447021484, 0.5671482086181641, 0.6504611968994141,
    0.6666765213012695, 0.7499895095825195, 0.590998649597168, 0.674311637878418,
    0.679295539855957, 0.762608528137207, 0.6148500442504883, 0.6981630325317383,
    0.6919136047363281, 0.7752265930175781, 0.6387004852294922, 0.7220134735107422,
    0.7045316696166992, 0.7878446578979492, 0.6625518798828125, 0.7458648681640625,
    0.7171506881713867, 0.8004636764526367, 0.6864023208618164, 0.7697153091430664,
    0.7297687530517578, 0.8130817413330078, 0.7102537155151367, 0.7935667037963867,
    0.7423868179321289, 0.8256998062133789, 0.7341041564941406, 0.8174171447753906,
    0.7538137435913086, 0.8371267318725586, 0.7579555511474609, 0.8412685394287109,
    0.7423868179321289, 0.8256998062133789, 0.7341041564941406, 0.8174171447753906
};

/* Covered starts have x strictly above these bounds, by component. */
static const omni_s3_real omni_s3_start_lower[2] = {
    4.002559471130373, 0.0025613784790050166
};

/* Covered starts have x strictly below these bounds, by component. */
static const omni_s3_real omni_s3_start_upper[2] = {
    4.4974386215209945, 0.49744052886962775
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

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline omni_s3_real omni_s3_edge_at(int32_t at, omni_s3_real w0, omni_s3_real w1, omni_s3_real w2,
                                           omni_s3_real w3)
{
    const omni_s3_real q0 = omni_s3_coefficients[at];
    const int32_t at_1 = at + 4;
    const omni_s3_real q1 = omni_s3_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const omni_s3_real q2 = omni_s3_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const omni_s3_real q3 = omni_s3_coefficients[at_3];
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s3_real lower_edge = omni_s3_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s3_real upper_edge = omni_s3_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s3_real lower_slope = omni_s3_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const omni_s3_real lower_speed = lower_slope * per_second;
        const omni_s3_real upper_slope = omni_s3_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const omni_s3_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
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
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s3_real lower_edge = omni_s3_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s3_real upper_edge = omni_s3_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s3_real x_i = x[i];
        const omni_s3_real width = upper_edge - lower_edge;
        const omni_s3_real to_lower = x_i - lower_edge;
        const omni_s3_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s3_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s3_real gain = upper_nearer ? (-0.5) : 0.5;
        const omni_s3_real smallest = width * 0.005;
        const bool clear = smallest < distance;
        const omni_s3_real to_nearer = clear ? distance : smallest;
        const omni_s3_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
        const bool outside_next = inside ? outside : true;
        omni_s3_real epsilon;
        omni_s3_real xi;
        omni_s3_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const omni_s3_real u_i = omni_s3_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s3_real lower_edge = omni_s3_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s3_real upper_edge = omni_s3_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s3_real x_i = x[i];
        const omni_s3_real width = upper_edge - lower_edge;
        const omni_s3_real to_lower = x_i - lower_edge;
        const omni_s3_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s3_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s3_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const omni_s3_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool less = margin_x < margin;
        const omni_s3_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void omni_s3_margins(omni_s3_real t, const omni_s3_real x[OMNI_S3_N], omni_s3_real margin[OMNI_S3_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (omni_s3_real)NAN;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s3_real lower_edge = omni_s3_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s3_real upper_edge = omni_s3_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s3_real x_i = x[i];
        const omni_s3_real width = upper_edge - lower_edge;
        const omni_s3_real to_lower = x_i - lower_edge;
        const omni_s3_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s3_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s3_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const omni_s3_real margin_x = x_beyond ? (-1.0) : x_share;
        margin[i] = margin_x;
    }
}

bool omni_s3_covered(const omni_s3_real x[OMNI_S3_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s3_real x_i = x[i];
        const omni_s3_real x_lower = omni_s3_start_lower[i];
        const omni_s3_real x_upper = omni_s3_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void omni_s3_transform(const omni_s3_real lower[OMNI_S3_N], const omni_s3_real upper[OMNI_S3_N],
                       const omni_s3_real x[OMNI_S3_N], omni_s3_real e[OMNI_S3_N],
                       omni_s3_real epsilon[OMNI_S3_N], omni_s3_real xi[OMNI_S3_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s3_real lower_edge = lower[i];
        const omni_s3_real upper_edge = upper[i];
        const omni_s3_real x_i = x[i];
        const omni_s3_real width = upper_edge - lower_edge;
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const omni_s3_real safe_width = wide ? width : 9.5367431640625e-7;
        const omni_s3_real to_lower = x_i - lower_edge;
        const omni_s3_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s3_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s3_real sign = upper_nearer ? (-1.0) : 1.0;
        const omni_s3_real smallest = safe_width * 0.005;
        const omni_s3_real widened = safe_width - width;
        const omni_s3_real half = widened * 0.5;
        const omni_s3_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const omni_s3_real to_nearer = clear ? safe_distance : smallest;
        const omni_s3_real to_farther = safe_width - to_nearer;
        const omni_s3_real a = upper_nearer ? to_farther : to_nearer;
        const omni_s3_real b = upper_nearer ? to_nearer : to_farther;
        const omni_s3_real e_i = omni_s3_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const omni_s3_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const omni_s3_real e_limited = e_beyond ? 0.99 : e_raised;
        omni_s3_real epsilon_nearer;
        omni_s3_real xi_i;
        omni_s3_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const omni_s3_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const omni_s3_real e_or_zero = empty ? 0.0 : e_limited;
        const omni_s3_real e_out = finite ? e_or_zero : (omni_s3_real)NAN;
        e[i] = e_out;
        const omni_s3_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const omni_s3_real epsilon_out = finite ? epsilon_or_zero : (omni_s3_real)NAN;
        epsilon[i] = epsilon_out;
        const omni_s3_real xi_or_zero = empty ? 0.0 : xi_i;
        const omni_s3_real xi_out = finite ? xi_or_zero : (omni_s3_real)NAN;
        xi[i] = xi_out;
    }
}
