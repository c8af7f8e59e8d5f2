"""A simulator's side of somebody else that reports on a line of its own what its car is commanded.

==========================================================  ======================================================
The simulator's side says
``{"commanded": "AckermannCommand", "speed_m_s": 5.0,       the car was commanded this: the name and the fields of a
... "mode": 1, "by_node": false}``                          command, and those of `Published`
The simulator's side hears
``{"by_hand": true}``                                       say no status by itself any more
``{"sense": {"lon_speed_m_s": 3.0, ...}}``                  so the car moves now: a `CarState`
``{"report": ["velocity", "steering"]}``                    report so much of it, as a simulator does at each step
==========================================================  ======================================================
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import msgspec

from hilbench.bench import Bench
from hilbench.bench.report_line import ClientReports, ReportLine
from hilbench.links import Port
from hilbench.systems.vehicle.car_simulator import CarSimulator, Published
from protocols.carla import AckermannCommand, ManualCommand
from targets.robots.car_host import CarState

__all__ = ["REPORTED_CAPABILITIES", "CarReporter", "ReportingCar"]

REPORTED_CAPABILITIES = frozenset({"car.reported"})

_COMMANDS: Mapping[str, type[AckermannCommand | ManualCommand]] = {
    kind.__name__: kind for kind in (AckermannCommand, ManualCommand)
}
_OF_PUBLISHED = ("mode", "by_node")


class ReportingCar:
    """What the checker knows of such a car.

    Args:
        bench: whose time is used.
        port: the checker's end of the line on which it reports.
    """

    def __init__(self, bench: Bench, port: Port) -> None:
        self._bench = bench
        self._published: list[Published] = []
        self._line = ClientReports(port, "the simulator's side", self._understand)

    @property
    def published(self) -> list[Published]:
        """What the car was commanded, oldest first, each with the time at which it was reported.

        Raises:
            Violation: something that was reported makes no sense.
        """
        self._line.require_sense()
        return self._published

    def report_by_hand(self) -> None:
        """Have it say no status by itself any more."""
        self._line.say({"by_hand": True})

    def sense(self, state: CarState) -> None:
        """Have its car move so."""
        self._line.say({"sense": asdict(state)})

    def report(self, *what: str) -> None:
        """Have it report ``velocity`` or ``steering``."""
        self._line.say({"report": list(what)})

    def _understand(self, said: Mapping[str, Any]) -> None:
        fields = {name: value for name, value in said.items() if name not in ("commanded", *_OF_PUBLISHED)}
        command = msgspec.convert(fields, _COMMANDS[said["commanded"]])
        mode, by_node = msgspec.convert((said["mode"], said["by_node"]), tuple[int | None, bool])
        self._published.append(Published(ns=self._bench.now_ns, command=command, mode=mode, by_node=by_node))


class CarReporter:
    """The other end: has our simulator's side report what its car is commanded, and do what it is told to.

    Args:
        bench: whose time is used.
        simulator: whose hands are taken.
        port: its end of the line.
    """

    def __init__(self, bench: Bench, simulator: CarSimulator, port: Port) -> None:
        del bench
        self._simulator = simulator
        self._line = ReportLine(port, self._take)
        simulator.on_published = self._report

    def _report(self, one: Published) -> None:
        about = {name: getattr(one, name) for name in _OF_PUBLISHED}
        self._line.say({"commanded": type(one.command).__name__, **asdict(one.command), **about})

    def _take(self, said: Mapping[str, Any]) -> None:
        if said.get("by_hand"):
            self._simulator.report_by_hand()
        if "sense" in said:
            self._simulator.sense(msgspec.convert(said["sense"], CarState))
        if "report" in said:
            self._simulator.report(*said["report"])
