// SPDX-License-Identifier: GPL-2.0-or-later
//
// A rover that is to keep a log in serial flash, and asks that memory who it is before anything else. With LOG_MEMORY_TRIES 0
// it waits for the answer for ever; otherwise it looks so many times, and goes on without a log.
//
// The linker puts this before the rover's own main (--wrap in rover.mk).

#include <stdbool.h>

#include "rover/chip/quadspi.h"
#include "rover/chip/rcc.h"

#define READ_ID 0x9Fu // JEDEC JESD216
#define ID_BYTES 3u
#define SIZE_16_MB 23u

int __wrap_main(void);
int __real_main(void);

static bool answered(void) { return QUADSPI->SR & QUADSPI_SR_TCF; }

static void ask_who_it_is(void)
{
    RCC->AHB3ENR |= RCC_AHB3_QUADSPI;
    (void)RCC->AHB3ENR; // the gate is open by then
    QUADSPI->DCR = SIZE_16_MB << QUADSPI_DCR_FSIZE_SHIFT;
    QUADSPI->CR = QUADSPI_CR_EN | 1u << QUADSPI_CR_PRESCALER_SHIFT;
    QUADSPI->DLR = ID_BYTES - 1;
    QUADSPI->CCR = QUADSPI_CCR_INDIRECT_READ | QUADSPI_CCR_ONE_LINE(QUADSPI_CCR_IMODE) |
                   QUADSPI_CCR_ONE_LINE(QUADSPI_CCR_DMODE) | READ_ID;
}

int __wrap_main(void)
{
    ask_who_it_is();
    for (unsigned tries = 0; !answered(); ++tries)
        if (LOG_MEMORY_TRIES && tries == LOG_MEMORY_TRIES)
            break;
    return __real_main();
}
