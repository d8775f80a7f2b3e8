/* courier_phase.c: which entry of the mission is being served. courier_control does not need it. */
#include "courier.h"

int courier_phase(courier_real t)
{
    static const courier_real until[3] = { 9.7734375F, 13.130859F, 16.945312F };
    static const int entry[3] = { 1, 3, 1 };
    int phase = 0;
    for (int k = 3 - 1; k >= 0; k--) {
        if (t < until[k]) {
            phase = entry[k];
        }
    }
    return phase;
}
