"""A change is judged by the same examples whenever, and after whatever, its tests are run."""

from __future__ import annotations

import importlib.util
import os
import sys

import pytest
from hypothesis import given, settings, strategies

NUMBER = 918_273_645_546_372_819


@pytest.mark.skipif("HILBENCH_SEARCH" in os.environ, reason="a search may use whatever it finds")
def test_a_module_that_is_loaded_changes_no_example(tmp_path, monkeypatch):
    drawn = []

    @settings(max_examples=100)
    @given(strategies.lists(strategies.integers(), min_size=20))
    def draw(numbers):
        drawn.append(numbers)

    draw()
    before, drawn[:] = list(drawn), []
    (tmp_path / "numbers_of_a_user.py").write_text("\n".join(f"N{n} = {NUMBER + n}" for n in range(200)))
    spec = importlib.util.spec_from_file_location("numbers_of_a_user", tmp_path / "numbers_of_a_user.py")
    monkeypatch.setitem(sys.modules, spec.name, importlib.util.module_from_spec(spec))
    draw()
    assert len(before) == 100
    assert drawn == before
