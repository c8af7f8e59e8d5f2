// SPDX-License-Identifier: GPL-2.0-or-later
//
// What high-density devices have beyond the others, but for the DAC: TIM5 to TIM8 (RM0008, sections 14, 15 and 17), DMA2
// (section 13, table 79), UART4 and UART5 (section 27), their interrupts (table 63). Needs no wire: the UARTs hear
// themselves on one wire. Nothing may be attached to PA0, PA3, PA7, PC6, PC10 and PC12.

#include "check.h"
#include "clock.h"
#include "cycles.h"
#include "f103e/handlers.h"
#include "f103e/registers.h"
#include "memory.h"
#include "pin.h"
#include "wait.h"

static void fresh_timers(void)
{
    RCC->APB1RSTR = RCC_APB1_TIM2 | RCC_APB1_TIM3 | RCC_APB1_TIM4 | RCC_APB1_TIM5 | RCC_APB1_TIM6 | RCC_APB1_TIM7;
    RCC->APB1RSTR = 0;
    RCC->APB2RSTR = RCC_APB2_TIM1 | RCC_APB2_TIM8;
    RCC->APB2RSTR = 0;
}

static bool pends(unsigned irq)
{
    bool pending = NVIC->ISPR[irq / 32] >> irq % 32 & 1u;
    NVIC->ICPR[irq / 32] = 1u << irq % 32;
    return pending;
}

// Which of the interrupts from 43 on are pending, and no others; they are none after that.
static uint32_t pending_from_43(void)
{
    uint32_t found = NVIC->ISPR[1] >> (43 - 32);
    NVIC->ICPR[1] = ~0u;
    return found;
}

// --- TIM6 and TIM7 (17.4)

static void basic_registers(const char *name, volatile tim_t *timer)
{
    timer->CR1 = ~1u;
    timer->CR2 = timer->DIER = ~0u;
    uint32_t kept = (timer->CR1 & 0xFFFF) ^ (timer->CR2 & 0xFFFF) << 16;
    check_equal(name, kept | (timer->DIER != 0x101), 0x0070008E);
}

static void basic_timer(volatile tim_t *timer, const char *counts, const char *interrupts, const char *stops, unsigned irq)
{
    fresh_timers();
    timer->PSC = 71;
    timer->ARR = 9;
    timer->EGR = TIM_EGR_UG;
    timer->SR = 0;
    timer->DIER = TIM_UIF;
    uint32_t begin = cycles();
    timer->CR1 = TIM_CR1_CEN;
    wait_until(timer->SR & TIM_UIF);
    check_range(counts, cycles() - begin, 720, 760);
    check(interrupts, pends(irq));
    timer->DIER = 0;
    timer->SR = 0;
    pends(irq);
    timer->CR1 = TIM_CR1_CEN | TIM_CR1_OPM;
    wait_until(timer->SR & TIM_UIF);
    check_equal(stops, timer->CR1, TIM_CR1_OPM);
}

static void basic_timers(void)
{
    basic_registers("tim6-registers", TIM6);
    basic_registers("tim7-registers", TIM7);
    basic_timer(TIM6, "tim6-counts", "tim6-is-irq-54", "tim6-one-pulse", TIM6_IRQ);
    basic_timer(TIM7, "tim7-counts", "tim7-is-irq-55", "tim7-one-pulse", TIM7_IRQ);
}

// --- TIM5 and TIM8: interrupts, outputs

static void interrupts(void)
{
    static const struct {
        const char *name;
        uint32_t enable, irq;
    } cases[] = {
        {"tim8-break-is-irq-43", TIM_BIF, TIM8_BRK_IRQ},  {"tim8-update-is-irq-44", TIM_UIF, TIM8_UP_IRQ},
        {"tim8-trigger-is-irq-45", TIM_TIF, TIM8_TRG_COM_IRQ}, {"tim8-com-is-irq-45", TIM_COMIF, TIM8_TRG_COM_IRQ},
        {"tim8-compare-is-irq-46", TIM_CCIF(3), TIM8_CC_IRQ},
    };
    for (unsigned i = 0; i < sizeof cases / sizeof *cases; ++i) {
        fresh_timers();
        pending_from_43();
        TIM8->DIER = cases[i].enable;
        TIM8->EGR = cases[i].enable;
        check_equal(cases[i].name, pending_from_43(), 1u << (cases[i].irq - 43));
    }
    fresh_timers();
    pending_from_43();
    TIM5->DIER = TIM_CCIF(4);
    TIM5->EGR = TIM_CCIF(4);
    check_equal("tim5-is-irq-50", pending_from_43(), 1u << (TIM5_IRQ - 43));
    fresh_timers();
    pending_from_43();
}

static void outputs(void)
{
    fresh_timers();
    pin_mode(GPIOC, 6, PIN_ALTERNATE);
    pin_mode(GPIOA, 7, PIN_ALTERNATE);
    TIM8->CCMR1 = TIM_OC_FORCE_HIGH;
    TIM8->CCER = TIM_CCER_E(1) | TIM_CCER_NE(1);
    bool before = pin_read(GPIOC, 6) || pin_read(GPIOA, 7);
    TIM8->BDTR = TIM_BDTR_MOE;
    wait_cycles(50);
    uint32_t high = pin_read(GPIOC, 6) << 1 | pin_read(GPIOA, 7);
    TIM8->CCMR1 = TIM_OC_FORCE_LOW;
    wait_cycles(50);
    uint32_t low = pin_read(GPIOC, 6) << 1 | pin_read(GPIOA, 7);
    TIM8->EGR = TIM_EGR_BG;
    check("tim8-waits-for-moe", !before);
    check_equal("tim8-ch1-and-ch1n", high << 4 | low, 0x21);
    check_equal("tim8-break-clears-moe", TIM8->BDTR & TIM_BDTR_MOE, 0);
    TIM8->RCR = 2;
    TIM8->ARR = 99;
    TIM8->EGR = TIM_EGR_UG;
    TIM8->SR = 0;
    uint32_t begin = cycles();
    TIM8->CR1 = TIM_CR1_CEN;
    wait_until(TIM8->SR & TIM_UIF);
    check_range("tim8-repeats", cycles() - begin, 300, 340);

    fresh_timers();
    pin_mode(GPIOA, 0, PIN_ALTERNATE);
    TIM5->CCER = TIM_CCER_E(1);
    TIM5->CCMR1 = TIM_OC_FORCE_HIGH;
    wait_cycles(50);
    high = pin_read(GPIOA, 0);
    TIM5->CCMR1 = TIM_OC_FORCE_LOW;
    wait_cycles(50);
    check_equal("tim5-ch1-at-pa0", high << 4 | pin_read(GPIOA, 0), 0x10);
    pin_mode(GPIOA, 0, PIN_FLOATING);
}

// --- Who triggers whom (tables 82 and 86): a slave counts what comes by its ITRx

static void masters(const char *name, volatile tim_t *slave, volatile tim_t *const *by_itr)
{
    uint32_t wrong = 0;
    for (unsigned itr = 0; itr < 4; ++itr) {
        fresh_timers();
        slave->SMCR = TIM_TS_ITR(itr) | TIM_SLAVE_EXTERNAL;
        slave->CR1 = TIM_CR1_CEN;
        for (unsigned other = 0; other < 4; ++other)
            for (unsigned pulse = 0; pulse <= other; ++pulse) {
                by_itr[other]->EGR = TIM_EGR_UG; // MMS = 000: that is put out
                wait_cycles(20);
            }
        wrong += slave->CNT != itr + 1;
    }
    check_equal(name, wrong, 0);
}

static void triggers(void)
{
    masters("masters-of-tim1", TIM1, (volatile tim_t *const[]){TIM5, TIM2, TIM3, TIM4});
    masters("masters-of-tim2", TIM2, (volatile tim_t *const[]){TIM1, TIM8, TIM3, TIM4});
    masters("masters-of-tim3", TIM3, (volatile tim_t *const[]){TIM1, TIM2, TIM5, TIM4});
    masters("masters-of-tim4", TIM4, (volatile tim_t *const[]){TIM1, TIM2, TIM3, TIM8});
    masters("masters-of-tim5", TIM5, (volatile tim_t *const[]){TIM2, TIM3, TIM4, TIM8});
    masters("masters-of-tim8", TIM8, (volatile tim_t *const[]){TIM1, TIM2, TIM4, TIM5});
}

// --- TIM5 measures the LSI (9.4.2, TIM5CH4_IREMAP): 30 to 60 kHz

static bool captured(void) { return wait_until(TIM5->SR & TIM_CCIF(4)); }

static void low_speed_oscillator(void)
{
    fresh_timers();
    pin_pull(GPIOA, 3, false);
    RCC->CSR |= RCC_CSR_LSION;
    wait_until(RCC->CSR & RCC_CSR_LSIRDY);
    TIM5->CCMR2 = TIM_CC_INPUT_DIRECT << 8 | 3u << (8 + TIM_IC_PSC_SHIFT); // each eighth edge
    TIM5->CCER = TIM_CCER_E(4);
    TIM5->CR1 = TIM_CR1_CEN;
    wait_cycles(72 * 500);
    check("no-lsi-without-the-remap", !(TIM5->SR & TIM_CCIF(4)));
    AFIO->MAPR = AFIO_MAPR_SWD_ONLY | AFIO_MAPR_TIM5CH4_LSI;
    bool comes = captured();
    uint32_t first = TIM5->CCR[3];
    comes = captured() && comes;
    check("lsi-is-captured", comes);
    check_range("eight-periods-of-lsi", (TIM5->CCR[3] - first) & 0xFFFF, 72000000u / 60000 * 8, 72000000u / 30000 * 8);
    AFIO->MAPR = AFIO_MAPR_SWD_ONLY;
    (void)TIM5->CCR[3];
    wait_cycles(72 * 500);
    check("pa3-is-back", !(TIM5->SR & TIM_CCIF(4)));
    RCC->CSR &= ~RCC_CSR_LSION;
}

// --- DMA2: five channels, the last two with one interrupt

#define WORDS (2u << DMA_CCR_PSIZE_SHIFT | 2u << DMA_CCR_MSIZE_SHIFT)

static uint32_t target[5];

static void start(unsigned n, volatile const void *peripheral, volatile const void *memory, uint32_t count, uint32_t ccr)
{
    volatile dma_channel_t *channel = DMA2_CHANNEL(n);
    channel->CCR = 0;
    channel->CPAR = (uint32_t)(uintptr_t)peripheral;
    channel->CMAR = (uint32_t)(uintptr_t)memory;
    channel->CNDTR = count;
    channel->CCR = ccr | DMA_CCR_EN;
}

static void stop_all(void)
{
    for (unsigned n = 1; n <= 5; ++n)
        DMA2_CHANNEL(n)->CCR = 0;
    DMA2->IFCR = ~0u;
    pending_from_43();
}

static void channels(void)
{
    static const char *const names[] = {"dma2-1-is-irq-56", "dma2-2-is-irq-57", "dma2-3-is-irq-58", "dma2-4-is-irq-59",
                                        "dma2-5-is-irq-59"};
    static const uint32_t source = 0x12345678;
    for (unsigned n = 1; n <= 5; ++n) {
        stop_all();
        start(n, &source, &target[n - 1], 1, DMA_CCR_MEM2MEM | DMA_CCR_TCIE | WORDS);
        bool done = wait_until(DMA2->ISR & DMA_TCIF(n)) && target[n - 1] == source;
        check_equal(names[n - 1], (uint32_t)done << 31 | pending_from_43(), 1u << 31 | 1u << ((n < 5 ? 55 + n : 59) - 43));
    }
    check_equal("flags-of-five-channels", DMA2->ISR & ~0xF0000u, 0);
    stop_all();
    start(4, &source, &target[3], 1, DMA_CCR_MEM2MEM | DMA_CCR_TCIE | WORDS);
    start(5, &source, &target[4], 1, DMA_CCR_MEM2MEM | DMA_CCR_TCIE | WORDS);
    wait_until((DMA2->ISR & (DMA_TCIF(4) | DMA_TCIF(5))) == (DMA_TCIF(4) | DMA_TCIF(5)));
    DMA2->IFCR = DMA_GIF(4);
    pending_from_43();
    check_equal("59-stays-while-one-asks", pending_from_43(), 1u << (59 - 43));
    DMA2->IFCR = DMA_GIF(5);
    pending_from_43();
    check_equal("59-falls-with-both", pending_from_43(), 0);
    stop_all();
}

// Each event of a timer moves a word at the channel that it leads to, and at no other.
static void requests_of(const char *name, volatile tim_t *timer, uint32_t enable, uint32_t event, unsigned channel)
{
    static const uint32_t source[2] = {1, 2};
    stop_all();
    for (unsigned n = 1; n <= 5; ++n)
        start(n, source, target, 2, WORDS);
    timer->DIER = enable;
    timer->EGR = event;
    wait_cycles(100);
    uint32_t left = 0;
    for (unsigned n = 1; n <= 5; ++n)
        left |= DMA2_CHANNEL(n)->CNDTR << 4 * n;
    timer->DIER = 0;
    check_equal(name, left, 0x222220u - (1u << 4 * channel));
}

static void requests(void)
{
    fresh_timers();
    requests_of("tim5-ch4", TIM5, TIM_DIER_CCDE(4), TIM_CCIF(4), 1);
    requests_of("tim5-trigger", TIM5, 1u << 14, TIM_EGR_TG, 1);
    requests_of("tim8-ch3", TIM8, TIM_DIER_CCDE(3), TIM_CCIF(3), 1);
    requests_of("tim8-update", TIM8, TIM_DIER_UDE, TIM_EGR_UG, 1);
    requests_of("tim5-ch3", TIM5, TIM_DIER_CCDE(3), TIM_CCIF(3), 2);
    requests_of("tim5-update", TIM5, TIM_DIER_UDE, TIM_EGR_UG, 2);
    requests_of("tim8-ch4", TIM8, TIM_DIER_CCDE(4), TIM_CCIF(4), 2);
    requests_of("tim8-trigger", TIM8, 1u << 14, TIM_EGR_TG, 2);
    requests_of("tim8-com", TIM8, 1u << 13, TIM_EGR_COMG, 2);
    requests_of("tim6-update", TIM6, TIM_DIER_UDE, TIM_EGR_UG, 3);
    requests_of("tim8-ch1", TIM8, TIM_DIER_CCDE(1), TIM_CCIF(1), 3);
    requests_of("tim5-ch2", TIM5, TIM_DIER_CCDE(2), TIM_CCIF(2), 4);
    requests_of("tim7-update", TIM7, TIM_DIER_UDE, TIM_EGR_UG, 4);
    requests_of("tim5-ch1", TIM5, TIM_DIER_CCDE(1), TIM_CCIF(1), 5);
    requests_of("tim8-ch2", TIM8, TIM_DIER_CCDE(2), TIM_CCIF(2), 5);
    stop_all();
}

// --- UART4 and UART5, each on one wire (27.3.10): it hears what it sends

#define BIT 100u // of PCLK1

static void one_wire(volatile usart_t *uart, port_t port, unsigned pin)
{
    pin_write(port, pin, true);
    pin_mode(port, pin, PIN_ALTERNATE);
    uart->BRR = BIT;
    uart->CR3 = USART_CR3_HDSEL;
    uart->CR1 = USART_CR1_UE | USART_CR1_TE | USART_CR1_RE;
    wait_cycles(26 * BIT);
    (void)uart->SR;
    (void)uart->DR;
}

static void uart_registers(void)
{
    UART4->CR2 = UART5->CR2 = UART4->CR3 = UART5->CR3 = 0xFFFF;
    check_equal("no-clock-and-no-half-stop-bits", UART4->CR2 << 16 | UART5->CR2, 0x606F606F);
    check_equal("no-flow-control-no-smartcard", UART4->CR3, 0x00CF);
    check_equal("no-dma-of-uart5", UART5->CR3, 0x000F);
    check_equal("sr-reset", UART4->SR << 16 | UART5->SR, (USART_SR_TXE | USART_SR_TC) << 16 | USART_SR_TXE | USART_SR_TC);
    UART4->CR2 = UART5->CR2 = UART4->CR3 = UART5->CR3 = 0;
}

static void uart_interrupt(const char *name, volatile usart_t *uart, port_t port, unsigned pin, unsigned irq)
{
    one_wire(uart, port, pin);
    pending_from_43();
    uart->CR1 |= USART_CR1_RXNEIE;
    uart->DR = 0xA5;
    wait_until(uart->SR & USART_SR_RXNE);
    uint32_t pending = pending_from_43();
    check_equal(name, uart->DR << 24 | pending, 0xA5u << 24 | 1u << (irq - 43));
    uart->CR1 = 0;
    pending_from_43();
}

static void uart_dma(void)
{
    static const uint8_t text[8] = "UART4-2";
    static uint8_t heard[8];
    one_wire(UART4, GPIOC, 10);
    stop_all();
    start(3, &UART4->DR, heard, 8, DMA_CCR_MINC);
    start(5, &UART4->DR, text, 8, DMA_CCR_MINC | DMA_CCR_FROM_MEMORY);
    UART4->CR3 = USART_CR3_HDSEL | USART_CR3_DMAR | USART_CR3_DMAT;
    bool done = wait_until(DMA2->ISR & DMA_TCIF(3));
    check("uart4-by-dma2-both-ways", done && memcmp(text, heard, 8) == 0);
    check_equal("uart4-without-errors", UART4->SR & (USART_SR_ORE | USART_SR_FE | USART_SR_NE), 0);
    UART4->CR1 = UART4->CR3 = 0;
    stop_all();
}

int main(void)
{
    clock_72mhz();
    cycles_start();
    RCC->AHBENR |= RCC_AHB_DMA2;
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOC | RCC_APB2_TIM1 | RCC_APB2_TIM8;
    RCC->APB1ENR |= RCC_APB1_TIM2 | RCC_APB1_TIM3 | RCC_APB1_TIM4 | RCC_APB1_TIM5 | RCC_APB1_TIM6 | RCC_APB1_TIM7;
    RCC->APB1ENR |= RCC_APB1_UART4 | RCC_APB1_UART5;
    basic_timers();
    interrupts();
    outputs();
    triggers();
    low_speed_oscillator();
    channels();
    requests();
    uart_registers();
    uart_interrupt("uart4-is-irq-52", UART4, GPIOC, 10, UART4_IRQ);
    uart_interrupt("uart5-is-irq-53", UART5, GPIOC, 12, UART5_IRQ);
    uart_dma();
    check_done();
}
