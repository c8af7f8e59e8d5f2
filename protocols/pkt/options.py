"""What both roles can be set to; each choice between sources that disagree names them.

The sources, in short: *document* is the seed document, nhorro/ceai2020 intro_se/ISE-ProyectoFinalRover.md, version
0.1.0; *manual* is intro_se/workspace/rover_firmware/doc/index.md; *G0* is the Arduino firmware, nhorro/rover-firmware;
*G1* and *G1b* are the Mbed firmware nhorro/ceai2020 intro_se/workspace/rover_firmware up to de8cdae and from b73d4c7 to
f2fe6c7; *G2* the same at 6058e92, the last. Times are in seconds of bench time here, for people; the connection counts
in integer nanoseconds.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

from protocols.common.options import check_positive
from protocols.pkt.codes import ReportId
from protocols.pkt.errors import LocalProtocolError

__all__ = [
    "ClientOptions",
    "ExecutionReports",
    "FrameTimer",
    "Framing",
    "FramingOptions",
    "PollOptions",
    "RangeRule",
    "ReportRate",
    "Resync",
    "Schema",
    "ServerOptions",
]

MAX_PAYLOAD_LEN = 96
"""The largest payload of a frame with a length byte (all firmware: protocol.h, PAYLOAD_BUFFER_SIZE)."""
MAX_PAYLOAD_TERM = 64
"""The largest payload of a frame without one (document and manual, "un máximo de 64 bytes")."""

_MAX_LENGTH = 255
"""The largest length that a length byte can say."""
_HOST_TIMEOUT_S = 0.5
_REPORTS_V1 = {ReportId.GENERAL, ReportId.EXECUTION_STATUS, ReportId.IMU}


class Framing(enum.Enum):
    """Where a payload ends."""

    LEN = "a length byte behind the sync word (all firmware, both Python clients)"
    TERM = "the first newline (document and manual; no code of any generation)"


class Schema(enum.Enum):
    """What stands in the payloads."""

    V1 = "speeds as big-endian int16 (document, G0, G1)"
    V1B = "speeds as little-endian int16 (G1b)"
    V2 = "throttles as little-endian float32 (G2 and its manual)"


class Resync(enum.Enum):
    """What becomes of the bytes of a frame that failed."""

    NONE = "used up, the offending byte too: `PPKT!` loses the frame (all firmware, protocol.cpp)"
    SYNC = "an offending P begins the next sync word (choice: the document does not say that ERROR uses it up)"
    SCAN = "searched again for a sync word, so that a sound frame behind or inside is found (choice)"


class FrameTimer(enum.Enum):
    """Since when an unfinished frame may be unfinished."""

    OFF = "for ever (G1b, G2: nothing calls `check_timeouts`)"
    SINCE_FIRST_BYTE = "since its first byte (what the comment in G2's `check_timeouts` says)"
    SINCE_LAST_BYTE = "since its latest byte (choice, for hosts)"
    SINCE_RESET = "since the decoder's latest reset, be it before the frame began (G0, G1: protocol.cpp `reset`)"


@dataclass(frozen=True, slots=True, kw_only=True)
class FramingOptions:
    """How frames are found.

    Attributes:
        framing: see `Framing`.
        max_payload: the largest payload, in bytes; None for 96 with a length byte, 64 without.
        strict_diagram: without a length byte: the limit counts all bytes in front of the newline, the CRC too, as in
            the document's diagram; otherwise the payload alone, as in its text.
        tolerant_newline: without a length byte: a newline behind which the CRC is wrong may belong to the payload or
            to the CRC, and reading goes on up to the limit (choice; 1 of 65536 wrong frames is then taken for right).
        resync: see `Resync`.
        timer: see `FrameTimer`.
        timeout_s: the time of `timer`; 1 s (all firmware: config.h, PACKET_TIMEOUT_IN_MS).
    """

    framing: Framing = Framing.LEN
    max_payload: int | None = None
    strict_diagram: bool = False
    tolerant_newline: bool = False
    resync: Resync = Resync.NONE
    timer: FrameTimer = FrameTimer.SINCE_FIRST_BYTE
    timeout_s: float = 1.0

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("timeout_s",))
        if not 1 <= self.payload_limit <= _MAX_LENGTH:
            raise LocalProtocolError(f"max_payload {self.max_payload} is not 1..{_MAX_LENGTH}")
        if self.framing is Framing.LEN and (self.strict_diagram or self.tolerant_newline):
            raise LocalProtocolError("strict_diagram and tolerant_newline are for frames without a length byte")

    @property
    def payload_limit(self) -> int:
        """The largest payload, in bytes."""
        if self.max_payload is not None:
            return self.max_payload
        return MAX_PAYLOAD_LEN if self.framing is Framing.LEN else MAX_PAYLOAD_TERM


class ExecutionReports(enum.Enum):
    """After which commands 0x81 is sent; REQUEST_TMY is answered with 0x80 and never has one (choice)."""

    NEVER = "none (all firmware: the flag tested is that of opcode 0, application.cpp `handle_packet`)"
    LEDS = "LED_ON and LED_OFF (what the table of opcodes means, application.cpp)"
    EVERY = "every command, also an unknown one (document and manual, 0x81)"


class RangeRule(enum.Enum):
    """What becomes of a throttle or speed outside the range of the document."""

    ANY = "taken as it is, NaN too (all firmware)"
    CLAMP = (
        "the nearest in range, NaN is 0 (document and manual give -255..255 and -1..1; how to keep them is a choice)"
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class ReportRate:
    """How often a report is due.

    Attributes:
        report: which.
        ticks: every how many ticks of the base rate.
    """

    report: ReportId
    ticks: int

    def __post_init__(self) -> None:
        """Checks the figure."""
        check_positive(LocalProtocolError, self, ("ticks",))


@dataclass(frozen=True, slots=True, kw_only=True)
class PollOptions:
    """A receiver that looks for bytes at fixed times only (G2: application.cpp `read_telecommands`).

    Attributes:
        hz: how often it looks, at whole multiples of 1/hz s from the rover's epoch.
        bytes_each: the most it takes at once: 32, so 3200 bytes/s at 100 Hz.
        buffer_bytes: what waits meanwhile; more is lost. 256 is Mbed OS's default, uart-serial-rxbuf-size.
        lose_eleven: a look that yields exactly 11 bytes throws them away: the result is compared with EAGAIN, which is
            11 in newlib, without its minus sign.
    """

    hz: int = 100
    bytes_each: int = 32
    buffer_bytes: int = 256
    lose_eleven: bool = True

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("hz", "bytes_each", "buffer_bytes"))


G2_RATES = (
    ReportRate(report=ReportId.GENERAL, ticks=33),
    ReportRate(report=ReportId.MOTION, ticks=25),
    ReportRate(report=ReportId.IMU, ticks=100),
    ReportRate(report=ReportId.GPS, ticks=100),
)
"""The rates of the manual's table of tasks, 3, 4, 1 and 1 Hz, in the firmware's order, rounded as G2 rounds them."""


@dataclass(frozen=True, slots=True, kw_only=True)
class ServerOptions:
    """The server role, the rover. The defaults are those of the profile `documented`.

    Attributes:
        frames: how its frames are found.
        schema: what stands in its payloads.
        execution_reports: see `ExecutionReports`.
        general_status: 0x80 has its sixth byte, STATUS; all code sends it, the document's table ends before it.
        rates: the periodic reports in their order; none: 0x80 on request alone, as the document says.
        tick_hz: the base rate that `rates` divide.
        report_at_once: each periodic report is due at the epoch already (G2: all counters begin at 0); otherwise after
            its first period (G0: application.cpp `execute_periodic_tasks`).
        silence_s: without a sound frame for this long the motors must stop; None for never (G1b, G2: nothing calls
            `check_timeouts`). 1 s in all firmware (config.h, HEARTBEAT_TIMEOUT_IN_MS); G0 repeats the stop at every
            turn of its loop, which changes nothing, and also before the first frame.
        strict_length: a command with too few parameters is answered with LAST_ERROR 2 and does nothing (choice);
            otherwise the bytes that earlier frames left in the buffer are taken for parameters (all firmware).
        range_rule: see `RangeRule`.
        pid_reads_late: RESET_PID_CONTROLLER takes its gains 4 bytes too far behind: the sent kd for kp, the sent ki for
            kd, and what lies behind the payload for ki (G2: application.cpp `config_pid_controller`).
        pid_reports_kp: the report of the gains says kp for all three (G2: controllers/pid.h).
        gps_stale_byte: byte 1 of 0x84 is that of the report before (G2: application.cpp `send_gps_report`).
        poll: see `PollOptions`; None: bytes are taken as they come.
    """

    frames: FramingOptions = field(default_factory=lambda: FramingOptions(resync=Resync.SYNC))
    schema: Schema = Schema.V2
    execution_reports: ExecutionReports = ExecutionReports.EVERY
    general_status: bool = True
    rates: tuple[ReportRate, ...] = G2_RATES
    tick_hz: int = 100
    report_at_once: bool = True
    silence_s: float | None = 1.0
    strict_length: bool = True
    range_rule: RangeRule = RangeRule.CLAMP
    pid_reads_late: bool = False
    pid_reports_kp: bool = False
    gps_stale_byte: bool = False
    poll: PollOptions | None = None

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("silence_s", "tick_hz"))
        if self.schema is Schema.V1 and not {rate.report for rate in self.rates} <= _REPORTS_V1:
            raise LocalProtocolError("the first schema has no reports of motion, position or gains")


@dataclass(frozen=True, slots=True, kw_only=True)
class ClientOptions:
    """The client role, the host or ground station. No source has one that does all this: the figures are choices.

    Attributes:
        frames: how its frames are found.
        schema: what stands in its payloads.
        split_lines: take each line that ends with a newline for a frame, and look at its sync word and length only,
            never at its CRC, as the author's client (rover_groundcontrol/rover/serialprotocol.py `run`, over pyserial's
            readline); `frames` is not used then.
        request_s: REQUEST_TMY is sent when nothing else was for this long, so that the rover hears a heartbeat; None
            leaves it to the user, as the author's client.
        silence_s: a rover without a sound report for this long counts as lost; None for never. 0x80 comes every 0.33 s.
        stop_at_the_end: `disconnect` stops both motors.
    """

    frames: FramingOptions = field(
        default_factory=lambda: FramingOptions(
            resync=Resync.SCAN, timer=FrameTimer.SINCE_LAST_BYTE, timeout_s=_HOST_TIMEOUT_S
        )
    )
    schema: Schema = Schema.V2
    split_lines: bool = False
    request_s: float | None = 0.4
    silence_s: float | None = 2.0
    stop_at_the_end: bool = True

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("request_s", "silence_s"))
