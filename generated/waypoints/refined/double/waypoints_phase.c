/* waypoints_phase.c: which entry of the mission is being served. waypoints_control does not need it. */
#include "waypoints.h"

int waypoints_phase(waypoints_real t)
{
    static const waypoints_real until[2] = { 7.03271484375, 18.0 };
    static const int entry[2] = { 1, 2 };
    int phase = 0;
    for (int k = 2 - 1; k >= 0; k--) {
        if (t < until[k]) {
            phase = entry[k];
        }
    }
    return phase;
}
