// SPDX-License-Identifier: GPL-2.0-or-later
//
// External interrupts and events (RM0008, 10.2 and 10.3). Edges come from the pins' own pulls, from an output that reads
// itself, and from software; no wire is needed. Lines 5 to 9 on port B, where nothing is attached.

#include "check.h"
#include "chip/stm32f103.h"
#include "handlers.h"
#include "pin.h"

#define LINE 6
#define BIT (1u << LINE)

static volatile uint32_t interrupts;
static volatile uint32_t pending_seen;

void EXTI9_5_IRQHandler(void)
{
    ++interrupts;
    pending_seen = EXTI->PR;
    EXTI->PR = pending_seen;
}

void EXTI0_IRQHandler(void)
{
    interrupts += 100;
    EXTI->PR = 1;
}

void EXTI15_10_IRQHandler(void)
{
    interrupts += 10000;
    EXTI->PR = 0xFC00;
}

static void settle(void)
{
    DSB();
    for (int i = 0; i < 8; ++i)
        NOP();
}

static void drive(bool up)
{
    pin_write(GPIOB, LINE, up);
    settle();
}

static void edges(uint32_t rising, uint32_t falling)
{
    EXTI->RTSR = rising;
    EXTI->FTSR = falling;
}

// --- Edges (10.2.4)

static void pending_register(const char *name, bool rising, bool falling, uint32_t want)
{
    edges(rising ? BIT : 0, falling ? BIT : 0);
    drive(false);
    EXTI->PR = BIT;
    drive(true);
    uint32_t got = (EXTI->PR & BIT) != 0;
    EXTI->PR = BIT;
    drive(false);
    got = got << 4 | ((EXTI->PR & BIT) != 0);
    EXTI->PR = BIT;
    check_equal(name, got, want);
}

static void edge_detection(void)
{
    EXTI->IMR = BIT;
    pending_register("no-edge-selected", false, false, 0x00);
    pending_register("rising-edge", true, false, 0x10);
    pending_register("falling-edge", false, true, 0x01);
    pending_register("both-edges", true, true, 0x11);

    edges(BIT, 0);
    drive(true);
    EXTI->PR = 0;
    check("pr-keeps-on-writing-0", EXTI->PR & BIT);
    irq_unpend(EXTI9_5_IRQ);
    check("unpending-is-in-vain-while-pr-is-set", irq_is_pending(EXTI9_5_IRQ));
    EXTI->PR = BIT;
    check("pr-clears-on-writing-1", !(EXTI->PR & BIT));
    drive(true);
    check("no-edge-no-pending", !(EXTI->PR & BIT));
    check("line-reaches-nvic", irq_is_pending(EXTI9_5_IRQ));
    irq_unpend(EXTI9_5_IRQ);

    // The other ports' pins of the same number have no part in it until AFIO says so (9.4.3)
    drive(false);
    EXTI->PR = BIT;
    AFIO->EXTICR[LINE / 4] = 0; // port A
    drive(true);
    check("other-port-selected", !(EXTI->PR & BIT));
    EXTI->PR = BIT;
    AFIO->EXTICR[LINE / 4] = 1u << (LINE % 4 * 4);
    settle();
    EXTI->PR = BIT;
    irq_unpend(EXTI9_5_IRQ);

    pin_mode(GPIOB, LINE, PIN_OUTPUT); // the input stage of an output is on (9.1.8)
    drive(false);
    EXTI->PR = BIT;
    drive(true);
    check("own-output-triggers", EXTI->PR & BIT);
    EXTI->PR = BIT;
    irq_unpend(EXTI9_5_IRQ);
    pin_mode(GPIOB, LINE, PIN_PULLED);
}

// --- Interrupts

static void handlers(void)
{
    edges(BIT, BIT);
    interrupts = 0;
    irq_line_enable(EXTI9_5_IRQ);
    drive(false);
    drive(true);
    check_equal("interrupt-on-each-edge", interrupts, 2);
    check_equal("pending-in-handler", pending_seen, BIT);
    EXTI->IMR = 0;
    drive(false);
    check_equal("masked-line-is-silent", interrupts, 2);
    check_equal("masked-line-is-not-pending", EXTI->PR & BIT, 0);
    EXTI->PR = BIT;
    EXTI->IMR = BIT;
    settle();
    check_equal("cleared-before-unmasking", interrupts, 2);
}

// --- By software (10.3.5)

static void software(void)
{
    EXTI->IMR = BIT;
    edges(0, 0);
    irq_line_disable(EXTI9_5_IRQ);
    EXTI->SWIER = BIT;
    check("swier-sets-pr", EXTI->PR & BIT);
    check_equal("swier-reads-back", EXTI->SWIER, BIT);
    EXTI->PR = BIT;
    check_equal("swier-cleared-with-pr", EXTI->SWIER, 0);
    irq_unpend(EXTI9_5_IRQ);
    irq_line_enable(EXTI9_5_IRQ);

    EXTI->IMR = BIT | 1u | 1u << 12;
    interrupts = 0;
    irq_line_enable(EXTI0_IRQ);
    irq_line_enable(EXTI15_10_IRQ);
    EXTI->SWIER = BIT;
    settle();
    check_equal("swier-line-6-vector-9-5", interrupts, 1);
    EXTI->SWIER = 1;
    settle();
    check_equal("swier-line-0-vector-0", interrupts, 101);
    EXTI->SWIER = 1u << 12;
    settle();
    check_equal("swier-line-12-vector-15-10", interrupts, 10101);
    irq_disable();
    EXTI->SWIER = BIT;
    EXTI->SWIER = BIT;
    settle();
    irq_enable();
    settle();
    check_equal("swier-twice-is-once", interrupts, 10102);
    check_equal("all-cleared", EXTI->PR, 0);
}

// --- Events (10.2.3): they wake WFE and leave no trace in EXTI_PR unless the interrupt is unmasked too

static volatile uint32_t alarms;

void SysTick_Handler(void)
{
    ++alarms;
    SYSTICK->CTRL = 0;
}

// Wakes a WFE that the event did not, so that a failure is a failed check.
static void set_alarm(void)
{
    alarms = 0;
    SYSTICK->LOAD = 20000;
    SYSTICK->VAL = 0;
    SYSTICK->CTRL = SYSTICK_CLKSOURCE | SYSTICK_TICKINT | SYSTICK_ENABLE;
}

static void events(void)
{
    EXTI->IMR = 0;
    EXTI->EMR = BIT;
    edges(BIT, 0);
    drive(false);
    EXTI->PR = BIT;
    SEV(); // empties the event register: the first WFE goes through
    WFE();
    set_alarm();
    drive(true);
    WFE();
    check_equal("event-wakes-wfe", alarms, 0);
    SYSTICK->CTRL = 0;

    EXTI->EMR = 0;
    drive(false);
    SEV();
    WFE();
    set_alarm();
    drive(true);
    WFE();
    check_equal("masked-event-does-not", alarms, 1);
    EXTI->PR = BIT;
}

int main(void)
{
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOB;
    check_equal("imr-reset", EXTI->IMR, 0);
    check_equal("emr-reset", EXTI->EMR, 0);
    check_equal("rtsr-reset", EXTI->RTSR, 0);
    check_equal("ftsr-reset", EXTI->FTSR, 0);
    check_equal("swier-reset", EXTI->SWIER, 0);
    pin_pull(GPIOB, LINE, false);
    AFIO->EXTICR[LINE / 4] = 1u << (LINE % 4 * 4); // port B
    settle();
    edge_detection();
    handlers();
    software();
    events();
    check_done();
}
