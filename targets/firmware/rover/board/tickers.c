// SPDX-License-Identifier: GPL-2.0-or-later

#include "rover/board/tickers.h"

#include "f767/lp_ticker.h"
#include "rover/board/clock.h"

#define LAST_TICK 0xFFFFu
#define TENTH 3277u // ticks of 32768 Hz

void lp_ticker_irq_handler(void) { lp_ticker_set_interrupt((lp_ticker_read() + TENTH) & LAST_TICK); }

void clock_and_tickers_start(void)
{
    clock_start();
    lp_ticker_init();
    lp_ticker_irq_handler();
}
