"""I2C of an emulated board, for people: lines of `run --follow`, and the bus in a test."""

from __future__ import annotations

import pytest

from hilbench.benchfile.reader import open_bench
from hilbench.errors import UsageError
from hilbench.mcu.emulated import EmulatedBench
from hilbench.mcu.narration import Narrator
from hilbench.mcu.under_test import boards_under_test
from targets.firmware import image_path
from targets.mcu.i2c_bus import I2cMessage, I2cTransaction


@pytest.fixture
def bench_file(tmp_path):
    """A Nucleo whose program asks three times who is at 0x50, and breaks off a fourth time."""
    file = tmp_path / "my.toml"
    file.write_text(f'version = 1\n[targets.brain]\nboard = "nucleo-f767zi"\nfirmware = "{image_path("f767-i2c")}"\n')
    return open_bench(str(file))


@pytest.fixture
def emulated(bench_file):
    emulated = EmulatedBench(bench_file)
    yield emulated
    emulated.close()


def lines_of(emulated, happen):
    said = []
    Narrator(emulated, said.append)
    happen()
    return [line.split(maxsplit=2)[2] for line in said if line.split()[1] == "brain.i2c1"]


def test_a_run_is_told_transaction_by_transaction(emulated):
    assert lines_of(emulated, lambda: emulated.bench.run_for(0.01)) == [
        "0x50 w no acknowledge",
        "0x50 r no acknowledge",
        "0x50 w no acknowledge",
        "broken off",
    ]


def message(read, data, **fields):
    fields = {"acknowledged": True, "refused": False, **fields}
    return I2cMessage(address=0x68, read=read, data=data, at_ns=0, **fields)


@pytest.mark.parametrize(
    ("messages", "complete", "line"),
    [
        ([message(False, b"\x75"), message(True, b"\x71")], True, "0x68 w 75, 0x68 r 71"),
        ([message(False, b"\x6b\x80", refused=True)], True, "0x68 w 6b80 no acknowledge"),
        ([message(False, b"\x3b")], False, "0x68 w 3b, broken off"),
        ([message(True, bytes(17))], True, f"0x68 r {'00' * 16}..."),
        ([message(False, b"")], True, "0x68 w"),
    ],
)
def test_what_a_transaction_looks_like(emulated, messages, complete, line):
    transaction = I2cTransaction(messages=tuple(messages), begin_ns=0, end_ns=1, complete=complete)
    assert lines_of(emulated, lambda: emulated.bench.record_event("brain.i2c1", transaction)) == [line]


def test_a_test_may_watch_the_bus(emulated):
    told = []
    boards_under_test(emulated)["brain"].i2c("i2c1").taps.append(told.append)
    emulated.bench.run_for(0.01)
    assert [one.complete for one in told] == [True, True, True, False]


def changes(vcd, scope):
    """The changes of the signals of a scope, in the order of the file: name, ns, level."""
    names, here, found, ns = {}, "", [], 0
    for line in vcd.read_text().splitlines():
        words = line.split()
        if words[0] == "$scope":
            here = f"{here}.{words[2]}".lstrip(".")
        elif words[0] == "$upscope":
            here = here.rpartition(".")[0]
        elif words[0] == "$var" and here == scope:
            names[words[3]] = words[4]
        elif words[0].startswith("#"):
            ns = int(words[0][1:])
        elif words[0][0] in "01" and words[0][1:] in names:
            found.append((names[words[0][1:]], ns, words[0][0] == "1"))
    return found


def test_waveforms_have_clock_and_data(bench_file, tmp_path):
    """Three STARTs with an address and its NACK up to a STOP; the fourth is broken off within its address."""
    emulated = EmulatedBench(bench_file, vcd=tmp_path / "i2c.vcd", step_ns=30_000)
    told = []
    boards_under_test(emulated)["brain"].i2c("I2C1").taps.append(told.append)
    emulated.bench.run_for(0.01)
    emulated.close()
    conditions, clocks, scl = [], 0, True
    for name, ns, level in changes(tmp_path / "i2c.vcd", "brain.i2c1")[2:]:  # behind the levels at the beginning
        if name == "scl":
            scl, clocks = level, clocks + level
        elif scl:
            conditions.append((level, clocks, ns))
            clocks = 0
    assert [one[:2] for one in conditions[:6]] == [(False, 0), (True, 10)] * 3  # nine clocks, and that of the STOP
    times = [ns for one in told[:3] for ns in (one.begin_ns, one.end_ns)]
    assert [one[2] for one in conditions[:6]] == times


def test_an_interface_that_is_not_there(emulated, tmp_path):
    brain = boards_under_test(emulated)["brain"]
    with pytest.raises(UsageError, match=r"brain has no I2C interface 'I2C9'; did you mean 'I2C\d'\?"):
        brain.i2c("I2C9")
    file = tmp_path / "old.toml"
    image = image_path("selftest-crc")
    file.write_text(f'version = 1\n[targets.old]\nboard = "bluepill"\nfirmware = "{image}"\n')
    old = EmulatedBench(open_bench(str(file)))
    with pytest.raises(UsageError, match="has no I2C interface 'I2C3'; did you mean"):
        boards_under_test(old)["old"].i2c("I2C3")
    old.close()


WIRES = """[[wires]]
ends = ["brain.PB6", "brain.PB10"]
[[wires]]
ends = ["brain.PB7", "brain.PB11"]
"""


def test_two_interfaces_of_a_chip_meet_on_wires(tmp_path):
    file = tmp_path / "my.toml"
    image = image_path("selftest-i2c-slave")
    file.write_text(f'version = 1\n[targets.brain]\nboard = "bluepill"\nfirmware = "{image}"\n{WIRES}')
    emulated = EmulatedBench(open_bench(str(file)))
    lines = lines_of(emulated, lambda: emulated.bench.run_for(0.002_5))
    assert lines == ["0x21 w 11223344"]
    assert not emulated.notes()
    emulated.close()


def test_a_slave_that_no_master_reaches_is_said(tmp_path):
    file = tmp_path / "my.toml"
    image = image_path("selftest-i2c-slave")
    file.write_text(f'version = 1\n[targets.brain]\nboard = "bluepill"\nfirmware = "{image}"\n')
    emulated = EmulatedBench(open_bench(str(file)))
    emulated.bench.run_for(0.001)
    assert [(note["kind"], note["where"]) for note in emulated.notes()] == [("unmodelled", "I2C2_OAR1")]
    emulated.close()
