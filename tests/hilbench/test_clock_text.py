"""Times and factors as people read them."""

from __future__ import annotations

from hilbench.clock.text import factor_text, seconds_text
from tests.each import each


@each(
    ("time_s", "text"),
    [
        (0, "0 s"),
        (0.000_004, "0.004 ms"),
        (0.000_82, "0.82 ms"),
        (0.0098, "9.8 ms"),
        (0.009_96, "10 ms"),
        (0.0352, "35 ms"),
        (0.0994, "99 ms"),
        (0.0996, "0.1 s"),
        (6.29, "6.3 s"),
        (99.9, "99.9 s"),
        (99.96, "100 s"),
        (1234.5, "1234 s"),
    ],
)
def test_a_time_has_as_many_digits_as_say_something(time_s, text):
    assert seconds_text(time_s) == text


@each(("factor", "text"), [(0, "0.0"), (0.0252, "0.025"), (0.5, "0.5"), (12.34, "12.3"), (412.3, "412")])
def test_so_does_a_factor(factor, text):
    assert factor_text(factor) == text
