"""Changes to a TOML file that a command line asks for: ``KEY=VALUE`` in the place of what stands in the file.

The key is one of TOML, with a number for an entry of a list: ``world.scene``, ``faults.0.probability``. The value is
one of TOML too; what is none is a text, so ``world.scene=corridor`` needs no quotes.
"""

from __future__ import annotations

import copy
import json
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from hilbench.errors import UsageError

__all__ = ["Change", "apply", "change_text", "parse_change", "stands", "toml_key", "toml_value"]

OPTION = "--set"


@dataclass(frozen=True, slots=True)
class Change:
    """What one key is to be.

    Attributes:
        path: the key, part by part.
        value: as `tomllib` gives it.
        text: as it was written.
    """

    path: tuple[str, ...]
    value: Any
    text: str

    @property
    def where(self) -> str:
        """The option as it was written, for messages."""
        return f"{OPTION} {self.text}"

    def canonical(self) -> str:
        """Return the same text for the same change, however it was written."""
        return json.dumps([self.path, self.value], sort_keys=True, default=str)


def parse_change(text: str) -> Change:
    """Read ``KEY=VALUE``.

    Raises:
        ValueError: it is not of that form.
    """
    key, sign, value = text.partition("=")
    if not sign:
        raise ValueError(f"'{text}' is not KEY=VALUE")
    try:
        return Change(_path(key, text), _value(value.strip()), text)
    except RecursionError:
        raise ValueError(f"'{text:.40}...' has too many nested brackets") from None


def change_text(key: str, value: Any) -> str:
    """Return a change as a command line has it: a text without quotes, where it is read as one.

    Raises:
        ValueError: the key is none.
    """
    plain = f"{key}={value}"
    if isinstance(value, str) and value == value.strip() and parse_change(plain).value == value:
        return plain
    return parse_change(f"{key}={toml_value(value)}").text


def toml_value(value: Any) -> str:
    """Return plain data as a value of TOML, in one line."""
    if isinstance(value, dict):
        entries = [f"{toml_key(str(key))} = {toml_value(of)}" for key, of in value.items()]
        return "{ " + ", ".join(entries) + " }" if entries else "{}"
    if isinstance(value, list):
        return "[" + ", ".join(map(toml_value, value)) + "]"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    return json.dumps(value) if isinstance(value, bool) else str(value)


def toml_key(text: str) -> str:
    """Return a key as TOML has it, without quotes where it needs none."""
    bare = text.replace("_", "").replace("-", "")
    return text if bare.isascii() and bare.isalnum() else toml_value(text)


def apply(data: dict[str, Any], changes: Sequence[Change]) -> None:
    """Change data in place; one after the other, so a later change may be about what an earlier one has made.

    Raises:
        UsageError: a key leads through what is neither a table nor a list, or past the end of a list.
    """
    for change in changes:
        at: Any = data
        value = copy.deepcopy(change.value)  # a later change may be about what is in it
        for part, following in zip(change.path, change.path[1:], strict=False):
            at = _enter(at, part, [] if following.isdecimal() else {}, change)
        _put(at, change.path[-1], value, change)


def stands(data: Any, path: Sequence[str]) -> bool:
    """Say whether there is something at a path."""
    for part in path:
        if isinstance(data, list) and part.isdecimal() and int(part) < len(data):
            data = data[int(part)]
        elif isinstance(data, dict) and part in data:
            data = data[part]
        else:
            return False
    return True


def _path(key: str, text: str) -> tuple[str, ...]:
    try:
        found = tomllib.loads(f"{key} = 0")
    except tomllib.TOMLDecodeError:
        raise ValueError(f"'{text}' does not begin with a key, such as world.scene or faults.0.probability") from None
    path: list[str] = []
    at: Any = found
    while isinstance(at, dict):
        if len(at) != 1:
            raise ValueError(f"'{text}' names more than one key")
        ((part, at),) = at.items()
        path.append(part)
    return tuple(path)


def _value(text: str) -> Any:
    try:
        found = tomllib.loads(f"value = {text}")
    except tomllib.TOMLDecodeError:
        return text
    return found["value"] if found.keys() == {"value"} else text


def _enter(at: Any, part: str, empty: Any, change: Change) -> Any:
    if isinstance(at, dict):
        return at.setdefault(part, empty)
    index = _index(at, part, change)
    if index == len(at):
        at.append(empty)
    return at[index]


def _put(at: Any, part: str, value: Any, change: Change) -> None:
    if isinstance(at, dict):
        at[part] = value
        return
    index = _index(at, part, change)
    at[index : index + 1] = [value]


def _index(at: Any, part: str, change: Change) -> int:
    if not isinstance(at, list):
        raise UsageError(f"'{part}' is looked for in what is neither a table nor a list", where=change.where)
    if not part.isdecimal():
        raise UsageError(f"'{part}' is looked for in a list", where=change.where, hint="name its entry: 0 is the first")
    if int(part) > len(at):
        raise UsageError(f"there is no entry {part}: the list has {len(at)}", where=change.where)
    return int(part)
