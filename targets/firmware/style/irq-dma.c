// SPDX-License-Identifier: GPL-2.0-or-later
//
// In the style of: interrupt and DMA drivers. USART1 (PA9, PA10), 115200 8N1, receives by DMA into a circle and hears of it
// by IDLE, half and full interrupts; what it sends goes through a ring by TXE interrupts. TIM2 interrupts each 10 ms and
// toggles PB1; a button on PA0 (pulled up, pressed to ground) interrupts through EXTI. The main loop sleeps.
//
// Lines that it understands: "count" (answers bytes, 10 ms ticks and presses), "led" (toggles PC13); any other is sent
// back with "? " before it.

#include "chip/stm32f103.h"
#include "clock.h"
#include "handlers.h"
#include "pin.h"
#include "ring.h"
#include "text.h"

#define BAUD 115200u
#define LED 13
#define BUTTON 0
#define BEAT 1
#define CIRCLE_BYTES 64u

static struct ring outgoing, incoming;
static uint8_t circle[CIRCLE_BYTES];
static volatile uint32_t bytes_in, beats, presses;

// --- Sending: the interrupt takes from the ring and switches itself off when that is empty

static void send_text(const char *text)
{
    for (; *text; ++text) {
        while (!ring_put(&outgoing, (uint8_t)*text)) {
        }
        USART1->CR1 |= USART_CR1_TXEIE;
    }
}

static void send_next(void)
{
    uint8_t byte;
    if (ring_get(&outgoing, &byte))
        USART1->DR = byte;
    else
        USART1->CR1 &= ~USART_CR1_TXEIE;
}

// --- Receiving: whoever interrupts, what is new in the circle is moved on

static void take_from_circle(void)
{
    static uint32_t taken;
    uint32_t written = CIRCLE_BYTES - DMA1_CHANNEL(DMA_USART1_RX)->CNDTR;
    for (; taken != written; taken = (taken + 1) % CIRCLE_BYTES) {
        ring_put(&incoming, circle[taken]);
        ++bytes_in;
    }
}

void USART1_IRQHandler(void)
{
    uint32_t status = USART1->SR;
    if (status & USART_SR_IDLE) {
        (void)USART1->DR; // after the read of SR this clears IDLE
        take_from_circle();
    }
    if (status & USART_SR_TXE && USART1->CR1 & USART_CR1_TXEIE)
        send_next();
}

void DMA1_Channel5_IRQHandler(void)
{
    DMA1->IFCR = DMA_GIF(DMA_USART1_RX);
    take_from_circle();
}

void TIM2_IRQHandler(void)
{
    TIM2->SR = ~TIM_UIF;
    ++beats;
    pin_toggle(GPIOB, BEAT);
}

void EXTI0_IRQHandler(void)
{
    EXTI->PR = 1u << BUTTON;
    ++presses;
}

static void set_up_pins(void)
{
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_GPIOC;
    pin_write(GPIOC, LED, true);
    pin_mode(GPIOC, LED, PIN_OUTPUT);
    pin_mode(GPIOB, BEAT, PIN_OUTPUT);
    pin_mode(GPIOA, 9, PIN_ALTERNATE);
    pin_pull(GPIOA, 10, true);
    pin_pull(GPIOA, BUTTON, true);
    EXTI->FTSR = 1u << BUTTON;
    EXTI->IMR = 1u << BUTTON;
}

static void set_up_serial(void)
{
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB2ENR |= RCC_APB2_USART1;
    volatile dma_channel_t *channel = DMA1_CHANNEL(DMA_USART1_RX);
    channel->CPAR = (uint32_t)(uintptr_t)&USART1->DR;
    channel->CMAR = (uint32_t)(uintptr_t)circle;
    channel->CNDTR = CIRCLE_BYTES;
    channel->CCR = DMA_CCR_MINC | DMA_CCR_CIRC | DMA_CCR_HTIE | DMA_CCR_TCIE | DMA_CCR_EN;
    USART1->BRR = (clock_pclk2_hz() + BAUD / 2) / BAUD;
    USART1->CR3 = USART_CR3_DMAR;
    USART1->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE | USART_CR1_IDLEIE;
}

static void set_up_timer(void)
{
    RCC->APB1ENR |= RCC_APB1_TIM2;
    TIM2->PSC = 7200 - 1; // 10 kHz
    TIM2->ARR = 100 - 1;
    TIM2->EGR = TIM_EGR_UG;
    TIM2->SR = 0;
    TIM2->DIER = TIM_UIF;
    TIM2->CR1 = TIM_CR1_CEN;
}

// The receiving handlers share a priority, since they share the circle.
static void set_up_interrupts(void)
{
    static const struct {
        enum irq irq;
        unsigned priority;
    } lines[] = {{DMA1_CHANNEL1_IRQ + DMA_USART1_RX - 1, 4}, {USART1_IRQ, 4}, {TIM2_IRQ, 2}, {EXTI0_IRQ, 6}};
    for (unsigned i = 0; i < sizeof lines / sizeof lines[0]; ++i) {
        irq_priority(lines[i].irq, lines[i].priority);
        irq_line_enable(lines[i].irq);
    }
}

// --- The application: one line at a time

static void answer_count(void)
{
    struct line line = EMPTY_LINE;
    line_text(&line, "bytes ");
    line_decimal(&line, bytes_in);
    line_text(&line, " ticks ");
    line_decimal(&line, beats);
    line_text(&line, " presses ");
    line_decimal(&line, presses);
    line_text(&line, "\r\n");
    send_text(line.text);
}

static bool is(const struct line *line, const char *text)
{
    uint32_t i = 0;
    while (text[i] && line->text[i] == text[i])
        ++i;
    return !text[i] && i == line->length;
}

static void obey(const struct line *line)
{
    if (is(line, "count")) {
        answer_count();
    } else if (is(line, "led")) {
        pin_toggle(GPIOC, LED);
        send_text("ok\r\n");
    } else {
        send_text("? ");
        send_text(line->text);
        send_text("\r\n");
    }
}

static void take_byte(struct line *line, uint8_t byte)
{
    if (byte == '\r')
        return;
    if (byte == '\n') {
        obey(line);
        *line = EMPTY_LINE;
        return;
    }
    line_text(line, (const char[]){(char)byte, 0});
}

int main(void)
{
    static struct line line;
    uint32_t presses_told = 0;
    clock_72mhz();
    set_up_pins();
    set_up_interrupts();
    set_up_serial();
    set_up_timer();
    send_text("style-irq-dma\r\n");
    for (;;) {
        uint8_t byte;
        while (ring_get(&incoming, &byte))
            take_byte(&line, byte);
        for (; presses_told != presses; ++presses_told)
            send_text("button\r\n");
        // Nothing is lost between the test above and the sleep: a pending interrupt wakes WFI with PRIMASK set too
        irq_disable();
        if (ring_fill(&incoming) == 0 && presses_told == presses)
            WFI();
        irq_enable();
    }
}
