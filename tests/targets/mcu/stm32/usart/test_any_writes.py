"""Whatever a program writes into a USART with FIFOs and whenever, its flags keep their rules; it works afterwards."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

UE, RE, TE, FIFOEN = 1 << 0, 1 << 2, 1 << 3, 1 << 29
ORE, RXNE, TC, TXE, TXFE, RXFF, RXFT, TXFT = (1 << bit for bit in (3, 5, 6, 7, 23, 24, 26, 27))

words = st.integers(0, 0xFFFF_FFFF)
writes = st.one_of(
    st.tuples(st.just("CR1"), words),
    st.tuples(st.just("CR1"), st.sampled_from([0, FIFOEN, UE | RE | TE, FIFOEN | UE | RE | TE])),
    st.tuples(st.sampled_from(["CR2", "CR3", "RTOR", "RQR", "ICR", "PRESC", "GTPR"]), words),
    st.tuples(st.just("BRR"), st.sampled_from([0, 16, 33, 0xFFFF])),
    st.tuples(st.just("TDR"), st.integers(0, 0x1FF)),
    st.tuples(st.sampled_from(["RDR", "hear", "low", "high"]), st.just(0x5A)),
)
steps = st.lists(st.tuples(writes, st.integers(0, 30_000)), max_size=40)


def act(port, what, value):
    """Do it; return the cycle at which the line is free again."""
    match what:
        case "RDR":
            port.peek("RDR")
        case "hear":
            if port.usart.baud_hz:
                return port.chip.time.cycle_at(port.hear(value, wait=False).end_s)
        case "low" | "high":
            port.rx.drive(what == "high")
        case _:
            port.poke(what, value)
    return port.now


@given(steps=steps)
def test_rules_hold(make_fifo_port, steps):
    port = make_fifo_port()
    free = 0
    for (what, value), cycles in steps:
        free = max(free, act(port, what, value))
        port.chip.advance(cycles)
        flags, fifos = port.peek("ISR"), port.peek("CR1") & FIFOEN
        assert fifos or not flags & (RXFF | RXFT | TXFT | TXFE)
        assert not flags & RXFF or flags & RXNE
        assert not flags & TXFE or flags & TXE
        assert not flags & TC or flags & TXE
    port.chip.advance_to(max(port.now, free))
    port.rx.drive(True)
    port.poke("CR1", 0)
    for register in ("CR2", "CR3", "PRESC"):
        port.poke(register, 0)
    port.open(brr=16, cr1=FIFOEN | TE | RE)
    port.bits(3000)
    port.poke("RQR", 0x18)
    port.sent.clear()
    port.hear(0x42)
    port.poke("TDR", 0x24)
    port.bits(12)
    assert port.peek("RDR") == 0x42
    assert port.values == [0x24]
