"""Says what rules would make of a device, without udev: for `hilbench udev --explain`, and for tests without hardware.

It knows the keys that our own rules use. What udev does in other files is not done here: who calls says which
properties a device has by then.
"""

from __future__ import annotations

import fnmatch
import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

from hilbench.errors import InternalError
from hilbench.udev.rules import Expression, Rule

__all__ = ["Device", "Outcome", "apply_rules"]

_REFERENCE = re.compile(r"\$env\{([^}]*)\}")


@dataclass(frozen=True, slots=True, kw_only=True)
class Device:
    """What happens to which device.

    Attributes:
        action: ``add``, ``change``, ``bind`` or ``remove``.
        subsystem: such as ``tty``.
        kernel: its name, such as ``ttyUSB0``.
        properties: those of the event and of the rules before.
        attributes: of the device and of each above it, itself first.
        files: paths that exist.
    """

    action: str = "add"
    subsystem: str
    kernel: str = ""
    properties: Mapping[str, str] = field(default_factory=dict)
    attributes: Sequence[Mapping[str, str]] = ({},)
    files: frozenset[str] = frozenset()


@dataclass(slots=True, kw_only=True)
class Outcome:
    """What the rules made of it.

    Attributes:
        properties: all of them, also those it had.
        links: further names, below ``/dev``.
        tags: such as ``uaccess``.
        group: the group of its node; empty if it is not set.
        mode: the mode of its node; empty if it is not set.
        written: attributes that were written.
    """

    properties: dict[str, str]
    links: list[str] = field(default_factory=list)
    tags: list[str] = field(default_factory=list)
    group: str = ""
    mode: str = ""
    written: dict[str, str] = field(default_factory=dict)


def apply_rules(rules: Sequence[Rule], device: Device) -> Outcome:
    """Return what rules make of a device.

    Raises:
        InternalError: a key stands in them that is not known here.
    """
    outcome = Outcome(properties=dict(device.properties))
    wanted: str | None = None
    for rule in rules:
        if wanted is not None and rule.value("LABEL") != wanted:
            continue
        wanted = None
        if _fits(rule, device, outcome):
            for one in rule.expressions:
                _assign(one, outcome)
            wanted = rule.value("GOTO")
    return outcome


def _fits(rule: Rule, device: Device, outcome: Outcome) -> bool:
    conditions = [one for one in rule.expressions if one.compares]
    of_parents = [one for one in conditions if one.key == "ATTRS"]
    if any(not _holds(one, device, outcome) for one in conditions if one.key != "ATTRS"):
        return False
    # All that is said of one parent must hold of the same one.
    return not of_parents or any(
        all(_matches(one, place.get(one.attribute)) for one in of_parents) for place in device.attributes
    )


def _holds(one: Expression, device: Device, outcome: Outcome) -> bool:
    if one.key == "TEST":
        there = one.value in (device.files if one.value.startswith("/") else device.attributes[0])
        return there == (one.operator == "==")
    values: Mapping[str, Callable[[], str | None]] = {
        "ACTION": lambda: device.action,
        "SUBSYSTEM": lambda: device.subsystem,
        "KERNEL": lambda: device.kernel,
        "ENV": lambda: outcome.properties.get(one.attribute, ""),
        "ATTR": lambda: device.attributes[0].get(one.attribute),
    }
    if one.key not in values:
        raise InternalError(f"a rule compares {one.key}, which is not known here")
    return _matches(one, values[one.key]())


def _matches(one: Expression, value: str | None) -> bool:
    if value is None:
        return False
    fits = any(fnmatch.fnmatchcase(value, pattern) for pattern in one.value.split("|"))
    return fits == (one.operator == "==")


def _assign(one: Expression, outcome: Outcome) -> None:
    if one.compares or one.key in {"GOTO", "LABEL"}:
        return
    value = _REFERENCE.sub(lambda match: outcome.properties.get(match[1], ""), one.value)
    if one.key == "ENV":
        outcome.properties[one.attribute] = value
    elif one.key == "SYMLINK":
        outcome.links.append(value)
    elif one.key == "TAG":
        outcome.tags.append(value)
    elif one.key == "GROUP":
        outcome.group = value
    elif one.key == "MODE":
        outcome.mode = value
    elif one.key == "ATTR":
        outcome.written[one.attribute] = value
    else:
        raise InternalError(f"a rule sets {one.key}, which is not known here")
