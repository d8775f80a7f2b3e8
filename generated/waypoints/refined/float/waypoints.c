/* waypoints.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
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
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0)
#error "waypoints.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif

/* B-spline control points divided by 6, one row for each of 64 + 3 points:
 * lower[0], upper[0], lower[1], upper[1]
 * Multiples of 2^-18: exact in float and double.
 */
static const waypoints_real waypoints_coefficients[268] = {
    0.65968704F, 0.84848404F, 0.66101074F, 0.84425354F,
    0.6667061F, 0.8332939F, 0.6667061F, 0.8332939F,
    0.67372894F, 0.8181038F, 0.67240524F, 0.8223305F,
    0.680748F, 0.80290985F, 0.6781006F, 0.81136703F,
    0.68777084F, 0.7877197F, 0.6837959F, 0.8004074F,
    0.6947899F, 0.7947426F, 0.6894913F, 0.78944397F,
    0.933239F, 1.0331917F, 0.94174576F, 1.0416985F,
    1.1716881F, 1.271637F, 1.228363F, 1.3283119F,
    1.4101334F, 1.510086F, 1.5149765F, 1.6149292F,
    1.4053688F, 1.5053177F, 1.80159F, 1.9015427F,
    1.4006004F, 1.5005493F, 2.0882072F, 2.1881561F,
    1.3958321F, 1.495781F, 2.3748207F, 2.4747734F,
    1.3910637F, 1.4910164F, 2.412632F, 2.5125809F,
    1.3862953F, 1.486248F, 2.3748245F, 2.4747734F,
    1.381527F, 1.4814796F, 2.3697853F, 2.4697342F,
    1.3767586F, 1.4767113F, 2.364746F, 2.4646988F,
    1.3719902F, 1.4719429F, 2.3597069F, 2.4596596F,
    1.5354462F, 1.635395F, 2.1965446F, 2.2964973F,
    1.6988983F, 1.7988472F, 2.0333824F, 2.133335F,
    1.8623505F, 1.9623032F, 1.8702202F, 1.9701691F,
    2.0258026F, 2.1257553F, 1.707058F, 1.8070068F,
    2.1892548F, 2.2892075F, 1.5438919F, 1.6438446F,
    2.3527107F, 2.4526596F, 1.3807297F, 1.4806824F,
    2.4000282F, 2.499981F, 1.333355F, 1.4333038F,
    2.4000282F, 2.499981F, 1.333355F, 1.4333038F,
    2.4000282F, 2.499981F, 1.333355F, 1.4333038F,
    2.3526688F, 2.4526176F, 1.3809814F, 1.4809341F,
    2.1894188F, 2.2893715F, 1.5428848F, 1.6428375F,
    2.0261726F, 2.1261253F, 1.7047882F, 1.8047409F,
    1.8629227F, 1.9628754F, 1.8666916F, 1.9666405F,
    1.6996765F, 1.7996292F, 2.028595F, 2.1285439F,
    1.5364304F, 1.6363792F, 2.1904984F, 2.2904472F,
    1.3731804F, 1.4731331F, 2.352398F, 2.4523506F,
    1.3710213F, 1.4709702F, 2.4000282F, 2.499981F,
    1.3688583F, 1.468811F, 2.4000282F, 2.499981F,
    1.3666954F, 1.4666481F, 2.4000282F, 2.499981F,
    1.3166809F, 1.4166336F, 2.4000282F, 2.499981F,
    1.3666992F, 1.4666481F, 2.370388F, 2.4703407F,
    1.6166954F, 1.7166443F, 2.118538F, 2.2184906F,
    1.8666916F, 1.9666405F, 1.8666916F, 1.9666405F,
    2.1166878F, 2.2166367F, 1.6148415F, 1.7147942F,
    2.366684F, 2.4666328F, 1.3629951F, 1.462944F,
    2.4167023F, 2.5166512F, 1.333355F, 1.4333038F,
    2.366684F, 2.4666328F, 1.333355F, 1.4333038F,
    2.3619232F, 2.461872F, 1.333355F, 1.4333038F,
    2.3571625F, 2.4571114F, 1.333355F, 1.4333038F,
    2.352398F, 2.4523506F, 1.333355F, 1.4333038F,
    2.3476372F, 2.4475899F, 1.333355F, 1.4333038F,
    2.3428764F, 2.4428291F, 1.333355F, 1.4333038F,
    2.3381157F, 2.4380646F, 1.333355F, 1.4333038F,
    2.333355F, 2.4333038F, 1.3748207F, 1.4747734F,
    2.3285904F, 2.428543F, 1.5675278F, 1.6674805F,
    2.3238297F, 2.4237823F, 1.7602348F, 1.8601875F,
    2.319069F, 2.4190216F, 1.9529419F, 2.0528908F,
    2.3143082F, 2.4142609F, 2.145649F, 2.2455978F,
    2.3792F, 2.4791527F, 2.3383522F, 2.438305F,
    2.5390625F, 2.6390152F, 2.5310593F, 2.631012F,
    2.6989288F, 2.7988815F, 2.7237663F, 2.823719F,
    2.8587952F, 2.958744F, 2.9164734F, 3.0164223F,
    3.0186577F, 3.1186104F, 3.0042381F, 3.1041908F,
    3.0666962F, 3.166645F, 3.0666962F, 3.166645F,
    3.0666962F, 3.166645F, 3.0666962F, 3.166645F,
    3.0666962F, 3.166645F, 3.0666962F, 3.166645F,
    3.0666962F, 3.166645F, 3.0666962F, 3.166645F,
    3.0666962F, 3.166645F, 3.0666962F, 3.166645F,
    3.0666962F, 3.166645F, 3.0666962F, 3.166645F,
    3.0666962F, 3.166645F, 3.0666962F, 3.166645F
};

/* Spline time u = 64 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 64 (t_c = 18 s).
 */
static inline void waypoints_segment(waypoints_real t, int32_t *row, waypoints_real *s)
{
    const bool positive = 0.0F < t;
    const waypoints_real started = positive ? t : 0.0F;
    const waypoints_real scaled = started * 3.5555556F;
    const bool early = scaled < 63.999996F;
    const waypoints_real u = early ? scaled : 63.999996F;
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
    const waypoints_real v0 = 1.0F - s;
    const waypoints_real v1 = v0 * v0;
    const waypoints_real v2 = v1 * v0;
    const waypoints_real v3 = v0 * s;
    const waypoints_real v4 = 1.0F + v3;
    const waypoints_real v5 = 3.0F * v4;
    const waypoints_real v6 = v0 * v5;
    const waypoints_real v7 = 1.0F + v6;
    const waypoints_real v8 = s * v5;
    const waypoints_real v9 = 1.0F + v8;
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
    const waypoints_real v0 = 1.0F - s;
    const waypoints_real v1 = v0 + v0;
    const waypoints_real v2 = v0 * v1;
    const waypoints_real v3 = v0 * v0;
    const waypoints_real v4 = v2 + v3;
    const waypoints_real v5 = -v4;
    const waypoints_real v6 = v0 - s;
    const waypoints_real v7 = 3.0F * v6;
    const waypoints_real v8 = v0 * v7;
    const waypoints_real v9 = v0 * s;
    const waypoints_real v10 = 1.0F + v9;
    const waypoints_real v11 = 3.0F * v10;
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
    const waypoints_real v1 = logf(v0);
    const waypoints_real v2 = -v1;
    const waypoints_real v3 = 1.0F + v0;
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
    const bool moving = t < 18.0F;
    const waypoints_real per_second = moving ? 3.5555556F : 0.0F;
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
    const waypoints_real t_zero = t * 0.0F;
    waypoints_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const waypoints_real x_j = x[j];
        const waypoints_real x_zero = x_j * 0.0F;
        const waypoints_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j2 = 0; j2 < 2; ++j2) {
            u[j2] = 0.0F;
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
        const waypoints_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const waypoints_real least = room * 0.005F;
        const bool clear = least < nearest;
        const waypoints_real near = clear ? nearest : least;
        const waypoints_real far = room - near;
        const bool within = 0.0F < nearest;
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
    const waypoints_real t_zero = t * 0.0F;
    waypoints_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const waypoints_real x_j = x[j];
        const waypoints_real x_zero = x_j * 0.0F;
        const waypoints_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
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
    waypoints_real margin = 0.5F;
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
        const bool beyond = share < (-1.0F);
        const waypoints_real held_share = beyond ? (-1.0F) : share;
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
        const bool filled = 0.0F < room;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < room;
        const waypoints_real width = wide ? room : 9.536743e-7F;
        const waypoints_real to_lower = x_i - lower_edge;
        const waypoints_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const waypoints_real nearest = upper_nearer ? to_upper : to_lower;
        const waypoints_real gain = upper_nearer ? (-1.0F) : 1.0F;
        const waypoints_real least = width * 0.005F;
        const waypoints_real widened = width - room;
        const waypoints_real spare = widened * 0.5F;
        const waypoints_real distance = nearest + spare;
        const bool farther = least < distance;
        const bool clear = filled && farther;
        const waypoints_real near = clear ? distance : least;
        const waypoints_real far = width - near;
        const waypoints_real a = upper_nearer ? far : near;
        const waypoints_real b = upper_nearer ? near : far;
        const waypoints_real e_raw = waypoints_normalized_error(a, b, width);
        const bool e_held_above = (-0.99F) < e_raw;
        const waypoints_real e_held_raised = e_held_above ? e_raw : (-0.99F);
        const bool e_held_over = 0.99F < e_held_raised;
        const waypoints_real e_held = e_held_over ? 0.99F : e_held_raised;
        waypoints_real epsilon_near;
        waypoints_real xi_i;
        waypoints_transformed_error(near, far, &epsilon_near, &xi_i);
        const waypoints_real epsilon_i = gain * epsilon_near;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_room = isfinite(room) != 0;
        const bool finite = finite_x && finite_room;
        const waypoints_real e_settled = empty ? 0.0F : e_held;
        const waypoints_real e_out = finite ? e_settled : (waypoints_real)NAN;
        e[i] = e_out;
        const waypoints_real epsilon_settled = empty ? 0.0F : epsilon_i;
        const waypoints_real epsilon_out = finite ? epsilon_settled : (waypoints_real)NAN;
        epsilon[i] = epsilon_out;
        const waypoints_real xi_settled = empty ? 0.0F : xi_i;
        const waypoints_real xi_out = finite ? xi_settled : (waypoints_real)NAN;
        xi[i] = xi_out;
    }
}
