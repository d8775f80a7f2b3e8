/* crawler.h: prescribed-time reach-avoid-stay controller, refined tube, single precision.
 *
 * Certified (crawler.certificate.json): for every t the tube keeps 0.05 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The state stays in it (P9) sampled every 0.005 s or faster, from every start with |e(0)| <= 0.9, for |f +
 * w| <= 0.1, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 0.002: |e| < 0.9001, |u| <= 1.3.
 *
 * Call crawler_control once every period with the time since the start and the measured state. It keeps no state and
 * needs no set-up; any thread or interrupt may call it. Every call costs about the same: no loop depends on data.
 * Compile without -ffast-math, and with -ffp-contract=off where the target has a fused multiply-add.
 */
#ifndef CRAWLER_H
#define CRAWLER_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef float crawler_real;

#define CRAWLER_N 2
#define CRAWLER_T_C 6.0F /* prescribed time, seconds */
#define CRAWLER_TICK_PERIOD 0.001F /* seconds of one tick of crawler_control_tick */
#define CRAWLER_TICKS 6000U /* the first tick that is not before t_c: count no farther */
#define CRAWLER_PERIOD_PROVED 0.005F /* seconds between samples, at most: from which starts, see above (P9) */
#define CRAWLER_SHARE 0.9F /* 0.9 of the half widths at t = 0, rounded down: for crawler_covered */
#define CRAWLER_DESIGN_HASH "c377fc1be17d5f0b" /* log it: names this design */

typedef enum {
    CRAWLER_OK = 0,
    CRAWLER_OUTSIDE_TUBE = 1,
    CRAWLER_BAD_INPUT = 2
} crawler_status;

/* Edges of the tube gamma at time t (seconds), in the task's units.
 * t below 0 counts as 0 and above t_c as t_c; NaN when t is not finite.
 */
void crawler_tube(crawler_real t, crawler_real lower[CRAWLER_N], crawler_real upper[CRAWLER_N]);

/* Rate of change of the edges, d gamma / d t, at time t (seconds), in units per second.
 * The rate at 0 before that and zero from t_c on; NaN when t is not finite.
 */
void crawler_tube_rate(crawler_real t, crawler_real lower_rate[CRAWLER_N], crawler_real upper_rate[CRAWLER_N]);

/* Control law (13), u = -k xi epsilon, k = [0.0388, 0.0623], e clamped to [-0.99, 0.99] by component, u saturated.
 * t: seconds since the start (held within [0, t_c]); x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: t or x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
crawler_status crawler_control(crawler_real t, const crawler_real x[CRAWLER_N], crawler_real u[CRAWLER_N]);

/* Control law (13), u = -k xi epsilon, k = [0.0388, 0.0623], e clamped to [-0.99, 0.99] by component, u saturated.
 * tick: periods of 0.001 s since the start (it must not wrap to 0: stop counting at t_c); x: state; u: input.
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law, finite, and points inward
 * (0 where the tube is empty). BAD_INPUT: x has a NaN or an infinity; u is 0. u may be the array x itself.
 */
crawler_status crawler_control_tick(uint32_t tick, const crawler_real x[CRAWLER_N], crawler_real u[CRAWLER_N]);

/* How far x is from leaving the tube: the distance to the nearest edge over the tube's width there, least over the
 * components. 0.5 in the middle, positive inside, negative outside, at least -1; NaN when an argument is not finite.
 * Watch it: act while there is margin, not when the tube is left.
 */
crawler_real crawler_margin(crawler_real t, const crawler_real x[CRAWLER_N]);

/* The margin of each component: which axis is near its edge. NaN where that component of the state is NaN; in all
 * components where another argument is not finite.
 */
void crawler_margins(crawler_real t, const crawler_real x[CRAWLER_N], crawler_real margin[CRAWLER_N]);

/* Whether the proof of the sampling period (P9) covers a start at the measured x:
 * every component of x is within 0.9 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands. False for a NaN.
 */
bool crawler_covered(const crawler_real x[CRAWLER_N]);

/* Error transform of section IV for the state x in the box (lower, upper), by component:
 *   e       = (2 x - (upper + lower)) / (upper - lower), clamped to [-e_max, e_max]
 *   epsilon = ln((1 + e) / (1 - e))
 *   xi      = 4 / ((upper - lower) (1 - e^2)) = d epsilon / dx
 * 0 in a component with upper <= lower; a width below 2^-20 counts as that.
 * NaN where an edge, x or upper - lower is not finite.
 */
void crawler_transform(const crawler_real lower[CRAWLER_N], const crawler_real upper[CRAWLER_N],
                       const crawler_real x[CRAWLER_N], crawler_real e[CRAWLER_N],
                       crawler_real epsilon[CRAWLER_N], crawler_real xi[CRAWLER_N]);

#ifdef __cplusplus
}
#endif

#endif
