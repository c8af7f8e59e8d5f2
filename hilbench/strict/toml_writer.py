"""Writes plain data as TOML, as a person would: tables under headings, lists of tables as such."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from hilbench.strict.changes import toml_key, toml_value

__all__ = ["toml_text"]


def toml_text(data: Mapping[str, Any]) -> str:
    """Return the text; reading it gives the data back."""
    return "\n".join(_table(data, ())) + "\n"


def _table(data: Mapping[str, Any], path: tuple[str, ...]) -> Iterator[str]:
    tables = {key: value for key, value in data.items() if isinstance(value, dict) and value}
    lists = {key: value for key, value in data.items() if _is_list_of_tables(value)}
    for key, value in data.items():
        if key not in tables and key not in lists:
            yield f"{toml_key(key)} = {toml_value(value)}"
    for key, value in tables.items():
        if not all(isinstance(one, dict) and one for one in value.values()):
            yield from ("", f"[{_heading((*path, key))}]")
        yield from _table(value, (*path, key))
    for key, values in lists.items():
        for value in values:
            yield from ("", f"[[{_heading((*path, key))}]]", *_flat(value))


def _flat(entry: Mapping[str, Any]) -> Iterator[str]:
    """Yield an entry of a list, with the tables in it in one line each."""
    yield from (f"{toml_key(key)} = {toml_value(value)}" for key, value in entry.items())


def _is_list_of_tables(value: Any) -> bool:
    return isinstance(value, list) and bool(value) and all(isinstance(one, dict) for one in value)


def _heading(path: tuple[str, ...]) -> str:
    return ".".join(map(toml_key, path))
