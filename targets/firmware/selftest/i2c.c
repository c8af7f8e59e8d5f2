// SPDX-License-Identifier: GPL-2.0-or-later
//
// I2C1 (RM0008, section 26) as a master to which nobody answers, with pull-ups at PB6 (SCL) and PB7 (SDA) and nothing else.
// HCLK and PCLK1 are 8 MHz (HSI).

#include "check.h"
#include "chip/i2c.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "handlers.h"
#include "pin.h"
#include "wait.h"

#define NOBODY 0x42u
#define CCR_100K 40u // 8 MHz / 100 kHz / 2

static volatile uint32_t events, errors;
static volatile uint32_t seen;

void I2C1_EV_IRQHandler(void)
{
    ++events;
    seen = I2C1->SR1;
    I2C1->CR2 &= ~I2C_CR2_ITEVTEN;
}

void I2C1_ER_IRQHandler(void)
{
    ++errors;
    I2C1->SR1 = 0;
}

static void restart(uint32_t ccr, uint32_t cr2)
{
    I2C1->CR1 = I2C_CR1_SWRST;
    I2C1->CR1 = 0;
    I2C1->CR2 = 8 | cr2;
    I2C1->CCR = ccr;
    I2C1->TRISE = 9;
    I2C1->CR1 = I2C_CR1_PE;
}

static bool start(void)
{
    I2C1->CR1 |= I2C_CR1_START;
    return wait_until(I2C1->SR1 & I2C_SR1_SB);
}

static uint32_t refused(uint32_t ccr)
{
    restart(ccr, 0);
    start();
    uint32_t begin = cycles();
    I2C1->DR = NOBODY << 1;
    wait_until(I2C1->SR1 & I2C_SR1_AF);
    return cycles() - begin;
}

static void stop(void)
{
    I2C1->CR1 |= I2C_CR1_STOP;
    wait_until(!(I2C1->SR2 & I2C_SR2_BUSY));
}

// --- Registers and conditions (26.3.3, 26.6)

static void conditions(void)
{
    check_equal("trise-reset", I2C1->TRISE, 2);
    check_equal("sr1-reset", I2C1->SR1, 0);
    I2C1->CR1 = I2C_CR1_START;
    check("without-pe-no-start", !(I2C1->SR1 & I2C_SR1_SB));
    restart(CCR_100K, 0);
    check_equal("idle", I2C1->SR2, 0);
    check("start", start());
    check_equal("start-clears-itself", I2C1->CR1 & I2C_CR1_START, 0);
    check_equal("master-of-a-busy-bus", I2C1->SR2, I2C_SR2_MSL | I2C_SR2_BUSY);
    wait_cycles(4000);
    check_equal("sb-waits-for-the-address", I2C1->SR1, I2C_SR1_SB);
    I2C1->DR = NOBODY << 1;
    check("dr-clears-sb", !(I2C1->SR1 & I2C_SR1_SB));
    check("nobody-acknowledges", wait_until(I2C1->SR1 & I2C_SR1_AF));
    check_equal("no-addr-then", I2C1->SR1 & (I2C_SR1_ADDR | I2C_SR1_TXE), 0);
    check_equal("still-master", I2C1->SR2 & (I2C_SR2_MSL | I2C_SR2_BUSY), I2C_SR2_MSL | I2C_SR2_BUSY);
    I2C1->SR1 = 0;
    check_equal("af-clears-by-0", I2C1->SR1, 0);
    check("a-repeated-start", start());
    I2C1->DR = NOBODY << 1 | 1;
    check("nobody-again", wait_until(I2C1->SR1 & I2C_SR1_AF));
    I2C1->SR1 = 0;
    I2C1->CR1 |= I2C_CR1_STOP;
    check("stop", wait_until(!(I2C1->SR2 & I2C_SR2_MSL)));
    check_equal("stop-clears-itself", I2C1->CR1 & I2C_CR1_STOP, 0);
    check_equal("the-bus-is-free", I2C1->SR2, 0);
}

static void times(void)
{
    uint32_t slow = refused(CCR_100K);
    check_range("nine-clocks-at-100-khz", slow, 9 * 80, 9 * 80 + 50);
    stop();
    uint32_t fast = refused(I2C_CCR_FAST | 7);
    check_range("nine-clocks-of-3-x-7", fast, 9 * 21, 9 * 21 + 50);
    stop();
    uint32_t duty = refused(I2C_CCR_FAST | I2C_CCR_DUTY | 1);
    check_range("nine-clocks-of-25-x-1", duty, 9 * 25, 9 * 25 + 50);
    stop();
}

// --- Interrupts, reset (26.4, 26.6.1)

static void lines(void)
{
    restart(CCR_100K, I2C_CR2_ITEVTEN | I2C_CR2_ITERREN);
    events = errors = 0;
    irq_line_enable(I2C1_EV_IRQ);
    irq_line_enable(I2C1_ER_IRQ);
    I2C1->CR1 |= I2C_CR1_START;
    wait_cycles(2000);
    check_equal("an-event-for-sb", events, 1);
    check_equal("sb-was-set", seen, I2C_SR1_SB);
    (void)I2C1->SR1;
    I2C1->DR = NOBODY << 1;
    wait_cycles(2000);
    check_equal("an-error-for-af", errors, 1);
    irq_line_disable(I2C1_EV_IRQ);
    irq_line_disable(I2C1_ER_IRQ);
    stop();

    start();
    I2C1->CR1 = I2C_CR1_SWRST;
    check_equal("swrst-frees-the-bus", I2C1->SR2, 0);
    check_equal("and-clears-the-rest", I2C1->CCR | I2C1->SR1, 0);
    I2C1->CR1 = 0;
    restart(CCR_100K, 0);
    start();
    I2C1->CR1 = 0;
    check_equal("pe-off-frees-the-bus", I2C1->SR2 | I2C1->SR1, 0);
}

int main(void)
{
    cycles_start();
    RCC->APB1ENR |= RCC_APB1_I2C1;
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOB;
    pin_mode(GPIOB, 6, PIN_ALTERNATE_OPEN_DRAIN);
    pin_mode(GPIOB, 7, PIN_ALTERNATE_OPEN_DRAIN);
    conditions();
    times();
    lines();
    check_done();
}
