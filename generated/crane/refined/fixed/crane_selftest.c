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
    if (crane_differs(0U, 127930, 135787, 5199, -2570, -5346049, -864283, CRANE_OK)) { return 13; }
    if (crane_differs(2400U, 1341620, 865893, -2600, -4624, -886840, 6990265, CRANE_OK)) { return 14; }
    if (crane_differs(4294967295U, 1337691, 858821, -4680, 2054, 7154910, 3474402, CRANE_OK)) { return 15; }
    if (crane_differs(300U, 48474, 103245, 17015, 61376, 25165824, 25165824, CRANE_OK)) { return 16; }
    if (crane_differs(900U, 438517, 618159, 144528, 175375, -25165824, -25165824, CRANE_OK)) { return 17; }
    if (crane_differs(1500U, 784286, 748053, 183287, 59200, 25165824, 25165824, CRANE_OUTSIDE_TUBE)) { return 18; }
    if (crane_differs(2100U, 1457204, 1057410, 55783, -50957, -25165824, -25165824, CRANE_OUTSIDE_TUBE)) { return 19; }
    if (crane_differs(1987U, 1261744, 928044, 55416, 5922, 25165824, -25165824, CRANE_OK)) { return 20; }
    if (crane_differs(1987U, 1261744, 928044, 58666, 5521, 25165824, -25165824, CRANE_OK)) { return 21; }
    if (crane_differs(1987U, 1261744, 928044, 61915, 5119, 25165824, -25165824, CRANE_OK)) { return 22; }
    if (crane_differs(1987U, 1261744, 928044, 65164, 4718, 25165824, -25165824, CRANE_OK)) { return 23; }
    if (crane_differs(1987U, 1261744, 928044, 68414, 9234, 20703639, -25165824, CRANE_OK)) { return 24; }
    if (crane_differs(1987U, 1261744, 928044, 71663, 9033, 14317699, -25165824, CRANE_OK)) { return 25; }
    if (crane_differs(1987U, 1261744, 928044, 74912, 8832, 8411806, -25165824, CRANE_OK)) { return 26; }
    if (crane_differs(1987U, 1261744, 928044, 78162, 8632, 2774675, -25165824, CRANE_OK)) { return 27; }
    if (crane_differs(1987U, 1261744, 928044, 41607, 8431, 25165824, -25165824, CRANE_OK)) { return 28; }
    if (crane_differs(1987U, 1261744, 928044, 43231, 8230, 25165824, -25165824, CRANE_OK)) { return 29; }
    if (crane_differs(1987U, 1261744, 928044, 44856, 8030, 25165824, -25165824, CRANE_OK)) { return 30; }
    if (crane_differs(1987U, 1261744, 928044, 46481, 7829, 25165824, -25165824, CRANE_OK)) { return 31; }
    if (crane_differs(1987U, 1261744, 928044, 48105, 10087, 25165824, -25165824, CRANE_OK)) { return 32; }
    if (crane_differs(1987U, 1261744, 928044, 49730, 9987, 25165824, -25165824, CRANE_OK)) { return 33; }
    if (crane_differs(1987U, 1261744, 928044, 51355, 9886, 25165824, -25165824, CRANE_OK)) { return 34; }
    if (crane_differs(1987U, 1261744, 928044, 52979, 9786, 25165824, -25165824, CRANE_OK)) { return 35; }
    if (crane_differs(1987U, 1261744, 928044, 34702, 9686, 25165824, -25165824, CRANE_OK)) { return 36; }
    if (crane_differs(1987U, 1261744, 928044, 35514, 9585, 25165824, -25165824, CRANE_OK)) { return 37; }
    if (crane_differs(1987U, 1261744, 928044, 36327, 9485, 25165824, -25165824, CRANE_OK)) { return 38; }
    if (crane_differs(1987U, 1261744, 928044, 37139, 9384, 25165824, -25165824, CRANE_OK)) { return 39; }
    if (crane_differs(1987U, 1261744, 928044, 37951, 10513, 25165824, -25165824, CRANE_OK)) { return 40; }
    if (crane_differs(1987U, 1261744, 928044, 38764, 10463, 25165824, -25165824, CRANE_OK)) { return 41; }
    if (crane_differs(1987U, 1261744, 928044, 39576, 10413, 25165824, -25165824, CRANE_OK)) { return 42; }
    if (crane_differs(1987U, 1261744, 928044, 40388, 10363, 25165824, -25165824, CRANE_OK)) { return 43; }
    if (crane_differs(1987U, 1261744, 928044, 31249, 10313, 25165824, -25165824, CRANE_OK)) { return 44; }
    if (crane_differs(1987U, 1261744, 928044, 31656, 10263, 25165824, -25165824, CRANE_OK)) { return 45; }
    if (crane_differs(1987U, 1261744, 928044, 32062, 10212, 25165824, -25165824, CRANE_OK)) { return 46; }
    if (crane_differs(1987U, 1261744, 928044, 32468, 10162, 25165824, -25165824, CRANE_OK)) { return 47; }
    if (crane_differs(1987U, 1261744, 928044, 32874, -16357, 25165824, -25165824, CRANE_OK)) { return 48; }
    if (crane_differs(1987U, 1261744, 928044, 33280, -19569, 25165824, -25165824, CRANE_OK)) { return 49; }
    if (crane_differs(1987U, 1261744, 928044, 33686, -22780, 25165824, -25165824, CRANE_OK)) { return 50; }
    if (crane_differs(1987U, 1261744, 928044, 34093, -25992, 25165824, -25165824, CRANE_OK)) { return 51; }
    if (crane_differs(1987U, 1261744, 928044, 29523, -29203, 25165824, -20228060, CRANE_OK)) { return 52; }
    if (crane_differs(1987U, 1261744, 928044, 29726, -32414, 25165824, -13988819, CRANE_OK)) { return 53; }
    if (crane_differs(1987U, 1261744, 928044, 29929, -35626, 25165824, -8216644, CRANE_OK)) { return 54; }
    if (crane_differs(1987U, 1261744, 928044, 30132, -38837, 25165824, -2710944, CRANE_OK)) { return 55; }
    if (crane_differs(1987U, 1261744, 928044, 30336, -2709, 25165824, -25165824, CRANE_OK)) { return 56; }
    if (crane_differs(1987U, 1261744, 928044, 30539, -4314, 25165824, -25165824, CRANE_OK)) { return 57; }
    if (crane_differs(1987U, 1261744, 928044, 30742, -5920, 25165824, -25165824, CRANE_OK)) { return 58; }
    if (crane_differs(1987U, 1261744, 928044, 30945, -7526, 25165824, -25165824, CRANE_OK)) { return 59; }
    if (crane_differs(1987U, 1261744, 928044, 28660, -9131, 25165824, -25165824, CRANE_OK)) { return 60; }
    if (crane_differs(1987U, 1261744, 928044, 28762, -10737, 25165824, -25165824, CRANE_OK)) { return 61; }
    if (crane_differs(1987U, 1261744, 928044, 28863, -12343, 25165824, -25165824, CRANE_OK)) { return 62; }
    if (crane_differs(1987U, 1261744, 928044, 28965, -13949, 25165824, -25165824, CRANE_OK)) { return 63; }
    if (crane_differs(1987U, 1261744, 928044, 29066, 4116, 25165824, -25165824, CRANE_OK)) { return 64; }
    if (crane_differs(1987U, 1261744, 928044, 29168, 3313, 25165824, -25165824, CRANE_OK)) { return 65; }
    if (crane_differs(1987U, 1261744, 928044, 29269, 2510, 25165824, -25165824, CRANE_OK)) { return 66; }
    if (crane_differs(1987U, 1261744, 928044, 29371, 1707, 25165824, -25165824, CRANE_OK)) { return 67; }
    if (crane_differs(1987U, 1261744, 928044, 28229, 904, 25165824, -25165824, CRANE_OK)) { return 68; }
    if (crane_differs(1987U, 1261744, 928044, 28279, 101, 25165824, -25165824, CRANE_OK)) { return 69; }
    if (crane_differs(1987U, 1261744, 928044, 28330, -701, 25165824, -25165824, CRANE_OK)) { return 70; }
    if (crane_differs(1987U, 1261744, 928044, 28381, -1504, 25165824, -25165824, CRANE_OK)) { return 71; }
    if (crane_differs(1987U, 1261744, 928044, 28432, 7528, 25165824, -25165824, CRANE_OK)) { return 72; }
    if (crane_differs(1987U, 1261744, 928044, 28482, 7126, 25165824, -25165824, CRANE_OK)) { return 73; }
    if (crane_differs(1987U, 1261744, 928044, 28533, 6725, 25165824, -25165824, CRANE_OK)) { return 74; }
    if (crane_differs(1987U, 1261744, 928044, 28584, 6324, 25165824, -25165824, CRANE_OK)) { return 75; }
    if (crane_differs(0U, 127930, 135787, 5199, -2570, -5346049, -864283, CRANE_OK)) { return 76; }
    if (crane_differs(1200U, 547530, 688657, 262345, 174006, 852, 842, CRANE_OUTSIDE_TUBE)) { return 77; }
    if (crane_differs(1200U, 710975, 852101, 154206, 67145, 852, 842, CRANE_OUTSIDE_TUBE)) { return 78; }
    if (crane_differs(1200U, 629253, 770379, 154210, 67145, 25165824, 25165824, CRANE_OUTSIDE_TUBE)) { return 79; }
    if (crane_differs(1200U, 629253, 770379, 262340, 174007, -25165824, -25165824, CRANE_OUTSIDE_TUBE)) { return 80; }
    if (crane_differs(800U, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, 25165824, 25165824, CRANE_OUTSIDE_TUBE)) { return 81; }
    if (crane_differs(800U, 2147483647, 2147483647, 2147483647, 2147483647, -25165824, -25165824, CRANE_OUTSIDE_TUBE)) { return 82; }
    return 0;
}
