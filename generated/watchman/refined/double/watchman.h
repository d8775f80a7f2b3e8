/* watchman.h: prescribed-time reach-avoid-stay controller, refined tube, double precision.
 *
 * Certified (watchman.certificate.json): for every t the tube keeps 0.03 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and repeats itself for ever.
 * Every x(t) that stays in the tube satisfies the mission (P10): (always eventually[0, 14] gate and always
 * eventually[0, 14] office and always eventually[0, 14] store and always not lab); times are seconds of t, not turned
 * back. It still holds where every time at which the tube is in a region, or off one, is wrong by up to 0.343 s.
 *
 * Call watchman_control once every period with the time that watchman_wrap turns back and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef WATCHMAN_H
#define WATCHMAN_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef double watchman_real;

#define WATCHMAN_N 2
#define WATCHMAN_T_C 16.0 /* prescribed time, seconds; t = 0 is when the mission begins */
#define WATCHMAN_TICK_PERIOD 0.02 /* seconds of one tick of watchman_control_tick */
#define WATCHMAN_TICKS 800U /* the first tick that is not before t_c: watchman_wrap_tick turns it back */
#define WATCHMAN_CYCLE 14.0 /* seconds after which the tube repeats itself, from T_C - CYCLE on: watchman_wrap */
#define WATCHMAN_CYCLE_TICKS 700U /* the same in ticks, exactly */
#define WATCHMAN_SHARE 0.99 /* 0.99 of the half widths at t = 0, rounded down: for watchman_covered */
#define WATCHMAN_DESIGN_HASH "eb13cea42d742794" /* log it: names this design */

typedef enum {
    WATCHMAN_OK = 0,
    WATCHMAN_OUTSIDE_TUBE = 1,
    WATCHMAN_BAD_INPUT = 2
} watchman_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void watchman_tube(watchman_real t, watchman_real lower[WATCHMAN_N], watchman_real upper[WATCHMAN_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void watchman_tube_rate(watchman_real t, watchman_real lower_rate[WATCHMAN_N],
                        watchman_real upper_rate[WATCHMAN_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * t: seconds, as watchman_wrap turns them back (held within [0, t_c]); x: state; u: input.
 * x by component: x [m], y [m].
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
watchman_status watchman_control(watchman_real t, const watchman_real x[WATCHMAN_N],
                                 watchman_real u[WATCHMAN_N]);

/* Control law (13), u = -k xi epsilon, k = 0.5, e clamped to [-0.99, 0.99] by component.
 * tick: periods of 0.02 s, as watchman_wrap_tick turns them back; x: state; u: input.
 * x by component: x [m], y [m].
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
watchman_status watchman_control_tick(uint32_t tick, const watchman_real x[WATCHMAN_N],
                                      watchman_real u[WATCHMAN_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
watchman_real watchman_margin(watchman_real t, const watchman_real x[WATCHMAN_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void watchman_margins(watchman_real t, const watchman_real x[WATCHMAN_N], watchman_real margin[WATCHMAN_N]);

/* Whether the paper's Theorem 4.1, in continuous time, covers a start at the measured x:
 * every component of x is within 0.99 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool watchman_covered(const watchman_real x[WATCHMAN_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void watchman_transform(const watchman_real lower[WATCHMAN_N], const watchman_real upper[WATCHMAN_N],
                        const watchman_real x[WATCHMAN_N], watchman_real e[WATCHMAN_N],
                        watchman_real epsilon[WATCHMAN_N], watchman_real xi[WATCHMAN_N]);

/* In watchman_phase.c: which entry of the mission is being served at time t, from 1; in every cycle alike, also what was asked once.
 * 1 patrol gate, office, store: store from 4.282 to 4.968 s; office from 9.282 to 9.968 s; gate from 12.29 to 12.96 s
 * 2 never lab: holds, without a visit
 */
int watchman_phase(watchman_real t);

/* In watchman_wrap.c: time that never ends. After 2 s the tube repeats itself every 14 s: t or, from t_c on, t one
 * cycle earlier; for t less than a cycle after t_c. So count t = watchman_wrap(t + period).
 * Of a t beyond t_c the tube is that at t_c: it stands off every unsafe set, and the mission does not go on.
 * In seconds a turn moves the clock by up to 1.8e-15 s and every sum by up to 1.8e-15 s, period after period.
 * In ticks nothing is lost: tick = watchman_wrap_tick(tick + 1U). All that is said above is about a clock that is right. */
watchman_real watchman_wrap(watchman_real t);
uint32_t watchman_wrap_tick(uint32_t tick);

#ifdef __cplusplus
}
#endif

#endif
