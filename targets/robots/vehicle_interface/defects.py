"""The defects of the published firmwares, each by itself, to be put back into a board that does what was promised.

Those of the protocol are its quirks (protocols/carla/profiles.py): H1, H2, H6 to H9, V1 and more. The names are those
of the options of our own firmware (targets/firmware/vehicle_interface/defects.h), as far as it has them. Sources: V0 is
toffanetto/im420x, project/ws/nucleo-H753ZI_TemplateAutoware_Serial; V1 is LMA-FEM-UNICAMP/microAutoware; DOC is the
report on V0 in the first of these.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

from protocols.carla import QUIRKS
from targets.robots.vehicle_interface.behaviour import Behaviour

__all__ = ["DEFECTS", "Defect"]


@dataclass(frozen=True, slots=True, kw_only=True)
class Defect:
    """One thing that is wrong.

    Attributes:
        name: as in settings.
        text: what it does.
        source: where it is published.
        board: what changes in `BoardOptions`.
        body: the same in `BodyQuirks`.
    """

    name: str
    text: str
    source: str
    board: Mapping[str, object] = field(default_factory=dict)
    body: Mapping[str, object] = field(default_factory=dict)

    def put_into(self, behaviour: Behaviour) -> Behaviour:
        """The behaviour with this defect."""
        return Behaviour(
            board=replace(behaviour.board, **self.board),  # type: ignore[arg-type]
            body=replace(behaviour.body, **self.body),  # type: ignore[arg-type]
        )


_OURS = (
    Defect(
        name="one-miss",
        text="a single miss of the first deadlines changes the mode: 30 ms for a command",
        source="DOC, table of tasks; V0 until 4 November 2024",
        board={"command_deadline_s": 0.030, "misses": 1},
    ),
    Defect(
        name="no-factor",
        text="the steering is handed on without its factor of 1.2",
        source="V0 before the factor was moved from the simulator's side into the firmware",
        board={"steering_factor": 1.0},
    ),
    Defect(
        name="axes-swapped",
        text="the joystick's axes are exchanged",
        source="DOC, schematic: X on PF11, Y on PF12",
        body={"axes_swapped": True},
    ),
    Defect(
        name="no-lamps",
        text="turn indicators and hazard lights are not served",
        source="V0 and V1 microAutoware.c: commented out; DOC asks for them",
        body={"lamps": False},
    ),
    Defect(
        name="no-watchdog",
        text="no watchdog: a program that hangs leaves the simulator with the last command",
        source="V0 and V1 main.c",
        body={"watchdog_s": None},
    ),
    Defect(
        name="no-padding",
        text="the NUL behind each frame is missing",
        source="DOC and the READMEs, where the pattern of 29 bytes is said to have 30",
        body={"padded": False},
    ),
)

DEFECTS: Mapping[str, Defect] = MappingProxyType(
    {
        **{
            quirk.name: Defect(name=quirk.name, text=quirk.text, source=quirk.source, board=quirk.board)
            for quirk in QUIRKS.values()
            if quirk.board
        },
        **{defect.name: defect for defect in _OURS},
    }
)
"""All defects by name."""
