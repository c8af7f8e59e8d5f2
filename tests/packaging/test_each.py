"""A table that is checked in one test says which row is wrong, and leaves none out."""

from __future__ import annotations

import pytest

from tests.each import each


def checked(test):
    """Return what a test ends with, and what is noted about it."""
    try:
        test()
    except BaseException as error:  # of pytest's own, too
        return type(error), getattr(error, "__notes__", [])
    return None, []


def test_every_row_is_checked():
    seen = []

    @each(("a", "b"), iter([(1, "x"), (2, "y")]))
    def test(a, b):
        seen.append((a, b))

    assert (checked(test), checked(test)) == ((None, []), (None, []))
    assert seen == [(1, "x"), (2, "y")] * 2


def test_a_failure_names_its_row():
    @each("a", [1, 2])
    def asserts(a):
        assert a == 1

    @each("a", [1, 2])
    def raises(a):
        if a == 2:
            with pytest.raises(ValueError, match="2"):
                pass

    assert checked(asserts) == (AssertionError, ["in the row a=2"])
    assert checked(raises) == (pytest.fail.Exception, ["in the row a=2"])


def test_a_row_that_is_skipped_does_not_hide_the_others():
    @each("a", [1, 2])
    def test(a):
        if a == 1:
            pytest.skip("not here")

    error, notes = checked(test)
    assert error is pytest.fail.Exception
    assert notes == ["in the row a=1"]


def test_what_would_check_nothing_is_refused():
    with pytest.raises(ValueError, match="without rows"):
        each("a", [])

    async def never_awaited(a):
        raise AssertionError(a)

    def never_begun(a):
        yield a

    for test in (never_awaited, never_begun):
        with pytest.raises(TypeError, match=r"never_\w+ does nothing when it is called"):
            each("a", [1])(test)


def test_a_row_with_a_mark_would_lose_it():
    with pytest.raises(TypeError, match="take parametrize"):
        each("a", [1, pytest.param(2, marks=pytest.mark.slow("why"))])
