"""What drivers in the field do, as sequences of register accesses, against the far end of the line.

Each class follows one library's published source; names of functions are theirs. What matters is the order of accesses
and which flags they rely on.
"""

from __future__ import annotations

import pytest

from tests.each import each
from tests.share import matrix

PE, FE, NE, ORE, IDLE, RXNE, TC, TXE, LBD, CTS = (1 << bit for bit in range(10))
SBK, RWU, RE, TE, IDLEIE, RXNEIE, TCIE, TXEIE, PEIE, PS, PCE, WAKE, M, UE = (1 << bit for bit in range(14))
EIE, HDSEL, DMAR, DMAT, RTSE, CTSE = 1, 8, 0x40, 0x80, 0x100, 0x200
ERRORS = PE | FE | NE | ORE
RAM = 0x2000_0000
IRQ = {"USART1": 37, "USART2": 38, "USART3": 39}
BASE = {"USART1": 0x4001_3800, "USART2": 0x4000_4400, "USART3": 0x4000_4800}
DMA_CHANNELS = {"USART1": (4, 5), "USART2": (7, 6), "USART3": (2, 3)}
TEXT = b"The quick brown fox jumps over the lazy dog.\r\n"
NAMES = list(IRQ)


class TestLibopencm3:
    """lib/stm32/common/usart_common_all.c and usart_common_f124.c; examples usart, usart_irq, usart_printf."""

    def setup(self, cpu, usart, name, baud):
        clock = cpu.chip.time.hclk_hz // cpu.chip.clocks.pclk("APB2" if name == "USART1" else "APB1")
        usart.BRR = (clock + baud // 2) // baud
        usart.CR1 = usart.CR1 & ~M
        usart.CR2 = usart.CR2 & ~0x3000
        usart.CR1 = usart.CR1 & ~(RE | TE) | RE | TE
        usart.CR1 = usart.CR1 & ~(PCE | PS)
        usart.CR3 = usart.CR3 & ~(RTSE | CTSE)
        usart.CR1 = usart.CR1 | UE

    def send_blocking(self, usart, value):
        while not usart.SR & TXE:
            pass
        usart.DR = value & 0x1FF

    def recv_blocking(self, usart):
        while not usart.SR & RXNE:
            pass
        return usart.DR & 0x1FF

    @pytest.mark.parametrize(("name", "baud"), matrix(NAMES, [9600, 115200, 921600]))
    def test_blocking(self, make_board, name, baud):
        cpu, usart, _, far = make_board(name, baud)
        self.setup(cpu, usart, name, baud)
        far.echoes = True
        received = bytearray()
        for value in TEXT[:3]:
            self.send_blocking(usart, value)
            received.append(self.recv_blocking(usart))
        assert far.heard == received == TEXT[:3]

    def test_echo_by_interrupt(self, make_board):
        """usart_irq.c: the handler stores the byte and enables TXEIE; sending it, it disables TXEIE."""
        cpu, usart, _, far = make_board("USART1", 230400)
        data = [ord("A")]

        def handler():
            if usart.CR1 & RXNEIE and usart.SR & RXNE:
                data[0] = usart.DR & 0x1FF
                usart.CR1 = usart.CR1 | TXEIE
            if usart.CR1 & TXEIE and usart.SR & TXE:
                usart.DR = data[0] & 0x1FF
                usart.CR1 = usart.CR1 & ~TXEIE

        self.setup(cpu, usart, "USART1", 230400)
        usart.CR1 = usart.CR1 | RXNEIE
        cpu.handlers[37] = handler
        cpu.wait(10_000)
        far.say(TEXT)
        cpu.wait_for(lambda: len(far.heard) == len(TEXT))
        assert far.heard == TEXT


class TestStandardPeripheralLibrary:
    """STM32F10x_StdPeriph_Lib V3.5.0: stm32f10x_usart.c and the example USART/Printf."""

    def init(self, usart, brr):
        usart.CR2 = usart.CR2 & ~0x3000
        usart.CR1 = usart.CR1 & ~(M | PCE | PS | TE | RE) | TE | RE
        usart.CR3 = usart.CR3 & ~(RTSE | CTSE)
        usart.BRR = brr
        usart.CR1 = usart.CR1 | UE

    def test_the_first_byte_is_lost_as_on_silicon(self, make_board):
        """USART_SendData, then wait for TC: it is still set from reset, so the second byte overwrites the first.

        The preamble keeps the first byte in the data register. USART_ClearFlag(USART_FLAG_TC) is the known remedy.
        """
        for clear_first, heard in ((False, TEXT[1:]), (True, TEXT)):
            cpu, usart, _, far = make_board()
            self.init(usart, 625)
            if clear_first:
                usart.SR = ~TC
            for value in TEXT:
                usart.DR = value
                while not usart.SR & TC:
                    pass
            cpu.wait(100_000)
            assert far.heard == heard

    def test_rs485_driver_enable_after_tc(self, make_board):
        """The line driver is switched off when TC is set: the last stop bit has just ended."""
        cpu, usart, _, far = make_board(baud=115200)
        self.init(usart, 625)
        for value in TEXT[:5]:
            while not usart.SR & TXE:
                pass
            usart.DR = value
        while not usart.SR & TC:
            pass
        assert far.heard == TEXT[:5]
        assert 0 <= cpu.chip.time.now - far.last_end <= 2 * cpu.access_cycles

    def test_a_receive_handler_that_never_reads_sr_hangs_in_an_overrun(self, make_board):
        """DR alone does not clear ORE, and the interrupt of RXNEIE is a level of ORE too."""
        cpu, usart, _, far = make_board(baud=921600)
        heard = bytearray()
        calls = [0]

        def handler():
            calls[0] += 1
            heard.append(usart.DR)

        self.init(usart, 78)
        far.say(b"\x01\x02")
        cpu.wait(3000)  # not enabled yet: the second byte overruns
        usart.CR1 = usart.CR1 | RXNEIE
        cpu.handlers[37] = handler
        cpu.wait(5000)
        assert heard[:1] == b"\x01"
        assert calls[0] > 100
        assert far.usart.read(0) & (ORE | RXNE) == ORE

    def test_dma_enabled_before_the_usart(self, make_board):
        """Example USART/DMA_Polling: DMA and its requests first, USART_Cmd(ENABLE) last, then wait for TC."""
        cpu, usart, dma, far = make_board()
        cpu.chip.bus.load(RAM, TEXT)
        usart.CR2 = 0
        usart.BRR = 625
        usart.CR1 = TE | RE
        dma.CPAR4, dma.CMAR4, dma.CNDTR4, dma.CCR4 = BASE["USART1"] + 4, RAM, len(TEXT), 0x0090
        usart.SR = ~TC
        usart.CR3 = DMAT
        dma.CCR4 = dma.CCR4 | 1
        cpu.wait(1000)
        assert len(TEXT) - 1 == dma.CNDTR4  # one is in the data register
        usart.CR1 = usart.CR1 | UE
        while not dma.ISR & 2 << 12:
            pass
        assert len(far.heard) == len(TEXT) - 1  # TCIF is set when the last byte is in the data register
        cpu.wait_for(lambda: len(far.heard) == len(TEXT))
        while not usart.SR & TC:
            pass
        assert far.heard == TEXT
        assert cpu.chip.time.now >= far.last_end


class Hal:
    """stm32f1xx_hal_uart.c and stm32f1xx_hal_dma.c (V1.1.x), reduced to the accesses."""

    def __init__(self, cpu, usart, dma, name, brr, cr1=0, cr2=0, cr3=0):
        self.cpu, self.usart, self.dma, self.name = cpu, usart, dma, name
        self.tx_channel, self.rx_channel = DMA_CHANNELS[name]
        self.tx_data, self.rx_left = b"", 0
        self.received = bytearray()
        self.errors = 0
        self.events = []
        self.to_idle = 0
        usart.CR1 = usart.CR1 & ~UE
        usart.CR2 = usart.CR2 & ~0x3000 | cr2
        usart.CR1 = usart.CR1 & ~(M | PCE | PS | TE | RE | 0x8000) | TE | RE | cr1
        usart.CR3 = usart.CR3 & ~(RTSE | CTSE) | cr3
        usart.BRR = brr
        usart.CR2 = usart.CR2 & ~0x4800
        usart.CR3 = usart.CR3 & ~0x2A
        usart.CR1 = usart.CR1 | UE
        cpu.handlers[IRQ[name]] = self.irq_handler
        cpu.handlers[10 + self.tx_channel] = self.dma_tx_handler
        cpu.handlers[10 + self.rx_channel] = self.dma_rx_handler

    # --- blocking

    def transmit(self, data):
        for value in data:
            self.wait_flag(TXE)
            self.usart.DR = value
        self.wait_flag(TC)

    def receive(self, count):
        data = bytearray()
        for _ in range(count):
            self.wait_flag(RXNE)
            data.append(self.usart.DR & 0xFF)
        return data

    def wait_flag(self, flag):
        self.cpu.wait_for(lambda: self.usart.SR & flag)

    # --- by interrupt

    def transmit_it(self, data):
        self.tx_data = bytes(data)
        self.usart.CR1 = self.usart.CR1 | TXEIE

    def receive_it(self, count):
        self.rx_left = count
        self.usart.CR1 = self.usart.CR1 | PEIE
        self.usart.CR3 = self.usart.CR3 | EIE
        self.usart.CR1 = self.usart.CR1 | RXNEIE

    def irq_handler(self):
        usart = self.usart
        flags, cr1, cr3 = usart.SR, usart.CR1, usart.CR3
        errors = flags & ERRORS
        if not errors and flags & RXNE and cr1 & RXNEIE:
            self.receive_one()
            return
        if errors and (cr3 & EIE or cr1 & (RXNEIE | PEIE)):
            self.errors |= errors
            if flags & RXNE and cr1 & RXNEIE:
                self.receive_one()
            if errors & ORE or cr3 & DMAR:
                self.end_rx_transfer()
            return
        if self.to_idle and flags & IDLE and cr1 & IDLEIE:
            assert usart.SR is not None  # __HAL_UART_CLEAR_IDLEFLAG
            assert usart.DR is not None
            if cr3 & DMAR:
                left = getattr(self.dma, f"CNDTR{self.rx_channel}")
                if 0 < left < self.to_idle:
                    self.events.append(("idle", self.to_idle - left))
            else:
                usart.CR1 = usart.CR1 & ~(RXNEIE | PEIE | IDLEIE)
                self.events.append(("idle", len(self.received)))
            return
        if flags & TXE and cr1 & TXEIE:
            self.transmit_one()
            return
        if flags & TC and cr1 & TCIE:
            usart.CR1 = usart.CR1 & ~TCIE
            self.events.append(("sent", self.cpu.chip.time.now))

    def receive_one(self):
        self.received.append(self.usart.DR & 0xFF)
        self.rx_left -= 1
        if self.rx_left == 0:
            self.usart.CR1 = self.usart.CR1 & ~RXNEIE
            self.usart.CR1 = self.usart.CR1 & ~PEIE
            self.usart.CR3 = self.usart.CR3 & ~EIE
            self.events.append(("received", bytes(self.received)))

    def end_rx_transfer(self):
        self.usart.CR1 = self.usart.CR1 & ~(RXNEIE | PEIE)
        self.usart.CR3 = self.usart.CR3 & ~EIE
        self.events.append(("error", self.errors))
        if self.usart.CR3 & DMAR:
            self.usart.CR3 = self.usart.CR3 & ~DMAR
            setattr(self.dma, f"CCR{self.rx_channel}", getattr(self.dma, f"CCR{self.rx_channel}") & ~0xF)

    def transmit_one(self):
        self.usart.DR = self.tx_data[0]
        self.tx_data = self.tx_data[1:]
        if not self.tx_data:
            self.usart.CR1 = self.usart.CR1 & ~TXEIE
            self.usart.CR1 = self.usart.CR1 | TCIE

    # --- by DMA

    def start_dma(self, channel, control, count, memory):
        dma = self.dma
        setattr(dma, f"CCR{channel}", control)
        dma.IFCR = 1 << 4 * (channel - 1)
        setattr(dma, f"CNDTR{channel}", count)
        setattr(dma, f"CPAR{channel}", BASE[self.name] + 4)
        setattr(dma, f"CMAR{channel}", memory)
        setattr(dma, f"CCR{channel}", getattr(dma, f"CCR{channel}") | 0xE)
        setattr(dma, f"CCR{channel}", getattr(dma, f"CCR{channel}") | 1)

    def transmit_dma(self, data, memory=RAM):
        self.cpu.chip.bus.load(memory, data)
        self.start_dma(self.tx_channel, 0x0090, len(data), memory)
        self.usart.SR = ~TC
        self.usart.CR3 = self.usart.CR3 | DMAT

    def receive_dma(self, count, memory=RAM + 0x1000, *, circular=False):
        self.start_dma(self.rx_channel, 0x00A0 if circular else 0x0080, count, memory)
        assert self.usart.SR is not None  # __HAL_UART_CLEAR_OREFLAG
        assert self.usart.DR is not None
        self.usart.CR1 = self.usart.CR1 | PEIE
        self.usart.CR3 = self.usart.CR3 | EIE
        self.usart.CR3 = self.usart.CR3 | DMAR

    def receive_to_idle_dma(self, count, memory=RAM + 0x1000, *, circular=False):
        self.to_idle = count
        self.receive_dma(count, memory, circular=circular)
        assert self.usart.SR is not None
        assert self.usart.DR is not None
        self.usart.CR1 = self.usart.CR1 | IDLEIE

    def dma_tx_handler(self):
        if self.dma_handler(self.tx_channel) == "complete":
            self.usart.CR3 = self.usart.CR3 & ~DMAT
            self.usart.CR1 = self.usart.CR1 | TCIE

    def dma_rx_handler(self):
        what = self.dma_handler(self.rx_channel)
        if what:
            self.events.append((what, getattr(self.dma, f"CNDTR{self.rx_channel}")))
            circular = getattr(self.dma, f"CCR{self.rx_channel}") & 0x20
            if what == "complete" and not circular:
                self.usart.CR1 = self.usart.CR1 & ~PEIE
                self.usart.CR3 = self.usart.CR3 & ~EIE
                self.usart.CR3 = self.usart.CR3 & ~DMAR

    def dma_handler(self, channel):
        """HAL_DMA_IRQHandler: half first, then complete, then error."""
        dma, shift = self.dma, 4 * (channel - 1)
        flags = dma.ISR >> shift
        control = getattr(dma, f"CCR{channel}")
        if flags & 4 and control & 4:
            if not control & 0x20:
                setattr(dma, f"CCR{channel}", getattr(dma, f"CCR{channel}") & ~4)
            dma.IFCR = 4 << shift
            return "half"
        if flags & 2 and control & 2:
            if not control & 0x20:
                setattr(dma, f"CCR{channel}", getattr(dma, f"CCR{channel}") & ~0xA)
            dma.IFCR = 2 << shift
            return "complete"
        return None


@pytest.fixture
def make_hal(make_board):
    def make(name="USART1", brr=625, line_format="8N1", **how):
        divider = 1 if name == "USART1" else 2
        cpu, usart, dma, far = make_board(name, 72_000_000 // divider // brr, line_format)
        return Hal(cpu, usart, dma, name, brr, **how), cpu, far

    return make


class TestHal:
    @pytest.mark.parametrize(
        ("line_format", "cr1", "cr2"), [("8N1", 0, 0), ("8E1", M | PCE, 0), ("7O1", PCE | PS, 0), ("8N2", 0, 0x2000)]
    )
    def test_blocking(self, make_hal, line_format, cr1, cr2):
        hal, cpu, far = make_hal(line_format=line_format, cr1=cr1, cr2=cr2)
        hal.transmit(TEXT)
        assert far.heard == TEXT
        assert 0 <= cpu.chip.time.now - far.last_end < 30
        far.say(TEXT[:10])
        data = bytes(value & (0x7F if line_format[0] == "7" else 0xFF) for value in hal.receive(10))
        assert data == TEXT[:10]

    @pytest.mark.parametrize(("name", "brr"), matrix(NAMES, [1250, 312, 78]))
    def test_by_interrupt_both_ways(self, make_hal, name, brr):
        hal, cpu, far = make_hal(name, brr)
        hal.receive_it(len(TEXT))
        cpu.wait(brr * 20)
        far.say(TEXT)
        hal.transmit_it(TEXT)
        cpu.wait_for(lambda: len(hal.events) == 2)
        assert far.heard == TEXT
        assert ("received", TEXT) in hal.events
        (sent,) = [at for what, at in hal.events if what == "sent"]
        assert 0 <= sent - far.last_end < 300
        assert hal.errors == 0

    def test_errors_by_interrupt(self, make_hal):
        hal, cpu, far = make_hal(cr1=M | PCE, line_format="8O1")
        hal.receive_it(5)
        far.say(b"\x01")
        cpu.wait(20_000)
        assert hal.errors == PE
        assert hal.received == b"\x01"

    def test_an_overrun_while_nobody_receives(self, make_hal):
        """The next HAL_UART_Receive_IT finds ORE: an error callback, then it works again."""
        hal, cpu, far = make_hal()
        far.say(b"ab")
        cpu.wait(30_000)
        hal.receive_it(3)
        cpu.wait(1000)
        assert hal.events == [("error", ORE)]
        assert hal.received == b"a"
        hal.received.clear()
        hal.receive_it(3)
        far.say(b"cde")
        cpu.wait_for(lambda: len(hal.events) == 2)
        assert hal.events[1] == ("received", b"cde")

    @pytest.mark.parametrize(("name", "brr"), matrix(NAMES, [625, 78, 16]))
    def test_dma_both_ways(self, make_hal, name, brr):
        hal, cpu, far = make_hal(name, brr)
        hal.receive_dma(len(TEXT))
        cpu.wait(brr * 30)
        far.say(TEXT)
        hal.transmit_dma(TEXT)
        cpu.wait_for(lambda: len(hal.events) == 3)
        assert far.heard == TEXT
        assert cpu.chip.bus.dump(RAM + 0x1000, len(TEXT)) == TEXT
        half, complete = (event for event in hal.events if event[0] != "sent")
        assert half[0] == "half"
        assert half[1] <= len(TEXT) - len(TEXT) // 2
        assert complete == ("complete", 0)
        assert hal.errors == 0

    def test_dma_sends_without_gaps(self, make_hal):
        hal, cpu, far = make_hal(brr=78)
        cpu.wait(5000)
        start = cpu.chip.time.now
        hal.transmit_dma(TEXT)
        cpu.wait_for(lambda: hal.events)
        assert far.last_end - start - len(TEXT) * 780 < 200

    def test_reception_to_idle_by_dma_in_a_ring(self, make_hal):
        hal, cpu, far = make_hal()
        hal.receive_to_idle_dma(16, circular=True)
        for message in (b"hello", b"wo", b"rld", b"again!"):
            cpu.wait(far.say(message) - cpu.chip.time.now + 11 * 625)
        assert hal.events == [
            ("idle", 5),
            ("idle", 7),
            ("half", 8),
            ("idle", 10),
            ("complete", 16),
        ]
        assert cpu.chip.bus.dump(RAM + 0x1000, 16) == b"helloworldagain!"

    def test_one_idle_event_a_message_whatever_the_pauses(self, make_hal):
        hal, cpu, far = make_hal()
        hal.receive_to_idle_dma(64)
        far.say(b"with pauses", pause_bits=9)
        cpu.wait(625 * 300)
        assert hal.events == [("idle", 11)]

    def test_reception_to_idle_by_interrupt(self, make_hal):
        hal, cpu, far = make_hal()
        hal.to_idle = 64
        hal.receive_it(64)
        assert hal.usart.SR is not None
        assert hal.usart.DR is not None
        hal.usart.CR1 = hal.usart.CR1 | IDLEIE
        far.say(b"hello")
        cpu.wait_for(lambda: hal.events)
        assert hal.events == [("idle", 5)]
        assert hal.received == b"hello"

    def test_a_break_stops_reception_by_dma(self, make_hal):
        """FE with EIE and DMAR: HAL aborts the transfer; a driver that restarts it goes on."""
        hal, cpu, far = make_hal()
        hal.receive_dma(8)
        far.say(b"ab")
        cpu.wait(625 * 30)
        far.format = type(far.format)(data_bits=9)
        far.say(b"\0\0"[:1])
        cpu.wait(625 * 12)
        assert hal.events == [("error", FE)]
        far.format = type(far.format)()
        hal.receive_dma(8)
        far.say(b"cd")
        cpu.wait(625 * 30)
        assert hal.events == [("error", FE)]
        assert cpu.chip.bus.dump(RAM + 0x1000, 2) == b"cd"

    def test_lin_break_and_half_duplex_switch(self, make_hal):
        """HAL_HalfDuplex_Init and EnableTransmitter / EnableReceiver: TE and RE are never on together."""
        hal, cpu, far = make_hal()
        hal.usart.CR3 = hal.usart.CR3 | HDSEL
        hal.usart.CR1 = hal.usart.CR1 & ~(TE | RE) | TE
        hal.transmit(b"ask")
        hal.usart.CR1 = hal.usart.CR1 & ~(TE | RE) | RE
        far.say(b"answer", after_bits=3)
        assert hal.receive(6) == b"answer"
        assert far.heard == b"ask"
        hal.usart.CR1 = hal.usart.CR1 | SBK
        hal.usart.CR1 = hal.usart.CR1 & ~(TE | RE) | TE | SBK
        cpu.wait(625 * 40)
        assert far.breaks == 1


class TestArduinoCore:
    """stm32duino HardwareSerial: one byte at a time through HAL_UART_Receive_IT and a ring for Transmit_IT."""

    @each("brr", [1250, 156])
    def test_echo_of_a_sketch(self, make_hal, brr):
        hal, cpu, far = make_hal(brr=brr)
        ring = bytearray()

        def after_event():
            # HAL_UART_RxCpltCallback: take the byte, start the next reception at once
            for what, value in hal.events:
                if what == "received":
                    ring.extend(value)
            hal.events.clear()
            hal.received.clear()
            if not hal.rx_left:
                hal.receive_it(1)
            if ring and not hal.tx_data and not hal.usart.CR1 & (TXEIE | TCIE):
                sending, ring[:] = bytes(ring[:1]), ring[1:]
                hal.transmit_it(sending)

        def handler():
            hal.irq_handler()
            after_event()

        cpu.handlers[37] = handler
        hal.receive_it(1)
        cpu.wait(brr * 12)
        far.say(TEXT, pause_bits=2)
        cpu.wait_for(lambda: len(far.heard) == len(TEXT))
        assert far.heard == TEXT
        assert hal.errors == 0


class TestChibiOS:
    """os/hal/ports/STM32/LLD/USARTv1: hal_serial_lld.c (usart_init, serve_interrupt) and hal_uart_lld.c."""

    def start(self, usart, brr):
        usart.BRR = brr
        usart.CR2 = usart.CR2 & ~0x3000 | 0x40
        usart.CR3 = EIE
        usart.CR1 = UE | PEIE | RXNEIE | TE | RE
        usart.SR = 0
        assert usart.SR is not None
        assert usart.DR is not None

    def serve_interrupt(self, usart, incoming, outgoing, events):
        cr1, flags = usart.CR1, usart.SR
        if flags & ERRORS:
            events.append(flags & ERRORS)
        if flags & LBD:
            events.append("break")
            usart.SR = ~LBD
        while flags & (RXNE | ERRORS):
            value = usart.DR
            if flags & RXNE:
                incoming.append(value & 0xFF)
            flags = usart.SR
        if cr1 & TXEIE and flags & TXE:
            if outgoing:
                usart.DR = outgoing.pop(0)
            else:
                usart.CR1 = cr1 & ~TXEIE | TCIE
        if cr1 & TCIE and flags & TC:
            events.append("transmission end")
            usart.CR1 = cr1 & ~TCIE
            usart.SR = ~TC

    def test_serial_driver(self, make_board):
        cpu, usart, _, far = make_board("USART2", 36_000_000 // 312)
        incoming, outgoing, events = bytearray(), bytearray(), []
        self.start(usart, 312)
        cpu.handlers[38] = lambda: self.serve_interrupt(usart, incoming, outgoing, events)
        cpu.wait(10_000)
        far.say(TEXT)
        outgoing.extend(TEXT)
        usart.CR1 = usart.CR1 | TXEIE
        cpu.wait_for(lambda: "transmission end" in events)
        cpu.wait_for(lambda: len(incoming) == len(TEXT))
        assert far.heard == incoming == TEXT
        assert events == ["transmission end"]

    def test_errors_are_reported_and_reception_goes_on(self, make_board):
        cpu, usart, _, far = make_board("USART1", 115200)
        incoming, events = bytearray(), []
        self.start(usart, 625)
        cpu.handlers[37] = lambda: self.serve_interrupt(usart, incoming, bytearray(), events)
        far.format = type(far.format)(data_bits=9)
        far.say(b"\x55")
        cpu.wait(625 * 12)
        far.format = type(far.format)()
        far.say(b"ok")
        cpu.wait(625 * 25)
        assert events == [FE]
        assert incoming == b"\x55ok"

    def test_uart_driver_by_dma(self, make_board):
        """hal_uart_lld.c: an idle DMA channel eats what comes in between receptions, one byte, circular."""
        cpu, usart, dma, far = make_board("USART1", 115200)
        usart.BRR = 625
        usart.CR2 = 0x40
        usart.CR3 = EIE | DMAT | DMAR
        dma.CPAR5, dma.CMAR5, dma.CNDTR5 = BASE["USART1"] + 4, RAM + 0x100, 1
        dma.CCR5 = 0x0020 | 0x2 | 1
        usart.CR1 = UE | PEIE | TE | RE
        usart.SR = 0
        assert usart.SR is not None
        assert usart.DR is not None
        idle_chars = []

        def eaten():
            dma.IFCR = 0xF << 16
            idle_chars.extend(cpu.chip.bus.dump(RAM + 0x100, 1))

        cpu.handlers[15] = eaten
        far.say(b"noise")
        cpu.wait(625 * 60)
        assert bytes(idle_chars) == b"noise"
        dma.CCR5 = 0
        dma.IFCR = 0xF << 16
        dma.CMAR5, dma.CNDTR5 = RAM + 0x200, 4
        dma.CCR5 = 0x80 | 1
        far.say(b"data")
        cpu.wait(625 * 50)
        assert cpu.chip.bus.dump(RAM + 0x200, 4) == b"data"
        assert dma.CNDTR5 == 0
        assert not usart.SR & ERRORS
