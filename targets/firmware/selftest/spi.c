// SPDX-License-Identifier: GPL-2.0-or-later
//
// SPI1 (RM0008, section 25) as a master to which nothing is attached: what it receives is what the pull of PA6 (MISO) says.
// PA4 to PA7 must be free. HCLK and PCLK2 are 8 MHz (HSI).

#include "check.h"
#include "chip/spi.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "handlers.h"
#include "pin.h"
#include "wait.h"

#define NSS 4
#define SCK 5
#define MISO 6
#define MOSI 7
#define BY_SOFTWARE (SPI_CR1_SSM | SPI_CR1_SSI)
#define MASTER (SPI_CR1_MSTR | BY_SOFTWARE)

static volatile uint32_t interrupts;
static volatile uint32_t seen;

void SPI1_IRQHandler(void)
{
    ++interrupts;
    seen = SPI1->SR;
    SPI1->CR2 = 0;
}

static void restart(uint32_t cr1)
{
    RCC->APB2RSTR = RCC_APB2_SPI1;
    RCC->APB2RSTR = 0;
    SPI1->CR1 = cr1;
    SPI1->CR1 = cr1 | SPI_CR1_SPE;
}

static uint32_t transfer(uint32_t word)
{
    SPI1->DR = word;
    return wait_until(SPI1->SR & SPI_SR_RXNE) ? SPI1->DR : 0xDEAD;
}

static uint32_t taken(uint32_t cr1)
{
    restart(MASTER | cr1);
    uint32_t start = cycles();
    SPI1->DR = 0x5A;
    wait_until(!(SPI1->SR & SPI_SR_BSY));
    return cycles() - start;
}

// --- Words (25.3.1 to 25.3.5)

static void words(void)
{
    check_equal("sr-reset", SPI1->SR, SPI_SR_TXE);
    check_equal("crcpr-reset", SPI1->CRCPR, 7);
    restart(MASTER);
    check_equal("idle-with-spe", SPI1->SR, SPI_SR_TXE);
    pin_pull(GPIOA, MISO, true);
    check_equal("ones-of-a-pull-up", transfer(0x5A), 0xFF);
    pin_pull(GPIOA, MISO, false);
    check_equal("zeros-of-a-pull-down", transfer(0x5A), 0);
    check_equal("dr-clears-rxne", SPI1->SR, SPI_SR_TXE);
    restart(MASTER | 7u << SPI_CR1_BR_SHIFT);
    SPI1->DR = 1;
    check_equal("the-first-goes-at-once", SPI1->SR, SPI_SR_TXE | SPI_SR_BSY);
    SPI1->DR = 2;
    check_equal("the-second-waits", SPI1->SR, SPI_SR_BSY);
    check("txe-when-the-first-is-through", wait_until(SPI1->SR & SPI_SR_TXE));
    check_equal("with-it-rxne", SPI1->SR & SPI_SR_RXNE, SPI_SR_RXNE);
    (void)SPI1->DR;
    wait_until(!(SPI1->SR & SPI_SR_BSY));
    pin_pull(GPIOA, MISO, true);
    restart(MASTER | SPI_CR1_DFF);
    check_equal("sixteen-bits", transfer(0x1234), 0xFFFF);

    uint32_t fast = taken(0), slow = taken(7u << SPI_CR1_BR_SHIFT), wide = taken(SPI_CR1_DFF | 7u << SPI_CR1_BR_SHIFT);
    check_range("8-clocks-of-pclk-by-2", fast, 16, 60);
    check_range("8-clocks-of-pclk-by-256", slow, 2048, 2048 + 40);
    check_range("16-clocks-of-pclk-by-256", wide, 4096, 4096 + 40);

    restart(MASTER | SPI_CR1_CPOL);
    check("cpol-is-the-idle-level", pin_read(GPIOA, SCK));
    restart(MASTER);
    check("and-low-without", !pin_read(GPIOA, SCK));
    transfer(0xFE);
    check("mosi-keeps-the-last-bit", !pin_read(GPIOA, MOSI));
    transfer(0x01);
    check("of-each-word", pin_read(GPIOA, MOSI));
    restart(MASTER | SPI_CR1_LSBFIRST);
    transfer(0x01);
    check("lsb-first", !pin_read(GPIOA, MOSI));

    restart(MASTER | SPI_CR1_RXONLY | 5u << SPI_CR1_BR_SHIFT);
    bool first = wait_until(SPI1->SR & SPI_SR_RXNE);
    (void)SPI1->DR;
    bool second = wait_until(SPI1->SR & SPI_SR_RXNE);
    SPI1->CR1 &= ~SPI_CR1_SPE;
    (void)SPI1->DR;
    bool third = wait_until(SPI1->SR & SPI_SR_RXNE);
    (void)SPI1->DR;
    wait_cycles(2000);
    check("receive-only-goes-on", first && second && third);
    check("until-spe-falls", !(SPI1->SR & (SPI_SR_RXNE | SPI_SR_BSY)));

    restart(MASTER | SPI_CR1_BIDIMODE | SPI_CR1_BIDIOE);
    SPI1->DR = 0x55;
    wait_until(!(SPI1->SR & SPI_SR_BSY));
    check_equal("one-wire-out-receives-nothing", SPI1->SR, SPI_SR_TXE);
}

// --- Errors (25.3.10)

static void errors(void)
{
    pin_pull(GPIOA, MISO, false);
    restart(MASTER);
    SPI1->DR = 1;
    wait_until(!(SPI1->SR & SPI_SR_BSY));
    pin_pull(GPIOA, MISO, true);
    SPI1->DR = 2;
    wait_until(!(SPI1->SR & SPI_SR_BSY));
    check_equal("overrun", SPI1->SR, SPI_SR_TXE | SPI_SR_RXNE | SPI_SR_OVR);
    check_equal("sr-alone-keeps-it", SPI1->SR & SPI_SR_OVR, SPI_SR_OVR);
    check_equal("dr-has-the-first", SPI1->DR, 0);
    (void)SPI1->SR;
    check_equal("dr-and-sr-end-it", SPI1->SR, SPI_SR_TXE);

    restart(MASTER);
    SPI1->CR1 = SPI_CR1_MSTR | SPI_CR1_SSM | SPI_CR1_SPE;
    check_equal("mode-fault-by-ssi", SPI1->CR1 & (SPI_CR1_SPE | SPI_CR1_MSTR), 0);
    SPI1->CR1 = MASTER | SPI_CR1_SPE;
    check_equal("it-holds-the-bits", SPI1->CR1 & (SPI_CR1_SPE | SPI_CR1_MSTR), 0);
    check("modf-is-set", SPI1->SR & SPI_SR_MODF);
    SPI1->CR1 = MASTER | SPI_CR1_SPE;
    check_equal("sr-and-cr1-end-it", SPI1->SR & SPI_SR_MODF, 0);
    check("and-let-it-be-master", SPI1->CR1 & SPI_CR1_SPE);

    pin_pull(GPIOA, NSS, true);
    restart(SPI_CR1_MSTR);
    check("nss-high-is-no-fault", !(SPI1->SR & SPI_SR_MODF));
    pin_pull(GPIOA, NSS, false);
    check("nss-low-is-one", SPI1->SR & SPI_SR_MODF);
    pin_pull(GPIOA, NSS, true);

    RCC->APB2RSTR = RCC_APB2_SPI1;
    RCC->APB2RSTR = 0;
    pin_mode(GPIOA, NSS, PIN_ALTERNATE);
    SPI1->CR2 = SPI_CR2_SSOE;
    SPI1->CR1 = SPI_CR1_MSTR | SPI_CR1_SPE;
    check("ssoe-pulls-nss-low", !pin_read(GPIOA, NSS));
    check("which-is-no-fault", !(SPI1->SR & SPI_SR_MODF));
    pin_pull(GPIOA, NSS, true);
}

// --- CRC (25.3.6)

static void crc(void)
{
    pin_pull(GPIOA, MISO, true);
    restart(MASTER | SPI_CR1_CRCEN);
    transfer(0x31);
    SPI1->DR = 0x32;
    SPI1->CR1 |= SPI_CR1_CRCNEXT;
    wait_until(SPI1->SR & SPI_SR_RXNE);
    (void)SPI1->DR;
    check_equal("tx-crc", SPI1->TXCRCR, 0x72); // CRC-8 of "12"
    check_equal("rx-crc-of-two-ff", SPI1->RXCRCR, 0x24);
    check("the-crc-follows", wait_until(SPI1->SR & SPI_SR_RXNE));
    check("what-came-in-is-none", SPI1->SR & SPI_SR_CRCERR);
    SPI1->SR = 0;
    check("crcerr-clears-by-0", !(SPI1->SR & SPI_SR_CRCERR));
    SPI1->CR1 = MASTER;
    check_equal("without-crcen-they-are-0", SPI1->TXCRCR | SPI1->RXCRCR, 0);
}

// --- Interrupts, DMA (25.3.9)

static uint32_t interrupt_of(uint32_t enable, bool send)
{
    restart(MASTER);
    if (send)
        transfer(0x11);
    interrupts = 0;
    irq_line_enable(SPI1_IRQ);
    SPI1->CR2 = enable;
    if (send)
        SPI1->DR = 0x22;
    wait_cycles(100);
    irq_line_disable(SPI1_IRQ);
    irq_unpend(SPI1_IRQ);
    SPI1->CR2 = 0;
    return interrupts;
}

static uint8_t out[4] = {1, 2, 3, 4}, in[4];

static void lines(void)
{
    check_equal("txeie", interrupt_of(SPI_CR2_TXEIE, false), 1);
    check_equal("rxneie-without-a-word", interrupt_of(SPI_CR2_RXNEIE, false), 0);
    check_equal("rxneie", interrupt_of(SPI_CR2_RXNEIE, true), 1);
    check("rxne-was-set", seen & SPI_SR_RXNE);

    restart(MASTER);
    pin_pull(GPIOA, MISO, true);
    for (unsigned way = 0; way < 2; ++way) {
        volatile dma_channel_t *channel = DMA1_CHANNEL(way ? DMA_SPI1_TX : DMA_SPI1_RX);
        channel->CCR = 0;
        channel->CPAR = (uint32_t)(uintptr_t)&SPI1->DR;
        channel->CMAR = (uint32_t)(uintptr_t)(way ? out : in);
        channel->CNDTR = 4;
        channel->CCR = DMA_CCR_MINC | (way ? DMA_CCR_FROM_MEMORY : 0) | DMA_CCR_EN;
    }
    SPI1->CR2 = SPI_CR2_RXDMAEN | SPI_CR2_TXDMAEN;
    check("dma-both-ways", wait_until(DMA1->ISR & DMA_TCIF(DMA_SPI1_RX)) && (DMA1->ISR & DMA_TCIF(DMA_SPI1_TX)));
    check_equal("four-bytes-came", in[0] & in[1] & in[2] & in[3], 0xFF);
    check("none-was-lost", !(SPI1->SR & SPI_SR_OVR));
    SPI1->CR2 = 0;
}

int main(void)
{
    cycles_start();
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOA | RCC_APB2_SPI1;
    pin_pull(GPIOA, NSS, true);
    pin_mode(GPIOA, SCK, PIN_ALTERNATE);
    pin_pull(GPIOA, MISO, true);
    pin_mode(GPIOA, MOSI, PIN_ALTERNATE);
    words();
    errors();
    crc();
    lines();
    check_done();
}
