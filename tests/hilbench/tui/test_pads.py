"""Game pads: events cut anywhere, what is pushed and pulled, the dead man, coming and going."""

from __future__ import annotations

import os

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.tui.model.pad import DEAD_MAN, DEAD_ZONE, EVENT, PadState
from hilbench.tui.pad_hand import PadHand
from hilbench.tui.pads import LOOK_EVERY_S, Pads

BUTTON, AXIS, INITIAL = 1, 2, 0x80
FULL = 32767


def event(kind, number, value):
    return EVENT.pack(0, value, kind, number)


def axis(number, share):
    return event(AXIS, number, round(share * FULL))


def pad(*events):
    state = PadState()
    state.feed(b"".join(events))
    return state


# --- what it means


def test_an_event_is_as_the_kernel_has_it():
    assert EVENT.size == 8
    assert pad(bytes.fromhex("00000000 0100 01 04")).held  # little-endian, as every machine we run on


@given(st.binary(max_size=200), st.lists(st.integers(0, 200), max_size=4))
def test_however_events_are_cut_they_mean_the_same(data, cuts):
    whole, parts = pad(data), PadState()
    for begin, end in zip([0, *sorted(cuts)], [*sorted(cuts), len(data)], strict=True):
        parts.feed(data[begin:end])
    assert (parts.shares, parts.held, parts.asked) == (whole.shares, whole.held, whole.asked)
    assert all(-1 <= share <= 1 for share in whole.shares)


@given(st.floats(-1, 1))
def test_a_stick_begins_beyond_its_dead_zone_and_ends_at_its_end(share):
    forward, turn = pad(axis(1, share), axis(0, 0.0)).shares
    assert turn == 0.0
    if abs(share) <= DEAD_ZONE - 1e-4:
        assert forward == 0.0
    else:
        expected = (abs(share) - DEAD_ZONE) / (1 - DEAD_ZONE)
        assert abs(forward) == pytest.approx(max(0.0, expected), abs=1e-3)
        assert forward * share <= 0  # up is negative there, and forward here


def test_up_is_forward_and_left_is_left():
    assert pad(axis(1, -1)).shares == (1.0, 0.0)
    assert pad(axis(0, -1)).shares == (0.0, 1.0)
    assert pad(axis(3, 1)).shares == (0.0, -1.0)


def test_the_triggers_are_the_speed_their_difference():
    at_rest = (event(AXIS | INITIAL, 2, -FULL), event(AXIS | INITIAL, 5, -FULL))
    assert pad(*at_rest).shares == (0.0, 0.0)
    assert pad(*at_rest, axis(5, 1)).shares == (1.0, 0.0)
    assert pad(*at_rest, axis(2, 0)).shares[0] == pytest.approx(-0.5, abs=1e-3)
    assert pad(*at_rest, axis(5, 1), axis(2, 1)).shares == (0.0, 0.0)


def test_an_axis_that_was_never_seen_at_the_end_of_a_trigger_is_none():
    assert pad(axis(5, 0.0), axis(2, 0.0)).shares == (0.0, 0.0)


def test_the_cross_connects_and_disconnects_once_each_time():
    state = pad(axis(7, -1), axis(7, -1), axis(7, 0), axis(7, 1))
    assert state.asked == ["connect", "disconnect"]
    assert pad(event(AXIS | INITIAL, 7, -FULL)).asked == []


# --- the device


@pytest.fixture
def device(tmp_path):
    """A pad that a test moves: a pipe with a name, in the place of a device."""
    path = tmp_path / "js0"
    os.mkfifo(path)
    writer = os.open(path, os.O_RDWR | os.O_NONBLOCK)
    yield path, lambda *events: os.write(writer, b"".join(events))
    os.close(writer)


def test_a_pad_is_found_read_missed_and_found_again(device):
    path, move = device
    pads = Pads(path.parent)
    assert pads.poll(0.0) == ["game pad: js0. Hold L1 (LB) and drive"]
    assert pads.poll(0.1) == []
    move(axis(1, -1), event(BUTTON, DEAD_MAN, 1))
    pads.poll(0.2)
    assert (pads.state.held, pads.state.shares) == (True, (1.0, 0.0))
    path.rename(path.with_name("gone"))
    assert pads.poll(0.3) == ["game pad js0 is gone"]
    assert (pads.name, pads.state.held) == ("", False)
    path.with_name("gone").rename(path)
    assert pads.poll(0.4 + LOOK_EVERY_S) == ["game pad: js0. Hold L1 (LB) and drive"]
    pads.close()


def test_without_devices_there_is_none(tmp_path):
    pads = Pads(tmp_path / "nothing")
    assert pads.poll(0.0) == []
    assert pads.name == ""


def test_a_pad_that_cannot_be_read_is_said_once(tmp_path):
    (tmp_path / "js0").symlink_to(tmp_path / "loop")
    (tmp_path / "loop").symlink_to(tmp_path / "js0")
    pads = Pads(tmp_path)
    (said,) = pads.poll(0.0)
    assert said.startswith(f"game pad {tmp_path / 'js0'} cannot be read:")
    assert pads.poll(10.0) == []


# --- the hand


def test_the_dead_man_drives_while_it_is_held_and_stops_when_it_is_let_go(device, process_of):
    path, move = device
    process, hand = process_of("pioneer"), PadHand(Pads(path.parent))
    move(axis(1, -1), axis(0, 0.55))
    hand.look(process, 0.0)
    assert process.sent == []
    assert hand.text == "pad +1.00 ahead -0.50 left, hold L1"
    move(event(BUTTON, DEAD_MAN, 1))
    hand.look(process, 0.1)
    hand.look(process, 0.2)
    assert process.sent == [("drive", {"forward": 1.0, "turn": -0.5, "pad": True})] * 2
    assert hand.text.endswith("drives")
    move(event(BUTTON, DEAD_MAN, 0))
    hand.look(process, 0.3)
    hand.look(process, 0.4)
    assert process.sent[2:] == [("stop", {})]
    hand.close()


def test_a_pad_that_is_unplugged_while_it_drives_stops_the_vehicle(device, process_of):
    path, move = device
    process, hand = process_of("pioneer"), PadHand(Pads(path.parent))
    move(event(BUTTON, DEAD_MAN, 1))
    hand.look(process, 0.0)
    path.unlink()
    assert hand.look(process, 0.1) == ["game pad js0 is gone"]
    assert process.sent[-1] == ("stop", {})
    assert hand.text == ""


def test_only_what_the_bench_can_is_asked(device, process_of):
    path, move = device
    process, hand = process_of("pioneer"), PadHand(Pads(path.parent))
    process.actions = ("connect",)
    move(event(BUTTON, DEAD_MAN, 1), axis(7, -1), axis(7, 1))
    hand.look(process, 0.0)
    assert process.sent == [("connect", {})]
    hand.close()


def test_the_dashboard_shows_the_pad_and_drives_by_it(device, process_of, on_screen, rows):
    path, move = device
    process = process_of("pioneer")
    pads = Pads(path.parent)

    async def scenario(app, pilot):
        move(event(BUTTON, DEAD_MAN, 1), axis(1, -1))
        app.look()
        await pilot.pause()
        assert "pad +1.00 ahead +0.00 left, drives" in rows(app)[0]
        assert ("drive", {"forward": 1.0, "turn": 0.0, "pad": True}) in process.sent

    on_screen(process, scenario, (100, 30), pads=pads)
    pads.close()
