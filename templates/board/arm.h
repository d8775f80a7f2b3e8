/* A Cortex-M under QEMU: output by semihosting, SysTick counts on the processor's clock (25.6 ticks an instruction with
 * -icount shift=10). */
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define BOARD_CONST
#define BOARD_BARRIER __asm__ volatile("" ::: "memory")
#define BOARD_PAINT 4096 /* bytes below the stack pointer that are painted before a call */
#define BOARD_STACK_POINTER(p) __asm__ volatile("mov %0, sp" : "=r"(p))
#define BOARD_SYSTICK ((volatile uint32_t *)0xE000E010U) /* control, reload, value */

static inline int board_call(int operation, const void *argument)
{
    register int r0 __asm__("r0") = operation;
    register const void *r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
    return r0;
}

static inline void board_start(void)
{
    BOARD_SYSTICK[1] = 0xFFFFFFU;
    BOARD_SYSTICK[2] = 0U;
    BOARD_SYSTICK[0] = 5U;
}

static inline uint32_t board_ticks(void)
{
    return BOARD_SYSTICK[2];
}

static inline uint32_t board_since(uint32_t begin)
{
    return (begin - BOARD_SYSTICK[2]) & 0xFFFFFFU; /* it counts down */
}

static inline void board_read(void *to, const void *from, size_t size)
{
    memcpy(to, from, size);
}

static inline void board_write(const char *text)
{
    (void)board_call(0x04, text);
}

static inline void board_stop(void)
{
    static const uint32_t reason[2] = {0x20026U, 0U};
    (void)board_call(0x20, reason);
}

