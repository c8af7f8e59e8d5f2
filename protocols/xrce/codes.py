"""The numbers of DDS-XRCE: submessages, kinds of objects, status values, formats, well-known ids.

All are those of OMG DDS-XRCE 1.0 (formal/2020-02-01), dds_xrce_types.idl, but for REQUESTER and REPLIER, which are
those of eProsima's client and agent (include/uxr/client/core/type/xrce_types.h).
"""

from __future__ import annotations

import enum

from protocols.xrce.errors import LocalProtocolError

__all__ = [
    "BUILTIN_BEST_EFFORT",
    "BUILTIN_RELIABLE",
    "COOKIE",
    "NO_SESSION",
    "NO_SESSION_WITH_KEY",
    "NO_STREAM",
    "OBJECT_AGENT",
    "OBJECT_CLIENT",
    "OBJECT_SESSION",
    "VENDOR_EPROSIMA",
    "VERSION",
    "DataFormat",
    "InfoMask",
    "InstanceState",
    "ObjectKind",
    "QosFlag",
    "Status",
    "SubmessageId",
    "has_client_key",
    "is_reliable",
    "kind_of",
    "object_id",
    "with_kind",
]

COOKIE = b"XRCE"
VERSION = b"\x01\x00"
VENDOR_EPROSIMA = b"\x01\x0f"

NO_SESSION_WITH_KEY = 0x00
"""Session id of messages outside of any session, with a client key in their header."""
NO_SESSION = 0x80
"""Session id of messages outside of any session; ids below it have a client key in the header."""

NO_STREAM = 0x00
BUILTIN_BEST_EFFORT = 0x01
BUILTIN_RELIABLE = 0x80
"""The first reliable stream; ids below it, but for 0, are best-effort."""

OBJECT_AGENT = 0xFFFD
OBJECT_CLIENT = 0xFFFE
OBJECT_SESSION = 0xFFFF

_LARGEST_NUMBER = 0xFFF


class SubmessageId(enum.IntEnum):
    """The first byte of a submessage."""

    CREATE_CLIENT = 0
    CREATE = 1
    GET_INFO = 2
    DELETE = 3
    STATUS_AGENT = 4
    STATUS = 5
    INFO = 6
    WRITE_DATA = 7
    READ_DATA = 8
    DATA = 9
    ACKNACK = 10
    HEARTBEAT = 11
    RESET = 12
    FRAGMENT = 13
    TIMESTAMP = 14
    TIMESTAMP_REPLY = 15


class ObjectKind(enum.IntEnum):
    """What an object is: the last four bits of its id."""

    PARTICIPANT = 0x01
    TOPIC = 0x02
    PUBLISHER = 0x03
    SUBSCRIBER = 0x04
    DATAWRITER = 0x05
    DATAREADER = 0x06
    REQUESTER = 0x07
    REPLIER = 0x08
    TYPE = 0x0A
    QOSPROFILE = 0x0B
    APPLICATION = 0x0C
    AGENT = 0x0D
    CLIENT = 0x0E
    OTHER = 0x0F


class Status(enum.IntEnum):
    """How a request ended; 0x80 and above are errors."""

    OK = 0x00
    OK_MATCHED = 0x01
    DDS_ERROR = 0x80
    MISMATCH = 0x81
    ALREADY_EXISTS = 0x82
    DENIED = 0x83
    UNKNOWN_REFERENCE = 0x84
    INVALID_DATA = 0x85
    INCOMPATIBLE = 0x86
    RESOURCES = 0x87


class DataFormat(enum.IntEnum):
    """How data stand in WRITE_DATA and DATA: bits 1 to 3 of the flags."""

    DATA = 0x00
    SAMPLE = 0x02
    DATA_SEQ = 0x08
    SAMPLE_SEQ = 0x0A
    PACKED_SAMPLES = 0x0E


class InfoMask(enum.IntFlag):
    """What GET_INFO asks for."""

    CONFIGURATION = 0x01
    ACTIVITY = 0x02


class InstanceState(enum.IntFlag):
    """What a sample says about its instance."""

    UNREGISTERED = 0x01
    DISPOSED = 0x02
    VIEW_NEW = 0x04
    READ = 0x08


class QosFlag(enum.IntFlag):
    """Quality of service of a data writer or reader in binary."""

    RELIABLE = 0x01
    HISTORY_KEEP_LAST = 0x02
    OWNERSHIP_EXCLUSIVE = 0x04
    DURABILITY_TRANSIENT_LOCAL = 0x08
    DURABILITY_TRANSIENT = 0x10
    DURABILITY_PERSISTENT = 0x20


def object_id(number: int, kind: ObjectKind) -> int:
    """The id of an object: its number, 0..4095, and its kind in the last four bits.

    Raises:
        LocalProtocolError: the number does not fit.
    """
    if not 0 <= number <= _LARGEST_NUMBER:
        raise LocalProtocolError(f"object number {number} is not 0..{_LARGEST_NUMBER}")
    return number << 4 | kind


def kind_of(object_id: int) -> int:
    """The kind in an object's id, an `ObjectKind` if it is a known one."""
    return object_id & 0x0F


def with_kind(object_id: int, kind: ObjectKind) -> int:
    """The id with the number of this one, and this kind."""
    return object_id & 0xFFF0 | kind


def has_client_key(session_id: int) -> bool:
    """Messages of this session have a client key in their header."""
    return session_id < NO_SESSION


def is_reliable(stream_id: int) -> bool:
    """The stream repeats what was lost."""
    return stream_id >= BUILTIN_RELIABLE
