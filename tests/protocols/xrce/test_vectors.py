"""The table of vectors is right in itself: names, flags, lengths and CRCs are what its columns say."""

from __future__ import annotations

import crcmod.predefined

from tests.protocols.xrce.vectors import FRAMES, MESSAGES, SUBMESSAGES

NAMES = (
    *("CREATE_CLIENT", "CREATE", "GET_INFO", "DELETE", "STATUS_AGENT", "STATUS", "INFO", "WRITE_DATA", "READ_DATA"),
    *("DATA", "ACKNACK", "HEARTBEAT", "RESET", "FRAGMENT", "TIMESTAMP", "TIMESTAMP_REPLY"),
)
crc = crcmod.predefined.mkCrcFun("crc-16")


def test_each_submessage_is_there_with_its_id_its_flags_and_its_length():
    assert {vector.name for vector in SUBMESSAGES} == set(NAMES)
    for vector in SUBMESSAGES:
        head = bytes((NAMES.index(vector.name), vector.flags)) + (len(vector.data) - 4).to_bytes(2, "little")
        assert vector.data[:4] == head, vector


def test_a_message_is_its_header_and_its_submessages_each_at_a_multiple_of_four():
    first = {vector.name: vector.data for vector in reversed(SUBMESSAGES)}
    for vector in MESSAGES:
        expected = bytes((vector.session_id, vector.stream_id)) + vector.sequence.to_bytes(2, "little")
        expected += vector.client_key or b""
        for name in vector.submessages:
            expected += bytes(-len(expected) % 4) + first[name]
        assert vector.data == expected, vector


def test_a_frame_is_its_parts_and_the_crc_of_its_payload():
    for vector in FRAMES:
        parts = bytes((vector.source, vector.destination)) + len(vector.payload).to_bytes(2, "little")
        parts += vector.payload + crc(vector.payload).to_bytes(2, "little")
        stuffed = b"".join(bytes((0x7D, byte ^ 0x20)) if byte in b"\x7e\x7d" else bytes((byte,)) for byte in parts)
        assert vector.data == b"\x7e" + stuffed, vector
