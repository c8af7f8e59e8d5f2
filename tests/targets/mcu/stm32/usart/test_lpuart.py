"""What the low-power UART of the STM32H7 has otherwise than a USART with FIFOs: its rate, and what it lacks."""

from __future__ import annotations

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.mcu.stm32.lpuart import LowPowerUart

UE, RE, TE, FIFOEN = 1 << 0, 1 << 2, 1 << 3, 1 << 29
TXE, TC, RXNE = 1 << 7, 1 << 6, 1 << 5


@pytest.fixture(scope="session")
def make_lpuart(make_fifo_port):
    class LowPowerPort(make_fifo_port):
        make_usart = LowPowerUart

    return LowPowerPort


def test_registers(make_lpuart):
    port = make_lpuart(name="LPUART1")
    assert port.flags == TXE | TC
    names = {register.name for register in port.usart.registers.values()}
    assert names == {"CR1", "CR2", "CR3", "BRR", "RQR", "ISR", "ICR", "RDR", "TDR", "PRESC"}
    for register, mask in (("CR1", 0xF3FF_7FFE), ("CR2", 0xFF0F_B010), ("CR3", 0xFEF0_F7C9), ("BRR", 0xF_FFFF)):
        port.poke(register, 0xFFFF_FFFE if register == "CR1" else 0xFFFF_FFFF)
        assert port.peek(register) == mask, register
    port.poke("CR1", 0)
    port.poke("CR1", FIFOEN)
    assert port.flags == 1 << 23 | TXE | TC


@given(brr=st.integers(0x300, 0xF_FFFF), kernel_hz=st.sampled_from([32_768, 4_000_000, 64_000_000, 120_000_000]))
def test_the_rate(make_lpuart, brr, kernel_hz):
    port = make_lpuart(kernel_hz=kernel_hz, name="LPUART1")
    port.poke("BRR", brr)
    assert port.usart.baud_hz == Fraction(256 * kernel_hz, brr)


def test_9600_baud_from_the_watch_crystal(make_lpuart):
    """256 times 32768 Hz by 0x36A is 9597.95 baud; the second word begins at the first cycle not before its time."""
    port = make_lpuart(kernel_hz=32_768, name="LPUART1")
    port.poke("BRR", 0x36A)
    port.poke("CR1", FIFOEN)
    port.poke("CR1", FIFOEN | UE | TE | RE)
    port.bits(15)
    assert float(port.usart.baud_hz) == pytest.approx(9597.95, abs=0.01)
    start = port.now
    port.poke("TDR", 0x55)
    port.poke("TDR", 0xAA)
    port.hear(0x5A)
    port.bits(12)
    assert port.values == [0x55, 0xAA]
    assert [cycle - start for cycle, _ in port.sent] == [
        0,
        -(-(10 * port.bit).numerator // (10 * port.bit).denominator),
    ]
    assert port.peek("RDR") == 0x5A


def test_a_brr_that_is_too_small_is_no_rate(make_lpuart):
    port = make_lpuart(name="LPUART1")
    port.poke("BRR", 0x2FF)
    port.poke("CR1", UE | TE | RE)
    assert port.usart.baud_hz == 0
    assert port.chip.noted("misuse") == ["LPUART1_BRR"]
