"""A foreign ground station that reports on a line of its own what it understood, and does what it is told there.

======================================================  ==========================================================
The station says
``{"report": "GeneralReport", "accepted": 7, ...}``     it has understood a report: its name and fields, as in
                                                        `protocols.pkt`
``{"state": "LINKED"}``                                 whether it hears its rover: a name of `ClientState`
``{"totals": {"accepted": 300, "rejected": 0}}``        what the rover's counters have come to
The station hears
``{"send": "MotorThrottles", "a": 0.5, ...}``           a command that it has to send, as above
======================================================  ==========================================================
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from dataclasses import asdict
from typing import Any

import msgspec

from hilbench.bench import Bench
from hilbench.bench.report_line import ClientReports, ReportLine
from hilbench.clock import NS_PER_MS
from hilbench.links import Port
from hilbench.systems.rover.ground_station import GroundStation, Telemetry
from protocols.pkt import (
    ClientOptions,
    ClientState,
    Command,
    ExecutionReport,
    GeneralReport,
    GpsReport,
    ImuReport,
    LedOff,
    LedOn,
    MotionReport,
    MotorThrottles,
    PacketTotals,
    PidGains,
    Profile,
    Report,
    RequestTelemetry,
    SpeedSetpoints,
)

__all__ = ["REPORTED_CAPABILITIES", "ReportingStation", "StationReporter"]

LOOK_NS = 50 * NS_PER_MS
"""How often a change of state is looked for. A choice."""

REPORTED_CAPABILITIES = frozenset({"client.report", "client.commands"})

_COMMANDS: Mapping[str, type[Command]] = {
    kind.__name__: kind for kind in (RequestTelemetry, LedOn, LedOff, MotorThrottles, SpeedSetpoints, PidGains)
}
_REPORTS: Mapping[str, type[Report]] = {
    kind.__name__: kind for kind in (GeneralReport, ExecutionReport, ImuReport, MotionReport, GpsReport)
}


class ReportingStation:
    """What the checker knows of such a station.

    Args:
        bench: whose time is used.
        port: the checker's end of the line on which it reports.
        profile: what the rover speaks.

    Attributes:
        options: those of the profile's client.
        counts: how many reports of each kind it has understood.
        latest: the newest report of each kind.
        state: whether it hears its rover.
    """

    def __init__(self, bench: Bench, port: Port, profile: Profile) -> None:
        self.options: ClientOptions = profile.client
        self.state = ClientState.IDLE
        self.latest: dict[type[Report], Telemetry] = {}
        self._bench = bench
        self._counts: Counter[type[Report]] = Counter()
        self._totals: PacketTotals | None = None
        self._line = ClientReports(port, "the client", self._understand)

    @property
    def counts(self) -> Counter[type[Report]]:
        """How many reports of each kind it has understood.

        Raises:
            Violation: something that it reported makes no sense.
        """
        self._line.require_sense()
        return self._counts

    @property
    def totals(self) -> PacketTotals | None:
        """What the rover's counters have come to; None before it said so."""
        return self._totals

    def send(self, command: Command) -> None:
        """Have it send a command."""
        self._line.say({"send": type(command).__name__, **asdict(command)})

    def _understand(self, said: Mapping[str, Any]) -> None:
        if "report" in said:
            fields = {name: value for name, value in said.items() if name != "report"}
            report = msgspec.convert(fields, _REPORTS[said["report"]])
            self._counts[type(report)] += 1
            self.latest[type(report)] = Telemetry(ns=self._bench.now_ns, report=report)
        if "state" in said:
            self.state = ClientState[said["state"]]
        if "totals" in said:
            self._totals = msgspec.convert(said["totals"], PacketTotals)


class StationReporter:
    """The other end: has a ground station report what it understood, and send what it is told to.

    Args:
        bench: whose time is used.
        station: whose hands are taken.
        port: the client's end of the line.
    """

    def __init__(self, bench: Bench, station: GroundStation, port: Port) -> None:
        self._bench = bench
        self._station = station
        self._line = ReportLine(port, self._take)
        self._state = station.state
        station.on_report = self._report
        self._look()

    def _report(self, telemetry: Telemetry) -> None:
        report = telemetry.report
        if type(report).__name__ in _REPORTS:
            self._line.say({"report": type(report).__name__, **asdict(report)})
        if self._station.totals is not None:
            self._line.say({"totals": asdict(self._station.totals)})

    def _look(self) -> None:
        if self._station.state is not self._state:
            self._state = self._station.state
            self._line.say({"state": self._state.name})
        self._bench.scheduler.after(LOOK_NS, self._look, source="~reporter")

    def _take(self, said: Mapping[str, Any]) -> None:
        fields = {name: value for name, value in said.items() if name != "send"}
        self._station.send(msgspec.convert(fields, _COMMANDS[said["send"]]))
