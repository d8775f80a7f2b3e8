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

/* A negative number is shifted right as if by a division that rounds down: C leaves that to the compiler. */
typedef char gantry_shifts_down[((-3) >> 1 == -2) ? 1 : -1];

#if defined(__AVR__)
/* a / 2^n rounded down, and a 2^n of a >= 0, by bytes first. */
static inline int32_t gantry_shift_down(int32_t a, int32_t n)
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

static inline int32_t gantry_shift_up(int32_t a, int32_t n)
{
    uint32_t shifted = (uint32_t)a;
    if (((uint8_t)n & 16U) != 0U) { shifted <<= 16; }
    if (((uint8_t)n & 8U) != 0U) { shifted <<= 8; }
    for (uint8_t k = (uint8_t)n & 7U; k != 0U; --k) { shifted <<= 1; }
    shifted &= 0x7fffffffU;
    return (int32_t)shifted;
}

/* a b, a of 16 bits with a sign, b of 16 without one. */
static inline int32_t gantry_product(int32_t a, int32_t b)
{
    int16_t signed_half = (int16_t)a;
    uint16_t unsigned_half = (uint16_t)b;
    __asm__("" : "+r"(signed_half), "+r"(unsigned_half));
    return (int32_t)signed_half * (int32_t)unsigned_half;
}

/* a b / 2^16 rounded down, for 0 <= b < 2^16. */
static inline int32_t gantry_high_product(int32_t a, int32_t b)
{
    uint16_t low_half = (uint16_t)a;
    uint16_t unsigned_half = (uint16_t)b;
    __asm__("" : "+r"(low_half), "+r"(unsigned_half));
    const uint32_t low_part = (uint32_t)low_half * unsigned_half;
    return gantry_product(a >> 16, b) + (int32_t)(low_part >> 16);
}
#else
/* a / 2^n rounded down, and a 2^n of a >= 0. */
static inline int32_t gantry_shift_down(int32_t a, int32_t n)
{
    return a >> n;
}

static inline int32_t gantry_shift_up(int32_t a, int32_t n)
{
    const uint32_t shifted = ((uint32_t)a << (uint32_t)n) & 0x7fffffffU;
    return (int32_t)shifted;
}

/* a b, a of 16 bits with a sign, b of 16 without one. */
static inline int32_t gantry_product(int32_t a, int32_t b)
{
    return a * b;
}

/* a b / 2^16 rounded down, for 0 <= b < 2^16. */
static inline int32_t gantry_high_product(int32_t a, int32_t b)
{
    const uint32_t low_part = ((uint32_t)a & 0xffffU) * (uint32_t)b;
    return (gantry_shift_down(a, 16) * b) + (int32_t)(low_part >> 16);
}
#endif

/* By how many bits a > 0 can be shifted up to [2^30, 2^31). */
static inline int32_t gantry_leading(int32_t a)
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
static inline int32_t gantry_low_bits(int32_t a, int32_t mask)
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
 * 8 for each octave of y, for H = 4 ln((2 - y)/y)/((1 - y) y (2 - y)).
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

/* By row: H is its quadratic times 2 to this power, and a common one. */
static const uint8_t gantry_h_shifts[72] GANTRY_FLASH = {
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
    36658, 36658
};

/* The product e H/d times the gain is shifted down by this, less the shifts of d and of H's row. */
static const uint8_t gantry_shift_offsets[2] GANTRY_FLASH = {
    18, 18
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
    const int32_t count_low = gantry_low_bits(count, 65535);
    const int32_t passed = gantry_high_product(34359738, count_low);
    const bool early = passed < 2097151;
    const int32_t place = early ? passed : 2097151;
    const int32_t segment = gantry_shift_down(place, 16);
    const int32_t share = gantry_low_bits(place, 65535);
    const int32_t first = segment * 4;
    *row = first;
    *s = share;
}

/* At s: (1 - s)^3 and s^3 in 2^-15, 3 s + 3 s^2 - 2 s^3 in 2^-14. */
static inline void gantry_weights(int32_t s, int32_t *w0, int32_t *w1, int32_t *w2)
{
    const int32_t s_fine = gantry_shift_up(s, 12);
    const int32_t square = gantry_high_product(s_fine, s);
    const int32_t cube = gantry_high_product(square, s);
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
    const int32_t middle_rounded = gantry_shift_down(middle_and_half, 14);
    const bool first_over = 0 < first;
    const int32_t first_raised = first_over ? first : 0;
    const int32_t first_and_half = first_raised + 4096;
    const int32_t first_weight = gantry_shift_down(first_and_half, 13);
    const bool middle_under = middle_rounded < 65535;
    const int32_t middle_weight = middle_under ? middle_rounded : 65535;
    const int32_t last_and_half = cube + 4096;
    const int32_t last_weight = gantry_shift_down(last_and_half, 13);
    *w0 = first_weight;
    *w1 = middle_weight;
    *w2 = last_weight;
}

/* An edge of the tube: a control point, and the steps about it by their weights. */
static inline int32_t gantry_edge_at(int32_t at, int32_t w0, int32_t w1, int32_t w2)
{
    const int32_t q0 = GANTRY_READ_32(gantry_coefficients[at]);
    const int32_t at_1 = at + 4;
    const int32_t q1 = GANTRY_READ_32(gantry_coefficients[at_1]);
    const int32_t at_2 = at + 8;
    const int32_t q2 = GANTRY_READ_32(gantry_coefficients[at_2]);
    const int32_t at_3 = at + 12;
    const int32_t q3 = GANTRY_READ_32(gantry_coefficients[at_3]);
    const int32_t difference_0 = q1 - q0;
    const int32_t difference_1 = q2 - q1;
    const int32_t difference_2 = q3 - q2;
    const int32_t d0 = (int32_t)(int16_t)difference_0;
    const int32_t d1 = (int32_t)(int16_t)difference_1;
    const int32_t d2 = (int32_t)(int16_t)difference_2;
    const int32_t six_q1 = q1 * 6;
    const int32_t base = six_q1 + d1;
    const int32_t d1_weighted = gantry_product(d1, w1);
    const int32_t middle_part = gantry_shift_down(d1_weighted, 14);
    const int32_t d2_weighted = gantry_product(d2, w2);
    const int32_t d0_weighted = gantry_product(d0, w0);
    const int32_t outer = d2_weighted - d0_weighted;
    const int32_t outer_part = gantry_shift_down(outer, 15);
    const int32_t base_and_middle = base + middle_part;
    const int32_t value = base_and_middle + outer_part;
    return value;
}

/* The quadratic of a row, level - (slope - bend t) t, at t in 2^-16. */
static inline int32_t gantry_curve(int32_t row, int32_t t)
{
    const int32_t level = GANTRY_READ_16(gantry_levels[row]);
    const int32_t slope = GANTRY_READ_16(gantry_slopes[row]);
    const int32_t bend = GANTRY_READ_16(gantry_bends[row]);
    const int32_t bend_t = gantry_product(bend, t);
    const int32_t bend_part = gantry_shift_down(bend_t, 16);
    const int32_t mean_slope = slope - bend_part;
    const int32_t slope_t = gantry_product(mean_slope, t);
    const int32_t fall = gantry_shift_down(slope_t, 17);
    const int32_t difference = level - fall;
    const int32_t value = gantry_low_bits(difference, 65535);
    return value;
}

/* |u|: gain e H/d, at most `limit`. */
static inline int32_t gantry_input_size(int32_t e, int32_t h, int32_t reciprocal, int32_t gain, int32_t shift,
                                        int32_t limit)
{
    const int32_t e_times_h = gantry_high_product(e, h);
    const int32_t over_width = gantry_high_product(e_times_h, reciprocal);
    const int32_t unshifted = gantry_high_product(over_width, gain);
    const int32_t unlimited = gantry_shift_down(unshifted, shift);
    const bool limit_under = unlimited < limit;
    const int32_t size = limit_under ? unlimited : limit;
    return size;
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
        const int32_t lower_edge = gantry_edge_at(lower_at, w0, w1, w2);
        const int32_t upper_edge = gantry_edge_at(upper_at, w0, w1, w2);
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
        const int32_t lower_edge = gantry_edge_at(lower_at, w0, w1, w2);
        const int32_t upper_edge = gantry_edge_at(upper_at, w0, w1, w2);
        const int32_t x_any = x[i];
        const bool x_over = (-268435456) < x_any;
        const int32_t x_raised = x_over ? x_any : (-268435456);
        const bool x_under = x_raised < 268435456;
        const int32_t x_i = x_under ? x_raised : 268435456;
        const int32_t to_lower = x_i - lower_edge;
        const int32_t to_upper = upper_edge - x_i;
        const int32_t width = to_lower + to_upper;
        const int32_t difference = to_lower - to_upper;
        const bool wide = 131072 < width;
        const int32_t safe_width = wide ? width : 131072;
        const int32_t width_shift = gantry_leading(safe_width);
        const int32_t width_shifted = gantry_shift_up(safe_width, width_shift);
        const int32_t width_bits = gantry_shift_down(width_shifted, 26);
        const int32_t width_row = gantry_low_bits(width_bits, 15);
        const int32_t width_tail = gantry_shift_down(width_shifted, 10);
        const int32_t width_t = gantry_low_bits(width_tail, 65535);
        const int32_t reciprocal = gantry_curve(width_row, width_t);
        const bool upper_nearer = 0 < difference;
        const int32_t difference_minus = -difference;
        const int32_t offset = upper_nearer ? difference : difference_minus;
        const bool offset_under = offset < safe_width;
        const int32_t offset_limited = offset_under ? offset : safe_width;
        const int32_t offset_shifted = gantry_shift_up(offset_limited, width_shift);
        const int32_t e_any = gantry_high_product(offset_shifted, reciprocal);
        const bool e_under = e_any < 1063134168;
        const int32_t e_limited = e_under ? e_any : 1063134168;
        const int32_t remainder = width_shifted - offset_shifted;
        const int32_t y_any = gantry_high_product(remainder, reciprocal);
        const bool y_over = 10736107 < y_any;
        const int32_t y_raised = y_over ? y_any : 10736107;
        const bool y_under = y_raised < 1073741823;
        const int32_t y_limited = y_under ? y_raised : 1073741823;
        const int32_t y_shift = gantry_leading(y_limited);
        const int32_t octave_rows = y_shift * 8;
        const int32_t first_row = octave_rows + 8;
        const int32_t y_shifted = gantry_shift_up(y_limited, y_shift);
        const int32_t y_bits = gantry_shift_down(y_shifted, 27);
        const int32_t y_piece = gantry_low_bits(y_bits, 7);
        const int32_t y_row = y_piece + first_row;
        const int32_t y_tail = gantry_shift_down(y_shifted, 11);
        const int32_t y_t = gantry_low_bits(y_tail, 65535);
        const int32_t h = gantry_curve(y_row, y_t);
        const int32_t h_shift = GANTRY_READ_8(gantry_h_shifts[y_row]);
        const int32_t gain = GANTRY_READ_16(gantry_gains[i]);
        const int32_t shift_offset = GANTRY_READ_8(gantry_shift_offsets[i]);
        const int32_t limit = GANTRY_READ_32(gantry_limits[i]);
        const int32_t less_width_shift = shift_offset - width_shift;
        const int32_t shift_any = less_width_shift - h_shift;
        const bool shift_over = 0 < shift_any;
        const int32_t shift = shift_over ? shift_any : 0;
        const int32_t size = gantry_input_size(e_limited, h, reciprocal, gain, shift, limit);
        const int32_t size_minus = -size;
        const int32_t u_i = upper_nearer ? size_minus : size;
        u[i] = u_i;
        const bool inside = offset < width;
        const bool outside_next = inside ? outside : true;
        outside = outside_next;
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
        const int32_t lower_edge = gantry_edge_at(lower_at, w0, w1, w2);
        const int32_t upper_edge = gantry_edge_at(upper_at, w0, w1, w2);
        const int32_t x_any = x[i];
        const bool x_over = (-268435456) < x_any;
        const int32_t x_raised = x_over ? x_any : (-268435456);
        const bool x_under = x_raised < 268435456;
        const int32_t x_i = x_under ? x_raised : 268435456;
        const int32_t to_lower = x_i - lower_edge;
        const int32_t to_upper = upper_edge - x_i;
        const int32_t x_width = to_lower + to_upper;
        const bool x_wide = 131072 < x_width;
        const int32_t x_safe_width = x_wide ? x_width : 131072;
        const int32_t x_width_shift = gantry_leading(x_safe_width);
        const int32_t x_width_shifted = gantry_shift_up(x_safe_width, x_width_shift);
        const int32_t x_width_bits = gantry_shift_down(x_width_shifted, 26);
        const int32_t x_width_row = gantry_low_bits(x_width_bits, 15);
        const int32_t x_width_tail = gantry_shift_down(x_width_shifted, 10);
        const int32_t x_width_t = gantry_low_bits(x_width_tail, 65535);
        const int32_t x_reciprocal = gantry_curve(x_width_row, x_width_t);
        const bool x_nearer = to_upper < to_lower;
        const int32_t x_distance = x_nearer ? to_upper : to_lower;
        const bool x_inside = 0 < x_distance;
        const int32_t x_distance_minus = -x_distance;
        const int32_t x_size = x_inside ? x_distance : x_distance_minus;
        const bool x_size_under = x_size < x_safe_width;
        const int32_t x_size_limited = x_size_under ? x_size : x_safe_width;
        const int32_t x_size_shifted = gantry_shift_up(x_size_limited, x_width_shift);
        const int32_t x_quotient = gantry_high_product(x_size_shifted, x_reciprocal);
        const int32_t x_share_any = gantry_shift_down(x_quotient, 14);
        const bool x_share_under = x_share_any < 65535;
        const int32_t x_share = x_share_under ? x_share_any : 65535;
        const int32_t x_share_minus = (-1) - x_share;
        const int32_t margin_x = x_inside ? x_share : x_share_minus;
        const bool less = margin_x < margin;
        const int32_t margin_next = less ? margin_x : margin;
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
        const int32_t lower_edge = gantry_edge_at(lower_at, w0, w1, w2);
        const int32_t upper_edge = gantry_edge_at(upper_at, w0, w1, w2);
        const int32_t x_any = x[i];
        const bool x_over = (-268435456) < x_any;
        const int32_t x_raised = x_over ? x_any : (-268435456);
        const bool x_under = x_raised < 268435456;
        const int32_t x_i = x_under ? x_raised : 268435456;
        const int32_t to_lower = x_i - lower_edge;
        const int32_t to_upper = upper_edge - x_i;
        const int32_t x_width = to_lower + to_upper;
        const bool x_wide = 131072 < x_width;
        const int32_t x_safe_width = x_wide ? x_width : 131072;
        const int32_t x_width_shift = gantry_leading(x_safe_width);
        const int32_t x_width_shifted = gantry_shift_up(x_safe_width, x_width_shift);
        const int32_t x_width_bits = gantry_shift_down(x_width_shifted, 26);
        const int32_t x_width_row = gantry_low_bits(x_width_bits, 15);
        const int32_t x_width_tail = gantry_shift_down(x_width_shifted, 10);
        const int32_t x_width_t = gantry_low_bits(x_width_tail, 65535);
        const int32_t x_reciprocal = gantry_curve(x_width_row, x_width_t);
        const bool x_nearer = to_upper < to_lower;
        const int32_t x_distance = x_nearer ? to_upper : to_lower;
        const bool x_inside = 0 < x_distance;
        const int32_t x_distance_minus = -x_distance;
        const int32_t x_size = x_inside ? x_distance : x_distance_minus;
        const bool x_size_under = x_size < x_safe_width;
        const int32_t x_size_limited = x_size_under ? x_size : x_safe_width;
        const int32_t x_size_shifted = gantry_shift_up(x_size_limited, x_width_shift);
        const int32_t x_quotient = gantry_high_product(x_size_shifted, x_reciprocal);
        const int32_t x_share_any = gantry_shift_down(x_quotient, 14);
        const bool x_share_under = x_share_any < 65535;
        const int32_t x_share = x_share_under ? x_share_any : 65535;
        const int32_t x_share_minus = (-1) - x_share;
        const int32_t margin_x = x_inside ? x_share : x_share_minus;
        margin[i] = margin_x;
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
