/* either.c: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (either.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * Every x(t) that stays in the tube satisfies the mission (P10): eventually[8, 9.5] (T1 or T2); times are seconds of
 * t. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.158 s.
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
    0.6111526489257812, 0.7837944030761719, 0.6405181884765625, 0.8131599426269531,
    0.6667060852050781, 0.8332939147949219, 0.6667060852050781, 0.8332939147949219,
    0.7222633361816406, 0.8827896118164062, 0.6928977966308594, 0.853424072265625,
    0.7778167724609375, 0.9322853088378906, 0.7190895080566406, 0.8735580444335938,
    0.8333740234375, 0.9817848205566406, 0.7452774047851562, 0.8936920166015625,
    0.8889274597167969, 1.031280517578125, 0.7714691162109375, 0.9138259887695312,
    0.9444808959960938, 1.080780029296875, 0.7976608276367188, 0.9339561462402344,
    1.0000381469726562, 1.1302757263183594, 0.8238525390625, 0.9540901184082031,
    1.0555915832519531, 1.1797752380371094, 0.8500404357910156, 0.9742240905761719,
    1.11114501953125, 1.2292709350585938, 0.8762321472167969, 0.994354248046875,
    1.1667022705078125, 1.2787666320800781, 0.9024238586425781, 1.0144882202148438,
    1.2222557067871094, 1.3282661437988281, 0.9286117553710938, 1.0346221923828125,
    1.2778129577636719, 1.3777618408203125, 0.954803466796875, 1.0547561645507812,
    1.3333663940429688, 1.433319091796875, 0.9749374389648438, 1.0748863220214844,
    1.3889198303222656, 1.4888725280761719, 0.9950714111328125, 1.0950202941894531,
    1.4444770812988281, 1.5444259643554688, 1.0152015686035156, 1.1151542663574219,
    1.500030517578125, 1.5999832153320312, 1.0353355407714844, 1.1352882385253906,
    1.5555877685546875, 1.6555366516113281, 1.0554695129394531, 1.1554183959960938,
    1.6111412048339844, 1.7110939025878906, 1.0755996704101562, 1.1755523681640625,
    1.6666946411132812, 1.7666473388671875, 1.095733642578125, 1.1956863403320312,
    1.7222518920898438, 1.8222007751464844, 1.1158676147460938, 1.2158164978027344,
    1.7778053283691406, 1.8777580261230469, 1.1360015869140625, 1.2359504699707031,
    1.8333625793457031, 1.9333114624023438, 1.1561317443847656, 1.2560844421386719,
    1.888916015625, 1.9888687133789062, 1.1762657165527344, 1.2762184143066406,
    1.9444694519042969, 2.044422149658203, 1.1963996887207031, 1.2963485717773438,
    2.0000267028808594, 2.0999755859375, 1.2165336608886719, 1.3164825439453125,
    2.0555801391601562, 2.1555328369140625, 1.236663818359375, 1.3366165161132812,
    2.1111373901367188, 2.2110862731933594, 1.2567977905273438, 1.35675048828125,
    2.1666908264160156, 2.266643524169922, 1.2769317626953125, 1.3768806457519531,
    2.2222442626953125, 2.3221969604492188, 1.2970619201660156, 1.3970146179199219,
    2.277801513671875, 2.3777503967285156, 1.3171958923339844, 1.4171485900878906,
    2.333354949951172, 2.433307647705078, 1.3333549499511719, 1.4333038330078125,
    2.3889007568359375, 2.4888534545898438, 1.3495101928710938, 1.449462890625,
    2.3887786865234375, 2.4887313842773438, 1.4000282287597656, 1.4999771118164062,
    2.388660430908203, 2.4886093139648438, 1.4505538940429688, 1.5505027770996094,
    2.388538360595703, 2.4884910583496094, 1.5010795593261719, 1.6010284423828125,
    2.388416290283203, 2.4883689880371094, 1.551605224609375, 1.6515579223632812,
    2.3882980346679688, 2.4882469177246094, 1.6021308898925781, 1.7020835876464844,
    2.3881759643554688, 2.488128662109375, 1.6526565551757812, 1.7526092529296875,
    2.3880577087402344, 2.488006591796875, 1.7031822204589844, 1.8031349182128906,
    2.3879356384277344, 2.487884521484375, 1.7537078857421875, 1.8536605834960938,
    2.3878135681152344, 2.4877662658691406, 1.8042373657226562, 1.9041862487792969,
    2.3876953125, 2.4876441955566406, 1.8547630310058594, 1.9547119140625,
    2.3875732421875, 2.4875259399414062, 1.9052886962890625, 2.005237579345703,
    2.387451171875, 2.4874038696289062, 1.9558143615722656, 2.055767059326172,
    2.3873329162597656, 2.4872817993164062, 2.0063400268554688, 2.106292724609375,
    2.3872108459472656, 2.487163543701172, 2.056865692138672, 2.156818389892578,
    2.3870887756347656, 2.487041473388672, 2.107391357421875, 2.2073440551757812,
    2.3869705200195312, 2.486919403076172, 2.157917022705078, 2.2578697204589844,
    2.3868484497070312, 2.4868011474609375, 2.2084426879882812, 2.3083953857421875,
    2.386730194091797, 2.4866790771484375, 2.25897216796875, 2.3589210510253906,
    2.386608123779297, 2.486560821533203, 2.309497833251953, 2.4094467163085938,
    2.386486053466797, 2.486438751220703, 2.3600234985351562, 2.459972381591797,
    2.4376144409179688, 2.537567138671875, 2.4105491638183594, 2.5105018615722656,
    2.4887428283691406, 2.588695526123047, 2.4610748291015625, 2.5610275268554688,
    2.5398712158203125, 2.639820098876953, 2.5116004943847656, 2.611553192138672,
    2.5909996032714844, 2.690948486328125, 2.5621261596679688, 2.662078857421875,
    2.6421241760253906, 2.742076873779297, 2.612651824951172, 2.712604522705078,
    2.6932525634765625, 2.7932052612304688, 2.6631813049316406, 2.7631301879882812,
    2.7443809509277344, 2.8443336486816406, 2.7137069702148438, 2.8136558532714844,
    2.7955093383789062, 2.8954620361328125, 2.764232635498047, 2.8641815185546875,
    2.846637725830078, 2.9465866088867188, 2.81475830078125, 2.9147109985351562,
    2.89776611328125, 2.9977149963378906, 2.865283966064453, 2.9652366638183594,
    2.9488906860351562, 3.0488433837890625, 2.9158096313476562, 3.0157623291015625,
    3.000019073486328, 3.0999717712402344, 2.9663352966308594, 3.0662879943847656,
    3.000019073486328, 3.0999717712402344, 3.0168609619140625, 3.1168136596679688,
    3.000019073486328, 3.0999717712402344, 2.9663352966308594, 3.0662879943847656
};

/* Covered starts have x strictly above these bounds, by component. */
static const either_real either_start_lower[2] = {
    4.005237922668462, 4.005237922668462
};

/* Covered starts have x strictly below these bounds, by component. */
static const either_real either_start_upper[2] = {
    4.994762077331538, 4.994762077331538
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
