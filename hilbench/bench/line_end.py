"""The checker's end of a line, as a report looks at it: what it heard and what it wrote."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

from hilbench.bench.line_evidence import Passed, Written, in_order

__all__ = ["LineEnd"]


class LineEnd(ABC):
    """See the module.

    Attributes:
        received: the messages heard, oldest first, each with `at_ns` and `raw`.
    """

    received: list[Any]
    _written: Written

    @abstractmethod
    def kind_of(self, got: Any) -> object:
        """Return what is the same for messages of one kind."""

    @abstractmethod
    def words_of(self, got: Any) -> str:
        """Return a message that was heard in words."""

    def ask_again(self) -> None:  # noqa: B027 - many have nothing of the kind, and so the next
        """Send what is answered and changes nothing, whatever state the target is in, if there is such a message."""

    def stand_still(self) -> None:  # noqa: B027
        """Send what stops a target that moves, if the protocol has such a message."""

    def mark(self) -> int:
        """Return a position in what was received, to look only at what comes after it."""
        return len(self.received)

    def refused_since(self, since_ns: int) -> Sequence[Passed]:  # noqa: ARG002 - whoever keeps the times has them
        """Return what came since a moment and was no frame, as far as its time is known."""
        return ()

    def news(self, mark: int, since_ns: int) -> Sequence[Passed]:
        """Return what passed since a moment: of each kind of message the first and the last that say something new.

        Args:
            mark: how many messages had been received then.
            since_ns: bench time of the moment.
        """
        last = {self.kind_of(got): got.raw for got in self.received[:mark]}
        new: dict[object, list[Passed]] = {}
        for got in self.received[mark:]:
            kind = self.kind_of(got)
            if last.get(kind) != got.raw:
                new.setdefault(kind, [])[1:] = [(got.at_ns, f"<  {self.words_of(got)}")]
            last[kind] = got.raw
        sent = [one for one in self._written.passed() if one[0] >= since_ns]
        refused = self.refused_since(since_ns)
        return in_order(sent, [*refused[:1], *refused[1:][-1:]], *new.values())
