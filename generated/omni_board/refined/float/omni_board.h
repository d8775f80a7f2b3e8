/* omni_board.h: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (omni_board.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 *
 * Call omni_board_control once every period with the time since the start and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef OMNI_BOARD_H
#define OMNI_BOARD_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef float omni_board_real;

#define OMNI_BOARD_N 2
#define OMNI_BOARD_T_C 9.0F /* prescribed time, seconds */
#define OMNI_BOARD_TICK_PERIOD 0.001F /* seconds of one tick of omni_board_control_tick */
#define OMNI_BOARD_TICKS 9000U /* the first tick that is not before t_c: count no farther */
#define OMNI_BOARD_SHARE 0.98999995F /* 0.99 of the half widths at t = 0, rounded down: for omni_board_covered */
#define OMNI_BOARD_DESIGN_HASH "23e458e2bad7f4ef" /* log it: names this design */

typedef enum {
    OMNI_BOARD_OK = 0,
    OMNI_BOARD_OUTSIDE_TUBE = 1,
    OMNI_BOARD_BAD_INPUT = 2
} omni_board_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void omni_board_tube(omni_board_real t, omni_board_real lower[OMNI_BOARD_N],
                     omni_board_real upper[OMNI_BOARD_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void omni_board_tube_rate(omni_board_real t, omni_board_real lower_rate[OMNI_BOARD_N],
                          omni_board_real upper_rate[OMNI_BOARD_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * t: seconds since the start (held within [0, t_c]); x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
omni_board_status omni_board_control(omni_board_real t, const omni_board_real x[OMNI_BOARD_N],
                                     omni_board_real u[OMNI_BOARD_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * tick: periods of 0.001 s since the start (it must not wrap to 0: stop counting at t_c); x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
omni_board_status omni_board_control_tick(uint32_t tick, const omni_board_real x[OMNI_BOARD_N],
                                          omni_board_real u[OMNI_BOARD_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
omni_board_real omni_board_margin(omni_board_real t, const omni_board_real x[OMNI_BOARD_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void omni_board_margins(omni_board_real t, const omni_board_real x[OMNI_BOARD_N],
                        omni_board_real margin[OMNI_BOARD_N]);

/* Whether the paper's Theorem 4.1, in continuous time, covers a start at the measured x:
 * every component of x is within 0.99 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool omni_board_covered(const omni_board_real x[OMNI_BOARD_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void omni_board_transform(const omni_board_real lower[OMNI_BOARD_N], const omni_board_real upper[OMNI_BOARD_N],
                          const omni_board_real x[OMNI_BOARD_N], omni_board_real e[OMNI_BOARD_N],
                          omni_board_real epsilon[OMNI_BOARD_N], omni_board_real xi[OMNI_BOARD_N]);

/* In omni_board_selftest.c: calls the controller at points all along the mission and with a NaN, for the board's boot.
 * 0: every u is one that IEEE arithmetic can give; else the number of the first point, from 1, that is off. */
#define OMNI_BOARD_SELFTEST_23e458e2bad7f4ef
int omni_board_selftest(void);

#ifdef __cplusplus
}
#endif

#endif
