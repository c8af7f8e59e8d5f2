"""A session with a server under test, as the cases of `p2os_server` see it: commands out, SIPs in, each with its time.

It goes by what the line says and by nothing else, so that a case is the same on a virtual robot and on a real one.
"""

from __future__ import annotations

import statistics
from collections.abc import Callable, Sequence
from dataclasses import dataclass

from hilbench.check import Untimely, Violation
from hilbench.clock import NS_PER_S
from hilbench.systems.pioneer.peer import Peer
from protocols.p2os import (
    ROBOTS,
    CommandNumber,
    Identification,
    Pose,
    PoseTracker,
    RobotParameters,
    Sip,
    wheel_speed_mm_s,
)

CYCLE_S = 0.1
"""Time between two SIPs by default (Pioneer 2 Operations Manual, server information packets)."""

SIP_WITHIN_S = 1.0
"""How long a case waits for what it needs to go on. No limit of a clause; S05, S06, S18 and S21 judge those."""

STILL_SIPS = 3
"""A robot is at rest when so many SIPs in a row say so. A choice: one alone could be the turning point of a wheel."""

FALLBACK = "p2dx"
"""The parameters taken for a robot of unknown subclass; S03 judges the subclass."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Seen:
    """A SIP, when it came, and how fast the robot was by it.

    Attributes:
        start_ns: bench time at which its first byte was complete.
        end_ns: bench time at which its last byte was complete.
        sip: what it says.
        raw: the packet from header to checksum.
        left_mm_s: speed of the left wheel.
        right_mm_s: speed of the right wheel.
    """

    start_ns: int
    end_ns: int
    sip: Sip
    raw: bytes
    left_mm_s: float
    right_mm_s: float

    @property
    def speed_mm_s(self) -> float:
        """Speed of the robot's middle, + forward."""
        return (self.left_mm_s + self.right_mm_s) / 2

    @property
    def at_rest(self) -> bool:
        """The type says stopped and both wheel speeds are 0."""
        return not self.sip.moving and not self.sip.left_raw and not self.sip.right_raw

    def after_s(self, since_ns: int) -> float:
        """How long after ``since_ns`` its first byte came, in seconds."""
        return (self.start_ns - since_ns) / NS_PER_S


class Session:
    """Goes through the handshake, opens a session and waits for its first SIP.

    Args:
        peer: the checker's end of the line.
        motors: enable the motors, and wait until a SIP says so.

    Attributes:
        peer: see above.
        identification: who answered.
        robot: its parameters.
        first: the first SIP.

    Raises:
        Violation: the server lets no session begin.
    """

    def __init__(self, peer: Peer, *, motors: bool = False) -> None:
        self.peer = peer
        self.identification = peer.handshake()
        self.robot = find_parameters(peer, self.identification)
        peer.send(CommandNumber.OPEN)
        self.first = self.next()
        if motors:
            self.motors_on()

    # --- sending

    @property
    def now_ns(self) -> int:
        """Bench time."""
        return self.peer.bench.now_ns

    def send(self, number: int, argument: int | bytes | None = None) -> int:
        """Send a command; return the bench time at which its last byte is off the line."""
        return self._arrival_ns(self.peer.send, number, argument)

    def write(self, data: bytes) -> int:
        """Send bytes as they are; return the bench time at which the last one is off the line."""
        return self._arrival_ns(self.peer.write, data)

    def _arrival_ns(self, send: Callable[..., None], *arguments: object) -> int:
        before = self.peer.port.counters.sent
        send(*arguments)
        count, baud = self.peer.port.counters.sent - before, self.peer.port.baud
        return self.now_ns + (10 * count * NS_PER_S // baud if baud else 0)

    def motors_on(self) -> None:
        """Enable the motors and wait until a SIP says so; S21 judges how soon."""
        self.send(CommandNumber.ENABLE, 1)
        mark = self.peer.mark()
        self._wait(mark, lambda: any(s.sip.motors_enabled for s in self.seen(mark)), "SIP with motors enabled")

    def set_ramps(self, *, up: int = 0, down: int = 0, turn: int = 0) -> None:
        """Set acceleration and deceleration in mm/s² (SETA), and both of the turn in deg/s² (SETRA); 0 leaves one."""
        for number, rate in ((CommandNumber.SETA, up), (CommandNumber.SETA, -down)):
            if rate:
                self.send(number, rate)
        if turn:
            self.send(CommandNumber.SETRA, turn)
            self.send(CommandNumber.SETRA, -turn)

    def leave(self) -> None:
        """Stop and close, without waiting for it."""
        self.send(CommandNumber.STOP)
        self.send(CommandNumber.ENABLE, 0)
        self.send(CommandNumber.CLOSE, 1)

    # --- receiving

    def seen(self, mark: int) -> list[Seen]:
        """Return the SIPs received since ``mark``."""
        return [
            Seen(
                start_ns=got.start_ns,
                end_ns=got.at_ns,
                sip=sip,
                raw=got.raw,
                left_mm_s=wheel_speed_mm_s(sip.left_raw, self.robot),
                right_mm_s=wheel_speed_mm_s(sip.right_raw, self.robot),
            )
            for got, sip in self.peer.since(mark, Sip)
        ]

    def watch(self, duration_s: float) -> list[Seen]:
        """Say nothing for ``duration_s`` seconds; return the SIPs that came."""
        mark = self.peer.mark()
        self.peer.run(duration_s)
        return self._some(mark, duration_s)

    def watch_alive(self, duration_s: float) -> list[Seen]:
        """As `watch`, but feed the watchdog with PULSEs."""
        mark = self.peer.mark()
        self.peer.run_alive(duration_s)
        return self._some(mark, duration_s)

    def next(self) -> Seen:
        """Wait for a SIP; afterwards there is time for a command before the next one."""
        mark = self.peer.mark()
        self._wait(mark, lambda: bool(self.seen(mark)), "SIP")
        return self.seen(mark)[0]

    def next_after(self, arrived_ns: int) -> Seen:
        """Wait for a SIP that for certain began after a command had arrived, so that it can know of it."""
        while (seen := self.next()).after_s(arrived_ns) <= self.uncertainty_s(arrived_ns):
            pass
        return seen

    def wait_at_rest(self, within_s: float) -> Seen:
        """Wait until the robot is at rest, feeding its watchdog.

        Raises:
            Violation: it was not within ``within_s`` seconds.
        """
        end_ns, fed_ns, still = self.now_ns + round(within_s * NS_PER_S), 0, 0
        while self.now_ns < end_ns:
            if self.now_ns - fed_ns > NS_PER_S // 2:
                self.send(CommandNumber.PULSE)
                fed_ns = self.now_ns
            seen = self.next()
            still = still + 1 if seen.at_rest else 0
            if still == STILL_SIPS:
                return seen
        text = f"the robot is not at rest after {within_s:g} s"
        raise Untimely(text, self.peer.evidence(), spare_s=within_s / 2)

    def uncertainty_s(self, since_ns: int) -> float:
        """Return how far off times since ``since_ns`` may be, in seconds."""
        return self.peer.uncertainty_s(since_ns)

    def _wait(self, mark: int, condition: Callable[[], bool], what: str) -> None:
        if not self.peer.bench.run_until(condition, SIP_WITHIN_S):
            self.peer.require_line()
            raise Untimely(f"no {what} within {SIP_WITHIN_S:g} s", self.peer.evidence(mark), spare_s=SIP_WITHIN_S / 2)

    def _some(self, mark: int, duration_s: float) -> list[Seen]:
        seen = self.seen(mark)
        if not seen:
            raise Untimely("no SIP came", self.peer.evidence(mark), spare_s=duration_s - 2 * CYCLE_S)
        return seen


def find_parameters(peer: Peer, identification: Identification) -> RobotParameters:
    """Return the parameters of the robot that answered; of `FALLBACK` for an unknown one, which the journal notes."""
    found = ROBOTS.get(identification.subclass.lower())
    if found is None:
        peer.bench.record("note", "checker", text=f"subclass {identification.subclass!r} unknown, taken for {FALLBACK}")
    return found or ROBOTS[FALLBACK]


def medians_mm_s(seen: Sequence[Seen]) -> tuple[float, float]:
    """Return the median speeds of the left and the right wheel; a single flicker does not count."""
    return statistics.median(s.left_mm_s for s in seen), statistics.median(s.right_mm_s for s in seen)


class Slope:
    """How fast a speed changed on a ramp.

    Between a tenth and nine tenths of the ramp by least squares; where fewer than three SIPs fall into that stretch,
    between the last before and the first behind it, which for a jump is a lower bound.

    Args:
        seen: SIPs of the ramp, and of some time before and behind it.
        start_mm_s: speed before it.
        end_mm_s: speed behind it.
        uncertainty_s: of the times.

    Attributes:
        mm_s2: signed.
        uncertainty_mm_s2: what that of the times makes of it.
    """

    def __init__(self, seen: Sequence[Seen], start_mm_s: float, end_mm_s: float, uncertainty_s: float) -> None:
        progress = [(s.speed_mm_s - start_mm_s) / (end_mm_s - start_mm_s) for s in seen]
        first = next((i for i, share in enumerate(progress) if share > _RAMP[0]), len(seen))
        last = next((i for i, share in enumerate(progress) if share >= _RAMP[1]), len(seen))
        if last == len(seen) or first == 0:
            raise Violation(
                f"the speed does not go from {start_mm_s:g} to {end_mm_s:g} mm/s",
                [f"{s.start_ns / NS_PER_S:10.4f} s  {s.speed_mm_s:g} mm/s" for s in seen[:: max(1, len(seen) // 20)]],
            )
        ramp = seen[first:last] if last - first >= _FEWEST else seen[first - 1 : last + 1]
        times_s = [s.after_s(ramp[0].start_ns) for s in ramp]
        self.mm_s2 = statistics.linear_regression(times_s, [s.speed_mm_s for s in ramp]).slope
        self.uncertainty_mm_s2 = abs(self.mm_s2) * 2 * uncertainty_s / times_s[-1]


_RAMP = 0.1, 0.9
_FEWEST = 3


def poses(seen: Sequence[Seen], robot: RobotParameters) -> list[Pose]:
    """Return the pose of each SIP, followed from the first on so that nothing wraps."""
    tracker = PoseTracker(robot)
    return [tracker.update(s.sip) for s in seen]


def turned_deg(seen: Sequence[Seen], robot: RobotParameters) -> float:
    """Return how far the heading went from the first of the SIPs to the last, in degrees, + counter-clockwise."""
    followed = poses(seen, robot)
    return followed[-1].heading_deg - followed[0].heading_deg


def turn_rate_deg_s(seen: Sequence[Seen], robot: RobotParameters) -> float:
    """Return the mean rate of turn from the first of the SIPs to the last, in deg/s, + counter-clockwise."""
    return turned_deg(seen, robot) / seen[-1].after_s(seen[0].start_ns)
