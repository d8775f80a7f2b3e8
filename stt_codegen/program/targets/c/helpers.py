"""The C of helper functions that printed operations call: exponent and mantissa of a number, and arithmetic of integers."""

from __future__ import annotations

_BIT_LAYOUTS = {  # type of the bits, width of the fraction, and the bits of 1/sqrt 2
    "float": ("uint32_t", 23, "0x3f3504f3U"),
    "double": ("uint64_t", 52, "0x3fe6a09e667f3bcdU"),
}


def split_lines(prefix: str, scalar: str) -> list[str]:
    """Return the C of the operations `exponent` and `mantissa`, by the bits of an IEEE-754 number."""
    word, shift, smallest = _BIT_LAYOUTS[scalar]
    size = 4 if scalar == "float" else 8
    head = [f"    {word} bits;", "    (void)memcpy(&bits, &y, sizeof bits);"]
    return [
        f"/* The type must have {8 * size} bits: avr-gcc's double, for one, has not. */",
        f"typedef char {prefix}_real_size[(sizeof({prefix}_real) == {size}U) ? 1 : -1];",
        "",
        "/* y = m 2^e with m in [1/sqrt 2, sqrt 2), for y not below that: e, and m. */",
        f"static inline int32_t {prefix}_exponent({prefix}_real y)",
        "{",
        *head,
        f"    return (int32_t)((bits - {smallest}) >> {shift});",
        "}",
        "",
        f"static inline {prefix}_real {prefix}_mantissa({prefix}_real y)",
        "{",
        *head,
        f"    bits = ((bits - {smallest}) & {(1 << shift) - 1:#x}U) + {smallest};",
        f"    {prefix}_real m;",
        "    (void)memcpy(&m, &bits, sizeof m);",
        "    return m;",
        "}",
    ]


def fixed_lines(prefix: str) -> list[str]:
    """Return the C of the operations that only a program of integers has, and what it assumes of the compiler."""
    return [*_table_lines(prefix), *_avr_lines(prefix), *_portable_lines(prefix), *_bit_lines(prefix)]


def _table_lines(prefix: str) -> list[str]:
    """Return macros that read entries of tables, from the flash of an AVR too, and a check of how the compiler shifts."""
    macro = prefix.upper()
    return [
        "/* Tables stay in flash: an AVR reads it by instructions of its own. */",
        "#if defined(__AVR__)",
        "#include <avr/pgmspace.h>",
        f"#define {macro}_FLASH PROGMEM",
        f"#define {macro}_READ_8(entry) ((int32_t)pgm_read_byte(&(entry)))",
        f"#define {macro}_READ_16(entry) ((int32_t)pgm_read_word(&(entry)))",
        f"#define {macro}_READ_32(entry) ((int32_t)pgm_read_dword(&(entry)))",
        "#else",
        f"#define {macro}_FLASH",
        *(f"#define {macro}_READ_{bits}(entry) ((int32_t)(entry))" for bits in (8, 16, 32)),
        "#endif",
        "",
        "/* A negative number is shifted right as if by a division that rounds down: C leaves that to the compiler. */",
        f"typedef char {prefix}_shifts_down[((-3) >> 1 == -2) ? 1 : -1];",
        "",
    ]


def _avr_lines(prefix: str) -> list[str]:
    """Return shifts and products for an AVR, written out by bytes.

    On an AVR gcc turns every shift but by a whole number of bytes into a loop, and a product within a larger expression into one
    of 32 x 32 bits.
    """
    return [
        "#if defined(__AVR__)",
        "/* a / 2^n rounded down, and a 2^n of a >= 0, by bytes first. */",
        f"static inline int32_t {prefix}_shift_down(int32_t a, int32_t n)",
        "{",
        "    int32_t shifted = a;",
        "    if (__builtin_constant_p(n) && (n >= 16)) {",
        "        return (int16_t)(a >> 16) >> (n - 16);",
        "    }",
        "    if (__builtin_constant_p(n) && (n > 12)) {",
        "        return ((a >> 16) * ((int32_t)1 << (16 - n))) + (int32_t)((uint16_t)a >> n);",
        "    }",
        "    if (((uint8_t)n & 16U) != 0U) { shifted >>= 16; }",
        "    if (((uint8_t)n & 8U) != 0U) { shifted >>= 8; }",
        "    for (uint8_t k = (uint8_t)n & 7U; k != 0U; --k) { shifted >>= 1; }",
        "    return shifted;",
        "}",
        "",
        f"static inline int32_t {prefix}_shift_up(int32_t a, int32_t n)",
        "{",
        "    uint32_t shifted = (uint32_t)a;",
        "    if (((uint8_t)n & 16U) != 0U) { shifted <<= 16; }",
        "    if (((uint8_t)n & 8U) != 0U) { shifted <<= 8; }",
        "    for (uint8_t k = (uint8_t)n & 7U; k != 0U; --k) { shifted <<= 1; }",
        "    shifted &= 0x7fffffffU;",
        "    return (int32_t)shifted;",
        "}",
        "",
        "/* a b, a of 16 bits with a sign, b of 16 without one. */",
        f"static inline int32_t {prefix}_product(int32_t a, int32_t b)",
        "{",
        "    int16_t signed_half = (int16_t)a;",
        "    uint16_t unsigned_half = (uint16_t)b;",
        '    __asm__("" : "+r"(signed_half), "+r"(unsigned_half));',
        "    return (int32_t)signed_half * (int32_t)unsigned_half;",
        "}",
        "",
        "/* a b / 2^16 rounded down, for 0 <= b < 2^16. */",
        f"static inline int32_t {prefix}_high_product(int32_t a, int32_t b)",
        "{",
        "    uint16_t low_half = (uint16_t)a;",
        "    uint16_t unsigned_half = (uint16_t)b;",
        '    __asm__("" : "+r"(low_half), "+r"(unsigned_half));',
        "    const uint32_t low_part = (uint32_t)low_half * unsigned_half;",
        f"    return {prefix}_product(a >> 16, b) + (int32_t)(low_part >> 16);",
        "}",
    ]


def _portable_lines(prefix: str) -> list[str]:
    """Return shifts and products for every compiler but that of an AVR."""
    return [
        "#else",
        "/* a / 2^n rounded down, and a 2^n of a >= 0. */",
        f"static inline int32_t {prefix}_shift_down(int32_t a, int32_t n)",
        "{",
        "    return a >> n;",
        "}",
        "",
        f"static inline int32_t {prefix}_shift_up(int32_t a, int32_t n)",
        "{",
        "    const uint32_t shifted = ((uint32_t)a << (uint32_t)n) & 0x7fffffffU;",
        "    return (int32_t)shifted;",
        "}",
        "",
        "/* a b, a of 16 bits with a sign, b of 16 without one. */",
        f"static inline int32_t {prefix}_product(int32_t a, int32_t b)",
        "{",
        "    return a * b;",
        "}",
        "",
        "/* a b / 2^16 rounded down, for 0 <= b < 2^16. */",
        f"static inline int32_t {prefix}_high_product(int32_t a, int32_t b)",
        "{",
        "    const uint32_t low_part = ((uint32_t)a & 0xffffU) * (uint32_t)b;",
        f"    return ({prefix}_shift_down(a, 16) * b) + (int32_t)(low_part >> 16);",
        "}",
        "#endif",
        "",
    ]


def _bit_lines(prefix: str) -> list[str]:
    """Return the C of `leading` and `low_bits`."""
    return [
        "/* By how many bits a > 0 can be shifted up to [2^30, 2^31). */",
        f"static inline int32_t {prefix}_leading(int32_t a)",
        "{",
        "    uint32_t shifted = (uint32_t)a;",
        "    int32_t shift = 0;",
        "    if (shifted < 0x8000U) { shifted <<= 16; shift = 16; }",
        "    if (shifted < 0x800000U) { shifted <<= 8; shift += 8; }",
        "    if (shifted < 0x8000000U) { shifted <<= 4; shift += 4; }",
        "    if (shifted < 0x20000000U) { shifted <<= 2; shift += 2; }",
        "    if (shifted < 0x40000000U) { shift += 1; }",
        "    return shift;",
        "}",
        "",
        "/* a mod 2^k, mask being 2^k - 1. */",
        f"static inline int32_t {prefix}_low_bits(int32_t a, int32_t mask)",
        "{",
        "    const uint32_t bits = (uint32_t)a & (uint32_t)mask;",
        "    return (int32_t)bits;",
        "}",
    ]
