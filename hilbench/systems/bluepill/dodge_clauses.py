"""The catalogue of what a program that finds its way between obstacles must do, beside G13."""

from __future__ import annotations

from hilbench.check.catalogue import Clause

__all__ = ["CLAUSES"]

_THESIS = "bachelor-thesis (Embedded systems simulator for robotics applications, USP 2025), section 5.4"
_CHOICE = "figures: choice"


def _clause(number: int, title: str, text: str, *sources: str) -> Clause:
    return Clause(
        id=f"D{number:02}",
        suite="bluepill-dodge",
        level="must",
        title=title,
        text=text,
        source="; ".join(sources),
        needs=frozenset({"boards", "contacts"}),
    )


CLAUSES = (
    _clause(
        1,
        "It gets about",
        "In 3 minutes between obstacles it drives at least 5 m.",
        f"{_THESIS}: obstacle dodging by a finite state machine",
        _CHOICE,
    ),
    _clause(
        2,
        "Every manoeuvre ends",
        "The states show as motor codes, or as commands: at least one way of turning is entered and left, and no "
        "turning or backing lasts for 60 s.",
        f"{_THESIS}: the states of the machine are seen at the outputs",
        _CHOICE,
    ),
    _clause(
        3,
        "What stands ahead is not driven at",
        "While one of DD3 to DD6 (30 degrees to either side) is high, both motor codes are positive for no longer than "
        "50 ms, whichever of them it is: five passes of a program of 10 ms, and 1 cm of way.",
        f"{_THESIS}: distance sensors",
        "discs 3 to 6: p2os-arduino, table p2dx",
        _CHOICE,
    ),
    _clause(
        4,
        "The program runs on",
        "In all this time the board is not reset, and its program neither ends nor crashes.",
        "choice",
    ),
    _clause(
        5,
        "The same inputs give the same outputs",
        "The edges that came in on distance and encoder pins straight on wheels, given at the same times to a board by "
        "itself, give exactly the same edges on all outputs.",
        f"{_THESIS}: the same program in the simulator and on the robot",
        "to the cycle: choice",
    ),
    _clause(
        6,
        "What stands ahead is not driven at, over P2OS",
        "With something nearer than 0.4 m straight before one of discs 3 to 6, a program that speaks P2OS itself has "
        "the robot drive on for no longer than 0.5 s: a round of the sonars and two packets.",
        "Pioneer 2 Operations Manual: 40 ms for each disc, sonars of the front ring one after the other",
        _CHOICE,
    ),
    _clause(
        7,
        "A reset within a session leaves no robot adrift",
        "The board of a program that speaks P2OS itself is reset while the robot drives towards a wall. Within 3 s the "
        "robot stands or is in a new session, and in 20 s it touches nothing.",
        "Pioneer 2 Operations Manual: SYNC0 and PULSE are the same bytes, so that in a session SYNC0 only feeds the "
        "watchdog",
        _CHOICE,
    ),
)
"""All clauses, in the order of their ids."""
