"""What is asked for by key, and by name."""

from __future__ import annotations

from textual.binding import Binding, BindingType

from hilbench.tui.panes import PANES
from hilbench.tui.vehicle_keys import VEHICLE_BY_NAME, VEHICLE_KEYS, VEHICLE_NEEDS

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
    Binding("o", "demo", "Demo", show=False),
    Binding("c", "connect", "Connect", show=False),
    Binding("x", "disconnect", "Disconnect", show=False),
    Binding("r", "reset", "Reset", show=False),
    Binding("p", "pause", "Pause"),
    Binding("n", "step", "Step", show=False),
    Binding("plus", "faster", "Faster", show=False),
    Binding("minus", "slower", "Slower", show=False),
    Binding("f", "fast", "Fast", show=False),
    Binding("i", "inject", "Fault"),
    Binding("u", "clear_faults", "No faults", show=False),
    Binding("m", "mark", "Mark", show=False),
    Binding("g", "picture", "SVG", show=False),
    Binding("R", "keep", "Keep", show=False),
    Binding("X", "export", "Export", show=False),
    Binding("slash", "filter", "Filter"),
    Binding("t", "check", "Check"),
    Binding("P", "panes", "Panes"),
    Binding("left_square_bracket", "resize(-2, 0)", show=False),
    Binding("right_square_bracket", "resize(2, 0)", show=False),
    Binding("left_curly_bracket", "resize(0, -1)", show=False),
    Binding("right_curly_bracket", "resize(0, 1)", show=False),
    Binding("L", "signals", "Signals", show=False),
    Binding("less_than_sign", "span(-1)", show=False),
    Binding("greater_than_sign", "span(1)", show=False),
    Binding("T", "light", "Light or dark", show=False),
    Binding("b", "pick", "Bench", show=False),
    Binding("question_mark", "help", "Help", key_display="?"),
    Binding("q", "leave", "Quit"),
    *VEHICLE_KEYS,  # behind what must be seen on 80 columns too
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
    Binding("e", "error(1)", "Next error"),
    Binding("E", "error(-1)", show=False),
    *(Binding(pane.key, f"zoom('{name}')", show=False) for name, pane in PANES.items()),
]

BY_NAME: dict[str, tuple[str, tuple[object, ...]]] = {
    "Connect": ("connect", ()),
    "Disconnect": ("disconnect", ()),
    "Drive forward": ("drive", (0, 0.5)),
    "Drive backward": ("drive", (0, -0.5)),
    "Turn left": ("drive", (1, 0.5)),
    "Turn right": ("drive", (1, -0.5)),
    "Stop the vehicle": ("stop", ()),
    "Let the demo driver go on": ("demo", ()),
    "Press the reset button": ("reset", ()),
    "Pause or go on": ("pause", ()),
    "Go 0.1 s further": ("step", ()),
    "Twice as fast": ("faster", ()),
    "Half as fast": ("slower", ()),
    "As fast as it can, or real time": ("fast", ()),
    "Put a fault on the line": ("inject", ()),
    "Take all faults back": ("clear_faults", ()),
    "Mark this moment": ("mark", ()),
    "Filter frames": ("filter", ()),
    "Save the screen as SVG": ("picture", ()),
    "Keep the recording so far": ("keep", ()),
    "Export as CSV, JSON or hex": ("export", ()),
    "Run a suite on a fresh bench": ("check", ()),
    "Stop the suite": ("stop_check", ()),
    "Which panes, and where": ("panes", ()),
    "Which signals are plotted": ("signals", ()),
    "Plot a shorter time": ("span", (-1,)),
    "Plot a longer time": ("span", (1,)),
    "Light or dark": ("light", ()),
    "Open another bench": ("pick", ()),
    "Explain this screen": ("help", ()),
    "Play, or stand still": ("play", ()),
    "Go a second on": ("go", (1,)),
    "Go a second back": ("go", (-1,)),
    "Go to the beginning": ("go", (-1_000_000,)),
    "Go to the end": ("go", (1_000_000,)),
    "Go an event on": ("event", (1,)),
    "Go an event back": ("event", (-1,)),
    "Go to the next error": ("error", (1,)),
    "Go to the previous error": ("error", (-1,)),
    "Show all panes": ("unzoom", ()),
    **{f"Show {pane.title} alone": ("zoom", (name,)) for name, pane in PANES.items()},
    **{what: (name, ()) for name, what in VEHICLE_BY_NAME.items()},
    "Leave": ("leave", ()),
}
"""The command palette: what actions are called there, and what each is."""

NEEDS = {
    "drive": "drive", "stop": "stop", "demo": "demo", "connect": "connect", "disconnect": "disconnect",
    "reset": "reset", "inject": "inject", "clear_faults": "clear-faults", "pause": "pause", "step": "step",
    "faster": "speed", "slower": "speed", "fast": "speed", "mark": "mark",
    **VEHICLE_NEEDS,
}  # fmt: skip
"""What an action of ours asks of the bench; one that the bench does not have is not offered."""

OF_RECORDINGS = {
    "play": True,
    "go": True,
    "event": True,
    "error": True,
    "check": False,
    "stop_check": False,
    "keep": False,
    "pick": False,
}
"""Actions that there are of recordings alone, or of benches alone."""
