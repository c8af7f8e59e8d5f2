// SPDX-License-Identifier: GPL-2.0-or-later
//
// LPTIM1 as Mbed OS 6 uses it for its low-power ticker, written anew from what that does:
//
//  * LSE on and awaited, the timer on it, without a prescaler, its registers reset by RCC;
//  * its vector in a table in RAM, its line of EXTI with a rising edge, CMPM and CMPOK enabled before the timer;
//  * ARR = 0xFFFF and ARROK polled, the counter started, CMP = 0 and CMPOK polled, with no limit on either wait;
//  * a new CMP is written only after the CMPOK of the one before: what is asked for meanwhile waits for that interrupt;
//  * CMP matches where the counter is greater, too, so for a tick beyond the end of the period 0xFFFF is written first.

#include "f767/lp_ticker.h"

#include "chip/cpu.h"
#include "f767/registers.h"
#include "lptim.h"

#define RCC_APB1RSTR (*(volatile uint32_t *)0x40023820u)
#define RCC_BDCR (*(volatile uint32_t *)0x40023870u)
#define RCC_DCKCFGR2 (*(volatile uint32_t *)0x40023890u)
#define RCC_BDCR_LSEON (1u << 0)
#define RCC_BDCR_LSERDY (1u << 1)
#define RCC_APB1_LPTIM1 (1u << 9)
#define RCC_DCKCFGR2_LPTIM1_LSE (3u << 24)
#define PWR_CR1_DBP (1u << 8)
#define LINE (1u << 23)

#define LAST 0xFFFFu // of a period
#define GUARD 5u     // so many ticks ahead a match is sure to be seen

enum { LPTIM1_IRQ = 93, VECTORS = 16 + IRQ_COUNT };

static void (*vectors[VECTORS])(void) __attribute__((aligned(512)));
static volatile bool started, fired, written = true, waits;
static volatile uint32_t wanted;

static uint32_t enter_critical(void)
{
    uint32_t before = READ_SPECIAL("primask");
    irq_disable();
    return before;
}

static void exit_critical(uint32_t before)
{
    if (!before)
        irq_enable();
}

static void clear_match(void)
{
    LPTIM1->ICR = LPTIM_CMPM;
    NVIC->ICPR[LPTIM1_IRQ / 32] = 1u << LPTIM1_IRQ % 32;
}

static void handle(void)
{
    uint32_t critical = enter_critical();
    if (fired) {
        fired = false;
        LPTIM1->ICR = LPTIM_CMPM;
        lp_ticker_irq_handler();
    }
    if (LPTIM1->ISR & LPTIM1->IER & LPTIM_CMPM) {
        LPTIM1->ICR = LPTIM_CMPM;
        lp_ticker_irq_handler();
    }
    if (LPTIM1->ISR & LPTIM1->IER & LPTIM_CMPOK) {
        LPTIM1->ICR = LPTIM_CMPOK;
        written = true;
        if (waits) {
            waits = false;
            lp_ticker_set_interrupt(wanted);
        }
    }
    EXTI->PR = LINE;
    exit_critical(critical);
}

static void start_crystal(void)
{
    RCC->APB1ENR |= RCC_APB1_PWR;
    PWR->CR1 |= PWR_CR1_DBP;
    while (!(PWR->CR1 & PWR_CR1_DBP)) {
    }
    RCC_BDCR |= RCC_BDCR_LSEON;
    while (!(RCC_BDCR & RCC_BDCR_LSERDY)) {
    }
}

static void set_vector(unsigned irq, void (*handler)(void))
{
    void (*const *from)(void) = (void (*const *)(void))SCB->VTOR;
    for (unsigned i = 0; i < VECTORS; ++i)
        vectors[i] = from[i];
    vectors[16 + irq] = handler;
    SCB->VTOR = (uint32_t)vectors;
    DSB();
}

void lp_ticker_init(void)
{
    if (started)
        return;
    started = true;
    start_crystal();
    RCC_DCKCFGR2 |= RCC_DCKCFGR2_LPTIM1_LSE;
    RCC->APB1ENR |= RCC_APB1_LPTIM1;
    RCC_APB1RSTR |= RCC_APB1_LPTIM1;
    RCC_APB1RSTR &= ~RCC_APB1_LPTIM1;
    LPTIM1->CFGR = 0;
    set_vector(LPTIM1_IRQ, handle);
    EXTI->IMR |= LINE;
    EXTI->RTSR |= LINE;
    LPTIM1->IER = LPTIM_CMPM | LPTIM_CMPOK;
    LPTIM1->CR |= LPTIM_ENABLE;
    LPTIM1->ICR = LPTIM_ARROK;
    LPTIM1->ARR = LAST;
    while (!(LPTIM1->ISR & LPTIM_ARROK)) {
    }
    LPTIM1->CR |= LPTIM_CNTSTRT;
    LPTIM1->ICR = LPTIM_CMPOK;
    LPTIM1->CMP = 0;
    while (!(LPTIM1->ISR & LPTIM_CMPOK)) {
    }
    LPTIM1->ICR = LPTIM_CMPOK;
}

uint32_t lp_ticker_read(void)
{
    uint32_t count = LPTIM1->CNT;
    for (uint32_t again; (again = LPTIM1->CNT) != count;) // it may be changing (RM0410, section 26.7.8)
        count = again;
    return count;
}

void lp_ticker_set_interrupt(uint32_t tick)
{
    uint32_t critical = enter_critical(), now = lp_ticker_read();
    wanted = tick;
    interrupt_enable(LPTIM1_IRQ, 0);
    if (!written) {
        waits = true;
    } else {
        clear_match();
        if (((tick - now) & LAST) < GUARD)
            tick = (tick + GUARD) & LAST;
        LPTIM1->CMP = tick < now && now <= LAST - GUARD ? LAST : tick;
        written = false;
    }
    exit_critical(critical);
}

void lp_ticker_fire_interrupt(void)
{
    uint32_t critical = enter_critical();
    fired = true;
    waits = false;
    NVIC->ISPR[LPTIM1_IRQ / 32] = 1u << LPTIM1_IRQ % 32;
    interrupt_enable(LPTIM1_IRQ, 0);
    exit_critical(critical);
}

bool lp_ticker_allows_stop(void) { return written; }
