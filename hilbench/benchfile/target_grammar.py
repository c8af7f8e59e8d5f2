"""What can stand at the far end of a line, in the words of the command line: one grammar for every command.

==============================================  ========================================================
``MODEL``, ``MODEL:PROFILE``                    a model of a system; of some, one of its profiles
``BOARD:IMAGE``, ``./board.toml:IMAGE``         an emulated board with firmware
``serial:PORT[@BAUD[,KEY=VALUE]...]``           a serial port; see `hilbench.links.serial_target`
``socket://HOST:PORT`` and the like             any URL that pyserial knows
``listen:pty:PATH``, ``listen:tcp:[HOST:]PORT``  a client that comes to us
``exec:COMMAND``                                a client that is started; ``{pty}`` or ``{port}`` is where it connects
``capture:FILE``                                what was recorded
==============================================  ========================================================
"""

from __future__ import annotations

import enum
import shlex
from dataclasses import dataclass

from hilbench.benchfile.board_files import is_board_file
from hilbench.errors import UsageError
from hilbench.links.serial_target import is_serial_target, parse_serial_target
from hilbench.nearest import did_you_mean
from hilbench.plugins.discovery import PLUGINS
from hilbench.terminal.options import TargetChoice
from targets.boards import board_names

__all__ = ["Target", "TargetKind", "parse_target", "target_of"]


class TargetKind(enum.Enum):
    """What it is that stands there."""

    MODEL = "a model"
    BOARD = "an emulated board"
    SERIAL = "a serial port"
    LISTEN = "a client that comes"
    EXEC = "a client that is started"
    CAPTURE = "a recording"


@dataclass(frozen=True, slots=True, kw_only=True)
class Target:
    """A TARGET that was understood; whether what it names is there, whoever opens it finds out.

    Attributes:
        kind: what it is.
        text: all of it, as it was written.
        name: what stands before the first colon: model or board, ``serial``, ``listen`` ...
        rest: what stands behind it: profile, image, port, door, command, file; empty where there is nothing.
    """

    kind: TargetKind
    text: str
    name: str
    rest: str = ""


_KINDS = {"listen": TargetKind.LISTEN, "exec": TargetKind.EXEC, "capture": TargetKind.CAPTURE}


def parse_target(text: str, where: str) -> Target:
    """Return what a TARGET means.

    Args:
        text: the TARGET.
        where: who names it, for the error.

    Raises:
        UsageError: it is none, or says too little.
    """
    name, colon, rest = text.partition(":")
    if colon and name in _KINDS:
        _check_words(name, rest, where)
        return Target(kind=_KINDS[name], text=text, name=name, rest=rest)
    if is_serial_target(text):
        parse_serial_target(text)
        return Target(kind=TargetKind.SERIAL, text=text, name=name, rest=rest)
    if name in _models():
        return Target(kind=TargetKind.MODEL, text=text, name=name, rest=rest)
    if colon and (name in board_names() or is_board_file(name)):
        if not rest:
            raise UsageError("names no image", where=where, hint=f"write {name}:IMAGE (ELF, Intel HEX or raw binary)")
        return Target(kind=TargetKind.BOARD, text=text, name=name, rest=rest)
    if text.startswith("/"):
        raise UsageError("not a target", where=where, hint=f"write serial:{text}")
    forms = [*_models(), *(f"{board}:IMAGE" for board in board_names()), "serial:PORT@BAUD", "socket://HOST:PORT"]
    forms += ["listen:pty:PATH", "listen:tcp:PORT", "exec:COMMAND", "capture:FILE"]
    known = dict.fromkeys(form.partition(":")[0] for form in forms) if colon else forms
    hint = did_you_mean(name, known, "a target begins with one of" if colon else "a target is one of")
    raise UsageError("not a target", where=where, hint=hint)


def target_of(choice: TargetChoice) -> Target:
    """Return what a ``--target`` means; see `parse_target`."""
    return parse_target(choice.spec, choice.where)


def _models() -> list[str]:
    return [kind.target for _, kind in PLUGINS.systems.models().values() if kind.target]


def _check_words(name: str, rest: str, where: str) -> None:
    if name == "capture" and not rest:
        raise UsageError("names no recording", where=where, hint="write capture:FILE")
    if name == "listen":
        door, _, place = rest.partition(":")
        if door not in {"pty", "tcp"} or not place:
            raise UsageError("not an endpoint", where=where, hint="write listen:pty:PATH or listen:tcp:[HOST:]PORT")
    if name == "exec":
        try:
            shlex.split(rest)
        except ValueError as error:
            raise UsageError(f"cannot be split into words: {error}", where=where) from None
        if "{pty}" not in rest and "{port}" not in rest:
            raise UsageError("does not say where to connect", where=where, hint="put {pty} or {port} into it")
