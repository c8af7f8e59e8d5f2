"""A protocol: the one record that all generic code reads."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, Protocol, get_type_hints

from protocols.common.checksum import Checksum
from protocols.common.decoding import Decoder, NoOptions, Speaker
from protocols.common.items import Item
from protocols.common.layout import Region, laid_out

if TYPE_CHECKING:
    from hilbench.bench import Bench
    from hilbench.bench.devices import SerialDevice
    from hilbench.bench.line_peer import LinePeer
    from hilbench.links import Port

__all__ = [
    "API",
    "ClauseEntry",
    "Device",
    "FirstTest",
    "Heard",
    "ProtocolPlugin",
    "Quantity",
    "Recorded",
    "TopicSample",
]

API = 1
"""Of this record; a plug-in says which one it was written for."""


class ClauseEntry(Protocol):
    """A clause of a catalogue; see `hilbench.check.catalogue.Clause`. `stand_ins` and `by_hand` are optional."""

    @property
    def id(self) -> str:
        """The short name, unique in all catalogues."""

    @property
    def suite(self) -> str:
        """The suite whose cases cite it."""

    @property
    def level(self) -> Literal["must", "should"]:
        """``must`` or ``should``."""

    @property
    def title(self) -> str:
        """The clause in a few words."""

    @property
    def text(self) -> str:
        """The rule itself."""

    @property
    def source(self) -> str:
        """Where the rule is published."""

    @property
    def needs(self) -> Collection[str]:
        """The capabilities that a bench must have to check it."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """One end of a line as a model: the device that answers, or the host that asks.

    Attributes:
        make: makes the model from its settings, just powered on. If the model has an attribute ``observed``, its state
            machine (`hilbench.bench.state_reporter.Observed`) or several by name, the dashboard shows their states and
            watchdogs. If it has a method ``look``, its result is recorded as an event with the name of the system, for
            the view of that system.
        settings: the class of its settings, a dataclass with a default for each field.
        capabilities: further capabilities of a bench with this model, by the names that clauses use.
        resting: the names of its timers that may expire in normal operation, such as the one for the next request. All
            other timers are shown as watchdogs.
    """

    make: Callable[[Any], SerialDevice]
    settings: type[Any] = NoOptions
    capabilities: frozenset[str] = frozenset()
    resting: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class Recorded:
    """What can be checked on a recording.

    Attributes:
        capabilities: the capabilities that a recording has, in addition to the protocol itself.
        suites: the suites that check a recording, then the suites whose clauses are not applicable there: names of
            shipped suites, or files.
    """

    suites: tuple[str, ...]
    capabilities: frozenset[str] = frozenset()


@dataclass(frozen=True, slots=True, kw_only=True)
class FirstTest:
    """The test that ``hilbench init --protocol`` writes for a board at a port.

    Attributes:
        bench: the bench that it runs on.
        text: the test. ``{target}`` is replaced by the port of the board.
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


class Heard(Protocol):
    """A frame of a recording; see `hilbench.recordings.frames.Framed`."""

    @property
    def ns(self) -> int:
        """When its last byte was there, in ns."""

    @property
    def source(self) -> str:
        """Who sent or received it."""

    @property
    def line(self) -> str:
        """At which of its lines; empty where it has but one."""

    @property
    def kind(self) -> str:
        """``tx`` or ``rx``."""

    @property
    def item(self) -> Item:
        """What it is."""


@dataclass(frozen=True, slots=True, kw_only=True)
class TopicSample:
    """A sample of a topic of ROS 2 in a recording.

    Attributes:
        ns: when it was said, in ns.
        topic: the name, as ROS has it: ``/speed``.
        type_name: such as ``std_msgs/msg/Float32``.
        definition: of the type, with all that is in it, as the encoding ``ros2msg`` has it; None if it is not
            known.
        data: in CDR, behind its header.
    """

    ns: int
    topic: str
    type_name: str
    definition: str | None
    data: bytes


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
        api: the version of this record that it was written for, `API`.
        name: its name on the command line and in journals.
        title: its name for people. A bench that speaks it has the capability of this name.
        summary: what it is, in a few words.
        help: what the dashboard's help says where our client speaks it; in Textual's markup.
        decoder: makes the decoder of a stream, ``decoder(options, speaker)``.
        options: how frames are read: a dataclass with a default for each field. Each field becomes an option of the
            commands that show frames; its metadata ``help`` is the help text.
        quantities: returns the quantities of fields whose names do not end with their units, by their names. It gets
            what the header of a journal says of the bench, such as how far a count of its vehicle is.
        answers: the names of messages that answer a request, by the name of the request. A dashboard joins them.
        regions: returns the fields of a valid frame and their bytes, ``regions(raw, options, sent=...)``; ``sent`` is
            True for a frame that the host has sent. By default the whole frame is one region.
        checksum: returns the checksum rule for these options, for tools that change frames on the line; None if there
            is no single rule.
        longest_frame: the longest frame, in bytes. So much of a frame may be left at the beginning of a recording.
        clauses: returns the clauses of the protocol.
        encode: makes the frame of a message, for ``peer.send`` in a suite and for a message that is edited in the
            dashboard: ``encode(message, options)``.
        settle: brings a real target into the state in which a case begins; it gets a peer to send with. None sends
            nothing.
        peer: makes the checker's end of a line, from a bench, a port and the program that a board runs; None for a
            peer that uses the decoder.
        device: the model of the device. A bench file names it as ``model = "NAME"``.
        host: the model of the host that speaks to the device in the dashboard; at a real port the dashboard only
            listens.
        suites: the suites of a bench with the device, if its file names none.
        baud: the usual rate of its line, in bit/s.
        recorded: what can be checked on a recording; None for nothing.
        replay_bench: the bench that ``hilbench replay --into PORT`` uses, by name or as the path of its file; empty if
            none can be used.
        first_test: the first test for a new user; None for none.
        samples: returns the samples of topics in the frames of a recording, in order, and the names of types that are
            not known; it gets the folders with definitions of types. None where nothing of the kind is said.
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
    samples: Callable[[Sequence[Heard], Sequence[Path]], tuple[list[TopicSample], list[str]]] | None = None

    def options_in(self, about: Mapping[str, object]) -> Any:
        """Return the options that the header of a journal has; values of enumerations stand there by name."""
        kinds = get_type_hints(self.options)
        known = (one.name for one in dataclasses.fields(self.options) if one.name in about)
        return self.options(**{name: _value(kinds[name], about[name]) for name in known})


def _value(kind: Any, said: Any) -> Any:
    if isinstance(kind, type) and issubclass(kind, Enum):
        return kind[said]
    return Path(said) if kind is Path else said
