"""A clause: one rule that a peer follows or violates, where it is written, and of which profiles it is part."""

from __future__ import annotations

from dataclasses import dataclass

from protocols.common import clause

__all__ = ["Clause"]

DOCUMENT = "seed document, nhorro/ceai2020 intro_se/ISE-ProyectoFinalRover.md"
DIAGRAM = "seed document's diagram, nhorro/ceai2020 intro_se/rover-serial-protocol.png"
MANUAL = "manual, nhorro/ceai2020 rover_firmware/doc/index.md"
DECODER = "nhorro/ceai2020 and nhorro/rover-firmware, protocol.cpp"
G0 = "nhorro/rover-firmware application.cpp"
G2 = "nhorro/ceai2020 at 6058e92, rover_firmware/application.cpp"
G2_CONFIG = "nhorro/ceai2020 rover_firmware/config.h"
G2_MOTORS = "nhorro/ceai2020 at 6058e92, rover_firmware/actuators/motor/l298n_motor_control.cpp"
G2_PID = "nhorro/ceai2020 at 6058e92, rover_firmware/controllers/pid.cpp"
G2_IMU = "nhorro/ceai2020 at 6058e92, rover_firmware/sensors/mpu9250_imu"
G2_MEDIAN = "nhorro/ceai2020 at 6058e92, rover_firmware/filters/median/median_filter.cpp"
CLIENT = "nhorro/ceai2020 rover_groundcontrol/rover/serialprotocol.py"
SERIAL = "the nature of a serial line, which keeps no packet boundaries"
CHOICE = "choice: no source says"


@dataclass(frozen=True, slots=True, kw_only=True)
class Clause(clause.Clause):
    """One rule; see `protocols.common.clause.Clause`.

    Attributes:
        profiles: names of the profiles that hold it, see profiles.py.
        twin: where shipped behaviour is a defect, the clause that says what was promised; else None.
        needs: names of what a bench must be able to do for it to be checked: `server` or `client` under test, `led`
            (see the test LED), `wheels` (hold them, and see how fast they turn), `duty` (see what reaches the motor
            driver), `imu` (hold the IMU still), `gps` (know the position), `sensed` (choose what its sensors sense),
            `turned` (turn it to and fro), `sky` (cover the GPS receiver), `carried` (carry it away), `air` (know how
            warm the air is), `boot` (begin from power-up), `reopen`
            (close the port and open it again), `client.report` (ask what it understood). Of `stand_ins`, beside these:
            `motion reports` (the rover sends 0x83 by itself).
    """

    profiles: tuple[str, ...]
    twin: str | None = None
