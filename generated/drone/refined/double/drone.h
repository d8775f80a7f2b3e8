/* drone.h: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (drone.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.025 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= 0.35, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 0.005, u acts at most 0.004 s after its sample, v
 * measured to 0.02: |e| of v + lambda x < [0.9343, 0.9343, 0.9374], |u| <= 2.5.
 *
 * Call drone_control once every period with the time since the start and the measured x and v. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef DRONE_H
#define DRONE_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef double drone_real;

#define DRONE_N 3
#define DRONE_T_C 12.0 /* prescribed time, seconds */
#define DRONE_PERIOD_PROVED 0.024999999999999998 /* seconds between samples, at most: from which starts, see above (P9) */
#define DRONE_SHARE 0.7999999999999999 /* 0.8 of the half widths at t = 0, rounded down: for drone_covered */
#define DRONE_DESIGN_HASH "27c2ed83cf677421" /* log it: names this design */

typedef enum {
    DRONE_OK = 0,
    DRONE_OUTSIDE_TUBE = 1,
    DRONE_BAD_INPUT = 2
} drone_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void drone_tube(drone_real t, drone_real lower[DRONE_N], drone_real upper[DRONE_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void drone_tube_rate(drone_real t, drone_real lower_rate[DRONE_N], drone_real upper_rate[DRONE_N]);

/* Edges of the filtered tube at time t, in units per second: of v + lambda x, lambda = [0.98046875, 0.98046875, 0.78564453125].
 * While v + lambda x is between them, x stays in the tube. NaN when t is not finite.
 */
void drone_filtered_tube(drone_real t, drone_real lower[DRONE_N], drone_real upper[DRONE_N]);

/* Control law (13), u = -k xi epsilon, k = [0.0525, 0.0525, 0.027], e clamped to [-0.99, 0.99] by component, u saturated.
 * for v + lambda x in its tube, lambda = [0.98046875, 0.98046875, 0.78564453125]. t: seconds since the start (held within [0, t_c]);
 * x: state; v: its rate; u: input.
 * x by component: x [m], y [m], z [m].
 * OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law,
 * finite, and points inward (0 where the tube is empty). BAD_INPUT: t, x or v has a NaN or an
 * infinity; u is 0. u may be the array x or v itself.
 */
drone_status drone_control(drone_real t, const drone_real x[DRONE_N], const drone_real v[DRONE_N],
                           drone_real u[DRONE_N]);

/* How far x is from leaving the tube, and v + lambda x from leaving its own: the distance to the nearest edge
 * over the width there, the lesser of both, least over the components. 0.5 in the middle, positive inside,
 * negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
drone_real drone_margin(drone_real t, const drone_real x[DRONE_N], const drone_real v[DRONE_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void drone_margins(drone_real t, const drone_real x[DRONE_N], const drone_real v[DRONE_N],
                   drone_real margin[DRONE_N]);

/* Whether the proof of the sampling period (P9) covers a start at the measured x and v:
 * every component of x is within 0.8 of the tube's half width about its middle at t = 0,
 * and v + lambda x is in its own tube, no farther from the middle than from such an x at rest.
 * What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool drone_covered(const drone_real x[DRONE_N], const drone_real v[DRONE_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void drone_transform(const drone_real lower[DRONE_N], const drone_real upper[DRONE_N],
                     const drone_real x[DRONE_N], drone_real e[DRONE_N], drone_real epsilon[DRONE_N],
                     drone_real xi[DRONE_N]);

#ifdef __cplusplus
}
#endif

#endif
