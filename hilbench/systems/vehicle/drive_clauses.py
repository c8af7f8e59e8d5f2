"""The catalogue of how a car drives through a vehicle-interface board: VD01 to VD11."""

from __future__ import annotations

from hilbench.check.catalogue import Clause
from hilbench.judging.verdicts import Level

__all__ = ["CLAUSES"]

_TASK = "LMA-FEM-UNICAMP/microAutoware src/HIL taksControl.c"
_MICRO_ROS = "LMA-FEM-UNICAMP/microAutoware src/microAutoware microAutoware.c"
_BRIDGE = "LMA-FEM-UNICAMP/carla_serial_bridge carla_serial_bridge_node.cpp"
_CAR = "docs/vehicle-car.md"
_NODE = "carla-simulator/ros-bridge carla_ackermann_control_node.py"
_SIGNS = "signs of ROS (REP 103): choice, LMA-FEM-UNICAMP/Carla-Autoware-Bridge turns two of them round"
_TRACK = "worlds/scenes/track.py: the lane"
_LIMITS = "limits and tolerances: choice"
_HARDENED = "choice: the original sends the last command again"


def _clause(number: int, title: str, text: str, *sources: str, level: Level = "must") -> Clause:
    return Clause(
        id=f"VD{number:02}",
        suite="vehicle-drive",
        level=level,
        title=title,
        text=text,
        source="; ".join(sources),
        needs=frozenset({"CARLA", "board", "stack", "joystick", "lamps", "contacts"}),
    )


CLAUSES = (
    _clause(
        1,
        "A lap in AUTOWARE",
        "A driver that follows the middle line of the test track at up to 10 m/s brings the car once around: it stays "
        "in its lane, touches nothing, and every frame is of mode 1.",
        _TRACK,
        _TASK,
        _LIMITS,
    ),
    _clause(
        2,
        "Reports are true",
        "On that lap each velocity report has the speeds along and across and the turn rate of the car, and each "
        "steering report the angle of its tyres, as they were within 0.1 s before; forwards and left are positive.",
        f"{_TASK}: a status is reported as it comes",
        _BRIDGE,
        _SIGNS,
        _LIMITS,
    ),
    _clause(
        3,
        "A drive by joystick in MANUAL",
        "Half of the stick's way in Y gives half of the car's acceleration; a fifth in X turns the tyres by a fifth of "
        "their largest angle, to the right below the middle, to the left above; Y all the way back stops the car.",
        f"{_TASK}: throttle, brake and steer by the calibration",
        _CAR,
        _LIMITS,
    ),
    _clause(
        4,
        "Hand-over to the joystick without a jump",
        "A press at 8 m/s, the stick at rest: the car rolls on with free pedals. It neither speeds up nor brakes, and "
        "no command on the way has figures of the other mode.",
        _TASK,
        f"{_BRIDGE}: V is a speed in mode 1 and a throttle in mode 4",
        _LIMITS,
    ),
    _clause(
        5,
        "Hand-over to the driving stack without a jump",
        "Asked for while the car rolls, AUTOWARE begins with a command of the driving stack that is not older than a "
        "deadline: the car never brakes harder than the stack wants, and goes on in its lane.",
        _TASK,
        f"{_MICRO_ROS}: control_mode_request",
        _LIMITS,
    ),
    _clause(
        6,
        "A driving stack that falls silent",
        "At 7 m/s no command comes any more: the board commands a stop at the first miss, keeps its tyres as they "
        "were, stands before 1.3 s are over within the way that 8 m/s² need, and the mode is MANUAL then.",
        f"{_TASK}: 10 × 110 ms",
        _HARDENED,
        _CAR,
        _LIMITS,
    ),
    _clause(
        7,
        "A driving stack that comes back",
        "When commands come again, nothing happens until AUTOWARE is asked for; then the car drives on in its lane.",
        f"{_TASK}: MANUAL to AUTOWARE by request or press alone",
    ),
    _clause(
        8,
        "A simulator that falls silent",
        "At 8 m/s no status comes any more: 1.0 s after the last one the mode is EMERGENCY, its light is lit, and the "
        "car stops with all it has.",
        f"{_TASK}: 10 × 100 ms",
        _NODE,
    ),
    _clause(
        9,
        "A simulator that comes back",
        "The first status ends the emergency in MANUAL, within a frame; the car stands until it is driven again, and "
        "drives on in its lane when AUTOWARE is asked for.",
        f"{_TASK}: EMERGENCY to MANUAL",
    ),
    _clause(
        10,
        "Emergency stop from 10 m/s",
        "From the emergency's first frame a car at 10 m/s stands after v²/(2·8 m/s²) = 6.25 m, 0.15 m more or less, "
        "straight ahead, its tyres in the middle.",
        _NODE,
        f"{_CAR}: greatest deceleration",
        _LIMITS,
    ),
    _clause(
        11,
        "Tyres stand as the driving stack asks",
        "On a lap the tyres stand on average where the driving stack asks, 5 % more or less: the board's factor of 1.2 "
        "is what CARLA's ackermann node takes away, which divides by the largest angle of one wheel.",
        "LMA-FEM-UNICAMP/microAutoware taksControl.c: times 1.2",
        _NODE,
        _LIMITS,
    ),
)
"""All clauses of the suite ``vehicle-drive``."""
