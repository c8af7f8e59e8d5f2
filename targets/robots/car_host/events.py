"""What a car host reports beside the events of its protocol. Do not subclass."""

from __future__ import annotations

from dataclasses import dataclass

from protocols.carla import AckermannCommand, ManualCommand

__all__ = ["CarCommanded"]


@dataclass(frozen=True, slots=True, kw_only=True)
class CarCommanded:
    """The car is told something.

    Attributes:
        command: what.
        mode: the mode byte of the frame that says so; None where no frame does.
        by_node: CARLA's ackermann node says it again, and no frame does.
    """

    command: AckermannCommand | ManualCommand
    mode: int | None = None
    by_node: bool = False
