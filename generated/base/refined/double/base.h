/* base.h: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (base.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled every 0.02 s or faster, from every start with |e(0)| <= 0.8 at rest, for |f +
 * w| <= [0.5, 0.53, 0.4], 0.85 <= g_ii <= 1.18, |g_ij| <= [0.05, 0.05, 0], x measured to 0.003, u acts at most 0.002
 * s after its sample, v measured to 0.01: |e| of v + lambda x < [0.8745, 0.8849, 0.8661], |u| <= [2.1, 2.5, 1.1].
 *
 * Call base_control once every period with the time since the start and the measured x and v. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef BASE_H
#define BASE_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef double base_real;

#define BASE_N 3
#define BASE_T_C 25.0 /* prescribed time, seconds */
#define BASE_PERIOD_PROVED 0.019999999999999997 /* seconds between samples, at most: from which starts, see above (P9) */
#define BASE_SHARE 0.7999999999999999 /* 0.8 of the half widths at t = 0, rounded down: for base_covered */
#define BASE_DESIGN_HASH "ed7a2b9b8a866850" /* log it: names this design */

typedef enum {
    BASE_OK = 0,
    BASE_OUTSIDE_TUBE = 1,
    BASE_BAD_INPUT = 2
} base_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void base_tube(base_real t, base_real lower[BASE_N], base_real upper[BASE_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void base_tube_rate(base_real t, base_real lower_rate[BASE_N], base_real upper_rate[BASE_N]);

/* Edges of the filtered tube at time t, in units per second: of v + lambda x, lambda = [1.4306640625, 1.359375, 1.009765625].
 * While v + lambda x is between them, x stays in the tube. NaN when t is not finite.
 */
void base_filtered_tube(base_real t, base_real lower[BASE_N], base_real upper[BASE_N]);

/* Control law (13), u = -k xi epsilon, k = [0.0927, 0.144, 0.0285], e clamped to [-0.99, 0.99] by component, u saturated.
 * for v + lambda x in its tube, lambda = [1.4306640625, 1.359375, 1.009765625]. t: seconds since the start (held within [0, t_c]);
 * x: state; v: its rate; u: input.
 * x by component: x [m], y [m], heading [rad].
 * OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law,
 * finite, and points inward (0 where the tube is empty). BAD_INPUT: t, x or v has a NaN or an
 * infinity; u is 0. u may be the array x or v itself.
 */
base_status base_control(base_real t, const base_real x[BASE_N], const base_real v[BASE_N], base_real u[BASE_N]);

/* How far x is from leaving the tube, and v + lambda x from leaving its own: the distance to the nearest edge
 * over the width there, the lesser of both, least over the components. 0.5 in the middle, positive inside,
 * negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
base_real base_margin(base_real t, const base_real x[BASE_N], const base_real v[BASE_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void base_margins(base_real t, const base_real x[BASE_N], const base_real v[BASE_N], base_real margin[BASE_N]);

/* Whether the proof of the sampling period (P9) covers a start at the measured x and v:
 * every component of x is within 0.8 of the tube's half width about its middle at t = 0,
 * and v + lambda x is in its own tube, no farther from the middle than from such an x at rest.
 * What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool base_covered(const base_real x[BASE_N], const base_real v[BASE_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void base_transform(const base_real lower[BASE_N], const base_real upper[BASE_N], const base_real x[BASE_N],
                    base_real e[BASE_N], base_real epsilon[BASE_N], base_real xi[BASE_N]);

#ifdef __cplusplus
}
#endif

#endif
