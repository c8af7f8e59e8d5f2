// SPDX-License-Identifier: GPL-2.0-or-later
//
// What I2C1 has for SMBus (RM0008, sections 26.3.6, 26.3.8 and 26.6), as a master to which nobody answers, with pull-ups at
// PB6 (SCL) and PB7 (SDA) and nothing else; nothing at PB5 (SMBA). HCLK and PCLK1 are 8 MHz (HSI).

#include "check.h"
#include "chip/i2c_smbus.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "handlers.h"
#include "pin.h"
#include "wait.h"

#define NOBODY 0x42u
#define CCR_100K 40u // 8 MHz / 100 kHz / 2
#define MS 8000u
#define SMBA 5

static volatile uint32_t errors, seen;

void I2C1_ER_IRQHandler(void)
{
    ++errors;
    seen = I2C1->SR1;
    I2C1->SR1 = 0;
}

static void restart(uint32_t cr1, uint32_t cr2)
{
    I2C1->CR1 = I2C_CR1_SWRST;
    I2C1->CR1 = 0;
    I2C1->CR2 = 8 | cr2;
    I2C1->CCR = CCR_100K;
    I2C1->TRISE = 9;
    I2C1->CR1 = I2C_CR1_PE | cr1;
}

static bool start(void)
{
    I2C1->CR1 |= I2C_CR1_START;
    return wait_until(I2C1->SR1 & I2C_SR1_SB);
}

static bool refused(uint8_t address)
{
    bool begun = start();
    I2C1->DR = address;
    bool is_refused = wait_until(I2C1->SR1 & I2C_SR1_AF);
    I2C1->SR1 = 0;
    return begun && is_refused;
}

static void stop(void)
{
    I2C1->CR1 |= I2C_CR1_STOP;
    wait_until(!(I2C1->SR2 & I2C_SR2_BUSY));
}

static uint32_t pec(void) { return I2C1->SR2 >> I2C_SR2_PEC_SHIFT; }

// --- Packet error code (26.3.8)

static uint8_t crc8(uint8_t crc, uint8_t byte)
{
    uint32_t rest = crc ^ byte;
    for (int bit = 0; bit < 8; ++bit)
        rest = rest << 1 ^ (rest & 0x80 ? 0x107u : 0);
    return (uint8_t)rest;
}

static void packet_error_code(void)
{
    uint8_t known = 0;
    for (const char *digit = "123456789"; *digit; ++digit)
        known = crc8(known, (uint8_t)*digit);
    check_equal("the-polynomial", known, 0xF4);

    uint8_t writes = NOBODY << 1, reads = NOBODY << 1 | 1;
    restart(0, 0);
    check("a-message-without-it", refused(writes));
    check_equal("none-without-enpec", pec(), 0);
    stop();
    restart(I2C_CR1_ENPEC, 0);
    check("start", start());
    check_equal("none-at-first", pec(), 0);
    I2C1->DR = writes;
    wait_until(I2C1->SR1 & I2C_SR1_AF);
    I2C1->SR1 = 0;
    check_equal("of-the-address", pec(), crc8(0, writes));
    check("a-repeated-start", refused(reads));
    check_equal("of-the-whole-message", pec(), crc8(crc8(0, writes), reads));
    stop();
    check("the-next-message", refused(reads));
    check_equal("begins-anew", pec(), crc8(0, reads));
    I2C1->CR1 &= ~I2C_CR1_ENPEC;
    check_equal("enpec-off-clears-it", pec(), 0);
    stop();
}

static void requests(void)
{
    restart(I2C_CR1_ENPEC, 0);
    I2C1->CR1 |= I2C_CR1_PEC;
    check_equal("pec-is-asked-for", I2C1->CR1 & I2C_CR1_PEC, I2C_CR1_PEC);
    start();
    check_equal("start-takes-it-back", I2C1->CR1 & I2C_CR1_PEC, 0);
    I2C1->CR1 |= I2C_CR1_PEC;
    stop();
    check_equal("stop-takes-it-back", I2C1->CR1 & I2C_CR1_PEC, 0);
    I2C1->CR1 |= I2C_CR1_PEC | I2C_CR1_POS | I2C_CR1_ACK | I2C_CR1_ALERT;
    I2C1->CR1 &= ~I2C_CR1_PE;
    check_equal("what-pe-clears", I2C1->CR1, I2C_CR1_ENPEC);
}

// --- SCL low for too long (26.6.6)

static void timeouts(void)
{
    restart(0, 0);
    start();
    wait_cycles(40 * MS);
    check_equal("i2c-has-no-timeout", I2C1->SR1, I2C_SR1_SB);
    stop();

    restart(I2C_CR1_SMBUS, 0);
    start();
    uint32_t begin = cycles();
    wait_until(I2C1->SR1 & I2C_SR1_TIMEOUT);
    uint32_t took = cycles() - begin;
    check_range("a-master-has-10-ms", took, 10 * MS - 50, 10 * MS + 50);
    check("then-it-stops", wait_until(!(I2C1->SR2 & I2C_SR2_MSL)));
    check_equal("stop-clears-itself", I2C1->CR1 & I2C_CR1_STOP, 0);
    check_equal("nothing-but-the-flag", I2C1->SR1, I2C_SR1_TIMEOUT);
    I2C1->SR1 = 0;
    check_equal("it-clears-by-0", I2C1->SR1, 0);

    start();
    wait_cycles(9 * MS);
    I2C1->DR = NOBODY << 1;
    wait_until(I2C1->SR1 & I2C_SR1_AF);
    wait_cycles(9 * MS);
    check_equal("each-byte-has-its-own", I2C1->SR1, I2C_SR1_AF);
    stop();

    restart(I2C_CR1_SMBUS, I2C_CR2_ITERREN);
    errors = 0;
    irq_line_enable(I2C1_ER_IRQ);
    start();
    wait_cycles(11 * MS);
    irq_line_disable(I2C1_ER_IRQ);
    check_equal("an-error-interrupt", errors, 1);
    check_equal("for-the-timeout", seen, I2C_SR1_TIMEOUT);
}

// --- SMBA (26.3.6)

static void alerts(void)
{
    restart(I2C_CR1_SMBUS, 0);
    pin_mode(GPIOB, SMBA, PIN_ALTERNATE);
    check("smba-is-high", pin_read(GPIOB, SMBA));
    I2C1->CR1 |= I2C_CR1_ALERT;
    check("alert-pulls-it-low", !pin_read(GPIOB, SMBA));
    I2C1->CR1 &= ~I2C_CR1_ALERT;
    check("and-lets-go-of-it", pin_read(GPIOB, SMBA));

    pin_pull(GPIOB, SMBA, true);
    pin_write(GPIOB, SMBA, false);
    check_equal("a-device-does-not-listen", I2C1->SR1, 0);
    pin_write(GPIOB, SMBA, true);
    restart(I2C_CR1_SMBUS | I2C_CR1_SMBTYPE, I2C_CR2_ITERREN);
    errors = 0;
    irq_line_enable(I2C1_ER_IRQ);
    check_equal("no-alert-yet", errors, 0);
    pin_write(GPIOB, SMBA, false);
    check_equal("a-host-is-interrupted", errors, 1);
    check_equal("by-the-alert", seen, I2C_SR1_SMBALERT);
    pin_write(GPIOB, SMBA, true);
    check_equal("not-by-its-end", errors, 1);
    irq_line_disable(I2C1_ER_IRQ);
}

int main(void)
{
    cycles_start();
    RCC->APB1ENR |= RCC_APB1_I2C1;
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOB;
    pin_mode(GPIOB, 6, PIN_ALTERNATE_OPEN_DRAIN);
    pin_mode(GPIOB, 7, PIN_ALTERNATE_OPEN_DRAIN);
    packet_error_code();
    requests();
    timeouts();
    alerts();
    check_done();
}
