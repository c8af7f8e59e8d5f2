"""How benches of a rover are shown."""

from __future__ import annotations

from hilbench.plugins.dashboard import Dashboard

__all__ = ["DASHBOARD"]

DASHBOARD = Dashboard(
    kind="rover",
    shows=frozenset({"pkt", "rover-4wd"}),
    wide=(
        (4, (("link", 7), ("timers", 6), ("counters", 16))),
        (5, (("world", 4), ("tables", 2), ("plots", 3))),
        (4, (("pins", 5), ("states", 4), ("console", 2), ("checks", 4))),
    ),
    narrow=(
        "world", "frames", "plots", "pins", "link", "log", "states", "timers", "counters", "checks", "console",
    ),
    plots=("speed", "turn rate", "rpm", "throttles", "duty", "temperature"),
    routine=frozenset({"ReportReceived", "CommandReceived", "MotorsCommanded", "ReportDue"}),
    bad=frozenset({"RoverLost", "CommandRefused"}),
    traffic=frozenset({"requests"}),
)  # fmt: skip
