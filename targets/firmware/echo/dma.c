// SPDX-License-Identifier: GPL-2.0-or-later
//
// USART1 (PA9, PA10), 921600 baud, sends back what it receives, by DMA both ways out of one circle: channel 5 writes round
// and round, channel 4 sends stretch after stretch of what is new. An interrupt comes with an idle line, with half a circle
// and with the end of a stretch. What was not sent before it is overwritten would be lost, but both ways run at one speed.

#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"

#define BAUD 921600u
#define CIRCLE_BYTES 4096u

static uint8_t circle[CIRCLE_BYTES];
static uint32_t sent;      // where in the circle the next stretch begins
static uint32_t in_flight; // length of the stretch that channel 4 is sending, 0 if it rests

static void send_stretch(void)
{
    uint32_t written = (CIRCLE_BYTES - DMA1_CHANNEL(DMA_USART1_RX)->CNDTR) % CIRCLE_BYTES;
    if (in_flight || written == sent)
        return;
    in_flight = (written > sent ? written : CIRCLE_BYTES) - sent;
    volatile dma_channel_t *channel = DMA1_CHANNEL(DMA_USART1_TX);
    channel->CCR = 0;
    channel->CMAR = (uint32_t)(uintptr_t)(circle + sent);
    channel->CNDTR = in_flight;
    channel->CCR = DMA_CCR_FROM_MEMORY | DMA_CCR_MINC | DMA_CCR_TCIE | DMA_CCR_EN;
}

void DMA1_Channel4_IRQHandler(void)
{
    DMA1->IFCR = DMA_GIF(DMA_USART1_TX);
    sent = (sent + in_flight) % CIRCLE_BYTES;
    in_flight = 0;
    send_stretch();
}

void DMA1_Channel5_IRQHandler(void)
{
    DMA1->IFCR = DMA_GIF(DMA_USART1_RX);
    send_stretch();
}

void USART1_IRQHandler(void)
{
    (void)USART1->SR;
    (void)USART1->DR; // clears IDLE; channel 5 has long taken the byte
    send_stretch();
}

int main(void)
{
    clock_72mhz();
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB2ENR |= RCC_APB2_GPIOA | RCC_APB2_USART1;
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_pull(GPIOA, 10, true);
    DMA1_CHANNEL(DMA_USART1_TX)->CPAR = (uint32_t)(uintptr_t)&USART1->DR;
    volatile dma_channel_t *receive = DMA1_CHANNEL(DMA_USART1_RX);
    receive->CPAR = (uint32_t)(uintptr_t)&USART1->DR;
    receive->CMAR = (uint32_t)(uintptr_t)circle;
    receive->CNDTR = CIRCLE_BYTES;
    receive->CCR = DMA_CCR_MINC | DMA_CCR_CIRC | DMA_CCR_HTIE | DMA_CCR_TCIE | DMA_CCR_EN;
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR3 = USART_CR3_DMAR | USART_CR3_DMAT;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | USART_CR1_IDLEIE;
    irq_line_enable(DMA1_CHANNEL1_IRQ + DMA_USART1_TX - 1);
    irq_line_enable(DMA1_CHANNEL1_IRQ + DMA_USART1_RX - 1);
    irq_line_enable(USART1_IRQ);
    for (;;)
        WFI();
}
