"""How a rover behaves beyond its protocol, profile by profile.

Sources: manual, nhorro/ceai2020 rover_firmware/doc/index.md; G2, the same repository at 6058e92,
rover_firmware/application.cpp, filters/median, actuators/motor, controllers/pid; G0, nhorro/rover-firmware.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from protocols.pkt import PROFILES, Dialect, ServerOptions
from targets.robots.rover.plant import SLOTS

__all__ = ["BEHAVIOURS", "Behaviour", "BodyQuirks"]


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyQuirks:
    """What stands between the commands and the wheels, and between the sensors and the reports.

    Attributes:
        shown_limit_rpm: a faster wheel is shown as standing; None for none (G2: MAX_TACHO_VALID_RPM_READING, 150).
        median_begins: what the three last readings are before there are any, in rpm (G2: 0, 1, 2).
        position_known: whether 0x84 has a position (G2: `read_gps` is commented out).
        attitude_known: whether the quaternion is one (G2 begins with zeros in it, which its filter never leaves).
        led_shared: the test LED blinks until the first packet, and toggles with each one (G2).
        stop_reaches_motors: a lost link stops the motors, and not only the variables (G1 at 4720b70 zeroes those).
        slots: how many slots a disc has, as the firmware believes (G1: 32).
        mode_resets_controllers: the speed controllers begin anew when their mode is entered (choice; G2 goes on).
        speed_held: a wheel that stops is shown at its last speed for a second (G2 lm393_tachometer.cpp `get_rpm`).
        boot_s: how long after power-on nobody listens and nothing is said (G2 mpu9250.cpp sleeps for 0.955 s).
        windup: the sum grows also while the output is at its limit (G2 controllers/pid.cpp).
        kp: gain of the speed controllers at power-up, throttle per rpm (manual; G2 config.h).
        kd: throttle per (rpm/s).
        ki: throttle per (rpm s).
    """

    shown_limit_rpm: float | None = None
    median_begins: tuple[float, float, float] = (0.0, 0.0, 0.0)
    position_known: bool = True
    attitude_known: bool = True
    led_shared: bool = False
    stop_reaches_motors: bool = True
    slots: int = SLOTS
    mode_resets_controllers: bool = True
    speed_held: bool = False
    boot_s: float = 0.0
    windup: bool = False
    kp: float = 0.01
    kd: float = 0.0001
    ki: float = 0.0001


@dataclass(frozen=True, slots=True, kw_only=True)
class Behaviour:
    """All that a rover promises or gets wrong.

    Attributes:
        server: its end of the protocol.
        dialect: what it means by its numbers.
        body: the rest.
    """

    server: ServerOptions
    dialect: Dialect
    body: BodyQuirks = field(default_factory=BodyQuirks)


_BODIES = {
    "g2": BodyQuirks(
        shown_limit_rpm=150.0,
        median_begins=(0.0, 1.0, 2.0),
        position_known=False,
        led_shared=True,
        mode_resets_controllers=False,
        speed_held=True,
        boot_s=0.955,
        windup=True,
    )
}

BEHAVIOURS: Mapping[str, Behaviour] = MappingProxyType(
    {
        name: Behaviour(server=profile.server, dialect=profile.dialect, body=_BODIES.get(name, BodyQuirks()))
        for name, profile in PROFILES.items()
    }
)
"""The behaviour of each profile."""
