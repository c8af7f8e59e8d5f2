// SPDX-License-Identifier: GPL-2.0-or-later
//
// Reset and clock control (RM0008, section 7): oscillators and their flags, what is protected while it is in use, the way
// to 72 MHz, prescalers, clock gates, peripheral resets, the backup domain's protection.

#include "check.h"
#include "chip/stm32f103.h"
#include "clock.h"
#include "cycles.h"
#include "wait.h"

static uint32_t sysclk(void) { return (RCC->CFGR & RCC_CFGR_SWS) >> RCC_CFGR_SWS_SHIFT; }

static void select(uint32_t source) { RCC->CFGR = (RCC->CFGR & ~RCC_CFGR_SW) | source; }

static bool select_and_wait(uint32_t source)
{
    select(source);
    return wait_until(sysclk() == source);
}

// --- After reset (7.3)

static void after_reset(void)
{
    check_equal("cr-reset", RCC->CR & 0xFFFF00FF, 0x83); // HSI on, ready, trim 16; calibration is each chip's own
    check_equal("cfgr-reset", RCC->CFGR, 0);
    check_equal("cir-reset", RCC->CIR, 0);
    check_equal("ahbenr-reset", RCC->AHBENR, RCC_AHB_SRAM | RCC_AHB_FLITF);
    check_equal("apb2enr-reset", RCC->APB2ENR, 0);
    check_equal("apb1enr-reset", RCC->APB1ENR, 0);
    // Every reset of the chip pulls NRST low as well (7.1.1), so whatever happened, this one is set.
    check("csr-has-a-cause", RCC->CSR & RCC_CSR_PINRSTF);
    RCC->CSR |= RCC_CSR_RMVF;
    check_equal("rmvf-clears-causes", RCC->CSR & RCC_CSR_CAUSES, 0);
    RCC->CSR &= ~RCC_CSR_RMVF;
}

// --- Oscillators (7.2, 7.3.1, 7.3.3)

static void hse(void)
{
    RCC->CR |= RCC_CR_HSEON;
    check("hse-is-not-ready-at-once", !(RCC->CR & RCC_CR_HSERDY));
    check("hse-gets-ready", wait_until(RCC->CR & RCC_CR_HSERDY));
    check("hserdyf-needs-hserdyie", !(RCC->CIR & RCC_CIR_HSERDYF));
    RCC->CR &= ~RCC_CR_HSEON;
    check("hserdy-falls", wait_until(!(RCC->CR & RCC_CR_HSERDY)));

    RCC->CIR = RCC_CIR_HSERDYIE;
    RCC->CR |= RCC_CR_HSEON;
    check("hserdyf-rises", wait_until(RCC->CIR & RCC_CIR_HSERDYF));
    check("hserdy-with-its-flag", RCC->CR & RCC_CR_HSERDY);
    check("hserdyf-requests-interrupt", irq_is_pending(RCC_IRQ));
    RCC->CIR = RCC_CIR_HSERDYIE | RCC_CIR_HSERDYC;
    check("hserdyc-clears", !(RCC->CIR & RCC_CIR_HSERDYF));
    irq_unpend(RCC_IRQ);
    check("interrupt-gone-with-flag", !irq_is_pending(RCC_IRQ));
    RCC->CIR = 0;
}

static void hsi(void)
{
    RCC->CR &= ~RCC_CR_HSION;
    check("hsi-in-use-stays-on", RCC->CR & RCC_CR_HSION);
    check("to-hse", select_and_wait(SYSCLK_HSE));
    RCC->CR &= ~RCC_CR_HSION;
    check("hsi-goes-off", wait_until(!(RCC->CR & RCC_CR_HSIRDY)) && !(RCC->CR & RCC_CR_HSION));
    RCC->CR &= ~RCC_CR_HSEON;
    check("hse-in-use-stays-on", RCC->CR & RCC_CR_HSEON);
    RCC->CIR = RCC_CIR_HSIRDYIE;
    RCC->CR |= RCC_CR_HSION;
    check("hsirdyf-rises", wait_until(RCC->CIR & RCC_CIR_HSIRDYF));
    RCC->CIR = RCC_CIR_HSIRDYC;
    check("back-to-hsi", select_and_wait(SYSCLK_HSI));
    uint32_t cr = RCC->CR;
    RCC->CR = (cr & ~(0x1Fu << RCC_CR_HSITRIM_SHIFT)) | 5u << RCC_CR_HSITRIM_SHIFT;
    check_equal("hsitrim-is-kept", RCC->CR >> RCC_CR_HSITRIM_SHIFT & 0x1F, 5);
    RCC->CR = cr;
}

static void lsi(void)
{
    RCC->CIR = RCC_CIR_LSIRDYIE;
    RCC->CSR |= RCC_CSR_LSION;
    check("lsi-gets-ready", wait_until(RCC->CSR & RCC_CSR_LSIRDY));
    check("lsirdyf-rises", wait_until(RCC->CIR & RCC_CIR_LSIRDYF));
    RCC->CIR = RCC_CIR_LSIRDYC;
    RCC->CSR &= ~RCC_CSR_LSION;
    check("lsirdy-falls", wait_until(!(RCC->CSR & RCC_CSR_LSIRDY)));
    irq_unpend(RCC_IRQ);
}

// --- PLL and the switch (7.2.3, 7.2.6, 7.3.2)

#define PLL_9 (RCC_CFGR_PLLSRC | (9u - 2u) << RCC_CFGR_PLLMUL_SHIFT)

static void pll(void)
{
    FLASH->ACR = FLASH_ACR_PRFTBE | FLASH_ACR_LATENCY_2;
    RCC->CFGR = PLL_9 | APB_DIV2 << RCC_CFGR_PPRE1_SHIFT;
    RCC->CIR = RCC_CIR_PLLRDYIE;
    RCC->CR |= RCC_CR_PLLON;
    select(SYSCLK_PLL);
    bool early = sysclk() == SYSCLK_PLL && !(RCC->CR & RCC_CR_PLLRDY);
    check("switch-waits-for-pll", !early);
    check("pll-gets-ready", wait_until(RCC->CR & RCC_CR_PLLRDY));
    check("switch-follows-pll", wait_until(sysclk() == SYSCLK_PLL));
    check("pllrdyf-rises", RCC->CIR & RCC_CIR_PLLRDYF);
    RCC->CIR = RCC_CIR_PLLRDYC;
    check("pllrdyc-clears", !(RCC->CIR & RCC_CIR_PLLRDYF));
    irq_unpend(RCC_IRQ);
    check_equal("hclk-is-72-mhz", clock_hclk_hz(), 72000000);

    RCC->CR &= ~RCC_CR_PLLON;
    check("pll-in-use-stays-on", RCC->CR & RCC_CR_PLLON);
    RCC->CR &= ~RCC_CR_HSEON;
    check("hse-behind-pll-stays-on", RCC->CR & RCC_CR_HSEON);
    RCC->CFGR &= ~RCC_CFGR_PLLMUL; // "can be written only when PLL is disabled"
    check_equal("pllmul-is-fixed-while-on", RCC->CFGR & RCC_CFGR_PLLMUL, PLL_9 & RCC_CFGR_PLLMUL);

    check("back-to-hse", select_and_wait(SYSCLK_HSE));
    *bit_of(&RCC->CR, 24) = 0; // PLLON by its bit-band alias
    check("pll-goes-off", wait_until(!(RCC->CR & RCC_CR_PLLRDY)));
    RCC->CFGR &= ~RCC_CFGR_PLLMUL;
    check_equal("pllmul-is-free-while-off", RCC->CFGR & RCC_CFGR_PLLMUL, 0);
    RCC->CFGR |= PLL_9;
    *bit_of(&RCC->CR, 24) = 1;
    check("bit-band-turns-pll-on", wait_until(RCC->CR & RCC_CR_PLLRDY));
    check("to-pll-again", select_and_wait(SYSCLK_PLL));
}

// --- Prescalers: a timer gets its bus's clock, doubled if that is divided (7.2, figure 8)

// HCLK cycles in which TIM2 counts 1000.
static uint32_t tim2_thousand(void)
{
    TIM2->CR1 = 0;
    TIM2->CNT = 0;
    TIM2->CR1 = TIM_CR1_CEN;
    uint32_t start = cycles();
    while (TIM2->CNT < 1000) {
    }
    return cycles() - start;
}

static void prescalers(void)
{
    static const struct {
        const char *name;
        uint32_t ppre1, cycles_per_tick;
    } cases[] = {
        {"timer-clock-apb1-div1", APB_DIV1, 1}, {"timer-clock-apb1-div2", APB_DIV2, 1},
        {"timer-clock-apb1-div4", APB_DIV4, 2}, {"timer-clock-apb1-div8", APB_DIV8, 4},
        {"timer-clock-apb1-div16", APB_DIV16, 8},
    };
    select_and_wait(SYSCLK_HSE); // so that APB1 may run undivided
    RCC->APB1ENR |= RCC_APB1_TIM2;
    for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
        RCC->CFGR = (RCC->CFGR & ~RCC_CFGR_PPRE1) | cases[i].ppre1 << RCC_CFGR_PPRE1_SHIFT;
        uint32_t want = 1000 * cases[i].cycles_per_tick;
        check_range(cases[i].name, tim2_thousand(), want - 60, want + 120);
    }
    TIM2->CR1 = 0;
    RCC->CFGR = (RCC->CFGR & ~RCC_CFGR_PPRE1) | APB_DIV2 << RCC_CFGR_PPRE1_SHIFT;
    RCC->CFGR |= 0x9u << RCC_CFGR_HPRE_SHIFT; // divided by 4
    check_equal("hpre-is-kept", clock_hclk_hz(), 2000000);
    RCC->CFGR &= ~RCC_CFGR_HPRE;
    select_and_wait(SYSCLK_PLL);
}

// --- Clock gates and resets (7.3.4 to 7.3.8)

static void gates(void)
{
    RCC->APB1ENR &= ~RCC_APB1_TIM3;
    TIM3->ARR = 0x1234;
    check_equal("gated-reads-0", TIM3->ARR, 0);
    RCC->APB1ENR |= RCC_APB1_TIM3;
    check_equal("gated-write-is-lost", TIM3->ARR, 0xFFFF);
    TIM3->ARR = 0x1234;
    check_equal("open-gate-takes-write", TIM3->ARR, 0x1234);
    RCC->APB1ENR &= ~RCC_APB1_TIM3;
    RCC->APB1ENR |= RCC_APB1_TIM3;
    check_equal("gate-keeps-registers", TIM3->ARR, 0x1234);
    RCC->APB1RSTR = RCC_APB1_TIM3;
    RCC->APB1RSTR = 0;
    check_equal("peripheral-reset", TIM3->ARR, 0xFFFF);
    check("reset-keeps-gate", RCC->APB1ENR & RCC_APB1_TIM3);

    RCC->APB2ENR |= RCC_APB2_GPIOB;
    GPIOB->ODR = 0x0100;
    RCC->APB2RSTR = RCC_APB2_GPIOB;
    check_equal("held-in-reset", GPIOB->ODR, 0);
    RCC->APB2RSTR = 0;
    RCC->APB2ENR &= ~RCC_APB2_GPIOB;
}

// --- The backup domain's register needs PWR_CR.DBP (7.3.9, 5.1.2)

static void backup_domain(void)
{
    RCC->APB1ENR |= RCC_APB1_PWR | RCC_APB1_BKP;
    PWR->CR &= ~PWR_CR_DBP;
    uint32_t before = RCC->BDCR & RCC_BDCR_LSEON;
    RCC->BDCR ^= RCC_BDCR_LSEON;
    check_equal("bdcr-is-protected", RCC->BDCR & RCC_BDCR_LSEON, before);
    PWR->CR |= PWR_CR_DBP;
    RCC->BDCR |= RCC_BDCR_LSEON;
    check("dbp-lets-write", RCC->BDCR & RCC_BDCR_LSEON);
    RCC->BDCR |= RCC_BDCR_BDRST;
    check("bdrst-clears", !(RCC->BDCR & RCC_BDCR_LSEON));
    RCC->BDCR &= ~RCC_BDCR_BDRST;
    PWR->CR &= ~PWR_CR_DBP;
}

int main(void)
{
    after_reset();
    cycles_start();
    hse();
    hsi();
    lsi();
    pll();
    prescalers();
    gates();
    backup_domain();
    check_done();
}
