"""Whole families of stimuli, each tried member by member: every bit of a CRC, every size of a payload, every place."""

from __future__ import annotations

import itertools
import struct
from collections.abc import Iterator, Mapping

from hilbench.check import Inconclusive, Untimely, Violation, at_most
from hilbench.judging.uncertainty import OfTimes
from hilbench.suites._rover import DONE_S, Rover, on_rover
from hilbench.suites._spoiling import WrongByte, other_rules, other_values, single_bits
from hilbench.suites.pkt_board._frames import BAD_CRC, SUCCESS, UNKNOWN_OPCODE, led_on_frame, require_refused
from protocols.pkt import (
    COMMANDS,
    SYNC,
    TERMINATOR,
    Framing,
    GeneralReport,
    LedOff,
    MotorThrottles,
    ReportId,
    RequestTelemetry,
    SpeedSetpoints,
    hides_newline,
)

TAIL = 4
"""The last bytes of a frame whose payload is an opcode: opcode, CRC, newline."""

CRC = ("CRC byte 1", "CRC byte 2")

NOT_ASKED_WITHIN = 4
"""So many frames are sent between two 0x80 that come by themselves, three times a second."""

PERIODIC_SPARE_S = 0.33 - NOT_ASKED_WITHIN * (DONE_S + 0.005)
"""How long it is from the last of them to the next 0x80 that comes by itself."""


# --- CRC


def _opcode_and_crc(frame: bytes) -> Mapping[int, str]:
    """Name the bytes of a frame whose payload is an opcode, by their places."""
    return dict(enumerate(("opcode", *CRC), start=len(frame) - TAIL))


def _crc(frame: bytes) -> Mapping[int, str]:
    return dict(enumerate(CRC, start=len(frame) - TAIL + 1))


@on_rover("P67", lasts_s=3.2)
def test_every_bit_of_a_crc_counts(rover: Rover) -> None:
    rover.dark()
    frame, rejected = led_on_frame(rover), itertools.count(1)

    def is_rejected(wrong: WrongByte) -> None:
        frame_is_rejected(wrong.put_into(frame))

    def frame_is_rejected(wrong: bytes) -> None:
        mark = rover.mark()
        rover.write(wrong)
        rover.require(0, next(rejected), None, BAD_CRC)
        rover.require_dark()
        rover.require_executions(mark)

    rover.try_members("single bits", single_bits(frame, _opcode_and_crc(frame)), is_rejected, budget=24)
    rover.try_members("wrong bytes of a CRC", other_values(frame, _crc(frame), SYNC[:1]), is_rejected, budget=24)
    others = other_rules(frame, rover.peer.checksum())
    rover.try_members("CRCs by another rule", others, frame_is_rejected, budget=len(others))


@on_rover("P68", lasts_s=3.2)
def test_a_wrong_crc_has_no_answer(rover: Rover) -> None:
    frame, sent = rover.peer.frame_of(RequestTelemetry()), itertools.count()

    def is_not_answered(wrong: WrongByte) -> None:
        late_s = rover.peer.uncertainty_s(rover.peer.bench.now_ns)
        if next(sent) % NOT_ASKED_WITHIN == 0 or NOT_ASKED_WITHIN * late_s > PERIODIC_SPARE_S:
            rover.after_periodic()
        mark = rover.mark()
        rover.write(wrong.put_into(frame))
        if rover.peer.since(mark, GeneralReport):
            text = "a request with a wrong CRC was answered"
            raise Untimely(text, rover.peer.evidence(mark), spare_s=PERIODIC_SPARE_S)

    corrupted = [*single_bits(frame, _opcode_and_crc(frame)), *other_values(frame, _crc(frame), SYNC[:1])]
    rover.try_members("corrupted requests", corrupted, is_not_answered, budget=24)
    # A frame that begins as the time of another ends may be lost on the way (FrameTimer.SINCE_RESET).
    rover.require(0, next(sent), None, BAD_CRC, spare_s=PERIODIC_SPARE_S / NOT_ASKED_WITHIN)


# --- sizes


def _parameters(rover: Rover, opcode: int, size: int) -> bytes:
    """Return parameters whose effect differs from size to size, as exact floats."""
    throttle = size / 128
    if not rover.v2:
        return struct.pack(">hhB", size, -size, 3) if opcode == 3 else b""
    of = {
        3: struct.pack("<ffB", throttle, -throttle, 3),
        4: struct.pack("<ffB", size / 2, -size / 2, 3),
        5: struct.pack("<fff", 0.01, 0.0001, 0.0001),
    }
    return of.get(opcode, b"")


@on_rover("P69", lasts_s=8.5)
def test_every_size_too_small_is_refused(rover: Rover) -> None:
    rover.drive(0.5, -0.25)
    setpoints_rpm = rover.motion().setpoints_rpm

    def is_refused(payload: bytes) -> None:
        require_refused(rover, payload)
        report = rover.motion()
        rover.require_throttles(report, 0.5, -0.25)
        rover.require_setpoints(report, *setpoints_rpm)

    members = []
    for opcode, spec in COMMANDS[rover.schema].items():
        whole = bytes((opcode,)) + _parameters(rover, opcode, 96)
        members += [(f"{spec.name} with {size} bytes of {spec.size}", whole[: 1 + size]) for size in range(spec.size)]
    rover.try_members("sizes too small", members, is_refused, budget=len(members))


@on_rover("P70", lasts_s=6.0)
def test_every_size_too_large_is_taken(rover: Rover) -> None:
    def is_taken(payload: bytes) -> None:
        before, mark, opcode = rover.counts, rover.mark(), payload[0]
        rover.write(rover.peer.frame(payload))
        if opcode == 0:
            if not rover.peer.since(mark, GeneralReport):
                raise Untimely("it was not answered", rover.peer.evidence(mark))
            rover.require(before.accepted, before.rejected, before.opcode, before.error)
            return
        rover.require((before.accepted + 1) % 256, before.rejected, opcode, SUCCESS)
        if rover.v2:
            _require_effect(rover, opcode, payload)

    limit = rover.peer.profile.server.frames.payload_limit
    members = []
    for opcode, spec in COMMANDS[rover.schema].items():
        for size in range(spec.size + 2, limit + 1):
            payload = (bytes((opcode,)) + _parameters(rover, opcode, size)).ljust(size, b"\x7f")
            if _fits(rover, payload):
                members.append((f"{spec.name}, {size} bytes of payload", payload))
    rover.try_members("sizes too large", members, is_taken, budget=24)
    for opcode, spec in COMMANDS[rover.schema].items():
        for behind in (b"\xff", b"\0"):
            payload = bytes((opcode,)) + _parameters(rover, opcode, spec.size + SPARE)
            is_taken(payload.ljust(spec.size + SPARE, behind))


SPARE = 3
"""Bytes of payload beside a command's parameters, of which the values are tried: its opcode and two behind them."""


def _require_effect(rover: Rover, opcode: int, payload: bytes) -> None:
    """Require that the parameters were taken from behind the opcode."""
    size = len(payload)
    if opcode == 3:
        rover.require_throttles(rover.motion(), size / 128, -size / 128)
    elif opcode == 4:
        rover.require_setpoints(rover.motion(), size / 2, -size / 2)


# --- bytes

SIZE = 16
FILL = b"\x55"

FLOW_CONTROL = {0x11: "XON", 0x13: "XOFF"}
OF_FRAMES = {value: f"'{chr(value)}'" for value in SYNC} | {TERMINATOR[0]: "newline"}
OF_TERMINALS = {
    0x00: "NUL",
    0x03: "ETX, ^C",
    0x04: "EOT, ^D",
    0x08: "BS",
    0x0D: "CR",
    0x0F: "SI, ^O",
    0x12: "DC2, ^R",
    0x15: "NAK, ^U",
    0x16: "SYN, ^V",
    0x17: "ETB, ^W",
    0x1A: "SUB, ^Z",
    0x1B: "ESC",
    0x1C: "FS, ^\\",
    0x7F: "DEL",
    0xFF: "FF",
}


def _fits(rover: Rover, payload: bytes) -> bool:
    """Say whether a payload can be sent in the rover's frames: without a length byte a newline ends it."""
    return rover.peer.profile.server.frames.framing is Framing.LEN or not hides_newline(payload)


def _room(rover: Rover) -> int:
    """Return how long a payload may be; g2 loses a look of eleven bytes, and a longer frame may be cut into one."""
    return SIZE if rover.peer.profile.server.poll is None else 2


def _with_values(rover: Rover, values: Mapping[int, str]) -> Iterator[tuple[str, bytes]]:
    """Yield payloads of LED_ON that have a value at each place of payload and CRC, and as their length."""
    room = _room(rover)
    for value, name in values.items():
        byte = bytes((value,))
        for place in range(1, room):
            payload = (b"\x01" + FILL * (place - 1) + byte).ljust(room, FILL)
            yield f"{name} ({value:02X}) at byte {place} of the payload", payload
        candidates = [b"\x01" + bytes((more,)).rjust(room - 1, FILL) for more in range(256)]
        for place, of_crc in ((-3, "high"), (-2, "low")):
            found = next((one for one in candidates if rover.peer.frame(one)[place] == value), None)
            if found is not None:
                yield f"{name} ({value:02X}) as the CRC's {of_crc} byte", found
        if SIZE < value <= rover.peer.profile.server.frames.payload_limit and room == SIZE:
            yield f"{value} bytes of payload ({value:02X})", b"\x01".ljust(value, FILL)


def _with_frames(rover: Rover) -> Iterator[tuple[str, bytes]]:
    """Yield payloads of LED_ON in which sync words and whole frames stand."""
    for what, inside in (("sync word", SYNC), ("whole LED_OFF", rover.peer.frame_of(LedOff()))):
        for place in range(1, 1 + _room(rover) - len(inside)):
            payload = (b"\x01" + FILL * (place - 1) + inside).ljust(SIZE, FILL)
            yield f"a {what} at byte {place} of the payload", payload


@on_rover("P71", lasts_s=3.6)
def test_no_byte_is_special_inside_a_frame(rover: Rover) -> None:
    accepted = itertools.count(1)

    def is_taken(payload: bytes) -> None:
        rover.write(rover.peer.frame(payload))
        rover.require(next(accepted) % 256, 0, 1, SUCCESS)
        rover.require_lit()

    rover.dark()
    families = (
        ("flow-control bytes", _with_values(rover, FLOW_CONTROL)),
        ("bytes of frames", itertools.chain(_with_values(rover, OF_FRAMES), _with_frames(rover))),
        ("control characters", _with_values(rover, OF_TERMINALS)),
    )
    for family, members in families:
        distinct = {payload: what for what, payload in members if _fits(rover, payload)}
        rover.try_members(family, [(what, payload) for payload, what in distinct.items()], is_taken, budget=18)


# --- what means nothing

RESERVED = {ReportId.IMU: (2, 3), ReportId.MOTION: (1, 2, 3), ReportId.GPS: (2, 3)}
"""By report the places of its payload that mean nothing; byte 1 of 0x82 and 0x84 has a meaning."""


@on_rover("P72", lasts_s=2.3)
def test_reserved_bytes_of_reports_are_zero(rover: Rover) -> None:
    mark = rover.mark()
    rover.peer.run(2.2)
    payload_at = len(SYNC) + 1
    received = [got.raw[payload_at:] for got in rover.peer.received[mark:]]
    for rate in rover.peer.profile.server.rates:
        places = RESERVED.get(rate.report)
        if places is None:
            continue
        reports = [payload for payload in received if payload[0] == rate.report]
        if not reports:
            text = f"no 0x{rate.report:02X} came in 2.2 s"
            raise Untimely(text, rover.peer.evidence(mark), spare_s=1.0)
        for payload in reports:
            set_ones = [f"byte {place} is {payload[place]:02X}" for place in places if payload[place]]
            if set_ones:
                raise Violation(f"0x{rate.report:02X}: {', '.join(set_ones)}, required 00", [payload.hex(" ")])


@on_rover("P73", lasts_s=5.0)
def test_reserved_flags_mean_nothing(rover: Rover) -> None:
    rover.drive(0.5, -0.25)

    def is_no_other_flag(flags: int) -> None:
        rover.send(MotorThrottles(a=0.5, b=-0.25))
        rover.send(MotorThrottles(a=flags / 256, b=-flags / 256, flags=flags))
        left, right = (flags / 256 if flags & 1 else 0.5), (-flags / 256 if flags & 2 else -0.25)
        rover.require_throttles(rover.motion(), left, right)

    def is_no_other_flag_of_setpoints(flags: int) -> None:
        rover.send(SpeedSetpoints(a_rpm=30.0, b_rpm=-20.0))
        rover.send(SpeedSetpoints(a_rpm=flags / 8, b_rpm=-flags / 8, flags=flags))
        left_rpm, right_rpm = (flags / 8 if flags & 1 else 30.0), (-flags / 8 if flags & 2 else -20.0)
        rover.require_setpoints(rover.motion(), left_rpm, right_rpm)

    members = [(f"flags {flags:02X}", flags) for flags in range(4, 256)]
    rover.try_members("reserved flags of 0x03", members, is_no_other_flag, budget=8)
    rover.try_members("reserved flags of 0x04", members, is_no_other_flag_of_setpoints, budget=8)


@on_rover("P74", lasts_s=2.6)
def test_no_unknown_opcode_is_taken_for_another(rover: Rover) -> None:
    accepted = itertools.count(1)

    def is_unknown(opcode: int) -> None:
        rover.write(rover.peer.frame(bytes((opcode,))))
        rover.require(next(accepted), 0, opcode, UNKNOWN_OPCODE)

    members = [(f"opcode {opcode:02X}", opcode) for opcode in range(256) if opcode not in COMMANDS[rover.schema]]
    rover.try_members("unknown opcodes", members, is_unknown, budget=40)


@on_rover("P75", lasts_s=8.0)
def test_reports_do_not_double_when_the_port_is_opened_again(rover: Rover) -> None:
    def count() -> int:
        mark = rover.mark()
        rover.peer.run(2.0)
        return len(rover.peer.received[mark:])

    before = count()
    if not before:
        raise Inconclusive("no report comes by itself")
    for number in ("second", "third"):
        rover.reopen(0.5)
        begun_ns = rover.peer.bench.now_ns
        found, doubt = count(), before / 2.0 * rover.peer.uncertainty_s(begun_ns)
        what = f"in 2 s, the port open for the {number} time"
        at_most(found, 1.5 * before, unit="reports", what=what, uncertainty=OfTimes(doubt) if doubt else 0.0)
