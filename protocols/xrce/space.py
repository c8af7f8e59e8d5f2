"""The data space of an agent: who writes and who reads which topic, and what reaches whom.

A sample reaches each reader of its domain and topic whose type is the writer's and whose quality of service the writer
can offer. Readers keep what nobody has fetched yet: the newest samples, bounded in number and in bytes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Protocol

from protocols.xrce.descriptions import Qos, TopicDescription

__all__ = ["DataSpace", "Outside", "Reader", "SampleIdentity", "Samples", "StoredSample", "Writer"]


@dataclass(frozen=True, slots=True)
class SampleIdentity:
    """Which sample of which writer: a GUID of 16 bytes, and a number, 0..2^64-1."""

    guid: bytes
    number: int


@dataclass(frozen=True, slots=True, kw_only=True)
class StoredSample:
    """A sample on its way.

    Attributes:
        data: as its writer has encoded it.
        little_endian: its byte order.
        identity: which one it is; None where nobody asks.
        answers: the request that it is the reply to.
    """

    data: bytes
    little_endian: bool = True
    identity: SampleIdentity | None = None
    answers: SampleIdentity | None = None


class Samples:
    """The newest samples, no more than so many and so many bytes; the newest one is kept however long it is.

    Args:
        most: how many.
        max_bytes: of all of them.

    Attributes:
        overrun: samples that were pushed out by newer ones.
    """

    def __init__(self, most: int, max_bytes: int) -> None:
        self.overrun = 0
        self._most = most
        self._max_bytes = max_bytes
        self._samples: deque[StoredSample] = deque()
        self.held = 0

    def __len__(self) -> int:
        """How many there are."""
        return len(self._samples)

    def __iter__(self) -> Iterator[StoredSample]:
        """The oldest first."""
        return iter(self._samples)

    def put(self, sample: StoredSample) -> None:
        """Takes one more, in the place of the oldest ones if there are too many."""
        self._samples.append(sample)
        self.held += len(sample.data)
        while len(self) > self._most or (self.held > self._max_bytes and len(self) > 1):
            self.take()
            self.overrun += 1

    def take(self) -> StoredSample:
        """The oldest one, which is not kept any more."""
        sample = self._samples.popleft()
        self.held -= len(sample.data)
        return sample


class Writer:
    """A writer of a topic.

    Args:
        domain_id: of its participant.
        topic: what it writes.
        qos: what it offers.
        most: samples that are kept at most for readers that come later.
        max_bytes: of these samples.

    Attributes:
        written: samples so far.
        kept: those for readers that come later.
    """

    def __init__(self, domain_id: int, topic: TopicDescription, qos: Qos, *, most: int, max_bytes: int) -> None:
        self.domain_id = domain_id
        self.topic = topic
        self.qos = qos
        self.written = 0
        self.kept = Samples(min(qos.depth or 1, most), max_bytes)


class Reader:
    """A reader of a topic.

    Args:
        domain_id: of its participant.
        topic: what it reads.
        qos: what it asks for.
        most: samples that are kept where its quality of service says nothing, and at most.
        max_bytes: of the samples that are kept.
        guid: only replies to requests of this GUID are for it; None for all samples.

    Attributes:
        waiting: samples that nobody has fetched yet.
        received: samples so far.
        guid: as above.
    """

    def __init__(
        self,
        domain_id: int,
        topic: TopicDescription,
        qos: Qos,
        *,
        most: int,
        max_bytes: int,
        guid: bytes | None = None,
    ) -> None:
        self.domain_id = domain_id
        self.topic = topic
        self.qos = qos
        self.received = 0
        self.waiting = Samples(min(qos.depth or most, most), max_bytes)
        self.guid = guid

    def offer(self, sample: StoredSample) -> bool:
        """Takes a sample; whether it is for this reader."""
        if self.guid is not None and (sample.answers is None or sample.answers.guid != self.guid):
            return False
        self.received += 1
        self.waiting.put(sample)
        return True


class Outside(Protocol):
    """Who is told of all endpoints and of what is written, to hand it on; what comes back is `AgentService.hand`'s."""

    def opened(self, one: Writer | Reader) -> None:
        """An endpoint is there."""

    def closed(self, one: Writer | Reader) -> None:
        """An endpoint is gone."""

    def written(self, writer: Writer, sample: StoredSample) -> None:
        """A sample was written."""


class DataSpace:
    """See the module.

    Attributes:
        outside: whom to tell, from now on; None for nobody.
    """

    def __init__(self) -> None:
        self.outside: Outside | None = None
        self._writers: dict[tuple[int, str], list[Writer]] = {}
        self._readers: dict[tuple[int, str], list[Reader]] = {}

    @property
    def topics(self) -> dict[tuple[int, str], tuple[int, int]]:
        """How many writers and readers each domain and topic has."""
        there = sorted({*self._writers, *self._readers})
        return {key: (len(self._writers.get(key, ())), len(self._readers.get(key, ()))) for key in there}

    @property
    def endpoints(self) -> Iterator[Writer | Reader]:
        """All writers and readers."""
        for writers in self._writers.values():
            yield from writers
        for readers in self._readers.values():
            yield from readers

    def add_writer(self, writer: Writer) -> list[Reader]:
        """Adds a writer; returns the readers of its topic that cannot be served by it."""
        self._writers.setdefault(_key(writer), []).append(writer)
        if self.outside is not None:
            self.outside.opened(writer)
        return [reader for reader in self._readers.get(_key(writer), ()) if not _match(writer, reader)]

    def add_reader(self, reader: Reader) -> list[Writer]:
        """Adds a reader; returns the writers of its topic that cannot serve it. It gets what these keep for it."""
        self._readers.setdefault(_key(reader), []).append(reader)
        if self.outside is not None:
            self.outside.opened(reader)
        writers = self._writers.get(_key(reader), [])
        for writer in writers:
            if reader.qos.durability and _match(writer, reader):
                for sample in writer.kept:
                    reader.offer(sample)
        return [writer for writer in writers if not _match(writer, reader)]

    def remove(self, one: Writer | Reader) -> None:
        """Takes a writer or reader out."""
        there: dict[tuple[int, str], list[Writer]] | dict[tuple[int, str], list[Reader]]
        there = self._writers if isinstance(one, Writer) else self._readers
        group = there[_key(one)]
        group.remove(one)  # type: ignore[arg-type]
        if not group:
            del there[_key(one)]
        if self.outside is not None:
            self.outside.closed(one)

    def write(self, writer: Writer, sample: StoredSample) -> list[Reader]:
        """Hands a sample of a writer on; returns the readers that it has reached."""
        writer.written += 1
        if writer.qos.durability:
            writer.kept.put(sample)
        if self.outside is not None:
            self.outside.written(writer, sample)
        return [reader for reader in self.matched(writer) if reader.offer(sample)]

    def matched(self, writer: Writer) -> Iterator[Reader]:
        """The readers that a writer serves."""
        return (reader for reader in self._readers.get(_key(writer), ()) if _match(writer, reader))


def _key(one: Writer | Reader) -> tuple[int, str]:
    return one.domain_id, one.topic.name


def _match(writer: Writer, reader: Reader) -> bool:
    return writer.topic == reader.topic and writer.qos.suits(reader.qos)
