// SPDX-License-Identifier: GPL-2.0-or-later
//
// The low-power timers of the STM32H753 (RM0433, section 43): what all chips with the block have, then what the H7 adds, the
// clocks, one timer that starts another, and Stop mode. At 64 MHz, on HSI. Uses PD13 (OUT), PD12 (IN1), PE1 (IN2) and PE0
// (ETR), to which nothing is attached on a Nucleo-144.

#include "chip/cpu.h"
#include "check.h"
#include "cycles.h"
#include "h753/registers.h"
#include "lptim.h"

#define RCC_CSR_LSION (1u << 0)
#define RCC_CSR_LSIRDY (1u << 1)
#define RCC_APB1L_LPTIM1 (1u << 9)
#define RCC_APB4_LPTIM(number) (1u << ((number) + 7)) // 2 to 5
#define D2_LPTIM1_ON_LSI (4u << 28)
#define D3_LPTIM_ON_LSI (4u << 10 | 4u << 13)
#define EXTI_RTSR2 (*(volatile uint32_t *)0x58000020u)
#define EXTI_CPUIMR2 (*(volatile uint32_t *)0x58000090u)
#define EXTI_CPUPR2 (*(volatile uint32_t *)0x58000098u)
#define LPTIM2_OUTPUT (1u << 17) // of line 49
#define LPTIM1_WAKES (1u << 15)  // line 47
#define AF_LPTIM 1

#define LPTIM2 ((volatile lptim_t *)0x58002400u)
#define LPTIM3 ((volatile lptim_t *)0x58002800u)
#define LPTIM4 ((volatile lptim_t *)0x58002C00u)
#define LPTIM5 ((volatile lptim_t *)0x58003000u)

enum { LPTIM1_IRQ = 93 };

void lptim_reset(void)
{
    RCC->APB1LRSTR = RCC_APB1L_LPTIM1;
    RCC->APB1LRSTR = 0;
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

static void what_the_h7_adds(void)
{
    lptim_reset();
    LPTIM1->CFGR2 = 0x11;
    check_equal("CFGR2", LPTIM1->CFGR2, 0x11);
    LPTIM1->CFGR2 = 0;
    lptim_open(LPTIM1, LPTIM_CFGR_PRESC(7), 0, 0xFFFF, 0xFFFF);
    LPTIM1->CR = LPTIM_ENABLE | LPTIM_CNTSTRT;
    wait_cycles(128 * 100);
    uint32_t before = LPTIM1->CNT;
    LPTIM1->CR = LPTIM_ENABLE | LPTIM_COUNTRST;
    uint32_t start = cycles();
    while (LPTIM1->CR & LPTIM_COUNTRST && cycles() - start < 100000) {
    }
    uint32_t after = LPTIM1->CNT, done = LPTIM1->CR;
    LPTIM1->CR = LPTIM_ENABLE | LPTIM_RSTARE;
    wait_cycles(128 * 20);
    uint32_t first = LPTIM1->CNT, second = LPTIM1->CNT;
    check_range("before-COUNTRST", before, 90, 110);
    check_range("after-COUNTRST", after, 0, 2);
    check_equal("which-has-gone", done, LPTIM_ENABLE);
    check_range("a-read", first, 18, 25);
    check_range("clears-with-RSTARE", second, 0, 1);
}

// Those in D3 on PCLK4, which is HCLK: the output of LPTIM2 starts LPTIM3 and is an edge for EXTI.
static void one_starts_another(void)
{
    RCC->APB4ENR |= RCC_APB4_LPTIM(2) | RCC_APB4_LPTIM(3) | RCC_APB4_LPTIM(4) | RCC_APB4_LPTIM(5);
    (void)RCC->APB4ENR;
    EXTI_RTSR2 |= LPTIM2_OUTPUT;
    EXTI_CPUIMR2 |= LPTIM2_OUTPUT;
    lptim_open(LPTIM3, LPTIM_TRIGEN_RISING, 0, 0xFFFF, 0xFFFF);
    LPTIM3->CR = LPTIM_ENABLE | LPTIM_SNGSTRT;
    lptim_open(LPTIM2, 0, 0, 0xFFFF, 2000);
    wait_cycles(1000);
    uint32_t before = LPTIM3->CNT, edge = EXTI_CPUPR2 & LPTIM2_OUTPUT;
    LPTIM2->CR = LPTIM_ENABLE | LPTIM_SNGSTRT;
    wait_cycles(4000);
    uint32_t two = LPTIM2->CNT, three = LPTIM3->CNT;
    check_equal("LPTIM3-waits", before, 0);
    check_equal("no-edge-yet", edge, 0);
    check_range("LPTIM2-is-ahead", two - three, 1950, 2050);
    check_equal("it-was-a-trigger", LPTIM3->ISR, LPTIM_EXTTRIG);
    check_equal("and-an-edge", EXTI_CPUPR2 & LPTIM2_OUTPUT, LPTIM2_OUTPUT);
    EXTI_RTSR2 &= ~LPTIM2_OUTPUT;
    EXTI_CPUPR2 = LPTIM2_OUTPUT;
    LPTIM2->CR = 0;
    LPTIM3->CR = 0;
    LPTIM4->CFGR = LPTIM_ENC | LPTIM_PRELOAD;
    check_equal("LPTIM4-has-no-encoder", LPTIM4->CFGR, LPTIM_PRELOAD);
}

// LSI may be anything from 31 to 33 kHz (DS12117); the four of D3 have two choices of clock between them.
static void slow_clocks(void)
{
    RCC->CSR |= RCC_CSR_LSION;
    while (!(RCC->CSR & RCC_CSR_LSIRDY)) {
    }
    RCC->D2CCIP2R = D2_LPTIM1_ON_LSI;
    RCC->D3CCIPR = D3_LPTIM_ON_LSI;
    lptim_reset();
    volatile lptim_t *const timers[] = {LPTIM1, LPTIM2, LPTIM5};
    for (uint32_t i = 0; i < 3; ++i) {
        static const char *const names[] = {"LPTIM1-on-LSI", "LPTIM2-on-LSI", "LPTIM5-on-LSI"};
        lptim_open(timers[i], 0, 0, 0xFFFF, 0xFFFF);
        timers[i]->CR = LPTIM_ENABLE | LPTIM_CNTSTRT;
        wait_cycles(64 * 200);
        uint32_t from = timers[i]->CNT;
        wait_cycles(64 * 5000);
        check_range(names[i], timers[i]->CNT - from, 150, 170);
    }
    LPTIM1->ICR = LPTIM_ALL;
    LPTIM1->CMP = 0x8000;
    uint32_t start = cycles(), at_once = LPTIM1->ISR;
    while (!(LPTIM1->ISR & LPTIM_CMPOK) && cycles() - start < 1000000) {
    }
    uint32_t took = cycles() - start;
    check_equal("CMPOK-takes-its-time", at_once & LPTIM_CMPOK, 0);
    check_range("of-the-slow-clock", took, 64000000 / 33000, 4 * 64000000 / 31000);
}

static void stop(void)
{
    lptim_reset();
    lptim_open(LPTIM1, 0, LPTIM_CMPM, 0xFFFF, 200);
    lptim_forget();
    EXTI_CPUIMR2 |= LPTIM1_WAKES;
    irq_disable(); // what is pending ends the sleep all the same
    interrupt_enable(LPTIM1_IRQ, 4);
    SCB->SCR |= SCR_SLEEPDEEP;
    uint32_t start = cycles();
    LPTIM1->CR = LPTIM_ENABLE | LPTIM_CNTSTRT;
    DSB();
    WFI();
    uint32_t awake = cycles() - start, count = LPTIM1->CNT;
    SCB->SCR &= ~SCR_SLEEPDEEP;
    check_equal("woken-and-asked", lptim_pending(), 1);
    check_range("by-the-match", count, 201, 210);
    check_range("and-the-core-slept", awake, 0, 80000); // of about 400000 cycles
}

int main(void)
{
    DEMCR |= DEMCR_TRCENA;
    DWT_LAR = 0xC5ACCE55;
    cycles_start();
    PWR->CR3 = (PWR->CR3 & ~PWR_CR3_SCUEN) | PWR_CR3_LDOEN; // without it no voltage is ready, and no Stop
    RCC->AHB4ENR |= RCC_AHB4_GPIO('D') | RCC_AHB4_GPIO('E');
    RCC->APB1LENR |= RCC_APB1L_LPTIM1;
    (void)RCC->APB1LENR;
    pin_alternate('D', 12, AF_LPTIM);
    pin_alternate('D', 13, AF_LPTIM);
    pin_alternate('E', 0, AF_LPTIM);
    pin_alternate('E', 1, AF_LPTIM);
    lptim_check_block();
    what_the_h7_adds();
    one_starts_another();
    slow_clocks();
    stop();
    check_done();
}
