"""An SPI bus between a master in a chip and the slaves outside: words, each at its own bench time.

Levels of SCK, MOSI and MISO are not modelled here. The master owns the timing; it calls the bus at the end of each word
with the bits as they followed each other on MOSI, and gets those of MISO. A slave takes and gives whole bytes, the bit
that comes first as the highest, and knows by its own chip select whether it is meant. A word of the master may end in
the middle of a byte; the rest of it comes with the next word. There is no standard of SPI; the
four modes are those of CPOL and CPHA (RM0008 section 25.3.1).

A slave may promise bytes that it will answer, whatever is sent, as a flash does that is read on and on: see
`PromisingSlave`. Who has a promise need not call the bus for each word. It keeps what it sends, and the slaves are told
of all of it at once before anything else happens to them.

Choice: a slave in another mode than the master samples at the other edge, where the line changes. It sees each bit one
later, the first one being the last of the byte before, and so does the master of what it answers.
"""

from __future__ import annotations

from collections.abc import Callable
from operator import and_
from typing import Protocol, TypeGuard

__all__ = ["PromisingSlave", "SpiBus", "SpiSlave", "check_slave", "promises"]

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


class PromisingSlave(SpiSlave, Protocol):
    """A slave that may know beforehand what it answers.

    Attributes:
        broken: the bus sets it; to be called before chip select changes, or what was promised does.
    """

    broken: Callable[[], None]

    def promise(self, most: int) -> bytes | None:
        """Return what stands on MISO next, whatever is sent, as long as chip select stays; called after `exchange`.

        Args:
            most: that many bytes are enough.

        Returns:
            At least one byte; none while it is not selected, which counts until `broken` is called; None: nobody knows.
        """

    def take(self, data: bytes, now_ns: int) -> None:
        """Take the bytes of MOSI that have come since a promise; `now_ns` is the end of the last one."""


def check_slave(slave: object) -> None:
    """Raise TypeError, with what is missing, for an object that has not all of `SpiSlave`."""
    missing = [name for name in ("modes", "releases", "selected", "exchange", "answer") if not hasattr(slave, name)]
    if missing:
        raise TypeError(f"{type(slave).__name__} is no SpiSlave: it has no {', no '.join(missing)}")


def promises(slave: SpiSlave) -> TypeGuard[PromisingSlave]:
    """Say whether a slave is a `PromisingSlave`."""
    return hasattr(slave, "promise")


class SpiBus:
    """See the module.

    Attributes:
        on_attach: called after a slave was soldered to it.
        take_heard: ends a promise; returns the bytes that were sent since, and the end of the last one.
    """

    def __init__(self) -> None:
        self.on_attach: Callable[[], None] = lambda: None
        self.take_heard: Callable[[], tuple[bytes, int]] = lambda: (b"", 0)
        self._ends: list[_End] = []

    def attach(self, slave: SpiSlave) -> None:
        """Solder a slave to the bus; raises TypeError as `check_slave` does."""
        check_slave(slave)
        self.settle()
        self._ends.append(_End(slave, self.settle))
        self.on_attach()

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
        self.settle()
        found: int | None = None
        for end in self._ends:
            answer = end.exchange(bits, count, mode, now_ns)
            if answer is not None:
                found = answer if found is None else found & answer
        return found

    def promise(self, mode: int, most: int) -> bytes | None:
        """Return what stands on MISO next, whatever is sent; called after `exchange`.

        It holds until `take_heard` is called.

        Args:
            mode: of the master.
            most: that many bytes are enough.

        Returns:
            At least one byte; none: no slave is selected; None: nobody knows.
        """
        found = b""
        for end in self._ends:
            answers = end.promise(mode, most)
            if answers is None:
                return None
            if answers:
                found = bytes(map(and_, found, answers)) if found else answers
        return found

    def settle(self) -> None:
        """Tell slaves what was sent while they had promised their answers; the promises end. For who looks at them."""
        data, now_ns = self.take_heard()
        if data:
            for end in self._ends:
                end.take(data, now_ns)


class _End:
    """What a slave knows of the bits on the bus since it was selected."""

    def __init__(self, slave: SpiSlave, settle: Callable[[], None]) -> None:
        self._slave = slave
        self._promising = slave if promises(slave) else None
        if self._promising is not None:
            self._promising.broken = settle
        self._hears = False
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

    def promise(self, mode: int, most: int) -> bytes | None:
        """Return what it answers next; see `SpiBus.promise`."""
        answers = None if self._promising is None else self._promising.promise(most)
        self._hears = bool(answers)
        return None if answers and (mode not in self._slave.modes or self._begun_bits) else answers

    def take(self, data: bytes, now_ns: int) -> None:
        """Tell it what has come since then, if it was selected."""
        if self._hears and self._promising is not None:
            self._promising.take(data, now_ns)

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
