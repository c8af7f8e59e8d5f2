"""What is wrong with a record, in words; found when it is taken, and not in the middle of a run."""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator, Mapping
from enum import Enum
from pathlib import Path
from typing import Any, get_type_hints

from hilbench.plugins import system as systems
from hilbench.plugins.protocol import API, Device, FirstTest, ProtocolPlugin, Recorded
from hilbench.plugins.system import HandRequest, ModelKind, System, VehicleKind

__all__ = ["OPTION_KINDS", "problem_of", "problem_of_system", "problem_of_vehicle"]

OPTION_KINDS = (bool, int, float, str, Path)
"""What an option of a protocol may be, beside an enumeration: what a word of a command line can be read as."""

_NAME = re.compile(r"[a-z][a-z0-9_-]*")
_CALLABLE = ("decoder", "quantities", "regions", "clauses")
_PERHAPS_CALLABLE = ("checksum", "encode", "settle", "peer")
_PARTS = {"device": Device, "host": Device, "recorded": Recorded, "first_test": FirstTest}


def problem_of(record: ProtocolPlugin) -> str:
    """Return the first thing that is wrong with a record; empty for nothing."""
    if record.api != API:
        return f"was written for api {record.api}, and this hilbench has {API}; install one that fits"
    return next(_problems(record), "")


def problem_of_system(system: System) -> str:
    """Return the first thing that is wrong with a system; empty for nothing."""
    if system.api != systems.API:
        return f"was written for api {system.api}, and this hilbench has {systems.API}; install one that fits"
    return next(_system_problems(system), "")


def problem_of_vehicle(made: Any) -> str:
    """Return the first thing that is wrong with what makes a vehicle; empty for nothing."""
    return next(_of_vehicle(made), "")


def _system_problems(system: Any) -> Iterator[str]:
    yield from _of_name(system)
    yield from _of_class(str, "text", system, "title", "summary")
    yield from _of_class(Mapping, "mapping of names", system, "speakers", "checkers")
    yield from _of_requests(system.hand_requests)
    if system.benches is not None and not (isinstance(system.benches, Path) and system.benches.is_dir()):
        yield f"its folder of benches '{system.benches}' is not there"
    yield from _of_bodies(system)


def _of_requests(requests: Any) -> Iterator[str]:
    """Yield what is wrong with what may be asked of somebody beside a target."""
    if not isinstance(requests, Mapping) or not all(isinstance(one, HandRequest) for one in requests.values()):
        yield "hand_requests is no mapping of names to HandRequests"
        return
    for name, request in requests.items():
        if request.undo and request.undo not in requests:
            yield f"its request '{name}' is undone by '{request.undo}', which is none"


def _of_bodies(system: Any) -> Iterator[str]:
    """Yield what is wrong with the models and vehicles of a system."""
    if not callable(system.models):
        yield "models cannot be called"
        return
    for what, found in (("vehicles", system.vehicles), ("models()", system.models())):
        if not isinstance(found, Mapping) or not all(isinstance(name, str) for name in found):
            yield f"{what} is no mapping of names"
            return
    for name, make in system.vehicles.items():
        if not callable(make):
            yield f"its vehicle '{name}' cannot be made"
    for name, kind in system.models().items():
        if not isinstance(kind, ModelKind):
            yield f"its model '{name}' is no ModelKind"
        for wrong in _of_kind(kind):
            yield f"its model '{name}': {wrong}"


def _of_kind(kind: Any) -> Iterator[str]:
    for wrong in _of_settings(kind.settings):
        yield f"settings: {wrong}"
    yield from _of_class(str, "text", kind, "protocol", "bench", "target")
    yield from _of_number(kind, "baud", 300)
    for what, of in (("suites", str), ("rates", int), ("lines", str)):
        value = getattr(kind, what)
        if not isinstance(value, tuple) or not all(type(one) is of for one in value):
            yield f"{what} is no tuple of {of.__name__}"
    if not kind.lines:
        yield "lines is empty"
    yield from _of_class(bool, "bool", kind, "beside", "has_body")


def _of_vehicle(made: Any) -> Iterator[str]:
    if not isinstance(made, VehicleKind):
        yield f"its maker returns {made!r}, and no VehicleKind"
        return
    for what in ("vehicle", "body", *(["wire"] if made.signals else [])):
        if not callable(getattr(made, what)):
            yield f"{what} cannot be called"
    signals: Any = made.signals
    if not isinstance(signals, Mapping) or not all(hasattr(one, "by_rays") for one in signals.values()):
        yield "signals is no mapping of names to WorldSignals"
    size: Any = made.size_m
    if not isinstance(size, tuple) or [type(one) in (int, float) and one > 0 for one in size] != [True, True]:
        yield "size_m is no length and breadth in m"
    yield from _of_class(bool, "bool", made, "stands_ready")


def _of_name(record: Any) -> Iterator[str]:
    if not isinstance(record.name, str) or _NAME.fullmatch(record.name) is None:
        yield f"name {record.name!r} is no name: write small letters, digits, _ and -"


def _of_class(kind: type, called: str, record: Any, *names: str) -> Iterator[str]:
    for name in names:
        if not isinstance(getattr(record, name), kind):
            yield f"{name} is no {called}"


def _of_number(record: Any, number: str, least: int) -> Iterator[str]:
    value = getattr(record, number)
    if type(value) is not int or value < least:
        yield f"{number} is no whole number from {least} on"


def _problems(record: Any) -> Iterator[str]:
    yield from _of_words(record)
    for what in (*_CALLABLE, *_PERHAPS_CALLABLE):
        value = getattr(record, what)
        if not callable(value) and (value is not None or what in _CALLABLE):
            yield f"{what} cannot be called"
    for what, kind in _PARTS.items():
        if getattr(record, what) is not None:
            yield from _of_class(kind, kind.__name__, record, what)
    for what in ("device", "host"):
        yield from _of_device(what, getattr(record, what))
    yield from _of_suites(record.suites)
    yield from _of_options(record.options)


def _of_words(record: Any) -> Iterator[str]:
    yield from _of_name(record)
    yield from _of_class(str, "text", record, "title", "summary", "help", "replay_bench")
    yield from _of_class(Mapping, "mapping of names", record, "answers")
    if not record.title:
        yield "title is empty"
    yield from _of_number(record, "baud", 300)
    yield from _of_number(record, "longest_frame", 1)


def _of_device(what: str, device: Any) -> Iterator[str]:
    if device is None:
        return
    if not callable(device.make):
        yield f"the make of its {what} cannot be called"
    for wrong in _of_settings(device.settings):
        yield f"the settings of its {what}: {wrong}"


def _of_suites(suites: Any) -> Iterator[str]:
    if not isinstance(suites, tuple) or not all(isinstance(suite, Path) for suite in suites):
        yield "suites is no tuple of paths"
        return
    for suite in suites:
        if not suite.exists():
            yield f"its suite '{suite}' is not there"


def _of_options(options: Any) -> Iterator[str]:
    for wrong in _of_settings(options):
        yield f"options: {wrong}"
    kinds = get_type_hints(options)
    for one in dataclasses.fields(options):
        kind = kinds[one.name]
        if not (kind in OPTION_KINDS or (isinstance(kind, type) and issubclass(kind, Enum))):
            there = ", ".join(known.__name__ for known in OPTION_KINDS)
            yield f"options: '{one.name}' can be no flag: it is none of {there}, and no enumeration"


def _of_settings(settings: Any) -> Iterator[str]:
    if not isinstance(settings, type) or not dataclasses.is_dataclass(settings):
        yield "no dataclass"
        return
    try:
        get_type_hints(settings)
        settings()
    except Exception as error:  # noqa: BLE001 - whatever a stranger's class raises
        yield f"cannot be made without values: {type(error).__name__}: {error}"
