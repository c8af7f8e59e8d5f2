"""`hilbench diff` with captures: waveforms and tables, by us and by logic analysers."""

from __future__ import annotations

import pytest

from hilbench.cli import main
from targets.firmware import image_path

pytestmark = pytest.mark.usefixtures("keep_signals")

STEPS = [(1, "PB7", False), (1, "PB6", False), (10, "PB7", True), (20, "PB6", True), (30, "PB7", False)]
TABLE = """\
Time [s],D0,D1
0.000000,0,0
0.509000,1,0
0.519000,1,1
0.529100,0,1
0.600000,0,1
"""
WAVES = """\
$timescale 100 ns $end
$scope module logic $end
$var wire 1 ! D0 $end
$var wire 1 " D1 $end
$var wire 8 # D2 $end
$upscope $end
$enddefinitions $end
#0 0! 0" b0 #
#5090000 1!
#5190000 1"
#5291000 b101 # 0!
#6000000
"""
MAP = ("--map", "D0=brain.PB7", "--map", "D1=brain.PB6")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("b.csv", TABLE),
        ("b.csv", "; made by an analyser\n" + TABLE.replace(",", ";")),
        ("b.csv", "\ufeff" + TABLE.replace(",", "\t").replace("\n", "\r\n")),
        ("b.vcd", WAVES),
    ],
)
def test_a_capture_of_a_real_board_is_held_against_a_journal(write, pins, data, name, text):
    a, b = pins("a.jsonl", STEPS), write(name, text)
    found = data(a, b, *MAP, "--tolerance", "200us")
    assert found["equal"]
    assert found["aligned_on"]["signal"] == "brain.PB7"
    assert found["aligned_on"]["b_ns"] == 509_000_000
    assert [(one["name"], one["a"], one["b"], one["largest_late_ns"]) for one in found["signals"]] == [
        ("brain.PB6", 1, 1, 0),
        ("brain.PB7", 2, 2, 100_000),
    ]
    assert data(a, b, *MAP)["first"]["text"] == "brain.PB7 -> 0 comes 100 us later in B than in A"
    assert data(b, a, *MAP)["first"]["text"] == "brain.PB7 -> 0 comes 100 us earlier in B than in A"


def test_a_pin_that_is_pulled_up_before_the_firmware_runs_has_its_first_edge_in_both(write, pins, data):
    a = pins("a.jsonl", [(2, "PB4", None), (3, "PB4", False), (9, "PB4", True)])
    b = write("b.csv", "Time,PB4\n0,1\n0.002,0\n0.009,1\n0.1,1\n")
    found = data(a, b)
    assert found["equal"]
    assert found["signals"][0]["agree"] == 2


def test_columns_with_the_names_of_pins_need_no_map(write, pins, data):
    named = TABLE.replace("D0", "PB7").replace("D1", "brain.PB6")
    assert data(pins("a.jsonl", STEPS), write("b.csv", named), "--tolerance", "200us")["equal"]


def test_columns_of_no_net_are_named(write, pins, data):
    found = data(pins("a.jsonl", STEPS), write("b.csv", TABLE), "--map", "D0=brain.PB7", "--tolerance", "200us")
    assert found["equal"]
    assert found["b"]["remarks"] == ["no net of the bench: D1 (name it with --map)"]
    assert found["not_compared"] == {"D1": "only in B", "brain.PB6": "only in A"}


def test_two_captures_begin_with_their_levels(write, data):
    a = write("a.csv", TABLE)
    b = write("b.csv", "Time [s],D0,D1\n0,0,1\n0.6,0,1\n")
    found = data(a, b)
    assert found["first"]["text"] == "D1 begins with 0 in A, with 1 in B"
    assert data(a, write("c.csv", TABLE))["equal"]


def test_a_pin_that_a_journal_tells_as_bytes_is_not_compared_edge_by_edge(journal, write, data, diff):
    pin = ("pin", "brain.PA9", {"level": True})
    sent = [(2, "frames", "brain", {"pin": "PA9"}), (2, "tx", "brain.usart1", {"data": b"U", "from_ns": 2_000_000})]
    a = journal("a.jsonl", [(1, *pin), *sent])
    rows = "".join(f"{at / 1e4},{at % 2}\n" for at in range(10, 30))
    b = write("b.csv", f"Time,PA9\n0,0\n{rows}")
    other = write("c.csv", f"Time,PA9,PB0\n0,0,0\n{rows.replace(chr(10), ',0' + chr(10))}")
    assert "bytes in the place of its edges" in data(a, other)["not_compared"]["brain.PA9"]
    code, _, err = diff(a, b)
    assert code == 2
    assert "nothing to compare in these recordings; brain.PA9: A has bytes" in err


def test_a_journal_and_the_waveforms_of_the_same_run_are_equal(tmp_path, data, capfd):
    journal, waves = tmp_path / "run.jsonl", tmp_path / "run.vcd"
    words = ["--for", "200ms", "--journal", str(journal), "--vcd", str(waves)]
    assert main(["run", f"bluepill:{image_path('robot-words')}", *words]) == 0
    capfd.readouterr()
    found = data(str(journal), str(waves))
    assert found["equal"]
    assert set(found["not_compared"].values()) == {
        "only in A", "only in B", "A has bytes in the place of its edges (hilbench run --edges records both)"
    }  # fmt: skip
    agree = {one["name"]: one["agree"] for one in found["signals"]}
    assert agree["bluepill.PB7"] == agree["bluepill.PA1"] == 1
    assert data(str(waves), str(waves))["equal"]


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("none.csv", None, "none.csv: cannot be read: No such file or directory"),
        ("b.csv", "", "b.csv: is empty"),
        ("b.csv", "hello\nworld\n", "b.csv: is neither a journal, nor waveforms (VCD), nor a table; the first line"),
        ("b.csv", "Time,D0\n", "b.csv: has no samples"),
        ("b.csv", "Time,D0,D0\n0,1,1\n", "b.csv:1: has two columns 'D0'"),
        ("b.csv", "Time,D0\n0,1\nsoon,0\n", "b.csv:3: 'soon' is no time in seconds"),
        ("b.csv", "Time,D0\n0,1\ninf,0\n", "b.csv:3: 'inf' is no time in seconds"),
        ("b.csv", "Time,D0\n0,1\n1,3.3\n", "b.csv:3: '3.3' is no level: 0, 1 or z"),
        ("b.csv", "Time,D0\n0,1\n1\n", "b.csv:3: has 1 columns instead of 2"),
        ("b.csv", "Time,D0\n2,1\n1,0\n", "b.csv:3: its time goes back to 1 s"),
        ("b.vcd", "$scope module a $end $enddefinitions $end", "b.vcd: is a value change dump without a variable"),
        ("b.vcd", "$var wire 1 ! D0 $end $enddefinitions $end #5 1! #3 0!", "b.vcd: is no value change dump: its"),
        ("b.vcd", "$var wire one ! D0 $end", "b.vcd: is no value change dump: "),
        ("b.jsonl", '{"kind":"other"}\n', "b.jsonl: is not a hilbench journal"),
        ("b.jsonl", '{"kind":"journal"', "b.jsonl: no journal can be read from it: cut in line 1"),
    ],
)
def test_what_cannot_be_read_is_one_line_and_3(write, pins, diff, name, text, said, tmp_path):
    a, b = pins("a.jsonl", STEPS), str(tmp_path / name)
    if text is not None:
        write(name, text)
    code, out, err = diff(a, b, "--map", "D0=brain.PB7")
    assert (code, out, err.count("\n")) == (3, "", 1)
    assert err.startswith(f"hilbench: {tmp_path}/{said}")
