"""The driving stack's messages as samples of ROS 2: topics and types of the original, in CDR."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from protocols.autoware import MESSAGES, ControlModeRequest, ControlModeResponse, FieldSpec, Message, Time, WireType
from protocols.xrce import TopicDescription
from protocols.xrce.cdr import INTERFACES, SERVICES, MessageTypes, definition_of, parse_service

__all__ = ["decode_sample", "encode_sample", "topic_of"]

_NAME = "autoware_auto_vehicle_msgs/srv/ControlModeCommand"
_SERVICE = parse_service(_NAME, SERVICES[_NAME])

_TYPES = MessageTypes()
for _definition in (*map(definition_of, INTERFACES), _SERVICE.request, _SERVICE.response):
    _TYPES.add(_definition)

_HALVES = {
    ControlModeRequest: (_SERVICE.request, "rq", "Request"),
    ControlModeResponse: (_SERVICE.response, "rr", "Reply"),
}


def topic_of(kind: type[Message]) -> TopicDescription:
    """Return the topic of a message as DDS names it, and its type (ROS 2, topic and service name mapping to DDS).

    Raises:
        KeyError: the message has none.
    """
    spec = MESSAGES[kind]
    if not spec.topic:
        raise KeyError(kind.__name__)
    prefix, suffix = ("rt", "") if kind not in _HALVES else _HALVES[kind][1:]
    package, family, name = _name_of(kind).split("/")
    return TopicDescription(f"{prefix}{spec.topic}{suffix}", f"{package}::{family}::dds_::{name}_")


def encode_sample(message: Message) -> bytes:
    """Return a message in CDR, little-endian, without a header.

    Raises:
        LocalProtocolError: of protocols.xrce: a number does not fit.
    """
    fields: dict[str, Any] = {}
    for spec in _sent(type(message)):
        *path, last = spec.original.split(".")
        where = fields
        for step in path:
            where = where.setdefault(step, {})
        where[last] = _out(getattr(message, spec.name))
    return _TYPES.encode(_name_of(type(message)), fields)


def decode_sample(kind: type[Message], data: bytes, *, little_endian: bool = True) -> Message:
    """Return what a sample says; the number of a request or response is 0, as it does not stand in it.

    Raises:
        RemoteProtocolError: of protocols.xrce: it makes no sense.
    """
    fields = _TYPES.decode(_name_of(kind), data, little_endian=little_endian)
    return kind(**{spec.name: _in(spec, fields) for spec in _sent(kind)})


def _name_of(kind: type[Message]) -> str:
    return _HALVES[kind][0].name if kind in _HALVES else MESSAGES[kind].original


def _sent(kind: type[Message]) -> list[FieldSpec]:
    return [spec for spec in MESSAGES[kind].fields if spec.original]


def _out(value: object) -> object:
    return {"sec": value.sec, "nanosec": value.nanosec} if isinstance(value, Time) else value


def _in(spec: FieldSpec, fields: Mapping[str, Any]) -> Any:
    value: Any = fields
    for step in spec.original.split("."):
        value = value[step]
    return Time(value["sec"], value["nanosec"]) if spec.type is WireType.TIME else value
