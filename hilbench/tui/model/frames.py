"""The frames on our lines, read from the bytes that the journal holds."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Collection, Hashable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hilbench.plugins.blame import place_of
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.protocol import ProtocolPlugin, Quantity
from hilbench.tui.model.quantities import numbers_of, quantity_of, text_of
from hilbench.tui.model.rates import Counted
from protocols.common.decoding import Decoder, Speaker
from protocols.common.item_words import said
from protocols.common.items import Item, Kind
from protocols.common.layout import Region, laid_out

__all__ = ["KEPT_FRAMES", "LEAST_STEP_NS", "Field", "FrameModel", "FramesModel", "MessageModel", "failed"]

KEPT_FRAMES = 2000
LEAST_STEP_NS = 50_000_000
"""Figures that come faster are thinned to this (choice)."""

Event = Mapping[str, Any]


@dataclass(frozen=True, slots=True)
class Field:
    """A field of a message.

    Attributes:
        name: as its protocol calls it.
        quantity: what it is.
        value: as it stands in the frame.
    """

    name: str
    quantity: Quantity
    value: object

    @property
    def text(self) -> str:
        """The value in its unit, without that."""
        return text_of(self.value, self.quantity)

    @property
    def numbers(self) -> list[float]:
        """The value in its unit: one number, or those of a list; none where it is no number."""
        return numbers_of(self.value, self.quantity)


class FrameModel:
    """A frame, or bytes that are none; read when somebody looks at it.

    Args:
        number: counted from 1, since the journal began.
        ns: bench time at which it was handed over, or complete, in ns.
        sent: whether our end sent it.
        end: whose line it was on.
        found: what was found of it.
        read: reads that.

    Attributes:
        line: on which of several lines; empty if there is but one.
    """

    __slots__ = ("_end", "_found", "_item", "_read", "line", "ns", "number", "sent")

    def __init__(self, number: int, ns: int, sent: bool, end: _End, found: Any, read: Callable[[Any], Item]) -> None:
        self.number = number
        self.ns = ns
        self.sent = sent
        self.line = end.line
        self._end = end
        self._found = found
        self._read = read
        self._item: Item | None = None

    @property
    def item(self) -> Item:
        """What it says."""
        if self._item is None:
            self._item = self._read(self._found)
        return self._item

    @property
    def good(self) -> bool:
        """Whether it is sound and says something."""
        return self.item.kind is Kind.FRAME

    @property
    def text(self) -> str:
        """What it says in one line."""
        return said(self.item)

    @property
    def fields(self) -> list[Field]:
        """What it says, field by field; those without a value are left out."""
        known = self._end.quantities
        return [
            Field(name, quantity_of(name, known), value)
            for name, value in self.item.fields.items()
            if value is not None
        ]

    @property
    def message(self) -> tuple[str, bool, str]:
        """Which message it is: on which line, whether our end sent it, and its name."""
        return self.line, self.sent, self.item.name

    @property
    def answers(self) -> Collection[str]:
        """The names of the requests that it answers."""
        return self._end.requests.get(self.item.name, ())

    @property
    def asks(self) -> bool:
        """Whether it is a request."""
        protocol = self._end.protocol
        return protocol is not None and self.item.name in protocol.answers

    def made_anew(self, message: object) -> bytes:
        """Return the frame of another message of its protocol.

        Raises:
            ValueError: its protocol cannot make one, or not of this message.
        """
        protocol = self._end.protocol
        if protocol is None or protocol.encode is None:
            raise ValueError("its protocol makes no frames here")
        try:
            return protocol.encode(message, self._end.options)
        except Exception as error:
            raise ValueError(f"{error}") from error

    @property
    def can_be_made(self) -> bool:
        """Whether its protocol makes frames of messages, and it is one."""
        protocol = self._end.protocol
        return self.item.message is not None and protocol is not None and protocol.encode is not None

    @property
    def source(self) -> str:
        """Whose line it was on, as in the journal."""
        return self._end.source

    @property
    def regions(self) -> list[Region]:
        """What its bytes are, if it is sound."""
        if self._end.protocol is None:
            return laid_out(self.item.raw, [("bytes", len(self.item.raw))])
        try:
            by_host = self.sent == (self._end.side == "host")
            return self._end.protocol.regions(self.item.raw, self._end.options, sent=by_host)
        except Exception as error:  # noqa: BLE001 - a plug-in's: the others are there
            return laid_out(self.item.raw, [(failed("regions", error), len(self.item.raw))])

    @property
    def words(self) -> str:
        """What a filter looks at: its line and what it says, in small letters."""
        return f"{self.line} {self.text}".lower()


@dataclass(frozen=True, slots=True, kw_only=True)
class _End:
    """An end of a line: what it speaks and how, which line of several that is, and from which side it is seen.

    What a far end sends is heard by whoever sees it so.
    """

    name: str
    source: str = ""
    protocol: ProtocolPlugin | None = None
    options: Any = None
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    requests: Mapping[str, Collection[str]] = field(default_factory=dict)
    line: str = ""
    side: str = "host"
    far: bool = False


class _Guarded:
    """A decoder whose code may fail: then its bytes are shown, and why they were not read.

    Args:
        end: who speaks what.
        speaker: which end of it.
    """

    def __init__(self, end: _End, speaker: Speaker) -> None:
        self._why = ""
        self._decoder: Decoder | None = None
        if end.protocol is None:
            self._why = f"no protocol '{end.name}' is known here; --plugin FILE brings one of a file"
            return
        try:
            self._decoder = end.protocol.decoder(end.options, speaker)
        except Exception as error:  # noqa: BLE001 - a plug-in's
            self._why = failed("decoder", error)

    def find(self, data: bytes) -> Sequence[Any]:
        if self._decoder is None:
            return [self._unread(data)]
        try:
            return self._decoder.find(data)
        except Exception as error:  # noqa: BLE001 - a plug-in's
            self._why = failed("decoder", error)
            return [self._unread(data)]

    def sort(self, found: Any) -> Hashable:
        if isinstance(found, _Unread) or self._decoder is None:
            return None
        try:
            return self._decoder.sort(found)
        except Exception:  # noqa: BLE001 - a plug-in's; whoever reads it says so
            return None

    def read(self, found: Any) -> Item:
        if isinstance(found, _Unread):
            return found.item
        assert self._decoder is not None
        try:
            return self._decoder.read(found)
        except Exception as error:  # noqa: BLE001 - a plug-in's
            return Item(kind=Kind.UNREADABLE, name=failed("decoder", error), raw=bytes(getattr(found, "raw", b"")))

    def _unread(self, data: bytes) -> _Unread:
        return _Unread(Item(kind=Kind.DROPPED, name=self._why, raw=data))


@dataclass(frozen=True, slots=True)
class _Unread:
    """Bytes that a decoder has failed on."""

    item: Item


def failed(what: str, error: Exception) -> str:
    """Return what went wrong in the code of a plug-in, and where."""
    place = place_of(error, PLUGINS.brought)
    return f"its {what} fails: {place}{': ' if place else ''}{type(error).__name__}: {error}"


@dataclass(slots=True)
class MessageModel:
    """A message that comes again and again.

    Attributes:
        latest: the last of its frames.
        counts: how many there were, and how often lately; of each sort of it that its decoder distinguishes.
    """

    latest: FrameModel
    counts: list[Counted]

    @property
    def count(self) -> int:
        """How many there were."""
        return sum(one.value for one in self.counts)

    def per_s(self, now_ns: int) -> float:
        """Return how many come in a second, lately."""
        return sum(one.per_s(now_ns) for one in self.counts)

    def joined(self, other: MessageModel) -> MessageModel:
        """Return it with another sort of the same message."""
        latest = max(self.latest, other.latest, key=lambda frame: frame.number)
        return MessageModel(latest, [*self.counts, *other.counts])


class FramesModel:
    """The latest frames of both directions of all lines, in the order in which they came.

    Args:
        live: what the header of the journal says of the bench.
    """

    def __init__(self, live: Event) -> None:
        self.frames: deque[FrameModel] = deque(maxlen=KEPT_FRAMES)
        self._count = 0
        self._messages: dict[tuple[str, bool, Hashable], MessageModel] = {}
        self._ends = _ends(live)
        self._seen: dict[str, dict[Hashable, int]] = {who: {} for who in self._ends}
        self._decoders: dict[tuple[str, bool], _Guarded] = {}
        for who, about in self._ends.items():
            for sent in (True, False):
                speaker = "host" if sent == (about.side == "host") else "target"
                self._decoders[who, sent] = _Guarded(about, speaker)

    @property
    def count(self) -> int:
        """How many there were in all."""
        return self._count

    @property
    def protocols(self) -> list[ProtocolPlugin]:
        """What is spoken, as far as it is known here."""
        return [end.protocol for end in self._ends.values() if end.protocol is not None]

    def take(self, event: Event) -> list[FrameModel]:
        """Take bytes that an end of ours sent or heard, or a far one; return what they bring anew.

        That are the frames that were heard, but of each message at most one in each `LEAST_STEP_NS`: a full line has
        thousands in a second, and nobody reads them all.
        """
        source, ns = event.get("source", ""), event["ns"]
        end = self._ends.get(source)
        if end is None:
            return []
        sent = (event["kind"] == "tx") != end.far
        decoder = self._decoders[source, sent]
        found = decoder.find(bytes.fromhex(event["data"]))
        read, count = decoder.read, self._count + 1
        frames = [FrameModel(number, ns, sent, end, one, read) for number, one in enumerate(found, count)]
        self._count += len(frames)
        self.frames.extend(frames)
        sorts = [decoder.sort(one) for one in found]
        self._count_messages(sorts, frames)
        return [] if sent else list(self._news(source, ns, sorts, frames))

    @property
    def messages(self) -> list[MessageModel]:
        """The messages that there were, those of each line and direction together, by their names."""
        found: dict[tuple[str, bool, str], MessageModel] = {}
        for one in self._messages.values():
            of = one.latest.message
            found[of] = one if of not in found else found[of].joined(one)
        return [found[of] for of in sorted(found)]

    def _count_messages(self, sorts: Sequence[Hashable], frames: Sequence[FrameModel]) -> None:
        """Count frames by their messages; bytes that are no frame are none."""
        for sort, frame in zip(sorts, frames, strict=True):
            if sort is not None:
                of = frame.source, frame.sent, sort
                message = self._messages.get(of)
                if message is None:
                    message = self._messages[of] = MessageModel(frame, [Counted()])
                message.latest = frame
                (counted,) = message.counts
                counted.take(counted.value + 1, frame.ns)

    def series(self, message: tuple[str, bool, str], field: str) -> list[tuple[int, list[float]]]:
        """Return the bench times in ns and the numbers of a field of a message, as far back as frames are kept."""
        found = []
        for frame in self.frames:
            if frame.good and frame.message == message:
                numbers = next((one.numbers for one in frame.fields if one.name == field), [])
                if numbers:
                    found.append((frame.ns, numbers))
        return found

    def _news(
        self, source: str, ns: int, sorts: Iterable[Hashable], frames: Sequence[FrameModel]
    ) -> Iterator[FrameModel]:
        seen = self._seen[source]
        for sort, frame in zip(sorts, frames, strict=True):
            if sort is not None and ns - seen.get(sort, -LEAST_STEP_NS) >= LEAST_STEP_NS:
                seen[sort] = ns
                yield frame

    def matching(self, pattern: str, count: int) -> list[FrameModel]:
        """Return the latest frames that a filter lets pass, oldest first.

        Args:
            pattern: words that all must stand in a frame's row, in any case; ``-word`` must not, ``>`` is sent, ``<``
                is heard, ``!`` is not sound.
            count: how many at most.
        """
        words = pattern.lower().split()
        found: list[FrameModel] = []
        for frame in reversed(self.frames):
            if all(_passes(word, frame) for word in words):
                found.append(frame)
                if len(found) == count:
                    break
        return found[::-1]


def _ends(live: Event) -> dict[str, _End]:
    """Return our ends that speak a protocol, by their sources in the journal."""
    alone = {"protocol": live.get("protocol", ""), "side": live.get("side", "host")}
    speakers: Event = live.get("speakers", {str(live.get("operator")): alone})
    found = {}
    for who, about in speakers.items():
        name = str(about["protocol"])
        protocol = PLUGINS.known(name)
        side, line = str(about.get("side", "host")), str(about.get("line", ""))
        options = None if protocol is None else protocol.options_in(live)
        if name:
            far = bool(about.get("far", False))
            found[who] = _End(
                name=name, source=who, protocol=protocol, options=options, quantities=_quantities(protocol, live),
                requests=_requests(protocol), line=line, side=side, far=far,
            )  # fmt: skip
    return found


def _requests(protocol: ProtocolPlugin | None) -> Mapping[str, Collection[str]]:
    """Return by the name of an answer which requests it answers."""
    found: dict[str, list[str]] = {}
    for request, answers in {} if protocol is None else protocol.answers.items():
        for answer in answers:
            found.setdefault(answer, []).append(request)
    return found


def _quantities(protocol: ProtocolPlugin | None, live: Event) -> Mapping[str, Quantity]:
    if protocol is None:
        return {}
    try:
        return dict(protocol.quantities(live))
    except Exception:  # noqa: BLE001 - a plug-in's: the fields are shown as they are
        return {}


def _passes(word: str, frame: FrameModel) -> bool:
    match word:
        case ">":
            return frame.sent
        case "<":
            return not frame.sent
        case "!":
            return not frame.good
    if word.startswith("-") and len(word) > 1:
        return word[1:] not in frame.words
    return word in frame.words
