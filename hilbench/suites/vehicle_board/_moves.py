"""What the cases of several files do to the board, and require of it."""

from __future__ import annotations

from collections.abc import Sequence

from hilbench.check import Untimely
from hilbench.clock import NS_PER_S
from hilbench.suites._vehicle import MISSES, MODE_WITHIN_S, STATUS, STATUS_HZ, STATUS_MISS_S, Frame, Vehicle
from protocols.autoware import AckermannControlCommand, VelocityReport
from protocols.carla import VECTORS, CommandFrame, Mode, decode_command

__all__ = [
    "AGENT_WAIT_S",
    "EXACTLY",
    "F1",
    "F3",
    "IMPOSSIBLE_M_S",
    "MANUAL_MISS_S",
    "MANUAL_S",
    "OTHER_WAY",
    "OTHER_WAY_FRAME",
    "PING_S",
    "REPORT_WITHIN_S",
    "WHICH",
    "behind",
    "between_lines_s",
    "nine_misses",
    "nine_misses_around_a_status",
    "quiet",
    "require_emergencies",
    "require_emergency",
    "require_newest",
    "say_a_hundred",
    "status_returns",
]

F1 = decode_command(VECTORS["F1"].data)

F3 = decode_command(VECTORS["F3"].data)

OTHER_WAY = AckermannControlCommand(
    steering_tire_angle=-0.4, steering_tire_rotation_rate=0.25, speed=-2.0, acceleration=-3.0, jerk=-0.5
)
"""To the right, in reverse and braking: each sign that F1 does not have."""

OTHER_WAY_FRAME = CommandFrame(
    steering=-0.48, steering_rate=0.3, speed=-2.0, acceleration=-3.0, jerk=-0.5, mode=Mode.AUTOWARE
)

MANUAL_S, MANUAL_MISS_S = 0.060, 0.160

AGENT_WAIT_S = 20.0

PING_S = 1.0
"""How often a board asks whether somebody is there that has no answer yet."""

WHICH = "frames may have other causes than they seem to have"
"""What comes of a bench that is late by as much as frames lie apart."""

EXACTLY = 0.5
"""Tolerance of a whole number that has to be right."""

IMPOSSIBLE_M_S = 1e30

ADAPTER_S = 0.016
"""How long an adapter to USB may keep bytes: what an FT232R begins with (FTDI AN232B-04)."""

REPORT_WITHIN_S = 0.003
"""How long the last byte of a status and the first of a report may lie apart, their own time on the line with it."""


def nine_misses(vehicle: Vehicle, mark: int, mode: Mode, count: int, step_s: float) -> None:
    """Wait for the frames since a mark that nine misses make; require that they have a mode and come at a steady pace.

    Raises:
        Violation: they do not.
    """
    begun_ns = vehicle.bench.now_ns
    found = vehicle.bench.run_until(lambda: len(vehicle.frames(mark)) >= count, (count + 1) * step_s + 0.2)
    vehicle.simulator.require_punctual(begun_ns, step_s / 4, WHICH)
    frames = vehicle.frames(mark)
    if not found:
        raise Untimely(f"{len(frames)} frames came in {count} times {step_s:g} s", vehicle.shown(frames))
    vehicle.require_modes(frames, mode)
    vehicle.require_steps(frames, step_s, "between frames while nothing is said", unprompted=True)


def nine_misses_around_a_status(vehicle: Vehicle, mode: Mode, step_s: float) -> None:
    """While statuses are missing, say one behind a frame, and twice more behind nine misses; require one mode."""
    mark = vehicle.mark()
    vehicle.bench.run_until(lambda: vehicle.mark() > mark, 2 * step_s)
    for _ in range(2):
        mark = vehicle.mark()
        vehicle.say(STATUS)
        nine_misses(vehicle, mark, mode, MISSES, step_s)
    mark = vehicle.mark()
    vehicle.say(STATUS, 2 * step_s)
    vehicle.require_modes(vehicle.frames(mark), mode)


def require_emergency(vehicle: Vehicle, frames: Sequence[Frame]) -> None:
    """Require that frames are F3, in every field."""
    assert frames, "no frame came"
    for got in frames:
        vehicle.require_frame(got, F3, "the frame of the emergency")


def require_emergencies(vehicle: Vehicle, found: int, wanted: int, since_ns: int) -> None:
    """Require how many frames of an emergency came since its first: without a second one no pace is to be seen."""
    rate_hz = 1 / STATUS_MISS_S
    vehicle.require_count(found, wanted, 1, what="frames of the emergency", since_ns=since_ns, rate_hz=rate_hz)


def status_returns(vehicle: Vehicle) -> int:
    """Have statuses come back in EMERGENCY; return a mark in the frames from then on."""
    vehicle.emergency()
    vehicle.run(0.15)
    mark = vehicle.mark()
    vehicle.simulator.statuses.start(STATUS_HZ)
    vehicle.wait_for(Mode.MANUAL, MODE_WITHIN_S, mark)
    return mark


def behind(vehicle: Vehicle, frame: Frame) -> int:
    """Return a mark behind a frame."""
    return vehicle.simulator.received.index(frame) + 1


def quiet(vehicle: Vehicle) -> int:
    """In AUTOWARE, let statuses stop between two of them; return a mark in the reports from then on."""
    vehicle.autoware()
    statuses = vehicle.simulator.statuses
    said = statuses.said
    vehicle.bench.run_until(lambda: statuses.said > said, 0.2)
    statuses.stop()
    vehicle.run(0.02)
    return vehicle.stack.mark()


def say_a_hundred(vehicle: Vehicle) -> list[tuple[int, float]]:
    """Change the status each time it is said, in whole m/s; return when each was said, in ns, and its speed."""
    statuses = vehicle.simulator.statuses
    said_ns = []
    for number in range(100):
        speed_m_s = float(1 + number % 30)
        vehicle.other_status(speed_m_s)
        said = statuses.said
        vehicle.bench.run_until(lambda said=said: statuses.said > said, 0.2)  # type: ignore[misc]
        said_ns.append((vehicle.bench.now_ns, speed_m_s))
    return said_ns


def between_lines_s(vehicle: Vehicle, since_ns: int) -> float:
    """Return how far off times may be that lie between bytes of both lines, over what happened since a time."""
    uncertainty_s = vehicle.uncertainty_s(since_ns)
    return uncertainty_s + ADAPTER_S if uncertainty_s else 0.0


def require_newest(vehicle: Vehicle, stack_mark: int, newest: Sequence[tuple[int, float]]) -> int:
    """Require that each report since a mark is of the status that was the newest then; return how many there are.

    Args:
        vehicle: the board.
        stack_mark: the mark of its reports.
        newest: what `say_a_hundred` returned.

    Raises:
        Violation: one of them is of another status.
    """
    late_ns = round((REPORT_WITHIN_S + between_lines_s(vehicle, newest[0][0])) * NS_PER_S)
    reports = vehicle.stack.since(stack_mark, VelocityReport)
    for got, report in reports:
        of_old = [speed for when_ns, speed in newest if when_ns <= got.start_ns - late_ns][-1:]
        since = [speed for when_ns, speed in newest if got.start_ns - late_ns < when_ns <= got.start_ns]
        if report.longitudinal_velocity not in (*of_old, *since) and newest[0][0] < got.start_ns - late_ns:
            found, at_s = report.longitudinal_velocity, got.start_ns / NS_PER_S
            raise Untimely(f"{found:g} m/s is reported at {at_s:.4f} s, the newest are {[*of_old, *since]}")
    return len(reports)
