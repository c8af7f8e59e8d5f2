"""The bench of one case of a rover: a behavioural one in virtual time, or one that somebody else runs."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from types import MappingProxyType
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.cases import CaseBase
from hilbench.bench.devices import DeviceActor
from hilbench.bench.line_end import LineEnd
from hilbench.bench.line_faults import LineFaults
from hilbench.bench.line_peer import LinePeer
from hilbench.bench.state_reporter import Observed, Senses
from hilbench.benchfile.bench_file import BenchFile
from hilbench.driving.rig import CLIENT_SENSES
from hilbench.judging.provider import CaseInfo
from hilbench.links import Line, MemoryLink, Port
from hilbench.systems.rover.about import about_pkt
from hilbench.systems.rover.client import HostUnderTest
from hilbench.systems.rover.ground_station import GroundStation
from hilbench.systems.rover.hands import ModelHands, OperatorHands, RoverHands
from hilbench.systems.rover.peer import RoverPeer
from hilbench.systems.rover.scripted import ScriptedRover
from protocols.pkt import PROFILES
from targets.robots.rover import RoverRobot, RoverSettings

__all__ = ["AttachedRoverCase", "HostCase", "RoverCase", "RoverFactory", "VirtualRoverCase", "make_rover", "rover_baud"]

RoverFactory = Callable[[RoverSettings], RoverRobot]


def make_rover(settings: RoverSettings) -> RoverRobot:
    """Make the rover as it is meant to be; what takes its place in a test may be a faulty one."""
    return RoverRobot(settings)


def rover_baud(bench_file: BenchFile) -> int:
    """Return the rate of the line of the one rover of a bench, in bit/s."""
    return bench_file.links[0].baud if bench_file.links else Line().baud


class RoverCase(CaseBase):
    """What every case of a rover has.

    Attributes:
        peer: the checker's end of the rover's line.
        hands: who stands beside the rover; None if nobody does.
    """

    peer: RoverPeer
    hands: RoverHands | None = None

    def _peers(self) -> Mapping[str, LinePeer[Any]]:
        return {"host": self.peer}

    def _about_view(self) -> Mapping[str, Any]:
        return about_pkt("checker", {}, self.peer.profile.name)


class VirtualRoverCase(RoverCase):
    """A behavioural rover on a bench of its own, where nothing is real and time runs free.

    Args:
        bench: made for this case alone.
        case: what is known of it.
        settings: of the rover; its profile is the one that the rover is spoken to in.
        line: the host's line.
        make_rover: makes the rover.
        faults: what goes wrong on the line.

    Attributes:
        robot: the rover.
    """

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        settings: RoverSettings,
        line: Line,
        *,
        make_rover: RoverFactory = make_rover,
        faults: LineFaults | None = None,
    ) -> None:
        super().__init__(bench, case, faults)
        link = MemoryLink(bench.scheduler, line, name="host", faults=faults.plan if faults is not None else None)
        self._link = link
        self.peer = RoverPeer(bench, link.a, PROFILES[settings.profile])
        self.robot = make_rover(settings)
        self.hands = ModelHands(self.robot)
        self._actor = DeviceActor(bench, self.robot, link.b, name="rover")

    def reopen(self, closed_s: float) -> None:
        """Cut the line for so long, in seconds, and bring it back."""
        self.peer.line_expected = False
        self._link.hang_up()
        self.peer.run(closed_s)
        self._link.restore()
        self.bench.run_until(lambda: self._link.a.line_is_up, 1.0)
        self.peer.line_expected = True

    def _machines_seen(self) -> Mapping[str, Observed]:
        return {"rover": self.robot.connection}


class HostCase(CaseBase):
    """What every case of a host has: a scripted rover at the far end of its line.

    Args:
        bench: whose time passes.
        case: what is known of it.
        rover: the scripted rover.
        client: the host under test.
        faults: what goes wrong on the line.
    """

    _senses: Senses = MappingProxyType({"station": CLIENT_SENSES})

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        rover: ScriptedRover,
        client: HostUnderTest,
        faults: LineFaults | None = None,
    ) -> None:
        super().__init__(bench, case, faults)
        self.rover = rover
        self.client = client

    def _machines_seen(self) -> Mapping[str, Observed]:
        own = self.client.own
        return {"station": own.connection} if isinstance(own, GroundStation) else {}

    def _ends(self) -> Mapping[str, LineEnd]:
        return {"host": self.rover}

    def _lines_seen(self) -> Mapping[str, Port]:
        return {"host": self.rover.port}

    def _about_view(self) -> Mapping[str, Any]:
        return about_pkt("rover", self._machines_seen(), self.rover.profile.name)

    def _packets(self) -> Sequence[str]:
        return self.rover.evidence()


class AttachedRoverCase(RoverCase):
    """A rover that somebody else runs, in real time.

    Args:
        bench: shared by all cases, locked to the host's clock.
        case: what is known of this one.
        peer: the checker's end of the line, settled.
        open_again: opens the port again.
        faults: what goes wrong on the line.
        hands: who stands beside the rover; None if nobody does.
    """

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        peer: RoverPeer,
        open_again: Callable[[], Port],
        faults: LineFaults | None = None,
        hands: OperatorHands | None = None,
    ) -> None:
        super().__init__(bench, case, faults)
        self.hands = hands
        self.peer = peer
        self._open_again = open_again

    def reopen(self, closed_s: float) -> None:
        """Close the port for so long, in seconds, and open it again."""
        self.peer.line_expected = False
        self.peer.port.close()
        self.peer.run(closed_s)
        self.peer.attach(self._open_again())
