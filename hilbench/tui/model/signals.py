"""Figures over time: how the vehicle moves, what far end and pins tell, how the line is used; each with its unit."""

from __future__ import annotations

import math
from bisect import bisect_left
from collections import deque
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from hilbench.plugins.dashboard import Dashboard
from hilbench.tui.model.frames import LEAST_STEP_NS, Field, FrameModel, FramesModel
from hilbench.tui.model.tables import RowModel, TablesModel

__all__ = ["LEAST_STEP_NS", "Signal", "SignalsModel", "field_signal"]

Event = Mapping[str, Any]
NS_PER_S = 1_000_000_000
_KEPT = 6000
"""Points: five minutes at the least step."""
_SLOWEST_PWM_NS = 100_000_000
_MOST_PARTS = 4
_MOST_USUAL = 4
_LATENESS = "lateness p99"


@dataclass(slots=True)
class Signal:
    """A figure over time, or a few that belong together, as those of four wheels.

    Attributes:
        unit: of its values; empty of a bare number.
        parts: bench times in ns, rising, and values, of each of them.
    """

    unit: str
    parts: list[deque[tuple[int, float]]] = field(default_factory=list)

    def take(self, ns: int, values: Sequence[float]) -> None:
        """Take a value of each part; those that come too soon after the last are left out, as is what is no number."""
        while len(self.parts) < len(values):
            self.parts.append(deque(maxlen=_KEPT))
        for points, value in zip(self.parts, values, strict=False):
            if math.isfinite(value) and (not points or ns - points[-1][0] >= LEAST_STEP_NS):
                points.append((ns, value))

    def since(self, ns: int) -> list[list[tuple[int, float]]]:
        """Return the points of each part from a bench time on, and the one before."""
        found = []
        for part in self.parts:
            points = list(part)
            found.append(points[max(0, bisect_left(points, (ns, -math.inf)) - 1) :])
        return found


class SignalsModel:
    """The figures that were recorded.

    Args:
        dashboard: says which figures matter.
        live: what the header of the journal says of the bench.
        frames: those of the bench; each field of their messages is a figure, too.
        tables: those of the bench; so is each field of their rows.
    """

    def __init__(
        self,
        dashboard: Dashboard,
        live: Event,
        frames: FramesModel | None = None,
        tables: TablesModel | None = None,
    ) -> None:
        self._frames = frames
        self._tables = tables
        self.signals: dict[str, Signal] = {}
        self._dashboard = dashboard
        self._live = live
        self._ahead: dict[int, float | None] = {}
        self._pose: Event | None = None
        self._line: dict[str, Event] = {}
        self._rises: dict[str, tuple[int, int | None]] = {}

    def usual(self) -> list[str]:
        """Return what is plotted unless somebody chooses: the first of each sort that matters on such a bench."""
        found: list[str] = []
        for word in self._dashboard.plots:
            named = [name for name in self.signals if name.endswith(f" {word}")]
            found += [word] if word in self.signals else named[:1]
        return found[:_MOST_USUAL] or sorted(self.signals, key=lambda name: name == _LATENESS)[:_MOST_USUAL]

    def signal(self, name: str) -> Signal | None:
        """Return a figure, or a field of a message or of a row by what that is called; None if there is no such."""
        if name in self.signals:
            return self.signals[name]
        found = None if self._tables is None else self._tables.field(name)
        if found is not None:
            row, one = found
            return _of_row(row, one)
        if self._frames is None:
            return None
        for message in self._frames.messages:
            frame = message.latest
            for one in frame.fields:
                if field_signal(frame, one.name) == name:
                    return _of_field(self._frames, frame, one)
        return None

    def take(self, event: Event) -> None:
        """Take what an event tells."""
        match event["kind"]:
            case "pose":
                self._take_pose(event)
            case "pin":
                self._take_edge(event)
            case "pwm":
                self._take_wave(event)
            case "link":
                self._take_line(event)
            case "host-pace":
                self._put(_LATENESS, "ms", event["ns"], event["p99_ns"] / 1e6)

    def take_frames(self, frames: Iterable[FrameModel]) -> None:
        """Take what the far end says: all of its fields that have a unit."""
        for frame in frames:
            if frame.sent or not frame.good:
                continue
            # Of several lines the same word means several things: a speed that is commanded, one that is reported.
            of = f"{frame.item.name} " if frame.line else ""
            for one in frame.fields:
                if one.quantity.unit and 0 < len(one.numbers) <= _MOST_PARTS:
                    self._put(of + one.quantity.label, one.quantity.unit, frame.ns, *one.numbers)
            self._take_echoes(frame.item.fields, frame.ns)

    # --- how it moves

    def _take_pose(self, event: Event) -> None:
        before, self._pose = self._pose, event
        if before is None or event["ns"] <= before["ns"]:
            return
        span_s = (event["ns"] - before["ns"]) / NS_PER_S
        yaw, was = event["yaw_rad"] / 1e6, before["yaw_rad"] / 1e6
        along_m = (
            (event["x_m"] - before["x_m"]) * math.cos(was) + (event["y_m"] - before["y_m"]) * math.sin(was)
        ) / 1e6
        turned = math.remainder(yaw - was, math.tau)
        self._put("speed", "m/s", event["ns"], along_m / span_s)
        self._put("turn rate", "°/s", event["ns"], math.degrees(turned) / span_s)

    # --- what is recorded

    def _take_echoes(self, fields: Event, ns: int) -> None:
        """Take the least of what the sensors heard last that look ahead; nothing where none of them hears anything."""
        ahead = {one.number: one.range_m for one in self._dashboard.echoes(self._live, fields) if one.ahead}
        self._ahead |= ahead
        heard = [range_m for range_m in self._ahead.values() if range_m is not None]
        if ahead and heard:
            self._put("range ahead", "m", ns, min(heard))

    # --- pins and lines

    def _take_wave(self, event: Event) -> None:
        high = 1.0 if event.get("level") else 0.0
        if event.get("edges", 0) and event.get("period_ns"):
            high = event.get("duty", event["high_ns"] / event["period_ns"])
        self._put(f"{_pin(event['source'])} duty", "%", event["ns"], 100 * high)

    def _take_edge(self, event: Event) -> None:
        """Take an edge of a pin whose edges are recorded one by one; its duty is known with the end of a period."""
        ns, source = event["ns"], event["source"]
        rise_ns, fall_ns = self._rises.get(source, (None, None))
        if not event["level"]:
            if rise_ns is not None:
                self._rises[source] = (rise_ns, ns)
            return
        self._rises[source] = (ns, None)
        if rise_ns is not None and fall_ns is not None and 0 < ns - rise_ns <= _SLOWEST_PWM_NS:
            self._put(f"{_pin(source)} duty", "%", ns, 100 * (fall_ns - rise_ns) / (ns - rise_ns))

    def _take_line(self, event: Event) -> None:
        before = self._line.get(event["source"])
        if before is not None and event["ns"] - before["ns"] < NS_PER_S // 2:
            return
        self._line[event["source"]] = event
        if before is None:
            return
        span_s = (event["ns"] - before["ns"]) / NS_PER_S
        of = f"{event['source']} " if len(self._line) > 1 else ""
        for counter, word in (("sent", "sent"), ("received", "heard")):
            if counter in event and counter in before:
                self._put(of + word, "B/s", event["ns"], (event[counter] - before[counter]) / span_s)

    def _put(self, name: str, unit: str, ns: int, *values: float) -> None:
        signal = self.signals.setdefault(name, Signal(unit))
        if signal.unit != unit:  # two fields with one name, such as a speed in mm/s and one in %
            signal = self.signals.setdefault(f"{name} in {unit}", Signal(unit))
        signal.take(ns, values)


def field_signal(frame: FrameModel, field: str) -> str:
    """Return what a field of a message is called as a figure."""
    line, sent, name = frame.message
    return f"{line} {'>' if sent else '<'} {name}.{field}".strip()


def _of_field(frames: FramesModel, frame: FrameModel, field: Field) -> Signal:
    signal = Signal(field.quantity.unit)
    for ns, numbers in frames.series(frame.message, field.name):
        signal.take(ns, numbers[:_MOST_PARTS])
    return signal


def _of_row(row: RowModel, field: Field) -> Signal:
    signal = Signal(field.quantity.unit)
    for ns, number in row.series(field.name):
        signal.take(ns, (number,))
    return signal


def _pin(source: str) -> str:
    return str(source).rpartition(".")[2]
