// SPDX-License-Identifier: GPL-2.0-or-later
//
// DMA behind its multiplexer (RM0433, sections 15 and 17): which request reaches which stream, both controllers from memory
// to memory, what they do not reach, a USART with FIFOs that is served both ways. Uses USART2 at PD5, to which nothing is
// attached on a Nucleo-144.

#include "check.h"
#include "h753/blocks.h"
#include "h753/clock.h"
#include "h753/handlers.h"

#define DIVIDER 130u // 923077 baud at 120 MHz
#define BIT (4 * DIVIDER)
#define AXI_RAM ((volatile uint8_t *)0x24000000u)
#define D2_RAM ((volatile uint8_t *)0x30000000u)
#define D3_RAM ((volatile uint8_t *)0x38000000u)

enum { TX = 5, AF_USART2 = 7 };

static volatile uint32_t in_dtcm[4] = {1, 2, 3, 4};
static volatile uint32_t interrupts;

void DMA2_Stream0_IRQHandler(void)
{
    ++interrupts;
    DMA2->LIFCR = DMA_ALL;
}

static void start(volatile stream_t *stream, uint32_t control, const volatile void *peripheral, volatile void *memory,
                  uint32_t count)
{
    stream->CR = 0;
    while (stream->CR & DMA_EN) {
    }
    stream->PAR = (uint32_t)peripheral;
    stream->M0AR = (uint32_t)memory;
    stream->NDTR = count;
    stream->CR = control;
    stream->CR = control | DMA_EN;
}

static void registers(void)
{
    check_equal("no-request", DMAMUX1[0], 0);
    DMA1->S[3].CR = 0xFFFFFFFE;
    check_equal("TRBUFF-and-no-CHSEL", DMA1->S[3].CR, 0x01FFFFFE);
    DMA1->S[3].CR = 0;
    DMAMUX1[3] = REQUEST_TIM6_UP;
    check_equal("DMAREQ_ID", DMAMUX1[3], REQUEST_TIM6_UP);
    DMAMUX1[3] = 0;
}

static void between(const char *name, volatile dma_t *dma, volatile uint8_t *from, volatile uint8_t *to)
{
    for (uint32_t index = 0; index < 64; ++index) {
        from[index] = (uint8_t)(index * 7u + 1u);
        to[index] = 0;
    }
    DSB();
    dma->LIFCR = DMA_ALL;
    start(&dma->S[0], DMA_BETWEEN | DMA_PINC | DMA_MINC | DMA_WORDS, from, to, 16);
    wait_cycles(2000);
    uint32_t same = 0;
    for (uint32_t index = 0; index < 64; ++index)
        same += to[index] == (uint8_t)(index * 7u + 1u);
    check_equal(name, same | dma->LISR << 8, 64u | (DMA_TCIF | DMA_HTIF) << 8);
}

static void memories(void)
{
    between("dma1-axi-to-d2", DMA1, AXI_RAM, D2_RAM);
    between("dma2-d2-to-d3", DMA2, D2_RAM, D3_RAM);
    between("dma2-d3-to-axi", DMA2, D3_RAM, AXI_RAM + 128);
    DMA1->LIFCR = DMA_ALL;
    start(&DMA1->S[0], DMA_BETWEEN | DMA_PINC | DMA_MINC | DMA_WORDS, in_dtcm, AXI_RAM, 4);
    wait_cycles(1000);
    check_equal("dtcm-is-out-of-reach", DMA1->LISR & (DMA_TEIF | DMA_TCIF), DMA_TEIF);
    check_equal("and-disables-the-stream", DMA1->S[0].CR & DMA_EN, 0);
    DMA2->LIFCR = DMA_ALL;
    interrupt_enable(DMA2_S0_IRQ, 3);
    start(&DMA2->S[0], DMA_BETWEEN | DMA_MINC | DMA_TEIE, D2_RAM, in_dtcm, 4);
    wait_cycles(1000);
    check_equal("error-interrupt", interrupts, 1);
    check_equal("dtcm-is-as-it-was", in_dtcm[0], 1);
}

static void choices(void)
{
    volatile uint32_t *to = (volatile uint32_t *)D2_RAM;
    to[0] = to[1] = 0;
    TIM6->ARR = 99;
    TIM6->DIER = 1u << 8; // UDE
    DMAMUX1[8 + 5] = REQUEST_USART2_RX;
    start(&DMA2->S[5], DMA_MINC | DMA_WORDS, &TIM6->ARR, to, 2);
    TIM6->EGR = 1;
    wait_cycles(500);
    check_equal("another-request-is-not-heard", DMA2->S[5].NDTR, 2);
    DMAMUX1[8 + 5] = REQUEST_TIM6_UP;
    TIM6->EGR = 1;
    wait_cycles(500);
    check_range("the-chosen-one-is", DMA2->S[5].NDTR, 0, 1);
    check_equal("what-it-moves", to[0], 99);
    DMA2->S[5].CR = 0;
    DMAMUX1[8 + 5] = 0;
    TIM6->DIER = 0;
}

static void both_ways(void)
{
    USART2->CR1 = 0;
    USART2->CR3 = CR3_HDSEL | CR3_DMAR | CR3_DMAT;
    USART2->BRR = DIVIDER;
    USART2->CR1 = CR1_FIFOEN;
    USART2->CR1 = CR1_FIFOEN | USART_CR1_UE | USART_CR1_RE;
    for (uint32_t index = 0; index < 40; ++index) {
        AXI_RAM[index] = (uint8_t)(200 - index);
        D2_RAM[index] = 0;
    }
    DSB();
    DMA2->LIFCR = DMA_ALL << 6 | DMA_ALL << 16;
    DMAMUX1[8 + 1] = REQUEST_USART2_RX;
    DMAMUX1[8 + 2] = REQUEST_USART2_TX;
    start(&DMA2->S[1], DMA_MINC | DMA_CIRC | DMA_TRBUFF, &USART2->RDR, D2_RAM, 32);
    start(&DMA2->S[2], DMA_MINC | DMA_TO_PERIPHERAL | DMA_TRBUFF, &USART2->TDR, AXI_RAM, 40);
    USART2->ICR = 1u << 6;
    USART2->CR1 |= USART_CR1_TE;
    wait_cycles(14 * BIT + 10 * BIT);
    uint32_t waiting = DMA2->S[2].NDTR;
    wait_cycles(40 * 10 * BIT);
    uint32_t same = 0;
    for (uint32_t index = 0; index < 32; ++index)
        same += D2_RAM[index] == (uint8_t)(200 - (index < 8 ? index + 32 : index));
    check_range("the-fifo-is-filled", waiting, 20, 22);
    check_equal("all-came-round", same, 32);
    check_equal("where-the-circle-stands", DMA2->S[1].NDTR, 24);
    check_equal("sent", DMA2->LISR >> 16 & DMA_TCIF, DMA_TCIF);
    check_equal("TC", USART2->ISR & USART_ISR_TC, USART_ISR_TC);
    check_equal("no-overrun", USART2->ISR & USART_ISR_ORE, 0);
}

int main(void)
{
    counter_start();
    clock_start();
    RCC->AHB1ENR |= RCC_AHB1_DMA1 | RCC_AHB1_DMA2;
    RCC->AHB2ENR |= 7u << 29; // SRAM1 to SRAM3
    RCC->AHB4ENR |= RCC_AHB4_GPIO('D');
    RCC->APB1LENR |= RCC_APB1L_USART2 | RCC_APB1L_TIM6;
    (void)RCC->APB1LENR;
    pin_alternate('D', TX, AF_USART2);
    registers();
    memories();
    choices();
    both_ways();
    check_done();
}
