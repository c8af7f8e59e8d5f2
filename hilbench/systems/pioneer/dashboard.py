"""How benches of a Pioneer are shown."""

from __future__ import annotations

from hilbench.plugins.dashboard import Dashboard

__all__ = ["DASHBOARD"]

DASHBOARD = Dashboard(
    kind="robot",
    shows=frozenset({"p2os"}),
    plots=("speed", "turn rate", "range ahead", "battery"),
    discs_ahead=frozenset({2, 3, 4, 5}),  # as of `hilbench.systems.pioneer.operator`
    routine=frozenset({"PacketReceived", "CommandReceived", "CommandObeyed"}),
    bad=frozenset({"ConnectionLost", "ConnectFailed", "WatchdogExpired"}),
    traffic=frozenset({"keepalives"}),
)
