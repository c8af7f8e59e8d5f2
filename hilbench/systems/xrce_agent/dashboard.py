"""How benches of a micro-ROS agent are shown."""

from __future__ import annotations

from hilbench.plugins.dashboard import Dashboard

__all__ = ["DASHBOARD"]

DASHBOARD = Dashboard(
    kind="agent",
    shows=frozenset({"xrce"}),
    wide=(
        (4, (("link", 7), ("timers", 8), ("counters", 13))),
        (6, (("tables", 4), ("states", 3), ("checks", 3))),
        (4, (("plots", 3), ("pins", 3), ("console", 2))),
    ),
    narrow=("tables", "frames", "plots", "messages", "states", "link", "log", "timers", "counters", "checks"),
    plots=("sent", "heard"),
    routine=frozenset({"Received", "SampleRouted"}),
)
