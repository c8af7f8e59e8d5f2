"""Figures that a time or a count cannot be."""

from __future__ import annotations

import math
from types import SimpleNamespace

import pytest

from protocols.common.options import check_positive
from tests.each import each


@each("value, why", [(0, "not above 0"), (-1.5, "not above 0"), (math.nan, "not above 0"), (math.inf, "not finite")])
def test_a_figure_that_cannot_be_is_refused_by_name(value, why):
    with pytest.raises(ValueError, match=f"limit_s is {value}, {why}"):
        check_positive(ValueError, SimpleNamespace(limit_s=value), ("limit_s",))


def test_a_figure_above_0_or_none_is_taken():
    check_positive(ValueError, SimpleNamespace(limit_s=1e-9, other_s=None), ("limit_s", "other_s"))
