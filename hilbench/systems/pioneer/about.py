"""What the header of a journal says of a Pioneer for those who show it; see `hilbench.bench.about`."""

from __future__ import annotations

from typing import Any

__all__ = ["about_sonars"]


def about_sonars(subclass: str) -> dict[str, Any]:
    """Return where the discs sit, what a raw range means, and from which on nothing was heard."""
    from hilbench.systems.pioneer.robot import sonar_poses
    from protocols.p2os import robot_parameters
    from protocols.p2os.units import NO_ECHO_RAW

    poses = [[round(x_m, 4), round(y_m, 4), round(th_rad, 4)] for x_m, y_m, th_rad in sonar_poses(subclass)]
    unit_mm = robot_parameters(subclass).range_unit_mm
    return {"sonars": poses, "sonar_unit_mm": unit_mm, "sonar_no_echo": NO_ECHO_RAW}
