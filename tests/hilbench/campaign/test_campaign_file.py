"""Which points a campaign file means, and what is said of one that is wrong."""

from __future__ import annotations

import math
import textwrap

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.campaign.campaign_file import Range, read_campaign
from hilbench.campaign.point import command_of, key_of, options_of
from hilbench.errors import UsageError

HEAD = 'version = 1\nbench = "pioneer-plane"\n'


@pytest.fixture
def points(tmp_path):
    def read(text):
        file = tmp_path / "c.toml"
        file.write_text(textwrap.dedent(text))
        return read_campaign(file).points

    return read


def test_seeds_benches_and_levels_are_combined_in_order(points):
    found = points("""
        version = 1
        bench = ["pioneer", "pioneer-plane"]
        seeds = [7, 3]
        select = "S36"
        [set]
        "world.scene" = "corridor"
        [factors]
        "faults.0.probability" = [0.1, 0.2]
        [factors.firmware]
        old = { "targets.a.firmware" = "old.elf", "targets.a.base" = 1 }
        new = {}
    """)
    assert len(found) == 2 * 2 * 2 * 2
    first, last = found[0], found[-1]
    assert (first.bench, first.seed, first.select) == ("pioneer", 7, "S36")
    assert first.changes == (
        "world.scene=corridor", "faults.0.probability=0.1", "targets.a.firmware=old.elf", "targets.a.base=1",
    )  # fmt: skip
    assert first.levels == {"bench": "pioneer", "faults.0.probability": 0.1, "firmware": "old"}
    assert (last.bench, last.seed, last.changes[1:]) == ("pioneer-plane", 3, ("faults.0.probability=0.2",))


def test_a_point_is_a_command_that_means_the_same(points):
    (point,) = points(HEAD + 'select = "S01 or S36"\n[set]\n"a.b" = [1, "x y", { c = true }]\n"d" = "1"')
    assert command_of(point) == (
        """hilbench check pioneer-plane --set 'a.b=[1, "x y", { c = true }]' --set 'd="1"' -k 'S01 or S36' --seed 0"""
    )
    assert [change.value for change in options_of(point).changes] == [[1, "x y", {"c": True}], "1"]


def test_paths_are_those_beside_the_file_and_names_are_names(points, tmp_path):
    (point,) = points('version = 1\nbench = "sub/b.toml"\nsuites = ["p2os-server", "mine.py"]')
    assert point.bench == str(tmp_path / "sub/b.toml")
    assert point.suites == ("p2os-server", str(tmp_path / "mine.py"))


def test_a_hypercube_has_one_value_in_each_part_of_a_range(points):
    pytest.importorskip("scipy")
    text = HEAD + "[factors]\na = { low = 0.0, high = 1.0 }\nb = { low = 1, high = 20 }\n[draw]\nsamples = 20"
    found = points(text)
    assert sorted(math.floor(point.levels["a"] * 20) for point in found) == list(range(20))
    assert sorted(point.levels["b"] for point in found) == list(range(1, 21))
    assert points(text) == found
    assert points(f"{text}\nseed = 1") != found


def test_drawn_at_random_needs_no_library_and_is_the_same_again(points):
    drawn = '[factors]\na = { low = 0.001, high = 1.0, scale = "log" }\n[draw]\nmethod = "random"\nsamples = 50'
    text = f"{HEAD}seeds = 2\n{drawn}"
    found = points(text)
    assert len(found) == 100
    assert points(text) == found
    values = [point.levels["a"] for point in found]
    assert all(0.001 <= value <= 1 for value in values)
    assert values[:50] == values[50:]
    assert sum(value < 0.0316 for value in values) in range(30, 70)


@given(st.integers(-50, 50), st.integers(1, 50), st.floats(0, 1, exclude_max=True))
def test_whole_numbers_are_drawn_within_both_ends(low, width, share):
    value = Range(low=low, high=low + width).at(share)
    assert isinstance(value, int)
    assert low <= value <= low + width


@given(st.floats(1e-6, 1e6), st.floats(1.001, 1e6), st.floats(0, 1, exclude_max=True))
def test_values_on_a_log_scale_stay_within_the_range(low, factor, share):
    value = Range(low=low, high=low * factor, scale="log").at(share)
    assert low * (1 - 1e-5) <= value <= low * factor * (1 + 1e-5)


WRONG = {
    "nonsense = 1": ":3: unknown key 'nonsense'",
    "seeds = 0": ":3: 'seeds': must be",
    "seeds = []": "means 0 points",
    "seeds = 1000000\n[factors]\na = [1, 2]": "means 2000000 points; 1 to 1000000",
    "[factors]\na = 1": ":4: 'a' has no levels; [1, 2, 3]",
    "[factors]\na = []": ":4: 'a' has no levels",
    "[factors]\nbench = [1]": ":4: is a name of its own",
    "[factors]\na = { low = 1, high = 2 }": ":4: 'a' is a range to draw from; [draw] with samples = 100",
    "[draw]\nsamples = 3": ":3: there is no range to draw from",
    "[factors]\na = { low = 2, high = 1 }\n[draw]\nsamples = 2": ":4: ",
    '[factors]\na = { low = 0, high = 1, scale = "log" }\n[draw]\nsamples = 2': ":4: ",
    "[factors]\na = { low = 0, hihg = 1 }\n[draw]\nsamples = 2": ":4: ",
    '[factors]\n"a b" = [1]': ":4: ",
    '[set]\n"a b" = 1': ":4: ",
}


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_is_one_line_with_its_place(points, text):
    with pytest.raises(UsageError) as caught:
        points(HEAD + text)
    assert "c.toml" in str(caught.value)
    assert WRONG[text] in str(caught.value)
    assert "\n" not in str(caught.value)


def test_a_key_depends_on_what_is_run_and_not_on_how_it_is_called(points):
    one, other, third = points(HEAD + "[factors.x]\na = { b = 1 }\nc = { b = 2 }\nd = {b = 1}")
    assert key_of(one, ["f"]) == key_of(third, ["f"]) != key_of(other, ["f"])
    assert key_of(one, ["f"]) != key_of(one, ["g"])
    assert key_of(one, ["f", "g"]) != key_of(one, ["g", "f"])  # two boards with each other's firmware
