"""Turns plain data into a typed model, and every mistake into one line: what, where, and what was probably meant."""

from __future__ import annotations

import functools
import re
from collections.abc import Callable, Iterable
from typing import Any, TypeVar

import msgspec
from msgspec import inspect

from hilbench.errors import UsageError
from hilbench.nearest import did_you_mean

ModelT = TypeVar("ModelT")
Path = tuple[str | int, ...]
Locate = Callable[[Path], str]

# Looking into a model takes longer than most files do.
_kind_of: Callable[[Any], inspect.Type] = functools.cache(inspect.type_info)

_PLACE = re.compile(r" - at `\$(?P<path>.*)`$")
_STEP = re.compile(r"\.(?P<key>[^.\[\]]+)|\[(?P<index>\d+)\]")
_WORDS = [
    (re.compile(pattern), words)
    for pattern, words in (
        ("^Object missing required field `(.*)`", r"the key '\1' is missing"),
        ("^Expected ", "must be "),
        (", got ", ", not "),
        (r" \| null`", "`"),
        ("`int`", "a whole number"),
        ("`float`", "a number"),
        ("`str`", "a text"),
        ("`bool`", "true or false"),
        ("`array`", "a list"),
        ("`object`", "a table"),
    )
]


class Strict:
    """Converts data with one way of saying where a mistake is.

    Args:
        locate: turns a path into a place for people, such as ``bench.toml:7``.
    """

    def __init__(self, locate: Locate) -> None:
        self._locate = locate

    def convert(self, data: Any, model: type[ModelT]) -> ModelT:
        """Return the model that the data describe.

        Raises:
            UsageError: an unknown key, a wrong type, a value out of range.
        """
        kind = _kind_of(model)
        self._refuse_unknown_keys(data, kind, ())
        self._check_entries(data, kind, ())
        converted: ModelT = self._converted(data, model, ())
        return converted

    def convert_at(self, data: Any, model: type[ModelT], path: Path) -> ModelT:
        """Return the model that the data at a path describe; see `convert`.

        Raises:
            UsageError: an unknown key, a wrong type, a value out of range.
        """
        self._refuse_unknown_keys(data, _kind_of(model), path)
        converted: ModelT = self._converted(data, model, path)
        return converted

    def error(self, message: str, path: Path, hint: str | None = None) -> UsageError:
        """Return the error for a mistake at a path."""
        return UsageError(message, where=self._locate(path), hint=hint)

    def _converted(self, data: Any, model: Any, prefix: Path) -> Any:
        try:
            return msgspec.convert(data, model)
        except msgspec.ValidationError as error:
            message, path = _split(str(error))
            raise self._explained(message, data, _kind_of(model), prefix, path) from None

    def _check_entries(self, data: Any, kind: inspect.Type, prefix: Path) -> None:
        """Convert the entries of each table of named things by themselves: msgspec does not tell their names."""
        for name, field in _fields(kind).items():
            if isinstance(field, inspect.DictType) and isinstance(data.get(name), dict):
                for key, entry in data[name].items():
                    self._converted(entry, _model_of(field.value_type), (*prefix, name, key))

    def _refuse_unknown_keys(self, data: Any, kind: inspect.Type, path: Path) -> None:
        if isinstance(kind, inspect.DictType) and isinstance(data, dict):
            for key, value in data.items():
                self._refuse_unknown_keys(value, kind.value_type, (*path, key))
        elif isinstance(kind, inspect.ListType | inspect.VarTupleType) and isinstance(data, list):
            for index, value in enumerate(data):
                self._refuse_unknown_keys(value, kind.item_type, (*path, index))
        elif isinstance(kind, inspect.StructType | inspect.DataclassType) and isinstance(data, dict):
            fields = _fields(kind)
            for key, value in data.items():
                if key not in fields:
                    raise self._unknown(key, fields, path)
                self._refuse_unknown_keys(value, fields[key], (*path, key))

    def _unknown(self, key: str, known: Iterable[str], path: Path) -> UsageError:
        table = f" in [{_dotted(path)}]" if path else ""
        return self.error(f"unknown key '{key}'{table}", (*path, key), did_you_mean(key, known, "known keys"))

    def _explained(self, message: str, data: Any, kind: inspect.Type, prefix: Path, path: Path) -> UsageError:
        value, field = _follow(data, kind, path)
        hint = None
        if isinstance(field, inspect.LiteralType):
            message = f"{value!r} is not a value it takes"
            hint = did_you_mean(str(value), map(str, field.values), "it takes")
        about = message.split(maxsplit=1)[0]
        if about in _fields(field):  # a model's own rule, which begins with the name of the field
            return self.error(message, (*prefix, *path, about))
        full = (*prefix, *path)
        name = f"'{_dotted(full)}': " if full else ""
        return self.error(f"{name}{_plain(message)}", full, hint)


def _fields(kind: inspect.Type) -> dict[str, inspect.Type]:
    if isinstance(kind, inspect.StructType | inspect.DataclassType):
        return {field.encode_name: field.type for field in kind.fields}
    return {}


def _model_of(kind: inspect.Type) -> Any:
    return kind.cls if isinstance(kind, inspect.StructType | inspect.DataclassType) else Any


def _follow(data: Any, kind: inspect.Type, path: Path) -> tuple[Any, inspect.Type]:
    for step in path:
        data = data[step]
        kind = _inside(kind, step)
    return data, kind


def _inside(kind: inspect.Type, step: str | int) -> inspect.Type:
    if isinstance(kind, inspect.DictType):
        return kind.value_type
    if isinstance(kind, inspect.ListType | inspect.VarTupleType):
        return kind.item_type
    return _fields(kind).get(str(step), inspect.AnyType())


def _split(message: str) -> tuple[str, Path]:
    place = _PLACE.search(message)
    if place is None:
        return message, ()
    steps = _STEP.finditer(place["path"])
    return message[: place.start()], tuple(step["key"] or int(step["index"]) for step in steps)


def _plain(message: str) -> str:
    for pattern, words in _WORDS:
        message = pattern.sub(words, message)
    return message


def _dotted(path: Path) -> str:
    text = ""
    for step in path:
        text += f"[{step}]" if isinstance(step, int) else f".{step}"
    return text.removeprefix(".")
