"""Waveforms for GTKWave and PulseView: a value change dump (IEEE 1364-2005, section 18) of pins, nets and lines.

Time unit is the nanosecond of bench time. Pins are under ``BOARD.pins``, lines under ``BOARD.usart1`` with ``tx`` and
``rx`` as the levels on the wire (so that a UART decoder reads them), I2C buses under ``BOARD.i2c1`` with ``scl`` and
``sda``, nets under ``nets``. A pin that floats is ``z``.
"""

from __future__ import annotations

import contextlib
import heapq
import itertools
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from hilbench.clock import NS_PER_S
from hilbench.errors import UnavailableError
from targets.mcu.pins import Edge
from targets.mcu.serial_line import SerialFrame

if TYPE_CHECKING:
    from vcd.writer import Variable

__all__ = ["Waveforms"]

_LEVELS = {True: "1", False: "0", None: "z"}


class Waveforms:
    """Writes one file. Everything must be declared before the first change is written.

    Args:
        path: the file; an older one is overwritten.

    Attributes:
        late: each returns a bench time from which on changes may still come that belong there, or None.

    Raises:
        UnavailableError: it cannot be written.
    """

    def __init__(self, path: Path) -> None:
        from vcd import VCDWriter

        try:
            self._file = path.open("w", encoding="utf-8", errors="backslashreplace")
        except OSError as error:
            raise _cannot_write(path, error) from error
        self._path = path
        self._writer = VCDWriter(self._file, timescale="1 ns", comment="hilbench; times are bench time")
        self._changes: list[tuple[int, int, Variable[str], str]] = []
        self._sequence = itertools.count()
        self._variables: dict[tuple[str, str], Variable[str]] = {}
        self._nets: dict[tuple[str, str], Variable[str]] = {}
        self._written_ns = 0
        self.late: list[Callable[[], int | None]] = []

    def declare(self, scope: str, names: Iterable[str], initial: bool | None) -> None:
        """Declare signals of one bit, with the level they begin with."""
        for name in names:
            self._variables[scope, name] = self._writer.register_var(scope, name, "wire", size=1, init=_LEVELS[initial])

    def declare_net(self, net: str, scope: str, name: str, initial: bool | None) -> None:
        """Declare a net that shows the level of a signal that was declared."""
        self._nets[scope, name] = self._writer.register_var(
            "nets", net.replace(".", "_"), "wire", size=1, init=_LEVELS[initial]
        )

    def edges(self, scope: str, name: str, edges: Iterable[Edge]) -> None:
        """Take edges of a pin, now or ahead of bench time."""
        for edge in edges:
            self._change(scope, name, edge.ns, _LEVELS[edge.level])

    def frame(self, scope: str, name: str, frame: SerialFrame) -> None:
        """Take a frame on a line."""
        for time_s, level in frame.edges():
            self._change(scope, name, time_s.numerator * NS_PER_S // time_s.denominator, _LEVELS[level])

    def level(self, scope: str, name: str, ns: int, level: bool) -> None:
        """Take a level that a signal has from `ns` on."""
        self._change(scope, name, ns, _LEVELS[level])

    def write_to(self, reached_ns: int) -> None:
        """Write what has happened up to and including `reached_ns`, and nothing behind what may come late.

        Raises:
            UnavailableError: the file cannot be written.
        """
        late_ns = [ns - 1 for late in self.late if (ns := late()) is not None]
        self._write(min([reached_ns, *late_ns]))

    def _write(self, reached_ns: int) -> None:
        try:
            while self._changes and self._changes[0][0] <= reached_ns:
                ns, _, variable, level = heapq.heappop(self._changes)
                self._written_ns = max(self._written_ns, ns)
                self._writer.change(variable, self._written_ns, level)
        except OSError as error:
            self._give_up()
            raise _cannot_write(self._path, error) from error

    def _give_up(self) -> None:
        """Close the file as it is: one that is left open says its own word on the way out, from CPython 3.13 on."""
        with contextlib.suppress(OSError):
            self._file.close()

    def close(self, at_ns: int) -> None:
        """Write what is left, with the end at `at_ns`.

        Raises:
            UnavailableError: the file cannot be written.
        """
        self._write(at_ns)
        try:
            self._writer.close(max(at_ns, self._written_ns))
            self._file.close()
        except OSError as error:
            self._give_up()
            raise _cannot_write(self._path, error) from error

    def _change(self, scope: str, name: str, ns: int, level: str) -> None:
        for variables in (self._variables, self._nets):
            variable = variables.get((scope, name))
            if variable is not None:
                heapq.heappush(self._changes, (ns, next(self._sequence), variable, level))


def _cannot_write(path: Path, error: OSError) -> UnavailableError:
    reason = error.strerror or str(error)
    return UnavailableError(f"the waveforms cannot be written: {reason}", where=str(path), hint="choose another file")
