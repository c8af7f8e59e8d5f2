// SPDX-License-Identifier: GPL-2.0-or-later
//
// Numbers that come from outside, which may be anything.

#pragma once

#include <stdbool.h>

// False for a NaN, and for an infinity.
static inline bool within(float value, float limit) { return value >= -limit && value <= limit; }
