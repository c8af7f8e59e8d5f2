"""A port of which nobody looks at the pins against one of which somebody looks at each: programs must see the same."""

from __future__ import annotations

from hypothesis import strategies as st

from targets.mcu.testing import peek, poke


def actions(configurations):
    """Return a strategy of what happens to a port, each so many cycles after the one before."""
    numbers = st.integers(0, 7)
    write = st.tuples(
        st.sampled_from(["ODR", "BSRR", "BRR", "IDR"]), st.one_of(st.integers(0, 0xFF), st.integers(0, 0xFFFF_FFFF))
    )
    other = st.one_of(
        st.tuples(st.just("configure"), st.tuples(numbers, configurations)),
        st.tuples(st.sampled_from(["record", "follow", "look", "take"]), numbers),
        st.tuples(st.just("drive"), st.tuples(numbers, st.sampled_from([None, True, False]))),
        st.tuples(st.sampled_from(["clock", "reset"]), st.integers(1, 3)),
    )
    return st.lists(st.tuples(st.integers(1, 50), st.one_of(write, write, other)), min_size=4, max_size=25)


class Script:
    """A port and what was seen of it.

    Args:
        pinout: the port's chip.
        letter: which port.
        configure: called with the pinout, a pin's number and how it is to be.
        looks: whether somebody looks at each pin, so that Python is told of each change.
    """

    def __init__(self, pinout, letter, configure, *, looks):
        self.pinout, self.port, self.configure = pinout, pinout.ports[letter], configure
        self.pins, self.seen = self.port.pins, []
        for pin in self.pins[:3]:
            pin.record()
        for pin in self.pins[2:6]:
            pin.follow()
        if looks:
            for pin in self.pins:
                pin.on_edge(lambda *_edge: None)

    def run(self, script):
        """Do all that; return what was seen."""
        for after, (what, how) in script:
            self.pinout.chip.advance(after)
            self.do(what, how)
            self.seen.append([peek(self.port, name) for name in ("IDR", "ODR", "BSRR")])
        self.pinout.chip.advance(7)
        self.seen += [(pin.level, pin.latch, pin.take_edges(), pin.take_followed()) for pin in self.pins]
        return self.seen

    def do(self, what, how):
        """Do one thing."""
        if what.isupper():
            if what in [register.name for register in self.port.registers.values()]:
                poke(self.port, what, how)
        else:
            getattr(self, f"_{what}")(how)

    def _configure(self, how):
        self.configure(self.pinout, *how)

    def _record(self, number):
        self.pins[number].record(not self.pins[number].recording)

    def _follow(self, number):
        self.pins[number].follow(not self.pins[number].following)

    def _look(self, number):
        self.seen.append((self.pins[number].level, self.pins[number].volts))

    def _take(self, number):
        followed = sorted(self.pinout.pins.take_followed(), key=lambda pair: pair[0].name)
        self.seen.append((self.pins[number].take_edges(), [(pin.name, edges) for pin, edges in followed]))

    def _drive(self, how):
        if self.pins[how[0]].bonded:
            self.pins[how[0]].drive(how[1])

    def _clock(self, divider):
        self.pinout.chip.change_clock(hclk_hz=72_000_000 // divider)

    def _reset(self, _number):
        self.port.reset()
