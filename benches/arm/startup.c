/*
 * Start of a program on a Cortex-M, and its output by semihosting. With -DSPRUNG_STDIO, the program uses
 * printf of newlib (rdimon.specs).
 */
#include "machine.h"

#include <stdint.h>

#ifdef SPRUNG_STDIO
#include <stdlib.h>
void initialise_monitor_handles(void);

/* newlib calls these at the begin and at the end. */
void _init(void);
void _fini(void);

void _init(void)
{
}

void _fini(void)
{
}
#endif

extern uint32_t data_begin[], data_end[], data_in_flash[], bss_begin[], bss_end[], stack_top[];

int main(void);
void reset(void);

/* Operations of semihosting. */
enum { WRITE_STRING = 0x04, EXIT = 0x18 };

/* Reasons of an exit. */
enum { DONE = 0x20026, FAULT = 0x20023 };

static void ask(uint32_t operation, uintptr_t argument)
{
    register uint32_t r0 __asm__("r0") = operation;
    register uintptr_t r1 __asm__("r1") = argument;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

void print(const char *text)
{
    ask(WRITE_STRING, (uintptr_t)text);
}

static void fault(void)
{
    print("the processor stopped with a fault\n");
    ask(EXIT, FAULT);
    for (;;) {
    }
}

/* The first words of the memory: where the stack begins, the program, and six kinds of faults. */
__attribute__((section(".vectors"), used)) static const struct {
    uint32_t *stack;
    void (*program)(void);
    void (*faults[6])(void);
} vectors = {stack_top, reset, {fault, fault, fault, fault, fault, fault}};

#define REGISTER(address) (*(volatile uint32_t *)(address))
#define COPROCESSORS REGISTER(0xe000ed88)
#define TIMER_CONTROL REGISTER(0xe000e010)
#define TIMER_RELOAD REGISTER(0xe000e014)
#define TIMER_VALUE REGISTER(0xe000e018)

/* The timer counts at 25 MHz, and -icount shift=0 gives each instruction 1 ns. */
#define INSTRUCTIONS_PER_TICK 40u

void begin_count(void)
{
    TIMER_RELOAD = 0xffffff;
    TIMER_VALUE = 0;
    TIMER_CONTROL = 5;
    while (TIMER_VALUE == 0) {
    }
}

uint32_t count(void)
{
    return (0xffffff - TIMER_VALUE) * INSTRUCTIONS_PER_TICK;
}

/* Two instructions for each turn. */
void loop(uint32_t turns)
{
    __asm__ volatile("1: subs %0, #1\n bne 1b" : "+r"(turns) : : "cc");
}

#define PAINT 0x5a5a5a5au

__attribute__((noinline)) uint32_t stack_of(void (*call)(void))
{
    uint32_t *own = __builtin_frame_address(0);
    uint32_t *word;
    uint32_t *top;
    __asm__ volatile("mov %0, sp" : "=r"(top));
    for (word = bss_end; word < top; word++) {
        *(volatile uint32_t *)word = PAINT;
    }
    call();
    for (word = bss_end; word < own && *(volatile uint32_t *)word == PAINT; word++) {
    }
    return (uint32_t)((uintptr_t)top - (uintptr_t)word);
}

/* Runs before the memory has its values: uses none. */
__attribute__((noreturn)) void reset(void)
{
    uint32_t *to;
    const uint32_t *from = data_in_flash;
    int code;
    COPROCESSORS |= 0xfu << 20;
    __asm__ volatile("dsb\n isb");
    for (to = data_begin; to < data_end; to++) {
        *to = *from++;
    }
    for (to = bss_begin; to < bss_end; to++) {
        *to = 0;
    }
#ifdef SPRUNG_STDIO
    initialise_monitor_handles();
    code = main();
    exit(code);
#else
    code = main();
    ask(EXIT, code == 0 ? DONE : FAULT);
    for (;;) {
    }
#endif
}
