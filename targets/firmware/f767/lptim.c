// SPDX-License-Identifier: GPL-2.0-or-later
//
// LPTIM1 of the STM32F767 (RM0410, section 26): what all chips with the block have, then its own clocks and Stop mode. At
// 16 MHz, on HSI. Uses PD13 (OUT), PD12 (IN1), PE1 (IN2) and PE0 (ETR), to which nothing is attached on a Nucleo-144.

#include "chip/cpu.h"
#include "check.h"
#include "cycles.h"
#include "f767/registers.h"
#include "lptim.h"

#define RCC_APB1RSTR (*(volatile uint32_t *)0x40023820u)
#define RCC_CSR (*(volatile uint32_t *)0x40023874u)
#define RCC_DCKCFGR2 (*(volatile uint32_t *)0x40023890u)
#define RCC_CSR_LSION (1u << 0)
#define RCC_CSR_LSIRDY (1u << 1)
#define RCC_APB1_LPTIM1 (1u << 9)
#define ON_LSI (1u << 24)
#define ON_HSI (2u << 24)
#define PWR_CR1_LPDS (1u << 0)
#define LINE (1u << 23)
#define AF_LPTIM 3

enum { LPTIM1_IRQ = 93 };

void lptim_reset(void)
{
    RCC_APB1RSTR = RCC_APB1_LPTIM1;
    RCC_APB1RSTR = 0;
}

void lptim_pull(enum lptim_input input, bool high)
{
    static const struct {
        char port;
        uint8_t pin;
    } pins[] = {{'D', 12}, {'E', 1}, {'E', 0}};
    volatile gpio_t *port = GPIO(pins[input].port);
    unsigned pin = pins[input].pin;
    port->PUPDR = (port->PUPDR & ~(3u << 2 * pin)) | (high ? 1u : 2u) << 2 * pin;
}

bool lptim_out(void) { return pin_read('D', 13); }

bool lptim_pending(void) { return NVIC->ISPR[LPTIM1_IRQ / 32] >> LPTIM1_IRQ % 32 & 1u; }

void lptim_forget(void)
{
    NVIC->ICPR[LPTIM1_IRQ / 32] = 1u << LPTIM1_IRQ % 32;
    DSB();
}

// The rates of its clocks, against the core's cycles of HSI; LSI may be anything from 17 to 47 kHz (DS11532).
static void clocks(void)
{
    RCC_DCKCFGR2 = ON_HSI;
    lptim_reset();
    lptim_open(LPTIM1, LPTIM_CFGR_PRESC(7), 0, 0xFFFF, 0xFFFF);
    LPTIM1->CR = LPTIM_ENABLE | LPTIM_CNTSTRT;
    wait_cycles(1000);
    uint32_t from = LPTIM1->CNT;
    wait_cycles(128 * 100);
    check_range("HSI", LPTIM1->CNT - from, 98, 102);
    RCC_CSR |= RCC_CSR_LSION;
    while (!(RCC_CSR & RCC_CSR_LSIRDY)) {
    }
    RCC_DCKCFGR2 = ON_LSI;
    lptim_reset();
    lptim_open(LPTIM1, 0, 0, 0xFFFF, 0xFFFF);
    LPTIM1->CR = LPTIM_ENABLE | LPTIM_CNTSTRT;
    wait_cycles(5000);
    from = LPTIM1->CNT;
    wait_cycles(160000); // 10 ms
    check_range("LSI", LPTIM1->CNT - from, 169, 471);
    LPTIM1->ICR = LPTIM_ALL;
    LPTIM1->CMP = 0x8000;
    uint32_t start = cycles(), at_once = LPTIM1->ISR;
    while (!(LPTIM1->ISR & LPTIM_CMPOK) && cycles() - start < 100000) {
    }
    uint32_t took = cycles() - start;
    check_equal("CMPOK-takes-its-time", at_once & LPTIM_CMPOK, 0);
    check_range("of-the-slow-clock", took, 16000000 / 47000, 4 * 16000000 / 17000);
}

// Blips shorter than eight samples of the LSI do not count.
static void filter(void)
{
    lptim_pull(LPTIM_IN1, false);
    lptim_reset();
    lptim_open(LPTIM1, LPTIM_COUNTMODE | LPTIM_CKFLT_8, 0, 0xFFFF, 0xFFFF);
    LPTIM1->CR = LPTIM_ENABLE | LPTIM_CNTSTRT;
    wait_cycles(10000);
    for (uint32_t length = 1000; length <= 20000; length += 19000) {
        for (uint32_t i = 0; i < 3; ++i) {
            lptim_pull(LPTIM_IN1, true);
            wait_cycles(length);
            lptim_pull(LPTIM_IN1, false);
            wait_cycles(20000);
        }
        check_equal(length == 1000 ? "blips-do-not-count" : "pulses-do", LPTIM1->CNT, length == 1000 ? 0 : 3);
    }
}

static void stop(void)
{
    lptim_reset();
    lptim_open(LPTIM1, 0, LPTIM_CMPM, 0xFFFF, 200);
    lptim_forget();
    EXTI->PR = LINE;
    EXTI->RTSR |= LINE;
    EXTI->IMR |= LINE;
    irq_disable(); // what is pending ends the sleep all the same
    interrupt_enable(LPTIM1_IRQ, 4);
    PWR->CR1 |= PWR_CR1_LPDS;
    SCB->SCR |= SCR_SLEEPDEEP;
    uint32_t start = cycles();
    LPTIM1->CR = LPTIM_ENABLE | LPTIM_CNTSTRT;
    DSB();
    WFI();
    uint32_t awake = cycles() - start, count = LPTIM1->CNT;
    SCB->SCR &= ~SCR_SLEEPDEEP;
    check_equal("woken-by-its-line", EXTI->PR & LINE, LINE);
    check_equal("and-asks", lptim_pending(), 1);
    check_range("by-the-match", count, 201, 210);
    check_range("and-the-core-slept", awake, 0, 20000); // of about 100000 cycles
}

int main(void)
{
    DEMCR |= DEMCR_TRCENA;
    DWT_LAR = 0xC5ACCE55;
    cycles_start();
    RCC->AHB1ENR |= RCC_AHB1_GPIO('D') | RCC_AHB1_GPIO('E');
    RCC->APB1ENR |= RCC_APB1_LPTIM1 | RCC_APB1_PWR;
    (void)RCC->APB1ENR;
    pin_alternate('D', 12, AF_LPTIM);
    pin_alternate('D', 13, AF_LPTIM);
    pin_alternate('E', 0, AF_LPTIM);
    pin_alternate('E', 1, AF_LPTIM);
    lptim_check_block();
    clocks();
    filter();
    stop();
    check_done();
}
