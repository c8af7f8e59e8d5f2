"""Data that is written as TOML is read as the same data."""

from __future__ import annotations

import tomllib

from hypothesis import given
from hypothesis import strategies as st

from hilbench.strict.toml_writer import toml_text

texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=6)
plain = st.one_of(st.integers(-(2**63), 2**63 - 1), st.floats(allow_nan=False), st.booleans(), texts)
values = st.recursive(
    plain, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3), max_leaves=12
)
tables = st.dictionaries(texts, values, max_size=5)


@given(tables)
def test_it_is_read_back(data):
    assert tomllib.loads(toml_text(data)) == data


def test_it_is_written_as_a_person_would():
    data = {
        "version": 1,
        "targets": {"robot": {"model": "m", "settings": {"a b": 0.5}}},
        "faults": [{"kind": "drop", "from": "peer"}, {"kind": "flip"}],
        "none": {},
        "list": [],
    }
    assert toml_text(data) == (
        'version = 1\nnone = {}\nlist = []\n\n[targets.robot]\nmodel = "m"\n\n[targets.robot.settings]\n"a b" = 0.5\n'
        '\n[[faults]]\nkind = "drop"\nfrom = "peer"\n\n[[faults]]\nkind = "flip"\n'
    )
