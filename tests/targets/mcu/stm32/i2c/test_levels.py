"""SCL and SDA as they are drawn, read back by a decoder that knows nothing but UM10204."""

from __future__ import annotations

import itertools

from hypothesis import given
from hypothesis import strategies as st

START, STOP, AUTOEND = 1 << 13, 1 << 14, 1 << 25
CYCLE_NS = 1000 / 216


def decode(edges):
    """Return what was on the bus: S, P, and bytes with their acknowledge."""
    scl = sda = True
    found, bits = [], []
    for line, _ns, level in edges:
        if line == "scl":
            scl = level
            if scl:
                bits.append(sda)
                if len(bits) == 9:
                    byte = int("".join("01"[bit] for bit in bits[:8]), 2)
                    found.append(f"{byte:02x}{'-' if bits[8] else '+'}")
                    bits = []
        else:
            sda = level
            if scl:
                assert len(bits) <= 1, "a condition within a byte"
                found.append("P" if sda else "S")
                bits = []
    return found


def draw(rig):
    edges = []
    rig.i2c.draw(lambda line, ns, level: edges.append((line, ns, level)))
    return edges


def test_a_register_read(rig):
    edges = draw(rig)
    rig.send(0x42, more=0)
    rig.until("TC")
    rig.fetch(2)
    rig.until("STOPF")
    assert decode(edges) == ["S", "a0+", "42+", "S", "a1+", "42+", "43-", "P"]
    assert rig.i2c.undrawn_ns() is None


def test_an_address_of_nobody(rig):
    edges = draw(rig)
    rig.begin(0x23)
    rig.until("STOPF")
    assert decode(edges) == ["S", "46-", "P"]


@given(
    messages=st.lists(st.tuples(st.booleans(), st.integers(1, 3)), min_size=1, max_size=4),
    pause=st.integers(0, 300),
    stretch=st.sampled_from([0, 2000]),
)
def test_any_messages(make_rig, make_memory, messages, pause, stretch):
    rig = make_rig(make_memory())
    rig.enable()
    rig.bus.stretch_ns[0x50] = stretch
    edges = draw(rig)
    for number, (read, count) in enumerate(messages):
        last = number == len(messages) - 1
        rig.begin(count=count, read=read, more=AUTOEND if last else 0)
        for byte in range(count):
            rig.until("RXNE" if read else "TXIS")
            rig.clocks(pause)
            if read:
                rig.peek("RXDR")
            else:
                rig.poke("TXDR", 0xA5 + byte)
        rig.until("STOPF" if last else "TC")
    (told,) = rig.told
    expected = []
    for message in told.messages:
        expected += ["S", f"{message.address << 1 | message.read:02x}+"]
        expected += [f"{byte:02x}+" for byte in message.data]
        if message.read:
            expected[-1] = expected[-1][:-1] + "-"
    assert decode(edges) == [*expected, "P"]
    assert edges == sorted(edges, key=lambda edge: edge[1])
    assert (edges[0][1], edges[-1][1]) == (told.begin_ns, told.end_ns)


def test_high_and_low_last_as_the_register_says(rig):
    """SCLH and SCLL of the rig, and two clocks each of synchronisation: 31 and 55 of 54 MHz."""
    edges = draw(rig)
    rig.begin(count=0, more=AUTOEND)
    rig.until("STOPF")
    clock = [(ns, level) for line, ns, level in edges if line == "scl"]
    spans = {(level, round((later - ns) / (4 * CYCLE_NS))) for (ns, level), (later, _) in itertools.pairwise(clock)}
    assert spans == {(True, 31), (False, 55)}


def test_none_is_missing_before_what_is_undrawn(rig):
    edges = draw(rig)
    rig.send(1, 2, 3)
    while not rig.isr("STOPF")[0]:
        undrawn_ns, known = rig.i2c.undrawn_ns(), len(edges)
        rig.clocks(7)
        assert all(ns >= undrawn_ns for _, ns, _ in edges[known:])


def test_stuck_and_released(rig):
    edges = draw(rig)
    rig.bus.stick()
    rig.bus.unstick()
    assert [(line, level) for line, _, level in edges] == [("sda", False), ("sda", True)]
    edges.clear()
    rig.begin(count=1)
    rig.clocks(200)
    rig.poke("CR1", 0)
    levels = dict.fromkeys(("scl", "sda"), True)
    for line, _, level in edges:
        levels[line] = level
    assert levels == {"scl": True, "sda": True}
