/* omni_s1.h: prescribed-time reach-avoid-stay controller, literal tube, single precision.
 *
 * *** NOT CERTIFIED *** NOT CERTIFIED *** NOT CERTIFIED ***
 * This controller was written with --uncertified. Do not run it on a machine. What fails:
 *   P4 avoid at t in [2.95875, 2.961] s, unsafe set O1
 *   P5 reach at t = 9 s, dimension 2
 *
 * At the start call omni_s1_alpha_init(alpha). Then once every period, with t the time since the start: first
 * omni_s1_control(t, alpha, x, u), then omni_s1_alpha_step(t, period, alpha). alpha is yours and the only state;
 * do not let two threads step the same one. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef OMNI_S1_H
#define OMNI_S1_H

#ifdef __cplusplus
extern "C" {
#endif

typedef float omni_s1_real;

#define OMNI_S1_N 2
#define OMNI_S1_T_C 9.0F /* prescribed time, seconds */
#define OMNI_S1_DESIGN_HASH "0b56835935158ebe" /* log it: names this design */

typedef enum {
    OMNI_S1_OK = 0,
    OMNI_S1_OUTSIDE_TUBE = 1,
    OMNI_S1_BAD_INPUT = 2
} omni_s1_status;

/* Start of the update function: alpha(0) = 0 (11). alpha = [alpha_L by dimension, alpha_U by dimension]. */
void omni_s1_alpha_init(omni_s1_real alpha[2 * OMNI_S1_N]);

/* One implicit (backward Euler) step of (11) from t to t + dt seconds; fixed cost, stable for every dt > 0. The new
 * alpha replaces the given one (C) or is returned (Python); it is the given one when dt <= 0 or a number is not finite.
 * Call it once after each control step. A late start begins at t = 0 too: alpha_init, then such steps up to that t.
 */
void omni_s1_alpha_step(omni_s1_real t, omni_s1_real dt, omni_s1_real alpha[2 * OMNI_S1_N]);

/* Right side of the update equation (11) and its Jacobian d rate / d alpha (diagonal), laid out as alpha.
 * For a solver of your own; `alpha_step` needs neither. NaN when a number is not finite.
 */
void omni_s1_alpha_rate(omni_s1_real t, const omni_s1_real alpha[2 * OMNI_S1_N],
                        omni_s1_real rate[2 * OMNI_S1_N], omni_s1_real jacobian[2 * OMNI_S1_N]);

/* Edges of the tube gamma (10) at time t (seconds) for the update function alpha, in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t or alpha is not finite.
 */
void omni_s1_tube(omni_s1_real t, const omni_s1_real alpha[2 * OMNI_S1_N], omni_s1_real lower[OMNI_S1_N],
                  omni_s1_real upper[OMNI_S1_N]);

/* Total rate of the edges, d gamma / d t along (11), at time t (seconds), in units per second.
 * Before 0 the rate at 0; from t_c on only alpha moves. NaN when t or alpha is not finite.
 */
void omni_s1_tube_rate(omni_s1_real t, const omni_s1_real alpha[2 * OMNI_S1_N],
                       omni_s1_real lower_rate[OMNI_S1_N], omni_s1_real upper_rate[OMNI_S1_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * t: seconds since the start (held within [0, t_c]); alpha: the update function at t; x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t, alpha or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
omni_s1_status omni_s1_control(omni_s1_real t, const omni_s1_real alpha[2 * OMNI_S1_N],
                               const omni_s1_real x[OMNI_S1_N], omni_s1_real u[OMNI_S1_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
omni_s1_real omni_s1_margin(omni_s1_real t, const omni_s1_real alpha[2 * OMNI_S1_N],
                            const omni_s1_real x[OMNI_S1_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void omni_s1_margins(omni_s1_real t, const omni_s1_real alpha[2 * OMNI_S1_N], const omni_s1_real x[OMNI_S1_N],
                     omni_s1_real margin[OMNI_S1_N]);

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
