// SPDX-License-Identifier: GPL-2.0-or-later
//
// The interface of serial flash: RM0410, 14.5.

#pragma once

#include <stdint.h>

typedef struct {
    uint32_t CR, DCR, SR, FCR, DLR, CCR, AR, ABR, DR;
} quadspi_t;

#define QUADSPI ((volatile quadspi_t *)0xA0001000u)

#define QUADSPI_CR_EN (1u << 0)
#define QUADSPI_CR_PRESCALER_SHIFT 24
#define QUADSPI_DCR_FSIZE_SHIFT 16 // 2 to the power of this plus 1 is the memory's size in bytes
#define QUADSPI_SR_TCF (1u << 1)   // all bytes of an indirect read have come
#define QUADSPI_CCR_ONE_LINE(phase) (1u << (phase))
#define QUADSPI_CCR_IMODE 8
#define QUADSPI_CCR_DMODE 24
#define QUADSPI_CCR_INDIRECT_READ (1u << 26)
