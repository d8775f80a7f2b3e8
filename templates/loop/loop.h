/* A closed loop: the emitted controller, held between samples, and a plant xdot = f(x) + g(x) u + w between them, or of order 2
 * xdot = v, vdot = f(x, v) + g(x, v) u + w. A state is x, or x and then v. */
#ifndef LOOP_H
#define LOOP_H

#include <stdint.h>

#define MAX_DIMENSIONS 64 /* of x */
#define STATE (4 * MAX_DIMENSIONS) /* numbers in x, v and the outputs of two lags in series */
#define DRIVE_COLUMNS 4 /* of the drives' table: lag, second lag, slew, weight of opposite commands */
#define MAX_FACES 1024 /* of one unsafe set */
#define MAX_PENDING 128 /* inputs that wait to act */

/* Writes u for the measured state at time t. Returns a status: 0, or another number if the state is outside the tube or an argument is
 * not finite. */
typedef int (*loop_step)(double t, const double *x, double *u);
/* Writes the edges of the tube at t; of order 2, those of the filtered tube follow them. */
typedef void (*loop_tube)(double t, double *lower, double *upper);
/* Moves alpha, the state of an adaptive controller, from t to t + dt. */
typedef void (*loop_advance)(double t, double dt);

/* The direction of w. NONE: w is 0. CONSTANT: one random vector. SINUSOIDAL: that vector times a sine of time. RANDOM: a new vector in
 * every period. NEAREST: toward the nearest unsafe set or face of the state space. OUTWARD: along one axis, toward the nearest edge of
 * the tube. MOTION: along the same axis, the way that x moves in its tube. */
typedef enum { NONE, CONSTANT, SINUSOIDAL, RANDOM, NEAREST, OUTWARD, MOTION } disturbance;

/* The error of the clock by which the sets move. STATED: none. EARLY: the clock is behind the controller's as far as it may be. LATE: it
 * is ahead as far as it may be. WORST: CLOCKS errors between both are tried for each set at each time; a collision with one counts. */
typedef enum { STATED, EARLY, LATE, WORST } sets_clock;

/* A face is a half-space normal.x <= offset: n + 1 numbers, a unit normal and then the offset. */
typedef struct {
    int32_t n, sets;       /* dimensions; unsafe sets */
    int32_t order;         /* of the plant: 1 or 2 */
    int32_t samples;       /* sampling periods to run */
    int32_t integration_steps; /* Runge-Kutta steps in each period */
    int32_t disturbance_kind; /* a value of `disturbance` */
    int32_t max_lost_samples; /* in a row; a sample is lost at random */
    int32_t has_constant_dynamics; /* 1: f and g do not depend on the state, and there are no drives */
    uint64_t seed;
    double period, end;    /* seconds; the last period is cut at the end */
    double w_max;          /* bound on |w|, the Euclidean norm */
    const double *measurement_errors; /* bounds on the error of every measured component of the state */
    const double *filter;  /* n, lambda of order 2: v + filter x is in the filtered tube */
    const double *plant_constants; /* in this run */
    const double *w_ratios; /* n, at most 1: |w_i| is at most w_ratios[i] w_max */
    const double *drives;  /* n rows of DRIVE_COLUMNS, by which the plant's input follows u from rest; NULL: it is u. Time constants of
                            * two first-order lags in series, seconds, 0: none. The rate of change before them, units of u a second, 0:
                            * no limit. The weight nu of opposite commands, of an adverse drive that overshoots. */
    int32_t is_adverse;    /* 1: drives are at once where that helps the disturbance, and as late as they may be elsewhere; the first
                            * u is as late as the others */
    double latency;        /* seconds from a sample to its u, less than MAX_PENDING - 2 periods; the first u acts at once, or see
                            * is_adverse */
    const double *start;   /* a state */
    int32_t space_face_count, target_face_count;
    const double *space_faces; /* of the state space */
    const double *target_faces;
    const int32_t *face_range_starts; /* sets + 1: the faces of set j are those from [j] to before [j + 1] */
    const double *faces;   /* of all sets that are polytopes: x is in the set where it is in every half-space */
    const double *radius;  /* sets: a round set is all points within this distance of its core; 0 for a polytope. The core is a segment
                            * with a box about each of its points. */
    const double *segments; /* sets, 3 n: both ends of a round set's segment, and the half sides of the box */
    int32_t clock;         /* a value of `sets_clock` */
    const int32_t *knot_range_starts; /* sets + 1: the knots of set j are those from [j] to before [j + 1]; a set at rest has none. NULL
                            * where all sets are at rest. */
    const double *knots;   /* each n + 1 numbers: the time on the set's clock, and the displacement of the set */
    const double *activity_and_clock; /* sets, 5: begin and end of the active interval on the set's clock; growth a second; seconds by
                            * which this clock may be behind the controller's; seconds by which it may be ahead */
} loop_setting;

typedef struct {
    int32_t hit;           /* unsafe set that was entered first, or -1 */
    int32_t left;          /* 1: x was outside the state space */
    int32_t reached;       /* 1: x is in the target at the end */
    int32_t outside;       /* samples at which the controller returned a status that is not 0 */
    double hit_at, left_at, outside_at; /* seconds of the first time; -1 where it did not happen */
    double margin;         /* smallest distance to an edge over the width, during the run */
    double e[MAX_DIMENSIONS], u[MAX_DIMENSIONS]; /* largest |e_i|, |u_i| */
    double last[MAX_DIMENSIONS]; /* x at the end */
} loop_result;

/* Runs a closed loop. trace, if not NULL, takes samples + 1 rows: t, x, u, lower, upper, w, of order 2 v, status. tube and
 * advance may be NULL. */
void loop_run(const loop_setting *s, loop_step step, loop_tube tube, loop_advance advance, loop_result *r, double *trace);

/* Writes f (n) and g (n by n, by columns) of the plant at a state. p: constants of the plant; sample: the measured x from which u was
 * computed. */
void loop_plant(const double *x, const double *p, const double *sample, double *f, double *g);

#endif
