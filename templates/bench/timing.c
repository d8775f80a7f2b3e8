/* How long a controller takes: it is called once at every row of t and x, in order. Returns seconds a call. */
#define _POSIX_C_SOURCE 199309L
#include <time.h>

double time_steps(int (*step)(double t, const double *x, double *u), const double *rows, int n, int count);

double time_steps(int (*step)(double t, const double *x, double *u), const double *rows, int n, int count)
{
    struct timespec begin, end;
    double u[64];
    volatile double sum = 0.0; /* uses every result, so that no compiler removes a call */
    clock_gettime(CLOCK_MONOTONIC, &begin);
    for (int k = 0; k < count; k++) {
        const double *row = rows + (n + 1) * k;
        step(row[0], row + 1, u);
        sum += u[0];
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    return ((double)(end.tv_sec - begin.tv_sec) + 1e-9 * (double)(end.tv_nsec - begin.tv_nsec)) / count;
}
