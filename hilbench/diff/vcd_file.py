"""Reads a value change dump (IEEE 1364-2005, section 18) as a capture: our own, or that of a logic analyser.

Variables of one bit are signals. Of our own files the names are those of the journal: ``brain.pins.PB7`` is
``brain.PB7``, and ``nets``, which show the same levels again, are left out.
"""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, cast

from hilbench.clock import NS_PER_S
from hilbench.diff.capture import END_NS, Capture, Track
from hilbench.errors import UnavailableError

if TYPE_CHECKING:
    from vcd.common import Timescale
    from vcd.reader import HasReadinto, ScalarChange, ScopeDecl, Token, VarDecl, VectorChange

__all__ = ["read_vcd"]

_LEVELS = {"0": False, "1": True, "l": False, "h": True}
_PER_SECOND = {"s": 1, "ms": 10**3, "us": 10**6, "ns": 10**9, "ps": 10**12, "fs": 10**15}


@dataclass(slots=True)
class _Wire:
    """A variable while the file is read."""

    known: bool = False
    initial: bool | None = None
    level: bool | None = None
    times_ns: list[int] = field(default_factory=list)
    values: list[bool | None] = field(default_factory=list)

    def take(self, ns: int, level: bool | None) -> None:
        if not self.known:
            self.known, self.initial = True, level
        elif level is not self.level:
            self.times_ns.append(ns)
            self.values.append(level)
        self.level = level


def read_vcd(path: Path) -> Capture:
    """Read a file; one that was cut up to its last whole line.

    Raises:
        UnavailableError: it cannot be read, or is no value change dump.
    """
    from vcd.reader import VCDParseError

    reader = _Reader()
    try:
        data = path.read_bytes()
        end = data.rfind(b"\n") + 1 or len(data)
        reader.read(io.BytesIO(data[:end]))
    except OSError as error:
        raise UnavailableError(f"cannot be read: {error.strerror or error}", where=str(path)) from error
    except (VCDParseError, ValueError) as error:
        raise UnavailableError(f"is no value change dump: {error}", where=str(path)) from error
    tracks = {track.name: track for track in reader.tracks()}
    if not tracks:
        raise UnavailableError("is a value change dump without a variable of one bit", where=str(path))
    wires = reader.wires.values()
    return Capture(
        label=str(path),
        kind="waveforms",
        tracks=tracks,
        end_ns=reader.ns,
        floats=any(None in wire.values or (wire.known and wire.initial is None) for wire in wires),
        remarks=("its last line has no end and is left out",) if data[end:].strip() else (),
    )


class _Reader:
    """Takes the tokens of a file."""

    def __init__(self) -> None:
        self.ns = 0
        self.wires: dict[str, _Wire] = {}
        self._names: dict[str, str] = {}
        self._scopes: list[str] = []
        self._tick_ns = Fraction(1)

    def read(self, file: object) -> None:
        """Take all of them."""
        from vcd.reader import TokenKind, tokenize

        actions = {
            TokenKind.SCOPE: lambda data: self._scopes.append(cast("ScopeDecl", data).ident),
            TokenKind.UPSCOPE: lambda _data: self._leave_scope(),
            TokenKind.TIMESCALE: self._timescale,
            TokenKind.VAR: self._declare,
            TokenKind.CHANGE_TIME: self._time,
            TokenKind.CHANGE_SCALAR: self._change,
            TokenKind.CHANGE_VECTOR: self._change,
        }
        for token in _all(tokenize(cast("HasReadinto", file))):
            action = actions.get(token.kind)
            if action is not None:
                action(token.data)

    def tracks(self) -> Iterator[Track]:
        """Return the signals."""
        own = {name.partition(".")[0] for name in self._names if name.split(".")[1:2] == ["pins"]}
        for name, code in self._names.items():
            scope, _, rest = name.partition(".")
            if own and scope == "nets":
                continue
            wire = self.wires[code]
            yield Track(
                name=f"{scope}.{rest.removeprefix('pins.')}" if scope in own else name,
                times_ns=wire.times_ns,
                values=wire.values,
                initial=wire.initial,
                initial_known=wire.known,
            )

    def _leave_scope(self) -> None:
        if not self._scopes:
            raise ValueError("a scope ends that has not begun")
        self._scopes.pop()

    def _timescale(self, data: object) -> None:
        scale = cast("Timescale", data)
        self._tick_ns = Fraction(scale.magnitude * NS_PER_S, _PER_SECOND[scale.unit.value])

    def _declare(self, data: object) -> None:
        variable = cast("VarDecl", data)
        if variable.size == 1 and variable.type_.value not in {"real", "realtime", "string"}:
            self._names[".".join([*self._scopes, variable.ref_str])] = variable.id_code
            self.wires.setdefault(variable.id_code, _Wire())

    def _time(self, data: object) -> None:
        ns = round(cast("int", data) * self._tick_ns)
        if ns < self.ns:
            raise ValueError(f"its time goes back to {ns} ns")
        if ns >= END_NS:
            raise ValueError("its time ends more than a century away")
        self.ns = ns

    def _change(self, data: object) -> None:
        change = cast("ScalarChange | VectorChange", data)
        wire = self.wires.get(change.id_code)
        if wire is not None:
            wire.take(self.ns, _LEVELS.get(str(change.value).lower()))


def _all(tokens: Iterator[Token]) -> Iterator[Token]:
    """Pass the tokens on; whatever else the reader stumbles over makes the file unreadable."""
    try:
        yield from tokens
    except (AssertionError, KeyError, IndexError, UnicodeDecodeError) as error:
        raise ValueError(f"{type(error).__name__} {error}") from error
