"""A board that is plugged in and out, and comes back under another name."""

from __future__ import annotations

import itertools

from hilbench.errors import UnavailableError
from hilbench.links import Line, MemoryLink, MemoryPort
from hilbench.ports.listing import PortInfo, UsbIdentity

BOARD = UsbIdentity(vendor_id=0x0483, product_id=0x374B, serial_number="0668FF30", location="1-1.2", interface=2)
ANOTHER = UsbIdentity(vendor_id=0x0483, product_id=0x374B, serial_number="0668FF31", location="1-1.3", interface=2)


class Bay:
    """A machine without ports but for a board that is plugged in and out; the port is a line in memory.

    Attributes:
        attach: puts what is on the board at the far end of the line.
    """

    def __init__(self, bench):
        self.bench = bench
        self.names = (f"/dev/ttyACM{number}" for number in itertools.count(1))
        self.device = None
        self.plugged_ns = None
        self.link = None
        self.refuse = None
        self.kind = MemoryPort
        self.attach = lambda far_end: None

    def ports(self):
        others = [PortInfo(device="/dev/ttyACM0", usb=ANOTHER), PortInfo(device="/dev/ttyS0")]
        return others if self.device is None else [*others, PortInfo(device=self.device, usb=BOARD)]

    def open(self, scheduler, target):
        if self.refuse is not None:
            raise UnavailableError(self.refuse, where=target.url)
        if target.url != self.device:
            raise UnavailableError("there is no such port", where=target.url)
        self.link = MemoryLink(scheduler, Line(baud=target.baud), name="usb")
        self.attach(self.link.b)
        self.link.a.__class__ = self.kind
        return self.link.a

    def plug_in(self):
        self.device = next(self.names)
        self.plugged_ns = self.bench.now_ns

    def pull_out(self):
        self.device = None
        self.link.hang_up()
