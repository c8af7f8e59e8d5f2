"""The entries of ``[[faults]]`` in a bench file: what is written, what is refused, how it is said in one line.

What a fault does to the line is in `hilbench.links.faults`; how the entries get onto it, in
`hilbench.bench.line_faults`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, Literal

import msgspec
from msgspec import UNSET, Meta, UnsetType

LONGEST_S = 1e6
MOST_BYTES = 65_536

_TRIGGERS = ("at_s", "byte", "probability")
_LINE_KINDS = frozenset({"break", "disconnect", "baud"})
_OPTIONAL = {
    "drop": {"count"},
    "flip": {"count"},
    "duplicate": {"count"},
    "noise": {"count"},
}
_REQUIRED = {
    "flip": {"bit"},
    "delay": {"duration_s"},
    "break": {"duration_s"},
    "disconnect": {"duration_s"},
    "baud": {"duration_s", "baud"},
}
_DETAILS = ("count", "bit", "duration_s", "baud")

_Seconds = Annotated[float, Meta(ge=0, le=LONGEST_S)]
_Span = Annotated[float, Meta(gt=0, le=LONGEST_S)]


class FaultEntry(msgspec.Struct, frozen=True, kw_only=True, forbid_unknown_fields=True):
    """What goes wrong on a link, and when: one of ``at_s``, ``byte`` and ``probability``.

    Attributes:
        link: which link, counted from 0.
        kind: drop, flip, duplicate: bytes are lost, have a bit inverted, come twice; delay: the line idles before a
            byte; noise: random bytes come before a byte; truncate: a byte and all that waits behind it are lost;
            break: the line is held low; disconnect: it is interrupted, both ways; baud: the sender runs at another
            rate.
        towards: the end that receives what is struck; the second of the link's ends if neither this nor ``from`` is
            given.
        from: the end that sends what is struck; another way to say ``towards``.
        at_s: from when on, in seconds of bench time since the case began, or since serving began.
        byte: from which byte of its direction on, counted from 0.
        probability: of striking each byte, above 0 up to 1; decided by the seed of the case.
        count: how many bytes in a row are struck; for noise, how many random bytes come. 1 if not given.
        bit: which bit is inverted, 0 (the lowest, sent first) to 7.
        duration_s: how long it lasts, in seconds.
        baud: rate of the sender, in bit/s.
    """

    kind: Literal["drop", "flip", "duplicate", "delay", "noise", "truncate", "break", "disconnect", "baud"]
    link: Annotated[int, Meta(ge=0)] = 0
    towards: str | UnsetType = UNSET
    from_: str | UnsetType = msgspec.field(default=UNSET, name="from")
    at_s: _Seconds | UnsetType = UNSET
    byte: Annotated[int, Meta(ge=0)] | UnsetType = UNSET
    probability: Annotated[float, Meta(gt=0, le=1)] | UnsetType = UNSET
    count: Annotated[int, Meta(ge=1, le=MOST_BYTES)] | UnsetType = UNSET
    bit: Annotated[int, Meta(ge=0, le=7)] | UnsetType = UNSET
    duration_s: _Span | UnsetType = UNSET
    baud: Annotated[int, Meta(ge=300, le=4_000_000)] | UnsetType = UNSET

    def __post_init__(self) -> None:
        """Refuse what contradicts itself; the message begins with the key it is about."""
        self._check_trigger()
        self._check_direction()
        required = _REQUIRED.get(self.kind, set())
        allowed = required | _OPTIONAL.get(self.kind, set())
        for name in _DETAILS:
            if name in self.given and name not in allowed:
                raise ValueError(f"{name} does not apply to kind '{self.kind}'")
            if name in required and name not in self.given:
                raise ValueError(f"kind '{self.kind}' needs {name}")

    @property
    def given(self) -> Mapping[str, Any]:
        """The triggers and details that were written."""
        values = {name: getattr(self, name) for name in (*_TRIGGERS, *_DETAILS)}
        return {name: value for name, value in values.items() if value is not UNSET}

    def _check_trigger(self) -> None:
        given = [name for name in _TRIGGERS if name in self.given]
        if len(given) > 1:
            raise ValueError(f"{given[1]} cannot go with {given[0]}: a fault has one of {', '.join(_TRIGGERS)}")
        if self.kind in _LINE_KINDS and given != ["at_s"]:
            raise ValueError(f"kind '{self.kind}' is a fault of the line, not of a byte, and needs at_s")
        if not given:
            raise ValueError(f"kind '{self.kind}' needs one of {', '.join(_TRIGGERS)}")

    def _check_direction(self) -> None:
        if self.towards is not UNSET and self.from_ is not UNSET:
            raise ValueError("from cannot go with towards: either says which way")
        if self.kind == "disconnect" and (self.towards is not UNSET or self.from_ is not UNSET):
            name = "towards" if self.towards is not UNSET else "from"
            raise ValueError(f"{name} does not apply to kind 'disconnect', which has no direction")

    def describe(self) -> str:
        """Return the fault in a few words, such as ``flip at_s 3.2 bit 3 towards robot.host``."""
        words = [self.kind, *(f"{name} {value}".removesuffix(".0") for name, value in self.given.items())]
        words += [f"link {self.link}"] if self.link else []
        return " ".join(words if self.kind == "disconnect" else [*words, f"towards {self.towards}"])
