"""The lock of a GPIO port: LCKR and its key sequence (RM0008 section 9.2.7, RM0410 section 6.4.8).

Write 1, 0, 1 to LCKK with the same LCK bits, then read: from then on, until a reset, the port refuses to configure
those pins anew. Whatever breaks the sequence begins it anew.
"""

from __future__ import annotations

__all__ = ["PortLock"]

_LCKK = 1 << 16
_WRITES = 3
_LOCKED = 4


class PortLock:
    """LCKR of one port."""

    __slots__ = ("_mask", "_shown", "_step")

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Go to the state after reset: nothing is locked."""
        self._step = 0
        self._mask = 0
        self._shown = 0

    @property
    def pins(self) -> int:
        """The pins that are locked, one bit for each; 0 until the sequence is complete."""
        return self._mask if self._step == _LOCKED else 0

    def write(self, value: int) -> None:
        """Take one step of the sequence, or begin anew."""
        if self._step == _LOCKED:
            return
        mask, key = value & 0xFFFF, bool(value & _LCKK)
        if self._step and mask != self._mask:
            self._step = 0
        expected = self._step != 1
        if key is expected and self._step < _WRITES:
            self._step += 1
        else:
            self._step = 1 if key else 0
        self._mask = self._shown = mask

    def read(self) -> int:
        """Return LCKR. The read that ends the sequence still shows LCKK as 0; from the next on it shows 1."""
        value = self._shown
        if self._step == _WRITES:
            self._step = _LOCKED
            self._shown = value | _LCKK
        elif self._step != _LOCKED:
            self._step = 0
        return value
