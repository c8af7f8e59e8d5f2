"""How a bench is shown: as its system says, or as any other."""

from __future__ import annotations

from dataclasses import replace

from hilbench.plugins.dashboard import Dashboard, Event
from hilbench.plugins.discovery import PLUGINS
from hilbench.tui.model.arrangement import arrangement_of
from hilbench.tui.model.frames import failed

__all__ = ["BOARD", "ROBOT", "dashboard_of"]

ROBOT = Dashboard(kind="robot")
"""Of benches on which our client speaks what no system shows."""
BOARD = Dashboard(
    kind="board",
    wide=(
        (4, (("pins", 9), ("link", 2), ("timers", 2), ("counters", 3))),
        (6, (("world", 4), ("tables", 4), ("plots", 3))),
        (4, (("console", 4), ("log", 4), ("states", 3), ("checks", 4), ("frames", 2), ("messages", 2))),
    ),
    below=(),
    narrow=("world", "console", "pins", "tables", "log", "plots", "checks"),
)  # fmt: skip
"""Of those on which none of our clients speaks."""

_BUSES = frozenset({"I2cTransaction"})
"""What the buses of a board report all the time; their pins show it."""
_BYTES = frozenset({"bytes_in", "bytes_out", "frames_in", "frames_out"})


def dashboard_of(live: Event) -> tuple[Dashboard, list[str]]:
    """Return how a bench is shown, and what is wrong with plug-ins that have a say in that, a line each.

    Of events and counters each system knows its own: a model of one may stand on any bench.

    Args:
        live: what the header of the journal says of it.
    """
    from targets.parts import ROUTINE

    shown = str(live.get("protocol") or live.get("vehicle", ""))
    found, problems = [ROBOT if live.get("protocol") else BOARD], []
    for system in PLUGINS.systems.shown(shown):
        try:
            dashboard = system.dashboard()
            if dashboard is not None:
                _check(dashboard)
                found.append(dashboard)
        except Exception as error:  # noqa: BLE001 - a plug-in's: the others are there
            problems.append(f"system '{system.name}': {failed('dashboard', error)}")
    meant = next((one for one in found if shown in one.shows), found[0])
    every = replace(
        meant,
        narrow=meant.narrow if live.get("vehicle") else _without_world(meant.narrow),
        routine=frozenset().union(_BUSES, ROUTINE, *(one.routine for one in found)),
        bad=frozenset().union(*(one.bad for one in found)),
        said={kind: said for one in found for kind, said in one.said.items()},
        traffic=_BYTES.union(*(one.traffic for one in found)),
    )
    return every, problems


def _without_world(narrow: tuple[str, ...]) -> tuple[str, ...]:
    """Return which panes come first where no vehicle moves: what stands beside the world takes its place."""
    if narrow[:1] != ("world",) or len(narrow) < 3:
        return narrow
    return (narrow[2], narrow[1], *narrow[3:])


def _check(dashboard: object) -> None:
    """Look whether a dashboard can be used before anything is drawn with it."""
    if not isinstance(dashboard, Dashboard):
        raise TypeError(f"{dashboard!r} is no Dashboard")
    for wide in (True, False):
        arrangement_of(dashboard, wide=wide)
    for key in dashboard.keys:
        key.sent({}, 0)
