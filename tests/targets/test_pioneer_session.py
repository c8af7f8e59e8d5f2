"""Connecting, SIPs, keeping alive, leaving: the robot asked in the bytes real clients send."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.p2os import (
    Command,
    CommandNumber,
    ConfigPacket,
    FrameDropped,
    Identification,
    Sip,
    SyncEcho,
    WatchdogExpired,
    WatchdogRevived,
    encode_command,
    vel2,
)
from targets.robots.pioneer import (
    CommandIgnored,
    CommandObeyed,
    HostBaudChanged,
    MotorsEnabled,
    NotModelled,
    PioneerRobot,
    Refusal,
    RobotSettings,
)
from tests.each import each
from tests.share import examples

SYNC0, SYNC1, SYNC2 = "FAFB03000000", "FAFB03010001", "FAFB03020002"
OPEN_1, CLOSE_1 = "FAFB06013B0100023B", "FAFB06023B0100033B"
ENABLE_1, ENABLE_0 = "FAFB06043B0100053B", "FAFB06043B0000043B"
VEL_200 = "FAFB060B3BC800D33B"
CONFIG_1, CONFIG_BARE = "FAFB06123B0100133B", "FAFB03120012"
MS = 1_000_000


# --- handshake -----------------------------------------------------------------------------------------------------


def test_handshake_step_by_step(rig) -> None:  # S01 S02 S03
    assert rig.say(SYNC0, 0.2)[0].raw == bytes.fromhex(SYNC0)
    assert rig.say(SYNC1, 0.2)[0].raw == bytes.fromhex(SYNC1)
    (answer,) = rig.say(SYNC2, 0.2)
    assert answer.packet == Identification(name="hilbench", robot_class="Pioneer", subclass="p2dx")


def test_identification_bytes(make_rig) -> None:
    rig = make_rig(RobotSettings(name="bench"))
    rig.handshake()
    assert rig.received[-1].raw.hex().upper() == "FAFB160262656E63680050696F6E656572007032647800B3A2"


def test_silence_before_a_session(rig) -> None:  # S04 S07
    assert rig.run(3.0) == []
    assert rig.say(VEL_200, 1.0) == []
    assert rig.say(SYNC0, 3.0) == rig.received
    rig.handshake()
    assert rig.run(3.0) == []


@pytest.mark.parametrize("opening", [SYNC1, OPEN_1])
def test_sips_begin_after_open(rig, opening: str) -> None:  # S05 S06
    rig.handshake()
    rig.connected = True
    assert isinstance(rig.say(opening, 0.2)[0].packet, Sip)


@pytest.mark.parametrize(
    ("noise", "wait_s"),
    [
        ("574D53320D", 0.0),  # S08: ARIA's radio modem string
        ("FAFB03000001", 0.0),  # S09: bad checksum
        ("FA", 0.0),  # S10: stray FA
        ("FAFB02", 0.0),  # S15
        ("FAFB01", 0.0),
        ("FAFB00", 0.0),
        ("FAFBFA" + "55" * 250, 0.0),  # S16: longer than any packet may be
        ("0B3BC800D33B", 0.0),
    ],
)
def test_noise_before_a_good_packet_is_skipped(rig, noise: str, wait_s: float) -> None:
    assert rig.say(noise, wait_s) == []
    assert [r.packet for r in rig.say(SYNC0, 0.1)] == [SyncEcho(number=0)]


def test_byte_by_byte_and_repeated(rig) -> None:  # S11 S12 S13
    for byte in bytes.fromhex(SYNC0):
        rig.say(bytes((byte,)), 0.02)
    rig.say(SYNC0 + SYNC0, 0.1)
    rig.say(SYNC1, 0.1)
    rig.say(SYNC0, 0.1)
    assert [r.packet.number for r in rig.received] == [0, 0, 0, 1, 0]
    rig.handshake()


def test_skipping_ahead_is_answered_and_recovers(rig) -> None:  # S14
    rig.say(SYNC0, 0.1)
    assert rig.say(SYNC2, 0.2)
    rig.handshake()
    assert isinstance(rig.received[-1].packet, Identification)


# --- the stream of SIPs --------------------------------------------------------------------------------------------


@each("cycle_ms", [100, 50])
def test_sips_come_exactly_on_the_cycle(make_rig, cycle_ms: int) -> None:  # S18
    rig = make_rig(RobotSettings(sip_cycle_ms=cycle_ms))
    rig.run(0.0371)
    rig.open()
    opened_ns = rig.now_ns
    received = rig.run(10.0)
    assert [r.at_ns for r in received] == [opened_ns + n * cycle_ms * MS for n in range(1, 10_000 // cycle_ms + 1)]
    for r in received:
        assert isinstance(r.packet, Sip)
        assert r.raw[3] == 0x32
        assert r.raw[2] == 27 + 3 * len(r.packet.sonars)


def test_a_late_bench_gets_every_sip(rig) -> None:
    rig.open()
    data = rig.robot.advance(rig.now_ns + 1_050 * MS)
    assert data.count(b"\xfa\xfb") == 10
    assert rig.robot.next_deadline_ns() > rig.now_ns + 1_050 * MS


def test_what_was_due_before_a_byte_goes_out_before_it_counts(rig) -> None:
    rig.open()
    data = rig.robot.receive(bytes.fromhex(CLOSE_1), rig.now_ns + 250 * MS)
    assert data.count(b"\xfa\xfb") == 2


def test_the_first_sip(rig) -> None:  # S19
    rig.open()
    sip = rig.next_sip()
    assert (sip.motors_enabled, sip.sonar_enabled, sip.moving) == (False, True, False)
    assert (sip.x_raw, sip.y_raw, sip.th_raw, sip.control_raw) == (0, 0, 0, 0)
    assert (sip.battery_dv, sip.timer, sip.analog, sip.digin) == (130, 5, 128, 0xFF)


def test_enable(rig) -> None:  # S21
    rig.open()
    rig.send(ENABLE_1)
    assert rig.next_sip().motors_enabled
    rig.send(ENABLE_0)
    assert not rig.next_sip().motors_enabled
    assert rig.told(MotorsEnabled) == [MotorsEnabled(enabled=True), MotorsEnabled(enabled=False)]


def test_a_sip_without_bumpers_looks_as_captured_from_a_real_robot(make_rig) -> None:
    rig = make_rig(RobotSettings(bumpers_fitted=False))
    rig.open()
    sip = rig.next_sip()
    assert (sip.stall_rear, sip.stall_front) == (0xFE, 0xFE)
    assert not sip.left_stall
    assert not sip.right_stall


# --- watchdog ------------------------------------------------------------------------------------------------------


def test_silence_stops_and_any_packet_revives(ready) -> None:  # S36 S37
    ready.say(VEL_200, 1.0)
    assert ready.sips[-1].left_raw == 200
    received = ready.run(1.0 + 200 / 300 + 0.2)
    assert len(received) == pytest.approx(18, abs=1)
    assert received[-1].packet.left_raw == 0
    assert not received[-1].packet.moving
    assert received[-1].packet.motors_enabled
    assert ready.told(WatchdogExpired)
    ready.send(SYNC0)
    ready.run(1.5)
    assert ready.sips[-1].left_raw == 200
    assert ready.told(WatchdogRevived)


def test_the_stop_comes_at_two_seconds_with_normal_deceleration(ready) -> None:
    ready.send(VEL_200)
    ready.run(1.99)
    assert ready.chassis.servo
    before = ready.robot.controller.odometer.wheel_speeds_mm_s()[0]
    assert before == pytest.approx(200.0, abs=1)
    ready.run(0.01 + 1 / 3 + 0.025)
    assert ready.robot.controller.odometer.wheel_speeds_mm_s()[0] == pytest.approx(100.0, abs=3)


def test_a_position_move_interrupted_by_the_watchdog_still_arrives(ready) -> None:
    ready.send(Command(CommandNumber.MOVE, 3000))
    ready.run(5.0)
    assert not ready.sips[-1].moving
    assert ready.chassis.x_m == pytest.approx(1.2, abs=0.01)
    for _ in range(7):
        ready.say(SYNC0, 1.0)
    assert ready.chassis.x_m == pytest.approx(3.0, abs=0.001)


def test_traffic_that_is_not_a_pulse_keeps_it_alive(ready) -> None:  # S38
    ready.say(VEL_200, 1.0)
    ready.received.clear()
    for _ in range(5):
        ready.say("FAFB061C3B01001D3B", 1.9)
    assert all(sip.left_raw == 200 for sip in ready.sips)


def test_pulse_has_no_echo(ready) -> None:  # S39
    received = ready.say(SYNC0, 0.5)
    assert [r.packet for r in received] == [r.packet for r in received if isinstance(r.packet, Sip)]
    assert len(received) == 5


# --- the end -------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("closing", [SYNC2, CLOSE_1])
def test_close_while_moving_and_reconnect(ready, closing: str) -> None:  # S40 S41
    ready.say(VEL_200, 1.0)
    ready.send(closing)
    ready.connected = False
    fired = len(ready.chassis.fired)
    assert ready.run(1.0) == []
    assert len(ready.chassis.fired) == fired
    assert [r.packet for r in ready.say(SYNC0, 0.1)] == [SyncEcho(number=0)]
    ready.open()
    sip = ready.next_sip()
    assert (sip.moving, sip.motors_enabled, sip.sonar_enabled) == (False, False, True)
    ready.run(1.0)
    assert not ready.sips[-1].moving


def test_line_down_is_a_close(ready) -> None:
    ready.say(VEL_200, 1.0)
    ready.hang_up()
    ready.connected = False
    assert ready.run(1.0) == []
    assert not ready.chassis.servo
    ready.open()
    assert not ready.next_sip().motors_enabled


def test_what_a_client_set_ends_with_its_session(ready) -> None:
    for text in ("FAFB06283B02002A3B", "FAFB062C3B03002F3B"):
        ready.send(text)
    ready.send(Command(CommandNumber.SETV, 100))
    ready.send(Command(CommandNumber.ROTKP, 77))
    ready.send(Command(CommandNumber.GETAUX, 3))
    ready.send(CLOSE_1)
    ready.open()
    ready.robot.controller.aux_ports[0].feed(b"late")
    received = ready.say(CONFIG_1, 0.35)
    (config,) = [r.packet for r in received if not isinstance(r.packet, Sip)]
    assert isinstance(config, ConfigPacket)
    assert (config.trans_vel_max_mm_s, config.rot_kp) == (600, 40)
    assert ready.robot.controller.bumpers.mode == 0


@pytest.mark.parametrize("ended", [False, True], ids=["same session", "later session"])
@pytest.mark.parametrize(
    ("ramp", "used", "wheels_mm_s", "other"),
    [
        (CommandNumber.SETA, CommandNumber.VEL, (300, 300), CommandNumber.RVEL),
        (CommandNumber.SETRA, CommandNumber.RVEL, (-300, 300), CommandNumber.VEL),
    ],
)
def test_ramps_of_before_do_not_act_later(ready, ramp, used, wheels_mm_s, other, ended: bool) -> None:
    """A gentle ramp was in use and is no more; the loop that gets the wheels back from VEL2 does not go by it."""
    ready.send(Command(ramp, -10))
    ready.say(Command(used, 0), 0.2)
    if ended:
        ready.send(CLOSE_1)
        ready.ready()
    else:
        ready.send(Command(ramp, -100))
    ready.say(vel2(*wheels_mm_s), 1.9)
    before = ready.sips[-1]
    assert before.right_raw > 250
    ready.say(Command(other, 0), 0.5)
    after = ready.sips[-1]
    stored = {CommandNumber.SETA: 300, CommandNumber.SETRA: math.radians(100) / 0.0056}
    rate_mm_s2 = stored[ramp] if ended or ramp is CommandNumber.SETRA else 100
    assert before.right_raw - after.right_raw == pytest.approx(rate_mm_s2 * 0.5, rel=0.15)


@pytest.mark.parametrize("motion", [Command(CommandNumber.VEL, 400), vel2(400, 400), vel2(-200, 200)])
@pytest.mark.parametrize("closing", [CLOSE_1, SYNC2, "hang-up"])
def test_the_wheels_are_braked_before_they_are_free(ready, motion: Command, closing: str) -> None:  # S41
    ready.say(motion, 1.9)
    if closing == "hang-up":
        ready.hang_up()
    else:
        ready.send(closing)
    assert ready.told(MotorsEnabled)[-1] == MotorsEnabled(enabled=False)
    ready.run(0.01)
    assert ready.chassis.servo
    ready.open()
    sip = ready.next_sip()
    assert (sip.moving, sip.motors_enabled) == (False, False)
    ready.run(0.1)
    assert not ready.chassis.servo


def test_the_watchdog_s_gentle_stop_does_not_outlast_a_hang_up(ready) -> None:
    ready.say(Command(CommandNumber.VEL, 400), 2.1)
    ready.hang_up()
    ready.run(0.2)
    assert max(map(abs, ready.robot.controller.odometer.wheel_speeds_mm_s())) < 0.5
    assert not ready.chassis.servo


def test_motors_switched_on_while_braking_stay_on(ready) -> None:
    ready.say(Command(CommandNumber.VEL, 400), 1.9)
    ready.send(CLOSE_1)
    ready.ready()
    ready.run(1.0)
    assert ready.sips[-1].motors_enabled
    assert ready.chassis.servo
    assert ready.say(VEL_200, 1.5)[-1].packet.left_raw == 200


def test_sonar_sequence_and_analog_port_are_as_stored_in_a_new_session(ready) -> None:
    ready.send(Command(CommandNumber.POLLING, bytes((3,))))
    ready.send(Command(CommandNumber.ADSEL, 2))
    ready.send(Command(CommandNumber.DIGOUT, -241))
    ready.send(CLOSE_1)
    ready.open()
    ready.run(0.5)
    assert {reading.number for sip in ready.sips[-5:] for reading in sip.sonars} == set(range(8))
    assert ready.sips[-1].analog_port == 5
    assert ready.sips[-1].digout == 0x0F, "outputs are latches: nobody switches them with the session"


def test_silenced_sonar_speak_in_a_new_session(ready) -> None:
    ready.send(Command(CommandNumber.POLLING, b""))
    ready.send(CLOSE_1)
    ready.open()
    ready.run(0.3)
    assert ready.sips[-1].sonars


def test_take_over_of_a_live_session(ready) -> None:
    ready.say(VEL_200, 4.0)
    assert not ready.sips[-1].moving
    assert isinstance(ready.say(SYNC0, 0.1)[0].packet, Sip)
    ready.send(CLOSE_1)
    ready.connected = False
    assert ready.run(0.2) == []
    ready.handshake()


# --- robustness ----------------------------------------------------------------------------------------------------


def test_ten_commands_in_one_write(ready) -> None:  # S50
    commands = [Command(CommandNumber.DIGOUT, 0x0100 << k | 1 << k) for k in range(7)]
    commands += [Command(CommandNumber.ADSEL, 3), Command(CommandNumber.SETV, 150), Command(CommandNumber.VEL, 500)]
    ready.send(b"".join(map(encode_command, commands)))
    ready.run(1.0)
    assert [event.command for event in ready.told(CommandObeyed)][-10:] == commands
    assert ready.sips[-1].left_raw == 150
    assert ready.sips[-1].analog_port == 3


def test_a_corrupt_command_is_not_obeyed(ready) -> None:  # S49
    ready.say("FAFB060B3B64006F3C", 1.0)
    assert not ready.sips[-1].moving


def test_unknown_and_foreign_commands_leave_the_session_alone(ready) -> None:  # S48
    for text in ("FAFB063E3B01003F3B", "FAFB06C83B0100C93B", "FAFB03400040"):
        ready.send(text)
    ready.send(Command(63, b"world"))
    ready.send(Command(200, 1))
    received = ready.run(0.5)
    assert all(isinstance(r.packet, Sip) for r in received)
    assert len(received) == 5
    assert [event.command for event in ready.told(NotModelled)] == [200, 64, 63]
    assert CommandIgnored(command=Command(62, 1), reason=Refusal.NOT_FITTED) in ready.events


@pytest.mark.parametrize("text", ["FAFB090F2B04010602691947", "FAFB0A0F2B040106026900822E"])
def test_say_with_and_without_nul(ready, text: str) -> None:  # S51
    ready.say(text, 0.2)
    assert ready.told(CommandObeyed)[-1].command == Command(CommandNumber.SAY, bytes((1, 6, 2, 0x69)))


def test_the_longest_packet_does_not_desynchronise(ready) -> None:  # S17
    body = bytes((0x0F, 0x2B, 195)) + b"\x01" * 195
    ready.send(b"\xfa\xfb" + bytes((200,)) + body + bytes((0x33, 0x8D)))
    received = ready.say(CONFIG_1, 0.2)
    assert any(isinstance(r.packet, ConfigPacket) for r in received)


def test_a_string_where_a_number_belongs_is_refused(ready) -> None:
    ready.say(VEL_200, 1.0)
    ready.say(Command(CommandNumber.VEL, b"x"), 0.5)
    assert ready.told(FrameDropped)
    assert ready.sips[-1].left_raw == 200


@given(
    bodies=st.lists(
        st.tuples(
            st.integers(0, 255).filter(lambda n: n != 2),
            st.none() | st.integers(-65535, 65535) | st.binary(max_size=20),
        ),
        max_size=40,
    )
)
@settings(max_examples=examples(60))
def test_no_command_can_break_the_robot(make_rig_globally: Callable[[], object], bodies: list) -> None:
    rig = make_rig_globally()
    rig.ready()
    for number, argument in bodies:
        rig.say(Command(number, argument), 0.03)
    rig.run(0.25)
    assert rig.sips
    assert all(-2048 <= sip.th_raw <= 2047 and sip.x_raw <= 0x7FFF for sip in rig.sips)


@pytest.fixture(scope="module")
def make_rig_globally(request: pytest.FixtureRequest) -> Callable[[], object]:
    everything = RobotSettings(
        gripper_fitted=True,
        tcm2_fitted=True,
        gyro_fitted=True,
        joystick_fitted=True,
        aux_loop_back=True,
        answers_battery_info=True,
    )
    rig_class = request.getfixturevalue("rig_class")
    return lambda: rig_class(everything)


# --- host baud -----------------------------------------------------------------------------------------------------


def test_host_baud_reverts_without_a_good_packet(ready) -> None:  # S57
    ready.send("FAFB06323B0200343B")
    assert ready.robot.host_baud == 38400
    ready.run(0.49)
    assert ready.robot.host_baud == 38400
    ready.run(0.02)
    assert ready.robot.host_baud == 9600
    changes = ready.told(HostBaudChanged)
    assert changes == [HostBaudChanged(baud=38400, reverted=False), HostBaudChanged(baud=9600, reverted=True)]


def test_host_baud_stays_once_confirmed_and_ends_with_the_session(ready) -> None:
    ready.say("FAFB06323B0200343B", 0.1)
    ready.say(SYNC0, 2.0)
    assert ready.robot.host_baud == 38400
    received = ready.say(CONFIG_1, 0.2)
    assert [r.packet.host_baud for r in received if isinstance(r.packet, ConfigPacket)] == [2]
    ready.send(CLOSE_1)
    assert ready.robot.host_baud == 9600


def test_two_equal_runs_are_equal(make_rig) -> None:
    def run() -> tuple[object, ...]:
        rig = make_rig(RobotSettings(slip_noise_mm_per_sqrt_m=1.0), seed=5)
        rig.ready()
        rig.say(Command(CommandNumber.VEL, 300), 2.0)
        rig.say(Command(CommandNumber.RVEL, 20), 1.5)
        return tuple((r.at_ns, r.raw) for r in rig.received)

    assert run() == run()


def test_another_connection_may_be_given(rig) -> None:
    robot = PioneerRobot(dataclasses.replace(rig.settings), rig.chassis, seed=1, connection=rig.robot.connection)
    assert robot.connection is rig.robot.connection
