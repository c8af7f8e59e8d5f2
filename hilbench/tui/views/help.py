"""Help that teaches: what one sees on this bench, what to try, what each pane says, and the keys."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rich.markup import escape

from hilbench.plugins.dashboard import Help
from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.frames import failed

__all__ = ["help_text"]

_PANES = {
    "link": "bytes, rates and errors of the line; how well the host keeps up with real time",
    "timers": "every timer of both ends runs down; min: the least time left at a restart",
    "counters": "of both ends, with rates; red once something has gone wrong",
    "world": "from above, true: the way in green, in red what its range sensors report. The odometry may differ",
    "frames": "> sent, < heard, ⇄ heard in answer. Equal ones are folded; F: each, h holds, arrows point, enter opens",
    "states": "each state of the table: lit is the present one, 3x how often it was come to, arrow the last step",
    "pins": "lights first; level, the last two seconds, duty and period; volts of analog pins",
    "log": "changes of state, faults, what you did, resets, what the models noted",
    "plots": "figures over time, each with its scale and unit; L chooses, < and > change the time",
    "checks": "the clauses of a suite and their verdicts; arrows point, enter shows cause and evidence",
    "messages": "each message with its rate and last fields; arrows point, enter opens one, enter there plots a field",
    "tables": "what devices have to show, with rates and what came last; enter opens a row, there it plots a field",
    "console": "what firmware says in words: semihosting, ITM, or a UART with text",
}
_KEYS = (
    ("0-9 B C M", "that pane alone; again, or escape: all panes. So does a double click on it"),
    ("tab", "the next pane; P: which panes, and where"),
    ("\\[ ] { } ", "the pane narrower, wider, lower, higher; or drag its border with the mouse. It is remembered"),
    ("w a s d", "drive, as arrows do where no list has them; capitals: full speed. Hold the key: 0.7 s after it"),
    ("", "came last the vehicle stops (dead man). You take over from the demo driver"),
    ("game pad", "hold L1 (LB): triggers or the left stick drive, either stick turns; the cross connects, disconnects"),
    ("space o", "stop at once; let the demo driver go on"),
    ("c x r", "connect, disconnect; press the reset button of a board"),
    ("p n", "pause or go on; 0.1 s further"),
    ("+ - f", "twice, half as fast; as fast as it can, and real time again"),
    ("i u", "put a fault on the line; take all back"),
    ("I", "give a board a level, volts, a wave, bytes: PC13=0/50ms, PA0=1.65V, usart1=hello"),
    ("m R", "mark this moment in the journal; keep the recording so far, in the working folder"),
    ("e", "edit a message and send it to the target: the one that is pointed at in Messages, or one of a list"),
    ("/", "filter frames: words that must be there, -word must not, > or <, ! what is not sound"),
    ("L < >", "which signals are plotted; over a shorter, a longer time"),
    ("t b", "run a suite on a fresh bench; open another bench"),
    ("g X", "save the screen as SVG; export as CSV, JSON or hex. Both into the working folder"),
    ("T", "themes, light and dark; each is shown while it is pointed at"),
    ("q", "leave: stop the bench, or detach from it"),
    ("ctrl+p", "all of this by name"),
)
_RECORDED = (
    ("p", "plays, or stands still"),
    ("left right", "a second back, on; with shift ten"),
    (", .", "an event back, on"),
    ("e E", "the next error, the one before"),
    ("home end", "its beginning, its end"),
    ("a click", "on the line of time goes there: ! is an error, m a mark, c a verdict"),
)


def _table(rows: Collection[tuple[str, str]]) -> list[str]:
    return [f"[b]{keys:<10}[/b] {text}" for keys, text in rows]


def help_text(
    model: BenchModel | None, actions: Collection[str], panes: Collection[tuple[str, str, str]], *, recorded: bool
) -> str:
    """Return the help for what is on the screen, in Textual's markup.

    Args:
        model: of the bench; None before anything is known.
        actions: what the bench can do.
        panes: key, name and title of the panes that have something to show.
        recorded: whether it is a recording.
    """
    own = _own(model, actions)
    parts = ["[b]What you see[/b]", *_seen(model, own, recorded), ""]
    tries = list(_tries(model, actions, own, recorded))
    if tries:
        parts += ["[b]Try[/b]", *tries, ""]
    parts += ["[b]Panes[/b]", *(f"[b]{key}[/b] {title:<10} {_PANES[name]}" for key, name, title in panes), ""]
    parts += ["[b]Of a recording[/b]", *_table(_RECORDED), ""] if recorded else []
    parts += [f"[b]{own.title}[/b]", *_table(own.rows), ""] if own.rows else []
    return "\n".join([*parts, "[b]Keys[/b]", *_table(_KEYS)])


def _own(model: BenchModel | None, actions: Collection[str]) -> Help:
    """Return what the system of the bench says."""
    if model is None:
        return Help()
    try:
        return model.dashboard.help(actions, model.driver.who)
    except Exception as error:  # noqa: BLE001 - a plug-in's: the rest is said
        return Help(seen=(escape(failed("help", error)),))


def _seen(model: BenchModel | None, own: Help, recorded: bool) -> Iterator[str]:
    if recorded:
        yield "A recording: nothing here can be changed, and every moment of it can be looked at."
    else:
        yield "A bench that runs in a process of its own: it does not wait for this screen, and goes on without it."
    yield "All times are bench time. What is not recorded is not shown."
    if model is None:
        return
    boards = ", ".join(escape(f"{about.get('board', name)}") for name, about in model.live.get("boards", {}).items())
    if boards:
        yield f"Firmware runs on an emulated {boards}, instruction by instruction; Pins show what it does."
    said = dict.fromkeys(one.help or f"The line speaks {escape(one.title)}." for one in model.frames.protocols)
    yield from said or ("None of our clients speaks to it: you look on, and can reset it.",)
    if model.world.vehicle:
        yield f"World is the truth about the {escape(model.world.vehicle)}, not what it believes."
    if model.driver.who == "figure-of-eight" and not recorded:
        yield "The demo driver has the stick: figures of eight. Press w, a, s or d and you have it."
    yield from own.seen


def _tries(model: BenchModel | None, actions: Collection[str], own: Help, recorded: bool) -> Iterator[str]:
    if recorded:
        yield "[b]e[/b] goes to the first error; [b],[/b] and [b].[/b] go through what led to it, event by event."
        return
    if "drive" in actions:
        yield "Hold [b]w[/b], then let go: the log says when the dead man stops it."
    yield from own.tries
    if "inject" in actions:
        yield "[b]i ctrl+s[/b]: noise towards the target. Counters show what is rejected, Watchdogs what is left."
        yield "[b]i[/b], drop, 60 percent: how long does the session live? States shows which way it ends."
    if model is not None and ("protocol" in model.live or "speakers" in model.live):
        yield "[b]5 up enter[/b]: a frame byte by byte. [b]/ ! enter[/b]: only those that were refused."
        yield "[b]M down enter[/b]: a message field by field; [b]enter[/b] on a field plots it."
    if "pause" in actions:
        yield "[b]p[/b] stops time itself, [b]n[/b] goes on by 0.1 s, [b]f[/b] lets it run as fast as it can."
    if "reset" in actions:
        yield "[b]r[/b] presses reset: how long until the board is heard again?"
    yield "[b]t[/b] checks a fresh bench of this kind against its suite, clause by clause."
