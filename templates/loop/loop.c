/* The loop: classical Runge-Kutta steps between samples, halved until both halves agree with the whole; every state on the way
 * is judged. See loop.h. */
#include "loop.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define TOLERANCE 1e-12 /* of 1 + |x|, the difference of a step and its halves, 15 times the error that is left */
#define DEPTH 12
#define ROUNDS 200
#define CLOCKS 9 /* readings that are tried for the worst */

typedef struct {
    const loop_setting *s;
    uint64_t random;
    double direction[MOST]; /* unit vector, or the vector held over this period */
    double rate, phase;     /* of the sinusoid, rad/s and rad */
    double middle[STATE], half[STATE]; /* of the tube, and of the filtered one, at the last look */
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

static double size_of(const double *face, int n)
{
    double sum = 0.0;
    for (int i = 0; i < n; i++) sum += fabs(face[i]);
    return sum;
}

/* From x to the nearest point of a polytope, by Hildreth's method: each half-space in turn takes back what it pushed and pushes
 * anew. Boxes are done in one round; `way` is the whole push. Returns the distance, 0 inside. */
static double toward(const double *faces, int count, double growth, const double *x, double *way, int n)
{
    double pushed[FACES], y[MOST];
    memset(pushed, 0, (size_t)count * sizeof *pushed); /* of these alone: all of FACES cost more than the whole loop */
    memset(way, 0, (size_t)n * sizeof *way);
    memcpy(y, x, (size_t)n * sizeof *x);
    for (int round = 0; round < ROUNDS; round++) {
        double moved = 0.0;
        for (int f = 0; f < count; f++) {
            const double *face = faces + (n + 1) * f;
            const double out = growth > 0.0 ? growth * size_of(face, n) : 0.0; /* grown by a box */
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
    double turn[2 * MOST + 2] = {0.0, 1.0}, best = HUGE_VAL;
    int turns = 2;
    for (int i = 0; i < n; i++)
        for (int side = -1; side <= 1; side += 2) {
            const double t = (x[i] + side * half[i] - from[i]) / (to[i] - from[i]);
            if (t > 0.0 && t < 1.0) turn[turns++] = t;
        }
    for (int k = 1; k < turns; k++)
        for (int m = k; m > 0 && turn[m] < turn[m - 1]; m--) {
            const double other = turn[m];
            turn[m] = turn[m - 1], turn[m - 1] = other;
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
            double gaps[MOST];
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

/* Where a set is, and whether it is unsafe, at one reading of its clock. */
typedef struct {
    int unsafe;
    double growth, seen[MOST]; /* seen: x from where the set would be if it were not displaced */
} sight;

static int readings(const loop_setting *s, int j)
{
    return s->turn != NULL && s->clock == WORST && s->turn[j + 1] > s->turn[j] ? CLOCKS : 1;
}

static void look(const loop_setting *s, int j, int reading, double t, const double *x, sight *p)
{
    const int n = s->n;
    double by[MOST] = {0}, tau = t;
    p->unsafe = 1, p->growth = 0.0;
    memcpy(p->seen, x, (size_t)n * sizeof *x);
    if (s->turn == NULL || s->turn[j + 1] == s->turn[j]) return;
    const int first = s->turn[j], last = s->turn[j + 1] - 1;
    const double *hours = s->hours + 5 * j, *at = s->turns + (n + 1) * first;
    if (s->clock == EARLY) tau = t - hours[3];
    if (s->clock == LATE) tau = t + hours[4];
    if (s->clock == WORST) tau = t - hours[3] + reading * (hours[3] + hours[4]) / (CLOCKS - 1);
    p->unsafe = tau >= hours[0] && tau <= hours[1];
    p->growth = fmax(0.0, tau) * hours[2];
    memcpy(by, at + 1, (size_t)n * sizeof *by);
    for (int k = first; k < last; k++, at += n + 1) {
        const double *to = at + n + 1, share = fmin(1.0, (tau - at[0]) / (to[0] - at[0]));
        if (tau <= at[0]) break;
        for (int i = 0; i < n; i++) by[i] = at[1 + i] + share * (to[1 + i] - at[1 + i]);
    }
    for (int i = 0; i < n; i++) p->seen[i] = x[i] - by[i];
}

static double to_core(const loop_setting *s, int j, const sight *p, double *way)
{
    const int n = s->n;
    if (s->radius[j] > 0.0) return to_segment(s->ends + 3 * n * j, p->seen, way, n);
    return toward(s->faces + (n + 1) * s->first[j], s->first[j + 1] - s->first[j], p->growth, p->seen, way, n);
}

static void nearest(const loop_setting *s, double t, const double *x, double *w)
{
    const int n = s->n;
    double best = HUGE_VAL, way[MOST];
    sight p;
    for (int j = 0; j < s->sets; j++)
        for (int reading = 0; reading < readings(s, j); reading++) {
            look(s, j, reading, t, x, &p);
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

static int held_size(const loop_setting *s)
{
    return s->order * s->n;
}

static int state_size(const loop_setting *s) /* with what acts, where that lags */
{
    return held_size(s) + (s->lag > 0.0 ? s->n : 0);
}

/* What the tubes are about: x, and of order 2 then v + filter x. */
static void held_of(const loop_setting *s, const double *x, double *held)
{
    const int n = s->n;
    memcpy(held, x, (size_t)n * sizeof *x);
    if (s->order == 2)
        for (int i = 0; i < n; i++) held[n + i] = x[n + i] + s->filter[i] * x[i];
}

static void blow(const wind *v, double t, const double *x, double *w)
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
        double most = -1.0, held[STATE];
        held_of(s, x, held);
        for (int i = first; i < first + n; i++) {
            const double e = fabs(held[i] - v->middle[i]) / v->half[i];
            if (e > most) most = e, worst = i;
        }
        w[worst - first] = held[worst] < v->middle[worst] ? -1.0 : 1.0;
    }
    for (int i = 0; i < n; i++) w[i] *= s->strength * s->shares[i];
}

/* An input, x of the sample that it was made of, and since when it acts. */
typedef struct {
    double since, u[MOST], sample[MOST];
} held_input;

/* Inputs on their way, the oldest first: that one acts until the next one's time has come. */
typedef struct {
    held_input on_the_way[WAITING];
    int first, count;
} inputs;

static held_input *of_age(inputs *q, int k)
{
    return &q->on_the_way[(q->first + k) % WAITING];
}

static void rate_of(const wind *v, double t, const double *x, const held_input *acts, double *rate)
{
    const double *u = acts->u;
    const int n = v->s->n;
    double g[MOST * MOST], w[MOST], *turn = rate + (v->s->order - 1) * n;
    loop_plant(x, v->s->constants, acts->sample, turn, g);
    blow(v, t, x, w);
    if (v->s->lag > 0.0) {
        const int first = held_size(v->s);
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
    double whole[STATE], halves[STATE], worst = 0.0;
    memcpy(whole, x, (size_t)n * sizeof *x);
    runge_kutta(v, t, h, acts, whole);
    if (v->s->constant) { /* f and g do not change: one step is exact but for what w does */
        memcpy(x, whole, (size_t)n * sizeof *x);
        return;
    }
    memcpy(halves, x, (size_t)n * sizeof *x);
    runge_kutta(v, t, 0.5 * h, acts, halves);
    runge_kutta(v, t + 0.5 * h, 0.5 * h, acts, halves);
    for (int i = 0; i < n; i++) worst = fmax(worst, fabs(halves[i] - whole[i]) / (1.0 + fabs(halves[i])));
    if (depth == 0 || !(worst > TOLERANCE)) {
        for (int i = 0; i < n; i++) x[i] = halves[i] + (halves[i] - whole[i]) / 15.0;
        return;
    }
    integrate(v, t, 0.5 * h, acts, x, depth - 1);
    integrate(v, t + 0.5 * h, 0.5 * h, acts, x, depth - 1);
}

/* From `now` on over h: each input while it is its turn. */
static void drive(const wind *v, double now, double h, inputs *q, double *x)
{
    const double end = now + h;
    for (double at = now, left = h; left > 0.0; left = end - at) {
        while (q->count > 1 && of_age(q, 1)->since <= at) q->first = (q->first + 1) % WAITING, q->count--;
        const double step = q->count > 1 ? fmin(left, of_age(q, 1)->since - at) : left;
        integrate(v, at, step, of_age(q, 0), x, DEPTH);
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

/* The interior: touching an unsafe set is no collision, since sets may touch what is allowed. */
static int within(const loop_setting *s, int j, double t, const double *x)
{
    const int n = s->n;
    double way[MOST];
    sight p;
    for (int reading = 0; reading < readings(s, j); reading++) {
        int in = 1;
        look(s, j, reading, t, x, &p);
        if (!p.unsafe) continue;
        if (s->radius[j] > 0.0) in = to_core(s, j, &p, way) < s->radius[j] + p.growth;
        for (int f = s->first[j]; in && f < s->first[j + 1]; f++) {
            const double *face = s->faces + (n + 1) * f, out = p.growth > 0.0 ? p.growth * size_of(face, n) : 0.0;
            in = beyond(face, p.seen, n) < out;
        }
        if (in) return 1;
    }
    return 0;
}

static void judge(const loop_setting *s, double t, const double *x, loop_tube tube, wind *v, loop_result *r)
{
    const int n = s->n;
    double lower[STATE], upper[STATE], held[STATE];
    for (int j = 0; j < s->sets && r->hit < 0; j++)
        if (within(s, j, t, x)) r->hit = j, r->hit_at = t;
    if (!r->left && !inside(s->space, s->walls, x, n)) r->left = 1, r->left_at = t;
    if (tube == NULL) return;
    tube(t, lower, upper);
    held_of(s, x, held);
    for (int i = 0; i < held_size(s); i++) {
        const double width = upper[i] - lower[i], nearer = fmin(held[i] - lower[i], upper[i] - held[i]);
        v->middle[i] = 0.5 * (lower[i] + upper[i]);
        v->half[i] = width > 0.0 ? 0.5 * width : 1e-9;
        const double share = width > 0.0 ? nearer / width : -1.0, e = fabs(held[i] - v->middle[i]) / v->half[i];
        double *most = &r->e[i % n];
        r->margin = share >= r->margin ? r->margin : share == share ? share : -1.0; /* what is no number is outside */
        *most = e <= *most ? *most : e == e ? e : HUGE_VAL;
    }
}

static void start_wind(wind *v, const loop_setting *s)
{
    v->s = s;
    v->random = s->seed;
    unit_vector(&v->random, v->direction, s->n);
    v->rate = exp(log(0.5) + uniform(&v->random) * log(40.0)); /* 0.5 to 20 rad/s */
    v->phase = 6.283185307179586 * uniform(&v->random);
    held_of(s, s->start, v->middle);
    for (int i = 0; i < held_size(s); i++) v->half[i] = 1.0;
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
    const int n = s->n, size = held_size(s);
    wind v;
    double x[STATE] = {0}, seen[STATE], u[MOST] = {0}, w[MOST] = {0};
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
            for (int i = 0; i < size; i++) seen[i] = x[i] + (i < n ? s->noise : s->noise_v) * (2.0 * uniform(&v.random) - 1.0);
            status = step(t, seen, u);
            if (status != 0 && r->outside++ == 0) r->outside_at = t;
            for (int i = 0; i < n; i++) r->u[i] = fmax(r->u[i], fabs(u[i]));
            held_input *made = of_age(&q, q.count++);
            made->since = k > 0 ? t + s->latency : 0.0;
            memcpy(made->u, u, (size_t)n * sizeof *u);
            memcpy(made->sample, seen, (size_t)n * sizeof *seen);
        }
        if (trace != NULL) {
            blow(&v, t, x, w);
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
