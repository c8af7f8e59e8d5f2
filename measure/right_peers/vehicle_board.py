"""A vehicle-interface board that shares no code, table or CRC with the project: from the published pages alone.

It is what the profile `hardened` asks for, between a simulator and a driving stack on the stand-in link. Nothing in it
knows hilbench. A control task, a generator, says until when it waits and for what.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Generator, Iterator

COMMAND_S, STATUS_S, PAUSE_S, TRIES = 0.110, 0.100, 0.060, 10
REPORT_S, SILENCE_S, CLUMSY_S = 0.1, 3.0, 0.005
NUMBER, AUTONOMOUS, MANUAL, NOT_READY = "<f", 1, 4, 6
STATUS_MOST = (150.0, 150.0, 20.0, 2.0)
COMMAND_MOST = (2.5, 50.0, 150.0, 100.0, 1000.0)
SIZES = {1: 1, 2: 9, 3: 29, 4: 11, 5: 10, 6: 10}
Waits = tuple[float, frozenset[str]]
"""Until when the control task waits, and for what."""
Said = tuple[float, tuple[float, ...]]
"""Until when something counts, and its figures."""


def arc(data: bytes) -> int:
    """Return the CRC-16/ARC of a payload."""
    value = 0
    for byte in data:
        value ^= byte
        for _ in range(8):
            value = value >> 1 ^ (0xA001 if value & 1 else 0)
    return value


def linked(payload: bytes) -> bytes:
    """Return a payload as a frame of the stand-in link."""
    body = struct.pack("<BBH", 0, 0, len(payload)) + payload + struct.pack("<H", arc(payload))
    return b"\x7e" + body.replace(b"\x7d", b"\x7d\x5d").replace(b"\x7e", b"\x7d\x5e")


class LinkReader:
    """Finds the payloads of sound frames."""

    def __init__(self) -> None:
        self._frame: bytearray | None = None
        self._escaped = False

    def feed(self, data: bytes) -> Iterator[bytes]:
        """Take bytes; yield payloads as they end."""
        for byte in data:
            if byte == 0x7E:
                self._frame, self._escaped = bytearray(), False
            elif self._frame is not None:
                if byte == 0x7D and not self._escaped:
                    self._escaped = True
                    continue
                self._frame.append(byte ^ 0x20 if self._escaped else byte)
                self._escaped = False
                payload = self._whole()
                if payload is not None:
                    self._frame = None
                    yield payload

    def _whole(self) -> bytes | None:
        frame = self._frame or b""
        if len(frame) < 4 or len(frame) < (size := int.from_bytes(frame[2:4], "little")) + 6:
            return None
        payload, crc = bytes(frame[4 : 4 + size]), int.from_bytes(frame[4 + size : 6 + size], "little")
        return payload if frame[1] == 0 and crc == arc(payload) else b""


class StatusReader:
    """Finds whole statuses: # A B C D $, each once and in this order, within a deadline of their first byte."""

    def __init__(self) -> None:
        self._bytes = bytearray()
        self._since_s = 0.0

    def feed(self, data: bytes, now_s: float) -> Iterator[tuple[float, ...]]:
        """Take bytes; yield the four figures of each status."""
        if self._bytes and now_s - self._since_s > STATUS_S:
            self._bytes.clear()
        for byte in data:
            if not self._bytes:
                self._since_s = now_s
            self._bytes.append(byte)
            while self._bytes and not self._may_be():
                del self._bytes[0]
            if len(self._bytes) == 22:
                yield struct.unpack("<xxfxfxfxfx", self._bytes)
                self._bytes.clear()

    def _may_be(self) -> bool:
        letters = {0: 0x23, 1: 0x41, 6: 0x42, 11: 0x43, 16: 0x44, 21: 0x24}
        return all(self._bytes[at] == letter for at, letter in letters.items() if at < len(self._bytes))


def possible(figures: tuple[float, ...], most: tuple[float, ...]) -> bool:
    """Say whether all figures are numbers within their limits."""
    return all(math.isfinite(one) and abs(one) <= limit for one, limit in zip(figures, most, strict=True))


class VehicleBoard:
    """The board: bytes of each of its lines and a time in, bytes out for each of them."""

    LINES = ("simulator", "stack")

    def __init__(self, now_s: float) -> None:
        self._now_s = now_s
        self._out = dict.fromkeys(self.LINES, b"")
        self._link, self._statuses = LinkReader(), StatusReader()
        self._command: Said | None = None
        self._status: Said | None = None
        self._last = (0.0,) * 5
        self._has_last = False
        self._stamp = bytes(8)
        self._mode: int | None = None
        self._asked: tuple[float, list[int]] | None = None
        self._agent_s: float | None = None
        self._pings, self._ping_s, self._report_s = 0, now_s, now_s
        self._lamps = {0x85: 1, 0x86: 1}
        self._task = self._control()
        self._until_s, self._wants = next(self._task)

    # --- time

    @property
    def next_s(self) -> float:
        """When something is due."""
        asked = self._asked[0] + CLUMSY_S if self._asked else math.inf
        ping = self._ping_s if self._seeks else math.inf
        return min(self._until_s, self._report_s, asked, ping)

    @property
    def _seeks(self) -> bool:
        return self._agent_s is None and self._pings <= 20

    def poll(self, now_s: float) -> dict[str, bytes]:
        """Let time pass; return what is to be sent on each line."""
        while (due_s := self.next_s) <= now_s + 1e-9:
            self._now_s = max(self._now_s, due_s)
            self._happen(due_s)
        self._now_s = now_s
        said, self._out = self._out, dict.fromkeys(self.LINES, b"")
        return said

    def _happen(self, due_s: float) -> None:
        if self._asked and self._asked[0] + CLUMSY_S <= due_s:
            self._wake("asked")
        elif self._seeks and self._ping_s <= due_s:
            self._pings += 1
            self._ping_s += 1.0
            if self._pings <= 20:
                self._tell(b"\x81")
        elif self._report_s <= due_s:
            self._report_s += REPORT_S
            self._report_mode()
        else:
            self._go_on()

    def feed(self, line: str, data: bytes, now_s: float) -> dict[str, bytes]:
        """Hear bytes of a line; return what is to be sent on each."""
        before = self.poll(now_s)
        if line == "simulator":
            for figures in self._statuses.feed(data, now_s):
                if possible(figures, STATUS_MOST):
                    self._status = (now_s + STATUS_S, figures)
                    self._wake("status")
        else:
            for payload in self._link.feed(data):
                if payload and len(payload) == SIZES.get(payload[0]):
                    self._agent_s = now_s
                    self._obey(payload)
        after = self.poll(now_s)
        return {one: before[one] + after[one] for one in self.LINES}

    def _wake(self, event: str) -> None:
        if event in self._wants:
            self._go_on()

    def _go_on(self) -> None:
        self._until_s, self._wants = next(self._task)

    # --- the driving stack

    def _tell(self, payload: bytes) -> None:
        self._out["stack"] += linked(payload)

    def _report_mode(self) -> None:
        if self._agent_s is not None and self._mode is not None and self._now_s - self._agent_s < SILENCE_S:
            self._tell(b"\x83" + self._stamp + bytes([self._mode or NOT_READY]))

    def _obey(self, payload: bytes) -> None:
        kind, body = payload[0], payload[1:]
        if kind == 1:
            self._wake("agent")
        elif kind == 2:
            self._stamp = body
        elif kind == 3:
            figures = struct.unpack("<5f", body[8:])
            meant = (1.2 * figures[0], 1.2 * figures[1], *figures[2:])
            if possible(meant, COMMAND_MOST):
                self._command = (self._now_s + COMMAND_S, meant)
                self._wake("command")
        elif kind == 4:
            self._ask(body[0], body[-1])
        elif body[-1]:
            self._lamps[kind + 0x80] = body[-1]

    def _ask(self, number: int, mode: int) -> None:
        granted = mode in (AUTONOMOUS, MANUAL) and self._mode not in (0, None)
        self._tell(bytes([0x84, number, granted]))
        if granted:
            since_s, modes = self._asked or (self._now_s, [])
            self._asked = (since_s, [*modes, mode])

    def _take_asked(self) -> int | None:
        """Return the mode that was asked for, MANUAL if both were; None if nobody asked long enough ago."""
        if self._asked is None or self._now_s + 1e-9 < self._asked[0] + CLUMSY_S:
            return None
        modes, self._asked = self._asked[1], None
        return max(modes) if self._mode else None

    # --- the simulator

    def _drive(self, figures: tuple[float, ...], mode: int) -> None:
        steer, rate, speed, accel, jerk = figures
        self._out["simulator"] += struct.pack(
            "<ccfcfcfcfcfcBcx",
            *(b"#", b"S", steer, b"W", rate, b"V", speed, b"A", accel, b"J", jerk, b"M", mode, b"$"),
        )

    def _is_fresh(self, said: Said | None) -> bool:
        """Say whether there is something, and it has not waited for longer than somebody waits for it."""
        return said is not None and self._now_s <= said[0]

    def _take_status(self) -> bool:
        """Report the newest status, if there is one that has not waited for too long; say whether there is."""
        status, self._status = self._status, None
        if status is None or not self._is_fresh(status):
            return False
        lon, lat, turn, angle = status[1]
        self._tell(b"\x87" + self._stamp + struct.pack("<3f", lon, lat, turn))
        self._tell(b"\x88" + self._stamp + struct.pack(NUMBER, angle))
        for kind, value in self._lamps.items():
            self._tell(bytes([kind]) + self._stamp + bytes([value]))
        return True

    # --- the control task

    def _control(self) -> Generator[Waits, None, None]:
        end_s = self._now_s + 20.0
        while self._agent_s is None and self._now_s < end_s - 1e-9:
            yield end_s, frozenset({"agent"})
        mode = AUTONOMOUS if self._agent_s is not None else MANUAL
        while True:
            self._enter(mode)
            block = {AUTONOMOUS: self._autoware, MANUAL: self._manual}.get(mode, self._emergency)
            mode = yield from block()

    def _enter(self, mode: int) -> None:
        self._mode = mode
        self._command = None
        self._has_last = False
        self._report_mode()

    def _wait(self, seconds: float, event: str) -> Generator[Waits, None, int | None]:
        """Wait for an event, and for who asks for another mode; return that mode."""
        until_s = self._now_s + seconds
        while self._now_s < until_s - 1e-9 and not self._is_fresh(
            self._command if event == "command" else self._status
        ):
            yield until_s, frozenset({event, "asked"})
            asked = self._take_asked()
            if asked is not None and asked != self._mode:
                return asked
        return None

    def _autoware(self) -> Generator[Waits, None, int]:
        commands = statuses = 0
        while True:
            asked = yield from self._wait(COMMAND_S, "command")
            if asked is not None:
                return asked
            command, self._command = self._command, None
            if command is None or not self._is_fresh(command):
                commands += 1
                statuses = 0 if self._take_status() else statuses + 1
                if statuses >= TRIES:
                    return 0
                if commands >= TRIES:
                    return MANUAL
                if self._has_last:
                    self._drive((self._last[0], 0.0, 0.0, 0.0, 0.0), AUTONOMOUS)
                continue
            commands, self._last, self._has_last = 0, command[1], True
            self._drive(command[1], AUTONOMOUS)
            asked = yield from self._wait(STATUS_S, "status")
            if asked is not None:
                return asked
            statuses = 0 if self._take_status() else statuses + 1
            if statuses >= TRIES:
                return 0

    def _manual(self) -> Generator[Waits, None, int]:
        statuses = 0
        while True:
            self._drive((-0.0, 0.0, 0.0, 0.0, 0.0), MANUAL)
            asked = yield from self._wait(STATUS_S, "status")
            if asked is not None:
                return asked
            statuses = 0 if self._take_status() else statuses + 1
            until_s = self._now_s + PAUSE_S
            while self._now_s < until_s - 1e-9:
                yield until_s, frozenset({"asked"})
                asked = self._take_asked()
                if asked == AUTONOMOUS:
                    return asked
            if statuses >= TRIES:
                return 0

    def _emergency(self) -> Generator[Waits, None, int]:
        self._status = self._asked = None
        while True:
            self._drive((0.0,) * 5, 0)
            until_s = self._now_s + STATUS_S
            while self._now_s < until_s - 1e-9 and self._status is None:
                yield until_s, frozenset({"status"})
            if self._take_status():
                return MANUAL
