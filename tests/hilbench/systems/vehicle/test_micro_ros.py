"""The driving stack beside a micro-ROS agent: its messages as samples, against a client of the protocol."""

from __future__ import annotations

import dataclasses
import struct

import pytest

from hilbench.bench import Bench
from hilbench.bench.devices import ClientDevice, DeviceActor
from hilbench.check import CheckOptions, Verdict, run_suites
from hilbench.check.bench_provider import make_provider
from hilbench.clock import Scheduler
from hilbench.journal import Journal
from hilbench.links import Line, MemoryLink
from hilbench.systems.vehicle.driving_stack import DrivingStack
from hilbench.systems.vehicle.micro_ros import MicroRosEnd
from hilbench.systems.vehicle.micro_ros_peer import MicroRosPeer, stack_peer
from hilbench.systems.vehicle.micro_ros_settings import MicroRosSettings
from hilbench.systems.vehicle.ros_messages import decode_sample, encode_sample, topic_of
from hilbench.systems.vehicle.stack_peer import StackPeer
from protocols import xrce
from protocols.autoware import (
    MESSAGES,
    AckermannControlCommand,
    AgentOnline,
    AgentPing,
    AgentState,
    Clock,
    ControlMode,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    LocalProtocolError,
    Time,
    TurnIndicatorsCommand,
    VelocityReport,
)
from protocols.xrce import machine

MS = 1_000_000
SECOND = 1000 * MS
PARTICIPANT, PUBLISHER, SUBSCRIBER, SERVICE = 0x11, 0x13, 0x14, 0x98
WRITES = {ControlModeReport: 2, VelocityReport: 3}
READS = {AckermannControlCommand: 4, Clock: 5}
COMMAND = AckermannControlCommand(
    stamp=Time(3, 4), steering_tire_angle=0.5, steering_tire_rotation_rate=0.25, speed=5.0, acceleration=1.0, jerk=0.125
)


class Board:
    """A board with micro-ROS at a line: a client, in Python, that creates everything as soon as it has a session."""

    def __init__(self, bench, port, domain_id=0):
        self.bench = bench
        self.domain_id = domain_id
        self.session = xrce.Session(xrce.Role.CLIENT, xrce.ClientOptions(client_key=b"test", attempts=1000))
        self.heard = []
        self.statuses = []
        self._device = ClientDevice(self.session, xrce.Transmit)
        self.actor = DeviceActor(bench, self._device, port, name="board", on_event=self._take)

    def ping(self):
        self.actor.transmit(self.session.ping(self.bench.now_ns))

    def connect(self):
        self.actor.transmit(self._device.take(self.session.connect(self.bench.now_ns)))
        self.bench.run_for(0.5)

    def say(self, message):
        number = WRITES[type(message)]
        self._send(xrce.WriteData(request_id=1, object_id=number << 4 | 5, data=encode_sample(message)))

    def answer(self, identity, *, success):
        self._send(xrce.WriteData(request_id=1, object_id=SERVICE, data=identity + bytes((success,))))

    def samples(self, kind):
        object_id = SERVICE if kind is ControlModeRequest else READS[kind] << 4 | 6
        return [said.data for said in self.heard if said.object_id == object_id]

    def _send(self, said):
        self.actor.transmit(self.session.send(said, self.bench.now_ns))

    def _take(self, event):
        if isinstance(event, xrce.SessionOpened):
            for object_id, made in self._objects().items():
                self._send(xrce.Create(request_id=20, object_id=object_id, object=made))
            control = xrce.DeliveryControl(max_samples=xrce.UNLIMITED)
            specification = xrce.ReadSpecification(stream_id=0x80, delivery=control)
            for object_id in (*(number << 4 | 6 for number in READS.values()), SERVICE):
                self._send(xrce.ReadData(request_id=30, object_id=object_id, specification=specification))
        elif isinstance(event, xrce.Received) and isinstance(event.submessage, xrce.TopicData):
            self.heard.append(event.submessage)
        elif isinstance(event, xrce.Received):
            self.statuses.append(event.submessage.status)

    def _objects(self):
        there = {"participant_id": PARTICIPANT}
        made = {
            PARTICIPANT: xrce.Participant(representation=xrce.ParticipantBinary(), domain_id=self.domain_id),
            PUBLISHER: xrce.Publisher(representation=xrce.PublisherBinary(), **there),
            SUBSCRIBER: xrce.Subscriber(representation=xrce.SubscriberBinary(), **there),
        }
        for kind, number in (WRITES | READS).items():
            topic = topic_of(kind)
            named = xrce.TopicBinary(topic_name=topic.name, type_name=topic.type_name)
            made[number << 4 | 2] = xrce.Topic(representation=named, **there)
            if kind in WRITES:
                binary = xrce.DataWriterBinary(topic_id=number << 4 | 2)
                made[number << 4 | 5] = xrce.DataWriter(representation=binary, publisher_id=PUBLISHER)
            else:
                binary = xrce.DataReaderBinary(topic_id=number << 4 | 2)
                made[number << 4 | 6] = xrce.DataReader(representation=binary, subscriber_id=SUBSCRIBER)
        asked, answered = topic_of(ControlModeRequest), topic_of(ControlModeResponse)
        service = xrce.ReplierBinary(
            service_name="control/control_mode_request",
            request_type=asked.type_name,
            reply_type=answered.type_name,
            request_topic_name=asked.name,
            reply_topic_name=answered.name,
        )
        return made | {SERVICE: xrce.Replier(representation=service, **there)}


@pytest.fixture
def line():
    bench = Bench(Scheduler(), Journal())
    return bench, MemoryLink(bench.scheduler, Line(baud=921_600), name="stack")


@pytest.fixture
def peer(line):
    bench, link = line
    return MicroRosPeer(bench, link.a, MicroRosSettings())


@pytest.fixture
def board(line, peer):
    board = Board(line[0], line[1].b)
    board.connect()
    assert board.session.state is xrce.ClientState.OPEN
    assert {*board.statuses} == {xrce.Status.OK}
    return board


# --- messages as samples


def test_each_message_of_a_topic_is_read_as_it_was_written():
    for kind, spec in MESSAGES.items():
        if spec.topic:
            message = kind()
            assert decode_sample(kind, encode_sample(message)) == message, kind


def test_a_control_command_is_that_of_ros():
    assert encode_sample(COMMAND) == struct.pack("<iIiIffiIfff", 3, 4, 0, 0, 0.5, 0.25, 0, 0, 5.0, 1.0, 0.125)
    big = struct.pack(">iIiIffiIfff", 3, 4, 0, 0, 0.5, 0.25, 0, 0, 5.0, 1.0, 0.125)
    assert decode_sample(AckermannControlCommand, big, little_endian=False) == COMMAND


def test_names_of_topics_and_types():
    assert topic_of(Clock) == xrce.TopicDescription("rt/clock", "rosgraph_msgs::msg::dds_::Clock_")
    assert topic_of(ControlModeResponse) == xrce.TopicDescription(
        "rr/control/control_mode_requestReply",
        "autoware_auto_vehicle_msgs::srv::dds_::ControlModeCommand_Response_",
    )
    with pytest.raises(KeyError, match="AgentPing"):
        topic_of(AgentPing)


def test_settings_that_make_no_agent():
    for wrong in (
        {"domain_id": -1},
        {"domain_id": 233},
        {"silence_s": 0},
        {"silence_s": float("nan")},
        {"slow_s": -1},
        {"slow_s": float("nan")},
        {"agents": 0},
        {"agents": 5},
    ):
        with pytest.raises(ValueError, match=next(iter(wrong))):
            MicroRosSettings(**wrong)


# --- the checker's end


def test_what_is_said_to_the_board_comes_as_a_sample(peer, board, line):
    peer.send(COMMAND)
    peer.set_clock(5 * SECOND)
    line[0].run_for(0.1)
    assert board.samples(AckermannControlCommand) == [encode_sample(COMMAND)]
    assert board.samples(Clock) == [struct.pack("<iI", 5, 0)]


def test_what_the_board_publishes_is_a_message_of_its_frame(peer, board, line):
    mark = peer.mark()
    board.say(ControlModeReport(mode=4))
    board.say(VelocityReport(longitudinal_velocity=2.5))
    line[0].run_for(0.1)
    assert peer.modes(mark) == [4]
    ((got, report),) = peer.since(mark, VelocityReport)
    assert report.longitudinal_velocity == 2.5
    assert got.at_ns - got.start_ns == pytest.approx((len(got.raw) - 1) * SECOND * 10 / 921_600, abs=1000)


def test_an_answer_has_the_number_of_its_request(peer, board, line):
    peer.send(ControlModeRequest(sequence=7, mode=ControlMode.MANUAL))
    peer.send(ControlModeRequest(sequence=8, mode=ControlMode.AUTONOMOUS))
    line[0].run_for(0.1)
    one, other = board.samples(ControlModeRequest)
    assert (one[32], other[32]) == (4, 1)
    board.answer(other[:24], success=True)
    board.answer(one[:24], success=False)
    line[0].run_for(0.1)
    answers = [answer for _, answer in peer.since(0, ControlModeResponse)]
    assert answers == [ControlModeResponse(sequence=8, success=True), ControlModeResponse(sequence=7, success=False)]


def test_a_ping_is_seen_and_answered_while_it_is_online(peer, line):
    bench, link = line
    board = Board(bench, link.b)
    for online, seen, answered in ((False, 1, 0), (True, 2, 1)):
        peer.online = online
        board.ping()
        bench.run_for(0.1)
        assert len(peer.since(0, AgentPing)) == seen
        assert board.session.counters.frames_in == answered


def test_its_tables_show_the_board_and_the_stack_beside_it(peer, board, line):
    peer.end.tables.look()
    peer.set_clock(5 * SECOND)
    line[0].run_for(0.1)
    tables = peer.end.tables.look()
    assert [*tables["clients"].rows] == ["board"]
    assert tables["topics"].rows["/clock"].last == {"clock": "5.000000000 s"}
    (service,) = tables["services"].rows.values()
    assert service.cells == ("1", "1", "autoware_auto_vehicle_msgs/srv/ControlModeCommand")


def test_an_agent_that_was_killed_knows_nothing(peer, board, line):
    peer.online = False
    board.say(ControlModeReport(mode=1))
    line[0].run_for(1.0)
    assert peer.modes() == []
    peer.go_online()
    line[0].run_for(5.0)
    assert peer.end.state is AgentState.ALONE
    assert peer.modes() == []


def test_damage_in_each_bit_of_a_message_for_the_board_can_be_made(peer, board, line):
    frame = peer.frame_of(COMMAND)
    peer.write(frame)
    line[0].run_for(0.1)
    assert board.samples(AckermannControlCommand) == [encode_sample(COMMAND)]
    peer.write(frame[:-1] + bytes((frame[-1] ^ 1,)))
    line[0].run_for(0.1)
    assert board.session.counters.bad_crcs == 1
    with pytest.raises(LocalProtocolError, match="nobody at the line reads rt/control/command/turn"):
        peer.frame_of(TurnIndicatorsCommand())


def test_its_sign_of_life_is_the_time_that_it_told_last(peer, board, line):
    peer.set_clock(3 * SECOND)
    peer.send(AgentOnline())
    peer.write(peer.wire(AgentOnline()))
    line[0].run_for(0.1)
    assert board.samples(Clock) == [struct.pack("<iI", 3, 0)] * 3


def test_another_domain_is_not_heard(line):
    bench, link = line
    peer = stack_peer(bench, link.a, MicroRosSettings(domain_id=5))
    board = Board(bench, link.b, domain_id=4)
    board.connect()
    peer.send(COMMAND)
    board.say(ControlModeReport(mode=1))
    bench.run_for(0.5)
    assert board.samples(AckermannControlCommand) == []
    assert peer.modes() == []


def test_a_slow_agent_says_all_later(line):
    bench, link = line
    peer = stack_peer(bench, link.a, MicroRosSettings(slow_s=0.25, silence_s=5.0))
    board = Board(bench, link.b)
    board.connect()
    bench.run_for(2.0)
    assert {*board.statuses} == {xrce.Status.OK}
    peer.send(COMMAND)
    bench.run_for(0.24)
    assert board.samples(AckermannControlCommand) == []
    bench.run_for(0.02)
    assert board.samples(AckermannControlCommand) == [encode_sample(COMMAND)]


def test_of_two_agents_each_says_all(line):
    bench, link = line
    peer = stack_peer(bench, link.a, MicroRosSettings(agents=2))
    board = Board(bench, link.b)
    board.connect()
    peer.send(COMMAND)
    bench.run_for(0.1)
    assert board.samples(AckermannControlCommand) == [encode_sample(COMMAND)]
    assert board.session.counters.stale > 5


def test_without_an_agent_the_link_is_the_stand_in(line):
    assert type(stack_peer(line[0], line[1].a, None)) is StackPeer


# --- the driving stack


def test_the_driving_stack_drives_through_an_agent(line):
    bench, link = line
    stack = DrivingStack(bench, link.a, connection=MicroRosEnd())
    board = Board(bench, link.b)
    found = []
    stack.on_board = found.append
    stack.open()
    board.connect()
    assert stack.state is AgentState.HEARD
    stack.drive_with(lambda: COMMAND)
    board.say(ControlModeReport(mode=1))
    bench.run_for(1.0)
    assert stack.mode == 1
    assert len(board.samples(AckermannControlCommand)) == pytest.approx(30, abs=1)
    assert len(board.samples(Clock)) >= 20
    answers = []
    stack.request_mode(ControlMode.MANUAL, answers.append)
    bench.run_for(0.1)
    board.answer(board.samples(ControlModeRequest)[0][:24], success=True)
    bench.run_for(0.1)
    assert answers == [True]
    assert found == [True]


def test_a_board_that_falls_silent_is_lost(line):
    bench, link = line
    stack = DrivingStack(bench, link.a, connection=MicroRosEnd(MicroRosSettings(silence_s=2.0)), clock_hz=None)
    board = Board(bench, link.b)
    found = []
    stack.on_board = found.append
    stack.open()
    board.connect()
    bench.run_for(1.3)
    assert found == [True]
    bench.run_for(1.0)
    assert found == [True, False]
    assert stack.failure
    stack.close()
    assert stack.state is AgentState.CLOSED
    with pytest.raises(LocalProtocolError, match="no agent runs"):
        stack.close()
    stack.open()
    with pytest.raises(LocalProtocolError, match="the agent runs"):
        stack.open()


def test_what_is_the_board_s_to_say_is_refused():
    with pytest.raises(LocalProtocolError, match="ControlModeReport"):
        MicroRosEnd().send(ControlModeReport(), 0)


# --- the bench


OPTIONS = CheckOptions(bench="vehicle-micro-ros", suites=("vehicle-board",))


@pytest.mark.slow("runs a case of the emulated board, with its client of DDS-XRCE")
def test_the_firmware_hands_commands_on_through_an_agent():
    options = dataclasses.replace(OPTIONS, select="(VB01 or VB04H) and hardened")
    cases = run_suites(options, make_provider(options)).cases
    assert [(case.cause, case.verdict) for case in cases] == [("", Verdict.PASS)] * 2


@pytest.mark.slow("runs a case of the emulated board, with its client of DDS-XRCE")
def test_a_client_that_acknowledges_data_and_hands_none_on_is_found(monkeypatch):
    """What DDS-XRCE obliges no client to show at its line; here the board is to it as if it had thrown DATA away."""

    def without_data(said):
        if isinstance(said, xrce.TopicData):
            said = xrce.StatusReply(request_id=0xFFF0, object_id=0xFF11, status=xrce.Status.OK)
        return xrce.encode_submessage(said)

    monkeypatch.setattr(machine, "encode_submessage", without_data)
    options = dataclasses.replace(OPTIONS, select="VB01 and hardened")
    (case,) = run_suites(options, make_provider(options)).cases
    assert case.verdict is Verdict.FAIL


@pytest.mark.exhaustive("the whole bench twice: 260 cases on the emulated board with either link")
def test_the_verdicts_are_those_of_the_stand_in():
    verdicts = {}
    for bench in ("vehicle", "vehicle-micro-ros"):
        options = CheckOptions(bench=bench)
        report = run_suites(options, make_provider(options))
        verdicts[bench] = {case.id: case.verdict for case in report.cases}
    assert verdicts["vehicle"] == verdicts["vehicle-micro-ros"]
    assert {*verdicts["vehicle"].values()} <= {Verdict.PASS, Verdict.NOT_APPLICABLE}
