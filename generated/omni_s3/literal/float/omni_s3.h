/* omni_s3.h: prescribed-time reach-avoid-stay controller, literal tube, single precision.
 *
 * *** NOT CERTIFIED *** NOT CERTIFIED *** NOT CERTIFIED ***
 * This controller was written with --uncertified. Do not run it on a machine. What fails:
 *   P1 width at t = 1.6695 s, dimension 2
 *   P4 avoid at t in [1.67175, 1.674] s, unsafe set O4
 *   P5 reach at t = 9 s, dimension 1
 *
 * At the start call omni_s3_alpha_init(alpha). Then once every period, with t the time since the start: first
 * omni_s3_control(t, alpha, x, u), then omni_s3_alpha_step(t, period, alpha). alpha is yours and the only state;
 * do not let two threads step the same one. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef OMNI_S3_H
#define OMNI_S3_H

#ifdef __cplusplus
extern "C" {
#endif

typedef float omni_s3_real;

#define OMNI_S3_N 2
#define OMNI_S3_T_C 9.0F /* prescribed time, seconds */
#define OMNI_S3_DESIGN_HASH "cf57365fb103b5dc" /* log it: names this design */

typedef enum {
    OMNI_S3_OK = 0,
    OMNI_S3_OUTSIDE_TUBE = 1,
    OMNI_S3_BAD_INPUT = 2
} omni_s3_status;

/* Start of the update function: alpha(0) = 0 (11). alpha = [alpha_L by dimension, alpha_U by dimension]. */
void omni_s3_alpha_init(omni_s3_real alpha[2 * OMNI_S3_N]);

/* One implicit (backward Euler) step of (11) from t to t + dt seconds; fixed cost, stable for every dt > 0. The new
 * alpha replaces the given one (C) or is returned (Python); it is the given one when dt <= 0 or a number is not finite.
 * Call it once after each control step. A late start begins at t = 0 too: alpha_init, then such steps up to that t.
 */
void omni_s3_alpha_step(omni_s3_real t, omni_s3_real dt, omni_s3_real alpha[2 * OMNI_S3_N]);

/* Right side of the update equation (11) and its Jacobian d rate / d alpha (diagonal), laid out as alpha.
 * For a solver of your own; `alpha_step` needs neither. NaN when a number is not finite.
 */
void omni_s3_alpha_rate(omni_s3_real t, const omni_s3_real alpha[2 * OMNI_S3_N],
                        omni_s3_real rate[2 * OMNI_S3_N], omni_s3_real jacobian[2 * OMNI_S3_N]);

/* Edges of the tube gamma (10) at time t (seconds) for the update function alpha, in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t or alpha is not finite.
 */
void omni_s3_tube(omni_s3_real t, const omni_s3_real alpha[2 * OMNI_S3_N], omni_s3_real lower[OMNI_S3_N],
                  omni_s3_real upper[OMNI_S3_N]);

/* Total rate of the edges, d gamma / d t along (11), at time t (seconds), in units per second.
 * Before 0 the rate at 0; from t_c on only alpha moves. NaN when t or alpha is not finite.
 */
void omni_s3_tube_rate(omni_s3_real t, const omni_s3_real alpha[2 * OMNI_S3_N],
                       omni_s3_real lower_rate[OMNI_S3_N], omni_s3_real upper_rate[OMNI_S3_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * t: seconds since the start (held within [0, t_c]); alpha: the update function at t; x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t, alpha or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
omni_s3_status omni_s3_control(omni_s3_real t, const omni_s3_real alpha[2 * OMNI_S3_N],
                               const omni_s3_real x[OMNI_S3_N], omni_s3_real u[OMNI_S3_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
omni_s3_real omni_s3_margin(omni_s3_real t, const omni_s3_real alpha[2 * OMNI_S3_N],
                            const omni_s3_real x[OMNI_S3_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void omni_s3_margins(omni_s3_real t, const omni_s3_real alpha[2 * OMNI_S3_N], const omni_s3_real x[OMNI_S3_N],
                     omni_s3_real margin[OMNI_S3_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void omni_s3_transform(const omni_s3_real lower[OMNI_S3_N], const omni_s3_real upper[OMNI_S3_N],
                       const omni_s3_real x[OMNI_S3_N], omni_s3_real e[OMNI_S3_N],
                       omni_s3_real epsilon[OMNI_S3_N], omni_s3_real xi[OMNI_S3_N]);

#ifdef __cplusplus
}
#endif

#endif
