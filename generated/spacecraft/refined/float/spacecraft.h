/* spacecraft.h: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (spacecraft.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * Call spacecraft_control once every period with the time since the start and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef SPACECRAFT_H
#define SPACECRAFT_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef float spacecraft_real;

#define SPACECRAFT_N 3
#define SPACECRAFT_T_C 15.0F /* prescribed time, seconds */
#define SPACECRAFT_SHARE 0.98999995F /* 0.99 of the half widths at t = 0, rounded down: for spacecraft_covered */
#define SPACECRAFT_DESIGN_HASH "dc61a40ca017e859" /* log it: names this design */

typedef enum {
    SPACECRAFT_OK = 0,
    SPACECRAFT_OUTSIDE_TUBE = 1,
    SPACECRAFT_BAD_INPUT = 2
} spacecraft_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void spacecraft_tube(spacecraft_real t, spacecraft_real lower[SPACECRAFT_N],
                     spacecraft_real upper[SPACECRAFT_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void spacecraft_tube_rate(spacecraft_real t, spacecraft_real lower_rate[SPACECRAFT_N],
                          spacecraft_real upper_rate[SPACECRAFT_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * t: seconds since the start (held within [0, t_c]); x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
spacecraft_status spacecraft_control(spacecraft_real t, const spacecraft_real x[SPACECRAFT_N],
                                     spacecraft_real u[SPACECRAFT_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
spacecraft_real spacecraft_margin(spacecraft_real t, const spacecraft_real x[SPACECRAFT_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void spacecraft_margins(spacecraft_real t, const spacecraft_real x[SPACECRAFT_N],
                        spacecraft_real margin[SPACECRAFT_N]);

/* Whether the paper's Theorem 4.1, in continuous time, covers a start at the measured x:
 * every component of x is within 0.99 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool spacecraft_covered(const spacecraft_real x[SPACECRAFT_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void spacecraft_transform(const spacecraft_real lower[SPACECRAFT_N], const spacecraft_real upper[SPACECRAFT_N],
                          const spacecraft_real x[SPACECRAFT_N], spacecraft_real e[SPACECRAFT_N],
                          spacecraft_real epsilon[SPACECRAFT_N], spacecraft_real xi[SPACECRAFT_N]);

#ifdef __cplusplus
}
#endif

#endif
