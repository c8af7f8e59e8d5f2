"""The line of keys at the foot of the screen."""

from __future__ import annotations

from textual.app import ComposeResult
from textual.screen import Screen
from textual.widgets import Footer

__all__ = ["KeyLine"]


class KeyLine(Footer):
    """Textual's own, but put together anew only where other keys are offered, and not whenever the focus moves.

    Each time costs two dozen widgets with their styles, and a layout of the whole screen.
    """

    def __init__(self) -> None:
        super().__init__(compact=True, show_command_palette=False)
        self._shown: list[tuple[str, str, bool]] | None = None

    def compose(self) -> ComposeResult:
        """Put the keys into the line."""
        self._shown = self._offered() if self._bindings_ready else None
        yield from super().compose()

    def bindings_changed(self, screen: Screen[object]) -> None:
        """Look whether other keys are offered."""
        if self._offered() != self._shown:
            super().bindings_changed(screen)

    def _offered(self) -> list[tuple[str, str, bool]]:
        offered = self.screen.active_bindings.values()
        return [(one.binding.key, one.binding.description, one.enabled) for one in offered if one.binding.show]
