"""Whatever is written and read, and however time is cut between: the same bytes and the same edges."""

from __future__ import annotations

from hypothesis import given, settings
from hypothesis import strategies as st

from targets.mcu.i2c_bus import I2cBus
from targets.parts.mpu9250 import Mpu9250, Mpu9250Settings
from targets.parts.testing import PartBench
from tests.share import examples

MS = 1_000_000
WRITES = st.one_of(
    st.tuples(st.just(0x19), st.sampled_from([0, 1, 4, 19, 99, 255])),
    st.tuples(st.sampled_from([0x1A, 0x1D]), st.integers(0, 15)),
    st.tuples(st.sampled_from([0x1B, 0x1C]), st.sampled_from([0, 0x18, 0xE0, 0x08])),
    st.tuples(st.just(0x23), st.sampled_from([0x00, 0x08, 0x78, 0xF9])),
    st.tuples(st.just(0x37), st.sampled_from([0x00, 0x20, 0x30, 0xA2])),
    st.tuples(st.just(0x38), st.sampled_from([0x00, 0x01, 0x51])),
    st.tuples(st.just(0x69), st.sampled_from([0x00, 0x80, 0xC0])),
    st.tuples(st.just(0x6A), st.sampled_from([0x00, 0x40, 0x60, 0x44, 0x01])),
    st.tuples(st.just(0x6B), st.sampled_from([0x00, 0x01, 0x40, 0x20, 0x80])),
    st.tuples(st.just(0x6C), st.sampled_from([0x00, 0x07, 0x38, 0x12])),
    st.tuples(st.just(0x25), st.just(0x8C)),
    st.tuples(st.just(0x27), st.sampled_from([0x00, 0x8A])),
)
STEPS = st.lists(
    st.tuples(st.integers(1, 40 * MS), st.one_of(WRITES, st.tuples(st.sampled_from([0x3A, 0x3B, 0x49, 0x72, 0x74])))),
    min_size=2,
    max_size=10,
)


def _moving(ns: int) -> dict[str, float]:
    """Straight lines, which every cut leaves as they are."""
    s = ns / 1e9
    return {"ax": s, "ay": -2 * s, "az": 9.8, "wx": s / 3, "wy": 0.1, "wz": -s, "roll": 0.0, "pitch": 0.0, "yaw": s}


def _play(script, step_ns: int, looks) -> tuple[list[bytes], list]:
    """Do what the script says at its times; at other times the part is looked at only."""
    bench = PartBench(Mpu9250, Mpu9250Settings(), quantities=_moving, step_ns=step_ns)
    bus = I2cBus()
    bus.attach(bench.part.slave("i2c"))
    read: list[bytes] = []
    at_ns = 60 * MS
    for wait_ns, operation in script:
        for look in looks:
            bench.run_to(at_ns + round(wait_ns * look))
            bench.part.advance(bench.now_ns)
        at_ns += wait_ns
        bench.run_to(at_ns)
        bus.start(at_ns)
        bus.address(0x68, False, at_ns)
        for byte in operation:
            bus.write(byte, at_ns)
        if len(operation) == 1:
            bus.start(at_ns)
            bus.address(0x68, True, at_ns)
            read.append(bytes(bus.read(at_ns) for _ in range(14)))
        bus.stop(at_ns)
    bench.run_to(at_ns + 5 * MS)
    return read, bench.wires["int"].edges


@settings(max_examples=examples(60))
@given(STEPS, st.sampled_from([1 * MS, 4_166_667, 20 * MS]), st.lists(st.floats(0, 1), max_size=3).map(sorted))
def test_any_script_gives_the_same_however_it_is_cut(script, step_ns, looks) -> None:
    assert _play(script, step_ns, looks) == _play(script, 7 * MS, [])
