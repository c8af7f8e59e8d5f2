"""A car host on a bench: what the suite ``vehicle-host`` puts to the test where nothing else is named.

It stands at any port. What the car does is given by `sense`; what it was commanded is kept with its time.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from hilbench.bench import Bench
from hilbench.bench.devices import DeviceActor
from hilbench.bench.under_test import OwnUnderTest
from hilbench.links import Port
from protocols.carla import AckermannCommand, LocalProtocolError, ManualCommand, SimulatorReader
from targets.robots.car_host import CarCommanded, CarHost, CarHostSettings, CarState

__all__ = [
    "OWN_HOST_CAPABILITIES",
    "CarSimulator",
    "HostFactory",
    "OwnCarHost",
    "Published",
    "make_host",
]

OWN_HOST_CAPABILITIES = frozenset({"simulator", "car", "read errors"})

HostFactory = Callable[[CarHostSettings, int], CarHost]


def make_host(settings: CarHostSettings, power_on_ns: int) -> CarHost:
    """Make the car host as it is meant to be; what takes its place in a test may be a faulty one."""
    return CarHost(settings, power_on_ns=power_on_ns)


@dataclass(frozen=True, slots=True, kw_only=True)
class Published:
    """Something that the car was commanded.

    Attributes:
        ns: bench time of it.
        command: what.
        mode: the mode byte of the frame that says so; None where no frame does. A stop in AUTOWARE and an emergency are
            told apart by it alone.
        by_node: CARLA's ackermann node says it again, and no frame does.
    """

    ns: int
    command: AckermannCommand | ManualCommand
    mode: int | None
    by_node: bool


class CarSimulator:
    """See the module.

    Args:
        bench: whose time and journal are used.
        port: its end of the line.
        settings: of the car host.
        make_host: makes it.

    Attributes:
        published: what the car was commanded, oldest first.
        on_published: called with each of these.
    """

    def __init__(
        self, bench: Bench, port: Port, settings: CarHostSettings, *, make_host: HostFactory = make_host
    ) -> None:
        self._bench = bench
        self._port = port
        self._settings = settings
        self._make_host = make_host
        self._host: CarHost | None = None
        self.published: list[Published] = []
        self.on_published: Callable[[Published], None] = lambda _one: None

    @property
    def host(self) -> CarHost:
        """The car host.

        Raises:
            LocalProtocolError: it was not started.
        """
        if self._host is None:
            raise LocalProtocolError("the simulator's side was not started")
        return self._host

    @property
    def backlog_s(self) -> float:
        """How long it takes to read what has come already, if it reads in pieces; in seconds."""
        options = self.host.behaviour.line
        if options.reader is not SimulatorReader.POLL:
            return 0.0
        return self.host.connection.held / options.poll.bytes_each * options.poll.period_s

    def connect(self) -> None:
        """Start it.

        Raises:
            LocalProtocolError: it runs already.
        """
        if self._host is not None:
            raise LocalProtocolError("the simulator's side runs already")
        self._host = self._make_host(self._settings, self._bench.now_ns)
        self._actor = DeviceActor(self._bench, self._host, self._port, name="car", on_event=self._keep)

    def disconnect(self) -> None:
        """Nothing: the line has no leave-taking."""

    def hear(self, data: bytes) -> None:
        """Take bytes at once, without the line; many of them in a moment."""
        self._actor.transmit(self.host.receive(data, self._bench.now_ns))

    def sense(self, state: CarState) -> None:
        """Take how the car moves now."""
        self.host.sense(state)

    def report_by_hand(self) -> None:
        """Say no status by itself any more."""
        self.host.report_by_hand()
        self._actor.settle()

    def report(self, *what: str) -> None:
        """Say ``velocity`` or ``steering``, as a simulator does at each of its steps."""
        self._actor.transmit(self.host.report(*what, now_ns=self._bench.now_ns))

    def read_error(self, *, failing: bool) -> None:
        """Let reading the line fail from now on, or work again."""
        self._actor.transmit(self.host.read_error(failing=failing, now_ns=self._bench.now_ns))

    def _keep(self, event: object) -> None:
        if isinstance(event, CarCommanded):
            now_ns = self._bench.now_ns
            published = Published(ns=now_ns, command=event.command, mode=event.mode, by_node=event.by_node)
            self.published.append(published)
            self.on_published(published)


class OwnCarHost(OwnUnderTest[CarSimulator]):
    """That of this package."""

    def __init__(self, simulator: CarSimulator) -> None:
        super().__init__(simulator, called="simulator's side", refusal=LocalProtocolError)
