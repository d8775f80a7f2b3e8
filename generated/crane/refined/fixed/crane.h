/* crane.h: prescribed-time reach-avoid-stay controller, refined tube, in integers of 32 bits.
 *
 * Certified (crane.certificate.json): for every t the tube keeps 0.05 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled at ticks, every 0.02 s or faster, from every start with |e(0)| <= 0.9 at rest,
 * for |f + w| <= 0.1, 0.9 <= g_ii <= 1.1, |g_ij| <= 0: |e| of v + lambda x < 0.9001, |u| <= 1.5.
 *
 * Call crane_control once every period with the tick since the start and the measured x and v.
 * It keeps no state and needs no set-up; any thread or interrupt may call it. Every call costs about the same.
 * No floating point, no division, no library but the compiler's own products on an AVR.
 * Every bit pattern of an argument is a number, and none overflows.
 */
#ifndef CRANE_H
#define CRANE_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define CRANE_N 2
#define CRANE_X_BITS 18 /* x counts units of 2^-18, v as many a second: round to the nearest */
#define CRANE_U_BITS 25 /* u counts units of 2^-25 */
#define CRANE_X(v) CRANE_UNITS(v, 262144.0) /* units of a constant in the task's: the compiler computes it */
#define CRANE_U(v) CRANE_UNITS(v, 33554432.0)
#define CRANE_UNITS(v, scale) ((int32_t)(((v) * (scale)) + (((v) < 0) ? -0.5 : 0.5)))
#define CRANE_TICKS UINT32_C(2400) /* the first tick that is not before t_c = 12 s: count no farther */
#define CRANE_TICKS_A_SECOND INT32_C(200)
#define CRANE_TICKS_PROVED UINT32_C(4) /* between samples, at most: from which starts, see above (P9) */
#define CRANE_SHARE 0.8999999999999999 /* 0.9 of the half widths at t = 0, rounded down: for crane_covered */
#define CRANE_DESIGN_HASH "94579429cb9a0d6c" /* log it: names this design */

typedef enum {
    CRANE_OK = 0,
    CRANE_OUTSIDE_TUBE = 1
} crane_status;

/* Edges of the tube gamma at a tick, in the units of x.
 * From the tick of t_c on those at t_c.
 */
void crane_tube(uint32_t tick, int32_t lower[CRANE_N], int32_t upper[CRANE_N]);

/* Edges of the filtered tube at a tick, in units a second: of v + lambda x,
 * lambda = [0.66162109375, 0.65380859375].
 * While v + lambda x is between them, x stays in the tube.
 */
void crane_filtered_tube(uint32_t tick, int32_t lower[CRANE_N], int32_t upper[CRANE_N]);

/* Control law (13), u = -k xi epsilon, k = [0.0171, 0.0165], e clamped to [-0.99, 0.99], u saturated,
 * for v + lambda x in its tube, lambda = [0.66162109375, 0.65380859375].
 * tick: periods of 0.005 s since the start (it must not wrap to 0: stop counting at t_c);
 * x: state; v: its rate; u: input.
 * x by component: x [m], y [m].
 * OK: x strictly inside the tube, and v + lambda x inside its own. OUTSIDE_TUBE: not so; u is the clamped law and
 * points inward. Every value of x and v is a state: there is no bad input.
 * u may be the array x or v itself.
 */
crane_status crane_control(uint32_t tick, const int32_t x[CRANE_N], const int32_t v[CRANE_N],
                           int32_t u[CRANE_N]);

/* How far x is from leaving the tube, and v + lambda x from leaving its own, in 2^-16: the distance to
 * the nearest edge over the width there, the lesser of both, least over the components.
 * 32768 in the middle, 0 or more inside, negative outside, at least -65536.
 * Watch it: act while there is margin, not when the tube is left.
 */
int32_t crane_margin(uint32_t tick, const int32_t x[CRANE_N], const int32_t v[CRANE_N]);

/* The margin of each component, in the same units: which axis is near its edge. */
void crane_margins(uint32_t tick, const int32_t x[CRANE_N], const int32_t v[CRANE_N], int32_t margin[CRANE_N]);

/* Whether the proof of the sampling period (P9) covers a start at the measured x and v:
 * every component of x is within 0.9 of the tube's half width about its middle at t = 0,
 * and v + lambda x is in its own tube, no farther from the middle than from such an x at rest.
 * What a measurement may be wrong by (rounding) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands.
 */
bool crane_covered(const int32_t x[CRANE_N], const int32_t v[CRANE_N]);

/* In crane_selftest.c: calls the controller at points all along the mission and at the ends of its integers, for the
 * board's boot. 0: every result is the one that integers give; else the number of the first point, from 1, that is off. */
#define CRANE_SELFTEST_94579429cb9a0d6c
int crane_selftest(void);

#ifdef __cplusplus
}
#endif

#endif
