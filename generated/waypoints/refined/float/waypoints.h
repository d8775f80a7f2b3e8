/* waypoints.h: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (waypoints.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and carries out the mission.
 * Every x(t) that stays in the tube satisfies the mission (P10): (always[0, 1] home and always[3, 4] left and
 * always[6, 7] right and always[9, 10] left and always[12, 13] right and always[17, 18] goal); times are seconds of
 * t. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.0326 s.
 *
 * Call waypoints_control once every period with the time since the start and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef WAYPOINTS_H
#define WAYPOINTS_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef float waypoints_real;

#define WAYPOINTS_N 2
#define WAYPOINTS_T_C 18.0F /* prescribed time, seconds; t = 0 is when the mission begins */
#define WAYPOINTS_SHARE 0.98999995F /* 0.99 of the half widths at t = 0, rounded down: for waypoints_covered */
#define WAYPOINTS_DESIGN_HASH "27bf76fd458edffa" /* log it: names this design */

typedef enum {
    WAYPOINTS_OK = 0,
    WAYPOINTS_OUTSIDE_TUBE = 1,
    WAYPOINTS_BAD_INPUT = 2
} waypoints_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void waypoints_tube(waypoints_real t, waypoints_real lower[WAYPOINTS_N], waypoints_real upper[WAYPOINTS_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void waypoints_tube_rate(waypoints_real t, waypoints_real lower_rate[WAYPOINTS_N],
                         waypoints_real upper_rate[WAYPOINTS_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * t: seconds since the start (held within [0, t_c]); x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
waypoints_status waypoints_control(waypoints_real t, const waypoints_real x[WAYPOINTS_N],
                                   waypoints_real u[WAYPOINTS_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
waypoints_real waypoints_margin(waypoints_real t, const waypoints_real x[WAYPOINTS_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void waypoints_margins(waypoints_real t, const waypoints_real x[WAYPOINTS_N],
                       waypoints_real margin[WAYPOINTS_N]);

/* Whether the paper's Theorem 4.1, in continuous time, covers a start at the measured x:
 * every component of x is within 0.99 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool waypoints_covered(const waypoints_real x[WAYPOINTS_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void waypoints_transform(const waypoints_real lower[WAYPOINTS_N], const waypoints_real upper[WAYPOINTS_N],
                         const waypoints_real x[WAYPOINTS_N], waypoints_real e[WAYPOINTS_N],
                         waypoints_real epsilon[WAYPOINTS_N], waypoints_real xi[WAYPOINTS_N]);

/* In waypoints_phase.c: which entry of the mission is being served at time t, from 1; 0 once all are done.
 * 1 always[0, 1] home and always[3, 4] left and always[6, 7] right: home from the start to 1.032 s; left from 2.905
 *   to 4.032 s; right from 5.905 to 7.032 s
 * 2 always[9, 10] left and always[12, 13] right and always[17, 18] goal: left from 8.901 to 10.03 s; right from 11.16
 *   to 13.87 s; goal from 16.13 on
 */
int waypoints_phase(waypoints_real t);

#ifdef __cplusplus
}
#endif

#endif
