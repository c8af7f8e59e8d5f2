"""An absolute encoder of a wheel: three wires carry the number of the 45 degree sector in which the wheel stands.

The plug-in of the original simulation (bachelor-thesis, listing of the encoder plug-in) computes
``trunc(fmod(angle, 2 pi) / (pi / 4)) % 8`` and stm32-qemu vl.c takes the low three bits. For angles below zero that
counts -1 as 7 one sector late: sector 0 is 90 degrees wide around zero, and all others are shifted by one. The form
"truncating" does the same; "floor" is what an encoder on a shaft does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Literal

from targets.parts.part import Direction, Part, Ports, Quantity, Terminal
from targets.parts.settings import check_settings, setting
from targets.parts.words import LSB_FIRST, BitOrder, bits_of

__all__ = ["SECTOR_RAD", "Encoder3Bit", "EncoderMoved", "EncoderSettings", "sector_word"]

SECTOR_RAD = math.pi / 4
"""Width of a sector: 45 degrees."""

_MOST_SECTORS = 64
"""More than so many sectors in one physics step is no rotation but a wheel that was put elsewhere (choice)."""

Form = Literal["floor", "truncating"]


@dataclass(frozen=True, slots=True, kw_only=True)
class EncoderSettings:
    """How the angle becomes a number, and the number levels.

    Raises:
        ValueError: a value is none of its choices.
    """

    form: Literal["floor", "truncating"] = setting(
        "floor", "", "choice; truncating: bachelor-thesis, encoder plug-in, with stm32-qemu vl.c"
    )
    bit_order: Literal["lsb-first", "msb-first"] = setting(
        LSB_FIRST, "", "bachelor-thesis, Fig. 22: s1 is bit 0; msb-first: pioneer_2DX-Interface bluepill_comm.cpp"
    )

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class EncoderMoved:
    """The number on the wires has changed at `at_ns`."""

    word: int
    at_ns: int


def sector_word(angle_rad: float, form: Form) -> int:
    """The number 0..7 of the sector at an angle in rad."""
    return _word_of(_interval_of(angle_rad, form), form)


class Encoder3Bit(Part):
    """See the head of this file. Within a physics step the wheel is taken to turn evenly."""

    TERMINALS = tuple(Terminal(name=name, direction=Direction.OUT) for name in ("s1", "s2", "s3"))
    QUANTITIES = (Quantity(name="angle", direction=Direction.IN, unit="rad", text="of the wheel, not wrapped"),)
    Settings = EncoderSettings

    def __init__(self, settings: EncoderSettings, ports: Ports, *, seed: int) -> None:  # noqa: ARG002
        self._form: Form = settings.form
        self._order: BitOrder = settings.bit_order
        self._outputs = tuple(ports.output(terminal.name) for terminal in self.TERMINALS)
        self._tell = ports.tell
        self._word = 0
        self._interval: int | None = None

    def power_on(self, now_ns: int) -> None:
        """Begin at sector 0, until the first angle is known."""
        self._word, self._interval = 0, None
        for output in self._outputs:
            output.set(False, now_ns)

    def after_step(self, from_ns: int, to_ns: int, before: Mapping[str, float], after: Mapping[str, float]) -> None:
        """Put every boundary that was crossed on the wires at its exact time."""
        start_rad, end_rad = before.get("angle", math.nan), after.get("angle", math.nan)
        if not (math.isfinite(start_rad) and math.isfinite(end_rad)):
            return
        start = _interval_of(start_rad, self._form)
        if start != self._interval:
            self._show(start, from_ns)
        end = _interval_of(end_rad, self._form)
        if abs(end - start) > _MOST_SECTORS:
            self._show(end, to_ns)
            return
        for interval, boundary_rad in _crossings(start, end):
            part = min(1.0, max(0.0, (boundary_rad - start_rad) / (end_rad - start_rad)))
            self._show(interval, from_ns + math.ceil((to_ns - from_ns) * part))

    def _show(self, interval: int, at_ns: int) -> None:
        self._interval = interval
        word = _word_of(interval, self._form)
        changed = word ^ self._word
        if not changed:
            return
        self._word = word
        for output, level, touched in zip(
            self._outputs, bits_of(word, self._order), bits_of(changed, self._order), strict=True
        ):
            if touched:
                output.set(level, at_ns)
        self._tell(EncoderMoved(word=word, at_ns=at_ns))


def _interval_of(angle_rad: float, form: Form) -> int:
    """Interval n is n to n + 1 sectors, with its lower boundary; below zero, truncated, with its upper one instead."""
    sectors = angle_rad / SECTOR_RAD
    return math.ceil(sectors) - 1 if form == "truncating" and sectors < 0 else math.floor(sectors)


def _word_of(interval: int, form: Form) -> int:
    return (interval + 1 if form == "truncating" and interval < 0 else interval) & 7


def _crossings(start: int, end: int) -> Iterator[tuple[int, float]]:
    """The intervals that are entered on the way, and the angle in rad at which each is."""
    if end >= start:
        return ((interval, interval * SECTOR_RAD) for interval in range(start + 1, end + 1))
    return ((interval, (interval + 1) * SECTOR_RAD) for interval in range(start - 1, end - 1, -1))
