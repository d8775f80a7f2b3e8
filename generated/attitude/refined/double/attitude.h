/* attitude.h: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (attitude.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.06 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= [0.045, 0.03, 0.04], 0.91 <= g_ii <= 1.09, |g_ij| <= [0.1, 0.03, 0.035], x measured to 0.0005, v measured to
 * 0.0005: |e| of v + lambda x < [0.9021, 0.84, 0.8665], |u| <= [0.09, 0.06, 0.08].
 *
 * Call attitude_control once every period with the time since the start and the measured x and v. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef ATTITUDE_H
#define ATTITUDE_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef double attitude_real;

#define ATTITUDE_N 3
#define ATTITUDE_T_C 60.0 /* prescribed time, seconds */
#define ATTITUDE_PERIOD_PROVED 0.06 /* seconds between samples, at most: from which starts, see above (P9) */
#define ATTITUDE_SHARE 0.7999999999999999 /* 0.8 of the half widths at t = 0, rounded down: for attitude_covered */
#define ATTITUDE_DESIGN_HASH "7958079c380280a3" /* log it: names this design */

typedef enum {
    ATTITUDE_OK = 0,
    ATTITUDE_OUTSIDE_TUBE = 1,
    ATTITUDE_BAD_INPUT = 2
} attitude_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void attitude_tube(attitude_real t, attitude_real lower[ATTITUDE_N], attitude_real upper[ATTITUDE_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void attitude_tube_rate(attitude_real t, attitude_real lower_rate[ATTITUDE_N],
                        attitude_real upper_rate[ATTITUDE_N]);

/* Edges of the filtered tube at time t, in units per second: of v + lambda x, lambda = 0.12.
 * While v + lambda x is between them, x stays in the tube. NaN when t is not finite.
 */
void attitude_filtered_tube(attitude_real t, attitude_real lower[ATTITUDE_N], attitude_real upper[ATTITUDE_N]);

/* Control law (13), u = -k xi epsilon, k = [0.00012, 7.8e-05, 9.77e-05], e clamped to [-0.99, 0.99] by component, u saturated.
 * for v + lambda x in its tube, lambda = 0.12. t: seconds since the start (held within [0, t_c]);
 * x: state; v: its rate; u: input.
 * x by component: roll [rad], pitch [rad], yaw [rad].
 * OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law,
 * finite, and points inward (0 where the tube is empty). BAD_INPUT: t, x or v has a NaN or an
 * infinity; u is 0. u may be the array x or v itself.
 */
attitude_status attitude_control(attitude_real t, const attitude_real x[ATTITUDE_N],
                                 const attitude_real v[ATTITUDE_N], attitude_real u[ATTITUDE_N]);

/* How far x is from leaving the tube, and v + lambda x from leaving its own: the distance to the nearest edge
 * over the width there, the lesser of both, least over the components. 0.5 in the middle, positive inside,
 * negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
attitude_real attitude_margin(attitude_real t, const attitude_real x[ATTITUDE_N],
                              const attitude_real v[ATTITUDE_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void attitude_margins(attitude_real t, const attitude_real x[ATTITUDE_N], const attitude_real v[ATTITUDE_N],
                      attitude_real margin[ATTITUDE_N]);

/* Whether the proof of the sampling period (P9) covers a start at the measured x and v:
 * every component of x is within 0.8 of the tube's half width about its middle at t = 0,
 * and v + lambda x is in its own tube, no farther from the middle than from such an x at rest.
 * What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool attitude_covered(const attitude_real x[ATTITUDE_N], const attitude_real v[ATTITUDE_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void attitude_transform(const attitude_real lower[ATTITUDE_N], const attitude_real upper[ATTITUDE_N],
                        const attitude_real x[ATTITUDE_N], attitude_real e[ATTITUDE_N],
                        attitude_real epsilon[ATTITUDE_N], attitude_real xi[ATTITUDE_N]);

#ifdef __cplusplus
}
#endif

#endif
