"""Scene files: strict TOML, every complaint names the file and the key.

::

    name = "my-lab"
    floor_friction = 1.0                     # optional
    [start]                                  # optional
    x_m = 0.0
    y_m = 0.0
    yaw_deg = 90.0
    [[boxes]]
    name = "crate"
    center_m = [2.0, 0.5, 0.2]
    size_m = [0.4, 0.4, 0.4]
    yaw_deg = 30.0                           # optional, as are pitch_deg and friction
"""

from __future__ import annotations

import difflib
import math
import tomllib
from pathlib import Path
from typing import Any

from worlds.errors import SceneFileError
from worlds.scenes.model import Box, Scene, Start, Vector


def read_scene(path: Path) -> Scene:
    """Read a scene file.

    Raises:
        SceneFileError: unreadable file, bad TOML, a key that does not belong or a value out of range.
    """
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except (OSError, UnicodeDecodeError) as problem:
        reason = problem.strerror if isinstance(problem, OSError) else "not UTF-8"
        raise SceneFileError(f"{path}: cannot read the scene: {reason}") from problem
    except tomllib.TOMLDecodeError as problem:
        raise SceneFileError(f"{path}: not TOML: {problem}") from problem
    return _scene(_Table(path, "", document))


class _Table:
    """One TOML table with its place in the file, for messages; every key must be asked for or is refused."""

    def __init__(self, path: Path, prefix: str, values: dict[str, Any]) -> None:
        self._path = path
        self._prefix = prefix
        self._values = values
        self._asked: list[str] = []

    def error(self, key: str, reason: str) -> SceneFileError:
        return SceneFileError(f"{self._path}: {self._prefix}{key}: {reason}")

    def _take(self, key: str, default: Any) -> Any:
        self._asked.append(key)
        value = self._values.get(key, default)
        if value is None:
            raise self.error(key, "missing")
        return value

    def text(self, key: str) -> str:
        value = self._take(key, None)
        if not isinstance(value, str) or not value:
            raise self.error(key, "must be a text that is not empty")
        return value

    def number(self, key: str, default: float, *, least: float = -math.inf) -> float:
        return self._checked(key, self._take(key, default), least)

    def vector(self, key: str, *, above: float = -math.inf) -> Vector:
        value = self._take(key, None)
        if not isinstance(value, list) or len(value) != 3:
            raise self.error(key, "must be a list of three numbers")
        x, y, z = (self._checked(key, number, -math.inf) for number in value)
        if min(x, y, z) <= above:
            raise self.error(key, f"every number must be greater than {above:g}")
        return x, y, z

    def table(self, key: str) -> _Table:
        value = self._take(key, {})
        if not isinstance(value, dict):
            raise self.error(key, f"must be a table, [{key}]")
        return _Table(self._path, f"{self._prefix}{key}.", value)

    def tables(self, key: str) -> list[_Table]:
        values = self._take(key, [])
        if not isinstance(values, list) or not all(isinstance(value, dict) for value in values):
            raise self.error(key, f"must be a list of tables, [[{key}]]")
        return [_Table(self._path, f"{self._prefix}{key}[{index}].", value) for index, value in enumerate(values)]

    def finish(self) -> None:
        for key in self._values:
            if key not in self._asked:
                near = difflib.get_close_matches(key, self._asked, n=1)
                hint = f"did you mean {near[0]!r}?" if near else f"known: {', '.join(self._asked)}"
                raise self.error(key, f"unknown key: {hint}")

    def _checked(self, key: str, value: Any, least: float) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
            raise self.error(key, f"must be a finite number, not {value!r}")
        if value < least:
            raise self.error(key, f"must be at least {least:g}, not {value:g}")
        return float(value)


def _scene(table: _Table) -> Scene:
    name = table.text("name")
    friction = table.number("floor_friction", 1.0, least=0.0)
    start = _start(table.table("start"))
    tables = table.tables("boxes")
    table.finish()
    boxes: dict[str, Box] = {}
    for entry in tables:
        box = _box(entry)
        if box.name in boxes or box.name == "floor":
            raise entry.error("name", f"{box.name!r} is taken")
        boxes[box.name] = box
    return Scene(name=name, start=start, boxes=tuple(boxes.values()), floor_friction=friction)


def _start(table: _Table) -> Start:
    start = Start(
        x_m=table.number("x_m", 0.0), y_m=table.number("y_m", 0.0), yaw_rad=math.radians(table.number("yaw_deg", 0.0))
    )
    table.finish()
    return start


def _box(table: _Table) -> Box:
    box = Box(
        name=table.text("name"),
        center_m=table.vector("center_m"),
        size_m=table.vector("size_m", above=0.0),
        yaw_rad=math.radians(table.number("yaw_deg", 0.0)),
        pitch_rad=math.radians(table.number("pitch_deg", 0.0)),
        friction=table.number("friction", 1.0, least=0.0),
    )
    table.finish()
    return box
