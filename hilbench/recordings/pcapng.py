"""A recording as pcapng, for Wireshark: the bytes of each line with their direction, and what happened as comments.

Blocks follow the Internet-Draft "PCAP Now Generic (pcapng) Capture File Format" (draft-ietf-opsawg-pcapng): a section,
one interface for each end of a line that was watched, a packet for each event. Link type 250, LINKTYPE_RTAC_SERIAL
(tcpdump.org/linktypes), because Wireshark has a dissector for it that shows bytes, direction and control lines of a
serial port; for one of LINKTYPE_USER0 to 15 each user would have to set up one. Time is bench time in ns, from 0, which
Wireshark shows as 1970-01-01.

Pins and poses are left out: VCD and MCAP have them. Everything else comes back as it was.
"""

from __future__ import annotations

import struct
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import IO, Any

import msgspec

from hilbench.clock import NS_PER_S
from hilbench.journal import Recording
from hilbench.recordings.layout import Event, data_of, json_bytes, laid_out, without

__all__ = ["LEFT_OUT", "MAGIC", "read_pcapng", "write_pcapng"]

MAGIC = b"\x0a\x0d\x0d\x0a"
LEFT_OUT = frozenset({"pin", "pwm", "frames", "pose", "scene", "margins"})

LINKTYPE_RTAC_SERIAL = 250
LINKTYPE_USER = range(147, 163)
_SECTION, _INTERFACE, _PACKET = 0x0A0D0D0A, 1, 6
_ORDER_MAGIC = 0x1A2B3C4D
_END, _COMMENT, _IF_NAME, _IF_DESCRIPTION, _IF_TSRESOL, _APPLICATION, _FLAGS = 0, 1, 2, 3, 9, 4, 2
_INBOUND, _OUTBOUND = 1, 2
_NS_DIGITS = 9
_US_DIGITS = 6
_STATUS_CHANGE, _TX_START, _RX_START, _TX_END, _RX_END = range(5)
_OTHER_EVENTS = {5: "bytes lost", 6: "complete", 7: "framing error", 8: "parity error", 9: "break", 10: "overflow"}
_RTAC_HEADER = struct.Struct(">IIBBH")
_PROGRAM = b"hilbench "
_LONGEST_BLOCK = 64 * 1024 * 1024
_LONGEST_OPTION = 0xFFFF
_ABOUT = ("ns", "kind", "source", "format", "bench", "seed")


def write_pcapng(recording: Recording, file: IO[bytes]) -> int:
    """Write a recording; return how many events were written, each as one packet."""
    named = recording.header.get("hilbench", "")
    header = [(_COMMENT, _text_of(recording.header)), (_APPLICATION, _PROGRAM + str(named).encode())]
    file.write(_block(_SECTION, struct.pack("<IHHq", _ORDER_MAGIC, 1, 0, -1) + _options(header)))
    interfaces = {"journal": 0}
    file.write(_interface("journal", "what happened on the bench, as comments"))
    written = 0
    for ns, event in laid_out(recording.events):
        if event["kind"] in LEFT_OUT:
            continue
        source = str(event.get("source", "")) if data_of(event) is not None else "journal"
        if source not in interfaces:
            interfaces[source] = len(interfaces)
            file.write(_interface(source, f"what {source} sends and receives"))
        file.write(_packet(interfaces[source], ns, event))
        written += 1
    return written


def _interface(name: str, description: str) -> bytes:
    options = [(_IF_NAME, name.encode()), (_IF_DESCRIPTION, description.encode()), (_IF_TSRESOL, bytes([_NS_DIGITS]))]
    return _block(_INTERFACE, struct.pack("<HHI", LINKTYPE_RTAC_SERIAL, 0, 0) + _options(options))


def _packet(interface: int, ns: int, event: Event) -> bytes:
    data = data_of(event)
    sent = event["kind"] == "tx"
    if data is None:
        kind, comment, options = _STATUS_CHANGE, dict(event), []
    else:
        kind = _TX_START if sent else _RX_START
        comment = without(event, "ns", "source", "data", *(() if event["kind"] == "dropped" else ("kind",)))
        options = [(_FLAGS, struct.pack("<I", _OUTBOUND if sent else _INBOUND))]
    if comment:
        options.insert(0, (_COMMENT, _text_of(comment)))
    seconds, rest_ns = divmod(ns, NS_PER_S)
    body = _RTAC_HEADER.pack(seconds & 0xFFFFFFFF, rest_ns // 1000, kind, 0, 0) + (data or b"")
    head = struct.pack("<IIIII", interface, ns >> 32, ns & 0xFFFFFFFF, len(body), len(body))
    return _block(_PACKET, head + _padded(body) + _options(options))


def _block(kind: int, body: bytes) -> bytes:
    length = len(body) + 12
    return struct.pack("<II", kind, length) + body + struct.pack("<I", length)


def _options(options: list[tuple[int, bytes]]) -> bytes:
    fitting = [(code, value[:_LONGEST_OPTION]) for code, value in options]
    packed = b"".join(struct.pack("<HH", code, len(value)) + _padded(value) for code, value in fitting)
    return packed + struct.pack("<HH", _END, 0) if packed else b""


def _text_of(fields: Mapping[str, Any]) -> bytes:
    """Return fields as a comment; where an option has no room for them, no more than what they are of."""
    text = json_bytes(fields)
    if len(text) <= _LONGEST_OPTION:
        return text
    return json_bytes({name: fields[name] for name in _ABOUT if name in fields} | {"cut": "too long for a comment"})


def _padded(data: bytes) -> bytes:
    return data + b"\0" * (-len(data) % 4)


# --- reading


@dataclass(slots=True)
class _Interface:
    name: str
    link_type: int
    ticks_per_s: int


@dataclass(slots=True)
class _Reader:
    """Takes the blocks of a file, of either byte order."""

    data: bytes
    order: str = "<"
    header: dict[str, Any] = field(default_factory=dict)
    ours: bool = False
    interfaces: list[_Interface] = field(default_factory=list)
    events: list[Event] = field(default_factory=list)
    base_ns: int = 0

    def read(self) -> str | None:
        """Take all of them; return what ended the reading before the end of the file."""
        at = number = 0
        while at < len(self.data):
            number += 1
            block = self._block(at)
            if block is None:
                return f"cut in block {number}"
            kind, body, at = block
            try:
                self._take(kind, body)
            except (struct.error, LookupError, TypeError, ValueError, msgspec.DecodeError, RecursionError):
                return f"block {number} cannot be read"
        return None if number else "the file is empty"

    def _block(self, at: int) -> tuple[int, bytes, int] | None:
        """Return kind and body of the block that begins here, and where the next one does; None if it is not whole."""
        if len(self.data) < at + 12:
            return None
        if self.data[at : at + 4] == MAGIC:
            self.order = "<" if self.data[at + 8 : at + 12] == struct.pack("<I", _ORDER_MAGIC) else ">"
        kind, length = struct.unpack_from(f"{self.order}II", self.data, at)
        end = at + length
        if length < 12 or length > _LONGEST_BLOCK or end > len(self.data):
            return None
        return kind, self.data[at + 8 : end - 4], end

    def _take(self, kind: int, body: bytes) -> None:
        if kind == _SECTION:
            self.interfaces.clear()
            options = self._options(body[16:])
            self.ours = options.get(_APPLICATION, b"").startswith(_PROGRAM)
            if self.ours and _COMMENT in options and not self.header:
                self.header = _fields(options[_COMMENT])
        elif kind == _INTERFACE:
            self._take_interface(body)
        elif kind == _PACKET:
            self._take_packet(body)

    def _take_interface(self, body: bytes) -> None:
        link_type = struct.unpack_from(f"{self.order}H", body)[0]
        options = self._options(body[8:])
        name = options.get(_IF_NAME, f"interface{len(self.interfaces)}".encode()).decode("utf-8", "replace")
        resolution = options.get(_IF_TSRESOL, bytes([_US_DIGITS]))[0]
        ticks = 2 ** (resolution & 0x7F) if resolution & 0x80 else 10**resolution
        self.interfaces.append(_Interface(name, link_type, ticks))

    def _take_packet(self, body: bytes) -> None:
        number, high, low, length, _ = struct.unpack_from(f"{self.order}IIIII", body)
        packet = body[20 : 20 + length]
        options = self._options(body[20 + length + (-length % 4) :])
        interface = self.interfaces[number]
        ns = (high << 32 | low) * NS_PER_S // interface.ticks_per_s
        comment = _fields(options[_COMMENT]) if self.ours and _COMMENT in options else {}
        if "kind" in comment and "source" in comment:
            if comment["kind"] == "case":
                self.base_ns = ns - int(comment["ns"])
            self.events.append(comment)
            return
        flags = struct.unpack(f"{self.order}I", options[_FLAGS])[0] if len(options.get(_FLAGS, b"")) == 4 else 0
        event = _event(interface, packet, sent=flags & 3 == _OUTBOUND)
        if event is not None:
            self.events.append({"ns": ns - self.base_ns, **event, **comment})

    def _options(self, data: bytes) -> dict[int, bytes]:
        found: dict[int, bytes] = {}
        at = 0
        while at + 4 <= len(data):
            code, length = struct.unpack_from(f"{self.order}HH", data, at)
            if code == _END:
                break
            found.setdefault(code, data[at + 4 : at + 4 + length])
            at += 4 + length + (-length % 4)
        return found


def _fields(comment: bytes) -> dict[str, Any]:
    return msgspec.json.decode(comment, type=dict[str, Any])


def _event(interface: _Interface, packet: bytes, *, sent: bool) -> Mapping[str, Any] | None:
    """Return what a packet says: bytes of a line, or what else happened there; None on another kind of link."""
    if interface.link_type == LINKTYPE_RTAC_SERIAL:
        kind, data = _RTAC_HEADER.unpack_from(packet)[2], packet[_RTAC_HEADER.size :]
        if kind not in {_TX_START, _RX_START, _TX_END, _RX_END}:
            return {"kind": "note", "source": interface.name, "text": _OTHER_EVENTS.get(kind, "status change")}
        sent = kind in {_TX_START, _TX_END}
    elif interface.link_type in LINKTYPE_USER:
        data = packet
    else:
        return None
    return {"kind": "tx" if sent else "rx", "source": interface.name, "data": data.hex()}


def read_pcapng(data: bytes) -> Recording:
    """Read a capture: of ours every event that it has, of others the bytes of serial interfaces.

    Interfaces of other kinds are passed over. A file that was cut is read up to there.
    """
    reader = _Reader(data)
    problem = reader.read()
    events: tuple[Event, ...] = tuple(reader.events)
    ended = bool(events) and events[-1]["kind"] == "host-end"
    return Recording(header=reader.header, events=events, problem=problem, ended=ended)
