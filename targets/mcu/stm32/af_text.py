"""How the tables of alternate functions are written.

A line is a pin and, for each alternate function that it has, number and signals; signals joined by a slash share the
function. AF15 is EVENTOUT at every pin and left out.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

__all__ = ["parse"]


def parse(table: str) -> Mapping[str, Mapping[int, tuple[str, ...]]]:
    """Return for each pin the signals of each alternate function, EVENTOUT among them."""
    functions: dict[str, dict[int, tuple[str, ...]]] = {}
    pin = ""
    for word in table.split():
        number, colon, signals = word.partition(":")
        if colon:
            functions[pin][int(number)] = tuple(signals.split("/"))
        else:
            pin = word
            functions[pin] = {}
    return MappingProxyType({pin: MappingProxyType(of_pin | {15: ("EVENTOUT",)}) for pin, of_pin in functions.items()})
