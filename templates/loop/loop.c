/* The loop: classical Runge-Kutta steps between samples, halved until both halves agree with the full step; every state on the
 * way is judged. See loop.h. */
#include "loop.h"

#include <math.h>
#include <stddef.h>
#include <string.h>

#define TOLERANCE 1e-12 /* times 1 + |x|: allowed difference of a step and its two halves, which is 15 times the error of the halves */
#define MAX_HALVINGS 12 /* of a step */
#define PROJECTION_ROUNDS 200 /* of Hildreth's method */
#define CLOCKS 9 /* readings that WORST tries, evenly from EARLY to LATE */

typedef struct {
    const loop_setting *s;
    uint64_t random;
    double direction[MAX_DIMENSIONS]; /* unit vector, or the vector held over this period */
    double rate, phase;     /* of the sinusoid, rad/s and rad */
    double middle[STATE], half[STATE]; /* of the tube and the filtered tube, at the last judged time */
    double e[MAX_DIMENSIONS], push[MAX_DIMENSIONS]; /* e_i at that time, and 1 or -1: where an adversary pushes component i */
    double ramp_time, ramp[MAX_DIMENSIONS]; /* what a limited rate has made of u at a time */
    double smallest_u[MAX_DIMENSIONS], largest_u[MAX_DIMENSIONS]; /* of all commands so far, with 0 before the first */
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

static double signed_distance(const double *face, const double *x, int n) /* to the half-space of a face; negative inside */
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

/* Finds the point of a polytope that is nearest to x, by Hildreth's method: each half-space takes back its last push and pushes again,
 * one half-space after the other. A box takes one round. Writes the vector from x to the point. Returns the distance, 0 inside. */
static double to_polytope(const double *faces, int count, double growth, const double *x, double *to_nearest, int n)
{
    double pushed[MAX_FACES], y[MAX_DIMENSIONS];
    memset(pushed, 0, (size_t)count * sizeof *pushed); /* not all of MAX_FACES, which takes longer than the rest of the loop */
    memset(to_nearest, 0, (size_t)n * sizeof *to_nearest);
    memcpy(y, x, (size_t)n * sizeof *x);
    for (int round = 0; round < PROJECTION_ROUNDS; round++) {
        double moved = 0.0;
        for (int f = 0; f < count; f++) {
            const double *face = faces + (n + 1) * f;
            const double enlargement = growth > 0.0 ? growth * one_norm_of(face, n) : 0.0; /* grown by a box */
            const double push = fmax(0.0, pushed[f] + (signed_distance(face, y, n) - enlargement)), change = push - pushed[f];
            for (int i = 0; i < n; i++) y[i] -= change * face[i];
            pushed[f] = push;
            moved = fmax(moved, fabs(change));
        }
        if (moved <= 1e-12) break;
    }
    for (int i = 0; i < n; i++) to_nearest[i] = y[i] - x[i];
    return norm_of(to_nearest, n);
}

/* Finds the point that is nearest to x in a segment with a box about each of its points. Along the segment the square of the distance
 * is convex. It consists of parabolas, which meet at breakpoints: there a coordinate of x is at an edge of the box. Writes the vector
 * from x to the point. Returns the distance, 0 inside. */
static double to_segment(const double *ends, const double *x, double *to_nearest, int n)
{
    const double *from = ends, *to = ends + n, *half = ends + 2 * n;
    double breakpoints[2 * MAX_DIMENSIONS + 2] = {0.0, 1.0}, best = HUGE_VAL;
    int breakpoint_count = 2;
    for (int i = 0; i < n; i++)
        for (int side = -1; side <= 1; side += 2) {
            const double t = (x[i] + side * half[i] - from[i]) / (to[i] - from[i]);
            if (t > 0.0 && t < 1.0) breakpoints[breakpoint_count++] = t;
        }
    for (int k = 1; k < breakpoint_count; k++)
        for (int m = k; m > 0 && breakpoints[m] < breakpoints[m - 1]; m--) {
            const double larger = breakpoints[m - 1];
            breakpoints[m - 1] = breakpoints[m], breakpoints[m] = larger;
        }
    for (int k = 0; k + 1 < breakpoint_count; k++) {
        double slope = 0.0, bend = 0.0, candidates[3] = {breakpoints[k], breakpoints[k + 1], breakpoints[k]};
        const double middle = 0.5 * (breakpoints[k] + breakpoints[k + 1]);
        for (int i = 0; i < n; i++) { /* the side of the box on which x is does not change between two breakpoints */
            const double gap = from[i] + middle * (to[i] - from[i]) - x[i];
            const double side = gap > half[i] ? 1.0 : gap < -half[i] ? -1.0 : 0.0, step = to[i] - from[i];
            if (side != 0.0) slope += (gap - side * half[i]) * step, bend += step * step;
        }
        if (bend > 0.0) candidates[2] = fmin(fmax(middle - slope / bend, breakpoints[k]), breakpoints[k + 1]);
        for (int p = 0; p < 3; p++) {
            double gaps[MAX_DIMENSIONS];
            for (int i = 0; i < n; i++) {
                const double gap = from[i] + candidates[p] * (to[i] - from[i]) - x[i];
                gaps[i] = gap > half[i] ? gap - half[i] : gap < -half[i] ? gap + half[i] : 0.0;
            }
            const double distance = norm_of(gaps, n);
            if (distance < best) {
                best = distance;
                memcpy(to_nearest, gaps, (size_t)n * sizeof *to_nearest);
            }
        }
    }
    return best;
}

/* A set at one reading of its clock. unsafe: 1 in its active interval; relative_x: x minus the displacement of the set. */
typedef struct {
    int unsafe;
    double growth, relative_x[MAX_DIMENSIONS];
} set_state;

static int readings(const loop_setting *s, int j) /* of the clock of set j that are tried */
{
    return s->knot_range_starts != NULL && s->clock == WORST && s->knot_range_starts[j + 1] > s->knot_range_starts[j] ? CLOCKS : 1;
}

/* Writes the state of set j for a controller that is at x at time t. */
static void set_state_at(const loop_setting *s, int j, int reading, double t, const double *x, set_state *p)
{
    const int n = s->n;
    double displacement[MAX_DIMENSIONS] = {0}, tau = t;
    p->unsafe = 1, p->growth = 0.0;
    memcpy(p->relative_x, x, (size_t)n * sizeof *x);
    if (s->knot_range_starts == NULL || s->knot_range_starts[j + 1] == s->knot_range_starts[j]) return;
    const int first = s->knot_range_starts[j], last = s->knot_range_starts[j + 1] - 1;
    const double *clock_row = s->activity_and_clock + 5 * j, *knot = s->knots + (n + 1) * first;
    if (s->clock == EARLY) tau = t - clock_row[3];
    if (s->clock == LATE) tau = t + clock_row[4];
    if (s->clock == WORST) tau = t - clock_row[3] + reading * (clock_row[3] + clock_row[4]) / (CLOCKS - 1);
    p->unsafe = tau >= clock_row[0] && tau <= clock_row[1];
    p->growth = fmax(0.0, tau) * clock_row[2];
    memcpy(displacement, knot + 1, (size_t)n * sizeof *displacement);
    for (int k = first; k < last; k++, knot += n + 1) {
        const double *next_knot = knot + n + 1, fraction = fmin(1.0, (tau - knot[0]) / (next_knot[0] - knot[0]));
        if (tau <= knot[0]) break;
        for (int i = 0; i < n; i++) displacement[i] = knot[1 + i] + fraction * (next_knot[1 + i] - knot[1 + i]);
    }
    for (int i = 0; i < n; i++) p->relative_x[i] = x[i] - displacement[i];
}

/* Writes the vector from x to the nearest point of the core of set j. Returns the distance, 0 inside. */
static double to_core(const loop_setting *s, int j, const set_state *p, double *to_nearest)
{
    const int n = s->n;
    if (s->radius[j] > 0.0) return to_segment(s->segments + 3 * n * j, p->relative_x, to_nearest, n);
    const int first = s->face_range_starts[j], count = s->face_range_starts[j + 1] - first;
    return to_polytope(s->faces + (n + 1) * first, count, p->growth, p->relative_x, to_nearest, n);
}

/* Writes the unit vector toward the nearest unsafe set or wall. */
static void nearest(const loop_setting *s, double t, const double *x, double *w)
{
    const int n = s->n;
    double best = HUGE_VAL, to_nearest[MAX_DIMENSIONS];
    set_state p;
    for (int j = 0; j < s->sets; j++)
        for (int reading = 0; reading < readings(s, j); reading++) {
            set_state_at(s, j, reading, t, x, &p);
            if (!p.unsafe) continue;
            const double core = to_core(s, j, &p, to_nearest);
            const double distance = s->radius[j] > 0.0 ? core - s->radius[j] - p.growth : core;
            if (distance > 0.0 && distance < best) {
                best = distance;
                for (int i = 0; i < n; i++) w[i] = to_nearest[i] / core;
            }
        }
    for (int f = 0; f < s->space_face_count; f++) {
        const double *wall = s->space_faces + (n + 1) * f, distance = -signed_distance(wall, x, n);
        if (distance < best) {
            best = distance;
            memcpy(w, wall, (size_t)n * sizeof *w);
        }
    }
}

static int tube_size(const loop_setting *s) /* coordinates of all tubes */
{
    return s->order * s->n;
}

static int state_size(const loop_setting *s) /* with the outputs of both lags */
{
    return tube_size(s) + (s->drives != NULL ? 2 * s->n : 0);
}

/* Writes the quantities that the tubes bound: x, and of order 2 then v + filter x. */
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
    if (s->disturbance_kind == CONSTANT || s->disturbance_kind == RANDOM) memcpy(w, v->direction, (size_t)n * sizeof *w);
    if (s->disturbance_kind == SINUSOIDAL)
        for (int i = 0; i < n; i++) w[i] = v->direction[i] * sin(v->rate * t + v->phase);
    if (s->disturbance_kind == NEAREST) nearest(s, t, x, w);
    if (s->disturbance_kind == OUTWARD || s->disturbance_kind == MOTION) { /* along the axis that is nearest to an edge */
        const int first = (s->order - 1) * n;
        int worst = first;
        double largest_e = -1.0, coordinates[STATE];
        tube_coordinates(s, x, coordinates);
        for (int i = first; i < first + n; i++) {
            const double e = fabs(coordinates[i] - v->middle[i]) / v->half[i];
            if (e > largest_e) largest_e = e, worst = i;
        }
        w[worst - first] = coordinates[worst] < v->middle[worst] ? -1.0 : 1.0;
        if (s->disturbance_kind == MOTION) w[worst - first] = v->push[worst - first];
    }
    for (int i = 0; i < n; i++) w[i] *= s->w_max * s->w_ratios[i];
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

/* What a limited rate makes of component i of u at time t. It reaches u and never passes it. */
static double ramp_at(const wind *v, int i, double u, double t)
{
    const double slew = v->s->drives[DRIVE_COLUMNS * i + 2], largest = slew * fmax(0.0, t - v->ramp_time), gap = u - v->ramp[i];
    return slew > 0.0 && fabs(gap) > largest ? v->ramp[i] + (gap < 0.0 ? -largest : largest) : u;
}

/* Writes what acts of u at time t, and the derivatives of both lags of each component, which follow x and v in the state. */
static void answer_of_drives(const wind *v, double t, const double *x, const double *u, double *acting, double *rate)
{
    const int n = v->s->n, first = tube_size(v->s);
    for (int i = 0; i < n; i++) {
        const double *drive = v->s->drives + DRIVE_COLUMNS * i, *lagging = x + first + i;
        double source = ramp_at(v, i, u[i], t);
        for (int k = 0; k < 2; k++) {
            rate[first + k * n + i] = drive[k] > 0.0 ? (source - lagging[k * n]) / drive[k] : 0.0;
            source = drive[k] > 0.0 ? lagging[k * n] : source;
        }
        acting[i] = source + drive[3] * (source - (v->push[i] > 0.0 ? v->smallest_u[i] : v->largest_u[i]));
    }
}

/* Moves the outputs of adverse drives at time t to what they follow, where that is in the direction of the push. */
static void jump_drives(wind *v, double t, double *x, const double *u)
{
    const int n = v->s->n, first = tube_size(v->s);
    for (int i = 0; i < n; i++) {
        double source = ramp_at(v, i, u[i], t);
        if ((u[i] - source) * v->push[i] > 0.0) source = v->ramp[i] = u[i];
        for (int k = 0; k < 2; k++) {
            double *lagging = x + first + k * n + i;
            if (v->s->drives[DRIVE_COLUMNS * i + k] > 0.0 && (source - *lagging) * v->push[i] > 0.0) *lagging = source;
            source = v->s->drives[DRIVE_COLUMNS * i + k] > 0.0 ? *lagging : source;
        }
    }
}

/* Begins a step at time t: what the limited rate has made of u so far is stored. */
static void move_ramps(wind *v, double t, const double *u)
{
    double reached[MAX_DIMENSIONS];
    for (int i = 0; i < v->s->n; i++) reached[i] = ramp_at(v, i, u[i], t);
    memcpy(v->ramp, reached, (size_t)v->s->n * sizeof *reached);
    v->ramp_time = t;
}

/* Writes the derivative of the state. */
static void rate_of(const wind *v, double t, const double *x, const held_input *acts, double *rate)
{
    const double *u = acts->u;
    const int n = v->s->n;
    double g[MAX_DIMENSIONS * MAX_DIMENSIONS], w[MAX_DIMENSIONS], acting[MAX_DIMENSIONS], *highest_rate = rate + (v->s->order - 1) * n;
    loop_plant(x, v->s->plant_constants, acts->sample, highest_rate, g);
    disturb(v, t, x, w);
    if (v->s->drives != NULL) {
        answer_of_drives(v, t, x, u, acting, rate);
        u = acting;
    }
    for (int i = 0; i < n; i++) {
        if (v->s->order == 2) rate[i] = x[n + i];
        highest_rate[i] += w[i];
        for (int j = 0; j < n; j++) highest_rate[i] += g[i + n * j] * u[j];
    }
}

static void runge_kutta(const wind *v, double t, double h, const held_input *acts, double *x)
{
    static const double stage_fraction[4] = {0.0, 0.5, 0.5, 1.0}, weight[4] = {1.0 / 6, 1.0 / 3, 1.0 / 3, 1.0 / 6};
    const int n = state_size(v->s);
    double k[STATE] = {0}, y[STATE], sum[STATE] = {0};
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < n; i++) y[i] = x[i] + stage_fraction[stage] * h * k[i];
        rate_of(v, t + stage_fraction[stage] * h, y, acts, k);
        for (int i = 0; i < n; i++) sum[i] += weight[stage] * k[i];
    }
    for (int i = 0; i < n; i++) x[i] += h * sum[i];
}

/* Integrates over h. Where one step and two half steps differ by more than TOLERANCE, each half is integrated by itself. */
static void integrate(const wind *v, double t, double h, const held_input *acts, double *x, int depth)
{
    const int n = state_size(v->s);
    double full[STATE], halves[STATE], worst = 0.0;
    memcpy(full, x, (size_t)n * sizeof *x);
    runge_kutta(v, t, h, acts, full);
    if (v->s->has_constant_dynamics) { /* f and g do not depend on x: only the change of w makes an error in one step */
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
static void drive(wind *v, double now, double h, inputs *q, double *x)
{
    const double end = now + h;
    for (double at = now, left = h; left > 0.0; left = end - at) {
        while (q->count > 1 && input_at(q, 1)->since <= at) q->first = (q->first + 1) % MAX_PENDING, q->count--;
        const double step = q->count > 1 ? fmin(left, input_at(q, 1)->since - at) : left;
        const double *u = input_at(q, 0)->u;
        if (v->s->drives != NULL) {
            for (int i = 0; i < v->s->n; i++) {
                v->smallest_u[i] = fmin(v->smallest_u[i], u[i]);
                v->largest_u[i] = fmax(v->largest_u[i], u[i]);
            }
            if (v->s->is_adverse) jump_drives(v, at, x, u);
        }
        integrate(v, at, step, input_at(q, 0), x, MAX_HALVINGS);
        if (v->s->drives != NULL) move_ramps(v, at + step, u);
        if (step == left) return;
        at += step;
    }
}

static int inside(const double *faces, int count, const double *x, int n)
{
    for (int f = 0; f < count; f++)
        if (!(signed_distance(faces + (n + 1) * f, x, n) <= 0.0)) return 0;
    return 1;
}

/* Whether x is in the interior of set j. Touching an unsafe set is no collision, since the start or the target may touch it. */
static int collides(const loop_setting *s, int j, double t, const double *x)
{
    const int n = s->n;
    double to_nearest[MAX_DIMENSIONS];
    set_state p;
    for (int reading = 0; reading < readings(s, j); reading++) {
        int in = 1;
        set_state_at(s, j, reading, t, x, &p);
        if (!p.unsafe) continue;
        if (s->radius[j] > 0.0) in = to_core(s, j, &p, to_nearest) < s->radius[j] + p.growth;
        for (int f = s->face_range_starts[j]; in && f < s->face_range_starts[j + 1]; f++) {
            const double *face = s->faces + (n + 1) * f, enlargement = p.growth > 0.0 ? p.growth * one_norm_of(face, n) : 0.0;
            in = signed_distance(face, p.relative_x, n) < enlargement;
        }
        if (in) return 1;
    }
    return 0;
}

/* Updates the result r by the state at time t, and in v the tube that the disturbance OUTWARD needs. */
static void judge(const loop_setting *s, double t, const double *x, loop_tube tube, wind *v, loop_result *r)
{
    const int n = s->n;
    double lower[STATE], upper[STATE], coordinates[STATE];
    for (int j = 0; j < s->sets && r->hit < 0; j++)
        if (collides(s, j, t, x)) r->hit = j, r->hit_at = t;
    if (!r->left && !inside(s->space_faces, s->space_face_count, x, n)) r->left = 1, r->left_at = t;
    if (tube == NULL) return;
    tube(t, lower, upper);
    tube_coordinates(s, x, coordinates);
    for (int i = 0; i < tube_size(s); i++) {
        const double width = upper[i] - lower[i], nearer = fmin(coordinates[i] - lower[i], upper[i] - coordinates[i]);
        v->middle[i] = 0.5 * (lower[i] + upper[i]);
        v->half[i] = width > 0.0 ? 0.5 * width : 1e-9;
        const double distance_ratio = width > 0.0 ? nearer / width : -1.0, e = fabs(coordinates[i] - v->middle[i]) / v->half[i];
        double *largest_e = &r->e[i % n];
        /* NaN counts as outside */
        if (i >= tube_size(s) - n) { /* the tube that u acts on */
            const double before = v->e[i % n], side = coordinates[i] - v->middle[i];
            v->e[i % n] = side / v->half[i];
            if (s->disturbance_kind != MOTION) v->push[i % n] = side < 0.0 ? -1.0 : 1.0;
            else if (v->e[i % n] != before) v->push[i % n] = v->e[i % n] < before ? -1.0 : 1.0;
        }
        r->margin = distance_ratio >= r->margin ? r->margin : distance_ratio == distance_ratio ? distance_ratio : -1.0;
        *largest_e = e <= *largest_e ? *largest_e : e == e ? e : HUGE_VAL;
    }
}

static void start_wind(wind *v, const loop_setting *s)
{
    memset(v, 0, sizeof *v);
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
    const double *vectors[6] = {x, u, edges[0], edges[1], w, x + n};
    *row++ = t;
    for (int p = 0; p < 4 + order; p++)
        for (int i = 0; i < n; i++) *row++ = vectors[p][i];
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
    if (s->is_adverse && s->latency > 0.0) memset(input_at(&q, q.count++), 0, sizeof(held_input)); /* u is 0 until the first acts */
    r->hit = -1, r->hit_at = r->left_at = r->outside_at = -1.0, r->margin = 0.5;
    start_wind(&v, s);
    memcpy(x, s->start, (size_t)size * sizeof *x);
    judge(s, 0.0, x, tube, &v, r);
    for (int k = 0; k < s->samples; k++) {
        const double t = k * s->period, h = fmin(s->period, s->end - t) / s->integration_steps;
        if (s->disturbance_kind == RANDOM) { /* a new vector in the ball every period */
            unit_vector(&v.random, v.direction, n);
            const double size = pow(uniform(&v.random), 1.0 / n);
            for (int i = 0; i < n; i++) v.direction[i] *= size;
        }
        lost = k > 0 && lost < s->max_lost_samples && uniform(&v.random) < 0.5 ? lost + 1 : 0;
        if (!lost) {
            for (int i = 0; i < size; i++) measured[i] = x[i] + s->measurement_errors[i] * (2.0 * uniform(&v.random) - 1.0);
            status = step(t, measured, u);
            if (status != 0 && r->outside++ == 0) r->outside_at = t;
            for (int i = 0; i < n; i++) r->u[i] = fmax(r->u[i], fabs(u[i]));
            held_input *next = input_at(&q, q.count++);
            next->since = k > 0 || s->is_adverse ? t + s->latency : 0.0;
            memcpy(next->u, u, (size_t)n * sizeof *u);
            memcpy(next->sample, measured, (size_t)n * sizeof *measured);
        }
        if (trace != NULL) {
            disturb(&v, t, x, w);
            trace = write_row(trace, t, x, u, tube, w, status, n, s->order);
        }
        for (int integration_step = 0; integration_step < s->integration_steps; integration_step++) {
            const double now = t + integration_step * h;
            drive(&v, now, h, &q, x);
            if (advance != NULL) advance(now, h);
            judge(s, now + h, x, tube, &v, r);
        }
    }
    if (trace != NULL) write_row(trace, s->end, x, u, tube, w, status, n, s->order);
    r->reached = inside(s->target_faces, s->target_face_count, x, n);
    memcpy(r->last, x, (size_t)n * sizeof *x);
}
