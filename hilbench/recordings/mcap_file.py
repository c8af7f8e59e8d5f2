"""A recording as MCAP (mcap.dev/spec), which Foxglove opens: a channel for each source and kind of event.

Each event of the journal is one JSON message, as it stands there. Besides there are the frames in the bytes, where a
protocol is known, the samples of topics of ROS 2 in them as `ros2 bag` has them (mcap.dev/spec/registry: cdr, ros2msg),
and poses and a log in the form that Foxglove's panels take. Chunks are not compressed: of a file
that was cut, everything up to there can be read, even in the last chunk.
"""

from __future__ import annotations

import io
import struct
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, cast

import msgspec
from mcap.exceptions import McapError

from hilbench.journal import Recording
from hilbench.plugins.protocol import ProtocolPlugin, TopicSample
from hilbench.recordings.frames import Framed, framed
from hilbench.recordings.layout import Event, json_bytes, laid_out
from hilbench.recordings.lines import plain
from hilbench.recordings.mcap_schemas import (
    EVENT_SCHEMA,
    FOXGLOVE_SCHEMAS,
    FRAME_SCHEMA,
    LOG,
    POSE,
    event_schema,
    frame_schema,
    log_of,
    pose_of,
)

if TYPE_CHECKING:
    from mcap.writer import Writer
    from typing_extensions import Buffer

__all__ = ["MAGIC", "Messages", "read_mcap", "write_mcap", "write_ros2"]

MAGIC = b"\x89MCAP0\r\n"

_CHUNK_BYTES = 256 * 1024
_HEADER_NAME = "hilbench"
_SCHEMA, _CHANNEL, _MESSAGE, _CHUNK, _METADATA, _FOOTER = 3, 4, 5, 6, 12, 2
_RECORD_HEAD = 9


@dataclass(frozen=True, slots=True)
class Messages:
    """What was written: events of the journal, samples of topics, and names of types whose definition is not known."""

    events: int
    samples: int = 0
    unknown: Sequence[str] = ()


def write_mcap(
    recording: Recording, file: IO[bytes], protocol: ProtocolPlugin | None = None, folders: Sequence[Path] = ()
) -> Messages:
    """Write a recording.

    Args:
        recording: what is written.
        file: where to; a pipe will do, for it is only written to.
        protocol: what is spoken on its lines; None for no frames.
        folders: with definitions of types of topics, see `hilbench.plugins.protocol.ProtocolPlugin.samples`.

    Returns:
        How much was written, each event of the journal as one message.
    """
    writer = _begun(recording, file)
    writer.add_metadata(_HEADER_NAME, {"header": json_bytes(dict(recording.header)).decode()})
    channels = _Channels(writer)
    events = list(laid_out(recording.events))
    streams = [_messages(channels, events)]
    written = Messages(len(events))
    if protocol is not None:
        frames: Iterable[Framed] = framed(events, protocol)
        if protocol.samples is not None:
            frames = list(frames)
            samples, unknown = protocol.samples(frames, folders)
            streams.append(_samples(channels, samples))
            written = Messages(len(events), len(samples), unknown)
        streams.append(_frames(channels, frames))
    _finish(writer, _merged(streams))
    return written


def write_ros2(recording: Recording, file: IO[bytes], samples: Sequence[TopicSample]) -> None:
    """Write the topics of a recording alone, by the profile ``ros2`` (mcap.dev/spec/registry), as ``ros2 bag`` does."""
    writer = _begun(recording, file, profile="ros2")
    _finish(writer, _samples(_Channels(writer), samples))


def _begun(recording: Recording, file: IO[bytes], *, profile: str = "") -> Writer:
    from mcap.writer import CompressionType, Writer

    counted = cast("IO[bytes]", _Counted(file))
    writer = Writer(counted, chunk_size=_CHUNK_BYTES, compression=CompressionType.NONE)
    writer.start(profile=profile, library=f"hilbench {recording.header.get('hilbench', '')}")
    return writer


def _finish(writer: Writer, messages: Iterator[Message]) -> None:
    for sequence, (ns, channel, data) in enumerate(messages):
        writer.add_message(channel, log_time=ns, data=data, publish_time=ns, sequence=sequence)
    writer.finish()  # type: ignore[no-untyped-call]


class _Counted(io.BufferedIOBase):
    """A file that knows how far it is written, also where the system cannot tell, as of a pipe: indexes hold places.

    MCAP is written from its beginning to its end, and nothing is ever changed (mcap.dev/spec, "Summary Section").
    """

    def __init__(self, file: IO[bytes]) -> None:
        self._file = file
        self._at = 0

    def write(self, data: Buffer, /) -> int:
        count = self._file.write(data)
        self._at += count
        return count

    def tell(self) -> int:
        return self._at


Message = tuple[int, int, bytes]
"""Time, channel, data."""


def _merged(streams: list[Iterator[Message]]) -> Iterator[Message]:
    from heapq import merge

    return merge(*streams, key=lambda message: message[0])


def _messages(channels: _Channels, events: list[tuple[int, Event]]) -> Iterator[Message]:
    for ns, event in events:
        kind = str(event["kind"])
        yield (
            ns,
            channels.of(f"/{_path(event)}/{kind}", EVENT_SCHEMA + kind, event_schema(kind)),
            json_bytes(dict(event)),
        )
        for topic, schema, made in (("/log", LOG, log_of(ns, event)), ("/pose", POSE, pose_of(ns, event))):
            if made is not None:
                yield ns, channels.of(topic, schema, FOXGLOVE_SCHEMAS[schema]), json_bytes(made)


def _frames(channels: _Channels, frames: Iterable[Framed]) -> Iterator[Message]:
    for one in frames:
        said = {
            "name": one.item.name,
            "kind": one.item.kind.value,
            "fields": {name: plain(value) for name, value in one.item.fields.items()},
            "raw": one.item.raw.hex(),
        }
        path = _path({"source": one.source, "line": one.line})
        yield one.ns, channels.of(f"/{path}/{one.kind}/frames", FRAME_SCHEMA, frame_schema()), json_bytes(said)


def _samples(channels: _Channels, samples: Iterable[TopicSample]) -> Iterator[Message]:
    for one in samples:
        yield one.ns, channels.of_topic(one.topic, one.type_name, one.definition), one.data


def _path(event: Event) -> str:
    """Return whose channels those of an event are: of a source, or of one of its lines."""
    source, line = str(event.get("source", "")), event.get("line")
    return "/".join((*source.split("."), *([line] if isinstance(line, str) and line else [])))


class _Channels:
    """Makes channels and schemas as they are needed."""

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        self._schemas: dict[str, int] = {}
        self._channels: dict[tuple[str, str], int] = {}

    def of(self, topic: str, schema: str, shape: Mapping[str, Any]) -> int:
        """Return the channel of a topic with messages in JSON."""
        return self._of(topic, schema, "json", "jsonschema", json_bytes(dict(shape)), {})

    def of_topic(self, topic: str, type_name: str, definition: str | None) -> int:
        """Return the channel of a topic of ROS 2; without a definition it has none that a reader could use."""
        quality = {"offered_qos_profiles": ""}  # not known; readers of the profile look for it
        encoding = "" if definition is None else "ros2msg"
        return self._of(topic, type_name, "cdr", encoding, (definition or "").encode(), quality)

    def _of(
        self, topic: str, schema: str, encoding: str, schema_encoding: str, described: bytes, about: dict[str, str]
    ) -> int:
        if schema not in self._schemas:
            self._schemas[schema] = self._writer.register_schema(schema, schema_encoding, described)
        if (topic, schema) not in self._channels:
            self._channels[topic, schema] = self._writer.register_channel(topic, encoding, self._schemas[schema], about)
        return self._channels[topic, schema]


# --- reading


def read_mcap(data: bytes) -> Recording:
    """Read the events of a file that `write_mcap` has written; other messages are passed over.

    A file that was cut is read up to there.
    """
    reader = _Reader()
    problem = reader.read(data)
    events = tuple(event for _, event in sorted(reader.events, key=lambda pair: pair[0]))
    ended = bool(events) and events[-1]["kind"] == "host-end"
    return Recording(header=reader.header, events=events, problem=problem, ended=ended)


class _Reader:
    """Takes the records of a file."""

    def __init__(self) -> None:
        self.header: dict[str, Any] = {}
        self.events: list[tuple[int, Event]] = []
        self._schemas: dict[int, str] = {}
        self._channels: dict[int, str] = {}

    def read(self, data: bytes) -> str | None:
        """Take all of them; return what ended the reading before the end of the file."""
        at = len(MAGIC)
        while True:
            record = _record(data, at)
            if record is None:
                return f"cut at byte {len(data)}" if data else "the file is empty"
            code, body, end = record
            whole = end <= len(data)
            try:
                self._take(code, body, whole=whole)
            except _DamagedError as error:
                return f"the chunk at byte {at} is damaged: {error}"
            except _UNREADABLE as error:
                return f"the record at byte {at} cannot be read: {type(error).__name__}"
            if not whole:
                return f"cut at byte {len(data)}"
            if code == _FOOTER:
                return None
            at = end

    def _take(self, code: int, body: bytes, *, whole: bool) -> None:
        if code == _CHUNK:
            for inner, content in _records(_unpacked(body, whole=whole), whole=whole):
                self._take(inner, content, whole=True)
        elif not whole:
            return
        elif code == _METADATA:
            self._take_header(body)
        elif code in {_SCHEMA, _CHANNEL, _MESSAGE}:
            self._take_message(code, body)

    def _take_header(self, body: bytes) -> None:
        from mcap.data_stream import ReadDataStream
        from mcap.records import Metadata

        found = Metadata.read(ReadDataStream(io.BytesIO(body)))
        if found.name == _HEADER_NAME:
            self.header = msgspec.json.decode(found.metadata["header"], type=dict[str, Any])

    def _take_message(self, code: int, body: bytes) -> None:
        from mcap.data_stream import ReadDataStream
        from mcap.records import Channel, Message, Schema

        stream = ReadDataStream(io.BytesIO(body))
        if code == _SCHEMA:
            schema = Schema.read(stream)
            self._schemas[schema.id] = schema.name
        elif code == _CHANNEL:
            channel = Channel.read(stream)
            self._channels[channel.id] = self._schemas.get(channel.schema_id, "")
        else:
            message = Message.read(stream, len(body))
            if self._channels.get(message.channel_id, "").startswith(EVENT_SCHEMA):
                event = msgspec.json.decode(message.data, type=dict[str, Any])
                self.events.append((message.sequence, event))


_UNREADABLE = (ValueError, KeyError, struct.error, OverflowError, McapError, msgspec.DecodeError, RecursionError)


def _record(data: bytes, at: int) -> tuple[int, bytes, int] | None:
    """Return code, body and end of the record that begins here, whole or not; None if even its head is cut."""
    if len(data) < at + _RECORD_HEAD:
        return None
    code, length = struct.unpack_from("<BQ", data, at)
    begin = at + _RECORD_HEAD
    return code, data[begin : begin + length], begin + length


class _DamagedError(ValueError):
    """A chunk is all there, and not what was written."""


def _records(data: bytes, *, whole: bool) -> Iterator[tuple[int, bytes]]:
    """Yield the whole records of a chunk; if it is not cut, they end where it does.

    Raises:
        _DamagedError: they do not.
    """
    at = 0
    while (record := _record(data, at)) is not None and record[2] <= len(data):
        code, body, at = record
        yield code, body
    if whole and at != len(data):
        raise _DamagedError(f"it holds no whole record at its byte {at}")


def _unpacked(body: bytes, *, whole: bool) -> bytes:
    """Return the records of a chunk; of one that is cut what there is, if it is not compressed.

    Raises:
        _DamagedError: they are not those that were written.
        ValueError: they cannot be unpacked.
    """
    if not whole:
        if len(body) < 32:
            return b""
        name_length = struct.unpack_from("<I", body, 28)[0]
        return b"" if name_length else body[40:]
    from mcap.data_stream import ReadDataStream
    from mcap.records import Chunk
    from mcap.stream_reader import CRCValidationError, get_chunk_data_stream

    chunk = Chunk.read(ReadDataStream(io.BytesIO(body)))
    try:
        stream, length = get_chunk_data_stream(chunk, validate_crc=True)
        return bytes(stream.read(length))
    except CRCValidationError as error:
        raise _DamagedError("its CRC is wrong") from error
    except Exception as error:
        raise ValueError(str(error)) from error
