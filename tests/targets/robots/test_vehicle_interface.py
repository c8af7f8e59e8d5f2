"""The vehicle-interface board as a device at two lines: what passes from one to the other, what is beside them."""

from __future__ import annotations

import pytest

from protocols import autoware
from protocols.autoware import (
    AckermannControlCommand,
    AgentOnline,
    AgentPing,
    Clock,
    ControlModeReport,
    ControlModeRequest,
    ControlModeResponse,
    FrameReader,
    HazardLights,
    HazardLightsCommand,
    HazardLightsReport,
    SteeringReport,
    Time,
    TurnIndicators,
    TurnIndicatorsCommand,
    TurnIndicatorsReport,
    VelocityReport,
    decode_message,
    encode_frame,
    encode_message,
)
from protocols.carla import PROFILES, VECTORS, LocalProtocolError, Mode, decode_command
from targets.robots.vehicle_interface import (
    BEHAVIOURS,
    DEFECTS,
    PROFILE_NAMES,
    SIMULATOR_LINE,
    STACK_LINE,
    VehicleInterface,
    VehicleSettings,
)

MS = 1_000_000
F5 = VECTORS["F5"].data
COMMAND = AckermannControlCommand(speed=5.0)


class Board:
    """A board, and what it has put on its lines."""

    def __init__(self, **settings):
        self.board = VehicleInterface(VehicleSettings(**settings))
        self.now_ns = 0
        self.lines = {SIMULATOR_LINE: b"", STACK_LINE: b""}
        self.keep(self.board.advance(0))

    def keep(self, sent):
        for line, data in sent:
            self.lines[line] += data

    def run(self, ms):
        self.now_ns += round(ms * MS)
        self.keep(self.board.advance(self.now_ns))

    def live(self, ms):
        """Let time pass with statuses and commands at 20 Hz."""
        for _ in range(round(ms / 50)):
            self.tell(COMMAND)
            self.status()
            self.run(50)

    def status(self, data=F5):
        self.keep(self.board.receive(SIMULATOR_LINE, data, self.now_ns))

    def tell(self, message):
        frame = encode_frame(encode_message(message))
        self.keep(self.board.receive(STACK_LINE, frame, self.now_ns))

    def frames(self):
        data, self.lines[SIMULATOR_LINE] = self.lines[SIMULATOR_LINE], b""
        return [decode_command(data[at : at + 30]) for at in range(0, len(data), 30)]

    def told(self, kind):
        messages = [decode_message(frame.payload) for frame in FrameReader().receive(self.lines[STACK_LINE])]
        return [message for message in messages if isinstance(message, kind)]

    def press(self):
        self.keep(self.board.press(self.now_ns))


@pytest.fixture
def board():
    made = Board()
    made.tell(AgentOnline())
    return made


def test_a_command_goes_to_the_simulator_and_a_status_to_the_stack(board):
    board.tell(Clock(clock=Time(7, 8)))
    board.tell(COMMAND)
    board.status()
    assert [frame.mode for frame in board.frames()] == [Mode.AUTOWARE]
    (velocity,) = board.told(VelocityReport)
    assert velocity.stamp == Time(7, 8)
    assert velocity.longitudinal_velocity == pytest.approx(8.3333)
    assert velocity.heading_rate == pytest.approx(0.1)
    assert board.told(SteeringReport)[0].steering_tire_angle == pytest.approx(-0.2)
    assert board.board.light == "amber"


def test_it_pings_for_an_agent_and_then_leaves_it(board):
    silent = Board()
    silent.run(21_000)
    assert len(silent.told(AgentPing)) == 20
    assert silent.board.simulator.mode is Mode.MANUAL
    assert silent.board.light == "green"
    assert len(board.told(AgentPing)) == 1


def test_an_answer_has_the_number_of_its_request(board):
    for sequence, mode in ((5, 4), (6, 2)):
        board.tell(ControlModeRequest(sequence=sequence, mode=mode))
    answers = [(answer.sequence, answer.success) for answer in board.told(ControlModeResponse)]
    assert answers == [(5, True), (6, False)]


def test_the_joystick(board):
    board.tell(ControlModeRequest(mode=4))
    board.run(200)
    board.keep(board.board.set_joystick(65_535, 65_535, board.now_ns))
    board.frames()
    board.run(200)
    assert {(frame.steering, frame.speed, frame.mode) for frame in board.frames()} == {(-1.0, 1.0, Mode.MANUAL)}
    with pytest.raises(LocalProtocolError):
        board.board.set_joystick(65_536, 0, board.now_ns)


def test_a_press_changes_the_mode(board):
    board.live(1100)
    assert board.board.simulator.mode is Mode.AUTOWARE
    board.press()
    board.live(200)
    assert board.board.simulator.mode is Mode.MANUAL


def test_lamps_are_commanded_reported_and_blink(board):
    board.tell(TurnIndicatorsCommand(command=TurnIndicators.ENABLE_LEFT))
    board.tell(TurnIndicatorsCommand(command=TurnIndicators.NO_COMMAND))
    board.tell(COMMAND)
    board.status()
    assert board.told(TurnIndicatorsReport)[0].report == TurnIndicators.ENABLE_LEFT
    assert board.told(HazardLightsReport)[0].report == HazardLights.DISABLE
    lit = [board.board.lit_lamps(ms * MS) for ms in range(0, 2000, 10)]
    assert {right for _, right in lit} == {False}
    assert sum(left for left, _ in lit) == pytest.approx(100, abs=7)
    board.tell(HazardLightsCommand(command=HazardLights.ENABLE))
    assert board.board.lit_lamps(board.now_ns) == (True, True)


def test_without_the_lamps_nothing_of_them_is_said():
    board = Board(profile="v0")
    board.tell(AgentOnline())
    board.tell(HazardLightsCommand(command=HazardLights.ENABLE))
    board.tell(COMMAND)
    board.status()
    assert board.told(VelocityReport)
    assert not board.told(HazardLightsReport)
    assert board.board.lit_lamps(board.now_ns) == (False, False)


def test_reset_forgets_everything(board):
    board.tell(COMMAND)
    board.run(500)
    board.frames()
    board.keep(board.board.reset(board.now_ns))
    assert board.board.light == ""
    assert board.board.stack.state is autoware.BoardState.SEEKING
    board.run(200)
    assert board.frames() == []


def test_nobody_listens_while_it_boots():
    board = Board(boot_s=0.5)
    board.tell(AgentOnline())
    board.press()
    board.run(600)
    assert board.board.stack.state is autoware.BoardState.SEEKING
    assert len(board.told(AgentPing)) == 1


def test_a_line_that_goes_down_is_not_noticed(board):
    board.keep(board.board.line_down(SIMULATOR_LINE, board.now_ns))
    board.tell(COMMAND)
    assert len(board.frames()) == 1


def test_a_late_agent_is_a_sign_of_life_only_where_it_is_heard(board):
    board.run(5_000)
    assert not board.board.simulator.agent_online
    board.tell(AgentOnline())
    assert board.board.simulator.agent_online
    shipped = Board(profile="v0")
    shipped.run(25_000)
    shipped.tell(AgentOnline())
    assert not shipped.board.simulator.agent_online


def test_frames_without_their_nul():
    board = Board(defects=("no-padding",))
    board.tell(AgentOnline())
    board.tell(COMMAND)
    assert len(board.lines[SIMULATOR_LINE]) == 29


def test_profiles_and_defects():
    assert {*PROFILE_NAMES} == {*PROFILES} == {*BEHAVIOURS}
    assert len(DEFECTS) >= 12
    assert {"H1", "H2", "H6", "H7", "H8", "H9", "V1"} <= {*DEFECTS}
    hardened = BEHAVIOURS["hardened"]
    for defect in DEFECTS.values():
        assert defect.text
        assert defect.source
        assert defect.put_into(hardened) != hardened
    with pytest.raises(ValueError, match="defects has 'H10', which is none; there are"):
        VehicleSettings(defects=("H10",))
    with pytest.raises(ValueError, match=r"boot_s 61 is not 0\.\.60 s"):
        VehicleSettings(boot_s=61)


def test_reports_of_the_mode_come_by_themselves(board):
    board.run(1000)
    assert len(board.told(ControlModeReport)) == pytest.approx(10, abs=1)


def test_a_board_that_hangs_is_reset_by_its_watchdog(board):
    board.live(500)
    board.keep(board.board.hang(board.now_ns))
    board.frames()
    board.keep(board.board.set_joystick(65_535, 33_580, board.now_ns))
    board.press()
    board.keep(board.board.line_error(board.now_ns))
    lamps = board.board.lit_lamps(board.now_ns)
    board.live(450)
    assert board.frames() == []
    assert board.board.lit_lamps(board.now_ns) == lamps
    board.run(51)
    assert board.told(AgentPing)[-1:] == [AgentPing()]
    board.tell(AgentOnline())
    board.live(200)
    assert {frame.mode for frame in board.frames()} == {Mode.AUTOWARE}


def test_without_a_watchdog_it_hangs_until_somebody_resets_it():
    board = Board(defects=("no-watchdog",))
    board.tell(AgentOnline())
    board.live(200)
    board.keep(board.board.hang(board.now_ns))
    board.frames()
    board.live(3000)
    assert board.frames() == []
    board.keep(board.board.reset(board.now_ns))
    board.tell(AgentOnline())
    board.live(200)
    assert board.frames()


def test_the_switch_does_nothing_as_it_closes(board):
    board.live(1500)
    board.keep(board.board.hold(board.now_ns))
    board.live(200)
    assert {frame.mode for frame in board.frames()} == {Mode.AUTOWARE}
    board.press()
    board.live(200)
    assert board.frames()[-1].mode == Mode.MANUAL
