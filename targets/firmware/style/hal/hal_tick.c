// SPDX-License-Identifier: GPL-2.0-or-later

#include "clock.h"
#include "hal.h"

static volatile uint32_t tick_ms;

__attribute__((weak)) void hal_inc_tick(void) { ++tick_ms; }

uint32_t hal_get_tick(void) { return tick_ms; }

hal_status_t hal_init_tick(void)
{
    uint32_t load = clock_hclk_hz() / 1000 - 1;
    if (load > 0xFFFFFF)
        return HAL_ERROR;
    SYSTICK->LOAD = load;
    exception_priority(EXCEPTION_SYSTICK, 15);
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
    return HAL_OK;
}

hal_status_t hal_init(void)
{
    FLASH->ACR |= FLASH_ACR_PRFTBE;
    SCB->AIRCR = AIRCR_VECTKEY | 3u << AIRCR_PRIGROUP_SHIFT; // all four bits of a priority preempt
    return hal_init_tick();
}

// One tick more than asked for, so that it is never less.
void hal_delay(uint32_t ms)
{
    uint32_t start = hal_get_tick();
    uint32_t wait = ms == HAL_FOREVER ? ms : ms + 1;
    while (hal_get_tick() - start < wait) {
    }
}
