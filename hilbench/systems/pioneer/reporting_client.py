"""A P2OS client of somebody else that reports on a line of its own what it understood, and does what it is told there.

======================================================  ==========================================================
The client says
``{"state": "OPEN", "failure": ""}``                    where its connection is, a name of `ClientState`, and why it
                                                        failed or was lost; behind what it learned on the way there
``{"identification": {"name": "bench", ...}}``          what the robot said it is
``{"config": {"robot_type": "Pioneer", ...}}``          its configuration, a `ConfigPacket`
``{"sip": {...}, "reading": {...}, "pose": {...}}``     a SIP that it understood: its fields as in `Sip`, the same in
                                                        physical units as in `SipReading`, and where the robot is then,
                                                        a `Pose`
The client hears
``{"send": 11, "argument": -200}``                      a command that it has to send, by its number; a string as
                                                        ``{"text": "0102"}``, in hexadecimal digits
``{"wheels": [100.0, 200.0]}``                          drive each wheel at a speed, in mm/s
======================================================  ==========================================================
"""

from __future__ import annotations

import contextlib
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any, TypeVar

import msgspec

from hilbench.bench import Bench
from hilbench.bench.report_line import ClientReports, ReportLine
from hilbench.links import Port
from hilbench.systems.pioneer.client import P2osClient
from protocols.p2os import (
    ClientState,
    CommandNumber,
    ConfigPacket,
    Identification,
    LocalProtocolError,
    Pose,
    RobotParameters,
    Sip,
    SipReading,
)

__all__ = ["REPORTED_CAPABILITIES", "ClientReporter", "ReportingClient"]

REPORTED_CAPABILITIES = frozenset({"client.report", "client.commands"})

KindT = TypeVar("KindT")

_TAIL = "tail"
"""What late firmware appends to a SIP is not reported."""


@dataclass(frozen=True, slots=True)
class _Reported:
    """Where the robot is, as a tracker has it."""

    pose: Pose


class ReportingClient:
    """What the checker knows of such a client.

    Args:
        bench: whose time is used.
        port: the checker's end of the line on which it reports.

    Attributes:
        state: where its connection is.
        failure: why connecting failed, or why the connection was lost; empty if neither happened.
        identification: what the robot said it is; None before that.
        config: the robot's configuration; None if it did not report it.
        reading: the newest SIP in physical units; None before the session.
        pose: where the robot is; None before the session.
        robot: None: it does not report which parameters it took.
    """

    robot: RobotParameters | None = None

    def __init__(self, bench: Bench, port: Port) -> None:
        del bench
        self.state = ClientState.IDLE
        self.failure = ""
        self.identification: Identification | None = None
        self.config: ConfigPacket | None = None
        self.reading: SipReading | None = None
        self.pose: _Reported | None = None
        self._sips: list[Sip] = []
        self._line = ClientReports(port, "the client", self._understand)

    @property
    def sips(self) -> list[Sip]:
        """The SIPs that it understood, oldest first.

        Raises:
            Violation: something that it reported makes no sense.
        """
        self._line.require_sense()
        return self._sips

    # --- what it is told

    def send(self, number: int, argument: int | bytes | None = None) -> None:
        """Have it send a command."""
        said = {"text": argument.hex()} if isinstance(argument, bytes) else {"argument": argument}
        self._line.say({"send": int(number), **said})

    def enable(self) -> None:
        """Have it give the motors power."""
        self.send(CommandNumber.ENABLE, 1)

    def drive(self, speed_mm_s: float) -> None:
        """Have it drive straight on."""
        self.send(CommandNumber.VEL, round(speed_mm_s))

    def drive_wheels(self, left_mm_s: float, right_mm_s: float) -> None:
        """Have it drive each wheel."""
        self._line.say({"wheels": [left_mm_s, right_mm_s]})

    # --- what it reports

    def _understand(self, said: Mapping[str, Any]) -> None:
        if "state" in said:
            self.state = ClientState[said["state"]]
            over = self.state.value if self.state in (ClientState.FAILED, ClientState.LOST) else ""
            self.failure = _as(str, said.get("failure", "")) or over  # it need not know why
        if "identification" in said:
            self.identification = _as(Identification, said["identification"])
        if "config" in said:
            self.config = _as(ConfigPacket, said["config"])
        if "sip" in said:
            sip = _as(Sip, said["sip"])
            self.reading, self.pose = _as(SipReading, said["reading"]), _Reported(_as(Pose, said["pose"]))
            self._sips.append(sip)


def _as(kind: type[KindT], said: object) -> KindT:
    return msgspec.convert(said, kind, str_keys=True)


class ClientReporter:
    """The other end: has our client report what it understood, and do what it is told to.

    Args:
        bench: whose time is used.
        client: whose hands are taken.
        port: its end of the line.
    """

    def __init__(self, bench: Bench, client: P2osClient, port: Port) -> None:
        del bench
        self._client = client
        self._line = ReportLine(port, self._take)
        self._said: dict[str, object] = {}
        self._sips = 0
        client.on_event = self._report

    def _report(self) -> None:
        client = self._client
        for name, packet in (("identification", client.identification), ("config", client.config)):
            if packet is not None:
                self._report_new(name, {name: asdict(packet)})
        reading, sips = client.reading, client.sips
        if reading is not None and client.pose is not None and len(sips) > self._sips:
            sip = {name: value for name, value in asdict(sips[-1]).items() if name != _TAIL}
            read = {**asdict(reading), "no_echo": sorted(reading.no_echo)}
            self._line.say({"sip": sip, "reading": read, "pose": asdict(client.pose.pose)})
        self._sips = len(sips)
        if client.identification is not None or client.state is not ClientState.OPEN:
            self._report_new("state", {"state": client.state.name, "failure": client.failure})

    def _report_new(self, name: str, said: dict[str, object]) -> None:
        if self._said.get(name) != said:
            self._said[name] = said
            self._line.say(said)

    def _take(self, said: Mapping[str, Any]) -> None:
        with contextlib.suppress(LocalProtocolError):  # what it refuses does not go out, and that is seen
            if "wheels" in said:
                self._client.drive_wheels(*said["wheels"])
            else:
                text, argument = said.get("text"), said.get("argument")
                self._client.send(said["send"], argument if text is None else bytes.fromhex(text))
