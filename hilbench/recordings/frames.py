"""The frames in the bytes of a recording, and which protocol is spoken there."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from hilbench.decode.chunks import chunk_of
from hilbench.decode.decoders import DECODERS
from hilbench.decode.items import Item, Kind
from hilbench.decode.reading import DecodeOptions, Decoder
from hilbench.recordings.layout import Event

__all__ = ["Framed", "framed", "spoken"]

_ENOUGH_BYTES = 50_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Framed:
    """An item of one stream.

    Attributes:
        ns: when its last byte was there, in ns.
        source: who sent or received it.
        kind: ``tx`` or ``rx``.
        item: what it is.
    """

    ns: int
    source: str
    kind: str
    item: Item


def framed(
    events: Iterable[tuple[int, Event]], protocol: str, options: DecodeOptions | None = None
) -> Iterator[Framed]:
    """Yield what the bytes of each stream turn out to be; a case begins with nothing left of the one before.

    Args:
        events: with their times.
        protocol: name in `DECODERS`.
        options: how bytes are read.
    """
    options = options or DecodeOptions()
    decoders: dict[tuple[str, str], Decoder] = {}
    last_ns = 0
    for ns, event in events:
        if event["kind"] == "case":
            yield from _rest(decoders, last_ns)
            decoders.clear()
        last_ns = ns
        chunk = chunk_of(event)
        if chunk is None:
            continue
        key = (str(event["source"]), "tx" if event["kind"] == "tx" else "rx")
        if key not in decoders:
            decoders[key] = DECODERS[protocol](options, chunk.speaker or ("host" if key[1] == "tx" else "target"))
        for item in decoders[key].feed(chunk.data):
            yield Framed(ns=ns, source=key[0], kind=key[1], item=item)
    yield from _rest(decoders, last_ns)


def _rest(decoders: dict[tuple[str, str], Decoder], ns: int) -> Iterator[Framed]:
    for (source, kind), decoder in decoders.items():
        for item in decoder.finish():
            yield Framed(ns=ns, source=source, kind=kind, item=item)


def spoken(events: Iterable[tuple[int, Event]]) -> str:
    """Return the protocol that makes frames of most of the bytes, at least of half of them; empty if none does."""
    sample, total = [], 0
    for ns, event in events:
        sample.append((ns, event))
        chunk = chunk_of(event)
        total += len(chunk.data) if chunk else 0
        if total >= _ENOUGH_BYTES:
            break
    sound = {name: _in_frames(sample, name) for name in DECODERS}
    best = max(sound, key=lambda name: sound[name])
    return best if sound[best] * 2 > total else ""


def _in_frames(events: list[tuple[int, Event]], protocol: str) -> int:
    return sum(len(one.item.raw) for one in framed(events, protocol) if one.item.kind is Kind.FRAME)
