"""Reads the values of options: one small function for each form a value can have.

They raise `ValueError` with what is wrong; whoever calls them knows which option it was.
"""

from __future__ import annotations

import math
import os
import re
import shlex
from fractions import Fraction
from pathlib import Path

from hilbench.terminal.options import PtyDoor, Rfc2217Door, TargetChoice, TcpDoor

_NAME = re.compile(r"(?P<name>[A-Za-z_][\w.-]*)=(?P<rest>.*)", re.DOTALL)
_DURATION = re.compile(r"(?P<number>\d+(\.\d+)?)(?P<unit>us|ms|s|min|h)", re.ASCII)
_SIZE = re.compile(r"(?P<number>\d+(\.\d+)?)(?P<unit>kB|MB|GB)", re.ASCII)
_UNITS_BYTES = {"kB": 10**3, "MB": 10**6, "GB": 10**9}
_SMALLEST_JOURNAL = 100_000
_UNITS_NS = {"us": 10**3, "ms": 10**6, "s": 10**9, "min": 60 * 10**9, "h": 3600 * 10**9}
_HIGHEST_PORT = 65_535
_HIGHEST_DOMAIN = 232
_HIGHEST_SEED = 2**63 - 1
_SLOWEST_BAUD, _FASTEST_BAUD = 300, 4_000_000
_LONGEST_WAIT = 1000
_MOST = 1000
_MOST_JOBS = 256


def target_choice(text: str) -> TargetChoice:
    """Read ``[NAME=]T``."""
    name, spec = _named(text)
    if not spec:
        raise ValueError(f"'{text}' names no target")
    return TargetChoice(name=name, spec=spec)


def pty_door(text: str) -> PtyDoor:
    """Read ``[LINK=]PATH``."""
    link, path = _named(text)
    if not path:
        raise ValueError(f"'{text}' names no path")
    return PtyDoor(link=link, path=Path(path))


def tcp_door(text: str) -> TcpDoor:
    """Read ``[LINK=][HOST:]PORT``; an IPv6 address stands in brackets."""
    link, address = _named(text)
    host, _, port = address.rpartition(":")
    if not port.isascii() or not port.isdigit() or int(port) > _HIGHEST_PORT:
        raise ValueError(f"'{address}' does not end in a port from 0 to {_HIGHEST_PORT}")
    return TcpDoor(link=link, host=host.strip("[]") or "127.0.0.1", port=int(port))


def rfc2217_door(text: str) -> Rfc2217Door:
    """Read ``[LINK=][HOST:]PORT``, as `tcp_door`."""
    door = tcp_door(text)
    return Rfc2217Door(link=door.link, host=door.host, port=door.port)


def output_file(text: str) -> Path:
    """Read the name of a file to write."""
    if text in {"", "-"}:
        raise ValueError(f"'{text}' is not a file")
    return Path(text)


def folder(text: str) -> Path:
    """Read the path of a folder that is there."""
    if not Path(text).is_dir():
        raise ValueError(f"'{text}' is no folder")
    return Path(text)


def named_file(text: str) -> tuple[str, Path]:
    """Read a name and a file to write: ``NAME=FILE``."""
    name, equals, file = text.partition("=")
    if not name or not equals:
        raise ValueError(f"'{text}' is not NAME=FILE")
    return name, output_file(file)


def command(text: str) -> tuple[str, ...]:
    """Read the words of a command, as a shell would."""
    words = tuple(shlex.split(text))
    if not words:
        raise ValueError(f"'{text}' is no command")
    return words


def seed(text: str) -> int:
    """Read a seed: a whole number, 0 to 2**63 - 1."""
    return _whole_number(text, 0, _HIGHEST_SEED)


def dds_domain(text: str) -> int:
    """Read the number of a DDS domain: 0 to 232, of which there are ports (OMG DDSI-RTPS 2.5, 9.6.2)."""
    return _whole_number(text, 0, _HIGHEST_DOMAIN)


def jobs(text: str) -> int:
    """Read how many processes: a whole number, 1 to 256, or ``auto`` for as many as there are processors for us."""
    return len(os.sched_getaffinity(0)) if text == "auto" else _whole_number(text, 1, _MOST_JOBS)


def count(text: str) -> int:
    """Read how often or how many: a whole number, 1 to 1000."""
    return _whole_number(text, 1, _MOST)


def baud(text: str) -> int:
    """Read the speed of a line in bit/s, 300 to 4000000."""
    return _whole_number(text, _SLOWEST_BAUD, _FASTEST_BAUD)


def duration_ns(text: str) -> int:
    """Read a span of bench time, such as ``10s``, ``500ms``, ``2min``; return it in nanoseconds."""
    if text.startswith("-") and _DURATION.fullmatch(text[1:]):
        raise ValueError(f"'{text}' is negative; a duration is positive: 10s, 500ms or 2min")
    match = _DURATION.fullmatch(text)
    if match is None:
        raise ValueError(f"'{text}' is not a duration; write 10s, 500ms or 2min")
    span_ns = round(Fraction(match["number"]) * _UNITS_NS[match["unit"]])
    if not span_ns:
        raise ValueError(f"'{text}' is not longer than zero")
    return span_ns


def journal_bytes(text: str) -> int:
    """Read how large a journal may get, such as ``50MB``; return it in bytes."""
    match = _SIZE.fullmatch(text)
    if match is None:
        raise ValueError(f"'{text}' is not a size; write 500kB, 50MB or 2GB")
    size = round(Fraction(match["number"]) * _UNITS_BYTES[match["unit"]])
    if size < _SMALLEST_JOURNAL:
        raise ValueError(f"'{text}' is less than {_SMALLEST_JOURNAL // 1000} kB")
    return size


def timeout_scale(text: str) -> float:
    """Read a factor of 1 to 1000."""
    try:
        factor = float(text)
    except ValueError:
        factor = math.nan
    if not 1 <= factor <= _LONGEST_WAIT:
        raise ValueError(f"'{text}' is not a factor of 1 to {_LONGEST_WAIT}")
    return factor


def _named(text: str) -> tuple[str, str]:
    match = _NAME.fullmatch(text)
    return (match["name"], match["rest"]) if match else ("", text)


def _whole_number(text: str, low: int, high: int) -> int:
    digits = text.removeprefix("-")
    if not digits.isascii() or not digits.isdigit():
        raise ValueError(f"'{text}' is not a whole number")
    if not low <= int(text) <= high:
        raise ValueError(f"{text} is not between {low} and {high}")
    return int(text)
