"""The two families of error of this protocol stack.

    PktError
     +-- LocalProtocolError    the program on this side misused the stack
     +-- RemoteProtocolError   the peer sent what makes no sense

`FrameReader.receive` and `Connection.receive` raise neither of them, whatever the bytes are: they report and count.
`RemoteProtocolError` comes only from the `decode` functions, which are handed the payload of one sound frame.
"""

from __future__ import annotations

__all__ = ["LocalProtocolError", "PktError", "RemoteProtocolError"]


class PktError(Exception):
    """Base of every error that this package raises on purpose."""


class LocalProtocolError(PktError):
    """This side asked for something the protocol does not have; nothing was changed.

    Examples: a throttle for a rover that knows speeds only, a payload longer than a frame, a number that does not fit
    in a float of 32 bits, connecting twice.
    """


class RemoteProtocolError(PktError):
    """The peer sent a payload that cannot be read.

    Examples: a motor command without its flags, a report of the wrong size.
    """
