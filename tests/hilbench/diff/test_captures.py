"""`hilbench diff` with captures: waveforms and tables, by us and by logic analysers."""

from __future__ import annotations

from decimal import Decimal

import pytest

from hilbench.cli import main
from hilbench.diff.csv_file import read_csv
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


@pytest.mark.parametrize(
    ("head", "factor"),
    [
        ("Time", 1),
        ("Timestamp (s)", 1),
        ("time_s", 1),
        ("Time [ms]", 10**3),
        ("time_us", 10**6),
        ("Time(\u00b5s)", 10**6),
        ("Time [\u03bcs]", 10**6),
        ("TIME NS", 10**9),
        ("time [Milliseconds]", 10**3),
    ],
)
def test_the_head_of_the_column_of_times_says_their_unit(write, pins, data, head, factor):
    times = [("0", 0, 0), ("0.509", 1, 0), ("0.519", 1, 1), ("0.529", 0, 1), ("0.6", 0, 1)]
    rows = "".join(f"{float(at) * factor:.9f},{d0},{d1}\n" for at, d0, d1 in times)
    assert data(pins("a.jsonl", STEPS), write("b.csv", f"{head},D0,D1\n{rows}"), *MAP)["equal"]


def test_two_captures_begin_with_their_levels(write, data):
    a = write("a.csv", TABLE)
    b = write("b.csv", "Time [s],D0,D1\n0,0,1\n0.6,0,1\n")
    found = data(a, b)
    assert found["first"]["text"] == "D1 begins with 0 in A, with 1 in B"
    assert data(a, write("c.csv", TABLE))["equal"]


def test_a_pin_that_a_journal_tells_as_bytes_is_not_compared_edge_by_edge(journal, write, data, diff):
    pin = ("pin", "brain.PA9", {"level": True})
    sent = [(2, "frames", "brain", {"pin": "PA9"}), (2, "tx", "brain.usart1", {"data": b"U", "from_ns": 2_000_000})]
    a = journal("a.jsonl", [(1, *pin), *sent, (2, "pin", "brain.PB0", {"level": True})])
    rows = "".join(f"{at / 1e4},{at % 2}\n" for at in range(10, 30))
    b = write("b.csv", f"Time,PA9\n0,0\n{rows}")
    both = "".join(f"{at / 1e4},{at % 2},{int(at >= 20)}\n" for at in range(10, 30))
    other = write("c.csv", f"Time,PA9,PB0\n0,0,0\n{both}")
    quiet = write("d.csv", f"Time,PA9,PB1\n0,0,0\n{rows.replace(chr(10), ',0' + chr(10))}")
    assert "bytes in the place of its edges" in data(a, other)["not_compared"]["brain.PA9"]
    code, _, err = diff(a, quiet)
    assert code == 2
    assert "compared for 2.9 ms; brain.PA9: A has bytes" in err
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
        ("b.csv", "Time,D0\n0,1\n1e400,0\n", "b.csv:3: '1e400' is no time in seconds"),
        ("b.csv", "Time,D0\n0,1\n1,3.3\n", "b.csv:3: '3.3' is no level: 0, 1 or z"),
        ("b.csv", "Time,D0\n0,1\n1\n", "b.csv:3: has 1 columns instead of 2"),
        ("b.csv", "Time,D0\n2,1\n1,0\n", "b.csv:3: its time goes back to 1 s"),
        ("b.csv", "time_us,D0\n2,1\n1,0\n", "b.csv:3: its time goes back to 1 us"),
        ("b.csv", "\nTime [ms],D0\nsoon,1\n", "b.csv:3: 'soon' is no time in milliseconds"),
        (
            "b.csv",
            "Time [samples],D0\n2,1\n",
            "b.csv:1: 'Time [samples]' has no unit that is known; call it 'Time [s]'",
        ),
        ("b.csv", "Time [h],D0\n2,1\n", "b.csv:1: 'Time [h]' has no unit that is known; "),
        ("b.vcd", "$scope module a $end $enddefinitions $end", "b.vcd: is a value change dump without a variable"),
        ("b.vcd", "$var wire 1 ! D0 $end $enddefinitions $end #5 1! #3 0!", "b.vcd: is no value change dump: its"),
        (
            "b.vcd",
            f"$var wire 1 ! D0 $end $enddefinitions $end #0 0! #{'1' * 400} 1!",
            "b.vcd: is no value change dump: ",
        ),
        ("b.vcd", "$var wire one ! D0 $end", "b.vcd: is no value change dump: "),
        ("b.jsonl", '{"kind":"other"}\n', "b.jsonl: is not a hilbench journal"),
        ("b.jsonl", '{"kind":"journal","images":3}\n', "b.jsonl:1: 'images' is no table of boards"),
        ("b.jsonl", '{"kind":"journal"', "b.jsonl: no journal can be read from it: cut in line 1"),
        ("b.csv", f"Time,PB7\n0,0\n1,{'1' * 140_000}\n", "b.csv: is no table: field larger than field limit"),
        ("b.vcd", WAVES.replace("$upscope $end", "$upscope $end $upscope $end", 1), "b.vcd: is no value change dump: "),
    ],
)
def test_what_cannot_be_read_is_one_line_and_3(write, pins, diff, name, text, said, tmp_path):
    a, b = pins("a.jsonl", STEPS), str(tmp_path / name)
    if text is not None:
        write(name, text)
    code, out, err = diff(a, b, "--map", "D0=brain.PB7")
    assert (code, out, err.count("\n")) == (3, "", 1)
    assert err.startswith(f"hilbench: {tmp_path}/{said}")


@pytest.mark.parametrize("separator", [",", ";", "\t"])
def test_a_table_that_was_cut_anywhere_is_read_up_to_there(tmp_path, separator):
    """What a level is cannot be cut; a line that has one in each column is there, end or not."""
    text = "Time [s],D0,D1\n0,0,0\n0.509,1,0\n0.519,1,z\n0.5291,,1\n0.6,0,1\n".replace(",", separator)
    path, rows = tmp_path / "b.csv", text.splitlines()[1:]
    for cut in range(text.index("\n0.509"), len(text)):
        path.write_text(text[:cut])
        found = read_csv(path)
        whole = [row for row in rows if text.index(row) + len(row) <= cut]
        assert found.end_ns == round(Decimal(whole[-1].partition(separator)[0]) * 10**9)
        left_out = not text[:cut].endswith(("\n", whole[-1]))
        ended = text[cut - 1] == "\n"
        assert found.remarks == (
            () if ended else ("its last line has no end and is left out",)
            if left_out else ("its last line has no end: whether more lines followed cannot be known",)
        )  # fmt: skip


def test_an_empty_last_cell_without_an_end_may_have_been_cut(write, pins, diff):
    b = write("b.csv", "Time,PB7,PB6\n0,0,0\n0.509,1,0\n0.519,1,")
    out = diff(pins("a.jsonl", STEPS), b, "--common")[1]
    assert "b.csv: table of samples, 0.509000 s\n   its last line has no end and is left out\n" in out


def test_a_device_is_no_recording(write, pins, diff):
    code, out, err = diff(pins("a.jsonl", STEPS), "/dev/zero")
    assert (code, out) == (3, "")
    assert err.startswith("hilbench: /dev/zero: is not a regular file")


@pytest.mark.parametrize(
    ("line", "said"),
    [
        ('{"ns":"x","kind":"pin","source":"brain.PB7","level":true}', "'ns' is no whole number"),
        ('{"ns":true,"kind":"pin","source":"brain.PB7","level":true}', "'ns' is no whole number"),
        ('{"kind":"pin","source":"brain.PB7","level":true}', "'ns' is missing"),
        ('{"ns":1,"kind":["pin"],"source":"brain.PB7","level":true}', "'kind' is no text"),
        ('{"ns":1,"kind":"pin","level":true}', "'source' is missing"),
        ('{"ns":1,"kind":"pin","source":7,"level":true}', "'source' is no text"),
        ('{"ns":1,"kind":"pin","source":"brain.PB7"}', "'level' is missing"),
        ('{"ns":1,"kind":"pin","source":"brain.PB7","level":"high"}', "'level' is no level: true, false or null"),
        ('{"ns":1,"kind":"pin","source":"brain.PB7","level":1}', "'level' is no level: true, false or null"),
        ('{"ns":1,"kind":"frames","source":"brain"}', "'pin' is missing"),
        ('{"ns":1,"kind":"pwm","source":"brain.PB7","in_ns":5}', "'edges' is missing"),
        ('{"ns":1,"kind":"pwm","source":"brain.PB7","in_ns":5,"edges":"5"}', "'edges' is no whole number"),
        ('{"ns":1,"kind":"pwm","source":"b.PB7","in_ns":5,"edges":5,"duty":2}', "'duty' is no part of 1"),
        ('{"ns":1,"kind":"pwm","source":"b.PB7","in_ns":5,"edges":5,"period_ns":9}', "'high_ns' is missing"),
        ('{"ns":1,"kind":"tx","source":"brain.usart1","data":5}', "'data' is no text"),
        ('{"ns":1,"kind":"tx","source":"brain.usart1","data":"55","from_ns":"x"}', "'from_ns' is no whole number"),
        ('{"ns":1,"kind":"event","source":"m","value":{"code":1,"at_ns":"x"}}', "'at_ns' is no whole number"),
        ('{"ns":1,"kind":"case","source":"journal"}', "'case' is missing"),
        ('{"ns":1,"kind":"case","source":"journal","case":[]}', "'case' is no text"),
    ],
)
def test_an_event_that_is_damaged_is_named_by_its_line(write, pins, diff, line, said, tmp_path):
    good = '{"ns":0,"kind":"pin","source":"brain.PB7","level":false}'
    damaged = write("b.jsonl", f'{{"kind":"journal","images":{{"brain":{{}}}}}}\n{good}\n{line}\n')
    code, out, err = diff(pins("a.jsonl", STEPS), damaged)
    assert (code, out, err) == (3, "", f"hilbench: {tmp_path}/b.jsonl:3: {said}\n")


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("b.csv", "Time,PB7,PB6\n0,0,0\n"),
        ("b.csv", "Time,PB7,PB6\n0,0,0\n0.0004,0,0\n"),
        ("b.vcd", WAVES.replace("D0", "PB7").partition("#5090000")[0] + "#4000\n"),
    ],
)
def test_a_capture_in_which_nothing_happens_before_it_ends_is_nothing_to_compare(write, pins, diff, name, text):
    a = pins("a.jsonl", STEPS, end_ms=15_000)
    for files in ((a, write(name, text)), (write(name, text), a)):
        code, out, err = diff(*files)
        assert (code, out, err.count("\n")) == (2, "", 1)
        assert err.startswith("hilbench: nothing to compare: no change of any signal is in both recordings, ")


def test_a_capture_that_ends_early_is_different_unless_that_is_asked_for(write, pins, data, diff):
    a, b = pins("a.jsonl", STEPS), write("b.csv", "Time,PB7,PB6\n0,0,0\n0.509,1,0\n0.515,1,0\n")
    found = data(a, b)
    assert found["first"]["kind"] == "end"
    assert found["first"]["text"] == (
        "B ends 6 ms after the first change in common, and A goes on: brain.PB6 -> 1 and 1 change more not compared"
    )
    assert found["beyond"] == {"a_ns": 84_000_000, "b_ns": 0, "a": 2, "b": 0}
    assert data(b, a)["first"]["text"].startswith("A ends 6 ms after the first change in common, and B goes on: ")
    code, out, _ = diff(a, b)
    assert code == 1
    assert "\ndifferent: B ends 6 ms after" in out
    assert out.count("\n>") == 1
    assert "(--common compares what both have, --until T the first T of it)" in out
    assert data(a, b, "--common")["equal"]
    assert data(a, b, "--until", "6ms")["equal"]
    assert data(a, b, "--until", "9ms")["equal"]
    assert not data(a, b, "--until", "10ms")["equal"]
    assert "\nA goes on for 84 ms after that\n" in diff(a, b, "--common")[1]
    assert diff(a, b, "--until", "5ms", "--common")[0] == 0


def test_a_capture_that_ends_with_its_last_change_is_complete_where_nothing_follows(write, pins, data):
    assert data(pins("a.jsonl", STEPS), write("b.csv", TABLE.replace("0.5291", "0.529").replace(
        "0.600000,0,1\n", "")), *MAP)["equal"]  # fmt: skip
