"""A wheel motor that is told its speed on three wires: a code -4..3, two's complement, times a speed per code.

comm3 is the most significant bit (bachelor-thesis, Fig. 22). The original reads the wires every 100 ms and publishes
what they say (stm32-qemu vl.c); it reads the output data register of the port, whatever the direction of its pins.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

from targets.parts.part import Direction, Part, Ports, Quantity, Terminal
from targets.parts.settings import check_settings, setting
from targets.parts.words import LSB_FIRST, BitOrder, signed, word_of

__all__ = ["MotorCode", "MotorCodeSettings", "MotorWord"]

_MS = 1_000_000


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorCodeSettings:
    """How the wires are read, and what a code means.

    Raises:
        ValueError: a value makes no motor.
    """

    period_ms: float = setting(100.0, "ms", "stm32-qemu vl.c, publishers; 0: at once, mean of each step", least=0.0)
    speed_per_code_m_s: float = setting(
        0.0625, "m/s at the rim", "pioneer_2DX-Interface bluepill_comm.cpp: 1000 mm/s over 16 codes, of two wheels"
    )
    reads: Literal["pins", "odr"] = setting(
        "pins", "", "choice; odr: stm32-qemu vl.c reads the output latch whatever the pin's direction"
    )
    bit_order: Literal["lsb-first", "msb-first"] = setting(
        LSB_FIRST, "", "bachelor-thesis, Fig. 22: comm1 is bit 0; msb-first: bachelor-thesis, Listing 5.5"
    )

    def __post_init__(self) -> None:
        check_settings(self)


@dataclass(frozen=True, slots=True, kw_only=True)
class MotorWord:
    """A word was read from the wires: at every publication, or (period 0) when it has changed.

    Attributes:
        raw: 0..7, as the original publishes it.
        code: -4..3, what it means.
        at_ns: when.
    """

    raw: int
    code: int
    at_ns: int


class MotorCode(Part):
    """See the head of this file. Publications fall on whole periods after power-on; the speed then holds."""

    TERMINALS = tuple(Terminal(name=name, direction=Direction.IN, needed=True) for name in ("comm1", "comm2", "comm3"))
    QUANTITIES = (Quantity(name="speed", direction=Direction.OUT, unit="m/s", text="at the rim of the wheel"),)
    Settings = MotorCodeSettings

    def __init__(self, settings: MotorCodeSettings, ports: Ports, *, seed: int) -> None:  # noqa: ARG002
        self._settings = settings
        self._order: BitOrder = settings.bit_order
        self._latches = settings.reads == "odr"
        self._inputs = tuple(ports.input(terminal.name) for terminal in self.TERMINALS)
        self._tell = ports.tell
        self._period_ns = round(settings.period_ms * _MS)
        self._due_ns: int | None = None
        self._stepped_ns = 0
        self._word: int | None = None

    def power_on(self, now_ns: int) -> None:
        """Stand still until the first publication."""
        self._due_ns = now_ns + self._period_ns if self._period_ns else None
        self._stepped_ns = now_ns
        self._word = None

    def before_step(self, from_ns: int, to_ns: int) -> Mapping[str, float]:  # noqa: ARG002
        """Return the speed as published, or by the mean levels of the time since the last step."""
        code = self._published(from_ns) if self._period_ns else self._mean(from_ns)
        return {"speed": code * self._settings.speed_per_code_m_s}

    def advance(self, now_ns: int) -> None:
        """Publish what is due."""
        while self._due_ns is not None and self._due_ns <= now_ns:
            self._publish(self._due_ns)
            self._due_ns += self._period_ns

    def next_deadline_ns(self) -> int | None:
        """When the next word is published."""
        return self._due_ns

    def _published(self, now_ns: int) -> float:
        self.advance(now_ns)
        return 0.0 if self._word is None else signed(self._word)

    def _mean(self, now_ns: int) -> float:
        """Mean of the code: each bit counts in it with its weight, so the mean of each will do."""
        since_ns, self._stepped_ns = self._stepped_ns, now_ns
        if self._read(now_ns) != self._word:
            self._publish(now_ns)
        if self._latches:
            return signed(self._read(now_ns))
        first, second, third = (wire.mean(since_ns, now_ns) for wire in self._inputs)
        if self._order != LSB_FIRST:
            first, third = third, first
        return first + 2 * second - 4 * third

    def _publish(self, at_ns: int) -> None:
        self._word = self._read(at_ns)
        self._tell(MotorWord(raw=self._word, code=signed(self._word), at_ns=at_ns))

    def _read(self, at_ns: int) -> int:
        levels = (wire.latch() if self._latches else wire.level_at(at_ns) for wire in self._inputs)
        return word_of(levels, self._order)
