"""What common drivers do at start, register by register, and what they expect of it."""

from __future__ import annotations

import pytest

MS = 1_000_000


def test_calibration_from_the_fifo(make_imu) -> None:
    """Reset, 40 ms of gyroscope and accelerometer in the FIFO, means of it, biases into the offset registers."""
    imu = make_imu(ideal=False)
    for register, value, wait_ms in (
        (0x6B, 0x80, 100),
        (0x6B, 0x01, 0),
        (0x6C, 0x00, 200),
        (0x38, 0x00, 0),
        (0x23, 0x00, 0),
        (0x6B, 0x00, 0),
        (0x24, 0x00, 0),
        (0x6A, 0x00, 0),
        (0x6A, 0x0C, 15),
        (0x1A, 0x01, 0),
        (0x19, 0x00, 0),
        (0x1B, 0x00, 0),
        (0x1C, 0x00, 0),
        (0x6A, 0x40, 0),
        (0x23, 0x78, 40),
        (0x23, 0x00, 0),
    ):
        imu.write(register, value)
        imu.run(wait_ms)
    packets = int.from_bytes(imu.read(0x72, 2), "big") // 12
    assert packets == 40
    sums = [0] * 6
    for _ in range(packets):
        for index, word in enumerate(imu.words(0x74, 6)):
            sums[index] += word
    means = [total // packets for total in sums]
    offsets = b"".join((-(mean // 4) & 0xFFFF).to_bytes(2, "big") for mean in means[3:])
    imu.write(0x13, *offsets)
    for axis, register in enumerate((0x77, 0x7A, 0x7D)):
        stored = int.from_bytes(imu.read(register, 2), "big", signed=True)
        excess = means[axis] - (16384 if axis == 2 else 0)
        trimmed = (stored - excess // 8) & ~1 | stored & 1
        imu.write(register, *(trimmed & 0xFFFF).to_bytes(2, "big"))
    imu.run(20)
    gyro = [sum(values) / 50 for values in zip(*(_after(imu, imu.gyro) for _ in range(50)), strict=True)]
    accel = [sum(values) / 50 for values in zip(*(_after(imu, imu.accel) for _ in range(50)), strict=True)]
    assert gyro == pytest.approx([0, 0, 0], abs=25)
    assert accel == pytest.approx([0, 0, 16384], abs=60)


def _after(imu, read):
    imu.run(1)
    return read()


def test_self_test_within_14_percent(make_imu) -> None:
    """200 readings without and with excitation, against 2620 / 2^FS * 1.01^(code - 1)."""
    imu = make_imu(ideal=False)
    imu.write(0x19, 0, 0x02, 0x00)
    imu.write(0x1D, 0x02)
    imu.write(0x1C, 0x00)

    def mean() -> list[float]:
        found = [_after(imu, lambda: imu.words(0x3B, 7)) for _ in range(200)]
        return [sum(values) / 200 for values in zip(*found, strict=True)]

    imu.run(50)
    still = mean()
    imu.write(0x1C, 0xE0)
    imu.write(0x1B, 0xE0)
    imu.run(25)
    excited = mean()
    codes = [*imu.read(0x0D, 3), 0, *imu.read(0x00, 3)]
    for word in (0, 1, 2, 4, 5, 6):
        trim = 2620 * 1.01 ** (codes[word] - 1)
        assert (excited[word] - still[word]) / trim == pytest.approx(1, abs=0.14)


def test_magnetometer_behind_the_auxiliary_master_as_flight_controllers_have_it(make_imu) -> None:
    """Writes and reads of the AK8963 by slave 0, a millisecond each; then seven bytes at every sample."""
    imu = make_imu()

    def ak_write(register: int, value: int) -> None:
        imu.write(0x25, 0x0C)
        imu.write(0x26, register)
        imu.write(0x63, value)
        imu.write(0x27, 0x81)
        imu.run(1)

    def ak_read(register: int, count: int) -> bytes:
        imu.write(0x25, 0x8C)
        imu.write(0x26, register)
        imu.write(0x27, 0x80 | count)
        imu.run(1)
        return imu.read(0x49, count)

    imu.write(0x6B, 0x01)
    imu.write(0x6A, 0x20)
    imu.write(0x24, 0x0D)
    ak_write(0x0A, 0x00)
    imu.write(0x6B, 0x80)
    imu.run(100)
    imu.write(0x6B, 0x01)
    assert imu.byte(0x75) == 0x71
    imu.write(0x1D, 0x01)
    imu.write(0x1A, 0x01)
    imu.write(0x19, 0x00)
    imu.write(0x6A, 0x20)
    imu.write(0x24, 0x0D)
    assert ak_read(0x00, 1) == b"\x48"
    ak_write(0x0A, 0x00)
    imu.run(100)
    ak_write(0x0A, 0x0F)
    imu.run(100)
    assert all(160 <= code <= 190 for code in ak_read(0x10, 3))
    ak_write(0x0A, 0x00)
    imu.run(100)
    ak_write(0x0A, 0x16)
    # As long as slave 0 writes the mode at each sample, every measurement is begun anew.
    assert ak_read(0x03, 7)[6] == 0x10
    imu.run(100)
    data = imu.read(0x3B, 21)
    words = [int.from_bytes(data[at : at + 2], "little", signed=True) for at in (14, 16, 18)]
    assert words[0] > 80
    assert words[2] < -70
    assert data[20] == 0x10


def test_single_measurements_triggered_by_slave_1(make_imu) -> None:
    """Slave 0 reads eight bytes from ST1 on, slave 1 starts the next measurement, both once in five samples."""
    imu = make_imu()
    imu.write(0x19, 9, 0x03)
    imu.write(0x24, 0x40)
    imu.write(0x25, 0x8C, 0x02, 0x88)
    imu.write(0x28, 0x0C, 0x0A, 0x81)
    imu.write(0x64, 0x11)
    imu.write(0x34, 0x04)
    imu.write(0x67, 0x03)
    imu.write(0x6A, 0x20)
    imu.run(130)
    data = imu.read(0x49, 8)
    assert data[0] == 0x01
    assert int.from_bytes(data[1:3], "little", signed=True) > 80
    assert data[7] == 0x10


def test_wake_on_motion_in_low_power(make_imu, rest) -> None:
    """Gyroscope off, cycling at 31 Hz, threshold 40 mg: a knock wakes the host, rest does not."""
    knock = lambda ns: {**rest, "ay": 3.0 if 600 * MS <= ns < 700 * MS else 0.0}  # noqa: E731
    imu = make_imu(knock, step_ns=5 * MS)
    for register, value in (
        (0x6B, 0x00),
        (0x6C, 0x07),
        (0x1D, 0x09),
        (0x38, 0x40),
        (0x69, 0xC0),
        (0x1F, 10),
        (0x1E, 0x07),
        (0x6B, 0x20),
    ):
        imu.write(register, value)
    imu.run_to(590 * MS)
    assert imu.rises() == []
    imu.run_to(900 * MS)
    assert len(imu.rises()) == 2
    assert 600 * MS <= imu.rises()[0] <= 650 * MS
