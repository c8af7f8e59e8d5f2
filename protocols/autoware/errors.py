"""The two families of error of this protocol stack.

    AutowareError
     +-- LocalProtocolError    the program on this side misused the stack
     +-- RemoteProtocolError   the peer sent what makes no sense

`FrameReader.receive` and `Connection.receive` raise neither of them, whatever the bytes are: they report and count.
`RemoteProtocolError` comes only from `decode_message`, which is handed the payload of one sound frame.
"""

from __future__ import annotations

__all__ = ["AutowareError", "LocalProtocolError", "RemoteProtocolError"]


class AutowareError(Exception):
    """Base of every error that this package raises on purpose."""


class LocalProtocolError(AutowareError):
    """This side asked for something the link does not have; nothing was changed.

    Examples: a report sent by the agent, a number that does not fit in a float of 32 bits, opening a link twice.
    """


class RemoteProtocolError(AutowareError):
    """The peer sent a payload that cannot be read.

    Examples: an empty one, a control command without its jerk, a success that is neither 0 nor 1.
    """
