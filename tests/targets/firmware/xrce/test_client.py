"""The XRCE client in C against our agent, both ways, over faulty lines, and with agents that come and go."""

from __future__ import annotations

import random
import shutil
import subprocess

import pytest

from protocols import xrce
from protocols.testing import lossy
from tests.share import seeds
from tests.targets.firmware.xrce.native import (
    DOWN,
    DOWN_BEST,
    MS,
    SECOND,
    SERVICE,
    UP,
    UP_BEST,
    Native,
    State,
    build,
    compiled,
)
from tests.targets.firmware.xrce.native import HERE as FOLDER

FAULTS = {
    "none": {},
    "lost": {"drop": 0.2},
    "turned": {"flip": 0.2},
    "twice": {"repeat": 0.3},
    "noise": {"noise": 0.5},
    "all": {"drop": 0.1, "flip": 0.1, "repeat": 0.1, "noise": 0.3},
}
BEST_EFFORT, RELIABLE = 0x01, 0x80
OBJECTS = {0x11, 0x13, 0x14, 0x22, 0x25, 0x32, 0x36, 0x42, 0x45, 0x52, 0x56, 0x68}


@pytest.fixture(scope="session")
def library(tmp_path_factory):
    """The client, compiled."""
    if shutil.which("gcc") is None:
        pytest.skip("there is no gcc here")
    return build(tmp_path_factory.mktemp("xrce"))


@pytest.fixture
def connected(library):
    """A client with a session and all its objects."""
    there = Native(library, lost_s=2)
    there.run(SECOND)
    assert there.state is State.OPEN
    return there


def numbered(count, most):
    return [number.to_bytes(4, "big") * (1 + number * 7919 % most) for number in range(count)]


def exchange(there, messages, *, patience_s=600):
    """Both ends write all of it as fast as there is room; down, a sample is there before the next one is written."""
    up, down = list(messages), list(messages)
    before = len(there.heard[DOWN])
    end_ns = there.now_ns + patience_s * SECOND
    while there.now_ns < end_ns and (
        up or down or there.unacknowledged or len(there.heard[DOWN]) - before < len(messages)
    ):
        while up and there.write(UP, up[0]):
            del up[0]
        if down and len(there.heard[DOWN]) - before == len(messages) - len(down):
            there.publish("rt/down", down.pop(0))
        there.run(10 * MS)


def test_a_session_and_all_objects_in_it(connected):
    assert connected.objects == OBJECTS
    created = [event for event in connected.agent.take_events() if isinstance(event, xrce.ObjectCreated)]
    assert {(one.kind, one.topic) for one in created if one.kind in ("DataWriter", "DataReader", "Replier")} == {
        ("DataWriter", "rt/up"),
        ("DataReader", "rt/down"),
        ("DataWriter", "rt/up_best"),
        ("DataReader", "rt/down_best"),
        ("Replier", "rr/askReply"),
    }


def test_samples_pass_both_ways_on_both_kinds_of_stream(connected):
    for number in range(20):
        data = bytes((number, 0x7E, 0x7D, 0x5E))
        assert connected.write(UP, data)
        assert connected.write(UP_BEST, data)
        connected.publish("rt/down", data)
        connected.publish("rt/down_best", data)
        connected.run(50 * MS)
    wanted = [bytes((number, 0x7E, 0x7D, 0x5E)) for number in range(20)]
    assert [one.data for one in connected.said["rt/up"]] == wanted
    assert [one.data for one in connected.said["rt/up_best"]] == wanted
    assert connected.heard[DOWN] == connected.heard[DOWN_BEST] == wanted


def test_a_service_is_asked_and_answers(connected):
    connected.publish("rq/askRequest", b"\x01")
    connected.run(50 * MS)
    (request,) = connected.heard[SERVICE]
    assert request[24:] == b"\x01"
    assert connected.write(SERVICE, request[:24] + b"\x01")
    connected.run(50 * MS)
    assert [one.data for one in connected.said["rr/askReply"]] == [b"\x01"]


def test_the_domain_is_the_one_that_is_set(library):
    there = Native(library, domain_id=42)
    there.run(SECOND)
    there.write(UP, b"1234")
    there.run(SECOND)
    assert [one.data for one in there.said["rt/up"]] == [b"1234"]


@pytest.mark.parametrize("fault", FAULTS)
@pytest.mark.parametrize("seed", seeds(6, 1))
def test_over_a_faulty_line_every_reliable_sample_comes_once_and_in_order(library, fault, seed):
    there = Native(library)
    there.run(SECOND)
    there.damage = lossy(seed, **FAULTS[fault])
    messages = numbered(60, 60)
    exchange(there, messages)
    assert [one.data for one in there.said["rt/up"]] == messages
    assert there.heard[DOWN] == messages


@pytest.mark.exhaustive("a thousand samples each way for each fault; the gate has 60")
@pytest.mark.parametrize("fault", FAULTS)
def test_a_thousand_samples(library, fault):
    there = Native(library)
    there.run(SECOND)
    there.damage = lossy(26, **FAULTS[fault])
    messages = numbered(1000, 20)
    exchange(there, messages, patience_s=10_000)
    assert [one.data for one in there.said["rt/up"]] == messages
    assert there.heard[DOWN] == messages


@pytest.mark.parametrize("fault", ["none", "all"])
def test_numbers_begin_anew_behind_the_last_one(library, fault):
    there = Native(library)
    there.run(SECOND)
    there.number_from(0xFFF0)
    there.damage = lossy(5, **FAULTS[fault])
    exchange(there, numbered(40, 5))
    assert [one.data for one in there.said["rt/up"]] == numbered(40, 5)
    assert there.heard[DOWN] == numbered(40, 5)


@pytest.mark.parametrize("fault", FAULTS)
def test_a_session_begins_over_a_faulty_line(library, fault):
    there = Native(library, damage=lossy(3, **FAULTS[fault]))
    there.run(60 * SECOND)
    assert there.state is State.OPEN
    assert there.objects == OBJECTS


def test_a_long_sample_comes_in_fragments(connected):
    for size in (400, 600, 1000):
        data = bytes(number % 251 for number in range(size))
        connected.publish("rt/down", data)
        connected.run(SECOND)
        assert connected.heard[DOWN].pop() == data
    connected.publish("rt/down", bytes(1100))
    connected.publish("rt/down", b"next")
    connected.run(SECOND)
    assert connected.heard[DOWN] == [b"next"]


def test_a_sample_that_fits_no_message_is_refused(connected):
    assert not connected.write(UP, bytes(512))
    assert connected.write(UP, bytes(496))
    connected.run(SECOND)
    assert len(connected.said["rt/up"]) == 1


def test_the_window_is_never_overrun(connected):
    connected.agent = None
    assert sum(connected.write(UP, b"1234") for _ in range(20)) == 8
    assert connected.unacknowledged == 8


@pytest.mark.parametrize("back_after_s", [0, 1, 5, 60])
def test_an_agent_that_is_killed_and_restarted_finds_everything_created_anew(connected, back_after_s):
    for _ in range(3):
        connected.agent = None
        connected.write(UP, b"lost")
        connected.run(back_after_s * SECOND)
        connected.restart_agent()
        connected.run(4 * SECOND)
        assert connected.state is State.OPEN
        assert connected.objects == OBJECTS
        connected.said["rt/up"].clear()
        exchange(connected, numbered(10, 3))
        assert [one.data for one in connected.said["rt/up"]] == numbered(10, 3)


def test_an_agent_that_has_lost_the_session_is_noticed_without_any_sample(connected):
    connected.restart_agent()
    connected.run(SECOND)
    assert connected.state is State.OPEN
    assert connected.objects == OBJECTS


def test_a_silent_line_is_asked_and_the_session_stays(connected):
    begun = connected.written.count(b"XRCE")
    connected.run(60 * SECOND)
    assert connected.state is State.OPEN
    assert connected.written.count(b"XRCE") == begun


def test_a_mute_agent_is_lost_in_time_and_looked_for(connected):
    connected.agent = None
    connected.run(1900 * MS)
    assert connected.state is State.OPEN
    connected.run(200 * MS)
    assert connected.state is State.SEEKING
    assert not connected.write(UP, b"1234")


def test_a_board_that_is_reset_takes_its_session_over(library, connected):
    again = Native(library)
    again.agent = connected.agent
    again.run(SECOND)
    assert again.state is State.OPEN
    assert len(again.agent.objects["board"]) == len(OBJECTS)


def test_what_a_client_has_created_is_freed_at_its_end(connected):
    connected.end()
    connected.run(6 * MS)
    assert connected.objects == set()


def test_an_agent_that_refuses_an_object_is_asked_again_later(library):
    there = Native(library, options=xrce.AgentOptions(max_objects=5))
    there.run(5 * SECOND)
    assert there.state is not State.OPEN
    assert 5 <= there.written.count(b"XRCE") <= 12
    there._options = None
    there.restart_agent()
    there.run(5 * SECOND)
    assert there.objects == OBJECTS


def test_times_and_numbers_may_go_round(library):
    there = Native(library, start_ms=(1 << 32) - 3000, lost_s=2)
    there.run(10 * SECOND)
    assert there.state is State.OPEN
    exchange(there, numbered(20, 5))
    there.agent = None
    there.run(3 * SECOND)
    there.restart_agent()
    there.run(3 * SECOND)
    assert there.objects == OBJECTS


def test_heartbeats_come_ever_more_rarely(connected):
    connected.agent = None
    connected.write(UP, b"1234")
    connected.written = b""
    connected.run(1600 * MS)
    assert len([one for one in said_in(connected.written) if isinstance(one, xrce.Heartbeat)]) == 4


def said_in(data):
    """The submessages in serial frames."""
    found = []
    for frame in xrce.FrameReader().receive(data):
        _, body = xrce.decode_header(frame.payload)
        found += [xrce.decode_submessage(raw) for raw in xrce.split_submessages(body)]
    return found


def test_either_byte_order_is_understood(connected):
    beat = xrce.Heartbeat(first_unacked=0x0102, last_unacked=0x0103, stream_id=RELIABLE)
    connected.written = b""
    connected.to_client(framed(header(), xrce.encode_submessage(beat, little_endian=False)))
    (answer,) = [one for one in said_in(connected.written) if isinstance(one, xrce.AckNack)]
    assert (answer.first_unacked, answer.nack_bitmap) == (0x0102, 0b11)


def test_a_slow_agent_gets_a_session_as_long_as_each_answer_comes_in_time(library):
    there = Native(library, lost_s=1, answers_after_ns=450 * MS)
    there.run(10 * SECOND)
    assert there.state is State.OPEN
    assert there.objects == OBJECTS
    assert there.written.count(b"XRCE") == 1


def test_what_waits_behind_lost_messages_is_heard_when_a_heartbeat_skips_them(connected):
    connected.number_from(0x100)
    connected.agent = None
    connected.to_client(framed(header(RELIABLE, 0x101), data_for(0x36, b"early")))
    assert connected.heard[DOWN] == []
    connected.written = b""
    beat = xrce.Heartbeat(first_unacked=0x101, last_unacked=0x101, stream_id=RELIABLE)
    connected.to_client(framed(header(), xrce.encode_submessage(beat)))
    assert connected.heard[DOWN] == [b"early"]
    (answer,) = [one for one in said_in(connected.written) if isinstance(one, xrce.AckNack)]
    assert (answer.first_unacked, answer.nack_bitmap) == (0x102, 0)


def test_a_refused_read_begins_the_session_anew(connected):
    begun = connected.written.count(b"XRCE")
    for request, reader, sessions in [(0x205, 0x25, 0), (0x101, 0x25, 0), (0x100, 0x25, 0), (0x101, 0x36, 1)]:
        refusal = xrce.StatusReply(request_id=request, object_id=reader, status=xrce.Status.UNKNOWN_REFERENCE)
        connected.to_client(framed(header(), xrce.encode_submessage(refusal)))
        connected.run(2 * SECOND)
        assert connected.written.count(b"XRCE") == begun + sessions, (request, reader)
        assert connected.state is State.OPEN
    connected.publish("rt/down", b"again")
    connected.run(SECOND)
    assert connected.heard[DOWN] == [b"again"]


def test_silence_is_noticed_behind_weeks_of_talk(connected):
    connected.agent = None
    talk = xrce.encode_submessage(xrce.AckNack(first_unacked=0, nack_bitmap=0, stream_id=RELIABLE))
    for _ in range(3):
        connected.pass_over((1 << 30) * MS)
        connected.to_client(framed(header(), talk))
    connected.written = b""
    connected.run(SECOND)
    assert [type(one) for one in said_in(connected.written)] == [xrce.GetInfo] * 3
    connected.run(1100 * MS)
    assert connected.state is State.SEEKING


def test_a_client_that_waits_as_long_as_it_may_notices_a_lost_agent(library):
    """Where it asks more rarely than an agent may be silent."""
    there = Native(library, lost_s=0.2)
    there.run(100 * MS)
    assert there.state is State.OPEN
    there.agent = None
    there.run(250 * MS)
    assert there.state is State.SEEKING


def test_pieces_of_another_stream_do_not_come_between(connected):
    connected.number_from(0x100)
    connected.agent = None
    whole = data_for(0x36, b"whole")
    for head, piece in (
        (header(RELIABLE, 0x100), xrce.Fragment(data=whole[:8])),
        (header(BEST_EFFORT, 0x7000), xrce.Fragment(data=b"\xee" * 4)),
        (header(), xrce.Fragment(data=b"\xee" * 4, last=True)),
        (header(RELIABLE, 0x101), xrce.Fragment(data=whole[8:], last=True)),
    ):
        connected.to_client(framed(head, xrce.encode_submessage(piece)))
    assert connected.heard[DOWN] == [b"whole"]


def test_more_endpoints_than_there_are_bits_for_are_refused(library):
    assert library.can_begin_with(14)
    assert not library.can_begin_with(15)


def header(stream_id=0, sequence=0):
    return xrce.Header(session_id=0x81, stream_id=stream_id, sequence=sequence)


def data_for(reader, data):
    return xrce.encode_submessage(xrce.TopicData(request_id=0x101, object_id=reader, data=data))


def framed(head, *submessages):
    return xrce.encode_frame(xrce.encode_message(head, xrce.pack_submessages(submessages)))


@pytest.mark.exhaustive(
    "ten seconds: compiles the client with the sanitizers of gcc, and plays it some 100 000 bytes that are wrong"
)
def test_no_bytes_make_the_client_touch_what_is_not_its_own(tmp_path, library):
    program = compiled(
        tmp_path / "fuzz", "-fsanitize=address,undefined", "-fno-sanitize-recover", str(FOLDER / "fuzz.c")
    )
    there = Native(library)
    there.run(SECOND)
    opening = len(there.came)
    exchange(there, numbered(40, 60))
    chance = random.Random(26)
    pieces = []
    for turn in range(40):
        sound = there.came[:opening] if turn % 2 else []
        pieces += [b"", *sound, *mutated(there.came[len(sound) :], chance)]
    data = b"".join(len(piece).to_bytes(2, "little") + piece for piece in pieces)
    done = subprocess.run([program], input=data, capture_output=True, check=False)
    assert (done.returncode, done.stderr) == (0, b"")
    assert int(done.stdout) > 1000, "hardly any of it came to an open session"


def mutated(pieces, chance):
    """The same, some of them with other bytes inside a sound frame, some damaged, some noise."""
    for piece in pieces:
        what = chance.random()
        frames = [found for found in xrce.FrameReader().receive(piece) if isinstance(found, xrce.Frame)]
        if what < 0.3 and frames:
            payload = bytearray(frames[0].payload)
            for _ in range(chance.randrange(1, 4)):
                payload[chance.randrange(1, len(payload))] = chance.randrange(256)
            yield xrce.encode_frame(bytes(payload))
        elif what < 0.35 and frames:
            yield xrce.encode_frame(frames[0].payload + chance.randbytes(chance.randrange(450)))
        elif what < 0.4:
            yield chance.randbytes(chance.randrange(1500))
        else:
            yield piece
