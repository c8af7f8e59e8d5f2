"""What it measures: scales, axes, offsets, self-test, temperature, filters (PS section 3, RM section 4)."""

from __future__ import annotations

import math

import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from targets.parts.mpu9250.individual import Individual
from targets.parts.mpu9250.rates import rates_of
from targets.parts.mpu9250.registers import REGISTERS
from targets.parts.mpu9250.settings import Mpu9250Settings
from targets.parts.track import Track
from tests.each import each

MS = 1_000_000
G = 9.80665
RESET = {address: register.reset for address, register in REGISTERS.items()}


@pytest.mark.parametrize(("scale", "counts"), [(0, 16384), (1, 8192), (2, 4096), (3, 2048)])
def test_one_g_at_rest_in_every_full_scale(imu, scale, counts) -> None:
    imu.write(0x1C, scale << 3)
    imu.run(2)
    assert imu.accel() == [0, 0, counts]
    assert imu.gyro() == [0, 0, 0]


@each(("scale", "counts_per_dps"), [(0, 131), (1, 65.5), (2, 32.8), (3, 16.4)])
@each("rate_dps", [90.0, -33.0])
def test_a_known_rotation_in_every_full_scale(make_imu, turning, scale, counts_per_dps, rate_dps) -> None:
    imu = make_imu(turning(rate_dps))
    imu.write(0x1B, scale << 3)
    imu.run(40)
    assert imu.gyro() == [0, 0, round(rate_dps * counts_per_dps)]


def test_free_fall(make_imu, rest) -> None:
    imu = make_imu(lambda _ns: {**rest, "az": 0.0})
    imu.run(10)
    assert imu.accel() == [0, 0, 0]


@each(("rate_dps", "word"), [(300.0, 32767), (-300.0, -32768)])
def test_beyond_full_scale_it_saturates(make_imu, turning, rate_dps, word) -> None:
    imu = make_imu(turning(rate_dps))
    assert imu.gyro()[2] == word


def test_axes_keep_apart(make_imu) -> None:
    imu = make_imu(lambda _ns: {"ax": G / 2, "ay": -G / 4, "az": G, "wx": 0.1, "wy": -0.2, "wz": 0.3})
    imu.run(20)
    assert imu.accel() == [8192, -4096, 16384]
    assert imu.gyro() == [round(math.degrees(rate) * 131) for rate in (0.1, -0.2, 0.3)]


def test_mounting_turns_the_axes(make_imu, rest) -> None:
    """Turned a quarter to the left: the body's x is the sensor's -y."""
    imu = make_imu(lambda _ns: {**rest, "ax": G}, mount_yaw_deg=90)
    imu.run(20)
    assert imu.accel() == [0, -16384, 16384]
    upside_down = make_imu(mount_roll_deg=180)
    assert upside_down.accel() == [0, 0, -16384]
    nose_up = make_imu(mount_pitch_deg=-90)
    assert nose_up.accel() == [16384, 0, 0]


@pytest.mark.parametrize("after_us", [1, 999])
def test_a_sample_is_of_its_time_less_the_delay_of_the_filter(make_imu, rest, after_us) -> None:
    """A rate that grows by 1000 dps a second: a millisecond is 131 counts."""
    imu = make_imu(lambda ns: {**rest, "wz": math.radians(ns / 1e6)}, step_ns=3 * MS)
    imu.write(0x19, 0, 0x02)
    set_ns = imu.now_ns - imu.byte_ns  # the period begins anew with the last byte
    imu.byte_ns = 0
    imu.run_to(set_ns + 50 * MS + after_us * 1000)
    seen_ms = (set_ns + 50 * MS) / 1e6 - 3.9
    assert imu.gyro()[2] == pytest.approx(seen_ms * 131, abs=1)


def test_the_accelerometer_has_a_delay_of_its_own(make_imu, rest) -> None:
    """A force that grows by a g a second."""
    imu = make_imu(lambda ns: {**rest, "ax": G * ns / 1e9}, step_ns=3 * MS)
    imu.write(0x19, 0, 0x01)
    set_ns = imu.now_ns - imu.byte_ns
    imu.write(0x1D, 0x03)
    imu.byte_ns = 0
    imu.run_to(set_ns + 150 * MS + 900_000)
    assert imu.accel()[0] / 16384 == pytest.approx((set_ns + 150 * MS) / 1e9 - 0.0118, abs=0.00004)


@pytest.mark.parametrize(("config2", "changes"), [(0x03, 10), (0x08, 40)])
def test_a_slow_accelerometer_repeats_its_values_at_8_khz(make_imu, rest, config2, changes) -> None:
    """In 10 ms: 1 kHz, or 4 kHz with the filter off."""
    imu = make_imu(lambda ns: {**rest, "ax": G * ns / 1e9, "wx": ns / 1e9})
    imu.write(0x1D, config2)
    imu.byte_ns = 0
    imu.run_to(70 * MS)
    seen = []
    for _ in range(80):
        imu.run_to(imu.now_ns + 125_000)
        seen.append((imu.accel()[0], imu.gyro()[0]))
    assert len({accel for accel, _ in seen}) == pytest.approx(changes, abs=1)
    assert len({gyro for _, gyro in seen}) > 70


@each("degc", [-40.0, 21.0, 25.0, 85.0])
def test_temperature(make_imu, degc) -> None:
    imu = make_imu(temperature_degc=degc)
    word = imu.words(0x41, 1)[0]
    assert word / 333.87 + 21 == pytest.approx(degc, abs=0.5 / 333.87)


def test_a_burst_is_of_one_sample(make_imu, rest) -> None:
    """The body turns faster and faster; a burst that lasts for four samples shows one of them."""
    imu = make_imu(lambda ns: {**rest, **dict.fromkeys(("wx", "wy", "wz"), ns / 1e9)})
    imu.byte_ns = 700_000
    first = imu.gyro()
    assert first[0] == first[1] == first[2] != 0
    assert imu.gyro()[0] > first[0]


# --- offsets, self-test, individuals


def test_gyro_offsets_are_added(imu) -> None:
    """A step is 4 / 131 dps whatever the full scale."""
    imu.write(0x13, 0x01, 0x00, 0xFF, 0x00)
    for scale in range(4):
        imu.write(0x1B, scale << 3)
        imu.run(2)
        assert imu.gyro() == [256 * 4 >> scale, -256 * 4 >> scale, 0]


def test_accelerometer_offsets_are_relative_to_those_of_the_factory(imu) -> None:
    """A step of the upper 15 bits is 0.98 mg: 2 g / 2048."""
    factory = imu.read(0x77, 2)
    steps = (int.from_bytes(factory, "big", signed=True) >> 1) + 512
    imu.write(0x77, *(steps << 1 & 0xFFFF).to_bytes(2, "big"))
    imu.run(2)
    assert imu.accel() == [8192, 0, 16384]


@each("seed", range(5))
def test_the_self_test_answers_as_the_factory_codes_say(make_imu, seed) -> None:
    imu = make_imu()
    codes = [*imu.read(0x0D, 3), *imu.read(0x00, 3)]
    still = imu.accel() + imu.gyro()
    imu.write(0x1C, 0xE0)
    imu.write(0x1B, 0xE0)
    imu.run(5)
    moved = [new - old for new, old in zip(imu.accel() + imu.gyro(), still, strict=True)]
    for code, response in zip(codes, moved, strict=True):
        assert response / (2620 * 1.01 ** (code - 1)) == pytest.approx(1, abs=0.051)


def test_one_axis_alone_can_be_tested(imu) -> None:
    imu.write(0x1B, 0x40)
    imu.run(2)
    found = imu.gyro()
    assert [bool(word) for word in found] == [False, True, False]


@given(st.integers(0, 2**64 - 1))
@example(10)  # one that is cut off at its tolerance
def test_individuals_are_within_the_tolerances(seed) -> None:
    person = Individual.of(Mpu9250Settings(), seed)
    assert all(abs(part) <= 0.06 for part in person.zero_g[:2])
    assert abs(person.zero_g[2]) <= 0.08
    assert all(abs(rate) <= 5 for rate in person.zero_rate_dps)
    assert all(0.97 <= scale <= 1.03 for scale in (*person.accel_scale, *person.gyro_scale))
    assert all(0.225 <= response <= 0.675 for response in person.accel_test_g)
    assert all(60 < response < 250 for response in person.gyro_test_dps)


def test_individuals_differ() -> None:
    assert Individual.of(Mpu9250Settings(), 1) != Individual.of(Mpu9250Settings(), 2)
    assert Individual.of(Mpu9250Settings(), 1) == Individual.of(Mpu9250Settings(), 1)


def test_a_real_one_at_rest_is_within_its_tolerances(make_imu) -> None:
    imu = make_imu(ideal=False)
    accel, gyro = imu.accel(), imu.gyro()
    assert accel != [0, 0, 16384]
    assert gyro != [0, 0, 0]
    assert all(abs(word - at_rest) < 0.15 * 16384 for word, at_rest in zip(accel, (0, 0, 16384), strict=True))
    assert all(abs(word) < 5.5 * 131 for word in gyro)


# --- noise


def _spread(words: list[int]) -> float:
    mean = sum(words) / len(words)
    return math.sqrt(sum((word - mean) ** 2 for word in words) / len(words))


def test_noise_has_the_density_of_the_data_sheet(make_imu) -> None:
    """0.1 dps rms at 92 Hz (PS section 3.1); 300 ug/rtHz over 92 Hz."""
    imu = make_imu(gyro_noise_dps_rthz=0.01, accel_noise_ug_rthz=300)
    imu.write(0x19, 0, 0x02)
    imu.write(0x1D, 0x02)
    gyro, accel = [], []
    for _ in range(400):
        imu.run(1)
        words = imu.words(0x3B, 7)
        accel.append(words[0])
        gyro.append(words[6])
    assert _spread(gyro) == pytest.approx(0.01 * math.sqrt(92) * 131, rel=0.12)
    assert _spread(accel) == pytest.approx(300e-6 * math.sqrt(92) * 16384, rel=0.12)


@pytest.mark.parametrize("step_ms", [1, 4, 10])
@pytest.mark.parametrize("pause_ms", [1, 3])
def test_samples_do_not_depend_on_how_a_run_is_cut(make_imu, rest, step_ms, pause_ms) -> None:
    """A steady turn seen in steps of any length, polled often or not: sample 300 is the same."""

    def seen(step, pause):
        imu = make_imu(lambda ns: {**rest, "wz": ns / 1e9}, step_ns=step * MS, ideal=False)
        imu.write(0x19, 0, 0x03)
        while imu.now_ns < 290 * MS:
            imu.run(pause)
            imu.byte(0x3A)
        imu.run_to(300 * MS + 100)
        return imu.read(0x3B, 14)

    assert seen(step_ms, pause_ms) == seen(2, 7)


# --- filters


@each(
    ("config", "fchoice_b", "bandwidth_hz", "delay_ms", "rate_hz"),
    [
        (0, 0, 250, 0.97, 8000),
        (1, 0, 184, 2.9, 1000),
        (2, 0, 92, 3.9, 1000),
        (3, 0, 41, 5.9, 1000),
        (4, 0, 20, 9.9, 1000),
        (5, 0, 10, 17.85, 1000),
        (6, 0, 5, 33.48, 1000),
        (7, 0, 3600, 0.17, 8000),
        (3, 1, 8800, 0.064, 32000),
        (3, 2, 3600, 0.11, 32000),
        (3, 3, 8800, 0.064, 32000),
    ],
)
def test_the_gyroscopes_table(config, fchoice_b, bandwidth_hz, delay_ms, rate_hz) -> None:
    rates = rates_of({**RESET, 0x1A: config, 0x1B: fchoice_b}, gyro_on=True, low_power=False)
    assert (rates.gyro.bandwidth_hz, rates.gyro.delay_s * 1000) == (bandwidth_hz, delay_ms)
    assert 1e9 / rates.sample_ns == rate_hz


@each(
    ("config", "bandwidth_hz", "delay_ms", "rate_hz"),
    [
        (0, 460, 1.94, 1000),
        (1, 184, 5.8, 1000),
        (2, 92, 7.8, 1000),
        (3, 41, 11.8, 1000),
        (4, 20, 19.8, 1000),
        (5, 10, 35.7, 1000),
        (6, 5, 66.96, 1000),
        (7, 460, 1.94, 1000),
        (8, 1130, 0.75, 4000),
        (11, 1130, 0.75, 4000),
    ],
)
def test_the_accelerometers_table(config, bandwidth_hz, delay_ms, rate_hz) -> None:
    rates = rates_of({**RESET, 0x1D: config}, gyro_on=True, low_power=False)
    assert (rates.accel.bandwidth_hz, rates.accel.delay_s * 1000) == (bandwidth_hz, pytest.approx(delay_ms))
    assert 1e9 / rates.accel_ns == rate_hz


@each("config", range(8))
def test_a_ramp_comes_out_late_by_the_delay_of_the_table(config) -> None:
    rates = rates_of({**RESET, 0x1A: config}, gyro_on=True, low_power=False)
    track = Track((0.0,))
    track.set_filter(rates.gyro.lag_s, rates.gyro.rest_s)
    track.step(0, 1_000 * MS, (0.0,), (1.0,))
    assert 1 - track.at(1_000 * MS)[0] == pytest.approx(rates.gyro.delay_s, abs=1e-6)


@each("config", range(8))
def test_a_sine_at_the_bandwidth_loses_3_db(config) -> None:
    rates = rates_of({**RESET, 0x1A: config}, gyro_on=True, low_power=False)
    hertz = rates.gyro.bandwidth_hz
    track = Track((0.0,))
    track.set_filter(rates.gyro.lag_s, rates.gyro.rest_s)
    step_ns = round(1e9 / hertz / 100)
    for tick in range(1000):
        ends = ((math.sin(2 * math.pi * hertz * (tick + end) * step_ns / 1e9),) for end in (0, 1))
        track.step(tick * step_ns, (tick + 1) * step_ns, *ends)
    peak = max(track.at(ns)[0] for ns in range(800 * step_ns, 1000 * step_ns, step_ns // 7))
    assert 20 * math.log10(peak) == pytest.approx(-3.01, abs=0.05)


@given(st.lists(st.integers(1, 20 * MS), min_size=1, max_size=12), st.integers(0, 100 * MS))
def test_the_filter_does_not_depend_on_the_steps(cuts, asked_ns) -> None:
    """A straight line cut into pieces is the same line."""
    whole, cut = Track((0.0,)), Track((0.0,))
    end_ns = sum(cuts)
    at_ns = 0
    for span_ns in cuts:
        cut.step(at_ns, at_ns + span_ns, (at_ns / 1e6,), ((at_ns + span_ns) / 1e6,))
        at_ns += span_ns
    whole.step(0, end_ns, (0.0,), (end_ns / 1e6,))
    for track in (whole, cut):
        track.set_filter(0.005, 0.003)
    assert cut.at(min(asked_ns, end_ns))[0] == pytest.approx(whole.at(min(asked_ns, end_ns))[0], abs=1e-9)


def test_what_is_no_number_is_not_seen(make_imu, rest) -> None:
    imu = make_imu(lambda ns: {**rest, "az": G if ns < 60 * MS else math.nan})
    imu.run(100)
    assert imu.accel() == [0, 0, 16384]


def test_without_a_world_it_rests(make_imu) -> None:
    imu = make_imu(step_ns=0)
    assert imu.accel() == [0, 0, 16384]


def test_a_past_of_minutes_is_not_kept(imu) -> None:
    imu.run(3000)
    assert len(imu.bench.part._sensing._rate._times_ns) < 700


# --- power


def test_asleep_the_last_sample_stays(make_imu, rest) -> None:
    imu = make_imu(lambda ns: {**rest, "wz": ns / 1e9})
    imu.write(0x6B, 0x41)
    first = imu.gyro()
    imu.run(50)
    assert imu.gyro() == first
    imu.write(0x6B, 0x01)
    woken_ns = imu.now_ns
    imu.run_to(woken_ns + 34 * MS)
    assert imu.gyro() == first
    imu.run_to(woken_ns + 36 * MS)
    assert imu.gyro() != first


def test_clock_source_7_stops_everything(imu) -> None:
    imu.write(0x6B, 0x07)
    imu.byte(0x3A)
    imu.run(50)
    assert imu.byte(0x3A) == 0


def test_axes_that_are_off_keep_their_last_value(make_imu, rest) -> None:
    imu = make_imu(lambda ns: {**rest, **dict.fromkeys(("wx", "wy", "wz"), ns / 1e9), "ax": ns / 1e8})
    imu.write(0x6C, 0x22)
    accel, gyro = imu.accel(), imu.gyro()
    imu.run(50)
    later_accel, later_gyro = imu.accel(), imu.gyro()
    assert (later_accel[0], later_gyro[1]) == (accel[0], gyro[1])
    assert later_gyro[0] > gyro[0]
    assert later_gyro[2] > gyro[2]


def test_with_every_axis_off_there_are_no_samples(imu) -> None:
    imu.write(0x6C, 0x3F)
    imu.byte(0x3A)
    imu.run(50)
    assert imu.byte(0x3A) == 0
    imu.write(0x6C, 0x3E)
    imu.run(50)
    assert imu.byte(0x3A) == 1


def test_the_thermometer_can_be_switched_off(make_imu) -> None:
    imu = make_imu(temperature_degc=30)
    warm = imu.words(0x41, 1)
    imu.write(0x6B, 0x09)
    imu.run(5)
    assert imu.words(0x41, 1) == warm
    imu.write(0x6A, 0x01)
    imu.run(5)
    assert imu.words(0x41, 1) == [0]
    assert imu.accel() == [0, 0, 16384]


def test_signal_reset_clears_the_output_registers(imu) -> None:
    imu.byte_ns = 1000
    imu.write(0x6A, 0x01)
    assert imu.accel() == [0, 0, 0]
    imu.run(1)
    assert imu.accel() == [0, 0, 16384]
    assert imu.byte(0x6A) == 0
    imu.write(0x68, 0x07)
    assert imu.byte(0x68) == 0
    assert imu.accel() == [0, 0, 16384]
