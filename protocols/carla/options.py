"""What both roles can be set to; each choice between sources that disagree names them.

The sources, in short: *V0* is the board's firmware of November 2024, toffanetto/im420x
project/ws/nucleo-H753ZI_TemplateAutoware_Serial; *V1* that of January 2025, LMA-FEM-UNICAMP/microAutoware; *bridge* the
simulator's side, LMA-FEM-UNICAMP/carla_serial_bridge; *report* the course report of toffanetto/im420x. The defaults are
those of the profile `hardened`, which is ours: what it does beside the original is a choice. Times are in seconds of
bench time here, for people; the connection counts in integer nanoseconds.
"""

from __future__ import annotations

import enum
from dataclasses import dataclass, field

from protocols.carla.errors import LocalProtocolError
from protocols.carla.joystick import X_AXIS, Y_AXIS, Axis
from protocols.carla.messages import STEERING_FACTOR
from protocols.carla.states import DEADLINES
from protocols.common.options import check_positive

__all__ = [
    "BoardOptions",
    "BoardReader",
    "CommandLimits",
    "EmergencyReport",
    "MissedCommand",
    "PollOptions",
    "SimulatorOptions",
    "SimulatorReader",
    "StatusLimits",
]


class BoardReader(enum.Enum):
    """How the board finds statuses in its bytes."""

    BLOCKS = "blocks of 22 bytes as they come, each read from its start; a stray byte shifts all later ones (V0, V1)"
    STREAM = "a frame begins at any #, and what fails is searched again (choice)"


class SimulatorReader(enum.Enum):
    """How the simulator finds commands in its bytes."""

    POLL = "at most 30 bytes each 20 ms into a buffer that keeps what was there, always read from its start (bridge)"
    STREAM = "a frame begins at any #, and what fails is searched again (choice)"


class MissedCommand(enum.Enum):
    """What is sent when no command came in time."""

    AGAIN = "the bytes before, moving or not (V0, V1)"
    STOP = "the steering of the command before, rate, speed, acceleration and jerk 0; nothing before the first (choice)"


class EmergencyReport(enum.Enum):
    """The mode that the driving stack is told in EMERGENCY."""

    KEPT = "that of before: the flag is not in the mask that is waited for (V0)"
    MANUAL = "4, MANUAL (V1)"
    NOT_READY = "6, NOT_READY of ControlModeReport (choice)"


@dataclass(frozen=True, slots=True, kw_only=True)
class StatusLimits:
    """What a status can be true with; beyond it is taken for damaged. All assumed, far beyond what a car does.

    Attributes:
        speed_m_s: the largest longitudinal or lateral speed.
        heading_rate_rad_s: the largest heading rate.
        steering_rad: the largest angle of the tyre; CARLA's largest is 69.99 degrees, 1.22 rad.
    """

    speed_m_s: float = 150.0
    heading_rate_rad_s: float = 20.0
    steering_rad: float = 2.0

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("speed_m_s", "heading_rate_rad_s", "steering_rad"))


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandLimits:
    """What a command can be meant with; beyond it is taken for damaged. All assumed, far beyond what a car does.

    Attributes:
        steering_rad: the largest angle of the tyre, times 1.2.
        steering_rate_rad_s: the largest rate of it, times 1.2.
        speed_m_s: the largest speed.
        acceleration_m_s2: the largest acceleration.
        jerk_m_s3: the largest jerk.
        manual: the largest value of steer, throttle and brake; what is less but beyond their range is clamped.
    """

    steering_rad: float = 2.5
    steering_rate_rad_s: float = 50.0
    speed_m_s: float = 150.0
    acceleration_m_s2: float = 100.0
    jerk_m_s3: float = 1000.0
    manual: float = 10.0

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("steering_rad", "steering_rate_rad_s", "speed_m_s", "manual"))
        check_positive(LocalProtocolError, self, ("acceleration_m_s2", "jerk_m_s3"))


@dataclass(frozen=True, slots=True, kw_only=True)
class BoardOptions:
    """The board. The defaults are those of the profile `hardened`.

    Attributes:
        reader: see `BoardReader`.
        frame_timeout_s: STREAM: an unfinished status is given up this long after its first byte (choice: one status
            deadline); None for never.
        finite_only: a NaN or an infinity, in a status or a command, is dropped and counted (choice).
        status_limits: a status beyond them is dropped and counted; None for any (V0, V1).
        command_limits: the same for commands of the driving stack, after the factor.
        dies_on_line_error: an overrun or framing error ends reception until reset (V0, V1: ST's HAL aborts the DMA, and
            there is no HAL_UART_ErrorCallback that starts it again; from reading, not measured).
        agent_wait_s: see `DEADLINES`.
        command_deadline_s: see `DEADLINES`.
        status_deadline_s: see `DEADLINES`.
        manual_pause_s: see `DEADLINES`.
        debounce_s: see `DEADLINES`.
        misses: how many deadlines in a row until the mode changes.
        missed_command: see `MissedCommand`.
        uninitialised: missed commands before the first one send the buffer as it is after boot, see
            `UNINITIALISED_FRAME` (V0, V1).
        shared_action: commands, joystick and emergency write into one structure, and the flag that says that a command
            is in it outlives the mode: back in AUTOWARE the first frame may be the joystick's (V0, V1).
        fresh_only: a status or command that waited longer than its deadline is no answer any more (choice).
        watch_while_waiting: statuses are taken, and their absence counted, at each missed command too; V0 and V1 do not
            supervise the simulator then.
        requests_in_emergency: the driving stack can order a mode in EMERGENCY (V0, V1; not in the report's diagram).
        both_to_manual: of two requests at once MANUAL is taken; that branch of V0 and V1 cannot be reached.
        republish_stale: at each missed status the old one is reported again (V0, V1).
        flag_clash: in MANUAL the wait for a status waits for the flag that requests AUTOWARE from the micro-ROS
            task (V1: osEventFlagsWait with UART_NEW_DATA_FLAG, 0b10, which is MA_TO_AUTOWARE_MODE_FLAG there).
        own_mode: the micro-ROS task keeps a mode of its own, hands commands on by it and reports it (V0, V1).
        emergency_report: see `EmergencyReport`.
        late_agent: an agent that comes late, or comes back, is heard (choice); otherwise only at boot (V0, V1).
        agent_silence_s: without a sign of the driving stack for this long it counts as lost: AUTOWARE ends, a press
            does not lead there (choice); None: not watched (V0, V1).
        clamp_joystick: positions beyond the calibration are kept within -1..1 (choice).
        x_axis: the calibration of X.
        y_axis: the calibration of Y.
        steering_factor: see `STEERING_FACTOR`.
        mode_report_s: how often the mode is reported; choice: the original does it in each loop of its micro-ROS task,
            of at most 80 ms.
    """

    reader: BoardReader = BoardReader.STREAM
    frame_timeout_s: float | None = 0.1
    finite_only: bool = True
    status_limits: StatusLimits | None = field(default_factory=StatusLimits)
    command_limits: CommandLimits | None = field(default_factory=CommandLimits)
    dies_on_line_error: bool = False
    agent_wait_s: float = DEADLINES["agent_wait_s"].value_s
    command_deadline_s: float = DEADLINES["command_deadline_s"].value_s
    status_deadline_s: float = DEADLINES["status_deadline_s"].value_s
    manual_pause_s: float = DEADLINES["manual_pause_s"].value_s
    debounce_s: float = DEADLINES["debounce_s"].value_s
    misses: int = DEADLINES["status_deadline_s"].misses
    missed_command: MissedCommand = MissedCommand.STOP
    uninitialised: bool = False
    shared_action: bool = False
    fresh_only: bool = True
    watch_while_waiting: bool = True
    requests_in_emergency: bool = False
    both_to_manual: bool = True
    republish_stale: bool = False
    flag_clash: bool = False
    own_mode: bool = False
    emergency_report: EmergencyReport = EmergencyReport.NOT_READY
    late_agent: bool = True
    agent_silence_s: float | None = 3.0
    clamp_joystick: bool = True
    x_axis: Axis = X_AXIS
    y_axis: Axis = Y_AXIS
    steering_factor: float = STEERING_FACTOR
    mode_report_s: float = 0.1

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, tuple(DEADLINES))
        check_positive(LocalProtocolError, self, ("misses", "frame_timeout_s", "agent_silence_s", "mode_report_s"))
        if self.flag_clash and not self.own_mode:
            raise LocalProtocolError("flag_clash needs own_mode: it is the micro-ROS task's flag that is eaten")


@dataclass(frozen=True, slots=True, kw_only=True)
class PollOptions:
    """A receiver that reads at fixed times (bridge: carla_serial_bridge_node.cpp `timer_callback`, serial_com.hpp).

    Attributes:
        period_s: how often: 20 ms, a wall timer.
        bytes_each: the most it reads at once, and what its buffer holds.
        gather_s: how long the adapter keeps bytes from their first until it hands them on together; assumed 1 ms, the
            least that an FT232R can be set to; it starts with 16 ms.
    """

    period_s: float = 0.020
    bytes_each: int = 30
    gather_s: float = 0.001

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("period_s", "bytes_each", "gather_s"))


@dataclass(frozen=True, slots=True, kw_only=True)
class SimulatorOptions:
    """The simulator's side. The defaults are those of the profile `hardened`.

    Attributes:
        reader: see `SimulatorReader`.
        poll: the figures of POLL, and of STREAM where reads wait.
        idle_block_s: reads are made at the times of `poll`, and one that finds nothing waits this long for a byte, and
            the one thread with it, also for what it has to send (bridge: 0.5 s, termios VMIN 0, VTIME 5); None: nothing
            waits.
        icrnl: a carriage return is read as a newline (bridge: termios keeps ICRNL, which Linux has by default).
        frame_timeout_s: STREAM: an unfinished command is given up this long after its first byte (choice); None: never.
        finite_only: a command with a NaN or an infinity is dropped and counted (choice).
        limits: a command beyond them is dropped and counted; None for any (bridge).
        clamp_manual: steer is kept within -1..1, throttle and brake within 0..1 (choice; the bridge hands on anything).
        silence_s: without a sound command for this long, after the first, the car is commanded to stop, once; choice:
            two deadlines of the board and a pause, with room; None: never (bridge).
        forget_mode: sending a status sets the mode variable to 0, so that a frame without M is an emergency with the
            values of before (bridge: `send_to_microautoware`).
    """

    reader: SimulatorReader = SimulatorReader.STREAM
    poll: PollOptions = field(default_factory=PollOptions)
    idle_block_s: float | None = None
    icrnl: bool = False
    frame_timeout_s: float | None = 0.1
    finite_only: bool = True
    limits: CommandLimits | None = field(default_factory=CommandLimits)
    clamp_manual: bool = True
    silence_s: float | None = 0.5
    forget_mode: bool = False

    def __post_init__(self) -> None:
        """Checks the figures; LocalProtocolError names the wrong one."""
        check_positive(LocalProtocolError, self, ("idle_block_s", "frame_timeout_s", "silence_s"))
