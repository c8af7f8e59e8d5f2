"""Requested packets, sonar and user I/O, asked in bytes."""

from __future__ import annotations

import itertools

import pytest

from protocols.p2os import (
    BatteryPacket,
    Command,
    CommandNumber,
    ConfigPacket,
    EncoderPacket,
    GripperPacket,
    GyroPacket,
    IoPacket,
    JoystickPacket,
    PlaylistPacket,
    SerAuxPacket,
    Sip,
    Tcm2Packet,
)
from targets.robots.pioneer import RobotSettings

MS = 1_000_000


def count(received, kind: type) -> int:
    return sum(isinstance(r.packet, kind) for r in received)


@pytest.mark.parametrize("ask", ["FAFB06123B0100133B", "FAFB03120012"])
def test_config(ready, ask: str) -> None:  # S42
    received = ready.say(ask, 1.0)
    assert count(received, ConfigPacket) == 1
    config = next(r.packet for r in received if isinstance(r.packet, ConfigPacket))
    assert (config.robot_type, config.subtype, config.name) == ("Pioneer", "p2dx", "hilbench")
    assert (config.trans_vel_top_mm_s, config.trans_vel_max_mm_s, config.watchdog_ms) == (1600, 600, 2000)
    assert (config.trans_kp, config.trans_kv, config.trans_ki) == (40, 30, 0)
    assert config.fields == ConfigPacket.P2OS_FIELDS
    assert config.auto_baud == 0


def test_config_bytes_of_a_known_robot(make_rig) -> None:
    rig = make_rig(
        RobotSettings(
            name="bench",
            serial="BENCH001",
            rotation_acceleration_top_deg_s2=300.0,
            joystick_mm_s=500,
        )
    )
    rig.open()
    received = rig.say("FAFB03120012", 0.15)
    assert received[-1].raw.hex().upper() == (
        "FAFB592050696F6E65657200703264780042454E4348303031000068014006" + "2C01D007F40162656E636800640000000001000"
        "06E00BA40D00700C800C800F4016400640058026400640028001400000" + "02C012C0128001E00000048B9"
    )


def test_config_reflects_what_was_set(ready) -> None:
    for number, value in ((CommandNumber.SETV, 250), (CommandNumber.SETRA, -70), (CommandNumber.TRANSKI, 7)):
        ready.send(Command(number, value))
    received = ready.say(Command(CommandNumber.CONFIG), 0.15)
    config = received[-1].packet
    assert (config.trans_vel_max_mm_s, config.rot_decel_deg_s2, config.trans_ki) == (250, 70, 7)


@pytest.mark.parametrize(
    ("number", "kind"),
    [
        (CommandNumber.ENCODER, EncoderPacket),  # S43
        (CommandNumber.IOREQUEST, IoPacket),  # S44
        (CommandNumber.GRIPREQUEST, GripperPacket),
    ],
)
def test_once_stream_stop(ready, number: CommandNumber, kind: type) -> None:
    assert count(ready.say(Command(number, 1), 1.0), kind) == 1
    streamed = ready.say(Command(number, 2), 1.0)
    assert count(streamed, kind) == 10
    assert all(isinstance(r.packet, Sip) for r in streamed[::2]), "the SIP goes first"
    assert count(ready.say(Command(number, 0), 1.0), kind) == 0


def test_encoder_counts_follow_the_wheels(ready) -> None:
    ready.say(Command(CommandNumber.MOVE, 500), 1.5)
    ready.say(Command(CommandNumber.PULSE), 1.9)
    ready.say(Command(CommandNumber.PULSE), 1.0)
    ready.send(Command(CommandNumber.SETO))
    encoder = ready.say(Command(CommandNumber.ENCODER, 1), 0.15)[-1].packet
    expected = 500 / ready.settings.mm_per_turn * ready.settings.encoder_ticks_per_turn
    assert encoder.left_ticks == pytest.approx(expected, abs=20)
    assert encoder.right_ticks == pytest.approx(expected, abs=20)


def test_io_packet_and_digout(ready) -> None:  # S47
    ready.send("FAFB061E1BF1000F1B")
    received = ready.say("FAFB06283B02002A3B", 0.15)
    assert ready.sips[-1].digout == 0x0F
    assert received[-1].packet == IoPacket(digin=(0xFF,), digout=(0x0F,), analog=(512,) * 5)
    ready.robot.controller.io.digital_in = 0x30
    assert ready.next_sip().digin == 0x30


def test_analog_port_is_shown_in_the_timer_word(ready) -> None:
    ready.robot.controller.io.analog[1] = 1023
    ready.send(Command(CommandNumber.ADSEL, 2))
    sip = ready.next_sip()
    assert (sip.timer, sip.analog) == (2, 255)


def test_aux_loop_back(make_rig) -> None:  # S58
    rig = make_rig(RobotSettings(aux_loop_back=True))
    rig.ready()
    assert count(rig.say("FAFB062B3B02002D3B".replace("2D3B", "2D3B"), 0.5), SerAuxPacket) == 0
    received = rig.say("FAFB072A2B0241542C38", 0.5)
    assert [r.packet for r in received if isinstance(r.packet, SerAuxPacket)] == [SerAuxPacket(port=1, data=b"AT")]
    rig.send("FAFB072A2B78797AA2DE")
    assert count(rig.say("FAFB062B3B00002B3B", 0.2), SerAuxPacket) == 0
    assert count(rig.say("FAFB062B3B02002D3B", 0.2), SerAuxPacket) == 0


@pytest.mark.parametrize(
    ("tty", "getaux", "port"),
    [
        (CommandNumber.TTY2, CommandNumber.GETAUX, 1),
        (CommandNumber.TTY3, CommandNumber.GETAUX2, 2),
        (CommandNumber.TTY4, CommandNumber.GETAUX3, 3),
    ],
)
def test_aux_ports_are_apart(ready, tty: CommandNumber, getaux: CommandNumber, port: int) -> None:
    ready.send(Command(tty, b"hello"))
    assert ready.robot.controller.aux_ports[port - 1].take_sent() == b"hello"
    ready.robot.controller.aux_ports[port - 1].feed(b"device")
    received = ready.say(Command(getaux, 6), 0.15)
    assert received[-1].packet == SerAuxPacket(port=port, data=b"device")


# --- sonar ---------------------------------------------------------------------------------------------------------


def test_sonar_starts_by_itself_and_lists_only_new_readings(ready) -> None:
    ready.chassis.echoes = dict.fromkeys(range(8), 1.0)
    ready.run(0.15)
    ready.received.clear()
    ready.run(4.0)
    counts = [len(sip.sonars) for sip in ready.sips]
    assert set(counts) <= {2, 3}
    order = [reading.number for sip in ready.sips for reading in sip.sonars]
    assert all(b == (a + 1) % 8 for a, b in itertools.pairwise(order))
    assert len(order) == 100


def test_sonar_ranges(ready) -> None:  # S54
    ready.chassis.echoes = {0: 0.268, 5: 1.0}
    sips = [r.packet for r in ready.run(1.0)]
    ranges = {reading.number: reading.range_raw for sip in sips for reading in sip.sonars}
    assert (ranges[0], ranges[5], ranges[4]) == (1000, 3731, 32000)
    assert set(ranges) == set(range(8))


def test_sonar_off_and_on(ready) -> None:  # S45
    ready.send("FAFB061C3B00001C3B")
    sips = [r.packet for r in ready.run(0.5)]
    assert all(not sip.sonar_enabled and not sip.sonars for sip in sips)
    ready.send("FAFB061C3B01001D3B")
    sips = [r.packet for r in ready.run(0.5)]
    assert all(sip.sonar_enabled for sip in sips)
    assert sips[-1].sonars


def test_polling(ready) -> None:  # S46
    ready.run(0.3)
    ready.send(Command(CommandNumber.POLLING, bytes((1, 5))))
    sips = [r.packet for r in ready.run(1.0)]
    assert {reading.number for sip in sips for reading in sip.sonars} == {0, 4}
    ready.send("FAFB05032B00032B")
    sips = [r.packet for r in ready.run(1.0)]
    assert not any(sip.sonars for sip in sips)


# --- accessories ---------------------------------------------------------------------------------------------------


def test_without_accessories_nothing_answers(ready) -> None:
    for number in (CommandNumber.GYRO, CommandNumber.TCM2, CommandNumber.JOYINFO, CommandNumber.BATTERYINFO):
        ready.send(Command(number, 3))
    received = ready.run(0.5)
    assert count(received, Sip) == len(received)
    gripper = ready.say(Command(CommandNumber.GRIPREQUEST, 1), 0.15)[-1].packet
    assert gripper == GripperPacket(kind=0, state=0, grasp_time_raw=0)


def test_with_accessories(make_rig) -> None:
    rig = make_rig(
        RobotSettings(
            gyro_fitted=True,
            tcm2_fitted=True,
            joystick_fitted=True,
            gripper_fitted=True,
            answers_battery_info=True,
        )
    )
    rig.ready()
    assert count(rig.say(Command(CommandNumber.GYRO, 1), 0.55), GyroPacket) == 5
    assert count(rig.say(Command(CommandNumber.GYRO, 0), 0.5), GyroPacket) == 0
    assert count(rig.say(Command(CommandNumber.JOYINFO, 1), 0.5), JoystickPacket) == 1
    assert count(rig.say(Command(CommandNumber.BATTERYINFO, 1), 0.5), BatteryPacket) == 1
    assert count(rig.say(Command(CommandNumber.TCM2, 3), 0.5), Tcm2Packet) == 5
    assert count(rig.say(Command(CommandNumber.TCM2, 1), 0.5), Tcm2Packet) == 0
    rig.send(Command(CommandNumber.GRIPPER, 2))
    assert rig.next_sip().timer == 5 | 0xBE << 8


def test_gyro_sees_the_turn(make_rig) -> None:
    rig = make_rig(RobotSettings(gyro_fitted=True))
    rig.ready()
    rig.send(Command(CommandNumber.RVEL, 50))
    received = rig.say(Command(CommandNumber.GYRO, 1), 1.0)
    rates = [r.packet.readings[0].rate_raw for r in received if isinstance(r.packet, GyroPacket)]
    assert rates[-1] == 512 + 100
    assert rates[-1] > rates[0] >= 512


def test_compass_byte_turns_clockwise(make_rig) -> None:
    rig = make_rig(RobotSettings(tcm2_fitted=True))
    rig.ready()
    rig.send(Command(CommandNumber.TCM2, 1))
    assert rig.next_sip().compass_raw == 0
    rig.say(Command(CommandNumber.HEAD, -90), 1.5)
    rig.say(Command(CommandNumber.PULSE), 1.5)
    assert rig.sips[-1].compass_raw == 45


def test_playlist_of_a_robot_without_sounds(ready) -> None:
    received = ready.say(Command(CommandNumber.PLAYLIST, 0), 0.15)
    assert received[-1].packet == PlaylistPacket(text=bytes(25))


def test_pretended_battery(ready) -> None:
    ready.send(Command(CommandNumber.BATTEST, 105))
    assert ready.next_sip().battery_dv == 105
    ready.send(Command(CommandNumber.BATTEST, 0))
    assert ready.next_sip().battery_dv == 130
