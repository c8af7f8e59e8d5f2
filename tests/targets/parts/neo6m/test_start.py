"""From switching on to a position, and back to none (NEO-6 data sheet GPS.G6-HW-09005, table 2)."""

from __future__ import annotations

import pytest

from targets.parts.neo6m import FixChanged, Neo6m, Neo6mSettings, ReceiverStarted
from targets.parts.part import Ports
from tests.each import each

MS = 1_000_000


def _first_fix_s(gps) -> float:
    return next(ns for ns, event in gps.bench.events if isinstance(event, FixChanged)) / 1e9


@each(("start", "typical_s"), [("cold", 27), ("warm", 27), ("hot", 1)])
def test_times_to_first_fix(make_gps, start, typical_s) -> None:
    gps = make_gps(start=start, spread_percent=0)
    gps.run(40)
    assert typical_s <= _first_fix_s(gps) <= typical_s + 2
    assert gps.bench.told(FixChanged) == [FixChanged(fix="3d", satellites=10)]
    assert gps.bench.told(ReceiverStarted) == [ReceiverStarted(start=start)]


def test_times_are_drawn_by_the_seed() -> None:
    def first_fix_ns(seed):
        told = []
        part = Neo6m(Neo6mSettings(), Ports(tell=told.append), seed=seed)
        part.power_on(0)
        while not any(isinstance(event, FixChanged) for event in told):
            now_ns = part.next_deadline_ns()
            part.advance(now_ns)
        return now_ns

    times = [first_fix_ns(seed) for seed in range(30)]
    assert len(set(times)) > 5
    assert first_fix_ns(3) == times[3]
    assert sum(times) / len(times) / 1e9 == pytest.approx(27.5, abs=2)


def test_a_cold_receiver_finds_satellites_then_the_time_then_a_position(make_gps) -> None:
    gps = make_gps(start="cold", spread_percent=0)
    gps.run(32)
    lines = gps.lines()
    counts = [int(fields[3]) for fields in lines if fields[0] == "GPGSV"]
    assert counts == sorted(counts)
    assert counts[0] == 0
    assert counts[-1] == 10
    times = [fields[1] for fields in lines if fields[0] == "GPRMC"]
    first_time = next(index for index, time in enumerate(times) if time)
    fixes = [fields[2] for fields in lines if fields[0] == "GPRMC"]
    assert 15 < first_time < fixes.index("A")
    assert ["GPRMC", times[first_time], "V", *[""] * 6, "100921", "", "", "N"] in lines


def test_where_satellites_stand_is_not_known_at_once(make_gps) -> None:
    gps = make_gps(start="cold", spread_percent=0)
    gps.run(12)
    gsv = [fields for fields in gps.lines() if fields[0] == "GPGSV"][-1]
    assert gsv[4] != ""
    assert gsv[5:7] == ["", ""]


def test_a_closed_sky_keeps_it_searching(make_gps) -> None:
    gps = make_gps()
    gps.bench.part.set({"sky": 0.0}, 0)
    gps.run(10)
    assert gps.bench.told(FixChanged) == []
    gps.bench.part.set({"sky": 1.0}, gps.now_ns)
    gps.run(4)
    assert gps.bench.told(FixChanged) == [FixChanged(fix="3d", satellites=10)]


def test_losing_satellites_and_finding_them_again(gps) -> None:
    for sky, seconds in ((0.3, 2), (0.1, 2), (0.5, 4)):
        gps.bench.part.set({"sky": sky}, gps.now_ns)
        gps.run(seconds)
    assert gps.bench.told(FixChanged)[1:] == [
        FixChanged(fix="2d", satellites=3),
        FixChanged(fix="none", satellites=0),
        FixChanged(fix="3d", satellites=5),
    ]
    lines = gps.lines()
    lost = next(fields for fields in lines if fields[0] == "GPRMC" and fields[2] == "V")
    assert lost[1] != ""
    assert lost[3:7] == [""] * 4


@pytest.mark.parametrize("sky", [-0.1, 1.1])
def test_the_sky_has_its_range(gps, sky) -> None:
    with pytest.raises(ValueError, match=r"^sky goes from 0 to 1"):
        gps.bench.part.set({"sky": sky}, gps.now_ns)


# --- time pulse


def test_the_pulse_comes_at_the_full_second_with_a_fix_only(make_gps) -> None:
    gps = make_gps(spread_percent=0, utc="2021-09-10T12:00:00.4")
    gps.run_to(6)
    edges = gps.bench.wires["timepulse"].edges
    assert edges[0] == (0, False)
    rises = [ns for ns, level in edges if level]
    falls = [ns for ns, level in edges[1:] if level is False]
    assert rises[0] >= 1.6e9
    assert {ns % 1_000_000_000 for ns in rises} == {600 * MS}
    assert [fall - rise for rise, fall in zip(rises, falls, strict=True)] == [100 * MS] * len(rises)
    gps.bench.part.set({"sky": 0.0}, gps.now_ns)
    gps.run(3)
    assert len([ns for ns, level in gps.bench.wires["timepulse"].edges if level]) == len(rises) + 1


# --- resets


@pytest.mark.parametrize(("cleared", "kind"), [(0x0000, "hot"), (0x0001, "warm"), (0xFFFF, "cold"), (0x0002, "hot")])
def test_what_is_cleared_says_how_it_starts(gps, cleared, kind) -> None:
    assert gps.command(0x06, 0x04, cleared.to_bytes(2, "little") + b"\x01\x00") == b""
    assert gps.bench.told(ReceiverStarted)[-1] == ReceiverStarted(start=kind)
    gps.run(1.5)
    assert b"u-blox ag" in gps.take()


def test_what_was_never_known_is_not_remembered(make_gps) -> None:
    gps = make_gps(start="cold", spread_percent=0)
    gps.run_to(5)
    gps.command(0x06, 0x04, b"\x00\x00\x01\x00")
    assert gps.bench.told(ReceiverStarted)[-1] == ReceiverStarted(start="cold")
    gps.run(30)
    gps.command(0x06, 0x04, b"\x00\x00\x01\x00")
    assert gps.bench.told(ReceiverStarted)[-1] == ReceiverStarted(start="hot")


def test_a_reset_of_navigation_alone_says_nothing_and_forgets_the_position(gps) -> None:
    gps.command(0x06, 0x04, b"\xff\xff\x02\x00")
    gps.run(2)
    lines = gps.lines()
    assert "GPTXT" not in [fields[0] for fields in lines]
    assert [fields for fields in lines if fields[0] == "GPRMC"][-1][2] == "V"


def test_navigation_can_be_stopped_and_started(gps) -> None:
    gps.command(0x06, 0x04, b"\x00\x00\x08\x00")
    gps.run(5)
    assert gps.last("GPRMC")[2] == "V"
    gps.command(0x06, 0x04, b"\x00\x00\x09\x00")
    gps.run(4)
    assert gps.last("GPRMC")[2] == "A"


def test_nobody_hears_during_the_start(make_gps) -> None:
    gps = make_gps()
    gps.say(b"\xb5\x62\x0a\x04\x00\x00\x0e\x34")
    gps.run_to(0.2)
    assert gps.take() == b""
    assert any("start-up" in note for note in gps.notes())


def test_settings_are_checked() -> None:
    with pytest.raises(ValueError, match=r"^utc must look like"):
        Neo6mSettings(utc="noon")
    with pytest.raises(ValueError, match=r"^latitude_deg must be at most 90"):
        Neo6mSettings(latitude_deg=91)
