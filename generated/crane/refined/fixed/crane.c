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

/* A negative number is shifted right as if by a division that rounds down: C leaves that to the compiler. */
typedef char crane_shifts_down[((-3) >> 1 == -2) ? 1 : -1];

#if defined(__AVR__)
/* a / 2^n rounded down, and a 2^n of a >= 0, by bytes first. */
static inline int32_t crane_shift_down(int32_t a, int32_t n)
{
    int32_t shifted = a;
    if (__builtin_constant_p(n) && (n >= 16)) {
        return (int16_t)(a >> 16) >> (n - 16);
    }
    if (__builtin_constant_p(n) && (n > 12)) {
        return ((a >> 16) * ((int32_t)1 << (16 - n))) + (int32_t)((uint16_t)a >> n);
    }
    if (((uint8_t)n & 16U) != 0U) { shifted >>= 16; }
    if (((uint8_t)n & 8U) != 0U) { shifted >>= 8; }
    for (uint8_t k = (uint8_t)n & 7U; k != 0U; --k) { shifted >>= 1; }
    return shifted;
}

static inline int32_t crane_shift_up(int32_t a, int32_t n)
{
    uint32_t shifted = (uint32_t)a;
    if (((uint8_t)n & 16U) != 0U) { shifted <<= 16; }
    if (((uint8_t)n & 8U) != 0U) { shifted <<= 8; }
    for (uint8_t k = (uint8_t)n & 7U; k != 0U; --k) { shifted <<= 1; }
    shifted &= 0x7fffffffU;
    return (int32_t)shifted;
}

/* a b, a of 16 bits with a sign, b of 16 without one. */
static inline int32_t crane_product(int32_t a, int32_t b)
{
    int16_t signed_half = (int16_t)a;
    uint16_t unsigned_half = (uint16_t)b;
    __asm__("" : "+r"(signed_half), "+r"(unsigned_half));
    return (int32_t)signed_half * (int32_t)unsigned_half;
}

/* a b / 2^16 rounded down, for 0 <= b < 2^16. */
static inline int32_t crane_high_product(int32_t a, int32_t b)
{
    uint16_t low_half = (uint16_t)a;
    uint16_t unsigned_half = (uint16_t)b;
    __asm__("" : "+r"(low_half), "+r"(unsigned_half));
    const uint32_t low_part = (uint32_t)low_half * unsigned_half;
    return crane_product(a >> 16, b) + (int32_t)(low_part >> 16);
}
#else
/* a / 2^n rounded down, and a 2^n of a >= 0. */
static inline int32_t crane_shift_down(int32_t a, int32_t n)
{
    return a >> n;
}

static inline int32_t crane_shift_up(int32_t a, int32_t n)
{
    const uint32_t shifted = ((uint32_t)a << (uint32_t)n) & 0x7fffffffU;
    return (int32_t)shifted;
}

/* a b, a of 16 bits with a sign, b of 16 without one. */
static inline int32_t crane_product(int32_t a, int32_t b)
{
    return a * b;
}

/* a b / 2^16 rounded down, for 0 <= b < 2^16. */
static inline int32_t crane_high_product(int32_t a, int32_t b)
{
    const uint32_t low_part = ((uint32_t)a & 0xffffU) * (uint32_t)b;
    return (crane_shift_down(a, 16) * b) + (int32_t)(low_part >> 16);
}
#endif

/* By how many bits a > 0 can be shifted up to [2^30, 2^31). */
static inline int32_t crane_leading(int32_t a)
{
    uint32_t shifted = (uint32_t)a;
    int32_t shift = 0;
    if (shifted < 0x8000U) { shifted <<= 16; shift = 16; }
    if (shifted < 0x800000U) { shifted <<= 8; shift += 8; }
    if (shifted < 0x8000000U) { shifted <<= 4; shift += 4; }
    if (shifted < 0x20000000U) { shifted <<= 2; shift += 2; }
    if (shifted < 0x40000000U) { shift += 1; }
    return shift;
}

/* a mod 2^k, mask being 2^k - 1. */
static inline int32_t crane_low_bits(int32_t a, int32_t mask)
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
 * 8 for each octave of y, for H = 4 ln((2 - y)/y)/((1 - y) y (2 - y)).
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

/* By row: H is its quadratic times 2 to this power, and a common one. */
static const uint8_t crane_h_shifts[72] CRANE_FLASH = {
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
    35861, 34603
};

/* The product e H/d times the gain is shifted down by this, less the shifts of d and of H's row. */
static const uint8_t crane_shift_offsets[2] CRANE_FLASH = {
    19, 19
};

/* The largest |u|. */
static const int32_t crane_limits[2] CRANE_FLASH = {
    50331648, 50331648
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
    const int32_t count_low = crane_low_bits(count, 65535);
    const int32_t passed = crane_high_product(57266231, count_low);
    const bool early = passed < 2097151;
    const int32_t place = early ? passed : 2097151;
    const int32_t segment = crane_shift_down(place, 16);
    const int32_t share = crane_low_bits(place, 65535);
    const int32_t first = segment * 4;
    *row = first;
    *s = share;
}

/* At s: (1 - s)^3 and s^3 in 2^-15, 3 s + 3 s^2 - 2 s^3 in 2^-14. */
static inline void crane_weights(int32_t s, int32_t *w0, int32_t *w1, int32_t *w2)
{
    const int32_t s_fine = crane_shift_up(s, 12);
    const int32_t square = crane_high_product(s_fine, s);
    const int32_t cube = crane_high_product(square, s);
    const int32_t sum = s_fine + square;
    const int32_t three_sums = sum * 3;
    const int32_t two_cubes = cube * 2;
    const int32_t middle = three_sums - two_cubes;
    const int32_t difference = s_fine - square;
    const bool difference_over = 0 < difference;
    const int32_t difference_raised = difference_over ? difference : 0;
    const int32_t three_differences = difference_raised * 3;
    const int32_t first_and_cube = 268435456 - three_differences;
    const int32_t first = first_and_cube - cube;
    const bool middle_over = 0 < middle;
    const int32_t middle_raised = middle_over ? middle : 0;
    const int32_t middle_and_half = middle_raised + 8192;
    const int32_t middle_rounded = crane_shift_down(middle_and_half, 14);
    const bool first_over = 0 < first;
    const int32_t first_raised = first_over ? first : 0;
    const int32_t first_and_half = first_raised + 4096;
    const int32_t first_weight = crane_shift_down(first_and_half, 13);
    const bool middle_under = middle_rounded < 65535;
    const int32_t middle_weight = middle_under ? middle_rounded : 65535;
    const int32_t last_and_half = cube + 4096;
    const int32_t last_weight = crane_shift_down(last_and_half, 13);
    *w0 = first_weight;
    *w1 = middle_weight;
    *w2 = last_weight;
}

/* At s, in 2^-11 a second: 3 (1 - s)^2, 3 + 6 s (1 - s) and 3 s^2 times the segments in a second. */
static inline void crane_rates(int32_t s, int32_t *r0, int32_t *r1, int32_t *r2)
{
    const int32_t s_fine = crane_shift_up(s, 12);
    const int32_t square = crane_high_product(s_fine, s);
    const int32_t difference = s_fine - square;
    const bool difference_over = 0 < difference;
    const int32_t difference_raised = difference_over ? difference : 0;
    const bool difference_under = difference_raised < 67108864;
    const int32_t difference_limited = difference_under ? difference_raised : 67108864;
    const int32_t complement = 268435456 - s_fine;
    const int32_t first = complement - difference_limited;
    const bool first_over = 0 < first;
    const int32_t first_raised = first_over ? first : 0;
    const int32_t two_differences = difference_limited * 2;
    const int32_t middle = 268435456 + two_differences;
    const int32_t first_tripled = first_raised * 3;
    const int32_t first_per_second = crane_high_product(first_tripled, 43690);
    const int32_t first_and_half = first_per_second + 16384;
    const int32_t first_weight = crane_shift_down(first_and_half, 15);
    const int32_t middle_tripled = middle * 3;
    const int32_t middle_per_second = crane_high_product(middle_tripled, 43690);
    const int32_t middle_and_half = middle_per_second + 16384;
    const int32_t middle_weight = crane_shift_down(middle_and_half, 15);
    const int32_t last_tripled = square * 3;
    const int32_t last_per_second = crane_high_product(last_tripled, 43690);
    const int32_t last_and_half = last_per_second + 16384;
    const int32_t last_weight = crane_shift_down(last_and_half, 15);
    *r0 = first_weight;
    *r1 = middle_weight;
    *r2 = last_weight;
}

/* An edge of the tube, and its rate in units a second, by the steps about it. */
static inline void crane_edge_at(int32_t at, int32_t w0, int32_t w1, int32_t w2, int32_t r0, int32_t r1,
                                 int32_t r2, int32_t *edge, int32_t *rate)
{
    const int32_t q0 = CRANE_READ_32(crane_coefficients[at]);
    const int32_t at_1 = at + 4;
    const int32_t q1 = CRANE_READ_32(crane_coefficients[at_1]);
    const int32_t at_2 = at + 8;
    const int32_t q2 = CRANE_READ_32(crane_coefficients[at_2]);
    const int32_t at_3 = at + 12;
    const int32_t q3 = CRANE_READ_32(crane_coefficients[at_3]);
    const int32_t difference_0 = q1 - q0;
    const int32_t difference_1 = q2 - q1;
    const int32_t difference_2 = q3 - q2;
    const int32_t d0 = (int32_t)(int16_t)difference_0;
    const int32_t d1 = (int32_t)(int16_t)difference_1;
    const int32_t d2 = (int32_t)(int16_t)difference_2;
    const int32_t six_q1 = q1 * 6;
    const int32_t base = six_q1 + d1;
    const int32_t d1_weighted = crane_product(d1, w1);
    const int32_t middle_part = crane_shift_down(d1_weighted, 14);
    const int32_t d2_weighted = crane_product(d2, w2);
    const int32_t d0_weighted = crane_product(d0, w0);
    const int32_t outer = d2_weighted - d0_weighted;
    const int32_t outer_part = crane_shift_down(outer, 15);
    const int32_t base_and_middle = base + middle_part;
    const int32_t value = base_and_middle + outer_part;
    const int32_t d1_per_second = crane_product(d1, r1);
    const int32_t middle_rate = crane_shift_down(d1_per_second, 11);
    const int32_t d0_per_second = crane_product(d0, r0);
    const int32_t d2_per_second = crane_product(d2, r2);
    const int32_t outer_sum = d0_per_second + d2_per_second;
    const int32_t outer_rate = crane_shift_down(outer_sum, 11);
    const int32_t value_rate = middle_rate + outer_rate;
    *edge = value;
    *rate = value_rate;
}

/* The quadratic of a row, level - (slope - bend t) t, at t in 2^-16. */
static inline int32_t crane_curve(int32_t row, int32_t t)
{
    const int32_t level = CRANE_READ_16(crane_levels[row]);
    const int32_t slope = CRANE_READ_16(crane_slopes[row]);
    const int32_t bend = CRANE_READ_16(crane_bends[row]);
    const int32_t bend_t = crane_product(bend, t);
    const int32_t bend_part = crane_shift_down(bend_t, 16);
    const int32_t mean_slope = slope - bend_part;
    const int32_t slope_t = crane_product(mean_slope, t);
    const int32_t fall = crane_shift_down(slope_t, 17);
    const int32_t difference = level - fall;
    const int32_t value = crane_low_bits(difference, 65535);
    return value;
}

/* |u|: gain e H/d, at most `limit`. */
static inline int32_t crane_input_size(int32_t e, int32_t h, int32_t reciprocal, int32_t gain, int32_t shift,
                                       int32_t limit)
{
    const int32_t e_times_h = crane_high_product(e, h);
    const int32_t over_width = crane_high_product(e_times_h, reciprocal);
    const int32_t unshifted = crane_high_product(over_width, gain);
    const int32_t unlimited = crane_shift_down(unshifted, shift);
    const bool limit_under = unlimited < limit;
    const int32_t size = limit_under ? unlimited : limit;
    return size;
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
        crane_edge_at(lower_at, w0, w1, w2, r0, r1, r2, &lower_edge, &lower_rate);
        int32_t upper_edge;
        int32_t upper_rate;
        crane_edge_at(upper_at, w0, w1, w2, r0, r1, r2, &upper_edge, &upper_rate);
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
        crane_edge_at(lower_at, w0, w1, w2, r0, r1, r2, &lower_edge, &lower_rate);
        int32_t upper_edge;
        int32_t upper_rate;
        crane_edge_at(upper_at, w0, w1, w2, r0, r1, r2, &upper_edge, &upper_rate);
        const int32_t lower_part = crane_high_product(lower_edge, filter_i);
        const int32_t z_lower = lower_rate + lower_part;
        lower[i] = z_lower;
        const int32_t upper_part = crane_high_product(upper_edge, filter_i);
        const int32_t z_upper = upper_rate + upper_part;
        upper[i] = z_upper;
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
        crane_edge_at(lower_at, w0, w1, w2, r0, r1, r2, &lower_edge, &lower_rate);
        int32_t upper_edge;
        int32_t upper_rate;
        crane_edge_at(upper_at, w0, w1, w2, r0, r1, r2, &upper_edge, &upper_rate);
        const int32_t x_any = x[i];
        const bool x_over = (-67108864) < x_any;
        const int32_t x_raised = x_over ? x_any : (-67108864);
        const bool x_under = x_raised < 67108864;
        const int32_t x_i = x_under ? x_raised : 67108864;
        const int32_t to_lower = x_i - lower_edge;
        const int32_t to_upper = upper_edge - x_i;
        const int32_t v_any = v[i];
        const bool v_over = (-268435456) < v_any;
        const int32_t v_raised = v_over ? v_any : (-268435456);
        const bool v_under = v_raised < 268435456;
        const int32_t v_i = v_under ? v_raised : 268435456;
        const int32_t v_to_lower = v_i - lower_rate;
        const int32_t v_to_upper = upper_rate - v_i;
        const int32_t filter_i = CRANE_READ_16(crane_filters[i]);
        const int32_t lower_part = crane_high_product(to_lower, filter_i);
        const int32_t z_to_lower = v_to_lower + lower_part;
        const int32_t upper_part = crane_high_product(to_upper, filter_i);
        const int32_t z_to_upper = v_to_upper + upper_part;
        const int32_t width = z_to_lower + z_to_upper;
        const int32_t difference = z_to_lower - z_to_upper;
        const bool wide = 65536 < width;
        const int32_t safe_width = wide ? width : 65536;
        const int32_t width_shift = crane_leading(safe_width);
        const int32_t width_shifted = crane_shift_up(safe_width, width_shift);
        const int32_t width_bits = crane_shift_down(width_shifted, 26);
        const int32_t width_row = crane_low_bits(width_bits, 15);
        const int32_t width_tail = crane_shift_down(width_shifted, 10);
        const int32_t width_t = crane_low_bits(width_tail, 65535);
        const int32_t reciprocal = crane_curve(width_row, width_t);
        const bool upper_nearer = 0 < difference;
        const int32_t difference_minus = -difference;
        const int32_t offset = upper_nearer ? difference : difference_minus;
        const bool offset_under = offset < safe_width;
        const int32_t offset_limited = offset_under ? offset : safe_width;
        const int32_t offset_shifted = crane_shift_up(offset_limited, width_shift);
        const int32_t e_any = crane_high_product(offset_shifted, reciprocal);
        const bool e_under = e_any < 1063134168;
        const int32_t e_limited = e_under ? e_any : 1063134168;
        const int32_t remainder = width_shifted - offset_shifted;
        const int32_t y_any = crane_high_product(remainder, reciprocal);
        const bool y_over = 10736107 < y_any;
        const int32_t y_raised = y_over ? y_any : 10736107;
        const bool y_under = y_raised < 1073741823;
        const int32_t y_limited = y_under ? y_raised : 1073741823;
        const int32_t y_shift = crane_leading(y_limited);
        const int32_t octave_rows = y_shift * 8;
        const int32_t first_row = octave_rows + 8;
        const int32_t y_shifted = crane_shift_up(y_limited, y_shift);
        const int32_t y_bits = crane_shift_down(y_shifted, 27);
        const int32_t y_piece = crane_low_bits(y_bits, 7);
        const int32_t y_row = y_piece + first_row;
        const int32_t y_tail = crane_shift_down(y_shifted, 11);
        const int32_t y_t = crane_low_bits(y_tail, 65535);
        const int32_t h = crane_curve(y_row, y_t);
        const int32_t h_shift = CRANE_READ_8(crane_h_shifts[y_row]);
        const int32_t gain = CRANE_READ_16(crane_gains[i]);
        const int32_t shift_offset = CRANE_READ_8(crane_shift_offsets[i]);
        const int32_t limit = CRANE_READ_32(crane_limits[i]);
        const int32_t less_width_shift = shift_offset - width_shift;
        const int32_t shift_any = less_width_shift - h_shift;
        const bool shift_over = 0 < shift_any;
        const int32_t shift = shift_over ? shift_any : 0;
        const int32_t size = crane_input_size(e_limited, h, reciprocal, gain, shift, limit);
        const int32_t size_minus = -size;
        const int32_t u_i = upper_nearer ? size_minus : size;
        u[i] = u_i;
        const bool z_inside = offset < width;
        const bool x_above = 0 < to_lower;
        const bool x_below = 0 < to_upper;
        const bool x_inside = x_above && x_below;
        const bool inside = z_inside && x_inside;
        const bool outside_next = inside ? outside : true;
        outside = outside_next;
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
        crane_edge_at(lower_at, w0, w1, w2, r0, r1, r2, &lower_edge, &lower_rate);
        int32_t upper_edge;
        int32_t upper_rate;
        crane_edge_at(upper_at, w0, w1, w2, r0, r1, r2, &upper_edge, &upper_rate);
        const int32_t x_any = x[i];
        const bool x_over = (-67108864) < x_any;
        const int32_t x_raised = x_over ? x_any : (-67108864);
        const bool x_under = x_raised < 67108864;
        const int32_t x_i = x_under ? x_raised : 67108864;
        const int32_t to_lower = x_i - lower_edge;
        const int32_t to_upper = upper_edge - x_i;
        const int32_t v_any = v[i];
        const bool v_over = (-268435456) < v_any;
        const int32_t v_raised = v_over ? v_any : (-268435456);
        const bool v_under = v_raised < 268435456;
        const int32_t v_i = v_under ? v_raised : 268435456;
        const int32_t v_to_lower = v_i - lower_rate;
        const int32_t v_to_upper = upper_rate - v_i;
        const int32_t filter_i = CRANE_READ_16(crane_filters[i]);
        const int32_t lower_part = crane_high_product(to_lower, filter_i);
        const int32_t z_to_lower = v_to_lower + lower_part;
        const int32_t upper_part = crane_high_product(to_upper, filter_i);
        const int32_t z_to_upper = v_to_upper + upper_part;
        const int32_t z_width = z_to_lower + z_to_upper;
        const bool z_wide = 65536 < z_width;
        const int32_t z_safe_width = z_wide ? z_width : 65536;
        const int32_t z_width_shift = crane_leading(z_safe_width);
        const int32_t z_width_shifted = crane_shift_up(z_safe_width, z_width_shift);
        const int32_t z_width_bits = crane_shift_down(z_width_shifted, 26);
        const int32_t z_width_row = crane_low_bits(z_width_bits, 15);
        const int32_t z_width_tail = crane_shift_down(z_width_shifted, 10);
        const int32_t z_width_t = crane_low_bits(z_width_tail, 65535);
        const int32_t z_reciprocal = crane_curve(z_width_row, z_width_t);
        const bool z_nearer = z_to_upper < z_to_lower;
        const int32_t z_distance = z_nearer ? z_to_upper : z_to_lower;
        const bool z_inside = 0 < z_distance;
        const int32_t z_distance_minus = -z_distance;
        const int32_t z_size = z_inside ? z_distance : z_distance_minus;
        const bool z_size_under = z_size < z_safe_width;
        const int32_t z_size_limited = z_size_under ? z_size : z_safe_width;
        const int32_t z_size_shifted = crane_shift_up(z_size_limited, z_width_shift);
        const int32_t z_quotient = crane_high_product(z_size_shifted, z_reciprocal);
        const int32_t z_share_any = crane_shift_down(z_quotient, 14);
        const bool z_share_under = z_share_any < 65535;
        const int32_t z_share = z_share_under ? z_share_any : 65535;
        const int32_t z_share_minus = (-1) - z_share;
        const int32_t margin_z = z_inside ? z_share : z_share_minus;
        const int32_t x_width = to_lower + to_upper;
        const bool x_wide = 131072 < x_width;
        const int32_t x_safe_width = x_wide ? x_width : 131072;
        const int32_t x_width_shift = crane_leading(x_safe_width);
        const int32_t x_width_shifted = crane_shift_up(x_safe_width, x_width_shift);
        const int32_t x_width_bits = crane_shift_down(x_width_shifted, 26);
        const int32_t x_width_row = crane_low_bits(x_width_bits, 15);
        const int32_t x_width_tail = crane_shift_down(x_width_shifted, 10);
        const int32_t x_width_t = crane_low_bits(x_width_tail, 65535);
        const int32_t x_reciprocal = crane_curve(x_width_row, x_width_t);
        const bool x_nearer = to_upper < to_lower;
        const int32_t x_distance = x_nearer ? to_upper : to_lower;
        const bool x_inside = 0 < x_distance;
        const int32_t x_distance_minus = -x_distance;
        const int32_t x_size = x_inside ? x_distance : x_distance_minus;
        const bool x_size_under = x_size < x_safe_width;
        const int32_t x_size_limited = x_size_under ? x_size : x_safe_width;
        const int32_t x_size_shifted = crane_shift_up(x_size_limited, x_width_shift);
        const int32_t x_quotient = crane_high_product(x_size_shifted, x_reciprocal);
        const int32_t x_share_any = crane_shift_down(x_quotient, 14);
        const bool x_share_under = x_share_any < 65535;
        const int32_t x_share = x_share_under ? x_share_any : 65535;
        const int32_t x_share_minus = (-1) - x_share;
        const int32_t margin_x = x_inside ? x_share : x_share_minus;
        const bool z_smaller = margin_z < margin_x;
        const int32_t smaller = z_smaller ? margin_z : margin_x;
        const bool less = smaller < margin;
        const int32_t margin_next = less ? smaller : margin;
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
        crane_edge_at(lower_at, w0, w1, w2, r0, r1, r2, &lower_edge, &lower_rate);
        int32_t upper_edge;
        int32_t upper_rate;
        crane_edge_at(upper_at, w0, w1, w2, r0, r1, r2, &upper_edge, &upper_rate);
        const int32_t x_any = x[i];
        const bool x_over = (-67108864) < x_any;
        const int32_t x_raised = x_over ? x_any : (-67108864);
        const bool x_under = x_raised < 67108864;
        const int32_t x_i = x_under ? x_raised : 67108864;
        const int32_t to_lower = x_i - lower_edge;
        const int32_t to_upper = upper_edge - x_i;
        const int32_t v_any = v[i];
        const bool v_over = (-268435456) < v_any;
        const int32_t v_raised = v_over ? v_any : (-268435456);
        const bool v_under = v_raised < 268435456;
        const int32_t v_i = v_under ? v_raised : 268435456;
        const int32_t v_to_lower = v_i - lower_rate;
        const int32_t v_to_upper = upper_rate - v_i;
        const int32_t filter_i = CRANE_READ_16(crane_filters[i]);
        const int32_t lower_part = crane_high_product(to_lower, filter_i);
        const int32_t z_to_lower = v_to_lower + lower_part;
        const int32_t upper_part = crane_high_product(to_upper, filter_i);
        const int32_t z_to_upper = v_to_upper + upper_part;
        const int32_t z_width = z_to_lower + z_to_upper;
        const bool z_wide = 65536 < z_width;
        const int32_t z_safe_width = z_wide ? z_width : 65536;
        const int32_t z_width_shift = crane_leading(z_safe_width);
        const int32_t z_width_shifted = crane_shift_up(z_safe_width, z_width_shift);
        const int32_t z_width_bits = crane_shift_down(z_width_shifted, 26);
        const int32_t z_width_row = crane_low_bits(z_width_bits, 15);
        const int32_t z_width_tail = crane_shift_down(z_width_shifted, 10);
        const int32_t z_width_t = crane_low_bits(z_width_tail, 65535);
        const int32_t z_reciprocal = crane_curve(z_width_row, z_width_t);
        const bool z_nearer = z_to_upper < z_to_lower;
        const int32_t z_distance = z_nearer ? z_to_upper : z_to_lower;
        const bool z_inside = 0 < z_distance;
        const int32_t z_distance_minus = -z_distance;
        const int32_t z_size = z_inside ? z_distance : z_distance_minus;
        const bool z_size_under = z_size < z_safe_width;
        const int32_t z_size_limited = z_size_under ? z_size : z_safe_width;
        const int32_t z_size_shifted = crane_shift_up(z_size_limited, z_width_shift);
        const int32_t z_quotient = crane_high_product(z_size_shifted, z_reciprocal);
        const int32_t z_share_any = crane_shift_down(z_quotient, 14);
        const bool z_share_under = z_share_any < 65535;
        const int32_t z_share = z_share_under ? z_share_any : 65535;
        const int32_t z_share_minus = (-1) - z_share;
        const int32_t margin_z = z_inside ? z_share : z_share_minus;
        const int32_t x_width = to_lower + to_upper;
        const bool x_wide = 131072 < x_width;
        const int32_t x_safe_width = x_wide ? x_width : 131072;
        const int32_t x_width_shift = crane_leading(x_safe_width);
        const int32_t x_width_shifted = crane_shift_up(x_safe_width, x_width_shift);
        const int32_t x_width_bits = crane_shift_down(x_width_shifted, 26);
        const int32_t x_width_row = crane_low_bits(x_width_bits, 15);
        const int32_t x_width_tail = crane_shift_down(x_width_shifted, 10);
        const int32_t x_width_t = crane_low_bits(x_width_tail, 65535);
        const int32_t x_reciprocal = crane_curve(x_width_row, x_width_t);
        const bool x_nearer = to_upper < to_lower;
        const int32_t x_distance = x_nearer ? to_upper : to_lower;
        const bool x_inside = 0 < x_distance;
        const int32_t x_distance_minus = -x_distance;
        const int32_t x_size = x_inside ? x_distance : x_distance_minus;
        const bool x_size_under = x_size < x_safe_width;
        const int32_t x_size_limited = x_size_under ? x_size : x_safe_width;
        const int32_t x_size_shifted = crane_shift_up(x_size_limited, x_width_shift);
        const int32_t x_quotient = crane_high_product(x_size_shifted, x_reciprocal);
        const int32_t x_share_any = crane_shift_down(x_quotient, 14);
        const bool x_share_under = x_share_any < 65535;
        const int32_t x_share = x_share_under ? x_share_any : 65535;
        const int32_t x_share_minus = (-1) - x_share;
        const int32_t margin_x = x_inside ? x_share : x_share_minus;
        const bool z_smaller = margin_z < margin_x;
        const int32_t smaller = z_smaller ? margin_z : margin_x;
        margin[i] = smaller;
    }
}

bool crane_covered(const int32_t x[CRANE_N], const int32_t v[CRANE_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t x_any = x[i];
        const bool x_over = (-67108864) < x_any;
        const int32_t x_raised = x_over ? x_any : (-67108864);
        const bool x_under = x_raised < 67108864;
        const int32_t x_i = x_under ? x_raised : 67108864;
        const int32_t v_any = v[i];
        const bool v_over = (-268435456) < v_any;
        const int32_t v_raised = v_over ? v_any : (-268435456);
        const bool v_under = v_raised < 268435456;
        const int32_t v_i = v_under ? v_raised : 268435456;
        const int32_t filter_i = CRANE_READ_16(crane_filters[i]);
        const int32_t x_part = crane_high_product(x_i, filter_i);
        const int32_t z_i = v_i + x_part;
        const int32_t x_lower = CRANE_READ_16(crane_start_lower[i]);
        const int32_t x_upper = CRANE_READ_32(crane_start_upper[i]);
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const int32_t z_lower = CRANE_READ_16(crane_filtered_start_lower[i]);
        const int32_t z_upper = CRANE_READ_32(crane_filtered_start_upper[i]);
        const bool z_above = z_lower < z_i;
        const bool z_below = z_i < z_upper;
        const bool z_inside = z_above && z_below;
        const bool inside = x_inside && z_inside;
        const bool covered_next = inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}
