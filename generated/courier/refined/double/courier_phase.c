/* courier_phase.c: which entry of the mission is being served. It is in courier.h; courier_control does not need it. */
#include "courier.h"

int courier_phase(courier_real t)
{
    int phase = 0;
    if (t < 9.703125) {
        phase = 1;
    }
    else if (t < 13.1253662109375) {
        phase = 3;
    }
    else if (t < 19.1722412109375) {
        phase = 1;
    }
    return phase;
}
