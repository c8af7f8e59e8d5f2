"""A PKT! rover board that shares no code, table or CRC with the project: written from document and manual alone.

It has the length byte and the promises of the profile `documented`. Nothing in it knows hilbench, and it runs alone:
``python rover_board.py`` opens a pty, says its name, and serves it in real time.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator

SYNC = b"PKT!"
LONGEST = 96
HEARTBEAT_S = PACKET_TIMEOUT_S = 1.0
OK, BAD_SYNC, BAD_LENGTH, BAD_CRC, BAD_END, UNKNOWN, TOO_SHORT = 0, 1, 2, 3, 4, 5, 6
SIZES = {0: 0, 1: 0, 2: 0, 3: 9, 4: 9, 5: 12}
STEP_S = 0.02
TASKS = ((0x80, 0.33), (0x83, 0.25), (0x82, 1.0), (0x84, 1.0))
IN_FLIGHT = "the rest of the packet"


def crc16(data: bytes) -> int:
    """Return the CRC of a payload, bit by bit: x^16 + x^12 + x^5 + 1, from all ones."""
    value = 0xFFFF
    for bit in (byte >> place & 1 for byte in data for place in range(7, -1, -1)):
        top, value = value >> 15, value << 1 & 0xFFFF
        if top != bit:
            value ^= 0x1021
    return value


def framed(payload: bytes) -> bytes:
    """Return the frame of a payload."""
    return SYNC + bytes([len(payload)]) + payload + crc16(payload).to_bytes(2, "big") + b"\n"


class Side:
    """One pair of wheels with its motor: a throttle, a controller of speed, and a plant of first order."""

    def __init__(self) -> None:
        self.throttle = self.setpoint = self.rpm = self.turns = 0.0
        self.controlled = False
        self.gains = (0.01, 0.0001, 0.0001)  # of the error, of its change, of its sum
        self.sum = self.last = 0.0

    def stop(self) -> None:
        """Let the motor run out, with nothing remembered."""
        self.throttle = self.setpoint = self.sum = self.last = 0.0
        self.controlled = False

    def step(self) -> None:
        """Let 20 ms pass."""
        if self.controlled:
            proportional, derivative, integral = self.gains
            error = self.setpoint - self.rpm
            self.sum += error * STEP_S
            wanted = proportional * error + integral * self.sum + derivative * (error - self.last) / STEP_S
            self.last = error
            self.throttle = max(-1.0, min(1.0, wanted))
        aim = 300 * self.throttle if abs(self.throttle) > 0.2 else 0.0
        self.rpm += (aim - self.rpm) * STEP_S / 0.1
        if abs(self.rpm) < 1:
            self.rpm = 0.0
        self.turns += abs(self.rpm) / 60 * STEP_S


class RoverBoard:
    """The board: bytes and a time in, bytes out."""

    def __init__(self, now_s: float) -> None:
        self._begin_s = self._heard_s = self._stepped_s = now_s
        self._next = {report: now_s for report, _ in TASKS}
        self._buffer = bytearray()
        self._buffer_s = now_s
        self._accepted = self._rejected = self._opcode = self._error = 0
        self._sides = (Side(), Side())
        self._out: list[bytes] = []
        self.led = False

    @property
    def next_s(self) -> float:
        """When something is due."""
        return min(self._stepped_s + STEP_S, *self._next.values())

    def poll(self, now_s: float) -> bytes:
        """Let time pass; return what is to be sent."""
        while self._stepped_s + STEP_S <= now_s + 1e-9:
            self._stepped_s += STEP_S
            for side in self._sides:
                side.step()
        if now_s - self._heard_s > HEARTBEAT_S:
            for side in self._sides:
                side.stop()
        for report, period_s in TASKS:
            while self._next[report] <= now_s + 1e-9:
                self._next[report] += period_s
                self._say(getattr(self, f"_report_{report:02x}")())
        said, self._out = b"".join(self._out), []
        return said

    def feed(self, data: bytes, now_s: float) -> bytes:
        """Hear bytes; return what is to be sent."""
        before = self.poll(now_s)
        if self._buffer and now_s - self._buffer_s >= PACKET_TIMEOUT_S:
            self._buffer.clear()
        if not self._buffer:
            self._buffer_s = now_s
        self._buffer += data
        for payload in self._payloads(now_s):
            self._obey(payload, now_s)
        return before + self.poll(now_s)

    # --- frames

    def _payloads(self, now_s: float) -> Iterator[bytes]:
        """Yield sound payloads; what is wrong is counted and looked through for the next packet."""
        while self._buffer:
            size = len(self._buffer)
            error, used = self._look()
            if error is None and used == 0:
                return
            if error is None:
                payload = bytes(self._buffer[5 : used - 3])
                del self._buffer[:used]
                yield payload
            else:
                if error:
                    self._rejected = (self._rejected + 1) % 256
                    self._error = error
                del self._buffer[:used]
            if len(self._buffer) != size:
                self._buffer_s = now_s

    def _look(self) -> tuple[int | None, int]:
        """Return what the buffer begins with: an error, 0 between packets, None for a packet; and how many bytes."""
        data = self._buffer
        if data[0] != SYNC[0]:
            return OK, 1
        for place in range(1, 4):
            if len(data) == place:
                return None, 0
            if data[place] != SYNC[place]:
                return BAD_SYNC, place
        if len(data) == 4:
            return None, 0
        length = data[4]
        if not 1 <= length <= LONGEST:
            return BAD_LENGTH, 5
        whole = length + 8
        if len(data) >= whole - 1 and crc16(bytes(data[5 : 5 + length])) != int.from_bytes(
            data[5 + length : 7 + length], "big"
        ):
            return BAD_CRC, self._next_p(whole - 1)
        if len(data) < whole:
            return None, 0
        return (None, whole) if data[whole - 1] == 0x0A else (BAD_END, self._next_p(whole - 1))

    def _next_p(self, most: int) -> int:
        """Return how much of a bad packet is thrown away: up to what may begin another one."""
        at = self._buffer.find(SYNC, 1, most + 3)
        return most if at < 0 else at

    def _say(self, payload: bytes) -> None:
        self._out.append(framed(payload))

    # --- commands

    def _obey(self, payload: bytes, now_s: float) -> None:
        self._heard_s = now_s
        opcode, given = payload[0], payload[1:]
        if opcode == 0:
            self._say(self._report_80())
            return
        self._accepted = (self._accepted + 1) % 256
        self._opcode = opcode
        self._error = self._run(opcode, given)
        self._say(bytes([0x81, opcode, self._error]))

    def _run(self, opcode: int, given: bytes) -> int:
        if opcode not in SIZES:
            return UNKNOWN
        if len(given) < SIZES[opcode]:
            return TOO_SHORT
        if opcode in (1, 2):
            self.led = opcode == 1
        elif opcode == 5:
            proportional, derivative, integral = struct.unpack_from("<3f", given)
            for side in self._sides:
                side.gains, side.sum, side.last = (proportional, derivative, integral), 0.0, 0.0
        else:
            *wanted, flags = struct.unpack_from("<ffB", given)
            for number, (side, value) in enumerate(zip(self._sides, wanted, strict=True)):
                if flags >> number & 1 and math.isfinite(value):
                    self._set(side, value, speed=opcode == 4)
        return OK

    def _set(self, side: Side, value: float, *, speed: bool) -> None:
        if speed != side.controlled:
            side.sum = side.last = 0.0
        side.controlled = speed
        if speed:
            side.setpoint = value
        else:
            side.throttle, side.setpoint = max(-1.0, min(1.0, value)), 0.0

    # --- reports

    def _report_80(self) -> bytes:
        return bytes([0x80, self._accepted, self._rejected, self._opcode, self._error, 0])

    def _report_82(self) -> bytes:
        rest = (0.0, 0.0, 9.81, 0.0, 0.0, 0.0, 230.0, 0.0, -90.0, 24.0, 0.0, 0.0, 0.0, 1.0)
        return b"\x82\x03\0\0" + struct.pack("<14f", *rest)

    def _report_83(self) -> bytes:
        left, right = self._sides
        four = (left, right, left, right)
        return b"\x83\0\0\0" + struct.pack(
            "<4f4I4f",
            *(abs(side.rpm) for side in four),
            *(int(20 * side.turns) for side in four),
            *(side.throttle for side in self._sides),
            *(side.setpoint for side in self._sides),
        )

    def _report_84(self) -> bytes:
        return b"\x84\0\0\0" + struct.pack("<2f", -34.6175, -58.3683)
