"""The two wires of an I2C bus, for a program that moves its pins by itself.

A program without an I2C interface sets and reads the pins bit by bit. One that has an interface does so to free a bus
whose slave holds SDA low: it clocks until the slave has sent the rest of its byte and lets go (UM10204 section 3.1.16).
Here the edges become the conditions and bytes of an `I2cBus`, and what its slaves answer becomes levels:

* SDA that changes while SCL is high is a START or a STOP, whatever was under way (UM10204 section 3.1.4);
* a bit counts at the rising edge of SCL, and a slave puts its next one on SDA at the falling edge;
* a slave is asked whether it acknowledges at the falling edge of the eighth clock, and for a byte at that of the ninth.

An interface at the same pins does not move them here: it calls the bus by itself. A slave at two pins that it leaves in
the middle of a byte lets go of SDA; one that is soldered to the interface goes on from there (`I2cBus.left`).

Choices: each bus brings pull-ups of 4.7 kOhm to 3.3 V. A slave reacts at once. One that has not acknowledged takes no
part until the next START.
"""

from __future__ import annotations

import enum

from targets.mcu.i2c_bus import I2cBus
from targets.mcu.pins import DRIVER_OHMS, Pin, Source
from targets.mcu.signals import PinInput

__all__ = ["I2cPins"]

_PULL_UP = Source(3.3, 4_700.0)
_LOW = Source(0.0, DRIVER_OHMS)
_BITS = 8


class _Phase(enum.Enum):
    """What the clocks mean."""

    IDLE = "nobody takes part"
    ADDRESS = "the byte after a START"
    WRITE = "the master sends"
    READ = "a slave sends"


class I2cPins:
    """See the module.

    Args:
        bus: whose slaves they are.

    Attributes:
        bus: the bus of these slaves.
    """

    def __init__(self, bus: I2cBus) -> None:
        self.bus = bus
        self._at: tuple[Pin, Pin] | None = None
        self._clock_high = True
        self._pulling = False
        self._phase = _Phase.IDLE
        self._clocks = 0  # rising edges of SCL since the byte began
        self._byte = 0  # what has come in so far, or what goes out
        self._bit = True  # SDA at the last rising edge
        bus.clocked_by_pins = True
        bus.on_stuck.append(self._put_data)

    def put_at(self, scl: Pin, sda: Pin) -> None:
        """Be at these pins from now on."""
        self.take_away()
        self._at = scl, sda
        for pin in self._at:
            pin.put((self, "pull-up"), _PULL_UP)
        self._clock_high = scl.level is True
        scl.on_edge(self._clock_changed)
        sda.on_edge(self._data_changed)
        self._put_data()

    def take_away(self) -> None:
        """Be at no pins any more."""
        if self._at is None:
            return
        (scl, sda), self._at = self._at, None
        scl.off_edge(self._clock_changed)
        sda.off_edge(self._data_changed)
        for pin in (scl, sda):
            pin.put((self, "pull-up"), None)
            pin.put(self, None)

    def follow(self, scl: PinInput, sda: PinInput) -> None:
        """Be at the pins that carry these two signals of an interface, and go with them when they are remapped."""

        def routed() -> None:
            pins = (scl.pin, sda.pin)
            if pins != (self._at or (None, None)):
                self.take_away()
                if scl.pin is not None and sda.pin is not None:
                    self.put_at(scl.pin, sda.pin)

        scl.on_reach = sda.on_reach = routed
        routed()

    # --- edges

    def _data_changed(self, _cycle: int, ns: int, level: bool | None) -> None:
        if self._pulling or not self._clock_high:
            return
        self._clocks = 0
        if level is True:
            self._phase = _Phase.IDLE
            self.bus.stop(ns)
        else:
            self._phase = _Phase.ADDRESS
            self.bus.start(ns)

    def _clock_changed(self, _cycle: int, ns: int, level: bool | None) -> None:
        high = level is True
        if high is self._clock_high:
            return
        self._clock_high = high
        if self.bus.left is not None:
            self._go_on(self.bus.left)
        if self._phase is _Phase.IDLE:
            return
        if high:
            self._rises()
        elif self._clocks == _BITS:
            self._end_bits(ns)
        elif self._clocks > _BITS:
            self._end_byte(ns)
        elif self._phase is _Phase.READ:
            self.bus.pull(not self._byte >> _BITS - 1 - self._clocks & 1)

    def _go_on(self, left: tuple[int, int]) -> None:
        """Take over a slave that an interface has left in the middle of a byte."""
        self._byte, self._clocks = left
        self._phase = _Phase.READ
        self.bus.left = None

    def _rises(self) -> None:
        self._bit = self._at is not None and self._at[1].level is True
        if self._clocks < _BITS and self._phase is not _Phase.READ:
            self._byte = (self._byte << 1 | self._bit) & 0xFF
        self._clocks += 1

    def _end_bits(self, ns: int) -> None:
        """Ask for the acknowledge of what the master has sent; of what a slave has, the master gives it."""
        acknowledge = False
        if self._phase is _Phase.ADDRESS:
            acknowledge = self.bus.address(self._byte >> 1, bool(self._byte & 1), ns)
        elif self._phase is _Phase.WRITE:
            acknowledge = self.bus.write(self._byte, ns)
        self.bus.pull(acknowledge)

    def _end_byte(self, ns: int) -> None:
        """Go on after the ninth clock, if that one had an acknowledge."""
        self._clocks = 0
        self._stretch(ns)
        if self._bit:
            self._phase = _Phase.IDLE
        elif self._phase is _Phase.ADDRESS:
            self._phase = _Phase.READ if self._byte & 1 else _Phase.WRITE
        if self._phase is _Phase.READ:
            self._byte = self.bus.read(ns)
        self.bus.pull(self._phase is _Phase.READ and not self._byte >> _BITS - 1)

    def _stretch(self, ns: int) -> None:
        held_ns = self.bus.stretched_ns
        if held_ns and self._at is not None:
            scl = self._at[0]
            scl.put(self, _LOW)
            scl.chip.time.at_ns(ns + held_ns, lambda: scl.put(self, None))

    def _put_data(self) -> None:
        if self._at is not None:
            self._pulling = True  # what a slave does to SDA is no condition
            self._at[1].put(self, _LOW if self.bus.stuck else None)
            self._pulling = False
