/* gantry_selftest.c: calls of gantry_control with known results, for the board's boot. Optional. */
#include "gantry.h"

#include <stdbool.h>

#ifndef GANTRY_SELFTEST_a0f9dc15bb115d69
#error "gantry_selftest.c is of another design than gantry.h"
#endif

/* Whether gantry_control gives anything but this. Arguments and results are constants of the code: they take no memory. */
static bool gantry_differs(uint32_t tick, int32_t x0, int32_t x1, int32_t u0, int32_t u1,
                           gantry_status status)
{
    const int32_t x[GANTRY_N] = { x0, x1 };
    int32_t u[GANTRY_N];
    const gantry_status found = gantry_control(tick, x, u);
    return (found != status) || (u[0] != u0) || (u[1] != u1);
}

int gantry_selftest(void)
{
    if (gantry_differs(62U, 121853, 140068, 522783, -786276, GANTRY_OK)) { return 1; }
    if (gantry_differs(437U, 193467, 250688, -786276, -130433, GANTRY_OK)) { return 2; }
    if (gantry_differs(812U, 250936, 357538, -130433, 1052455, GANTRY_OK)) { return 3; }
    if (gantry_differs(1187U, 304632, 476646, 1052455, 522783, GANTRY_OK)) { return 4; }
    if (gantry_differs(1562U, 379755, 600540, 522783, -786345, GANTRY_OK)) { return 5; }
    if (gantry_differs(1937U, 504142, 605411, -786276, -130433, GANTRY_OK)) { return 6; }
    if (gantry_differs(2312U, 614762, 584107, -130433, 1052455, GANTRY_OK)) { return 7; }
    if (gantry_differs(2687U, 721609, 575064, 1052455, 522783, GANTRY_OK)) { return 8; }
    if (gantry_differs(3062U, 840717, 571678, 522783, -786276, GANTRY_OK)) { return 9; }
    if (gantry_differs(3437U, 965484, 554854, -786380, -130438, GANTRY_OK)) { return 10; }
    if (gantry_differs(3812U, 1075323, 630926, -130433, 1052432, GANTRY_OK)) { return 11; }
    if (gantry_differs(3937U, 1086172, 662810, 1052455, 522875, GANTRY_OK)) { return 12; }
    if (gantry_differs(0U, 111572, 121001, 522783, -786276, GANTRY_OK)) { return 13; }
    if (gantry_differs(4000U, 1100196, 671999, -786276, -130438, GANTRY_OK)) { return 14; }
    if (gantry_differs(4294967295U, 1095481, 663511, -130433, 1052502, GANTRY_OK)) { return 15; }
    if (gantry_differs(500U, 109605, 180472, 40265280, 40265280, GANTRY_OK)) { return 16; }
    if (gantry_differs(1500U, 455681, 665332, -40265280, -40265280, GANTRY_OK)) { return 17; }
    if (gantry_differs(2500U, 483023, 396612, 40265280, 40265280, GANTRY_OUTSIDE_TUBE)) { return 18; }
    if (gantry_differs(3500U, 1167813, 745431, -40265280, -40265280, GANTRY_OUTSIDE_TUBE)) { return 19; }
    if (gantry_differs(0U, 71137, 200441, 8499448, -40265280, GANTRY_OK)) { return 20; }
    if (gantry_differs(0U, 77031, 199704, 6734464, -40265280, GANTRY_OK)) { return 21; }
    if (gantry_differs(0U, 82926, 198968, 5299979, -40265280, GANTRY_OK)) { return 22; }
    if (gantry_differs(0U, 88820, 198231, 4093675, -40265280, GANTRY_OK)) { return 23; }
    if (gantry_differs(0U, 94714, 206520, 3045735, -40265280, GANTRY_OK)) { return 24; }
    if (gantry_differs(0U, 100608, 206151, 2106282, -40265280, GANTRY_OK)) { return 25; }
    if (gantry_differs(0U, 106503, 205783, 1237190, -40265280, GANTRY_OK)) { return 26; }
    if (gantry_differs(0U, 112397, 205415, 408105, -40265280, GANTRY_OK)) { return 27; }
    if (gantry_differs(0U, 46087, 205046, 26560039, -40265280, GANTRY_OK)) { return 28; }
    if (gantry_differs(0U, 49034, 204678, 22531000, -40265280, GANTRY_OK)) { return 29; }
    if (gantry_differs(0U, 51981, 204309, 19357064, -40265280, GANTRY_OK)) { return 30; }
    if (gantry_differs(0U, 54928, 203941, 16795759, -40265280, GANTRY_OK)) { return 31; }
    if (gantry_differs(0U, 57875, 208085, 14687318, -40265280, GANTRY_OK)) { return 32; }
    if (gantry_differs(0U, 60822, 207901, 12922799, -40265280, GANTRY_OK)) { return 33; }
    if (gantry_differs(0U, 63769, 207717, 11423903, -40265280, GANTRY_OK)) { return 34; }
    if (gantry_differs(0U, 66716, 207533, 10133463, -40265280, GANTRY_OK)) { return 35; }
    if (gantry_differs(0U, 33561, 207349, 40265280, -40265280, GANTRY_OK)) { return 36; }
    if (gantry_differs(0U, 35035, 207164, 40265280, -40265280, GANTRY_OK)) { return 37; }
    if (gantry_differs(0U, 36508, 206980, 40265280, -40265280, GANTRY_OK)) { return 38; }
    if (gantry_differs(0U, 37982, 206796, 40265280, -40265280, GANTRY_OK)) { return 39; }
    if (gantry_differs(0U, 39456, 208868, 40265280, -40265280, GANTRY_OK)) { return 40; }
    if (gantry_differs(0U, 40929, 208776, 36944040, -40265280, GANTRY_OK)) { return 41; }
    if (gantry_differs(0U, 42403, 208684, 33396626, -40265280, GANTRY_OK)) { return 42; }
    if (gantry_differs(0U, 43876, 208592, 30363398, -40265280, GANTRY_OK)) { return 43; }
    if (gantry_differs(0U, 27299, 208500, 40265280, -40265280, GANTRY_OK)) { return 44; }
    if (gantry_differs(0U, 28035, 208408, 40265280, -40265280, GANTRY_OK)) { return 45; }
    if (gantry_differs(0U, 28772, 208316, 40265280, -40265280, GANTRY_OK)) { return 46; }
    if (gantry_differs(0U, 29509, 208223, 40265280, -40265280, GANTRY_OK)) { return 47; }
    if (gantry_differs(0U, 30246, 159550, 40265280, -8499448, GANTRY_OK)) { return 48; }
    if (gantry_differs(0U, 30983, 153656, 40265280, -6734464, GANTRY_OK)) { return 49; }
    if (gantry_differs(0U, 31719, 147761, 40265280, -5299979, GANTRY_OK)) { return 50; }
    if (gantry_differs(0U, 32456, 141867, 40265280, -4093675, GANTRY_OK)) { return 51; }
    if (gantry_differs(0U, 24167, 135973, 40265280, -3045735, GANTRY_OK)) { return 52; }
    if (gantry_differs(0U, 24536, 130079, 40265280, -2106282, GANTRY_OK)) { return 53; }
    if (gantry_differs(0U, 24904, 124184, 40265280, -1237190, GANTRY_OK)) { return 54; }
    if (gantry_differs(0U, 25272, 118290, 40265280, -408105, GANTRY_OK)) { return 55; }
    if (gantry_differs(0U, 25641, 184600, 40265280, -26560039, GANTRY_OK)) { return 56; }
    if (gantry_differs(0U, 26009, 181653, 40265280, -22531000, GANTRY_OK)) { return 57; }
    if (gantry_differs(0U, 26378, 178706, 40265280, -19357064, GANTRY_OK)) { return 58; }
    if (gantry_differs(0U, 26746, 175759, 40265280, -16795759, GANTRY_OK)) { return 59; }
    if (gantry_differs(0U, 22602, 172812, 40265280, -14687318, GANTRY_OK)) { return 60; }
    if (gantry_differs(0U, 22786, 169865, 40265280, -12922799, GANTRY_OK)) { return 61; }
    if (gantry_differs(0U, 22970, 166918, 40265280, -11423903, GANTRY_OK)) { return 62; }
    if (gantry_differs(0U, 23154, 163971, 40265280, -10133463, GANTRY_OK)) { return 63; }
    if (gantry_differs(0U, 23338, 197126, 40265280, -40265280, GANTRY_OK)) { return 64; }
    if (gantry_differs(0U, 23523, 195652, 40265280, -40265280, GANTRY_OK)) { return 65; }
    if (gantry_differs(0U, 23707, 194179, 40265280, -40265280, GANTRY_OK)) { return 66; }
    if (gantry_differs(0U, 23891, 192705, 40265280, -40265280, GANTRY_OK)) { return 67; }
    if (gantry_differs(0U, 21819, 191231, 40265280, -40265280, GANTRY_OK)) { return 68; }
    if (gantry_differs(0U, 21911, 189758, 40265280, -36944040, GANTRY_OK)) { return 69; }
    if (gantry_differs(0U, 22003, 188284, 40265280, -33396626, GANTRY_OK)) { return 70; }
    if (gantry_differs(0U, 22095, 186811, 40265280, -30363398, GANTRY_OK)) { return 71; }
    if (gantry_differs(0U, 22187, 203388, 40265280, -40265280, GANTRY_OK)) { return 72; }
    if (gantry_differs(0U, 22279, 202652, 40265280, -40265280, GANTRY_OK)) { return 73; }
    if (gantry_differs(0U, 22371, 201915, 40265280, -40265280, GANTRY_OK)) { return 74; }
    if (gantry_differs(0U, 22464, 201178, 40265280, -40265280, GANTRY_OK)) { return 75; }
    if (gantry_differs(0U, 111572, 121001, 522783, -786276, GANTRY_OK)) { return 76; }
    if (gantry_differs(2000U, 423550, 508007, 40265280, 40265280, GANTRY_OUTSIDE_TUBE)) { return 77; }
    if (gantry_differs(2000U, 423551, 508008, 40265280, 40265280, GANTRY_OUTSIDE_TUBE)) { return 78; }
    if (gantry_differs(2000U, 423552, 508009, 40265280, 40265280, GANTRY_OK)) { return 79; }
    if (gantry_differs(2000U, 612166, 696623, -40265280, -40265280, GANTRY_OK)) { return 80; }
    if (gantry_differs(2000U, 612167, 696624, -40265280, -40265280, GANTRY_OUTSIDE_TUBE)) { return 81; }
    if (gantry_differs(2000U, 612168, 696625, -40265280, -40265280, GANTRY_OUTSIDE_TUBE)) { return 82; }
    if (gantry_differs(2000U, 517858, 602315, 138, 138, GANTRY_OK)) { return 83; }
    if (gantry_differs(2000U, 517859, 602316, 0, 0, GANTRY_OK)) { return 84; }
    if (gantry_differs(2000U, 517860, 602317, -138, -138, GANTRY_OK)) { return 85; }
    if (gantry_differs(1333U, INT32_MIN, INT32_MIN, 40265280, 40265280, GANTRY_OUTSIDE_TUBE)) { return 86; }
    if (gantry_differs(1333U, 2147483647, 2147483647, -40265280, -40265280, GANTRY_OUTSIDE_TUBE)) { return 87; }
    return 0;
}
