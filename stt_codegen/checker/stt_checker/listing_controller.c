The C of a controller in floating point: all that it must be, but for its numbers.

P_ stands for the task's name, M_ for the same in capitals. $name is a number or a word that depends on the task: controller.py
says which, and computes it. A literal like 0.5 carries an F in a float controller. <<words>> stands for the piece with that heading.
A line that ends with [words] is there only for a task with these options: "order 1" or "order 2" (plant.order); "ticks"
(emit.tick_period); "libm" or "inline" (emit.math); "one gain" or "gains", "one clamp" or "clamps", "one filter" or "filters" (a
table, where a number differs by component); "limits" (control.u_max), "scaled" (with control.saturate), or "no limits";
"differences" (control.velocity); "float" or "double".

== controller
#include "P.h"
#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <string.h>  [inline]
<<compiler flags>>
static const P_real P_coefficients[$entries] = { $coefficients };
static const P_real P_filter[$n] = { $filter_table };  [order 2, filters]
static const P_real P_gain[$n] = { $gain_table };  [gains]
static const P_real P_e_max[$n] = { $e_max_table };  [clamps]
static const P_real P_least_share[$n] = { $smallest_share_table };  [clamps]
static const P_real P_u_max[$n] = { $u_max_table };  [limits]
static const P_real P_start_lower[$n] = { $start_lower };
static const P_real P_start_upper[$n] = { $start_upper };
static const P_real P_filtered_start_lower[$n] = { $filtered_start_lower };  [order 2]
static const P_real P_filtered_start_upper[$n] = { $filtered_start_upper };  [order 2]
<<exponent and mantissa>>  [inline]
<<segment of a time>>
<<segment of a tick>>  [ticks]
<<basis>>
<<rate of the basis>>
<<edge>>
<<error transform and law>>
<<tube>>
<<rate of the tube>>
<<filtered tube>>  [order 2]
<<velocity>>  [order 2, differences]
<<control>>
<<control at a tick>>  [ticks]
<<margin>>
<<margins>>
<<covered>>
<<transform>>

== compiler flags
/* Flags that change results are refused where the compiler has macros for them. avr-gcc has none after a pragma: this comes first. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error "P.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity"
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error "P.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding"
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)  [float]
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 1) && (FLT_EVAL_METHOD != 16)  [double]
#error "P.c: compile for $scalar arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that"
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)  [float]
#if defined(DBL_MANT_DIG) && (DBL_MANT_DIG != 53)  [double]
#error "P.c: $scalar is not IEEE-754's here, for which rounding is bounded"
#endif
/* No fused multiply-adds: Arduino's and other -std=gnu.. compilers would make them. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#pragma clang fp reassociate(off)
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#endif

== segment of a time
/* Spline time u = K t / t_c, held from 0 to the last number below K; the row of the table and s = u - floor(u). */
static inline void P_segment(P_real t, int32_t *row, P_real *s)
{
    const bool positive = 0.0 < t;
    const P_real started = positive ? t : 0.0;
    const P_real scaled = started * $per_second;
    const bool early = scaled < $last;
    const P_real u = early ? scaled : $last;
    const int32_t segment = (int32_t)u;
    const P_real base = (P_real)segment;
    const P_real place = u - base;
    const int32_t first = segment * $pairs;
    *row = first;
    *s = place;
}

== segment of a tick
/* The same for a count of ticks, tick_num/tick_den of a segment each, in integers; only s is rounded. */
static inline void P_segment_at_tick(uint32_t tick, int32_t *row, P_real *s)
{
    const bool running = tick < $ticksU;
    const uint32_t held = running ? tick : $ticksU;
    const int32_t count = (int32_t)held;
    const int32_t passed = count * $tick_num;
    const bool early = passed < $tick_end;
    const int32_t place = early ? passed : $tick_end;
    const int32_t whole = place / $tick_den;
    const bool before_last = whole < $last_segment;
    const int32_t segment = before_last ? whole : $last_segment;
    const int32_t base = segment * $tick_den;
    const int32_t rest = place - base;
    const P_real part = (P_real)rest;
    const P_real share = part / $tick_real;
    const int32_t first = segment * $pairs;
    *row = first;
    *s = share;
}

== basis
/* (1 - s)^3, 1 + 3 (1 - s)(1 + s (1 - s)), 1 + 3 s (1 + s (1 - s)), s^3: 6 times the cubic B-spline's weights. */
static inline void P_basis(P_real s, P_real *w0, P_real *w1, P_real *w2, P_real *w3)
{
    const P_real v0 = 1.0 - s;
    const P_real v1 = v0 * v0;
    const P_real v2 = v1 * v0;
    const P_real v3 = v0 * s;
    const P_real v4 = 1.0 + v3;
    const P_real v5 = 3.0 * v4;
    const P_real v6 = v0 * v5;
    const P_real v7 = 1.0 + v6;
    const P_real v8 = s * v5;
    const P_real v9 = 1.0 + v8;
    const P_real v10 = s * s;
    const P_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

== rate of the basis
/* Their derivatives by s: -3 (1 - s)^2, 3 s (3 s - 4), 3 (1 + 2 s - 3 s^2), 3 s^2. */
static inline void P_basis_rate(P_real s, P_real *dw0, P_real *dw1, P_real *dw2, P_real *dw3)
{
    const P_real v0 = 1.0 - s;
    const P_real v1 = v0 + v0;
    const P_real v2 = v0 * v1;
    const P_real v3 = v0 * v0;
    const P_real v4 = v2 + v3;
    const P_real v5 = -v4;
    const P_real v6 = v0 - s;
    const P_real v7 = 3.0 * v6;
    const P_real v8 = v0 * v7;
    const P_real v9 = v0 * s;
    const P_real v10 = 1.0 + v9;
    const P_real v11 = 3.0 * v10;
    const P_real v12 = v8 - v11;
    const P_real v13 = s * v7;
    const P_real v14 = v11 + v13;
    const P_real v15 = s + s;
    const P_real v16 = s * v15;
    const P_real v17 = s * s;
    const P_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

== edge
/* One edge, or its slope: w0 q0 + w1 q1 + w2 q2 + w3 q3 of four entries of the table, `at` and one, two and three rows after it. */
static inline P_real P_edge_at(int32_t at, P_real w0, P_real w1, P_real w2, P_real w3)
{
    const P_real q0 = P_coefficients[at];
    const int32_t at_1 = at + $row_1;
    const P_real q1 = P_coefficients[at_1];
    const int32_t at_2 = at + $row_2;
    const P_real q2 = P_coefficients[at_2];
    const int32_t at_3 = at + $row_3;
    const P_real q3 = P_coefficients[at_3];
    const P_real v0 = w0 * q0;
    const P_real v1 = w1 * q1;
    const P_real v2 = v0 + v1;
    const P_real v3 = w2 * q2;
    const P_real v4 = w3 * q3;
    const P_real v5 = v3 + v4;
    const P_real v6 = v2 + v5;
    return v6;
}

== error transform and law
/* e, from the distances a and b to both edges; epsilon = -ln(b/a), xi = 1/a + 1/b; u = -k xi epsilon. */
static inline P_real P_normalized_error(P_real a, P_real b, P_real width)
{
    const P_real v0 = a - b;
    const P_real v1 = v0 / width;
    return v1;
}
static inline void P_transformed_error(P_real a, P_real b, P_real *epsilon, P_real *xi)
{
    const P_real v0 = b / a;
    const P_real v1 = $log(v0);  [libm]
    <<logarithm>>  [inline]
    const P_real v2 = -v1;
    const P_real v3 = 1.0 + v0;
    const P_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}
static inline P_real P_law(P_real k, P_real xi, P_real epsilon)
{
    const P_real v0 = k * xi;
    const P_real v1 = v0 * epsilon;
    const P_real v2 = -v1;
    return v2;
}

== logarithm
/* v0 = m 2^e with m in [1/sqrt 2, sqrt 2): ln v0 = e ln 2 + 2 atanh((m - 1)/(m + 1)), within 2^-14. */
    const int32_t exponent = P_exponent(v0);
    const P_real base = (P_real)exponent;
    const P_real mantissa = P_mantissa(v0);
    const P_real below = mantissa - 1.0;
    const P_real above = mantissa + 1.0;
    const P_real s = below / above;
    const P_real z = s * s;
    const P_real bent = z * $bend;
    const P_real around = bent + 2.0;
    const P_real part = s * around;
    const P_real whole = base * $ln_2;
    const P_real v1 = whole + part;

== exponent and mantissa
/* By the bits of IEEE-754; the word less that of 1/sqrt 2, so that m begins there. */
typedef char P_real_size[(sizeof(P_real) == $bytesU) ? 1 : -1];
static inline int32_t P_exponent(P_real y)
{
    $word bits;
    (void)memcpy(&bits, &y, sizeof bits);
    return (int32_t)((bits - $cut) >> $places);
}
static inline P_real P_mantissa(P_real y)
{
    $word bits;
    (void)memcpy(&bits, &y, sizeof bits);
    bits = ((bits - $cut) & $mask) + $cut;
    P_real m;
    (void)memcpy(&m, &bits, sizeof m);
    return m;
}

== segment and s
    int32_t row;
    P_real s;
    P_segment(t, &row, &s);

== weights
    P_real w0;
    P_real w1;
    P_real w2;
    P_real w3;
    P_basis(s, &w0, &w1, &w2, &w3);

== rates
    P_real dw0;
    P_real dw1;
    P_real dw2;
    P_real dw3;
    P_basis_rate(s, &dw0, &dw1, &dw2, &dw3);

== places in the table
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;

== edges
        <<places in the table>>
        const P_real lower_edge = P_edge_at(lower_at, w0, w1, w2, w3);
        const P_real upper_edge = P_edge_at(upper_at, w0, w1, w2, w3);

== NaN unless t is finite
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < $n; ++j) {

== tube
void P_tube(P_real t, P_real lower[M_N], P_real upper[M_N])
{
    <<NaN unless t is finite>>
            lower[j] = (P_real)NAN;
            upper[j] = (P_real)NAN;
        }
        return;
    }
    <<segment and s>>
    <<weights>>
    for (int32_t i = 0; i < $n; ++i) {
        <<edges>>
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

== rate of the tube
void P_tube_rate(P_real t, P_real lower_rate[M_N], P_real upper_rate[M_N])
{
    <<NaN unless t is finite>>
            lower_rate[j] = (P_real)NAN;
            upper_rate[j] = (P_real)NAN;
        }
        return;
    }
    <<segment and s>>
    <<rates>>
    const bool moving = t < $t_c;
    const P_real per_second = moving ? $per_second : 0.0;
    for (int32_t i = 0; i < $n; ++i) {
        <<places in the table>>
        const P_real lower_slope = P_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const P_real lower_speed = lower_slope * per_second;
        const P_real upper_slope = P_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const P_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

== control
P_status P_control(P_real t, const P_real x[M_N], P_real u[M_N])  [order 1]
P_status P_control(P_real t, const P_real x[M_N], const P_real v[M_N], P_real u[M_N])  [order 2]
{
    const P_real t_zero = t * 0.0;
    P_real zero = t_zero;
    <<inputs that are not finite>>
    <<segment and s>>
    <<law>>
}

== control at a tick
P_status P_control_tick(uint32_t tick, const P_real x[M_N], P_real u[M_N])  [order 1]
P_status P_control_tick(uint32_t tick, const P_real x[M_N], const P_real v[M_N], P_real u[M_N])  [order 2]
{
    P_real zero = 0.0;
    <<inputs that are not finite>>
    int32_t row;
    P_real s;
    P_segment_at_tick(tick, &row, &s);
    <<law>>
}

== sum of zeros
/* 0 times each input: 0, or NaN where one is infinite or NaN. */
    for (int32_t j = 0; j < $n; ++j) {
        const P_real x_j = x[j];
        const P_real x_zero = x_j * 0.0;
        const P_real zeros = zero + x_zero;
        zero = zeros;
    }
    <<sum of zeros of v>>  [order 2]
    const bool finite = zero <= 0.0;  [order 1]
    const bool finite = v_zeros <= 0.0;  [order 2]
    const bool bad = !finite;

== inputs that are not finite
    <<sum of zeros>>
    if (bad) {
        for (int32_t m = 0; m < $n; ++m) {
            u[m] = 0.0;
        }
        return M_BAD_INPUT;
    }

== law
    <<weights>>
    <<rates>>  [order 2]
    bool outside = false;
    for (int32_t i = 0; i < $n; ++i) {
        <<state between the edges>>  [order 1]
        <<state and rate between the edges>>  [order 2]
        const P_real u_limit = P_u_max[i];  [limits]
        P_real epsilon;
        P_real xi;
        P_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const P_real u_i = P_law(gain, xi, epsilon);
        const P_real u_min = -u_limit;  [limits]
        const bool u_above = u_min < u_i;  [limits]
        const P_real u_raised = u_above ? u_i : u_min;  [limits]
        const bool u_beyond = u_limit < u_raised;  [limits]
        const P_real u_limited = u_beyond ? u_limit : u_raised;  [limits]
        u[i] = u_limited;  [limits]
        u[i] = u_i;  [no limits]
        outside = outside_next;
    }
    <<scale u>>  [scaled]
    return outside ? M_OUTSIDE_TUBE : M_OK;

== state between the edges
        <<edges>>
        const P_real x_i = x[i];
        const P_real least_share_i = P_least_share[i];  [clamps]
        const P_real gain_i = P_gain[i];  [gains]
        const P_real gain_minus = -gain_i;  [gains]
        const P_real width = upper_edge - lower_edge;
        const P_real to_lower = x_i - lower_edge;
        const P_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const P_real distance = upper_nearer ? to_upper : to_lower;
        const P_real gain = upper_nearer ? gain_minus : gain_i;  [gains]
        const P_real gain = upper_nearer ? $gain_minus : $gain;  [one gain]
        const P_real smallest = width * least_share_i;  [clamps]
        const P_real smallest = width * $smallest_share;  [one clamp]
        const bool clear = smallest < distance;
        const P_real to_nearer = clear ? distance : smallest;
        const P_real to_farther = width - to_nearer;
        const bool inside = 0.0 < distance;
        const bool outside_next = inside ? outside : true;

== scale u
/* By the one factor that brings the largest within the limit. */
    P_real largest = 0.0;
    for (int32_t p = 0; p < $n; ++p) {
        const P_real u_p = u[p];
        const bool negative = u_p < 0.0;
        const P_real minus = -u_p;
        const P_real size = negative ? minus : u_p;
        const bool more = largest < size;
        const P_real larger = more ? size : largest;
        largest = larger;
    }
    const bool over = $limit < largest;
    const P_real divisor = over ? largest : $limit;
    const P_real factor = $limit / divisor;
    for (int32_t r = 0; r < $n; ++r) {
        const P_real u_r = u[r];
        const P_real u_scaled = u_r * factor;
        const bool u_above = $limit_minus < u_scaled;
        const P_real u_raised = u_above ? u_scaled : $limit_minus;
        const bool u_beyond = $limit < u_raised;
        const P_real u_limited = u_beyond ? $limit : u_raised;
        u[r] = u_limited;
    }

== margin
P_real P_margin(P_real t, const P_real x[M_N])  [order 1]
P_real P_margin(P_real t, const P_real x[M_N], const P_real v[M_N])  [order 2]
{
    const P_real t_zero = t * 0.0;
    P_real zero = t_zero;
    <<sum of zeros>>
    if (bad) {
        return (P_real)NAN;
    }
    <<segment and s>>
    <<weights>>
    <<rates>>  [order 2]
    P_real margin = 0.5;
    for (int32_t i = 0; i < $n; ++i) {
        <<margin of a component>>
        const bool less = margin_x < margin;  [order 1]
        const P_real margin_next = less ? margin_x : margin;  [order 1]
        const bool less = smaller < margin;  [order 2]
        const P_real margin_next = less ? smaller : margin;  [order 2]
        margin = margin_next;
    }
    return margin;
}

== margins
void P_margins(P_real t, const P_real x[M_N], P_real margin[M_N])  [order 1]
void P_margins(P_real t, const P_real x[M_N], const P_real v[M_N], P_real margin[M_N])  [order 2]
{
    <<NaN unless t is finite>>
            margin[j] = (P_real)NAN;
        }
        return;
    }
    <<segment and s>>
    <<weights>>
    <<rates>>  [order 2]
    for (int32_t i = 0; i < $n; ++i) {
        <<margin of a component>>
        margin[i] = margin_x;  [order 1]
        margin[i] = smaller;  [order 2]
    }
}

== margin of a component
        <<edges>>  [order 1]
        const P_real x_i = x[i];  [order 1]
        const P_real width = upper_edge - lower_edge;  [order 1]
        const P_real to_lower = x_i - lower_edge;  [order 1]
        const P_real to_upper = upper_edge - x_i;  [order 1]
        <<distances>>  [order 2]
        <<filtered distances>>  [order 2]
        <<margin of v + lambda x>>  [order 2]
        const bool x_nearer = to_upper < to_lower;
        const P_real x_distance = x_nearer ? to_upper : to_lower;
        const P_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0);
        const P_real margin_x = x_beyond ? (-1.0) : x_share;
        <<smaller margin>>  [order 2]

== covered
bool P_covered(const P_real x[M_N])  [order 1]
bool P_covered(const P_real x[M_N], const P_real v[M_N])  [order 2]
{
    bool covered = true;
    for (int32_t i = 0; i < $n; ++i) {
        const P_real x_i = x[i];
        const P_real x_lower = P_start_lower[i];
        const P_real x_upper = P_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        <<start of v + lambda x>>  [order 2]
        const bool covered_next = x_inside ? covered : false;  [order 1]
        const bool covered_next = inside ? covered : false;  [order 2]
        covered = covered_next;
    }
    return covered;
}

== transform
void P_transform(const P_real lower[M_N], const P_real upper[M_N], const P_real x[M_N],
                 P_real e[M_N], P_real epsilon[M_N], P_real xi[M_N])
{
    for (int32_t i = 0; i < $n; ++i) {
        const P_real lower_edge = lower[i];
        const P_real upper_edge = upper[i];
        const P_real x_i = x[i];
        const P_real least_share_i = P_least_share[i];  [clamps]
        const P_real width = upper_edge - lower_edge;
        const bool filled = 0.0 < width;
        const bool empty = !filled;
        const bool wide = $narrowest < width;
        const P_real safe_width = wide ? width : $narrowest;
        const P_real to_lower = x_i - lower_edge;
        const P_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const P_real distance = upper_nearer ? to_upper : to_lower;
        const P_real sign = upper_nearer ? (-1.0) : 1.0;
        const P_real smallest = safe_width * least_share_i;  [clamps]
        const P_real smallest = safe_width * $smallest_share;  [one clamp]
        const P_real widened = safe_width - width;
        const P_real half = widened * 0.5;
        const P_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const P_real to_nearer = clear ? safe_distance : smallest;
        const P_real to_farther = safe_width - to_nearer;
        const P_real a = upper_nearer ? to_farther : to_nearer;
        const P_real b = upper_nearer ? to_nearer : to_farther;
        const P_real e_i = P_normalized_error(a, b, safe_width);
        const P_real e_max_i = P_e_max[i];  [clamps]
        const P_real e_max_minus = -e_max_i;  [clamps]
        const bool e_above = e_max_minus < e_i;  [clamps]
        const P_real e_raised = e_above ? e_i : e_max_minus;  [clamps]
        const bool e_beyond = e_max_i < e_raised;  [clamps]
        const P_real e_limited = e_beyond ? e_max_i : e_raised;  [clamps]
        const bool e_above = $e_max_minus < e_i;  [one clamp]
        const P_real e_raised = e_above ? e_i : $e_max_minus;  [one clamp]
        const bool e_beyond = $e_max < e_raised;  [one clamp]
        const P_real e_limited = e_beyond ? $e_max : e_raised;  [one clamp]
        P_real epsilon_nearer;
        P_real xi_i;
        P_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const P_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const P_real e_or_zero = empty ? 0.0 : e_limited;
        const P_real e_out = finite ? e_or_zero : (P_real)NAN;
        e[i] = e_out;
        const P_real epsilon_or_zero = empty ? 0.0 : epsilon_i;
        const P_real epsilon_out = finite ? epsilon_or_zero : (P_real)NAN;
        epsilon[i] = epsilon_out;
        const P_real xi_or_zero = empty ? 0.0 : xi_i;
        const P_real xi_out = finite ? xi_or_zero : (P_real)NAN;
        xi[i] = xi_out;
    }
}
