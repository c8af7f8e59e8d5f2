"""What both ends of the stand-in link can be set to. Times are in seconds of bench time, for people."""

from __future__ import annotations

from dataclasses import dataclass, field

from protocols.autoware.errors import LocalProtocolError
from protocols.common.flagged import FlaggedOptions
from protocols.common.options import check_positive

__all__ = ["AgentOptions", "BoardOptions", "FramingOptions"]


@dataclass(frozen=True, slots=True, kw_only=True)
class FramingOptions(FlaggedOptions):
    """How frames are made and found.

    Attributes:
        local_address: of this end.
        remote_address: of the other end.
        max_payload: the largest payload, in bytes. 64 is a choice: the longest message has 29, and the original's
            client takes 512 (UXR_CONFIG_CUSTOM_TRANSPORT_MTU).
    """

    MISUSE = LocalProtocolError

    max_payload: int = 64


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardOptions:
    """The board's end.

    Attributes:
        frames: how its frames are made and found.
        ping_s: time between two pings after a reset, and how long the last one is waited for; 1 s (LMA-FEM-UNICAMP/
            microAutoware, microAutoware.c: rmw_uros_ping_agent(1000, 20)).
        pings: how many; 20, so that the board gives up after 20 s.
        reconnects: an agent that comes later is taken, too (choice); the original needs a reset then.
    """

    frames: FramingOptions = field(default_factory=FramingOptions)
    ping_s: float = 1.0
    pings: int = 20
    reconnects: bool = True

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("ping_s", "pings"))


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentOptions:
    """The driving stack's end.

    Attributes:
        frames: how its frames are made and found.
        silence_s: a board without a sound frame for this long counts as lost; None for never. 1 s is a choice: the
            board reports its mode several times in it.
    """

    frames: FramingOptions = field(default_factory=FramingOptions)
    silence_s: float | None = 1.0

    def __post_init__(self) -> None:
        """Checks the figure."""
        check_positive(LocalProtocolError, self, ("silence_s",))
