"""How benches of a rover are shown."""

from __future__ import annotations

from hilbench.plugins.dashboard import Dashboard

__all__ = ["DASHBOARD"]

DASHBOARD = Dashboard(
    kind="rover",
    shows=frozenset({"pkt", "rover-4wd"}),
    wide=(
        (4, (("link", 9), ("timers", 6), ("counters", 16), ("log", 7))),
        (5, (("world", 3), ("plots", 3), ("frames", 2))),
        (4, (("states", 4), ("pins", 4), ("console", 2), ("checks", 3))),
    ),
    narrow=(
        "world", "plots", "frames", "link", "pins", "log", "states", "timers", "counters", "checks", "console",
    ),
    plots=("speed", "turn rate", "rpm", "throttles", "duty", "temperature"),
    units={"rpm": "rpm", "throttles": ""},
    routine=frozenset({"ReportReceived", "CommandReceived", "MotorsCommanded", "ReportDue"}),
    bad=frozenset({"RoverLost", "CommandRefused"}),
    traffic=frozenset({"requests"}),
)  # fmt: skip
