"""The defects of the published firmwares, one by one, and these firmwares without one of them."""

from __future__ import annotations

from collections.abc import Iterator

from measure.mutants.vehicle.mutant import SLOW, VehicleMutant
from protocols.carla.clauses import BOARD_CLAUSES
from targets.robots.vehicle_interface import BEHAVIOURS, DEFECTS

HAZARDS = tuple(clause.id for clause in BOARD_CLAUSES if "hardened" not in clause.profiles and clause.id not in SLOW)
"""Clauses that describe what the published firmwares should not do."""

PUBLISHED = tuple(
    VehicleMutant(
        id=defect.name,
        what=defect.text,
        about=("VB31H", "VB42H", "VB55H") if defect.name == "H9" else (),
        board=defect.board,
        body=defect.body,
    )
    for defect in DEFECTS.values()
)

_SLOW_OF = {"v0-without-H2": ("VB25",), "v0-without-H9": ("VB31", "VB42"), "v0-without-H6": ("VB31",)}


def _cures() -> Iterator[VehicleMutant]:
    """The published firmwares with one thing right: what the clauses of their hazards must notice."""
    hardened = BEHAVIOURS["hardened"].board
    for defect in DEFECTS.values():
        right = {name: getattr(hardened, name) for name in defect.board}
        for profile in ("v0", "v1"):
            shipped = BEHAVIOURS[profile].board
            wrong = {name: value for name, value in defect.board.items() if getattr(shipped, name) == value}
            if wrong == dict(defect.board) and right != wrong and not (profile == "v1" and "own_mode" in wrong):
                what = f"the firmware of {profile} without {defect.name}"
                name = f"{profile}-without-{defect.name}"
                about = (*HAZARDS, *_SLOW_OF.get(name, ()))
                yield VehicleMutant(id=name, what=what, profile=profile, about=about, board=right)
                break
    yield VehicleMutant(
        id="v1-without-V1",
        what="the firmware of v1 without V1",
        profile="v1",
        about=("VB22", "VB23"),
        board={"flag_clash": False},
    )
    yield VehicleMutant(
        id="v1-without-emergency-manual",
        what="the firmware of v1 without emergency-manual",
        profile="v1",
        about=("VB37",),
        board={"emergency_report": hardened.emergency_report},
    )

    yield VehicleMutant(
        id="v0-without-no-watchdog",
        what="the firmware of v0 with a watchdog",
        profile="v0",
        about=("VB56",),
        body={"watchdog_s": BEHAVIOURS["hardened"].body.watchdog_s},
    )


CURES = tuple({mutant.id: mutant for mutant in _cures()}.values())
