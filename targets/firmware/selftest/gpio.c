// SPDX-License-Identifier: GPL-2.0-or-later
//
// General-purpose pins (RM0008, section 9). Uses PB5 to PB9, to which nothing is attached on a Blue Pill, and PA13 to PA15
// with PB3 and PB4, the debug port's pins.

#include "check.h"
#include "chip/stm32f103.h"
#include "pin.h"

#define PIN 6
#define OTHER 7

// The input is sampled once in a cycle of APB2 (9.1.3): a read right after a write may still be too early.
static uint32_t level(port_t port, unsigned pin)
{
    DSB();
    for (int i = 0; i < 4; ++i)
        NOP();
    return pin_read(port, pin);
}

static void after_reset(void)
{
    check_equal("crh-reset", GPIOB->CR[1], 0x44444444);
    check_equal("odr-reset", GPIOC->ODR, 0);
    check_equal("lckr-reset", GPIOB->LCKR, 0);
    check_equal("bsrr-reads-0", GPIOB->BSRR, 0);
    check_equal("brr-reads-0", GPIOB->BRR, 0);
}

static void set_and_reset(void)
{
    GPIOC->ODR = 0;
    GPIOB->ODR = 0x00F0;
    GPIOB->BSRR = 0x0101;
    check_equal("bsrr-sets", GPIOB->ODR, 0x01F1);
    GPIOB->BSRR = 0x00110000;
    check_equal("bsrr-resets", GPIOB->ODR, 0x01E0);
    GPIOB->BSRR = 0x00FF000F;
    check_equal("bsrr-set-and-reset", GPIOB->ODR, 0x010F);
    GPIOB->BSRR = 0x000F000F;
    check_equal("bsrr-set-wins", GPIOB->ODR, 0x010F);
    GPIOB->BRR = 0xFFFF0105;
    check_equal("brr-resets", GPIOB->ODR, 0x000A);
    check_equal("other-port-untouched", GPIOC->ODR, 0);
    GPIOB->ODR = 0xABCD1234;
    check_equal("odr-has-16-bits", GPIOB->ODR, 0x1234);
    GPIOB->ODR = 0;
    *bit_of(&GPIOB->ODR, PIN) = 1; // "the ODR bits can be individually set and cleared" by bit-banding too
    check_equal("odr-bit-band", GPIOB->ODR, 1u << PIN);
    GPIOB->ODR = 0;
}

static void outputs(void)
{
    pin_mode(GPIOB, PIN, PIN_OUTPUT);
    pin_write(GPIOB, PIN, true);
    check_equal("push-pull-reads-back-high", level(GPIOB, PIN), 1);
    pin_write(GPIOB, PIN, false);
    check_equal("push-pull-reads-back-low", level(GPIOB, PIN), 0);
    pin_mode(GPIOB, PIN, PIN_OUTPUT_OPEN_DRAIN);
    check_equal("open-drain-low", level(GPIOB, PIN), 0);
    pin_write(GPIOB, PIN, true);
    pin_mode(GPIOB, PIN, 0x1); // push-pull at 10 MHz
    check_equal("10-mhz-output", level(GPIOB, PIN), 1);
    pin_mode(GPIOB, PIN, 0x2); // and at 2 MHz
    check_equal("2-mhz-output", level(GPIOB, PIN), 1);
    pin_mode(GPIOB, OTHER, PIN_OUTPUT);
    pin_write(GPIOB, PIN, false);
    pin_write(GPIOB, OTHER, true);
    check_equal("pins-are-independent", GPIOB->IDR >> PIN & 3, 2);
}

static void inputs(void)
{
    pin_pull(GPIOB, PIN, true);
    check_equal("pull-up", level(GPIOB, PIN), 1);
    pin_write(GPIOB, PIN, false);
    check_equal("pull-down", level(GPIOB, PIN), 0);
    pin_write(GPIOB, PIN, true);
    check_equal("pull-up-again", level(GPIOB, PIN), 1);
    GPIOB->IDR = 0;
    check_equal("idr-is-read-only", level(GPIOB, PIN), 1);
    pin_mode(GPIOB, PIN, PIN_ANALOG);
    check_equal("analog-reads-0", level(GPIOB, PIN), 0); // 9.1.10
    pin_mode(GPIOB, PIN, PIN_PULLED);
    check_equal("pulled-after-analog", level(GPIOB, PIN), 1);
    check_equal("cr-reads-back", GPIOB->CR[0] >> (4 * PIN) & 0xF, PIN_PULLED);
    // Two outputs never fight here, but a pulled input must give way to an output turned on in its place
    pin_write(GPIOB, PIN, false);
    pin_mode(GPIOB, PIN, PIN_OUTPUT);
    check_equal("output-after-pull", level(GPIOB, PIN), 0);
    pin_mode(GPIOB, PIN, PIN_FLOATING);
}

// --- Lock (9.2.7)

static void write_lock(uint32_t first, uint32_t second, uint32_t third)
{
    GPIOB->LCKR = first;
    GPIOB->LCKR = second;
    GPIOB->LCKR = third;
    (void)GPIOB->LCKR;
}

static void locking(void)
{
    uint32_t pins = 1u << 8;
    write_lock(GPIO_LCKR_LCKK | pins, GPIO_LCKR_LCKK | pins, GPIO_LCKR_LCKK | pins);
    check_equal("wrong-sequence-does-not-lock", GPIOB->LCKR & GPIO_LCKR_LCKK, 0);
    write_lock(GPIO_LCKR_LCKK | pins, pins | 1u << 9, GPIO_LCKR_LCKK | pins);
    check_equal("changed-pins-do-not-lock", GPIOB->LCKR & GPIO_LCKR_LCKK, 0);
    pin_mode(GPIOB, 8, PIN_OUTPUT);
    check_equal("not-locked-yet", GPIOB->CR[1] & 0xF, PIN_OUTPUT);
    write_lock(GPIO_LCKR_LCKK | pins, pins, GPIO_LCKR_LCKK | pins);
    check_equal("locked", GPIOB->LCKR, GPIO_LCKR_LCKK | pins);
    pin_mode(GPIOB, 8, PIN_FLOATING);
    check_equal("locked-pin-keeps-mode", GPIOB->CR[1] & 0xF, PIN_OUTPUT);
    pin_mode(GPIOB, 9, PIN_OUTPUT);
    check_equal("unlocked-pin-changes", GPIOB->CR[1] >> 4 & 0xF, PIN_OUTPUT);
    pin_write(GPIOB, 8, true);
    check_equal("locked-pin-still-drives", level(GPIOB, 8), 1);
    GPIOB->LCKR = 0;
    check_equal("lock-lasts", GPIOB->LCKR, GPIO_LCKR_LCKK | pins);
    RCC->APB2RSTR = RCC_APB2_GPIOB;
    RCC->APB2RSTR = 0;
    check_equal("lock-ends-with-reset", GPIOB->LCKR, 0);
}

// --- The debug port's pins (9.3.5, 31.4.4): pulled by it until AFIO gives them back

static void debug_pins(void)
{
    check_equal("jtms-is-pulled-up", level(GPIOA, 13), 1);
    check_equal("jtck-is-pulled-down", level(GPIOA, 14), 0);
    check_equal("jtdi-is-pulled-up", level(GPIOA, 15), 1);
    check_equal("njtrst-is-pulled-up", level(GPIOB, 4), 1);
    AFIO->MAPR = AFIO_MAPR_SWD_ONLY;
    pin_pull(GPIOA, 15, false);
    check_equal("released-jtdi-obeys", level(GPIOA, 15), 0);
    pin_pull(GPIOB, 4, false);
    check_equal("released-njtrst-obeys", level(GPIOB, 4), 0);
    pin_mode(GPIOB, 3, PIN_OUTPUT);
    pin_write(GPIOB, 3, true);
    check_equal("released-jtdo-drives", level(GPIOB, 3), 1);
    check_equal("swdio-stays-debug", level(GPIOA, 13), 1);
}

static void remapping(void)
{
    AFIO->MAPR = AFIO_MAPR_SWD_ONLY | 3u << AFIO_MAPR_TIM3_SHIFT | AFIO_MAPR_USART1;
    check_equal("mapr-reads-back", AFIO->MAPR & 0x00FFFFFF, 3u << AFIO_MAPR_TIM3_SHIFT | AFIO_MAPR_USART1);
    AFIO->MAPR = AFIO_MAPR_SWD_ONLY;
    AFIO->EXTICR[1] = 0x2101;
    check_equal("exticr-reads-back", AFIO->EXTICR[1], 0x2101);
    AFIO->EXTICR[1] = 0;
}

int main(void)
{
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_GPIOB | RCC_APB2_GPIOC;
    after_reset();
    debug_pins();
    set_and_reset();
    outputs();
    inputs();
    remapping();
    locking();
    check_done();
}
