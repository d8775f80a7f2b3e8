/* drone.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (drone.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.025 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= 0.35, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 0.005, u acts at most 0.004 s after its sample, v
 * measured to 0.02: |e| of v + lambda x < [0.9343, 0.9343, 0.9374], |u| <= 2.5.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "drone.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "drone.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "drone.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)
#error "drone.c: compile for double arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)
#error "drone.c: double is not IEEE-754's here, for which rounding is bounded"
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
 * Multiples of 2^-20: exact in float and double.
 */
static const drone_real drone_coefficients[210] = {
    0.050009727478027344, 0.14999008178710938, 0.05177879333496094, 0.15175914764404297,
    0.11683368682861328, 0.2168130874633789,
    0.050009727478027344, 0.14999008178710938, 0.04912567138671875, 0.14910507202148438,
    0.11659812927246094, 0.21657848358154297,
    0.050009727478027344, 0.14999008178710938, 0.05177879333496094, 0.15175914764404297,
    0.11683368682861328, 0.2168130874633789,
    0.05123329162597656, 0.1512136459350586, 0.059739112854003906, 0.15971851348876953,
    0.1175394058227539, 0.21751976013183594,
    0.05776405334472656, 0.1577434539794922, 0.07300472259521484, 0.17298507690429688,
    0.11871623992919922, 0.21869659423828125,
    0.06960010528564453, 0.16958045959472656, 0.09157848358154297, 0.1915578842163086,
    0.12036418914794922, 0.22034358978271484,
    0.08674335479736328, 0.1867237091064453, 0.11545753479003906, 0.2154369354248047,
    0.1224822998046875, 0.22246265411376953,
    0.10453510284423828, 0.2045145034790039, 0.14464378356933594, 0.24462318420410156,
    0.12507152557373047, 0.2250509262084961,
    0.12763214111328125, 0.22761249542236328, 0.1791362762451172, 0.2791156768798828,
    0.12813186645507812, 0.22811126708984375,
    0.156036376953125, 0.25601673126220703, 0.2189350128173828, 0.31891441345214844,
    0.13166236877441406, 0.2316417694091797,
    0.18974781036376953, 0.28972721099853516, 0.2640399932861328, 0.36402034759521484,
    0.13566303253173828, 0.2356433868408203,
    0.22876453399658203, 0.32874393463134766, 0.3144521713256836, 0.4144325256347656,
    0.1401357650756836, 0.24011516571044922,
    0.26778221130371094, 0.36776161193847656, 0.37017154693603516, 0.4701509475708008,
    0.14507770538330078, 0.2450580596923828,
    0.30679893493652344, 0.40677928924560547, 0.42747974395751953, 0.5274591445922852,
    0.15049171447753906, 0.2504711151123047,
    0.3511228561401367, 0.45110225677490234, 0.47948169708251953, 0.5794610977172852,
    0.15637588500976562, 0.25635528564453125,
    0.4007530212402344, 0.5007333755493164, 0.5261764526367188, 0.6261558532714844,
    0.16273117065429688, 0.2627105712890625,
    0.4556903839111328, 0.5556697845458984, 0.5675649642944336, 0.6675453186035156,
    0.1695566177368164, 0.26953601837158203,
    0.5159339904785156, 0.6159133911132812, 0.6036472320556641, 0.7036266326904297,
    0.176849365234375, 0.27682971954345703,
    0.5814838409423828, 0.6814632415771484, 0.6344232559204102, 0.7344026565551758,
    0.18391036987304688, 0.2838907241821289,
    0.650456428527832, 0.7504358291625977, 0.6598920822143555, 0.7598714828491211,
    0.19050121307373047, 0.2904806137084961,
    0.7194290161132812, 0.8194084167480469, 0.6800546646118164, 0.780034065246582,
    0.19662094116210938, 0.296600341796875,
    0.783106803894043, 0.883087158203125, 0.694911003112793, 0.7948904037475586,
    0.2022695541381836, 0.3022489547729492,
    0.8414793014526367, 0.9414587020874023, 0.7044601440429688, 0.8044395446777344,
    0.20744800567626953, 0.30742740631103516,
    0.8945446014404297, 0.9945240020751953, 0.7087030410766602, 0.8086824417114258,
    0.21215534210205078, 0.3121347427368164,
    0.9423027038574219, 1.042283058166504, 0.7076396942138672, 0.8076190948486328,
    0.21639156341552734, 0.3163719177246094,
    0.9847555160522461, 1.0847349166870117, 0.702519416809082, 0.8024997711181641,
    0.22015762329101562, 0.32013702392578125,
    1.0219011306762695, 1.1218805313110352, 0.6974000930786133, 0.7973794937133789,
    0.22345256805419922, 0.32343292236328125,
    1.0537405014038086, 1.1537199020385742, 0.6922807693481445, 0.7922601699829102,
    0.22627735137939453, 0.32625675201416016,
    1.0802726745605469, 1.180253028869629, 0.6871604919433594, 0.7871408462524414,
    0.22863101959228516, 0.3286104202270508,
    1.1014995574951172, 1.2014789581298828, 0.6820411682128906, 0.7820205688476562,
    0.2305135726928711, 0.3304939270019531,
    1.1174192428588867, 1.2173986434936523, 0.6769208908081055, 0.7769012451171875,
    0.23192596435546875, 0.3319063186645508,
    1.1280317306518555, 1.228011131286621, 0.6718015670776367, 0.7717809677124023,
    0.23286724090576172, 0.33284759521484375,
    1.1333379745483398, 1.2333183288574219, 0.666682243347168, 0.7666616439819336,
    0.2333383560180664, 0.33331775665283203,
    1.1333379745483398, 1.2333183288574219, 0.666682243347168, 0.7666616439819336,
    0.2333383560180664, 0.33331775665283203,
    1.1333379745483398, 1.2333183288574219, 0.666682243347168, 0.7666616439819336,
    0.2333383560180664, 0.33331775665283203
};

/* lambda of v + lambda x, by component. */
static const drone_real drone_filter[3] = {
    0.98046875, 0.98046875, 0.78564453125
};

/* Gain k of the control law, by component. */
static const drone_real drone_gain[3] = {
    0.0525, 0.0525, 0.027
};

/* Saturation of u, by component. */
static const drone_real drone_u_max[3] = {
    2.5, 2.5, 2.5
};

/* Covered starts have x strictly above these bounds, by component. */
static const drone_real drone_start_lower[3] = {
    0.3650465774536151, 0.36504810333252136, 0.765047912597658
};

/* Covered starts have x strictly below these bounds, by component. */
static const drone_real drone_start_upper[3] = {
    0.8349522781372052, 0.834950752258299, 1.2349520874023419
};

/* The same of v + lambda x: strictly above these bounds. */
static const drone_real drone_filtered_start_lower[3] = {
    0.3779167614877298, 0.37791825756431363, 0.6210557086765827
};

/* The same of v + lambda x: strictly below these bounds. */
static const drone_real drone_filtered_start_upper[3] = {
    0.7986446164548323, 0.7986431203782485, 0.9502333538234173
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 12 s).
 */
static inline void drone_segment(drone_real t, int32_t *row, drone_real *s)
{
    const bool positive = 0.0 < t;
    const drone_real started = positive ? t : 0.0;
    const drone_real scaled = started * 2.6666666666666665;
    const bool early = scaled < 31.999999999999996;
    const drone_real u = early ? scaled : 31.999999999999996;
    const int32_t segment = (int32_t)u;
    const drone_real base = (drone_real)segment;
    const drone_real place = u - base;
    const int32_t first = segment * 6;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void drone_basis(drone_real s, drone_real *w0, drone_real *w1, drone_real *w2, drone_real *w3)
{
    const drone_real v0 = 1.0 - s;
    const drone_real v1 = v0 * v0;
    const drone_real v2 = v1 * v0;
    const drone_real v3 = v0 * s;
    const drone_real v4 = 1.0 + v3;
    const drone_real v5 = 3.0 * v4;
    const drone_real v6 = v0 * v5;
    const drone_real v7 = 1.0 + v6;
    const drone_real v8 = s * v5;
    const drone_real v9 = 1.0 + v8;
    const drone_real v10 = s * s;
    const drone_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void drone_basis_rate(drone_real s, drone_real *dw0, drone_real *dw1, drone_real *dw2,
                                    drone_real *dw3)
{
    const drone_real v0 = 1.0 - s;
    const drone_real v1 = v0 + v0;
    const drone_real v2 = v0 * v1;
    const drone_real v3 = v0 * v0;
    const drone_real v4 = v2 + v3;
    const drone_real v5 = -v4;
    const drone_real v6 = v0 - s;
    const drone_real v7 = 3.0 * v6;
    const drone_real v8 = v0 * v7;
    const drone_real v9 = v0 * s;
    const drone_real v10 = 1.0 + v9;
    const drone_real v11 = 3.0 * v10;
    const drone_real v12 = v8 - v11;
    const drone_real v13 = s * v7;
    const drone_real v14 = v11 + v13;
    const drone_real v15 = s + s;
    const drone_real v16 = s * v15;
    const drone_real v17 = s * s;
    const drone_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline drone_real drone_edge_at(int32_t at, drone_real w0, drone_real w1, drone_real w2, drone_real w3)
{
    const drone_real q0 = drone_coefficients[at];
    const int32_t at_1 = at + 6;
    const drone_real q1 = drone_coefficients[at_1];
    const int32_t at_2 = at + 12;
    const drone_real q2 = drone_coefficients[at_2];
    const int32_t at_3 = at + 18;
    const drone_real q3 = drone_coefficients[at_3];
    const drone_real v0 = w0 * q0;
    const drone_real v1 = w1 * q1;
    const drone_real v2 = v0 + v1;
    const drone_real v3 = w2 * q2;
    const drone_real v4 = w3 * q3;
    const drone_real v5 = v3 + v4;
    const drone_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline drone_real drone_normalized_error(drone_real a, drone_real b, drone_real width)
{
    const drone_real v0 = a - b;
    const drone_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void drone_transformed_error(drone_real a, drone_real b, drone_real *epsilon, drone_real *xi)
{
    const drone_real v0 = b / a;
    const drone_real v1 = log(v0);
    const drone_real v2 = -v1;
    const drone_real v3 = 1.0 + v0;
    const drone_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline drone_real drone_law(drone_real k, drone_real xi, drone_real epsilon)
{
    const drone_real v0 = k * xi;
    const drone_real v1 = v0 * epsilon;
    const drone_real v2 = -v1;
    return v2;
}

void drone_tube(drone_real t, drone_real lower[DRONE_N], drone_real upper[DRONE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (drone_real)NAN;
            upper[j] = (drone_real)NAN;
        }
        return;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real w0;
    drone_real w1;
    drone_real w2;
    drone_real w3;
    drone_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_edge = drone_edge_at(lower_at, w0, w1, w2, w3);
        const drone_real upper_edge = drone_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void drone_tube_rate(drone_real t, drone_real lower_rate[DRONE_N], drone_real upper_rate[DRONE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower_rate[j] = (drone_real)NAN;
            upper_rate[j] = (drone_real)NAN;
        }
        return;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real dw0;
    drone_real dw1;
    drone_real dw2;
    drone_real dw3;
    drone_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 12.0;
    const drone_real per_second = moving ? 2.6666666666666665 : 0.0;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_slope = drone_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const drone_real lower_speed = lower_slope * per_second;
        const drone_real upper_slope = drone_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const drone_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

void drone_filtered_tube(drone_real t, drone_real lower[DRONE_N], drone_real upper[DRONE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            lower[j] = (drone_real)NAN;
            upper[j] = (drone_real)NAN;
        }
        return;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real w0;
    drone_real w1;
    drone_real w2;
    drone_real w3;
    drone_basis(s, &w0, &w1, &w2, &w3);
    drone_real dw0;
    drone_real dw1;
    drone_real dw2;
    drone_real dw3;
    drone_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_edge = drone_edge_at(lower_at, w0, w1, w2, w3);
        const drone_real upper_edge = drone_edge_at(upper_at, w0, w1, w2, w3);
        const drone_real lower_slope = drone_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const drone_real lower_rate = lower_slope * 2.6666666666666665;
        const drone_real upper_slope = drone_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const drone_real upper_rate = upper_slope * 2.6666666666666665;
        const drone_real filter_i = drone_filter[i];
        const drone_real lower_part = lower_edge * filter_i;
        const drone_real z_lower = lower_rate + lower_part;
        lower[i] = z_lower;
        const drone_real upper_part = upper_edge * filter_i;
        const drone_real z_upper = upper_rate + upper_part;
        upper[i] = z_upper;
    }
}

drone_status drone_control(drone_real t, const drone_real x[DRONE_N], const drone_real v[DRONE_N],
                           drone_real u[DRONE_N])
{
    const drone_real t_zero = t * 0.0;
    drone_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const drone_real x_j = x[j];
        const drone_real x_zero = x_j * 0.0;
        const drone_real zeros = zero + x_zero;
        zero = zeros;
    }
    drone_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const drone_real v_k = v[k];
        const drone_real v_zero = v_k * 0.0;
        const drone_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 3; ++m) {
            u[m] = 0.0;
        }
        return DRONE_BAD_INPUT;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real w0;
    drone_real w1;
    drone_real w2;
    drone_real w3;
    drone_basis(s, &w0, &w1, &w2, &w3);
    drone_real dw0;
    drone_real dw1;
    drone_real dw2;
    drone_real dw3;
    drone_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    bool outside = false;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_edge = drone_edge_at(lower_at, w0, w1, w2, w3);
        const drone_real upper_edge = drone_edge_at(upper_at, w0, w1, w2, w3);
        const drone_real lower_slope = drone_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const drone_real lower_rate = lower_slope * 2.6666666666666665;
        const drone_real upper_slope = drone_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const drone_real upper_rate = upper_slope * 2.6666666666666665;
        const drone_real x_i = x[i];
        const drone_real v_i = v[i];
        const drone_real width = upper_edge - lower_edge;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const drone_real v_width = upper_rate - lower_rate;
        const drone_real v_to_lower = v_i - lower_rate;
        const drone_real v_to_upper = upper_rate - v_i;
        const drone_real filter_i = drone_filter[i];
        const drone_real gain_i = drone_gain[i];
        const drone_real gain_minus = -gain_i;
        const drone_real width_part = width * filter_i;
        const drone_real z_width = v_width + width_part;
        const drone_real lower_part = to_lower * filter_i;
        const drone_real z_to_lower = v_to_lower + lower_part;
        const drone_real upper_part = to_upper * filter_i;
        const drone_real z_to_upper = v_to_upper + upper_part;
        const bool upper_nearer = z_to_upper < z_to_lower;
        const drone_real distance = upper_nearer ? z_to_upper : z_to_lower;
        const drone_real gain = upper_nearer ? gain_minus : gain_i;
        const drone_real smallest = z_width * 0.005;
        const bool clear = smallest < distance;
        const drone_real to_nearer = clear ? distance : smallest;
        const drone_real to_farther = z_width - to_nearer;
        const bool x_above = 0.0 < to_lower;
        const bool x_below = 0.0 < to_upper;
        const bool x_inside = x_above && x_below;
        const bool z_inside = 0.0 < distance;
        const bool inside = z_inside && x_inside;
        const bool outside_next = inside ? outside : true;
        const drone_real u_limit = drone_u_max[i];
        drone_real epsilon;
        drone_real xi;
        drone_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const drone_real u_i = drone_law(gain, xi, epsilon);
        const drone_real u_min = -u_limit;
        const bool u_above = u_min < u_i;
        const drone_real u_raised = u_above ? u_i : u_min;
        const bool u_beyond = u_limit < u_raised;
        const drone_real u_limited = u_beyond ? u_limit : u_raised;
        u[i] = u_limited;
        outside = outside_next;
    }
    return outside ? DRONE_OUTSIDE_TUBE : DRONE_OK;
}

drone_real drone_margin(drone_real t, const drone_real x[DRONE_N], const drone_real v[DRONE_N])
{
    const drone_real t_zero = t * 0.0;
    drone_real zero = t_zero;
    for (int32_t j = 0; j < 3; ++j) {
        const drone_real x_j = x[j];
        const drone_real x_zero = x_j * 0.0;
        const drone_real zeros = zero + x_zero;
        zero = zeros;
    }
    drone_real v_zeros = zero;
    for (int32_t k = 0; k < 3; ++k) {
        const drone_real v_k = v[k];
        const drone_real v_zero = v_k * 0.0;
        const drone_real v_sum = v_zeros + v_zero;
        v_zeros = v_sum;
    }
    const bool finite = v_zeros <= 0.0;
    const bool bad = !finite;
    if (bad) {
        return (drone_real)NAN;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real w0;
    drone_real w1;
    drone_real w2;
    drone_real w3;
    drone_basis(s, &w0, &w1, &w2, &w3);
    drone_real dw0;
    drone_real dw1;
    drone_real dw2;
    drone_real dw3;
    drone_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    drone_real margin = 0.5;
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_edge = drone_edge_at(lower_at, w0, w1, w2, w3);
        const drone_real upper_edge = drone_edge_at(upper_at, w0, w1, w2, w3);
        const drone_real lower_slope = drone_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const drone_real lower_rate = lower_slope * 2.6666666666666665;
        const drone_real upper_slope = drone_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const drone_real upper_rate = upper_slope * 2.6666666666666665;
        const drone_real x_i = x[i];
        const drone_real v_i = v[i];
        const drone_real width = upper_edge - lower_edge;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const drone_real v_width = upper_rate - lower_rate;
        const drone_real v_to_lower = v_i - lower_rate;
        const drone_real v_to_upper = upper_rate - v_i;
        const drone_real filter_i = drone_filter[i];
        const drone_real width_part = width * filter_i;
        const drone_real z_width = v_width + width_part;
        const drone_real lower_part = to_lower * filter_i;
        const drone_real z_to_lower = v_to_lower + lower_part;
        const drone_real upper_part = to_upper * filter_i;
        const drone_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const drone_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const drone_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0);
        const drone_real margin_z = z_beyond ? (-1.0) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const drone_real x_distance = x_nearer ? to_upper : to_lower;
        const drone_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const drone_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const drone_real smaller = x_smaller ? margin_x : margin_z;
        const bool less = smaller < margin;
        const drone_real margin_next = less ? smaller : margin;
        margin = margin_next;
    }
    return margin;
}

void drone_margins(drone_real t, const drone_real x[DRONE_N], const drone_real v[DRONE_N],
                   drone_real margin[DRONE_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 3; ++j) {
            margin[j] = (drone_real)NAN;
        }
        return;
    }
    int32_t row;
    drone_real s;
    drone_segment(t, &row, &s);
    drone_real w0;
    drone_real w1;
    drone_real w2;
    drone_real w3;
    drone_basis(s, &w0, &w1, &w2, &w3);
    drone_real dw0;
    drone_real dw1;
    drone_real dw2;
    drone_real dw3;
    drone_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    for (int32_t i = 0; i < 3; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const drone_real lower_edge = drone_edge_at(lower_at, w0, w1, w2, w3);
        const drone_real upper_edge = drone_edge_at(upper_at, w0, w1, w2, w3);
        const drone_real lower_slope = drone_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const drone_real lower_rate = lower_slope * 2.6666666666666665;
        const drone_real upper_slope = drone_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const drone_real upper_rate = upper_slope * 2.6666666666666665;
        const drone_real x_i = x[i];
        const drone_real v_i = v[i];
        const drone_real width = upper_edge - lower_edge;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const drone_real v_width = upper_rate - lower_rate;
        const drone_real v_to_lower = v_i - lower_rate;
        const drone_real v_to_upper = upper_rate - v_i;
        const drone_real filter_i = drone_filter[i];
        const drone_real width_part = width * filter_i;
        const drone_real z_width = v_width + width_part;
        const drone_real lower_part = to_lower * filter_i;
        const drone_real z_to_lower = v_to_lower + lower_part;
        const drone_real upper_part = to_upper * filter_i;
        const drone_real z_to_upper = v_to_upper + upper_part;
        const bool z_nearer = z_to_upper < z_to_lower;
        const drone_real z_distance = z_nearer ? z_to_upper : z_to_lower;
        const drone_real z_share = z_distance / z_width;
        const bool z_beyond = z_share < (-1.0);
        const drone_real margin_z = z_beyond ? (-1.0) : z_share;
        const bool x_nearer = to_upper < to_lower;
        const drone_real x_distance = x_nearer ? to_upper : to_lower;
        const drone_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const drone_real margin_x = x_beyond ? (-1.0) : x_share;
        const bool x_smaller = margin_x < margin_z;
        const drone_real smaller = x_smaller ? margin_x : margin_z;
        margin[i] = smaller;
    }
}

bool drone_covered(const drone_real x[DRONE_N], const drone_real v[DRONE_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 3; ++i) {
        const drone_real x_i = x[i];
        const drone_real x_lower = drone_start_lower[i];
        const drone_real x_upper = drone_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const drone_real filter_i = drone_filter[i];
        const drone_real x_part = x_i * filter_i;
        const drone_real v_i = v[i];
        const drone_real z_i = v_i + x_part;
        const drone_real z_lower = drone_filtered_start_lower[i];
        const drone_real z_upper = drone_filtered_start_upper[i];
        const bool z_above = z_lower < z_i;
        const bool z_below = z_i < z_upper;
        const bool z_inside = z_above && z_below;
        const bool inside = x_inside && z_inside;
        const bool covered_next = inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void drone_transform(const drone_real lower[DRONE_N], const drone_real upper[DRONE_N],
                     const drone_real x[DRONE_N], drone_real e[DRONE_N], drone_real epsilon[DRONE_N],
                     drone_real xi[DRONE_N])
{
    for (int32_t i = 0; i < 3; ++i) {
        const drone_real lower_edge = lower[i];
        const drone_real upper_edge = upper[i];
        const drone_real x_i = x[i];
        const drone_real width = upper_edge - lower_edge;
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = 9.5367431640625e-7 < width;
        const drone_real safe_width = wide ? width : 9.5367431640625e-7;
        const drone_real to_lower = x_i - lower_edge;
        const drone_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const drone_real distance = upper_nearer ? to_upper : to_lower;
        const drone_real sign = upper_nearer ? (-1.0) : 1.0;
        const drone_real smallest = safe_width * 0.005;
        const drone_real widened = safe_width - width;
        const drone_real half = widened * 0.5;
        const drone_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const drone_real to_nearer = clear ? safe_distance : smallest;
        const drone_real to_farther = safe_width - to_nearer;
        const drone_real a = upper_nearer ? to_farther : to_nearer;
        const drone_real b = upper_nearer ? to_nearer : to_farther;
        const drone_real e_i = drone_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99) < e_i;
        const drone_real e_raised = e_above ? e_i : (-0.99);
        const bool e_beyond = 0.99 < e_raised;
        const drone_real e_limited = e_beyond ? 0.99 : e_raised;
        drone_real epsilon_nearer;
        drone_real xi_i;
        drone_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const drone_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const drone_real e_or_zero = empty ? 0.0 : e_limited;
        const drone_real e_out = finite ? e_or_zero : (drone_real)NAN;
        e[i] = e_out;
        const drone_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const drone_real epsilon_out = finite ? epsilon_or_zero : (drone_real)NAN;
        epsilon[i] = epsilon_out;
        const drone_real xi_or_zero = empty ? 0.0 : xi_i;
        const drone_real xi_out = finite ? xi_or_zero : (drone_real)NAN;
        xi[i] = xi_out;
    }
}
