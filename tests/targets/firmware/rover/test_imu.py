"""The inertial sensor, read from the model of an MPU-9250 over a bus without a chip; then missing and hanging."""

from __future__ import annotations

import itertools
import math
import struct

import pytest

from protocols.pkt import PROFILES, FrameReader, Schema, attitude_wxyz, decode_report
from targets.mcu.i2c_bus import I2cBus
from targets.parts.mpu9250 import Mpu9250, Mpu9250Settings, SensorNote
from targets.parts.testing import PartBench
from tests.share import few

G = 9.80665
IDEAL = {
    "accel_noise_ug_rthz": 0,
    "gyro_noise_dps_rthz": 0,
    "mag_noise_ut": 0,
    "zero_g_xy_mg": 0,
    "zero_g_z_mg": 0,
    "zero_rate_dps": 0,
    "sensitivity_percent": 0,
    "zero_field_ut": 0,
}
LEVEL = {"ax": 0.0, "ay": 0.0, "az": G, "wx": 0.0, "wy": 0.0, "wz": 0.0, "roll": 0.0, "pitch": 0.0, "yaw": 0.0}
NORTH_FIELD = {"field_north_nt": 20000.0, "field_east_nt": 0.0, "field_down_nt": -15000.0}
BYTE_NS = 25_000


class Bus:
    """A sensor on the rover's bus: each transfer of the program is carried out at its time, byte by byte."""

    def __init__(self, rover, *, state=LEVEL, settings=(), image="rover"):
        self.state = dict(state)
        self._turning_since_ns = 0
        self.bench = PartBench(
            Mpu9250,
            Mpu9250Settings(**{**IDEAL, **NORTH_FIELD, **dict(settings)}),
            quantities=self._at,
            step_ns=4_000_000,
        )
        self.bus = I2cBus()
        self.bus.attach(self.bench.part.slave("i2c"))
        self.chip = rover(image)
        self.chip.slave.carry_out = self._carry_out

    def _at(self, ns):
        yaw = self.state["yaw"] + self.state["wz"] * (ns - self._turning_since_ns) / 1e9
        return {**self.state, "yaw": yaw}

    def turn(self, rate, seconds):
        """Turn to the left on the level, in rad/s, and stop."""
        for wz in (rate, 0.0):
            self.state["yaw"] = self._at(self.bench.now_ns)["yaw"]
            self.state["wz"], self._turning_since_ns = wz, self.bench.now_ns
            self.run(seconds if wz else 0.0)
        return self

    def _tick(self):
        self.bench.run_to(self.bench.now_ns + BYTE_NS)
        return self.bench.now_ns

    def _carry_out(self, address, reg, count, value):
        self.bench.run_to(max(self.bench.now_ns, self.chip.now_us * 1000))
        bus = self.bus
        bus.start(self.bench.now_ns)
        found = b""
        acknowledged = bus.address(address, False, self._tick()) and bus.write(reg, self._tick())
        if acknowledged and value is not None:
            acknowledged = bus.write(value, self._tick())
        elif acknowledged:
            bus.start(self._tick())
            acknowledged = bus.address(address, True, self._tick())
            found = bytes(bus.read(self._tick()) for _ in range(count)) if acknowledged else b""
        bus.stop(self._tick())
        return found if acknowledged else None

    def run(self, seconds):
        self.chip.run(seconds)
        return self

    @property
    def report(self):
        return imu_report(self.chip)

    @property
    def notes(self):
        return self.bench.told(SensorNote)


def imu_report(chip, schema=Schema.V2):
    chip.fetch()
    chip.run(1.0)
    payloads = [frame.payload for frame in FrameReader().receive(chip.fetch(), 0)]
    return next(decode_report(payload, schema) for payload in payloads if payload[0] == 0x82)


def status_of(chip):
    chip.fetch()
    chip.write(bytes.fromhex("504B54210100E1F00A")).run(0.02)
    return next(frame.payload[5] for frame in FrameReader().receive(chip.fetch(), 0) if frame.payload[0] == 0x80)


def test_at_rest(rover):
    bus = Bus(rover).run(2.0)
    report = bus.report
    assert report.validity == 3
    assert report.acceleration == pytest.approx((0.0, 0.0, G), abs=0.01)
    assert report.rate_deg_s == pytest.approx((0.0, 0.0, 0.0), abs=0.01)
    assert report.temperature_c == pytest.approx(25.0, abs=0.1)
    assert status_of(bus.chip) & 1 == 0


def test_nothing_is_done_that_the_sensor_minds(rover):
    assert Bus(rover).run(5.0).notes == []


def test_readings_begin_within_a_second(rover):
    bus = Bus(rover).run(0.9)
    assert bus.chip.code.bytes_at(bus.chip.code.symbols["imu"], 1) == b"\1"


def test_units_axes_and_signs(rover):
    bus = Bus(rover).run(1.5)
    bus.state |= {"ax": 1.0, "ay": -2.0, "az": 3.0, "wx": 0.1, "wy": -0.2, "wz": 0.3}
    report = bus.run(1.0).report
    assert report.acceleration == pytest.approx((1.0, -2.0, 3.0), abs=0.01)
    assert report.rate_deg_s == pytest.approx([math.degrees(rate) for rate in (0.1, -0.2, 0.3)], abs=0.05)


def test_the_field_is_in_the_axes_of_the_other_two(rover):
    """Looking to magnetic north in the southern hemisphere: forwards, and up."""
    report = Bus(rover, state={**LEVEL, "yaw": math.pi / 2}).run(1.5).report
    assert report.field_mgauss == pytest.approx((200.0, 0.0, 150.0), abs=3.0)


def test_the_field_to_the_west(rover):
    """Looking east the north is to the left, which is Y."""
    report = Bus(rover).run(1.5).report
    assert report.field_mgauss == pytest.approx((0.0, 200.0, 150.0), abs=3.0)


def test_a_bias_of_the_gyroscope_is_calibrated_away(rover):
    bus = Bus(rover, settings={"zero_rate_dps": 5.0, "gyro_noise_dps_rthz": 0.01}).run(2.0)
    assert bus.report.rate_deg_s == pytest.approx((0.0, 0.0, 0.0), abs=0.3)


def test_a_rover_that_turns_while_it_is_calibrated_keeps_its_rate(rover):
    bus = Bus(rover)
    rates = itertools.cycle([0.0, 0.5])
    for _ in range(30):
        bus.state["wz"] = next(rates)
        bus.run(0.05)
    bus.state["wz"] = 0.5
    assert bus.run(0.5).report.rate_deg_s[2] == pytest.approx(math.degrees(0.5), abs=0.1)


def test_the_attitude_towards_magnetic_north(rover):
    report = Bus(rover, state={**LEVEL, "yaw": math.pi / 2}).run(3.0).report
    assert report.quaternion == pytest.approx((0.0, 0.0, 0.0, 1.0), abs=0.02)


def test_the_quaternions_other_order_and_none(rover):
    north = {**LEVEL, "yaw": math.pi / 2}
    for image in ("rover-quat-wxyz", "rover-g2"):
        assert Bus(rover, state=north, image=image).run(3.0).report.quaternion[0] == pytest.approx(1.0, abs=0.01)
    report = Bus(rover, state=north, image="rover-nan-quaternion").run(3.0).report
    assert all(math.isnan(part) for part in report.quaternion)


def test_acceleration_in_g(rover):
    for image in ("rover-accel-g", "rover-g2"):
        assert Bus(rover, image=image).run(2.0).report.acceleration == pytest.approx((0.0, 0.0, 1.0), abs=0.01)


@pytest.mark.parametrize("heading_deg", few([60.0, 0.0, 90.0, 180.0, -90.0], 2, "other headings"))
def test_the_heading_is_found(rover, heading_deg):
    """Counted from east as in the world; the quaternion from magnetic north. Both to the left."""
    bus = Bus(rover, state={**LEVEL, "yaw": math.radians(heading_deg)}).run(3.0)
    w, x, y, z = attitude_wxyz(bus.report, PROFILES["documented"].dialect)
    yaw = math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    assert math.remainder(math.degrees(yaw) - (heading_deg - 90), 360) == pytest.approx(0.0, abs=2.0)


def test_a_slope_is_found(rover):
    """Nose up by 20 degrees: gravity pulls backwards, so the specific force has a part forwards."""
    pitch = math.radians(20)
    leaning = {**LEVEL, "ax": G * math.sin(pitch), "az": G * math.cos(pitch), "pitch": -pitch, "yaw": math.pi / 2}
    w, x, y, z = attitude_wxyz(Bus(rover, state=leaning).run(3.0).report, PROFILES["documented"].dialect)
    up_x = 2 * (x * z - w * y)  # how far the earth's up points forwards
    assert up_x == pytest.approx(math.sin(pitch), abs=0.02)
    assert abs(x) < 0.02


def test_the_angles_of_the_arduino_firmware(rover):
    bus = Bus(rover, image="rover-g0").run(1.5).turn(0.2, 5.0)
    report = imu_report(bus.chip, Schema.V1)
    assert report.magnetic_angles_rad == pytest.approx((0.0, 0.0, 1.0 - math.pi / 2), abs=0.03)
    assert report.gyro_angles_rad == pytest.approx((0.0, 0.0, 1.0), abs=0.05)
    assert report.acceleration == pytest.approx((0.0, 0.0, 1.0), abs=0.01)


@pytest.mark.parametrize("rate", few([-1.5, 0.5, 3.0], 1, "other rates"))
def test_turning_is_followed(rover, rate):
    """Once around and a quarter, at ten readings a second."""
    angle = 2.5 * math.pi
    bus = Bus(rover, state={**LEVEL, "yaw": math.pi / 2}).run(2.0).turn(rate, angle / abs(rate))
    x, y, z, w = bus.run(0.3).chip.code.quaternion
    turned = math.copysign(angle, rate)
    assert math.remainder(2 * math.atan2(z, w) - turned, 2 * math.pi) == pytest.approx(0.0, abs=0.05 + 0.05 * abs(rate))
    assert (x, y) == pytest.approx((0.0, 0.0), abs=0.03)


# --- what goes wrong


def test_without_a_sensor(rover):
    chip = rover().run(0.5)
    assert status_of(chip) & 1
    report = imu_report(chip)
    assert report.validity == 0
    assert report.quaternion == (0.0, 0.0, 0.0, 1.0)


def test_status_stays_zero_where_nothing_writes_it(rover):
    for image in ("rover-status-zero", "rover-g2"):
        assert status_of(rover(image).run(5.0)) == 0


def test_a_sensor_with_another_name_is_none(rover):
    chip = rover()
    chip.slave.devices = {0x68: {0x75: 0x70}}
    assert status_of(chip.run(0.5)) & 1


def test_without_the_magnetometer_there_is_gravity(rover):
    bus = Bus(rover)
    bus.bus.deaf.add(0x0C)
    report = bus.run(3.0).report
    assert report.validity == 1
    assert report.acceleration == pytest.approx((0.0, 0.0, G), abs=0.01)
    assert report.quaternion == pytest.approx((0.0, 0.0, 0.0, 1.0), abs=0.01)


def test_a_sensor_that_goes_and_comes_back(rover):
    bus = Bus(rover).run(2.0)
    bus.bus.deaf |= {0x68, 0x0C}
    assert status_of(bus.run(0.3).chip) & 1
    bus.bus.deaf.clear()
    bus.run(2.5)
    assert status_of(bus.chip) & 1 == 0
    assert bus.report.validity == 3


def test_a_bus_that_hangs_is_recovered_and_stops_nothing(rover):
    bus = Bus(rover).run(2.0)
    bus.chip.slave.hanging = True
    bus.chip.fetch()
    bus.run(2.0)
    payloads = [frame.payload for frame in FrameReader().receive(bus.chip.fetch(), 0)]
    assert [payload[0] for payload in payloads].count(0x83) == 8
    assert status_of(bus.chip) & 1
    assert bus.chip.slave.recovered >= 2
    bus.chip.slave.hanging = False
    assert status_of(bus.run(2.5).chip) & 1 == 0


def test_data_that_is_never_new_is_a_failure(rover):
    chip = rover()
    chip.slave.devices = {0x68: {0x75: 0x71, 0x3A: 0x00}, 0x0C: {0x00: 0x48}}
    chip.run(1.0)
    assert status_of(chip) & 1


def test_a_field_that_is_too_strong_is_not_valid(rover):
    motion = {0x75: 0x71, 0x3A: 0x01, 0x3F: 0x40}
    chip = rover()
    chip.slave.devices = {0x68: motion, 0x0C: {0x00: 0x48, 0x02: 0x01, 0x09: 0x08}}
    assert imu_report(chip.run(1.5)).validity == 1
    chip.slave.devices[0x0C][0x09] = 0
    assert imu_report(chip).validity == 3


def test_registers_become_numbers(rover):
    """Full scale: 2 g, 250 deg/s; the data sheets' steps."""
    raw = struct.pack(">7h", 16384, -16384, 8192, 3339, 0, 0, 0)
    registers = {0x75: 0x71, 0x3A: 0x01} | {0x3B + n: byte for n, byte in enumerate(raw)}
    field = {0x00: 0x48, 0x02: 0x01} | {0x10: 128, 0x11: 192, 0x12: 64}
    field |= {0x03 + n: byte for n, byte in enumerate(struct.pack("<3h", 100, 200, -300))}
    chip = rover()
    chip.slave.devices = {0x68: registers, 0x0C: field}
    report = imu_report(chip.run(1.5))
    assert report.acceleration == pytest.approx((G, -G, G / 2))
    assert report.temperature_c == pytest.approx(31.0, abs=0.01)
    assert report.field_mgauss == pytest.approx((200 * 1.5 * 1.25, 100 * 1.5, 300 * 1.5 * 0.75))
