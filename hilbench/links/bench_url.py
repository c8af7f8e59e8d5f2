"""What a URL ``hilbench://TARGET[?KEY=VALUE&...]`` means."""

from __future__ import annotations

from dataclasses import dataclass
from urllib.parse import unquote, urlsplit

from hilbench.errors import UsageError
from hilbench.nearest import did_you_mean

__all__ = ["BenchUrl", "parse_bench_url"]

_KEYS = ("image", "line", "seed", "fast")


@dataclass(frozen=True, slots=True, kw_only=True)
class BenchUrl:
    """A bench, and how it runs.

    Attributes:
        what: a TARGET or bench, as ``hilbench serve`` takes it.
        line: which of its lines; empty for the usual one.
        seed: of everything random.
        fast: whether it runs as fast as the processor goes, and only while it is waited for.
    """

    what: str
    line: str = ""
    seed: int = 0
    fast: bool = False


def parse_bench_url(url: str) -> BenchUrl:
    """Read a URL: ``hilbench://BENCH``, ``hilbench://BOARD?image=fw.elf&line=usart2``, ``hilbench:///dir/bench.toml``.

    Keys are ``image`` (firmware for a board), ``line`` (which line), ``seed``, and ``fast``.

    Raises:
        UsageError: it names no bench, or a key or value is wrong.
    """
    try:
        parts = urlsplit(url)
    except ValueError as error:
        raise UsageError(f"is no URL: {error}", where=url) from error
    what = unquote(parts.netloc + parts.path)
    if parts.scheme.lower() != "hilbench" or not what:
        raise UsageError("names no bench", where=url, hint="write hilbench://BENCH or hilbench://BOARD?image=FILE")
    given = _given(parts.query)
    for key in given:
        if key not in _KEYS:
            raise UsageError(f"no key '{key}'", where=url, hint=did_you_mean(key, _KEYS, "keys"))
    if not given.get("seed", "0").isdecimal():
        raise UsageError(f"seed: '{given['seed']}' is not a whole number", where=url)
    if given.get("fast", "") not in {"", "0", "1"}:
        raise UsageError(f"fast: '{given['fast']}' is neither 0 nor 1", where=url)
    image = given.get("image")
    return BenchUrl(
        what=what if image is None else f"{what}:{image}",
        line=given.get("line", ""),
        seed=int(given.get("seed", "0")),
        fast="fast" in given and given["fast"] != "0",
    )


def _given(query: str) -> dict[str, str]:
    """Read keys and values; a plus is a plus, as in the name of a file, and no blank as in a form's answers."""
    pairs = (word.partition("=") for word in query.split("&") if word)
    return {unquote(key): unquote(value) for key, _, value in pairs}
