/* The loop: classical Runge-Kutta steps between samples, halved until both halves agree with the full step; every state on the
 * way is judged. See loop.h. */
#include "loop.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define TOLERANCE 1e-12 /* of 1 + |x|: largest difference of a step and its halves, 15 times the remaining error */
#define MAX_HALVINGS 12 /* of a step */
#define PROJECTION_ROUNDS 200 /* of Hildreth's method */
#define CLOCKS 9 /* readings that are tried for the worst */

typedef struct {
    const loop_setting *s;
    uint64_t random;
    double direction[MAX_DIMENSIONS]; /* unit vector, or the vector held over this period */
    double rate, phase;     /* of the sinusoid, rad/s and rad */
    double middle[STATE], half[STATE]; /* of the tube, and of the filtered one, when last judged */
} wind;

static double uniform(uint64_t *state) /* splitmix64, to [0, 1) */
{
    uint64_t z = (*state += 0x9E3779B97F4A7C15u);
    z = (z ^ (z >> 30)) * 0xBF58476D1CE4E5B9u;
    z = (z ^ (z >> 27)) * 0x94D049BB133111EBu;
    return (double)((z ^ (z >> 31)) >> 11) * 0x1.0p-53;
}

static double norm_of(const double *v, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += v[i] * v[i];
    return sqrt(sum);
}

static void unit_vector(uint64_t *state, double *v, int n)
{
    double size;
    do { /* in the ball, then on the sphere */
        for (int i = 0; i < n; i++) { /* normal numbers, by Box and Muller */
            const double a = 1.0 - uniform(state), b = uniform(state);
            v[i] = sqrt(-2.0 * log(a)) * cos(6.283185307179586 * b);
        }
        size = norm_of(v, n);
    } while (size < 1e-9);
    for (int i = 0; i < n; i++) v[i] /= size;
}

static double beyond(const double *face, const double *x, int n) /* how far x is from its half-space, negative inside */
{
    double sum = -face[n];
    for (int i = 0; i < n; i++) sum += face[i] * x[i];
    return sum;
}

static double one_norm_of(const double *face, int n) /* of the normal */
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += fabs(face[i]);
    return sum;
}

/* From x to the nearest point of a polytope, by Hildreth's method: each half-space in turn takes back its last push and pushes
 * again. A box takes one round. `way` is the sum of all pushes. Returns the distance, 0 inside. */
static double to_polytope(const double *faces, int count, double growth, const double *x, double *way, int n)
{
    double pushed[MAX_FACES], y[MAX_DIMENSIONS];
    memset(pushed, 0, (size_t)count * sizeof *pushed); /* not all of MAX_FACES, which takes longer than the rest of the loop */
    memset(way, 0, (size_t)n * sizeof *way);
    memcpy(y, x, (size_t)n * sizeof *x);
    for (int round = 0; round < PROJECTION_ROUNDS; round++) {
        double moved = 0.0;
        for (int f = 0; f < count; f++) {
            const double *face = faces + (n + 1) * f;
            const double out = growth > 0.0 ? growth * one_norm_of(face, n) : 0.0; /* grown by a box */
            const double push = fmax(0.0, pushed[f] + (beyond(face, y, n) - out)), change = push - pushed[f];
            for (int i = 0; i < n; i++) y[i] -= change * face[i];
            pushed[f] = push;
            moved = fmax(moved, fabs(change));
        }
        if (moved <= 1e-12) break;
    }
    for (int i = 0; i < n; i++) way[i] = y[i] - x[i];
    return norm_of(way, n);
}

/* From x to the nearest point of a segment with a box about every point: along the segment the square of the distance is convex,
 * made of parabolas that meet where a coordinate comes to the box's edge. Returns the distance, 0 inside. */
static double to_segment(const double *ends, const double *x, double *way, int n)
{
    const double *from = ends, *to = ends + n, *half = ends + 2 * n;
    double turn[2 * MAX_DIMENSIONS + 2] = {0.0, 1.0}, best = HUGE_VAL;
    int turns = 2;
    for (int i = 0; i < n; i++)
        for (int side = -1; side <= 1; side += 2) {
            const double t = (x[i] + side * half[i] - from[i]) / (to[i] - from[i]);
            if (t > 0.0 && t < 1.0) turn[turns++] = t;
        }
    for (int k = 1; k < turns; k++)
        for (int m = k; m > 0 && turn[m] < turn[m - 1]; m--) {
            const double larger = turn[m - 1];
            turn[m - 1] = turn[m], turn[m] = larger;
        }
    for (int k = 0; k + 1 < turns; k++) {
        double slope = 0.0, bend = 0.0, at[3] = {turn[k], turn[k + 1], turn[k]};
        const double middle = 0.5 * (turn[k] + turn[k + 1]);
        for (int i = 0; i < n; i++) { /* which side of the box it is on does not change between two turns */
            const double gap = from[i] + middle * (to[i] - from[i]) - x[i];
            const double side = gap > half[i] ? 1.0 : gap < -half[i] ? -1.0 : 0.0, step = to[i] - from[i];
            if (side != 0.0) slope += (gap - side * half[i]) * step, bend += step * step;
        }
        if (bend > 0.0) at[2] = fmin(fmax(middle - slope / bend, turn[k]), turn[k + 1]);
        for (int p = 0; p < 3; p++) {
            double gaps[MAX_DIMENSIONS];
            for (int i = 0; i < n; i++) {
                const double gap = from[i] + at[p] * (to[i] - from[i]) - x[i];
                gaps[i] = gap > half[i] ? gap - half[i] : gap < -half[i] ? gap + half[i] : 0.0;
            }
            const double distance = norm_of(gaps, n);
            if (distance < best) {
                best = distance;
                memcpy(way, gaps, (size_t)n * sizeof *way);
            }
        }
    }
    return best;
}

/* A set at one reading of its clock: whether it is unsafe, its growth, and x less the displacement of the set. */
typedef struct {
    int unsafe;
    double growth, relative_x[MAX_DIMENSIONS];
} set_state;

static int readings(const loop_setting *s, int j) /* how many readings of its clock count for a set */
{
    return s->turn != NULL && s->clock == WORST && s->turn[j + 1] > s->turn[j] ? CLOCKS : 1;
}

/* Writes the state of set j for a controller that is at x at time t. */
static void set_state_at(const loop_setting *s, int j, int reading, double t, const double *x, set_state *p)
{
    const int n = s->n;
    double by[MAX_DIMENSIONS] = {0}, tau = t;
    p->unsafe = 1, p->growth = 0.0;
    memcpy(p->relative_x, x, (size_t)n * sizeof *x);
    if (s->turn == NULL || s->turn[j + 1] == s->turn[j]) return;
    const int first = s->turn[j], last = s->turn[j + 1] - 1;
    const double *activity = s->activity + 5 * j, *at = s->turns + (n + 1) * first;
    if (s->clock == EARLY) tau = t - activity[3];
    if (s->clock == LATE) tau = t + activity[4];
    if (s->clock == WORST) tau = t - activity[3] + reading * (activity[3] + activity[4]) / (CLOCKS - 1);
    p->unsafe = tau >= activity[0] && tau <= activity[1];
    p->growth = fmax(0.0, tau) * activity[2];
    memcpy(by, at + 1, (size_t)n * sizeof *by);
    for (int k = first; k < last; k++, at += n + 1) {
        const double *to = at + n + 1, share = fmin(1.0, (tau - at[0]) / (to[0] - at[0]));
        if (tau <= at[0]) break;
        for (int i = 0; i < n; i++) by[i] = at[1 + i] + share * (to[1 + i] - at[1 + i]);
    }
    for (int i = 0; i < n; i++) p->relative_x[i] = x[i] - by[i];
}

/* From x to the core of set j: the distance, 0 inside; `way` is the vector to the nearest point. */
static double to_core(const loop_setting *s, int j, const set_state *p, double *way)
{
    const int n = s->n;
    if (s->radius[j] > 0.0) return to_segment(s->ends + 3 * n * j, p->relative_x, way, n);
    return to_polytope(s->faces + (n + 1) * s->first[j], s->first[j + 1] - s->first[j], p->growth, p->relative_x, way, n);
}

/* Writes the unit vector toward the nearest unsafe set or wall. */
static void nearest(const loop_setting *s, double t, const double *x, double *w)
{
    const int n = s->n;
    double best = HUGE_VAL, way[MAX_DIMENSIONS];
    set_state p;
    for (int j = 0; j < s->sets; j++)
        for (int reading = 0; reading < readings(s, j); reading++) {
            set_state_at(s, j, reading, t, x, &p);
            if (!p.unsafe) continue;
            const double core = to_core(s, j, &p, way);
            const double distance = s->radius[j] > 0.0 ? core - s->radius[j] - p.growth : core;
            if (distance > 0.0 && distance < best) {
                best = distance;
                for (int i = 0; i < n; i++) w[i] = way[i] / core;
            }
        }
    for (int f = 0; f < s->walls; f++) {
        const double *wall = s->space + (n + 1) * f, distance = -beyond(wall, x, n);
        if (distance < best) {
            best = distance;
            memcpy(w, wall, (size_t)n * sizeof *w);
        }
    }
}

static int tube_size(const loop_setting *s) /* of all tubes together */
{
    return s->order * s->n;
}

static int state_size(const loop_setting *s) /* with the acting input, where it lags */
{
    return tube_size(s) + (s->lag > 0.0 ? s->n : 0);
}

/* Writes what the tubes bound: x, and of order 2 then v + filter x. */
static void tube_coordinates(const loop_setting *s, const double *x, double *coordinates)
{
    const int n = s->n;
    memcpy(coordinates, x, (size_t)n * sizeof *x);
    if (s->order == 2)
        for (int i = 0; i < n; i++) coordinates[n + i] = x[n + i] + s->filter[i] * x[i];
}

/* Writes the disturbance w at time t and state x. */
static void disturb(const wind *v, double t, const double *x, double *w)
{
    const loop_setting *s = v->s;
    const int n = s->n;
    memset(w, 0, (size_t)n * sizeof *w);
    if (s->kind == CONSTANT || s->kind == RANDOM) memcpy(w, v->direction, (size_t)n * sizeof *w);
    if (s->kind == SINUSOIDAL)
        for (int i = 0; i < n; i++) w[i] = v->direction[i] * sin(v->rate * t + v->phase);
    if (s->kind == NEAREST) nearest(s, t, x, w);
    if (s->kind == OUTWARD) { /* toward the nearest edge of the tube */
        const int first = (s->order - 1) * n;
        int worst = first;
        double largest_e = -1.0, coordinates[STATE];
        tube_coordinates(s, x, coordinates);
        for (int i = first; i < first + n; i++) {
            const double e = fabs(coordinates[i] - v->middle[i]) / v->half[i];
            if (e > largest_e) largest_e = e, worst = i;
        }
        w[worst - first] = coordinates[worst] < v->middle[worst] ? -1.0 : 1.0;
    }
    for (int i = 0; i < n; i++) w[i] *= s->strength * s->shares[i];
}

/* An input, x of the sample that it was computed from, and the time from which it acts. */
typedef struct {
    double since, u[MAX_DIMENSIONS], sample[MAX_DIMENSIONS];
} held_input;

/* The acting input, and those that are still to act, in order of time. */
typedef struct {
    held_input pending[MAX_PENDING];
    int first, count;
} inputs;

static held_input *input_at(inputs *q, int k) /* 0: the acting one */
{
    return &q->pending[(q->first + k) % MAX_PENDING];
}

/* Writes the derivative of the state. */
static void rate_of(const wind *v, double t, const double *x, const held_input *acts, double *rate)
{
    const double *u = acts->u;
    const int n = v->s->n;
    double g[MAX_DIMENSIONS * MAX_DIMENSIONS], w[MAX_DIMENSIONS], *turn = rate + (v->s->order - 1) * n;
    loop_plant(x, v->s->constants, acts->sample, turn, g);
    disturb(v, t, x, w);
    if (v->s->lag > 0.0) {
        const int first = tube_size(v->s);
        for (int i = 0; i < n; i++) rate[first + i] = (u[i] - x[first + i]) / v->s->lag;
        u = x + first;
    }
    for (int i = 0; i < n; i++) {
        if (v->s->order == 2) rate[i] = x[n + i];
        turn[i] += w[i];
        for (int j = 0; j < n; j++) turn[i] += g[i + n * j] * u[j];
    }
}

static void runge_kutta(const wind *v, double t, double h, const held_input *acts, double *x)
{
    static const double at[4] = {0.0, 0.5, 0.5, 1.0}, share[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    const int n = state_size(v->s);
    double k[STATE] = {0}, y[STATE], sum[STATE] = {0};
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < n; i++) y[i] = x[i] + at[stage] * h * k[i];
        rate_of(v, t + at[stage] * h, y, acts, k);
        for (int i = 0; i < n; i++) sum[i] += share[stage] * k[i];
    }
    for (int i = 0; i < n; i++) x[i] += h * sum[i];
}

/* A step of h, by halves where one step and two halves differ by more than rounding and TOLERANCE allow. */
static void integrate(const wind *v, double t, double h, const held_input *acts, double *x, int depth)
{
    const int n = state_size(v->s);
    double full[STATE], halves[STATE], worst = 0.0;
    memcpy(full, x, (size_t)n * sizeof *x);
    runge_kutta(v, t, h, acts, full);
    if (v->s->constant) { /* f and g do not change: one step is exact but for the change of w */
        memcpy(x, full, (size_t)n * sizeof *x);
        return;
    }
    memcpy(halves, x, (size_t)n * sizeof *x);
    runge_kutta(v, t, 0.5 * h, acts, halves);
    runge_kutta(v, t + 0.5 * h, 0.5 * h, acts, halves);
    for (int i = 0; i < n; i++) worst = fmax(worst, fabs(halves[i] - full[i]) / (1.0 + fabs(halves[i])));
    if (depth == 0 || !(worst > TOLERANCE)) {
        for (int i = 0; i < n; i++) x[i] = halves[i] + (halves[i] - full[i]) / 15.0;
        return;
    }
    integrate(v, t, 0.5 * h, acts, x, depth - 1);
    integrate(v, t + 0.5 * h, 0.5 * h, acts, x, depth - 1);
}

/* Drives the plant from `now` over h, with each input while it acts. */
static void drive(const wind *v, double now, double h, inputs *q, double *x)
{
    const double end = now + h;
    for (double at = now, left = h; left > 0.0; left = end - at) {
        while (q->count > 1 && input_at(q, 1)->since <= at) q->first = (q->first + 1) % MAX_PENDING, q->count--;
        const double step = q->count > 1 ? fmin(left, input_at(q, 1)->since - at) : left;
        integrate(v, at, step, input_at(q, 0), x, MAX_HALVINGS);
        if (step == left) return;
        at += step;
    }
}

static int inside(const double *faces, int count, const double *x, int n)
{
    for (int f = 0; f < count; f++)
        if (!(beyond(faces + (n + 1) * f, x, n) <= 0.0)) return 0;
    return 1;
}

/* Whether x is in the interior of set j. Touching an unsafe set is no collision, since the start or the target may touch it. */
static int collides(const loop_setting *s, int j, double t, const double *x)
{
    const int n = s->n;
    double way[MAX_DIMENSIONS];
    set_state p;
    for (int reading = 0; reading < readings(s, j); reading++) {
        int in = 1;
        set_state_at(s, j, reading, t, x, &p);
        if (!p.unsafe) continue;
        if (s->radius[j] > 0.0) in = to_core(s, j, &p, way) < s->radius[j] + p.growth;
        for (int f = s->first[j]; in && f < s->first[j + 1]; f++) {
            const double *face = s->faces + (n + 1) * f, out = p.growth > 0.0 ? p.growth * one_norm_of(face, n) : 0.0;
            in = beyond(face, p.relative_x, n) < out;
        }
        if (in) return 1;
    }
    return 0;
}

/* Notes in r what a state at time t adds to the result, and in v the tube. */
static void judge(const loop_setting *s, double t, const double *x, loop_tube tube, wind *v, loop_result *r)
{
    const int n = s->n;
    double lower[STATE], upper[STATE], coordinates[STATE];
    for (int j = 0; j < s->sets && r->hit < 0; j++)
        if (collides(s, j, t, x)) r->hit = j, r->hit_at = t;
    if (!r->left && !inside(s->space, s->walls, x, n)) r->left = 1, r->left_at = t;
    if (tube == NULL) return;
    tube(t, lower, upper);
    tube_coordinates(s, x, coordinates);
    for (int i = 0; i < tube_size(s); i++) {
        const double width = upper[i] - lower[i], nearer = fmin(coordinates[i] - lower[i], upper[i] - coordinates[i]);
        v->middle[i] = 0.5 * (lower[i] + upper[i]);
        v->half[i] = width > 0.0 ? 0.5 * width : 1e-9;
        const double share = width > 0.0 ? nearer / width : -1.0, e = fabs(coordinates[i] - v->middle[i]) / v->half[i];
        double *largest_e = &r->e[i % n];
        r->margin = share >= r->margin ? r->margin : share == share ? share : -1.0; /* NaN counts as outside */
        *largest_e = e <= *largest_e ? *largest_e : e == e ? e : HUGE_VAL;
    }
}

static void start_wind(wind *v, const loop_setting *s)
{
    v->s = s;
    v->random = s->seed;
    unit_vector(&v->random, v->direction, s->n);
    v->rate = exp(log(0.5) + uniform(&v->random) * log(40.0)); /* 0.5 to 20 rad/s */
    v->phase = 6.283185307179586 * uniform(&v->random);
    tube_coordinates(s, s->start, v->middle);
    for (int i = 0; i < tube_size(s); i++) v->half[i] = 1.0;
}

static double *write_row(double *row, double t, const double *x, const double *u, loop_tube tube, const double *w, int status,
                         int n, int order)
{
    double edges[2][STATE] = {{0}, {0}};
    if (tube != NULL) tube(t, edges[0], edges[1]);
    const double *parts[6] = {x, u, edges[0], edges[1], w, x + n};
    *row++ = t;
    for (int p = 0; p < 4 + order; p++)
        for (int i = 0; i < n; i++) *row++ = parts[p][i];
    *row++ = status;
    return row;
}

void loop_run(const loop_setting *s, loop_step step, loop_tube tube, loop_advance advance, loop_result *r, double *trace)
{
    const int n = s->n, size = tube_size(s);
    wind v;
    double x[STATE] = {0}, measured[STATE], u[MAX_DIMENSIONS] = {0}, w[MAX_DIMENSIONS] = {0};
    static inputs q; /* one loop at a time in a process */
    int status = 0, lost = 0;
    memset(r, 0, sizeof *r);
    q.first = q.count = 0;
    r->hit = -1, r->hit_at = r->left_at = r->outside_at = -1.0, r->margin = 0.5;
    start_wind(&v, s);
    memcpy(x, s->start, (size_t)size * sizeof *x);
    judge(s, 0.0, x, tube, &v, r);
    for (int k = 0; k < s->samples; k++) {
        const double t = k * s->period, h = fmin(s->period, s->end - t) / s->parts;
        if (s->kind == RANDOM) { /* a new vector in the ball every period */
            unit_vector(&v.random, v.direction, n);
            const double size = pow(uniform(&v.random), 1.0 / n);
            for (int i = 0; i < n; i++) v.direction[i] *= size;
        }
        lost = k > 0 && lost < s->lost && uniform(&v.random) < 0.5 ? lost + 1 : 0;
        if (!lost) {
            for (int i = 0; i < size; i++) measured[i] = x[i] + (i < n ? s->noise : s->noise_v) * (2.0 * uniform(&v.random) - 1.0);
            status = step(t, measured, u);
            if (status != 0 && r->outside++ == 0) r->outside_at = t;
            for (int i = 0; i < n; i++) r->u[i] = fmax(r->u[i], fabs(u[i]));
            held_input *next = input_at(&q, q.count++);
            next->since = k > 0 ? t + s->latency : 0.0;
            memcpy(next->u, u, (size_t)n * sizeof *u);
            memcpy(next->sample, measured, (size_t)n * sizeof *measured);
        }
        if (trace != NULL) {
            disturb(&v, t, x, w);
            trace = write_row(trace, t, x, u, tube, w, status, n, s->order);
        }
        for (int part = 0; part < s->parts; part++) {
            const double now = t + part * h;
            drive(&v, now, h, &q, x);
            if (advance != NULL) advance(now, h);
            judge(s, now + h, x, tube, &v, r);
        }
    }
    if (trace != NULL) write_row(trace, s->end, x, u, tube, w, status, n, s->order);
    r->reached = inside(s->target, s->goals, x, n);
    memcpy(r->last, x, (size_t)n * sizeof *x);
}
