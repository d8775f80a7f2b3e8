/* A control barrier function filter, solved at every step by OSQP's generated C, beside our emitted step (-DOWN): both in
 * closed loop with xdot = u for 9 s, timed in one process. Reads the edges of the boxes. benchmarks/peers/barrier.py compiles it.
 *
 * Prints for each: seconds a step, whether the state ends in the target, whether it was ever inside a box, steps without
 * a solution.
 */
#define _POSIX_C_SOURCE 199309L
#include <math.h>
#include <stdio.h>
#include <time.h>

#include "cbf_workspace.h"
#include "osqp.h"
#ifdef OWN
#include "arena.h"
#endif

#define STEPS (9 * HERTZ)
#define PERIOD (1.0 / HERTZ)
#define ROUNDS 3
#define ROWS (BOXES + N)

typedef struct {
    double seconds;
    int reached, collided;
} outcome;

static double box[BOXES][N][2];
static double wind; /* |w| that the filter allows for: xdot = u + w */

/* h and its gradient: a smooth lower bound of the distance max_i(|x_i - centre_i| - radius_i), so h >= 0 is outside. */
static double barrier(double edges[N][2], const double x[N], double gradient[N])
{
    double distance[N], largest = -HUGE_VAL, sum = 0.0;
    for (int i = 0; i < N; i++) {
        distance[i] = fabs(x[i] - 0.5 * (edges[i][0] + edges[i][1])) - 0.5 * (edges[i][1] - edges[i][0]);
        largest = fmax(largest, distance[i]);
    }
    for (int i = 0; i < N; i++) {
        gradient[i] = exp(SHARPNESS * (distance[i] - largest));
        sum += gradient[i];
    }
    for (int i = 0; i < N; i++) gradient[i] *= (x[i] < 0.5 * (edges[i][0] + edges[i][1]) ? -1.0 : 1.0) / sum;
    return largest + log(sum / N) / SHARPNESS;
}

/* Writes the input nearest to the nominal one that satisfies every barrier condition: min |u - nominal|^2, gradient . (u + w) >= -CLASS_K h for all w. */
static int filter_step(double t, const double x[N], double u[N])
{
    OSQPFloat q[N], rows[N * (BOXES + 1)], lower[ROWS], upper[ROWS]; /* rows: by column, the boxes and then the bound */
    (void)t;
    for (int j = 0; j < BOXES; j++) {
        double gradient[N], steep = 0.0;
        const double h = barrier(box[j], x, gradient);
        for (int i = 0; i < N; i++) steep += gradient[i] * gradient[i];
        lower[j] = (OSQPFloat)(-CLASS_K * h + wind * sqrt(steep));
        upper[j] = OSQP_INFTY;
        for (int i = 0; i < N; i++) rows[i * (BOXES + 1) + j] = (OSQPFloat)gradient[i];
    }
    for (int i = 0; i < N; i++) { /* the walls of the state space are barriers too */
        rows[i * (BOXES + 1) + BOXES] = 1;
        q[i] = (OSQPFloat)-fmax(-SPEED, fmin(SPEED, GAIN * (SIDE - 0.5 * END - x[i])));
        lower[BOXES + i] = (OSQPFloat)fmax(-SPEED, -CLASS_K * x[i] + wind);
        upper[BOXES + i] = (OSQPFloat)fmin(SPEED, CLASS_K * (SIDE - x[i]) - wind);
    }
    osqp_update_data_mat(&cbf_solver, NULL, NULL, 0, rows, NULL, N * (BOXES + 1));
    osqp_update_data_vec(&cbf_solver, q, lower, upper);
    osqp_solve(&cbf_solver);
    int solved = cbf_solver.info->status_val == OSQP_SOLVED;
    for (int i = 0; i < N; i++) u[i] = solved ? (double)cbf_solver.solution->x[i] : 0.0;
    return !solved;
}

#ifdef OWN
static int own_step(double t, const double x[N], double u[N])
{
    arena_real state[N], input[N];
    for (int i = 0; i < N; i++) state[i] = (arena_real)x[i];
    int failed = arena_control((arena_real)t, state, input) != ARENA_OK;
    for (int i = 0; i < N; i++) u[i] = (double)input[i];
    return failed;
}
#endif

#ifdef LIBRARY /* for the loops of templates/loop/ */
void filter_boxes(const double *edges, double allowed);
int filter_next(double t, const double *x, double *u);

void filter_boxes(const double *edges, double allowed)
{
    wind = allowed;
    for (int k = 0; k < BOXES * N * 2; k++) (&box[0][0][0])[k] = edges[k];
    osqp_cold_start(&cbf_solver);
}

int filter_next(double t, const double *x, double *u)
{
    return filter_step(t, x, u);
}
#else
static int inside(double edges[N][2], const double x[N])
{
    for (int i = 0; i < N; i++)
        if (!(edges[i][0] < x[i] && x[i] < edges[i][1])) return 0;
    return 1;
}

/* One closed loop. States are judged after the clock has stopped; since they are, no compiler removes a step. */
static outcome closed_loop(int (*step)(double, const double[N], double[N]))
{
    static double path[STEPS + 1][N];
    struct timespec begin, end;
    outcome result = {0.0, 1, 0}; /* reached, until it is not */
    for (int i = 0; i < N; i++) path[0][i] = 0.5 * END;
    clock_gettime(CLOCK_MONOTONIC, &begin);
    for (int k = 0; k < STEPS; k++) {
        double u[N];
        (void)step(k * PERIOD, path[k], u);
        for (int i = 0; i < N; i++) path[k + 1][i] = path[k][i] + PERIOD * u[i];
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    result.seconds = ((double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec)) / STEPS;
    for (int i = 0; i < N; i++) result.reached &= SIDE - END <= path[STEPS][i] && path[STEPS][i] <= SIDE;
    for (int k = 0; k <= STEPS; k++)
        for (int j = 0; j < BOXES; j++) result.collided |= inside(box[j], path[k]);
    return result;
}

/* Prints the quickest of the rounds, since any other work of the machine only adds time. */
static void report(const char *name, int (*step)(double, const double[N], double[N]))
{
    outcome best = closed_loop(step);
    for (int k = 1; k < ROUNDS; k++) {
        osqp_cold_start(&cbf_solver);
        outcome next = closed_loop(step);
        best.seconds = fmin(best.seconds, next.seconds);
    }
    printf("%s %.9g %d %d\n", name, best.seconds, best.reached, best.collided);
}

int main(void)
{
    for (int j = 0; j < BOXES; j++)
        for (int i = 0; i < N; i++)
            if (scanf("%lf %lf", &box[j][i][0], &box[j][i][1]) != 2) return 1;
    report("cbf", filter_step);
#ifdef OWN
    report("own", own_step);
#endif
    return 0;
}
#endif
