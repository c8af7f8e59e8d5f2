"""The hint after a wrong name: the nearest right one, or all of them."""

from __future__ import annotations

import difflib
from collections.abc import Iterable


def did_you_mean(name: str, known: Iterable[str], these: str = "known") -> str | None:
    """Return a hint for somebody who wrote a name that does not exist.

    Args:
        name: what was written.
        known: the names that exist.
        these: what to call them where none is near, as in ``shipped suites``.

    Returns:
        ``did you mean 'x'?`` where one is near, else the list of them; None if there are none.
    """
    names = list(known)
    found = nearest(name, names)
    if found is not None:
        return f"did you mean '{found}'?"
    return f"{these}: {', '.join(names)}" if names else None


def nearest(name: str, known: Iterable[str]) -> str | None:
    """Return the name that somebody may have meant; None if none is near. The dashes of options make none near."""
    written = _bare(name)
    by_case = {_bare(one): one for one in known}
    # A name that goes on, as order codes of chips do, means what it begins with.
    begun = [one for one in by_case if written.startswith(one) and 2 * len(one) > len(written)]
    found = sorted(begun, key=len)[-1:] or difflib.get_close_matches(written, by_case, n=1, cutoff=0.55)
    return by_case[found[0]] if found else None


def _bare(name: str) -> str:
    return name.lower().lstrip("-")
