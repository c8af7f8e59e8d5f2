"""An SPI bus between a master in a chip and the slaves outside: words, each at its own bench time.

Levels of SCK, MOSI and MISO are not modelled here. The master owns the timing; it calls the bus at the end of each word
with the bits as they followed each other on MOSI, and gets those of MISO. A slave takes and gives whole bytes, the bit
that comes first as the highest, and knows by its own chip select whether it is meant. There is no standard of SPI; the
four modes are those of CPOL and CPHA (RM0008 section 25.3.1).

Choice: a slave in another mode than the master samples at the other edge, where the line changes. It sees each bit one
later, the first one being the last of the byte before, and so does the master of what it answers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

__all__ = ["SpiBus", "SpiSlave", "SpiWord"]

BYTE_BITS = 8


class SpiSlave(Protocol):
    """What answers on a bus. Times are bench time in ns and never go back.

    Attributes:
        modes: those in which it works, 0 to 3: CPOL and CPHA as two bits.
    """

    @property
    def modes(self) -> frozenset[int]: ...  # noqa: D102

    def selected(self, now_ns: int) -> bool:
        """Say whether its chip select is active."""

    def exchange(self, byte: int, now_ns: int) -> int:
        """Take a byte of MOSI, 0 to 255, and return the one that stood on MISO meanwhile."""


class SpiWord(NamedTuple):
    """A word that went over a bus.

    Attributes:
        mosi: its bits on MOSI, the first one as the highest,
        miso: and on MISO; None where no slave was selected.
        bits: how many.
        end_ns: bench time of its end.
    """

    mosi: int
    miso: int | None
    bits: int
    end_ns: int


class SpiBus:
    """See the module.

    Attributes:
        taps: called with every word.
    """

    def __init__(self) -> None:
        self.taps: list[Callable[[SpiWord], None]] = []
        self._slaves: list[SpiSlave] = []
        self._last_bits: dict[int, tuple[int, int]] = {}

    def attach(self, slave: SpiSlave) -> None:
        """Solder a slave to the bus."""
        self._slaves.append(slave)

    def exchange(self, bits: int, count: int, mode: int, now_ns: int) -> int | None:
        """A word has gone over the bus.

        Args:
            bits: those on MOSI, the first one as the highest.
            count: how many, 8 or 16.
            mode: of the master.
            now_ns: the end of the word.

        Returns:
            What stood on MISO; None while no slave is selected. Of several that are, low wins (choice).
        """
        found: int | None = None
        for number, slave in enumerate(self._slaves):
            if slave.selected(now_ns):
                answer = self._of(number, slave, bits, count, mode, now_ns)
                found = answer if found is None else found & answer
            else:
                self._last_bits.pop(number, None)
        for tap in tuple(self.taps):
            tap(SpiWord(bits, found, count, now_ns))
        return found

    def _of(self, number: int, slave: SpiSlave, bits: int, count: int, mode: int, now_ns: int) -> int:
        late = mode not in slave.modes
        last_in, last_out = self._last_bits.get(number, (1, 1))
        if late:
            last_in, bits = bits & 1, last_in << count - 1 | bits >> 1
        answer = 0
        for shift in range(count - BYTE_BITS, -1, -BYTE_BITS):
            answer = answer << BYTE_BITS | slave.exchange(bits >> shift & 0xFF, now_ns)
        if late:
            last_out, answer = answer & 1, last_out << count - 1 | answer >> 1
        self._last_bits[number] = (last_in, last_out)
        return answer
