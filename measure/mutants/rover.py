"""Faulty rovers: the defects of the published firmwares, one by one, and what else a firmware engineer gets wrong.

``python -m measure.mutants.rover`` runs the suite ``pkt-board`` against each and writes ``docs/rover-defects.md``.
"""

from __future__ import annotations

import argparse
import contextlib
import math
import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from unittest.mock import patch
from weakref import WeakSet

from hilbench.bench.shared import Shared
from hilbench.benchfile.reader import open_bench
from hilbench.check import CheckOptions, run_suites
from hilbench.check.results import Report
from hilbench.clock import NS_PER_S
from hilbench.journal import Journal
from hilbench.judging.provider import CaseBench, CaseInfo
from hilbench.mcu.board_provider import BoardProvider
from hilbench.systems.rover.provider import RoverProvider
from hilbench.terminal.options import TargetChoice
from measure.mutants.defects_page import DefectsPage, Found, by_clauses, killers
from measure.mutants.each_its_own import Fault
from protocols.pkt import (
    SERVER_TABLE,
    Action,
    Command,
    Connection,
    Dropped,
    DropReason,
    ExecutionReport,
    Frame,
    FrameAction,
    FrameReader,
    FrameState,
    FrameTable,
    FrameTransition,
    FrameTrigger,
    GeneralReport,
    GpsReport,
    ImuReport,
    MotionReport,
    MotorThrottles,
    ReportId,
    Resync,
    Role,
    ServerState,
    ServerTrigger,
    SpeedSetpoints,
    Table,
    Transition,
    crc16,
    encode_frame,
    frame_table,
)
from protocols.pkt.clauses import BOARD_CLAUSES
from protocols.pkt.server import ServerMachine
from targets.firmware import image_path
from targets.robots.rover import BEHAVIOURS, DEFECTS, Behaviour, RoverRobot, RoverSettings, behaviour_of
from targets.robots.rover.control import Motors

SHOWN = 3
"""So many of the clauses that find a defect in the model are run on the emulated board."""

PAGE = DefectsPage(path=Path(__file__).parents[2] / "docs" / "rover-defects.md", clauses=BOARD_CLAUSES)

FrameEdges = Mapping[tuple[FrameState, FrameTrigger], FrameTransition]
Edges = Mapping[tuple[ServerState, ServerTrigger], Transition]
Change = Callable[[Behaviour], Behaviour]

_F, _FT, _FA = FrameState, FrameTrigger, FrameAction
_IDLE = FrameTransition(_F.IDLE)


@dataclass(frozen=True, slots=True, kw_only=True)
class RoverMutant:
    """A rover with one fault.

    Attributes:
        id: stable name.
        what: what it does wrong.
        profile: of the cases that have to find it.
        change: what is wrong with its behaviour.
        frames: changed edges of its decoder.
        edges: changed edges of its role.
        patches: what is put in the place of parts of it.
    """

    id: str
    what: str
    profile: str = "documented"
    change: Change = lambda behaviour: behaviour
    frames: FrameEdges = field(default_factory=dict)
    edges: Edges = field(default_factory=dict)
    patches: tuple[Callable[[], contextlib.AbstractContextManager[object]], ...] = ()

    def make(self, settings: RoverSettings) -> RoverRobot:
        """Make the rover."""
        behaviour = self.change(behaviour_of(settings))
        table: Table = {**SERVER_TABLE, **self.edges}
        frames: FrameTable = {**frame_table(behaviour.server.frames), **self.frames}
        epoch_ns = round(behaviour.body.boot_s * NS_PER_S)
        connection = Connection(Role.SERVER, behaviour.server, epoch_ns=epoch_ns, table=table, frames=frames)
        return RoverRobot(settings, behaviour=behaviour, connection=connection)


def published() -> tuple[RoverMutant, ...]:
    """The defects of the published firmwares, in a rover that is otherwise as documented."""
    return tuple(RoverMutant(id=defect.name, what=defect.text, change=defect.put_into) for defect in DEFECTS.values())


def server(**changes: object) -> Change:
    """Change `ServerOptions`."""
    return lambda behaviour: replace(behaviour, server=replace(behaviour.server, **changes))  # type: ignore[arg-type]


def frames(**changes: object) -> Change:
    """Change `FramingOptions`."""

    def change(behaviour: Behaviour) -> Behaviour:
        options = replace(behaviour.server.frames, **changes)  # type: ignore[arg-type]
        return replace(behaviour, server=replace(behaviour.server, frames=options))

    return change


def body(**changes: object) -> Change:
    """Change `BodyQuirks`."""
    return lambda behaviour: replace(behaviour, body=replace(behaviour.body, **changes))  # type: ignore[arg-type]


def as_documented(_behaviour: Behaviour) -> Behaviour:
    """The documented rover, where a shipped one is expected."""
    return BEHAVIOURS["documented"]


def everywhere(trigger: ServerTrigger, *actions: Action) -> Edges:
    """The same edge in each state."""
    return {(state, trigger): Transition(ServerState.LINKED, actions) for state in ServerState}


def _saturating(act: Callable[..., None], machine: ServerMachine, action: Action) -> None:
    if action is not Action.ACCEPT or machine.telemetry.accepted < 255:
        act(machine, action)


def _without_flags(set_values: Callable[..., None], motors: Motors, which: object, values: object, _flags: int) -> None:
    set_values(motors, which, values, 3)


def _saturating_rejected(act: Callable[..., None], machine: ServerMachine, action: Action) -> None:
    if action is not Action.REJECT or machine.telemetry.rejected < 255:
        act(machine, action)


def _one_more(encode: Callable[..., bytes], machine: ServerMachine, report: object) -> bytes:
    if isinstance(report, GeneralReport):
        report = replace(report, accepted=(report.accepted + 1) % 256)
    return encode(machine, report)


def _exchanged(set_both: Callable[..., None], motors: Motors, a_rpm: float, b_rpm: float, flags: int) -> None:
    set_both(motors, b_rpm, a_rpm, flags)


def _without_setpoint_flags(
    set_both: Callable[..., None], motors: Motors, a_rpm: float, b_rpm: float, _flags: int
) -> None:
    set_both(motors, a_rpm, b_rpm, 3)


def _silent_on_motors(send: Callable[..., None], machine: ServerMachine) -> None:
    if machine.telemetry.last_opcode not in (3, 4, 5):
        send(machine)


def _always_success(_send: Callable[..., None], machine: ServerMachine) -> None:
    machine.transmit(machine.encode(ExecutionReport(opcode=machine.telemetry.last_opcode, error=0)))


def _filled_up(decode: Callable[..., object], machine: ServerMachine, frame: Frame) -> object:
    if frame.payload[0] in (4, 5):
        frame = replace(frame, payload=frame.payload.ljust(13, b"\0"))
    return decode(machine, frame)


def _one_pair_alone(stop: Callable[..., None], motors: Motors) -> None:
    right = motors.throttles[1]
    stop(motors)
    motors.throttles[1] = right


def _setpoints_kept(stop: Callable[..., None], motors: Motors) -> None:
    kept = [*motors.setpoints_rpm]
    stop(motors)
    motors.setpoints_rpm[:] = kept


def _remembering(stop: Callable[..., None], motors: Motors) -> None:
    motors.before_stop = [*motors.throttles]  # type: ignore[attr-defined]
    stop(motors)


def _come_back(receive: Callable[..., bytes], robot: RoverRobot, data: bytes, now_ns: int) -> bytes:
    was_lost = robot.connection.state is ServerState.LOST
    sent = receive(robot, data, now_ns)
    if was_lost and robot.connection.state is ServerState.LINKED and not any(robot.motors.throttles):
        robot.motors.throttles[:] = getattr(robot.motors, "before_stop", [0.0, 0.0])
    return sent


def _fed_by_noise(drop: Callable[..., None], machine: ServerMachine, dropped: Dropped) -> None:
    machine.act(Action.FEED_WATCHDOG, ServerTrigger.BAD_FRAME)
    drop(machine, dropped)


def _only_without_control(stop: Callable[..., None], motors: Motors) -> None:
    if not motors.pid:
        stop(motors)


def _counting_noise(drop: Callable[..., None], machine: ServerMachine, dropped: Dropped) -> None:
    if dropped.reason is DropReason.NOISE:
        dropped = Dropped(reason=DropReason.BAD_SYNC, data=dropped.data)
    drop(machine, dropped)


def _crc_by(mask: int) -> Callable[..., int]:
    """Compare these bits of the CRC alone."""

    def step(_step: Callable[..., int], reader: FrameReader, data: bytes, at: int) -> int:
        reader._raw.append(data[at])
        body = bytes(reader._raw[reader._body_at :])
        wrong = crc16(body[:-2]) ^ int.from_bytes(body[-2:], "big")
        reader._fire(FrameTrigger.BAD_CRC if wrong & mask else FrameTrigger.GOOD_CRC)
        return at + 1

    return step


def _answering_first(drop: Callable[..., None], machine: ServerMachine, dropped: Dropped) -> None:
    if dropped.reason is DropReason.BAD_CRC and dropped.data[_PAYLOAD_AT] == 0:
        machine.transmit(machine.encode(machine.telemetry))
    drop(machine, dropped)


def _without_all_flags(decode: Callable[..., object], machine: ServerMachine, frame: Frame) -> object:
    if frame.payload[0] == 3 and len(frame.payload) > 6:
        frame = replace(frame, payload=frame.payload.ljust(10, b"\3"))
    return decode(machine, frame)


def _parameters_of(frame: Frame) -> int:
    """How many bytes of parameters a motor command has; 255 for others."""
    return {3: 9, 4: 9, 5: 12}.get(frame.payload[0], 255)


def _no_byte_too_many(decode: Callable[..., object], machine: ServerMachine, frame: Frame) -> object:
    if len(frame.payload) > 1 + _parameters_of(frame):
        frame = replace(frame, payload=frame.payload[:1])
    return decode(machine, frame)


def _from_the_end(decode: Callable[..., object], machine: ServerMachine, frame: Frame) -> object:
    size = _parameters_of(frame)
    if len(frame.payload) > 1 + size:
        frame = replace(frame, payload=frame.payload[:1] + frame.payload[-size:])
    return decode(machine, frame)


def _seven_bits(decode: Callable[..., object], machine: ServerMachine, frame: Frame) -> object:
    return decode(machine, replace(frame, payload=bytes((frame.payload[0] & 0x7F,)) + frame.payload[1:]))


def _swallowing(receive: Callable[..., bytes], rover: RoverRobot, data: bytes, now_ns: int) -> bytes:
    return receive(rover, data.translate(None, b"\x11\x13"), now_ns)


def _translating(receive: Callable[..., bytes], rover: RoverRobot, data: bytes, now_ns: int) -> bytes:
    return receive(rover, data.replace(b"\r", b"\n"), now_ns)


def _unused_set(encode: Callable[..., bytes], machine: ServerMachine, report: object) -> bytes:
    frame = encode(machine, report)
    payload = bytearray(frame[_PAYLOAD_AT:-3])
    if payload[0] == ReportId.MOTION:
        payload[3] = 1
    return encode_frame(bytes(payload))


def _half_the_counts(motion: Callable[..., MotionReport], rover: RoverRobot) -> MotionReport:
    report = motion(rover)
    lf, rf, lb, rb = report.ticks
    return replace(report, ticks=(lf // 2, rf // 2, lb // 2, rb // 2))


def _twice_as_long(imu: Callable[..., object], rover: RoverRobot) -> object:
    report = imu(rover)
    if not isinstance(report, ImuReport):
        return report
    x, y, z, w = (2 * component for component in report.quaternion)
    return replace(report, quaternion=(x, y, z, w))


def _rates_exchanged(imu: Callable[..., object], rover: RoverRobot) -> object:
    report = imu(rover)
    if not isinstance(report, ImuReport):
        return report
    x, y, z = report.rate_deg_s
    return replace(report, rate_deg_s=(x, z, y))


def _south_is_north(gps: Callable[..., GpsReport], rover: RoverRobot) -> GpsReport:
    report = gps(rover)
    return replace(report, first_deg=abs(report.first_deg))


def _as_in_nmea(gps: Callable[..., GpsReport], rover: RoverRobot) -> GpsReport:
    report = gps(rover)
    first, second = (100 * math.trunc(deg) + 60 * math.fmod(deg, 1) for deg in (report.first_deg, report.second_deg))
    return replace(report, first_deg=first, second_deg=second)


def _where_it_was(gps: Callable[..., GpsReport], rover: RoverRobot) -> GpsReport:
    settings = rover._settings
    return replace(gps(rover), first_deg=settings.latitude_deg, second_deg=settings.longitude_deg)


def _of_imu(field: str, change: Callable[..., object]) -> Callable[..., object]:
    """Change a field of 0x82."""

    def changed(imu: Callable[..., object], rover: RoverRobot) -> object:
        report = imu(rover)
        if not isinstance(report, ImuReport):
            return report
        return replace(report, **{field: change(getattr(report, field))})  # type: ignore[arg-type]

    return changed


class _Doubling:
    """Say reports twice once the line has been down."""

    def __init__(self) -> None:
        self._been_down = WeakSet[RoverRobot]()

    def line_down(self, line_down: Callable[..., bytes], rover: RoverRobot, now_ns: int) -> bytes:
        self._been_down.add(rover)
        return line_down(rover, now_ns)

    def advance(self, advance: Callable[..., bytes], rover: RoverRobot, now_ns: int) -> bytes:
        return advance(rover, now_ns) * (2 if rover in self._been_down else 1)


def _one_a_turn(obey: Callable[..., None], rover: RoverRobot, command: Command) -> None:
    if not isinstance(command, MotorThrottles | SpeedSetpoints):
        obey(rover, command)
    elif getattr(rover, "obeyed_in", None) != rover._tick:
        rover.obeyed_in = rover._tick  # type: ignore[attr-defined]
        obey(rover, command)


def _any_flag(set_values: Callable[..., None], motors: Motors, which: object, values: object, flags: int) -> None:
    set_values(motors, which, values, 3 if flags > 3 else flags)


def patched(
    owner: type, name: str, around: Callable[..., object]
) -> Callable[[], contextlib.AbstractContextManager[object]]:
    """Put a function around a method."""
    original = getattr(owner, name)
    return lambda: patch.object(owner, name, lambda self, *args: around(original, self, *args))


_DOUBLING = _Doubling()
_PAYLOAD_AT = 5
_COUNTED = (Action.FEED_WATCHDOG, Action.ACCEPT, Action.SEND_GENERAL)
_RESULT = (Action.NOTE_RESULT, Action.SEND_EXECUTION)

BY_HAND = (
    RoverMutant(
        id="counts-halved",
        what="the counts of 0x83 are half of what they should be",
        patches=(patched(RoverRobot, "_motion", _half_the_counts),),
    ),
    RoverMutant(
        id="quaternion-long",
        what="the quaternion of 0x82 has a length of 2",
        patches=(patched(RoverRobot, "_imu", _twice_as_long),),
    ),
    RoverMutant(
        id="rates-exchanged",
        what="0x82 has the rates about y and z in each other's place",
        patches=(patched(RoverRobot, "_imu", _rates_exchanged),),
    ),
    RoverMutant(
        id="latitude-unsigned",
        what="the latitude of 0x84 has no sign",
        patches=(patched(RoverRobot, "_gps", _south_is_north),),
    ),
    RoverMutant(
        id="position-as-in-nmea",
        what="0x84 has degrees and minutes in one number, as a NMEA sentence does",
        patches=(patched(RoverRobot, "_gps", _as_in_nmea),),
    ),
    RoverMutant(
        id="position-stays",
        what="0x84 has for ever where the rover was first",
        patches=(patched(RoverRobot, "_gps", _where_it_was),),
    ),
    RoverMutant(
        id="field-mirrored",
        what="the y axis of the field in 0x82 has the other sign",
        patches=(patched(RoverRobot, "_imu", _of_imu("field_mgauss", lambda field: (field[0], -field[1], field[2]))),),
    ),
    RoverMutant(
        id="temperature-in-fahrenheit",
        what="the temperature of 0x82 is in degrees Fahrenheit",
        patches=(patched(RoverRobot, "_imu", _of_imu("temperature_c", lambda deg_c: 1.8 * deg_c + 32)),),
    ),
    RoverMutant(
        id="crc-unchecked",
        what="a frame with a wrong CRC is executed",
        frames={(_F.CRC2, _FT.BAD_CRC): FrameTransition(_F.TERMINATOR)},
    ),
    RoverMutant(
        id="terminator-unchecked",
        what="a frame without its newline is executed",
        frames={(_F.TERMINATOR, _FT.WRONG): FrameTransition(_F.IDLE, (_FA.DISPATCH,))},
    ),
    RoverMutant(
        id="lengths-uncounted",
        what="a length out of range is not counted",
        frames={(_F.LENGTH, _FT.BAD_LENGTH): FrameTransition(_F.IDLE, (_FA.ABANDON,))},
    ),
    RoverMutant(id="limit-255", what="any length is taken", change=frames(max_payload=255)),
    RoverMutant(id="limit-95", what="95 bytes are the largest payload", change=frames(max_payload=95)),
    RoverMutant(
        id="sync-uncounted",
        what="a broken sync word is not counted",
        frames={
            (state, _FT.WRONG): FrameTransition(_F.IDLE, (_FA.ABANDON,)) for state in (_F.SYNC1, _F.SYNC2, _F.SYNC3)
        },
    ),
    RoverMutant(
        id="noise-counted",
        what="a byte that begins no frame counts as a broken sync word",
        patches=(patched(ServerMachine, "drop", _counting_noise),),
    ),
    RoverMutant(
        id="requests-counted",
        what="REQUEST_TMY counts as a packet",
        edges=everywhere(ServerTrigger.REQUEST, *_COUNTED),
    ),
    RoverMutant(
        id="requests-unanswered",
        what="REQUEST_TMY is not answered",
        edges=everywhere(ServerTrigger.REQUEST, Action.FEED_WATCHDOG),
    ),
    RoverMutant(
        id="commands-uncounted",
        what="packets are not counted",
        edges=everywhere(ServerTrigger.COMMAND, Action.FEED_WATCHDOG, Action.DELIVER_COMMAND, *_RESULT),
    ),
    RoverMutant(
        id="unknown-rejected",
        what="an unknown opcode counts as rejected",
        edges=everywhere(ServerTrigger.UNKNOWN, Action.FEED_WATCHDOG, Action.REJECT),
    ),
    RoverMutant(
        id="accepted-saturates",
        what="ACCEPTED stays at 255",
        patches=(patched(ServerMachine, "_act_on_packet", _saturating),),
    ),
    RoverMutant(
        id="rejected-saturates",
        what="REJECTED stays at 255",
        patches=(patched(ServerMachine, "_act_on_packet", _saturating_rejected),),
    ),
    RoverMutant(
        id="flags-ignored",
        what="a motor command is for both pairs, whatever its flags",
        patches=(patched(Motors, "_set", _without_flags),),
    ),
    RoverMutant(
        id="setpoints-exchanged",
        what="0x04 sets the right pair to A and the left one to B",
        patches=(patched(Motors, "set_setpoints", _exchanged),),
    ),
    RoverMutant(
        id="setpoint-flags-ignored",
        what="0x04 is for both pairs, whatever its flags",
        patches=(patched(Motors, "set_setpoints", _without_setpoint_flags),),
    ),
    RoverMutant(
        id="0x81-not-for-motors",
        what="0x81 is not sent after 0x03, 0x04 and 0x05",
        patches=(patched(ServerMachine, "_send_execution", _silent_on_motors),),
    ),
    RoverMutant(
        id="0x81-always-success",
        what="0x81 has status 0 also after a command that was refused",
        patches=(patched(ServerMachine, "_send_execution", _always_success),),
    ),
    RoverMutant(
        id="short-speed-control-taken",
        what="missing parameters of 0x04 and 0x05 are taken for 0",
        patches=(patched(ServerMachine, "_decode", _filled_up),),
    ),
    RoverMutant(
        id="lost-once",
        what="a link that was lost is not watched any more",
        edges={
            (ServerState.LOST, trigger): replace(SERVER_TABLE[ServerState.LOST, trigger], next_state=ServerState.LOST)
            for trigger in (ServerTrigger.COMMAND, ServerTrigger.REQUEST)
        },
    ),
    RoverMutant(
        id="deaf-when-lost",
        what="REQUEST_TMY is not answered after a lost link",
        edges={(ServerState.LOST, ServerTrigger.REQUEST): Transition(ServerState.LINKED, (Action.FEED_WATCHDOG,))},
    ),
    RoverMutant(
        id="accepted-from-1",
        what="ACCEPTED begins with 1",
        patches=(patched(ServerMachine, "encode", _one_more),),
    ),
    RoverMutant(id="stops-late", what="the motors stop after two seconds of silence", change=server(silence_s=2.0)),
    RoverMutant(
        id="stops-a-little-late",
        what="the motors stop after 1.2 seconds of silence",
        change=server(silence_s=1.2),
    ),
    RoverMutant(
        id="speed-control-outlives-the-link",
        what="a lost link does not stop motors that are under speed control",
        patches=(patched(Motors, "stop", _only_without_control),),
    ),
    RoverMutant(
        id="stops-one-pair",
        what="a lost link stops the left pair alone",
        patches=(patched(Motors, "stop", _one_pair_alone),),
    ),
    RoverMutant(
        id="setpoints-outlive-the-link",
        what="the setpoints outlast a lost link, and come back with a command for the other pair",
        patches=(patched(Motors, "stop", _setpoints_kept),),
    ),
    RoverMutant(
        id="motors-come-back",
        what="the throttles from before the link was lost come back with the next frame",
        patches=(patched(Motors, "stop", _remembering), patched(RoverRobot, "receive", _come_back)),
    ),
    RoverMutant(
        id="noise-counts-as-life",
        what="whatever is received keeps the link up",
        patches=(patched(ServerMachine, "drop", _fed_by_noise),),
    ),
    RoverMutant(
        id="requests-do-not-count-as-life",
        what="REQUEST_TMY does not keep the link up",
        edges={(state, ServerTrigger.REQUEST): Transition(state, (Action.SEND_GENERAL,)) for state in ServerState},
    ),
    RoverMutant(id="frame-timeout-300ms", what="a frame is given up after 0.3 s", change=frames(timeout_s=0.3)),
    RoverMutant(id="frame-timeout-700ms", what="a frame is given up after 0.7 s", change=frames(timeout_s=0.7)),
    RoverMutant(id="frame-timeout-20s", what="a frame is given up after 20 s", change=frames(timeout_s=20.0)),
    RoverMutant(
        id="crc-low-byte-alone",
        what="only the low byte of the CRC is compared",
        patches=(patched(FrameReader, "_step_crc_low", _crc_by(0x00FF)),),
    ),
    RoverMutant(
        id="crc-high-byte-alone",
        what="only the high byte of the CRC is compared",
        patches=(patched(FrameReader, "_step_crc_low", _crc_by(0xFF00)),),
    ),
    RoverMutant(
        id="crc-bit-5-uncompared",
        what="bit 5 of the CRC's low byte is not compared",
        patches=(patched(FrameReader, "_step_crc_low", _crc_by(0xFFDF)),),
    ),
    RoverMutant(
        id="answers-before-the-crc",
        what="REQUEST_TMY is answered before its CRC is looked at",
        patches=(patched(ServerMachine, "drop", _answering_first),),
    ),
    RoverMutant(
        id="0x03-without-all-flags",
        what="0x03 is taken for both pairs if up to three of its bytes are missing",
        patches=(patched(ServerMachine, "_decode", _without_all_flags),),
    ),
    RoverMutant(
        id="byte-too-many-refused",
        what="0x03, 0x04 and 0x05 are refused if bytes follow their parameters",
        patches=(patched(ServerMachine, "_decode", _no_byte_too_many),),
    ),
    RoverMutant(
        id="parameters-from-the-end",
        what="the parameters of 0x03, 0x04 and 0x05 are taken from the end of the payload",
        patches=(patched(ServerMachine, "_decode", _from_the_end),),
    ),
    RoverMutant(
        id="opcodes-of-seven-bits",
        what="the highest bit of an opcode is ignored",
        patches=(patched(ServerMachine, "_decode", _seven_bits),),
    ),
    RoverMutant(
        id="swallows-xon-xoff",
        what="XON and XOFF never reach the decoder",
        patches=(patched(RoverRobot, "receive", _swallowing),),
    ),
    RoverMutant(
        id="cr-translated",
        what="CR reaches the decoder as a newline",
        patches=(patched(RoverRobot, "receive", _translating),),
    ),
    RoverMutant(
        id="reserved-byte-set",
        what="byte 3 of 0x83 is 1",
        patches=(patched(ServerMachine, "encode", _unused_set),),
    ),
    RoverMutant(
        id="reports-double-when-reopened",
        what="each report comes twice after the port was opened again",
        patches=(
            patched(RoverRobot, "line_down", _DOUBLING.line_down),
            patched(RoverRobot, "advance", _DOUBLING.advance),
        ),
    ),
    RoverMutant(
        id="reserved-flags-for-both",
        what="a reserved flag makes a motor command one for both pairs",
        patches=(patched(Motors, "_set", _any_flag),),
    ),
    RoverMutant(
        id="one-command-a-turn",
        what="of the commands of the motors that come in one turn of its loop, 10 ms, the first is carried out alone",
        patches=(patched(RoverRobot, "_obey", _one_a_turn),),
    ),
    RoverMutant(
        id="first-behind-silence-unheard",
        what="the first command behind a lost link is counted and not carried out",
        edges={
            (ServerState.LOST, ServerTrigger.COMMAND): Transition(
                ServerState.LINKED, (Action.FEED_WATCHDOG, Action.ACCEPT, *_RESULT)
            )
        },
    ),
    RoverMutant(id="kp-doubled", what="the controllers begin with twice the gain", change=body(kp=0.02)),
    RoverMutant(
        id="cut-frames-cost-two",
        what="a frame that fails costs the one behind it too",
        frames={(_F.CRC2, _FT.BAD_CRC): FrameTransition(_F.SYNC1, (_FA.FAIL_CRC,))},
    ),
    RoverMutant(
        id="term-strict",
        what="64 bytes are the limit for payload and CRC together",
        profile="term-doc",
        change=frames(strict_diagram=True),
    ),
    RoverMutant(
        id="term-tolerant",
        what="a newline behind which the CRC is wrong is taken for payload",
        profile="term-doc",
        change=frames(tolerant_newline=True),
    ),
    RoverMutant(
        id="term-long", what="200 bytes are the largest payload", profile="term-doc", change=frames(max_payload=200)
    ),
    RoverMutant(
        id="term-crc-uncounted",
        what="a wrong CRC in front of the newline is not counted",
        profile="term-doc",
        frames={(_F.BODY, _FT.BAD_END): FrameTransition(_F.IDLE, (_FA.ABANDON,))},
    ),
    RoverMutant(
        id="g2-scans",
        what="what a failed frame held is searched for the next one",
        profile="g2",
        change=frames(resync=Resync.SCAN),
    ),
    RoverMutant(
        id="g2-sum-stands", what="the sum stands at the limit of the output", profile="g2", change=body(windup=False)
    ),
    RoverMutant(
        id="g2-sum-forgotten",
        what="the speed controllers begin anew with their mode",
        profile="g2",
        change=body(mode_resets_controllers=True),
    ),
    RoverMutant(
        id="g2-as-documented", what="does what was promised, not what was shipped", profile="g2", change=as_documented
    ),
)


FIRMWARE_ALONE = (
    (
        "status-zero",
        "STATUS in 0x80 is always 0",
        "G2: nothing writes TMY_PARAM_STATUS",
        "R21, R22 of `rover-motion`; nothing of `pkt-board`, which cannot break a sensor",
    ),
    (
        "kd-ki-getters",
        "0x85 shows kp in the place of kd and ki",
        "G2 controllers/pid.h",
        "nothing: no clause asks for 0x85, which no promised rover sends by itself",
    ),
)
"""Images with a defect that the model does not have: name, what it does, where it was published, who finds it."""


def all_mutants() -> tuple[RoverMutant, ...]:
    """Every faulty rover there is."""
    return (*published(), *BY_HAND)


def run(mutant: RoverMutant | None, select: str = "") -> Report:
    """Run the cases of a mutant's profile against it; those of all profiles against the right rover for None."""
    shared = Shared(bench_file=open_bench("rover-model"), timeout_scale=1.0, journal=Journal())
    provider = RoverProvider(shared, make_rover=mutant.make) if mutant is not None else RoverProvider(shared)
    words = [word for word in (mutant.profile if mutant is not None else "", select) if word]
    options = CheckOptions(bench="rover-model", suites=("pkt-board",), select=" and ".join(words))
    with contextlib.ExitStack() as stack:
        for make in mutant.patches if mutant is not None else ():
            stack.enter_context(make())
        return run_suites(options, provider)


def fault(mutant: RoverMutant, clause_id: str) -> Fault:
    """A mutant as something that a clause has to find."""
    shared = Shared(bench_file=open_bench("rover-model"), timeout_scale=1.0, journal=Journal())
    provider = RoverProvider(shared, make_rover=mutant.make)

    @contextlib.contextmanager
    def open_case(case: CaseInfo) -> Iterator[CaseBench]:
        with contextlib.ExitStack() as stack:
            for make in mutant.patches:
                stack.enter_context(make())
            yield stack.enter_context(provider.open_case(case))

    return Fault(name=mutant.id, clause_id=clause_id, select=mutant.profile, open_case=open_case)


def run_image(name: str, clauses: Sequence[str]) -> Report:
    """Run some clauses of `documented` on the emulated board, with the image that has this defect."""
    shared = Shared(bench_file=open_bench("rover"), timeout_scale=1.0, journal=Journal())
    spec = f"nucleo-f767zi:{image_path(f'rover-{name}')}"
    provider = BoardProvider(shared, [TargetChoice(name="brain.documented", spec=spec)])
    select = f"documented and ({' or '.join(clauses)})"
    return run_suites(CheckOptions(bench="rover", suites=("pkt-board",), select=select), provider)


def has_image(name: str) -> bool:
    """There is an image with this defect."""
    return image_path(f"rover-{name}").is_file()


def page(found: Found, firmware: Found) -> str:
    """The page of the table, from the clauses that find each mutant, as a model and in the firmware."""
    return "\n".join([*_head(), *_table(found, firmware), *PAGE.by_clause(found)]) + "\n"


def _head() -> Iterator[str]:
    yield "# Defects of the rover, and the clauses that find them\n"
    yield "Made by `python -m measure.mutants.rover`. Do not edit.\n"
    yield "The published firmwares of the CEAI rover differ from what their document and manual promise. Each of these"
    yield "defects is put back by itself into a rover that is otherwise as documented (a behavioural model: `defects`"
    yield "in the settings of the bench `rover-model`), and the suite `pkt-board` is run against it. Then the first"
    yield f"{SHOWN} of the clauses that found it are run against our firmware with the same defect, on the emulated"
    yield "NUCLEO-F767ZI (images `rover-DEFECT`).\n"
    yield "A star marks a clause that says *should*: what only such clauses find is a warning, and fails a run with"
    yield "`--strict` alone.\n"


def _table(found: Found, firmware: Found) -> Iterator[str]:
    yield from PAGE.published(DEFECTS.values(), found, firmware)
    yield "\n## In the firmware alone\n"
    yield "| Defect | What it does | Where it was published | Found by |"
    yield "|---|---|---|---|"
    for name, text, source, finders in FIRMWARE_ALONE:
        yield f"| `{name}` | {text} | {source} | {finders} |"
    yield "\n## Other faults\n"
    yield from PAGE.faults(BY_HAND, found)


def on_the_page() -> dict[str, tuple[str, ...]]:
    """What the page says already: by fault, the clauses that find it in the model."""
    alone = {name for name, *_ in FIRMWARE_ALONE}
    return {name: clauses for name, clauses in PAGE.said().items() if name not in alone}


def asked(mutant: RoverMutant) -> set[str]:
    """The clauses that a rover is run against."""
    return {clause.id for clause in BOARD_CLAUSES if mutant.profile in clause.profiles}


def main(words: Sequence[str]) -> int:
    """Run them all and write the page; 1 if one survives."""
    parser = argparse.ArgumentParser(prog="python -m measure.mutants.rover", description=__doc__)
    parser.add_argument("--firmware", action="store_true", help="run the images alone; the model is as on the page")
    parser.add_argument("--clauses", nargs="+", help="run these on the model alone; the rest is as on the page")
    chosen = parser.parse_args(words)
    if chosen.clauses:
        found = by_clauses(on_the_page(), all_mutants(), chosen.clauses, asked=asked, run=run)
        firmware: Found = PAGE.said_of_firmware()
    else:
        found = on_the_page() if chosen.firmware else {mutant.id: killers(run(mutant)) for mutant in all_mutants()}
        firmware = {name: killers(run_image(name, found[name][:SHOWN])) for name in DEFECTS if has_image(name)}
    PAGE.path.write_text(page(found, firmware), encoding="utf-8")
    survivors = [name for name, clauses in (*found.items(), *firmware.items()) if not clauses]
    sys.stderr.write("".join(f"{name} survives\n" for name in survivors))
    return 1 if survivors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
