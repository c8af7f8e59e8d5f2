"""Samples of topics of ROS 2 in a recording, in MCAP: as `ros2 bag` has them, and beside all else."""

from __future__ import annotations

import io
import struct
from pathlib import Path

import pytest

from hilbench.cli import main
from hilbench.journal import Journal, Recording
from hilbench.recordings.mcap_file import write_mcap, write_ros2
from hilbench.systems.xrce_agent.protocol import XRCE
from protocols import xrce
from protocols.testing import lossy, unchanged
from protocols.xrce.cdr import INTERFACES, MessageTypes, decapsulate, definition_of, full_text, parse_message
from tests.each import each
from tests.protocols.xrce.star import SECOND, WRITER, Star, objects

VECTOR = "geometry_msgs::msg::dds_::Vector3Stamped_"


class Recorded(Star):
    """An agent and its clients whose bytes are recorded at the agent's ends of the lines, as `serve` does it."""

    def __init__(self, *names, **options):
        self.recorded = []
        super().__init__(*names, **options)
        self.connect()

    def _fly(self, end, line, data):
        arrives = self.damage(data)
        seen = arrives if end == "agent" else data
        if seen:
            about = {"ns": self.now_ns, "kind": "rx" if end == "agent" else "tx", "source": "agent", "line": line}
            self.recorded.append({**about, "data": seen.hex()})
        damage, self.damage = self.damage, unchanged
        super()._fly(end, line, arrives)
        self.damage = damage

    @property
    def recording(self):
        return Recording(header={"hilbench": "0"}, events=tuple(self.recorded), problem=None, ended=True)


def messages_in(file):
    from mcap.reader import make_reader

    return list(make_reader(io.BytesIO(file.getvalue())).iter_messages())


def topics_in(recording, folders=()):
    """The samples of a recording by topic, each with its type; and the types that are not known."""
    file = io.BytesIO()
    written = write_mcap(recording, file, XRCE, folders)
    found = {}
    for schema, channel, message in messages_in(file):
        if channel.message_encoding == "cdr":
            assert schema.encoding == ("" if schema.name in written.unknown else "ros2msg")
            found.setdefault((channel.topic, schema.name), []).append(message.data)
    assert written.samples == sum(map(len, found.values()))
    return found, written.unknown


def floats(samples):
    assert {sample[:4] for sample in samples} == {b"\0\1\0\0"}
    return [struct.unpack("<f", sample[4:])[0] for sample in samples]


def test_each_line_of_a_source_has_channels_of_its_own():
    star = Recorded("line1", "line2")
    file = io.BytesIO()
    write_mcap(star.recording, file, XRCE)
    topics = {channel.topic for _, channel, _ in messages_in(file)}
    ends = [f"/agent/{line}/{way}" for line in ("line1", "line2") for way in ("rx", "tx")]
    assert topics == {*ends, *(f"{end}/frames" for end in ends)}


@each("damage", [unchanged, lossy(5, drop=0.05, repeat=0.05)])
def test_what_clients_write_is_there_once_whatever_is_repeated(damage):
    star = Recorded("a", "b")
    for name in ("a", "b"):
        star.create_all(name)
        star.read(name)
    star.damage = damage
    for number in range(50):
        star.write("ab"[number % 2], struct.pack("<f", number))
        star.run(SECOND // 10)
    star.damage = unchanged
    star.run(10 * SECOND)
    found, unknown = topics_in(star.recording)
    assert (list(found), unknown) == ([("/speed", "std_msgs/msg/Float32")], [])
    assert sorted(floats(*found.values())) == list(range(50))


def test_what_no_client_writes_is_what_one_of_them_reads_in_pieces_or_not():
    star = Recorded("a", "b")
    kind = "std_msgs::msg::dds_::UInt8MultiArray_"
    for name in ("a", "b"):
        for object_id, made in objects(type_name=kind).items():
            assert object_id == WRITER or star.create(name, object_id, made) is xrce.Status.OK
        star.read(name)
    writer = star.agent.writer("rt/speed", kind)
    for length in (12, 3000):
        star._wrote(star.agent.write(writer, bytes(length), star.now_ns))
        star.run(SECOND)
    ((of, samples),) = topics_in(star.recording)[0].items()
    assert of == ("/speed", "std_msgs/msg/UInt8MultiArray")
    assert [len(sample) - 4 for sample in samples] == [12, 3000]


def test_a_message_has_its_definition_with_all_that_is_in_it():
    star = Recorded("a")
    star.create_all("a", topic="rt/imu/field", type_name=VECTOR)
    types = MessageTypes()
    for name in INTERFACES:
        types.add(definition_of(name))
    said = {"header": {"stamp": {"sec": 5, "nanosec": 6}, "frame_id": "imu"}, "vector": {"x": 1.0, "y": 2.0, "z": 3.0}}
    star.write("a", types.encode("geometry_msgs/msg/Vector3Stamped", said))
    star.run(SECOND)
    file = io.BytesIO()
    write_ros2(star.recording, file, XRCE.samples(_frames(star.recording), ())[0])
    ((schema, channel, message),) = messages_in(file)
    assert (channel.topic, channel.message_encoding, schema.name) == (
        "/imu/field",
        "cdr",
        "geometry_msgs/msg/Vector3Stamped",
    )
    parts = schema.data.decode().split("=" * 80 + "\nMSG: ")
    names = ["geometry_msgs/Vector3Stamped", *(part.partition("\n")[0] for part in parts[1:])]
    texts = [parts[0], *(part.partition("\n")[2] for part in parts[1:])]
    read = MessageTypes()
    for name, text in zip(names, texts, strict=True):
        read.add(parse_message(name, text))
    data, little_endian = decapsulate(message.data)
    assert read.decode("geometry_msgs/msg/Vector3Stamped", data, little_endian=little_endian) == said


def _frames(recording):
    from hilbench.recordings.frames import framed
    from hilbench.recordings.layout import laid_out

    return list(framed(laid_out(recording.events), XRCE))


@pytest.fixture
def journal(tmp_path):
    """A board that says a type of its own."""
    star = Recorded("a")
    star.create_all("a", topic="rt/own", type_name="mine::msg::dds_::Own_")
    star.write("a", struct.pack("<fi", 1, 2))
    star.run(SECOND)
    path = tmp_path / "run.jsonl"
    log = Journal(path, {"bench": "test"})
    for event in star.recorded:
        log.record(event["kind"], event["source"], event["ns"], line=event["line"], data=bytes.fromhex(event["data"]))
    log.close()
    return path


def test_types_of_ones_own_are_read_from_folders(journal, tmp_path, capfd):
    assert main(["export", str(journal), "--ros2", str(tmp_path / "it.mcap")]) == 0
    assert "1 events (samples of topics; not known without --types: mine/msg/Own)" in capfd.readouterr().out
    folder = tmp_path / "share" / "mine" / "msg"
    folder.mkdir(parents=True)
    (folder / "Own.msg").write_text("float32 speed  # m/s\nint32 count\n")
    assert main(["export", str(journal), "--ros2", str(tmp_path / "it.mcap"), "--types", str(tmp_path / "share")]) == 0
    assert "1 events (samples of topics)" in capfd.readouterr().out
    ((schema, channel, _),) = messages_in(io.BytesIO((tmp_path / "it.mcap").read_bytes()))
    assert (channel.topic, schema.data) == ("/own", b"float32 speed  # m/s\nint32 count\n")


def test_without_topics_there_is_no_file(tmp_path, capfd):
    path = tmp_path / "run.jsonl"
    log = Journal(path, {"bench": "test"})
    log.record("tx", "checker", 1000, data=bytes.fromhex("fafb03000000"))
    log.close()
    assert main(["export", str(path), "--ros2", str(tmp_path / "it.mcap")]) == 2
    assert "has no topics of ROS 2" in capfd.readouterr().err
    assert not (tmp_path / "it.mcap").exists()


def test_an_unreadable_definition_is_named(journal, tmp_path, capfd):
    folder = tmp_path / "share" / "mine" / "msg"
    export = ["export", str(journal), "--ros2", str(tmp_path / "it.mcap"), "--types", str(tmp_path / "share")]
    (folder / "Own.msg").mkdir(parents=True)
    assert main(export) == 2
    assert "Own.msg: cannot be read" in capfd.readouterr().err
    (folder / "Own.msg").rmdir()
    (folder / "Own.msg").write_text("uint8 a\nwhat?!\n")
    assert main(export) == 2
    said = capfd.readouterr().err
    assert "Own.msg: cannot be read: mine/msg/Own, line 2: 'what?!' is no field and no constant" in said
    (folder / "Own.msg").write_text("Inner a\nwstring b")
    assert main(export) == 0
    assert "1 events (samples of topics; neither known nor in --types: mine/msg/Inner)" in capfd.readouterr().out
    (folder / "Inner.msg").write_text("float32 speed\nint32[<=3] count", encoding="utf-8-sig")
    assert main(export) == 0
    assert "1 events (samples of topics)" in capfd.readouterr().out


@each(
    ("topic", "kind"),
    [
        ("rt/own", "../secret::msg::dds_::Own_"),
        ("rt/own", "a\0b::msg::dds_::Own_"),
        ("rt/own", "\udcff::msg::dds_::Own_"),
        ("rt/own", "mine::msg::dds_::_"),
        ("rt/own", f"mine::msg::dds_::{'O' * 300}_"),
        ("rt/\udcff", VECTOR),
        ("rt/a\0b", VECTOR),
        ("rt/", VECTOR),
    ],
)
def test_what_has_no_name_of_ros_is_left_out(tmp_path, topic, kind):
    star = Recorded("a")
    star.create_all("a", topic=topic, type_name=kind)
    star.write("a", bytes(4))
    star.run(SECOND)
    assert topics_in(star.recording, [tmp_path]) == ({}, [])


# --- a second opinion


def test_rosbags_knows_the_same_messages():
    typesys = pytest.importorskip("rosbags.typesys")
    known = typesys.get_typestore(typesys.Stores.ROS2_HUMBLE)
    compared = {name for name in INTERFACES if name in known.fielddefs}
    assert {name.partition("/")[0] for name in INTERFACES.keys() - compared} == {
        "autoware_auto_control_msgs",
        "autoware_auto_vehicle_msgs",
    }
    for name in compared - {"std_msgs/msg/Empty"}:  # which has a member there that no file names
        found = typesys.get_types_from_msg(full_text(name, INTERFACES.get), name)
        assert {one: found[one][1] for one in found} == {one: known.fielddefs[one][1] for one in found}, name


def test_rosbags_reads_a_message_without_fields(tmp_path):
    highlevel = pytest.importorskip("rosbags.highlevel")
    star = Recorded("a")
    star.create_all("a", type_name="std_msgs::msg::dds_::Empty_")
    star.write("a", b"\0")
    star.run(SECOND)
    path = tmp_path / "it.mcap"
    with path.open("wb") as file:
        write_ros2(star.recording, file, XRCE.samples(_frames(star.recording), ())[0])
    ((schema, _, _),) = messages_in(io.BytesIO(path.read_bytes()))
    assert (schema.encoding, schema.data) == ("ros2msg", b"")
    with highlevel.AnyReader([path]) as reader:
        assert [one.msgtype for one, _, _ in reader.messages()] == ["std_msgs/msg/Empty"]


def test_rosbags_reads_the_file(tmp_path):
    highlevel = pytest.importorskip("rosbags.highlevel")
    star = Recorded("a")
    star.create_all("a")
    for number in range(5):
        star.write("a", struct.pack("<f", number))
    star.run(SECOND)
    path = Path(tmp_path / "it.mcap")
    with path.open("wb") as file:
        write_ros2(star.recording, file, XRCE.samples(_frames(star.recording), ())[0])
    with highlevel.AnyReader([path]) as reader:
        read = [(one.topic, reader.deserialize(data, one.msgtype).data) for one, _, data in reader.messages()]
    assert read == [("/speed", float(number)) for number in range(5)]
