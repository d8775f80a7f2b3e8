/* courier.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (courier.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * Every x(t) that stays in the tube satisfies the mission (P10): (eventually[4, 9] (always[0, 2] dock and
 * eventually[2, 12] (left or right)) and (not lab until[0, 24] dock) and always[0, 12] (not dock or eventually[0, 8]
 * charger)); times are seconds of t. It still holds where every time at which the tube is in a region, or off one, is
 * wrong by up to 0.000366 s.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "courier.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "courier.c: compile without -ffast-math; it tests its inputs for NaN and infinity"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)
#error "courier.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif

/* B-spline control points divided by 6, one row for each of 64 + 3 points:
 * lower[0], upper[0], lower[1], upper[1]
 * Multiples of 2^-20: exact in float and double.
 */
static const courier_real courier_coefficients[268] = {
    0.008760452F, 0.14207363F, -0.020165443F, 0.113147736F,
    0.016676903F, 0.14999008F, 0.016676903F, 0.14999008F,
    0.024593353F, 0.15790558F, 0.053518295F, 0.18683147F,
    0.03250885F, 0.16582203F, 0.09036064F, 0.22367382F,
    0.0404253F, 0.17373848F, 0.12720203F, 0.2605152F,
    0.04834175F, 0.18165398F, 0.16404438F, 0.29735756F,
    0.056257248F, 0.18957043F, 0.20088577F, 0.33419895F,
    0.0641737F, 0.19748688F, 0.23772812F, 0.3710413F,
    0.07209015F, 0.20540237F, 0.2745695F, 0.4078827F,
    0.080005646F, 0.21331882F, 0.31141186F, 0.44472408F,
    0.087922096F, 0.22123528F, 0.34825325F, 0.48156643F,
    0.09583855F, 0.22915077F, 0.3850956F, 0.5184078F,
    0.10375404F, 0.23706722F, 0.421937F, 0.55525017F,
    0.111670494F, 0.24498367F, 0.45877934F, 0.59209156F,
    0.119586945F, 0.25289917F, 0.49562073F, 0.6289339F,
    0.12750244F, 0.26081562F, 0.5324621F, 0.6657753F,
    0.13541889F, 0.26873207F, 0.56930447F, 0.70261765F,
    0.14333439F, 0.27664757F, 0.60614586F, 0.73945904F,
    0.15125084F, 0.28456402F, 0.6429882F, 0.7763014F,
    0.15916729F, 0.29248047F, 0.6798296F, 0.8131428F,
    0.16708279F, 0.30039597F, 0.71667194F, 0.8499851F,
    0.17499924F, 0.30831242F, 0.71667194F, 0.8499851F,
    0.18291569F, 0.31622887F, 0.71667194F, 0.8499851F,
    0.1865654F, 0.31987858F, 0.71667194F, 0.8499851F,
    0.19021606F, 0.3235283F, 0.71667194F, 0.8499851F,
    0.16739082F, 0.300704F, 0.71667194F, 0.8499851F,
    0.20383549F, 0.33714867F, 0.71667194F, 0.8499851F,
    0.16738796F, 0.30070114F, 0.71667194F, 0.8499851F,
    0.17660904F, 0.30992222F, 0.71667194F, 0.8499851F,
    0.25061893F, 0.3839321F, 0.72875786F, 0.86207104F,
    0.32462883F, 0.45794106F, 0.7408438F, 0.874156F,
    0.39863777F, 0.53195095F, 0.7529297F, 0.8862419F,
    0.47264767F, 0.60596085F, 0.7650156F, 0.8983278F,
    0.54665756F, 0.6799698F, 0.7690973F, 0.90240955F,
    0.6206665F, 0.7539797F, 0.7731781F, 0.9064913F,
    0.6946764F, 0.8279896F, 0.7772598F, 0.910573F,
    0.7686863F, 0.9019995F, 0.7353525F, 0.8686657F,
    0.84269524F, 0.9760084F, 0.6934452F, 0.8267584F,
    0.83827114F, 0.9715843F, 0.6515379F, 0.7848511F,
    0.83384705F, 0.9671602F, 0.6096306F, 0.74294376F,
    0.82942295F, 0.9627361F, 0.5677233F, 0.7010355F,
    0.82499886F, 0.95831203F, 0.525815F, 0.6591282F,
    0.82057476F, 0.95388794F, 0.4839077F, 0.6172209F,
    0.81615067F, 0.94946384F, 0.4420004F, 0.57531357F,
    0.81172657F, 0.94503975F, 0.40009308F, 0.53340626F,
    0.8073025F, 0.94061565F, 0.35818577F, 0.49149895F,
    0.8028784F, 0.9361906F, 0.31627846F, 0.44959068F,
    0.7984543F, 0.9317665F, 0.27437115F, 0.40768337F,
    0.79402924F, 0.9273424F, 0.23246288F, 0.36577606F,
    0.78960514F, 0.9229183F, 0.19055557F, 0.32386875F,
    0.78518105F, 0.9184942F, 0.14864826F, 0.28196144F,
    0.78075695F, 0.9140701F, 0.10674095F, 0.24005413F,
    0.77633286F, 0.90964603F, 0.06483364F, 0.19814682F,
    0.8019171F, 0.9352293F, 0.121931076F, 0.25524426F,
    0.82750034F, 0.9608135F, 0.17902851F, 0.3123417F,
    0.85308456F, 0.98639774F, 0.23612595F, 0.36943913F,
    0.87866783F, 1.011981F, 0.29322433F, 0.42653656F,
    0.90425205F, 1.0375652F, 0.35032177F, 0.48363495F,
    0.9298353F, 1.0631485F, 0.4074192F, 0.5407324F,
    0.95541954F, 1.0887327F, 0.46451664F, 0.5978298F,
    0.9810028F, 1.114316F, 0.5216141F, 0.65492725F,
    1.006587F, 1.1399002F, 0.57871246F, 0.7120247F,
    1.0321712F, 1.1654835F, 0.6358099F, 0.7691231F,
    1.0577545F, 1.1910677F, 0.69290733F, 0.8262205F,
    1.0833387F, 1.216651F, 0.75000477F, 0.88331795F,
    1.0833387F, 1.216651F, 0.75000477F, 0.88331795F,
    1.0833387F, 1.216651F, 0.75000477F, 0.88331795F
};

/* Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 64 (t_c = 24 s).
 */
static inline void courier_segment(courier_real t, int32_t *row, courier_real *s)
{
    const bool positive = 0.0F < t;
    const courier_real started = positive ? t : 0.0F;
    const courier_real scaled = started * 2.6666667F;
    const bool early = scaled < 63.999996F;
    const courier_real u = early ? scaled : 63.999996F;
    const int32_t segment = (int32_t)u;
    const courier_real base = (courier_real)segment;
    const courier_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void courier_basis(courier_real s, courier_real *w0, courier_real *w1, courier_real *w2,
                                 courier_real *w3)
{
    const courier_real v0 = 1.0F - s;
    const courier_real v1 = v0 * v0;
    const courier_real v2 = v1 * v0;
    const courier_real v3 = v0 * s;
    const courier_real v4 = 1.0F + v3;
    const courier_real v5 = 3.0F * v4;
    const courier_real v6 = v0 * v5;
    const courier_real v7 = 1.0F + v6;
    const courier_real v8 = s * v5;
    const courier_real v9 = 1.0F + v8;
    const courier_real v10 = s * s;
    const courier_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void courier_basis_rate(courier_real s, courier_real *dw0, courier_real *dw1, courier_real *dw2,
                                      courier_real *dw3)
{
    const courier_real v0 = 1.0F - s;
    const courier_real v1 = v0 + v0;
    const courier_real v2 = v0 * v1;
    const courier_real v3 = v0 * v0;
    const courier_real v4 = v2 + v3;
    const courier_real v5 = -v4;
    const courier_real v6 = v0 - s;
    const courier_real v7 = 3.0F * v6;
    const courier_real v8 = v0 * v7;
    const courier_real v9 = v0 * s;
    const courier_real v10 = 1.0F + v9;
    const courier_real v11 = 3.0F * v10;
    const courier_real v12 = v8 - v11;
    const courier_real v13 = s * v7;
    const courier_real v14 = v11 + v13;
    const courier_real v15 = s + s;
    const courier_real v16 = s * v15;
    const courier_real v17 = s * s;
    const courier_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j. */
static inline courier_real courier_blend(courier_real w0, courier_real w1, courier_real w2, courier_real w3,
                                         courier_real q0, courier_real q1, courier_real q2, courier_real q3)
{
    const courier_real v0 = w0 * q0;
    const courier_real v1 = w1 * q1;
    const courier_real v2 = v0 + v1;
    const courier_real v3 = w2 * q2;
    const courier_real v4 = w3 * q3;
    const courier_real v5 = v3 + v4;
    const courier_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline courier_real courier_normalized_error(courier_real a, courier_real b, courier_real width)
{
    const courier_real v0 = a - b;
    const courier_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void courier_transformed_error(courier_real a, courier_real b, courier_real *epsilon,
                                             courier_real *xi)
{
    const courier_real v0 = b / a;
    const courier_real v1 = logf(v0);
    const courier_real v2 = -v1;
    const courier_real v3 = 1.0F + v0;
    const courier_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline courier_real courier_law(courier_real k, courier_real xi, courier_real epsilon)
{
    const courier_real v0 = k * xi;
    const courier_real v1 = v0 * epsilon;
    const courier_real v2 = -v1;
    return v2;
}

void courier_tube(courier_real t, courier_real lower[COURIER_N], courier_real upper[COURIER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (courier_real)NAN;
            upper[j] = (courier_real)NAN;
        }
        return;
    }
    int32_t row;
    courier_real s;
    courier_segment(t, &row, &s);
    courier_real w0;
    courier_real w1;
    courier_real w2;
    courier_real w3;
    courier_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const courier_real lower_q0 = courier_coefficients[at];
        const int32_t lower_1 = at + 4;
        const courier_real lower_q1 = courier_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const courier_real lower_q2 = courier_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const courier_real lower_q3 = courier_coefficients[lower_3];
        const courier_real lower_edge = courier_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        lower[i] = lower_edge;
        const int32_t upper_0 = at + 1;
        const courier_real upper_q0 = courier_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const courier_real upper_q1 = courier_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const courier_real upper_q2 = courier_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const courier_real upper_q3 = courier_coefficients[upper_3];
        const courier_real upper_edge = courier_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        upper[i] = upper_edge;
    }
}

void courier_tube_rate(courier_real t, courier_real lower_rate[COURIER_N], courier_real upper_rate[COURIER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (courier_real)NAN;
            upper_rate[j] = (courier_real)NAN;
        }
        return;
    }
    int32_t row;
    courier_real s;
    courier_segment(t, &row, &s);
    courier_real dw0;
    courier_real dw1;
    courier_real dw2;
    courier_real dw3;
    courier_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 24.0F;
    const courier_real per_second = moving ? 2.6666667F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const courier_real lower_q0 = courier_coefficients[at];
        const int32_t lower_1 = at + 4;
        const courier_real lower_q1 = courier_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const courier_real lower_q2 = courier_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const courier_real lower_q3 = courier_coefficients[lower_3];
        const courier_real lower_slope = courier_blend(dw0, dw1, dw2, dw3, lower_q0, lower_q1, lower_q2, lower_q3);
        const courier_real lower_speed = lower_slope * per_second;
        lower_rate[i] = lower_speed;
        const int32_t upper_0 = at + 1;
        const courier_real upper_q0 = courier_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const courier_real upper_q1 = courier_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const courier_real upper_q2 = courier_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const courier_real upper_q3 = courier_coefficients[upper_3];
        const courier_real upper_slope = courier_blend(dw0, dw1, dw2, dw3, upper_q0, upper_q1, upper_q2, upper_q3);
        const courier_real upper_speed = upper_slope * per_second;
        upper_rate[i] = upper_speed;
    }
}

courier_status courier_control(courier_real t, const courier_real x[COURIER_N], courier_real u[COURIER_N])
{
    const courier_real t_zero = t * 0.0F;
    courier_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const courier_real x_j = x[j];
        const courier_real x_zero = x_j * 0.0F;
        const courier_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j2 = 0; j2 < 2; ++j2) {
            u[j2] = 0.0F;
        }
        return COURIER_BAD_INPUT;
    }
    int32_t row;
    courier_real s;
    courier_segment(t, &row, &s);
    courier_real w0;
    courier_real w1;
    courier_real w2;
    courier_real w3;
    courier_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const courier_real lower_q0 = courier_coefficients[at];
        const int32_t lower_1 = at + 4;
        const courier_real lower_q1 = courier_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const courier_real lower_q2 = courier_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const courier_real lower_q3 = courier_coefficients[lower_3];
        const courier_real lower_edge = courier_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const int32_t upper_0 = at + 1;
        const courier_real upper_q0 = courier_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const courier_real upper_q1 = courier_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const courier_real upper_q2 = courier_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const courier_real upper_q3 = courier_coefficients[upper_3];
        const courier_real upper_edge = courier_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const courier_real x_i = x[i];
        const courier_real room = upper_edge - lower_edge;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const courier_real nearest = upper_nearer ? to_upper : to_lower;
        const courier_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const courier_real least = room * 0.005F;
        const bool clear = least < nearest;
        const courier_real near = clear ? nearest : least;
        const courier_real far = room - near;
        const bool within = 0.0F < nearest;
        const bool outside_any = within ? outside : true;
        courier_real epsilon;
        courier_real xi;
        courier_transformed_error(near, far, &epsilon, &xi);
        const courier_real push = courier_law(gain, xi, epsilon);
        u[i] = push;
        outside = outside_any;
    }
    return outside ? COURIER_OUTSIDE_TUBE : COURIER_OK;
}

courier_real courier_margin(courier_real t, const courier_real x[COURIER_N])
{
    const courier_real t_zero = t * 0.0F;
    courier_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const courier_real x_j = x[j];
        const courier_real x_zero = x_j * 0.0F;
        const courier_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (courier_real)NAN;
    }
    int32_t row;
    courier_real s;
    courier_segment(t, &row, &s);
    courier_real w0;
    courier_real w1;
    courier_real w2;
    courier_real w3;
    courier_basis(s, &w0, &w1, &w2, &w3);
    courier_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t at = row + pair;
        const courier_real lower_q0 = courier_coefficients[at];
        const int32_t lower_1 = at + 4;
        const courier_real lower_q1 = courier_coefficients[lower_1];
        const int32_t lower_2 = at + 8;
        const courier_real lower_q2 = courier_coefficients[lower_2];
        const int32_t lower_3 = at + 12;
        const courier_real lower_q3 = courier_coefficients[lower_3];
        const courier_real lower_edge = courier_blend(w0, w1, w2, w3, lower_q0, lower_q1, lower_q2, lower_q3);
        const int32_t upper_0 = at + 1;
        const courier_real upper_q0 = courier_coefficients[upper_0];
        const int32_t upper_1 = at + 5;
        const courier_real upper_q1 = courier_coefficients[upper_1];
        const int32_t upper_2 = at + 9;
        const courier_real upper_q2 = courier_coefficients[upper_2];
        const int32_t upper_3 = at + 13;
        const courier_real upper_q3 = courier_coefficients[upper_3];
        const courier_real upper_edge = courier_blend(w0, w1, w2, w3, upper_q0, upper_q1, upper_q2, upper_q3);
        const courier_real x_i = x[i];
        const courier_real room = upper_edge - lower_edge;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const courier_real nearest = upper_nearer ? to_upper : to_lower;
        const courier_real share = nearest / room;
        const bool beyond = share < (-1.0F);
        const courier_real held_share = beyond ? (-1.0F) : share;
        const bool less = held_share < margin;
        const courier_real margin_next = less ? held_share : margin;
        margin = margin_next;
    }
    return margin;
}

void courier_transform(const courier_real lower[COURIER_N], const courier_real upper[COURIER_N],
                       const courier_real x[COURIER_N], courier_real e[COURIER_N],
                       courier_real epsilon[COURIER_N], courier_real xi[COURIER_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const courier_real lower_edge = lower[i];
        const courier_real upper_edge = upper[i];
        const courier_real x_i = x[i];
        const courier_real room = upper_edge - lower_edge;
        const bool filled = 0.0F < room;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < room;
        const courier_real width = wide ? room : 9.536743e-7F;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const courier_real nearest = upper_nearer ? to_upper : to_lower;
        const courier_real gain = upper_nearer ? (-1.0F) : 1.0F;
        const courier_real least = width * 0.005F;
        const courier_real widened = width - room;
        const courier_real spare = widened * 0.5F;
        const courier_real distance = nearest + spare;
        const bool farther = least < distance;
        const bool clear = filled && farther;
        const courier_real near = clear ? distance : least;
        const courier_real far = width - near;
        const courier_real a = upper_nearer ? far : near;
        const courier_real b = upper_nearer ? near : far;
        const courier_real e_raw = courier_normalized_error(a, b, width);
        const bool e_held_above = (-0.99F) < e_raw;
        const courier_real e_held_raised = e_held_above ? e_raw : (-0.99F);
        const bool e_held_over = 0.99F < e_held_raised;
        const courier_real e_held = e_held_over ? 0.99F : e_held_raised;
        courier_real epsilon_near;
        courier_real xi_i;
        courier_transformed_error(near, far, &epsilon_near, &xi_i);
        const courier_real epsilon_i = gain * epsilon_near;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_room = isfinite(room) != 0;
        const bool finite = finite_x && finite_room;
        const courier_real e_settled = empty ? 0.0F : e_held;
        const courier_real e_out = finite ? e_settled : (courier_real)NAN;
        e[i] = e_out;
        const courier_real epsilon_settled = empty ? 0.0F : epsilon_i;
        const courier_real epsilon_out = finite ? epsilon_settled : (courier_real)NAN;
        epsilon[i] = epsilon_out;
        const courier_real xi_settled = empty ? 0.0F : xi_i;
        const courier_real xi_out = finite ? xi_settled : (courier_real)NAN;
        xi[i] = xi_out;
    }
}
