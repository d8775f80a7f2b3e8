/* trolley.h: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (trolley.certificate.json): for every t the tube keeps 0.05 from every
 * unsafe set, stays in the state space, is at least 0.2 wide, and ends in the target set.
 * The state stays in it (P9) sampled every 0.02 s or faster, from every start with |e(0)| <= 0.9, for |f +
 * w| <= 0.15, 0.9 <= g_ii <= 1.1, |g_ij| <= 0.05, x measured to 0.002, u acts at most 0.002 s after its sample:
 * |e| < [0.9117, 0.9138], |u| <= 2.
 *
 * Call trolley_control once every period with the time since the start and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef TROLLEY_H
#define TROLLEY_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef float trolley_real;

#define TROLLEY_N 2
#define TROLLEY_T_C 8.0F /* prescribed time, seconds */
#define TROLLEY_PERIOD_PROVED 0.02F /* seconds between samples, at most: from which starts, see above (P9) */
#define TROLLEY_SHARE 0.9F /* 0.9 of the half widths at t = 0, rounded down: for trolley_covered */
#define TROLLEY_DESIGN_HASH "5ebd1be7025bd9ea" /* log it: names this design */

typedef enum {
    TROLLEY_OK = 0,
    TROLLEY_OUTSIDE_TUBE = 1,
    TROLLEY_BAD_INPUT = 2
} trolley_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void trolley_tube(trolley_real t, trolley_real lower[TROLLEY_N], trolley_real upper[TROLLEY_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void trolley_tube_rate(trolley_real t, trolley_real lower_rate[TROLLEY_N], trolley_real upper_rate[TROLLEY_N]);

/* Control law (13), u = -k xi epsilon, k = [0.0384, 0.0252], e clamped to [-0.99, 0.99] by component, u saturated.
 * t: seconds since the start (held within [0, t_c]); x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
trolley_status trolley_control(trolley_real t, const trolley_real x[TROLLEY_N], trolley_real u[TROLLEY_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
trolley_real trolley_margin(trolley_real t, const trolley_real x[TROLLEY_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void trolley_margins(trolley_real t, const trolley_real x[TROLLEY_N], trolley_real margin[TROLLEY_N]);

/* Whether the proof of the sampling period (P9) covers a start at the measured x:
 * every component of x is within 0.9 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool trolley_covered(const trolley_real x[TROLLEY_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void trolley_transform(const trolley_real lower[TROLLEY_N], const trolley_real upper[TROLLEY_N],
                       const trolley_real x[TROLLEY_N], trolley_real e[TROLLEY_N],
                       trolley_real epsilon[TROLLEY_N], trolley_real xi[TROLLEY_N]);

#ifdef __cplusplus
}
#endif

#endif
