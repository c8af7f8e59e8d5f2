"""What the objects of a client are in DDS: topics, endpoints with their quality of service, services.

They come in three representations: in binary, in the XML of Fast DDS's profiles (an endpoint in XML names its topic
itself), and by reference, which is the name of such a profile in the agent's configuration. Defaults are those of Fast
DDS (Fast-DDS, include/fastdds/rtps/attributes): a writer is reliable and keeps samples for readers that come later, a
reader is best-effort and wants none from before its time.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from xml.etree import ElementTree
from xml.etree.ElementTree import Element

from protocols.xrce.codes import QosFlag
from protocols.xrce.errors import LocalProtocolError, RemoteProtocolError
from protocols.xrce.objects import (
    AsXml,
    ByReference,
    DataReaderQos,
    DataWriterQos,
    ReplierBinary,
    RequesterBinary,
    TopicBinary,
)

__all__ = [
    "Durability",
    "EndpointDescription",
    "Profiles",
    "Qos",
    "ServiceDescription",
    "TopicDescription",
    "UnknownProfileError",
    "reader_qos",
    "writer_qos",
]

Durability = int
"""0 volatile, 1 transient local, 2 transient, 3 persistent: a reader may ask for no more than its writer has."""

_DURABILITIES: Mapping[str, Durability] = MappingProxyType(
    {"VOLATILE": 0, "TRANSIENT_LOCAL": 1, "TRANSIENT": 2, "PERSISTENT": 3}
)
_MOST_DEPTH = 0xFFFF


class UnknownProfileError(RemoteProtocolError):
    """A client refers to something that the agent's configuration does not have."""


@dataclass(frozen=True, slots=True)
class TopicDescription:
    """A topic, such as ``rt/chatter`` of ``std_msgs::msg::dds_::String_``."""

    name: str
    type_name: str


@dataclass(frozen=True, slots=True, kw_only=True)
class Qos:
    """What an endpoint offers or asks for.

    Attributes:
        reliable: no sample may be lost.
        durability: see `Durability`.
        depth: how many samples are kept for somebody who is slow, or None for whatever the agent has.
    """

    reliable: bool
    durability: Durability = 0
    depth: int | None = None

    def suits(self, asked: Qos) -> bool:
        """A reader that asks for this can be served by a writer that offers `self`."""
        return self.reliable >= asked.reliable and self.durability >= asked.durability


_WRITER_DEFAULT = Qos(reliable=True, durability=1)
_READER_DEFAULT = Qos(reliable=False)


@dataclass(frozen=True, slots=True)
class EndpointDescription:
    """A data writer or reader that names its topic itself."""

    topic: TopicDescription
    qos: Qos


@dataclass(frozen=True, slots=True)
class ServiceDescription:
    """The two topics of a service."""

    request: TopicDescription
    reply: TopicDescription


def writer_qos(said: DataWriterQos | None) -> Qos:
    """What a data writer in binary offers."""
    return _WRITER_DEFAULT if said is None else _qos_in_binary(said)


def reader_qos(said: DataReaderQos | None) -> Qos:
    """What a data reader in binary asks for."""
    return _READER_DEFAULT if said is None else _qos_in_binary(said)


def _qos_in_binary(said: DataWriterQos | DataReaderQos) -> Qos:
    levels = (QosFlag.DURABILITY_TRANSIENT_LOCAL, QosFlag.DURABILITY_TRANSIENT, QosFlag.DURABILITY_PERSISTENT)
    durability = max((level for level, flag in enumerate(levels, 1) if said.flags & flag), default=0)
    return Qos(reliable=bool(said.flags & QosFlag.RELIABLE), durability=durability, depth=said.history_depth or None)


class Profiles:
    """Reads descriptions, and knows the profiles of the agent's configuration.

    Args:
        text: the configuration: XML with elements ``participant``, ``topic``, ``data_writer``, ``data_reader``,
            ``requester`` and ``replier``, each with a ``profile_name``, as Micro-XRCE-DDS-Agent's ``agent.refs``; empty
            for none.

    Raises:
        LocalProtocolError: it is no such XML.
    """

    def __init__(self, text: str = "") -> None:
        try:
            elements = [] if not text else [*_root(text).iter()]
        except RemoteProtocolError as error:
            raise LocalProtocolError(f"references: {error}") from None
        self._profiles = {(one.tag, one.get("profile_name")): one for one in elements if one.get("profile_name")}

    def check_participant(self, said: AsXml | ByReference) -> None:
        """Accepts a participant: any well-formed XML, and any name, as nothing depends on it.

        Raises:
            RemoteProtocolError: it is no XML.
        """
        if isinstance(said, AsXml) and said.text:
            _root(said.text)

    def topic(self, said: AsXml | ByReference | TopicBinary) -> TopicDescription:
        """The topic that a client means.

        Raises:
            RemoteProtocolError: it makes no sense, or there is no such profile.
        """
        if isinstance(said, TopicBinary):
            return TopicDescription(said.topic_name, said.type_name or said.type_reference or "")
        return _topic_in(self._element("topic", said))

    def writer(self, said: AsXml | ByReference) -> EndpointDescription:
        """The data writer that a client means.

        Raises:
            RemoteProtocolError: it makes no sense, or there is no such profile.
        """
        return _endpoint_in(self._element("data_writer", said), _WRITER_DEFAULT)

    def reader(self, said: AsXml | ByReference) -> EndpointDescription:
        """The data reader that a client means.

        Raises:
            RemoteProtocolError: it makes no sense, or there is no such profile.
        """
        return _endpoint_in(self._element("data_reader", said), _READER_DEFAULT)

    def service(self, tag: str, said: AsXml | ByReference | RequesterBinary | ReplierBinary) -> ServiceDescription:
        """The service that a client means.

        Args:
            tag: ``requester`` or ``replier``.
            said: how the client says it.

        Raises:
            RemoteProtocolError: it makes no sense, or there is no such profile.
        """
        if isinstance(said, RequesterBinary | ReplierBinary):
            names = (said.request_topic_name, said.reply_topic_name)
            return _service(said.service_name, (said.request_type, said.reply_type), names)
        element = self._element(tag, said)
        service, *types = (_attribute(element, name) for name in ("service_name", "request_type", "reply_type"))
        request, reply = (element.findtext(name) for name in ("request_topic_name", "reply_topic_name"))
        return _service(service, (types[0], types[1]), (request, reply))

    def _element(self, tag: str, said: AsXml | ByReference) -> Element:
        if isinstance(said, ByReference):
            found = self._profiles.get((tag, said.name))
            if found is None:
                raise UnknownProfileError(f"no {tag} '{said.name}' in the agent's configuration")
            return found
        found = next(_root(said.text).iter(tag), None)
        if found is None:
            raise RemoteProtocolError(f"no element {tag}")
        return found


def _service(service: str, types: tuple[str, str], names: tuple[str | None, str | None]) -> ServiceDescription:
    """Names of topics that are not said are Fast DDS's (Micro-XRCE-DDS-Agent, FastDDSEntities.cpp)."""
    return ServiceDescription(
        TopicDescription(names[0] or f"{service}_Request", types[0]),
        TopicDescription(names[1] or f"{service}_Reply", types[1]),
    )


def _root(text: str) -> Element:
    """The root of an XML text, names without namespaces; entities, which could make it huge, are refused."""
    if "<!DOCTYPE" in text:
        raise RemoteProtocolError("XML with a document type, which no profile needs")
    try:
        root = ElementTree.fromstring(text)  # noqa: S314 - without a document type there are no entities
    except (ElementTree.ParseError, LookupError, ValueError) as error:
        raise RemoteProtocolError(f"no XML: {error}") from None
    for one in root.iter():
        one.tag = one.tag.rpartition("}")[2]
    return root


def _topic_in(element: Element) -> TopicDescription:
    name, type_name = element.findtext("name"), element.findtext("dataType")
    if not name:
        raise RemoteProtocolError(f"{element.tag} without a name")
    return TopicDescription(name.strip(), (type_name or "").strip())


def _endpoint_in(element: Element, default: Qos) -> EndpointDescription:
    topic = element.find("topic")
    if topic is None:
        raise RemoteProtocolError(f"{element.tag} without a topic")
    reliability = element.findtext("qos/reliability/kind")
    durability = element.findtext("qos/durability/kind")
    depth = topic.findtext("historyQos/depth") if topic.findtext("historyQos/kind") != "KEEP_ALL" else None
    return EndpointDescription(
        _topic_in(topic),
        Qos(
            reliable=default.reliable if reliability is None else reliability.strip() == "RELIABLE",
            durability=default.durability if durability is None else _durability(durability.strip()),
            depth=None if depth is None else _depth(depth.strip()),
        ),
    )


def _durability(kind: str) -> Durability:
    if kind not in _DURABILITIES:
        raise RemoteProtocolError(f"durability '{kind}' is none of {', '.join(_DURABILITIES)}")
    return _DURABILITIES[kind]


def _depth(text: str) -> int:
    if not (text.isascii() and text.isdigit() and len(text) <= len(str(_MOST_DEPTH))):
        raise RemoteProtocolError(f"depth '{text}' is no number")
    return max(1, min(int(text), _MOST_DEPTH))


def _attribute(element: Element, name: str) -> str:
    found = element.get(name)
    if not found:
        raise RemoteProtocolError(f"{element.tag} without a {name}")
    return found
