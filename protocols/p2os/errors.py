"""The two families of error of this protocol stack.

    P2osError
     +-- LocalProtocolError    the program on this side misused the stack
     +-- RemoteProtocolError   the peer sent what makes no sense

`FrameReader.receive` and `Connection.receive` raise neither of them, whatever the bytes are: they report and count.
`RemoteProtocolError` comes only from the `decode` functions, which are handed the body of one sound frame.
"""

from __future__ import annotations

__all__ = ["LocalProtocolError", "P2osError", "RemoteProtocolError"]


class P2osError(Exception):
    """Base of every error that this package raises on purpose."""


class LocalProtocolError(P2osError):
    """This side asked for something the protocol does not have; nothing was changed.

    Examples: sending a command before the session is open, a string longer than a frame, a speed that does not fit
    in sixteen bits, connecting twice.
    """


class RemoteProtocolError(P2osError):
    """The peer sent a body that cannot be read.

    Examples: a SIP whose sonar count reaches past its end, an identification without its three strings, an argument
    of unknown type.
    """
