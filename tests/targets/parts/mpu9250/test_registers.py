"""The register map: reset values, what is writable, how bursts count (RM-MPU-9250A-00 section 3)."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from targets.parts.mpu9250.registers import FACTORY, REGISTERS, Reg
from targets.parts.testing import PartBench

READ_ONLY = [*range(0x35, 0x37), *range(0x3A, 0x61), 0x72, 0x73, 0x75]
OUTPUTS = range(0x3B, 0x49)


def test_who_am_i_at_both_addresses(make_imu) -> None:
    assert make_imu().byte(0x75) == 0x71
    other = make_imu(ad0=True)
    assert other.read(0x75, address=0x69) == b"\x71"
    assert not other.answers(0x68)


def test_the_map_is_that_of_the_manual() -> None:
    """Table 1: every address with a name, and no other."""
    named = [*range(0x03), *range(0x0D, 0x10), *range(0x13, 0x20), *range(0x23, 0x39), *range(0x3A, 0x61)]
    named += [*range(0x63, 0x6D), *range(0x72, 0x76), 0x77, 0x78, 0x7A, 0x7B, 0x7D, 0x7E]
    assert sorted(REGISTERS) == named


def test_reset_values(imu) -> None:
    imu.write(0x6B, 0x40)  # asleep: no sample changes anything any more
    imu.write(0x6A, 0x01)
    imu.byte(0x3A)
    for address in REGISTERS:
        expected = {0x6B: 0x40, 0x75: 0x71}.get(address, 0)
        if address not in FACTORY:
            assert imu.byte(address) == expected, REGISTERS[address].name


def test_power_management_comes_up_with_the_pll(imu) -> None:
    assert imu.byte(0x6B) == 0x01


@pytest.mark.parametrize("address", READ_ONLY)
def test_read_only_registers_stay_and_say_so(imu, address) -> None:
    imu.write(0x6B, 0x40)
    imu.byte(0x3A)
    before = imu.byte(address)
    imu.write(address, before ^ 0xFF)
    assert imu.byte(address) == before
    assert any("read-only" in note for note in imu.notes())


@pytest.mark.parametrize(
    ("address", "kept"),
    [(0x1A, 0x7F), (0x1B, 0xFB), (0x1C, 0xF8), (0x1D, 0x0F), (0x1E, 0x0F), (0x37, 0xFE), (0x38, 0x59), (0x6C, 0x3F)],
)
def test_reserved_bits_read_zero(imu, address, kept) -> None:
    imu.write(address, 0xFF)
    assert imu.byte(address) == kept


@pytest.mark.parametrize("address", [0x03, 0x12, 0x20, 0x39, 0x61, 0x76, 0x7F])
def test_reserved_addresses_read_zero_and_are_noted(imu, address) -> None:
    imu.write(address, 0x55)
    assert imu.byte(address) == 0
    assert any(f"0x{address:02X} is reserved" in note for note in imu.notes())


def test_every_other_register_keeps_what_is_written(imu) -> None:
    imu.write(0x6B, 0x40)
    whole = [
        address
        for address, register in REGISTERS.items()
        if register.writable == 0xFF and address not in (Reg.INT_PIN_CFG, Reg.INT_ENABLE)
    ]
    for address in whole:
        imu.write(address, 0xA5)
    assert {imu.byte(address) for address in whole} == {0xA5}


def test_a_burst_counts_up_and_stays_at_the_fifo(imu) -> None:
    imu.write(0x13, 1, 2, 3, 4, 5, 6, 7)
    assert imu.read(0x13, 7) == bytes((1, 2, 3, 4, 5, 6, 7))
    imu.write(0x74, 0x11, 0x22, 0x33)
    assert imu.read(0x74, 3) == bytes((0x11, 0x22, 0x33))
    assert imu.read(0x73, 4)[2:] == b"\x33\x33"


def test_the_pointer_goes_on_from_message_to_message(imu) -> None:
    imu.read(0x74)
    imu.write(0x75)
    imu.bus.start(imu.now_ns)
    imu.bus.address(0x68, True, imu.now_ns)
    assert imu.bus.read(imu.now_ns) == 0x71
    imu.bus.stop(imu.now_ns)


def test_reset_brings_everything_back(imu) -> None:
    factory = imu.read(0x77, 2)
    for address in (0x19, 0x1B, 0x23, 0x37, 0x38, 0x6C, 0x77, 0x78):
        imu.write(address, 0x18)
    imu.write(0x6B, 0x80)
    assert imu.byte(0x6B) == 0x01
    assert {imu.byte(address) for address in (0x19, 0x1B, 0x23, 0x37, 0x38, 0x6C)} == {0}
    assert imu.read(0x77, 2) == factory
    assert imu.accel() == [0, 0, 0]
    imu.run(35)
    assert imu.accel() == [0, 0, 16384]


def test_nothing_is_acknowledged_before_the_start_up_time(make_imu) -> None:
    imu = make_imu(ready=False)
    imu.run_to(10_000_000)
    assert not imu.answers(0x68)
    assert any("start-up" in note for note in imu.notes())
    imu.run_to(11_000_000)
    assert imu.answers(0x68)
    assert make_imu(ready=False, ready_ms=0).answers(0x68)


def test_it_does_not_answer_to_others(imu) -> None:
    assert [address for address in range(128) if imu.answers(address)] == [0x68]


def test_the_spi_only_bit_makes_it_deaf(imu) -> None:
    imu.write(0x6A, 0x10)
    assert not imu.answers(0x68)
    assert any("SPI" in note for note in imu.notes())


@pytest.mark.parametrize(
    ("address", "value", "word"), [(0x6D, 1, "motion processor"), (0x6A, 0x80, "motion processor")]
)
def test_what_is_absent_is_noted_once(imu, address, value, word) -> None:
    imu.write(address, value)
    imu.write(address, value)
    assert [word in note for note in imu.notes()] == [True]


def test_the_motion_processor_reads_zero_and_is_noted(imu) -> None:
    assert imu.read(0x6D, 5) == bytes(5)
    assert any("motion processor" in note for note in imu.notes())


def test_a_part_that_was_not_switched_on_is_silent() -> None:
    from targets.parts.mpu9250 import Mpu9250, Mpu9250Settings
    from targets.parts.part import Ports

    part = Mpu9250(Mpu9250Settings(), Ports(), seed=1)
    assert not part.slave("i2c").address(0x68, False, 0)
    with pytest.raises(KeyError):
        part.slave("spi")


MESSAGES = st.lists(
    st.tuples(
        st.sampled_from([0x68, 0x0C, 0x69]),
        st.booleans(),
        st.lists(st.integers(0, 255), max_size=6),
        st.integers(0, 3_000_000),
    ),
    max_size=12,
)


@given(MESSAGES)
def test_no_bytes_raise_anything(messages) -> None:
    from targets.mcu.i2c_bus import I2cBus
    from targets.parts.mpu9250 import Mpu9250, Mpu9250Settings

    still = {"ax": 0.0, "ay": 0.0, "az": 9.8, "wx": 0.0, "wy": 0.0, "wz": 0.0}
    bench = PartBench(Mpu9250, Mpu9250Settings(ready_ms=0), quantities=lambda _ns: still, step_ns=4_000_000)
    bus = I2cBus()
    bus.attach(bench.part.slave("i2c"))
    for address, read, data, wait_ns in messages:
        bench.run_to(bench.now_ns + wait_ns)
        bus.start(bench.now_ns)
        if bus.address(address, read, bench.now_ns):
            for byte in data:
                found = bus.read(bench.now_ns) if read else bus.write(byte, bench.now_ns)
                assert 0 <= found <= 255
        bus.stop(bench.now_ns)
    bench.run(0.05)
