// SPDX-License-Identifier: GPL-2.0-or-later
//
// Unaligned accesses (DDI 0403, A3.2.1): single loads and stores are allowed, unless CCR.UNALIGN_TRP is set; those of several
// words always fault. By itself, apart from the other faults, since an emulator may well not trap what hardly any firmware
// does on purpose.

#include "catch.h"
#include "check.h"
#include "chip/stm32f103.h"

CAUSE(load, "ldr r0, [r0]")
CAUSE(load_halfword, "ldrh r0, [r0]")
CAUSE(load_double, "ldrd r0, r1, [r0]")
CAUSE(load_multiple, "ldmia r0, {r1, r2}")

int main(void)
{
    static const uint32_t words[4] = {1, 2, 3, 4};
    uint32_t odd = (uint32_t)(uintptr_t)words + 1;
    SCB->SHCSR = SHCSR_USGFAULTENA;
    provoke(load, odd);
    check_equal("word-is-allowed", caught.exception, 0);
    provoke(load_halfword, odd);
    check_equal("half-word-is-allowed", caught.exception, 0);
    provoke(load_multiple, odd);
    expect_caught("ldm-faults", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(load_multiple));
    provoke(load_double, odd);
    expect_caught("ldrd-faults", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(load_double));
    SCB->CCR |= CCR_UNALIGN_TRP;
    provoke(load, odd);
    expect_caught("word-traps", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(load));
    provoke(load_halfword, odd);
    expect_caught("half-word-traps", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(load_halfword));
    SCB->CCR &= ~CCR_UNALIGN_TRP;
    check_done();
}
