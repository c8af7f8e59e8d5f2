"""How the adapter reads its pins: majority of five, the connection window, its dead time, its reset line."""

from __future__ import annotations

import pytest

from targets.parts.p2os_adapter import (
    AdapterHeld,
    AdapterStarted,
    CodesRead,
    ConnectionPin,
    P2osAdapterSettings,
    RobotConnected,
)
from targets.parts.p2os_adapter.sampling import ConnectionSampler, read_burst
from targets.parts.testing import Wire
from tests.each import each

MS = 1_000_000
US = 1_000


@each(("high_reads", "level"), [(0, False), (2, False), (3, True), (5, True)])
@each("early", [False, True])
def test_a_burst_has_a_majority(high_reads, level, early, pulse) -> None:
    wire, end_ns, spacing_ns = Wire(), 5 * MS, 2 * US
    reads_ns = [end_ns - number * spacing_ns for number in range(5)]
    chosen = sorted(reads_ns)[:high_reads] if early else reads_ns[:high_reads]
    if chosen:
        pulse(wire, min(chosen) - 10, max(chosen) + 10)
    assert read_burst([wire], end_ns, reads=5, spacing_ns=spacing_ns) == (level,)


@pytest.mark.parametrize(("high_reads", "code"), [(2, 0), (3, 1)])
def test_majority_at_the_terminals(adapter, high_reads, code, pulse) -> None:
    """Bursts fall on every second pass: at 0, 2, 4 ms; each is decoded a pass later."""
    burst_ns = 200 * MS
    pulse(adapter.wire("m1_comm1"), burst_ns - (2 * high_reads - 1) * US, burst_ns + 10)
    adapter.run(0.3)
    expected = [CodesRead(left=code, right=0, speed_m_s=0.031, turn_rad_s=-0.021)] if code else []
    assert adapter.told(CodesRead)[:1] == expected


@each("order", ["lsb-first", "msb-first"])
def test_bit_order_of_the_motor_words(make_adapter, order) -> None:
    adapter = make_adapter(motor_order=order)
    adapter.codes(1, 1)
    adapter.run(0.1)
    (read,) = adapter.told(CodesRead)
    assert (read.left, read.right) == ((1, 1) if order == "lsb-first" else (-4, -4))


def test_a_code_is_seen_within_three_passes(adapter) -> None:
    adapter.run(0.0505)
    adapter.codes(3, -4)
    adapter.run(0.004)
    (when_ns,) = [ns for ns, event in adapter.bench.events if isinstance(event, CodesRead)]
    assert 0 < when_ns - 50_500_000 <= 3 * MS


@pytest.mark.parametrize("start_ms", [0.0, 0.3, 2.5, 5.0, 7.7])
@pytest.mark.parametrize(("length_ms", "connects"), [(5, False), (50, True)])
def test_g15_a_short_pulse_is_ignored_and_a_long_one_connects(adapter, length_ms, connects, start_ms, pulse) -> None:
    start_ns = 1500 * MS + round(start_ms * MS)
    pulse(adapter.wire("p2dx_con"), start_ns, start_ns + length_ms * MS)
    adapter.run(1.7)
    events = [(ns, event.connected) for ns, event in adapter.bench.events if isinstance(event, ConnectionPin)]
    echoes = [edge for edge in adapter.wire("echo").edges if edge[0] > 0]
    if not connects:
        assert events == echoes == []
        return
    (on_ns, on), (off_ns, off) = events
    assert (on, off) == (True, False)
    assert echoes == [(on_ns, True), (off_ns, False)]
    assert 5 * MS < on_ns - start_ns <= 20 * MS
    assert 5 * MS <= off_ns - start_ns - 50 * MS <= 20 * MS


def test_within_the_first_second_nothing_is_acted_on(adapter, pulse) -> None:
    pulse(adapter.wire("p2dx_con"), 100 * MS, 900 * MS)
    adapter.run(1.5)
    assert adapter.told(ConnectionPin) == []
    assert adapter.line == []


def test_a_pin_that_is_high_from_the_start_connects_after_a_second(adapter) -> None:
    adapter.put("p2dx_con", True)
    adapter.run(1.1)
    (when_ns,) = [ns for ns, event in adapter.bench.events if isinstance(event, ConnectionPin)]
    assert 1000 * MS < when_ns <= 1002 * MS
    assert adapter.line[0][1] == bytes.fromhex("FAFB03000000")


def test_another_dead_time_and_window(make_adapter) -> None:
    adapter = make_adapter(dead_time_s=0.2, connection_sample_ms=100.0)
    adapter.put("p2dx_con", True)
    adapter.run(0.25)
    (when_ns,) = [ns for ns, event in adapter.bench.events if isinstance(event, ConnectionPin)]
    assert 200 * MS < when_ns <= 210 * MS


@each(("high_ns", "verdict"), [(5 * MS, False), (5 * MS + 1, True)])
def test_more_than_half_of_the_window(high_ns, verdict, pulse) -> None:
    wire = Wire()
    pulse(wire, 3 * MS, 3 * MS + high_ns)
    sampler = ConnectionSampler(wire, 10 * MS, 0)
    verdicts = []
    for number in range(21):
        sampler.take_pass(number * MS)
        verdicts.append(sampler.high)
    assert verdicts == [False] * 10 + [verdict] * 10 + [False]


def test_reset_line_forgets_everything_and_drives_nothing(adapter, pulse) -> None:
    adapter.connect()
    adapter.robot.sip = _sip_with_obstacle()
    adapter.run(0.3)
    assert adapter.distances()[2] is True
    pulse(adapter.wire("rst"), adapter.now_ns + MS // 2, adapter.now_ns + 10 * MS + MS // 2)
    adapter.run(0.005)
    assert len(adapter.told(AdapterHeld)) == 1
    assert adapter.distances() == [None] * 8
    assert adapter.level("echo") is None
    assert adapter.level("e1_s1") is None
    sent = len(adapter.line)
    adapter.run(0.02)
    started = adapter.told(AdapterStarted)
    assert started == [
        AdapterStarted(mode="bluepill", cause="power"),
        AdapterStarted(mode="bluepill", cause="reset line"),
    ]
    assert adapter.distances() == [False] * 6 + [None] * 2
    assert adapter.level("echo") is False
    adapter.run(0.9)
    assert len(adapter.line) == sent  # dead time
    adapter.run(5.0)
    assert len(adapter.told(RobotConnected)) == 2
    assert adapter.level("echo") is True


def _sip_with_obstacle():
    from protocols.p2os import Sip, SonarReading

    return Sip(sonars=(SonarReading(number=2, range_raw=1000),))


def test_the_shortest_glitch_on_the_reset_line_resets(adapter, pulse) -> None:
    adapter.run(0.1)
    pulse(adapter.wire("rst"), adapter.now_ns + 300, adapter.now_ns + 1300)
    adapter.run(0.01)
    assert [event.cause for event in adapter.told(AdapterStarted)] == ["power", "reset line"]


def test_held_in_reset_from_power_on(make_adapter) -> None:
    adapter = make_adapter()
    held = make_adapter()
    held.bench.wires["rst"].set(True, 0)
    held.bench.part.power_on(0)
    assert adapter.told(AdapterStarted)
    held.put("p2dx_con", True)
    held.run(3.0)
    assert held.line == []
    held.put("rst", False)
    held.run(3.0)
    assert held.told(RobotConnected)


@each(("level", "mode"), [(True, "bluepill"), (False, "gamepad")])
def test_the_mode_pin_is_read_once_at_start(make_adapter, level, mode, pulse) -> None:
    adapter = make_adapter(mode="pin")
    adapter.put("mode", level)
    adapter.run(0.001)
    pulse(adapter.wire("rst"), adapter.now_ns, adapter.now_ns + 2 * MS)
    adapter.run(0.01)
    assert adapter.told(AdapterStarted)[-1].mode == mode
    adapter.put("mode", not level)
    adapter.run(0.01)
    assert len(adapter.told(AdapterStarted)) == 2


@each(
    ("name", "value"),
    [("mode", "radio"), ("motor_reads", 0), ("pass_ms", 0.0), ("encoder_order", "random"), ("safe_stop_s", -1.0)],
)
def test_settings_are_checked(name, value) -> None:
    with pytest.raises(ValueError, match=rf"^{name} must be"):
        P2osAdapterSettings(**{name: value})
