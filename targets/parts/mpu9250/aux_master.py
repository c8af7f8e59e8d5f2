"""The auxiliary I2C master: it fetches bytes from sensors behind the MPU-9250 (RM-MPU-9250A-00 sections 4.12 to 4.22).

Slaves 0 to 3 are visited at each sample, or at one in 1 + I2C_MST_DLY of them; slave 4 once when it is told to. What
slaves deliver stands one behind the other in EXT_SENS_DATA; who is disabled keeps its place until all are, or until
I2C_MST_RST (section 4.25). Choices: a slave that is enabled anew or with another length makes the places anew; who
does not acknowledge is asked again at the next sample, and its bytes read 0; a visit takes no time and happens at the
instant of the sample, so WAIT_FOR_ES and DELAY_ES_SHADOW change nothing and the clock of the bus means nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from targets.parts.mpu9250.ak8963 import AK8963_ADDRESS, Ak8963
from targets.parts.mpu9250.registers import Reg

__all__ = ["EXTERNAL_BYTES", "SLAVE_4_DONE", "AuxMaster"]

EXTERNAL_BYTES = 24
"""EXT_SENS_DATA_00 to 23."""

SLAVE_4_DONE = 0x40
"""In I2C_MST_STATUS; bits 0 to 4 are what was not acknowledged by slaves 0 to 4."""

_ENABLE, _SWAP, _NO_REGISTER, _ODD_PAIRS = 0x80, 0x40, 0x20, 0x10


@dataclass(frozen=True, slots=True, kw_only=True)
class _Visit:
    """One slave as its registers describe it."""

    number: int
    address: int
    register: int
    control: int
    out: int

    @property
    def reads(self) -> bool:
        return bool(self.address & 0x80)

    @property
    def length(self) -> int:
        return self.control & 0xF


class AuxMaster:
    """See the module.

    Args:
        ak8963: the only slave there is, if any.
        fetch: returns the value of a register.

    Attributes:
        external: EXT_SENS_DATA.
        status: I2C_MST_STATUS.
        slave_4_in: I2C_SLV4_DI.
    """

    def __init__(self, ak8963: Ak8963 | None, fetch: Callable[[Reg], int]) -> None:
        self._ak8963 = ak8963
        self._fetch = fetch
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.external = bytes(EXTERNAL_BYTES)
        self.status = 0
        self.slave_4_in = 0
        self._chunks: dict[int, bytes] = {}
        self._places: dict[int, int] = {}

    def controls_changed(self) -> None:
        """I2C_SLV0_CTRL to I2C_SLV3_CTRL may have been written: with the last slave the places go."""
        if not any(self._fetch(control) & _ENABLE for control in _CONTROLS.values()):
            self._places.clear()

    def read_status(self) -> int:
        """I2C_MST_STATUS is read, and cleared by that."""
        status, self.status = self.status, 0
        return status

    def chunk(self, number: int) -> bytes:
        """What slave 0 to 3 has delivered last, for the FIFO."""
        return self._chunks.get(number, b"") if self._fetch(_CONTROLS[number]) & _ENABLE else b""

    def visit_all(self, sample: int, at_ns: int) -> bool:
        """Do what is due at a sample; return whether slave 4 was visited."""
        every = 1 + (self._fetch(Reg.I2C_SLV4_CTRL) & 0x1F)
        delayed = self._fetch(Reg.I2C_MST_DELAY_CTRL)
        for number in range(4):
            visit = self._visit(number)
            due = not delayed >> number & 1 or sample % every == 0
            if visit.control & _ENABLE and due:
                self._chunks[number] = self._exchange(visit, at_ns)
            if visit.control & _ENABLE and visit.reads:
                self._places[number] = visit.length
        placed = (
            self._chunks.get(number, b"")[:size].ljust(size, b"\0") for number, size in sorted(self._places.items())
        )
        self.external = b"".join(placed)[:EXTERNAL_BYTES].ljust(EXTERNAL_BYTES, b"\0")
        return self._visit_slave_4(at_ns)

    def _visit(self, number: int) -> _Visit:
        return _Visit(
            number=number,
            address=self._fetch(_ADDRESSES[number]),
            register=self._fetch(_REGISTERS[number]),
            control=self._fetch(_CONTROLS[number]),
            out=self._fetch(_OUTS[number]),
        )

    def _visit_slave_4(self, at_ns: int) -> bool:
        control = self._fetch(Reg.I2C_SLV4_CTRL)
        if not control & _ENABLE:
            return False
        visit = _Visit(
            number=4,
            address=self._fetch(Reg.I2C_SLV4_ADDR),
            register=self._fetch(Reg.I2C_SLV4_REG),
            control=control & _NO_REGISTER | 1,
            out=self._fetch(Reg.I2C_SLV4_DO),
        )
        found = self._exchange(visit, at_ns)
        if visit.reads:
            self.slave_4_in = found[0]
        self.status |= SLAVE_4_DONE
        return True

    def _exchange(self, visit: _Visit, at_ns: int) -> bytes:
        """Talk to a slave: a byte out, or some in. Bytes of a slave that does not answer read 0 (choice)."""
        slave = self._ak8963 if visit.address & 0x7F == AK8963_ADDRESS else None
        if slave is None or not slave.address(
            AK8963_ADDRESS, visit.reads and bool(visit.control & _NO_REGISTER), at_ns
        ):
            self.status |= 1 << visit.number
            return bytes(visit.length)
        if not visit.control & _NO_REGISTER:
            slave.write(visit.register, at_ns)
        if not visit.reads:
            slave.write(visit.out, at_ns)
            slave.end(at_ns)
            return b""
        slave.address(AK8963_ADDRESS, True, at_ns)
        found = bytes(slave.read(at_ns) for _ in range(visit.length))
        slave.end(at_ns)
        return _swapped(found, visit) if visit.control & _SWAP else found


def _swapped(found: bytes, visit: _Visit) -> bytes:
    """Swap the bytes of words that begin at even addresses, or at odd ones (RM section 4.13, I2C_SLV0_GRP)."""
    data = bytearray(found)
    odd = bool(visit.control & _ODD_PAIRS)
    first = (visit.register & 1) ^ odd
    for index in range(first, len(data) - 1, 2):
        data[index], data[index + 1] = data[index + 1], data[index]
    return bytes(data)


def _of_slaves(first: Reg, step: int) -> Mapping[int, Reg]:
    return {number: Reg(first + step * number) for number in range(4)}


_ADDRESSES = _of_slaves(Reg.I2C_SLV0_ADDR, 3)
_REGISTERS = _of_slaves(Reg.I2C_SLV0_REG, 3)
_CONTROLS = _of_slaves(Reg.I2C_SLV0_CTRL, 3)
_OUTS = _of_slaves(Reg.I2C_SLV0_DO, 1)
