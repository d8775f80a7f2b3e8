/* A closed loop: the emitted controller, held between samples, and a plant xdot = f(x) + g(x) u + w between them, or of order 2
 * xdot = v, vdot = f(x, v) + g(x, v) u + w. A state is x, or x and then v. */
#ifndef LOOP_H
#define LOOP_H

#include <stdint.h>

#define MAX_DIMENSIONS 64 /* dimensions */
#define STATE (3 * MAX_DIMENSIONS)
#define MAX_FACES 1024 /* of one unsafe set */
#define MAX_PENDING 128 /* inputs on their way */

/* Writes u for the measured state at time t; returns a status, not 0 where the state is outside of the tube or an argument is bad. */
typedef int (*loop_step)(double t, const double *x, double *u);
/* Writes the edges of the tube at t, of order 2 then those of the filtered tube. */
typedef void (*loop_tube)(double t, double *lower, double *upper);
/* Moves the state of the controller itself, of an adaptive tube, from t to t + dt. */
typedef void (*loop_advance)(double t, double dt);

typedef enum { NONE, CONSTANT, SINUSOIDAL, RANDOM, NEAREST, OUTWARD } disturbance;

/* What the clock of the sets shows, within their timing uncertainty; WORST: the worst of CLOCKS readings, for each set at each time. */
typedef enum { STATED, EARLY, LATE, WORST } sets_clock;

typedef struct {
    int32_t n, sets;       /* dimension; unsafe sets */
    int32_t order;         /* of the plant: 1 or 2 */
    int32_t samples;       /* periods to run */
    int32_t parts;         /* Runge-Kutta steps in each */
    int32_t kind;          /* of disturbance */
    int32_t lost;          /* samples that may be lost in a row, at random */
    int32_t constant;      /* whether f and g are the same everywhere */
    uint64_t seed;
    double period, end;    /* seconds; the last period is cut at the end */
    double strength;       /* |w| at most, its Euclidean norm */
    double noise;          /* of every measured component of x, at most */
    double noise_v;        /* and of v */
    const double *filter;  /* n, of order 2: v + filter x is in the filtered tube */
    const double *constants; /* of the plant, in this run */
    const double *shares;  /* n: of w by component, at most 1 */
    double lag;            /* seconds: the acting input follows u by a first-order lag, 0 for none; it begins at 0 */
    double latency;        /* seconds from a sample to its u, less than MAX_PENDING - 2 periods; the first one acts at once */
    const double *start;   /* a state */
    int32_t walls, goals;  /* half-spaces of the state space and of the target */
    const double *space;   /* each n + 1 numbers, as in faces */
    const double *target;
    const int32_t *first;  /* sets + 1: where the faces of each begin, and how many there are */
    const double *faces;   /* each n + 1 numbers, a unit normal and an offset: the core of a set is where normal.x <= offset for all its faces */
    const double *radius;  /* sets: a round set is all points this near to its core, the segment between its ends with a box about
                            * every point; 0 for a polytope */
    const double *ends;    /* sets, 3 n: both ends, and half the box */
    int32_t clock;         /* sets_clock */
    const int32_t *turn;   /* sets + 1: where the turns of each motion begin, and how many there are; a set at rest has none;
                            * NULL where all are at rest */
    const double *turns;   /* each n + 1 numbers: the time on the sets' clock, the displacement */
    const double *activity; /* sets, 5: active interval on the sets' clock, from and to; growth a second; seconds that this clock
                            * may be behind the controller's, and ahead of it */
} loop_setting;

typedef struct {
    int32_t hit;           /* unsafe set that was entered first, or -1 */
    int32_t left;          /* whether x was ever outside the state space */
    int32_t reached;       /* x in the target at the end */
    int32_t outside;       /* samples at which the controller returned a status that is not 0 */
    double hit_at, left_at, outside_at; /* seconds; -1 where not */
    double margin;         /* smallest distance to an edge over the width, all along */
    double e[MAX_DIMENSIONS], u[MAX_DIMENSIONS]; /* largest |e_i|, |u_i| */
    double last[MAX_DIMENSIONS]; /* x at the end */
} loop_result;

/* Runs a closed loop. trace, if not NULL, takes samples + 1 rows: t, x, u, lower, upper, w, of order 2 v, status. tube and advance may be NULL. */
void loop_run(const loop_setting *s, loop_step step, loop_tube tube, loop_advance advance, loop_result *r, double *trace);

/* The plant: f (n) and g (n by n, by columns) at a state, with its constants p; sample: x of the sample that u was computed from. */
void loop_plant(const double *x, const double *p, const double *sample, double *f, double *g);

#endif
