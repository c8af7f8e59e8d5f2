"""A rover under test, as the cases of `pkt_board` see it: bytes out, reports and counters in, somebody beside it.

The state is what the general report says, held against what it said before the case: a rover that somebody else runs
cannot be switched off and on between cases.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeVar, cast

from hilbench.check import CaseSetup, Inconclusive, Untimely, Violation, at_most, case, near, try_members
from hilbench.clock import NS_PER_S
from hilbench.errors import InternalError
from hilbench.judging.provider import CaseBench
from hilbench.judging.recorder import unrecorded
from hilbench.mcu.board_case import BoardCase
from hilbench.systems.rover.hands import RoverBench, RoverHands, RoverOnBoard
from protocols.pkt import (
    PROFILES,
    Command,
    ExecutionReport,
    GeneralReport,
    LedOff,
    MotionReport,
    MotorSpeeds,
    MotorThrottles,
    ReportId,
    RequestTelemetry,
    Schema,
)
from protocols.pkt.clauses import BOARD_CLAUSES

__all__ = ["Counts", "Rover", "at_power_up", "on_rover", "rover_bench"]

GivenT = TypeVar("GivenT")
ReportT = TypeVar("ReportT")
StimulusT = TypeVar("StimulusT")

_PROFILES = {clause.id: clause.profiles for clause in BOARD_CLAUSES}

DONE_S = 0.05
"""How long a rover has for a frame, behind its last byte: five turns of its loop. A choice."""

LINK_S = 1.0
"""After so long a silence a rover that watches its link takes it for lost (P24D)."""

EVER_LATER = "the bench gets later and later, so answers cannot be assigned to requests"

ANSWER_S = 2.0
"""How long a case waits for the counters."""

PERIODIC_WITHIN_S = 1.2
"""The slowest of the published firmwares says 0x80 once a second."""

REPORT_S = 0.3
"""How long a case waits for a report that comes four times a second."""

OTHER_REPORTS = 113
"""Bytes of one of each other report: 0x80, 0x81, 0x82, 0x84."""

MOTION_AND_COMMAND = 78
"""Bytes of a 0x83 and of a motor command."""

JUST_AFTER_S = 0.02
"""How much later than the motors must stand a 0x83 begins that shows whether they do. A choice: two turns of a loop."""


def on_rover(clause_id: str, *, lasts_s: float) -> Callable[[Callable[[Rover], None]], Callable[[CaseBench], None]]:
    """Declare the case of a clause, in each of its profiles; it gets the rover, which answers."""
    return _declared(clause_id, lasts_s, Rover)


def at_power_up(
    clause_id: str, *, lasts_s: float
) -> Callable[[Callable[[RoverBench], None]], Callable[[CaseBench], None]]:
    """Declare the case of a clause, in each of its profiles; it gets the bench of the rover, power just on."""
    return _declared(clause_id, lasts_s, lambda there: there)


def _declared(
    clause_id: str, lasts_s: float, give: Callable[[RoverBench], GivenT]
) -> Callable[[Callable[[GivenT], None]], Callable[[CaseBench], None]]:
    setups = {profile: CaseSetup(program=profile) for profile in _PROFILES[clause_id]}

    def declared(function: Callable[[GivenT], None]) -> Callable[[CaseBench], None]:
        def judged(bench: CaseBench) -> None:
            function(give(rover_bench(bench)))

        # Not functools.wraps: pytest would follow it, and ask for what the function inside wants.
        judged.__name__, judged.__module__, judged.__doc__ = function.__name__, function.__module__, function.__doc__
        return case(clause_id, bench_time_s=lasts_s, setups=setups)(judged)

    return declared


def rover_bench(bench: CaseBench) -> RoverBench:
    """Return the bench of a case as one with a rover."""
    if isinstance(bench, BoardCase):
        return RoverOnBoard(bench, PROFILES[bench.case.setup.program or "documented"])
    return cast("RoverBench", bench)


@dataclass(frozen=True, slots=True)
class Counts:
    """What a case has made of the rover's counters.

    Attributes:
        accepted: packets accepted since the case began.
        rejected: packets rejected since then.
        opcode: LAST_OPCODE.
        error: LAST_ERROR.
    """

    accepted: int
    rejected: int
    opcode: int
    error: int

    def __str__(self) -> str:
        return f"{self.accepted}/{self.rejected}/{self.opcode:X}/{self.error}"


class Rover:
    """See the module.

    Args:
        bench: of the case.

    Attributes:
        peer: the checker's end of the line.
        before: what the general report said when the case began.
        reopen: closes the line for some seconds and opens it again, where the bench can.
        v2: the rover speaks the last schema: throttles, reports of its motion.
    """

    def __init__(self, bench: RoverBench) -> None:
        self._hands = bench.hands
        self._seed = bench.case.seed
        self.reopen = bench.reopen
        self.peer = bench.peer
        self.schema = self.peer.profile.server.schema
        self.v2 = self.schema is Schema.V2
        if not self.peer.wait_ready():
            text = f"the rover does not answer REQUEST_TMY{self.peer.refused()}"
            raise Untimely(text, self.peer.evidence(), spare_s=ANSWER_S)
        self.before = self._general()

    def try_members(
        self, family: str, members: Sequence[tuple[str, StimulusT]], judge: Callable[[StimulusT], object], budget: int
    ) -> None:
        """Try members of a family of stimuli, drawn by the seed of the case."""
        try_members(family, members, judge, seed=self._seed, budget=budget)

    # --- beside the line

    @property
    def hands(self) -> RoverHands:
        """Who stands beside the rover.

        Raises:
            InternalError: nobody does, and the case has not said that it needs somebody.
        """
        if self._hands is None:
            raise InternalError("the case needs somebody beside the rover and has not said so")
        return self._hands

    def can(self, name: str) -> bool:
        """Say whether somebody beside the rover does and sees what has this name among the needs of clauses."""
        return self._hands is not None and name in self._hands.can

    @property
    def lit(self) -> bool:
        """The test LED is on."""
        return self.hands.led_is_lit()

    def require_lit(self) -> None:
        """Require that the test LED is on, if anybody can see it."""
        assert not self.can("led") or self.lit, "the LED is off: an accepted LED_ON was not executed"

    def require_dark(self) -> None:
        """Require that the test LED is off, if anybody can see it."""
        assert not self.can("led") or not self.lit, "the LED is on: a rejected frame was executed"

    @property
    def seen(self) -> bool:
        """Somebody sees what reaches the motors; else there is only what the rover itself says of them."""
        return self.can("duty")

    @property
    def duties(self) -> tuple[float, float]:
        """What reaches the motors; where nobody sees that, the throttles of a 0x83 that begins later than now."""
        return self.hands.duties() if self.seen else self.motion().throttles

    @property
    def runs(self) -> bool:
        """Both pairs run; in one of three 0x83 where nobody sees them, for a speed controller may pass through 0."""
        return all(self.duties) if self.seen else any(all(self.duties) for _ in range(3))

    def require_shown(self) -> None:
        """Require of motors that were commanded and that nobody sees that the rover says they run.

        Raises:
            Inconclusive: it does not, so that what it says later tells nothing.
        """
        if not self.seen and not self.runs:
            raise Inconclusive("0x83 does not show the throttles that were commanded", self.peer.evidence())

    def hold_wheels(self) -> None:
        """Hold all wheels, if somebody is there."""
        if self.held:
            self.hands.hold_wheels(True)

    @property
    def held(self) -> bool:
        """Somebody is there who holds the wheels when that is asked for."""
        return self.can("wheels")

    # --- bytes out

    def write(self, data: bytes) -> None:
        """Put bytes on the line, and give the rover the time to take them, also where they were handed over late."""
        sent_ns = self.peer.bench.now_ns
        self.peer.write(data)
        self.peer.run(self.peer.line_s(len(data)) + DONE_S)
        if late_s := self.peer.uncertainty_s(sent_ns):
            self.peer.run(late_s)

    def send(self, command: Command) -> None:
        """As `write`, with a command."""
        self.write(self.peer.frame_of(command))

    def dark(self) -> None:
        """Switch the test LED off, and take what that does to the counters for the beginning."""
        self.send(LedOff())
        self.before = self._general()
        if self.can("led") and self.lit:
            raise Inconclusive("the LED does not go out", self.peer.evidence())

    def drive(self, left: float, right: float) -> None:
        """Command shares of full throttle, in whichever schema."""
        if self.v2:
            self.send(MotorThrottles(a=left, b=right))
        else:
            self.send(MotorSpeeds(a=round(left * 255), b=round(right * 255)))

    def keep_alive(self, duration_s: float, every_s: float = 0.5) -> None:
        """Let time pass while a REQUEST_TMY each `every_s` seconds keeps the link up."""
        begin_ns = self.peer.bench.now_ns
        end_ns = begin_ns + round(duration_s * NS_PER_S)
        while self.peer.bench.now_ns < end_ns:
            self.peer.send(RequestTelemetry())
            self.peer.run(min(every_s, (end_ns - self.peer.bench.now_ns) / NS_PER_S))
        self.peer.require_punctual(begin_ns, LINK_S - every_s, "the link may have been lost")

    # --- what it says

    @property
    def counts(self) -> Counts:
        """What the case has made of the counters, as the rover says now."""
        return self.counts_in(self._general())

    def counts_in(self, now: GeneralReport) -> Counts:
        """What the case has made of the counters, by this report."""
        return Counts(
            accepted=(now.accepted - self.before.accepted) % 256,
            rejected=(now.rejected - self.before.rejected) % 256,
            opcode=now.last_opcode,
            error=now.last_error,
        )

    def require(
        self, accepted: int, rejected: int, opcode: int | None, error: int | None, *, spare_s: float | None = None
    ) -> None:
        """Require the counters; an opcode or error of None is the one of before.

        Args:
            accepted: packets accepted since the case began.
            rejected: packets rejected since then.
            opcode: LAST_OPCODE.
            error: LAST_ERROR.
            spare_s: if they depend on the pace of what was written, by how much it may have been off, in seconds.
        """
        expected = Counts(
            accepted,
            rejected,
            self.before.last_opcode if opcode is None else opcode,
            self.before.last_error if error is None else error,
        )
        found = self.counts
        if found != expected:
            text = f"the state is {found}, required {expected}"
            if spare_s is None:
                raise Violation(text, self.peer.evidence())
            raise Untimely(text, self.peer.evidence(), spare_s=spare_s)

    def mark(self) -> int:
        """Return a position in what was received."""
        return self.peer.mark()

    def executions(self, mark: int) -> list[ExecutionReport]:
        """Return the 0x81 since a mark."""
        return [report for _, report in self.peer.since(mark, ExecutionReport)]

    def require_executions(self, mark: int, *expected: ExecutionReport) -> None:
        """Require these 0x81 since a mark, and no others."""
        found = self.executions(mark)
        if len(found) < len(expected) and self.peer.uncertainty_s(self.peer.bench.now_ns):
            self._general()  # behind its answer nothing is on its way any more
            found = self.executions(mark)
        if found != list(expected):
            shown = ", ".join(map(str, found)) or "none"
            raise Violation(f"0x81: {shown}; required {', '.join(map(str, expected)) or 'none'}", self.peer.evidence())

    def next(self, kind: type[ReportT], within_s: float) -> ReportT:
        """Wait for a periodic report.

        Raises:
            Violation: it did not come.
        """
        with unrecorded():
            return self.peer.expect(kind, within_s)

    def after_periodic(self) -> None:
        """Wait until the periodic 0x80 is just over, so that the next one that comes is an answer."""
        if any(rate.report is ReportId.GENERAL for rate in self.peer.profile.server.rates):
            mark = self.mark()
            self.peer.bench.run_until(lambda: bool(self.peer.since(mark, GeneralReport)), PERIODIC_WITHIN_S)

    def motion(self) -> MotionReport:
        """Wait for a 0x83 that begins later than now; the link is kept up meanwhile."""
        self.peer.send(RequestTelemetry())
        start_ns = self.peer.bench.now_ns
        while self.peer.bench.now_ns - start_ns < ANSWER_S * NS_PER_S:
            mark = self.mark()
            report = self.next(MotionReport, REPORT_S * 2)
            (got, _), *_ = self.peer.since(mark, MotionReport)
            doubt_ns = round(self.peer.uncertainty_s(start_ns) * NS_PER_S)
            if got.start_ns - start_ns > doubt_ns:
                self._let_out(doubt_ns)
                return report
        raise Inconclusive(EVER_LATER)

    def require_throttles(self, report: MotionReport, left: float, right: float, tolerance: float = 1e-4) -> None:
        """Require the throttles of a 0x83."""
        for name, found, wanted in zip("AB", report.throttles, (left, right), strict=True):
            near(found, wanted, tolerance, unit="of full", what=f"throttle {name} in 0x83")

    def require_setpoints(self, report: MotionReport, left_rpm: float, right_rpm: float) -> None:
        """Require the setpoints of a 0x83."""
        for name, found_rpm, wanted_rpm in zip("AB", report.setpoints_rpm, (left_rpm, right_rpm), strict=True):
            near(found_rpm, wanted_rpm, 1e-3, unit="rpm", what=f"setpoint {name} in 0x83")

    def stop_s(self, since_ns: int, within_s: float) -> None:
        """Require that both motors are without voltage within a time since `since_ns`."""
        if not self.seen:
            self._stop_shown_s(since_ns, within_s)
            return
        stopped = self.peer.bench.run_until(self._stands, within_s + 1.0)
        if not stopped:
            raise Violation(f"the motors still run: {self.duties}", self.peer.evidence())
        elapsed_s = (self.peer.bench.now_ns - since_ns) / NS_PER_S
        at_most(
            elapsed_s, within_s, unit="s", what="the motors stood after", uncertainty=self.peer.uncertainty_s(since_ns)
        )

    def before_silence(self, within_s: float) -> None:
        """Where nobody sees the motors, wait until a 0x83 will come just after they must stand.

        Without that a stop may be late by the time between two of them before anything shows it.

        Args:
            within_s: how soon after a command that is sent now they must stand, in seconds.
        """
        if self.seen:
            return
        self.next(MotionReport, REPORT_S * 2)
        until_s = within_s + self._reported_late_s + JUST_AFTER_S + self.peer.line_s(MOTION_AND_COMMAND)
        self.peer.run(-until_s % self._motion_s)

    def _stop_shown_s(self, since_ns: int, within_s: float) -> None:
        """As `stop_s`, by the 0x83 that come by themselves: to ask for something would keep the link up."""
        within_s += self._reported_late_s
        self.peer.run(within_s + 2 * self._motion_s)
        reports = [
            ((got.start_ns - since_ns) / NS_PER_S, report)
            for got, report in self.peer.since(0, MotionReport)
            if got.start_ns > since_ns
        ]
        running = [(after_s, report.throttles) for after_s, report in reports if any(report.throttles)]
        if not running:
            raise Inconclusive("no 0x83 shows the motors running after the last command", self.peer.evidence())
        if reports[-1][0] < within_s:
            raise Inconclusive("no 0x83 came after the time in which the motors must stop", self.peer.evidence())
        after_s, (left, right) = running[-1]
        at_most(
            after_s,
            within_s,
            unit="s",
            what=f"0x83 still showed throttles of {left:g} and {right:g} after",
            uncertainty=self.peer.uncertainty_s(since_ns),
        )

    @property
    def _motion_s(self) -> float:
        """The time between two 0x83."""
        server = self.peer.profile.server
        return next(rate.ticks for rate in server.rates if rate.report is ReportId.MOTION) / server.tick_hz

    @property
    def _reported_late_s(self) -> float:
        """How long ago may be what a 0x83 says when it begins: other reports of the same tick stand before it."""
        return self.peer.line_s(OTHER_REPORTS)

    def _stands(self) -> bool:
        return self.duties == (0.0, 0.0)

    def _general(self) -> GeneralReport:
        """Ask for the counters, until an answer cannot be one to what came before; P01 judges how soon it comes."""
        asked_ns = self.peer.bench.now_ns
        while self.peer.bench.now_ns - asked_ns < ANSWER_S * NS_PER_S:
            mark = self.mark()
            self.peer.send(RequestTelemetry())
            report = self.next(GeneralReport, ANSWER_S)
            (got, _), *_ = self.peer.since(mark, GeneralReport)
            doubt_ns = round(self.peer.uncertainty_s(asked_ns) * NS_PER_S)
            if not doubt_ns or got.start_ns - asked_ns > doubt_ns:
                self._let_out(doubt_ns)
                return report
        raise Inconclusive(EVER_LATER)

    def _let_out(self, doubt_ns: int) -> None:
        """Wait until what was written last is out on a late bench, or it would come together with what is next."""
        if doubt_ns:
            self.peer.run(doubt_ns / NS_PER_S)
