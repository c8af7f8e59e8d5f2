"""Foreign ends of a line, in bench time: what a provider finds there is a script of ours, and never late."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from hilbench.bench import Bench
from hilbench.bench.client_under_test import ClientUnderTest, ListenClient
from hilbench.bench.locked_providers import FarEnd, ListenProvider
from hilbench.bench.shared import Shared
from hilbench.clock import NS_PER_S
from hilbench.links import Line, MemoryLink, Port, SerialTarget
from hilbench.systems.rover.provider import AttachedRoverProvider
from hilbench.systems.vehicle.provider import AttachedVehicleProvider
from hilbench.terminal.options import TargetChoice
from targets.robots.vehicle_interface import LINE_BAUD, SIMULATOR_LINE, STACK_LINE

Script = Callable[[Bench, Port], None]
"""Puts something at a port."""

BoardScript = Callable[[Bench, Mapping[str, Port]], None]
"""Puts a board at two ports, by its names for them."""


def saying(data: bytes, every_s: float) -> Script:
    """Says the same for ever, whatever it hears."""

    def begin(bench: Bench, port: Port) -> None:
        def say() -> None:
            port.write(data)
            bench.scheduler.at(bench.now_ns + round(every_s * NS_PER_S), say)

        say()

    return begin


class _Stays(ListenClient):
    """A client that is there, and does not leave between cases."""

    def start(self) -> None:
        """It is."""


class ForeignClientInBenchTime(ListenProvider):
    """Serves a client of which only the line is seen."""

    def __init__(self, shared: Shared, far_end: FarEnd, script: Script) -> None:
        super().__init__(shared, "tcp:0", far_end)
        self.capabilities |= {"client.disconnect"}
        self._script = script

    def _lock(self) -> None:
        """Time is virtual."""

    def _open_door(self) -> tuple[Port, str]:
        link = MemoryLink(self._scheduler, Line(), name="foreign")
        self._script(self._bench, link.b)
        return link.a, link.a.name

    def _client(self) -> ClientUnderTest:
        assert self._port is not None
        return _Stays(self._bench, self._port)


class ForeignRoverInBenchTime(AttachedRoverProvider):
    """Checks a rover of which only the line is seen."""

    def __init__(self, shared: Shared, script: Script) -> None:
        super().__init__(shared, "serial:/dev/none")
        self._script = script

    def _lock(self) -> None:
        """Time is virtual."""

    def _open_port(self) -> Port:
        link = MemoryLink(self._scheduler, Line(baud=self.USUAL_BAUD), name="foreign")
        self._script(self._bench, link.b)
        return link.a


class ForeignVehicleInBenchTime(AttachedVehicleProvider):
    """Checks a vehicle-interface board of which only its two lines are seen."""

    def __init__(self, shared: Shared, script: BoardScript) -> None:
        ports = [TargetChoice(name=line, spec=f"serial:/dev/{line}") for line in ("simulator", "stack")]
        super().__init__(shared, ports)
        links = {line: MemoryLink(self._scheduler, Line(baud=LINE_BAUD), name=line) for line in _VEHICLE_LINES}
        self._near = iter([link.a for link in links.values()])
        script(self._bench, {line: link.b for line, link in links.items()})

    def _lock(self) -> None:
        """Time is virtual."""

    def _open_serial(self, target: SerialTarget) -> Port:
        del target
        return next(self._near)


_VEHICLE_LINES = (SIMULATOR_LINE, STACK_LINE)
