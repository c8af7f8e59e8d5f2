"""USARTs with ISR, ICR, RDR and TDR (RM0410 section 34, on the STM32F7; F0, F3 and L4 have the same).

Here is what their control registers set up; flags, data and requests are in ``usart_isr.c``. Those that have FIFOs as
well, on the STM32H7, are `usart_fifo.FifoUsart`.

Choices where the manual is silent, besides those of the transmitter and the receiver:

* A bit that "can only be written when the USART is disabled" keeps its value while UE stays set; that is noted.
* TEACK and REACK follow TE, RE and UE at once.
* UE cleared in mid-frame stops everything at once; the frame on the wire stays as it was announced at its start.
* A word written to TDR while UE is clear is lost.
* Frames are handed over as lines that idle high. With TXINV or RXINV whoever sends or takes frames at the far end is
  taken to be inverted too; the levels at the pins are the inverse ones.
* In single-wire half-duplex mode the receiver hears what is sent, unless RE is off. Meanwhile it hears others as far as
  they come in as frames, but not what they do to the level of the pin.
* RTOEN and RTOR are looked at when a word is complete.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from fractions import Fraction
from typing import ClassVar

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.services import InputSignal, Services
from targets.mcu.stm32.usart_base import UsartBase, listen
from targets.mcu.stm32.usart_line import Kind
from targets.mcu.stm32.usart_receiver import Receiver

__all__ = ["Usart"]

CR1, CR2, CR3, BRR, GTPR, RTOR, RQR, ISR, ICR, RDR, TDR = range(0, 0x2C, 4)

PE, FE, NF, ORE, IDLE, RXNE, TC, TXE, LBDF, CTSIF, CTS, RTOF, EOBF = (1 << bit for bit in range(13))
BUSY, CMF, SBKF, RWU, WUF, TEACK, REACK = (1 << bit for bit in range(16, 23))

UE, UESM, RE, TE, IDLEIE, RXNEIE, TCIE, TXEIE, PEIE, PS, PCE, WAKE, M0, MME, CMIE, OVER8 = (1 << n for n in range(16))
DEDT_DEAT, RTOIE, EOBIE, M1 = 0x3FF << 16, 1 << 26, 1 << 27, 1 << 28

ADDM7, LBDL, LBDIE = 1 << 4, 1 << 5, 1 << 6
CLOCK, STOP, LINEN, SWAP, RXINV, TXINV, DATAINV, MSBFIRST = 0xF << 8, 3 << 12, *(1 << bit for bit in range(14, 20))
CLKEN, ABREN, ABRMOD, RTOEN, ADD = 1 << 11, 1 << 20, 3 << 21, 1 << 23, 0xFF << 24

EIE, IREN, IRLP, HDSEL, NACK, SCEN, DMAR, DMAT, RTSE, CTSE, CTSIE, ONEBIT, OVRDIS, DDRE, DEM, DEP = (
    1 << bit for bit in range(16)
)
SCARCNT, WUS, WUFIE, UCESM = 7 << 17, 3 << 20, 1 << 22, 1 << 23

ABRRQ, SBKRQ, MMRQ, RXFRQ, TXFRQ = (1 << bit for bit in range(5))

AFTER_RESET = TC | TXE
CLEARED_BY_ICR = PE | FE | NF | ORE | IDLE | TC | LBDF | CTSIF | RTOF | EOBF | CMF | WUF

_LOCKED = {
    CR1: M1 | DEDT_DEAT | OVER8 | M0 | WAKE | PCE | PS,
    CR2: ADDM7 | LBDL | CLOCK | STOP | LINEN | SWAP | RXINV | TXINV | DATAINV | MSBFIRST | ABRMOD,
    CR3: IREN | IRLP | HDSEL | NACK | SCEN | RTSE | CTSE | ONEBIT | OVRDIS | DDRE | DEM | DEP | SCARCNT | WUS,
    BRR: 0xFFFF,
    GTPR: 0xFFFF,
}
"""Bits that can be written only while UE is clear (RM0410 section 34.8)."""

_WORD_BITS = {0: 8, M0: 9, M1: 7}
_LEAST_DIVIDER = 16


class Usart(UsartBase):
    """A USART or UART; see `UsartBase`.

    Args:
        name: ``USART3`` or ``UART4``.
        base: address of CR1.
        services: what the chip offers.
        irq: number of its interrupt.
        kernel_hz: returns the rate of the clock that BRR divides; 0 while it stands still. The peripheral is told of
            changes as of any change of a clock.
    """

    REGISTERS: ClassVar[tuple[Register, ...]] = (
        Register(
            "CR1",
            CR1,
            writable=0x1FFF_FFFF,
            ignored=EOBIE | UESM,
            fidelity=Fidelity.PARTLY,
            note="the end of a smartcard's block (EOBIE) and waking up from Stop mode (UESM) are not modelled",
        ),
        Register(
            "CR2",
            CR2,
            writable=0xFFFF_FF70,
            ignored=CLKEN | ABREN,
            fidelity=Fidelity.PARTLY,
            note="no clock is put out (CLKEN), and the rate is not measured (ABREN); frames are asynchronous",
        ),
        Register(
            "CR3",
            CR3,
            writable=0x00FE_FFFF,
            ignored=IREN | SCEN | DEM | WUFIE | UCESM,
            fidelity=Fidelity.PARTLY,
            note="IrDA, smartcard, driver enable (DEM) and waking up from Stop mode are not modelled",
        ),
        Register("BRR", BRR, writable=0xFFFF),
        Register("GTPR", GTPR, writable=0xFFFF, fidelity=Fidelity.PARTLY, note="is remembered without effect"),
        Register(
            "RTOR",
            RTOR,
            ignored=0xFF00_0000,
            fidelity=Fidelity.PARTLY,
            note="BLEN, the length of a smartcard's block, is remembered without effect",
        ),
        Register(
            "RQR",
            RQR,
            writable=0x1F,
            ignored=ABRRQ,
            fidelity=Fidelity.PARTLY,
            note="the rate is not measured (ABRRQ)",
        ),
        Register(
            "ISR",
            ISR,
            reset=AFTER_RESET,
            writable=0,
            fidelity=Fidelity.PARTLY,
            note="EOBF, ABRE, ABRF and WUF are never set",
        ),
        Register("ICR", ICR, writable=CLEARED_BY_ICR),
        Register("RDR", RDR, writable=0),
        Register("TDR", TDR, writable=0x1FF),
    )

    STATUS, CR1, CR2, CR3 = ISR, CR1, CR2, CR3
    KIND = Kind.ISR
    LEAST_DIVIDER: ClassVar[str] = "16 is the least USARTDIV"
    LOCKED: ClassVar[Mapping[int, int]] = _LOCKED

    def __init__(
        self, name: str, base: int, services: Services, *, irq: int, kernel_hz: Callable[[], Fraction]
    ) -> None:
        super().__init__(name, base, services, irq=irq)
        self._kernel_hz = kernel_hz
        self._outputs = (self._line_tx, services.output(f"{name}_RX"))

    def _make_receiver(self) -> Receiver:
        rx = super()._make_receiver()
        rx.on_timeout = self._timed_out
        return rx

    # --- status and data

    def read_ISR(self) -> int:
        """Return the flags, with the level of CTS (inverted) and whether a word is coming in."""
        return self[ISR] | (0 if self._line_cts.level() else CTS) | (BUSY if self._rx.busy else 0)

    def read_ICR(self) -> int:
        """Write-only: reads 0."""
        return 0

    def read_RQR(self) -> int:
        """Write-only: reads 0."""
        return 0

    def write_RQR(self, value: int) -> None:
        """Ask for a break, mute mode, or that received or waiting data be thrown away."""
        if value & RXFRQ:
            self._kept.unread = 0
            self[ISR] &= ~RXNE
        if value & TXFRQ:
            self._kept.unsent = self._kept.holds = 0
            self[ISR] |= TXE
        if value & MMRQ and self[CR1] & MME:
            self[ISR] |= RWU
        if value & SBKRQ:
            self[ISR] |= SBKF
            self._kept.break_wanted = True
            self._line.proceed()
        self._update()

    def write_TDR(self, value: int) -> None:
        """Lose a word that C does not take."""
        self[TDR] = value
        self.note("misuse", "TDR", "written while UE is clear: nothing is sent")

    # --- configuration

    def write_CR1(self, value: int) -> None:
        """Enable, disable, frame. Clearing UE stops everything and sets the flags as after reset."""
        stops = self[CR1] & UE and not value & UE
        self._write_control(CR1, value)
        if stops:
            self._stop()

    def write_CR2(self, value: int) -> None:
        """Set stop bits, levels, order of bits, LIN mode and address."""
        if self[CR1] & (UE | RE) == UE | RE and (value ^ self[CR2]) & ADD:
            self.note("misuse", "CR2", "ADD cannot be changed while the receiver is enabled: it keeps its value")
            value = value & ~ADD | self[CR2] & ADD
        self._write_control(CR2, value)
        for bit, name in ((TXINV, "TXINV"), (RXINV, "RXINV")):
            if self[CR2] & bit:
                text = "frames are those of a far end that is inverted too; the pin has the inverse levels"
                self.note("assumed", f"CR2.{name}", text)

    def write_CR3(self, value: int) -> None:
        """Set DMA requests, flow control, half-duplex mode and what to do about errors."""
        self._write_control(CR3, value)

    def write_BRR(self, value: int) -> None:
        """Set the divider of the bit clock."""
        self.before_clock_change()
        self[BRR] = self._permitted(BRR, value)
        if self[CR1] & OVER8 and self[BRR] & 0x8:
            self.note("misuse", "BRR", "bit 3 must be kept clear with OVER8; it is not looked at")
        self.after_clock_change()

    def write_GTPR(self, value: int) -> None:
        """Keep guard time and prescaler."""
        self[GTPR] = self._permitted(GTPR, value)

    def write_RTOR(self, value: int) -> None:
        """Set the timeout, in bits."""
        self[RTOR] = value
        self._configure()

    def _permitted(self, offset: int, value: int) -> int:
        """Return what a write leaves: some bits are locked while UE is set."""
        stays_enabled = self[CR1] & UE and not (offset == CR1 and not value & UE)
        locked = (value ^ self[offset]) & self.LOCKED[offset] if stays_enabled else 0
        if locked:
            name = self.registers[offset].name
            self.note("misuse", name, f"bits 0x{locked:X} cannot be changed while UE is set: they keep their value")
        return value ^ locked

    def _write_control(self, offset: int, value: int) -> None:
        value = self._permitted(offset, value)
        changed = self[offset] ^ value
        if not self.in_c.store(offset, value):
            self[offset] = value
            self._configure()
        if offset == CR1 and changed & OVER8:
            self.after_clock_change()

    def _stop(self) -> None:
        if not self._kept.quiet:
            text = "UE was cleared while a frame was being sent: silicon breaks it off, here it was sent to its end"
            self.note("misuse", "CR1.UE", text)
        self._tx.reset()
        self._kept.idle_armed = False
        self[ISR] = self.registers[ISR].reset
        self._update()

    def _configure(self) -> None:
        """Let everything follow the control registers."""
        cr1, cr2, cr3 = self[CR1], self[CR2], self[CR3]
        tx, rx = self._tx, self._rx
        word_bits = _WORD_BITS.get(cr1 & (M0 | M1), 8)
        if cr1 & (M0 | M1) == M0 | M1:
            self.note("reserved", "CR1.M", "11 is reserved: words have 8 bits")
        self._take_frame(word_bits)
        tx.inverted = bool(cr2 & TXINV)
        rx.oversampling = 8 if cr1 & OVER8 else 16
        rx.one_sample = bool(cr3 & ONEBIT)
        rx.timeout_bits = self[RTOR] & 0xFF_FFFF if cr2 & RTOEN else None
        tx.move(self._outputs[bool(cr2 & SWAP)])
        self._run()
        self._update()
        self._tell_setting()

    def _run(self) -> None:
        """Start and stop transmitter and receiver, and listen to the pins that matter."""
        cr1, cr3 = self[CR1], self[CR3]
        wanted = cr1 & (TE | RE) if cr1 & UE else 0
        if wanted and not self._divider():
            text = f"0x{self[BRR]:X} is no baud rate ({self.LEAST_DIVIDER}): {self.name} does nothing"
            self.note("misuse", "BRR", text)
            wanted = 0
        acknowledged = (TEACK if wanted & TE else 0) | (REACK if wanted & RE else 0)
        self[ISR] = self[ISR] & ~(TEACK | REACK) | acknowledged
        hears = self._switch_halves(wanted)
        single = bool(cr3 & HDSEL)
        heard = self._heard_at() if hears else None
        for line in (self._line_rx, self._line_single):
            listen(line, (self._single_heard if single else self._heard) if line is heard else None)

    def _divider(self) -> int | Fraction:
        """Return ticks of the kernel clock in a bit; 0 if BRR is no rate."""
        brr = self[BRR]
        if not self[CR1] & OVER8:
            return brr if brr >= _LEAST_DIVIDER else 0
        doubled = brr & 0xFFF0 | (brr & 0x7) << 1
        return doubled // 2 if doubled >= _LEAST_DIVIDER else 0

    def _bit_cycles(self) -> int | Fraction:
        divider, kernel_hz = self._divider(), self._kernel_hz()
        if not divider or not kernel_hz:
            return 0
        cycles = divider * self.time.hclk_hz / kernel_hz
        return cycles.numerator if cycles.denominator == 1 else cycles

    # --- the line

    def _heard_at(self) -> InputSignal:
        # Half duplex uses the pin of the sender, and SWAP exchanges the two.
        return self._line_single if self._half_duplex() is not bool(self[CR2] & SWAP) else self._line_rx

    def _sends_at_pin(self) -> bool:
        return self._outputs[bool(self[CR2] & SWAP)].at_pin()

    def _why_deaf(self) -> str:
        signal = "TX" if self._heard_at() is self._line_single else "RX"
        return f"no pin has the alternate function {self.name}_{signal} and leaves the line to others"

    def _why_unseen(self) -> str:
        return f"no pin has the alternate function {self.name}_{'RX' if self[CR2] & SWAP else 'TX'}"

    def _heard(self, level: bool) -> None:
        self._rx.drive(level is not bool(self[CR2] & RXINV))

    def _single_heard(self, level: bool) -> None:
        self._single_changed(level is not bool(self[CR2] & RXINV))

    def _timed_out(self) -> None:
        self[ISR] |= RTOF
        self._update()
