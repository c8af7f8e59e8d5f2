"""The table of vectors is right in itself, and the code makes and reads just these bytes."""

from __future__ import annotations

import crcmod.predefined

from protocols import xrce
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


def plain(value):
    """What a field of the table is in the code: pairs of numbers that are versions and vendors are bytes there."""
    return bytes(value) if isinstance(value, tuple) else value


def client(fields):
    named = {name.removeprefix("xrce_"): plain(value) for name, value in fields.items() if name.startswith("xrce_")}
    return {**{name: value for name, value in fields.items() if not name.startswith("xrce_")}, **named}


RENAMED = {
    "qos_flags": "flags",
    "deadline_msec": "deadline_ms",
    "lifespan_msec": "lifespan_ms",
    "timebasedfilter_msec": "time_based_filter_ms",
    "contentbased_filter": "content_based_filter",
}
OBJECTS = {
    "PARTICIPANT": (xrce.Participant, xrce.ParticipantBinary, None),
    "TOPIC": (xrce.Topic, xrce.TopicBinary, None),
    "PUBLISHER": (xrce.Publisher, xrce.PublisherBinary, xrce.GroupQos),
    "SUBSCRIBER": (xrce.Subscriber, xrce.SubscriberBinary, xrce.GroupQos),
    "DATAWRITER": (xrce.DataWriter, xrce.DataWriterBinary, xrce.DataWriterQos),
    "DATAREADER": (xrce.DataReader, xrce.DataReaderBinary, xrce.DataReaderQos),
    "REQUESTER": (xrce.Requester, xrce.RequesterBinary, None),
    "REPLIER": (xrce.Replier, xrce.ReplierBinary, None),
    "TYPE": (xrce.Type, None, None),
    "QOSPROFILE": (xrce.QosProfile, None, None),
    "APPLICATION": (xrce.Application, None, None),
}


def object_of(kind, fields):
    whole, binary, qos = OBJECTS[kind]
    form, said = fields["representation"]
    if form == "BINARY":
        if said.get("qos"):
            said = {**said, "qos": qos(**{RENAMED.get(name, name): value for name, value in said["qos"].items()})}
        representation = binary(**said)
    else:
        representation = xrce.ByReference(name=said) if form == "REFERENCE" else xrce.AsXml(text=said)
    return whole(**{**fields, "representation": representation})


def activity_of(kind, fields):
    match kind:
        case "AGENT":
            addresses = tuple(xrce.MediumLocator(address=one, port=port) for _, one, port in fields["address_seq"])
            return xrce.AgentActivity(availability=fields["availability"], addresses=addresses)
        case "DATAREADER":
            return xrce.DataReaderActivity(highest_acked=fields["highest_acked_num"])
    return xrce.DataWriterActivity(sample_sequence=fields["sample_seq_num"], stream_sequence=fields["stream_seq_num"])


def info_of(state, detail, values):
    both = ("sequence_number", "time_offset_ms")
    names = {"EMPTY": (), "SEQNUM": both[:1], "TIMESTAMP": both[1:], "SEQN_TIMS": both}[detail]
    return xrce.SampleInfo(state=state, **dict(zip(names, values, strict=True)))


def data_of(form, said):
    match form:
        case "DATA":
            return said
        case "SAMPLE":
            return xrce.Sample(info=info_of(*said["info"]), data=said["data"])
        case "DATA_SEQ":
            return xrce.DataSequence(count=said[0], data=said[1])
        case "SAMPLE_SEQ":
            return xrce.SampleSequence(count=said[0], data=said[1])
    return xrce.PackedSamples(base=info_of(*said[0]), count=said[1], data=said[2])


def specification_of(fields):
    control = fields["delivery_control"]
    delivery = control and xrce.DeliveryControl(
        max_samples=control["max_samples"],
        max_elapsed_s=control["max_elapsed_time"],
        max_bytes_per_s=control["max_bytes_per_second"],
        min_pace_ms=control["min_pace_period"],
    )
    return xrce.ReadSpecification(
        stream_id=fields["preferred_stream_id"],
        format=xrce.DataFormat(fields["data_format"]),
        content_filter=fields["content_filter_expression"],
        delivery=delivery,
    )


def split(fields, *names):
    """Fields under these names, and the others."""
    return {name: fields[name] for name in names}, {name: fields[name] for name in fields if name not in names}


def create(fields, flags):
    ids, others = split(fields, "request_id", "object_id")
    created = object_of(*others["object_representation"])
    return xrce.Create(**ids, object=created, reuse=bool(flags & 2), replace=bool(flags & 4))


def status_agent(fields, flags):
    result, others = split(fields, "status", "implementation_status")
    return xrce.StatusAgent(**result, agent=xrce.Agent(**client(others)))


def info(fields, flags):
    unions, others = split(fields, "config", "activity")
    config, activity = unions["config"], unions["activity"]
    return xrce.Info(
        **others,
        config=object_of(*config) if config else None,
        activity=activity_of(*activity) if activity else None,
    )


def with_data(kind):
    return lambda fields, flags: kind(**{**fields, "data": data_of(*fields["data"])}, little_endian=bool(flags & 1))


def read_data(fields, flags):
    ids, specification = split(fields, "request_id", "object_id")
    return xrce.ReadData(**ids, specification=specification_of(specification))


def numbers(kind, *names):
    return lambda fields, flags: kind(**dict(zip(names, fields.values(), strict=True)))


def times(kind):
    return lambda fields, flags: kind(
        **{name.removesuffix("_timestamp"): xrce.Time(*value) for name, value in fields.items()}
    )


MADE = {
    "CREATE_CLIENT": lambda fields, flags: xrce.CreateClient(client=xrce.Client(**client(fields))),
    "CREATE": create,
    "GET_INFO": lambda fields, flags: xrce.GetInfo(**fields),
    "DELETE": lambda fields, flags: xrce.Delete(**fields),
    "STATUS_AGENT": status_agent,
    "STATUS": lambda fields, flags: xrce.StatusReply(**fields),
    "INFO": info,
    "WRITE_DATA": with_data(xrce.WriteData),
    "READ_DATA": read_data,
    "DATA": with_data(xrce.TopicData),
    "ACKNACK": numbers(xrce.AckNack, "first_unacked", "nack_bitmap", "stream_id"),
    "HEARTBEAT": numbers(xrce.Heartbeat, "first_unacked", "last_unacked", "stream_id"),
    "RESET": lambda fields, flags: xrce.Reset(),
    "FRAGMENT": lambda fields, flags: xrce.Fragment(**fields, last=bool(flags & 2)),
    "TIMESTAMP": times(xrce.Timestamp),
    "TIMESTAMP_REPLY": times(xrce.TimestampReply),
}


def message_of(vector):
    """The submessage of the code that the row is about."""
    return MADE[vector.name](vector.fields, vector.flags)


def test_what_is_said_becomes_these_bytes():
    for vector in SUBMESSAGES:
        little_endian = bool(vector.flags & 1)
        assert xrce.encode_submessage(message_of(vector), little_endian=little_endian) == vector.data, vector


def test_these_bytes_say_it():
    for vector in SUBMESSAGES:
        (raw,) = xrce.split_submessages(vector.data)
        assert xrce.decode_submessage(raw) == message_of(vector), vector


def test_a_submessage_that_is_cut_says_nothing_else_than_before_or_is_refused():
    for vector in SUBMESSAGES:
        (raw,) = xrce.split_submessages(vector.data)
        whole = xrce.decode_submessage(raw)
        for length in range(len(raw.payload)):
            cut = xrce.RawSubmessage(id=raw.id, flags=raw.flags, payload=raw.payload[:length])
            try:
                said = xrce.decode_submessage(cut)
            except xrce.RemoteProtocolError:
                continue
            shorter = ("FRAGMENT", "WRITE_DATA", "DATA", "CREATE_CLIENT")  # all that is left, or a last field
            assert said != whole, vector
            assert vector.name in shorter, vector


def test_messages_become_these_bytes_and_back():
    first = {vector.name: vector for vector in reversed(SUBMESSAGES)}
    for vector in MESSAGES:
        header = xrce.Header(
            session_id=vector.session_id,
            stream_id=vector.stream_id,
            sequence=vector.sequence,
            client_key=vector.client_key,
        )
        said = [message_of(first[name]) for name in vector.submessages]
        body = xrce.pack_submessages(map(xrce.encode_submessage, said))
        assert xrce.encode_message(header, body) == vector.data, vector
        found, rest = xrce.decode_header(vector.data)
        assert (found, found.size) == (header, len(vector.data) - len(rest)), vector
        assert [xrce.decode_submessage(raw) for raw in xrce.split_submessages(rest)] == said, vector


def test_frames_become_these_bytes_and_back():
    for vector in FRAMES:
        options = xrce.FramingOptions(local_address=vector.source, remote_address=vector.destination)
        assert xrce.encode_frame(vector.payload, options) == vector.data, vector
        reader = xrce.FrameReader(xrce.FramingOptions(local_address=vector.destination))
        expected = xrce.Frame(raw=vector.data, source=vector.source, payload=vector.payload)
        assert reader.receive(vector.data) == [expected], vector
