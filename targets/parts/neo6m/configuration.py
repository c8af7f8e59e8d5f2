"""What can be set in the receiver: messages of class CFG, and the sentences PUBX,40 and PUBX,41.

Every CFG message is answered: a poll by the message itself, everything by ACK-ACK, or by ACK-NAK where it is not
known or makes no sense (GPS.G6-SW-10018, sections "CFG (0x06)" and "ACK (0x05)").
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import partial

from targets.parts.neo6m.nav_messages import NAV, NAV_MESSAGES
from targets.parts.neo6m.nmea import PUBX_SENTENCES, SENTENCES
from targets.parts.neo6m.ubx import UbxMessage

__all__ = ["CFG", "NMEA", "PUBX", "Configurator", "Nav5", "Reset", "State"]

CFG, NMEA, PUBX, MON = 0x06, 0xF0, 0xF1, 0x0A
_PRT, _MSG, _RST, _RATE, _CFG_CFG, _NAV5 = 0x00, 0x01, 0x04, 0x08, 0x09, 0x24
_UART1, _PORTS = 1, 5
_TARGETS = 6
_KNOWN_SENTENCES = range(0x0B)
_KNOWN_PUBX = (0x00, 0x01, 0x03, 0x04, 0x05, 0x06)
_SPOKEN_AT_START = ("GGA", "GLL", "GSA", "GSV", "RMC", "VTG")
_LEAST_PERIOD_MS = 200
"""5 Hz at most (NEO-6 data sheet table 2)."""

_KEPT = {0x02: 10, 0x07: 20, 0x11: 2, 0x13: 4, 0x16: 8, 0x17: 4, 0x1D: 28, 0x23: 40, 0x31: 32, 0x3B: 44}
"""INF, TP, RXM, ANT, SBAS, NMEA, TMODE, NAVX5, TP5 and PM2, with the size of their payload, or of a block of it."""

_NAV5_FORM = struct.Struct("<HBBiIbBHHHHBBIII")
_PORT_FORM = struct.Struct("<BBHIIHHHH")
_8N1 = 0x000008D0


@dataclass(frozen=True, slots=True, kw_only=True)
class Nav5:
    """CFG-NAV5: how positions are made. Fields in the units of the message."""

    dynamic_model: int = 0
    fix_mode: int = 3
    fixed_altitude_cm: int = 0
    fixed_altitude_variance: int = 10_000
    min_elevation_deg: int = 5
    dead_reckoning_limit_s: int = 0
    position_dop_tenths: int = 250
    time_dop_tenths: int = 250
    position_accuracy_m: int = 100
    time_accuracy_m: int = 300
    static_hold_cm_s: int = 0
    differential_timeout_s: int = 60


_NAV5_BITS = {
    0x01: ("dynamic_model",),
    0x02: ("min_elevation_deg",),
    0x04: ("fix_mode", "fixed_altitude_cm", "fixed_altitude_variance"),
    0x08: ("dead_reckoning_limit_s",),
    0x10: ("position_dop_tenths", "position_accuracy_m"),
    0x20: ("time_dop_tenths", "time_accuracy_m"),
    0x40: ("static_hold_cm_s",),
    0x80: ("differential_timeout_s",),
}
"""What each bit of the mask applies (GPS.G6-SW-10018, CFG-NAV5)."""


@dataclass(frozen=True, slots=True, kw_only=True)
class State:
    """Everything that can be set and saved.

    Attributes:
        baud: of UART 1.
        takes: protocols that are heard: bit 0 UBX, bit 1 NMEA, bit 2 RTCM.
        sends: protocols that are spoken.
        period_ms: from solution to solution.
        time_reference: 0 UTC, 1 GPS; kept only.
        nav5: how positions are made.
        rates: of messages on UART 1, by class and number: once in so many solutions; what is missing is off.
    """

    baud: int = 9600
    takes: int = 0x07
    sends: int = 0x03
    period_ms: int = 1000
    time_reference: int = 1
    nav5: Nav5 = field(default_factory=Nav5)
    rates: frozenset[tuple[int, int, int]] = frozenset((NMEA, SENTENCES[name][0], 1) for name in _SPOKEN_AT_START)

    def rate(self, group: int, number: int) -> int:
        """How often a message is sent: once in so many solutions; 0 for never."""
        return next((rate for a, b, rate in self.rates if (a, b) == (group, number)), 0)

    def with_rate(self, group: int, number: int, rate: int) -> State:
        """The same with another rate of a message."""
        others = frozenset(one for one in self.rates if one[:2] != (group, number))
        return replace(self, rates=others | {(group, number, rate)} if rate else others)


@dataclass(frozen=True, slots=True, kw_only=True)
class Reset:
    """CFG-RST: which backed-up data to clear, and what to start again or stop."""

    cleared: int
    mode: int


class Configurator:
    """Answers CFG messages.

    Args:
        baud: of the line at power-on.
        note: takes what is not modelled.

    Attributes:
        state: what is set now.
        reset: CFG-RST that has come in and waits to be done.
    """

    def __init__(self, baud: int, note: Callable[[str], None]) -> None:
        self._default = State(baud=baud)
        self._saved = self._default
        self._note = note
        self.state = self._default
        self.reset: Reset | None = None
        self._kept: dict[int, bytes] = {}
        self._handlers: dict[int, Callable[[bytes], list[UbxMessage] | None]] = {
            _PRT: self._prt,
            _MSG: self._msg,
            _RST: self._rst,
            _RATE: self._rate,
            _CFG_CFG: self._cfg,
            _NAV5: self._nav5,
        }

    def restart(self) -> None:
        """Take what was saved."""
        self.state = self._saved

    def handle(self, message: UbxMessage) -> list[UbxMessage]:
        """Do what a CFG message says; return the answers."""
        handler = self._handlers.get(message.number, partial(self._keep, message.number))
        answers = handler(message.payload)
        if self.reset is not None:
            return []
        done = UbxMessage(group=0x05, number=answers is not None, payload=bytes((CFG, message.number)))
        return [*(answers or ()), done]

    # --- each returns what it answers before the acknowledge, or None to refuse

    def _keep(self, number: int, payload: bytes) -> list[UbxMessage] | None:
        """Take what has no effect here, if it has the right size; give it back when it is asked for."""
        if number not in _KEPT or len(payload) % _KEPT[number]:
            self._note(f"UBX-CFG 0x{number:02X} is not modelled: not acknowledged")
            return None
        if payload:
            self._note(f"UBX-CFG 0x{number:02X} is kept, and has no effect")
            self._kept[number] = payload
            return []
        known = self._kept.get(number)
        if known is None:
            self._note(f"UBX-CFG 0x{number:02X}: what the receiver begins with is not modelled: not acknowledged")
            return None
        return [_cfg_message(number, known)]

    def _prt(self, payload: bytes) -> list[UbxMessage] | None:
        if len(payload) <= 1:
            port = payload[0] if payload else _UART1
            return [_cfg_message(_PRT, self._port(port))] if port < _PORTS else None
        if len(payload) != _PORT_FORM.size or payload[0] >= _PORTS:
            return None
        port, _, _, mode, baud, takes, sends, _, _ = _PORT_FORM.unpack(payload)
        if port != _UART1:
            self._note("UBX-CFG-PRT: ports other than UART 1 lead nowhere; taken, and without effect")
            return []
        if not baud:
            return None
        if mode & 0x3EC0 != _8N1 & 0x3EC0:
            self._note("UBX-CFG-PRT: the line stays at 8 bits without parity, whatever the mode says")
        self.set_port(baud, takes, sends)
        return []

    def set_port(self, baud: int, takes: int, sends: int) -> None:
        """Set rate and protocols of UART 1."""
        self.state = replace(self.state, baud=baud, takes=takes, sends=sends)

    def _port(self, port: int) -> bytes:
        state = self.state
        if port == _UART1:
            return _PORT_FORM.pack(port, 0, 0, _8N1, state.baud, state.takes, state.sends, 0, 0)
        mode = {0: 0x84, 2: _8N1}.get(port, 0)
        return _PORT_FORM.pack(port, 0, 0, mode, 9600 if port == 2 else 0, 0x07, 0x03, 0, 0)

    def _msg(self, payload: bytes) -> list[UbxMessage] | None:
        if len(payload) not in (2, 3, 2 + _TARGETS) or not self._known(payload[0], payload[1]):
            return None
        group, number = payload[0], payload[1]
        if len(payload) == 2:
            rates = [self.state.rate(group, number) if port == _UART1 else 0 for port in range(_TARGETS)]
            return [_cfg_message(_MSG, payload + bytes(rates))]
        self.set_rate(group, number, payload[2] if len(payload) == 3 else payload[2 + _UART1])
        return []

    def set_rate(self, group: int, number: int, rate: int) -> None:
        """Send a message once in so many solutions."""
        if rate and not _written(group, number):
            self._note(f"message 0x{group:02X} 0x{number:02X} is not modelled: its rate is kept, and nothing is sent")
        self.state = self.state.with_rate(group, number, rate)

    def _known(self, group: int, number: int) -> bool:
        """Messages that the real one has; of some classes all are taken for known (choice)."""
        if group == NMEA:
            return number in _KNOWN_SENTENCES
        if group == PUBX:
            return number in _KNOWN_PUBX
        return group in (NAV, 0x02, MON, 0x0B, 0x0D)

    def _rst(self, payload: bytes) -> list[UbxMessage] | None:
        if len(payload) != 4:
            return None
        cleared, mode, _ = struct.unpack("<HBB", payload)
        if mode not in (0x00, 0x01, 0x02, 0x04, 0x08, 0x09):
            return None
        self.reset = Reset(cleared=cleared, mode=mode)
        return []

    def _rate(self, payload: bytes) -> list[UbxMessage] | None:
        if not payload:
            return [_cfg_message(_RATE, struct.pack("<HHH", self.state.period_ms, 1, self.state.time_reference))]
        if len(payload) != 6:
            return None
        period_ms, every, reference = struct.unpack("<HHH", payload)
        if period_ms < _LEAST_PERIOD_MS or reference > 1:
            return None
        if every != 1:
            self._note("UBX-CFG-RATE: the navigation rate of a u-blox 6 is always 1")
        self.state = replace(self.state, period_ms=period_ms, time_reference=reference)
        return []

    def _cfg(self, payload: bytes) -> list[UbxMessage] | None:
        if len(payload) not in (12, 13):
            return None
        clear, save, load = struct.unpack("<III", payload[:12])
        self._saved = _mixed(self._saved, self._default, clear)
        self._saved = _mixed(self._saved, self.state, save)
        self.state = _mixed(self.state, self._saved, load)
        return []

    def _nav5(self, payload: bytes) -> list[UbxMessage] | None:
        if not payload:
            return [_cfg_message(_NAV5, _nav5_payload(self.state.nav5))]
        if len(payload) != _NAV5_FORM.size:
            return None
        mask, *values = _NAV5_FORM.unpack(payload)
        given = Nav5(**dict(zip(Nav5.__dataclass_fields__, values[:12], strict=True)))
        wanted = {name for bit, names in _NAV5_BITS.items() if mask & bit for name in names}
        new = replace(self.state.nav5, **{name: getattr(given, name) for name in wanted})
        if new.fix_mode not in (1, 2, 3) or new.dynamic_model in (1,) or new.dynamic_model > 8:
            return None
        for name in ("static_hold_cm_s", "dead_reckoning_limit_s"):
            if getattr(new, name):
                self._note(f"UBX-CFG-NAV5: {name} is kept, and has no effect")
        self.state = replace(self.state, nav5=new)
        return []


def _written(group: int, number: int) -> bool:
    if group == NMEA:
        return number in {known for known, _ in SENTENCES.values()}
    if group == PUBX:
        return number in PUBX_SENTENCES
    return group == NAV and number in NAV_MESSAGES


def _cfg_message(number: int, payload: bytes) -> UbxMessage:
    return UbxMessage(group=CFG, number=number, payload=payload)


def _nav5_payload(nav5: Nav5) -> bytes:
    return _NAV5_FORM.pack(0xFFFF, *(getattr(nav5, name) for name in Nav5.__dataclass_fields__), 0, 0, 0)


def _mixed(old: State, new: State, mask: int) -> State:
    """Take sections over: bit 0 the port, bit 1 the messages, bit 3 navigation (GPS.G6-SW-10018, CFG-CFG)."""
    if mask & 0x01:
        old = replace(old, baud=new.baud, takes=new.takes, sends=new.sends)
    if mask & 0x02:
        old = replace(old, rates=new.rates)
    if mask & 0x08:
        old = replace(old, period_ms=new.period_ms, time_reference=new.time_reference, nav5=new.nav5)
    return old
