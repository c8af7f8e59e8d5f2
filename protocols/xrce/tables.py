"""What an agent has to show: its clients, and the topics, services and actions of ROS 2 with what was said last."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from protocols.common.tables import Row, Table, Value
from protocols.xrce.action_server import GoalState
from protocols.xrce.cdr import Library, whole_of
from protocols.xrce.errors import LocalProtocolError, RemoteProtocolError
from protocols.xrce.objects import Participant
from protocols.xrce.ros_names import RosKind, RosName, ros_name, ros_type
from protocols.xrce.service import AgentService
from protocols.xrce.space import Reader, StoredSample, Writer

__all__ = ["AgentTables"]

_MOST_FIELDS, _MOST_PARTS, _MOST_LETTERS, _MOST_BYTES = 32, 4, 60, 8
"""Of what is shown of a sample: fields, values of an array, letters of a string, bytes of an array (choices)."""
_STATUS = "action_msgs/msg/GoalStatusArray"
_TIME = {"sec", "nanosec"}
_STATES = {state.value: state.name.lower() for state in GoalState}


@dataclass(slots=True)
class _Spoken:
    """What was said on a topic.

    Attributes:
        count: how often.
        sample: the last.
    """

    count: int = 0
    sample: StoredSample | None = None


@dataclass(slots=True)
class _Topic:
    """A topic of DDS: its name, what it is in ROS 2, its type, what was said, how many write and read it."""

    name: str
    said: RosName
    type_name: str
    spoken: _Spoken
    writers: int = 0
    readers: int = 0


@dataclass(slots=True)
class _Whole:
    """A topic, service or action of ROS 2: its topics of DDS, by part and half."""

    domain_id: int
    name: str
    topics: dict[tuple[str, str], _Topic] = field(default_factory=dict)


class AgentTables:
    """See the module. It looks at an agent from the first call on.

    Args:
        agent: returns the agent, which may be another one after it was started anew.
        library: definitions of the types.
    """

    def __init__(self, agent: Callable[[], AgentService], library: Library) -> None:
        self._agent, self._library = agent, library
        self._watched: AgentService | None = None
        self._spoken: dict[tuple[int, str], _Spoken] = {}
        self._read: dict[tuple[int, str], tuple[StoredSample, Mapping[str, Value] | str]] = {}

    def look(self) -> Mapping[str, Table]:
        """The tables ``clients``, ``topics``, ``services`` and ``actions``."""
        agent = self._agent()
        if agent is not self._watched:
            self._watched, agent.space.outside = agent, self
            self._spoken.clear()
            self._read.clear()
        there = self._wholes(agent)
        return {
            "clients": Table(columns=("client key", "session", "participants", "objects"), rows=dict(_clients(agent))),
            "topics": Table(columns=("writers", "readers", "type"), rows=self._rows(there[RosKind.TOPIC], self._topic)),
            "services": Table(
                columns=("servers", "clients", "type"), rows=self._rows(there[RosKind.SERVICE], self._service)
            ),
            "actions": Table(
                columns=("goals", "servers", "clients", "type"), rows=self._rows(there[RosKind.ACTION], self._action)
            ),
        }

    # --- what the agent's data space tells

    def opened(self, one: Writer | Reader) -> None:
        """See `protocols.xrce.space.Outside`."""

    def closed(self, one: Writer | Reader) -> None:
        """See `protocols.xrce.space.Outside`."""

    def written(self, writer: Writer, sample: StoredSample) -> None:
        """See `protocols.xrce.space.Outside`."""
        spoken = self._spoken.setdefault((writer.domain_id, writer.topic.name), _Spoken())
        spoken.count += 1
        spoken.sample = sample

    # --- what there is

    def _wholes(self, agent: AgentService) -> Mapping[RosKind, dict[tuple[int, str], _Whole]]:
        """All that has an endpoint; what was said where none is left is forgotten."""
        found: dict[RosKind, dict[tuple[int, str], _Whole]] = {kind: {} for kind in RosKind}
        kept = {}
        for one in agent.space.endpoints:
            name = one.topic.name
            said = ros_name(name) or RosName(RosKind.TOPIC, f"{name} of DDS" if name.startswith("/") else name)
            whole = found[said.kind].setdefault((one.domain_id, said.name), _Whole(one.domain_id, said.name))
            key = one.domain_id, name
            spoken = kept[key] = self._spoken.get(key, _Spoken())
            topic = whole.topics.setdefault((said.part, said.half), _Topic(name, said, one.topic.type_name, spoken))
            if isinstance(one, Writer):
                topic.writers += 1
                topic.type_name = one.topic.type_name
            else:
                topic.readers += 1
        self._spoken = {key: spoken for key, spoken in kept.items() if spoken.count}
        self._read = {key: read for key, read in self._read.items() if key in kept}
        return found

    def _rows(self, wholes: Mapping[tuple[int, str], _Whole], row_of: Callable[[_Whole], Row]) -> dict[str, Row]:
        return {
            _shown(f"{whole.name} in domain {whole.domain_id}" if whole.domain_id else whole.name): row_of(whole)
            for _, whole in sorted(wholes.items())
        }

    def _topic(self, whole: _Whole) -> Row:
        (topic,) = whole.topics.values()
        cells = (str(topic.writers), str(topic.readers), _type(topic))
        return Row(cells=cells, count=topic.spoken.count, last=self._said(whole, topic))

    def _service(self, whole: _Whole) -> Row:
        asks = whole.topics.get(("", "request"))
        last = self._each_said(whole, {"request": ("", "request"), "reply": ("", "reply")})
        return Row(cells=(*_sides(asks), _type_of(whole)), count=asks.spoken.count if asks else 0, last=last)

    def _action(self, whole: _Whole) -> Row:
        asks = whole.topics.get(("send_goal", "request"))
        parts = {"feedback": ("feedback", ""), "goal": ("send_goal", "request"), "result": ("get_result", "reply")}
        last = self._each_said(whole, parts)
        cells = (self._goals(whole), *_sides(asks), _type_of(whole))
        return Row(cells=cells, count=asks.spoken.count if asks else 0, last=last)

    def _goals(self, whole: _Whole) -> str:
        """How many goals are in which state, by what the server has said last."""
        status = whole.topics.get(("status", ""))
        if status is None or status.spoken.sample is None:
            return "none"
        if ros_type(status.type_name) != _STATUS:
            return f"a {_type(status)}"
        message = self._message(status, status.spoken.sample)
        if isinstance(message, str):
            return message
        states = Counter(_STATES.get(one["status"], "unknown") for one in message["status_list"])
        return ", ".join(f"{count} {state}" for state, count in states.items()) or "none"

    # --- what was said

    def _each_said(self, whole: _Whole, parts: Mapping[str, tuple[str, str]]) -> Mapping[str, Value] | str:
        """What was said last in each of several parts, by the names of these; in words where none can be read."""
        fields: dict[str, Value] = {}
        words = ""
        for name, part in parts.items():
            topic = whole.topics.get(part)
            said = self._said(whole, topic) if topic is not None else ""
            if isinstance(said, str):
                words = words or said
            else:
                fields |= {_joined(name, one): value for one, value in said.items()}
        return fields or words

    def _said(self, whole: _Whole, topic: _Topic) -> Mapping[str, Value] | str:
        sample = topic.spoken.sample
        if sample is None:
            return ""
        key = whole.domain_id, topic.name
        if key not in self._read or self._read[key][0] is not sample:
            message = self._message(topic, sample)
            self._read[key] = sample, message if isinstance(message, str) else _flat(message, topic.said)
        return self._read[key][1]

    def _message(self, topic: _Topic, sample: StoredSample) -> Mapping[str, Any] | str:
        """A sample by the definition of its type, or in words."""
        size = f"{len(sample.data)} byte{'s' * (len(sample.data) != 1)}"
        name = ros_type(topic.type_name)
        if name is None:
            return f"{size}; the type is none of ROS 2"
        try:
            return self._library.decode(name, sample.data, little_endian=sample.little_endian)
        except LocalProtocolError as error:
            return f"{size}; {error}"
        except RemoteProtocolError as error:
            return f"{size} that make no {name}: {error}"


def _clients(agent: AgentService) -> Iterator[tuple[str, Row]]:
    for line, client in agent.clients.items():
        entities = agent.objects[line].values()
        domains = Counter(one.domain_id for one in entities if isinstance(one.object, Participant))
        participants = ", ".join(
            f"{count} in domain {domain_id}" if domain_id else str(count)
            for domain_id, count in sorted(domains.items())
        )
        cells = (
            client.client_key.hex(" ").upper(),
            f"0x{client.session_id:02X}",
            participants or "none",
            str(len(entities)),
        )
        yield line, Row(cells=cells, count=sum(one.writer.written for one in entities if one.writer is not None))


def _sides(asks: _Topic | None) -> tuple[str, str]:
    """How many serve, and how many ask."""
    return ("0", "0") if asks is None else (str(asks.readers), str(asks.writers))


def _type(topic: _Topic) -> str:
    name = ros_type(topic.type_name)
    return _shown(topic.type_name) if name is None else whole_of(name)


def _type_of(whole: _Whole) -> str:
    """The type of a service or an action, by a topic that is of this type: not each of an action's is."""
    asks = ("", "request"), ("send_goal", "request")
    return _type(min(whole.topics.items(), key=lambda one: one[0] not in asks)[1])


def _shown(text: str) -> str:
    """A text of a client's for a terminal: what is no letter there stands as an escape."""
    return text if text.isprintable() else repr(text)[1:-1]


def _joined(*names: str) -> str:
    return ".".join(name for name in names if name)


def _flat(message: Mapping[str, Any], said: RosName) -> Mapping[str, Value]:
    """The fields of a message, those of messages in it behind a dot, stamps last; of an action without ids of goals."""
    if said.kind is RosKind.ACTION:
        message = {name: value for name, value in message.items() if name != "goal_id"}
        if len(message) == 1:
            (message,) = message.values()
    fields = sorted(_fields("", message), key=lambda one: "stamp" in one[0] or one[0].startswith("header."))
    left_out = len(fields) - _MOST_FIELDS
    more: list[tuple[str, Value]] = [("more", f"{left_out} fields")] if left_out > 0 else []
    return dict([*fields[:_MOST_FIELDS], *more])


def _fields(name: str, value: Any) -> Iterator[tuple[str, Value]]:
    match value:
        case Mapping() if name and value.keys() == _TIME:
            yield name, f"{value['sec']}.{value['nanosec']:09d} s"
        case Mapping():
            for part, inner in value.items():
                yield from _fields(_joined(name, part), inner)
        case list() if len(value) <= _MOST_PARTS:
            for number, inner in enumerate(value):
                yield from _fields(f"{name}[{number}]", inner)
        case list():
            yield name, f"{len(value)} values"
        case bytes():
            shown = value[:_MOST_BYTES].hex(" ").upper()
            yield name, shown if len(value) <= _MOST_BYTES else f"{shown} ... {len(value)} bytes"
        case str():
            yield name, _shown(value if len(value) <= _MOST_LETTERS else f"{value[: _MOST_LETTERS - 1]}…")
        case float() if not math.isfinite(value):
            yield name, str(value)
        case _:
            yield name, value
