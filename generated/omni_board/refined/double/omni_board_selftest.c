/* omni_board_selftest.c: a dozen calls of omni_board_control with known results, for the board's boot. Optional. */
#include "omni_board.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#define VECTORS 12
#define NUMBERS 3

/* Arguments of control: t, x. */
static const omni_board_real omni_board_points[36] = {
    0.3, 0.45118569861517993, 0.20114173924481418,
    1.05, 0.2425096261766221, 1.113264123987268,
    1.8, 0.7267321529388425, 0.9404256210327145,
    2.55, 0.5006048848498303, 2.4354470353529183,
    3.3, 1.5910812377929675, 1.0611972741021047,
    4.05, 1.4768508911132803, 2.9399356842041007,
    4.8, 3.097196960449217, 1.7208431602760585,
    5.55, 3.0304550170898423, 2.384885809545162,
    6.3, 3.957184521675108, 2.891515356445311,
    7.05, 4.049656854643643, 3.205233239844991,
    7.8, 4.115312448713512, 10.463888567889168,
    8.55, 10.78661808013916, 4.555851795196531
};

/* u may be from here */
static const omni_board_real omni_board_least[24] = {
    -6.698736134679877e-14, 3.9620289878631962,
    3.020464298314042, -2.5982920489822785,
    -3.042150589945968, 52.9498890586201,
    119.48363979563702, -65.13532703144196,
    -119.48273386149856, 566.4408006305473,
    1064.2392750317679, -565.9840932804567,
    -1064.2392750324777, 10.39047846717161,
    17.795501020454832, -49.08141223561531,
    -8.471727911072286, -2.194864352638144,
    -0.5124386741298204, 1.4199696096029364,
    0.7700991946608123, -693.1945263369989,
    -727.4940720046603, -2.2974725352969795e-12
};

/* to here: all that IEEE arithmetic can give. */
static const omni_board_real omni_board_greatest[24] = {
    6.698736134679877e-14, 3.9620289878632966,
    3.020464298314138, -2.598292048981949,
    -3.0421505899455434, 52.94988905864062,
    119.48363979572146, -65.13532703132347,
    -119.48273386120684, 566.4408006306764,
    1064.2392750322454, -565.9840932803178,
    -1064.239275031535, 10.390478467181788,
    17.795501020509302, -49.081412235290934,
    -8.471727911055677, -2.1948643526254146,
    -0.5124386741287588, 1.4199696096068795,
    0.7700991946623482, -693.1945263362763,
    -727.4940720036983, 2.2974725352969795e-12
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
