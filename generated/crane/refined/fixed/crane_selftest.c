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
    if (crane_differs(37U, 127210, 136486, -2530, 4998, -697610, -112607, CRANE_OK)) { return 1; }
    if (crane_differs(262U, 124587, 166971, 6336, 48980, -115761, 912001, CRANE_OK)) { return 2; }
    if (crane_differs(487U, 157615, 246096, 52075, 101691, 933950, 453185, CRANE_OK)) { return 3; }
    if (crane_differs(712U, 241290, 387235, 106651, 150807, 464202, -681158, CRANE_OK)) { return 4; }
    if (crane_differs(937U, 388973, 581255, 157582, 170124, -697610, -112848, CRANE_OK)) { return 5; }
    if (crane_differs(1162U, 595160, 747515, 197595, 123727, -115555, 912001, CRANE_OK)) { return 6; }
    if (crane_differs(1387U, 831888, 858944, 202607, 84365, 933950, 453185, CRANE_OK)) { return 7; }
    if (crane_differs(1612U, 1031131, 928800, 161556, 41415, 463979, -681158, CRANE_OK)) { return 8; }
    if (crane_differs(1837U, 1186800, 951584, 116868, -12324, -697610, -112848, CRANE_OK)) { return 9; }
    if (crane_differs(2062U, 1293393, 910981, 61260, -57321, -115761, 911803, CRANE_OK)) { return 10; }
    if (crane_differs(2287U, 1334410, 861975, 11373, -13394, 933950, 453185, CRANE_OK)) { return 11; }
    if (crane_differs(2362U, 1330489, 862088, 4126, 3167, 463979, -681158, CRANE_OK)) { return 12; }
    if (crane_differs(0U, 127930, 135787, 5199, -2570, -697834, -112733, CRANE_OK)) { return 13; }
    if (crane_differs(2400U, 1341620, 865893, -2600, -4624, -115761, 911779, CRANE_OK)) { return 14; }
    if (crane_differs(4294967295U, 1337691, 858821, -4680, 2054, 933950, 453185, CRANE_OK)) { return 15; }
    if (crane_differs(300U, 48474, 103245, 17015, 61376, 50331648, 50331648, CRANE_OK)) { return 16; }
    if (crane_differs(900U, 438517, 618159, 144528, 175375, -50331648, -50331648, CRANE_OK)) { return 17; }
    if (crane_differs(1500U, 784286, 748053, 183287, 59200, 50331648, 50331648, CRANE_OUTSIDE_TUBE)) { return 18; }
    if (crane_differs(2100U, 1457204, 1057410, 55783, -50957, -50331648, -50331648, CRANE_OUTSIDE_TUBE)) { return 19; }
    if (crane_differs(1987U, 1261744, 928044, 55416, 5922, 7541849, -50331648, CRANE_OK)) { return 20; }
    if (crane_differs(1987U, 1261744, 928044, 58666, 5521, 5975407, -50331648, CRANE_OK)) { return 21; }
    if (crane_differs(1987U, 1261744, 928044, 61915, 5119, 4702816, -50331648, CRANE_OK)) { return 22; }
    if (crane_differs(1987U, 1261744, 928044, 65164, 4718, 3632523, -50331648, CRANE_OK)) { return 23; }
    if (crane_differs(1987U, 1261744, 928044, 68414, 9234, 2702502, -50331648, CRANE_OK)) { return 24; }
    if (crane_differs(1987U, 1261744, 928044, 71663, 9033, 1868928, -50331648, CRANE_OK)) { return 25; }
    if (crane_differs(1987U, 1261744, 928044, 74912, 8832, 1098016, -50331648, CRANE_OK)) { return 26; }
    if (crane_differs(1987U, 1261744, 928044, 78162, 8632, 362186, -50331648, CRANE_OK)) { return 27; }
    if (crane_differs(1987U, 1261744, 928044, 41607, 8431, 23567599, -50331648, CRANE_OK)) { return 28; }
    if (crane_differs(1987U, 1261744, 928044, 43231, 8230, 19994003, -50331648, CRANE_OK)) { return 29; }
    if (crane_differs(1987U, 1261744, 928044, 44856, 8030, 17176097, -50331648, CRANE_OK)) { return 30; }
    if (crane_differs(1987U, 1261744, 928044, 46481, 7829, 14902840, -50331648, CRANE_OK)) { return 31; }
    if (crane_differs(1987U, 1261744, 928044, 48105, 10087, 13032743, -50331648, CRANE_OK)) { return 32; }
    if (crane_differs(1987U, 1261744, 928044, 49730, 9987, 11466724, -50331648, CRANE_OK)) { return 33; }
    if (crane_differs(1987U, 1261744, 928044, 51355, 9886, 10136428, -50331648, CRANE_OK)) { return 34; }
    if (crane_differs(1987U, 1261744, 928044, 52979, 9786, 8991646, -50331648, CRANE_OK)) { return 35; }
    if (crane_differs(1987U, 1261744, 928044, 34702, 9686, 50331648, -50331648, CRANE_OK)) { return 36; }
    if (crane_differs(1987U, 1261744, 928044, 35514, 9585, 50331648, -50331648, CRANE_OK)) { return 37; }
    if (crane_differs(1987U, 1261744, 928044, 36327, 9485, 46397079, -50331648, CRANE_OK)) { return 38; }
    if (crane_differs(1987U, 1261744, 928044, 37139, 9384, 40967913, -50331648, CRANE_OK)) { return 39; }
    if (crane_differs(1987U, 1261744, 928044, 37951, 10513, 36508206, -50331648, CRANE_OK)) { return 40; }
    if (crane_differs(1987U, 1261744, 928044, 38764, 10463, 32781330, -50331648, CRANE_OK)) { return 41; }
    if (crane_differs(1987U, 1261744, 928044, 39576, 10413, 29635311, -50331648, CRANE_OK)) { return 42; }
    if (crane_differs(1987U, 1261744, 928044, 40388, 10363, 26943425, -50331648, CRANE_OK)) { return 43; }
    if (crane_differs(1987U, 1261744, 928044, 31249, 10313, 50331648, -50331648, CRANE_OK)) { return 44; }
    if (crane_differs(1987U, 1261744, 928044, 31656, 10263, 50331648, -50331648, CRANE_OK)) { return 45; }
    if (crane_differs(1987U, 1261744, 928044, 32062, 10212, 50331648, -50331648, CRANE_OK)) { return 46; }
    if (crane_differs(1987U, 1261744, 928044, 32468, 10162, 50331648, -50331648, CRANE_OK)) { return 47; }
    if (crane_differs(1987U, 1261744, 928044, 32874, -16357, 50331648, -7362962, CRANE_OK)) { return 48; }
    if (crane_differs(1987U, 1261744, 928044, 33280, -19569, 50331648, -5833661, CRANE_OK)) { return 49; }
    if (crane_differs(1987U, 1261744, 928044, 33686, -22780, 50331648, -4591370, CRANE_OK)) { return 50; }
    if (crane_differs(1987U, 1261744, 928044, 34093, -25992, 50331648, -3546099, CRANE_OK)) { return 51; }
    if (crane_differs(1987U, 1261744, 928044, 29523, -29203, 50331648, -2638459, CRANE_OK)) { return 52; }
    if (crane_differs(1987U, 1261744, 928044, 29726, -32414, 50331648, -1824640, CRANE_OK)) { return 53; }
    if (crane_differs(1987U, 1261744, 928044, 29929, -35626, 50331648, -1071742, CRANE_OK)) { return 54; }
    if (crane_differs(1987U, 1261744, 928044, 30132, -38837, 50331648, -353603, CRANE_OK)) { return 55; }
    if (crane_differs(1987U, 1261744, 928044, 30336, -2709, 50331648, -23008890, CRANE_OK)) { return 56; }
    if (crane_differs(1987U, 1261744, 928044, 30539, -4314, 50331648, -19519972, CRANE_OK)) { return 57; }
    if (crane_differs(1987U, 1261744, 928044, 30742, -5920, 50331648, -16769301, CRANE_OK)) { return 58; }
    if (crane_differs(1987U, 1261744, 928044, 30945, -7526, 50331648, -14549891, CRANE_OK)) { return 59; }
    if (crane_differs(1987U, 1261744, 928044, 28660, -9131, 50331648, -12724098, CRANE_OK)) { return 60; }
    if (crane_differs(1987U, 1261744, 928044, 28762, -10737, 50331648, -11195174, CRANE_OK)) { return 61; }
    if (crane_differs(1987U, 1261744, 928044, 28863, -12343, 50331648, -9896202, CRANE_OK)) { return 62; }
    if (crane_differs(1987U, 1261744, 928044, 28965, -13949, 50331648, -8778042, CRANE_OK)) { return 63; }
    if (crane_differs(1987U, 1261744, 928044, 29066, 4116, 50331648, -50331648, CRANE_OK)) { return 64; }
    if (crane_differs(1987U, 1261744, 928044, 29168, 3313, 50331648, -50331648, CRANE_OK)) { return 65; }
    if (crane_differs(1987U, 1261744, 928044, 29269, 2510, 50331648, -45301177, CRANE_OK)) { return 66; }
    if (crane_differs(1987U, 1261744, 928044, 29371, 1707, 50331648, -39996631, CRANE_OK)) { return 67; }
    if (crane_differs(1987U, 1261744, 928044, 28229, 904, 50331648, -35641030, CRANE_OK)) { return 68; }
    if (crane_differs(1987U, 1261744, 928044, 28279, 101, 50331648, -32005064, CRANE_OK)) { return 69; }
    if (crane_differs(1987U, 1261744, 928044, 28330, -701, 50331648, -28934988, CRANE_OK)) { return 70; }
    if (crane_differs(1987U, 1261744, 928044, 28381, -1504, 50331648, -26305426, CRANE_OK)) { return 71; }
    if (crane_differs(1987U, 1261744, 928044, 28432, 7528, 50331648, -50331648, CRANE_OK)) { return 72; }
    if (crane_differs(1987U, 1261744, 928044, 28482, 7126, 50331648, -50331648, CRANE_OK)) { return 73; }
    if (crane_differs(1987U, 1261744, 928044, 28533, 6725, 50331648, -50331648, CRANE_OK)) { return 74; }
    if (crane_differs(1987U, 1261744, 928044, 28584, 6324, 50331648, -50331648, CRANE_OK)) { return 75; }
    if (crane_differs(0U, 127930, 135787, 5199, -2570, -697834, -112733, CRANE_OK)) { return 76; }
    if (crane_differs(1200U, 547530, 688657, 262345, 174006, 111, 109, CRANE_OUTSIDE_TUBE)) { return 77; }
    if (crane_differs(1200U, 710975, 852101, 154206, 67145, 111, 109, CRANE_OUTSIDE_TUBE)) { return 78; }
    if (crane_differs(1200U, 629253, 770379, 154210, 67145, 50331648, 50331648, CRANE_OUTSIDE_TUBE)) { return 79; }
    if (crane_differs(1200U, 629253, 770379, 262340, 174007, -50331648, -50331648, CRANE_OUTSIDE_TUBE)) { return 80; }
    if (crane_differs(800U, INT32_MIN, INT32_MIN, INT32_MIN, INT32_MIN, 50331648, 50331648, CRANE_OUTSIDE_TUBE)) { return 81; }
    if (crane_differs(800U, 2147483647, 2147483647, 2147483647, 2147483647, -50331648, -50331648, CRANE_OUTSIDE_TUBE)) { return 82; }
    return 0;
}
