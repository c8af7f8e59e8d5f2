"""The first two lines: what is watched and how it goes; what goes on, and what to press."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from rich.text import Text

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.views.words import DIM, HEAD

__all__ = ["guide_view", "head_view", "target_words"]

_BETWEEN = " │ "
_DOWN = " DOWN"


def head_view(model: BenchModel, now: str, width: int, said: str = "") -> Text:
    """Return target, line, driver, faults and clock in one line; where there is little room, the last two first.

    Args:
        model: of the bench.
        now: the clock, and what is to be said of it.
        width: cells in the line.
        said: what is said besides.
    """
    faults, down = len(model.armed), not all(line.about.get("up") for line in model.lines.values())
    parts = [
        target_words(model),
        *_lines(model),
        f"driver {model.driver.who}" if model.driver.who else "",
        f"{faults} fault{'s' * (faults != 1)} on the line" if faults else "" if down else "no faults",
        said,
    ]
    name = f" {model.name}"
    shown = [part for part in parts if part]
    room = width - len(name) - len(now) - 2
    while shown and sum(len(part) + len(_BETWEEN) for part in shown) > room:
        shown.pop(_least(shown))
    left = Text(_BETWEEN.join([name, *shown]))
    if faults:
        left.highlight_words([parts[-2]], "reverse")
    left.append(f"{now} ".rjust(max(2, width - left.cell_len)))
    return left


def _least(shown: list[str]) -> int:
    """Return which part is left out first: target and line say what does not change, unless the line is down."""
    kept = ("driver ", "fault", _DOWN)
    return next((at for at, part in enumerate(shown) if not any(word in part for word in kept)), 0)


def target_words(model: BenchModel) -> str:
    """Return what is under test: the boards, else the vehicle, else what is spoken."""
    boards = [str(about.get("board", name)) for name, about in model.live.get("boards", {}).items()]
    return "+".join(boards) or model.world.vehicle or _spoken(model)


def _spoken(model: BenchModel) -> str:
    return ", ".join(protocol.title for protocol in model.frames.protocols)


def _lines(model: BenchModel) -> Iterator[str]:
    """Yield the port of each line and its rate; a line without a port of its own has its name."""
    for name, line in model.lines.items():
        port = str(line.about.get("port", name))
        baud = f" {line.about['baud']}" if line.about.get("baud") else ""
        state = "" if line.about.get("up") else _DOWN
        yield f"{port if '/' in port or ':' in port else name}{baud}{state}"


def guide_view(model: BenchModel | None, actions: Collection[str], width: int, *, recorded: bool) -> Text:
    """Return what goes on, and what to press; where there is little room, the last keys are left out.

    Args:
        model: of the bench; None before anything is known of it.
        actions: what the bench can do, and `check` where it has a suite.
        width: cells in the line.
        recorded: whether it is a recording.
    """
    if model is None:
        return Text(" The bench starts.", DIM)
    said, keys = _recording(model) if recorded else _live(model, actions)
    line, last = Text(f" {said} "), _key("?", "explains")
    for key, does in keys:
        one = _key(key, does)
        if line.cell_len + one.cell_len + last.cell_len <= width:
            line.append_text(one)
    return line.append_text(last)


def _key(key: str, does: str) -> Text:
    return Text.assemble(" ", (key, f"{HEAD} cyan"), f" {does} ")


Keys = list[tuple[str, str]]


def _recording(model: BenchModel) -> tuple[str, Keys]:
    return f"A recording of {model.name}.", [("p", "plays"), ("← →", "a second"), ("e", "the next error")]


def _live(model: BenchModel, actions: Collection[str]) -> tuple[str, Keys]:
    """Return what goes on, and the keys that matter most then."""
    usual = [("i", "a fault")] * ("inject" in actions) + [("t", "checks")] * ("check" in actions)
    usual += [("M", "messages")] * bool(model.frames.protocols) + [("B", "tables")] * bool(model.tables.shown)
    world = model.world
    where = f" {world.vehicle}{f' ({world.scene})' if world.scene else ''}" if world.vehicle else ""
    if model.paused:
        return "Bench time stands still.", [("p", "goes on"), ("n", "0.1 s"), *usual]
    if model.driver.by_hand:
        return f"You drive{where}; let go, and it stops.", [("space", "stops"), ("o", "demo"), *usual]
    if not model.driver.nobody:
        return f"The demo drives{where}.", [("wasd", "you drive")] * ("drive" in actions) + usual
    if "drive" in actions:
        keys = [("c", "connects")] * ("connect" in actions) + [("wasd", "drives")]
        return f"Nobody drives{where}.", [*keys, *[("o", "demo")] * ("demo" in actions), *usual]
    if model.live.get("boards"):
        own = [("r", "resets"), ("I", "a stimulus")]
        return f"{target_words(model)} runs its firmware.", own + usual
    does = "speaks" if model.live.get("operator") in model.machines else "listens to"
    return f"hilbench {does} {_spoken(model)}.", usual
