"""What a session can be set to. Times are in seconds of bench time, for people."""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

from protocols.common.flagged import FlaggedOptions
from protocols.common.options import check_positive
from protocols.xrce.codes import NO_SESSION, NO_SESSION_WITH_KEY
from protocols.xrce.errors import LocalProtocolError

__all__ = [
    "LEAST_MTU",
    "LONGEST_S",
    "AgentOptions",
    "ClientOptions",
    "Framing",
    "FramingOptions",
    "StreamOptions",
]

_MOST = 0xFFFF
_BITMAP_BITS = 16
_KEY_BYTES = 4
LONGEST_S = 0x7FFFFFFF
"""The latest second of a clock, and the longest silence: what the seconds of `Time` can say, 68 years."""
LEAST_MTU = 36
"""Bytes of the shortest message that a session can do with: TIMESTAMP_REPLY with a client key in the header."""


class Framing(enum.Enum):
    """How messages stand on a line."""

    SERIAL = "flags, escapes, CRC"
    LENGTH = "a length of 16 bits before each, low byte first, as over TCP"
    EITHER = "whichever the other end begins with"


@dataclass(frozen=True, slots=True, kw_only=True)
class FramingOptions(FlaggedOptions):
    """How frames are made and found.

    Attributes:
        framing: how messages stand on the line; an agent may find it out.
        local_address: of this end.
        remote_address: of the other end; an agent answers to the address that asks, and keeps that for a session.
        max_payload: the largest payload, in bytes; by default whatever the length field can say, as in
            Micro-XRCE-DDS-Agent (config.hpp: SERVER_BUFFER_SIZE 65535).
    """

    MISUSE = LocalProtocolError

    framing: Framing = Framing.SERIAL


@dataclass(frozen=True, slots=True, kw_only=True)
class StreamOptions:
    """How streams repeat and what they keep.

    Attributes:
        window: messages of a reliable stream that may be on their way unacknowledged, 1..16, as an ACKNACK has 16
            bits; also those that are kept for one that is missing before them.
        heartbeat_s: time from the first unacknowledged message to the first HEARTBEAT, 0.1 s
            (Micro-XRCE-DDS-Client, CMakeLists.txt: UCLIENT_MIN_HEARTBEAT_TIME_INTERVAL 100 ms); it doubles each time
            until an ACKNACK comes, as there.
        heartbeat_max_s: the longest time between two; 1.6 s is a choice, the original doubles on.
        repeat_s: time in which no message is sent again twice, whatever ACKNACKs say; 0.05 s is a choice, half of the
            shortest time to a HEARTBEAT, so that the answer to that is always obeyed.
        max_queued: bytes of messages that wait for the window of one stream; 65536 is a choice.
        max_message: bytes of a message put together from fragments; 65536 is a choice.
        max_streams: streams of each kind that the peer may use, and reliable ones that are sent on beside the built-in
            one; 16 is a choice.
    """

    window: int = _BITMAP_BITS
    heartbeat_s: float = 0.1
    heartbeat_max_s: float = 1.6
    repeat_s: float = 0.05
    max_queued: int = 0x10000
    max_message: int = 0x10000
    max_streams: int = 16

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("heartbeat_s", "heartbeat_max_s", "repeat_s"))
        check_positive(LocalProtocolError, self, ("max_queued", "max_message", "max_streams"))
        if not 1 <= self.window <= _BITMAP_BITS:
            raise LocalProtocolError(f"window {self.window} is not 1..{_BITMAP_BITS}")


def _check_lengths(mtu: int, frames: FramingOptions) -> None:
    for name, length in (("mtu", mtu), ("max_payload", frames.max_payload)):
        if not LEAST_MTU <= length <= _MOST:
            raise LocalProtocolError(f"{name} {length} is not {LEAST_MTU}..{_MOST}")


@dataclass(frozen=True, slots=True, kw_only=True)
class ClientOptions:
    """The client's end.

    Attributes:
        client_key: 4 bytes, another one for each client of an agent, not all of them 0.
        session_id: 0x81 is micro-ROS's (Micro-XRCE-DDS-Client, session.c uxr_init_session); below 0x80 each message
            has the key in its header.
        mtu: the longest message, in bytes, as announced to the agent; 512 is that of its serial transports.
        properties: names and values that are sent to the agent.
        attempts: how often CREATE_CLIENT and DELETE are sent until they are answered; 10
            (UCLIENT_MAX_SESSION_CONNECTION_ATTEMPTS).
        retry_s: time between these; 1 s (UCLIENT_MIN_SESSION_CONNECTION_INTERVAL).
        epoch_ns: what this side's clock says at bench time 0, in ns.
        frames: how its frames are made and found.
        streams: how its streams repeat and what they keep.
    """

    client_key: bytes
    session_id: int = 0x81
    mtu: int = 512
    properties: tuple[tuple[str, str], ...] = ()
    attempts: int = 10
    retry_s: float = 1.0
    epoch_ns: int = 0
    frames: FramingOptions = field(default_factory=FramingOptions)
    streams: StreamOptions = field(default_factory=StreamOptions)

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("attempts", "retry_s"))
        _check_lengths(self.mtu, self.frames)
        if len(self.client_key) != _KEY_BYTES or not any(self.client_key):
            raise LocalProtocolError(f"client_key {self.client_key.hex()} is not 4 bytes that are not all 0")
        if not 0 <= self.session_id <= 0xFF or self.session_id in (NO_SESSION, NO_SESSION_WITH_KEY):
            raise LocalProtocolError(f"session_id {self.session_id:#04x} is that of no session")


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentOptions:
    """The agent's end.

    Attributes:
        mtu: the longest message, in bytes, to a client that says none; 512 is that of a client's serial transports.
        silence_s: a client without a message for this long counts as lost, at most 2147483647 s; None for never, as in
            the original.
        epoch_ns: what the agent's clock says at bench time 0, in ns; TIMESTAMP is answered by it.
        frames: how its frames are made and found.
        streams: how its streams repeat and what they keep.
        max_objects: objects of one client; 256 is a choice.
        history: samples that are kept for a reader, or for those that come later, whatever they ask for; 16 is a
            choice.
        max_history_bytes: of these samples; 65536 is a choice.
        references: the profiles that clients refer to, as XML; see `protocols.xrce.descriptions.Profiles`.
    """

    mtu: int = 512
    silence_s: float | None = None
    epoch_ns: int = 0
    frames: FramingOptions = field(default_factory=FramingOptions)
    streams: StreamOptions = field(default_factory=StreamOptions)
    max_objects: int = 256
    history: int = 16
    max_history_bytes: int = 0x10000
    references: str = ""

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("silence_s", "max_objects", "history", "max_history_bytes"))
        if self.silence_s is not None and self.silence_s > LONGEST_S:
            raise LocalProtocolError(f"silence_s is {self.silence_s}, above {LONGEST_S}")
        _check_lengths(self.mtu, self.frames)
