"""How a vehicle-interface board behaves, profile by profile: both its links, and what is beside them.

Sources: V0, toffanetto/im420x project/ws/nucleo-H753ZI_TemplateAutoware_Serial; V1, LMA-FEM-UNICAMP/microAutoware; DOC,
the report of toffanetto/im420x.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

from protocols import autoware
from protocols.carla import PROFILES, BoardOptions

__all__ = ["BEHAVIOURS", "Behaviour", "BodyQuirks"]


@dataclass(frozen=True, slots=True, kw_only=True)
class BodyQuirks:
    """What is not of the links.

    Attributes:
        boot_s: how long after power-on nothing happens (assumed: clocks, peripherals, scheduler).
        lamps: turn indicators and hazard lights are served (choice; DOC requires them, V0 and V1 have comments only).
        blink_hz: how often lamps go on (choice: 1.5 Hz, the middle of UN Regulation 6, 60 to 120 a minute).
        axes_swapped: the joystick's X is read as Y (the schematic of DOC).
        watchdog_s: how long after the last of its life it is reset (choice); None for never (V0, V1).
        padded: the NUL behind each frame is sent (V0, V1: sizeof of the C string).
    """

    boot_s: float = 0.0
    lamps: bool = True
    blink_hz: float = 1.5
    axes_swapped: bool = False
    watchdog_s: float | None = 0.5
    padded: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Behaviour:
    """All that a board promises or gets wrong.

    Attributes:
        board: its end of the simulator's line, and its modes.
        body: the rest.
    """

    board: BoardOptions
    body: BodyQuirks = field(default_factory=BodyQuirks)

    @property
    def stack(self) -> autoware.BoardOptions:
        """Its end of the driving stack's line."""
        return autoware.BoardOptions(ping_s=1.0, pings=round(self.board.agent_wait_s), reconnects=self.board.late_agent)


_SHIPPED = BodyQuirks(lamps=False, watchdog_s=None)
_BODIES = {"v0": _SHIPPED, "v1": _SHIPPED}

BEHAVIOURS: Mapping[str, Behaviour] = MappingProxyType(
    {name: Behaviour(board=profile.board, body=_BODIES.get(name, BodyQuirks())) for name, profile in PROFILES.items()}
)
"""The behaviour of each profile."""
