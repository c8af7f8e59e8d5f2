"""What must stand on the line, worked out by hand before there was code: each submessage, messages, serial frames.

Sections are those of OMG DDS-XRCE 1.0 (formal/2020-02-01), types those of its dds_xrce_types.idl. Rows of its Annex B
are the examples that it works out itself, put here after the code (where the length or the offset that it prints
contradicts its own drawing, the drawing holds). Where clients and agents in use differ, the bytes are theirs, and
`differs` says how: eProsima's Micro-XRCE-DDS-Client (src/c/core/serialization/xrce_types.c) and Micro-XRCE-DDS-Agent;
the differences are those that the dissector jseldent/wireshark-dds-xrce lists. Serial frames are laid out as in Annex
C.1, but for the CRC: theirs (src/c/profile/transport/stream_framing/stream_framing_protocol.c) is another one, over the
payload alone. CRCs were reckoned with crcmod.

Fields are plain values under the names of the specification, so that this file needs nothing of what it tests; a union
is a pair of its case and its fields.
"""

from __future__ import annotations

from typing import NamedTuple

__all__ = ["FRAMES", "MESSAGES", "SUBMESSAGES", "FrameVector", "MessageVector", "SubmessageVector"]


class SubmessageVector(NamedTuple):
    """One submessage, header and all, without the padding that may follow it."""

    section: str
    name: str
    fields: dict[str, object]
    text: str
    flags: int = 1
    differs: str = ""

    @property
    def data(self) -> bytes:
        return bytes.fromhex(self.text)


class MessageVector(NamedTuple):
    """One message: its header, and the names of the submessages in it."""

    section: str
    session_id: int
    stream_id: int
    sequence: int
    client_key: bytes | None
    submessages: tuple[str, ...]
    text: str

    @property
    def data(self) -> bytes:
        return bytes.fromhex(self.text)


class FrameVector(NamedTuple):
    """One serial frame around a payload."""

    what: str
    source: int
    destination: int
    payload: bytes
    text: str

    @property
    def data(self) -> bytes:
        return bytes.fromhex(self.text)


KEY = bytes.fromhex("AABBCCDD")
AGENT = {"xrce_cookie": b"XRCE", "xrce_version": (1, 0), "xrce_vendor_id": (0x01, 0x0F)}
CLIENT = {**AGENT, "client_key": KEY, "session_id": 0x81}
_MTU = "the specification's CLIENT_Representation ends before the mtu"
_RESULT = "the specification's STATUS_AGENT_Payload has no result"
_ORDER = "in the specification's ObjectInfo the activity comes before the configuration"
_TYPE = "the specification has an optional TypeIdentifier where they send the name of a type"
_TOPIC_ID = "the specification has the name of a topic where they send its object id"
_SERVICE = "the specification has no requesters and repliers"


def _request(request_id: int, object_id: int, **others: object) -> dict[str, object]:
    return {"request_id": request_id, "object_id": object_id, **others}


def _reply(request_id: int, object_id: int, status: int, implementation_status: int, **others: object):
    return _request(request_id, object_id, status=status, implementation_status=implementation_status, **others)


def _create(request_id: int, object_id: int, kind: str, representation: tuple[str, object], **parent: object):
    return _request(request_id, object_id, object_representation=(kind, {"representation": representation, **parent}))


SUBMESSAGES = [
    SubmessageVector(
        "8.3.5.1", "CREATE_CLIENT", {**CLIENT, "properties": None, "mtu": 512},
        "00 01 10 00  58 52 43 45  01 00  01 0F  AA BB CC DD  81  00  00 02", differs=_MTU,
    ),
    SubmessageVector(
        "8.3.5.1", "CREATE_CLIENT", {**CLIENT, "properties": None, "mtu": None},
        "00 01 0E 00  58 52 43 45  01 00  01 0F  AA BB CC DD  81  00",
    ),
    SubmessageVector(
        "8.3.5.1", "CREATE_CLIENT", {**CLIENT, "properties": (("a", "bc"),), "mtu": 512},
        "00 01 26 00  58 52 43 45  01 00  01 0F  AA BB CC DD  81  01 00 00"
        "  01 00 00 00  02 00 00 00 61 00 00 00  03 00 00 00 62 63 00 00  00 02", differs=_MTU,
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE", _create(10, 0x0011, "PARTICIPANT", ("REFERENCE", "p"), domain_id=0),
        "01 01 10 00  00 0A 00 11  01 01 00 00  02 00 00 00 70 00  00 00",
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE", _create(10, 0x0011, "PARTICIPANT", ("REFERENCE", "p"), domain_id=0),
        "01 07 10 00  00 0A 00 11  01 01 00 00  02 00 00 00 70 00  00 00", flags=7,
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE", _create(10, 0x0011, "PARTICIPANT", ("REFERENCE", "p"), domain_id=-2),
        "01 00 10 00  00 0A 00 11  01 01 00 00  00 00 00 02 70 00  FF FE", flags=0,
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE",
        _create(
            10, 0x0011, "PARTICIPANT", ("BINARY", {"domain_reference": None, "qos_profile_reference": None}),
            domain_id=42,
        ),
        "01 01 10 00  00 0A 00 11  01 03 00 00  02 00 00 00 00 00  2A 00",
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE", _create(11, 0x0012, "TOPIC", ("XML", "<dds/>"), participant_id=0x0011),
        "01 01 15 00  00 0B 00 12  02 02 00 00  07 00 00 00 3C 64 64 73 2F 3E 00  00 11",
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE",
        _create(
            11, 0x0012, "TOPIC", ("BINARY", {"topic_name": "rt/t", "type_reference": None, "type_name": "T"}),
            participant_id=0x0011,
        ),
        "01 01 20 00  00 0B 00 12  02 03 00 00  12 00 00 00"
        "  05 00 00 00 72 74 2F 74 00  00  01 00  02 00 00 00 54 00  00 11", differs=_TYPE,
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE",
        _create(12, 0x0013, "PUBLISHER", ("BINARY", {"name": None, "qos": None}), participant_id=0x0011),
        "01 01 10 00  00 0C 00 13  03 03 00 00  02 00 00 00  00 00  00 11",
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE",
        _create(
            13, 0x0014, "SUBSCRIBER", ("BINARY", {"name": "s", "qos": {"partitions": ("a",), "group_data": None}}),
            participant_id=0x0011,
        ),
        "01 01 25 00  00 0D 00 14  04 03 00 00  17 00 00 00"
        "  01 00 00 00  02 00 00 00 73 00  01  01  01 00 00 00  02 00 00 00 61 00  00  00 11",
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE",
        _create(
            14, 0x0015, "DATAWRITER",
            (
                "BINARY",
                {
                    "topic_id": 0x0012,
                    "qos": {
                        "qos_flags": 0x0003, "history_depth": 5, "deadline_msec": None, "lifespan_msec": None,
                        "user_data": None, "ownership_strength": None,
                    },
                },
            ),
            publisher_id=0x0013,
        ),
        "01 01 1C 00  00 0E 00 15  05 03 00 00  0E 00 00 00"
        "  00 12  01 00  03 00  01 00 05 00  00 00 00 00  00 13", differs=_TOPIC_ID,
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE",
        _create(
            15, 0x0016, "DATAREADER",
            (
                "BINARY",
                {
                    "topic_id": 0x0012,
                    "qos": {
                        "qos_flags": 0x0008, "history_depth": None, "deadline_msec": 100, "lifespan_msec": None,
                        "user_data": None, "timebasedfilter_msec": None, "contentbased_filter": "x>1",
                    },
                },
            ),
            subscriber_id=0x0014,
        ),
        "01 01 26 00  00 0F 00 16  06 03 00 00  18 00 00 00"
        "  00 12  01 00  08 00  00  01 64 00 00 00  00 00 00  01 04 00 00 00 78 3E 31 00  00 14", differs=_TOPIC_ID,
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE",
        _create(
            16, 0x0017, "REQUESTER",
            (
                "BINARY",
                {
                    "service_name": "s", "request_type": "Q", "reply_type": "R",
                    "request_topic_name": "rq/s", "reply_topic_name": "rr/s",
                },
            ),
            participant_id=0x0011,
        ),
        "01 01 3B 00  00 10 00 17  07 03 00 00  2D 00 00 00"
        "  02 00 00 00 73 00 00 00  02 00 00 00 51 00 00 00  02 00 00 00 52 00"
        "  01 00  05 00 00 00 72 71 2F 73 00  01 00 00  05 00 00 00 72 72 2F 73 00  00 11", differs=_SERVICE,
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE",
        _create(
            17, 0x0018, "REPLIER",
            (
                "BINARY",
                {
                    "service_name": "s", "request_type": "Q", "reply_type": "R",
                    "request_topic_name": None, "reply_topic_name": None,
                },
            ),
            participant_id=0x0011,
        ),
        "01 01 26 00  00 11 00 18  08 03 00 00  18 00 00 00"
        "  02 00 00 00 73 00 00 00  02 00 00 00 51 00 00 00  02 00 00 00 52 00  00 00  00 11", differs=_SERVICE,
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE", _create(18, 0x001A, "TYPE", ("REFERENCE", "T")),
        "01 01 0E 00  00 12 00 1A  0A 01 00 00  02 00 00 00 54 00",
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE", _create(19, 0x001B, "QOSPROFILE", ("XML", "<q/>")),
        "01 01 11 00  00 13 00 1B  0B 02 00 00  05 00 00 00 3C 71 2F 3E 00",
    ),
    SubmessageVector(
        "8.3.5.2", "CREATE", _create(20, 0x001C, "APPLICATION", ("REFERENCE", "a")),
        "01 01 0E 00  00 14 00 1C  0C 01 00 00  02 00 00 00 61 00",
    ),
    SubmessageVector(
        "8.3.5.3", "GET_INFO", _request(10, 0xFFFD, info_mask=2), "02 01 08 00  00 0A FF FD  02 00 00 00"
    ),
    SubmessageVector("8.3.5.4", "DELETE", _request(2, 0xFFFE), "03 01 04 00  00 02 FF FE"),
    SubmessageVector(
        "8.3.5.5", "STATUS_AGENT", {"status": 0, "implementation_status": 0, **AGENT, "properties": None},
        "04 01 0B 00  00 00  58 52 43 45  01 00  01 0F  00", differs=_RESULT,
    ),
    SubmessageVector("8.3.5.6", "STATUS", _reply(10, 0x0011, 0x00, 0), "05 01 06 00  00 0A 00 11  00 00"),
    SubmessageVector("8.3.5.6", "STATUS", _reply(10, 0x0011, 0x84, 7), "05 01 06 00  00 0A 00 11  84 07"),
    SubmessageVector(
        "8.3.5.7", "INFO",
        _reply(10, 0xFFFD, 0, 1, config=None, activity=("AGENT", {"availability": 1, "address_seq": ()})),
        "06 01 10 00  00 0A FF FD  00 01  00  01 0D 00  01 00  00 00 00 00", differs=_ORDER,
    ),
    SubmessageVector(
        "8.3.5.7", "INFO",
        _reply(
            10, 0xFFFD, 0, 1, config=None,
            activity=("AGENT", {"availability": 1, "address_seq": (("MEDIUM", bytes((127, 0, 0, 1)), 2019),)}),
        ),
        "06 01 18 00  00 0A FF FD  00 01  00  01 0D 00  01 00  01 00 00 00  01 7F 00 00 01 00 E3 07", differs=_ORDER,
    ),
    SubmessageVector(
        "8.3.5.7", "INFO",
        _reply(10, 0x0016, 0, 0, config=None, activity=("DATAREADER", {"highest_acked_num": 5})),
        "06 01 0C 00  00 0A 00 16  00 00  00  01 06 00  05 00", differs=_ORDER,
    ),
    SubmessageVector(
        "8.3.5.7", "INFO",
        _reply(10, 0x0015, 0, 0, config=None, activity=("DATAWRITER", {"sample_seq_num": 7, "stream_seq_num": 9})),
        "06 01 16 00  00 0A 00 15  00 00  00  01 05 00 00 00  07 00 00 00 00 00 00 00  09 00", differs=_ORDER,
    ),
    SubmessageVector(
        "8.3.5.7", "INFO",
        _reply(
            10, 0x0011, 0, 0, activity=None,
            config=("PARTICIPANT", {"representation": ("REFERENCE", "p"), "domain_id": 0}),
        ),
        "06 01 15 00  00 0A 00 11  00 00  01 01 01 00 00 00  02 00 00 00 70 00  00 00  00", differs=_ORDER,
    ),
    SubmessageVector(
        "8.3.5.8", "WRITE_DATA", _request(11, 0x0015, data=("DATA", b"\1\2\3\4")),
        "07 01 08 00  00 0B 00 15  01 02 03 04",
    ),
    SubmessageVector(
        "8.3.5.8", "WRITE_DATA",
        _request(11, 0x0015, data=("SAMPLE", {"info": (4, "SEQNUM", (7,)), "data": b"\xaa\xbb"})),
        "07 03 0E 00  00 0B 00 15  04 01 00 00  07 00 00 00  AA BB", flags=0x03,
    ),
    SubmessageVector(
        "8.3.5.8", "WRITE_DATA",
        _request(11, 0x0015, data=("SAMPLE_SEQ", (2, bytes.fromhex("00 00 33  00 00 34")))),
        "07 0B 0E 00  00 0B 00 15  02 00 00 00  00 00 33  00 00 34", flags=0x0B,
    ),
    SubmessageVector(
        "8.3.5.8", "WRITE_DATA",
        _request(
            11, 0x0015, data=("PACKED_SAMPLES", ((0, "TIMESTAMP", (1000,)), 1, bytes.fromhex("00 01 0A 00  44")))
        ),
        "07 0F 15 00  00 0B 00 15  00 02 00 00  E8 03 00 00  01 00 00 00  00 01  0A 00  44", flags=0x0F,
    ),
    SubmessageVector(
        "8.3.5.9", "READ_DATA",
        _request(
            12, 0x0016, preferred_stream_id=0x80, data_format=0, content_filter_expression=None,
            delivery_control={
                "max_samples": 0xFFFF, "max_elapsed_time": 0, "max_bytes_per_second": 0, "min_pace_period": 0
            },
        ),
        "08 01 10 00  00 0C 00 16  80 00 00 01  FF FF 00 00 00 00 00 00",
    ),
    SubmessageVector(
        "8.3.5.10", "DATA", _request(12, 0x0016, data=("DATA", b"\xaa\xbb")), "09 01 06 00  00 0C 00 16  AA BB",
    ),
    SubmessageVector(
        "8.3.5.11", "ACKNACK", {"first_unacked_seq_num": 5, "nack_bitmap": 0x0103, "stream_id": 0x80},
        "0A 01 05 00  05 00  01 03  80",
    ),
    SubmessageVector(
        "8.3.5.11", "ACKNACK", {"first_unacked_seq_num": 5, "nack_bitmap": 0x0103, "stream_id": 0x80},
        "0A 00 05 00  00 05  01 03  80", flags=0,
    ),
    SubmessageVector(
        "8.3.5.12", "HEARTBEAT", {"first_unacked_seq_nr": 5, "last_unacked_seq_nr": 9, "stream_id": 0x80},
        "0B 01 05 00  05 00  09 00  80",
    ),
    SubmessageVector(
        "8.3.5.12", "HEARTBEAT", {"first_unacked_seq_nr": 5, "last_unacked_seq_nr": 9, "stream_id": 0x80},
        "0B 00 05 00  00 05  00 09  80", flags=0,
    ),
    SubmessageVector("8.3.5.13", "RESET", {}, "0C 01 00 00"),
    SubmessageVector("8.3.5.14", "FRAGMENT", {"data": b"\xde\xad\xbe\xef"}, "0D 01 04 00  DE AD BE EF"),
    SubmessageVector("8.3.5.14", "FRAGMENT", {"data": b"\xca\xfe"}, "0D 03 02 00  CA FE", flags=3),
    SubmessageVector(
        "8.3.5.15", "TIMESTAMP", {"transmit_timestamp": (1, 2)}, "0E 01 08 00  01 00 00 00 02 00 00 00"
    ),
    SubmessageVector(
        "8.3.5.16", "TIMESTAMP_REPLY",
        {"transmit_timestamp": (5, 6), "receive_timestamp": (3, 4), "originate_timestamp": (-1, 2)},
        "0F 01 18 00  05 00 00 00 06 00 00 00  03 00 00 00 04 00 00 00  FF FF FF FF 02 00 00 00",
    ),
    # The specification's own examples, where it prints values; what is not printed (times, numbers) is filled in.
    SubmessageVector(
        "8.3.5.11.2", "ACKNACK", {"first_unacked_seq_num": 100, "nack_bitmap": 0x4009, "stream_id": 0x80},
        "0A 01 05 00  64 00  40 09  80",
    ),
    SubmessageVector(
        "B.1", "CREATE_CLIENT",
        {
            **AGENT, "xrce_vendor_id": (0x0F, 0x0F), "client_key": bytes.fromhex("22334455"), "session_id": 0xDD,
            "properties": None, "mtu": None,
        },
        "00 01 0E 00  58 52 43 45  01 00  0F 0F  22 33 44 55  DD  00",
    ),
    SubmessageVector(
        "B.2.1", "CREATE",
        _create(0xAA01, 0xDDD1, "PARTICIPANT", ("REFERENCE", "MyLibrary::MyParticipant"), domain_id=0),
        "01 07 28 00  AA 01 DD D1  01 01 00 00  19 00 00 00"
        "  4D 79 4C 69 62 72 61 72 79 3A 3A 4D 79 50 61 72 74 69 63 69 70 61 6E 74 00  00  00 00", flags=7,
    ),
    SubmessageVector(
        "B.3.1", "WRITE_DATA", _request(0xAA01, 0x4405, data=("DATA", b"\x19\0")),
        "07 01 06 00  AA 01 44 05  19 00",
    ),
    SubmessageVector(
        "B.3.2", "WRITE_DATA",
        _request(0xAA01, 0x4405, data=("DATA_SEQ", (4, bytes.fromhex("1400 1100 1A00 2800")))),
        "07 09 10 00  AA 01 44 05  04 00 00 00  14 00 11 00 1A 00 28 00", flags=0x09,
    ),
    SubmessageVector(
        "B.3.3", "WRITE_DATA",
        _request(0xAA01, 0x4405, data=("SAMPLE", {"info": (0, "TIMESTAMP", (1000,)), "data": b"\x19\0"})),
        "07 03 0E 00  AA 01 44 05  00 02 00 00  E8 03 00 00  19 00", flags=0x03,
    ),
    SubmessageVector(
        "B.3.4", "WRITE_DATA",
        _request(
            0xAA01, 0x4405, data=("SAMPLE", {"info": (2, "EMPTY", ()), "data": bytes.fromhex("112233641900")})
        ),
        "07 03 0C 00  AA 01 44 05  02 00  11 22 33 64 19 00", flags=0x03,
    ),
    SubmessageVector(
        "B.4.1", "READ_DATA",
        _request(
            0xAA01, 0x4406, preferred_stream_id=0, data_format=0, content_filter_expression=None, delivery_control=None
        ),
        "08 01 08 00  AA 01 44 06  00 00 00 00",
    ),
    SubmessageVector(
        "B.5.1", "DATA", _request(0xAA01, 0x4406, data=("DATA", b"\0\0\0\x13")),
        "09 00 08 00  AA 01 44 06  00 00 00 13", flags=0,
    ),
    SubmessageVector(
        "B.5.4", "DATA",
        _request(
            0xAA02, 0x4406,
            data=(
                "SAMPLE_SEQ",
                (2, bytes.fromhex("00030000 00000001 00000064 00000001  00030000 00000002 00000065 00000002")),
            ),
        ),
        "09 0A 28 00  AA 02 44 06  00 00 00 02"
        "  00 03 00 00  00 00 00 01  00 00 00 64  00 00 00 01"
        "  00 03 00 00  00 00 00 02  00 00 00 65  00 00 00 02", flags=0x0A,
    ),
    SubmessageVector(
        "B.5.5", "DATA",
        _request(
            0xAA03, 0x4406,
            data=(
                "PACKED_SAMPLES",
                ((0, "SEQN_TIMS", (1, 100)), 2, bytes.fromhex("00000000 00000001  00010001 00000002")),
            ),
        ),
        "09 0E 24 00  AA 03 44 06  00 03 00 00  00 00 00 01  00 00 00 64  00 00 00 02"
        "  00 00 00 00  00 00 00 01  00 01 00 01  00 00 00 02", flags=0x0E,
    ),
]  # fmt: skip

MESSAGES = [
    MessageVector("8.3.2", 0x81, 0x00, 0, None, (), "81 00 00 00"),
    MessageVector("8.3.2.4", 0x01, 0x80, 0xFFFE, KEY, ("RESET",), "01 80 FE FF AA BB CC DD  0C 01 00 00"),
    MessageVector(
        "8.3.2.3", 0x80, 0x00, 0, None, ("CREATE_CLIENT",),
        "80 00 00 00  00 01 10 00  58 52 43 45 01 00 01 0F AA BB CC DD 81 00 00 02",
    ),
    MessageVector(
        "8.3.4", 0x81, 0x00, 0, None, ("ACKNACK", "HEARTBEAT"),
        "81 00 00 00  0A 01 05 00 05 00 01 03 80  00 00 00  0B 01 05 00 05 00 09 00 80",
    ),
]  # fmt: skip

FRAMES = [
    FrameVector("nothing to escape", 0x00, 0x00, bytes.fromhex("81000000"), "7E 00 00 04 00 81 00 00 00 28 3C"),
    FrameVector("the flag and the escape", 0x01, 0x00, b"\x7e\x7d", "7E 01 00 02 00 7D 5E 7D 5D E1 81"),
    FrameVector("escaped addresses", 0x7D, 0x7E, b"123456789", "7E 7D 5D 7D 5E 09 00 31 32 33 34 35 36 37 38 39 3D BB"),
    FrameVector("an escaped CRC", 0x00, 0x00, b"\xa9\x6c", "7E 00 00 02 00 A9 6C 7D 5E 7D 5D"),
    FrameVector("nothing at all", 0x00, 0x00, b"", "7E 00 00 00 00 00 00"),
]
