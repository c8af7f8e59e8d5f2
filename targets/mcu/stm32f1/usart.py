"""USART1 to USART3: registers, flags, interrupt and DMA requests (RM0008 section 27).

Choices where the manual is silent, besides those of the transmitter and the receiver:

* A flag that is cleared by "a read of SR followed by an access to DR" is cleared only if that read has seen it.
* While ORE is set, words that come in are lost without any further flag. The manual does not say so; silicon does it
  (libopencm3 issue 918, on an STM32F103).
* Of a word that is lost by an overrun, ORE is the only flag (the manual says so of FE).
* IDLE needs a word that has set RXNE before it, also the first time.
* The end of the preamble does not set TC: TC is "the transmission of a frame containing data".
* In single-wire half-duplex mode the receiver hears what is sent, unless RE is off. Meanwhile it hears others as far as
  they come in as frames, but not what they do to the level of the pin.
* A BRR below 16 stops the bit clock.
"""

from __future__ import annotations

from targets.mcu.fidelity import Fidelity
from targets.mcu.registers import Register
from targets.mcu.serial_line import Sampled
from targets.mcu.services import InputSignal, Services
from targets.mcu.stm32.usart_base import UsartBase, listen

__all__ = ["Usart"]

SR, DR, BRR, CR1, CR2, CR3, GTPR = range(0, 0x1C, 4)

PE, FE, NE, ORE, IDLE, RXNE, TC, TXE, LBD, CTS = (1 << bit for bit in range(10))

SBK, RWU, RE, TE, IDLEIE, RXNEIE, TCIE, TXEIE, PEIE, PS, PCE, WAKE, M, UE = (1 << bit for bit in range(14))

ADD = 0xF
LBDL, LBDIE = 1 << 5, 1 << 6
CLKEN, LINEN = 1 << 11, 1 << 14

EIE, IREN, IRLP, HDSEL, NACK, SCEN, DMAR, DMAT, RTSE, CTSE, CTSIE = (1 << bit for bit in range(11))

_SAME_BIT = TXEIE | TCIE | RXNEIE | IDLEIE
"""Interrupt enables of CR1 that stand at the bit of their flag in SR."""

_ENABLES_OF_CR1 = TXEIE | TCIE | RXNEIE | IDLEIE | PEIE
_ENABLES_OF_CR3 = EIE | DMAR | DMAT | CTSIE

_CLEARED_BY_DR_READ = PE | FE | NE | ORE | IDLE
_CLEARED_BY_DR_WRITE = PE | TC

_PINS = {
    "USART1": ("PA9 (or PB6)", "PA10 (or PB7)"),
    "USART2": ("PA2 (or PD5)", "PA3 (or PD6)"),
    "USART3": ("PB10 (or PC10, PD8)", "PB11 (or PC11, PD9)"),
}


class Usart(UsartBase):
    """A USART; see `UsartBase`.

    Args:
        name: ``USART1``.
        base: address of SR.
        services: what the chip offers.
        bus: whose clock it runs on, ``APB1`` or ``APB2``.
        irq: number of its interrupt.
    """

    REGISTERS = (
        Register("SR", SR, 0xC0, CTS | LBD | TC | RXNE),
        Register("DR", DR, 0, 0x1FF),
        Register("BRR", BRR, 0, 0xFFFF),
        Register("CR1", CR1, 0, 0x3FFF),
        Register(
            "CR2",
            CR2,
            0,
            0x7F6F,
            CLKEN,
            fidelity=Fidelity.PARTLY,
            note="the synchronous clock (CLKEN, CPOL, CPHA, LBCL) is not put out; frames are asynchronous",
        ),
        Register(
            "CR3",
            CR3,
            0,
            0x7FF,
            IREN | SCEN,
            fidelity=Fidelity.PARTLY,
            note="IrDA and smartcard mode are not modelled; frames are those of asynchronous mode",
        ),
        Register("GTPR", GTPR, 0, 0xFFFF, fidelity=Fidelity.PARTLY, note="is remembered without effect"),
    )

    STATUS, CR1, CR2, CR3 = SR, CR1, CR2, CR3

    def __init__(self, name: str, base: int, services: Services, *, bus: str, irq: int) -> None:
        super().__init__(name, base, services, irq=irq)
        self._bus = bus
        self._received = 0
        self._seen = 0

    # --- what the chip calls

    def reset(self) -> None:
        """Go to the state after reset; a frame that is being sent stays on the wire as it was announced."""
        self._received = self._seen = 0
        super().reset()

    # --- registers

    def read_SR(self) -> int:
        """Return the flags; those that are set are armed to be cleared by the next access to DR."""
        self._seen = self[SR]
        return self._seen

    def write_SR(self, value: int) -> None:
        """Clear CTS, LBD, TC and RXNE where a 0 was written."""
        self[SR] &= value
        self._update()

    def read_DR(self) -> int:
        """Return the word received last, and clear RXNE and what the read of SR has armed."""
        self[SR] &= ~(RXNE | self._seen & _CLEARED_BY_DR_READ)
        self._seen &= ~_CLEARED_BY_DR_READ
        self._update()
        return self._received

    def write_DR(self, value: int) -> None:
        """Put a word into the transmit data register."""
        self[SR] &= ~(TXE | self._seen & _CLEARED_BY_DR_WRITE)
        self._seen &= ~_CLEARED_BY_DR_WRITE
        self._tx.write(self._format.word(value))
        self._update()

    def write_BRR(self, value: int) -> None:
        """Set the bit clock; a frame under way goes on at the new rate."""
        self.before_clock_change()
        self[BRR] = value
        self.after_clock_change()

    def write_CR1(self, value: int) -> None:
        """Enable, disable, frame; ask for a break, a preamble, mute mode."""
        if value & WAKE and self[SR] & RXNE:
            # "The RWU bit cannot be modified by software while the RXNE bit is set", with address mark detection.
            value = value & ~RWU | self[CR1] & RWU
        self._configure_unless(CR1, value, _ENABLES_OF_CR1)

    def write_CR2(self, value: int) -> None:
        """Set stop bits, LIN mode and the address in mute mode."""
        self._configure_unless(CR2, value, LBDIE)

    def write_CR3(self, value: int) -> None:
        """Set DMA requests, flow control and half-duplex mode."""
        self._configure_unless(CR3, value, _ENABLES_OF_CR3)

    def _configure_unless(self, offset: int, value: int, enables: int) -> None:
        """Keep a value; more than the lines changes only if there is a change outside of the bits `enables`."""
        changed = self[offset] ^ value
        self[offset] = value
        if changed & ~enables:
            self._configure()
        elif changed:
            self._update()

    def _configure(self) -> None:
        """Let everything follow the control registers."""
        self._take_frame(9 if self[CR1] & M else 8)
        self._tx.break_wanted = bool(self[CR1] & SBK)
        self._run()
        self._update()
        self._tell_setting()

    def _run(self) -> None:
        """Start and stop transmitter and receiver, and listen to the pins that matter."""
        cr1, cr3 = self[CR1], self[CR3]
        wanted = cr1 & (TE | RE) if cr1 & UE else 0
        if wanted and self[BRR] < 16:
            what = f"0x{self[BRR]:X} is no baud rate (16 is the least): {self.name} does nothing"
            self.note("misuse", "BRR", what)
            wanted = 0
        hears = self._switch_halves(wanted)
        listen(self._line_rx, self._rx.drive if hears and not cr3 & HDSEL else None)
        listen(self._line_single, self._single_changed if hears and cr3 & HDSEL else None)

    def _bit_cycles(self) -> int:
        divider = self[BRR]
        return divider * self.services.clocks.pclk(self._bus) if divider >= 16 else 0

    def _heard_at(self) -> InputSignal:
        return self._line_single if self._half_duplex() else self._line_rx

    def _sends_at_pin(self) -> bool:
        return self._line_tx.at_pin()

    def _why_deaf(self) -> str:
        pin = _PINS.get(self.name, ("its pin", "its pin"))[0 if self._half_duplex() else 1]
        return f"{pin} is not configured to let {self.name} see it"

    def _why_unseen(self) -> str:
        return f"{_PINS.get(self.name, ('its pin',))[0]} is not an alternate-function output"

    # --- sending

    def _break_sent(self) -> None:
        self[CR1] &= ~SBK

    # --- receiving

    def _word(self, sampled: Sampled) -> None:
        flags, errors = self[SR], 0
        if flags & ORE:
            self.on_word(self._format.value(sampled.word), ORE)
            return
        if self._is_muted_for(sampled.word):
            return
        if flags & RXNE:
            errors = ORE
        else:
            self._received = sampled.word
            self._idle_armed = True
            flags |= RXNE
            errors = (NE if sampled.noise else 0) | (FE if sampled.framing_error else 0)
            errors |= PE if self._format.parity_wrong(sampled.word) else 0
        self[SR] = flags | errors
        self.on_word(self._format.value(sampled.word), errors)
        self._update()

    def _is_muted_for(self, word: int) -> bool:
        """Say whether mute mode hides a word, and enter or leave the mode if the word is an address."""
        cr1 = self[CR1]
        if not cr1 & WAKE:
            return bool(cr1 & RWU)
        is_address = word >> self._format.data_bits - 1 & 1
        if not is_address:
            return bool(cr1 & RWU)
        is_mine = word & ADD == self[CR2] & ADD
        self[CR1] = cr1 & ~RWU if is_mine else cr1 | RWU
        return not is_mine

    def _wants_idle(self) -> bool:
        return self._idle_armed or self[CR1] & (RWU | WAKE) == RWU

    def _idle(self) -> None:
        if self[CR1] & RWU:
            if not self[CR1] & WAKE:
                self[CR1] &= ~RWU
        elif self._idle_armed:
            self._idle_armed = False
            self[SR] |= IDLE
            self._update()

    # --- lines

    def _update(self) -> None:
        """Drive interrupt, DMA requests and RTS from flags and enables."""
        sr, cr1, cr3 = self[SR], self[CR1], self[CR3]
        self._line_rts.set((bool(sr & RXNE) or not self._rx.running) if cr3 & RTSE else None)
        self._drive_lines(
            bool(sr & cr1 & _SAME_BIT) or self._irq_of_errors(sr, cr1, cr3),
            bool(cr3 & DMAT and sr & TXE),
            bool(cr3 & DMAR and sr & RXNE),
        )

    def _irq_of_errors(self, sr: int, cr1: int, cr3: int) -> bool:
        if not sr & (PE | FE | NE | ORE | LBD | CTS):
            return False
        return bool(
            (sr & ORE and cr1 & RXNEIE)
            or (sr & PE and cr1 & PEIE)
            or (sr & (FE | NE | ORE) and cr3 & EIE and cr3 & DMAR)
            or (sr & CTS and cr3 & CTSIE)
            or (sr & LBD and self[CR2] & LBDIE)
        )
