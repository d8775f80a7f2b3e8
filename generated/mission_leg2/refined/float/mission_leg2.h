/* mission_leg2.h: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (mission_leg2.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * Call mission_leg2_control once every period with the time since the start and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef MISSION_LEG2_H
#define MISSION_LEG2_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef float mission_leg2_real;

#define MISSION_LEG2_N 2
#define MISSION_LEG2_T_C 3.0F /* prescribed time, seconds */
#define MISSION_LEG2_SHARE 0.98999995F /* 0.99 of the half widths at t = 0, rounded down: for mission_leg2_covered */
#define MISSION_LEG2_DESIGN_HASH "f1effa867ee9fab9" /* log it: names this design */

typedef enum {
    MISSION_LEG2_OK = 0,
    MISSION_LEG2_OUTSIDE_TUBE = 1,
    MISSION_LEG2_BAD_INPUT = 2
} mission_leg2_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void mission_leg2_tube(mission_leg2_real t, mission_leg2_real lower[MISSION_LEG2_N],
                       mission_leg2_real upper[MISSION_LEG2_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void mission_leg2_tube_rate(mission_leg2_real t, mission_leg2_real lower_rate[MISSION_LEG2_N],
                            mission_leg2_real upper_rate[MISSION_LEG2_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * t: seconds since the start (held within [0, t_c]); x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
mission_leg2_status mission_leg2_control(mission_leg2_real t, const mission_leg2_real x[MISSION_LEG2_N],
                                         mission_leg2_real u[MISSION_LEG2_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
mission_leg2_real mission_leg2_margin(mission_leg2_real t, const mission_leg2_real x[MISSION_LEG2_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void mission_leg2_margins(mission_leg2_real t, const mission_leg2_real x[MISSION_LEG2_N],
                          mission_leg2_real margin[MISSION_LEG2_N]);

/* Whether the paper's Theorem 4.1, in continuous time, covers a start at the measured x:
 * every component of x is within 0.99 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool mission_leg2_covered(const mission_leg2_real x[MISSION_LEG2_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void mission_leg2_transform(const mission_leg2_real lower[MISSION_LEG2_N],
                            const mission_leg2_real upper[MISSION_LEG2_N],
                            const mission_leg2_real x[MISSION_LEG2_N], mission_leg2_real e[MISSION_LEG2_N],
                            mission_leg2_real epsilon[MISSION_LEG2_N], mission_leg2_real xi[MISSION_LEG2_N]);

#ifdef __cplusplus
}
#endif

#endif
