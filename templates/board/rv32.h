/* A 32-bit RISC-V under QEMU's virt machine: output by semihosting, the instruction counter of the core. */
#pragma once

#include <stddef.h>
#include <stdint.h>
#include <string.h>

#define BOARD_CONST
#define BOARD_BARRIER __asm__ volatile("" ::: "memory")
#define BOARD_PAINT 4096 /* bytes below the stack pointer that are painted before a call */
#define BOARD_STACK_POINTER(p) __asm__ volatile("mv %0, sp" : "=r"(p))

static inline int board_call(int operation, const void *argument)
{
    register int a0 __asm__("a0") = operation;
    register const void *a1 __asm__("a1") = argument;
    __asm__ volatile(".option push\n.balign 16\n.option norvc\nslli x0, x0, 0x1f\nebreak\nsrai x0, x0, 7\n.option pop"
                     : "+r"(a0)
                     : "r"(a1)
                     : "memory");
    return a0;
}

static inline void board_start(void)
{
}

static inline uint32_t board_ticks(void)
{
    uint32_t count;
    __asm__ volatile(".option push\n.option arch, +zicsr\ncsrr %0, minstret\n.option pop" : "=r"(count)::"memory");
    return count;
}

static inline uint32_t board_since(uint32_t begin)
{
    return board_ticks() - begin;
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

