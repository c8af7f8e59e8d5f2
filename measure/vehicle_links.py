"""The way from a command of the driving stack to the car, over either link of the vehicle interface: how long it takes.

    python -m measure.vehicle_links > docs/vehicle-links.md

Our firmware on the emulated board, in virtual time: with the stand-in link, and with DDS-XRCE and an agent. Times are
taken from when something is written to the last byte of what comes of it.
"""

from __future__ import annotations

import contextlib
import itertools
import random
import sys
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

from hilbench.bench import Bench
from hilbench.benchfile.reader import read_bench
from hilbench.clock import NS_PER_MS, Scheduler
from hilbench.journal import Journal
from hilbench.mcu.emulated import EmulatedBench
from hilbench.systems.vehicle.micro_ros_peer import stack_peer
from hilbench.systems.vehicle.micro_ros_settings import MicroRosSettings
from hilbench.systems.vehicle.simulator_peer import SimulatorPeer
from hilbench.systems.vehicle.stack_peer import StackPeer
from protocols.autoware import (
    AckermannControlCommand,
    ControlMode,
    ControlModeRequest,
    ControlModeResponse,
    VelocityReport,
)
from protocols.carla import Mode, StatusFrame
from targets.firmware import image_path
from targets.robots.vehicle_interface import SIMULATOR_LINE, STACK_LINE

__all__ = ["LINKS", "Measured", "measured", "page"]

BENCH = Path(__file__).parent / "deadlines" / "h753.toml"
LINKS = {"stand-in": ("vehicle", None), "micro-ROS": ("vehicle-micro-ros", MicroRosSettings())}
"""The image of each, and the agent."""

_SECONDS = 5.0


@dataclass(frozen=True, kw_only=True)
class Measured:
    """What was measured of a link; times in ms.

    Attributes:
        start: from power-on to the first frame with a command, with commands at 30 Hz.
        commands: from a command, while the board waits for one, to its frame.
        ages: at 30 Hz, with statuses at 20 Hz: how old the command in each frame is.
        late: of these frames, how much later than 50 ms each came after the one before.
        reports: from a status to its velocity report, with commands at 30 Hz.
        answers: from a request for a mode to its answer.
        up, down: bytes a second on the driving stack's line, from the board and to it.
        back: from when the driving stack's end comes back, after 5 s, to its first answer to a request.
    """

    start: float
    commands: list[float]
    ages: list[float]
    late: list[float]
    reports: list[float]
    answers: list[float]
    up: float
    down: float
    back: float


class _Rig:
    def __init__(self, bench: Bench, simulator: SimulatorPeer, stack: StackPeer) -> None:
        self.bench, self.simulator, self.stack = bench, simulator, stack
        self.chance = random.Random(26)
        self.written = 0
        self._written_ns: dict[float, int] = {}
        write = stack.port.write

        def counted(data: bytes) -> None:
            self.written += len(data)
            write(data)

        stack.port.write = counted  # type: ignore[method-assign]

    def command(self, number: int) -> None:
        """Command a speed of its own; note when it was written."""
        speed = number / 64  # exact in 32 bits
        self._written_ns[speed] = self.bench.now_ns
        self.stack.send(AckermannControlCommand(speed=speed))

    def ages(self, mark: int) -> list[float]:
        """How old the commands of the frames are, in ms, where they were written: not sent again by the board."""
        found = [got for got in self.simulator.frames(mark) if got.packet and got.packet.mode == Mode.AUTOWARE]
        pairs = [(got, self._written_ns.get(got.packet.speed)) for got in found if got.packet]
        return [(got.at_ns - ns) / NS_PER_MS for got, ns in pairs if ns is not None]


@contextlib.contextmanager
def _rig(link: str) -> Iterator[_Rig]:
    image, settings = LINKS[link]
    bench_file = read_bench(BENCH)
    brain = replace(bench_file.boards["brain"], firmware=image_path(image))
    bench = Bench(Scheduler(), Journal())
    with contextlib.closing(EmulatedBench(replace(bench_file, boards={"brain": brain}), seed=0, bench=bench)) as there:
        ports = [there.ports[f"brain.{line}"] for line in (SIMULATOR_LINE, STACK_LINE)]
        for port in ports:
            port.reacts = True
        yield _Rig(bench, SimulatorPeer(bench, ports[0]), stack_peer(bench, ports[1], settings))


def measured(link: str, seconds: float = _SECONDS) -> Measured:
    """Measure a link, each figure over so many seconds of bench time."""
    with _rig(link) as rig:
        start = _start(rig)
        ages, late, up, down = _drive(rig, seconds)
        reports = _reports(rig, seconds)
        commands = _commands(rig, seconds)
        answers = _answers(rig, seconds)
        back = _back(rig)
    return Measured(
        start=start,
        commands=commands,
        ages=ages,
        late=late,
        reports=reports,
        answers=answers,
        up=up,
        down=down,
        back=back,
    )


def _until_autoware(rig: _Rig, mark: int) -> float:
    """Wait for a frame with a command; return when it began, in ms."""
    for number in range(1, 200):
        rig.command(number)
        if rig.bench.run_until(lambda: bool(rig.ages(mark)), 1 / 30):
            break
    first = next(got for got in rig.simulator.frames(mark) if got.packet and got.packet.speed)
    return first.at_ns / NS_PER_MS


def _start(rig: _Rig) -> float:
    rig.simulator.status = StatusFrame(lon_speed_m_s=1.0)
    rig.simulator.statuses.start(20.0)
    return _until_autoware(rig, 0)


def _drive(rig: _Rig, seconds: float) -> tuple[list[float], list[float], float, float]:
    """Drive at the usual rates."""
    mark, heard, written = rig.simulator.mark(), rig.stack.bytes_received, rig.written
    for number in range(round(30 * seconds)):
        rig.command(1 + number)
        rig.bench.run_for(1 / 30)
    frames = rig.simulator.frames(mark)
    late = [
        max(0.0, (later.start_ns - earlier.start_ns) / NS_PER_MS - 50) for earlier, later in itertools.pairwise(frames)
    ]
    up, down = (rig.stack.bytes_received - heard) / seconds, (rig.written - written) / seconds
    return rig.ages(mark), late, up, down


def _commands(rig: _Rig, seconds: float) -> list[float]:
    """Command now and then, where the board has its status and waits."""
    rig.simulator.statuses.start(100.0)
    mark = rig.simulator.mark()
    for number in range(round(20 * seconds)):
        rig.bench.run_for(rig.chance.uniform(0.040, 0.060))
        rig.command(5000 + number)
    rig.bench.run_for(0.05)
    return rig.ages(mark)


def _reports(rig: _Rig, seconds: float) -> list[float]:
    """Statuses with speeds of their own; when each is reported."""
    rig.simulator.statuses.stop()
    mark, said_ns = rig.stack.mark(), {}
    for number in range(round(20 * seconds)):
        rig.command(1 + number)
        rig.bench.run_for(0.010)
        said_ns[number / 64] = rig.bench.now_ns
        rig.simulator.send_status(StatusFrame(lon_speed_m_s=number / 64))
        rig.bench.run_for(rig.chance.uniform(0.030, 0.045))
    found = rig.stack.since(mark, VelocityReport)
    return [
        (got.at_ns - said_ns[report.longitudinal_velocity]) / NS_PER_MS
        for got, report in found
        if report.longitudinal_velocity in said_ns
    ]


def _answers(rig: _Rig, seconds: float) -> list[float]:
    rig.simulator.statuses.start(20.0)
    found = []
    for number in range(round(5 * seconds)):
        rig.command(1 + number)
        begun_ns = rig.bench.now_ns
        rig.stack.request(ControlMode.AUTONOMOUS)
        found.append((rig.bench.now_ns - begun_ns) / NS_PER_MS)
        rig.bench.run_for(rig.chance.uniform(0.02, 0.06))
    return found


def _back(rig: _Rig) -> float:
    """Have the driving stack's end away for 5 s, so that the board loses it; return when it answers again, in ms."""
    rig.stack.online = False
    rig.bench.run_for(5.0)
    rig.stack.go_online()
    begun_ns, mark = rig.bench.now_ns, rig.stack.mark()
    for number in range(_PATIENCE):
        rig.stack.send(ControlModeRequest(sequence=number, mode=ControlMode.MANUAL))
        if rig.bench.run_until(lambda: bool(rig.stack.since(mark, ControlModeResponse)), 0.02):
            break
    return (rig.bench.now_ns - begun_ns) / NS_PER_MS


def page(found: dict[str, Measured]) -> str:
    """Return the page of what was measured."""
    rows = [
        ("power-on to the first frame with a command", [f"{one.start:.1f}" for one in found.values()]),
        ("a command to its frame, where the board waits for it", [_spread(one.commands) for one in found.values()]),
        ("age of the command in a frame, at 30 and 20 Hz", [_spread(one.ages) for one in found.values()]),
        ("how late a frame is, of the 50 ms between two", [_spread(one.late) for one in found.values()]),
        ("a status to its velocity report", [_spread(one.reports) for one in found.values()]),
        ("a request for a mode to its answer", [_spread(one.answers) for one in found.values()]),
        ("back after 5 s: its first answer after", [f"{one.back:.1f}" for one in found.values()]),
        ("bytes a second from the board", [f"{one.up:.0f}" for one in found.values()]),
        ("bytes a second to the board", [f"{one.down:.0f}" for one in found.values()]),
    ]
    lines = [f"| ms: median, 95 %, most | {' | '.join(found)} |", "|---" * (1 + len(found)) + "|"]
    lines += [f"| {what} | {' | '.join(figures)} |" for what, figures in rows]
    return _PAGE.format(table="\n".join(lines))


def _spread(values: list[float]) -> str:
    ordered = sorted(values)
    return f"{ordered[len(ordered) // 2]:.2f}, {ordered[len(ordered) * 95 // 100]:.2f}, {ordered[-1]:.2f}"


_PATIENCE = 500
_PAGE = """\
<!-- Made by `python -m measure.vehicle_links`. -->

# The vehicle's two links

The vehicle interface speaks to its driving stack over a [stand-in link](autoware/stand-in-link.md), or as the original
over micro-ROS: by DDS-XRCE to an agent (`hilbench check vehicle-micro-ros`). This page says how long the way from a
command to the car takes with either, in ms. Our firmware runs on the emulated board, both lines have 921600 baud, and
time is virtual: the figures are those of lines and program alone. Times are from when something is written to the last
byte of what comes of it.

{table}

With micro-ROS a message has headers and a sample in CDR, and each on a reliable stream is acknowledged. At power-on a
session begins and 22 objects are created before a command can come. An agent that comes back is found by a ping. The
board sends one a second in the first 20 s after power-on, then each time its task runs, 100 to 200 ms apart.
"""


def main() -> int:
    """Measure, and print the page."""
    sys.stdout.write(page({link: measured(link) for link in LINKS}))
    return 0


if __name__ == "__main__":
    sys.exit(main())
