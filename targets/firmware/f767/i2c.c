// SPDX-License-Identifier: GPL-2.0-or-later
//
// I2C as a master to which nobody answers (RM0410, section 33): registers, times, NACK, STOP, interrupts, PE. Uses I2C1 at
// PB8 and PB9 with their own pull-ups, to which nothing is attached on a Nucleo-144.

#include "check.h"
#include "f767/clock.h"
#include "f767/transfers.h"

// About 100 kHz from PCLK1: SCL is low for 20 and high for 16 times 7 clocks of 54 MHz, and what synchronisation takes.
#define TIMING 0x60000F13u
#define SCL_CYCLES (4u * 7u * 36u)

static void open(uint32_t cr1)
{
    I2C1->CR1 = 0;
    I2C1->TIMINGR = TIMING;
    I2C1->CR1 = cr1 | I2C_ANFOFF | I2C_PE;
}

static uint32_t cycles_to(uint32_t flag)
{
    uint32_t start = DWT->CYCCNT;
    while (!(I2C1->ISR & flag)) {
        if (DWT->CYCCNT - start > 10000000u)
            return 0xFFFFFFFFu;
    }
    return DWT->CYCCNT - start;
}

static void registers(void)
{
    check_equal("CR1", I2C1->CR1, 0);
    check_equal("CR2", I2C1->CR2, 0);
    check_equal("ISR", I2C1->ISR, I2C_TXE);
    I2C1->CR2 = 0xFFFFFFFFu;
    check_equal("no-START-without-PE", I2C1->CR2, 0x03FF1FFFu);
    I2C1->CR2 = 0;
    I2C1->TIMINGR = 0xFFFFFFFFu;
    check_equal("TIMINGR", I2C1->TIMINGR, 0xF0FFFFFFu);
}

static void nobody_answers(void)
{
    open(0);
    I2C1->CR2 = 0x50u << 1 | I2C_NBYTES(1) | I2C_START;
    uint32_t took = cycles_to(I2C_NACKF), then = I2C1->ISR, stop = cycles_to(I2C_STOPF);
    // START holds for t_SCLH, and nine clocks follow; 4 to 6 clocks of each are synchronisation
    check_range("address-takes-nine-clocks", took, 9u * SCL_CYCLES + 4u * 7u * 16u, 9u * (SCL_CYCLES + 32u) + 4u * 7u * 16u + 200u);
    check_equal("BUSY-until-STOP", then & (I2C_BUSY | I2C_STOPF), I2C_BUSY);
    check_equal("START-is-over", I2C1->CR2 & I2C_START, 0);
    check_range("STOP-by-itself", stop, SCL_CYCLES - 100u, SCL_CYCLES + 132u);
    check_equal("flags", I2C1->ISR, I2C_TXE | I2C_NACKF | I2C_STOPF);
    I2C1->ICR = I2C_NACKF;
    check_equal("NACKCF", I2C1->ISR, I2C_TXE | I2C_STOPF);
    I2C1->ICR = I2C_STOPF;
    check_equal("STOPCF", I2C1->ISR, I2C_TXE);
    I2C1->CR2 = 0x50u << 1 | I2C_READ | I2C_NBYTES(4) | I2C_AUTOEND | I2C_START;
    cycles_to(I2C_STOPF);
    check_equal("reading-too", I2C1->ISR, I2C_TXE | I2C_NACKF | I2C_STOPF);
    I2C1->ICR = I2C_NACKF | I2C_STOPF;
}

static void interrupts(void)
{
    forget(I2C1_EV_IRQ);
    open(I2C_STOPIE);
    I2C1->CR2 = 0x50u << 1 | I2C_START;
    cycles_to(I2C_NACKF);
    check("none-without-its-enable", !pending(I2C1_EV_IRQ));
    cycles_to(I2C_STOPF);
    wait_cycles(20);
    check("STOPIE", pending(I2C1_EV_IRQ));
    I2C1->ICR = I2C_NACKF | I2C_STOPF;
    forget(I2C1_EV_IRQ);
    check("level-falls-with-the-flag", !pending(I2C1_EV_IRQ));
    check("no-error", !pending(I2C1_ER_IRQ));
}

static void transmit_register(void)
{
    open(0);
    I2C1->TXDR = 0x55;
    check_equal("TXDR-is-full", I2C1->ISR & I2C_TXE, 0);
    I2C1->ISR = I2C_TXE;
    check_equal("TXE-flushes", I2C1->ISR & I2C_TXE, I2C_TXE);
}

static void software_reset(void)
{
    I2C1->CR2 = 0x50u << 1 | I2C_NBYTES(1) | I2C_START;
    wait_cycles(3 * SCL_CYCLES);
    check_equal("under-way", I2C1->ISR & I2C_BUSY, I2C_BUSY);
    I2C1->CR1 = 0;
    wait_cycles(100);
    check_equal("PE-breaks-off", I2C1->ISR, I2C_TXE);
    check_equal("and-clears-START", I2C1->CR2, 0x50u << 1 | I2C_NBYTES(1));
    check_equal("and-keeps-TIMINGR", I2C1->TIMINGR, TIMING);
}

int main(void)
{
    cycles_start();
    clock_start();
    RCC->AHB1ENR |= RCC_AHB1_GPIO('B');
    RCC->APB1ENR |= RCC_APB1_I2C1;
    for (unsigned pin = 8; pin <= 9; ++pin) {
        GPIO('B')->OTYPER |= 1u << pin;
        GPIO('B')->PUPDR |= 1u << 2 * pin;
        pin_alternate('B', pin, 4);
    }
    registers();
    nobody_answers();
    interrupts();
    transmit_register();
    software_reset();
    check_done();
}
