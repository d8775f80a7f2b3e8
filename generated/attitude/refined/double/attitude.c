/* attitude.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (attitude.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.06 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= [0.045, 0.03, 0.04], 0.91 <= g_ii <= 1.09, |g_ij| <= [0.1, 0.03, 0.035], x measured to 0.0005, v measured to
 * 0.0005: |e| of v + lambda x < [0.9021, 0.84, 0.8665], |u| <= [0.09, 0.06, 0.08].
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "attitude.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "attitude.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "attitude.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "attitude.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "attitude.c: double is not IEEE-754's here, for which rounding is bounded"
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
    0.00012, 0.000078, 0.0000977
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

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline attitude_real attitude_edge_at(int32_t at, attitude_real w0, attitude_real w1, attitude_real w2,
                                             attitude_real w3)
{
    const attitude_real q0 = attitude_coefficients[at];
    const int32_t at_1 = at + 6;
    const attitude_real q1 = attitude_coefficients[at_1];
    const int32_t at_2 = at + 12;
    const attitude_real q2 = attitude_coefficients[at_2];
    const int32_t at_3 = at + 18;
    const attitude_real q3 = attitude_coefficients[at_3];
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_edge = attitude_edge_at(lower_at, w0, w1, w2, w3);
        const attitude_real upper_edge = attitude_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_slope = attitude_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const attitude_real lower_speed = lower_slope * per_second;
        const attitude_real upper_slope = attitude_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const attitude_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_edge = attitude_edge_at(lower_at, w0, w1, w2, w3);
        const attitude_real upper_edge = attitude_edge_at(upper_at, w0, w1, w2, w3);
        const attitude_real lower_slope = attitude_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const attitude_real lower_rate = lower_slope * 0.5333333333333333;
        const attitude_real upper_slope = attitude_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const attitude_real upper_rate = upper_slope * 0.5333333333333333;
        const attitude_real lower_part = lower_edge * 0.12;
        const attitude_real z_lower = lower_rate + lower_part;
        lower[i] = z_lower;
        const attitude_real upper_part = upper_edge * 0.12;
        const attitude_real z_upper = upper_rate + upper_part;
        upper[i] = z_upper;
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
    attitude_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const attitude_real v_k = v[k];
        const attitude_real v_zero = v_k * 0.0;
        const attitude_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 3; ++m) {
            u[m] = 0.0;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_edge = attitude_edge_at(lower_at, w0, w1, w2, w3);
        const attitude_real upper_edge = attitude_edge_at(upper_at, w0, w1, w2, w3);
        const attitude_real lower_slope = attitude_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const attitude_real lower_rate = lower_slope * 0.5333333333333333;
        const attitude_real upper_slope = attitude_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const attitude_real upper_rate = upper_slope * 0.5333333333333333;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real width = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real v_width = upper_rate - lower_rate;
        const attitude_real v_to_lower = v_i - lower_rate;
        const attitude_real v_to_upper = upper_rate - v_i;
        const attitude_real gain_i = attitude_gain[i];
        const attitude_real gain_minus = -gain_i;
        const attitude_real width_part = width * 0.12;
        const attitude_real z_width = v_width + width_part;
        const attitude_real lower_part = to_lower * 0.12;
        const attitude_real z_to_lower = v_to_lower + lower_part;
        const attitude_real upper_part = to_upper * 0.12;
        const attitude_real z_to_upper = v_to_upper + upper_part;
        const bool upper_nearer = z_to_upper < z_to_lower;
        const attitude_real distance = upper_nearer ? z_to_upper : z_to_lower;
        const attitude_real gain = upper_nearer ? gain_minus : gain_i;
        const attitude_real smallest = z_width * 0.005;
        const bool clear = smallest < distance;
        const attitude_real to_nearer = clear ? distance : smallest;
        const attitude_real to_farther = z_width - to_nearer;
        const bool x_above = 0.0 < to_lower;
        const bool x_below = 0.0 < to_upper;
        const bool x_inside = x_above && x_below;
        const bool z_inside = 0.0 < distance;
        const bool inside = z_inside && x_inside;
        const bool outside_next = inside ? outside : true;
        const attitude_real u_limit = attitude_u_max[i];
        attitude_real epsilon;
        attitude_real xi;
        attitude_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const attitude_real u_i = attitude_law(gain, xi, epsilon);
        const attitude_real u_min = -u_limit;
        const bool u_above = u_min < u_i;
        const attitude_real u_raised = u_above ? u_i : u_min;
        const bool u_beyond = u_limit < u_raised;
        const attitude_real u_limited = u_beyond ? u_limit : u_raised;
        u[i] = u_limited;
        outside = outside_next;
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
    attitude_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const attitude_real v_k = v[k];
        const attitude_real v_zero = v_k * 0.0;
        const attitude_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_edge = attitude_edge_at(lower_at, w0, w1, w2, w3);
        const attitude_real upper_edge = attitude_edge_at(upper_at, w0, w1, w2, w3);
        const attitude_real lower_slope = attitude_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const attitude_real lower_rate = lower_slope * 0.5333333333333333;
        const attitude_real upper_slope = attitude_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const attitude_real upper_rate = upper_slope * 0.5333333333333333;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real width = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real v_width = upper_rate - lower_rate;
        const attitude_real v_to_lower = v_i - lower_rate;
        const attitude_real v_to_upper = upper_rate - v_i;
        const attitude_real width_part = width * 0.12;
        const attitude_real z_width = v_width + width_part;
        const attitude_real lower_part = to_lower * 0.12;
        const attitude_real z_to_lower = v_to_lower + lower_part;
        const attitude_real upper_part = to_upper * 0.12;
        const attitude_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const attitude_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const attitude_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0);
        const attitude_real margin_z = z_beyond ? (-1.0) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const attitude_real x_distance = x_nearer ? to_upper : to_lower;
        const attitude_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const attitude_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const attitude_real smaller = x_smaller ? margin_x : margin_z;
        const bool less = smaller < margin;
        const attitude_real margin_next = less ? smaller : margin;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const attitude_real lower_edge = attitude_edge_at(lower_at, w0, w1, w2, w3);
        const attitude_real upper_edge = attitude_edge_at(upper_at, w0, w1, w2, w3);
        const attitude_real lower_slope = attitude_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const attitude_real lower_rate = lower_slope * 0.5333333333333333;
        const attitude_real upper_slope = attitude_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const attitude_real upper_rate = upper_slope * 0.5333333333333333;
        const attitude_real x_i = x[i];
        const attitude_real v_i = v[i];
        const attitude_real width = upper_edge - lower_edge;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const attitude_real v_width = upper_rate - lower_rate;
        const attitude_real v_to_lower = v_i - lower_rate;
        const attitude_real v_to_upper = upper_rate - v_i;
        const attitude_real width_part = width * 0.12;
        const attitude_real z_width = v_width + width_part;
        const attitude_real lower_part = to_lower * 0.12;
        const attitude_real z_to_lower = v_to_lower + lower_part;
        const attitude_real upper_part = to_upper * 0.12;
        const attitude_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const attitude_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const attitude_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0);
        const attitude_real margin_z = z_beyond ? (-1.0) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const attitude_real x_distance = x_nearer ? to_upper : to_lower;
        const attitude_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const attitude_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const attitude_real smaller = x_smaller ? margin_x : margin_z;
        margin[i] = smaller;
    }
}

bool attitude_covered(const attitude_real x[ATTITUDE_N], const attitude_real v[ATTITUDE_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 3; ++i) {
        const attitude_real x_i = x[i];
        const attitude_real x_lower = attitude_start_lower[i];
        const attitude_real x_upper = attitude_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const attitude_real x_part = x_i * 0.12;
        const attitude_real v_i = v[i];
        const attitude_real z_i = v_i + x_part;
        const attitude_real z_lower = attitude_filtered_start_lower[i];
        const attitude_real z_upper = attitude_filtered_start_upper[i];
        const bool z_above = z_lower < z_i;
        const bool z_below = z_i < z_upper;
        const bool z_inside = z_above && z_below;
        const bool inside = x_inside && z_inside;
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
        const attitude_real width = upper_edge - lower_edge;
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const attitude_real safe_width = wide ? width : 9.5367431640625e-7;
        const attitude_real to_lower = x_i - lower_edge;
        const attitude_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const attitude_real distance = upper_nearer ? to_upper : to_lower;
        const attitude_real sign = upper_nearer ? (-1.0) : 1.0;
        const attitude_real smallest = safe_width * 0.005;
        const attitude_real widened = safe_width - width;
        const attitude_real half = widened * 0.5;
        const attitude_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const attitude_real to_nearer = clear ? safe_distance : smallest;
        const attitude_real to_farther = safe_width - to_nearer;
        const attitude_real a = upper_nearer ? to_farther : to_nearer;
        const attitude_real b = upper_nearer ? to_nearer : to_farther;
        const attitude_real e_i = attitude_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const attitude_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const attitude_real e_limited = e_beyond ? 0.99 : e_raised;
        attitude_real epsilon_nearer;
        attitude_real xi_i;
        attitude_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const attitude_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const attitude_real e_or_zero = empty ? 0.0 : e_limited;
        const attitude_real e_out = finite ? e_or_zero : (attitude_real)NAN;
        e[i] = e_out;
        const attitude_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const attitude_real epsilon_out = finite ? epsilon_or_zero : (attitude_real)NAN;
        epsilon[i] = epsilon_out;
        const attitude_real xi_or_zero = empty ? 0.0 : xi_i;
        const attitude_real xi_out = finite ? xi_or_zero : (attitude_real)NAN;
        xi[i] = xi_out;
    }
}
