// SPDX-License-Identifier: GPL-2.0-or-later
//
// What the Cortex-M7 has beyond the M3's registers in core.h (ARM DDI 0403, B3.2.20 and B2.2; DDI 0489).

#pragma once

#include <stdint.h>

#define CPACR (*(volatile uint32_t *)0xE000ED88u)
#define CPACR_FPU (0xFu << 20) // full access to CP10 and CP11

#define ICIALLU (*(volatile uint32_t *)0xE000EF50u) // a write empties the instruction cache
#define CCR_IC (1u << 17)
