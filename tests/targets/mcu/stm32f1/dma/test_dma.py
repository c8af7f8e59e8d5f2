"""The DMA controller against its register description and against a naive model of it."""

from __future__ import annotations

import pytest
from hypothesis import Phase, given, settings
from hypothesis import strategies as st

from targets.mcu.errors import BusFault
from tests.share import examples

RAM, PORT, NOWHERE = 0x2000_0000, 0x4001_0000, 0x6000_0000
EN, TCIE, HTIE, TEIE, DIR, CIRC, PINC, MINC, MEM2MEM = (1 << bit for bit in (0, 1, 2, 3, 4, 5, 6, 7, 14))
GIF, TCIF, HTIF, TEIF = 1, 2, 4, 8
TRANSFER = 5

# RM0008 table 78
TABLE = {
    1: "ADC1 TIM2_CH3 TIM4_CH1",
    2: "SPI1_RX USART3_TX TIM1_CH1 TIM2_UP TIM3_CH3",
    3: "SPI1_TX USART3_RX TIM1_CH2 TIM3_CH4 TIM3_UP",
    4: "SPI2_RX USART1_TX I2C2_TX TIM1_CH4 TIM1_TRIG TIM1_COM TIM4_CH2",
    5: "SPI2_TX USART1_RX I2C2_RX TIM1_UP TIM2_CH1 TIM4_CH3",
    6: "USART2_RX I2C1_TX TIM1_CH3 TIM3_CH1 TIM3_TRIG",
    7: "USART2_TX I2C1_RX TIM2_CH2 TIM2_CH4 TIM4_UP",
}


def sizes(psize, msize):
    return psize << 8 | msize << 10


class TestRegisters:
    def test_reset_values(self, rig):
        assert all(rig.dma.read(offset) == 0 for offset in rig.dma.registers)

    @pytest.mark.parametrize("number", range(1, 8))
    def test_places_and_reserved_bits(self, rig, number):
        """RM0008 section 13.4.7, DMA register map."""
        base = 0x08 + 20 * (number - 1)
        for offset, mask in ((base + 4, 0xFFFF), (base + 8, 0xFFFF_FFFF), (base + 12, 0xFFFF_FFFF), (base, 0x7FFE)):
            rig.dma.write(offset, 0xFFFF_FFFE)
            assert rig.dma.read(offset) == 0xFFFF_FFFE & mask

    def test_reset_from_anywhere(self, rig):
        rig.fill(RAM, 8)
        for number in range(1, 8):
            rig.channel(number, MEM2MEM | EN | TCIE | MINC, 2, PORT, RAM + 0x100)
        rig.chip.advance(60)
        assert rig.irq(1).level
        rig.dma.reset()
        assert all(rig.dma.read(offset) == 0 for offset in rig.dma.registers)
        assert not any(rig.irq(number).level for number in range(1, 8))
        done = len(rig.bus.accesses)
        rig.chip.advance(1000)
        assert len(rig.bus.accesses) == done

    @pytest.mark.parametrize("name", ["CNDTR", "CPAR", "CMAR"])
    def test_write_protected_while_enabled(self, rig, name):
        rig.channel(3, EN, 7)
        before = rig.peek(f"{name}3")
        rig.poke(f"{name}3", 0x1234)
        assert rig.peek(f"{name}3") == before
        assert rig.chip.noted("misuse") == [f"DMA1_{name}3"]
        rig.poke("CCR3", 0)
        rig.poke(f"{name}3", 0x1234)
        assert rig.peek(f"{name}3") == 0x1234

    @given(number=st.integers(1, 7), flags=st.sampled_from(range(0, 16, 2)), cleared=st.integers(0, 15))
    def test_flags_are_cleared_by_ifcr(self, make_rig, number, flags, cleared):
        rig = make_rig()
        rig.dma[0x00] = 0x0111_1111 * flags
        rig.poke("IFCR", cleared << 4 * (number - 1))
        assert rig.peek("IFCR") == 0
        left = 0 if cleared & GIF else flags & ~cleared
        for other in range(1, 8):
            expected = left if other == number else flags
            assert rig.flags(other) == (expected | GIF if expected else 0)

    @given(flags=st.sampled_from(range(0, 16, 2)), enables=st.integers(0, 7))
    def test_interrupts_are_levels(self, make_rig, flags, enables):
        rig = make_rig()
        rig.dma[0x00] = flags << 4
        rig.poke("CCR2", enables << 1)
        assert rig.irq(2).level is bool(flags & enables << 1)
        rig.poke("CCR2", 0)
        assert not rig.irq(2).level


class TestRequests:
    @pytest.mark.parametrize(("number", "name"), [(n, name) for n, names in TABLE.items() for name in names.split()])
    def test_each_asks_its_channel(self, rig, number, name):
        for other in range(1, 8):
            rig.channel(other, EN, 100)
        rig.dma.request(name).set(True)
        rig.chip.advance(TRANSFER)
        assert [n for n in range(1, 8) if rig.peek(f"CNDTR{n}") == 99] == [number]

    def test_those_that_are_not_connected_go_nowhere(self, rig):
        rig.channel(7, EN, 1)
        rig.dma.request("TIM2_TRIG").set(True)
        rig.dma.request("TIM2_TRIG").pulse()
        rig.chip.advance(100)
        assert rig.peek("CNDTR7") == 1

    def test_a_level_is_served_while_it_lasts(self, rig):
        request = rig.dma.request("USART1_TX")
        rig.channel(4, EN | MINC, 10)
        request.set(True)
        rig.chip.advance(3 * TRANSFER)
        request.set(False)
        rig.chip.advance(100)
        assert rig.peek("CNDTR4") == 7

    def test_a_pulse_is_served_once_also_later(self, rig):
        request = rig.dma.request("TIM2_UP")
        request.pulse()
        request.pulse()
        rig.chip.advance(100)
        rig.channel(2, EN | MINC, 10)
        rig.chip.advance(100)
        assert rig.peek("CNDTR2") == 9
        request.pulse()
        request.set(False)
        rig.chip.advance(100)
        assert rig.peek("CNDTR2") == 9

    def test_requests_of_a_channel_are_ored(self, rig):
        rig.channel(1, EN, 10)
        rig.dma.request("ADC1").set(True)
        rig.dma.request("TIM2_CH3").set(True)
        rig.dma.request("ADC1").set(False)
        rig.chip.advance(2 * TRANSFER)
        assert rig.peek("CNDTR1") == 8

    def test_nothing_without_a_clock(self, rig):
        rig.channel(1, EN, 10)
        rig.dma.clocked = False
        rig.dma.request("ADC1").set(True)
        rig.chip.advance(100)
        assert rig.peek("CNDTR1") == 10
        rig.dma.clocked = True
        rig.dma.request("ADC1").set(False)
        rig.dma.request("ADC1").set(True)
        rig.chip.advance(TRANSFER)
        rig.dma.clocked = False
        rig.chip.advance(100)
        assert rig.peek("CNDTR1") == 9

    def test_no_count_no_transfer(self, rig):
        rig.channel(1, EN, 0)
        rig.dma.request("ADC1").set(True)
        rig.chip.advance(100)
        assert not rig.bus.accesses
        assert rig.flags(1) == 0


class TestTransfers:
    @pytest.mark.parametrize(
        ("psize", "msize", "written"),
        # RM0008 table 77, programmable data width and endian behaviour: source port to destination, 4 items
        [
            (0, 0, "B0 B1 B2 B3"),
            (0, 1, "00B0 00B1 00B2 00B3"),
            (0, 2, "000000B0 000000B1 000000B2 000000B3"),
            (1, 0, "B0 B2 B4 B6"),
            (1, 1, "B1B0 B3B2 B5B4 B7B6"),
            (1, 2, "0000B1B0 0000B3B2 0000B5B4 0000B7B6"),
            (2, 0, "B0 B4 B8 BC"),
            (2, 1, "B1B0 B5B4 B9B8 BDBC"),
            (2, 2, "B3B2B1B0 B7B6B5B4 BBBAB9B8 BFBEBDBC"),
        ],
    )
    @pytest.mark.parametrize("direction", [0, DIR])
    def test_widths(self, rig, psize, msize, written, direction):
        rig.bus.load(PORT, bytes(range(0xB0, 0xC0)))
        source, target = (PORT, RAM) if not direction else (RAM, PORT)
        if direction:
            psize, msize = msize, psize
            rig.bus.load(RAM, bytes(range(0xB0, 0xC0)))
        rig.channel(1, MEM2MEM | PINC | MINC | direction | sizes(psize, msize) | EN, 4)
        rig.chip.advance(4 * TRANSFER)
        reads = [access for access in rig.bus.accesses if access[0] == "read"]
        writes = [access for access in rig.bus.accesses if access[0] == "write"]
        source_size, target_size = (1 << psize, 1 << msize) if not direction else (1 << msize, 1 << psize)
        assert [access[1:3] for access in reads] == [(source + n * source_size, source_size) for n in range(4)]
        assert [access[1:3] for access in writes] == [(target + n * target_size, target_size) for n in range(4)]
        assert " ".join(f"{access[3]:0{2 * target_size}X}" for access in writes) == written

    def test_each_takes_five_cycles(self, rig):
        data = rig.fill(PORT, 4)
        rig.channel(1, MEM2MEM | PINC | MINC | EN, 4)
        for count in range(1, 5):
            rig.chip.advance(TRANSFER - 1)
            assert rig.peek("CNDTR1") == 5 - count
            rig.chip.advance(1)
            assert rig.peek("CNDTR1") == 4 - count
            assert rig.bus.dump(RAM, 4) == data[:count] + bytes(4 - count)

    def test_half_and_complete(self, rig):
        rig.channel(1, MEM2MEM | MINC | EN | HTIE, 6)
        seen = []
        for _ in range(8):
            rig.chip.advance(TRANSFER)
            seen.append((rig.flags(1), rig.irq(1).level))
        half, complete = (GIF | HTIF, True), (GIF | HTIF | TCIF, True)
        assert seen == [(0, False)] * 2 + [half] * 3 + [complete] * 3
        assert rig.peek("CCR1") & EN  # it stays enabled, with nothing to do
        assert rig.peek("CNDTR1") == 0

    @pytest.mark.parametrize(("count", "half_after"), [(1, 1), (2, 1), (3, 2), (5, 3), (8, 4)])
    def test_half_of_an_odd_number(self, rig, count, half_after):
        rig.channel(1, MEM2MEM | MINC | EN, count)
        rig.chip.advance(half_after * TRANSFER - 1)
        assert not rig.flags(1) & HTIF
        rig.chip.advance(1)
        assert rig.flags(1) & HTIF

    def test_circular(self, rig):
        request = rig.dma.request("ADC1")
        rig.channel(1, CIRC | MINC | EN, 4)
        found = []
        for value in range(1, 11):
            rig.bus.load(PORT, bytes([value]))
            request.pulse()
            rig.chip.advance(20)
            found.append((rig.peek("CNDTR1"), rig.flags(1)))
            rig.poke("IFCR", 0xF)
        assert rig.bus.dump(RAM, 4) == bytes([9, 10, 7, 8])
        half, complete = GIF | HTIF, GIF | TCIF
        assert found == [(3, 0), (2, half), (1, 0), (4, complete)] * 2 + [(3, 0), (2, half)]

    def test_again_after_it_was_disabled(self, rig):
        data = rig.fill(PORT, 4)
        rig.channel(1, MEM2MEM | PINC | MINC | EN, 4)
        rig.chip.advance(50)
        rig.poke("CCR1", 0)
        rig.bus.load(RAM, bytes(4))
        rig.poke("CCR1", MEM2MEM | PINC | MINC | EN)
        rig.chip.advance(50)
        assert rig.bus.dump(RAM, 4) == bytes(4)  # CNDTR is 0
        rig.poke("CCR1", 0)
        rig.poke("CNDTR1", 3)
        rig.poke("CCR1", MEM2MEM | PINC | MINC | EN)
        rig.chip.advance(50)
        assert rig.bus.dump(RAM, 4) == data[:3] + bytes(1)

    def test_disabled_in_mid_transfer_nothing_is_lost(self, rig):
        request = rig.dma.request("ADC1")
        rig.channel(1, MINC | EN, 4)
        request.set(True)
        rig.chip.advance(TRANSFER - 1)
        rig.poke("CCR1", MINC)
        rig.chip.advance(50)
        assert not rig.bus.accesses
        assert rig.peek("CNDTR1") == 4

    @pytest.mark.parametrize(("peripheral", "memory"), [(NOWHERE, RAM), (PORT, NOWHERE)])
    def test_a_bus_error_disables_the_channel(self, rig, peripheral, memory):
        rig.channel(1, MEM2MEM | EN | TEIE, 4, peripheral, memory)
        rig.channel(2, MEM2MEM | EN, 4, PORT, RAM)
        rig.chip.advance(100)
        assert rig.flags(1) == GIF | TEIF
        assert rig.peek("CCR1") == MEM2MEM | TEIE
        assert rig.peek("CNDTR1") == 4
        assert rig.irq(1).level
        assert rig.flags(2) & TCIF
        with pytest.raises(BusFault):
            rig.bus.read(NOWHERE, 4)

    def test_addresses_are_aligned(self, rig):
        rig.bus.load(PORT, bytes(range(0xB0, 0xB8)))
        rig.channel(1, MEM2MEM | PINC | MINC | sizes(2, 1) | EN, 2, PORT + 3, RAM + 1)
        rig.chip.advance(50)
        assert rig.bus.dump(RAM, 4) == bytes((0xB0, 0xB1, 0xB4, 0xB5))
        assert rig.chip.noted("misuse") == ["DMA1_CPAR1", "DMA1_CMAR1"]

    def test_memory_to_memory_does_not_go_round(self, rig):
        rig.channel(1, MEM2MEM | CIRC | MINC | EN, 4)
        rig.chip.advance(100)
        assert rig.peek("CNDTR1") == 0
        assert rig.chip.noted("misuse") == ["DMA1_CCR1"]

    def test_priorities(self, rig):
        order = []
        rig.bus.load(RAM, bytes(16))
        for number, level in ((2, 0), (3, 3), (5, 3), (6, 1)):
            rig.poke(f"CCR{number}", MEM2MEM | level << 12)
            rig.poke(f"CNDTR{number}", 2)
            rig.poke(f"CPAR{number}", PORT)
            rig.poke(f"CMAR{number}", RAM + number)
        for number in (2, 6, 5, 3):
            rig.poke(f"CCR{number}", rig.peek(f"CCR{number}") | EN)
        rig.chip.advance(8 * TRANSFER)
        order = [address - RAM for kind, address, _, _ in rig.bus.accesses if kind == "write"]
        assert order == [3, 3, 5, 5, 6, 6, 2, 2]

    def test_who_comes_during_a_transfer_waits(self, rig):
        rig.channel(7, EN, 3, PORT, RAM + 7)
        rig.channel(1, 3 << 12 | EN, 3, PORT, RAM + 1)
        rig.dma.request("USART2_TX").set(True)
        rig.chip.advance(1)
        rig.dma.request("ADC1").set(True)
        rig.chip.advance(5 * TRANSFER - 1)
        order = [address - RAM for kind, address, _, _ in rig.bus.accesses if kind == "write"]
        assert order == [7, 1, 1, 1, 7]


class NaiveDma:
    """The oracle: it looks at everything at every cycle."""

    def __init__(self, memory):
        self.memory = memory
        self.channels = {}
        self.busy_since = None
        self.asking_since = {}
        self.flags = dict.fromkeys(range(1, 8), 0)
        self.log = []

    def wants(self, number, requests):
        one = self.channels.get(number)
        if one is None or not one["on"] or not one["left"]:
            return False
        return one["control"] & MEM2MEM or requests.get(number)

    def finish(self, now, pulses):
        if self.busy_since is not None and now == self.busy_since + TRANSFER:
            asking = [n for n, since in self.asking_since.items() if since <= self.busy_since]
            self.busy_since = None
            if asking:
                best = max(asking, key=lambda n: (self.channels[n]["control"] >> 12 & 3, -n))
                pulses.discard(best)
                del self.asking_since[best]
                self.serve(now, best)

    def look(self, now, requests, pulses):
        for number in range(1, 8):
            if not (self.wants(number, requests) or (number in pulses and self.wants(number, {number: True}))):
                self.asking_since.pop(number, None)
            else:
                self.asking_since.setdefault(number, now)
        if self.busy_since is None and self.asking_since:
            self.busy_since = now

    def serve(self, now, number):
        one = self.channels[number]
        control = one["control"]
        width = {"p": 1 << min(control >> 8 & 3, 2), "m": 1 << min(control >> 10 & 3, 2)}
        source, target = ("m", "p") if control & DIR else ("p", "m")
        data = self.copy(one[source], width[source])
        data = (data + bytes(4))[: width[target]]
        for index, byte in enumerate(data):
            self.memory[one[target] // width[target] * width[target] + index] = byte
        self.log.append((now, number))
        one["p"] += width["p"] if control & PINC else 0
        one["m"] += width["m"] if control & MINC else 0
        one["left"] -= 1
        if one["left"] == one["count"] // 2:
            self.flags[number] |= HTIF
        if one["left"] == 0:
            self.flags[number] |= TCIF
            if control & CIRC and not control & MEM2MEM:
                one.update(left=one["count"], p=one["p0"], m=one["m0"])

    def copy(self, address, width):
        address = address // width * width
        return bytes(self.memory[address + n] for n in range(width))


CHANNEL = st.fixed_dictionaries(
    {
        "control": st.integers(0, 0x7FFF).map(lambda word: word & ~EN & ~0xE),
        "count": st.integers(0, 9),
        "peripheral": st.integers(0, 40),
        "memory": st.integers(0, 200),
        "on": st.integers(0, 60),
        "pulses": st.lists(st.integers(0, 250), max_size=8),
        "level": st.tuples(st.integers(0, 150), st.integers(0, 100)),
    }
)


@settings(max_examples=examples(200), phases=(Phase.generate,))
@given(setup=st.dictionaries(st.integers(1, 7), CHANNEL, min_size=1, max_size=4))
def test_random_configurations(make_rig, setup):
    rig = make_rig()
    rig.fill(RAM, 0x180)
    rig.fill(PORT, 0x60)
    naive = NaiveDma(dict(rig.bus.memory))
    requests, pulses = {}, set()
    lines = {number: rig.dma.request(TABLE[number].split()[0]) for number in setup}
    timed = {number: rig.dma.request(TABLE[number].split()[-1]) for number in setup}
    log = []
    for now in range(300):
        before = len(rig.bus.accesses)
        counts = {number: rig.peek(f"CNDTR{number}") for number in setup}
        rig.chip.advance_to(now)
        naive.finish(now, pulses)
        if len(rig.bus.accesses) != before:
            log += [(now, number) for number in setup if rig.peek(f"CNDTR{number}") != counts[number]]
        # The order in which one cycle's changes come must not matter.
        for number, one in sorted(setup.items(), reverse=now % 2 == 0):
            if now == one["on"]:
                rig.channel(number, one["control"] | EN, one["count"], PORT + one["peripheral"], RAM + one["memory"])
                naive.channels[number] = {
                    "control": one["control"],
                    "on": True,
                    "count": one["count"],
                    "left": one["count"],
                    "p": PORT + one["peripheral"],
                    "p0": PORT + one["peripheral"],
                    "m": RAM + one["memory"],
                    "m0": RAM + one["memory"],
                }
            if now in one["pulses"]:
                timed[number].pulse()
                pulses.add(number)
            start, length = one["level"]
            level = start <= now < start + length
            if level != requests.get(number, False):
                requests[number] = level
                lines[number].set(level)
        naive.look(now, requests, pulses)
    assert {number: rig.flags(number) & ~GIF for number in range(1, 8)} == naive.flags
    assert {number: rig.peek(f"CNDTR{number}") for number in setup} == {n: naive.channels[n]["left"] for n in setup}
    assert rig.bus.memory == naive.memory
    # the count of a circular channel of one item does not show a transfer
    assert [entry for entry in naive.log if setup[entry[1]]["count"] > 1] == [
        entry for entry in log if setup[entry[1]]["count"] > 1
    ]
