"""What is left of faults and stimuli: what it takes for a clause to fail, and no more."""

from __future__ import annotations

import random

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.campaign.shrinking import Shrinker
from hilbench.cli import main

BENCH = """
version = 1
[world]
physics = "plane"
[targets.robot]
model = "pioneer-2dx"
[[links]]
ends = ["peer", "robot.host"]
baud = 9600
"""
LOST = '[[faults]]\nkind = "drop"\nfrom = "peer"\nbyte = {0}\ncount = 3\n'
DROP = "faults=[{ kind = 'drop', byte = 0 }]"
LATE = '[[faults]]\nkind = "delay"\nfrom = "peer"\nbyte = {0}\nduration_s = 0.12\n'


@given(st.integers(1, 60), st.data())
def test_what_is_planted_is_what_is_left(size, data):
    planted = data.draw(st.sets(st.integers(0, size - 1), max_size=4))
    split = data.draw(st.integers(0, size))
    entries = {"faults": list(range(split)), "stimuli": list(range(split, size))}
    shrinker = Shrinker(lambda left: planted <= {*left["faults"], *left["stimuli"]})
    left = shrinker.shrink(entries)
    assert [*left["faults"], *left["stimuli"]] == sorted(planted)
    assert left["faults"] == [entry for entry in sorted(planted) if entry < split]
    assert shrinker.runs <= size**2 + 3 * size + 1  # the bound of the paper for ddmin, and one run with nothing


@given(st.integers(1, 20), st.integers(0, 2**32))
def test_whatever_fails_nothing_of_what_is_left_can_be_left_out(size, seed):
    def fails(left):
        chosen = tuple(left["faults"])
        return len(chosen) == size or random.Random(f"{seed} {chosen}").random() < 0.3

    left = Shrinker(fails).shrink({"faults": list(range(size))})["faults"]
    assert fails({"faults": left})
    assert len(left) <= 1 or not any(fails({"faults": left[:at] + left[at + 1 :]}) for at in range(len(left)))


def test_counts_and_durations_become_as_small_as_they_can():
    entries = [{"kind": "noise", "count": 50}, {"kind": "delay", "duration_s": 0.8}]

    def fails(left):
        found = {entry["kind"]: entry for entry in left["faults"]}
        return found.get("noise", {}).get("count", 0) >= 10 and found.get("delay", {}).get("duration_s", 0) >= 0.3

    assert Shrinker(fails).shrink({"faults": entries}) == {
        "faults": [{"kind": "noise", "count": 12}, {"kind": "delay", "duration_s": 0.4}]
    }
    assert entries[0]["count"] == 50


def bench_with(planted, seed, among):
    """Return a bench file with so many faults, of which the planted ones alone come while S01 runs."""
    chance = random.Random(seed)
    kinds, ends = ("drop", "noise", "duplicate"), ("peer", "robot.host")
    faults = [
        f'[[faults]]\nkind = "{chance.choice(kinds)}"\nfrom = "{chance.choice(ends)}"\n'
        f"byte = {chance.randrange(5000, 60000)}\ncount = {chance.randrange(1, 50)}\n"
        for _ in range(among - len(planted))
    ]
    for text in planted:
        faults.insert(chance.randrange(len(faults) + 1), text)
    return BENCH + "".join(faults)


def shrunk(tmp_path, capsys, planted, seed, among=30):
    file, small = tmp_path / "b.toml", tmp_path / "small.toml"
    file.write_text(bench_with(planted, seed, among))
    assert main(["shrink", str(file), "-k", "S01", "--write", str(small)]) == 0
    said = capsys.readouterr().out.splitlines()
    assert main(["check", str(small), "-k", "S01", "-q"]) == 1
    capsys.readouterr()
    return said, small.read_text()


@pytest.mark.slow("runs a check ten times")
def test_two_that_fail_only_together_are_found_among_four(tmp_path, capsys):
    said, small = shrunk(tmp_path, capsys, [LATE.format(0), LATE.format(4)], 1, among=4)
    assert said[0].startswith("S01 fails with 2 of 4 entries; ")
    assert said[-1].startswith("hilbench check ")
    assert small.count("[[faults]]") == small.count("delay") == 2


@pytest.mark.exhaustive("twenty benches; the gate has one, and lists of all kinds in memory")
def test_one_or_two_are_found_among_thirty_in_all_of_twenty_benches(tmp_path, capsys):
    for seed in range(20):
        planted = [LATE.format(0), LATE.format(4)] if seed < 2 else [LOST.format(seed % 5)]
        said, small = shrunk(tmp_path, capsys, planted, seed)
        assert small.count("[[faults]]") == len(planted), (seed, said)
        assert small.count("delay" if seed < 2 else "drop") == len(planted), (seed, said)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["-k", "S01"], "has no faults and no stimuli to leave out; it takes a bench with [[faults]]"),
        (["-k", "S01", "--set", "faults=[{ kind = 'drop', byte = 90000 }]"], "no clause fails"),
        (["-k", "S01", "--set", DROP, "--clause", "S20"], "S20 does not fail here; these do: S01"),
        (["-k", "no_such_case", "--set", DROP], "nothing is selected"),
        (["--set", "faults=[{ kind = 'drip' }]"], "--set faults=[{ kind = 'drip' }]: 'faults[0].kind'"),
    ],
)  # fmt: skip
def test_what_cannot_be_reduced_is_one_line(words, said, capsys):
    assert main(["shrink", "pioneer-plane", *words]) == 2
    lines = capsys.readouterr().err.splitlines()
    assert len(lines) == 1
    assert said in lines[0]


def test_a_bench_whose_paths_lead_nowhere_from_there_is_not_left_behind(tmp_path, capsys):
    (tmp_path / "plain.py").write_text("")
    file = tmp_path / "b.toml"
    file.write_text(BENCH.replace("version = 1", 'version = 1\nsuites = ["plain.py", "p2os-server"]') + LOST.format(0))
    (tmp_path / "sub").mkdir()
    small = tmp_path / "sub" / "small.toml"
    assert main(["shrink", str(file), "--suite", "p2os-server", "-k", "S01", "--write", str(small)]) == 2
    said = capsys.readouterr()
    assert "S01 fails with 1 of 1 entries" in said.out
    assert f"its paths are relative to {tmp_path}: write it there" in said.err
    assert not small.exists()
    small.write_text("mine")
    assert main(["shrink", str(file), "--suite", "p2os-server", "-k", "S01", "--write", str(small)]) == 2
    assert small.read_text() == "mine"
    assert [one.name for one in small.parent.iterdir()] == ["small.toml"]


def test_a_clause_that_fails_only_after_other_cases_is_reduced_with_them(tmp_path, capsys):
    (tmp_path / "mine.py").write_text(
        "from hilbench.check import case\nbefore = []\n"
        '@case("X1", text="One.", source="us")\ndef test_one(peer): before.append(1)\n'
        '@case("X2", text="Two.", source="us")\ndef test_two(peer): assert not before\n'
    )
    words = ["--suite", str(tmp_path / "mine.py"), "--set", DROP]
    assert main(["shrink", "pioneer-plane", *words]) == 0
    assert capsys.readouterr().out.startswith("X2 fails without any of the 1 entries")


def test_a_duration_in_whole_seconds_is_halved_too():
    def fails(left):
        return bool(left["faults"]) and left["faults"][0]["duration_s"] >= 0.3

    assert Shrinker(fails).shrink({"faults": [{"duration_s": 2}]}) == {"faults": [{"duration_s": 0.5}]}
