The header, and the small files that a task may have beside the C.

== header
#ifndef M_H
#define M_H
#include <stdbool.h>
#include <stdint.h>  [ticks]
#ifdef __cplusplus
extern "C" {
#endif
typedef $scalar P_real;
#define M_N $n
#define M_T_C $t_c
#define M_TICK_PERIOD $tick_period  [ticks]
#define M_TICKS $ticksU  [ticks]
#define M_CYCLE $cycle  [repeats]
#define M_CYCLE_TICKS $cycle_ticksU  [repeats, ticks]
#define M_PERIOD_PROVED $period  [period]
#define M_PERIOD_SHORTEST $shortest  [differences]
#define M_SHARE $share
<<turn of a closed axis>>  [each closed axis]
#define M_DESIGN_HASH "$hash"
typedef enum { M_OK = 0, M_OUTSIDE_TUBE = 1, M_BAD_INPUT = 2 } P_status;
void P_tube(P_real t, P_real lower[M_N], P_real upper[M_N]);
void P_tube_rate(P_real t, P_real lower_rate[M_N], P_real upper_rate[M_N]);
void P_filtered_tube(P_real t, P_real lower[M_N], P_real upper[M_N]);  [order 2]
void P_velocity(P_real dt, const P_real x[M_N], const P_real x_before[M_N], P_real v[M_N]);  [differences]
P_status P_control(P_real t, const P_real x[M_N], P_real u[M_N]);  [order 1]
P_status P_control(P_real t, const P_real x[M_N], const P_real v[M_N], P_real u[M_N]);  [order 2]
P_status P_control_tick(uint32_t tick, const P_real x[M_N], P_real u[M_N]);  [order 1, ticks]
P_status P_control_tick(uint32_t tick, const P_real x[M_N], const P_real v[M_N], P_real u[M_N]);  [order 2, ticks]
P_real P_margin(P_real t, const P_real x[M_N]);  [order 1]
P_real P_margin(P_real t, const P_real x[M_N], const P_real v[M_N]);  [order 2]
void P_margins(P_real t, const P_real x[M_N], P_real margin[M_N]);  [order 1]
void P_margins(P_real t, const P_real x[M_N], const P_real v[M_N], P_real margin[M_N]);  [order 2]
bool P_covered(const P_real x[M_N]);  [order 1]
bool P_covered(const P_real x[M_N], const P_real v[M_N]);  [order 2]
void P_transform(const P_real lower[M_N], const P_real upper[M_N], const P_real x[M_N],
                 P_real e[M_N], P_real epsilon[M_N], P_real xi[M_N]);
P_status P_guard(P_real t, const P_real x[M_N], P_real held[2], P_real u[M_N]);  [hold]
P_status P_guard(P_real t, const P_real x[M_N], int *stopped, P_real u[M_N]);  [stop, order 1]
P_status P_guard(P_real t, const P_real x[M_N], const P_real v[M_N], int *stopped, P_real u[M_N]);  [stop, order 2]
int P_phase(P_real t);  [phase]
P_real P_wrap(P_real t);  [repeats]
uint32_t P_wrap_tick(uint32_t tick);  [repeats, ticks]
void P_unwrap(const P_real x_before[M_N], P_real x[M_N]);  [closed]
#define M_SELFTEST_$hash  [selftest]
int P_selftest(void);  [selftest]
#ifdef __cplusplus
}
#endif
#endif

== guard
#include "P.h"
<<guard that holds>>  [hold]
<<guard that stops>>  [stop]

== guard that holds
P_status P_guard(P_real t, const P_real x[M_N], P_real held[2], P_real u[M_N])
{
    const P_real now = t - held[0];
    const P_status status = P_control(now, x, u);
    if (status == M_OK) {
        held[1] = now;
    }
    if (status != M_OUTSIDE_TUBE) {
        return status;
    }
    held[0] = t - held[1];
    return P_control(held[1], x, u);
}

== guard that stops
P_status P_guard(P_real t, const P_real x[M_N], int *stopped, P_real u[M_N])  [order 1]
P_status P_guard(P_real t, const P_real x[M_N], const P_real v[M_N], int *stopped, P_real u[M_N])  [order 2]
{
    P_status status = P_control(t, x, u);  [order 1]
    P_status status = P_control(t, x, v, u);  [order 2]
    if (status == M_OUTSIDE_TUBE) {
        *stopped = 1;
    }
    if (*stopped != 0) {
        for (int i = 0; i < M_N; i++) {
            u[i] = 0;
        }
        if (status == M_OK) {
            status = M_OUTSIDE_TUBE;
        }
    }
    return status;
}

== wrap
#include "P.h"
P_real P_wrap(P_real t)
{
    return (t < M_T_C) ? t : (t - M_CYCLE);
}
<<wrap of ticks>>  [ticks]

== wrap of ticks
uint32_t P_wrap_tick(uint32_t tick)
{
    return (tick < M_TICKS) ? tick : (tick - M_CYCLE_TICKS);
}

== turn of a closed axis
#define M_TURN_$number $turn

== unwrap
#include "P.h"
/* No fused multiply-adds, so that x has the same bits on every board. */
#if defined(__clang__)
#pragma STDC FP_CONTRACT OFF
#pragma clang fp reassociate(off)
#elif defined(__GNUC__)
#pragma GCC optimize ("fp-contract=off")
#endif
void P_unwrap(const P_real x_before[M_N], P_real x[M_N])
{
    P_real turns;
    <<unwrap an axis>>  [each closed axis]
}

== unwrap an axis
    turns = (x_before[$axis] - x[$axis]) / M_TURN_$number;
    if ((turns > -1000.0) && (turns < 1000.0)) {
        x[$axis] += M_TURN_$number * (P_real)(int)(turns + ((turns < 0.0) ? -0.5 : 0.5));
    }
