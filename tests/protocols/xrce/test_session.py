"""A session on a sound line: how it begins and ends, what is said in it, what is nobody's business."""

from __future__ import annotations

import math

import pytest

from protocols import xrce
from protocols.testing import LATENCY_NS
from protocols.xrce import AgentState, ClientOptions, ClientState, CloseReason, Role, Session, Status
from tests.each import each

MS = 1_000_000
SECOND = 1000 * MS
KEY = bytes.fromhex("AABBCCDD")
IDS = {"request_id": 10, "object_id": 0x15}


def frame(submessage, *, session_id=0x81, stream_id=0, sequence=0, key=None):
    """A frame with one submessage in it."""
    header = xrce.Header(session_id=session_id, stream_id=stream_id, sequence=sequence, client_key=key)
    return xrce.encode_frame(xrce.encode_message(header, xrce.encode_submessage(submessage)))


def said_in(events):
    """What a session wants on the line: header and submessages of each frame."""
    said = []
    for event in events:
        if isinstance(event, xrce.Transmit):
            (found,) = xrce.FrameReader().receive(event.data)
            header, body = xrce.decode_header(found.payload)
            said.append((header, [xrce.decode_submessage(raw) for raw in xrce.split_submessages(body)]))
    return said


def client_of(**options):
    return Session(Role.CLIENT, ClientOptions(client_key=KEY, **options))


def open_agent(**options):
    agent = Session(Role.AGENT, xrce.AgentOptions(**options))
    agent.receive(frame(xrce.CreateClient(client=xrce.Client(client_key=KEY, session_id=0x81)), session_id=0x80), 0)
    return agent


@each("session_id", [0x81, 0x01, 0x7F, 0xFF])
def test_a_session_begins_says_and_ends(line, session_id):
    pair = line(session_id=session_id)
    pair.connect()
    pair.run(SECOND)
    pair.say("client", b"up")
    pair.say("server", b"down")
    pair.say("client", b"any", stream_id=1)
    pair.run(SECOND)
    assert (pair.heard("server"), pair.heard("client")) == ([b"up"], [b"down"])
    assert pair.heard("server", stream_id=1) == [b"any"]
    assert pair.client.unacknowledged == pair.server.unacknowledged == 0
    pair.disconnect()
    pair.run(SECOND)
    assert (pair.client.state, pair.server.state) == (ClientState.CLOSED, AgentState.LISTENING)
    opened = pair.of(xrce.SessionOpened)
    assert [type(event.peer) for event in opened] == [xrce.Client, xrce.Agent]
    assert opened[0].peer.client_key == KEY
    assert [event.reason for event in pair.of(xrce.SessionClosed)] == [CloseReason.DELETED] * 2
    assert pair.of(xrce.Senseless) == []


def test_the_first_bytes_of_a_client_are_those_of_micro_ros():
    """CREATE_CLIENT in session 80, mtu and all; without an answer ten times, a second apart."""
    client = client_of()
    ((header, (said,)),) = said_in(client.connect(0))
    assert header == xrce.Header(session_id=0x80)
    assert said == xrce.CreateClient(client=xrce.Client(client_key=KEY, session_id=0x81, mtu=512))
    events = [event for step in range(1, 12) for event in client.advance(step * SECOND)]
    assert len(said_in(events)) == 9
    assert events[-1] == xrce.SessionClosed(reason=CloseReason.NO_ANSWER)
    assert client.next_deadline_ns() is None


def test_an_agent_answers_in_the_session_that_is_asked_for():
    agent = Session(Role.AGENT)
    asked = xrce.Client(client_key=KEY, session_id=0x01, mtu=256, properties=(("uxr_hl", "000100"),))
    events = agent.receive(frame(xrce.CreateClient(client=asked), session_id=0x00, key=KEY), 0)
    ((header, (said,)),) = said_in(events)
    assert header == xrce.Header(session_id=0x01, client_key=KEY)
    assert said == xrce.StatusAgent(status=Status.OK, agent=xrce.Agent())
    assert xrce.SessionOpened(peer=asked) in events
    assert agent.mtu == 256


def test_an_agent_answers_to_the_address_that_asks():
    """eProsima's serial transport lets a client have any address; its agent answers to that."""
    agent = Session(Role.AGENT)
    client = client_of(frames=xrce.FramingOptions(local_address=5))
    answer = agent.receive(client.connect(0)[-1].data, 0)
    assert [type(event) for event in client.receive(answer[1].data, 0)] == [xrce.StateChanged, xrce.SessionOpened]
    (found,) = xrce.FrameReader(xrce.FramingOptions(local_address=5)).receive(
        agent.send(xrce.TopicData(**IDS, data=b""), 0)
    )
    assert found.source == 0


def test_a_session_keeps_the_address_that_it_was_asked_for_from():
    """No CRC covers the addresses: one that came wrong must not take the session away from a client that only reads."""
    agent = open_agent()
    header = xrce.Header(session_id=0x81)
    heard = xrce.encode_submessage(xrce.WriteData(**IDS, data=b""))
    wrong = xrce.FramingOptions(local_address=4)
    events = agent.receive(xrce.encode_frame(xrce.encode_message(header, heard), wrong), 1)
    assert xrce.Received(stream_id=0, submessage=xrce.WriteData(**IDS, data=b"")) in events
    assert agent.send(xrce.TopicData(**IDS, data=b""), 1)[1:3] == bytes((0, 0))
    ping = xrce.encode_submessage(xrce.GetInfo(request_id=10, object_id=xrce.OBJECT_AGENT, info_mask=2))
    (pong,) = agent.receive(xrce.encode_frame(xrce.encode_message(header, ping), wrong), 1)
    assert pong.data[1:3] == bytes((0, 4))


def test_a_client_with_properties_says_a_length_without_them():
    """As eProsima's does: CREATE_CLIENT_PAYLOAD_SIZE is 16 in any case (session_info_internal.h)."""
    asked = xrce.Client(client_key=KEY, session_id=0x81, mtu=512, properties=(("uxr_hl", "000100"),))
    whole = xrce.encode_submessage(xrce.CreateClient(client=asked))
    said = whole[:2] + b"\x10\0" + whole[4:]
    events = Session(Role.AGENT).receive(xrce.encode_frame(b"\x80\0\0\0" + said), 0)
    assert xrce.SessionOpened(peer=asked) in events
    assert not any(isinstance(event, xrce.Senseless) for event in events)


@each(
    ("client", "status"),
    [
        (xrce.Client(client_key=KEY, session_id=0x81, cookie=b"XRCF"), Status.INVALID_DATA),
        (xrce.Client(client_key=bytes(4), session_id=0x81), Status.INVALID_DATA),
        (xrce.Client(client_key=KEY, session_id=0x80), Status.INVALID_DATA),
        (xrce.Client(client_key=KEY, session_id=0x81, mtu=35), Status.INVALID_DATA),
        (xrce.Client(client_key=KEY, session_id=0x81, version=b"\2\0"), Status.INCOMPATIBLE),
    ],
)
def test_a_client_that_cannot_be_taken_is_told_why(client, status):
    agent = Session(Role.AGENT)
    ((_, (said,)),) = said_in(agent.receive(frame(xrce.CreateClient(client=client), session_id=0x80), 0))
    assert said.status is status
    assert agent.state is AgentState.LISTENING


def test_a_refused_client_says_so():
    client = client_of()
    client.connect(0)
    refusal = frame(xrce.StatusAgent(status=Status.DENIED, agent=xrce.Agent()))
    assert client.receive(refusal, 1)[-1] == xrce.SessionClosed(reason=CloseReason.REFUSED, status=Status.DENIED)


def test_the_same_client_again_and_another_one():
    agent = open_agent()
    same = xrce.Client(client_key=KEY, session_id=0x81)
    other = xrce.Client(client_key=b"\1\2\3\4", session_id=0x82)
    events = agent.receive(frame(xrce.CreateClient(client=same), session_id=0x80), 1)
    assert xrce.SessionOpened(peer=same, again=True) in events
    events = agent.receive(frame(xrce.CreateClient(client=other), session_id=0x80), 2)
    reports = [event for event in events if isinstance(event, xrce.SessionOpened | xrce.SessionClosed)]
    assert reports == [xrce.SessionClosed(reason=CloseReason.REPLACED), xrce.SessionOpened(peer=other)]
    agent.disconnect(3)
    events = agent.receive(frame(xrce.CreateClient(client=other), session_id=0x80), 4)
    assert xrce.SessionOpened(peer=other) in events


def test_a_ping_is_answered_with_a_session_and_without():
    client, agent = client_of(), Session(Role.AGENT)
    answer = agent.receive(client.ping(0), 0)
    assert client.receive(answer[0].data, 0) == [xrce.Pong(in_session=False)]
    agent.receive(client.connect(0)[-1].data, 0)
    answer = agent.receive(client.ping(0), 0)
    assert client.receive(answer[0].data, 0) == [xrce.Pong(in_session=True)]


def test_a_ping_of_a_client_whose_agent_was_restarted():
    """In its own session, which the new agent does not know: it answers, and says that there is none."""
    agent = Session(Role.AGENT)
    ping = xrce.GetInfo(request_id=10, object_id=xrce.OBJECT_AGENT, info_mask=xrce.InfoMask.ACTIVITY)
    ((header, (said,)),) = said_in(agent.receive(frame(ping), 0))
    assert header == xrce.Header(session_id=0x81)
    assert said.implementation_status == 0
    farewell = frame(xrce.Delete(request_id=2, object_id=xrce.OBJECT_CLIENT))
    ((_, (said,)),) = said_in(agent.receive(farewell, 0))
    assert said == xrce.StatusReply(request_id=2, object_id=xrce.OBJECT_CLIENT, status=Status.OK)
    assert agent.receive(frame(xrce.WriteData(**IDS, data=b"?"), stream_id=0x80), 0) == []
    assert agent.counters.foreign == 3


def test_the_agents_clock(line):
    pair = line(epoch_ns=1_800_000_000 * SECOND)
    pair.connect()
    pair.run(SECOND)
    pair.write("client", pair.client.synchronize(pair.now_ns))
    pair.run(SECOND)
    assert pair.of(xrce.AgentTime) == [xrce.AgentTime(ahead_ns=1_800_000_000 * SECOND, round_trip_ns=2 * LATENCY_NS)]


def test_time_behind_2038_begins_anew():
    assert xrce.Time.of_ns((1 << 31) * SECOND + 5) == xrce.Time(-(1 << 31), 5)
    assert xrce.Time(3, 4).ns == 3 * SECOND + 4


def test_a_long_message_goes_in_fragments_and_a_very_long_one_waits(line):
    frames = []

    def seen(data):
        frames.extend(xrce.FrameReader().receive(data))
        return data

    pair = line(mtu=64, window=4, damage=seen)
    pair.connect()
    pair.run(SECOND)
    picture = bytes(range(256)) * 30
    for end, other in (("client", "server"), ("server", "client")):
        pair.say(end, picture)
        pair.say(end, b"behind it")
        pair.run(10 * SECOND)
        assert pair.heard(other) == [picture, b"behind it"]
    assert max(len(one.payload) for one in frames) == 64
    assert pair.client.held == pair.server.held == 0


def test_several_submessages_go_in_one_message():
    agent = open_agent()
    several = [xrce.StatusReply(request_id=number, object_id=0x11, status=Status.OK) for number in (10, 11)]
    data = agent.send(several, 1)
    (found,) = xrce.FrameReader().receive(data)
    header, body = xrce.decode_header(found.payload)
    assert (header.stream_id, header.sequence) == (0x80, 0)
    assert [xrce.decode_submessage(raw) for raw in xrce.split_submessages(body)] == several


def test_a_fragment_may_stand_behind_whole_submessages():
    """As eProsima's client packs them: what is left of a message takes the first piece."""
    agent = open_agent()
    write = xrce.WriteData(**IDS, data=b"long")
    whole = xrce.encode_submessage(write)
    first = xrce.pack_submessages([whole, xrce.encode_submessage(xrce.Fragment(data=whole[:8]))])
    header = xrce.Header(session_id=0x81, stream_id=0x80)
    events = agent.receive(xrce.encode_frame(xrce.encode_message(header, first)), 1)
    events += agent.receive(frame(xrce.Fragment(data=whole[8:], last=True), stream_id=0x80, sequence=1), 2)
    assert [event.submessage for event in events if isinstance(event, xrce.Received)] == [write, write]


def test_what_makes_no_sense_costs_nothing_else():
    agent = open_agent()
    write = xrce.WriteData(**IDS, data=b"good")
    unknown = xrce.RawSubmessage(id=99, flags=1, payload=b"?")
    nested = xrce.Fragment(data=xrce.encode_submessage(xrce.Fragment(data=b"", last=True)), last=True)
    body = xrce.pack_submessages(xrce.encode_submessage(one) for one in (write, unknown, nested, write))
    cut = xrce.encode_submessage(write)[:-1]
    header = xrce.Header(session_id=0x81, stream_id=0x80)
    events = agent.receive(xrce.encode_frame(xrce.encode_message(header, body + cut)), 1)
    assert [type(event) for event in events] == [
        *(xrce.Received, xrce.Senseless, xrce.Senseless, xrce.Received, xrce.Senseless, xrce.Transmit)
    ]
    assert agent.counters.bad_bodies == 3
    assert agent.receive(xrce.encode_frame(b"\x81"), 2)[0].reason is xrce.DropReason.BAD_BODY


def test_fragments_beyond_the_limit_are_passed_over():
    agent = open_agent(streams=xrce.StreamOptions(max_message=10))
    events = []
    for number, piece in enumerate([b"123456", b"123456", b"123456"]):
        said = xrce.Fragment(data=piece, last=number == 2)
        events += agent.receive(frame(said, stream_id=0x80, sequence=number), number)
        assert agent.held <= 10
    assert [event.why for event in events if isinstance(event, xrce.Senseless)] == ["fragments of more than 10 bytes"]
    events = agent.receive(frame(xrce.WriteData(**IDS, data=b"next"), stream_id=0x80, sequence=3), 9)
    assert isinstance(events[0], xrce.Received)


def test_reset_begins_all_streams_anew(line):
    pair = line()
    pair.connect()
    pair.run(SECOND)
    for end in ("client", "server"):
        pair.say("client", b"before")
        pair.say("server", b"before")
        pair.run(SECOND)
        session = pair.client if end == "client" else pair.server
        for event in session.reset(pair.now_ns):
            pair.write(end, event.data)
        pair.say(end, b"after")
        pair.run(SECOND)
    assert pair.heard("server") == [b"before", b"after", b"before"]
    assert pair.heard("client") == [b"before", b"before", b"after"]
    assert len(pair.of(xrce.StreamsReset)) == 2


def test_nothing_of_old_streams_is_handed_on_behind_a_reset():
    agent = open_agent()
    assert len(said_in(agent.receive(frame(xrce.WriteData(**IDS, data=b"1"), stream_id=0x80, sequence=1), 1))) == 1
    events = agent.receive(frame(xrce.Reset(), stream_id=0x80), 2)
    assert events == [xrce.StreamsReset()]


def test_nothing_is_handed_on_behind_the_end_of_a_session():
    agent = open_agent()
    both = xrce.pack_submessages(
        map(
            xrce.encode_submessage,
            [xrce.Delete(request_id=2, object_id=xrce.OBJECT_CLIENT), xrce.WriteData(**IDS, data=b"")],
        )
    )
    header = xrce.Header(session_id=0x81, stream_id=0x80)
    events = agent.receive(xrce.encode_frame(xrce.encode_message(header, both)), 1)
    assert [said for _, (said,) in said_in(events)] == [
        xrce.StatusReply(request_id=2, object_id=xrce.OBJECT_CLIENT, status=Status.OK)
    ]
    assert not any(isinstance(event, xrce.Received) for event in events)


def test_the_end_of_a_session_is_waited_for_and_no_other_answer():
    client = client_of()
    client.connect(0)
    client.receive(frame(xrce.StatusAgent(status=Status.OK, agent=xrce.Agent())), 0)
    client.disconnect(1)
    client.receive(frame(xrce.StatusReply(**IDS, status=Status.OK)), 2)
    assert client.state is ClientState.CLOSING
    client.advance(30 * SECOND)
    assert client.state is ClientState.CLOSED
    events = client.connect(31 * SECOND) + client.advance(60 * SECOND)
    assert len(said_in(events)) == 10


def test_a_session_has_ended_where_it_is_not_known_any_more():
    """Its first DELETE was obeyed and the answer lost; the second is answered as the first was."""
    client, agent = client_of(), open_agent()
    client.connect(0)
    client.receive(frame(xrce.StatusAgent(status=Status.OK, agent=xrce.Agent())), 0)
    agent.receive(client.disconnect(1)[-1].data, 1)
    (again,) = [event for event in client.advance(SECOND + 1) if isinstance(event, xrce.Transmit)]
    (answer,) = agent.receive(again.data, SECOND + 1)
    ((_, (said,)),) = said_in([answer])
    assert said.status is Status.OK
    assert xrce.SessionClosed(reason=CloseReason.DELETED) in client.receive(answer.data, SECOND + 1)
    assert client.state is ClientState.CLOSED


def test_a_line_that_goes_down_leaves_nothing_of_a_frame():
    agent = open_agent()
    assert agent.receive(frame(xrce.WriteData(**IDS, data=b"1"))[:9], 1) == []
    dropped, *_, closed = agent.line_down(2)
    assert (dropped.reason, len(dropped.data)) == (xrce.DropReason.CUT_SHORT, 9)
    assert closed == xrce.SessionClosed(reason=CloseReason.LINE_DOWN)


def test_what_is_sent_waits_for_its_heartbeat_from_then_on():
    agent = open_agent()
    agent.send(xrce.TopicData(**IDS, data=b""), SECOND)
    assert agent.next_deadline_ns() == SECOND + 100 * MS


def test_a_client_says_what_it_has_and_how_much_it_takes():
    client = client_of(properties=(("a", "b"),), frames=xrce.FramingOptions(max_payload=100))
    ((_, (said,)),) = said_in(client.connect(0))
    assert (said.client.properties, said.client.mtu, client.mtu) == ((("a", "b"),), 100, 100)


def test_a_message_may_be_as_long_as_the_mtu():
    agent = open_agent(mtu=100)
    for stream_id in (1, 0x80):
        data = agent.send(xrce.TopicData(**IDS, data=bytes(100 - 4 - 4 - 4)), 1, stream_id=stream_id)
        assert [len(one.payload) for one in xrce.FrameReader().receive(data)] == [100]
    data = agent.send(xrce.TopicData(**IDS, data=bytes(100 - 4 - 4 - 4 + 1)), 1)
    assert [len(one.payload) for one in xrce.FrameReader().receive(data)] == [100, 4 + 4 + 5]
    small = open_agent(frames=xrce.FramingOptions(max_payload=100))
    assert small.mtu == 100


def test_a_silent_client_is_lost_where_that_is_wanted(line):
    pair = line(silence_s=2.0)
    pair.connect()
    pair.run(SECOND)
    pair.say("client", b"here")
    pair.run(1900 * MS)
    assert pair.server.state is AgentState.OPEN
    pair.run(SECOND)
    assert pair.of(xrce.SessionClosed) == [xrce.SessionClosed(reason=CloseReason.SILENCE)]


def test_heartbeats_come_less_and_less_often_until_an_acknack():
    agent = open_agent()
    agent.send(xrce.StatusReply(request_id=10, object_id=0x11, status=Status.OK), 0)
    times = []
    while len(times) < 7:
        now_ns = agent.next_deadline_ns()
        assert said_in(agent.advance(now_ns))[0][1] == [xrce.Heartbeat(first_unacked=0, last_unacked=0, stream_id=0x80)]
        times.append(now_ns // MS)
    assert [b - a for a, b in zip([0, *times], times, strict=False)] == [100, 200, 400, 800, 1600, 1600, 1600]
    acknack = xrce.AckNack(first_unacked=0, nack_bitmap=1, stream_id=0x80)
    events = agent.receive(frame(acknack), now_ns)
    assert [type(one) for _, (one,) in said_in(events)] == [xrce.StatusReply]
    assert agent.next_deadline_ns() == now_ns + 100 * MS
    agent.receive(frame(xrce.AckNack(first_unacked=1, nack_bitmap=0, stream_id=0x80)), now_ns)
    assert (agent.next_deadline_ns(), agent.unacknowledged) == (None, 0)


def test_many_acknacks_have_a_message_sent_again_once():
    agent = open_agent()
    for _ in range(16):
        agent.send(xrce.TopicData(**IDS, data=bytes(400)), 0)
    all_of_them = xrce.encode_submessage(xrce.AckNack(first_unacked=0, nack_bitmap=0xFFFF, stream_id=0x80))
    asked = xrce.encode_frame(
        xrce.encode_message(xrce.Header(session_id=0x81), xrce.pack_submessages([all_of_them] * 40))
    )
    repeats = [len(said_in(agent.receive(asked * 2, at_ms * MS))) for at_ms in (1, 50, 51)]
    assert repeats == [16, 0, 16]
    assert agent.counters.repeated == 32


def test_an_acknack_about_what_was_never_sent_means_nothing():
    agent = open_agent()
    agent.send(xrce.StatusReply(request_id=10, object_id=0x11, status=Status.OK), 0)
    for first in (2, 0xFFFF, 0x8000):
        assert agent.receive(frame(xrce.AckNack(first_unacked=first, nack_bitmap=0xFFFF, stream_id=0x80)), 1) == []
    assert agent.unacknowledged == 1
    assert agent.receive(frame(xrce.AckNack(first_unacked=0, nack_bitmap=1, stream_id=0x81)), 1) == []


def test_what_a_sender_does_not_have_any_more_is_reported():
    agent = open_agent()
    late = frame(xrce.WriteData(**IDS, data=b"7"), stream_id=0x80, sequence=7)
    assert [one for _, one in said_in(agent.receive(late, 1))] == [
        [xrce.AckNack(first_unacked=0, nack_bitmap=0x7F, stream_id=0x80)]
    ]
    events = agent.receive(frame(xrce.Heartbeat(first_unacked=6, last_unacked=8, stream_id=0x80)), 2)
    assert xrce.MessagesLost(stream_id=0x80, count=6) in events
    assert said_in(events)[0][1] == [xrce.AckNack(first_unacked=6, nack_bitmap=0b101, stream_id=0x80)]
    events = agent.receive(frame(xrce.WriteData(**IDS, data=b"6"), stream_id=0x80, sequence=6), 3)
    assert [event.submessage.data for event in events if isinstance(event, xrce.Received)] == [b"6", b"7"]


def test_a_message_is_handled_to_its_end_before_the_next_one():
    """The HEARTBEAT in front makes the next message no earlier."""
    agent = open_agent()
    first, second = (xrce.WriteData(**IDS, data=data) for data in (b"1111", b"2222"))
    heartbeat = xrce.Heartbeat(first_unacked=0, last_unacked=1, stream_id=0x80)
    body = xrce.pack_submessages(map(xrce.encode_submessage, (heartbeat, first)))
    agent.receive(frame(second, stream_id=0x80, sequence=1), 1)
    header = xrce.Header(session_id=0x81, stream_id=0x80)
    events = agent.receive(xrce.encode_frame(xrce.encode_message(header, body)), 2)
    assert [event.submessage for event in events if isinstance(event, xrce.Received)] == [first, second]
    assert [said for _, (said,) in said_in(events)] == [xrce.AckNack(first_unacked=2, nack_bitmap=0, stream_id=0x80)]


def test_heartbeats_in_messages_that_wait_for_each_other_end():
    """4.6 kB: each message of 16 full windows has a HEARTBEAT that hands on the next one, in a fragment."""
    agent = open_agent()
    streams = range(0x80, 0x90)
    for stream_id in streams:
        follower = stream_id + 1 if stream_id + 1 in streams else streams[0]
        for number in range(1, 16):
            said = xrce.Heartbeat(first_unacked=0, last_unacked=15, stream_id=stream_id)
            if number == 15:
                said = xrce.Heartbeat(first_unacked=1, last_unacked=15, stream_id=follower)
            whole = xrce.Fragment(data=xrce.encode_submessage(said), last=True)
            agent.receive(frame(whole, stream_id=stream_id, sequence=number), 1)
    first = xrce.Heartbeat(first_unacked=0, last_unacked=15, stream_id=streams[0])
    events = agent.receive(frame(first, stream_id=streams[0]), 2)
    received = {said.stream_id: said.first_unacked for _, (said,) in said_in(events)}
    assert received == dict.fromkeys(streams, 16)
    assert agent.held == 0


def test_best_effort_takes_only_what_is_newer():
    agent = open_agent()
    numbers = [0, 1, 1, 0, 3, 2, 0x8002, 0x8001]
    heard = []
    for number in numbers:
        write = xrce.WriteData(**IDS, data=number.to_bytes(2, "big"))
        events = agent.receive(frame(write, stream_id=1, sequence=number), 1)
        heard += [number for event in events if isinstance(event, xrce.Received)]
    assert heard == [0, 1, 3, 0x8002]
    assert agent.counters.stale == 4


def test_streams_beyond_the_limit_are_refused():
    agent = open_agent(streams=xrce.StreamOptions(max_streams=2))
    for stream_id in (1, 2, 3, 128, 129, 130):
        agent.receive(frame(xrce.WriteData(**IDS, data=b"x"), stream_id=stream_id), 1)
    assert agent.counters.refused == 2
    assert agent.receive(frame(xrce.Heartbeat(first_unacked=0, last_unacked=0, stream_id=1)), 1) == []


@each(
    ("role", "said"),
    [
        (Role.AGENT, xrce.Create(**IDS, object=xrce.Type(representation=xrce.ByReference(name="T")))),
        (Role.AGENT, xrce.Reset()),
        (Role.CLIENT, xrce.TopicData(**IDS, data=b"")),
        (Role.CLIENT, xrce.AckNack(first_unacked=0, nack_bitmap=0, stream_id=0x80)),
    ],
)
def test_what_is_not_for_the_program_to_send(role, said):
    session = open_agent() if role is Role.AGENT else client_of()
    if role is Role.CLIENT:
        session.connect(0)
        session.receive(frame(xrce.StatusAgent(status=Status.OK, agent=xrce.Agent())), 0)
    with pytest.raises(xrce.LocalProtocolError, match=type(said).__name__):
        session.send(said, 1)


def test_misuse_changes_nothing():
    client = client_of()
    for call in (client.disconnect, client.reset):
        with pytest.raises(xrce.LocalProtocolError, match="CLOSED"):
            call(0)
    with pytest.raises(xrce.LocalProtocolError, match="no session"):
        client.send(xrce.Delete(**IDS), 0)
    client.connect(0)
    with pytest.raises(xrce.LocalProtocolError, match="CONNECTING cannot connect"):
        client.connect(0)
    agent = open_agent()
    for call in (agent.connect, agent.ping, agent.synchronize):
        with pytest.raises(xrce.LocalProtocolError):
            call(0)
    with pytest.raises(xrce.LocalProtocolError, match="508"):
        agent.send(xrce.TopicData(**IDS, data=bytes(600)), 0, stream_id=1)
    assert agent.send(xrce.TopicData(**IDS, data=b"x"), 0, stream_id=1)[4 + 3] == 0


@each(
    "make",
    [
        lambda: Session(Role.CLIENT),
        lambda: Session(Role.CLIENT, xrce.AgentOptions()),
        lambda: Session(Role.AGENT, ClientOptions(client_key=KEY)),
        lambda: ClientOptions(client_key=bytes(4)),
        lambda: ClientOptions(client_key=b"123"),
        lambda: ClientOptions(client_key=KEY, session_id=0x80),
        lambda: ClientOptions(client_key=KEY, mtu=35),
        lambda: ClientOptions(client_key=KEY, frames=xrce.FramingOptions(max_payload=35)),
        lambda: xrce.AgentOptions(frames=xrce.FramingOptions(max_payload=35)),
        lambda: ClientOptions(client_key=KEY, attempts=0),
        lambda: xrce.AgentOptions(silence_s=0.0),
        lambda: xrce.AgentOptions(silence_s=math.inf),
        lambda: xrce.AgentOptions(silence_s=math.nan),
        lambda: xrce.StreamOptions(window=17),
        lambda: xrce.StreamOptions(heartbeat_s=0.0),
        lambda: xrce.StreamOptions(repeat_s=0.0),
    ],
)
def test_options_that_cannot_be(make):
    with pytest.raises(xrce.LocalProtocolError):
        make()


def test_a_submessage_of_the_wrong_end_or_outside_of_a_session_is_nobodys_business():
    agent = open_agent()
    for said in (xrce.TopicData(**IDS, data=b""), xrce.StatusReply(**IDS, status=Status.OK)):
        assert agent.receive(frame(said), 1) == []
    for said in (xrce.WriteData(**IDS, data=b""), xrce.Reset(), xrce.Timestamp(transmit=xrce.Time())):
        assert agent.receive(frame(said, session_id=0x82), 1) == []
    heartbeat = xrce.Heartbeat(first_unacked=0, last_unacked=3, stream_id=0x80)
    assert agent.receive(frame(heartbeat, session_id=0x80), 1) == []
    assert agent.counters.misplaced == 6
    fragment = frame(xrce.Fragment(data=b"", last=True), session_id=0x80, stream_id=0x80)
    assert [type(event) for event in agent.receive(fragment, 1)] == [xrce.Senseless]


def test_a_stream_that_cannot_be_is_refused_before_anything_is_taken():
    agent = open_agent()
    for stream_id in (-1, 256):
        with pytest.raises(xrce.LocalProtocolError, match=f"stream_id {stream_id}"):
            agent.send(xrce.TopicData(**IDS, data=b""), 1, stream_id=stream_id)
    assert (agent.unacknowledged, agent.next_deadline_ns()) == (0, None)


def test_the_longest_answer_fits_the_shortest_message():
    """An agent never has an answer that it cannot put in a frame."""
    agent = Session(Role.AGENT, xrce.AgentOptions(mtu=36, frames=xrce.FramingOptions(max_payload=36)))
    asked = xrce.Client(client_key=KEY, session_id=0x01, mtu=36)
    agent.receive(frame(xrce.CreateClient(client=asked), session_id=0x00, key=KEY), 0)
    asked = frame(xrce.Timestamp(transmit=xrce.Time()), session_id=0x01, key=KEY)
    ((_, (said,)),) = said_in(agent.receive(asked, 0))
    assert isinstance(said, xrce.TimestampReply)


def test_properties_that_no_message_holds_are_refused_at_once():
    with pytest.raises(xrce.LocalProtocolError, match="longer than 100"):
        client_of(properties=(("a", "b" * 100),), frames=xrce.FramingOptions(max_payload=100))


def test_request_ids_begin_behind_the_reserved_ones():
    client = client_of()
    assert [client.new_request_id() for _ in range(3)] == [10, 11, 12]
    client._request_id = 0xFFFF
    assert client.new_request_id() == 10
