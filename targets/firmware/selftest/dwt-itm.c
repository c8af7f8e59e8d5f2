// SPDX-License-Identifier: GPL-2.0-or-later
//
// The cycle counter and the instrumentation trace (DDI 0403, C1.7 and C1.8; Cortex-M3 TRM), as firmware uses them: to
// measure and to print. Stimulus port 0 gets the text "itm console\n" in bytes, a half-word and a word.

#include "check.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "wait.h"

static void cycle_counter(void)
{
    DEMCR |= DEMCR_TRCENA;
    check_equal("four-comparators", DWT->CTRL >> DWT_NUMCOMP_SHIFT, 4);
    DWT->CTRL &= ~DWT_CYCCNTENA;
    DWT->CYCCNT = 1234;
    for (int i = 0; i < 20; ++i)
        NOP();
    check_equal("stands-still-when-disabled", DWT->CYCCNT, 1234);
    DWT->CTRL |= DWT_CYCCNTENA;
    check("counts-when-enabled", DWT->CYCCNT > 1234);
    DWT->CYCCNT = 0;
    check_range("can-be-written", DWT->CYCCNT, 0, 60);
    DWT->CTRL &= ~DWT_CYCCNTENA;
    uint32_t stopped = DWT->CYCCNT;
    for (int i = 0; i < 20; ++i)
        NOP();
    check_equal("stands-still-when-stopped", DWT->CYCCNT, stopped);
    DWT->CTRL |= DWT_CYCCNTENA;
    DWT->CYCCNT = 0xFFFFFF00;
    wait_cycles(1000);
    check_range("wraps-at-32-bits", DWT->CYCCNT, 700, 1100);

    // The same clock as SysTick's: over any stretch both count the same, give or take the instructions between two reads
    SYSTICK->LOAD = 0xFFFFFF;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_ENABLE;
    uint32_t begin = cycles() + SYSTICK->VAL;
    wait_cycles(100000);
    uint32_t end = cycles() + SYSTICK->VAL;
    SYSTICK->CTRL = 0;
    check_range("agrees-with-systick", end - begin + 8, 0, 16);
}

static void when_asleep(void)
{
    // HCLK goes on in sleep mode, and with it this counter (RM0008, 5.3.3)
    SYSTICK->LOAD = 19999;
    SYSTICK->VAL = 0;
    irq_disable();
    uint32_t begin = cycles();
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
    WFI();
    uint32_t slept = cycles() - begin;
    SYSTICK->CTRL = 0;
    SCB->ICSR = ICSR_PENDSTCLR;
    irq_enable();
    check_range("counts-in-sleep", slept, 19900, 20200);
}

static bool port_ready(void) { return wait_until(ITM->STIM[0].word & 1); }

static void trace(void)
{
    ITM->LAR = CORESIGHT_UNLOCK;
    ITM->TCR = ITM_TCR_ITMENA | 1u << 16; // trace bus id 1
    ITM->TER[0] = 1;
    check_equal("ter-reads-back", ITM->TER[0], 1);
    check("itmena-reads-back", ITM->TCR & ITM_TCR_ITMENA);
    check("port-gets-ready", port_ready());
    for (const char *text = "itm c"; *text; ++text) {
        port_ready();
        ITM->STIM[0].byte = (uint8_t)*text;
    }
    port_ready();
    ITM->STIM[0].half = 'o' | 'n' << 8;
    port_ready();
    ITM->STIM[0].word = 's' | 'o' << 8 | 'l' << 16 | (uint32_t)'e' << 24;
    port_ready();
    ITM->STIM[0].byte = '\n';
    ITM->TER[0] = 0;
    ITM->STIM[0].byte = '!'; // goes nowhere
    ITM->TER[0] = 1;
    check("port-still-ready", port_ready());
}

static void debug_mcu(void)
{
    // Without a debugger it reads 0 ("Debug registers cannot be read by user software", errata sheet ES0340)
    uint32_t device = DBGMCU_IDCODE & 0xFFF;
    check("idcode-is-medium-density-or-hidden", device == 0x410 || device == 0);
    DBGMCU_CR = 0x307;
    check("dbgmcu-cr-reads-back-or-hidden", DBGMCU_CR == 0x307 || DBGMCU_CR == 0);
    DBGMCU_CR = 0;
}

int main(void)
{
    cycle_counter();
    when_asleep();
    trace();
    debug_mcu();
    check_done();
}
