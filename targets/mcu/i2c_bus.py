"""An I2C bus between a master in a chip and the slaves: conditions and bytes, each at its own bench time.

Levels of SCL and SDA are not modelled here; for a program that moves them itself see `targets.mcu.i2c_pins`. The master
owns the timing; it calls the bus at the moments at which something
is decided, and the bus passes that on to the slaves (I2C-bus specification UM10204 section 3.1):

* START and STOP when SDA moves;
* an address and a byte that is written at the ninth clock of that byte, with the acknowledge as the answer;
* a byte that is read at the ninth clock of the byte before it, where the slave has to put its first bit on SDA. So a
  slave is asked for exactly the bytes that the master clocks out of it.

Ten-bit addresses are no case of their own here: their first byte is the 7-bit address 0x78 to 0x7B, and the second one
is a byte that is written (UM10204 section 3.1.11). The general call is address 0, which each slave may take.

Each interface of a chip has a bus. Where two of them are on the same wires, their buses are `I2cBus.joined`: the slaves
of both are reached from either, and so is the other interface, if it is a slave. Such a slave is a program, which takes
its time: meanwhile it holds SCL low (`I2cBus.hold`).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from targets.mcu.i2c_contest import Contest

__all__ = ["RELEASED", "I2cBus", "I2cInterface", "I2cMessage", "I2cSlave", "I2cTransaction"]

BYTE_BITS = 8
RELEASED = 0xFF
"""What is read while nobody pulls SDA low."""


class I2cSlave(Protocol):
    """What answers on a bus. Times are bench time in ns and never go back."""

    def address(self, address: int, read: bool, now_ns: int) -> bool:
        """Take the address of a message, 0 to 127; return whether to acknowledge it and take part in the message."""

    def write(self, byte: int, now_ns: int) -> bool:
        """Take a byte; return whether to acknowledge it."""

    def read(self, now_ns: int) -> int:
        """Return the next byte, 0 to 255."""

    def end(self, now_ns: int) -> None:
        """The message is over: a STOP, or a repeated START."""


class I2cInterface(I2cSlave, Protocol):
    """A slave that hears whatever another master does, addressed or not."""

    def started(self, now_ns: int) -> None:
        """A START, or a repeated one."""

    def answered(self, acknowledged: bool, now_ns: int) -> None:
        """The master has acknowledged a byte that it has read here, or has not."""

    def paused(self, low: bool) -> None:
        """The master holds SCL low between two bytes from now on, or does not any more."""

    def stopped(self, now_ns: int) -> None:
        """A STOP."""

    def released(self, now_ns: int) -> None:
        """The master has let go of both lines without a STOP."""


@dataclass(frozen=True, slots=True, kw_only=True)
class I2cMessage:
    """What follows one START, up to the next START or STOP.

    Attributes:
        address: 0 to 127.
        read: whether the slave was to send.
        acknowledged: whether anybody acknowledged the address.
        data: bytes, with the one that was not acknowledged.
        refused: whether the last byte that was written was not acknowledged.
        at_ns: bench time of the START.
    """

    address: int
    read: bool
    acknowledged: bool
    data: bytes
    refused: bool
    at_ns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class I2cTransaction:
    """What happened from a START to the STOP.

    Attributes:
        messages: in order, divided by repeated STARTs; none after a START that no address followed.
        begin_ns: bench time of the first START,
        end_ns: and of the STOP, or of the moment in which the master let go.
        complete: False if the master let go of the bus without a STOP.
    """

    messages: tuple[I2cMessage, ...]
    begin_ns: int
    end_ns: int
    complete: bool


@dataclass(slots=True)
class _Message:
    """A message under way; see `I2cMessage`."""

    at_ns: int
    address: int | None = None
    read: bool = False
    acknowledged: bool = False
    refused: bool = False
    data: bytearray = field(default_factory=bytearray)

    def frozen(self) -> I2cMessage:
        assert self.address is not None
        return I2cMessage(
            address=self.address,
            read=self.read,
            acknowledged=self.acknowledged,
            data=bytes(self.data),
            refused=self.refused,
            at_ns=self.at_ns,
        )


@dataclass(slots=True)
class _Transaction:
    """What happens between a START and the STOP.

    Attributes:
        messages: so far.
        addressed: who takes part in the last one.
        reached: the buses that were joined at the START.
    """

    messages: list[_Message] = field(default_factory=list)
    addressed: list[I2cSlave] = field(default_factory=list)
    reached: tuple[I2cBus, ...] = ()


class I2cBus:
    """See the module.

    Attributes:
        taps: called with every transaction, at its end.
        deaf: addresses that nobody acknowledges any more, whoever has them: a broken wire, a slave without supply.
        stretch_ns: by address, how long its slave holds SCL low after each byte of its messages.
        on_stuck: called after each change of `stuck`.
        clocked_by_pins: whether a program can clock a slave by its pins that was left in the middle of a byte. Where
            that is impossible no slave is left like that: it could never be freed.
        left: the byte that a slave was sending when the master let go, and which clock of it, 1 to 8, that was.
        interface: the interface whose bus it is, where that may be a slave.
        joined: returns the buses of other interfaces that are on the same wires at present.
        on_free: called when nobody holds SCL low any more.
        slaves: what is soldered to it.
        sticks: whether SDA is held low, see `stick`.
        holds: whether its interface holds SCL low as a slave, see `hold`.
        under_way: what its master is doing.
        contest: while another master has made a START at the same time as its own.
        master: the bus of the master that is heard here, from its START on; None for its own, and without one.
    """

    def __init__(self) -> None:
        self.taps: list[Callable[[I2cTransaction], None]] = []
        self.deaf: set[int] = set()
        self.stretch_ns: dict[int, int] = {}
        self.on_stuck: list[Callable[[], None]] = []
        self.clocked_by_pins = False
        self.left: tuple[int, int] | None = None
        self.interface: I2cInterface | None = None
        self.joined: Callable[[], tuple[I2cBus, ...]] = tuple
        self.on_free: list[Callable[[], None]] = []
        self.under_way = _Transaction()
        self.contest: Contest | None = None
        self.master: I2cBus | None = None
        self.holds = False
        self.sticks = False
        self._pulled = False
        self.slaves: list[I2cSlave] = []

    # --- for who puts it together and for who breaks it

    def attach(self, slave: I2cSlave) -> None:
        """Solder a slave to the bus. Several may have one address: what any of them pulls low is low."""
        self.slaves.append(slave)

    def stick(self) -> None:
        """Hold SDA low from now on, as a slave does that has lost count of the clocks."""
        self._set_low(stuck=True)

    def unstick(self) -> None:
        """Let go of SDA."""
        self._set_low(stuck=False)

    def pull(self, low: bool) -> None:
        """Have a slave pull SDA low until it is clocked on, or let go of it; it goes on from where it was `left`."""
        self._set_low(pulled=low)

    @property
    def stuck(self) -> bool:
        """Whether something holds SDA low."""
        return self.pulls or any(bus.pulls for bus in self.joined())

    @property
    def pulls(self) -> bool:
        """Whether something of this bus alone, not of those that are joined, does."""
        return self.sticks or self._pulled

    def hold(self, low: bool) -> None:
        """Have the interface hold SCL low as a slave, or let go of it."""
        if low is self.holds:
            return
        self.holds = low
        if self.master is not None and not self.master.held:
            for free in tuple(self.master.on_free):
                free()

    @property
    def held(self) -> bool:
        """Whether an interface that is a slave of this master holds SCL low."""
        return any(bus.holds for bus in self.under_way.reached)

    def _set_low(self, *, stuck: bool | None = None, pulled: bool | None = None) -> None:
        before = self.pulls
        self.sticks = self.sticks if stuck is None else stuck
        self._pulled = self._pulled if pulled is None else pulled
        if self.pulls is not before:
            for changed in [changed for bus in (self, *self.joined()) for changed in bus.on_stuck]:
                changed()

    # --- for the master

    @property
    def stretched_ns(self) -> int:
        """How long the slave that is addressed holds SCL low after the byte that has just ended."""
        if not self.under_way.addressed or not self.under_way.messages or self.under_way.messages[-1].address is None:
            return 0
        address = self.under_way.messages[-1].address
        return max(bus.stretch_ns.get(address, 0) for bus in (self, *self.under_way.reached))

    def start(self, now_ns: int) -> None:
        """A START, or a repeated one."""
        self._end_message(now_ns)
        if not self.under_way.messages:
            self.under_way.reached = self.joined()
            for bus in self.under_way.reached:
                bus.master = self
        self._free_slaves()
        self.under_way.messages.append(_Message(now_ns))
        for interface in self._interfaces:
            interface.started(now_ns)

    def address(self, address: int, read: bool, now_ns: int) -> bool:
        """An address was sent; return whether it was acknowledged."""
        message = self.under_way.messages[-1]
        message.address, message.read = address, read
        if not any(address in bus.deaf for bus in (self, *self.under_way.reached)):
            slaves = [slave for bus in (self, *self.under_way.reached) for slave in bus.slaves] + self._interfaces
            self.under_way.addressed = [slave for slave in slaves if slave.address(address, read, now_ns)]
        message.acknowledged = bool(self.under_way.addressed) or self._sticks
        return message.acknowledged

    def write(self, byte: int, now_ns: int) -> bool:
        """A byte was sent; return whether it was acknowledged."""
        message = self.under_way.messages[-1]
        message.data.append(byte)
        answers = [slave.write(byte, now_ns) for slave in self.under_way.addressed]
        message.refused = not any(answers) and not self._sticks
        return not message.refused

    def read(self, now_ns: int) -> int:
        """A byte is about to be clocked in; return it."""
        byte = RELEASED
        for slave in self.under_way.addressed:
            byte &= slave.read(now_ns)
        if self._sticks:
            byte = 0
        if self.under_way.messages:
            self.under_way.messages[-1].data.append(byte)
        return byte

    def answer(self, acknowledged: bool, now_ns: int) -> None:
        """A byte that was read was acknowledged, or was not."""
        for interface in self._interfaces:
            if interface in self.under_way.addressed:
                interface.answered(acknowledged, now_ns)

    def pause(self, low: bool) -> None:
        """The master holds SCL low from now on, or does not any more."""
        for interface in self._interfaces:
            interface.paused(low)

    def stop(self, now_ns: int) -> None:
        """A STOP."""
        self._end_message(now_ns)
        self._free_slaves()
        self._finish(now_ns, complete=True)
        for interface in self._let_loose():
            interface.stopped(now_ns)

    def release(self, now_ns: int, clock: int = 0) -> None:
        """The master lets go of the bus in the middle; slaves learn of it at the next START, as UM10204 has it.

        Args:
            now_ns: the present.
            clock: of the byte that is being read, 1 to 8. A slave goes on with its bit until somebody clocks it; 0 for
                none, as between two bytes (choice: its first bit is not on SDA then).
        """
        if clock and self.under_way.addressed and self.clocked_by_pins:
            byte = self.under_way.messages[-1].data[-1]
            self.left = byte, clock
            self.pull(not byte >> BYTE_BITS - clock & 1)
        self._finish(now_ns, complete=False)
        for interface in self._let_loose():
            interface.released(now_ns)

    def hand_over(self, other: I2cBus) -> None:
        """Let the master of another bus, which has done the same so far, go on with what is under way."""
        other.under_way, self.under_way = self.under_way, _Transaction()
        other.under_way.reached = other.joined()
        other.master = None
        for bus in other.under_way.reached:
            bus.master = other

    @property
    def _sticks(self) -> bool:
        return self.sticks or any(bus.sticks for bus in self.under_way.reached)

    @property
    def _interfaces(self) -> list[I2cInterface]:
        """The interfaces that hear this master."""
        return [bus.interface for bus in self.under_way.reached if bus.interface is not None]

    def _let_loose(self) -> list[I2cInterface]:
        """Return the interfaces that have heard this master; they do so no more."""
        interfaces, reached, self.under_way.reached = self._interfaces, self.under_way.reached, ()
        for bus in reached:
            bus.master = None
        return interfaces

    def _free_slaves(self) -> None:
        """A condition ends the byte that a slave was left in."""
        for bus in (self, *self.under_way.reached):
            bus.left = None
            bus.pull(False)

    def _end_message(self, now_ns: int) -> None:
        addressed, self.under_way.addressed = self.under_way.addressed, []
        for slave in addressed:
            slave.end(now_ns)

    def _finish(self, now_ns: int, *, complete: bool) -> None:
        messages, self.under_way.messages = self.under_way.messages, []
        if not messages:
            return
        transaction = I2cTransaction(
            messages=tuple(message.frozen() for message in messages if message.address is not None),
            begin_ns=messages[0].at_ns,
            end_ns=now_ns,
            complete=complete,
        )
        for tap in tuple(self.taps):
            tap(transaction)
