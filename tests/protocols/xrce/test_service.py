"""The agent with all its lines: what clients create, what reaches whom, what is kept, and for how long."""

from __future__ import annotations

import pytest

from protocols import xrce
from protocols.xrce import AgentOptions, CloseReason, Status
from tests.each import each
from tests.protocols.xrce.star import (
    FLOAT,
    MS,
    PARTICIPANT,
    PUBLISHER,
    READER,
    REPLIER,
    REQUESTER,
    SECOND,
    SUBSCRIBER,
    TOPIC,
    WRITER,
    Star,
    objects,
)

PARTICIPANT_XML = "<dds><participant><rtps><name>default_xrce_participant</name></rtps></participant></dds>"
TOPIC_XML = f"<dds><topic><name>rt/speed</name><dataType>{FLOAT}</dataType></topic></dds>"
ENDPOINT_XML = (
    "<dds><{0}><historyMemoryPolicy>PREALLOCATED_WITH_REALLOC</historyMemoryPolicy><qos><reliability><kind>{1}</kind>"
    "</reliability></qos><topic><kind>NO_KEY</kind><name>rt/speed</name><dataType>" + FLOAT + "</dataType><historyQos>"
    "<kind>KEEP_LAST</kind><depth>5</depth></historyQos></topic></{0}></dds>"
)
SERVICE_XML = (
    '<dds><{0} profile_name="p" service_name="add" request_type="Request_" reply_type="Response_">'
    "<request_topic_name>rq/addRequest</request_topic_name><reply_topic_name>rr/addReply</reply_topic_name></{0}></dds>"
)
SERVICE = {
    "service_name": "add",
    "request_type": "Request_",
    "reply_type": "Response_",
    "request_topic_name": "rq/addRequest",
    "reply_topic_name": "rr/addReply",
}


def connected(*names, **options):
    star = Star(*names, **options)
    star.connect()
    return star


def xml_objects(writer="RELIABLE", reader="RELIABLE"):
    """As `objects`, in the XML that micro-ROS sends."""
    return {
        PARTICIPANT: xrce.Participant(representation=xrce.AsXml(text=PARTICIPANT_XML)),
        TOPIC: xrce.Topic(representation=xrce.AsXml(text=TOPIC_XML), participant_id=PARTICIPANT),
        PUBLISHER: xrce.Publisher(representation=xrce.AsXml(text=""), participant_id=PARTICIPANT),
        SUBSCRIBER: xrce.Subscriber(representation=xrce.AsXml(text=""), participant_id=PARTICIPANT),
        WRITER: xrce.DataWriter(
            representation=xrce.AsXml(text=ENDPOINT_XML.format("data_writer", writer)), publisher_id=PUBLISHER
        ),
        READER: xrce.DataReader(
            representation=xrce.AsXml(text=ENDPOINT_XML.format("data_reader", reader)), subscriber_id=SUBSCRIBER
        ),
    }


@each("session_ids", [{}, {"a": 0x01, "b": 0x7F}, {"a": 0xFF}])
@each("made", [objects(), xml_objects()])
def test_what_one_client_writes_another_one_reads(session_ids, made):
    star = connected("a", "b", session_ids=session_ids)
    for name in ("a", "b"):
        for object_id, one in made.items():
            assert star.create(name, object_id, one) is Status.OK
    star.read("b")
    for number in range(20):
        star.write("a", bytes((number,)))
    star.run(SECOND)
    assert star.data("b") == [bytes((number,)) for number in range(20)]
    assert star.data("a") == []
    samples = star.of(xrce.SampleRouted)
    assert samples == [xrce.SampleRouted(line="a", domain_id=0, topic="rt/speed", size=1, readers=2)] * 20
    assert {(said.request_id, said.object_id) for _, said in star.heard["b"] if isinstance(said, xrce.TopicData)} == {
        (20, READER)
    }


def test_the_bytes_of_data_are_those_of_the_writer_in_its_order():
    star = connected("a", "b")
    star.create_all("a")
    star.create_all("b")
    star.read("b", stream_id=1)
    for little_endian in (True, False):
        star.say("a", xrce.WriteData(request_id=30, object_id=WRITER, data=b"\1\2", little_endian=little_endian))
    star.run(SECOND)
    heard = [said for stream, said in star.heard["b"] if stream == 1]
    assert heard == [
        xrce.TopicData(request_id=20, object_id=READER, data=b"\1\2", little_endian=order) for order in (True, False)
    ]


@each(
    ("representation", "expected"),
    [
        ({"object_id": 0x21, "participant": xrce.AsXml(text="<dds>")}, Status.INVALID_DATA),
        ({"object_id": 0x21, "participant": xrce.AsXml(text="<!DOCTYPE dds><dds/>")}, Status.INVALID_DATA),
        ({"object_id": 0x21, "participant": xrce.ByReference(name="anything")}, Status.OK),
    ],
)
def test_participants(representation, expected):
    star = connected("a")
    made = xrce.Participant(representation=representation.get("participant", xrce.ParticipantBinary()))
    assert star.create("a", representation["object_id"], made) is expected


@each(
    ("object_id", "missing"),
    [
        (TOPIC, PARTICIPANT),
        (PUBLISHER, PARTICIPANT),
        (SUBSCRIBER, PARTICIPANT),
        (WRITER, PUBLISHER),
        (WRITER, TOPIC),
        (READER, SUBSCRIBER),
        (READER, TOPIC),
    ],
)
def test_what_an_object_belongs_to_has_to_be_there_and_takes_it_with_it(object_id, missing):
    star = connected("a")
    star.create_all("a")
    (said,) = star.ask("a", xrce.Delete(request_id=11, object_id=missing))
    assert said == xrce.StatusReply(request_id=11, object_id=missing, status=Status.OK)
    assert object_id not in star.agent.objects["a"]
    assert star.create("a", object_id, objects()[object_id]) is Status.UNKNOWN_REFERENCE
    (said,) = star.ask("a", xrce.Delete(request_id=11, object_id=missing))
    assert said.status is Status.UNKNOWN_REFERENCE


def test_the_kind_in_an_id_is_that_of_what_is_meant():
    star = connected("a")
    made = objects()
    assert star.create("a", 0x10, made[PARTICIPANT]) is Status.OK
    topic = xrce.Topic(representation=made[TOPIC].representation, participant_id=0x1F)
    assert star.create("a", 0x1A, topic) is Status.OK
    assert (
        star.create("a", 0x10, xrce.Publisher(representation=xrce.PublisherBinary(), participant_id=0x10)) is Status.OK
    )
    writer = xrce.DataWriter(representation=xrce.DataWriterBinary(topic_id=0x10), publisher_id=0x10)
    assert star.create("a", 0x10, writer) is Status.OK
    assert [*star.agent.objects["a"]] == [PARTICIPANT, TOPIC, PUBLISHER, WRITER]
    star.write("a", b"1")
    star.run(SECOND)
    assert star.of(xrce.SampleRouted)[0].topic == "rt/speed"


@each(
    ("flags", "other", "expected"),
    [
        ({}, False, Status.ALREADY_EXISTS),
        ({"reuse": True}, False, Status.OK_MATCHED),
        ({"reuse": True}, True, Status.MISMATCH),
        ({"replace": True}, False, Status.OK),
        ({"replace": True}, True, Status.OK),
        ({"reuse": True, "replace": True}, False, Status.OK_MATCHED),
        ({"reuse": True, "replace": True}, True, Status.OK),
    ],
)
def test_an_object_that_is_there_already(flags, other, expected):
    """The table of OMG DDS-XRCE 1.0, 7.8.3.2."""
    star = connected("a")
    star.create_all("a")
    made = objects(topic="rt/other" if other else "rt/speed")[TOPIC]
    assert star.create("a", TOPIC, made, **flags) is expected
    is_new = expected is Status.OK and other
    assert (star.agent.objects["a"][TOPIC].topic.name == "rt/other") is is_new


@each(
    ("made", "object_id"),
    [
        (xrce.Topic(representation=xrce.ByReference(name="no_such"), participant_id=PARTICIPANT), 0x22),
        (xrce.DataWriter(representation=xrce.ByReference(name="no_such"), publisher_id=PUBLISHER), 0x25),
        (xrce.DataReader(representation=xrce.ByReference(name="no_such"), subscriber_id=SUBSCRIBER), 0x26),
        (xrce.Requester(representation=xrce.ByReference(name="no_such"), participant_id=PARTICIPANT), REQUESTER),
        (xrce.Replier(representation=xrce.ByReference(name="no_such"), participant_id=PARTICIPANT), REPLIER),
    ],
)
def test_a_reference_to_nothing(made, object_id):
    star = connected("a")
    star.create_all("a")
    assert star.create("a", object_id, made) is Status.UNKNOWN_REFERENCE


def test_references_mean_the_profiles_of_the_configuration():
    def profile(text, tag, name):
        return text.replace("<dds>", "").replace("</dds>", "").replace(f"<{tag}>", f'<{tag} profile_name="{name}">')

    parts = [
        profile(TOPIC_XML, "topic", "t"),
        profile(ENDPOINT_XML.format("data_writer", "RELIABLE"), "data_writer", "w"),
        profile(ENDPOINT_XML.format("data_reader", "RELIABLE"), "data_reader", "r"),
    ]
    text = f"<?xml version='1.0' encoding='UTF-8'?><profiles><!-- ours -->{''.join(parts)}</profiles>"
    star = connected("a", options=AgentOptions(references=text))
    made = xml_objects() | {
        TOPIC: xrce.Topic(representation=xrce.ByReference(name="t"), participant_id=PARTICIPANT),
        WRITER: xrce.DataWriter(representation=xrce.ByReference(name="w"), publisher_id=PUBLISHER),
        READER: xrce.DataReader(representation=xrce.ByReference(name="r"), subscriber_id=SUBSCRIBER),
    }
    for object_id, one in made.items():
        assert star.create("a", object_id, one) is Status.OK
    star.read("a")
    star.write("a", b"own")
    star.run(SECOND)
    assert star.data("a") == [b"own"]
    with pytest.raises(xrce.LocalProtocolError, match="references"):
        xrce.Profiles("<profiles>")


@each(
    ("other", "why"),
    [
        ({"type_name": "Other_"}, "type"),
        ({"reader": xrce.DataReaderQos(flags=1), "writer": xrce.DataWriterQos(flags=0)}, "reliable"),
        ({"reader": xrce.DataReaderQos(flags=0x08), "writer": xrce.DataWriterQos(flags=1)}, "before its time"),
    ],
)
def test_ends_that_cannot_speak_to_each_other_are_said_to(other, why):
    star = connected("a", "b")
    star.create_all("a", **({} if "type_name" in other else {"writer": other["writer"]}))
    star.create_all("b", **{name: one for name, one in other.items() if name != "writer"})
    star.read("b")
    star.write("a", b"1")
    star.run(SECOND)
    assert star.data("b") == []
    assert any(why in one.why for one in star.of(xrce.Mismatch))


def test_another_domain_is_another_world():
    star = connected("a", "b")
    star.create_all("a", domain_id=0)
    star.create_all("b", domain_id=1)
    star.read("b")
    star.write("a", b"1")
    star.run(SECOND)
    assert star.data("b") == []
    assert star.of(xrce.Mismatch) == []
    assert [*star.agent.space.topics] == [(0, "rt/speed"), (1, "rt/speed")]


def test_who_comes_later_gets_what_is_kept_for_him_and_nothing_else():
    star = connected("a", "b", "c")
    latched = xrce.DataWriterQos(flags=0x09, history_depth=2)
    star.create_all("a", writer=latched)
    for number in range(5):
        star.write("a", bytes((number,)))
    star.run(SECOND)
    star.create_all("b", reader=xrce.DataReaderQos(flags=0x09))
    star.create_all("c", reader=xrce.DataReaderQos(flags=0x01))
    for name in ("b", "c"):
        star.read(name)
    star.run(SECOND)
    assert star.data("b") == [b"\3", b"\4"]
    assert star.data("c") == []


# --- READ_DATA


def test_a_read_without_control_is_for_one_sample_and_the_rest_waits():
    star = connected("a")
    star.create_all("a")
    for number in range(3):
        star.write("a", bytes((number,)))
    star.run(SECOND)
    for number in range(3):
        assert star.data("a") == [bytes((one,)) for one in range(number)]
        specification = xrce.ReadSpecification(stream_id=0x80)
        (said,) = star.ask("a", xrce.ReadData(request_id=40, object_id=READER, specification=specification))
        assert said == xrce.TopicData(request_id=40, object_id=READER, data=bytes((number,)))


def test_no_more_samples_than_wanted_then_nothing_and_a_read_of_none_ends_it():
    star = connected("a")
    star.create_all("a")
    star.read("a", max_samples=2)
    for number in range(4):
        star.write("a", bytes((number,)))
    star.run(SECOND)
    assert star.data("a") == [b"\0", b"\1"]
    star.read("a", request_id=21)
    star.read("a", request_id=22, max_samples=0)
    star.write("a", b"\4")
    star.run(SECOND)
    assert star.data("a") == [b"\0", b"\1", b"\2", b"\3"]


def test_a_read_is_over_after_its_time():
    star = connected("a")
    star.create_all("a")
    star.read("a", max_elapsed_s=2)
    star.write("a", b"1")
    star.run(3 * SECOND)
    star.write("a", b"2")
    star.run(SECOND)
    assert star.data("a") == [b"1"]


@each("control", [{"min_pace_ms": 200}, {"max_bytes_per_s": 500}])
def test_samples_come_no_faster_than_wanted(control):
    star = connected("a")
    star.create_all("a")
    star.read("a", **control)
    for _ in range(5):
        star.write("a", bytes(100))
    for step in range(1, 6):
        assert len(star.data("a")) <= step
        star.run(200 * MS)
    star.run(20 * MS)
    assert len(star.data("a")) == 5


@each(
    "said",
    [
        xrce.WriteData(request_id=31, object_id=0x35, data=b""),
        xrce.WriteData(request_id=31, object_id=TOPIC, data=b""),
        xrce.ReadData(request_id=31, object_id=0x36, specification=xrce.ReadSpecification(stream_id=0x80)),
        xrce.ReadData(request_id=31, object_id=WRITER, specification=xrce.ReadSpecification(stream_id=0x80)),
    ],
)
def test_data_of_what_is_not_there(said):
    star = connected("a")
    star.create_all("a")
    (heard,) = star.ask("a", said)
    assert heard == xrce.StatusReply(request_id=31, object_id=said.object_id, status=Status.UNKNOWN_REFERENCE)
    assert star.of(xrce.RequestFailed)[-1].status is Status.UNKNOWN_REFERENCE


def test_several_samples_in_one_are_refused_as_nobody_can_tell_them_apart():
    star = connected("a")
    star.create_all("a")
    many = xrce.DataSequence(count=2, data=b"\1\2")
    (heard,) = star.ask("a", xrce.WriteData(request_id=31, object_id=WRITER, data=many))
    assert heard.status is Status.INVALID_DATA


def test_long_samples_go_in_fragments_and_are_refused_on_a_best_effort_stream():
    star = connected("a", "b", mtu=128)
    star.create_all("a")
    star.create_all("b")
    star.read("b")
    long = bytes(range(256)) * 20
    star.write("a", long)
    star.run(5 * SECOND)
    assert star.data("b") == [long]
    star.read("b", stream_id=1, request_id=21)
    star.write("a", long)
    star.write("a", b"short")
    star.run(5 * SECOND)
    assert star.data("b", stream_id=1) == [b"short"]
    assert star.agent.counters.undeliverable == 1
    told = star.of(xrce.SampleTooLong)
    assert [(one.line, one.stream_id, one.topic, one.size) for one in told] == [("b", 1, "rt/speed", len(long))]


@each("depth", [1, 5, None])
def test_what_is_read_does_not_depend_on_how_the_bytes_are_cut(depth):
    """More samples than are kept, and a READ_DATA in their midst, by which those before it are read first."""

    def heard(*, whole):
        star = connected("a", "b")
        reader = xrce.DataReaderQos(history_depth=depth)
        star.create_all("a", reader=reader)
        star.create_all("b", reader=reader)
        star.read("b", stream_id=1)
        said = [xrce.WriteData(request_id=30, object_id=WRITER, data=bytes((number,))) for number in range(200)]
        specification = xrce.ReadSpecification(stream_id=2, delivery=xrce.DeliveryControl(max_samples=xrce.UNLIMITED))
        said.insert(100, xrce.ReadData(request_id=21, object_id=READER, specification=specification))
        frames = [star.clients["a"].send(one, star.now_ns, stream_id=1) for one in said]
        for data in [b"".join(frames)] if whole else frames:
            star._wrote(star.agent.receive("a", data, star.now_ns))
        star.run(SECOND)
        return star.data("b", stream_id=1), star.data("a", stream_id=2)

    of_b, of_a = heard(whole=True)
    assert (of_b, of_a) == heard(whole=False)
    assert of_b == [bytes((number,)) for number in range(200)]
    assert of_a == of_b[100 - (depth or 16) :]


@each("stream_id", [0x80, 1])
def test_all_samples_of_one_message_are_read(stream_id):
    star = connected("a", "b", mtu=4096)
    star.create_all("a")
    star.create_all("b")
    star.read("b", stream_id=stream_id)
    listened = []
    star.agent.listen("rt/speed", FLOAT, lambda sample: listened.append(sample.data))
    many = [bytes((number,)) for number in range(40)]
    star.say("a", *(xrce.WriteData(request_id=30, object_id=WRITER, data=data) for data in many))
    star.run(SECOND)
    assert star.data("b", stream_id=stream_id) == listened == many


# --- services


@each("xml", [False, True])
def test_a_request_reaches_the_server_and_its_reply_the_one_who_asked(xml):
    star = connected("asks", "asks-too", "answers")
    for name in star.clients:
        assert star.create(name, PARTICIPANT, objects()[PARTICIPANT]) is Status.OK
    asks = xrce.AsXml(text=SERVICE_XML.format("requester")) if xml else xrce.RequesterBinary(**SERVICE)
    answers = xrce.AsXml(text=SERVICE_XML.format("replier")) if xml else xrce.ReplierBinary(**SERVICE)
    for name in ("asks", "asks-too"):
        made = xrce.Requester(representation=asks, participant_id=PARTICIPANT)
        assert star.create(name, REQUESTER, made) is Status.OK
        star.read(name, REQUESTER)
    made = xrce.Replier(representation=answers, participant_id=PARTICIPANT)
    assert star.create("answers", REPLIER, made) is Status.OK
    star.read("answers", REPLIER)
    for name, number in (("asks", 0x1234), ("asks-too", 7), ("asks", 8)):
        star.write(name, b"question of " + name.encode(), REQUESTER, request_id=number)
        star.run(SECOND)
    questions = star.data("answers")
    assert [one[24:] for one in questions] == [b"question of asks", b"question of asks-too", b"question of asks"]
    assert len({one[:24] for one in questions}) == 3
    for one in reversed(questions):
        star.write("answers", one[:24] + b"answer to " + one[24:], REPLIER)
    star.run(SECOND)
    assert star.data("asks") == [
        bytes.fromhex("0008 0017") + b"answer to question of asks",
        bytes.fromhex("1234 0017") + b"answer to question of asks",
    ]
    assert star.data("asks-too") == [bytes.fromhex("0007 0017") + b"answer to question of asks-too"]
    (heard,) = star.ask("answers", xrce.WriteData(request_id=31, object_id=REPLIER, data=bytes(23)))
    assert heard.status is Status.INVALID_DATA


# --- sessions


@each(("asked_on", "answered_on"), [(0x80, 0x80), (0x81, 0x80), (1, 1), (0, 1)])
def test_the_stream_of_an_answer(asked_on, answered_on):
    star = connected("a")
    asked = xrce.Create(request_id=10, object_id=PARTICIPANT, object=objects()[PARTICIPANT])
    star.say("a", asked, stream_id=asked_on)
    star.run(SECOND)
    answer = xrce.StatusReply(request_id=10, object_id=PARTICIPANT, status=Status.OK)
    assert star.heard["a"] == [(answered_on, answer)]


@each("line", ["a", "b"])
def test_the_same_client_again_has_nothing_of_what_it_had(line):
    star = connected("a", "b")
    star.create_all("a")
    star.read("a")
    star.write("a", b"1")
    star.run(SECOND)
    star.client_options[line] = star.client_options["a"]
    star.restart(line)
    star.connect(line)
    assert star.agent.objects == {"a": {}, "b": {}}
    assert star.agent.space.topics == {}
    star.create_all(line)
    star.write(line, b"2")
    star.run(SECOND)
    assert star.data(line) == []  # the reading went with the rest
    star.read(line)
    assert star.data(line) == [b"2"]
    open_lines = [name for name, one in star.agent.sessions.items() if one.state is xrce.AgentState.OPEN]
    assert line in open_lines
    assert ("a" in open_lines) is (line == "a")


@each("how", ["delete", "line", "silence"])
def test_what_a_client_has_created_goes_with_it(how):
    star = connected("a", "b", options=AgentOptions(silence_s=30.0))
    star.create_all("a")
    if how == "delete":
        star._took("a", star.clients["a"].disconnect(star.now_ns))
    elif how == "line":
        star.agent.line_down("a", star.now_ns)
    star.run(SECOND if how != "silence" else 40 * SECOND)
    assert star.agent.objects["a"] == {}
    assert star.agent.space.topics == {}
    closed = [one.event.reason for one in star.of(xrce.ClientEvent) if isinstance(one.event, xrce.SessionClosed)]
    reasons = {"delete": CloseReason.DELETED, "line": CloseReason.LINE_DOWN, "silence": CloseReason.SILENCE}
    assert closed[0] is reasons[how]


def test_a_request_is_answered_in_the_session_that_it_was_made_in():
    """A board that is reset says all of it in one write: nothing of the first session is answered in the second."""
    star = Star("a")
    client, other = star.clients["a"], xrce.Session(xrce.Role.CLIENT, star.client_options["a"])
    client.receive(star.agent.receive("a", client.connect(0)[-1].data, 0)[0][1], 0)
    stale = client.send(xrce.Create(request_id=10, object_id=PARTICIPANT, object=objects()[PARTICIPANT]), 0)
    written = star.agent.receive("a", stale + other.connect(0)[-1].data, 0)
    found = [one for _, data in written for one in xrce.FrameReader().receive(data)]
    headers = [xrce.decode_header(one.payload)[1][0] for one in found]
    last = max(at for at, one in enumerate(headers) if one == xrce.SubmessageId.STATUS_AGENT)
    assert xrce.SubmessageId.STATUS in headers[:last]
    assert xrce.SubmessageId.STATUS not in headers[last:]
    assert star.agent.objects["a"] == {}


def test_get_info_tells_what_an_object_is_and_how_far_it_has_come():
    star = connected("a")
    star.create_all("a")
    star.read("a")
    star.write("a", b"1")
    star.run(SECOND)
    both = xrce.InfoMask.CONFIGURATION | xrce.InfoMask.ACTIVITY
    for object_id, activity in (
        (WRITER, xrce.DataWriterActivity(sample_sequence=1, stream_sequence=0)),
        (READER, xrce.DataReaderActivity(highest_acked=1)),
        (TOPIC, None),
    ):
        (said,) = star.ask("a", xrce.GetInfo(request_id=50, object_id=object_id, info_mask=both))
        expected = {"request_id": 50, "object_id": object_id, "activity": activity}
        assert said == xrce.Info(**expected, config=objects()[object_id])
    (said,) = star.ask("a", xrce.GetInfo(request_id=50, object_id=0x35, info_mask=both))
    assert said.status is Status.UNKNOWN_REFERENCE


# --- what is bounded


def test_a_client_can_create_no_more_than_so_many_objects():
    star = connected("a", options=AgentOptions(max_objects=3))
    made = objects()[PARTICIPANT]
    assert [star.create("a", number << 4 | 1, made) for number in range(5)] == [Status.OK] * 3 + [Status.RESOURCES] * 2
    assert star.create("a", 0x01, made, replace=True) is Status.OK


def test_a_client_can_read_on_no_more_than_so_many_reliable_streams_beside_the_built_in_one():
    star = connected("a", max_streams=3)
    star.create_all("a")

    def read(stream_id):
        specification = xrce.ReadSpecification(
            stream_id=stream_id, delivery=xrce.DeliveryControl(max_samples=xrce.UNLIMITED)
        )
        return star.ask("a", xrce.ReadData(request_id=20, object_id=READER, specification=specification))

    (said,) = [one for stream_id in (0x81, 0x82, 0x83, 0x84) for one in read(stream_id)]
    assert said == xrce.StatusReply(request_id=20, object_id=READER, status=Status.RESOURCES)
    star.write("a", b"on the last one that there was room for")
    star.run(SECOND)
    assert len(star.data("a", stream_id=0x83)) == 1
    assert [one for stream_id in (0x81, 0x80, 1, 0x7F) for one in read(stream_id)] == []
    with pytest.raises(xrce.LocalProtocolError, match="streams"):
        star.agent.sessions["a"].send(xrce.TopicData(request_id=20, object_id=READER, data=b""), 0, stream_id=0x90)


@each("made", [xml_objects(), objects()])
def test_descriptions_count_as_what_is_held(made):
    star = connected("a")
    for object_id, one in made.items():
        before = star.agent.held
        assert star.create("a", object_id, one) is Status.OK
        text = getattr(one.representation, "text", getattr(one.representation, "topic_name", ""))
        assert len(text) < star.agent.held - before < len(text) + 80
    (said,) = star.ask("a", xrce.Delete(request_id=11, object_id=PARTICIPANT))
    assert (said.status, star.agent.held) == (Status.OK, 0)


def test_a_client_that_never_reads_does_not_make_the_agent_grow():
    bounds = {"history": 10, "max_history_bytes": 4000}
    options = AgentOptions(streams=xrce.StreamOptions(max_queued=5000), **bounds)
    star = connected("a", "b", options=options, max_queued=5000)
    star.create_all("a")
    star.create_all("b")
    of_objects = star.agent.held
    star.read("b")
    star.read("b", stream_id=1, request_id=21)
    star.read("b", stream_id=0x80, request_id=22)
    star.deaf.add("b")
    most = 0
    for number in range(3000):
        star.write("a", number.to_bytes(4, "big") * 50, stream_id=1)
        star.run(MS)
        most = max(most, star.agent.held)
    assert most - of_objects <= 16 * 512 + 5000 + 2 * (4000 + 200)
    assert star.agent.objects["b"][READER].reader.waiting.overrun > 2000
    star.deaf.clear()
    star.run(10 * SECOND)
    heard = star.data("b")
    assert heard == sorted(heard)
    assert heard[-1] == (2999).to_bytes(4, "big") * 50


def test_reconnects_leave_nothing_behind():
    star = connected("a", "b")
    sizes = []
    for number in range(40):
        star.create_all("a")
        star.read("a")
        star.write("a", bytes(100))
        star.run((number % 7) * 3 * MS)
        star.restart("a")
        star.connect("a")
        sizes.append((star.agent.held, len(star.agent.objects["a"]), len(star.agent.space.topics)))
    assert set(sizes) == {(0, 0, 0)}


# --- a program beside the agent


def test_a_program_beside_the_agent_writes_and_listens():
    star = connected("a")
    star.create_all("a")
    star.read("a")
    heard = []
    reader = star.agent.listen("rt/speed", FLOAT, heard.append)
    star.write("a", b"of the client")
    star.run(SECOND)
    writer = star.agent.writer("rt/speed", FLOAT)
    star._wrote(star.agent.write(writer, b"of the bench", star.now_ns))
    star.run(SECOND)
    assert star.data("a") == [b"of the client", b"of the bench"]
    assert [one.data for one in heard] == [b"of the client", b"of the bench"]
    star.agent.silence(reader)
    star.agent.space.remove(writer)
    star.write("a", b"unheard")
    star.run(SECOND)
    assert len(heard) == 2


class Told:
    """Whom the data space tells."""

    def __init__(self):
        self.there = []
        self.samples = []
        self.opened, self.closed = self.there.append, self.there.remove

    def written(self, writer, sample):
        self.samples.append((writer.topic.name, sample.data))


def test_who_joins_it_to_another_data_space_is_told_of_all_and_hands_a_sample_to_one_reader():
    star = Star("a", "b")
    star.agent.space.outside = told = Told()
    star.connect()
    for name in ("a", "b"):
        star.create_all(name)
        star.read(name)
    assert [(type(one), one.topic.name) for one in told.there] == [
        (xrce.Writer, "rt/speed"),
        (xrce.Reader, "rt/speed"),
    ] * 2
    star.write("a", b"of a client")
    star.run(SECOND)
    star._wrote(star.agent.hand(told.there[3], xrce.StoredSample(data=b"from outside"), star.now_ns))
    star.run(SECOND)
    assert (star.data("a"), star.data("b")) == ([b"of a client"], [b"of a client", b"from outside"])
    assert told.samples == [("rt/speed", b"of a client")]
    assert star.of(xrce.SampleRouted)[-1] == xrce.SampleRouted(
        line="", domain_id=0, topic="rt/speed", size=12, readers=1
    )
    star.say("a", xrce.Delete(request_id=3, object_id=PARTICIPANT))
    star.run(SECOND)
    star._wrote(star.agent.line_down("b", star.now_ns))
    assert told.there == []


# --- over TCP


@each("framing", [xrce.Framing.LENGTH, xrce.Framing.SERIAL])
def test_the_framing_is_that_of_the_client_and_found_out_anew_on_each_line(framing):
    either = AgentOptions(frames=xrce.FramingOptions(framing=xrce.Framing.EITHER))
    star = connected("a", "b", options=either, framing=framing)
    for _ in range(2):
        star.create_all("a")
        star.read("a")
        star.write("a", b"1")
        star.run(SECOND)
        assert star.data("a") == [b"1"]
        star.agent.line_down("a", star.now_ns)
        star.restart("a")
        star.connect("a")
