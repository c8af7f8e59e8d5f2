"""Reads a campaign file: which check, at which points.

A factor is what differs from point to point. It has levels, each of which sets keys of the bench file as
``check --set`` does, or a range that values are drawn from.
"""

from __future__ import annotations

import itertools
import math
import random
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import msgspec
from msgspec import Meta

from hilbench.benchfile.suites import shipped_suites
from hilbench.campaign.point import Point
from hilbench.errors import UnavailableError, UsageError
from hilbench.files.built_in import built_in_benches
from hilbench.files.names import file_name
from hilbench.plugins.discovery import PLUGINS
from hilbench.strict import Strict
from hilbench.strict.changes import change_text
from hilbench.strict.toml_file import TomlFile

__all__ = ["MOST_POINTS", "Campaign", "read_campaign"]

MOST_POINTS = 1_000_000
"""More than that is a mistake (choice): a week on a hundred processors, at a minute each."""

_DIGITS = 6
"""Significant digits of a value that is drawn (choice): it can be written in a command, and is the same then."""

Seeds = Annotated[int, Meta(ge=1, le=MOST_POINTS)] | list[Annotated[int, Meta(ge=0, le=(1 << 63) - 1)]]


class Draw(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """How values are drawn from ranges.

    Attributes:
        samples: how many points are drawn, for each combination of levels, benches and seeds.
        method: ``latin-hypercube`` spreads them evenly over each range (scipy); ``random`` draws each by itself.
        seed: of the drawing.
    """

    samples: Annotated[int, Meta(ge=1, le=MOST_POINTS)]
    method: Literal["latin-hypercube", "random"] = "latin-hypercube"
    seed: Annotated[int, Meta(ge=0, le=(1 << 63) - 1)] = 0


class Range(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """A range that values are drawn from: whole numbers if both ends are.

    Attributes:
        low: the least value.
        high: the greatest.
        scale: ``log`` draws as many between 0.001 and 0.01 as between 0.01 and 0.1.
    """

    low: int | float
    high: int | float
    scale: Literal["linear", "log"] = "linear"

    def __post_init__(self) -> None:
        """Refuse what is no range; the message begins with the key it is about."""
        if not (math.isfinite(self.low) and math.isfinite(self.high) and self.low < self.high):
            raise ValueError("high must be above low")
        if self.scale == "log" and self.low <= 0:
            raise ValueError("low must be above 0 on a log scale")

    def at(self, share: float) -> float:
        """Return the value at a share of the range, 0 to below 1."""
        whole = isinstance(self.low, int) and isinstance(self.high, int)
        high = self.high + 1 if whole else self.high
        if self.scale == "log":
            value = self.low * (high / self.low) ** share
        else:
            value = self.low + share * (high - self.low)
        return math.floor(value) if whole else float(f"{value:.{_DIGITS}g}")


class CampaignModel(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What a campaign file has in it.

    Attributes:
        version: of this format.
        bench: the bench, or several: a factor of its own then.
        suites: as ``check --suite``.
        select: as ``check -k``.
        seeds: how many seeds, from 0 on, or which.
        set: what each point has otherwise than the bench file says, by its key.
        factors: what differs: values of a key of the bench file, a range of them, or levels by name.
        draw: how values are drawn from ranges.
    """

    version: Literal[1]
    bench: str | list[str]
    suites: list[str] = []
    select: str = ""
    seeds: Seeds = 1
    set: dict[str, Any] = {}
    factors: dict[str, Any] = {}
    draw: Draw | None = None


@dataclass(frozen=True, slots=True)
class _Level:
    """What a factor is at a point: its name there, and what is set for it."""

    name: float | str
    changes: tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Campaign:
    """A campaign file that was understood.

    Attributes:
        path: of the file.
        points: all points, in order; each is there once.
        factors: the names of what differs.
    """

    path: Path
    points: tuple[Point, ...]
    factors: tuple[str, ...]


def read_campaign(path: Path) -> Campaign:
    """Read a campaign file.

    Raises:
        UsageError: it cannot be read, or is wrong; the line is named.
        UnavailableError: values are to be drawn by a library that is not installed.
    """
    return _Reader(TomlFile(path, "campaign file", "docs/campaigns.md shows one")).read()


class _Reader:
    def __init__(self, file: TomlFile) -> None:
        self._file = file
        self._strict = Strict(file.place)

    def read(self) -> Campaign:
        model = self._strict.convert(self._file.data, CampaignModel)
        benches = [model.bench] if isinstance(model.bench, str) else model.bench
        seeds = list(range(model.seeds)) if isinstance(model.seeds, int) else model.seeds
        levels, ranges = self._factors(model.factors)
        self._check_draw(model.draw, ranges)
        draw = model.draw or Draw(samples=1)
        number = len(benches) * len(seeds) * draw.samples * math.prod(map(len, levels.values()))
        if not 1 <= number <= MOST_POINTS:
            raise UsageError(f"means {number} points; 1 to {MOST_POINTS} are possible", where=str(self._file.path))
        fixed = tuple(self._change(key, value, ("set", key)) for key, value in model.set.items())
        found: dict[Point, None] = {}
        several = len(benches) > 1
        for bench, seed in itertools.product(map(self._bench, benches), seeds):
            for factors in self._combinations(levels, ranges, draw):
                named = {name: level.name for name, level in factors.items()}
                point = Point(
                    bench=bench,
                    seed=seed,
                    changes=fixed + tuple(change for level in factors.values() for change in level.changes),
                    suites=tuple(map(self._suite, model.suites)),
                    select=model.select,
                    levels={"bench": bench, **named} if several else named,
                )
                found[point] = None
        names = (["bench"] if several else []) + [*levels, *ranges]
        return Campaign(path=self._file.path, points=tuple(found), factors=tuple(names))

    def _combinations(
        self, levels: Mapping[str, list[_Level]], ranges: Mapping[str, Range], draw: Draw
    ) -> Iterator[dict[str, _Level]]:
        for chosen in itertools.product(*levels.values()):
            for drawn in self._drawn(ranges, draw):
                yield dict(zip(levels, chosen, strict=True)) | drawn

    def _factors(self, entries: Mapping[str, Any]) -> tuple[dict[str, list[_Level]], dict[str, Range]]:
        levels: dict[str, list[_Level]] = {}
        ranges: dict[str, Range] = {}
        for name, entry in entries.items():
            path = ("factors", name)
            if name == "bench":
                raise self._strict.error("is a name of its own", path, 'several benches: bench = ["a.toml", "b.toml"]')
            if isinstance(entry, list) and entry:
                levels[name] = [_Level(_label(value), (self._change(name, value, path),)) for value in entry]
            elif isinstance(entry, dict) and entry.keys() & {"low", "high"}:
                ranges[name] = self._strict.convert_at(entry, Range, path)
                self._change(name, 0, path)
            elif isinstance(entry, dict) and entry and all(isinstance(level, dict) for level in entry.values()):
                levels[name] = [self._level(label, level, (*path, label)) for label, level in entry.items()]
            else:
                hint = "[1, 2, 3], { low = 1, high = 3 }, or tables of keys by a name of the level"
                raise self._strict.error(f"'{name}' has no levels", path, hint)
        return levels, ranges

    def _level(self, label: str, keys: Mapping[str, Any], path: tuple[str, ...]) -> _Level:
        return _Level(label, tuple(self._change(key, value, (*path, key)) for key, value in keys.items()))

    def _change(self, key: str, value: Any, path: tuple[str, ...]) -> str:
        try:
            return change_text(key, value)
        except ValueError as error:
            raise self._strict.error(str(error), path) from None

    def _check_draw(self, draw: Draw | None, ranges: Mapping[str, Range]) -> None:
        if ranges and draw is None:
            name = next(iter(ranges))
            raise self._strict.error(
                f"'{name}' is a range to draw from", ("factors", name), "[draw] with samples = 100"
            )
        if draw is not None and not ranges:
            hint = '[factors] with "faults.0.probability" = { low = 0.001, high = 0.1 }'
            raise self._strict.error("there is no range to draw from", ("draw",), hint)

    def _drawn(self, ranges: Mapping[str, Range], draw: Draw) -> list[dict[str, _Level]]:
        """Return what the ranges are at each of the points drawn."""
        if not ranges:
            return [{}]
        shares = _spread(len(ranges), draw) if draw.method == "latin-hypercube" else _independent(len(ranges), draw)
        found = []
        for row in shares:
            values = {name: each.at(share) for (name, each), share in zip(ranges.items(), row, strict=True)}
            found.append({name: _Level(value, (change_text(name, value),)) for name, value in values.items()})
        return found

    def _bench(self, bench: str) -> str:
        if bench in built_in_benches() or PLUGINS.systems.bench(bench) is not None:
            return bench
        return self._beside(bench)

    def _suite(self, suite: str) -> str:
        return suite if suite in shipped_suites() else self._beside(suite)

    def _beside(self, text: str) -> str:
        """Return a path that stands in the file, from where we are."""
        return str(self._file.path.parent / file_name(text))


def _label(value: Any) -> float | str:
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return value
    return value if isinstance(value, str) else change_text("value", value).removeprefix("value=")


def _independent(dimensions: int, draw: Draw) -> Iterable[Sequence[float]]:
    chance = random.Random(draw.seed)
    return [[chance.random() for _ in range(dimensions)] for _ in range(draw.samples)]


def _spread(dimensions: int, draw: Draw) -> Iterable[Sequence[float]]:
    try:
        from scipy.stats import qmc
    except ImportError:
        hint = "pip install 'hilbench[campaign]', or method = \"random\" in [draw]"
        raise UnavailableError("a Latin hypercube needs scipy, which is not installed", hint=hint) from None
    shares: Iterable[Sequence[float]] = qmc.LatinHypercube(dimensions, rng=draw.seed).random(draw.samples).tolist()
    return shares
