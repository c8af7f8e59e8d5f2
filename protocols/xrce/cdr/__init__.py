"""CDR, the encoding of data in DDS, and the messages of ROS in it, by `.msg` and `.srv` files of anybody.

Start at `parse_message` and `MessageTypes`.
"""

from __future__ import annotations

from protocols.xrce.cdr.definitions import (
    PRIMITIVES,
    Constant,
    Field,
    FieldType,
    MessageDefinition,
    ServiceDefinition,
    Value,
    parse_message,
    parse_service,
)
from protocols.xrce.cdr.interfaces import (
    INTERFACES,
    definition_of,
    full_text,
)
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
    "XCDR1_ALIGN",
    "XCDR2_ALIGN",
    "CdrReader",
    "CdrWriter",
    "Constant",
    "Field",
    "FieldType",
    "MessageDefinition",
    "MessageTypes",
    "ServiceDefinition",
    "Value",
    "decapsulate",
    "definition_of",
    "encapsulate",
    "full_text",
    "parse_message",
    "parse_service",
]
