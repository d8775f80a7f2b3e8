"""Names that compilers predefine and common headers define as macros: no local or parameter of emitted C has them.

Such a name compiles here. It breaks where one of these headers is included before the controller's, or with such a compiler. Only
names in small letters are listed (not `B0` of binary.h and termios.h, `F`, `I`, `PI` or `HIGH`), because no local has a capital.
"""

MACROS_BY_SOURCE = {
    "Arduino.h and avr/interrupt.h": "abs bit cli constrain degrees interrupts max min radians round sei sq word",
    "minwindef.h, rpcndr.h and combaseapi.h of Windows": "cdecl far hyper interface near pascal small",
    "compilers for 8 and 16 bits: Borland, Open Watcom, Keil C51, SDCC, XC8": """bank1 bank2 bank3 banked bdata code compact data
        eeprom flash huge idata interrupt large naked pdata persistent ram reentrant rom sbit sfr sram trap using xdata""",
    "gcc with -std=gnu99": "i386 linux mips sparc sun unix vax",
    "complex.h, math.h, stdio.h, assert.h, setjmp.h and stddef.h": """assert complex fpclassify imaginary isfinite isgreater
        isgreaterequal isinf isless islessequal islessgreater isnan isnormal isunordered offsetof setjmp signbit stderr stdin
        stdout""",
    "sys/param.h and sys/sysmacros.h": "howmany major makedev minor powerof2 roundup",
}
COMMON_MACROS = frozenset(name for names in MACROS_BY_SOURCE.values() for name in names.split())
