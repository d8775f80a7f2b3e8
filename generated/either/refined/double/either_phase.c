/* either_phase.c: which entry of the mission is being served. It is in either.h; either_control does not need it. */
#include "either.h"

int either_phase(either_real t)
{
    int phase = 0;
    if (t < 9.000274658203125) {
        phase = 1;
    }
    return phase;
}
