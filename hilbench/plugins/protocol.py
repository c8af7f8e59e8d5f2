"""What a protocol says of itself: the one record that everything generic knows it by."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol, get_type_hints

from protocols.common.checksum import Checksum
from protocols.common.decoding import Decoder, NoOptions, Speaker
from protocols.common.layout import Region, laid_out

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.bench.devices import SerialDevice
    from hilbench.bench.line_peer import LinePeer
    from hilbench.links import Port

__all__ = ["API", "ClauseEntry", "Device", "FirstTest", "ProtocolPlugin", "Quantity", "Recorded"]

API = 1
"""Of this record; a plug-in says which one it was written for."""


class ClauseEntry(Protocol):
    """A rule of a catalogue; see `hilbench.check.catalogue.Clause`. It may have `stand_ins` and `by_hand` besides."""

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
    def needs(self) -> Collection[str]:
        """Capabilities without which it cannot be checked."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """One end of a line as a model: what answers there, or who speaks to it.

    Attributes:
        make: makes one with these settings, just powered on. Where it has an attribute ``observed``, its state machine
            (`hilbench.bench.state_reporter.Observed`) or several by name, the dashboard shows states and watchdogs.
            What its method ``look`` returns, if it has one, is recorded as events of the system's name, for the view of
            that system.
        settings: what it can be set to, a dataclass whose fields all have defaults.
        capabilities: what a bench with it can do beside speaking the protocol, by the names that clauses use.
        resting: the names of its timers with which nothing is wrong when they run out, such as one for the next
            question; the others are watchdogs.
    """

    make: Callable[[Any], SerialDevice]
    settings: type[Any] = NoOptions
    capabilities: frozenset[str] = frozenset()
    resting: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """What can be judged on a recording.

    Attributes:
        capabilities: those of the clauses that need no more than listening, beside the protocol itself.
        suites: those that listen, then those whose clauses the others are: names of shipped ones, or files.
    """

    suites: tuple[str, ...]
    capabilities: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstTest:
    """What ``hilbench init --protocol`` writes for a board at a port.

    Attributes:
        bench: the bench that it runs on.
        text: the test; ``{target}`` is where the board is.
    """

    bench: str
    text: str


@dataclass(frozen=True, slots=True)
class Quantity:
    """What a field of a message is, where its name does not end with its unit.

    Attributes:
        label: what people call it.
        unit: of the value once it is multiplied; empty of a bare number.
        scale: what the value in the frame is multiplied by to be in that unit.
        wraps_at: a counter that begins anew there is shown as what is nearest to 0; 0 of one that does not.
    """

    label: str
    unit: str = ""
    scale: float = 1.0
    wraps_at: int = 0


def _no_quantities(live: Mapping[str, Any]) -> Mapping[str, Quantity]:
    del live
    return {}


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
        help: what one sees where our client speaks it, for the help of the dashboard; in Textual's markup.
        decoder: makes a decoder of a stream: how it is read, and who sends it.
        options: how frames are read, a dataclass whose fields all have defaults; each becomes a flag of those commands
            that show frames. The metadata ``help`` of a field says what it is.
        quantities: returns what fields are whose names do not end with their units, by their names: of what the header
            of a journal says of the bench, such as how far a count of its vehicle is.
        answers: the names of messages that answer a request, by the name of the request; a dashboard joins them.
        regions: returns what the bytes of a sound frame are, ``regions(raw, options, sent=...)``, where a host
            sent or heard it; the whole frame is one region if it says nothing.
        checksum: returns how the frames that are read in this way are checked, for whoever changes one on its way; None
            where they are not, or not by one rule.
        longest_frame: in bytes: what may be left of a frame where a recording begins.
        clauses: returns the rules of the protocol.
        encode: makes the frame of a message, for a suite's ``peer.send`` and for who edits one in the dashboard:
            ``encode(message, options)``.
        settle: brings a real target back to where a case may begin, by what it sends with a peer; None sends nothing.
        peer: makes the checker's end of a line, of a bench, a port and the program that a board runs; None for one
            that knows frames by the decoder.
        device: what answers, as a model: a bench file has it as ``model = "NAME"``.
        host: who speaks to it in the dashboard, where nothing is real: at a port the dashboard listens.
        suites: what is checked of a bench with the model whose file names no suites.
        baud: the usual rate of its line, in bit/s.
        recorded: what can be judged on a recording; None for nothing.
        replay_bench: the bench, by name or as the path of its file, that a recording is played to where only a port is
            named; empty if none can.
        first_test: what is written for somebody who begins; None for nothing.
    """

    api: int
    name: str
    title: str
    decoder: Callable[[Any, Speaker], Decoder]
    summary: str = ""
    help: str = ""
    options: type[Any] = NoOptions
    quantities: Callable[[Mapping[str, Any]], Mapping[str, Quantity]] = _no_quantities
    answers: Mapping[str, Collection[str]] = field(default_factory=dict)
    regions: Callable[..., list[Region]] = _one_region
    checksum: Callable[[Any], Checksum] | None = None
    longest_frame: int = 256
    clauses: Callable[[], Sequence[ClauseEntry]] = tuple
    encode: Callable[[Any, Any], bytes] | None = None
    settle: Callable[[Any], None] | None = None
    peer: Callable[[Bench, Port, str], LinePeer[Any]] | None = None
    device: Device | None = None
    host: Device | None = None
    suites: tuple[Path, ...] = ()
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
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind[said]
    return Path(said) if kind is Path else said
