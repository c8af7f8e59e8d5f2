// SPDX-License-Identifier: GPL-2.0-or-later
//
// Ports whose every pin has a multiplexer (RM0410, section 6). Uses PE7 to PE10 and PG9, to which nothing is attached on a
// Nucleo-144, and the registers of ports A and B.

#include "check.h"
#include "f767/blocks.h"

#define PORT GPIO('E')
enum { PIN = 8, OTHER = 9 };

// The input is sampled once in a cycle of AHB: a read right after a write may still be too early.
static uint32_t level(unsigned pin)
{
    DSB();
    for (int i = 0; i < 4; ++i)
        NOP();
    return pin_read('E', pin);
}

static void after_reset(void)
{
    check_equal("MODER-A", GPIO('A')->MODER, 0xA8000000);
    check_equal("OSPEEDR-A", GPIO('A')->OSPEEDR, 0x0C000000);
    check_equal("PUPDR-A", GPIO('A')->PUPDR, 0x64000000);
    check_equal("MODER-B", GPIO('B')->MODER, 0x00000280);
    check_equal("OSPEEDR-B", GPIO('B')->OSPEEDR, 0x000000C0);
    check_equal("PUPDR-B", GPIO('B')->PUPDR, 0x00000100);
    check_equal("MODER-E", PORT->MODER, 0);
    check_equal("BSRR-reads-0", PORT->BSRR, 0);
    check_equal("LCKR", PORT->LCKR, 0);
    check_equal("AFRL", PORT->AFR[0], 0);
}

static void set_and_reset(void)
{
    PORT->ODR = 0x00F0;
    PORT->BSRR = 0x0101;
    check_equal("bsrr-sets", PORT->ODR, 0x01F1);
    PORT->BSRR = 0x00FF000F;
    check_equal("bsrr-set-wins", PORT->ODR, 0x010F);
    ((volatile uint16_t *)&PORT->BSRR)[1] = 0x0100;
    check_equal("upper-half-word-resets", PORT->ODR, 0x000F);
    ((volatile uint8_t *)&PORT->ODR)[1] = 0xA5;
    check_equal("a-byte-leaves-the-other", PORT->ODR, 0xA50F);
    PORT->ODR = 0xABCD0000;
    check_equal("odr-has-16-bits", PORT->ODR, 0);
}

static void outputs(void)
{
    pin_mode('E', PIN, PIN_OUTPUT);
    pin_write('E', PIN, true);
    check_equal("push-pull-high", level(PIN), 1);
    pin_write('E', PIN, false);
    check_equal("push-pull-low", level(PIN), 0);
    PORT->OTYPER = 1u << PIN;
    PORT->PUPDR = 1u << 2 * PIN;
    check_equal("open-drain-low", level(PIN), 0);
    pin_write('E', PIN, true);
    check_equal("open-drain-with-pull-up", level(PIN), 1);
    PORT->PUPDR = 2u << 2 * PIN;
    check_equal("open-drain-with-pull-down", level(PIN), 0);
    PORT->OTYPER = 0;
    check_equal("push-pull-beats-a-pull", level(PIN), 1);
}

static void inputs(void)
{
    pin_mode('E', PIN, PIN_INPUT);
    check_equal("pull-down", level(PIN), 0);
    PORT->PUPDR = 1u << 2 * PIN;
    check_equal("pull-up", level(PIN), 1);
    pin_mode('E', PIN, PIN_ANALOG);
    check_equal("analog-reads-0", level(PIN), 0);
    pin_mode('E', PIN, PIN_INPUT);
    PORT->PUPDR = 0;
}

// TIM1 holds its channels 1 and 1N, which PE9 and PE8 carry as AF1, at forced levels.
static void alternate(void)
{
    RCC->APB2ENR |= RCC_APB2_TIM1;
    TIM1->BDTR = TIM_MOE;
    TIM1->CCER = 1;
    TIM1->CCMR[0] = 5u << 4;
    PORT->PUPDR = 1u << 2 * PIN | 2u << 2 * OTHER;
    pin_mode('E', OTHER, PIN_INPUT);
    check_equal("without-the-function", level(OTHER), 0);
    pin_alternate('E', OTHER, 1);
    check_equal("with-the-function", level(OTHER), 1);
    TIM1->CCMR[0] = 4u << 4;
    check_equal("it-follows", level(OTHER), 0);
    TIM1->CCMR[0] = 5u << 4;
    pin_alternate('E', PIN, 1);
    check_equal("not-driven-but-pulled", level(PIN), 1);
    PORT->OTYPER = 1u << OTHER;
    check_equal("open-drain-function", level(OTHER), 0);
    PORT->OTYPER = 0;
    pin_mode('E', OTHER, PIN_INPUT);
    check_equal("function-taken-away", level(OTHER), 0);
    pin_mode('E', PIN, PIN_INPUT);
    PORT->AFR[1] = 0;
    PORT->PUPDR = 0;
}

static void lock(void)
{
    const uint32_t key = 1u << 16, pins = 1u << PIN;
    PORT->LCKR = key | pins;
    PORT->LCKR = pins;
    check_equal("not-yet-locked", PORT->LCKR & key, 0);
    PORT->LCKR = key | pins;
    PORT->LCKR = pins;
    PORT->LCKR = key | pins;
    (void)PORT->LCKR;
    check_equal("locked", PORT->LCKR, key | pins);
    PORT->MODER = 0x55555555;
    check_equal("moder-holds", PORT->MODER, 0x55555555u & ~(3u << 2 * PIN));
    PORT->MODER = 0;
    PORT->AFR[1] = 0xFF;
    check_equal("afrh-holds", PORT->AFR[1], 0xF0);
    PORT->PUPDR = 0xFFFFFFFF;
    check_equal("pupdr-holds", PORT->PUPDR, ~(3u << 2 * PIN));
    PORT->ODR = pins;
    check_equal("odr-does-not", PORT->ODR, pins);
    PORT->LCKR = 0;
    check_equal("until-a-reset", PORT->LCKR, key | pins);
}

int main(void)
{
    RCC->AHB1ENR |= RCC_AHB1_GPIO('A') | RCC_AHB1_GPIO('B') | RCC_AHB1_GPIO('E');
    after_reset();
    set_and_reset();
    outputs();
    inputs();
    alternate();
    lock();
    check_done();
}
