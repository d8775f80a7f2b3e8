/* waypoints.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (waypoints.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and carries out the mission.
 * Every x(t) that stays in the tube satisfies the mission (P10): (always[0, 1] home and always[3, 4] left and
 * always[6, 7] right and always[9, 10] left and always[12, 13] right and always[17, 18] goal); times are seconds of
 * t. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.031 s.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "waypoints.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "waypoints.c: compile without -ffast-math; it tests its inputs for NaN and infinity"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1)
#error "waypoints.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif

/* B-spline control points divided by 6, one row for each of 64 + 3 points:
 * lower[0], upper[0], lower[1], upper[1]
 * Multiples of 2^-18: exact in float and double.
 */
static const waypoints_real waypoints_coefficients[268] = {
    0.6596870422363281, 0.8484840393066406, 0.6610107421875, 0.8442535400390625,
    0.6667060852050781, 0.8332939147949219, 0.6667060852050781, 0.8332939147949219,
    0.6737289428710938, 0.8181037902832031, 0.6724052429199219, 0.8223304748535156,
    0.6807479858398438, 0.8029098510742188, 0.6781005859375, 0.8113670349121094,
    0.6877708435058594, 0.7877197265625, 0.6837959289550781, 0.8004074096679688,
    0.6947898864746094, 0.7947425842285156, 0.6894912719726562, 0.7894439697265625,
    0.9332389831542969, 1.0331916809082031, 0.9417457580566406, 1.0416984558105469,
    1.1716880798339844, 1.271636962890625, 1.228363037109375, 1.3283119201660156,
    1.4101333618164062, 1.5100860595703125, 1.5149765014648438, 1.61492919921875,
    1.4053688049316406, 1.5053176879882812, 1.8015899658203125, 1.9015426635742188,
    1.4006004333496094, 1.50054931640625, 2.088207244873047, 2.1881561279296875,
    1.3958320617675781, 1.4957809448242188, 2.3748207092285156, 2.474773406982422,
    1.3910636901855469, 1.4910163879394531, 2.4126319885253906, 2.5125808715820312,
    1.3862953186035156, 1.4862480163574219, 2.3748245239257812, 2.474773406982422,
    1.3815269470214844, 1.4814796447753906, 2.3697853088378906, 2.4697341918945312,
    1.3767585754394531, 1.4767112731933594, 2.36474609375, 2.4646987915039062,
    1.3719902038574219, 1.4719429016113281, 2.3597068786621094, 2.4596595764160156,
    1.5354461669921875, 1.6353950500488281, 2.196544647216797, 2.296497344970703,
    1.6988983154296875, 1.7988471984863281, 2.0333824157714844, 2.1333351135253906,
    1.8623504638671875, 1.9623031616210938, 1.8702201843261719, 1.9701690673828125,
    2.0258026123046875, 2.1257553100585938, 1.7070579528808594, 1.8070068359375,
    2.1892547607421875, 2.2892074584960938, 1.5438919067382812, 1.6438446044921875,
    2.352710723876953, 2.4526596069335938, 1.3807296752929688, 1.480682373046875,
    2.4000282287597656, 2.499980926513672, 1.3333549499511719, 1.4333038330078125,
    2.4000282287597656, 2.499980926513672, 1.3333549499511719, 1.4333038330078125,
    2.4000282287597656, 2.499980926513672, 1.3333549499511719, 1.4333038330078125,
    2.3526687622070312, 2.452617645263672, 1.3809814453125, 1.4809341430664062,
    2.1894187927246094, 2.2893714904785156, 1.5428848266601562, 1.6428375244140625,
    2.026172637939453, 2.1261253356933594, 1.7047882080078125, 1.8047409057617188,
    1.8629226684570312, 1.9628753662109375, 1.8666915893554688, 1.9666404724121094,
    1.699676513671875, 1.7996292114257812, 2.028594970703125, 2.1285438537597656,
    1.5364303588867188, 1.6363792419433594, 2.1904983520507812, 2.290447235107422,
    1.3731803894042969, 1.4731330871582031, 2.352397918701172, 2.452350616455078,
    1.3710212707519531, 1.4709701538085938, 2.4000282287597656, 2.499980926513672,
    1.3688583374023438, 1.46881103515625, 2.4000282287597656, 2.499980926513672,
    1.3666954040527344, 1.4666481018066406, 2.4000282287597656, 2.499980926513672,
    1.316680908203125, 1.4166336059570312, 2.4000282287597656, 2.499980926513672,
    1.36669921875, 1.4666481018066406, 2.3703880310058594, 2.4703407287597656,
    1.6166954040527344, 1.716644287109375, 2.1185379028320312, 2.2184906005859375,
    1.8666915893554688, 1.9666404724121094, 1.8666915893554688, 1.9666404724121094,
    2.116687774658203, 2.2166366577148438, 1.6148414611816406, 1.7147941589355469,
    2.3666839599609375, 2.466632843017578, 1.3629951477050781, 1.4629440307617188,
    2.4167022705078125, 2.516651153564453, 1.3333549499511719, 1.4333038330078125,
    2.3666839599609375, 2.466632843017578, 1.3333549499511719, 1.4333038330078125,
    2.3619232177734375, 2.461872100830078, 1.3333549499511719, 1.4333038330078125,
    2.3571624755859375, 2.457111358642578, 1.3333549499511719, 1.4333038330078125,
    2.352397918701172, 2.452350616455078, 1.3333549499511719, 1.4333038330078125,
    2.347637176513672, 2.447589874267578, 1.3333549499511719, 1.4333038330078125,
    2.342876434326172, 2.442829132080078, 1.3333549499511719, 1.4333038330078125,
    2.338115692138672, 2.4380645751953125, 1.3333549499511719, 1.4333038330078125,
    2.333354949951172, 2.4333038330078125, 1.3748207092285156, 1.4747734069824219,
    2.3285903930664062, 2.4285430908203125, 1.5675277709960938, 1.66748046875,
    2.3238296508789062, 2.4237823486328125, 1.7602348327636719, 1.8601875305175781,
    2.3190689086914062, 2.4190216064453125, 1.95294189453125, 2.0528907775878906,
    2.3143081665039062, 2.4142608642578125, 2.145648956298828, 2.2455978393554688,
    2.379199981689453, 2.4791526794433594, 2.3383522033691406, 2.438304901123047,
    2.5390625, 2.6390151977539062, 2.5310592651367188, 2.631011962890625,
    2.6989288330078125, 2.7988815307617188, 2.723766326904297, 2.823719024658203,
    2.858795166015625, 2.9587440490722656, 2.916473388671875, 3.0164222717285156,
    3.018657684326172, 3.118610382080078, 3.0042381286621094, 3.1041908264160156,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828,
    3.0666961669921875, 3.166645050048828, 3.0666961669921875, 3.166645050048828
};

/* Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 64 (t_c = 18 s).
 */
static inline void waypoints_segment(waypoints_real t, int32_t *row, waypoints_real *s)
{
    const bool positive = 0.0 < t;
    const waypoints_real started = positive ? t : 0.0;
    const waypoints_real scaled = started * 3.5555555555555554;
    const bool early = scaled < 63.99999999999999;
    const waypoints_real u = early ? scaled : 63.99999999999999;
    const int32_t segment = (int32_t)u;
    const waypoints_real base = (waypoints_real)segment;
    const waypoints_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void waypoints_basis(waypoints_real s, waypoints_real *w0, waypoints_real *w1, waypoints_real *w2,
                                   waypoints_real *w3)
{
    const waypoints_real v0 = 1.0 - s;
    const waypoints_real v1 = v0 * v0;
    const waypoints_real v2 = v1 * v0;
    const waypoints_real v3 = v0 * s;
    const waypoints_real v4 = 1.0 + v3;
    const waypoints_real v5 = 3.0 * v4;
    const waypoints_real v6 = v0 * v5;
    const waypoints_real v7 = 1.0 + v6;
    const waypoints_real v8 = s * v5;
    const waypoints_real v9 = 1.0 + v8;
    const waypoints_real v10 = s * s;
    const waypoints_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void waypoints_basis_rate(waypoints_real s, waypoints_real *dw0, waypoints_real *dw1,
                                        waypoints_real *dw2, waypoints_real *dw3)
{
    const waypoints_real v0 = 1.0 - s;
    const waypoints_real v1 = v0 + v0;
    const waypoints_real v2 = v0 * v1;
    const waypoints_real v3 = v0 * v0;
    const waypoints_real v4 = v2 + v3;
    const waypoints_real v5 = -v4;
    const waypoints_real v6 = v0 - s;
    const waypoints_real v7 = 3.0 * v6;
    const waypoints_real v8 = v0 * v7;
    const waypoints_real v9 = v0 * s;
    const waypoints_real v10 = 1.0 + v9;
    const waypoints_real v11 = 3.0 * v10;
    const waypoints_real v12 = v8 - v11;
    const waypoints_real v13 = s * v7;
    const waypoints_real v14 = v11 + v13;
    const waypoints_real v15 = s + s;
    const waypoints_real v16 = s * v15;
    const waypoints_real v17 = s * s;
    const waypoints_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j. */
static inline waypoints_real waypoints_blend(waypoints_real w0, waypoints_real w1, waypoints_real w2,
                                             waypoints_real w3, waypoints_real q0, waypoints_real q1,
                                             waypoints_real q2, waypoints_real q3)
{
    const waypoints_real v0 = w0 * q0;
    const waypoints_real v1 = w1 * q1;
    const waypoints_real v2 = v0 + v1;
    const waypoints_real v3 = w2 * q2;
    const waypoints_real v4 = w3 * q3;
    const waypoints_real v5 = v3 + v4;
    const waypoints_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline waypoints_real waypoints_normalized_error(waypoints_real a, waypoints_real b,
                                                        waypoints_real width)
{
    const waypoints_real v0 = a - b;
    const waypoints_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void waypoints_transformed_error(waypoints_real a, waypoints_real b, waypoints_real *epsilon,
                                               waypoints_real *xi)
{
    const waypoints_real v0 = b / a;
    const waypoints_real v1 = log(v0);
    const waypoints_real v2 = -v1;
    const waypoints_real v3 = 1.0 + v0;
    const waypoints_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline waypoints_real waypoints_law(waypoints_real k, waypoints_real xi, waypoints_real epsilon)
{
    const waypoints_real v0 = k * xi;
    const waypoints_real v1 = v0 * epsilon;
    const waypoints_real v2 = -v1;
    return v2;
}

void waypoints_tube(waypoints_real t, waypoints_real lower[WAYPOINTS_N], waypoints_real upper[WAYPOINTS_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (waypoints_real)NAN;
            upper[j] = (waypoints_real)NAN;
        }
        return;
    }
    int32_t row;
    waypoints_real s;
    waypoints_segment(t, &row, &s);
    waypoints_real w0;
    waypoints_real w1;
    waypoints_real w2;
    waypoints_real w3;
    waypoints_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const waypoints_real lower_q0 = waypoints_coefficients[at];
        const int32_t lower_1 = at + 4;
        const waypoints_real lower_q1 = waypoints_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const waypoints_real lower_q2 = waypoints_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const waypoints_real lower_q3 = waypoints_coefficients[lower_3];
        const waypoints_real lower_edge = waypoints_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        lower[i] = lower_edge;
        const int32_t upper_0 = at + 1;
        const waypoints_real upper_q0 = waypoints_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const waypoints_real upper_q1 = waypoints_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const waypoints_real upper_q2 = waypoints_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const waypoints_real upper_q3 = waypoints_coefficients[upper_3];
        const waypoints_real upper_edge = waypoints_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        upper[i] = upper_edge;
    }
}

void waypoints_tube_rate(waypoints_real t, waypoints_real lower_rate[WAYPOINTS_N],
                         waypoints_real upper_rate[WAYPOINTS_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (waypoints_real)NAN;
            upper_rate[j] = (waypoints_real)NAN;
        }
        return;
    }
    int32_t row;
    waypoints_real s;
    waypoints_segment(t, &row, &s);
    waypoints_real dw0;
    waypoints_real dw1;
    waypoints_real dw2;
    waypoints_real dw3;
    waypoints_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 18.0;
    const waypoints_real per_second = moving ? 3.5555555555555554 : 0.0;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const waypoints_real lower_q0 = waypoints_coefficients[at];
        const int32_t lower_1 = at + 4;
        const waypoints_real lower_q1 = waypoints_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const waypoints_real lower_q2 = waypoints_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const waypoints_real lower_q3 = waypoints_coefficients[lower_3];
        const waypoints_real lower_slope = waypoints_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const waypoints_real lower_speed = lower_slope * per_second;
        lower_rate[i] = lower_speed;
        const int32_t upper_0 = at + 1;
        const waypoints_real upper_q0 = waypoints_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const waypoints_real upper_q1 = waypoints_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const waypoints_real upper_q2 = waypoints_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const waypoints_real upper_q3 = waypoints_coefficients[upper_3];
        const waypoints_real upper_slope = waypoints_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const waypoints_real upper_speed = upper_slope * per_second;
        upper_rate[i] = upper_speed;
    }
}

waypoints_status waypoints_control(waypoints_real t, const waypoints_real x[WAYPOINTS_N],
                                   waypoints_real u[WAYPOINTS_N])
{
    const waypoints_real t_zero = t * 0.0;
    waypoints_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const waypoints_real x_j = x[j];
        const waypoints_real x_zero = x_j * 0.0;
        const waypoints_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j2 = 0; j2 < 2; ++j2) {
            u[j2] = 0.0;
        }
        return WAYPOINTS_BAD_INPUT;
    }
    int32_t row;
    waypoints_real s;
    waypoints_segment(t, &row, &s);
    waypoints_real w0;
    waypoints_real w1;
    waypoints_real w2;
    waypoints_real w3;
    waypoints_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const waypoints_real lower_q0 = waypoints_coefficients[at];
        const int32_t lower_1 = at + 4;
        const waypoints_real lower_q1 = waypoints_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const waypoints_real lower_q2 = waypoints_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const waypoints_real lower_q3 = waypoints_coefficients[lower_3];
        const waypoints_real lower_edge = waypoints_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const int32_t upper_0 = at + 1;
        const waypoints_real upper_q0 = waypoints_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const waypoints_real upper_q1 = waypoints_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const waypoints_real upper_q2 = waypoints_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const waypoints_real upper_q3 = waypoints_coefficients[upper_3];
        const waypoints_real upper_edge = waypoints_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const waypoints_real x_i = x[i];
        const waypoints_real room = upper_edge - lower_edge;
        const waypoints_real to_lower = x_i - lower_edge;
        const waypoints_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const waypoints_real nearest = upper_nearer ? to_upper : to_lower;
        const waypoints_real gain = upper_nearer ? (-0.5) : 0.5;
        const waypoints_real least = room * 0.005;
        const bool clear = least < nearest;
        const waypoints_real near = clear ? nearest : least;
        const waypoints_real far = room - near;
        const bool within = 0.0 < nearest;
        const bool outside_any = within ? outside : true;
        waypoints_real epsilon;
        waypoints_real xi;
        waypoints_transformed_error(near, far, &epsilon, &xi);
        const waypoints_real push = waypoints_law(gain, xi, epsilon);
        u[i] = push;
        outside = outside_any;
    }
    return outside ? WAYPOINTS_OUTSIDE_TUBE : WAYPOINTS_OK;
}

waypoints_real waypoints_margin(waypoints_real t, const waypoints_real x[WAYPOINTS_N])
{
    const waypoints_real t_zero = t * 0.0;
    waypoints_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const waypoints_real x_j = x[j];
        const waypoints_real x_zero = x_j * 0.0;
        const waypoints_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        return (waypoints_real)NAN;
    }
    int32_t row;
    waypoints_real s;
    waypoints_segment(t, &row, &s);
    waypoints_real w0;
    waypoints_real w1;
    waypoints_real w2;
    waypoints_real w3;
    waypoints_basis(s, &w0, &w1, &w2, &w3);
    waypoints_real margin = 0.5;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const waypoints_real lower_q0 = waypoints_coefficients[at];
        const int32_t lower_1 = at + 4;
        const waypoints_real lower_q1 = waypoints_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const waypoints_real lower_q2 = waypoints_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const waypoints_real lower_q3 = waypoints_coefficients[lower_3];
        const waypoints_real lower_edge = waypoints_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const int32_t upper_0 = at + 1;
        const waypoints_real upper_q0 = waypoints_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const waypoints_real upper_q1 = waypoints_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const waypoints_real upper_q2 = waypoints_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const waypoints_real upper_q3 = waypoints_coefficients[upper_3];
        const waypoints_real upper_edge = waypoints_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const waypoints_real x_i = x[i];
        const waypoints_real room = upper_edge - lower_edge;
        const waypoints_real to_lower = x_i - lower_edge;
        const waypoints_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const waypoints_real nearest = upper_nearer ? to_upper : to_lower;
        const waypoints_real share = nearest / room;
        const bool beyond = share < (-1.0);
        const waypoints_real held_share = beyond ? (-1.0) : share;
        const bool less = held_share < margin;
        const waypoints_real margin_next = less ? held_share : margin;
        margin = margin_next;
    }
    return margin;
}

void waypoints_transform(const waypoints_real lower[WAYPOINTS_N], const waypoints_real upper[WAYPOINTS_N],
                         const waypoints_real x[WAYPOINTS_N], waypoints_real e[WAYPOINTS_N],
                         waypoints_real epsilon[WAYPOINTS_N], waypoints_real xi[WAYPOINTS_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const waypoints_real lower_edge = lower[i];
        const waypoints_real upper_edge = upper[i];
        const waypoints_real x_i = x[i];
        const waypoints_real room = upper_edge - lower_edge;
        const bool filled = 0.0 < room;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < room;
        const waypoints_real width = wide ? room : 9.5367431640625e-7;
        const waypoints_real to_lower = x_i - lower_edge;
        const waypoints_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const waypoints_real nearest = upper_nearer ? to_upper : to_lower;
        const waypoints_real gain = upper_nearer ? (-1.0) : 1.0;
        const waypoints_real least = width * 0.005;
        const waypoints_real widened = width - room;
        const waypoints_real spare = widened * 0.5;
        const waypoints_real distance = nearest + spare;
        const bool farther = least < distance;
        const bool clear = filled && farther;
        const waypoints_real near = clear ? distance : least;
        const waypoints_real far = width - near;
        const waypoints_real a = upper_nearer ? far : near;
        const waypoints_real b = upper_nearer ? near : far;
        const waypoints_real e_raw = waypoints_normalized_error(a, b, width);
        const bool e_held_above = (-0.99) < e_raw;
        const waypoints_real e_held_raised = e_held_above ? e_raw : (-0.99);
        const bool e_held_over = 0.99 < e_held_raised;
        const waypoints_real e_held = e_held_over ? 0.99 : e_held_raised;
        waypoints_real epsilon_near;
        waypoints_real xi_i;
        waypoints_transformed_error(near, far, &epsilon_near, &xi_i);
        const waypoints_real epsilon_i = gain * epsilon_near;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_room = isfinite(room) != 0;
        const bool finite = finite_x && finite_room;
        const waypoints_real e_settled = empty ? 0.0 : e_held;
        const waypoints_real e_out = finite ? e_settled : (waypoints_real)NAN;
        e[i] = e_out;
        const waypoints_real epsilon_settled = empty ? 0.0 : epsilon_i;
        const waypoints_real epsilon_out = finite ? epsilon_settled : (waypoints_real)NAN;
        epsilon[i] = epsilon_out;
        const waypoints_real xi_settled = empty ? 0.0 : xi_i;
        const waypoints_real xi_out = finite ? xi_settled : (waypoints_real)NAN;
        xi[i] = xi_out;
    }
}
