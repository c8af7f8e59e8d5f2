// SPDX-License-Identifier: GPL-2.0-or-later
//
// Streams with FIFOs (RM0410, section 8): between memories, by requests of TIM6, to an end, round and round, two buffers in
// turn, broken off; what is locked meanwhile; errors.

#include "check.h"
#include "f767/clock.h"
#include "f767/transfers.h"

static uint8_t from[64], to[64];
static uint32_t many[4];
static const void *const nowhere = (const void *)0x08400000u; // behind the flash

static uint32_t flags(void) { return DMA2->LISR & DMA_ALL; }

static void clear(void)
{
    DMA2->S[0].CR = 0;
    while (DMA2->S[0].CR & DMA_EN) {
    }
    DMA2->LIFCR = DMA_ALL;
    for (unsigned index = 0; index < sizeof to; ++index) {
        from[index] = (uint8_t)(index + 1);
        to[index] = 0;
    }
    DSB();
}

static void between(const void *source, void *target, uint32_t control, uint32_t fcr, uint32_t count)
{
    clear();
    DMA2->S[0].PAR = (uint32_t)source;
    DMA2->S[0].M0AR = (uint32_t)target;
    DMA2->S[0].NDTR = count;
    DMA2->S[0].FCR = fcr;
    DMA2->S[0].CR = control | DMA_BETWEEN | DMA_PINC | DMA_MINC;
    DMA2->S[0].CR |= DMA_EN;
    wait_cycles(2000);
}

static bool copied(unsigned size)
{
    for (unsigned index = 0; index < size; ++index)
        if (to[index] != from[index])
            return false;
    return true;
}

static void between_memories(void)
{
    static const char *const names[] = {"bytes", "half-words-to-bytes", "words-to-bytes", "bytes-to-words", "words"};
    static const uint8_t widths[][2] = {{0, 0}, {1, 0}, {2, 0}, {0, 2}, {2, 2}};
    for (unsigned test = 0; test < 5; ++test) {
        between(from, to, DMA_PSIZE(widths[test][0]) | DMA_MSIZE(widths[test][1]), FCR_DMDIS | FCR_FULL, 32u >> widths[test][0]);
        check(names[test], copied(32) && !to[32]);
    }
    check_equal("HTIF-and-TCIF", flags(), DMA_HTIF | DMA_TCIF);
    check_equal("disabled-at-the-end", DMA2->S[0].CR & DMA_EN, 0);
    check_equal("nothing-left", DMA2->S[0].NDTR, 0);
    between(from, to, DMA_PSIZE(2) | DMA_MSIZE(2) | DMA_MBURST_4, FCR_DMDIS | FCR_FULL, 8);
    check("bursts", copied(32));
    check_equal("fifo-is-empty", DMA2->S[0].FCR & 7u << 3, FCR_EMPTY);
    check("interrupt-is-pending-by-enable", !pending(DMA2_S0_IRQ));
    DMA2->S[0].CR |= DMA_TCIE;
    check("interrupt", pending(DMA2_S0_IRQ));
}

static void errors(void)
{
    between(from, to, DMA_PSIZE(2) | DMA_MSIZE(2) | DMA_MBURST_4, FCR_DMDIS, 8);
    check_equal("burst-that-does-not-fit", flags(), DMA_FEIF);
    check_equal("and-disables", DMA2->S[0].CR & DMA_EN, 0);
    between(nowhere, to, DMA_PSIZE(2) | DMA_MSIZE(2), FCR_DMDIS, 8);
    check_equal("address-of-nothing", flags() & DMA_TEIF, DMA_TEIF);
    check_equal("and-disables-too", DMA2->S[0].CR & DMA_EN, 0);
    clear();
}

// DMA1 stream 1, channel 7 is TIM6_UP. Each `take` asks for one transfer.
static void take(unsigned times)
{
    while (times--) {
        TIM6->EGR = TIM_UG;
        wait_cycles(200);
    }
}

static void by_request(const void *peripheral, uint32_t control, uint32_t count, uint32_t fcr)
{
    clear();
    DMA1->S[1].CR = 0;
    while (DMA1->S[1].CR & DMA_EN) {
    }
    DMA1->LIFCR = DMA_ALL << 6;
    DMA1->S[1].PAR = (uint32_t)peripheral;
    DMA1->S[1].M0AR = (uint32_t)to;
    DMA1->S[1].M1AR = (uint32_t)(to + 32);
    DMA1->S[1].NDTR = count;
    DMA1->S[1].FCR = fcr;
    DMA1->S[1].CR = DMA_CHANNEL(7) | control | DMA_MINC;
    DMA1->S[1].CR |= DMA_EN;
}

static uint32_t flags_1(void) { return DMA1->LISR >> 6 & DMA_ALL; }

static void by_requests(void)
{
    RCC->APB1ENR |= RCC_APB1_TIM(6);
    TIM6->DIER = 1u << 8; // UDE
    TIM6->ARR = 0x1234;

    by_request((const void *)&TIM6->ARR, DMA_PSIZE(1), 4, 0);
    take(1);
    check_equal("one-for-each-request", DMA1->S[1].NDTR, 3);
    check_equal("direct-mode-stores-at-once", *(volatile uint16_t *)to, 0x1234);
    check_equal("not-half-yet", flags_1(), 0);
    take(1);
    check_equal("half", flags_1(), DMA_HTIF);
    DMA1->S[1].NDTR = 9;
    DMA1->S[1].PAR = 0;
    check_equal("count-is-locked", DMA1->S[1].NDTR, 2);
    check_equal("address-is-locked", DMA1->S[1].PAR, (uint32_t)&TIM6->ARR);
    take(2);
    check_equal("complete", flags_1(), DMA_HTIF | DMA_TCIF);
    take(1);
    check_equal("and-over", DMA1->S[1].NDTR, 0);
    DMA1->LIFCR = DMA_ALL << 6;
    DMA1->S[1].CR |= DMA_EN;
    check_equal("count-comes-back-with-EN", DMA1->S[1].NDTR, 4);

    by_request((const void *)&TIM6->ARR, DMA_PSIZE(1) | DMA_CIRC, 2, 0);
    take(5);
    check_equal("circular", DMA1->S[1].NDTR, 1);
    check_equal("circular-completes", flags_1(), DMA_HTIF | DMA_TCIF);

    by_request((const void *)&TIM6->ARR, DMA_PSIZE(1) | DMA_DBM, 1, 0);
    check_equal("first-buffer", DMA1->S[1].CR & DMA_CT, 0);
    take(1);
    check_equal("second-buffer", DMA1->S[1].CR & DMA_CT, DMA_CT);
    TIM6->ARR = 0x4321;
    take(1);
    check_equal("two-buffers", *(volatile uint16_t *)to | (uint32_t) * (volatile uint16_t *)(to + 32) << 16, 0x43211234);

    by_request((const void *)&TIM6->ARR, DMA_PSIZE(1) | DMA_MSIZE(1), 8, FCR_DMDIS | FCR_FULL);
    take(3);
    check_equal("fifo-keeps-it", *(volatile uint16_t *)to, 0);
    check_equal("fifo-level", DMA1->S[1].FCR >> 3 & 7u, 1); // 6 of 16 bytes
    DMA1->S[1].CR &= ~(uint32_t)DMA_EN;
    wait_cycles(200);
    check_equal("disabling-stores-it", *(volatile uint16_t *)(to + 4), 0x4321);
    check_equal("and-completes", flags_1() & DMA_TCIF, DMA_TCIF);
    check_equal("what-is-left-stands", DMA1->S[1].NDTR, 5);

    many[0] = 77;
    by_request((const void *)&TIM6->ARR, DMA_TO_PERIPHERAL | DMA_PSIZE(1), 4, 0);
    DMA1->S[1].CR &= ~(uint32_t)DMA_EN;
    DMA1->LIFCR = DMA_ALL << 6;
    DMA1->S[1].M0AR = (uint32_t)many;
    DMA1->S[1].CR |= DMA_EN;
    take(1);
    check_equal("to-a-peripheral", TIM6->ARR, 77);
}

int main(void)
{
    cycles_start();
    clock_start();
    RCC->AHB1ENR |= RCC_AHB1_DMA1 | RCC_AHB1_DMA2;
    check_equal("FCR-after-reset", DMA2->S[7].FCR, 0x21);
    between_memories();
    errors();
    by_requests();
    check_done();
}
