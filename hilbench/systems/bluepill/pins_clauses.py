"""The catalogue of what a robot with a Blue Pill on its connector must do: G01 to G25.

The experiments of the bachelor's thesis, with figures; what the thesis left open and its programs answer, from their
text. Where the published adapter and a sound design differ, the clause names both, and each has a case of its own.
"""

from __future__ import annotations

from hilbench.check.catalogue import Clause
from hilbench.judging.verdicts import Level

__all__ = ["CLAUSES"]

_THESIS = "bachelor-thesis (Embedded systems simulator for robotics applications, USP 2025)"
_RESULTS = f"{_THESIS}, section 5.4"
_TABLE = f"{_THESIS}, Table 3 and Fig. 22"
_QEMU = "qemu-gazebo-sim/stm32-qemu vl.c"
_PINS = "qemu-gazebo-sim/pioneer_2DX-Interface code-esp32_d1 bluepill_comm.cpp"
_TASKS = "qemu-gazebo-sim/pioneer_2DX-Interface code-esp32_d1 task_controller.cpp"
_LIBRARY = "qemu-gazebo-sim/p2os-arduino p2os_comm.cpp, p2os_config.hpp"
_SCHEMATIC = "qemu-gazebo-sim/bachelor-thesis, schematic of the adapter board"
_TOLERANCE = "tolerance: choice"


def _clause(number: int, title: str, text: str, *sources: str, level: Level = "must", suite: str = "pins") -> Clause:
    return Clause(
        id=f"G{number:02}",
        suite=f"bluepill-{suite}",
        level=level,
        title=title,
        text=text,
        source="; ".join(sources),
        needs=frozenset({"boards"}),
    )


CLAUSES = (
    _clause(
        1,
        "Motor words",
        "Codes 0, 3, -4 and 0 on both motors stand on their wires as words 0, 3, 4 and 0, comm3 first; on PB5 to PB7 "
        "they are mirrored. What reads the wires takes them for exactly these codes.",
        _RESULTS,
        _TABLE,
        _QEMU,
    ),
    _clause(
        2,
        "Codes are speeds",
        "Code 3 on both motors drives at 187 mm/s forward and -4 at 250 mm/s backward, 5 % more or less; code 0 stops "
        "within 1 s. The heading drifts by less than 3 degrees in each leg on a flat floor.",
        _RESULTS,
        _PINS,
        _TOLERANCE,
    ),
    _clause(
        3,
        "A step is a step",
        "From 3 to -4 the command goes in one step; nothing in between is commanded.",
        f"{_RESULTS}: the robot moves in jerks",
        _PINS,
    ),
    _clause(
        4,
        "All 64 pairs of codes",
        "Each pair gives the speed and the rate of turn of the published arithmetic, and the robot gets the "
        "same in whole mm/s and deg/s; straight on wheels each code is 62.5 mm/s at the rim.",
        _PINS,
        _LIBRARY,
        _TOLERANCE,
    ),
    _clause(
        5,
        "Each distance sensor by itself",
        "With an obstacle before sensor i alone, DDi alone is high, and low again when the obstacle is gone. On the "
        "published adapter DD1 stays low and DD7 and DD8 are not driven.",
        _RESULTS,
        _TABLE,
        _PINS,
    ),
    _clause(
        6,
        "All distance sensors at once",
        "With obstacles on all sides all bits are high within one period of the sensors and 1 ms.",
        _RESULTS,
        _TOLERANCE,
    ),
    _clause(
        7,
        "The threshold",
        "The simulated sensor is high nearer than its threshold and low at it; the adapter is high at its threshold of "
        "1.0 m and low beyond.",
        f"{_THESIS}, listing of the distance sensor plug-in",
        _PINS,
    ),
    _clause(
        8,
        "Reaction",
        "A program that drives while a sensor is high changes its motor wires within its loop of 10 ms, and the robot "
        "its motion within 100 ms more.",
        _RESULTS,
        f"{_QEMU}: publishers every 100 ms",
        _TOLERANCE,
    ),
    _clause(
        9,
        "Encoders, forward",
        "In a turn of the wheel forward the numbers 0 to 7 come once each, rising, each 45 degrees wide within 1 "
        "degree; the program reads the same numbers.",
        _RESULTS,
        f"{_THESIS}, listing of the encoder plug-in",
        _TOLERANCE,
    ),
    _clause(
        10,
        "Encoders, backward",
        "In a turn backward the numbers fall from 7 to 0. In the form of the original plug-in, which cuts toward zero, "
        "0 is 90 degrees wide and 7 to 1 follow.",
        f"{_THESIS}, listing of the encoder plug-in",
        _QEMU,
        _TOLERANCE,
    ),
    _clause(
        11,
        "Pins of the encoders",
        "Number 5 of the left encoder is PB4 high, PB3 low, PA15 high; the program has to free these pins from the "
        "debug port to read it.",
        _SCHEMATIC,
        _TABLE,
    ),
    _clause(
        12,
        "Order of the encoder's bits",
        "Number 1 is s1 alone and 4 is s3 alone; on the published adapter it is the other way round.",
        f"{_THESIS}, Fig. 22",
        _PINS,
    ),
    _clause(
        13,
        "Obstacles are dodged",
        "A program that finds its way by the sensors drives 3 minutes between obstacles without touching one.",
        _RESULTS,
        _TOLERANCE,
        suite="dodge",
    ),
    _clause(
        14,
        "One program, two robots",
        "The same image gives the same order of edges at the connector straight on wheels and over the adapter.",
        _RESULTS,
    ),
    _clause(
        15,
        "The connection line",
        "p2dx_con high for 5 ms is ignored, for 50 ms it connects and the echo goes high; before 1 s of uptime it is "
        "ignored.",
        _PINS,
        _TASKS,
    ),
    _clause(
        16,
        "Majority of five reads",
        "A motor wire that is high in two of five reads counts as low, in three of them as high.",
        _PINS,
    ),
    _clause(
        17,
        "A program that has stopped",
        "The published adapter drives on at the last codes for ever; one with a timeout stops after it.",
        _PINS,
        "the time and what stops it: choice",
    ),
    _clause(
        18,
        "The robot is kept alive",
        "While connected with codes 0, PULSE goes to the robot every 0.5 s and ENABLE every 0.1 s, and the session "
        "stays open.",
        _LIBRARY,
        _TASKS,
        _TOLERANCE,
    ),
    _clause(
        19,
        "The game pad",
        "A whole right trigger is 500 mm/s forward on the published adapter, 400 in the thesis, without any turn.",
        _TASKS,
        f"{_THESIS}, Fig. 23",
    ),
    _clause(
        20,
        "Turning on the spot",
        "Codes -1 and 1 turn at 42 mrad/s on the published adapter, sent to the robot as 2 deg/s; straight on "
        "wheels, or with an adapter that computes as wheels turn, at 350 mrad/s.",
        _PINS,
        "AriaCoda params/p2dx.p: DiffConvFactor",
        _TOLERANCE,
    ),
    _clause(
        21,
        "A ramp",
        "Up a ramp of 8 degrees at code 3 and down at -4 the speed is within 20 % of that on the flat, and the robot "
        "stays on its wheels.",
        f"{_THESIS}: the ramp of the simulated building",
        "slope and tolerance: choice",
    ),
    _clause(
        22,
        "The reset line",
        "PB13 high for 10 ms restarts the adapter, which opens its session again and drives on; the Blue Pill runs on.",
        _SCHEMATIC,
        _TASKS,
    ),
    _clause(
        23,
        "Nothing attached",
        "Without sensors and encoders their pins read 0, and the motor words go out all the same.",
        _QEMU,
        "pull-downs of the program: choice",
    ),
    _clause(
        24,
        "Period of publication",
        "In 10 s each motor's word is published 100 times, once more or less.",
        f"{_QEMU}: publishers every 100 ms",
    ),
    _clause(
        25,
        "Wires that were left inputs",
        "Where a program writes its output latch but has left the pins inputs, the original publishes the code, and a "
        "motor that is really connected sees 0.",
        f"{_QEMU}: ODR is read whatever the direction",
    ),
)
"""All clauses, in the order of their ids."""
