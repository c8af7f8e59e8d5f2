"""An input of a peripheral that a field of AFIO takes away from its pin and ties to a signal inside the chip."""

from __future__ import annotations

from collections.abc import Callable

from targets.mcu.services import InputSignal

__all__ = ["InputChoice"]


class InputChoice:
    """One of two inputs; see `targets.mcu.services.InputSignal`.

    Args:
        pin: the input as it is at a pin.
        inside: what it is connected to instead.
    """

    def __init__(self, pin: InputSignal, inside: InputSignal) -> None:
        self._both = (pin, inside)
        self._chosen = pin
        self._on_change: Callable[[bool], None] | None = None
        self.on_reach: Callable[[], None] | None = None

    def choose(self, *, inside: bool) -> None:
        """Take the signal inside, or that of the pin; who listens is told if the level changes by that."""
        chosen = self._both[inside]
        if chosen is self._chosen:
            return
        before = self.level()
        self._chosen.on_change = None
        self._chosen = chosen
        chosen.on_change = self._on_change
        if self._on_change is not None and chosen.level() is not before:
            self._on_change(not before)

    @property
    def on_change(self) -> Callable[[bool], None] | None:
        """Called with the new level, at the cycle of the change; None while nobody listens."""
        return self._on_change

    @on_change.setter
    def on_change(self, callback: Callable[[bool], None] | None) -> None:
        self._on_change = callback
        self._chosen.on_change = callback

    def level(self) -> bool:
        """Return the present level."""
        return self._chosen.level()

    def holds(self, forget: Callable[[], None]) -> bool:  # noqa: ARG002
        """Nobody knows: another may be chosen."""
        return False

    def at_pin(self) -> bool:
        """Say whether what is outside of a pin can reach the signal."""
        return self._chosen.at_pin()
