"""USARTs at real pins: what configuration they need, what stands on the pins, wires between them."""

from __future__ import annotations

from fractions import Fraction

import pytest

from targets.mcu.nets import Nets
from targets.mcu.serial_line import SerialFormat
from targets.mcu.stm32f1.usart import Usart
from targets.mcu.testing import peek, poke

SITES = {"USART1": (0x4001_3800, "APB2", 37), "USART2": (0x4000_4400, "APB1", 38)}
AF_PP, AF_OD, FLOATING, PULLED, ANALOG, OUTPUT = 0xB, 0xF, 0x4, 0x8, 0x0, 0x3
MAPR, USART1_REMAP = 0x04, 1 << 2


@pytest.fixture
def board(pinout):
    """The chip with USART1 and USART2 running at 16 cycles a bit."""
    for name, (base, bus, irq) in SITES.items():
        usart = pinout.chip.add(Usart(name, base, pinout.services, bus=bus, irq=irq))
        usart.reset()
        poke(usart, "BRR", 16)
        poke(usart, "CR1", 0x200C)
        setattr(pinout, name.lower(), usart)
    pinout.chip.advance(400)
    return pinout


def frame(board, value):
    time = board.chip.time
    return SerialFormat().frame(value, time.seconds(time.now), Fraction(16, 72_000_000))


@pytest.mark.parametrize(("nibble", "leaves"), [(AF_PP, True), (AF_OD, True), (OUTPUT, False), (FLOATING, False)])
def test_tx_needs_an_alternate_function_output(board, nibble, leaves):
    sent = []
    board.usart1.on_frame = sent.append
    board.mode("PA9", nibble)
    poke(board.usart1, "DR", 0x41)
    board.chip.advance(200)
    assert bool(sent) is leaves
    assert [note.where for note in board.chip.notes.all] == ([] if leaves else ["USART1_TX"])


@pytest.mark.parametrize(
    ("nibble", "heard"), [(FLOATING, True), (PULLED, True), (AF_OD, True), (ANALOG, False), (OUTPUT, False)]
)
def test_rx_needs_an_input(board, nibble, heard):
    board.mode("PA10", nibble)
    board.usart1.receive(frame(board, 0x41))
    board.chip.advance(200)
    assert bool(peek(board.usart1, "SR") & 0x20) is heard
    assert [note.where for note in board.chip.notes.all] == ([] if heard else ["USART1_RX"])


def test_a_pin_that_begins_to_float_does_not_hold_the_line_down(board):
    """It reads as low then. But the frames that come in say that somebody outside holds the line high."""
    board.mode("PA10", PULLED)
    board.ports["A"].write(0x10, 1 << 10)
    board.chip.advance(400)
    board.mode("PA10", FLOATING)
    board.chip.advance(400)
    assert peek(board.usart1, "SR") & 0x22 == 0x22
    assert peek(board.usart1, "DR") == 0
    for value in (0x41, 0x42):
        board.usart1.receive(frame(board, value))
        board.chip.advance(200)
        assert peek(board.usart1, "SR") & 0x2F == 0x20
        assert peek(board.usart1, "DR") == value


def test_remapped_pins(board):
    sent = []
    board.usart1.on_frame = sent.append
    board.afio.write(MAPR, USART1_REMAP)
    board.mode("PB6", AF_PP)
    board.mode("PB7", FLOATING)
    board.pins["PB6"].record()
    poke(board.usart1, "DR", 0x55)
    board.usart1.receive(frame(board, 0xAA))
    board.chip.advance(200)
    assert len(sent) == 1
    assert peek(board.usart1, "DR") == 0xAA
    assert len(board.pins["PB6"].take_edges()) == 10


def test_the_record_of_a_pin_is_the_waveform(board):
    board.mode("PA9", AF_PP)
    pin = board.pins["PA9"]
    assert pin.level is True
    pin.record()
    start = board.chip.time.now
    poke(board.usart1, "DR", 0x0F)
    poke(board.usart1, "DR", 0xFF)
    board.chip.advance(400)
    edges = [(edge.cycle - start, edge.level) for edge in pin.take_edges()]
    assert edges == [(0, False), (16, True), (80, False), (144, True), (160, False), (176, True)]


def test_a_wire_between_pins_carries_bytes(board):
    """No frame is handed over: the receiver samples the level of its pin."""
    board.mode("PA9", AF_PP)
    board.mode("PA3", FLOATING)
    Nets().wire("line", board.pins["PA9"], board.pins["PA3"])
    for value in b"over the wire":
        poke(board.usart1, "DR", value)
        board.chip.advance(165)
        assert peek(board.usart2, "SR") & 0x2F == 0x20
        assert peek(board.usart2, "DR") == value


def test_a_port_pin_may_send_by_hand(board):
    board.mode("PB0", OUTPUT)
    board.ports["B"].write(0x10, 1)
    board.mode("PA10", PULLED)
    board.ports["A"].write(0x10, 1 << 10)
    Nets().wire("line", board.pins["PB0"], board.pins["PA10"])
    board.chip.advance(100)
    for level in (0, 1, 0, 0, 0, 0, 0, 1, 0, 1):
        board.ports["B"].write(0x10, 1 if level else 1 << 16)
        board.chip.advance(16)
    assert peek(board.usart1, "SR") & 0x2F == 0x20
    assert peek(board.usart1, "DR") == 0x41


def test_who_reads_the_port_sees_the_bits(board):
    board.mode("PA9", AF_PP)
    poke(board.usart1, "DR", 0x55)
    seen = []
    for _ in range(10):
        board.chip.advance(8)
        seen.append(board.ports["A"].read(0x08) >> 9 & 1)
        board.chip.advance(8)
    assert seen == [0, 1, 0, 1, 0, 1, 0, 1, 0, 1]


@pytest.mark.parametrize("nibble", [AF_OD, AF_PP])
def test_half_duplex_on_one_wire(board, nibble):
    """Both TX pins on one wire with a pull-up."""
    for pin in ("PA9", "PA2"):
        board.mode(pin, nibble)
    Nets().wire("bus", board.pins["PA9"], board.pins["PA2"], pull=True)
    for usart in (board.usart1, board.usart2):
        poke(usart, "CR3", 0x8)
    board.chip.advance(400)
    for usart in (board.usart1, board.usart2):
        peek(usart, "SR")
        peek(usart, "DR")
    for talker, listener in ((board.usart1, board.usart2), (board.usart2, board.usart1)) * 2:
        for value in b"ping":
            poke(talker, "DR", value)
            board.chip.advance(165)
            assert [peek(usart, "SR") & 0x2F for usart in (talker, listener)] == [0x20, 0x20]
            assert [peek(usart, "DR") for usart in (talker, listener)] == [value, value]


@pytest.mark.parametrize("nibble", [AF_OD, AF_PP])
def test_half_duplex_without_a_pull_up(board, nibble):
    """Between frames the pin floats, which reads as low: that is no break."""
    board.mode("PA9", nibble)
    poke(board.usart1, "CR3", 0x8)
    for value in b"to myself":
        poke(board.usart1, "DR", value)
        board.chip.advance(400)
        assert peek(board.usart1, "SR") & 0x2F == 0x20
        assert peek(board.usart1, "DR") == value


def test_flow_control_at_the_pins(board):
    """RTS of one at CTS of the other: PA12 is USART1_RTS, PA0 is USART2_CTS."""
    board.mode("PA12", AF_PP)
    board.mode("PA0", FLOATING)
    board.mode("PA2", AF_PP)
    Nets().wire("flow", board.pins["PA12"], board.pins["PA0"])
    sent = []
    board.usart2.on_frame = lambda one: (sent.append(one.bits), board.usart1.receive(one))
    poke(board.usart1, "CR3", 0x100)
    poke(board.usart2, "CR3", 0x200)
    for value in (1, 2, 3):
        poke(board.usart2, "DR", value)
        board.chip.advance(400)
    assert sent == [1]
    received = []
    for _ in range(2):
        received.append(peek(board.usart1, "DR"))
        board.chip.advance(400)
    assert received == [1, 3]  # 2 was overwritten in the data register
    assert not peek(board.usart1, "SR") & 0x8


@pytest.fixture
def passing(board):
    """PA9 carries frames whose edges the one that follows it does not want; call it to send one."""
    board.mode("PA9", AF_PP)
    pin = board.pins["PA9"]
    pin.follow()
    board.usart1.on_frame = lambda frame: pin.pass_over(len(frame.edge_bits()))

    def send(cycles=200):
        begin = board.chip.time.now
        poke(board.usart1, "DR", 0x41)
        board.chip.advance(cycles)
        return [(begin + cycle, level) for cycle, level in OF_0X41]

    return send


OF_0X41 = [(0, False), (16, True), (32, False), (112, True), (128, False), (144, True)]


def followed(board):
    return [(edge.cycle, edge.level) for _, edges in board.pins.take_followed() for edge in edges]


def test_edges_that_nobody_wants_are_counted(board, passing):
    for _ in range(3):
        passing()
        assert followed(board) == []
    pin = board.pins["PA9"]
    assert pin.level is True
    assert (pin.take_passed(), pin.take_passed(), followed(board)) == (3 * 6, 0, [])


def test_who_asks_for_the_level_in_mid_frame_has_the_edges_told(board, passing):
    """All of this frame, but none of the next; so it is where their count is asked for."""
    pin = board.pins["PA9"]
    for ask, passed in ((lambda: pin.level is False, 6 + 6), (lambda: pin.take_passed() == 6, 6)):
        passing()
        edges = passing(40)
        assert ask()
        assert followed(board) == edges[:3]
        board.chip.advance(80)
        assert followed(board) == edges[3:4]
        board.chip.advance(80)
        assert followed(board) == edges[4:]
        passing()
        assert followed(board) == []
        assert pin.take_passed() == passed


def test_a_clock_that_changes_in_mid_frame_has_the_edges_told(board, passing):
    edges = passing(40)
    board.chip.change_clock(36_000_000)
    board.chip.advance(200)
    assert followed(board) == edges
    assert board.pins["PA9"].take_passed() == 0


def test_edges_that_others_have_to_see_are_told(board, passing):
    pin, timer = board.pins["PA9"], board.signals.output("TIM1_CH2")

    def hear(*_edge):
        pass

    needs = {
        "a record": (pin.record, lambda: pin.record(False)),
        "a listener": (lambda: pin.on_edge(hear), lambda: pin.off_edge(hear)),
        "a source": (lambda: pin.drive(True, ohms=10_000), lambda: pin.drive(None)),
        "a timer": (lambda: timer.set(True), lambda: timer.set(None)),
        "an open drain": (lambda: board.mode("PA9", AF_OD), lambda: board.mode("PA9", AF_PP)),
    }
    for who, (begin, end) in needs.items():
        begin()
        passing()
        assert (who, pin.take_passed()) == (who, 0)
        end()
        board.pins.take_followed()
        passing()
        assert (who, pin.take_passed()) == (who, 6)


def test_the_edges_before_a_reset_in_mid_frame_are_recorded(board):
    """Each edge is recorded, also if nobody asks for them before the frame is broken off."""
    board.mode("PA9", AF_PP)
    pin = board.pins["PA9"]
    pin.record()
    begin = board.chip.time.now
    poke(board.usart1, "DR", 0x55)
    board.chip.advance(3 * 16 + 5)
    board.usart1.reset()
    assert [(edge.cycle - begin, edge.level) for edge in pin.take_edges()] == [
        (0, False),
        (16, True),
        (32, False),
        (48, True),
        (53, None),
    ]
