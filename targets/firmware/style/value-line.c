// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: a vendor's peripheral library, on an STM32VLDISCOVERY, a board with an STM32F100RB. The start-up makes
// 24 MHz of the crystal by a divider before the PLL. TIM16 interrupts each 10 ms and toggles LD4 (PC8) each 50 ms; TIM15
// makes a PWM of 1 kHz and a quarter on PA2; TIM6 and DMA1 channel 3 play a staircase of four levels on PA4; LD3 (PC9) shows the
// button (PA0). USART1 (PA9, PA10), 115200 8N1: a banner, then what comes in goes back.

#include "f103e/handlers.h"
#include "f103e/registers.h"
#include "pin.h"

#define RCC_CFGR2 (*(volatile uint32_t *)0x4002102Cu)
#define TIM15 ((volatile tim_t *)0x40014000u)
#define TIM16 ((volatile tim_t *)0x40014400u)
#define RCC_APB2_TIM15 (1u << 16)
#define RCC_APB2_TIM16 (1u << 17)

#define MHZ 24u
#define LD4 8
#define LD3 9
#define USER 0

static const uint16_t stairs[4] = {0, 1365, 2730, 4095};

static void set_clock_to_24(void)
{
    RCC->CR |= RCC_CR_HSEON;
    while (!(RCC->CR & RCC_CR_HSERDY)) {
    }
    RCC->CFGR &= ~(RCC_CFGR_PLLSRC | RCC_CFGR_PLLXTPRE | RCC_CFGR_PLLMUL);
    RCC_CFGR2 = 1; // HSE / 2
    RCC->CFGR |= RCC_CFGR_PLLSRC | RCC_CFGR_PLLXTPRE | (6u - 2u) << RCC_CFGR_PLLMUL_SHIFT;
    RCC->CR |= RCC_CR_PLLON;
    while (!(RCC->CR & RCC_CR_PLLRDY)) {
    }
    RCC->CFGR = (RCC->CFGR & ~RCC_CFGR_SW) | SYSCLK_PLL;
    while ((RCC->CFGR & RCC_CFGR_SWS) != SYSCLK_PLL << RCC_CFGR_SWS_SHIFT) {
    }
}

// Its handler is that of TIM1's update, whose place in the table it shares
void TIM1_UP_IRQHandler(void)
{
    static uint32_t ticks;
    TIM16->SR = ~TIM_UIF;
    if (++ticks % 5 == 0)
        pin_toggle(GPIOC, LD4);
}

static void start_timers(void)
{
    TIM16->PSC = MHZ - 1;
    TIM16->ARR = 10000 - 1;
    TIM16->EGR = TIM_EGR_UG;
    TIM16->SR = 0;
    TIM16->DIER = TIM_UIF;
    irq_line_enable(TIM1_UP_IRQ);
    TIM16->CR1 = TIM_CR1_CEN;

    pin_mode(GPIOA, 2, PIN_ALTERNATE);
    TIM15->PSC = MHZ - 1;
    TIM15->ARR = 1000 - 1;
    TIM15->CCR[0] = 250;
    TIM15->CCMR1 = TIM_OC_PWM1 | TIM_OC_PRELOAD;
    TIM15->CCER = TIM_CCER_E(1);
    TIM15->BDTR = TIM_BDTR_MOE;
    TIM15->EGR = TIM_EGR_UG;
    TIM15->CR1 = TIM_CR1_CEN;
}

static void start_stairs(void)
{
    pin_mode(GPIOA, 4, PIN_ANALOG);
    volatile dma_channel_t *dma = DMA1_CHANNEL(3);
    dma->CPAR = (uint32_t)(uintptr_t)&DAC->DHR12R1;
    dma->CMAR = (uint32_t)(uintptr_t)stairs;
    dma->CNDTR = 4;
    dma->CCR = DMA_CCR_FROM_MEMORY | DMA_CCR_MINC | DMA_CCR_CIRC | 1u << DMA_CCR_PSIZE_SHIFT | 1u << DMA_CCR_MSIZE_SHIFT |
               DMA_CCR_EN;
    DAC->CR = DAC_CR_EN | DAC_CR_TEN | DAC_TIM6 << DAC_CR_TSEL_SHIFT | DAC_CR_DMAEN;
    TIM6->PSC = MHZ - 1;
    TIM6->ARR = 500 - 1;
    TIM6->CR2 = TIM_TRGO_UPDATE << TIM_CR2_MMS_SHIFT;
    TIM6->CR1 = TIM_CR1_CEN;
}

static void say(const char *text)
{
    for (; *text; ++text) {
        while (!(USART1->SR & USART_SR_TXE)) {
        }
        USART1->DR = (uint8_t)*text;
    }
}

int main(void)
{
    set_clock_to_24();
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB1ENR |= RCC_APB1_TIM6 | RCC_APB1_DAC;
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOC | RCC_APB2_USART1 | RCC_APB2_TIM15 | RCC_APB2_TIM16;
    pin_mode(GPIOC, LD3, PIN_OUTPUT);
    pin_mode(GPIOC, LD4, PIN_OUTPUT);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    USART1->BRR = MHZ * 1000000u / 115200u;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE;
    start_timers();
    start_stairs();
    say("style-value-line at 24 MHz\r\n");
    for (;;) {
        pin_write(GPIOC, LD3, pin_read(GPIOA, USER));
        if (USART1->SR & USART_SR_RXNE)
            USART1->DR = USART1->DR;
    }
}
