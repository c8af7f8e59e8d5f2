"""Commands, from the client to the server: a number and at most one argument.

The table of what each number means stands in `command_table.py`. A number that is in no table can be sent and decoded
all the same: a server ignores it, but it counts as traffic (Pioneer 2 Operations Manual; AMRISim EmulatePioneer.cc).
"""

from __future__ import annotations

from dataclasses import dataclass

from protocols.p2os.arguments import (
    ArgumentForm,
    BytePacking,
    decode_argument,
    encode_argument,
    pack_bytes,
    unpack_signed_bytes,
)
from protocols.p2os.command_table import COMMANDS, ArgumentKind, CommandNumber, CommandSpec, Support
from protocols.p2os.errors import LocalProtocolError, RemoteProtocolError
from protocols.p2os.framing import MAX_COUNT_STRICT, encode_frame

__all__ = [
    "COMMANDS",
    "VEL2_UNIT_MM_S",
    "ArgumentKind",
    "Command",
    "CommandNumber",
    "CommandSpec",
    "Support",
    "check_argument_kind",
    "command_name",
    "decode_command",
    "digout",
    "encode_command",
    "encode_command_body",
    "vel2",
    "vel2_speeds_mm_s",
]

VEL2_UNIT_MM_S = 20
"""One unit of a VEL2 byte on a Pioneer 2, in mm/s (Pioneer 2 Operations Manual); 4 on a Pioneer 1."""

_RAW_STRING_COMMANDS = frozenset((CommandNumber.TTY2, CommandNumber.TTY3, CommandNumber.TTY4))


@dataclass(frozen=True, slots=True)
class Command:
    """One command.

    Attributes:
        number: 0..255; `CommandNumber` has the names.
        argument: an integer (-65535..65535 on the wire, as sign and magnitude), a string of bytes, or None.
    """

    number: int
    argument: int | bytes | None = None

    @property
    def name(self) -> str:
        """The name of the number, for example "VEL"; "#200" where it has none."""
        return command_name(self.number)

    @property
    def value(self) -> int:
        """The integer argument; where there is none, what a server takes instead (1 for CONFIG, otherwise mostly 0)."""
        if isinstance(self.argument, int):
            return self.argument
        spec = COMMANDS.get(self.number)
        return spec.default if spec is not None else 0

    @property
    def text(self) -> bytes:
        """The string argument; empty where there is none."""
        return self.argument if isinstance(self.argument, bytes) else b""


def command_name(number: int) -> str:
    """The name of a command number, for example "VEL"; "#200" where it has none."""
    spec = COMMANDS.get(number)
    return spec.name if spec is not None else f"#{number}"


def encode_command_body(command: Command, *, form: ArgumentForm = ArgumentForm.PLAIN) -> bytes:
    """The body of a command's frame.

    Raises:
        LocalProtocolError: the number is no byte, or the argument does not fit its type.
    """
    if not 0 <= command.number <= 0xFF:
        raise LocalProtocolError(f"command number {command.number} is not 0..255")
    return bytes((command.number,)) + encode_argument(command.argument, form)


def encode_command(
    command: Command, *, form: ArgumentForm = ArgumentForm.PLAIN, max_count: int = MAX_COUNT_STRICT
) -> bytes:
    """The whole frame of a command.

    Args:
        command: what to say.
        form: how to write the argument; anything but PLAIN imitates a particular sender.
        max_count: the largest count byte allowed.

    Raises:
        LocalProtocolError: the number is no byte, the argument does not fit its type, or the frame is too long.
    """
    return encode_frame(encode_command_body(command, form=form), max_count=max_count)


def decode_command(body: bytes, *, raw_tty: bool = True) -> Command:
    """The command in a frame's body, with every tolerance that real senders need (see `arguments.py`).

    Args:
        body: the body of a sound frame.
        raw_tty: for TTY2, TTY3 and TTY4 only, take a string without a proper length byte for raw data.

    Raises:
        RemoteProtocolError: the body is empty or its argument cannot be read.
    """
    if not body:
        raise RemoteProtocolError("an empty body holds no command number")
    number = body[0]
    raw_string = raw_tty and number in _RAW_STRING_COMMANDS
    return Command(number=number, argument=decode_argument(body[1:], raw_string=raw_string))


def check_argument_kind(command: Command) -> None:
    """Holds a command against its entry in the table.

    Raises:
        RemoteProtocolError: a string where the command takes an integer, or the other way round. A missing argument
            is never wrong, nor is any argument of a command that takes none or is unknown.
    """
    spec = COMMANDS.get(command.number)
    if spec is None or command.argument is None or spec.argument is ArgumentKind.NONE:
        return
    if (spec.argument is ArgumentKind.STRING) != isinstance(command.argument, bytes):
        raise RemoteProtocolError(f"{spec.name} takes {spec.argument.value}, not {command.argument!r}")


def vel2(
    left_mm_s: float,
    right_mm_s: float,
    *,
    unit_mm_s: float = VEL2_UNIT_MM_S,
    packing: BytePacking = BytePacking.SIGNED,
) -> Command:
    """VEL2 for two wheel speeds in mm/s: left in the high byte, right in the low, rounded toward 0, within +-127.

    Source: AriaCoda ArRobot.cpp, setVel2; Player p2os driver, p2os.cc.
    """
    left, right = (max(-127, min(127, int(speed / unit_mm_s))) for speed in (left_mm_s, right_mm_s))
    return Command(number=CommandNumber.VEL2, argument=pack_bytes(left, right, packing))


def vel2_speeds_mm_s(command: Command, *, unit_mm_s: float = VEL2_UNIT_MM_S) -> tuple[float, float]:
    """The (left, right) wheel speeds in mm/s of a VEL2 in either packing."""
    left, right = unpack_signed_bytes(command.value)
    return left * unit_mm_s, right * unit_mm_s


def digout(mask: int, value: int, *, packing: BytePacking = BytePacking.SIGNED) -> Command:
    """DIGOUT: the outputs whose bit is set in `mask` (0..255) take their bit of `value` (0..255)."""
    return Command(number=CommandNumber.DIGOUT, argument=pack_bytes(mask, value, packing))
