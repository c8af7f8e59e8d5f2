"""What a vehicle-interface board reports beside the events of its protocols. Do not subclass."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["LightsSwitched"]


@dataclass(frozen=True, slots=True, kw_only=True)
class LightsSwitched:
    """Another of the three lights is on.

    Attributes:
        lit: ``green`` (LD1) for MANUAL, ``amber`` (LD2) for AUTOWARE, ``red`` (LD3) for EMERGENCY.
    """

    lit: str
