"""The frames in the bytes of a recording, and which protocol is spoken there."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass

from hilbench.clock import NS_PER_S
from hilbench.plugins.discovery import PLUGINS
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.recordings.chunks import chunk_of, line_of
from hilbench.recordings.layout import Event
from protocols.common.decoding import Decoder
from protocols.common.items import Item, Kind

__all__ = ["FRAME_NS", "Framed", "framed", "spoken"]

FRAME_NS = NS_PER_S // 2
"""So long a frame takes at most, with pauses in it (choice: more than twice the longest one at 9600 bit/s)."""

_UNFINISHED = frozenset({"unfinished frame abandoned", "unfinished for too long"})
"""What decoders call a frame whose rest did not come."""

_ENOUGH_BYTES = 50_000

_Stream = tuple[str, str, str]
"""A source, one of its lines, and ``tx`` or ``rx``."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Framed:
    """An item of one stream.

    Attributes:
        ns: when its last byte was there, in ns.
        source: who sent or received it.
        line: at which of its lines; empty where it has but one.
        kind: ``tx`` or ``rx``.
        item: what it is.
        cut: whether it is of a frame whose rest was still to come when the recording, or its case, ended.
    """

    ns: int
    source: str
    line: str
    kind: str
    item: Item
    cut: bool = False


def framed(events: Iterable[tuple[int, Event]], protocol: ProtocolPlugin, options: object = None) -> Iterator[Framed]:
    """Yield what the bytes of each stream turn out to be; a case begins with nothing left of the one before.

    Args:
        events: with their times.
        protocol: what is spoken.
        options: how its frames are read, its own record; as usual if None.
    """
    options = protocol.options() if options is None else options
    decoders: dict[_Stream, Decoder] = {}
    fed_ns: dict[_Stream, int] = {}
    last_ns = 0
    for ns, event in events:
        if event["kind"] == "case":
            yield from _rest(decoders, fed_ns, last_ns)
            decoders.clear()
        last_ns = max(last_ns, ns)
        chunk = chunk_of(event)
        if chunk is None:
            continue
        key = source, line, kind = _stream(event)
        if key not in decoders:
            decoders[key] = protocol.decoder(options, chunk.speaker or ("host" if kind == "tx" else "target"))
        fed_ns[key] = ns
        for item in decoders[key].feed(chunk.data):
            yield Framed(ns=ns, source=source, line=line, kind=kind, item=item)
    yield from _rest(decoders, fed_ns, last_ns)


def _stream(event: Event) -> _Stream:
    return str(event["source"]), line_of(event), "tx" if event["kind"] == "tx" else "rx"


def _rest(decoders: dict[_Stream, Decoder], fed_ns: dict[_Stream, int], ns: int) -> Iterator[Framed]:
    for (source, line, kind), decoder in decoders.items():
        items = list(decoder.finish())
        cut_at = _cut_at(items) if ns - fed_ns[source, line, kind] <= FRAME_NS else len(items)
        for number, item in enumerate(items):
            yield Framed(ns=ns, source=source, line=line, kind=kind, item=item, cut=number >= cut_at)


def _cut_at(items: list[Item]) -> int:
    """Return where the unfinished frame begins; what it holds may look like anything, but not like a sound frame."""
    behind = max((number for number, item in enumerate(items, 1) if item.kind is not Kind.DROPPED), default=0)
    return next(
        (number for number, item in enumerate(items) if number >= behind and item.name in _UNFINISHED), len(items)
    )


def spoken(
    events: Iterable[tuple[int, Event]], can: Callable[[ProtocolPlugin], bool] = lambda _: True
) -> ProtocolPlugin | None:
    """Return the protocol that makes frames of most bytes; None if none does.

    One that can do what is wanted comes before those that cannot: a protocol without a checksum makes frames of all.

    It counts for what one end says or hears if more than half of that is in its frames. Other lines beside it, such as
    a GPS receiver's or a console's, say nothing against it, however much is said there.
    """
    sample, total = [], 0
    for ns, event in events:
        sample.append((ns, event))
        chunk = chunk_of(event)
        total += len(chunk.data) if chunk else 0
        if total >= _ENOUGH_BYTES:
            break
    said = _said(sample)
    most, best = (False, 0), None
    for protocol in PLUGINS.all():
        try:
            count = _in_frames(sample, protocol, said)
        except Exception as error:  # noqa: BLE001 - whatever the code of a plug-in raises: the others are there
            PLUGINS.fails(protocol.name, error)
            continue
        if count and (can(protocol), count) > most:
            most, best = (can(protocol), count), protocol
    return best


def _said(events: list[tuple[int, Event]]) -> Counter[_Stream]:
    """Count the bytes of each stream."""
    chunks = ((event, chunk_of(event)) for _, event in events)
    counted: Counter[_Stream] = Counter()
    for event, chunk in chunks:
        if chunk is not None:
            counted[_stream(event)] += len(chunk.data)
    return counted


def _in_frames(events: list[tuple[int, Event]], protocol: ProtocolPlugin, said: Counter[_Stream]) -> int:
    """Count the bytes in frames, of the streams that consist of frames."""
    sound: Counter[_Stream] = Counter()
    for one in framed(events, protocol):
        if one.item.kind is Kind.FRAME:
            sound[one.source, one.line, one.kind] += len(one.item.raw)
    return sum(count for stream, count in sound.items() if count * 2 > said[stream])
