"""How benches of a vehicle interface are shown, and what is asked there: modes, the switch, who falls silent, lamps."""

from __future__ import annotations

from collections.abc import Collection

from hilbench.plugins.dashboard import Dashboard, Help, Key
from hilbench.systems.vehicle.cockpit import cockpit_view

__all__ = ["DASHBOARD"]

_KEYS = (
    Key(
        key="y",
        title="Ask the board for AUTOWARE",
        help="Have the driving stack ask the board for AUTOWARE; it drives then.",
        do="mode",
        more={"mode": "AUTOWARE"},
    ),
    Key(
        key="v",
        title="Ask the board for MANUAL",
        help="Have the driving stack ask the board for MANUAL; the joystick rules then.",
        do="mode",
        more={"mode": "MANUAL"},
    ),
    Key(
        key="j",
        title="Press the joystick's switch",
        help="Press the joystick's switch: AUTOWARE becomes MANUAL, and MANUAL AUTOWARE.",
        do="press",
        shown="Switch",
    ),
    Key(
        key="k",
        title="Pause the driving stack, or let it go on",
        help="Let the driving stack fall silent, commands, clock and answers, or let it go on.",
        do="stack",
        toggle=("on", "stack_on"),
        shown="Stack",
    ),
    Key(
        key="l",
        title="Pause the simulator, or let it go on",
        help="Let the simulator's statuses end, or begin again.",
        do="simulator",
        toggle=("on", "simulator_on"),
        shown="Simulator",
    ),
    Key(
        key="z",
        title="Next lamps: left, right, hazard, off",
        help="Have the driving stack ask for the next of: left, right, hazard, off.",
        do="lamps",
        cycle=("which", ("left", "right", "hazard", "off")),
    ),
    Key(
        key="backspace",
        title="Put the car back to the start",
        help="Put the car back to where it began, at rest.",
        do="restart",
    ),
)
_ROWS = (
    ("y v", "ask the board for AUTOWARE, MANUAL"),
    ("j", "press the joystick's switch, as a drive key does in AUTOWARE. Let go, and the car is braked"),
    ("k l", "pause the driving stack, the simulator, or let it go on"),
    ("z", "next lamps: left, right, hazard"),
    ("backspace", "put the car back to the start"),
)
_TRIES = (
    "[b]l[/b] pauses the simulator: after ten missed statuses EMERGENCY. [b]l[/b] again: MANUAL.",
    "[b]k[/b] pauses the driving stack: after ten missed commands MANUAL. Watchdogs shows it come.",
)


def _help(actions: Collection[str], driver: str) -> Help:
    by_hand = "w, a, s and d press the switch, and you have the stick."
    who = by_hand if "press" in actions else "The joystick is not ours."
    return Help(
        seen=(f"The driving stack follows the track. {who}",) if driver == "path-follower" else (),
        tries=_TRIES if "simulator" in actions else (),
        title="Of a vehicle interface",
        rows=_ROWS if "press" in actions else (),
    )


DASHBOARD = Dashboard(
    kind="vehicle",
    shows=frozenset({"car"}),
    wide=(
        (4, (("pins", 10), ("link", 9), ("timers", 10))),
        (5, (("world", 3), ("tables", 3), ("plots", 2))),
        (4, (("states", 5), ("counters", 4), ("console", 2), ("checks", 4))),
    ),
    narrow=(
        "world", "frames", "plots", "tables", "states", "link", "timers", "log", "pins", "counters", "checks",
        "console",
    ),
    plots=("speed", "turn rate", "steer"),
    keys=_KEYS,
    help=_help,
    tells="vehicle",
    view=cockpit_view,
    routine=frozenset({
        "MessageReceived", "StatusReceived", "StatusReported", "ModeReported", "Commanded", "CarCommanded",
        "LightsSwitched", "LampChanged", "ModeAnswered",
    }),
    bad=frozenset({"BoardLost", "DeadlineMissed", "LinkSilent", "LineDead", "CommandRefused"}),
    said={
        "press": lambda _event: ("the joystick's switch is pressed", False),
        "answer": lambda event: (f"{event['mode']}: {event['said']}", event["said"] != "granted"),
    },
    traffic=frozenset({
        "requests", "pings", "polls", "commands", "mode_changes", "presses", "status_reports", "published",
        "frames_autoware", "frames_manual", "frames_emergency", "commands_sent", "statuses_sent",
    }),
)  # fmt: skip
