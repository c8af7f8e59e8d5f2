// SPDX-License-Identifier: GPL-2.0-or-later
//
// Waiting for hardware that may never answer.

#pragma once

#include <stdbool.h>
#include <stdint.h>

// About 20 ms at 72 MHz and 200 ms at 8 MHz.
#define WAIT_POLLS 200000u

// Polls until the condition holds; false if it does not within WAIT_POLLS polls.
#define wait_until(condition)                                                                                           \
    ({                                                                                                                  \
        uint32_t polls_ = WAIT_POLLS;                                                                                   \
        bool met_;                                                                                                      \
        while (!(met_ = (condition)) && --polls_ != 0) {                                                                \
        }                                                                                                               \
        met_;                                                                                                           \
    })
