"""What an agent of DDS-XRCE must do, with the checker as its client: on the model, or on another agent at a port."""

from __future__ import annotations

import pytest

from hilbench.bench.protocol_peer import ProtocolPeer
from hilbench.check import Violation, case
from hilbench.suites._xrce import (
    DATA_S,
    KEY,
    PARTICIPANT,
    PUBLISHER,
    READER,
    SUBSCRIBER,
    TOPIC,
    WRITER,
    Board,
    objects,
    xml_objects,
)
from protocols import xrce
from protocols.xrce import Status

ERRORS_FROM = 0x80
HEARTBEAT_S = 1.0
MS = 1_000_000


@pytest.fixture
def board(peer: ProtocolPeer) -> Board:
    """A client without a session."""
    return Board(peer)


@case("XA01", bench_time_s=0.5)
def test_a_session_begins(peer: ProtocolPeer) -> None:
    for session_id in (0x81, 0x01):
        board = Board(peer, session_id)
        header, said = board.connect()
        assert header == board.header(), f"STATUS_AGENT came with {header}"
        assert said.status is Status.OK
        assert said.agent.cookie == xrce.COOKIE
        assert said.agent.version == xrce.VERSION


@case("XA02", bench_time_s=0.5)
def test_who_is_no_client_is_refused(board: Board) -> None:
    for wrong in (
        xrce.Client(client_key=KEY, session_id=0x81, cookie=b"xrce", mtu=512),
        xrce.Client(client_key=KEY, session_id=0x81, version=b"\x02\x00", mtu=512),
        xrce.Client(client_key=bytes(4), session_id=0x81, mtu=512),
    ):
        _, said = board.connect(wrong)
        assert said.status >= ERRORS_FROM, f"{wrong} was accepted"


@case("XA03", bench_time_s=0.5)
def test_a_ping_is_answered(board: Board) -> None:
    for header in (xrce.Header(session_id=0x80), board.header()):
        if header.session_id == board.session_id:
            board.connect()
        asked = xrce.GetInfo(request_id=10, object_id=xrce.OBJECT_AGENT, info_mask=xrce.InfoMask.ACTIVITY)
        board.write(header, asked)
        answered, said = board.hear(xrce.Info)
        assert answered.session_id == header.session_id
        assert said.request_id == asked.request_id
        assert isinstance(said.activity, xrce.AgentActivity)
        assert said.activity.availability > 0


@case("XA04", bench_time_s=1.0)
def test_objects_are_created(board: Board) -> None:
    board.connect()
    for object_id, made in objects().items():
        assert board.create(object_id, made) is Status.OK, f"{type(made).__name__} was not created"


@case("XA05", bench_time_s=1.0)
def test_objects_are_created_from_xml(board: Board) -> None:
    board.connect()
    for object_id, made in xml_objects().items():
        assert board.create(object_id, made) is Status.OK, f"{type(made).__name__} was not created"


@case("XA06", bench_time_s=1.0)
def test_an_object_without_its_parent_is_refused(board: Board) -> None:
    board.connect()
    there = objects()
    for object_id in (TOPIC, PUBLISHER, SUBSCRIBER):
        assert board.create(object_id, there[object_id]) >= ERRORS_FROM
    assert board.create(PARTICIPANT, there[PARTICIPANT]) is Status.OK
    assert board.create(TOPIC, there[TOPIC]) is Status.OK
    for object_id in (WRITER, READER):
        assert board.create(object_id, there[object_id]) >= ERRORS_FROM


@case("XA07", bench_time_s=1.0)
def test_an_object_that_is_there_already(board: Board) -> None:
    board.begin()
    made = objects()[TOPIC]
    assert board.create(TOPIC, made) is Status.ALREADY_EXISTS
    assert board.create(TOPIC, made, reuse=True) is Status.OK_MATCHED
    assert board.create(TOPIC, made, replace=True) is Status.OK


@case("XA08", bench_time_s=1.0)
def test_an_object_is_deleted_once(board: Board) -> None:
    board.begin()
    assert board.delete(WRITER) is Status.OK
    assert board.delete(WRITER) is Status.UNKNOWN_REFERENCE


@case("XA09", bench_time_s=1.0)
def test_the_stream_of_an_answer(board: Board) -> None:
    board.connect()
    made = objects()[PARTICIPANT]
    for asked_on in (0x80, 0x01):
        board.say(xrce.Create(request_id=77, object_id=PARTICIPANT, object=made, replace=True), stream_id=asked_on)
        header, _ = board.hear(xrce.StatusReply)
        assert header.stream_id == asked_on


@case("XA10", bench_time_s=4.0)
def test_what_is_written_is_read(board: Board) -> None:
    board.begin()
    for stream_id in (0x80, 0x01):
        request_id = board.read(stream_id=stream_id)
        for number in range(5):
            data = bytes((number, stream_id, 0x7E, 0x7D)) * (1 + number)
            board.say(board.sample(data))
            header, said = board.hear(xrce.TopicData, DATA_S)
            assert header.stream_id == stream_id
            assert said == xrce.TopicData(request_id=request_id, object_id=READER, data=data)
        assert len(board.heard(xrce.TopicData, DATA_S)) == 1, "a sample came twice"


@case("XA11", bench_time_s=4.0)
def test_no_more_is_read_than_is_wanted(board: Board) -> None:
    board.begin()
    board.acknowledges = False
    board.read(2, stream_id=1)
    board.say(*(board.sample(bytes((number,))) for number in range(5)))
    assert len(board.heard(xrce.TopicData)) == 2
    board.read(stream_id=1)
    board.heard(xrce.TopicData)
    board.read(0, stream_id=1)
    board.say(board.sample(b"\x09"))
    assert board.heard(xrce.TopicData) == []


@case("XA12", bench_time_s=1.0)
def test_what_is_not_there_cannot_be_read(board: Board) -> None:
    board.connect()
    request_id = board.read()
    _, said = board.hear(xrce.StatusReply)
    assert said == xrce.StatusReply(request_id=request_id, object_id=READER, status=Status.UNKNOWN_REFERENCE)


@case("XA13", bench_time_s=2.0)
def test_the_order_of_a_reliable_stream(board: Board) -> None:
    board.begin()
    board.read(stream_id=1)
    for number in (1, 2):
        board.write(board.header(0x81, number), board.sample(bytes((number,))))
        _, said = board.hear(xrce.AckNack, where=lambda one: one.stream_id == 0x81)
        assert said.first_unacked == 0
        assert said.nack_bitmap & 1, "the message that is missing is not named"
        assert not said.nack_bitmap >> number & 1, "a message that came is named as missing"
    board.write(board.header(0x81, 0), board.sample(b"\x00"))
    assert [said.data for said in board.heard(xrce.TopicData)] == [b"\x00", b"\x01", b"\x02"]


@case("XA14", bench_time_s=2.0)
def test_a_message_that_comes_twice(board: Board) -> None:
    board.begin()
    board.read(stream_id=1)
    said = board.sample(b"once")
    for times in (1, 2):
        board.write(board.header(0x81, 0), said)
        _, answer = board.hear(xrce.AckNack, where=lambda one: one.stream_id == 0x81)
        assert answer.first_unacked == 1
        assert len(board.heard(xrce.TopicData)) == (1 if times == 1 else 0), "it was obeyed twice"


@case("XA15", bench_time_s=1.0)
def test_a_heartbeat_is_answered(board: Board) -> None:
    board.begin()
    board.write(board.header(), xrce.Heartbeat(first_unacked=0, last_unacked=2, stream_id=0x81))
    _, said = board.hear(xrce.AckNack, where=lambda one: one.stream_id == 0x81)
    assert (said.first_unacked, said.nack_bitmap) == (0, 0b111)


@case("XA16", bench_time_s=4.0)
def test_what_is_not_acknowledged_is_sent_again(board: Board) -> None:
    board.begin()
    board.read(stream_id=0x81)
    board.acknowledges = False
    board.say(board.sample(b"again"))
    header, first = board.hear(xrce.TopicData, DATA_S)
    _, beat = board.hear(xrce.Heartbeat, HEARTBEAT_S, where=lambda one: one.stream_id == 0x81)
    assert beat.first_unacked == header.sequence
    missing = xrce.AckNack(first_unacked=header.sequence, nack_bitmap=1, stream_id=0x81)
    board.write(board.header(), missing)
    again, second = board.hear(xrce.TopicData)
    assert (again, second) == (header, first)


@case("XA17", bench_time_s=1.5)
def test_fragments_are_put_together(board: Board) -> None:
    board.begin()
    board.read(stream_id=1)
    said = board.sample(bytes(range(100)))
    whole = xrce.encode_submessage(said)
    pieces = [whole[at : at + 40] for at in range(0, len(whole), 40)]
    for place, piece in enumerate(pieces):
        board.say(xrce.Fragment(data=piece, last=place == len(pieces) - 1))
    _, heard = board.hear(xrce.TopicData, DATA_S)
    assert heard.data == said.data


@case("XA18", bench_time_s=3.0)
def test_a_best_effort_stream_goes_forward(board: Board) -> None:
    board.begin()
    board.read(stream_id=1)
    for number, obeyed in ((5, True), (5, False), (3, False), (6, True)):
        board.write(board.header(0x02, number), board.sample(bytes((number,))))
        assert len(board.heard(xrce.TopicData)) == obeyed, f"message {number}"


@case("XA19", bench_time_s=1.5)
def test_a_client_begins_anew(board: Board) -> None:
    board.begin()
    board.connect()
    board.say(xrce.Create(request_id=78, object_id=PARTICIPANT, object=objects()[PARTICIPANT], replace=True))
    header, said = board.hear(xrce.StatusReply)
    assert (header.stream_id, header.sequence) == (0x80, 0)
    assert said.status is Status.OK


@case("XA20", bench_time_s=2.0)
def test_what_a_client_had_is_gone(board: Board) -> None:
    board.begin()
    board.write(board.header(), xrce.Delete(request_id=2, object_id=xrce.OBJECT_CLIENT))
    header, said = board.hear(xrce.StatusReply)
    assert header == board.header()
    assert said == xrce.StatusReply(request_id=2, object_id=xrce.OBJECT_CLIENT, status=Status.OK)
    board.connect()
    for object_id, made in objects().items():
        assert board.create(object_id, made) is Status.OK, f"{type(made).__name__} is still there"


@case("XA21", bench_time_s=0.5)
def test_the_time_is_told(board: Board) -> None:
    board.connect()
    asked = xrce.Time(7, 123_456_789)
    board.write(board.header(), xrce.Timestamp(transmit=asked))
    _, said = board.hear(xrce.TimestampReply)
    assert said.originate == asked
    assert 0 <= said.transmit.ns - said.receive.ns < 200 * MS


@case("XA22", bench_time_s=3.0)
def test_damage_costs_one_frame(board: Board) -> None:
    board.connect()
    made = xrce.Create(request_id=79, object_id=PARTICIPANT, object=objects()[PARTICIPANT])
    sound = xrce.encode_frame(xrce.encode_message(board.header(), xrce.encode_submessage(made)))
    for damaged in (sound[:-1] + bytes((sound[-1] ^ 1,)), sound[: len(sound) // 2], b"\x00\xff\x12noise"):
        mark = board.peer.mark()
        board.peer.write(damaged)
        board.peer.run(0.1)
        if board.peer.mark() != mark:
            raise Violation(f"{damaged.hex(' ').upper()} was answered")
        board.write(board.header(), xrce.Timestamp(transmit=xrce.Time()))
        board.hear(xrce.TimestampReply)


@case("XA23", bench_time_s=1.5)
def test_either_byte_order(board: Board) -> None:
    board.connect()
    for object_id, made in objects().items():
        request_id = board.request_id()
        said = xrce.Create(request_id=request_id, object_id=object_id, object=made)
        board.say(raw_of(said))
        _, answer = board.hear(xrce.StatusReply)
        assert answer.request_id == request_id
        assert answer.status is Status.OK, f"{type(made).__name__} was not created"
    control = xrce.DeliveryControl(max_samples=1)
    specification = xrce.ReadSpecification(stream_id=1, delivery=control)
    board.say(raw_of(xrce.ReadData(request_id=80, object_id=READER, specification=specification)))
    board.say(board.sample(b"1"), board.sample(b"2"))
    assert [said.data for said in board.heard(xrce.TopicData)] == [b"1"]


def raw_of(said: xrce.Submessage) -> xrce.RawSubmessage:
    """A submessage with its numbers in big-endian."""
    data = xrce.encode_submessage(said, little_endian=False)
    return xrce.RawSubmessage(id=data[0], flags=data[1], payload=data[4:])
