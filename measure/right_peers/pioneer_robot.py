"""A Pioneer 2-DX on an endless floor that shares no code, table or checksum with the project: from the manuals alone.

Nothing in it knows hilbench.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterator

HEADER = b"\xfa\xfb"
STEP_S, SIP_S, DISC_S, WATCHDOG_S = 0.005, 0.1, 0.04, 2.0
MM_PER_UNIT, RANGE_MM_PER_UNIT, HALF_TRACK_MM = 0.84, 0.268, 1 / 0.0056
TICKS_PER_MM = 132
TOPS = {"setv": 1600, "setrv": 360, "seta+": 2000, "seta-": 2000, "setra+": 300, "setra-": 300}
DEFAULTS = {"setv": 750, "setrv": 100, "seta+": 300, "seta-": 300, "setra+": 100, "setra-": 100}
GAINS = {82: 40, 83: 20, 84: 0, 85: 40, 86: 30, 87: 0}
NAME, CLASS, SUBCLASS = b"lone", b"Pioneer", b"p2dx"
ANALOG = (512, 100, 200, 300, 400, 500)
MOTION = frozenset({8, 9, 11, 12, 13, 21, 22, 32})


def checksum(body: bytes) -> int:
    """Return the sum of a body by the manual: big-endian words, and an odd byte over the low one."""
    total = 0
    for place in range(0, len(body) - 1, 2):
        total += body[place] * 256 + body[place + 1]
    total %= 65536
    return total ^ body[-1] if len(body) % 2 else total


def packed(body: bytes) -> bytes:
    """Return the packet of a body."""
    return HEADER + bytes([len(body) + 2]) + body + checksum(body).to_bytes(2, "big")


def toward(now: float, goal: float, gain: float, loss: float) -> float:
    """Return a speed one step nearer to its goal, by how fast it may grow and fall."""
    rate = gain if abs(goal) > abs(now) and goal * now >= 0 else loss
    change = max(-rate * STEP_S, min(rate * STEP_S, goal - now))
    return now + change


def shortest(angle_deg: float) -> float:
    """Return an angle from -180 to 180 degrees."""
    return math.remainder(angle_deg, 360)


class PioneerRobot:
    """The robot: bytes and a time in, bytes out."""

    def __init__(self, now_s: float) -> None:
        self._now_s = self._step_s = self._sip_s = self._disc_s = self._fed_s = now_s
        self._buffer = bytearray()
        self._sync = 0
        self._open = False
        self._out: list[bytes] = []
        self._x_mm = self._y_mm = self._heading_deg = 0.0
        self._left_mm = self._right_mm = 0.0
        self._outputs = 0
        self._begin_session()

    def _begin_session(self) -> None:
        """Be as at power-on, but for the place and the outputs."""
        self._limits = dict(DEFAULTS)
        self._gains = dict(GAINS)
        self._enabled, self._sonar = False, True
        self._discs, self._next_disc = list(range(8)), 0
        self._heard_discs: list[int] = []
        self._port = 5
        self._streams = {0x90: 0, 0xF0: 0}
        self._configs = 0
        self._rest()

    def _rest(self) -> None:
        """Stand, with nothing to do."""
        self._speed = self._turn = 0.0
        self._wheels: tuple[float, float] | None = None
        self._goal_speed = self._goal_turn = 0.0
        self._aim_mm: float | None = None
        self._aim_deg: float | None = None
        self._hard = False

    # --- time

    @property
    def next_s(self) -> float:
        """When something is due."""
        return min(self._step_s + STEP_S, self._sip_s if self._open else math.inf)

    def poll(self, now_s: float) -> bytes:
        """Let time pass; return what is to be sent."""
        while self._step_s + STEP_S <= now_s + 1e-9:
            self._step_s += STEP_S
            self._move()
            while self._disc_s + DISC_S <= self._step_s + 1e-9:
                self._disc_s += DISC_S
                self._fire()
        while self._open and self._sip_s <= now_s + 1e-9:
            self._sip_s += SIP_S
            self._cycle()
        self._now_s = now_s
        said, self._out = b"".join(self._out), []
        return said

    def feed(self, data: bytes, now_s: float) -> bytes:
        """Hear bytes; return what is to be sent."""
        before = self.poll(now_s)
        self._buffer += data
        for body in self._bodies():
            self._obey(body)
        return before + self.poll(now_s)

    def _bodies(self) -> Iterator[bytes]:
        while (at := self._buffer.find(HEADER)) >= 0:
            del self._buffer[:at]
            if len(self._buffer) < 3:
                return
            count = self._buffer[2]
            if not 3 <= count <= 200:
                del self._buffer[:2]
                continue
            if len(self._buffer) < count + 3:
                return
            body, sent = bytes(self._buffer[3 : count + 1]), self._buffer[count + 1 : count + 3]
            if checksum(body) == int.from_bytes(sent, "big"):
                del self._buffer[: count + 3]
                yield body
            else:
                del self._buffer[:2]
        del self._buffer[: max(0, len(self._buffer) - 1)]

    # --- motion

    def _move(self) -> None:
        if not self._enabled:
            return
        lost = self._step_s - self._fed_s > WATCHDOG_S
        gain, loss = (self._limits["seta+"], self._limits["seta-"]) if not self._hard else (5000, 5000)
        if self._wheels is not None:
            left, right = self._speed - self._side, self._speed + self._side
            wanted = (0.0, 0.0) if lost else self._wheels
            left, right = toward(left, wanted[0], gain, loss), toward(right, wanted[1], gain, loss)
            self._speed, self._turn = (left + right) / 2, math.degrees((right - left) / 2 / HALF_TRACK_MM)
        else:
            self._speed = toward(self._speed, 0.0 if lost else self._wanted_speed(), gain, loss)
            gain, loss = (self._limits["setra+"], self._limits["setra-"]) if not self._hard else (1000, 1000)
            self._turn = toward(self._turn, 0.0 if lost else self._wanted_turn(), gain, loss)
        self._go()

    @property
    def _side(self) -> float:
        return math.radians(self._turn) * HALF_TRACK_MM

    def _go(self) -> None:
        way = self._speed * STEP_S
        middle = math.radians(self._heading_deg + self._turn * STEP_S / 2)
        self._x_mm += way * math.cos(middle)
        self._y_mm += way * math.sin(middle)
        self._heading_deg = shortest(self._heading_deg + self._turn * STEP_S)
        self._left_mm += (self._speed - self._side) * STEP_S
        self._right_mm += (self._speed + self._side) * STEP_S
        if self._aim_mm is not None:
            self._aim_mm -= way

    def _wanted_speed(self) -> float:
        if self._aim_mm is None:
            return self._goal_speed
        if abs(self._aim_mm) < 1:
            self._aim_mm, self._goal_speed = None, 0.0
            return 0.0
        return math.copysign(
            min(self._limits["setv"], math.sqrt(1.8 * self._limits["seta-"] * abs(self._aim_mm))), self._aim_mm
        )

    def _wanted_turn(self) -> float:
        if self._aim_deg is None:
            return self._goal_turn
        left = shortest(self._aim_deg - self._heading_deg)
        if abs(left) < 0.05:
            return 0.0
        return math.copysign(min(self._limits["setrv"], math.sqrt(1.6 * self._limits["setra-"] * abs(left))), left)

    # --- what is sent

    def _fire(self) -> None:
        if self._open and self._sonar and self._discs:
            self._heard_discs.append(self._discs[self._next_disc % len(self._discs)])
            self._next_disc += 1

    def _cycle(self) -> None:
        self._say(self._sip())
        for _ in range(self._configs):
            self._say(self._config())
        self._configs = 0
        for kind, make in ((0x90, self._encoders), (0xF0, self._io)):
            if self._streams[kind]:
                self._say(make())
            if self._streams[kind] == 1:
                self._streams[kind] = 0

    def _say(self, body: bytes) -> None:
        self._out.append(packed(body))

    def _units(self, mm: float) -> int:
        return math.floor(mm / MM_PER_UNIT) & 0x7FFF

    def _sip(self) -> bytes:
        moving = round(self._speed) != 0 or abs(self._turn) > 0.3
        heading = self._heading_deg if self._aim_deg is None else shortest(self._aim_deg)
        discs, self._heard_discs = self._heard_discs, []
        body = struct.pack(
            "<BHHhhhBBBhHBB",
            0x33 if moving else 0x32,
            self._units(self._x_mm),
            self._units(self._y_mm),
            self._angle(self._heading_deg),
            round(self._speed - self._side),
            round(self._speed + self._side),
            127,
            0,
            0,
            self._angle(heading),
            self._enabled | self._sonar << 1,
            0,
            len(discs),
        )
        body += b"".join(struct.pack("<BH", disc, int(5000 / RANGE_MM_PER_UNIT)) for disc in discs)
        return body + bytes([self._port, 0, ANALOG[self._port % 6] >> 2, 0xFF, self._outputs])

    @staticmethod
    def _angle(angle_deg: float) -> int:
        return (round(angle_deg * 4096 / 360) + 2048) % 4096 - 2048

    def _config(self) -> bytes:
        limits = self._limits
        strings = (CLASS, SUBCLASS, b"LONE0001")
        body = b"\x20" + b"".join(one + b"\0" for one in strings)
        body += struct.pack("<B5H", 0, TOPS["setrv"], TOPS["setv"], TOPS["setra+"], TOPS["seta+"], 500) + NAME + b"\0"
        body += struct.pack("<3B2HB", 100, 0, 0, 0, 1, 0)
        body += struct.pack("<3HB4H", 110, 16570, round(1000 * WATCHDOG_S), 0, 200, 200, 500, 100)
        body += struct.pack("<4H", limits["setrv"], limits["setv"], limits["setra+"], limits["setra-"])
        body += struct.pack("<3H", *(self._gains[number] for number in (82, 83, 84)))
        body += struct.pack("<2H", limits["seta+"], limits["seta-"])
        return body + struct.pack("<3H", *(self._gains[number] for number in (85, 86, 87)))

    def _encoders(self) -> bytes:
        return b"\x90" + struct.pack("<2i", int(self._left_mm * TICKS_PER_MM), int(self._right_mm * TICKS_PER_MM))

    def _io(self) -> bytes:
        return struct.pack("<BBBBBB", 0xF0, 1, 0xFF, 1, self._outputs, len(ANALOG)) + struct.pack("<6H", *ANALOG)

    # --- what is heard

    def _obey(self, body: bytes) -> None:
        self._fed_s = self._step_s
        number = body[0]
        if not self._open:
            self._shake_hands(number, body)
            return
        value, text = self._argument(body)
        if number == 2:
            self._open = False
            self._sync = 0
            self._begin_session()
        elif number == 4:
            self._enabled = bool(value)
            if not self._enabled:
                self._rest()
        elif number in MOTION:
            if self._enabled:
                self._steer(number, value or 0)
        elif text is not None or value is not None or number in (7, 18, 19, 29, 40, 55):
            self._set(number, value, text)

    def _shake_hands(self, number: int, body: bytes) -> None:
        if number == 1 and self._sync == 3:
            self._begin_session()
            self._open = True
            self._sip_s = self._disc_s = self._step_s
            self._sip_s += SIP_S
        elif number > 2 or len(body) > 1:
            return  # a command, and there is no session
        elif number < 2:
            self._say(body)
            self._sync = number + 1
        else:
            self._say(b"\x02" + b"".join(one + b"\0" for one in (NAME, CLASS, SUBCLASS)))
            self._sync = 3

    @staticmethod
    def _argument(body: bytes) -> tuple[int | None, bytes | None]:
        """Return the number or the text that a packet gives; None for what it does not."""
        if len(body) >= 4 and body[1] in (0x3B, 0x1B):
            value = body[2] | body[3] << 8
            return (value if body[1] == 0x3B else -value), None
        if len(body) >= 3 and body[1] == 0x2B and len(body) >= 3 + body[2]:
            return None, body[3 : 3 + body[2]]
        return None, None

    def _steer(self, number: int, value: int) -> None:
        self._hard = False
        if number == 32:
            bits = value & 0xFFFF
            right, left = (20 * ((one + 128) % 256 - 128) for one in (bits & 0xFF, bits >> 8))
            self._aim_mm = self._aim_deg = None
            self._goal_speed = self._goal_turn = 0.0
            self._wheels = (left, right)
            return
        if self._wheels is not None:
            self._wheels, self._goal_speed, self._goal_turn = None, 0.0, 0.0
        top, turn_top = self._limits["setv"], self._limits["setrv"]
        if number == 11:
            self._goal_speed, self._aim_mm = max(-top, min(top, value)), None
        elif number == 8:
            self._aim_mm = value
        elif number == 21:
            self._goal_turn, self._aim_deg = max(-turn_top, min(turn_top, value)), None
        elif number == 12:
            self._aim_deg = value
        elif number in (9, 13):
            self._aim_deg = self._heading_deg + value
        else:
            self._aim_deg = (self._heading_deg if self._aim_deg is None else self._aim_deg) + value

    def _set(self, number: int, value: int | None, text: bytes | None) -> None:
        given = 1 if value is None else value
        if number == 7:
            if self._aim_deg is not None:
                self._aim_deg -= self._heading_deg
            self._x_mm = self._y_mm = self._heading_deg = 0.0
        elif number == 18:
            self._configs += 1
        elif number in (19, 40):
            self._streams[0x90 if number == 19 else 0xF0] = given
        elif number in (29, 55):
            self._brake(hard=number == 55)
        elif number == 3 and text is not None:
            self._discs = [one - 1 for one in text if 1 <= one <= 8]
        elif number == 28:
            self._sonar = bool(given)
            self._heard_discs.clear()
        elif value is not None:
            self._store(number, value)

    def _brake(self, *, hard: bool) -> None:
        self._goal_speed = self._goal_turn = 0.0
        self._aim_mm = self._aim_deg = None
        self._wheels = None if self._wheels is None else (0.0, 0.0)
        self._hard = hard

    def _store(self, number: int, value: int) -> None:
        if number == 30:
            mask, wanted = value >> 8 & 0xFF, value & 0xFF
            self._outputs = self._outputs & ~mask | wanted & mask
        elif number == 35:
            self._port = value & 0xFF
        elif number in self._gains:
            self._gains[number] = value & 0xFFFF
        else:
            self._limit(number, value)

    def _limit(self, number: int, value: int) -> None:
        sign = "-" if value < 0 else "+"
        name = {5: f"seta{sign}", 23: f"setra{sign}", 6: "setv", 10: "setrv"}.get(number)
        if name is not None:
            self._limits[name] = min(TOPS[name], abs(value))
