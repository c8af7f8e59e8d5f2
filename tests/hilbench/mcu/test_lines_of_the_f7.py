"""Serial lines of a chip whose USARTs have ISR and ICR, by the same ports as those of the F1."""

from __future__ import annotations

from fractions import Fraction

import pytest

from hilbench.mcu.emulated import EmulatedBench
from targets.mcu.stm32.usart import Usart
from targets.mcu.testing import peek, poke

KERNEL_HZ = 54_000_000
UE_TE_RE, RXNEIE, OVER8, M0, PCE = 0xD, 1 << 5, 1 << 15, 1 << 12, 1 << 10


@pytest.fixture
def emulate_f7(bench_file, fake_maker):
    """Build a bench whose board has USART1 with the registers of the F7."""
    opened = []

    def build(program, **options):
        maker = fake_maker(program)

        def make_machine(board, image):
            machine = maker(board, image)
            machine.chip.usarts["USART1"] = machine.fake.add(
                Usart("USART1", 0x4001_1000, machine.fake.services, irq=37, kernel_hz=lambda: Fraction(KERNEL_HZ))
            )
            return machine

        emulated = EmulatedBench(bench_file(), make_machine=make_machine, **options)
        opened.append(emulated)
        return emulated

    yield build
    for emulated in opened:
        emulated.close()


def echo(machine, brr, cr1=0):
    """Send back what comes in, from the interrupt."""
    usart = machine.chip.usarts["USART1"]

    def interrupted(level):
        while level and peek(usart, "ISR") & 0x20:
            poke(usart, "TDR", peek(usart, "RDR"))

    machine.fake.irq(37).on_set = interrupted
    poke(usart, "BRR", brr)
    poke(usart, "CR1", cr1)
    poke(usart, "CR1", cr1 | UE_TE_RE | RXNEIE)


@pytest.mark.parametrize(
    ("brr", "cr1", "baud", "form"),
    [(469, 0, 115_200, "8N1"), (0x753, OVER8, 57_600, "8N1"), (1406, M0 | PCE, 38_400, "8E1")],
)
def test_an_echo(emulate_f7, brr, cr1, baud, form):
    emulated = emulate_f7(lambda machine: echo(machine, brr, cr1))
    port = emulated.ports["brain.usart1"]
    heard = bytearray()
    port.on_receive = lambda data, _at_ns: heard.extend(data)
    emulated.bench.run_for(0.01)
    assert port.baud == baud
    assert str(port.line_format) == form
    port.write(b"hello, world")
    emulated.bench.run_for(0.05)
    assert heard == b"hello, world"


def test_a_break_both_ways(emulate_f7):
    seen = []

    def program(machine):
        usart = machine.chip.usarts["USART1"]
        usart.on_word = lambda data, errors: seen.append((data, errors))
        echo(machine, 469)
        machine.at_ns(20_000_000, lambda: poke(usart, "RQR", 2))

    emulated = emulate_f7(program)
    port = emulated.ports["brain.usart1"]
    emulated.bench.run_for(0.01)
    port.send_break(1_000_000)
    emulated.bench.run_for(0.03)
    assert seen == [(0, 2)]
    assert port.counters.breaks == 1
