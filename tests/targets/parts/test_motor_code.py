"""Motor codes: publications, means, latches, orders."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.parts.motor_code import MotorCode, MotorCodeSettings, MotorWord
from targets.parts.testing import PartBench
from targets.parts.words import bits_of, signed
from tests.each import each

MS = 1_000_000
STEP_NS = 4 * MS
WIRES = ("comm1", "comm2", "comm3")


def _bench(**settings) -> PartBench:
    return PartBench(MotorCode, MotorCodeSettings(**settings), step_ns=STEP_NS)


def _put(bench, word, ns, order="lsb-first") -> None:
    for name, level in zip(WIRES, bits_of(word, order), strict=True):
        bench.wires[name].set(level, ns)


@each("order", ["lsb-first", "msb-first"])
@each("word", range(8))
def test_each_word_is_published_raw_and_drives_by_its_code(word, order) -> None:
    bench = _bench(bit_order=order)
    _put(bench, word, 0, order)
    bench.run(0.15)
    assert bench.told(MotorWord) == [MotorWord(raw=word, code=signed(word), at_ns=100 * MS)]
    assert bench.quantities_out == {"speed": signed(word) * 0.0625}


def test_ten_seconds_have_a_hundred_publications() -> None:
    bench = _bench()
    bench.run(10.0)
    assert [event.at_ns for event in bench.told(MotorWord)] == [n * 100 * MS for n in range(1, 101)]
    assert {event.raw for event in bench.told(MotorWord)} == {0}


def test_the_speed_steps_at_publications_only() -> None:
    bench = _bench()
    _put(bench, 3, 1 * MS)
    bench.run_to(99 * MS)
    assert bench.quantities_out["speed"] == 0
    _put(bench, 4, 101 * MS)
    bench.run_to(199 * MS)
    assert bench.quantities_out["speed"] == 3 * 0.0625
    bench.run_to(200 * MS)
    assert bench.quantities_out["speed"] == -4 * 0.0625
    assert [event.raw for event in bench.told(MotorWord)] == [3, 4]


def test_at_once_the_mean_of_the_step_counts() -> None:
    bench = _bench(period_ms=0.0)
    bench.run_to(7 * STEP_NS)
    _put(bench, 3, 7 * STEP_NS + MS)
    bench.run_to(8 * STEP_NS)
    assert bench.quantities_out["speed"] == pytest.approx(0.75 * 3 * 0.0625)
    bench.run_to(9 * STEP_NS)
    assert bench.quantities_out["speed"] == 3 * 0.0625
    assert [event.raw for event in bench.told(MotorWord)] == [0, 3]


@given(
    st.lists(st.tuples(st.integers(0, 7), st.integers(1, 2 * MS)), min_size=1, max_size=30),
    st.sampled_from(["lsb-first", "msb-first"]),
)
def test_the_mean_is_the_time_average_of_the_codes(pieces, order) -> None:
    bench = _bench(period_ms=0.0, bit_order=order)
    now_ns, way = 0, 0.0
    for word, span_ns in pieces:
        _put(bench, word, now_ns, order)
        now_ns += span_ns
        way += signed(word) * span_ns
    for name in WIRES:
        bench.wires[name].set(False, now_ns)
    total = 0.0
    for tick in range(1, now_ns // STEP_NS + 2):
        bench.run_to(tick * STEP_NS)
        total += bench.quantities_out["speed"] * STEP_NS
    assert total == pytest.approx(way * 0.0625, abs=1e-3)


@each(("reads", "raw"), [("pins", 0), ("odr", 3)])
def test_pins_left_as_inputs_publish_only_by_their_latch(reads, raw) -> None:
    """The original reads the output data register even of pins that are inputs."""
    bench = _bench(reads=reads)
    for name, level in zip(WIRES, bits_of(3, "lsb-first"), strict=True):
        bench.wires[name].latched = level
    bench.run(0.1)
    assert bench.told(MotorWord) == [MotorWord(raw=raw, code=raw, at_ns=100 * MS)]


def test_a_latch_at_once() -> None:
    bench = _bench(reads="odr", period_ms=0.0)
    bench.wires["comm3"].latched = True
    bench.run_to(STEP_NS)
    assert bench.quantities_out["speed"] == -0.25


def test_late_calls_publish_at_the_right_times() -> None:
    bench = _bench()
    _put(bench, 1, 0)
    _put(bench, 2, 150 * MS)
    bench.part.advance(250 * MS)
    assert [(event.at_ns, event.raw) for event in bench.told(MotorWord)] == [(100 * MS, 1), (200 * MS, 2)]


def test_settings_are_checked() -> None:
    with pytest.raises(ValueError, match=r"^period_ms must be at least"):
        MotorCodeSettings(period_ms=-1.0)
    with pytest.raises(ValueError, match=r"^reads must be one of pins, odr"):
        MotorCodeSettings(reads="ears")
