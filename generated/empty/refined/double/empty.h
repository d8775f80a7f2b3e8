/* empty.h: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (empty.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * Call empty_control once every period with the time since the start and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef EMPTY_H
#define EMPTY_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef double empty_real;

#define EMPTY_N 2
#define EMPTY_T_C 4.0 /* prescribed time, seconds */
#define EMPTY_SHARE 0.99 /* 0.99 of the half widths at t = 0, rounded down: for empty_covered */
#define EMPTY_DESIGN_HASH "8d92b6e277885e91" /* log it: names this design */

typedef enum {
    EMPTY_OK = 0,
    EMPTY_OUTSIDE_TUBE = 1,
    EMPTY_BAD_INPUT = 2
} empty_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void empty_tube(empty_real t, empty_real lower[EMPTY_N], empty_real upper[EMPTY_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void empty_tube_rate(empty_real t, empty_real lower_rate[EMPTY_N], empty_real upper_rate[EMPTY_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * t: seconds since the start (held within [0, t_c]); x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
empty_status empty_control(empty_real t, const empty_real x[EMPTY_N], empty_real u[EMPTY_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
empty_real empty_margin(empty_real t, const empty_real x[EMPTY_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void empty_margins(empty_real t, const empty_real x[EMPTY_N], empty_real margin[EMPTY_N]);

/* Whether the paper's Theorem 4.1, in continuous time, covers a start at the measured x:
 * every component of x is within 0.99 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool empty_covered(const empty_real x[EMPTY_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void empty_transform(const empty_real lower[EMPTY_N], const empty_real upper[EMPTY_N],
                     const empty_real x[EMPTY_N], empty_real e[EMPTY_N], empty_real epsilon[EMPTY_N],
                     empty_real xi[EMPTY_N]);

#ifdef __cplusplus
}
#endif

#endif
