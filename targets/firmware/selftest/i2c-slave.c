// SPDX-License-Identifier: GPL-2.0-or-later
//
// I2C2 as a slave of I2C1, and as a master beside it (RM0008, sections 26.3.2, 26.3.4 to 26.3.8, 26.6), by two wires with
// pull-ups: PB6 to PB10 (SCL) and PB7 to PB11 (SDA). HCLK and PCLK1 are 8 MHz (HSI), SCL has 100 kHz.

#include "check.h"
#include "chip/dma.h"
#include "chip/i2c_smbus.h"
#include "chip/stm32f103.h"
#include "cycles.h"
#include "handlers.h"
#include "pin.h"
#include "wait.h"

#define OWN 0x21u
#define SECOND 0x35u
#define TEN 0x2A5u
#define TEN_HEADER (0xF0u | (TEN >> 7 & 6u))
#define CCR_100K 40u // 8 MHz / 100 kHz / 2
#define BYTE 720u    // nine clocks
#define MS 8000u

typedef volatile i2c_t *i2c_pointer;

static void set_up(i2c_pointer i2c, uint32_t cr1, uint32_t cr2)
{
    i2c->CR1 = I2C_CR1_SWRST;
    i2c->CR1 = 0;
    i2c->CR2 = 8 | cr2;
    i2c->CCR = CCR_100K;
    i2c->TRISE = 9;
    i2c->OAR1 = I2C_OAR1_ALWAYS;
    i2c->CR1 = I2C_CR1_PE;
    i2c->CR1 = I2C_CR1_PE | cr1;
}

// A master with these bits in CR1, and a slave with those, which has the address OWN.
static void set_up_both(uint32_t master, uint32_t slave)
{
    set_up(I2C1, master, 0);
    set_up(I2C2, slave, 0);
    I2C2->OAR1 = I2C_OAR1_ALWAYS | OWN << 1;
    I2C2->CR1 |= I2C_CR1_ACK;
}

static void clear_addr(i2c_pointer i2c)
{
    (void)i2c->SR1;
    (void)i2c->SR2;
}

static void clear_both(void)
{
    clear_addr(I2C1);
    clear_addr(I2C2);
}

// START and this byte: an address with its direction, or a header. Whether it was acknowledged.
static bool address(uint32_t byte)
{
    I2C1->CR1 |= I2C_CR1_START;
    wait_until(I2C1->SR1 & I2C_SR1_SB);
    I2C1->DR = byte;
    wait_until(I2C1->SR1 & (I2C_SR1_ADDR | I2C_SR1_ADD10 | I2C_SR1_AF));
    bool refused = I2C1->SR1 & I2C_SR1_AF;
    I2C1->SR1 = 0;
    return !refused;
}

static void stop(void)
{
    I2C1->CR1 |= I2C_CR1_STOP;
    wait_until(!(I2C1->SR2 & I2C_SR2_BUSY));
}

static void send(uint8_t byte)
{
    I2C1->DR = byte;
    wait_until(I2C1->SR1 & (I2C_SR1_BTF | I2C_SR1_AF));
}

static void end_slave(void)
{
    (void)I2C2->SR1;
    I2C2->CR1 |= I2C_CR1_PE;
    I2C2->SR1 = 0;
}

// --- The slave receives: EV1, EV2, EV4 (figure 241)

static void receiving(void)
{
    set_up_both(0, 0);
    I2C1->CR1 |= I2C_CR1_START;
    wait_until(I2C1->SR1 & I2C_SR1_SB);
    check_equal("a-start-makes-the-bus-busy", I2C2->SR2, I2C_SR2_BUSY);
    I2C1->DR = OWN << 1;
    wait_until(I2C1->SR1 & I2C_SR1_ADDR);
    check_equal("ev1", I2C2->SR1, I2C_SR1_ADDR);
    clear_addr(I2C1);
    I2C1->DR = 0x11;
    wait_cycles(3 * BYTE);
    check_equal("which-holds-scl", I2C1->SR1, I2C_SR1_TXE);
    (void)I2C2->SR1;
    uint32_t begin = cycles(), state = I2C2->SR2, flags = I2C2->SR1;
    wait_until(I2C2->SR1 & I2C_SR1_RXNE);
    uint32_t took = cycles() - begin;
    check_equal("a-slave-that-receives", state, I2C_SR2_BUSY);
    check_equal("sr1-and-sr2-clear-addr", flags, 0);
    check_range("nine-clocks-later-ev2", took, BYTE, BYTE + 50);
    check_equal("the-byte", I2C2->DR, 0x11);
    check_equal("dr-clears-rxne", I2C2->SR1, 0);
    send(0x22);
    send(0x33);
    check_equal("two-bytes-wait", I2C2->SR1, I2C_SR1_RXNE | I2C_SR1_BTF);
    I2C1->DR = 0x44;
    wait_cycles(3 * BYTE);
    check_equal("and-hold-scl", I2C1->SR1, I2C_SR1_TXE);
    check_equal("the-first", I2C2->DR, 0x22);
    check_equal("the-second", I2C2->DR, 0x33);
    wait_until(I2C2->SR1 & I2C_SR1_RXNE);
    check_equal("the-third", I2C2->DR, 0x44);
    stop();
    check_equal("ev4", I2C2->SR1, I2C_SR1_STOPF);
    check_equal("a-stop-frees-the-bus", I2C2->SR2, 0);
    I2C2->CR1 = I2C_CR1_PE | I2C_CR1_ACK;
    check_equal("sr1-and-cr1-clear-stopf", I2C2->SR1, 0);

    address(OWN << 1);
    clear_both();
    send(1);
    (void)I2C2->DR;
    address(OWN << 1);
    check_equal("a-repeated-start-is-no-stop", I2C2->SR1, I2C_SR1_ADDR);
    clear_both();
    I2C2->CR1 = I2C_CR1_PE;
    send(0x55);
    check_equal("without-ack-a-nack", I2C1->SR1 & I2C_SR1_AF, I2C_SR1_AF);
    check_equal("of-a-byte-all-the-same", I2C2->DR, 0x55);
    stop();
    check_equal("after-a-nack-no-stopf", I2C2->SR1, 0);
    I2C1->SR1 = 0;
    check("without-ack-no-address", !address(OWN << 1));
    check_equal("nor-addr", I2C2->SR1, 0);
    stop();
}

// --- The slave sends: EV1, EV3_1, EV3, EV3_2 (figure 240)

static void sending(void)
{
    set_up_both(I2C_CR1_ACK, 0);
    address(OWN << 1 | 1);
    check_equal("ev1-to-send", I2C2->SR1, I2C_SR1_ADDR);
    clear_addr(I2C1);
    (void)I2C2->SR1;
    check_equal("a-slave-that-sends", I2C2->SR2, I2C_SR2_BUSY | I2C_SR2_TRA);
    check_equal("ev3-1", I2C2->SR1, I2C_SR1_TXE);
    wait_cycles(3 * BYTE);
    check_equal("it-holds-scl", I2C1->SR1, 0);
    I2C2->DR = 0xA1;
    uint32_t first = I2C2->SR1;
    I2C2->DR = 0xA2;
    uint32_t second = I2C2->SR1;
    wait_until(I2C1->SR1 & I2C_SR1_RXNE);
    uint32_t byte = I2C1->DR, third = I2C2->SR1;
    check_equal("ev3", first, I2C_SR1_TXE);
    check_equal("dr-is-full", second, 0);
    check_equal("what-the-master-reads", byte, 0xA1);
    check_equal("dr-is-empty-again", third, I2C_SR1_TXE);
    wait_until(I2C2->SR1 & I2C_SR1_BTF);
    check_equal("all-is-sent", I2C2->SR1, I2C_SR1_TXE | I2C_SR1_BTF);
    check_equal("the-second-byte", I2C1->DR, 0xA2);
    I2C1->CR1 &= ~I2C_CR1_ACK;
    wait_cycles(3 * BYTE);
    check_equal("scl-is-held-again", I2C1->SR1, 0);
    I2C2->DR = 0xA3;
    I2C2->DR = 0xA4;
    wait_until(I2C1->SR1 & I2C_SR1_RXNE);
    check_equal("ev3-2", I2C2->SR1, I2C_SR1_AF);
    I2C2->SR1 = 0;
    check_equal("af-clears-by-0", I2C2->SR1, 0);
    stop();
    check_equal("the-last-byte", I2C1->DR, 0xA3);
    check_equal("no-stopf-then", I2C2->SR1, 0);
    check_equal("no-sender-any-more", I2C2->SR2, 0);
    address(OWN << 1 | 1);
    clear_both();
    check_equal("what-was-left-is-gone", I2C2->SR1, I2C_SR1_TXE);
    I2C2->DR = 0xB1;
    wait_until(I2C1->SR1 & I2C_SR1_RXNE);
    check_equal("the-next-message", I2C1->DR, 0xB1);
    stop();
}

// --- Addresses (26.3.2, 26.6.3, 26.6.4)

static void addresses(void)
{
    set_up_both(0, 0);
    check("another-address", !address((OWN + 1) << 1));
    check("the-second-one-unasked", !address(SECOND << 1));
    check("the-general-call-unasked", !address(0));
    stop();
    I2C2->OAR2 = SECOND << 1 | I2C_OAR2_ENDUAL;
    check("the-second-one", address(SECOND << 1));
    check_equal("dualf", I2C2->SR2 & I2C_SR2_DUALF, I2C_SR2_DUALF);
    clear_both();
    check("another-one-by-a-repeated-start", !address((OWN + 1) << 1));
    check_equal("ends-dualf", I2C2->SR2, I2C_SR2_BUSY);
    check("the-first-one-beside-it", address(OWN << 1));
    check_equal("no-dualf", I2C2->SR2 & I2C_SR2_DUALF, 0);
    clear_both();
    stop();
    end_slave();
    I2C2->CR1 |= I2C_CR1_ENGC;
    check("the-general-call", address(0));
    check_equal("gencall", I2C2->SR2 & I2C_SR2_GENCALL, I2C_SR2_GENCALL);
    clear_both();
    stop();
    check_equal("gencall-ends", I2C2->SR2, 0);
    end_slave();

    I2C2->OAR1 = I2C_OAR1_ADDMODE | I2C_OAR1_ALWAYS | TEN;
    check("no-seven-bits-then", !address((TEN & 0xFE)));
    check("another-header", !address(TEN_HEADER ^ 2));
    check("a-header", address(TEN_HEADER));
    check_equal("which-is-no-address", I2C2->SR1, 0);
    I2C1->DR = ~TEN & 0xFF;
    wait_until(I2C1->SR1 & I2C_SR1_AF);
    check_equal("another-second-byte", I2C2->SR1, 0);
    I2C1->SR1 = 0;
    check("no-sender-before-its-address", !address(TEN_HEADER | 1));
    address(TEN_HEADER);
    (void)I2C1->SR1;
    I2C1->DR = TEN & 0xFF;
    wait_until(I2C1->SR1 & I2C_SR1_ADDR);
    check_equal("all-ten-bits", I2C2->SR1, I2C_SR1_ADDR);
    check_equal("as-a-receiver", I2C2->SR2 & I2C_SR2_TRA, 0);
    clear_both();
    check("the-header-to-read", address(TEN_HEADER | 1));
    check_equal("as-a-sender", I2C2->SR2 & I2C_SR2_TRA, I2C_SR2_TRA);
    clear_both();
    I2C2->DR = 0x77;
    wait_until(I2C1->SR1 & I2C_SR1_RXNE);
    check_equal("what-it-sends", I2C1->DR, 0x77);
    stop();
}

static void addresses_of_smbus(void)
{
    set_up_both(0, I2C_CR1_ENARP);
    check("i2c-has-no-default", !address(0x61u << 1));
    stop();
    set_up_both(0, I2C_CR1_SMBUS | I2C_CR1_ENARP);
    check("the-default-of-a-device", address(0x61u << 1));
    check_equal("smbdefault", I2C2->SR2 & I2C_SR2_SMBDEFAULT, I2C_SR2_SMBDEFAULT);
    clear_both();
    check("a-device-is-no-host", !address(0x08u << 1));
    check("nobody-is-alert", !address(0x0Cu << 1 | 1));
    stop();
    end_slave();
    I2C2->CR1 |= I2C_CR1_ALERT;
    check("the-one-that-is", address(0x0Cu << 1 | 1));
    check_equal("is-told-so", I2C2->SR1, I2C_SR1_ADDR | I2C_SR1_SMBALERT);
    clear_both();
    I2C2->DR = OWN << 1;
    wait_until(I2C1->SR1 & I2C_SR1_RXNE);
    check_equal("and-says-who-it-is", I2C1->DR, OWN << 1);
    stop();
    set_up_both(0, I2C_CR1_SMBUS | I2C_CR1_SMBTYPE | I2C_CR1_ENARP);
    check("a-host", address(0x08u << 1));
    check_equal("smbhost", I2C2->SR2 & I2C_SR2_SMBHOST, I2C_SR2_SMBHOST);
    clear_both();
    stop();
}

// --- Without stretching (26.3.4, 26.3.5)

static void no_stretching(void)
{
    set_up_both(I2C_CR1_ACK, I2C_CR1_NOSTRETCH);
    address(OWN << 1);
    clear_addr(I2C1);
    send(0x11);
    check_equal("addr-holds-nothing", I2C2->SR1, I2C_SR1_ADDR | I2C_SR1_RXNE);
    clear_addr(I2C2);
    send(0x22);
    check_equal("an-overrun", I2C2->SR1, I2C_SR1_RXNE | I2C_SR1_OVR);
    check_equal("the-first-stays", I2C2->DR, 0x11);
    I2C2->SR1 = 0;
    send(0x33);
    check_equal("it-goes-on", I2C2->DR, 0x33);
    check_equal("without-ovr", I2C2->SR1, 0);
    address(OWN << 1 | 1);
    clear_addr(I2C2);
    I2C2->DR = 0xA1;
    clear_addr(I2C1);
    wait_until(I2C1->SR1 & I2C_SR1_BTF);
    check_equal("an-underrun", I2C2->SR1 & I2C_SR1_OVR, I2C_SR1_OVR);
    check_equal("no-btf", I2C2->SR1 & I2C_SR1_BTF, 0);
    I2C1->CR1 &= ~I2C_CR1_ACK;
    check_equal("a-byte", I2C1->DR, 0xA1);
    check_equal("the-same-again", I2C1->DR, 0xA1);
    wait_until(I2C1->SR1 & I2C_SR1_RXNE);
    stop();
}

// --- Packet error code (26.3.8)

static void packet_error_code(void)
{
    set_up_both(I2C_CR1_ENPEC, I2C_CR1_ENPEC);
    address(OWN << 1);
    clear_both();
    send(0x5A);
    (void)I2C2->DR;
    uint32_t both = I2C1->SR2 >> I2C_SR2_PEC_SHIFT;
    check_equal("both-count-the-same", I2C2->SR2 >> I2C_SR2_PEC_SHIFT, both);
    I2C2->CR1 |= I2C_CR1_PEC;
    I2C1->CR1 |= I2C_CR1_PEC;
    wait_until(I2C1->SR1 & I2C_SR1_BTF);
    check_equal("the-pec-is-right", I2C2->SR1, I2C_SR1_RXNE);
    check_equal("it-was-sent", I2C2->DR, both);
    check_equal("asked-for-once", (I2C1->CR1 | I2C2->CR1) & I2C_CR1_PEC, 0);
    stop();
    end_slave();

    address(OWN << 1);
    clear_both();
    send(0x5A);
    (void)I2C2->DR;
    I2C2->CR1 |= I2C_CR1_PEC;
    send((uint8_t)~both);
    check_equal("a-wrong-one", I2C2->SR1, I2C_SR1_RXNE | I2C_SR1_PECERR);
    check_equal("is-refused", I2C1->SR1 & I2C_SR1_AF, I2C_SR1_AF);
    stop();
    I2C1->SR1 = 0;
    I2C2->SR1 = 0;
    (void)I2C2->DR;

    I2C1->CR1 |= I2C_CR1_ACK;
    address(OWN << 1 | 1);
    clear_both();
    I2C2->DR = 0x3C;
    I2C2->CR1 |= I2C_CR1_PEC;
    wait_until(I2C1->SR1 & I2C_SR1_RXNE);
    I2C1->CR1 = (I2C1->CR1 & ~I2C_CR1_ACK) | I2C_CR1_PEC;
    uint32_t byte = I2C1->DR;
    wait_until(I2C1->SR1 & I2C_SR1_RXNE);
    check_equal("a-byte-of-the-slave", byte, 0x3C);
    check_equal("then-its-pec", I2C1->SR1, I2C_SR1_RXNE);
    check_equal("which-was-sent", I2C1->DR, I2C2->SR2 >> I2C_SR2_PEC_SHIFT);
    stop();
    I2C2->SR1 = 0;

    I2C1->CR1 |= I2C_CR1_ACK;
    address(OWN << 1 | 1);
    I2C1->CR1 |= I2C_CR1_PEC;
    clear_both();
    I2C2->DR = 0x3C;
    wait_until(I2C1->SR1 & I2C_SR1_RXNE);
    check_equal("what-is-none", I2C1->SR1, I2C_SR1_RXNE | I2C_SR1_PECERR);
    stop();
}

// --- By interrupts: a slave with eight registers

static volatile uint8_t registers[8];
static volatile uint32_t place, stops, refusals;
static volatile bool placed;

void I2C2_EV_IRQHandler(void)
{
    uint32_t status = I2C2->SR1;
    if (status & I2C_SR1_ADDR) {
        (void)I2C2->SR2;
        placed = false;
    }
    if (status & I2C_SR1_RXNE) {
        uint8_t byte = (uint8_t)I2C2->DR;
        if (placed)
            registers[place++ & 7] = byte;
        else
            place = byte;
        placed = true;
    } else if (status & I2C_SR1_TXE) {
        I2C2->DR = registers[place++ & 7];
    }
    if (status & I2C_SR1_STOPF) {
        I2C2->CR1 |= I2C_CR1_PE;
        ++stops;
    }
}

void I2C2_ER_IRQHandler(void)
{
    ++refusals;
    I2C2->SR1 = 0;
}

static void by_interrupts(void)
{
    set_up_both(0, 0);
    I2C2->CR2 |= I2C_CR2_ITEVTEN | I2C_CR2_ITBUFEN | I2C_CR2_ITERREN;
    irq_line_enable(I2C2_EV_IRQ);
    irq_line_enable(I2C2_ER_IRQ);
    address(OWN << 1);
    clear_addr(I2C1);
    for (uint32_t byte = 0; byte < 4; ++byte)
        send(byte ? (uint8_t)(0x10 * byte) : 3);
    stop();
    check_equal("registers-were-written", (uint32_t)(registers[3] << 16 | registers[4] << 8 | registers[5]), 0x102030);
    check_equal("a-stop-for-it", stops, 1);
    address(OWN << 1);
    clear_addr(I2C1);
    send(4);
    I2C1->CR1 |= I2C_CR1_POS | I2C_CR1_ACK;
    address(OWN << 1 | 1);
    clear_addr(I2C1);
    I2C1->CR1 &= ~I2C_CR1_ACK;
    wait_until(I2C1->SR1 & I2C_SR1_BTF);
    stop();
    check_equal("registers-are-read", I2C1->DR, 0x20);
    check_equal("one-after-the-other", I2C1->DR, 0x30);
    check_equal("the-end-was-refused", refusals, 1);
    check_equal("no-stop-for-that", stops, 1);
    irq_line_disable(I2C2_EV_IRQ);
    irq_line_disable(I2C2_ER_IRQ);
}

// --- By DMA on both sides, with the packet error code (26.3.7, 26.3.8)

static uint8_t out[4] = {0xC1, 0xC2, 0xC3, 0xC4}, in[5];

static void channel(uint32_t number, i2c_pointer i2c, uint8_t *memory, uint32_t count, uint32_t direction)
{
    DMA1_CHANNEL(number)->CCR = 0;
    DMA1_CHANNEL(number)->CPAR = (uint32_t)(uintptr_t)&i2c->DR;
    DMA1_CHANNEL(number)->CMAR = (uint32_t)(uintptr_t)memory;
    DMA1_CHANNEL(number)->CNDTR = count;
    DMA1_CHANNEL(number)->CCR = DMA_CCR_EN | DMA_CCR_MINC | direction;
}

static void check_bytes(const char *all, const char *pec)
{
    bool equal = true;
    for (uint32_t byte = 0; byte < sizeof out; ++byte)
        equal = equal && in[byte] == out[byte];
    check(all, equal);
    check_equal(pec, in[4], I2C2->SR2 >> I2C_SR2_PEC_SHIFT);
    for (uint32_t byte = 0; byte < sizeof in; ++byte)
        in[byte] = 0;
}

static void by_dma(void)
{
    set_up_both(I2C_CR1_ENPEC, I2C_CR1_ENPEC);
    I2C1->CR2 |= I2C_CR2_DMAEN;
    I2C2->CR2 |= I2C_CR2_DMAEN;
    channel(DMA_I2C1_TX, I2C1, out, sizeof out, DMA_CCR_FROM_MEMORY);
    channel(DMA_I2C2_RX, I2C2, in, sizeof in, 0);
    address(OWN << 1);
    clear_both();
    wait_until(!DMA1_CHANNEL(DMA_I2C2_RX)->CNDTR);
    wait_until(I2C1->SR1 & I2C_SR1_BTF);
    check_equal("the-slave-found-no-error", I2C2->SR1, 0);
    stop();
    check_bytes("what-it-received", "and-the-pec");
    end_slave();

    I2C1->CR2 |= I2C_CR2_LAST;
    channel(DMA_I2C2_TX, I2C2, out, sizeof out, DMA_CCR_FROM_MEMORY);
    channel(DMA_I2C1_RX, I2C1, in, sizeof in, 0);
    I2C1->CR1 |= I2C_CR1_ACK;
    address(OWN << 1 | 1);
    clear_both();
    wait_until(!DMA1_CHANNEL(DMA_I2C1_RX)->CNDTR);
    check_equal("the-master-found-no-error", I2C1->SR1, 0);
    check_equal("and-refused-the-last", I2C2->SR1 & I2C_SR1_AF, I2C_SR1_AF);
    stop();
    check_bytes("what-it-sent", "with-its-pec");
}

// --- A slave that takes too long (26.6.6), and one that becomes a master (26.3.1)

static void timeouts(void)
{
    set_up_both(0, I2C_CR1_SMBUS);
    address(OWN << 1);
    clear_addr(I2C1);
    uint32_t begin = cycles();
    I2C1->DR = 1;
    wait_until(I2C2->SR1 & I2C_SR1_TIMEOUT);
    check_range("a-slave-has-25-ms", cycles() - begin, 25 * MS - 1000, 25 * MS + 100);
    check("then-it-lets-go", wait_until(I2C1->SR1 & I2C_SR1_AF));
    check_equal("and-forgets-its-address", I2C2->SR1, I2C_SR1_TIMEOUT);
    stop();

    I2C1->SR1 = 0;
    I2C2->SR1 = 0;
    address(OWN << 1);
    begin = cycles();
    clear_addr(I2C2);
    wait_until(I2C2->SR1 & I2C_SR1_TIMEOUT);
    check_range("so-has-a-master", cycles() - begin, 25 * MS - 1000, 25 * MS + 100);
    clear_addr(I2C1);
    send(1);
    check_equal("then-the-slave-is-gone", I2C1->SR1 & I2C_SR1_AF, I2C_SR1_AF);
    stop();
}

static void roles(void)
{
    set_up_both(0, 0);
    I2C1->OAR1 = I2C_OAR1_ALWAYS | SECOND << 1;
    I2C1->CR1 |= I2C_CR1_ACK;
    address(OWN << 1);
    I2C2->CR1 |= I2C_CR1_START;
    clear_both();
    wait_cycles(3 * BYTE);
    check_equal("start-waits", I2C2->SR1, 0);
    stop();
    check("for-the-stop", wait_until(I2C2->SR1 & I2C_SR1_SB));
    check_equal("master-now", I2C2->SR2, I2C_SR2_MSL | I2C_SR2_BUSY);
    check_equal("slave-now", I2C1->SR2, I2C_SR2_BUSY);
    (void)I2C2->SR1;
    I2C2->DR = SECOND << 1;
    wait_until(I2C2->SR1 & I2C_SR1_ADDR);
    check_equal("its-address", I2C1->SR1, I2C_SR1_ADDR);
    clear_both();
    I2C2->DR = 0x99;
    wait_until(I2C1->SR1 & I2C_SR1_RXNE);
    check_equal("its-byte", I2C1->DR, 0x99);
    I2C1->CR1 = 0;
    check_equal("busy-without-pe", I2C1->SR2, I2C_SR2_BUSY);
    I2C1->CR1 = I2C_CR1_PE;
    I2C1->CR1 = I2C_CR1_PE | I2C_CR1_ACK;
    I2C2->CR1 |= I2C_CR1_START;
    wait_until(I2C2->SR1 & I2C_SR1_SB);
    I2C2->DR = SECOND << 1;
    wait_until(I2C2->SR1 & I2C_SR1_ADDR);
    clear_both();
    I2C2->CR1 |= I2C_CR1_STOP;
    check("its-stop", wait_until(I2C1->SR1 & I2C_SR1_STOPF));
    check_equal("the-bus-is-free", I2C1->SR2 | I2C2->SR2, 0);
}

// --- Two masters at once (26.3.4): a START of both waits for the same STOP, and then for the same t_BUF

static void start_both(uint32_t second_cr2)
{
    set_up_both(0, 0);
    I2C2->CR2 |= second_cr2;
    address(OWN << 1);
    clear_both();
    I2C2->CR1 |= I2C_CR1_START;
    I2C1->CR1 |= I2C_CR1_START | I2C_CR1_STOP;
    wait_until(I2C1->SR1 & I2C_SR1_SB);
    wait_until(I2C2->SR1 & I2C_SR1_SB);
    I2C2->CR1 |= I2C_CR1_PE;
}

static void arbitration(void)
{
    start_both(0);
    check_equal("a-master", I2C1->SR2, I2C_SR2_MSL | I2C_SR2_BUSY);
    check_equal("and-another", I2C2->SR2, I2C_SR2_MSL | I2C_SR2_BUSY);
    I2C1->DR = 0x60;
    wait_cycles(3 * BYTE);
    check_equal("one-waits-for-the-other", I2C1->SR1, 0);
    uint32_t begin = cycles();
    I2C2->DR = 0x62;
    wait_until(I2C2->SR1 & I2C_SR1_ARLO);
    uint32_t took = cycles() - begin;
    check_range("the-seventh-bit-differs", took, 6 * 80 + 40, 7 * 80 + 20);
    check_equal("who-lets-sda-go-has-lost", I2C2->SR1, I2C_SR1_ARLO);
    check_equal("and-is-a-slave", I2C2->SR2, I2C_SR2_BUSY);
    wait_until(I2C1->SR1 & I2C_SR1_AF);
    check_equal("the-other-goes-on", I2C1->SR2 & I2C_SR2_MSL, I2C_SR2_MSL);
    I2C1->SR1 = 0;
    check("a-repeated-start", address(OWN << 1));
    check_equal("is-heard-by-the-loser", I2C2->SR1, I2C_SR1_ARLO | I2C_SR1_ADDR);
    clear_both();
    stop();

    start_both(I2C_CR2_ITERREN);
    irq_line_enable(I2C2_ER_IRQ);
    refusals = 0;
    I2C1->DR = OWN << 1;
    I2C2->DR = (OWN + 1) << 1;
    wait_until(I2C1->SR1 & (I2C_SR1_AF | I2C_SR1_ADDR));
    irq_line_disable(I2C2_ER_IRQ);
    check_equal("not-in-the-same-transfer", I2C1->SR1, I2C_SR1_AF);
    check_equal("an-error-interrupt", refusals, 1);
    stop();

    start_both(0);
    I2C1->DR = 0x62;
    I2C2->DR = 0x60;
    wait_until(I2C2->SR1 & I2C_SR1_AF);
    check_equal("the-other-way-round", I2C1->SR1, I2C_SR1_ARLO);
    I2C2->CR1 |= I2C_CR1_STOP;
    check("the-winner-stops", wait_until(!(I2C1->SR2 & I2C_SR2_BUSY)));

    start_both(0);
    I2C1->DR = 0x60;
    I2C2->DR = 0x60;
    wait_until(I2C1->SR1 & I2C_SR1_AF);
    wait_until(I2C2->SR1 & I2C_SR1_AF);
    check_equal("both-the-same", (I2C1->SR1 | I2C2->SR1) & I2C_SR1_ARLO, 0);
    I2C1->CR1 |= I2C_CR1_STOP;
    I2C2->CR1 |= I2C_CR1_STOP;
    check("both-stop", wait_until(!((I2C1->SR2 | I2C2->SR2) & I2C_SR2_BUSY)));
}

int main(void)
{
    cycles_start();
    RCC->AHBENR |= RCC_AHB_DMA1;
    RCC->APB1ENR |= RCC_APB1_I2C1 | RCC_APB1_I2C2;
    RCC->APB2ENR |= RCC_APB2_AFIO | RCC_APB2_GPIOB;
    for (unsigned pin = 6; pin < 12; pin += pin == 7 ? 3 : 1)
        pin_mode(GPIOB, pin, PIN_ALTERNATE_OPEN_DRAIN);
    receiving();
    sending();
    addresses();
    addresses_of_smbus();
    no_stretching();
    packet_error_code();
    by_interrupts();
    by_dma();
    timeouts();
    roles();
    arbitration();
    check_done();
}
