"""Known bytes, each read and written."""

from __future__ import annotations

from protocols.p2os import (
    ArgumentForm,
    BytePacking,
    Command,
    ConfigPacket,
    EncoderPacket,
    Frame,
    FrameReader,
    GripperPacket,
    GyroPacket,
    GyroReading,
    Identification,
    IoPacket,
    JoystickPacket,
    SerAuxPacket,
    Sip,
    SonarReading,
    SyncEcho,
    SyncError,
    checksum,
    decode_command,
    decode_packet,
    digout,
    encode_command,
    encode_packet,
    vel2,
    vel2_speeds_mm_s,
)
from protocols.p2os import (
    CommandNumber as N,
)
from tests.each import each

PLAIN, NUL, RAW, TYPE_ONLY = (
    ArgumentForm.PLAIN,
    ArgumentForm.STRING_WITH_NUL,
    ArgumentForm.RAW_STRING,
    ArgumentForm.TYPE_ONLY,
)

COMMANDS = [
    (Command(N.PULSE), PLAIN, "FA FB 03 00 00 00"),
    (Command(N.OPEN), PLAIN, "FA FB 03 01 00 01"),
    (Command(N.CLOSE), PLAIN, "FA FB 03 02 00 02"),
    (Command(N.OPEN, 1), PLAIN, "FA FB 06 01 3B 01 00 02 3B"),
    (Command(N.CLOSE, 1), PLAIN, "FA FB 06 02 3B 01 00 03 3B"),
    (Command(N.ENABLE, 1), PLAIN, "FA FB 06 04 3B 01 00 05 3B"),
    (Command(N.ENABLE, 0), PLAIN, "FA FB 06 04 3B 00 00 04 3B"),
    (Command(N.SETA, 300), PLAIN, "FA FB 06 05 3B 2C 01 31 3C"),
    (Command(N.SETA, -300), PLAIN, "FA FB 06 05 1B 2C 01 31 1C"),
    (Command(N.SETV, 2200), PLAIN, "FA FB 06 06 3B 98 08 9E 43"),
    (Command(N.SETO), PLAIN, "FA FB 03 07 00 07"),
    (Command(N.SETO), TYPE_ONLY, "FA FB 04 07 3B 07 3B"),
    (Command(N.MOVE, 1000), PLAIN, "FA FB 06 08 3B E8 03 F0 3E"),
    (Command(N.MOVE, -500), PLAIN, "FA FB 06 08 1B F4 01 FC 1C"),
    (Command(N.ROTATE, 45), PLAIN, "FA FB 06 09 3B 2D 00 36 3B"),
    (Command(N.SETRV, 100), PLAIN, "FA FB 06 0A 3B 64 00 6E 3B"),
    (Command(N.SETRV, 500), PLAIN, "FA FB 06 0A 3B F4 01 FE 3C"),
    (Command(N.VEL, 200), PLAIN, "FA FB 06 0B 3B C8 00 D3 3B"),
    (Command(N.VEL, -200), PLAIN, "FA FB 06 0B 1B C8 00 D3 1B"),
    (Command(N.VEL, 0), PLAIN, "FA FB 06 0B 3B 00 00 0B 3B"),
    (Command(N.VEL, -32768), PLAIN, "FA FB 06 0B 1B 00 80 0B 9B"),
    (Command(N.HEAD, 90), PLAIN, "FA FB 06 0C 3B 5A 00 66 3B"),
    (Command(N.HEAD, -90), PLAIN, "FA FB 06 0C 1B 5A 00 66 1B"),
    (Command(N.DHEAD, -45), PLAIN, "FA FB 06 0D 1B 2D 00 3A 1B"),
    (Command(N.RVEL, 30), PLAIN, "FA FB 06 15 3B 1E 00 33 3B"),
    (Command(N.RVEL, -30), PLAIN, "FA FB 06 15 1B 1E 00 33 1B"),
    (Command(N.DCHEAD, 30), PLAIN, "FA FB 06 16 3B 1E 00 34 3B"),
    (Command(N.SETRA, 100), PLAIN, "FA FB 06 17 3B 64 00 7B 3B"),
    (Command(N.SETRA, -100), PLAIN, "FA FB 06 17 1B 64 00 7B 1B"),
    (Command(N.CONFIG, 1), PLAIN, "FA FB 06 12 3B 01 00 13 3B"),
    (Command(N.CONFIG), PLAIN, "FA FB 03 12 00 12"),
    (Command(N.ENCODER, 2), PLAIN, "FA FB 06 13 3B 02 00 15 3B"),
    (Command(N.IOREQUEST, 2), PLAIN, "FA FB 06 28 3B 02 00 2A 3B"),
    (Command(N.SONAR, 0), PLAIN, "FA FB 06 1C 3B 00 00 1C 3B"),
    (Command(N.SONAR, 1), PLAIN, "FA FB 06 1C 3B 01 00 1D 3B"),
    (Command(N.STOP), PLAIN, "FA FB 03 1D 00 1D"),
    (Command(N.E_STOP), PLAIN, "FA FB 03 37 00 37"),
    (vel2(300, -100), PLAIN, "FA FB 06 20 3B FB 0F 1B 4A"),
    (vel2(300, -100, packing=BytePacking.RAW), PLAIN, "FA FB 06 20 3B FB 0F 1B 4A"),
    (vel2(-100, -100), PLAIN, "FA FB 06 20 1B 05 04 25 1F"),
    (vel2(-100, -100, packing=BytePacking.RAW), PLAIN, "FA FB 06 20 3B FB FB 1C 36"),
    (vel2(-100, 300), PLAIN, "FA FB 06 20 1B F1 04 11 1F"),
    (vel2(100, 200), PLAIN, "FA FB 06 20 3B 0A 05 2A 40"),
    (digout(0xFF, 0x0F), PLAIN, "FA FB 06 1E 1B F1 00 0F 1B"),
    (Command(N.BUMPSTALL, 3), PLAIN, "FA FB 06 2C 3B 03 00 2F 3B"),
    (Command(N.HOSTBAUD, 2), PLAIN, "FA FB 06 32 3B 02 00 34 3B"),
    (Command(N.BATTERYINFO, 1), PLAIN, "FA FB 06 3E 3B 01 00 3F 3B"),
    (Command(N.SAY, b"\x01\x06\x02\x69"), PLAIN, "FA FB 09 0F 2B 04 01 06 02 69 19 47"),
    (Command(N.SAY, b"\x01\x06\x02\x69"), NUL, "FA FB 0A 0F 2B 04 01 06 02 69 00 82 2E"),
    (Command(N.POLLING, b"\x01\x05\x10"), PLAIN, "FA FB 08 03 2B 03 01 05 10 0B 3C"),
    (Command(N.POLLING, b""), PLAIN, "FA FB 05 03 2B 00 03 2B"),
    (Command(N.TTY2, b"AT"), PLAIN, "FA FB 07 2A 2B 02 41 54 2C 38"),
    (Command(N.TTY2, b"xyz"), RAW, "FA FB 07 2A 2B 78 79 7A A2 DE"),
    (Command(N.GETAUX, 0), PLAIN, "FA FB 06 2B 3B 00 00 2B 3B"),
    (Command(N.GETAUX, 6), PLAIN, "FA FB 06 2B 3B 06 00 31 3B"),
]

BENCH = Identification(name="bench", subclass="p2dx")
STOPPED_SIP = Sip(battery_dv=128, timer=5, digin=0xFF)
GOLDEN_SIP = Sip(
    moving=True,
    x_raw=1190,
    y_raw=32758,
    th_raw=1024,
    left_raw=200,
    right_raw=300,
    battery_dv=128,
    stall_rear=1,
    stall_front=2,
    control_raw=1024,
    flags=3,
    compass_raw=45,
    sonars=(SonarReading(number=0, range_raw=1000), SonarReading(number=5, range_raw=3731)),
    timer=5,
    analog=0x80,
    digin=0xFF,
    digout=0x0F,
)
CAPTURED_SIP = Sip(
    battery_dv=144,
    stall_rear=0xFE,
    stall_front=0xFE,
    sonars=(SonarReading(number=4, range_raw=32000), SonarReading(number=7, range_raw=32000)),
    timer=5,
    analog=0x59,
    digin=0x30,
    digout=0xF0,
)
CONFIG = ConfigPacket(
    robot_type="Pioneer",
    subtype="p2dx",
    serial="BENCH001",
    rot_vel_top_deg_s=360,
    trans_vel_top_mm_s=1600,
    rot_acc_top_deg_s2=300,
    trans_acc_top_mm_s2=2000,
    pwm_max=500,
    name="bench",
    sip_cycle_ms=100,
    front_sonar=1,
    low_battery_dv=110,
    revcount=16570,
    watchdog_ms=2000,
    stall_pwm=200,
    stall_count_ms=200,
    joy_vel_mm_s=500,
    joy_rot_vel_deg_s=100,
    rot_vel_max_deg_s=100,
    trans_vel_max_mm_s=600,
    rot_acc_deg_s2=100,
    rot_decel_deg_s2=100,
    rot_kp=40,
    rot_kv=20,
    trans_acc_mm_s2=300,
    trans_decel_mm_s2=300,
    trans_kp=40,
    trans_kv=30,
)

PACKETS = [
    (BENCH, False, "FA FB 16 02 62 65 6E 63 68 00 50 69 6F 6E 65 65 72 00 70 32 64 78 00 B3 A2"),
    (Identification(name="", subclass="p2dx"), False, "FA FB 11 02 00 50 69 6F 6E 65 65 72 00 70 32 64 78 00 6D E6"),
    (SyncEcho(number=0), False, "FA FB 03 00 00 00"),
    (SyncEcho(number=1), False, "FA FB 03 01 00 01"),
    (SyncError(), False, "FA FB 03 FF 00 FF"),
    (
        STOPPED_SIP,
        True,
        "FA FB 1B 32 00 00 00 00 00 00 00 00 00 00 80 00 00 00 00 00 00 00 00 05 00 00 FF 00 38 7F",
    ),
    (
        GOLDEN_SIP,
        True,
        "FA FB 21 33 A6 04 F6 7F 00 04 C8 00 2C 01 80 01 02 00 04 03 00 2D 02 00 E8 03 05 93 0E 05 00 80 FF 0F 0C 1D",
    ),
    (
        CAPTURED_SIP,
        True,
        "FA FB 21 32 00 00 00 00 00 00 00 00 00 00 90 FE FE 00 00 00 00 00 02 04 00 7D 07 00 7D 05 00 59 30 F0 11 B4",
    ),
    (
        CONFIG,
        True,
        (
            "FA FB 59 20 50 69 6F 6E 65 65 72 00 70 32 64 78 00 42 45 4E 43 48 30 30 31 00 00 68 01 40 06 2C 01 D0 07 "
            "F4 01 62 65 6E 63 68 00 64 00 00 00 00 01 00 00 6E 00 BA 40 D0 07 00 C8 00 C8 00 F4 01 64 00 64 00 58 02 "
            "64 00 64 00 28 00 14 00 00 00 2C 01 2C 01 28 00 1E 00 00 00 48 B9"
        ),
    ),
    (EncoderPacket(left_ticks=1000, right_ticks=-1000), True, "FA FB 0B 90 E8 03 00 00 18 FC FF FF 90 00"),
    (SerAuxPacket(data=b"\x90\x6a\x41"), True, "FA FB 06 B0 90 6A 41 1A D1"),
    (IoPacket(digin=(0xFF,), digout=(0x0F,), analog=(512, 2047)), True, "FA FB 0C F0 01 FF 01 0F 02 00 02 FF 07 FD 0D"),
    (
        GyroPacket(
            readings=(GyroReading(rate_raw=512, temperature_raw=60), GyroReading(rate_raw=520, temperature_raw=60))
        ),
        True,
        "FA FB 0A 98 02 00 02 3C 08 02 3C D6 48",
    ),
    (GripperPacket(kind=1, state=0x3D, grasp_time_raw=20), True, "FA FB 06 E0 01 3D 14 1D 15"),
    (JoystickPacket(), True, "FA FB 0B F8 00 00 00 02 00 02 00 02 FC 02"),
]


def the_frame(raw):
    (frame,) = FrameReader().receive(raw, 0)
    assert isinstance(frame, Frame)
    assert frame.raw == raw
    return frame


def test_every_command_is_written_and_read():
    for command, form, text in COMMANDS:
        raw = bytes.fromhex(text)
        assert encode_command(command, form=form) == raw, text
        read = decode_command(the_frame(raw).body)
        assert read == command, text
        assert encode_command(read, form=form) == raw, text


@each(("packet", "connected", "text"), PACKETS)
def test_packet_is_written_and_read(packet, connected, text):
    raw = bytes.fromhex(text)
    assert encode_packet(packet) == raw
    assert decode_packet(the_frame(raw).body, connected=connected) == packet


@each(
    ("body", "expected"),
    [("0B 3B C8 00", 0xD33B), ("2A 2B 78 79 7A", 0xA2DE), ("90" + "FF" * 8, 0x9003), ("", 0), ("07", 7)],
)
def test_checksum(body, expected):
    assert checksum(bytes.fromhex(body)) == expected


def test_the_longest_say_has_the_checksum_of_the_manuals_limit():
    raw = encode_command(Command(N.SAY, b"\x01" * 195))
    assert raw[2] == 200
    assert raw[-2:] == bytes.fromhex("338D")


@each("packing", BytePacking)
@each(("left", "right"), [(300, -100), (-100, -100), (-100, 300), (2540, -2540), (0, 20)])
def test_vel2_reads_the_same_in_both_packings(left, right, packing):
    raw = encode_command(vel2(left, right, packing=packing))
    assert vel2_speeds_mm_s(decode_command(the_frame(raw).body)) == (left, right)


@each(("asked", "sent"), [(19.9, 0), (-19.9, 0), (39, 20), (-39, -20), (99_999, 2540), (-99_999, -2540)])
def test_vel2_rounds_toward_zero_and_clips(asked, sent):
    assert vel2_speeds_mm_s(vel2(asked, asked)) == (sent, sent)


def test_missing_arguments_have_the_value_a_server_takes():
    assert Command(N.VEL).value == 0
    assert Command(N.CONFIG).value == Command(N.ENCODER).value == Command(N.IOREQUEST).value == 1
    assert Command(200).value == 0
    assert Command(N.SAY).text == b""
    assert Command(200).name == "#200"


@each("tail", [2, 3, 4, 10])
def test_config_that_is_cut_is_read_as_far_as_it_goes(tail):
    body = CONFIG.encode()[:-tail]
    cut = decode_packet(body)
    assert isinstance(cut, ConfigPacket)
    assert cut.fields < ConfigPacket.P2OS_FIELDS
    assert (cut.serial, cut.watchdog_ms) == ("BENCH001", 2000)
    assert cut.trans_ki == 0
    assert body.startswith(cut.encode())


def test_config_cut_behind_the_watchdog():
    body = CONFIG.encode()
    cut = decode_packet(body[: body.index(bytes.fromhex("D00700C800")) + 2])
    assert isinstance(cut, ConfigPacket)
    assert cut.watchdog_ms == 2000
    assert (cut.trans_vel_top_mm_s, cut.trans_vel_max_mm_s) == (1600, 0)
