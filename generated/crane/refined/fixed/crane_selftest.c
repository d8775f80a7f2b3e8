/* crane_selftest.c: calls of crane_control with known results, for the board's boot. Optional. */
#include "crane.h"

#include <stdbool.h>

#ifndef CRANE_SELFTEST_94579429cb9a0d6c
#error "crane_selftest.c is of another design than crane.h"
#endif

/* Whether crane_control gives anything but this. Arguments and results are constants of the code: they take no memory. */
static bool crane_differs(uint32_t tick, int32_t x0, int32_t x1, int32_t v0, int32_t v1, int32_t u0, int32_t u1,
                          crane_status status)
{
    const int32_t x[CRANE_N] = { x0, x1 };
    const int32_t v[CRANE_N] = { v0, v1 };
    int32_t u[CRANE_N];
    const crane_status found = crane_control(tick, x, v, u);
    return (found != status) || (u[0] != u0) || (u[1] != u1);
}

int crane_selftest(void)
{
    if (crane_differs(37U, 127210, 136486, -2530, 4998, -5344336, -863316, CRANE_OK)) { return 1; }
    if (crane_differs(262U, 124587, 166971, 6336, 48980, -886840, 6991966, CRANE_OK)) { return 2; }
    if (crane_differs(487U, 157615, 246096, 52075, 101691, 7154910, 3474402, CRANE_OK)) { return 3; }
    if (crane_differs(712U, 241290, 387235, 106651, 150807, 3556216, -5222181, CRANE_OK)) { return 4; }
    if (crane_differs(937U, 388973, 581255, 157582, 170124, -5344336, -865168, CRANE_OK)) { return 5; }
    if (crane_differs(1162U, 595160, 747515, 197595, 123727, -885263, 6991966, CRANE_OK)) { return 6; }
    if (crane_differs(1387U, 831888, 858944, 202607, 84365, 7154910, 3474402, CRANE_OK)) { return 7; }
    if (crane_differs(1612U, 1031131, 928800, 161556, 41415, 3554507, -5222181, CRANE_OK)) { return 8; }
    if (crane_differs(1837U, 1186800, 951584, 116868, -12324, -5344336, -865168, CRANE_OK)) { return 9; }
    if (crane_differs(2062U, 1293393, 910981, 61260, -57321, -886840, 6990446, CRANE_OK)) { return 10; }
    if (crane_differs(2287U, 1334410, 861975, 11373, -13394, 7154910, 3474402, CRANE_OK)) { return 11; }
    if (crane_differs(2362U, 1330489, 862088, 4126, 3167, 3554507, -5222181, CRANE_OK)) { return 12; }
    if (crane_differs(300U, 48474, 103245, 17015, 61376, 25165824, 25165824, CRANE_OK)) { return 13; }
    if (crane_differs(900U, 438517, 618159, 144528, 175375, -25165824, -25165824, CRANE_OK)) { return 14; }
    if (crane_differs(1500U, 784286, 748053, 183287, 59200, 25165824, 25165824, CRANE_OUTSIDE_TUBE)) { return 15; }
    if (crane_differs(2100U, 1457204, 1057410, 55783, -50957, -25165824, -25165824, CRANE_OUTSIDE_TUBE)) { return 16; }
    if (crane_differs(0U, 127930, 135787, 5199, -2570, -5346049, -864283, CRANE_OK)) { return 17; }
    if (crane_differs(2400U, 1341620, 865893, -2600, -4624, -886840, 6990265, CRANE_OK)) { return 18; }
    if (crane_differs(4294967295U, 1337691, 858821, -4680, 2054, 7154910, 3474402, CRANE_OK)) { return 19; }
    if (crane_differs(800U, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, 25165824, 25165824, CRANE_OUTSIDE_TUBE)) { return 20; }
    if (crane_differs(800U, 2147483647, 2147483647, 2147483647, 2147483647, -25165824, -25165824, CRANE_OUTSIDE_TUBE)) { return 21; }
    return 0;
}
