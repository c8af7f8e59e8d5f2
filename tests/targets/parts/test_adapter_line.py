"""The adapter against the server role of the protocol: set-up, velocities, keep-alive, leave, loss, nonsense."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols.p2os import CommandNumber, Identification, ServerState
from targets.parts.p2os_adapter import (
    BytesDropped,
    CodesRead,
    P2osAdapter,
    P2osAdapterSettings,
    RobotConnected,
    RobotConnectFailed,
    RobotLeft,
    RobotLost,
    SafeStopped,
    SpeedSent,
)
from targets.parts.testing import PartBench
from tests.each import each
from tests.share import examples, few

MS = 1_000_000
VEL, RVEL, ENABLE, PULSE = CommandNumber.VEL, CommandNumber.RVEL, CommandNumber.ENABLE, CommandNumber.PULSE


def test_the_set_up(adapter, cut_frames) -> None:
    adapter.connect()
    assert adapter.told(RobotConnected) == [RobotConnected(name="bare", robot_class="Pioneer", subclass="p2dx")]
    assert cut_frames(adapter.sent_after(0))[:7] == [
        "FA FB 03 00 00 00",  # SYNC0
        "FA FB 03 01 00 01",  # SYNC1
        "FA FB 03 02 00 02",  # SYNC2
        "FA FB 03 01 00 01",  # OPEN
        "FA FB 03 00 00 00",  # PULSE
        "FA FB 03 07 00 07",  # SETO
        "FA FB 06 04 3B 01 00 05 3B",  # ENABLE 1
    ]


def test_published_frames(adapter, cut_frames) -> None:
    adapter.connect()
    wanted = {
        (3, 3): ["FA FB 06 0B 3B BB 00 C6 3B", "FA FB 06 15 3B 00 00 15 3B"],
        (-4, -4): ["FA FB 06 0B 1B FA 00 05 1B", "FA FB 06 15 3B 00 00 15 3B"],
        (0, 0): ["FA FB 06 0B 3B 00 00 0B 3B", "FA FB 06 15 3B 00 00 15 3B"],
    }
    for codes, frames in wanted.items():
        adapter.codes(*codes)
        start_ns = adapter.now_ns
        adapter.run(0.05)
        sent = [frame for frame in cut_frames(adapter.sent_after(start_ns)) if frame[9:11] in ("0B", "15")]
        assert sent == frames


def test_a_velocity_goes_out_at_changes_and_every_two_seconds_of_motion(adapter) -> None:
    adapter.connect()
    adapter.codes(3, 2)
    adapter.run(7.0)
    times_ns = adapter.robot.times_ns(VEL)
    assert len(times_ns) == 4
    assert all(2000 * MS < b - a <= 2002 * MS for a, b in itertools.pairwise(times_ns))
    assert adapter.robot.times_ns(RVEL) == times_ns
    adapter.codes(0, 0)
    adapter.run(7.0)
    assert len(adapter.robot.times_ns(VEL)) == 5


def test_a_change_below_the_limit_is_not_sent(make_adapter) -> None:
    adapter = make_adapter(change=0.05)
    adapter.connect()
    adapter.codes(1, 0)  # 31 mm/s, 21 mrad/s
    adapter.run(0.1)
    assert adapter.robot.times_ns(VEL) == []
    adapter.codes(1, 1)
    adapter.run(0.1)
    assert len(adapter.robot.times_ns(VEL)) == 1


def test_keep_alive(adapter) -> None:
    """G18: PULSE every 0.5 s, ENABLE every 0.1 s."""
    adapter.connect()
    since_ns = adapter.now_ns
    adapter.run(5.0)
    for number, period_ms in ((PULSE, 500), (ENABLE, 100)):
        times_ns = [ns for ns in adapter.robot.times_ns(number) if ns > since_ns]
        assert len(times_ns) == pytest.approx(5_000 / period_ms, rel=0.03)
        assert all(period_ms * MS < b - a <= (period_ms + 2) * MS for a, b in itertools.pairwise(times_ns))


def test_timers_of_whole_seconds(make_adapter) -> None:
    """The library divides milliseconds by 1000 in whole numbers: 0.5 s becomes 1 s, more than 2 s becomes 3."""
    adapter = make_adapter(whole_seconds=True)
    adapter.connect()
    adapter.codes(3, 3)
    adapter.run(7.0)
    for number, period_ms in ((PULSE, 1000), (VEL, 3000)):
        times_ns = adapter.robot.times_ns(number)[1:]
        assert all(period_ms * MS <= b - a <= (period_ms + 2) * MS for a, b in itertools.pairwise(times_ns))


def test_codes_before_the_session_are_sent_once_it_is_open_and_enabled(adapter) -> None:
    adapter.codes(3, 3)
    adapter.connect()
    numbers = adapter.robot.numbers()
    assert numbers.index(ENABLE) < numbers.index(VEL)
    assert adapter.told(SpeedSent)[0] == SpeedSent(speed_mm_s=187, turn_deg_s=0)


def test_not_connected_nothing_moves(adapter) -> None:
    adapter.codes(3, 3)
    adapter.run(5.0)
    assert adapter.told(CodesRead)
    assert adapter.line == []


def test_taking_leave_and_coming_back(adapter) -> None:
    adapter.connect()
    adapter.codes(3, 3)
    adapter.run(0.5)
    adapter.put("p2dx_con", False)
    adapter.run(0.5)
    assert adapter.robot.connection.state is ServerState.WAIT
    assert adapter.told(RobotLeft)
    assert adapter.robot.numbers()[-2:] == [CommandNumber.STOP, ENABLE]
    silent_from = len(adapter.line)
    adapter.run(3.0)
    assert len(adapter.line) == silent_from
    adapter.put("p2dx_con", True)
    adapter.run(3.5)
    assert len(adapter.told(RobotConnected)) == 2
    assert adapter.robot.times_ns(VEL)[-1] > adapter.now_ns - 3500 * MS


@pytest.mark.parametrize("after_s", few([0.012, 0.1, 0.35, 0.6], 2, "other moments of the set-up"))
def test_a_change_of_mind_during_the_set_up_or_the_leave(adapter, after_s) -> None:
    adapter.put("p2dx_con", True)
    adapter.run(1.0)
    for level in (False, True, False, True):
        adapter.run(after_s)
        adapter.put("p2dx_con", level)
    adapter.run(5.0)
    assert adapter.robot.connection.state is ServerState.OPEN
    assert not adapter.told(RobotConnectFailed)


def test_a_robot_that_comes_later_is_found(adapter) -> None:
    adapter.robot.mute = True
    adapter.connect()
    adapter.run(5.0)
    assert adapter.told(RobotConnectFailed)[0].reason == "no answer"
    adapter.robot.mute = False
    adapter.run(5.0)
    assert adapter.told(RobotConnected)


def test_the_published_adapter_tries_once(make_adapter) -> None:
    adapter = make_adapter(reconnect_s=None)
    adapter.robot.mute = True
    adapter.connect()
    adapter.run(5.0)
    adapter.robot.mute = False
    adapter.run(4.0)
    assert not adapter.told(RobotConnected)
    adapter.put("p2dx_con", False)
    adapter.run(0.1)
    adapter.put("p2dx_con", True)
    adapter.run(3.0)
    assert adapter.told(RobotConnected)


def test_a_robot_that_falls_silent_is_lost_and_found_again(adapter) -> None:
    adapter.connect()
    adapter.robot.mute = True
    adapter.run(9.0)
    assert adapter.told(RobotLost)[0].reason == "no SIP for too long"
    adapter.robot.mute = False
    adapter.run(8.0)
    assert len(adapter.told(RobotConnected)) == 2


def test_an_unknown_robot_is_taken_for_a_p2dx(make_adapter, bare_robot) -> None:
    adapter = make_adapter(bare_robot(Identification(name="odd", subclass="hexapod")))
    adapter.connect()
    assert adapter.told(RobotConnected)[0].subclass == "hexapod"


def test_g17_firmware_that_stands_still_is_not_noticed(adapter) -> None:
    adapter.connect()
    adapter.codes(3, 3)
    adapter.run(8.0)
    assert not adapter.told(SafeStopped)
    assert {event.speed_mm_s for event in adapter.told(SpeedSent)} == {187}


def test_g17_the_safe_profile_stops_and_goes_on_with_the_next_change(make_adapter) -> None:
    adapter = make_adapter(safe_stop_s=3.0)
    adapter.connect()
    adapter.codes(3, 3)
    start_ns = adapter.now_ns
    adapter.run(4.0)
    (stopped_ns,) = [ns for ns, event in adapter.bench.events if isinstance(event, SafeStopped)]
    assert stopped_ns - start_ns == pytest.approx(3000 * MS, abs=5 * MS)
    assert adapter.told(SpeedSent)[-1] == SpeedSent(speed_mm_s=0, turn_deg_s=0)
    adapter.codes(3, 2)
    adapter.run(0.1)
    assert adapter.told(SpeedSent)[-1].speed_mm_s == 156
    adapter.codes(0, 0)
    adapter.run(4.0)
    assert len(adapter.told(SafeStopped)) == 1


@each(("trigger_mm_s", "speed_mm_s"), [(400, 400), (500, 500)])
def test_g19_the_game_pad(make_adapter, trigger_mm_s, speed_mm_s) -> None:
    adapter = make_adapter(mode="gamepad", trigger_mm_s=trigger_mm_s)
    adapter.put("p2dx_con", True)
    adapter.codes(3, 3)
    adapter.run(2.0)
    assert adapter.line == []  # the pins do not count in this mode, and nobody pressed up
    adapter.bench.part.set({"up": 1}, adapter.now_ns)
    adapter.run(2.0)
    adapter.bench.part.set({"up": 0, "r2": 255}, adapter.now_ns)
    adapter.run(0.1)
    assert adapter.told(SpeedSent) == [SpeedSent(speed_mm_s=speed_mm_s, turn_deg_s=0)]
    adapter.bench.part.set({"r2": 0, "rx": -128}, adapter.now_ns)
    adapter.run(0.1)
    assert adapter.told(SpeedSent)[-1] == SpeedSent(speed_mm_s=0, turn_deg_s=97)
    adapter.bench.part.set({"down": 1}, adapter.now_ns)
    adapter.run(0.5)
    assert adapter.told(RobotLeft)


@given(st.lists(st.tuples(st.integers(0, 400), st.binary(max_size=60)), max_size=25))
@settings(max_examples=examples(30))
def test_nonsense_from_the_robot_never_raises(chunks) -> None:
    bench = PartBench(P2osAdapter, P2osAdapterSettings(dead_time_s=0.0))
    bench.wires["p2dx_con"].set(True, 0)
    for pause_ms, data in chunks:
        bench.run(pause_ms / 1000)
        bench.receive(data)
    bench.run(1.0)


_FRAMES = st.builds(
    lambda body: bytes((0xFA, 0xFB, len(body) + 2)) + body + _sum(body),
    st.builds(
        lambda kind, rest: bytes((kind,)) + rest,
        st.sampled_from([0, 1, 2, 0x20, 0x32, 0x33, 0x30, 0x34, 0x90, 0xFF, 0xF0]),
        st.binary(max_size=70),
    ),
)


def _sum(body: bytes) -> bytes:
    total = 0
    for index in range(0, len(body) - 1, 2):
        total = (total + (body[index] << 8 | body[index + 1])) & 0xFFFF
    if len(body) % 2:
        total ^= body[-1]
    return total.to_bytes(2, "big")


@given(st.lists(_FRAMES, max_size=20))
@settings(max_examples=examples(30))
def test_sound_frames_with_any_contents_never_raise(frames) -> None:
    bench = PartBench(P2osAdapter, P2osAdapterSettings(dead_time_s=0.0, encoder_form="wheel", dd7_8_driven=True))
    bench.wires["p2dx_con"].set(True, 0)
    bench.run(0.05)
    identity = b"\x02bare\0Pioneer\0p2dx\0"
    sip = b"\x32" + bytes(28)
    for body in (b"\x00", b"\x01", identity):
        bench.receive(bytes((0xFA, 0xFB, len(body) + 2)) + body + _sum(body))
        bench.run(0.15)
    bench.receive(bytes((0xFA, 0xFB, len(sip) + 2)) + sip + _sum(sip))
    assert bench.told(RobotConnected)
    for frame in frames:
        bench.run(0.05)
        bench.receive(frame)
    bench.run(0.5)


def test_dropped_bytes_are_told(adapter) -> None:
    adapter.connect()
    adapter.bench.receive(bytes.fromhex("FAFB0432010203"))
    adapter.run(1.0)
    assert adapter.told(BytesDropped)


def test_it_is_the_same_however_calls_are_cut() -> None:
    def run(step_s: float) -> list:
        bench = PartBench(P2osAdapter, P2osAdapterSettings())
        bench.wires["p2dx_con"].set(True, 0)
        for index in range(40):
            bench.wires["m1_comm1"].set(index % 3 == 0, index * 37 * MS)
            bench.wires["m2_comm3"].set(index % 5 == 0, index * 37 * MS)
        end_ns = 1_500 * MS
        while bench.now_ns < end_ns:
            bench.run_to(min(end_ns, bench.now_ns + round(step_s * 1e9)))
        return [bench.events, bench.sent]

    assert run(0.0003) == run(0.07) == run(5.0)
