/* watchman_phase.c: which entry of the mission is being served. watchman_control does not need it. */
#include "watchman.h"

int watchman_phase(watchman_real t)
{
    static const watchman_real until[1] = { 16.0F };
    static const int entry[1] = { 1 };
    int phase = 0;
    for (int k = 1 - 1; k >= 0; k--) {
        if (t < until[k]) {
            phase = entry[k];
        }
    }
    return phase;
}
