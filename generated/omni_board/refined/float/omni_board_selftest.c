/* omni_board_selftest.c: calls of omni_board_control with known results, for the board's boot. Optional. */
#include "omni_board.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#ifndef OMNI_BOARD_SELFTEST_dcd2c935a7ab399c
#error "omni_board_selftest.c is of another design than omni_board.h"
#endif

/* Arguments of control: t, x. */
static const omni_board_real omni_board_points[57] = {
    0.1265625F, 0.30049577F, 0.38385266F,
    0.9703125F, 0.5819156F, 0.70907587F,
    1.8140625F, 0.43802902F, 1.5389682F,
    2.6578126F, 0.84975046F, 1.944856F,
    3.5015626F, 1.4604375F, 1.9060043F,
    4.3453126F, 2.1710985F, 2.09424F,
    5.1890626F, 2.969238F, 2.1184309F,
    6.0328126F, 3.4720688F, 2.7335064F,
    6.8765626F, 3.8755813F, 3.0592384F,
    7.7203126F, 4.073422F, 3.795909F,
    8.564062F, 4.502848F, 4.636698F,
    8.845312F, 4.7489753F, 4.6907735F,
    0.9703125F, 0.029123716F, 0.2370509F,
    2.6578126F, 1.059698F, 2.4433959F,
    4.6265626F, 1.9539298F, 1.0938692F,
    6.3140626F, 4.6318707F, 3.2590427F,
    8.001562F, 14.988194F, 10.635737F,
    -0.9984375F, 0.22500749F, 0.274994F,
    10.251562F, 4.774995F, 4.6875076F
};

/* u may be from here */
static const omni_board_real omni_board_least[38] = {
    1.6662453F, -1.5084959F,
    -0.8710215F, 0.3607162F,
    0.421968F, -0.3594477F,
    -0.81115615F, 1.3004937F,
    2.1797502F, 0.8985939F,
    1.6893766F, -0.8994181F,
    -1.6905943F, 0.9121964F,
    0.56364053F, -2.173327F,
    -0.26455823F, 1.425092F,
    0.7365411F, 1.1001225F,
    1.1807309F, -1.1839404F,
    -1.6557628F, 0.72836596F,
    61.585857F, 53.143337F,
    -119.50294F, -71.29936F,
    1064.153F, 579.8681F,
    -500.21814F, -1319.6495F,
    -426.1328F, -693.2918F,
    0.81100243F, -0.8110261F,
    -0.8111139F, 2.179542F
};

/* to here: all that IEEE arithmetic can give. */
static const omni_board_real omni_board_greatest[38] = {
    1.6662725F, -1.5084543F,
    -0.87098646F, 0.3607334F,
    0.42198548F, -0.3593682F,
    -0.81087756F, 1.300712F,
    2.1803215F, 0.89877903F,
    1.6902885F, -0.8991395F,
    -1.6890619F, 0.9134472F,
    0.5645268F, -2.1624365F,
    -0.26428244F, 1.4259894F,
    0.7368887F, 1.101224F,
    1.1823921F, -1.1821421F,
    -1.6520835F, 0.7312107F,
    61.58622F, 53.144455F,
    -119.46408F, -71.267395F,
    1064.3257F, 579.9109F,
    -500.14603F, -1319.2517F,
    -426.05426F, -693.0971F,
    0.8110194F, -0.8109924F,
    -0.81070054F, 2.179993F
};

static const omni_board_status omni_board_expected[19] = {
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OUTSIDE_TUBE,
    OMNI_BOARD_OUTSIDE_TUBE,
    OMNI_BOARD_OUTSIDE_TUBE,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK
};

/* Arguments of control_tick: x. */
static const omni_board_real omni_board_points_at_ticks[38] = {
    0.30049577F, 0.38385266F,
    0.5819156F, 0.70907587F,
    0.43802902F, 1.5389682F,
    0.84975046F, 1.944856F,
    1.4604375F, 1.9060043F,
    2.1710985F, 2.09424F,
    2.969238F, 2.1184309F,
    3.4720688F, 2.7335064F,
    3.8755813F, 3.0592384F,
    4.073422F, 3.795909F,
    4.502848F, 4.636698F,
    4.7489753F, 4.6907735F,
    0.029123716F, 0.2370509F,
    1.059698F, 2.4433959F,
    1.9539298F, 1.0938692F,
    4.6318707F, 3.2590427F,
    14.988194F, 10.635737F,
    0.22500749F, 0.274994F,
    4.774995F, 4.6875076F
};

/* u may be from here */
static const omni_board_real omni_board_least_at_ticks[38] = {
    1.6516303F, -1.5184448F,
    -0.87101924F, 0.35906243F,
    0.42195925F, -0.3597719F,
    -0.8334894F, 1.2945759F,
    2.1608782F, 0.8986637F,
    1.6800354F, -0.8993225F,
    -1.6919063F, 0.9119496F,
    0.56352645F, -2.3209944F,
    -0.26547074F, 1.4174839F,
    0.7357904F, 1.0963609F,
    1.1809331F, -1.1838235F,
    -1.6599163F, 0.7259661F,
    61.58592F, 52.66547F,
    -126.623856F, -71.38164F,
    1064.2224F, 579.81586F,
    -500.21573F, -1319.7496F,
    -425.93976F, -693.2064F,
    0.81100243F, -0.8110261F,
    -0.8111139F, 2.179542F
};

/* to here: all that IEEE arithmetic can give. */
static const omni_board_real omni_board_greatest_at_ticks[38] = {
    1.651655F, -1.518407F,
    -0.87099934F, 0.3590724F,
    0.42196733F, -0.35974133F,
    -0.8334065F, 1.2946409F,
    2.1610148F, 0.8987092F,
    1.6802175F, -0.89926535F,
    -1.6916429F, 0.9121647F,
    0.56366193F, -2.3193293F,
    -0.26543263F, 1.4176064F,
    0.7358342F, 1.0964966F,
    1.1811188F, -1.1836224F,
    -1.6595192F, 0.7262725F,
    61.58616F, 52.666077F,
    -126.61151F, -71.372444F,
    1064.2562F, 579.8248F,
    -500.2046F, -1319.6903F,
    -425.9299F, -693.18256F,
    0.8110194F, -0.8109924F,
    -0.81070054F, 2.179993F
};

static const uint32_t omni_board_ticks[19] = {
    126U,
    970U,
    1814U,
    2657U,
    3501U,
    4345U,
    5189U,
    6032U,
    6876U,
    7720U,
    8564U,
    8845U,
    970U,
    2657U,
    4626U,
    6314U,
    8001U,
    0U,
    10251U
};

static const omni_board_status omni_board_expected_at_ticks[19] = {
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK,
    OMNI_BOARD_OUTSIDE_TUBE,
    OMNI_BOARD_OUTSIDE_TUBE,
    OMNI_BOARD_OUTSIDE_TUBE,
    OMNI_BOARD_OK,
    OMNI_BOARD_OK
};

/* Whether u is between the least and the greatest that it may be. */
static bool omni_board_between(const omni_board_real *least, const omni_board_real *u,
                               const omni_board_real *greatest)
{
    bool good = true;
    for (int32_t i = 0; i < OMNI_BOARD_N; ++i) {
        good = good && (least[i] <= u[i]) && (u[i] <= greatest[i]);
    }
    return good;
}

int omni_board_selftest(void)
{
    omni_board_real u[OMNI_BOARD_N];
    for (int32_t k = 0; k < 19; ++k) {
        const int32_t first = k * 3;
        const int32_t out = k * OMNI_BOARD_N;
        const omni_board_real *point = &omni_board_points[first];
        const omni_board_status status =
            omni_board_control(point[0], &point[1], u);
        const bool good = omni_board_between(&omni_board_least[out], u, &omni_board_greatest[out]);
        if ((status != omni_board_expected[k]) || !good) {
            return (int)k + 1;
        }
    }
    for (int32_t k = 0; k < 19; ++k) {
        const int32_t first = k * 2;
        const int32_t out = k * OMNI_BOARD_N;
        const omni_board_real *point = &omni_board_points_at_ticks[first];
        const omni_board_status status =
            omni_board_control_tick(omni_board_ticks[k], &point[0], u);
        const bool good = omni_board_between(&omni_board_least_at_ticks[out], u, &omni_board_greatest_at_ticks[out]);
        if ((status != omni_board_expected_at_ticks[k]) || !good) {
            return (int)k + 20;
        }
    }
    for (int32_t k = 0; k < 3; ++k) { /* a NaN in every argument in turn */
        omni_board_real point[3];
        for (int32_t i = 0; i < 3; ++i) {
            point[i] = (i == k) ? (omni_board_real)NAN : omni_board_points[i];
        }
        const omni_board_status status =
            omni_board_control(point[0], &point[1], u);
        if (status != OMNI_BOARD_BAD_INPUT) {
            return 39;
        }
    }
    return 0;
}
