/* omni_board_selftest.c: calls of omni_board_control with known results, for the board's boot. Optional. */
#include "omni_board.h"

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#ifndef OMNI_BOARD_SELFTEST_23e458e2bad7f4ef
#error "omni_board_selftest.c is of another design than omni_board.h"
#endif

/* Arguments of control: t, x. */
static const omni_board_real omni_board_points[57] = {
    0.1265625F, 0.22049761F, 0.3983438F,
    0.9703125F, 0.45702973F, 0.97906286F,
    1.8140625F, 0.59092706F, 1.6847514F,
    2.6578126F, 1.2274722F, 1.9364358F,
    3.5015626F, 1.730749F, 1.9497309F,
    4.3453126F, 2.3340015F, 2.0505047F,
    5.1890626F, 3.0247326F, 1.9796395F,
    6.0328126F, 3.5041876F, 2.5619469F,
    6.8765626F, 3.9306083F, 3.130169F,
    7.7203126F, 4.229857F, 3.7983665F,
    8.564062F, 4.6271234F, 4.5535893F,
    8.845312F, 4.796381F, 4.6775637F,
    0.9703125F, 0.1720993F, 0.76911414F,
    2.6578126F, 1.437421F, 2.233863F,
    4.6265626F, 2.08103F, 1.5009052F,
    6.3140626F, 4.1521955F, 3.2553985F,
    8.001562F, 8.670213F, 8.315884F,
    -0.9984375F, 0.22500801F, 0.27499485F,
    10.251562F, 4.7749615F, 4.6874847F
};

/* u may be from here */
static const omni_board_real omni_board_least[38] = {
    1.6898204F, -1.6898565F,
    -1.6898772F, 0.8109414F,
    0.8109544F, -0.81121314F,
    -0.81120604F, 2.1797214F,
    2.179694F, 1.6894845F,
    1.6893353F, -1.6902905F,
    -1.6906142F, 0.8105552F,
    0.81007886F, -0.81174946F,
    -0.81225336F, 2.1789536F,
    2.1784027F, 1.6885225F,
    1.6880716F, -1.691625F,
    -1.6917721F, 0.8092648F,
    119.48084F, 119.474724F,
    -119.50952F, -119.52314F,
    1064.1486F, 1064.1686F,
    -1064.405F, -1064.3646F,
    -1064.4854F, -1064.4657F,
    0.8110052F, -0.8110288F,
    -0.8112193F, 2.1798081F
};

/* to here: all that IEEE arithmetic can give. */
static const omni_board_real omni_board_greatest[38] = {
    1.6898406F, -1.6898052F,
    -1.6897837F, 0.8110837F,
    0.81106895F, -0.810811F,
    -0.8108185F, 2.180346F,
    2.1803746F, 1.6901747F,
    1.690318F, -1.6893616F,
    -1.6890539F, 0.8114734F,
    0.8119535F, -0.81027967F,
    -0.8097661F, 2.1811223F,
    2.181661F, 1.6911467F,
    1.6915846F, -1.6880448F,
    -1.6878976F, 0.8127757F,
    119.48468F, 119.490486F,
    -119.45673F, -119.44091F,
    1064.3301F, 1064.3099F,
    -1064.0736F, -1064.114F,
    -1063.9933F, -1064.013F,
    0.81101996F, -0.81099635F,
    -0.8108059F, 2.1802592F
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
    0.22049761F, 0.3983438F,
    0.45702973F, 0.97906286F,
    0.59092706F, 1.6847514F,
    1.2274722F, 1.9364358F,
    1.730749F, 1.9497309F,
    2.3340015F, 2.0505047F,
    3.0247326F, 1.9796395F,
    3.5041876F, 2.5619469F,
    3.9306083F, 3.130169F,
    4.229857F, 3.7983665F,
    4.6271234F, 4.5535893F,
    4.796381F, 4.6775637F,
    0.1720993F, 0.76911414F,
    1.437421F, 2.233863F,
    2.08103F, 1.5009052F,
    4.1521955F, 3.2553985F,
    8.670213F, 8.315884F,
    0.22500801F, 0.27499485F,
    4.7749615F, 4.6874847F
};

/* u may be from here */
static const omni_board_real omni_board_least_at_ticks[38] = {
    1.6864035F, -1.7062926F,
    -1.6917558F, 0.80288565F,
    0.8097011F, -0.8127057F,
    -0.8300458F, 2.1799111F,
    2.1637962F, 1.6897272F,
    1.6815146F, -1.6899302F,
    -1.6916152F, 0.8107691F,
    0.7981293F, -0.832192F,
    -0.81977415F, 2.1619606F,
    2.1739497F, 1.680558F,
    1.688671F, -1.6918232F,
    -1.6908582F, 0.80509907F,
    118.97364F, 117.07298F,
    -125.47987F, -119.501465F,
    1064.2216F, 1064.2252F,
    -1064.2639F, -1064.2582F,
    -1064.2689F, -1064.2666F,
    0.8110052F, -0.8110288F,
    -0.8112192F, 2.1798081F
};

/* to here: all that IEEE arithmetic can give. */
static const omni_board_real omni_board_greatest_at_ticks[38] = {
    1.686422F, -1.706246F,
    -1.691704F, 0.8029616F,
    0.8097457F, -0.8125551F,
    -0.8299318F, 2.1800935F,
    2.163958F, 1.6898917F,
    1.6817107F, -1.6897438F,
    -1.691347F, 0.81092775F,
    0.7984106F, -0.831968F,
    -0.81943876F, 2.1622531F,
    2.1743464F, 1.6808773F,
    1.6890613F, -1.6914258F,
    -1.6904399F, 0.80547667F,
    118.975716F, 117.08096F,
    -125.4634F, -119.47799F,
    1064.2571F, 1064.2533F,
    -1064.2146F, -1064.2205F,
    -1064.2097F, -1064.212F,
    0.81101996F, -0.81099635F,
    -0.8108059F, 2.1802592F
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
