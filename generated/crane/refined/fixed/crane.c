/* crane.c: prescribed-time reach-avoid-stay controller, refined tube, in integers of 32 bits.
 *
 * Certified (crane.certificate.json): for every t the tube keeps 0.05 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The plant is of order 2: xdot = v, vdot = f + g u + w, and v is measured too. Covered is every start
 * at rest in it; gamma(0) is in the certificate.
 * The state stays in it (P9) sampled at ticks, every 0.02 s or faster, from every start with |e(0)| <= 0.9 at rest,
 * for |f + w| <= 0.1, 0.9 <= g_ii <= 1.1, |g_ij| <= 0: |e| of v + lambda x < 0.9001, |u| <= 1.5.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 * No value leaves 32 bits, whatever the arguments.
 */
#include "crane.h"

#include <stdbool.h>

/* Tables stay in flash: an AVR reads it by instructions of its own. */
#if defined(__AVR__)
#include <avr/pgmspace.h>
#define CRANE_FLASH PROGMEM
#define CRANE_READ_8(entry) ((int32_t)pgm_read_byte(&(entry)))
#define CRANE_READ_16(entry) ((int32_t)pgm_read_word(&(entry)))
#define CRANE_READ_32(entry) ((int32_t)pgm_read_dword(&(entry)))
#else
#define CRANE_FLASH
#define CRANE_READ_8(entry) ((int32_t)(entry))
#define CRANE_READ_16(entry) ((int32_t)(entry))
#define CRANE_READ_32(entry) ((int32_t)(entry))
#endif

/* A negative number moves right as if by a division that rounds down: C leaves that to the compiler. */
typedef char crane_shifts_down[((-3) >> 1 == -2) ? 1 : -1];

#if defined(__AVR__)
/* a / 2^n rounded down, and a 2^n of a >= 0, by bytes first. */
static inline int32_t crane_down(int32_t a, int32_t n)
{
    int32_t rest = a;
    if (__builtin_constant_p(n) && (n >= 16)) {
        return (int16_t)(a >> 16) >> (n - 16);
    }
    if (__builtin_constant_p(n) && (n > 12)) {
        return ((a >> 16) * ((int32_t)1 << (16 - n))) + (int32_t)((uint16_t)a >> n);
    }
    if (((uint8_t)n & 16U) != 0U) { rest >>= 16; }
    if (((uint8_t)n & 8U) != 0U) { rest >>= 8; }
    for (uint8_t k = (uint8_t)n & 7U; k != 0U; --k) { rest >>= 1; }
    return rest;
}

static inline int32_t crane_up(int32_t a, int32_t n)
{
    uint32_t rest = (uint32_t)a;
    if (((uint8_t)n & 16U) != 0U) { rest <<= 16; }
    if (((uint8_t)n & 8U) != 0U) { rest <<= 8; }
    for (uint8_t k = (uint8_t)n & 7U; k != 0U; --k) { rest <<= 1; }
    rest &= 0x7fffffffU;
    return (int32_t)rest;
}

/* a b, a of 16 bits with a sign, b of 16 without one. */
static inline int32_t crane_product(int32_t a, int32_t b)
{
    int16_t own = (int16_t)a;
    uint16_t other = (uint16_t)b;
    __asm__("" : "+r"(own), "+r"(other));
    return (int32_t)own * (int32_t)other;
}

/* a b / 2^16 rounded down, for 0 <= b < 2^16. */
static inline int32_t crane_upper(int32_t a, int32_t b)
{
    uint16_t own = (uint16_t)a;
    uint16_t other = (uint16_t)b;
    __asm__("" : "+r"(own), "+r"(other));
    const uint32_t low = (uint32_t)own * other;
    return crane_product(a >> 16, b) + (int32_t)(low >> 16);
}
#else
/* a / 2^n rounded down, and a 2^n of a >= 0. */
static inline int32_t crane_down(int32_t a, int32_t n)
{
    return a >> n;
}

static inline int32_t crane_up(int32_t a, int32_t n)
{
    const uint32_t moved = ((uint32_t)a << (uint32_t)n) & 0x7fffffffU;
    return (int32_t)moved;
}

/* a b, a of 16 bits with a sign, b of 16 without one. */
static inline int32_t crane_product(int32_t a, int32_t b)
{
    return a * b;
}

/* a b / 2^16 rounded down, for 0 <= b < 2^16. */
static inline int32_t crane_upper(int32_t a, int32_t b)
{
    const uint32_t low = ((uint32_t)a & 0xffffU) * (uint32_t)b;
    return (crane_down(a, 16) * b) + (int32_t)(low >> 16);
}
#endif

/* By how many places the bits of a > 0 can move up. */
static inline int32_t crane_leading(int32_t a)
{
    uint32_t rest = (uint32_t)a;
    int32_t places = 0;
    if (rest < 0x8000U) { rest <<= 16; places = 16; }
    if (rest < 0x800000U) { rest <<= 8; places += 8; }
    if (rest < 0x8000000U) { rest <<= 4; places += 4; }
    if (rest < 0x20000000U) { rest <<= 2; places += 2; }
    if (rest < 0x40000000U) { places += 1; }
    return places;
}

/* a mod 2^k, mask being 2^k - 1. */
static inline int32_t crane_low(int32_t a, int32_t mask)
{
    const uint32_t bits = (uint32_t)a & (uint32_t)mask;
    return (int32_t)bits;
}

/* B-spline control points divided by 6, in 2^-18, a row for each of 32 + 3 points. */
static const int32_t crane_coefficients[140] CRANE_FLASH = {
    8417, 34610, 9068, 35262,
    8915, 35108, 8589, 34782,
    8417, 34610, 9068, 35262,
    6992, 33185, 10507, 36700,
    6562, 32755, 12905, 39098,
    7127, 33320, 16262, 42455,
    8689, 34882, 20577, 46770,
    11247, 37440, 25852, 52045,
    14801, 40994, 32086, 58279,
    19351, 45544, 39279, 65472,
    24897, 51090, 47432, 73625,
    31440, 57633, 56543, 82736,
    38978, 65171, 66613, 92806,
    47513, 73706, 77642, 103835,
    57044, 83237, 88535, 114728,
    67571, 93764, 98469, 124662,
    79093, 105287, 107444, 133637,
    91613, 117806, 115460, 141653,
    105128, 131321, 122516, 148709,
    119074, 145267, 128614, 154807,
    132023, 158216, 133752, 159945,
    143977, 170170, 137932, 164125,
    154934, 181127, 141152, 167345,
    164895, 191088, 143413, 169606,
    173860, 200053, 144716, 170909,
    181829, 208022, 145059, 171252,
    188802, 214995, 144443, 170636,
    194779, 220972, 142868, 169061,
    199759, 225952, 140333, 166527,
    203744, 229937, 136842, 163036,
    206732, 232925, 133965, 160158,
    208724, 234917, 132047, 158240,
    209721, 235914, 131088, 157281,
    209721, 235914, 131088, 157281,
    209721, 235914, 131088, 157281
};

/* lambda by component, in 2^-16. */
static const uint16_t crane_filters[2] CRANE_FLASH = {
    43360, 42848
};

/* Quadratics level - (slope - bend t) t, by row: 16 for 1/d, d in [2^30, 2^31), then
 * 8 for each octave of y, for H = 4 ln((2 - y)/y)/((1 - y) y (2 - y)), which also moves up, by:
 */
static const uint16_t crane_levels[72] CRANE_FLASH = {
    65535,
    61680,
    58253,
    55187,
    52428,
    49931,
    47662,
    45590,
    43690,
    41942,
    40329,
    38836,
    37449,
    36157,
    34952,
    33824,
    47996,
    43453,
    40084,
    37570,
    35709,
    34368,
    33463,
    32939,
    48578,
    42676,
    38104,
    34475,
    63078,
    58254,
    54239,
    50862,
    54083,
    47061,
    41588,
    37216,
    33653,
    61399,
    56435,
    52211,
    61945,
    53773,
    47386,
    42270,
    38090,
    34617,
    63381,
    58389,
    35589,
    61813,
    54476,
    48588,
    43766,
    39753,
    36366,
    33472,
    40628,
    35334,
    62356,
    55671,
    50189,
    45618,
    41754,
    38448,
    45928,
    40013,
    35361,
    63229,
    57073,
    51933,
    47583,
    43856
};

static const uint16_t crane_slopes[72] CRANE_FLASH = {
    8175,
    7244,
    6462,
    5801,
    5236,
    4750,
    4328,
    3960,
    3638,
    3353,
    3100,
    2875,
    2673,
    2492,
    2329,
    2181,
    10462,
    7720,
    5762,
    4297,
    3151,
    2213,
    1410,
    687,
    13374,
    10243,
    8053,
    6465,
    10558,
    8741,
    7319,
    6186,
    15875,
    12226,
    9672,
    7819,
    6435,
    10755,
    9103,
    7790,
    18451,
    14251,
    11303,
    9162,
    7560,
    6333,
    10747,
    9221,
    10561,
    16353,
    13000,
    10558,
    8728,
    7324,
    6225,
    5350,
    11929,
    9256,
    14744,
    11996,
    9934,
    8349,
    7107,
    6116,
    13316,
    10351,
    8259,
    13461,
    11163,
    9396,
    8008,
    6900
};

static const uint16_t crane_bends[72] CRANE_FLASH = {
    467,
    392,
    331,
    283,
    244,
    211,
    184,
    162,
    143,
    127,
    113,
    101,
    91,
    82,
    74,
    67,
    1384,
    987,
    737,
    576,
    471,
    403,
    363,
    344,
    1581,
    1104,
    799,
    596,
    913,
    714,
    569,
    461,
    1842,
    1287,
    933,
    696,
    532,
    830,
    659,
    531,
    2120,
    1485,
    1078,
    805,
    616,
    482,
    766,
    618,
    1203,
    1690,
    1229,
    920,
    705,
    552,
    439,
    355,
    1349,
    949,
    1383,
    1037,
    796,
    624,
    497,
    402,
    1496,
    1054,
    769,
    1155,
    888,
    697,
    556,
    451
};

static const uint8_t crane_places[72] CRANE_FLASH = {
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    0,
    1,
    1,
    1,
    1,
    1,
    1,
    1,
    1,
    2,
    2,
    2,
    2,
    1,
    1,
    1,
    1,
    3,
    3,
    3,
    3,
    3,
    2,
    2,
    2,
    4,
    4,
    4,
    4,
    4,
    4,
    3,
    3,
    6,
    5,
    5,
    5,
    5,
    5,
    5,
    5,
    7,
    7,
    6,
    6,
    6,
    6,
    6,
    6,
    8,
    8,
    8,
    7,
    7,
    7,
    7,
    7
};

/* By component: the gain, 16 bits of it. */
static const uint16_t crane_gains[2] CRANE_FLASH = {
    34341, 33161
};

/* By how many places less u moves up. */
static const uint8_t crane_offsets[2] CRANE_FLASH = {
    16, 16
};

/* The largest |u|. */
static const int32_t crane_limits[2] CRANE_FLASH = {
    25165824, 25165824
};

/* Covered starts have x strictly above these bounds, by component. */
static const uint16_t crane_start_lower[2] CRANE_FLASH = {
    60352, 60350
};

/* Covered starts have x strictly below these bounds, by component. */
static const int32_t crane_start_upper[2] CRANE_FLASH = {
    201794, 201794
};

/* The same of v + lambda x: strictly above these bounds. */
static const uint16_t crane_filtered_start_lower[2] CRANE_FLASH = {
    39931, 39459
};

/* The same of v + lambda x: strictly below these bounds. */
static const int32_t crane_filtered_start_upper[2] CRANE_FLASH = {
    133510, 131933
};

/* Table index of the segment at a tick, and s in 2^-16 of it. */
static inline void crane_segment(uint32_t tick, int32_t *row, int32_t *s)
{
    const bool running = tick < 2400U;
    const uint32_t held = running ? tick : 2400U;
    const int32_t count = (int32_t)held;
    const int32_t count_low = crane_low(count, 65535);
    const int32_t passed = crane_upper(57266231, count_low);
    const bool place_under = passed < 2097151;
    const int32_t place = place_under ? passed : 2097151;
    const int32_t segment = crane_down(place, 16);
    const int32_t share = crane_low(place, 65535);
    const int32_t first = segment * 4;
    *row = first;
    *s = share;
}

/* At s: (1 - s)^3 and s^3 in 2^-15, 3 s + 3 s^2 - 2 s^3 in 2^-14. */
static inline void crane_weights(int32_t s, int32_t *w0, int32_t *w1, int32_t *w2)
{
    const int32_t s_up = crane_up(s, 12);
    const int32_t square = crane_upper(s_up, s);
    const int32_t cube = crane_upper(square, s);
    const int32_t sum = s_up + square;
    const int32_t sum_3 = sum * 3;
    const int32_t cube_2 = cube * 2;
    const int32_t bend = sum_3 - cube_2;
    const int32_t less = s_up - square;
    const bool less_held_over = 0 < less;
    const int32_t less_held = less_held_over ? less : 0;
    const int32_t less_3 = less_held * 3;
    const int32_t left_square = 268435456 - less_3;
    const int32_t left = left_square - cube;
    const bool bend_held_over = 0 < bend;
    const int32_t bend_held = bend_held_over ? bend : 0;
    const int32_t bend_near_half = bend_held + 8192;
    const int32_t bend_near = crane_down(bend_near_half, 14);
    const bool left_held_over = 0 < left;
    const int32_t left_held = left_held_over ? left : 0;
    const int32_t before_half = left_held + 4096;
    const int32_t before = crane_down(before_half, 13);
    const bool middle_under = bend_near < 65535;
    const int32_t middle = middle_under ? bend_near : 65535;
    const int32_t after_half = cube + 4096;
    const int32_t after = crane_down(after_half, 13);
    *w0 = before;
    *w1 = middle;
    *w2 = after;
}

/* At s, in 2^-11 a second: 3 (1 - s)^2, 3 + 6 s (1 - s) and 3 s^2 times the segments in a second. */
static inline void crane_rates(int32_t s, int32_t *r0, int32_t *r1, int32_t *r2)
{
    const int32_t s_up = crane_up(s, 12);
    const int32_t square = crane_upper(s_up, s);
    const int32_t less = s_up - square;
    const bool less_held_over = 0 < less;
    const int32_t less_held = less_held_over ? less : 0;
    const bool less_most_under = less_held < 67108864;
    const int32_t less_most = less_most_under ? less_held : 67108864;
    const int32_t one_less = 268435456 - s_up;
    const int32_t left = one_less - less_most;
    const bool left_held_over = 0 < left;
    const int32_t left_held = left_held_over ? left : 0;
    const int32_t less_2 = less_most * 2;
    const int32_t middle = 268435456 + less_2;
    const int32_t before_3 = left_held * 3;
    const int32_t before_second = crane_upper(before_3, 43690);
    const int32_t before_half = before_second + 16384;
    const int32_t before = crane_down(before_half, 15);
    const int32_t between_3 = middle * 3;
    const int32_t between_second = crane_upper(between_3, 43690);
    const int32_t between_half = between_second + 16384;
    const int32_t between = crane_down(between_half, 15);
    const int32_t after_3 = square * 3;
    const int32_t after_second = crane_upper(after_3, 43690);
    const int32_t after_half = after_second + 16384;
    const int32_t after = crane_down(after_half, 15);
    *r0 = before;
    *r1 = between;
    *r2 = after;
}

/* An edge of the tube, and its rate in units a second, by the steps about it. */
static inline void crane_edge(int32_t at, int32_t w0, int32_t w1, int32_t w2, int32_t r0, int32_t r1,
                              int32_t r2, int32_t *edge, int32_t *rate)
{
    const int32_t at_q0 = CRANE_READ_32(crane_coefficients[at]);
    const int32_t at_1 = at + 4;
    const int32_t at_q1 = CRANE_READ_32(crane_coefficients[at_1]);
    const int32_t at_2 = at + 8;
    const int32_t at_q2 = CRANE_READ_32(crane_coefficients[at_2]);
    const int32_t at_3 = at + 12;
    const int32_t at_q3 = CRANE_READ_32(crane_coefficients[at_3]);
    const int32_t apart_0 = at_q1 - at_q0;
    const int32_t apart_1 = at_q2 - at_q1;
    const int32_t apart_2 = at_q3 - at_q2;
    const int32_t d0 = (int32_t)(int16_t)apart_0;
    const int32_t d1 = (int32_t)(int16_t)apart_1;
    const int32_t d2 = (int32_t)(int16_t)apart_2;
    const int32_t q1_6 = at_q1 * 6;
    const int32_t base = q1_6 + d1;
    const int32_t d1_w1 = crane_product(d1, w1);
    const int32_t middle = crane_down(d1_w1, 14);
    const int32_t d2_w2 = crane_product(d2, w2);
    const int32_t d0_w0 = crane_product(d0, w0);
    const int32_t outer = d2_w2 - d0_w0;
    const int32_t ends = crane_down(outer, 15);
    const int32_t bent = base + middle;
    const int32_t value = bent + ends;
    const int32_t d1_r1 = crane_product(d1, r1);
    const int32_t between = crane_down(d1_r1, 11);
    const int32_t d0_r0 = crane_product(d0, r0);
    const int32_t d2_r2 = crane_product(d2, r2);
    const int32_t about = d0_r0 + d2_r2;
    const int32_t around = crane_down(about, 11);
    const int32_t slope = between + around;
    *edge = value;
    *rate = slope;
}

/* The quadratic of a row, level - (slope - bend t) t, at t in 2^-16. */
static inline int32_t crane_curve(int32_t row, int32_t t)
{
    const int32_t level = CRANE_READ_16(crane_levels[row]);
    const int32_t slope = CRANE_READ_16(crane_slopes[row]);
    const int32_t bend = CRANE_READ_16(crane_bends[row]);
    const int32_t bend_t = crane_product(bend, t);
    const int32_t bent = crane_down(bend_t, 16);
    const int32_t down = slope - bent;
    const int32_t down_t = crane_product(down, t);
    const int32_t fall = crane_down(down_t, 17);
    const int32_t left = level - fall;
    const int32_t found = crane_low(left, 65535);
    return found;
}

/* |u|: gain e H/d, at most `limit`. */
static inline int32_t crane_push(int32_t e, int32_t rise, int32_t over, int32_t gain, int32_t places,
                                 int32_t limit)
{
    const int32_t steep = crane_upper(e, rise);
    const int32_t over_width = crane_upper(steep, over);
    const int32_t size = crane_upper(over_width, gain);
    const int32_t moved = crane_down(size, places);
    const bool push_held_under = moved < limit;
    const int32_t push_held = push_held_under ? moved : limit;
    return push_held;
}

void crane_tube(uint32_t tick, int32_t lower[CRANE_N], int32_t upper[CRANE_N])
{
    int32_t row;
    int32_t s;
    crane_segment(tick, &row, &s);
    int32_t w0;
    int32_t w1;
    int32_t w2;
    crane_weights(s, &w0, &w1, &w2);
    int32_t r0;
    int32_t r1;
    int32_t r2;
    crane_rates(s, &r0, &r1, &r2);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        int32_t lower_edge;
        int32_t lower_rate;
        crane_edge(lower_at, w0, w1, w2, r0, r1, r2, &lower_edge, &lower_rate);
        int32_t upper_edge;
        int32_t upper_rate;
        crane_edge(upper_at, w0, w1, w2, r0, r1, r2, &upper_edge, &upper_rate);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

void crane_filtered_tube(uint32_t tick, int32_t lower[CRANE_N], int32_t upper[CRANE_N])
{
    int32_t row;
    int32_t s;
    crane_segment(tick, &row, &s);
    int32_t w0;
    int32_t w1;
    int32_t w2;
    crane_weights(s, &w0, &w1, &w2);
    int32_t r0;
    int32_t r1;
    int32_t r2;
    crane_rates(s, &r0, &r1, &r2);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t filter_i = CRANE_READ_16(crane_filters[i]);
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        int32_t lower_edge;
        int32_t lower_rate;
        crane_edge(lower_at, w0, w1, w2, r0, r1, r2, &lower_edge, &lower_rate);
        int32_t upper_edge;
        int32_t upper_rate;
        crane_edge(upper_at, w0, w1, w2, r0, r1, r2, &upper_edge, &upper_rate);
        const int32_t lower_filtered = crane_upper(lower_edge, filter_i);
        const int32_t lower_z = lower_rate + lower_filtered;
        lower[i] = lower_z;
        const int32_t upper_filtered = crane_upper(upper_edge, filter_i);
        const int32_t upper_z = upper_rate + upper_filtered;
        upper[i] = upper_z;
    }
}

crane_status crane_control(uint32_t tick, const int32_t x[CRANE_N], const int32_t v[CRANE_N],
                           int32_t u[CRANE_N])
{
    int32_t row;
    int32_t s;
    crane_segment(tick, &row, &s);
    int32_t w0;
    int32_t w1;
    int32_t w2;
    crane_weights(s, &w0, &w1, &w2);
    int32_t r0;
    int32_t r1;
    int32_t r2;
    crane_rates(s, &r0, &r1, &r2);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        int32_t lower_edge;
        int32_t lower_rate;
        crane_edge(lower_at, w0, w1, w2, r0, r1, r2, &lower_edge, &lower_rate);
        int32_t upper_edge;
        int32_t upper_rate;
        crane_edge(upper_at, w0, w1, w2, r0, r1, r2, &upper_edge, &upper_rate);
        const int32_t x_all = x[i];
        const bool x_near_over = (-67108864) < x_all;
        const int32_t x_near = x_near_over ? x_all : (-67108864);
        const bool x_i_under = x_near < 67108864;
        const int32_t x_i = x_i_under ? x_near : 67108864;
        const int32_t x_lower = x_i - lower_edge;
        const int32_t x_upper = upper_edge - x_i;
        const int32_t v_all = v[i];
        const bool v_near_over = (-268435456) < v_all;
        const int32_t v_near = v_near_over ? v_all : (-268435456);
        const bool v_i_under = v_near < 268435456;
        const int32_t v_i = v_i_under ? v_near : 268435456;
        const int32_t v_lower = v_i - lower_rate;
        const int32_t v_upper = upper_rate - v_i;
        const int32_t filter_i = CRANE_READ_16(crane_filters[i]);
        const int32_t lower_filtered = crane_upper(x_lower, filter_i);
        const int32_t to_lower = v_lower + lower_filtered;
        const int32_t upper_filtered = crane_upper(x_upper, filter_i);
        const int32_t to_upper = v_upper + upper_filtered;
        const int32_t room = to_lower + to_upper;
        const int32_t apart = to_lower - to_upper;
        const bool e_width_over = 65536 < room;
        const int32_t e_width = e_width_over ? room : 65536;
        const int32_t e_n = crane_leading(e_width);
        const int32_t e_width_up = crane_up(e_width, e_n);
        const int32_t e_over_bits = crane_down(e_width_up, 26);
        const int32_t e_over_head = crane_low(e_over_bits, 15);
        const int32_t e_over_tail = crane_down(e_width_up, 10);
        const int32_t e_over_t = crane_low(e_over_tail, 65535);
        const int32_t e_over = crane_curve(e_over_head, e_over_t);
        const bool upper_nearer = 0 < apart;
        const int32_t minus = -apart;
        const int32_t off = upper_nearer ? apart : minus;
        const bool off_held_under = off < e_width;
        const int32_t off_held = off_held_under ? off : e_width;
        const int32_t off_up = crane_up(off_held, e_n);
        const int32_t e_all = crane_upper(off_up, e_over);
        const bool e_under = e_all < 1063134168;
        const int32_t e = e_under ? e_all : 1063134168;
        const int32_t rest = e_width_up - off_up;
        const int32_t y_all = crane_upper(rest, e_over);
        const bool y_near_over = 10736107 < y_all;
        const int32_t y_near = y_near_over ? y_all : 10736107;
        const bool y_under = y_near < 1073741823;
        const int32_t y = y_under ? y_near : 1073741823;
        const int32_t m = crane_leading(y);
        const int32_t octaves = m * 8;
        const int32_t octave = octaves + 8;
        const int32_t y_up = crane_up(y, m);
        const int32_t rise_bits = crane_down(y_up, 27);
        const int32_t rise_head = crane_low(rise_bits, 7);
        const int32_t rise_row = rise_head + octave;
        const int32_t rise_tail = crane_down(y_up, 11);
        const int32_t rise_t = crane_low(rise_tail, 65535);
        const int32_t rise = crane_curve(rise_row, rise_t);
        const int32_t rise_places = CRANE_READ_8(crane_places[rise_row]);
        const int32_t gain = CRANE_READ_16(crane_gains[i]);
        const int32_t offset = CRANE_READ_8(crane_offsets[i]);
        const int32_t limit = CRANE_READ_32(crane_limits[i]);
        const int32_t down_n = offset - e_n;
        const int32_t down_all = down_n - rise_places;
        const bool down_over = 0 < down_all;
        const int32_t down = down_over ? down_all : 0;
        const int32_t push = crane_push(e, rise, e_over, gain, down, limit);
        const int32_t back = -push;
        const int32_t u_i = upper_nearer ? back : push;
        u[i] = u_i;
        const bool within = off < room;
        const bool over = 0 < x_lower;
        const bool under = 0 < x_upper;
        const bool between = over && under;
        const bool inside = within && between;
        const bool outside_any = inside ? outside : true;
        outside = outside_any;
    }
    return outside ? CRANE_OUTSIDE_TUBE : CRANE_OK;
}

int32_t crane_margin(uint32_t tick, const int32_t x[CRANE_N], const int32_t v[CRANE_N])
{
    int32_t row;
    int32_t s;
    crane_segment(tick, &row, &s);
    int32_t w0;
    int32_t w1;
    int32_t w2;
    crane_weights(s, &w0, &w1, &w2);
    int32_t r0;
    int32_t r1;
    int32_t r2;
    crane_rates(s, &r0, &r1, &r2);
    int32_t margin = 32768;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        int32_t lower_edge;
        int32_t lower_rate;
        crane_edge(lower_at, w0, w1, w2, r0, r1, r2, &lower_edge, &lower_rate);
        int32_t upper_edge;
        int32_t upper_rate;
        crane_edge(upper_at, w0, w1, w2, r0, r1, r2, &upper_edge, &upper_rate);
        const int32_t x_all = x[i];
        const bool x_near_over = (-67108864) < x_all;
        const int32_t x_near = x_near_over ? x_all : (-67108864);
        const bool x_i_under = x_near < 67108864;
        const int32_t x_i = x_i_under ? x_near : 67108864;
        const int32_t x_lower = x_i - lower_edge;
        const int32_t x_upper = upper_edge - x_i;
        const int32_t v_all = v[i];
        const bool v_near_over = (-268435456) < v_all;
        const int32_t v_near = v_near_over ? v_all : (-268435456);
        const bool v_i_under = v_near < 268435456;
        const int32_t v_i = v_i_under ? v_near : 268435456;
        const int32_t v_lower = v_i - lower_rate;
        const int32_t v_upper = upper_rate - v_i;
        const int32_t filter_i = CRANE_READ_16(crane_filters[i]);
        const int32_t lower_filtered = crane_upper(x_lower, filter_i);
        const int32_t to_lower = v_lower + lower_filtered;
        const int32_t upper_filtered = crane_upper(x_upper, filter_i);
        const int32_t to_upper = v_upper + upper_filtered;
        const int32_t share_room = to_lower + to_upper;
        const bool share_width_over = 65536 < share_room;
        const int32_t share_width = share_width_over ? share_room : 65536;
        const int32_t share_n = crane_leading(share_width);
        const int32_t share_width_up = crane_up(share_width, share_n);
        const int32_t share_over_bits = crane_down(share_width_up, 26);
        const int32_t share_over_head = crane_low(share_over_bits, 15);
        const int32_t share_over_tail = crane_down(share_width_up, 10);
        const int32_t share_over_t = crane_low(share_over_tail, 65535);
        const int32_t share_over = crane_curve(share_over_head, share_over_t);
        const bool share_high = to_upper < to_lower;
        const int32_t share_nearest = share_high ? to_upper : to_lower;
        const bool share_inside = 0 < share_nearest;
        const int32_t share_beyond = -share_nearest;
        const int32_t share_size = share_inside ? share_nearest : share_beyond;
        const bool share_held_under = share_size < share_width;
        const int32_t share_held = share_held_under ? share_size : share_width;
        const int32_t share_up = crane_up(share_held, share_n);
        const int32_t share_quotient = crane_upper(share_up, share_over);
        const int32_t share_part = crane_down(share_quotient, 14);
        const bool share_most_under = share_part < 65535;
        const int32_t share_most = share_most_under ? share_part : 65535;
        const int32_t share_minus = (-1) - share_most;
        const int32_t share = share_inside ? share_most : share_minus;
        const int32_t place_room = x_lower + x_upper;
        const bool place_width_over = 131072 < place_room;
        const int32_t place_width = place_width_over ? place_room : 131072;
        const int32_t place_n = crane_leading(place_width);
        const int32_t place_width_up = crane_up(place_width, place_n);
        const int32_t place_over_bits = crane_down(place_width_up, 26);
        const int32_t place_over_head = crane_low(place_over_bits, 15);
        const int32_t place_over_tail = crane_down(place_width_up, 10);
        const int32_t place_over_t = crane_low(place_over_tail, 65535);
        const int32_t place_over = crane_curve(place_over_head, place_over_t);
        const bool place_high = x_upper < x_lower;
        const int32_t place_nearest = place_high ? x_upper : x_lower;
        const bool place_inside = 0 < place_nearest;
        const int32_t place_beyond = -place_nearest;
        const int32_t place_size = place_inside ? place_nearest : place_beyond;
        const bool place_held_under = place_size < place_width;
        const int32_t place_held = place_held_under ? place_size : place_width;
        const int32_t place_up = crane_up(place_held, place_n);
        const int32_t place_quotient = crane_upper(place_up, place_over);
        const int32_t place_part = crane_down(place_quotient, 14);
        const bool place_most_under = place_part < 65535;
        const int32_t place_most = place_most_under ? place_part : 65535;
        const int32_t place_minus = (-1) - place_most;
        const int32_t place = place_inside ? place_most : place_minus;
        const bool filtered_less = share < place;
        const int32_t lesser = filtered_less ? share : place;
        const bool less = lesser < margin;
        const int32_t margin_next = less ? lesser : margin;
        margin = margin_next;
    }
    return margin;
}

void crane_margins(uint32_t tick, const int32_t x[CRANE_N], const int32_t v[CRANE_N], int32_t margin[CRANE_N])
{
    int32_t row;
    int32_t s;
    crane_segment(tick, &row, &s);
    int32_t w0;
    int32_t w1;
    int32_t w2;
    crane_weights(s, &w0, &w1, &w2);
    int32_t r0;
    int32_t r1;
    int32_t r2;
    crane_rates(s, &r0, &r1, &r2);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        int32_t lower_edge;
        int32_t lower_rate;
        crane_edge(lower_at, w0, w1, w2, r0, r1, r2, &lower_edge, &lower_rate);
        int32_t upper_edge;
        int32_t upper_rate;
        crane_edge(upper_at, w0, w1, w2, r0, r1, r2, &upper_edge, &upper_rate);
        const int32_t x_all = x[i];
        const bool x_near_over = (-67108864) < x_all;
        const int32_t x_near = x_near_over ? x_all : (-67108864);
        const bool x_i_under = x_near < 67108864;
        const int32_t x_i = x_i_under ? x_near : 67108864;
        const int32_t x_lower = x_i - lower_edge;
        const int32_t x_upper = upper_edge - x_i;
        const int32_t v_all = v[i];
        const bool v_near_over = (-268435456) < v_all;
        const int32_t v_near = v_near_over ? v_all : (-268435456);
        const bool v_i_under = v_near < 268435456;
        const int32_t v_i = v_i_under ? v_near : 268435456;
        const int32_t v_lower = v_i - lower_rate;
        const int32_t v_upper = upper_rate - v_i;
        const int32_t filter_i = CRANE_READ_16(crane_filters[i]);
        const int32_t lower_filtered = crane_upper(x_lower, filter_i);
        const int32_t to_lower = v_lower + lower_filtered;
        const int32_t upper_filtered = crane_upper(x_upper, filter_i);
        const int32_t to_upper = v_upper + upper_filtered;
        const int32_t share_room = to_lower + to_upper;
        const bool share_width_over = 65536 < share_room;
        const int32_t share_width = share_width_over ? share_room : 65536;
        const int32_t share_n = crane_leading(share_width);
        const int32_t share_width_up = crane_up(share_width, share_n);
        const int32_t share_over_bits = crane_down(share_width_up, 26);
        const int32_t share_over_head = crane_low(share_over_bits, 15);
        const int32_t share_over_tail = crane_down(share_width_up, 10);
        const int32_t share_over_t = crane_low(share_over_tail, 65535);
        const int32_t share_over = crane_curve(share_over_head, share_over_t);
        const bool share_high = to_upper < to_lower;
        const int32_t share_nearest = share_high ? to_upper : to_lower;
        const bool share_inside = 0 < share_nearest;
        const int32_t share_beyond = -share_nearest;
        const int32_t share_size = share_inside ? share_nearest : share_beyond;
        const bool share_held_under = share_size < share_width;
        const int32_t share_held = share_held_under ? share_size : share_width;
        const int32_t share_up = crane_up(share_held, share_n);
        const int32_t share_quotient = crane_upper(share_up, share_over);
        const int32_t share_part = crane_down(share_quotient, 14);
        const bool share_most_under = share_part < 65535;
        const int32_t share_most = share_most_under ? share_part : 65535;
        const int32_t share_minus = (-1) - share_most;
        const int32_t share = share_inside ? share_most : share_minus;
        const int32_t place_room = x_lower + x_upper;
        const bool place_width_over = 131072 < place_room;
        const int32_t place_width = place_width_over ? place_room : 131072;
        const int32_t place_n = crane_leading(place_width);
        const int32_t place_width_up = crane_up(place_width, place_n);
        const int32_t place_over_bits = crane_down(place_width_up, 26);
        const int32_t place_over_head = crane_low(place_over_bits, 15);
        const int32_t place_over_tail = crane_down(place_width_up, 10);
        const int32_t place_over_t = crane_low(place_over_tail, 65535);
        const int32_t place_over = crane_curve(place_over_head, place_over_t);
        const bool place_high = x_upper < x_lower;
        const int32_t place_nearest = place_high ? x_upper : x_lower;
        const bool place_inside = 0 < place_nearest;
        const int32_t place_beyond = -place_nearest;
        const int32_t place_size = place_inside ? place_nearest : place_beyond;
        const bool place_held_under = place_size < place_width;
        const int32_t place_held = place_held_under ? place_size : place_width;
        const int32_t place_up = crane_up(place_held, place_n);
        const int32_t place_quotient = crane_upper(place_up, place_over);
        const int32_t place_part = crane_down(place_quotient, 14);
        const bool place_most_under = place_part < 65535;
        const int32_t place_most = place_most_under ? place_part : 65535;
        const int32_t place_minus = (-1) - place_most;
        const int32_t place = place_inside ? place_most : place_minus;
        const bool filtered_less = share < place;
        const int32_t lesser = filtered_less ? share : place;
        margin[i] = lesser;
    }
}

bool crane_covered(const int32_t x[CRANE_N], const int32_t v[CRANE_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t x_all = x[i];
        const bool x_near_over = (-67108864) < x_all;
        const int32_t x_near = x_near_over ? x_all : (-67108864);
        const bool x_i_under = x_near < 67108864;
        const int32_t x_i = x_i_under ? x_near : 67108864;
        const int32_t v_all = v[i];
        const bool v_near_over = (-268435456) < v_all;
        const int32_t v_near = v_near_over ? v_all : (-268435456);
        const bool v_i_under = v_near < 268435456;
        const int32_t v_i = v_i_under ? v_near : 268435456;
        const int32_t filter_i = CRANE_READ_16(crane_filters[i]);
        const int32_t filtered = crane_upper(x_i, filter_i);
        const int32_t z = v_i + filtered;
        const int32_t x_lower = CRANE_READ_16(crane_start_lower[i]);
        const int32_t x_upper = CRANE_READ_32(crane_start_upper[i]);
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const int32_t z_lower = CRANE_READ_16(crane_filtered_start_lower[i]);
        const int32_t z_upper = CRANE_READ_32(crane_filtered_start_upper[i]);
        const bool z_above = z_lower < z;
        const bool z_below = z < z_upper;
        const bool z_inside = z_above && z_below;
        const bool inside = x_inside && z_inside;
        const bool covered_next = inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}
