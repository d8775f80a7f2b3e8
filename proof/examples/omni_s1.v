(* omni_s1.v: theorems about the controller in omni_s1.c. The texts of the task, of omni_s1.h and of omni_s1.c are below, and Coq reads them.

   For every finite time and every state below 2^30, `omni_s1_control` ends, without anything that C leaves undefined, if u is another array than x.
   It stores finite inputs that act as the law (13) with e clamped, on the distances of the state from edges L and U, up to
   32 units of rounding in the factor and in epsilon. Its status says whether the state is between L and U in every dimension.
   For every time, L and U are those of the tube theorem: as wide as demanded, within the state space, clear of every unsafe set,
   in the initial set at 0 and in the target set from t_c on.

   The closed loop, by example: the task has no control.period, and these numbers are not its own. Inputs are held: each is
   what `omni_s1_control` stores for the time, exact or rounded once, and the measured state of a sample. The first is taken
   at 0 and acts from then on; an input acts at most 0 s after its sample for the first time, and never when that is older
   than 0.001 s. What is measured is wrong by at most 1.25169e-06. Take any plant xdot_i = f_i + sum over j of g_ij u_j with
   |f_i| (drift and disturbance) at most 0.05, g_ii from 1 to 1, g_ij = 0 for other j. Then every trajectory from every start
   with |e| at most 0.95 keeps |e| at most 0.95 for as long as there are inputs, e being that of the exact tube; it is in the
   state space and the clearance away from every unsafe set, and from t = 9 s on in the target set. Unsafe sets are grown and
   the state space is shrunk by the body.

   Assumed: IEEE 754 arithmetic without contraction, and a library whose logarithm is within 4 units in the last place. *)
From Coq Require Import ZArith QArith Qreals Reals List String.
From Coquelicot Require Import Coquelicot.
From Flocq Require Import IEEE754.BinarySingleNaN.
From Stt Require HeldInputs HeldInputLaw.
From Stt Require Import Tube Speed Rounding Emitted EmittedTube Syntax Read Run Emission Control Semantics Edge Law Controller Windows Period Design Sound Toml Header.
Import ListNotations.
Open Scope R_scope.

(* The three files, as they are. *)
Definition the_toml : string := string_of "#:schema ../docs/task.schema.json
# The paper's case study, start S1: a robot in a room of 5 m by 5 m, from the upper left corner to the upper right, in 9 s.
name = ""omni_s1""
prescribed_time = 9.0
initial_state = [0.25, 4.75]

[state_space]
lower = [0.0, 0.0]
upper = [5.0, 5.0]

[initial_set]
lower = [0.0, 4.5]
upper = [0.5, 5.0]

[target_set]
lower = [4.5, 4.5]
upper = [5.0, 5.0]

[[unsafe]]
name = ""O1""
lower = [1.0, 4.0]
upper = [2.0, 5.0]

[[unsafe]]
name = ""O2""
lower = [2.0, 2.5]
upper = [3.0, 3.5]

[[unsafe]]
name = ""O3""
lower = [1.0, 0.5]
upper = [2.0, 1.5]

[[unsafe]]
name = ""O4""
lower = [4.0, 1.5]
upper = [5.0, 2.5]

[tube]
clearance = 0.03
min_width = 0.05

[control]
gain = 0.5
"%text.
Definition the_header : string := string_of "/* omni_s1.h: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (omni_s1.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * Call omni_s1_control once every period with the time since the start and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef OMNI_S1_H
#define OMNI_S1_H

#include <stdbool.h>

#ifdef __cplusplus
extern ""C"" {
#endif

typedef float omni_s1_real;

#define OMNI_S1_N 2
#define OMNI_S1_T_C 9.0F /* prescribed time, seconds */
#define OMNI_S1_SHARE 0.98999995F /* 0.99 of the half widths at t = 0, rounded down: for omni_s1_covered */
#define OMNI_S1_DESIGN_HASH ""93e290185d1afd3c"" /* log it: names this design */

typedef enum {
    OMNI_S1_OK = 0,
    OMNI_S1_OUTSIDE_TUBE = 1,
    OMNI_S1_BAD_INPUT = 2
} omni_s1_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void omni_s1_tube(omni_s1_real t, omni_s1_real lower[OMNI_S1_N], omni_s1_real upper[OMNI_S1_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void omni_s1_tube_rate(omni_s1_real t, omni_s1_real lower_rate[OMNI_S1_N], omni_s1_real upper_rate[OMNI_S1_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * t: seconds since the start (held within [0, t_c]); x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
omni_s1_status omni_s1_control(omni_s1_real t, const omni_s1_real x[OMNI_S1_N], omni_s1_real u[OMNI_S1_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
omni_s1_real omni_s1_margin(omni_s1_real t, const omni_s1_real x[OMNI_S1_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void omni_s1_margins(omni_s1_real t, const omni_s1_real x[OMNI_S1_N], omni_s1_real margin[OMNI_S1_N]);

/* Whether the paper's Theorem 4.1, in continuous time, covers a start at the measured x:
 * every component of x is within 0.99 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool omni_s1_covered(const omni_s1_real x[OMNI_S1_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void omni_s1_transform(const omni_s1_real lower[OMNI_S1_N], const omni_s1_real upper[OMNI_S1_N],
                       const omni_s1_real x[OMNI_S1_N], omni_s1_real e[OMNI_S1_N],
                       omni_s1_real epsilon[OMNI_S1_N], omni_s1_real xi[OMNI_S1_N]);

#ifdef __cplusplus
}
#endif

#endif
"%text.
Definition the_text : string := string_of "/* omni_s1.c: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (omni_s1.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 */
#include ""omni_s1.h""

#include <float.h>
#include <math.h>
#include <stdbool.h>
#include <stdint.h>

/* Flags that change results are refused, before the pragma: after it avr-gcc has no macros for them. */
#if defined(__FAST_MATH__) || (defined(__FINITE_MATH_ONLY__) && (__FINITE_MATH_ONLY__ > 0))
#error ""omni_s1.c: compile without -ffast-math and -ffinite-math-only; it tests its inputs for NaN and infinity""
#endif
#if defined(__ASSOCIATIVE_MATH__) || defined(__RECIPROCAL_MATH__)
#error ""omni_s1.c: compile without -funsafe-math-optimizations, -fassociative-math, -freciprocal-math: they change rounding""
#endif
#if defined(FLT_EVAL_METHOD) && (FLT_EVAL_METHOD != 0) && (FLT_EVAL_METHOD != 16)
#error ""omni_s1.c: compile for float arithmetic, not the x87's (-mfpmath=sse): rounding is bounded for that""
#endif
#if defined(FLT_MANT_DIG) && (FLT_MANT_DIG != 24)
#error ""omni_s1.c: float is not IEEE-754's here, for which rounding is bounded""
#endif
/* No fused multiply-adds: Arduino's and other -std=gnu.. compilers would make them. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#pragma clang fp reassociate(off)
#elif defined(__GNUC__)
#pragma GCC optimize (""fp-contract=off"")
#endif

/* B-spline control points divided by 6, one row for each of 32 + 3 points:
 * lower[0], upper[0], lower[1], upper[1]
 * Multiples of 2^-20: exact in float and double.
 */
static const omni_s1_real omni_s1_coefficients[140] = {
    -0.012588501F, 0.07280731F, 0.777133F, 0.8619337F,
    0.0000104904175F, 0.08332348F, 0.7500105F, 0.8333235F,
    0.012608528F, 0.09383869F, 0.722888F, 0.80471325F,
    0.025206566F, 0.104353905F, 0.6957655F, 0.776103F,
    0.037805557F, 0.11487007F, 0.668643F, 0.7474928F,
    0.050403595F, 0.12538528F, 0.6415205F, 0.7188816F,
    0.06300163F, 0.1359005F, 0.614398F, 0.6902714F,
    0.08876228F, 0.16166115F, 0.5872755F, 0.66166115F,
    0.11452484F, 0.1874237F, 0.560153F, 0.6330519F,
    0.1402874F, 0.21318626F, 0.5666475F, 0.6395464F,
    0.16605091F, 0.23894978F, 0.57314205F, 0.6460409F,
    0.19181347F, 0.26471233F, 0.5796375F, 0.6525364F,
    0.21757603F, 0.2904749F, 0.58613205F, 0.6590309F,
    0.24333858F, 0.31623745F, 0.5888052F, 0.66170406F,
    0.26910114F, 0.342F, 0.5886774F, 0.6615763F,
    0.2948637F, 0.36776257F, 0.58855057F, 0.66144943F,
    0.32062626F, 0.39352512F, 0.5884237F, 0.6613226F,
    0.34638977F, 0.41928864F, 0.58829594F, 0.6611948F,
    0.37215233F, 0.4450512F, 0.5909691F, 0.66386795F,
    0.3979149F, 0.47081375F, 0.6023283F, 0.67522717F,
    0.42367744F, 0.4965763F, 0.61368847F, 0.68658733F,
    0.44944F, 0.52233887F, 0.62504864F, 0.6979475F,
    0.47520256F, 0.5481014F, 0.63640785F, 0.7093067F,
    0.5009661F, 0.57386494F, 0.647768F, 0.7206669F,
    0.52672863F, 0.5996275F, 0.65912724F, 0.7320261F,
    0.5524912F, 0.62539005F, 0.6704874F, 0.74338627F,
    0.57825375F, 0.6511526F, 0.6818466F, 0.7547455F,
    0.6040163F, 0.67691517F, 0.6932068F, 0.76610565F,
    0.62977886F, 0.7026777F, 0.704566F, 0.77746487F,
    0.6555414F, 0.7284403F, 0.7159262F, 0.78882504F,
    0.68130493F, 0.7542038F, 0.7272854F, 0.80018425F,
    0.7070675F, 0.77996635F, 0.73864555F, 0.8115444F,
    0.73283005F, 0.8057289F, 0.75000477F, 0.82290363F,
    0.7585926F, 0.8314915F, 0.75000477F, 0.82290363F,
    0.73283005F, 0.8057289F, 0.75000477F, 0.82290363F
};

/* Covered starts have x strictly above these bounds, by component. */
static const omni_s1_real omni_s1_start_lower[2] = {
    0.0025619746F, 4.502563F
};

/* Covered starts have x strictly below these bounds, by component. */
static const omni_s1_real omni_s1_start_upper[2] = {
    0.49743992F, 4.997441F
};

/* Spline time u = 32 t / t_c of t held within [0, t_c]: table index of segment floor(u), and s = u - floor(u).
 * Before 0 the start; from t_c on the last number below 32 (t_c = 9 s).
 */
static inline void omni_s1_segment(omni_s1_real t, int32_t *row, omni_s1_real *s)
{
    const bool positive = 0.0F < t;
    const omni_s1_real started = positive ? t : 0.0F;
    const omni_s1_real scaled = started * 3.5555556F;
    const bool early = scaled < 31.999998F;
    const omni_s1_real u = early ? scaled : 31.999998F;
    const int32_t segment = (int32_t)u;
    const omni_s1_real base = (omni_s1_real)segment;
    const omni_s1_real place = u - base;
    const int32_t first = segment * 4;
    *row = first;
    *s = place;
}

/* 6 times the uniform cubic B-spline basis at s in [0, 1]: weights >= 0 with sum 6. */
static inline void omni_s1_basis(omni_s1_real s, omni_s1_real *w0, omni_s1_real *w1, omni_s1_real *w2,
                                 omni_s1_real *w3)
{
    const omni_s1_real v0 = 1.0F - s;
    const omni_s1_real v1 = v0 * v0;
    const omni_s1_real v2 = v1 * v0;
    const omni_s1_real v3 = v0 * s;
    const omni_s1_real v4 = 1.0F + v3;
    const omni_s1_real v5 = 3.0F * v4;
    const omni_s1_real v6 = v0 * v5;
    const omni_s1_real v7 = 1.0F + v6;
    const omni_s1_real v8 = s * v5;
    const omni_s1_real v9 = 1.0F + v8;
    const omni_s1_real v10 = s * s;
    const omni_s1_real v11 = v10 * s;
    *w0 = v2;
    *w1 = v7;
    *w2 = v9;
    *w3 = v11;
}

/* Derivative of the weights with respect to s. */
static inline void omni_s1_basis_rate(omni_s1_real s, omni_s1_real *dw0, omni_s1_real *dw1, omni_s1_real *dw2,
                                      omni_s1_real *dw3)
{
    const omni_s1_real v0 = 1.0F - s;
    const omni_s1_real v1 = v0 + v0;
    const omni_s1_real v2 = v0 * v1;
    const omni_s1_real v3 = v0 * v0;
    const omni_s1_real v4 = v2 + v3;
    const omni_s1_real v5 = -v4;
    const omni_s1_real v6 = v0 - s;
    const omni_s1_real v7 = 3.0F * v6;
    const omni_s1_real v8 = v0 * v7;
    const omni_s1_real v9 = v0 * s;
    const omni_s1_real v10 = 1.0F + v9;
    const omni_s1_real v11 = 3.0F * v10;
    const omni_s1_real v12 = v8 - v11;
    const omni_s1_real v13 = s * v7;
    const omni_s1_real v14 = v11 + v13;
    const omni_s1_real v15 = s + s;
    const omni_s1_real v16 = s * v15;
    const omni_s1_real v17 = s * s;
    const omni_s1_real v18 = v16 + v17;
    *dw0 = v5;
    *dw1 = v12;
    *dw2 = v14;
    *dw3 = v18;
}

/* An edge of the tube (or its slope in spline time): sum of w_j q_j,
 * of the control points that stand at `at` and one, two and three rows after it.
 */
static inline omni_s1_real omni_s1_edge_at(int32_t at, omni_s1_real w0, omni_s1_real w1, omni_s1_real w2,
                                           omni_s1_real w3)
{
    const omni_s1_real q0 = omni_s1_coefficients[at];
    const int32_t at_1 = at + 4;
    const omni_s1_real q1 = omni_s1_coefficients[at_1];
    const int32_t at_2 = at + 8;
    const omni_s1_real q2 = omni_s1_coefficients[at_2];
    const int32_t at_3 = at + 12;
    const omni_s1_real q3 = omni_s1_coefficients[at_3];
    const omni_s1_real v0 = w0 * q0;
    const omni_s1_real v1 = w1 * q1;
    const omni_s1_real v2 = v0 + v1;
    const omni_s1_real v3 = w2 * q2;
    const omni_s1_real v4 = w3 * q3;
    const omni_s1_real v5 = v3 + v4;
    const omni_s1_real v6 = v2 + v5;
    return v6;
}

/* Normalized error e = (2 x - gamma_s) / gamma_d, from a = x - lower, b = upper - x. */
static inline omni_s1_real omni_s1_normalized_error(omni_s1_real a, omni_s1_real b, omni_s1_real width)
{
    const omni_s1_real v0 = a - b;
    const omni_s1_real v1 = v0 / width;
    return v1;
}

/* Transformed error epsilon = ln((1 + e)/(1 - e)) = ln(a/b) and xi = d epsilon/dx = 1/a + 1/b. */
static inline void omni_s1_transformed_error(omni_s1_real a, omni_s1_real b, omni_s1_real *epsilon,
                                             omni_s1_real *xi)
{
    const omni_s1_real v0 = b / a;
    const omni_s1_real v1 = logf(v0);
    const omni_s1_real v2 = -v1;
    const omni_s1_real v3 = 1.0F + v0;
    const omni_s1_real v4 = v3 / b;
    *epsilon = v2;
    *xi = v4;
}

/* Control law (13): u = -k xi epsilon. */
static inline omni_s1_real omni_s1_law(omni_s1_real k, omni_s1_real xi, omni_s1_real epsilon)
{
    const omni_s1_real v0 = k * xi;
    const omni_s1_real v1 = v0 * epsilon;
    const omni_s1_real v2 = -v1;
    return v2;
}

void omni_s1_tube(omni_s1_real t, omni_s1_real lower[OMNI_S1_N], omni_s1_real upper[OMNI_S1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower[j] = (omni_s1_real)NAN;
            upper[j] = (omni_s1_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void omni_s1_tube_rate(omni_s1_real t, omni_s1_real lower_rate[OMNI_S1_N], omni_s1_real upper_rate[OMNI_S1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            lower_rate[j] = (omni_s1_real)NAN;
            upper_rate[j] = (omni_s1_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real dw0;
    omni_s1_real dw1;
    omni_s1_real dw2;
    omni_s1_real dw3;
    omni_s1_basis_rate(s, &dw0, &dw1, &dw2, &dw3);
    const bool moving = t < 9.0F;
    const omni_s1_real per_second = moving ? 3.5555556F : 0.0F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_slope = omni_s1_edge_at(lower_at, dw0, dw1, dw2, dw3);
        const omni_s1_real lower_speed = lower_slope * per_second;
        const omni_s1_real upper_slope = omni_s1_edge_at(upper_at, dw0, dw1, dw2, dw3);
        const omni_s1_real upper_speed = upper_slope * per_second;
        lower_rate[i] = lower_speed;
        upper_rate[i] = upper_speed;
    }
}

omni_s1_status omni_s1_control(omni_s1_real t, const omni_s1_real x[OMNI_S1_N], omni_s1_real u[OMNI_S1_N])
{
    const omni_s1_real t_zero = t * 0.0F;
    omni_s1_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s1_real x_j = x[j];
        const omni_s1_real x_zero = x_j * 0.0F;
        const omni_s1_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        for (int32_t m = 0; m < 2; ++m) {
            u[m] = 0.0F;
        }
        return OMNI_S1_BAD_INPUT;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s1_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s1_real gain = upper_nearer ? (-0.5F) : 0.5F;
        const omni_s1_real smallest = width * 0.005F;
        const bool clear = smallest < distance;
        const omni_s1_real to_nearer = clear ? distance : smallest;
        const omni_s1_real to_farther = width - to_nearer;
        const bool inside = 0.0F < distance;
        const bool outside_next = inside ? outside : true;
        omni_s1_real epsilon;
        omni_s1_real xi;
        omni_s1_transformed_error(to_nearer, to_farther, &epsilon, &xi);
        const omni_s1_real u_i = omni_s1_law(gain, xi, epsilon);
        u[i] = u_i;
        outside = outside_next;
    }
    return outside ? OMNI_S1_OUTSIDE_TUBE : OMNI_S1_OK;
}

omni_s1_real omni_s1_margin(omni_s1_real t, const omni_s1_real x[OMNI_S1_N])
{
    const omni_s1_real t_zero = t * 0.0F;
    omni_s1_real zero = t_zero;
    for (int32_t j = 0; j < 2; ++j) {
        const omni_s1_real x_j = x[j];
        const omni_s1_real x_zero = x_j * 0.0F;
        const omni_s1_real zeros = zero + x_zero;
        zero = zeros;
    }
    const bool finite = zero <= 0.0F;
    const bool bad = !finite;
    if (bad) {
        return (omni_s1_real)NAN;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    omni_s1_real margin = 0.5F;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s1_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s1_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const omni_s1_real margin_x = x_beyond ? (-1.0F) : x_share;
        const bool less = margin_x < margin;
        const omni_s1_real margin_next = less ? margin_x : margin;
        margin = margin_next;
    }
    return margin;
}

void omni_s1_margins(omni_s1_real t, const omni_s1_real x[OMNI_S1_N], omni_s1_real margin[OMNI_S1_N])
{
    const bool finite = isfinite(t) != 0;
    const bool bad = !finite;
    if (bad) {
        for (int32_t j = 0; j < 2; ++j) {
            margin[j] = (omni_s1_real)NAN;
        }
        return;
    }
    int32_t row;
    omni_s1_real s;
    omni_s1_segment(t, &row, &s);
    omni_s1_real w0;
    omni_s1_real w1;
    omni_s1_real w2;
    omni_s1_real w3;
    omni_s1_basis(s, &w0, &w1, &w2, &w3);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const omni_s1_real lower_edge = omni_s1_edge_at(lower_at, w0, w1, w2, w3);
        const omni_s1_real upper_edge = omni_s1_edge_at(upper_at, w0, w1, w2, w3);
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool x_nearer = to_upper < to_lower;
        const omni_s1_real x_distance = x_nearer ? to_upper : to_lower;
        const omni_s1_real x_share = x_distance / width;
        const bool x_beyond = x_share < (-1.0F);
        const omni_s1_real margin_x = x_beyond ? (-1.0F) : x_share;
        margin[i] = margin_x;
    }
}

bool omni_s1_covered(const omni_s1_real x[OMNI_S1_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s1_real x_i = x[i];
        const omni_s1_real x_lower = omni_s1_start_lower[i];
        const omni_s1_real x_upper = omni_s1_start_upper[i];
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}

void omni_s1_transform(const omni_s1_real lower[OMNI_S1_N], const omni_s1_real upper[OMNI_S1_N],
                       const omni_s1_real x[OMNI_S1_N], omni_s1_real e[OMNI_S1_N],
                       omni_s1_real epsilon[OMNI_S1_N], omni_s1_real xi[OMNI_S1_N])
{
    for (int32_t i = 0; i < 2; ++i) {
        const omni_s1_real lower_edge = lower[i];
        const omni_s1_real upper_edge = upper[i];
        const omni_s1_real x_i = x[i];
        const omni_s1_real width = upper_edge - lower_edge;
        const bool filled = 0.0F < width;
        const bool empty = !filled;
        const bool wide = 9.536743e-7F < width;
        const omni_s1_real safe_width = wide ? width : 9.536743e-7F;
        const omni_s1_real to_lower = x_i - lower_edge;
        const omni_s1_real to_upper = upper_edge - x_i;
        const bool upper_nearer = to_upper < to_lower;
        const omni_s1_real distance = upper_nearer ? to_upper : to_lower;
        const omni_s1_real sign = upper_nearer ? (-1.0F) : 1.0F;
        const omni_s1_real smallest = safe_width * 0.005F;
        const omni_s1_real widened = safe_width - width;
        const omni_s1_real half = widened * 0.5F;
        const omni_s1_real safe_distance = distance + half;
        const bool farther = smallest < safe_distance;
        const bool clear = filled && farther;
        const omni_s1_real to_nearer = clear ? safe_distance : smallest;
        const omni_s1_real to_farther = safe_width - to_nearer;
        const omni_s1_real a = upper_nearer ? to_farther : to_nearer;
        const omni_s1_real b = upper_nearer ? to_nearer : to_farther;
        const omni_s1_real e_i = omni_s1_normalized_error(a, b, safe_width);
        const bool e_above = (-0.99F) < e_i;
        const omni_s1_real e_raised = e_above ? e_i : (-0.99F);
        const bool e_beyond = 0.99F < e_raised;
        const omni_s1_real e_limited = e_beyond ? 0.99F : e_raised;
        omni_s1_real epsilon_nearer;
        omni_s1_real xi_i;
        omni_s1_transformed_error(to_nearer, to_farther, &epsilon_nearer, &xi_i);
        const omni_s1_real epsilon_i = sign * epsilon_nearer;
        const bool finite_x = isfinite(x_i) != 0;
        const bool finite_width = isfinite(width) != 0;
        const bool finite = finite_x && finite_width;
        const omni_s1_real e_or_zero = empty ? 0.0F : e_limited;
        const omni_s1_real e_out = finite ? e_or_zero : (omni_s1_real)NAN;
        e[i] = e_out;
        const omni_s1_real epsilon_or_zero = empty ? 0.0F : epsilon_i;
        const omni_s1_real epsilon_out = finite ? epsilon_or_zero : (omni_s1_real)NAN;
        epsilon[i] = epsilon_out;
        const omni_s1_real xi_or_zero = empty ? 0.0F : xi_i;
        const omni_s1_real xi_out = finite ? xi_or_zero : (omni_s1_real)NAN;
        xi[i] = xi_out;
    }
}
"%text.

(* The task in the first file. Unsafe sets are grown and the state space is shrunk by the body; all numbers are exact. *)
Definition the_task : Tube.task := (Task 2 (9 # 1) [(1 # 4); (19 # 4)]
  (Box [(0 # 1); (0 # 1)] [(5 # 1); (5 # 1)]) (* state space *)
  (Box [(0 # 1); (9 # 2)] [(1 # 2); (5 # 1)]) (* initial set *)
  (Box [(9 # 2); (9 # 2)] [(5 # 1); (5 # 1)]) (* target set *)
  [(shape_of_box (Box [(1 # 1); (4 # 1)] [(2 # 1); (5 # 1)]));
   (shape_of_box (Box [(2 # 1); (5 # 2)] [(3 # 1); (7 # 2)]));
   (shape_of_box (Box [(1 # 1); (1 # 2)] [(2 # 1); (3 # 2)]));
   (shape_of_box (Box [(4 # 1); (3 # 2)] [(5 # 1); (5 # 2)]))] (* unsafe sets *)
  (3 # 100) (1 # 20) (* clearance, least width *)
  [] [] (* half-spaces that cut state space and target *))%Q.
Lemma task_read : task_in the_toml = Some ("omni_s1"%string, the_task).
Proof. vm_cast_no_check (eq_refl (Some ("omni_s1"%string, the_task))). Qed.

(* The header has this type of numbers, these values of the status, prototypes, and nothing else that the C could use. *)
Lemma header_read : header_ok Single "omni_s1"%string 2 the_header = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

Definition the_unit : Q := (1 # 1048576).
Definition the_error : Q := (1 # 131072).

Definition the_source := read_source (literal_suffix Single) "omni_s1"%string the_text.
Definition the_constants : constants := Eval vm_compute in constants_of Single the_source.
Definition the_coefficients : list decimal := Eval vm_compute in coefficients_of the_source.
Definition the_table : Tube.table := Eval vm_compute in rows_of Single the_unit the_constants the_coefficients.
Definition the_scale : time_scale := Eval vm_compute in scale_of Single the_constants.
Definition the_gains : list Q := Eval vm_compute in gains_of Single the_constants.
Definition the_limits : list (option Q) := Eval vm_compute in limits_of Single the_constants.
Definition the_clamp_shares : list Q := Eval vm_compute in clamp_shares_of Single the_constants.
Definition the_step_maxima : list Z := Eval vm_compute in step_maxima_of (Tube.n the_task) the_table.
Definition the_time_error : Q := Eval vm_compute in time_error_of Single (Tube.t_c the_task) the_table the_scale.
Definition the_program : source := Source (expected_directives the_constants "omni_s1"%string) (emitted_tables the_constants the_coefficients) (Emission.emitted_functions the_constants).

(* The text is this program: the tables, and the functions that `tube` and `control` are made of. *)
Lemma text_read : option_map relevant_part (read_source (literal_suffix Single) "omni_s1"%string the_text) = Some the_program.
Proof. vm_cast_no_check (eq_refl (Some the_program)). Qed.

(* How Coq searches for P1 to P5; nothing in it is believed. It has the number of times that a segment may be halved, and normals for every unsafe set. *)
Definition the_search : search_plan := SearchPlan 20 [[]; []; []; []].
(* The exact tube has P1 to P5, with room for the error. *)
Lemma tube_checked : tube_check the_unit the_error the_search the_task the_table = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
(* The edges are no faster than the_step_maxima says. *)
Lemma slopes_checked : slopes_check the_error the_task the_table the_step_maxima = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
(* P7: the arithmetic moves no edge by more than the error. *)
Lemma rounding_checked : rounding_check Single the_unit the_error the_task the_table the_step_maxima the_scale the_time_error = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
(* The constants and the table of the text are these numbers, of ordinary size. *)
Lemma constants_checked : constants_check Single the_constants the_coefficients the_unit the_task the_table the_scale the_gains the_clamp_shares the_limits = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

(* The text limits u just where the task has u_max, and to no more. *)
Lemma limits_checked : match limits_in the_toml with Some u_max => limits_within the_limits u_max | None => false end = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

Notation number := (binary_float (precision Single) (largest_exponent Single)).

(* Theorem 1: `control` ends, and its inputs act as the law. *)
Theorem controller : forall (log_ : number -> number), accurate (precision Single) (largest_exponent Single) log_ ->
  let A := machine (precision Single) (largest_exponent Single) (Edge.precision_pos_instance Single) (Edge.precision_below_instance Single) log_ in
  forall (t : number) (x : nat -> number),
  is_finite t = true -> (forall i, (i < 2)%nat -> is_finite (x i) = true) ->
  (forall i, (i < 2)%nat -> (Rabs (B2R (x i)) <= 1073741824)%R) ->
  forall tau, clock_shows Single (B2R t) tau ->
  let L i := EmittedTube.emitted_edge Single the_unit the_table the_scale fst i (B2R t) in
  let U i := EmittedTube.emitted_edge Single the_unit the_table the_scale snd i (B2R t) in
  exists program out status,
    option_map relevant_part (read_source (literal_suffix Single) "omni_s1"%string the_text) = Some program /\
    execute A (log_name the_constants) program "@control" [@RealValue A t] (caller_arrays A the_constants (fun i => x (Z.to_nat i))) = Some (out, Some (IntValue status)) /\
    (status = 0%Z <-> forall i, (i < 2)%nat -> (L i < B2R (x i) < U i)%R) /\ (status = 0 \/ status = 1)%Z /\
    forall i, (i < 2)%nat -> exists v : number, last_stored (A := A) "u" (Z.of_nat i) out = Some v /\ is_finite v = true /\
      HeldInputLaw.acts_as_law (Q2R (nth i the_gains 0%Q)) (Q2R (nth i the_clamp_shares 0%Q)) (Q2R (32 * half_ulp Single)) (option_map Q2R (nth i the_limits None)) (B2R (x i) - L i) (U i - B2R (x i)) (B2R v).
Proof.
  intros log_ accurate A t x Ft Fx Sx tau Rt L U.
  destruct (control_runs_as_law Single the_constants the_coefficients (expected_directives the_constants "omni_s1"%string) the_unit the_error the_search the_task the_table the_step_maxima the_scale the_time_error
    the_gains the_clamp_shares the_limits tube_checked slopes_checked rounding_checked constants_checked log_ (fun _ => accurate) x Fx Sx t Ft tau Rt) as (out & status & H).
  exists the_program, out, status. split; [exact text_read|exact H].
Qed.

(* Theorem 2: the edges have P1 to P5. *)
Definition tube := emitted_tube_sound Single the_unit the_error the_search the_task the_table the_step_maxima the_scale the_time_error tube_checked slopes_checked rounding_checked.


(* The conditions on samples, sensors and plant: an example, for the task has no period: period, latency, share, noise; then by component bounds on |f|, on g_ii from below and above, and on |g_ij|. *)
Definition the_conditions : conditions := (Conditions (1 # 1000) (0 # 1) (19 # 20) (1 # 1048576) [(1 # 20); (1 # 20)] [(1 # 1); (1 # 1)] [(1 # 1); (1 # 1)] [(0 # 1); (0 # 1)])%Q.
(* Chosen, and checked: |e| stays at most (rho - 1)/(rho + 1); bounds on the error of a distance that the law measures. *)
Definition the_rhos : list Q := [(39 # 1); (39 # 1)]%Q.
Definition the_shifts : list Q := [(149 # 16777216); (149 # 16777216)]%Q.
(* The sampled loop that `period_check` decides about. *)
Definition the_sampling : sampling := sampling_of 2 the_conditions (law_loss Single the_constants) the_gains the_clamp_shares the_limits the_rhos the_shifts.
(* By window and component a bound on |u| and one on the logarithm in it; they are checked. *)
Definition the_hints : list (list (Q * Q)) := [
  [((1294644935 # 8388608), (3842323 # 1048576)); ((642610395 # 4194304), (61477077 # 16777216))];
  [((1328746523 # 8388608), (30738749 # 8388608)); ((1309043197 # 8388608), (15369327 # 4194304))];
  [((2729386485 # 16777216), (61477847 # 16777216)); ((2667536171 # 16777216), (61477547 # 16777216))];
  [((2805277901 # 16777216), (30739107 # 8388608)); ((2718906707 # 16777216), (15369449 # 4194304))];
  [((2871821123 # 16777216), (7684817 # 2097152)); ((2772277175 # 16777216), (30739027 # 8388608))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((353471599 # 2097152), (61478323 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((1437862667 # 8388608), (61478555 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))];
  [((2885510437 # 16777216), (61478603 # 16777216)); ((2885510437 # 16777216), (61478603 # 16777216))]]%Q.
(* P9, window by window. *)
Lemma period_checked : period_check the_unit the_task the_table the_sampling the_hints 1 the_error = true.
Proof. vm_cast_no_check (eq_refl true). Qed.
(* These bounds include the error of a measured state. *)
Lemma sensors_checked : at_most_all (sensor_error Single the_task the_conditions + the_error) (map component_distance_error (components the_sampling)) = true.
Proof. vm_cast_no_check (eq_refl true). Qed.

(* Theorem 3: the closed loop. Input p is what `control` of the text stores, called at clock p with the state measured at time `sampled_at p`. It acts from
   `acts_from p` to `acts_from (p + 1)`. *)
Theorem closed_loop_example : forall (log_ : number -> number), accurate (precision Single) (largest_exponent Single) log_ ->
  forall (sampled_at acts_from : nat -> R) (x push : nat -> R -> R) (G : nat -> nat -> R -> R) (clock : nat -> number) (measured : nat -> nat -> number) (program : source),
  option_map relevant_part (read_source (literal_suffix Single) "omni_s1"%string the_text) = Some program ->
  let L i t := Tube.lower the_unit the_task the_table i t in
  let U i t := Tube.upper the_unit the_task the_table i t in
  let input p i := applied_input Single log_ the_constants program (clock p) (measured p) i in
  (* times: the first input acts from 0 on; no sample is older than period + latency while its input acts, and an input acts at most the latency after its sample *)
  (acts_from 0%nat = 0 /\ forall p, 0 <= sampled_at p <= acts_from p /\ acts_from p < acts_from (S p) /\
    acts_from (S p) - sampled_at p <= Q2R (sampling_period the_conditions) + Q2R (input_delay the_conditions) /\ acts_from p - sampled_at p <= Q2R (input_delay the_conditions)) ->
  (forall p, is_finite (clock p) = true /\ clock_shows Single (B2R (clock p)) (sampled_at p)) ->
  (* sensors: the noise, and one rounding of the largest coordinate *)
  (forall p i, (i < 2)%nat -> is_finite (measured p i) = true /\ Rabs (B2R (measured p i)) <= 1073741824 /\
    Rabs (B2R (measured p i) - x i (sampled_at p)) <= Q2R (sensor_error Single the_task the_conditions)) ->
  (forall i t, (i < 2)%nat -> continuity_pt (x i) t) ->
  (* the start: |e| <= share *)
  (forall i, (i < 2)%nat -> Rabs (2 * x i 0 - L i 0 - U i 0) <= Q2R (start_share the_conditions) * (U i 0 - L i 0)) ->
  (* the plant *)
  (forall p t, acts_from p < t < acts_from (S p) -> (forall i, (i < 2)%nat -> L i t < x i t < U i t) -> forall i, (i < 2)%nat ->
    is_derive (x i) t (push i t + total 2 (fun j => G i j t * input p j)) /\
    Rabs (push i t) <= real_at (forces_max the_conditions) i /\ real_at (diagonal_gains_min the_conditions) i <= G i i t <= real_at (diagonal_gains_max the_conditions) i /\
    forall j, (j < 2)%nat -> j <> i -> Rabs (G i j t) <= real_at (cross_gains_max the_conditions) i) ->
  forall p t, 0 <= t <= acts_from p ->
    (forall i, (i < 2)%nat -> Rabs (2 * x i t - L i t - U i t) <= (real_at the_rhos i - 1) / (real_at the_rhos i + 1) * (U i t - L i t)) /\
    in_space the_task (fun i => x i t) /\
    (forall o, In o (unsafe_sets the_task) -> clear 2 (Q2R (clearance the_task)) o (fun i => x i t)) /\
    (Q2R (Tube.t_c the_task) <= t -> in_target the_task (fun i => x i t)).
Proof.
  intros log_ accurate sampled_at acts_from x push G clock measured program Text L U input Times Clock Sensors Continuous Start Plant.
  rewrite text_read in Text. injection Text as <-.
  exact (controller_sound Single the_constants the_coefficients (expected_directives the_constants "omni_s1"%string) the_unit the_error the_search the_task the_table the_step_maxima the_scale the_time_error
    the_gains the_clamp_shares the_limits the_conditions the_rhos the_shifts the_hints 1 tube_checked slopes_checked rounding_checked constants_checked period_checked sensors_checked
    log_ (fun _ => accurate) sampled_at acts_from x push G measured Times Sensors Continuous Start clock Clock Plant).
Qed.

Definition theorems := (task_read, header_read, text_read, limits_checked, controller, tube, closed_loop_example).
Print Assumptions theorems.
