"""The colours of all views from the theme: they name the sixteen of a terminal, and this says which those are."""

from __future__ import annotations

from rich.terminal_theme import TerminalTheme
from textual.color import Color
from textual.theme import Theme

__all__ = ["terminal_theme"]

_TEXT = ("foreground", "text-error", "text-success", "text-warning", "primary", "text-error", "text-primary")
"""Black, red, green, yellow, blue, magenta, cyan: the theme's colours as letters can be read in. Magenta is half way
from red to cyan: no theme has as many colours as a plot needs."""
_MAGENTA, _CYAN = 5, 6
_GROUND, _SELECTED = "background", "block-cursor-background"
"""What is pointed at is bright white on bright blue, see `hilbench.tui.views.words.LIT`: letters that can be read on
the ground of the theme's own cursor."""


def terminal_theme(theme: Theme) -> TerminalTheme | None:
    """Return the terminal's colours of a theme; None of one that leaves them to the terminal."""
    system = theme.to_color_system().generate()
    ground, selected, *plain = (Color.parse(system[name]) for name in (_GROUND, _SELECTED, *_TEXT))
    if any(colour.ansi is not None for colour in (ground, selected, *plain)):
        return None
    selected = ground.blend(selected, selected.a, 1.0)
    lit = selected.get_contrast_text(1.0).rgb
    colours = [ground.blend(colour, colour.a, 1.0).rgb for colour in plain]
    colours[_MAGENTA] = plain[_MAGENTA].blend(plain[_CYAN], 0.5, 1.0).rgb
    letters = colours[0]
    bright = [*colours[:4], selected.rgb, *colours[5:], lit]
    return TerminalTheme(ground.rgb, letters, [*colours, letters], bright)
