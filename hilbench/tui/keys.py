"""What is asked for by key, and by name."""

from __future__ import annotations

from textual.binding import Binding, BindingType

from hilbench.tui.panes import pane_names

__all__ = ["BY_NAME", "KEYS", "NEEDS", "OF_RECORDINGS"]

KEYS: list[BindingType] = [
    Binding("w,up", "drive(0, 0.5)", "Drive", key_display="wasd"),
    Binding("s,down", "drive(0, -0.5)", show=False),
    Binding("a,left", "drive(1, 0.5)", show=False),
    Binding("d,right", "drive(1, -0.5)", show=False),
    Binding("W,shift+up", "drive(0, 1)", show=False),
    Binding("S,shift+down", "drive(0, -1)", show=False),
    Binding("A,shift+left", "drive(1, 1)", show=False),
    Binding("D,shift+right", "drive(1, -1)", show=False),
    Binding("space", "stop", "Stop"),
    Binding("o", "demo", "Demo"),
    Binding("c", "connect", "Connect", show=False),
    Binding("x", "disconnect", "Disconnect", show=False),
    Binding("r", "reset", "Reset"),
    Binding("p", "pause", "Pause"),
    Binding("n", "step", "Step", show=False),
    Binding("plus", "faster", "Faster", show=False),
    Binding("minus", "slower", "Slower", show=False),
    Binding("i", "inject", "Fault"),
    Binding("u", "clear_faults", "No faults", show=False),
    Binding("m", "mark", "Mark", show=False),
    Binding("g", "picture", "SVG", show=False),
    Binding("slash", "filter", "Filter"),
    Binding("t", "check", "Check", show=False),
    Binding("b", "pick", "Bench", show=False),
    Binding("question_mark", "help", "Help", key_display="?"),
    Binding("q", "leave", "Quit"),
    Binding("escape", "unzoom", show=False),
    Binding("p", "play", "Play"),
    Binding("left", "go(-1)", "Back"),
    Binding("right", "go(1)", "On"),
    Binding("shift+left", "go(-10)", show=False),
    Binding("shift+right", "go(10)", show=False),
    Binding("home", "go(-1000000)", show=False),
    Binding("end", "go(1000000)", show=False),
    Binding("comma", "event(-1)", show=False),
    Binding("full_stop", "event(1)", show=False),
    Binding("e", "next_error", "Next error"),
    *(Binding(str(key), f"zoom('{name}')", show=False) for key, name in enumerate(pane_names(), 1)),
]

BY_NAME = {
    "connect": "Connect",
    "disconnect": "Disconnect",
    "demo": "Let the demo driver go on",
    "stop": "Stop the vehicle",
    "reset": "Press the reset button",
    "pause": "Pause or go on",
    "step": "Go 0.1 s further",
    "faster": "Twice as fast",
    "slower": "Half as fast",
    "inject": "Put a fault on the line",
    "clear_faults": "Take all faults back",
    "mark": "Mark this moment",
    "filter": "Filter frames",
    "picture": "Save the screen as SVG",
    "check": "Run a suite on a fresh bench",
    "pick": "Open another bench",
    "leave": "Leave",
}
"""The command palette: actions, and what they are called there."""

NEEDS = {
    "drive": "drive", "stop": "stop", "demo": "demo", "connect": "connect", "disconnect": "disconnect",
    "reset": "reset", "inject": "inject", "clear_faults": "clear-faults", "pause": "pause", "step": "step",
    "faster": "speed", "slower": "speed", "mark": "mark",
}  # fmt: skip
"""What an action of ours asks of the bench; one that the bench does not have is not offered."""

OF_RECORDINGS = frozenset({"play", "go", "event", "next_error"})
