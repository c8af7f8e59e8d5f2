"""How benches of a Pioneer are shown."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from hilbench.plugins.dashboard import Dashboard, Echo, Event

__all__ = ["DASHBOARD"]

_AHEAD = frozenset({2, 3, 4, 5})
"""Discs of the sonar, as of `hilbench.systems.pioneer.operator`."""


def _echoes(live: Event, reported: Event) -> Iterator[Echo]:
    """Yield what the sonar hears by a SIP, or by an event that has one; see `hilbench.systems.pioneer.about`."""
    unit_m, discs = live.get("sonar_unit_mm", 0.0) / 1000, live.get("sonars", ())
    readings = reported.get("packet", reported).get("sonars", ()) if unit_m else ()
    for number, range_raw in map(_plain, readings):
        heard = range_raw < live["sonar_no_echo"]
        yield Echo(
            number=number,
            range_m=range_raw * unit_m if heard else None,
            place=discs[number] if number < len(discs) else None,
            ahead=number in _AHEAD,
        )


def _plain(reading: Any) -> tuple[int, int]:
    """Return number and range of a reading, which is the protocol's, or a mapping in a journal."""
    if isinstance(reading, Mapping):
        return reading["number"], reading["range_raw"]
    return reading.number, reading.range_raw


DASHBOARD = Dashboard(
    kind="robot",
    shows=frozenset({"p2os"}),
    plots=("speed", "turn rate", "range ahead", "battery"),
    echoes=_echoes,
    routine=frozenset({"PacketReceived", "CommandReceived", "CommandObeyed"}),
    bad=frozenset({"ConnectionLost", "ConnectFailed", "WatchdogExpired"}),
    traffic=frozenset({"keepalives"}),
)
