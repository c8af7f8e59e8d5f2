"""Benches with something real attached: a server at a port, or a client that connects to us, in real time."""

from __future__ import annotations

import contextlib
import ipaddress
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, Generic, Protocol, TypeVar

from hilbench.bench import LOCAL_PORT_S, LOCKED_FLOOR_S, Bench
from hilbench.bench.cases import CaseBase
from hilbench.bench.client_under_test import (
    EXEC_CAPABILITIES,
    LISTEN_CAPABILITIES,
    ClientUnderTest,
    ExecClient,
    ListenClient,
)
from hilbench.bench.line_faults import LineFaults
from hilbench.bench.line_peer import LinePeer
from hilbench.bench.observing import counters_of, pace_of
from hilbench.bench.operator import Beside
from hilbench.bench.report_line import REPORT
from hilbench.bench.shared import Shared
from hilbench.bench.stamps import ByteStamps, PortStamps
from hilbench.benchfile.line_hooks import run_hook
from hilbench.benchfile.reader import BenchFile
from hilbench.clock import NS_PER_S, MonotonicHostClock, Scheduler
from hilbench.clock.precedence import OF_A_BENCH, freeze_memory, give_way, take_precedence
from hilbench.errors import UnavailableError, UsageError
from hilbench.judging.observations import Observations
from hilbench.judging.provider import CaseInfo
from hilbench.links import (
    DEFAULT_BAUD,
    Line,
    Port,
    PtyDoor,
    ReconnectingPort,
    SerialPort,
    SerialTarget,
    TcpDoor,
    parse_serial_target,
)
from hilbench.links.faults import FaultyPort
from hilbench.links.reconnecting import POLL_NS
from hilbench.links.serial_target import located
from hilbench.links.stamped import StampingProcess
from hilbench.pace.far_pace import FarPace, ends_of, is_pseudo_terminal, place_of
from hilbench.pace.pty_probe import PtyProbe
from hilbench.ports.calibration import Calibration, calibration_of
from hilbench.ports.listing import list_ports
from hilbench.terminal import own_process

PeerT = TypeVar("PeerT", bound=LinePeer[Any])
CaseT = TypeVar("CaseT", bound=CaseBase)

_LAST_WORDS_S = 0.5
"""How long a client's last bytes may take to pass the wire, so that the next case does not hear them. A choice."""

RETURN_WITHIN_S = 15.0
"""How long a run waits between two cases for a board that has been unplugged, in seconds (choice)."""


class LockedProvider:
    """What benches with something real attached have in common: one scheduler, locked to the host's clock."""

    def __init__(self, shared: Shared, target: str) -> None:
        if shared.route is not None:
            raise UsageError(
                "a target at a port cannot be reached through an endpoint of this machine",
                where="--through",
                hint="leave out --through or --target",
            )
        self._shared = shared
        self._target = target
        self._host = MonotonicHostClock()
        self._scheduler = Scheduler()
        self._bench = shared.bench(self._scheduler)
        self._locked = False
        self._first = False
        self._ports: list[Port] = []
        self._known: set[str] = set()
        self._calibrations: dict[str, Calibration] = {}
        self._returns = True

    @property
    def suites(self) -> Sequence[str]:
        """The suites of the bench file."""
        return self._shared.suites

    def describe(self) -> Mapping[str, str]:
        """Name the target, and what its ports were measured to add to every time; there is no physics of ours."""
        about = self._shared.describe(self._target, "none of ours")
        kept = "; ".join(f"{one.uncertainty_s * 1000:.2f} ms at {key}" for key, one in self._calibrations.items())
        if self._bench.stamps is not None:
            about = {**about, "stamps": self._bench.stamps.words}
        return {**about, "calibration": kept} if kept else about

    def observed(self) -> Observations:
        """Return how well the host kept up so far, and what passed the port."""
        return Observations(pace=pace_of(self._scheduler), port=counters_of(self._ports))

    def _operator_for(self, case: CaseInfo) -> Beside | None:
        """Return the operator for a case that needs one; what was asked of him before is taken back first."""
        operator = self._shared.operator
        if operator is None:
            return None
        operator.restore(self._bench)
        return Beside(operator, self._bench, case) if case.by_hand else None

    def _lock(self) -> None:
        """Follow the host's clock, once a port is open: how long that takes is no lateness."""
        if not self._locked:
            if own_process.is_ours():
                freeze_memory()
                self._first = take_precedence(OF_A_BENCH)
            self._scheduler.lock(self._host)
            self._locked = True

    def _open_serial(self, target: SerialTarget) -> Port:
        """Open a real port that may be unplugged and come back."""
        stamps = None
        if own_process.is_ours():
            self._bench.stamps = self._bench.stamps or ByteStamps(StampingProcess)
            stamps = PortStamps(self._bench.stamps)
        open_port = partial(SerialPort, stamps=stamps)
        port = ReconnectingPort(self._scheduler, target, record=self._bench.record, open_port=open_port)
        self._ports.append(port)
        where = located(target).url
        self._learn(where)
        if stamps is not None and place_of(where) is not None:
            stamps.far = FarPace(where)
        return port

    def _learn(self, where: str) -> None:
        """Learn what a port adds to every time, and which bench of ours is behind it, by its path or URL."""
        if where in self._known:
            return
        if not self._known:
            self._bench.port_floor_s = 0.0
        self._known.add(where)
        if place_of(where) is not None:
            self._bench.far.append(FarPace(where))
        ends = ends_of(where)
        if ends != [where] or not is_pseudo_terminal(where):
            self._bench.adapter_s = LOCAL_PORT_S  # more than the kernel of this host lies between
        if self._bench.way is None and any(is_pseudo_terminal(one) for one in (where, *ends)):
            self._bench.way = PtyProbe(self._scheduler, self._host)
        for end in ends:
            calibration = calibration_of(end, list_ports())
            if calibration is not None:
                self._calibrations[calibration.key] = calibration
                self._adds(max(calibration.uncertainty_s, LOCAL_PORT_S))
                self._bench.adapter_s = self._bench.port_uncertainty_s
            elif place_of(end) is not None:
                self._adds(LOCAL_PORT_S)
            else:
                self._bench.port_floor_s = LOCKED_FLOOR_S

    def _adds(self, uncertainty_s: float) -> None:
        self._bench.port_uncertainty_s = max(self._bench.port_uncertainty_s, uncertainty_s)

    def _await_return(self, peers: Sequence[LinePeer[Any]]) -> None:
        """Wait for what has been unplugged, between two cases: the next one begins with a line that is up.

        Raises:
            UnavailableError: it does not come back.
        """
        for peer in peers:
            within_s = RETURN_WITHIN_S if self._returns else 2 * POLL_NS / NS_PER_S
            if not peer.port.line_is_up and not self._bench.run_until(partial(_is_up, peer.port), within_s):
                self._returns = False  # the others are not to wait as long
                raise UnavailableError("has gone and has not come back", where=peer.port.name, hint="plug it in again")
            self._returns = True
            peer.attach(peer.port)

    def close(self) -> None:
        """Give the clock and the journal back."""
        if self._bench.way is not None:
            self._bench.way.close()
            self._bench.way = None
        if self._locked:
            self._scheduler.unlock()
        if self._first:
            give_way()
        self._host.close()
        self._shared.close(self._bench.now_ns)


@contextlib.contextmanager
def faults_between(peer: LinePeer[Any], faults: LineFaults, link: int | None = 0) -> Iterator[FaultyPort]:
    """Put the faults of a link between a peer and its port for as long as this lasts; the port is sound after it."""
    faulty = faults.on(peer.port, link)
    peer.attach(faulty)
    try:
        yield faulty
    finally:
        faulty.detach()
        was_expected = peer.line_expected
        peer.attach(faulty.port)
        peer.line_expected = was_expected


class AttachedProviderBase(LockedProvider, ABC, Generic[PeerT, CaseT]):
    """A target that somebody else runs, at a serial port or behind any pyserial URL.

    The port is opened once, before the first case; between cases the target is settled.

    Args:
        shared: bench file, journal, waiting.
        spec: the target as on the command line.
        usual_baud: the rate of a port of which the command line says none, in bit/s; `USUAL_BAUD` if None.
    """

    USUAL_BAUD: ClassVar[int] = DEFAULT_BAUD

    def __init__(self, shared: Shared, spec: str, usual_baud: int | None = None) -> None:
        super().__init__(shared, spec)
        self._serial = parse_serial_target(spec, usual_baud or self.USUAL_BAUD, shared.bench_file.port.settings)
        self._peer: PeerT | None = None
        self._beside: Beside | None = None

    @abstractmethod
    def _make_peer(self, port: Port) -> PeerT:
        """Return the checker's end of the line."""

    @abstractmethod
    def _make_case(
        self, case: CaseInfo, peer: PeerT, reopen: Callable[[], Port], faults: LineFaults | None = None
    ) -> CaseT:
        """Return the bench of a case."""

    def prepare(self, cases: Sequence[CaseInfo]) -> None:
        """Open the port before anything runs, so that one that is not there costs a line and no case.

        Raises:
            UnavailableError: it cannot be opened.
        """
        if cases:
            self._opened()

    def _opened(self) -> PeerT:
        if self._peer is None:
            self._peer = self._make_peer(self._open_port())
            self._lock()
            run_hook(self._bench, self._peer.port, "boot", self._shared.bench_file.port.boot)
        return self._peer

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[CaseT]:
        """Settle the target and hand it to one case."""
        peer = self._opened()
        if not peer.port.line_is_up and not peer.line_expected:
            peer.attach(self._open_port())
        self._await_return([peer])
        self._beside = self._operator_for(case)
        peer.port.baud = self._serial.baud
        run_hook(self._bench, peer.port, "reset", self._shared.bench_file.port.reset)
        peer.settle()
        yield from self._case(case, peer)

    def close(self) -> None:
        """Leave the target stopped and its session closed, whatever the last case did; close everything."""
        if self._peer is not None:
            if self._peer.port.line_is_up:
                with contextlib.suppress(UnavailableError):
                    self._peer.settle()
            self._peer.port.close()
        super().close()

    def _case(self, case: CaseInfo, peer: PeerT) -> Iterator[CaseT]:
        """Hand the target to a case, with the bench file's faults on the line for as long as it lasts."""

        def interrupted() -> None:
            peer.line_expected = False

        faults = self._shared.line_faults(self._bench, case, near_is_client=True, on_interruption=interrupted)
        if faults is None:
            yield self._make_case(case, peer, self._open_port)
            return
        with faults_between(peer, faults) as faulty:

            def reopen() -> Port:
                faulty.reopen(self._open_port())
                return faulty

            yield self._make_case(case, peer, reopen, faults)

    def _open_port(self) -> Port:
        return self._open_serial(self._serial)


class Script(Protocol):
    """What a check puts in the place of a server."""

    @property
    def port(self) -> Port:
        """Its end of the line."""

    def close(self) -> None:
        """Leave the port to another."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FarEnd:
    """What a foreign client finds at the far end of its line.

    Attributes:
        serve: begins to serve at a port.
        case: makes the bench of a case.
        capabilities: of a bench with it, beside those of the client.
        reporting: makes what knows what a client tells on a line of its own, from the checker's end of that; None where
            nobody would understand it.
        reported_capabilities: of a bench with such a client, beside these.
    """

    serve: Callable[[Bench, Port], Any]
    case: Callable[[Bench, CaseInfo, Any, Any, LineFaults | None], CaseBase]
    capabilities: frozenset[str] = frozenset()
    reporting: Callable[[Bench, Port], Any] | None = None
    reported_capabilities: frozenset[str] = frozenset()


class _ClientProvider(LockedProvider, ABC):
    """A foreign client, which finds our scripted server behind a door."""

    def __init__(self, shared: Shared, target: str, capabilities: frozenset[str], far_end: FarEnd) -> None:
        super().__init__(shared, target)
        self.capabilities = capabilities | far_end.capabilities
        self._far_end = far_end
        self._port: Port | None = None

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[CaseBase]:
        """Put a fresh scripted server behind the door, and take care of the client."""
        self._lock()
        if self._port is None:
            self._port, where = self._open_door()
            self._ports.append(self._port)
            self._learn(where)
        faults = self._shared.line_faults(self._bench, case, near_is_client=False)
        faulty = None if faults is None else faults.on(self._port)
        server: Script = self._far_end.serve(self._bench, faulty or self._port)
        client = self._client()
        try:
            yield self._far_end.case(self._bench, case, server, client, faults)
        finally:
            client.close()
            server.close()
            self._bench.run_until(lambda: not server.port.line_is_up, _LAST_WORDS_S)
            if faulty is not None:
                faulty.detach()

    def close(self) -> None:
        """Close the door, the clock and the journal."""
        if self._port is not None:
            self._port.close()
        super().close()

    @abstractmethod
    def _open_door(self) -> tuple[Port, str]:
        """Open the door the client is to come through; return it, and its path or URL."""

    @abstractmethod
    def _client(self) -> ClientUnderTest:
        """Return the client of the next case."""


class ListenProvider(_ClientProvider):
    """Waits for whoever connects: ``listen:pty:PATH`` or ``listen:tcp:[HOST:]PORT``."""

    def __init__(self, shared: Shared, spec: str, far_end: FarEnd) -> None:
        super().__init__(shared, f"a client that connects to {spec}", LISTEN_CAPABILITIES, far_end)
        self._kind, _, self._where = spec.partition(":")

    def _open_door(self) -> tuple[Port, str]:
        line = Line(baud=_baud_of(self._shared.bench_file))
        if self._kind == "pty":
            pty = PtyDoor(self._scheduler, self._where, line)
            return pty, pty.slave_name
        tcp = TcpDoor(self._scheduler, self._where, line)
        return tcp, _url_of(tcp)

    def _client(self) -> ClientUnderTest:
        assert self._port is not None
        return ListenClient(self._bench, self._port)


class ExecProvider(_ClientProvider):
    """Starts a program for each case: ``exec:COMMAND``, with ``{pty}`` or ``{port}`` where it is to connect.

    With ``{report}`` it is given a second pty, to tell there what it understood.
    """

    def __init__(self, shared: Shared, command: str, far_end: FarEnd) -> None:
        super().__init__(shared, command, EXEC_CAPABILITIES, far_end)
        self._command = command
        self._names: dict[str, str] = {}
        self._tells = f"{{{REPORT}}}" in command
        self._report: Port | None = None
        if self._tells:
            if far_end.reporting is None:
                raise UsageError("nobody here would understand what it reports", where=f"exec:{command}")
            self.capabilities |= far_end.reported_capabilities

    def _open_door(self) -> tuple[Port, str]:
        door, where = self._open_line()
        if self._tells:
            self._report = self._open_report()
        return door, where

    def _open_report(self) -> Port:
        """Open the line on which the client tells, at no rate."""
        pty = PtyDoor(self._scheduler, None, Line(baud=0))
        self._names[REPORT] = pty.slave_name
        return pty

    def close(self) -> None:
        """Close the doors, the clock and the journal."""
        if self._report is not None:
            self._report.close()
        super().close()

    def _reporting(self) -> Any:
        """Return what knows what the next client tells; None if it tells nothing."""
        if self._report is None or self._far_end.reporting is None:
            return None
        return self._far_end.reporting(self._bench, self._report)

    def _open_line(self) -> tuple[Port, str]:
        line = Line(baud=_baud_of(self._shared.bench_file))
        if "{pty}" in self._command:
            pty = PtyDoor(self._scheduler, None, line)
            self._names = {"pty": pty.slave_name}
            return pty, pty.slave_name
        tcp = TcpDoor(self._scheduler, "127.0.0.1:0", line)
        self._names = {"port": str(tcp.port)}
        return tcp, _url_of(tcp)

    def _client(self) -> ClientUnderTest:
        return ExecClient(self._command, self._names, self._reporting())


def _is_up(port: Port) -> bool:
    return port.line_is_up


def _url_of(door: TcpDoor) -> str:
    """Return the URL of a door; whoever comes by one that is not for this host alone may come from anywhere."""
    host = ipaddress.ip_address(door.host)
    if not host.is_loopback:
        return f"socket://0.0.0.0:{door.port}"
    return f"socket://{f'[{host}]' if host.version == 6 else host}:{door.port}"


def _baud_of(bench_file: BenchFile) -> int:
    return bench_file.links[0].baud if bench_file.links else Line().baud
