"""A table checked in one test.

`pytest.mark.parametrize` makes a test of each row, which costs more to collect than most rows take to be checked. It is
right where rows need fixtures of their own, or marks; and where one may be skipped, which here fails.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Sequence
from typing import Any

import pytest
from _pytest.mark.structures import ParameterSet


def each(names: str | Sequence[str], rows: Iterable[Any]) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Call a test with every row of a table; the message of a failure names the row.

    Args:
        names: of the arguments, as for `parametrize`.
        rows: one value, or for several names a sequence of values, each.
    """
    given = [name.strip() for name in names.split(",")] if isinstance(names, str) else list(names)
    rows = [*rows]
    if any(isinstance(row, ParameterSet) for row in rows):
        message = f"a row of {', '.join(given)} has a mark or an id of its own, take parametrize"
        raise TypeError(message)
    table = [(row,) if len(given) == 1 else tuple(row) for row in rows]
    if not table:
        message = f"a table of {', '.join(given)} without rows checks nothing"
        raise ValueError(message)

    def decorate(test: Callable[..., None]) -> Callable[..., None]:
        if inspect.iscoroutinefunction(test) or inspect.isgeneratorfunction(test):
            message = f"{test.__name__} does nothing when it is called"
            raise TypeError(message)

        @functools.wraps(test)
        def over_rows(*others: object, **fixtures: object) -> None:
            for row in table:
                of_row = dict(zip(given, row, strict=True))
                try:
                    _check(test, *others, **fixtures, **of_row)
                except (Exception, pytest.fail.Exception) as error:  # what `pytest.raises` misses is no Exception
                    error.add_note("in the row " + ", ".join(f"{name}={value!r}" for name, value in of_row.items()))
                    raise

        signature = inspect.signature(test)
        rest = [one for name, one in signature.parameters.items() if name not in given]
        over_rows.__signature__ = signature.replace(parameters=rest)  # type: ignore[attr-defined]
        return over_rows

    return decorate


def _check(test: Callable[..., None], *others: object, **arguments: object) -> None:
    """Check a row; one that is skipped would take those behind it along."""
    try:
        test(*others, **arguments)
    except pytest.skip.Exception as error:
        pytest.fail(f"a row cannot be skipped, take parametrize: {error}")
