// SPDX-License-Identifier: GPL-2.0-or-later
//
// Deep sleep on a Nucleo-H753ZI (RM0433, section 6.7): Stop mode until B1 is pushed, then Standby until it is pushed again,
// which is a reset. B1 is EXTI13 and WKUP4. USART3 (115200 8N1) says where the program is; a word in backup SRAM counts how
// often it came out of Standby.

#include <stdint.h>

#include "chip/cpu.h"
#include "h753/clock.h"
#include "h753/handlers.h"
#include "h753/registers.h"

#define BAUD 115200u
#define B1 13u
#define WKUP4 (1u << 3)

#define PWR_CPUCR_PDDS 7u
#define PWR_CPUCR_SBF (1u << 6)
#define PWR_CPUCR_CSSF (1u << 9)
#define RCC_RSR_RMVF (1u << 16)
#define RCC_RSR_PORRSTF (1u << 23)
#define WAKE_UPS (*(volatile uint32_t *)0x38800000u)

void EXTI15_10_IRQHandler(void) { EXTI->CPUPR1 = 1u << B1; }

static void start_usart(void)
{
    RCC->AHB4ENR |= RCC_AHB4_GPIO('D');
    RCC->APB1LENR |= RCC_APB1L_USART3;
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
    while (!(USART3->ISR & USART_ISR_TC)) { // nothing may be under way when the clock stops
    }
}

static void sleep_deeply(uint32_t mode)
{
    PWR->CPUCR = (PWR->CPUCR & ~PWR_CPUCR_PDDS) | mode;
    SCB->SCR |= SCR_SLEEPDEEP;
    DSB();
    WFI();
    SCB->SCR &= ~SCR_SLEEPDEEP;
}

static void stop_until_button(void)
{
    RCC->AHB4ENR |= RCC_AHB4_GPIO('C');
    pin_mode('C', B1, PIN_INPUT);
    SYSCFG_EXTICR[B1 / 4] = (uint32_t)('C' - 'A') << B1 % 4 * 4;
    EXTI->RTSR1 |= 1u << B1;
    EXTI->CPUIMR1 |= 1u << B1;
    interrupt_enable(EXTI15_10_IRQ, 4);
    sleep_deeply(0);
}

static void standby_until_button(void)
{
    PWR->WKUPEPR = WKUP4;
    PWR->WKUPCR = WKUP4;
    sleep_deeply(PWR_CPUCR_PDDS);
}

int main(void)
{
    clock_start();
    start_usart();
    RCC->AHB4ENR |= RCC_AHB4_BKPSRAM;
    PWR->CR1 |= PWR_CR1_DBP;
    if (PWR->CPUCR & PWR_CPUCR_SBF) {
        PWR->CPUCR |= PWR_CPUCR_CSSF;
        ++WAKE_UPS;
        say(RCC->RSR & RCC_RSR_PORRSTF ? "reset by the supply\r\n" : "reset by WKUP4\r\n");
    }
    RCC->RSR = RCC_RSR_RMVF;
    if (WAKE_UPS >= 2) {
        say("enough\r\n");
        for (;;)
            WFI();
    }
    say("Stop\r\n");
    stop_until_button();
    uint32_t clock = RCC->CFGR & RCC_CFGR_SWS;
    clock_start();
    say(clock ? "awake, and fast\r\n" : "awake on HSI\r\n");
    say("Standby\r\n");
    standby_until_button();
    say("no Standby\r\n");
    for (;;) {
    }
}
