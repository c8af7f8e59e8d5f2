"""All that is known of a bench: one object that takes events and never asks anybody."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from hilbench.tui.model.checks import ChecksModel
from hilbench.tui.model.consoles import ConsoleModel
from hilbench.tui.model.dashboards import dashboard_of
from hilbench.tui.model.frames import FramesModel, MessageModel
from hilbench.tui.model.log import LogModel
from hilbench.tui.model.machines import MachineModel, is_change
from hilbench.tui.model.pins import PinsModel
from hilbench.tui.model.places import WorldModel
from hilbench.tui.model.rates import Counted
from hilbench.tui.model.signals import SignalsModel
from hilbench.tui.model.tables import TablesModel

__all__ = ["SLOW_FACTOR", "BenchModel", "DriverModel", "LineModel"]

Event = Mapping[str, Any]

SLOW_FACTOR = 0.98
"""A bench that is slower than this is shown to be (choice)."""


@dataclass(slots=True)
class LineModel:
    """The operator's end of a line.

    Attributes:
        about: what was reported last: port, rate, whether it is up, what waits.
        counters: bytes and errors, by name.
        outages: how often it went down; a line that was never up has not.
    """

    about: Event = field(default_factory=dict)
    counters: dict[str, Counted] = field(default_factory=dict)
    outages: int = 0

    def take(self, event: Event) -> None:
        """Take what is reported of it."""
        if self.about.get("up", False) and not event["up"]:
            self.outages += 1
        self.about = event
        for name, value in event.items():
            if type(value) is int and name not in {"ns", "baud", "pending"}:
                self.counters.setdefault(name, Counted()).take(value, event["ns"])


@dataclass(frozen=True, slots=True, kw_only=True)
class DriverModel:
    """Who drives, and with which shares."""

    who: str = ""
    forward: float = 0.0
    turn: float = 0.0

    @property
    def by_hand(self) -> bool:
        """Whether a person does."""
        return self.who == "user"

    @property
    def nobody(self) -> bool:
        """Whether nobody does."""
        return self.who in {"", "nobody", "dead man"}


class BenchModel:
    """See the module.

    Args:
        header: the first line of the journal.

    Attributes:
        ns: the latest bench time that was reported.
        taken: how many events were.
        ended: whether the journal was closed in good order.
        faults: how often each struck.
        armed: those that go on striking until they are taken back, in words.
        dashboard: how it is shown.
        seen: what was reported last of what its system shows of its own; empty before.
    """

    def __init__(self, header: Event) -> None:
        self.header = header
        live = self.live = header.get("live", {})
        self.ns = 0
        self.taken = 0
        self.ended = False
        self.machines = {name: MachineModel(name, table) for name, table in live.get("machines", {}).items()}
        self.lines: dict[str, LineModel] = {}
        self.frames = FramesModel(live)
        self.world = WorldModel.of(live)
        self.pins = PinsModel(live)
        self.dashboard, problems = dashboard_of(live)
        self.tables = TablesModel()
        self.signals = SignalsModel(self.dashboard, live, self.frames, self.tables)
        self.console = ConsoleModel(live)
        self.checks = ChecksModel()
        self.log = LogModel(self.dashboard)
        for problem in problems:
            self.log.say(0, "screen", problem)
        self.faults: Counter[str] = Counter()
        self.armed: list[str] = []
        self.pace: Event = {}
        self.driver = DriverModel()
        self.seen: Event = {}
        self.paused = False
        self.speed = 1.0

    @property
    def name(self) -> str:
        """The bench."""
        return str(self.header.get("bench", ""))

    @property
    def messages(self) -> list[MessageModel]:
        """The messages that there were; those that still come stand first."""
        return sorted(self.frames.messages, key=lambda one: one.per_s(self.ns) == 0)

    @property
    def factor(self) -> float | None:
        """Bench seconds in a second of what is wanted, at present; None before that was reported."""
        return self.pace.get("recent", self.pace["factor"]) if self.pace else None

    @property
    def slow(self) -> bool:
        """Whether the host does not keep up at present."""
        return self.factor is not None and self.factor < SLOW_FACTOR and not self.paused

    def take(self, events: Iterable[Event]) -> None:
        """Take events in the order of the journal; one that is not understood is none."""
        for event in events:
            self.taken += 1
            self.ns = max(self.ns, event["ns"])
            try:
                self._take(event)
                self.signals.take(event)
                self.log.take(event)
            except Exception:  # noqa: BLE001, S112 - of another version, touched, or a plug-in's words: the rest is shown
                continue

    def _take(self, event: Event) -> None:
        match event["kind"]:
            case "tx" | "rx":
                self.signals.take_frames(self.frames.take(event))
                self.console.take(event)
            case "machine":
                self.machines.setdefault(event["source"], MachineModel(event["source"])).take(event)
            case "event":
                self._take_reported(event)
            case "link":
                self.lines.setdefault(event["source"], LineModel()).take(event)
            case "scene" | "pose":
                self.world.take(event)
            case "pin" | "pwm" | "volts":
                self.pins.take(event)
            case "fault":
                self.faults[f"{event['fault']} towards {event['towards']}"] += 1
            case "host-pace":
                self.pace = event
            case "table":
                self.tables.take(event)
            case _:
                self._take_rare(event)

    def _take_rare(self, event: Event) -> None:
        match event["kind"]:
            case "driver":
                self.driver = DriverModel(who=event["who"], forward=event["forward"], turn=event["turn"])
            case "clock":
                self.paused, self.speed = event["paused"], event["speed"]
            case "host-end":
                self.ended = True
            case "console":
                self.console.take(event)
            case "case" | "verdict":
                self.checks.take(event)
            case "armed":
                self.armed.append(self._armed(event))
            case "disarmed":
                self.armed.clear()
            case "standing":
                self._take_standing(event)
            case self.dashboard.tells:
                self.seen = event

    def _take_standing(self, event: Event) -> None:
        """Take what was reported before this journal begins, or where it was passed over."""
        self.paused, self.speed = event["paused"], event["speed"]
        if event["driver"] is not None:
            who, forward, turn = event["driver"]
            self.driver = DriverModel(who=who, forward=forward, turn=turn)
        self.armed = [self._armed(one) for one in event["armed"]]
        self.faults = Counter({f"{fault} towards {towards}": count for fault, towards, count in event["struck"]})
        for name, count in event.get("outages", {}).items():
            if name in self.lines:
                self.lines[name].outages = count
        for source, (level, edges, fast) in event.get("pins", {}).items():
            self.pins.take_standing(source, event["ns"], level, edges, fast=fast)

    def _armed(self, event: Event) -> str:
        about = f"{event['fault']} {event['probability']:.2g} towards {event['towards']}"
        return about if len(self.lines) < 2 else f"{about} on {event['source']}"

    def _take_reported(self, event: Event) -> None:
        value = event.get("value", {})
        if is_change(value):
            for machine in self.machines.values():
                if machine.is_meant(event):
                    machine.change(event)
        elif event["source"] == self.live.get("operator"):
            self.world.take_echoes(self.dashboard.echoes(self.live, value))
