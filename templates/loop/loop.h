/* A closed loop: the emitted controller, held between samples, and a plant xdot = f(x) + g(x) u + w between them, or of order 2
 * xdot = v, vdot = f(x, v) + g(x, v) u + w. A state is x, or x and then v. */
#ifndef LOOP_H
#define LOOP_H

#include <stdint.h>

#define MOST 64 /* dimensions */
#define STATE (3 * MOST)
#define FACES 1024 /* of one unsafe set */
#define WAITING 128 /* inputs on their way */

/* u from the measured state at time t; not 0 when the controller says that it is outside its tube, or that its input is bad. */
typedef int (*loop_step)(double t, const double *x, double *u);
/* Edges of the tube at t as the controller has it now, of order 2 then those of the filtered one; to its next state, by steps of its own, over dt from t on. */
typedef void (*loop_tube)(double t, double *lower, double *upper);
typedef void (*loop_advance)(double t, double dt);

typedef enum { NONE, CONSTANT, SINUSOIDAL, RANDOM, NEAREST, OUTWARD } disturbance;

typedef enum { STATED, EARLY, LATE, WORST } sets_clock; /* what it shows, of all that the doubt about it allows; WORST: of each
                                                          * set and moment the worst of CLOCKS readings */

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
    const double *filter;  /* n, of order 2: what is held in the filtered tube is v + filter x */
    const double *constants; /* of the plant, in this run */
    const double *shares;  /* n: of w by component, at most 1 */
    double lag;            /* seconds: what acts follows u by a first-order lag, 0 for none; at rest first */
    double latency;        /* seconds from a sample to its u, less than WAITING - 2 periods; the first one acts at once */
    const double *start;   /* a state */
    int32_t walls, goals;  /* half-spaces of the state space and of the target */
    const double *space;   /* each n + 1 numbers, as in faces */
    const double *target;
    const int32_t *first;  /* sets + 1: where the faces of each begin, and how many there are */
    const double *faces;   /* each n + 1 numbers, a unit normal and an offset: the core of a set is where normal.x <= offset for all of its own */
    const double *radius;  /* sets: of a round one what is that near to its core, the segment from one end to the other with a box
                            * about every point; 0 of a polytope */
    const double *ends;    /* sets, 3 n: both ends, and half the box */
    int32_t clock;         /* sets_clock */
    const int32_t *turn;   /* sets + 1: where the turns of each motion begin, none of one that stands, and how many there are;
                            * NULL where all stand */
    const double *turns;   /* each n + 1 numbers: the time on the sets' clock, the displacement */
    const double *hours;   /* sets, 5: unsafe from and to, on the sets' clock; growth a second; seconds that the clock may be behind
                            * the controller's, and ahead */
} loop_setting;

typedef struct {
    int32_t hit;           /* unsafe set that was entered first, or -1 */
    int32_t left;          /* whether x was ever outside the state space */
    int32_t reached;       /* x in the target at the end */
    int32_t outside;       /* samples at which the controller said so */
    double hit_at, left_at, outside_at; /* seconds; -1 where not */
    double margin;         /* least distance to an edge over the width, all along */
    double e[MOST], u[MOST]; /* largest |e_i|, |u_i| */
    double last[MOST];     /* x then */
} loop_result;

/* Runs it. trace, where given, takes samples + 1 rows: t, x, u, lower, upper, w, of order 2 v, status. tube and advance may be NULL. */
void loop_run(const loop_setting *s, loop_step step, loop_tube tube, loop_advance advance, loop_result *r, double *trace);

/* The plant: f (n) and g (n by n, by columns) at a state, with its constants, where u is what a sample made. */
void loop_plant(const double *x, const double *p, const double *sample, double *f, double *g);

#endif
