"""What ``--set`` puts in the place of what stands in a file."""

from __future__ import annotations

import copy

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hilbench.errors import UsageError
from hilbench.strict.changes import Change, apply, parse_change
from tests.each import each

DATA = {"world": {"scene": "empty"}, "faults": [{"kind": "drop"}, {"kind": "flip"}], "seed": 1}

keys = st.text("abcdefghij_-", min_size=1, max_size=5)
values = st.one_of(st.integers(-9, 9), st.text("ab c", max_size=4), st.booleans())


def changed(*texts):
    data = copy.deepcopy(DATA)
    apply(data, [parse_change(text) for text in texts])
    return data


def test_values_are_those_of_toml_and_what_is_none_is_a_text():
    rows = {
        "a=1": 1,
        "a = 0.5": 0.5,
        "a=true": True,
        'a="1"': "1",
        "a=[1, 2]": [1, 2],
        "a={ b = 1 }": {"b": 1},
        "a=corridor": "corridor",
        "a=my file.elf": "my file.elf",
        "a=": "",
        "a=x=y": "x=y",
        "a=1\nb=2": "1\nb=2",
    }
    for text, value in rows.items():
        assert parse_change(text).value == value, text


def test_keys_are_those_of_toml():
    assert parse_change("a.b.c=1").path == ("a", "b", "c")
    assert parse_change('a."b.c".0=1').path == ("a", "b.c", "0")


@each("text", ["", "a", "=1", "a.=1", ".a=1", "a b=1", "[a]=1", "a\nb=1", "#=1"])
def test_what_is_no_change_is_refused(text):
    with pytest.raises(ValueError, match=r"KEY=VALUE|key"):
        parse_change(text)


def test_tables_and_entries_of_lists_are_changed_made_and_put_at_the_end():
    assert changed("world.scene=wall")["world"] == {"scene": "wall"}
    assert changed("world.friction.wheel=2")["world"] == {"scene": "empty", "friction": {"wheel": 2}}
    assert changed("faults.1.kind=noise")["faults"] == [{"kind": "drop"}, {"kind": "noise"}]
    assert changed("faults.2.kind=noise", "faults.2.count=3")["faults"][2] == {"kind": "noise", "count": 3}
    assert changed("faults.0={ kind = 'noise' }")["faults"] == [{"kind": "noise"}, {"kind": "flip"}]
    assert changed("links.0.ends=['a', 'b']")["links"] == [{"ends": ["a", "b"]}]
    assert changed("faults=[]")["faults"] == []


def test_what_leads_nowhere_is_one_line():
    rows = {
        "seed.x=1": "--set seed.x=1: 'x' is looked for in what is neither a table nor a list",
        "faults.kind=x": "--set faults.kind=x: 'kind' is looked for in a list; name its entry: 0 is the first",
        "faults.3.kind=x": "--set faults.3.kind=x: there is no entry 3: the list has 2",
    }
    for text, said in rows.items():
        with pytest.raises(UsageError) as caught:
            changed(text)
        assert str(caught.value) == said


@given(st.lists(keys, min_size=1, max_size=4), values)
def test_a_change_is_read_back_and_does_what_it_says(path, value):
    change = Change(tuple(path), value, "")
    data: dict[str, object] = {}
    apply(data, [change])
    at: object = data
    for part in path:
        at = at[part]  # type: ignore[index]
    assert at == value


@given(st.lists(keys, min_size=1, max_size=4), st.text(max_size=20))
def test_no_text_breaks_the_reading(path, text):
    assert parse_change(f"{'.'.join(path)}={text}").path == tuple(path)


@given(st.text(max_size=30))
def test_whatever_is_written_is_read_or_refused(text):
    try:
        change = parse_change(text)
    except ValueError:
        return
    assert change.path
    assert change.canonical() == parse_change(text).canonical()


def test_a_change_is_the_same_after_it_was_made():
    changes = [parse_change("faults=[]"), parse_change("faults.0.kind=drop")]
    before = [change.canonical() for change in changes]
    apply({}, changes)
    assert [change.canonical() for change in changes] == before


def test_brackets_without_end_are_refused():
    for text in (f"a={'[' * 20_000}", f"a={'{a=' * 20_000}"):
        with pytest.raises(ValueError, match="too many nested brackets"):
            parse_change(text)
