"""The MPU-6050: what differs from its successor (RM-MPU-6000A-00, PS-MPU-6000A-00)."""

from __future__ import annotations

from tests.each import each
from tests.targets.parts.mpu9250.conftest import MS, REST

G = 9.80665


def test_it_sleeps_until_it_is_woken(make_mpu6050):
    imu = make_mpu6050(awake=False)
    assert imu.byte(0x75) == 0x68
    assert imu.byte(0x6B) == 0x40
    imu.run(100)
    assert imu.accel() == [0, 0, 0]
    assert not imu.byte(0x3A) & 1
    imu.write(0x6B, 0x01)
    imu.run(50)
    assert imu.accel() == [0, 0, 16384]


@each(("degc", "counts"), [(36.53, 0), (25.0, -3920), (85.0, 16480)])
def test_its_thermometer(make_mpu6050, degc, counts):
    assert make_mpu6050(temperature_degc=degc).words(0x41, 1) == [counts]


@each("scale", range(4))
def test_its_full_scales(make_mpu6050, scale, turning):
    imu = make_mpu6050(turning(100))
    imu.write(0x1B, scale << 3, scale << 3)
    imu.run(100)
    assert imu.gyro()[2] == round(100 * (131.0, 65.5, 32.8, 16.4)[scale])
    assert imu.accel() == [0, 0, 16384 >> scale]


@each(
    ("config", "divider", "hz"),
    [(0, 0, 8000), (0, 7, 1000), (7, 79, 100), (1, 0, 1000), (3, 4, 200), (6, 255, 3.90625)],
)
def test_the_divider_counts_in_every_filter(make_mpu6050, config, divider, hz):
    imu = make_mpu6050()
    imu.write(0x19, divider, config)
    imu.write(0x38, 1)
    imu.write(0x37, 0x10)  # any read clears
    imu.byte(0x3A)
    begin = len(imu.rises())
    imu.byte_ns = 10_000
    for _ in range(6):
        imu.run(1000 / hz if hz < 1000 else 1)
        imu.byte(0x75)
    gaps = {later - earlier for earlier, later in zip(imu.rises()[begin + 1 :], imu.rises()[begin + 2 :], strict=False)}
    assert gaps
    assert all(gap % round(1e9 / hz) == 0 for gap in gaps)
    assert hz >= 1000 or min(gaps) == round(1e9 / hz)


@each(("control", "hz"), [(0, 1.25), (1, 5), (2, 20), (3, 40)])
def test_it_wakes_for_single_samples(make_mpu6050, control, hz):
    imu = make_mpu6050()
    imu.write(0x38, 1)
    imu.write(0x6B, 0x20, control << 6 | 0x07)
    imu.run(5000 / hz)
    rises = imu.rises()
    assert rises[-1] - rises[-2] == round(1e9 / hz)


def test_its_fifo_holds_1024_bytes(make_mpu6050):
    imu = make_mpu6050()
    imu.write(0x1A, 1)
    imu.write(0x23, 0x08)
    imu.write(0x6A, 0x40)
    imu.run(300)
    imu.write(0x23, 0)
    assert int.from_bytes(imu.read(0x72, 2), "big") == 1024
    assert imu.byte(0x3A) & 0x10


@each("seed", range(4))
def test_the_self_test_is_within_14_percent(make_mpu6050, seed):
    """STR less the trim of the factory is at most 14 % of that (RM section 4.1)."""
    imu = make_mpu6050(temperature_degc=20.0 + seed)
    imu.write(0x1B, 0x00, 0x10)
    imu.run(50)
    off_gyro, off_accel = imu.gyro(), imu.accel()
    imu.write(0x1B, 0xE0, 0xF0)
    imu.run(50)
    x, y, z, a = imu.read(0x0D, 4)
    for axis, (own, sign) in enumerate(zip((x, y, z), (1, -1, 1), strict=True)):
        gyro_trim = sign * 25 * 131 * 1.046 ** ((own & 0x1F) - 1)
        assert abs((imu.gyro()[axis] - off_gyro[axis]) / gyro_trim - 1) < 0.14
        code = own >> 5 << 2 | a >> 4 - 2 * axis & 3
        accel_trim = 4096 * 0.34 * (0.92 / 0.34) ** ((code - 1) / 30)
        assert abs((imu.accel()[axis] - off_accel[axis]) / accel_trim - 1) < 0.14


def test_it_has_no_magnetometer(make_mpu6050):
    imu = make_mpu6050()
    imu.write(0x37, 0x02)
    assert not imu.answers(0x0C)
    imu.write(0x25, 0x8C, 0x00, 0x81)
    imu.write(0x6A, 0x20)
    imu.run(10)
    assert imu.byte(0x36) & 1


def test_its_address(make_mpu6050):
    assert not make_mpu6050(ad0=True, awake=False).answers(0x68)
    assert make_mpu6050(ad0=True, awake=False).answers(0x69)


def test_what_the_register_map_does_not_have_is_noted(make_mpu6050):
    imu = make_mpu6050()
    imu.write(0x06, 1)
    imu.write(0x1D, 1)
    imu.write(0x6A, 0x80)
    assert [note.split(":")[0] for note in imu.notes()] == [
        "register 0x06 is reserved",
        "register 0x1D is reserved",
        "the digital motion processor is not modelled",
    ]


def test_a_motion_is_seen(make_mpu6050):
    imu = make_mpu6050(lambda ns: {**REST, "ax": G / 2 if ns > 200 * MS else 0.0})
    assert imu.accel()[0] == 0
    imu.run(200)
    assert imu.accel()[0] == 8192
