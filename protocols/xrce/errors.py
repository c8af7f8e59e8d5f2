"""The two families of error of this protocol stack.

    XrceError
     +-- LocalProtocolError    the program on this side misused the stack
     |    +-- StreamFullError  a reliable stream has no room for the message now
     +-- RemoteProtocolError   the peer sent what makes no sense

`FrameReader.receive` and `Session.receive` raise neither of them, whatever the bytes are: they report and count.
`RemoteProtocolError` comes only from the `decode` functions, which are handed one message or one value.
"""

from __future__ import annotations

__all__ = ["LocalProtocolError", "RemoteProtocolError", "StreamFullError", "XrceError"]


class XrceError(Exception):
    """Base of every error that this package raises on purpose."""


class LocalProtocolError(XrceError):
    """This side asked for something the protocol does not have; nothing was changed.

    Examples: a number that does not fit its field, a submessage longer than a message of a best-effort stream,
    connecting twice, a message definition that cannot be read.
    """


class StreamFullError(LocalProtocolError):
    """The peer has not acknowledged enough for one more message; it is to be offered again later, or dropped."""


class RemoteProtocolError(XrceError):
    """The peer sent bytes that cannot be read.

    Examples: a string longer than what is left, a submessage that ends behind its message, a boolean of 2.
    """
