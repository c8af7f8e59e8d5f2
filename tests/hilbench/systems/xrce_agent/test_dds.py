"""`hilbench serve xrce-agent --dds`: programs of Cyclone DDS in other processes, at the loopback interface."""

from __future__ import annotations

import contextlib
import importlib.util
import os
import re
import select
import signal
import struct
import subprocess
import sys
from pathlib import Path

import pytest

from hilbench.journal import Journal
from protocols import xrce
from tests.hilbench.forked import PATIENCE_S
from tests.hilbench.systems.xrce_agent.test_served import Client, Lengths

NEEDS_CYCLONE = pytest.mark.skipif(
    importlib.util.find_spec("cyclonedds") is None, reason="the extra 'ros2' is not installed"
)
SERVED = pytest.mark.real_time("processes that serve; what they say is waited for, and nothing is timed")
TOPIC, TYPE = "rt/speed", "std_msgs::msg::dds_::Float32_"
ASKED, ANSWERED = (f"example_interfaces::srv::dds_::AddTwoInts_{half}_" for half in ("Request", "Response"))
KEEPS = xrce.QosFlag.RELIABLE | xrce.QosFlag.DURABILITY_TRANSIENT_LOCAL
PARTICIPANT, SUBSCRIBER, PUBLISHER, DDS_TOPIC, WRITER, READER = 0x11, 0x14, 0x13, 0x12, 0x15, 0x16


class Board(Client):
    """A client at a socket that keeps its samples, and wants those that were kept."""

    def __init__(self, port, key):
        super().__init__(Lengths(port), key)
        self.connect()
        self.make(PARTICIPANT, xrce.Participant(representation=xrce.ParticipantBinary()))

    def put(self, said):
        data = xrce.encode_submessage(said)
        self.say(data[0], data[4:], flags=data[1])

    def make(self, object_id, made):
        self._request += 1
        self.put(xrce.Create(request_id=self._request, object_id=object_id, object=made))
        assert self.hear(5)[4] == 0

    def drop(self, object_id):
        self._request += 1
        self.put(xrce.Delete(request_id=self._request, object_id=object_id))
        assert self.hear(5)[4] == 0

    def speed(self, flags=KEEPS, kind=TYPE):
        topic = xrce.TopicBinary(topic_name=TOPIC, type_name=kind)
        writes = xrce.DataWriterBinary(topic_id=DDS_TOPIC, qos=xrce.DataWriterQos(flags=flags))
        reads = xrce.DataReaderBinary(topic_id=DDS_TOPIC, qos=xrce.DataReaderQos(flags=flags))
        there = {"participant_id": PARTICIPANT}
        self.make(DDS_TOPIC, xrce.Topic(representation=topic, **there))
        self.make(PUBLISHER, xrce.Publisher(representation=xrce.PublisherBinary(), **there))
        self.make(SUBSCRIBER, xrce.Subscriber(representation=xrce.SubscriberBinary(), **there))
        self.make(WRITER, xrce.DataWriter(representation=writes, publisher_id=PUBLISHER))
        self.make(READER, xrce.DataReader(representation=reads, subscriber_id=SUBSCRIBER))
        self.read(READER)

    def read(self, object_id):
        wanted = xrce.ReadSpecification(
            stream_id=xrce.BUILTIN_RELIABLE, delivery=xrce.DeliveryControl(max_samples=xrce.UNLIMITED)
        )
        self.put(xrce.ReadData(request_id=0x20, object_id=object_id, specification=wanted))

    def write(self, object_id, data, request_id=0x30, little_endian=True):
        said = xrce.WriteData(request_id=request_id, object_id=object_id, data=data, little_endian=little_endian)
        self.put(said)

    def says(self, speed):
        self.write(WRITER, struct.pack("<f", speed))

    def hears(self):
        return struct.unpack("<f", self.hear(9)[4:])[0]

    def asks(self, object_id, data):
        """The reply of a service, which is asked until it answers: it keeps nothing for who is not there yet."""
        while True:
            self.write(object_id, data, request_id=0x0107)
            while select.select((self.line.socket,), (), (), 1)[0]:
                kind, payload = self.hear_any()
                if kind == 9:
                    return payload[4:]


class Peer:
    """A process of `dds_peer`."""

    def __init__(self, *words, env):
        script = str(Path(__file__).with_name("dds_peer.py"))
        self._process = subprocess.Popen(
            [sys.executable, script, *words], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True, env=env
        )

    def says(self, *words):
        print(*words, file=self._process.stdin, flush=True)

    def hears(self):
        assert select.select((self._process.stdout,), (), (), PATIENCE_S)[0], "nothing came"
        return self._process.stdout.readline().split()

    def close(self):
        self._process.stdin.close()
        self._process.stdout.close()
        assert self._process.wait(PATIENCE_S) == 0


class Bed:
    """Begins agents, boards and peers; all end with it."""

    def __init__(self, forkable, env, stack):
        self._forkable, self._env, self._stack = forkable, env, stack

    def agent(self, *more):
        process = self._stack.enter_context(
            self._forkable.start("serve", "xrce-agent", "--tcp", "0", *more, env=self._env)
        )
        self._stack.callback(process.send_signal, signal.SIGINT)
        return process, int(re.search(r"tcp .*:(\d+),", process.hear("stop with"))[1])

    def board(self, port, key=b"\1\2\3\4"):
        made = Board(port, key)
        self._stack.callback(made.line.close)
        return made

    def peer(self, *words):
        made = Peer(*words, env={**os.environ, **self._env})
        self._stack.callback(made.close)
        return made


@pytest.fixture
def bed(forkable, domain):
    with contextlib.ExitStack() as stack:
        yield Bed(forkable, domain, stack)


@NEEDS_CYCLONE
@SERVED
def test_a_board_and_a_program_of_dds_hear_each_other_each_sample_once(bed):
    _, port = bed.agent("--dds")
    board, node = bed.board(port), bed.peer("node", TOPIC)
    board.speed()
    for number in range(5):
        board.says(number)
        assert board.hears() == number  # its own reader hears it by the agent, and not by DDS again
        assert node.hears() == ["heard", f"{number}.0"]
        node.says(number + 0.5)
        assert node.hears() == ["heard", f"{number}.5"]
        assert board.hears() == number + 0.5


@NEEDS_CYCLONE
@SERVED
def test_what_a_board_writes_big_endian_is_turned_where_its_type_is_known(bed):
    process, port = bed.agent("--dds")
    board, node = bed.board(port), bed.peer("node", TOPIC)
    board.speed()
    board.write(WRITER, struct.pack(">f", 1.5), little_endian=False)
    assert node.hears() == ["heard", "1.5"]
    assert struct.unpack(">f", board.hear(9)[4:]) == (1.5,)
    for object_id in (PUBLISHER, SUBSCRIBER, DDS_TOPIC):
        board.drop(object_id)
    board.speed(kind="own::msg::dds_::Speed_")
    board.write(WRITER, struct.pack(">f", 1.5), little_endian=False)
    process.hear("a sample was not handed on to DDS: it is big-endian, and own::msg::dds_::Speed_ is not known here")


@NEEDS_CYCLONE
@SERVED
def test_two_agents_hand_on_nothing_from_each_other(bed):
    boards = [bed.board(bed.agent("--dds", "0")[1], bytes((1, 2, 3, number))) for number in (4, 5)]
    for board in boards:
        board.speed()
    for number in range(5):
        for board in boards:
            board.says(number)
            assert [one.hears() for one in boards] == [number, number]
    for length in (1, 2, 3):  # which are padded on their way
        boards[0].write(WRITER, b"\xff" * length)
        assert [one.hear(9)[4:] for one in boards] == [b"\xff" * length] * 2


@NEEDS_CYCLONE
@SERVED
def test_a_name_that_dds_does_not_have_is_said_and_ends_nothing(bed):
    process, port = bed.agent("--dds")
    board, node = bed.board(port), bed.peer("node", TOPIC)
    for number, (name, kind) in enumerate((("rt/\udcff\x1b[1m\n", TYPE), (TOPIC, "\udcff"), ("a" * 257, TYPE)), 1):
        topic = xrce.TopicBinary(topic_name=name, type_name=kind)
        board.make(DDS_TOPIC, xrce.Topic(representation=topic, participant_id=PARTICIPANT))
        board.make(PUBLISHER, xrce.Publisher(representation=xrce.PublisherBinary(), participant_id=PARTICIPANT))
        writes = xrce.DataWriterBinary(topic_id=DDS_TOPIC)
        board.make(WRITER, xrce.DataWriter(representation=writes, publisher_id=PUBLISHER))
        board.says(1)
        said = process.hear("is no name in DDS", times=number)
        assert said.count("it cannot be joined to DDS domain 0") == number
        assert all(line.isprintable() for line in said.splitlines())
        for object_id in (PUBLISHER, DDS_TOPIC):
            board.drop(object_id)
    board.speed()
    board.says(2)
    assert node.hears() == ["heard", "2.0"]


@NEEDS_CYCLONE
def test_a_domain_that_cannot_be_joined_is_said_before_anybody_comes(forkable):
    process = forkable.run("serve", "xrce-agent", "--tcp", "0", "--dds", env={"CYCLONEDDS_URI": "<CycloneDDS><Odd/>"})
    assert process.returncode == 3
    assert process.error.splitlines()[-1] == (
        "hilbench: DDS domain 0 cannot be joined: Error; the line before says why; interfaces are those that "
        "CYCLONEDDS_URI names"
    )


@NEEDS_CYCLONE
@SERVED
@pytest.mark.parametrize(
    ("kind", "flags", "words"),
    [
        ("best-effort", KEEPS, "a writer in DDS does not suit: the reader wants a reliable writer"),
        ("wanting", xrce.QosFlag.RELIABLE, "a reader in DDS does not suit: the reader wants samples from before"),
    ],
)
def test_what_does_not_suit_is_said_once_on_stderr_and_in_the_journal(bed, tmp_path, kind, flags, words):
    path = tmp_path / "j.jsonl"
    process, port = bed.agent("--dds", "--journal", str(path))
    board = bed.board(port)
    board.speed(flags)
    for _ in range(2):
        bed.peer("misfit", TOPIC, kind)
    assert f"{TOPIC}: {words}" in process.hear(words)
    board.says(1)
    board.hears()
    process.send_signal(signal.SIGINT)
    process.communicate()
    events = [one for one in Journal.read(path).events if one["kind"] == "event" and one["name"] == "Mismatch"]
    assert [(one["source"], one["value"]["topic"]) for one in events] == [("agent", TOPIC)]
    assert words in events[0]["value"]["why"]
    assert process.error.count(words) + process.said.count(words) == 1


@NEEDS_CYCLONE
@SERVED
def test_a_board_asks_a_service_of_dds(bed):
    _, port = bed.agent("--dds")
    board, server = bed.board(port), bed.peer("server", "/add")
    board.make(
        0x17,
        xrce.Requester(
            participant_id=PARTICIPANT,
            representation=xrce.RequesterBinary(
                service_name="/add",
                request_type=ASKED,
                reply_type=ANSWERED,
                request_topic_name="rq//addRequest",
                reply_topic_name="rr//addReply",
            ),
        ),
    )
    board.read(0x17)
    assert board.asks(0x17, struct.pack("<qq", 2, 3)) == b"\x01\x07\x00\x17" + struct.pack("<q", 5)
    assert server.hears() == ["asked", "2", "3"]


@NEEDS_CYCLONE
@SERVED
def test_a_board_answers_a_program_of_dds(bed):
    _, port = bed.agent("--dds")
    board, caller = bed.board(port), bed.peer("caller", "/add")
    board.make(
        0x18,
        xrce.Replier(
            participant_id=PARTICIPANT,
            representation=xrce.ReplierBinary(
                service_name="/add",
                request_type=ASKED,
                reply_type=ANSWERED,
                request_topic_name="rq//addRequest",
                reply_topic_name="rr//addReply",
            ),
        ),
    )
    board.read(0x18)
    for number in range(3):
        caller.says(number, 10)
        asked = board.hear(9)[4:]
        a, b = struct.unpack("<qq", asked[24:])
        assert (a, b) == (number, 10)
        board.write(0x18, asked[:24] + struct.pack("<q", a + b))
        assert caller.hears() == ["answered", str(number), str(number + 10)]


def test_without_it_there_is_one_line_that_says_what_to_install(forkable):
    if importlib.util.find_spec("cyclonedds") is not None:
        pytest.skip("the extra 'ros2' is installed")
    process = forkable.run("serve", "xrce-agent", "--tcp", "0", "--dds")
    assert process.returncode == 3
    assert process.error.splitlines() == [
        "hilbench: DDS needs Cyclone DDS, which is not installed; pip install 'hilbench[ros2]'"
    ]


def test_a_target_without_topics_joins_no_domain(forkable):
    process = forkable.run("serve", "pioneer", "--tcp", "0", "--dds")
    assert process.returncode == 2
    assert "--dds: the target has no topics" in process.error
