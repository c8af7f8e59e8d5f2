"""Server packets: what is written is read again, and any body is read or refused."""

from __future__ import annotations

import dataclasses

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.p2os import (
    ArmInfoPacket,
    ArmJoint,
    ArmStatusPacket,
    BatteryPacket,
    BatteryReading,
    ClientOptions,
    ConfigPacket,
    ControllerReset,
    EncoderPacket,
    Frame,
    FrameReader,
    GripperPacket,
    GyroPacket,
    GyroReading,
    Identification,
    IoPacket,
    JoystickPacket,
    LateSipFields,
    LocalProtocolError,
    PlaylistPacket,
    RemoteProtocolError,
    SerAuxPacket,
    Sip,
    SonarReading,
    SyncEcho,
    SyncError,
    Tcm2Packet,
    UnknownPacket,
    decode_packet,
    encode_packet,
)
from tests.each import each
from tests.share import examples


def unsigned(size=1):
    return st.integers(0, 256**size - 1)


def signed(size=1):
    return st.integers(-(256**size) // 2, 256**size // 2 - 1)


def tuples(strategy, size):
    return st.lists(strategy, max_size=size).map(tuple)


u8, u16, s8, s16 = unsigned(), unsigned(2), signed(), signed(2)
names = st.text(st.characters(min_codepoint=1, max_codepoint=255), max_size=19)
readings = tuples(st.builds(SonarReading, number=u8, range_raw=u16), 16)

SIPS = st.builds(
    Sip,
    moving=st.booleans(),
    x_raw=u16,
    y_raw=u16,
    th_raw=s16,
    left_raw=s16,
    right_raw=s16,
    battery_dv=u8,
    stall_rear=u8,
    stall_front=u8,
    control_raw=s16,
    flags=u16,
    compass_raw=u8,
    sonars=readings,
    timer=u16,
    analog=u8,
    digin=u8,
    digout=u8,
    tail=st.binary(max_size=20),
)


def config_strategy():
    """Configurations of any length; fields beyond it keep their defaults, as a reader sees them."""
    fields = [field for field in dataclasses.fields(ConfigPacket) if field.metadata]

    def value(field):
        if not field.metadata["size"]:
            return names
        return (signed if field.metadata["signed"] else unsigned)(field.metadata["size"])

    def config(count):
        return st.builds(ConfigPacket, fields=st.just(count), **{field.name: value(field) for field in fields[:count]})

    return st.one_of(*(config(count) for count in (0, 1, 10, 20, 36, 42, 67)))


bytes5 = st.builds(
    BatteryReading,
    flags=st.tuples(u8, u8, u8),
    relative_percent=u8,
    absolute_percent=u8,
    more=st.just(b""),
)
SESSION_PACKETS = {
    Sip: SIPS,
    ConfigPacket: config_strategy(),
    EncoderPacket: st.builds(EncoderPacket, left_ticks=signed(4), right_ticks=signed(4)),
    IoPacket: st.builds(IoPacket, digin=tuples(u8, 5), digout=tuples(u8, 5), analog=tuples(u16, 8)),
    SerAuxPacket: st.builds(SerAuxPacket, port=st.integers(1, 3), data=st.binary(max_size=190)),
    GyroPacket: st.builds(GyroPacket, readings=tuples(st.builds(GyroReading, rate_raw=u16, temperature_raw=u8), 20)),
    GripperPacket: st.builds(GripperPacket, kind=u8, state=u8, grasp_time_raw=u8),
    JoystickPacket: st.builds(JoystickPacket, button1=u8, button2=u8, x_raw=u16, y_raw=u16, throttle_raw=u16),
    Tcm2Packet: st.builds(
        Tcm2Packet,
        **dict.fromkeys(("heading_ddeg", "pitch_ddeg", "roll_ddeg", "magnetic_x_cut", "magnetic_y_cut"), s16),
        **dict.fromkeys(("magnetic_z_cut", "temperature_dc", "error", "calibration_m_raw"), s16),
        calibration_h=s8,
        calibration_v=s8,
    ),
    ArmStatusPacket: st.builds(ArmStatusPacket, status=u8, moving=u8, positions_raw=st.tuples(u8, u8, u8, u8, u8, u8)),
    ArmInfoPacket: st.builds(
        ArmInfoPacket,
        version=names,
        joints=tuples(
            st.builds(ArmJoint, speed=u8, home=u8, minimum=u8, centre=u8, maximum=u8, ticks_per_90_deg=u8), 6
        ),
    ),
    BatteryPacket: st.builds(BatteryPacket, batteries=tuples(bytes5, 4)),
    PlaylistPacket: st.builds(PlaylistPacket, text=st.binary(max_size=30)),
    ControllerReset: st.builds(ControllerReset, code=st.sampled_from((0xFF, 0xFE))),
}
HANDSHAKE_PACKETS = {
    SyncEcho: st.builds(SyncEcho, number=st.sampled_from((0, 1))),
    SyncError: st.just(SyncError()),
    Identification: st.builds(Identification, name=names, robot_class=names, subclass=names),
}


@each("kind", SESSION_PACKETS)
def test_round_trip_in_session(kind):
    @settings(max_examples=examples(60))
    @given(SESSION_PACKETS[kind])
    def check(packet):
        assert decode_packet(packet.encode()) == packet

    check()


@each("kind", HANDSHAKE_PACKETS)
def test_round_trip_before_the_session(kind):
    @settings(max_examples=examples(60))
    @given(HANDSHAKE_PACKETS[kind])
    def check(packet):
        assert decode_packet(packet.encode(), connected=False) == packet

    check()


KNOWN_TYPES = (0, 1, 2, 0x20, 0x30, 0x32, 0x33, 0x90, 0x98, 0xA0, 0xA1, 0xB0, 0xB8, 0xC0, 0xC8, 0xD0, 0xE0, 0xF0, 0xF8)
any_body = st.one_of(
    st.binary(min_size=1, max_size=205),
    st.builds(lambda kind, rest: bytes((kind,)) + rest, st.sampled_from((*KNOWN_TYPES, 0xFA, 0xFE, 0xFF)), st.binary()),
)


@settings(max_examples=examples(500))
@given(any_body, st.booleans(), st.booleans())
def test_any_body_is_read_or_refused(body, connected, wide_status):
    try:
        packet = decode_packet(body, connected=connected, wide_status=wide_status)
    except RemoteProtocolError:
        return
    again = packet.encode()
    assert decode_packet(again, connected=connected, wide_status=wide_status) == packet


@each("kind", {**SESSION_PACKETS, **HANDSHAKE_PACKETS})
def test_every_cut_body_is_read_or_refused(kind):
    @settings(max_examples=examples(15))
    @given((SESSION_PACKETS | HANDSHAKE_PACKETS)[kind], st.data())
    def check(packet, data):
        body = packet.encode()
        cut = body[: data.draw(st.integers(1, len(body)))]
        try:
            decode_packet(cut, connected=kind in SESSION_PACKETS)
        except RemoteProtocolError:
            assert len(cut) < len(body)

    check()


def test_the_same_bytes_mean_different_things_by_state():
    for body, before, inside in (
        (b"\x00", SyncEcho(number=0), UnknownPacket(packet_type=0)),
        (b"\x01", SyncEcho(number=1), UnknownPacket(packet_type=1)),
        (b"\xff", SyncError(), ControllerReset(code=0xFF)),
        (b"\xfe", UnknownPacket(packet_type=0xFE), ControllerReset(code=0xFE)),
    ):
        assert decode_packet(body, connected=False) == before
        assert decode_packet(body, connected=True) == inside


@each("body", [b"", b"\x02", b"\x02abc", b"\x02a\0b\0", b"\x02a\0b\0c"])
def test_identification_without_its_strings(body):
    with pytest.raises(RemoteProtocolError):
        decode_packet(body, connected=False)


def test_sip_whose_count_reaches_past_its_end():
    body = bytearray(Sip(sonars=(SonarReading(number=1, range_raw=2),)).encode())
    body[19] = 2
    with pytest.raises(RemoteProtocolError, match="sonar count"):
        Sip.decode(bytes(body))
    body[19] = 255
    with pytest.raises(RemoteProtocolError):
        Sip.decode(bytes(body))


@each("status", [0x30, 0x31, 0x34])
def test_further_status_bytes_only_where_asked_for(status):
    body = bytes((status,)) + Sip(x_raw=7).encode()[1:]
    assert decode_packet(body) == UnknownPacket(packet_type=status, payload=body[1:])
    assert decode_packet(body, wide_status=True) == Sip(moving=bool(status & 1), x_raw=7)


tails = st.builds(
    LateSipFields,
    battery_dv=u16,
    charge_state=u8,
    rotation_ddeg_s=s16,
    fault_flags=u16,
    lateral_mm_s=s16,
    temperature_c=s8,
    charge_percent=s8,
    time_us=unsigned(4),
    flags3=unsigned(4),
)


@given(tails, st.integers(0, 19))
def test_late_firmware_tail_is_read_as_far_as_it_goes(tail, size):
    data = tail.encode()
    assert len(data) == 19
    cut = LateSipFields.decode(data[:size])
    whole = dataclasses.asdict(tail)
    read = {name: value for name, value in dataclasses.asdict(cut).items() if value is not None}
    assert read.items() <= whole.items()
    assert data.startswith(cut.encode())
    assert len(cut.encode()) > size - 4
    assert LateSipFields.decode(data) == tail


def test_stall_bumper_and_flag_bits():
    sip = Sip(stall_rear=0b0000_0101, stall_front=0b0010_0010, flags=0b10_0011, timer=0x2A05)
    assert (sip.left_stall, sip.right_stall) == (True, False)
    assert (sip.rear_bumpers, sip.front_bumpers) == (0b10, 0b1_0001)
    assert (sip.motors_enabled, sip.sonar_enabled, sip.stop_button) == (True, True, True)
    assert (sip.analog_port, sip.gripper_state) == (5, 0x2A)
    other = Sip(stall_rear=0b10, stall_front=0b1)
    assert (other.left_stall, other.right_stall) == (False, True)
    assert not (other.motors_enabled)
    assert not (other.sonar_enabled)
    assert not (other.stop_button)


def test_playlist_of_a_robot_without_sounds():
    assert PlaylistPacket().encode() == b"\xd0" + bytes(25)
    assert PlaylistPacket().name == ""
    assert PlaylistPacket(text=b"bell\0\0").name == "bell"


def test_battery_record_longer_than_ours_keeps_the_rest():
    packet = BatteryPacket(batteries=(BatteryReading(relative_percent=80, more=b"xy"), BatteryReading(more=b"zz")))
    assert BatteryPacket.decode(packet.encode()) == packet


@each(
    "packet",
    [
        Sip(x_raw=65536),
        Sip(x_raw=-1),
        Sip(th_raw=40000),
        Sip(sonars=(SonarReading(number=256, range_raw=0),)),
        EncoderPacket(left_ticks=2**31, right_ticks=0),
        SerAuxPacket(port=4, data=b""),
        SerAuxPacket(port=1, data=bytes(253)),
        ArmStatusPacket(positions_raw=(1, 2)),
        BatteryPacket(batteries=(BatteryReading(more=b"x"), BatteryReading())),
        ControllerReset(code=3),
        SyncEcho(number=3),
        Identification(name="a\0b", subclass="p2dx"),
        Identification(name="\u20ac", subclass="p2dx"),
        ConfigPacket(fields=68),
        ConfigPacket(sip_cycle_ms=256),
        UnknownPacket(packet_type=0x61, payload=bytes(253)),
    ],
)
def test_what_cannot_be_sent(packet):
    with pytest.raises(LocalProtocolError):
        encode_packet(packet)


def test_a_full_aux_packet_reaches_a_client_as_it_is_by_default():
    frame = encode_packet(SerAuxPacket(port=1, data=bytes(200)))
    reader = FrameReader(max_count=ClientOptions().max_count)
    (item,) = reader.receive(frame, 0)
    assert isinstance(item, Frame)
    assert decode_packet(item.body) == SerAuxPacket(port=1, data=bytes(200))
