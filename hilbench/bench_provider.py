"""Which benches there are, and which one a command line means.

A provider opens the bench of each case: a fresh virtual one, or what is at the other end of a real port, or a client
that connects to us. What it can do decides which cases apply; the names of the capabilities are those the clauses use.
"""

from __future__ import annotations

import contextlib
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from hilbench.bench import Bench
from hilbench.cases import AttachedCase, ClientFactory, ForeignClientCase, Tap, VirtualCase, make_client, no_tap
from hilbench.check.provider import BenchProvider, CaseInfo
from hilbench.client_under_test import (
    EXEC_CAPABILITIES,
    LISTEN_CAPABILITIES,
    OWN_CAPABILITIES,
    ClientUnderTest,
    ExecClient,
    ListenClient,
)
from hilbench.clock import MonotonicHostClock, Scheduler
from hilbench.config import BenchFile, open_bench
from hilbench.errors import UnavailableError, UsageError
from hilbench.journal import Journal
from hilbench.links import Line, Port, PtyDoor, SerialPort, TcpDoor, parse_serial_target
from hilbench.nearest import did_you_mean
from hilbench.options import CheckOptions
from hilbench.peer import Peer
from hilbench.pioneer import PioneerPlan, plan_of
from hilbench.scripted_server import ScriptedServer
from worlds.errors import WorldError

VIRTUAL_CAPABILITIES = frozenset({"server", "hangup", "baud", "truth"}) | OWN_CAPABILITIES
BULLET_CAPABILITIES = frozenset({"scene", "rays", "contacts", "gravity"})

_LAST_WORDS_S = 0.5
"""How long a client's last bytes may take to pass the wire, so that the next case does not hear them. A choice."""

_TARGET_KINDS = (
    "pioneer",
    "serial:PORT@BAUD",
    "socket://HOST:PORT",
    "listen:pty:PATH",
    "listen:tcp:PORT",
    "exec:COMMAND",
)
_SERVER_CAPABILITIES = frozenset({"server"})


def make_provider(options: CheckOptions) -> BenchProvider:
    """Return the provider that the options mean; nothing is opened yet.

    Raises:
        UsageError: the bench file or the target is wrong.
        UnavailableError: the bench needs something that is not installed.
    """
    bench_file = open_bench(options.bench)
    journal = Journal(options.journal, {"seed": options.seed, "bench": bench_file.name}) if options.journal else None
    shared = Shared(bench_file=bench_file, timeout_scale=options.timeout_scale, journal=journal or Journal())
    if not options.targets:
        return VirtualProvider(shared)
    if len(options.targets) > 1:
        raise UsageError("this bench has one target", where=f"--target {options.targets[1].spec}", hint="name only one")
    return _for_target(shared, options.targets[0].spec)


def _for_target(shared: Shared, spec: str) -> BenchProvider:
    if spec == "pioneer":
        return VirtualProvider(shared)
    kind, _, rest = spec.partition(":")
    if kind == "listen":
        return ListenProvider(shared, rest)
    if kind == "exec" and rest:
        return ExecProvider(shared, rest)
    if rest:
        return AttachedProvider(shared, spec)
    raise UsageError(
        "not a target", where=f"--target {spec}", hint=did_you_mean(spec, _TARGET_KINDS, "a target is one of")
    )


@dataclass(frozen=True, slots=True, kw_only=True)
class Shared:
    """What all benches of a run have in common.

    Attributes:
        bench_file: what was asked for.
        timeout_scale: how much longer to wait.
        journal: where everything is recorded.
    """

    bench_file: BenchFile
    timeout_scale: float
    journal: Journal

    def bench(self, scheduler: Scheduler) -> Bench:
        """Return a bench on a scheduler."""
        return Bench(scheduler, self.journal, timeout_scale=self.timeout_scale)


class VirtualProvider:
    """Gives each case a fresh virtual robot, in its world, in virtual time.

    Args:
        shared: bench file, journal, waiting.
        plan: the robot to build instead of the bench file's.
        make_client: makes the client under test.
        tap: what stands between the checker and the device.
    """

    def __init__(
        self,
        shared: Shared,
        *,
        plan: PioneerPlan | None = None,
        make_client: ClientFactory = make_client,
        tap: Tap = no_tap,
    ) -> None:
        self._shared = shared
        self._plan = plan or plan_of(shared.bench_file)
        self._make_client = make_client
        self._tap = tap

    @property
    def capabilities(self) -> frozenset[str]:
        """Everything, but for what a world without contacts and rays cannot show and what is not fitted."""
        settings, real_physics = self._plan.settings, self._plan.physics != "plane"
        capabilities = VIRTUAL_CAPABILITIES
        if real_physics:
            capabilities |= BULLET_CAPABILITIES
        if real_physics and settings.bumpers_fitted:
            capabilities |= {"bumpers"}
        if settings.aux_loop_back:
            capabilities |= {"aux-loopback"}
        return capabilities

    def describe(self) -> Mapping[str, str]:
        """Name the bench, its target and its physics."""
        physics = f"{self._plan.physics} at {self._plan.step_hz} Hz"
        if self._plan.physics == "plane":
            physics += " (an endless floor without rays and contacts)"
        return {"bench": self._shared.bench_file.name, "target": "virtual Pioneer 2-DX", "physics": physics}

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[VirtualCase]:
        """Open a bench for one case."""
        line = Line(baud=self._plan.settings.host_baud)
        bench = VirtualCase(
            self._shared.bench(Scheduler()), case, self._plan, line, make_client=self._make_client, tap=self._tap
        )
        try:
            yield bench
        except WorldError as error:
            raise UnavailableError(str(error)) from error
        finally:
            bench.close()

    def close(self) -> None:
        """Close the journal."""
        self._shared.journal.close()


class _LockedProvider:
    """What benches with something real attached have in common: one scheduler, locked to the host's clock."""

    def __init__(self, shared: Shared, target: str) -> None:
        self._shared = shared
        self._target = target
        self._host = MonotonicHostClock()
        self._scheduler = Scheduler()
        self._bench = shared.bench(self._scheduler)
        self._locked = False

    def describe(self) -> Mapping[str, str]:
        """Name the target; there is no physics of ours."""
        return {"bench": self._shared.bench_file.name, "target": self._target, "physics": "none of ours"}

    def _lock(self) -> None:
        if not self._locked:
            self._scheduler.lock(self._host)
            self._locked = True

    def close(self) -> None:
        """Give the clock and the journal back."""
        if self._locked:
            self._scheduler.unlock()
        self._host.close()
        self._shared.journal.close(self._bench.now_ns)


class AttachedProvider(_LockedProvider):
    """A server that somebody else runs, at a serial port or behind any pyserial URL.

    The port is opened once, before the first case; between cases the target is settled.

    Args:
        shared: bench file, journal, waiting.
        spec: the target as on the command line.
    """

    def __init__(self, shared: Shared, spec: str) -> None:
        super().__init__(shared, spec)
        self._serial = parse_serial_target(spec)
        self._peer: Peer | None = None

    @property
    def capabilities(self) -> frozenset[str]:
        """A serial line has a rate that can be changed, a socket can be hung up; more is not known of a stranger."""
        is_network = "://" in self._serial.url and not self._serial.url.startswith(("rfc2217:", "spy:", "hwgrep:"))
        return _SERVER_CAPABILITIES | ({"hangup"} if is_network else {"baud"})

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[AttachedCase]:
        """Settle the target and hand it to one case."""
        self._lock()
        if self._peer is None:
            self._peer = Peer(self._bench, self._open_port())
        elif not self._peer.port.line_is_up and not self._peer.line_expected:
            self._peer.attach(self._open_port())
        self._peer.port.baud = self._serial.baud
        self._peer.settle()
        yield AttachedCase(self._bench, case, self._peer, self._open_port)

    def close(self) -> None:
        """Close the port, the clock and the journal."""
        if self._peer is not None:
            self._peer.port.close()
        super().close()

    def _open_port(self) -> Port:
        return SerialPort(self._scheduler, self._serial)


class _ClientProvider(_LockedProvider):
    """A foreign client, which finds our scripted server behind a door."""

    def __init__(self, shared: Shared, target: str, capabilities: frozenset[str]) -> None:
        super().__init__(shared, target)
        self.capabilities = capabilities
        self._port: Port | None = None

    @contextlib.contextmanager
    def open_case(self, case: CaseInfo) -> Iterator[ForeignClientCase]:
        """Put a fresh scripted server behind the door, and take care of the client."""
        self._lock()
        if self._port is None:
            self._port = self._open_door()
        server = ScriptedServer(self._bench, self._port)
        client = self._client()
        try:
            yield ForeignClientCase(self._bench, case, server, client)
        finally:
            client.close()
            server.close()
            self._bench.run_until(lambda: not server.port.line_is_up, _LAST_WORDS_S)

    def close(self) -> None:
        """Close the door, the clock and the journal."""
        if self._port is not None:
            self._port.close()
        super().close()

    def _open_door(self) -> Port:
        raise NotImplementedError

    def _client(self) -> ClientUnderTest:
        raise NotImplementedError


class ListenProvider(_ClientProvider):
    """Waits for whoever connects: ``listen:pty:PATH`` or ``listen:tcp:[HOST:]PORT``."""

    def __init__(self, shared: Shared, spec: str) -> None:
        super().__init__(shared, f"whoever connects to {spec}", LISTEN_CAPABILITIES)
        self._kind, _, self._where = spec.partition(":")
        if self._kind not in {"pty", "tcp"} or not self._where:
            raise UsageError(
                "not a door", where=f"--target listen:{spec}", hint="write listen:pty:PATH or listen:tcp:[HOST:]PORT"
            )

    def _open_door(self) -> Port:
        line = Line(baud=_baud_of(self._shared.bench_file))
        if self._kind == "pty":
            return PtyDoor(self._scheduler, self._where, line)
        return TcpDoor(self._scheduler, self._where, line)

    def _client(self) -> ClientUnderTest:
        assert self._port is not None
        return ListenClient(self._bench, self._port)


class ExecProvider(_ClientProvider):
    """Starts a program for each case: ``exec:COMMAND``, with ``{pty}`` or ``{port}`` where it is to connect."""

    def __init__(self, shared: Shared, command: str) -> None:
        super().__init__(shared, command, EXEC_CAPABILITIES)
        self._command = command
        self._names: dict[str, str] = {}
        if "{pty}" not in command and "{port}" not in command:
            raise UsageError(
                "does not say where to connect", where=f"--target exec:{command}", hint="put {pty} or {port} into it"
            )

    def _open_door(self) -> Port:
        line = Line(baud=_baud_of(self._shared.bench_file))
        if "{pty}" in self._command:
            pty = PtyDoor(self._scheduler, None, line)
            self._names = {"pty": pty.slave_name}
            return pty
        tcp = TcpDoor(self._scheduler, "127.0.0.1:0", line)
        self._names = {"port": str(tcp.port)}
        return tcp

    def _client(self) -> ClientUnderTest:
        return ExecClient(self._command, self._names)


def _baud_of(bench_file: BenchFile) -> int:
    return bench_file.links[0].baud if bench_file.links else Line().baud
