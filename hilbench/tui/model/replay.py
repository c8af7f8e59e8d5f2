"""A recording and a place in it; the model there is made of all events before it."""

from __future__ import annotations

import io
import pickle
import struct
from array import array
from bisect import bisect_left, bisect_right
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from hilbench.plugins.dashboard import Dashboard
from hilbench.plugins.protocol import ProtocolPlugin
from hilbench.recordings.piecewise import Pieces
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.log import line_of

__all__ = ["Replay"]

Event = Mapping[str, Any]
NS_PER_S = 1_000_000_000
_AT_ONCE = 500
"""Events that are taken before somebody else has a turn (choice)."""
_MOST_KEPT = 32
"""Models of places on the way that are kept: a way back begins at one of them (choice)."""


class Replay:
    """See the module. It goes to a place, and reads, only in `work`; the place is first the end of what was read.

    Args:
        pieces: the recording.

    Attributes:
        model: what is known at the place, or on the way to it.
        playing: whether time goes on by itself.
        marks: where something happened, in the order of time: ``!`` an error, ``m`` a mark, ``c`` a verdict.
        reading: whether there is more of the recording than was read.
    """

    def __init__(self, pieces: Pieces) -> None:
        self.playing = False
        self.reading = True
        self.marks: list[tuple[int, str]] = []
        self.model = BenchModel(pieces.header)
        self._pieces = pieces
        self._times = array("q")
        self._errors = array("Q")
        self._follows = True
        self._at = self._wanted = self._from = 0
        self._now_ns = 0
        self._apart = _AT_ONCE
        self._kept: dict[int, Callable[[], BenchModel]] = {0: partial(BenchModel, pieces.header)}

    @property
    def length_ns(self) -> int:
        """The bench time of the last event that was read."""
        return self._times[-1] if self._times else 0

    @property
    def now_ns(self) -> int:
        """The bench time of the place."""
        return self._now_ns

    @property
    def problem(self) -> str | None:
        """What ended the reading before the end of the file; None if nothing did."""
        return self._pieces.problem

    @property
    def progress(self) -> str:
        """What there is still to do, and how much of it is done, in words; empty if there is nothing."""
        if self._at != self._wanted:
            return f"on the way, {_per_cent((self._at - self._from) / (self._wanted - self._from))}"
        return f"reading, {_per_cent(self._pieces.share)}" if self.reading else ""

    def work(self, enough: Callable[[], bool] = lambda: False) -> None:
        """Go where somebody wants to be, then read, until there is nothing to do or it is enough.

        Args:
            enough: asked after each step of some milliseconds.
        """
        while self._step_on() and not enough():
            pass

    def go_to(self, ns: int) -> None:
        """Go to a bench time: everything up to it has happened. At the end what is still read is followed."""
        self._now_ns = max(0, min(ns, self.length_ns))
        self._place(bisect_right(self._times, self._now_ns))
        self._follows = ns >= self.length_ns

    def go_by(self, span_ns: int) -> None:
        """Go on, or back."""
        self.go_to(self._now_ns + span_ns)

    def step(self, events: int) -> None:
        """Go on by so many events, or back."""
        self._place(max(0, min(len(self._times), self._wanted + events)))
        self._now_ns = self._times[self._wanted - 1] if self._wanted else 0

    def to_error(self, way: int) -> bool:
        """Go behind the next event that tells of something bad, or of the one before; say whether there was one."""
        number = bisect_left(self._errors, self._wanted) if way > 0 else bisect_left(self._errors, self._wanted - 1) - 1
        found = 0 <= number < len(self._errors)
        if found:
            self.step(self._errors[number] + 1 - self._wanted)
        return found

    def play(self, elapsed_s: float) -> None:
        """Let time go on, if it does; at the end it stops."""
        if self.playing:
            self.go_by(round(elapsed_s * NS_PER_S))
            self.playing = self.reading or self._now_ns < self.length_ns

    # --- going

    def _place(self, at: int) -> None:
        """Go to behind so many events, from the nearest place before it of which there is a model."""
        self._follows = False
        self._wanted = at
        nearest = max(number for number in self._kept if number <= at)
        if at < self._at or nearest > self._at:
            self.model, self._at = self._kept[nearest](), nearest
        self._from = self._at

    def _step_on(self) -> bool:
        """Do a little of what there is to do; say whether there was anything."""
        if self._at != self._wanted:
            end = min(self._wanted, self._at + _AT_ONCE)
            self._take(self._pieces.between(self._at, end), end)
        elif self.reading:
            self._read()
        else:
            return False
        return True

    def _read(self) -> None:
        events = self._pieces.read()
        self.reading = bool(events)
        for event in events:  # an event that is recorded late belongs where it stands
            self._times.append(max(event["ns"], self.length_ns))
            sort = _sort(event, self.model.dashboard)
            if sort:
                self.marks.append((self._times[-1], sort))
            if sort == "!":
                self._errors.append(len(self._times) - 1)
        if self._follows:
            self._take(events, len(self._times))
            self._wanted, self._now_ns = self._at, self.length_ns

    def _take(self, events: Sequence[Event], end: int) -> None:
        self.model.take(events)
        self._at = end
        if end - max(self._kept) >= self._apart:
            self._keep(end)
            if len(self._kept) > _MOST_KEPT:
                self._apart *= 2
                self._kept = dict(list(self._kept.items())[::2])

    def _keep(self, end: int) -> None:
        try:
            self._kept[end] = _Kept(self.model).model
        except (pickle.PicklingError, AttributeError, TypeError):  # a plug-in's decoder: ways back are longer without
            self._apart *= 2


class _Packer(pickle.Pickler):
    """Makes a copy of a model to keep, small and quick.

    What never changes, plug-ins, layouts and frames of the protocols, is not copied: some of it is known by its
    identity.
    """

    def __init__(self, file: io.BytesIO, shared: dict[int, object]) -> None:
        super().__init__(file, pickle.HIGHEST_PROTOCOL)
        self._shared = shared

    def persistent_id(self, thing: object) -> int | None:
        sort = type(thing)
        if sort not in (struct.Struct, ProtocolPlugin, Dashboard):
            known = getattr(sort, "__dataclass_params__", None)
            if known is None or not known.frozen or not sort.__module__.startswith("protocols."):
                return None
        self._shared[id(thing)] = thing
        return id(thing)


class _Unpacker(pickle.Unpickler):
    """Makes a model of a copy."""

    def __init__(self, file: io.BytesIO, shared: Mapping[int, object]) -> None:
        super().__init__(file)
        self._shared = shared

    def persistent_load(self, number: int) -> object:
        return self._shared[number]


class _Kept:
    """A copy of a model."""

    def __init__(self, model: BenchModel) -> None:
        self._shared: dict[int, object] = {}
        file = io.BytesIO()
        _Packer(file, self._shared).dump(model)
        self._packed = file.getvalue()

    def model(self) -> BenchModel:
        """Return a model like it, of its own."""
        model = _Unpacker(io.BytesIO(self._packed), self._shared).load()
        assert isinstance(model, BenchModel)
        return model


def _per_cent(share: float) -> str:
    return f"{int(100 * share)} %"


def _sort(event: Event, dashboard: Dashboard) -> str:
    """Return the mark of an event on the line of time; empty for most of them."""
    try:
        found = line_of(event, dashboard)
        if (found is not None and found[1]) or event.get("verdict") in {"fail", "error"}:
            return "!"
        if event["kind"] == "action":
            return "m" if event["do"] == "mark" else ""
    except Exception:  # noqa: BLE001 - as of `BenchModel.take`
        return ""
    return "c" if event["kind"] == "verdict" else ""
