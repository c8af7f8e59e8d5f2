"""Definitions of ROS 2 by the names of messages, whatever file they stand in, and data read by them.

    library = Library(read)                                  # what stands in ``demo/action/Count.action``, or None
    library.decode("demo/action/Count_FeedbackMessage", data)

A request of a service is called ``demo/srv/Add_Request``; see `ActionDefinition` for what belongs to an action.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from typing import Any

from protocols.xrce.cdr.definitions import (
    MessageDefinition,
    parse_action,
    parse_message,
    parse_service,
    text_of_fields,
)
from protocols.xrce.cdr.interfaces import INTERFACES, SERVICES, full_text
from protocols.xrce.cdr.messages import MessageTypes
from protocols.xrce.errors import LocalProtocolError

__all__ = ["Library", "whole_of"]

_PARTS = re.compile(r"_(?:(?:SendGoal_|GetResult_)?(?:Request|Response)|FeedbackMessage|Goal|Result|Feedback)$")


def _nothing(_path: str) -> None:
    return None


def whole_of(name: str) -> str:
    """The service or action that a message belongs to, ``demo/srv/Add`` of ``demo/srv/Add_Request``; else its name."""
    return _PARTS.sub("", name) if name.split("/")[1:2] in (["srv"], ["action"]) else name


class Library:
    """See the module.

    Args:
        read: what stands in a file, as ``std_msgs/msg/String.msg``; None without it. What is known without a file is
            there anyway.
    """

    def __init__(self, read: Callable[[str], str | None] = _nothing) -> None:
        self._read = read
        self._types = MessageTypes()
        self._known: set[str] = set()

    def text_of(self, name: str) -> str | None:
        """What stands in the `.msg` file of a message, or would; None where that is not known.

        Raises:
            LocalProtocolError: the file of its service or action cannot be read.
        """
        kind = name.split("/")[1:2]
        if kind not in (["srv"], ["action"]):
            text = self._read(f"{name}.msg")
            return INTERFACES.get(name) if text is None else text
        found = {one.name: one for one in self._messages_of(whole_of(name), kind[0])}
        return text_of_fields(found[name]) if name in found else None

    def full_text(self, name: str) -> str:
        """See `interfaces.full_text`."""
        return full_text(name, self.text_of)

    def encode(self, name: str, message: Mapping[str, Any]) -> bytes:
        """A message in CDR, little-endian, without a header.

        Raises:
            LocalProtocolError: see `decode`; or a field is not in it, or does not fit.
        """
        self._learn(name)
        return self._types.encode(name, message)

    def decode(self, name: str, data: bytes, *, little_endian: bool = True) -> dict[str, Any]:
        """A message in CDR, without a header.

        Raises:
            LocalProtocolError: it is not known, or one in it, or their definitions cannot be read.
            RemoteProtocolError: the data end before, or make no sense.
        """
        self._learn(name)
        return self._types.decode(name, data, little_endian=little_endian)

    def _learn(self, name: str) -> None:
        if name in self._known:
            return
        text = self.text_of(name)
        if text is None:
            raise LocalProtocolError(f"{name} is not known here")
        definition = parse_message(name, text)
        self._known.add(name)
        self._types.add(definition)
        try:
            for field in definition.fields:
                if field.type.is_message:
                    self._learn(field.type.base)
        except LocalProtocolError:
            self._known.discard(name)
            raise

    def _messages_of(self, whole: str, kind: str) -> tuple[MessageDefinition, ...]:
        text = self._read(f"{whole}.{kind}")
        if text is None:
            text = SERVICES.get(whole)
        if text is None:
            return ()
        if kind == "action":
            return parse_action(whole, text).messages
        service = parse_service(whole, text)
        return service.request, service.response
