"""The simulator's side: what it hands on to the car, what it sends, and what a silent line does to it."""

from __future__ import annotations

import struct
from dataclasses import replace

import pytest

from protocols.carla import (
    PROFILES,
    VECTORS,
    AckermannCommand,
    Commanded,
    CommandFrame,
    DropReason,
    FrameDropped,
    LinkSilent,
    LinkState,
    LocalProtocolError,
    ManualCommand,
    Mode,
    PollOptions,
    SimulatorOptions,
    StatusFrame,
    decode_status,
    encode_command,
)
from tests.each import each

MS = 1_000_000
F1, F2, F3 = (VECTORS[name].data for name in ("F1", "F2", "F3"))
P = encode_command(AckermannCommand(steering_rad=0.25, speed_m_s=2.0).frame())
Q = encode_command(CommandFrame(steering=-0.75, speed=0.5, mode=Mode.MANUAL))
ALL = pytest.mark.parametrize("profile", PROFILES)
SHIPPED = pytest.mark.parametrize("profile", ["v0", "v1"])


@pytest.fixture
def hears(make_simulator):
    """Has a simulator hear something in one go, and gives it 45 ms for its reads."""

    def make(profile, *pieces, quirks=()):
        simulator = make_simulator(profile, quirks)
        for piece in pieces:
            simulator.hear(piece)
            simulator.run(0.045)
        return simulator

    return make


def rounded(command):
    return type(command)(**{name: round(getattr(command, name), 6) for name in command.__dataclass_fields__})


F1_SAYS = AckermannCommand(
    steering_rad=0.6, steering_rate_rad_s=0.12, speed_m_s=5.0, acceleration_m_s2=1.0, jerk_m_s3=0.2
)


@ALL
@pytest.mark.parametrize(
    ("data", "says"),
    [
        (F1, F1_SAYS),
        (F1[:29], F1_SAYS),
        (F2, ManualCommand(steer=-0.5, throttle=0.75)),
        (F3, AckermannCommand()),
    ],
)
def test_commands_are_handed_on_once(hears, profile, data, says):
    simulator = hears(profile, data)
    simulator.run(0.3)
    assert [rounded(command) for command in simulator.commands] == [says]


@ALL
def test_an_unknown_mode_is_not(hears, profile):
    simulator = hears(profile, F1[:27] + b"\x07$\0")
    assert simulator.commands == []
    assert simulator.counters.unknown_modes == 1


@SHIPPED
def test_torn_frames(hears, profile):
    simulator = hears(profile, P, Q[:10], Q[10:])
    assert simulator.commands[0] == AckermannCommand(steering_rad=0.25, speed_m_s=2.0)
    assert simulator.commands[1] == AckermannCommand(steering_rad=-0.75, speed_m_s=2.0)
    assert ManualCommand(steer=-0.75, throttle=0.5) not in simulator.commands


def test_a_frame_in_pieces_is_one_frame(hears):
    simulator = hears("hardened", P, Q[:10], Q[10:])
    assert simulator.commands == [
        AckermannCommand(steering_rad=0.25, speed_m_s=2.0),
        ManualCommand(steer=-0.75, throttle=0.5),
    ]


@each(("profile", "commands"), [("v0", 0), ("v1", 0), ("hardened", 1)])
def test_a_hash_too_many(hears, profile, commands):
    assert len(hears(profile, b"#" + F1[:29]).commands) == commands


@each(("profile", "commands"), [("v0", 0), ("v1", 0), ("hardened", 40)])
def test_a_shifted_stream(make_simulator, profile, commands):
    simulator = make_simulator(profile)
    simulator.hear(b"\x55" * 7 + F1 * 40)
    simulator.run(1.0)
    assert len([event for event in simulator.of(Commanded) if event.frame]) == commands


def test_forty_frames_of_29_bytes_give_three(make_simulator):
    """Each read of 30 takes a byte of the next frame; it falls on an edge now and then."""
    simulator = make_simulator("v0")
    simulator.hear(F1[:29] * 40)
    simulator.run(1.0)
    assert len(simulator.commands) == 3
    hardened = make_simulator()
    hardened.hear(F1[:29] * 40)
    assert len(hardened.commands) == 40


@SHIPPED
def test_missing_fields_keep_their_old_values(hears, profile):
    simulator = hears(profile, F1, b"#M\x04$")
    assert rounded(simulator.commands[1]) == ManualCommand(steer=0.6, throttle=5.0, brake=1.0)
    assert rounded(hears(profile, b"#M\x04$").commands[0]) == ManualCommand()


@SHIPPED
def test_an_empty_frame_commands(hears, profile):
    assert hears(profile, b"#$").commands == [AckermannCommand()]


@each("data", [b"#M\x04$", b"#$", F1[:6] + b"S" + F1[7:], b"#" + F1[6:11] + F1[1:6] + F1[11:]])
def test_the_hardened_side_wants_each_field_once(hears, data):
    simulator = hears("hardened", F1, data)
    assert len(simulator.commands) == 1
    assert len(simulator.of(FrameDropped)) >= 1


@SHIPPED
def test_a_port_that_is_gone_goes_on_commanding(hears, profile):
    simulator = hears(profile, F1)
    simulator.read_error()
    simulator.run(1.0)
    assert len(simulator.commands) == pytest.approx(52, abs=1)
    assert set(map(rounded, simulator.commands)) == {F1_SAYS}
    assert simulator.counters.read_errors == len(simulator.commands) - 1
    simulator.read_error(failing=False)
    simulator.run(1.0)
    assert simulator.counters.read_errors == len(simulator.commands) - 1


def test_a_port_that_is_gone_stops_the_car(hears):
    simulator = hears("hardened", F1)
    simulator.read_error()
    simulator.run(1.0)
    assert [rounded(command) for command in simulator.commands] == [F1_SAYS, AckermannCommand()]
    assert len(simulator.of(LinkSilent)) == simulator.counters.read_errors == 1


@each(("profile", "speed"), [("v0", 0.539216), ("v1", 0.539216), ("hardened", 0.550980)])
def test_a_carriage_return(hears, profile, speed):
    simulator = hears(profile, F1[:12] + b"\r\r\r\x3f" + F1[16:])
    assert simulator.commands[0].speed_m_s == pytest.approx(speed, abs=1e-6)


def test_a_lone_carriage_return_quirk(hears):
    simulator = hears("hardened", F1[:12] + b"\r\r\r\x3f" + F1[16:], quirks=["H4"])
    assert simulator.commands[0].speed_m_s == pytest.approx(0.539216, abs=1e-6)


@each("bits", [b"\0\0\xc0\x7f", b"\0\0\x80\x7f", struct.pack("<f", 1e30)])
def test_values_without_meaning(hears, bits):
    data = F1[:12] + bits + F1[16:]
    assert struct.pack("<f", hears("v0", data).commands[0].speed_m_s) == bits
    simulator = hears("hardened", data)
    assert simulator.commands == []
    assert simulator.counters.not_finite + simulator.counters.implausible == 1


def test_manual_values_beyond_their_range(hears):
    data = encode_command(CommandFrame(steering=2.0, speed=1.5, acceleration=-1.0, mode=4))
    assert hears("v0", data).commands == [ManualCommand(steer=2.0, throttle=1.5, brake=-1.0)]
    simulator = hears("hardened", data)
    assert simulator.commands == [ManualCommand(steer=1.0, throttle=1.0, brake=0.0)]
    assert simulator.counters.clamped == 1
    wild = encode_command(CommandFrame(steering=-11.0, mode=4))
    assert hears("hardened", wild).of(FrameDropped)[0].reason is DropReason.IMPLAUSIBLE
    limits = encode_command(CommandFrame(acceleration=101.0, mode=1))
    assert hears("hardened", limits).of(FrameDropped)[0].reason is DropReason.IMPLAUSIBLE


@SHIPPED
def test_a_silent_board_drives_on(hears, profile):
    simulator = hears(profile, F1)
    simulator.run(3.0)
    assert len(simulator.commands) == 1


def test_a_silent_board_stops_the_car_once_and_is_obeyed_again(hears):
    simulator = hears("hardened", F1)
    simulator.run(3.0)
    assert [event.frame is None for event in simulator.of(Commanded)] == [False, True]
    stopped = next(t for t, event in simulator.seen if isinstance(event, LinkSilent))
    assert stopped == 500 * MS
    assert simulator.connection.state is LinkState.SILENT
    simulator.hear(F1)
    assert rounded(simulator.commands[-1]) == F1_SAYS
    assert simulator.connection.state is LinkState.LINKED


def test_a_board_that_never_spoke_is_not_missed(make_simulator):
    simulator = make_simulator().run(5.0)
    assert simulator.seen == []


# --- statuses


@ALL
def test_a_status_waits_for_both_reports_and_takes_the_newest(make_simulator, profile):
    simulator = make_simulator(profile)
    simulator.velocity(1.0)
    simulator.velocity(8.3333, -0.05, 0.1)
    assert simulator.sent == []
    simulator.steering(-0.2)
    simulator.run(0.6)
    assert [data for _, data in simulator.sent] == [VECTORS["F5"].data]
    simulator.steering(-0.2)
    simulator.steering(0.3)
    simulator.run(0.6)
    assert len(simulator.sent) == 1
    simulator.velocity()
    simulator.run(0.6)
    assert decode_status(simulator.sent[1][1]) == StatusFrame(steering_rad=pytest.approx(0.3))
    assert simulator.counters.frames_out == 2


def report_at_20_hz(simulator, seconds):
    for _ in range(round(seconds * 20)):
        simulator.velocity()
        simulator.steering()
        simulator.run(0.05)


def test_a_quiet_board_holds_the_statuses_up(make_simulator):
    simulator = make_simulator("v0")
    simulator.run(0.01)
    report_at_20_hz(simulator, 2.0)
    times = [t // MS for t, _ in simulator.sent]
    assert times == [500, 1000, 1500, 2000]
    assert simulator.counters.sends_delayed >= 30
    assert simulator.counters.blocks >= 4


def test_a_quiet_board_holds_nothing_up_where_reads_do_not_wait(make_simulator):
    for quirks in ((), ["H4"]):
        simulator = make_simulator("hardened", quirks)
        report_at_20_hz(simulator, 60.0)
        assert len(simulator.sent) == 1200
        assert {len(data) for _, data in simulator.sent} == {22}
        assert [t % (50 * MS) for t, _ in simulator.sent] == [0] * 1200


def test_sending_forgets_the_mode(hears):
    for profile, says in (("v0", AckermannCommand(steering_rad=-0.5, speed_m_s=0.75)), ("hardened", None)):
        simulator = hears(profile, F2)
        simulator.hear(F2[:1])  # wakes a read
        simulator.velocity()
        simulator.steering()
        simulator.run(0.6)
        simulator.hear(b"#$")
        simulator.run(0.1)
        last = simulator.commands[-1]
        assert last == (says if says is not None else AckermannCommand())
        assert (simulator.of(Commanded)[-1].frame is None) is (says is None)


# --- the poll


def test_frames_at_100_hz_pile_up(make_simulator):
    late = {}
    for profile in ("v0", "hardened"):
        simulator = make_simulator(profile)
        simulator.run(0.005)
        for n in range(200):
            simulator.hear(encode_command(AckermannCommand(speed_m_s=float(n % 100)).frame()))
            simulator.run(0.01)
        late[profile] = 200 - len(simulator.commands)
    assert late["hardened"] == 0
    assert late["v0"] == pytest.approx(100, abs=3)


def test_a_full_buffer_loses_bytes(make_simulator):
    simulator = make_simulator("v0")
    simulator.hear(F1 * 200)
    simulator.run(0.002)
    simulator.hear(F1 * 10)
    simulator.run(0.002)
    assert simulator.of(FrameDropped)[0].reason is DropReason.OVERRUN
    assert simulator.counters.overruns == 2
    assert simulator.connection.held <= 4096


def test_a_read_that_does_not_wait(make_simulator):
    options = PROFILES["v0"].simulator
    options = type(options)(reader=options.reader, silence_s=None)
    simulator = make_simulator(options=options)
    simulator.hear(F1)
    simulator.run(1.0)
    assert len(simulator.commands) == 1
    assert simulator.counters.blocks == 0


# --- torn frames (H3) and waiting (H5), each by itself


def in_two_pieces(simulator):
    simulator.run(0.01)
    for piece in (P, Q[:10], Q[10:]):
        simulator.hear(piece)
        simulator.run(0.025)
    return [rounded(command) for command in simulator.commands]


P_SAYS = AckermannCommand(steering_rad=0.25, speed_m_s=2.0)
Q_SAYS = ManualCommand(steer=-0.75, throttle=0.5)
WAITING = [500, 1000, 1500, 2000]


@each(
    ("quirks", "says", "times"),
    [
        ([], [P_SAYS, Q_SAYS], [10 + 50 * n for n in range(40)]),
        (["H3"], [P_SAYS, replace(P_SAYS, steering_rad=-0.75)], [10 + 50 * n for n in range(40)]),
        (["H5"], [P_SAYS, Q_SAYS], WAITING),
        (["H3", "H5"], [P_SAYS, replace(P_SAYS, steering_rad=-0.75)], WAITING),
        (["H5", "H3"], [P_SAYS, replace(P_SAYS, steering_rad=-0.75)], WAITING),
    ],
)
def test_torn_frames_and_waiting_are_two_things(make_simulator, quirks, says, times):
    assert in_two_pieces(make_simulator("hardened", quirks))[:2] == says
    quiet = make_simulator("hardened", quirks)
    quiet.run(0.01)
    report_at_20_hz(quiet, 2.0)
    assert [t // MS for t, _ in quiet.sent] == times


def test_waiting_alone_loses_nothing(make_simulator):
    simulator = make_simulator("hardened", ["H5"])
    for n in range(200):
        simulator.hear(encode_command(AckermannCommand(speed_m_s=n / 2).frame())[:29])
        simulator.run(0.01)
    simulator.run(0.03)
    assert [command.speed_m_s for command in simulator.commands] == [n / 2 for n in range(200)]
    simulator.hear(F1[:10])
    assert simulator.connection.held == 10
    simulator.run(0.2)
    assert simulator.connection.held == 0
    assert simulator.of(FrameDropped)[-1].reason is DropReason.TIMED_OUT
    simulator.read_error(True)
    simulator.run(0.1)
    assert len(simulator.commands) == 200
    assert simulator.counters.read_errors


@each("field", ["period_s", "bytes_each", "gather_s"])
def test_figures_that_cannot_be(field):
    with pytest.raises(LocalProtocolError, match=f"{field} is 0, not above 0"):
        PollOptions(**{field: 0})


def test_a_wait_that_cannot_be():
    with pytest.raises(LocalProtocolError, match="idle_block_s is 0, not above 0"):
        SimulatorOptions(idle_block_s=0)


def test_reports_that_do_not_fit_are_the_callers_mistake(make_simulator):
    simulator = make_simulator()
    with pytest.raises(LocalProtocolError, match="does not fit"):
        simulator.velocity(1e39)
    with pytest.raises(LocalProtocolError, match="does not fit"):
        simulator.steering(-1e39)
    simulator.velocity()
    simulator.steering()
    assert len(simulator.sent) == 1
