/* gantry.h: prescribed-time reach-avoid-stay controller, refined tube, in integers of 32 bits.
 *
 * Certified (gantry.certificate.json): for every t the tube keeps 0.01 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The state stays in it (P9) sampled at ticks, every 0.01 s or faster, from every start with |e(0)| <= 0.9, for |f +
 * w| <= 0.02, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 3e-05: |e| < 0.9001, |u| <= 0.6.
 *
 * Call gantry_control once every period with the tick since the start and the measured state.
 * It keeps no state and needs no set-up; any thread or interrupt may call it. Every call costs about the same.
 * No floating point, no division, no library but the compiler's own products on an AVR.
 * Every bit pattern of an argument is a number, and none overflows.
 */
#ifndef GANTRY_H
#define GANTRY_H

#include <stdbool.h>
#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

#define GANTRY_N 2
#define GANTRY_X_BITS 20 /* x counts units of 2^-20: nothing smaller is seen, round to the nearest */
#define GANTRY_U_BITS 26 /* u counts units of 2^-26 */
#define GANTRY_X(v) GANTRY_UNITS(v, 1048576.0) /* units of a constant in the task's: the compiler computes it */
#define GANTRY_U(v) GANTRY_UNITS(v, 67108864.0)
#define GANTRY_UNITS(v, scale) ((int32_t)(((v) * (scale)) + (((v) < 0) ? -0.5 : 0.5)))
#define GANTRY_TICKS UINT32_C(4000) /* the first tick that is not before t_c = 4 s: count no farther */
#define GANTRY_TICKS_A_SECOND INT32_C(1000)
#define GANTRY_TICKS_PROVED UINT32_C(10) /* between samples, at most: from which starts, see above (P9) */
#define GANTRY_SHARE 0.8999999999999999 /* 0.9 of the half widths at t = 0, rounded down: for gantry_covered */
#define GANTRY_DESIGN_HASH "a0f9dc15bb115d69" /* log it: names this design */

typedef enum {
    GANTRY_OK = 0,
    GANTRY_OUTSIDE_TUBE = 1
} gantry_status;

/* Edges of the tube gamma at a tick, in the units of x.
 * From the tick of t_c on those at t_c.
 */
void gantry_tube(uint32_t tick, int32_t lower[GANTRY_N], int32_t upper[GANTRY_N]);

/* Control law (13), u = -k xi epsilon, k = 0.00437, e clamped to [-0.99, 0.99], u saturated.
 * tick: periods of 0.001 s since the start (it must not wrap to 0: stop counting at t_c); x: state; u: input.
 * x by component: x [m], y [m].
 * OK: x strictly inside the tube. OUTSIDE_TUBE: not so; u is the clamped law and points inward.
 * Every value of x is a state: there is no bad input. u may be the array x itself.
 */
gantry_status gantry_control(uint32_t tick, const int32_t x[GANTRY_N], int32_t u[GANTRY_N]);

/* How far x is from leaving the tube, in 2^-16: the distance to the nearest edge over the width there,
 * least over the components. 32768 in the middle, 0 or more inside, else -65536 to -1.
 * Watch it: act while there is margin, not when the tube is left.
 */
int32_t gantry_margin(uint32_t tick, const int32_t x[GANTRY_N]);

/* The margin of each component, in the same units: which axis is near its edge. */
void gantry_margins(uint32_t tick, const int32_t x[GANTRY_N], int32_t margin[GANTRY_N]);

/* Whether the proof of the sampling period (P9) covers a start at the measured x:
 * every component of x is within 0.9 of the tube's half width about its middle at t = 0.
 * What a measurement may be wrong by (rounding and the noise of [plant]) is taken off.
 * Ask before the first step. Where it says false, nothing is proved of this start: move the robot, or design a tube
 * from where it stands.
 */
bool gantry_covered(const int32_t x[GANTRY_N]);

/* In gantry_selftest.c: calls the controller at points all along the mission and at the ends of its integers, for the
 * board's boot. 0: every result is the one that integers give; else the number of the first point, from 1, that is off. */
#define GANTRY_SELFTEST_a0f9dc15bb115d69
int gantry_selftest(void);

#ifdef __cplusplus
}
#endif

#endif
