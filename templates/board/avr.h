/* An ATmega328P under simavr: output over the UART, Timer1 counts cycles. */
#pragma once

#include <avr/interrupt.h>
#include <avr/io.h>
#include <avr/pgmspace.h>
#include <avr/sleep.h>
#include <stdint.h>

#define BOARD_CONST PROGMEM
#define BOARD_BARRIER __asm__ volatile("" ::: "memory")
#define BOARD_PAINT 300 /* bytes below the stack pointer that are painted before a call */
#define BOARD_STACK_POINTER(p) ((p) = (volatile uint8_t *)SP)

static volatile uint16_t board_turns; /* of the 16-bit counter */

ISR(TIMER1_OVF_vect)
{
    board_turns++;
}

static inline void board_start(void)
{
    UCSR0B = (uint8_t)(1U << TXEN0);
    TCCR1A = 0U;
    TCCR1B = 1U;
    TIMSK1 = 1U;
    sei();
}

static inline uint32_t board_ticks(void)
{
    cli();
    const uint16_t count = TCNT1;
    uint16_t turns = board_turns;
    if ((TIFR1 & 1U) != 0U && count < 0x8000U) {
        turns++;
    }
    sei();
    return ((uint32_t)turns << 16) | count;
}

static inline uint32_t board_since(uint32_t begin)
{
    return board_ticks() - begin;
}

static inline void board_read(void *to, const void *from, uint16_t size)
{
    memcpy_P(to, from, size);
}

static inline void board_write(const char *text)
{
    for (; *text != '\0'; text++) {
        while ((UCSR0A & (1U << UDRE0)) == 0U) {
        }
        UDR0 = (uint8_t)*text;
    }
}

static inline void board_stop(void)
{
    cli();
    sleep_mode(); /* simavr ends when the core sleeps with interrupts off */
}

