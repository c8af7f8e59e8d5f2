"""An inertial sensor and a GPS receiver at a board whose program reads them; a part at the far end of a USART."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from hilbench.mcu.emulated import EmulatedBench
from protocols.pkt import Frame, FrameReader, GpsReport, ImuReport, decode_report
from targets.firmware import image_path

ROVER = """version = 1
[targets.brain]
board = "nucleo-f767zi"
firmware = "{image}"
[world]
vehicle = "rover-4wd"
scene = "hard-floor"
[parts.imu]
kind = "mpu9250"
buses = {{ i2c = "brain.I2C1" }}
pins = {{ int = "brain.PA8" }}
[parts.imu.settings]
accel_noise_ug_rthz = 0
mag_noise_ut = 0
zero_g_xy_mg = 0
zero_g_z_mg = 0
sensitivity_percent = 0
zero_field_ut = 0
clock_tolerance_percent = 0
[parts.imu.signals]
ax = "world.ax"
ay = "world.ay"
az = "world.az"
wx = "world.wx"
wy = "world.wy"
wz = "world.wz"
roll = "world.roll"
pitch = "world.pitch"
yaw = "world.yaw"
[parts.gps]
kind = "neo6m"
[parts.gps.settings]
start = "hot"
hot_s = 0.1
accuracy_m = 0
noise_m = 0
[parts.gps.signals]
x = "world.x"
y = "world.y"
z = "world.z"
vx = "world.vx"
vy = "world.vy"
vz = "world.vz"
[[links]]
ends = ["brain.usart2", "gps.uart1"]
"""

ECHO = """version = 1
[targets.brain]
board = "bluepill"
firmware = "{image}"
[parts.gps]
kind = "neo6m"
[parts.gps.settings]
baud = {baud}
[parts.gps.signals]
x = "world.x"
y = "world.y"
z = "world.z"
vx = "world.vx"
vy = "world.vy"
vz = "world.vz"
[world]
vehicle = "rover-4wd"
[[links]]
ends = ["brain.usart1", "gps.uart1"]
"""


DOCS = Path(__file__).parents[4] / "docs" / "sensors.md"


def reports(data: bytes, kind: type) -> list:
    frames = [found for found in FrameReader().receive(bytes(data), 0) if isinstance(found, Frame)]
    return [report for report in map(decode_report, (frame.payload for frame in frames)) if isinstance(report, kind)]


def test_the_example_of_the_docs_is_a_bench_file(read):
    head = '[targets.brain]\nboard = "nucleo-f767zi"\nfirmware = "a.elf"\n[world]\nvehicle = "rover-4wd"\n'
    example = DOCS.read_text(encoding="utf-8").split("```toml\n")[1].split("```")[0]
    found = read("version = 1\n" + head + example)
    assert {name: plan.kind for name, plan in found.parts.items()} == {"imu": "mpu9250", "gps": "neo6m"}
    assert found.links[0].ends == ("brain.usart2", "gps.uart1")


@pytest.mark.needs_physics
def test_the_rovers_program_reads_its_sensors(read):
    """At rest, with the nose to the east, at the world's origin."""
    emulated = EmulatedBench(read(ROVER.format(image=image_path("rover"))), seed=1)
    try:
        said, edges = bytearray(), []
        emulated.machines["brain"].chip.pins["PA8"].on_edge(lambda _cycle, ns, level: edges.append((ns, level)))
        emulated.ports["brain.usart3"].taps.append(lambda data, _ns: said.extend(data))
        emulated.bench.scheduler.run_until(None, 2_100_000_000)
        imu, gps = reports(said, ImuReport)[-1], reports(said, GpsReport)[-1]
    finally:
        emulated.close()
    rises = [ns for ns, level in edges if level][1:]  # the first one tells of a sample before it was enabled
    assert len(rises) > 60  # each of the readings at rest, then ten a second
    assert {round((ns - rises[0]) / 1000) % 5000 for ns in rises} <= {0, 1, 4999}  # 200 Hz, whenever it is read
    assert imu.validity == 3
    assert imu.acceleration == pytest.approx((0, 0, 9.81), abs=0.02)
    assert imu.rate_deg_s == pytest.approx((0, 0, 0), abs=0.3)
    assert imu.temperature_c == pytest.approx(25, abs=0.01)
    assert imu.field_mgauss == pytest.approx((-28.72, 170.30, 147.49), abs=1.5)
    assert (gps.first_deg, gps.second_deg) == pytest.approx((-34.6175, -58.3683), abs=1e-5)
    x, y, z, w = imu.quaternion
    heading_deg = math.degrees(math.atan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))
    assert heading_deg == pytest.approx(-90 - 9.57, abs=3)


@pytest.mark.needs_physics
@pytest.mark.parametrize(("baud", "heard"), [(115200, True), (9600, False)])
def test_a_part_at_a_usart_has_its_own_rate_and_hears_answers(read, baud, heard):
    """What the receiver says comes back from the program, and is no sentence that it knows."""
    emulated = EmulatedBench(read(ECHO.format(image=image_path("echo-irq"), baud=baud)), seed=1)
    try:
        answers = bytearray()
        emulated.ports["brain.usart1"].heard_taps.append(lambda data, _ns: answers.extend(data))
        emulated.bench.scheduler.run_until(None, 320_000_000)
    finally:
        emulated.close()
    assert answers.startswith(b"$GPTXT,01,01,02,u-blox ag - www.u-blox.com*50\r\n")
    assert (b"$GPTXT,01,01,01,NMEA unknown msg*58\r\n" in answers) is heard
