"""What a system brings to the dashboard: its keys, its view, its help, and which figures and words matter."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rich.text import Text

__all__ = ["BAD", "DIM", "GOOD", "HEAD", "Columns", "Dashboard", "Echo", "Event", "Help", "Key"]

HEAD, DIM, GOOD, BAD = "bold", "dim", "green", "bold red"
"""The styles of all views."""

Event = Mapping[str, Any]
Columns = tuple[tuple[float, tuple[tuple[str, float], ...]], ...]
"""The share of each column, and its panes with theirs of its height."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Key:
    """A key, and a command of the palette: what is asked of the bench.

    Attributes:
        key: as Textual calls it: ``y``, ``backspace``. One that the dashboard has a use for on this bench keeps that.
        title: what the command is called.
        help: what it does, in a sentence.
        do: the action; a bench that has none of this name is not asked.
        more: what is sent with it.
        toggle: the name of what is sent besides, and under which name it was reported: True where that was False.
        cycle: the name of what is sent besides, and what that is by turns.
        shown: what stands at the foot of the screen; nothing if empty.
    """

    key: str
    title: str
    help: str
    do: str
    more: Mapping[str, object] = field(default_factory=dict)
    toggle: tuple[str, str] | None = None
    cycle: tuple[str, Sequence[object]] | None = None
    shown: str = ""

    def sent(self, seen: Event, before: int) -> dict[str, object]:
        """Return what is sent with the action.

        Args:
            seen: what was reported last of what the key changes.
            before: how often it was asked for before.
        """
        sent = dict(self.more)
        if self.toggle is not None:
            name, reported_as = self.toggle
            sent[name] = not seen.get(reported_as, True)
        if self.cycle is not None:
            name, values = self.cycle
            sent[name] = values[before % len(values)]
        return sent


@dataclass(frozen=True, slots=True, kw_only=True)
class Help:
    r"""What help says of a bench besides, in Textual's markup: ``[b]bold[/b]``, and ``\[`` is a bracket.

    Attributes:
        seen: what one sees, a line each.
        tries: what to try.
        title: what stands above the rows.
        rows: keys, and what they do.
    """

    seen: tuple[str, ...] = ()
    tries: tuple[str, ...] = ()
    title: str = ""
    rows: tuple[tuple[str, str], ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class Echo:
    """What a range sensor of a vehicle reported last.

    Attributes:
        number: of the sensor.
        range_m: how far away the nearest thing in its beam is; None if it hears nothing.
        place: x and y in m and the direction in rad, as the vehicle sees them; None if that is not known.
        ahead: it looks ahead: the least of these is a figure, too.
    """

    number: int
    range_m: float | None
    place: tuple[float, float, float] | None = None
    ahead: bool = False


def _no_echoes(live: Event, reported: Event) -> Iterable[Echo]:
    del live, reported
    return ()


def _no_help(actions: Collection[str], driver: str) -> Help:
    del actions, driver
    return Help()


@dataclass(frozen=True, slots=True, kw_only=True)
class Dashboard:
    """How benches of a system are shown. All that is not said is as of any robot.

    Attributes:
        kind: of these benches: what somebody makes of the panes of one holds for all of its kind.
        shows: names of protocols and of vehicles: it is a bench of this kind if our client speaks such a protocol, or
            if none of ours speaks and such a vehicle drives there.
        wide: where the panes are, on a screen with room for columns.
        below: as above, in a band of its own below them; what `wide` names is there and not here.
        narrow: which of them come first on a screen without: the first stands above the second.
        plots: the figures that are plotted, the most important first.
        echoes: returns what range sensors of the vehicle report: of what the header of the journal says of the bench,
            and of the fields of a frame or of an event of who drives.
        keys: what can be asked for besides.
        help: returns what help says besides, of the actions of the bench and of who drives.
        tells: the kind of the journal's events that say what the view shows and what keys toggle.
        view: returns that as lines, of such an event, the cells in a line and the rows there are.
        routine: names of events that come all the time, and are no line of the log.
        bad: names of events that tell of something bad.
        said: by kinds of events: what the log says of one, and whether that is bad; nothing of those for other panes.
        traffic: the counters that count what is right; each other one counts something that went wrong, or nearly.
    """

    kind: str
    shows: frozenset[str] = frozenset()
    wide: Columns = (
        (4, (("link", 7), ("timers", 8), ("counters", 13), ("pins", 8))),
        (5, (("world", 3), ("tables", 2), ("console", 1))),
        (4, (("plots", 4), ("states", 4), ("checks", 4))),
    )
    below: Columns = ((5, (("frames", 1),)), (3, (("messages", 1), ("log", 1))))
    narrow: tuple[str, ...] = (
        "world", "frames", "plots", "link", "log", "tables", "states", "timers", "counters", "messages", "checks",
        "console", "pins",
    )  # fmt: skip
    plots: tuple[str, ...] = ("speed", "turn rate", "duty")
    echoes: Callable[[Event, Event], Iterable[Echo]] = _no_echoes
    keys: tuple[Key, ...] = ()
    help: Callable[[Collection[str], str], Help] = _no_help
    tells: str = ""
    view: Callable[[Event, int, int], Sequence[Text]] | None = None
    routine: frozenset[str] = frozenset()
    bad: frozenset[str] = frozenset()
    said: Mapping[str, Callable[[Event], tuple[str, bool] | None]] = field(default_factory=dict)
    traffic: frozenset[str] = frozenset()
