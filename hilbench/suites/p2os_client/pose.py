"""What the client makes of it: a pose that does not jump."""

from __future__ import annotations

import dataclasses
import math
from itertools import pairwise

import pytest

from hilbench.check import case, near
from hilbench.suites._client import ClientBench, connect, own_client, understood
from hilbench.systems.pioneer.scripted_packets import IDENTIFICATION, STANDING
from protocols.p2os import Sip, encode_packet, robot_parameters

_WRAPS: dict[str, tuple[str, list[int]]] = {
    "x at 32768": ("x_raw", [32766, 32767, 0, 1]),
    "x at 65536": ("x_raw", [65534, 65535, 0, 1]),
    "y at 32768": ("y_raw", [32766, 32767, 0, 1]),
    "heading": ("th_raw", [2046, 2047, -2048, -2047]),
}


@case("C21", bench_time_s=1.9)
@pytest.mark.parametrize("counter", list(_WRAPS))
@pytest.mark.parametrize("way", ["up", "down"])
def test_the_pose_does_not_jump(bench: ClientBench, counter: str, way: str) -> None:
    connect(bench)
    field, values = _WRAPS[counter]
    ordered = values if way == "up" else values[::-1]
    poses = [_pose_units(bench, _sip_with(field, value)) for value in ordered]
    steps = [math.dist(before, after) for before, after in pairwise(poses)]
    worst = max(steps, key=lambda step: abs(step - 1))
    near(worst, 1, 0.05, unit="units", what=f"step of the pose where {counter} wraps")


def _sip_with(field: str, value: int) -> Sip:
    match field:
        case "x_raw":
            return dataclasses.replace(STANDING, x_raw=value)
        case "y_raw":
            return dataclasses.replace(STANDING, y_raw=value)
        case _:
            return dataclasses.replace(STANDING, th_raw=value)


def _pose_units(bench: ClientBench, sip: Sip) -> tuple[float, float, float]:
    """Let the client see counters, and return the pose it makes of them in their units."""
    understood(bench, encode_packet(sip))
    tracker = own_client(bench).pose
    assert tracker is not None, "the client has no pose"
    pose, unit_mm = tracker.pose, robot_parameters(IDENTIFICATION.subclass).distance_unit_mm
    return pose.x_mm / unit_mm, pose.y_mm / unit_mm, pose.heading_rad * 4096 / math.tau
