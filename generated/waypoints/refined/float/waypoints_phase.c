/* waypoints_phase.c: which entry of the mission is being served. It is in waypoints.h; waypoints_control does not need it. */
#include "waypoints.h"

int waypoints_phase(waypoints_real t)
{
    int phase = 0;
    if (t < 7.03125F) {
        phase = 1;
    }
    else if (t < 18.0F) {
        phase = 2;
    }
    return phase;
}
