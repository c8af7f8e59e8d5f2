"""Any submessage is read as it was written, in either byte order; any bytes raise the documented error or nothing."""

from __future__ import annotations

import dataclasses
import types
import typing

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols import xrce
from tests.each import each
from tests.protocols.xrce.vectors import SUBMESSAGES
from tests.share import examples

RANGES = {
    **dict.fromkeys(("request_id", "object_id", "participant_id", "publisher_id", "subscriber_id"), (0, 0xFFFF)),
    **dict.fromkeys(("topic_id", "first_unacked", "last_unacked", "nack_bitmap", "flags", "mtu"), (0, 0xFFFF)),
    **dict.fromkeys(("history_depth", "max_samples", "max_elapsed_s", "max_bytes_per_s", "min_pace_ms"), (0, 0xFFFF)),
    **dict.fromkeys(("stream_id", "session_id", "implementation_status", "state"), (0, 0xFF)),
    **dict.fromkeys(("availability", "highest_acked", "stream_sequence", "domain_id"), (-0x8000, 0x7FFF)),
    "seconds": (-(1 << 31), (1 << 31) - 1),
    "sample_sequence": (0, (1 << 64) - 1),
}
SIZES = {"cookie": 4, "version": 2, "vendor_id": 2, "client_key": 4}
LOCATORS = {
    kind: st.builds(kind, address=st.binary(min_size=size, max_size=size), port=st.integers(0, most))
    for kind, size, most in [
        (xrce.SmallLocator, 2, 0xFF),
        (xrce.MediumLocator, 4, 0xFFFF),
        (xrce.LargeLocator, 16, 0xFFFFFFFF),
    ]
}
TEXTS = st.text(st.characters(exclude_categories=("Cs",)), max_size=6)


def of_type(kind, name=""):
    """Values of a type, as the field of this name can have them."""
    if kind in LOCATORS:
        return LOCATORS[kind]
    if typing.get_origin(kind) in (typing.Union, types.UnionType):
        return st.one_of([of_type(one, name) for one in typing.get_args(kind)])
    if typing.get_origin(kind) is tuple:
        one, *others = typing.get_args(kind)
        if others == [...]:
            return st.lists(of_type(one), max_size=2).map(tuple)
        return st.tuples(of_type(one), *map(of_type, others))
    if dataclasses.is_dataclass(kind):
        hints = typing.get_type_hints(kind)
        return st.builds(kind, **{field.name: of_type(hints[field.name], field.name) for field in fields(kind)})
    if issubclass(kind, xrce.Status | xrce.DataFormat):
        return st.sampled_from(kind)
    size = SIZES.get(name)
    plain = {
        type(None): st.none(),
        bool: st.booleans(),
        int: st.integers(*RANGES.get(name, (0, 0xFFFFFFFF))),
        str: TEXTS,
        bytes: st.binary(min_size=size or 0, max_size=size or 9),
    }
    return plain[kind]


def fields(kind):
    return dataclasses.fields(kind)


ANY = st.one_of([of_type(kind) for kind in typing.get_args(xrce.Submessage)])


@settings(max_examples=examples(500))
@given(ANY, st.booleans())
def test_any_submessage_is_read_as_it_was_written(submessage, little_endian):
    data = xrce.encode_submessage(submessage, little_endian=little_endian)
    (raw,) = xrce.split_submessages(data + bytes(-len(data) % 4))
    assert xrce.decode_submessage(raw) == submessage
    assert xrce.encode_submessage(raw) == data


def read_all(data):
    """What is read of some bytes, or the error."""
    try:
        _, rest = xrce.decode_header(data)
        return [xrce.decode_submessage(raw) for raw in xrce.split_submessages(rest)]
    except xrce.RemoteProtocolError as error:
        return error


@settings(max_examples=examples(500))
@given(st.binary(max_size=80), st.integers(0, 16), st.integers(0, 15))
def test_any_bytes_raise_nothing_but_the_documented_error(payload, number, flags):
    read_all(payload)
    raw = xrce.RawSubmessage(id=number, flags=flags, payload=payload)
    read_all(b"\x81\x80\0\0" + xrce.encode_submessage(raw))


def test_any_bit_of_a_sound_submessage_that_is_turned_raises_nothing_else():
    for vector in SUBMESSAGES:
        for bit in range(8 * len(vector.data)):
            damaged = bytearray(vector.data)
            damaged[bit // 8] ^= 1 << bit % 8
            read_all(b"\x81\x80\0\0" + bytes(damaged))


def test_every_kind_of_object_and_of_submessage_is_there():
    assert set(xrce.SUBMESSAGES.values()) == set(xrce.SubmessageId)
    assert set(xrce.KIND_OF_OBJECT.values()) == set(xrce.ObjectKind) - {xrce.ObjectKind.OTHER}
    assert xrce.object_id(0xFFF, xrce.ObjectKind.AGENT) == xrce.OBJECT_AGENT
    assert xrce.kind_of(0x0016) == xrce.ObjectKind.DATAREADER
    with pytest.raises(xrce.LocalProtocolError, match="4096"):
        xrce.object_id(4096, xrce.ObjectKind.TOPIC)


IDS = {"request_id": 10, "object_id": 0x11}


@each(
    "wrong",
    [
        xrce.GetInfo(request_id=0x10000, object_id=0, info_mask=0),
        xrce.GetInfo(request_id=0, object_id=0, info_mask=-1),
        xrce.Create(**IDS, object=xrce.Participant(representation=xrce.TopicBinary(topic_name="t"))),
        xrce.Create(**IDS, object=xrce.Type(representation=xrce.ByReference(name="\ud800"))),
        xrce.CreateClient(client=xrce.Client(client_key=b"123", session_id=0x81)),
        xrce.Create(**IDS, object=xrce.Type(representation=xrce.AsXml(text="x" * 70000))),
    ],
)
def test_what_does_not_fit_is_refused(wrong):
    with pytest.raises(xrce.LocalProtocolError):
        xrce.encode_submessage(wrong)


def test_data_longer_than_the_length_field_take_all_that_is_left():
    """As micro-ROS sends a picture: in fragments, with a length of 0 in its own header."""
    picture = xrce.WriteData(**IDS, data=bytes(range(256)) * 300)
    data = xrce.encode_submessage(picture)
    assert data[2:4] == b"\0\0"
    (raw,) = xrce.split_submessages(data)
    assert xrce.decode_submessage(raw) == picture


def test_a_sequence_that_claims_more_than_there_is_costs_no_memory():
    claims = bytes.fromhex("58 52 43 45 01 00 01 0F AA BB CC DD 81 01 00 00 FF FF FF FF")
    raw = xrce.RawSubmessage(id=xrce.SubmessageId.CREATE_CLIENT, flags=1, payload=claims)
    with pytest.raises(xrce.RemoteProtocolError, match="4294967295"):
        xrce.decode_submessage(raw)


def test_samples_that_are_said_to_be_many_are_counted_by_who_knows_their_type():
    claims = bytes.fromhex("00 0B 00 15 FF FF FF FF 33")
    raw = xrce.RawSubmessage(id=xrce.SubmessageId.WRITE_DATA, flags=1 | xrce.DataFormat.DATA_SEQ, payload=claims)
    assert xrce.decode_submessage(raw).data == xrce.DataSequence(count=0xFFFFFFFF, data=b"\x33")


@each(
    "wrong",
    [
        {"session_id": 0x81, "client_key": b"1234"},
        {"session_id": 1},
        {"session_id": 1, "client_key": b"123"},
        {"session_id": 256},
        {"session_id": 0x81, "sequence": -1},
    ],
)
def test_a_header_that_cannot_be(wrong):
    with pytest.raises(xrce.LocalProtocolError):
        xrce.Header(**wrong)
