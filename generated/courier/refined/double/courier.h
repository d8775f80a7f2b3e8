/* courier.h: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (courier.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * Every x(t) that stays in the tube satisfies the mission (P10): (eventually[4, 9] (always[0, 2] dock and
 * eventually[2, 12] (left or right)) and (not lab until[0, 24] dock) and always[0, 12] (not dock or eventually[0, 8]
 * charger)); times are seconds of t. It still holds where every time at which the tube is in a region, or off one, is
 * wrong by up to 0.00585 s.
 *
 * Call courier_control once every period with the time since the start and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef COURIER_H
#define COURIER_H

#include <stdbool.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef double courier_real;

#define COURIER_N 2
#define COURIER_T_C 24.0 /* prescribed time, seconds; t = 0 is when the mission begins */
#define COURIER_SHARE 0.99 /* 0.99 of the half widths at t = 0, rounded down: for courier_covered */
#define COURIER_DESIGN_HASH "7fb5858d3aa4bbc2" /* log it: names this design */

typedef enum {
    COURIER_OK = 0,
    COURIER_OUTSIDE_TUBE = 1,
    COURIER_BAD_INPUT = 2
} courier_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void courier_tube(courier_real t, courier_real lower[COURIER_N], courier_real upper[COURIER_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void courier_tube_rate(courier_real t, courier_real lower_rate[COURIER_N], courier_real upper_rate[COURIER_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * t: seconds since the start (held within [0, t_c]); x: state; u: input.
 * x by component: x [m], y [m].
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
courier_status courier_control(courier_real t, const courier_real x[COURIER_N], courier_real u[COURIER_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
courier_real courier_margin(courier_real t, const courier_real x[COURIER_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void courier_margins(courier_real t, const courier_real x[COURIER_N], courier_real margin[COURIER_N]);

/* Whether the paper's Theorem 4.1, in continuous time, covers a start at the measured x:
 * every component of x is within 0.99 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool courier_covered(const courier_real x[COURIER_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void courier_transform(const courier_real lower[COURIER_N], const courier_real upper[COURIER_N],
                       const courier_real x[COURIER_N], courier_real e[COURIER_N],
                       courier_real epsilon[COURIER_N], courier_real xi[COURIER_N]);

/* In courier_phase.c: which entry of the mission is being served at time t, from 1; 0 once all are done.
 * 1 visit dock then exit: dock from 7.5 to 9.773 s; left from 16.87 to 16.94 s
 * 2 never lab before dock: dock from 7.5 to 9.773 s
 * 3 always[0, 12] (dock -> eventually[0, 8] charger): charger from 13.12 to 13.13 s
 */
int courier_phase(courier_real t);

#ifdef __cplusplus
}
#endif

#endif
