/* courier.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1)
#error "courier.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif

/* B-spline control points divided by 6, one row for each of 64 + 3 points:
 * lower[0], upper[0], lower[1], upper[1]
 * Multiples of 2^-20: exact in float and double.
 */
static const courier_real courier_coefficients[268] = {
    0.008760452270507812, 0.1420736312866211, -0.020165443420410156, 0.11314773559570312,
    0.016676902770996094, 0.14999008178710938, 0.016676902770996094, 0.14999008178710938,
    0.024593353271484375, 0.15790557861328125, 0.05351829528808594, 0.18683147430419922,
    0.03250885009765625, 0.16582202911376953, 0.09036064147949219, 0.22367382049560547,
    0.04042530059814453, 0.1737384796142578, 0.12720203399658203, 0.2605152130126953,
    0.04834175109863281, 0.1816539764404297, 0.16404438018798828, 0.29735755920410156,
    0.05625724792480469, 0.18957042694091797, 0.20088577270507812, 0.3341989517211914,
    0.06417369842529297, 0.19748687744140625, 0.23772811889648438, 0.37104129791259766,
    0.07209014892578125, 0.20540237426757812, 0.2745695114135742, 0.4078826904296875,
    0.08000564575195312, 0.2133188247680664, 0.31141185760498047, 0.44472408294677734,
    0.0879220962524414, 0.2212352752685547, 0.3482532501220703, 0.4815664291381836,
    0.09583854675292969, 0.22915077209472656, 0.38509559631347656, 0.5184078216552734,
    0.10375404357910156, 0.23706722259521484, 0.4219369888305664, 0.5552501678466797,
    0.11167049407958984, 0.24498367309570312, 0.45877933502197266, 0.5920915603637695,
    0.11958694458007812, 0.252899169921875, 0.4956207275390625, 0.6289339065551758,
    0.12750244140625, 0.2608156204223633, 0.5324621200561523, 0.6657752990722656,
    0.13541889190673828, 0.26873207092285156, 0.5693044662475586, 0.7026176452636719,
    0.14333438873291016, 0.27664756774902344, 0.6061458587646484, 0.7394590377807617,
    0.15125083923339844, 0.2845640182495117, 0.6429882049560547, 0.776301383972168,
    0.15916728973388672, 0.29248046875, 0.6798295974731445, 0.8131427764892578,
    0.1670827865600586, 0.3003959655761719, 0.7166719436645508, 0.8499851226806641,
    0.17499923706054688, 0.30831241607666016, 0.7166719436645508, 0.8499851226806641,
    0.18291568756103516, 0.31622886657714844, 0.7166719436645508, 0.8499851226806641,
    0.18656539916992188, 0.31987857818603516, 0.7166719436645508, 0.8499851226806641,
    0.190216064453125, 0.3235282897949219, 0.7166719436645508, 0.8499851226806641,
    0.1673908233642578, 0.3007040023803711, 0.7166719436645508, 0.8499851226806641,
    0.20383548736572266, 0.33714866638183594, 0.7166719436645508, 0.8499851226806641,
    0.1673879623413086, 0.3007011413574219, 0.7166719436645508, 0.8499851226806641,
    0.17660903930664062, 0.3099222183227539, 0.7166719436645508, 0.8499851226806641,
    0.25061893463134766, 0.38393211364746094, 0.7287578582763672, 0.8620710372924805,
    0.3246288299560547, 0.45794105529785156, 0.7408437728881836, 0.8741559982299805,
    0.3986377716064453, 0.5319509506225586, 0.7529296875, 0.8862419128417969,
    0.47264766693115234, 0.6059608459472656, 0.7650156021118164, 0.8983278274536133,
    0.5466575622558594, 0.6799697875976562, 0.7690973281860352, 0.902409553527832,
    0.62066650390625, 0.7539796829223633, 0.7731781005859375, 0.9064912796020508,
    0.694676399230957, 0.8279895782470703, 0.7772598266601562, 0.9105730056762695,
    0.7686862945556641, 0.9019994735717773, 0.7353525161743164, 0.8686656951904297,
    0.8426952362060547, 0.976008415222168, 0.6934452056884766, 0.8267583847045898,
    0.8382711410522461, 0.9715843200683594, 0.6515378952026367, 0.78485107421875,
    0.8338470458984375, 0.9671602249145508, 0.6096305847167969, 0.7429437637329102,
    0.8294229507446289, 0.9627361297607422, 0.567723274230957, 0.7010354995727539,
    0.8249988555908203, 0.9583120346069336, 0.5258150100708008, 0.6591281890869141,
    0.8205747604370117, 0.953887939453125, 0.48390769958496094, 0.6172208786010742,
    0.8161506652832031, 0.9494638442993164, 0.4420003890991211, 0.5753135681152344,
    0.8117265701293945, 0.9450397491455078, 0.40009307861328125, 0.5334062576293945,
    0.8073024749755859, 0.9406156539916992, 0.3581857681274414, 0.4914989471435547,
    0.8028783798217773, 0.9361906051635742, 0.31627845764160156, 0.44959068298339844,
    0.7984542846679688, 0.9317665100097656, 0.2743711471557617, 0.4076833724975586,
    0.7940292358398438, 0.927342414855957, 0.23246288299560547, 0.36577606201171875,
    0.7896051406860352, 0.9229183197021484, 0.19055557250976562, 0.3238687515258789,
    0.7851810455322266, 0.9184942245483398, 0.14864826202392578, 0.28196144104003906,
    0.780756950378418, 0.9140701293945312, 0.10674095153808594, 0.24005413055419922,
    0.7763328552246094, 0.9096460342407227, 0.0648336410522461, 0.19814682006835938,
    0.8019170761108398, 0.9352293014526367, 0.12193107604980469, 0.25524425506591797,
    0.8275003433227539, 0.9608135223388672, 0.17902851104736328, 0.31234169006347656,
    0.8530845642089844, 0.9863977432250977, 0.23612594604492188, 0.36943912506103516,
    0.8786678314208984, 1.0119810104370117, 0.2932243347167969, 0.42653656005859375,
    0.9042520523071289, 1.0375652313232422, 0.35032176971435547, 0.48363494873046875,
    0.929835319519043, 1.0631484985351562, 0.40741920471191406, 0.5407323837280273,
    0.9554195404052734, 1.0887327194213867, 0.46451663970947266, 0.5978298187255859,
    0.9810028076171875, 1.1143159866333008, 0.5216140747070312, 0.6549272537231445,
    1.006587028503418, 1.1399002075195312, 0.5787124633789062, 0.7120246887207031,
    1.0321712493896484, 1.1654834747314453, 0.6358098983764648, 0.7691230773925781,
    1.0577545166015625, 1.1910676956176758, 0.6929073333740234, 0.8262205123901367,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953,
    1.083338737487793, 1.2166509628295898, 0.750004768371582, 0.8833179473876953
};

/* Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 64 (t_c = 24 s).
 */
static inline void courier_segment(courier_real t, int32_t *row, courier_real *s)
{
    const bool positive = 0.0 < t;
    const courier_real started = positive ? t : 0.0;
    const courier_real scaled = started * 2.6666666666666665;
    const bool early = scaled < 63.99999999999999;
    const courier_real u = early ? scaled : 63.99999999999999;
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
    const courier_real v0 = 1.0 - s;
    const courier_real v1 = v0 * v0;
    const courier_real v2 = v1 * v0;
    const courier_real v3 = v0 * s;
    const courier_real v4 = 1.0 + v3;
    const courier_real v5 = 3.0 * v4;
    const courier_real v6 = v0 * v5;
    const courier_real v7 = 1.0 + v6;
    const courier_real v8 = s * v5;
    const courier_real v9 = 1.0 + v8;
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
    const courier_real v0 = 1.0 - s;
    const courier_real v1 = v0 + v0;
    const courier_real v2 = v0 * v1;
    const courier_real v3 = v0 * v0;
    const courier_real v4 = v2 + v3;
    const courier_real v5 = -v4;
    const courier_real v6 = v0 - s;
    const courier_real v7 = 3.0 * v6;
    const courier_real v8 = v0 * v7;
    const courier_real v9 = v0 * s;
    const courier_real v10 = 1.0 + v9;
    const courier_real v11 = 3.0 * v10;
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
    const courier_real v1 = log(v0);
    const courier_real v2 = -v1;
    const courier_real v3 = 1.0 + v0;
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
    const bool moving = t < 24.0;
    const courier_real per_second = moving ? 2.6666666666666665 : 0.0;
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
    const courier_real t_zero = t * 0.0;
    courier_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const courier_real x_j = x[j];
        const courier_real x_zero = x_j * 0.0;
        const courier_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j2 = 0; j2 < 2; ++j2) {
            u[j2] = 0.0;
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
        const courier_real gain = upper_nearer ? (-0.5) : 0.5;
        const courier_real least = room * 0.005;
        const bool clear = least < nearest;
        const courier_real near = clear ? nearest : least;
        const courier_real far = room - near;
        const bool within = 0.0 < nearest;
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
    const courier_real t_zero = t * 0.0;
    courier_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const courier_real x_j = x[j];
        const courier_real x_zero = x_j * 0.0;
        const courier_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0;
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
    courier_real margin = 0.5;
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
        const bool beyond = share < (-1.0);
        const courier_real held_share = beyond ? (-1.0) : share;
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
        const bool filled = 0.0 < room;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < room;
        const courier_real width = wide ? room : 9.5367431640625e-7;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const courier_real nearest = upper_nearer ? to_upper : to_lower;
        const courier_real gain = upper_nearer ? (-1.0) : 1.0;
        const courier_real least = width * 0.005;
        const courier_real widened = width - room;
        const courier_real spare = widened * 0.5;
        const courier_real distance = nearest + spare;
        const bool farther = least < distance;
        const bool clear = filled && farther;
        const courier_real near = clear ? distance : least;
        const courier_real far = width - near;
        const courier_real a = upper_nearer ? far : near;
        const courier_real b = upper_nearer ? near : far;
        const courier_real e_raw = courier_normalized_error(a, b, width);
        const bool e_held_above = (-0.99) < e_raw;
        const courier_real e_held_raised = e_held_above ? e_raw : (-0.99);
        const bool e_held_over = 0.99 < e_held_raised;
        const courier_real e_held = e_held_over ? 0.99 : e_held_raised;
        courier_real epsilon_near;
        courier_real xi_i;
        courier_transformed_error(near, far, &epsilon_near, &xi_i);
        const courier_real epsilon_i = gain * epsilon_near;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_room = isfinite(room) != 0;
        const bool finite = finite_x && finite_room;
        const courier_real e_settled = empty ? 0.0 : e_held;
        const courier_real e_out = finite ? e_settled : (courier_real)NAN;
        e[i] = e_out;
        const courier_real epsilon_settled = empty ? 0.0 : epsilon_i;
        const courier_real epsilon_out = finite ? epsilon_settled : (courier_real)NAN;
        epsilon[i] = epsilon_out;
        const courier_real xi_settled = empty ? 0.0 : xi_i;
        const courier_real xi_out = finite ? xi_settled : (courier_real)NAN;
        xi[i] = xi_out;
    }
}
