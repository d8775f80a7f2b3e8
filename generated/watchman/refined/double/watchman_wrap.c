/* watchman_wrap.c: time that never ends: from t_c on it is one cycle earlier. watchman_control does not need it. */
#include "watchman.h"

watchman_real watchman_wrap(watchman_real t)
{
    return (t < WATCHMAN_T_C) ? t : (t - WATCHMAN_CYCLE);
}

uint32_t watchman_wrap_tick(uint32_t tick)
{
    return (tick < WATCHMAN_TICKS) ? tick : (tick - WATCHMAN_CYCLE_TICKS);
}
