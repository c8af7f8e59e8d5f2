// SPDX-License-Identifier: GPL-2.0-or-later
//
// A master by interrupts (RM0008, section 25): TXE asks for the first word, each one that comes in for the next, so that no
// handler can be too late. It leaves chip select and callback to the thread of works. Between two commands SPE is 0.

#include "chip/spi.h"

#include "chip/stm32f103.h"
#include "device.h"

static struct {
    struct work work; // first: the work is the state
    const struct device *device;
    struct spi_transfer transfer;
    uint32_t sent, received;
    spi_callback *callback;
    void *argument;
} state;

struct config {
    const char *gpio;
    uint32_t select;
};

static void set_select(const struct device *device, bool level)
{
    const struct config *config = device->config;
    const struct device *gpio = device_get(config->gpio);
    ((const struct gpio_api *)gpio->api)->set(gpio, config->select, level);
}

static void completed(struct work *work)
{
    (void)work;
    while (SPI1->SR & SPI_SR_BSY) {
    }
    if (!state.transfer.keep) {
        SPI1->CR1 &= ~SPI_CR1_SPE;
        set_select(state.device, true);
    }
    state.callback(state.device, 0, state.argument);
}

static void send_next(void) { SPI1->DR = state.transfer.out ? state.transfer.out[state.sent++] : 0xFF; }

static void isr(const void *argument)
{
    (void)argument;
    uint32_t status = SPI1->SR;
    if (status & SPI_SR_RXNE) {
        uint8_t byte = (uint8_t)SPI1->DR;
        if (state.transfer.in)
            state.transfer.in[state.received] = byte;
        if (++state.received < state.transfer.count) {
            send_next();
        } else {
            SPI1->CR2 = 0;
            work_submit(&state.work);
        }
    } else if (status & SPI_SR_TXE) {
        SPI1->CR2 &= ~SPI_CR2_TXEIE;
        send_next();
    }
}

static int transceive(const struct device *device, const struct spi_transfer *transfer, spi_callback *callback, void *argument)
{
    state.device = device;
    state.transfer = *transfer;
    state.sent = state.received = 0;
    state.callback = callback;
    state.argument = argument;
    set_select(device, false);
    SPI1->CR1 |= SPI_CR1_SPE;
    SPI1->CR2 = SPI_CR2_RXNEIE | SPI_CR2_TXEIE;
    return 0;
}

const struct spi_api spi_stm32 = {transceive};

int spi_stm32_init(const struct device *device)
{
    RCC->APB2ENR |= RCC_APB2_SPI1;
    state.work.handler = completed;
    set_select(device, true);
    SPI1->CR1 = SPI_CR1_MSTR | SPI_CR1_SSM | SPI_CR1_SSI | 2u << SPI_CR1_BR_SHIFT; // 9 MHz
    irq_connect(SPI1_IRQ, isr, 0);
    return 0;
}
