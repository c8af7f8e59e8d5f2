"""A request to DMA that a field of AFIO moves from one channel to another."""

from __future__ import annotations

from targets.mcu.services import DmaRequest

__all__ = ["RequestChoice"]


class RequestChoice:
    """One of two requests; see `targets.mcu.services.DmaRequest`.

    A level goes along when it is moved; a pulse that was not served yet is lost (choice).

    Args:
        usual: where it goes after reset.
        moved: where it goes when it is moved.
    """

    in_c = None

    def __init__(self, usual: DmaRequest, moved: DmaRequest) -> None:
        self._both = (usual, moved)
        self._chosen = usual
        self._level = False

    def choose(self, *, moved: bool) -> None:
        """Go to the one or the other."""
        chosen = self._both[moved]
        if chosen is not self._chosen:
            self._chosen.set(False)
            self._chosen = chosen
            chosen.set(self._level)

    def set(self, level: bool) -> None:
        """Drive the request."""
        self._level = level
        self._chosen.set(level)

    def pulse(self) -> None:
        """Ask for one transfer."""
        self._chosen.pulse()
