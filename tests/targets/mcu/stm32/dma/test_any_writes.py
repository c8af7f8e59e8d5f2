"""Whatever a program writes and whenever, the controller keeps its own rules and does its work afterwards."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

RAM, PORT, NOWHERE = 0x2000_0000, 0x4001_0000, 0x6000_0000
EN, MINC, PINC = 1, 1 << 10, 1 << 9

addresses = st.builds(lambda base, offset: base + offset, st.sampled_from([RAM, PORT, NOWHERE]), st.integers(0, 0x90))
controls = st.builds(
    lambda low, size, more, channel: low | size << 11 | more << 15 | channel << 25,
    st.integers(0, 0x7FF),
    st.integers(0, 15),
    st.integers(0, 0x3FF),
    st.sampled_from([3, 4, 5]),
)
writes = st.one_of(
    st.tuples(st.just("CR"), controls.map(lambda value: value | EN)),
    st.tuples(st.just("CR"), controls),
    st.tuples(st.just("NDTR"), st.integers(0, 40)),
    st.tuples(st.sampled_from(["PAR", "M0AR", "M1AR"]), addresses),
    st.tuples(st.just("FCR"), st.integers(0, 0xFF)),
    st.tuples(st.just("FLAGS"), st.just(0)),
    st.tuples(st.sampled_from(["on", "off", "pulse", "end", "gate"]), st.just(0)),
)
steps = st.lists(st.tuples(st.integers(0, 2), writes, st.integers(0, 60)), max_size=40)


def act(rig, number, what, value):
    line = rig.line(number)
    match what:
        case "on" | "off":
            line.set(what == "on")
        case "pulse" | "end":
            getattr(line, what)()
        case "gate":
            rig.dma.clocked = not rig.dma.clocked
        case "FLAGS":
            rig.clear(number)
        case _:
            rig.poke(f"S{number}{what}", value)


@given(steps=steps)
def test_rules_hold(make_rig, steps):
    rig = make_rig()
    for number, (what, value), cycles in steps:
        act(rig, number, what, value)
        rig.chip.advance(cycles)
        for stream in range(3):
            control, flags = rig.peek(f"S{stream}CR"), rig.peek("LISR") >> (0, 6, 16)[stream] & 0x3D
            assert 0 <= rig.peek(f"S{stream}NDTR") <= 0xFFFF
            wanted = flags & (control & 0x1E) << 1 or (flags & 1 and rig.peek(f"S{stream}FCR") & 0x80)
            assert rig.irq(stream).level is bool(wanted)
    for _, address, size, value in rig.bus.accesses:
        assert address % size == 0
        assert 0 <= value < 1 << 8 * size
    rig.dma.clocked = True
    for stream in range(3):
        rig.line(stream).set(False)
        rig.poke(f"S{stream}CR", 0)
    rig.chip.advance(1000)
    data = rig.fill(PORT + 0x200, 16)
    rig.clear(0)
    rig.stream(0, EN | MINC | PINC, 16, PORT + 0x200, RAM + 0x200)
    rig.serve(0, 16)
    assert rig.bus.dump(RAM + 0x200, 16) == data
    assert rig.flags(0) == {"HT", "TC"}
