/* courier.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (courier.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * Every x(t) that stays in the tube satisfies the mission (P10): (eventually[4, 9] (always[0, 2] dock and
 * eventually[2, 12] (left or right)) and (not lab until[0, 24] dock) and always[0, 12] (not dock or eventually[0, 8]
 * charger)); times are seconds of t. It still holds where every time at which the tube is in a region, or off one, is
 * wrong by up to 0.00585 s.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include "courier.h"

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "courier.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "courier.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error "courier.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error "courier.c: float is not IEEE-754's here, for which rounding is bounded"
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
 * Multiples of 2^-20: exact in float and double.
 */
static const courier_real courier_coefficients[268] = {
    0.008747101F, 0.14206028F, -0.01875782F, 0.11455536F,
    0.016676903F, 0.14999008F, 0.016676903F, 0.14999008F,
    0.024606705F, 0.15791988F, 0.052111626F, 0.1854248F,
    0.032536507F, 0.16584969F, 0.08754635F, 0.22085857F,
    0.04046631F, 0.17377949F, 0.12298107F, 0.2562933F,
    0.04839611F, 0.18170929F, 0.15841484F, 0.29172802F,
    0.056325912F, 0.18963909F, 0.19384956F, 0.32716274F,
    0.064255714F, 0.1975689F, 0.22928429F, 0.36259747F,
    0.07218552F, 0.2054987F, 0.264719F, 0.3980322F,
    0.08011627F, 0.2134285F, 0.30015373F, 0.4334669F,
    0.088046074F, 0.2213583F, 0.33558846F, 0.46890163F,
    0.095975876F, 0.2292881F, 0.37102318F, 0.5043354F,
    0.10390568F, 0.23721886F, 0.4064579F, 0.5397701F,
    0.11183548F, 0.24514866F, 0.44189167F, 0.57520485F,
    0.11976528F, 0.25307846F, 0.4773264F, 0.6106396F,
    0.12769508F, 0.26100826F, 0.5127611F, 0.6460743F,
    0.13562489F, 0.26893806F, 0.54819584F, 0.681509F,
    0.14355469F, 0.27686787F, 0.58363056F, 0.71694374F,
    0.15148449F, 0.28479767F, 0.6190653F, 0.75237846F,
    0.15941429F, 0.29272747F, 0.6545F, 0.78781223F,
    0.1673441F, 0.30065727F, 0.68993473F, 0.82324696F,
    0.1752739F, 0.30858707F, 0.72225857F, 0.85557175F,
    0.1832037F, 0.31651688F, 0.7210617F, 0.8543749F,
    0.18162155F, 0.31493473F, 0.7198639F, 0.8531771F,
    0.18003845F, 0.31335163F, 0.71866703F, 0.8519802F,
    0.1770153F, 0.31032848F, 0.71747017F, 0.85078335F,
    0.1739912F, 0.30730438F, 0.71627235F, 0.84958553F,
    0.17701626F, 0.31032944F, 0.7174721F, 0.8507843F,
    0.24275398F, 0.37606716F, 0.7257843F, 0.8590975F,
    0.3084917F, 0.4418049F, 0.7340965F, 0.8674097F,
    0.37422943F, 0.5075426F, 0.74240875F, 0.87572193F,
    0.4399681F, 0.57328033F, 0.750721F, 0.88403416F,
    0.50570583F, 0.639019F, 0.75903416F, 0.8923464F,
    0.57144356F, 0.70475674F, 0.7673464F, 0.90065956F,
    0.6371813F, 0.77049446F, 0.7756586F, 0.9089718F,
    0.702919F, 0.8362322F, 0.78397083F, 0.917284F,
    0.7686577F, 0.9019699F, 0.7387419F, 0.87205505F,
    0.8343954F, 0.9677086F, 0.67300415F, 0.8063173F,
    0.82807064F, 0.9613838F, 0.6072664F, 0.7405796F,
    0.8217468F, 0.95506F, 0.5415287F, 0.6748409F,
    0.81542206F, 0.94873524F, 0.47579098F, 0.6091032F,
    0.80909824F, 0.9424114F, 0.4100523F, 0.5433655F,
    0.8027744F, 0.93608665F, 0.34431458F, 0.47762775F,
    0.79644966F, 0.92976284F, 0.27857685F, 0.41189003F,
    0.79012585F, 0.9234381F, 0.21283913F, 0.3461523F,
    0.7838011F, 0.91711426F, 0.1471014F, 0.28041363F,
    0.77747726F, 0.9107895F, 0.081362724F, 0.2146759F,
    0.7944689F, 0.92778206F, 0.015625F, 0.14893818F,
    0.81146145F, 0.9447746F, 0.058823586F, 0.19213676F,
    0.828454F, 0.9617672F, 0.102023125F, 0.23533535F,
    0.8454466F, 0.9787588F, 0.14522171F, 0.2785349F,
    0.8624382F, 0.9957514F, 0.1884203F, 0.32173347F,
    0.8794308F, 1.012744F, 0.23161888F, 0.36493206F,
    0.89642334F, 1.0297365F, 0.27481842F, 0.40813065F,
    0.91341496F, 1.0467281F, 0.318017F, 0.45133018F,
    0.9304075F, 1.0637207F, 0.3612156F, 0.49452877F,
    0.9474001F, 1.0807133F, 0.40441418F, 0.53772736F,
    0.96439266F, 1.0977049F, 0.44761372F, 0.58092594F,
    0.9813843F, 1.1146975F, 0.4908123F, 0.6241255F,
    0.99837685F, 1.13169F, 0.5340109F, 0.66732407F,
    1.0153694F, 1.1486826F, 0.5772095F, 0.71052265F,
    1.032361F, 1.1656742F, 0.620409F, 0.75372124F,
    1.0493536F, 1.1826668F, 0.6636076F, 0.7969208F,
    1.0663462F, 1.1996593F, 0.7068062F, 0.84011936F,
    1.0833387F, 1.216651F, 0.75000477F, 0.88331795F,
    1.0833387F, 1.216651F, 0.75000477F, 0.88331795F,
    1.0833387F, 1.216651F, 0.75000477F, 0.88331795F
};

/* Covered starts have x strictly above these bounds, by component. */
static const courier_real courier_start_lower[2] = {
    0.10406177F, 0.10406177F
};

/* Covered starts have x strictly below these bounds, by component. */
static const courier_real courier_start_upper[2] = {
    0.8959401F, 0.8959401F
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

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline courier_real courier_edge_at(int32_t at, courier_real w0, courier_real w1, courier_real w2,
                                           courier_real w3)
{
    const courier_real q0 = courier_coefficients[at];
    const int32_t at_1 = at + 4;
    const courier_real q1 = courier_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const courier_real q2 = courier_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const courier_real q3 = courier_coefficients[at_3];
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const courier_real lower_edge = courier_edge_at(lower_at, w0, w1, w2, w3);
        const courier_real upper_edge = courier_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const courier_real lower_slope = courier_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const courier_real lower_speed = lower_slope * per_second;
        const courier_real upper_slope = courier_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const courier_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
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
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const courier_real lower_edge = courier_edge_at(lower_at, w0, w1, w2, w3);
        const courier_real upper_edge = courier_edge_at(upper_at, w0, w1, w2, w3);
        const courier_real x_i = x[i];
        const courier_real width = upper_edge - lower_edge;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const courier_real distance = upper_nearer ? to_upper : to_lower;
        const courier_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const courier_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const courier_real to_nearer = clear ? distance : smallest;
        const courier_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        courier_real epsilon;
        courier_real xi;
        courier_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const courier_real u_i = courier_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const courier_real lower_edge = courier_edge_at(lower_at, w0, w1, w2, w3);
        const courier_real upper_edge = courier_edge_at(upper_at, w0, w1, w2, w3);
        const courier_real x_i = x[i];
        const courier_real width = upper_edge - lower_edge;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const courier_real x_distance = x_nearer ? to_upper : to_lower;
        const courier_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const courier_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const courier_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void courier_margins(courier_real t, const courier_real x[COURIER_N], courier_real margin[COURIER_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (courier_real)NAN;
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
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const courier_real lower_edge = courier_edge_at(lower_at, w0, w1, w2, w3);
        const courier_real upper_edge = courier_edge_at(upper_at, w0, w1, w2, w3);
        const courier_real x_i = x[i];
        const courier_real width = upper_edge - lower_edge;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const courier_real x_distance = x_nearer ? to_upper : to_lower;
        const courier_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const courier_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool courier_covered(const courier_real x[COURIER_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const courier_real x_i = x[i];
        const courier_real x_lower = courier_start_lower[i];
        const courier_real x_upper = courier_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void courier_transform(const courier_real lower[COURIER_N], const courier_real upper[COURIER_N],
                       const courier_real x[COURIER_N], courier_real e[COURIER_N],
                       courier_real epsilon[COURIER_N], courier_real xi[COURIER_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const courier_real lower_edge = lower[i];
        const courier_real upper_edge = upper[i];
        const courier_real x_i = x[i];
        const courier_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const courier_real safe_width = wide ? width : 9.536743e-7F;
        const courier_real to_lower = x_i - lower_edge;
        const courier_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const courier_real distance = upper_nearer ? to_upper : to_lower;
        const courier_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const courier_real smallest = safe_width * 0.005F;
        const courier_real widened = safe_width - width;
        const courier_real half = widened * 0.5F;
        const courier_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const courier_real to_nearer = clear ? safe_distance : smallest;
        const courier_real to_farther = safe_width - to_nearer;
        const courier_real a = upper_nearer ? to_farther : to_nearer;
        const courier_real b = upper_nearer ? to_nearer : to_farther;
        const courier_real e_i = courier_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const courier_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const courier_real e_limited = e_beyond ? 0.99F : e_raised;
        courier_real epsilon_nearer;
        courier_real xi_i;
        courier_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const courier_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const courier_real e_or_zero = empty ? 0.0F : e_limited;
        const courier_real e_out = finite ? e_or_zero : (courier_real)NAN;
        e[i] = e_out;
        const courier_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const courier_real epsilon_out = finite ? epsilon_or_zero : (courier_real)NAN;
        epsilon[i] = epsilon_out;
        const courier_real xi_or_zero = empty ? 0.0F : xi_i;
        const courier_real xi_out = finite ? xi_or_zero : (courier_real)NAN;
        xi[i] = xi_out;
    }
}
