/* watchman_phase.c: which entry of the mission is being served. watchman_control does not need it. */
#include "watchman.h"

int watchman_phase(watchman_real t)
{
    return (t < 16.0F) ? 1 : 0;
}
