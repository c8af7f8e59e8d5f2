// SPDX-License-Identifier: GPL-2.0-or-later
//
// How a self-test speaks: a line for each check, "ok NAME" or "FAIL NAME got=.. want=..", and at the end
// "done N ok M failed". A check's name says what the manual promises.
//
// Over a serial line a check takes milliseconds: what is timed, or goes on meanwhile, is measured first and checked after.

#pragma once

#include <stdbool.h>
#include <stdint.h>

// The two must be equal.
void check_equal(const char *name, uint32_t got, uint32_t want);

// low <= got <= high.
void check_range(const char *name, uint32_t got, uint32_t low, uint32_t high);

// It must be so.
static inline void check(const char *name, bool holds) { check_equal(name, holds, 1); }

// Prints the tally and ends the program; the status is the number of checks that failed.
__attribute__((noreturn)) void check_done(void);

// For tests that a reset is part of: the tally is kept over the reset, and with it a stage. Call it first. `expected` says
// whether this reset looks like the one the test made; if not, the tally and the stage start from zero.
uint32_t check_stage(bool expected);

// The stage that check_stage returns after the next reset.
void check_next_stage(uint32_t stage);

// For a test that loses RAM on its way: the tally goes to two half-words that last, and comes back from there.
void check_keep(volatile uint32_t *registers);
void check_resume(volatile const uint32_t *registers);
