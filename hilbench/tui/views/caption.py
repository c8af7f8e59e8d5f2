"""The caption of a demo: what happens and why it matters, with what was measured filled in."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Mapping, Sequence

from rich.text import Text

from hilbench.tui.model.bench import BenchModel
from hilbench.tui.model.checks import RUNNING, ChecksModel
from hilbench.tui.model.playing import Playing, figures
from hilbench.tui.views.words import HEAD

__all__ = ["caption_keys", "caption_of", "caption_view", "words_of"]

_FILLED_IN = re.compile(r"\{([^{}]+)\}")
_UNKNOWN = "…"


def words_of(playing: Playing, model: BenchModel | None, checks: ChecksModel | None) -> dict[str, str]:
    """Return what can be filled into a caption, by its name."""
    words = {"since": f"{playing.since_s(0 if model is None else model.ns):.1f} s"}
    if model is not None:
        words["faults"] = str(sum(model.faults.values()))
    for name, (values, unit) in figures(model).items():
        shown = "/".join(f"{value:.2f}" for value in values)
        words[name] = f"{shown} {unit}".rstrip().replace("-0.00", "0.00")
    rows = () if checks is None else checks.rows.values()
    if rows:
        words["verdict"] = ", ".join(
            "still running" if row.state in {"", RUNNING} else row.state.upper() for row in rows
        )
        words["cause"] = ", ".join(row.cause for row in rows if row.cause)
    return words


def caption_of(text: str, words: Mapping[str, str]) -> str:
    """Return a caption, filled in; what is not known yet is shown as such."""
    return _FILLED_IN.sub(lambda found: words.get(found[1], _UNKNOWN), text)


def caption_view(text: str, width: int, height: int) -> Sequence[Text]:
    """Return a caption in lines; what there is no room for is seen to be missing."""
    lines = textwrap.wrap(text, max(1, width), max_lines=max(1, height), placeholder=f" {_UNKNOWN}")
    return [Text(line, HEAD) for line in lines]


def caption_keys(playing: Playing) -> str:
    """Return the keys, which scene it is, and how long the demo takes from here."""
    minutes, seconds = divmod(round(playing.left_s), 60)
    state = "PAUSED" if playing.paused else f"{minutes}:{seconds:02d} left"
    skip = "wait for the end" if playing.skipped else "n Next"
    keys = f"space {'Continue' if playing.paused else 'Pause'}  {skip}  q Quit"
    return f"{keys}   {playing.number + 1}/{len(playing.demo.scenes)}  {state}"
