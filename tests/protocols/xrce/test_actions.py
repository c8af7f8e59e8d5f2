"""Actions of ROS 2: what their files say, what they are called in DDS, and a client with a server of ours."""

from __future__ import annotations

import pytest

from protocols import xrce
from protocols.xrce import GoalState, LocalProtocolError, RosKind, RosName, Status
from protocols.xrce.cdr import (
    Library,
    MessageTypes,
    definition_of,
    parse_action,
    parse_message,
    text_of_fields,
    whole_of,
)
from tests.each import each
from tests.protocols.xrce.star import MS, PARTICIPANT, SECOND, SUBSCRIBER, Star, objects

WALK = """
# how far
float32 way_m
uint8 FAST=2
---
float32 gone_m
string<=20[<=3] words
---
float32 gone_m 0.5
Leg[4] legs
"""
FILES = {
    "demo/action/Walk.action": WALK,
    "demo/msg/Leg.msg": "bool up",
    "demo/srv/Add.srv": "int64 a\nint64 b\n---\nint64 sum",
    "demo/srv/Torn.srv": "int64 a",
}
UUID, TIME = "unique_identifier_msgs/msg/UUID", "builtin_interfaces/msg/Time"


@pytest.fixture
def library():
    return Library(FILES.get)


def test_an_action_brings_what_rosidl_makes_of_its_three_parts():
    found = parse_action("demo/Walk", WALK)
    assert {one.name: text_of_fields(one).split("\n") for one in found.messages} == {
        "demo/action/Walk_Goal": ["float32 way_m"],
        "demo/action/Walk_Result": ["float32 gone_m", "string<=20[<=3] words"],
        "demo/action/Walk_Feedback": ["float32 gone_m", "demo/msg/Leg[4] legs"],
        "demo/action/Walk_SendGoal_Request": [f"{UUID} goal_id", "demo/action/Walk_Goal goal"],
        "demo/action/Walk_SendGoal_Response": ["bool accepted", f"{TIME} stamp"],
        "demo/action/Walk_GetResult_Request": [f"{UUID} goal_id"],
        "demo/action/Walk_GetResult_Response": ["int8 status", "demo/action/Walk_Result result"],
        "demo/action/Walk_FeedbackMessage": [f"{UUID} goal_id", "demo/action/Walk_Feedback feedback"],
    }
    assert [one.name for one in found.goal.constants] == ["FAST"]


@each(
    ("text", "words"),
    [
        ("int8 a\n---\nint8 b", "demo/action/Walk: an action has two lines ---, not 1"),
        ("---\n---\n---", "demo/action/Walk: an action has two lines ---, not 3"),
        ("int8 a\n---\n\n---\nint9", "demo/action/Walk_Feedback, line 5: 'int9' is no field"),
    ],
)
def test_an_action_file_that_cannot_be_read_says_where(text, words):
    with pytest.raises(LocalProtocolError, match=f"^{words}"):
        parse_action("demo/Walk", text)


def test_the_fields_of_a_message_as_text_make_the_same_message():
    for name in ("sensor_msgs/msg/Imu", "action_msgs/msg/GoalStatusArray", "std_msgs/msg/MultiArrayLayout"):
        one = definition_of(name)
        assert parse_message(name, text_of_fields(one)) == one


@each(
    ("topic", "found"),
    [
        ("rt/chatter", RosName(RosKind.TOPIC, "/chatter")),
        ("rt/a/b", RosName(RosKind.TOPIC, "/a/b")),
        ("rq/addRequest", RosName(RosKind.SERVICE, "/add", "", "request")),
        ("rr/addReply", RosName(RosKind.SERVICE, "/add", "", "reply")),
        ("rr/addRequest", None),
        ("rq/add", None),
        ("chatter", None),
        ("rt", None),
        ("rq/ns/walk/_action/send_goalRequest", RosName(RosKind.ACTION, "/ns/walk", "send_goal", "request")),
        ("rr/walk/_action/cancel_goalReply", RosName(RosKind.ACTION, "/walk", "cancel_goal", "reply")),
        ("rr/walk/_action/get_resultReply", RosName(RosKind.ACTION, "/walk", "get_result", "reply")),
        ("rt/walk/_action/feedback", RosName(RosKind.ACTION, "/walk", "feedback")),
        ("rt/walk/_action/status", RosName(RosKind.ACTION, "/walk", "status")),
        ("rt/walk/_action/other", RosName(RosKind.TOPIC, "/walk/_action/other")),
        ("rt/walk/_action/send_goal", RosName(RosKind.TOPIC, "/walk/_action/send_goal")),
        ("rq/walk/_action/statusRequest", RosName(RosKind.SERVICE, "/walk/_action/status", "", "request")),
    ],
)
def test_what_a_topic_of_dds_is_in_ros(topic, found):
    assert xrce.ros_name(topic) == found


@each(
    ("type_name", "found", "whole"),
    [
        ("std_msgs::msg::dds_::String_", "std_msgs/msg/String", "std_msgs/msg/String"),
        ("demo::srv::dds_::Add_Response_", "demo/srv/Add_Response", "demo/srv/Add"),
        ("demo::action::dds_::Walk_SendGoal_Request_", "demo/action/Walk_SendGoal_Request", "demo/action/Walk"),
        ("demo::action::dds_::Walk_FeedbackMessage_", "demo/action/Walk_FeedbackMessage", "demo/action/Walk"),
        ("demo::msg::dds_::The_Goal_", "demo/msg/The_Goal", "demo/msg/The_Goal"),
        ("demo::idl::dds_::String_", None, ""),
        ("demo::msg::String_", None, ""),
        ("demo::msg::dds_::String", None, ""),
        ("String", None, ""),
    ],
)
def test_what_a_type_of_dds_is_in_ros(type_name, found, whole):
    assert xrce.ros_type(type_name) == found
    assert found is None or whole_of(found) == whole


def test_a_library_knows_messages_by_their_files_and_without(library):
    assert library.decode("demo/srv/Add_Request", bytes(8) + b"\2" + bytes(7)) == {"a": 0, "b": 2}
    assert library.decode("std_srvs/srv/Trigger_Request", b"\0") == {}
    assert library.decode("demo/msg/Leg", b"\1") == {"up": True}
    assert library.text_of("demo/srv/Add_Reply") is None
    full = library.full_text("demo/action/Walk_FeedbackMessage")
    assert full.startswith(f"{UUID} goal_id\ndemo/Walk_Feedback feedback\n====")
    assert "\nMSG: demo/Walk_Feedback\nfloat32 gone_m\ndemo/msg/Leg[4] legs\n" in full
    for name, words in (
        ("demo/msg/Arm", "demo/msg/Arm is not known here"),
        ("demo/srv/Other_Request", "demo/srv/Other_Request is not known here"),
        ("demo/srv/Torn_Request", "demo/srv/Torn: a service has one line ---, not 0"),
    ):
        for _ in range(2):
            with pytest.raises(LocalProtocolError, match=words):
                library.decode(name, b"")


# --- both roles

SEND, CANCEL, GET, FEEDBACK, STATUS = 0x27, 0x37, 0x47, 0x26, 0x36
ONE, TWO = bytes(range(16)), bytes(range(16, 32))
SERVICES = {
    SEND: ("send_goal", "demo/action/Walk_SendGoal"),
    CANCEL: ("cancel_goal", "action_msgs/srv/CancelGoal"),
    GET: ("get_result", "demo/action/Walk_GetResult"),
}
TOPICS = {
    FEEDBACK: ("feedback", "demo/action/Walk_FeedbackMessage", 0x22),
    STATUS: ("status", "action_msgs/msg/GoalStatusArray", 0x32),
}


class Walker:
    """A client that asks, and the bench's node that answers; see `Star`."""

    def __init__(self, library):
        self.star, self.library = Star("asks"), library
        self.server = xrce.ActionServer(
            self.star.agent, "/walk", "demo/action/Walk", library, accepts=lambda wanted: wanted["way_m"] < 100
        )
        self.star.connect()
        for object_id in (PARTICIPANT, SUBSCRIBER):
            assert self.star.create("asks", object_id, objects()[object_id]) is Status.OK
        for object_id, (part, service) in SERVICES.items():
            self._create_requester(object_id, part, service)
        for object_id, (part, message, topic_id) in TOPICS.items():
            self._create_reader(object_id, part, message, topic_id)
        for object_id in (*SERVICES, *TOPICS):
            self.star.read("asks", object_id, request_id=object_id)

    def _create_requester(self, object_id, part, service):
        request = xrce.topic_of_ros(f"/walk/_action/{part}", f"{service}_Request", half="request")
        reply = xrce.topic_of_ros(f"/walk/_action/{part}", f"{service}_Response", half="reply")
        made = xrce.RequesterBinary(
            service_name=part,
            request_type=request.type_name,
            reply_type=reply.type_name,
            request_topic_name=request.name,
            reply_topic_name=reply.name,
        )
        asks = xrce.Requester(representation=made, participant_id=PARTICIPANT)
        assert self.star.create("asks", object_id, asks) is Status.OK

    def _create_reader(self, object_id, part, message, topic_id):
        named = xrce.topic_of_ros(f"/walk/_action/{part}", message)
        topic = xrce.TopicBinary(topic_name=named.name, type_name=named.type_name)
        made = xrce.Topic(representation=topic, participant_id=PARTICIPANT)
        assert self.star.create("asks", topic_id, made) is Status.OK
        reader = xrce.DataReaderBinary(topic_id=topic_id)
        made = xrce.DataReader(representation=reader, subscriber_id=SUBSCRIBER)
        assert self.star.create("asks", object_id, made) is Status.OK

    def ask(self, object_id, **message):
        """Ask one of the services; return what it answers at once, None for nothing."""
        service = SERVICES[object_id][1]
        before = len(self.heard(object_id))
        self.star.write("asks", self.library.encode(f"{service}_Request", message), object_id)
        self.star.run(SECOND)
        self.do(self.server.advance(self.star.now_ns))
        return next(iter(self.heard(object_id)[before:]), None)

    def do(self, written):
        self.star._wrote(written)
        self.star.run(10 * MS)

    def heard(self, object_id):
        name = TOPICS[object_id][1] if object_id in TOPICS else f"{SERVICES[object_id][1]}_Response"
        return [
            self.library.decode(name, said.data[4 * (object_id in SERVICES) :])
            for _, said in self.star.heard["asks"]
            if isinstance(said, xrce.TopicData) and said.object_id == object_id
        ]

    def states(self):
        return [[one["status"] for one in said["status_list"]] for said in self.heard(STATUS)]


def goal(goal_id, way_m):
    return {"goal_id": {"uuid": goal_id}, "goal": {"way_m": way_m}}


def info(goal_id=bytes(16), ns=0):
    sec, nanosec = divmod(ns, SECOND)
    return {"goal_info": {"goal_id": {"uuid": goal_id}, "stamp": {"sec": sec, "nanosec": nanosec}}}


def test_a_goal_is_accepted_told_of_and_ended(library):
    walker = Walker(library)
    assert walker.ask(SEND, **goal(ONE, 100.0))["accepted"] is False
    assert walker.server.active == []
    accepted = walker.ask(SEND, **goal(ONE, 3.0))
    assert accepted["accepted"] is True
    assert walker.ask(SEND, **goal(ONE, 3.0))["accepted"] is False  # it is there already
    (asked,) = walker.server.active
    assert (asked.goal_id, asked.wanted) == (ONE, {"way_m": 3.0})
    assert accepted["stamp"] == dict(zip(("sec", "nanosec"), divmod(asked.accepted_ns, SECOND), strict=True))
    assert walker.ask(GET, goal_id={"uuid": ONE}) is None
    for gone_m in (1.0, 2.0):
        walker.do(walker.server.say(asked, {"gone_m": gone_m}, walker.star.now_ns))
    assert [one["goal_id"]["uuid"] for one in walker.heard(FEEDBACK)] == [ONE, ONE]
    assert [one["feedback"]["gone_m"] for one in walker.heard(FEEDBACK)] == [1.0, 2.0]
    walker.do(walker.server.finish(asked, GoalState.SUCCEEDED, {"gone_m": 3.0, "words": ["done"]}, walker.star.now_ns))
    ended = {"status": GoalState.SUCCEEDED, "result": {"gone_m": 3.0, "words": ["done"]}}
    assert walker.heard(GET) == [ended]
    assert walker.ask(GET, goal_id={"uuid": ONE}) == ended
    assert walker.ask(GET, goal_id={"uuid": TWO})["status"] == 0
    assert walker.states() == [[GoalState.ACCEPTED], [GoalState.EXECUTING], [GoalState.SUCCEEDED]]


def test_goals_are_given_up_by_id_by_time_or_all(library):
    walker = Walker(library)
    walker.ask(SEND, **goal(ONE, 1.0))
    between_ns = walker.star.now_ns
    walker.ask(SEND, **goal(TWO, 2.0))
    one, two = walker.server.active

    def given_up(said):
        return said["return_code"], [told["goal_id"]["uuid"] for told in said["goals_canceling"]]

    assert given_up(walker.ask(CANCEL, **info(bytes(15) + b"\1"))) == (2, [])
    assert given_up(walker.ask(CANCEL, **info(ns=between_ns))) == (0, [ONE])
    assert (one.state, two.state) == (GoalState.CANCELING, GoalState.ACCEPTED)
    assert given_up(walker.ask(CANCEL, **info(TWO))) == (0, [TWO])
    assert given_up(walker.ask(CANCEL, **info())) == (0, [ONE, TWO])
    walker.do(walker.server.finish(one, GoalState.CANCELED, {"gone_m": 0.1}, walker.star.now_ns))
    assert given_up(walker.ask(CANCEL, **info(ONE))) == (3, [])
    assert given_up(walker.ask(CANCEL, **info())) == (0, [TWO])
    assert walker.server.active == [two]
    assert walker.states()[-1] == [GoalState.CANCELED, GoalState.CANCELING]
    assert walker.ask(GET, goal_id={"uuid": ONE})["status"] == GoalState.CANCELED


def test_nonsense_gets_no_answer_and_the_latest_results_are_kept(library):
    walker = Walker(library)
    walker.star.write("asks", b"\1", SEND)
    walker.star.run(SECOND)
    walker.do(walker.server.advance(walker.star.now_ns))
    assert walker.heard(SEND) == []
    for number in range(20):
        walker.ask(SEND, **goal(bytes((number,)) * 16, 1.0))
        (asked,) = walker.server.active
        walker.do(walker.server.finish(asked, GoalState.ABORTED, {}, walker.star.now_ns))
    assert [goal_id[0] for goal_id in walker.server.goals] == [*range(4, 20)]


def test_an_action_that_is_not_known_is_refused():
    with pytest.raises(LocalProtocolError, match="demo/action/Walk_FeedbackMessage is not known here"):
        xrce.ActionServer(Star("a").agent, "/walk", "demo/action/Walk", Library())


def test_messages_of_a_library_are_those_of_types_that_know_each_other(library):
    types = MessageTypes()
    for one in (*parse_action("demo/Walk", WALK).messages, definition_of(UUID), parse_message("demo/Leg", "bool up")):
        types.add(one)
    said = {"goal_id": {"uuid": ONE}, "feedback": {"gone_m": 1.0, "legs": [{"up": True}] * 4}}
    data = types.encode("demo/action/Walk_FeedbackMessage", said)
    assert library.encode("demo/action/Walk_FeedbackMessage", said) == data
    assert library.decode("demo/action/Walk_FeedbackMessage", data) == said
