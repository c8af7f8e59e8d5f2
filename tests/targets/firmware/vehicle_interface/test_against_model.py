"""Each image says what the behavioural model with the same defect says: the same frames and messages, within two ticks.

The model's tasks take no time and know no ticks; a message of the board is later by what lies on the line before it.
"""

from __future__ import annotations

import math

import pytest

from protocols import autoware
from targets.firmware import image_names
from targets.robots.vehicle_interface import DEFECTS

FEW = ("vehicle", "vehicle-v0", "vehicle-v1")
MICRO_ROS = "vehicle-micro-ros"
"""Images that speak DDS-XRCE, where the model has the stand-in link; the bench vehicle-micro-ros has their suites."""
IMAGES = [name for name in image_names() if name.startswith("vehicle") and not name.startswith(MICRO_ROS)]
UNPLAYED = ("vehicle-no-watchdog",)
"""No play makes a program hang; test_on_board.py and VB56H do."""
SHORT = {"vehicle-flag-clash": "V1"} | {f"vehicle-h{number}": f"H{number}" for number in range(1, 10)}


def settings_of(name):
    """What the model is set to for an image."""
    if name == "vehicle":
        return {}
    what = name.removeprefix("vehicle-")
    return {"profile": what} if name in FEW else {"defects": (SHORT.get(name, what),)}


def every(period_ms, begin_ms, end_ms):
    return [begin_ms + period_ms * step for step in range(math.ceil((end_ms - begin_ms) / period_ms))]


def drive(stimuli):
    """Commands, their loss, the simulator's loss, presses too early, too soon and in time, the joystick, requests."""
    stimuli.online(50.2)
    stimuli.status(*every(50, 100.3, 2100), lon_speed_m_s=3.0, heading_rate_rad_s=0.1, steering_rad=0.05)
    stimuli.command(
        *every(33.4, 320.7, 1450), steering_tire_angle=0.5, steering_tire_rotation_rate=0.1, speed=5.0, jerk=0.2
    )
    stimuli.message(300.4, autoware.Clock(clock=autoware.Time(7, 5))).press(700.2)
    stimuli.message(700.4, autoware.TurnIndicatorsCommand(command=autoware.TurnIndicators.ENABLE_LEFT))
    stimuli.request(900.2, 2, sequence=9)
    stimuli.message(2457.4, autoware.HazardLightsCommand(command=autoware.HazardLights.ENABLE))
    stimuli.press(4801.5)  # in EMERGENCY
    stimuli.status(*every(50, 5400.3, 9900), lon_speed_m_s=1.0)
    stimuli.command(*every(33.4, 5900.7, 7200), steering_tire_angle=-0.5, speed=2.0)
    stimuli.press(6001.5).press(6502.5)
    stimuli.move(8000.2, 0, 65_535).move(8300.2, 65_535, 20_000).move(8500.2, 40_000, 0)
    stimuli.request(8700.5, 1, sequence=4).request(9100.5, 4, sequence=5)
    stimuli.command(*every(33.4, 8700.9, 9300), speed=8.0)
    return stimuli, 9900


def trouble(stimuli):
    """Statuses and commands that cannot be true, orders against the mode, commands that wait, a line that errs."""
    good = {"lon_speed_m_s": 2.0}
    stimuli.online(50.2)
    stimuli.status(*every(50, 100.3, 2500), **good)
    stimuli.status(925.3, heading_rate_rad_s=math.nan).status(1120.3, lon_speed_m_s=1000.0)
    stimuli.command(*every(7.1, 120.7, 3300), steering_tire_angle=0.25, speed=5.0)
    stimuli.command(1000.2, speed=math.nan).command(1300.2, steering_tire_angle=2.4)
    stimuli.press(1507.5).press(2701.5)  # a command waits each time
    stimuli.request(2303.0, 1, sequence=1).request(2303.4, 4, sequence=2)
    stimuli.request(4705.5, 1, sequence=3)  # in EMERGENCY
    stimuli.status(*every(50, 6400.3, 7900), **good)
    stimuli.command(*every(33.4, 6503.7, 6900), speed=1.0)
    stimuli.request(6480.5, 1, sequence=4)
    stimuli.noise.append(7107.5)
    stimuli.raw(7523.5, b"#")
    stimuli.status(*every(50, 7905.3, 9900), **good)
    stimuli.message(9405.4, autoware.Clock()).press(9350.5).press(10_500.5)  # the agent is lost, and found
    stimuli.status(*every(50, 9905.3, 11_000), **good)
    return stimuli, 11_000


def late(stimuli):
    """An agent that comes after twenty seconds."""
    stimuli.status(*every(50, 19_500.3, 22_000), lon_speed_m_s=2.0)
    stimuli.online(21_003.2).command(*every(33.4, 21_100.7, 22_000), speed=3.0).press(21_305.5)
    return stimuli, 22_000


def kinds(said):
    """What was said, by whom and what kind, in order."""
    found = {}
    for one in said:
        if one.who != "light":
            found.setdefault((one.who, type(one.what).__name__ if one.who == "stack" else ""), []).append(one)
    return found


def check(board, model, played):
    stimuli, until_ms = played
    ours, theirs = kinds(board.play(stimuli, until_ms)), kinds(model.play(stimuli, until_ms))
    assert ours.keys() == theirs.keys()
    for kind, expected in theirs.items():
        for one, other in zip(ours[kind], expected, strict=False):
            assert one.agrees_with(other), f"{one} for {other}"
        assert abs(len(ours[kind]) - len(expected)) <= 1  # what is on its way at the end
    assert board.misuses == []
    assert board.resets == ["POR"]


@pytest.mark.parametrize(
    ("name", "play"),
    [
        pytest.param(
            name,
            play,
            marks=pytest.mark.slow("ten seconds of everything that the board and its model do")
            if (name, play) == ("vehicle", drive)
            else pytest.mark.exhaustive("each profile in each play; the gate has the hardened one in the longer play"),
        )
        for name in FEW
        for play in (drive, trouble)
    ],
)
def test_it_says_what_the_model_says(on_board, model, stimuli, name, play):
    check(on_board(name), model(**settings_of(name)), play(stimuli))


@pytest.mark.exhaustive("22 s of waiting for an agent; the gate has the model, which waits as long")
@pytest.mark.parametrize("name", FEW)
def test_an_agent_that_comes_late(on_board, model, stimuli, name):
    check(on_board(name), model(**settings_of(name)), late(stimuli))


def first_that_shows(model, make_stimuli, name):
    """The first play in which the model says something else with the defect of an image."""
    for play in (drive, trouble, late):
        played = [model(**settings).play(*play(make_stimuli())) for settings in ({}, settings_of(name))]
        if [str(one) for one in played[0]] != [str(one) for one in played[1]]:
            return play
    raise AssertionError(f"no play shows what {name} does")


@pytest.mark.exhaustive("each defect; the gate compares the hardened board")
@pytest.mark.parametrize("name", [name for name in IMAGES if name not in (*FEW, *UNPLAYED)])
def test_so_it_does_with_each_defect(on_board, model, stimuli, name):
    play = first_that_shows(model, type(stimuli), name)
    check(on_board(name), model(**settings_of(name)), play(stimuli))


def test_each_defect_of_the_model_has_an_image():
    assert {name for image in IMAGES for name in settings_of(image).get("defects", ())} == set(DEFECTS)
