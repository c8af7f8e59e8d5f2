"""Which messages are dropped though their letters are right: values that cannot be true, or cannot be meant."""

from __future__ import annotations

from protocols.carla.frames import CommandFrame, Mode, StatusFrame, finite
from protocols.carla.options import BoardOptions, CommandLimits, SimulatorOptions, StatusLimits
from protocols.carla.reading import DropReason

__all__ = ["clamped", "command_fault", "simulator_fault", "status_fault"]


def status_fault(options: BoardOptions, frame: StatusFrame | CommandFrame) -> DropReason | None:
    """Why the board drops a status; None if it does not."""
    if not isinstance(frame, StatusFrame):
        return None
    if options.finite_only and not finite(frame):
        return DropReason.NOT_FINITE
    limits = options.status_limits
    return DropReason.IMPLAUSIBLE if limits is not None and not _status_fits(frame, limits) else None


def command_fault(options: BoardOptions, frame: CommandFrame) -> DropReason | None:
    """Why the board does not hand on what the driving stack commands; None if it does."""
    return _fault(frame, finite_only=options.finite_only, limits=options.command_limits)


def simulator_fault(options: SimulatorOptions, frame: StatusFrame | CommandFrame) -> DropReason | None:
    """Why the simulator drops a command; None if it does not."""
    if not isinstance(frame, CommandFrame):
        return None
    if frame.mode not in tuple(Mode):
        return DropReason.UNKNOWN_MODE
    return _fault(frame, finite_only=options.finite_only, limits=options.limits)


def clamped(frame: CommandFrame) -> CommandFrame:
    """A command of the joystick with its fields within their ranges; another one as it is. NaN stays NaN."""
    if frame.mode != Mode.MANUAL:
        return frame
    return CommandFrame(
        steering=_clamp(frame.steering, -1.0),
        speed=_clamp(frame.speed, 0.0),
        acceleration=_clamp(frame.acceleration, 0.0),
        mode=frame.mode,
    )


def _clamp(value: float, least: float) -> float:
    return least if value < least else min(value, 1.0)


def _fault(frame: CommandFrame, *, finite_only: bool, limits: CommandLimits | None) -> DropReason | None:
    if finite_only and not finite(frame):
        return DropReason.NOT_FINITE
    return DropReason.IMPLAUSIBLE if limits is not None and not _command_fits(frame, limits) else None


def _status_fits(status: StatusFrame, limits: StatusLimits) -> bool:
    return (
        not abs(status.lon_speed_m_s) > limits.speed_m_s
        and not abs(status.lat_speed_m_s) > limits.speed_m_s
        and not abs(status.heading_rate_rad_s) > limits.heading_rate_rad_s
        and not abs(status.steering_rad) > limits.steering_rad
    )


def _command_fits(frame: CommandFrame, limits: CommandLimits) -> bool:
    if frame.mode == Mode.MANUAL:
        return not max(abs(frame.steering), abs(frame.speed), abs(frame.acceleration)) > limits.manual
    return (
        not abs(frame.steering) > limits.steering_rad
        and not abs(frame.steering_rate) > limits.steering_rate_rad_s
        and not abs(frame.speed) > limits.speed_m_s
        and not abs(frame.acceleration) > limits.acceleration_m_s2
        and not abs(frame.jerk) > limits.jerk_m_s3
    )
