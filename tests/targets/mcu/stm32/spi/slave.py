"""A slave on an SPI bus that remembers."""

from __future__ import annotations

__all__ = ["Promising", "Slave"]


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

    def select(self, on):
        self.on = on
        self.releases += not on


class Promising(Slave):
    """The same, where every fifth answer is one that it will not promise."""

    def __init__(self, *answers, **about):
        super().__init__(*answers, **about)
        self.asked = 0
        self.broken = lambda: None

    def exchange(self, byte, now_ns):
        self.asked += 1
        return super().exchange(byte, now_ns)

    def promise(self, most):
        if not self.on:
            return b""
        known = 4 - len(self.taken) % 5
        return bytes((self.answers[:known] + [0xFF] * known)[:known])[:most] or None

    def take(self, data, now_ns):
        for byte in data:
            super().exchange(byte, now_ns)

    def select(self, on):
        self.broken()
        super().select(on)
