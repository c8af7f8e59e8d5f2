"""`hilbench diff`: what counts as equal, where two recordings part, and how that is said."""

from __future__ import annotations

import pytest

pytestmark = pytest.mark.usefixtures("keep_signals")

STEPS = [(1, "PB7", False), (1, "PB6", False), (10, "PB7", True), (20, "PB6", True), (30, "PB7", False)]


def moved(edges, by_ms):
    return [(at_ms + by_ms, pin, level) for at_ms, pin, level in edges]


def test_the_same_is_equal(pins, diff):
    code, out, err = diff(pins("a.jsonl", STEPS), pins("b.jsonl", STEPS))
    assert (code, err) == (0, "")
    assert "  brain.PB7       3       3       3  0 ns, 0 ns\n" in out
    assert out.endswith("equal: 2 signals, all changes at the same times\n")


def test_times_count_from_the_first_change_in_common(pins, data):
    found = data(pins("a.jsonl", STEPS), pins("b.jsonl", moved(STEPS, 7), end_ms=120))
    assert found["equal"]
    assert found["aligned_on"] == {
        "signal": "brain.PB6", "a_ns": 1_000_000, "b_ns": 8_000_000, "a": False, "b": False, "late_ns": 7_000_000,
    }  # fmt: skip
    assert found["compared_ns"] == 99_000_000


def test_a_change_at_another_time_is_a_difference_beyond_the_tolerance(pins, diff, data):
    late = [*STEPS[:3], (20.5, "PB6", True), STEPS[4]]
    files = pins("a.jsonl", STEPS), pins("b.jsonl", late)
    found = data(*files, "--tolerance", "400us")
    assert found["first"]["kind"] == "time"
    assert found["first"]["text"] == "brain.PB6 -> 1 comes 500 us later in B than in A"
    assert found["signals"][0]["largest_late_ns"] == 500_000
    assert found["signals"][0]["median_late_ns"] == 250_000
    assert data(*files, "--tolerance", "500us")["equal"]
    assert data(*files, "--order-only")["equal"]
    _, out, _ = diff(*files)
    assert ">      0.020000000       0.020500000       +500 us  brain.PB6 -> 1\n" in out


def test_the_first_difference_is_shown_with_what_is_around_it(pins, data):
    less = [edge for edge in STEPS if edge[0] != 20]
    found = data(pins("a.jsonl", STEPS), pins("b.jsonl", less))
    assert found["first"]["text"] == "brain.PB6 -> 1 is missing in B"
    assert [(row["signal"], row["a_ns"], row["b_ns"]) for row in found["around"]][-2:] == [
        ("brain.PB6", 20_000_000, None),
        ("brain.PB7", 30_000_000, 30_000_000),
    ]
    assert data(pins("a.jsonl", less), pins("b.jsonl", STEPS))["first"]["kind"] == "missing in A"


def test_a_pin_that_is_quiet_in_one_journal_has_no_changes_there(pins, data):
    found = data(pins("a.jsonl", STEPS), pins("b.jsonl", [*STEPS, (40, "PC13", True)]))
    assert found["first"]["text"] == "brain.PC13 -> 1 is missing in A"


def test_what_comes_after_the_end_of_the_shorter_one_is_not_compared(pins, data):
    files = pins("a.jsonl", STEPS), pins("b.jsonl", [*STEPS, (60, "PB7", True)])
    assert not data(*files)["equal"]
    assert data(pins("a.jsonl", STEPS, end_ms=59), files[1])["equal"]
    assert data(pins("a.jsonl", STEPS, end_ms=61), files[1], "--tolerance", "2ms")["equal"]


def test_reversed_order_of_two_pins_is_a_difference_of_order(pins, data):
    other = [(1, "PB7", False), (1, "PB6", False), (10, "PB6", True), (20, "PB7", True), (30, "PB7", False)]
    files = pins("a.jsonl", STEPS), pins("b.jsonl", other)
    found = data(*files, "--order-only")
    assert found["first"]["text"] == "brain.PB6 -> 1 comes after brain.PB7 -> 1 in A, before it in B"
    assert data(*files, "--order-only", "--pins", "PB7")["equal"]
    assert data(*files, "--order-only", "--tolerance", "10ms")["equal"]


def test_changes_at_the_same_time_are_in_no_order(pins, data):
    together = [(1, "PA1", False), (1, "PA2", False), (5, "PA1", True), (5, "PA2", True)]
    apart = [(1, "PA1", False), (2, "PA2", False), (5, "PA2", True), (6, "PA1", True)]
    assert data(pins("a.jsonl", together), pins("b.jsonl", apart), "--order-only")["equal"]


@pytest.mark.parametrize("pattern", ["PB7", "brain.PB7", "*7"])
def test_patterns_choose_signals(pins, data, pattern):
    found = data(pins("a.jsonl", STEPS), pins("b.jsonl", STEPS), "--pins", pattern)
    assert [signal["name"] for signal in found["signals"]] == ["brain.PB7"]


def test_words_count_when_they_change_and_bytes_one_by_one(journal, data):
    def word(at_ms, code):
        about = {"name": "MotorWord", "value": {"raw": code & 7, "code": code, "at_ns": at_ms * 1_000_000}}
        return (at_ms, "event", "motor_left", about)

    sent = (12, "tx", "brain.usart1", {"data": b"on", "from_ns": 3_000_000})
    a = journal("a.jsonl", [word(10, 3), word(20, 3), word(30, -4), sent])
    b = journal("b.jsonl", [word(10, 3), word(20, -4), word(30, -4), sent])
    found = data(a, b, "--tolerance", "10ms")
    assert found["equal"]
    assert {signal["name"]: signal["agree"] for signal in found["signals"]} == {
        "brain.usart1 tx": 2,
        "motor_left word": 2,
    }
    assert data(a, b)["first"]["text"] == "motor_left word -> -4 comes 10 ms earlier in B than in A"
    other = journal("c.jsonl", [(12, "tx", "brain.usart1", {"data": b"of", "from_ns": 3_000_000})])
    assert data(a, other)["first"]["text"] == "brain.usart1 tx -> 6e in A, -> 66 in B"


def test_edges_that_were_summarised_are_compared_as_summaries_and_that_is_said(journal, data, diff):
    def fast(high_ns):
        edges = [(1 + at, "pin", "brain.PA8", {"level": bool(at % 2)}) for at in range(20)]
        about = {"period_ns": 50_000, "high_ns": high_ns, "edges": 3000, "in_ns": 100_000_000, "level": True}
        return [*edges, (120, "pwm", "brain.PA8", about), (121, "pin", "brain.PA8", {"level": False})]

    a, b = journal("a.jsonl", fast(25_000), end_ms=200), journal("b.jsonl", fast(10_000), end_ms=200)
    found = data(a, b)
    assert found["first"]["signal"] == "brain.PA8 pwm"
    assert [signal["remark"] for signal in found["signals"]] == [
        "too fast: A and B summarise its edges; compared for 0.019 s",
        "",
    ]
    assert found["signals"][0]["a"] == 19
    _, out, _ = diff(a, a)
    assert "in part only: brain.PA8: too fast: A and B summarise its edges" in out


def test_a_case_of_a_journal_of_checks_is_a_recording_of_its_own(tmp_path, data, diff):
    from hilbench.journal import Journal

    path = str(tmp_path / "check.jsonl")
    log = Journal(path, {"bench": "test"})
    for case, late in (("s/one", 0), ("s/two", 5)):
        log.begin_case(case, 0)
        log.record("pin", "brain.PB7", 1000, level=False)
        log.record("pin", "brain.PB7", 2000 + late, level=True)
        log.end_case(9000)
    log.close()
    code, _, err = diff(path, path)
    assert (code, err) == (2, f"hilbench: {path}: has a bench for each case; choose one with --case: s/one, s/two\n")
    assert diff(path, path, "--case", "s/on")[2].endswith("has no case 's/on'; did you mean 's/one'?\n")
    assert data(path, path, "--case", "s/one")["equal"]
    found = data(path, path, "--case", "s/one", "--case", "s/two")
    assert found["first"]["late_ns"] == 5
    assert found["b"]["file"] == f"{path} s/two"


def test_a_journal_that_was_cut_is_compared_up_to_there(pins, data):
    a, b = pins("a.jsonl", STEPS), pins("b.jsonl", STEPS)
    with open(b, "r+b") as file:
        file.truncate(len(file.read()) - 90)
    found = data(a, b)
    assert found["first"]["text"].startswith("B ends ")
    assert found["b"]["remarks"] == ["cut in line 6: compared up to there"]
    assert data(a, b, "--common")["equal"]


def test_a_journal_of_a_process_that_was_killed_does_not_say_that_it_is_complete(pins, data):
    a, b = pins("a.jsonl", STEPS), pins("b.jsonl", STEPS[:4])
    with open(b) as file:
        lines = file.readlines()
    with open(b, "w") as file:
        file.writelines(lines[:-1])
    assert data(a, b)["first"]["kind"] == "end"
    assert data(a, b, "--common")["equal"]


def test_journals_that_hardly_overlap_are_different(pins, data):
    late = [(80, "PB7", True), (85, "PB7", False), (88, "PB7", True)]
    files = pins("a.jsonl", late), pins("b.jsonl", [*moved(late, -79), (50, "PB7", False)])
    assert data(*files)["first"]["kind"] == "end"
    assert data(*files, "--common")["equal"]


def test_one_change_has_no_time_to_compare_and_that_is_said(pins, diff):
    code, out, _ = diff(pins("a.jsonl", [(9, "PB7", True)]), pins("b.jsonl", [(70, "PB7", True)]))
    assert code == 0
    assert out.endswith("but that is one change, at which they are laid over each other: no time was compared\n")


def test_two_boards_that_do_nothing_are_nothing_to_compare(pins, diff):
    files = pins("a.jsonl", STEPS), pins("b.jsonl", moved(STEPS, 200), end_ms=300)
    assert diff(*files, "--until", "1ms")[0] == 0
    quiet = pins("c.jsonl", [(60, "PB7", True)], end_ms=80), pins("d.jsonl", [(90, "PB7", False)], end_ms=95)
    assert diff(*quiet, "--until", "1ms")[::2] == (
        2, "hilbench: nothing to compare: no change of any signal is in both recordings, which were compared for 1 ms\n"
    )  # fmt: skip


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("a.jsonl", "diff: B is missing"),
        ("a.jsonl a.jsonl --pins PX", "--pins PX: matches no signal; they have: brain.PB6, brain.PB7"),
        (
            "a.jsonl a.jsonl --pins PB6 --pins brian.PB7",
            "--pins brian.PB7: matches no signal; did you mean 'brain.PB7'?",
        ),
        ("a.jsonl a.jsonl --pins PB6 --pins PB77", "--pins PB77: matches no signal; did you mean 'PB7'?"),
        ("a.jsonl other.jsonl --pins PB6", "--pins PB6: no signal that both recordings have; they have brain.PB6, "),
        ("a.jsonl a.jsonl --until 3", "--until: '3' is not a duration"),
        ("a.jsonl a.jsonl --map D0", "--map: 'D0' is not NAME=NET, such as D0=brain.PB7"),
        ("a.jsonl a.jsonl --map D0=brain.PB7", "--map D0=brain.PB7: no column 'D0'; only captures have columns"),
        ("a.jsonl a.jsonl --map D0=x --map D0=y", "--map: names a column twice"),
        ("a.jsonl a.jsonl --case s/one", "--case s/one: is no case of these recordings"),
        ("a.jsonl a.jsonl --case 1 --case 2 --case 3", "--case: more than two cases for two recordings"),
        ("a.jsonl a.jsonl --tolerance 3", "--tolerance: '3' is not a duration"),
        ("a.jsonl other.jsonl", "diff: nothing to compare in these recordings; A has brain.PB6, brain.PB7, B"),
    ],
)
def test_wrong_usage_is_one_line_and_2(pins, journal, diff, words, said, tmp_path, monkeypatch):
    pins("a.jsonl", STEPS)
    journal("other.jsonl", [(1, "pin", "left.PA0", {"level": True})], board="left")
    monkeypatch.chdir(tmp_path)
    code, out, err = diff(*words.split())
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"hilbench: {said}")
