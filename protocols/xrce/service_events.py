"""What an agent reports of its clients, beside what their sessions report."""

from __future__ import annotations

from dataclasses import dataclass

from protocols.xrce.codes import Status
from protocols.xrce.entities import Mismatch
from protocols.xrce.events import Event

__all__ = [
    "AgentEvent",
    "ClientEvent",
    "Mismatch",
    "ObjectCreated",
    "ObjectDeleted",
    "RequestFailed",
    "SampleRouted",
    "SampleTooLong",
]


@dataclass(frozen=True, slots=True, kw_only=True)
class ClientEvent:
    """What a session reports.

    Attributes:
        line: at which it is.
        what: the name of what it reports, for who reads a journal.
        event: what it reports.
    """

    line: str
    what: str
    event: Event


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectCreated:
    """A client has created an object, in the place of another one of that id if there was one.

    Attributes:
        line: of the client.
        object_id: of the object.
        kind: what it is, such as ``DataWriter``.
        topic: that it is for, a service's topic for requests; empty where it is for none.
        type_name: of that topic.
    """

    line: str
    object_id: int
    kind: str
    topic: str = ""
    type_name: str = ""


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectDeleted:
    """A client has deleted an object, and with it all that belonged to it."""

    line: str
    object_id: int


@dataclass(frozen=True, slots=True, kw_only=True)
class RequestFailed:
    """A request of a client was answered with an error."""

    line: str
    request_id: int
    object_id: int
    status: Status


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleRouted:
    """A sample of a client, of a program beside the agent, or from outside.

    Attributes:
        line: of the client; empty for the others.
        domain_id: of its participant.
        topic: its name.
        size: of the data, in bytes.
        readers: how many it has reached.
    """

    line: str
    domain_id: int
    topic: str
    size: int
    readers: int


@dataclass(frozen=True, slots=True, kw_only=True)
class SampleTooLong:
    """A sample is longer than the stream takes on which a client wants it, and is left out.

    Attributes:
        line: of the client.
        object_id: of what it reads by.
        stream_id: a best-effort stream takes one message, a reliable one what may wait on it.
        topic: its name.
        size: of what the client would have got, in bytes.
    """

    line: str
    object_id: int
    stream_id: int
    topic: str
    size: int


AgentEvent = ClientEvent | ObjectCreated | ObjectDeleted | RequestFailed | SampleRouted | SampleTooLong | Mismatch
