/* either_phase.c: which entry of the mission is being served. either_control does not need it. */
#include "either.h"

int either_phase(either_real t)
{
    static const either_real until[1] = { 8.9296875 };
    static const int entry[1] = { 1 };
    int phase = 0;
    for (int k = 1 - 1; k >= 0; k--) {
        if (t < until[k]) {
            phase = entry[k];
        }
    }
    return phase;
}
