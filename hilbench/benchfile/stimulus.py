r"""A stimulus: what is done to an emulated board from outside, in one line of text.

It is the same on a command line, in a bench file, in a test, and in what ``hilbench run --write-stimuli`` writes:

    [TIME:][BOARD.]TARGET=VALUE

======================  ==========================================================================================
``PC13=0``, ``=1``      a pin is driven low, or high
``PC13=z``              what drove it lets go
``PA0=1.65V``           a voltage at a pin
``PA0=0V..3.3V/1s``     a ramp, whose last voltage stays
``PA0=1kHz/25%/2s``     a square wave that begins high; half of its period and without an end, if nothing else is said
``USER=press``          a button of the board is pushed, by its name; ``release`` lets go
``reset=press``         the button of the reset
``usart2=AT\r\n``         bytes on a serial line; ``\r \n \t \0 \\ \xNN``, ``hex:0d0a`` or ``@FILE``
``i2c1=stuck``          something holds SDA low; ``free`` lets go
======================  ==========================================================================================

``/50ms`` behind a level, a voltage, ``press`` or ``stuck`` ends it after that time. TIME is bench time since power-on:
``1s``, ``250ms``, ``1.5us``; ``1s+100ms`` repeats it each 100 ms for ever, ``1s+100ms*5`` five times in all. Without
TIME it happens at power-on.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.files.names import file_name
from hilbench.nearest import did_you_mean
from hilbench.terminal.arguments import duration_ns

if TYPE_CHECKING:
    from hilbench.benchfile.bench_file import EmulatedBoard
    from targets.boards import Board

__all__ = ["Action", "Hold", "Ramp", "Reset", "Send", "Square", "Stick", "Stimulus", "parse_stimulus"]

HIGHEST_VOLTS = 5.5
"""No pin of these chips takes more, whatever its kind (DS5319 table 7: VDD + 4.0 V at most, with VDD from 2 V)."""
FASTEST_HZ = 10_000_000
"""Of a square wave: each edge is an event of its own (choice)."""
MOST_BYTES = 64_000_000
"""Of a file that is sent, so that a device without an end is none (choice)."""

_LINE = re.compile(r"(?:(?P<time>[^:=]*):)?(?P<target>[^:=]+)=(?P<value>.*)", re.DOTALL)
_TIME = re.compile(r"(?P<at>[^+*]+)(\+(?P<every>[^+*]+)(\*(?P<times>[1-9]\d{0,8}))?)?", re.ASCII)
_ZERO = re.compile(r"0(\.0*)?(us|ms|s|min|h)", re.ASCII)
_NUMBER = r"\d{1,20}(?:\.\d{1,20})?"
_VOLTS = re.compile(rf"({_NUMBER})V", re.ASCII)
_RAMP = re.compile(rf"({_NUMBER})V\.\.({_NUMBER})V", re.ASCII)
_WAVE = re.compile(rf"({_NUMBER})(m|k|M)?Hz", re.ASCII)
_DUTY = re.compile(rf"({_NUMBER})%", re.ASCII)
_SCALES = {"m": Fraction(1, 1000), None: Fraction(1), "k": Fraction(1000), "M": Fraction(1_000_000)}
_SERIAL = re.compile(r"(lp)?us?art\d+", re.IGNORECASE | re.ASCII)
_BUS = re.compile(r"i2c\d+", re.IGNORECASE | re.ASCII)
_ESCAPE = re.compile(r"\\(x[0-9A-Fa-f]{2}|.|$)", re.DOTALL)
_ESCAPES = {"n": b"\n", "r": b"\r", "t": b"\t", "0": b"\0", "\\": b"\\"}


@dataclass(frozen=True, slots=True, kw_only=True)
class Hold:
    """A pin is held.

    Attributes:
        value: a level, or volts; None lets go.
        for_ns: after so long it is let go, in ns; 0 for never.
    """

    value: bool | float | None
    for_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Ramp:
    """The voltage at a pin goes evenly from one to another, and stays there.

    Attributes:
        from_volts: the first,
        to_volts: and the last voltage.
        in_ns: how long it takes, in ns.
    """

    from_volts: float
    to_volts: float
    in_ns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class Square:
    """A pin gets a square wave that begins high.

    Attributes:
        hz: periods in a second.
        duty: the part of a period for which it is high, above 0 and below 1.
        for_ns: after so long the pin is let go, in ns; 0 for never.
    """

    hz: Fraction
    duty: Fraction = Fraction(1, 2)
    for_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Send:
    """Bytes come over a serial line.

    Attributes:
        data: the bytes.
        file: where they were read; None where they stood in the line.
    """

    data: bytes
    file: Path | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class Stick:
    """SDA of an I2C bus is held low, or let go.

    Attributes:
        stuck: whether it is held.
        for_ns: after so long it is let go, in ns; 0 for never.
    """

    stuck: bool
    for_ns: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Reset:
    """The reset button is pushed."""


Action = Hold | Ramp | Square | Send | Stick | Reset


@dataclass(frozen=True, slots=True, kw_only=True)
class Stimulus:
    """What is done to a board at a moment.

    Attributes:
        text: as it was written, without its time.
        board: name of the board in its bench.
        target: a port pin (``PC13``), a serial line (``usart1``), a bus (``i2c1``), or ``reset``.
        action: what is done.
        at_ns: when, in ns of bench time since power-on, or since it was asked for.
        every_ns: the time from one to the next, in ns; 0 for once.
        times: how often in all; 0 for ever.
    """

    text: str
    board: str
    target: str
    action: Action
    at_ns: int = 0
    every_ns: int = 0
    times: int = 1


def parse_stimulus(text: str, boards: Mapping[str, EmulatedBoard], folder: Path) -> Stimulus:
    """Read a stimulus; see the module.

    Args:
        text: the line.
        boards: those of the bench, by name.
        folder: what the name of a file is relative to.

    Raises:
        ValueError: it is none, or it is for a board, pin, button or file that is not there; with what to do.
    """
    match = _LINE.fullmatch(text)
    if match is None:
        raise ValueError(f"'{text}' is no stimulus; write [TIME:]TARGET=VALUE, such as 1s:PC13=0 or usart1=hello")
    at_ns, every_ns, times = _times(match["time"])
    board, name = _board(match["target"], boards)
    target, action = _target_and_action(boards[board].board, name, match["value"], folder)
    words = f"{match['target']}={match['value']}"
    return Stimulus(
        text=words, board=board, target=target, action=action, at_ns=at_ns, every_ns=every_ns, times=times
    )  # fmt: skip


# --- when, and where


def _times(text: str | None) -> tuple[int, int, int]:
    if text is None:
        return 0, 0, 1
    match = _TIME.fullmatch(text)
    if match is None:
        raise ValueError(f"'{text}' is no time; write 1s, or 1s+100ms*5 for five times")
    at_ns = 0 if _ZERO.fullmatch(match["at"]) else duration_ns(match["at"])
    if match["every"] is None:
        return at_ns, 0, 1
    return at_ns, duration_ns(match["every"]), int(match["times"] or 0)


def _board(target: str, boards: Mapping[str, EmulatedBoard]) -> tuple[str, str]:
    board, dot, name = target.rpartition(".")
    if not dot and len(boards) == 1:
        return next(iter(boards)), name
    if not boards:
        raise ValueError(f"'{target}': there is no emulated board here that could get a stimulus")
    if board not in boards:
        first = next(iter(boards))
        if dot:
            raise ValueError(f"there is no board '{board}'; {did_you_mean(board, boards, 'boards')}")
        raise ValueError(f"'{target}' does not say of which board; write {first}.{target}")
    return board, name


def _target_and_action(board: Board, name: str, value: str, folder: Path) -> tuple[str, Action]:
    if name.lower() == "reset":
        _require(value == "press", name, value, "press")
        return "reset", Reset()
    if _SERIAL.fullmatch(name):
        return _line_of(board, name), _send(value, folder)
    if _BUS.fullmatch(name):
        words, for_ns = _limited(value)
        _require(words in {"stuck", "free"}, name, value, "stuck, stuck/10ms or free")
        return name.lower(), Stick(stuck=words == "stuck", for_ns=for_ns)
    if value.partition("/")[0] in {"press", "release"}:
        words, for_ns = _limited(value)
        return _button(board, name, pushed=words == "press", for_ns=for_ns)
    return _pin(board, name), _at_pin(name, value)


def _require(holds: bool, name: str, value: str, forms: str) -> None:
    if not holds:
        raise ValueError(f"'{value}' says nothing to {name}; write {forms}")


def _line_of(board: Board, name: str) -> str:
    known = [usart.lower() for usart in board.variant.usarts]
    if name.lower() not in known:
        raise ValueError(f"the {board.chip} has no '{name}'; {did_you_mean(name.lower(), known, 'serial lines')}")
    return name.lower()


def _pin(board: Board, name: str) -> str:
    pin = board.port_pin(name)
    if pin is None:
        buttons = [button.name for button in board.buttons]
        if name in buttons:
            raise ValueError(f"'{name}' is a button; write {name}=press, {name}=press/50ms or {name}=release")
        known = [*sorted(board.variant.pins), *board.pins]
        raise ValueError(f"the board has no pin '{name}'; {did_you_mean(name.upper(), known, 'pins')}")
    return pin


def _button(board: Board, name: str, *, pushed: bool, for_ns: int) -> tuple[str, Action]:
    for button in board.buttons:
        if button.name == name:
            return button.pin, Hold(value=(button.active == "high") if pushed else None, for_ns=for_ns)
    known = [button.name for button in board.buttons]
    hint = did_you_mean(name, known, "buttons") if known else f"it has none; write a level: {name}=0"
    raise ValueError(f"the board has no button '{name}'; {hint}")


# --- what


def _limited(value: str) -> tuple[str, int]:
    """Split ``WORDS[/DURATION]``."""
    words, slash, span = value.partition("/")
    return words, duration_ns(span) if slash else 0


def _at_pin(name: str, value: str) -> Action:
    if match := _RAMP.fullmatch(value.partition("/")[0]):
        span = value.partition("/")[2]
        if not span:
            raise ValueError(f"'{value}' does not say how long the ramp takes; write {value}/1s")
        return Ramp(from_volts=_volts(match[1]), to_volts=_volts(match[2]), in_ns=duration_ns(span))
    if match := _WAVE.fullmatch(value.partition("/")[0]):
        return _square(value, Fraction(match[1]) * _SCALES[match[2]])
    words, for_ns = _limited(value)
    if words in {"0", "1", "z"}:
        return Hold(value={"0": False, "1": True, "z": None}[words], for_ns=for_ns)
    if match := _VOLTS.fullmatch(words):
        return Hold(value=_volts(match[1]), for_ns=for_ns)
    forms = "0, 1, z, 1.65V, 0V..3.3V/1s or 1kHz, and /50ms behind it for a time"
    raise ValueError(f"'{value}' is nothing that a pin can get ({name}); write {forms}")


def _volts(text: str) -> float:
    volts = float(text)
    if volts > HIGHEST_VOLTS:
        raise ValueError(f"{text} V is more than any pin bears; write 0 to {HIGHEST_VOLTS} V")
    return volts


def _square(value: str, hz: Fraction) -> Square:
    if not 0 < hz <= FASTEST_HZ:
        raise ValueError(f"'{value}': a square wave has more than 0 Hz, and {FASTEST_HZ // 1_000_000} MHz at most")
    duty, for_ns = None, 0
    for part in value.split("/")[1:]:
        match = _DUTY.fullmatch(part)
        if (match and duty is not None) or (not match and for_ns):
            twice = "which part of a period is high" if match else "for how long"
            raise ValueError(f"'{value}' says twice {twice}; say it once")
        if match:
            duty = Fraction(match[1]) / 100
        else:
            for_ns = duration_ns(part)
    duty = Fraction(1, 2) if duty is None else duty
    if not 0 < duty < 1:
        raise ValueError(f"'{value}': the part of a period that is high is above 0 % and below 100 %")
    return Square(hz=hz, duty=duty, for_ns=for_ns)


def _send(value: str, folder: Path) -> Send:
    if value.startswith("@"):
        file = folder / file_name(value[1:])
        try:
            with file.open("rb") as opened:
                data = opened.read(MOST_BYTES + 1)
        except (OSError, ValueError) as error:
            raise ValueError(f"{file} cannot be read: {getattr(error, 'strerror', None) or error}") from None
        if len(data) > MOST_BYTES:
            raise ValueError(f"{file} has more than the {MOST_BYTES // 1_000_000} MB that can be sent")
        return Send(data=data, file=file)
    if value.startswith("hex:"):
        try:
            return Send(data=bytes.fromhex(value[4:]))
        except ValueError:
            raise ValueError(f"'{value[4:]}' is no hexadecimal; write two digits a byte: hex:0d0a") from None
    try:
        return Send(data=_unescaped(value))
    except UnicodeEncodeError:
        raise ValueError("the text has bytes that are no UTF-8; write them as \\xNN or hex:") from None


def _unescaped(text: str) -> bytes:
    data, end = bytearray(), 0
    for match in _ESCAPE.finditer(text):
        data += text[end : match.start()].encode()
        end = match.end()
        letter = match[1]
        if letter[:1] == "x" and len(letter) == 3:
            data.append(int(letter[1:], 16))
        elif letter in _ESCAPES:
            data += _ESCAPES[letter]
        else:
            raise ValueError(f"'\\{letter}' is no escape; there are \\n \\r \\t \\0 \\xNN and \\\\")
    return bytes(data + text[end:].encode())
