"""The bench of one case of a Pioneer, as its suite sees it.

A case asks for parts by name, and only what it asks for is built. With a server under test there is ``peer``, the
checker's end of the line; with a client under test ``client`` and the scripted ``server`` it talks to. On a virtual
bench there are also ``pioneer`` and ``world``, the truth to hold against what the line says.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

from hilbench.bench import Bench
from hilbench.bench.about import about_world
from hilbench.bench.cases import CaseBase
from hilbench.bench.line_end import LineEnd
from hilbench.bench.line_faults import LineFaults
from hilbench.bench.line_peer import LinePeer
from hilbench.bench.state_reporter import Observed, Senses
from hilbench.benchfile.fault_entries import FaultEntry
from hilbench.clock import Scheduler
from hilbench.driving.rig import CLIENT_SENSES
from hilbench.errors import InternalError
from hilbench.judging.provider import CaseInfo
from hilbench.links import Line, MemoryLink, Port
from hilbench.systems.pioneer.about import about_sonars
from hilbench.systems.pioneer.client import P2osClient
from hilbench.systems.pioneer.flash import with_figures
from hilbench.systems.pioneer.peer import Peer
from hilbench.systems.pioneer.robot import PioneerPlan, VirtualPioneer
from hilbench.systems.pioneer.scripted import ScriptedServer
from hilbench.systems.pioneer.under_test import ClientUnderTest, OwnClient
from protocols.p2os import ClientOptions, Connection
from worlds.world import World

AT_SERVER: Mapping[str, Any] = {"operator": "checker", "protocol": "p2os"}
"""What a view knows of the frames of a case: which source of the journal speaks what, here to a server."""
AT_CLIENT: Mapping[str, Any] = {"operator": "server", "protocol": "p2os", "side": "target"}
"""The same of a case of a client: the checker is the server."""

ClientFactory = Callable[[Bench, Port, ClientOptions], P2osClient]
Tap = Callable[[Scheduler, Port], Port]
"""Puts something between the checker and the device on a port; what a frame-altering mutant does."""


def make_client(bench: Bench, port: Port, options: ClientOptions) -> P2osClient:
    """Make our client as it is meant to be."""
    return P2osClient(bench, port, options)


def no_tap(_scheduler: Scheduler, port: Port) -> Port:
    """Put nothing in between."""
    return port


class VirtualCase(CaseBase):
    """A case on a bench of its own, where nothing is real and time runs free.

    Args:
        bench: made for this case alone.
        case: what is known of it.
        plan: the robot to build; a scene the case asks for replaces the plan's.
        line: the host line.
        make_client: makes the client under test.
        tap: what stands between the checker and the device.
        faults: what goes wrong on the line.
    """

    _senses: Senses = MappingProxyType({"client": CLIENT_SENSES})

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        plan: PioneerPlan,
        line: Line,
        *,
        make_client: ClientFactory = make_client,
        tap: Tap = no_tap,
        faults: Sequence[FaultEntry] = (),
    ) -> None:
        super().__init__(bench, case)
        self.plan = replace(plan, scene=case.scene) if case.scene else plan
        self._make_client = make_client
        self._line = line
        self._entries = faults
        self._made_link: MemoryLink | None = None
        self._tap = tap

    def _link(self, *, checker_is_client: bool) -> MemoryLink:
        """Return the line, with the checker at its end ``a``; made when it is known which part the checker plays."""
        if self._made_link is None:
            if self._entries:
                self._faults = LineFaults(
                    self.bench,
                    self._entries,
                    seed=self.case.seed,
                    near_is_client=checker_is_client,
                    on_interruption=self._interrupted,
                )
            plan = self._faults.plan if self._faults is not None else None
            self._made_link = MemoryLink(self.bench.scheduler, self._line, name="host", faults=plan)
        return self._made_link

    def _interrupted(self) -> None:
        if "peer" in self.__dict__:
            self.peer.line_expected = False

    @cached_property
    def pioneer(self) -> VirtualPioneer:
        """The virtual robot with its world, on the far end of the line."""
        port = self._tap(self.bench.scheduler, self._link(checker_is_client=True).b)
        return VirtualPioneer(self.bench, port, self.plan, seed=self.case.seed)

    @cached_property
    def peer(self) -> Peer:
        """The checker's end of the robot's line."""
        peer = Peer(self.bench, self._link(checker_is_client=True).a)
        self.pioneer  # noqa: B018 - brings the robot to life at the far end
        return peer

    def write_flash(self, figures: Mapping[str, int]) -> None:
        """Write figures of CONFIG into the robot's FLASH, by their names there, and switch it off and on again."""
        self.pioneer.power_on(with_figures(self.plan.settings, figures))

    def drive_inputs(self, digital: int, analog: Sequence[int]) -> None:
        """Put levels (a byte) and voltages (10-bit counts, ports 1 to 5) on the inputs of its user I/O connector."""
        io = self.pioneer.robot.controller.io
        io.digital_in, io.analog = digital, list(analog)

    @property
    def world(self) -> World:
        """The world the robot stands in: the truth."""
        return self.pioneer.world

    @cached_property
    def server(self) -> ScriptedServer:
        """The scripted server that a client under test talks to."""
        return ScriptedServer(self.bench, self._link(checker_is_client=False).a)

    @cached_property
    def client(self) -> ClientUnderTest:
        """The client under test."""
        return self.client_with(ClientOptions())

    def client_with(self, options: ClientOptions) -> ClientUnderTest:
        """Make the client under test with options of the case's choosing; only once in a case."""
        if "client" in self.__dict__:
            raise InternalError("the case has its client already")
        self.server  # noqa: B018 - the far end is there before the client speaks
        port = self._tap(self.bench.scheduler, self._link(checker_is_client=False).b)
        client = OwnClient(self._make_client(self.bench, port, options))
        self.__dict__["client"] = client
        return client

    def hang_up(self) -> None:
        """Cut the line, as a TCP client that dies does."""
        self.peer.line_expected = False
        self._link(checker_is_client=True).hang_up()

    def reconnect(self) -> None:
        """Bring the line back."""
        link = self._link(checker_is_client=True)
        link.restore()
        self.bench.run_until(lambda: link.a.line_is_up, 1.0)
        self.peer.line_expected = True

    def connections(self) -> list[Connection]:
        """Return our own devices' ends of the protocol, as far as the case built them: what it tested."""
        tested = [self.pioneer.robot.connection] if "pioneer" in self.__dict__ else []
        client = self.client.own if "client" in self.__dict__ else None
        return [*tested, client.connection] if isinstance(client, P2osClient) else tested

    def commands_seen(self) -> frozenset[tuple[int, str]] | None:
        """Return the commands the robot got, each with what became of it; None if there is no robot."""
        return frozenset(self.pioneer.commands) if "pioneer" in self.__dict__ else None

    def _machines_seen(self) -> Mapping[str, Observed]:
        own = self.client.own if "client" in self.__dict__ else None
        client: dict[str, Observed] = {"client": own.connection} if isinstance(own, P2osClient) else {}
        return client | ({"robot": self.pioneer.robot.connection} if "pioneer" in self.__dict__ else {})

    def _lines_seen(self) -> Mapping[str, Port]:
        ends = [self.__dict__[name].port for name in ("peer", "server") if name in self.__dict__]
        return {"host": ends[0]} if ends else {}

    def _about_view(self) -> Mapping[str, Any]:
        if "pioneer" in self.__dict__:
            robot = about_sonars(self.plan.settings.subclass) | about_world(self.world)
            return {**AT_SERVER, **robot}
        return AT_CLIENT

    def _peers(self) -> Mapping[str, LinePeer[Any]]:
        return {"host": self.peer} if "peer" in self.__dict__ else {}

    def _ends(self) -> Mapping[str, LineEnd]:
        return {"host": self.server} if "server" in self.__dict__ else self._peers()

    def _packets(self) -> Sequence[str]:
        return self.server.evidence() if "server" in self.__dict__ else super()._packets()

    def close(self) -> None:
        """Give the world back."""
        if "pioneer" in self.__dict__:
            self.pioneer.close()


class AttachedCase(CaseBase):
    """A case on a server that somebody else runs: a real robot, or a program behind a pty or a socket."""

    def __init__(
        self, bench: Bench, case: CaseInfo, peer: Peer, reopen: Callable[[], Port], faults: LineFaults | None = None
    ) -> None:
        super().__init__(bench, case, faults)
        self.peer = peer
        self._reopen = reopen

    def hang_up(self) -> None:
        """Close our end of the line."""
        self.peer.line_expected = False
        self.peer.port.close()

    def reconnect(self) -> None:
        """Open the line again."""
        self.peer.attach(self._reopen())

    def _peers(self) -> Mapping[str, LinePeer[Any]]:
        return {"host": self.peer}

    def _about_view(self) -> Mapping[str, Any]:
        return AT_SERVER


class ForeignClientCase(CaseBase):
    """A case on a client that somebody else wrote."""

    def __init__(
        self,
        bench: Bench,
        case: CaseInfo,
        server: ScriptedServer,
        client: ClientUnderTest,
        faults: LineFaults | None = None,
    ) -> None:
        super().__init__(bench, case, faults)
        self.server = server
        self.client = client

    def _ends(self) -> Mapping[str, LineEnd]:
        return {"host": self.server}

    def _lines_seen(self) -> Mapping[str, Port]:
        return {"host": self.server.port}

    def _about_view(self) -> Mapping[str, Any]:
        return AT_CLIENT

    def _packets(self) -> Sequence[str]:
        return self.server.evidence()
