// SPDX-License-Identifier: GPL-2.0-or-later
//
// Unaligned accesses of several words (DDI 0403, A3.2.1): they always fault, where single ones do only if CCR.UNALIGN_TRP is set
// (faults.c). By itself, since an emulator may well do them, and then the other faults should still be seen to pass.

#include "catch.h"
#include "check.h"
#include "chip/stm32f103.h"

CAUSE(load_double, "ldrd r0, r1, [r0]")
CAUSE(store_double, "strd r0, r1, [r0]")
CAUSE(load_multiple, "ldmia r0, {r1, r2}")
CAUSE(store_multiple, "stmia r0!, {r1, r2}")

static uint32_t words[4];

int main(void)
{
    uint32_t odd = (uint32_t)(uintptr_t)words + 1;
    SCB->SHCSR = SHCSR_USGFAULTENA;
    provoke(load_multiple, odd - 1);
    check_equal("aligned-is-allowed", caught.exception, 0);
    provoke(load_multiple, odd);
    expect_caught("ldm-faults", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(load_multiple));
    provoke(store_multiple, odd);
    expect_caught("stm-faults", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(store_multiple));
    provoke(load_double, odd + 1);
    expect_caught("ldrd-faults", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(load_double));
    provoke(store_double, odd + 1);
    expect_caught("strd-faults", EXCEPTION_USAGEFAULT, CFSR_UNALIGNED, address_of(store_double));
    check_done();
}
