"""The line of keys at the foot of the screen: those of the pane that has the focus, then what matters now."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from textual.app import ComposeResult
from textual.binding import Binding
from textual.screen import Screen
from textual.widgets import Footer
from textual.widgets._footer import FooterKey

from hilbench.tui.keys import ALWAYS

__all__ = ["KeyLine"]

Offered = tuple[str, str, str, str]


class KeyLine(Footer):
    """See the module.

    It is put together anew only where other keys are offered, and not whenever the focus moves: each time costs two
    dozen widgets with their styles, and a layout of the whole screen.
    """

    def __init__(self) -> None:
        super().__init__(compact=True, show_command_palette=False)
        self._wanted: Sequence[tuple[str, str]] = ()
        self._shown: list[Offered] | None = None

    def compose(self) -> ComposeResult:
        """Put the keys into the line."""
        self._shown = self._offered() if self._bindings_ready else None
        self.styles.grid_size_columns = len(self._shown or ())
        for key, display, description, action in self._shown or ():
            shown = FooterKey(key, display, description, action, classes="-compact")
            shown.set_reactive(FooterKey.compact, True)
            yield shown

    def look(self, wanted: Sequence[tuple[str, str]]) -> None:
        """Offer what matters now.

        Args:
            wanted: actions and what they are called, the most important first.
        """
        if wanted != self._wanted:
            self._wanted = wanted
            self.bindings_changed(self.screen)

    def on_resize(self) -> None:
        """Offer as many as there is room for now."""
        self.bindings_changed(self.screen)

    def bindings_changed(self, screen: Screen[object]) -> None:
        """Look whether other keys are offered."""
        if self._offered() != self._shown:
            super().bindings_changed(screen)

    def _offered(self) -> list[Offered]:
        """Return the keys that there is room for; those that are always there stand last, and keep their places."""
        last = [one for action, called in ALWAYS for one in self._of(action, called)]
        room = self.size.width - sum(map(_cells, last))
        found = []
        for one in [*self._of_pane(), *(one for action, called in self._wanted for one in self._of(action, called))]:
            if one not in found and _cells(one) <= room:
                room -= _cells(one)
                found.append(one)
        return [*found, *last]

    def _of_pane(self) -> Iterator[Offered]:
        for active in self.screen.active_bindings.values():
            if active.node not in {self.app, self.screen} and active.binding.show:
                yield self._key(active.binding, active.binding.description)

    def _of(self, action: str, called: str) -> Iterator[Offered]:
        """Yield the key of an action of the dashboard, if it is offered."""
        active = [one.binding for one in self.screen.active_bindings.values() if one.node is self.app and one.enabled]
        found = next((binding for binding in active if binding.action == action), None)
        if found is not None:
            yield self._key(found, called)

    def _key(self, binding: Binding, called: str) -> Offered:
        return binding.key, self.app.get_key_display(binding), called, binding.action


def _cells(offered: Offered) -> int:
    return len(offered[1]) + len(offered[2]) + 2
