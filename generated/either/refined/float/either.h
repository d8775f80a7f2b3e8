/* either.h: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (either.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * Every x(t) that stays in the tube satisfies the mission (P10): eventually[8, 9.5] (T1 or T2); times are seconds of
 * t. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.158 s.
 *
 * Call either_control once every period with the time since the start and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef EITHER_H
#define EITHER_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef float either_real;

#define EITHER_N 2
#define EITHER_T_C 18.0F /* prescribed time, seconds; t = 0 is when the mission begins */
#define EITHER_SHARE 0.98999995F /* 0.99 of the half widths at t = 0, rounded down: for either_covered */
#define EITHER_DESIGN_HASH "10573e2c770750a3" /* log it: names this design */

typedef enum {
    EITHER_OK = 0,
    EITHER_OUTSIDE_TUBE = 1,
    EITHER_BAD_INPUT = 2
} either_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void either_tube(either_real t, either_real lower[EITHER_N], either_real upper[EITHER_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void either_tube_rate(either_real t, either_real lower_rate[EITHER_N], either_real upper_rate[EITHER_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * t: seconds since the start (held within [0, t_c]); x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
either_status either_control(either_real t, const either_real x[EITHER_N], either_real u[EITHER_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
either_real either_margin(either_real t, const either_real x[EITHER_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void either_margins(either_real t, const either_real x[EITHER_N], either_real margin[EITHER_N]);

/* Whether the paper's Theorem 4.1, in continuous time, covers a start at the measured x:
 * every component of x is within 0.99 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool either_covered(const either_real x[EITHER_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void either_transform(const either_real lower[EITHER_N], const either_real upper[EITHER_N],
                      const either_real x[EITHER_N], either_real e[EITHER_N], either_real epsilon[EITHER_N],
                      either_real xi[EITHER_N]);

/* In either_phase.c: which entry of the mission is being served at time t, from 1; 0 once all are done.
 * 1 visit T: T1 or T2 from 8.614 to 8.929 s
 */
int either_phase(either_real t);

#ifdef __cplusplus
}
#endif

#endif
