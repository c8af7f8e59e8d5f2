"""Samples on the clock, the pin, the FIFO, wake on motion (RM-MPU-9250A-00 sections 4.4 to 4.11, 4.23 to 4.37)."""

from __future__ import annotations

import pytest

from targets.parts.mpu9250.individual import Individual
from targets.parts.mpu9250.settings import Mpu9250Settings
from tests.each import each

MS = 1_000_000
US = 1_000


# --- the pin


def test_raw_data_ready_comes_at_the_sample_times(imu, gaps) -> None:
    """1 kHz over 1 + 4, and a pulse of 50 us."""
    imu.write(0x19, 4, 1)
    imu.write(0x38, 1)
    imu.run(100)
    rises = imu.rises()
    assert len(rises) >= 20
    assert gaps(rises) == {5 * MS}
    falls = [ns for ns, level in imu.edges()[1:] if level is False]
    assert {fall - rise for rise, fall in zip(rises, falls, strict=False)} == {50 * US}
    assert imu.notes() == []


def test_the_first_sample_comes_35_ms_after_power_on(make_imu) -> None:
    imu = make_imu(ready=False, ready_ms=0)
    imu.write(0x1A, 1)
    imu.write(0x38, 1)
    imu.run(60)
    assert imu.rises()[0] == 35 * MS


@pytest.mark.parametrize(
    ("config", "fchoice_b", "divider", "period_ns"),
    [(0, 0, 9, 125_000), (7, 0, 9, 125_000), (1, 0, 9, 10 * MS), (6, 0, 0, MS), (6, 0, 255, 256 * MS)],
)
def test_when_the_divider_counts(imu, gaps, config, fchoice_b, divider, period_ns) -> None:
    imu.write(0x19, divider, config, fchoice_b)
    imu.write(0x38, 1)
    imu.run(3 * period_ns / MS + 2)
    assert gaps(imu.rises()) == {period_ns}


def test_at_32_khz_pulses_run_into_each_other(imu) -> None:
    imu.write(0x1B, 2)
    imu.write(0x38, 1)
    imu.run(2)
    assert len(imu.rises()) == 1


def test_without_an_interrupt_nothing_is_waited_for(imu) -> None:
    assert imu.bench.part.next_deadline_ns() is None
    imu.run(50)
    assert len(imu.edges()) == 1


def test_latched_until_the_status_is_read(imu) -> None:
    imu.write(0x19, 99, 1)
    imu.write(0x37, 0x20)
    imu.byte(0x3A)
    imu.write(0x38, 1)
    imu.run(250)
    assert len(imu.rises()) == 1
    imu.byte(0x75)
    assert imu.bench.wires["int"].level()
    assert imu.byte(0x3A) == 1
    assert not imu.bench.wires["int"].level()
    assert imu.byte(0x3A) == 0
    imu.run(150)
    assert len(imu.rises()) == 2


def test_a_latched_pin_waits_for_its_reader_only(imu) -> None:
    imu.write(0x37, 0x20)
    imu.write(0x38, 1)
    imu.run(5)
    assert imu.bench.wires["int"].level()
    assert imu.bench.part.next_deadline_ns() is None
    imu.byte(0x3A)
    assert imu.bench.part.next_deadline_ns() is not None


def test_any_read_clears(imu) -> None:
    imu.write(0x19, 99, 1)
    imu.write(0x37, 0x30)
    imu.byte(0x3A)
    imu.write(0x38, 1)
    imu.run(150)
    imu.byte(0x75)
    assert not imu.bench.wires["int"].level()
    assert imu.byte(0x3A) == 0


@pytest.mark.parametrize(
    ("config", "idle", "active"), [(0x20, False, True), (0xA0, True, False), (0x60, False, None), (0xE0, None, False)]
)
def test_polarity_and_open_drain(imu, config, idle, active) -> None:
    """Open drain: high is let go."""
    imu.write(0x6B, 0x40)
    imu.byte(0x3A)
    imu.write(0x37, config)
    assert imu.bench.wires["int"].driven_at(imu.now_ns) is idle
    imu.write(0x38, 1)
    imu.write(0x6B, 0)
    imu.run(60)
    assert imu.bench.wires["int"].driven_at(imu.now_ns) is active


def test_the_status_tells_of_new_samples_without_an_interrupt(imu) -> None:
    imu.write(0x19, 49, 1)
    imu.byte(0x3A)
    assert imu.byte(0x3A) == 0
    imu.run(50)
    assert imu.byte(0x3A) == 1
    assert imu.byte(0x3A) == 0


def test_a_clock_that_is_off_by_a_percent(make_imu, gaps) -> None:
    imu = make_imu(clock_error_percent=1)
    imu.write(0x19, 0, 1)
    imu.write(0x38, 1)
    imu.run(20)
    assert gaps(imu.rises()) == {round(MS / 1.01)}


@each("step_ms", [1, 4, 16])
def test_edges_do_not_depend_on_the_steps(make_imu, step_ms) -> None:
    imu = make_imu(step_ns=step_ms * MS)
    imu.write(0x19, 2, 1)
    set_ns = imu.now_ns - 25 * US
    imu.write(0x38, 1)
    imu.run_to(150 * MS)
    assert imu.rises() == list(range(set_ns + 3 * MS, 150 * MS, 3 * MS))


# --- low power


@pytest.mark.parametrize(("setting", "hertz"), [(11, 500), (10, 250), (9, 125), (8, 62.5), (5, 7.8125)])
def test_low_power_rates(imu, gaps, setting, hertz) -> None:
    imu.write(0x1E, setting)
    imu.write(0x6C, 0x07)
    imu.write(0x6B, 0x21)
    imu.write(0x38, 1)
    imu.run(3000 / hertz + 25)
    assert gaps(imu.rises()) == {round(1e9 / hertz)}


def test_the_slowest_low_power_rate_keeps_its_sample(make_imu, rest) -> None:
    """0.24 Hz: what is read long after the sample is what was there then."""
    imu = make_imu(lambda ns: {**rest, "ax": 9.80665 if 4_000 * MS < ns < 4_200 * MS else 0.0})
    imu.write(0x6C, 0x07)
    imu.write(0x6B, 0x21)
    imu.run_to(6_000 * MS)
    assert imu.accel() == [16384, 0, 16384]


# --- FIFO


def _start_fifo(imu, wanted: int, divider: int = 0) -> None:
    """As the calibration of common drivers does: filter on, 1 kHz, FIFO on, then what goes in."""
    imu.write(0x19, divider, 1)
    imu.write(0x6A, 0x44)
    imu.write(0x23, wanted)


def test_forty_samples_in_forty_milliseconds(imu) -> None:
    _start_fifo(imu, 0x78)
    imu.run(40)
    imu.write(0x23, 0)
    count = int.from_bytes(imu.read(0x72, 2), "big")
    assert count // 12 == 40
    assert imu.words(0x74, 6) == [0, 0, 16384, 0, 0, 0]
    assert int.from_bytes(imu.read(0x72, 2), "big") == count - 12


@pytest.mark.parametrize(("wanted", "size"), [(0x08, 6), (0x80, 2), (0x40, 2), (0x70, 6), (0xF8, 14)])
def test_what_goes_in(imu, wanted, size) -> None:
    _start_fifo(imu, wanted, 9)
    imu.run(50)
    imu.write(0x23, 0)
    assert int.from_bytes(imu.read(0x72, 2), "big") == 5 * size


def test_order_in_the_fifo_is_that_of_the_registers(make_imu) -> None:
    imu = make_imu(lambda _ns: {"ax": 9.80665 / 16, "ay": 9.80665 / 8, "az": 9.80665, "wx": 0.1, "wy": 0.2, "wz": 0.3})
    _start_fifo(imu, 0xF8, 9)
    imu.run(30)
    assert imu.words(0x74, 7) == imu.words(0x3B, 7)


def test_overflow_drops_the_oldest(imu) -> None:
    _start_fifo(imu, 0x08)
    imu.byte(0x3A)
    imu.run(80)
    assert imu.byte(0x3A) & 0x10 == 0
    imu.run(20)
    assert imu.byte(0x3A) & 0x10
    assert int.from_bytes(imu.read(0x72, 2), "big") == 512


def test_overflow_in_the_other_mode_keeps_the_oldest(imu) -> None:
    imu.write(0x1A, 0x41)
    imu.write(0x6A, 0x44)
    imu.write(0x74, 0xAB)
    imu.write(0x23, 0x08)
    imu.run(100)
    assert int.from_bytes(imu.read(0x72, 2), "big") == 512
    assert imu.byte(0x74) == 0xAB


def test_fifo_reset_and_empty_reads(imu) -> None:
    imu.write(0x74, 0x12, 0x34)
    assert imu.byte(0x74) == 0x12
    imu.write(0x6A, 0x04)
    assert imu.read(0x72, 2) == b"\0\0"
    assert imu.byte(0x74) == 0x12
    assert imu.byte(0x6A) == 0


def test_the_high_byte_of_the_count_latches_the_low_one(imu) -> None:
    imu.write(0x74, 1, 2, 3)
    assert imu.byte(0x72) == 0
    imu.write(0x74, 4)
    assert imu.byte(0x73) == 3


def test_nothing_goes_in_while_it_is_off(imu) -> None:
    imu.write(0x23, 0x78)
    imu.run(20)
    assert imu.read(0x72, 2) == b"\0\0"


def test_fifo_overflow_raises_the_pin_at_the_sample(imu) -> None:
    imu.write(0x38, 0x10)
    _start_fifo(imu, 0x08)
    imu.run(100)
    assert imu.rises()
    since = imu.rises()[0]
    assert (since - imu.rises()[1]) % MS == 0


# --- wake on motion


@pytest.mark.parametrize(("mode", "pulses"), [(0xC0, 2), (0x80, 60)])
def test_wake_on_motion(make_imu, rest, mode, pulses) -> None:
    """A knock of 0.2 g for 60 ms: against the sample before there are two changes, against the first one sixty."""
    imu = make_imu(lambda ns: {**rest, "ax": 2.0 if 100 * MS <= ns < 160 * MS else 0.0})
    imu.write(0x1D, 0x08)
    imu.write(0x19, 0, 1)
    imu.write(0x1F, 0xFF // 16)
    imu.write(0x69, mode)
    imu.write(0x38, 0x40)
    imu.run_to(99 * MS)
    assert imu.rises() == []
    imu.run_to(200 * MS)
    assert pulses <= len(imu.rises()) <= pulses + 3
    assert imu.byte(0x3A) & 0x40


@pytest.mark.parametrize("scale", range(4))
@pytest.mark.parametrize(("mg", "moved"), [(45, True), (35, False)])
def test_the_threshold_of_motion_is_in_mg_whatever_the_scale(make_imu, rest, scale, mg, moved) -> None:
    """Ten steps of 4 mg."""
    imu = make_imu(lambda ns: {**rest, "az": 9.80665 * (1 + (ns >= 100 * MS) * mg / 1000)}, step_ns=5 * MS)
    imu.write(0x1C, scale << 3)
    imu.write(0x19, 9, 1)
    imu.write(0x1F, 10)
    imu.write(0x69, 0x80)
    imu.write(0x38, 0x40)
    imu.run_to(150 * MS)
    assert bool(imu.rises()) is moved


@pytest.mark.parametrize(
    ("register", "value", "word"), [(0x1A, 0x08, "EXT_SYNC"), (0x38, 0x08, "FSYNC_INT"), (0x24, 0x40, "WAIT_FOR_ES")]
)
def test_pins_and_waits_that_are_not_there_are_noted(imu, register, value, word) -> None:
    imu.write(register, value)
    assert [word in note for note in imu.notes()] == [True]


def test_a_still_sensor_sleeps_on(make_imu) -> None:
    imu = make_imu(accel_noise_ug_rthz=300)
    imu.write(0x1F, 0xFF)
    imu.write(0x69, 0xC0)
    imu.write(0x38, 0x40)
    imu.run(300)
    assert imu.rises() == []


# --- the clock is the part's own


def data_seen(imu, reads: int = 250) -> list[int]:
    """Read as a published rover does: any read clears, WHO_AM_I, and 0.2 ms later INT_STATUS, every 100 ms."""
    for register, value in ((0x6B, 0x01), (0x1A, 0x03), (0x19, 0x04), (0x37, 0x12)):  # 41 Hz, 200 samples a second
        imu.write(register, value)
    seen = []
    for number in range(reads):
        imu.run_to((200 + 100 * number) * MS)
        assert imu.byte(0x75) == 0x71
        imu.run(0.1)  # and 0.1 ms of bus
        seen.append(imu.byte(0x3A))
    return seen


def test_a_program_that_clears_before_it_asks_sees_data_now_and_then(make_imu) -> None:
    """Samples and reads drift through each other: the share is that of the time between the two reads, 4 %."""
    imu = make_imu(step_ns=20 * MS, clock_tolerance_percent=1.0, clock_phase_percent=100.0)
    seen = data_seen(imu)
    assert 0.02 < sum(seen) / len(seen) < 0.06


def test_without_a_clock_of_its_own_it_would_always_be_the_same(make_imu) -> None:
    assert sum(data_seen(make_imu(step_ns=20 * MS), reads=50)) in (0, 50)


def test_each_part_has_its_own_rate_and_phase() -> None:
    drawn = [Individual.of(Mpu9250Settings(), seed).clock_error for seed in range(200)]
    assert len(set(drawn)) == 200
    assert max(map(abs, drawn)) <= 0.01
    assert min(drawn) < -0.004
    assert max(drawn) > 0.004
