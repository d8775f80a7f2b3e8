/* rover.h: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (rover.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The state stays in it (P9) sampled every 0.02 s or faster, from every start with |e(0)| <= 0.9, for |f + w| <= 0.1,
 * 0.99 <= g_ii <= 1.01, |g_ij| <= 0.1, x measured to 0.005, u acts at most 0.002 s after its sample: |e| < [0.9119,
 * 0.9105], |u| <= 0.8.
 *
 * Call rover_control once every period with the time since the start and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef ROVER_H
#define ROVER_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef float rover_real;

#define ROVER_N 2
#define ROVER_T_C 20.0F /* prescribed time, seconds */
#define ROVER_PERIOD_PROVED 0.02F /* seconds between samples, at most: from which starts, see above (P9) */
#define ROVER_SHARE 0.9F /* 0.9 of the half widths at t = 0, rounded down: for rover_covered */
#define ROVER_DESIGN_HASH "fd3d315be19c6b65" /* log it: names this design */

typedef enum {
    ROVER_OK = 0,
    ROVER_OUTSIDE_TUBE = 1,
    ROVER_BAD_INPUT = 2
} rover_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void rover_tube(rover_real t, rover_real lower[ROVER_N], rover_real upper[ROVER_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void rover_tube_rate(rover_real t, rover_real lower_rate[ROVER_N], rover_real upper_rate[ROVER_N]);

/* Control law (13), u = -k xi epsilon, k = [0.0109, 0.0155], e clamped to [-0.99, 0.99] by component, u saturated.
 * t: seconds since the start (held within [0, t_c]); x: state; u: input.
 * x by component: x [m], y [m].
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
rover_status rover_control(rover_real t, const rover_real x[ROVER_N], rover_real u[ROVER_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
rover_real rover_margin(rover_real t, const rover_real x[ROVER_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void rover_margins(rover_real t, const rover_real x[ROVER_N], rover_real margin[ROVER_N]);

/* Whether the proof of the sampling period (P9) covers a start at the measured x:
 * every component of x is within 0.9 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool rover_covered(const rover_real x[ROVER_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void rover_transform(const rover_real lower[ROVER_N], const rover_real upper[ROVER_N],
                     const rover_real x[ROVER_N], rover_real e[ROVER_N], rover_real epsilon[ROVER_N],
                     rover_real xi[ROVER_N]);

#ifdef __cplusplus
}
#endif

#endif
