"""What the streams move, when, and in which order (RM0410 section 8.3)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

RAM, PORT, NOWHERE = 0x2000_0000, 0x4001_0000, 0x6000_0000
EN, DMEIE, TEIE, HTIE, TCIE, PFCTRL = (1 << bit for bit in range(6))
P2M, M2P, M2M = 0, 1 << 6, 2 << 6
CIRC, PINC, MINC = 1 << 8, 1 << 9, 1 << 10
PINCOS, DBM, CT = 1 << 15, 1 << 18, 1 << 19
PERIPHERAL, MEMORY = 5, 4
DIRECT, FIFO = 0x21, 0x24


def sizes(psize, msize):
    return psize << 11 | msize << 13


def bursts(pburst, mburst):
    return pburst << 21 | mburst << 23


def allowed(msize, mburst, threshold):
    """RM0410 table 30, FIFO threshold configurations."""
    if mburst == 0:
        return True
    table = {
        (0, 0): {1},
        (0, 1): {1, 2},
        (0, 2): {1},
        (0, 3): {1, 2, 3},
        (1, 1): {1},
        (1, 3): {1, 2},
        (2, 3): {1},
    }
    return mburst in table.get((msize, threshold), set())


class TestDirectMode:
    def test_from_a_peripheral(self, rig):
        rig.stream(0, EN | MINC, 3)
        rig.bus.load(PORT, b"\x5a")
        rig.line(0).pulse()
        rig.chip.advance(PERIPHERAL - 1)
        assert rig.peek("S0NDTR") == 3
        rig.chip.advance(1)
        assert rig.peek("S0NDTR") == 2
        rig.chip.advance(MEMORY - 1)
        assert rig.bus.dump(RAM, 1) == b"\0"
        rig.chip.advance(1)
        assert rig.bus.dump(RAM, 1) == b"\x5a"

    def test_to_a_peripheral_one_item_is_there_before_it_is_asked_for(self, rig):
        data = rig.fill(RAM, 3)
        rig.stream(0, EN | MINC | M2P, 3)
        rig.chip.advance(100)
        assert rig.accesses("read") == [RAM]
        rig.line(0).pulse()
        rig.chip.advance(PERIPHERAL)
        assert rig.bus.dump(PORT, 1) == data[:1]
        assert rig.peek("S0NDTR") == 2
        rig.chip.advance(MEMORY)
        assert rig.accesses("read") == [RAM, RAM + 1]

    @pytest.mark.parametrize("direction", [P2M, M2P])
    @pytest.mark.parametrize("size", [0, 1, 2])
    def test_widths_and_increments(self, rig, direction, size):
        width = 1 << size
        source, target = (PORT, RAM) if direction is P2M else (RAM, PORT)
        data = rig.fill(source, 4 * width)
        rig.stream(0, EN | direction | PINC | MINC | sizes(size, 0), 4)
        rig.serve(0, 4)
        assert rig.bus.dump(target, 4 * width) == data
        assert {access[2] for access in rig.bus.accesses if access[0] in ("read", "write")} == {width}
        assert rig.flags(0) == {"HT", "TC"}
        assert not rig.peek("S0CR") & EN

    def test_peripheral_increment_of_a_word(self, rig):
        rig.bus.load(PORT, bytes(range(16)))
        rig.stream(0, EN | PINC | MINC | PINCOS, 4)
        rig.serve(0, 4)
        assert rig.bus.dump(RAM, 4) == bytes([0, 4, 8, 12])

    def test_data_that_is_overwritten(self, rig):
        """DMEIF: an item came before the last one was stored, and the memory address does not move."""
        rig.stream(0, EN | DMEIE, 10)
        rig.stream(7, EN | 3 << 16 | M2M | PINC | MINC | sizes(2, 0), 64, PORT + 0x100, RAM + 0x100, fcr=FIFO | 3)
        rig.line(0).set(True)
        rig.chip.advance(200)
        assert "DME" in rig.flags(0)
        assert rig.irq(0).level
        assert rig.peek("S0CR") & EN or rig.peek("S0NDTR") == 0


class TestAnySetting:
    """However it is set, what arrives is what was there."""

    @given(
        direction=st.sampled_from([P2M, M2P, M2M]),
        psize=st.integers(0, 2),
        msize=st.integers(0, 2),
        pburst=st.integers(0, 3),
        mburst=st.integers(0, 3),
        threshold=st.integers(0, 3),
        words=st.integers(1, 20),
    )
    def test_fifo_mode(self, make_rig, direction, psize, msize, pburst, mburst, threshold, words):
        rig = make_rig()
        source, target = (RAM, PORT) if direction is M2P else (PORT, RAM)
        data = rig.fill(source, 4 * words)
        control = direction | PINC | MINC | sizes(psize, msize) | bursts(pburst, mburst)
        items = 4 * words >> psize
        rig.stream(1, EN | control, items, fcr=FIFO | threshold)
        if not allowed(msize, mburst, threshold) or (1, 4, 8, 16)[pburst] << psize > 16:
            assert rig.flags(1) == {"FE"}
            assert not rig.peek("S1CR") & EN
            return
        if direction is not M2M:
            rig.serve(1, items)
        rig.chip.advance(1000)
        assert rig.bus.dump(target, 4 * words) == data
        assert rig.peek("S1NDTR") == 0
        assert rig.flags(1) == {"HT", "TC"}
        assert not rig.peek("S1CR") & EN
        kinds = {"read": psize, "write": msize} if direction is not M2P else {"read": msize, "write": psize}
        assert {(kind, size) for kind, _, size, _ in rig.bus.accesses} <= {
            (kind, 1 << size) for kind, size in kinds.items()
        }

    @given(psize=st.integers(0, 2), msize=st.integers(0, 2), items=st.integers(1, 30))
    def test_odd_ends(self, make_rig, psize, msize, items):
        rig = make_rig()
        data = rig.fill(PORT, items << psize)
        rig.stream(1, EN | PINC | MINC | sizes(psize, msize), items, fcr=FIFO | 1)
        rig.serve(1, items)
        whole = -(-len(data) // (1 << msize)) * (1 << msize)
        assert rig.bus.dump(RAM, whole) == data + bytes(whole - len(data))

    @given(psize=st.integers(0, 2), msize=st.integers(0, 2), items=st.integers(1, 30))
    def test_odd_ends_the_other_way(self, make_rig, psize, msize, items):
        rig = make_rig()
        data = rig.fill(RAM, items << psize)
        rig.stream(1, EN | M2P | PINC | MINC | sizes(psize, msize), items, fcr=FIFO | 1)
        rig.serve(1, items)
        assert rig.bus.dump(PORT, len(data)) == data
        assert rig.flags(1) == {"HT", "TC"}


class TestFifo:
    @pytest.mark.parametrize("threshold", range(4))
    def test_is_emptied_at_the_threshold(self, rig, threshold):
        rig.fill(PORT, 32)
        rig.stream(0, EN | PINC | MINC, 32, fcr=FIFO | threshold)
        for count in range(4 * (threshold + 1) - 1):
            rig.serve(0)
            assert rig.accesses("write") == []
            assert rig.peek("S0FCR") >> 3 & 7 == (count + 1) // 4
        rig.line(0).pulse()
        rig.chip.advance(PERIPHERAL)
        assert rig.peek("S0FCR") >> 3 & 7 == (threshold + 1 if threshold < 3 else 5)
        rig.chip.advance(100)
        assert len(rig.accesses("write")) == 4 * (threshold + 1)
        assert rig.peek("S0FCR") >> 3 & 7 == 4

    @pytest.mark.parametrize("threshold", range(4))
    def test_is_filled_again_at_the_threshold(self, rig, threshold):
        rig.fill(RAM, 64)
        rig.stream(0, EN | M2P | PINC | MINC, 64, fcr=FIFO | threshold)
        rig.chip.advance(200)
        assert len(rig.accesses("read")) == 16
        assert rig.peek("S0FCR") >> 3 & 7 == 5
        below = 16 - 4 * (threshold + 1)
        rig.serve(0, max(0, below - 1), gap=100)
        assert len(rig.accesses("read")) == 16
        rig.serve(0, 1, gap=100)
        assert len(rig.accesses("read")) == 16 + max(below, 1)

    def test_packing(self, rig):
        rig.fill(PORT, 8)
        rig.stream(0, EN | PINC | MINC | sizes(0, 2), 8, fcr=FIFO)
        rig.serve(0, 8)
        assert [access[2:] for access in rig.bus.accesses if access[0] == "write"] == [
            (4, 0x0403_0201),
            (4, 0x0807_0605),
        ]

    def test_a_burst_is_quicker_than_single_accesses(self, rig):
        for mburst, cycles in ((0, 4 * MEMORY), (1, MEMORY + 3)):
            rig.bus.accesses.clear()
            rig.clear(0)
            rig.stream(0, EN | PINC | MINC | bursts(0, mburst), 4, fcr=FIFO)
            rig.serve(0, 3)
            rig.line(0).pulse()
            rig.chip.advance(PERIPHERAL + (MEMORY if mburst else cycles) - 1)
            assert len(rig.accesses("write")) == (0 if mburst else 3)
            rig.chip.advance(1)
            assert len(rig.accesses("write")) == 4

    def test_one_request_moves_a_burst_of_the_peripheral(self, rig):
        rig.fill(PORT, 16)
        rig.stream(0, EN | PINC | MINC | bursts(1, 0), 10, fcr=FIFO)
        rig.serve(0)
        assert rig.peek("S0NDTR") == 6
        rig.serve(0)
        assert rig.peek("S0NDTR") == 2
        rig.serve(0)  # what is left is less than a burst: single items
        assert rig.peek("S0NDTR") == 1


class TestFlags:
    @pytest.mark.parametrize("direction", [P2M, M2P])
    @pytest.mark.parametrize("count", [1, 2, 3, 5, 8])
    def test_half_and_complete(self, rig, direction, count):
        rig.stream(0, EN | direction | MINC | HTIE, count)
        seen = []
        for _ in range(count):
            rig.serve(0)
            seen.append("HT" in rig.flags(0))
            assert ("TC" in rig.flags(0)) is (len(seen) == count)
        assert seen == [number >= (count + 1) // 2 for number in range(1, count + 1)]
        assert rig.irq(0).level

    def test_complete_comes_with_the_last_byte_in_memory(self, rig):
        rig.stream(0, EN | MINC | TCIE, 1)
        rig.line(0).pulse()
        rig.chip.advance(PERIPHERAL)
        assert rig.peek("S0NDTR") == 0
        assert rig.flags(0) == set()
        assert rig.peek("S0CR") & EN
        rig.chip.advance(MEMORY)
        assert rig.flags(0) == {"HT", "TC"}
        assert rig.irq(0).rises == [PERIPHERAL + MEMORY]

    @pytest.mark.parametrize(("peripheral", "memory"), [(NOWHERE, RAM), (PORT, NOWHERE)])
    @pytest.mark.parametrize("direction", [P2M, M2P, M2M])
    def test_a_bus_error_ends_the_stream(self, rig, peripheral, memory, direction):
        rig.stream(0, EN | MINC | direction | TEIE, 4, peripheral, memory)
        rig.stream(1, EN | MINC, 2)
        rig.serve(0, 2, gap=100)
        assert rig.flags(0) == {"TE"}
        assert not rig.peek("S0CR") & EN
        assert rig.irq(0).level
        rig.serve(1, 2)
        assert "TC" in rig.flags(1)

    def test_flags_that_were_not_cleared_are_noted(self, rig):
        rig.stream(0, EN | MINC, 1)
        rig.serve(0)
        rig.poke("S0CR", rig.peek("S0CR") | EN)
        assert rig.chip.noted("misuse") == ["DMA2_S0CR.EN"]

    def test_addresses_are_aligned(self, rig):
        rig.bus.load(PORT, bytes(range(8)))
        rig.stream(0, EN | PINC | MINC | sizes(1, 0), 2, PORT + 1, RAM + 3)
        rig.serve(0, 2)
        assert rig.bus.dump(RAM + 2, 4) == bytes(range(4))
        assert rig.chip.noted("misuse") == ["DMA2_S0PAR", "DMA2_S0M0AR"]


class TestRounds:
    @pytest.mark.parametrize("direction", [P2M, M2P])
    @pytest.mark.parametrize("fcr", [DIRECT, FIFO | 1])
    def test_circular(self, rig, direction, fcr):
        rig.fill(RAM, 4)
        rig.stream(0, EN | direction | CIRC | MINC, 4, fcr=fcr)
        found = []
        for value in range(1, 11):
            if direction is P2M:
                rig.bus.load(PORT, bytes([value]))
            rig.serve(0)
            found.append(rig.bus.dump(PORT, 1)[0])
            assert rig.peek("S0NDTR") == 4 - value % 4
            assert ("TC" in rig.flags(0)) is (value % 4 == 0)
            rig.clear(0)
        if direction is P2M:
            rig.serve(0, 2)
            assert rig.bus.dump(RAM, 4) == bytes([9, 10, 10, 10])
        else:
            assert found == [1, 2, 3, 4, 1, 2, 3, 4, 1, 2]
        assert rig.peek("S0CR") & EN

    def test_double_buffer(self, rig):
        rig.stream(0, EN | DBM | MINC, 2)
        for value in range(1, 7):
            rig.bus.load(PORT, bytes([value]))
            rig.serve(0)
            assert bool(rig.peek("S0CR") & CT) is ((value // 2) % 2 == 1)
            if value == 3:
                rig.poke("S0M0AR", RAM + 0x10)  # not in use now
        assert rig.bus.dump(RAM, 2) == bytes([1, 2])
        assert rig.bus.dump(RAM + 0x800, 2) == bytes([3, 4])
        assert rig.bus.dump(RAM + 0x10, 2) == bytes([5, 6])

    def test_double_buffer_may_begin_with_the_second(self, rig):
        rig.bus.load(PORT, b"\7")
        rig.stream(0, EN | DBM | CT | MINC, 1)
        rig.serve(0)
        assert rig.bus.dump(RAM + 0x800, 1) == b"\7"
        assert not rig.peek("S0CR") & CT

    def test_address_of_the_buffer_in_use_is_an_error(self, rig):
        rig.stream(0, EN | DBM | MINC, 2)
        rig.poke("S0M1AR", RAM + 0x20)
        assert rig.peek("S0M1AR") == RAM + 0x20
        rig.poke("S0M0AR", RAM + 0x20)
        assert rig.flags(0) == {"TE"}
        assert not rig.peek("S0CR") & EN

    def test_enabled_again_it_has_its_old_count(self, rig):
        """RM0410 section 8.5.6."""
        data = rig.fill(PORT, 3)
        rig.stream(0, EN | PINC | MINC, 3)
        rig.serve(0, 3)
        assert rig.peek("S0NDTR") == 0
        rig.bus.load(RAM, bytes(3))
        rig.clear(0)
        rig.poke("S0CR", rig.peek("S0CR") | EN)
        assert rig.peek("S0NDTR") == 3
        rig.serve(0, 3)
        assert rig.bus.dump(RAM, 3) == data

    def test_no_count_no_transfer(self, rig):
        rig.stream(0, EN | MINC, 0)
        rig.serve(0)
        assert not rig.bus.accesses
        assert rig.peek("S0CR") & EN
        rig.poke("S0CR", 0)
        assert not rig.peek("S0CR") & EN


class TestDisabling:
    @given(cycles=st.integers(0, 300), msize=st.integers(0, 2), threshold=st.integers(0, 3))
    def test_what_was_taken_is_stored(self, make_rig, cycles, msize, threshold):
        """RM0410 section 8.3.13, "FIFO flush": NDTR tells how much has arrived, and TCIF that it has."""
        rig = make_rig()
        data = rig.fill(PORT, 64)
        rig.stream(0, EN | PINC | MINC | sizes(0, msize), 64, fcr=FIFO | threshold)
        rig.line(0).set(True)
        rig.chip.advance(cycles)
        rig.poke("S0CR", rig.peek("S0CR") & ~EN)
        rig.chip.advance(200)
        taken = 64 - rig.peek("S0NDTR")
        assert len(rig.accesses("read")) == taken
        assert rig.bus.dump(RAM, taken) == data[:taken]
        assert not rig.peek("S0CR") & EN
        assert "TC" in rig.flags(0)

    def test_en_stays_set_while_the_fifo_is_emptied(self, rig):
        rig.stream(0, EN | MINC, 10, fcr=FIFO | 3)
        rig.serve(0, 2)
        rig.poke("S0CR", rig.peek("S0CR") & ~EN)
        rig.chip.advance(2 * MEMORY - 1)
        assert rig.peek("S0CR") & EN
        assert rig.flags(0) == set()
        rig.chip.advance(1)
        assert not rig.peek("S0CR") & EN
        assert rig.flags(0) == {"TC"}
        assert rig.peek("S0NDTR") == 8

    def test_to_a_peripheral_it_ends_at_once(self, rig):
        rig.stream(0, EN | MINC | M2P, 10)
        rig.serve(0, 2)
        rig.poke("S0CR", rig.peek("S0CR") & ~EN)
        assert not rig.peek("S0CR") & EN
        assert rig.flags(0) == {"TC"}
        rig.serve(0)
        assert rig.peek("S0NDTR") == 8

    def test_circular_ends_too(self, rig):
        rig.stream(0, EN | MINC | CIRC, 4)
        rig.serve(0, 6)
        rig.poke("S0CR", rig.peek("S0CR") & ~EN)
        rig.serve(0, 3)
        assert rig.peek("S0NDTR") == 2

    def test_reset_from_anywhere(self, rig):
        for number in range(8):
            rig.stream(number, EN | M2M | MINC | TCIE, 100)
        rig.chip.advance(61)
        rig.dma.reset()
        done = len(rig.bus.accesses)
        rig.chip.advance(2000)
        assert len(rig.bus.accesses) == done
        assert rig.peek("S0CR") == rig.peek("LISR") == 0

    def test_a_stream_that_stops_itself_makes_no_further_beat(self, rig):
        """Four words for its own CR: the first ends it, and the second would have it begin anew."""
        control = MINC | M2P | sizes(2, 2) | bursts(1, 0)
        rig.bus.load(RAM, b"".join(word.to_bytes(4, "little") for word in (0, control | 3 << 25 | EN, 0, 0)))
        rig.stream(0, control | EN, 8, rig.dma.base + 0x10, fcr=FIFO | 3)
        rig.chip.advance(100)
        rig.serve(0)
        assert rig.accesses("write", rig.dma.base) == [rig.dma.base + 0x10]
        assert not rig.peek("S0CR") & EN
        assert rig.peek("S0NDTR") == 8

    def test_without_its_clock_nothing_goes_on_until_it_comes_back(self, rig):
        data = rig.fill(PORT, 64)
        rig.stream(0, EN | M2M | PINC | MINC, 64)
        rig.chip.advance(61)
        rig.gate(False)
        done = len(rig.bus.accesses)
        rig.chip.advance(2000)
        assert len(rig.bus.accesses) == done
        rig.gate(True)
        rig.chip.advance(2000)
        assert rig.bus.dump(RAM, 64) == data
        assert rig.flags(0) == {"HT", "TC"}


class TestFlowController:
    def test_the_peripheral_says_when(self, rig):
        data = rig.fill(PORT, 8)
        rig.stream(0, EN | PFCTRL | PINC | MINC | TCIE, 0, fcr=FIFO | 3)
        assert rig.peek("S0NDTR") == 0xFFFF
        rig.serve(0, 5)
        assert rig.peek("S0NDTR") == 0xFFFF - 5
        rig.line(0).end()
        rig.chip.advance(100)
        assert rig.bus.dump(RAM, 6) == data[:5] + b"\0"
        assert rig.flags(0) == {"TC"}
        assert not rig.peek("S0CR") & EN

    def test_otherwise_it_is_not_asked(self, rig):
        rig.stream(0, EN | MINC, 5)
        rig.line(0).end()
        assert rig.peek("S0CR") & EN

    def test_nor_is_the_peripheral_of_another_channel(self, rig):
        rig.stream(0, EN | PFCTRL | MINC, 0)
        rig.requests.line("X").end()
        assert rig.peek("S0CR") & EN


class TestLastTransfer:
    @pytest.mark.parametrize("direction", [P2M, M2P])
    @pytest.mark.parametrize("mode", [0, CIRC, DBM])
    def test_the_peripheral_is_told_of_the_last_of_each_round(self, rig, direction, mode):
        told = []
        rig.line(0).on_last = lambda: told.append(rig.peek("S0NDTR"))
        rig.stream(0, EN | direction | MINC | mode, 3)
        rig.serve(0, 2)
        assert told == []
        rig.serve(0)
        assert len(told) == 1
        rig.serve(0, 3)
        assert len(told) == (2 if mode else 1)


class TestMemoryToMemory:
    def test_runs_without_requests(self, rig):
        data = rig.fill(PORT, 40)
        rig.stream(3, EN | M2M | PINC | MINC | sizes(2, 2), 10, fcr=FIFO | 3)
        rig.chip.advance(200)
        assert rig.bus.dump(RAM, 40) == data
        assert rig.flags(3) == {"HT", "TC"}

    def test_not_in_a_controller_that_cannot(self, make_rig):
        rig = make_rig(between_memories=False)
        rig.stream(3, EN | M2M | PINC | MINC, 10)
        rig.chip.advance(200)
        assert not rig.bus.accesses
        assert rig.flags(3) == {"TE"}
        assert rig.chip.noted("misuse") == ["DMA2_S3CR.DIR"]


class TestPriorities:
    def test_level_first_then_number(self, rig):
        for number, level in ((2, 0), (3, 3), (5, 3), (6, 1)):
            rig.stream(number, MINC | level << 16, 2, PORT + number)
        for number in (2, 6, 5, 3):
            rig.poke(f"S{number}CR", rig.peek(f"S{number}CR") | EN)
            rig.line(number).set(True)
        rig.chip.advance(8 * PERIPHERAL)
        assert [address - PORT for address in rig.accesses("read")] == [3, 3, 5, 5, 6, 6, 2, 2]

    def test_who_comes_during_an_access_waits(self, rig):
        rig.stream(7, EN | MINC, 3, PORT + 7)
        rig.stream(1, EN | MINC | 3 << 16, 3, PORT + 1)
        rig.line(7).set(True)
        rig.chip.advance(1)
        rig.line(1).set(True)
        rig.chip.advance(5 * PERIPHERAL - 1)
        assert [address - PORT for address in rig.accesses("read")] == [7, 1, 1, 1, 7]

    def test_both_ports_work_at_the_same_time(self, rig):
        rig.stream(0, EN | MINC, 20)
        rig.line(0).set(True)
        rig.chip.advance(20 * PERIPHERAL + MEMORY)
        assert rig.flags(0) == {"HT", "TC"}


def test_a_burst_holds_its_port_for_each_further_beat(rig):
    rig.stream(1, EN | MINC | PINC | 1 << 21, 8, fcr=FIFO | 3)
    rig.stream(2, EN | MINC, 1, PORT + 0x200)
    rig.line(1).pulse()
    rig.chip.advance(1)
    rig.line(2).pulse()
    rig.chip.advance(4)
    assert rig.accesses("read", PORT) == [PORT, PORT + 1, PORT + 2, PORT + 3]
    rig.chip.advance(3 + 4)
    assert len(rig.accesses("read", PORT)) == 4
    rig.chip.advance(1)
    assert rig.accesses("read", PORT)[4:] == [PORT + 0x200]
