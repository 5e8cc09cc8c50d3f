/* What the driver needs from the machine that it runs on. */
#ifndef MACHINE_H
#define MACHINE_H

#include <stdint.h>

/* Prints a string. */
void print(const char *text);

#ifdef __arm__
/* Starts the count of instructions; it is exact to 40 and ends after 671 million. */
void begin_count(void);

/* Returns the instructions since begin_count. */
uint32_t count(void);

/* Takes two instructions for each turn: a known number. */
void loop(uint32_t turns);

/* Returns the bytes of stack that a function needs: those of a painted stack that it changes. */
uint32_t stack_of(void (*call)(void));
#endif

#endif
