"""A slave on an SPI bus that remembers."""

from __future__ import annotations

__all__ = ["Slave"]


class Slave:
    """Answers with what it was given to say, then with 0xFF."""

    def __init__(self, *answers, modes=(0, 3)):
        self.answers = list(answers)
        self.modes = frozenset(modes)
        self.taken = []
        self.on = True
        self.releases = 0

    def selected(self, now_ns):
        del now_ns
        return self.on

    def exchange(self, byte, now_ns):
        self.taken.append((byte, now_ns))
        return self.answers.pop(0) if self.answers else 0xFF

    def answer(self):
        return self.answers[0] if self.answers else 0xFF

    @property
    def bytes(self):
        return bytes(byte for byte, _ in self.taken)
