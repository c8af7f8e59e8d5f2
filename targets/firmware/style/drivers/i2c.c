// SPDX-License-Identifier: GPL-2.0-or-later
//
// A master by interrupts (RM0008, section 26): short messages byte by byte, whose last ones are read after BTF, two at once;
// long ones by DMA. A message without STOP is followed by the next one from within the handler, which the BTF that is
// still set calls again until the START is there. The thread waits for a semaphore.

#include "chip/i2c.h"

#include "chip/stm32f103.h"
#include "device.h"

#define BY_DMA 16u // bytes, at least
#define LIMIT_MS 100
#define INTERRUPTS (I2C_CR2_ITEVTEN | I2C_CR2_ITBUFEN | I2C_CR2_ITERREN)

static struct {
    struct sem lock, done;
    struct i2c_message *message, *end;
    uint8_t *at, address;
    uint32_t left;
    bool restarting;
    int result;
} state;

static bool reading(void) { return state.message->flags & I2C_READ; }

static bool by_dma(void) { return state.message->count >= BY_DMA; }

static void finish(int result)
{
    I2C1->CR2 &= ~(INTERRUPTS | I2C_CR2_DMAEN | I2C_CR2_LAST);
    state.result = result;
    sem_give(&state.done);
}

static void begin_message(void)
{
    state.at = state.message->data;
    state.left = state.message->count;
    I2C1->CR1 = (I2C1->CR1 & ~I2C_CR1_POS) | I2C_CR1_ACK | I2C_CR1_START;
}

static void message_over(void)
{
    if (++state.message == state.end)
        finish(0);
    else {
        state.restarting = true;
        begin_message();
    }
}

static void stop(void) { I2C1->CR1 |= I2C_CR1_STOP; }

static void start_dma(void)
{
    unsigned number = reading() ? DMA_I2C1_RX : DMA_I2C1_TX;
    volatile dma_channel_t *channel = DMA1_CHANNEL(number);
    channel->CCR = 0;
    channel->CPAR = (uint32_t)(uintptr_t)&I2C1->DR;
    channel->CMAR = (uint32_t)(uintptr_t)state.at;
    channel->CNDTR = state.left;
    channel->CCR = DMA_CCR_MINC | DMA_CCR_TCIE | DMA_CCR_TEIE | (reading() ? 0 : DMA_CCR_FROM_MEMORY) | DMA_CCR_EN;
    I2C1->CR2 = (I2C1->CR2 & ~(I2C_CR2_ITEVTEN | I2C_CR2_ITBUFEN)) | I2C_CR2_DMAEN | (reading() ? I2C_CR2_LAST : 0);
}

static void dma_isr(const void *argument)
{
    unsigned number = (unsigned)(uintptr_t)argument;
    uint32_t flags = DMA1->ISR;
    DMA1->IFCR = DMA_GIF(number);
    DMA1_CHANNEL(number)->CCR = 0;
    I2C1->CR2 &= ~(I2C_CR2_DMAEN | I2C_CR2_LAST);
    if (flags & DMA_TEIF(number)) {
        stop();
        finish(E_IO);
    } else if (reading()) {
        stop();
        message_over();
    } else {
        state.left = 0;
        I2C1->CR2 |= I2C_CR2_ITEVTEN; // BTF is still to come
    }
}

// To refuse the second byte of two, ACK is cleared after ADDR (RM0008, 26.6.1, POS).
static void addressed(void)
{
    bool few = reading() && !by_dma();
    if (by_dma())
        start_dma();
    else if (!reading() || state.left == 1 || state.left > 3)
        I2C1->CR2 |= I2C_CR2_ITBUFEN;
    if (few && state.left == 2)
        I2C1->CR1 |= I2C_CR1_POS;
    else if (few && state.left == 1)
        I2C1->CR1 &= ~I2C_CR1_ACK;
    (void)I2C1->SR2;
    if (few && state.left == 2)
        I2C1->CR1 &= ~I2C_CR1_ACK;
    else if (few && state.left == 1)
        stop();
}

static void take(void)
{
    *state.at++ = (uint8_t)I2C1->DR;
    --state.left;
}

static void received(bool two)
{
    if (two && state.left == 2) {
        stop();
        take();
        take();
        message_over();
    } else if (two && state.left == 3) {
        I2C1->CR1 &= ~I2C_CR1_ACK;
        take();
    } else {
        take();
        if (state.left == 3)
            I2C1->CR2 &= ~I2C_CR2_ITBUFEN;
        else if (!state.left)
            message_over();
    }
}

static void can_send(bool sent)
{
    if (state.left) {
        I2C1->DR = *state.at++;
        if (!--state.left)
            I2C1->CR2 &= ~I2C_CR2_ITBUFEN;
    } else if (sent) {
        if (state.message->flags & I2C_STOP)
            stop();
        message_over();
    }
}

static void event_isr(const void *argument)
{
    (void)argument;
    uint32_t status = I2C1->SR1;
    if (status & I2C_SR1_SB) {
        state.restarting = false;
        I2C1->DR = (uint32_t)state.address << 1 | reading();
    } else if (status & I2C_SR1_ADDR)
        addressed();
    else if (state.restarting)
        return;
    else if (reading()) {
        if (status & I2C_SR1_RXNE)
            received(status & I2C_SR1_BTF);
    } else if (status & I2C_SR1_TXE)
        can_send(status & I2C_SR1_BTF);
}

static void error_isr(const void *argument)
{
    (void)argument;
    I2C1->SR1 = 0;
    stop();
    finish(E_IO);
}

static void set_up(void)
{
    I2C1->CR1 = I2C_CR1_SWRST;
    I2C1->CR1 = 0;
    I2C1->CR2 = 36;
    I2C1->CCR = I2C_CCR_FAST | 30;
    I2C1->TRISE = 36 * 300 / 1000 + 1;
    I2C1->CR1 = I2C_CR1_PE;
}

static int transfer(const struct device *device, struct i2c_message *messages, uint32_t count, uint8_t address)
{
    (void)device;
    sem_take(&state.lock, FOREVER);
    state.message = messages;
    state.end = messages + count;
    state.address = address;
    begin_message();
    I2C1->CR2 |= I2C_CR2_ITEVTEN | I2C_CR2_ITERREN;
    int result = sem_take(&state.done, LIMIT_MS);
    if (result)
        set_up();
    else
        result = state.result;
    while (I2C1->CR1 & I2C_CR1_STOP) {
    }
    sem_give(&state.lock);
    return result;
}

const struct i2c_api i2c_stm32 = {transfer};

int i2c_stm32_init(const struct device *device)
{
    (void)device;
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB1ENR |= RCC_APB1_I2C1;
    state.lock = SEM(1, 1);
    state.done = SEM(0, 1);
    set_up();
    irq_connect(I2C1_EV_IRQ, event_isr, 0);
    irq_connect(I2C1_ER_IRQ, error_isr, 0);
    irq_connect(DMA1_CHANNEL1_IRQ + DMA_I2C1_TX - 1, dma_isr, (const void *)DMA_I2C1_TX);
    irq_connect(DMA1_CHANNEL1_IRQ + DMA_I2C1_RX - 1, dma_isr, (const void *)DMA_I2C1_RX);
    return 0;
}
