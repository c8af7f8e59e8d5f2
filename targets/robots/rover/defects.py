"""The defects of the published firmwares, each by itself, to be put back into a rover that does what was promised.

Their names are those of the options of our own firmware (targets/firmware/rover/defects.h), as far as it has them.
Sources: G2 is nhorro/ceai2020 at 6058e92, rover_firmware; G0 is nhorro/rover-firmware. Each names file and function.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from protocols.pkt import (
    AccelerationUnit,
    ExecutionReports,
    FrameTimer,
    PollOptions,
    PositionOrder,
    QuaternionOrder,
    RangeRule,
    ReportId,
    ReportRate,
    Resync,
)
from targets.robots.rover.behaviour import Behaviour

__all__ = ["DEFECTS", "Defect"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Defect:
    """One thing that is wrong.

    Attributes:
        name: as in settings.
        text: what it does.
        source: where it is published.
        frames: what changes in `FramingOptions`.
        server: the same in `ServerOptions`.
        dialect: the same in `Dialect`.
        body: the same in `BodyQuirks`.
    """

    name: str
    text: str
    source: str
    frames: Mapping[str, object] = field(default_factory=dict)
    server: Mapping[str, object] = field(default_factory=dict)
    dialect: Mapping[str, object] = field(default_factory=dict)
    body: Mapping[str, object] = field(default_factory=dict)

    def put_into(self, behaviour: Behaviour) -> Behaviour:
        """The behaviour with this defect."""
        server = replace(behaviour.server, **self.server)  # type: ignore[arg-type]
        return Behaviour(
            server=replace(server, frames=replace(server.frames, **self.frames)),  # type: ignore[arg-type]
            dialect=replace(behaviour.dialect, **self.dialect),  # type: ignore[arg-type]
            body=replace(behaviour.body, **self.body),  # type: ignore[arg-type]
        )


_ALL = (
    Defect(
        name="no-0x81",
        text="0x81 is never sent",
        source="G2 application.cpp handle_packet: the flag tested is that of opcode 0; G0 likewise",
        server={"execution_reports": ExecutionReports.NEVER},
    ),
    Defect(
        name="0x81-leds-only",
        text="0x81 is sent after LED_ON and LED_OFF alone",
        source="G2 application.cpp, table of opcodes, as it was meant",
        server={"execution_reports": ExecutionReports.LEDS},
    ),
    Defect(
        name="no-resync",
        text="the byte that breaks a sync word is used up, even a P",
        source="G2 and G0 protocol.cpp handle_pkt_state_expecting_start_sync1 to 3",
        frames={"resync": Resync.NONE},
    ),
    Defect(
        name="no-frame-timeout",
        text="half a frame waits for ever",
        source="G2 main.cpp and application.cpp: nothing calls check_timeouts",
        frames={"timer": FrameTimer.OFF},
    ),
    Defect(
        name="timer-since-reset",
        text="the time of a frame runs from the decoder's last reset, so that a frame in flight can be dropped early",
        source="G0 protocol.cpp reset and check_timeouts",
        frames={"timer": FrameTimer.SINCE_RESET},
    ),
    Defect(
        name="no-link-timeout",
        text="the motors keep their last throttle when the link is lost",
        source="G2 application.cpp handle_connection_lost: commented out, and nothing calls it",
        server={"silence_s": None},
    ),
    Defect(
        name="eagain-11",
        text="a look of the receiver that yields exactly eleven bytes throws them away",
        source="G2 application.cpp read_telecommands: compared with EAGAIN, which is 11, instead of its negative",
        server={"poll": PollOptions(lose_eleven=True)},
    ),
    Defect(
        name="polled",
        text="bytes are taken 32 at most every 10 ms, and what finds no room meanwhile is lost",
        source="G2 application.cpp read_telecommands",
        server={"poll": PollOptions(lose_eleven=False)},
    ),
    Defect(
        name="no-len-check",
        text="missing parameters are taken from earlier frames",
        source="G2 application.cpp set_motor_throttles; G0 update_motor_speeds",
        server={"strict_length": False},
    ),
    Defect(
        name="throttle-unchecked",
        text="a throttle beyond 1 and NaN are kept and shown",
        source="G2 application.cpp set_motor_throttles",
        server={"range_rule": RangeRule.ANY},
    ),
    Defect(
        name="rpm-150",
        text="0x83 shows 0 for a wheel that is faster than 150 rpm",
        source="G2 application.cpp read_tachometers, MAX_TACHO_VALID_RPM_READING",
        body={"shown_limit_rpm": 150.0},
    ),
    Defect(
        name="pid-offsets",
        text="RESET_PID_CONTROLLER reads its gains four bytes too far behind",
        source="G2 application.cpp config_pid_controller",
        server={"pid_reads_late": True},
    ),
    Defect(
        name="stale-byte-84",
        text="byte 1 of 0x84 is that of the report before",
        source="G2 application.cpp send_gps_report",
        server={"gps_stale_byte": True},
    ),
    Defect(
        name="no-gps",
        text="0x84 has zeros, wherever the rover is",
        source="G2 application.cpp read_gps: commented out",
        body={"position_known": False},
    ),
    Defect(
        name="gps-order",
        text="0x84 has the longitude before the latitude",
        source="G2 application.cpp send_gps_report",
        dialect={"position": PositionOrder.LONGITUDE_FIRST},
    ),
    Defect(
        name="accel-g",
        text="0x82 has its accelerations in g instead of m/s^2",
        source="G2 sensors/mpu9250_imu/mpu9250.cpp",
        dialect={"acceleration": AccelerationUnit.G},
    ),
    Defect(
        name="quat-wxyz",
        text="the quaternion of 0x82 begins with its scalar",
        source="G2 sensors/mpu9250_imu/madwick.cpp; application.cpp read_imu",
        dialect={"quaternion": QuaternionOrder.WXYZ},
    ),
    Defect(
        name="first-rpm-1",
        text="the wheels seem to turn at power-up: the median's window begins as 0, 1, 2",
        source="G2 filters/median/median_filter.cpp",
        body={"median_begins": (0.0, 1.0, 2.0)},
    ),
    Defect(
        name="led-shared",
        text="the test LED blinks until the first packet and toggles with each one",
        source="G2 application.cpp handle_packet",
        body={"led_shared": True},
    ),
    Defect(
        name="link-stops-report-only",
        text="when the link is lost the throttles are shown as 0, and the motors go on",
        source="G1, nhorro/ceai2020 at 4720b70, application.cpp handle_connection_lost",
        body={"stop_reaches_motors": False},
    ),
    Defect(
        name="nan-quaternion",
        text="the attitude is no number, for ever",
        source="G2 sensors/mpu9250_imu/madwick.h: a quaternion that begins as zeros",
        body={"attitude_known": False},
    ),
    Defect(
        name="rpm-held",
        text="a wheel that stops is shown at its last speed for a second",
        source="G2 sensors/tachometer/lm393_tachometer.cpp get_rpm",
        body={"speed_held": True},
    ),
    Defect(
        name="slots-32",
        text="32 slots are reckoned with on discs of 20",
        source="G1, nhorro/ceai2020 at de8cdae",
        body={"slots": 32},
    ),
    Defect(
        name="pid-no-reset",
        text="the speed controllers keep their old sums when their mode is entered again",
        source="G2 actuators/motor/l298n_motor_control.cpp",
        body={"mode_resets_controllers": False},
    ),
    Defect(
        name="pid-windup",
        text="the sum goes on growing while the output is at its limit",
        source="G2 controllers/pid.cpp",
        body={"windup": True},
    ),
    Defect(
        name="slow-start",
        text="nothing is heard and nothing is said in the first 955 ms",
        source="G2 sensors/mpu9250_imu/mpu9250.cpp: sleeps before the first tick",
        body={"boot_s": 0.955},
    ),
    Defect(
        name="no-periodic-reports",
        text="0x80 comes on request alone, and no other report by itself",
        source="seed document, nhorro/ceai2020 intro_se/ISE-ProyectoFinalRover.md, which knows no periodic report",
        server={"rates": ()},
    ),
    Defect(
        name="g0-rates",
        text="0x80 comes once a second, 0x82 five times, 0x83 and 0x84 never",
        source="G0 application.cpp execute_periodic_tasks",
        server={
            "report_at_once": False,
            "rates": (
                ReportRate(report=ReportId.IMU, ticks=20),
                ReportRate(report=ReportId.GENERAL, ticks=100),
            ),
        },
    ),
)

DEFECTS: Mapping[str, Defect] = MappingProxyType({defect.name: defect for defect in _ALL})
"""All defects by name."""
