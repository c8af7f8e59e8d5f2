"""The bench that a person has chosen in the settings."""

from __future__ import annotations

from hilbench.benchfile.reader import DEFAULT_FILE, open_bench
from hilbench.errors import UsageError
from hilbench.terminal.settings import settings, settings_file

__all__ = ["chosen_bench"]


def chosen_bench() -> str | None:
    """Return the bench of the settings; None if they name none, or ``./hilbench.toml`` comes before it.

    Raises:
        UsageError: it is none, or the settings are wrong.
    """
    bench = "" if DEFAULT_FILE.is_file() else settings().bench
    if not bench:
        return None
    try:
        open_bench(bench)
    except UsageError as error:
        raise UsageError(f"bench: {error}", where=str(settings_file())) from None
    return bench
