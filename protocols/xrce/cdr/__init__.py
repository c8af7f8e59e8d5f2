"""CDR, the encoding of data in DDS, and the messages of ROS in it, by anybody's `.msg`, `.srv` and `.action` files.

Start at `parse_message` and `MessageTypes`, or at `Library` where there are files.
"""

from __future__ import annotations

from protocols.xrce.cdr.definitions import (
    PRIMITIVES,
    ActionDefinition,
    Constant,
    Field,
    FieldType,
    MessageDefinition,
    ServiceDefinition,
    Value,
    parse_action,
    parse_message,
    parse_service,
    text_of_fields,
)
from protocols.xrce.cdr.interfaces import (
    INTERFACES,
    SERVICES,
    definition_of,
    full_text,
)
from protocols.xrce.cdr.library import Library, whole_of
from protocols.xrce.cdr.messages import (
    MessageTypes,
    decapsulate,
    encapsulate,
)
from protocols.xrce.cdr.stream import (
    XCDR1_ALIGN,
    XCDR2_ALIGN,
    CdrReader,
    CdrWriter,
)

__all__ = [
    "INTERFACES",
    "PRIMITIVES",
    "SERVICES",
    "XCDR1_ALIGN",
    "XCDR2_ALIGN",
    "ActionDefinition",
    "CdrReader",
    "CdrWriter",
    "Constant",
    "Field",
    "FieldType",
    "Library",
    "MessageDefinition",
    "MessageTypes",
    "ServiceDefinition",
    "Value",
    "decapsulate",
    "definition_of",
    "encapsulate",
    "full_text",
    "parse_action",
    "parse_message",
    "parse_service",
    "text_of_fields",
    "whole_of",
]
