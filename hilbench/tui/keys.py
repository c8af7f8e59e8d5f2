"""What is asked for by key, and by name."""

from __future__ import annotations

from textual.actions import parse
from textual.binding import Binding, BindingType

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.panes import PANES

__all__ = ["ALWAYS", "BY_NAME", "KEYS", "NEEDS", "OF_RECORDINGS", "key_of", "wanted_now"]

KEYS: list[BindingType] = [
    Binding("w,up", "drive(0, 0.5)", key_display="wasd"),
    Binding("s,down", "drive(0, -0.5)"),
    Binding("a,left", "drive(1, 0.5)"),
    Binding("d,right", "drive(1, -0.5)"),
    Binding("W,shift+up", "drive(0, 1)"),
    Binding("S,shift+down", "drive(0, -1)"),
    Binding("A,shift+left", "drive(1, 1)"),
    Binding("D,shift+right", "drive(1, -1)"),
    Binding("space", "stop"),
    Binding("o", "demo"),
    Binding("c", "connect"),
    Binding("x", "disconnect"),
    Binding("r", "reset"),
    Binding("p", "pause"),
    Binding("n", "step"),
    Binding("plus", "faster"),
    Binding("minus", "slower"),
    Binding("f", "fast"),
    Binding("i", "inject"),
    Binding("u", "clear_faults"),
    Binding("I", "stimulate"),
    Binding("e", "compose"),
    Binding("m", "mark"),
    Binding("g", "picture"),
    Binding("R", "keep"),
    Binding("X", "export"),
    Binding("slash", "filter"),
    Binding("t", "check"),
    Binding("P", "panes"),
    Binding("left_square_bracket", "resize(-2, 0)"),
    Binding("right_square_bracket", "resize(2, 0)"),
    Binding("left_curly_bracket", "resize(0, -1)"),
    Binding("right_curly_bracket", "resize(0, 1)"),
    Binding("L", "signals"),
    Binding("less_than_sign", "span(-1)"),
    Binding("greater_than_sign", "span(1)"),
    Binding("T", "theme"),
    Binding("b", "pick"),
    Binding("question_mark", "help", key_display="?"),
    Binding("q", "leave"),
    Binding("escape", "unzoom"),
    Binding("p", "play"),
    Binding("left", "go(-1)"),
    Binding("right", "go(1)"),
    Binding("shift+left", "go(-10)"),
    Binding("shift+right", "go(10)"),
    Binding("home", "go(-1000000)"),
    Binding("end", "go(1000000)"),
    Binding("comma", "event(-1)"),
    Binding("full_stop", "event(1)"),
    Binding("e", "error(1)"),
    Binding("E", "error(-1)"),
    *(Binding(pane.key, f"zoom('{name}')") for name, pane in PANES.items()),
]

BY_NAME: dict[str, tuple[str, tuple[object, ...]]] = {
    "Drive: forward": ("drive", (0, 0.5)),
    "Drive: backward": ("drive", (0, -0.5)),
    "Drive: turn left": ("drive", (1, 0.5)),
    "Drive: turn right": ("drive", (1, -0.5)),
    "Drive: stop the vehicle": ("stop", ()),
    "Drive: let the demo driver go on": ("demo", ()),
    "Line: connect": ("connect", ()),
    "Line: disconnect": ("disconnect", ()),
    "Line: put a fault on it": ("inject", ()),
    "Line: take all faults back": ("clear_faults", ()),
    "Line: send a message": ("compose", ()),
    "Board: press the reset button": ("reset", ()),
    "Board: give it a stimulus": ("stimulate", ()),
    "Time: pause or go on": ("pause", ()),
    "Time: go 0.1 s further": ("step", ()),
    "Time: twice as fast": ("faster", ()),
    "Time: half as fast": ("slower", ()),
    "Time: as fast as it can, or real time": ("fast", ()),
    "Check: run a suite on a fresh bench": ("check", ()),
    "Check: stop the suite": ("stop_check", ()),
    "Save: mark this moment": ("mark", ()),
    "Save: keep the recording so far": ("keep", ()),
    "Save: export as CSV, JSON or hex": ("export", ()),
    "Save: the screen as SVG": ("picture", ()),
    "Frames: filter": ("filter", ()),
    "Plots: which signals": ("signals", ()),
    "Plots: a shorter time": ("span", (-1,)),
    "Plots: a longer time": ("span", (1,)),
    "View: which panes, and where": ("panes", ()),
    "View: choose a theme": ("theme", ()),
    "View: all panes": ("unzoom", ()),
    **{f"View: {pane.title} alone": ("zoom", (name,)) for name, pane in PANES.items()},
    "Recording: play, or stand still": ("play", ()),
    "Recording: a second on": ("go", (1,)),
    "Recording: a second back": ("go", (-1,)),
    "Recording: to the beginning": ("go", (-1_000_000,)),
    "Recording: to the end": ("go", (1_000_000,)),
    "Recording: an event on": ("event", (1,)),
    "Recording: an event back": ("event", (-1,)),
    "Recording: to the next error": ("error", (1,)),
    "Recording: to the previous error": ("error", (-1,)),
    "Dashboard: open another bench": ("pick", ()),
    "Dashboard: explain this screen": ("help", ()),
    "Dashboard: leave": ("leave", ()),
}
"""The command palette: what actions are called there, by the task that they belong to, and what each is."""


def key_of(name: str, arguments: tuple[object, ...]) -> str:
    """Return the key of an action, as people write it; empty if it has none."""
    for one in KEYS:
        if isinstance(one, Binding) and parse(one.action)[1:] == (name, arguments):
            key = one.key.partition(",")[0]
            return one.key_display or _SIGNS.get(key, key)
    return ""


ALWAYS = (("help", "Help"), ("command_palette", "All"), ("leave", "Quit"))
"""What stands at the end of the line of keys, whatever goes on."""
_OFTEN = (
    ("inject", "Fault"), ("check", "Check"), ("compose", "Send"), ("filter", "Filter"), ("signals", "Plots"),
    ("panes", "Panes"), ("theme", "Theme"), ("mark", "Mark"), ("export", "Export"), ("pick", "Bench"),
)  # fmt: skip
_RECORDED = (
    ("play", "Play"), ("go(-1)", "Back"), ("go(1)", "On"), ("event(1)", "Event"), ("error(1)", "Next error"),
    ("filter", "Filter"), ("signals", "Plots"), ("panes", "Panes"), ("theme", "Theme"), ("export", "Export"),
)  # fmt: skip


def wanted_now(model: BenchModel | None, *, recorded: bool) -> tuple[tuple[str, str], ...]:
    """Return the actions that matter now, and what they are called, the most important first."""
    if model is None:
        return ()
    if recorded:
        return _RECORDED
    own = tuple((f"ask({number})", key.shown) for number, key in enumerate(model.dashboard.keys) if key.shown)
    undo = (("clear_faults", "No faults"),) * bool(model.armed)
    if model.paused:
        return (("pause", "Go on"), ("step", "0.1 s"), *undo, *own, *_OFTEN)
    drives = (("drive(0, 0.5)", "Drive"), ("stop", "Stop"))
    if model.driver.by_hand:
        return (*drives, ("demo", "Demo"), *undo, *own, ("pause", "Pause"), *_OFTEN)
    if model.driver.nobody:
        return (("connect", "Connect"), *drives, ("demo", "Demo"), *undo, *own, ("pause", "Pause"), *_OFTEN)
    return (*drives, *undo, *own, ("pause", "Pause"), *_OFTEN)


_SIGNS = {
    "plus": "+", "minus": "-", "slash": "/", "question_mark": "?", "comma": ",", "full_stop": ".",
    "less_than_sign": "<", "greater_than_sign": ">",
}  # fmt: skip

NEEDS = {
    "drive": "drive", "stop": "stop", "demo": "demo", "connect": "connect", "disconnect": "disconnect",
    "reset": "reset", "inject": "inject", "compose": "send", "clear_faults": "clear-faults",
    "pause": "pause", "step": "step",
    "faster": "speed", "slower": "speed", "fast": "speed", "mark": "mark", "stimulate": "stimulate",
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
