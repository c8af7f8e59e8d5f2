"""The AK8963: by itself on the outer bus, and behind the auxiliary master (MS1356-E, RM-MPU-9250A-00 section 5)."""

from __future__ import annotations

import itertools
import math

import pytest

from targets.parts.mpu9250.ak8963 import sensitivity
from tests.each import each

MS = 1_000_000
NORTH_UT, EAST_UT, DOWN_UT = 17.030, -2.872, -14.749


@pytest.fixture
def bypassed(make_imu):
    """Makes rigs whose magnetometer is on the outer bus."""

    def make(moving=None, **settings):
        imu = make_imu(moving, **settings)
        imu.write(0x37, 0x02)
        return imu

    return make


@pytest.fixture
def mag(bypassed):
    return bypassed()


def _codes(imu) -> list[int]:
    imu.write(0x0A, 0x0F, address=0x0C)
    found = list(imu.read(0x10, 3, address=0x0C))
    imu.write(0x0A, 0x00, address=0x0C)
    imu.run(1)
    return found


def _field_ut(imu, words, *, lsb_ut=0.15) -> list[float]:
    return [word * lsb_ut * sensitivity(code) for word, code in zip(words, _codes(imu), strict=True)]


def _measure(imu) -> list[int]:
    imu.write(0x0A, 0x11, address=0x0C)
    imu.run(10)
    return imu.magnetic()


def test_it_is_hidden_until_it_is_bypassed(imu) -> None:
    assert not imu.answers(0x0C)
    imu.write(0x37, 0x02)
    assert imu.answers(0x0C)
    imu.write(0x6A, 0x20)
    assert not imu.answers(0x0C)


def test_identity_and_reset_values(mag) -> None:
    assert mag.byte(0x00, address=0x0C) == 0x48
    assert mag.read(0x02, 11, address=0x0C) == bytes(11)


def test_the_counter_goes_around(mag) -> None:
    found = mag.read(0x0C, 2, address=0x0C)
    assert found[1] == 0x48
    codes = _codes(mag)
    mag.write(0x0A, 0x0F, address=0x0C)
    assert list(mag.read(0x10, 4, address=0x0C)) == [*codes, codes[0]]


def test_sensitivity_adjustment() -> None:
    """MS1356-E section 8.3.11: Hadj = H * ((ASA - 128) * 0.5 / 128 + 1)."""
    assert [sensitivity(code) for code in (0, 128, 192, 255)] == [0.5, 1.0, 1.25, 1 + 127 / 256]


def test_fuse_rom_is_read_in_its_mode_only(mag) -> None:
    assert mag.read(0x10, 3, address=0x0C) == bytes(3)
    assert any("fuse ROM" in note for note in mag.notes())
    assert all(160 <= code <= 190 for code in _codes(mag))


def test_a_single_measurement_takes_7_2_ms_and_ends_in_power_down(mag) -> None:
    mag.write(0x0A, 0x11, address=0x0C)
    set_ns = mag.now_ns - 25_000
    mag.byte_ns = 1_000
    mag.run_to(set_ns + 7_150_000)
    assert mag.byte(0x02, address=0x0C) == 0
    mag.run_to(set_ns + 7_210_000)
    assert mag.byte(0x02, address=0x0C) == 1
    assert mag.byte(0x0A, address=0x0C) == 0x10
    mag.magnetic()
    mag.run(50)
    assert mag.byte(0x02, address=0x0C) == 0


def test_axes_lie_as_the_data_sheet_draws_them(bypassed) -> None:
    """Level and with its x axis to the east: AK x = MPU y = north, AK y = MPU x = east, AK z = down."""
    imu = bypassed()
    assert _field_ut(imu, _measure(imu)) == pytest.approx([NORTH_UT, EAST_UT, DOWN_UT], abs=0.12)


@pytest.mark.parametrize("heading_deg", [0, 37, 90, 180, 270])
def test_a_compass_made_of_it_shows_the_heading(bypassed, rest, heading_deg) -> None:
    """Yaw turns to the left from the world's x axis; the bearing of x is north here."""
    yaw = -math.radians(heading_deg)
    imu = bypassed(lambda _ns: {**rest, "roll": 0.0, "pitch": 0.0, "yaw": yaw}, x_axis_bearing_deg=0)
    y, x, _ = _field_ut(imu, _measure(imu))
    declination = math.degrees(math.atan2(EAST_UT, NORTH_UT))
    found = math.degrees(math.atan2(y, x)) + declination
    assert (found - heading_deg + 180) % 360 - 180 == pytest.approx(0, abs=0.7)


def test_rolled_over_it_sees_the_field_from_below(bypassed, rest) -> None:
    imu = bypassed(lambda _ns: {**rest, "az": -9.8, "roll": math.pi, "pitch": 0.0, "yaw": 0.0})
    assert _field_ut(imu, _measure(imu)) == pytest.approx([-NORTH_UT, EAST_UT, -DOWN_UT], abs=0.12)


def test_hard_iron_is_in_the_axes_of_the_accelerometer(bypassed) -> None:
    imu = bypassed(
        field_north_nt=0, field_east_nt=0, field_down_nt=0, hard_iron_x_ut=10, hard_iron_y_ut=20, hard_iron_z_ut=30
    )
    assert _field_ut(imu, _measure(imu)) == pytest.approx([20, 10, -30], abs=0.12)


def test_fourteen_bits_are_four_times_coarser(bypassed) -> None:
    imu = bypassed()
    imu.write(0x0A, 0x01, address=0x0C)
    imu.run(10)
    words = imu.magnetic()
    assert imu.byte(0x09, address=0x0C) & 0x10 == 0
    assert _field_ut(imu, words, lsb_ut=0.6) == pytest.approx([NORTH_UT, EAST_UT, DOWN_UT], abs=0.4)


@pytest.mark.parametrize(("mode", "period_ms"), [(0x12, 125), (0x16, 10)])
def test_continuous_rates(mag, mode, period_ms) -> None:
    mag.byte_ns = 1_000
    mag.write(0x0A, mode, address=0x0C)
    times_ns = []
    while len(times_ns) < 4:
        mag.run(0.1)
        if mag.byte(0x02, address=0x0C) & 1:
            times_ns.append(mag.now_ns)
            mag.read(0x03, 7, address=0x0C)
    assert [b - a for a, b in itertools.pairwise(times_ns)] == pytest.approx([period_ms * MS] * 3, abs=150_000)


def test_overrun_is_told_and_cleared_by_reading(mag) -> None:
    mag.write(0x0A, 0x16, address=0x0C)
    mag.run(9)
    assert mag.byte(0x02, address=0x0C) == 1
    mag.run(10)
    assert mag.byte(0x02, address=0x0C) == 3
    mag.read(0x03, 7, address=0x0C)
    assert mag.byte(0x02, address=0x0C) == 0


def test_data_are_protected_until_status_2_is_read(bypassed, rest) -> None:
    """The body turns; what has been begun to read stays, and what came meanwhile is lost and told."""
    imu = bypassed(lambda ns: {**rest, "roll": 0.0, "pitch": 0.0, "yaw": ns / 2e8})
    imu.write(0x0A, 0x16, address=0x0C)
    imu.run(9)
    first = imu.read(0x03, 6, address=0x0C)
    imu.run(50)
    assert imu.read(0x03, 6, address=0x0C) == first
    assert imu.byte(0x02, address=0x0C) & 1 == 0
    imu.byte(0x09, address=0x0C)
    assert imu.byte(0x02, address=0x0C) & 2
    imu.run(10)
    assert imu.read(0x03, 6, address=0x0C) != first


def test_overflow(bypassed) -> None:
    imu = bypassed(hard_iron_x_ut=3000, hard_iron_y_ut=2500)
    imu.write(0x0A, 0x11, address=0x0C)
    imu.run(10)
    assert imu.byte(0x09, address=0x0C) == 0x18
    strong = bypassed(hard_iron_x_ut=9000)
    assert _measure(strong)[1] == 32760


def test_self_test_is_in_its_range(bypassed) -> None:
    """RM section 5.11: -200..200, -200..200, -3200..-800, after the adjustment."""
    imu = bypassed()
    imu.write(0x0C, 0x40, address=0x0C)
    imu.write(0x0A, 0x18, address=0x0C)
    imu.run(10)
    x, y, z = (ut / 0.15 for ut in _field_ut(imu, imu.magnetic()))
    assert abs(x) <= 200
    assert abs(y) <= 200
    assert -3200 <= z <= -800


def test_soft_reset(mag) -> None:
    mag.write(0x0A, 0x16, address=0x0C)
    mag.run(20)
    mag.write(0x0B, 0x01, address=0x0C)
    assert mag.read(0x02, 11, address=0x0C) == bytes(11)


def test_i2c_can_be_disabled_for_good(mag) -> None:
    mag.write(0x0F, 0x1B, address=0x0C)
    assert not mag.answers(0x0C)


@pytest.mark.parametrize(
    ("modes", "word"),
    [
        ((0x1A,), "prohibited"),
        ((0x04,), "trigger"),
        ((0x16, 0x12), "without power-down"),
        ((0x16, 0x00, 0x12), "100 us"),
    ],
)
def test_mistakes_are_noted(mag, modes, word) -> None:
    mag.byte_ns = 1_000
    for mode in modes:
        mag.write(0x0A, mode, address=0x0C)
    assert any(word in note for note in mag.notes())


def test_registers_for_the_factory_are_noted(mag) -> None:
    mag.write(0x0D, 0xFF, address=0x0C)
    assert any("TS1" in note for note in mag.notes())


def test_writes_beyond_the_registers_do_nothing(mag) -> None:
    mag.write(0x0B, 0x00, address=0x0C)
    mag.write(0x42, 0x01, address=0x0C)
    assert mag.read(0x42, 1, address=0x0C) == b"\0"
    assert mag.notes() == []


def test_a_reset_of_the_mpu_leaves_it_alone(mag) -> None:
    mag.write(0x0A, 0x16, address=0x0C)
    mag.write(0x6B, 0x80)
    mag.write(0x37, 0x02)
    assert mag.byte(0x0A, address=0x0C) == 0x16


# --- the auxiliary master


def _auxiliary(imu) -> None:
    imu.write(0x19, 4, 1)
    imu.write(0x37, 0x30)
    imu.write(0x24, 0x0D)
    imu.write(0x6A, 0x20)


def test_slave_0_fetches_what_the_bypass_shows(make_imu) -> None:
    imu = make_imu()
    _auxiliary(imu)
    imu.write(0x25, 0x0C, 0x0A, 0x81)
    imu.write(0x63, 0x16)
    imu.run(20)
    imu.write(0x25, 0x8C, 0x03, 0x87)
    imu.run(20)
    data = imu.read(0x49, 7)
    words = [int.from_bytes(data[i : i + 2], "little", signed=True) for i in (0, 2, 4)]
    assert data[6] == 0x10
    assert words[0] > 90
    assert words[2] < -70
    assert imu.byte(0x36) & 0x01 == 0


def test_several_slaves_stand_one_behind_the_other(make_imu) -> None:
    imu = make_imu()
    _auxiliary(imu)
    imu.write(0x25, 0x8C, 0x00, 0x81)
    imu.write(0x28, 0x8C, 0x00, 0x82)
    imu.run(10)
    assert imu.read(0x49, 4) == b"\x48\x48\x9a\x00"


def test_a_disabled_slave_keeps_its_place_until_all_are(make_imu) -> None:
    imu = make_imu()
    _auxiliary(imu)
    imu.write(0x25, 0x8C, 0x00, 0x81)
    imu.write(0x28, 0x8C, 0x01, 0x81)
    imu.run(10)
    imu.write(0x27, 0x00)
    imu.run(10)
    assert imu.read(0x49, 2) == b"\x48\x9a"
    imu.write(0x2A, 0x00)
    imu.write(0x2A, 0x81)
    imu.run(10)
    assert imu.read(0x49, 2) == b"\x9a\x00"


def test_more_bytes_than_there_is_room_for_are_lost(make_imu) -> None:
    imu = make_imu()
    _auxiliary(imu)
    for first in (0x25, 0x28):
        imu.write(first, 0x8C, 0x00, 0x8F)
    imu.run(10)
    found = imu.read(0x49, 25)
    assert found[13] == found[15] == 0x48
    assert found[24] == 0


def test_bytes_of_a_word_can_be_swapped(make_imu) -> None:
    imu = make_imu()
    _auxiliary(imu)
    imu.write(0x25, 0x8C, 0x00, 0xC2)
    imu.run(10)
    assert imu.read(0x49, 2) == b"\x9a\x48"


def test_a_slave_without_a_register_goes_on_where_it_stood(make_imu) -> None:
    """I2C_SLV0_REG_DIS: the first read sets the counter of the AK8963, the next ones continue."""
    imu = make_imu()
    imu.write(0x37, 0x02)
    imu.read(0x0C, 1, address=0x0C)
    _auxiliary(imu)
    imu.write(0x6A, 0x00)
    imu.write(0x25, 0x8C, 0x77, 0xA2)
    imu.write(0x19, 99)
    imu.write(0x6A, 0x20)
    imu.run(101)
    assert imu.read(0x49, 2) == b"\x48\x9a"


def test_slave_4_writes_once_and_is_done(make_imu) -> None:
    imu = make_imu()
    _auxiliary(imu)
    imu.write(0x31, 0x0C, 0x0A, 0x0F, 0x80)
    imu.run(10)
    assert imu.byte(0x36) & 0x40
    assert imu.byte(0x36) == 0
    assert imu.byte(0x34) == 0
    imu.write(0x31, 0x8C, 0x00)
    imu.write(0x34, 0x80)
    imu.run(10)
    imu.write(0x31, 0x8C)
    imu.write(0x34, 0xA0)  # without a register: what follows the one byte that was read
    imu.run(10)
    assert imu.byte(0x35) == 0x9A
    imu.write(0x31, 0x8C, 0x10)
    imu.write(0x34, 0x80)
    imu.run(10)
    assert 160 <= imu.byte(0x35) <= 190


def test_who_is_not_there_does_not_acknowledge(make_imu) -> None:
    imu = make_imu()
    _auxiliary(imu)
    imu.write(0x28, 0x9E, 0x00, 0x82)
    imu.run(10)
    assert imu.byte(0x36) == 0x02


def test_delayed_slaves_are_visited_less_often(make_imu) -> None:
    imu = make_imu()
    _auxiliary(imu)
    imu.write(0x34, 9)
    imu.write(0x67, 0x02)
    imu.write(0x25, 0x9E, 0x00, 0x81)
    imu.write(0x28, 0x9D, 0x00, 0x81)
    seen = []
    for _ in range(40):
        imu.byte(0x36)
        imu.run_to((imu.now_ns // (5 * MS) + 1) * 5 * MS + 2 * MS)
        seen.append(imu.byte(0x36))
    assert sum(status & 1 for status in seen) == 40
    assert sum(status >> 1 & 1 for status in seen) == 4


@each(("slave", "fifo_en", "master_ctrl"), [(0, 0x01, 0), (1, 0x02, 0), (2, 0x04, 0), (3, 0x00, 0x20)])
def test_external_bytes_go_into_the_fifo(make_imu, slave, fifo_en, master_ctrl) -> None:
    """All four slaves read; one of them is wanted."""
    imu = make_imu()
    _auxiliary(imu)
    for number in range(4):
        imu.write(0x25 + 3 * number, 0x8C, 0x00 if number == slave else 0x0A, 0x82)
    imu.run(5)
    imu.write(0x24, master_ctrl)
    imu.write(0x6A, 0x64)
    imu.write(0x23, fifo_en)
    imu.run(24)
    imu.write(0x23, 0)
    imu.write(0x24, 0)
    count = imu.read(0x72, 2)[1]
    assert count in (8, 10)
    assert imu.read(0x74, 4) == b"\x48\x9a\x48\x9a"


def test_master_reset_forgets(make_imu) -> None:
    imu = make_imu()
    _auxiliary(imu)
    imu.write(0x25, 0x8C, 0x00, 0x82)
    imu.run(10)
    imu.write(0x25, 0x8C, 0x00, 0x00)
    imu.write(0x6A, 0x02)
    assert imu.read(0x49, 2) == b"\0\0"
