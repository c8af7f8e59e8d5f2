"""The samples in a recording of DDS-XRCE, by topic: what clients write, and what they read if none of them writes it.

An agent that nobody answers to hears what the clients say, and so finds out what they create and write, whatever is
repeated or comes in pieces. It is not known where a client refers to a profile of the recorded agent's configuration.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from hilbench.errors import UsageError
from hilbench.plugins.protocol import Heard, TopicSample
from protocols import xrce
from protocols.common.items import Kind
from protocols.xrce.cdr import INTERFACES, encapsulate, full_text, parse_message
from protocols.xrce.decoding import Message

__all__ = ["message_of", "samples_in"]

_TOPIC = re.compile(r"rt(/[\w/]+)", re.ASCII)
_TYPE = re.compile(r"([A-Za-z]\w{0,200})::msg::dds_::([A-Za-z]\w{0,200})_", re.ASCII)
"""``rt/speed``, ``std_msgs::msg::dds_::Float32_`` (ROS 2, topic and service name mapping to DDS); fit for files."""
_EITHER = xrce.AgentOptions(frames=xrce.FramingOptions(framing=xrce.Framing.EITHER))
_OF_CLIENTS = (xrce.CreateClient, xrce.Create, xrce.WriteData, xrce.ReadData)

_Said = tuple[int, xrce.TopicDescription, bytes, bool]
"""Time in ns, topic, data, whether they are little-endian."""


def samples_in(frames: Sequence[Heard], folders: Sequence[Path]) -> tuple[list[TopicSample], list[str]]:
    """Return the samples of topics of ROS 2 in order, and the names of types, or of types in them, that are not known.

    Topics and types that have no names of ROS 2 are left out.

    Args:
        frames: of the recording.
        folders: with definitions of types, as ``share`` of an installed ROS 2: ``PACKAGE/msg/NAME.msg`` in them.

    Raises:
        UsageError: a definition there cannot be read.
    """
    listener = _Listener(frames)
    texts: dict[str, str | None] = {}
    unknown: dict[str, None] = {}
    text_of = _texts(folders, unknown)
    found = []
    for ns, topic, data, little_endian in listener.samples():
        of_topic, name = _TOPIC.fullmatch(topic.name), message_of(topic.type_name)
        if of_topic is None or name is None:
            continue
        if name not in texts:
            try:
                texts[name] = full_text(name, text_of)
            except xrce.LocalProtocolError:
                texts[name] = None
        found.append(
            TopicSample(
                ns=ns,
                topic=of_topic[1],
                type_name=name,
                definition=texts[name],
                data=encapsulate(data, little_endian=little_endian),
            )
        )
    return found, list(unknown)


def message_of(type_name: str) -> str | None:
    """Return ``std_msgs/msg/Float32`` of ``std_msgs::msg::dds_::Float32_``; None of what ROS 2 names otherwise."""
    found = _TYPE.fullmatch(type_name)
    return None if found is None else "/msg/".join(found.groups())


def _texts(folders: Sequence[Path], unknown: dict[str, None]) -> Callable[[str], str | None]:
    """Return what returns a definition, and takes the names of those that it does not find."""

    def text_of(name: str) -> str | None:
        for folder in folders:
            path = folder / f"{name}.msg"
            try:
                text = path.read_text(encoding="utf-8-sig")
                parse_message(name, text)
            except FileNotFoundError:
                continue
            except (OSError, UnicodeDecodeError, xrce.LocalProtocolError) as error:
                raise UsageError(f"cannot be read: {error}", where=str(path)) from None
            return text
        if name not in INTERFACES:
            unknown[name] = None
        return INTERFACES.get(name)

    return text_of


class _Listener:
    """See the module."""

    def __init__(self, frames: Sequence[Heard]) -> None:
        self._frames = [one for one in frames if isinstance(one.item.message, Message) and one.item.kind is Kind.FRAME]
        said = {(one.source, one.line, one.kind) for one in self._frames}
        whole = {(source, line) for source, line, _ in said if {(source, line, "tx"), (source, line, "rx")} <= said}
        # An end of a line of which both directions are there tells all; what the other end has sent would come twice.
        self._frames = [one for one in self._frames if not whole or (one.source, one.line) in whole]
        self._agent = xrce.AgentService(sorted({_line(one) for one in self._frames}), _EITHER)
        self._agent.space.outside = self
        self._of_client: dict[str, tuple[str, str]] = {}
        self._clients: dict[str, xrce.Session] = {}
        self._written: set[str] = set()
        self._samples: list[tuple[_Said, object]] = []
        self._ns = 0

    def samples(self) -> Iterator[_Said]:
        """Yield what was written, and what was read of topics that no client writes: there by one reader."""
        for one in self._frames:
            self._ns = one.ns
            self._take(one, _line(one))
        first: dict[str, object] = {}
        for said, reader in self._samples:
            topic = said[1].name
            if reader is None or (topic not in self._written and first.setdefault(topic, reader) == reader):
                yield said

    def _take(self, one: Heard, line: str) -> None:
        """Take a frame: of the client, or of the agent."""
        if any(isinstance(said, _OF_CLIENTS) for said in _message(one).submessages):
            self._of_client[line] = one.source, one.kind
        if self._of_client.get(line) == (one.source, one.kind):
            self._agent.receive(line, one.item.raw, one.ns)
            for told in self._agent.take_events():
                if isinstance(told, xrce.ClientEvent) and isinstance(told.event, xrce.SessionOpened):
                    assert isinstance(told.event.peer, xrce.Client)
                    self._clients[line] = _client_like(told.event.peer, one)
        elif line in self._clients:
            for event in self._clients[line].receive(one.item.raw, one.ns):
                if isinstance(event, xrce.Received) and isinstance(event.submessage, xrce.TopicData):
                    self._read(line, event.submessage)

    def _read(self, line: str, said: xrce.TopicData) -> None:
        entity = self._agent.objects[line].get(said.object_id)
        if entity is not None and entity.reader is not None and isinstance(said.data, bytes):
            read = self._ns, entity.reader.topic, said.data, said.little_endian
            self._samples.append((read, (line, said.object_id)))

    # --- what the agent's data space tells

    def opened(self, one: xrce.Writer | xrce.Reader) -> None:
        """See `protocols.xrce.space.Outside`."""

    def closed(self, one: xrce.Writer | xrce.Reader) -> None:
        """See `protocols.xrce.space.Outside`."""

    def written(self, writer: xrce.Writer, sample: xrce.StoredSample) -> None:
        """See `protocols.xrce.space.Outside`."""
        self._written.add(writer.topic.name)
        self._samples.append(((self._ns, writer.topic, sample.data, sample.little_endian), None))


def _message(one: Heard) -> Message:
    assert isinstance(one.item.message, Message)
    return one.item.message


def _line(one: Heard) -> str:
    return f"{one.source}.{one.line}"


def _client_like(client: xrce.Client, said: Heard) -> xrce.Session:
    """Return a client that waits for the answer to what this one has said."""
    framing = xrce.Framing.SERIAL if said.item.raw[:1] == b"\x7e" else xrce.Framing.LENGTH
    options = xrce.ClientOptions(
        client_key=client.client_key, session_id=client.session_id, frames=xrce.FramingOptions(framing=framing)
    )
    made = xrce.Session(xrce.Role.CLIENT, options)
    made.connect(said.ns)
    return made
