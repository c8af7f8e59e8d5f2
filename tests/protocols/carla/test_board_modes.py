"""Who rules when: the mode machine and its deadlines, in every profile. Times are in ms since the stimulus."""

from __future__ import annotations

import math
from itertools import pairwise

import pytest

from protocols.carla import (
    LINK_TABLE,
    MODE_TABLE,
    PROFILES,
    STEP_TABLE,
    UNINITIALISED_FRAME,
    VECTORS,
    AgentChanged,
    BoardOptions,
    CommandRefused,
    Connection,
    ControlCommand,
    DeadlineMissed,
    LampChanged,
    LocalProtocolError,
    Mode,
    ModeAnswered,
    ModeChanged,
    ModeReported,
    ModeTrigger,
    PressIgnored,
    Refusal,
    Role,
    Step,
    Timer,
    Waited,
)
from tests.each import each

MS = 1_000_000
ALL = pytest.mark.parametrize("profile", PROFILES)
SHIPPED = pytest.mark.parametrize("profile", ["v0", "v1"])
NOT_V1 = pytest.mark.parametrize("profile", ["hardened", "v0"])


def steps(times):
    return [later - earlier for earlier, later in pairwise(times)]


# --- AUTOWARE


@ALL
def test_a_command_is_handed_on(driving, profile):
    board = driving(profile)
    assert board.last.data == VECTORS["F1"].data


@ALL
def test_one_command_for_each_status(driving, profile):
    board = driving(profile)
    start = board.now_ns
    board.run(3.0)
    frames = board.frames(start)
    assert {mode for _, mode in frames} == {1}
    assert len(frames) == pytest.approx(60, abs=2)


@ALL
def test_without_agent_manual_after_twenty_seconds(make_board, profile):
    board = make_board(profile)
    board.every("status", 0.05)
    board.run(20.5)
    assert board.frames()[0] == (20_000, 4)
    assert board.times(ModeChanged) == [20_000]
    assert board.since(0, ModeReported) == []


@SHIPPED
def test_frames_that_nobody_filled(make_board, profile):
    board = make_board(profile)
    board.every("agent", 1.0)
    board.every("status", 0.05)
    board.run(1.15)
    assert board.frames() == [*((110 * n, None) for n in range(1, 10)), (1100, 4)]
    assert board.since(0, type(board.last))[0].data == UNINITIALISED_FRAME
    assert board.counters.uninitialised == 9


def test_the_hardened_board_says_nothing_before_there_is_something_to_say(make_board):
    board = make_board()
    board.every("agent", 1.0)
    board.every("status", 0.05)
    board.run(1.15)
    assert board.frames() == [(1100, 4)]


@ALL
def test_commands_stop(driving, profile):
    board = driving(profile)
    board.every("command", None)
    board.run(0.03)
    last = board.last.data
    waits_since = board.now_ns  # a status has come at the end of the run before, or comes in 20 ms
    board.run(0.02)
    waits_since = board.now_ns
    board.run(1.2)
    frames = [(at, mode) for at, mode in board.frames(waits_since) if at > 1]
    assert [mode for _, mode in frames[:10]] == [1] * 9 + [4]
    assert set(steps([at for at, _ in frames[:10]])) == {110}
    assert 1080 <= frames[9][0] <= 1120
    sent = [event.data for event in board.since(waits_since + MS, type(board.last))][:9]
    if profile == "hardened":
        assert {data[11:26] for data in sent} == {VECTORS["F3"].data[11:26]}
        assert {data[2:6] for data in sent} == {last[2:6]}
        assert {data[7:11] for data in sent} == {bytes(4)}
        assert board.counters.stops_sent == 9
    else:
        assert set(sent) == {last}
        assert board.counters.sent_again == 9


@ALL
def test_what_is_waited_for_and_how_often_in_vain_can_be_seen(driving, profile):
    board = driving(profile)
    board.every("command", None)
    board.run(0.6)
    missed = [event.misses for event in board.since(0, DeadlineMissed) if event.what is Waited.COMMAND]
    assert board.connection.misses == {Waited.COMMAND: (missed[-1], 10), Waited.STATUS: (0, 10)}
    assert set(board.connection.deadlines) == {Timer.COMMAND}
    assert board.connection.table is STEP_TABLE
    assert board.connection.mode_table is MODE_TABLE
    board.command()
    assert board.connection.misses[Waited.COMMAND] == (0, 10)


def test_a_simulator_has_no_modes():
    simulator = Connection(Role.SIMULATOR)
    assert simulator.table is LINK_TABLE
    assert simulator.misses == {}
    with pytest.raises(LocalProtocolError):
        simulator.mode_table  # noqa: B018 - it is the asking that is wrong


@ALL
def test_any_command_begins_the_count_again(driving, profile):
    board = driving(profile)
    board.every("command", None)
    for _ in range(2):
        board.run(1.05)
        assert board.mode is Mode.AUTOWARE
        assert max(event.misses for event in board.since(0, DeadlineMissed) if event.what is Waited.COMMAND) == 9
        board.command()
    board.run(0.5)
    assert board.mode is Mode.AUTOWARE


@ALL
def test_slow_commands_are_filled_up(driving, profile):
    board = driving(profile)
    board.every("command", 0.2)
    start = board.now_ns
    board.run(3.0)
    assert board.mode is Mode.AUTOWARE
    sent = [event.data[12:16] for event in board.since(start, type(board.last))]
    fast, slow = VECTORS["F1"].data[12:16], bytes(4)
    assert sent[-6:] in ([[fast, slow] * 3, [slow, fast] * 3] if profile == "hardened" else [[fast] * 6])
    assert len(sent) == pytest.approx(30, abs=2)


@ALL
def test_statuses_stop(driving, profile):
    board = driving(profile)
    board.every("status", None)
    board.run(0.001)
    start = board.now_ns
    board.run(1.55)
    frames = board.frames(start)
    assert [mode for _, mode in frames[:10]] == [1] * 9 + [0]
    assert frames[9][0] == pytest.approx(950, abs=51)
    assert set(steps([at for at, _ in frames])) == {100}
    assert frames[-1][1] == 0
    assert board.since(start, ModeChanged)[0].trigger is ModeTrigger.STATUS_LOST
    assert board.last.data == VECTORS["F3"].data


@ALL
def test_ten_frames_of_mode_one_before_the_emergency(driving, profile):
    """Counted from the last status that was taken: ten frames that none followed."""
    board = driving(profile)
    board.run(0.0)
    board.every("status", None)
    misses = len(board.since(0, DeadlineMissed))
    board.run(2.0)
    missed = [event for event in board.since(0, DeadlineMissed) if event.what is Waited.STATUS][misses:]
    assert [event.misses for event in missed] == list(range(1, 11))


# --- EMERGENCY


@pytest.fixture
def in_emergency(driving):
    def make(profile="hardened", quirks=()):
        board = driving(profile, quirks)
        board.every("status", None)
        board.run(2.0)
        assert board.mode is Mode.EMERGENCY
        return board

    return make


@ALL
def test_a_status_ends_the_emergency_in_manual(in_emergency, profile):
    board = in_emergency(profile)
    start = board.now_ns
    board.status()
    assert board.mode is Mode.MANUAL
    assert board.frames(start)[-1] == (0, 4)
    assert board.since(start, LampChanged) == [LampChanged(mode=Mode.MANUAL)]
    board.run(0.15)
    assert board.since(start, ModeReported)[-1].mode == 4


@ALL
def test_and_a_press_leads_back(in_emergency, profile):
    board = in_emergency(profile)
    board.every("status", 0.05)
    board.run(0.5)
    board.press()
    start = board.now_ns
    board.run(1.0)
    assert board.mode is Mode.AUTOWARE
    assert [mode for _, mode in board.frames(start)][-10:] == [1] * 10


@ALL
def test_a_press_in_emergency_is_used_up(in_emergency, profile):
    board = in_emergency(profile)
    start = board.now_ns
    board.press()
    board.run(0.5)
    assert {mode for _, mode in board.frames(start)} == {0}
    assert board.since(start, PressIgnored) == [PressIgnored(reason=Refusal.EMERGENCY)]
    board.status()
    board.every("status", 0.05, phase=0.05)
    board.run(1.0)
    assert board.mode is Mode.MANUAL


@SHIPPED
def test_autoware_can_be_ordered_in_emergency(in_emergency, profile):
    board = in_emergency(profile)
    start = board.now_ns
    board.request(1)
    board.run(2.0)
    assert board.since(start, ModeAnswered) == [ModeAnswered(mode=1, success=True)]
    frames = board.frames(start)
    driven = [at for at, mode in frames if mode == 1]
    assert driven[-1] - driven[0] >= 900
    assert frames[-1][1] == 0
    assert board.times(ModeChanged, start)[1] - board.times(ModeChanged, start)[0] == 1000


@each("mode", [1, 4])
def test_nobody_orders_anything_in_the_emergency_of_the_hardened_board(in_emergency, mode):
    board = in_emergency()
    start = board.now_ns
    board.request(mode)
    board.run(1.0)
    assert board.since(start, ModeAnswered) == [ModeAnswered(mode=mode, success=False, reason=Refusal.EMERGENCY)]
    assert {mode for _, mode in board.frames(start)} == {0}


def test_a_request_that_was_granted_before_the_emergency_ends_with_it(driving):
    board = driving(seconds=2.0)
    board.every("status", None)
    board.run(0.97)
    start = board.now_ns
    board.request(4)
    board.run(0.2)
    assert board.since(start, ModeAnswered)[0].success
    assert board.mode in (Mode.MANUAL, Mode.EMERGENCY)
    board.run(2.0)
    assert board.mode is Mode.EMERGENCY


@each(("profile", "told"), [("hardened", [1, 6, 4]), ("v0", [1, 4]), ("v1", [1, 4])])
def test_what_the_driving_stack_is_told(in_emergency, profile, told):
    board = in_emergency(profile)
    assert board.connection.reported_mode == {"hardened": 6, "v0": 1, "v1": 4}[profile]
    board.status()
    board.run(0.2)
    assert board.modes_reported() == told


# --- requests and presses


@ALL
@pytest.mark.parametrize("mode", [0, 2, 3, 5, 200])
def test_other_modes_are_refused(driving, profile, mode):
    board = driving(profile)
    start = board.now_ns
    board.request(mode)
    board.run(0.5)
    assert board.since(start, ModeAnswered) == [ModeAnswered(mode=mode, success=False, reason=Refusal.UNKNOWN_MODE)]
    assert {mode for _, mode in board.frames(start)} == {1}


@ALL
def test_two_presses_within_a_second_are_one(driving, profile):
    board = driving(profile)
    board.press()
    board.run(0.5)
    board.press()
    board.run(1.0)
    assert board.mode is Mode.MANUAL
    assert board.counters.presses == 1
    board.press()
    board.run(0.5)
    assert board.mode is Mode.AUTOWARE


@ALL
@pytest.mark.parametrize(("at_ms", "seen"), [(1, False), (999, False), (1000, False), (1001, True)])
def test_the_first_second_is_blind(make_board, profile, at_ms, seen):
    board = make_board(profile)
    board.every("agent", 1.0)
    board.every("command", 0.03)
    board.every("status", 0.05)
    board.run(at_ms / 1000)
    board.press()
    board.run(0.5)
    assert board.mode is (Mode.MANUAL if seen else Mode.AUTOWARE)


@ALL
def test_a_bouncing_switch_is_one_press(driving, profile):
    board = driving(profile)
    for _ in range(10):
        board.press()
        board.run(0.002)
    board.run(1.0)
    assert board.mode is Mode.MANUAL
    assert board.counters.presses_ignored == 9


@ALL
def test_a_press_before_the_agent_comes_turns_the_first_mode_round(make_board, profile):
    board = make_board(profile)
    board.every("status", 0.05)
    board.run(5.0)
    board.press()
    board.every("agent", 1.0)
    board.run(0.2)
    assert board.mode is Mode.MANUAL


@NOT_V1
def test_autoware_can_be_ordered_in_manual(by_hand, profile):
    board = by_hand(profile)
    start = board.now_ns
    board.request(1)
    board.run(3.0)
    assert board.since(start, ModeAnswered) == [ModeAnswered(mode=1, success=True)]
    assert board.mode is Mode.AUTOWARE
    assert {mode for at, mode in board.frames(start) if at > 100} == {1}


@ALL
@pytest.mark.parametrize("order", [(1, 4), (4, 1)])
def test_of_two_requests_at_once(driving, profile, order):
    board = driving(profile)
    for mode in order:
        board.request(mode)
    board.run(0.3)
    assert board.mode is (Mode.MANUAL if profile == "hardened" else Mode.AUTOWARE)


@ALL
def test_requests_are_looked_at_before_presses(driving, profile):
    """A request for MANUAL makes it MANUAL, and the press leads on from there."""
    board = driving(profile)
    board.press()
    board.request(4)
    board.run(0.2)
    assert [event.new for event in board.since(0, ModeChanged)] == [Mode.MANUAL, Mode.AUTOWARE]


# --- MANUAL


@NOT_V1
@pytest.mark.parametrize(("rate_hz", "period_ms"), [(20, 60), (10, 100), (50, 60)])
def test_how_often_the_joystick_is_sent(by_hand, profile, rate_hz, period_ms):
    board = by_hand(profile)
    board.every("status", 1 / rate_hz)
    board.run(1.0)
    start = board.now_ns
    board.run(2.0)
    frames = board.frames(start)
    assert {mode for _, mode in frames} == {4}
    assert set(steps([at for at, _ in frames])) == {period_ms}
    reports = board.statuses(start)
    assert len(reports) == pytest.approx(len(frames), abs=1)
    assert all(report.fresh for report in reports)


@NOT_V1
def test_statuses_stop_in_manual(by_hand, profile):
    board = by_hand(profile)
    board.every("status", None)
    start = board.now_ns
    board.run(2.5)
    frames = board.frames(start)
    unanswered = next(at for at, later in pairwise(frames) if later[0] - at[0] == 160)[0]
    first_f3 = next(at for at, mode in frames if mode == 0)
    assert first_f3 - unanswered == 1600
    assert len([at for at, mode in frames if mode == 4 and at >= unanswered]) == 10
    assert set(steps([at for at, mode in frames if mode == 0])) == {100}


# --- V1


def test_the_false_emergency(by_hand):
    board = by_hand("v1")
    board.run(3.0)
    start = board.now_ns
    board.run(8.0)
    frames = board.frames(start)
    manual = [at for at, mode in frames if mode == 4]
    emergencies = [at for at, mode in frames if mode == 0]
    assert set(steps(manual)) == {160}
    assert len(emergencies) == 5
    assert set(steps(emergencies)) == {1600}
    assert set(emergencies) <= set(manual)
    reports = board.statuses(start)
    assert len({report.status for report in reports}) == 1
    assert not any(report.fresh for report in reports)
    assert board.counters.emergencies == len(board.frames()) - len([m for _, m in board.frames() if m != 0])


def test_a_lone_quirk_v1_finds_the_same(by_hand):
    board = by_hand("hardened", ["V1"])
    board.run(3.0)
    start = board.now_ns
    board.run(8.0)
    emergencies = [at for at, mode in board.frames(start) if mode == 0]
    assert set(steps(emergencies)) == {1600}


def wait_for(board, step):
    while board.connection.state is not step or board.mode is not Mode.MANUAL:
        board.run(0.005)


def test_v1_loses_the_way_to_autoware_while_it_waits(by_hand):
    board = by_hand("v1")
    wait_for(board, Step.MANUAL_STATUS)
    start = board.now_ns
    board.request(1)
    board.run(1.3)
    assert board.since(start, ModeAnswered)[0].success
    entered, left = board.times(ModeChanged, start)
    assert (entered, left - entered) == (60, 1100)
    assert board.counters.flags_eaten == 1
    assert board.modes_reported(start) == [4]
    assert {mode for _, mode in board.frames(start)} == {4}
    assert board.statuses(start)[0].fresh  # the flag that was eaten passed for a status


def test_v1_finds_it_while_it_rests(by_hand):
    board = by_hand("v1")
    wait_for(board, Step.MANUAL_PAUSE)
    start = board.now_ns
    board.request(1)
    board.run(3.0)
    assert board.mode is Mode.AUTOWARE
    assert board.counters.flags_eaten == 0
    assert {mode for at, mode in board.frames(start) if at > 100} == {1}


def test_v1_toggles_by_its_joystick(by_hand):
    board = by_hand("v1")
    board.run(1.0)
    board.press()
    board.run(3.0)
    assert board.mode is Mode.AUTOWARE
    assert board.frames()[-1][1] == 1


# --- what only the originals do, or only the hardened board


@SHIPPED
def test_the_joysticks_values_as_a_command(in_emergency, profile):
    """A command came in EMERGENCY; back in AUTOWARE what was written over it is sent."""
    board = in_emergency(profile)
    board.joystick(65535, 65535)
    board.every("status", 0.05)
    board.run(1.0)
    board.press()
    start = board.now_ns
    board.run(0.5)
    lit = board.times(LampChanged, start, lambda event: event.mode is Mode.AUTOWARE)[0]
    at, mode = next(frame for frame in board.frames(start) if frame[0] >= lit)
    assert (at, mode) == (lit, 4)


def test_the_hardened_board_begins_with_a_command(in_emergency):
    board = in_emergency()
    board.joystick(65535, 65535)
    board.every("status", 0.05)
    board.run(1.0)
    board.press()
    start = board.now_ns
    board.run(0.5)
    lit = board.times(LampChanged, start, lambda event: event.mode is Mode.AUTOWARE)[0]
    assert {mode for at, mode in board.frames(start) if at >= lit} == {1}


def test_both_fall_silent(driving):
    lost = {}
    for profile in ("hardened", "v0"):
        board = driving(profile)
        board.every("status", None)
        board.every("command", None)
        start = board.now_ns
        board.run(4.0)
        lost[profile] = next(at for at, mode in board.frames(start) if mode == 0)
    assert lost["hardened"] <= 1300
    assert lost["v0"] == pytest.approx(2750, abs=160)


@each(("profile", "seconds"), [("v0", 1.1), ("hardened", None)])
def test_a_press_without_a_driving_stack(make_board, profile, seconds):
    board = make_board(profile)
    board.every("status", 0.05)
    board.run(22.0)
    start = board.now_ns
    board.press()
    board.run(2.0)
    changes = board.times(ModeChanged, start)
    if seconds is None:
        assert changes == []
        assert board.since(start, PressIgnored) == [PressIgnored(reason=Refusal.NO_AGENT)]
    else:
        assert changes[1] - changes[0] == 1100
        assert {mode for _, mode in board.frames(start)} == {4}


@each(("profile", "heard"), [("v0", False), ("v1", False), ("hardened", True)])
def test_an_agent_that_comes_late(make_board, profile, heard):
    board = make_board(profile)
    board.every("status", 0.05)
    board.run(25.0)
    board.every("agent", 1.0)
    board.every("command", 0.03)
    board.run(0.1)
    board.request(1)
    board.run(1.0)
    assert board.connection.agent_online is heard
    assert bool(board.since(0, ModeReported)) is heard
    assert bool(board.since(0, ModeAnswered)) is heard
    assert board.mode is (Mode.AUTOWARE if heard else Mode.MANUAL)


def test_a_driving_stack_that_falls_silent_is_noticed_and_found_again(by_hand):
    board = by_hand()
    board.every("agent", None)
    board.every("command", None)
    start = board.now_ns
    board.run(3.5)
    assert board.since(start, AgentChanged) == [AgentChanged(online=False)]
    assert board.times(AgentChanged, start)[0] == pytest.approx(3000, abs=34)
    reports = len(board.since(0, ModeReported))
    board.run(1.0)
    assert len(board.since(0, ModeReported)) == reports
    board.agent()
    assert board.since(start, AgentChanged)[-1] == AgentChanged(online=True)


def test_a_driving_stack_that_leaves_ends_autoware(driving):
    board = driving()
    board.every("agent", None)
    board.every("command", None)
    board.agent(online=False)
    board.run(0.3)
    assert board.since(0, ModeChanged)[-1].trigger is ModeTrigger.AGENT_LOST


@each(
    ("command", "reason"),
    [
        (ControlCommand(speed_m_s=math.nan), Refusal.NOT_FINITE),
        (ControlCommand(jerk_m_s3=math.inf), Refusal.NOT_FINITE),
        (ControlCommand(speed_m_s=1e30), Refusal.IMPLAUSIBLE),
        (ControlCommand(steering_rad=3e38), Refusal.NOT_FINITE),
    ],
)
def test_commands_without_meaning(driving, command, reason):
    board = driving()
    board.every("command", None)
    start = board.now_ns
    board.command(command)
    board.run(1.3)
    assert board.since(start, CommandRefused) == [CommandRefused(reason=reason)]
    assert board.mode is Mode.MANUAL
    board = driving("v0")
    board.every("command", None)
    board.command(command)
    board.run(0.1)
    assert board.frames()[-1][1] == 1
    assert board.counters.commands_refused == 0


# --- misuse


def test_what_is_for_the_other_role():
    board, simulator = Connection(Role.BOARD), Connection(Role.SIMULATOR)
    for call in (simulator.press, simulator.agent, simulator.line_error, board.read_error):
        with pytest.raises(LocalProtocolError, match="that is for a"):
            call(0)
    with pytest.raises(LocalProtocolError, match="not the options of a simulator"):
        Connection(Role.SIMULATOR, BoardOptions())
    with pytest.raises(LocalProtocolError, match="needs own_mode"):
        BoardOptions(flag_clash=True)
    with pytest.raises(LocalProtocolError, match="command_deadline_s is 0, not above 0"):
        BoardOptions(command_deadline_s=0)
    with pytest.raises(LocalProtocolError, match="reading 65536"):
        board.joystick(0, 65536, 0)
    with pytest.raises(LocalProtocolError, match="does not fit"):
        board.command(ControlCommand(speed_m_s=1e39), 0)


def test_a_time_that_goes_back_counts_as_the_latest(driving):
    board = driving()
    board.connection.advance(0)
    assert board.connection.next_deadline_ns() > board.now_ns - MS
