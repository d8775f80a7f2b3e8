/* omni_board_selftest.c: calls of omni_board_control with known results, for the board's boot. Optional. */
#include "omni_board.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#ifndef OMNI_BOARD_SELFTEST_fbb55d3aca79a42b
#error "omni_board_selftest.c is of another design than omni_board.h"
#endif

/* Arguments of control: t, x. */
static const omni_board_real omni_board_points[57] = {
    0.1265625F, 0.20000815F, 0.3983438F,
    0.9703125F, 0.30294606F, 0.9790628F,
    1.8140625F, 0.5900756F, 1.6847514F,
    2.6578126F, 1.2274722F, 2.111539F,
    3.5015626F, 1.730749F, 1.76539F,
    4.3453126F, 2.3340015F, 1.8360168F,
    5.1890626F, 3.0247326F, 1.9721563F,
    6.0328126F, 3.3553493F, 2.5526915F,
    6.8765626F, 3.4810457F, 3.110159F,
    7.7203126F, 3.8571472F, 3.7783566F,
    8.564062F, 4.460399F, 4.5340323F,
    8.845312F, 4.751312F, 4.6709795F,
    0.9703125F, 0.018015647F, 0.769114F,
    2.6578126F, 1.437421F, 2.4089663F,
    4.6265626F, 2.08103F, 1.2834098F,
    6.3140626F, 3.7882972F, 3.2359433F,
    8.001562F, 8.365513F, 8.295874F,
    -0.9984375F, 0.22500706F, 0.27499485F,
    10.251562F, 4.7749653F, 4.6874847F
};

/* u may be from here */
static const omni_board_real omni_board_least[38] = {
    1.6898215F, -1.6898565F,
    -1.6898648F, 0.81094044F,
    0.810956F, -0.8112155F,
    -0.81120604F, 2.1796947F,
    2.179694F, 1.6895163F,
    1.6893353F, -1.6902485F,
    -1.6906142F, 0.81055564F,
    0.81012124F, -0.8117487F,
    -0.8121206F, 2.1789608F,
    2.178547F, 1.6885296F,
    1.6881393F, -1.6916051F,
    -1.691741F, 0.80925953F,
    119.482315F, 119.475044F,
    -119.50952F, -119.52736F,
    1064.1486F, 1064.176F,
    -1064.3893F, -1064.3638F,
    -1064.4685F, -1064.4646F,
    0.8110055F, -0.8110288F,
    -0.81121933F, 2.1798081F
};

/* to here: all that IEEE arithmetic can give. */
static const omni_board_real omni_board_greatest[38] = {
    1.6898395F, -1.6898052F,
    -1.6897956F, 0.8110828F,
    0.81107014F, -0.81081337F,
    -0.8108185F, 2.1803725F,
    2.1803746F, 1.6901432F,
    1.690318F, -1.6894087F,
    -1.6890539F, 0.8114658F,
    0.8119108F, -0.8102841F,
    -0.8099114F, 2.1811154F,
    2.1815138F, 1.6911397F,
    1.6915265F, -1.6880393F,
    -1.6879083F, 0.8127649F,
    119.48314F, 119.49081F,
    -119.45673F, -119.439186F,
    1064.3301F, 1064.3026F,
    -1064.0894F, -1064.1149F,
    -1064.0101F, -1064.014F,
    0.81101966F, -0.81099635F,
    -0.81080586F, 2.1802592F
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
    0.20000815F, 0.3983438F,
    0.30294606F, 0.9790628F,
    0.5900756F, 1.6847514F,
    1.2274722F, 2.111539F,
    1.730749F, 1.76539F,
    2.3340015F, 1.8360168F,
    3.0247326F, 1.9721563F,
    3.3553493F, 2.5526915F,
    3.4810457F, 3.110159F,
    3.8571472F, 3.7783566F,
    4.460399F, 4.5340323F,
    4.751312F, 4.6709795F,
    0.018015647F, 0.769114F,
    1.437421F, 2.4089663F,
    2.08103F, 1.2834098F,
    3.7882972F, 3.2359433F,
    8.365513F, 8.295874F,
    0.22500706F, 0.27499485F,
    4.7749653F, 4.6874847F
};

/* u may be from here */
static const omni_board_real omni_board_least_at_ticks[38] = {
    1.6898243F, -1.7062926F,
    -1.6906796F, 0.80288476F,
    0.8096681F, -0.8127081F,
    -0.8300458F, 2.185065F,
    2.1637962F, 1.6794341F,
    1.6815146F, -1.6885303F,
    -1.6916152F, 0.810506F,
    0.82217264F, -0.8307507F,
    -0.8125026F, 2.1619616F,
    2.1708648F, 1.6805588F,
    1.6880102F, -1.6918349F,
    -1.6965854F, 0.804374F,
    119.26001F, 117.0733F,
    -125.47987F, -118.24829F,
    1064.2216F, 1064.2267F,
    -1064.2617F, -1064.258F,
    -1064.267F, -1064.2665F,
    0.8110055F, -0.8110288F,
    -0.81121933F, 2.1798081F
};

/* to here: all that IEEE arithmetic can give. */
static const omni_board_real omni_board_greatest_at_ticks[38] = {
    1.6898412F, -1.706246F,
    -1.6906407F, 0.8029607F,
    0.8097127F, -0.81255746F,
    -0.8299318F, 2.185264F,
    2.163958F, 1.6795824F,
    1.6817107F, -1.6883618F,
    -1.691347F, 0.8106638F,
    0.8224452F, -0.83052754F,
    -0.81220454F, 2.1622522F,
    2.171226F, 1.6808765F,
    1.6883861F, -1.6914392F,
    -1.696171F, 0.80475086F,
    119.260506F, 117.08128F,
    -125.4634F, -118.22346F,
    1064.2571F, 1064.252F,
    -1064.2169F, -1064.2206F,
    -1064.2117F, -1064.2122F,
    0.81101966F, -0.81099635F,
    -0.81080586F, 2.1802592F
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
