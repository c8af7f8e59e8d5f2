"""An SPI bus between a master in a chip and the slaves outside: words, each at its own bench time.

Levels of SCK, MOSI and MISO are not modelled here. The master owns the timing; it calls the bus at the end of each word
with the bits as they followed each other on MOSI, and gets those of MISO. A slave takes and gives whole bytes, the bit
that comes first as the highest, and knows by its own chip select whether it is meant. A word of the master may end in
the middle of a byte; the rest of it comes with the next word. There is no standard of SPI; the
four modes are those of CPOL and CPHA (RM0008 section 25.3.1).

Choice: a slave in another mode than the master samples at the other edge, where the line changes. It sees each bit one
later, the first one being the last of the byte before, and so does the master of what it answers.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

__all__ = ["SpiBus", "SpiSlave", "SpiWord", "check_slave"]

BYTE_BITS = 8


class SpiSlave(Protocol):
    """What answers on a bus. Times are bench time in ns and never go back.

    Attributes:
        modes: those in which it works, 0 to 3: CPOL and CPHA as two bits.
        releases: how often its chip select has risen so far, as of the last call of `selected`.
    """

    @property
    def modes(self) -> frozenset[int]: ...  # noqa: D102
    @property
    def releases(self) -> int: ...  # noqa: D102

    def selected(self, now_ns: int) -> bool:
        """Say whether its chip select is active."""

    def exchange(self, byte: int, now_ns: int) -> int:
        """Take a byte of MOSI, 0 to 255, and return the one that stood on MISO meanwhile."""

    def answer(self) -> int:
        """Return the byte that stands on MISO while the next one comes, whichever that is."""


def check_slave(slave: object) -> None:
    """Raise TypeError, with what is missing, for an object that has not all of `SpiSlave`."""
    missing = [name for name in ("modes", "releases", "selected", "exchange", "answer") if not hasattr(slave, name)]
    if missing:
        raise TypeError(f"{type(slave).__name__} is no SpiSlave: it has no {', no '.join(missing)}")


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
        self._ends: list[_End] = []

    def attach(self, slave: SpiSlave) -> None:
        """Solder a slave to the bus; raises TypeError as `check_slave` does."""
        check_slave(slave)
        self._ends.append(_End(slave))

    def exchange(self, bits: int, count: int, mode: int, now_ns: int) -> int | None:
        """A word has gone over the bus.

        Args:
            bits: those on MOSI, the first one as the highest.
            count: how many, at least 1.
            mode: of the master.
            now_ns: the end of the word.

        Returns:
            What stood on MISO; None while no slave is selected. Of several that are, low wins (choice).
        """
        found: int | None = None
        for end in self._ends:
            answer = end.exchange(bits, count, mode, now_ns)
            if answer is not None:
                found = answer if found is None else found & answer
        for tap in tuple(self.taps):
            tap(SpiWord(bits, found, count, now_ns))
        return found


class _End:
    """What a slave knows of the bits on the bus since it was selected."""

    def __init__(self, slave: SpiSlave) -> None:
        self._slave = slave
        self._releases = 0
        self._forget()

    def _forget(self) -> None:
        self._last_in = self._last_out = 1
        self._begun = self._begun_bits = 0  # of a byte that has not ended yet

    def exchange(self, bits: int, count: int, mode: int, now_ns: int) -> int | None:
        """Take a word and return what stood on MISO; None if the slave is not selected."""
        if not self._slave.selected(now_ns):
            self._forget()
            return None
        if self._slave.releases != self._releases:
            self._releases = self._slave.releases
            self._forget()
        if mode in self._slave.modes:
            return self._shift(bits, count, now_ns)
        late, self._last_in = self._last_in << count - 1 | bits >> 1, bits & 1
        answer = self._shift(late, count, now_ns)
        late, self._last_out = self._last_out << count - 1 | answer >> 1, answer & 1
        return late

    def _shift(self, bits: int, count: int, now_ns: int) -> int:
        answer, left = 0, count
        while left:
            missing = BYTE_BITS - self._begun_bits
            now = min(missing, left)
            left -= now
            self._begun = self._begun << now | bits >> left & (1 << now) - 1
            if now == missing:
                byte, self._begun = self._slave.exchange(self._begun, now_ns), 0
            else:
                byte = self._slave.answer()
            self._begun_bits = (self._begun_bits + now) % BYTE_BITS
            answer = answer << now | byte >> missing - now & (1 << now) - 1
        return answer
