// SPDX-License-Identifier: GPL-2.0-or-later
//
// Deep sleep on a Nucleo-F767ZI (RM0410, section 4.3): Stop mode until B1 is pushed, then Standby until it is pushed again,
// which is a reset. B1 is EXTI13 and WKUP4. USART3 (115200 8N1) says where the program is; a word in backup SRAM counts how
// often it came out of Standby.

#include <stdint.h>

#include "chip/cpu.h"
#include "f767/clock.h"
#include "f767/handlers.h"
#include "f767/registers.h"

#define BAUD 115200u
#define B1 13u
#define WKUP4 (1u << 3)

#define PWR_CR2 (*(volatile uint32_t *)0x40007008u)
#define PWR_CSR2 (*(volatile uint32_t *)0x4000700Cu)
#define PWR_CR1_LPDS (1u << 0)
#define PWR_CR1_PDDS (1u << 1)
#define PWR_CR1_CSBF (1u << 3)
#define PWR_CR1_DBP (1u << 8)
#define PWR_CSR1_SBF (1u << 1)
#define RCC_CSR (*(volatile uint32_t *)0x40023874u)
#define RCC_CSR_RMVF (1u << 24)
#define RCC_AHB1_BKPSRAM (1u << 18)
#define WAKE_UPS (*(volatile uint32_t *)0x40024000u)

void EXTI15_10_IRQHandler(void) { EXTI->PR = 1u << B1; }

static void start_usart(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('D');
    RCC->APB1ENR |= RCC_APB1_USART3;
    pin_alternate('D', 8, 7);
    USART3->BRR = (PCLK1_HZ + BAUD / 2) / BAUD;
    USART3->CR1 = USART_CR1_UE | USART_CR1_TE;
}

static void say(const char *text)
{
    for (; *text; ++text) {
        while (!(USART3->ISR & USART_ISR_TXE)) {
        }
        USART3->TDR = (uint8_t)*text;
    }
    while (!(USART3->ISR & 1u << 6)) { // TC: nothing may be under way when the clock stops
    }
}

static void sleep_deeply(uint32_t mode)
{
    PWR->CR1 = (PWR->CR1 & ~(PWR_CR1_LPDS | PWR_CR1_PDDS)) | mode;
    SCB->SCR |= SCR_SLEEPDEEP;
    DSB();
    WFI();
    SCB->SCR &= ~SCR_SLEEPDEEP;
}

static void stop_until_button(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('C');
    RCC->APB2ENR |= RCC_APB2_SYSCFG;
    SYSCFG_EXTICR[B1 / 4] = (uint32_t)('C' - 'A') << B1 % 4 * 4;
    EXTI->RTSR |= 1u << B1;
    EXTI->IMR |= 1u << B1;
    interrupt_enable(EXTI15_10_IRQ, 4);
    sleep_deeply(PWR_CR1_LPDS);
}

static void standby_until_button(void)
{
    PWR_CSR2 = WKUP4 << 8;
    PWR_CR2 = WKUP4; // clears the flag
    sleep_deeply(PWR_CR1_PDDS);
}

int main(void)
{
    clock_start();
    start_usart();
    RCC->AHB1ENR |= RCC_AHB1_BKPSRAM;
    PWR->CR1 |= PWR_CR1_DBP;
    if (PWR->CSR1 & PWR_CSR1_SBF) {
        PWR->CR1 |= PWR_CR1_CSBF;
        ++WAKE_UPS;
        say(RCC_CSR >> 24 == 0x0C ? "reset by WKUP4\r\n" : "reset by something else\r\n");
    }
    RCC_CSR |= RCC_CSR_RMVF;
    if (WAKE_UPS >= 2) {
        say("enough\r\n");
        for (;;)
            WFI();
    }
    say("Stop\r\n");
    stop_until_button();
    uint32_t clock = RCC->CFGR & RCC_CFGR_SWS, over_drive = PWR->CSR1 & PWR_CSR1_ODSWRDY;
    clock_start();
    say(clock || over_drive ? "awake, and fast\r\n" : "awake on HSI\r\n");
    say("Standby\r\n");
    standby_until_button();
    say("no Standby\r\n");
    for (;;) {
    }
}
