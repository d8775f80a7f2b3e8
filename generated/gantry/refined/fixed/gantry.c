/* gantry.c: prescribed-time reach-avoid-stay controller, refined tube, in integers of 32 bits.
 *
 * Certified (gantry.certificate.json): for every t the tube keeps 0.01 from every
 * unsafe set, stays in the state space, is at least 0.05 wide, and ends in the target set.
 * The state stays in it (P9) sampled at ticks, every 0.01 s or faster, from every start with |e(0)| <= 0.9, for |f +
 * w| <= 0.02, 0.95 <= g_ii <= 1.05, |g_ij| <= 0, x measured to 3e-05: |e| < 0.9001, |u| <= 0.6.
 *
 * One statement a line, every value assigned once. Numbers in brackets are equations of Das and Jagtap, IEEE L-CSS 8, 2024.
 * No value leaves 32 bits, whatever the arguments.
 */
#include "gantry.h"

#include <stdbool.h>

/* Tables stay in flash: an AVR reads it by instructions of its own. */
#if defined(__AVR__)
#include <avr/pgmspace.h>
#define GANTRY_FLASH PROGMEM
#define GANTRY_READ_8(entry) ((int32_t)pgm_read_byte(&(entry)))
#define GANTRY_READ_16(entry) ((int32_t)pgm_read_word(&(entry)))
#define GANTRY_READ_32(entry) ((int32_t)pgm_read_dword(&(entry)))
#else
#define GANTRY_FLASH
#define GANTRY_READ_8(entry) ((int32_t)(entry))
#define GANTRY_READ_16(entry) ((int32_t)(entry))
#define GANTRY_READ_32(entry) ((int32_t)(entry))
#endif

/* A negative number moves right as if by a division that rounds down: C leaves that to the compiler. */
typedef char gantry_shifts_down[((-3) >> 1 == -2) ? 1 : -1];

#if defined(__AVR__)
/* a / 2^n rounded down, and a 2^n of a >= 0, by bytes first. */
static inline int32_t gantry_down(int32_t a, int32_t n)
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

static inline int32_t gantry_up(int32_t a, int32_t n)
{
    uint32_t rest = (uint32_t)a;
    if (((uint8_t)n & 16U) != 0U) { rest <<= 16; }
    if (((uint8_t)n & 8U) != 0U) { rest <<= 8; }
    for (uint8_t k = (uint8_t)n & 7U; k != 0U; --k) { rest <<= 1; }
    rest &= 0x7fffffffU;
    return (int32_t)rest;
}

/* a b, a of 16 bits with a sign, b of 16 without one. */
static inline int32_t gantry_product(int32_t a, int32_t b)
{
    int16_t own = (int16_t)a;
    uint16_t other = (uint16_t)b;
    __asm__("" : "+r"(own), "+r"(other));
    return (int32_t)own * (int32_t)other;
}

/* a b / 2^16 rounded down, for 0 <= b < 2^16. */
static inline int32_t gantry_upper(int32_t a, int32_t b)
{
    uint16_t own = (uint16_t)a;
    uint16_t other = (uint16_t)b;
    __asm__("" : "+r"(own), "+r"(other));
    const uint32_t low = (uint32_t)own * other;
    return gantry_product(a >> 16, b) + (int32_t)(low >> 16);
}
#else
/* a / 2^n rounded down, and a 2^n of a >= 0. */
static inline int32_t gantry_down(int32_t a, int32_t n)
{
    return a >> n;
}

static inline int32_t gantry_up(int32_t a, int32_t n)
{
    const uint32_t moved = ((uint32_t)a << (uint32_t)n) & 0x7fffffffU;
    return (int32_t)moved;
}

/* a b, a of 16 bits with a sign, b of 16 without one. */
static inline int32_t gantry_product(int32_t a, int32_t b)
{
    return a * b;
}

/* a b / 2^16 rounded down, for 0 <= b < 2^16. */
static inline int32_t gantry_upper(int32_t a, int32_t b)
{
    const uint32_t low = ((uint32_t)a & 0xffffU) * (uint32_t)b;
    return (gantry_down(a, 16) * b) + (int32_t)(low >> 16);
}
#endif

/* By how many places the bits of a > 0 can move up. */
static inline int32_t gantry_leading(int32_t a)
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
static inline int32_t gantry_low(int32_t a, int32_t mask)
{
    const uint32_t bits = (uint32_t)a & (uint32_t)mask;
    return (int32_t)bits;
}

/* B-spline control points divided by 6, in 2^-20, a row for each of 32 + 3 points. */
static const int32_t gantry_coefficients[140] GANTRY_FLASH = {
    51, 31487, -2902, 28534,
    3506, 34942, 3506, 34942,
    6961, 38397, 9913, 41349,
    10415, 41851, 16321, 47757,
    13870, 45306, 22728, 54164,
    17325, 48761, 29136, 60572,
    20779, 52215, 35544, 66979,
    24234, 55670, 41951, 73387,
    27689, 59125, 48359, 79795,
    31143, 62579, 54766, 86202,
    34598, 66034, 61174, 92610,
    38053, 69489, 67581, 99017,
    41507, 72943, 73989, 105425,
    44962, 76398, 80396, 111832,
    51370, 82806, 86803, 118239,
    57777, 89213, 86092, 117527,
    64185, 95621, 85380, 116816,
    70592, 102028, 84668, 116104,
    77000, 108436, 83956, 115392,
    83407, 114843, 83244, 114680,
    89815, 121251, 82532, 113968,
    96222, 127658, 81820, 113256,
    102630, 134066, 81108, 112544,
    109037, 140473, 80396, 111832,
    115445, 146881, 79684, 111120,
    121852, 153288, 78972, 110408,
    128260, 159696, 78260, 109696,
    134667, 166103, 77548, 108984,
    141075, 172511, 76837, 108272,
    147483, 178918, 76125, 107561,
    153890, 185326, 81173, 112609,
    160298, 191734, 87581, 119017,
    166705, 198141, 93989, 125424,
    166705, 198141, 97193, 128629,
    166705, 198141, 93989, 125424
};

/* Quadratics level - (slope - bend t) t, by row: 16 for 1/d, d in [2^30, 2^31), then
 * 8 for each octave of y, for H = 4 ln((2 - y)/y)/((1 - y) y (2 - y)), which also moves up, by:
 */
static const uint16_t gantry_levels[72] GANTRY_FLASH = {
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

static const uint16_t gantry_slopes[72] GANTRY_FLASH = {
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

static const uint16_t gantry_bends[72] GANTRY_FLASH = {
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

static const uint8_t gantry_places[72] GANTRY_FLASH = {
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
static const uint16_t gantry_gains[2] GANTRY_FLASH = {
    58196, 58196
};

/* By how many places less u moves up. */
static const uint8_t gantry_offsets[2] GANTRY_FLASH = {
    14, 14
};

/* The largest |u|. */
static const int32_t gantry_limits[2] GANTRY_FLASH = {
    40265280, 40265280
};

/* Covered starts have x strictly above these bounds, by component. */
static const uint16_t gantry_start_lower[2] GANTRY_FLASH = {
    30498, 30497
};

/* Covered starts have x strictly below these bounds, by component. */
static const int32_t gantry_start_upper[2] GANTRY_FLASH = {
    200190, 200189
};

/* Table index of the segment at a tick, and s in 2^-16 of it. */
static inline void gantry_segment(uint32_t tick, int32_t *row, int32_t *s)
{
    const bool running = tick < 4000U;
    const uint32_t held = running ? tick : 4000U;
    const int32_t count = (int32_t)held;
    const int32_t count_low = gantry_low(count, 65535);
    const int32_t passed = gantry_upper(34359738, count_low);
    const bool place_under = passed < 2097151;
    const int32_t place = place_under ? passed : 2097151;
    const int32_t segment = gantry_down(place, 16);
    const int32_t share = gantry_low(place, 65535);
    const int32_t first = segment * 4;
    *row = first;
    *s = share;
}

/* At s: (1 - s)^3 and s^3 in 2^-15, 3 s + 3 s^2 - 2 s^3 in 2^-14. */
static inline void gantry_weights(int32_t s, int32_t *w0, int32_t *w1, int32_t *w2)
{
    const int32_t s_up = gantry_up(s, 12);
    const int32_t square = gantry_upper(s_up, s);
    const int32_t cube = gantry_upper(square, s);
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
    const int32_t bend_near = gantry_down(bend_near_half, 14);
    const bool left_held_over = 0 < left;
    const int32_t left_held = left_held_over ? left : 0;
    const int32_t before_half = left_held + 4096;
    const int32_t before = gantry_down(before_half, 13);
    const bool middle_under = bend_near < 65535;
    const int32_t middle = middle_under ? bend_near : 65535;
    const int32_t after_half = cube + 4096;
    const int32_t after = gantry_down(after_half, 13);
    *w0 = before;
    *w1 = middle;
    *w2 = after;
}

/* An edge of the tube: a control point, and the steps about it by their weights. */
static inline int32_t gantry_edge(int32_t at, int32_t w0, int32_t w1, int32_t w2)
{
    const int32_t at_q0 = GANTRY_READ_32(gantry_coefficients[at]);
    const int32_t at_1 = at + 4;
    const int32_t at_q1 = GANTRY_READ_32(gantry_coefficients[at_1]);
    const int32_t at_2 = at + 8;
    const int32_t at_q2 = GANTRY_READ_32(gantry_coefficients[at_2]);
    const int32_t at_3 = at + 12;
    const int32_t at_q3 = GANTRY_READ_32(gantry_coefficients[at_3]);
    const int32_t apart_0 = at_q1 - at_q0;
    const int32_t apart_1 = at_q2 - at_q1;
    const int32_t apart_2 = at_q3 - at_q2;
    const int32_t d0 = (int32_t)(int16_t)apart_0;
    const int32_t d1 = (int32_t)(int16_t)apart_1;
    const int32_t d2 = (int32_t)(int16_t)apart_2;
    const int32_t q1_6 = at_q1 * 6;
    const int32_t base = q1_6 + d1;
    const int32_t d1_w1 = gantry_product(d1, w1);
    const int32_t middle = gantry_down(d1_w1, 14);
    const int32_t d2_w2 = gantry_product(d2, w2);
    const int32_t d0_w0 = gantry_product(d0, w0);
    const int32_t outer = d2_w2 - d0_w0;
    const int32_t ends = gantry_down(outer, 15);
    const int32_t bent = base + middle;
    const int32_t value = bent + ends;
    return value;
}

/* The quadratic of a row, level - (slope - bend t) t, at t in 2^-16. */
static inline int32_t gantry_curve(int32_t row, int32_t t)
{
    const int32_t level = GANTRY_READ_16(gantry_levels[row]);
    const int32_t slope = GANTRY_READ_16(gantry_slopes[row]);
    const int32_t bend = GANTRY_READ_16(gantry_bends[row]);
    const int32_t bend_t = gantry_product(bend, t);
    const int32_t bent = gantry_down(bend_t, 16);
    const int32_t down = slope - bent;
    const int32_t down_t = gantry_product(down, t);
    const int32_t fall = gantry_down(down_t, 17);
    const int32_t left = level - fall;
    const int32_t found = gantry_low(left, 65535);
    return found;
}

/* |u|: gain e H/d, at most `limit`. */
static inline int32_t gantry_push(int32_t e, int32_t rise, int32_t over, int32_t gain, int32_t places,
                                  int32_t limit)
{
    const int32_t steep = gantry_upper(e, rise);
    const int32_t over_width = gantry_upper(steep, over);
    const int32_t size = gantry_upper(over_width, gain);
    const int32_t moved = gantry_down(size, places);
    const bool push_held_under = moved < limit;
    const int32_t push_held = push_held_under ? moved : limit;
    return push_held;
}

void gantry_tube(uint32_t tick, int32_t lower[GANTRY_N], int32_t upper[GANTRY_N])
{
    int32_t row;
    int32_t s;
    gantry_segment(tick, &row, &s);
    int32_t w0;
    int32_t w1;
    int32_t w2;
    gantry_weights(s, &w0, &w1, &w2);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const int32_t lower_edge = gantry_edge(lower_at, w0, w1, w2);
        const int32_t upper_edge = gantry_edge(upper_at, w0, w1, w2);
        lower[i] = lower_edge;
        upper[i] = upper_edge;
    }
}

gantry_status gantry_control(uint32_t tick, const int32_t x[GANTRY_N], int32_t u[GANTRY_N])
{
    int32_t row;
    int32_t s;
    gantry_segment(tick, &row, &s);
    int32_t w0;
    int32_t w1;
    int32_t w2;
    gantry_weights(s, &w0, &w1, &w2);
    bool outside = false;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const int32_t lower_edge = gantry_edge(lower_at, w0, w1, w2);
        const int32_t upper_edge = gantry_edge(upper_at, w0, w1, w2);
        const int32_t x_all = x[i];
        const bool x_near_over = (-268435456) < x_all;
        const int32_t x_near = x_near_over ? x_all : (-268435456);
        const bool x_i_under = x_near < 268435456;
        const int32_t x_i = x_i_under ? x_near : 268435456;
        const int32_t x_lower = x_i - lower_edge;
        const int32_t x_upper = upper_edge - x_i;
        const int32_t room = x_lower + x_upper;
        const int32_t apart = x_lower - x_upper;
        const bool e_width_over = 131072 < room;
        const int32_t e_width = e_width_over ? room : 131072;
        const int32_t e_n = gantry_leading(e_width);
        const int32_t e_width_up = gantry_up(e_width, e_n);
        const int32_t e_over_bits = gantry_down(e_width_up, 26);
        const int32_t e_over_head = gantry_low(e_over_bits, 15);
        const int32_t e_over_tail = gantry_down(e_width_up, 10);
        const int32_t e_over_t = gantry_low(e_over_tail, 65535);
        const int32_t e_over = gantry_curve(e_over_head, e_over_t);
        const bool upper_nearer = 0 < apart;
        const int32_t minus = -apart;
        const int32_t off = upper_nearer ? apart : minus;
        const bool off_held_under = off < e_width;
        const int32_t off_held = off_held_under ? off : e_width;
        const int32_t off_up = gantry_up(off_held, e_n);
        const int32_t e_all = gantry_upper(off_up, e_over);
        const bool e_under = e_all < 1063134168;
        const int32_t e = e_under ? e_all : 1063134168;
        const int32_t rest = e_width_up - off_up;
        const int32_t y_all = gantry_upper(rest, e_over);
        const bool y_near_over = 10736107 < y_all;
        const int32_t y_near = y_near_over ? y_all : 10736107;
        const bool y_under = y_near < 1073741823;
        const int32_t y = y_under ? y_near : 1073741823;
        const int32_t m = gantry_leading(y);
        const int32_t octaves = m * 8;
        const int32_t octave = octaves + 8;
        const int32_t y_up = gantry_up(y, m);
        const int32_t rise_bits = gantry_down(y_up, 27);
        const int32_t rise_head = gantry_low(rise_bits, 7);
        const int32_t rise_row = rise_head + octave;
        const int32_t rise_tail = gantry_down(y_up, 11);
        const int32_t rise_t = gantry_low(rise_tail, 65535);
        const int32_t rise = gantry_curve(rise_row, rise_t);
        const int32_t rise_places = GANTRY_READ_8(gantry_places[rise_row]);
        const int32_t gain = GANTRY_READ_16(gantry_gains[i]);
        const int32_t offset = GANTRY_READ_8(gantry_offsets[i]);
        const int32_t limit = GANTRY_READ_32(gantry_limits[i]);
        const int32_t down_n = offset - e_n;
        const int32_t down_all = down_n - rise_places;
        const bool down_over = 0 < down_all;
        const int32_t down = down_over ? down_all : 0;
        const int32_t push = gantry_push(e, rise, e_over, gain, down, limit);
        const int32_t back = -push;
        const int32_t u_i = upper_nearer ? back : push;
        u[i] = u_i;
        const bool within = off < room;
        const bool outside_any = within ? outside : true;
        outside = outside_any;
    }
    return outside ? GANTRY_OUTSIDE_TUBE : GANTRY_OK;
}

int32_t gantry_margin(uint32_t tick, const int32_t x[GANTRY_N])
{
    int32_t row;
    int32_t s;
    gantry_segment(tick, &row, &s);
    int32_t w0;
    int32_t w1;
    int32_t w2;
    gantry_weights(s, &w0, &w1, &w2);
    int32_t margin = 32768;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const int32_t lower_edge = gantry_edge(lower_at, w0, w1, w2);
        const int32_t upper_edge = gantry_edge(upper_at, w0, w1, w2);
        const int32_t x_all = x[i];
        const bool x_near_over = (-268435456) < x_all;
        const int32_t x_near = x_near_over ? x_all : (-268435456);
        const bool x_i_under = x_near < 268435456;
        const int32_t x_i = x_i_under ? x_near : 268435456;
        const int32_t x_lower = x_i - lower_edge;
        const int32_t x_upper = upper_edge - x_i;
        const int32_t share_room = x_lower + x_upper;
        const bool share_width_over = 131072 < share_room;
        const int32_t share_width = share_width_over ? share_room : 131072;
        const int32_t share_n = gantry_leading(share_width);
        const int32_t share_width_up = gantry_up(share_width, share_n);
        const int32_t share_over_bits = gantry_down(share_width_up, 26);
        const int32_t share_over_head = gantry_low(share_over_bits, 15);
        const int32_t share_over_tail = gantry_down(share_width_up, 10);
        const int32_t share_over_t = gantry_low(share_over_tail, 65535);
        const int32_t share_over = gantry_curve(share_over_head, share_over_t);
        const bool share_high = x_upper < x_lower;
        const int32_t share_nearest = share_high ? x_upper : x_lower;
        const bool share_inside = 0 < share_nearest;
        const int32_t share_beyond = -share_nearest;
        const int32_t share_size = share_inside ? share_nearest : share_beyond;
        const bool share_held_under = share_size < share_width;
        const int32_t share_held = share_held_under ? share_size : share_width;
        const int32_t share_up = gantry_up(share_held, share_n);
        const int32_t share_quotient = gantry_upper(share_up, share_over);
        const int32_t share_part = gantry_down(share_quotient, 14);
        const bool share_most_under = share_part < 65535;
        const int32_t share_most = share_most_under ? share_part : 65535;
        const int32_t share_minus = (-1) - share_most;
        const int32_t share = share_inside ? share_most : share_minus;
        const bool less = share < margin;
        const int32_t margin_next = less ? share : margin;
        margin = margin_next;
    }
    return margin;
}

void gantry_margins(uint32_t tick, const int32_t x[GANTRY_N], int32_t margin[GANTRY_N])
{
    int32_t row;
    int32_t s;
    gantry_segment(tick, &row, &s);
    int32_t w0;
    int32_t w1;
    int32_t w2;
    gantry_weights(s, &w0, &w1, &w2);
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t pair = i * 2;
        const int32_t lower_at = row + pair;
        const int32_t upper_at = lower_at + 1;
        const int32_t lower_edge = gantry_edge(lower_at, w0, w1, w2);
        const int32_t upper_edge = gantry_edge(upper_at, w0, w1, w2);
        const int32_t x_all = x[i];
        const bool x_near_over = (-268435456) < x_all;
        const int32_t x_near = x_near_over ? x_all : (-268435456);
        const bool x_i_under = x_near < 268435456;
        const int32_t x_i = x_i_under ? x_near : 268435456;
        const int32_t x_lower = x_i - lower_edge;
        const int32_t x_upper = upper_edge - x_i;
        const int32_t share_room = x_lower + x_upper;
        const bool share_width_over = 131072 < share_room;
        const int32_t share_width = share_width_over ? share_room : 131072;
        const int32_t share_n = gantry_leading(share_width);
        const int32_t share_width_up = gantry_up(share_width, share_n);
        const int32_t share_over_bits = gantry_down(share_width_up, 26);
        const int32_t share_over_head = gantry_low(share_over_bits, 15);
        const int32_t share_over_tail = gantry_down(share_width_up, 10);
        const int32_t share_over_t = gantry_low(share_over_tail, 65535);
        const int32_t share_over = gantry_curve(share_over_head, share_over_t);
        const bool share_high = x_upper < x_lower;
        const int32_t share_nearest = share_high ? x_upper : x_lower;
        const bool share_inside = 0 < share_nearest;
        const int32_t share_beyond = -share_nearest;
        const int32_t share_size = share_inside ? share_nearest : share_beyond;
        const bool share_held_under = share_size < share_width;
        const int32_t share_held = share_held_under ? share_size : share_width;
        const int32_t share_up = gantry_up(share_held, share_n);
        const int32_t share_quotient = gantry_upper(share_up, share_over);
        const int32_t share_part = gantry_down(share_quotient, 14);
        const bool share_most_under = share_part < 65535;
        const int32_t share_most = share_most_under ? share_part : 65535;
        const int32_t share_minus = (-1) - share_most;
        const int32_t share = share_inside ? share_most : share_minus;
        margin[i] = share;
    }
}

bool gantry_covered(const int32_t x[GANTRY_N])
{
    bool covered = true;
    for (int32_t i = 0; i < 2; ++i) {
        const int32_t x_i = x[i];
        const int32_t x_lower = GANTRY_READ_16(gantry_start_lower[i]);
        const int32_t x_upper = GANTRY_READ_32(gantry_start_upper[i]);
        const bool x_above = x_lower < x_i;
        const bool x_below = x_i < x_upper;
        const bool x_inside = x_above && x_below;
        const bool covered_next = x_inside ? covered : false;
        covered = covered_next;
    }
    return covered;
}
