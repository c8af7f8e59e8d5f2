"""The two families of error of this protocol stack.

    CarlaError
     +-- LocalProtocolError    the program on this side misused the stack
     +-- RemoteProtocolError   the peer sent what makes no sense

The readers and `Connection.receive` raise neither of them, whatever the bytes are: they report and count.
`RemoteProtocolError` comes only from the `decode` functions, which are handed one whole frame.
"""

from __future__ import annotations

__all__ = ["CarlaError", "LocalProtocolError", "RemoteProtocolError"]


class CarlaError(Exception):
    """Base of every error that this package raises on purpose."""


class LocalProtocolError(CarlaError):
    """This side asked for something the protocol does not have; nothing was changed.

    Examples: a number that does not fit in a float of 32 bits, a joystick reading beyond 16 bits, a velocity report
    given to a board, options of the other role.
    """


class RemoteProtocolError(CarlaError):
    """The peer sent a frame that cannot be read.

    Examples: a frame of the wrong length, a letter where another should stand.
    """
