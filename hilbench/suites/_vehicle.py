"""A vehicle-interface board under test, as the cases of `vehicle_board` see it: both its lines, somebody beside it.

A case brings the board into a mode, changes one thing and looks at frames and reports. Times are taken at the first
byte of each frame, so that the rate of a line drops out of every difference.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import TypeVar, cast

from hilbench.bench import Bench
from hilbench.bench.cases import CaseBase
from hilbench.bench.line_evidence import in_words
from hilbench.bench.line_peer import Received
from hilbench.check import CaseSetup, Untimely, Violation, at_most, case, near, try_members, within
from hilbench.clock import NS_PER_S
from hilbench.errors import InternalError
from hilbench.judging.provider import CaseBench
from hilbench.mcu.board_case import BoardCase
from hilbench.systems.vehicle.hands import VehicleBench, VehicleHands
from hilbench.systems.vehicle.on_board import VehicleOnBoard
from hilbench.systems.vehicle.simulator_peer import STATUS_HZ
from protocols.autoware import (
    AckermannControlCommand,
    AgentPing,
    ControlMode,
    ControlModeReport,
    SteeringReport,
    VelocityReport,
)
from protocols.carla import COMMAND_BYTES, CommandFrame, Mode, StatusFrame
from protocols.carla.clauses import BOARD_CLAUSES
from targets.robots.vehicle_interface import SIMULATOR_LINE

__all__ = [
    "COMMAND",
    "COMMAND_HZ",
    "COMMAND_MISS_S",
    "MISSES",
    "STATUS",
    "STATUS_HZ",
    "STATUS_MISS_S",
    "TICK_S",
    "Frame",
    "Vehicle",
    "on_board",
    "status_of",
    "vehicle_bench",
]

ReportT = TypeVar("ReportT")
StimulusT = TypeVar("StimulusT")
Frame = Received[CommandFrame]

_PROFILES = {clause.id: clause.profiles for clause in BOARD_CLAUSES}

COMMAND_HZ = 30.0
"""Autoware's trajectory follower (ctrl_period 0.03 s)."""

COMMAND = AckermannControlCommand(
    steering_tire_angle=0.5, steering_tire_rotation_rate=0.1, speed=5.0, acceleration=1.0, jerk=0.2
)
"""What F1 hands on."""

STATUS = StatusFrame(lon_speed_m_s=8.3333, lat_speed_m_s=-0.05, heading_rate_rad_s=0.1, steering_rad=-0.2)
"""F5."""

TICK_S = 0.0011
"""One tick of the board, 1 ms, and what it has to compute meanwhile: 0.1 ms (choice)."""

COMMAND_MISS_S = 0.110
STATUS_MISS_S = 0.100
MISSES = 10

MODE_WITHIN_S = 0.5
"""How long a mode that was asked for may take to show: the longest turn of the control task, 160 ms, and a few more."""

SPARE_S = 0.3
"""So much longer than it may take something is waited for, which tells late from never. A choice."""

NEAREST, FURTHEST = 1e-9, 1.04
"""Between these is what a joystick says that is not at rest: far less than a step of a 16-bit converter, for who takes
the mean of readings; what VB34 has, and some. Choices."""

EMERGENCY_WITHIN_S = 2.5
"""1.0 s in AUTOWARE, 1.6 s and a pause in MANUAL; a choice with room."""


def on_board(
    clause_id: str, *, lasts_s: float, noisy: bool = False
) -> Callable[[Callable[[Vehicle], None]], Callable[[CaseBench], None]]:
    """Declare the case of a clause, in each of its profiles; it gets the board as it is: power just on, or settled.

    Args:
        clause_id: the clause.
        lasts_s: how much bench time it takes.
        noisy: the board may say what is no frame; of all others it is required that it does not.
    """
    setups = {profile: CaseSetup(program=profile) for profile in _PROFILES[clause_id]}

    def declared(function: Callable[[Vehicle], None]) -> Callable[[CaseBench], None]:
        def judged(bench: CaseBench) -> None:
            vehicle = Vehicle(vehicle_bench(bench), cast("CaseBase", bench).case.seed)
            begun_ns = vehicle.bench.now_ns
            try:
                function(vehicle)
                if not noisy:
                    vehicle.require_nothing_between()
                    vehicle.require_manual_frames()
            except (AssertionError, Violation) as error:
                vehicle.excuse(error, begun_ns)
                raise

        # Not functools.wraps: pytest would follow it, and ask for what the function inside wants.
        judged.__name__, judged.__module__, judged.__doc__ = function.__name__, function.__module__, function.__doc__
        return case(clause_id, bench_time_s=lasts_s, setups=setups)(judged)

    return declared


def vehicle_bench(bench: CaseBench) -> VehicleBench:
    """Return the bench of a case as one with a vehicle-interface board."""
    return VehicleOnBoard(bench) if isinstance(bench, BoardCase) else cast("VehicleBench", bench)


class Vehicle:
    """See the module.

    Args:
        there: the bench.
        seed: of the case.

    Attributes:
        simulator: the checker's end of the simulator's line.
        stack: the checker's end of the driving stack's line.
        bench: whose time passes.
    """

    def __init__(self, there: VehicleBench, seed: int = 0) -> None:
        self._seed = seed
        self.simulator = there.simulator
        self.stack = there.stack
        self.bench: Bench = there.simulator.bench
        self._hands = there.hands
        self.simulator.status = STATUS
        self.stack.command = COMMAND

    def try_members(
        self, family: str, members: Sequence[tuple[str, StimulusT]], judge: Callable[[StimulusT], object], budget: int
    ) -> None:
        """Try members of a family of stimuli, drawn by the seed of the case."""
        try_members(family, members, judge, seed=self._seed, budget=budget)

    @property
    def hands(self) -> VehicleHands:
        """Who stands beside the board.

        Raises:
            InternalError: nobody does, and the case has not said that it needs somebody.
        """
        if self._hands is None:
            raise InternalError("the case needs somebody beside the board and has not said so")
        return self._hands

    def hold_joystick(self, x_count: int, y_count: int) -> None:
        """Hold the joystick there, if somebody stands beside the board: counts of its converter, 0 to 65535."""
        if self._hands is not None:
            self._hands.set_joystick(x_count, y_count)

    @property
    def light(self) -> str:
        """The one light that is on; several of them, or none, in words."""
        return " and ".join(sorted(self.hands.lights())) or "none"

    # --- bringing it somewhere

    def feed(self, *, status_hz: float | None = STATUS_HZ, command_hz: float | None = COMMAND_HZ) -> None:
        """Let statuses and commands come at these rates, from now on."""
        for feed, rate_hz in ((self.simulator.statuses, status_hz), (self.stack.commands, command_hz)):
            if rate_hz is None:
                feed.stop()
            else:
                feed.start(rate_hz)

    def autoware(self, *, status_hz: float = STATUS_HZ, command_hz: float = COMMAND_HZ) -> int:
        """Have the driving stack rule; return a mark behind which everything has its rhythm.

        Raises:
            Violation: it does not.
        """
        self.feed(status_hz=status_hz, command_hz=command_hz)
        mark = self.simulator.mark()
        self.run(MODE_WITHIN_S)
        if self.simulator.modes(mark)[-1:] != [Mode.AUTOWARE]:
            mark = self.simulator.mark()
            self.stack.request(ControlMode.AUTONOMOUS)
            self.wait_for(Mode.AUTOWARE, MODE_WITHIN_S, mark)
            self.run(MODE_WITHIN_S)
        return self.simulator.mark()

    def manual(self, *, status_hz: float = STATUS_HZ, command_hz: float | None = COMMAND_HZ) -> int:
        """Have the joystick rule; return a mark behind which everything has its rhythm.

        Raises:
            Violation: it does not.
        """
        self.feed(status_hz=status_hz, command_hz=command_hz)
        self.run(0.2)
        mark = self.simulator.mark()
        self.stack.request(ControlMode.MANUAL)
        self.wait_for(Mode.MANUAL, MODE_WITHIN_S, mark)
        self.run(5 / status_hz)
        return self.simulator.mark()

    def emergency(self) -> Frame:
        """Let statuses stop, from AUTOWARE; return the first frame of the emergency.

        Raises:
            Violation: none comes.
        """
        self.autoware()
        mark = self.simulator.mark()
        self.simulator.statuses.stop()
        return self.wait_for(Mode.EMERGENCY, EMERGENCY_WITHIN_S, mark)

    # --- time

    def excuse(self, error: AssertionError | Violation, since_ns: int) -> None:
        """Say of a fail that it is about time where the bench was so late that the board missed statuses, and said so.

        Raises:
            Untimely: so it was.
        """
        late_s = self.bench.lateness(since_ns).whole_ns / NS_PER_S
        if late_s > STATUS_MISS_S and not isinstance(error, Untimely):
            evidence = error.evidence if isinstance(error, Violation) else ()
            raise Untimely(str(error).partition("\n")[0], evidence, spare_s=STATUS_MISS_S) from error

    def run(self, duration_s: float) -> None:
        """Let bench time pass, in seconds."""
        self.simulator.run(duration_s)

    def uncertainty_s(self, since_ns: int) -> float:
        """Return how far off times may be over what happened since then."""
        return self.bench.uncertainty_s(since_ns)

    def since_s(self, since_ns: int, frame: Frame) -> float:
        """Return how long after a time a frame began."""
        return (frame.start_ns - self.byte_ns - since_ns) / NS_PER_S

    @property
    def byte_ns(self) -> int:
        """How long a byte takes on the simulator's line."""
        baud = self.simulator.port.baud
        return 10 * NS_PER_S // baud if baud else 0

    @property
    def started_ns(self) -> int:
        """When the board began to ping for an agent, the first thing that it does.

        Raises:
            Violation: it has not.
        """
        pings = self.stack.since(0, AgentPing)
        if not pings:
            raise Untimely("the board has not pinged for an agent", self.stack.evidence(0))
        baud = self.stack.port.baud
        return pings[0][0].start_ns - (10 * NS_PER_S // baud if baud else 0)

    @property
    def linked_ns(self) -> int:
        """When the way to the driving stack was there: with the first ping, or with the last object that it needs.

        Raises:
            Violation: the board has not pinged.
        """
        return self.started_ns if self.stack.made_ns is None else self.stack.made_ns

    # --- frames

    def shown(self, frames: Sequence[Frame]) -> Sequence[str]:
        """Return frames of the simulator's line as lines for a report."""
        return [in_words(got.at_ns, f"{SIMULATOR_LINE:9} <  {self.simulator.words_of(got)}") for got in frames]

    def mark(self) -> int:
        """Return a position in the frames of the simulator's line."""
        return self.simulator.mark()

    def frames(self, mark: int = 0) -> list[Frame]:
        """Return the frames since a mark."""
        return self.simulator.frames(mark)

    def wait_for(self, mode: int, within_s: float, mark: int) -> Frame:
        """Wait for a frame of a mode, since a mark.

        Raises:
            Violation: none comes.
        """

        def found() -> list[Frame]:
            return [got for got in self.frames(mark) if got.packet is not None and got.packet.mode == mode]

        begun_ns = self.bench.now_ns
        if not self.bench.run_until(lambda: bool(found()), within_s + SPARE_S):
            self.simulator.require_line()
            text = f"no frame of mode {mode} within {within_s:g} s"
            raise Untimely(text, self.shown(self.frames(mark)[-6:]), spare_s=SPARE_S)
        self._require_within(begun_ns, within_s, f"a frame of mode {mode} came after")
        return found()[0]

    def _require_within(self, begun_ns: int, within_s: float, what: str) -> None:
        """Require of what was waited for a little longer than it may take that it has come in time."""
        elapsed_s = (self.bench.now_ns - begun_ns) / NS_PER_S
        if elapsed_s > within_s:
            at_most(elapsed_s, within_s, unit="s", what=what, uncertainty=self.uncertainty_s(begun_ns))

    def require_modes(self, frames: Sequence[Frame], mode: int) -> None:
        """Require that all frames have a mode."""
        others = [got for got in frames if got.packet is not None and got.packet.mode != mode]
        if others:
            times = ", ".join(f"{got.start_ns / NS_PER_S:.4f}" for got in others[:5])
            text = f"{len(others)} of {len(frames)} frames have another mode than {mode}, at {times} s"
            raise Violation(text, self.shown(others[:6]))

    def require_steps(self, frames: Sequence[Frame], step_s: float, what: str, *, unprompted: bool = False) -> None:
        """Require that frames begin at a steady pace.

        Each step is judged, and all of them together: how far off the bench may be does not grow with their number.

        Args:
            frames: the frames.
            step_s: how far apart they begin, in seconds.
            what: what that is called in a report.
            unprompted: the board sends them by its own clock, because something does not come.

        Raises:
            Violation: they do not.
        """
        spans = [(before, after, 1) for before, after in pairwise(frames)]
        if len(spans) > 1:
            spans.append((frames[0], frames[-1], len(spans)))
        for first, last, count in spans:
            found_s, doubt_s = self.bench.span(first.start_ns, last.start_ns, unprompted=unprompted)
            name = what if count == 1 else f"{what}, {count} together"
            near(found_s, count * step_s, count * TICK_S, unit="s", what=name, uncertainty=doubt_s)

    def require_gap(self, first: Frame, second: Frame, least_s: float, most_s: float, what: str) -> None:
        """Require how far apart two frames begin, as far as the bench can tell."""
        gap_s, doubt_s = self.bench.span(first.start_ns, second.start_ns)
        within(gap_s, least_s, most_s, unit="s", what=what, uncertainty=doubt_s)

    def require_count(
        self, found: int, wanted: int, tolerance: float, *, what: str, since_ns: int, rate_hz: float
    ) -> None:
        """Require how many frames came that come at a rate; a bench that is late may have made them more or fewer."""
        doubt = self.uncertainty_s(since_ns) * rate_hz
        near(found, wanted, tolerance, unit="frames", what=what, uncertainty=doubt)

    def require_frame(self, got: Frame, wanted: CommandFrame, what: str, off: float = 0.0) -> None:
        """Require what a frame says, as far as floats of 32 bits tell, which have a 0, or so far off at most."""
        assert got.packet is not None
        for name in ("steering", "steering_rate", "speed", "acceleration", "jerk", "mode"):
            found, value = getattr(got.packet, name), getattr(wanted, name)
            if not abs(found - value) <= max(off, 1e-6 * abs(value)):
                raise Violation(f"{what}: {name} is {found:g}, required {value:g}", self.shown([got]))

    def require_nothing_between(self) -> None:
        """Require that behind each frame stands its NUL, and nothing but that between frames.

        Raises:
            Violation: something does, or a NUL is missing.
        """
        peer = self.simulator
        if peer.dropped:
            between = peer.dropped[0].data[:COMMAND_BYTES].hex(" ").upper()
            text = f"{between} is between the frames of {COMMAND_BYTES} bytes"
            raise Violation(text, self.shown(self.frames()[:3]))
        count = len(self.frames())
        if peer.paddings < count - 1:  # that of the last one may be on its way
            raise Violation(f"{peer.paddings} NULs follow {count} frames", self.shown(self.frames()[-3:]))

    def require_manual_frames(self) -> None:
        """Require that each frame of MANUAL says what a joystick can, wherever somebody holds it.

        Raises:
            Violation: W or J is not 0, V or A is below 0, both are above, or one of S, V, A is what no reading makes.
        """
        for got in self.frames():
            said = got.packet
            if said is None or said.mode != Mode.MANUAL:
                continue
            stick = (said.steering, said.speed, said.acceleration)
            known = all(value == 0 or NEAREST <= abs(value) <= FURTHEST for value in stick)
            one_way = min(said.speed, said.acceleration) == 0
            if not (known and one_way and said.steering_rate == said.jerk == 0):
                text = "a frame of mode 4 says what no joystick does: S, V, A, W, J are "
                found = (*stick, said.steering_rate, said.jerk)
                raise Violation(text + ", ".join(f"{value:g}" for value in found), self.shown([got]))

    # --- statuses and reports

    def say(self, status: StatusFrame, wait_s: float = 0.0) -> None:
        """Say one status, by hand, and let time pass."""
        self.simulator.send_status(status)
        self.run(wait_s)

    def reports(self, mark: int, kind: type[ReportT]) -> list[ReportT]:
        """Return the reports of a kind since a mark of the driving stack's line."""
        return [report for _, report in self.stack.since(mark, kind)]

    def speeds(self, mark: int) -> list[float]:
        """Return the longitudinal speeds reported since a mark of the driving stack's line."""
        return [report.longitudinal_velocity for report in self.reports(mark, VelocityReport)]

    def steerings(self, mark: int) -> list[float]:
        """Return the tyre angles reported since a mark of the driving stack's line."""
        return [report.steering_tire_angle for report in self.reports(mark, SteeringReport)]

    def require_reported(self, status: StatusFrame, mark: int, within_s: float = MODE_WITHIN_S) -> None:
        """Require that all four figures of a status are reported, since a mark of the driving stack's line.

        Raises:
            Violation: they are not.
        """
        figures = (status.lon_speed_m_s, status.lat_speed_m_s, status.heading_rate_rad_s)

        def reported() -> bool:
            velocities = self.reports(mark, VelocityReport)
            reported = [(one.longitudinal_velocity, one.lateral_velocity, one.heading_rate) for one in velocities]
            steered = any(_same(angle, status.steering_rad) for angle in self.steerings(mark))
            return steered and any(all(map(_same, three, figures)) for three in reported)

        begun_ns = self.bench.now_ns
        wanted = ", ".join(f"{value:g}" for value in (*figures, status.steering_rad))
        if not self.bench.run_until(reported, within_s + SPARE_S):
            text = f"speeds, heading rate and steering of {wanted} are not reported within {within_s:g} s"
            raise Untimely(text, self.stack.evidence(mark), spare_s=SPARE_S)
        self._require_within(begun_ns, within_s, f"speeds, heading rate and steering of {wanted} were reported after")

    def modes_reported(self, mark: int) -> list[int]:
        """Return the modes of the control-mode reports since a mark of the driving stack's line."""
        return [report.mode for report in self.reports(mark, ControlModeReport)]

    def other_status(self, speed_m_s: float) -> StatusFrame:
        """Return a status with another speed, from which its other figures follow, and let it be the usual one."""
        self.simulator.status = status_of(speed_m_s)
        return self.simulator.status


def status_of(speed_m_s: float) -> StatusFrame:
    """Return a status with this speed, from which its other figures follow."""
    return StatusFrame(
        lon_speed_m_s=speed_m_s,
        lat_speed_m_s=-speed_m_s / 20,
        heading_rate_rad_s=speed_m_s / 50,
        steering_rad=-speed_m_s / 60,
    )


def _same(found: float, wanted: float) -> bool:
    """Say whether two figures are the same, as far as floats of 32 bits tell."""
    return abs(found - wanted) <= 1e-6 * max(1.0, abs(wanted))
