"""Images on the emulated board against fixed figures: deadlines within a tick, pins, lines, the watchdog, sleep.

The figures are those of the original (LMA-FEM-UNICAMP/microAutoware, src/HIL taksControl.c and its header), in ms.
"""

from __future__ import annotations

import itertools
import struct

import pytest

from protocols import autoware, carla
from tests.share import few

TICK_MS = 1.1
STOPPED = carla.CommandFrame(mode=carla.Mode.EMERGENCY)
AT_REST = carla.CommandFrame(steering=-0.0, mode=carla.Mode.MANUAL)
COMMAND = {"steering_tire_angle": 0.5, "speed": 5.0, "acceleration": 1.0, "jerk": 0.25}
MOVING = carla.decode_command(
    carla.encode_command(
        carla.CommandFrame(steering=0.6, speed=5.0, acceleration=1.0, jerk=0.25, mode=carla.Mode.AUTOWARE)
    )
)
WAITING, FOR_EVER = 1, 0xFFFFFFFF
AS_SHIPPED = ["vehicle-v0", "vehicle-v1"]
PLAYED = pytest.mark.exhaustive(
    "fixed figures for what the gate compares with the model in the drive of test_against_model"
)
OF_THE_MODEL = pytest.mark.exhaustive("the image is fixed bytes; the gate asks this of the model, and of faulty ones")
THE_SAME_CODE = pytest.mark.exhaustive("the same question to another image; the gate asks one")
WITH_THE_DEFECT = pytest.mark.exhaustive(
    "what the defect leads to; the gate asks the hardened image, the suites find it"
)
ANY = ["vehicle", *(pytest.param(name, marks=THE_SAME_CODE) for name in AS_SHIPPED)]


def every(period_ms, begin_ms, end_ms):
    return [begin_ms + period_ms * step for step in range(int((end_ms - begin_ms) // period_ms) + 1)]


def frames(said, begin_ms=0, end_ms=1e9):
    return [(one.ms, one.what) for one in said if one.who == "simulator" and begin_ms <= one.ms < end_ms]


def modes(found):
    return [frame.mode if isinstance(frame, carla.CommandFrame) else None for _ms, frame in found]


def periods(found):
    times = [ms for ms, _frame in found]
    return [after - before for before, after in itertools.pairwise(times)]


def messages(said, kind):
    return [(one.ms, one.what) for one in said if one.who == "stack" and isinstance(one.what, kind)]


def lights(said):
    return [one.what for one in said if one.who == "light" and one.what[1]]


def all_near(values, expected):
    return values and all(abs(value - expected) <= TICK_MS for value in values)


@pytest.mark.parametrize("name", ["vehicle", *AS_SHIPPED])
def test_it_starts_at_480_mhz_and_touches_nothing_that_is_wrong(on_board, stimuli, name):
    board = on_board(name)
    board.play(stimuli.status(10.5).online(20.5), 50)
    assert board.machine.time.hclk_hz * 2 == 480_000_000 or board.machine.time.hclk_hz == 480_000_000
    assert board.misuses == []
    assert board.resets == ["POR"]


@pytest.mark.parametrize("name", ["vehicle", *AS_SHIPPED])
def test_a_command_is_handed_on_at_once(on_board, stimuli, name):
    stimuli.online(50.2).status(*every(50, 100.3, 400)).command(140.7, **COMMAND)
    assert frames(on_board(name).play(stimuli, 190)) == [(pytest.approx(141.1, abs=TICK_MS), MOVING)]


@PLAYED
@pytest.mark.parametrize("name", ANY)
def test_twenty_frames_in_a_second(on_board, stimuli, name):
    """Commands at 30 Hz, statuses at 20 Hz."""
    stimuli.online(50.2).status(*every(50, 100.3, 1300)).command(*every(33.3, 110.7, 1300), speed=5.0)
    found = frames(on_board(name).play(stimuli, 1300), 200, 1200)
    assert 19 <= len(found) <= 21
    assert set(modes(found)) == {carla.Mode.AUTOWARE}


@OF_THE_MODEL
@pytest.mark.parametrize("name", ANY)
def test_without_an_agent(on_board, stimuli, name):
    said = on_board(name).play(stimuli, 20_050)
    assert frames(said)[0] == (pytest.approx(20_000, abs=TICK_MS), AT_REST)
    assert len(messages(said, autoware.AgentPing)) == 20
    assert lights(said) == [("green", True)]


@pytest.mark.parametrize("name", ["vehicle-v0", pytest.param("vehicle-v1", marks=THE_SAME_CODE)])
def test_without_a_command_the_buffer_is_sent_as_it_is(on_board, stimuli, name):
    found = frames(on_board(name).play(stimuli.online(50.2).status(*every(50, 60.3, 1300)), 1250))
    assert [frame for _ms, frame in found[:9]] == [b"\xa5" * 30] * 9
    assert all_near(periods(found[:9]), 110)
    assert found[9] == (pytest.approx(50.2 + 1100, abs=TICK_MS), AT_REST)


def test_hardened_says_nothing_before_the_first_command(on_board, stimuli):
    found = frames(on_board("vehicle").play(stimuli.online(50.2).status(*every(50, 60.3, 1300)), 1250))
    assert found[0] == (pytest.approx(50.2 + 1100, abs=TICK_MS), AT_REST)


def left_without_commands(stimuli):
    """Commands end at 400 ms, statuses go on; the frame behind the last command is answered at 450.3."""
    return stimuli.online(50.2).status(*every(50, 100.3, 2000)).command(*every(33.3, 110.7, 400), **COMMAND)


@PLAYED
@pytest.mark.parametrize(
    ("name", "sent"),
    [
        pytest.param("vehicle-v0", MOVING, marks=WITH_THE_DEFECT),
        pytest.param("vehicle-h7", MOVING, marks=WITH_THE_DEFECT),
        ("vehicle", carla.CommandFrame(steering=MOVING.steering, mode=carla.Mode.AUTOWARE)),
    ],
)
def test_what_is_sent_for_missing_commands(on_board, stimuli, name, sent):
    found = frames(on_board(name).play(left_without_commands(stimuli), 1700))
    manual = modes(found).index(carla.Mode.MANUAL)
    missing = found[manual - 9 : manual]
    assert [frame for _ms, frame in missing] == [sent] * 9
    assert all_near(periods(missing), 110)
    assert abs(found[manual][0] - missing[-1][0] - 110) <= TICK_MS


@pytest.mark.exhaustive("what the published firmware does; slow commands show it of the hardened one")
def test_a_command_clears_the_misses(on_board, stimuli):
    """Nine misses, one command, nine misses, one command."""
    stimuli.online(50.2).status(*every(50, 100.3, 2400)).command(140.7, 1180.7, 2220.7, **COMMAND)
    found = frames(on_board("vehicle-v0").play(stimuli, 2300))
    assert len(found) == 3 + 9 + 9
    assert set(modes(found)) == {carla.Mode.AUTOWARE}


@PLAYED
@pytest.mark.parametrize("name", ANY)
def test_the_simulator_falls_silent_in_autoware(on_board, stimuli, name):
    stimuli.online(50.2).status(*every(50, 100.3, 1010)).command(*every(33.3, 110.7, 3000), **COMMAND)
    stimuli.status(2820.3)
    board = on_board(name)
    said = board.play(stimuli, 2860)
    found = frames(said, 1000.4)
    stop = modes(found).index(carla.Mode.EMERGENCY)
    assert modes(found[:stop]) == [carla.Mode.AUTOWARE] * 10
    assert all_near(periods(found[: stop + 1]), 100)
    stops = found[stop : modes(found).index(carla.Mode.MANUAL)]
    assert [frame for _ms, frame in stops] == [STOPPED] * len(stops)
    assert all_near(periods(stops), 100)
    assert found[stop + len(stops)] == (pytest.approx(2820.6, abs=TICK_MS), AT_REST)
    assert lights(said) == [("amber", True), ("red", True), ("green", True)]
    assert messages(said, autoware.ControlModeReport)[-1][1].mode == autoware.ControlMode.MANUAL
    assert board.level("PB0")
    assert not board.level("PB14")


def in_manual(stimuli):
    """From 1.2 s on, for want of commands."""
    return stimuli.online(50.2).status(*every(50, 100.3, 1600))


@PLAYED
@pytest.mark.parametrize(
    ("name", "hz", "period_ms"),
    [
        ("vehicle", 20, 60),
        pytest.param("vehicle", 10, 100, marks=pytest.mark.exhaustive("another rate of the simulator")),
        pytest.param("vehicle-v0", 20, 60, marks=THE_SAME_CODE),
        pytest.param("vehicle-v0", 10, 100, marks=THE_SAME_CODE),
    ],
)
def test_frames_in_manual(on_board, stimuli, name, hz, period_ms):
    in_manual(stimuli).status(*every(1000 / hz, 1650.3, 2400))
    assert all_near(periods(frames(on_board(name).play(stimuli, 2400), 1900)), period_ms)


@PLAYED
@pytest.mark.parametrize("name", ["vehicle", pytest.param("vehicle-v0", marks=THE_SAME_CODE)])
def test_the_simulator_falls_silent_in_manual(on_board, stimuli, name):
    found = frames(on_board(name).play(in_manual(stimuli), 3600), 1200)
    stop = modes(found).index(carla.Mode.EMERGENCY)
    assert all_near(periods(found[: stop - 9]), 60)
    assert all_near(periods(found[stop - 10 : stop + 1]), 160)


@pytest.mark.exhaustive("five seconds; the gate compares V1 with its model, which raises them, too")
@pytest.mark.parametrize("name", ["vehicle-v1", "vehicle-flag-clash"])
def test_the_false_emergencies_of_v1(on_board, stimuli, name):
    in_manual(stimuli).status(*every(50, 1650.3, 5400), lon_speed_m_s=3.0)
    said = on_board(name).play(stimuli, 5400)
    found = frames(said, 1700)
    stops = [one for one in found if one[1].mode == carla.Mode.EMERGENCY]
    assert len(stops) >= 2
    assert all_near(periods(stops), 1600)
    assert all_near(periods([one for one in found if one[1].mode == carla.Mode.MANUAL]), 160)
    reports = [report for ms, report in messages(said, autoware.VelocityReport) if ms > 1700]
    assert {report.longitudinal_velocity for report in reports} == {0.0}


@OF_THE_MODEL
def test_v1_forgets_an_order_to_drive(on_board, stimuli):
    """The order comes while the control task waits; it is back in MANUAL 1.1 s after it took it."""
    in_manual(stimuli).status(*every(50, 1650.3, 5000)).command(*every(33.3, 1800.7, 5000), **COMMAND)
    stimuli.request(2040.5, autoware.ControlMode.AUTONOMOUS, sequence=3)
    said = on_board("vehicle-v1").play(stimuli, 3300)
    assert messages(said, autoware.ControlModeResponse)[0][1].success
    turned = [one.ms for one in said if one.who == "light" and one.ms > 2000]
    assert turned[2] - turned[0] == pytest.approx(1100, abs=TICK_MS)
    hands_on = [ms for ms, frame in frames(said, 2000) if frame == MOVING]
    assert hands_on == []


@OF_THE_MODEL
def test_slow_commands(on_board, stimuli):
    """At 5 Hz each is followed by one frame for a missing one, and MANUAL never comes."""
    stimuli.online(50.2).status(*every(50, 60.3, 2000)).command(*every(200, 70.7, 2000), **COMMAND)
    found = frames(on_board("vehicle").play(stimuli, 2000), 500)
    assert set(modes(found)) == {carla.Mode.AUTOWARE}
    assert [frame.speed for _ms, frame in found[:8]] in ([5.0, 0.0] * 4, [0.0, 5.0] * 4)


@pytest.mark.exhaustive("the drive of test_against_model.py has such presses")
def test_presses_too_early_and_too_soon(on_board, stimuli):
    stimuli.online(50.2).status(*every(50, 60.3, 4000)).command(*every(33.3, 70.7, 4000), **COMMAND)
    said = on_board("vehicle").play(stimuli.press(900.5).press(1600.5).press(2100.5).press(2700.5), 2750)
    assert lights(said) == [("amber", True), ("green", True), ("amber", True)]


@OF_THE_MODEL
@pytest.mark.parametrize(
    ("name", "after"), [("vehicle", "AUTOWARE"), pytest.param("vehicle-v0", "EMERGENCY", marks=WITH_THE_DEFECT)]
)
def test_a_stray_byte(on_board, stimuli, name, after):
    stimuli.online(50.2).status(*every(50, 60.3, 2700), lon_speed_m_s=2.0).raw(1023.5, b"#")
    said = on_board(name).play(stimuli.command(*every(33.3, 70.7, 2700), **COMMAND), 2700)
    assert set(modes(frames(said, 2200))) == {carla.Mode[after]}


@OF_THE_MODEL
@pytest.mark.parametrize(
    ("name", "after"),
    [("vehicle", "AUTOWARE"), pytest.param("vehicle-dies-on-error", "EMERGENCY", marks=WITH_THE_DEFECT)],
)
def test_a_framing_error(on_board, stimuli, name, after):
    stimuli.online(50.2).status(*every(50, 60.3, 2700), lon_speed_m_s=2.0).noise.append(1023.5)
    said = on_board(name).play(stimuli.command(*every(33.3, 70.7, 2700), **COMMAND), 2700)
    assert set(modes(frames(said, 2200))) == {carla.Mode[after]}


def test_a_frame_in_two_pieces(on_board, stimuli):
    data = carla.encode_status(carla.StatusFrame(lon_speed_m_s=4.0))
    stimuli.online(50.2).raw(100.3, data[:10]).raw(150.3, data[10:]).command(90.2, speed=1.0)
    said = on_board("vehicle").play(stimuli, 180)
    assert [report.longitudinal_velocity for _ms, report in messages(said, autoware.VelocityReport)] == [4.0]


@PLAYED
def test_the_joystick_at_its_pins(on_board, stimuli):
    in_manual(stimuli).status(*every(50, 1650.3, 4000))
    for ms, x, y in (
        (2000, 34_470, 34_080),
        (2200, 33_470, 33_080),
        (2400, 65_535, 65_535),
        (2600, 1057, 1062),
        (2800, 34_471, 0),
    ):
        stimuli.move(ms, x, y)
    said = on_board("vehicle").play(stimuli, 3000)
    at = {ms: frames(said, ms - 100, ms)[-1][1] for ms in (2000, 2200, 2400, 2600, 2800, 3000)}
    assert at[2000] == at[2200] == at[2400] == AT_REST
    assert (at[2600].steering, at[2600].speed, at[2600].acceleration) == (-1.0, 1.0, 0.0)
    assert (at[2800].steering, at[2800].speed, at[2800].acceleration) == (1.0, 0.0, 1.0)
    assert (at[3000].steering, at[3000].acceleration) == (pytest.approx(-1 / 31_065), 1.0)


def test_lamps(on_board, stimuli):
    left, off = autoware.TurnIndicators.ENABLE_LEFT, autoware.TurnIndicators.DISABLE
    stimuli.online(50.2).message(100.3, autoware.TurnIndicatorsCommand(command=left))
    stimuli.message(1200.3, autoware.HazardLightsCommand(command=autoware.HazardLights.ENABLE))
    stimuli.message(2000.3, autoware.HazardLightsCommand(command=autoware.HazardLights.DISABLE))
    stimuli.message(2050.3, autoware.TurnIndicatorsCommand(command=off))
    said = on_board("vehicle").play(stimuli, 2100)
    edges = {"left": [], "right": []}
    for one in said:
        if one.who == "light" and one.what[0] in edges and one.ms > 1:
            edges[one.what[0]].append((pytest.approx(one.ms, abs=TICK_MS), one.what[1]))
    together = [(1200.5, True), (1533.8, False), (1867.2, True)]
    alone = [(100.5, True), (433.8, False), (767.2, True), (1100.5, False)]
    assert edges["left"] == [*alone, *together, (2050.5, False)]
    assert edges["right"] == [*together, (2000.5, False)]


def hang(board, task):
    """The task waits for ever, for nothing: behind its stack pointer, link and priority stand state and wake tick."""
    memory = board.memory(task)
    struct.pack_into("<IIII", memory, 12, WAITING, 0, FOR_EVER, 0)


@pytest.mark.parametrize("task", few(["control", "driving_stack"], 1, "the other task"))
def test_a_task_that_hangs_is_noticed(on_board, stimuli, task):
    board = on_board("vehicle")
    board.machine.at_ns(400_000_000, lambda: hang(board, task))
    stimuli.online(50.2).status(*every(50, 60.3, 1000)).command(*every(33.3, 70.7, 1000), **COMMAND)
    board.play(stimuli, 1000)
    assert board.resets == ["POR", "IWDG"]


@pytest.mark.exhaustive("what the defect leads to; the gate shows that the watchdog notices")
def test_without_a_watchdog_nobody_notices(on_board, stimuli):
    board = on_board("vehicle-no-watchdog")
    board.machine.at_ns(400_000_000, lambda: hang(board, "control"))
    stimuli.online(50.2).status(*every(50, 60.3, 1000)).command(*every(33.3, 70.7, 1000), **COMMAND)
    assert frames(board.play(stimuli, 1100), 500) == []
    assert board.resets == ["POR"]


def test_it_sleeps_between(on_board, stimuli):
    board = on_board("vehicle")
    board.play(stimuli.online(50.2).status(*every(50, 60.3, 500)), 300.9)
    assert board.machine.asleep is not None
