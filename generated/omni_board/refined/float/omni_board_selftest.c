/* omni_board_selftest.c: a dozen calls of omni_board_control with known results, for the board's boot. Optional. */
#include "omni_board.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#define VECTORS 12
#define NUMBERS 3

/* Arguments of control: t, x. */
static const omni_board_real omni_board_points[36] = {
    0.3F, 0.4511857F, 0.20114174F,
    1.05F, 0.24250963F, 1.1132641F,
    1.8F, 0.72673213F, 0.9404256F,
    2.55F, 0.50060487F, 2.435447F,
    3.3F, 1.5910813F, 1.0611973F,
    4.05F, 1.4768511F, 2.9399357F,
    4.8F, 3.097197F, 1.7208433F,
    5.55F, 3.030455F, 2.384886F,
    6.3F, 3.9571848F, 2.8915155F,
    7.05F, 4.049657F, 3.2052333F,
    7.8F, 4.1153126F, 10.463889F,
    8.55F, 10.786615F, 4.555852F
};

/* u may be from here */
static const omni_board_real omni_board_least[24] = {
    -0.000015422838F, 3.9620156F,
    3.0204508F, -2.5983372F,
    -3.0422044F, 52.94722F,
    119.474686F, -65.14774F,
    -119.51771F, 566.425F,
    1064.1766F, -566.0023F,
    -1064.3319F, 10.389464F,
    17.789654F, -49.11665F,
    -8.473656F, -2.1963363F,
    -0.51256657F, 1.4195006F,
    0.76990455F, -693.28613F,
    -727.62054F, -0.0005957112F
};

/* to here: all that IEEE arithmetic can give. */
static const omni_board_real omni_board_greatest[24] = {
    0.000015422838F, 3.9620419F,
    3.0204775F, -2.5982468F,
    -3.042096F, 52.952625F,
    119.49246F, -65.12258F,
    -119.44864F, 566.4566F,
    1064.302F, -565.9659F,
    -1064.1467F, 10.391482F,
    17.80143F, -49.046394F,
    -8.469816F, -2.1933963F,
    -0.51230973F, 1.4204426F,
    0.7702941F, -693.103F,
    -727.3682F, 0.0005957112F
};

static const omni_board_status omni_board_expected[VECTORS] = {
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OUTSIDE_TUBE,
    OMNI_BOARD_OUTSIDE_TUBE,
    OMNI_BOARD_OUTSIDE_TUBE,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OUTSIDE_TUBE,
    OMNI_BOARD_OUTSIDE_TUBE
};

int omni_board_selftest(void)
{
    omni_board_real u[OMNI_BOARD_N];
    for (int32_t k = 0; k < VECTORS; ++k) {
        const int32_t first = k * NUMBERS;
        const omni_board_real *point = &omni_board_points[first];
        const omni_board_status status = omni_board_control(point[0], &point[1], u);
        bool good = status == omni_board_expected[k];
        for (int32_t i = 0; i < OMNI_BOARD_N; ++i) {
            const int32_t at = (k * OMNI_BOARD_N) + i;
            good = good && (omni_board_least[at] <= u[i]) && (u[i] <= omni_board_greatest[at]);
        }
        if (!good) {
            return (int)k + 1;
        }
    }
    omni_board_real point[NUMBERS];
    for (int32_t i = 0; i < NUMBERS; ++i) {
        point[i] = omni_board_points[i];
    }
    point[NUMBERS - 1] = (omni_board_real)NAN;
    const omni_board_status status = omni_board_control(point[0], &point[1], u);
    return (status == OMNI_BOARD_BAD_INPUT) ? 0 : (VECTORS + 1);
}
