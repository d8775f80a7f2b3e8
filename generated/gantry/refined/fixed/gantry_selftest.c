/* gantry_selftest.c: calls of gantry_control with known results, for the board's boot. Optional. */
#include "gantry.h"

#include <stdbool.h>

#ifndef GANTRY_SELFTEST_5e14e4d10f2a54ab
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
    if (gantry_differs(62U, 121853, 140068, 13279016, -19971902, GANTRY_OK)) { return 1; }
    if (gantry_differs(437U, 193467, 250688, -19971902, -3313080, GANTRY_OK)) { return 2; }
    if (gantry_differs(812U, 250936, 357538, -3313080, 26733033, GANTRY_OK)) { return 3; }
    if (gantry_differs(1187U, 304632, 476646, 26733033, 13279016, GANTRY_OK)) { return 4; }
    if (gantry_differs(1562U, 379755, 600540, 13279016, -19973667, GANTRY_OK)) { return 5; }
    if (gantry_differs(1937U, 504142, 605411, -19971902, -3313080, GANTRY_OK)) { return 6; }
    if (gantry_differs(2312U, 614762, 584107, -3313080, 26733033, GANTRY_OK)) { return 7; }
    if (gantry_differs(2687U, 721609, 575064, 26733033, 13279016, GANTRY_OK)) { return 8; }
    if (gantry_differs(3062U, 840717, 571678, 13279016, -19971902, GANTRY_OK)) { return 9; }
    if (gantry_differs(3437U, 965484, 554854, -19974545, -3313226, GANTRY_OK)) { return 10; }
    if (gantry_differs(3812U, 1075323, 630926, -3313080, 26732435, GANTRY_OK)) { return 11; }
    if (gantry_differs(3937U, 1086172, 662810, 26733033, 13281358, GANTRY_OK)) { return 12; }
    if (gantry_differs(500U, 109605, 180472, 40265280, 40265280, GANTRY_OK)) { return 13; }
    if (gantry_differs(1500U, 455681, 665332, -40265280, -40265280, GANTRY_OK)) { return 14; }
    if (gantry_differs(2500U, 483023, 396612, 40265280, 40265280, GANTRY_OUTSIDE_TUBE)) { return 15; }
    if (gantry_differs(3500U, 1167813, 745431, -40265280, -40265280, GANTRY_OUTSIDE_TUBE)) { return 16; }
    if (gantry_differs(0U, 111572, 121001, 13279016, -19971902, GANTRY_OK)) { return 17; }
    if (gantry_differs(4000U, 1100196, 671999, -19971902, -3313226, GANTRY_OK)) { return 18; }
    if (gantry_differs(4294967295U, 1095481, 663511, -3313080, 26734207, GANTRY_OK)) { return 19; }
    if (gantry_differs(1333U, INT32_MIN, INT32_MIN, 40265280, 40265280, GANTRY_OUTSIDE_TUBE)) { return 20; }
    if (gantry_differs(1333U, 2147483647, 2147483647, -40265280, -40265280, GANTRY_OUTSIDE_TUBE)) { return 21; }
    return 0;
}
