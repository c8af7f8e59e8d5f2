"""A u-blox NEO-6M as a part: a GPS receiver on a serial line, with its time pulse.

Start here; `navigation.py` makes a solution out of the antenna's motion, `nmea.py` and `nav_messages.py` write it
down, `configuration.py` does what the host sets, `ubx.py` cuts what comes in. Behaviour: u-blox 6 Receiver
Description and Protocol Specification, GPS.G6-SW-10018 (firmware 7.03), and the data sheet GPS.G6-HW-09005.

A solution is made at each moment at which GPS time is a whole number of periods, and goes out a latency later; what
is on its way out, and the rate of the line, decide when a byte is there. What is not modelled: `Neo6m.ABSENT`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from types import MappingProxyType

from targets.parts.neo6m.configuration import CFG, MON, NMEA, PUBX, Configurator, Reset
from targets.parts.neo6m.events import FixChanged, ReceiverNote, ReceiverStarted
from targets.parts.neo6m.nav_messages import NAV, NAV_MESSAGES
from targets.parts.neo6m.navigation import Navigation
from targets.parts.neo6m.nmea import PUBX_SENTENCES, SENTENCES, parse_sentence, text
from targets.parts.neo6m.settings import Neo6mSettings
from targets.parts.neo6m.solution import Fix, Solution
from targets.parts.neo6m.ubx import Dropped, Inlet, Line, UbxMessage, frame
from targets.parts.part import Control, Direction, Part, Ports, Quantity, Terminal, check_controls

__all__ = ["BOOT_TEXTS", "Neo6m"]

BOOT_TEXTS = (
    "u-blox ag - www.u-blox.com",
    "HW  UBX-G60xx  00040007 FF7FFFFFp",
    "ROM CORE 7.03 (45969) Mar 17 2011 16:18:34",
    "ANTSUPERV=AC SD PDoS SR",
    "ANTSTATUS=DONTKNOW",
)
"""What a NEO-6M says of itself after power-on, as modules with firmware 7.03 do."""

_NOTICE, _WARNING = 2, 1
_VERSION = b"7.03 (45969)".ljust(30, b"\0") + b"00040007".ljust(10, b"\0")
_MON_VER = 0x04
_UBX, _NMEA = 0x01, 0x02
_BITS_PER_BYTE = 10
_S = 1_000_000_000
_PULSE_NS = 100_000_000
_STARTS = {0x0000: "hot", 0x0001: "warm"}
_EPHEMERIS = 0x0001
_HARDWARE, _SOFTWARE, _GPS_ONLY, _SHUTDOWN, _STOP, _START = 0x00, 0x01, 0x02, 0x04, 0x08, 0x09
_NEVER = 1 << 62


class Neo6m(Part):
    """See the head of this file."""

    TERMINALS = (
        Terminal(
            name="timepulse", direction=Direction.OUT, text="high for 100 ms at each second, while there is a fix"
        ),
    )
    QUANTITIES = (
        *(Quantity(name=name, direction=Direction.IN, unit="m", text="antenna in the world") for name in "xyz"),
        *(
            Quantity(name=f"v{name}", direction=Direction.IN, unit="m/s", text="velocity in the world")
            for name in "xyz"
        ),
    )
    SERIAL = ("uart1",)
    CONTROLS = (Control(name="sky", least=0, greatest=1, rest=1, text="how much of the sky is open"),)
    ABSENT = (
        "orbits: the satellites stand still",
        "multipath, and errors that depend on speed or acceleration",
        "SBAS, DGPS, AssistNow, dead reckoning, static hold, platform models, power save mode",
        "the ports USB, DDC and SPI",
        "the sentence GRS, and PUBX,01, 05 and 06",
        "UBX classes RXM, AID and TIM; effects of CFG messages other than PRT, MSG, RATE, RST, CFG and NAV5",
    )
    Settings = Neo6mSettings

    def __init__(self, settings: Neo6mSettings, ports: Ports, *, seed: int) -> None:
        self._settings = settings
        self._ports = ports
        self._pulse = ports.output("timepulse")
        self._noted: set[str] = set()
        self._navigation = Navigation(settings, seed)
        self._configurator = Configurator(settings.baud, self._note)
        self._inlet = Inlet()
        self._started_ns = 0
        self._boot_ns = self._epoch_ns = self._out_ns = self._rise_ns = self._fall_ns = _NEVER
        self._booted = False
        self._last: Solution | None = None
        self._fix = Fix.NONE
        self._epochs = 0
        self._line_free_ns = 0
        self._line_baud = settings.baud
        self._rate_ns = _NEVER

    # --- what the bench calls

    def power_on(self, now_ns: int) -> None:
        """Begin to start up."""
        self._pulse.set(False, now_ns)
        self._navigation.acquisition.start(self._settings.start, now_ns)
        self._start(self._settings.start, now_ns)

    def after_step(self, from_ns: int, to_ns: int, before: Mapping[str, float], after: Mapping[str, float]) -> None:
        """Take where the antenna goes in the step."""
        self._navigation.step(from_ns, to_ns, before, after)

    def next_deadline_ns(self) -> int | None:
        """The next solution, output or pulse."""
        due_ns = min(self._boot_ns, self._rate_ns, self._fall_ns, self._rise_ns, self._epoch_ns, self._out_ns)
        return None if due_ns == _NEVER else due_ns

    def advance(self, now_ns: int) -> None:
        """Do everything that is due, in order; at one moment the pulse comes before the solution."""
        while (due_ns := self.next_deadline_ns()) is not None and due_ns <= now_ns:
            if due_ns == self._boot_ns:
                self._boot(due_ns)
            elif due_ns == self._rate_ns:
                self._set_rate()
            elif due_ns == self._fall_ns:
                self._fall_ns = _NEVER
                self._pulse.set(False, due_ns)
            elif due_ns == self._rise_ns:
                self._rise(due_ns)
            elif due_ns == self._epoch_ns:
                self._solve(due_ns)
            else:
                self._speak(due_ns)

    def receive(self, data: bytes, now_ns: int) -> None:
        """Take bytes from the host; nobody hears them before the start-up is over."""
        self.advance(now_ns)
        if not self._booted:
            self._note("spoken to before the start-up was over: not heard")
            return
        for found in self._inlet.receive(data):
            match found:
                case UbxMessage():
                    self._take_ubx(found, now_ns)
                case Line():
                    self._take_line(found.data, now_ns)
                case Dropped():
                    self._note(f"dropped {found.reason}")

    def set(self, values: Mapping[str, float], now_ns: int) -> None:  # noqa: ARG002
        """Open or close the sky; raises ValueError as `Part.set` does. It counts from the next solution on."""
        check_controls(self.CONTROLS, values)
        self._navigation.sky = values.get("sky", self._navigation.sky)

    # --- start

    def _start(self, kind: str, now_ns: int) -> None:
        self._started_ns = now_ns
        self._booted = False
        self._last = None
        self._inlet = Inlet()
        self._epoch_ns = self._out_ns = self._rise_ns = _NEVER
        self._boot_ns = now_ns + round(self._settings.boot_ms * 1e6)
        self._set_rate()
        self._tell_fix(Fix.NONE, 0)
        self._ports.tell(ReceiverStarted(start=kind))

    def _boot(self, now_ns: int) -> None:
        self._boot_ns = _NEVER
        self._booted = True
        self._plan(now_ns)
        self._rise_ns = self._navigation.next_epoch_ns(now_ns, 1000)
        self._send((text(_NOTICE, words) for words in BOOT_TEXTS), _NMEA, now_ns)

    def _reset(self, reset: Reset, now_ns: int) -> None:
        """CFG-RST: without its ephemerides a receiver starts warm, without more than those cold (choice)."""
        acquisition = self._navigation.acquisition
        kind = _STARTS.get(reset.cleared, "cold") if reset.cleared & _EPHEMERIS else "hot"
        if reset.mode == _STOP:
            acquisition.stop()
        elif reset.mode in (_GPS_ONLY, _START):
            acquisition.restart(kind, now_ns)
        else:
            self._configurator.restart()
            self._start(acquisition.restart(kind, now_ns), now_ns)

    # --- solutions

    def _plan(self, now_ns: int) -> None:
        self._epoch_ns = self._navigation.next_epoch_ns(now_ns, self._configurator.state.period_ms)

    def _solve(self, now_ns: int) -> None:
        self._plan(now_ns)
        self._epochs += 1
        self._last = solution = self._navigation.solve(now_ns, self._started_ns, self._configurator.state.nav5)
        self._out_ns = now_ns + round(self._settings.latency_ms * 1e6)
        self._tell_fix(solution.fix, solution.used)

    def _tell_fix(self, fix: Fix, used: int) -> None:
        if fix is not self._fix:
            self._fix = fix
            name = {Fix.NONE: "none", Fix.FIX_2D: "2d", Fix.FIX_3D: "3d"}[fix]
            self._ports.tell(FixChanged(fix=name, satellites=used))

    def _rise(self, now_ns: int) -> None:
        self._rise_ns = self._navigation.next_epoch_ns(now_ns, 1000)
        if self._fix:
            self._pulse.set(True, now_ns)
            self._fall_ns = now_ns + _PULSE_NS

    def _speak(self, now_ns: int) -> None:
        """Send what is due of the last solution: UBX by number, then the sentences (choice of the order)."""
        self._out_ns = _NEVER
        solution, state = self._last, self._configurator.state
        assert solution is not None
        due = {(group, number) for group, number, rate in state.rates if self._epochs % rate == 0}
        messages = [
            frame(UbxMessage(group=NAV, number=number, payload=write(solution)))
            for number, write in NAV_MESSAGES.items()
            if (NAV, number) in due
        ]
        self._send(messages, _UBX, now_ns)
        sentences = [write(solution) for number, write in SENTENCES.values() if (NMEA, number) in due]
        sentences += [write(solution) for number, write in PUBX_SENTENCES.items() if (PUBX, number) in due]
        self._send(sentences, _NMEA, now_ns)

    def _send(self, messages: Iterable[bytes], protocol: int, now_ns: int) -> None:
        """Put messages on the line, as long as they need not wait for too long there."""
        if not self._configurator.state.sends & protocol:
            return
        going = []
        for message in messages:
            free_ns = max(now_ns, self._line_free_ns)
            if free_ns - now_ns > self._settings.buffer_s * 1e9:
                self._note("more to send than the line can carry: messages are dropped")
                continue
            self._line_free_ns = free_ns + len(message) * _BITS_PER_BYTE * _S // self._line_baud
            going.append(message)
        if going:
            self._ports.serial(b"".join(going))

    # --- what the host says

    def _take_ubx(self, message: UbxMessage, now_ns: int) -> None:
        if not self._configurator.state.takes & _UBX:
            return
        if message.group == CFG:
            self._take_cfg(message, now_ns)
        elif message.payload:
            self._note(f"UBX 0x{message.group:02X} 0x{message.number:02X} is not modelled: not answered")
        else:
            self._take_poll(message.group, message.number, now_ns)

    def _plan_rate(self, now_ns: int) -> None:
        """A new rate of the line counts when everything that has been said before is out (choice)."""
        if self._configurator.state.baud != self._line_baud:
            self._rate_ns = max(now_ns, self._line_free_ns)

    def _set_rate(self) -> None:
        self._rate_ns = _NEVER
        self._line_baud = self._configurator.state.baud
        self._ports.rate(self._line_baud)

    def _take_cfg(self, message: UbxMessage, now_ns: int) -> None:
        period_ms = self._configurator.state.period_ms
        answers = self._configurator.handle(message)
        reset, self._configurator.reset = self._configurator.reset, None
        if reset is not None:
            self._reset(reset, now_ns)
            return
        self._send((frame(answer) for answer in answers), _UBX, now_ns)
        self._plan_rate(now_ns)
        if self._configurator.state.period_ms != period_ms:
            self._plan(now_ns)

    def _take_poll(self, group: int, number: int, now_ns: int) -> None:
        """A message without payload asks for one; there is none to give before the first solution."""
        if (group, number) == (MON, _MON_VER):
            self._send([frame(UbxMessage(group=MON, number=_MON_VER, payload=_VERSION))], _UBX, now_ns)
        elif group == NAV and number in NAV_MESSAGES:
            if self._last is not None:
                payload = NAV_MESSAGES[number](self._last)
                self._send([frame(UbxMessage(group=NAV, number=number, payload=payload))], _UBX, now_ns)
        elif (group, number) in _WRITERS:
            self._answer(_WRITERS[group, number], now_ns)
        else:
            self._note(f"UBX 0x{group:02X} 0x{number:02X} is not modelled: not answered")

    def _answer(self, write: Callable[[Solution], bytes], now_ns: int) -> None:
        if self._last is not None:
            self._send([write(self._last)], _NMEA, now_ns)

    def _take_line(self, line: bytes, now_ns: int) -> None:
        if not self._configurator.state.takes & _NMEA:
            return
        fields = parse_sentence(line)
        if fields is None:
            self._note("dropped a sentence with a wrong checksum")
        elif fields[0] == "PUBX":
            self._take_pubx(fields, now_ns)
            self._plan_rate(now_ns)
        elif fields[0][2:] == "GPQ":
            self._take_query(fields, now_ns)
        else:
            self._send([text(_WARNING, "NMEA unknown msg")], _NMEA, now_ns)

    def _take_query(self, fields: list[str], now_ns: int) -> None:
        known = SENTENCES.get(fields[1]) if len(fields) > 1 else None
        if known is None:
            self._note(f"a query of {','.join(fields[1:])} is not answered")
        else:
            self._answer(known[1], now_ns)

    def _take_pubx(self, fields: list[str], now_ns: int) -> None:
        """PUBX,40: how often a sentence comes; PUBX,41: the port; neither is answered. Others are queries."""
        kind = fields[1] if len(fields) > 1 else ""
        try:
            if len(fields) == 2 and (PUBX, int(kind)) in _WRITERS:
                self._answer(_WRITERS[PUBX, int(kind)], now_ns)
                return
            if kind == "40" and fields[2] in _SENTENCE_NUMBERS:
                self._configurator.set_rate(NMEA, _SENTENCE_NUMBERS[fields[2]], int(fields[4]) & 0xFF)
                return
            if kind == "41" and int(fields[2]) == 1 and 0 < int(fields[5]) < 2**32:
                self._configurator.set_port(int(fields[5]), int(fields[3], 16), int(fields[4], 16))
                return
        except (ValueError, IndexError):
            pass
        self._note(f"PUBX,{kind} is not modelled, or not as it was sent: without effect")

    def _note(self, words: str) -> None:
        if words not in self._noted:
            self._noted.add(words)
            self._ports.tell(ReceiverNote(text=words))


_WRITERS: Mapping[tuple[int, int], Callable[[Solution], bytes]] = MappingProxyType(
    {(NMEA, number): write for number, write in SENTENCES.values()}
    | {(PUBX, number): write for number, write in PUBX_SENTENCES.items()}
)
"""Of the sentences, by class and number."""

_SENTENCE_NUMBERS = {
    "GGA": 0x00,
    "GLL": 0x01,
    "GSA": 0x02,
    "GSV": 0x03,
    "RMC": 0x04,
    "VTG": 0x05,
    "GRS": 0x06,
    "GST": 0x07,
    "ZDA": 0x08,
    "GBS": 0x09,
    "DTM": 0x0A,
}
"""Numbers in class 0xF0 (GPS.G6-SW-10018, "NMEA Messages Overview")."""
