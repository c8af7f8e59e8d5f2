"""What an agent shows: who is there, topics, services and actions, with what was said last, in words where need be."""

from __future__ import annotations

import struct

import pytest

from protocols import xrce
from protocols.common.tables import Row
from protocols.xrce import AgentTables, GoalState
from protocols.xrce.cdr import Library
from tests.each import each
from tests.protocols.xrce.star import MS, PARTICIPANT, REQUESTER, SECOND, Star, objects
from tests.protocols.xrce.test_actions import FEEDBACK, FILES, ONE, SEND, Walker, goal


@pytest.fixture
def star():
    star = Star("line1", "line2")
    star.connect()
    star.tables = AgentTables(lambda: star.agent, Library(FILES.get))
    star.tables.look()
    return star


def write(star, name, data):
    star.write(name, data)
    star.run(100 * MS)


def test_who_is_there_is_shown_with_what_he_writes(star):
    star.create_all("line1")
    for object_id, made in objects(domain_id=7).items():
        star.create("line2", object_id, made)
    star.create("line2", 0x21, xrce.Participant(representation=xrce.ParticipantBinary(), domain_id=0))
    write(star, "line1", struct.pack("<f", 1.5))
    clients = star.tables.look()["clients"]
    assert dict(zip(clients.columns, clients.rows["line1"].cells, strict=True)) == {
        "client key": "01 02 03 01",
        "session": "0x81",
        "participants": "1",
        "objects": "6",
    }
    assert clients.rows["line2"].cells[2:] == ("1, 1 in domain 7", "7")
    assert [row.count for row in clients.rows.values()] == [1, 0]
    star._wrote(star.agent.line_down("line2", star.now_ns))
    assert [*star.tables.look()["clients"].rows] == ["line1"]


def test_a_topic_is_shown_with_its_ends_and_what_was_said_last(star):
    for name in ("line1", "line2"):
        star.create_all(name)
    empty = star.tables.look()["topics"]
    assert empty.columns == ("writers", "readers", "type")
    assert empty.rows == {"/speed": Row(cells=("2", "2", "std_msgs/msg/Float32"), count=0)}
    for number in range(3):
        write(star, "line1", struct.pack("<f", number / 2))
    (row,) = star.tables.look()["topics"].rows.values()
    assert (row.count, row.last) == (3, {"data": 1.0})
    assert star.tables.look()["topics"].rows["/speed"] == row
    star._wrote(star.agent.line_down("line1", star.now_ns))
    star._wrote(star.agent.line_down("line2", star.now_ns))
    assert star.tables.look()["topics"].rows == {}


def test_a_topic_without_the_prefix_of_ros_is_another_one(star):
    star.create_all("line1")
    star.create_all("line2", topic="/speed")
    rows = star.tables.look()["topics"].rows
    assert {name: row.cells[:2] for name, row in rows.items()} == {"/speed": ("1", "1"), "/speed of DDS": ("1", "1")}


@each(
    ("topic", "type_name", "data"),
    [
        ("rt/x/_action/status", "std_msgs::msg::dds_::Bool_", b"\1"),
        ("rt/x/_action/feedback", "std_msgs::msg::dds_::Bool_", b"\1"),
        ("rt/x/_action/feedback", "std_msgs::msg::dds_::Empty_", b"\1"),
        ("rt/\x1b[2J", "std_msgs::msg::dds_::Bool_", b"\1"),
        ("rt/x", "std_msgs::msg::dds_::String_", b"\5\0\0\0\x1b[2J\0"),
        ("rt/x", "../..::msg::dds_::a_", b"\1"),
        ("rt/x", "a\x1b::msg::dds_::Bool_", b"\1"),
        ("rt/x", f"{'a' * 300}::msg::dds_::Bool_", b"\1"),
    ],
)
def test_no_client_can_disturb_who_looks(topic, type_name, data):
    star, wanted = Star("a"), []
    star.connect()
    tables = AgentTables(lambda: star.agent, Library(wanted.append))
    tables.look()
    star.create_all("a", topic=topic, type_name=type_name)
    write(star, "a", data)
    for name, table in tables.look().items():
        for key, row in table.rows.items():
            last = row.last if isinstance(row.last, str) else " ".join(map(str, row.last.values()))
            assert all(text.isprintable() for text in (key, *row.cells, last)), (name, row)
    assert all(len(name) < 255 and name.isprintable() and ".." not in name for name in wanted)


def test_what_is_not_known_is_said_each_time_alike(star):
    library = Library({"demo/msg/Arm.msg": "Hand hand"}.get)
    for _ in range(2):
        with pytest.raises(xrce.LocalProtocolError, match="demo/msg/Hand is not known here"):
            library.decode("demo/msg/Arm", b"")


def test_a_sample_is_read_once(star):
    """It is looked at ten times a second, however seldom it comes."""
    star.create_all("line1")
    write(star, "line1", struct.pack("<f", 1.0))
    first = star.tables.look()["topics"].rows["/speed"].last
    assert star.tables.look()["topics"].rows["/speed"].last is first


def test_an_agent_that_is_started_anew_is_looked_at(star):
    star.create_all("line1")
    write(star, "line1", struct.pack("<f", 1.0))
    star.tables.look()
    star.agent = xrce.AgentService(("line1", "line2"), star.options)
    assert not any(table.rows for table in star.tables.look().values())
    star.restart("line1")
    star.connect("line1")
    star.create_all("line1")
    write(star, "line1", struct.pack("<f", 2.0))
    assert star.tables.look()["topics"].rows["/speed"].last == {"data": 2.0}
    assert star.tables.look()["topics"].rows["/speed"].count == 1


@each(
    ("type_name", "data", "last"),
    [
        ("demo::msg::dds_::Arm_", b"\1\2", "2 bytes; demo/msg/Arm is not known here"),
        ("String", b"\1", "1 byte; the type is none of ROS 2"),
        ("std_msgs::msg::dds_::Float64_", b"\1", "1 byte that make no std_msgs/msg/Float64: "),
        ("std_msgs::msg::dds_::Float32_", struct.pack("<f", float("nan")), {"data": "nan"}),
        ("std_msgs::msg::dds_::String_", b"\x47\0\0\0" + b"a" * 70 + b"\0", {"data": "a" * 59 + "…"}),
        ("builtin_interfaces::msg::dds_::Time_", struct.pack("<iI", 5, 6), {"sec": 5, "nanosec": 6}),
        ("unique_identifier_msgs::msg::dds_::UUID_", bytes(16), {"uuid": "00 00 00 00 00 00 00 00 ... 16 bytes"}),
        (
            "std_msgs::msg::dds_::Int16MultiArray_",
            struct.pack("<IIIhhh", 0, 0, 3, 1, 2, 3),
            {"layout.data_offset": 0, "data[0]": 1, "data[1]": 2, "data[2]": 3},
        ),
        (
            "std_msgs::msg::dds_::Int16MultiArray_",
            struct.pack("<IIIhhhhh", 0, 0, 5, 1, 2, 3, 4, 5),
            {"layout.data_offset": 0, "data": "5 values"},
        ),
        (
            "geometry_msgs::msg::dds_::Vector3Stamped_",
            struct.pack("<iIIB3xddd", 5, 6, 1, 0, 1.0, 2.0, 3.0),
            {"vector.x": 1.0, "vector.y": 2.0, "vector.z": 3.0, "header.stamp": "5.000000006 s", "header.frame_id": ""},
        ),
    ],
)
def test_a_sample_is_shown_field_by_field_or_in_words(type_name, data, last):
    star = Star("a")
    star.connect()
    tables = AgentTables(lambda: star.agent, Library())
    tables.look()
    star.create_all("a", topic="rt/any", type_name=type_name)
    write(star, "a", data)
    (row,) = tables.look()["topics"].rows.values()
    assert row.last == last or (isinstance(last, str) and last.endswith(": ") and row.last.startswith(last))


def test_of_many_fields_the_first_are_shown():
    star = Star("a", mtu=2000)
    star.connect()
    tables = AgentTables(lambda: star.agent, Library({"demo/msg/Many.msg": _many(40)}.get))
    tables.look()
    star.create_all("a", topic="many", type_name="demo::msg::dds_::Many_")
    write(star, "a", bytes(range(40)))
    last = tables.look()["topics"].rows["many"].last
    assert len(last) == 33
    assert last["f31"] == 31
    assert last["more"] == "8 fields"


def _many(count):
    return "\n".join(f"int8 f{number}" for number in range(count))


def test_a_service_is_one_row_with_the_last_request_and_reply(star):
    topics = {half: xrce.topic_of_ros("/add", f"demo/srv/Add_{kind}", half=half)
              for half, kind in (("request", "Request"), ("reply", "Response"))}  # fmt: skip
    made = xrce.RequesterBinary(
        service_name="add",
        request_type=topics["request"].type_name,
        reply_type=topics["reply"].type_name,
        request_topic_name=topics["request"].name,
        reply_topic_name=topics["reply"].name,
    )
    star.create("line1", PARTICIPANT, objects()[PARTICIPANT])
    star.create("line1", REQUESTER, xrce.Requester(representation=made, participant_id=PARTICIPANT))
    asked = []
    star.agent.listen(topics["request"].name, topics["request"].type_name, asked.append)
    replies = star.agent.writer(topics["reply"].name, topics["reply"].type_name)
    star.write("line1", struct.pack("<qq", 2, 3), REQUESTER)
    star.run(SECOND)
    star._wrote(star.agent.write(replies, struct.pack("<q", 5), star.now_ns, answers=asked[0].identity))
    tables = star.tables.look()
    assert tables["services"].rows == {
        "/add": Row(cells=("1", "1", "demo/srv/Add"), count=1, last={"request.a": 2, "request.b": 3, "reply.sum": 5})
    }
    assert not tables["topics"].rows
    assert not tables["actions"].rows


def test_an_action_is_one_row_with_its_goals_and_the_last_feedback():
    library = Library(FILES.get)
    walker = Walker(library)
    tables = AgentTables(lambda: walker.star.agent, library)
    assert {name: len(table.rows) for name, table in tables.look().items()} == {
        "clients": 1, "topics": 0, "services": 0, "actions": 1,
    }  # fmt: skip
    ((name, row),) = tables.look()["actions"].rows.items()
    assert (name, row) == ("/walk", Row(cells=("none", "1", "1", "demo/action/Walk"), count=0))
    walker.ask(SEND, **goal(ONE, 3.0))
    (asked,) = walker.server.active
    walker.do(walker.server.say(asked, {"gone_m": 1.0}, walker.star.now_ns))
    (row,) = tables.look()["actions"].rows.values()
    assert (row.cells[0], row.count) == ("1 executing", 1)
    assert {name: value for name, value in row.last.items() if "legs" not in name} == {
        "feedback.gone_m": 1.0,
        "goal.way_m": 3.0,
    }
    walker.do(walker.server.finish(asked, GoalState.CANCELED, {}, walker.star.now_ns))
    assert tables.look()["actions"].rows["/walk"].cells[0] == "1 canceled"
    assert len(walker.heard(FEEDBACK)) == 1
