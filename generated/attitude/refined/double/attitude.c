/* attitude.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (attitude.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.06 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= [0.045, 0.03, 0.04], 0.91 <= g_ii <= 1.09, |g_ij| <= [0.1, 0.03, 0.035], x measured to 0.0005, v measured to
 * 0.0005: |e| of v + lambda x < [0.8474, 0.8001, 0.8001], |u| <= [0.09, 0.06, 0.08].
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "attitude.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "attitude.c: compile without -ffast-math; it tests its inputs for NaN and infinity"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1)
#error "attitude.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif

/* B-spline control points divided by 6, one row for each of 32 + 3 points:
 * lower[0], upper[0], lower[1], upper[1], lower[2], upper[2]
 * Multiples of 2^-22: exact in float and double.
 */
static const attitude_real attitude_coefficients[210] = {
    -0.01666402816772461, 0.01666402816772461, -0.08289361000061035, -0.04956531524658203,
    -0.1828937530517578, -0.1495654582977295,
    -0.01666402816772461, 0.01666402816772461, -0.08354926109313965, -0.05022120475769043,
    -0.1835494041442871, -0.1502211093902588,
    -0.01666402816772461, 0.01666402816772461, -0.08289361000061035, -0.04956531524658203,
    -0.1828937530517578, -0.1495654582977295,
    -0.01666402816772461, 0.01666402816772461, -0.08092665672302246, -0.04759836196899414,
    -0.18092679977416992, -0.1475985050201416,
    -0.01666402816772461, 0.01666402816772461, -0.07764816284179688, -0.044319868087768555,
    -0.17764830589294434, -0.14432001113891602,
    -0.01666402816772461, 0.01666402816772461, -0.0730583667755127, -0.03973031044006348,
    -0.17305874824523926, -0.13973045349121094,
    -0.01666402816772461, 0.01666402816772461, -0.06715726852416992, -0.0338289737701416,
    -0.16715764999389648, -0.13382935523986816,
    -0.01666402816772461, 0.01666402816772461, -0.059944868087768555, -0.026616573333740234,
    -0.15994501113891602, -0.1266169548034668,
    -0.01666402816772461, 0.01666402816772461, -0.05142092704772949, -0.018092632293701172,
    -0.15142130851745605, -0.11809301376342773,
    -0.01666402816772461, 0.01666402816772461, -0.041585683822631836, -0.008257389068603516,
    -0.1415860652923584, -0.10825777053833008,
    -0.01666402816772461, 0.01666402816772461, -0.030439138412475586, 0.0028891563415527344,
    -0.13043951988220215, -0.09711122512817383,
    -0.01666402816772461, 0.01666402816772461, -0.017981290817260742, 0.015347003936767578,
    -0.1179816722869873, -0.08465337753295898,
    -0.01666402816772461, 0.01666402816772461, -0.0043447017669677734, 0.028983592987060547,
    -0.10421252250671387, -0.07088422775268555,
    -0.01666402816772461, 0.01666402816772461, 0.009126424789428711, 0.04245471954345703,
    -0.08913183212280273, -0.055803537368774414,
    -0.01666402816772461, 0.01666402816772461, 0.0212862491607666, 0.05461454391479492,
    -0.07273983955383301, -0.03941154479980469,
    -0.01666402816772461, 0.01666402816772461, 0.0321347713470459, 0.06546282768249512,
    -0.05503654479980469, -0.021708250045776367,
    -0.01666402816772461, 0.01666402816772461, 0.0416717529296875, 0.07500004768371582,
    -0.03602170944213867, -0.0026934146881103516,
    -0.01666402816772461, 0.01666402816772461, 0.04989743232727051, 0.08322572708129883,
    -0.015695571899414062, 0.017632484436035156,
    -0.01666402816772461, 0.01666402816772461, 0.05681180953979492, 0.09014010429382324,
    0.0039746761322021484, 0.03730297088623047,
    -0.01666402816772461, 0.01666402816772461, 0.06241488456726074, 0.09574294090270996,
    0.022333860397338867, 0.05566215515136719,
    -0.01666402816772461, 0.01666402816772461, 0.06670641899108887, 0.10003471374511719,
    0.03938150405883789, 0.07270979881286621,
    -0.01666402816772461, 0.01666402816772461, 0.0696866512298584, 0.10301494598388672,
    0.05511784553527832, 0.08844614028930664,
    -0.01666402816772461, 0.01666402816772461, 0.07135558128356934, 0.10468387603759766,
    0.06954288482666016, 0.10287117958068848,
    -0.01666402816772461, 0.01666402816772461, 0.07171297073364258, 0.1050412654876709,
    0.0826566219329834, 0.11598491668701172,
    -0.01666402816772461, 0.01666402816772461, 0.07075929641723633, 0.10408759117126465,
    0.09445881843566895, 0.12778711318969727,
    -0.01666402816772461, 0.01666402816772461, 0.06849408149719238, 0.1018223762512207,
    0.1049497127532959, 0.13827800750732422,
    -0.01666402816772461, 0.01666402816772461, 0.06491756439208984, 0.09824562072753906,
    0.11412930488586426, 0.14745759963989258,
    -0.01666402816772461, 0.01666402816772461, 0.06002950668334961, 0.09335780143737793,
    0.12199759483337402, 0.15532565116882324,
    -0.01666402816772461, 0.01666402816772461, 0.05478405952453613, 0.08811235427856445,
    0.1285543441772461, 0.16188263893127441,
    -0.01666402816772461, 0.01666402816772461, 0.049538612365722656, 0.08286690711975098,
    0.13379979133605957, 0.1671280860900879,
    -0.01666402816772461, 0.01666402816772461, 0.04560446739196777, 0.0789327621459961,
    0.13773393630981445, 0.17106199264526367,
    -0.01666402816772461, 0.01666402816772461, 0.042981863021850586, 0.0763101577758789,
    0.14035654067993164, 0.17368483543395996,
    -0.01666402816772461, 0.01666402816772461, 0.04167056083679199, 0.07499861717224121,
    0.14166784286499023, 0.17499613761901855,
    -0.01666402816772461, 0.01666402816772461, 0.04167056083679199, 0.07499861717224121,
    0.14166784286499023, 0.17499613761901855,
    -0.01666402816772461, 0.01666402816772461, 0.04167056083679199, 0.07499861717224121,
    0.14166784286499023, 0.17499613761901855
};

/* Gain k of the control law, by component. */
static const attitude_real attitude_gain[3] = {
    0.000301, 0.000202, 0.000255
};

/* Saturation of u, by component. */
static const attitude_real attitude_u_max[3] = {
    0.09, 0.06, 0.07999999999999999
};

/* Covered starts have x strictly above these bounds, by component. */
static const attitude_real attitude_start_lower[3] = {
    -0.07948733520507777, -0.47948738288879356, -1.0794881458282466
};

/* Covered starts have x strictly below these bounds, by component. */
static const attitude_real attitude_start_upper[3] = {
    0.07948733520507777, -0.3205123310089115, -0.9205123310089115
};

/* The same of v + lambda x: strictly above these bounds. */
static const attitude_real attitude_filtered_start_lower[3] = {
    -0.009038480224609197, -0.057038485946655074, -0.1290385774993894
};

/* The same of v + lambda x: strictly below these bounds. */
static const attitude_real attitude_filtered_start_upper[3] = {
    0.009038480224609197, -0.03896147972106954, -0.11096147972106957
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 60 s).
 */
static inline void attitude_segment(attitude_real t, int32_t *row, attitude_real *s)
{
    const bool positive = 0.0 < t;
    const attitude_real started = positive ? t : 0.0;
    const attitude_real scaled = started * 0.5333333333333333;
    const bool early = scaled < 31.999999999999996;
    const attitude_real u = early ? scaled : 31.999999999999996;
    const int32_t segment = (int32_t)u;
    const attitude_real base = (attitude_real)segment;
    const attitude_real place = u - base;
    const int32_t first = segment * 6;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void attitude_basis(attitude_real s, attitude_real *w0, attitude_real *w1, attitude_real *w2,
                                  attitude_real *w3)
{
    const attitude_real v0 = 1.0 - s;
    const attitude_real v1 = v0 * v0;
    const attitude_real v2 = v1 * v0;
    const attitude_real v3 = v0 * s;
    const attitude_real v4 = 1.0 + v3;
    const attitude_real v5 = 3.0 * v4;
    const attitude_real v6 = v0 * v5;
    const attitude_real v7 = 1.0 + v6;
    const attitude_real v8 = s * v5;
    const attitude_real v9 = 1.0 + v8;
    const attitude_real v10 = s * s;
    const attitude_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void attitude_basis_rate(attitude_real s, attitude_real *dw0, attitude_real *dw1,
                                       attitude_real *dw2, attitude_real *dw3)
{
    const attitude_real v0 = 1.0 - s;
    const attitude_real v1 = v0 + v0;
    const attitude_real v2 = v0 * v1;
    const attitude_real v3 = v0 * v0;
    const attitude_real v4 = v2 + v3;
    const attitude_real v5 = -v4;
    const attitude_real v6 = v0 - s;
    const attitude_real v7 = 3.0 * v6;
    const attitude_real v8 = v0 * v7;
    const attitude_real v9 = v0 * s;
    const attitude_real v10 = 1.0 + v9;
    const attitude_real v11 = 3.0 * v10;
    const attitude_real v12 = v8 - v11;
    const attitude_real v13 = s * v7;
    const attitude_real v14 = v11 + v13;
    const attitude_real v15 = s + s;
    const attitude_real v16 = s * v15;
    const attitude_real v17 = s * s;
    const attitude_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j. */
static inline attitude_real attitude_blend(attitude_real w0, attitude_real w1, attitude_real w2,
                                           attitude_real w3, attitude_real q0, attitude_real q1,
                                           attitude_real q2, attitude_real q3)
{
    const attitude_real v0 = w0 * q0;
    const attitude_real v1 = w1 * q1;
    const attitude_real v2 = v0 + v1;
    const attitude_real v3 = w2 * q2;
    const attitude_real v4 = w3 * q3;
    const attitude_real v5 = v3 + v4;
    const attitude_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline attitude_real attitude_normalized_error(attitude_real a, attitude_real b, attitude_real width)
{
    const attitude_real v0 = a - b;
    const attitude_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void attitude_transformed_error(attitude_real a, attitude_real b, attitude_real *epsilon,
                                              attitude_real *xi)
{
    const attitude_real v0 = b / a;
    const attitude_real v1 = log(v0);
    const attitude_real v2 = -v1;
    const attitude_real v3 = 1.0 + v0;
    const attitude_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline attitude_real attitude_law(attitude_real k, attitude_real xi, attitude_real epsilon)
{
    const attitude_real v0 = k * xi;
    const attitude_real v1 = v0 * epsilon;
    const attitude_real v2 = -v1;
    return v2;
}

void attitude_tube(attitude_real t, attitude_real lower[ATTITUDE_N], attitude_real upper[ATTITUDE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (attitude_real)NAN;
            upper[j] = (attitude_real)NAN;
        }
        return;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real w0;
    attitude_real w1;
    attitude_real w2;
    attitude_real w3;
    attitude_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_edge = attitude_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        lower[i] = lower_edge;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_edge = attitude_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        upper[i] = upper_edge;
    }
}

void attitude_tube_rate(attitude_real t, attitude_real lower_rate[ATTITUDE_N],
                        attitude_real upper_rate[ATTITUDE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower_rate[j] = (attitude_real)NAN;
            upper_rate[j] = (attitude_real)NAN;
        }
        return;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real dw0;
    attitude_real dw1;
    attitude_real dw2;
    attitude_real dw3;
    attitude_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 60.0;
    const attitude_real per_second = moving ? 0.5333333333333333 : 0.0;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_slope = attitude_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_speed = lower_slope * per_second;
        lower_rate[i] = lower_speed;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_slope = attitude_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_speed = upper_slope * per_second;
        upper_rate[i] = upper_speed;
    }
}

void attitude_filtered_tube(attitude_real t, attitude_real lower[ATTITUDE_N], attitude_real upper[ATTITUDE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (attitude_real)NAN;
            upper[j] = (attitude_real)NAN;
        }
        return;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real w0;
    attitude_real w1;
    attitude_real w2;
    attitude_real w3;
    attitude_basis(s, &w0, &w1, &w2, &w3);
    attitude_real dw0;
    attitude_real dw1;
    attitude_real dw2;
    attitude_real dw3;
    attitude_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_edge = attitude_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_slope = attitude_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_rate = lower_slope * 0.5333333333333333;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_edge = attitude_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_slope = attitude_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_rate = upper_slope * 0.5333333333333333;
        const attitude_real filtered = lower_edge * 0.12;
        const attitude_real edge = lower_rate + filtered;
        lower[i] = edge;
        const attitude_real filtered2 = upper_edge * 0.12;
        const attitude_real edge2 = upper_rate + filtered2;
        upper[i] = edge2;
    }
}

attitude_status attitude_control(attitude_real t, const attitude_real x[ATTITUDE_N],
                                 const attitude_real v[ATTITUDE_N], attitude_real u[ATTITUDE_N])
{
    const attitude_real t_zero = t * 0.0;
    attitude_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const attitude_real x_j = x[j];
        const attitude_real x_zero = x_j * 0.0;
        const attitude_real zeros = zero + x_zero;
        zero = zeros;
    }
    attitude_real zero2 = zero;
    for (int32_t j2 = 0; j2 < 3; ++j2) {
        const attitude_real v_j = v[j2];
        const attitude_real v_zero = v_j * 0.0;
        const attitude_real zeros2 = zero2 + v_zero;
        zero2 = zeros2;
    }
    const bool finite = zero2 <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j3 = 0; j3 < 3; ++j3) {
            u[j3] = 0.0;
        }
        return ATTITUDE_BAD_INPUT;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real w0;
    attitude_real w1;
    attitude_real w2;
    attitude_real w3;
    attitude_basis(s, &w0, &w1, &w2, &w3);
    attitude_real dw0;
    attitude_real dw1;
    attitude_real dw2;
    attitude_real dw3;
    attitude_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    bool outside = false;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_edge = attitude_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_slope = attitude_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_rate = lower_slope * 0.5333333333333333;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_edge = attitude_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_slope = attitude_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_rate = upper_slope * 0.5333333333333333;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real room = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real room2 = upper_rate - lower_rate;
        const attitude_real to_lower2 = v_i - lower_rate;
        const attitude_real to_upper2 = upper_rate - v_i;
        const attitude_real gain_i = attitude_gain[i];
        const attitude_real gain_minus = -gain_i;
        const attitude_real filtered = room * 0.12;
        const attitude_real room3 = room2 + filtered;
        const attitude_real filtered2 = to_lower * 0.12;
        const attitude_real to_lower3 = to_lower2 + filtered2;
        const attitude_real filtered3 = to_upper * 0.12;
        const attitude_real to_upper3 = to_upper2 + filtered3;
        const bool upper_nearer = to_upper3 < to_lower3;
        const attitude_real nearest = upper_nearer ? to_upper3 : to_lower3;
        const attitude_real gain = upper_nearer ? gain_minus : gain_i;
        const attitude_real least = room3 * 0.005;
        const bool clear = least < nearest;
        const attitude_real near = clear ? nearest : least;
        const attitude_real far = room3 - near;
        const bool over = 0.0 < to_lower;
        const bool under = 0.0 < to_upper;
        const bool between = over && under;
        const bool within = 0.0 < nearest;
        const bool inside = within && between;
        const bool outside_any = inside ? outside : true;
        const attitude_real u_limit = attitude_u_max[i];
        attitude_real epsilon;
        attitude_real xi;
        attitude_transformed_error(near, far, &epsilon, &xi);
        const attitude_real push = attitude_law(gain, xi, epsilon);
        const attitude_real u_min = -u_limit;
        const bool u_held_above = u_min < push;
        const attitude_real u_held_raised = u_held_above ? push : u_min;
        const bool u_held_over = u_limit < u_held_raised;
        const attitude_real u_held = u_held_over ? u_limit : u_held_raised;
        u[i] = u_held;
        outside = outside_any;
    }
    return outside ? ATTITUDE_OUTSIDE_TUBE : ATTITUDE_OK;
}

attitude_real attitude_margin(attitude_real t, const attitude_real x[ATTITUDE_N],
                              const attitude_real v[ATTITUDE_N])
{
    const attitude_real t_zero = t * 0.0;
    attitude_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const attitude_real x_j = x[j];
        const attitude_real x_zero = x_j * 0.0;
        const attitude_real zeros = zero + x_zero;
        zero = zeros;
    }
    attitude_real zero2 = zero;
    for (int32_t j2 = 0; j2 < 3; ++j2) {
        const attitude_real v_j = v[j2];
        const attitude_real v_zero = v_j * 0.0;
        const attitude_real zeros2 = zero2 + v_zero;
        zero2 = zeros2;
    }
    const bool finite = zero2 <= 0.0;
    const bool bad = !finite;
    if (bad) {
        return (attitude_real)NAN;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real w0;
    attitude_real w1;
    attitude_real w2;
    attitude_real w3;
    attitude_basis(s, &w0, &w1, &w2, &w3);
    attitude_real dw0;
    attitude_real dw1;
    attitude_real dw2;
    attitude_real dw3;
    attitude_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    attitude_real margin = 0.5;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_edge = attitude_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_slope = attitude_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_rate = lower_slope * 0.5333333333333333;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_edge = attitude_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_slope = attitude_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_rate = upper_slope * 0.5333333333333333;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real room = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real room2 = upper_rate - lower_rate;
        const attitude_real to_lower2 = v_i - lower_rate;
        const attitude_real to_upper2 = upper_rate - v_i;
        const attitude_real filtered = room * 0.12;
        const attitude_real room3 = room2 + filtered;
        const attitude_real filtered2 = to_lower * 0.12;
        const attitude_real to_lower3 = to_lower2 + filtered2;
        const attitude_real filtered3 = to_upper * 0.12;
        const attitude_real to_upper3 = to_upper2 + filtered3;
        const bool upper_nearer = to_upper3 < to_lower3;
        const attitude_real nearest = upper_nearer ? to_upper3 : to_lower3;
        const attitude_real share = nearest / room3;
        const bool beyond = share < (-1.0);
        const attitude_real held_share = beyond ? (-1.0) : share;
        const bool upper_nearer2 = to_upper < to_lower;
        const attitude_real nearest2 = upper_nearer2 ? to_upper : to_lower;
        const attitude_real share2 = nearest2 / room;
        const bool beyond2 = share2 < (-1.0);
        const attitude_real held_share2 = beyond2 ? (-1.0) : share2;
        const bool filtered_less = held_share < held_share2;
        const attitude_real lesser = filtered_less ? held_share : held_share2;
        const bool less = lesser < margin;
        const attitude_real margin_next = less ? lesser : margin;
        margin = margin_next;
    }
    return margin;
}

void attitude_margins(attitude_real t, const attitude_real x[ATTITUDE_N], const attitude_real v[ATTITUDE_N],
                      attitude_real margin[ATTITUDE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            margin[j] = (attitude_real)NAN;
        }
        return;
    }
    int32_t row;
    attitude_real s;
    attitude_segment(t, &row, &s);
    attitude_real w0;
    attitude_real w1;
    attitude_real w2;
    attitude_real w3;
    attitude_basis(s, &w0, &w1, &w2, &w3);
    attitude_real dw0;
    attitude_real dw1;
    attitude_real dw2;
    attitude_real dw3;
    attitude_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const attitude_real lower_q0 = attitude_coefficients[at];
        const int32_t lower_1 = at + 6;
        const attitude_real lower_q1 = attitude_coefficients[lower_1];
        const int32_t lower_2 = at + 12;
        const attitude_real lower_q2 = attitude_coefficients[lower_2];
        const int32_t lower_3 = at + 18;
        const attitude_real lower_q3 = attitude_coefficients[lower_3];
        const attitude_real lower_edge = attitude_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_slope = attitude_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const attitude_real lower_rate = lower_slope * 0.5333333333333333;
        const int32_t upper_0 = at + 1;
        const attitude_real upper_q0 = attitude_coefficients[upper_0];
        const int32_t upper_1 = at + 7;
        const attitude_real upper_q1 = attitude_coefficients[upper_1];
        const int32_t upper_2 = at + 13;
        const attitude_real upper_q2 = attitude_coefficients[upper_2];
        const int32_t upper_3 = at + 19;
        const attitude_real upper_q3 = attitude_coefficients[upper_3];
        const attitude_real upper_edge = attitude_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_slope = attitude_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const attitude_real upper_rate = upper_slope * 0.5333333333333333;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real room = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real room2 = upper_rate - lower_rate;
        const attitude_real to_lower2 = v_i - lower_rate;
        const attitude_real to_upper2 = upper_rate - v_i;
        const attitude_real filtered = room * 0.12;
        const attitude_real room3 = room2 + filtered;
        const attitude_real filtered2 = to_lower * 0.12;
        const attitude_real to_lower3 = to_lower2 + filtered2;
        const attitude_real filtered3 = to_upper * 0.12;
        const attitude_real to_upper3 = to_upper2 + filtered3;
        const bool upper_nearer = to_upper3 < to_lower3;
        const attitude_real nearest = upper_nearer ? to_upper3 : to_lower3;
        const attitude_real share = nearest / room3;
        const bool beyond = share < (-1.0);
        const attitude_real held_share = beyond ? (-1.0) : share;
        const bool upper_nearer2 = to_upper < to_lower;
        const attitude_real nearest2 = upper_nearer2 ? to_upper : to_lower;
        const attitude_real share2 = nearest2 / room;
        const bool beyond2 = share2 < (-1.0);
        const attitude_real held_share2 = beyond2 ? (-1.0) : share2;
        const bool filtered_less = held_share < held_share2;
        const attitude_real lesser = filtered_less ? held_share : held_share2;
        margin[i] = lesser;
    }
}

bool attitude_covered(const attitude_real x[ATTITUDE_N], const attitude_real v[ATTITUDE_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 3; ++i) {
        const attitude_real x_i = x[i];
        const attitude_real start_lower_i = attitude_start_lower[i];
        const attitude_real start_upper_i = attitude_start_upper[i];
        const bool x_i_after = start_lower_i < x_i;
        const bool x_i_before = x_i < start_upper_i;
        const bool x_i_between = x_i_after && x_i_before;
        const attitude_real filtered = x_i * 0.12;
        const attitude_real v_i = v[i];
        const attitude_real z = v_i + filtered;
        const attitude_real filtered_start_lower_i = attitude_filtered_start_lower[i];
        const attitude_real filtered_start_upper_i = attitude_filtered_start_upper[i];
        const bool z_after = filtered_start_lower_i < z;
        const bool z_before = z < filtered_start_upper_i;
        const bool z_between = z_after && z_before;
        const bool inside = x_i_between && z_between;
        const bool covered_next = inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void attitude_transform(const attitude_real lower[ATTITUDE_N], const attitude_real upper[ATTITUDE_N],
                        const attitude_real x[ATTITUDE_N], attitude_real e[ATTITUDE_N],
                        attitude_real epsilon[ATTITUDE_N], attitude_real xi[ATTITUDE_N])
{
    for (int32_t i = 0; i < 3; ++i) {
        const attitude_real lower_edge = lower[i];
        const attitude_real upper_edge = upper[i];
        const attitude_real x_i = x[i];
        const attitude_real room = upper_edge - lower_edge;
        const bool filled = 0.0 < room;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < room;
        const attitude_real width = wide ? room : 9.5367431640625e-7;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const attitude_real nearest = upper_nearer ? to_upper : to_lower;
        const attitude_real gain = upper_nearer ? (-1.0) : 1.0;
        const attitude_real least = width * 0.005;
        const attitude_real widened = width - room;
        const attitude_real spare = widened * 0.5;
        const attitude_real distance = nearest + spare;
        const bool farther = least < distance;
        const bool clear = filled && farther;
        const attitude_real near = clear ? distance : least;
        const attitude_real far = width - near;
        const attitude_real a = upper_nearer ? far : near;
        const attitude_real b = upper_nearer ? near : far;
        const attitude_real e_raw = attitude_normalized_error(a, b, width);
        const bool e_held_above = (-0.99) < e_raw;
        const attitude_real e_held_raised = e_held_above ? e_raw : (-0.99);
        const bool e_held_over = 0.99 < e_held_raised;
        const attitude_real e_held = e_held_over ? 0.99 : e_held_raised;
        attitude_real epsilon_near;
        attitude_real xi_i;
        attitude_transformed_error(near, far, &epsilon_near, &xi_i);
        const attitude_real epsilon_i = gain * epsilon_near;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_room = isfinite(room) != 0;
        const bool finite = finite_x && finite_room;
        const attitude_real e_settled = empty ? 0.0 : e_held;
        const attitude_real e_out = finite ? e_settled : (attitude_real)NAN;
        e[i] = e_out;
        const attitude_real epsilon_settled = empty ? 0.0 : epsilon_i;
        const attitude_real epsilon_out = finite ? epsilon_settled : (attitude_real)NAN;
        epsilon[i] = epsilon_out;
        const attitude_real xi_settled = empty ? 0.0 : xi_i;
        const attitude_real xi_out = finite ? xi_settled : (attitude_real)NAN;
        xi[i] = xi_out;
    }
}
