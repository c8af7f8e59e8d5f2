"""What a protocol says of itself: the one record that everything generic knows it by."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import TYPE_CHECKING, Any, Literal, Protocol, get_type_hints

from protocols.common.decoding import Decoder, NoOptions, Speaker
from protocols.common.layout import Region, laid_out

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.line_peer import LinePeer
    from hilbench.links import Port

__all__ = ["API", "ClauseEntry", "FirstTest", "ProtocolPlugin", "Recorded"]

API = 1
"""Of this record; a plug-in says which one it was written for."""


class ClauseEntry(Protocol):
    """A rule of a catalogue; see `hilbench.check.catalogue.Clause`."""

    @property
    def id(self) -> str:
        """Short name, unique over all catalogues."""

    @property
    def suite(self) -> str:
        """The suite whose cases cite it."""

    @property
    def level(self) -> Literal["must", "should"]:
        """How binding it is."""

    @property
    def title(self) -> str:
        """A few words."""

    @property
    def text(self) -> str:
        """The rule."""

    @property
    def source(self) -> str:
        """Where it is written."""

    @property
    def needs(self) -> Sequence[str]:
        """Capabilities without which it cannot be checked."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """What can be judged on a recording.

    Attributes:
        capabilities: those of the clauses that need no more than listening, beside the protocol itself.
        suites: those that listen, then those whose clauses the others are.
    """

    capabilities: frozenset[str]
    suites: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstTest:
    """What ``hilbench init --protocol`` writes for a board at a port.

    Attributes:
        bench: the bench that it runs on.
        text: the test; ``{target}`` is where the board is.
    """

    bench: str
    text: str


def _one_region(raw: bytes, options: object, *, sent: bool) -> list[Region]:
    del options, sent
    return laid_out(raw, [("frame", len(raw))])


@dataclass(frozen=True, slots=True, kw_only=True)
class ProtocolPlugin:
    """A protocol.

    Attributes:
        api: the version of this record, `API`.
        name: what a command line and a journal call it.
        title: what people call it; a bench that speaks it has the capability of this name.
        summary: what it is, in a few words.
        decoder: makes a decoder of a stream: how it is read, and who sends it.
        options: how frames are read, a dataclass whose fields all have defaults; each becomes a flag of those commands
            that show frames. The metadata ``help`` of a field says what it is.
        regions: returns what the bytes of a sound frame are; the whole frame is one if it says nothing.
        longest_frame: in bytes: what may be left of a frame where a recording begins.
        clauses: returns the rules of the protocol.
        peer: makes the checker's end of a line, of a bench, a port and the program that a board runs; None if a check
            has none.
        baud: the usual rate of its line, in bit/s.
        recorded: what can be judged on a recording; None for nothing.
        replay_bench: the bench that a recording is played to where only a port is named; empty if none can.
        first_test: what is written for somebody who begins; None for nothing.
    """

    api: int
    name: str
    title: str
    decoder: Callable[[Any, Speaker], Decoder]
    summary: str = ""
    options: type[Any] = NoOptions
    regions: Callable[..., list[Region]] = _one_region
    longest_frame: int = 256
    clauses: Callable[[], Sequence[ClauseEntry]] = tuple
    peer: Callable[[Bench, Port, str], LinePeer[Any]] | None = None
    baud: int = 9600
    recorded: Recorded | None = None
    replay_bench: str = ""
    first_test: FirstTest | None = None

    def options_in(self, about: Mapping[str, object]) -> Any:
        """Return how frames are read, as the header of a journal has it: names of enumerated values are their own."""
        kinds = get_type_hints(self.options)
        known = (one.name for one in dataclasses.fields(self.options) if one.name in about)
        return self.options(**{name: _value(kinds[name], about[name]) for name in known})


def _value(kind: Any, said: Any) -> Any:
    return kind[said] if isinstance(kind, type) and issubclass(kind, Enum) else said
